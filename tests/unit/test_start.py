"""Reference cycles and threads of BLAS in the process of one command and in programs
of users.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from small_scenes import STEADY

import contbed
from contbed.errors import SceneError

LOOK = """
import gc
from contbed.packed_bed import run as module
solve, during = module.run, []
module.run = lambda *arguments: (during.append(gc.isenabled()), solve(*arguments))
"""
AFTER = """
import os
print(during, gc.isenabled(), "meshio" in sys.modules, os.environ.get("OPENBLAS_NUM_THREADS"))
"""


@pytest.mark.parametrize(
    ("start", "expected"),
    [
        ("from contbed.__main__ import main; sys.argv[1:] = ['run', 'scene.toml', "
         "'--out', 'out', '--quiet']; main()",
         "[True] False False 1"),
        ("import contbed as cb; cb.run(cb.load('scene.toml'), out='out')", "[True] True False None"),
    ],
)  # fmt: skip
def test_a_command_and_a_program(start, expected, tmp_path):
    """Cycles are collected while either solves; a command alone starts BLAS with one
    thread.
    """
    (tmp_path / "scene.toml").write_text(STEADY)
    environment = {**os.environ, "PYTHONPATH": str(Path(contbed.__file__).parents[1])}
    environment.pop("OPENBLAS_NUM_THREADS", None)
    done = subprocess.run(
        [sys.executable, "-c", f"import sys\n{LOOK}\n{start}\n{AFTER}"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.stdout == expected + "\n", done.stderr
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        *("profiles.csv", "profiles.png", "fields.vtu", "summary.json")
    }


def test_a_file_in_place_of_a_scene_is_told():
    """Whoever gives the path to `run`, `plan` or `gradient` learns of `load`."""
    for call in (
        lambda: contbed.run("bed.toml"),
        lambda: contbed.run(Path("bed.toml"), "results"),
        lambda: contbed.plan("bed.toml"),
        lambda: contbed.gradient("bed.toml", "T_fluid_out_K", "packed_bed.porosity"),
    ):
        with pytest.raises(SceneError, match=r'contbed\.load\("bed\.toml"\)'):
            call()
    with pytest.raises(SceneError, match=r"contbed\.load\(\.\.\.\) makes one"):
        contbed.run({"mesh": {"type": "line"}})
