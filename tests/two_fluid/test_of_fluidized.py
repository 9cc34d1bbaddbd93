"""Minimum fluidization, height and circulation of beds of two fluids against closed
forms and by hand.
"""

from dataclasses import replace

import numpy as np
import pytest
from pytest import approx
from skfem import MeshQuad, MeshTri

import contbed as cb
from contbed.loading import loads
from contbed.mesh.build import build as build_mesh
from contbed.mesh.mesh import Mesh
from contbed.models import MODELS
from contbed.scene.mesh import MeshRectangle
from contbed.two_fluid.fv.grid import build
from contbed.two_fluid.of_fluidized import (
    bed_height,
    carried_out,
    circulation,
    layering,
    minimum_fluidization,
)
from contbed.two_fluid.vessel import Vessel, depth


def column(drag="drag_gidaspow", time=""):
    text = MODELS["two_fluid"].template.read_text().replace("drag_syamlal_obrien", drag)
    if time:
        text = text.split("[time]")[0] + f"[time]\n{time}\n"
    return loads(text)


def test_minimum_fluidization_by_ergun():
    """Below a porosity of 0.8 Gidaspow's drag is Ergun's:
    150 eps_s mu u/(eps^3 d^2) + 1.75 rho u^2/(eps^3 d) = (rho_s - rho) g.
    """
    scene = column()
    mu, rho, d, eps = 1.8e-5, 1.2, 4e-4, 0.42
    a = 1.75 * rho / (eps**3 * d)
    b = 150.0 * 0.58 * mu / (eps**3 * d**2)
    weight = (2500.0 - rho) * scene.two_fluid.gravity
    expected = 2.0 * weight / (b + np.sqrt(b**2 + 4.0 * a * weight))
    assert minimum_fluidization(scene, 0.58) == approx(expected, rel=1e-6)


def test_height_of_a_uniform_bed_below_gas():
    """Half of a vessel of 1 m is filled evenly; its centre of mass lies in the middle
    of a cell or between two.
    """
    z = (np.arange(40) + 0.5) / 40
    eps_s = np.where(z < 0.5, 0.5, 0.0)
    volume = np.full(40, 0.025)
    vessel = Vessel(np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    assert bed_height(eps_s, volume, z, vessel) == approx(0.5, rel=1e-12)
    # carried to the top
    assert bed_height(np.full(40, 0.1), volume, z, vessel) is None


def wedge(kind):
    """A grid of a vessel from 1 m wide below to 3 m above, 2 m high."""
    shapes = {"triangles": MeshTri, "quadrilaterals": MeshQuad}
    x, z = np.linspace(-0.5, 0.5, 9), np.linspace(0.0, 2.0, 33)
    mesh = shapes[kind].init_tensor(x, z)
    points = np.stack((mesh.p[0] * (1.0 + mesh.p[1]), mesh.p[1]))
    mesh = replace(mesh, doflocs=points)
    return build(Mesh(mesh.with_boundaries({"all": lambda x: x[1] > -1.0})))


@pytest.mark.parametrize("rows", [1, 16])
def test_a_vessel_whose_ends_are_periodic_has_its_height(rows):
    """One of both ends has no face of its own."""
    mesh = build_mesh(
        MeshRectangle(type="rectangle", length=1.0, height=2.0, cells=(2, rows))
    )
    grid = build(mesh, [("bottom", "top")])
    assert depth(grid, np.full(2 * rows, 0.2)) == approx(0.4, rel=1e-12)


@pytest.mark.parametrize("kind", ["triangles", "quadrilaterals"])
def test_a_bed_in_a_vessel_that_widens(kind):
    """A wedge of width 1 + z, filled evenly to 1 m, holds 1.5 m2 of it: its mean
    section is 1.5 m and its column 0.5 m of particles. Its cells have straight sides
    and are spread over their heights: some tenths of a percent.
    """
    grid = wedge(kind)
    z, volume = grid.centres[:, -1], grid.geometry.volume
    eps_s = np.where(z < 1.0, 0.5, 0.0)
    vessel = Vessel.of(grid)
    height = bed_height(eps_s, volume, z, vessel)
    assert height == approx(1.0, rel=3e-3)
    assert vessel.section(height) == approx(1.5, rel=3e-3)
    assert vessel.section() == approx(2.0, rel=1e-12)
    assert depth(grid, eps_s) == approx(0.5, rel=3e-3)


def test_a_plug_that_lies_on_a_looser_layer():
    """0.4 m of 0.4 below 0.2 m of 0.6: the centre of mass is at 0.3286 m, with cells
    of 0.4 alone below it, and the 7 cm of them above 0.33 m.
    """
    z = (np.arange(100) + 0.5) / 100
    eps_s = np.where(z < 0.4, 0.4, np.where(z < 0.6, 0.6, 0.0))
    volume = np.full(100, 0.01)
    above = (0.07 * 0.4**2 + 0.2 * 0.6**2) / (0.07 * 0.4 + 0.2 * 0.6)
    assert layering(eps_s, volume, z) == approx(above / 0.4, rel=1e-12)
    even = np.where(z < 0.6, 0.4, 0.0)
    assert layering(even, volume, z) == approx(1.0, rel=1e-12)


def test_a_bed_that_blows_out():
    scene = column("drag_syamlal_obrien", "end = 0.004")
    held = {"solids [kg]": np.array([3.0, 2.8, 2.4])}
    (text,) = carried_out(scene, held)
    assert text.startswith("20 % of the particles have left through outlets")
    assert not carried_out(scene, {"solids [kg]": np.array([3.0, 2.8])})


def test_circulation_of_particles_that_rise_in_a_quarter_of_the_section():
    z = np.repeat((np.arange(10) + 0.5) / 10, 4)
    flux = np.tile([3.0, -1.0, -1.0, -1.0], 10)
    volume = np.full(40, 0.025)
    assert circulation(flux, volume, z, 0.8) == approx(0.75, rel=1e-12)


def test_a_bed_reports_its_excess_of_gas():
    times = "end = 0.004\nsample = 0.002\naverage_from = 0.0"
    qoi = cb.run(column("drag_syamlal_obrien", times)).qoi
    assert qoi["u_over_u_mf"] * qoi["u_mf_m_s"] == approx(0.5, rel=1e-12)
    assert qoi["bed_height_m"] == approx(0.12, rel=0.05)
    assert qoi["circulation_kg_m2s"] >= 0.0
