"""Cells of runs in time that follow errors: states on other cells hold the same,
fronts have their closed forms.
"""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest
from reacting_bed_scenes import heated, isothermal, schumann, species
from solving import marched
from test_bounds_in_time import cores, course_of
from test_reacting_restart import BEDS, STOP

import contbed
from contbed.fem.line_dg import Line
from contbed.fem.line_projection import projected
from contbed.loading import from_dict
from contbed.models import plan
from contbed.reacting_bed.remap import transferred
from contbed.reacting_bed.storage import Storage
from contbed.reacting_bed.time_cells import FEWEST, SHORTEST, fitted, halved
from studies.ignition_front import fronts
from tests.balances import assert_closed
from tests.refusals import refusal, refused
from tests.restarts import interrupt, same_run
from tests.scene_text import set_keys

CLOSED = 1e-12  # of what enters


def following(scene, error=1e-5, **time):
    """A scene whose cells follow its errors."""
    mesh = {key: value for key, value in scene["mesh"].items() if key != "cells"}
    return scene | {
        "mesh": mesh,
        "time": scene["time"] | time,
        "solver": {"adapt": 8, "tolerance": error},
    }


def hot_gas(**heat):
    """A gas that fills the pores and becomes hot where A becomes B."""
    gases = species(A=0.028, B=0.028)
    gases["A"] |= {"heat_capacity": 30.0, "enthalpy": 0.0}
    # another: else all pressures would stay one
    gases["B"] |= {"heat_capacity": 45.0, "enthalpy": -1e4}
    scene = isothermal("A:1", gases) | {
        "heat": {},
        "closures": heat,
        "initial": {"temperature": 400.0},
    }
    set_keys(
        scene,
        """
        solids.particles.density = 2.0
        solids.particles.heat_capacity = 1000.0
        packed_bed.gas_storage = "stored"
        gas.conductivity = 0.05
        reactions = { r = { equation = "A -> B", A = 400.0, E = 3e4 } }
        mesh.cells = 6
        """,
    )
    return scene | {"time": {"end": 3.0, "tolerance": 1e-3}}


def after(scene, steps):
    """The bed and its state after some steps."""
    course = course_of(scene)
    history = list(islice(marched(course), steps))[-1]
    return course.at(history.time), history.state


def held(problem, u):
    """What every cell holds by equation (m, N), and per volume at the nodes."""
    content = Storage(problem, np.zeros_like(u), 1.0).content(u, False)[0]
    return content @ problem.line.weights * problem.line.h, content


def cells(length, count, seed):
    return length * np.sort(
        np.append(np.random.default_rng(seed).random(count - 1), [0.0, 1.0])
    )


def test_polynomials_stay_where_cells_are_divided_and_integrals_stay_everywhere():
    """To rounding, of values of order one."""
    line = Line(cells(1.0, 6, 0), 3)
    values = np.random.default_rng(1).random((2, 6, 4))
    finer = Line(np.union1d(line.vertices, cells(1.0, 9, 2)), 3)
    found = projected(line, values, finer)
    assert np.allclose(
        found,
        line.at(values, finer.points.ravel()).reshape(found.shape),
        rtol=0.0,
        atol=1e-12,
    )
    other = Line(cells(1.0, 5, 3), 3)
    ends = np.array(
        [[line.weights @ v for v in field] * line.h for field in values]
    ).sum(axis=1)
    assert np.allclose(
        (projected(line, values, other) @ line.weights * other.h).sum(axis=1),
        ends,
        rtol=1e-14,
        atol=0.0,
    )


HELD = {
    "section that adsorbs": BEDS["adsorbing section"],
    "kinds that adsorb": BEDS["kinds that adsorb"],
    "kinds of pellets": BEDS["kinds of pellets"],
    "gas in the pores": hot_gas(nusselt=10.0),
    "gas in the pores at one temperature": hot_gas(),
    "cores": cores(60.0),
}


