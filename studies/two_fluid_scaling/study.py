"""CPU of a step of the two-fluid model over the number of cells, and of three solvers
of its pressure.

Each size takes a few steps from the start of a bed in 2-D or 3-D and then solves the
last equation of pressure by elimination, by the project's sparse factors in nested
dissection and by multigrid. CPU of one process with one thread, medians; compilation is
left out. Elimination and sparse factors are left out where a solution would take more
than some seconds.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import scipy.sparse as sp

import contbed as cb
from contbed.models import plan
from contbed.solvers.linear import Policy, Solver
from contbed.solvers.ordering import nested_dissection
from contbed.two_fluid.fv.grid import Grid
from contbed.two_fluid.linear.elimination import Elimination
from contbed.two_fluid.linear.pressure_solver import PressureSolver, multigrid_on
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
SIZES = {
    "bed": [(37, 133), (56, 200), (84, 300), (118, 423), (187, 667), (374, 1336)],
    "box": [(12, 12, 36), (16, 16, 48), (20, 20, 60), (34, 34, 102), (54, 54, 162)],
}
STEPS, FIRST = 9, 4  # taken, and those of them that are left out
NOT_COMPARED = (
    "us_per_cell_step",
    "pressure_share",
    "elimination_ms",
    "sparse_direct_ms",
    "multigrid_ms",
)
DENSEST = 5e10  # cells times band^2 up to which elimination is tried
FACTORED = {"bed": 600_000, "box": 40_000}  # cells up to which sparse factors are tried
COLUMNS = ("case", "cells", "band", "us_per_cell_step", "pressure_share", "policy", "iterations", "elimination_ms",
           "sparse_direct_ms", "multigrid_ms")  # fmt: skip


class Watched(PressureSolver):
    """The solver of the model, with the time that it takes and its last equation."""

    def solve(self, coef: Any, rhs: Any, guess: Any) -> Any:
        """Solve and keep equation and CPU [s]."""
        begin = gallery.user_time()
        p = super().solve(coef, rhs, guess)
        self.seconds, self.last = gallery.user_time() - begin, (coef, rhs.copy(), guess)
        return p


def matrix(grid: Grid, coef: np.ndarray) -> sp.csc_matrix:
    """The equation as a sparse matrix."""
    g, count = grid.geometry, len(grid.cells)
    left, right, inner = g.left[: grid.interior], g.right, coef[: grid.interior]
    diagonal = np.bincount(g.left, coef, count) + np.bincount(right, inner, count)
    links = sp.coo_matrix((-inner, (left, right)), (count, count))
    return sp.csc_matrix(sp.diags(diagonal) + links + links.T)


def reference(whole: sp.csc_matrix, rhs: np.ndarray, dimension: int, order: Any) -> Any:
    """The equation solved by the project's sparse factors, with which the other
    solvers are compared.
    """
    return Solver(whole, Policy(dimension, None, order))(rhs)


def milliseconds(work: Any) -> float:
    """Median CPU of some work [ms]."""
    return 1e3 * gallery.cpu(work, long=5.0).seconds


def measure(case: str, cells: tuple[int, ...]) -> dict[str, object]:
    """One row."""
    bed, _ = plan(cb.load(HERE / f"{case}.toml", {"mesh.cells": list(cells)})).bed()
    grid, watched = (
        bed.model.grid,
        Watched(bed.model.grid, bed.model.pressure_solver.floating),
    )
    bed.model = replace(bed.model, pressure_solver=watched)
    steps, solutions = [], []
    for _ in range(STEPS):
        begin = gallery.user_time()
        bed.step(bed.next_step())
        steps.append(gallery.user_time() - begin)
        solutions.append(watched.seconds)
    coef, rhs, guess = watched.last
    count, width = len(grid.cells), grid.bandwidth
    iterative = multigrid_on(grid)
    row = {
        "case": case,
        "cells": count,
        "band": width,
        "us_per_cell_step": 1e6 * median(steps[FIRST:]) / count,
        "pressure_share": median(solutions[FIRST:]) / median(steps[FIRST:]),
        "policy": "elimination"
        if isinstance(watched.method, Elimination)
        else "multigrid",
        "iterations": iterative.solve(coef, watched.floating, rhs, guess.copy()),
        "multigrid_ms": milliseconds(
            lambda: iterative.solve(coef, watched.floating, rhs, guess.copy())
        ),
    }
    if count * width**2 < DENSEST:
        direct = Elimination(grid)
        row["elimination_ms"] = milliseconds(
            lambda: direct.solve(grid.geometry, coef, watched.floating, rhs.copy())
        )
    if count <= FACTORED[case]:
        pairs = np.stack((grid.geometry.left[: grid.interior], grid.geometry.right))
        order = nested_dissection(grid.middles[: grid.interior].T, [pairs], count)
        whole = matrix(grid, coef)
        row["sparse_direct_ms"] = milliseconds(
            lambda: reference(whole, rhs, grid.dimension, order)
        )
    return row


def compute() -> Tables:
    """All sizes."""
    rows = []
    for case, sizes in SIZES.items():
        measure(case, tuple(6 for _ in sizes[0]))  # compiles
        for cells in sizes:
            rows.append(measure(case, cells))
            print(
                {
                    name: f"{v:.3g}" if isinstance(v, float) else v
                    for name, v in rows[-1].items()
                },
                flush=True,
            )
    whole = dict.fromkeys(("cells", "band", "iterations"), "d")
    return {
        "results": Table(
            dict.fromkeys(COLUMNS, ".3g") | whole,
            [[row.get(name) for name in COLUMNS] for row in rows],
        )
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Cost of a step and of the solvers."""
    figure, panels = gallery.figure(1, 3, size=(10, 3.4))
    for case, text, colour in (
        ("bed", "2-D", gallery.BLUE),
        ("box", "3-D", gallery.VERMILION),
    ):
        mine = tables["results"].where({"case": case})
        cells = mine["cells"]
        panels[0].semilogx(
            cells, mine["us_per_cell_step"], "o-", color=colour, label=text
        )
        panels[1].semilogx(
            cells, 100 * mine["pressure_share"], "o-", color=colour, label=text
        )
        for solver, style in (
            ("elimination", "s-"),
            ("sparse_direct", "^:"),
            ("multigrid", "o--"),
        ):
            name = f"{solver.replace('_', ' ')}, {text}"
            panels[2].loglog(
                cells,
                1e3 * mine[f"{solver}_ms"] / cells,
                style,
                color=colour,
                label=name,
            )
    panels[0].set(ylabel="CPU of a step for each cell [us]", ylim=(0, None))
    panels[1].set(ylabel="share of the pressure [%]", ylim=(0, 100))
    panels[2].set_ylabel("CPU of a solution for each cell [us]")
    panels[2].legend(fontsize="xx-small")
    panels[0].legend()
    for axes in panels:
        axes.set(xlabel="cells")
        axes.grid(alpha=0.3)
    return {"scaling": figure}
