"""The command `contbed optimise` on a model in closed form: reading, files, what is
told, going on after a kill.
"""

import json
import os
import signal
import subprocess
import sys
import textwrap
import types
from pathlib import Path

import numpy as np
import pytest
from pytest import approx

import contbed as cb
from contbed import cli
from contbed.errors import ConvergenceError, SceneError
from contbed.many.optimise import evaluations, plots
from contbed.many.optimise.expression import read_expression
from contbed.many.optimise.reading import read_design
from tests.cases import each_case
from tests.command_line import command
from tests.numbers_of import table_of
from tests.refusals import problems_of, refusal
from tests.report.report_file import charts_of

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

[output]
plots = false
"""
DESIGN = """\
title = "Fast flow"
scene = "scene.toml"
maximise = "boundary.left.gas.velocity"
constraints = ["pressure_drop_Pa <= 0.1 kPa", "u_max <= 0.4"]
[keys]
boundary.left.gas.velocity = { from = "5 cm/s", to = 0.5 }
solids.particles.diameter = { from = "1 mm", to = "4 mm" }
"""


def model(scene):
    """Pressure drop 2000 v^2/(d/1 mm) [Pa] and largest velocity v + 10 d [m/s]."""
    v, d = scene.boundary["left"].gas.velocity, scene.diameter
    return {
        "pressure_drop_Pa": 2000.0 * v**2 / (1e3 * d),
        "u_max": v + 10.0 * d,
        "heat_wall_W": 3.0,
    }


def slopes(scene, qoi, keys):
    """Derivatives of `model`."""
    v, d = scene.boundary["left"].gas.velocity, scene.diameter
    drop = 2000.0 * v**2 / (1e3 * d)
    table = {
        "pressure_drop_Pa": {
            "boundary.left.gas.velocity": 4.0 * v / d,
            "solids.particles.diameter": -drop / d,
        },
        "u_max": {"boundary.left.gas.velocity": 1.0, "solids.particles.diameter": 10.0},
        "heat_wall_W": {
            "boundary.left.gas.velocity": 0.0,
            "solids.particles.diameter": 0.0,
        },
    }
    derivatives = np.array([[table[name][key] for key in keys] for name in qoi])
    return types.SimpleNamespace(
        derivatives=derivatives, standard_errors=None, method="tangent"
    )


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "design.toml").write_text(DESIGN)
    return tmp_path


@pytest.fixture
def runner(monkeypatch):
    """A runner that records its calls; `runner.error(scene)` may return what it
    raises.
    """
    module = types.ModuleType("contbed.runner")
    module.calls, module.gradients, module.error, module.model = (
        [],
        [],
        lambda scene: None,
        model,
    )

    def run(scene, out, quiet):
        module.calls.append(scene)
        if error := module.error(scene):
            raise error
        out.mkdir(parents=True, exist_ok=True)
        return types.SimpleNamespace(summary={"qoi": module.model(scene)})

    def gradient(scene, qoi, keys):
        module.gradients.append(scene)
        return slopes(scene, qoi, keys)

    module.run = run
    monkeypatch.setitem(sys.modules, "contbed.runner", module)
    monkeypatch.setattr(evaluations, "gradient", gradient)
    module.plot = plots.plot
    monkeypatch.setattr(plots, "plot", lambda *_: None)
    return module


def optimise(*arguments):
    return cli.main(["optimise", "design.toml", "--out", "out", *arguments])


def change(folder, *pairs):
    text = (folder / "design.toml").read_text()
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    (folder / "design.toml").write_text(text)


def summary(folder):
    return json.loads((folder / "out" / "summary.json").read_text())


def test_the_optimum_its_prices_and_files(folder, runner, capsys, monkeypatch):
    """Both constraints are active: v = 0.4 - 10 d and 2000 v^2 = P (1000 d), with
    P = 100 Pa.
    """

    def fastest_at(pressure):
        return 0.4 - 10.0 * min(np.roots([100.0, -8.0 - 0.5 * pressure, 0.16]))

    monkeypatch.setattr(plots, "plot", runner.plot)
    assert optimise() == 0
    v = fastest_at(100.0)
    d = 0.04 - 0.1 * v
    found = summary(folder)
    assert found["status"] == "optimum"
    assert found["keys"]["boundary.left.gas.velocity"]["value"] == approx(v, rel=1e-8)
    assert found["keys"]["solids.particles.diameter"]["value"] == approx(d, rel=1e-7)
    assert found["objective"]["value"] == approx(v, rel=1e-8)
    assert found["objective"]["unit"] == "m/s"
    pressure, fastest = found["constraints"]
    assert pressure["active"] and fastest["active"]
    slope = (fastest_at(100.01) - fastest_at(99.99)) / 0.02
    assert pressure["price"] == approx(slope, rel=1e-6)  # of central differences
    assert pressure["price_unit"] == "m/s per Pa"
    assert pressure["bound"] == 100.0
    assert "u_max <= 0.4" in fastest["constraint"]
    scene = cb.load(folder / "out" / "optimum.toml")
    assert scene.boundary["left"].gas.velocity == approx(v, rel=1e-8)
    assert scene.packed_bed.porosity == 0.4
    rows = table_of(folder / "out" / "table.csv")
    assert len(rows) == len(runner.calls) == found["runs"]["evaluated"]
    assert rows[0]["boundary.left.gas.velocity [m/s]"] == "0.1"
    # as it is maximised, not its negative
    assert rows[0]["boundary.left.gas.velocity: objective [m/s]"] == "0.1"
    assert float(rows[0]["pressure_drop [Pa]"]) == approx(2000.0 * 0.01 / 3.0)
    assert (folder / "out" / "convergence.png").read_bytes()[:4] == b"\x89PNG"
    text, warned = capsys.readouterr()
    assert warned == ""
    assert (
        '"pressure_drop_Pa <= 0.1 kPa": 10 Pa more allowed changes '
        "boundary.left.gas.velocity by +0.0" in text
    )
    assert text.splitlines()[-1].startswith(
        f"{len(rows)} evaluations, 0 were before, 0 failed"
    )
    pytest.importorskip(
        "plotly", reason="plotly is not installed: pip install 'contbed[report]'"
    )
    assert command("report out") == 0
    report = (folder / "out" / "report.html").read_text()
    assert (
        "Fast flow" in report
        and f"<code>boundary.left.gas.velocity</code>: {v:.6g} m/s" in report
    )
    assert (
        "active constraints: pressure_drop_Pa &lt;= 0.1 kPa, u_max &lt;= 0.4" in report
    )
    assert f"{pressure['price']:.6g}" in report and "m/s per Pa" in report
    charts = charts_of(report)
    assert "data:image/png;base64," in report
    assert [chart["kind"] for chart in charts] == ["parallel", "matrix"]
    assert len(charts[-1]["data"][0]["text"]) == len(rows)
    assert command("report out out") == 1
    assert "a report shows one search for an optimum" in capsys.readouterr().err


def test_a_second_call_computes_nothing(folder, runner):
    assert optimise() == 0
    first = summary(folder)
    calls, gradients = len(runner.calls), len(runner.gradients)
    assert optimise() == 0
    assert (len(runner.calls), len(runner.gradients)) == (calls, gradients)
    second = summary(folder)
    assert second["runs"]["before"] == calls and first["runs"]["before"] == 0
    assert {**second, "runs": 0} == {**first, "runs": 0}


def test_a_failed_run_is_stepped_back_from_and_told(folder, runner, capsys):
    runner.error = lambda scene: (
        ConvergenceError("no convergence here")
        if scene.boundary["left"].gas.velocity > 0.3723
        else None
    )
    assert optimise() == 0
    captured = capsys.readouterr()
    assert (
        "warning: stepped back to" in captured.err
        and "no convergence here" in captured.err
    )
    found = summary(folder)
    assert found["runs"]["failed"] >= 1 and found["warnings"]
    assert found["keys"]["boundary.left.gas.velocity"]["value"] == approx(
        0.3723, abs=1e-4
    )
    rows = table_of(folder / "out" / "table.csv")
    failed = [row for row in rows if row["exit code"] == "3"]
    assert failed and failed[0]["problem"] == "no convergence here"
    # a failed run is kept, until it is asked for again
    calls = len(runner.calls)
    runner.error = lambda scene: None
    assert optimise() == 0 and len(runner.calls) == calls
    assert optimise("--retry-failed") == 0 and len(runner.calls) > calls


def test_a_start_that_fails_is_told(folder, runner, capsys):
    runner.error = lambda scene: ConvergenceError("no convergence here")
    assert optimise() == 3
    assert (
        "the run at the start failed: no convergence here; give a start"
        in capsys.readouterr().err
    )


def test_constraints_that_cannot_hold_are_named_with_the_miss(folder, runner, capsys):
    change(folder, ("u_max <= 0.4", "u_max >= 0.7"))
    assert optimise() == 3
    told, warned = capsys.readouterr()
    # u_max = v + 10 d is linear: 0.54 at the largest v and d
    text = (
        '"u_max >= 0.7" is missed by 0.57 m/s at the start and, by the gradient '
        "there, by 0.16 m/s at the best point"
    )
    assert f"design.toml:4: {text}" in warned and "pressure_drop_Pa" not in warned
    assert 'the nearest misses "pressure_drop_Pa <= 0.1 kPa" by 22.' in told
    assert '"u_max >= 0.7" by 0.16' in told
    found = summary(folder)
    assert found["status"] == "infeasible"
    assert found["constraints"][1]["missed_by"] > 0.0
    assert found["costs"] == []


def test_as_many_runs_as_are_allowed(folder, runner, capsys):
    (folder / "design.toml").write_text("runs = 3\n" + DESIGN)
    assert optimise() == 3
    assert "all 3 runs are computed; raise runs" in capsys.readouterr().out
    assert summary(folder)["status"] == "not converged"
    calls = len(runner.calls)
    (folder / "design.toml").write_text(DESIGN)
    assert optimise() == 0
    assert summary(folder)["runs"]["before"] == calls == 3


def test_formulas_with_prices_and_whole_numbers(folder, runner):
    """The pressure drop asks for d >= 2 mm at any velocity, u_max for 1 m/s."""
    cost = (
        '{ formula = "2*boundary.left.gas.velocity + solids.particles.diameter", '
        'unit = "EUR" }'
    )
    change(
        folder,
        ('maximise = "boundary.left.gas.velocity"', f"minimise = {cost}"),
        (
            "pressure_drop_Pa <= 0.1 kPa",
            "pressure_drop_Pa <= 1e3 * gas.density * boundary.left.gas.velocity**2",
        ),
        ('from = "5 cm/s", to = 0.5', "from = 0, to = 3, start = 2, integer = true"),
        ("u_max <= 0.4", "u_max >= 1.01"),
    )
    assert optimise() == 0
    found = summary(folder)
    assert found["keys"]["boundary.left.gas.velocity"]["value"] == 1
    assert found["keys"]["solids.particles.diameter"]["value"] == approx(2e-3, rel=1e-6)
    assert found["objective"]["unit"] == "EUR"
    assert found["constraints"][0]["bound"] == approx(1e3)
    assert "all 4 choices of integers were tried" in found["verdict"]


@each_case(__file__, "mistakes")
def test_mistakes_are_told_before_any_run(folder, runner, capsys, old, new, told):
    change(folder, (old, new))
    assert optimise() == 2
    assert told in capsys.readouterr().err
    assert runner.calls == [] and not (folder / "out").exists()


def test_a_result_that_the_run_does_not_have_is_told_after_one_run(
    folder, runner, capsys
):
    change(folder, ("u_max <= 0.4", "T_fluid_out_K <= 400"))
    assert optimise() == 2
    assert (
        'design.toml:4: the run has no result "T_fluid_out_K"; allowed: '
        "pressure_drop_Pa" in capsys.readouterr().err
    )
    assert len(runner.calls) == 1


def test_all_mistakes_at_once(folder):
    change(
        folder,
        ("u_max <= 0.4", "u_max < 0.4"),
        ("boundary.left.gas.velocity = {", "boundary.left.gas.velosity = {"),
    )
    with pytest.raises(SceneError) as caught:
        read_design("design.toml")
    # the keys come first, as units of constraints follow from them
    assert len(caught.value.problems) == 1
    change(
        folder,
        ("boundary.left.gas.velosity = {", "boundary.left.gas.velocity = {"),
        ('maximise = "boundary', 'maximise = "boundar'),
    )
    assert len(problems_of(read_design, "design.toml")) == 2


UNITS = {
    "mesh.length": "m",
    "pressure_drop_Pa": "Pa",
    "boundary.left.gas.velocity": "m/s",
    "k_eff [W/m/K]": "W/m/K",
    "Nu": "1",
}


def test_bounds_of_a_constant_of_a_formula_have_units(tmp_path):
    """It starts at the text of the scene."""
    decay = """
