"""Beds that move: drag and closures take the velocity relative to the particles."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from moving_beds import SIDES, moving
from pytest import approx

import contbed as cb
from contbed.closures import pressure_gradient_ergun
from contbed.loading import from_dict
from contbed.packed_bed.flow import coefficients
from contbed.packed_bed.plan import plan
from tests.scene_text import scene_of

EPS, D = 0.39, 3e-3
OIL = {"density": 950.0, "viscosity": 2e-3}
UP, DOWN = 2e-3, 1.2e-3  # oil and shot, superficial [m/s]
SPEED = UP + EPS * DOWN / (1 - EPS)  # EPS (UP/EPS + DOWN/(1 - EPS))
T = 400.0
MESHES: dict[str, dict[str, Any]] = {
    "line": {"length": 1.2},
    "rectangle": {"length": 1.2, "height": 1.2, "cells": [4, 4]},
    "axisymmetric": {"radius": 0.2, "length": 1.2, "cells": [2, 4]},
    "box": {"length": 1.2, "width": 1.2, "height": 1.2, "cells": [2, 2, 2]},
}
AXES = [("line", 0), ("axisymmetric", 1), ("rectangle", 0), ("rectangle", 1)]
AXES += [("box", axis) for axis in range(3)]


def bed(mesh="line", axis=0, gas=UP, solid=-DOWN, **more):
    """A bed of one temperature; gas and particles move along an axis."""
    made = scene_of(
        """
        closures = { nusselt = "wakao_kaguei" }
        heat = {}
        gas = { heat_capacity = 2200.0, conductivity = 0.11 }
        [solids.particles]
        density = 7800.0
        heat_capacity = 500.0
        conductivity = 40.0
        """,
        {
            "mesh": {"type": mesh} | MESHES[mesh],
            "solids.particles.diameter": D,
            "packed_bed.porosity": EPS,
        },
    )
    made["gas"] |= OIL
    unit = np.eye(len(SIDES[mesh]))[axis]
    made["boundary"] = moving(made["mesh"], {}, list(gas * unit), list(solid * unit))
    for side in made["boundary"].values():
        for stream in (side.get("gas"), side.get("solids", {}).get("particles")):
            if stream is not None:
                stream["temperature"] = T
    for key, value in more.items():
        made[key] = made.get(key, {}) | value
    return made


def reynolds(result):
    """Return the Reynolds numbers that the Nusselt number had."""
    (nusselt,) = (each for each in result.closures if each["kind"] == "nusselt")
    return nusselt["ranges"]["Re"]["used"]


def ergun(speed):
    return pressure_gradient_ergun(u=speed, d_p=D, eps=EPS, mu=2e-3, rho=950.0)


@pytest.mark.parametrize(("mesh", "axis"), AXES)
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_oil_through_shot_has_the_drag_of_their_slip(mesh, axis, direction):
    """Along each axis, either way: Ergun's law and the Reynolds number by hand."""
    values = bed(mesh, axis, direction * UP, -direction * DOWN)
    result = cb.run(from_dict(values))
    drop = result.qoi["pressure_drop_Pa"]
    assert drop == approx(1.2 * ergun(SPEED), rel=1e-12)
    assert reynolds(result) == approx([950.0 * SPEED * D / 2e-3] * 2, rel=1e-12)


@pytest.mark.parametrize(("mesh", "axis"), AXES)
def test_particles_that_overtake_the_fluid_raise_its_pressure(mesh, axis):
    """Ergun's law of the slip, by which the drop is below zero: round-off."""
    solid = (1 - EPS) * 2.0 * UP / EPS  # of a fluid at 2 UP
    result = cb.run(from_dict(bed(mesh, axis, UP, solid)))
    assert result.qoi["pressure_drop_Pa"] == approx(-1.2 * ergun(UP), rel=1e-12)


