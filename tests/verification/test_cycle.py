"""Cyclic steady states against regenerators, and losses of a bed at rest against
their series.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from pytest import approx

from contbed.course.described import described_steps
from contbed.course.schedule import Schedule
from contbed.loading import load
from contbed.models import plan
from contbed.output.progress import Progress
from contbed.packed_bed.time_steps import HeatSteps
from contbed.runner import run
from contbed.solvers.anderson import Anderson
from tests.balances import assert_closed
from tests.particle.tables import rows
from tests.refusals import refused
from tests.restarts import interrupt, same_run

EPS, D, FILM, SOLID = 0.4, 0.01, 100.0, 1e6  # -, m, W/m2/K, J/m3/K
AREA, CONTENT = 6 * (1 - EPS) / D, (1 - EPS) * SOLID
HOLD_UP = 1e-6  # heat held by the gas over that of the solid; the tables have none


def regenerator(path, hot, cold, tolerance=1e-4, cells=60, cycle="{}"):
    """Bed of 1 m with one blow from either end; `hot` and `cold` are (reduced
    length, reduced period).
    """
    rho = HOLD_UP * CONTENT / EPS
    speeds = [FILM * AREA / length / rho for length, _ in (hot, cold)]
    times = [period * CONTENT / (FILM * AREA) for _, period in (hot, cold)]
    path.write_text(f"""
mesh = {{ type = "line", length = 1.0, cells = {cells} }}
boundary.left.gas.velocity = {{ times = [0, {times[0]!r}], values = [{speeds[0]!r}, {-speeds[1]!r}] }}
boundary.left.gas.temperature = 400.0
boundary.right.gas.temperature = 300.0
initial.gas.temperature = 350.0
initial.solids.particles.temperature = 350.0
time.end = {sum(times)!r}
time.tolerance = {tolerance}
time.cycle = {cycle}
gas = {{ density = {rho / 1000!r}, heat_capacity = 1000.0, conductivity = 1.0, viscosity = 1e-5 }}
solids.particles.density = 1000.0
solids.particles.heat_capacity = {SOLID / 1000!r}
solids.particles.conductivity = 1.0
solids.particles.diameter = {D}
packed_bed.porosity = {EPS}
closures = {{ nusselt = {FILM * D!r}, conductivity_gas = 0.0, conductivity_solids = 0.0 }}
heat = {{}}
""")
    return path


NAMES = ("Lambda_hot", "Pi_hot", "Lambda_cold", "Pi_cold")
CASES = [(tuple(row[name] for name in NAMES), row) for row in rows("regenerator.csv")]
FAST = {(30, 20, 30, 25)}


@pytest.mark.parametrize(
    ("numbers", "row"),
    [
        pytest.param(
            *case, marks=() if case[0] in FAST else pytest.mark.slow, id=str(case[0])
        )
        for case in CASES
    ],
)
def test_regenerator(tmp_path, numbers, row):
    found = run(load(regenerator(tmp_path / "s.toml", numbers[:2], numbers[2:])))
    # of time steps with a local error of 1e-4
    assert found.qoi["effectiveness_charge"] == approx(
        row["effectiveness_hot"], abs=2e-4
    )
    # heat above that of the cold gas, which enters with the hot gas alone
    entered = 100.0 * CONTENT * row["Pi_hot"] / row["Lambda_hot"]
    assert found.balances["energy"]["in"] == approx(entered, rel=1e-6)
    assert found.qoi["effectiveness_discharge"] == approx(
        row["effectiveness_cold"], abs=2e-4
    )
    # 1e-8 of 100 K over the period, and so for the heat
    assert found.qoi["cycle_change_K"] <= 1e-6
    assert found.qoi["storage_efficiency"] == approx(1.0, abs=1e-6)
    # repetition takes 250 periods to 1e-8 for (20, 2), and thousands for (50, 0.1)
    assert found.qoi["cycle_periods"] <= (60 if min(numbers[1::2]) < 0.5 else 40)
    assert_closed(found, 1e-11, "energy")


def test_the_plan_says_what_is_known_of_the_steps_and_the_bar_shows_the_period(
    tmp_path, monkeypatch
):
    """A period has a jump within and its end: 2 steps at least. Steps of 0.3 h in
    1.5 h, with outputs at 0.5 h and 1 h: 2 + 2 + 2.
    """
    path = regenerator(tmp_path / "s.toml", (5, 3), (5, 3), 1e-3, cells=10)
    steps = dict(plan(load(path)).built)["steps"]
    assert "time.tolerance = 0.001 need" in steps and "at least 2, to meet" in steps
    assert steps.endswith("up to 60 periods")
    fixed = SimpleNamespace(end=5400.0, times=(1800.0, 3600.0), step=1080.0, cycle=None)
    assert described_steps(fixed, Schedule({})) == "about 6 of 1080 s"
    notes = []
    monkeypatch.setattr(
        Progress, "advance_to", lambda self, value, note="": notes.append(note)
    )
    found = run(load(path), quiet=False)
    shown = list(dict.fromkeys(notes))
    assert shown[0] == "period 1" and shown[1].startswith("period 2 (the last changed")
    last = f"period {found.qoi['cycle_periods']} (the last changed by"
    shown = [note for note in shown if note.startswith(last)]
    assert len(shown) == 1 and shown[0].endswith("allowed are 1e-08)")


@pytest.mark.slow
def test_the_end_of_the_period_is_its_start(tmp_path):
    path = regenerator(tmp_path / "s.toml", (10, 3), (10, 3), 1e-3, cells=20)
    path.write_text(path.read_text() + "\nsolids.particles.inside.heat = 'interior'\n")
    found = run(load(path))
    assert found.qoi["cycle_change_K"] <= 1e-6 and found.qoi[
        "storage_efficiency"
    ] == approx(1.0, abs=1e-6)


def counted(*arguments, **settings):
    """A run, and how many steps it passed."""
    passed, steps = HeatSteps.passed, []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            HeatSteps, "passed", lambda *given: steps.append(1) or passed(*given)
        )
        return run(*arguments, **settings), len(steps)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The scene of a cycle, its folder, its result, and how many steps it passed."""
    folder = tmp_path_factory.mktemp("whole")
    path = regenerator(folder / "s.toml", (10, 3), (10, 3), 1e-3, cells=20)
    return path, folder, *counted(load(path), out=folder)


