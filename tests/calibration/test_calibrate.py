"""The command: keys of scenes recovered from tables, files, mistakes with file and
line, and what a kill leaves.
"""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure
from numpy.testing import assert_allclose, assert_array_equal

import contbed as cb
from contbed.errors import SceneError
from contbed.many.calibrate.calibrate import FILE, calibrate
from contbed.many.calibrate.experiments import Point, read_jobs
from contbed.many.calibrate.fit import Problem, fit
from contbed.many.calibrate.found import Prediction, data_of
from contbed.many.calibrate.model import SceneModel
from contbed.many.calibrate.plots import _curves
from contbed.many.calibrate.settings import read_file
from contbed.many.optimise.optimise import optimise
from contbed.many.store import Store
from contbed.many.sweep.sweep import sweep
from tests.cases import cases_of
from tests.command_line import command
from tests.numbers_of import table_of
from tests.report.report_file import charts_of

SCENE = """\
mesh = { type = "line", length = 2, cells = 4 }
gas = { density = 1.2, heat_capacity = 1000.0, conductivity = 0.03, viscosity = 2e-5 }
solids.particles = { density = 2000.0, heat_capacity = 900.0, conductivity = 1.0, diameter = "3 mm" }
packed_bed = { porosity = 0.4 }
closures = { nusselt = 2.0 }
heat = {}
boundary.left.gas = { velocity = 0.1, temperature = 300 }
"""
DROPS = """\
title = "pressure drops"
profiles = false
[keys]
packed_bed.porosity = { from = 0.35, to = 0.45 }
solids.particles.diameter = { median = "3 mm", factor = 1.2 }
[[experiment]]
scene = "scene.toml"
file = "drops.csv"
keys = { "boundary.left.gas.velocity" = "u" }
values = [{ quantity = "pressure_drop_Pa", column = "dp", error = "2 %" }]
predict = { results = ["residence_time_s"] }
"""
# A decays along an isothermal bed in plug flow: x = 0.1 exp(-k z/u)
DECAY = """\
mesh = { type = "line", length = "1 m" }
reactions.decay = { equation = "A -> B", rate = "k*c_A", basis = "bed", parameters = { k = "6 1/min" } }
[gas]
model = "ideal_gas"
composition = "A:0.1, N2:0.9"
species = { A = { elements.C = 1 }, B = { elements.C = 1 }, N2 = {} }
[solids.catalyst]
diameter = "3 mm"
[packed_bed]
porosity = 0.4
pressure_drop = "none"
[boundary.left]
gas = { velocity = 0.5, temperature = 500 }
"""
FRACTIONS = """\
profiles = false
[keys]
reactions.decay.parameters.k = { median = "30 1/min", factor = 3 }
[[experiment]]
scene = "scene.toml"
file = "fractions.csv"
position = "z"
values = [{ quantity = "x_A", column = "x", error = 1e-4 }]
"""
# a thin bed that a flux heats: dT/dt = q/(C L), the same everywhere
TANK = """\
mesh = { type = "line", length = 0.01, cells = 4 }

[gas]
density = 1.2
heat_capacity = 1000.0
conductivity = 0.03
viscosity = 2e-5

[solids.particles]
density = 2000.0
heat_capacity = 900.0
conductivity = 1e3
diameter = "1 mm"

[packed_bed]
porosity = 0.4

[closures]
nusselt = 0.0

[heat]

[boundary.left]
solids.particles.heat_flux = 500.0

[initial]
gas.temperature = 300
solids.particles.temperature = 300

[time]
end = 400
"""
HEATED = """\
[keys]
boundary.left.solids.particles.heat_flux = { from = 100, to = 1000 }
[[experiment]]
name = "tank"
scene = "tank.toml"
file = "heated.csv"
where = { probe = "A" }
time = "t"
position = "x"
until = "200 s"
values = [{ quantity = "T_solid", column = "T", error = "0.5 degC" }]
predict = { times = ["5 min"], positions = [0.004] }
[[experiment]]
name = "other"
scene = "tank.toml"
set = { "solids.particles.heat_capacity" = 450.0 }
file = "heated.csv"
where = { probe = "B" }
time = "t"
position = "x"
values = [{ quantity = "T_solid", column = "T", error_column = "error" }]
"""
CAPACITY = 0.6 * 2000.0 * 900.0 * 0.01  # J/m2/K of the tank
FLUX = 620.0


