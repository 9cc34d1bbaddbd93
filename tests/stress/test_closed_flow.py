"""Flow between walls that nothing enters: a fluid at rest, and one that a moving bed
stirs.
"""

from pathlib import Path

import pytest

import contbed as cb

CHANNEL = (
    Path(__file__).parents[2] / "studies" / "brinkman_forchheimer" / "slip_0.00.toml"
)
CLOSED = {"mesh.cells": [6, 8], "boundary.left.gas.velocity": 0.0}


@pytest.mark.filterwarnings("error")
def test_fluid_between_no_slip_walls_stays_at_rest():
    result = cb.run(cb.load(CHANNEL, CLOSED))
    assert result.status == "ok"
    assert result.qoi["u_max"] == result.qoi["pressure_drop_Pa"] == 0.0


@pytest.mark.filterwarnings("error")
def test_a_bed_that_moves_through_a_closed_vessel_builds_up_pressure():
    """Between walls the fluid cannot follow: its pressure rises by what drag gives,
    -eps mu/K eps u_solid/(1 - eps), with eps = 0.9.
    """
    result = cb.run(
        cb.load(
            CHANNEL,
            {
                **CLOSED,
                "boundary.left.solids.particles.velocity": 0.01,
                "closures.forchheimer": 0.0,
            },
        )
    )
    assert result.status == "ok"
    darcy = 1.731e-5 / 2.024706875e-5 * 0.01 * 0.9 / (1.0 - 0.9) * 4.0
    assert abs(result.qoi["pressure_drop_Pa"]) == pytest.approx(darcy, rel=0.02)
    assert result.qoi["u_max"] < 0.01
