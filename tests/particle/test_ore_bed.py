"""Ore of several sizes in mixed gas: where reduction stops, limits of supply and of
kinetics.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pytest import approx

from studies.iron_ore_bed.model import (
    AREA_OF_TUBE,
    HEMATITE,
    R_GAS,
    Fitted,
    Ore,
    Run,
    mole_fractions,
    reduce,
)

GAS = {"CO": 0.3802, "CO2": 0.4376, "H2": 0.01166, "H2O": 0.0445, "N2": 0.1261}


def test_reduction_stops_at_the_stoichiometry_of_wustite():
    run = Run(1023.15, GAS, (0.0, 1.0, 1.0))
    found = reduce(run, Ore(), Fitted(), np.array([0.0, 3000.0, 4000.0]))
    assert found[0] == approx(1 / 9, rel=1e-12)
    # CO and H2 of this gas are not in equilibrium with each other: 1e-4 of the iron
    # follows the one or the other
    assert found[1:] == approx(np.full(2, 1 / 3), abs=2e-4)


def test_fast_ore_takes_what_the_gas_can_at_equilibrium():
    run = Run(1023.15, {**GAS, "H2": 0.0, "H2O": 0.0}, (0.0, 1.0, 1.0))
    t = 60.0
    # no resistance of diffusion either, in grains as small
    ore = replace(Ore(), radii=(1e-6,), shares=(1.0,))
    found = reduce(run, ore, Fitted(), np.array([0.0, t]))
    x = mole_fractions(run.gas)
    K = np.exp(3.661 - 3132.5 / run.temperature)
    supply = (
        (x["CO"] - (x["CO"] + x["CO2"]) / (1 + K))
        * run.pressure
        / (R_GAS * run.temperature)
    )
    oxygen = 3.0 * Ore().mass / HEMATITE
    assert (found[1] - found[0]) / t == approx(
        supply * run.velocity * AREA_OF_TUBE / oxygen, rel=2e-3
    )


def test_half_of_the_gas_gives_half_of_the_supply():
    run = Run(1023.15, GAS, (0.0, 1.0, 1.0))
    ore = replace(Ore(), radii=(1e-6,), shares=(1.0,))
    whole, half = (
        np.diff(reduce(run, ore, Fitted(1.0, c), np.array([0.0, 60.0])))[0]
        for c in (1.0, 0.5)
    )
    assert half / whole == approx(0.5, rel=5e-3)
