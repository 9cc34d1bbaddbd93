"""Beds of two fluids for runs on ranks: the check cases, and a bed that moves on
each kind of mesh.
"""

from copy import deepcopy
from pathlib import Path
from typing import Any

from tests.scene_text import scene_of

CHECKS = Path(__file__).parents[2] / "studies" / "two_fluid_checks"
CHECK_CASES = (
    "closed_box_jj",
    "cooling",
    "cooling_drag",
    "crossing",
    "fixed_bed",
    "heating",
    "rest",
    "riemann",
    "settling",
    "shear",
    "slip",
    "uniform_gidaspow",
    "uniform_syamlal",
    "uniform_wenyu",
)
JET = scene_of("""
model = "two_fluid"

[closures]
drag = "drag_gidaspow"
friction_viscosity = "friction_viscosity_schaeffer"

[gas]
density = 1.2
viscosity = 1.8e-5

[solids.beads]
diameter = 5e-4
density = 2500.0
restitution = 0.9
packing_limit = 0.63

[initial]
solids.beads = { granular_temperature = 1e-3 }
noise = 0.02
layer = [{ end = 0.06, solids = { beads = { volume_fraction = 0.58, velocity = 0.1 } } }]

[boundary]
bottom.type = "inlet"
bottom.gas = { velocity = 0.8 }
top.type = "outlet"
left.type = "wall"
left.solids.beads.wall = "johnson_jackson"
left.solids.beads.specularity = 0.05
left.solids.beads.restitution = 0.9
right.type = "wall"

[time]
end = 0.05
sample = 0.01
first = 5e-4
longest = 1e-3

[output]
plots = false
""")
# the gas conducts so well that its conduction is implicit
HEAT = {
    "gas.heat_capacity": 1005.0,
    "gas.conductivity": 0.03,
    "gas.density_law": "ideal_gas",
    "solids.beads.heat_capacity": 800.0,
    "two_fluid.conductivity_gas": 2.0,
    "two_fluid.conductivity_solids": 1.0,
    "initial.gas.temperature": 300.0,
    "initial.solids.beads.temperature": 310.0,
    "boundary.left.temperature": 500.0,
    "boundary.right.heat_flux": 2e4,
}
PLANE = {"type": "rectangle", "length": 0.04, "height": 0.1, "cells": [10, 25]}


def bed(mesh: dict[str, Any], **more: dict[str, Any]) -> dict[str, Any]:
    """The jet on a mesh with some keys changed, by table."""
    scene = deepcopy(JET) | {"mesh": mesh}
    for name, table in more.items():
        scene[name] = scene.get(name, {}) | table
    return scene


def heated(
    scene: dict[str, Any], changes: dict[str, Any] | None = None
) -> dict[str, Any]:
    """A bed with [heat]: hot gas comes in, the left wall is hot, and the right one
    is heated; both where there are.
    """
    enters = scene["boundary"]["bottom"]["type"] == "inlet"
    hot_gas = {"boundary.bottom.gas.temperature": 600.0} if enters else {}
    made = deepcopy(scene) | {"heat": {}}
    for path, value in (HEAT | hot_gas | (changes or {})).items():
        *way, last = path.split(".")
        table = made
        for name in way:
            table = table.setdefault(name, {})
        table[last] = value
    return made


def _without(
    scene: dict[str, Any], side: str, **more: dict[str, Any]
) -> dict[str, Any]:
    scene["boundary"] = {
        name: part for name, part in scene["boundary"].items() if name != side
    } | more
    return scene


BEDS = {
    "rectangles": bed(PLANE),
    "triangles": bed(PLANE | {"shape": "triangle"}),
    # steps of 1 ms let theta alternate from one to the next, which multiplies rounding
    "triangles_algebraic": bed(
        PLANE | {"shape": "triangle"},
        two_fluid={"granular_temperature": "algebraic"},
        time={"first": 2.5e-4, "longest": 5e-4},
    ),
    "triangles_second_order": bed(PLANE | {"shape": "triangle"}, time={"order": 2}),
    "triangles_around_an_axis": _without(
        _without(
            bed(
                {
                    "type": "axisymmetric",
                    "radius": 0.02,
                    "length": 0.1,
                    "cells": [6, 25],
                    "shape": "triangle",
                }
            ),
            "left",
        ),
        "right",
        wall=JET["boundary"]["left"],
    ),
    "periodic": _without(
        _without(bed(PLANE), "left", left={"type": "periodic", "partner": "right"}),
        "right",
    ),
    "tetrahedra": bed(
        {
            "type": "box",
            "length": 0.03,
            "width": 0.02,
            "height": 0.08,
            "cells": [3, 2, 8],
            "shape": "tetrahedron",
        },
        boundary={"front": {"type": "wall"}, "back": {"type": "wall"}},
        time={"first": 1e-4, "longest": 1e-4},
    ),
    "hexahedra": bed(
        {
            "type": "box",
            "length": 0.03,
            "width": 0.02,
            "height": 0.08,
            "cells": [3, 2, 8],
        },
        boundary={"front": {"type": "wall"}, "back": {"type": "wall"}},
    ),
    "factors_near_walls": bed(PLANE, closures={"drag": "igci", "wall_drag": "igci"}),
    "closed": _without(
        bed(PLANE | {"shape": "triangle"}),
        "top",
        bottom={"type": "wall"},
        top={"type": "wall"},
    ),
}
BEDS |= {
    "heated": heated(BEDS["triangles"]),
    "heated_closed": heated(BEDS["closed"]),
    "heated_rectangles": heated(
        BEDS["rectangles"],
        {"gas.density_law": "constant", "two_fluid.conductivity_gas": 0.05},
    ),
}
PULSE = {
    "type": "inlet",
    "on": "bottom",
    "start": 0.012,
    "end": 0.028,
    "gas": {"velocity": 2.0, "temperature": 900.0},
    "until": 0.02,
}
BEDS["pulse"] = BEDS["heated"] | {
    "boundary": BEDS["heated"]["boundary"] | {"pulse": PULSE}
}
BEDS["averaged"] = bed(
    PLANE | {"shape": "triangle"}, time={"average_from": 0.012, "fields": 0.02}
)
