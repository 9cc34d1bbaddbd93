"""Several kinds of particles that adsorb, each by its own isotherms: alike they are
one; unlike they add up.
"""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest
from adsorption_scenes import (
    CORE,
    DENSITY,
    EPS,
    GAS_DIFFUSIVITY,
    SPEED,
    TRACE,
    adsorber,
)
from numpy.testing import assert_allclose
from pytest import approx
from reacting_bed_scenes import MOLAR, P, T, let_move, solids
from scipy.linalg import expm
from several_solids import SHARES, split
from solving import solved, stepped

from contbed.loading import from_dict
from contbed.many.derivatives.gradients import gradient_of
from contbed.particle.uptake import invert, uptake
from contbed.reacting_bed.course import Course
from contbed.reacting_bed.plan import plan
from tests.refusals import refused
from tests.scene_text import set_keys

# of two solutions of the same equations, whose Newton's methods end at 1e-10
ROUNDING = 1e-9
LEVELS = ("film", "linear_driving_force", "interior")
K = 200.0  # per volume of particles over per volume of gas


def warm(level):
    """A bed that adsorbs a fifth of its gas, with heat, two temperatures, straight
    isotherms and such that bend.
    """
    scene, _ = adsorber(K, 20.0, 1.0)
    set_keys(scene, 'gas.composition = "A:0.1, C:0.1, N:0.8"')
    set_keys(scene, "gas.species.C = { elements = { O = 2.0 }, molar_mass = 0.032 }")
    for data in scene["gas"]["species"].values():
        data |= {
            "heat_capacity": 30.0,
            "enthalpy": 0.0,
            "conductivity": 0.03,
            "viscosity": 2e-5,
        }
    at = {"diffusivity": 1e-6, "temperature": T}
    scene["solids"]["particles"]["adsorption"] = {
        "A": at | {"capacity": 0.5, "affinity": 1e-4, "enthalpy": -3e4},
        "C": at | {"henry": 1e-5, "enthalpy": -1e4},
    }
    set_keys(
        scene,
        """
        solids.particles.heat_capacity = 900.0
        solids.particles.porosity = 0.3
        solids.particles.conductivity = 0.2
        heat = {}
        closures.nusselt = "nusselt_wakao_kaguei"
        closures.conductivity_solids = 0.5
        closures.dispersion_mass = 1e-4
        packed_bed.pressure_drop = "ergun"
        """,
    )
    scene["solids"]["particles"]["inside"] = {"adsorption": level, "points": 2}
    set_keys(
        scene,
        """
        time = { end = 60.0, tolerance = 1e-3 }
        packed_bed.gas_storage = "auto"
        initial.gas = { composition = "N:1" }
        mesh.cells = 3
        """,
    )
    del scene["output"]["positions"]
    return scene


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("gas", ["quasi_steady", "stored"])
def test_steps_of_kinds_that_are_alike_are_those_of_one(level, gas):
    scene = warm(level)
    scene["packed_bed"]["gas_storage"] = gas
    one, two = stepped(scene, 2.0), stepped(split(scene), 2.0)
    assert np.ptp(one["T_solid"]) > 1.0
    for name, values in one.items():
        for found in [name] if name in two else [f"{name}_{kind}" for kind in SHARES]:
            assert two[found] == approx(values, rel=ROUNDING, abs=1e-12), found


def moving(scene, speed=-3e-3):
    del scene["time"]
    return let_move(scene, speed, temperature=T)


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("speed", [-3e-3, 3e-3], ids=["against", "along"])
def test_kinds_that_move_alike_are_one(level, speed):
    """Steady; profiles of the gas, of temperatures and of loadings."""
    scene = moving(warm(level), speed)
    one, two = solved(scene), solved(split(scene))
    for key, values in one.profiles.items():
        name, unit = key.split(" ")
        for column in (
            [key]
            if key in two.profiles
            else [f"{name}_{kind} {unit}" for kind in SHARES]
        ):
            assert two.profiles[column] == approx(values, rel=ROUNDING, abs=1e-12), (
                column
            )
    assert np.ptp(one.profiles["q_A [mol/kg]"]) > 0.01


