"""Conduction inside of the particles of a bed against exact breakthroughs and steady
moving beds.
"""

from __future__ import annotations

from itertools import groupby

import numpy as np
import pytest
from pytest import approx

from contbed.loading import load
from contbed.models import plan
from contbed.particle import uptake
from contbed.plan_text import percent
from contbed.runner import run
from tests.balances import assert_closed
from tests.particle.tables import rows
from tests.refusals import refused

EPS, D, LENGTH, FILM, SOLID = 0.4, 0.01, 1.0, 100.0, 1e6  # -, m, m, W/m2/K, J/m3/K
AREA = 6 * (1 - EPS) / D


def bed(folder, *, Bi, xi, hold=1e-6, inside="", more="", cells=200, axial=0.0):
    """Bed of spheres with h a L/(G c) = xi and gas that holds `hold` of the heat of
    the solids, as TOML.
    """
    carried = FILM * AREA * LENGTH / xi
    content = hold * (1 - EPS) * SOLID / EPS
    text = f"""
mesh = {{ type = "line", length = {LENGTH}, cells = {cells} }}
{more.replace("VELOCITY", repr(carried / content))}
[gas]
density = {content / 1000!r}
heat_capacity = 1000.0
conductivity = 1.0
viscosity = 1e-5
[packed_bed]
porosity = {EPS}
[solids.particles]
density = 1000.0
heat_capacity = {SOLID / 1000!r}
conductivity = {FILM * D / 2 / Bi!r}
diameter = {D}
{inside}
[closures]
nusselt = {FILM * D!r}
conductivity_gas = {axial * carried!r}
conductivity_solids = 0.0
[heat]
"""
    path = folder / "bed.toml"
    path.write_text(text, encoding="utf-8")
    return path


def step(etas, tolerance=1e-5, shift=0.0):
    """Tables of a run with a step at the inlet and output at h a t/C_solid = etas."""
    times = [eta * (1 - EPS) * SOLID / (FILM * AREA) + shift for eta in etas]
    return f"""
boundary.left.gas = {{ velocity = VELOCITY, temperature = 400.0 }}
initial.temperature = 300.0
time.end = {max(times)!r}
time.times = {times!r}
time.tolerance = {tolerance}
"""


def at_the_outlet(result, name):
    """Theta at the last position at each output time."""
    times = result.profiles["t [s]"]
    return [
        (result.profiles[f"{name} [K]"][times == t][-1] - 300.0) / 100.0
        for t in np.unique(times)
    ]


BREAKTHROUGHS = [
    (k, list(g))
    for k, g in groupby(rows("breakthrough_spheres.csv"), lambda r: (r["Bi"], r["xi"]))
]
FAST = {(10, 50)}


@pytest.mark.parametrize(
    ("numbers", "group"),
    [
        pytest.param(
            k,
            g,
            marks=() if k in FAST else pytest.mark.slow,
            id=f"Bi {k[0]}, xi {k[1]}",
        )
        for k, g in BREAKTHROUGHS
    ],
)
def test_breakthrough(tmp_path, numbers, group):
    Bi, xi = numbers
    inside = 'inside = { heat = "interior", points = 4 }'
    found = run(
        load(
            bed(
                tmp_path,
                Bi=Bi,
                xi=xi,
                inside=inside,
                more=step([r["eta"] for r in group], 5e-6),
            )
        )
    )
    # time steps of a local error of 5e-6 and 200 cells; four points inside err by up to
    # 2e-4 where Bi = 10, xi = 5
    error = 3e-4 if Bi == 10 and xi < 20 else 1e-4
    assert at_the_outlet(found, "T_fluid") == approx(
        [r["theta_gas"] for r in group], abs=error
    )
    assert at_the_outlet(found, "T_solid") == approx(
        [r["theta_solid_mean"] for r in group], abs=error
    )
    assert_closed(found, 1e-11, "energy")


