"""Branches of steady states: folds of a stirred bed, which a quadratic gives, and a
bed with everything in it.
"""

import numpy as np
import pytest
from bubbling_scenes import case1, one, solids, values
from pytest import approx
from scipy.optimize import brentq

import contbed as cb
from contbed.many.derivatives.gradients import gradient
from contbed.many.derivatives.keys import key
from contbed.scene.values import with_value
from tests.refusals import refused

# activation and heat release at infinite temperature over the capacity flow [K]
E, RISE = 3000.0, 5.0 * 3000.0 / 2.5


def stirred(guess, start, to, mixing=1e7):
    """One temperature: W (T - T_in) = W RISE exp(-E/T)."""
    flow, height, section = 300.0, 0.6, 1.3
    release = {
        "rate": RISE * np.exp(-E / 1000.0) * flow / height / section,
        "activation": E,
        "reference": 1000.0,
    }
    inert = {"gas_coefficient": 1e5, "mixing_conductivity": mixing, "release": release}
    return one(
        inert=inert,
        inlet={"capacity_flow": flow, "temperature": start},
        initial={"temperature": guess},
        continuation={"parameter": "boundary.bottom.gas.temperature", "to": to},
        mesh={"cells": 6},
    )


def test_folds_of_a_stirred_bed():
    result = cb.run(stirred(400.0, 600.0, 760.0))
    # dT_in/dT = 0 where (E/T^2) RISE exp(-E/T) = 1, on both sides of its largest value
    # at E/2
    turns = [
        brentq(lambda T: E / T**2 * RISE * np.exp(-E / T) - 1, *ends)
        for ends in ((600, E / 2), (E / 2, 4000))
    ]
    exact = [T - RISE * np.exp(-E / T) for T in turns]
    assert exact[0] > exact[1]
    found = [result.qoi["fold_1"], result.qoi["fold_2"]]
    # mixing of 1e7 W/m/K leaves differences of W RISE exp(-E/T) H/(A k), 3e-3 to 2e-2
    # K, along the height
    assert found == approx(exact, abs=1e-2)
    table = result.tables["continuation"]
    p, T = table["boundary.bottom.gas.temperature [K]"], table["T_inert [K]"]
    assert p[0] == 600 and p[-1] == 760
    assert T - RISE * np.exp(-E / T) == approx(p, abs=2e-2)
    assert set(table["turns [1]"]) == {0.0, 1.0, 2.0}


def test_back_from_the_ignited_side():
    result = cb.run(stirred(2500.0, 760.0, 600.0))
    assert [result.qoi["fold_1"], result.qoi["fold_2"]] == approx([661.4, 708.4], abs=1)


@pytest.mark.slow
def test_a_bed_with_radiation_ignites_at_a_fold():
    """Cold and hot guesses lead to two states; between them the branch over the heat
    of the gas finds a third.
    """
    release = {**values()["solids"]["char"]["release"], "activation": 8000.0}
    found = []
    for cells in (16, 24):
        result = cb.run(
            case1(
                solids=solids(char={"release": release}),
                release={"rate": 1.0e6, "length": 0.3},
                initial={"temperature": 400.0},
                mesh={"cells": cells},
                continuation={"parameter": "bubbling_bed.release.rate", "to": 3e6},
            )
        )
        found.append(result.qoi["fold_1"])
        table = result.tables["continuation"]
        p, T = table["bubbling_bed.release.rate [W/m**3]"], table["T_inert [K]"]
        assert p[-1] == p[0] == 1e6 and list(table["turns [1]"][[0, -1]]) == [0.0, 1.0]
        assert T[0] == approx(result.qoi["T_inert_mid_K"], abs=20)
        # below the state that a hot guess leads to, 1234.9 K
        assert T[0] + 300 < T[-1] < 1230
    assert found[0] == approx(found[1], rel=1e-4)  # of the meshes


@pytest.mark.parametrize(
    "parameter", ["bubbling_bed.sction", "bubbling_bed.height", "solids.inert", "title"]
)
def test_what_cannot_be_varied_is_refused(parameter):
    refused("can be varied", case1, continuation={"parameter": parameter, "to": 3.0})


def test_distance_to_the_first_fold():
    """The ignited bed goes out where the gas is colder by 1 - 661.4/760."""
    scene = stirred(2500.0, 760.0, 600.0)
    whole = cb.run(scene)
    table = {
        "parameter": "boundary.bottom.gas.temperature",
        "to": 600.0,
        "first_fold": True,
    }
    first = cb.run(
        with_value(
            scene, ("continuation",), scene.continuation.model_copy(update=table)
        )
    )
    assert first.qoi["fold_1"] == whole.qoi["fold_1"] and "fold_2" not in first.qoi
    assert first.qoi["fold_distance"] == approx(
        1.0 - first.qoi["fold_1"] / 760.0, rel=1e-12
    )
    assert len(first.tables["continuation"]["turns [1]"]) < len(
        whole.tables["continuation"]["turns [1]"]
    )
    assert first.warnings == []


def test_distance_without_a_fold_is_that_to_the_end_of_the_branch():
    result = cb.run(stirred(2500.0, 760.0, 700.0))
    assert "fold_1" not in result.qoi and result.qoi["fold_distance"] == approx(
        1.0 - 700.0 / 760.0
    )


def test_a_branch_that_is_given_up_has_no_distance():
    scene = stirred(2500.0, 760.0, 600.0)
    short = with_value(
        scene, ("continuation",), scene.continuation.model_copy(update={"points": 3})
    )
    result = cb.run(short)
    assert "fold_distance" not in result.qoi and any(
        "raise continuation.points" in text for text in result.warnings
    )


def test_how_folds_move_with_a_key():
    """d(p_1/p - 1)/dq by the null vector of the fold against differences of whole
    branches.
    """
    # little: rounding of a strong one hides small changes
    scene = stirred(2500.0, 760.0, 600.0, mixing=1e4)
    names = ["solids.inert.release.rate", "boundary.bottom.gas.temperature"]
    made = gradient(
        scene, ["fold_1", "fold_2", "fold_distance", "T_inert_mid_K"], names
    )
    assert made.method == "tangent" and made.notes == ()
    for k, changed in enumerate(key(scene, name) for name in names):
        ends = [
            cb.run(changed.on(scene, changed.value * (1.0 + side * 1e-4))).qoi
            for side in (1, -1)
        ]
        for q, name in enumerate(made.qoi):
            found = (ends[0][name] - ends[1][name]) / 2e-4
            # of central differences with folds to 1e-9 of the span: 1e-6 K over 2e-4
            assert made.derivatives[q, k] * changed.value == approx(
                found, rel=1e-5, abs=1e-5 * made.values[q]
            ), name
    # a fold in the gas temperature does not know that of the scene
    assert made.derivatives[0, 1] == 0.0
