"""Scenes of reacting beds with made-up species, for which closed forms exist, and
their tables.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import quad
from scipy.special import ive

from tests.scene_text import scene_of, set_keys

R_GAS = 8.31446261815324
T, P = 500.0, 1e5  # [K], [Pa]
MOLAR = P / (R_GAS * T)  # [mol/m3]
TABLES = Path(__file__).parent / "tables"


def table(name: str) -> list[dict[str, Any]]:
    """Rows of a table of exact values; numbers where they are numbers."""
    lines = [
        line
        for line in (TABLES / f"{name}.csv").read_text().splitlines()
        if not line.startswith("#")
    ]
    return [
        {key: _number(value) for key, value in row.items()}
        for row in csv.DictReader(lines)
    ]


def _number(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text


def species(**masses: float) -> dict[str, Any]:
    """Species of given molar masses, made of one element that weighs as much as they
    do.
    """
    return {
        name: {"elements": {"H": mass * 1e3}, "molar_mass": mass}
        for name, mass in masses.items()
    }


def isothermal(composition: str, gases: dict[str, Any], **more: Any) -> dict[str, Any]:
    """A bed of 1 m at one temperature and pressure, gas from the left."""
    scene: dict[str, Any] = scene_of(
        """
        [mesh]
        type = "line"
        length = 1.0
        [gas]
        model = "ideal_gas"
        [solids.particles]
        diameter = 3e-3
        [packed_bed]
        porosity = 0.4
        pressure_drop = "none"
        [closures]
        [boundary.left]
        gas.velocity = 0.5
        [initial]
        [output]
        plots = false
        """,
        {
            "gas.composition": composition,
            "gas.pressure": P,
            "gas.species": gases,
            "boundary.left.gas.temperature": T,
        },
    )
    for key, value in more.items():
        scene[key] = {**scene.get(key, {}), **value}
    return scene


def let_move(scene: dict[str, Any], velocity: float, **state: float) -> dict[str, Any]:
    """Let all solid phases move along x, in place: a superficial velocity, and the
    temperature where they enter.
    """
    side = scene["boundary"].setdefault("left" if velocity > 0.0 else "right", {})
    side["solids"] = {
        phase: {"velocity": abs(velocity), **state} for phase in scene["solids"]
    }
    return scene


def danckwerts(Pe: float, Da: float) -> dict[str, Any]:
    """First order with dispersion: Pe = u L/(eps D), Da = eps k L/u."""
    scene = isothermal("A:1", species(A=0.028, B=0.028))
    eps, u = 0.4, 0.5
    scene["closures"] |= {"dispersion_mass": u / (eps * Pe)}
    scene["reactions"] = {"r": {"equation": "A -> B", "A": Da * u / eps, "E": 0.0}}
    return scene


def expansion(e: float, Da: float) -> dict[str, Any]:
    """First order with change of moles, A -> (1 + e) B from pure A."""
    nu = 1.0 + e
    scene = isothermal("A:1", species(A=0.028, B=0.028 / nu))
    scene["reactions"] = {
        "r": {"equation": f"A -> {nu} B", "A": Da * 0.5 / 0.4, "E": 0.0}
    }
    return scene


def ergun(row: dict[str, float]) -> dict[str, Any]:
    """Isothermal gas through a bed by Ergun's equation."""
    scene = isothermal("A:1", species(A=row["M_kg_mol"]))
    scene["mesh"]["length"] = row["L_m"]
    scene["gas"] |= {"pressure": row["p_in_Pa"], "viscosity": row["mu_Pa_s"]}
    scene["packed_bed"]["porosity"] = row["eps"]
    scene["solids"]["particles"]["diameter"] = row["d_m"]
    scene["boundary"]["left"]["gas"] = {
        "mass_flux": row["G_kg_m2_s"],
        "temperature": row["T_K"],
    }
    set_keys(scene, 'packed_bed.pressure_drop = "ergun"')
    return scene


