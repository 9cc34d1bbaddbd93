"""Where the steps of a two-fluid bed are computed that ranks share: see
`two_fluid.place` for one process.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from contbed.mesh.mesh import Mesh
from contbed.ranks.two_fluid.averages import SharedAverages
from contbed.ranks.two_fluid.bed import SharedSimulation
from contbed.ranks.two_fluid.division import Division
from contbed.ranks.two_fluid.grid import SharedGrid
from contbed.two_fluid.averages import Averages
from contbed.two_fluid.closure_kernels import GuardCounts, ParticleProperties
from contbed.two_fluid.fv.connections import connect
from contbed.two_fluid.fv.grid import Grid
from contbed.two_fluid.model import Model
from contbed.two_fluid.place import Place
from contbed.two_fluid.plan import TwoFluidPlan, plan
from contbed.two_fluid.scene import TwoFluidScene
from contbed.two_fluid.simulation import Simulation


@dataclass(frozen=True)
class Ranks(Place):
    """All ranks.

    Attributes
    ----------
    divided : from which ranks make their parts of the grid, before they do
    parts : the grid, once ranks have it
    """

    divided: Division | None = None
    parts: SharedGrid | None = None

    def grid(self, mesh: Mesh, pairs: Sequence[tuple[str, str]]) -> tuple[Grid, Ranks]:
        """Return the outline of the grid, which rank 0 has, and what ranks make
        their parts from.
        """
        division = Division.of(connect(mesh, pairs))
        return division.outline(), Ranks(division)

    def described(self, cells: Grid) -> list[tuple[str, str]]:
        """Return what solves for the pressure, and on how many cores."""
        return [
            ("pressure", "conjugate gradients with algebraic multigrid of PETSc"),
            ("threads", "1 on each rank"),
        ]

    def share(self, cells: Grid) -> Ranks:
        """Have each rank make its part of the grid.

        Raises
        ------
        EngineError : fewer cells than ranks
        """
        assert self.divided is not None
        return Ranks(parts=SharedGrid(self.divided, cells))

    def simulation(
        self,
        model: Model,
        scene: TwoFluidScene,
        particles: ParticleProperties,
        counts: GuardCounts,
    ) -> Simulation:
        """Return the bed of a model on the outline, whose steps run on all ranks."""
        assert self.parts is not None
        return SharedSimulation(model, self.parts, scene, particles, counts)

    def averages(self, bed: Simulation, start: float, end: float) -> Averages:
        """Return averages from `start` to `end` [s], which each rank takes of its
        own cells.
        """
        assert isinstance(bed, SharedSimulation)
        return SharedAverages(bed, start, end)


def shared_plan(scene: TwoFluidScene) -> TwoFluidPlan:
    """Return the plan of a bed whose grid ranks share.

    Raises
    ------
    SceneError : what `two_fluid.plan.plan` raises
    EngineError : fewer cells than ranks
    """
    made = plan(scene, Ranks())
    assert isinstance(made.place, Ranks)
    place = made.place.share(made.grid)
    # a copy of the mesh leaves behind the lists of faces that the grid was built from
    mesh = replace(made.mesh, skfem=replace(made.mesh.skfem))
    return replace(made, mesh=mesh, place=place)
