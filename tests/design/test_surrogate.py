"""Searches without gradients: a known function with noise, particles with seeds,
going on, what is refused.
"""

import sys
import types

import numpy as np
import pytest
from pytest import approx
from scipy.integrate import quad
from test_optimise import SCENE, optimise, summary

import contbed as cb
from contbed.errors import SceneError
from contbed.many.optimise import plots
from contbed.many.optimise.reading import read_design
from contbed.many.optimise.surrogate import expected_improvement
from contbed.models import MODELS
from tests.cases import each_case
from tests.refusals import refusal

pytest.importorskip(
    "sklearn", reason="scikit-learn is not installed: pip install 'contbed[surrogate]'"
)

DESIGN = """\
title = "Known optimum"
scene = "scene.toml"
method = "surrogate"
minimise = "u_max"
constraints = ["pressure_drop_Pa <= 0.7"]
[keys]
boundary.left.gas.velocity = { from = 0, to = 1, start = 0.8 }
packed_bed.porosity = { from = 0.2, to = 0.9, start = 0.3 }
"""
PARTICLES = """\
scene = "particles.toml"
maximise = "u_max"
[keys]
boundary.bottom.gas.velocity = { from = 1, to = 2 }
"""
NOISE = 0.01  # standard deviation of u_max of one run


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "particles.toml").write_text(
        MODELS["particles_gas"].template.read_text(encoding="utf-8")
    )
    (tmp_path / "design.toml").write_text(DESIGN)
    monkeypatch.setattr(plots, "plot", lambda *_: None)
    return tmp_path


@pytest.fixture
def runner(monkeypatch):
    """A runner of a parabola with noise, by default that of the point, and with it
    the same each time.
    """
    module = types.ModuleType("contbed.runner")
    module.calls, module.noise = [], NOISE

    def run(scene, out, quiet):
        module.calls.append(scene)
        if scene.kind == "particles_gas":
            v = scene.boundary.bottom.gas.velocity
            scatter = (
                module.noise
                * np.random.default_rng(scene.particles.seed).standard_normal()
            )
            return types.SimpleNamespace(
                summary={"qoi": {"u_max": 1.0 - (v - 1.4) ** 2 + scatter}}
            )
        x, y = scene.boundary["left"].gas.velocity, scene.packed_bed.porosity
        seed = int(1e6 * x) + int(1e12 * y)
        scatter = module.noise * np.random.default_rng(seed).standard_normal()
        f = (x - 0.3) ** 2 + (y - 0.6) ** 2 + scatter
        return types.SimpleNamespace(
            summary={"qoi": {"u_max": f, "pressure_drop_Pa": x + y}}
        )

    module.run = run
    monkeypatch.setitem(sys.modules, "contbed.runner", module)
    return module


def test_expected_improvement_is_its_integral():
    goal, mean, deviation = 1.0, 1.3, 0.5

    def density(f):
        return (
            (goal - f)
            * np.exp(-0.5 * ((f - mean) / deviation) ** 2)
            / deviation
            / np.sqrt(2.0 * np.pi)
        )

    exact = quad(density, mean - 10 * deviation, goal, epsabs=1e-14)[0]
    assert expected_improvement(goal, np.array([mean]), np.array([deviation]))[
        0
    ] == approx(exact, rel=1e-10)


def test_a_known_optimum_with_noise_under_a_constraint(folder, runner, capsys):
    """(x - 0.3)^2 + (y - 0.6)^2 is least on x + y = 0.7 at (0.2, 0.5), where it is
    0.02: two standard deviations.
    """
    assert optimise() == 0
    found = summary(folder)
    x, y = (
        found["keys"][name]["value"]
        for name in ("boundary.left.gas.velocity", "packed_bed.porosity")
    )
    assert x + y <= 0.7 + 1e-3
    # noise of 0.01 hides distances of 0.1 of one run; a fit to some tens of them halves
    # that
    assert (x, y) == approx((0.2, 0.5), abs=0.06)
    expected = found["surrogate"]["u_max"]
    assert (
        abs(expected["expected"] - 0.02)
        < 3.0 * expected["standard_error"]
        < 3.0 * NOISE
    )
    assert found["status"] == "settled" and found["constraints"][0]["active"]
    assert "by Gaussian processes: u_max there 0.0" in capsys.readouterr().out
    assert len(runner.calls) == found["runs"]["evaluated"] < 60


def test_without_noise_the_optimum_is_close(folder, runner):
    runner.noise = 0.0
    assert optimise() == 0
    found = summary(folder)
    # improvements below 1e-3 of the range of f, 0.6, are not looked for: sqrt(6e-4) =
    # 0.024 from the optimum
    values = [
        found["keys"][name]["value"]
        for name in ("boundary.left.gas.velocity", "packed_bed.porosity")
    ]
    assert values == approx([0.2, 0.5], abs=0.025)


