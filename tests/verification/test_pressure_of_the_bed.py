"""Pressure, velocity and density along a packed bed: Ergun's drop, mass that is
conserved, properties along the bed.
"""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from moving_beds import moving
from numpy.testing import assert_allclose
from pytest import approx
from scipy.integrate import quad, solve_ivp, trapezoid
from scipy.optimize import brentq

import contbed as cb
from contbed.closures import pressure_gradient_ergun
from contbed.fem.ad.dual import Components
from contbed.fem.elements import Space
from contbed.loading import from_dict, loads
from contbed.models import MODELS
from contbed.packed_bed.equations.porous_flow import Coefficients
from contbed.packed_bed.flow import Flow, LocalProperties, flow_equations
from contbed.packed_bed.plan import plan
from contbed.packed_bed.pressure import lifted
from contbed.solvers.linear import Policy
from contbed.solvers.newton import Options, newton
from tests.balances import assert_closed
from tests.refusals import refused
from tests.scene_text import scene_of, set_keys
from tests.unit.test_mesh_file import LINE, TRIANGLE, write

MESHES = Path(__file__).parents[2] / "meshes"
U, EPS, D = 0.5, 0.4, 5e-3
CONSTANT = {
    "density": 1.2,
    "heat_capacity": 1000.0,
    "conductivity": 0.03,
    "viscosity": 1.8e-5,
}
STEAM = {"model": "cantera", "composition": "H2O:1", "mechanism": "gri30.yaml"}


def bed(fluid, velocity=U, **more):
    """A bed of 1 m with a hot end, that a fluid crosses."""
    inlet, outlet = ("left", "right") if velocity > 0 else ("right", "left")
    return (
        scene_of(
            """
                mesh = { type = "line", length = 1.0 }
                closures = { nusselt = "wakao_kaguei" }
                heat = {}

                [solids.particles]
                density = 2000.0
                heat_capacity = 900.0
                conductivity = 1.0
            """,
            {
                "gas": dict(fluid),
                "solids.particles.diameter": D,
                "packed_bed.porosity": EPS,
                "boundary": {
                    inlet: {"gas": {"velocity": abs(velocity), "temperature": 433.0}},
                    outlet: {"solids": {"particles": {"fixed_temperature": 967.0}}},
                },
            },
        )
        | more
    )


@pytest.mark.parametrize("velocity", [U, -U])
def test_constant_properties_give_ergun(velocity):
    """The profile is a line, so the trapezoidal rule is exact: 1e-12."""
    result = cb.run(from_dict(bed(CONSTANT, velocity)))
    wanted = pressure_gradient_ergun(u=U, d_p=D, eps=EPS, mu=1.8e-5, rho=1.2)
    assert result.qoi["pressure_drop_Pa"] == approx(wanted, rel=1e-12)
    assert result.qoi["residence_time_s"] == approx(EPS / U, rel=1e-12)
    p = result.profiles["p [Pa]"]
    assert p[-1 if velocity > 0 else 0] == 0.0 and p.min() >= 0.0


def cold(gas, **inlet):
    """A bed of 1 m without [heat], which a gas passes."""
    return bed(gas, heat=None, closures={}, boundary={"left": {"gas": inlet}})


@pytest.mark.parametrize(
    ("permeability", "constant", "diameter"),
    [("ergun", 150, 1.5 * D), ("carman_kozeny", 180, 1.5 * D), ("kuwahara", 144, D)],
)
@pytest.mark.parametrize("species", [False, True])
def test_rods_resist_by_six_volumes_over_their_surface(
    permeability, constant, diameter, species
):
    """That of a long rod is 1.5 d; arrays of rods have their own law on d: 1e-12, and
    1 % in a bed with species, whose gas expands by as much.
    """
    values = cold(CONSTANT, velocity=U)
    if species:
        values["model"] = "packed_bed"
        values["gas"] = {"model": "ideal_gas", "composition": "N2:1", "pressure": 1e5}
        values["gas"] |= {"viscosity": 1.8e-5, "species": {"N2": {}}}
        values["packed_bed"]["pressure_drop"] = "ergun"
        values["boundary"]["left"]["gas"]["temperature"] = 300.0
    values["closures"] = {"permeability": permeability}
    values["solids"]["particles"]["shape"] = "rods"
    result = cb.run(from_dict(values))
    density = 1.2
    if species:
        density = result.qoi["mass_flux_out_kg_m2s"] / U
    inertia = 1.75 * (1 - EPS) / EPS**3 * density * U**2
    K = diameter**2 * EPS**3 / (constant * (1 - EPS) ** 2)
    c_F = 1.75 / (150 * EPS**3) ** 0.5
    wanted = 1.8e-5 * U / K + c_F * density * U**2 / K**0.5
    if permeability == "ergun":
        viscous = 150 * 1.8e-5 * (1 - EPS) ** 2 / EPS**3 * U / diameter**2
        assert wanted == approx(viscous + inertia / diameter, rel=1e-12)
    found = result.qoi["pressure_drop_Pa"]
    assert found == approx(wanted, rel=0.01 if species else 1e-12)


