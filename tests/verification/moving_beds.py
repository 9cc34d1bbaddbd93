"""Velocities of both phases at the boundary of a built-in mesh where each enters."""

from __future__ import annotations

from typing import Any

import numpy as np

SIDES = {
    "line": (("left", "right"),),
    "rectangle": (("left", "right"), ("bottom", "top")),
    "axisymmetric": (("axis", "wall"), ("bottom", "top")),
    "box": (("left", "right"), ("front", "back"), ("bottom", "top")),
}


def moving(
    mesh: dict[str, Any], boundary: dict[str, Any], gas: Any = 0.0, solid: Any = 0.0
) -> dict[str, Any]:
    """Return the boundaries of a scene with superficial velocities [m/s]; a number
    is along the bed, as x or z.
    """
    found = dict(boundary)
    sides = SIDES[mesh["type"]]
    along = 1 if mesh["type"] == "axisymmetric" else 0
    for phase, velocity in (("gas", gas), ("solids", solid)):
        if not np.any(velocity):
            continue
        vector = np.ravel(velocity)
        number = len(vector) == 1
        axis = along if number else int(np.argmax(np.abs(vector)))
        component = float(vector[0] if number else vector[axis])
        side = sides[axis][0 if component > 0 else 1]
        table = found.get(side, {})
        moves = {"velocity": abs(component) if number else [float(v) for v in vector]}
        if phase == "gas":
            table = {**table, "gas": {**table.get("gas", {}), **moves}}
        else:
            table = {
                **table,
                "solids": {
                    "particles": {
                        **table.get("solids", {}).get("particles", {}),
                        **moves,
                    }
                },
            }
        found[side] = table
    return found


def started(gas: Any, solid: Any) -> dict[str, Any]:
    """Return the table [initial] with the temperatures of both phases at the
    start [K], numbers or profiles.
    """
    return {
        "gas": {"temperature": gas},
        "solids": {"particles": {"temperature": solid}},
    }
