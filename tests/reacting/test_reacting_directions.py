"""Beds mirrored along x, streams along each other, and inlets with a known state
inside.
"""

from __future__ import annotations

import numpy as np
from pytest import approx
from reacting_bed_scenes import (
    bilinear,
    danckwerts,
    isothermal,
    let_move,
    solids,
    species,
)

import contbed as cb
from contbed.loading import from_dict
from studies.clc_moving_bed import study as clc
from tests.balances import assert_closed

RESULTS = (
    "conversion_CH4",
    "conversion_Fe2O3",
    "pressure_drop_Pa",
    "T_solid_out_K",
    "T_fluid_out_K",
)


def test_a_mirrored_bed_gives_the_same():
    scene = cb.load(clc.HERE / "iron_oxide.toml")
    values = scene.model_dump(exclude_none=True)
    values["boundary"] = {
        "left": values["boundary"]["right"],
        "right": values["boundary"]["left"],
    }
    ours, mirrored = cb.run(scene), cb.run(from_dict(values))
    for key in RESULTS:
        assert mirrored.qoi[key] == approx(ours.qoi[key], rel=1e-9), key


def test_streams_along_each_other():
    """Bilinear rate with equal mole flows: F = 1/(1 + N) of both."""
    scene = bilinear(3.0, 1.0)
    scene["boundary"]["left"]["solids"] = scene["boundary"].pop("right")["solids"]
    qoi = cb.run(from_dict(scene)).qoi
    assert qoi["x_A_out"] == approx(0.25, abs=1e-8)
    assert 1.0 - qoi["conversion_S"] == approx(0.25, abs=1e-8)


def test_known_composition_inside_of_the_inlet():
    Pe, Da = 10.0, 1.0
    scene = danckwerts(Pe, Da)
    scene["boundary"] = {"left": {"gas": {"velocity": 0.5, "fixed_temperature": 500.0}}}
    scene["output"]["positions"] = [0.0, 1.0]
    result = cb.run(from_dict(scene))
    a = np.sqrt(1.0 + 4.0 * Da / Pe)
    p, m = 0.5 * Pe * (1.0 + a), 0.5 * Pe * (1.0 - a)
    # c = A e^(p z) + B e^(m z) with c(0) = 1 and c'(1) = 0
    A = -m * np.exp(m) / (p * np.exp(p) - m * np.exp(m))
    exact = A * np.exp(p) + (1.0 - A) * np.exp(m)
    assert result.profiles["x_A [1]"] == approx([1.0, exact], abs=1e-6)
    assert_closed(result, 1e-12, "H")


def test_particles_that_move_without_reacting_carry_heat():
    """Counter-current exchange of equal capacities with NTU = 3: effectiveness
    NTU/(1 + NTU).
    """
    cp, G, L, d = 30.0, 0.5, 0.5, 3e-3
    gases = species(A=0.028)
    gases["A"] |= {"heat_capacity": cp, "enthalpy": 0.0}
    capacity = G * cp / 0.028
    scene = isothermal("A:1", gases)
    scene["gas"] |= {"conductivity": 0.03, "viscosity": 2e-5}
    scene["mesh"]["length"] = L
    scene["solids"]["particles"] |= {
        k: v for k, v in solids().items() if k == "density"
    } | {"heat_capacity": 800.0}
    scene["boundary"]["left"]["gas"] = {"mass_flux": G, "temperature": 400.0}
    let_move(scene, -capacity / 800.0 / 3000.0, temperature=800.0)
    scene["heat"] = {}
    scene["closures"] |= {"nusselt": 3.0 * capacity / L / (6.0 * 0.6 / d) * d / 0.03}
    result = cb.run(from_dict(scene))
    assert result.qoi["T_fluid_out_K"] == approx(400.0 + 400.0 * 0.75, abs=1e-5)
    assert result.qoi["T_solid_out_K"] == approx(800.0 - 400.0 * 0.75, abs=1e-5)


def test_streams_of_one_temperature_enter_with_their_own():
    """Gas at 400 K and particles at 800 K along it mix to their mean by capacity where
    the bed has one temperature.
    """
    cp, G, velocity = 30.0, 0.5, 1e-4
    gases = species(A=0.028)
    gases["A"] |= {"heat_capacity": cp, "enthalpy": 0.0}
    scene = isothermal("A:1", gases)
    scene["gas"] |= {"conductivity": 0.03, "viscosity": 2e-5}
    scene["solids"]["particles"] |= {
        k: v for k, v in solids().items() if k == "density"
    } | {"heat_capacity": 800.0}
    let_move(scene, velocity, temperature=800.0)
    scene["boundary"]["left"]["gas"] = {"mass_flux": G, "temperature": 400.0}
    scene["heat"] = {}
    result = cb.run(from_dict(scene))
    gas, particles = G * cp / 0.028, velocity * 3000.0 * 800.0
    mixed = (gas * 400.0 + particles * 800.0) / (gas + particles)
    assert result.qoi["T_fluid_out_K"] == approx(mixed, abs=1e-6)
    assert_closed(result, 1e-12, "energy")
