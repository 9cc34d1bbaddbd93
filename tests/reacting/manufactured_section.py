"""A made-up state of a bed resolved across the flow, and the sources that make it a
solution, written independently.

Gases A and B of unlike masses, 3 A -> 2 B in the gas, one temperature; conduction and
dispersion across, a wall coefficient. Derivatives are those of complex steps, exact to
rounding.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from reacting_bed_scenes import R_GAS, P, isothermal

from contbed.fem.line_dg import Ends, System
from contbed.loading import from_dict
from contbed.reacting_bed.equations.section import Section
from contbed.reacting_bed.plan import plan

STEP = 1e-30  # of complex steps
EPS, RADIUS, K_RATE, D_MASS, K_HEAT, H_WALL, T_WALL = (
    0.4,
    0.05,
    2.0,
    2e-4,
    1.5,
    60.0,
    700.0,
)
M = {"A": 0.02, "B": 0.03}
H0 = {"A": 2e4, "B": -1e4}
CP, T_0 = 40.0, 298.15
# so that T meets the wall with its coefficient
BETA = H_WALL * RADIUS / (2.0 * K_HEAT + H_WALL * RADIUS)


def problem_of(shape: str, rings: int, cells: int, degree: int) -> Any:
    """The bed of the scene with these constants."""
    gases = {
        name: {
            "elements": {"H": M[name] * 1e3},
            "molar_mass": M[name],
            "heat_capacity": CP,
            "enthalpy": H0[name],
        }
        for name in M
    }
    made = isothermal("A:0.7, B:0.3", gases)
    made["mesh"]["cells"] = cells
    made["reactions"] = {
        "r": {"equation": "3 A -> 2 B", "A": K_RATE, "E": 0.0, "orders": {"A": 1.0}}
    }
    made["heat"] = {}
    made["mesh"]["diameter"] = 2.0 * RADIUS
    made["boundary"]["wall"] = {"coefficient": H_WALL, "ambient": T_WALL}
    made["packed_bed"]["section"] = {
        "shape": shape,
        "rings": rings,
        "conductivity_solids": K_HEAT,
        "dispersion_mass": D_MASS,
    }
    made["solver"] = {"degree": degree}
    return plan(from_dict(made)).problem


def fields(x: Any, r: Any) -> tuple[list[Any], list[Any]]:
    """g_A, g_B and T, and their slopes across."""
    k, across = np.pi / RADIUS, 1.0 + 0.3 * np.cos(np.pi * r / RADIUS)
    slope, s = -0.3 * k * np.sin(k * r), np.sin(1.5 * x)
    rise = -100.0 - 40.0 * np.cos(1.5 * x)
    values = [
        8.0 - 2.0 * s * across,
        4.0 + 1.5 * s * across,
        T_WALL + rise * (1.0 - BETA * (r / RADIUS) ** 2),
    ]
    return values, [
        -2.0 * s * slope,
        1.5 * s * slope,
        -2.0 * rise * BETA * r / RADIUS**2,
    ]


def _enthalpies(T: Any) -> tuple[Any, Any]:
    return H0["A"] + CP * (T - T_0), H0["B"] + CP * (T - T_0)


def along(x: Any, r: Any) -> list[Any]:
    """Fluxes of all equations along x."""
    (g_A, g_B, T), _ = fields(x, r)
    h_A, h_B = _enthalpies(T)
    return [g_A, g_B, g_A * h_A + g_B * h_B]


def across(x: Any, r: Any) -> list[Any]:
    """What comes inward across the flow, of all equations."""
    (g_A, g_B, T), (s_A, s_B, s_T) = fields(x, r)
    G = M["A"] * g_A + M["B"] * g_B
    rho = P / (R_GAS * T) * G / (g_A + g_B)
    # of the mass fraction of A
    slope = M["A"] * (s_A * G - g_A * (M["A"] * s_A + M["B"] * s_B)) / G**2
    moved = EPS * rho * D_MASS * slope
    N_A, N_B = moved / M["A"], -moved / M["B"]
    h_A, h_B = _enthalpies(T)
    return [N_A, N_B, K_HEAT * s_T + N_A * h_A + N_B * h_B]


def added(x: Any, r: Any, shape: str) -> list[Any]:
    """What has to be added to the sources for `fields` to be the solution."""
    power = 1 if shape == "tube" else 0
    (g_A, g_B, T), _ = fields(x, r)
    rate = EPS * K_RATE * g_A / (g_A + g_B) * P / (R_GAS * T)
    r_c = r + 1j * STEP
    gained = [(r_c**power * N).imag / STEP / r**power for N in across(x, r_c)]
    made = [-3.0 * rate, 2.0 * rate, 0.0]
    return [
        F.imag / STEP - N - S
        for F, N, S in zip(along(x + 1j * STEP, r), gained, made, strict=True)
    ]


@dataclass(frozen=True)
class Driven:
    """The rings with the sources that make `fields` their solution."""

    section: Section

    def __call__(
        self, u: list[Any], q: list[Any], x: Any
    ) -> tuple[list[Any], list[Any], list[Any]]:
        """Fluxes and sources."""
        C, D, S = self.section(u, q, x)
        rings = self.section.rings
        more = [
            np.broadcast_to(f, x.shape)
            for r in rings.middles
            for f in added(x, r, rings.shape)
        ]
        return C, D, [a + b for a, b in zip(S, more, strict=True)]

    def convective(self, u: list[Any]) -> list[Any]:
        """Fluxes of convection."""
        return self.section.convective(u)

    def diffusive(self, u: list[Any], q: list[Any]) -> list[Any]:
        """Fluxes along x of diffusion."""
        return self.section.diffusive(u, q)


def solution(
    shape: str, rings: int, cells: int, degree: int
) -> tuple[Any, Any, Any, int]:
    """The problem, its solution, the exact one at the nodes, and the iterations of
    Newton's method.
    """
    problem = problem_of(shape, rings, cells, degree)
    line, middles, m = problem.line, problem.rings.middles, 3 * rings
    at_inlet = np.array([flux for r in middles for flux in along(0.0, r)])
    none = np.zeros(m, dtype=bool)
    nan = np.full(m, np.nan)
    ends = Ends((at_inlet, np.zeros(m)), (~none, none), (nan, nan))
    system = System(
        line, [1] * m, [False] * m, Driven(Section(problem.bed, problem.rings)), ends
    )
    exact = np.array(
        [
            np.broadcast_to(f, line.points.shape)
            for r in middles
            for f in fields(line.points, r)[0]
        ]
    )
    u, iterations = exact * 1.01, 0
    for _ in range(12):
        residual, slopes = system.assemble(u)
        step = slopes.factors(problem.flux_sizes, problem.sizes).solve(-residual)
        u, iterations = u + step, iterations + 1
        if np.abs(step / exact).max() < 1e-11:
            break
    return problem, u, exact, iterations


def error(shape: str, rings: int, cells: int, degree: int) -> tuple[float, int]:
    """Largest root mean square error of a field over its size, and the iterations of
    Newton's method.
    """
    problem, u, exact, iterations = solution(shape, rings, cells, degree)
    line = problem.line
    square = problem.rings.mean(
        np.einsum("ecj,j,c->e", (u - exact) ** 2, line.weights, line.h)
    )
    return float((square**0.5 / np.array([8.0, 4.0, T_WALL])).max()), iterations
