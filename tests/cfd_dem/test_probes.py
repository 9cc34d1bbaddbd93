"""Probes of beds with gas: interpolation, columns of profiles, points outside of the
box; beds settled deep.
"""

from pathlib import Path

import numpy as np
import pytest
from pytest import approx

import contbed as cb
from contbed.cfd_dem.gas import Gas
from contbed.cfd_dem.grid import Grid
from contbed.cfd_dem.plan import _largest_overlap
from contbed.cfd_dem.probes import probes_of
from contbed.closures import drag_di_felice
from contbed.dem.particles import Particles
from contbed.loading import loads
from contbed.materials.constant import ConstantFluid
from contbed.output.progress import Progress
from tests.refusals import refused

SCENE = """
particles = { count = 60, width = ["8 mm", "8 mm"], height = "60 mm", modulus = "1 MPa", seed = 3 }
solids.glass = { diameter = "2 mm", density = 2500.0, conductivity = 0.84, restitution = 0.5 }
gas = { density = 1.2, viscosity = 1.8e-5, heat_capacity = 1005.0, conductivity = 0.026 }
closures.nusselt = "gunn"
boundary.bottom.gas.velocity = 1.0
time = { end = 0.004, sample = 0.002 }
output = { plots = true, fields = false, probes = { floor = [0.004, 0.004, 0.0], above = [0.001, 0.007, 0.055] } }
"""


@pytest.fixture
def gas():
    grid = Grid(np.array([0.01, 0.02, 0.0]), np.array([1e-3, 2e-3, 3e-3]), (3, 1, 4))
    gas = Gas(grid, ConstantFluid(1.2, 1005.0, 1.8e-5, 0.026), drag_di_felice)
    x, _, z = grid.centres.T
    gas.p, gas.eps = 2.0 + 3.0 * x + 5.0 * z, 0.4 + 10.0 * z
    return gas


def test_a_linear_field_is_found_exactly(gas):
    x, z = 0.0117, 0.0071
    probes = probes_of(gas.grid, {"a": (x, 0.0209, z)})
    assert probes.columns == ["a p [Pa]", "a eps_s [1]"]
    assert probes.row(gas) == approx(
        [2.0 + 3.0 * x + 5.0 * z, 0.6 - 10.0 * z], rel=1e-13
    )


def test_beside_a_wall_the_values_are_those_of_the_cells(gas):
    corner = probes_of(gas.grid, {"a": (0.01, 0.02, 0.0), "b": (0.013, 0.022, 0.012)})
    assert corner.row(gas)[::2] == approx([gas.p[0], gas.p[-1]], rel=1e-14)


def test_profiles_hold_the_probes_and_the_highest_particle(tmp_path):
    result = cb.run(loads(SCENE), out=tmp_path)
    columns = result.profiles
    assert len(columns["floor p [Pa]"]) == 2
    assert columns["floor p [Pa]"][0] > 10.0 * columns["above p [Pa]"][0] > 0.0
    assert columns["floor eps_s [1]"][0] > 0.3
    assert columns["above eps_s [1]"][0] == 0.0
    assert columns["height_max [m]"][0] > columns["height [m]"][0]
    assert (tmp_path / "profiles.png").is_file()
    assert "floor p [Pa]" in (tmp_path / "profiles.csv").read_text().splitlines()[0]


def test_a_probe_outside_of_the_box_is_refused():
    refused(
        r":8: output.probes.above = .* outside of the box from 0 to 0.008, 0.008",
        lambda: loads(SCENE.replace("0.055]", "0.065]")),
    )


def test_a_bed_that_has_settled_deep_into_itself_runs(tmp_path):
    """Soft spheres rest on overlaps of 7 % of the radius; their file is accepted
    again, but not for stiffer spheres.
    """
    soft = SCENE.replace('"1 MPa"', '"20 kPa"').replace(
        "plots = true, fields = false", "plots = false"
    )
    result = cb.run(loads(soft), out=tmp_path)
    assert result.qoi["time [s]"] == approx(0.004, rel=0.1)
    (file,) = tmp_path.glob("particles*.vtu")
    again = soft.replace("count = 60", f'file = "{file}"').replace(", seed = 3", "")
    assert len(cb.run(loads(again)).plan.particles) == 60
    refused(
        r"at most 0\.05 is accepted with their stiffness",
        lambda: cb.run(loads(again.replace('"20 kPa"', '"100 MPa"'))),
    )


def test_overlaps_of_a_file_are_judged_by_the_stiffness():
    """Hertz at 1 m/s: delta/R = (15 m* v2/(16 E* sqrt(R*)))^(2/5)/R, 0.17 at 1 MPa
    for glass beads of any size.
    """
    for modulus, expected in ((1e6, 0.1740), (1e8, 0.05), (1e4, 0.5)):
        scene = loads(SCENE.replace('"1 MPa"', f"{modulus}"))
        for radius in (1e-3, 4e-3):
            beads = Particles([[0.0, 0.0, 0.0]], radius)
            assert _largest_overlap(scene.particles, scene.solid, beads) == approx(
                expected, rel=1e-3
            )


def test_one_bar_shows_the_whole_run(monkeypatch):
    """Time that is left follows from one pace, not from that of each sample."""
    seen = []
    changes = {
        "time.end": "0.02 s",
        "time.average_from": "0.01 s",
        "time.fields": "0.02 s",
    }
    scene = cb.load(Path(cb.__file__).parent / "cfd_dem" / "template.toml", changes)
    monkeypatch.setattr(
        Progress, "advance_to", lambda bar, value, note="": seen.append((bar, value))
    )
    cb.run(scene)
    # others settle the packing before
    whole = [(bar, value) for bar, value in seen if bar.total == 0.02]
    values = [value for _, value in whole]
    assert len({id(bar) for bar, _ in whole}) == 1 and seen[-1][0] is whole[-1][0]
    assert seen.index(whole[0]) == len(seen) - len(whole)  # none in between
    assert values == sorted(values) and values[-1] == approx(0.02, rel=1e-3)
