"""Two-fluid scenes with mistakes: each is named with its key before anything is
built.
"""

import meshio
import numpy as np
import pytest
from changed_scenes import changed

from contbed.loading import from_dict
from contbed.models import plan
from tests.refusals import refusal, refused
from tests.scene_text import scene_of

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

RUBBING = "effective_restitution_chialvo_sundaresan"
RUBS = {"closures.effective_restitution": RUBBING, "solids.beads.sliding_friction": 0.1}


def scene(changes, without=()):
    return changed(GOOD, changes, without)


def test_the_good_scene_is_good():
    assert "cells" in str(plan(from_dict(GOOD)))


@pytest.mark.parametrize(
    ("changes", "without", "told"),
    [
        ({"closures.drag": "drag_wenyu"}, (), "drag_wen_yu"),
        (
            {"closures.granular_viscosity": "granular_viscosity_gidaspov"},
            (),
            "granular_viscosity_gidaspow",
        ),
        ({"closures.drag": "g0_lun_savage"}, (), "wanted kind 'drag'"),
        (
            {"closures.drag": {"name": "drag_syamlal_obrien", "cc": 0.8}},
            (),
            "no parameter 'cc'",
        ),
        ({"closures.radial_distribution": "none"}, (), "closures.radial_distribution"),
        ({"two_fluid.granular_temperature": "pdf"}, (), "granular_temperature"),
        ({"two_fluid.gravity": -9.81}, (), "gravity"),
        (
            {"initial.solids.beads.volume_fraction": 0.64},
            (),
            "denser than the densest packing",
        ),
        (
            {"initial.solids.beads.volume_fraction": 0.6, "initial.noise": 0.1},
            (),
            "with its noise",
        ),
        (
            {
                "initial.layer": [
                    {
                        "start": 0.1,
                        "end": 0.2,
                        "solids": {"beads": {"volume_fraction": 0.7}},
                    }
                ]
            },
            (),
            "initial.layer",
        ),
        ({"initial.layer": [{"start": 0.3, "end": 0.2}]}, (), "is not above start"),
        (
            {"initial.solids.beads.granular_temperature": -1.0},
            (),
            "initial.solids.beads.granular_temperature",
        ),
        (
            {
                "boundary.bottom.solids.beads.volume_fraction": 0.64,
                "boundary.bottom.solids.beads.mass_flux": 10.0,
            },
            (),
            "denser than the densest packing",
        ),
        (
            {"boundary.bottom.solids.beads.volume_fraction": 0.2},
            (),
            "need volume_fraction and either",
        ),
        (
            {"boundary.bottom.solids.beads.mass_flux": 10.0},
            (),
            "need volume_fraction and either",
        ),
        (
            {
                "boundary.bottom.solids.beads.volume_fraction": 0.2,
                "boundary.bottom.solids.beads.mass_flux": 9.0,
                "boundary.bottom.solids.beads.velocity": 0.1,
            },
            (),
            "give either mass_flux or velocity",
        ),
        ({"boundary.bottom.gas.velocity": -0.4}, (), "boundary.bottom"),
        ({}, ("boundary.left.solids.beads.specularity",), "specularity"),
        (
            {"boundary.right.solids.beads.specularity": 0.1},
            (),
            "belongs to wall = 'johnson_jackson'",
        ),
        ({"boundary.left.solids.beads.specularity": 1.5}, (), "specularity"),
        ({"boundary.left.solids.beads.wall": "partial"}, (), "johnson_jackson"),
        ({"boundary.top": {"type": "wall"}}, (), "nothing leaves"),
        ({}, ("boundary.right",), "boundary.right"),
        ({"boundary.lid": {"type": "wall"}}, (), "no boundary 'lid'"),
        ({"boundary.top.type": "outflow"}, (), "outlet"),
        (
            {"boundary.left": {"type": "periodic", "partner": "rihgt"}},
            (),
            "no such boundary",
        ),
        (
            {"boundary.left": {"type": "periodic", "partner": "right"}},
            (),
            "cannot be given twice",
        ),
        (
            {"boundary.feed": {"type": "wall", "on": "left", "start": 0.2, "end": 0.1}},
            (),
            "start below end",
        ),
        (
            {
                "boundary.feed": {
                    "type": "wall",
                    "on": "left",
                    "start": 0.101,
                    "end": 0.102,
                }
            },
            (),
            "refine the mesh",
        ),
        ({"solids.beads.restitution": -0.1}, (), "solids.beads.restitution"),
        ({"solids.beads.restitution": 1.1}, (), "solids.beads.restitution"),
        ({"solids.beads.diameter": 0.0}, (), "solids.beads.diameter"),
        ({"solids.beads.packing_limit": 0.8}, (), "solids.beads.packing_limit"),
        (
            {"solids.beads.sliding_friction": 0.1},
            (),
            "does nothing without closures.effective_restitution",
        ),
        (
            {"closures.effective_restitution": RUBBING},
            (),
            "needs solids.beads.sliding_friction",
        ),
        (
            {
                "closures.effective_restitution": "chialvo",
                "solids.beads.sliding_friction": 0.1,
            },
            (),
            "chialvo_sundaresan",
        ),
        (
            {**RUBS, "solids.beads.restitution": 0.1},
            (),
            "gives -0.01112, no restitution between 0 and 1",
        ),
        (
            {**RUBS, "closures.granular_dissipation": "none"},
            (),
            "is part of the dissipation of granular energy",
        ),
        (
            {"solids.beads.friction": {"start": 0.64}},
            (),
            "is not below the densest packing",
        ),
        ({}, ("mesh.cells",), "mesh.cells"),
        ({"mesh.cells": [0, 4]}, (), "mesh.cells"),
        ({"time.courant": 1.5}, (), "time.courant"),
        ({"time.average_from": 0.2}, (), "is not before the end"),
        ({"time.first": 1.0}, (), "longer than the longest step"),
        ({}, ("solids.beads.density",), "solids.beads.density"),
        ({"gas.presure": 1e5}, (), "pressure"),
    ],
)
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


