"""Gradients: refusals by name, differences of whole runs, common seeds."""

import numpy as np
import pytest
from design_scenes import SLIP
from pytest import approx

import contbed as cb
from contbed.loading import loads
from contbed.many.derivatives import differences
from contbed.many.derivatives.gradients import gradient, gradient_of
from contbed.many.derivatives.keys import continuous, key
from contbed.models import MODELS
from contbed.scene.values import with_value
from tests.cases import each_case
from tests.refusals import refused

OUT = ["T_fluid_out_K"]


def test_keys_that_a_scene_gives():
    names = [one.name for one in continuous(loads(SLIP))]
    assert names[0] == "mesh.length"
    assert "boundary.left.gas.fixed_temperature" in names
    assert "closures.forchheimer" in names
    assert not {"mesh.cells", "solver.degree", "closures.conductivity_gas"} & set(names)


@each_case(__file__, "keys_without_a_derivative_are_refused_by_name")
def test_keys_without_a_derivative_are_refused_by_name(name, told):
    refused(told, lambda: gradient(loads(SLIP), OUT, ["packed_bed.porosity", name]))


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("T_fluid_out", "nearest: T_fluid_out_K"),
        ("u_max", 'the run has no result "u_max"; allowed: '),
    ],
)
def test_results_that_a_run_does_not_have_are_refused(name, told):
    refused(told, lambda: gradient(loads(SLIP), [name], ["packed_bed.porosity"]))


def test_items_of_lists_and_parameters_of_closures_are_keys():
    scene = loads(SLIP.replace("conductivity = 0.8625", "conductivity = [0.5, 1e-3]"))
    one = key(scene, "solids.particles.conductivity[1]")
    assert (one.value, one.on(scene, 2e-3).solid.conductivity) == (1e-3, (0.5, 2e-3))
    scene = loads(
        SLIP.replace("nusselt = 12.0", 'nusselt = { name = "power", a = 1.1, b = 0.6 }')
    )
    one = key(scene, "closures.nusselt.a")
    assert one.on(scene, 1.2).closures.nusselt.a == 1.2
    assert "closures.nusselt.b" in [one.name for one in continuous(scene)]


def test_an_order_whose_unit_is_that_of_its_constant_is_no_key():
    """A = "2 1/s" has no value at an order of 1.001."""
    scene = loads(
        """
model = "packed_bed"
mesh = { type = "line", length = 1.0 }
gas.model = "cantera"
gas.composition = "A:1"
gas.viscosity = 2e-5
gas.species.A = { elements = { C = 1 }, heat_capacity = 30.0, enthalpy = 0.0 }
gas.species.B = { elements = { C = 1 }, heat_capacity = 30.0, enthalpy = 0.0 }
solids.cat = { diameter = 3e-3 }
packed_bed = { porosity = 0.4, pressure_drop = "none" }
reactions.r = { equation = "A -> B", A = "2 1/s", E = 0.0, orders = { A = 1.0 } }
boundary.left.gas = { velocity = 0.3, temperature = 500.0 }
"""
    )
    names = [one.name for one in continuous(scene)]
    assert "reactions.r.A" in names and "reactions.r.orders.A" not in names
    refused(
        "the unit of A belongs to this order",
        lambda: key(scene, "reactions.r.orders.A"),
    )


def test_coefficients_of_polynomials_have_the_unit_of_their_power():
    scene = loads(
        SLIP.replace("heat_capacity = 800.0", "heat_capacity = [560.0, 0.75, -2e-4]")
    )
    units = [
        key(scene, f"solids.particles.heat_capacity[{power}]").unit
        for power in range(3)
    ]
    assert units == ["J/kg/K", "J/kg/K**2", "J/kg/K**3"]


def test_properties_follow_the_temperature_of_a_library_material():
    text = SLIP.replace(
        "density = 2000.0\nheat_capacity = 800.0\nconductivity = 0.8625",
        'material = "alumina"\nmaterial_temperature = 600.0\ndensity = 3000.0',
    )
    scene = loads(text)
    other = key(scene, "solids.particles.material_temperature").on(scene, 700.0)
    assert other.solid.density == 3000.0
    assert (
        other.solid.conductivity
        == loads(text.replace("600.0", "700.0")).solid.conductivity
    )
    assert other.solid.conductivity != scene.solid.conductivity