def solids() -> dict[str, Any]:
    """Particles of S that become P of the same mass."""
    return {
        "composition": "S:1",
        "density": 3000.0,
        "constituent": {
            name: {"elements": {"Fe": 1.0}, "molar_mass": 0.1} for name in ("S", "P")
        },
    }


N_SOLID = 0.6 * 3000.0 / 0.1  # moles of S per volume of bed where particles enter


def bilinear(N: float, r: float) -> dict[str, Any]:
    """Counter-current bed with rate k c n; r solid over gas, N = k F L/(u v)."""
    u, eps = 0.5, 0.4
    F = u * MOLAR
    v = r * F / N_SOLID
    scene = let_move(isothermal("A:1", species(A=0.028, B=0.028)), -v * (1.0 - eps))
    scene["solids"]["particles"] |= solids()
    k = N * u * v / F
    scene["reactions"] = {"r": takes_solid("A + S -> B + P", k)}
    return scene


def takes_solid(equation: str, A: float) -> dict[str, Any]:
    """A reaction of first order in a gas and in a solid."""
    gas, _, solid, *_ = equation.split()
    orders = {gas: 1.0, solid: 1.0}
    return {"equation": equation, "A": A, "E": 0.0, "orders": orders, "basis": "bed"}


def shrinking_core(N: float, n: float, f: float, d: float, r: float) -> dict[str, Any]:
    """Counter-current bed of shrinking cores; see the header of its table."""
    u, eps, tau, R = 0.5, 0.4, 1000.0, 1.5e-3
    v = n * u * MOLAR / N_SOLID
    scene = let_move(isothermal("A:1", species(A=0.028, B=0.028)), -v * (1.0 - eps))
    scene["mesh"]["length"] = N * tau * v / n
    scene["solids"]["particles"] |= solids()
    demand = R * (N_SOLID / (1.0 - eps)) / MOLAR / tau
    scene["reactions"] = {
        "r": {
            "equation": "A + S -> B + P",
            "law": "shrinking_core",
            "A": demand / r if r else 1e12,
            "E": 0.0,
            "diffusivity": demand * R / (6.0 * d) if d else 1e12,
        }
    }
    if f:
        D = 1e-5
        scene["gas"]["diffusivity"] = D
        scene["closures"] |= {"sherwood": demand / (3.0 * f) * 2.0 * R / D}
    return scene


def equilibrium(
    composition: str, pressure: float, temperature: float, equations: dict[str, str]
) -> dict[str, Any]:
    """A bed in which reversible reactions are fast."""
    scene = isothermal(composition, {})
    scene["gas"] = {
        "model": "cantera",
        "composition": composition,
        "pressure": pressure,
    }
    scene["boundary"]["left"]["gas"]["temperature"] = temperature
    molar = pressure / (R_GAS * temperature)
    scene["reactions"] = {
        name: {"equation": text, "A": 1e3 / molar ** (orders - 1), "E": 0.0}
        for (name, text), orders in zip(equations.items(), (2, 2), strict=False)
    }
    return scene


def ignition(Pe_m: float, Pe_h: float, B: float, g: float, Da: float) -> dict[str, Any]:
    """Adiabatic bed of first order in the mole fraction; `reactions.r.factor` is
    Da = k(T_in) L/u.
    """
    cp, T_in, d, G, eps = 30.0, 600.0, 3e-3, 0.5, 0.4
    mass = 0.028
    fall = cp * B * T_in / g
    gases = species(A=mass, B=mass)
    gases["A"] |= {"heat_capacity": cp, "enthalpy": fall}
    gases["B"] |= {"heat_capacity": cp, "enthalpy": 0.0}
    scene = isothermal("A:1", gases)
    scene["boundary"]["left"]["gas"] = {"mass_flux": G, "temperature": T_in}
    set_keys(scene, 'packed_bed.pressure_drop = "none"')
    set_keys(scene, "heat = {}")
    scene["closures"] |= {
        "conductivity_solids": G * cp / mass / Pe_h,
        "dispersion_mass": {"name": "mass_dispersion_peclet", "Pe_p": Pe_m * d},
    }
    scene["reactions"] = {
        "r": {
            "equation": "A -> B",
            "rate": "k*x_A*exp(g*(1 - T_in/T))",
            "parameters": {"k": G / mass / eps, "g": g, "T_in": T_in},
            "factor": Da,
        }
    }
    return scene