@pytest.mark.parametrize(("mesh", "axis"), AXES)
def test_gas_and_particles_that_move_together_have_no_drag(mesh, axis):
    """u/eps = u_s/(1 - eps): neither the pressure falls, nor has the Nusselt number
    more than its value at rest.
    """
    values = bed(mesh, axis, EPS * 0.3, (1 - EPS) * 0.3)
    result = cb.run(from_dict(values))
    assert result.qoi["pressure_drop_Pa"] == approx(0.0, abs=1e-12 * ergun(0.1))
    assert reynolds(result) == approx([0.0, 0.0], abs=1e-12)
    of_flow = coefficients(result.plan).comoving_velocity.items
    assert of_flow == approx(list(result.plan.velocity), rel=1e-15)


def test_a_gas_that_expands_has_the_drag_of_its_own_velocity():
    """Steam at the temperature of the bed: the Reynolds number of all points."""
    steam = {"model": "cantera", "composition": "H2O:1", "mechanism": "gri30.yaml"}
    values = bed(gas=0.5, solid=0.4) | {"gas": steam}
    result = cb.run(from_dict(values))
    fluid = result.plan.medium.fluid
    speed = 0.5 - EPS * 0.4 / (1 - EPS)
    wanted = float(fluid.density(T)) * speed * D / float(fluid.viscosity(T))
    assert reynolds(result) == approx([wanted] * 2, rel=1e-9)


def test_the_form_of_the_paper_takes_superficial_velocities():
    values = bed(packed_bed={"relative_velocity": "superficial"})
    result = cb.run(from_dict(values))
    drop = result.qoi["pressure_drop_Pa"]
    assert drop == approx(1.2 * ergun(UP + DOWN), rel=1e-12)
    assert reynolds(result) == approx([950.0 * (UP + DOWN) * D / 2e-3] * 2, rel=1e-12)


def test_the_level_inside_of_particles_is_chosen_by_the_same_velocity():
    """By the Biot number of Wakao and Kaguei's film."""
    Re, Pr = 950.0 * SPEED * D / 2e-3, 2e-3 * 2200.0 / 0.11
    made = plan(from_dict(bed(solver={"accuracy": 0.01})))
    film = (2.0 + 1.1 * Re**0.6 * Pr ** (1 / 3)) * 0.11 / D
    assert made.inside.passage.biot == approx(film * 0.5 * D / 40.0, rel=1e-12)


@pytest.mark.parametrize("solid", [0.048, -0.048])
def test_a_bed_with_species_has_the_same_drag_and_nusselt_number(solid):
    """The packed bed and the bed with species take one velocity; 0.1 K leaves the
    density of the gas, which drag and film see, constant to 3e-4.
    """
    density, molar_mass, hot = 1.2, 0.028, 400.1
    gas = {"viscosity": 1.8e-5, "conductivity": 0.03}
    values = bed(gas=0.1, solid=solid)
    values["mesh"]["length"] = 3e-3
    values["closures"] |= {"conductivity_gas": 0.0, "conductivity_solids": 0.0}
    values["boundary"]["left"]["gas"]["temperature"] = hot
    species = {"N2": {"molar_mass": molar_mass, "heat_capacity": 1000.0 * molar_mass}}
    ideal = {"model": "ideal_gas", "composition": "N2:1", "species": species}
    ideal["pressure"] = density * 8.31446261815324 * hot / molar_mass
    packed = values | {"gas": gas | {"density": density, "heat_capacity": 1000.0}}
    reacting = values | {"gas": gas | ideal, "model": "packed_bed"}
    reacting["packed_bed"] = {"porosity": EPS, "pressure_drop": "ergun"}
    one, other = (cb.run(from_dict(each)).qoi for each in (packed, reacting))
    assert other["pressure_drop_Pa"] == approx(one["pressure_drop_Pa"], rel=3e-4)
    left, other_left = (qoi["T_fluid_out_K"] - T for qoi in (one, other))
    assert other_left == approx(left, rel=3e-4)