def drop(u, porosity=0.39, diameter=3.2e-3):
    """Ergun's equation."""
    share = (1.0 - porosity) / porosity**3
    return 2.0 * (
        150.0 * 2e-5 * share * (1.0 - porosity) * u / diameter**2
        + 1.75 * 1.2 * share * u**2 / diameter
    )


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "drops.toml").write_text(DROPS)
    rows = [f"{100.0 * u},{1e-2 * drop(u)!r}" for u in (0.02, 0.2, 1.0)]
    (tmp_path / "drops.csv").write_text(
        "\n".join(["# measured", "u [cm/s],dp [mbar]", *rows, ""])
    )
    (tmp_path / "tank.toml").write_text(TANK)
    (tmp_path / "heated.toml").write_text(HEATED)
    lines = ["t [min],x [mm],T [degC],probe,error [K]"]
    for minutes in (1.0, 2.0, 3.0, 6.0):
        warm = 300.0 + FLUX / CAPACITY * 60.0 * minutes - 273.15
        twice = 300.0 + 2.0 * FLUX / CAPACITY * 60.0 * minutes - 273.15
        lines += [f"{minutes},{x},{warm!r},A,1" for x in (2, 8)] + [
            f"{minutes},5,{twice!r},B,1"
        ]
    (tmp_path / "heated.csv").write_text("\n".join(lines))
    return tmp_path


@pytest.fixture
def no_pictures(monkeypatch):
    monkeypatch.setattr(
        "contbed.many.calibrate.calibrate.plot", lambda found, out: None
    )


@pytest.mark.slow
def test_porosity_and_diameter_are_found_from_pressure_drops(folder, capsys):
    text = (
        (folder / "drops.toml")
        .read_text()
        .replace("profiles = false", "profiles = true")
    )
    (folder / "drops.toml").write_text(text)
    assert command("calibrate drops.toml --out out") == 0
    keys = json.loads((folder / "out" / "summary.json").read_text())["keys"]
    fitted = [
        keys[name]["fitted"]
        for name in ("packed_bed.porosity", "solids.particles.diameter")
    ]
    # the data are exact; the prior about 3 mm draws the fit by 2 % of its distance
    assert_allclose(fitted, [0.39, 3.2e-3], rtol=5e-3)
    for key, true in (
        ("packed_bed.porosity", 0.39),
        ("solids.particles.diameter", 3.2e-3),
    ):
        assert keys[key]["low"] < true < keys[key]["high"]
        assert keys[key]["low of profile"] < true < keys[key]["high of profile"]
    points = table_of(folder / "out" / "points.csv")
    assert [row["line"] for row in points if row["measured"]] == [
        f"drops.csv:{k}" for k in range(3, 6)
    ]
    assert points[0]["unit"] == "Pa"
    ahead = [row for row in points if row["quantity"] == "residence_time_s"]
    # porosity by itself: the band of eps L/u follows that of eps
    low, high = (
        keys["packed_bed.porosity"][end] * 2.0 / 0.02 for end in ("low", "high")
    )
    assert_allclose(
        [float(ahead[0]["low"]), float(ahead[0]["high"])], [low, high], rtol=1e-6
    )
    out = capsys.readouterr().out
    assert "3 values, chi-square" in out and "known" in out
    assert command("report out") == 0
    report = (folder / "out" / "report.html").read_text()
    assert (
        "solids.particles.diameter" in report
        and report.count("data:image/png;base64,") == 3
    )
    covariance = json.loads((folder / "out" / "summary.json").read_text())[
        "covariance"
    ]["matrix"]
    assert all(f"{value:.6g}" in report for row in covariance for value in row)
    parallel, matrix = (chart["data"][0] for chart in charts_of(report))
    assert len(matrix["text"]) == 3 and len(parallel["dimensions"]) >= 2
    assert {path.name for path in (folder / "out").iterdir()} >= {
        "keys.csv", "points.csv", "combinations.csv", "profiles", "fit.png", "residuals.png", "keys.png", FILE,
        "calibrated.toml",
    }  # fmt: skip


