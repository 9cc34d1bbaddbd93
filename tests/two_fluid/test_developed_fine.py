"""Fully developed flow of fine particles: production of fluctuations by the slip,
and what is said without it.
"""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import contbed as cb
from contbed.developed_flow import equations as model
from contbed.developed_flow.equations import uniform_fraction
from contbed.developed_flow.problem import DevelopedProblem
from contbed.developed_flow.run import advice
from contbed.errors import ConvergenceError
from contbed.loading import from_dict
from contbed.models import plan
from contbed.scene.values import with_value
from tests.balances import assert_closed
from tests.refusals import refused
from tests.scene_text import scene_of


def fcc(cells=60, **closures):
    """FCC of 75 um in a pipe of 100 mm; 5 m/s, 50 kg/m2/s."""
    flow = {
        "section": "pipe",
        "radius": 0.05,
        "gas_velocity": 5.0,
        "solids_mass_flux": 50.0,
    }
    return from_dict(
        scene_of(
            f"""
            [gas]
            density = 1.2
            viscosity = 1.8e-5

            [solids.beads]
            diameter = 75e-6
            density = 1500.0

            [boundary.wall]
            type = "wall"
            solids.beads = {{ specularity = 0.1 }}

            [solver]
            cells = {cells!r}

            [output]
            plots = false
            fields = false
        """,
            {"developed_flow": flow, "closures": closures},
        )
    )


@pytest.mark.slow
def test_fine_particles_have_a_solution_with_production_by_the_slip():
    result = cb.run(fcc(granular_production="granular_production_koch"))
    assert_closed(result, 1e-10, "momentum", "gas flow", "solids flow")
    assert any(use["name"] == "granular_production_koch" for use in result.closures)
    # by hand from the profile: S = 81 eps mu^2 slip^2/(g0 d^3 rho sqrt(pi theta))
    problem = DevelopedProblem(result.plan)
    c = problem.c
    centre = {name: column[0] for name, column in result.profiles.items()}
    u = SimpleNamespace(
        u_gas=centre["u_gas [m/s]"],
        u_solid=centre["u_solid [m/s]"],
        root=centre["theta [m2/s2]"] ** 0.5,
        pressure=result.qoi["pressure_solid_Pa"],
    )
    at = model.local(u, c)
    slip = u.u_gas - u.u_solid
    S = (
        81.0
        * at.eps_s
        * 1.8e-5**2
        * slip**2
        / (at.g0 * 75e-6**3 * 1500.0 * np.pi**0.5 * u.root)
    )
    assert at.production == pytest.approx(S, rel=1e-12)


@pytest.mark.slow
def test_fine_particles_without_it_end_with_advice():
    with pytest.raises(
        ConvergenceError,
        match=r'no solution found; .*production = "granular_production_koch"',
    ):
        cb.run(fcc(20))


def test_advice_for_particles_that_drag_stops():
    """The Stokes number rho_s d^2 u/(18 mu R) of 10 um: 0.046."""
    fine = with_value(fcc(20), ("solids", "beads", "diameter"), 1e-5)
    text = advice(DevelopedProblem(plan(fine)))
    assert text.startswith("the Stokes number of the particles, 0.046 ")
    assert "Stokes" not in advice(DevelopedProblem(plan(fcc(20))))


def conveyed(**closures):
    """200 um in a pipe of 100 mm; 15 m/s, 10 kg/m2/s, turbulent gas."""
    scene = fcc(20, turbulence="eddy_viscosity_nikuradse", **closures)
    for path, value in {
        ("solids", "beads", "diameter"): 2e-4,
        ("solids", "beads", "density"): 2500.0,
        ("boundary", "wall", "solids", "beads", "specularity"): 0.05,
        ("developed_flow", "gas_velocity"): 15.0,
        ("developed_flow", "solids_mass_flux"): 10.0,
    }.items():
        scene = with_value(scene, path, value)
    return scene


def test_advice_for_particles_in_turbulent_gas():
    """The flat profile of the gas shears few particles: their pressure falls to 0."""
    text = advice(DevelopedProblem(plan(conveyed())))
    assert text.startswith('name closures.granular_production = "granular_prod')


def test_advice_for_few_particles():
    """They fly d/(6 sqrt(2) eps_s) between collisions, many times the radius."""
    named = conveyed(granular_production="granular_production_koch")
    few = with_value(named, ("developed_flow", "solids_mass_flux"), 0.5)
    problem = DevelopedProblem(plan(few))
    apart = problem.c.d_p / (6.0 * 2.0**0.5 * uniform_fraction(problem.c))
    assert apart > 3.0 * problem.c.radius
    assert advice(problem).startswith(
        f"the mean free path of the particles between collisions, {apart:.2g} m, is far"
    )
    assert "free path" not in advice(DevelopedProblem(plan(named)))


@pytest.mark.slow
def test_particles_are_conveyed_by_turbulent_gas():
    """Small steps lead from laminar to turbulent gas, at first 0.01 of the way."""
    result = cb.run(conveyed(granular_production="granular_production_koch"))
    assert_closed(result, 1e-10, "momentum", "gas flow", "solids flow")


@pytest.mark.slow
def test_cells_that_are_too_coarse_are_halved_and_told():
    result = cb.run(fcc(40, granular_production="granular_production_koch"))
    assert any(
        "no solution with 40 cells; 80 are used" in text for text in result.warnings
    )
    assert_closed(result, 1e-10, "momentum")


def test_coarse_particles_that_fail_are_not_told_of_production():
    """1 mm: shear and walls reach all particles with fluctuations; a search that
    fails has another reason.
    """
    scene = (
        Path(__file__).parents[2] / "studies" / "two_fluid_checks" / "developed.toml"
    )
    with pytest.raises(ConvergenceError) as error:
        cb.run(cb.load(scene, {"solver.newton_iterations": 1}))
    assert "try granular_temperature_centre" in str(
        error.value
    ) and "production" not in str(error.value)


def test_a_name_that_does_not_exist_is_refused():
    refused(
        r"closures\.granular_production",
        fcc,
        granular_production="granular_production_kock",
    )
