"""Names and units of parameters and results in the tables and pictures of studies."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from contbed import fields
from contbed.errors import SceneError
from contbed.explain import sheets
from contbed.fields import FIELDS, labelled, name_of, unit_of
from contbed.scene.mesh import power_units
from contbed.scene.names import nearest, nearest_of
from contbed.scene.tables import SceneBase
from contbed.scene.toml_lines import parse_key


@dataclass(frozen=True)
class Quantity:
    """A parameter or result: its key in scene or summary, its name and its unit;
    None for no number.
    """

    key: str
    name: str
    unit: str | None

    @property
    def header(self) -> str:
        """Column header, "T_fluid_out [K]"; a plain number has "-"."""
        return (
            self.name
            if self.unit is None
            else f"{self.name} [{'-' if self.unit == '1' else self.unit}]"
        )

    @property
    def label(self) -> str:
        """Axis label, with the symbol of the field that a result is named after."""
        field, rest = self.name, ""
        while field and field not in FIELDS:
            field, _, end = field.rpartition("_")
            rest = f" {end}{rest}"
        words = self.name if "." in self.name else self.name.replace("_", " ")
        text = f"${FIELDS[field].symbol}${rest}" if field else words
        return labelled(text, self.unit)


def parameter(key: str, values: Iterable[Any]) -> Quantity:
    """Return a key of the scene; names and tables have no unit."""
    named = any(isinstance(value, str | dict) for value in values)
    return Quantity(key, key, None if named else sheets.unit(parse_key(key)))


def result(key: str, scene: SceneBase | None = None) -> Quantity:
    """Return a named result, of a scene see `unit_of_result`; else the unit is that in
    its key ("k_eff [W/m/K]", "T_fluid_out_K") or of its field ("u_max").

    >>> [result(key).header for key in ("T_fluid_out_K", "k_eff [W/m/K]", "u_max", "porosity")]
    ['T_fluid_out [K]', 'k_eff [W/m/K]', 'u_max [m/s]', 'porosity [-]']
    """
    unit = unit_of(key) or "1"
    ending = re.sub(r"\W+", "_", unit)
    name = name_of(key).removesuffix(f"_{ending}").removesuffix(f"_{unit}")
    return Quantity(key, name, unit_of_result(key, scene) or "1")


def unit_of_result(key: str, scene: SceneBase | None) -> str | None:
    """Return the unit of a named result of a scene; that of a heat in a line is per area
    of its section, in a plane per depth. None if there is no such result.
    """
    mesh: Any = getattr(scene, "mesh", None)
    own = power_units([key], mesh) if hasattr(mesh, "dimension") else {}
    return own.get(key) or unit_of(key)


def why_unknown(name: str) -> str:
    """Return why a name is no named result of any run; empty if it is one."""
    if fields.result(name) is not None:
        return ""
    known = dict.fromkeys(
        one.replace("PHASE", phase)
        for one in fields.RESULTS
        for phase in ("fluid", "solid")
    )
    return f"no named result {name!r}; {nearest_of(name, list(known))}"


def number_of(qoi: Mapping[str, Any], name: str, where: str) -> float:
    """Return a named result of a run; `where` begins the message.

    Raises
    ------
    SceneError : it is not among the numbers of the run
    """
    numbers = {
        key: float(value)
        for key, value in qoi.items()
        if isinstance(value, int | float) and not isinstance(value, bool)
    }
    if name not in numbers:
        hint = nearest(name, list(numbers))
        raise SceneError(f'{where}: the run has no result "{name}"; {hint}')
    return numbers[name]
