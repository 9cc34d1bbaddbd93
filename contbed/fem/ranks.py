"""One rank leads, the others follow: the program runs on the first, and what is distributed runs on all.

The leader runs a scene as it would alone. Where work is distributed it says so with `Crew.together(function, ...)`: all
ranks then run that function, which is one of a module and known everywhere by its name. Between calls the others sleep.
No rank has to guess what another decides, so none waits for a message that never comes. An error that the leader meets
by itself ends all ranks with its exit code; one inside a distributed function aborts all of them with a message.

The leader holds vectors in the numbering of the mesh as built, so results, checkpoints and restarts do not depend on
the number of ranks. Matrices, their factors and preconditioners exist in pieces only.
"""

from __future__ import annotations

import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from contbed.errors import ContbedError
from contbed.fem import dolfinx_versions

NAP = 2e-4  # [s] between looks for work
FAILED = 70  # exit code of an abort


class Crew:
    """The ranks of a communicator and what they hold, by number: `things` of this rank."""

    def __init__(self, comm: Any):
        self.comm, self.leads = comm, comm.rank == 0
        self.things: dict[int, Any] = {}
        self.dropped: list[int] = []
        self.partition: Any = None
        self.iterations: list[int] = []
        self.count = 0

    def new(self) -> int:
        """A number for a thing that all ranks will hold."""
        self.count += 1
        return self.count

    def together(self, function: Callable[..., Any], *arguments: Any, root: Any = None) -> Any:
        """Run `function(crew, root, *arguments)` on all ranks, called by the leader; `root` stays with the leader."""
        with _uninterrupted():
            dropped = self.dropped[:]
            del self.dropped[: len(dropped)]
            if self.comm.size > 1:
                self._wake()
                self.comm.bcast((function, arguments, dropped))
            self._drop(dropped)
            return self._do(function, root, arguments)

    def follow(self) -> tuple[int, str]:
        """Do what the leader says until it ends; its exit code and last words."""
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        while True:
            self._wake()
            function, arguments, dropped = self.comm.bcast(None)
            self._drop(dropped)
            if function is None:
                return arguments
            self._do(function, None, arguments)

    def dismiss(self, code: int, words: str) -> None:
        """End the others."""
        if self.comm.size > 1:
            self._wake()
            self.comm.bcast((None, (code, words), []))

    def _drop(self, keys: list[int]) -> None:
        for key in keys:
            thing = self.things.pop(key, None)
            getattr(thing, "destroy", lambda: None)()

    def _wake(self) -> None:
        """Meet the others here, without keeping a processor busy meanwhile."""
        request = self.comm.Ibarrier()
        while not request.Test():
            time.sleep(NAP)

    def _do(self, function: Callable[..., Any], root: Any, arguments: tuple[Any, ...]) -> Any:
        try:
            return function(self, root, *arguments)
        except BaseException as error:
            if self.comm.size == 1:
                raise
            self.abort(error)

    def abort(self, error: BaseException) -> None:
        """Say what went wrong on this rank and end all of them."""
        if not isinstance(error, ContbedError | MemoryError):
            traceback.print_exception(error)
        kind = "" if isinstance(error, ContbedError) else f"{type(error).__name__}: "
        print(
            f"contbed: rank {self.comm.rank} of {self.comm.size} failed ({kind}{error}); all ranks end",
            file=sys.stderr,
            flush=True,
        )
        self.comm.Abort(error.exit_code if isinstance(error, ContbedError) else FAILED)

    def scatter(self, values: Any, counts: Any, width: int, dtype: Any) -> Any:
        """The leader's rows (sum of counts, width), given to the ranks in turn; `counts` is known to the leader."""
        mine = np.empty((self.comm.scatter(counts), width), dtype=dtype)
        shares = None if counts is None else [np.ascontiguousarray(values, dtype), np.asarray(counts) * width]
        self.comm.Scatterv(shares, mine)
        return mine

    def gather(self, mine: Any, counts: Any) -> Any:
        """All ranks' entries in turn, at the leader; None elsewhere."""
        if not self.leads:
            self.comm.Gatherv(np.ascontiguousarray(mine), None)
            return None
        out = np.empty(int(np.sum(counts)), dtype=mine.dtype)
        self.comm.Gatherv(np.ascontiguousarray(mine), [out, np.asarray(counts)])
        return out


_crew: Crew | None = None


def crew() -> Crew:
    """All ranks that mpirun started; the same each time."""
    global _crew
    if _crew is None:
        dolfinx_versions.modules()
        from mpi4py import MPI

        _crew = Crew(MPI.COMM_WORLD)
    return _crew


def lead(main: Callable[[], Any]) -> Any:
    """Run `main` on the first rank with the others at its service; they return None or raise what ended the leader."""
    all_ranks = crew()
    all_ranks.iterations = []
    if not all_ranks.leads:
        code, words = all_ranks.follow()
        if code:
            raise FollowerError(words, code)
        return None
    try:
        result = main()
    except BaseException as error:
        code = 130 if isinstance(error, KeyboardInterrupt) else getattr(error, "exit_code", 1)
        all_ranks.dismiss(code, str(error) or type(error).__name__)
        raise
    all_ranks.dismiss(0, "")
    return result


class FollowerError(ContbedError):
    """What ended the leader, on the other ranks; `exit_code` is that of the leader's error."""

    def __init__(self, message: str, exit_code: int):
        super().__init__(message)
        self.exit_code = exit_code


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Hold an interrupt back until all ranks have finished what they do together."""
    try:
        before = signal.getsignal(signal.SIGINT)
        seen: list[Any] = []
        signal.signal(signal.SIGINT, lambda *arguments: seen.append(arguments))
    except ValueError:  # only the main thread may
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if seen and callable(before):
        before(*seen[0])
