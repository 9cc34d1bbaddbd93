"""Runs that are stopped: by a signal, a full disk, a state that does not exist, a
balance that stays open.

A restarted run must give the numbers of an uninterrupted one bit for bit: steps sit on
a ladder of integers, every sum is continued in the same order, and the checkpoint holds
doubles. So all comparisons here are of bytes.
"""

import contextlib
import io
import json
import os
import random
import re
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest

import contbed as cb
from contbed import cli
from contbed.loading import loads
from contbed.output import checkpoint
from contbed.output.tables import read_table
from contbed.packed_bed.time_steps import HeatSteps
from tests.cases import each_case
from tests.command_line import command
from tests.refusals import refused
from tests.restarts import interrupt, same_run

SCENE = """\
[mesh]
type = "line"
length = 1.0
cells = 40

[gas]
density = 1.0
heat_capacity = 1000.0
conductivity = 0.05
viscosity = 2e-5

[solids.particles]
density = 2000.0
heat_capacity = 900.0
conductivity = 1.0
diameter = 0.01

[packed_bed]
porosity = 0.4

[closures]
nusselt = "wakao_kaguei"

[heat]

[boundary.left]
gas.velocity = 0.3
gas.temperature = 300.0

[boundary.right]
solids.particles.velocity = 1e-4
solids.particles.temperature = 500.0

[initial]
gas.temperature = 300.0
solids.particles.temperature = 500.0

[time]
end = 1500.0
times = [1.0, 100.0, 1000.0]
step = 0.5
checkpoint_every = 0.02

[output]
plots = false
fields = false
"""
ADAPTIVE = SCENE.replace("step = 0.5\n", "")
NONLINEAR = (
    SCENE.replace("end = 1500.0", "end = 1010.0")
    .replace("step = 0.5", "step = 50.0")
    .replace("heat_capacity = 900.0", "heat_capacity = [600.0, 0.6]")
)
COMMAND = [sys.executable, "-m", "contbed", "run", "--quiet"]


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """Of the scene with shorter steps, which runs for 0.5 s after its first
    checkpoint: kills come within 0.2 s.
    """
    path = tmp_path_factory.mktemp("scene") / "bed.toml"
    path.write_text(SCENE.replace("step = 0.5", "step = 0.2"))
    return path


@pytest.fixture(scope="module")
def whole(scene, tmp_path_factory):
    """Folder of the uninterrupted run."""
    folder = tmp_path_factory.mktemp("whole")
    assert finish(scene, "--out", folder)[0] == 0
    return folder


def finish(scene, *options) -> tuple[int, str]:
    """Exit code and stderr of a run in this process."""
    told = io.StringIO()
    with contextlib.redirect_stderr(told):
        code = cli.main(["run", "--quiet", *map(str, (scene, *options))])
    return code, told.getvalue()


