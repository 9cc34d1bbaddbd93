"""Tubes in a bed of particles in a gas: exact conductances, symmetry, blocked cells,
heat, restart, bad scenes.
"""

import re

import numpy as np
import pytest
from pytest import approx
from scipy.integrate import quad
from typer.testing import CliRunner

import contbed as cb
from contbed.cfd_dem.conduction import Solid
from contbed.cfd_dem.gas import Gas
from contbed.cfd_dem.gas_quantities import Motion
from contbed.cfd_dem.grid import Grid
from contbed.cfd_dem.tubes import SECTORS, BedTube, TubeHeat, angles, blocked
from contbed.cli import app
from contbed.closures import drag_gidaspow, nusselt_cylinder_churchill_bernstein
from contbed.closures.binding import BoundClosure
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Domain, box
from contbed.loading import loads
from contbed.materials.constant import ConstantFluid
from tests.balances import assert_closed
from tests.cases import each_case
from tests.refusals import refused
from tests.restarts import same_run

AIR = ConstantFluid(1.2, 1005.0, 1.8e-5, 0.026)
WIDTH, DEPTH, HEIGHT = 24e-3, 4e-3, 30e-3
R, R_TUBE, K, K_GAS = 0.5e-3, 4e-3, 1.1, 0.026
COUNT = (12, 2, 15)
SIZE = np.array([WIDTH, DEPTH, HEIGHT]) / COUNT

SCENE = """
particles = { count = 150, width = ["24 mm", "6.5 mm"], height = "60 mm", modulus = "1 MPa", seed = 3, \
cell = [2.0, 2.0], tubes = { low = { diameter = "8 mm", centre = ["12 mm", "7 mm"], temperature = 350.0 } } }
solids.glass = { diameter = "2 mm", density = 2600.0, conductivity = 1.1, youngs_modulus = "50 GPa", restitution = 0.5 }
gas = { density = 1.2, viscosity = 1.8e-5, heat_capacity = 1005.0, conductivity = 0.026 }
closures.nusselt = "gunn"
boundary.bottom.gas = { velocity = 1.5, temperature = 300.0 }
heat = {}
initial.solids.glass.temperature = 310.0
time = { end = 0.012, sample = 0.002, average_from = 0.004, checkpoint_every = 0.0001 }
output = { plots = false }
"""


def tube_at(x, z):
    law = BoundClosure(nusselt_cylinder_churchill_bernstein, {}, ("Re", "Pr"))
    return BedTube("tube", x, z, R_TUBE, DEPTH, law)


def around(x, modulus=None):
    """What spheres at `x` and gas that rises at 1 m/s exchange with a tube in the
    middle.
    """
    tube = tube_at(WIDTH / 2, HEIGHT / 2)
    domain = Domain((0, 0, 0), (WIDTH, DEPTH, np.inf))
    material = Material(density=2600.0, youngs_modulus=1e6)
    simulation = Simulation(
        Particles(x, R),
        [material],
        [*box(domain), tube.wall],
        domain,
        impact_speed=0.3,
        largest_overlap=0.1,
    )
    grid = Grid(np.zeros(3), SIZE, COUNT, blocked=blocked(SIZE, COUNT, [tube], 2.0 * R))
    gas = Gas(grid, AIR, drag_gidaspow)
    gas.inlet(1.0, 300.0)
    motion = Motion(simulation.position, simulation.velocity, simulation.radius)
    gas.start(motion)
    heat = TubeHeat(tube, grid, Solid(K, modulus=modulus))
    return heat.around(simulation, gas, motion), heat, gas


def at(angle, gap):
    """A sphere at an angle from the bottom of the tube [deg], its surface `gap` [m]
    away.
    """
    way, off = np.radians(angle), R_TUBE + R + gap
    return [[WIDTH / 2 + off * np.sin(way), 1.7e-3, HEIGHT / 2 - off * np.cos(way)]]


