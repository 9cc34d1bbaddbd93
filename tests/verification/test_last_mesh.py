"""Cells and processor time that the plan of an automatic plane or volume predicts for the last mesh of its run."""

from __future__ import annotations

import time

import numpy as np
import pytest
from wall_scenes import scene

import contbed as cb
from contbed import cli
from contbed.loading import from_dict
from contbed.packed_bed import last_mesh as module
from contbed.packed_bed.last_mesh import last_mesh
from contbed.packed_bed.plan import plan
from contbed.trial import predicted_time


def predicted_over_true(bed):
    """Return cells and processor time of the run as predicted, over those that it takes."""
    found = last_mesh(plan(bed))
    start = time.process_time()
    result = cb.run(bed)
    spent = time.process_time() - start
    return found.cells / result.plan.mesh.skfem.nelements, found.seconds / spent


def channel(shape="rectangle", tolerance=1e-4):
    """Return a bed between a hot wall and a cold one, both without slip."""
    across = {"rectangle": {"height": 0.1}, "box": {"height": 0.1, "width": 0.1}}[shape]
    velocity = {"rectangle": 0.1, "box": [0.1, 0.0, 0.0]}[shape]
    return from_dict(
        {
            "mesh": {"type": shape, "length": 0.3} | across,
            "fluid": {"density": 1.0, "heat_capacity": 1000.0, "conductivity": 0.1, "viscosity": 2e-5},
            "solid": {"density": 2000.0, "heat_capacity": 900.0, "conductivity": 2.0},
            "bed": {"porosity": 0.4, "particle_diameter": 0.01},
            "flow": {"velocity": velocity},
            "heat": {"nusselt": 5.0},
            "boundary": {
                "left": {"fluid": {"inflow": 300.0}},
                "bottom": {"type": "no_slip", "solid": {"coefficient": 50.0, "ambient": 600.0}},
                "top": {"type": "no_slip"},
            },
            "solver": {"tolerance": tolerance},
            "output": {"plots": False, "fields": False},
        }
    )


def test_last_mesh_follows_from_the_first(monkeypatch):
    """Within a factor of 2, the promise of the plan, where the trial ends after a mesh of 1353 cells; 2744 are due."""
    monkeypatch.setattr(module, "BUDGET", 0.0)
    bed = scene(3, tolerance=1e-4)
    assert plan(bed).mesh.skfem.nelements < 0.6 * 2744
    found = last_mesh(plan(bed))
    assert not found.ended
    cells, seconds = predicted_over_true(bed)
    assert 0.5 < cells < 2.0
    assert 0.5 < seconds < 2.0


def test_a_trial_that_comes_to_the_end_is_exact():
    """The plan says so, and counts its own start and the pictures to the run."""
    bed = scene(0, tolerance=1e-4)
    cells = cb.run(bed).plan.mesh.skfem.nelements
    found = last_mesh(plan(bed))
    assert found.ended
    assert found.cells == cells
    assert predicted_time(plan(bed)).endswith(f"of processor, {cells} cells in the last mesh, by a trial")


def test_a_dear_first_mesh_is_tried_with_larger_cells(monkeypatch):
    """Every other vertex is left out until the rates of the engine allow it, at least two cells stay in a direction."""
    made = plan(scene(3))
    assert module._affordable(made) is made
    monkeypatch.setattr(module, "DEAREST", 0.1)
    coarse = module._affordable(made)
    ends, former = (np.unique(each.mesh.skfem.p[0]) for each in (coarse, made))
    assert len(ends) < len(former)
    assert set(ends) < set(former)
    assert (ends[0], ends[-1]) == (former[0], former[-1])
    monkeypatch.setattr(module, "DEAREST", 0.0)
    assert module._affordable(made).mesh.skfem.nelements == 4


def test_plans_without_a_search_have_no_last_mesh(tmp_path, capsys):
    """Given cells and the remark on the first mesh."""
    text = """[mesh]
type = "rectangle"
length = 0.2
height = 0.1
CELLS
[fluid]
density = 1.0
heat_capacity = 1000.0
conductivity = 0.1
viscosity = 2e-5
[solid]
density = 2000.0
heat_capacity = 900.0
conductivity = 5.0
[bed]
porosity = 0.4
particle_diameter = 0.01
[flow]
velocity = 0.05
[heat]
nusselt = 1.0
[boundary.left.fluid]
inflow = 300.0
[boundary.bottom.solid]
fixed = 500.0
"""
    found = []
    for cells in ("", "cells = [10, 10]"):
        (tmp_path / "bed.toml").write_text(text.replace("CELLS", cells))
        assert cli.main(["plan", str(tmp_path / "bed.toml")]) == 0
        found.append(capsys.readouterr().out)
    assert "of processor for the first mesh" in found[0]
    assert "cells in the last mesh" in found[0]
    assert "of processor for a steady scene" in found[1]
    assert "time: " not in found[1]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(50))
def test_random_walls(seed):
    """Within a factor of 2, the promise of the plan; runs of less than a second are told by their trial."""
    bed = scene(seed)
    if plan(bed).balanced:
        cells, seconds = predicted_over_true(bed)
        assert 0.5 < cells < 2.0
        assert 0.5 < seconds < 2.0


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "tolerance"), [("rectangle", 1e-4), ("rectangle", 1e-5), ("box", 1e-2)])
def test_beds_between_walls_without_slip(shape, tolerance):
    """Within a factor of 2: flow and temperatures."""
    cells, seconds = predicted_over_true(channel(shape, tolerance))
    assert 0.5 < cells < 2.0
    assert 0.5 < seconds < 2.0
