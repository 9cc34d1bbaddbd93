"""The peers LIGGGHTS and LAMMPS: a bed as both read it, and the CPU of their decks."""

from __future__ import annotations

from pathlib import Path
from shutil import which
from typing import Any

import numpy as np
from numpy.typing import NDArray

from studies._gallery.timing import cpu_of

# of the Debian packages liggghts and lammps
PROGRAMS = {"LIGGGHTS": "liggghts", "LAMMPS": "lmp"}


def available(code: str) -> bool:
    """Is this code installed?"""
    return which(PROGRAMS[code]) is not None


def write_bed(
    path: Path,
    position: NDArray[np.float64],
    diameter: float,
    width: float,
    density: float,
    held: NDArray[np.bool_] | None = None,
) -> None:
    """Write a bed of equal spheres in a box, SI; particles that are held at a
    temperature are of type 2.
    """
    high = position[:, 2].max() + 2 * diameter
    kinds = np.ones(len(position), int) if held is None else np.where(held, 2, 1)
    rows = [
        f"{k} {kind} {diameter} {density} {x:.12g} {y:.12g} {z:.12g}"
        for k, (kind, (x, y, z)) in enumerate(
            zip(kinds, position.tolist(), strict=True), 1
        )
    ]
    sides = (
        f"0 {width:.9g} xlo xhi\n0 {width:.9g} ylo yhi\n{-diameter:.9g} {high:.9g} "
        "zlo zhi"
    )
    head = (
        f"settled bed\n\n{len(rows)} atoms\n{kinds.max()} atom types\n\n{sides}\n\n"
        "Atoms\n\n"
    )
    path.write_text(head + "\n".join(rows) + "\n")


def seconds(
    code: str,
    deck: Path,
    folder: Path,
    variables: dict[str, Any],
    steps: int,
    repeats: int,
) -> float:
    """Least user CPU of some steps of a deck [s], start and reading taken off; its
    output is in FOLDER/printed.
    """
    command = [PROGRAMS[code], "-in", str(deck)]
    command += [str(part) for pair in variables.items() for part in ("-var", *pair)]
    times = {
        count: min(
            cpu_of([*command, "-var", "steps", str(count)], folder).ru_utime
            for _ in range(repeats)
        )
        for count in (0, steps)
    }
    return times[steps] - times[0]
