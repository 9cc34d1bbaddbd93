"""Water at one pressure as a function of enthalpy: CoolProp's equation of state,
tabulated once in each phase.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from contbed.errors import SceneError
from contbed.materials.pointwise import pointwise

NODES = 400  # of each phase
T_LOW, T_HIGH = 273.2, 1500.0  # [K]


@dataclass(frozen=True, eq=False)
class Steam:
    """Temperature as a function of enthalpy [kJ/kg].

    Between `liquid` and `vapour` water boils; both are equal above the critical
    pressure. Outside `h_range` the temperature continues linearly with the last slope.
    """

    pressure: float
    liquid: float
    vapour: float
    h_range: tuple[float, float]
    _low: Any
    _high: Any

    def enthalpy(self, T: float) -> float:
        """Return the enthalpy [kJ/kg] of one phase at a temperature [K]."""
        from CoolProp import CoolProp

        return 1e-3 * float(
            CoolProp.PropsSI("Hmass", "P", self.pressure, "T", T, "Water")
        )

    def temperature(self, h: Any) -> Any:
        """Return the temperature [K]."""
        return pointwise(lambda x: self._value(x, 0), lambda x: self._value(x, 1), h)

    def _value(self, h: Any, derivative: int) -> Any:
        inside = np.clip(h, *self.h_range)
        low, high = (
            curve(np.clip(inside, curve.x[0], curve.x[-1]), derivative)
            for curve in (self._low, self._high)
        )
        boiling = 0.0 if derivative else self._low(self.liquid)
        value = np.where(
            inside < self.liquid, low, np.where(inside > self.vapour, high, boiling)
        )
        if derivative:
            return value
        ends = [
            curve(x, 1)
            for curve, x in (
                (self._low, self.h_range[0]),
                (self._high, self.h_range[1]),
            )
        ]
        return (
            value
            + ends[0] * np.minimum(h - self.h_range[0], 0.0)
            + ends[1] * np.maximum(h - self.h_range[1], 0.0)
        )

    def quality(self, h: float) -> float | None:
        """Return the share of vapour in the mass of boiling water; None in one
        phase.
        """
        if not self.liquid < h < self.vapour:
            return None
        return (h - self.liquid) / (self.vapour - self.liquid)


@cache
def steam(pressure: float) -> Steam:
    """Tabulate water at a pressure [Pa].

    Source
    ------
    CoolProp, IAPWS-95; http://www.coolprop.org
    """
    from CoolProp import CoolProp
    from scipy.interpolate import CubicSpline

    def enthalpy(T: Any) -> Any:
        return 1e-3 * np.asarray(
            CoolProp.PropsSI("Hmass", "P", pressure, "T", T, "Water")
        )

    if not 1e3 <= pressure <= 1e8:
        raise SceneError(
            f"steam: a pressure of {pressure:g} Pa is outside of 1 kPa to 100 MPa"
        )
    critical = CoolProp.PropsSI("Pcrit", "Water")
    if pressure < 0.999 * critical:
        T_boil = CoolProp.PropsSI("T", "P", pressure, "Q", 0, "Water")
        liquid, vapour = (
            1e-3 * CoolProp.PropsSI("Hmass", "P", pressure, "Q", q, "Water")
            for q in (0, 1)
        )
    else:
        T_boil = CoolProp.PropsSI("Tcrit", "Water")
        liquid = vapour = float(enthalpy(T_boil))
    # nodes crowd at saturation, where heat capacities rise
    near = 0.5 * (1 - np.cos(np.linspace(0, np.pi, NODES)))
    below, above = T_LOW + near * (T_boil - T_LOW), T_boil + near * (T_HIGH - T_boil)
    h_low, h_high = enthalpy(below[:-1]), enthalpy(above[1:])
    low = CubicSpline(np.append(h_low, liquid), below)
    high = CubicSpline(np.insert(h_high, 0, vapour), above)
    return Steam(
        pressure,
        float(liquid),
        float(vapour),
        (float(h_low[0]), float(h_high[-1])),
        low,
        high,
    )
