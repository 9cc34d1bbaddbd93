"""Small scenes that together use every form and every model that both engines have."""

from pathlib import Path
from typing import Any

MESHES = Path(__file__).parents[2] / "meshes"
GAS = {
    "model": "cantera",
    "composition": "N2:0.7, CO2:0.2, H2O:0.1",
    "pressure": "1 bar",
}
CONSTANT = {
    "density": 1.2,
    "heat_capacity": 1000.0,
    "conductivity": 0.05,
    "viscosity": 2e-5,
}
STEEL = {"density": 7800.0, "heat_capacity": 500.0, "conductivity": 1.5}
SILICA = {
    "density": 2200.0,
    "heat_capacity": [560.0, 0.75, -2.2e-4],
    "conductivity": 1.8,
}
DIAMETER, POROSITY = 0.006, 0.42
INLET = {"gas": {"velocity": 0.5, "fixed_temperature": 700.0}}
WALL = {"type": "no_slip"}
COOL = {"gas": {"coefficient": 30.0, "ambient": 300.0}}
CHANNEL = {
    "type": "rectangle",
    "length": 0.2,
    "height": 0.05,
    "cells": [12, 5],
    "shape": "triangle",
}
BOX = {
    "type": "box",
    "length": 0.1,
    "width": 0.04,
    "height": 0.05,
    "cells": [4, 3, 3],
    "shape": "tetrahedron",
}
LINE = {"type": "line", "length": 1.0, "cells": 30}
CONDUCTING = {"nusselt": "gunn", "conductivity_solids": 0.5}


def bed(
    mesh: dict[str, Any], solid: dict[str, Any] = STEEL, **tables: Any
) -> dict[str, Any]:
    """A scene with a bed at rest that hot gas enters; tables replace its own."""
    scene = {
        "mesh": mesh,
        "gas": CONSTANT,
        "solids": {"particles": solid | {"diameter": DIAMETER}},
        "packed_bed": {"porosity": POROSITY},
        "closures": {"nusselt": "wakao_kaguei"},
        "heat": {},
        "boundary": {"left": INLET},
    }
    scene |= tables
    return {name: table for name, table in scene.items() if table is not None}


def flow(mesh: dict[str, Any], **boundary: Any) -> dict[str, Any]:
    """The flow alone through a bed."""
    return bed(mesh, {}, closures=None, heat=None, boundary=boundary)


def gas(velocity: float, temperature: float) -> dict[str, Any]:
    """Gas that enters."""
    return {"gas": {"velocity": velocity, "temperature": temperature}}


def solids(**condition: float) -> dict[str, Any]:
    """A condition of the particles."""
    return {"solids": {"particles": condition}}


