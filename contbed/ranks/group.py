"""Control of MPI ranks: the program runs on rank 0, distributed functions run on all
ranks.

Rank 0 runs a scene as it would without MPI. For distributed work it calls
`RankGroup.run_on_all(function, ...)`: all ranks then run that function, which belongs
to a module and is known to all ranks by its name. Between calls the other ranks wait in
`RankGroup.serve`. No rank has to guess what another one decides, so none waits for a
message that never comes. An error that rank 0 meets outside a distributed function ends
all ranks with its exit code; an error inside a distributed function aborts all ranks
with a message.

Rank 0 holds vectors in the numbering of the mesh as built, so results, checkpoints and
restarts do not depend on the number of ranks. Matrices, their factors and
preconditioners are distributed only.
"""

from __future__ import annotations

import signal
import sys
import time
import traceback
from collections.abc import Callable
from typing import Any

import numpy as np

from contbed.compiled.interrupts import deferred_interrupt
from contbed.errors import ContbedError
from contbed.ranks import dolfinx

POLL_INTERVAL = 2e-4  # [s] between looks for work
ABORT_EXIT_CODE = 70  # exit code of an abort


class RankGroup:
    """The ranks of a communicator.

    `objects` are the distributed objects (meshes, spaces, forms, matrices, solvers)
    that this rank holds, by number. Keys in `released` are deleted on all ranks at the
    next call of `run_on_all`.
    """

    def __init__(self, comm: Any):
        self.comm, self.is_root = comm, comm.rank == 0
        self.objects: dict[int, Any] = {}
        self.released: list[int] = []
        self.partition: Any = None  # the last `system.Partition`
        self.iterations: list[int] = []
        self.count = 0
        self.served = False  # whether the other ranks wait for what rank 0 asks for

    @property
    def alone(self) -> bool:
        """Whether rank 0 can compute now: it is the only one, or the others serve
        it.
        """
        return self.comm.size == 1 or self.served

    def new_key(self) -> int:
        """Return a new number for an object that all ranks will hold."""
        self.count += 1
        return self.count

    def run_on_all(
        self, function: Callable[..., Any], *arguments: Any, root: Any = None
    ) -> Any:
        """Run `function(ranks, root, *arguments)` on all ranks; only rank 0 calls
        this and has `root`.
        """
        with deferred_interrupt():
            released = self.released[:]
            del self.released[: len(released)]
            if self.comm.size > 1:
                self._wake()
                self.comm.bcast((function, arguments, released))
            self._release(released)
            return self._do(function, root, arguments)

    def serve(self) -> tuple[int, str]:
        """Run the functions that rank 0 asks for until it ends; return its exit code
        and last message.
        """
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        while True:
            self._wake()
            function, arguments, released = self.comm.bcast(None)
            self._release(released)
            if function is None:
                code, words = arguments
                return code, words
            self._do(function, None, arguments)

    def end_others(self, code: int, words: str) -> None:
        """End the other ranks with an exit code and a message."""
        if self.comm.size > 1:
            self._wake()
            self.comm.bcast((None, (code, words), []))

    def _release(self, keys: list[int]) -> None:
        for key in keys:
            stored = self.objects.pop(key, None)
            getattr(stored, "destroy", lambda: None)()

    def _wake(self) -> None:
        """Meet the other ranks at a barrier; sleep between checks so that no
        processor is kept busy.
        """
        request = self.comm.Ibarrier()
        while not request.Test():
            time.sleep(POLL_INTERVAL)

    def _do(
        self, function: Callable[..., Any], root: Any, arguments: tuple[Any, ...]
    ) -> Any:
        try:
            return function(self, root, *arguments)
        except BaseException as error:
            if self.comm.size == 1:
                raise
            self.abort(error)

    def abort(self, error: BaseException) -> None:
        """Print what went wrong on this rank and end all ranks."""
        if not isinstance(error, ContbedError | MemoryError):
            traceback.print_exception(error)
        kind = "" if isinstance(error, ContbedError) else f"{type(error).__name__}: "
        print(
            f"contbed: rank {self.comm.rank} of {self.comm.size} failed "
            f"({kind}{error}); all ranks end",
            file=sys.stderr,
            flush=True,
        )
        self.comm.Abort(
            error.exit_code if isinstance(error, ContbedError) else ABORT_EXIT_CODE
        )

    def scatter(self, values: Any, counts: Any, width: int, dtype: Any) -> Any:
        """Distribute rows (sum of counts, width) of rank 0; only rank 0 knows
        `values` and `counts`.
        """
        mine = np.empty((self.comm.scatter(counts), width), dtype=dtype)
        shares = (
            None
            if counts is None
            else [np.ascontiguousarray(values, dtype), np.asarray(counts) * width]
        )
        self.comm.Scatterv(shares, mine)
        return mine

    def spread(self, values: Any, width: int, dtype: Any) -> Any:
        """Distribute rows (n, width) of rank 0 in equal ranges; only rank 0 knows
        `values`.
        """
        return self.scatter(
            values,
            None if values is None else np.diff(self._ends(len(values))),
            width,
            dtype,
        )

    def _ends(self, size: int) -> Any:
        return np.linspace(0, size, self.comm.size + 1).astype(int)

    def gather(self, mine: Any, counts: Any) -> Any:
        """Return the entries of all ranks in rank order on rank 0; None elsewhere."""
        if not self.is_root:
            self.comm.Gatherv(np.ascontiguousarray(mine), None)
            return None
        out = np.empty(int(np.sum(counts)), dtype=mine.dtype)
        self.comm.Gatherv(np.ascontiguousarray(mine), [out, np.asarray(counts)])
        return out

    def take(self, whole: Any, places: Any) -> Any:
        """Return rows (n, ...) at `places` (n,) of an array that only rank 0 has."""
        counts, everywhere = self.comm.gather(len(places)), None
        asked = self.gather(places, counts)
        shape = self.comm.bcast(None if whole is None else whole.shape[1:])
        if whole is not None:
            everywhere = whole[asked].reshape(len(asked), -1)
        return self.scatter(everywhere, counts, int(np.prod(shape)), float).reshape(
            -1, *shape
        )

    def put(self, mine: Any, places: Any) -> Any:
        """Return on rank 0 an array whose rows (n, ...) at `places` (n,) each rank
        has; None elsewhere.
        """
        counts = self.comm.gather(len(places))
        there = self.gather(places, counts)
        width = int(np.prod(mine.shape[1:]))
        rows = self.gather(mine.ravel(), counts and [width * count for count in counts])
        if there is None:
            return None
        whole = np.empty((len(there), *mine.shape[1:]))
        whole[there] = rows.reshape(whole.shape)
        return whole