@pytest.mark.parametrize(
    ("gas", "temperature", "viscosity", "density"),
    [
        # IAPWS: water at 15 degC and 3 bar
        (
            {"model": "coolprop", "name": "Water", "pressure": 3e5},
            288.15,
            1.1374e-3,
            999.19,
        ),
        # Lemmon and Jacobsen: air at 600 degC; 1 % as gri30 mixes by Wilke's law
        (
            {"model": "cantera", "composition": "N2:0.79, O2:0.21"},
            873.15,
            3.89e-5,
            0.4026,
        ),
    ],
)
def test_without_heat_properties_are_those_at_the_inlet(
    gas, temperature, viscosity, density
):
    if gas["model"] == "coolprop":
        gas = {**gas, "T_range": [283.15, 293.15]}
    found = cb.run(from_dict(cold(gas, velocity=U, temperature=temperature)))
    wanted = pressure_gradient_ergun(u=U, d_p=D, eps=EPS, mu=viscosity, rho=density)
    assert found.qoi["pressure_drop_Pa"] == approx(wanted, rel=0.01)
    refused(
        r"boundary\.left\.gas\.temperature: is missing: without \[heat\]",
        from_dict,
        cold(gas, velocity=U),
    )


@pytest.mark.parametrize(
    ("mesh", "axis"),
    [
        ({"type": "rectangle", "length": 0.2, "height": 1.0, "cells": [1, 40]}, "y"),
        (
            {"type": "box", "length": 0.1, "width": 0.1, "height": 1.0}
            | {"cells": [1, 1, 40]},
            "z",
        ),
    ],
)
def test_profiles_lie_along_the_flow(mesh, axis):
    """A bed that is crossed from below has the profiles of a line on the same cells,
    to rounding, and Ergun's pressure drop.
    """
    line = bed(CONSTANT)
    line["mesh"]["cells"] = 40
    upright = bed(CONSTANT, mesh=mesh)
    inlet, outlet = line["boundary"]["left"], line["boundary"]["right"]
    upright["boundary"] = {"bottom": inlet, "top": outlet}
    for values in (line, upright):
        values["output"] = {"positions": [0.0, 0.3, 0.95, 0.98, 1.0]}
    wanted, found = (cb.run(from_dict(values)) for values in (line, upright))
    for key in ("pressure_drop_Pa", "T_fluid_out_K", "residence_time_s"):
        assert found.qoi[key] == approx(wanted.qoi[key], rel=1e-9)
    assert found.profiles[f"{axis} [m]"].tolist() == wanted.profiles["x [m]"].tolist()
    for name in ("T_fluid [K]", "T_solid [K]", "p [Pa]"):
        assert_allclose(
            found.profiles[name], wanted.profiles[name], rtol=1e-6, atol=1e-9
        )


@pytest.mark.parametrize("solid", [0.0, [0.0, -0.1]])
def test_the_speed_across_the_bed_counts(solid):
    """A stream that crosses the bed at an angle has the drag of its whole speed:
    Ergun along that, to 1e-12.
    """
    values = bed(
        CONSTANT,
        mesh={"type": "rectangle", "length": 1.0, "height": 0.2, "cells": [8, 4]},
    )
    inlets: dict[str, Any] = {
        side: {"gas": {"temperature": 433.0}} for side in ("left", "bottom")
    }
    inlets["top"] = {"solids": {"particles": {"temperature": 433.0}}} if solid else {}
    values["boundary"] = moving(values["mesh"], inlets, [0.1, 0.4], solid)
    slip = np.array([0.1, 0.4 if not solid else 0.4 + EPS * 0.1 / (1 - EPS)])
    speed = np.hypot(*slip)
    wanted = (
        pressure_gradient_ergun(u=speed, d_p=D, eps=EPS, mu=1.8e-5, rho=1.2)
        * slip[0]
        / speed
    )
    result = cb.run(from_dict(values))
    assert result.qoi["pressure_drop_Pa"] == approx(wanted, rel=1e-12)
    # what the pores hold over what enters through both sides: 0.2 m of 0.1 m/s and 1 m
    # of 0.4 m/s
    assert result.qoi["residence_time_s"] == approx(
        EPS * 0.2 / (0.2 * 0.1 + 1.0 * 0.4), rel=1e-12
    )