def start_until_checkpoint(scene: Path, folder: Path) -> subprocess.Popen:
    """A run that has written a checkpoint; shells let what they start in the
    background ignore interrupts.
    """
    run = subprocess.Popen(
        [*COMMAND, str(scene), "--out", str(folder)],
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    while run.poll() is None and not (folder / "checkpoint.npz").exists():
        time.sleep(0.001)
    return run


def same(folder: Path, other: Path) -> None:
    assert (folder / "profiles.csv").read_bytes() == (
        other / "profiles.csv"
    ).read_bytes()
    one, two = (json.loads((f / "summary.json").read_text()) for f in (folder, other))
    for key in ("status", "balances", "qoi", "closures", "warnings"):
        assert one[key] == two[key], key


@pytest.mark.parametrize(
    "text", [SCENE, ADAPTIVE, NONLINEAR], ids=["fixed step", "adaptive", "nonlinear"]
)
@pytest.mark.parametrize("call", [2, 17])
def test_a_then_b_is_ab(text, call, tmp_path):
    scene = loads(text.replace("end = 1500.0", "end = 1001.0"))
    whole = cb.run(scene, out=tmp_path / "ab")
    interrupt(scene, tmp_path / "a", HeatSteps, "passed", call)
    stopped = json.loads((tmp_path / "a" / "summary.json").read_text())
    assert stopped["status"] == "interrupted"
    # what was reached is balanced and can be looked at
    assert abs(stopped["balances"]["energy"]["relative_residual"]) <= 1e-10
    reached = read_table(tmp_path / "a" / "profiles.csv")["t [s]"][-1]
    # a table has 12 digits
    assert reached == pytest.approx(stopped["qoi"]["time_reached_s"], rel=1e-11)
    restarted = cb.run(scene, out=tmp_path / "b", restart=tmp_path / "a")
    same_run(restarted, whole)
    same(tmp_path / "b", tmp_path / "ab")


def test_restart_of_a_finished_run_changes_nothing(scene, whole, tmp_path):
    assert finish(scene, "--restart", whole, "--out", tmp_path)[0] == 0
    same(tmp_path, whole)


def killed(scene: Path, folder: Path, delay: float) -> None:
    run = start_until_checkpoint(scene, folder)
    time.sleep(delay)
    run.kill()
    assert run.wait() == -signal.SIGKILL
    run.stderr.close()


@pytest.mark.parametrize(
    "seed", [1, 2, *(pytest.param(k, marks=pytest.mark.slow) for k in range(3, 11))]
)
def test_kill_at_any_moment(scene, whole, tmp_path, seed):
    killed(scene, tmp_path, random.Random(seed).uniform(0.0, 0.2))
    assert finish(scene, "--restart", tmp_path)[0] == 0
    same(tmp_path, whole)


def test_kill_while_a_checkpoint_is_written(scene, whole, tmp_path):
    """The third checkpoint is left half written."""
    code = """
        import os, signal, sys, zipfile
        real, calls = zipfile.ZipFile, []
        def fatal(*args, **kwargs):
            calls.extend(args[:1] * os.path.basename(args[0]).startswith("checkpoint"))
            if len(calls) == 3:
                with open(args[0], "wb") as part:
                    part.write(b"PK half a file")
                os.kill(os.getpid(), signal.SIGKILL)
            return real(*args, **kwargs)
        zipfile.ZipFile = fatal
        from contbed.cli import main
        main(["run", "--quiet", sys.argv[1], "--out", sys.argv[2]])
    """
    run = [sys.executable, "-c", textwrap.dedent(code), str(scene), str(tmp_path)]
    assert subprocess.run(run, capture_output=True).returncode == -signal.SIGKILL
    assert len(list(tmp_path.glob("checkpoint.npz.*.part"))) == 1
    assert json.loads((tmp_path / "summary.json").read_text())["status"] == "running"
    assert finish(scene, "--restart", tmp_path)[0] == 0
    assert not list(tmp_path.glob("*.part"))
    same(tmp_path, whole)


def test_kill_before_the_first_checkpoint(scene, tmp_path):
    code, message = finish(scene, "--restart", tmp_path)
    assert code == 2
    assert (
        message
        == f"{tmp_path}: no checkpoint.npz to restart from; run the scene without "
        "--restart\n"
    )
    code, message = finish(scene, "--restart", tmp_path / "nothing")
    assert (code, message) == (
        2,
        f"{tmp_path / 'nothing'}: no such folder to restart from\n",
    )
    assert not (tmp_path / "nothing").exists()


def test_interrupt_leaves_the_last_state(scene, whole, tmp_path):
    run = start_until_checkpoint(scene, tmp_path)
    run.send_signal(signal.SIGINT)
    _, message = run.communicate(timeout=60)
    hint = f"interrupted; to resume: contbed run {scene} --restart {tmp_path}\n"
    assert (run.returncode, message) == (130, hint)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["status"] == "interrupted"
    assert summary["qoi"]["time_steps"] > 0
    assert abs(summary["balances"]["energy"]["relative_residual"]) <= 1e-10
    assert (tmp_path / "profiles.csv").exists()
    assert finish(scene, "--restart", tmp_path)[0] == 0
    same(tmp_path, whole)


def test_the_way_on_has_the_settings_of_the_run(scene, tmp_path, capsys, monkeypatch):
    """A scene without them is another one, with which the checkpoint is refused."""
    monkeypatch.setattr("contbed.runner.run", stopped_after_a_checkpoint)
    settings = [
        "--set",
        "boundary.left.gas.velocity=0.31",
        "--set",
        "title=a b",
        "--allow-large",
    ]
    assert (
        cli.main(["run", str(scene), "--out", str(tmp_path), "--quiet", *settings])
        == 130
    )
    changes = "--set boundary.left.gas.velocity=0.31 --set 'title=a b'"
    way = f"contbed run {scene} {changes} --allow-large --restart {tmp_path}"
    assert capsys.readouterr().err == f"interrupted; to resume: {way}\n"


def test_an_earlier_checkpoint_is_no_way_on(scene, tmp_path, capsys, monkeypatch):
    (tmp_path / "checkpoint.npz").touch()
    os.utime(tmp_path / "checkpoint.npz", (1e9, 1e9))

    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("contbed.runner.run", stopped)
    assert command(f"run {scene} --out {tmp_path} --quiet") == 130
    assert capsys.readouterr().err == "interrupted\n"
    assert command(f"run {scene} --restart {tmp_path} --quiet") == 130
    assert capsys.readouterr().err.startswith("interrupted; to resume: contbed run")


def stopped_after_a_checkpoint(_, out, **__):
    """Run that is interrupted."""
    (out / "checkpoint.npz").touch()
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    "text", [SCENE, ADAPTIVE, NONLINEAR], ids=["fixed step", "adaptive", "nonlinear"]
)
def test_a_run_goes_on_to_a_later_end_and_other_output_times(text, tmp_path):
    long = (
        text.replace("end = 1500.0", "end = 600.0")
        .replace("1000.0]", "550.0]")
        .replace("end = 1010.0", "end = 600.0")
    )
    short = long.replace("end = 600.0", "end = 500.0").replace(
        "[1.0, 100.0, 550.0]", "[1.0, 50.0, 100.0]"
    )
    whole = cb.run(loads(long))
    cb.run(loads(short), out=tmp_path)
    found = cb.run(loads(long), out=tmp_path, restart=tmp_path)
    assert (
        found.status == "ok"
        and abs(found.balances["energy"]["relative_residual"]) <= 1e-10
    )
    assert list(dict.fromkeys(found.profiles["t [s]"])) == [1.0, 100.0, 550.0, 600.0]
    for name, column in whole.profiles.items():
        assert np.allclose(column, found.profiles[name], rtol=2e-3, atol=0.05), name
    later = read_table(tmp_path / "profiles.csv")["t [s]"]
    assert later[-1] == 600.0