BOX = {
    "mesh": {
        "type": "box",
        "length": 0.1,
        "width": 0.1,
        "height": 0.4,
        "cells": [2, 2, 16],
    },
    **{
        f"boundary.{name}": {"type": "wall"}
        for name in ("left", "right", "front", "back")
    },
}
JET = {"type": "inlet", "gas": {"velocity": 1.0}}
FEED = {
    "type": "inlet",
    "on": "left",
    "start": 0.1,
    "end": 0.2,
    "solids": {"beads": {"volume_fraction": 0.2, "mass_flux": 9.0}},
}
HEAT = {
    "heat": {},
    "gas.heat_capacity": 1000.0,
    "gas.conductivity": 0.025,
    "solids.beads.heat_capacity": 800.0,
}
HOT = {"initial.gas.temperature": 300.0, "boundary.bottom.gas.temperature": 300.0}
POWER = {"name": "power", "a": 1.2}


@pytest.mark.parametrize(
    ("changes", "without", "told"),
    [
        (
            {"initial.layer": [{"start": 0.5, "end": 0.6}]},
            (),
            "the vessel ends at 0.4 m",
        ),
        (
            {"initial.layer": [{"end": -0.1}]},
            (),
            "ends below 0 m, where the vessel begins",
        ),
        (
            {
                "initial.layer": [
                    {"end": 0.2, "solids": {"beads": {"volume_fraction": 0.5}}},
                    {"start": 0.1, "solids": {"beads": {"volume_fraction": 0.1}}},
                ]
            },
            (),
            "overlaps layer 1",
        ),
        (
            {"initial.layer": [{"start": 0.101, "end": 0.102}]},
            (),
            "holds no cell of the mesh",
        ),
        (
            {"boundary.a": FEED, "boundary.b": FEED | {"start": 0.15, "end": 0.3}},
            (),
            "overlaps boundary.a",
        ),
        ({"time.step": 0.2}, (), "is longer than the run"),
        (
            {"solids.beads.diameter": 0.1},
            (),
            "is not smaller than the width of the vessel",
        ),
        ({}, ("boundary.bottom.gas.velocity",), "nothing enters"),
        (
            {**HEAT, **HOT, "gas.density_law": "ideal_gas", "gas.pressure": 500.0},
            (),
            "absolute; below 1000 Pa",
        ),
        (
            {**HEAT, **HOT, "initial.gas.temperature": 1e6},
            (),
            "initial.gas.temperature = 1000000.0: above 6000 K",
        ),
        (
            {**HEAT, **HOT, "closures.nusselt": POWER},
            (),
            "closures.nusselt: closure 'power' needs b",
        ),
        (
            {**HEAT, **HOT, "closures.nusselt": POWER | {"b": 0.5, "c": 1.0}},
            (),
            "has no parameter 'c'",
        ),
        ({"mesh.cells": [1, 1]}, (), "one cell has no neighbour"),
        ({"output.window": {"start": 0.2, "end": 0.1}}, (), "is not above start"),
        (
            {"output.window": {"start": 0.5, "end": 0.6}},
            (),
            "outside of the vessel, which reaches from 0 to 0.4 m",
        ),
        (
            {"output.window": {"start": 0.101, "end": 0.102}},
            (),
            "output.window: holds no cell of the mesh",
        ),
    ],
)
def test_what_cannot_be_meant_is_an_error(changes, without, told):
    assert told in refusal(lambda: plan(from_dict(scene(changes, without))))


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"time.sample": 0.2}, "time.sample = 0.2: longer than the run of 0.1 s"),
        ({"time.fields": 0.2}, "time.fields = 0.2: longer than the run of 0.1 s"),
        ({"boundary.jet": JET | {"on": "bottom", "start": 0.0, "end": 0.05, "until": 0.2}},
         "boundary.jet.until = 0.2: is not before the end"),
        ({"boundary.jet": JET | {"on": "bottom", "start": 0.034, "end": 0.067}},
         "boundary.jet: reaches from 0.025 to 0.075 m on this mesh: 52 % more area, "
         "and of what crosses it"),
        ({"boundary.jet": JET | {"on": "left", "start": 0.15, "end": 0.21}},
         "boundary.jet: reaches from 0.15 to 0.2 m on this mesh: 17 % less area, and "
         "of what crosses it"),
        ({"initial.layer": [{"end": 0.11, "solids": {"beads": {"volume_fraction": 0.55}}}]},
         "initial.layer[0]: reaches from 0 to 0.1 m on this mesh: 9.1 % less of the "
         "particles"),
        ({"initial.layer": [{"end": 0.115, "solids": {"beads": {"volume_fraction": 0.55}}}], **BOX},
         "initial.layer[0]: reaches from 0 to 0.125 m on this mesh: 8.7 % more of the "
         "particles"),
        ({"solids.beads.diameter": 0.03}, "larger than the smallest cell, 0.025 m"),
        ({"initial.solids.beads.volume_fraction": 0.0}, "a flow of gas alone"),
        ({"boundary.bottom.gas.velocity": 0.0}, "boundary.bottom.gas.velocity = 0.0: "
                                                "nothing enters"),
        ({"gas.density": 3000.0}, "the gas is not lighter than the particles"),
        ({"closures.drag": "none"}, "does not carry the particles"),
        ({"initial.layer": [{"start": 0.3, "end": 0.5, "solids": {"beads": {"volume_fraction": 0.1}}}]},
         "initial.layer[0].end: 0.5 m is outside"),
    ],
)  # fmt: skip
def test_what_may_be_meant_is_a_warning(changes, told):
    good = from_dict(GOOD)
    assert (*good.warnings, *plan(good).warnings) == ()
    loaded = from_dict(scene(changes), name="bed.toml")
    planned = plan(loaded)
    found = (*loaded.warnings, *planned.warnings)
    assert any(text.startswith("bed.toml:1: ") and told in text for text in found)
    assert told in str(planned)


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
    lines = {
        "bottom": [[0, 1], [1, 2]],
        "top": [[3, 4], [4, 5]],
        "inner": [[0, 3]],
        "outer": [[2, 5]],
    }
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
