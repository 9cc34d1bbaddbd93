"""A boundary whose surface radiates to surroundings: `emissivity` and `ambient` of a
phase.
"""

from __future__ import annotations

import pytest
from pytest import approx
from scipy.optimize import brentq

import contbed as cb
from contbed.closures.optics import SIGMA
from contbed.loading import from_dict
from tests.balances import assert_closed
from tests.cases import each_case
from tests.refusals import refused
from tests.scene_text import scene_of

LENGTH, K_SOLID, EPS, EMISSIVITY, HOT, COLD = 0.1, 2.0, 0.4, 0.7, 1200.0, 300.0
MESHES = {
    "line": ({"type": "line", "length": LENGTH}, ("left", "right"), 1.0),
    "plane": (
        {"type": "rectangle", "length": LENGTH, "height": 0.02, "cells": [8, 2]},
        ("left", "right"),
        0.02,
    ),
    "round": (
        {"type": "axisymmetric", "length": LENGTH, "radius": 0.1, "cells": [2, 8]},
        ("bottom", "top"),
        3.141592653589793 * 0.01,
    ),
    "box": (
        {
            "type": "box",
            "length": LENGTH,
            "width": 0.02,
            "height": 0.03,
            "cells": [6, 1, 1],
        },
        ("left", "right"),
        6e-4,
    ),
}


def scene(mesh, sides, emissivity=EMISSIVITY, **more):
    """A bed that conducts from a hot end to one that radiates; the phases do not
    exchange heat.
    """
    low, high = sides
    fluid = {"fixed_temperature": 500.0}
    return (
        scene_of(
            """
                closures = { nusselt = 0.0 }
                heat = {}

                [gas]
                density = 1.0
                heat_capacity = 1000.0
                conductivity = 0.05
                viscosity = 2e-5

                [solids.particles]
                density = 2000.0
                heat_capacity = 900.0
                diameter = 2e-3
            """,
            {
                "mesh": mesh,
                "solids.particles.conductivity": K_SOLID,
                "packed_bed.porosity": EPS,
                "boundary": {
                    low: {
                        "gas": fluid,
                        "solids": {"particles": {"fixed_temperature": HOT}},
                    },
                    high: {
                        "solids": {
                            "particles": {"emissivity": emissivity, "ambient": COLD}
                        }
                    },
                },
            },
        )
        | more
    )


@pytest.mark.parametrize("name", MESHES)
def test_conduction_to_a_radiating_end_is_exact(name):
    """k (T0 - T)/L = e sigma (T^4 - Ta^4) at the end, linear between: 1e-9 by
    Newton; the balance to 1e-10.
    """
    mesh, sides, section = MESHES[name]
    k = (1.0 - EPS) * K_SOLID
    end = brentq(
        lambda T: k * (HOT - T) / LENGTH - EMISSIVITY * SIGMA * (T**4 - COLD**4),
        COLD,
        HOT,
        xtol=1e-12,
    )
    result = cb.run(from_dict(scene(mesh, sides)))
    T = result.profiles["T_solid [K]"]
    assert T[-1] == approx(end, rel=1e-9)
    assert T[len(T) // 2] == approx(
        HOT + (end - HOT) * next(iter(result.profiles.values()))[len(T) // 2] / LENGTH,
        rel=1e-9,
    )
    assert result.qoi[f"heat_{sides[1]}_W"] == approx(
        -section * k * (HOT - end) / LENGTH, rel=1e-8
    )
    assert_closed(result, 1e-10, "energy")


def test_small_emissivity_is_adiabatic():
    mesh, sides, _ = MESHES["line"]
    result = cb.run(from_dict(scene(mesh, sides, emissivity=1e-9)))
    assert result.profiles["T_solid [K]"] == approx(HOT, rel=1e-6)


@each_case(__file__, "what_does_not_fit_is_refused")
def test_what_does_not_fit_is_refused(solid, wrong):
    mesh, sides, _ = MESHES["line"]
    values = scene(mesh, sides)
    values["boundary"]["right"]["solids"] = {"particles": solid}
    refused(wrong, from_dict, values)
