"""Beds whose sides exchange little heat: the bound on what leaves, and the dimension
that the plan takes.
"""

from __future__ import annotations

import numpy as np
import pytest

import contbed as cb
from contbed.packed_bed.plan import plan
from contbed.packed_bed.sides import error_without_sides
from tests.balances import assert_closed
from tests.scene_text import scene_of


def round_bed(coefficient=None, flux=None, **more):
    """Bed of spheres 0.5 m long and 0.1 m wide, G c = 1000 W/m2/K, heated through
    its wall.
    """
    wall = (
        {"coefficient": coefficient, "ambient": 500.0}
        if flux is None
        else {"heat_flux": flux}
    )
    scene = scene_of(
        """
        [mesh]
        type = "axisymmetric"
        length = 0.5
        radius = 0.05
        [gas]
        model = "constant"
        density = 1.0
        heat_capacity = 1000.0
        conductivity = 0.03
        viscosity = 2e-5
        [solids.particles]
        density = 2000.0
        heat_capacity = 800.0
        conductivity = 1.0
        diameter = 0.005
        [packed_bed]
        porosity = 0.4
        [closures]
        nusselt = 20.0
        conductivity_solids = 1.0
        conductivity_gas = 1.0
        [heat]
        [boundary.bottom]
        gas.velocity = 1.0
        gas.temperature = 300.0
        """,
        {"boundary.wall.gas": wall},
    )
    return {**scene, **more}


def test_bound_is_the_number_of_transfer_units_of_the_wall():
    scene = cb.load(round_bed(3.0))
    # h 2 L/R/(G c) = 3 x 20/1000
    assert error_without_sides(scene, plan(scene).medium) == pytest.approx(
        0.06, rel=1e-12
    )
    # a flux alone has no temperature to compare with, but for what enters with moving
    # solids
    moving = round_bed(flux=50.0)
    moving["boundary"]["bottom"]["solids"] = {
        "particles": {"velocity": 1e-3, "temperature": 400.0}
    }
    scene = cb.load(moving)
    assert error_without_sides(scene, plan(scene).medium) == pytest.approx(
        50.0 * 20 / (1000.0 * 100.0), rel=1e-12
    )


@pytest.mark.parametrize("seed", range(6))
def test_what_leaves_is_within_the_bound(seed):
    random = np.random.default_rng(seed)
    keys = round_bed(10.0 ** random.uniform(-1.0, 1.5))
    keys["closures"]["conductivity_solids"] = 10.0 ** random.uniform(-1.0, 1.0)
    keys["boundary"]["wall"]["solids"] = {
        "particles": {
            "coefficient": 10.0 ** random.uniform(-1.0, 1.5),
            "ambient": 500.0,
        }
    }
    if seed % 2:
        velocity = 10.0 ** random.uniform(-4.0, -3.0)
        keys["boundary"]["bottom"]["solids"] = {
            "particles": {"velocity": velocity, "temperature": 300.0}
        }
    keys["mesh"]["cells"] = [12, 40]
    scene = cb.load(keys)
    bound = error_without_sides(scene, plan(scene).medium)
    whole = cb.run(scene)
    line = (
        cb.run(cb.load(keys | {"solver": {"accuracy": 0.999}}))
        if bound < 0.999
        else None
    )
    names = [
        f"T_{phase}_out_K"
        for phase in ("fluid", "solid")
        if f"T_{phase}_out_K" in whole.qoi
    ]
    # on a line nothing is heated, so that all leaves at 300 K
    assert line is None or all(
        line.qoi[name] == pytest.approx(300.0, abs=1e-6) for name in names
    )
    error = max(whole.qoi[name] - 300.0 for name in names) / 200.0
    assert 0.0 < error <= bound
    if bound < 0.1:
        # the first order of the number of transfer units; nearly all heat goes into the
        # streams
        assert error > 0.3 * bound or seed % 2


def test_a_line_is_taken_only_where_the_accuracy_is_stated_and_met():
    for accuracy, dimension in ((None, 2), (1e-3, 2), (0.05, 1)):
        solver = {} if accuracy is None else {"accuracy": accuracy}
        found = plan(cb.load(round_bed(0.1, solver=solver)))
        assert found.mesh.skfem.dim() == dimension
        assert "changes the outlet by at most 0.2 % of the temperature span" in str(
            found
        )
    # where the scene says that nothing is reduced, nothing is
    found = plan(cb.load(round_bed(0.1, solver={"accuracy": 0.05, "reduce": False})))
    assert found.mesh.skfem.dim() == 2


@pytest.mark.parametrize(
    "what", ["fixed_temperature", "flux and coefficient", "source"]
)
def test_sides_without_a_bound_are_resolved(what):
    keys = round_bed(0.1, solver={"accuracy": 0.05})
    if what == "fixed_temperature":
        keys["boundary"]["wall"]["solids"] = {"particles": {"fixed_temperature": 500.0}}
    elif what == "source":
        keys["region"] = {"bed": {"solids": {"heat_source": 1e5}}}
    else:
        keys["boundary"]["wall"]["solids"] = {"particles": {"heat_flux": 1.0}}
    found = plan(cb.load(keys))
    assert found.mesh.skfem.dim() == 2 and "changes what leaves" not in str(found)


def test_a_transient_without_sides_runs_and_closes_its_balance():
    keys = round_bed(0.1, solver={"accuracy": 0.05})
    keys["boundary"]["bottom"]["gas"]["temperature"] = 400.0
    keys |= {
        "time": {"end": 600.0, "tolerance": 1e-3},
        "initial": {"temperature": 300.0},
    }
    found = cb.run(cb.load(keys))
    assert found.plan.mesh.skfem.dim() == 1
    assert_closed(found, 1e-10, "energy")