@pytest.mark.parametrize("level", LEVELS)
def test_beads_that_adsorb_nothing_dilute_those_that_do(level, monkeypatch):
    """The share 0.3 of the volume alone, in a bed of as much more gas. Both begin with
    one step, which else follows the time that the gas stays.
    """
    monkeypatch.setattr(Course, "first_step", 1e-3)
    scene, unit = adsorber(K, 5.0, 10.0)
    scene["solids"]["particles"]["inside"] = {"adsorption": level}
    scene["time"] |= {"end": 3.0 * unit, "tolerance": 1e-3}
    set_keys(scene, "mesh.cells = 4")
    mixed = split(scene, {"sorbent": 0.3, "beads": 0.7}, beads={"adsorption": {}})
    scene["packed_bed"]["porosity"] = 1.0 - 0.3 * (1.0 - EPS)
    one, two = solved(scene), solved(mixed)
    assert one.qoi["time_steps"] == two.qoi["time_steps"]
    assert two.profiles["x_A [1]"] == approx(one.profiles["x_A [1]"], rel=1e-7)
    assert two.profiles["q_A_sorbent [mol/kg]"] == approx(
        one.profiles["q_A [mol/kg]"], rel=1e-7
    )
    assert 0.05 < one.profiles["x_A [1]"][-1] / TRACE < 0.95


# share, held over the gas, film [m/s], diameter [m], Bi
UNLIKE = {
    "fine": (0.4, 300.0, 0.02, 2e-3, 10.0),
    "coarse": (0.6, 80.0, 0.01, 5e-3, 4.0),
}


def unlike(level, **time):
    """Two kinds with their own isotherms, films, diameters and diffusion."""
    scene, _ = adsorber(K, 5.0, 1.0)
    scene["solids"] = {}
    for kind, (share, held, film, d, biot) in UNLIKE.items():
        scene["solids"][kind] = {
            "volume_share": share,
            "diameter": d,
            "density": DENSITY,
            "sherwood": film * d / GAS_DIFFUSIVITY,
            "adsorption": {
                "A": {
                    "henry": held * MOLAR / DENSITY / P,
                    "diffusivity": film * 0.5 * d / biot,
                }
            },
            "inside": {"adsorption": level, "points": 6},
        }
    set_keys(
        scene,
        """
        mesh.length = 0.2
        mesh.cells = 8
        output.positions = [0.2]
        """,
    )
    scene["time"] |= time
    return scene


# [s]
MEAN = (
    sum(share * held for share, held, *_ in UNLIKE.values()) * (1.0 - EPS) * 0.2 / SPEED
)


def passes(p, level):
    """Transform of the gas that leaves over its step, p in 1/s: each kind takes up
    by its own units and times.
    """
    exponent = 0.0
    for share, held, film, d, biot in UNLIKE.values():
        units = film * 6.0 * share * (1.0 - EPS) / d * 0.2 / SPEED
        rate = film * 0.5 * d / biot / (held * (0.5 * d) ** 2)
        exponent = exponent + units * uptake(p / rate, biot, level)
    return np.exp(-exponent) / p


@pytest.mark.parametrize(
    ("level", "exact"),
    [("linear_driving_force", "effective"), ("interior", "interior")],
)
def test_two_kinds_break_through_as_both_take_up(level, exact):
    """Straight isotherms, Laplace inverted on Talbot's contour; 1e-4 by steps to
    1e-4 and six points inside.
    """
    times = MEAN * np.array([0.5, 0.8, 1.0, 1.2, 1.6])
    scene = unlike(level, end=times[-1], times=list(times[:-1]))
    found = solved(scene).profiles["x_A [1]"] / TRACE
    assert_allclose(found, invert(lambda p: passes(p, exact), times), atol=1e-4)


