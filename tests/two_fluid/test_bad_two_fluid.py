"""Two-fluid scenes with mistakes: each is named with its key before anything is
built.
"""

import meshio
import numpy as np
import pytest

from contbed.loading import from_dict
from contbed.models import plan
from tests.cases import each_case
from tests.refusals import refusal, refused
from tests.scene_text import changed, scene_of

GOOD = scene_of(
    """
[mesh]
type = "rectangle"
length = 0.1
height = 0.4
cells = [4, 16]
[two_fluid]
[gas]
density = 1.2
viscosity = 1.8e-5
[solids.beads]
diameter = 275e-6
density = 2500.0
packing_limit = 0.63
[initial]
solids.beads.volume_fraction = 0.5
[boundary.left]
type = "wall"
solids.beads.wall = "johnson_jackson"
solids.beads.specularity = 0.1
solids.beads.restitution = 0.9
[boundary.right]
type = "wall"
[boundary.bottom]
type = "inlet"
gas.velocity = 0.4
[boundary.top]
type = "outlet"
[time]
end = 0.1
"""
)


def scene(changes, without=()):
    return changed(GOOD, changes, without)


def test_the_good_scene_is_good():
    assert "cells" in str(plan(from_dict(GOOD)))


@each_case(__file__, "mistakes")
def test_a_mistake_is_named(changes, without, told):
    assert told in refusal(lambda: plan(from_dict(scene(changes, without))))


def test_all_mistakes_are_told_at_once():
    text = refusal(
        lambda: from_dict(
            scene(
                {
                    "closures.drag": "drag_wenyu",
                    "initial.solids.beads.volume_fraction": 0.64,
                    "boundary.lid": {"type": "wall"},
                }
            )
        )
    )
    assert all(part in text for part in ("drag_wen_yu", "densest packing", "lid"))


@pytest.mark.parametrize(
    ("corner", "told"),
    [((1.0, 1.0), "plain.msh: 4 of 4 exterior facets"), ((0.5, 0.0), "plain.msh")],
)
def test_a_mesh_file_without_names_or_volume(tmp_path, corner, told):
    points = np.array([[0.0, 0.0], [1.0, 0.0], corner, [0.0, 1.0]])
    meshio.write(
        tmp_path / "plain.msh",
        meshio.Mesh(points, [("triangle", [[0, 1, 2], [0, 2, 3]])]),
        "gmsh",
    )
    assert told in refusal(
        lambda: plan(
            from_dict(
                scene({"mesh": {"type": "file", "file": "plain.msh"}}), base=tmp_path
            )
        )
    )


def test_a_mesh_file_that_is_missing(tmp_path):
    refused(
        r"mesh\.file.*no such file",
        lambda: from_dict(
            scene({"mesh": {"type": "file", "file": "absent.msh"}}), base=tmp_path
        ),
    )


JET = {"type": "inlet", "gas": {"velocity": 1.0}}


@each_case(__file__, "cannot_be_meant")
def test_what_cannot_be_meant_is_an_error(changes, without, told):
    assert told in refusal(lambda: plan(from_dict(scene(changes, without))))


@each_case(__file__, "may_be_meant")
def test_what_may_be_meant_is_a_warning(changes, told):
    good = from_dict(GOOD)
    assert (*good.warnings, *plan(good).warnings) == ()
    loaded = from_dict(scene(changes), name="bed.toml")
    planned = plan(loaded)
    found = (*loaded.warnings, *planned.warnings)
    assert any(text.startswith("bed.toml:1: ") and told in text for text in found)
    assert told in str(planned)


def test_what_nothing_holds_falls_for_ever():
    """Bottom and top are one; a wall at a side, or no gravity, is no fall for ever."""
    endless = {
        "boundary.bottom": {"type": "periodic", "partner": "top"},
        "boundary.left": {"type": "symmetry"},
        "boundary.right": {"type": "symmetry"},
    }
    (found,) = from_dict(scene(endless, ("boundary.top",))).warnings
    assert "boundary.bottom: joins bottom and top" in found and "fall together" in found
    for change in (
        {"boundary.left": {"type": "wall"}},
        {"two_fluid.gravity": 0.0},
    ):
        found = from_dict(scene(endless | change, ("boundary.top",))).warnings
        assert not any("fall together" in text for text in found)


def test_rings_are_compared_by_their_area():
    """A piece from 0.026 to 0.048 m covers the faces from 0.025 to 0.05 m:
    (0.05^2 - 0.025^2)/(0.048^2 - 0.026^2).
    """
    ring = {"boundary.ring": JET | {"on": "bottom", "start": 0.026, "end": 0.048}}
    mesh = {"type": "axisymmetric", "radius": 0.1, "length": 0.4, "cells": [4, 16]}
    round_bed = {"mesh": mesh, "boundary.wall": {"type": "wall"}} | ring
    (text,) = plan(
        from_dict(scene(round_bed, ("boundary.left", "boundary.right")))
    ).warnings
    assert "reaches from 0.025 to 0.05 m on this mesh: 15 % more area" in text
    for changes in (
        {"boundary.jet": JET | {"on": "left", "start": 0.1, "end": 0.2}},
        {"initial.layer": [{"end": 0.1}]},
    ):
        assert plan(from_dict(scene(changes))).warnings == ()


@pytest.mark.parametrize(
    ("inner", "told"),
    [(0.1, "an annulus from r = 0.1 m"), (-0.1, "2 of 6 nodes have r < 0")],
)
def test_an_axisymmetric_mesh_without_its_axis(tmp_path, inner, told):
    x = [inner, 0.5, 1.0]
    points = np.array([[a, b] for b in (0.0, 1.0) for a in x])
    lines = scene_of("""
        bottom = [[0, 1], [1, 2]]
        top = [[3, 4], [4, 5]]
        inner = [[0, 3]]
        outer = [[2, 5]]
    """)
    data = {"gmsh:physical": [], "gmsh:geometrical": []}
    cells, tags = [], {}
    for tag, (name, pairs) in enumerate(lines.items(), 1):
        cells.append(("line", np.array(pairs)))
        tags[name] = np.array([tag, 1])
    cells.append(("quad", np.array([[0, 1, 4, 3], [1, 2, 5, 4]])))
    tags["bed"] = np.array([9, 2])
    for key in data:
        data[key] = [
            np.full(len(block), tag)
            for (_, block), tag in zip(cells, (1, 2, 3, 4, 9), strict=True)
        ]
    meshio.write(
        tmp_path / "ring.msh",
        meshio.Mesh(points, cells, cell_data=data, field_data=tags),
        "gmsh22",
    )
    mesh = {"type": "file", "file": "ring.msh", "axisymmetric": True}
    walls = {name: {"type": "wall"} for name in lines}
    changed_scene = scene({"mesh": mesh, "boundary": walls})
    if inner > 0:
        assert any(
            told in text
            for text in plan(from_dict(changed_scene, base=tmp_path)).warnings
        )
    else:
        refused(told, lambda: plan(from_dict(changed_scene, base=tmp_path)))
