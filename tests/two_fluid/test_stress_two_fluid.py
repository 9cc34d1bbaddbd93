"""Beds in hard corners: packing shocks, steps at the Courant limit, random fields,
extreme particles.
"""

import numpy as np
import pytest
from gmsh_meshes import IN_3D, geometry

from contbed.loading import from_dict
from contbed.two_fluid import plan as planning
from contbed.two_fluid.solids_pressure import FrictionTable, frictional_pressure
from tests.scene_text import scene_of

WALL = {"type": "wall"}
THROWN = {
    "layer": [
        {
            "start": 0.1,
            "end": 0.2,
            "solids": {"beads": {"volume_fraction": 0.55, "velocity": -1.0}},
            "gas": {"velocity": -1.0},
        }
    ]
}


def build(
    two_fluid=None,
    solids=None,
    closures=None,
    gas=None,
    initial=None,
    bottom=None,
    cells=(8, 24),
    shape="quadrilateral",
    mesh=None,
    **time,
):
    """A small bed, on a `mesh` or a rectangle."""
    scene = scene_of(
        """
            [boundary]
            top = { type = "outlet" }
        """,
        {
            "mesh": mesh
            or {
                "type": "rectangle",
                "length": 0.1,
                "height": 0.3,
                "cells": cells,
                "shape": shape,
            },
            "two_fluid": two_fluid or {},
            "gas": gas or {"density": 1.2, "viscosity": 1.8e-5},
            "closures": closures or {},
            "solids.beads": {"diameter": 275e-6, "density": 2500.0}
            | (solids or {}).get("beads", {}),
            "initial": initial or {},
            "boundary.bottom": bottom or WALL,
            "boundary.left": WALL,
            "boundary.right": WALL,
            "time": {"end": 1.0} | time,
        },
    )
    return planning.plan(from_dict(scene, trust=True)).bed()[0]


def solids(bed):
    """Volume of the particles here and of those that left."""
    return (
        bed.state.eps_s @ bed.model.grid.geometry.volume + bed.state.account.solid_out
    )


def watched(bed, end):
    """Largest eps_s and speed until `end`; bounds and mass are kept to rounding."""
    before, dense, fast = solids(bed), [], []

    def look(bed):
        assert bed.state.eps_s.min() >= 0.0
        assert bed.state.theta.min() >= 0.0
        dense.append(bed.state.eps_s.max())
        fast.append(
            np.linalg.norm(bed.state.u_solid, axis=1).max(
                where=bed.state.eps_s > 1e-6, initial=0.0
            )
        )

    bed.advance(end, look)
    assert solids(bed) == pytest.approx(before, rel=1e-12)
    assert max(dense) <= bed.model.materials.eps_max
    return max(dense), max(fast)


@pytest.mark.parametrize("courant", [0.5, 0.9, 1.0])
def test_slug_thrown_on_a_wall_packs_and_stays(courant):
    # at eps_s = 0.605 friction over rho_s is 23 m2/s2, far more than stops 1 m/s and
    # the fall: nothing packs further or flies apart. With one tangent a step
    # particles reach hundreds of m/s
    dense, fast = watched(build(initial=THROWN, courant=courant, cells=(12, 36)), 0.25)
    assert 0.55 < dense < 0.605
    assert fast < 2.0


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"shape": "triangle"},
        {"two_fluid": {"granular_temperature": "algebraic"}},
        {
            "closures": {"friction_viscosity": "friction_viscosity_schaeffer"},
            "courant": 1.0,
        },
        {"solids": {"beads": {"diameter": 3e-3, "restitution": 1.0}}},
        {"solids": {"beads": {"diameter": 50e-6, "restitution": 0.5}}},
        {
            "solids": {"beads": {"density": 1100.0}},
            "gas": {"density": 1000.0, "viscosity": 1e-3},
        },
    ],
)
def test_random_fields_calm_down(changes):
    bed = build(bottom={"type": "inlet", "gas": {"velocity": 0.2}}, **changes)
    random, cells = np.random.default_rng(1), len(bed.state.eps_s)
    bed.start(
        eps_s=random.uniform(0.0, 0.6, cells),
        theta=random.uniform(0.0, 1.0, cells),
        u_gas=random.uniform(-1.0, 1.0, (cells, 2)),
        u_solid=random.uniform(-1.0, 1.0, (cells, 2)),
    )
    # three times the fastest at the start; spurious forces give tens of m/s
    assert watched(bed, 0.1)[1] < 3.0 * 2.0**0.5