@pytest.mark.parametrize("refine", [0, 1])
def test_a_run_goes_on_on_the_mesh_that_it_began_on(refine, tmp_path):
    """The cells of an automatic line follow end and output times; a run that goes on
    keeps those of its checkpoint.

    Another run to the same end on another mesh differs by the errors of both, below
    1e-3 of the span of 200 K.
    """
    short = SCENE.replace("cells = 40", f"refine = {refine}").replace(
        "end = 1500.0", "end = 300.0"
    )
    short = re.sub(r"times = .*\n", "", short)
    long = short.replace("end = 300.0", "end = 1500.0\ntimes = [1400.0]")
    first, whole = cb.run(loads(short), out=tmp_path), cb.run(loads(long))
    found = cb.run(loads(long), out=tmp_path, restart=tmp_path)
    assert not np.array_equal(first.plan.mesh.skfem.p, whole.plan.mesh.skfem.p)
    assert np.array_equal(found.plan.mesh.skfem.p, first.plan.mesh.skfem.p)
    assert found.qoi["T_fluid_out_K"] == pytest.approx(
        whole.qoi["T_fluid_out_K"], abs=0.2
    )


def test_what_has_passed_cannot_be_asked_for(tmp_path):
    text = SCENE.replace("end = 1500.0", "end = 200.0").replace(
        "100.0, 1000.0]", "100.0]"
    )
    cb.run(loads(text), out=tmp_path)
    before = json.loads((tmp_path / "summary.json").read_text())
    refused(
        r"scene\.toml:\d+: time.end = 150: lies before 200 s",
        lambda: cb.run(
            loads(text.replace("end = 200.0", "end = 150.0")), restart=tmp_path
        ),
    )
    refused(
        r"scene\.toml:\d+: time.times: 60 s lies before 200 s, .* was not kept",
        lambda: cb.run(
            loads(
                text.replace("[1.0, 100.0]", "[1.0, 60.0]").replace(
                    "end = 200.0", "end = 300.0"
                )
            ),
            restart=tmp_path,
        ),
    )
    assert json.loads((tmp_path / "summary.json").read_text()) == before


