"""The moving-bed fuel reactor as a boundary value problem of ordinary equations, solved
by shooting.

Its equations are written here once more, apart from the package, with switches for what
an open flowsheet code does otherwise. Unknown where the gas enters are what has reacted
in the whole bed and the temperature of the solids; both follow from what enters at the
top (Newton's method, Radau to 1e-11 in between).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

R = 8.31446261815324  # [J/mol/K]
GASES, SOLIDS = ("CH4", "CO2", "H2O"), ("Fe2O3", "Fe3O4", "Al2O3")
MADE = {"CH4": -1.0, "CO2": 1.0, "H2O": 2.0, "Fe2O3": -12.0, "Fe3O4": 8.0, "Al2O3": 0.0}
# 298.15 K of the Shomate equation [J/mol]
REFERENCE = {"CH4": -74.8731e3, "CO2": -393.5224e3, "H2O": -241.8264e3, "Fe2O3": -825.5032e3, "Fe3O4": -1120.894e3,
             "Al2O3": -1675.69e3}  # fmt: skip
HEAT_OF_REACTION = 136584.3  # of the flowsheet code [J/mol CH4]
TOLERANCE = 1e-11


@dataclass(frozen=True)
class Bed:
    """The inputs of a scene."""

    length: float
    porosity: float
    diameter: float
    gas: Mapping[str, float]  # mole fluxes that enter [mol/m2/s]
    pressure: float
    T_gas: float
    velocity: float  # of the solids, superficial, downwards [m/s]
    fractions: Mapping[str, float]  # of the solids that enter, by mass
    particle_porosity: float
    T_solid: float
    masses: Mapping[str, float]
    densities: Mapping[str, float]
    shomate: Mapping[str, Any]
    viscosity: Mapping[str, Any]
    conductivity: Mapping[str, Any]
    A: float
    E: float
    order: float
    scale: float  # active_share/(molar_density grain_radius)
    # what the flowsheet code does otherwise
    nusselt_cubed: bool = False
    root_in_conductivity: bool = False
    transposed_conductivity: bool = False
    products_without_enthalpy: bool = False
    slip: str = "interstitial"  # "none" and "sum" in Re and Ergun
    linear_pressure: bool = False

    @classmethod
    def of(cls, scene: Any) -> Bed:
        """Read the inputs of a scene of the package."""
        gas, solid, reaction = (
            scene.gas,
            scene.solids["carrier"],
            scene.reactions["reduction"],
        )
        inlet, solids_inlet = (
            scene.boundary["left"].gas,
            scene.boundary["right"].solids["carrier"],
        )
        pairs = dict(
            part.split(":") for part in gas.composition.replace(" ", "").split(",")
        )
        total = sum(map(float, pairs.values()))
        tables = {**gas.species, **solid.constituent}
        fractions = {
            k: float(v)
            for k, v in (
                p.split(":") for p in solid.composition.replace(" ", "").split(",")
            )
        }
        whole = sum(fractions.values())
        return cls(
            scene.mesh.length,
            scene.packed_bed.porosity,
            solid.diameter,
            {
                name: inlet.molar_flux * float(pairs.get(name, 0.0)) / total
                for name in GASES
            },
            gas.pressure,
            inlet.temperature,
            solids_inlet.velocity,
            {name: fractions.get(name, 0.0) / whole for name in SOLIDS},
            solid.porosity,
            solids_inlet.temperature,
            {name: table.molar_mass for name, table in tables.items()},
            {name: table.density for name, table in solid.constituent.items()},
            {name: table.shomate for name, table in tables.items()},
            {name: gas.species[name].viscosity for name in GASES},
            {name: gas.species[name].conductivity for name in GASES},
            reaction.A,
            reaction.E,
            reaction.orders["CH4"],
            reaction.active_share / (reaction.molar_density * reaction.grain_radius),
        )

    def changed(self, **changes: Any) -> Bed:
        """Return the bed with other inputs or switches."""
        return replace(self, **changes)

    def heat_capacity(self, name: str, T: float) -> float:
        """Return the heat capacity [J/mol/K]."""
        A, B, C, D, E = self.shomate[name][:5]
        t = T / 1000.0
        return A + B * t + C * t**2 + D * t**3 + E / t**2

    def enthalpy(self, name: str, T: float, sensible: bool) -> float:
        """Return the enthalpy [J/mol], over that of 298.15 K if `sensible`."""
        A, B, C, D, E, F = self.shomate[name][:6]
        t = T / 1000.0
        h = 1e3 * (A * t + B * t**2 / 2 + C * t**3 / 3 + D * t**4 / 4 - E / t + F)
        return h - REFERENCE[name] if sensible else h

    def solids(self, extent: float) -> dict[str, float]:
        """Return the mole fluxes of the solids [mol/m2/s] after an extent of
        reaction from the top [mol/m2/s].
        """
        density = (1.0 - self.particle_porosity) / sum(
            w / self.densities[k] for k, w in self.fractions.items() if w
        )
        enter = {
            k: self.velocity * density * w / self.masses[k]
            for k, w in self.fractions.items()
        }
        return {k: enter[k] + MADE[k] * extent for k in SOLIDS}

    def transport(self, T: float, x: Mapping[str, float]) -> tuple[float, float]:
        """Return viscosity and conductivity of the gas."""

        def pure(c: Any) -> float:
            return float(c[0] * T ** c[1] / (1.0 + c[2] / T + c[3] / T**2))

        M = self.masses
        mu = {k: pure(self.viscosity[k]) for k in GASES}
        kk = {k: pure(self.conductivity[k]) for k in GASES}
        viscosity = sum(
            x[i] * mu[i] / sum(x[j] * np.sqrt(M[j] / M[i]) for j in GASES)
            for i in GASES
        )
        conductivity = 0.0
        for i in GASES:
            below = 0.0
            for j in GASES:
                a, b = (j, i) if self.transposed_conductivity else (i, j)
                pair = (
                    1.0 + np.sqrt(kk[a] / kk[b]) * (M[a] / M[b]) ** 0.25
                ) ** 2 / np.sqrt(8.0 * (1.0 + M[a] / M[b]))
                below += x[j] * (np.sqrt(pair) if self.root_in_conductivity else pair)
            conductivity += x[i] * kk[i] / below
        return float(viscosity), float(conductivity)

    def slopes(self, _: float, y: Any, whole: float) -> list[float]:
        """Return the derivatives of extent, both temperatures and pressure along the
        gas.
        """
        extent, T_g, T_s, p = y
        g = {k: self.gas[k] + MADE[k] * extent for k in GASES}
        m = self.solids(whole - extent)
        moles = sum(g.values())
        x = {k: g[k] / moles for k in GASES}
        M = sum(x[k] * self.masses[k] for k in GASES)
        rho, c = p * M / (R * T_g), max(x["CH4"], 0.0) * p / (R * T_g)
        u = moles * R * T_g / p
        eps, d = self.porosity, self.diameter
        conversion = m["Fe3O4"] / (m["Fe3O4"] + 8.0 / 12.0 * m["Fe2O3"])
        per_particle = (
            3.0
            * self.scale
            * m["Fe2O3"]
            / self.velocity
            * self.A
            * np.exp(-self.E / (R * T_s))
        )
        r = (
            (1.0 - eps)
            * per_particle
            * c**self.order
            * max(1.0 - conversion, 0.0) ** (2.0 / 3.0)
        )
        mu, k = self.transport(T_g, x)
        cp = sum(x[i] * self.heat_capacity(i, T_g) for i in GASES) / M
        slip = (
            u
            + {
                "none": 0.0,
                "sum": self.velocity,
                "interstitial": eps / (1 - eps) * self.velocity,
            }[self.slip]
        )
        Re = rho * (u if self.slip == "sum" else slip) * d / mu
        Pr = mu * cp / k
        Nu = (
            ((2 + 1.1 * Re**1.8) * Pr) ** (1 / 3)
            if self.nusselt_cubed
            else 2 + 1.1 * Re**0.6 * Pr ** (1 / 3)
        )
        exchange = 6.0 * (1.0 - eps) / d * Nu * k / d * (T_s - T_g)
        sensible = self.products_without_enthalpy
        h_g = {i: self.enthalpy(i, T_g, sensible) for i in GASES}
        h_s = {i: self.enthalpy(i, T_s, sensible) for i in SOLIDS}
        to_gas = to_solid = exchange
        if sensible:
            to_solid = exchange + HEAT_OF_REACTION * r
        else:
            made = r * (
                self.enthalpy("CO2", T_s, False)
                + 2.0 * self.enthalpy("H2O", T_s, False)
                - h_g["CH4"]
            )
            to_gas, to_solid = exchange + made, exchange + made
        gas_capacity = sum(g[i] * self.heat_capacity(i, T_g) for i in GASES)
        solid_capacity = sum(m[i] * self.heat_capacity(i, T_s) for i in SOLIDS)
        dT_g = (to_gas - r * sum(MADE[i] * h_g[i] for i in GASES)) / gas_capacity
        dT_s = (to_solid + r * sum(MADE[i] * h_s[i] for i in SOLIDS)) / solid_capacity
        if self.linear_pressure:
            density = sum(m[i] * self.masses[i] for i in SOLIDS) / self.velocity
            dp = -0.2 * u * (density - rho)
        else:
            viscous = 150.0 * mu * (1.0 - eps) ** 2 / (eps**3 * d**2)
            dp = -(viscous + 1.75 * rho * (1.0 - eps) * abs(slip) / (eps**3 * d)) * slip
        return [r, dT_g, dT_s, dp]

    def solve(self, guess: tuple[float, float] | None = None) -> dict[str, float]:
        """Return conversions, temperatures and pressure of what leaves."""
        most = min(self.gas["CH4"], self.solids(0.0)["Fe2O3"] / 12.0)
        start = np.array(guess or (0.999 * most, self.T_solid - 40.0 * most / 3.767))

        def ends(unknown: Any) -> Any:
            whole, T_s = unknown
            y = solve_ivp(
                lambda x, y: self.slopes(x, y, whole),
                (0.0, self.length),
                [0.0, self.T_gas, T_s, self.pressure],
                method="Radau",
                rtol=TOLERANCE,
                atol=[1e-13, 1e-9, 1e-9, 1e-6],
                first_step=1e-7,
            ).y[:, -1]
            return y

        def missed(unknown: Any) -> Any:
            y = ends(unknown)
            return [(y[0] - unknown[0]) / most, (y[2] - self.T_solid) / self.T_solid]

        found = root(missed, start, method="hybr", options={"xtol": 1e-13, "eps": 1e-7})
        y = ends(found.x)
        m = self.solids(found.x[0])
        return {
            "conversion_CH4": float(found.x[0] / self.gas["CH4"]),
            "conversion_Fe2O3": float(1.0 - m["Fe2O3"] / self.solids(0.0)["Fe2O3"]),
            "pressure_drop_Pa": float(self.pressure - y[3]),
            "T_solid_out_K": float(found.x[1]),
            "T_fluid_out_K": float(y[1]),
            "missed": float(np.abs(found.fun).max()),
        }


AS_CODED = {
    "nusselt_cubed": True,
    "root_in_conductivity": True,
    "transposed_conductivity": True,
    "products_without_enthalpy": True,
    "slip": "none",
    "linear_pressure": True,
}
TEXTBOOK = {
    "products_without_enthalpy": True,
    "slip": "sum",
    "transposed_conductivity": True,
}
