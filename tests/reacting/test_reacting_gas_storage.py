"""Gas that is stored in the pores: exact distributions of residence times, order in
time, totals that close.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from reacting_bed_scenes import (
    MOLAR,
    danckwerts,
    ergun,
    fixed_bed,
    heated,
    isothermal,
    schumann,
    species,
    table,
)
from solving import course_of

import contbed
from contbed.errors import ConvergenceError
from contbed.fem.line_dg import System
from contbed.loading import from_dict
from contbed.particle.uptake import invert
from contbed.reacting_bed.plan import plan
from contbed.reacting_bed.solve import Report
from contbed.reacting_bed.stages import GAMMA, stages
from tests.balances import assert_closed
from tests.cases import each_case
from tests.refusals import refused
from tests.scene_text import changed, scene_of, set_keys

CLOSED = 1e-12
RESIDENCE = 0.8  # [s] of the gas in `danckwerts`: 0.4 of 1 m at 0.5 m/s


def vessel(Pe, Da):
    """Transform over time in residence times of what leaves a closed vessel after a
    step (Danckwerts 1953).
    """

    def transform(p):
        a = np.sqrt(1.0 + 4.0 * (p + Da) / Pe)
        fall = (1.0 + a) ** 2 - (1.0 - a) ** 2 * np.exp(-a * Pe)
        return 4.0 * a * np.exp(0.5 * Pe * (1.0 - a)) / fall / p

    return transform


def dispersed(Pe, Da, **time):
    scene = danckwerts(Pe, Da)
    set_keys(
        scene,
        """
        mesh.cells = 16
        output.positions = [1.0]
        initial = { gas = { composition = "B:1" } }
        """,
    )
    scene["time"] = {"end": 2.0 * RESIDENCE} | time
    return scene


@pytest.mark.parametrize(("Pe", "Da"), [(20.0, 0.0), (5.0, 1.0)])
def test_a_step_through_a_vessel_with_dispersion(Pe, Da):
    times = np.array([0.5, 1.0, 1.5, 2.0])
    result = contbed.run(from_dict(dispersed(Pe, Da, times=list(times * RESIDENCE))))
    exact = invert(vessel(Pe, Da), times)
    # steps to a local tolerance of 1e-4; the largest error found is 3e-5
    assert_allclose(result.profiles["x_A [1]"], exact, atol=1e-4)
    assert_closed(result, CLOSED, "H")


def test_a_trace_that_rises_is_as_right_as_a_main_gas():
    Da, peak, rises = 2.0, 1e-3, 2.0 * RESIDENCE
    scene = isothermal("A:0.001, N:0.999", species(A=0.028, B=0.028, N=0.028))
    scene["reactions"] = {"r": {"equation": "A -> B", "A": Da / RESIDENCE, "E": 0.0}}
    feed = {
        "times": [0.0, rises, 2.0 * rises],
        "values": ["N:1", f"A:{peak}, N:{1.0 - peak}", f"A:{peak}, N:{1.0 - peak}"],
    }
    times = np.array([1.6, 2.2, 2.8, 3.4])
    set_keys(
        scene,
        """
        mesh.cells = 40
        output.positions = [1.0]
        initial = { gas = { composition = "N:1" } }
        packed_bed.gas_storage = "stored"
        """,
    )
    scene["boundary"]["left"]["gas"]["composition"] = feed
    scene["time"] = {"end": 3.4 * RESIDENCE, "times": list(times * RESIDENCE)}
    result = contbed.run(from_dict(scene))
    # plug flow: what entered a residence time ago, less what has reacted since
    exact = peak * np.exp(-Da) * np.minimum((times - 1.0) * RESIDENCE / rises, 1.0)
    assert_allclose(result.profiles["x_A [1]"], exact, rtol=2e-3)


def test_a_quasi_steady_gas_is_early_by_its_residence():
    scene = dispersed(20.0, 0.0) | {"initial": {}}
    set_keys(scene, 'packed_bed.gas_storage = "quasi_steady"')
    result = contbed.run(from_dict(scene))
    assert np.all(result.tables["outlet"]["x_A [1]"] > 1.0 - 1e-9)


def test_rounding_does_not_decide_the_steps(monkeypatch):
    """Residuals with some roundings more, as another order of summation leaves:
    times are the same to the last bit.
    """
    scene, _ = heated(4.0)
    set_keys(
        scene,
        """
        mesh.cells = 8
        time.end = 400.0
        time.tolerance = 1e-3
        packed_bed.gas_storage = "stored"
        """,
    )
    plain = contbed.run(from_dict(scene)).tables["outlet"]
    random, assemble = np.random.default_rng(2), System.assemble

    def rounded(system, u, jacobian=True):
        residual, slopes = assemble(system, u, jacobian)
        size = np.abs(residual).max(axis=(1, 2), keepdims=True)
        return residual + 1e-15 * size * random.uniform(
            -1.0, 1.0, residual.shape
        ), slopes

    monkeypatch.setattr(System, "assemble", rounded)
    other = contbed.run(from_dict(scene)).tables["outlet"]
    assert len(plain["t [s]"]) > 30
    assert_array_equal(other["t [s]"], plain["t [s]"])
    assert_allclose(other["T_fluid [K]"], plain["T_fluid [K]"], rtol=1e-10)


def marched(course, steps):
    """States at the end of equal steps without control of the error."""
    u, dt = course.start(), course.time.end / steps
    for k in range(steps):
        problems = course.at((k + GAMMA) * dt), course.at((k + 1) * dt)
        _, u, _ = stages(problems, u, u, dt, Report(), course.sizes(u))
    return u


@pytest.mark.parametrize("rings", [0, pytest.param(2, marks=pytest.mark.slow)])
def test_order_two_in_time_with_inlets_that_change(rings):
    """Composition, temperature and flow rise linearly, the gas is stored, first-order
    reaction with heat.

    With rings the wall becomes hotter as well, and gas and heat pass across.
    """
    scene, _ = heated(4.0)
    mass, cp, end = 0.028, 30.0, 0.5
    scene["gas"]["species"]["B"] = {
        "elements": {"H": 28.0},
        "molar_mass": mass,
        "heat_capacity": cp,
        "enthalpy": -2e4,
    }
    scene["boundary"]["left"]["gas"] = scene_of(
        """
            [mass_flux]
            values = [0.4, 0.6]

            [temperature]
            values = [300.0, 400.0]

            [composition]
            values = ["A:0.2, B:0.8", "A:1"]
        """,
        {
            "mass_flux.times": [0.0, end],
            "temperature.times": [0.0, end],
            "composition.times": [0.0, end],
        },
    )
    set_keys(
        scene,
        """
        reactions = { r = { equation = "A -> B", A = 2.0, E = 5e3 } }
        solids.particles.density = 2.0
        solids.particles.heat_capacity = 800.0
        mesh.cells = 6
        """,
    )
    scene["time"] = {"end": end}
    set_keys(scene, 'packed_bed.gas_storage = "stored"')
    set_keys(scene, "initial.temperature = 300.0")
    if rings:
        hotter = {"times": [0.0, end], "values": [300.0, 500.0]}
        set_keys(scene, "mesh.diameter = 0.05")
        scene["boundary"]["wall"] = {"coefficient": 20.0, "ambient": hotter}
        scene["packed_bed"]["section"] = {
            "rings": rings,
            "conductivity_gas": 0.2,
            "conductivity_solids": 0.5,
            "dispersion_mass": 1e-3,
        }
    course = course_of(scene)
    sizes = course.problem.sizes[:, None, None]
    coarse, middle, fine = (marched(course, steps) / sizes for steps in (40, 80, 160))
    for k, name in enumerate(course.problem.names):
        ratio = np.abs(coarse[k] - middle[k]).max() / np.abs(middle[k] - fine[k]).max()
        # 4 for order 2; 3.97 to 4.18 are found, to 4.34 with rings, which comes to 4.18
        # with twice the steps
        assert 3.8 < ratio < 4.4, (name, ratio)


def test_heat_of_the_gas_delays_the_front():
    """At 10 MPa the gas holds a tenth of the heat: Schumann's curve comes later by
    the time the gas stays.
    """
    scene, eta_per_s = heated(4.0)
    scene["gas"]["pressure"] = 1e7
    # little, so that the density of the gas is nearly constant
    scene["boundary"]["left"]["gas"]["temperature"] = 302.0
    scene["time"] |= {"tolerance": 2e-3}
    scene["packed_bed"]["gas_storage"] = "stored"
    scene["solids"]["particles"] |= {"density": 200.0}
    scene["mesh"]["cells"] = 10
    eta_per_s *= 10.0
    scene["time"]["end"] = 5.0 / eta_per_s
    built = from_dict(scene)
    stay = plan(built).problem.gas_residence
    result = contbed.run(built)
    theta = (result.qoi["T_fluid_out_K"] - 300.0) / 2.0
    # the density changes by 0.7 % over the bed
    assert theta == pytest.approx(schumann(4.0, 5.0 - stay * eta_per_s), abs=2e-3)
    assert schumann(4.0, 5.0) - theta > 0.02
    # each stage is solved to 1e-14 of 1000 K, the heat that passes is that of 4 K
    assert_closed(result, 1e-10, "energy")


def test_gas_with_a_pressure_drop_closes():
    row = table("ergun_isothermal_gas")[0]
    scene = ergun(row)
    gases = scene["gas"]["species"]
    gases["B"] = {
        "elements": {"H": 2e3 * row["M_kg_mol"]},
        "molar_mass": 2.0 * row["M_kg_mol"],
    }
    set_keys(
        scene,
        """
        time = { end = 1.0, tolerance = 1e-3 }
        packed_bed.gas_storage = "stored"
        initial.gas = { composition = "B:1" }
        mesh.cells = 5
        """,
    )
    end = 2.0 * plan(from_dict(scene)).problem.gas_residence
    scene["time"]["end"] = end
    result = contbed.run(from_dict(scene))
    assert result.qoi["x_A_out"] > 0.95
    assert_closed(result, CLOSED, "H")


def test_the_plan_chooses_by_the_residence():
    scene = fixed_bed("bohart_adams", 0.0, 0.0, 0.0, 2.0, 0.8)
    assert not plan(from_dict(scene)).stores_gas  # 1.07 s of 800 s
    name, reason = plan(from_dict(scene)).skipped[-1]
    assert (name, reason) == (
        "storage in the gas",
        "what leaves is early by that: the gas stays for 1.07 s, 0.0013 of the run",
    )
    set_keys(
        scene,
        """
        boundary.left.gas.velocity = { times = [0.0, 50.0], values = [0.5, 0.4], form = "step" }
        """,
    )
    chosen = plan(from_dict(scene))
    assert chosen.stores_gas
    assert "0.027 of the shortest time between changes" in chosen.built[-1][1]


@each_case(__file__, "mistakes_in_what_fills_the_bed")
def test_mistakes_in_what_fills_the_bed(key, value, said):
    scene = changed(dispersed(20.0, 0.0), {key: value})
    refused(said, lambda: plan(from_dict(scene)))


def test_transient_heat_needs_particles():
    scene, _ = heated(4.0)
    set_keys(scene, "solids.particles = { diameter = 3e-3 }")
    set_keys(scene, "time.end = 1.0")
    refused(
        r"solids\.particles\.heat_capacity: missing; .* store heat", from_dict, scene
    )


@pytest.mark.parametrize("share", [-0.2, 1e-3])
def test_gas_that_cools_faster_than_it_enters_is_told(share):
    """Where the flow falls, gas in the pores takes the temperature of colder particles,
    and needs less room.

    With the lag dT of the gas behind the particles, n c dT/dt = h a dT holds before the
    jump: n/T dT/dt of the gas is g ln(T_in/T_out) of the former flow g, of 500 K where
    it enters and T_out, less the same of the flow that is left.
    """
    scene, eta_per_s = heated(4.0)
    end = 1.02 / eta_per_s
    scene["boundary"]["left"]["gas"]["mass_flux"] = {
        "times": [0.0, 1.0 / eta_per_s],
        "values": [0.5, 0.5 * share],
        "form": "step",
    }
    set_keys(scene, "boundary.left.gas.temperature = 500.0")
    set_keys(scene, "boundary.right = { gas = { temperature = 500.0 } }")
    scene["time"] |= {"end": end, "tolerance": 1e-3}
    set_keys(scene, 'packed_bed.gas_storage = "stored"')
    set_keys(scene, "mesh.cells = 5")
    with pytest.raises(
        ConvergenceError, match=r"the particles cool the gas .* it would flow back"
    ) as told:
        contbed.run(from_dict(scene))
    room = float(str(told.value).split("makes room for ")[1].split()[0])
    before = 0.5 / 0.028 * np.log(500.0 / (300.0 + 200.0 * schumann(4.0, 1.0)))
    assert room == pytest.approx(
        before * (1.0 - share if share > 0.0 else 1.0), rel=0.1
    )


def test_gas_that_is_used_up_faster_than_it_enters_is_told():
    """A bed full of A, 2 A -> B: k c L/2 of the moles vanish, more than enter; no
    step and no mesh helps.
    """
    scene = isothermal("A:1", species(A=0.014, B=0.028), time={"end": 10.0})
    scene["packed_bed"]["gas_storage"] = "stored"
    scene["reactions"] = {
        "r": {"equation": "2 A -> B", "A": 3.0, "E": 0.0, "orders": {"A": 1.0}}
    }
    # the rate of the equation is 3 c over the gas, 0.4 of the bed; the gas enters with
    # 0.5 m/s
    told = (
        f"reactions take {1.2 * MOLAR:.3g} mol/m2/s of the gas .* and "
        f"{0.5 * MOLAR:.3g} enter"
    )
    with pytest.raises(ConvergenceError, match=told):
        contbed.run(from_dict(scene))
