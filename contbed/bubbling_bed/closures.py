"""Closures of a bubbling bed: where a scene names them, and the arguments available to them at each place."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from contbed.closures.binding import BoundClosure, bind, named
from contbed.scene.toml_lines import KeyPath, dotted

Use = tuple[KeyPath, Any, str]

_GAS = frozenset({"T", "rho_gas", "mu", "cp_gas", "k_gas", "k_fluid", "Pr", "eps", "D_bed"})
_PARTICLES = frozenset({"d_p", "sphericity", "rho_solid", "Ar"})
_BED = _GAS | _PARTICLES | {"p", "molar_mass", "eps_mf", "cp_solid", "k_solid"}
_FLOW = _BED | {"u_mf", "u", "u_excess", "slip"}
_BUBBLES = _FLOW | {"d_b", "u_b", "delta"}
_PAIR = frozenset(f"{name}_{k}" for name in ("f", "d", "rho", "cp", "k") for k in (1, 2))
# the coefficients of bubbles follow from each other: rise, fraction, gas of the emulsion
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
_MORE = {"nusselt": frozenset({"Re"}), "solid_exchange": _PAIR}


def uses(scene: Any) -> Iterator[Use]:
    """Yield (key, value, kind) of each place where the scene may name a closure."""
    bed, bubbles = scene.bubbling_bed, scene.bubbles
    yield ("bubbling_bed", "minimum_fluidization"), bed.minimum_fluidization, "minimum_fluidization"
    if bed.expansion is not None:
        yield ("bubbling_bed", "expansion"), bed.expansion, "expansion"
    if bed.conductivity is not None:
        yield ("bubbling_bed", "conductivity"), bed.conductivity, "conductivity"
    if bubbles is not None:
        for key, kind in (
            ("fraction", "bubble_fraction"),
            ("exchange", "bubble_heat"),
            ("gas_exchange", "gas_exchange"),
            ("size", "bubble_growth"),
            ("start", "bubble_start"),
            ("rise", "bubble_rise"),
            ("emulsion_gas", "emulsion_gas"),
        ):
            yield ("bubbles", key), getattr(bubbles, key), kind
    for name, item in scene.species.items():
        yield ("species", name, "gas_coefficient"), item.gas_coefficient, "nusselt"
        yield ("species", name, "conductivity"), item.conductivity, "solids_mixing"
        for other, value in item.exchange.items():
            yield ("species", name, "exchange", other), value, "solid_exchange"
    for key, table in (("tubes", scene.tubes), ("walls", scene.walls)):
        if table is not None:
            yield (key, "coefficient"), table.coefficient, "bed_tube"
    if scene.freeboard is not None and scene.freeboard.height is not None:
        for key, kind in (
            ("ejection", "ejection"),
            ("decay", "decay"),
            ("terminal_velocity", "terminal_velocity"),
            ("elutriation", "elutriation"),
            ("gas_coefficient", "nusselt"),
        ):
            yield ("freeboard", key), getattr(scene.freeboard, key), kind


def gives(path: KeyPath, kind: str, bubbling: bool) -> frozenset[str]:
    """Return the arguments that a closure at a place of the scene can have, with bubbles or without."""
    table, key = path[0], str(path[-1])
    if key == "minimum_fluidization":
        return _BED
    if table == "freeboard":
        above = _ABOVE[key]
        if above is not None:
            return above
    if table == "bubbles":
        return _IN_TURN.get(key, _BUBBLES)
    return (_BUBBLES if bubbling else _FLOW) | _MORE.get(kind, frozenset())


def is_bubbling(bubbles: Any) -> bool:
    """Return whether a scene with this table has bubbles."""
    return bubbles is not None and bubbles.fraction != 0


class Coefficient:
    """One coefficient: a number, or a closure that takes its arguments from a state."""

    def __init__(self, path: KeyPath, spec: Any, kind: str, bubbling: bool, base: Path):
        self.path = dotted(path)
        self.closure: BoundClosure | None = None
        if named(spec):
            self.closure = bind(spec, kind, gives(path, kind, bubbling), base)
        self.value = None if self.closure is not None else spec

    def __call__(self, state: Mapping[str, Any], ranges: list[Any] | None) -> Any:
        """Return the value at a state; a list in `ranges` collects how the closure was used."""
        if self.closure is None:
            return self.value
        if ranges is not None:
            ranges.append({**self.closure.use(**state).to_dict(), "used_by": self.path})
        return self.closure(**state)
