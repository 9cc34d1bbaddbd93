"""What the process of one command leaves out, and that programs of users keep it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from small_scenes import STEADY

import contbed

LOOK = """
import gc
from contbed.packed_bed import run as module
solve, during = module.run, []
module.run = lambda *arguments: (during.append(gc.isenabled()), solve(*arguments))
"""
AFTER = """
import matplotlib.figure, matplotlib.axes
import os
rare = sys.modules["plistlib"]
loaded = [type(rare).__name__ == "module", rare.loads(rare.dumps({})) == {}]
one = os.environ.get("OPENBLAS_NUM_THREADS")
help_texts = "alpha" in (matplotlib.axes.Axes.set.__doc__ or "")
print(during, gc.isenabled(), "meshio" in sys.modules, help_texts, one, *loaded)
"""


@pytest.mark.parametrize(
    ("start", "expected"),
    [
        ("from contbed.__main__ import main; sys.argv[1:] = ['run', 'scene.toml', '--out', 'out', '--quiet']; main()",
         "[True] False False False 1 False True"),
        ("import contbed as cb; cb.run(cb.load('scene.toml'), out='out')", "[True] True False True None True True"),
    ],
)  # fmt: skip
def test_a_command_and_a_program(start, expected, tmp_path):
    """Cycles are collected while either solves; a command alone has no help texts of matplotlib, one thread of BLAS,
    and modules that it does not need load when they are used.
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
