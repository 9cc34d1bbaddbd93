"""Beds that adsorb: breakthrough against Rosen and the linear driving force,
Langmuir fronts, moving beds, heat.
"""

from __future__ import annotations

import numpy as np
import pytest
from adsorption_scenes import SPEED, TRACE, adsorber, constant_pattern
from numpy.testing import assert_allclose
from reacting_bed_scenes import P, T, let_move

import contbed
from contbed.loading import from_dict
from contbed.particle.uptake import breakthrough, moving_bed
from contbed.reacting_bed.plan import plan
from tests.balances import assert_closed
from tests.cases import each_case
from tests.refusals import refused
from tests.scene_text import changed, set_keys

CLOSED = 1e-12
K = 200.0  # per volume of particles over per volume of gas
SHARES = np.array([0.5, 0.8, 1.0, 1.2, 1.6])  # of the mean breakthrough


def breaks_through(scene, unit, units, cells=8):
    """What leaves over what enters, at five times about the mean breakthrough."""
    times = SHARES * units * unit
    scene["time"] |= {"end": times[-1], "times": list(times[:-1])}
    scene["mesh"]["cells"] = cells
    result = contbed.run(from_dict(scene))
    assert_closed(result, CLOSED, "C", "N")
    return result.profiles["x_A [1]"] / TRACE, result


# errors are those of the points inside, see the table of `contbed.particle.interior`,
# and of steps to 1e-4: 2e-5
@pytest.mark.parametrize(
    ("level", "points", "biot", "units", "tolerance"),
    [("interior", 4, 10.0, 5.0, 1e-4), ("linear_driving_force", 3, 10.0, 5.0, 1e-4)],
)
def test_breakthrough(level, points, biot, units, tolerance):
    scene, unit = adsorber(K, units, biot)
    scene["solids"]["particles"]["inside"] = {"adsorption": level, "points": points}
    found, _ = breaks_through(scene, unit, units)
    law = {"interior": "interior", "linear_driving_force": "effective"}[level]
    assert_allclose(
        found, breakthrough(units, units * SHARES, biot, law), atol=tolerance
    )


def test_porous_particles_hold_gas_as_well():
    """Half of what is held is in the pores: the same curve."""
    units = 5.0
    scene, unit = adsorber(1.0, units, 1.0)
    set_keys(scene, "solids.particles.porosity = 0.5")
    scene["solids"]["particles"]["adsorption"]["A"]["henry"] *= 0.5
    set_keys(
        scene,
        """
        solids.particles.inside = { adsorption = "linear_driving_force" }
        """,
    )
    found, _ = breaks_through(scene, unit, units)
    assert_allclose(
        found, breakthrough(units, units * SHARES, 1.0, "effective"), atol=1e-4
    )


def test_a_langmuir_front_keeps_its_shape():
    """q_s 1.25 times the loading in equilibrium with the feed: r = 0.2; the film
    alone resists.
    """
    units, capacity = 12.0, 1.25
    scene, unit = adsorber(K, units, 1.0, capacity)
    set_keys(scene, 'solids.particles.inside = { adsorption = "film" }')
    levels = np.array([0.1, 0.3, 0.5, 0.7, 0.9])
    times = (units + constant_pattern(levels, 1.0 - 1.0 / capacity)) * unit
    scene["time"] |= {"end": times[-1], "times": list(times[:-1]), "tolerance": 3e-3}
    set_keys(scene, "mesh.cells = 6")
    result = contbed.run(from_dict(scene))
    # steps to 3e-3 leave 1e-4 and less
    assert_allclose(result.profiles["x_A [1]"] / TRACE, levels, atol=5e-4)
    assert_closed(result, CLOSED, "C")


@pytest.mark.parametrize(
    ("gamma", "biot", "fourier"), [(-0.8, 1.0, 1.0), (0.5, 10.0, 0.3)]
)
def test_a_steady_bed_that_moves(gamma, biot, fourier):
    """Clean particles move along or against the gas."""
    units = 3.0 * abs(gamma) * biot * fourier
    scene, _ = adsorber(K, units, biot)
    del scene["time"]
    let_move(scene, gamma * SPEED / K)
    set_keys(
        scene,
        """
        solids.particles.inside = { adsorption = "interior", points = 6 }
        """,
    )
    result = contbed.run(from_dict(scene))
    assert result.qoi["x_A_out"] / TRACE == pytest.approx(
        moving_bed(gamma, biot, fourier), abs=1e-6
    )
    assert_closed(result, CLOSED, "C")
    # what the gas has lost, to the errors of polynomials at the end
    qoi = result.qoi
    taken = result.balances["C"]["in"] - qoi["out_A_mol_m2s"]
    found = qoi["solids_out_kg_m2s"] * qoi["q_A_out_mol_kg"]
    assert found == pytest.approx(taken, rel=1e-5)


