"""Solution of a fully developed flow and what a user reads of it: profiles, results, balances, other solutions."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from contbed.closures import usage
from contbed.developed_flow import equations as model
from contbed.developed_flow.problem import TYPICAL, DevelopedProblem
from contbed.result import Result
from contbed.solvers.branch import trace
from contbed.solvers.linear import constrain

Array = Any
ALIGNED = 3  # rounds that move a node to where gas and particles are equally fast
NEAR = 1e-3  # share of a cell within which it is there
APART = 1e-4  # relative difference of granular temperatures at the centre of two solutions
MEANT = 0.1  # within which a solution is the one that was asked for
SPAN, POINTS = 1.5, 60  # factor on the velocity both ways, and solutions on the way, where others are looked for


def solve(plan: Any, result: Result, folder: Path | None, quiet: bool, start: Any) -> None:
    """Solve and fill the result; steady and quick, so that `folder`, `quiet` and `start` have no use."""
    meant = plan.scene.fully_developed.theta_centre
    problem = DevelopedProblem(plan)
    state, history = problem.solve(meant or TYPICAL)
    result.history += history
    problem, state = aligned(problem, state)
    if problem.particles and plan.scene.solver.branches:
        state = _nearest(problem, state, meant, result)
        problem, state = aligned(problem, state)
    result.plan = problem.plan  # type: ignore[assignment]
    findings(problem, state, result)
    if problem.particles and meant is not None and abs(result.qoi["theta_centre"] / meant - 1.0) > MEANT:
        where = plan.scene.origin.at(("fully_developed", "theta_centre"))
        more = "" if plan.scene.solver.branches else "; solver.branches = true looks for others"
        found = result.qoi["theta_centre"]
        result.warnings.append(f"{where}: theta at the centre is {found:.4g} m2/s2, not near {meant:g}{more}")


def aligned(problem: DevelopedProblem, state: Array) -> tuple[DevelopedProblem, Array]:
    """The solution on a mesh with a node wherever gas and particles are equally fast: drag has a kink there."""
    for _ in range(ALIGNED if problem.particles else 0):
        nodes = np.sort(problem.plan.mesh.skfem.p[0])
        moved = nodes.copy()
        for place in _crossings(problem, state):
            k = 1 + int(np.argmin(np.abs(nodes[1:-1] - place)))
            if abs(nodes[k] - place) > NEAR * (nodes[k + 1] - nodes[k - 1]):
                moved[k] = place
        if np.array_equal(moved, nodes):
            break
        problem = DevelopedProblem(problem.plan.on(moved))
        state, _ = problem.solve_from(state)
    return problem, state


def _crossings(problem: DevelopedProblem, state: Array) -> Array:
    order = np.argsort(problem.r)
    r, slip = problem.r[order], (problem.system.part(state, "u_gas") - problem.system.part(state, "u_solid"))[order]
    k = np.flatnonzero(slip[:-1] * slip[1:] < 0)
    return r[k] + (r[k + 1] - r[k]) * slip[k] / (slip[k] - slip[k + 1])


def findings(problem: DevelopedProblem, state: Array, result: Result) -> None:
    """Profiles, named results, balances and the use of closures."""
    c, system = problem.c, problem.system
    order = np.argsort(problem.r)
    values = {name: system.part(state, name) for name in system.fields}
    columns = {"r [m]": problem.r[order], "u_gas [m/s]": values["u_gas"][order]}
    result.nodal["u_gas"] = (system.fields["u_gas"][0], values["u_gas"])
    result.qoi["pressure_gradient_Pa_m"] = float(values["gradient"][0])
    result.qoi["u_gas_centre"] = float(columns["u_gas [m/s]"][0])
    if problem.particles:
        at = model.local(SimpleNamespace(**values), c)
        profiles = {
            "u_solid [m/s]": values["u_solid"],
            "theta [m2/s2]": values["root"] ** 2,
            "eps_s [1]": at.eps_s,
            "beta [kg/m3/s]": at.beta,
            "mu_solid [Pa s]": at.mu,
        }
        for header, column in profiles.items():
            columns[header] = column[order]
            name = header.partition(" ")[0]
            result.nodal[name] = (system.fields["u_solid"][0], column)
            if name in ("u_solid", "theta", "eps_s"):
                result.qoi |= {
                    f"{name if name != 'eps_s' else 'eps_solid'}_{place}": float(column[order][k])
                    for place, k in (("centre", 0), ("wall", -1))
                }
        result.qoi["pressure_solid_Pa"] = float(values["pressure"][0])
        result.qoi["eps_solid_mean"] = _mean(problem, state, lambda u, o: model.local(u, c).eps_s)
        known = {"eps_s": at.eps_s, "g0": at.g0, "eps": 1.0 - at.eps_s, "Re": at.Re}
        for kind, (function, _) in c.laws.items():
            result.closures.append(usage(function, **c.given(kind, **known)).to_dict())
    result.profiles |= columns
    result.balances |= balances(problem, state)


def balances(problem: DevelopedProblem, state: Array) -> dict[str, dict[str, Any]]:
    """Momentum, of which the pressure gradient brings what weight and walls take [N/m3], and the two flows.

    The stress of the gas on the wall is what its discrete momentum lacks there.
    """
    c, system = problem.c, problem.system
    section = float(system.cells.weight.sum())
    missing = float(problem.steady(state, False)[0][problem.fixed].sum())
    gradient = float(system.part(state, "gradient")[0])
    weight, stress, flux = c.rho_gas * c.gravity, 0.0, 0.0
    gas = _mean(problem, state, lambda u, o: u.u_gas)
    if problem.particles:
        weight = _mean(problem, state, lambda u, o: _density(u, c)) * c.gravity
        stress = system.integrate(lambda u, o: model.wall_stress(u, model.local(u, c), c), [problem.wall], state)
        gas = _mean(problem, state, lambda u, o: (1.0 - model.local(u, c).eps_s) * u.u_gas)
        flux = _mean(problem, state, lambda u, o: c.rho_solid * model.local(u, c).eps_s * u.u_solid)
    taken = weight + (stress - missing) / section
    out = {"momentum": _balance(gradient, taken, "Pa/m"), "gas flow": _balance(c.velocity, gas, "m/s")}
    if problem.particles:
        out["solids flow"] = _balance(c.solid_flux, flux, "kg/m2/s")
    return out


def _density(u: Any, c: model.Coefficients) -> Any:
    eps_s = model.local(u, c).eps_s
    return (1.0 - eps_s) * c.rho_gas + eps_s * c.rho_solid


def _mean(problem: DevelopedProblem, state: Array, expression: Any) -> float:
    """Over the section."""
    cells = problem.system.cells
    return problem.system.integrate(expression, [cells], state) / float(cells.weight.sum())


def _balance(given: float, found: float, unit: str) -> dict[str, Any]:
    scale = max(abs(given), abs(found), 1e-300)
    return {
        "in": given,
        "out": found,
        "source": 0.0,
        "stored": 0.0,
        "relative_residual": (given - found) / scale,
        "unit": unit,
    }


def _nearest(problem: DevelopedProblem, state: Array, meant: float | None, result: Result) -> Array:
    """Of all solutions found, in branches.csv, the one that is meant; without a word on it the one at hand."""
    found = [state, *others(problem, state, result)]
    found.sort(key=lambda each: _centre(problem, each))
    result.qoi["solutions_found"] = len(found)
    columns = {
        "theta_centre [m2/s2]": [_centre(problem, each) for each in found],
        "pressure_gradient [Pa/m]": [problem.system.part(each, "gradient")[0] for each in found],
    }
    result.tables["branches"] = {header: np.array(column, dtype=float) for header, column in columns.items()}
    if meant is None:
        return state
    return min(found, key=lambda each: abs(np.log(_centre(problem, each) / meant)))


def others(problem: DevelopedProblem, state: Array, result: Result) -> list[Array]:
    """Other solutions for the same flows, where the branch over the velocity comes back to it after its folds."""
    velocity, policy = problem.c.velocity, problem.plan.policy

    def assemble(x: Array, value: float, jacobian: bool) -> tuple[Array, Any]:
        residual, matrix = problem.having(velocity=float(value)).steady(x, jacobian)
        residual[problem.fixed] = 0.0
        return residual, constrain(matrix, problem.fixed) if jacobian else None

    found = [state]
    for stop, back in ((velocity / SPAN, velocity * SPAN), (velocity * SPAN, velocity / SPAN)):
        branch = trace(
            assemble, state, velocity, stop, policy, weights=problem.weights, size=velocity, points=POINTS, back=back
        )
        if not branch.complete:
            end = branch.parameter[-1]
            result.warnings.append(f"the branch over the velocity is followed to {end:.4g} m/s, not to {stop:.4g}")
        values, states = list(branch.parameter), list(branch.states)
        for place, value, turn in reversed(branch.folds):
            values.insert(place, value)
            states.insert(place, turn)
        ahead = np.array(values) - velocity
        for k in np.flatnonzero(ahead[:-1] * ahead[1:] < 0):
            share = ahead[k] / (ahead[k] - ahead[k + 1])
            other, _ = problem.solve_from((1.0 - share) * states[k] + share * states[k + 1])
            if all(abs(_centre(problem, other) / _centre(problem, known) - 1.0) > APART for known in found):
                found.append(other)
    return found[1:]


def _centre(problem: DevelopedProblem, state: Array) -> float:
    """Granular temperature at the centre [m2/s2]."""
    return float(problem.system.part(state, "root")[np.argmin(problem.r)] ** 2)
