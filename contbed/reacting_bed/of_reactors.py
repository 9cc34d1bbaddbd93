"""Results of reactors: selectivity and yield by atoms, space velocities, the hot spot,
and how far reactions are from equilibrium where the gas leaves.

Of an element E that no solid takes or gives, a product P that leaves more than it
enters has the

    selectivity  atoms of E in the P that is made / atoms of E in what is used up
    yield        atoms of E in the P that is made / atoms of E fed in what is used up

so that selectivities of an element add up to 1, and the yield is the selectivity times
the conversion of what is used up.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.chemistry.kinetics import Reaction
from contbed.chemistry.thermo import R_GAS, Equilibrium
from contbed.fem.probe import peak
from contbed.reacting_bed.equations.unknowns import State
from contbed.reacting_bed.problem import Problem

T_NORMAL, P_NORMAL = 273.15, 101325.0  # [K], [Pa] of volumes in space velocities
HOUR = 3600.0
TRACE = 1e-3  # share of all that is made below which a gas is no product
SAME = 1e-10  # change of a gas over what is fed, below which it is rounding
CLOSED = 1e-6  # relative difference of atoms made and used up in the gas
STEPS = 50  # of Newton's method to an equilibrium temperature
RANGE = (100.0, 6000.0)  # [K] of equilibrium temperatures


def made_and_used(
    problem: Problem, leaving: Mapping[str, float]
) -> dict[str, float | Any]:
    """Return selectivities and yields by atoms, and space-time yields of products.

    `leaving` are mole fluxes of the gases that leave [mol/m2/s].
    """
    fed = {name: abs(n) for name, n in problem.streams.gas.items()}
    made = {name: leaving[name] - n for name, n in fed.items()}
    # what leaves as it enters is not used up
    made = {name: n if abs(n) > SAME * fed[name] else 0.0 for name, n in made.items()}
    least = TRACE * sum(max(n, 0.0) for n in made.values())
    products = [name for name, n in made.items() if n > least]
    length = problem.scene.mesh.length
    found = {
        f"space_time_yield_{name}_mol_m3s": made[name] / length for name in products
    }
    atoms = {name: problem.species.gases[name].composition for name in fed}
    elements = dict.fromkeys(element for each in products for element in atoms[each])
    for element in elements:
        of = {name: atoms[name].get(element, 0.0) for name in fed}
        used = -sum(of[name] * min(n, 0.0) for name, n in made.items())
        gained = sum(of[name] * max(n, 0.0) for name, n in made.items())
        if not 0.0 < abs(gained - used) + used <= (1.0 + CLOSED) * used:
            continue  # solids take or give it
        offered = sum(of[name] * fed[name] for name, n in made.items() if n < 0.0)
        if not offered:
            continue  # what is used up is rounding of what does not enter
        holding = [name for name in products if of[name]]
        for name in holding:
            share = of[name] * made[name]
            found[f"yield_{name}_{element}"] = share / offered
            if len(holding) > 1:
                found[f"selectivity_{name}_{element}"] = share / used
    return found


def space_velocities(problem: Problem) -> dict[str, float]:
    """Return gas fed per hour over the bed: its volume at 0 degC and 1 atm over that of
    the bed, and its mass over that of the particles in which gases react.
    """
    streams, per_hour = problem.streams, HOUR / problem.scene.mesh.length
    found = {"GHSV_1_h": per_hour * problem.moles * R_GAS * T_NORMAL / P_NORMAL}
    gases = set(problem.species.gases)
    catalysts = {
        str(each.phase)
        for each in problem.reactions
        if each.site == "particle" and gases.issuperset(each.stoichiometry)
    }
    mass = sum(streams.densities.get(name, 0.0) for name in catalysts)
    if mass:
        found["WHSV_1_h"] = per_hour * abs(streams.mass_flux) / mass
    return found


def heat_of(problem: Problem, reaction: Reaction, T: float) -> float:
    """Return the heat that a mole of a reaction absorbs at a temperature [J/mol]."""
    enthalpies = problem.species.enthalpies
    return sum(
        n * float(enthalpies[name](T)) for name, n in reaction.stoichiometry.items()
    )


def hot_spot(
    problem: Problem, inner: tuple[State, Array], ends: tuple[State, Array]
) -> dict[str, float]:
    """Return the largest temperature of gas and particles, and where it is, among
    states inside and at both ends with their positions.

    In a section states inside are repeated, one for each part, and those at the ends
    are means: they count where they are hotter than all parts inside.
    """
    if not problem.layout.temperatures:
        return {}
    highest = []
    for state, x in (inner, ends):
        phases = [own.T_solid for _, own in problem.bed.with_states(state)]
        hotter = np.max([state.T_fluid, *phases], axis=0)
        highest.append(hotter.reshape(-1, len(x)).max(axis=0))
    places = [inner[1], ends[1]]
    if problem.section is not None and highest[1].max() < highest[0].max():
        places, highest = places[:1], highest[:1]
    at = np.concatenate(places)
    order = np.argsort(at)
    where, hottest = peak(at[order], np.concatenate(highest)[order])
    return {"hot_spot_K": hottest, "hot_spot_m": where}


def equilibrium(
    problem: Problem, reaction: Reaction, T: float, pressures: Mapping[str, float]
) -> dict[str, float]:
    """Return the approach of a reaction of gases to equilibrium, as Q/K and as a
    difference of temperatures.

    Parameters
    ----------
    T : temperature at which it runs where the gas leaves [K]
    pressures : partial pressures there [Pa]
    """
    gases = reaction.stoichiometry
    Q = sum(n * np.log(pressures[name] / 1e5) for name, n in gases.items())
    factor = problem.scene.reactions[reaction.key].equilibrium_factor
    law = Equilibrium(gases, problem.species.all, frozenset(gases), factor)
    found = {f"Q_over_K_{reaction.name}": float(np.exp(Q - law.ln_K(T)))}
    there = temperature_of(law, float(Q), T)
    if there is not None:
        found[f"equilibrium_approach_{reaction.name}_K"] = T - there
    return found


def beyond_equilibrium(problem: Problem, reaction: Reaction, quotient: float) -> str:
    """Return the warning of a formula that runs beyond the equilibrium of its
    reaction.
    """
    path = ("reactions", reaction.key, "rate")
    return (
        f"{problem.scene.origin.place(path)}: the reaction runs beyond "
        f"its equilibrium: Q/K is {quotient:.3g} where the gas leaves, and 1 in "
        "equilibrium. A formula is the whole rate and has no way back of its own: "
        "multiply it by (1 - Q_over_K)"
    )


def temperature_of(law: Equilibrium, Q: float, T: float) -> float | None:
    """Return the temperature at which ln K is Q, by Newton's method in 1/T from T [K];
    None where there is none.
    """
    inverse = 1.0 / T
    for _ in range(STEPS):
        at = 1.0 / inverse
        slope = -law.heat(at) / R_GAS  # of ln K over 1/T, van 't Hoff
        if not slope:
            return None
        step = (Q - law.ln_K(at)) / slope
        inverse += float(np.clip(step, -0.5 * inverse, inverse))
        if not RANGE[0] < 1.0 / inverse < RANGE[1]:
            return None
        if abs(step) <= 1e-12 * inverse:
            return 1.0 / inverse
    return None
