"""Heat of walls of two fluids: on any mesh that of a layer which the cells need not
resolve.
"""

import numpy as np
import pytest
from core_closures import bed, closures, line, rectangle, shaken_mesh
from scipy.special import erf

from contbed.loading import from_dict
from contbed.mesh import build as meshing
from contbed.models import plan
from contbed.scene.mesh import MeshAxisymmetric, MeshBox
from contbed.two_fluid import run as study
from contbed.two_fluid.boundary import Inlet, Outlet, symmetry
from contbed.two_fluid.fv import grid
from contbed.two_fluid.heat.equations import stored_heat
from contbed.two_fluid.heat.model import Physics, Thermal, build_heat
from contbed.two_fluid.model import Options

SLIP = symmetry()
CP_GAS, CP_SOLID, RHO_GAS, RHO_SOLID, EPS_S = 1000.0, 800.0, 1.2, 2500.0, 0.5
K_GAS, K_SOLID = 0.02, 0.18
K = K_GAS + K_SOLID
# heat capacity [J/m3/K] of gas and particles
C = RHO_GAS * (1 - EPS_S) * CP_GAS + RHO_SOLID * EPS_S * CP_SOLID
BOX = {"type": "box", "length": 0.02, "width": 0.03, "height": 0.04}
# what a second of conduction is off on any mesh at most
AT_REST = 0.03


def heated(on, sides, thermal, conductivity=(K_GAS, K_SOLID), **given):
    """A bed that conducts, with so much exchange that both phases are equally warm."""

    def conduct(eps_s, *_):
        flat = np.ones_like(eps_s)
        return conductivity[0] * flat, conductivity[1] * flat

    physics = Physics(CP_GAS, CP_SOLID, lambda s, *_: np.full_like(s, 1e4), conduct)
    heat = build_heat(on, physics, thermal)
    options = given.pop("options", Options(dt_max=0.01))
    still = {"gravity": (0.0,) * on.dimension, "options": options} | given
    return bed(on, closures(), sides, heat=heat, rho_solid=RHO_SOLID, **still)


def at_rest(on, thermal, T=300.0, **given):
    """The same, at rest and at one temperature."""
    made = heated(on, dict.fromkeys(on.boundaries, SLIP), thermal, **given)
    made.start(eps_s=EPS_S, T_gas=T, T_solid=T)
    return made


def conducted(t, difference=1.0):
    """Heat [J/m2] into half a space after t [s]."""
    return 2.0 * K * difference * np.sqrt(t * C / (np.pi * K))


def scene(cells, **changes):
    """Particles at rest beside a hot wall, 1 s."""
    made = {
        "model": "two_fluid",
        "mesh": {"type": "line", "length": 0.1, "cells": cells},
        "two_fluid": {"gravity": 0.0},
        "gas": {
            "density": 1.2,
            "viscosity": 1.8e-5,
            "heat_capacity": 1005.0,
            "conductivity": 0.026,
        },
        "solids": {
            "beads": {
                "diameter": 5e-4,
                "density": 2600.0,
                "heat_capacity": 800.0,
                "conductivity": 1.0,
            }
        },
        "closures": {"conductivity_bed": "zehner_schluender"},
        "initial": {
            "gas": {"temperature": 300.0},
            "solids": {
                "beads": {"volume_fraction": 0.58, "granular_temperature": 1e-8}
            },
        },
        "boundary": {
            "left": {"type": "wall", "temperature": 380.0},
            "right": {"type": "wall"},
        },
        "heat": {},
        "time": {"end": 1.0},
        "output": {"plots": False, "fields": False},
    }
    return made | changes


@pytest.mark.parametrize("cells", [10, 40, 160, 640])
def test_heat_into_particles_at_rest(cells):
    """Exact: 2 k dT sqrt(t C/(pi k)), whether a cell is 16 times as deep as the layer
    or a quarter of it.
    """
    run = study.Run(plan(from_dict(scene(cells))))
    run.bed.advance(1.0)
    assert run.bed.state.energy.account.walls == pytest.approx(39430.0, rel=AT_REST)


GRIDS = {
    "line": lambda: line(0.1, 10),
    "rectangle": lambda: rectangle(0.1, 0.05, (10, 8)),
    "triangles": lambda: rectangle(0.1, 0.05, (10, 8), shape="triangle"),
    "box": lambda: grid.build(meshing.build(MeshBox(**BOX, cells=(4, 5, 6)))),
    "tetrahedra": lambda: grid.build(
        meshing.build(MeshBox(**BOX, cells=(3, 4, 5), shape="tetrahedron"))
    ),
    "axisymmetric": lambda: grid.build(
        meshing.build(
            MeshAxisymmetric(
                type="axisymmetric", length=0.3, radius=0.2, cells=(12, 10)
            )
        )
    ),
}