@pytest.mark.parametrize(
    "row",
    [
        r
        for r in rows("breakthrough_spheres.csv")
        if r["Bi"] == 1 and r["xi"] == 20 and r["eta"] == 16
    ],
)
def test_corrected_film_errs_as_predicted(tmp_path, row):
    inside, hold = 'inside = { heat = "effective" }', 0.01
    # the table counts the time from the moment when the gas arrives
    shift = 20 * hold * (1 - EPS) * SOLID / (FILM * AREA)
    path = bed(
        tmp_path,
        Bi=1,
        xi=20,
        hold=hold,
        inside=inside,
        more=step([row["eta"]], shift=shift),
        cells=400,
    )
    found = run(load(path))
    (theta,) = at_the_outlet(found, "T_fluid")
    # the digits of the table
    assert theta == approx(row["theta_gas"] + row["ldf_error"], abs=1e-6)


@pytest.mark.parametrize(
    "case",
    [
        0,
        pytest.param(1, marks=pytest.mark.slow),
        pytest.param(2, marks=pytest.mark.slow),
    ],
)
def test_breakthrough_with_dispersion_and_hold_up(tmp_path, case):
    group = rows("breakthrough_dispersed.csv")[5 * case : 5 * case + 5]
    first = group[0]
    # the table's time counts from the step, with the gas in the bed
    found = run(
        load(
            bed(
                tmp_path,
                Bi=first["Bi"],
                xi=first["xi"],
                hold=first["hold"],
                axial=1 / first["Pe"],
                inside='inside = { heat = "interior", points = 5 }',
                more=step([r["t"] for r in group]),
            )
        )
    )
    # of 1e-5 per time step
    assert at_the_outlet(found, "T_fluid") == approx(
        [r["theta_out"] for r in group], abs=1e-4
    )


@pytest.mark.parametrize("row", rows("moving_bed_spheres.csv"))
def test_steady_moving_bed(tmp_path, row):
    along, Bi = row["Gamma"] > 0, row["Bi"]
    alpha = FILM * D / 2 / Bi / SOLID
    speed = alpha * LENGTH * (1 - EPS) / (row["Fo"] * (D / 2) ** 2)
    carried = SOLID * speed / abs(row["Gamma"])  # heat capacity flow of the gas
    xi = FILM * AREA * LENGTH / carried
    more = f"""
boundary.{"left" if along else "right"}.gas = {{ velocity = VELOCITY, temperature = 400.0 }}
boundary.left.solids.particles = {{ velocity = {speed!r}, temperature = 300.0 }}
"""
    path = bed(
        tmp_path,
        Bi=Bi,
        xi=xi,
        inside='inside = { heat = "interior", points = 6 }',
        more=more,
        cells=400,
    )
    found = run(load(path))
    # six points inside for a stay as short as Fo = 0.3, 400 cells
    assert (found.qoi["T_fluid_out_K"] - 300) / 100 == approx(row["gas_out"], abs=2e-5)
    assert (found.qoi["T_solid_out_K"] - 300) / 100 == approx(
        row["solid_out_mean"], abs=2e-5
    )
    assert found.profiles["T_surface [K]"].shape == found.profiles["T_solid [K]"].shape
    corrected = run(
        load(
            bed(
                tmp_path,
                Bi=Bi,
                xi=xi,
                inside='inside = { heat = "effective" }',
                more=more,
                cells=400,
            )
        )
    )
    assert (
        corrected.qoi["T_fluid_out_K"] - found.qoi["T_fluid_out_K"]
    ) / 100 == approx(row["ldf_error_gas"], abs=4e-5)


def inside_line(found):
    """What a plan says about intraparticle conduction."""
    (line,) = [
        text
        for name, text in (*found.built, *found.skipped)
        if name == "intraparticle conduction"
    ]
    return line


