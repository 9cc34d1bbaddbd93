"""Cyclic steady state: the state that one period of a run gives back, found directly
instead of by many periods.

With y what is stored at the start of a period and Phi(y) that at its end, Phi(y) = y is
solved by Anderson's acceleration (`solvers.anderson`). Plain repetition takes hundreds
of periods where a period is short, as in regenerators. After some periods the sequence
of time steps is kept, so that Phi is smooth; it is chosen anew where the error of a
kept step is larger than allowed.

An extrapolated state may be one from which no period can be computed, or which changes
more than twice as much as the best: then the search begins anew at the end of the best
period.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Generic, NamedTuple, Protocol, Self

import numpy as np

from contbed.course.history import packed, unpacked
from contbed.course.march import H
from contbed.errors import ConvergenceError
from contbed.fields import distinct
from contbed.solvers.anderson import Anderson

ADAPTIVE = 4  # periods whose steps are chosen anew; later ones repeat those of the last
MOST = 60  # periods after which the run gives up
# error of a kept step over that allowed, above which steps are chosen anew
OUTDATED = 4.0
# change of a period over the least so far, above which what was extrapolated is given
# up
GROWN = 2.0


class Periodic(Protocol[H]):
    """Time steps of a model, see `TimeSteps`, and what it says of its cycle."""

    def march(self, history: H) -> Iterator[H]:
        """Yield the histories after each step."""

    def repeated(self, history: H, sizes: Iterable[float]) -> Iterator[tuple[H, float]]:
        """Yield the histories after steps of given sizes [s], and their errors."""

    def scale(self, after: H) -> Any:
        """Return the sizes that changes refer to, from the end of the first period."""

    def stored(self, state: Any, scale: Any) -> Any:
        """Return what is stored of a state, over its sizes."""

    def begun(self, values: Any, scale: Any, after: H) -> H:
        """Return the history at the start of a period from stored values that are
        extrapolated; `after` is the end of the last one.
        """

    def again(self, after: H) -> H:
        """Return the history at the start of a period that follows another."""


@dataclass(frozen=True)
class Search(Generic[H]):
    """Where the search for a cycle is; a checkpoint holds it, so that a restart
    has the same numbers.

    begin : history at the start of the next period; periods : how many were computed
    sizes : of the steps of the last period [s]; scale : of what is stored
    best, closest : ends of the best periods since the search began anew and of all,
        with their changes, of all of them by unknown
    extrapolated : whether `begin` is; outdated : whether steps are chosen anew
    pairs : states and images of former periods, see `Anderson`
    """

    begin: H
    periods: int = 0
    sizes: tuple[float, ...] = ()
    scale: Any = None
    best: H | None = None
    best_change: float = np.inf
    closest: H | None = None
    closest_change: Any = None
    extrapolated: bool = False
    outdated: bool = False
    pairs: tuple[Any, ...] = ()

    def pack(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the arrays and numbers of a checkpoint."""
        arrays: dict[str, Any] = {}
        return arrays, {"search": packed(self, "search", arrays)}

    @classmethod
    def unpack(
        cls, begin: H, arrays: Mapping[str, Any], meta: Mapping[str, Any]
    ) -> Self:
        """Restore a search from a checkpoint of the run that begins with a history."""
        found = unpacked(meta["search"], arrays)
        for name in ("begin", "best", "closest"):
            if found[name] is not None:
                found[name] = begin.like(found[name])
        return cls(**found)


class Period(NamedTuple):
    """A period: its number, its histories at the start and the end, the sizes of its
    steps [s], the changes of what is stored over the scale, and whether it closes.
    """

    number: int
    begin: Any
    history: Any
    sizes: list[float]
    scale: Any
    change: Any
    closed: bool

    @property
    def largest(self) -> float:
        """The largest change; 0 of a bed that stores nothing."""
        return float(np.max(self.change, initial=0.0))


def periods(
    model: Periodic[H],
    first: H,
    start: tuple[Any, Any] | None,
    tolerance: float,
    save: Callable[[Search[H]], None],
    advance: Callable[[float, str], None],
) -> Iterator[Period]:
    """Yield periods to one that closes, or `MOST`, and then the closest.

    Parameters
    ----------
    first : history at the start of the first period
    start : arrays and numbers of a checkpoint to resume from
    tolerance : largest change of what is stored, over its sizes
    save : is called with the search before each period
    advance : is called with the time after each step [s], and with the number of the
        period and the change of the one before

    Raises
    ------
    ConvergenceError : a step fails, in a period that is not extrapolated as well
    """
    search = Search(first)
    if start is not None:
        search = Search.unpack(first, *start)
    note = ""
    while search.periods < MOST:
        save(search)
        count = search.periods + 1
        fresh = count <= ADAPTIVE or search.outdated
        after, sizes, error = search.begin, [], 0.0
        try:
            for following, missed in _steps(model, search, fresh):
                advance(following.time, f"period {count}{note}")
                after, error = following, max(error, missed)
                sizes.append(after.taken)
        except ConvergenceError:
            if search.best is None or not search.extrapolated:
                raise
            search = _from_best(model, search, count)
            search = replace(search, outdated=True)
            continue
        scale = model.scale(after) if search.scale is None else search.scale
        before = model.stored(search.begin.state, scale)
        image = model.stored(after.state, scale)
        outdated = error > OUTDATED
        change = np.abs(image - before)
        # of a bed that stores nothing 0 in its first period
        largest = float(np.max(change, initial=0.0))
        changed, allowed = distinct(largest, tolerance)
        note = f" (the last changed by {changed}, allowed are {allowed})"
        small = largest <= tolerance and (count > 1 or not change.size)
        closed = small and not outdated
        yield Period(count, search.begin, after, sizes, scale, change, closed)
        if closed:
            return
        if search.closest is None or largest < np.max(search.closest_change):
            search = replace(search, closest=after, closest_change=change)
        pairs = () if outdated else search.pairs
        search = replace(search, scale=scale, outdated=outdated, pairs=pairs)
        grown = search.best is not None and largest > GROWN * search.best_change
        if grown and search.extrapolated:
            search = _from_best(model, search, count)
            continue
        if largest < search.best_change:
            search = replace(search, best=after, best_change=largest)
        accelerate = Anderson(search.pairs)
        values = accelerate(before.ravel(), image.ravel())
        search = replace(
            search,
            begin=model.begun(values, scale, after),
            periods=count,
            sizes=tuple(sizes),
            extrapolated=len(accelerate.pairs) > 1,
            pairs=accelerate.pairs,
        )
    if search.closest is not None:
        after, change = search.closest, search.closest_change
        yield Period(MOST, search.begin, after, [], search.scale, change, False)


def _steps(
    model: Periodic[H], search: Search[H], fresh: bool
) -> Iterator[tuple[H, float]]:
    if fresh:
        return ((after, 0.0) for after in model.march(search.begin))
    return model.repeated(search.begin, search.sizes)


def _from_best(model: Periodic[H], search: Search[H], count: int) -> Search[H]:
    """Return the search that begins anew at the end of the best period."""
    assert search.best is not None
    return replace(
        search,
        begin=model.again(search.best),
        periods=count,
        best=None,
        best_change=np.inf,
        extrapolated=False,
        pairs=(),
    )