def test_the_mean_breakthrough_is_what_both_hold():
    """The integral of what is missing of the step; trapezia over the steps and an
    end at 6 means leave 1e-3.
    """
    outlet = solved(unlike("film", end=6.0 * MEAN)).tables["outlet"]
    t, missing = outlet["t [s]"], 1.0 - outlet["x_A [1]"] / TRACE
    assert t[0] * missing[0] + np.trapezoid(missing, t) == approx(MEAN, rel=1e-3)


def test_kinds_of_unlike_speed_in_a_steady_bed():
    """Films alone, against the gas: the matrix exponential of gas and both kinds."""
    scene = unlike("film")
    del scene["time"], scene["mesh"]["cells"]
    v = {"fine": -1e-3, "coarse": -3e-3}
    scene["boundary"]["right"] = {
        "solids": {kind: {"velocity": -speed} for kind, speed in v.items()}
    }
    rows = np.zeros((3, 3))
    for i, (kind, (share, held, film, d, _)) in enumerate(UNLIKE.items(), 1):
        ka = film * 6.0 * share * (1.0 - EPS) / d
        rows[0, [0, i]] += np.array([-ka, ka]) / SPEED
        rows[i, [0, i]] = np.array([ka, -ka]) / (v[kind] * share * held)
    through = expm(rows * 0.2)
    enters = np.linalg.solve(through[1:, 1:], -through[1:, 0])  # clean at the right end
    exact = through[0] @ [1.0, *enters]
    found = solved(scene).qoi["x_A_out"] / TRACE
    # the share by which the flow of the gas changes
    assert found == approx(exact, abs=TRACE)
    assert 0.05 < exact < 0.95


def test_derivatives_to_the_isotherm_of_one_kind():
    """Against central differences, which err by the square of 1e-4 and by what
    Newton's method leaves over it.
    """
    scene = split(moving(warm("interior")), coarse={"diameter": 5e-3})
    found = gradient_of(
        solved(scene), ["x_A_out"], ["solids.fine.adsorption.A.affinity"]
    )
    sides = []
    for change in (-1e-4, 1e-4):
        other = deepcopy(scene)
        other["solids"]["fine"]["adsorption"]["A"]["affinity"] *= 1.0 + change
        sides.append(solved(other).qoi["x_A_out"])
    slope = (sides[1] - sides[0]) / (
        2e-4 * scene["solids"]["fine"]["adsorption"]["A"]["affinity"]
    )
    assert found.derivatives[0, 0] == approx(slope, rel=1e-6)


def test_each_kind_follows_its_isotherms():
    """In a bed filled with what enters; gases compete within a kind alone."""
    scene = warm("linear_driving_force")
    scene["initial"] |= {"gas": {"composition": scene["gas"]["composition"]}}
    capacity = {
        "A": {"capacity": 1.0, "affinity": 2e-4},
        "C": {"capacity": 2.0, "affinity": 1e-4},
    }
    both = {
        gas: at | {"temperature": T, "diffusivity": 1e-6}
        for gas, at in capacity.items()
    }
    del scene["heat"]
    set_keys(scene, 'packed_bed.pressure_drop = "none"')
    set_keys(scene, "solids.particles.porosity = 0.0")
    found = solved(
        split(scene, coarse={"adsorption": {"A": both["A"]}}, fine={"adsorption": both})
    ).profiles
    a, c = 2e-4 * 0.1 * P, 1e-4 * 0.1 * P
    assert_allclose(found["q_A_coarse [mol/kg]"], a / (1.0 + a), rtol=1e-10)
    assert_allclose(found["q_A_fine [mol/kg]"], a / (1.0 + a + c), rtol=1e-10)
    assert_allclose(found["q_C_fine [mol/kg]"], 2.0 * c / (1.0 + a + c), rtol=1e-10)
    assert "q_C_coarse [mol/kg]" not in found


