"""Results of a fully developed flow: profiles, named results, balances."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from contbed.balance import Balance
from contbed.developed_flow import equations as model
from contbed.developed_flow.problem import DevelopedProblem
from contbed.result import Result

Array = Any


def fill(problem: DevelopedProblem, state: Array, result: Result) -> None:
    """Fill in the profiles, named results, balances and the use of closures."""
    c, system = problem.c, problem.system
    order = np.argsort(problem.r)
    values = {name: system.part(state, name) for name in system.fields}
    columns = {"r [m]": problem.r[order], "u_gas [m/s]": values["u_gas"][order]}
    result.nodal["u_gas"] = (system.fields["u_gas"][0], values["u_gas"])
    result.qoi["pressure_gradient_Pa_m"] = float(values["gradient"][0])
    result.qoi["u_gas_centre"] = float(columns["u_gas [m/s]"][0])
    known: dict[str, Any] = {}
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
                    f"{name if name != 'eps_s' else 'eps_solid'}_{place}": float(
                        column[order][k]
                    )
                    for place, k in (("centre", 0), ("wall", -1))
                }
        result.qoi["pressure_solid_Pa"] = float(values["pressure"][0])
        result.qoi["eps_solid_mean"] = _mean(
            problem, state, lambda u, o: model.local(u, c).eps_s
        )
        known = {
            "eps_s": at.eps_s,
            "g0": at.g0,
            "eps": 1.0 - at.eps_s,
            "Re": at.Re,
            "beta": at.beta,
        }
    _closures_used(problem, values, known, result)
    result.profiles |= columns
    result.balances |= balances(problem, state)


def _closures_used(
    problem: DevelopedProblem,
    values: dict[str, Array],
    known: dict[str, Any],
    result: Result,
) -> None:
    """Note the ranges that closures saw; the shear rate of the gas is that between
    nodes.
    """
    c, order = problem.c, np.argsort(problem.r)
    beta = known.pop("beta", 0.0)
    for kind, closure in c.closures.items():
        if kind == "eddy_viscosity":
            shear = np.empty_like(problem.r)
            shear[order] = np.gradient(values["u_gas"][order], problem.r[order])
            arguments = c.eddies(problem.r, shear, known.get("eps_s", 0.0), beta)
        elif problem.particles:
            arguments = known
        else:
            continue
        result.closures.append(
            closure.use(**c.closure_arguments(**arguments)).to_dict()
        )


def balances(problem: DevelopedProblem, state: Array) -> dict[str, dict[str, Any]]:
    """Return the momentum balance [N/m3] and the two flow rates.

    The pressure gradient carries the weight of both phases and the stress on the wall.
    The stress of the gas on the wall is the residual of its discrete momentum there.
    """
    c, system = problem.c, problem.system
    section = float(system.cells.weight.sum())
    missing = float(problem.steady(state, False)[0][problem.fixed].sum())
    gradient = float(system.part(state, "gradient")[0])
    weight, stress, flux = c.rho_gas * c.gravity, 0.0, 0.0
    gas = _mean(problem, state, lambda u, o: u.u_gas)
    if problem.particles:
        weight = _mean(problem, state, lambda u, o: _density(u, c)) * c.gravity
        stress = system.integrate(
            lambda u, o: model.wall_stress(u, model.local(u, c), c),
            [problem.wall],
            state,
        )
        gas = _mean(
            problem, state, lambda u, o: (1.0 - model.local(u, c).eps_s) * u.u_gas
        )
        flux = _mean(
            problem,
            state,
            lambda u, o: c.rho_solid * model.local(u, c).eps_s * u.u_solid,
        )
    taken = weight + (stress - missing) / section
    out = {
        "momentum": Balance(gradient, taken, "Pa/m"),
        "gas flow": Balance(c.velocity, gas, "m/s"),
    }
    if problem.particles:
        out["solids flow"] = Balance(c.solid_flux, flux, "kg/m2/s")
    return {name: balance.as_dict() for name, balance in out.items()}


def _density(u: Any, c: model.Coefficients) -> Any:
    eps_s = model.local(u, c).eps_s
    return (1.0 - eps_s) * c.rho_gas + eps_s * c.rho_solid


def _mean(problem: DevelopedProblem, state: Array, expression: Any) -> float:
    """Return the mean of an expression over the section."""
    cells = problem.system.cells
    return problem.system.integrate(expression, [cells], state) / float(
        cells.weight.sum()
    )