@pytest.mark.parametrize("name", GRIDS)
def test_each_wall_heats_and_cools_alike(name):
    """All walls of all meshes, each alone: the same heat per area, to rounding the
    opposite with the opposite difference.
    """
    on = GRIDS[name]()
    for side in on.boundaries:
        if side == "axis":
            continue
        area = on.geometry.area[on.boundaries[side]].sum()
        found = []
        for wall in (350.0, 250.0):
            made = at_rest(on, {side: Thermal(wall=wall)})
            start = stored_heat(made.state, made.model)
            made.advance(0.3)
            energy = made.state.energy
            heat = energy.account.walls
            gained = stored_heat(made.state, made.model) - start
            assert gained == pytest.approx(heat, rel=1e-9)
            of_faces = energy.wall_heat[on.boundaries[side]].sum()
            assert of_faces == pytest.approx(heat, rel=1e-9)
            assert np.count_nonzero(energy.wall_heat) == len(on.boundaries[side])
            found.append(heat / area)
        assert found[0] == pytest.approx(-found[1], rel=1e-9)
        # corners of round beds give more than half a space
        assert found[0] == pytest.approx(conducted(0.3, 50.0), rel=AT_REST)


def test_a_resolved_layer_is_that_of_the_mesh():
    """Cells much thinner than the layer: T = T_wall - dT erf(x/sqrt(4 k t/C))."""
    on = line(0.01, 200)
    made = at_rest(on, {"left": Thermal(wall=400.0)}, options=Options(dt_max=2e-3))
    made.advance(4.0)
    x = on.centres[:, 0]
    exact = 400.0 - 100.0 * erf(x / np.sqrt(4.0 * K * 4.0 / C))
    np.testing.assert_allclose(made.state.energy.T_solid, exact, atol=0.2)


@pytest.mark.parametrize(
    ("on", "off"),
    [
        (lambda: line(0.1, 7), 1e-7),
        # as conduction along a side of triangles is
        (lambda: rectangle(0.1, 0.02, (40, 8), shape="triangle"), 0.015),
    ],
)
def test_steady_heat_is_linear(on, off):
    """Two walls: the temperature is linear and the heat k dT/L, to the iteration."""
    on = on()
    made = at_rest(
        on,
        {"left": Thermal(wall=300.0), "right": Thermal(wall=400.0)},
        options=Options(dt=1e4),
    )
    for _ in range(30):
        made.step(1e4)
    before = made.state.energy.wall_heat
    made.step(1e4)
    energy = made.state.energy
    if on.dimension == 1:
        exact = 300.0 + 1e3 * on.centres[:, 0]
        np.testing.assert_allclose(energy.T_solid, exact, rtol=1e-8)
    faces = on.boundaries["right"]
    rate = (energy.wall_heat - before)[faces].sum() / 1e4
    area = on.geometry.area[faces].sum()
    assert rate / area == pytest.approx(K * 100.0 / 0.1, rel=off)


def sliding(cells, u, height=0.1, options=None, wall=400.0):
    """Particles and gas that slide upwards along a hot wall on the left."""
    on = rectangle(0.05, height, cells)
    sides = {"left": SLIP, "right": SLIP, "top": Outlet()}
    sides["bottom"] = Inlet(u * (1 - EPS_S), EPS_S, solid_velocity=u)
    thermal = {"bottom": Thermal(300.0, 300.0), "left": Thermal(wall=wall)}
    options = options or Options(dt_max=0.01, theta="frozen")
    made = heated(on, sides, thermal, options=options)
    made.start(
        eps_s=EPS_S, u_gas=[0.0, u], u_solid=[0.0, u], T_gas=300.0, T_solid=300.0
    )
    return made


@pytest.mark.parametrize("cells", [(5, 10), (10, 20), (40, 20)])
def test_packets_of_one_time_of_contact(cells):
    """Particles that slide past a wall for tau take sqrt(4 k C/(pi tau)), as Mickley
    and Fairbanks have it.
    """
    u, height = 0.1, 0.1
    made = sliding(cells, u)
    made.advance(2.0)
    before = made.state.energy.account.walls
    made.advance(2.5)
    h = (made.state.energy.account.walls - before) / 0.5 / height / 100.0
    # upwind along the wall mixes the ages of ten cells
    assert h == pytest.approx(np.sqrt(4 * K * C / (np.pi * height / u)), rel=0.06)


def test_gas_alone_conducts_as_gas():
    """No particles: half a space of gas."""
    on = line(0.2, 10)
    made = at_rest(on, {"left": Thermal(wall=310.0)}, conductivity=(0.026, 0.0))
    made.start(eps_s=0.0, T_gas=300.0, T_solid=300.0)
    made.advance(2.0)
    exact = 20.0 * 0.026 * np.sqrt(2.0 * 1.2 * CP_GAS / (np.pi * 0.026))
    assert made.state.energy.account.walls == pytest.approx(exact, rel=AT_REST)


def test_shaken_meshes_conduct_alike():
    """A wall beside triangles and quadrilaterals of any form."""
    for shape in ("triangle", "quadrilateral"):
        on = grid.build(shaken_mesh(shape, (8, 8)))
        made = at_rest(on, {"left": Thermal(wall=400.0)})
        made.advance(1.0)
        heat = made.state.energy.account.walls
        assert heat == pytest.approx(conducted(1.0, 100.0), rel=AT_REST)
