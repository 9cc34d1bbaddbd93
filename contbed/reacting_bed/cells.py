"""Cells of a reacting bed that follow the errors of a state."""

from __future__ import annotations

import numpy as np

from contbed.arrays import Array
from contbed.mesh.grading import growing, of_density
from contbed.reacting_bed.problem import Problem

MOST_CELLS = 3000  # of a mesh: ten species have some 100,000 unknowns there
COARSEST = 2.5  # ratio of the lengths of neighbouring cells
# jumps are held to tolerance^ERROR_POWER: fluxes at vertices are of order 7, jumps of
# order 4
ERROR_POWER = 0.7
LEAST_SPAN = 1e-4  # of the typical size of a field, the least span that errors refer to
LEAST_RATIO = 1e-30  # of an error over what is aimed at, in a cell without any


def halves(problem: Problem) -> Array:
    """Return the vertices and the middles of the cells."""
    found: Array = np.sort(
        np.concatenate([problem.line.vertices, problem.line.points.mean(axis=1)])
    )
    return found


def moved(problem: Problem, u: Array, other: Problem) -> Array:
    """Return a state on the cells of another problem."""
    found: Array = problem.line.at(u, other.line.points.ravel()).reshape(
        len(u), *other.line.points.shape
    )
    return found


def errors(problem: Problem, u: Array, sizes: Array | None = None) -> Array:
    """Return the jumps and highest modes of the fields in each cell over sizes (m,),
    or their spans (N,).
    """
    line = problem.line
    span = (
        np.maximum(np.ptp(u, axis=(1, 2)), LEAST_SPAN * problem.sizes)
        if sizes is None
        else sizes
    )
    low, high = u @ line.left, u @ line.right
    jump = np.abs(low[:, 1:] - high[:, :-1])
    found = line.top_mode(u)
    found[:, 1:] = np.maximum(found[:, 1:], jump)
    found[:, :-1] = np.maximum(found[:, :-1], jump)
    worst: Array = (found / span[:, None]).max(axis=0)
    return worst


def next_cells(problem: Problem, u: Array) -> tuple[Array, float]:
    """Return better vertices for a state, and by how much the errors of the present
    ones exceed what is aimed at.
    """
    found = errors(problem, u)
    return better_cells(problem, found), float(found.max()) / aim(problem)


def aim(problem: Problem) -> float:
    """Return the error of a cell that is aimed at."""
    return float(problem.scene.solver.tolerance**ERROR_POWER)


def better_cells(problem: Problem, found: Array) -> Array:
    """Return vertices of cells whose errors are about what is aimed at, from those
    that were found (N,).
    """
    return regraded(problem.line.vertices, wanted_lengths(problem, found))


def wanted_lengths(
    problem: Problem, found: Array, least: float = 0.1, most: float = 2.0
) -> Array:
    """Return the lengths of cells whose errors would be about what is aimed at, from
    those that were found (N,).

    `least` and `most` are of the present lengths.
    """
    ratio = found / aim(problem)
    factor = np.clip(
        (0.5 / np.maximum(ratio, LEAST_RATIO)) ** (1.0 / (problem.line.degree + 1)),
        least,
        most,
    )
    return problem.line.h * factor


def regraded(vertices: Array, wanted: Array) -> Array:
    """Return vertices whose cells have about the wanted lengths (of the present
    cells), neighbours alike.
    """
    # a cell grows by no more than its distance from a short one allows
    steps = (COARSEST - 1.0) * np.diff(0.5 * (vertices[1:] + vertices[:-1]))
    wanted = growing(wanted, steps, steps)
    return of_density(vertices, 1.0 / wanted, least=4, most=MOST_CELLS)
