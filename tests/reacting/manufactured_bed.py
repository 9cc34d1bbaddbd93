"""A made-up state of a reacting bed, and the sources that make it a solution, written
independently of the package.

Gases A and B of unlike masses with dispersion, A -> B in the gas, A adsorbed by
particles that move against the gas or rest, two temperatures with exchange and
conduction. Derivatives are those of complex steps, exact to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from reacting_bed_scenes import R_GAS, P, isothermal, let_move

from contbed.fem.line_dg import Ends, System
from contbed.loading import from_dict
from contbed.reacting_bed.plan import plan

STEP = 1e-30  # of complex steps
EPS, D, K_RATE, D_BED, H_HEAT, K_F, K_S = 0.4, 3e-3, 2.0, 5e-3, 4e3, 0.8, 1.5
D_GAS, SHERWOOD, HENRY = 1e-5, 3.0, 2e-6
RHO, C_S, T_0 = 60.0, 500.0, 298.15
M_A, M_B = 0.02, 0.03
CP, H_A, H_B = 40.0, 2e4, -1e4
AREA = 6.0 * (1.0 - EPS) / D
FILM = AREA * SHERWOOD * D_GAS / D  # [1/s]
NAMES = ("g_A", "g_B", "T_fluid", "T_solid", "a_A_0")


def scene(
    velocity_solid: float, cells: int, degree: int, transient: bool
) -> dict[str, Any]:
    """The scene whose equations are those of `fluxes`, `sources` and `contents`."""
    gases = {}
    for name, mass, h in (("A", M_A, H_A), ("B", M_B, H_B)):
        gases[name] = {
            "elements": {"H": mass * 1e3},
            "molar_mass": mass,
            "heat_capacity": CP,
            "enthalpy": h,
        }
    made = isothermal("A:0.7, B:0.3", gases)
    made["mesh"]["cells"] = cells
    made["gas"] |= {"diffusivity": D_GAS, "conductivity": 0.03, "viscosity": 2e-5}
    made["solids"]["particles"] |= {"density": RHO, "heat_capacity": C_S}
    # A -> B does not balance with unlike masses of one element: 3 A -> 2 B does
    made["reactions"] = {
        "r": {"equation": "3 A -> 2 B", "A": K_RATE, "E": 0.0, "orders": {"A": 1.0}}
    }
    made["heat"] = {}
    made["closures"] |= {
        "nusselt": H_HEAT / AREA * D / 0.03,
        "conductivity_gas": K_F,
        "conductivity_solids": K_S,
    }
    made["closures"] |= {"dispersion_mass": D_BED, "sherwood": SHERWOOD}
    made["solids"]["particles"]["adsorption"] = {
        "A": {"henry": HENRY, "diffusivity": 1e-6}
    }
    made["solids"]["particles"]["inside"] = {"adsorption": "film"}
    made["solver"] = {"degree": degree}
    if velocity_solid:
        let_move(made, velocity_solid * (1.0 - EPS), temperature=400.0)
    if transient:
        made["time"] = {"end": 1.0}
        made["packed_bed"]["gas_storage"] = "stored"
        made["initial"] |= {"gas": {"composition": "B:1"}}
    return made


def fields(x: Any, t: Any) -> tuple[list[Any], list[Any]]:
    """Unknowns and their slopes; what diffuses has no slope where its stream leaves,
    x = 1 (solids x = 0).
    """
    w, s = 0.5 * np.pi, 1.0 + 0.3 * np.sin(2.0 * t)
    c = 1.0 + 0.2 * np.cos(3.0 * t)
    values = [
        8.0 - 2.0 * s * np.sin(w * x),
        4.0 + 1.5 * c * np.sin(w * x),
        500.0 + 40.0 * s * np.sin(w * x),
        450.0 - 30.0 * c * np.cos(w * x),
        7.0 + 2.0 * s * np.cos(2.0 * x),
    ]
    slopes = [
        -2.0 * s * w * np.cos(w * x),
        1.5 * c * w * np.cos(w * x),
        40.0 * s * w * np.cos(w * x),
        30.0 * c * w * np.sin(w * x),
        -4.0 * s * np.sin(2.0 * x),
    ]
    return values, slopes


def _enthalpies(T: Any) -> tuple[Any, Any]:
    return H_A + CP * (T - T_0), H_B + CP * (T - T_0)


def _adsorbed(u: list[Any]) -> Any:
    return (1.0 - EPS) * RHO * HENRY * R_GAS * u[3] * u[4]


def fluxes(x: Any, t: Any, v: float) -> list[Any]:
    """Fluxes of all equations along x."""
    u, q = fields(x, t)
    G = M_A * u[0] + M_B * u[1]
    rho = P / (R_GAS * u[2]) * G / (u[0] + u[1])
    # of the mass fraction of A
    slope = (M_A * q[0] * G - M_A * u[0] * (M_A * q[0] + M_B * q[1])) / G**2
    J_A, J_B = -EPS * rho * D_BED * slope / M_A, EPS * rho * D_BED * slope / M_B
    h_A, h_B = _enthalpies(u[2])
    gas = (u[0] + J_A) * h_A + (u[1] + J_B) * h_B - K_F * q[2]
    held = _adsorbed(u)
    solid = (
        v * ((1.0 - EPS) * RHO * C_S * (u[3] - T_0) + held * _enthalpies(u[3])[0])
        - K_S * q[3]
    )
    return [u[0] + J_A, u[1] + J_B, gas, solid, v * held]


def sources(x: Any, t: Any) -> list[Any]:
    """Sources of all equations."""
    u, _ = fields(x, t)
    c = u[0] / (u[0] + u[1]) * P / (R_GAS * u[2])
    rate = EPS * K_RATE * c
    taken = FILM * (c - u[4])
    passed = H_HEAT * (u[3] - u[2]) + np.where(
        np.real(taken) > 0.0, -taken * _enthalpies(u[2])[0], 0.0
    )
    passed = passed + np.where(np.real(taken) > 0.0, 0.0, -taken * _enthalpies(u[3])[0])
    return [-3.0 * rate - taken, 2.0 * rate, passed, -passed, taken]


def contents(x: Any, t: Any) -> list[Any]:
    """What is held per volume of bed."""
    u, _ = fields(x, t)
    molar = EPS * P / (R_GAS * u[2])
    n = [molar * g / (u[0] + u[1]) for g in u[:2]]
    h_A, h_B = _enthalpies(u[2])
    held = _adsorbed(u)
    solid = (1.0 - EPS) * RHO * C_S * (u[3] - T_0) + held * _enthalpies(u[3])[0]
    return [n[0], n[1], n[0] * h_A + n[1] * h_B, solid, held]


def added(x: Any, t: float, v: float, transient: bool) -> list[Any]:
    """What has to be added to the sources for `fields` to be the solution."""
    along = [f.imag / STEP for f in fluxes(x + 1j * STEP, t, v)]
    out = [a - np.real(s) for a, s in zip(along, sources(x, t), strict=True)]
    if transient:
        out = [
            a + f.imag / STEP
            for a, f in zip(out, contents(x, t + 1j * STEP), strict=True)
        ]
    return out


@dataclass(frozen=True)
class Driven:
    """A bed whose sources are those that make `fields` its solution at a time."""

    bed: Any
    t: float
    transient: bool

    def __call__(self, u: Any, q: Any, x: Any) -> Any:
        C, diffusive, S = self.bed(u, q, x)
        more = added(x, self.t, self.bed.velocity_solid, self.transient)
        return C, diffusive, [a + b for a, b in zip(S, more, strict=True)]

    def convective(self, u: Any) -> Any:
        return self.bed.convective(u)

    def diffusive(self, u: Any, q: Any) -> Any:
        return self.bed.diffusive(u, q)


def problem_of(
    velocity_solid: float, cells: int, degree: int, transient: bool = False
) -> Any:
    """The bed of the scene, its gas stored where it is transient."""
    made = plan(from_dict(scene(velocity_solid, cells, degree, transient))).problem
    assert made.layout.names == NAMES
    return made.with_gas_stored(P) if transient else made


def at(problem: Any, t: float, transient: bool = False) -> Any:
    """A copy of the problem with the sources and streams at a time."""
    copy, v = replace(problem), problem.bed.velocity_solid
    ends = problem.system.ends
    x = (0.0, 1.0)
    inflow = tuple(
        np.array([float(np.real(f)) for f in fluxes(x[k], t, v)]) for k in (0, 1)
    )
    flux = tuple(np.where(ends.given[k], inflow[k], 0.0) for k in (0, 1))
    if not v:  # no heat passes the ends of a bed at rest
        for end in flux:
            end[3] = 0.0
    base = problem.system

    directions = [1 if ahead else -1 for ahead in base.ahead]
    given = Ends((flux[0], flux[1]), ends.given, ends.value)
    copy.__dict__["system"] = System(
        problem.line,
        directions,
        base.diffuses,
        Driven(problem.bed, t, transient),
        given,
    )
    return copy


def exact(problem: Any, t: float) -> Any:
    """The made-up state at the nodes (m, N, p + 1)."""
    return np.array(fields(problem.line.points, t)[0])
