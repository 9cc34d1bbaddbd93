"""Beds of two fluids for runs on ranks: the check cases, and a bed that moves on each kind of mesh."""

from copy import deepcopy
from pathlib import Path
from typing import Any

CHECKS = Path(__file__).parents[2] / "studies" / "two_fluid_checks"
CHECK_CASES = (
    "closed_box_jj",
    "cooling",
    "cooling_drag",
    "crossing",
    "fixed_bed",
    "rest",
    "riemann",
    "settling",
    "shear",
    "slip",
    "uniform_gidaspow",
    "uniform_syamlal",
    "uniform_wenyu",
)
JET = {
    "two_fluid": {"drag": "drag_gidaspow", "friction_viscosity": "friction_viscosity_schaeffer"},
    "gas": {"density": 1.2, "viscosity": 1.8e-5},
    "solid": {"particle_diameter": 5e-4, "density": 2500.0, "restitution": 0.9, "packing": 0.63},
    "initial": {"theta": 1e-3, "noise": 0.02, "layer": [{"end": 0.06, "eps_s": 0.58, "u_solid": 0.1}]},
    "boundary": {
        "bottom": {"type": "inlet", "velocity": 0.8},
        "top": {"type": "outlet"},
        "left": {"type": "wall", "solid": "johnson_jackson", "specularity": 0.05, "restitution": 0.9},
        "right": {"type": "wall"},
    },
    "time": {"end": 0.05, "sample": 0.01, "first": 5e-4, "longest": 1e-3},
    "output": {"plots": False},
}
PLANE = {"type": "rectangle", "length": 0.04, "height": 0.1, "cells": [10, 25]}


def bed(mesh: dict[str, Any], **more: dict[str, Any]) -> dict[str, Any]:
    """The jet on a mesh with some keys changed, by table."""
    scene = deepcopy(JET) | {"mesh": mesh}
    for name, table in more.items():
        scene[name] = scene.get(name, {}) | table
    return scene


def _without(scene: dict[str, Any], side: str, **more: dict[str, Any]) -> dict[str, Any]:
    scene["boundary"] = {name: part for name, part in scene["boundary"].items() if name != side} | more
    return scene


BEDS = {
    "rectangles": bed(PLANE),
    "triangles": bed(PLANE | {"shape": "triangle"}),
    "triangles_algebraic": bed(PLANE | {"shape": "triangle"}, two_fluid={"granular_temperature": "algebraic"}),
    "triangles_second_order": bed(PLANE | {"shape": "triangle"}, time={"order": 2}),
    "triangles_around_an_axis": _without(
        _without(
            bed({"type": "axisymmetric", "radius": 0.02, "length": 0.1, "cells": [6, 25], "shape": "triangle"}), "left"
        ),
        "right",
        wall=JET["boundary"]["left"],
    ),
    "periodic": _without(_without(bed(PLANE), "left", left={"type": "periodic", "partner": "right"}), "right"),
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
    "factors_near_walls": bed(PLANE, two_fluid={"drag": "igci", "wall_drag": "igci"}),
    "closed": _without(bed(PLANE | {"shape": "triangle"}), "top", bottom={"type": "wall"}, top={"type": "wall"}),
}
