"""Error against CPU, contbed beside OpenFOAM's twoPhaseEulerFoam, for two problems with
exact solutions.

Settling of glass in water and a Riemann problem of a granular gas, in columns 20 cells
wide, over grids and Courant numbers. One process with one thread each; CPU of all steps
but the first.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.errors import SceneError
from contbed.models import plan
from studies import _gallery as gallery
from studies._gallery import Table, Tables, openfoam

HERE = Path(__file__).parent
WIDTH = 20  # cells across
POINTS = 100  # at which the exact profile of a cell is averaged
OWN, PEER = (0.1, 0.25, 0.5, 0.9, 1.0), (0.2, 0.5, 1.0, 2.0, 5.0)  # Courant numbers
ENOUGH = 2.0  # CPU [s] after which a run is not repeated
REPEATS = 3
CLOSED = {
    "type": "wall",
    "solids": {"beads": {"wall": "slip"}},
    "gas": {"wall": "slip"},
}
OURS = "contbed"
COLUMNS = ("case", "program", "cells", "courant", "steps", "cpu_s", "error_L1", "lower_position", "upper_position",
           "lower_exact", "upper_exact")  # fmt: skip
NOT_COMPARED = ("cpu_s",)
Run = tuple[float, float, np.ndarray]  # CPU [s], steps and the profile of eps_s


def settled(z: np.ndarray, t: float) -> np.ndarray:
    """Sediment, suspension and clear water."""
    return np.select([z < 9.21932e-4 * t, z < 0.1 - 4.60966e-3 * t], [0.6, 0.1], 0.0)


def expanded(z: np.ndarray, t: float) -> np.ndarray:
    """Fan, shock and what lies between of isothermal gas dynamics with a velocity of
    sound of 1 m/s.
    """
    speed = (z - 0.5) / t
    fan = 0.02 * np.exp(-(np.clip(speed, -1.0, 0.34743567 - 1.0) + 1.0))
    return np.where(speed < 1.18869463, fan, 0.01)


@dataclass(frozen=True)
class Problem:
    """Columns of `grids` cells in height; fronts are where eps_s falls through the
    two `levels`.
    """

    name: str
    title: str
    grids: tuple[int, ...]
    first: float  # time step [s]
    fluid: float  # its density [kg/m3]
    exact: Callable[[np.ndarray, float], np.ndarray]
    levels: tuple[float, float]

    def scene(self, cells: int, courant: float) -> cb.Scene:
        path = HERE.parent / "two_fluid_checks" / f"{self.name}.toml"
        height = cb.load(path).mesh.length
        mesh = {
            "type": "rectangle",
            "length": WIDTH * height / cells,
            "height": height,
            "cells": [WIDTH, cells],
        }
        walls = dict.fromkeys(("left", "right", "bottom", "top"), CLOSED)
        steps = {
            "time.courant": courant,
            "time.longest": 10.0,
            "time.first": self.first,
        }
        return cb.load(
            path, {"mesh": mesh, "boundary": walls, "gas.density": self.fluid, **steps}
        )

    def own(self, cells: int, courant: float) -> Run:
        """CPU [s], steps and the profile of eps_s."""
        scene = self.scene(cells, courant)
        bed = plan(scene).bed()[0]
        began: list[float] = []
        bed.advance(
            scene.time.end, lambda bed: began or began.append(gallery.user_time())
        )
        cpu = gallery.user_time() - began[0]
        rows = np.argsort(
            np.round(bed.model.grid.centres[:, 1] / scene.mesh.height, 9), kind="stable"
        )
        return (
            cpu,
            bed.state.steps,
            bed.state.eps_s[rows].reshape(cells, WIDTH).mean(axis=1),
        )

    def peer(self, cells: int, courant: float) -> Run:
        end = self.scene(cells, 0.5).time.end
        case = openfoam.Case(
            self.name,
            WIDTH,
            cells,
            end,
            0.0,
            courant=courant,
            dt=self.first,
            largest_dt=10.0,
            walls="slip",
        )
        with tempfile.TemporaryDirectory() as folder:
            found = openfoam.run(case, Path(folder))
            eps_s = openfoam.field(case, Path(folder), "alpha.particles")
        return found["loop_cpu_s"], found["steps"], eps_s.mean(axis=1)

    def measure(self, cells: int, eps_s: np.ndarray) -> list[float]:
        """Relative L1 error, both fronts [m] and where they ought to be."""
        scene = self.scene(cells, 0.5)
        height, end = scene.mesh.height, scene.time.end
        fine = (np.arange(cells * POINTS) + 0.5) * height / (cells * POINTS)
        profile = reference(self, fine, end)
        exact = profile.reshape(cells, POINTS).mean(axis=1)
        z = (np.arange(cells) + 0.5) * height / cells
        fronts = [
            front(*pair, level)
            for pair in ((z, eps_s), (fine, profile))
            for level in self.levels
        ]
        return [float(np.abs(eps_s - exact).sum() / exact.sum()), *fronts]


def front(z: np.ndarray, eps_s: np.ndarray, level: float) -> float:
    """Where eps_s falls through the level for the last time."""
    i = int(np.flatnonzero(eps_s >= level)[-1])
    return float(
        z[i] + (eps_s[i] - level) / (eps_s[i] - eps_s[i + 1]) * (z[i + 1] - z[i])
    )


PROBLEMS = (
    Problem(
        "settling",
        "Settling of glass in water",
        (100, 200, 400),
        1e-2,
        998.0,
        settled,
        (0.35, 0.05),
    ),
    Problem(
        "riemann",
        "Riemann problem of a granular gas",
        (100, 200, 400),
        1e-3,
        1.0,
        expanded,
        (0.017, 0.012),
    ),
)


def repeated(run: Callable[..., Run], *arguments: float) -> Run:
    """A run with its median CPU; one that takes long runs once."""
    found = [run(*arguments)]
    while len(found) < REPEATS and sum(cpu for cpu, *_ in found) < ENOUGH:
        found.append(run(*arguments))
    return float(np.median([cpu for cpu, *_ in found])), *found[-1][1:]


def reference(problem: Problem, z: np.ndarray, t: float) -> np.ndarray:
    """Exact eps_s of a problem at heights z [m] and time t [s]."""
    return problem.exact(z, t)


def compute() -> Tables:
    """Both programs over grids and Courant numbers; the committed rows of the peer
    are kept where it is missing.
    """
    try:
        PROBLEMS[0].scene(100, 1.01)
    except SceneError as refused:
        print(refused)
    programs = {OURS: ("own", OWN)} | (
        {openfoam.SOLVER: ("peer", PEER)} if openfoam.available() else {}
    )
    rows = []
    for problem in PROBLEMS:
        problem.own(20, 0.5)  # compiles
        for program, (run, numbers) in programs.items():
            for cells in problem.grids:
                for courant in numbers:
                    cpu, steps, eps_s = repeated(getattr(problem, run), cells, courant)
                    found = [courant, int(steps), cpu, *problem.measure(cells, eps_s)]
                    rows.append([problem.name, program, cells, *found])
                    print(*rows[-1][:6], flush=True)
    new = Table(dict.fromkeys(COLUMNS, ".5g") | {"steps": "d"}, rows)
    return {
        "results": Table.read(HERE / "results.csv").updated(new, ["case", "program"])
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Error over CPU, one figure for each problem."""
    return {
        problem.name: plot_problem(
            problem, tables["results"].where({"case": problem.name})
        )
        for problem in PROBLEMS
    }


def plot_problem(problem: Problem, table: Table) -> Any:
    """Error over CPU of one problem; the numbers are Courant numbers."""
    figure, axes = gallery.figure(size=(9.0, 5.0))
    shades = (
        gallery.shades(3, "Blues", 0.5, 0.95),
        gallery.shades(3, "Oranges", 0.5, 0.9),
    )
    for program, colours, mark in zip(
        (OURS, openfoam.SOLVER), shades, "os", strict=True
    ):
        for cells, colour in zip(problem.grids, colours, strict=True):
            mine = table.where({"program": program, "cells": cells})
            x, y = mine["cpu_s"], mine["error_L1"]
            axes.loglog(
                x, y, mark + "-", color=colour, label=f"{program}, {cells} cells"
            )
            for i in (0, -1):
                gallery.label_line(
                    axes, f"{mine['courant'][i]:g}", x[i], y[i], "black", (4, 4)
                )
    axes.set_xlabel("CPU of the run [s]; numbers: Courant number")
    axes.set_ylabel("L1 error of eps_s, relative [1]")
    axes.set_title(problem.title)
    axes.grid(True, which="both", alpha=0.3)
    figure.legend(loc="outside right upper")
    return figure
