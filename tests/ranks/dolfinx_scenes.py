"""Small scenes that together use every form and every model that both engines have."""

from pathlib import Path
from typing import Any

MESHES = Path(__file__).parents[2] / "meshes"
GAS = {"model": "cantera", "composition": "N2:0.7, CO2:0.2, H2O:0.1", "pressure": "1 bar"}
CONSTANT = {"density": 1.2, "heat_capacity": 1000.0, "conductivity": 0.05, "viscosity": 2e-5}
STEEL = {"density": 7800.0, "heat_capacity": 500.0, "conductivity": 1.5}
SILICA = {"density": 2200.0, "heat_capacity": [560.0, 0.75, -2.2e-4], "conductivity": 1.8}
BED = {"porosity": 0.42, "particle_diameter": 0.006}
INLET = {"fluid": {"fixed": 700.0}}
WALL = {"type": "no_slip"}
COOL = {"fluid": {"coefficient": 30.0, "ambient": 300.0}}
CHANNEL = {"type": "rectangle", "length": 0.2, "height": 0.05, "cells": [12, 5], "shape": "triangle"}
BOX = {"type": "box", "length": 0.1, "width": 0.04, "height": 0.05, "cells": [4, 3, 3], "shape": "tetrahedron"}
LINE = {"type": "line", "length": 1.0, "cells": 30}


def bed(mesh: dict[str, Any], **tables: Any) -> dict[str, Any]:
    """A scene with a bed at rest that hot gas enters; tables replace its own."""
    scene = {
        "mesh": mesh,
        "fluid": CONSTANT,
        "solid": STEEL,
        "bed": BED,
        "flow": {"velocity": 0.5},
        "heat": {"nusselt": "wakao_kaguei"},
        "boundary": {"left": INLET},
    }
    scene |= tables
    return {name: table for name, table in scene.items() if table is not None}


