"""Surface mechanisms beside Cantera's: rates, steady coverages, beds and pellets.

Cantera gives rates of progress at given coverages; the plug flow is an ordinary differential
equation with steady coverages at each point.
"""

from pathlib import Path

import cantera
import numpy as np
import pytest
from pytest import approx
from scipy.integrate import solve_ivp

import contbed
from contbed.chemistry.surface import surface_of
from contbed.errors import ConvergenceError
from contbed.loading import from_dict
from contbed.models import plan
from contbed.scene.reactions import Reaction
from tests.balances import assert_closed
from tests.cases import each_case
from tests.particle.tables import sphere
from tests.refusals import problems_of, refusal
from tests.scene_text import put, scene_of

DATA = Path(__file__).parents[1] / "data"
OWN = DATA / "surface.yaml"
R = 8.31446261815324
MECHANISMS = [
    ("ptcombust.yaml", "Pt_surf"),
    ("methane_pox_on_pt.yaml", "Pt_surf"),
    (str(OWN), "surf"),
]
FLUX, AREA, LENGTH = 0.3, 1e4, 0.01  # [kg/m2/s], [1/m] of particles, [m]
REACTING = ("H2", "O2", "H2O", "CH4", "CO", "CO2")
# each with a state in which its methane burns or reforms
FLOWS = {
    "ptcombust.yaml": (1000.0, "CH4:0.03, O2:0.1, N2:0.87", "N2"),
    "methane_pox_on_pt.yaml": (900.0, "CH4:0.3, O2:0.15, AR:0.55", "AR"),
}


def states(gas, T, seed, count=12):
    """Random temperatures [K], pressures [Pa] and mole fractions."""
    random = np.random.default_rng(seed)
    x = random.dirichlet(np.ones(gas.n_species), count)
    return random.uniform(*T, count), 10.0 ** random.uniform(3.0, 6.0, count), x


def mechanism(file, name):
    """The mechanism, and Cantera's surface and gas."""
    table = Reaction.model_validate({"mechanism": file, "surface": name})
    surface = cantera.Interface(file, name)
    return surface_of(table), surface, next(iter(surface.adjacent.values()))


def of_species(surface, values, names):
    """Return those of some species of a surface and its gas."""
    known = surface.kinetics_species_names
    return np.array([values[known.index(name)] for name in names])


def made_by_cantera(surface, names):
    """Production of species [mol/m2/s] at the state of a surface."""
    rates = surface.net_production_rates
    return 1e3 * of_species(surface, rates, names)


def made_of(known, rates):
    """Production of gases [mol/m2/s] from the rates of equations."""
    made = dict.fromkeys(known.gases, 0.0)
    for equation, rate in zip(known.equations.values(), rates, strict=True):
        for name, n in equation.stoichiometry.items():
            made[name] += n * rate
    return np.array([made[name] for name in known.gases])


def concentrations(known, gas):
    found = dict(zip(gas.species_names, gas.concentrations, strict=True))
    return np.array([found[name] for name in known.gases])


@pytest.mark.parametrize(("file", "name"), MECHANISMS)
def test_rates_at_random_coverages(file, name):
    """1e-12 of what is made and taken: both are sums in double precision."""
    known, surface, gas = mechanism(file, name)
    random = np.random.default_rng(3)
    for T, p, x in zip(*states(gas, (400.0, 1600.0), 1), strict=True):
        theta = random.dirichlet(np.ones(surface.n_species))
        gas.TPX, surface.TP, surface.coverages = (T, p, x), (T, p), theta
        c = concentrations(known, gas)[:, None]
        r, _, _ = known._steps(known._gas(np.array([T]), c), theta[:, None])
        made, turned = 1e3 * known.made.T @ r[:, 0], 1e3 * abs(known.made).T @ r[:, 0]
        exact = made_by_cantera(surface, (*known.gases, *known.adsorbates))
        assert (abs(made - exact) < 1e-12 * turned).all()


