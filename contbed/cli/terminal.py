"""What the commands share: their options, messages on stderr, how to resume after
Ctrl-C.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any

import typer
from typer import Argument, Option

# number of a process, set by what started it
RANK = ("OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK", "SLURM_PROCID")
SIZE = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE")  # how many processes mpirun started

# s, by which the times of files may lag; systems count them in some 10 ms
COARSE_CLOCK = 0.1
# what must exist to resume, not older than a time [s since 1970], and the command that
# does
resume: list[tuple[Path, float, str]] = []

SceneFile = Annotated[Path, Argument(metavar="SCENE", help="a TOML file")]
Quiet = Annotated[bool, Option("--quiet", help="no progress, no table")]
WithReport = Annotated[
    bool, Option("--report", help="write report.html into DIR as well")
]
OutFolder = Annotated[
    Path | None, Option("--out", metavar="DIR", help="folder for the results")
]
Settings = Annotated[
    list[str] | None,
    Option(
        "--set",
        metavar="KEY=VALUE",
        help="replace a value, such as mesh.refine=2; repeatable",
    ),
]


Trust = Annotated[
    bool,
    Option(
        "--trust",
        help="let files of the scene run programs: commands in a .geo, extensions of "
        "Cantera",
    ),
]
Threads = Annotated[
    int | None,
    Option(
        "--threads",
        metavar="N",
        min=1,
        help="cores to use; by default as many as are fastest",
    ),
]
AllowLarge = Annotated[
    bool,
    Option(
        "--allow-large",
        help="take sizes that are refused otherwise: memory, numbers of cells, files",
    ),
]


def usual_engine() -> str:
    """Return the engine that computes where none is asked for: that of several ranks
    under mpirun.
    """
    return (
        "dolfinx"
        if any(int(os.environ.get(name, "1")) > 1 for name in SIZE)
        else "skfem"
    )


def load_scene(
    path: Path, settings: list[str] | None, trust: bool, allow_large: bool
) -> Any:
    """Return the scene of a file with the values of --set."""
    from contbed.loading import load

    return load(path, overrides_of(settings), trust=trust, allow_large=allow_large)


def overrides_of(settings: list[str] | None) -> dict[str, Any]:
    """Return the values of --set by key."""
    return dict(_assignment(text) for text in settings or [])


def _assignment(text: str) -> tuple[str, Any]:
    """KEY=VALUE, the value as in TOML; what is not TOML is a text, so that units
    need no second pair of quotes.
    """
    import tomllib

    key, equals, value = text.partition("=")
    if not equals:
        raise typer.BadParameter(f"{text!r} is not KEY=VALUE", param_hint="--set")
    if len(text.splitlines()) > 1:
        raise typer.BadParameter(f"{text!r} has a line break", param_hint="--set")
    try:
        return key.strip(), tomllib.loads(f"value = {value}")["value"]
    except (ValueError, RecursionError):
        return key.strip(), value.strip()


def interrupted() -> str:
    """Return what to say after Ctrl-C: how to resume, where there is a state to
    resume from.
    """
    for needed, since, command in resume:
        if needed.exists() and needed.stat().st_mtime >= since - COARSE_CLOCK:
            return f"interrupted; to resume: {command}"
    return "interrupted"


def complain(text: str) -> None:
    """Print a message on stderr; of the processes that mpirun started the first
    speaks for all.
    """
    if not any(os.environ.get(name, "0").strip("0") for name in RANK):
        print(text, file=sys.stderr)


def warn(texts: Iterable[str]) -> None:
    """Print warnings on stderr."""
    for text in texts:
        complain(f"warning: {text}")
