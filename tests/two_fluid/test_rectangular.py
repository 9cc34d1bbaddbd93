"""Kernels over rows of rectangular grids against those for any mesh: the same
numbers to rounding.
"""

from dataclasses import replace
from itertools import cycle
from pathlib import Path

import numpy as np
import pytest
from core_closures import bed, closures, line, rectangle, shaken

import contbed as cb
from contbed.compiled import threads
from contbed.loading import from_dict
from contbed.mesh import build as meshing
from contbed.scene.mesh import MeshRectangle
from contbed.two_fluid import implicit
from contbed.two_fluid.boundary import InletCondition, OutletCondition, WallCondition
from contbed.two_fluid.fv import grid
from contbed.two_fluid.linear.pressure_solver import PressureSolver
from contbed.two_fluid.simulation import Simulation
from contbed.two_fluid.state import flatten, rebuild
from tests.scene_text import changed, scene_of


@pytest.fixture(autouse=True)
def small_grids_in_rows(monkeypatch):
    """Kernels over rows on grids of any size."""
    monkeypatch.setattr(grid, "FEWEST_IN_ROWS", 0)


HOT_BUBBLE = (
    Path(__file__).parents[2]
    / "studies"
    / "patil_hot_bubble_two_fluid"
    / "half_3mm_900.toml"
)
WALL = {
    "type": "wall",
    "solids": {
        "beads": {"wall": "johnson_jackson", "specularity": 0.01, "restitution": 0.9}
    },
}
BED = scene_of(
    """
model = "two_fluid"

[mesh]
type = "rectangle"
length = 0.06
height = 0.12
cells = [9, 20]

[closures]
drag = "drag_gidaspow"

[gas]
density = 1.225
viscosity = 1.7894e-5

[solids.beads]
diameter = 275e-6
density = 2500.0

[initial]
gas.velocity = 0.46
noise = 0.02
layer = [{ end = 0.06, solids = { beads = { volume_fraction = 0.55 } }, gas = { velocity = 1.0 } }]

[boundary]
bottom.type = "inlet"
bottom.gas = { velocity = 0.46 }
top.type = "outlet"

[time]
end = 1.0
""",
    {"boundary.left": WALL, "boundary.right": WALL},
)
SOLID_INLET = {
    "type": "inlet",
    "gas": {"velocity": 1.2},
    "solids": {
        "beads": {
            "volume_fraction": 0.1,
            "mass_flux": 100.0,
            "granular_temperature": 0.01,
        }
    },
}
SCENES = {
    "bed": BED,
    "solids enter": changed(BED, {"boundary.bottom": SOLID_INLET}),
    "box": changed(
        BED,
        {
            "mesh": {
                "type": "box",
                "length": 0.03,
                "width": 0.04,
                "height": 0.12,
                "cells": (4, 5, 11),
            },
            "boundary.front": WALL,
            "boundary.back": {"type": "symmetry"},
        },
    ),
    "axisymmetric": changed(
        BED,
        {
            "mesh": {
                "type": "axisymmetric",
                "radius": 0.03,
                "length": 0.12,
                "cells": (6, 20),
            },
            "boundary.axis": {"type": "symmetry"},
            "boundary.wall": WALL,
        },
        ("boundary.left", "boundary.right"),
    ),
}


