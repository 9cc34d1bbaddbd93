"""Dynamic h-adaptivity: the cells of a coarse mesh are bisected repeatedly where the
error indicator is large.

After a step the jumps between cells and the highest modes of all fields are taken over
the sizes that errors of steps refer to. Where one is larger than what is aimed at, the
step is repeated on cells that are shorter there, with some room for a front that moves,
and longer where errors are small. Cells that stay as they were keep their state to
rounding, and those that are divided what they hold at each place; only cells that are
joined lose something of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from contbed.arrays import Array
from contbed.reacting_bed.cells import COARSEST, aim, errors, wanted_lengths
from contbed.reacting_bed.course import Course
from contbed.reacting_bed.history import BedHistory
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.remap import transferred

FEWEST = 8  # cells of a bed in time, a power of 2
# cell in time over the bed: steps of a front that has no width are as short
SHORTEST = 2.0**-10
# lengths of a short cell around it in which others are as short, so that a front can
# move
ROOM = 3.0
# lengths of cells in time over those before: errors of long cells lie in a part of them
FINER, COARSER = 0.25, 4.0
FEWER = 0.8  # of the present cells, below which fewer are taken although none needs it
SAME_LENGTH = 1.0 + 1e-6


def halved(vertices: Array, wanted: Array) -> Array:
    """Return vertices of repeatedly bisected first cells, none longer than is wanted
    there (N,), with room beside it.

    `vertices` are the present ones; away from a short cell lengths grow by no more than
    the distance.
    """
    start, length = vertices[0], vertices[-1] - vertices[0]
    parts, size, done = np.arange(FEWEST) / FEWEST, 1.0 / FEWEST, []
    while len(parts):
        low = start + length * parts[:, None]
        beyond = np.maximum(vertices[:-1] - (low + length * size), low - vertices[1:])
        allowed = (
            wanted + (COARSEST - 1.0) * np.maximum(beyond - ROOM * wanted, 0.0)
        ).min(axis=1)
        long = (length * size > SAME_LENGTH * allowed) & (size > SHORTEST)
        done.append(parts[~long])
        size *= 0.5
        parts = np.concatenate([parts[long], parts[long] + size])
    found: Array = start + length * np.append(np.sort(np.concatenate(done)), 1.0)
    return found


def following(
    problem: Problem, states: Sequence[Array], sizes: Array
) -> tuple[Array | None, float]:
    """Return vertices of better cells for the states of a step, None where they are
    good, and the error of the last.

    The error is over sizes of the unknowns (m,).
    """
    found = [errors(problem, u, sizes) for u in states]
    wanted = wanted_lengths(problem, np.maximum.reduce(found), FINER, COARSER)
    vertices, worst = halved(problem.line.vertices, wanted), float(found[-1].max())
    bad = (found[-1] > aim(problem)) & (
        problem.line.h > SAME_LENGTH * SHORTEST * problem.scene.mesh.length
    )
    needless = len(vertices) - 1 < FEWER * problem.line.cells
    if not (bad.any() or needless) or np.array_equal(vertices, problem.line.vertices):
        return None, worst
    return vertices, worst


def fitted(course: Course) -> Course:
    """Return the course on cells that fit the state at the start, where cells follow
    errors.
    """
    for _ in range(course.rounds):
        u = course.start()
        better, _ = following(course.problem, [u], course.sizes(u))
        if better is None:
            break
        course = replace(course, problem=course.problem.on(better))
    return course


def on_cells(
    course: Course, history: BedHistory, vertices: Array
) -> tuple[Course, BedHistory]:
    """Return the course and the history on other cells, which hold the same.

    Raises
    ------
    ConvergenceError : no state there holds so much
    """
    old, damping = course.problem.line, history.damping
    problem, u = transferred(course.problem, history.state, vertices)
    for pellets in problem.pellets.values():
        pellets.known.clear()  # of other points
    first = np.searchsorted(old.vertices, vertices[:-1], side="right") - 1
    last = np.searchsorted(old.vertices, vertices[1:], side="left")
    spans = [slice(a, b) for a, b in zip(first, last, strict=True)]
    return replace(course, problem=problem), replace(
        history,
        state=u,
        stage=None,
        vertices=vertices,
        pressure=problem.bed.gas_pressure,
        damping=np.array([damping[:, cells].max(axis=1) for cells in spans]).T,
        damped=np.array([history.damped[cells].any() for cells in spans]),
        changes=history.changes + 1,
    )
