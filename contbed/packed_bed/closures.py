"""Closures of a packed bed: where a scene names them, and the arguments that the bed
gives them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from contbed.closures.binding import (
    BoundClosure,
    BoundDispersion,
    bind,
    bind_dispersion,
    is_phase,
    named,
)
from contbed.closures.packed_beds import GIVES
from contbed.packed_bed import scene as s
from contbed.scene.boundary import conditions_of
from contbed.scene.quantities import ClosureFile
from contbed.scene.toml_lines import KeyPath

OF_FLOW = ("permeability", "forchheimer")
OF_HEAT = (
    "dispersion",
    "nusselt",
    "conductivity_gas",
    "conductivity_solids",
    "tortuosity",
)


class At(NamedTuple):
    """What a `Medium` gives closures at a temperature of the fluid [K] and
    `speed(density)`, see `Medium.reynolds`.
    """

    medium: Any
    T: Any
    speed: Any

    @property
    def eps(self) -> float:
        """Porosity."""
        return float(self.medium.scene.packed_bed.porosity)

    @property
    def d_p(self) -> float:
        """Diameter of the particles [m]."""
        return float(self.medium.scene.diameter)

    @property
    def D_bed(self) -> float:
        """Hydraulic diameter of the bed [m]."""
        return float(self.medium.bed_diameter)

    @property
    def Re(self) -> Any:
        """Particle Reynolds number."""
        return self.medium.reynolds(self.T, self.speed)

    @property
    def Pr(self) -> Any:
        """Prandtl number of the fluid."""
        return self.medium.prandtl(self.T)

    @property
    def Pe(self) -> Any:
        """Particle Peclet number."""
        return self.Re * self.Pr

    @property
    def k_fluid(self) -> Any:
        """Conductivity of the fluid [W/m/K]."""
        return self.medium.fluid.conductivity(self.T)

    @property
    def k_solid(self) -> Any:
        """Conductivity of the particles [W/m/K]."""
        return self.medium.solid.conductivity(self.T)

    @property
    def k_stagnant(self) -> Any:
        """Conductivity of both phases without flow [W/m/K]."""
        return self.medium.stagnant(self.T)


Bound = Mapping[tuple[str, Any], BoundClosure | BoundDispersion]


def places(
    closures: s.Closures, heat: s.Heat | None, boundary: Mapping[str, s.Boundary]
) -> Iterator[tuple[KeyPath, Any, str]]:
    """Yield (key, value, kind) of each place where a scene may name a closure."""
    for key in OF_FLOW if heat is None else (*OF_FLOW, *OF_HEAT):
        kind = "conductivity" if key.startswith("conductivity") else key
        yield ("closures", key), getattr(closures, key), kind
    for path, _, condition in conditions_of(boundary):
        yield (*path, "coefficient"), condition.coefficient, "wall"


def bound(spec: Any, kind: str, base: Any) -> BoundClosure | BoundDispersion:
    """Return the closure named by a scene whose folder is `base`; raise what
    `binding.bind` raises.
    """
    if kind == "dispersion" and not isinstance(spec, ClosureFile):
        return bind_dispersion(spec, GIVES[kind])
    return bind(spec, kind, GIVES[kind], base)


def all_bound(scene: s.Scene) -> Bound:
    """Return all closures of a scene by kind and by what names them; equal names
    share one.
    """
    found = {}
    for _, spec, kind in places(scene.closures, scene.heat, scene.boundary):
        if named(spec) and not (kind == "conductivity" and is_phase(spec)):
            found[kind, spec] = bound(spec, kind, scene.origin.base)
    return found
