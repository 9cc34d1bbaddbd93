"""Scenes of the studies of reacting beds against their references, to the digits
that these have.
"""

from __future__ import annotations

import pytest
from pytest import approx

import contbed as cb
from studies.clc_moving_bed import study as clc
from studies.dri_shaft import study as dri
from studies.reformer_tube import study as reformer
from tests.balances import assert_closed


@pytest.mark.parametrize("case", reformer.CASES)
def test_reformer(case):
    result = cb.run(cb.load(reformer.HERE / f"{case}.toml"))
    for key, value in reformer.reference(case).items():
        assert result.qoi[key] == approx(value, rel=1e-7), key
    assert_closed(result, 1e-12)


# by `reference()` of the study, which takes 8 s; its two integrators agree to 4e-10
SHOOTING = {
    "conversion_CH4": 0.99973434047,
    "conversion_Fe2O3": 0.899828537195,
    "pressure_drop_Pa": 64407.857008,
    "T_solid_out_K": 1143.231580198,
}


def test_moving_bed_of_iron_oxide():
    result = cb.run(cb.load(clc.HERE / "iron_oxide.toml"))
    for key, value in SHOOTING.items():
        assert result.qoi[key] == approx(value, rel=1e-8), key
    assert_closed(result, 1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {"boundary.left.gas.molar_flux": 5.2, "mesh.length": 3.0},
        {
            "boundary.left.gas.molar_flux": 4.6,
            "mesh.length": 2.0,
            "solids.carrier.diameter": 2e-3,
        },
    ],
)
def test_moving_bed_with_more_methane_than_oxide_burns(changes):
    scene = cb.load(clc.HERE / "iron_oxide.toml", changes)
    result, exact = cb.run(scene), clc.reference(scene)
    for key in SHOOTING:
        assert result.qoi[key] == approx(exact[key], rel=1e-7), key


@pytest.mark.slow
@pytest.mark.parametrize("case", dri.CASES)
def test_hydrogen_shaft(case):
    result = cb.run(
        cb.load(
            dri.HERE / "h2_5m.toml", {"boundary.left.gas.molar_flux": dri.CASES[case]}
        )
    )
    # of the span of each result; the upwind cells of the reference are less sure than
    # that where heat is short
    spans = {
        "metallization": 1.0,
        "reduction": 1.0,
        "T_solid_out_K": 1e3,
        "T_fluid_out_K": 1e3,
        "x_H2_out": 1.0,
    }
    for key, value in zip(spans, dri.reference(case)[: len(spans)], strict=True):
        assert result.qoi[key] == approx(value, abs=5e-4 * spans[key]), key
    assert_closed(result, 1e-12)
