"""Beds with computed coefficients: the closures are those of the state reached, and
Newton's method sees all of it.
"""

from types import SimpleNamespace

import cantera as ct
import numpy as np
import pytest
from bubbling_scenes import solved
from computed_scenes import hot
from pytest import approx

import contbed as cb
from contbed import closures
from contbed.bubbling_bed.plan import plan
from contbed.bubbling_bed.problem import BubblingProblem
from contbed.loading import loads
from contbed.materials import gas_mixture

COLD = """
gas.composition = "O2:0.21, N2:0.79"
bubbling_bed = { height = 0.5, section = 0.1, solids_fraction = 0.55, bubbles = {} }

[boundary.bottom]
gas = { mass_flow = 0.0024, temperature = 293.15 }

[solids.quartz]
diameter = 2e-4
density = 2650
heat_capacity = 800
nusselt = "gunn"
mixing_conductivity = 1e3
"""

CLOSURES = {"bubbles": {"size": "horio_nonaka", "exchange": "sit_grace"}}
WALLS = {"perimeter": 3.5, "coefficient": 20.0, "temperature": 600.0, "emissivity": 0.8}
ABOVE = {"freeboard": {"height": 2.0, "walls": WALLS, "temperature_above": 500.0}}


@pytest.mark.parametrize("changes", [CLOSURES, ABOVE], ids=["bed", "freeboard"])
def test_jacobian_is_the_derivative(changes):
    problem = BubblingProblem(plan(hot(mesh={"cells": 8}, **changes)))
    random = np.random.default_rng(1)
    state = problem._state(
        problem._start(900.0) * (1 + 0.02 * random.normal(size=problem.system.size))
    )
    direction = random.normal(size=state.size) * np.abs(state)
    _, matrix = problem.assemble(state, True)
    plus, minus = (
        problem.assemble(state + sign * 1e-6 * direction, False)[0] for sign in (1, -1)
    )
    difference = (plus - minus) / 2e-6
    for name in problem.system.fields:
        exact, estimate = (
            problem.system.part(part, name) for part in (matrix @ direction, difference)
        )
        # central differences with a step of 1e-6: rounding of 1e-16/1e-6
        assert np.abs(exact - estimate).max() < 1e-8 * np.abs(estimate).max(), name


@pytest.mark.slow
def test_six_guesses_lead_to_one_state():
    found = [
        solved(hot(initial={"temperature": guess}))
        for guess in (400.0, 700.0, 1000.0, 1150.0, 1500.0, 2000.0)
    ]
    assert max(len(result.history) for result in found) <= 12
    for result in found[1:]:
        assert result.qoi == approx(found[0].qoi, rel=1e-9)


def test_closures_are_those_of_the_state():
    """Every profile again from the temperatures by the closures alone."""
    scene = hot(
        output={
            "positions": list(np.linspace(0.0, 0.6, 31)),
            "plots": False,
            "fields": False,
        }
    )
    result = solved(scene)
    column = {
        header.split(" [")[0]: values for header, values in result.profiles.items()
    }
    gas = gas_mixture("N2:0.79, O2:0.21", 101325.0)
    T = 0.98 * column["T_inert"] + 0.02 * column["T_char"]
    rho, mu = gas.density(T), gas.viscosity(T)
    rho_solid, d_p = 0.98 * 2600 + 0.02 * 1200, 1 / (0.98 / 7e-4 + 0.02 / 3e-3)
    Ar = d_p**3 * rho * (rho_solid - rho) * 9.81 / mu**2
    u_mf = closures.minimum_fluidization_grace(Ar) * mu / (rho * d_p)
    assert column["u_mf"] == approx(u_mf, rel=1e-9)
    bubbles = column["flow_bubble"]
    u = (0.6 - bubbles) / rho + bubbles / gas.density(column["T_bubble"])
    # the bend of the excess at zero, (1e-3 u_mf)^2 / (4 u_mf (u - u_mf)), is below 1e-6
    # of u
    assert column["u"] == approx(u, rel=1e-6)
    u_b = closures.bubble_rise_davidson_harrison(column["d_b"], column["u"] - u_mf, 1.0)
    delta = closures.bubble_fraction_kunii_levenspiel(column["u"], u_mf, u_b, 0.5)
    assert column["delta"] == approx(delta, rel=1e-9)
    # the flow is a field: the closure holds to the error of the mesh
    assert bubbles == approx(0.6 - rho * (1 - delta) * u_mf, rel=1e-6)
    assert column["d_b"][0] == approx(
        2.78 * (column["u"][0] - u_mf[0]) ** 2 / 9.81, rel=1e-6
    )