def test_a_column_of_a_gas_is_fitted(tmp_path, monkeypatch, no_pictures):
    """Mole fractions along the bed give the constant of the rate, whose prior has a
    unit; their error is a number in SI.
    """
    monkeypatch.chdir(tmp_path)
    z = np.array([0.1, 0.3, 0.5, 0.8])
    rows = [f"{at},{0.1 * np.exp(-0.7 / 0.5 * at):.12g}" for at in z]
    for name, text in (
        ("scene.toml", DECAY),
        ("file.toml", FRACTIONS),
        ("fractions.csv", "\n".join(["z [m],x [1]", *rows])),
    ):
        (tmp_path / name).write_text(text, encoding="utf-8")
    found = calibrate("file.toml", "out")
    assert {point.error for point in found.points if point.fitted} == {1e-4}
    assert found.keys[0].prior.low == 0.5
    # of the estimated error of the cells
    assert_allclose(found.values["reactions.decay.parameters.k"], 0.7, rtol=1e-4)


def test_a_plain_constant_takes_no_unit_in_a_study(tmp_path, monkeypatch):
    """It counts in the unit of its formula, which a text would not."""
    monkeypatch.chdir(tmp_path)
    Path("scene.toml").write_text(DECAY.replace('"6 1/min"', "0.1"), encoding="utf-8")
    Path("fractions.csv").write_text("z [m],x [1]\n0.5,0.05\n", encoding="utf-8")
    Path("file.toml").write_text(FRACTIONS, encoding="utf-8")
    with pytest.raises(SceneError, match="a plain number, this key has no unit"):
        calibrate("file.toml", "out")


def test_columns_of_constants_and_empty_cells(tmp_path, monkeypatch, no_pictures):
    """Each row has a rate constant, 1/h in the table; a cell that is empty counts for
    nothing.
    """
    monkeypatch.chdir(tmp_path)
    scene = DECAY.replace("c_A", "f*c_A").replace("{ k = ", "{ f = 1.0, k = ")
    Path("scene.toml").write_text(scene, encoding="utf-8")
    rows = ["k [1/h],x [1],T [K]"]
    for k in (360.0, 720.0, 1080.0):
        rows.append(f"{k},{0.1 * np.exp(-1.4 * k / 3600.0 / 0.5):.12g},500")
    rows[2] = "720,,500"
    Path("fractions.csv").write_text("\n".join(rows), encoding="utf-8")
    Path("file.toml").write_text(
        """\
profiles = false
[keys]
reactions.decay.parameters.f = { from = 0.5, to = 3 }
[[experiment]]
scene = "scene.toml"
file = "fractions.csv"
keys = { "reactions.decay.parameters.k" = "k" }
values = [
    { quantity = "x_A_out", column = "x", error = 1e-4 },
    { quantity = "T_fluid_out_K", column = "T", error = 1.0 },
]
""",
        encoding="utf-8",
    )
    found = calibrate("file.toml", "out")
    assert sum(point.fitted for point in found.points) == 5
    # of the estimated error of the cells
    assert_allclose(found.values["reactions.decay.parameters.f"], 1.4, rtol=1e-4)


PLATE = """
mesh = { type = "line", length = 0.03, cells = 4 }
gas = { density = 0.5, viscosity = 3e-5, heat_capacity = 1e3, conductivity = 0.05 }
solids.grains = { diameter = 1e-3, density = 5600, heat_capacity = 600, conductivity = 2 }
packed_bed.porosity = 0.4
closures = { nusselt = 5, conductivity_gas = 0, conductivity_solids = 0.5 }
heat = {}
boundary.left = { type = "wall", temperature = 400 }
boundary.right = { type = "wall", temperature = 300 }
"""
HOT_PLATE = """
profiles = false
[keys]
closures.conductivity_solids = { from = 0.1, to = 2 }
[[experiment]]
scene = "plate.toml"
file = "plate.csv"
keys = { "boundary.left.temperature" = "T" }
values = [{ quantity = "heat_left_W", column = "q", error = "50 W/m2" }]
"""
LAYER = """
scene = "plate.toml"
minimise = "mesh.length"
constraints = ["heat_left_W <= 5 kW/m2"]
[keys]
mesh.length = { from = "5 mm", to = "0.2 m", start = "30 mm" }
"""


