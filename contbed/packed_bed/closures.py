"""Closures of a packed bed: where a scene names them, and the arguments that the bed
gives them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from contbed.closures.binding import (
    BoundClosure,
    BoundDispersion,
    bind,
    bind_dispersion,
    is_phase,
    named,
)
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
    """A state of a `Medium`: temperature of the fluid [K] and `speed(density)`, see
    `Medium.reynolds`.
    """

    medium: Any
    T: Any
    speed: Any

    @property
    def Re(self) -> Any:
        """Particle Reynolds number."""
        return self.medium.reynolds(self.T, self.speed)

    @property
    def Pr(self) -> Any:
        """Prandtl number of the fluid."""
        return self.medium.prandtl(self.T)


Gives = Mapping[str, Callable[[At], Any]]
_PACKING: Gives = {
    "eps": lambda at: at.medium.scene.packed_bed.porosity,
    "d_p": lambda at: at.medium.scene.diameter,
}
_STREAM: Gives = _PACKING | {  # type: ignore[operator]
    "Re": lambda at: at.Re,
    "Pr": lambda at: at.Pr,
    "Pe": lambda at: at.Re * at.Pr,
    "T": lambda at: at.T,
    "D_bed": lambda at: at.medium.bed_diameter,
    "k_fluid": lambda at: at.medium.fluid.conductivity(at.T),
}
_PHASES: Gives = {
    "eps": _PACKING["eps"],
    "k_fluid": _STREAM["k_fluid"],
    "k_solid": lambda at: at.medium.solid.conductivity(at.T),
}
GIVES: Mapping[str, Gives] = {
    "permeability": _PACKING,
    "forchheimer": _PACKING,
    "nusselt": _STREAM,
    "dispersion": _STREAM,
    "wall": {**_STREAM, "k_stagnant": lambda at: at.medium.stagnant(at.T)},
    "conductivity": {**_PACKING, **_PHASES, "T": _STREAM["T"]},
    "tortuosity": _PHASES,
}
"""The arguments that closures of each kind can have, as functions of the state."""

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
