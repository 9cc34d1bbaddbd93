"""The driver of all runs in time: steps follow their errors, and end where series jump,
at output times that ask for it, and at the end of the run.

No step depends on where the run ends: the step that is cut short to meet the end is
thrown away where the run is continued, see `History.resume`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from contbed.course.history import SAME, History
from contbed.errors import ConvergenceError

H = TypeVar("H", bound=History)
Accept = Callable[[float], H]  # the history after a step, given the size of the next

SAFETY, LEAST_GROWTH = 0.8, 0.2
SHORTER = 0.25  # of a step that does not converge
POWERS_OF_TWO = 2
# steps between two powers of 2: a thousandth, of estimates that rounding changes by
# 1e-9
FEW_DIGITS = 2**10


@dataclass(frozen=True)
class Control:
    """How the sizes of steps follow their errors.

    first : step at the start and after a jump [s]; shortest : below which a run is
        given up [s]
    order : power of the size with which the error of a step falls
    growth : largest, from one step to the next
    digits : sizes between 1 and 2, less one; few, so that few matrices serve a run and
        rounding in the estimates of errors does not decide sizes
    constant : whether all steps have the first size and are not judged
    """

    first: float
    shortest: float
    order: int
    growth: float
    digits: int
    constant: bool = False

    def rounded(self, size: float) -> float:
        """Return the next shorter size of few digits."""
        mantissa, exponent = math.frexp(size)
        return math.ldexp(math.floor(mantissa * self.digits), exponent) / self.digits


class TimeSteps(Generic[H]):
    """The steps of one model; a model says how one is taken."""

    control: Control

    def stops(self) -> Sequence[float]:
        """Return the times at which a step ends, the end of the run last [s]."""
        raise NotImplementedError

    def entered(self, history: H, stop: float) -> H:
        """Return the history at the begin of the part of the run that ends at a stop,
        or within it after a restart.
        """
        return history

    def resolves(self, start: float, end: float) -> bool:
        """Return whether a step between two times [s] sees how series change."""
        return True

    def take(
        self, history: H, end: float, size: float, repeated: bool = False
    ) -> tuple[float, Accept[H]]:
        """Take a step of a size [s] that ends at a time [s]; return its error over the
        tolerance, and what accepts it.

        A `repeated` step is accepted whatever its error.

        Raises
        ------
        ConvergenceError : it has no solution
        """
        raise NotImplementedError

    def march(self, history: H) -> Iterator[H]:
        """Yield the histories after each accepted step to the end of the run.

        Raises
        ------
        ConvergenceError : steps become ever smaller
        """
        stops = self.stops()
        for stop in stops:
            if history.time >= stop * (1.0 - SAME):
                continue
            history = self.entered(history, stop)
            while history.time < stop:
                before, history = history, self.advanced(history, stop)
                if history.time == stops[-1] and history.taken < before.size:
                    history = replace(history, resume=before)
                yield history

    def repeated(self, history: H, sizes: Iterable[float]) -> Iterator[tuple[H, float]]:
        """Yield the histories after steps of given sizes [s], whatever their errors,
        and these over the tolerance.

        Raises
        ------
        ConvergenceError : a step has no solution
        """
        given = iter(sizes)
        for stop in self.stops():
            history = self.entered(history, stop)
            while history.time < stop:
                size = next(given)
                end = _met(history.time + size, stop)
                error, accept = self.take(history, end, size, True)
                history = accept(history.size)
                yield history, error

    def advanced(self, history: H, stop: float) -> H:
        """Return the history after one step towards a stop; others may try more than
        one.
        """
        return self.controlled(history, stop, history.size)

    def controlled(self, history: H, stop: float, size: float) -> H:
        """Return the history after the longest step, at most `size`, that its error
        allows.

        Raises
        ------
        ConvergenceError : steps become ever smaller
        """
        control = self.control
        while True:
            step = self._resolved(history.time, min(size, stop - history.time))
            if step < control.shortest and stop - history.time > 2.0 * step:
                raise ConvergenceError(
                    "the time step fell below its limit: the error of a step did "
                    "not become small enough"
                )
            try:
                end = _met(history.time + step, stop)
                error, accept = self.take(history, end, step)
            # a shorter step is nearer to the state from which it begins
            except ConvergenceError:
                size = control.rounded(SHORTER * step)
                if control.constant or size < control.shortest:
                    raise
                continue
            if control.constant:
                return accept(size)
            growth = SAFETY * max(error, 1e-300) ** (-1.0 / control.order)
            if not error <= 1.0:
                size = control.rounded(step * max(LEAST_GROWTH, growth))
                continue
            # a step that was cut short says nothing of the next
            return accept(self._next_size(size, growth) if step == size else size)

    def _next_size(self, size: float, growth: float) -> float:
        least = 1.0 if self.control.digits == POWERS_OF_TWO else LEAST_GROWTH
        factor = min(max(growth, least), self.control.growth)
        return self.control.rounded(size * factor)

    def _resolved(self, time: float, step: float) -> float:
        """Return the longest step [s] from a time, halved until it sees how series
        change.
        """
        while step > self.control.shortest and not self.resolves(time, time + step):
            step *= 0.5
        return step


def _met(end: float, stop: float) -> float:
    """Return the end of a step, that of a stop which is as near as rounding."""
    return stop if end >= stop * (1.0 - SAME) else end
