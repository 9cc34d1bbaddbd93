"""Cells of a reacting bed that follow the errors of a state: of any lengths, and in time halves of first cells.

In time cells that stay as they were keep their state to rounding, and only cells that are joined lose something of it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from contbed.mesh.grading import of_density
from contbed.reacting_bed.problem import Problem

Array = NDArray[np.float64]
MOST_CELLS = 3000
COARSEST = 2.5  # ratio of the lengths of neighbouring cells
ERROR_POWER = 0.7  # jumps are held to tolerance^ERROR_POWER: fluxes at vertices are of order 7, jumps of order 4
LEAST_SPAN = 1e-4  # of the typical size of a field, the least span that errors refer to
LEAST_RATIO = 1e-30  # of an error over what is aimed at, in a cell without any
FEWEST = 8  # cells of a bed in time, a power of 2
SHORTEST = 2.0**-10  # cell in time over the bed: steps of a front that has no width are as short
ROOM = 3.0  # lengths of a short cell around it in which others are as short, so that a front can move
FEWER = 0.7  # of the present cells, below which fewer are taken although none needs it
SAME_LENGTH = 1.0 + 1e-6


def halves(problem: Problem) -> Array:
    """Return the vertices and the middles of the cells."""
    found: Array = np.sort(np.concatenate([problem.line.vertices, problem.line.points.mean(axis=1)]))
    return found


def moved(problem: Problem, u: Array, other: Problem) -> Array:
    """Return a state on the cells of another problem."""
    found: Array = problem.line.at(u, other.line.points.ravel()).reshape(len(u), *other.line.points.shape)
    return found


def errors(problem: Problem, u: Array, sizes: Array | None = None) -> Array:
    """Return the jumps and highest modes of the fields in each cell over sizes (m,), or their spans (N,)."""
    line = problem.line
    span = np.maximum(np.ptp(u, axis=(1, 2)), LEAST_SPAN * problem.sizes) if sizes is None else sizes
    low, high = u @ line.left, u @ line.right
    jump = np.abs(low[:, 1:] - high[:, :-1])
    found = line.top_mode(u)
    found[:, 1:] = np.maximum(found[:, 1:], jump)
    found[:, :-1] = np.maximum(found[:, :-1], jump)
    worst: Array = (found / span[:, None]).max(axis=0)
    return worst


def next_cells(problem: Problem, u: Array) -> tuple[Array, float]:
    """Return better vertices for a state, and by how much the errors of the present ones exceed what is aimed at."""
    found = errors(problem, u)
    return better_cells(problem, found), float(found.max()) / aim(problem)


def aim(problem: Problem) -> float:
    """Return the error of a cell that is aimed at."""
    return float(problem.scene.solver.tolerance**ERROR_POWER)


def better_cells(problem: Problem, found: Array) -> Array:
    """Return vertices of cells whose errors are about what is aimed at, from those that were found (N,)."""
    return regraded(problem.line.vertices, wanted_lengths(problem, found))


def wanted_lengths(problem: Problem, found: Array) -> Array:
    """Return the lengths of cells whose errors would be about what is aimed at, from those that were found (N,)."""
    ratio = found / aim(problem)
    factor = np.clip((0.5 / np.maximum(ratio, LEAST_RATIO)) ** (1.0 / (problem.line.degree + 1)), 0.1, 2.0)
    return problem.line.h * factor


def halved(vertices: Array, wanted: Array) -> Array:
    """Return vertices of halves of halves of first cells, none longer than is wanted there (N,), with room beside it.

    `vertices` are the present ones; away from a short cell lengths grow by no more than the distance.
    """
    start, length = vertices[0], vertices[-1] - vertices[0]
    parts, size, done = np.arange(FEWEST) / FEWEST, 1.0 / FEWEST, []
    while len(parts):
        low = start + length * parts[:, None]
        beyond = np.maximum(vertices[:-1] - (low + length * size), low - vertices[1:])
        allowed = (wanted + (COARSEST - 1.0) * np.maximum(beyond - ROOM * wanted, 0.0)).min(axis=1)
        long = (length * size > SAME_LENGTH * allowed) & (size > SHORTEST)
        done.append(parts[~long])
        size *= 0.5
        parts = np.concatenate([parts[long], parts[long] + size])
    found: Array = start + length * np.append(np.sort(np.concatenate(done)), 1.0)
    return found


def following(problem: Problem, states: Sequence[Array], sizes: Array) -> tuple[Array | None, float]:
    """Return vertices of better cells for the states of a step, None where they are good, and the error of the last.

    The error is over sizes of the unknowns (m,).
    """
    found = [errors(problem, u, sizes) for u in states]
    wanted = wanted_lengths(problem, np.maximum.reduce(found))
    vertices, worst = halved(problem.line.vertices, wanted), float(found[-1].max())
    bad = (found[-1] > aim(problem)) & (problem.line.h > SAME_LENGTH * SHORTEST * problem.scene.mesh.length)
    needless = len(vertices) - 1 < FEWER * problem.line.cells
    if not (bad.any() or needless) or len(vertices) > MOST_CELLS or np.array_equal(vertices, problem.line.vertices):
        return None, worst
    return vertices, worst


def regraded(vertices: Array, wanted: Array) -> Array:
    """Return vertices whose cells have about the wanted lengths (of the present cells), neighbours alike."""
    wanted = wanted.copy()
    middle = 0.5 * (vertices[1:] + vertices[:-1])
    slope = COARSEST - 1.0
    for k in range(1, len(wanted)):  # a cell grows by no more than its distance from a short one allows
        wanted[k] = min(wanted[k], wanted[k - 1] + slope * (middle[k] - middle[k - 1]))
    for k in range(len(wanted) - 2, -1, -1):
        wanted[k] = min(wanted[k], wanted[k + 1] + slope * (middle[k + 1] - middle[k]))
    return of_density(vertices, 1.0 / wanted, least=4, most=MOST_CELLS)
