"""What a scene says about the heat between walls and bed: a layer, a coefficient, or a
closure of one; and radiation.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.closures.binding import named
from contbed.closures.optics import (
    emissivity_immersed,
    radiation_emissivity_half_space,
)
from contbed.scene.tables import Closure
from contbed.two_fluid import scene as t
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.conditions import Boundary, Wall, of_kind

KIND = "bed_tube"
PENETRATION = "penetration"
GAP = "gap"  # its only parameter
GIVES = (
    "Ar",
    "Pr",
    "delta",
    "eps",
    "eps_mf",
    "d_p",
    "T",
    "p",
    "mu",
    "rho_gas",
    "cp_gas",
    "k_gas",
    "k_stagnant",
    "rho_solid",
    "cp_solid",
)
"""Arguments that closures of walls can have; others have to stand in the scene."""

EVERYWHERE = ""  # the place of closures.wall_heat
# fraction of particles, and of bubbles, below which a cell counts as having this much
FEWEST = 1e-6


def is_layer(spec: Any) -> bool:
    """Whether heat comes by the layer of `wall_layer`."""
    return (spec.name if isinstance(spec, Closure) else spec) == PENETRATION


def gap_of(spec: Any) -> float:
    """Thickness [-] of the gas between a wall and the particles of a packed bed, over
    their diameter.
    """
    given = spec.model_extra or {} if isinstance(spec, Closure) else {}
    return float(given.get(GAP, 0.0))


def specs(closures: t.Closures, boundary: dict[str, Boundary]) -> dict[str, Any]:
    """Return what is chosen for all walls, EVERYWHERE, and for those that have a choice
    of their own.
    """
    own = {
        name: part.coefficient
        for name, part in of_kind(boundary, Wall).items()
        if part.coefficient is not None
    }
    return {EVERYWHERE: closures.wall_heat, **own}


def coefficients(scene: t.TwoFluidScene) -> dict[str, Any]:
    """Return what is no layer, in the order of the numbers of wall laws."""
    found = specs(scene.closures, scene.boundary)
    return {place: spec for place, spec in found.items() if not is_layer(spec)}


def kind_at(place: str) -> str:
    """Key of the bound closure of a place."""
    return KIND if place == EVERYWHERE else f"{KIND}_{place}"


def constants(scene: t.TwoFluidScene) -> dict[str, Any]:
    """Arguments of closures of walls that do not change in a run."""
    fluid, solid, gravity = scene.fluid, scene.solid, scene.two_fluid.gravity
    buoyancy = fluid.density * (solid.density - fluid.density) * gravity
    return {
        "Ar": solid.diameter**3 * buoyancy / fluid.viscosity**2,
        "eps_mf": 1.0 - solid.friction.start,
        "p": scene.gas.pressure,
        "rho_gas": fluid.density,
        "cp_gas": fluid.heat_capacity,
        "k_gas": fluid.conductivity,
        "rho_solid": solid.density,
        "cp_solid": solid.heat_capacity,
    }


def local(
    eps_s: Array, T: Array, k_stagnant: Array, scene: t.TwoFluidScene
) -> dict[str, Array]:
    """Arguments that change from cell to cell; `delta` is what is emptier than a bed
    that begins to fluidize.
    """
    eps_s = np.maximum(eps_s, FEWEST)
    delta = np.maximum(FEWEST, 1.0 - eps_s / scene.solid.friction.start)
    return {"eps": 1.0 - eps_s, "delta": delta, "T": T, "k_stagnant": k_stagnant}


def wall_laws(scene: t.TwoFluidScene, bound: Any, given: dict[str, Any]) -> Any:
    """Return the functions of the wall laws, in the order of their numbers."""

    def law(place: str, spec: Any) -> Any:
        closure = bound.get(kind_at(place)) if named(spec) else None

        def h(eps_s: Array, T: Array, k: Array) -> Array:
            if closure is None:
                return np.full_like(eps_s, float(spec))
            found = closure(**(given | local(eps_s, T, k, scene)))
            return np.asarray(found) * np.ones_like(eps_s)

        return h

    return tuple(law(*item) for item in coefficients(scene).items())


def condition(name: str, part: Wall, scene: t.TwoFluidScene) -> dict[str, float]:
    """Return law, gap and emissivity of a wall of a given temperature, as `Thermal` has
    them.
    """
    everywhere = specs(scene.closures, scene.boundary)
    place = name if name in everywhere else EVERYWHERE
    spec = everywhere[place]
    found = {"emissivity": emissivity(part, scene.solid)}
    if not is_layer(spec):
        return found | {"law": float(list(coefficients(scene)).index(place))}
    k_gas = scene.fluid.conductivity
    assert k_gas is not None
    return found | {"gap": gap_of(spec) * scene.solid.diameter / k_gas}


def emissivity(part: Wall, solid: t.Solid) -> float:
    """Emissivity [-] of wall and bed together; 0 where one of them is not given."""
    if part.emissivity is None or solid.emissivity is None:
        return 0.0
    bed = radiation_emissivity_half_space(1.0 - solid.emissivity)
    return float(emissivity_immersed(bed, part.emissivity))
