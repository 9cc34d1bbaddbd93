"""Heat transfer coefficients of particles: exact lattices, impacts, scenes of
particles in a gas, closure, restart.
"""

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from pytest import approx
from typer.testing import CliRunner

import contbed as cb
from contbed.cfd_dem.conduction import Solid
from contbed.cfd_dem.coupling import Bed
from contbed.cfd_dem.gas import Gas
from contbed.cfd_dem.grid import Grid
from contbed.cfd_dem.heat_transfer import Average, bed_nusselt, coefficients
from contbed.cfd_dem.history import History
from contbed.cli import app
from contbed.closures import drag_di_felice, nusselt_power
from contbed.dem import heat_impact
from contbed.dem.heat_pair import correction
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Domain
from contbed.errors import SceneError
from contbed.loading import loads
from contbed.materials.constant import ConstantFluid
from tests.balances import assert_closed
from tests.cases import each_case
from tests.numbers_of import table_of
from tests.restarts import interrupt, same_run

STUDY = Path(__file__).parents[2] / "studies/closure_transfer"
AIR = ConstantFluid(1.2, 1005.0, 1.8e-5, 0.026)
D, STEP = 2e-3, 0.999 * 2e-3
RE, PR = 1.2 * 0.5 * D / 1.8e-5, 1.8e-5 * 1005.0 / 0.026
NU = partial(nusselt_power, a=1.2, b=0.5)

SCENE = """
[particles]
file = "bed.csv"
width = [0.017982, 0.017982]
periodic = true
fixed = true
height = 0.029970
cell = [2.997, 2.997]
gravity = false

[solids.glass]
diameter = "2 mm"
density = 2500.0
conductivity = 30.0

[gas]
density = 1.2
viscosity = 1.8e-5
heat_capacity = 1005.0
conductivity = 0.026

[closures]
nusselt = { name = "power", a = 1.2, b = 0.5 }

[boundary.bottom]
gas.velocity = 0.5

[time]
end = 0.1
sample = 0.05
step = 1e-2
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A simple cubic lattice that fills the box of SCENE, as positions and as a
    dump.
    """
    path = tmp_path_factory.mktemp("beds")
    x = lattice()
    np.savetxt(path / "bed.csv", x, delimiter=",", fmt="%.17g")
    head = (
        f"ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n{len(x)}\nITEM: BOX BOUNDS pp "
        "pp ff\n"
    )
    head += "\n".join(f"0 {n * STEP:.17g}" for n in (9, 9, 15))
    rows = [f"{k} {a:.17g} {b:.17g} {c:.17g} 0.001" for k, (a, b, c) in enumerate(x)]
    (path / "bed.dump").write_text(
        head + "\nITEM: ATOMS id x y z radius\n" + "\n".join(rows) + "\n"
    )
    return path


def lattice():
    return np.stack(
        np.meshgrid(*[(np.arange(n) + 0.5) * STEP for n in (9, 9, 15)], indexing="ij"),
        -1,
    ).reshape(-1, 3)


