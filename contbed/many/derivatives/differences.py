"""Derivatives from differences of whole runs, with an estimate of their error.

    f'(p) = (4 D(h) - D(2h))/3,  D(h) = (f(p + h) - f(p - h))/(2h)        (Richardson), error |D(h) - D(2h)|/3

A key at a bound is changed to one side only, where D(h) = (f(p + h) - f(p))/h and
f'(p) = 2 D(h) - D(2h).

Results of particles and of two-fluid runs scatter: they are computed for several seeds,
the same seeds on both sides (common random numbers), with one large step; the mean of
the differences is reported with its standard error (Glasserman & Yao 1992,
doi:10.1287/mnsc.38.6.884). A scene without a seed is computed with several steps, and a
straight line over their squares, by least squares, gives D(0) and its standard error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.errors import ContbedError, SceneError
from contbed.many.derivatives.keys import Key, continuous
from contbed.scene.tables import SceneBase
from contbed.scene.values import tables, with_value

Results = Callable[[SceneBase], Array]

# relative: meshes that follow the scene change results by some 1e-6 of themselves
STEP = 1e-3
STEP_OF_NOISY = 0.05  # relative: particles scatter by percents
SEEDS = 4  # runs on each side of a key whose results scatter
# relative to a bound's distance: below it, the key counts as at its bound
MIN_STEP = 1e-12


@dataclass(frozen=True)
class Slope:
    """Derivatives of all results with respect to one key (n_qoi,), their estimated
    errors, and a remark.
    """

    values: Array
    errors: Array
    note: str = ""


@dataclass(frozen=True)
class Steps:
    """Values of a key to compute at: `sides` are +1 and -1, or one of them at a
    bound; `size` is the smaller step.
    """

    size: float
    sides: tuple[int, ...]
    note: str = ""


def steps(scene: SceneBase, key: Key, relative: float) -> Steps:
    """Return the steps for a key such that twice the step stays within its bounds on
    each side that is used.

    Raises
    ------
    SceneError : the bounds leave no room on any side
    """
    size = relative * scale(scene, key)
    both = [side for side in (1, -1) if key.allows(key.value + 2 * side * size)]
    if len(both) == 2:
        return Steps(size, (1, -1))
    # near a bound: a smaller step on both sides, unless the key stands at it
    room = min(key.value - key.low, key.high - key.value)
    if room > MIN_STEP * max(abs(key.value), size):
        smaller = 0.4 * room
        if smaller > 1e-3 * size:
            return Steps(smaller, (1, -1))
    if not both:
        raise SceneError(
            f"{scene.origin.at(key.path)}: {key.name} = {key.value:g} cannot be "
            "changed within its bounds"
        )
    side = "from above" if both == [1] else "from below"
    return Steps(
        size,
        tuple(both),
        f"{key.name} = {key.value:g} is at its bound: one-sided derivative {side}",
    )


def scale(scene: SceneBase, key: Key) -> float:
    """Return the size of a key for its step: its value, or if it is 0 the largest of
    the scene with its unit, or 1.
    """
    if key.value:
        return abs(key.value)
    alike = [
        abs(other.value)
        for other in continuous(scene)
        if other.unit == key.unit and other.value
    ]
    return max(alike, default=1.0)


def slope(
    scene: SceneBase, key: Key, results: Results, centre: Array, relative: float = STEP
) -> Slope:
    """Return the derivatives with respect to a key by runs at two distances.

    `centre` (n_qoi,) are the results of the scene itself.

    Raises
    ------
    ContbedError : a run fails, with the value of the key
    """
    chosen = steps(scene, key, relative)
    near, far = (
        _quotient(scene, key, chosen.sides, distance, results, lambda: centre)
        for distance in (chosen.size, 2 * chosen.size)
    )
    order = 2 if len(chosen.sides) == 2 else 1
    change = (near - far) / (2**order - 1)
    return Slope(near + change, np.abs(change), chosen.note)


def noisy_slope(
    scene: SceneBase, key: Key, results: Results, centre: Array, seeded: bool = True
) -> Slope:
    """Return the mean derivatives over common seeds, and their standard errors.

    A scene without a seed, or one whose seed changes nothing, is run with steps of
    several sizes instead.
    """
    found, distances = [], []
    places = seeds(scene) if seeded else []
    seeded = bool(places)
    chosen = steps(scene, key, 0.5 * STEP_OF_NOISY)
    for number in range(SEEDS):
        distance = (
            2 * chosen.size if seeded else chosen.size * (1 + number / (SEEDS - 1))
        )
        distances.append(distance)
        other = with_seeds(scene, places, number)

        def start(other: SceneBase = other, is_known: bool = not number) -> Array:
            known = is_known or not seeded
            return centre if known else _at(other, key, key.value, results)

        found.append(_quotient(other, key, chosen.sides, distance, results, start))
        if seeded and number == 1 and np.array_equal(found[0], found[1]):
            return noisy_slope(scene, key, results, centre, seeded=False)
    each = np.array(found)
    if not seeded:
        return Slope(
            *_at_no_distance(np.array(distances), each, len(chosen.sides)), chosen.note
        )
    return Slope(
        each.mean(axis=0), each.std(axis=0, ddof=1) / math.sqrt(SEEDS), chosen.note
    )


def _quotient(
    scene: SceneBase,
    key: Key,
    sides: Sequence[int],
    distance: float,
    results: Results,
    centre: Callable[[], Array],
) -> Array:
    """Return the difference of the results over that of the key at a distance on both
    sides, or on one of them; `centre` then returns the results of the scene itself.
    """
    ends = {
        side: _at(scene, key, key.value + side * distance, results) for side in sides
    }
    if len(ends) == 2:
        found: Array = (ends[1] - ends[-1]) / (2 * distance)
        return found
    (side,) = sides
    found = side * (ends[side] - centre()) / distance
    return found


def _at_no_distance(distances: Array, found: Array, order: int) -> tuple[Array, Array]:
    """Return differences (n, n_qoi) extrapolated to no distance by an error of that
    order, and standard errors.
    """
    line = np.column_stack(
        [np.ones_like(distances), (distances / distances.max()) ** order]
    )
    coefficients, *_ = np.linalg.lstsq(line, found, rcond=None)
    rest = found - line @ coefficients
    variance = (rest**2).sum(axis=0) / (len(distances) - line.shape[1])
    return coefficients[0], np.sqrt(variance * np.linalg.inv(line.T @ line)[0, 0])


def seeds(scene: SceneBase) -> list[tuple[tuple[Any, ...], int]]:
    """Return paths and values of the seeds of a scene."""
    return [
        ((*path, "seed"), seed)
        for path, table in tables(scene)
        if isinstance(seed := getattr(table, "seed", None), int)
    ]


def with_seeds(
    scene: SceneBase, seeded: Sequence[tuple[tuple[Any, ...], int]], shift: int
) -> SceneBase:
    """Return the scene with its seeds, as `seeds` gives them, so much higher."""
    for path, value in seeded:
        scene = with_value(scene, path, value + shift)
    return scene


def _at(scene: SceneBase, key: Key, value: float, results: Results) -> Array:
    try:
        return results(key.on(scene, value))
    except ContbedError as error:
        text = (
            f"{scene.origin.at(key.path)}: the derivative to {key.name} needs a run "
            f"at {value:.6g}, which fails: "
        )
        raise type(error)(f"{text}{error}") from error