def assert_steady(known, surface, gas):
    """At our coverages Cantera makes of the gases what we say, to 1e-9 of the largest and
    what a surface takes up in 1e7 s: and of adsorbates just that, to 1e-9 of what comes
    and goes, and rounding of the largest.
    """
    c = 1e3 * concentrations(known, gas)[:, None]
    theta = known.coverages(np.array([gas.T]), c)[:, 0]
    assert (theta >= 0.0).all()
    assert theta.sum() == approx(1.0, abs=1e-14)
    surface.coverages = theta
    rates, _ = known.rates(np.array([[gas.T], *c]), {})
    exact = made_by_cantera(surface, known.gases)
    whole = 1e3 * known.density / known.sites
    close = 1e-9 * abs(exact).max() + 4.0 * whole.max() / 1e7
    assert made_of(known, rates[:, 0]) == approx(exact, abs=close)
    taken_up = whole * (theta - np.maximum(known.start, 1e-12)) / 1e7
    of_adsorbates = made_by_cantera(surface, known.adsorbates)
    turned = surface.creation_rates + surface.destruction_rates
    sizes = 1e3 * of_species(surface, turned, known.adsorbates)
    rounding = 1e-15 * sizes.max()
    assert (abs(of_adsorbates - taken_up) <= 1e-9 * sizes + rounding).all()


@pytest.mark.parametrize(("file", "name"), MECHANISMS)
def test_steady_coverages(file, name):
    known, surface, gas = mechanism(file, name)
    for T, p, x in zip(*states(gas, (600.0, 1600.0), 2), strict=True):
        gas.TPX, surface.TP = (T, p, x), (T, p)
        assert_steady(known, surface, gas)


@pytest.mark.parametrize(
    ("file", "inert"), [(file, flow[2]) for file, flow in FLOWS.items()]
)
def test_surfaces_that_are_cold_or_covered_with_carbon(file, inert):
    """Of 200 gases with one to four of those that react, and traces of all, two at most
    are not found.
    """
    known, surface, gas = mechanism(file, "Pt_surf")
    random, lost = np.random.default_rng(5), []
    for _ in range(200):
        T = random.uniform(300.0, 1300.0)
        names = random.choice(REACTING, random.integers(1, 5), replace=False)
        shares = 10.0 ** random.uniform(-4.0, 0.0, len(names))
        traces = dict.fromkeys(known.gases, 1e-14)
        main = dict(zip(names, shares, strict=True))
        gas.TPX = T, 1e5, traces | main | {inert: 1.0}
        surface.TP = gas.TP
        try:
            assert_steady(known, surface, gas)
        except ConvergenceError:
            lost.append((T, gas.mole_fraction_dict()))
    assert len(lost) <= 2


@pytest.mark.parametrize(("file", "name"), MECHANISMS[:2])
def test_the_steady_state_that_cantera_finds(file, name):
    """1e-10 of the largest, from the coverages of the file, where Cantera finds one."""
    known, surface, gas = mechanism(file, name)
    found = 0
    for T, p, x in zip(*states(gas, (700.0, 1600.0), 4), strict=True):
        gas.TPX, surface.TP, surface.coverages = (T, p, x), (T, p), known.start
        try:
            surface.advance_coverages_to_steady_state()
        except cantera.CanteraError:
            continue
        found += 1
        c = 1e3 * concentrations(known, gas)[:, None]
        rates, _ = known.rates(np.array([[T], *c]), {})
        exact = made_by_cantera(surface, known.gases)
        assert made_of(known, rates[:, 0]) == approx(
            exact, abs=1e-10 * abs(exact).max()
        )
    assert found >= 8


@pytest.mark.parametrize(("file", "name"), MECHANISMS)
def test_derivatives_of_rates(file, name):
    """Central differences, 1e-6 of the largest rate for a relative change of one: steps of
    3e-5 err by 1e-9 of third derivatives.
    """
    known, _, _ = mechanism(file, name)
    x = {"CH4": 0.05, "O2": 0.06, "H2O": 0.02, "H2": 0.03, "CO": 0.05, "CO2": 0.04}
    c = np.array([x.get(each, 1e-6) for each in known.gases]) * 1e5 / (R * 1150.0)
    at = np.array([1150.0, *c])
    held = {}
    rates, slopes = known.rates(at[:, None], held)
    for k, value in enumerate(at):
        step = 3e-5 * value
        sides = []
        for sign in (1.0, -1.0):
            moved = at.copy()
            moved[k] += sign * step
            sides.append(known.rates(moved[:, None], held)[0])
        numeric = (sides[0] - sides[1])[:, 0] / (2.0 * step)
        exact = approx(value * numeric, abs=1e-6 * abs(rates).max())
        assert value * slopes[:, k, 0] == exact


