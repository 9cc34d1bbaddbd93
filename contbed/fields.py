"""The fields that a run writes: name, symbol, unit, bounds and meaning. Output and plots read only this."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Field:
    """One quantity in SI. `symbol` is mathtext; `lower` is an open bound; unit "1" is dimensionless."""

    name: str
    symbol: str
    unit: str
    description: str
    lower: float = -math.inf

    @property
    def header(self) -> str:
        """Column header, "T_fluid [K]"."""
        return f"{self.name} [{self.unit}]"

    @property
    def label(self) -> str:
        """Axis label with symbol and unit; a dimensionless quantity shows none."""
        return f"${self.symbol}$" + ("" if self.unit == "1" else f" [{self.unit}]")


_ALL = (
    Field("x", "x", "m", "coordinate along a planar bed or a box"),
    Field("y", "y", "m", "coordinate across a planar bed or a box"),
    Field("z", "z", "m", "height in a box, or coordinate along an axisymmetric bed"),
    Field("r", "r", "m", "distance from the axis of an axisymmetric bed"),
    Field("t", "t", "s", "time since the start of the run"),
    Field("T_fluid", r"T_\mathrm{f}", "K", "temperature of the fluid", lower=0.0),
    Field("T_solid", r"T_\mathrm{s}", "K", "temperature of the solid", lower=0.0),
    Field("theta_fluid", r"\theta_\mathrm{f}", "1", "scaled temperature of the fluid"),
    Field("theta_solid", r"\theta_\mathrm{s}", "1", "scaled temperature of the solid"),
    Field("u", "u", "m/s", "superficial velocity of the fluid"),
    Field("u_x", "u_x", "m/s", "superficial velocity of the fluid along x"),
    Field("u_y", "u_y", "m/s", "superficial velocity of the fluid along y"),
    Field("u_z", "u_z", "m/s", "superficial velocity of the fluid along z"),
    Field("u_r", "u_r", "m/s", "superficial velocity of the fluid away from the axis"),
    Field("speed", "|u|", "m/s", "magnitude of the superficial velocity of the fluid"),
    Field("G", "G", "W/m2", "incident radiation, the intensity integrated over all directions"),
    Field("q_radiation", r"q_\mathrm{r}", "W/m2", "radiative heat flux along the bed"),
    Field("pressure_drop", r"\Delta p", "Pa", "pressure of the gas below a bed of particles over that above"),
    Field("height", "H", "m", "mean height of the surface of a bed of particles"),
    Field("coordination", "z", "1", "mean number of touching neighbours of a particle"),
    Field("p", "p", "Pa", "pressure in the momentum equation, porosity times the intrinsic pressure of the fluid"),
)
FIELDS = {field.name: field for field in _ALL}


def header(name: str) -> str:
    """Column header of a field: `header("T_fluid")` is "T_fluid [K]"."""
    return FIELDS[name].header


def name_of(header: str) -> str:
    """The name in a column header; the inverse of `header`."""
    return header.split(" [")[0]


def unit_of(name: str) -> str | None:
    """Unit of a field or of a result named after one ("T_fluid_outlet" is in K); None where no field fits."""
    while name and name not in FIELDS:
        name = name.rpartition("_")[0]
    return FIELDS[name].unit if name else None
