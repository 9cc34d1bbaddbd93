"""Turbulent gas in developed flow: friction and profile of smooth pipes, limits of
the eddy viscosity, a riser.
"""

import numpy as np
import pytest
from pytest import approx

import contbed as cb
from contbed.closures.turbulence import eddy_viscosity_nikuradse
from contbed.developed_flow.equations import prandtl_friction
from contbed.loading import from_dict
from tests.balances import assert_closed
from tests.refusals import refused
from tests.scene_text import scene_of

R, NU = 0.05, 1.8e-5 / 1.2


def pipe(Re, flux=0.0, turbulence="eddy_viscosity_nikuradse"):
    flow = {
        "section": "pipe",
        "radius": R,
        "gas_velocity": Re * NU / (2 * R),
        "solids_mass_flux": flux,
    }
    return from_dict(
        scene_of(
            """
            [gas]
            density = 1.2
            viscosity = 1.8e-5

            [solids.beads]
            diameter = 200e-6
            density = 2500.0

            [boundary.wall]
            type = "wall"
            solids.beads = { specularity = 0.1 }

            [output]
            plots = false
            fields = false
        """,
            {"developed_flow": flow, "closures.turbulence": turbulence},
        )
    )


@pytest.mark.parametrize("Re", [1e4, 1e5, 1e6])
def test_friction_and_profile_of_smooth_pipes(Re):
    """Prandtl's friction within 3.5 % and u+ = ln(y+)/0.41 + 5.0 within 1.0 at y+ 30 to
    100.

    The mixing length gives 3.0, -1.2 and -1.9 % of friction, 0.9, 0.5 and 0.5 of u+: a
    law fitted to pipes.
    """
    scene = pipe(Re)
    result = cb.run(scene)
    U = scene.developed_flow.gas_velocity
    f = (result.qoi["pressure_gradient_Pa_m"] - 1.2 * 9.81) * 2 * R / (0.5 * 1.2 * U**2)
    assert f == approx(prandtl_friction(Re), rel=0.035)
    u_friction = U * (f / 8) ** 0.5
    y = (R - result.profiles["r [m]"]) * u_friction / NU
    within = (y > 30) & (y < 100)
    u = result.profiles["u_gas [m/s]"][within] / u_friction
    assert within.sum() >= 5
    assert np.abs(u - np.log(y[within]) / 0.41 - 5.0).max() < 1.0
    assert_closed(result, 1e-10, "momentum")
    assert not any("turbulent" in text for text in result.warnings)


@pytest.mark.parametrize(("Re", "f"), [(1e4, 0.03089), (1e5, 0.01799), (1e6, 0.01165)])
def test_friction_of_smooth_pipes(Re, f):
    """Values of Prandtl's law to four digits."""
    assert prandtl_friction(Re) == approx(f, abs=5e-6)


def test_limits_of_the_eddy_viscosity():
    flow = {"radius": R, "u_friction": 1.0, "nu": NU}
    centre = eddy_viscosity_nikuradse(y=R, shear_rate=100.0, drag_rate=0.0, **flow)
    assert centre == approx((0.14 * R) ** 2 * 100.0, rel=1e-12)
    assert eddy_viscosity_nikuradse(y=0.0, shear_rate=1e4, drag_rate=0.0, **flow) == 0.0
    # 0.4 y in the layer that the wall does not damp
    y = np.array([1e-3])
    fast = flow | {"u_friction": 10.0}
    assert eddy_viscosity_nikuradse(
        y=y, shear_rate=1.0, drag_rate=0.0, **fast
    ) == approx((0.4 * y) ** 2, rel=0.1)
    # shear that drag of particles outweighs: (l du/dr)^2 over 2 drag_rate/0.3
    damped = eddy_viscosity_nikuradse(y=R, shear_rate=1.0, drag_rate=1e6, **flow)
    assert damped == approx((0.14 * R) ** 2 * 0.3 / 2e6, rel=1e-6)


def test_laminar_gas_takes_no_eddy_viscosity():
    refused(r"turbulence.*the gas alone is laminar, Re = 2e\+03", pipe, 2000.0)


def test_turbulence_makes_the_gas_of_a_riser_flatter():
    """200 um, Re 6e4, 100 kg/m2/s: without it gas flows at 19.5 m/s half way to the
    wall, at 4.4 m/s at the centre.
    """
    result = cb.run(pipe(6e4, 100.0))
    laminar = cb.run(pipe(6e4, 100.0, turbulence=None))
    assert (
        result.profiles["u_gas [m/s]"].max()
        < 0.7 * laminar.profiles["u_gas [m/s]"].max()
    )
    assert result.qoi["u_gas_centre"] > 1.3 * laminar.qoi["u_gas_centre"]
    assert_closed(result, 1e-10, "momentum", "gas flow", "solids flow")
    assert any(
        'turbulence = "eddy_viscosity_nikuradse"' in text for text in laminar.warnings
    )
    assert any(use["name"] == "eddy_viscosity_nikuradse" for use in result.closures)
