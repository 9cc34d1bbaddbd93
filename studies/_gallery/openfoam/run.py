"""Run a case of the peer and read what it wrote."""

from __future__ import annotations

import os
import re
import resource
import subprocess
from pathlib import Path
from shutil import which

import numpy as np

from studies._gallery.openfoam.case import SOLVER, Case
from studies._gallery.openfoam.files import write

# where Debian keeps the dictionaries that every tool asks for
HOME = "/usr/share/openfoam"


def available() -> bool:
    return which(SOLVER) is not None


def run(case: Case, folder: Path) -> dict[str, float]:
    """Write, mesh and run a case: CPU of the solver and of its steps after the
    first [s], the number of steps, and the drift of the solids inventory.
    """
    write(case, folder)
    environment = {
        **os.environ,
        "WM_PROJECT_DIR": HOME,
        "FOAM_ETC": f"{HOME}/etc",
        "WM_PROJECT_VERSION": "v1912",
    }

    def tool(name: str) -> str:
        done = subprocess.run(
            [name],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        (folder / f"log.{name}").write_text(done.stdout + done.stderr)
        if done.returncode:
            raise RuntimeError(
                f"{name} failed, see {folder}/log.{name}: "
                f"{done.stdout[-300:]}{done.stderr[-300:]}"
            )
        return done.stdout

    tool("blockMesh")
    if not case.riser:
        tool("setFields")
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    log = tool(SOLVER)
    cpu = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    inventory = series(folder, "inventory", "volFieldValue")
    clock = [
        float(value) for value in re.findall(r"^ExecutionTime = ([0-9.]+)", log, re.M)
    ]
    return {
        "cpu_s": cpu,
        "loop_cpu_s": clock[-1] - clock[0],
        "steps": float(len(re.findall(r"^Time = ", log, re.M))),
        "mass_drift_relative": inventory[-1, 1] / inventory[0, 1] - 1.0
        if inventory[0, 1]
        else float("nan"),
    }


def series(folder: Path, name: str, kind: str) -> np.ndarray:
    """Rows of time [s] and values that a function object wrote."""
    return np.atleast_2d(
        np.loadtxt(folder / "postProcessing" / name / "0" / f"{kind}.dat")
    )


def times(folder: Path) -> list[Path]:
    """What was written, in the order of time; the start is the first."""
    return sorted(
        (p for p in folder.iterdir() if re.fullmatch(r"[0-9.]+", p.name)),
        key=lambda p: float(p.name),
    )


def field(case: Case, folder: Path, name: str, at: int = -1) -> np.ndarray:
    """A field of one of the `times` on the grid, shape (ny, nx) or (ny, nx,
    components).
    """
    body = (
        (times(folder)[at] / name)
        .read_text()
        .split("internalField", 1)[1]
        .split("boundaryField", 1)[0]
    )
    if body.strip().startswith("uniform"):
        numbers = np.array(
            re.findall(r"[-+0-9.eE]+", body.split("uniform", 1)[1]), float
        )
        return np.broadcast_to(numbers, (case.ny, case.nx, numbers.size)).squeeze()
    inside = body[body.index("(") : body.rindex(")")]
    numbers = np.array(re.findall(r"[-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?", inside), float)
    return numbers.reshape(case.ny, case.nx, -1).squeeze()
