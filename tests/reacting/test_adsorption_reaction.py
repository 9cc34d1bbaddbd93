"""Gases that react in the particles that adsorb them: transforms of breakthroughs,
steady states, balances, limits.
"""

from __future__ import annotations

import numpy as np
import pytest
from adsorption_scenes import TRACE, adsorber
from pytest import approx
from reacting_bed_scenes import T, let_move
from several_solids import split
from solving import CLOSED, solved

import contbed
from contbed.loading import from_dict
from contbed.particle.uptake import invert
from contbed.reacting_bed.plan import plan
from tests.balances import assert_closed
from tests.cases import each_case
from tests.refusals import refused
from tests.scene_text import scene_of, set_keys

K = 200.0  # held per volume of particles over the concentration around them
UNITS = 5.0
POINTS = 8  # inside of a sphere, to 1e-9


def reacting(biot: float, Da: float, level: str, **adsorption):
    """A trace A -> B of first order in particles that adsorb A, and the time of a
    transfer unit.

    Da : rate constant over (1 - eps), over k_f a, both per volume of bed
    """
    scene, unit = adsorber(K, UNITS, biot)
    scene["gas"]["species"]["B"] = scene["gas"]["species"]["A"]
    k = Da * K / unit
    scene["reactions"] = {
        "r": {"equation": "A -> B", "A": k, "E": 0.0, "basis": "particle"}
    }
    scene["solids"]["particles"]["inside"] = {"adsorption": level, "points": POINTS}
    scene["solids"]["particles"]["adsorption"] |= adsorption
    return scene, unit


def resistance(biot: float, Da: float, level: str):
    """What particles take of (c - 0) k_f a, over the transform p in transfer units:
    film, and what is inside.

    Inside of a sphere g = (phi coth phi - 1)/Bi with phi^2 = 3 Bi (p + Da); the linear
    driving force adds Bi/5.
    """

    def share(p):
        if level == "interior":
            phi = np.sqrt(3.0 * biot * (p + Da))
            g = (phi / np.tanh(phi) - 1.0) / biot
            return g / (1.0 + g)
        inside = 1.0 + (biot / 5.0 if level == "linear_driving_force" else 0.0)
        return (p + Da) / (1.0 + inside * (p + Da))

    return share


@pytest.mark.parametrize(
    ("biot", "Da", "level"),
    [(1.0, 0.3, "film"), (2.0, 0.5, "linear_driving_force"), (5.0, 0.4, "interior")],
)
def test_breakthrough(biot, Da, level):
    """The transform of what leaves is exp(-units share(p))/p."""
    scene, unit = reacting(biot, Da, level)
    times = np.array([1.0, 2.0, 4.0, 8.0])
    scene["time"] |= {
        "end": times[-1] * unit,
        "times": list(times[:-1] * unit),
        "tolerance": 1e-5,
    }
    set_keys(scene, "mesh.cells = 4")
    result = solved(scene)
    share = resistance(biot, Da, level)
    exact = invert(lambda p: np.exp(-UNITS * share(p)) / p, times)
    # local errors of 1e-5 of what enters; the largest error found is 1e-5
    np.testing.assert_allclose(result.profiles["x_A [1]"] / TRACE, exact, atol=5e-5)
    assert 0.05 < exact[-1] < 0.9


@pytest.mark.parametrize(
    ("biot", "Da", "level"),
    [(1.0, 0.3, "film"), (2.0, 0.5, "linear_driving_force"), (5.0, 0.4, "interior")],
)
def test_steady_state(biot, Da, level):
    """Particles at rest that react have a steady state: exp(-units share(0)),
    whatever they adsorb.
    """
    found = []
    for more in (1.0, 3.0):
        scene, _ = reacting(biot, Da, level)
        scene["solids"]["particles"]["adsorption"]["A"]["henry"] *= more
        del scene["time"]
        found.append(solved(scene).qoi["x_A_out"] / TRACE)
    assert found[0] == approx(
        np.exp(-UNITS * resistance(biot, Da, level)(0.0)), abs=1e-8
    )
    assert found[1] == approx(found[0], abs=1e-12)


def test_a_film_alone_is_that_of_particles_that_do_not_adsorb():
    """One concentration in the particle is that at its surface; both are solved to
    Newton's 1e-10.
    """
    scene, _ = reacting(1.0, 0.3, "film")
    del scene["time"]
    one = solved(scene)
    del (
        scene["solids"]["particles"]["adsorption"],
        scene["solids"]["particles"]["inside"],
    )
    other = solved(scene)
    for key in ("x_A_out", "x_B_out", "extent_r_mol_m2s"):
        assert one.qoi[key] == approx(other.qoi[key], rel=1e-9), key


def hot(level: str):
    """A -> 2 B with heat, both adsorbed with heat, in a bed of two temperatures."""
    scene, unit = reacting(2.0, 0.4, level)
    set_keys(
        scene,
        """
        gas.composition = "A:0.1, N:0.9"
        gas.species.B = { elements = { C = 0.5 }, molar_mass = 0.022 }
        reactions.r.equation = "A -> 2 B"
        """,
    )
    for name, data in scene["gas"]["species"].items():
        formed = {"A": 0.0, "B": -4e3, "N": 0.0}[name]
        data |= {
            "heat_capacity": 30.0,
            "enthalpy": formed,
            "conductivity": 0.03,
            "viscosity": 2e-5,
        }
    same = {
        "diffusivity": scene["solids"]["particles"]["adsorption"]["A"]["diffusivity"],
        "temperature": T,
    }
    scene["solids"]["particles"]["adsorption"] = {
        "A": same | {"capacity": 1.0, "affinity": 1e-4, "enthalpy": -2e4},
        "B": same | {"capacity": 0.5, "affinity": 2e-5, "enthalpy": -1e4},
    }
    set_keys(
        scene,
        """
        solids.particles.heat_capacity = 900.0
        heat = {}
        closures.nusselt = 10.0
        mesh.cells = 6
        """,
    )
    del scene["output"]["positions"]
    return scene, unit


