"""Closures of a bubbling bed: where a scene names them, and the arguments available
to them at each place.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from contbed.closures.binding import BoundClosure, bind, named
from contbed.closures.bubbles import GRAVITY
from contbed.scene.toml_lines import KeyPath, dotted

Use = tuple[KeyPath, Any, str]

MINIMUM_FLUIDIZATION: KeyPath = ("closures", "minimum_fluidization")
EXPANSION: KeyPath = ("closures", "expansion")
CONDUCTIVITY: KeyPath = ("bubbling_bed", "conductivity")
BUBBLES: KeyPath = ("bubbling_bed", "bubbles")
FREEBOARD: KeyPath = ("bubbling_bed", "freeboard")

_GAS = frozenset(
    {"T", "rho_gas", "mu", "cp_gas", "k_gas", "k_fluid", "Pr", "eps", "D_bed"}
)
_PARTICLES = frozenset({"d_p", "sphericity", "rho_solid", "Ar"})
_BED = _GAS | _PARTICLES | {"p", "molar_mass", "eps_mf", "cp_solid", "k_solid"}
_FLOW = _BED | {"u_mf", "u", "u_excess", "slip"}
_BUBBLES = _FLOW | {"d_b", "u_b", "delta"}
_PAIR = frozenset(
    f"{name}_{k}" for name in ("f", "d", "rho", "cp", "k") for k in (1, 2)
)
# the coefficients of bubbles follow from each other: rise, fraction, gas of the
# emulsion
_IN_TURN = {
    "rise": _FLOW | {"d_b"},
    "fraction": _FLOW | {"d_b", "u_b"},
    "gas_exchange": _BUBBLES | {"D_gas"},
}
_ABOVE = {
    "ejection": None,  # at the surface of the bed
    "decay": _GAS | {"u_gas", "d_p", "Re"},
    "gas_coefficient": _GAS | {"u_gas", "d_p", "Re"},
    "terminal_velocity": _GAS | _PARTICLES | {"u_gas"},
    "elutriation": _GAS | _PARTICLES | {"u_gas", "u_t"},
}
_OF_BUBBLES = {
    "fraction": "bubble_fraction",
    "exchange": "bubble_heat",
    "gas_exchange": "gas_exchange",
    "size": "bubble_growth",
    "start": "bubble_start",
    "rise": "bubble_rise",
    "emulsion_gas": "emulsion_gas",
}
_OF_FREEBOARD = {
    "ejection": "ejection",
    "decay": "decay",
    "terminal_velocity": "terminal_velocity",
    "elutriation": "elutriation",
    "gas_coefficient": "nusselt",
}
_MORE = {"nusselt": frozenset({"Re"}), "solid_exchange": _PAIR}


def uses(scene: Any) -> Iterator[Use]:
    """Yield (key, value, kind) of each place where the scene may name a closure.

    `scene` needs its bubbling_bed, solids and closures. A solid phase without a
    nusselt of its own takes that of [closures].
    """
    bed, closures = scene.bubbling_bed, scene.closures
    yield MINIMUM_FLUIDIZATION, closures.minimum_fluidization, "minimum_fluidization"
    if closures.expansion is not None:
        yield EXPANSION, closures.expansion, "expansion"
    if bed.conductivity is not None:
        yield CONDUCTIVITY, bed.conductivity, "conductivity"
    if bed.bubbles is not None:
        for key, kind in _OF_BUBBLES.items():
            yield (*BUBBLES, key), getattr(bed.bubbles, key), kind
    for name, item in scene.solids.items():
        yield from _uses_of_solid(name, item, closures)
    for key, table in bed.surfaces.items():
        yield (*surface_key(key), "coefficient"), table.coefficient, "bed_tube"
    if bed.freeboard is not None and bed.freeboard.height is not None:
        for key, kind in _OF_FREEBOARD.items():
            yield (*FREEBOARD, key), getattr(bed.freeboard, key), kind


def _uses_of_solid(name: str, item: Any, closures: Any) -> Iterator[Use]:
    """Yield the places of one solid phase."""
    nusselt = item.nusselt
    if item.gas_coefficient is not None:
        yield ("solids", name, "gas_coefficient"), item.gas_coefficient, "nusselt"
    elif nusselt is not None or closures.nusselt is not None:
        yield ("solids", name, "nusselt"), nusselt or closures.nusselt, "nusselt"
    mixing = item.mixing_conductivity
    yield ("solids", name, "mixing_conductivity"), mixing, "solids_mixing"
    for other, value in item.exchange.items():
        yield ("solids", name, "exchange", other), value, "solid_exchange"


def surface_key(name: str) -> KeyPath:
    """Return the key of a surface in the bed, "tubes" or "walls"."""
    return ("bubbling_bed", name)


def gives(path: KeyPath, kind: str, bubbling: bool) -> frozenset[str]:
    """Return the arguments that a closure at a place of the scene can have.

    `bubbling` says whether there are bubbles.
    """
    key = str(path[-1])
    if path == MINIMUM_FLUIDIZATION:
        return _BED
    if path[:-1] == FREEBOARD:
        above = _ABOVE[key]
        if above is not None:
            return above
    if path[:-1] == BUBBLES:
        return _IN_TURN.get(key, _BUBBLES)
    return (_BUBBLES if bubbling else _FLOW) | _MORE.get(kind, frozenset())


def gas_state(gas: Any, T: Any) -> dict[str, Any]:
    """Return what closures may ask for of a gas at a temperature [K]."""
    mu, k, cp = gas.viscosity(T), gas.conductivity(T), gas.heat_capacity(T)
    return {
        "T": T,
        "rho_gas": gas.density(T),
        "mu": mu,
        "cp_gas": cp,
        "k_gas": k,
        "k_fluid": k,
        "Pr": mu * cp / k,
    }


def archimedes(state: Mapping[str, Any], diameter: float, density: float) -> Any:
    """Return the Archimedes number of particles in a gas."""
    rho, mu = state["rho_gas"], state["mu"]
    return diameter**3 * rho * (density - rho) * GRAVITY / mu**2


class Coefficient:
    """One coefficient: a number, or a closure that takes its arguments from a state."""

    def __init__(self, path: KeyPath, spec: Any, kind: str, bubbling: bool, base: Path):
        self.path = dotted(path)
        self.closure: BoundClosure | None = None
        if named(spec):
            self.closure = bind(spec, kind, gives(path, kind, bubbling), base)
        self.value = None if self.closure is not None else spec

    def __call__(self, state: Mapping[str, Any], ranges: list[Any] | None) -> Any:
        """Return the value at a state; a list in `ranges` collects how the closure
        was used.
        """
        if self.closure is None:
            return self.value
        if ranges is not None:
            ranges.append({**self.closure.use(**state).to_dict(), "used_by": self.path})
        return self.closure(**state)
