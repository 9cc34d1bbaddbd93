"""Pressure, velocity and density along a packed bed: Ergun's drop, mass that is conserved, properties along the bed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

import contbed as cb
from contbed.closures import pressure_gradient_ergun
from contbed.loading import from_dict

U, EPS, D = 0.5, 0.4, 5e-3
CONSTANT = {"density": 1.2, "heat_capacity": 1000.0, "conductivity": 0.03, "viscosity": 1.8e-5}
STEAM = {"model": "cantera", "composition": "H2O:1", "mechanism": "gri30.yaml"}


def bed(fluid, velocity=U, **more):
    """A bed of 1 m with a hot end, that a fluid crosses."""
    inlet, outlet = ("left", "right") if velocity > 0 else ("right", "left")
    return {
        "mesh": {"type": "line", "length": 1.0},
        "fluid": dict(fluid),
        "solid": {"density": 2000.0, "heat_capacity": 900.0, "conductivity": 1.0},
        "bed": {"porosity": EPS, "particle_diameter": D},
        "flow": {"velocity": velocity},
        "heat": {"nusselt": "wakao_kaguei"},
        "boundary": {inlet: {"fluid": {"inflow": 433.0}}, outlet: {"solid": {"fixed": 967.0}}},
        **more,
    }


@pytest.mark.parametrize("velocity", [U, -U])
def test_constant_properties_give_ergun(velocity):
    """The profile is a line, so the trapezoidal rule is exact: 1e-12."""
    result = cb.run(from_dict(bed(CONSTANT, velocity)))
    wanted = pressure_gradient_ergun(u=U, d_p=D, eps=EPS, mu=1.8e-5, rho=1.2)
    assert result.qoi["pressure_drop_Pa"] == pytest.approx(wanted, rel=1e-12)
    assert result.qoi["residence_time_s"] == pytest.approx(EPS / U, rel=1e-12)
    p = result.profiles["p [Pa]"]
    assert p[-1 if velocity > 0 else 0] == 0.0 and p.min() >= 0.0


def test_a_resting_fluid_in_a_moving_bed_has_no_pressure_of_its_own_drag():
    """The bed moves as fast as the fluid: no relative velocity, no resistance."""
    values = bed(CONSTANT, flow={"velocity": U, "velocity_solid": U})
    values["boundary"] = {"left": {"fluid": {"inflow": 433.0}, "solid": {"inflow": 967.0}}}
    assert cb.run(from_dict(values)).qoi["pressure_drop_Pa"] == pytest.approx(0.0, abs=1e-12)


def test_steam_that_is_heated_speeds_up():
    """Mass flux to rounding; the pressure drop against adaptive quadrature of the formula at the local temperature:
    1e-4 by the trapezoidal rule on the points of the profile, and well above that of inlet properties.
    """
    hot = {"left": {"fluid": {"inflow": 433.0}}, "right": {"solid": {"inflow": 967.0}}}
    result = cb.run(from_dict(bed(STEAM, flow={"velocity": U, "velocity_solid": -1e-3}) | {"boundary": hot}))
    x, T = result.profiles["x [m]"], result.profiles["T_fluid [K]"]
    fluid = result.plan.medium.fluid
    flux = U * float(fluid.density(433.0))
    rho_u = result.profiles["u [m/s]"] * result.profiles["rho_fluid [kg/m3]"]
    np.testing.assert_allclose(rho_u, flux, rtol=1e-13)
    np.testing.assert_allclose(result.profiles["rho_fluid [kg/m3]"], fluid.density(T), rtol=1e-13)

    def gradient(place):
        at = float(np.interp(place, x, T))
        rho, mu = float(fluid.density(at)), float(fluid.viscosity(at))
        return pressure_gradient_ergun(u=flux / rho + 1e-3, d_p=D, eps=EPS, mu=mu, rho=rho)

    drag, _ = quad(gradient, 0.0, 1.0, points=list(np.linspace(0.02, 0.98, 49)), limit=400)
    expansion = flux**2 / EPS**2 * (1.0 / float(fluid.density(T[-1])) - 1.0 / float(fluid.density(T[0])))
    assert result.qoi["pressure_drop_Pa"] == pytest.approx(drag + expansion, rel=1e-4)
    at_inlet = pressure_gradient_ergun(
        u=U, d_p=D, eps=EPS, mu=float(fluid.viscosity(433.0)), rho=float(fluid.density(433.0))
    )
    assert result.qoi["pressure_drop_Pa"] > 1.5 * at_inlet


def test_few_positions_do_not_change_the_drop():
    whole = cb.run(from_dict(bed(STEAM))).qoi["pressure_drop_Pa"]
    few = cb.run(from_dict(bed(STEAM, output={"positions": [0.2, 0.7]})))
    assert few.qoi["pressure_drop_Pa"] == pytest.approx(whole, rel=1e-12)
    assert len(few.profiles["p [Pa]"]) == 2


def test_walls_report_the_pressure_of_the_fluid():
    """A wide channel with no-slip walls has the gradient of plug flow but for its wall layers, some 2 %."""
    mesh = {"type": "rectangle", "length": 1.0, "height": 0.2, "cells": [10, 20], "graded": True}
    sides = {"top": {"type": "no_slip"}, "bottom": {"type": "no_slip"}}
    values = bed(CONSTANT, mesh=mesh)
    values["boundary"] |= sides
    result = cb.run(from_dict(values))
    wanted = pressure_gradient_ergun(u=U, d_p=D, eps=EPS, mu=1.8e-5, rho=1.2)
    assert result.qoi["pressure_drop_Pa"] == pytest.approx(wanted, rel=0.03)


def test_flow_between_walls_warns_of_a_density_that_changes():
    mesh = {"type": "rectangle", "length": 1.0, "height": 0.2, "cells": [8, 4]}
    values = bed(STEAM, mesh=mesh)
    values["boundary"] |= {"top": {"type": "no_slip"}}
    result = cb.run(from_dict(values))
    assert any("density of the fluid changes by a factor" in text for text in result.warnings)


def test_duty_and_effectiveness():
    """Counter-current streams of equal heat capacity flows: effectiveness NTU/(1 + NTU), exact without conduction; the
    bed conducts a little, 1e-3. On a line heat flows are per area.
    """
    capacity = 1.2 * 1000.0 * U
    slow = -capacity / (2000.0 * 900.0)
    values = bed(CONSTANT, flow={"velocity": U, "velocity_solid": slow})
    values["fluid"]["conductivity"] = 1e-6
    values["solid"]["conductivity"] = 1e-6
    values["heat"] = {"nusselt": 2.0e4 * 0.02}
    values["boundary"] = {"left": {"fluid": {"inflow": 400.0}}, "right": {"solid": {"inflow": 500.0}}}
    result = cb.run(from_dict(values))
    exchange = 400.0 * 1e-6 * 6.0 * (1.0 - EPS) / D**2
    ntu = exchange * 1.0 / capacity
    wanted = ntu / (1.0 + ntu)
    assert result.qoi["effectiveness"] == pytest.approx(wanted, rel=1e-3)
    assert result.qoi["duty_W"] == pytest.approx(wanted * capacity * 100.0, rel=1e-3)
    assert result.summary["units"]["duty_W"] == "W/m2" and result.qoi["heat_reference_K"] == 400.0
    plane = cb.run(from_dict(values | {"mesh": {"type": "rectangle", "length": 1.0, "height": 0.2}}))
    assert plane.summary["units"]["heat_left_W"] == "W/m"
    assert plane.qoi["duty_W"] == pytest.approx(0.2 * result.qoi["duty_W"], rel=1e-9)


def test_effectiveness_counts_from_the_stream_that_enters():
    """Below one where both streams enter with a known temperature; not reported where an end also conducts."""
    values = bed(CONSTANT, flow={"velocity": U, "velocity_solid": -1.0e-3})
    values["solid"]["conductivity"] = 300.0
    values["heat"] = {"nusselt": 200.0}
    values["boundary"] = {"left": {"fluid": {"inflow": 400.0}}, "right": {"solid": {"inflow": 500.0}}}
    result = cb.run(from_dict(values))
    largest = 1.2 * 1000.0 * U * 100.0
    assert result.qoi["effectiveness"] == pytest.approx(result.qoi["duty_W"] / largest, rel=1e-9)
    assert result.qoi["effectiveness"] < 1.0
    values["boundary"]["right"] = {"solid": {"fixed": 500.0}}
    assert "effectiveness" not in cb.run(from_dict(values)).qoi  # the end conducts as well
