"""Rates at particles: films, effectiveness, formulas with units, and laws against
each other.
"""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx
from reacting_bed_scenes import danckwerts, isothermal, species

import contbed
from contbed.chemistry.equation import Equation
from contbed.chemistry.rate_law import Case
from contbed.closures.formula import parse_formula
from contbed.fem.ad.dual import Dual
from contbed.loading import from_dict, loads
from contbed.many.study_file import unit_of
from contbed.scene.reactions import Reaction
from contbed.scene.values import number_at
from tests.particle.tables import overall, sphere
from tests.refusals import refused
from tests.scene_text import set_keys


def catalytic(**reaction):
    scene = isothermal("A:1", species(A=0.028, B=0.028))
    set_keys(scene, "mesh.length = 0.1")
    scene["reactions"] = {
        "r": {"equation": "A -> B", "A": 20.0, "E": 0.0, "basis": "particle"} | reaction
    }
    return scene


def left(scene):
    return contbed.run(from_dict(scene)).qoi["x_A_out"]


def exponent(k, u=0.5, length=0.1, eps=0.4):
    """Exponent of plug flow with a rate k [1/s] per volume of particles."""
    return k * (1.0 - eps) * length / u


def test_film_in_series_with_a_first_order_rate():
    scene, D, d = catalytic(), 2e-5, 3e-3
    scene["gas"]["diffusivity"] = D
    set_keys(scene, "closures.sherwood = 4.0")
    film = 4.0 * D / d * 6.0 / d  # per volume of particles [1/s]
    assert left(scene) == approx(
        np.exp(-exponent(1.0 / (1.0 / 20.0 + 1.0 / film))), rel=1e-8
    )


def test_effectiveness_of_spheres():
    D_e, R = 4e-6, 1.5e-3
    scene = catalytic(diffusivity=D_e)
    set_keys(scene, 'solids.particles.inside = { mass = "effectiveness" }')
    phi = R * np.sqrt(20.0 / D_e)
    assert left(scene) == approx(np.exp(-exponent(20.0 * float(sphere(phi)))), rel=1e-8)


def test_effectiveness_with_a_film_is_the_overall_one():
    D_e, R, D = 4e-6, 1.5e-3, 2e-5
    scene = catalytic(diffusivity=D_e)
    set_keys(scene, 'solids.particles.inside = { mass = "effectiveness" }')
    scene["gas"]["diffusivity"] = D
    set_keys(scene, "closures.sherwood = 4.0")
    phi, biot = R * np.sqrt(20.0 / D_e), 4.0 * D / (2.0 * R) * R / D_e
    eta = float(overall(sphere(phi), phi, biot))
    assert left(scene) == approx(np.exp(-exponent(20.0 * eta)), rel=1e-8)


def test_a_formula_gives_what_the_law_gives():
    scene = danckwerts(10.0, 1.0)
    k = scene["reactions"]["r"]["A"]
    written = danckwerts(10.0, 1.0)
    written["reactions"] = {
        "r": {
            "equation": "A -> B",
            "rate": "k*c_A",
            "unit": "mol/m**3/s",
            "parameters": {"k": f"{k} 1/s"},
        }
    }
    assert left(written) == approx(left(scene), rel=1e-12)
    # 1 mol/m3/s is 3.6 kmol/m3/h
    written["reactions"]["r"] |= {
        "unit": "kmol/m**3/h",
        "rate": "k*c_A*3.6",
        "parameters": {"k": k},
    }
    assert left(written) == approx(left(scene), rel=1e-12)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2*x**3 - 1", 53.0),
        ("-x**2", -9.0),
        ("exp(log(x))", 3.0),
        ("max(x, 5)/2", 2.5),
        ("x**(2/3)", 3.0 ** (2 / 3)),
    ],
)
def test_formulas(text, value):
    formula = parse_formula(text)
    assert float(formula({"x": 3.0})) == approx(value, rel=1e-12)
    dual = formula({"x": Dual(np.array([3.0]), {"x": np.array([1.0])})})
    step = 1e-6
    slope = (formula({"x": 3.0 + step}) - formula({"x": 3.0 - step})) / (2.0 * step)
    assert float(dual.tangents.get("x", [0.0])[0]) == approx(slope, rel=1e-7, abs=1e-9)


