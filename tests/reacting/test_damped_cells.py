"""Fluxes that damp amounts inside of cells: exact derivatives, heat that goes with
them, gas that fills the pores.

Amounts of a gas that is stored are bounded to 1e-10 of their size, to which Newton's
method solves; each test first sees how far they would fall.
"""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from reacting_bed_scenes import danckwerts, heated, isothermal, let_move, species
from several_solids import split
from test_bounds_in_time import CLOSED, LEFT, course_of, least_of, unbounded
from test_several_solids import hot

import contbed
from contbed.loading import from_dict
from contbed.particle.uptake import invert
from contbed.reacting_bed.least_amounts import carried
from tests.balances import assert_closed
from tests.scene_text import set_keys

RESIDENCE = 0.8  # [s] of the gas in all scenes of 1 m: 0.4 of it at 0.5 m/s


def with_rings(scene):
    scene = deepcopy(scene)
    set_keys(
        scene,
        """
        mesh.diameter = 0.1
        boundary.wall = { coefficient = 50.0, ambient = 600.0 }
        packed_bed.section = { rings = 2, conductivity_solids = 2.0, dispersion = 1e-3 }
        """,
    )
    return scene


def one_temperature(scene):
    """Gas and particles that go the same way."""
    closures = {
        key: scene["closures"][key]
        for key in ("conductivity_solids", "sherwood", "dispersion_mass")
    }
    boundary = {"left": {"gas": {"velocity": 0.5, "temperature": 400.0}}}
    return let_move(
        scene | {"boundary": boundary, "closures": closures}, 2e-4, temperature=400.0
    )


BEDS = {
    "one kind": hot(),
    "one temperature": one_temperature(hot()),
    "several kinds": split(hot()),
    "kinds of one temperature": one_temperature(split(hot())),
    "rings": with_rings(one_temperature(hot())),
}


def bed_of(scene, stored):
    set_keys(scene, "mesh.cells = 3")
    problem = course_of(scene | {"time": {"end": 1.0}}).problem
    return problem.with_gas_stored(problem.streams.pressure) if stored else problem


@pytest.mark.parametrize("stored", [False, True], ids=["at once", "stored"])
@pytest.mark.parametrize("scene", BEDS.values(), ids=BEDS)
def test_derivatives_of_damping(scene, stored):
    """What damping adds against differences of steps of 1e-4, which are of order 2;
    it adds nothing to a cell.
    """
    problem, random = bed_of(scene, stored), np.random.default_rng(5)
    m, N = len(problem.names), problem.line.cells
    damping = random.uniform(0.0, 2.0, (m, N)) * (carried(problem) > 0.0)[:, None]
    damped = replace(problem, damping=damping)
    scale = problem.sizes[:, None, None]
    u = problem.start() * random.uniform(
        0.9, 1.1, (m, N, 4)
    ) + 0.1 * scale * random.uniform(0.1, 1.0, (m, N, 4))
    v = random.uniform(-1.0, 1.0, u.shape) * scale

    def added(at):
        return (
            damped.system.assemble(at, False)[0] - problem.system.assemble(at, False)[0]
        )

    def product(of):
        matrix = of.system.assemble(u)[1].matrix(of.flux_sizes)
        return (matrix @ v.ravel()).reshape(u.shape)

    step = 1e-4
    differences = (
        (added(u + step * v) - added(u - step * v))
        / (2.0 * step)
        / problem.flux_sizes[:, None, None]
    )
    exact = product(damped) - product(problem)
    assert np.abs(exact).max() > 0.1
    assert_allclose(exact, differences, rtol=0.0, atol=1e-6 * np.abs(exact).max())
    moved = added(u) / problem.flux_sizes[:, None, None]
    assert_allclose(moved.sum(axis=2), 0.0, atol=1e-12 * max(1.0, np.abs(moved).max()))


