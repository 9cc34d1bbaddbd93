"""Starts Python programs on a number of ranks."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

PROGRAM = Path(__file__).with_name("dolfinx_program.py")
ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
    "OMPI_MCA_mpi_yield_when_idle": "1",
}


def missing() -> str:
    """What these tests lack, empty if nothing."""
    try:
        import dolfinx.fem  # noqa: F401  # this folder itself passes for a package dolfinx
    except ImportError:
        return "DOLFINx is not installed"
    return "" if shutil.which("mpirun") else "mpirun is not installed"


def started(
    ranks: int, *arguments: Any, program: Any = PROGRAM, **environment: str
) -> Any:
    """A finished run of a Python program on a number of ranks, with its output;
    hangs end in an error.
    """
    command = [
        sys.executable,
        *(("-m", program) if isinstance(program, str) else (program,)),
        *arguments,
    ]
    command = [str(part) for part in command]
    if ranks > 1:
        command = ["mpirun", "-n", str(ranks), *command]
    root = str(PROGRAM.parents[2])
    everything = os.environ | ENVIRONMENT | {"PYTHONPATH": root} | environment
    return subprocess.run(
        command, capture_output=True, text=True, timeout=900, env=everything
    )
