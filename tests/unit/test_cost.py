"""Which engine a plan advises: limits of the rule, and that it is printed."""

from typing import Any

import pytest

from contbed.loading import from_dict
from contbed.models import plan
from contbed.ranks.petsc import DIRECT_3D, PetscPolicy
from contbed.solvers.cost import advice
from contbed.solvers.linear import Policy
from tests.scene_text import scene_of

BOX: dict[str, Any] = scene_of(
    """
[mesh]
type = "box"
length = 1.0
width = 1.0
height = 1.0
cells = [4, 4, 4]
[gas]
density = 1.0
heat_capacity = 1000.0
conductivity = 0.05
viscosity = 2e-5
[solids.particles]
diameter = 0.01
[packed_bed]
porosity = 0.4
[boundary.left]
gas.velocity = 0.3
[boundary.bottom]
type = "no_slip"
"""
)


def test_small_scenes_stay_on_the_default_engine() -> None:
    assert advice({"flow": 6000, "heat": 4000}, Policy(2, 8.0)) == "engine: skfem"


def test_memory_decides() -> None:
    text = advice({"heat": 10_000_000}, Policy(2, 8.0))
    assert text.startswith("engine: dolfinx under mpirun, about 29 GB on all ranks")
    assert "9 GB more on rank 0" in text
    assert "skfem would need 50 GB of 8 GB" in text


def test_plan_prints_the_advice() -> None:
    assert "\nengine: skfem" in str(plan(from_dict(BOX)))


def test_radiation_of_a_volume_is_planned_with_multigrid() -> None:
    """A cube of 38 x 38 x 38 bricks of second degree: 10 kB an unknown where
    incomplete factors would have 20.
    """
    medium = {"level": "p1", "absorption": 3.0, "scattering": 1.0}
    wall = {"radiation": {"temperature": 1000.0, "emissivity": 0.8}}
    cube = {
        "type": "box",
        "length": 1.0,
        "width": 1.0,
        "height": 1.0,
        "cells": [38, 38, 38],
    }
    found = plan(
        from_dict({"mesh": cube, "radiation": medium, "boundary": {"left": wall}})
    )
    size = found.unknowns()["radiation"]
    assert size == 77**3 and found.policy.predicted_GB(size) == pytest.approx(
        1e-5 * size
    )


def test_memory_of_multigrid_on_ranks_is_that_of_petsc() -> None:
    """A cube of a million unknowns took 4 GB on DOLFINx; 21 were predicted, and the
    scene refused.
    """
    assert 3.9 < PetscPolicy(3).predicted_GB(1_030_301) < 8.0
    assert PetscPolicy(3).predicted_GB(DIRECT_3D) == Policy(3).predicted_GB(DIRECT_3D)