@pytest.mark.parametrize(
    ("Bi", "level"),
    [(0.05, "corrected"), (0.5, "corrected"), (15.0, "2 intraparticle temperatures")],
)
def test_plan_takes_the_cheapest_level_within_the_accuracy(tmp_path, Bi, level):
    found = plan(
        load(bed(tmp_path, Bi=Bi, xi=20, inside="inside = {}", more=step([20.0])))
    )
    line = inside_line(found)
    assert level in line and f"Bi = {Bi:.3g}" in line
    for name in ("lumped", "effective"):
        error = uptake.breakthrough_error(20, Bi, name, last=1.0)
        assert percent(error) in line


def test_accuracy_decides_how_many_points(tmp_path):
    path = bed(tmp_path, Bi=15.0, xi=20, inside="inside = {}", more=step([20.0]))
    chosen = [
        plan(load(path, {"solver.accuracy": each})).solved.solid.inside
        for each in (0.1, 1e-2, 1e-4, 1e-6)
    ]
    assert [each.heat for each in chosen] == [
        "effective",
        "interior",
        "interior",
        "interior",
    ]
    assert [each.points for each in chosen[1:]] == [2, 3, 6]
    # two temperatures and six inside at 401 nodes of 200 cells of degree 2
    assert plan(load(path, {"solver.accuracy": 1e-6})).unknowns()["heat"] == 8 * 401


@pytest.mark.parametrize("level", ["lumped", "effective", "interior"])
def test_a_stated_level_is_kept_and_its_error_told(tmp_path, level):
    inside = f'inside = {{ heat = "{level}" }}'
    found = plan(
        load(
            bed(tmp_path, Bi=30.0, xi=20, inside=inside, more=step([20.0])),
            {"solver.accuracy": 1e-6},
        )
    )
    assert found.solved.solid.inside.heat == level
    line = inside_line(found)
    error = uptake.breakthrough_error(
        20, 30.0, 3 if level == "interior" else level, last=1.0
    )
    assert f"{percent(error)}, above solver.accuracy = 0.0001 %" in line


def test_stated_points_are_kept(tmp_path):
    path = bed(
        tmp_path, Bi=30.0, xi=20, inside="inside = { points = 5 }", more=step([20.0])
    )
    chosen = plan(load(path)).solved.solid.inside
    assert (chosen.heat, chosen.points) == ("interior", 5)


def test_a_moving_bed_is_judged_by_its_stay_and_the_heat_its_solids_take(tmp_path):
    more = """
boundary.right.gas = { velocity = VELOCITY, temperature = 400.0 }
boundary.left.solids.particles = { velocity = SPEED, temperature = 300.0 }
"""
    alpha = FILM * D / 2 / 5.0 / SOLID
    for fourier, level in (
        (0.02, "intraparticle temperatures"),
        (0.2, "intraparticle temperatures"),
        (2.0, "corrected"),
    ):
        speed = alpha * LENGTH * (1 - EPS) / (fourier * (D / 2) ** 2)
        gamma = 0.9
        text = more.replace("SPEED", repr(speed))
        units = gamma * 15.0 * fourier  # h a L/(G c) = s Gamma Bi Fo
        line = inside_line(
            plan(load(bed(tmp_path, Bi=5.0, xi=units, inside="inside = {}", more=text)))
        )
        assert level in line and f"Fo = {fourier:g}" in line
        assert (
            percent(uptake.moving_bed_error(-gamma, 5.0, fourier, "effective")) in line
        )


def test_without_the_table_particles_are_uniform_and_the_plan_tells_the_error(tmp_path):
    found = plan(load(bed(tmp_path, Bi=2.0, xi=20, more=step([20.0]))))
    assert (
        "no table solids.NAME.inside" in dict(found.skipped)["intraparticle conduction"]
    )
    assert (
        "T_inside_1" not in str(found.unknowns()) and found.solved.solid.inside is None
    )