def test_a_hot_wall_of_a_mesh_file_is_no_inlet():
    """The gas enters where its velocity is given, and has the density of that
    temperature, also where a wall of another temperature comes first.
    """
    scene = bed(STEAM, mesh={"type": "file", "file": str(MESHES / "square_quad.msh")})
    scene["boundary"] = {
        "top": {"gas": {"fixed_temperature": 967.0}},
        "left": {"gas": {"velocity": [U, 0.0], "temperature": 433.0}},
    }
    assert plan(from_dict(scene)).medium.T_fluid_in == 433.0


def test_steam_that_is_heated_speeds_up():
    """Mass flux to rounding; the pressure drop against adaptive quadrature of the
    formula at the local temperature: 1e-4 by the trapezoidal rule on the points of the
    profile, and well above that of inlet properties.
    """
    hot = {
        "left": {"gas": {"velocity": U, "temperature": 433.0}},
        "right": {"solids": {"particles": {"velocity": 1e-3, "temperature": 967.0}}},
    }
    result = cb.run(from_dict(bed(STEAM) | {"boundary": hot}))
    x, T = result.profiles["x [m]"], result.profiles["T_fluid [K]"]
    fluid = result.plan.medium.fluid
    flux = U * float(fluid.density(433.0))
    rho_u = result.profiles["u [m/s]"] * result.profiles["rho_fluid [kg/m3]"]
    assert_allclose(rho_u, flux, rtol=1e-13)
    assert_allclose(result.profiles["rho_fluid [kg/m3]"], fluid.density(T), rtol=1e-13)

    def gradient(place):
        at = float(np.interp(place, x, T))
        rho, mu = float(fluid.density(at)), float(fluid.viscosity(at))
        return pressure_gradient_ergun(
            u=flux / rho + EPS * 1e-3 / (1 - EPS), d_p=D, eps=EPS, mu=mu, rho=rho
        )

    drag, _ = quad(
        gradient, 0.0, 1.0, points=list(np.linspace(0.02, 0.98, 49)), limit=400
    )
    expansion = (
        flux**2
        / EPS**2
        * (1.0 / float(fluid.density(T[-1])) - 1.0 / float(fluid.density(T[0])))
    )
    assert result.qoi["pressure_drop_Pa"] == approx(drag + expansion, rel=1e-4)
    at_inlet = pressure_gradient_ergun(
        u=U,
        d_p=D,
        eps=EPS,
        mu=float(fluid.viscosity(433.0)),
        rho=float(fluid.density(433.0)),
    )
    assert result.qoi["pressure_drop_Pa"] > 1.5 * at_inlet


def test_few_positions_do_not_change_the_drop():
    whole = cb.run(from_dict(bed(STEAM))).qoi["pressure_drop_Pa"]
    few = cb.run(from_dict(bed(STEAM, output={"positions": [0.2, 0.7]})))
    assert few.qoi["pressure_drop_Pa"] == approx(whole, rel=1e-12)
    assert len(few.profiles["p [Pa]"]) == 2


def test_walls_report_the_pressure_of_the_fluid():
    """A wide channel with no-slip walls has the gradient of plug flow but for its
    wall layers, some 2 %.
    """
    mesh = {
        "type": "rectangle",
        "length": 1.0,
        "height": 0.2,
        "cells": [10, 20],
        "graded": True,
    }
    sides = {"top": {"type": "no_slip"}, "bottom": {"type": "no_slip"}}
    values = bed(CONSTANT, mesh=mesh)
    values["boundary"] |= sides
    result = cb.run(from_dict(values))
    wanted = pressure_gradient_ergun(u=U, d_p=D, eps=EPS, mu=1.8e-5, rho=1.2)
    assert result.qoi["pressure_drop_Pa"] == approx(wanted, rel=0.03)


