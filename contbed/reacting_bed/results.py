"""Profiles, named results and balances of a reacting bed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.balance import Balance
from contbed.chemistry.thermo import T_STANDARD
from contbed.materials.condensation import above_saturation
from contbed.reacting_bed import of_reactors
from contbed.reacting_bed.equations.unknowns import State
from contbed.reacting_bed.least_amounts import (
    Least,
    below_zero,
    between_nodes,
    least,
    nearer_to_means,
    share_above_zero,
)
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.results_solids import fill_phases
from contbed.reacting_bed.swings import largest_swing, unresolved_front
from contbed.result import Result, beyond_ranges

UNDERSHOT = 1e-6  # share of the whole below zero that is counted
DRY = 1e-9  # share of the gas beside steam below which there is no dry gas
# Q/K of a formula above which it is reported; its own K may differ from tables
BEYOND = 1.5
# share of the atoms of the element of which most enters, below which others are rounding
LEAST_ATOMS = 1e-15
# share of the heat of reactions that is released where a bed has a hot spot
LEAST_RELEASED = 1e-3
# that streams carry at least [J/mol], of a gas 1 K above 298.15 K: rounding of enthalpies
# with heats of formation is not measured by less
LEAST_HEAT = 30.0
BETWEEN = 2  # positions of profiles inside of each cell


def everywhere(problem: Problem) -> Array:
    """Return the vertices and points between, from end to end of the bed."""
    v = problem.line.vertices
    inner = v[:-1, None] + np.diff(v)[:, None] * np.arange(BETWEEN + 1) / (BETWEEN + 1)
    return np.append(inner.ravel(), v[-1])


def values_at(problem: Problem, u: Array, x: Array) -> State:
    """Return the state at positions, means over the section; temperatures and
    pressure as arrays.
    """
    mean = problem.mean(between_nodes(problem, u))
    return problem.bed.state(list(problem.line.at(mean, x)))


def profiles(problem: Problem, u: Array) -> dict[str, Array]:
    """Return the columns of profiles.csv."""
    given = problem.scene.output.positions
    x = np.array(given) if given else everywhere(problem)
    state = values_at(problem, u, x)
    ones = np.ones_like(x)
    out = {"x [m]": x, "T_fluid [K]": state.T_fluid * ones}
    out |= {
        f"{name} [K]": T * ones
        for name, T in temperatures_of_solids(problem, state).items()
    }
    out |= {"p_gas [Pa]": state.p * ones, "u [m/s]": state.u * ones}
    out |= {f"x_{name} [1]": value * ones for name, value in state.x.items()}
    out |= loadings(problem, u, x)
    if problem.layout.solids:
        out |= {
            f"n_{name} [mol/m3]": state.n[name] * ones for name in problem.layout.solids
        }
        out |= {
            f"w_{name} [1]": w * ones
            for name, w in fractions(problem, solids_at(problem, state, ones)).items()
        }
    return out | ({} if problem.rings is None else across(problem, u, x))


def temperatures_of_solids(problem: Problem, state: State) -> dict[str, Any]:
    """Return the temperatures of the particles by name, of each solid phase where
    they differ.
    """
    if len(problem.layout.temperatures) <= 2:
        return {"T_solid": state.T_solid}
    return {
        phase.layout.temperature: own.T_solid
        for phase, own in problem.bed.with_states(state)
    }


def fractions(problem: Problem, solids: Mapping[str, Any]) -> dict[str, Any]:
    """Return mass fractions of constituents in the particles of their solid phase."""
    out: dict[str, Any] = {}
    for names in constituents_of(problem).values():
        held = {
            name: solids[name] * problem.species.solids[name].molar_mass
            for name in names
        }
        mass = sum(held.values())
        out |= {name: m / mass for name, m in held.items()}
    return out


def constituents_of(problem: Problem) -> dict[str, list[str]]:
    """Return the names of the constituents of each solid phase that has some."""
    phases = problem.species.phases
    found = {
        name: [phase.full(each) for each in phase.solids]
        for name, phase in phases.items()
    }
    return {name: names for name, names in found.items() if names}


def loadings(
    problem: Problem, u: Array, x: Array, moving: bool = False
) -> dict[str, Array]:
    """Return the intraparticle moles of each gas, adsorbed and in their pores, per
    mass of their solid phase, or of those that move alone.

    Polynomials through what particles hold at the nodes: isotherms of a temperature
    and a concentration between the nodes of a front may be far from both.
    """
    out: dict[str, Array] = {}
    if not problem.layout.inside:
        return out
    line = problem.line
    state = problem.bed.state(problem.at_all_points(u))
    for phase, own in problem.bed.with_states(state):
        if (inside := phase.inside) is None or (moving and not phase.velocity):
            continue
        for name, points in inside.held(own.inner, own.T_solid)[0].items():
            total = sum(points) / (inside.solids * inside.density)
            q = problem.mean(total.reshape(-1, *line.points.shape))
            least = problem.scene.solver.newton_tolerance * np.abs(q).max(axis=(1, 2))
            q = nearer_to_means(line, q, share_above_zero(line, q, least))
            column = phase.layout.full(f"q_{name}")
            out[f"{column} [mol/kg]"] = line.at(q, x)[0]
    return out


def solids_at(problem: Problem, state: State, ones: Array) -> dict[str, Array]:
    """Return the moles of all constituents per volume of bed."""
    return {
        name: state.n.get(name, n) * ones for name, n in problem.streams.solid.items()
    }


def ends(problem: Problem) -> tuple[int, int]:
    """Return the index of the vertex where gas leaves, and of that where solids
    leave.
    """
    gas = -1 if problem.streams.ahead else 0
    return gas, (-1 if problem.bed.velocity_solid >= 0 else 0)


def fill(
    problem: Problem, u: Array, result: Result, passed: Least | None = None
) -> None:
    """Fill in profiles, results, balances, ranges and warnings of a state.

    `passed` is the least amount of a run in time, whose balances are not those of its
    state.
    """
    result.profiles = profiles(problem, u)
    fluxes = problem.flux_at(u)
    gas_end, solid_end = ends(problem)
    state = state_at_ends(problem, u)
    _gas(problem, fluxes, state, gas_end, result)
    _solids(problem, fluxes, state, solid_end, result)
    if problem.bed.velocity_solid:
        end = problem.line.vertices[[solid_end]]
        for column, q in loadings(problem, u, end, moving=True).items():
            result.qoi[f"{column.split()[0]}_out_mol_kg"] = float(q[0])
    _extents(problem, u, state, gas_end, result)
    if problem.rings is not None:
        _across(problem, u, result)
    if passed is None:
        _balances(problem, u, fluxes, result)
    if passed is None and problem.reactions:
        leaving = {
            name: result.qoi[f"out_{name}_mol_m2s"] for name in problem.streams.gas
        }
        result.qoi |= of_reactors.made_and_used(problem, leaving)
    _remarks(problem, u, result, passed)


def across(problem: Problem, u: Array, x: Array) -> dict[str, Array]:
    """Return the temperatures of the bed at the axis and at the wall [K], of
    parabolas through two rings there.
    """
    assert problem.rings is not None
    by_ring = problem.line.at(u, x).reshape(-1, len(problem.layout.names), len(x))
    found = {}
    for name in problem.layout.temperatures:
        T = by_ring[:, problem.layout.names.index(name)]
        axis, wall = problem.rings.to_axis @ T, problem.rings.to_wall @ T
        phases = ("fluid", "solid") if name == "T" else (name.removeprefix("T_"),)
        for phase in phases:
            found[f"T_{phase}_axis [K]"], found[f"T_{phase}_wall [K]"] = axis, wall
    return found


def _across(problem: Problem, u: Array, result: Result) -> None:
    """Add the largest difference of temperature between the axis and the wall."""
    at = across(problem, u, everywhere(problem))
    if "T_fluid_wall [K]" in at:
        result.qoi["dT_section_max_K"] = float(
            np.abs(at["T_fluid_wall [K]"] - at["T_fluid_axis [K]"]).max()
        )


def state_at_ends(problem: Problem, u: Array) -> State:
    """Return the state at both ends of the bed, see `values_at`."""
    return values_at(problem, u, problem.line.vertices[[0, -1]])


def at_end(value: Any, end: int) -> float:
    """Return a value of `state_at_ends`, or a constant, at one end."""
    return float(np.broadcast_to(value, (2,))[end])


def _gas(
    problem: Problem,
    fluxes: Mapping[str, Array],
    state: State,
    end: int,
    result: Result,
) -> None:
    qoi, streams = result.qoi, problem.streams
    sign = 1.0 if streams.ahead else -1.0
    leaving = {name: sign * float(fluxes[f"g_{name}"][end]) for name in streams.gas}
    total = sum(leaving.values())
    takes_part = {
        name for reaction in problem.reactions for name in reaction.stoichiometry
    }
    takes_part |= set(problem.layout.inside)
    for name, entering in streams.gas.items():
        qoi[f"out_{name}_mol_m2s"] = leaving[name]
        qoi[f"x_{name}_out"] = leaving[name] / total
        if name in takes_part and entering and abs(leaving[name]) < abs(entering):
            qoi[f"conversion_{name}"] = 1.0 - leaving[name] / abs(entering)
    water = leaving.get("H2O", 0.0)
    dry = total - water
    if water and dry > DRY * total:
        qoi |= {
            f"x_{name}_dry": n / dry for name, n in leaving.items() if name != "H2O"
        }
    qoi["gas_out_mol_m2s"] = total
    qoi["mass_flux_out_kg_m2s"] = sum(
        n * problem.species.gases[name].molar_mass for name, n in leaving.items()
    )
    qoi["T_fluid_out_K"] = at_end(state.T_fluid, end)
    qoi["u_in_m_s"] = problem.inlet_velocity
    qoi["u_out_m_s"] = abs(at_end(state.u, end))
    if problem.layout.pressure:
        qoi["pressure_drop_Pa"] = streams.pressure - float(fluxes["p"][end])
        qoi["p_out_Pa"] = float(fluxes["p"][end])


def _solids(
    problem: Problem,
    fluxes: Mapping[str, Array],
    state: State,
    end: int,
    result: Result,
) -> None:
    qoi, streams = result.qoi, problem.streams
    if not problem.bed.velocity_solid:
        return
    for name, T in temperatures_of_solids(problem, state).items():
        if problem.bed.velocity_of(name):
            qoi[f"{name}_out_K"] = at_end(T, end)
    amounts = dict(streams.solid)
    for name in problem.layout.solids:
        if v := problem.bed.velocity_of(f"n_{name}"):
            amounts[name] = float(fluxes[f"n_{name}"][end]) / v
    share = fractions(problem, amounts)
    for name in problem.layout.solids:
        if problem.bed.velocity_of(f"n_{name}"):
            qoi[f"w_{name}_out"] = share[name]
            if streams.solid[name] and amounts[name] < streams.solid[name]:
                qoi[f"conversion_{name}"] = 1.0 - amounts[name] / streams.solid[name]
    fill_phases(problem, amounts, qoi)


def _extents(
    problem: Problem, u: Array, state: State, end: int, result: Result
) -> None:
    """Add what each reaction has made, and how far the gas that leaves is from
    equilibrium.
    """
    inner = problem.bed.state(problem.at_all_points(u))
    rates = problem.bed.rates(inner, problem.bed.medium.at(inner))
    T, absorbed = float(np.mean(inner.T_fluid)), np.zeros(1)
    for reaction, rate in zip(problem.reactions, rates, strict=True):
        extent = problem.integral(rate)
        absorbed = absorbed + rate * of_reactors.heat_of(problem, reaction, T)
        result.qoi[f"extent_{reaction.name}_mol_m2s"] = extent
        if reaction.key != reaction.name:  # in several solid phases
            whole = f"extent_{reaction.key}_mol_m2s"
            result.qoi[whole] = result.qoi.get(whole, 0.0) + extent
        gases = {
            name: n
            for name, n in reaction.stoichiometry.items()
            if name in problem.species.gases
        }
        all_gas = len(gases) == len(reaction.stoichiometry)
        known = all(problem.species.gases[name].has_entropy for name in gases)
        if reaction.equation.reversible and all_gas and known:
            T = at_end(
                state.of(reaction.phase).T_solid
                if reaction.site != "gas"
                else state.T_fluid,
                end,
            )
            pressures = {
                name: max(at_end(state.x[name] * state.p, end), 1e-295)
                for name in gases
            }
            approach = of_reactors.equilibrium(problem, reaction, T, pressures)
            result.qoi |= approach
            quotient = approach[f"Q_over_K_{reaction.name}"]
            written = problem.scene.reactions[reaction.key].rate is not None
            if written and extent > 0.0 and quotient > BEYOND:
                result.warnings.append(
                    of_reactors.beyond_equilibrium(problem, reaction, quotient)
                )
    if problem.reactions:
        points = inner, problem.line.points.ravel()
        both_ends = state, problem.line.vertices[[0, -1]]
        released, all_heat = (
            problem.integral(heat)
            for heat in (np.maximum(-absorbed, 0.0), abs(absorbed))
        )
        if released >= LEAST_RELEASED * all_heat:
            result.qoi |= of_reactors.hot_spot(problem, points, both_ends)
        result.qoi |= of_reactors.space_velocities(problem)


def _balances(
    problem: Problem, u: Array, fluxes: Mapping[str, Array], result: Result
) -> None:
    """Add the balance of every element, and of energy with heats of formation."""
    names = problem.layout.names
    # into the bed at both ends, by unknown
    inward = {
        name: (float(fluxes[name][0]), -float(fluxes[name][-1])) for name in names
    }
    crossing: dict[str, tuple[float, float]] = {}
    for element, atoms in atoms_of(problem).items():
        streams = [
            value * count
            for name, count in zip(names, atoms.tolist(), strict=True)
            for value in inward[name]
        ]
        crossing[element] = (
            sum(value for value in streams if value > 0),
            -sum(value for value in streams if value < 0),
        )
    least = LEAST_ATOMS * max(entering for entering, _ in crossing.values())
    for element, (entering, leaving) in crossing.items():
        if entering > least:
            result.balances[element] = Balance(
                entering, leaving, "mol/m2/s", scale=entering
            ).as_dict()
    temperatures = problem.layout.temperatures
    if not temperatures:
        return
    sources = dict(zip(names, problem.mean(problem.system.sources(u)), strict=True))
    wall = sum(sources[name] for name in temperatures)
    parts = [value for name in temperatures for value in inward[name]]
    if problem.scene.wall is not None:
        result.qoi["heat_wall_W"] = wall
        result.units["heat_wall_W"] = "W/m2"
    scale = max(heat_carried(problem, u), abs(wall))
    result.balances["energy"] = Balance.of_fluxes(parts, "W/m2", wall).as_dict() | {
        "relative_residual": (sum(parts) + wall) / scale
    }


def atoms_of(problem: Problem) -> dict[str, Array]:
    """Return the atoms of each element in what each unknown of the layout counts, 0
    for temperatures, the pressure and films.
    """
    species, unknowns = problem.species.all, problem.layout.unknowns
    found: dict[str, Array] = {}
    for item in species.values():
        for element in item.composition:
            found.setdefault(element, np.zeros(len(unknowns)))
    for k, unknown in enumerate(unknowns):
        if unknown.conserved is not None:
            for element, count in species[unknown.conserved].composition.items():
                found[element][k] = count
    return found


def heat_carried(problem: Problem, u: Array) -> float:
    """Return the heat above 298.15 K of all streams that enter or leave, at least
    LEAST_HEAT per mole, the measure of the energy balance [W/m2].
    """
    state = state_at_ends(problem, u)
    h = problem.bed.enthalpies
    total = 0.0

    def heat(moles: Sequence[tuple[float, Any]], T: float) -> float:
        carried = sum(n * float(of(T) - of(T_STANDARD)) for n, of in moles)
        return max(abs(carried), LEAST_HEAT * abs(sum(n for n, _ in moles)))

    for k in (0, 1):
        gases = [(at_end(g, k), h[name]) for name, g in state.g.items()]
        streams = [(1.0, gases, at_end(state.T_fluid, k))]
        for phase, own in problem.bed.with_states(state):
            T, h_s = at_end(own.T_solid, k), phase.enthalpies
            moles = [(at_end(n, k), h_s[name]) for name, n in own.n.items()]
            streams += [
                (phase.velocity, part, T) for part in (moles, list(phase.inert))
            ]
        for v, moles, T in streams:
            total += abs(v) * heat(moles, T)
    return max(total, 1e-300)


def _remarks(problem: Problem, u: Array, result: Result, found: Least | None) -> None:
    """Record the use of closures and laws, and what lies below zero or outside of
    data.
    """
    state = problem.bed.state(problem.at_all_points(u))
    problem.bed.medium.at(state)
    if problem.rings is not None:
        problem.bed.medium.radial(state)
    result.closures = [use.to_dict() for use in problem.bed.medium.ranges()]
    result.warnings += beyond_ranges(result.closures)
    share = 0.0
    whole = max(sum(problem.streams.solid.values()), 1e-300)
    for value in [*state.x.values(), *(n / whole for n in state.n.values())]:
        share = max(share, float(np.mean(value < -UNDERSHOT)))
    result.qoi["share_negative"] = share
    if (sentence := below_zero(problem, found or least(problem, u))) is not None:
        result.warnings.append(sentence)
    if found is None:
        result.warnings += unresolved_front(problem, largest_swing(problem, u))
    ranges = [(state.T_fluid, problem.species.gases)]
    ranges += [
        (
            state.of(phase).T_solid,
            {name: problem.species.solids[name] for name in names},
        )
        for phase, names in constituents_of(problem).items()
    ]
    for name, table in problem.scene.solids.items():
        data = SimpleNamespace(T_range=table.data_range)
        ranges.append((state.of(name).T_solid, {f"solids.{name}": data}))
    for T, items in ranges:
        result.warnings += _beyond_data(T, items)
    if "H2O" in state.x:
        columns = result.profiles
        partial = columns["x_H2O [1]"] * columns["p_gas [Pa]"]
        result.warnings += above_saturation(
            "the gas", columns["x [m]"], columns["T_fluid [K]"], partial
        )


def _beyond_data(T: Array, items: Mapping[str, Any]) -> list[str]:
    """Return one warning for all species whose data end alike, where they are
    extrapolated.
    """
    names: dict[tuple[float, float], list[str]] = {}
    for name, item in items.items():
        low, high = item.T_range
        if np.min(T) < low * (1 - 1e-3) or np.max(T) > high * (1 + 1e-3):
            names.setdefault(item.T_range, []).append(name)
    return [
        f"{', '.join(species)}: data from {low:g} to {high:g} K, used from "
        f"{np.min(T):.4g} to {np.max(T):.4g} K with the heat capacity at the nearer end"
        for (low, high), species in names.items()
    ]