def test_steps_keep_within_bounds():
    scene = loads(SLIP)
    near = differences.steps(
        scene,
        key(
            with_value(scene, ("packed_bed", "porosity"), 0.9999), "packed_bed.porosity"
        ),
        1e-3,
    )
    assert near.sides == (1, -1)
    assert 0.9999 + 2 * near.size < 1.0
    at = loads(SLIP.replace("forchheimer = 0.1", "forchheimer = 0.0"))
    one_sided = differences.steps(at, key(at, "closures.forchheimer"), 1e-3)
    assert one_sided.sides == (1,)
    assert "one-sided derivative from above" in one_sided.note


def test_differences_of_runs_extrapolate():
    scene, one = loads(SLIP), key(loads(SLIP), "packed_bed.porosity")
    found = differences.slope(
        scene, one, lambda s: np.array([s.packed_bed.porosity**5]), np.array([0.6**5])
    )
    # the error is of fourth order in a step of 1e-3
    assert found.values == approx(5 * 0.6**4, rel=1e-10)
    at = loads(SLIP.replace("forchheimer = 0.1", "forchheimer = 0.0"))
    found = differences.slope(
        at,
        key(at, "closures.forchheimer"),
        lambda s: np.array([np.exp(s.closures.forchheimer)]),
        np.array([1.0]),
        1e-4,
    )
    assert found.values == approx(1.0, rel=1e-6)  # one-sided: second order


def test_scatter_of_common_seeds_cancels():
    class Noise:
        """Results with noise that depends on the seed and not on the key."""

        def __call__(self, scene):
            random = np.random.default_rng(scene.initial.seed)
            return np.array(
                [
                    3.0
                    * scene.initial.solid.volume_fraction
                    * (1 + 0.01 * random.normal())
                ]
            )

    scene = loads(MODELS["two_fluid"].template.read_text(encoding="utf-8"))
    one = key(scene, "initial.solids.beads.volume_fraction")
    noise = Noise()
    found = differences.noisy_slope(scene, one, noise, noise(scene))
    # with seeds of their own the scatter would be 0.01 * 3 * 0.6/0.03
    assert abs(found.values[0] - 3.0) < 4 * found.errors[0]
    assert 0.0 < found.errors[0] < 0.05


def test_a_seed_that_changes_nothing_leaves_the_error_of_the_step():
    scene = loads(MODELS["two_fluid"].template.read_text(encoding="utf-8"))
    one = key(scene, "gas.density")
    found = differences.noisy_slope(
        scene, one, lambda s: np.array([s.gas.density**3]), np.array([1.2**3])
    )
    # a cubic has an error in the square of the step alone
    assert found.values == approx([3 * 1.2**2], rel=1e-9)
    assert found.errors == approx([0.0], abs=1e-9)


def test_pressure_drop_by_its_closed_form():
    scene = loads(SLIP)
    result = cb.run(scene)
    found = gradient_of(
        result, ["pressure_drop_Pa", *OUT], ["mesh.length", "gas.viscosity"]
    )
    # plug flow relative to the particles: (mu/K w + quadratic drag) L
    drop = result.qoi["pressure_drop_Pa"]
    assert found.derivatives[0, 0] == approx(drop / 0.04, rel=1e-8)
    assert found.logarithmic[0, 0] == approx(1.0, rel=1e-8)
    assert found.qoi == ("pressure_drop_Pa", *OUT)
    assert found.values[0] == drop


def test_conduction_of_a_lattice_by_its_closed_form():
    """k = c a k_p/R: the conductivity goes with contact radius and particles, and
    against the radius.
    """
    text = """
[particles.lattice]
type = "bcc"
contact_radius = 1e-5
[solids.spheres]
diameter = 2e-3
conductivity = 26.0
"""
    keys = [
        "solids.spheres.diameter",
        "particles.lattice.contact_radius",
        "solids.spheres.conductivity",
    ]
    made = gradient(loads(text), ["k_xx [W/m/K]"], keys)
    # four steps of 2.5 to 5 % leave an error of their fourth power
    assert made.logarithmic[0] == approx([-1.0, 1.0, 1.0], abs=1e-4)
    assert (made.standard_errors >= 0.0).all()
    assert made.standard_errors[0, 0] * 2e-3 < 1e-4


def test_a_text_is_one_name():
    found = cb.gradient(loads(SLIP), OUT[0], "packed_bed.porosity")
    assert (found.qoi, found.keys) == (tuple(OUT), ("packed_bed.porosity",))