@pytest.mark.parametrize("scene", HELD.values(), ids=HELD)
def test_other_cells_hold_the_same(scene):
    """Moles of each species and heat to 1e-13 of the whole, on finer and coarser
    cells in turn, of reacting beds.
    """
    problem, u = after(scene, 8)
    whole = held(problem, u)[0].sum(axis=1)
    other, state = problem, u
    for count, seed in ((200, 1), (3, 2), (29, 3), (5, 4)):
        other, state = transferred(
            other, state, cells(problem.line.vertices[-1], count, seed)
        )
        parts, content = held(other, state)
        assert np.allclose(
            parts.sum(axis=1),
            whole,
            rtol=1e-13,
            atol=1e-13 * np.abs(whole[whole != 0.0]).min(),
        )
        solids = [k for k, name in enumerate(problem.names) if name.startswith("n_")]
        assert np.all(content[solids] > -1.1e-10 * problem.sizes[solids, None, None])


@pytest.mark.parametrize("name", ["section that adsorbs", "gas in the pores"])
def test_cells_that_are_divided_and_joined_have_their_state_again(name):
    """Values at nodes to 1e-9 of their sizes: what rounding of heat leaves, far
    below errors of steps.
    """
    problem, u = after(HELD[name], 8)
    v = problem.line.vertices
    finer, state = transferred(problem, u, np.union1d(v, 0.5 * (v[1:] + v[:-1])))
    again, found = transferred(finer, state, v)
    held_before, held_after = held(problem, u)[1], held(again, found)[1]
    assert np.abs(held_after - held_before).max() < 1e-11 * np.abs(held_before).max()
    stored = np.abs(held_before).max(axis=(1, 2)) > 0.0
    assert np.abs((found - u)[stored] / problem.sizes[stored, None, None]).max() < 1e-9


def test_cells_are_halves_of_halves_as_short_as_wanted():
    wanted = np.full(FEWEST, 0.2)
    wanted[2] = 0.01
    found = halved(np.linspace(0.0, 1.0, FEWEST + 1), wanted)
    h = np.diff(found)
    assert np.all(np.log2(h) % 1.0 == 0.0) and set(
        np.linspace(0.0, 1.0, FEWEST + 1)
    ) <= set(found)
    inside = (found[:-1] >= 2 / FEWEST) & (found[1:] <= 3 / FEWEST)
    # the longest such that is no longer than 0.01
    assert h[inside].max() == 2.0**-7 and h.max() == 1 / FEWEST
    assert np.max(h[1:] / h[:-1]) <= 4.0  # neighbours are alike
    assert np.diff(halved(found, np.full(len(h), 1e-9))).min() == SHORTEST


XI = 1000.0  # transfer units


def thermal(**mesh):
    """A front of heat a twentieth as long as the bed, half way through."""
    scene, eta_per_s = heated(XI)
    scene["mesh"] |= mesh
    scene["time"] |= {"end": 0.5 * XI / eta_per_s, "tolerance": 1e-3}
    scene["output"] |= {
        "positions": np.linspace(0.0, scene["mesh"]["length"], 41).tolist()
    }
    return scene


def test_a_front_of_heat_has_its_closed_form():
    """Schumann's within the error of steps, 2.2e-3 on 40 cells of one length; 10 of
    them miss ten times as much.
    """
    exact = np.array([schumann(XI * x, 0.5 * XI) for x in np.linspace(0.0, 1.0, 41)])
    errors = []
    for scene in (thermal(cells=10), following(thermal(), 1e-4)):
        result = contbed.run(from_dict(scene))
        errors.append(
            np.abs((result.profiles["T_fluid [K]"] - 300.0) / 300.0 - exact).max()
        )
        assert_closed(result, CLOSED, "energy")
    assert errors[0] > 0.02
    assert errors[1] < 2.5e-3
    assert result.qoi["cells_changes"] > 0 and result.qoi["cells_error"] < errors[1]
    assert FEWEST <= result.qoi["cells"] <= result.qoi["cells_most"] < 50


FOLLOWING = [
    pytest.param(
        following(hot_gas(nusselt=10.0), 1e-2, times=[0.3], end=0.5, tolerance=1e-2),
        id="gas in the pores",
    ),
    pytest.param(
        following(cores(60.0), 1e-3, times=[2.0]), id="cores", marks=pytest.mark.slow
    ),
    pytest.param(
        following(BEDS["kinds of pellets"], 1e-3), id="pellets", marks=pytest.mark.slow
    ),
    pytest.param(
        following(BEDS["adsorbing section"], 1e-5),
        id="section that adsorbs",
        marks=pytest.mark.slow,
    ),
]


