"""Errors, each with its exit code. A message says what went wrong, where, the
numbers, and what to try.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any


class ContbedError(Exception):
    """Base of all errors that a user can meet; `exit_code` is what the command line
    returns.
    """

    exit_code = 1


class SceneError(ContbedError):
    """The scene, its mesh or its materials cannot be used; `problems` holds one line
    for each mistake, none twice.
    """

    exit_code = 2

    def __init__(self, problems: str | Iterable[str]):
        texts = [problems] if isinstance(problems, str) else problems
        self.problems = list(dict.fromkeys(texts))
        super().__init__("\n".join(self.problems))


class ConvergenceError(ContbedError):
    """Newton, a time step or a linear solve failed; `history` of residual norms,
    `state` the last state.
    """

    exit_code = 3

    def __init__(
        self, message: str, history: list[float] | None = None, state: Any = None
    ):
        self.history = history or []
        self.state = state
        super().__init__(message)


class ClosureRangeError(ContbedError):
    """A closure left its declared range in strict mode."""

    exit_code = 4


class BalanceError(ContbedError):
    """A conserved quantity does not close to the tolerance that the scene asks for."""

    exit_code = 5


class EngineError(ContbedError):
    """The engine is missing, cannot solve the scene, or lost one of its processes."""

    exit_code = 2


class UnlikeError(ContbedError):
    """A changed value gives a problem with other unknowns or conditions, so that it
    is no small change.
    """

    exit_code = 2


def interrupt_in(error: BaseException) -> KeyboardInterrupt | None:
    """Return the interrupt that an error comes from; compiled code turns Ctrl-C into
    errors of other kinds.
    """
    found: BaseException | None = error
    while found is not None:
        if isinstance(found, KeyboardInterrupt):
            return found
        found = found.__cause__ or found.__context__
    return None
