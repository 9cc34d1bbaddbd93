"""Radiation beside the two-energy equations: limits, balances, symmetry, temperatures
far apart, steps in time.

Balances and identities close to 1e-10 of their largest part, as everywhere; other
tolerances are stated in each test.
"""

from typing import Any

import marching
import numpy as np
import pytest
from moving_beds import moving, started
from numpy.testing import assert_allclose
from pytest import approx
from test_balance import EQUAL, MESHES, SIDES, SOLID, brinkman, closed, ends, run, walls
from test_balance import scene as bed

import contbed as cb
from contbed.closures.optics import SIGMA
from contbed.errors import ConvergenceError
from contbed.fem.probe import Probe
from contbed.loading import from_dict
from contbed.models import plan
from contbed.output.progress import Progress
from contbed.packed_bed.heat import HeatProblem
from contbed.solvers.linear import Policy
from studies._exact.conduction_radiation import conduction_diffusion
from studies._exact.manufactured import observed_order
from tests.refusals import refused
from tests.restarts import interrupt
from tests.scene_text import scene_of

OPTICS = {"absorption": 8.0, "scattering": 2.0}
HOT, COLD = 1500.0, 400.0


def wall(T: float, emissivity: float = 0.8) -> dict[str, float]:
    return {"temperature": T, "emissivity": emissivity}


def radiating(
    mesh: str = "line", *, level: str = "p1", sides: bool = True, **tables: Any
) -> dict[str, Any]:
    """The bed of the balances with solid entering hot, radiating ends, and cold
    radiating walls along it.
    """
    low, high = ends(mesh)
    boundary = {
        low: {
            "gas": {"temperature": COLD},
            "solids": {"particles": {"temperature": HOT}},
            "radiation": wall(HOT),
        },
        high: {"radiation": wall(900.0, 0.5)},
    }
    if sides:
        boundary |= {name: {"radiation": wall(600.0, 0.9)} for name in walls(mesh)}
    values = bed(mesh, boundary=boundary, radiation={"level": level, **OPTICS})
    return {**values, **tables}


def posed(values: dict[str, Any]) -> HeatProblem:
    return HeatProblem(plan(from_dict(values)))


def values_at(
    result: Any, points: np.ndarray, names: tuple[str, ...] = ("T_fluid", "T_solid")
) -> np.ndarray:
    """Fields at points (dim, n)."""
    probe = Probe(result.plan.mesh, points)
    return np.array([probe(*result.nodal[name]) for name in names])


def standing(
    tau: float, N: float, cells: int = 100, level: str = "p1", **optics: float
) -> dict[str, Any]:
    """A bed at rest between walls at 1000 and 500 K, without exchange: a medium that
    conducts and radiates.
    """
    k = N * 4.0 * SIGMA * 1000.0**3 / tau
    boundary = {
        side: {
            "gas": {"fixed_temperature": 500.0},
            "solids": {"particles": {"fixed_temperature": T}},
            "radiation": wall(T, 1.0),
        }
        for side, T in (("left", 1000.0), ("right", 500.0))
    }
    values = bed(velocity=0.0, velocity_solid=0.0, boundary=boundary)
    values["closures"] = {"nusselt": 0.0, "conductivity_solids": k}
    values["mesh"] = {"type": "line", "length": 1.0, "cells": cells, "graded": True}
    return {
        **values,
        "radiation": {"level": level, "absorption": tau, "scattering": 0.0, **optics},
    }


# limits