@pytest.mark.parametrize(
    ("orders", "more", "A"),
    [
        ({"A": 1.0}, {}, "1200 1/min"),
        ({"A": 2.0}, {}, "1200 L/mol/min"),
        ({"A": 0.5}, {}, "20 mol^0.5/m^1.5/s"),
        ({"A": 1.0}, {"basis": "catalyst"}, "20 L/g/s"),
        ({"A": 1.0}, {"b": 0.5, "basis": "gas"}, "20 1/s/K^0.5"),
        ({"A": 1.0}, {"b": 0.5, "basis": "gas"}, "20 1/s"),
    ],
)
def test_factors_of_laws_have_units(orders, more, A):
    """A text in the unit of its order gives what the number in SI does."""
    in_SI = 0.02 if orders["A"] == 2.0 else 20.0
    scene = catalytic(orders=orders, A=in_SI, **more)
    if "basis" in more:
        set_keys(scene, "solids.particles.density = 1000")
    number = left(scene)
    scene["reactions"]["r"]["A"] = A
    assert left(scene) == approx(number, rel=1e-12)


def test_factors_of_grains_and_cores_have_units():
    """Of a rate per surface, to the order of the gas, and of a velocity."""
    for of, order, text in (("m/s", 0.0, "20 cm/s"), ("mol/m**2/s", 1.0, "20 cm/s")):
        table = Reaction(equation="A -> B", A=text, E=0.0)
        case = Case("r", table, Equation.of("A -> B"), None)
        assert case.constant(of, order)(500.0) == approx(0.2)


def test_a_factor_of_partial_pressures_is_refused():
    for A, what in (
        ("20 mol/kg/s/bar", r"like '1/s'.*to the order 1.*rate = "),
        ("20", "without a unit"),
        ("-20 1/s", "is below 0"),
    ):
        refused(rf"reactions\.r\.A: .*{what}", lambda A=A: left(catalytic(A=A)))


def test_a_factor_with_a_unit_is_a_number_of_studies():
    """Its key has the value in SI, and the unit of its text."""
    scene = from_dict(catalytic(A="1200 1/min"))
    assert number_at(scene, "reactions.r.A") == approx(20.0)
    assert unit_of("reactions.r.A", "1200 1/min") == "1/s"
    assert unit_of("reactions.r.A") is None
    slope = contbed.gradient(scene, "x_A_out", "reactions.r.A")
    assert slope.derivatives[0, 0] == approx(
        left(scene) * np.log(left(scene)) / 20.0, rel=1e-6
    )


def test_a_rate_that_falls_with_the_temperature_and_a_table_of_a_composition():
    """1 - exp(-k L/u) with k = A exp(4.41 kJ/mol/(R T)): the error of the cells."""
    scene = loads(
        """
        mesh = { type = "line", length = 1.0 }
        packed_bed = { porosity = 0.4, pressure_drop = "none" }
        solids.beads = { diameter = 3e-3, density = 2000 }
        reactions.r = { equation = "A -> B", A = 0.1, E = -4.41e3, basis = "bed" }
        boundary.left.gas = { velocity = 0.5, temperature = 400 }
        [gas]
        model = "ideal_gas"
        composition = { A = 0.1, N2 = 0.9 }
        pressure = 1e5
        viscosity = 2e-5
        [gas.species]
        A = { elements = { C = 1 } }
        B = { elements = { C = 1 } }
        N2 = {}
        """
    )
    exact = 1.0 - np.exp(-0.1 * np.exp(4.41e3 / (8.31446261815324 * 400.0)) / 0.5)
    assert contbed.run(scene).qoi["conversion_A"] == approx(exact, rel=1e-9)
