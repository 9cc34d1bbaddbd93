"""Transient reacting beds that are stopped: a restart gives the numbers of an
uninterrupted run bit for bit.
"""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from adsorption_scenes import adsorber
from pytest import approx
from reacting_bed_scenes import N_SOLID, danckwerts, fixed_bed, isothermal
from scipy.integrate import trapezoid
from several_solids import split, split_pellets

import contbed
from contbed.loading import from_dict
from contbed.reacting_bed import transient_run
from contbed.reacting_bed.time_steps import BedSteps
from tests.restarts import interrupt, same_run
from tests.scene_text import scene_of, set_keys

STOP = BedSteps, "_passed", 21  # steps, of about 70


def scene(**more):
    given = fixed_bed("bohart_adams", 0.0, 0.0, 0.0, 2.0, 0.8)
    given["boundary"]["left"]["gas"]["composition"] = {
        "times": [0, 300],
        "values": ["A:1", "A:0.5, B:0.5"],
        "form": "step",
    }
    given["mesh"]["cells"] = 20
    given["time"] = {"end": 800.0, "times": [50.0, 300.0, 600.0]} | more
    return given


def heated_section():
    """A bed of three rings that a wall heats; A -> B."""
    gas = {
        "elements": {"H": 28.0},
        "molar_mass": 0.028,
        "heat_capacity": 30.0,
        "enthalpy": 0.0,
    }
    given = isothermal("A:1", {"A": gas, "B": gas}) | {"heat": {}}
    set_keys(
        given,
        """
        solids.particles.density = 2000.0
        solids.particles.heat_capacity = 1000.0
        reactions = { r = { equation = "A -> B", A = 400.0, E = 3e4 } }
        mesh.cells = 4
        mesh.diameter = 0.1
        boundary.wall = { coefficient = 50.0, ambient = 800.0 }
        packed_bed.section = { rings = 3, conductivity_solids = 2.0 }
        time = { end = 300.0, times = [50.0] }
        """,
    )
    return given


def test_restart_goes_on_bit_for_bit(tmp_path):
    given, later = from_dict(scene()), from_dict(scene(end=1000.0))
    whole = contbed.run(given)
    interrupt(given, tmp_path / "a", *STOP)
    same_run(contbed.run(given, out=tmp_path / "b", restart=tmp_path / "a"), whole)
    # of a finished run nothing changes, and a later end is taken
    same_run(contbed.run(given, out=tmp_path / "c", restart=tmp_path / "b"), whole)
    longer = contbed.run(later, out=tmp_path / "d", restart=tmp_path / "b")
    same_run(longer, contbed.run(later))


def adsorbing_section():
    """Two rings whose particles take up gas, with points inside of them."""
    given, unit = adsorber(100.0, 10.0, 3.0, 2.0)
    for gas in given["gas"]["species"].values():
        gas |= {"heat_capacity": 30.0, "enthalpy": 0.0}
    set_keys(
        given,
        """
        mesh.cells = 3
        solids.particles.heat_capacity = 1000.0
        solids.particles.inside = { adsorption = "interior", points = 2 }
        """,
    )
    given["time"] |= {"end": 3.0 * unit, "tolerance": 1e-3}
    set_keys(
        given,
        """
        mesh.diameter = 0.1
        boundary.wall = { coefficient = 50.0, ambient = 400.0 }
        packed_bed.section = { rings = 2, conductivity_solids = 2.0 }
        """,
    )
    return given | {"heat": {}}


def section_of_pellets():
    """Two rings of pellets inside of which A becomes B."""
    given = heated_section()
    set_keys(
        given,
        """
        reactions.r.A = 5e6
        reactions.r.E = 6e4
        reactions.r.basis = "particle"
        packed_bed.section.rings = 2
        solids.particles.inside = { mass = "interior", diffusivity = { A = 2e-6, B = 2e-6 } }
        time = { end = 300.0, times = [50.0], tolerance = 1e-3 }
        """,
    )
    return given


def kinds_that_adsorb():
    """Two kinds of particles with points inside that take up a gas whose share
    falls.
    """
    given, unit = adsorber(100.0, 10.0, 3.0)
    set_keys(given, "mesh.cells = 4")
    values = ["A:1e-6, N:0.999999", "A:5e-7, N:0.9999995"]
    given["boundary"]["left"]["gas"]["composition"] = {
        "times": [0, 3.0 * unit],
        "values": values,
        "form": "linear",
    }
    set_keys(
        given,
        """
        solids.particles.inside = { adsorption = "interior", points = 2 }
        """,
    )
    given["time"] |= {"end": 3.0 * unit, "tolerance": 1e-3}
    return split(given)


def kinds_of_pellets():
    """Pellets of two sizes inside of which A becomes B."""
    given = section_of_pellets()
    del given["packed_bed"]["section"]
    set_keys(given, "time.end = 200.0")
    return split_pellets(given, coarse={"diameter": 5e-3})


def gas_that_is_damped():
    """A front of a gas in the pores, on cells that do not resolve it."""
    given = danckwerts(1000.0, 0.0)
    set_keys(given, "mesh.cells = 6")
    return given | {
        "initial": {"gas": {"composition": "B:1"}},
        "time": {"end": 1.6, "tolerance": 1e-3},
    }


