"""Pairs of runs into one folder, started together or a moment apart: one result of
one scene, and a clear error.
"""

import json
import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import contbed

HOME = str(Path(contbed.__file__).parents[1])
PAIRS = 36
LATER = (0.0, 0.05, 0.2, 0.4, 0.6, 1.0)  # s after which the second run is started
SCENE = """\
[mesh]
type = "line"
length = 1.0
cells = 10

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
gas.temperature = INLET

[boundary.right]
solids.particles.fixed_temperature = 300.0

[output]
plots = false
"""
INLETS = (400.0, 500.0)


def start(folder: Path, inlet: float) -> subprocess.Popen[str]:
    scene = folder / f"inlet_{inlet:.0f}.toml"
    scene.write_text(SCENE.replace("INLET", str(inlet)))
    command = [
        sys.executable,
        "-m",
        "contbed",
        "run",
        str(scene),
        "--out",
        str(folder / "out"),
        "--quiet",
    ]
    environment = {**os.environ, "PYTHONPATH": HOME, "OMP_NUM_THREADS": "1"}
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment)


def run_pair(folder: Path, delay: float) -> tuple[list[int], list[str]]:
    """Start both runs; return their exit codes and what they said."""
    first = start(folder, INLETS[0])
    with suppress(subprocess.TimeoutExpired):
        first.wait(delay)
    second = start(folder, INLETS[1])
    said = [process.communicate(timeout=120)[1] for process in (first, second)]
    return [first.returncode, second.returncode], said


@pytest.mark.slow
@pytest.mark.parametrize("number", range(PAIRS))
def test_the_folder_holds_one_run(tmp_path, number):
    codes, said = run_pair(tmp_path, LATER[number % len(LATER)])
    done = [inlet for inlet, code in zip(INLETS, codes, strict=True) if code == 0]
    assert done, said
    for code, text in zip(codes, said, strict=True):
        assert "Traceback" not in text
        assert code == 0 or (code == 1 and "another run is writing there" in text), text
    out = tmp_path / "out"
    summary = json.loads((out / "summary.json").read_text())
    inlet = summary["scene"]["boundary"]["left"]["gas"]["temperature"]
    assert summary["status"] == "ok" and inlet in done
    assert {path.name for path in out.iterdir()} == set(summary["files"])
    with open(out / "profiles.csv", encoding="utf-8") as file:
        header = file.readline().strip().split(",")
        rows = np.loadtxt(file, delimiter=",")
    # the fluid that enters tells which scene has written the profiles
    entering = rows[0, header.index("T_fluid [K]")]
    assert min(INLETS, key=lambda value: abs(value - entering)) == inlet
