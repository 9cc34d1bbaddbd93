"""Plan of a fully developed flow: coefficients, and a line from centre to wall that
is finer towards the wall.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import skfem

from contbed.developed_flow import scene as d
from contbed.developed_flow.closures import bound
from contbed.developed_flow.equations import Coefficients
from contbed.mesh.mesh import Mesh
from contbed.plan_text import plan_text
from contbed.scene.mesh import REGION

GRADED = 3.5  # of tanh: the last cell is thinner than the first by a factor of cosh^2


@dataclass(frozen=True)
class DevelopedPlan:
    """The scene, mesh and coefficients that a run uses."""

    scene: d.DevelopedScene
    coefficients: Coefficients
    mesh: Mesh
    built: tuple[tuple[str, str], ...]
    skipped: tuple[tuple[str, str], ...]
    steps: bool = False

    @property
    def policy(self) -> Any:
        """Choice of the linear solver."""
        from contbed.fem import policy

        return policy(self.mesh, None)

    def unknowns(self) -> dict[str, int]:
        """Count the unknowns: two velocities, the root of the granular temperature,
        and two numbers.
        """
        nodes = self.scene.solver.degree * self.mesh.skfem.nelements + 1
        return {
            "flow": 3 * nodes + 2
            if self.scene.developed_flow.solids_mass_flux
            else nodes + 1
        }

    def on(self, nodes: np.ndarray) -> DevelopedPlan:
        """Return the plan on other nodes."""
        return replace(self, mesh=line(nodes, self.mesh.axisymmetric))

    def __str__(self) -> str:
        return plan_text(self)


def plan(scene: d.DevelopedScene) -> DevelopedPlan:
    """Build the mesh and resolve closures."""
    table, turbulence = scene.developed_flow, scene.closures.turbulence
    even = np.linspace(0.0, 1.0, scene.solver.cells + 1)
    mesh = line(
        table.radius * np.tanh(GRADED * even) / np.tanh(GRADED), table.section == "pipe"
    )
    built = [
        (
            "section",
            f"{table.section}, {scene.solver.cells} cells of degree "
            f"{scene.solver.degree}",
        )
    ]
    skipped = []
    particles = (
        "particles",
        "two velocities and granular temperature, Newton with continuation",
    )
    if table.solids_mass_flux:
        built.append(particles)
    else:
        skipped.append((particles[0], "solids_mass_flux = 0"))
    (built if turbulence else skipped).append(
        ("turbulence of the gas", turbulence or "not named")
    )
    return DevelopedPlan(scene, coefficients(scene), mesh, tuple(built), tuple(skipped))


def coefficients(scene: d.DevelopedScene) -> Coefficients:
    """Return the coefficients of the equations from the scene."""
    table = scene.developed_flow
    fluid = scene.fluid
    solid = scene.solid
    wall = scene.boundary.wall.solid
    return Coefficients(
        rho_gas=fluid.density,
        mu_gas=fluid.viscosity,
        rho_solid=solid.density,
        d_p=solid.diameter,
        restitution=solid.restitution,
        eps_max=solid.packing_limit,
        gravity=table.gravity,
        velocity=table.gas_velocity,
        solid_flux=table.solids_mass_flux,
        radius=table.radius,
        pipe=table.section == "pipe",
        specularity=wall.specularity,
        wall_restitution=wall.restitution,
        closures=bound(scene),
    )


def line(nodes: np.ndarray, axisymmetric: bool) -> Mesh:
    """Build the mesh from centre to wall."""
    mesh = skfem.MeshLine(
        nodes[None, :], np.array([np.arange(len(nodes) - 1), np.arange(1, len(nodes))])
    )
    exterior = mesh.boundary_facets()
    place = mesh.p[0, mesh.facets[0, exterior]]
    named = {
        "centre": exterior[place == nodes[0]],
        "wall": exterior[place == nodes[-1]],
    }
    whole = {REGION: np.arange(mesh.nelements)}
    return Mesh(replace(mesh, _boundaries=named, _subdomains=whole), axisymmetric)