RADIATING = {"temperature": 1200.0, "emissivity": 0.9}
SCENES: dict[str, dict[str, Any]] = {
    "flow": flow(CHANNEL, left={"gas": {"velocity": 0.5}}, bottom=WALL),
    "flow_moving_bed": flow(
        CHANNEL | {"shape": "quadrilateral"},
        left={"gas": {"velocity": 0.3}}, right=solids(velocity=0.1), bottom=WALL, top=WALL,
    ),
    "line": bed(LINE | {"cells": None}, boundary={"left": INLET, "right": solids(fixed_temperature=400.0)}),
    "line_counter_current": bed(
        LINE, boundary={"left": gas(0.3, 300.0), "right": solids(velocity=2e-4, temperature=500.0)}
    ),
    "heat_plug_flow": bed(CHANNEL, boundary={"left": INLET, "bottom": COOL}, solver={"degree": 1}),
    "heat_constant": bed(CHANNEL, boundary={"left": INLET, "bottom": WALL | COOL}),
    "heat_unstabilised": bed(
        CHANNEL, SILICA, gas=GAS, boundary={"left": INLET, "bottom": WALL | COOL}, solver={"stabilisation": False}
    ),
    "heat_gas_walls": bed(
        CHANNEL | {"shape": "quadrilateral"}, SILICA, gas=GAS,
        closures={"nusselt": "gunn", "dispersion": "wakao_kaguei", "tortuosity": -1e-4,
                  "conductivity_solids": {"name": "zehner_bauer_schluender", "emissivity": 0.8}},
        boundary={
            "left": gas(0.4, 400.0) | solids(velocity=1e-3, fixed_temperature=800.0),
            "top": WALL | solids(heat_flux=200.0),
            "bottom": WALL | {"gas": {"coefficient": "li_finlayson", "ambient": 350.0}},
        },
    ),
    "heat_degree_3": bed(
        CHANNEL, SILICA, gas=GAS, boundary={"left": INLET, "bottom": WALL | COOL}, solver={"degree": 3}
    ),
    "heat_tables": bed(
        CHANNEL, SILICA, gas={"model": "coolprop", "name": "CO2", "pressure": "10 bar", "T_range": [290.0, 900.0]},
        boundary={"left": gas(0.2, 320.0) | solids(fixed_temperature=700.0), "bottom": WALL},
    ),
    "heat_sources_and_tubes": bed(
        {"type": "file", "file": str(MESHES / "two_layers.msh")}, STEEL | {"emissivity": 0.8},
        closures=CONDUCTING, radiation={"level": "p1"},
        boundary={"left": {"gas": {"velocity": [0.5, 0.0], "fixed_temperature": 700.0}}},
        region={"lower": {"solids": {"heat_source": 1e5}, "gas": {"heat_source": 2e4},
                          "tubes": {"area": 20.0, "emissivity": 0.7, "temperature": 400.0}}},
    ),
    "heat_axisymmetric": bed(
        {"type": "file", "file": str(MESHES / "moving_bed_heater.msh"), "axisymmetric": True}, SILICA,
        gas={"model": "cantera", "composition": "H2O:1", "pressure": "2 bar"},
        boundary={
            "bottom": {"gas": {"velocity": [0.0, 0.6], "temperature": 430.0}},
            "top": {"solids": {"particles": {"velocity": [0.0, -8e-4], "fixed_temperature": 970.0}}},
            "wall": WALL,
        },
    ),
    "heat_tetrahedra": bed(
        BOX, boundary={"left": {"gas": {"velocity": 0.3, "fixed_temperature": 700.0}}, "bottom": WALL | COOL}
    ),
    "heat_hexahedra": bed(
        BOX | {"shape": "hexahedron"},
        boundary={"left": {"gas": {"velocity": 0.3, "fixed_temperature": 700.0}}, "bottom": WALL | COOL},
    ),
    "transient": bed(LINE, time={"end": 400.0, "times": [100.0, 250.0]}, initial={"temperature": 300.0}),
    "transient_gas": bed(
        CHANNEL, SILICA, gas=GAS, boundary={"left": INLET, "bottom": WALL},
        time={"end": 60.0, "times": [30.0], "step": 6.0}, initial={"temperature": 500.0},
    ),
    "radiation_in_bed": bed(
        CHANNEL, SILICA | {"emissivity": 0.8}, gas=GAS, closures=CONDUCTING, radiation={"level": "p1"},
        boundary={
            "left": gas(0.5, 500.0) | {"radiation": RADIATING},
            "top": solids(fixed_temperature=1100.0) | {"radiation": {"temperature": 1100.0, "emissivity": 0.7}},
            "bottom": WALL,
        },
    ),
    "radiation_transient": bed(
        LINE, STEEL | {"emissivity": 0.8}, closures=CONDUCTING, radiation={"level": "two_flux"},
        boundary={"left": gas(0.5, 500.0) | {"radiation": RADIATING}},
        time={"end": 40.0, "step": 10.0}, initial={"temperature": 400.0},
    ),
    "rosseland_in_bed": bed(
        LINE, SILICA | {"emissivity": 0.8}, gas=GAS, closures=CONDUCTING, radiation={"level": "rosseland"},
        boundary={"left": gas(0.5, 500.0) | solids(fixed_temperature=1100.0)},
    ),
}  # fmt: skip
MEDIUM = {
    "mesh": LINE | {"cells": 20},
    "radiation": {"level": "two_flux", "absorption": 3.0, "scattering": 2.0},
    "boundary": {
        "left": {"radiation": {"temperature": 1000.0, "emissivity": 0.8}},
        "right": {"radiation": {"temperature": 500.0, "emissivity": 0.6}},
    },
}
SCENES |= {
    "medium_equilibrium": MEDIUM,
    "medium_conducting": {
        **MEDIUM,
        "radiation": MEDIUM["radiation"] | {"level": "p1", "conductivity": 0.5},
    },
    "medium_rosseland": {
        **MEDIUM,
        "radiation": MEDIUM["radiation"] | {"level": "rosseland", "conductivity": 0.5},
    },
    "medium_plane": {
        **MEDIUM,
        "mesh": CHANNEL | {"length": 1.0, "height": 1.0},
        "radiation": MEDIUM["radiation"] | {"level": "p1"},
    },
}
for _scene in SCENES.values():
    _scene["output"] = {"plots": False}
    if "mesh" in _scene and _scene["mesh"].get("cells", 0) is None:
        _scene["mesh"] = {k: v for k, v in _scene["mesh"].items() if v is not None}
