"""Plan of one particle: shells, reactions, what is left out."""

from __future__ import annotations

from dataclasses import dataclass

from contbed.plan_text import plan_text
from contbed.single_particle.scene import SingleParticleScene
from contbed.solvers.linear import Policy


@dataclass(frozen=True)
class Plan:
    """The scene and the choices."""

    scene: SingleParticleScene
    built: tuple[tuple[str, str], ...]
    skipped: tuple[tuple[str, str], ...]
    mesh: None = None
    steps: bool = False

    @property
    def policy(self) -> Policy:
        """Choice of the linear solver."""
        return Policy(1)

    def unknowns(self) -> dict[str, int]:
        """Return the number of unknowns: temperature, constituents and flow of gas
        of each shell, and the surface.
        """
        return {
            "particle": (len(self.scene.solid.constituent) + 2)
            * self.scene.single_particle.cells
            + 1
        }

    def __str__(self) -> str:
        return plan_text(self)


def plan(scene: SingleParticleScene) -> Plan:
    """Say what is built for a scene."""
    cells = scene.single_particle.cells
    constituents = scene.solid.constituent
    skipped = []
    built = [
        (
            "particle",
            f"{cells} shells, {len(constituents)} constituents, transient, TR-BDF2",
        )
    ]
    if scene.reactions:
        built.append(("reactions", f"{len(scene.reactions)} of first order"))
    else:
        skipped.append(("reactions", "no [reactions] table"))
    if scene.surface.fixed_temperature is not None:
        built.append(("surface", "held at the temperature given"))
    else:
        how = "convection" + (
            " and radiation" if scene.surface.emissivity is not None else ""
        )
        built.append(("surface", f"heated by {how}"))
    if scene.gas.heat_capacity == 0.0:
        skipped.append(("heat carried by the gas", "gas.heat_capacity is 0"))
    return Plan(scene, tuple(built), tuple(skipped))
