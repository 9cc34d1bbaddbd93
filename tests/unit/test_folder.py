"""The folder of a run: one run at a time, files that belong together, links,
failures.
"""

import json
import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from small_scenes import STEADY

import contbed as cb
from contbed.errors import ContbedError
from contbed.loading import loads
from contbed.output.files import atomic
from contbed.output.folder import LOCK, occupied, read_summary
from tests.command_line import command
from tests.refusals import refused

TRANSIENT = (
    STEADY
    + "[initial]\ngas.temperature = 300.0\nsolids.particles.temperature = 400.0\n\n"
    "[time]\nend = 2.0\ntimes = [1.0]\n"
)


def status(folder: Path) -> str:
    return json.loads((folder / "summary.json").read_text())["status"]


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_files_of_a_run_belong_together(tmp_path):
    cb.run(loads(TRANSIENT), out=tmp_path)
    assert {"checkpoint.npz", "fields.pvd", "fields_0001.vtu"} < names(tmp_path)
    assert set(read_summary(tmp_path)["files"]) == names(tmp_path)
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "fields_0007.vtu").write_text("mine")
    cb.run(loads(STEADY), out=tmp_path)
    assert names(tmp_path) == {
        *("summary.json", "profiles.csv", "profiles.png", "fields.vtu"),
        *("notes.txt", "fields_0007.vtu"),
    }


def test_no_file_of_others_is_replaced_whatever_its_name(tmp_path):
    """Names that follow from the run are seen when it writes them; a run that resumes,
    and a later one, replace what is theirs.
    """
    (tmp_path / "fields_0001.vtu").write_text("mine")
    said = r"fields_0001\.vtu: not written by a run of contbed"
    with pytest.raises(ContbedError, match=said):
        cb.run(loads(TRANSIENT), out=tmp_path)
    assert (tmp_path / "fields_0001.vtu").read_text() == "mine"
    assert status(tmp_path) == "output incomplete"
    assert "fields_0001.vtu" not in read_summary(tmp_path)["files"]
    (tmp_path / "fields_0001.vtu").unlink()
    for restart in (None, tmp_path, None):
        cb.run(loads(TRANSIENT), out=tmp_path, restart=restart)
        assert "fields_0001.vtu" in read_summary(tmp_path)["files"]


@pytest.mark.parametrize(
    "name",
    ["profiles.csv", "summary.json", "fields.vtu", "profiles.png", "fields.pvd"],
)
def test_files_of_others_are_not_replaced(tmp_path, name):
    (tmp_path / name).write_text("[]")
    said = rf"{name}: not written by a run of contbed.* another folder by --out"
    with pytest.raises(ContbedError, match=said):
        cb.run(loads(STEADY), out=tmp_path)
    assert names(tmp_path) == {name} and (tmp_path / name).read_text() == "[]"


def test_an_input_that_an_earlier_run_has_written_stays(tmp_path):
    with occupied(tmp_path) as place:
        place.begin({}, keep=False)
        with atomic(tmp_path / "closure.toml") as temporary:
            temporary.write_text("a = 1\n")
        with atomic(tmp_path / "table.csv") as temporary:
            temporary.write_text("a\n")
        place.end({"status": "ok"})
    with occupied(tmp_path) as place:
        place.begin({}, keep=False, inputs=[tmp_path / "closure.toml"])
        assert names(tmp_path) == {"closure.toml", "summary.json", LOCK}
        assert status(tmp_path) == "running"


REACTING = """
mesh = { type = "line", length = 1.0 }
gas = { model = "ideal_gas", composition = "A:1", species.A = { elements.H = 28, molar_mass = 0.028 } }
solids.beads.diameter = 3e-3
packed_bed = { porosity = 0.4, pressure_drop = "none" }
boundary.left.gas = { molar_flux = 1.0, temperature = 500 }
initial.file = "out/profiles.csv"
time.end = 1.0
"""


