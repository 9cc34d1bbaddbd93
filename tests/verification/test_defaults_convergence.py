"""Named results of every template under changes of what is only numerical: half the
cell, half the step, tolerances, orders, positions of output.

A result may move by the tolerance of the run, the wider of both, or by the share that
stands here for its kind: of the largest result of its unit, of a temperature over the
span of the scene. Steady packed beds estimate their errors, which are smaller:
temperatures move by no more than both runs estimate, within a factor of 3.
"""

from dataclasses import dataclass, field
from pathlib import Path

import pytest

import contbed
from contbed.fields import unit_of
from contbed.loading import load
from contbed.runner import run

ROOMS = Path(contbed.__file__).parent
# numbers of steps, cells and rounds, and errors, are no quantities of a bed
COUNTS = ("estimated_", "cells", "steps", "time", "ordinates", "samples", "share_")
COUNTS += ("packing_rounds", "theta_upwind", "drag_guard", "free_path")
TOLERANCES = ("solver.tolerance", "time.tolerance")
PLACE = 1e-3  # of the bed: extrema are flat
FINER = {"mesh.refine": 1}
POSITIONS = {"output.positions": [0.02, 0.05]}


@dataclass(frozen=True)
class Case:
    """A template, what is laid over it, the changes, and what results may move by:
    `share` of all, `own` of single ones; `span` of temperatures [K].
    """

    kind: str
    share: float
    changes: tuple[dict, ...]
    span: float = 1.0
    over: dict = field(default_factory=dict)
    own: dict = field(default_factory=dict)


def around(key, value, factor=10.0):
    """A key at a factor below its default and above."""
    return {key: value / factor}, {key: value * factor}


NEWTON = around("solver.newton_tolerance", 1e-10)
LINE = (FINER, POSITIONS, *around("solver.tolerance", 1e-5), {"solver.degree": 3})
HELD = {"boundary.right.solids.silica.velocity": None}
HELD |= {"boundary.right.solids.silica.temperature": None}
STORE = HELD | {"time.end": 3600.0, "initial.temperature": "700 degC"}
TIMES = (FINER, POSITIONS, {"time.times": [7.0, 70.0]})
TIMES += around("time.tolerance", 1e-4)
FAST = {
    "packed bed": Case("packed_bed", 1e-5, (*LINE, *NEWTON), 550.0),
    "store": Case("packed_bed", 1e-4, TIMES, 550.0, STORE),
    "two-flux": Case("radiation", 1e-5, LINE, 500.0),
    "P1": Case("radiation", 1e-5, LINE, 500.0, {"radiation.level": "p1"}),
    "reacting bed": Case(
        "reacting_bed",
        1e-6,
        (POSITIONS, *around("solver.tolerance", 1e-6), *NEWTON, {"solver.degree": 4}),
        300.0,
    ),
    "bubbling bed": Case(
        "bubbling_bed",
        1e-6,
        (FINER, POSITIONS, *around("solver.tolerance", 1e-6), {"solver.degree": 2}),
        700.0,
    ),
    # an eddy viscosity vanishes with the shear in the middle of the channel, where the
    # velocity of the gas is a power of 4/3
    "developed flow": Case(
        "developed_flow", 5e-4, ({"solver.cells": 120}, {"solver.degree": 2})
    ),
    "lattice": Case("dem", 1e-9, ({"particles.exponents": [0.2]},)),
}
PACKING = {"count": 400, "width": ["16 mm", "16 mm"]}
SLOW = {
    "ordinates": Case("radiation", 1e-5, LINE, 500.0, {"radiation.level": "ordinates"}),
    "single particle": Case(
        "single_particle",
        1e-3,
        ({"single_particle.cells": 60}, *around("time.tolerance", 1e-3, 2.0)),
        431.0,
    ),
    # how many spheres touch depends on their softness, what they conduct on the gas
    "packing": Case(
        "dem",
        0.02,
        around("particles.modulus", 1e7, 2.0),
        over={
            "particles.lattice": None,
            "particles.packing": PACKING,
            "solids.spheres.density": 2500.0,
            "solids.spheres.youngs_modulus": "63 GPa",
        },
    ),
    # of 4 samples; hits are longer where spheres are softer
    "particles in gas": Case(
        "cfd_dem",
        0.02,
        (
            *around("time.step", 2e-4, 2.0),
            *around("particles.modulus", 1e7, 2.0),
            {"solver.pressure_tolerance": 1e-9},
            {"time.sample": "5 ms"},
        ),
        own={"coordination": 0.25},
    ),
    # the bed expands for a tenth of a second, and instabilities grow
    "two fluids": Case(
        "two_fluid",
        0.06,
        (
            {"mesh.cells": [20, 60]},
            *around("time.longest", 0.01, 2.0),
            *around("time.first", 1e-5, 2.0),
            {"time.courant": 0.25},
            {"time.sample": "5 ms"},
        ),
    ),
}


def found(case, change):
    """Return the named results of a case, and the tolerance that it states."""
    quiet = {"output.plots": False}
    scene = load(ROOMS / case.kind / "template.toml", quiet | case.over | change)
    numbers = {
        name: value
        for name, value in run(scene, quiet=True).qoi.items()
        if isinstance(value, float) and not name.startswith(COUNTS)
    }
    stated = [value for key, value in change.items() if key in TOLERANCES]
    return numbers, max([case.share, *stated])


def moved(case, before, after):
    """Return by which share each result moves."""
    units = {name: unit_of(name) for name in before}
    largest: dict[str | None, float] = {"K": case.span}
    for name, value in before.items():
        if units[name] != "K":
            largest[units[name]] = max(largest.get(units[name], 0.0), abs(value))
    # granular temperature is energy of motion
    largest["m2/s2"] = largest.get("m/s", 1.0) ** 2
    return {
        name: abs(after[name] - value) / (largest[units[name]] or 1.0)
        for name, value in before.items()
    }


def check(case):
    before, _ = found(case, {})
    assert before
    for change in case.changes:
        after, share = found(case, change)
        assert set(after) == set(before)
        for name, by in moved(case, before, after).items():
            allowed = case.own.get(name, share)
            if unit_of(name) == "m":
                allowed = max(allowed, PLACE)
            assert by <= allowed, (change, name, before[name], after[name])


@pytest.mark.parametrize("case", FAST.values(), ids=FAST)
def test_results_stay(case):
    check(case)


@pytest.mark.slow
@pytest.mark.parametrize("case", SLOW.values(), ids=SLOW)
def test_results_stay_where_runs_are_longer(case):
    check(case)


def test_every_template_is_asked():
    kinds = {case.kind for case in (*FAST.values(), *SLOW.values())}
    assert kinds == {path.parent.name for path in ROOMS.glob("*/template.toml")}


@pytest.mark.parametrize("change", LINE[:-1])
def test_temperatures_of_a_packed_bed_stay_within_the_estimates(change):
    """Estimates are within a factor of 3, see `test_estimated_errors`."""
    path, quiet = ROOMS / "packed_bed" / "template.toml", {"output.plots": False}
    base, other = (run(load(path, quiet | more)).qoi for more in ({}, change))
    error = base["estimated_error"] + other.get("estimated_error", 0.0)
    for name in ("T_fluid_out_K", "T_solid_out_K", "pinch_K"):
        assert abs(other[name] - base[name]) <= 3.0 * error * 550.0