@pytest.mark.parametrize("gap", [0.0, 0.1 * R, 0.45 * R])
def test_a_sphere_beside_a_tube_conducts_as_beside_an_isothermal_plane(gap):
    """Heat along parallel lines through sphere and gas to the plane between a sphere
    and its image; 1e-9: the digits of both integrals are 1e-12, those of coordinates at
    contact some 1e-13 of a gap of 1e-4 R."""
    found, _, gas = around(at(90.0, gap + 1e-13))
    where, share, _ = gas.grid.shares(np.array(at(90.0, gap)), np.array([R]))
    eps = float((share * gas.eps[where]).sum())
    D, cone = R + gap, 0.56 * R * (1.0 - eps) ** (-1 / 3)
    end = R * cone / np.hypot(cone, D)

    def line(r):
        u = np.sqrt(R**2 - r**2)
        return 2.0 * np.pi * r / ((u - r * D / cone) / K + (D - u) / K_GAS)

    assert found.gap == approx(
        [quad(line, 0.0, end, epsabs=0.0, epsrel=1e-11)[0]], rel=1e-9
    )
    assert found.contact == 0.0 and found.touching.sum() == 0.0


def test_a_contact_conducts_as_an_isothermal_disc_on_a_half_space():
    """4 k a with Hertz's radius a = (R delta)^(1/2), times (E/E_0)^(1/3) for a
    stiffer material; to rounding.
    """
    delta = 0.05 * R
    for modulus, factor in ((None, 1.0), (64e6, 0.25)):
        found, *_ = around(at(30.0, -delta), modulus=modulus)
        assert found.contact == approx(
            [4.0 * K * np.sqrt(R * delta) * factor], rel=1e-9
        )
        assert found.touching.tolist() == [0, 1, *[0] * (SECTORS - 2)]


def test_a_sphere_too_far_away_conducts_nothing():
    found, *_ = around(at(90.0, 0.51 * R))
    assert len(found.near) == 0


def test_the_gas_exchanges_by_the_speed_beside_the_tube():
    """A superficial velocity that is the same on all faces gives its Nusselt number at
    each sector, to rounding; where blocked cells shut the faces above and below, the
    gas is slower there than at the sides."""
    found, heat, gas = around([[1e-3, 1e-3, 1e-3]])
    assert (found.h[[0, 6]] < found.h[3]).all()
    gas.q = np.array([0.3, 0.0, 0.6])[gas.grid.face_axis]
    h, D, speed = heat._convection(gas), 2.0 * R_TUBE, np.hypot(0.3, 0.6)
    Re, Pr = 1.2 * speed * D / 1.8e-5, 1.8e-5 * 1005.0 / K_GAS
    law = nusselt_cylinder_churchill_bernstein(Re=Re, Pr=Pr)
    assert h == approx(np.full(SECTORS, law * K_GAS / D), rel=1e-12)


def test_what_is_mirrored_gives_mirrored_coefficients():
    """Left and right, and below and above, of spheres at mirrored places; 1e-9 for
    rounding of the coordinates.
    """
    found, *_ = around(
        [
            *at(40.0, 0.01 * R),
            *at(320.0, 0.01 * R),
            *at(140.0, 0.01 * R),
            *at(220.0, 0.01 * R),
        ]
    )
    assert found.gap == approx(np.full(4, found.gap[0]), rel=1e-9)
    assert found.sector.tolist() == [1, 11, 5, 7]
    assert found.eps == approx(np.roll(found.eps[::-1], 1), rel=1e-12)
    assert found.h == approx(np.roll(found.h[::-1], 1), rel=1e-12)
    assert angles()[found.sector] == approx([30.0, 330.0, 150.0, 210.0])


def test_blocked_cells_lie_within_the_tube_and_hold_no_particle():
    tube = tube_at(WIDTH / 2, HEIGHT / 2)
    fine = SIZE / 8.0
    count = tuple(8 * n for n in COUNT)
    shut = blocked(fine, count, [tube], 2.0 * R)
    area = shut[:, 0].sum() * fine[0] * fine[2]
    # between the tube and what the centre of a sphere can reach; the staircase lacks at
    # most a ring of one diagonal
    assert (
        np.pi * (R_TUBE - np.hypot(fine[0], fine[2])) ** 2
        < area
        < np.pi * (R_TUBE + R) ** 2
    )
    assert blocked(fine, count, [], 2.0 * R) is None