def cores_that_are_damped():
    """Cores of 0.2 mm at rest, whose rate takes what is left of them."""
    given = fixed_bed("bohart_adams", 0.0, 0.0, 0.0, 2.0, 1.5)
    given["reactions"]["r"] |= {
        "orders": {"A": 1.0},
        "A": given["reactions"]["r"]["A"] * N_SOLID,
    }
    set_keys(given, "mesh.cells = 20")
    return given


BEDS = {
    "damped": gas_that_is_damped(),
    "limited": cores_that_are_damped(),
    "adsorbing section": adsorbing_section(),
    "kinds that adsorb": kinds_that_adsorb(),
    "kinds of pellets": kinds_of_pellets(),
}


@pytest.mark.parametrize("given", BEDS.values(), ids=BEDS)
def test_restart_of_beds_goes_on_bit_for_bit(tmp_path, given):
    given = from_dict(given)
    whole = contbed.run(given)
    interrupt(given, tmp_path / "a", *STOP)
    same_run(contbed.run(given, out=tmp_path / "b", restart=tmp_path / "a"), whole)


PULSE = """
mesh = { type = "line", length = 0.3, cells = 20 }
packed_bed = { porosity = 0.4, pressure_drop = "none" }
closures.sherwood = 1e5
boundary.left.gas = { velocity = 0.05, temperature = 300.0 }
initial.gas.composition = "He:1"
time.end = 4e4
[gas]
model = "ideal_gas"
composition = "He:1"
pressure = "1 bar"
viscosity = 2e-5
species = { He = {}, N2 = {} }
[solids.sieve]
diameter = 2e-3
density = 1000.0
adsorption.N2 = { henry = 1.60363e-5, diffusivity = 1.33333e-6, temperature = 300 }
inside.adsorption = "linear_driving_force"
"""


def test_short_steps_behind_a_jump_are_no_creeping_front():
    """The first moments of a pulse, by hand: t_0/2 + L/u (eps + (1 - eps) H), and t_0^2/12
    + 2 L/u (1 - eps) H/k with H = 40, k = 0.5/s; cells of one value made it 1.9 times as
    wide. Errors of the steps and of the sums.
    """
    given = scene_of(PULSE)
    pulse = {
        "times": [0, 20],
        "values": ["N2:0.0005, He:0.9995", "He:1"],
        "form": "step",
    }
    given["boundary"]["left"]["gas"]["composition"] = pulse
    found = contbed.run(from_dict(given))
    t, x = (found.tables["outlet"][name] for name in ("t [s]", "x_N2 [1]"))
    amount = trapezoid(x, t)
    mean = trapezoid(t * x, t) / amount
    variance = trapezoid((t - mean) ** 2 * x, t) / amount
    stays = 0.3 / 0.05
    assert mean == approx(10.0 + stays * (0.4 + 0.6 * 40.0), rel=2e-3)
    assert variance == approx(400.0 / 12.0 + 2.0 * stays * 0.6 * 40.0 / 0.5, rel=1e-2)
    assert not any("began again" in text for text in found.warnings)


@pytest.fixture
def creeping(monkeypatch):
    """Let runs by polynomials creep after ten steps."""
    for name, value in {
        "JUDGED": 5,
        "DAMPED": -1.0,
        "TOO_MANY": 0,
        "GROWTH": float("inf"),
        "HUNDREDS": 2,
    }.items():
        monkeypatch.setattr(transient_run, name, value)


def test_a_run_that_creeps_begins_again_with_one_value_a_cell(creeping, tmp_path):
    """It is the run of solver.degree = 0 then, also when it is stopped and resumed."""
    given = from_dict(scene())
    found = contbed.run(given)
    flat = scene()
    set_keys(flat, "solver.degree = 0")
    by_hand = contbed.run(from_dict(flat))
    assert found.qoi == by_hand.qoi
    assert "began again with one value a cell" in found.warnings[-1]
    assert "as axial dispersion by particles of" in found.warnings[-1]
    assert not any("began again" in text for text in by_hand.warnings)
    owner, name, _ = STOP
    interrupt(given, tmp_path / "a", owner, name, 40)
    same_run(contbed.run(given, out=tmp_path / "b", restart=tmp_path / "a"), found)


def test_the_progress_says_how_to_take_fewer_steps():
    """100 steps for 1 of 100 s leave 9900."""
    before, now = (SimpleNamespace(steps=100 * k, time=float(k)) for k in (0, 1))
    solver = SimpleNamespace(degree=None)
    course = SimpleNamespace(
        time=SimpleNamespace(end=100.0),
        scene=SimpleNamespace(solver=solver),
        problem=SimpleNamespace(line=SimpleNamespace(degree=2)),
    )
    said = "some 1e+04 steps are left; solver.degree = 0 takes fewer for fronts"
    assert transient_run._note(course, before, now) == said
    course.time.end = 50.0
    assert transient_run._note(course, before, now) == ""
    course.time.end, solver.degree = 100.0, 2
    assert transient_run._note(course, before, now) == ""