def test_heats_of_a_line_count_per_area(tmp_path, monkeypatch, no_pictures):
    """k = q L/dT, and L = k dT/q, in tables of studies as well: round-off and the end
    of the searches, 1e-6.
    """
    monkeypatch.chdir(tmp_path)
    for name, text in (("plate", PLATE), ("fit", HOT_PLATE), ("layer", LAYER)):
        Path(f"{name}.toml").write_text(text, encoding="utf-8")
    Path("plate.csv").write_text("T [K],q [kW/m2]\n400,2.4\n500,4.8\n", "utf-8")
    found = calibrate("fit.toml", "fit")
    assert found.values["closures.conductivity_solids"] == pytest.approx(0.72, rel=1e-6)
    optimise("layer.toml", "layer")
    best = json.loads(Path("layer/summary.json").read_text())
    assert best["keys"]["mesh.length"]["value"] == pytest.approx(0.01, rel=1e-6)
    assert "heat_left [W/m2]" in Path("layer/table.csv").read_text()
    Path("sweep.toml").write_text(
        'scene = "plate.toml"\nqoi = ["heat_left_W"]\n'
        'parameters."mesh.length" = [0.01, 0.02]\n'
    )
    sweep("sweep.toml", "sweep", jobs=1)
    assert "heat_left [W/m2]" in Path("sweep/table.csv").read_text()


def test_two_transient_experiments_are_fitted_at_once_and_the_rest_is_predicted(
    folder, no_pictures
):
    found = calibrate("heated.toml", "out")
    # the temperature is linear in the flux: the closed form of the weighted mean
    assert_allclose(
        found.values["boundary.left.solids.particles.heat_flux"], FLUX, rtol=1e-5
    )  # of the steps in time
    fitted = [point for point in found.points if point.fitted]
    slopes = [
        (2.0 if p.experiment == "other" else 1.0) * p.t / CAPACITY / p.error
        for p in fitted
    ]
    error = 1.0 / np.sqrt(np.sum(np.square(slopes)))
    assert len(fitted) == 6 + 4  # those of the first after 200 s are kept back
    assert {p.error for p in fitted} == {0.5, 1.0}  # a difference of 0.5 degC is 0.5 K
    prior = found.keys[0].prior
    scale = prior.slope(0.0)
    assert_allclose(np.sqrt(found.fit.covariance[0, 0]) * scale, error, rtol=1e-5)
    ahead = next(
        k
        for k, point in enumerate(found.points)
        if point.t == 300.0 and np.isnan(point.value)
    )
    assert_allclose(
        found.prediction.value[ahead], 300.0 + FLUX / CAPACITY * 300.0, rtol=1e-5
    )
    assert_allclose(
        found.prediction.deviation[ahead], error * 300.0 / CAPACITY, rtol=1e-4
    )
    whole = found.prediction.high_measured[ahead] - found.prediction.value[ahead]
    assert_allclose(
        whole, 1.6448536 * np.hypot(error * 300.0 / CAPACITY, 0.5), rtol=1e-4
    )
    summary = json.loads((folder / "out" / "summary.json").read_text())
    assert (
        summary["data"]["kept back"]
        == 2
        == summary["data"]["kept back inside of the band"]
    )
    # the scenes that are written are those that were fitted
    scene = cb.load(folder / "out" / "calibrated_other.toml")
    assert scene.solid.heat_capacity == 450.0
    assert_allclose(
        scene.boundary["left"].condition("solid").heat_flux, FLUX, rtol=1e-5
    )


@pytest.mark.slow
def test_intervals_of_a_scene_hold_the_keys_in_nine_of_ten_repetitions(folder):
    text = (
        (folder / "drops.toml")
        .read_text()
        .replace('median = "3 mm", factor = 1.2', 'from = "2 mm", to = "4 mm"')
    )
    (folder / "drops.toml").write_text(text)
    file = read_file("drops.toml")
    jobs, store, random = read_jobs(file), Store(None), np.random.default_rng(7)
    model, priors = SceneModel(file.keys, jobs, store), [key.prior for key in file.keys]
    true = np.array(
        [
            float(prior.scaled(value))
            for prior, value in zip(priors, (0.39, 3.2e-3), strict=True)
        ]
    )
    measured, held = data_of(model.points), np.zeros(2)
    for _ in range(200):
        values = measured.value + measured.error * random.standard_normal(3)
        found = fit(Problem(model, replace(measured, value=values), priors))
        held += np.abs(found.z - true) <= found.quantile * np.sqrt(
            np.diag(found.covariance)
        )
    # 180 with a standard deviation of 4.2
    assert np.all(held >= 170) and np.all(held <= 190), held