_group: RankGroup | None = None


def rank_group() -> RankGroup:
    """Return the group of all ranks that mpirun started; there is one for each
    process.
    """
    global _group
    if _group is None:
        dolfinx.modules()
        from mpi4py import MPI

        _group = RankGroup(MPI.COMM_WORLD)
    return _group


def run_on_root(main: Callable[[], Any]) -> Any:
    """Run `main` on rank 0 while the others serve it; they return None, or raise what
    ended rank 0.

    Within `main` of another call, as of the runs of a derivative, the others serve
    already.
    """
    all_ranks = rank_group()
    all_ranks.iterations = []
    if all_ranks.served:
        return main()
    if not all_ranks.is_root:
        code, words = all_ranks.serve()
        if code:
            raise RootRankError(words, code)
        return None
    all_ranks.served = True
    try:
        result = main()
    except BaseException as error:
        code = (
            130
            if isinstance(error, KeyboardInterrupt)
            else getattr(error, "exit_code", 1)
        )
        all_ranks.end_others(code, str(error) or type(error).__name__)
        raise
    finally:
        all_ranks.served = False
    all_ranks.end_others(0, "")
    return result


class RootRankError(ContbedError):
    """The error that ended rank 0, as raised on the other ranks with the same
    `exit_code`.
    """

    def __init__(self, message: str, exit_code: int):
        super().__init__(message)
        self.exit_code = exit_code