def test_pressure_between_walls_follows_the_temperature():
    """A wide heated channel with no-slip walls has the drop of plug flow but for its
    wall layers, some 2 %; with the properties of the inlet it would be less than half.
    Mass is conserved to the tolerance of the flow.
    """
    mesh = {
        "type": "rectangle",
        "length": 1.0,
        "height": 0.2,
        "cells": [30, 12],
        "graded": True,
    }
    values = bed(STEAM, mesh=mesh)
    values["boundary"]["right"] = {
        "solids": {"particles": {"fixed_temperature": 967.0}}
    }
    values["solids"]["particles"]["conductivity"] = 400.0  # the whole bed is hot
    plug = cb.run(from_dict(values))
    set_keys(values, 'boundary.top = { type = "no_slip" }')
    set_keys(values, 'boundary.bottom = { type = "no_slip" }')
    walls = cb.run(from_dict(values))
    assert walls.qoi["pressure_drop_Pa"] == approx(
        plug.qoi["pressure_drop_Pa"], rel=0.03
    )
    at_inlet = pressure_gradient_ergun(
        u=U,
        d_p=D,
        eps=EPS,
        mu=float(walls.plan.medium.fluid.viscosity(433.0)),
        rho=walls.plan.medium.mass_flux_scale(),
    )
    assert walls.qoi["pressure_drop_Pa"] > 1.5 * at_inlet
    assert_closed(walls, 1e-10, "fluid volume")
    assert not any("density of the fluid" in text for text in walls.warnings)


def channel(cells, conditions, c, inlet, local=None):
    """Flow through a channel of 1 m by 0.3 m with fields of local properties
    (expansion, viscosity) of x.
    """
    scene = bed(
        CONSTANT,
        mesh={"type": "rectangle", "length": 1.0, "height": 0.3, "cells": cells},
    )
    set_keys(scene, 'boundary.top = { type = "no_slip" }')
    mesh = cb.plan(from_dict(scene)).mesh
    space = Space(mesh.skfem, 2)
    x = space.points[0]
    fields = (
        None
        if local is None
        else LocalProperties(space, *(f(x) * np.ones_like(x) for f in local))
    )
    roles = {"left": "inlet", "right": "outlet"} | conditions
    equations = flow_equations(mesh, c, inlet, roles, fields)
    start = np.zeros(equations.system.size)
    equations.system.part(start, "u")[:] = np.asarray(inlet, dtype=float)[:, None]
    state, _ = newton(
        equations.residual,
        equations.with_given(start),
        equations.fixed,
        equations.system.ordered(Policy(2)),
        Options(1e-12),
    )
    return Flow(equations.system, state, c.porosity, fields)


def constants(density, viscosity):
    return Coefficients(density, viscosity, 0.4, 1e-6, 0.2, Components((0.0, 0.0)), 1.0)


def test_uniform_local_properties_are_those_of_another_fluid():
    """Half the density and twice the velocity: the same mass flux, so the flow of
    that fluid to rounding, 1e-9.
    """
    walls = {"top": "no_slip", "bottom": "slip"}
    local = channel(
        [12, 8], walls, constants(2.0, 1.0), (0.3, 0.0), (lambda x: 2.0, lambda x: 3e-3)
    )
    other = channel([12, 8], walls, constants(1.0, 3e-3), (0.6, 0.0))
    assert_allclose(local.expanded, other.velocity, atol=1e-9)
    assert_allclose(
        local.pressure,
        other.pressure,
        rtol=1e-9,
        atol=1e-9 * np.abs(other.pressure).max(),
    )


def test_a_fluid_that_expands_along_a_channel_without_walls():
    """u = U s(x) between slip walls; p is the integral of -G u'/eps^2 + (mu
    u')'/eps - drag: order 2 or more, as the pressure is linear in a cell.
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
        flow = channel(
            [cells, 2], {"top": "slip", "bottom": "slip"}, c, (U, 0.0), (s, mu)
        )
        x = flow.system.fields["p"][0].points[0]
        drop = flow.pressure[x == 0.0].mean() - flow.pressure[x == 1.0].mean()
        errors.append(abs(drop / wanted - 1.0))
    assert (
        errors[1] < errors[0] / 3.5 and errors[2] < errors[1] / 3.5 and errors[2] < 1e-3
    )


def lifting(velocity, **more):
    """Return the warnings of a run about a bed that is lifted, and the plan's text."""
    scene = from_dict(bed(CONSTANT, velocity) | more)
    return [
        text for text in cb.run(scene).warnings if "weight of the particles" in text
    ], str(plan(scene))


