"""The weak forms: order with a manufactured solution, exact Jacobian, what is
written, what costs nothing.
"""

import json

import numpy as np
import pytest
import skfem
from bubbling_scenes import STUDY, case1, one

import contbed as cb
from contbed.bubbling_bed.equations import bed as model
from contbed.bubbling_bed.equations.coefficients import (
    Coefficients,
    Plate,
    Species,
    Stream,
    Surface,
)
from contbed.bubbling_bed.plan import plan
from contbed.bubbling_bed.problem import BubblingProblem
from contbed.fem.skfem import System
from contbed.output.tables import read_table
from contbed.solvers.linear import Policy
from contbed.solvers.newton import Options, newton
from studies._exact.manufactured import Manufactured, observed_order
from tests.command_line import command

HEIGHT = 0.8
EXACT = {
    "T_a": lambda z: 900.0 + 200.0 * np.sin(3.0 * z),
    "T_b": lambda z: 800.0 + 150.0 * np.exp(-z),
    "T_emulsion": lambda z: 700.0 + 300.0 * z**2,
    "T_bubble": lambda z: 500.0 + 400.0 * z * np.exp(-z),
    "G": lambda z: 4 * 5.67e-8 * (850.0 + 100.0 * np.cos(2.0 * z)) ** 4,
    "T_distributor": lambda z: 600.0 + 0.0 * z,
}


def coefficients(level, degree):
    """All terms at work, and of one size."""

    def release(z, T):
        return 2e3 * np.exp(-z) * np.exp(-2000.0 * (1.0 / T - 1.0 / 900.0))

    a = Stream(lambda z: 5.0 * z**2, lambda z: 10.0 * z, 400.0, 3.0, release)
    b = Stream(lambda z: 2.0 * (z - HEIGHT), lambda z: 2.0 + 0.0 * z, 500.0, 8.0)
    return Coefficients(
        1.4,
        0.3,
        350.0,
        {"a": Species(a, 30.0, 0.4, 0.8), "b": Species(b, 50.0, 0.6, 1.5)},
        {("a", "b"): 20.0},
        Stream(lambda z: 12.0 + 0.0 * z, release=release),
        Stream(lambda z: 25.0 + 0.0 * z),
        40.0,
        {
            "tubes": Surface(2.0, 15.0, 450.0, 0.6),
            "walls": Surface(3.0, 5.0, 700.0, 0.3),
        },
        Plate(9.0, 0.8, 0.7),
        level,
        0.2,
        3e4,
        degree,
    )


def bed(level, degree, cells):
    """System and forms on an uneven line."""
    c = coefficients(level, degree)
    nodes = HEIGHT * np.linspace(0.0, 1.0, cells + 1) ** 1.2
    line = skfem.MeshLine.init_tensor(nodes).with_boundaries(
        {"bottom": lambda x: x[0] == 0.0, "top": lambda x: x[0] == HEIGHT}
    )
    system = System(
        line,
        dict.fromkeys(c.fields, (degree, 0)) | {"T_distributor": (0, 0)},
        2 * degree + 4,
    )
    forms = [
        (model.residual, system.cells, c),
        *(
            (form, system.boundary(end)[0], c)
            for form, end in ((model.bottom, "bottom"), (model.top, "top"))
        ),
    ]
    return system, forms


@pytest.mark.parametrize("level", ["none", "paper", "field"])
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_order_of_a_manufactured_solution(level, degree):
    errors, sizes = [], (8, 16, 32)
    for cells in sizes:
        system, forms = bed(level, degree, cells)
        case = Manufactured(
            system, {name: EXACT[name] for name in system.fields}, forms
        )
        load = case.load()

        def assemble(state, jacobian, system=system, forms=forms, load=load):
            residual, matrix = system.assemble(forms, state, jacobian)
            return residual - load, matrix

        state, _ = newton(
            assemble,
            1.05 * case.interpolant(),
            np.empty(0, dtype=int),
            Policy(1),
            Options(1e-9),
        )
        errors.append(case.errors(state))
    for name in errors[0].keys() - {"T_distributor"}:
        found = observed_order(
            [error[name] for error in errors], [1.0 / cells for cells in sizes]
        )
        # degree + 1 in L2, a little less on coarse meshes
        assert found[-1] > degree + 0.8, (name, found)
    # one number converges faster than a field, but not evenly
    assert all(error["T_distributor"] < error["T_a"] for error in errors)


