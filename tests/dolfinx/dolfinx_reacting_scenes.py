"""Small reacting beds that together use every term on a line, both directions and both kinds of ends."""

import sys
import tomllib
from copy import deepcopy
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "reacting"))

from adsorption_scenes import adsorber  # noqa: E402
from reacting_bed_scenes import danckwerts, isothermal, looping, shrinking_core, species  # noqa: E402
from several_solids import split, split_adsorbing, split_pellets  # noqa: E402

KINDS = {"elements": {"H": 28.0}, "molar_mass": 0.028, "heat_capacity": 30.0}


def study(path: str, **mesh: Any) -> dict[str, Any]:
    """The tables of a study, with keys of its mesh replaced, and profiles where they do not depend on its cells."""
    found = tomllib.loads((ROOT / "studies" / path).read_text(encoding="utf-8"))
    found["mesh"] |= mesh
    length = found["mesh"]["length"]
    return found | {"output": {"positions": [length * k / 20 for k in range(21)]}}


def to_the_left(scene: dict[str, Any]) -> dict[str, Any]:
    """The same with gas that comes from the right, where its composition and temperature are fixed."""
    scene = deepcopy(scene)
    scene["flow"]["velocity"] = -scene["flow"]["velocity"]
    scene["boundary"] = {"right": {"fluid": {"fixed": 500.0}}}
    return scene


def burning(**tables: Any) -> dict[str, Any]:
    """A -> B that heats a bed which conducts and mixes along it, two temperatures."""
    gases = {"A": {**KINDS, "enthalpy": 4000.0}, "B": {**KINDS, "enthalpy": 0.0}}
    scene = isothermal("A:0.9, B:0.1", gases)
    scene["mesh"]["cells"] = 12
    scene["fluid"] |= {"viscosity": 2e-5, "conductivity": 0.05, "diffusivity": 2e-5}
    scene["solid"] = {"density": 2000.0, "heat_capacity": 800.0}
    scene["heat"] = {"nusselt": "nusselt_gunn", "conductivity_solid": 1.0, "conductivity_fluid": 0.5}
    scene["mass"] = {"dispersion": 0.02, "sherwood": "sherwood_ranz_marshall"}
    scene["reactions"] = {"r": {"equation": "A -> B", "A": 5e3, "E": 4e4}}
    return scene | tables


def section() -> dict[str, Any]:
    """Rings of a tube whose wall cools, one temperature."""
    wall = {"diameter": 0.1, "coefficient": 50.0, "ambient": 600.0}
    rings = {"rings": 3, "conductivity_solid": 2.0, "dispersion": 1e-3}
    return burning(wall=wall, section=rings, heat={}, mass={"dispersion": 0.02})


def pellets() -> dict[str, Any]:
    """First order inside of pellets that are resolved."""
    scene = isothermal("A:1", species(A=0.028, B=0.028))
    scene["mesh"] |= {"length": 0.05, "cells": 8}
    rate = {"equation": "A -> B", "rate": "k*c_A", "parameters": {"k": 20.0}, "basis": "particle"}
    scene["particle"] = {"mass": "interior", "diffusivity": {"A": 2e-6, "B": 5e-6}}
    return scene | {"reactions": {"r": rate}, "solid": {"density": 1000.0}}


def pellets_across() -> dict[str, Any]:
    """Pellets in rings of a tube whose wall cools."""
    scene = section()
    scene["reactions"]["r"] |= {"A": 5e4, "basis": "particle"}
    return scene | {"particle": {"mass": "interior", "diffusivity": {"A": 2e-6, "B": 5e-6}}}


def front() -> dict[str, Any]:
    """A front of what is adsorbed, resolved inside of the particles, over a time in which it moves."""
    scene, unit = adsorber(K=200.0, units=10.0, biot=10.0, capacity=3.0)
    scene["time"] |= {"end": unit, "tolerance": 1e-2}
    scene["mesh"]["cells"] = 6
    scene["output"]["positions"] = [0.1, 0.2, 0.5, 1.0]
    return scene


def sorbent_that_reacts() -> dict[str, Any]:
    """A -> B in particles at rest that adsorb A, with points inside, over a time in which they fill."""
    scene, unit = adsorber(K=200.0, units=5.0, biot=5.0)
    scene["fluid"]["species"]["B"] = scene["fluid"]["species"]["A"]
    scene["reactions"] = {"r": {"equation": "A -> B", "A": 80.0 / unit, "E": 0.0, "basis": "particle"}}
    scene["time"] |= {"end": 2.0 * unit, "tolerance": 1e-2}
    scene["mesh"]["cells"] = 4
    scene["output"]["positions"] = [0.1, 0.2, 0.5, 1.0]
    return scene