def test_a_fluid_that_lifts_the_bed_is_told():
    """With key and numbers, in plan and run: Ergun's gradient reaches (1 - eps)
    (rho_s - rho) g at 1.9 m/s.
    """
    weight = (1.0 - EPS) * (2000.0 - 1.2) * 9.81
    limit = brentq(
        lambda u: (
            pressure_gradient_ergun(u=u, d_p=D, eps=EPS, mu=1.8e-5, rho=1.2) - weight
        ),
        0.1,
        10.0,
    )
    assert lifting(0.99 * limit)[0] == []
    (text,), planned = lifting(1.01 * limit)
    found = pressure_gradient_ergun(u=1.01 * limit, d_p=D, eps=EPS, mu=1.8e-5, rho=1.2)
    assert (
        f"boundary.left.gas.velocity: the pressure gradient at 433 K, {found:.4g} "
        "Pa/m, exceeds the weight" in text
    )
    assert (
        f"{weight:.4g} Pa/m: if the fluid flows upwards, it fluidizes the bed" in text
    )
    assert "WARNING" in planned
    assert "if the fluid flows upwards" in planned


def test_only_an_upward_flow_lifts_the_bed():
    """A bed that moves descends, and the axis of a round bed points upwards."""
    gas, solids = (
        {"velocity": 4.0, "temperature": 433.0},
        {"particles": {"velocity": 1e-3, "temperature": 967.0}},
    )
    against = {"boundary": {"left": {"gas": gas}, "right": {"solids": solids}}}
    (text,), _ = lifting(4.0, **against)
    assert "the fluid fluidizes the bed" in text
    assert lifting(4.0, boundary={"left": {"gas": gas, "solids": solids}})[0] == []
    for sign, inlet in ((1, "bottom"), (-1, "top")):
        made = plan(
            from_dict(
                bed(CONSTANT, sign * 4.0)
                | {
                    "mesh": {"type": "axisymmetric", "length": 1.0, "radius": 0.2},
                    "boundary": {
                        inlet: {"gas": {"velocity": 4.0, "temperature": 433.0}},
                        "wall": {"solids": {"particles": {"fixed_temperature": 967.0}}},
                    },
                }
            )
        )
        assert bool(lifted(made, np.array([433.0]))) == (sign > 0)


def test_particles_as_dense_as_the_fluid_are_held_by_something_else():
    assert (
        lifting(
            4.0,
            solids={
                "particles": bed(CONSTANT, 4.0)["solids"]["particles"]
                | {"density": 1.2}
            },
        )[0]
        == []
    )


def test_the_hottest_fluid_lifts_first():
    """At the same mass flux viscosity grows and density falls with temperature; the
    weight hardly changes.
    """
    scene = from_dict(bed(STEAM, 2.0))
    made = plan(scene)
    cold, hot = (lifted(made, np.array([T])) for T in (433.0, 967.0))
    assert cold == ""
    assert lifted(made, np.array([433.0, 967.0, 500.0])) == hot
    assert "at 967 K" in hot


EXPANDS = """
mesh = { type = "line", length = 40.0 }
gas = { GAS }
solids.cat = { diameter = 6e-3, density = 1900.0 }
packed_bed = { porosity = 0.45 }
boundary.left.gas = { velocity = VELOCITY, temperature = 500.0 }
"""
AIR = 'model = "cantera", composition = "N2:0.79, O2:0.21", pressure = 10e5'
WATER = 'model = "coolprop", name = "Water", pressure = 100e5, T_range = [480.0, 520.0]'


@pytest.mark.parametrize("velocity", [0.2, 0.4, 1.0, 2.0])
def test_a_gas_that_the_drop_expands_is_a_warning(velocity):
    """Its pressure is that of an ideal gas at one temperature: the integral of
    p dp/dx = p_0 (dp/dx at p_0), which a drop beyond half of p_0 does not have.
    """
    text = EXPANDS.replace("GAS", AIR).replace("VELOCITY", str(velocity))
    result = cb.run(loads(text))
    drop = result.qoi["pressure_drop_Pa"]
    found = [text for text in result.warnings if "gas.pressure" in text]
    if drop < 0.04 * 10e5:
        assert not found
        return
    if drop > 5e5:
        assert "no gas that enters at this pressure" in found[0]
        return
    integral = solve_ivp(
        lambda x, p: -drop / 40.0 * 10e5 / p, (0.0, 40.0), [10e5], rtol=1e-9
    )
    lost = 10e5 - integral.y[0, -1]
    assert f"enters at this pressure loses {lost:.4g} Pa" in found[0]