def test_condensed_steps_are_those_of_the_whole_system(tmp_path, monkeypatch):
    from contbed.packed_bed.heat import HeatProblem

    text = step([5.0, 10.0], 1e-3)
    path = bed(
        tmp_path,
        Bi=5.0,
        xi=10,
        cells=20,
        inside='inside = { heat = "interior" }',
        more=text,
    )
    condensed = run(load(path))
    monkeypatch.setattr(HeatProblem, "nodal_modes", None)
    whole = run(load(path))
    assert whole.qoi["time_steps"] == condensed.qoi["time_steps"]
    for name in ("T_fluid [K]", "T_solid [K]", "T_surface [K]", "T_centre [K]"):
        # rounding, in K
        assert condensed.profiles[name] == approx(whole.profiles[name], abs=1e-8)


def test_properties_that_vary_keep_the_balance(tmp_path):
    path = bed(
        tmp_path,
        Bi=5.0,
        xi=10,
        cells=8,
        inside='inside = { heat = "interior" }',
        more=step([8.0], 1e-2),
    )
    header = "[solids.particles]"
    before, solid = path.read_text().split(header)
    text = (
        before
        + header
        + solid.replace(
            f"heat_capacity = {SOLID / 1000!r}", "heat_capacity = [700.0, 1.0]"
        )
    )
    path.write_text(text)
    found = run(load(path))
    assert_closed(found, 1e-10, "energy")
    inner, outer = found.profiles["T_centre [K]"], found.profiles["T_surface [K]"]
    assert (
        np.all(inner < outer + 1e-6)
        and inner.min() < found.profiles["T_solid [K]"].min() + 1e-9
    )


@pytest.mark.parametrize("what", ["radiation", "no heat"])
def test_scenes_without_an_inside(tmp_path, what):
    path = bed(
        tmp_path,
        Bi=5.0,
        xi=10,
        inside='inside = { heat = "interior" }',
        more=step([8.0]),
    )
    text = path.read_text()
    if what == "radiation":
        text += '\n[radiation]\nlevel = "p1"\n'
    else:
        text = text.split("[heat]")[0]
    path.write_text(text)
    refused("inside", load, path)


@pytest.mark.slow
def test_restart_goes_on_with_the_inside(tmp_path):
    path = bed(
        tmp_path,
        Bi=5.0,
        xi=10,
        cells=20,
        inside='inside = { heat = "interior" }',
        more=step([8.0], 1e-3),
    )
    once, folder = run(load(path)), tmp_path / "out"
    end = float(once.qoi["time_reached_s"])
    run(load(path, {"time.end": 0.5 * end, "time.times": []}), out=folder)
    again = run(load(path), out=folder, restart=folder)
    last = once.profiles["t [s]"] == once.profiles["t [s]"].max()
    for name in ("T_solid [K]", "T_centre [K]"):
        now = again.profiles[name][
            again.profiles["t [s]"] == again.profiles["t [s]"].max()
        ]
        # the steps differ from those of one run, within the tolerance of 0.1 K per step
        assert now == approx(once.profiles[name][last], abs=0.2)


def test_solids_that_move_carry_their_inside(tmp_path):
    alpha = FILM * D / 2 / 5.0 / SOLID
    speed = alpha * LENGTH * (1 - EPS) / (0.5 * (D / 2) ** 2)
    more = f"""
boundary.right.gas = {{ velocity = VELOCITY, temperature = 400.0 }}
boundary.left.solids.particles = {{ velocity = {speed!r}, temperature = 300.0 }}
"""
    inside = 'inside = { heat = "interior" }'
    steady = run(load(bed(tmp_path, Bi=5.0, xi=5, inside=inside, more=more, cells=40)))
    passage = LENGTH * (1 - EPS) / speed
    late = (
        f"{more}time = {{ end = {20 * passage!r}, tolerance = 1e-3 }}\n"
        "initial.temperature = 300.0\n"
    )
    transient = run(
        load(bed(tmp_path, Bi=5.0, xi=5, inside=inside, more=late, cells=40))
    )
    assert transient.qoi["T_solid_out_K"] == approx(
        steady.qoi["T_solid_out_K"], abs=0.05
    )
    assert_closed(transient, 1e-10, "energy")