@pytest.mark.parametrize("level", ["none", "paper", "field"])
def test_jacobian_is_the_derivative(level):
    system, forms = bed(level, 2, 5)
    state = np.full(system.size, 800.0)
    for name in system.fields:
        where = system.fields[name][0].points[0]
        system.part(state, name)[:] = EXACT[name](where)
    direction = np.random.default_rng(1).normal(size=system.size) * np.abs(state)
    _, matrix = system.assemble(forms, state)
    step = 1e-5
    plus, minus = (
        system.assemble(forms, state + sign * step * direction, False)[0]
        for sign in (1, -1)
    )
    difference = (plus - minus) / (2 * step)
    # central differences of powers of T: relative error of step^2
    assert (
        np.abs(matrix @ direction - difference).max() < 1e-7 * np.abs(difference).max()
    )


def test_heat_that_one_phase_gives_another_gets():
    """What all phases gain, without what they release and surfaces take, is what
    radiation brings through the ends.
    """
    problem = BubblingProblem(plan(case1()))
    state, _ = problem.solve()
    residual, _ = problem.assemble(state, False)
    c = problem.c
    gains = problem.total(
        lambda u, o: sum(model.gains(u, c, c.at(u, o), o).values(), start=0.0), state
    )
    out = sum(
        value
        for name, value in problem.duties(state).items()
        if name.startswith(("tubes", "walls"))
    )
    ends = problem.duties(state)
    net = sum(problem.releases(state).values()) - out
    assert gains - net == pytest.approx(
        -ends["top_radiation_W"] - ends["distributor_radiation_W"], rel=1e-9
    )
    assert abs(residual.sum()) < 1e-12 * sum(
        abs(value) for value in problem.releases(state).values()
    )


def test_predicted_layers_of_two_streams():
    """Particles and gas at rest: K r^2 = p h, for a mode that decays upward and one
    that decays downward.
    """
    made = plan(
        one(
            inlet={"capacity_flow": 0.0, "temperature": 300.0},
            tubes={"perimeter": 1.0, "coefficient": 800.0, "temperature": 500.0},
        )
    )
    width = np.sqrt(1.3 * 5.0 / 800.0)
    assert "graded to 2 layers" in str(made)
    assert made.mesh.skfem.p[0, 1:].min() < 0.5 * width


def test_a_run_writes_what_other_runs_write(tmp_path):
    assert command(f"run {STUDY}/p1.toml --out {tmp_path} --quiet") == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["status"] == "ok" and summary["balances"]["energy"]["unit"] == "W"
    assert summary["scene"]["solids"]["char"]["diameter"] == 3e-3
    profiles = read_table(tmp_path / "profiles.csv")
    z = profiles["z [m]"]
    assert z[0] == 0.0 and z[-1] == 0.6 and np.all(np.diff(z) > 0)
    assert (z < np.sqrt(1 / (3 * 997 * 572))).sum() >= 20  # of the radiation's layer
    assert (tmp_path / "profiles.png").stat().st_size > 10_000 and (
        tmp_path / "fields.vtu"
    ).exists()


def test_plan_and_convergence_from_the_command_line(tmp_path, capsys):
    assert command(f"plan {STUDY}/none.toml") == 0
    assert "SKIPPED radiation" in capsys.readouterr().out
    assert command(f"converge {STUDY}/p1.toml --levels 2 --out {tmp_path}") == 0
    assert command("explain bubbling_bed.height") == 0
    assert "> 0 m" in capsys.readouterr().out


def test_overrides_and_dictionaries():
    scene = cb.load(STUDY / "p1.toml", {"radiation.level": "none", "mesh.cells": 15})
    assert scene.radiation.level == "none"
    assert cb.plan(scene).mesh.skfem.nelements == 15