reactions.decay = { equation = "A -> B", rate = "k*c_A", basis = "bed", parameters = { k = "6 1/min" } }
"""
    gas = """
model = "ideal_gas"
composition = "A:0.1, N2:0.9"
species = { A = { elements.C = 1 }, B = { elements.C = 1 }, N2 = {} }
"""
    scene = decay + SCENE.replace("density = 1\nviscosity = 2e-5\n", gas)
    scene = scene.replace(
        "gas.velocity = 0.1", "gas = { velocity = 0.1, temperature = 500 }"
    )
    (tmp_path / "scene.toml").write_text(scene, encoding="utf-8")
    bounds = 'reactions.decay.parameters.k = { from = "3 1/min", to = 0.5 }'
    design = f'scene = "scene.toml"\nmaximise = "conversion_A"\n[keys]\n{bounds}\n'
    (tmp_path / "file.toml").write_text(design, encoding="utf-8")
    (key,) = read_design(tmp_path / "file.toml").keys
    assert (key.low, key.high, key.start) == (approx(0.05), 0.5, approx(0.1))


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [
        ("mesh.length", 1.5, "m"),
        ("2*mesh.length + 0.3", 3.3, "m"),
        ("pressure_drop_Pa * boundary.left.gas.velocity", 2.25, "W/m**2"),
        ('0.5*"k_eff [W/m/K]" + 1e-1', 0.85, "W/m/K"),
        ("max(mesh.length, 1e-3)/boundary.left.gas.velocity", 1.0, "s"),
        ("exp(-Nu)*mesh.length**2", 2.25 * np.exp(-1.5), "m**2"),
        ("Nu - sqrt(Nu)", 1.5 - 1.5**0.5, "1"),
    ],
)
def test_formulas_have_values_units_and_derivatives(text, value, unit):
    found = read_expression(text, UNITS.__getitem__)
    at = dict.fromkeys(UNITS, 1.5)
    assert (found(at), found.unit) == (approx(value, rel=1e-14), unit)
    for name, slope in found.derivatives(at).items():
        h = 1e-6
        difference = (found({**at, name: 1.5 + h}) - found({**at, name: 1.5 - h})) / (
            2.0 * h
        )
        assert slope == approx(difference, rel=1e-8, abs=1e-9)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "(mesh.length - 900 Pa)**2",
            "'900 Pa': a number in a formula has no unit; write it in SI",
        ),
        ("mesh.length pressure_drop_Pa", "cannot be read as a formula"),
        ("mesh.length(2)", "there is no function 'mesh.length' for formulas"),
    ],
)
def test_what_is_no_formula_is_told_with_its_names(text, told):
    assert refusal(read_expression, text, UNITS.__getitem__).startswith(told)


KILLED = """
import os, signal, sys
sys.path[:0] = {paths}
import test_optimise as t
from contbed import cli, runner
from contbed.many.optimise import evaluations, plots
evaluations.gradient = t.slopes
kept, count = runner.run, 0
def run(scene, out, quiet):
    global count
    count += 1
    if count == {last}:
        os.kill(os.getpid(), signal.SIGKILL)
    import types
    return types.SimpleNamespace(summary={{"qoi": t.model(scene)}})
