"""Whether the heat of its fuel keeps a bubbling bed hot enough to burn it.

    Q_fuel min(1, lambda) = Q_gas(T) + Q_moisture + Q_surfaces(T)

Q_fuel is the lower heating value of the dry fuel, lambda the oxygen ratio, Q_gas what the
products of complete combustion need from 25 degC to T less what the gas that enters
brings, and Q_surfaces what tubes, walls and freeboard take of a bed of one temperature.
Heat of solids that enter or leave is left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from contbed.bubbling_bed.chemistry import thermo
from contbed.chemistry.thermo import T_STANDARD

BURNING = 1123.15  # usual temperature of a bed of burning fuel [K]
# particles all colder than this do not burn their fuel [K]
OUT = 700.0
COLDEST, HOTTEST = 400.0, 2500.0  # between which the balance is solved [K]
MEGA = 1e-6


@dataclass(frozen=True)
class HeatBalance:
    """Heat at one temperature of the bed [W].

    oxygen : ratio of the oxygen that enters to what the fuel needs
    surfaces : heat that tubes, walls and freeboard take
    """

    T: float
    fuel: float
    oxygen: float
    gas: float
    moisture: float
    surfaces: float

    @property
    def burnt(self) -> float:
        """Share of the fuel for which there is oxygen."""
        return min(1.0, self.oxygen)

    @property
    def surplus(self) -> float:
        """What is left over, negative where heat is missing [W]."""
        needed = self.gas + self.moisture + self.surfaces
        return self.fuel * self.burnt - needed


def burns(problem: Any) -> bool:
    """Whether a bed is fed with fuel that its reactions burn."""
    chemistry = problem.chemistry
    if chemistry is None or chemistry.data is None:
        return False
    return "O2" in chemistry.part.inlet and any(
        "combustion" in name or "oxidation" in name for name in chemistry.names
    )


def is_out(problem: Any, state: Any) -> bool:
    """Whether a bed that is fed with fuel is too cold to burn it."""
    if not burns(problem):
        return False
    hottest = max(
        float(np.max(problem.system.part(state, f"T_{name}")))
        for name in problem.c.species
    )
    return hottest < OUT


def heat_balance(problem: Any, T: float) -> HeatBalance:
    """Return the heat balance of a bed of one temperature."""
    chemistry, species = problem.chemistry, thermo.table()
    data, part = chemistry.data, chemistry.part
    entering = {name: x * chemistry.inlet_flow for name, x in part.inlet.items()}
    atoms, needed = data.elements, data.oxygen
    ratio = entering["O2"] / needed
    burnt = min(1.0, ratio)
    changes = {
        "CO2": atoms["C"],
        "H2O": 0.5 * atoms["H"],
        "SO2": atoms["S"],
        "N2": 0.5 * atoms["N"],
        "O2": -needed,
    }
    leaving = dict(entering)
    for name, moles in changes.items():
        leaving[name] = leaving.get(name, 0.0) + burnt * moles
    leaving["H2O"] += data.moisture

    def sensible(moles: dict[str, float], at: float) -> float:
        heat = 0.0
        for name, n in moles.items():
            h = (part.gases.get(name) or species[name]).enthalpy
            heat += n * float(h(at) - h(T_STANDARD))
        return heat

    inlet = problem.plan.scene.inlet.temperature
    vapour, liquid = species["H2O"].enthalpy, species["H2O(l)"].enthalpy
    latent = float(vapour(T_STANDARD) - liquid(T_STANDARD))
    with np.errstate(all="ignore"):
        duties = problem.duties(problem._state(problem._start(T)))
    return HeatBalance(
        T,
        data.rate * data.lower,
        ratio,
        sensible(leaving, T) - sensible(entering, inlet),
        data.moisture * latent,
        sum(duties.values()),
    )


def even_temperature(problem: Any) -> float | None:
    """Return the temperature of the bed at which complete combustion gives what is
    taken [K]; None where it lies outside 400 to 2500 K.
    """

    def surplus(T: float) -> float:
        return heat_balance(problem, T).surplus

    if not surplus(COLDEST) > 0.0 > surplus(HOTTEST):
        return None
    return float(brentq(surplus, COLDEST, HOTTEST, xtol=0.1))


def _remedies(found: HeatBalance) -> str:
    """Return what can bring the heat that is missing, alone or else all together."""
    effects = {
        "tubes and walls that take less": found.surfaces,
        "less or hotter gas": found.gas,
        "drier fuel": found.moisture,
        "more fuel": found.fuel * (found.oxygen - 1.0),
    }
    enough = [name for name, heat in effects.items() if heat >= -found.surplus]
    if enough:
        return ", or ".join(enough)
    together = [name for name, heat in effects.items() if heat > 0.0]
    return f"all of this: {', '.join(together)}"


def explained(problem: Any) -> str:
    """Return what the heat balance says of a bed whose fuel does not burn."""
    found, T = heat_balance(problem, BURNING), even_temperature(problem)
    released = found.fuel * found.burnt
    of_air = "" if found.burnt == 1.0 else f" with oxygen for {found.burnt:.3g} of it"
    height = problem.plan.scene.bubbling_bed.height
    text = (
        f"at {BURNING:.0f} K in a bed {height:.3g} m high the fuel gives "
        f"{released * MEGA:.3g} MW{of_air}, gas needs "
        f"{found.gas * MEGA:.3g} MW, its moisture {found.moisture * MEGA:.3g} MW, and "
        f"tubes, walls and freeboard take {found.surfaces * MEGA:.3g} MW"
    )
    even = "" if T is None else f"; all burnt the bed would be at {T:.0f} K"
    if found.surplus < 0.0:
        return (
            f"{text}: {-found.surplus * MEGA:.3g} MW are missing{even}; give "
            f"{_remedies(found)}"
        )
    return (
        f"{text}: {found.surplus * MEGA:.3g} MW are left over{even}, so that heat does "
        "not forbid a burning bed: its particles and gas may have too little time to burn"
    )
