"""Cyclic steady state of a reacting bed: the state that one period of a run gives back,
found directly.

With y what is stored at the start of a period and Phi(y) that at its end, Phi(y) = y is
solved by Anderson's acceleration (`solvers.anderson`). After some periods the sequence
of time steps is kept, so that Phi is smooth; it is chosen anew where the error of a
kept step is larger than allowed.

y holds what the equations store, each over its typical size: temperatures over the
range of the scene and of the bed after one period; moles of solids over those that
enter, of each phase; intraparticle concentrations over that of the gas, of traces over
their largest; mole fractions of a gas in the pores over 1. What follows at once (a gas
that is not stored, films, the pressure) is no part of y. The change of a cycle is the
largest of y over a period.

An extrapolated state may leave the bounds: amounts and fractions at or above zero,
temperatures no further than half of their size beyond those at the end of the period.
At each node where it does, the state there is moved towards that at the end of the
period, which is within, until it is: with one share for all that is stored at the node,
so that sums such as those of fractions, and of solids at rest of which one becomes the
other, stay. At worst this is plain repetition. So it is from the best period where none
can be computed from an extrapolated state, or one that changes more than twice as much.

What no period changes, such as the moles of iron at a place of a bed at rest, is that
of the start.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from contbed.errors import ConvergenceError
from contbed.reacting_bed import solve
from contbed.reacting_bed.course import Course
from contbed.reacting_bed.equations.unknowns import LEAST_T
from contbed.reacting_bed.history import History
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.storage import gas_of_rings, stored_rows
from contbed.reacting_bed.transient import begin, march, repeated, taken_in, turned
from contbed.solvers.anderson import Anderson

Array = NDArray[np.float64]
Advance = Callable[[float, str], None]
ADAPTIVE = 4  # periods whose steps are chosen anew; later ones repeat those of the last
MOST = 60  # periods after which the run gives up
# error of a kept step over that allowed, above which steps are chosen anew
OUTDATED = 4.0
# change of a period over the least so far, above which what was extrapolated is given
# up
GROWN = 2.0
# of the size of temperatures, by which an extrapolated one may leave those at the end
# of a period
BEYOND = 0.5


@dataclass(frozen=True)
class Cycle:
    """A period.

    history : of the period from its start; periods : how many were computed
    change : the largest over the period, see the module; change_T : of a
        temperature [K], None without any
    closed : whether the change is within the tolerance
    taken : what rates take in it though there is none of it; None if they do not
    """

    history: History
    periods: int
    change: float
    change_T: float | None
    closed: bool
    taken: str | None

    def qoi(self) -> dict[str, float]:
        """Return named results."""
        found: dict[str, float] = {
            "cycle_periods": self.periods,
            "cycle_change": self.change,
        }
        return (
            found
            if self.change_T is None
            else found | {"cycle_change_K": self.change_T}
        )


def periods(
    course: Course, start: Array, report: solve.Report, advance: Advance
) -> Iterator[Cycle]:
    """Yield periods from a first guess of the state at their start to one that closes,
    or `MOST`, and then the best.

    `advance` is called with the time that each step has reached [s], and which period
    it is.

    Raises
    ------
    ConvergenceError : steps become ever smaller, in a period that begins with the end
        of another as well
    """
    assert course.time.cycle is not None
    accelerate, stored = Anderson(), None
    history, best, ends, closest = _begun(course, start), None, None, None
    extrapolated = outdated = False
    for count in range(1, MOST + 1):
        begun, after, error, taken = history.u, history, 0.0, None
        try:
            for following, worst in _steps(
                course, history, None if count <= ADAPTIVE or outdated else ends, report
            ):
                taken = taken or taken_in(course, after, following)
                after, error = following, worst
                advance(after.time, f"period {count}")
        except ConvergenceError:
            if best is None or not extrapolated:
                raise
            accelerate.forget()
            history, best, extrapolated, outdated = (
                _begun(course, best.history.u, best.history),
                None,
                False,
                True,
            )
            continue
        stored = stored or Stored.of(course.problem, course.sizes(after.u))
        before, image = stored.values(begun), stored.values(after.u)
        change = np.abs(image - before)
        outdated = error > OUTDATED * course.time.tolerance
        # of a bed that stores nothing 0 in its first period
        largest = float(change.max(initial=0.0))
        closed = (
            largest <= course.time.cycle.tolerance
            and (count > 1 or not change.size)
            and not outdated
        )
        found = Cycle(after, count, largest, stored.in_kelvin(change), closed, taken)
        yield found
        if closed:
            return
        closest = found if closest is None or found.change < closest.change else closest
        if outdated:
            accelerate.forget()
        if best is not None and extrapolated and found.change > GROWN * best.change:
            accelerate.forget()
            history, best, extrapolated = (
                _begun(course, best.history.u, best.history),
                None,
                False,
            )
            continue
        best = found if best is None or found.change < best.change else best
        ends = [row[0] for row in after.outlet]
        extrapolation = accelerate(before.ravel(), image.ravel())
        extrapolated = len(accelerate) > 1
        history = _begun(course, stored.bounded(extrapolation, after.u), after)
    if closest is not None:
        yield replace(closest, periods=MOST)


def _begun(course: Course, u: Array, before: History | None = None) -> History:
    """Return the history at the start of a period from a state; `before` is the
    period that ends there.
    """
    history = begin(course, turned(course.problem, u))
    return (
        history
        if before is None
        else replace(history, damping=before.damping, extents=before.extents)
    )


def _steps(
    course: Course, history: History, ends: list[float] | None, report: solve.Report
) -> Iterator[tuple[History, float]]:
    """Yield the histories after the steps of a period, and the largest error so far;
    `ends` are those of kept steps.
    """
    if ends is None:
        yield from ((after, 0.0) for after in march(course, history, report))
        return
    worst = 0.0
    for after, error in repeated(course, history, ends, report):
        worst = max(worst, error)
        yield after, worst


@dataclass(frozen=True, eq=False)
class Stored:
    """What is stored of a state, over its sizes; `rows` of the unknowns that store
    something, `sizes` (m,) of all.

    `gas` are the rows of the gas in the pores of each ring, none where it follows at
    once.
    """

    rows: NDArray[np.intp]
    sizes: Array
    gas: tuple[NDArray[np.intp], ...]
    warm: NDArray[np.bool_]  # which rows are temperatures

    @classmethod
    def of(cls, problem: Problem, sizes: Array) -> Stored:
        """Return what a problem stores."""
        rows = stored_rows(problem)
        gas = gas_of_rings(problem) if problem.bed.gas_pressure is not None else ()
        return cls(
            rows,
            sizes,
            gas,
            np.array([problem.unknowns[k].is_temperature for k in rows]),
        )

    def values(self, u: Array) -> Array:
        """Return what is stored of a state (m, N, p + 1) over sizes (rows, N,
        p + 1).
        """
        out = u / self.sizes[:, None, None]
        for rows in self.gas:
            out[rows] = u[rows] / u[rows].sum(axis=0)
        found: Array = out[self.rows]
        return found

    def in_kelvin(self, change: Array) -> float | None:
        """Return the largest change of a temperature."""
        if not self.warm.any():
            return None
        sizes = self.sizes[self.rows][self.warm]
        return float((change[self.warm] * sizes[:, None, None]).max())

    def bounded(self, values: Array, image: Array) -> Array:
        """Return the state with stored values, at nodes where these leave the bounds
        moved towards an image.
        """
        inside = self.values(image)
        wanted = values.reshape(inside.shape)
        low, high = np.minimum(inside, 0.0), np.full_like(inside, np.inf)
        if self.warm.any():
            T, coldest = inside[self.warm], LEAST_T / self.sizes[self.rows][self.warm]
            low[self.warm] = np.maximum(T.min(axis=(1, 2)) - BEYOND, coldest)[
                :, None, None
            ]
            high[self.warm] = T.max(axis=(1, 2))[:, None, None] + BEYOND
        step = wanted - inside
        with np.errstate(divide="ignore", invalid="ignore"):
            down = np.where(wanted < low, (inside - low) / -step, 1.0)
            up = np.where(wanted > high, (high - inside) / step, 1.0)
        share = np.clip(np.minimum(down, up).min(axis=0), 0.0, 1.0)
        return self._state(inside + share * step, image)

    def _state(self, values: Array, image: Array) -> Array:
        """Return a state with stored values; the rest is that of an image."""
        u = image.copy()
        u[self.rows] = values * self.sizes[self.rows][:, None, None]
        for rows in self.gas:
            at = np.searchsorted(self.rows, rows)
            u[rows] = values[at] * image[rows].sum(axis=0)
        return u