def test_heat_of_adsorption_stays_in_the_bed():
    """A closed balance of energy; all heat leaves with the gas or is stored."""
    scene, _ = adsorber(K, 20.0, 1.0)
    share = 0.1
    scene["gas"]["composition"] = f"A:{share}, N:{1.0 - share}"
    for data in scene["gas"]["species"].values():
        data |= {
            "heat_capacity": 30.0,
            "enthalpy": 0.0,
            "conductivity": 0.03,
            "viscosity": 2e-5,
        }
    loading = 0.5
    scene["solids"]["particles"]["adsorption"]["A"] = {
        "capacity": loading,
        "affinity": 1e-4,
        "enthalpy": -3e4,
        "diffusivity": 1e-6,
        "temperature": T,
    }
    set_keys(
        scene,
        """
        solids.particles.heat_capacity = 900.0
        heat = {}
        closures.nusselt = 10.0
        """,
    )
    del scene["output"]["positions"]
    set_keys(
        scene,
        """
        time = { end = 60.0, tolerance = 1e-3 }
        packed_bed.gas_storage = "auto"
        initial.gas = { composition = "N:1" }
        mesh.cells = 6
        solids.particles.inside = { adsorption = "linear_driving_force" }
        """,
    )
    result = contbed.run(from_dict(scene))
    assert_closed(result, CLOSED)
    # where the front has passed an adiabatic bed is warmer by -dH q/c_p at most, and by
    # more than half of it, as the gas carries the rest ahead
    full = 3e4 * result.profiles["q_A [mol/kg]"].max() / 900.0
    assert 0.5 * full < result.profiles["T_solid [K]"].max() - T < 1.5 * full


def test_gases_compete_for_sites():
    """A bed that is filled with what enters holds both gases in the shares of their
    affinities.
    """
    scene, _ = adsorber(K, 20.0, 1.0)
    set_keys(scene, 'gas.composition = "A:0.02, C:0.01, N:0.97"')
    set_keys(scene, "gas.species.C = { elements = { O = 2.0 }, molar_mass = 0.032 }")
    same = {"capacity": 1.0, "diffusivity": 1e-5, "temperature": T}
    scene["solids"]["particles"]["adsorption"] = {
        "A": same | {"affinity": 1e-3},
        "C": same | {"affinity": 4e-3},
    }
    set_keys(scene, "time.end = 100.0")
    scene["initial"] |= {"gas": {"composition": scene["gas"]["composition"]}}
    set_keys(scene, "mesh.cells = 2")
    result = contbed.run(from_dict(scene))
    a, c = 1e-3 * 0.02 * P, 4e-3 * 0.01 * P
    assert_allclose(result.profiles["q_A [mol/kg]"], a / (1.0 + a + c), rtol=1e-10)
    assert_allclose(result.profiles["q_C [mol/kg]"], c / (1.0 + a + c), rtol=1e-10)


def test_isotherms_follow_the_temperature():
    from contbed.particle.adsorption import Isotherm

    isotherm = Isotherm(2e-5, None, -2e4, 300.0)
    # d ln H/dT = dH/(R T2)
    slope = (
        isotherm.affinity_at(300.5) - isotherm.affinity_at(299.5)
    ) / isotherm.affinity_at(300.0)
    assert slope == pytest.approx(-2e4 / 8.31446261815324 / 300.0**2, rel=1e-4)


@pytest.mark.parametrize(
    ("biot", "units", "level"),
    [
        (0.02, 20.0, "film"),
        (1.0, 20.0, "linear_driving_force"),
        (10.0, 5.0, "interior"),
    ],
)
def test_the_plan_chooses_the_cheapest_level(biot, units, level):
    scene, unit = adsorber(K, units, biot)
    scene["time"]["end"] = units * unit
    chosen = plan(from_dict(scene))
    assert chosen.problem.choices["particles"].level == level
    assert "Predicted outlet error" in dict(chosen.built)["adsorption of A"]


@each_case(__file__, "mistakes")
def test_mistakes(said, changes, without):
    scene, _ = adsorber(K, 20.0, 1.0)
    set_keys(scene, "time.end = 1.0")
    set_keys(scene, "gas.species.A2 = { elements = { C = 1.0 }, molar_mass = 0.044 }")
    scene = changed(scene, changes, without)
    refused(said, lambda: plan(from_dict(scene)))


def test_absent_adsorption_adds_no_unknowns():
    scene, _ = adsorber(K, 20.0, 1.0)
    del scene["solids"]["particles"]["adsorption"], scene["time"]
    layout = plan(from_dict(scene)).problem.layout
    assert layout.names == ("g_A", "g_N")
