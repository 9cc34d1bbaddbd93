"""Solution of a bubbling bed and what a user reads of it: profiles, temperatures, heat duties, energy balance."""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.bubbling.planning import BubblingPlan
from contbed.bubbling.problem import BubblingProblem
from contbed.closures import optics, registry
from contbed.errors import ConvergenceError
from contbed.problem.probe import Probe, axis_points
from contbed.result import Result

COLD, HOT = 400.0, 2000.0  # temperatures from which other steady states are looked for [K]
APART = 1.0  # difference of temperatures of two steady states [K]


def solve(plan: Any, result: Result) -> None:
    """Solve and fill the result."""
    problem = BubblingProblem(plan)
    state, history = problem.solve()
    result.history += history
    findings(plan, problem, state, result)
    scene = plan.scene
    if any(item.release is not None and item.release.activation for item in (scene.gas, *scene.present.values())):
        result.qoi["steady_states_found"] = _steady_states(problem, state, result)


def _steady_states(problem: BubblingProblem, state: Any, result: Result) -> int:
    """Number of states, with those that a cold and a hot guess lead to: release that grows with T allows several."""
    found = [state]
    for guess in (COLD, HOT):
        try:
            other, _ = problem.solve(guess)
        except ConvergenceError:
            result.warnings.append(f"no steady state was found from a uniform {guess:g} K")
            continue
        if all(_distance(problem, other, known) > APART for known in found):
            here, there = (
                np.mean([problem.system.part(each, f"T_{name}") for name in problem.c.species])
                for each in (state, other)
            )
            result.warnings.append(
                f"this is one of several steady states: its particles are at {here:.6g} K on average, those of another "
                f"at {there:.6g} K; solver.guess = {guess:g} leads there"
            )
            found.append(other)
    return len(found)


def _distance(problem: BubblingProblem, a: Any, b: Any) -> float:
    """Largest difference of a temperature [K]."""
    names = problem.c.streams
    return max(float(np.abs(problem.system.part(a, name) - problem.system.part(b, name)).max()) for name in names)


def findings(plan: BubblingPlan, problem: BubblingProblem, state: Any, result: Result) -> None:
    """Profiles, named results and the energy balance of a state."""
    scene, c, space = plan.scene, plan.coefficients, problem.space
    nodal = {name: problem.system.part(state, name) for name in c.fields}
    wanted = np.unique(scene.output.positions) if scene.output.positions else None
    positions, points = axis_points(plan.mesh, wanted)
    probe = Probe(plan.mesh, points)
    result.profiles = {"z [m]": positions} | {f"{name} [K]": probe(space, nodal[name]) for name in c.streams}
    if "G" in nodal:
        result.profiles["G [W/m2]"] = probe(space, nodal["G"])
        result.profiles["q_radiation [W/m2]"] = -c.diffusion * probe.slope(space, nodal["G"], 0)
    result.nodal |= {name: (space, values) for name, values in nodal.items()}

    height = scene.bubbling_bed.height
    middle, top = Probe(plan.mesh, np.array([[0.5 * height]])), Probe(plan.mesh, np.array([[height]]))
    if c.plate is not None:
        result.qoi["T_distributor_K"] = float(problem.system.part(state, "T_distributor")[0])
    result.qoi |= {f"T_{name}_mid_K": float(middle(space, nodal[f"T_{name}"])[0]) for name in c.species}
    result.qoi |= {f"{name}_top_K": float(top(space, nodal[name])[0]) for name in c.gases}
    duties, releases = problem.duties(state), problem.releases(state)
    result.qoi |= duties | {f"release_{name}_W": value for name, value in releases.items()}
    result.balances["energy"] = _balance(problem, state, duties, releases)
    if plan.albedo is not None:
        use = registry.usage(optics.radiation_emissivity_half_space, albedo=plan.albedo)
        result.closures = [use.to_dict()]


def _balance(
    problem: BubblingProblem, state: Any, duties: dict[str, float], releases: dict[str, float]
) -> dict[str, Any]:
    """Heat above 0 K that streams carry, surfaces and freeboard take, and phases release [W]. The gas carries away
    what the distributor takes.
    """
    parts = [value for brought, taken in problem.carried(state).values() for value in (brought, -taken)]
    parts += [-value for name, value in duties.items() if not name.startswith("distributor")]
    entering, leaving = sum(part for part in parts if part > 0), -sum(part for part in parts if part < 0)
    source = sum(releases.values())
    scale = max(entering, leaving, abs(source), 1e-300)
    return {
        "in": entering, "out": leaving, "source": source, "stored": 0.0,
        "relative_residual": (entering + source - leaving) / scale, "unit": "W",
    }  # fmt: skip

