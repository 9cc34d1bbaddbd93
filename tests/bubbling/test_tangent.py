"""The tangent of bubbling beds against differences of solutions on the same mesh,
with sizes and height that settle.
"""

import itertools

import numpy as np
import pytest
from bubbling_scenes import case1, put
from computed_scenes import tables as closure_tables
from reacting_scenes import combustor

import contbed as cb
from contbed.bubbling_bed import tangent
from contbed.bubbling_bed.results import fill
from contbed.bubbling_bed.settling import settle, stretched, unsettled
from contbed.bubbling_bed.tangent import Tangent
from contbed.errors import UnlikeError
from contbed.loading import from_dict, loads
from contbed.many.derivatives.gradients import _of_state, gradient, picked
from contbed.many.derivatives.keys import key
from contbed.result import Result


def on_one_mesh(result, qoi):
    """Results of full solutions on the mesh of a run, stretched to the height, as a
    function of the scene.
    """
    base = Tangent(result)

    def solve(scene):
        problem = stretched(base.problem.plan, base._as_settled(scene))
        state, _ = problem.solve_from(base.x)
        found = Result(problem.plan)
        if unsettled(scene):
            problem, state = settle(problem, state, found)
        fill(problem.plan, problem, state, found)
        return picked(scene, found.qoi, qoi)

    return solve


def worst(scene, names, step=1e-4):
    """Largest difference over the largest relative derivative of each result."""
    result = cb.run(scene)
    qoi = [
        name
        for name in result.qoi
        if name.endswith(("_mid_K", "convection_W", "_top_K", "height_m", "drain_kg_s"))
    ]
    qoi = [name for name in qoi if not name.startswith("height_at")]
    made = gradient(scene, qoi, names)
    assert made.method == "tangent"
    solve, columns = on_one_mesh(result, qoi), []
    for one in (key(scene, name) for name in names):
        ends = [
            solve(one.on(scene, one.value * (1.0 + side * step))) for side in (1, -1)
        ]
        columns.append((ends[0] - ends[1]) / (2.0 * step * one.value))
    found = np.array(columns).T
    weights = np.abs(found * made.at).max(axis=1, keepdims=True)
    return (np.abs(made.derivatives - found) * np.abs(made.at) / weights).max()


def test_bed_of_given_coefficients():
    names = ["bubbling_bed.section", "boundary.bottom.gas.temperature"]
    names += [
        f"bubbling_bed.{key}"
        for key in ("tubes.temperature", "tubes.coefficient", "height")
    ]
    assert worst(case1("p1"), names) < 1e-6


def test_bed_of_closures():
    names = [
        "boundary.bottom.gas.mass_flow",
        "solids.inert.diameter",
        "bubbling_bed.height",
    ]
    assert worst(from_dict(closure_tables() | {"mesh": {"cells": 16}}), names) < 1e-6


def settling():
    """A bed of sand of four sizes, fed and drained, below a freeboard, of a height
    by its bubbles.
    """
    tables = closure_tables(freeboard={"height": 3.0, "elutriation": "geldart"})
    sand = tables["solids"]["inert"]
    del sand["diameter"]
    sand["sizes"] = {
        "diameters": [1e-4, 2e-4, 5e-4, 1e-3],
        "feed": [0.1, 0.2, 0.4, 0.3],
    }
    sand["feed"] = {
        "mass_flow": 1.0,
        "temperature": 300.0,
        "height": 0.2,
        "width": 0.05,
    }
    return tables | {"mesh": {"cells": 12}}


@pytest.mark.slow
def test_sizes_that_settle():
    # steps of 1e-4 show to what error sizes settle, those of 1e-3 their own
    assert worst(from_dict(settling()), ["boundary.bottom.gas.mass_flow"], 3e-4) < 1e-6


@pytest.mark.slow
def test_sizes_and_height_that_settle():
    tables = settling()
    put(
        tables,
        ("bubbling_bed",),
        {"settled_height": 0.4, "section": 1.0, "solids_fraction": 0.5},
    )
    names = [
        "boundary.bottom.gas.mass_flow",
        "bubbling_bed.settled_height",
        "solids.inert.feed.mass_flow",
    ]
    assert worst(from_dict(tables), names) < 1e-6


DRIER = """
[bubbling_bed]
settled_height = 0.5
section = 3.0
solids_fraction = 0.55
[bubbling_bed.bubbles]
size = 0.1
[bubbling_bed.tubes]
perimeter = 25.0
coefficient = 350.0
temperature = 453.15
[bubbling_bed.walls]
perimeter = 7.0
coefficient = 8.0
temperature = 298.15
[gas]
material = "air"
[closures]
minimum_fluidization = "wen_yu"
[boundary.bottom]
gas.mass_flow = 1.5
gas.temperature = 293.15
[solids.sand]
diameter = 5e-4
density = 2650.0
heat_capacity = 850.0
nusselt = "ranz_marshall"
mixing_conductivity = 3e4
feed = { mass_flow = "10 t/h", temperature = 288.15, height = 0.3, width = 0.1, drain = "bottom" }
"""


def test_a_height_whose_change_is_rounded(monkeypatch):
    """Of a stiff bed, such as one that burns: a change of the height that is rounded by
    1e-6 of itself leaves the derivative of the bed to 1e-5.
    """
    scene, name = loads(DRIER), "bubbling_bed.tubes.perimeter"
    exact = gradient(scene, "T_sand_mid_K", name)
    apart, count = tangent._apart, itertools.count()
    monkeypatch.setattr(
        tangent,
        "_apart",
        lambda scenes: apart(scenes) * (1.0 + 1e-6 * (-1.0) ** next(count)),
    )
    found = gradient(scene, "T_sand_mid_K", name)
    assert found.derivatives == pytest.approx(exact.derivatives, rel=1e-5)


@pytest.mark.slow
def test_a_height_that_hardly_moves():
    """A key whose small change moves the height of the bed by 1e-8 of it: rounding ends
    the rounds.
    """
    scene, name, step = loads(DRIER), "bubbling_bed.walls.perimeter", 0.5
    made = gradient(scene, "T_sand_mid_K", name)
    above, below = (
        cb.run(key(scene, name).on(scene, 7.0 + side * step)).qoi["T_sand_mid_K"]
        for side in (1, -1)
    )
    # of second order in steps of 7 %
    assert made.derivatives[0, 0] == pytest.approx(
        (above - below) / (2.0 * step), rel=5e-3
    )


@pytest.mark.slow
def test_bed_that_reacts():
    names = [
        "solids.char.feed.mass_flow",
        "boundary.bottom.gas.mass_flow",
        "reactions.devolatilisation.time",
    ]
    names += ["bubbling_bed.tubes.coefficient"]
    assert worst(combustor(), names) < 1e-6


def test_results_beside_the_state_are_told():
    with pytest.raises(
        UnlikeError, match="fold_1 does not follow from the steady state alone"
    ):
        _of_state(case1("p1"), {"duty_W": 1.0}, ("fold_1",))