def test_a_lattice_has_the_coefficients_of_its_contacts():
    domain = Domain((0, 0, 0), (9 * STEP, 9 * STEP, np.inf), (True, True, False))
    simulation = Simulation(
        Particles(lattice(), D / 2), [Material(2500.0, 1e7)], (), domain
    )
    gas = Gas(
        Grid(np.zeros(3), np.full(3, 3 * STEP), (3, 3, 5), (True, True)),
        AIR,
        drag_di_felice,
        NU,
        isothermal=True,
        gravity=(0, 0, 0),
    )
    gas.inlet(0.5, 300.0)
    bed = Bed(simulation, gas, 1e-3, moving=False)
    bed.run(0.1)
    solid = Solid(30.0, modulus=5e10)
    h = coefficients(bed, solid, 0.9, 1000.0)
    # the uppermost spheres reach above the grid by half of their overlap: cells that
    # they are in, and who touches these
    inner = (simulation.position[:, 2] > 2 * STEP) & (
        simulation.position[:, 2] < 11 * STEP
    )
    # six contacts of G = 2 k c sqrt(R* delta), convection at the superficial Reynolds
    # number: exact
    radius = correction(1e7, 5e10) * np.sqrt(D / 4 * (D - STEP))
    assert h["contact"][inner] == approx(
        6 * 2 * 30.0 * radius / (np.pi * D**2), rel=1e-9
    )
    assert h["convection"] == approx(float(NU(Re=RE, Pr=PR)) * 0.026 / D, rel=1e-6)
    assert h["impact"].max() == 0.0
    # all neighbours within 1.5 d at one temperature: 4 sigma e T^3 (1 - eps)
    eps = 1 - np.pi / 6 * (D / STEP) ** 3
    assert h["radiation"][inner] == approx(
        4 * 5.670374419e-8 * 0.9 * 1e9 * (1 - eps), rel=1e-9
    )
    average = Average(solid)
    average(bed)
    average(bed)
    assert average.total == approx(
        sum(h[name] for name in h if name != "radiation"), rel=1e-12
    )
    assert average.Re == approx(RE, rel=1e-6)


def test_a_bed_of_two_sizes_exchanges_what_its_particles_do():
    """With Nu = 2 of each particle, h_i = 2 k/d_i: sum h_i d_i^2 = h sum d_i^2 with
    the length d_32 of Re and Nu.
    """
    d = np.where(np.arange(len(lattice())) % 3 == 0, D, 0.7 * D)
    simulation = Simulation(
        Particles(lattice(), d / 2), [Material(2500.0, 1e7)], (), Domain((0, 0, 0), (9 * STEP, 9 * STEP, np.inf),
        (True, True, False)),
    )  # fmt: skip
    grid = Grid(np.zeros(3), np.full(3, 3 * STEP), (3, 3, 5), (True, True))
    gas = Gas(
        grid,
        AIR,
        drag_di_felice,
        partial(nusselt_power, a=0.0, b=0.5),
        isothermal=True,
        gravity=(0, 0, 0),
    )
    Re, Pr, Nu = bed_nusselt(
        Bed(simulation, gas, 1e-3, moving=False), 0.5, 300.0, Solid(0.0)
    )
    d_32 = (d**3).sum() / (d**2).sum()
    assert Re == approx(1.2 * 0.5 * d_32 / 1.8e-5, rel=1e-12)
    assert Pr == approx(PR, rel=1e-12)
    assert Nu == approx(2.0 * d_32 * d.sum() / (d**2).sum(), rel=1e-12)


def test_a_fresh_contact_conducts_as_an_impact():
    # two spheres meet: while the contact is younger than Hertz's duration Eq. 7 holds,
    # and Eq. 6 does not
    x = np.array([[0.0, 0.0, 0.01], [D * 1.001, 0.0, 0.01]]) + 3 * D
    pair = Particles(x, D / 2, velocity=np.array([[0.05, 0, 0], [-0.05, 0, 0]]))
    glass = Material(2500.0, 1e7, restitution=1.0)
    simulation = Simulation(pair, [glass], (), Domain(), (0, 0, 0), 1e-6)
    gas = Gas(
        Grid(np.zeros(3), np.full(3, 3 * D), (4, 4, 4)),
        AIR,
        drag_di_felice,
        NU,
        isothermal=True,
    )
    bed = Bed(simulation, gas, moving=False)
    gas.start(bed.motion)
    solid = Solid(0.84, 840.0)
    around = bed.gas.around(bed.motion)
    heat, alone = 0.0, True
    for _ in range(400):
        simulation.run(1)
        parts = solid.exchange(simulation, around)[1]
        heat += 1e-6 * parts["impact"].sum()
        alone = alone and not (parts["impact"].any() and parts["contact"].any())
    impact = heat_impact.hertz_impact(
        D / 4, simulation.mass[0] / 2, 1e7 / (2 * (1 - 0.3**2)), 0.1
    )
    wanted = (
        heat_impact.impact_conductance(impact, (0.84, 0.84), (2.1e6, 2.1e6))
        * impact.duration
    )
    # the duration is met to a step of 1e-6 s in 3.2e-4 s
    assert alone and heat == approx(float(wanted), rel=0.01)
    assert float(wanted) == approx(1.865e-7, rel=2e-3)


