"""Steam reforming over nickel: the rates of Xu and Froment, per mass of catalyst.

    CH4 + H2O <-> CO + 3 H2       r1 = k1 (p_CH4 p_H2O - p_H2^3 p_CO/K1)/(p_H2^2.5 DEN^2)
    CO + H2O <-> CO2 + H2         r2 = k2 (p_CO p_H2O - p_H2 p_CO2/K2)/(p_H2 DEN^2)
    CH4 + 2 H2O <-> CO2 + 4 H2    r3 = k3 (p_CH4 p_H2O^2 - p_H2^4 p_CO2/(K1 K2))/(p_H2^3.5 DEN^2)
    DEN = 1 + K_CO p_CO + K_H2 p_H2 + K_CH4 p_CH4 + K_H2O p_H2O/p_H2

Pressures in bar. Equilibrium constants K1 [bar2] and K2 are those of the thermodynamics
in use, so that the rates vanish where enthalpies and entropies say so. The rates have
no limit without hydrogen: a trace has to enter.

Source: Xu, Froment 1989, AIChE J. 35, 88-96, doi:10.1002/aic.690350109; constants in
    kmol/kg/h.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from contbed.chemistry.local import Local, Rate
from contbed.chemistry.power_law import product
from contbed.chemistry.rate_law import BAR, Case, RateLaw
from contbed.chemistry.thermo import R_GAS

GASES = ("CH4", "H2O", "H2", "CO", "CO2")
REACTIONS: dict[str, str] = {
    "xu_froment_reforming": "CH4 + H2O <-> CO + 3 H2",
    "xu_froment_shift": "CO + H2O <-> CO2 + H2",
    "xu_froment_total": "CH4 + 2 H2O <-> CO2 + 4 H2",
}
_RATES = {
    "xu_froment_reforming": (4.225e15, 240.1e3),
    "xu_froment_shift": (1.955e6, 67.13e3),
    "xu_froment_total": (1.020e15, 243.9e3),
}
_ADSORPTION = {
    "CO": (8.23e-5, -70.65e3),
    "H2": (6.12e-9, -82.90e3),
    "CH4": (6.65e-4, -38.28e3),
    "H2O": (1.77e5, 88.68e3),
}
KMOL_PER_HOUR = 1.0 / 3.6  # kmol/kg/h in mol/kg/s
LEAST_H2 = 1e-6  # bar; below, the pressure of hydrogen in denominators stays there


def denominator(T: Any, p: Mapping[str, Any]) -> Any:
    """Return DEN at partial pressures [bar]."""
    K = {name: A * np.exp(-H / (R_GAS * T)) for name, (A, H) in _ADSORPTION.items()}
    H2 = np.maximum(p["H2"], LEAST_H2)
    return (
        1.0
        + K["CO"] * p["CO"]
        + K["H2"] * p["H2"]
        + K["CH4"] * p["CH4"]
        + K["H2O"] * p["H2O"] / H2
    )


def rate(name: str, T: Any, p: Mapping[str, Any], K: Any) -> Any:
    """Return a rate [mol/kg/s] at partial pressures [bar]; K in bar to the change of
    moles.
    """
    A, E = _RATES[name]
    k = KMOL_PER_HOUR * A * np.exp(-E / (R_GAS * T))
    H2 = np.maximum(p["H2"], LEAST_H2)
    H2_1 = p["H2"]
    if name == "xu_froment_reforming":
        driving = product([p["CH4"], p["H2O"]]) - H2_1 * H2_1 * H2_1 * p["CO"] / K
        below = H2 * H2 * np.sqrt(H2)
    elif name == "xu_froment_shift":
        driving, below = product([p["CO"], p["H2O"]]) - H2_1 * p["CO2"] / K, H2
    else:
        steam = p["H2O"] * p["H2O"]
        driving = p["CH4"] * steam - H2_1 * H2_1 * H2_1 * H2_1 * p["CO2"] / K
        below = H2 * H2 * H2 * np.sqrt(H2)
    den = denominator(T, p)
    return k * driving / (below * den * den)


def _rate(name: str, case: Case) -> Rate:
    def per_catalyst(at: Local) -> Any:
        p = {key: at.x[key] * at.p / BAR for key in GASES}
        return rate(name, at.T, p, np.exp(case.equilibrium.ln_K(at.T)))

    return per_catalyst


LAWS = {
    name: RateLaw(
        partial(_rate, name),
        equations=(equation,),
        takes=("equilibrium_factor", "diffusivity"),
        basis="catalyst",
        gases=GASES,
    )
    for name, equation in REACTIONS.items()
}
