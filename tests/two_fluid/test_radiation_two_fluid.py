"""Radiation between the particles of two fluids: heat from wall to wall beside that of
exact radiative transport, whatever the cells.
"""

import pytest
from pytest import approx

import contbed as cb
from contbed.closures.optics import SIGMA
from contbed.loading import from_dict
from studies._exact.conduction_radiation import conduction_radiation
from tests.refusals import refused
from tests.scene_text import changed, scene_of

HOT, COLD, GRAY = 1400.0, 600.0, (0.9, 0.7)
EPS_S, EMISSIVITY, DIAMETER, K = 0.58, 0.8, 5e-4, 0.2


def scene(depth, steps=300, **changes):
    """Particles at rest between a hot and a cold wall, until the heat is steady; they
    hold little of it, so that it soon is.
    """
    made = scene_of(
        """
        model = "two_fluid"
        [mesh]
        type = "line"
        [two_fluid]
        gravity = 0.0
        granular_temperature = "frozen"
        [gas]
        density = 0.3
        viscosity = 1.8e-5
        heat_capacity = 1005.0
        conductivity = 0.026
        [solids.beads]
        heat_capacity = 1.0
        density = 2600.0
        [radiation]
        [heat]
        [initial]
        gas.temperature = 1000.0
        [boundary.left]
        type = "wall"
        [boundary.right]
        type = "wall"
        [output]
        plots = false
        fields = false
        """,
        {
            "mesh.length": depth,
            "two_fluid.conductivity_gas": 0.5 * K / (1.0 - EPS_S),
            "two_fluid.conductivity_solids": 0.5 * K / EPS_S,
            "solids.beads.diameter": DIAMETER,
            "solids.beads.emissivity": EMISSIVITY,
            "initial.solids.beads.volume_fraction": EPS_S,
        },
    )
    end = 20e3 * depth**2
    made["time"] = {
        "end": end,
        "step": end / steps,
        "longest": end,
        "average_from": 0.9 * end,
    }
    for name, T, emissivity in zip(("left", "right"), (HOT, COLD), GRAY, strict=True):
        made["boundary"][name] |= {"temperature": T, "emissivity": emissivity}
    return changed(made, {key.replace("__", "."): v for key, v in changes.items()})


def extinction(eps_s):
    return 1.5 * eps_s / (DIAMETER * (1.0 - eps_s))  # 1/m


def exact(depth, eps_s=EPS_S):
    """Heat [W/m2] from wall to wall by conduction and exact radiative transport."""
    beta = extinction(eps_s)
    N = K * beta / (4.0 * SIGMA * HOT**3)
    found = conduction_radiation(beta * depth, N, COLD / HOT, 1.0 - EMISSIVITY, GRAY)
    return found.total * SIGMA * HOT**4


@pytest.mark.parametrize(
    ("diameters", "cells"), [(10, 2), (10, 4), (10, 10), (80, 2), (80, 10), (80, 80)]
)
def test_heat_from_wall_to_wall(diameters, cells):
    """Beds of 10 and 80 diameters, of which radiation carries most of the heat: that of
    transport theory within 2 %, as the conductivity of a cell is that of its mean
    temperature, and half a diameter of the bed takes the radiation of its wall.
    """
    depth = diameters * DIAMETER
    found = cb.run(from_dict(scene(depth, mesh__cells=cells))).qoi
    assert found["heat_left_W"] == approx(exact(depth), rel=0.02)
    # what is stored changes by less from step to step
    assert found["heat_right_W"] == approx(-found["heat_left_W"], rel=1e-4)
    conducted = K * (HOT - COLD) / depth
    assert conducted < 0.75 * found["heat_left_W"]


@pytest.mark.parametrize(
    ("eps_s", "off"), [(0.3, 0.01), (0.1, 0.05), (0.03, 0.25)], ids=["26", "7", "2"]
)
def test_thin_suspensions_are_warned_of(eps_s, off):
    """Between walls so many mean free paths apart radiation is less and less a
    conduction, and a run says so below 10.
    """
    made = scene(0.02, mesh__cells=8)
    made["initial"]["solids"]["beads"]["volume_fraction"] = eps_s
    made["two_fluid"]["conductivity_gas"] = 0.5 * K / (1.0 - eps_s)
    made["two_fluid"]["conductivity_solids"] = 0.5 * K / eps_s
    found = cb.run(from_dict(made))
    assert found.qoi["heat_left_W"] == approx(exact(0.02, eps_s), rel=off)
    warned = any("mean free paths" in text for text in found.warnings)
    assert warned == (extinction(eps_s) * 0.02 < 10.0)


@pytest.mark.parametrize(("shape", "cells"), [("quadrilateral", 4), ("triangle", 8)])
def test_each_axis_radiates_alike(shape, cells):
    """Turned by a right angle the bed takes the same heat, to the rounding of the
    iteration; on triangles, which are then others, to 1 %.
    """
    found = []
    for size, of_sides, sides in (
        ((0.04, 0.01), [cells, cells // 2], ("left", "right", "bottom", "top")),
        ((0.01, 0.04), [cells // 2, cells], ("bottom", "top", "left", "right")),
    ):
        made = scene(0.04, steps=50)
        made["mesh"] = {
            "type": "rectangle",
            "length": size[0],
            "height": size[1],
            "cells": of_sides,
            "shape": shape,
        }
        hot, cold = made["boundary"]["left"], made["boundary"]["right"]
        still = {"type": "wall"}
        made["boundary"] = dict(zip(sides, (hot, cold, still, still), strict=True))
        found.append(cb.run(from_dict(made)).qoi[f"heat_{sides[0]}_W"])
    assert found[0] == approx(found[1], rel=1e-8 if shape == "quadrilateral" else 0.01)
    assert found[0] == approx(0.01 * exact(0.04), rel=0.03)


def test_nearly_empty_space_does_not_stop_a_run():
    """A bed below nearly empty space: the mean free path there, hundreds of metres, is
    taken as that at a hundredth of particles. The bed ends as hot as its wall.
    """
    made = scene(0.04, mesh__cells=20, initial__solids__beads__volume_fraction=1e-6)
    made["initial"]["layer"] = [
        {"start": 0.0, "end": 0.02, "solids": {"beads": {"volume_fraction": EPS_S}}}
    ]
    made["boundary"]["right"] = {"type": "wall"}
    found = cb.run(from_dict(made))
    assert found.qoi["T_solid_max [K]"] == approx(HOT, rel=0.01)
    assert abs(found.qoi["heat_left_W"]) < 1e-3 * exact(0.04)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radiation__levels": "p1"}, "radiation.levels = .*allowed: correction"),
        ({"solids__beads__emissivity": None}, "radiation. needs it"),
        ({"heat": None}, "radiation: has no meaning without .heat"),
        (
            {"two_fluid__conductivity_gas": 0.0, "two_fluid__conductivity_solids": 0.0},
            "radiation: needs closures.conductivity_bed",
        ),
        (
            {
                "closures__conductivity_bed": {
                    "name": "zehner_bauer_schluender",
                    "emissivity": 0.8,
                }
            },
            "closures.conductivity_bed: contains the radiation",
        ),
        (
            {"closures__conductivity_bed": "nonsense"},
            "closures.conductivity_bed.*unknown",
        ),
        ({"radiation__anisotropy": 2.0}, "radiation.anisotropy = 2.0: out of range"),
    ],
)
def test_radiation_that_cannot_be(changes, message):
    """Mistakes are named with their key."""
    refused(message, from_dict, scene(0.04, **changes))