SCENES: dict[str, dict[str, Any]] = {
    "flow": bed(CHANNEL, solid=None, heat=None, boundary={"bottom": WALL}),
    "flow_moving_bed": bed(
        CHANNEL | {"shape": "quadrilateral"}, solid=None, heat=None, boundary={"bottom": WALL, "top": WALL},
        flow={"velocity": 0.3, "velocity_solid": -0.1},
    ),
    "line": bed(LINE | {"cells": None}, boundary={"left": INLET, "right": {"solid": {"fixed": 400.0}}}),
    "line_counter_current": bed(
        LINE, flow={"velocity": 0.3, "velocity_solid": -2e-4},
        boundary={"left": {"fluid": {"inflow": 300.0}}, "right": {"solid": {"inflow": 500.0}}},
    ),
    "heat_plug_flow": bed(CHANNEL, boundary={"left": INLET, "bottom": COOL}, solver={"degree": 1}),
    "heat_constant": bed(CHANNEL, boundary={"left": INLET, "bottom": WALL | COOL}),
    "heat_unstabilised": bed(
        CHANNEL, fluid=GAS, solid=SILICA, boundary={"left": INLET, "bottom": WALL | COOL},
        solver={"stabilisation": False},
    ),
    "heat_gas_walls": bed(
        CHANNEL | {"shape": "quadrilateral"}, fluid=GAS, solid=SILICA,
        flow={"velocity": 0.4, "velocity_solid": 1e-3},
        heat={"nusselt": "gunn", "dispersion": "wakao_kaguei", "tortuosity": -1e-4,
              "conductivity_solid": {"name": "zehner_bauer_schluender", "emissivity": 0.8}},
        boundary={
            "left": {"fluid": {"inflow": 400.0}, "solid": {"fixed": 800.0}}, "top": WALL | {"solid": {"flux": 200.0}},
            "bottom": WALL | {"fluid": {"coefficient": "li_finlayson", "ambient": 350.0}},
        },
    ),
    "heat_degree_3": bed(
        CHANNEL, fluid=GAS, solid=SILICA, boundary={"left": INLET, "bottom": WALL | COOL}, solver={"degree": 3}
    ),
    "heat_tables": bed(
        CHANNEL, fluid={"model": "coolprop", "name": "CO2", "pressure": "10 bar", "T_range": [290.0, 900.0]},
        solid=SILICA, flow={"velocity": 0.2},
        boundary={"left": {"fluid": {"inflow": 320.0}, "solid": {"fixed": 700.0}}, "bottom": WALL},
    ),
    "heat_sources_and_tubes": bed(
        {"type": "file", "file": str(MESHES / "two_layers.msh")}, heat={"nusselt": "gunn", "conductivity_solid": 0.5},
        radiation={"level": "p1", "emissivity": 0.8},
        region={"lower": {"source_solid": 1e5, "source_fluid": 2e4,
                          "tubes": {"area": 20.0, "emissivity": 0.7, "temperature": 400.0}}},
    ),
    "heat_axisymmetric": {
        "mesh": {"type": "file", "file": str(MESHES / "moving_bed_heater.msh"), "axisymmetric": True},
        "fluid": {"model": "cantera", "composition": "H2O:1", "pressure": "2 bar"}, "solid": SILICA, "bed": BED,
        "flow": {"velocity": 0.6, "velocity_solid": -8e-4}, "heat": {"nusselt": "wakao_kaguei"},
        "boundary": {"bottom": {"fluid": {"inflow": 430.0}}, "top": {"solid": {"fixed": 970.0}}, "wall": WALL},
    },
    "heat_tetrahedra": bed(BOX, flow={"velocity": [0.3, 0.0, 0.0]}, boundary={"left": INLET, "bottom": WALL | COOL}),
    "heat_hexahedra": bed(
        BOX | {"shape": "hexahedron"}, flow={"velocity": [0.3, 0.0, 0.0]},
        boundary={"left": INLET, "bottom": WALL | COOL},
    ),
    "transient": bed(
        LINE, time={"end": 400.0, "times": [100.0, 250.0], "initial_fluid": 300.0, "initial_solid": 300.0}
    ),
    "transient_gas": bed(
        CHANNEL, fluid=GAS, solid=SILICA, boundary={"left": INLET, "bottom": WALL},
        time={"end": 60.0, "times": [30.0], "step": 6.0, "initial_fluid": 500.0, "initial_solid": 500.0},
    ),
    "radiation_in_bed": bed(
        CHANNEL, fluid=GAS, solid=SILICA, heat={"nusselt": "gunn", "conductivity_solid": 0.5},
        radiation={"level": "p1", "emissivity": 0.8},
        boundary={
            "left": {"fluid": {"inflow": 500.0}, "radiation": {"temperature": 1200.0, "emissivity": 0.9}},
            "top": {"solid": {"fixed": 1100.0}, "radiation": {"temperature": 1100.0, "emissivity": 0.7}},
            "bottom": WALL,
        },
    ),
    "radiation_transient": bed(
        LINE, heat={"nusselt": "gunn", "conductivity_solid": 0.5}, radiation={"level": "two_flux", "emissivity": 0.8},
        boundary={"left": {"fluid": {"inflow": 500.0}, "radiation": {"temperature": 1200.0, "emissivity": 0.9}}},
        time={"end": 40.0, "step": 10.0, "initial_fluid": 400.0, "initial_solid": 400.0},
    ),
    "rosseland_in_bed": bed(
        LINE, fluid=GAS, solid=SILICA, heat={"nusselt": "gunn", "conductivity_solid": 0.5},
        radiation={"level": "rosseland", "emissivity": 0.8},
        boundary={"left": {"fluid": {"inflow": 500.0}, "solid": {"fixed": 1100.0}}},
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
    "medium_conducting": {**MEDIUM, "radiation": MEDIUM["radiation"] | {"level": "p1", "conductivity": 0.5}},
    "medium_rosseland": {**MEDIUM, "radiation": MEDIUM["radiation"] | {"level": "rosseland", "conductivity": 0.5}},
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
