"""Plan of a medium that radiates by itself: mesh, level of the radiation, what is left out."""

from __future__ import annotations

from dataclasses import dataclass

from contbed.mesh.build import build, require_names
from contbed.mesh.mesh import Mesh
from contbed.models import described
from contbed.radiation.grading import nodes
from contbed.radiation.scene import Radiation, RadiationScene
from contbed.solvers.cost import advice
from contbed.solvers.linear import Policy

NAMES = {"p1": "P1", "two_flux": "two-flux"}


@dataclass(frozen=True)
class Plan:
    """The scene as written (`scene`), the scene at the level that is solved (`solved`), the mesh and the choices."""

    scene: RadiationScene
    solved: RadiationScene
    mesh: Mesh
    built: tuple[tuple[str, str], ...]
    skipped: tuple[tuple[str, str], ...] = (("porous flow", "[radiation] alone"), ("two-energy", "no [heat] table"))
    without_weak_form: str = ""
    steps: bool = False

    @property
    def coordinate(self) -> str:
        """Name of the coordinate along the medium."""
        return "z" if self.mesh.axisymmetric else "x"

    @property
    def policy(self) -> Policy:
        """Choice of the linear solver."""
        from contbed.fem import policy

        return policy(self.mesh, self.scene.solver.memory_GB)

    def unknowns(self) -> dict[str, int]:
        """Return the number of unknowns: G or the intensities, and the temperature where the medium conducts."""
        from contbed.fem.elements import Space

        table = self.solved.radiation
        directions = {"ordinates": table.ordinates, "rosseland": 1}.get(table.level, 1)
        conducting = table.level != "rosseland" and bool(table.conductivity)
        return {"radiation": (directions + conducting) * Space(self.mesh.skfem, self.scene.solver.degree).size}

    def __str__(self) -> str:
        return described(self, advice(self.unknowns(), self.policy))


def plan(scene: RadiationScene) -> Plan:
    """Choose the level of the radiation and build the mesh.

    Raises
    ------
    SceneError : the mesh cannot be used, or has no boundary of a name in the scene
    """
    written, thick = scene, ""
    if scene.radiation.allow_rosseland:
        from contbed.radiation.rosseland import choose

        scene, thick = choose(scene)
    mesh = build(scene.mesh, nodes(scene), str(scene.origin.base))
    require_names(scene.origin, mesh, {"boundary": scene.boundary})
    cells = f"{mesh.skfem.nelements} cells, boundaries {', '.join(mesh.boundaries)}"
    table = scene.radiation
    if table.level == "rosseland":
        how = "Rosseland limit: a conductivity of the medium"
    elif table.temperature:
        how = f"{level_name(table)}, medium of given temperature"
    else:
        how = f"{level_name(table)}, medium {'conducting' if table.conductivity else 'in radiative equilibrium'}"
    built = ((f"mesh, {mesh.skfem.dim()}-D", cells), ("radiation", f"{how}; {thick}" if thick else how))
    return Plan(written, scene, mesh, built)


def level_name(table: Radiation) -> str:
    """Return the name of a level other than Rosseland's in words."""
    return NAMES.get(table.level, f"{table.ordinates} + {table.ordinates} ordinates")