@pytest.mark.parametrize(
    "temperatures", [{"T": 800.0}, {"T_fluid": 700.0, "T_solid": 900.0}]
)
@pytest.mark.parametrize("stored", [False, True], ids=["at once", "stored"])
def test_fluxes_of_damping_carry_their_heat(stored, temperatures):
    """To rounding; where the gas fills the pores its moles go both ways. Two kinds
    together are one.
    """
    scene = hot() if len(temperatures) == 2 else one_temperature(hot())
    one, two = bed_of(scene, stored), bed_of(split(scene), stored)
    random = np.random.default_rng(7)
    values = {name: np.array([x]) for name, x in (one.entering | temperatures).items()}
    J = {
        name: random.uniform(-1.0, 1.0, 1) if name[:2] in ("g_", "n_") else np.zeros(1)
        for name in values
    }

    def damped(problem, shares):
        def of(table):
            """The fluxes of each kind are its share, its temperature is that of
            both.
            """
            names = {
                f"{name}_{kind}": (name, share)
                for kind, share in shares.items()
                for name in table
            }
            amounts = {
                new: table[name] * (share if name[:2] == "n_" else 1.0)
                for new, (name, share) in names.items()
            }
            return [(table | amounts)[name] for name in problem.layout.names]

        return dict(
            zip(
                problem.layout.names, problem.bed.damped(of(values), of(J)), strict=True
            )
        )

    found, h = damped(one, {}), one.bed.enthalpies
    gas, solids = (
        [f"g_{name}" for name in one.layout.gases],
        [f"n_{name}" for name in one.layout.solids],
    )
    moved = {name: float(found[name][0]) for name in (*gas, *solids)}
    assert abs(sum(moved[name] for name in gas)) < 1e-15 or not stored
    assert all(moved[name] == J[name][0] for name in solids)
    heat = dict.fromkeys(temperatures, 0.0)
    for names, T in ((gas, next(iter(temperatures))), (solids, list(temperatures)[-1])):
        heat[T] += sum(moved[name] * h[name[2:]](temperatures[T]) for name in names)
    assert all(found[T][0] == pytest.approx(q, rel=1e-13) for T, q in heat.items())
    assert np.all(np.asarray(found["p"]) == 0.0)
    shares = {"coarse": 0.3, "fine": 0.7}
    both = damped(two, shares)
    for name in found:
        sums = (
            [both[name]]
            if name in both
            else [both[f"{name}_{kind}"] for kind in shares]
        )
        assert_allclose(np.sum(sums, axis=0), found[name], rtol=1e-12, atol=1e-12)


def entering(composition, initial, gases):
    scene = isothermal(composition, gases)
    set_keys(scene, "mesh.cells = 6")
    set_keys(scene, 'packed_bed.gas_storage = "stored"')
    return scene | {
        "initial": {"gas": {"composition": initial}},
        "time": {"end": RESIDENCE, "tolerance": 1e-3},
    }


def dispersed(Pe, cells=6):
    scene = danckwerts(Pe, 0.0)
    scene["mesh"]["cells"] = cells
    time = {"end": 2.0 * RESIDENCE, "tolerance": 1e-3}
    return scene | {"initial": {"gas": {"composition": "B:1"}}, "time": time}


def of_all_masses():
    """Light and heavy gases in plug flow, of which one is a trace at first."""
    return entering(
        "A:0.5, C:0.5", "B:0.999, C:0.001", species(A=0.002, B=0.028, C=0.044)
    )


def meeting():
    """A + B -> 2 P, so fast that A and B are nowhere together."""
    scene = entering("A:0.5, B:0.5", "B:1", species(A=0.028, B=0.028, P=0.028))
    return scene | {
        "reactions": {"r": {"equation": "A + B -> 2 P", "A": 5.0, "E": 0.0}}
    }


STORED = {
    "wide front": (dispersed(20.0), -1e-2),
    "steep front": (dispersed(1000.0), -0.1),
    "plug flow": (of_all_masses(), -0.1),
    "reaction": (meeting(), -0.01),
}
LONG = ("steep front", "plug flow")


