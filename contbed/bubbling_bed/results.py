"""Results of a bubbling bed: profiles, temperatures, heat duties, energy balance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.integrate import trapezoid

from contbed.balance import Balance
from contbed.bubbling_bed.diagnosis import flows_down
from contbed.bubbling_bed.plan import BubblingPlan
from contbed.bubbling_bed.problem import BubblingProblem
from contbed.closures import optics
from contbed.closures.bubbles import GRAVITY
from contbed.closures.ranges import usage
from contbed.errors import ConvergenceError
from contbed.fem.probe import Probe, line_along
from contbed.fields import header, name_of
from contbed.materials.common import extrapolation, share_outside
from contbed.materials.composition import mole_fractions
from contbed.materials.condensation import above_saturation
from contbed.result import Result
from contbed.scene.gas import GasCantera

# share of u_mf: with less excess gas a place counts as not fluidized
UNFLUIDIZED = 2e-3
SAME_CONTENT = 0.02  # by which heights of the same particles may differ
EVEN = 201  # heights at which the use of closures is counted
ROUNDED_CARRYOVER = 1e-9  # [kg/m2/s] left by rounding where no particles leave


def fill(
    plan: BubblingPlan, problem: BubblingProblem, state: Any, result: Result
) -> None:
    """Fill in profiles, named results and the energy balance of a state."""
    scene, c, space = plan.scene, plan.coefficients, problem.space
    nodal = {name: problem.system.part(state, name) for name in c.fields}
    wanted = scene.output.positions
    # named results are those of the whole height, also where profiles are short
    every = np.union1d(line_along(plan.mesh).positions, wanted)
    line = line_along(plan.mesh, every.tolist())
    positions, probe = line.positions, line.probe
    result.profiles = {"z [m]": positions} | {
        f"{name} [K]": probe(space, nodal[name]) for name in c.streams
    }
    if "G" in nodal:
        result.profiles["G [W/m2]"] = probe(space, nodal["G"])
        result.profiles["q_radiation [W/m2]"] = -c.diffusion * probe.slope(
            space, nodal["G"], 0
        )
    chemistry = c.chemistry
    if chemistry is not None:
        from contbed.bubbling_bed.chemistry import results as chemistry_results

        along = {name: probe(space, nodal[name]) for name in chemistry.part.fields}
        result.profiles |= chemistry_results.profiles(chemistry, along)
    if c.computed is not None:
        values: dict[str, Any] = {name: probe(space, nodal[name]) for name in c.fields}
        values |= {
            name: float(problem.system.part(state, name)[0]) for name in c.scalars
        }
        even = np.linspace(0.0, scene.bubbling_bed.height, EVEN)
        evenly = Probe(plan.mesh, even[None, :])
        at: dict[str, Any] = {
            name: evenly(space, nodal[name]) if name in nodal else value
            for name, value in values.items()
        }
        used = c.computed.recorded(at, even)[1]
        _computed(plan, values, positions, used, result)
    above = problem.above.part.fields if problem.above is not None else ()
    result.nodal |= {
        name: (space, values) for name, values in nodal.items() if name not in above
    }

    height = scene.bubbling_bed.height
    middle = Probe(plan.mesh, np.array([[0.5 * height]]))
    top = Probe(plan.mesh, np.array([[height]]))
    if c.plate is not None:
        result.qoi["T_distributor_K"] = float(
            problem.system.part(state, "T_distributor")[0]
        )
    result.qoi |= {
        f"T_{name}_mid_K": float(middle(space, nodal[f"T_{name}"])[0])
        for name in c.species
    }
    result.qoi |= {
        f"{name}_top_K": float(top(space, nodal[name])[0]) for name in c.gases
    }
    for name, item in scene.bubbling_bed.surfaces.items():
        if item.steam is not None:
            _water(
                problem,
                name,
                state,
                result,
                {key: probe(space, nodal[f"{key}_{name}"]) for key in ("h", "T")},
            )
    duties, releases = problem.duties(state), problem.releases(state)
    result.qoi |= duties | {
        f"release_{name}_W": value for name, value in releases.items()
    }
    result.balances["energy"] = _balance(problem, state, duties, releases)
    if chemistry is not None:
        chemistry_results.fill(problem, chemistry, state, result)
    if c.computed is not None:
        result.warnings += _condensing(scene.mixture, c.gases, result.profiles)
    if wanted:
        _only_at(wanted, positions, result)
    if c.albedo is not None:
        use = usage(optics.radiation_emissivity_half_space, albedo=c.albedo)
        result.closures.append(use.to_dict())


def _of_expansion(scene: Any, dense: float) -> list[str]:
    """Warn of an expansion that leaves another height without its bubbles [m] than the
    settled bed has.
    """
    given = scene.bubbling_bed.settled_height
    if scene.closures.expansion is None or given is None:
        return []
    if abs(dense / given - 1.0) <= SAME_CONTENT:
        return []
    return [
        f"closures.expansion: without its bubbles the bed is {dense:.3g} m high, "
        f"bubbling_bed.settled_height is {given:.3g} m: the particles of this run, and "
        f"what depends on them, are {dense / given:.0%} of the settled ones; without "
        "closures.expansion the volume of the bubbles gives the height"
    ]


def _condensing(
    gas: GasCantera, streams: Sequence[str], profiles: Mapping[str, Any]
) -> list[str]:
    """Warn of water that would condense in the gas of the bed."""
    entering = mole_fractions(gas.composition).get("H2O", 0.0)
    found = []
    for name in streams:
        T, phase = profiles[f"{name} [K]"], name.removeprefix("T_")
        x = profiles.get(f"x_H2O_{phase} [1]", np.full(len(T), entering))
        inside = np.isfinite(T)  # a freeboard has rows of its own
        at = (profiles["z [m]"], T, gas.pressure * x)
        found += above_saturation(
            f"the gas of the {phase}", *(each[inside] for each in at)
        )
    return found[:1]


def _only_at(wanted: Any, z: Any, result: Result) -> None:
    """Leave the rows of profiles at given heights; those of the freeboard are mirrored
    at the surface of the bed.
    """
    keep = np.isin(z, wanted)
    keep = np.append(keep, keep[::-1][1:])
    result.profiles = {
        key: column[keep[: len(column)]] for key, column in result.profiles.items()
    }


FREEBOARD = (
    "T_freeboard [K]",
    "T_up [K]",
    "T_down [K]",
    header("flow_up"),
    header("G_freeboard"),
)


def _water(
    problem: BubblingProblem,
    name: str,
    state: Any,
    result: Result,
    values: dict[str, Any],
) -> None:
    """Fill in the results of water inside a surface: profiles, outlet, and its own
    balance.
    """
    from contbed.materials.steam import steam

    table = problem.plan.scene.bubbling_bed.surfaces[name].steam
    assert table is not None
    water = steam(table.pressure)
    padded = np.full(len(result.profiles["z [m]"]), np.nan)
    for key, column in (
        (f"T_{name}_surface [K]", values["T"]),
        (f"T_{name}_water [K]", water.temperature(values["h"])),
        (f"h_{name}_water [kJ/kg]", values["h"]),
    ):
        padded[: len(column)] = column
        result.profiles[key] = padded.copy()
    h_in = water.enthalpy(table.temperature)
    end = problem.top if table.direction == "up" else problem.bottom
    h_out = problem.at(lambda u, o: getattr(u, f"h_{name}"), end, state)
    gained = sum(
        value
        for key, value in problem.duties(state).items()
        if key in (f"{name}_convection_W", f"{name}_radiation_W")
    )
    flow = 1e3 * table.mass_flow
    result.qoi |= {
        f"{name}_water_W": flow * (h_out - h_in),
        f"{name}_water_out_K": float(water.temperature(h_out)),
        f"{name}_water_out_kJ_kg": h_out,
    }
    if (quality := water.quality(h_out)) is not None:
        result.qoi[f"{name}_water_out_quality"] = quality
    if not water.h_range[0] <= h_out <= water.h_range[1]:
        result.warnings.append(
            f"{name}: water leaves at {h_out:g} kJ/kg, outside of its table"
        )
    result.balances[f"water in {name}"] = Balance(
        flow * h_in, flow * h_out, "W", gained
    ).as_dict()


HYDRODYNAMICS = ("u", "u_mf", "u_e", "u_b", "delta", "flow_bubble", "d_b")


def _computed(
    plan: BubblingPlan, values: dict[str, Any], z: Any, used: list[Any], result: Result
) -> None:
    """Fill in the values of closures over the height.

    Warn where they, as used at equally spaced heights, or the properties of the gas
    leave their range.
    """
    computed = plan.coefficients.computed
    local, _ = computed.recorded(values, z)
    found = local.state | {"flow_bubble": values.get("flow_bubble")}
    for name in HYDRODYNAMICS:
        if found.get(name) is not None:
            values_along = np.broadcast_to(found[name], z.shape)
            result.profiles[header(name)] = values_along.copy()
    if computed.above is not None:
        used += _freeboard(computed.above, values, local, z, result)
    result.closures += used
    for use in used:
        if use["share_outside"] > 0:
            result.warnings.append(
                f"{use['used_by']}: {use['name']} is used out of its range on "
                f"{100 * use['share_outside']:.3g} % of the height"
            )
    for name, value in local.contact.items():
        result.qoi[f"{name}_coefficient_W_m2K"] = float(
            trapezoid(np.broadcast_to(value, z.shape), z) / np.ptp(z)
        )
    emulsion = 1.0 - np.broadcast_to(local.delta, z.shape)
    dense = float(trapezoid(emulsion, z))
    result.qoi["pressure_drop_Pa"] = (
        GRAVITY * computed.solids * computed.rho_solid * dense
    )
    if computed.bubbling:
        result.qoi["height_at_minimum_fluidization_m"] = dense
        result.warnings += _of_expansion(plan.scene, dense)
        text = flows_down(
            plan.scene, np.broadcast_to(local.state["u_emulsion_closure"], z.shape), z
        )
        if text is not None:
            raise ConvergenceError(text, result.history)
    bare = found["u"] - found["u_mf"] <= UNFLUIDIZED * found["u_mf"]
    if computed.bubbling and np.any(bare):
        low, high = z[np.broadcast_to(bare, z.shape)][[0, -1]]
        result.warnings.append(
            f"{100 * float(np.mean(bare)):.3g} % of the height is not fluidized, "
            f"between {low:.3g} and {high:.3g} m: "
            "all gas flows through the emulsion there, and u is that of u_mf; more "
            "gas.mass_flow or hotter gas "
            "fluidizes it"
        )
    gas = computed.gas
    for phase in {name for name in ("T_emulsion", "T_bubble") if name in values}:
        T = values[phase]
        if text := extrapolation(phase, gas.heat_capacity, gas.T_range, T):
            result.warnings.append(text)
    for name, item in computed.scene.present.items():
        T = values.get(f"T_{name}", computed.scene.initial.temperature)
        if share_outside(T, item.data_range):
            low, high = item.data_range
            result.warnings.append(
                f"solids.{name}: data from {low:g} to {high:g} K are used at "
                f"{np.min(T):.5g} to {np.max(T):.5g} K"
            )


def _freeboard(
    above: Any, values: dict[str, Any], local: Any, z: Any, result: Result
) -> list[Any]:
    """Fill in profiles above the bed; return how the freeboard used its closures.

    The freeboard is upside down on the mesh of the bed.
    """
    part, computed = above.part, above.computed
    computed.ranges = []
    above.local_coefficients(SimpleNamespace(**values), None)
    ejected = float(np.broadcast_to(above.ejected(local), z.shape)[-1])
    used: list[Any] = computed.ranges
    computed.ranges = None
    result.qoi |= {
        "ejected_kg_m2s": ejected,
        "carryover_kg_s": part.section * values["carryover"],
        "T_freeboard_out_K": float(values["T_freeboard"][0]),
    }
    fed = sum(item.fed_solids for item in computed.scene.present.values())
    sized = any(item.sizes is not None for item in computed.scene.present.values())
    beyond = values["carryover"] - ROUNDED_CARRYOVER
    if not sized and part.section * beyond > fed:
        result.warnings.append(
            f"gas carries away {part.section * values['carryover']:.3g} kg/s of "
            "particles, "
            f"{fed:.3g} kg/s are fed: give solids.NAME.sizes, or solids.NAME.feed for "
            "what replaces them"
        )
    if beyond > ejected:
        result.warnings.append(
            "the gas carries away more particles than the bubbles throw up, "
            "which is impossible: choose another "
            "bubbling_bed.freeboard.elutriation"
        )
    above_bed = part.bed + (part.bed - z[::-1]) * part.stretch
    nothing = np.full(len(z) - 1, np.nan)
    for key, column in result.profiles.items():
        result.profiles[key] = np.append(
            column, above_bed[1:] if key == "z [m]" else nothing
        )
    for key in FREEBOARD:
        if name_of(key) in values:
            rising = values[name_of(key)][::-1]
            result.profiles[key] = np.concatenate([nothing, rising])
    if above.species is not None:
        from contbed.bubbling_bed.chemistry import results as chemistry_results

        shares = chemistry_results.mole_fractions(above.species, values, "freeboard")
        result.profiles |= {
            key: np.concatenate([nothing, x[::-1]]) for key, x in shares.items()
        }
    return used


def _balance(
    problem: BubblingProblem,
    state: Any,
    duties: dict[str, float],
    releases: dict[str, float],
) -> dict[str, Any]:
    """Return the energy balance [W]: heat above 0 K of streams, heat to surfaces and
    freeboard, and release of phases.

    The gas carries away the heat that the distributor takes.
    """
    parts = [
        value
        for brought, taken in problem.carried(state).values()
        for value in (brought, -taken)
    ]
    inside = (
        ("distributor",) if problem.above is None else ("distributor", "top_radiation")
    )
    parts += [-value for name, value in duties.items() if not name.startswith(inside)]
    return Balance.of_fluxes(parts, "W", sum(releases.values())).as_dict()
