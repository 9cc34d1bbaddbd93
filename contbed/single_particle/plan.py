"""Plan of one particle: shells, reactions, what is left out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from contbed.plan_text import Rows, built_and_skipped, plan_text
from contbed.single_particle.scene import SingleParticleScene
from contbed.solvers.linear import Policy


@dataclass(frozen=True)
class Plan:
    """The scene and the choices."""

    scene: SingleParticleScene
    built: Rows
    skipped: Rows
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
    return Plan(scene, *built_and_skipped(_parts(scene)))


def _parts(scene: SingleParticleScene) -> Iterator[tuple[str, str, bool]]:
    """Yield the parts of a particle, see `built_and_skipped`."""
    cells, count = scene.single_particle.cells, len(scene.solid.constituent)
    text = f"{cells} shells, {count} constituents, transient, TR-BDF2"
    yield "particle", text, True
    count = len(scene.reactions)
    text = f"{count} of first order" if count else "no [reactions] table"
    yield "reactions", text, count > 0
    if scene.surface.fixed_temperature is not None:
        yield "surface", "held at the temperature given", True
    else:
        radiates = scene.surface.emissivity is not None
        how = "convection and radiation" if radiates else "convection"
        yield "surface", f"heated by {how}", True
    if scene.gas.heat_capacity == 0.0:
        yield "heat carried by the gas", "gas.heat_capacity is 0", False
