"""Node coordinates in one direction, graded to layers of known position and width."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from contbed.arrays import Array
from contbed.errors import SceneError

CELLS_ALONG = 40  # cells along a bed without prescribed cells
# share of the smooth part of a solution in `equidistributed`, where a layer takes
# degree + 1
SMOOTH = 3.0
# error of theta on a mesh of grading scale 1 with quadratic elements, measured
GRADING_ERROR = 4e-4
# of the places at which `of_size` looks: share of the length at the ends, number
SMALLEST, SAMPLES = 1e-9, 2000
WIDENING = 8.0  # ratio of widths of layers around a corner

Layers = list[tuple[float, float]]


def scale_for(tolerance: float, degree: int) -> float:
    """Return the factor on the cells of a grading that brings the error of theta to
    `tolerance`.
    """
    return min(1.0, float((tolerance / GRADING_ERROR) ** (1.0 / (degree + 1))))


def widened(layers: Layers, extent: float) -> Layers:
    """Add layers of growing width at each position, up to `extent` [m].

    Where two walls of unlike temperature meet, heat flows on all length scales down to
    the mean free path.
    """
    steps = (
        WIDENING
        ** np.arange(max(1, np.ceil(np.log(extent / width) / np.log(WIDENING))))
        for _, width in layers
    )
    return [
        (x, width * step)
        for (x, width), each in zip(layers, steps, strict=True)
        for step in each
    ]


def graded(
    length: float,
    layers: Sequence[tuple[float, float]],
    ratio: float = 1.3,
    fraction: float = 0.5,
    coarse: float | None = None,
    scale: float = 1.0,
) -> Array:
    """Return node coordinates that resolve exponential layers
    e^{-|x - position|/width}.

    The cell size h(x) is the least of `coarse` and of one cone for each layer, and the
    nodes are equally spaced in the integral of dx/h. Cells grow at most by `ratio` away
    from a layer; where two layers meet at an interior node neighbours may differ by 2
    `ratio`. A `scale` of 1/n puts n cells into each cell of scale 1.

    Parameters
    ----------
    length : extent [m]
    layers : position and width of each layer [m]; the first cell there is at most
        `fraction` of the width
    ratio : growth from one cell to the next, > 1
    fraction : size of the first cell at a layer over the width of the layer
    coarse : largest cell [m]; length/40 if absent
    scale : factor on all cells

    Returns
    -------
    strictly increasing coordinates [m] from 0.0 to `length`, with a node at each layer more than a cell from others

    Raises
    ------
    SceneError : a width below 1e-12 of the length, which round-off cannot resolve
    """
    coarse = length / CELLS_ALONG if coarse is None else min(coarse, length)
    growth = np.log(ratio)
    position, width = np.array(layers, dtype=float).reshape(-1, 2).T
    if np.any(width < 1e-12 * length):
        thin = f"layer of width {width.min():.3g} m in a bed of {length:.3g} m"
        raise SceneError(
            f"mesh: {thin} is too thin to resolve; check the closures, or give "
            "mesh.cells"
        )
    # a cell that starts at a cone's tip and spans one unit of the integral has this
    # length times (ratio-1)/growth
    tip = np.minimum(fraction * width, coarse) * growth / (ratio - 1)

    def size(x: Array) -> Array:
        h: Array = np.minimum(
            coarse,
            np.min(
                tip + growth * np.abs(x[:, None] - position), axis=1, initial=np.inf
            ),
        )
        return h

    # h is linear between these: tips, where two cones cross, where a cone reaches the
    # coarse size
    reach = (coarse - tip) / growth
    cross = (position[:, None] + position) / 2 + (tip - tip[:, None]) / (2 * growth)
    knots = np.concatenate(
        ([0.0, length], position, position - reach, position + reach, cross.ravel())
    )
    knots = np.unique(knots[(knots >= 0) & (knots <= length)])
    span, h = np.diff(knots), size(knots)
    relative = np.diff(h) / h[:-1]
    flat = np.abs(relative) < 1e-12
    relative[flat] = 1.0
    logarithm = np.log1p(relative)
    cells = span / h[:-1] * np.where(flat, 1.0, logarithm / relative)
    total = np.concatenate(([0.0], np.cumsum(cells)))

    ends = [0.0]
    for tip_total in np.interp(
        np.unique(position[(position > 0) & (position < length)]), knots, total
    ):
        if tip_total - ends[-1] >= 1 and total[-1] - tip_total >= 1:
            ends.append(tip_total)
    ends.append(total[-1])
    counts = [max(1, round(np.ceil(b - a) / scale)) for a, b in pairwise(ends)]
    spans = zip(ends, ends[1:], counts, strict=False)
    target = np.concatenate([np.linspace(a, b, n, endpoint=False) for a, b, n in spans])
    piece = np.clip(np.searchsorted(total, target, side="right") - 1, 0, len(span) - 1)
    part = (target - total[piece]) / cells[piece]
    part = np.where(
        flat[piece], part, np.expm1(logarithm[piece] * part) / relative[piece]
    )
    return np.append(knots[piece] + span[piece] * part, length)


def equidistributed(
    length: float, layers: Sequence[tuple[float, float]], cells: int, degree: int = 2
) -> Array:
    """Return node coordinates [m] of `cells` cells that share the interpolation error
    equally.

    Elements of degree k interpolate e^{-|x - position|/width} with equal errors in all
    cells of a density e^{-|x - position|/(m width)}/width, m = k + 1. Its integral is m
    however thin the layer is, so that `cells` may be few. The densities of all `layers`
    (position and width [m]) and `SMOOTH`/length for the rest add up.
    """
    position, width = np.array(layers, dtype=float).reshape(-1, 2).T
    reach = (degree + 1) * width

    def count(x: Array) -> Array:
        beyond = (x[:, None] - position) / reach
        before = -position / reach
        part = np.sign(before) * np.expm1(-np.abs(before)) - np.sign(beyond) * np.expm1(
            -np.abs(beyond)
        )
        total: Array = SMOOTH * x / length + (degree + 1) * part.sum(axis=1)
        return total

    target = np.linspace(0.0, 1.0, cells + 1)[1:-1] * count(np.array([length]))
    low, high = np.zeros(cells - 1), np.full(cells - 1, length)
    for _ in range(60):
        middle = 0.5 * (low + high)
        right = count(middle) < target
        low, high = np.where(right, middle, low), np.where(right, high, middle)
    return np.concatenate(([0.0], 0.5 * (low + high), [length]))


def of_size(length: float, size: Callable[[Array], Array], scale: float = 1.0) -> Array:
    """Return node coordinates [m] of cells of the size that a function of the
    coordinate gives, times `scale`.
    """
    near = length * np.concatenate(([0.0], np.geomspace(SMALLEST, 0.5, SAMPLES)))
    ends = np.unique(np.concatenate((near, length - near)))
    middle = 0.5 * (ends[1:] + ends[:-1])
    return of_density(ends, 1.0 / size(middle), scale)


def finest(grids: Sequence[Array]) -> Array:
    """Return node coordinates that are nowhere coarser than those of any of the
    `grids` over the same length [m].
    """
    ends = np.unique(np.concatenate(grids))
    middle = 0.5 * (ends[1:] + ends[:-1])
    density = np.max(
        [1.0 / np.diff(grid)[np.searchsorted(grid, middle) - 1] for grid in grids],
        axis=0,
    )
    return of_density(ends, density)


def growing(size: Array, steps: Array, steps_back: Array) -> Array:
    """Return sizes of cells (n,) that grow by no more than `steps` (n - 1,) from each
    to the next, and by no more than `steps_back` the other way.
    """
    size = size.copy()
    for k, step in enumerate(steps, 1):
        size[k] = min(size[k], size[k - 1] + step)
    for k in range(len(size) - 2, -1, -1):
        size[k] = min(size[k], size[k + 1] + steps_back[k])
    return size


def of_density(
    ends: Array,
    density: Array,
    scale: float = 1.0,
    least: int = 1,
    most: int | None = None,
) -> Array:
    """Return node coordinates [m] of cells that hold `scale` of a density each, or
    less, all the same.

    The density (n,) is uniform between the `ends` (n + 1,); at `least` and at `most` so
    many cells are made.
    """
    total = np.concatenate(([0.0], np.cumsum(density * np.diff(ends))))
    count = int(np.clip(np.ceil(total[-1] / scale), least, most))
    nodes: Array = np.interp(np.linspace(0.0, total[-1], count + 1), total, ends)
    nodes[0], nodes[-1] = ends[0], ends[-1]
    return nodes
