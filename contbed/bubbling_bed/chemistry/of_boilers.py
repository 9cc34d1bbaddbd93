"""Results of boilers: efficiency by indirect losses, and emissions.

Losses are shares of the lower heating value, at 298.15 K, of the dry fuel that is fed
and of the gas that enters:

    efficiency = share burnt - heat of the flue gas - heat of the solids drained

which is what surfaces, walls and radiation take where nothing but fuel and gas is fed
at 298.15 K and no other solid reacts. Source: EN 12952-15, Water-tube boilers,
acceptance tests (2003).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from contbed.bubbling_bed.chemistry import thermo
from contbed.bubbling_bed.chemistry.problem import Chemistry
from contbed.bubbling_bed.chemistry.streams import Streams
from contbed.chemistry.thermo import T_STANDARD

EMITTED = ("CO", "NO", "NO2", "N2O", "SO2")
AIR, REFERENCE = 0.209, 0.06  # mole fractions of O2, in air and in dry flue gas
UNBURNT = 0.05  # share of the heating value above which a run warns
# reaction that burns a gas, and the gas
_BURNT_BY = {
    "tar_oxidation": "C6H6",
    "CO_oxidation": "CO",
    "H2_oxidation": "H2",
    "CH4_oxidation": "CH4",
    "H2S_oxidation": "H2S",
}
MOLAR_VOLUME = 8.31446261815324 * 273.15 / 101325.0  # [m3/mol]


def boiler_findings(
    problem: Any,
    chemistry: Chemistry,
    state: Any,
    streams: Streams,
    qoi: dict[str, Any],
) -> None:
    """Add losses, efficiency and emissions where there is air enough to burn the
    fuel.
    """
    if qoi["oxygen_ratio"] < 1.0:
        return
    power = qoi["fuel_power_W"]
    qoi["loss_flue_gas"] = flue_gas_heat(problem, chemistry, streams) / power
    qoi["loss_solids"] = heat_of_drain(problem, chemistry, state, streams) / power
    qoi["boiler_efficiency"] = (
        qoi["combustion_efficiency"] - qoi["loss_flue_gas"] - qoi["loss_solids"]
    )
    gases = chemistry.part.gases
    for name in EMITTED:
        if name in gases:
            shares = qoi[f"x_{name}_dry"], qoi["x_O2_dry"]
            qoi[f"emission_{name}_mg_m3"] = emission(*shares, gases[name].molar_mass)


def unburnt_fuel(
    lost: Mapping[str, float], qoi: Mapping[str, Any], reactions: Any
) -> list[str]:
    """Return a warning where much of the fuel leaves unburnt although there is air
    enough, with what to try.

    Parameters
    ----------
    lost : heating value of each gas and solid that leaves [W]
    reactions : table of the scene
    """
    power = qoi["fuel_power_W"]
    whole = sum(lost.values()) / power
    if whole < UNBURNT or qoi["oxygen_ratio"] < 1.0 or not qoi["ignited"]:
        return []
    shares = {name: heat / power for name, heat in lost.items()}
    named = sorted(shares, key=lambda name: -shares[name])
    named = [name for name in named if shares[name] > UNBURNT / 10]
    parts = ", ".join(f"{name} {shares[name]:.2g}" for name in named)
    missing = {
        fuel: f"[reactions.{key}]"
        for key, fuel in _BURNT_BY.items()
        if fuel in named and getattr(reactions, key, None) is None
    }
    remedy = (
        f"add {' and '.join(missing.values())}, which {' and '.join(missing)} burns by"
        if missing
        else "more time or a hotter place burns it: a deeper bed, a higher "
        "bubbling_bed.freeboard, less heat to the tubes; drain less char"
    )
    return [
        f"{100 * whole:.2g} % of the fuel's heating value leaves unburnt, though "
        f"{qoi['oxygen_ratio']:.3g} times the oxygen that it needs enters "
        f"(shares: {parts}); {remedy}"
    ]


def unburnt_sulphur(qoi: Mapping[str, Any], reactions: Any) -> list[str]:
    """Return a warning where sulphur leaves as H2S beside oxygen, as nothing burns it."""
    if reactions.of_gases.get("H2S_oxidation") is not None:
        return []
    if not 0.0 < qoi.get("x_H2S_wet", 0.0) < qoi.get("x_O2_wet", 0.0):
        return []
    return [
        "the sulphur of the fuel leaves as H2S beside oxygen; add "
        "[reactions.H2S_oxidation], which burns it to SO2"
    ]


def emission(x: float, x_oxygen: float, molar_mass: float) -> float:
    """Return milligrams of a gas per m3 of dry flue gas at 0 degC, 1 atm and 6 % of
    O2.

    Parameters
    ----------
    x, x_oxygen : mole fractions in the dry gas; molar_mass : [kg/mol]
    """
    diluted = (AIR - REFERENCE) / (AIR - x_oxygen)
    return 1e6 * x * diluted * molar_mass / MOLAR_VOLUME


def flue_gas_heat(problem: Any, chemistry: Chemistry, streams: Streams) -> float:
    """Return the heat above 298.15 K of the gas that leaves less that of the gas that
    enters, with the evaporation of the moisture of the fuel [W].
    """
    gases = chemistry.part.gases

    def heat(flows: Mapping[str, float], T: float) -> float:
        return sum(n * _above(gases[name], T) for name, n in flows.items())

    leaving = sum(heat(flows, streams.T[k]) for k, flows in streams.leaving.items())
    inlet = problem.c.inlet
    total = leaving - sum(heat(flows, inlet) for flows in streams.entering.values())
    species = thermo.table()
    steam, water = (species[name].enthalpy(T_STANDARD) for name in ("H2O", "H2O(l)"))
    return total + streams.fed.get("moisture", 0.0) * float(steam - water)


def _above(species: Any, T: float) -> float:
    """Return the enthalpy above that at 298.15 K."""
    return float(species.enthalpy(T) - species.enthalpy(T_STANDARD))


def heat_of_drain(
    problem: Any, chemistry: Chemistry, state: Any, streams: Streams
) -> float:
    """Return the heat above 298.15 K of solids and ash that are drained [W]."""
    part = chemistry.part
    total = sum(
        streams.drained[name] * _above(solid, streams.T[solid.species])
        for name, solid in part.solids.items()
    )
    for ash in part.ash:
        total += problem.total(
            lambda u, o, a=ash: (
                a.fed(o.x[0])
                * (a.enthalpy(getattr(u, f"T_{a.species}")) - a.enthalpy(T_STANDARD))
            ),
            state,
        )
    return float(total)