@pytest.mark.parametrize(("size", "most"), [(None, 2e-4), (0.01, 1e-3)])
def test_level_bed_on_triangles_calms_down(size, most, tmp_path):
    # the surface cuts gmsh's triangles at unequal heights, and where friction is a
    # viscosity they level at 3e-4 m/s; forces without a potential and cells that follow
    # their empty neighbours keep a bed at 6e-2 m/s, and rounding in empty cells throws
    # particles from the surface at 4e-2 m/s now and then if they share the velocities
    # of its faces; linear velocities that pass skewed faces move the surface at up to
    # 1.1e-4 m/s, without them 3e-5
    def look(bed):
        speed = np.linalg.norm(bed.state.u_solid, axis=1)
        assert speed.max(where=bed.state.eps_s > 1e-2, initial=0.0) < most

    mesh = None
    if size is not None:
        (tmp_path / "bed.geo").write_text(geometry("triangles", 0.1, 0.3, size))
        mesh = {"type": "file", "file": str(tmp_path / "bed.geo")}
    layer = {
        "layer": [{"end": 0.12, "solids": {"beads": {"volume_fraction": 0.58}}}],
        "solids": {"beads": {"granular_temperature": 1e-4}},
    }
    bed = build(initial=layer, cells=(9, 27), shape="triangle", mesh=mesh)
    bed.advance(1.0)
    bed.advance(4.0, look)


@pytest.mark.parametrize(
    ("kind", "size"), [("triangles", 0.004), ("tetrahedra", 0.008)]
)
def test_glass_settles_in_water(kind, size, tmp_path):
    # clear water above, whose depth is what the upper half has lost: within 1 % of the
    # height of the suspension while cells of 4 and 8 mm keep the sediment out of the
    # upper half
    (tmp_path / "bed.geo").write_text(geometry(kind, 0.02, 0.1, size))
    scene = scene_of(
        """
        [mesh]
        type = "file"
        [closures]
        drag = "drag_wen_yu"
        [two_fluid]
        guards = false
        [gas]
        density = 998.0
        viscosity = 1e-3
        [solids.beads]
        diameter = 1e-4
        density = 2500.0
        packing_limit = 0.6
        [initial]
        solids.beads.volume_fraction = 0.1
        [time]
        end = 6.0
        """,
        {
            "mesh.file": str(tmp_path / "bed.geo"),
            "mesh.dimension": 3 if kind in IN_3D else 2,
        },
    )
    names = ("bottom", "top", "left", "right") + (
        ("front", "back") if kind in IN_3D else ()
    )
    scene["boundary"] = dict.fromkeys(
        names, WALL | {"gas": {"wall": "slip"}, "solids": {"beads": {"wall": "slip"}}}
    )
    bed = planning.plan(from_dict(scene, trust=True)).bed()[0]
    watched(bed, 6.0)
    volume, upper = bed.model.grid.geometry.volume, bed.model.grid.centres[:, -1] > 0.05
    front = 0.1 - 0.1 * (volume * (0.1 - bed.state.eps_s))[upper].sum() / (
        0.1 * volume.sum()
    )
    assert front == pytest.approx(0.1 - 4.60966e-3 * 6.0, rel=0.01)


def test_table_of_friction_is_pressure_and_slope():
    table = FrictionTable(0.5, 0.01, np.array([0.0, 1.0, 4.0]))
    known = [
        (0.4, (0.0, 0.0)),
        (0.505, (0.5, 100.0)),
        (0.515, (2.5, 300.0)),
        (0.6, (4.0, 300.0)),
    ]
    for s, pair in known:
        assert frictional_pressure(table, s) == pytest.approx(pair, rel=1e-9)