@pytest.mark.parametrize(
    ("scene", "falls"),
    [
        pytest.param(*case, id=name, marks=[pytest.mark.slow] * (name in LONG))
        for name, case in STORED.items()
    ],
)
def test_no_stored_gas_falls_below_zero(monkeypatch, scene, falls):
    """Nor does one rise above 1 by more than the others may lie below zero together."""
    assert unbounded(monkeypatch, scene) < falls
    assert least_of(scene) > -LEFT
    result = contbed.run(from_dict(scene))
    assert result.qoi["steps_damped"] > 0
    assert not any("below zero" in text for text in result.warnings)
    assert_closed(result, CLOSED)
    above = LEFT * (len(scene["gas"]["species"]) - 1)
    for table in (result.profiles, result.tables["outlet"]):
        for name, column in table.items():
            if name.startswith("x_"):
                assert np.all((column > -LEFT) & (column < 1.0 + above)), name


def exactly(Pe, times):
    """What leaves a closed vessel after a step (Danckwerts 1953), at times over the
    residence.
    """

    def transform(p):
        a = np.sqrt(1.0 + 4.0 * p / Pe)
        fall = (1.0 + a) ** 2 - (1.0 - a) ** 2 * np.exp(-a * Pe)
        return 4.0 * a * np.exp(0.5 * Pe * (1.0 - a)) / fall / p

    return invert(transform, times)


@pytest.mark.slow
def test_fronts_that_are_damped_are_exact_on_finer_cells():
    """At the times of the front 1.1e-3 and 1.2e-4 are found: of order 3."""
    times, errors = np.array([0.5, 0.75, 1.0, 1.25, 1.5]), []
    for cells in (6, 12):
        scene = dispersed(20.0, cells)
        scene["time"] |= {"times": list(times * RESIDENCE), "tolerance": 3e-5}
        set_keys(scene, "output.positions = [1.0]")
        result = contbed.run(from_dict(scene))
        assert result.qoi["steps_damped"] > 0
        errors.append(
            np.abs(
                result.profiles["x_A [1]"][: len(times)] - exactly(20.0, times)
            ).max()
        )
    assert errors[0] < 2e-3
    assert errors[0] > 2.0**3 * errors[1]


def test_a_front_without_heat_leaves_the_temperature():
    """One gas displaces another whose formation takes 400 kJ/mol more: without its
    heat in the fluxes a run fails.
    """
    scene, _ = heated(4.0)
    more = {
        "elements": {"H": 28.0},
        "molar_mass": 0.028,
        "heat_capacity": 30.0,
        "enthalpy": -4e5,
    }
    scene["gas"] |= {
        "composition": "B:1",
        "species": scene["gas"]["species"] | {"B": more},
    }
    set_keys(
        scene,
        """
        boundary.left.gas.temperature = 300.0
        mesh.cells = 6
        time.end = 0.15
        packed_bed.gas_storage = "stored"
        initial.gas = { composition = "A:1" }
        """,
    )
    result = contbed.run(from_dict(scene))
    assert result.qoi["steps_damped"] > 50
    for name in ("T_fluid [K]", "T_solid [K]"):
        assert_allclose(result.profiles[name], 300.0, atol=1e-6)
    assert_closed(result, CLOSED, "energy")


def test_a_gas_that_has_come_to_rest_takes_long_steps():
    """A -> B -> C: B and C are zero where the gas enters, and damped there for ever; 45
    residences take 4 steps.

    Damping that comes and goes takes ten thousand.
    """
    scene = entering("A:1", "A:1", species(A=0.028, B=0.028, C=0.028))
    scene["reactions"] = {"first": {"equation": "A -> B", "A": 10.0, "E": 0.0}}
    scene["reactions"]["second"] = {"equation": "B -> C", "A": 10.0, "E": 0.0}
    scene["time"]["end"] = 50.0 * RESIDENCE
    result = contbed.run(from_dict(scene))
    times = result.tables["outlet"]["t [s]"]
    assert result.qoi["cells_damped"] > 0
    assert np.count_nonzero(times > 5.0 * RESIDENCE) < 40
