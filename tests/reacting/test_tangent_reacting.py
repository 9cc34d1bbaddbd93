"""The tangent of steady reacting beds: Danckwerts' dispersed plug flow in closed
form, differences of runs.
"""

import numpy as np
import pytest
from reacting_bed_scenes import danckwerts

import contbed as cb
from contbed.loading import from_dict, loads
from contbed.many.derivatives.gradients import gradient, picked
from contbed.many.derivatives.keys import continuous, key
from contbed.models import MODELS


def left_over(rate, dispersion, length, velocity, eps=0.4):
    """Share of a reactant that leaves a bed of first order with axial dispersion
    (Danckwerts 1953).
    """
    Pe, Da = velocity * length / (eps * dispersion), eps * rate * length / velocity
    a = np.sqrt(1.0 + 4.0 * Da / Pe)
    below = (1.0 + a) ** 2 * np.exp(0.5 * a * Pe) - (1.0 - a) ** 2 * np.exp(
        -0.5 * a * Pe
    )
    return 4.0 * a * np.exp(0.5 * Pe) / below


def test_danckwerts_dispersed_plug_flow():
    scene = from_dict(danckwerts(8.0, 1.5))
    names = [
        "reactions.r.A",
        "closures.dispersion_mass",
        "mesh.length",
        "boundary.left.gas.velocity",
    ]
    made = gradient(scene, ["conversion_A", "x_B_out"], names)
    assert made.method == "tangent"
    at = [scene.reactions["r"].A, scene.closures.dispersion_mass, 1.0, 0.5]
    assert made.values[0] == pytest.approx(1.0 - left_over(*at), rel=1e-6)
    for j in range(len(names)):
        ends = [
            left_over(*(v * (1.0 + 1e-4 * side * (k == j)) for k, v in enumerate(at)))
            for side in (1, -1)
        ]
        exact = -(ends[0] - ends[1]) / (2e-4 * at[j])
        # cells that follow errors of 1e-5 leave 1e-6 of the derivative
        assert made.derivatives[:, j] == pytest.approx([exact, exact], rel=1e-5)


DECAY = """
mesh = { type = "line", length = "1 m" }
reactions.decay = { equation = "A -> B", rate = "k*c_A", parameters.k = "360 1/h" }
[gas]
model = "ideal_gas"
composition = "A:0.001, N2:0.999"
species = { A.elements.C = 1, B.elements.C = 1, N2 = {} }
[solids.pebbles]
diameter = "3 mm"
[packed_bed]
porosity = 0.4
pressure_drop = "none"
[boundary.left.gas]
velocity = 0.5
temperature = 500
"""


def test_a_constant_of_a_formula_with_a_unit_is_a_key():
    """Plug flow: x = exp(-k tau), its derivative to k [1/s] -tau x."""
    scene = loads(DECAY)
    names = {one.name: one.unit for one in continuous(scene)}
    assert names["reactions.decay.parameters.k"] == "1/s"
    assert not any("elements" in name for name in names)
    found = gradient(scene, ["x_A_out"], ["reactions.decay.parameters.k"])
    tau = 0.4 * 1.0 / 0.5
    assert found.at == (pytest.approx(0.1),)
    slope = -tau * 1e-3 * np.exp(-0.1 * tau)
    assert found.derivatives[0, 0] == pytest.approx(slope, rel=1e-6)


def test_reformer_against_differences_on_given_cells():
    text = MODELS["reacting_bed"].template.read_text(encoding="utf-8")
    scene = loads(text.replace('length = "3 m"', 'length = "3 m"\ncells = 24'))
    names = [
        "gas.pressure",
        "boundary.left.gas.mass_flux",
        "boundary.wall.ambient",
        "mesh.length",
        "reactions.reforming.factor",
    ]
    qoi = ["T_fluid_out_K", "conversion_CH4", "x_H2_out"]
    made = gradient(scene, qoi, names)
    for j, name in enumerate(names):
        one = key(scene, name)
        ends = [
            picked(scene, cb.run(one.on(scene, one.value * (1 + side * 1e-4))).qoi, qoi)
            for side in (1, -1)
        ]
        found = (ends[0] - ends[1]) / (2e-4 * one.value)
        assert made.derivatives[:, j] == pytest.approx(found, rel=1e-6)
