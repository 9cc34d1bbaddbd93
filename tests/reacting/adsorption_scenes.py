"""Beds that adsorb a trace of gas, for which closed forms exist."""

from __future__ import annotations

from typing import Any

import numpy as np
from reacting_bed_scenes import MOLAR, P, T, isothermal

from tests.scene_text import set_keys

# mole fraction: what is adsorbed changes the flow of the gas by this share
TRACE = 1e-6
# of `isothermal`; density of the particles [kg/m3]
EPS, DIAMETER, DENSITY, SPEED = 0.4, 3e-3, 1000.0, 0.5
AREA = 6.0 * (1.0 - EPS) / DIAMETER  # [1/m]
GAS_DIFFUSIVITY = 1e-5  # [m2/s]
# of a reaction of particles
CORE = {"law": "shrinking_core", "A": 1.0, "E": 0.0, "diffusivity": 1e-6}


def adsorber(
    K: float, units: float, biot: float, capacity: float | None = None
) -> tuple[dict[str, Any], float]:
    """A clean bed of 1 m and the time of one transfer unit.

    K : held by particles per volume over the concentration of the gas that enters
    units : k_f a L/u; biot : k_f R/D
    capacity : q_s over what is in equilibrium with the gas that enters; None: a
        straight isotherm
    """
    film = units * SPEED / AREA
    scene = isothermal(f"A:{TRACE!r}, N:{1.0 - TRACE!r}", {})
    scene["gas"] |= {
        "diffusivity": GAS_DIFFUSIVITY,
        "species": {
            "A": {"elements": {"C": 1.0}, "molar_mass": 0.044},
            "N": {"elements": {"N": 2.0}, "molar_mass": 0.028},
        },
    }
    scene["solids"]["particles"] |= {"density": DENSITY}
    scene["closures"] |= {"sherwood": film * DIAMETER / GAS_DIFFUSIVITY}
    loading = K * TRACE * MOLAR / DENSITY  # [mol/kg] in equilibrium with what enters
    gas: dict[str, Any] = {
        "diffusivity": film * 0.5 * DIAMETER / biot,
        "temperature": T,
    }
    if capacity is None:
        gas["henry"] = loading / (TRACE * P)
    else:
        gas |= {
            "capacity": capacity * loading,
            "affinity": 1.0 / (capacity - 1.0) / (TRACE * P),
        }
    scene["solids"]["particles"]["adsorption"] = {"A": gas}
    set_keys(
        scene,
        """
        time = {}
        packed_bed.gas_storage = "quasi_steady"
        initial.gas = { composition = "N:1" }
        output.positions = [1.0]
        """,
    )
    return scene, (1.0 - EPS) * K / (film * AREA)


def constant_pattern(X: Any, r: float) -> Any:
    """Transfer units after the mean breakthrough at which a Langmuir front is at
    c/c_0 = X, where the film resists.

    r = 1/(1 + b p) of the gas that enters; Vermeulen, Adv. Chem. Eng. 2 (1958) 147.
    """
    return (np.log(X) - r * np.log(1.0 - X)) / (1.0 - r) + 1.0
