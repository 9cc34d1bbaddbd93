"""Mesh convergence of one scene: difference, observed order and wall time on a
sequence of meshes.

    contbed converge scene.toml --levels 5

Every level halves the cells of the one before. Prescribed cells are doubled in number;
the grading of an automatic mesh starts at its coarsest and is refined uniformly, so
that the first levels already show the order and not the tolerance of the scene. The
difference is the largest one of the profiles along the bed between successive levels,
at the points of the first one. Time steps stay as the scene has them.
"""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contbed.errors import SceneError
from contbed.fields import header
from contbed.loading import load
from contbed.many.tables import aligned
from contbed.mesh.grading import GRADING_ERROR
from contbed.models import plan as make_plan
from contbed.output.folder import prepare_study
from contbed.runner import run
from contbed.scene.tables import SceneBase

TIME = header("t")
LEAST_SCALE = 1e-9  # of a column; fractions below are what rounding leaves of a species


@dataclass(frozen=True)
class Level:
    """One mesh: mean cell size [m], unknowns, difference (nan on the first),
    observed order, wall time [s].
    """

    h: float
    unknowns: int
    difference: float
    order: float
    wall: float


@dataclass(frozen=True)
class Convergence:
    """All levels, and of what the differences are, for people."""

    levels: tuple[Level, ...]
    measure: str

    def __str__(self) -> str:
        rows = [("h [m]", "unknowns", "difference", "order", "wall [s]")]
        for level in self.levels:
            difference, order = (
                "" if np.isnan(value) else format(value, form)
                for value, form in ((level.difference, ".3e"), (level.order, ".2f"))
            )
            wall = f"{level.wall:.3f}"
            rows.append(
                (f"{level.h:.4e}", str(level.unknowns), difference, order, wall)
            )
        return "\n".join([self.measure, *aligned(rows, left=())])

    def columns(self) -> dict[str, list[float]]:
        """Return the table by header."""
        units = {
            "h": "m",
            "unknowns": "1",
            "difference": "1",
            "order": "1",
            "wall": "s",
        }
        return {
            f"{name} [{unit}]": [getattr(level, name) for level in self.levels]
            for name, unit in units.items()
        }


def converge(
    scene: str | Path,
    levels: int = 4,
    out: str | Path | None = None,
    trust: bool = False,
    allow_large: bool = False,
) -> Convergence:
    """Solve a scene on `levels` meshes; writes convergence.csv and convergence.png into
    `out`.

    `trust` and `allow_large` are those of `contbed.loading.load`.

    Raises
    ------
    SceneError, ConvergenceError, ClosureRangeError, BalanceError : as a run of the
        scene does
    """
    first = load(scene, trust=trust, allow_large=allow_large)
    plan: Any = make_plan(_at_level(scene, first, 0))
    if plan.mesh is None and plan.scene.mesh.cells is None:
        raise SceneError(
            f"{scene}: the cells of this bed follow its errors; give mesh.cells, which "
            "are doubled"
        )
    if out is not None:
        prepare_study(Path(out), "convergence.csv", "convergence.png")
    rows: list[Level] = []
    before: dict[str, Any] | None = None
    points: tuple[float, ...] = ()
    for k in range(levels):
        start = clock.perf_counter()
        result = run(_at_level(scene, first, k, points))
        wall = clock.perf_counter() - start
        coordinate, columns = _compared(result.profiles)
        points = points or tuple(np.unique(coordinate))
        difference = float("nan") if before is None else _distance(columns, before)
        before = columns
        h = _cell_size(result.plan)
        order = (
            float(np.log(rows[-1].difference / difference) / np.log(rows[-1].h / h))
            if rows and difference > 0
            else float("nan")
        )
        rows.append(
            Level(h, sum(result.plan.unknowns().values()), difference, order, wall)
        )
    names = ", ".join(name.split(" [")[0] for name in columns)
    measure = f"largest difference from the level before: {names}"
    found = Convergence(tuple(rows), measure)
    if out is not None:
        _write(found, Path(out), first.title)
    return found


def _at_level(
    path: str | Path, scene: Any, level: int, points: Sequence[float] = ()
) -> SceneBase:
    mesh = getattr(scene, "mesh", None)
    if mesh is None:
        remedy = (
            "; vary solver.cells" if "cells" in type(scene.solver).model_fields else ""
        )
        raise SceneError(
            f"{path}: a scene of kind {scene.kind} has no [mesh] to refine{remedy}"
        )
    if "positions" not in type(scene.output).model_fields:
        raise SceneError(
            f"{path}: a scene of kind {scene.kind} has no profiles at given positions "
            "to compare; `contbed run SCENE --set mesh.refine=1` halves its cells, and "
            "named results show what that changes"
        )
    changes: dict[str, Any] = (
        {"solver.adapt": 0} if "adapt" in type(scene.solver).model_fields else {}
    )
    cells = getattr(mesh, "cells", None)
    if cells is not None:
        changes["mesh.cells"] = (np.asarray(cells) * 2**level).tolist()
    else:
        changes |= {
            "mesh.refine": mesh.refine + level,
            "solver.tolerance": max(scene.solver.tolerance, GRADING_ERROR),
        }
    if points and not scene.output.positions:
        changes["output.positions"] = list(points)
    return load(
        path, changes, trust=scene.origin.trust, allow_large=scene.origin.allow_large
    )


def _cell_size(plan: Any) -> float:
    """Return the mean size of the cells [m]; of a reacting bed those of one length."""
    if plan.mesh is None:
        return float(plan.scene.mesh.length / plan.problem.line.cells)
    return float(
        (plan.mesh.measure() / plan.mesh.skfem.nelements)
        ** (1.0 / plan.mesh.skfem.dim())
    )


def _compared(profiles: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
    """Return the coordinate, and the columns that are compared: theta, or temperatures
    and fractions, or the velocity.

    Mole and mass fractions are there in a bed whose temperature may be the same
    everywhere.
    """
    coordinate, *names = (name for name in profiles if name != TIME)
    for prefixes in ("theta_", ("T_", "x_", "w_"), "u "):
        if chosen := {
            name: profiles[name] for name in names if name.startswith(prefixes)
        }:
            break
    return profiles[coordinate], chosen


def _distance(columns: dict[str, Any], reference: dict[str, Any]) -> float:
    """Return the largest difference of any column; theta as it is, others over their
    largest value.
    """
    scales = {
        name: max(np.abs(value).max(), LEAST_SCALE) for name, value in reference.items()
    }
    scales |= {name: 1.0 for name in columns if name.startswith("theta_")}
    return max(
        float(np.abs(columns[name] - reference[name]).max() / scales[name])
        for name in columns
    )


def _write(found: Convergence, out: Path, title: str) -> None:
    from contbed.output.plots import error_plot
    from contbed.output.tables import write_table

    columns = found.columns()
    write_table(out / "convergence.csv", columns)
    label = "difference between levels"
    curve = {label: (columns["h [m]"], columns["difference [1]"])}
    error_plot(out / "convergence.png", curve, "cell size [m]", label, title)