def bed(file, T, composition, **more):
    """Plug flow through particles with a catalyst."""
    values = {"gas.mechanism": file, "gas.composition": composition}
    values |= {"reactions.pt.mechanism": file, "boundary.left.gas.temperature": T}
    return scene_of(
        f"""
        [mesh]
        type = "line"
        length = {LENGTH}
        [gas]
        model = "cantera"
        pressure = 1e5
        [solids.foam]
        diameter = 1e-3
        [packed_bed]
        porosity = 0.4
        pressure_drop = "none"
        [reactions.pt]
        surface = "Pt_surf"
        area = {AREA}
        [boundary.left.gas]
        mass_flux = {FLUX}
        [solver]
        tolerance = 1e-8
        """,
        values | more,
    )


def plug_flow(file, T, composition, adiabatic):
    """Temperature and mole fluxes [mol/m2/s] that leave: temperature and mass fractions by
    ordinary differential equations to 1e-10.
    """
    surface = cantera.Interface(file, "Pt_surf")
    gas = surface.adjacent["gas"]
    gas.TPX = T, 1e5, composition
    M, area = gas.molecular_weights, 0.6 * AREA

    def slope(_, y):
        gas.TPY = y[0], 1e5, np.maximum(y[1:], 0.0)
        surface.TP = gas.TP
        surface.advance_coverages_to_steady_state()
        made = of_species(surface, surface.net_production_rates, gas.species_names)
        heat = -made @ gas.partial_molar_enthalpies * area
        by_T = heat / (FLUX * gas.cp_mass) if adiabatic else 0.0
        return np.array([by_T, *(made * M * area / FLUX)])

    start = np.array([T, *gas.Y])
    found = solve_ivp(slope, (0.0, LENGTH), start, "BDF", rtol=1e-10, atol=1e-16)
    moles = FLUX * found.y[1:, -1] / M * 1e3
    return found.y[0, -1], dict(zip(gas.species_names, moles, strict=True))


@pytest.mark.parametrize("adiabatic", [False, True])
@pytest.mark.parametrize("file", FLOWS)
def test_plug_flow(file, adiabatic):
    """1e-8 of all that leaves, the tolerance of the bed, though temperatures rise by
    1000 K where oxygen is used up; adiabatic 2e-7, by which the exact enthalpy drifts.
    """
    close = 2e-7 if adiabatic else 1e-8
    T, composition, _ = FLOWS[file]
    scene = bed(file, T, composition, **({"heat": {}} if adiabatic else {}))
    result = contbed.run(from_dict(scene))
    T_out, leaving = plug_flow(file, T, composition, adiabatic)
    assert result.qoi["T_fluid_out_K"] == approx(T_out, rel=close)
    whole = sum(leaving.values())
    for name in REACTING:
        found = result.qoi[f"out_{name}_mol_m2s"]
        assert found == approx(leaving[name], abs=close * whole)
    assert_closed(result, 1e-12)


def test_plug_flow_converges_with_the_mesh():
    """Third order at the outlet of straight lines in cells: 8 on half of the cells."""
    file = "ptcombust.yaml"
    T, composition, _ = FLOWS[file]
    _, leaving = plug_flow(file, T, composition, False)
    errors = []
    for cells in (16, 32):
        keys = {"mesh.cells": cells, "solver.adapt": 0, "solver.degree": 1}
        result = contbed.run(from_dict(bed(file, T, composition, **keys)))
        errors.append(abs(result.qoi["out_CH4_mol_m2s"] - leaving["CH4"]))
    assert errors[1] < errors[0] / 6.0


def test_hydrogen_in_air_in_time():
    """From 400 K, at which a surface may be covered by either: what enters and leaves is
    what is held, to 1e-12, of the elements that there are.
    """
    keys = {"time.end": 0.05, "mesh.cells": 20, "initial.temperature": 400.0}
    keys |= {"packed_bed.gas_storage": "quasi_steady", "heat": {}}
    keys |= {"solids.foam.density": 2000.0, "solids.foam.heat_capacity": 900.0}
    hydrogen = "H2:0.02, O2:0.2, N2:0.78"
    result = contbed.run(from_dict(bed("ptcombust.yaml", 400.0, hydrogen, **keys)))
    assert_closed(result, 1e-12)
    assert set(result.balances) == {"H", "O", "N", "energy"}
    assert result.qoi["conversion_H2"] > 0.99


def test_pellets_without_resistance():
    """1e-6: the pellets' resistance at 1e3 m2/s, and twelve cells."""
    gases = (*REACTING, "H", "O", "OH")
    inside = {"mass": "interior", "diffusivity": dict.fromkeys(gases, 1e3)}
    keys = {"solids.foam.inside": inside, "mesh.cells": 12, "solver.adapt": 0}
    flow = ("ptcombust.yaml", 900.0, "CH4:0.01, O2:0.1, N2:0.89")
    result = contbed.run(from_dict(bed(*flow, **keys)))
    _, leaving = plug_flow(*flow, False)
    whole = sum(leaving.values())
    for name in ("CH4", "CO2", "H2O"):
        found = result.qoi[f"out_{name}_mol_m2s"]
        assert found == approx(leaving[name], abs=1e-6 * whole)
    assert_closed(result, 1e-12)


