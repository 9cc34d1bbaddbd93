"""Compiled loops on several cores of one machine.

A kernel is compiled with `nogil=True` and takes a range: `kernel(begin, end,
*arguments)` computes the elements from begin to before end. `parallel` calls it for
equal parts of the range, one for each thread; a kernel whose elements do not depend on
each other gives the same bits for any number of threads. Sums need an order that does
not depend on the number of threads: `scattered` calls the kernel for parts of a fixed
length, each with an array of its own to which it adds, and sums these in the order of
parts.

    @njit(nogil=True, cache=True)
    def squares(begin, end, x, out):
        for k in range(begin, end):
            out[k] = x[k] ** 2

    with threads.using(2):
        threads.parallel(squares, len(x), x, out)

The calling thread takes the first part; the others wait for work in threads that are
started once. A kernel is compiled once, whatever the number of threads, and no library
for threads is needed.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from queue import SimpleQueue
from typing import Any

import numpy as np

from contbed.compiled.interrupts import deferred_interrupt
from contbed.errors import SceneError

# the least of those set bounds the default
VARIABLES = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS")
SCATTERED = 8  # most parts of `scattered`, each with an array of its own
# parts of `parallel` begin at multiples of it, so that two threads seldom write to one
# cache line
ALIGNED = 64
# elements that a thread must have by default; below, handing over costs more than it
# saves
LEAST = 4096

# of the calling thread: those that start runs at the same time do not change each
# other's
_limit: ContextVar[int | None] = ContextVar("_limit", default=None)
_in_use = threading.Lock()  # held while the workers compute for one caller
_workers: list[_Worker] = []


def available() -> int:
    """Count the cores that this process may use, at most what the variables
    VARIABLES say.
    """
    cores = (
        len(os.sched_getaffinity(0))
        if hasattr(os, "sched_getaffinity")
        else os.cpu_count() or 1
    )
    values = (os.environ.get(name, "") for name in VARIABLES)
    return max(1, min([cores, *(int(value) for value in values if value.isdigit())]))


def count(elements: int | None = None, least: int = LEAST) -> int:
    """Return how many threads to compute on: at most those that are allowed, each
    with `least` of the `elements`.
    """
    if elements is not None and elements < 2 * least:
        return 1  # without a look at the environment, which takes 5 us
    allowed = _limit.get() or available()
    return allowed if elements is None else min(allowed, elements // least)


def given() -> int | None:
    """Return the number that a block of `using` allows, as `--threads` does; None
    where nothing was said.
    """
    return _limit.get()


@contextmanager
def using(number: int | None) -> Iterator[None]:
    """Allow a number of threads in a block; None leaves what is allowed.

    Raises
    ------
    SceneError : the number is below 1
    """
    if number is not None and number < 1:
        raise SceneError(f"threads: {number} given; at least 1 is needed")
    before = _limit.set(number or _limit.get())
    try:
        yield
    finally:
        _limit.reset(before)


def parallel(
    kernel: Callable[..., Any], n: int, *arguments: Any, least: int = LEAST
) -> list[Any]:
    """Call `kernel(begin, end, *arguments)` for parts of the range 0 to n, one for each
    thread.

    Parameters
    ----------
    kernel : compiled with nogil=True; writes only what belongs to its range
    n : number of elements; below 2 `least` the calling thread takes all of them
    arguments : passed on to the kernel
    least : elements that a thread must have

    Returns
    -------
    what the calls return, by part

    Raises
    ------
    KeyboardInterrupt : SIGINT arrived; all parts are complete
    """
    number = count(n, least)
    if number == 1:
        return [kernel(0, n, *arguments)]
    bounds = [ALIGNED * (n * k // (number * ALIGNED)) for k in range(number)] + [n]
    calls = [(kernel, (bounds[k], bounds[k + 1], *arguments)) for k in range(number)]
    return together(calls)


def scattered(
    kernel: Callable[..., Any],
    n: int,
    shape: tuple[int, ...],
    *arguments: Any,
    least: int = LEAST,
) -> Any:
    """Add arrays to which `kernel(begin, end, *arguments, out)` adds for parts of the
    range, in the order of the parts.

    Parameters
    ----------
    kernel : compiled with nogil=True; adds to any place of `out`
    n : number of elements
    shape : of `out`, which is zero at the start of a part
    arguments : passed on to the kernel
    least : elements of a part; their number depends on it and `n`, not on the number of
        threads

    Returns
    -------
    the sum of all parts

    Raises
    ------
    KeyboardInterrupt : SIGINT arrived
    """
    parts = max(1, min(SCATTERED, n // least))
    out, bounds = np.zeros((parts, *shape)), [n * k // parts for k in range(parts + 1)]

    _each(
        lambda k: kernel(bounds[k], bounds[k + 1], *arguments, out[k]),
        parts,
        count(n, least),
    )
    return out[0] if parts == 1 else out.sum(axis=0)


def _each(call: Callable[[int], Any], parts: int, most: int) -> None:
    """Call `call(k)` for each part, in turn by at most so many threads."""
    number = min(most, parts)

    def some(first: int) -> None:
        for k in range(first, parts, number):
            call(k)

    together([(some, (first,)) for first in range(number)])


def together(calls: list[tuple[Callable[..., Any], tuple[Any, ...]]]) -> list[Any]:
    """Make calls at the same time, each in a thread of its own, the first in the
    calling one; return their results.

    Calls that come while others are under way, as from another thread, are made one
    after the other; so these may not wait for each other.

    Raises
    ------
    KeyboardInterrupt : SIGINT arrived; all calls have ended
    Exception : of the first call that failed, after all have ended
    """
    if len(calls) == 1 or not _in_use.acquire(blocking=False):
        return [function(*arguments) for function, arguments in calls]
    try:
        return _together(calls)
    finally:
        _in_use.release()


def _together(calls: list[tuple[Callable[..., Any], tuple[Any, ...]]]) -> list[Any]:
    """Make calls at the same time in the workers, which the caller holds."""
    with deferred_interrupt():
        while len(_workers) < len(calls) - 1:
            _workers.append(_Worker())
        busy = list(zip(_workers, calls[1:], strict=False))
        for worker, call in busy:
            worker.work.put(call)
        outcomes = [_outcome(*calls[0]), *(worker.done.get() for worker, _ in busy)]
    for _, error in outcomes:
        if error is not None:
            raise error
    return [value for value, _ in outcomes]


def team(
    crews: Callable[[int], list[Any]],
    kernel: Callable[..., Any],
    most: int,
    *arguments: Any,
) -> Any:
    """Call `kernel(member, *arguments)` for every member of a team at the same time.

    Parameters
    ----------
    crews : makes the members of a team of a size, as `contbed.compiled.barrier.crews`
        does
    kernel : compiled with nogil=True; its threads may wait for each other
    most : size of the team; it is 1 while the workers compute for another caller
    arguments : passed on to the kernel

    Returns
    -------
    what the first member's call returns

    Raises
    ------
    KeyboardInterrupt : SIGINT arrived; all calls have ended
    """
    if most > 1 and _in_use.acquire(blocking=False):
        try:
            return _together(
                [(kernel, (member, *arguments)) for member in crews(most)]
            )[0]
        finally:
            _in_use.release()
    return kernel(crews(1)[0], *arguments)


class _Worker:
    """A thread that makes calls from a queue and hands back results."""

    def __init__(self) -> None:
        self.work: SimpleQueue[Any] = SimpleQueue()
        self.done: SimpleQueue[Any] = SimpleQueue()
        # a daemon: it only waits, and must not keep the interpreter from ending
        threading.Thread(target=self._serve, name="contbed", daemon=True).start()

    def _serve(self) -> None:
        while True:
            self.done.put(_outcome(*self.work.get()))


def _outcome(
    function: Callable[..., Any], arguments: tuple[Any, ...]
) -> tuple[Any, BaseException | None]:
    try:
        return function(*arguments), None
    except BaseException as error:
        return None, error


def _forget() -> None:
    """Start anew in a process that was forked: threads of the parent do not exist
    there.
    """
    global _in_use
    _in_use = threading.Lock()
    _workers.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