@pytest.mark.parametrize("moment", [40, 333, 505])
def test_an_interrupted_cycle_resumes_bit_for_bit(tmp_path, whole, moment):
    """Ctrl-C at a step of the first periods, and of one that repeats steps."""
    path, _, expected, taken = whole
    interrupt(load(path), tmp_path, HeatSteps, "passed", moment)
    again, rest = counted(load(path), out=tmp_path, restart=tmp_path)
    same_run(again, expected)
    # of what was done before at most one period is repeated
    assert rest < taken - moment + expected.qoi["time_steps"]


def test_a_cycle_that_was_found_is_told_at_another_time(tmp_path, whole):
    path, folder, *_ = whole
    half = load(path).time.end / 2.0
    other = tmp_path / "s.toml"
    other.write_text(
        f"time.times = [{half!r}]\noutput.positions = [0.5]\n{path.read_text()}"
    )
    both = run(load(other), out=tmp_path, restart=folder)
    wanted = run(load(other)).profiles["T_solid [K]"]
    np.testing.assert_array_equal(both.profiles["T_solid [K]"], wanted)
    assert len(wanted) == 2


def test_anderson_solves_a_linear_problem_in_as_many_steps_as_it_has_unknowns():
    rng = np.random.default_rng(1)
    matrix = np.diag(np.linspace(0.1, 0.995, 6)) + 0.01 * rng.standard_normal((6, 6))
    shift, state, accelerate = rng.standard_normal(6), np.zeros(6), Anderson()
    for _ in range(8):
        state = accelerate(state, matrix @ state + shift)
    assert state == approx(np.linalg.solve(np.eye(6) - matrix, shift), rel=1e-7)


def test_a_cycle_without_series_is_refused(tmp_path):
    path = regenerator(tmp_path / "s.toml", (5, 1), (5, 1))
    lines = path.read_text().splitlines()
    key = "boundary.left.gas.velocity"
    path.write_text(
        "\n".join(f"{key} = 1.0" if line.startswith(key) else line for line in lines)
    )
    refused("a cycle needs a velocity or a temperature that changes", load, path)


@pytest.mark.parametrize("case", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_losses_of_a_bed_at_rest(tmp_path, case):
    group = rows("standby_losses.csv")[3 * case : 3 * case + 3]
    first, k, height = group[0], 2.0, 0.01
    content, T_amb, T_0 = (1 - EPS) * SOLID, 300.0, 400.0
    times = [row["Fo"] * content / k for row in group]
    path = tmp_path / "s.toml"
    # a thin bed: across it the temperature varies by beta (height/length)^2 = 1e-4 of
    # the difference to outside
    path.write_text(f"""
mesh = {{ type = "rectangle", length = 1.0, height = {height}, cells = [60, 1] }}
boundary.left.solids.particles = {{ coefficient = {first["B0"] * k!r}, ambient = {T_amb} }}
boundary.right.solids.particles = {{ coefficient = {first["B1"] * k!r}, ambient = {T_amb} }}
boundary.top.solids.particles = {{ coefficient = {first["beta"] * k * height!r}, ambient = {T_amb} }}
time.end = {times[-1]!r}
time.times = {times!r}
initial.temperature = {T_0}
time.tolerance = 1e-5
output.positions = [0.0, 0.5, 1.0]
gas = {{ density = 1e-9, heat_capacity = 1000.0, conductivity = 1.0, viscosity = 1e-5 }}
solids.particles = {{ density = 1000.0, heat_capacity = {SOLID / 1000!r}, conductivity = 1.0, diameter = {D} }}
packed_bed.porosity = {EPS}
closures = {{ nusselt = 1.0, conductivity_gas = 0.0, conductivity_solids = {k!r} }}
heat = {{}}
""")
    found = run(load(path))
    theta = (found.profiles["T_solid [K]"].reshape(len(group), 3) - T_amb) / (
        T_0 - T_amb
    )
    wanted = [[row[f"theta_{where}"] for where in ("0", "half", "1")] for row in group]
    assert theta == approx(np.array(wanted), abs=1e-4)