def test_viscosity_and_conductivity_of_the_gas_may_be_given():
    """The velocity of minimum fluidization is that of the given viscosity: round-off."""
    given = solved(hot(gas__viscosity=9e-5, gas__conductivity=0.3))
    gas = gas_mixture("N2:0.79, O2:0.21", 101325.0)
    T = given.profiles["T_inert [K]"], given.profiles["T_char [K]"]
    mean = 0.98 * T[0] + 0.02 * T[1]
    rho, rho_solid = gas.density(mean), 0.98 * 2600 + 0.02 * 1200
    d_p = 1 / (0.98 / 7e-4 + 0.02 / 3e-3)
    Ar = d_p**3 * rho * (rho_solid - rho) * 9.81 / 9e-5**2
    u_mf = closures.minimum_fluidization_grace(Ar) * 9e-5 / (rho * d_p)
    assert given.profiles["u_mf [m/s]"] == approx(u_mf, rel=1e-9)


def test_a_number_is_a_closure_that_returns_it():
    """The bed with the numbers that closures gave, at the same heat capacity of gas,
    has the same temperatures.
    """
    still = {"heat_capacity": 1000.0}
    result = solved(
        hot(
            tubes__coefficient=250.0,
            solids__char__mixing_conductivity=100.0,
            solids__char__exchange={"inert": 40.0},
            bubbles__size=0.1,
            solids__char__heat_capacity=still["heat_capacity"],
        )
    )
    assert result.qoi["tubes_coefficient_W_m2K"] == approx(250.0, rel=1e-12)
    assert np.all(result.profiles["d_b [m]"] == 0.1)
    assert not any(
        use["kind"] in ("bed_tube", "solid_exchange", "bubble_growth")
        for use in result.closures
    )


def test_packets_at_tubes_are_of_the_emulsion():
    """h^2 = 4 k C / (pi t) with the solids of the emulsion, 0.5, whatever the share of
    bubbles; its gas holds 2e-4 of the heat.
    """
    packets = {
        "name": "kunii_levenspiel_packet",
        "contact_time": 0.5,
        "k_stagnant": 0.35,
        "gap": 0.0,
    }
    same = {"solids__char__density": 2600.0, "solids__char__heat_capacity": 1000.0}
    result = solved(hot(tubes__coefficient=packets, **same))
    assert result.profiles["delta [1]"].max() > 0.1
    h = (4.0 * 0.35 * 0.5 * 2600.0 * 1000.0 / (np.pi * 0.5)) ** 0.5
    assert result.qoi["tubes_coefficient_W_m2K"] == approx(h, rel=1e-3)


def test_ranges_are_reported_with_where_they_are_used():
    result = solved(hot())
    used = {use["used_by"]: use for use in result.closures if "used_by" in use}
    assert used["solids.char.nusselt"]["name"] == "nusselt_ranz_marshall"
    assert used["bubbling_bed.bubbles.size"]["share_outside"] > 0
    told = "bubbling_bed.bubbles.size: bubble_growth_mori_wen is used out of"
    assert any(text.startswith(told) for text in result.warnings)
    with pytest.raises(cb.errors.ClosureRangeError, match="u_excess"):
        cb.run(hot(solver={"strict": True}))


def test_gas_that_passes_into_the_bubbles_brings_its_heat():
    """Without exchange bubbles are heated by that alone: W_b h_b' = X (h_e - h_b)
    where X = W_b' > 0.
    """
    result = solved(
        hot(
            bubbles={"exchange": 0.0},
            inlet__mass_flow=0.5,
            initial={"temperature": 900.0},
            solids__inert__mixing_conductivity=20.0,
        )
    )
    column = {
        header.split(" [")[0]: values for header, values in result.profiles.items()
    }
    flow = column["flow_bubble"]
    gas = gas_mixture("N2:0.79, O2:0.21", 101325.0)
    h_emulsion, h_bubble = (
        gas.enthalpy(column["T_emulsion"]),
        gas.enthalpy(column["T_bubble"]),
    )
    passed = np.diff(flow)
    mean = (
        0.5 * (h_emulsion[1:] + h_emulsion[:-1]),
        0.5 * (h_bubble[1:] + h_bubble[:-1]),
    )
    gained = np.sum(np.maximum(passed, 0) * mean[0] + np.minimum(passed, 0) * mean[1])
    change = flow[-1] * h_bubble[-1] - flow[0] * h_bubble[0]
    # gas does pass, and heats the bubbles; the trapezoidal rule of the table
    assert np.abs(passed).sum() > 0.01 and abs(change - gained) < 1e-3 * abs(gained)
    assert np.ptp(column["T_bubble"]) > 5


