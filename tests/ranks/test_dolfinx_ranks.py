"""Runs of several ranks: what goes wrong is said, ends all ranks with an exit code,
and never hangs.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from dolfinx_launch import started

from tests.cases import each_case

STUDIES = Path(__file__).parents[2] / "studies"
SCENE = """\
[mesh]
type = "line"
length = 1.0
cells = {cells}
[radiation]
level = "{level}"
absorption = 3.0
scattering = 1.0
[boundary]
left.radiation = {{ temperature = 1000.0, emissivity = 0.8 }}
right.radiation = {{ temperature = 500.0, emissivity = 0.8 }}
[output]
plots = false
"""


@pytest.fixture
def scene(tmp_path: Path):
    """Writes a scene and returns its path."""

    def write(cells: int = 4, level: str = "p1", text: str = SCENE) -> Path:
        path = tmp_path / "scene.toml"
        path.write_text(text.format(cells=cells, level=level))
        return path

    return write


def run(ranks: int, scene: Path, out: Path | None = None):
    out = out or scene.parent / "out"
    return started(
        ranks, "run", scene, "--engine", "dolfinx", "--out", out, program="contbed"
    )


@pytest.mark.without_dolfinx
def test_missing_dolfinx_is_named(scene) -> None:
    code = (
        "import sys; sys.modules['dolfinx'] = None\nfrom contbed.cli import main\n"
        f"sys.exit(main(['run', {str(scene())!r}, '--engine', 'dolfinx', '--out', "
        f"{str(scene().parent / 'out')!r}]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 2
    assert (
        "the engine dolfinx cannot be loaded" in done.stderr
        and "python3-dolfinx" in done.stderr
    )
    assert "Traceback" not in done.stderr


def test_complex_petsc_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    from petsc4py import PETSc

    from contbed.errors import EngineError
    from contbed.ranks import dolfinx

    monkeypatch.setattr(PETSc, "ScalarType", np.complex128)
    with pytest.raises(EngineError, match="real numbers, found a complex build"):
        dolfinx.modules()


def test_other_versions_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    import dolfinx as library

    from contbed.errors import EngineError
    from contbed.ranks import dolfinx

    monkeypatch.setattr(library, "__version__", "0.9.0")
    with pytest.raises(
        EngineError, match=r"tested with DOLFINx 0\.5 only, found 0\.9\.0"
    ):
        dolfinx.modules()


def test_two_ranks_write_one_result(scene) -> None:
    # the engine goes by itself
    done = started(
        2, "run", scene(), "--out", scene().parent / "out", program="contbed"
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("results are in") == 1
    summary = json.loads((scene().parent / "out" / "summary.json").read_text())
    assert summary["status"] == "ok" and summary["versions"]["dolfinx"]


def test_more_ranks_than_cells(scene) -> None:
    done = run(2, scene(cells=1))
    assert done.returncode == 2
    assert done.stderr.count("2 ranks for a mesh of 1 cells: each rank needs one") == 1


@pytest.mark.parametrize("ranks", [1, 2])
def test_what_the_engine_lacks_is_named(tmp_path: Path, ranks: int) -> None:
    done = run(ranks, STUDIES / "patil_packed_bed" / "schumann.toml", out=tmp_path)
    assert done.returncode == 2
    assert done.stderr.count("do not run on several ranks") == 1


@each_case(__file__, "other_models_are_refused_by_name")
def test_other_models_are_refused_by_name(study: str, what: str) -> None:
    from contbed.errors import EngineError
    from contbed.loading import load
    from contbed.runner import run as solve

    with pytest.raises(EngineError, match=what):
        solve(load(STUDIES / study), engine="dolfinx")


def test_a_bad_scene_is_told_once(scene) -> None:
    done = run(2, scene(text=SCENE.replace("length", "lenght")))
    assert done.returncode == 2
    assert done.stderr.count("lenght") == 1 and "length" in done.stderr


def test_a_rank_that_fails_ends_all() -> None:
    done = started(2, "lose", "unused", "heat_constant")
    assert done.returncode != 0
    assert (
        "rank 1 of 2 failed (FloatingPointError: this rank has had enough); all ranks "
        "end" in done.stderr
    )


@each_case(__file__, "all_ranks_meet_the_error_of_the_root_rank")
def test_all_ranks_meet_the_error_of_the_root_rank(
    results, scene, key, value, error: str, code: int
) -> None:
    folder = results("complain", 2, scene, key, value)
    first, second = ((folder / f"rank{k}.txt").read_text() for k in range(2))
    assert first.startswith(f"{error} {code} ") and second.startswith(
        f"RootRankError {code} "
    )
    assert first.split(" ", 2)[2] == second.split(" ", 2)[2]
    assert (folder / "summary.json").is_file() and (
        folder / "checkpoint.npz"
    ).is_file() == (code == 3)