@pytest.mark.parametrize("level", ["p1", "two_flux"])
@pytest.mark.parametrize("tau", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("N", [0.01, 1.0])
def test_without_exchange_it_is_the_medium_alone(level, tau, N):
    """Heat fluxes as by collocation to 1e-7, what 100 quadratic cells give, and as
    those of [radiation] alone.
    """
    values = standing(tau, N, level=level)
    result = closed(run(values))
    flux = conduction_diffusion(
        tau, N, 0.5, 0.25 if level == "two_flux" else 1 / 3
    ).total
    assert result.qoi["heat_left_W"] / (SIGMA * 1000.0**4) == approx(flux, rel=1e-7)
    alone = {
        "mesh": values["mesh"],
        "boundary": {
            side: {"radiation": table["radiation"]}
            for side, table in values["boundary"].items()
        },
        "radiation": {
            **values["radiation"],
            "conductivity": values["closures"]["conductivity_solids"],
        },
    }
    reference = run(alone)
    assert result.qoi["heat_left_W"] == approx(reference.qoi["heat_left_W"], rel=1e-7)
    x = np.linspace(0.0, 1.0, 23)[None]
    both = ("T_solid", "G")
    # the quadrature of T^4 differs, [radiation] alone takes two orders more: a few
    # times the error of the cells
    assert_allclose(
        values_at(result, x, both), values_at(reference, x, both), rtol=1e-7
    )


def test_thick_beds_tend_to_the_rosseland_conductivity():
    """The jump at walls is a mean free path thin: the difference of heat fluxes
    falls as 1/tau, order 1 to 0.1.
    """
    sizes, errors = [1e-2, 5e-3, 2.5e-3], []
    for size in sizes:
        tau = 1.0 / size
        values = standing(tau, 1e-2, 200)
        flux = run(values).qoi["heat_left_W"]
        thick = {**values, "radiation": {**values["radiation"], "level": "rosseland"}}
        for side in ("left", "right"):
            thick["boundary"][side].pop("radiation")
        limit = run(thick).qoi["heat_left_W"]
        errors.append(abs(flux / limit - 1.0))
    assert observed_order(errors, sizes) == approx(1.0, abs=0.1)


@pytest.mark.parametrize("mesh", ["line", "triangles", "axisymmetric", "box"])
@pytest.mark.parametrize("time", [None, {"end": 5e3}], ids=["steady", "time"])
def test_a_closed_hot_bed_stays_uniform(mesh, time):
    """Walls are mirrors or as hot as the bed; to the accuracy of the linear solves,
    1e-9 K and as much in G.
    """
    values = radiating(mesh)
    low, high = ends(mesh)
    streams = {
        "gas": {"temperature": HOT},
        "solids": {"particles": {"temperature": HOT}},
    }
    values["boundary"] = moving(
        MESHES[mesh], {low: streams, high: {"radiation": wall(HOT)}}, 0.2, 1e-4
    )
    if time is not None:
        values |= {"time": time, "initial": started(HOT, HOT)}
    result = run(values)
    for name in ("T_fluid", "T_solid"):
        assert_allclose(result.nodal[name][1], HOT, rtol=0, atol=2 * EQUAL)
    assert_allclose(result.nodal["G"][1], 4.0 * SIGMA * HOT**4, rtol=1e-11)


# balances


@pytest.mark.parametrize("level", ["p1", "two_flux"])
@pytest.mark.parametrize("velocity_solid", [1e-4, -1e-4])
def test_balances_on_a_line(level, velocity_solid):
    values = radiating(level=level)
    if velocity_solid < 0:
        values["boundary"]["right"]["solids"] = values["boundary"]["left"].pop("solids")
    closed(run(values))


@pytest.mark.parametrize("mesh", [name for name in MESHES if name != "line"])
@pytest.mark.parametrize(
    "time", [None, {"end": 2e3, "step": 4e2}], ids=["steady", "time"]
)
def test_balances_on_every_mesh(mesh, time):
    values = radiating(mesh)
    if time is not None:
        values |= {"time": time, "initial": started(500.0, 1200.0)}
    result = closed(run(values))
    low, high = ends(mesh)
    assert result.plan.mesh.skfem.dim() > 1 and {"G", "T_solid"} <= set(result.nodal)
    if time is None:
        heat = [result.qoi[f"heat_{name}_W"] for name in (low, high, *walls(mesh))]
        assert abs(sum(heat)) <= 1e-10 * max(map(abs, heat))


@pytest.mark.parametrize("mesh", ["rectangle", "triangles", "axisymmetric"])
def test_balances_with_computed_flow(mesh):
    values = brinkman(mesh, (COLD, HOT, 600.0), radiation=OPTICS)
    for name in walls(mesh):
        values["boundary"][name]["radiation"] = wall(600.0)
    result = closed(run(values))
    assert "p [Pa]" in result.profiles and "G [W/m2]" in result.profiles
    uniform = brinkman(mesh, (HOT, HOT, HOT), radiation=OPTICS)
    for name in walls(mesh):
        uniform["boundary"][name]["radiation"] = wall(HOT)
    still = run(uniform)
    for name in ("T_fluid", "T_solid"):
        assert_allclose(still.nodal[name][1], HOT, rtol=0, atol=2 * EQUAL)


SPECIES: dict[str, dict[str, Any]] = scene_of(
    """
        [char]
        diameter = 0.02
        emissivity = 0.9
        temperature = 1400.0

        [limestone]
        diameter = 0.03
        emissivity = 0.6
        temperature = 1100.0
    """,
    {
        "char.volume_share": 1 / 6,
        "limestone.volume_share": 1 / 3,
        "particles": {
            "volume_share": 0.5,
            "diameter": 0.05,
            "emissivity": 0.8,
            **SOLID,
        },
    },
)


@pytest.mark.parametrize(
    "time", [None, {"end": 2e3, "step": 4e2}], ids=["steady", "time"]
)
def test_species_of_given_temperature(time):
    """What they give off is part of the balance; all species together radiate what
    leaves through the walls.
    """
    values = radiating(radiation={}, solids=SPECIES)
    if time is not None:
        values |= {"time": time, "initial": started(500.0, 1200.0)}
    result = closed(run(values))
    problem = posed(values)
    state = np.concatenate([result.nodal[name][1] for name in problem.system.fields])
    optics = [
        1.5 * 0.6 * s["volume_share"] / s["diameter"] / 0.4 * s["emissivity"]
        for s in SPECIES.values()
    ]
    T = [1400.0, 1100.0, None]

    def radiated(unknowns: Any, o: Any) -> Any:
        return sum(
            K
            * (
                4.0 * SIGMA * (unknowns.T_solid if given is None else given) ** 4
                - unknowns.G
            )
            for K, given in zip(optics, T, strict=True)
        )

    total = problem.system.integrate(radiated, [problem.system.cells], state)
    leaving = -sum(
        flux["radiation"]
        for name, flux in problem.fluxes(state).items()
        if name in ("left", "right")
    )
    scale = problem.system.integrate(
        lambda u, o: optics[2] * 4.0 * SIGMA * u.T_solid**4,
        [problem.system.cells],
        state,
    )
    # the share of the walls in emission, to the convergence of Newton
    assert abs(total - leaving) <= 1e-10 * scale


def test_species_of_one_temperature_are_one_species():
    """Three that share the solved temperature, and their optics given directly: the
    same matrix, 1e-9 K.
    """
    free = {
        name: {k: v for k, v in item.items() if k != "temperature"}
        for name, item in SPECIES.items()
    }
    kappa = {
        name: 1.5 * 0.6 * item["volume_share"] / item["diameter"] / 0.4
        for name, item in free.items()
    }
    absorption = sum(kappa[name] * item["emissivity"] for name, item in free.items())
    direct = {"absorption": absorption, "scattering": sum(kappa.values()) - absorption}
    bare = {
        "particles": {
            key: value
            for key, value in free["particles"].items()
            if key != "emissivity"
        }
    }
    one = run(radiating(radiation={}, solids=free))
    other = run(radiating(radiation=direct, solids=bare))
    x = np.linspace(0.0, 1.0, 23)[None]
    assert_allclose(values_at(one, x), values_at(other, x), rtol=0, atol=EQUAL)


# symmetry


def test_mirrored_bed():
    x = np.linspace(0.0, 1.0, 37)[None]
    values = radiating()
    there = run(values)
    swapped = {"left": values["boundary"]["right"], "right": values["boundary"]["left"]}
    back = run({**values, "boundary": swapped})
    assert_allclose(values_at(there, x), values_at(back, 1.0 - x), rtol=0, atol=EQUAL)
    G = [values_at(result, at, ("G",)) for result, at in ((there, x), (back, 1.0 - x))]
    assert_allclose(*G, rtol=1e-11)


def test_the_axes_of_a_box_are_alike():
    points = np.random.default_rng(2).uniform(0.02, 0.48, (3, 40))
    found = []
    for axis in range(3):
        vector = [float(k == axis) for k in range(3)]
        low, high = SIDES[axis]
        boundary = {
            low: {
                "gas": {"temperature": COLD},
                "solids": {"particles": {"temperature": HOT}},
                "radiation": wall(HOT),
            },
            high: {"radiation": wall(900.0)},
            SIDES[(axis + 1) % 3][0]: {"radiation": wall(500.0, 0.4)},
        }
        mesh = {
            "type": "box",
            "length": 0.5,
            "width": 0.5,
            "height": 0.5,
            "cells": [3, 3, 3],
        }
        boundary = moving(
            mesh, boundary, [0.2 * v for v in vector], [1e-4 * v for v in vector]
        )
        result = closed(run({**radiating(), "mesh": mesh, "boundary": boundary}))
        found.append(values_at(result, np.roll(points, axis, axis=0)))
    for other in found[1:]:
        assert_allclose(other, found[0], rtol=0, atol=EQUAL)


def test_one_dimension_stands_for_two_and_three():
    x = np.linspace(0.0, 1.0, 29)
    plain = {"solver": {"stabilisation": False}}
    reference = values_at(run(radiating(**plain)), x[None])
    for mesh in ("rectangle", "axisymmetric", "box"):
        cells = (
            [2, 12]
            if mesh == "axisymmetric"
            else [12, *[2] * (len(MESHES[mesh]["cells"]) - 1)]
        )
        values = radiating(
            mesh, sides=False, solver={"stabilisation": False, "reduce": False}
        )
        result = closed(run({**values, "mesh": {**MESHES[mesh], "cells": cells}}))
        across = [np.full_like(x, 0.1)] * (len(cells) - 1)
        at = np.array([*across, x] if mesh == "axisymmetric" else [x, *across])
        assert_allclose(values_at(result, at), reference, rtol=0, atol=EQUAL)


# temperatures far apart


GAS = {"model": "cantera", "composition": "N2:0.79, O2:0.21"}
POLYNOMIAL = {
    "density": 2000.0,
    "heat_capacity": [600.0, 0.4],
    "conductivity": [0.5, 1e-3],
}
MOTIONS = {
    "at rest": (0.0, 0.0),
    "gas": (0.5, 0.0),
    "co-current": (0.5, 1e-3),
    "counter-current": (0.5, -1e-3),
}
STEPS = 12  # of Newton at most, without continuation, on each mesh


def furnace(
    tau: float,
    albedo: float,
    motion: str,
    walls: float,
    gas: float,
    emissivity: float = 0.8,
    N: float | None = None,
    **tables: Any,
) -> dict[str, Any]:
    """One metre of bed between walls of one temperature, with gas of another; N = k
    beta/(4 sigma T^3).
    """
    velocity, velocity_solid = MOTIONS[motion]
    left: dict[str, Any] = {
        "radiation": wall(walls, emissivity),
        "gas": {"temperature" if velocity else "fixed_temperature": gas},
    }
    right: dict[str, Any] = {"radiation": wall(walls if velocity else gas, emissivity)}
    if velocity_solid:
        end = left if velocity_solid > 0 else right
        end["solids"] = {"particles": {"temperature": gas}}
    values = bed(
        velocity=velocity,
        velocity_solid=velocity_solid,
        boundary={"left": left, "right": right},
        **tables,
    )
    values |= {
        "mesh": {"type": "line", "length": 1.0},
        "radiation": {"absorption": tau * (1.0 - albedo), "scattering": tau * albedo},
    }
    if N is not None:
        values["closures"]["conductivity_solids"] = (
            N * 4.0 * SIGMA * max(walls, gas) ** 3 / tau
        )
    return values


def at_once(
    values: dict[str, Any], monkeypatch: pytest.MonkeyPatch, overshoot: float = 1e-6
) -> Any:
    """Run where continuation is not allowed; bounds of theta hold and no mesh takes
    more than STEPS of Newton.
    """

    def refuse(*arguments: Any, **options: Any) -> None:
        raise ConvergenceError("continuation was needed")

    monkeypatch.setattr("contbed.solvers.continuation.relax", refuse)
    result = closed(run(values))
    assert result.qoi["theta_overshoot"] <= overshoot
    assert len(result.history) <= (STEPS + 1) * (result.adaptations + 1)
    return result


@pytest.mark.parametrize("tau", [0.1, 1.0, 10.0, 400.0])
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize(
    ("walls", "gas"), [(2500.0, 300.0), (300.0, 2500.0), (1000.0, 300.0)]
)
def test_cold_starts(tau, motion, walls, gas, monkeypatch):
    for albedo in (0.0, 0.9):
        at_once(furnace(tau, albedo, motion, walls, gas), monkeypatch)


@pytest.mark.parametrize("N", [1e-4, 1e-2, 1.0, 10.0])
@pytest.mark.parametrize("tau", [0.1, 10.0, 400.0])
@pytest.mark.parametrize("motion", ["at rest", "gas"])
def test_weak_and_strong_conduction(N, tau, motion, monkeypatch):
    at_once(furnace(tau, 0.0, motion, 1500.0, 300.0, N=N), monkeypatch)


@pytest.mark.parametrize("emissivity", [1e-6, 0.1, 1.0])
@pytest.mark.parametrize("albedo", [0.0, 1.0 - 1e-9])
def test_mirrors_and_scattering(emissivity, albedo, monkeypatch):
    at_once(
        furnace(10.0, albedo, "gas", 2000.0, 300.0, emissivity=emissivity), monkeypatch
    )


@pytest.mark.parametrize("tau", [1.0, 400.0])
@pytest.mark.parametrize("motion", ["gas", "co-current", "counter-current"])
@pytest.mark.parametrize(("walls", "gas"), [(2500.0, 300.0), (300.0, 2500.0)])
def test_real_gas_and_solid(tau, motion, walls, gas, monkeypatch):
    values = furnace(tau, 0.2, motion, walls, gas, solid=POLYNOMIAL)
    at_once({**values, "gas": GAS}, monkeypatch)


@pytest.mark.parametrize("degree", [2, 3])
def test_incident_radiation_may_undershoot(degree, monkeypatch):
    """Few cells at a hot corner: G falls below 0 on the way and in a few nodes, and
    temperatures still converge.
    """
    values = furnace(
        160.0,
        0.2,
        "counter-current",
        350.0,
        300.0,
        1.0,
        solid=POLYNOMIAL,
        solver={"degree": degree},
    )
    values["mesh"] = {
        "type": "rectangle",
        "length": 1.0,
        "height": 0.4,
        "cells": [16, 10],
        "graded": True,
    }
    values["boundary"]["top"] = {"radiation": wall(2330.0)}
    assert (
        at_once(values, monkeypatch, overshoot=1e-2).nodal["G"][1].max()
        <= 4.0 * SIGMA * 2330.0**4
    )


def test_real_gas_at_rest_with_a_closure_of_the_flow(monkeypatch):
    values = furnace(1.0, 0.2, "at rest", 2000.0, 300.0)
    values |= {"gas": GAS, "closures": {"nusselt": "wakao_kaguei"}}
    at_once(values, monkeypatch)


def radiative_heat(values: dict[str, Any]) -> np.ndarray:
    """Radiation into the bed through each radiating boundary [W]."""
    result = run(values)
    problem = HeatProblem(result.plan)
    state = np.concatenate([result.nodal[name][1] for name in problem.system.fields])
    return np.array(
        [
            flux["radiation"]
            for flux in problem.fluxes(state).values()
            if "radiation" in flux
        ]
    )


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("albedo", [0.0, 0.8])
def test_wall_fluxes_of_a_thick_bed(motion, albedo):
    """400 mean free paths: 1e-5 of the flux at each wall on the automatic mesh."""
    values = furnace(400.0, albedo, motion, 1500.0, 300.0)
    fine = {**values, "solver": {"tolerance": 1e-8, "degree": 3}}
    assert_allclose(radiative_heat(values), radiative_heat(fine), rtol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["at rest", "gas"])
def test_wall_fluxes_of_a_thick_bed_in_the_plane(motion):
    """Given cells, graded, and a third wall: corners between walls of unlike
    temperature take more cells than a line. 60 x 42 quadratic cells reach 1e-5 of the
    largest flux.
    """
    values = furnace(400.0, 0.0, motion, 1500.0, 300.0)
    values["boundary"]["top"] = {"radiation": wall(900.0, 0.5)}
    mesh = {"type": "rectangle", "length": 1.0, "height": 0.5, "graded": True}
    found = radiative_heat({**values, "mesh": {**mesh, "cells": [60, 42]}})
    fine = radiative_heat(
        {**values, "mesh": {**mesh, "cells": [72, 52]}, "solver": {"degree": 3}}
    )
    assert_allclose(found, fine, rtol=0, atol=1e-5 * np.abs(fine).max())


# steps in time


def heating(**time: Any) -> dict[str, Any]:
    """A thin bed at rest that radiating walls heat; starts smoothly, as orders in
    time ask for.
    """
    boundary = {
        "left": {"radiation": wall(HOT)},
        "right": {"radiation": wall(900.0, 0.5)},
    }
    boundary["left"]["gas"] = {"coefficient": 5.0, "ambient": COLD}
    values = bed(velocity=0.0, velocity_solid=0.0, boundary=boundary)
    values |= {
        "radiation": {"absorption": 1.5, "scattering": 0.5},
        "mesh": {**MESHES["line"], "cells": 8},
    }
    return {
        **values,
        "initial": {
            "gas": {"temperature": 500.0},
            "solids": {"particles": {"temperature": 500.0}},
        },
        "time": {"end": 4e3, **time},
    }


def test_incident_radiation_starts_consistently():
    problem = posed(heating())
    state = problem.begin(Policy(1))
    residual = problem.steady(state, False)[0]
    G = problem.system.part(residual, "G")
    assert np.abs(G).max() <= 1e-12 * np.abs(residual).max()
    assert np.all(problem.system.part(state, "T_solid") == 500.0)


def last(values: dict[str, Any], steps: int | None = None) -> np.ndarray:
    problem = posed(values)
    time, policy = values["time"], Policy(1)
    low, high = problem.T_span
    step = None if steps is None else time["end"] / steps
    tolerance = time.get("tolerance", 1e-4)
    options = {"tolerance": tolerance, "span": high - low, "step": step}
    start = problem.begin(policy)
    final = marching.last(problem, start, policy, time["end"], **options)
    return final * problem.weights


@pytest.mark.slow
def test_steps_are_of_second_order():
    """Temperatures and G by successive differences, order 2 to 0.1."""
    coarse, middle, fine = (last(heating(), steps) for steps in (32, 64, 128))
    differences = [np.abs(coarse - middle).max(), np.abs(middle - fine).max()]
    assert observed_order(differences, [1.0, 0.5])[0] == approx(2.0, abs=0.1)


@pytest.mark.slow
def test_the_error_of_a_step_is_controlled():
    """The tolerance bounds the error of one step; over the run it adds up to less
    than ten times as much.
    """
    reference = last(heating(tolerance=1e-7))
    problem = posed(heating())
    low, high = problem.T_span
    for tolerance in (1e-3, 1e-4):
        error = np.abs(last(heating(tolerance=tolerance)) - reference).max() / (
            high - low
        )
        assert error <= 10 * tolerance


def test_the_end_of_a_long_run_is_the_steady_state():
    slow = run(heating(end=1e8, tolerance=1e-3))
    steady = run({key: table for key, table in heating().items() if key != "time"})
    for name, rtol in (("T_fluid", 1e-8), ("T_solid", 1e-8), ("G", 1e-7)):
        assert_allclose(slow.nodal[name][1], steady.nodal[name][1], rtol=rtol)


def test_a_restart_repeats_the_same_numbers(tmp_path):
    values = heating(times=[1e3])
    whole, scene = run(values), from_dict(values)
    half = whole.qoi["time_steps"] // 2
    interrupt(scene, tmp_path, Progress, "advance_to", half)
    resumed = cb.run(scene, tmp_path, restart=tmp_path)
    for name in ("T_fluid", "T_solid", "G"):
        assert np.array_equal(resumed.nodal[name][1], whole.nodal[name][1])


def species_bed(level="p1", **radiation):
    """Gas through ore at the temperature of the bed beside coke at 1173.15 K; the
    wall at the outlet is 1300 K hot.
    """
    kind = {"volume_share": 0.5, "diameter": "8 mm", "emissivity": 0.8}
    ore = kind | {"density": 2000.0, "heat_capacity": 800.0, "conductivity": 1.0}
    return scene_of(
        """
            mesh = { type = "line", length = 0.5 }
            packed_bed = { porosity = 0.4 }
            closures = { nusselt = "wakao_kaguei" }
            heat = {}

            [gas]
            density = 1.0
            viscosity = 2e-5
            heat_capacity = 1000.0
            conductivity = 0.05

            [boundary]
            left = { gas = { velocity = 0.5, temperature = 573.15 } }

            [boundary.right]
            radiation = { temperature = 1300.0 }
            solids = { ore = { fixed_temperature = 1300.0 } }
        """,
        {
            "solids.ore": ore,
            "solids.coke": kind | {"temperature": "900 degC"},
            "radiation": {"level": level, **radiation},
        },
    )


def test_heat_of_species_is_a_result():
    """What the boundaries and the coke supply adds up to nothing, to the balance of
    1e-10.
    """
    heats = cb.run(from_dict(species_bed())).qoi
    found = [heats[f"heat_{name}_W"] for name in ("left", "right", "species")]
    assert abs(sum(found)) < 1e-9 * max(map(abs, found))
    assert heats["heat_species_W"] > 1e4  # the gas enters 600 K colder than the coke


def test_rosseland_has_no_species_of_its_own_temperature():
    """It would leave their heat out."""
    refused(
        r"solids\.coke\.temperature.*the temperature of the solid",
        lambda: from_dict(species_bed("rosseland")),
    )
