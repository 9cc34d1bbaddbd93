"""Sweeps in this process: designs, tables, what is kept and what is told; their
workers are in tests/stress.
"""

import errno
import importlib
import json
import math
import sys
import types
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.special import ndtr

from contbed import cli
from contbed.errors import ContbedError, ConvergenceError, SceneError
from contbed.many import quantities, value_sets
from contbed.many.sweep.plots import _Axis, _is_plane, _means
from contbed.many.sweep.study import read_study
from tests.cases import cases_of
from tests.numbers_of import table_of

STUDIES = Path(__file__).parents[2] / "studies"
SCENE = """\
[mesh]
type = "line"
length = 2

[gas]
density = 1
viscosity = 2e-5

[solids.particles]
diameter = "3 mm"

[packed_bed]
porosity = 0.4

[boundary.left]
gas.velocity = 0.1
"""
STUDY = """\
scene = "scene.toml"
[parameters]
boundary.left.gas.velocity = [0.1, "20 cm/s"]
"solids.particles.diameter" = ["1 mm", "2 mm"]
"""
SPHERES = (
    '[solids.spheres]\ndiameter = "2 mm"\nconductivity = 1.0\n[output]\nplots = false\n'
)
ALONE = 'scene = "scene.toml"\n[parameters]\n'
SAMPLE = """\
scene = "scene.toml"
[sample]
method = "sobol"
count = 8
seed = 3
[sample.parameters]
boundary.left.gas.velocity = { distribution = "log_uniform", from = "1 cm/s", to = 1 }
packed_bed.porosity = { from = 0.3, to = 0.5 }
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path


@pytest.fixture
def runner(monkeypatch):
    """A runner that only records its calls; `runner.error(scene)` may return what it
    raises.
    """
    # keeps the true one, which other tests need
    importlib.import_module("contbed.many.derivatives.gradients")
    module = types.ModuleType("contbed.runner")
    module.calls, module.error = [], lambda scene: None

    def run(scene, out, quiet):
        module.calls.append(scene)
        if error := module.error(scene):
            raise error
        out.mkdir(parents=True, exist_ok=True)
        drop = (
            scene.boundary["left"].gas.velocity
            / scene.diameter
            * (2.0 if scene.solid.shape == "rods" else 1.0)
        )
        return types.SimpleNamespace(
            summary={
                "qoi": {
                    "pressure_drop_Pa": drop,
                    "u_max": scene.boundary["left"].gas.velocity,
                }
            }
        )

    module.run = run
    monkeypatch.setitem(sys.modules, "contbed.runner", module)
    return module


def sweep(*arguments):
    return cli.main(["sweep", "study.toml", "--out", "out", "--jobs", "1", *arguments])


def rows(folder):
    return table_of(folder / "out" / "table.csv")


def never(below, text):
    raise AssertionError(f"{below}: {text}")


@pytest.mark.parametrize(
    ("low", "high", "count", "spacing"),
    [
        (0.1, 0.7, 7, "linear"),
        (3.0, -1.0, 10, "linear"),
        (math.pi, math.e, 5, "log"),
        (-1e3, -1e-5, 9, "log"),
        (7, 1, 2, "log"),
    ],
)
def test_ranges_are_even_and_exact_at_both_ends(low, high, count, spacing):
    found = value_sets.values(
        {"from": low, "to": high, "count": count, "spacing": spacing}, "1", never
    )
    assert len(found) == count
    assert (found[0], found[-1]) == (low, high)  # to the last bit
    steps = np.diff(np.log(np.abs(found)) if spacing == "log" else found)
    assert_allclose(steps, steps.mean(), rtol=1e-12)


def test_ranges_carry_units_and_count_in_whole_numbers():
    assert value_sets.values(
        {"from": "3 mm", "to": "1.2 cm", "count": 4}, "m", never
    ) == [0.003, 0.006, 0.009, 0.012]
    assert value_sets.values(
        {"from": "0 degC", "to": 373.15, "count": 2}, "K", never
    ) == [273.15, 373.15]
    whole = value_sets.values({"from": 10, "to": 40, "count": 4}, None, never)
    assert whole == [10, 20, 30, 40] and all(type(value) is int for value in whole)
    assert value_sets.values({"from": 1, "to": 2, "count": 3}, None, never) == [
        1.0,
        1.5,
        2.0,
    ]


@pytest.mark.parametrize("count", [1, 7, 64, 1000])
def test_a_latin_hypercube_has_one_point_in_each_slice_of_equal_probability(count):
    u = value_sets.sample("latin_hypercube", count, seed=5, dimensions=4)
    spread = [
        {"from": 2.0, "to": 3.0},
        {"distribution": "log_uniform", "from": -1e-3, "to": -10.0},
        {"mean": 5.0, "deviation": 0.1},
        {"from": -1.0, "to": 1.0},
    ]
    values = [
        value_sets.distribution(entry, "1", never)(u[:, k])
        for k, entry in enumerate(spread)
    ]
    probabilities = [
        values[0] - 2.0,
        np.log(values[1] / -1e-3) / math.log(1e4),
        ndtr((values[2] - 5.0) / 0.1),
        (values[3] + 1.0) / 2.0,
    ]
    for column in probabilities:
        # exact: a point would have to lie within round-off of an edge to be counted in
        # the wrong slice
        assert sorted(np.floor(count * column).astype(int)) == list(range(count))


def test_sobol_points_are_those_of_their_seed_and_fill_every_dimension():
    u = value_sets.sample("sobol", 64, seed=1, dimensions=6)
    assert_array_equal(u, value_sets.sample("sobol", 64, seed=1, dimensions=6))
    # more points go on
    assert_array_equal(u[:16], value_sets.sample("sobol", 16, seed=1, dimensions=6))
    assert (u != value_sets.sample("sobol", 64, seed=2, dimensions=6)).all()
    for column in u.T:
        assert sorted(np.floor(64 * column).astype(int)) == list(range(64))
    # a (0, 6, 2) net: one point in each box of 2^-k by 2^(k-6)
    for k in range(7):
        boxes = np.floor(u[:, :2] * (2**k, 2 ** (6 - k))).astype(int)
        assert len(np.unique(boxes, axis=0)) == 64


def test_a_normal_sample_has_its_mean_and_deviation_also_in_degrees():
    spread = value_sets.distribution(
        {"mean": "700 degC", "deviation": "10 degC"}, "K", never
    )
    assert_allclose(
        spread(ndtr(np.array([-2.0, 0.0, 1.0]))), [953.15, 973.15, 983.15], rtol=1e-12
    )


def test_parts_are_combined_and_zipped_ones_go_in_step(folder):
    (folder / "study.toml").write_text(
        STUDY
        + "[[zipped]]\ngas.density = [1.2, 0.6, 0.3]\ngas.viscosity = { from = 1e-5, "
        "to = 3e-5, count = 3 }\n"
        + SAMPLE.partition("\n")[2]
        .replace("boundary.left.gas.velocity", "closures.permeability")
        .replace('"1 cm/s"', '"1e-9 m2"')
    )
    study = read_study("study.toml")
    assert len(study.cases) == 2 * 2 * 3 * 8
    assert len({case.name for case in study.cases}) == len(study.cases)
    pairs = {
        (case.parameters["gas.density"], case.parameters["gas.viscosity"])
        for case in study.cases
    }
    assert pairs == {(1.2, 1e-5), (0.6, 2e-5), (0.3, 3e-5)}
    assert study.axes == (
        "boundary.left.gas.velocity",
        "solids.particles.diameter",
        "gas.density",
        "closures.permeability",
        "packed_bed.porosity",
    )
    assert tuple(study.parameters) == (
        *study.axes[:3],
        "gas.viscosity",
        *study.axes[3:],
    )
    assert study.logarithmic == {"closures.permeability"}
    for case in study.cases:
        assert case.scene.gas.viscosity == case.parameters["gas.viscosity"]
        assert case.scene.packed_bed.porosity == case.parameters["packed_bed.porosity"]
    assert not study.warnings


def test_the_same_scene_twice_is_one_run(folder):
    (folder / "study.toml").write_text(STUDY.replace('"20 cm/s"', '"10 cm/s", 0.1'))
    assert len(read_study("study.toml").cases) == 2


def test_scenes_of_every_kind(folder):
    (folder / "scene.toml").write_text(
        '[particles.lattice]\ntype = "sc"\ncontact_radius = 1e-5\n' + SPHERES
    )
    (folder / "study.toml").write_text(
        'scene = "scene.toml"\n[parameters]\nparticles.lattice.type = ["sc", "bcc", '
        '"fcc"]\n'
    )
    assert sweep() == 0
    found = [float(row["k_eff [W/m/K]"]) for row in rows(folder)]
    assert found[0] < found[1] < found[2]  # more contacts conduct more
    scene = STUDIES / "bubbling_bed_case1" / "none.toml"
    (folder / "study.toml").write_text(
        f'scene = "{scene}"\n[parameters]\nmesh.cells = [30, 40]\n'
    )
    assert [case.scene.mesh.cells for case in read_study("study.toml").cases] == [
        30,
        40,
    ]


def test_a_sweep_runs_everything_once_and_keeps_failures(folder, runner, capsys):
    runner.error = lambda scene: (
        ConvergenceError("stalled\nat once")
        if scene.boundary["left"].gas.velocity > 0.15
        else None
    )
    assert sweep() == 3
    out, err = capsys.readouterr()
    assert out == "2 of 4 runs are finished, 0 were before; see out/table.csv\n"
    assert err.splitlines() == [
        "failed with 3: boundary.left.gas.velocity = 0.2, solids.particles.diameter = "
        f"{d}: stalled; at once"
        for d in (0.001, 0.002)
    ]
    assert [row["exit code"] for row in rows(folder)] == ["0", "0", "3", "3"]
    assert [row["problem"] for row in rows(folder)] == [
        "",
        "",
        "stalled; at once",
        "stalled; at once",
    ]
    kept = json.loads(
        (folder / "out" / "runs" / rows(folder)[2]["run"] / "outcome.json").read_text()
    )
    assert (
        kept["exit_code"] == 3
        and kept["scene"]["boundary"]["left"]["gas"]["velocity"] == 0.2
    )

    assert sweep() == 3
    assert len(runner.calls) == 4
    runner.error = lambda scene: None
    assert sweep("--retry-failed") == 0
    assert len(runner.calls) == 6
    assert sweep("--retry-failed") == 0
    assert len(runner.calls) == 6
    found = rows(folder)
    assert list(found[0]) == [
        "boundary.left.gas.velocity [m/s]",
        "solids.particles.diameter [m]",
        "pressure_drop [Pa]",
        "u_max [m/s]",
        "run",
        "exit code",
        "problem",
    ]
    assert [row["boundary.left.gas.velocity [m/s]"] for row in found] == [
        "0.1",
        "0.1",
        "0.2",
        "0.2",
    ]
    assert [float(row["pressure_drop [Pa]"]) for row in found] == [
        100.0,
        50.0,
        200.0,
        100.0,
    ]
    whole = json.loads((folder / "out" / "table.json").read_text())
    assert whole["qoi"] == {
        "pressure_drop_Pa": {"unit": "Pa"},
        "u_max": {"unit": "m/s"},
    }
    assert whole["runs"][3]["qoi"] == {"pressure_drop_Pa": 100.0, "u_max": 0.2}
    assert (folder / "out" / "sweep.png").read_bytes().startswith(b"\x89PNG")

    written = (folder / "out" / "table.csv").read_bytes()
    assert sweep() == 0
    assert (folder / "out" / "table.csv").read_bytes() == written

    # a new value and a damaged outcome are run, the rest is there
    (folder / "study.toml").write_text(STUDY.replace("0.1,", "0.1, 0.3,"))
    (folder / "out" / "runs" / found[0]["run"] / "outcome.json").write_text("{ broken")
    assert sweep() == 0
    assert len(runner.calls) == 9
    log = (
        (folder / "out" / "runs" / found[0]["run"] / "workers.log")
        .read_text()
        .splitlines()
    )
    assert [line.split()[-1] for line in log] == ["begun", "finished"] * 2


ON_A_FILE = STUDY.replace('[0.1, "20 cm/s"]', "[[0.1, 0.0], [0.2, 0.0]]")


def test_a_changed_file_is_a_changed_scene(folder):
    (folder / "scene.toml").write_text(
        SCENE.replace('type = "line"\nlength = 2', 'type = "file"\nfile = "bed.msh"')
    )
    (folder / "study.toml").write_text(ON_A_FILE)
    (folder / "bed.msh").write_bytes(b"one")
    first = {case.name for case in read_study("study.toml").cases}
    (folder / "bed.msh").write_bytes(b"two")
    assert not first & {case.name for case in read_study("study.toml").cases}


def test_a_changed_geometry_and_another_version_are_changed_scenes(folder, monkeypatch):
    (folder / "scene.toml").write_text(
        SCENE.replace('type = "line"\nlength = 2', 'type = "file"\nfile = "bed.geo"')
    )
    (folder / "study.toml").write_text(ON_A_FILE)
    (folder / "bed.geo").write_text("x = 1;\n")
    found = [{case.name for case in read_study("study.toml", trust=True).cases}]
    (folder / "bed.geo").write_text("x = 2;\n")
    found.append({case.name for case in read_study("study.toml", trust=True).cases})
    monkeypatch.setattr("contbed.scene.identity.__version__", "99.0")
    found.append({case.name for case in read_study("study.toml", trust=True).cases})
    assert len(set.union(*found)) == sum(map(len, found))


def test_a_changed_mechanism_is_computed_again(folder, runner):
    gas = 'model = "cantera"\ncomposition = "N2:1"\nmechanism = "mine.yaml"'
    (folder / "scene.toml").write_text(
        SCENE.replace("density = 1\nviscosity = 2e-5", gas) + "gas.temperature = 300\n"
    )
    (folder / "mine.yaml").write_text("a: 1\n")
    assert sweep() == 0
    (folder / "mine.yaml").write_text("a: 2\n")
    assert sweep() == 0
    assert len(runner.calls) == 8


def test_an_outcome_with_a_flipped_digit_is_computed_again(folder, runner, capsys):
    assert sweep() == 0
    run = rows(folder)[0]["run"]
    outcome = folder / "out" / "runs" / run / "outcome.json"
    outcome.write_text(outcome.read_text().replace("100.0", "100.1"))
    capsys.readouterr()
    assert sweep() == 0
    assert (
        len(runner.calls) == 5 and float(rows(folder)[0]["pressure_drop [Pa]"]) == 100.0
    )
    warning = (
        f"warning: runs/{run}: outcome.json is not as it was written; the run is "
        "computed again\n"
    )
    assert capsys.readouterr().err == warning


def test_a_log_that_is_a_link_is_not_followed(folder, runner):
    (case, *_) = read_study("study.toml").cases
    (folder / "mine.txt").write_text("mine")
    (folder / "out" / "runs" / case.name).mkdir(parents=True)
    (folder / "out" / "runs" / case.name / "workers.log").symlink_to(
        folder / "mine.txt"
    )
    assert sweep() == 1
    assert (folder / "mine.txt").read_text() == "mine"


def test_a_crash_in_one_run_does_not_lose_the_others(folder, runner):
    runner.error = lambda scene: (
        ZeroDivisionError("a\nb")
        if scene.boundary["left"].gas.velocity > 0.15
        else None
    )
    assert sweep("--quiet") == 3
    assert [row["problem"] for row in rows(folder)] == [
        "",
        "",
        *["ZeroDivisionError: a; b"] * 2,
    ]
    assert [row["exit code"] for row in rows(folder)] == ["0", "0", "1", "1"]


def test_a_value_that_a_run_refuses_is_blamed_on_its_line(folder, runner):
    text = "boundary.left.gas.velocity = 0.2: too fast"
    runner.error = lambda scene: (
        SceneError(f"override: {text}")
        if scene.boundary["left"].gas.velocity > 0.15
        else None
    )
    assert sweep("--quiet") == 3
    lines = (folder / "study.toml").read_text().splitlines()
    (line,) = (k for k, each in enumerate(lines, 1) if "gas.velocity" in each)
    assert [row["problem"] for row in rows(folder)] == [
        "",
        "",
        *[f"study.toml:{line}: {text}"] * 2,
    ]


def test_a_full_disk_stops_the_sweep_and_is_no_fault_of_the_scene(
    folder, runner, capsys
):
    full = OSError(errno.ENOSPC, "No space left on device", "out/runs")

    def error(scene):
        if len(runner.calls) < 3:
            return None
        failure = ContbedError(
            "cannot write profiles.csv: No space left on device; free some space"
        )
        failure.__cause__ = full
        return failure

    runner.error = error
    assert sweep() == 1
    assert (
        capsys.readouterr().err
        == "cannot write profiles.csv: No space left on device; free some space\n"
    )
    assert len(runner.calls) == 3
    assert [row["exit code"] for row in rows(folder)] == ["0", "0"]
    runner.error = lambda scene: full if len(runner.calls) == 4 else None
    assert sweep() == 1
    assert sweep() == 0
    assert len(runner.calls) == 6


def test_an_interrupt_keeps_what_is_there(folder, runner, capsys):
    runner.error = lambda scene: KeyboardInterrupt() if len(runner.calls) == 2 else None
    assert sweep() == 130
    assert capsys.readouterr().err == "interrupted; to resume: the same command\n"
    assert len(rows(folder)) == 1
    assert json.loads((folder / "out" / "table.json").read_text())["cases"] == 4
    assert sweep() == 0
    assert len(runner.calls) == 5
    assert len(rows(folder)) == 4


def test_a_folder_that_cannot_be_written_is_told_before_the_first_run(
    folder, runner, capsys
):
    (folder / "out").write_text("a file")
    assert sweep() == 1
    assert "cannot write" in capsys.readouterr().err
    assert not runner.calls


def test_a_sobol_count_that_is_no_power_of_two_is_a_warning(folder, runner, capsys):
    (folder / "study.toml").write_text(SAMPLE.replace("count = 8", "count = 6"))
    assert sweep() == 0
    assert capsys.readouterr().err == (
        "warning: study.toml:4: sample.count = 6: not a power of two; Sobol points "
        "fill the space evenly at 4 or 8\n"
    )
    assert json.loads((folder / "out" / "table.json").read_text())["warnings"]


def test_a_result_that_no_run_has_is_told_with_those_there_are(folder, runner, capsys):
    (folder / "study.toml").write_text('qoi = ["u_max", "presure_drop_Pa"]\n' + STUDY)
    assert sweep() == 2
    assert capsys.readouterr().err == (
        'study.toml:1: qoi: no run has the result "presure_drop_Pa"; allowed: '
        "pressure_drop_Pa, u_max; "
        "did you mean 'pressure_drop_Pa'?\n"
    )
    assert len(rows(folder)) == 4
    (folder / "study.toml").write_text('qoi = ["u_max", "pressure_drop_Pa"]\n' + STUDY)
    assert sweep() == 0
    assert len(runner.calls) == 4


@pytest.mark.parametrize(
    ("text", "line"),
    [
        *cases_of(__file__, "mistakes", "text", "line"),
        (
            STUDY.replace("0.1,", f"{'0.1, ' * 60000}"),
            "study.toml:2: parameters: 120002 runs; at most 100000",
        ),
        *cases_of(__file__, "mistakes_in_samples", "text", "line"),
    ],
)
def test_mistakes_in_a_study_are_told_before_the_first_run(
    folder, runner, capsys, text, line
):
    (folder / "study.toml").write_text(text)
    assert sweep() == 2
    out, err = capsys.readouterr()
    assert line in err and out == ""
    assert all(told.startswith("study.toml:") for told in err.splitlines())
    assert not runner.calls
    assert not (folder / "out").exists()


def test_a_contradiction_in_the_scene_names_the_values_that_make_it(
    folder, runner, capsys
):
    (folder / "study.toml").write_text(
        'scene = "scene.toml"\n[parameters]\nmesh.type = ["line", "file"]\n'
    )
    assert sweep() == 2
    assert "(with mesh.type = file)" in capsys.readouterr().err


def test_quantities_have_names_units_and_labels():
    found = [
        quantities.result(name)
        for name in (
            "T_fluid_out_K",
            "heat_wall_W",
            "k_eff [W/m/K]",
            "u_max",
            "porosity",
        )
    ]
    assert [q.header for q in found] == [
        "T_fluid_out [K]",
        "heat_wall [W]",
        "k_eff [W/m/K]",
        "u_max [m/s]",
        "porosity [-]",
    ]
    assert [q.label for q in found] == [
        r"$T_\mathrm{f}$ out [K]",
        "heat wall [W]",
        "k eff [W/m/K]",
        "$u$ max [m/s]",
        "porosity",
    ]
    assert (
        quantities.parameter("solids.particles.diameter", [0.1]).label
        == "solids.particles.diameter [m]"
    )
    assert (
        quantities.parameter("closures.nusselt", [2.0, "nusselt_gunn"]).header
        == "closures.nusselt"
    )
    assert (
        quantities.parameter("closures.nusselt", [2.0, 4.0]).header
        == "closures.nusselt [-]"
    )


@pytest.mark.parametrize(
    "text",
    [
        ALONE + "boundary.left.gas.velocity = [0.1, 0.2, 0.4]",
        ALONE
        + "boundary.left.gas.velocity = { from = -1, to = -0.1, count = 3, spacing = "
        "'log' }",
        ALONE + "solids.particles.shape = ['spheres', 'rods']",
        ALONE
        + "solids.particles.shape = ['spheres', 'rods']\nboundary.left.gas.velocity = "
        "[0.1, 0.2]",
        STUDY.replace(
            '["1 mm", "2 mm"]', '{ from = 1e-3, to = 1e-2, count = 3, spacing = "log" }'
        ),
        STUDY + "solids.particles.shape = ['spheres', 'rods']",
        STUDY + "mesh.length = [1, 2]\ngas.density = [1, 2]\ngas.viscosity = [1, 2]\n"
        "packed_bed.porosity = [0.3, 0.4]",
        SAMPLE.replace("count = 8", "count = 64"),
    ],
    ids=[
        "line",
        "negative log",
        "choice",
        "line for each choice",
        "contours",
        "effects",
        "six effects",
        "sample",
    ],
)
@pytest.mark.parametrize("failures", [0, 1])
def test_pictures_also_where_runs_failed(folder, runner, text, failures):
    (folder / "study.toml").write_text(text)
    runner.error = lambda scene: (
        ConvergenceError("no") if len(runner.calls) <= failures else None
    )
    assert sweep() == (3 if failures else 0)
    # the only other shape is left: nothing varies
    assert (folder / "out" / "sweep.png").exists() == (
        not (failures and len(runner.calls) == 2)
    )


def test_no_picture_where_nothing_varies(folder, runner):
    (folder / "study.toml").write_text(ALONE + "boundary.left.gas.velocity = [0.1]")
    assert sweep() == 0
    assert sorted(path.name for path in (folder / "out").iterdir()) == [
        ".contbed.study",
        "runs",
        "table.csv",
        "table.json",
    ]


def test_main_effects_of_a_sum_are_its_terms():
    """A product design of y = a + b: the mean over b at each a is a + mean(b), to
    round-off.
    """
    a, b = (
        grid.ravel() for grid in np.meshgrid([1.0, 2.0, 5.0], [0.0, 10.0, 40.0, 50.0])
    )
    levels, means = _means(
        _Axis(quantities.parameter("boundary.left.gas.velocity", a), a), a + b
    )
    assert_allclose(levels, [1.0, 2.0, 5.0])
    assert_allclose(means, [26.0, 27.0, 30.0], rtol=1e-14)
    axes = [
        _Axis(quantities.parameter("boundary.left.gas.velocity", a), values)
        for values in (a, b, 3.0 * a + 1.0)
    ]
    assert _is_plane([axes[0], axes[1]]) and not _is_plane([axes[0], axes[2]])
