"""What threads need that run one compiled kernel together: tickets for the next piece
of work, and a barrier.

A team runs the same kernel once in each of its threads, `kernel(crew, *arguments)` with
a `Crew` of its own. It goes through phases: in each, a thread takes pieces of work
until none is left, and waits until all have finished theirs.

    @entry(nogil=True, cache=True)
    def kernel(crew, pieces, x, y):
        piece = take(crew)
        while piece < pieces:
            ...                      # writes what belongs to the piece
            piece = take(crew)
        finish(crew, pieces)         # all pieces are done, by whichever thread

A piece always is the same work, so that the result does not depend on which thread does
it, or on how many there are. Threads wait by looking at a counter, at first without a
pause and then leaving the core to others in between.

Without it a step of two fluids would take a third longer on two cores: 37 % of the CPU
of a step of 50,700 cells is spent in kernels that meet some 20 times in an iteration,
too often to hand them over from Python.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from contbed.arrays import Integers
from contbed.compiled import threads
from contbed.compiled.functions import entry, inner

# places of the counters, 64 bytes apart: a cache line each
TICKET, ARRIVED, SIZE = 0, 8, 16
LOOKS = 2000  # at the counter before the core is left to others, about 5 us

_yield_core = types.ExternalFunction("sched_yield", types.int32())


class Crew(NamedTuple):
    """One thread of a team: its number, how many there are, the shared counters, and
    its own count.

    counters : (SIZE,) shared by all threads
    own : (2,) tickets that all earlier phases have taken, and phases finished
    """

    number: int
    size: int
    counters: Integers
    own: Integers


def run(kernel: Any, most: int, *arguments: Any) -> Any:
    """Run `kernel(crew, *arguments)` in at most `most` threads at the same time and
    return what the first returns.

    Raises
    ------
    KeyboardInterrupt : SIGINT arrived; the kernel has ended
    """
    return threads.team(crews, kernel, most, *arguments)


def crews(size: int) -> list[Crew]:
    """Make the members of a team with common counters."""
    counters = np.zeros(SIZE, np.int64)
    return [
        Crew(number, size, counters, np.zeros(2, np.int64)) for number in range(size)
    ]


@entry(nogil=True)
def take(crew: Crew) -> int:
    """Take the next piece of work of the present phase; a number from 0 on, which
    may be beyond the last piece.
    """
    return int(_add(crew.counters, TICKET, 1) - crew.own[0])


@inner(nogil=True)
def finish(crew: Crew, pieces: int) -> None:
    """End a phase of so many pieces: wait until all threads have come here."""
    # each thread has taken one ticket beyond the last piece
    crew.own[0] += pieces + crew.size
    wait(crew)


@inner(nogil=True)
def wait(crew: Crew) -> None:
    """Wait until all threads have come here."""
    crew.own[1] += 1
    everyone = crew.own[1] * crew.size
    _add(crew.counters, ARRIVED, 1)
    looks = 0
    while _look(crew.counters, ARRIVED) < everyone:
        looks += 1
        if looks > LOOKS:
            _yield_core()


def _add_code(typing_context: Any, counters: Any, place: Any, value: Any) -> Any:
    """Add to a counter and return what it was; what was written before is seen by
    who reads the counter later.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address = _address(context, builder, signature, arguments)
        return builder.atomic_rmw("add", address, arguments[2], ordering="seq_cst")

    return types.int64(counters, types.intp, types.int64), code


def _look_code(typing_context: Any, counters: Any, place: Any) -> Any:
    """Read a counter; what others wrote before they changed it is seen afterwards."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load_atomic(
            _address(context, builder, signature, arguments), "acquire", 8
        )

    return types.int64(counters, types.intp), code


def _address(context: Any, builder: Any, signature: Any, arguments: Any) -> ir.Value:
    array = context.make_array(signature.args[0])(context, builder, arguments[0])
    return cgutils.get_item_pointer(
        context, builder, signature.args[0], array, [arguments[1]], wraparound=False
    )


_add: Any = intrinsic(_add_code)
_look: Any = intrinsic(_look_code)