def test_a_liquid_is_not_expanded_by_the_drop():
    text = EXPANDS.replace("GAS", WATER).replace("VELOCITY", "0.3")
    result = cb.run(loads(text))
    # 2 MPa change the density of water by 0.2 %
    assert result.qoi["pressure_drop_Pa"] > 1e6
    assert not [text for text in result.warnings if "gas.pressure" in text]


CONE = """
mesh = { type = "file", file = "cone.msh" }
gas = { density = 1.2, viscosity = 1.8e-5 }
solids.beads.diameter = 6e-3
packed_bed.porosity = 0.4
[boundary]
left.gas.velocity = 0.8
right.type = "outlet"
bottom.type = "no_slip"
top.type = "no_slip"
"""


def test_the_drop_of_a_bed_that_widens_is_that_of_mean_pressures(tmp_path):
    """In a wedge the pressure at the inlet is not that of its middle: the drop is the
    mean over the inlet, by its nodes, to the error of the trapezoidal rule.
    """
    across, along = 10, 16
    x, y = np.meshgrid(np.linspace(0, 0.2, along + 1), np.linspace(-1, 1, across + 1))
    points = np.stack([x, y * (0.03 + 0.4 * x), 0.0 * x], axis=-1).reshape(-1, 3)
    number = 1 + np.arange(len(points)).reshape(x.shape)
    corners = (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    cells = np.stack(corners, axis=-1).reshape(-1, 4).tolist()
    sides = ((1, number[0]), (2, number[:, -1]), (3, number[-1]), (4, number[:, 0]))
    elements = [(LINE, tag, n) for tag, row in sides for n in pairwise(row)]
    for a, b, c, d in cells:
        elements += [(TRIANGLE, 5, (a, b, c)), (TRIANGLE, 5, (a, c, d))]
    write(tmp_path / "cone.msh", points.tolist(), elements)
    (tmp_path / "cone.toml").write_text(CONE)
    result = cb.run(cb.load(tmp_path / "cone.toml"))
    space, p = result.nodal["p"]
    at_inlet = np.flatnonzero(space.points[0] == 0.0)
    order = at_inlet[np.argsort(space.points[1, at_inlet])]
    mean = trapezoid(p[order], space.points[1, order]) / 0.06
    middle = p[order][np.abs(space.points[1, order]).argmin()]
    assert result.qoi["pressure_drop_Pa"] == pytest.approx(mean, rel=2e-3)
    assert abs(middle / mean - 1.0) > 0.01


BLOCK = """
mesh = { type = "line", length = 0.5 }
gas = { density = 1.2, viscosity = 1.8e-5, heat_capacity = 1000, conductivity = 0.026 }
packed_bed.porosity = 0.5
closures = { permeability = 1e-8, forchheimer = 0.6, nusselt = 10 }
heat = {}
boundary.left.gas = { velocity = 2.0, temperature = 300.0 }
[solids.block]
diameter = 5e-3
density = 2500
heat_capacity = 800
conductivity = 1
"""


def test_the_drop_of_a_porous_block_with_heat():
    """Darcy's 1800 Pa and Forchheimer's 14400 Pa; nothing heats the gas."""
    result = cb.run(loads(BLOCK))
    assert result.qoi["pressure_drop_Pa"] == approx(16200.0, rel=1e-12)
    assert result.qoi["T_fluid_out_K"] == approx(300.0, abs=1e-9)


def test_the_template_without_heat_is_the_drop_alone():
    """Ergun's drop at the velocity relative to the particles, which sink at 0.5 mm/s:
    the superficial velocity of the gas less porosity times theirs.
    """
    text = MODELS["packed_bed"].template.read_text(encoding="utf-8")
    for table in ("heat", "closures"):
        text = re.sub(rf"(?ms)^\[{table}\].*?(?=^\[)", "", text)
    text = re.sub(r"(?m)^.*temperature = .*$", "", text)
    result = cb.run(loads(text))
    w = 0.5 + 0.4 * 0.3e-3 / 0.6
    lost = pressure_gradient_ergun(u=w, eps=0.4, d_p=0.04, mu=2e-5, rho=0.5)
    assert result.qoi["pressure_drop_Pa"] == approx(0.6 * float(lost), rel=1e-9)
    refused(
        r"boundary\.left\.gas\.temperature = 300\.0: has no meaning without a \[heat\] table",
        loads,
        text.replace("gas.velocity", "gas.temperature = 300.0\ngas.velocity"),
    )