def test_a_scene_gives_coefficients_and_a_closure_that_scenes_use(folder, tmp_path):
    text = SCENE + "\n[particles.closure]\nvelocities = [0.1, 0.3, 0.6, 1.0]\n"
    result = cb.run(loads(text, base=folder), out=tmp_path / "out")
    assert result.qoi["h_convection [W/m2/K]"] == approx(
        float(NU(Re=RE, Pr=PR)) * 0.026 / D, rel=1e-6
    )
    assert result.qoi["coordination"] == approx(6 - 2 / 15, rel=1e-12)
    assert_closed(result, 1e-12, "gas")
    assert [use["kind"] for use in result.closures] == ["drag", "nusselt"]
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {
        "summary.json",
        "profiles.csv",
        "profiles.png",
        "particles.pvd",
        "particles_0000.vtu",
        "checkpoint.npz",
        "closure.toml",
    }
    assert (
        json.loads((tmp_path / "out/summary.json").read_text())["scene"]["boundary"][
            "bottom"
        ]["gas"]["velocity"]
        == 0.5
    )
    # where every particle sees the same gas the fit is the law that went in
    packed = """
mesh = {{ type = "line", length = 0.1 }}
gas = {{ density = 1.2, viscosity = 1.8e-5, heat_capacity = 1005.0, conductivity = 0.026 }}
solids.glass = {{ diameter = "2 mm", density = 2500.0, heat_capacity = 840.0, conductivity = 0.84 }}
packed_bed.porosity = 0.475
heat = {{}}
closures.nusselt = {}
boundary.left.gas = {{ velocity = 0.5, fixed_temperature = 300.0 }}
boundary.right.solids.glass = {{ velocity = 1e-4, fixed_temperature = 400.0 }}
"""
    with_file = cb.run(
        loads(packed.format('{ file = "closure.toml" }'), base=tmp_path / "out")
    )
    named = cb.run(loads(packed.format('{ name = "power", a = 1.2, b = 0.5 }')))
    assert with_file.qoi["T_fluid_out_K"] == approx(
        named.qoi["T_fluid_out_K"], rel=1e-7
    )


def test_a_dump_of_another_program_gives_the_same(folder):
    plain, dumped = (
        cb.run(loads(text, base=folder)).qoi
        for text in (SCENE, SCENE.replace("bed.csv", "bed.dump"))
    )
    for name in ("h_total [W/m2/K]", "h_contact [W/m2/K]", "pressure_drop [Pa]"):
        assert dumped[name] == approx(plain[name], rel=1e-9)


STIRRED = """
particles = { count = 200, width = ["12 mm", "12 mm"], height = "60 mm", modulus = "1 MPa", seed = 3 }
solids.glass = { diameter = "2 mm", density = 2500, conductivity = 0.84, youngs_modulus = "50 GPa", restitution = 0.5 }
gas = { composition = "N2:0.79, O2:0.21" }
closures.nusselt = "gunn"
boundary.bottom.gas = { velocity = 1.0, temperature = 400.0 }
boundary.jet = { start = 0.004, end = 0.008, until = 0.012, gas = { mass_flux = 4.0, temperature = 600.0 } }
heat = {}
initial.solids.glass.temperature = 300.0
time = { end = 0.04, average_from = 0.01, sample = 0.01 }
output = { plots = false, fields = false }
"""