def fixed_bed(
    law: str, f: float, d: float, r: float, xi: float, tau: float
) -> dict[str, Any]:
    """Bed at rest whose particles react with the gas; xi and tau as in the header of
    its table.
    """
    u, full = 0.5, 1000.0
    scene = isothermal("A:1", species(A=0.028, B=0.028))
    scene["solids"]["particles"] |= solids()
    scene["mesh"]["length"] = xi * u * MOLAR * full / N_SOLID
    scene["time"] = {"end": tau * full}
    scene["output"] |= {"positions": [scene["mesh"]["length"]]}
    if law == "bohart_adams":
        k = 1.0 / (MOLAR * full)
        scene["reactions"] = {"r": takes_solid("A + S -> B + P", k)}
        return scene
    cores = shrinking_core(1.0, 1.0, f, d, r)
    scene["reactions"] = cores["reactions"]
    scene["gas"] = cores["gas"]
    scene["closures"] = cores["closures"]
    return scene


def schumann(xi: float, eta: float) -> float:
    """Gas temperature after a step of the inlet, theta = 1 - e^-xi int_0^xi ...
    (Schumann 1929).
    """
    if eta <= 0.0:
        return float(np.exp(-xi))
    inner = quad(
        lambda z: (
            np.exp(-((np.sqrt(z) - np.sqrt(eta)) ** 2)) * ive(0, 2.0 * np.sqrt(z * eta))
        ),
        0.0,
        xi,
    )[0]
    return float(1.0 - inner)


def heated(xi: float) -> tuple[dict[str, Any], float]:
    """A bed of xi transfer units at 300 K in a gas of 600 K, and eta = h a t/C_solid
    per second.
    """
    cp, rho_s, c_s, G, L, d = 30.0, 2000.0, 800.0, 0.5, 0.2, 3e-3
    gases = species(A=0.028)
    gases["A"] |= {"heat_capacity": cp, "enthalpy": 0.0}
    scene = isothermal("A:1", gases)
    scene["gas"] |= {"conductivity": 0.03, "viscosity": 2e-5}
    scene["mesh"]["length"] = L
    scene["boundary"]["left"]["gas"] = {"mass_flux": G, "temperature": 600.0}
    set_keys(scene, 'packed_bed.pressure_drop = "none"')
    scene["solids"]["particles"] |= {"density": rho_s, "heat_capacity": c_s}
    ha = xi * G * cp / 0.028 / L
    scene["heat"] = {}
    scene["closures"] |= {"nusselt": ha / (6.0 * 0.6 / d) * d / 0.03}
    set_keys(scene, "time = {}")
    set_keys(scene, "initial.temperature = 300.0")
    return scene, ha / (0.6 * rho_s * c_s)


def switched(values: list[Any], half: float) -> dict[str, Any]:
    """A series that takes each value for half of a cycle."""
    return {"times": [0.0, half], "values": values, "form": "step"}


def looping() -> dict[str, Any]:
    """Particles at rest that a fuel takes oxygen from and air gives it back to."""
    scene = isothermal("A:1", species(A=0.028, B=0.028, O=0.032, I=0.032))
    scene["solids"]["particles"] |= solids()
    k = 1e-3 / MOLAR
    scene["reactions"] = {
        "reduction": takes_solid("A + S -> B + P", k),
        "oxidation": takes_solid("O + P -> I + S", 2.0 * k),
    }
    scene["boundary"]["left"]["gas"]["composition"] = switched(["A:1", "O:1"], 600.0)
    set_keys(
        scene,
        """
        time = { end = 1200.0, times = [600.0], tolerance = 1e-3, cycle = {} }
        packed_bed.gas_storage = "quasi_steady"
        mesh.length = 0.3
        mesh.cells = 4
        """,
    )
    return scene
