"""Pressure, velocity and density along a packed bed: Ergun's drop, mass that is conserved, properties along the bed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

import contbed as cb
from contbed.closures import pressure_gradient_ergun
from contbed.fem.dual import Components
from contbed.fem.elements import Space
from contbed.loading import from_dict
from contbed.packed_bed.equations.porous_flow import Coefficients
from contbed.packed_bed.flow import LocalProperties, solve_flow
from contbed.solvers.linear import Policy

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


def test_pressure_between_walls_follows_the_temperature():
    """A wide heated channel with no-slip walls has the drop of plug flow but for its wall layers, some 2 %; with the
    properties of the inlet it would be less than half. Mass is conserved to the tolerance of the flow.
    """
    mesh = {"type": "rectangle", "length": 1.0, "height": 0.2, "cells": [30, 12], "graded": True}
    values = bed(STEAM, mesh=mesh)
    values["boundary"]["right"] = {"solid": {"fixed": 967.0}}
    values["solid"]["conductivity"] = 400.0  # the whole bed is hot
    plug = cb.run(from_dict(values))
    values["boundary"] |= {"top": {"type": "no_slip"}, "bottom": {"type": "no_slip"}}
    walls = cb.run(from_dict(values))
    assert walls.qoi["pressure_drop_Pa"] == pytest.approx(plug.qoi["pressure_drop_Pa"], rel=0.03)
    at_inlet = pressure_gradient_ergun(
        u=U, d_p=D, eps=EPS, mu=float(walls.plan.medium.fluid.viscosity(433.0)), rho=walls.plan.medium.mass_flux_scale()
    )
    assert walls.qoi["pressure_drop_Pa"] > 1.5 * at_inlet
    assert abs(walls.balances["fluid volume"]["relative_residual"]) < 1e-10
    assert not any("density of the fluid" in text for text in walls.warnings)


def channel(cells, conditions, c, inlet, local=None):
    """Flow through a channel of 1 m by 0.3 m with fields of local properties (expansion, viscosity) of x."""
    scene = bed(CONSTANT, mesh={"type": "rectangle", "length": 1.0, "height": 0.3, "cells": cells})
    scene["boundary"] |= {"top": {"type": "no_slip"}}
    mesh = cb.plan(from_dict(scene)).mesh
    space = Space(mesh.skfem, 2)
    x = space.points[0]
    fields = None if local is None else LocalProperties(space, *(f(x) * np.ones_like(x) for f in local))
    roles = {"left": "inlet", "right": "outlet"} | conditions
    return solve_flow(mesh, c, inlet, roles, Policy(2), tolerance=1e-12, iterations=30, local=fields)


def constants(density, viscosity):
    return Coefficients(density, viscosity, 0.4, 1e-6, 0.2, Components((0.0, 0.0)), 1.0)


def test_uniform_local_properties_are_those_of_another_fluid():
    """Half the density and twice the velocity: the same mass flux, so the flow of that fluid to rounding, 1e-9."""
    walls = {"top": "no_slip", "bottom": "slip"}
    local = channel([12, 8], walls, constants(2.0, 1.0), (0.3, 0.0), (lambda x: 2.0, lambda x: 3e-3))
    other = channel([12, 8], walls, constants(1.0, 3e-3), (0.6, 0.0))
    np.testing.assert_allclose(local.expanded, other.velocity, atol=1e-9)
    np.testing.assert_allclose(local.pressure, other.pressure, rtol=1e-9, atol=1e-9 * np.abs(other.pressure).max())


def test_a_fluid_that_expands_along_a_channel_without_walls():
    """u = U s(x) between slip walls; p is the integral of -G u'/eps^2 + (mu u')'/eps - drag: order 2 or more,
    as the pressure is linear in a cell.
    """
    U, rho, c = 0.3, 2.0, constants(2.0, 1.0)
    s, slope, bend = lambda x: 1.0 + x + 0.5 * x**2, lambda x: 1.0 + x, 1.0
    mu, mu_slope = lambda x: 0.05 * (1.0 + x), 0.05

    def gradient(x):
        u = U * s(x)
        drag = mu(x) / 1e-6 + rho / s(x) * 0.2 / 1e-3 * u
        stress = mu(x) * U * bend + mu_slope * U * slope(x)
        return -rho * U * U * slope(x) / 0.4**2 + stress / 0.4 - drag * u

    wanted = -quad(gradient, 0.0, 1.0)[0]
    errors = []
    for cells in (8, 16, 32):
        flow = channel([cells, 2], {"top": "slip", "bottom": "slip"}, c, (U, 0.0), (s, mu))
        x = flow.system.fields["p"][0].points[0]
        drop = flow.pressure[x == 0.0].mean() - flow.pressure[x == 1.0].mean()
        errors.append(abs(drop / wanted - 1.0))
    assert errors[1] < errors[0] / 3.5 and errors[2] < errors[1] / 3.5 and errors[2] < 1e-3


def test_a_transient_between_walls_warns_of_a_density_that_changes():
    mesh = {"type": "rectangle", "length": 1.0, "height": 0.2, "cells": [4, 2]}
    values = bed(STEAM, mesh=mesh, time={"end": 0.1, "initial_fluid": 900.0, "initial_solid": 900.0})
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