runner.run = run
sys.exit(cli.main(["optimise", "design.toml", "--out", "out"]))
"""


@pytest.mark.skipif(os.name == "nt", reason="needs SIGKILL")
def test_a_killed_search_goes_on_and_computes_no_run_twice(folder, runner):
    whole = command("optimise design.toml --out whole")
    assert whole == 0
    calls = len(runner.calls)
    paths = [str(Path(__file__).parent), str(Path(cb.__file__).parents[1])]
    code = textwrap.dedent(KILLED.format(paths=paths, last=4))
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == -signal.SIGKILL, done.stderr
    assert not (folder / "out" / "summary.json").exists()
    assert (folder / "out" / "table.csv").exists()  # of the three that had ended
    runner.calls.clear()
    assert optimise() == 0
    assert len(runner.calls) == calls - 3
    same = json.loads((folder / "whole" / "summary.json").read_text())
    assert {**summary(folder), "runs": 0} == {**same, "runs": 0}


def test_a_gradient_that_fails_on_the_way_loses_nothing(folder, runner, monkeypatch):
    def gradient(scene, qoi, keys):
        if scene.boundary["left"].gas.velocity > 0.3723:
            raise SceneError("no room for a step")
        return slopes(scene, qoi, keys)

    monkeypatch.setattr(evaluations, "gradient", gradient)
    assert optimise() in (0, 3)
    assert any(
        "no gradient: no room for a step" in text
        for text in summary(folder)["warnings"]
    )
    monkeypatch.setattr(
        evaluations,
        "gradient",
        lambda *_: gradient(
            cb.load("scene.toml", {"boundary.left.gas.velocity": 1}), [], []
        ),
    )
    (folder / "out" / "summary.json").unlink()
    # a key without derivative is told at once
    assert command("optimise design.toml --out fresh") == 2
