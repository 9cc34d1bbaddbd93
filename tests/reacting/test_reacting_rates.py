"""Rates at particles: films, effectiveness, formulas with units, and laws against
each other.
"""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx
from reacting_bed_scenes import danckwerts, isothermal, species

import contbed
from contbed.closures.formula import parse_formula
from contbed.fem.ad.dual import Dual
from contbed.loading import from_dict
from tests.particle.tables import overall, sphere
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
