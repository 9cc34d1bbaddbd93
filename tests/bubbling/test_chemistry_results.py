"""What a reacting bed reports: char that does not fit, laws out of their range,
amounts that are rounding.
"""

import numpy as np
import pytest
from reacting_scenes import combustor, tube

import contbed as cb
from contbed.bubbling_bed.chemistry.results import (
    _below_zero,
    _beside_declared,
    _fits,
    without_rounding,
)
from contbed.errors import ConvergenceError
from contbed.fields import unit_of
from contbed.result import Result


def test_char_beyond_the_volume_of_the_solids_is_no_result():
    result = Result(cb.plan(combustor()))
    _fits(combustor(), 0.9, result)
    with pytest.raises(
        ConvergenceError, match=r"scene:1: solids.char.fuel: .* 171 %.*drain\.time"
    ) as error:
        _fits(combustor(), 1.71, result)
    assert error.value.exit_code == 3


def test_another_share_of_char_than_declared_is_a_warning():
    scene = combustor()
    declared = scene.solids["char"].volume_share
    assert _beside_declared(scene, declared + 0.09) == []
    (text,) = _beside_declared(scene, 0.572)
    assert text.startswith("char fills 57.2 % of the volume of the solids")
    assert "give solids.char.volume_share between both with the shares" in text


@pytest.mark.parametrize(
    ("mesh", "advice"),
    [
        ({"cells": 6}, "give more mesh.cells, or none for a mesh that is chosen"),
        ({}, "give mesh.cells, more than the"),
    ],
)
def test_advice_about_a_fraction_below_zero_names_the_mesh_of_the_scene(mesh, advice):
    plan = cb.plan(combustor(mesh=mesh))
    # none above the bed
    x, z = np.array([0.0, -1e-3, np.nan]), np.array([0.0, 0.3, 1.0])
    profiles = {"x_H2_bubble [1]": x, "z [m]": z}
    text = _below_zero(["H2"], ["bubble"], profiles, plan)
    assert advice in text
    assert "-0.001 at z = 0.3 m" in text


def test_a_law_out_of_its_range_is_a_warning_and_fractions_have_no_unit():
    found = cb.run(tube("CH4:0.01, O2:0.2, N2:0.79", {"CH4_oxidation": {}}, walls=None, initial={"temperature": 900.0},
                        solver={}, gas={"composition": "CH4:0.001, O2:0.2, N2:0.799"},
                        inlet={"mass_flow": 0.02, "temperature": 900.0},
                        tubes={"perimeter": 1.0, "coefficient": 1e6, "temperature": 900.0}))  # fmt: skip
    assert any(
        text.startswith(
            "reactions.CH4_oxidation: dryer_glassman is used out of its range on 100 % "
            "of the height, 900"
        )
        for text in found.warnings
    )
    names = [name for name in found.qoi if name.endswith(("_wet", "_dry"))]
    assert len(names) > 6 and {unit_of(name) for name in names} == {"1"}
    assert all(
        value == 0 or abs(value) > 1e-15
        for name, value in found.qoi.items()
        if name in names
    )


def test_rounding_is_zero_and_undershoots_stay():
    amounts = np.array([-1e-40, 3e-16, -1e-5, 0.2])
    assert without_rounding(amounts, 1.0).tolist() == [0.0, 0.0, -1e-5, 0.2]


def test_a_fraction_below_zero_is_told_with_its_place():
    """On few cells of degree 2 gas in bubbles undershoots above the distributor; a
    mesh that is chosen holds 1e-6.
    """
    coarse, chosen = (
        cb.run(
            combustor(
                mesh=mesh, solver={"degree": degree}, initial={"temperature": 1150.0}
            )
        )
        for mesh, degree in (({"cells": 6}, 2), ({}, 3))
    )
    (text,) = (text for text in coarse.warnings if "below zero" in text)
    least = coarse.profiles["x_CO2_bubble [1]"].min()
    z = coarse.profiles["z [m]"][coarse.profiles["x_CO2_bubble [1]"].argmin()]
    assert text.startswith(
        f"CO2 in the bubble falls to a mole fraction of {least:.2g} at z = {z:.3g} m, "
        "further below"
    )
    assert least < -1e-4 and z < 1e-3
    assert not any("below zero" in text for text in chosen.warnings)
    assert (
        min(x.min() for name, x in chosen.profiles.items() if name.startswith("x_"))
        > -1e-6
    )