def first_order(**more):
    """A -> B on a surface that A hardly covers, 1 mm long at 500 K."""
    species = {"elements": {"N": 2, "O": 1}, "heat_capacity": 40.0}
    values = {"mesh.length": 1e-3, "gas.species": {"A": species, "B": species}}
    values |= {"reactions.pt.mechanism": str(OWN), "reactions.pt.surface": "first"}
    return bed("gri30.yaml", 500.0, "A:1", **(values | more))


def constant():
    """Rate constant of `first_order` [1/s] over the volume of particles: Kee, ch. 11."""
    M = 44.013e-3
    return AREA * 1e-8 * np.sqrt(R * 500.0 / (2.0 * np.pi * M))


@pytest.mark.parametrize("phi", [0.5, 4.0])
def test_first_order_in_pellets(phi):
    """Effectiveness by the Thiele modulus; 1e-5 by the shells and by A on the surface."""
    k, radius = constant(), 0.5e-3
    D = k * (radius / phi) ** 2
    inside = {"mass": "interior", "diffusivity": {"A": D, "B": D}}
    result = contbed.run(from_dict(first_order(**{"solids.foam.inside": inside})))
    velocity = FLUX / 44.013e-3 * R * 500.0 / 1e5
    left = np.exp(-0.6 * k * sphere(phi) * 1e-3 / velocity)
    assert 1.0 - result.qoi["x_A_out"] == approx(1.0 - left, rel=1e-4)


def test_area_over_the_volume_of_the_bed():
    whole = contbed.run(from_dict(first_order()))
    of_bed = {"reactions.pt.basis": "bed", "reactions.pt.area": 0.6 * AREA}
    found = contbed.run(from_dict(first_order(**of_bed)))
    assert found.qoi["x_B_out"] == approx(whole.qoi["x_B_out"], rel=1e-12)


def test_the_plan_says_that_coverages_are_steady():
    T, composition, _ = FLOWS["ptcombust.yaml"]
    text = str(plan(from_dict(bed("ptcombust.yaml", T, composition))))
    assert "Pt_surf of ptcombust.yaml" in text
    assert "coverages in steady state with the gas at each point" in text


@each_case(__file__, "refused")
def test_refused(key, value, text):
    scene = bed("ptcombust.yaml", 1000.0, "H2:0.03, O2:0.1, N2:0.87")
    put(scene, key, value)
    found = " ".join(problems_of(lambda: plan(from_dict(scene))))
    assert text in found


def test_a_kind_of_rate_that_is_not_read():
    """With the file, the line and the equation."""
    lines = OWN.read_text().split("\n")
    line = 1 + next(k for k, each in enumerate(lines) if "B + X <=>" in each)
    scene = first_order(**{"reactions.pt.surface": "masel"})
    message = refusal(from_dict, scene)
    assert f"surface.yaml:{line}: B + X <=> A(X): a rate of the kind" in message


def test_a_mechanism_beside_the_scene(tmp_path):
    (tmp_path / "mine.yaml").write_text(OWN.read_text())
    scene = first_order(**{"reactions.pt.mechanism": "mine.yaml"})
    assert contbed.run(from_dict(scene, base=tmp_path)).qoi["x_B_out"] > 0.0


def test_a_surface_on_which_nothing_reacts():
    """Oxygen alone at 273 K: what leaves is what enters, to the half of a monolayer that
    the surface takes up in 1e7 s, 3e-12.
    """
    result = contbed.run(from_dict(bed("ptcombust.yaml", 273.15, "O2:0.21, N2:0.79")))
    assert result.qoi["x_O2_out"] == approx(0.21, rel=1e-11)
    assert not any(name.startswith("yield") for name in result.qoi)


def test_an_element_that_does_not_enter_has_no_balance():
    """Hydrogen in air, where traces of carbon are rounding: they left the run open."""
    scene = bed("ptcombust.yaml", 400.0, "H2:0.01, O2:0.21, N2:0.78", heat={})
    result = contbed.run(from_dict(scene))
    assert set(result.balances) == {"H", "O", "N", "energy"}
    assert_closed(result, 1e-12)
