"""Bubbles of two fluids: circles of known size that move at a known velocity, on
rectangles, triangles and across periodic sides.
"""

from dataclasses import replace

import numpy as np
import pytest
import skfem
from pytest import approx

from contbed.loading import loads
from contbed.mesh.mesh import Mesh
from contbed.models import MODELS
from contbed.ranks.two_fluid.division import Division
from contbed.two_fluid.bubbles import Bubbles, open_regions, rises
from contbed.two_fluid.end_pressure import end_faces
from contbed.two_fluid.fv.connections import connect
from contbed.two_fluid.fv.grid import build
from contbed.two_fluid.of_fluidized import judge
from contbed.two_fluid.plan import plan
from tests.cases import each_case

WIDTH, HEIGHT = 0.1, 0.3
TIMES = "end = 2.0\naverage_from = 0.0"


def planned(cells=(50, 150), periodic=False):
    """A plan of the template's bed on other cells, without its kernels."""
    text = MODELS["two_fluid"].template.read_text().split("[time]")[0]
    text = text.replace("[10, 30]", str(list(cells)))
    if periodic:
        start = text.split("[boundary.left]")[0]
        left = '[boundary.left]\ntype = "periodic"\npartner = "right"\n'
        text = start + left + "[initial]" + text.split("[initial]")[1]
    return plan(loads(f"{text}[time]\n{TIMES}\n"))


def circle(centres, middle, diameter, width=np.inf):
    """Porosity one within a circle, in a bed up to 0.2 m, and above it."""
    across = centres[:, 0] - middle[0]
    if np.isfinite(width):
        across -= width * np.rint(across / width)
    inside = np.hypot(across, centres[:, 1] - middle[1]) < 0.5 * diameter
    return inside | (centres[:, 1] > 0.2)


def test_a_circle_has_its_diameter_and_rises_as_it_is_moved():
    """On cells of 2 mm: size within the mesh error, velocity exact as the circle is
    moved by whole cells.
    """
    bed, diameter, speed, step = planned(), 0.0402, 0.4, 0.01
    bubbles = Bubbles(bed)
    for row in range(8):
        middle = (0.051, 0.061 + speed * step * row)
        gas = circle(bed.grid.centres, middle, diameter)
        bubbles.add(step * row, np.where(gas, 0.0, 0.55))
    found, table = bubbles.findings(8, 0.2)
    assert found["bubbles"] == 1.0
    assert found["bubble_diameter_m"] == approx(diameter, rel=0.02)
    assert found["bubble_diameter_max_m"] == approx(diameter, rel=0.02)
    assert found["bubble_rise_m_s"] == approx(speed, rel=1e-9)
    share = 0.25 * np.pi * found["bubble_diameter_m"] ** 2 / (WIDTH * 0.2)
    assert found["bubble_share"] == approx(share, rel=1e-9)
    assert table["delta [1]"].mean() == approx(share, rel=1e-9)
    assert np.nanmax(table["u_b [m/s]"]) == approx(speed, rel=1e-9)


def test_triangles_show_the_same_circle():
    mesh = skfem.MeshTri.init_tensor(
        np.linspace(0.0, WIDTH, 51), np.linspace(0.0, HEIGHT, 151)
    )
    mesh = mesh.with_boundaries({"all": lambda x: x[0] > -1.0})
    mesh = mesh.with_subdomains({"bed": lambda x: x[0] > -1.0})
    grid = build(Mesh(mesh, False))
    ends = np.concatenate([end_faces(grid, side) for side in (-1, 1)])
    gas = circle(grid.centres, (0.05, 0.1), 0.04)
    links = np.stack((grid.geometry.left[: grid.interior], grid.geometry.right))
    at_ends = grid.geometry.left[grid.interior + ends]
    found = open_regions(gas, links, at_ends, grid.geometry.volume, grid.centres)
    ((volume, x, y),) = found
    assert np.sqrt(4.0 * volume / np.pi) == approx(0.04, rel=0.01)
    assert (x, y) == approx((0.05, 0.1), abs=1e-4)


def test_a_circle_across_periodic_sides_is_one():
    bed = planned(periodic=True)
    bubbles = Bubbles(bed)
    gas = circle(bed.grid.centres, (0.0, 0.1), 0.04, WIDTH)
    bubbles.add(0.0, np.where(gas, 0.0, 0.55))
    found, _ = bubbles.findings(1, 0.2)
    assert found["bubbles"] == 1.0
    assert found["bubble_diameter_m"] == approx(0.04, rel=0.01)


def test_the_outline_that_ranks_have_shows_the_same_bubbles():
    bed = planned(periodic=True)
    outline = Division.of(connect(bed.mesh, [("left", "right")])).outline()
    gas = circle(bed.grid.centres, (0.0, 0.1), 0.04, WIDTH)
    found = []
    for one in (bed, replace(bed, grid=outline)):
        bubbles = Bubbles(one)
        bubbles.add(0.0, np.where(gas, 0.0, 0.55))
        found.append(bubbles.findings(1, 0.2)[0])
    assert found[1] == approx(found[0], rel=1e-12)


@pytest.mark.parametrize("middle", [(0.05, 0.0), (0.05, 0.2), (0.05, 0.25)])
def test_gas_at_the_floor_and_freeboard_is_no_bubble(middle):
    bed = planned()
    bubbles = Bubbles(bed)
    gas = circle(bed.grid.centres, middle, 0.03)
    bubbles.add(0.0, np.where(gas, 0.0, 0.55))
    assert bubbles.findings(1, 0.2) == ({"bubbles": 0.0}, {})


def test_bubbles_are_followed_only_where_rows_are_near_enough():
    """A bubble of 0.04 m moves by its radius in 0.045 s at 0.71 sqrt(g d)."""
    diameter, centre = np.full(2, 0.04), np.array([[0.05, 0.10], [0.05, 0.11]])
    slow, fast = (
        rises(np.array([0.0, step]), diameter, centre, 9.81) for step in (0.044, 0.046)
    )
    assert slow[1] == approx(0.01 / 0.044)
    assert np.isnan([slow[0], *fast]).all()
    other = rises(np.array([0.0, 0.02]), diameter * [1.0, 1.4], centre, 9.81)
    assert np.isnan(other).all()


def test_rows_that_are_too_far_apart_are_reported():
    bed = planned()
    bubbles = Bubbles(bed)
    (text,) = bubbles.judge(bed.scene, {"bubble_diameter_m": 0.04}, 0.1)
    assert "time.sample = 0.04" in text
    assert not bubbles.judge(bed.scene, {"bubble_diameter_m": 0.04}, 0.01)
    followed = {"bubble_diameter_m": 0.04, "bubble_rise_m_s": 0.3}
    assert not bubbles.judge(bed.scene, followed, 0.1)


@each_case(__file__, "a_run_too_short_for_a_frequency_says_so")
def test_a_run_too_short_for_a_frequency_says_so(rows, frequency, words):
    qoi = {} if frequency is None else {"dominant_frequency [Hz]": frequency}
    time = np.linspace(0.0, 2.0, rows)
    found = judge(planned().scene, {"t [s]": time}, qoi)
    assert (words is None and not found) or words in found[0]
