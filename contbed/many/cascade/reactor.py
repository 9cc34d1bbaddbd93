"""What packings of particles give a reactor, and what they take from it, by the kind of
its scene.

A packed or moving bed is the packing. Of a bubbling bed the emulsion is: gas passes its
particles at about the voidage of minimum fluidization, which is that of a loose
packing, so that the solids fraction of the emulsion, its conductivity at rest and the
exchange of each solid phase with the gas around it are those of packings. What
particles do when they move, their mixing, stays as the scene has it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from contbed.bubbling_bed.scene import BubblingScene
from contbed.packed_bed.scene import Scene

CONDUCTIVITY, NUSSELT = "conductivity", "nusselt"  # kinds of the closures
POROSITY, SOLIDS_FRACTION = "packed_bed.porosity", "bubbling_bed.solids_fraction"


@dataclass(frozen=True)
class Reactor:
    """Keys of a scene that closures of packings stand at, and the particles that it
    has.

    places : keys by the kind of closure
    diameter : Sauter mean [m]
    density : of the particles [kg/m3]
    porosity : before there are packings
    bubbling : whether packings are the emulsion of a bubbling bed
    """

    places: Mapping[str, tuple[str, ...]]
    diameter: float
    density: float
    porosity: float
    bubbling: bool

    def at(self, porosity: float) -> dict[str, Any]:
        """Return the change of the scene that gives it the porosity of packings."""
        return (
            {SOLIDS_FRACTION: 1.0 - porosity} if self.bubbling else {POROSITY: porosity}
        )


def reactor(scene: Scene | BubblingScene) -> Reactor:
    """Return what packings give a scene; of a bubbling bed each solid phase has the
    mean diameter of all.
    """
    places: dict[str, tuple[str, ...]]
    if isinstance(scene, Scene):
        assert scene.solid.density is not None  # `heat` needs it
        places = {
            CONDUCTIVITY: ("closures.conductivity_solids",),
            NUSSELT: ("closures.nusselt",),
        }
        return Reactor(
            places,
            scene.diameter,
            scene.solid.density,
            scene.packed_bed.porosity,
            False,
        )
    present = scene.present
    places = {
        CONDUCTIVITY: ("bubbling_bed.conductivity",),
        NUSSELT: tuple(f"solids.{name}.nusselt" for name in present),
    }
    surface = sum(item.volume_share / item.diameter for item in present.values())
    density = sum(
        item.volume_share * float(item.density or 0.0) for item in present.values()
    )
    return Reactor(
        places, 1.0 / surface, density, 1.0 - scene.bubbling_bed.solids_fraction, True
    )


def why_not(scene: Any) -> str:
    """Return why packings can give a scene nothing; empty if they can."""
    if isinstance(scene, BubblingScene):
        if scene.computed:
            return ""
        inlet = "boundary.bottom.gas"
        return (
            f"coefficients of a bed with {inlet}.capacity_flow are numbers; give "
            f"{inlet}.mass_flow"
        )
    if not isinstance(scene, Scene) or scene.heat is None:
        return (
            "a cascade ends in a packed or moving bed with [heat], or in a bubbling bed"
        )
    if scene.solid.shape != "spheres":
        return (
            "the packings are of spheres, but the shape of the solid is "
            f"{scene.solid.shape!r}"
        )
    return ""