def test_particles_take_a_surrogate_and_repeats_by_themselves(folder, runner, capsys):
    (folder / "design.toml").write_text(PARTICLES)
    assert optimise() == 0
    found = summary(folder)
    assert found["method"] == "surrogate" and found["surrogate"]["runs_at_a_point"] == 3
    assert "as results scatter" in capsys.readouterr().out
    assert len(runner.calls) == 3 * found["runs"]["evaluated"]
    assert {scene.particles.seed for scene in runner.calls} == {0, 1, 2}
    # the same three seeds at each point: their mean shifts all values alike and moves
    # no optimum
    assert found["keys"]["boundary.bottom.gas.velocity"]["value"] == approx(
        1.4, abs=0.05
    )
    calls = len(runner.calls)
    assert optimise() == 0  # again: the same search, no run
    assert summary(folder)["keys"] == found["keys"] and len(runner.calls) == calls
    # as if killed: half of the runs are not there
    for path in list((folder / "out" / "runs").iterdir())[::2]:
        (path / "outcome.json").unlink()
    assert optimise() == 0
    assert (
        summary(folder)["keys"] == found["keys"]
        and calls < len(runner.calls) < 2 * calls
    )


@pytest.mark.slow
def test_beads_that_gas_nearly_carries(folder):
    """The lowest velocity at which 80 beads take a pressure drop of 90 Pa, of the
    115 Pa that carry them.
    """
    text = (folder / "particles.toml").read_text()
    for old, new in (("count = 300", "count = 80"), ('["12 mm", "12 mm"]', '["8 mm", '
                                                                           '"8 mm"]'), ("0.08 m", "0.05 m"),
                     ('end = "0.06 s"', 'end = "0.04 s"'), ('from = "0.03 s"', 'from = "0.02 s"')):  # fmt: skip
        assert old in text
        text = text.replace(old, new)
    (folder / "particles.toml").write_text(text)
    lines = [
        'scene = "particles.toml"',
        'minimise = "boundary.bottom.gas.velocity"',
        """constraints = ['"pressure_drop [Pa]" >= 90']""",
    ]
    (folder / "design.toml").write_text(
        "\n".join(
            [*lines, "[keys]", "boundary.bottom.gas.velocity = { from = 1, to = 2 }"]
        )
    )
    assert optimise() == 0
    found = summary(folder)
    v = found["keys"]["boundary.bottom.gas.velocity"]["value"]
    drop = next(
        one for name, one in found["surrogate"].items() if "pressure_drop" in name
    )
    assert 0.0 < drop["standard_error"] < 5.0
    means = []
    for seed in range(10, 16):  # others than those of the search
        scene = cb.load(
            folder / "particles.toml",
            {"boundary.bottom.gas.velocity": v, "particles.seed": seed},
        )
        means.append(cb.run(scene).qoi["pressure_drop [Pa]"])
    # standard error of the mean of six and of the prediction
    error = np.hypot(np.std(means, ddof=1) / np.sqrt(6), drop["standard_error"])
    assert abs(np.mean(means) - 90.0) < 3.0 * error


def test_whole_numbers_are_tried_once(folder, runner):
    text = DESIGN.replace(
        "from = 0, to = 1, start = 0.8", "from = 0, to = 3, start = 1, integer = true"
    )
    (folder / "design.toml").write_text(text.replace("<= 0.7", "<= 2"))
    runner.noise = 0.0
    assert optimise() == 0
    found = summary(folder)
    assert found["keys"]["boundary.left.gas.velocity"]["value"] == 0
    assert found["keys"]["packed_bed.porosity"]["value"] == approx(0.6, abs=0.03)


def test_what_no_point_fulfils(folder, runner, capsys):
    (folder / "design.toml").write_text(DESIGN.replace("<= 0.7", "<= 0.1"))
    assert optimise() == 3
    assert summary(folder)["status"] == "infeasible"
    # x + y is 0.2 at the least
    assert '"pressure_drop_Pa <= 0.1" by 0.1' in capsys.readouterr().out


def test_runs_that_fail_are_left_out(folder, runner):
    runner.noise = 0.0
    kept = runner.run

    def run(scene, out, quiet):
        if (
            scene.boundary["left"].gas.velocity > 0.7
            and scene.packed_bed.porosity > 0.5
        ):
            raise SceneError("too fast")
        return kept(scene, out, quiet)

    runner.run = run
    assert optimise() == 0
    assert summary(folder)["runs"]["failed"] > 0


@each_case(__file__, "mistakes")
def test_mistakes(folder, old, new, told):
    assert old in DESIGN
    (folder / "design.toml").write_text(DESIGN.replace(old, new))
    assert told in refusal(read_design, "design.toml")


def test_what_to_install_is_told_before_any_run(folder, runner, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "sklearn", None)
    assert optimise() == 1
    assert (
        "needs scikit-learn: pip install 'contbed[surrogate]'"
        in capsys.readouterr().err
    )
    assert runner.calls == []
