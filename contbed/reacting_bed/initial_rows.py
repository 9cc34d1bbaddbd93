"""The file that a run of a reacting bed begins with: its rows, and the gases that it
names; see `initial`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from contbed.errors import SceneError
from contbed.reacting_bed import scene as s
from contbed.scene.profile import Rows, rows_along

KEY = ("initial", "file")
GAS = "x_"  # begins columns of mole fractions


def rows_of(initial: s.Initial, base: Path) -> Rows | None:
    """Return the rows of the file that a run begins with; None without one.

    Raises
    ------
    SceneError : the file cannot be used
    """
    return (
        None if initial.file is None else rows_along(base / initial.file, initial.time)
    )


def gases_in(initial: s.Initial, base: Path) -> dict[str, str]:
    """Return the gases that a file names and that are somewhere, with where their
    columns stand.

    Raises
    ------
    SceneError : the file cannot be used
    """
    rows = rows_of(initial, base)
    if rows is None:
        return {}
    place = f"{rows.table.path.name}:{rows.table.header_line}"
    names = [
        name
        for name in rows.table.names
        if name.startswith(GAS) and np.any(rows.column(name, "1"))
    ]
    return {name.removeprefix(GAS): f"{place}: column '{name}'" for name in names}


def located(scene: s.ReactingScene, error: SceneError | str) -> SceneError:
    """Return a mistake of the file with the place in the scene that names it."""
    return SceneError(f"{scene.origin.place(KEY)}: {error}")