def test_the_same_command_computes_nothing_again(folder, no_pictures):
    first = calibrate("drops.toml", "out")
    again = calibrate("drops.toml", "out")
    assert again.runs == again.before == first.runs > 0
    assert_array_equal(first.fit.z, again.fit.z)


def test_a_line_that_was_not_written_whole_is_computed_again(folder, no_pictures):
    first = calibrate("drops.toml", "out")
    file = folder / "out" / FILE
    text = file.read_bytes()
    file.write_bytes(text[:-40])
    again = calibrate("drops.toml", "out")
    assert (again.runs, again.before) == (first.runs, first.runs - 1)
    assert_array_equal(first.fit.z, again.fit.z)
    assert calibrate("drops.toml", "out").before == first.runs


def test_a_line_that_was_changed_is_computed_again(folder):
    store = Store(folder / FILE)
    store.add("one", {"exit_code": 0, "problem": "", "values": [1.5]})
    store.add("two", {"exit_code": 0, "problem": "", "values": [2.5]})
    file = folder / FILE
    file.write_text(file.read_text().replace("1.5", "1.6"))
    again = Store(folder / FILE)
    assert again.known("one") is None and again.known("two")["values"] == [2.5]


def test_a_killed_command_goes_on(folder, no_pictures):
    command = [
        sys.executable,
        "-m",
        "contbed",
        "calibrate",
        "drops.toml",
        "--out",
        "out",
    ]
    process = subprocess.Popen(
        command, env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    )
    file, deadline = folder / "out" / FILE, time.monotonic() + 60.0
    while (
        not (file.is_file() and file.stat().st_size > 2000)
        and time.monotonic() < deadline
    ):
        time.sleep(0.005)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert not (folder / "out" / "summary.json").exists()
    before = len(file.read_text().splitlines()) - 1  # the last line may not be whole
    done = calibrate("drops.toml", "out")
    assert 0 < before <= done.before < done.runs
    assert_allclose(done.values["packed_bed.porosity"], 0.39, rtol=5e-3)


def test_failed_runs_are_kept_and_lose_nothing(folder, monkeypatch, no_pictures):
    from contbed import runner
    from contbed.errors import ConvergenceError

    run = runner.run

    def fails_above(scene, *arguments, **options):
        if scene.packed_bed.porosity > 0.3995:  # the middle of the prior among them
            raise ConvergenceError("no solution")
        return run(scene, *arguments, **options)

    monkeypatch.setattr(runner, "run", fails_above)
    found = calibrate("drops.toml", "out")
    assert found.failed and all(each["exit_code"] == 3 for each in found.failed)
    assert_allclose(found.values["packed_bed.porosity"], 0.39, rtol=5e-3)
    monkeypatch.setattr(runner, "run", run)
    again = calibrate("drops.toml", "out", retry_failed=True)
    assert not again.failed and again.before == found.runs - len(found.failed)


@pytest.mark.slow
def test_several_processes_find_the_same(folder, no_pictures):
    one, two = calibrate("drops.toml", "one"), calibrate("drops.toml", "two", jobs=2)
    assert_array_equal(one.fit.z, two.fit.z)


def test_tangents_of_the_runs_are_the_derivatives(folder):
    file = read_file("drops.toml")
    model = SceneModel(file.keys, read_jobs(file), Store(None))
    z = np.array([0.3, 0.4])
    slopes = model.slopes(z)
    keys = model.at(z)
    assert model.computed == 3
    for k, u in enumerate((0.02, 0.2, 1.0)):
        for j, name in enumerate(("porosity", "diameter")):
            given = {
                "porosity": keys["packed_bed.porosity"],
                "diameter": keys["solids.particles.diameter"],
            }
            step = 1e-6 * given[name]
            ends = [
                drop(u, **(given | {name: given[name] + side * step}))
                for side in (1.0, -1.0)
            ]
            exact = (ends[0] - ends[1]) / (2.0 * step) * file.keys[j].prior.slope(z[j])
            # central differences of the closed form are good to 1e-9, the tangent to
            # 1e-6
            assert_allclose(slopes[2 * k, j], exact, rtol=1e-6)


def test_profiles_and_transients_have_no_tangents(folder):
    file = read_file("heated.toml")
    model = SceneModel(file.keys, read_jobs(file), Store(None))
    assert model.slopes(np.array([0.3])) is None and model.computed == 0


def test_a_store_in_memory_writes_nothing(folder):
    store = Store(None)
    store.add("name", {"exit_code": 0, "problem": "", "values": [1.0]})
    assert store.known("name")["values"] == [1.0] and len(store) == 1