@pytest.mark.parametrize("given", FOLLOWING)
def test_restart_on_cells_that_follow_goes_on_bit_for_bit(tmp_path, given):
    given = from_dict(given)
    whole = contbed.run(given)
    assert whole.qoi["cells_changes"] > 1
    interrupt(given, tmp_path / "a", *STOP)
    same_run(contbed.run(given, out=tmp_path / "b", restart=tmp_path / "a"), whole)
    assert_closed(whole, CLOSED)


def test_a_run_begins_on_cells_that_fit_its_profiles(tmp_path):
    """Profiles between two points of each cell are linear: cells are a little
    shorter than those they come from.
    """
    given = following(thermal(), 1e-3)
    set_keys(given, "output = { plots = false }")
    before = contbed.run(from_dict(given), out=tmp_path)
    del given["initial"]["temperature"]
    given["time"] |= {"end": 1e-3 * given["time"]["end"]}
    given["initial"] |= {"file": str(tmp_path / "profiles.csv")}
    course = fitted(course_of(given))
    x, T = before.profiles["x [m]"], before.profiles["T_solid [K]"]
    found = course.problem.line.at(
        course.start()[course.problem.names.index("T_solid")], x
    )
    assert FEWEST < course.problem.line.cells <= 2 * before.qoi["cells"]
    assert np.abs(found - T).max() < 1e-2 * 300.0


@pytest.mark.slow
def test_temperatures_at_a_front_of_heat_keep_their_bounds():
    """Within the error of cells that a run tells, where they leave them by 7 % on 60
    cells; means to 0.2 K of 539 K.
    """
    scene = contbed.load(
        fronts.HERE / "oxygen_carrier.toml", {"output.positions": fronts.X.tolist()}
    )
    exact, left = fronts.reference(scene.time.end)
    result = contbed.run(scene)
    T, span = result.profiles["T_fluid [K]"], np.ptp(exact)
    assert result.qoi["cells_error"] < 0.02
    assert (
        max(T.max() - exact.max(), exact.min() - T.min())
        < result.qoi["cells_error"] * span
    )
    assert np.abs(T - exact).mean() < 0.2
    assert np.abs(result.profiles["w_S [1]"] - left).max() < 1e-3  # that of steps
    assert any(
        "fronts are shorter than the shortest cells" in text for text in result.warnings
    )
    closed = {
        name: abs(balance["relative_residual"])
        for name, balance in result.balances.items()
    }
    assert closed.pop("energy") < 1e-11  # as on cells of one length
    assert max(closed.values()) < 0.1 * CLOSED


def test_a_plan_says_that_cells_are_adaptive():
    told = dict(plan(from_dict(following(thermal()))).built)["cells"]
    assert told.startswith(f"{FEWEST} initially") and "adaptive" in told
    assert "adaptive" not in dict(plan(from_dict(thermal(cells=10))).built)["cells"]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            lambda s: s["mesh"].update(cells=10),
            "solver.adapt = 8: cells do not follow errors beside mesh.cells",
        ),
        (
            lambda s: s["time"].update(cycle={}),
            "solver.adapt = 8: cells do not follow errors in time.cycle",
        ),
    ],
)
def test_cells_that_cannot_follow_are_a_mistake(change, said):
    scene = following(thermal())
    scene["boundary"]["left"]["gas"]["temperature"] = {
        "times": [0, 1],
        "values": [600.0, 300.0],
        "period": 2.0,
    }
    change(scene)
    assert said in refusal(from_dict, scene)


@pytest.mark.parametrize("time", [{"end": 1.0}, None], ids=["in time", "steady"])
def test_refinement_of_cells_that_are_not_given_is_a_mistake(time):
    scene = thermal()
    scene["time"] = time
    set_keys(scene, "mesh.refine = 1")
    refused("has no effect on cells that the run chooses; give mesh", from_dict, scene)
    set_keys(scene, "mesh.cells = 3")
    assert plan(from_dict(scene)).problem.line.cells == 6