def around_a_tube():
    """Bed of a lattice with empty places."""
    mesh = meshing.build(
        MeshRectangle(type="rectangle", length=0.06, height=0.12, cells=(9, 20))
    )
    x, y = mesh.skfem.p[:, mesh.skfem.t].mean(axis=1)
    inside = (np.abs(x - 0.03) < 0.012) & (np.abs(y - 0.05) < 0.01)
    cut = mesh.skfem.restrict(np.flatnonzero(~inside))
    ends = {"bottom": lambda x: x[1] < 1e-9, "top": lambda x: x[1] > 0.12 - 1e-9}
    sides = {"walls": lambda x: (x[1] > 1e-9) & (x[1] < 0.12 - 1e-9)}
    named = replace(cut, _boundaries=None).with_boundaries(ends | sides)
    on = grid.build(replace(mesh, skfem=named))
    conditions = {
        "bottom": InletCondition(velocity=0.5),
        "top": OutletCondition(),
        "walls": WallCondition(),
    }
    found = bed(
        on,
        closures(drag=2000.0, pressure=1.0, viscosity=0.01, conductivity=0.01),
        conditions,
        (0.0, -9.81),
    )
    found.start(eps_s=0.3 * (on.centres[:, 1] < 0.08), u_gas=(0.0, 0.5), theta=1e-3)
    return found


CASES = {
    name: lambda scene=scene: cb.plan(from_dict(scene)).bed()[0]
    for name, scene in SCENES.items()
}
CASES["around a tube"] = around_a_tube
CASES["heat"] = lambda: cb.plan(cb.load(HOT_BUBBLE)).bed()[0]
# kernels by rows of three dimensions take half a minute to compile
NAMES = [
    pytest.param(name, marks=pytest.mark.slow) if name == "box" else name
    for name in CASES
]


def both(by_rows):
    """The same bed by rows, and face by face with vectors in the memory order of
    other meshes.
    """
    model = by_rows.model
    on = replace(model.grid, rectangular=False, places=None)
    solver = PressureSolver(on, model.pressure_solver.floating)
    general = Simulation(replace(model, grid=on, pressure_solver=solver))
    saved = flatten(by_rows.state)
    saved = {
        name: np.array(v, order="C") if isinstance(v, np.ndarray) else v
        for name, v in saved.items()
    }
    general.state = rebuild(by_rows.state, saved)
    return by_rows, general


@pytest.mark.parametrize("name", NAMES)
def test_a_step_by_rows_is_that_of_any_mesh(name, monkeypatch):
    # iterations converged as far as rounding lets them, as their last residuals differ
    monkeypatch.setattr(implicit, "TOLERANCE", 1e-15)
    made = CASES[name]()
    assert made.model.grid.rows is not None
    for _ in range(12):
        made.step(made.next_step())
    dt = 5 * made.next_step()
    by_rows, general = both(made)
    by_rows.step(dt)
    general.step(dt)
    found, expected = flatten(by_rows.state), flatten(general.state)
    assert found.keys() == expected.keys()
    # rates are differences of two velocities over the step: their rounding is that of
    # velocities over the step
    speed = max(
        np.abs(expected[f"state.u_{phase}"]).max() for phase in ("gas", "solid")
    )
    # cells so empty that rounding is a large share of what they hold have no meaningful
    # velocity of particles
    filled = general.state.eps_s > 1e-12
    for key, values in expected.items():
        least = speed / dt if ".memory.rate" in key or ".memory.force" in key else 1e-30
        # of adiabatic walls: rounding of the heat that cells give each other
        if key == "state.energy.account.walls":
            least = float(expected["state.energy.account.heat_in"])
        both_values = found[key], values
        if key in (
            "state.u_solid",
            "state.memory.rate_solid",
            "state.memory.force_solid",
        ):
            both_values = found[key][filled], values[filled]
        largest = max(np.abs(values).max(initial=0), least)
        np.testing.assert_allclose(
            *both_values, rtol=0, atol=1e-12 * largest, err_msg=key
        )


# cells that threads share the lattices of multigrid for, 5 blocks, and where no
# multigrid is needed
FINE = changed(BED, {"mesh.cells": (90, 100), "boundary.bottom": SOLID_INLET})