def test_species_are_told_apart():
    """Closures of a pair see each species with its own numbers, and mixing counts
    each one's own heat.
    """
    computed = plan(
        hot(solids__inert__mixing_conductivity="kunii_levenspiel")
    ).coefficients.computed
    T, flow, d_b = np.full(1, 1100.0), np.full(1, 0.3), np.full(1, 0.08)
    local, _ = computed.recorded(
        {
            "T_inert": T,
            "T_char": T,
            "T_emulsion": T,
            "T_bubble": T,
            "flow_bubble": flow,
            "d_bubble": d_b,
        },
        np.full(1, 0.3),
    )
    char, inert = (
        computed._of_pair(name, k, local.state)
        for name, k in (("char", 1), ("inert", 2))
    )
    assert (char["f_1"], char["d_1"], char["rho_1"]) == (0.5 * 0.02, 3e-3, 1200.0)
    assert (inert["f_2"], inert["d_2"], inert["rho_2"]) == (0.5 * 0.98, 7e-4, 2600.0)
    assert char["cp_1"] == approx(1000.0 + 0.5 * T) and inert["cp_2"] == approx(1000.0)
    # the same mixing [m2/s] of all particles carries heat as each species holds it
    held = {"char": 0.02 * 1200.0 * (1000.0 + 0.5 * T), "inert": 0.98 * 2600.0 * 1000.0}
    assert local.conduction["char"] / local.conduction["inert"] == approx(
        held["char"] / held["inert"]
    )
    mixing = [
        computed._dispersion(
            name,
            SimpleNamespace(
                **vars(local)
                | {"state": local.state | {"conduction": local.conduction}}
            ),
        )
        for name in held
    ]
    assert mixing[0] == approx(mixing[1])
    mean = (held["char"] + held["inert"]) / (0.02 * 1200.0 + 0.98 * 2600.0)
    assert local.state["cp_solid"] == approx(mean)


def test_a_gas_at_room_temperature_says_what_its_data_miss():
    """The data of gri30 begin at 300 K; the warning states the change of the
    heat capacity there, that of Cantera. Half the gas of fluidization is warned of.
    """
    scene = loads(COLD, "cold.toml")
    result = cb.run(scene)
    told = next(text for text in result.warnings if text.startswith("T_emulsion"))
    gas = ct.Solution("gri30.yaml")
    capacity = []
    for T in (293.15, 300.0):
        gas.TPX = T, ct.one_atm, "O2:0.21, N2:0.79"
        capacity.append(gas.cp_mass)
    share = abs(capacity[0] / capacity[1] - 1.0)
    assert (
        f"extrapolated to 293.15 K, where the heat capacity differs by {share:.2%}"
        in told
    )
    assert any(
        "100 % of the height is not fluidized" in text for text in result.warnings
    )


def test_a_narrow_feed_without_mixing_is_resolved():
    """Counter-current streams of constant properties by the number of transfer units;
    nothing is colder than what enters, and the grain as it enters within a few mK.
    """
    scene = loads(
        """
        [bubbling_bed]
        height = 0.5
        section = 1.0
        solids_fraction = 0.5
        [gas]
        material = "air"
        [boundary.bottom]
        gas = { mass_flow = 1.5, temperature = 473.15 }
        [solids.grain]
        diameter = 4e-3
        density = 1200
        heat_capacity = 1500
        gas_coefficient = 4
        mixing_conductivity = 0
        feed = { mass_flow = 2, temperature = 293.15, height = 0.5, width = 2e-3, drain = "bottom" }
        [radiation]
        level = "none"
        """
    )
    result = cb.run(scene)
    T = result.profiles["T_grain [K]"]
    assert T.min() > 293.15
    assert T[-1] == approx(293.35, abs=0.02)