def test_an_interrupted_scene_continues_bit_for_bit(tmp_path):
    scene = loads(STIRRED)
    whole = cb.run(scene)
    assert_closed(whole, 1e-10, "energy")
    assert whole.qoi["T_fluid_max_K"] < 600.0
    interrupt(scene, tmp_path, History, "record", 4)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["status"] == "interrupted"
    same_run(cb.run(scene, restart=tmp_path), whole)


@pytest.mark.parametrize("k, warns", [(2.0, False), (0.1, True)])
def test_particles_that_conduct_badly_are_a_warning(k, warns):
    """R/(5 k) beside 1/h, which a sphere has that cools slowly."""
    result = cb.run(
        loads(STIRRED.replace("conductivity = 0.84", f"conductivity = {k}"))
    )
    said = [text for text in result.warnings if "each particle has one temp" in text]
    assert bool(said) is warns
    if warns:
        share = result.qoi["h_convection [W/m2/K]"] * D / 2.0 / (5.0 * k)
        assert f"up to {100.0 * share:.0f} % too large" in said[0]


@each_case(__file__, "mistakes_are_named_with_their_line")
def test_mistakes_are_named_with_their_line(folder, old, new, wanted):
    with pytest.raises(SceneError) as error:
        cb.run(loads(SCENE.replace(old, new, 1), "scene.toml", base=folder))
    assert any(wanted in problem for problem in error.value.problems), (
        error.value.problems
    )


def test_what_is_seldom_meant_is_a_warning(folder, tmp_path):
    doubtful = SCENE.replace(
        "density = 2500.0", "density = 2500.0\npoisson_ratio = -0.1"
    ).replace("[2.997", "[12.0")
    scene = loads(doubtful, "scene.toml", base=folder)
    for told in (
        "solids.glass.poisson_ratio = -0.1: is negative",
        "particles.cell[0] = 12.0: 0.024 m in x, the bed is 0.018 m",
    ):
        assert any(
            text.startswith("scene.toml:") and told in text for text in scene.warnings
        ), scene.warnings
    assert set(scene.warnings) <= set(cb.run(scene).warnings)
    (tmp_path / "scene.toml").write_text(
        doubtful.replace("bed.csv", str(folder / "bed.csv"))
    )
    shown = CliRunner().invoke(app, ["check", str(tmp_path / "scene.toml")]).output
    assert (
        "warning: " in shown
        and "poisson_ratio = -0.1" in shown
        and shown.endswith("scene.toml: ok, with warnings\n")
    )


def test_the_check_refuses_particles_that_the_run_refuses(folder):
    (folder / "close.csv").write_text("0.004,0.004,0.004\n0.0045,0.004,0.004\n")
    for old, new, wanted in (
        ('"bed.csv"', '"close.csv"', "particles 0 and 1 overlap by"),
        ("height = 0.029970", "height = 0.02", "particles.height: centres from"),
        ('"bed.csv"', '"empty.dump"', "empty.dump:4: step 7 has no particles"),
    ):
        text = (folder / "bed.dump").read_text()
        (folder / "empty.dump").write_text(
            text[: text.index("ITEM: NUMBER")]
            + "ITEM: NUMBER OF ATOMS\n0\n"
            + text[text.index("ITEM: BOX") : text.index("radius\n") + 7]
        )
        with pytest.raises(SceneError) as error:
            loads(SCENE.replace(old, new, 1), "scene.toml", base=folder)
        assert any(wanted in problem for problem in error.value.problems), (
            error.value.problems
        )


def test_the_study_of_transfer_to_a_moving_bed():
    # both committed closure files give the committed outlet temperature, inside of
    # their ranges
    result = cb.run(cb.load(STUDY / "moving_bed.toml"))
    rows = {
        (row["scene"], row["closures"]): float(row["T_out [K]"])
        for row in table_of(STUDY / "outlet_both.csv")
    }
    assert result.qoi["T_fluid_out_K"] == approx(
        rows["moving_bed", "packings"], abs=2e-3
    )
    assert all(use["share_outside"] == 0 for use in result.closures)
