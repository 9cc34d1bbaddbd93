"""Compile all kernels once, at install time, so that no run has to wait for it:
`contbed warm`.

Small scenes run through every compiled loop. Kernels that hold the closures of a scene
are compiled with the default closures here, and with others when a scene first names
them, which takes about a second.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

_GAS = {"density": 1.2, "viscosity": 1.8e-5}
_WALLS = {name: {"type": "wall"} for name in ("left", "right", "bottom", "top")}
_BED = {
    "mesh": {"type": "rectangle", "length": 0.02, "height": 0.04, "cells": [4, 8]},
    "two_fluid": {},
    "gas": _GAS,
    "solids": {"beads": {"diameter": 275e-6, "density": 2500.0}},
    "initial": {
        "layer": [{"end": 0.02, "solids": {"beads": {"volume_fraction": 0.5}}}]
    },
    "boundary": _WALLS
    | {
        "bottom": {"type": "inlet", "gas": {"velocity": 0.3}},
        "top": {"type": "outlet"},
    },
    "time": {"end": 1e-3, "sample": 5e-4, "average_from": 5e-4},
}
_HOT = {
    "heat": {},
    "gas": _GAS | {"heat_capacity": 1000.0, "conductivity": 0.025},
    "solids": {
        "beads": {"diameter": 275e-6, "density": 2500.0, "heat_capacity": 800.0}
    },
    "initial": {
        "layer": [{"end": 0.02, "solids": {"beads": {"volume_fraction": 0.5}}}],
        "gas": {"temperature": 300.0},
    },
    "boundary": _WALLS
    | {
        "bottom": {"type": "inlet", "gas": {"velocity": 0.3, "temperature": 400.0}},
        "top": {"type": "outlet"},
    },
}
_BOX = {
    "mesh": {
        "type": "box",
        "length": 0.02,
        "width": 0.02,
        "height": 0.04,
        "cells": [8, 8, 16],
    },
    "boundary": _BED["boundary"]
    | {name: {"type": "wall"} for name in ("front", "back")},  # type: ignore[operator]
}
_PARTICLES = {
    "particles": {"count": 150, "width": [0.009, 0.009], "height": 0.04},
    "solids": {
        "beads": {
            "diameter": 2e-3,
            "density": 2500.0,
            "conductivity": 0.84,
            "emissivity": 0.9,
            "sliding_friction": 0.3,
            "rolling_friction": 0.04,
        }
    },
    "gas": _GAS | {"heat_capacity": 1005.0, "conductivity": 0.026},
    "closures": {"nusselt": "gunn"},
    "boundary": {"bottom": {"gas": {"velocity": 0.6}}},
    "heat": {},
    "initial": {"solids": {"beads": {"temperature": 400.0}}},
    "time": {"end": 2e-3, "sample": 1e-3},
}
_LINE = {
    "mesh": {"type": "line", "length": 0.04, "cells": 8},
    "boundary": {
        "left": {"type": "inlet", "gas": {"velocity": 0.3}},
        "right": {"type": "outlet"},
    },
}
SCENES: dict[str, dict[str, Any]] = {
    "two fluids": _BED,
    "two fluids with heat": _BED | _HOT,
    "two fluids on triangles": _BED | {"mesh": _BED["mesh"] | {"shape": "triangle"}},  # type: ignore[operator]
    "two fluids on a line": _BED | _LINE,
    "two fluids in 3-D": _BED | _BOX,
    "particles in a gas": _PARTICLES,
}


def warm() -> Iterator[tuple[str, float]]:
    """Compile what runs need; yields the name of each physics and the CPU time that
    it took [s].
    """
    from contbed.loading import from_dict
    from contbed.runner import run

    for name, values in SCENES.items():
        start = time.process_time()
        run(from_dict(values, name="contbed warm"))
        yield name, time.process_time() - start
