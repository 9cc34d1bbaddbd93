"""Reacting beds on DOLFINx: the weak form in UFL gives the residuals, derivatives and results of the blocks on a line.

Both engines sum the same terms in another order and factor with other pivots. Residuals of random states and products
of their Jacobians agree to 1e-12 of the largest of an equation: terms that cancel are up to a thousand times as large.
Results of runs agree to 1e-10 of the largest value of a field; 1e-13 is usual. Cells that follow errors are placed by
jumps of a millionth of a field, which rounding changes by some 1e-10 of themselves.
"""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("dolfinx.fem", reason="DOLFINx is not installed")

from dolfinx_launch import started
from dolfinx_reacting_scenes import LONG, ROOT, SCENES, burning, warming

from contbed.fem.dolfinx import on_dolfinx
from contbed.loading import from_dict
from contbed.models import plan as make_plan
from contbed.reacting_bed.amounts import carried
from contbed.reacting_bed.course import Course
from contbed.reacting_bed.storage import Storage
from contbed.runner import run

FORMS, TOLERANCE = 1e-12, 1e-10
SOLVED = 1e-11  # of the largest right-hand side, what MUMPS leaves of it
ROUNDING = 1e-12  # of conversions of what does not react, and of what is left of solids used up, which are differences
RUNS = {1: tuple(SCENES), 2: tuple(name for name in SCENES if name not in LONG)}
STATES = SCENES | {"damped": burning(), "stored": warming("stored"), "stored and damped": warming("stored")}
STATES["one_cell"] = burning() | {"mesh": burning()["mesh"] | {"cells": 1}}


def problems(name: str):
    """The bed of a scene on both engines."""
    made = make_plan(from_dict(STATES[name]))
    plans = (made, on_dolfinx(made))
    if made.scene.time is None:
        return [plan.problem for plan in plans]
    return [Course.of(plan.scene, plan.problem, plan.schedule, plan.stores_gas).problem for plan in plans]


def largest(values, m: int):
    """The largest of each of m equations."""
    return np.abs(values.reshape(m, -1)).max(axis=1)


@pytest.mark.parametrize("name", STATES)
def test_residual_and_jacobian(name: str) -> None:
    one, other = problems(name)
    assert other.line.engine == "dolfinx" and type(one.system) is not type(other.system)
    random, m = np.random.default_rng(5), len(one.names)
    if "damped" in name:
        damping = random.uniform(0.0, 2.0, (m, one.line.cells)) * (carried(one) > 0.0)[:, None]
        one, other = (replace(problem, damping=damping) for problem in (one, other))
    u = one.start() * random.uniform(0.97, 1.03, (m, *one.line.points.shape)) + 1e-3 * one.sizes[:, None, None]
    x = random.uniform(-1.0, 1.0, u.shape) * one.sizes[:, None, None]
    found = []
    for problem in (one, other):
        residual, slopes = problem.system.assemble(u)
        if problem.scene.time is not None:
            storage = Storage(problem, Storage(problem, u, 3.0).content(0.9 * u, False)[0], 3.0)
            residual = storage.add(u, residual, slopes)
        matrix = slopes.matrix(problem.flux_sizes)
        product = matrix @ x.ravel()
        found.append((residual, product, problem.system.fluxes(u), problem.system.sources(u)))
    right = (product * np.repeat(one.flux_sizes, u[0].size)).reshape(u.shape)
    solved = slopes.factors(one.flux_sizes, one.sizes).solve(right)
    assert np.all(largest(matrix @ solved.ravel() - product, m) <= SOLVED * largest(product, m).max())
    for first, second in zip(*found, strict=True):
        assert np.all(largest(first - second, m) <= FORMS * np.maximum(largest(first, m), 1e-300))


@pytest.fixture(scope="session")
def expected():
    """Results of the first engine, made when asked for."""
    from dolfinx_program import found

    return cache(lambda name: found(run(from_dict(SCENES[name]))))


@pytest.mark.parametrize(("name", "ranks"), [(name, ranks) for ranks, names in RUNS.items() for name in names])
def test_scene(name: str, ranks: int, results, expected) -> None:
    one, other = expected(name), dict(np.load(Path(results("react", ranks, *RUNS[ranks])) / f"{name}.npz"))
    assert one.keys() == other.keys()
    assert any(np.ptp(values) > 0 for key, values in one.items() if key.startswith("profile.x_"))
    for key, values in one.items():
        assert values.shape == other[key].shape, key
        scale, floor = np.nanmax(np.abs(values)), 0.0
        if key.startswith(("balance.", "qoi.cycle_change", "qoi.estimated_error", "qoi.cells_error")):
            scale, floor = 0.0, ROUNDING
        elif key.startswith(("qoi.conversion_", "qoi.w_", "qoi.x_")):
            floor = ROUNDING
        np.testing.assert_allclose(other[key], values, rtol=0.0, atol=TOLERANCE * scale + floor, err_msg=key)


@pytest.mark.parametrize(("first", "then"), [(1, 1), (2, 1)])
def test_continued_on_other_ranks(results, first: int, then: int) -> None:
    """The same numbers to the last bit on as many ranks, to those of rounding on others."""
    folder = results("stop", first, "warming", 100.0)
    found = np.load(results("resume", then, "warming", folder) / "found.npz")
    whole = np.load(results("react", then, *RUNS[then]) / "warming.npz")
    assert found.files == whole.files
    for key in whole.files:
        if first == then:
            assert np.array_equal(found[key], whole[key]), key
        elif key.startswith("profile."):
            assert np.abs(found[key] - whole[key]).max() <= TOLERANCE * np.abs(whole[key]).max(), key


def test_derivatives_are_those_of_the_tangent(results) -> None:
    """Differences of runs at two distances err by 1e-12 of the cube of a step of 1e-3; Newton leaves 1e-10/1e-3."""
    qoi, keys = "T_fluid_out_K", ["bed.porosity", "boundary.left.fluid.inflow", "reactions.r.E"]
    exact = run(from_dict(SCENES["burning"])).gradient([qoi], keys)
    found = np.load(results("slopes", 1, "burning", qoi, *keys) / "slopes.npz")
    assert exact.method == "tangent" and found["method"] == "differences"
    scale = np.abs(exact.derivatives * exact.at).max()
    np.testing.assert_allclose(found["derivatives"] * exact.at, exact.derivatives * exact.at, rtol=0, atol=1e-6 * scale)


def test_command_on_two_ranks(tmp_path: Path) -> None:
    scene, out = ROOT / "contbed" / "reacting_bed" / "template.toml", tmp_path / "out"
    done = started(2, "run", scene, "--engine", "dolfinx", "--out", out, program="contbed")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("results are in") == 1
    summary = json.loads((out / "summary.json").read_text())
    assert summary["status"] == "ok" and summary["engine"]["ranks"] == 2
    assert (out / "profiles.csv").is_file()


def test_more_ranks_than_cells(tmp_path: Path) -> None:
    scene = ROOT / "contbed" / "reacting_bed" / "template.toml"
    done = started(2, "run", scene, "--set", "mesh.cells=1", "--out", tmp_path, program="contbed")
    assert done.returncode == 2
    assert done.stderr.count("2 ranks for a mesh of 1 cells: each rank needs one") == 1
