"""Pellets whose inside is resolved: closed forms of first order, derivatives, and
the reformer's rates.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pytest import approx
from reacting_bed_scenes import isothermal, species

import contbed
from contbed.fem.ad.dual import Dual
from contbed.loading import from_dict
from contbed.many.derivatives.gradients import gradient
from contbed.plan_text import percent
from contbed.reacting_bed.plan import plan
from tests.balances import assert_closed
from tests.cases import each_case
from tests.particle.tables import sphere
from tests.refusals import refused
from tests.scene_text import scene_of, set_keys

D_A, D_B, R = 2e-6, 5e-6, 1.5e-3


def pellets(phi, K=None):
    """A -> B of first order in pellets, phi = R sqrt(k/D_A); with the equilibrium
    constant K reversible.
    """
    scene = isothermal("A:1", species(A=0.028, B=0.028))
    k = D_A * (phi / R) ** 2
    rate = "k*c_A" if K is None else "k*(c_A - c_B/K)"
    parameters = {"k": k} if K is None else {"k": k, "K": K}
    scene["reactions"] = {
        "r": {
            "equation": "A -> B",
            "rate": rate,
            "parameters": parameters,
            "basis": "particle",
        }
    }
    set_keys(scene, "solids.particles.density = 1000.0")
    scene["solids"]["particles"]["inside"] = {
        "mass": "interior",
        "diffusivity": {"A": D_A, "B": D_B},
    }
    return scene, k


def left(k, eta):
    """Share of A that is left of first order in plug flow of 1 m."""
    return np.exp(-0.6 * k * eta / 0.5)


@pytest.mark.parametrize("phi", [0.5, 5.0])
def test_first_order(phi):
    scene, k = pellets(phi)
    scene["mesh"]["length"] = L = min(1.0, 1.0 / (0.6 * k * sphere(phi) / 0.5))
    result = contbed.run(from_dict(scene))
    # 3e-6 of the effectiveness by the shells
    assert result.qoi["x_A_out"] == approx(left(k * L, sphere(phi)), rel=1e-5)


def test_reversible_first_order():
    """phi^2 = k R^2 (1/D_A + 1/(K D_B)), the driving force c_A - c_B/K."""
    K, phi = 2.0, 4.0
    scene, k = pellets(phi, K)
    scene["mesh"]["length"] = L = 0.02
    eta = sphere(R * np.sqrt(k / D_A + k / (K * D_B)))
    equal = 1.0 / (1.0 + K)  # share of A at equilibrium
    exact = equal + (1.0 - equal) * left(k * L * (1.0 + 1.0 / K), eta)
    result = contbed.run(from_dict(scene))
    assert result.qoi["x_A_out"] == approx(exact, rel=1e-5)


def test_thiele_where_a_reaction_runs_back():
    """Pure B: the modulus is that of k/K, which B is used up with."""
    K, phi = 0.5, 6.0
    scene, _ = pellets(phi, K)
    set_keys(scene, 'gas.composition = "B:1"')
    set_keys(scene, 'solids.particles.inside = { mass = "none" }')
    scene["reactions"]["r"]["diffusivity"] = D_A
    rates = []
    for mass in ("none", "effectiveness"):
        scene["solids"]["particles"]["inside"]["mass"] = mass
        problem = plan(from_dict(scene)).problem
        state = problem.bed.state(list(problem.start()[:, 0, :1]))
        rates.append(
            float(problem.bed.rates(state, problem.bed.medium.at(state))[0][0])
        )
    assert rates[0] < 0.0
    assert rates[1] / rates[0] == approx(sphere(phi / np.sqrt(K)), rel=1e-12)


REFORMER = scene_of(
    """
        mesh = { type = "line", length = 1.0 }
        packed_bed = { porosity = 0.5, pressure_drop = "none" }
        closures = {}
        heat = {}
        output = { plots = false }

        [gas]
        model = "cantera"
        composition = "CH4:0.2, H2O:0.6, H2:0.12, CO:0.02, CO2:0.06"
        pressure = "20 bar"
        viscosity = 3e-5

        [boundary]
        left = { gas = { mass_flux = 5.0, temperature = 900.0 } }
    """,
    {
        "solids": scene_of("""
        [particles]
        diameter = 8e-3
        density = 2700.0
        inside.mass = "interior"
        inside.diffusivity.CH4 = 2e-6
        inside.diffusivity.H2O = 2.5e-6
        inside.diffusivity.H2 = 6e-6
        inside.diffusivity.CO = 2e-6
        inside.diffusivity.CO2 = 1.5e-6
    """),
        "reactions": {
            name: {"law": f"xu_froment_{name}"}
            for name in ("reforming", "shift", "total")
        },
    },
)


def test_derivatives_of_mean_rates():
    """Against central differences of the inputs."""
    problem = plan(from_dict(REFORMER)).problem
    state = problem.bed.state(list(problem.start()[:, 0, :1]))
    inside = problem.reactions[0].rate
    at = problem.local(state, problem.reactions[0])
    one = np.ones(1)
    c = {name: Dual(value * one, {name: one}) for name, value in at.c.items()}
    found = inside(replace(at, T=Dual(at.T * one, {"T": one}), c=c))
    for key in ("T", "CH4", "H2", "CO2"):
        value = float(at.T[0] if key == "T" else at.c[key][0])
        h = 1e-4 * value
        sides = []
        for sign in (1.0, -1.0):
            moved = {**at.c, key: at.c[key] + sign * h} if key != "T" else at.c
            T_moved = at.T + sign * h if key == "T" else at.T
            sides.append(inside(replace(at, T=T_moved, c=moved)))
        for k, rate in enumerate(found):
            slope = (sides[0][k] - sides[1][k]) / (2.0 * h)
            # differences err by the square of 1e-4
            assert rate.tangents[key][0] == approx(float(slope[0]), rel=1e-5), (
                key,
                k,
            )


def test_a_reformer_closes_and_the_plan_tells_the_effectiveness():
    scene = from_dict(REFORMER)
    text = dict(plan(scene).built)["intrapellet diffusion"]
    assert "effectiveness at the inlet: reforming 0.0" in text
    assert "by the Thiele modulus of CH4" in text
    result = contbed.run(scene)
    assert_closed(result, 1e-12)
    assert 0.05 < result.qoi["conversion_CH4"] < 0.5


@each_case(__file__, "mistakes")
def test_mistakes(change, said):
    scene, _ = pellets(1.0)
    scene["solids"]["particles"]["inside"] |= change
    refused(said, from_dict, scene)


def test_pores_of_rods_are_refused():
    """A sphere of 1.5 d has the surface over volume of a rod of d: 6/(1.5 d) = 4/d."""
    scene, _ = pellets(1.0)
    particles = scene["solids"]["particles"]
    particles["shape"] = "rods"
    sphere = 1.5 * particles["diameter"]
    refused(f"that of spheres; give .* diameter = {sphere:g}", from_dict, scene)
    particles["inside"] = {"mass": "none"}
    from_dict(scene)


def test_nothing_to_resolve():
    scene, _ = pellets(1.0)
    set_keys(scene, 'reactions.r.basis = "gas"')
    scene["solids"]["particles"]["inside"].pop("diffusivity")
    refused("nothing reacts in these particles", from_dict, scene)


@pytest.mark.parametrize(("phi", "level"), [(0.2, "none"), (0.6, "interior")])
def test_pellets_are_resolved_where_diffusion_matters(phi, level):
    """Of first order in plug flow what reacts would differ by 1 - eta, and what
    leaves differs by less.
    """
    scene, k = pellets(phi)
    scene["mesh"]["length"] = 0.5 / (0.6 * k)
    del scene["solids"]["particles"]["inside"]["mass"]
    planned = plan(from_dict(scene))
    assert planned.scene.solids["particles"].inside.mass == level
    told = dict(planned.built if level == "interior" else planned.skipped)[
        "intrapellet diffusion"
    ]
    assert f"changes the reacted amounts by {percent(1.0 - sphere(phi))}" in told
    found = contbed.run(from_dict(scene)).qoi["x_A_out"]
    both = {}
    for mass in ("none", "interior"):
        if mass == "none":
            set_keys(scene, 'solids.particles.inside = { mass = "none" }')
        else:
            scene["solids"]["particles"]["inside"] = {
                "mass": mass,
                "diffusivity": {"A": D_A, "B": D_B},
            }
        both[mass] = contbed.run(from_dict(scene)).qoi["x_A_out"]
    assert found == both[level]
    change = abs(both["none"] - both["interior"]) / (1.0 - both["none"])
    assert 0.3 * (1.0 - sphere(phi)) < change < 1.0 - sphere(phi)


def test_derivatives_of_a_bed_whose_level_was_chosen():
    """The tangent is that of the level which was run: without resistance
    x = exp(-0.6 k L/u), dk of it by hand.
    """
    scene, k = pellets(0.2)
    scene["mesh"]["length"] = L = 0.5 / (0.6 * k)
    set_keys(scene, 'solids.particles.inside.mass = "auto"')
    found = gradient(
        from_dict(scene), ["x_A_out"], ["reactions.r.parameters.k"]
    ).derivatives[0, 0]
    # resolved pellets have 2 (1 - eta) = 0.5 % less
    assert found == approx(-left(k * L, 1.0) * 0.6 * L / 0.5, rel=1e-4)


def test_what_cannot_be_judged_is_resolved():
    """In time; without a diffusivity there is nothing to resolve, and nothing is
    solved to find out.
    """
    scene, _ = pellets(0.1)
    del scene["solids"]["particles"]["inside"]["mass"]
    set_keys(scene, "time = { end = 1.0 }")
    planned = plan(from_dict(scene))
    assert (
        "always resolved in transients" in dict(planned.built)["intrapellet diffusion"]
    )
    assert type(planned.problem.reactions[0].rate).__name__ == "Pellets"
    del scene["solids"]["particles"]["inside"], scene["time"]
    planned = plan(from_dict(scene))
    assert "intrapellet diffusion" not in dict(planned.built) | dict(planned.skipped)
