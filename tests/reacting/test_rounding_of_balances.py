"""Balances of beds that hold much more than reacts or passes: two kinds of cores at
rest in a gas that changes.

The scenes are those of 40 drawn at random whose balances were open the most: by 5e-10
of what had reacted, which is the rounding of what is held, and by 2e-12 of the heat of
the streams, which is what the corrections of a step left.
"""

from __future__ import annotations

import pytest
from solving import CLOSED

import contbed
from contbed.loading import from_dict
from tests.scene_text import scene_of, set_keys

# J/mol/K, J/mol
GASES = {"H2": (29.0, 0.0), "H2O": (36.0, -241.8e3), "N2": (30.0, 0.0)}
# and kg/m3
SOLIDS = {
    "FeO": (50.0, -272e3, 5700.0),
    "Fe": (30.0, 0.0, 7800.0),
    "Al2O3": (100.0, -1675e3, 3900.0),
}


def kind(share, diameter, oxide):
    """Cores of FeO in alumina; `share` of the volume of all particles, `oxide` that
    of the mass.
    """
    names = ("heat_capacity", "enthalpy", "density")
    return {
        "volume_share": share,
        "diameter": diameter,
        "composition": f"FeO:{oxide}, Al2O3:{round(1.0 - oxide, 6)}",
        "porosity": 0.3,
        "constituent": {
            name: dict(zip(names, data, strict=True)) for name, data in SOLIDS.items()
        },
    }


def bed(length, cells, mass_flux, hottest, oxide, fast):
    """A bed of two kinds whose gas and its temperature change; `fast` [m/s] of the
    rate constant of the cores.
    """
    gas = {name: {"heat_capacity": c, "enthalpy": h} for name, (c, h) in GASES.items()}
    composition = {
        "times": [0.0, 200.0],
        "values": ["H2:0.5, N2:0.5", "H2:0.2, H2O:0.24, N2:0.56"],
        "form": "linear",
    }
    warmer = {"times": [0.0, 200.0], "values": [900.0, hottest]}
    return scene_of(
        """
            heat = {}
            closures = { nusselt = "gunn", sherwood = "wakao_funazkri" }
            time = { end = 200.0, tolerance = 1e-2 }
            initial = { temperature = 800.0 }
            output = { plots = false }
            solver = { balance_tolerance = 1.0 }

            [mesh]
            type = "line"

            [gas]
            model = "ideal_gas"
            pressure = 1.5e5
            viscosity = 4e-5
            conductivity = 0.2
            diffusivity = 4e-4

            [packed_bed]
            porosity = 0.42
            pressure_drop = "ergun"
            gas_storage = "quasi_steady"

            [reactions.r]
            equation = "FeO + H2 -> Fe + H2O"
            law = "shrinking_core"
            E = 6e4
            diffusivity = 4e-6
        """,
        {
            "mesh.length": length,
            "mesh.cells": cells,
            "gas.species": gas,
            "solids.coarse": kind(0.34, 6e-3, oxide),
            "solids.fine": kind(0.66, 2e-3, oxide),
            "boundary.left.gas.mass_flux": mass_flux,
            "boundary.left.gas.temperature": warmer,
            "boundary.left.gas.composition": composition,
            "reactions.r.A": fast,
        },
    )


@pytest.mark.parametrize(
    "shape",
    [
        (0.3, 4, 0.6, 1000.0, 0.5, 3e-6),
        (0.3, 4, 0.5, 1150.0, 0.5, 4e-4),
        (0.6, 8, 0.1, 750.0, 0.9, 1e-6),
    ],
    ids=["little reacts", "heated", "long and slow"],
)
def test_balances_close_where_much_is_held(shape):
    closes(bed(*shape))


def test_energy_closes_in_many_steps():
    """Particles of 7 and 1 mm that a warmer gas heats in some hundred steps."""
    scene = bed(0.28, 4, 0.52, 1090.0, 0.5, 4.4e-4)
    scene["solids"] = {
        "coarse": kind(0.375, 7e-3, 0.5),
        "fine": kind(0.625, 1.06e-3, 0.5),
    }
    set_keys(scene, "reactions.r.diffusivity = 2.3e-5")
    values = ["H2:0.5, N2:0.5", "H2:0.8, H2O:0.06, N2:0.14"]
    scene["boundary"]["left"]["gas"]["composition"] = {
        "times": [0.0, 200.0],
        "values": values,
        "form": "step",
    }
    set_keys(
        scene,
        """
        boundary.left.gas.temperature.times = [0.0, 400.0]
        time.end = 374.0
        time.tolerance = 1e-3
        initial.temperature = 715.5
        """,
    )
    closes(scene)


def closes(scene):
    balances = contbed.run(from_dict(scene)).balances
    assert set(balances) >= {"H", "N", "O", "Fe", "energy"}
    for name, balance in balances.items():
        assert abs(balance["relative_residual"]) < CLOSED, name


def test_a_steep_isotherm():
    """Zeolite that is full at a thousandth of the pressure of what enters: what is left
    of an error of the gas is a thousand times as much in the zeolite. Balances were
    open by 4e-9.
    """
    scene = scene_of(
        """
        mesh = { type = "line", length = 0.5, cells = 5 }
        packed_bed = { porosity = 0.4, pressure_drop = "none", gas_storage = "quasi_steady" }
        heat = {}
        closures = { sherwood = "wakao_funazkri" }
        boundary.left.gas = { velocity = 0.2, temperature = 298.15 }
        initial = { temperature = 298.15, gas.composition = "N2:1" }
        time = { end = 250.0, tolerance = 1e-3 }
        output = { plots = false }
        solver = { balance_tolerance = 1.0 }

        [gas]
        model = "ideal_gas"
        composition = "CO2:0.01, N2:0.99"
        pressure = 1e5
        viscosity = 1.85e-5
        diffusivity = "fuller"
        species.CO2 = { heat_capacity = 37, enthalpy = 0 }
        species.N2 = { heat_capacity = 29.1, enthalpy = 0 }

        [solids.zeolite]
        diameter = 4e-3
        density = 1100
        heat_capacity = 920
        inside.adsorption = "linear_driving_force"

        [solids.zeolite.adsorption.CO2]
        capacity = 1.0
        affinity = 1.0
        diffusivity = 2e-6
        enthalpy = -40e3
        """
    )
    balances = contbed.run(from_dict(scene)).balances
    for name in ("C", "N", "energy"):
        assert abs(balances[name]["relative_residual"]) < 10.0 * CLOSED, name
