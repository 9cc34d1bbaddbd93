"""Beds at rest whose particles are used up, or heated, by the gas: exact profiles, and totals that close."""

from __future__ import annotations

import numpy as np
import pytest
from reacting_bed_scenes import fixed_bed, isothermal, species, table
from scipy.integrate import quad
from scipy.special import ive

import contbed
from contbed.loading import from_dict

ROWS = [row for row in table("fixed_bed_gas_solid") if row["d"] < 1.0]
# steps to a local tolerance of 1e-4, of one order more than their estimate; the largest error of all rows is 1.02e-5
STEPS = 2e-5
CLOSED = 1e-12


def compared(row):
    scene = fixed_bed(*(row[key] for key in ("law", "f", "d", "r", "xi", "tau")))
    result = contbed.run(from_dict(scene))
    assert result.profiles["x_A [1]"][-1] == pytest.approx(row["y"], abs=STEPS)
    assert result.profiles["w_P [1]"][-1] == pytest.approx(row["X"], abs=STEPS)
    for name, balance in result.balances.items():
        assert abs(balance["relative_residual"]) < CLOSED, name
    return result


def test_breakthrough_through_a_bed_that_is_used_up():
    row = next(row for row in ROWS if row["law"] == "bohart_adams" and (row["xi"], row["tau"]) == (2.0, 0.8))
    result = compared(row)
    assert result.tables["outlet"]["t [s]"][-1] == pytest.approx(800.0)
    assert np.all(np.diff(result.tables["outlet"]["x_A [1]"]) > 0.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    "row", ROWS, ids=lambda r: f"{r['law']}-{r['f']:g}-{r['d']:g}-{r['r']:g}-{r['xi']:g}-{r['tau']:g}"
)
def test_gas_and_conversion_in_beds_at_rest(row):
    compared(row)


def schumann(xi, eta):
    """Gas temperature after a step of the inlet, theta = 1 - e^-xi int_0^xi ... (Schumann 1929)."""
    inner = quad(lambda z: np.exp(-((np.sqrt(z) - np.sqrt(eta)) ** 2)) * ive(0, 2.0 * np.sqrt(z * eta)), 0.0, xi)[0]
    return 1.0 - inner


def test_heating_of_a_bed_by_a_gas():
    cp, rho_s, c_s, G, L = 30.0, 2000.0, 800.0, 0.5, 0.2
    gases = species(A=0.028)
    gases["A"] |= {"heat_capacity": cp, "enthalpy": 0.0}
    scene = isothermal("A:1", gases)
    scene["fluid"] |= {"conductivity": 0.03, "viscosity": 2e-5}
    scene["mesh"]["length"] = L
    scene["flow"] = {"mass_flux": G, "pressure_drop": "none"}
    scene["boundary"] = {"left": {"fluid": {"inflow": 600.0}}}
    scene["solid"] = {"density": rho_s, "heat_capacity": c_s}
    capacity = G * cp / 0.028  # of the gas [W/m2/K]
    xi = 4.0
    ha = xi * capacity / L
    a, d = 6.0 * 0.6 / 3e-3, 3e-3
    scene["heat"] = {"nusselt": ha / a * d / 0.03}
    end = 5.0 * 0.6 * rho_s * c_s / ha  # eta = 5
    scene["time"] = {"end": end, "initial_temperature": 300.0}
    result = contbed.run(from_dict(scene))
    theta = (result.qoi["T_fluid_out_K"] - 300.0) / 300.0
    assert theta == pytest.approx(schumann(4.0, 5.0), abs=1e-4)
    assert abs(result.balances["energy"]["relative_residual"]) < CLOSED
