"""Humid air by its humidity: a composition of dry air and water vapour, which every
model of mixtures takes; and where the water of a gas would condense.

    x_H2O = W/(W + M_H2O/M_air) = RH p_s(T)/p
    ln(p_s/p_c) = T_c/T (a_1 t + a_2 t^1.5 + a_3 t^3 + a_4 t^3.5 + a_5 t^4 + a_6 t^7.5),  t = 1 - T/T_c

W  humidity ratio, mass of water over that of dry air      RH  relative humidity
p_s  saturation pressure of water [Pa]                     T   dry-bulb temperature [K]

Sources: dry air of Lemmon et al. 2000, J. Phys. Chem. Ref. Data 29, 331-385,
doi:10.1063/1.1285884; saturation of Wagner and Pruss 1993, J. Phys. Chem. Ref. Data 22,
783-787, doi:10.1063/1.555926, continued below 273 K as supercooled water. Interactions
of gas and water raise p_s by 0.5 % at 1 bar; they are left out.
"""

from __future__ import annotations

from typing import Any, Literal, Self

import numpy as np
from pydantic import model_validator

from contbed.scene.quantities import NonNegative, Share, Table, Temperature

AIR, HUMID_AIR = "air", "humid air"
DRY_AIR = {"N2": 0.7812, "O2": 0.2096, "AR": 0.0092}  # mole fractions
RATIO = 18.015268 / 28.9586  # molar mass of water over that of dry air
T_CRITICAL, P_CRITICAL = 647.096, 22.064e6  # of water [K], [Pa]
_SATURATION = (
    (1.0, -7.85951783),
    (1.5, 1.84408259),
    (3.0, -11.7866497),
    (3.5, 22.6807411),
    (4.0, -15.9618719),
    (7.5, 1.80122502),
)
COLDEST = 150.0  # [K] to which dew points are looked for


def saturation_pressure(T: float) -> float:
    """Return the pressure of water vapour over water [Pa]; inf above the critical
    temperature.
    """
    if T >= T_CRITICAL:
        return float("inf")
    tau = 1.0 - T / T_CRITICAL
    total = sum(a * tau**power for power, a in _SATURATION)
    return P_CRITICAL * float(np.exp(total * T_CRITICAL / T))


def dew_point(pressure: float) -> float:
    """Return the temperature [K] at which water vapour of a partial pressure [Pa]
    condenses.
    """
    low, high = COLDEST, T_CRITICAL
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (
            (middle, high) if saturation_pressure(middle) < pressure else (low, middle)
        )
    return high


class HumidAir(Table):
    """Keys of a gas that may be air."""

    material: Literal["air", "humid air"] | None = None
    """instead of composition: dry air, or humid air with humidity_ratio, or with
    relative_humidity and dry_bulb"""
    humidity_ratio: NonNegative | None = None
    """of humid air: mass of water over that of dry air"""
    relative_humidity: Share | None = None
    """of humid air at dry_bulb and the pressure of the gas"""
    dry_bulb: Temperature | None = None
    """temperature at which relative_humidity holds"""

    @model_validator(mode="before")
    @classmethod
    def _composition(cls, values: Any) -> Any:
        """Return the table of a gas with the composition of its humid air.

        Raises
        ------
        ValueError : the humidity is not given once, or no gas
        """
        if not isinstance(values, dict):
            return values
        given = {key for key in _HUMIDITY if values.get(key) is not None}
        material = values.get("material")
        if given and material != HUMID_AIR:
            raise ValueError(
                f'{" and ".join(sorted(given))}: of material = "humid air" only'
            )
        if material not in (AIR, HUMID_AIR):
            return values
        by_ratio, by_state = {"humidity_ratio"}, {"relative_humidity", "dry_bulb"}
        if material == HUMID_AIR and given not in (by_ratio, by_state):
            raise ValueError(
                "humid air: give humidity_ratio, or relative_humidity with dry_bulb"
            )
        composition = _composition_of(values, bool(given))
        if values.get("composition", composition) != composition:
            raise ValueError(f"give the composition, or {material}, not both")
        return values | {"composition": composition}

    def of_air(self) -> Self:
        """Return the table with the composition of its air, one of whose values was
        changed.
        """
        if self.material is None:
            return self
        values = {key: value for key, value in self if value is not None}
        given = any(key in values for key in _HUMIDITY)
        return self.model_copy(update={"composition": _composition_of(values, given)})


_HUMIDITY = ("humidity_ratio", "relative_humidity", "dry_bulb")


def _composition_of(values: dict[str, Any], humid: bool) -> str:
    """Return the composition of air."""
    share = _share_of_water(values) if humid else 0.0
    rest = {name: (1.0 - share) * x for name, x in DRY_AIR.items()}
    shares = rest | ({"H2O": share} if share else {})
    return ", ".join(f"{name}:{x:.10g}" for name, x in shares.items())


def _share_of_water(values: dict[str, Any]) -> float:
    """Return the mole fraction of water of humid air."""
    from contbed.scene.units import to_si

    def number(key: str, unit: str) -> float:
        given = values[key]
        return float(to_si(given, unit) if isinstance(given, str) else given)

    if values.get("humidity_ratio") is not None:
        ratio = number("humidity_ratio", "1")
        return ratio / (ratio + RATIO)
    pressure = number("pressure", "Pa") if "pressure" in values else 101325.0
    T = number("dry_bulb", "K")
    partial = number("relative_humidity", "1") * saturation_pressure(T)
    if not 0.0 <= partial < pressure:
        raise ValueError(
            f"air of {pressure:g} Pa holds no water of {partial:.4g} Pa, its pressure "
            f"at {T:g} K: water boils there; give a lower relative_humidity or dry_bulb"
        )
    return partial / pressure
