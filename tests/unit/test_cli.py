"""The command line: exit codes and plain lines on stderr."""

import os
import subprocess
import sys
import types
from pathlib import Path

import pytest
from small_scenes import STEADY

import contbed
from contbed import cli
from contbed.errors import BalanceError, ClosureRangeError, ConvergenceError, SceneError
from tests.cases import each_case
from tests.command_line import command

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


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path / "scene.toml"


@pytest.fixture
def runner(monkeypatch):
    """A runner that only records its calls; `runner.error` is what it raises."""
    module = types.ModuleType("contbed.runner")
    module.calls, module.error = [], None

    def run(
        scene,
        out=None,
        quiet=False,
        restart=None,
        progress=None,
        engine="skfem",
        threads=None,
    ):
        module.calls.append((scene, out, quiet, restart))
        if module.error:
            raise module.error
        out.mkdir(parents=True, exist_ok=True)
        result = types.SimpleNamespace(
            summary={"qoi": {"pressure_drop": 2.0 / scene.diameter}}
        )
        result.table = lambda: "the table"
        return result

    module.run = run
    monkeypatch.setitem(sys.modules, "contbed.runner", module)
    return module


def python(*arguments):
    environment = {**os.environ, "PYTHONPATH": str(Path(contbed.__file__).parents[1])}
    return subprocess.run(
        [sys.executable, *arguments], env=environment, capture_output=True, text=True
    )


def test_the_command_itself(scene):
    """The entry point in a process of its own: help is fast and light, a bad scene
    ends with 2 and writes nothing.
    """
    scene.write_text(SCENE.replace("0.4", "4"))
    before = set(scene.parent.iterdir())
    done = python("-m", "contbed", "run", "scene.toml", "--out", "out")
    assert done.returncode == 2
    assert done.stdout == ""
    assert (
        done.stderr
        == "scene.toml:13: packed_bed.porosity = 4: out of range; allowed: a number > "
        "0 and < 1\n"
    )
    assert set(scene.parent.iterdir()) == before
    code = (
        "import sys; from contbed.cli import main; assert main(['--help']) == 0; "
        "print([m for m in ('numpy', 'pydantic', 'scipy', 'skfem', 'gmsh', 'CoolProp', "
        "'joblib') if m in sys.modules])"
    )
    done = python("-c", code)
    assert "converge" in done.stdout
    assert done.stdout.splitlines()[-1] in ("[]", "['numpy']")


def test_each_command_has_a_help_of_one_line(capsys):
    assert cli.main(["--help"]) == 0
    listed = capsys.readouterr().out.partition("Commands:")[2]
    assert len(listed.split()) > 60 and "..." not in listed


def test_check(scene, capsys):
    scene.write_text(SCENE.replace("velocity = 0.1", "velocity = 0"))
    assert command("check scene.toml") == 2
    assert capsys.readouterr().err == (
        "scene.toml:16: boundary.left.gas.velocity: nothing to solve: the gas is at "
        "rest and there is no [heat] table\n"
    )
    scene.write_text(STEADY)
    assert command("check scene.toml") == 0
    assert capsys.readouterr().out == "scene.toml: ok\n"
    assert (
        command(
            "check scene.toml no.toml --set packed_bed.porosity=2 --set 'boundary.left.gas.velocity=1 kg'"
        )
        == 2
    )
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines() == [
        "override: packed_bed.porosity = 2: out of range; allowed: a number > 0 and < 1",
        'override: boundary.left.gas.velocity = "1 kg": expected a velocity like '
        "'m/s', found '1 kg'",
        "no.toml:1: no such file",
    ]


def test_run(scene, runner, capsys):
    assert command("run scene.toml --set 'mesh.length=3 m'") == 0
    loaded, out, quiet, restart = runner.calls[-1]
    assert (loaded.mesh.length, str(out), quiet, restart) == (
        3.0,
        "results/scene",
        False,
        None,
    )
    assert "the table" in capsys.readouterr().out
    assert command("run scene.toml --out there --quiet --restart here") == 0
    assert [str(value) for value in runner.calls[-1][1:]] == ["there", "True", "here"]
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (SceneError(["a:1: b", "a:2: c"]), 2),
        (ConvergenceError("Newton stalled"), 3),
        (ClosureRangeError("Re"), 4),
        (BalanceError("mass"), 5),
        (KeyboardInterrupt(), 130),
        (OverflowError(34, "Numerical result out of range"), 3),
        (PermissionError(13, "Permission denied", "/there"), 1),
    ],
)
def test_each_error_has_its_exit_code_and_no_traceback(
    scene, runner, capsys, error, code
):
    runner.error = error
    assert command("run scene.toml") == code
    out, err = capsys.readouterr()
    assert out == ""
    assert err or code == 130
    assert "Traceback" not in err


@each_case(__file__, "usage_errors_end_with_2")
def test_usage_errors_end_with_2(scene, capsys, arguments):
    assert cli.main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert 1 <= len(err.splitlines()) <= 2


def test_a_quiet_plan_does_not_tell_that_it_compiles(tmp_path, capsys, monkeypatch):
    scene, told = tmp_path / "scene.toml", []
    scene.write_text(STEADY)
    monkeypatch.setattr(cli.commands, "_tell_when_compiling", told.append)
    assert command(f"plan {scene} --quiet") == 0
    assert "BUILT" in capsys.readouterr().out and not told
    assert command(f"plan {scene}") == 0 and len(told) == 1


def test_version_and_help(capsys):
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("contbed ")
    for name in (
        "run",
        "check",
        "plan",
        "explain",
        "list",
        "converge",
        "bench",
        "sweep",
        "calibrate",
        "warm",
        "new",
        "schema",
    ):
        assert command(f"{name} --help") == 0
        assert name in capsys.readouterr().out


@each_case(__file__, "explain")
def test_explain(capsys, name, part):
    assert command(f"explain {name}") == 0
    assert part in capsys.readouterr().out


def test_list_shows_everything_by_name(capsys):
    assert cli.main(["list"]) == 0
    out = capsys.readouterr().out
    for part in (
        "two_energy",
        "closures: nusselt",
        "nusselt_gunn",
        "boundary.NAME",
    ):
        assert part in out


def test_a_value_with_a_line_break_is_refused(tmp_path, capsys):
    """What follows the break would be other keys."""
    assert cli.main(["check", "scene.toml", "--set", "title=a\nb"]) == 2
    assert "has a line break" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("animate results", "ParaView"),
        ("validate --json", "summary.json"),
        ("sweep study.toml --scheduler tcp://host:8786", "on each machine"),
        ("explain --search heat", "contbed list"),
    ],
)
def test_what_is_gone_names_what_to_do_instead(capsys, line, told):
    assert command(line) == 2
    assert told in capsys.readouterr().err
