"""Plan of a stand-alone radiating medium: mesh, level of the radiation, what is left
out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from contbed.mesh.build import mesh_of, moved, require_names
from contbed.mesh.mesh import Mesh
from contbed.plan_text import plan_text
from contbed.radiation.grading import nodes
from contbed.radiation.scene import (
    FEWEST,
    MOST,
    MOST_CONDUCTING,
    Radiation,
    RadiationScene,
)
from contbed.scene.mesh import MeshLine
from contbed.solvers.cost import advice
from contbed.solvers.linear import Policy

NAMES = {"p1": "P1", "two_flux": "two-flux"}
ADVICE = (
    'error up to 15 %. Set radiation.level = "ordinates" to meet solver.tolerance '
    "at little more cost in 1-D"
)


@dataclass(frozen=True)
class Plan:
    """The scene as written (`scene`), the scene with the ordinates that are
    solved (`solved`), the mesh and the choices.
    """

    scene: RadiationScene
    solved: RadiationScene
    mesh: Mesh
    built: tuple[tuple[str, str], ...]
    skipped: tuple[tuple[str, str], ...] = (
        ("porous flow", "[radiation] alone"),
        ("two-energy", "no [heat] table"),
    )
    steps: bool = False

    @property
    def without_ranks(self) -> str:
        """What the scene has that does not run on several ranks, as text; empty if
        there is nothing.
        """
        return (
            "discrete ordinates on a line"
            if self.solved.radiation.level == "ordinates"
            else ""
        )

    @property
    def coordinate(self) -> str:
        """Name of the coordinate along the medium."""
        return "z" if self.mesh.axisymmetric else "x"

    @property
    def policy(self) -> Policy:
        """Choice of the linear solver."""
        from contbed.fem import policy

        return replace(policy(self.mesh, self.scene.solver.memory_GB), multigrid=True)

    def unknowns(self) -> dict[str, int]:
        """Return the number of unknowns: G or the intensities, and the temperature
        where the medium conducts.
        """
        from contbed.fem.elements import Space

        table = self.solved.radiation
        directions = table.directions if table.level == "ordinates" else 1
        conducting = table.level != "rosseland" and bool(table.conductivity)
        return {
            "radiation": (directions + conducting)
            * Space(self.mesh.skfem, self.scene.solver.degree).size
        }

    def with_values(self, scene: RadiationScene) -> Plan:
        """Return the plan of a scene with other numbers on the cells of this one,
        whose nodes move with the lengths of the medium.
        """
        return replace(
            self,
            scene=scene,
            solved=scene,
            mesh=moved(self.mesh, self.solved.mesh, scene.mesh),
        )

    def with_more_ordinates(self) -> Plan | None:
        """Return the plan with twice the ordinates on a mesh for them; None where
        their number is given or enough.
        """
        table = self.solved.radiation
        now = table.directions
        if (
            table.level != "ordinates"
            or self.scene.radiation.ordinates is not None
            or now >= most(table)
        ):
            return None
        scene = self.solved.model_copy(
            update={"radiation": table.model_copy(update={"ordinates": 2 * now})}
        )
        return replace(
            self,
            solved=scene,
            mesh=mesh_of(scene, nodes(scene)),
        )

    def by_ordinates(self) -> Plan | None:
        """Return the plan of the same medium by ordinates, with which P1 and two-flux
        are compared; None where these cost more, or solve it already.
        """
        table = self.scene.radiation
        line = isinstance(self.scene.mesh, MeshLine)
        if table.level not in NAMES or not line or table.conductivity:
            return None
        update = {"level": "ordinates"}
        scene = self.scene.model_copy(
            update={"radiation": table.model_copy(update=update)}
        )
        return plan(scene)

    def __str__(self) -> str:
        return plan_text(self, advice(self.unknowns(), self.policy))


def plan(scene: RadiationScene) -> Plan:
    """Build the mesh, and say at which level the radiation is solved.

    Raises
    ------
    SceneError : the mesh cannot be used, or has no boundary of a name in the scene
    """
    mesh = mesh_of(scene, nodes(scene))
    require_names(scene.origin, mesh, {"boundary": scene.boundary})
    cells = f"{mesh.skfem.nelements} cells, boundaries {', '.join(mesh.boundaries)}"
    table = scene.radiation
    if table.level == "rosseland":
        how = "Rosseland limit: a conductivity of the medium"
    elif table.temperature:
        how = f"{level_name(table)}, medium of given temperature"
    else:
        how = (
            f"{level_name(table)}, medium "
            f"{'conducting' if table.conductivity else 'in radiative equilibrium'}"
        )
    if table.level in NAMES and isinstance(scene.mesh, MeshLine):
        how += f"; {ADVICE}"
    built = (
        (f"mesh, {mesh.skfem.dim()}-D", cells),
        ("radiation", how),
    )
    return Plan(scene, scene, mesh, built)


def most(table: Radiation) -> int:
    """Return how many ordinates in a hemisphere are tried where none are given."""
    return MOST_CONDUCTING if table.conductivity else MOST


def level_name(table: Radiation) -> str:
    """Return the name of a level other than Rosseland's in words."""
    if table.level == "ordinates" and table.ordinates is None:
        return (
            f"{FEWEST} + {FEWEST} ordinates, doubled until solver.tolerance is met, "
            f"{most(table)} of each at most"
        )
    return NAMES.get(table.level, f"{table.ordinates} + {table.ordinates} ordinates")