def test_a_catalyst_beside_a_sorbent():
    """What is adsorbed in one kind reacts in the other: of first order, exp(-Da)
    times the breakthrough.
    """
    Da = 0.7
    scene = unlike("linear_driving_force", end=1.2 * MEAN)
    set_keys(scene, "gas.species.B = { elements = { C = 1.0 }, molar_mass = 0.044 }")
    share = 0.25
    for table in scene["solids"].values():
        table["volume_share"] *= 1.0 - share
    scene["solids"]["catalyst"] = {
        "volume_share": share,
        "diameter": 3e-3,
        "density": DENSITY,
    }
    rate = Da * SPEED / (0.2 * share * (1.0 - EPS))
    scene["reactions"] = {
        "r": {
            "equation": "A -> B",
            "A": rate,
            "E": 0.0,
            "basis": "particle",
            "solid": "catalyst",
        }
    }
    scene["closures"]["sherwood"] = 1e12  # of the catalyst, nothing resists there
    found = solved(scene).profiles["x_A [1]"] / TRACE
    fewer = lambda p: (passes(p, "effective") * p) ** (1.0 - share) / p  # noqa: E731
    assert found == approx(
        np.exp(-Da) * invert(fewer, np.array([1.2 * MEAN])), abs=1e-4
    )


def test_all_that_differs_closes():
    """Elements and energy; the kind that adsorbs with more heat is the warmer one."""
    scene = warm("film")
    set_keys(scene, "time.end = 2.0")
    own = scene["solids"]["particles"]["adsorption"]
    hot = {"adsorption": {"A": own["A"] | {"enthalpy": -4e4}}, "diameter": 6e-3}
    cold = {
        "adsorption": {"C": own["C"]},
        "diameter": 2e-3,
        "nusselt": 3.0,
        "heat_capacity": 700.0,
    }
    result = solved(split(scene, coarse=hot, fine=cold))
    assert {"C", "O", "energy"} <= set(result.balances)
    warmer = result.profiles["T_solid_coarse [K]"] - result.profiles["T_solid_fine [K]"]
    assert warmer.max() > 0.5


def test_the_plan_chooses_for_each_kind():
    """Both may err, each by its part of solver.accuracy."""
    scene = unlike("auto", end=5.0 * MEAN)
    set_keys(scene, "mesh.length = 1.0")
    chosen = plan(from_dict(scene))
    told = dict(chosen.built)
    assert (
        "A: Bi = 10" in told["adsorption of A by fine"]
        and "A: Bi = 4" in told["adsorption of A by coarse"]
    )
    errors = {
        kind: choice.error["linear_driving_force"]
        for kind, choice in chosen.problem.choices.items()
    }
    scene["solver"] = {"accuracy": 1.9 * max(errors.values())}
    assert (
        plan(from_dict(scene)).problem.choices[max(errors, key=errors.get)].level
        == "interior"
    )
    scene["solver"] = {"accuracy": 2.1 * max(errors.values())}
    assert {c.level for c in plan(from_dict(scene)).problem.choices.values()} == {
        "linear_driving_force"
    }


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            lambda s: s["solids"]["fine"]["adsorption"].update(
                B=s["solids"]["fine"]["adsorption"]["A"]
            ),
            r"solids\.fine\.adsorption\.B: no gas of this name",
        ),
        (
            lambda s: s.pop("time"),
            r"solids\.fine\.adsorption: particles at rest take up nothing",
        ),
        (lambda s: s["initial"].pop("gas"), r"initial\.gas\.composition: missing"),
        (
            lambda s: s["solids"]["fine"]["adsorption"]["A"].pop("henry"),
            "give henry, or capacity and affinity",
        ),
        (
            lambda s: (
                s["solids"]["fine"].update(solids()),
                s.update(
                    reactions={
                        "r": {"equation": "A + S -> A2 + P", "solid": "fine", **CORE}
                    }
                ),
            ),
            r"reactions\.r: A is adsorbed by the particles in which it reacts, and shrinking_core has a film",
        ),
    ],
)
def test_mistakes(change, said):
    scene = unlike("film", end=1.0)
    set_keys(scene, "gas.species.A2 = { elements = { C = 1.0 }, molar_mass = 0.044 }")
    change(scene)
    refused(said, lambda: plan(from_dict(scene)))
