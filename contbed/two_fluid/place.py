"""Where the steps of a bed are computed: on this process, unless `contbed.ranks`
shares the bed among several.
"""

from __future__ import annotations

from collections.abc import Sequence

from contbed.compiled import threads
from contbed.mesh.mesh import Mesh
from contbed.two_fluid import momentum_budget
from contbed.two_fluid.averages import Averages
from contbed.two_fluid.closure_kernels import GuardCounts, ParticleProperties
from contbed.two_fluid.fv.grid import Grid, build
from contbed.two_fluid.linear.pressure_solver import uses_elimination
from contbed.two_fluid.model import Model
from contbed.two_fluid.scene import TwoFluidScene
from contbed.two_fluid.simulation import Simulation


class Place:
    """One process, which has the whole grid."""

    def grid(self, mesh: Mesh, pairs: Sequence[tuple[str, str]]) -> tuple[Grid, Place]:
        """Return the grid of a mesh with pairs of periodic boundaries, and the place
        that computes on it.
        """
        return build(mesh, pairs), self

    def described(self, cells: Grid) -> list[tuple[str, str]]:
        """Return what solves for the pressure, and on how many cores."""
        how = (
            "elimination"
            if uses_elimination(cells)
            else "conjugate gradients with multigrid"
        )
        return [
            ("pressure", f"{how}, band of {cells.bandwidth} cells"),
            ("threads", _threads(cells)),
        ]

    def simulation(
        self,
        model: Model,
        scene: TwoFluidScene,
        particles: ParticleProperties,
        counts: GuardCounts,
    ) -> Simulation:
        """Return the bed of a model; `counts` get how often limits of its closures
        acted.
        """
        return Simulation(model)

    def averages(self, bed: Simulation, start: float, end: float) -> Averages:
        """Return averages of a bed from `start` to `end` [s]."""
        return Averages(start, end, momentum=momentum_budget.momentum(bed))


ONE_PROCESS = Place()


def _threads(cells: Grid) -> str:
    """Return on how many cores a step is computed, and why."""
    count, allowed, number = (
        len(cells.cells),
        threads.count(),
        threads.count(len(cells.cells)),
    )
    if not cells.rectangular:
        return (
            "1: the mesh is not a rectangular grid, whose rows are shared among cores"
        )
    if number == 1:
        why = (
            "one core is allowed"
            if allowed == 1
            else f"below {2 * threads.LEAST} cells, sharing costs more than it saves"
        )
        return f"1: {why}"
    few = (
        f", {allowed} are allowed: each takes at least {threads.LEAST} cells"
        if number < allowed
        else ""
    )
    return f"{number}, each takes {count // number} cells{few}"