@pytest.mark.parametrize("level", ["film", "interior"])
def test_balances_in_time(level):
    """Elements and energy, to rounding."""
    scene, unit = hot(level)
    set_keys(scene, "solids.particles.inside.points = 3")
    scene["time"] = {"end": 2.0 * unit, "tolerance": 1e-3}
    set_keys(scene, 'packed_bed.gas_storage = "auto"')
    set_keys(scene, 'initial.gas = { composition = "N:1" }')
    result = solved(scene)
    assert {"C", "N", "energy"} <= set(result.balances)
    assert result.profiles["q_B [mol/kg]"].max() > 1e-3
    assert result.profiles["T_solid [K]"].max() - T > 5.0


def test_balances_of_particles_that_move():
    """What particles hold of both gases leaves with them."""
    scene, _ = hot("interior")
    let_move(scene, -0.02, temperature=T)
    set_keys(scene, "solids.particles.inside.points = 3")
    del scene["time"]
    result = solved(scene)
    carbon = result.balances["C"]
    assert carbon["relative_residual"] == approx(0.0, abs=CLOSED)
    by_gas = result.qoi["out_A_mol_m2s"] + 0.5 * result.qoi["out_B_mol_m2s"]
    assert by_gas < 0.98 * carbon["in"]


def test_equal_kinds_are_one():
    """Two kinds of the same particles, to what Newton's method leaves."""
    scene, _ = hot("interior")
    set_keys(scene, "solids.particles.inside.points = 3")
    del scene["time"]
    one = solved(scene)
    set_keys(scene, 'reactions.r.solid = ["fine", "coarse"]')
    two = solved(split(scene))
    for key in ("x_A_out", "x_B_out", "T_fluid_out_K"):
        assert two.qoi[key] == approx(one.qoi[key], rel=1e-9), key


def test_a_product_that_is_adsorbed_shifts_the_equilibrium():
    """A <-> B + C with K = p_B p_C/p_A of 0.05 bar: more than the equilibrium reacts
    until C has filled the particles.

    x^2/(1 - x^2) p = K with the share x that reacts of pure A at 1 bar; what is left to
    take up is a millionth.
    """
    scene, unit = reacting(1.0, 20.0, "film")
    scene["gas"]["composition"] = "A:1"
    scene["gas"]["species"] = scene_of("""
        [A]
        elements = { C = 2.0 }
        molar_mass = 0.044
        entropy = 0.0

        [B]
        elements = { C = 1.0 }
        molar_mass = 0.022
        entropy = 0.0

        [C]
        elements = { C = 1.0 }
        molar_mass = 0.022
        entropy = 0.0
    """)
    for data in scene["gas"]["species"].values():
        data |= {"heat_capacity": 30.0, "enthalpy": 0.0}
    scene["gas"]["species"]["A"]["entropy"] = -8.31446261815324 * np.log(0.05)
    scene["gas"]["species"]["B"]["heat_capacity"] = scene["gas"]["species"]["C"][
        "heat_capacity"
    ] = 15.0
    set_keys(scene, 'reactions.r.equation = "A <-> B + C"')
    # 20 transfer units, which leave exp(-20) of the distance
    scene["closures"]["sherwood"] *= 4.0
    isotherm = scene["solids"]["particles"]["adsorption"].pop("A")
    scene["solids"]["particles"]["adsorption"] = {"C": isotherm}
    scene["time"] = {"end": 40.0 * unit, "times": [1.0 * unit], "tolerance": 1e-3}
    set_keys(
        scene,
        """
        packed_bed.gas_storage = "auto"
        initial.gas = { composition = "A:1" }
        mesh.cells = 6
        output.positions = [1.0]
        """,
    )
    result = contbed.run(from_dict(scene))
    assert_closed(result, CLOSED)
    early, late = result.profiles["x_A [1]"]
    x = np.sqrt(0.05 / 1.05)
    assert late == approx((1.0 - x) / (1.0 + x), rel=1e-5)
    assert early < 0.9 * late


def test_the_plan_resolves_points_where_adsorbed_gases_react():
    scene, unit = reacting(0.02, 0.3, "auto")
    scene["time"]["end"] = unit
    found = plan(from_dict(scene))
    assert found.problem.choices["particles"].level == "interior"
    assert "as adsorbed gases react" in dict(found.built)["adsorption of A"]


@each_case(__file__, "pores_are_modelled_once")
def test_pores_are_modelled_once(inside):
    scene, unit = reacting(1.0, 0.3, "film")
    scene["time"]["end"] = unit
    set_keys(scene, "reactions.r.diffusivity = 1e-6")
    scene["solids"]["particles"]["inside"] = inside
    refused(
        r"reactions\.r: A is adsorbed by the particles in which it reacts: it diffuses",
        lambda: plan(from_dict(scene)),
    )