@pytest.mark.parametrize(
    ("text", "key"),
    [
        (
            TRANSIENT.replace(
                "particles.temperature = 400.0",
                'particles.temperature = { file = "out/profiles.csv" }',
            ),
            "initial.solids.particles.temperature",
        ),
        (REACTING, "initial"),
    ],
    ids=["packed", "reacting"],
)
def test_a_run_does_not_replace_what_it_reads(tmp_path, text, key):
    out = tmp_path / "out"
    out.mkdir()
    (out / "profiles.csv").write_text("x [m],T_solid [K],x_A [1]\n0,400,1\n1,400,1\n")
    (out / "summary.json").write_text(
        '{"status": "ok", "files": ["profiles.csv", "summary.json"]}'
    )
    before = {path: path.read_text() for path in out.iterdir()}
    (tmp_path / "linked").symlink_to(out)
    scene = loads(text, base=tmp_path)
    said = rf"scene\.toml:\d+: {key}\.file: profiles\.csv lies in .* give another folder by --out"
    for more in ({"out": out}, {"out": tmp_path / "linked"}, {"restart": out}):
        refused(said, cb.run, scene, **more)
    assert before == {path: path.read_text() for path in out.iterdir()}


def test_other_inputs_may_lie_among_results_and_are_not_replaced(tmp_path):
    (tmp_path / "feed.csv").write_text("mine")
    with occupied(tmp_path) as place:
        place.begin({}, keep=False, inputs=[tmp_path / "feed.csv"])
        said = r"cannot write .*feed\.csv: the run reads this file"
        with (
            pytest.raises(ContbedError, match=said),
            atomic(tmp_path / "feed.csv") as temporary,
        ):
            temporary.write_text("a\n")
        assert (tmp_path / "feed.csv").read_text() == "mine"


def test_only_plain_names_of_the_folder_are_removed(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    out = tmp_path / "out"
    out.mkdir()
    (out / "linked").symlink_to(tmp_path / "mine.txt")
    listed = ["../mine.txt", str(tmp_path / "mine.txt"), "..", "", 3, "linked"]
    (out / "summary.json").write_text(json.dumps({"status": "ok", "files": listed}))
    with occupied(out) as place:
        place.begin({}, keep=False)
    assert (tmp_path / "mine.txt").read_text() == "mine"
    assert not (out / "linked").is_symlink()


@pytest.mark.parametrize("when", ["plan", "run", "late"])
def test_a_failed_run_does_not_look_like_the_good_one_before(
    tmp_path, monkeypatch, when
):
    cb.run(loads(STEADY), out=tmp_path)
    place = {
        "plan": "contbed.packed_bed.plan.plan",
        "run": "contbed.packed_bed.run.run",
        "late": "contbed.runner._verdict",
    }
    with monkeypatch.context() as patch:
        patch.setattr(place[when], lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            cb.run(loads(STEADY), out=tmp_path)
    assert status(tmp_path) == "failed"
    assert "division by zero" in read_summary(tmp_path)["warnings"][0]
    # what an earlier run has found is only given up for a run that begins
    assert (tmp_path / "profiles.csv").exists() == (when != "run")
    cb.run(loads(STEADY), out=tmp_path)
    assert status(tmp_path) == "ok"


def test_a_scene_with_a_mistake_marks_the_folder_and_makes_none(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(STEADY)
    assert command("run scene.toml --out out --quiet") == 0
    before = names(tmp_path / "out")
    (tmp_path / "scene.toml").write_text(STEADY.replace("0.4", "4"))
    assert command("run scene.toml --out out --quiet") == 2
    assert status(tmp_path / "out") == "bad scene" and names(tmp_path / "out") == before
    assert command("run scene.toml --out other --quiet") == 2
    assert not (tmp_path / "other").exists()


def test_a_killed_run_says_running(tmp_path):
    cb.run(loads(STEADY), out=tmp_path)
    code = """
        import os, signal, sys
        import contbed.packed_bed.run as module
        module.run = lambda *_: os.kill(os.getpid(), signal.SIGKILL)
        import contbed as cb
        cb.run(cb.load(sys.argv[1]), out=sys.argv[2])
    """
    (tmp_path / "scene.toml").write_text(STEADY)
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code), tmp_path / "scene.toml", tmp_path]
    )
    assert done.returncode == -9
    assert status(tmp_path) == "running" and not (tmp_path / "profiles.csv").exists()
    assert (tmp_path / LOCK).exists()  # of a process that is no more
    cb.run(loads(STEADY), out=tmp_path)
    assert status(tmp_path) == "ok" and not (tmp_path / LOCK).exists()