@pytest.mark.parametrize("name", [*NAMES, "fine"])
def test_bits_do_not_depend_on_the_number_of_threads(name, monkeypatch):
    make, found = CASES.get(name, lambda: cb.plan(from_dict(FINE)).bed()[0]), []
    for number in (1, 2, 3):
        # also for beds that are too small to gain from threads
        monkeypatch.setattr(threads, "count", lambda *_, number=number: number)
        made = make()
        for _ in range(4):
            made.step(made.next_step())
        found.append(
            {
                key: np.asarray(value).tobytes()
                for key, value in flatten(made.state).items()
            }
        )
    assert made.model.pressure_solver.lattice is not None
    assert found[0] == found[1] == found[2]


def test_the_number_of_threads_may_change_at_any_time(monkeypatch):
    """As it does where a run measures which number is the fastest."""
    found = []
    for numbers in ([1], [2, 1, 3]):
        turn = cycle(numbers)
        monkeypatch.setattr(threads, "count", lambda *_, turn=turn: next(turn))
        made = cb.plan(from_dict(FINE)).bed()[0]
        for _ in range(4):
            made.step(made.next_step())
        found.append(
            {
                key: np.asarray(value).tobytes()
                for key, value in flatten(made.state).items()
            }
        )
    assert found[0] == found[1]


def test_parts_hold_every_face_once():
    on = rectangle(0.1, 0.2, (5, 9), [("left", "right")])
    for number in (1, 2, 4):
        taken, cells = (
            np.zeros(len(on.geometry.left), int),
            np.zeros((2, len(on.cells)), int),
        )
        for g, rows in on.parts(number):
            taken[g.edge_from : g.edge_to] += 1
            cells[0, g.left[g.edge_from : g.edge_to]] -= 1
            for r in range(len(rows.length)):
                of_left = np.arange(rows.left_from[r], rows.left_to[r], dtype=int)
                of_right = np.arange(rows.right_from[r], rows.right_to[r], dtype=int)
                taken[int(rows.face[r]) + of_left] += 1
                cells[0, int(rows.left[r]) + of_left] += 1
                cells[1, int(rows.right[r]) + of_right] += 1
                np.testing.assert_array_equal(
                    g.left[int(rows.face[r]) + of_left], int(rows.left[r]) + of_left
                )
                np.testing.assert_array_equal(
                    g.right[int(rows.face[r]) + of_right], int(rows.right[r]) + of_right
                )
                assert (rows.begin <= int(rows.left[r]) + of_left).all() and (
                    int(rows.left[r]) + of_left < rows.end
                ).all()
        assert (taken == 1).all()
        g, ni = on.geometry, on.interior
        np.testing.assert_array_equal(
            cells[0],
            np.bincount(g.left[:ni], minlength=45)
            - np.bincount(g.left[ni:], minlength=45),
        )
        np.testing.assert_array_equal(cells[1], np.bincount(g.right, minlength=45))


@pytest.mark.parametrize(
    ("on", "rows"),
    [
        (rectangle(0.1, 0.2, (3, 7)), 1 + 3),
        (rectangle(0.1, 0.2, (3, 7), [("left", "right")]), 1 + 1 + 3),
        (rectangle(0.1, 0.2, (3, 7), [("bottom", "top")]), 1 + 3 + 3),
        (line(0.1, 9), 1),
    ],
    ids=["walls", "periodic across", "periodic along", "line"],
)
def test_rows_hold_all_faces_in_order(on, rows):
    found, g = on.rows, on.geometry
    assert len(found.face) == rows and found.length.sum() == on.interior
    for axis, *row in zip(
        found.axis, *(x.astype(int) for x in found[1:5]), strict=True
    ):
        face, left, right, length = row
        each = np.arange(length)
        np.testing.assert_array_equal(g.left[face + each], left + each)
        np.testing.assert_array_equal(g.right[face + each], right + each)
        np.testing.assert_allclose(
            g.normal[face + each], np.eye(on.dimension)[[axis] * length], atol=1e-14
        )


def test_skewed_grids_have_no_rows():
    assert rectangle(0.1, 0.2, (3, 4), shape="triangle").rows is None
    assert shaken("quadrilateral", (4, 4)).rows is None
