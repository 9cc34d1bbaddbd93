"""Sweeps by several workers: the same to the last bit as by one, and whoever is killed,
nothing is lost or done twice.

Every worker writes a line to the log of a run when it begins it and when it has ended
it; these lines are counted.
"""

import os
import signal
import subprocess
import sys
import textwrap
import time
from contextlib import suppress
from functools import partial
from pathlib import Path
from threading import Thread

import pytest

import contbed
from contbed.many.sweep.sweep import sweep
from tests.numbers_of import table_of

SCENE = """\
mesh = { type = "line", length = 0.5 }
output = { plots = false, fields = false }

[gas]
density = 0.4
heat_capacity = 2000
conductivity = 0.03
viscosity = 1.7e-5

[solids.particles]
density = 2000
heat_capacity = 900
conductivity = 1
diameter = "6 mm"

[packed_bed]
porosity = 0.4

[closures]
nusselt = "gunn"

[heat]

[boundary.left]
gas.velocity = 0.2
gas.temperature = 300

[boundary.right]
solids.particles.velocity = 1e-4
solids.particles.fixed_temperature = 500
"""
# a hundred time steps, so that there is something to kill
SLOW = (
    SCENE
    + "[initial]\ngas.temperature = 400\nsolids.particles.temperature = 400\n\n[time]\n"
    "end = 40\nstep = 0.4\n"
)
STUDY = """\
scene = "scene.toml"
[sample]
method = "latin_hypercube"
count = {}
seed = 7
[sample.parameters]
packed_bed.porosity = {{ from = 0.36, to = 0.44 }}
boundary.left.gas.velocity = {{ from = 0.1, to = 0.3 }}
solids.particles.diameter = {{ distribution = "log_uniform", from = "2 mm", to = "10 mm" }}
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path


def write_study(count, scene=SCENE):
    Path("scene.toml").write_text(scene)
    Path("study.toml").write_text(STUDY.format(count))


def command(*arguments):
    environment = {**os.environ, "PYTHONPATH": str(Path(contbed.__file__).parents[1])}
    return subprocess.Popen(
        [sys.executable, "-m", "contbed", "sweep", "study.toml", *arguments],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def wait_for(condition, seconds=120.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "nothing came in time"
        time.sleep(0.005)


def outcomes(out):
    return {path.parent.name for path in Path(out).glob("runs/*/outcome.json")}


def log(out):
    """What was noted of each run: "begun", "finished", with the process."""
    return {
        path.parent.name: [line.split()[2:] for line in path.read_text().splitlines()]
        for path in Path(out).glob("runs/*/workers.log")
    }


def times(out, what):
    return {
        name: sum(line[1] == what for line in lines) for name, lines in log(out).items()
    }


def assert_same(one, other):
    """Tables and profiles agree to the last bit."""
    assert (Path(one) / "table.csv").read_bytes() == (
        Path(other) / "table.csv"
    ).read_bytes()
    files = sorted(
        path.relative_to(one) for path in Path(one).glob("runs/*/profiles.csv")
    )
    assert files == sorted(
        path.relative_to(other) for path in Path(other).glob("runs/*/profiles.csv")
    )
    for file in files:
        assert (Path(one) / file).read_bytes() == (Path(other) / file).read_bytes()


def assert_once(count, killed):
    """Every run was computed to its end once; begun again were at most those that
    were killed.
    """
    begun, finished = times("out", "begun"), times("out", "finished")
    assert len(begun) == len(outcomes("out")) == count
    assert max(begun.values()) <= 2 and sum(begun.values()) <= count + killed
    # a worker may be killed when the outcome is there and only its last note is not
    assert max(finished.values()) == 1 and sum(finished.values()) >= count - killed


def kill(pid):
    os.kill(int(pid), signal.SIGKILL)


def test_processes_give_what_one_gives_to_the_last_bit(folder):
    write_study(10)
    sweep("study.toml", "serial", jobs=1)
    found = sweep("study.toml", "parallel", jobs=2)
    assert len(found.rows) == 10 and not found.failed
    assert_same("serial", "parallel")
    workers = {pid for lines in log("parallel").values() for pid, _ in lines}
    assert str(os.getpid()) not in workers and len(workers) == 2


@pytest.mark.slow
def test_a_killed_process_costs_only_what_was_running(folder):
    write_study(16, SLOW)
    victims = []

    def killer():
        wait_for(lambda: len(outcomes("out")) >= 6)
        running = [
            lines[-1][0]
            for lines in log("out").values()
            if lines and lines[-1][1] == "begun"
        ]
        victims.append(running[0])
        kill(running[0])

    thread = Thread(target=killer)
    thread.start()
    found = sweep("study.toml", "out", jobs=2)
    thread.join()
    assert victims and len(found.rows) == 16 and not found.failed
    assert_once(16, killed=2)  # the other process of the pool goes with the killed one
    sweep("study.toml", "serial", jobs=1)
    assert_same("serial", "out")


@pytest.mark.slow
def test_a_run_that_always_kills_its_worker_fails_and_the_others_finish(folder):
    write_study(5, SLOW)
    victim = sweep_names()[2]
    done = []

    def killer():
        while not done:
            lines = log("out").get(victim, [])
            if (
                lines
                and len(lines[-1]) > 1
                and lines[-1][1] == "begun"
                and victim not in outcomes("out")
            ):
                with suppress(ProcessLookupError):
                    kill(lines[-1][0])
            time.sleep(0.005)

    thread = Thread(target=killer)
    thread.start()
    found = sweep("study.toml", "out", jobs=2)
    done.append(True)
    thread.join()
    assert [row.run for row in found.failed] == [victim]
    assert (
        found.failed[0].exit_code == 137
        and "its worker died" in found.failed[0].problem
    )
    assert len(found.rows) == 5
    assert not sweep("study.toml", "out", jobs=2, retry_failed=True).failed


def sweep_names():
    from contbed.many.sweep.study import read_study

    return [case.name for case in read_study("study.toml").cases]


def test_workers_end_with_a_parent_that_is_killed(folder):
    """Within 5 s, in the middle of whatever they compute."""
    code = """
        import os, time
        from contbed.many.workers import computed
        def work(name):
            open(name, "w").write(str(os.getpid()))
            os.rename(name, name + ".pid")
            while True:
                sum(range(10**6))
        list(computed(work, [("a",), ("b",)], 2, bool, bool))
    """
    environment = {**os.environ, "PYTHONPATH": str(Path(contbed.__file__).parents[1])}
    parent = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(code)], env=environment
    )
    wait_for(lambda: len(list(folder.glob("*.pid"))) == 2)
    parent.kill()
    parent.wait()
    for path in folder.glob("*.pid"):
        wait_for(partial(has_ended, int(path.read_text())), 5.0)


def has_ended(pid):
    """Return whether a process has ended, also where nobody has asked for its status."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except OSError:
        return True
    return state == "Z"


