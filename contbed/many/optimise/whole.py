"""Designs with integers: for each choice of them the other keys are found by a search
of their own.

Up to `ENUMERATED` choices all are tried, and the best is exact. Beyond that the
neighbours of the best choice so far are tried, one integer up and down for each key,
until none is better: a better choice farther off is not excluded.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod

from contbed.many.optimise.constrained_search import Optimum

ENUMERATED = 24  # choices of integers up to which all are tried

Choice = tuple[int, ...]


@dataclass(frozen=True)
class Best:
    """The best choice and the search with it, how many choices were tried, and
    whether these are all.
    """

    choice: Choice
    optimum: Optimum
    tried: int
    complete: bool


def best_choice(
    ranges: Sequence[tuple[int, int]],
    start: Choice,
    search: Callable[[Choice, Optimum | None], Optimum | None],
) -> Best | None:
    """Return the best choice of integers; None if no search could begin.

    Parameters
    ----------
    ranges : lowest and highest value of each integer
    start : the choice to begin with
    search : returns the best of the other keys for a choice, beginning at an earlier
        optimum; None where that fails
    """
    tried: dict[Choice, Optimum | None] = {}
    best: tuple[Choice, Optimum] | None = None

    def attempt(choice: Choice) -> bool:
        nonlocal best
        found = tried[choice] = search(choice, best[1] if best else None)
        better = found is not None and (best is None or found.beats(best[1]))
        if found is not None and better:
            best = choice, found
        return better

    every = [range(low, high + 1) for low, high in ranges]
    count = prod(map(len, every))
    attempt(start)
    if count <= ENUMERATED:
        for choice in sorted(product(*every), key=lambda one: _distance(one, start)):
            if choice not in tried:
                attempt(choice)
    else:
        better = True
        while better and best is not None:
            untried = [one for one in _neighbours(best[0], ranges) if one not in tried]
            better = any([attempt(one) for one in untried])  # noqa: C419 - each neighbour is tried
    return None if best is None else Best(*best, len(tried), count == len(tried))


def _neighbours(choice: Choice, ranges: Sequence[tuple[int, int]]) -> Iterator[Choice]:
    for k, (low, high) in enumerate(ranges):
        for value in (choice[k] - 1, choice[k] + 1):
            if low <= value <= high:
                yield (*choice[:k], value, *choice[k + 1 :])


def _distance(one: Choice, other: Choice) -> tuple[int, Choice]:
    return sum(abs(a - b) for a, b in zip(one, other, strict=True)), one