def test_two_runs_in_one_folder(tmp_path):
    with occupied(tmp_path):
        with pytest.raises(
            ContbedError,
            match=rf"another run is writing there \(process {os.getpid()} on .*\); wait",
        ):
            cb.run(loads(STEADY), out=tmp_path)
        with pytest.raises(ContbedError, match="another run"), occupied(tmp_path):
            pass
    cb.run(loads(STEADY), out=tmp_path)


def test_many_runs_at_once_are_one_after_the_other_or_refused(tmp_path):
    (tmp_path / "scene.toml").write_text(STEADY + "[output]\nplots = false\n")
    start = [
        sys.executable,
        "-m",
        "contbed",
        "run",
        "scene.toml",
        "--quiet",
        "--out",
        "out",
        "--set",
    ]
    runs = [
        subprocess.Popen(
            [*start, f"boundary.left.gas.velocity={0.1 * k}"],
            cwd=tmp_path,
            stderr=subprocess.PIPE,
            text=True,
        )
        for k in range(1, 5)
    ]
    ended = [(run.communicate()[1], run.returncode) for run in runs]
    assert {code for _, code in ended} <= {0, 1} and any(code == 0 for _, code in ended)
    assert all("another run is writing there" in text for text, code in ended if code)
    assert status(tmp_path / "out") == "ok"
    assert not list((tmp_path / "out").glob("*.part"))


def test_planted_links_are_not_followed(tmp_path):
    mine = tmp_path / "mine.txt"
    mine.write_text("mine")
    out = tmp_path / "out"
    out.mkdir()
    for name in (
        "summary.json.part",
        "summary.json",
        "profiles.csv",
        "profiles.csv.part",
        "fields.vtu",
    ):
        (out / name).symlink_to(mine)
    cb.run(loads(STEADY), out=out)
    assert mine.read_text() == "mine"
    assert not (out / "profiles.csv").is_symlink() and status(out) == "ok"
    (out / LOCK).symlink_to(mine)
    with pytest.raises(ContbedError, match="cannot lock"):
        cb.run(loads(STEADY), out=out)
    assert mine.read_text() == "mine"


def test_one_output_that_fails_keeps_no_other_back(tmp_path, monkeypatch):
    monkeypatch.setattr("contbed.output.tables.write_table", lambda *_: 1 / 0)
    with pytest.raises(
        ContbedError,
        match=r"profiles.csv cannot be written: ZeroDivisionError: division by zero",
    ):
        cb.run(loads(STEADY), out=tmp_path)
    assert names(tmp_path) == {"summary.json", "profiles.png", "fields.vtu"}
    summary = read_summary(tmp_path)
    assert (
        summary["status"] == "output incomplete" and summary["qoi"]["T_fluid_out_K"] > 0
    )
    (tmp_path / "fields.vtu").unlink()
    (tmp_path / "fields.vtu").mkdir()
    monkeypatch.undo()
    with pytest.raises(ContbedError, match="a folder has this name"):
        cb.run(loads(STEADY), out=tmp_path)
    assert (tmp_path / "profiles.csv").exists()


def test_a_plan_that_fails_makes_no_folder(tmp_path, monkeypatch):
    monkeypatch.setattr("contbed.packed_bed.plan.plan", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        cb.run(loads(STEADY), out=tmp_path / "new")
    assert not (tmp_path / "new").exists()
