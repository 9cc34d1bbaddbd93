"""The tangent of radiation alone and of fully developed flow: closed forms,
differences of solutions on one mesh.
"""

import numpy as np
from pytest import approx

import contbed as cb
from contbed.developed_flow.results import fill
from contbed.developed_flow.tangent import Tangent as DevelopedTangent
from contbed.loading import from_dict, loads
from contbed.many.derivatives.gradients import gradient, picked
from contbed.many.derivatives.keys import key
from contbed.models import MODELS
from contbed.result import Result
from tests.scene_text import scene_of

SIGMA = 5.670374419e-8

PLATES = """\
[mesh]
type = "line"
length = 0.1
[radiation]
level = "p1"
absorption = 7
scattering = 3
[boundary.left.radiation]
temperature = 1500.0
emissivity = 0.8
[boundary.right.radiation]
temperature = 1000.0
"""


def test_radiative_equilibrium_between_plates():
    """By P1: q = sigma (T1^4 - T2^4)/(3 tau/4 + 1/e1 + 1/e2 - 1)."""
    names = [
        "mesh.length",
        "radiation.absorption",
        "boundary.left.radiation.temperature",
    ]
    names += ["boundary.left.radiation.emissivity"]
    made = gradient(loads(PLATES), ["heat_left_W"], names)
    assert made.method == "tangent"
    below = 0.75 + 1.25
    q = SIGMA * (1500.0**4 - 1000.0**4) / below
    exact = [
        -q / below * 7.5,
        -q / below * 0.075,
        4.0 * SIGMA * 1500.0**3 / below,
        q / below / 0.8**2,
    ]
    assert made.values[0] == approx(q, rel=1e-9)
    assert made.derivatives[0] == approx(exact, rel=1e-8)


def test_conducting_medium_against_runs_on_given_cells():
    text = PLATES.replace(
        "scattering = 3", "scattering = 3\nconductivity = 2.0"
    ).replace("0.1\n", "0.1\ncells = 20\n", 1)
    scene = loads(text)
    for name in (
        "radiation.conductivity",
        "boundary.left.radiation.temperature",
        "mesh.length",
    ):
        made, one = gradient(scene, ["heat_left_W"], [name]), key(scene, name)
        ends = [
            cb.run(one.on(scene, one.value * (1 + side * 1e-4))).qoi["heat_left_W"]
            for side in (1, -1)
        ]
        assert made.derivatives[0, 0] == approx(
            (ends[0] - ends[1]) / (2e-4 * one.value), rel=1e-6
        )


def test_ordinates_take_differences_of_runs():
    made = gradient(
        loads(PLATES.replace('"p1"', '"ordinates"')),
        ["heat_left_W"],
        ["boundary.left.radiation.temperature"],
    )
    assert made.method == "differences"
    q = made.values[0]
    assert made.derivatives[0, 0] == approx(
        4 * 1500.0**3 / (1500.0**4 - 1000.0**4) * q, rel=1e-5
    )


def test_laminar_gas_between_plates():
    """Without particles: dp/dx = 3 mu u/R^2 + rho g."""
    values = scene_of(
        """
        [developed_flow]
        section = "channel"
        radius = 0.01
        gas_velocity = 0.5
        solids_mass_flux = 0.0
        [gas]
        density = 1.2
        viscosity = 1.8e-5
        [solids.beads]
        diameter = 1e-3
        density = 2500.0
        restitution = 0.95
        packing_limit = 0.6
        [boundary.wall]
        type = "wall"
        solids.beads.specularity = 0.05
        solids.beads.restitution = 0.9
        """
    )
    names = [
        "gas.viscosity",
        "gas.density",
        "developed_flow.radius",
        "developed_flow.gas_velocity",
    ]
    made = gradient(from_dict(values), ["pressure_gradient_Pa_m"], names)
    drag = 3.0 * 1.8e-5 * 0.5 / 0.01**2
    exact = np.array([drag / 1.8e-5, 9.81, -2.0 * drag / 0.01, drag / 0.5])
    assert made.method == "tangent"
    # of gravity in the scene
    assert made.derivatives[0] == approx(exact, rel=1e-3)


def test_developed_flow_against_solutions_on_one_mesh():
    scene = loads(MODELS["developed_flow"].template.read_text(encoding="utf-8"))
    result = cb.run(scene)
    qoi = ["pressure_gradient_Pa_m", "eps_solid_centre", "theta_wall", "u_gas_centre"]
    names = [
        "developed_flow.gas_velocity",
        "solids.beads.restitution",
        "developed_flow.radius",
    ]
    made, base = gradient(scene, qoi, names), DevelopedTangent(result)

    def solve(changed):
        problem = base._problem(changed)
        state, _ = problem.solve_from(base.x)
        found = Result(problem.plan)
        fill(problem, state, found)
        return picked(scene, found.qoi, qoi)

    for j, one in enumerate(key(scene, name) for name in names):
        ends = [solve(one.on(scene, one.value * (1 + side * 1e-4))) for side in (1, -1)]
        found = (ends[0] - ends[1]) / (2e-4 * one.value)
        # kinks of the drag leave their nodes by the change of the step
        assert made.derivatives[:, j] == approx(found, rel=1e-5)