def test_heat_of_a_tube_is_in_the_balance(tmp_path):
    """Energy to 1e-10 of what goes through, mass to rounding; the mean of the rows
    is what the balance has.
    """
    result = cb.run(loads(SCENE), out=tmp_path)
    energy = result.balances["energy"]
    rows = result.profiles["low heat_tube [W]"]
    t = np.concatenate([[0.0], result.profiles["t [s]"]])
    assert energy["source"] == approx(rows @ np.diff(t), rel=1e-12)
    assert energy["source"] > 0.0 and abs(energy["relative_residual"]) < 1e-10
    assert_closed(result, 1e-12, "gas")
    table = result.tables["tube_low"]
    parts = (
        table["h_contact [W/m2/K]"]
        + table["h_gap [W/m2/K]"]
        + table["h_convection [W/m2/K]"]
    )
    assert table["h [W/m2/K]"] == approx(parts, rel=1e-14)
    assert result.qoi["h_tube_low [W/m2/K]"] == approx(parts.mean(), rel=1e-14)
    # the samples of the averages are at the ends of the rows, of which each has some
    # steps
    assert table["q [W/m2]"].sum() * np.pi * 8e-3 * 6.5e-3 / SECTORS == approx(
        rows[1:].mean(), rel=0.2
    )
    # particles and gas are between 300 K and the tube
    assert (table["q [W/m2]"] <= 50.0 * parts).all()
    assert (tmp_path / "tube_low.csv").read_text().startswith("angle [deg],h [W/m2/K]")
    assert 0 < result.plan.number < 150
    names = [use["name"] for use in result.closures]
    assert "nusselt_cylinder_churchill_bernstein" in names


def test_a_tube_as_warm_as_the_bed_gives_no_heat():
    scene = SCENE.replace("temperature = 310.0", "temperature = 300.0").replace(
        "temperature = 350.0", "temperature = 300.0"
    )
    # of 1 W
    assert cb.run(loads(scene)).profiles["low heat_tube [W]"] == approx(0.0, abs=1e-12)


def test_a_restart_goes_on_bit_for_bit(tmp_path):
    cb.run(loads(SCENE, {"time.end": 0.006}), out=tmp_path / "part")
    rest = cb.run(loads(SCENE), out=tmp_path / "rest", restart=tmp_path / "part")
    same_run(rest, cb.run(loads(SCENE)))


@each_case(__file__, "tubes_that_cannot_be")
def test_tubes_that_cannot_be(old, new, says):
    assert old in SCENE
    refused(re.escape(says), lambda: loads(SCENE.replace(old, new)))


def test_particles_of_a_file_that_lie_in_a_tube_are_left_out(tmp_path):
    x = np.stack(
        np.meshgrid(
            *[np.arange(1.1e-3, w, 2.05e-3) for w in (23e-3, 5.6e-3, 20e-3)],
            indexing="ij",
        ),
        -1,
    )
    np.savetxt(
        tmp_path / "bed.csv",
        x.reshape(-1, 3),
        delimiter=",",
        header="x,y,z",
        comments="",
    )
    scene = SCENE.replace("count = 150", f'file = "{tmp_path / "bed.csv"}"')
    path = tmp_path / "scene.toml"
    path.write_text(scene)
    done = CliRunner().invoke(app, ["plan", str(path)])
    off = np.hypot(x[..., 0] - 12e-3, x[..., 2] - 7e-3).ravel()
    inside = int((off < 4e-3 + 0.95e-3).sum())
    assert f"{inside} in tubes are left out" in done.output
    done = CliRunner().invoke(app, ["check", str(path)])
    assert done.exit_code == 0, done.output


def test_the_schema_knows_the_law_of_tubes():
    from contbed.explain.closure_keys import closure_keys

    assert closure_keys()["particles.tubes.NAME.nusselt"] == "nusselt_cylinder"
