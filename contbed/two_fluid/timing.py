"""Wall time of the phases of a step, by their names."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from time import perf_counter
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


class Timer:
    """Seconds of wall time by phase; a phase does not include the phases that it
    calls.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._nested = 0.0

    def run(self, phase: str, work: Callable[[], T]) -> T:
        """Do some work and add its time to a phase."""
        outer, self._nested, start = self._nested, 0.0, perf_counter()
        try:
            return work()
        finally:
            spent = perf_counter() - start
            self.seconds[phase] = self.seconds.get(phase, 0.0) + spent - self._nested
            self._nested = outer + spent


def timed(name: str) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Add the wall time of a function to a phase of the step, by the timer of the
    `Model`, its last argument.
    """

    def decorated(function: Callable[P, T]) -> Callable[P, T]:
        @wraps(function)
        def call(*arguments: P.args, **named_arguments: P.kwargs) -> T:
            model: Any = arguments[-1]
            timer: Timer = model.timer
            return timer.run(name, lambda: function(*arguments, **named_arguments))

        return call

    return decorated