@pytest.mark.slow
def test_a_sweep_that_is_killed_goes_on_where_it_was(folder):
    write_study(24, SLOW)
    process = command("--out", "out", "--jobs", "2")
    wait_for(lambda: len(outcomes("out")) >= 8)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    before = outcomes("out")
    assert 8 <= len(before) < 24
    stamps = {
        name: (folder / "out/runs" / name / "outcome.json").stat().st_mtime_ns
        for name in before
    }
    process = command("--out", "out", "--jobs", "2")
    out, err = process.communicate()
    assert (process.returncode, err) == (0, "")  # a pipe gets no progress bar
    *spreads, last = out.splitlines()
    named = [
        {
            line.split(",")[0]
            for line in spreads
            if f", by {how} (24 runs): mean " in line
        }
        for how in ("samples", "polynomial chaos")
    ]
    assert named[0] == named[1] >= {"pressure_drop", "T_fluid_out", "T_solid_out"}
    assert (
        last
        == f"24 of 24 runs are finished, {len(before)} were before; see out/table.csv"
    )
    assert {
        name: (folder / "out/runs" / name / "outcome.json").stat().st_mtime_ns
        for name in before
    } == stamps
    begun = times("out", "begun")
    assert len(begun) == 24 and all(begun[name] == 1 for name in before)
    assert sum(begun.values()) <= 24 + 2  # those that were running
    sweep("study.toml", "serial", jobs=1)
    assert_same("serial", "out")


@pytest.mark.slow
@pytest.mark.parametrize("whole_group", [True, False], ids=["Ctrl-C", "kill -INT"])
def test_an_interrupted_sweep_ends_clean(folder, whole_group):
    write_study(24, SLOW)
    process = command("--out", "out", "--jobs", "2")
    wait_for(lambda: len(outcomes("out")) >= 4)
    (os.killpg if whole_group else os.kill)(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err) == (
        130,
        "",
        "interrupted; to resume: the same command\n",
    )
    assert 4 <= len(table_of("out/table.csv")) < 24
    with pytest.raises(ProcessLookupError):  # no worker is left
        wait_for(lambda: os.killpg(process.pid, 0), 10.0)


@pytest.mark.slow
def test_two_sweeps_of_one_study_share_the_work(folder):
    write_study(16, SLOW)
    both = [command("--out", "out", "--jobs", "2") for _ in range(2)]
    for process in both:
        _, err = process.communicate()
        assert process.returncode == 0, err
    assert set(times("out", "begun").values()) == {1}
    assert len({lines[0][0] for lines in log("out").values()}) > 2  # processes