MISTAKES = cases_of(__file__, "mistakes", "file", "old", "new", "told")


@pytest.mark.parametrize(
    ("name", "old", "new", "told"), MISTAKES, ids=[case[3][:60] for case in MISTAKES]
)
def test_mistakes_are_told_with_file_and_line(folder, capsys, name, old, new, told):
    path = folder / f"{name}.toml"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    assert command(f"calibrate {name}.toml --out out") == 2
    assert told in capsys.readouterr().err.replace(f"{folder}/", "")
    assert not (folder / "out" / "summary.json").exists()


def test_data_outside_of_the_model_are_told_by_their_line(folder, capsys):
    with open(folder / "heated.csv", "a") as file:
        file.write("\n8,2,40.0,A,1\n5,12,40.0,A,1\n")
    assert command("calibrate heated.toml") == 2
    assert (
        "heated.csv:14: 480 s is after the end of the run, time.end = 400 s in "
        "tank.toml; let the scene run longer" in capsys.readouterr().err
    )
    text = (folder / "heated.csv").read_text().replace("8,2,40.0,A,1\n", "")
    (folder / "heated.csv").write_text(text)
    assert command("calibrate heated.toml") == 2
    assert (
        "heated.csv:14: position 0.012 m: outside of the bed, 0 to 0.01 m"
        in capsys.readouterr().err
    )


def test_fewer_data_than_keys_are_refused(folder, capsys):
    lines = (folder / "drops.csv").read_text().splitlines()
    (folder / "drops.csv").write_text("\n".join(lines[:3]))
    assert command("calibrate drops.toml") == 2
    assert (
        "drops.toml:3: 2 keys are to be fitted to 1 measured values; leave out keys, "
        "or give" in capsys.readouterr().err
    )


def test_a_series_over_time_is_one_curve():
    """A quantity without positions has no number to tell series apart."""
    points = [
        Point("one", "mass_fraction", "1", t, value=1.0, error=0.1, fitted=t < 3.0)
        for t in (1.0, 2.0, 3.0)
    ]
    three = np.array([1.0, 1.1, 1.2])
    prediction = Prediction(
        three, 0.1 * three, three - 0.2, three + 0.2, three - 0.3, three + 0.3
    )
    figure = Figure()
    axes = figure.subplots()
    _curves(axes, SimpleNamespace(points=points, prediction=prediction), [0, 1, 2])
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["predicted"]
    assert_array_equal(axes.get_lines()[0].get_xdata(), [1.0, 2.0, 3.0])


def test_a_steady_scene_has_no_times(folder, capsys):
    (folder / "tank.toml").write_text(SCENE)
    text = (
        (folder / "heated.toml")
        .read_text()
        .replace(
            "boundary.left.solids.particles.heat_flux = { from = 100, to = 1000 }", ""
        )
    )
    (folder / "heated.toml").write_text(
        text.replace("[keys]", "[keys]\npacked_bed.porosity = { from = 0.3, to = 0.5 }")
    )
    assert command("calibrate heated.toml") == 2
    assert (
        "heated.csv:2: the scene tank.toml is steady; leave out time"
        in capsys.readouterr().err
    )


def test_the_posterior_goes_on_where_it_was_and_says_when_it_is_short(
    folder, no_pictures
):
    pytest.importorskip("emcee")
    with open(folder / "drops.toml", "a") as file:
        file.write("[posterior]\nwalkers = 4\nsteps = 10\n")
    found = calibrate("drops.toml", "out")
    assert found.samples is not None and found.samples.z.shape == (4 * 8, 2)
    assert any("autocorrelation times" in text for text in found.warnings)
    again = calibrate("drops.toml", "out")
    assert again.before == found.runs
    assert_array_equal(found.samples.z, again.samples.z)
    assert len(table_of(folder / "out" / "posterior.csv")) == 32


def test_without_emcee_the_posterior_is_refused_before_any_run(
    folder, capsys, monkeypatch
):
    with open(folder / "drops.toml", "a") as file:
        file.write("[posterior]\n")
    monkeypatch.setitem(sys.modules, "emcee", None)
    assert command("calibrate drops.toml --out out") == 1
    assert "pip install 'contbed[calibrate]'" in capsys.readouterr().err
    assert not (folder / "out").exists()