def kinds_that_adsorb() -> dict[str, Any]:
    """Two sizes that move at unlike speeds against a gas that they take up, with points inside."""
    scene, _ = adsorber(K=200.0, units=10.0, biot=10.0)
    del scene["time"]
    scene["flow"]["velocity_solid"] = -2e-3
    scene["boundary"]["right"] = {"solid": {"inflow": 500.0}}
    scene["mesh"]["cells"] = 8
    scene["output"]["positions"] = [0.1, 0.2, 0.5, 1.0]
    scene["particle"] = {"adsorption": "interior", "points": 2}
    return split_adsorbing(scene, coarse={"particle_diameter": 6e-3, "velocity_solid": -1e-3})


def kinds_of_pellets() -> dict[str, Any]:
    """Two sizes of pellets that are resolved inside."""
    return split_pellets(pellets(), coarse={"particle_diameter": 6e-3})


def kinds_across() -> dict[str, Any]:
    """Two sizes of particles, of two temperatures beside that of the gas, in rings of a tube whose wall cools."""
    scene = burning(wall=section()["wall"], section=section()["section"] | {"conductivity_fluid": 0.5})
    scene["mesh"]["cells"] = 6
    scene = split(scene, coarse={"particle_diameter": 6e-3})
    scene["reactions"]["r"] |= {"basis": "particle", "solid": "fine"}
    return scene


def warming(gas: str) -> dict[str, Any]:
    """A bed over the time in which what enters gets warmer."""
    scene = burning(time={"end": 400.0, "gas": gas, "tolerance": 1e-2, "initial_temperature": 500.0})
    scene["boundary"]["left"]["fluid"]["inflow"] = {"times": [0.0, 400.0], "values": [500.0, 540.0]}
    scene["mesh"]["cells"] = 8
    return scene


def warming_finely() -> dict[str, Any]:
    """The same with stored gas and steps so short that stages end where rounding decides."""
    scene = warming("stored")
    scene["time"]["tolerance"] = 1e-3
    return scene


def going_on() -> dict[str, Any]:
    """The same from profiles of temperatures and fractions."""
    scene = warming("stored")
    del scene["time"]["initial_temperature"]
    scene["time"]["end"], scene["mesh"]["cells"] = 4.0, 4
    scene["time"]["initial"] = {"file": str(ROOT / "tests" / "reacting" / "tables" / "start_of_a_burning_bed.csv")}
    return scene


def following() -> dict[str, Any]:
    """The same on cells that follow its errors, with a gas that is stored."""
    scene = warming("stored")
    del scene["mesh"]["cells"]
    return scene | {"solver": {"adapt": 6, "tolerance": 1e-5}}


def kinds_stored() -> dict[str, Any]:
    """Two sizes in rings whose wall cools, in a hot gas that is stored: its matrix is often computed anew."""
    scene = kinds_across()
    scene["time"] = {"end": 400.0, "gas": "stored", "tolerance": 1e-2, "initial_temperature": 500.0}
    for kind in scene["solids"].values():
        kind |= {"density": 2000.0, "heat_capacity": 800.0}
    return scene


SCENES: dict[str, dict[str, Any]] = {
    "first_order": danckwerts(5.0, 2.0),
    "first_order_to_the_left": to_the_left(danckwerts(5.0, 2.0)),
    "shrinking_core": shrinking_core(N=2.0, n=0.8, f=0.3, d=0.4, r=0.3),
    "burning": burning(),
    "burning_to_the_left": to_the_left(burning()),
    "section": section(),
    "pellets": pellets(),
    "pellets_across": pellets_across(),
    "adsorption": front(),
    "sorbent_that_reacts": sorbent_that_reacts(),
    "kinds_that_adsorb": kinds_that_adsorb(),
    "kinds_of_pellets": kinds_of_pellets(),
    "kinds_across": kinds_across(),
    "warming": warming("quasi_steady"),
    "warming_stored": warming_finely(),
    "going_on": going_on(),
    "following": following(),
    "cycle": looping(),
    "kinds_stored": kinds_stored(),
    "reformer_tube": study("reformer_tube/tube_U300.toml"),
    "clc_moving_bed": study("clc_moving_bed/iron_oxide.toml"),
    "branch": study("ignition_front/adiabatic_bed.toml", cells=6),
}
LONG = (
    "adsorption",
    "branch",
    "cycle",
    "following",
    "going_on",
    "kinds_stored",
)  # hundreds of linear systems: solved on one rank alone
SCENES["branch"]["continuation"] |= {"to": 0.1, "points": 6}
SCENES["cycle"]["mesh"]["cells"] = 2
SCENES["cycle"]["fluid"]["composition"]["values"] = ["A:0.8, O:0.2", "A:0.2, O:0.8"]  # none of a gas vanishes
SCENES["cycle"]["time"] |= {"tolerance": 1e-2, "cycle": {"tolerance": 1e-6}}
for _scene in SCENES.values():
    _scene["output"] = _scene.get("output", {}) | {"plots": False}
