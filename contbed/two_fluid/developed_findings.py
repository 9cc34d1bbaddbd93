"""Solution of a fully developed flow and what a user reads of it: profiles, results, balances, other solutions."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from contbed.closures import usage
from contbed.errors import ConvergenceError
from contbed.models import developed_flow as model
from contbed.result import Result
from contbed.two_fluid.developed_planning import DevelopedPlan
from contbed.two_fluid.developed_problem import DevelopedProblem

Array = Any
ALIGNED = 3  # rounds that move a node to where gas and particles are equally fast
NEAR = 1e-3  # share of a cell within which it is there
APART = 1e-4  # relative difference of granular temperatures at the centre of two solutions
MEANT = 0.1  # within which a solution is the one that was asked for
DECADES = (-3, -2, -1, 1, 2)  # powers of 10 times the given theta from which others are looked for


def solve(plan: Any, result: Result) -> None:
    """Solve and fill the result."""
    table = plan.scene.fully_developed
    problem = DevelopedProblem(plan)
    state, history = problem.solve(table.theta_centre)
    result.history += history
    problem, state = aligned(problem, state)
    result.plan = problem.plan  # type: ignore[assignment]
    findings(problem, state, result)
    if problem.particles and plan.scene.solver.branches:
        _others(problem, state, result)
    if problem.particles and abs(result.qoi["theta_centre"] / table.theta_centre - 1.0) > MEANT:
        where = plan.scene.origin.at(("fully_developed", "theta_centre"))
        result.warnings.append(
            f"the solution found has theta {result.qoi['theta_centre']:.4g} m2/s2 at the centre; from "
            f"{table.theta_centre:g} ({where}) granular energy settles to it"
        )


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
        profiles = {"u_solid [m/s]": values["u_solid"], "theta [m2/s2]": values["root"] ** 2, "eps_s [1]": at.eps_s,
                    "beta [kg/m3/s]": at.beta, "mu_solid [Pa s]": at.mu}  # fmt: skip
        for header, column in profiles.items():
            columns[header] = column[order]
            name = header.partition(" ")[0]
            result.nodal[name] = (system.fields["u_solid"][0], column)
            if name in ("u_solid", "theta", "eps_s"):
                result.qoi |= {f"{name if name != 'eps_s' else 'eps_solid'}_{place}": float(column[order][k])
                               for place, k in (("centre", 0), ("wall", -1))}  # fmt: skip
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
    return {"in": given, "out": found, "source": 0.0, "stored": 0.0, "relative_residual": (given - found) / scale,
            "unit": unit}  # fmt: skip


def _others(problem: DevelopedProblem, state: Array, result: Result) -> None:
    """Solutions that granular energy settles to from other temperatures, in branches.csv."""
    plan: DevelopedPlan = problem.plan
    found = [state]
    for power in DECADES:
        theta = plan.scene.fully_developed.theta_centre * 10.0**power
        try:
            other, _ = problem.solve(theta)
        except ConvergenceError:
            result.warnings.append(f"granular energy from a level theta of {theta:g} m2/s2 settles to no solution")
            continue
        if all(abs(_centre(problem, other) / _centre(problem, known) - 1.0) > APART for known in found):
            found.append(other)
    found.sort(key=lambda each: _centre(problem, each))
    result.qoi["solutions_found"] = len(found)
    result.tables["branches"] = {
        "theta_centre [m2/s2]": np.array([_centre(problem, each) for each in found]),
        "pressure_gradient [Pa/m]": np.array([problem.system.part(each, "gradient")[0] for each in found]),
    }


def _centre(problem: DevelopedProblem, state: Array) -> float:
    """Granular temperature at the centre [m2/s2]."""
    return float(problem.system.part(state, "root")[np.argmin(problem.r)] ** 2)