def test_checkpoint_of_another_version(scene, whole, tmp_path):
    """Of one that has the same number but kept other arrays or values."""
    for part in (0, 1):
        parts = checkpoint.load(whole)
        name = next(key for key in parts[part] if key != "identity")
        del parts[part][name]
        checkpoint.save(tmp_path, *parts)
        refused(
            f"it lacks '{name}', as of another version; run the scene without",
            lambda: cb.run(cb.load(scene), out=tmp_path, restart=tmp_path),
        )


def test_a_steady_scene_has_nothing_to_restart(whole):
    refused(
        "nothing to restart, the scene takes no time steps",
        lambda: cb.run(loads(SCENE[: SCENE.index("[time]")]), restart=whole),
    )


def test_folder_that_cannot_be_written(scene, tmp_path):
    (tmp_path / "file").write_text("")
    began = time.monotonic()
    code, message = finish(scene, "--out", tmp_path / "file" / "results")
    assert code == 1
    assert message.startswith(
        f"cannot write {tmp_path / 'file' / 'results'}: Not a directory; a file has "
        "the name of"
    )
    assert time.monotonic() - began < 10.0  # before anything is solved


def steady(**changes: str) -> str:
    text = SCENE[: SCENE.index("[time]")] + "[output]\nplots = false\n"
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    return text


def outcome(text: str, tmp_path: Path) -> tuple[int, str, dict]:
    (tmp_path / "bed.toml").write_text(text)
    code, message = finish(tmp_path / "bed.toml", "--out", tmp_path / "out")
    return code, message, json.loads((tmp_path / "out" / "summary.json").read_text())


def test_no_solution(tmp_path):
    """A sink that no stream can feed: temperatures would fall below 0 K."""
    text = steady(**{"heat_capacity = 900.0": "heat_capacity = [600.0, 0.6]"})
    text += "[region.bed]\nsolids.heat_source = -1e6\n"
    code, message, summary = outcome(text, tmp_path)
    assert code == 3 and len(message.splitlines()) == 1
    assert summary["status"] == "not converged"
    assert len(summary["newton"]) > 1 and summary["warnings"] == [message.rstrip("\n")]
    with np.load(tmp_path / "out" / "checkpoint.npz") as kept:
        assert np.isfinite(kept["array.state"]).all()


def test_strict_range(tmp_path):
    text = (
        steady(**{"velocity = 0.3\n": "velocity = 0.01\n"})
        + "[solver]\nstrict = true\n"
    )
    code, message, summary = outcome(text, tmp_path)
    assert code == 4 and message.startswith(
        "closure nusselt_wakao_kaguei is out of its range: Re "
    )
    assert (
        summary["status"] == "closure out of range"
        and summary["qoi"]["T_fluid_out_K"] > 300.0
    )
    assert (tmp_path / "out" / "profiles.csv").exists()


def test_open_balance(tmp_path):
    code, message, summary = outcome(
        steady() + "[solver]\nbalance_tolerance = 1e-30\n", tmp_path
    )
    assert code == 5 and message.startswith("balance of energy is open by ")
    assert (
        summary["status"] == "balance open" and summary["qoi"]["T_fluid_out_K"] > 300.0
    )


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("state", np.float32),
        ("state", lambda array: array[:-1]),
        ("mean", lambda array: array[None]),
        ("kept_1", np.bool_),
        ("outlet", lambda array: array + 0j),
        ("vertices", lambda array: array[:5]),
        ("state", lambda array: np.full_like(array, np.nan)),
    ],
)
def test_checkpoint_with_other_arrays(name, other, scene, whole, tmp_path):
    """Its checksum is right, its content is of no run."""
    arrays, meta = checkpoint.load(whole)
    arrays[name] = np.asarray(other(arrays[name]))
    checkpoint.save(tmp_path, arrays, meta)
    refused(
        "run (the scene )?without --restart",
        lambda: cb.run(cb.load(scene), out=tmp_path / "out", restart=tmp_path),
    )


@each_case(__file__, "checkpoint_with_other_values")
def test_checkpoint_with_other_values(name, other, scene, whole, tmp_path):
    arrays, meta = checkpoint.load(whole)
    checkpoint.save(tmp_path, arrays, {**meta, name: other})
    refused(
        "the checkpoint does not fit this scene",
        lambda: cb.run(cb.load(scene), out=tmp_path / "out", restart=tmp_path),
    )
