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
    _table: Any
    _slope: Any

    def enthalpy(self, T: Any) -> Any:
        """Return the enthalpy [kJ/kg] of one phase at temperatures [K]."""
        return _enthalpy(self.pressure, T)

    def temperature(self, h: Any) -> Any:
        """Return the temperature [K]."""
        return pointwise(self._table, self._slope, h)

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
    from scipy.interpolate import CubicSpline, PPoly

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
        liquid = vapour = float(_enthalpy(pressure, T_boil))
    # nodes crowd at saturation, where heat capacities rise
    near = 0.5 * (1 - np.cos(np.linspace(0, np.pi, NODES)))
    below, above = T_LOW + near * (T_boil - T_LOW), T_boil + near * (T_HIGH - T_boil)
    h_low, h_high = _enthalpy(pressure, below[:-1]), _enthalpy(pressure, above[1:])
    low = CubicSpline(np.append(h_low, liquid), below)
    high = CubicSpline(np.insert(h_high, 0, vapour), above)
    first, last = float(h_low[0]), float(h_high[-1])
    # straight beyond both ends, constant where water boils
    start = [0.0, 0.0, low(first, 1), low(first) - low(first, 1)]
    end = [0.0, 0.0, high(last, 1), high(last)]
    boiling = [[0.0, 0.0, 0.0, T_boil]] if vapour > liquid else []
    pieces = [start, *low.c.T, *boiling, *high.c.T, end]
    nodes = np.unique([first - 1.0, *low.x, *high.x, last + 1.0])
    table = PPoly(np.array(pieces).T, nodes)
    return Steam(pressure, liquid, vapour, (first, last), table, table.derivative())


def _enthalpy(pressure: float, T: Any) -> Any:
    from CoolProp import CoolProp

    return 1e-3 * np.asarray(CoolProp.PropsSI("Hmass", "P", pressure, "T", T, "Water"))
