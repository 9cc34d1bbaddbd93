"""What a bed does as a whole and no closure states, on the scenes of
studies/emergent_checks.
"""

import numpy as np
import pytest

import contbed as cb
from studies.emergent_checks import study


def front_velocity(fraction):
    scene = cb.load(
        study.HERE / "settling.toml",
        {"initial.solids.beads.volume_fraction": fraction, "time.end": 3.0},
    )
    return (scene.mesh.length - cb.run(scene).qoi["front_position_m"]) / scene.time.end


def test_hindered_settling_has_the_exponent_of_richardson_and_zaki():
    dilute, dense = front_velocity(0.01), front_velocity(0.2)
    exponent = np.log(dense / dilute) / np.log(0.8 / 0.99)
    Re = 998.0 * dilute / 0.99**4.4 * 1e-4 / 1e-3
    # the correlation is given to two decimals; the front is between two of 200 cells
    assert exponent == pytest.approx(study.richardson_zaki(Re), rel=0.02)


@pytest.mark.parametrize("friction", [0.15, 0.3])
def test_walls_drawn_up_carry_what_janssen_says_of_an_isotropic_pressure(friction):
    depth = 0.15
    sides = {
        f"boundary.{side}.solids.beads.friction": friction for side in ("left", "right")
    }
    found = cb.run(cb.load(study.HERE / "janssen.toml", sides)).qoi["weight_walls"]
    share = study.wall_share(depth, 1.0, friction)
    # 9 % below at 0.3: the bed creeps, and its pressure is not the same across the slot
    assert found == pytest.approx(share, rel=0.12)


@pytest.mark.slow
def test_gas_of_a_bed_that_rubs_late_carries_it_near_wen_and_yu():
    def share(velocity, start):
        changes = {
            "solids.beads.friction.start": start,
            "boundary.left.gas.velocity": velocity,
            "initial.gas.velocity": velocity,
        }
        return study.carried_share(cb.load(study.HERE / "minimum.toml", changes))

    # 1.06 m/s by Wen and Yu: a bed that rubs from 0.5 on loosens and carries itself
    # until 1.34 m/s
    assert share(1.2, 0.57) > 0.95 > share(1.2, 0.5)
