"""Reacting beds resolved across the flow: closed forms, manufactured solutions,
limits, balances, mistakes.
"""

from __future__ import annotations

import numpy as np
import pytest
from adsorption_scenes import TRACE, adsorber
from manufactured_section import error, solution
from pytest import approx
from reacting_bed_scenes import R_GAS, P, T, isothermal, let_move
from scipy.optimize import brentq
from scipy.special import j0, j1
from solving import solved

from contbed.closures import get
from contbed.loading import from_dict
from contbed.reacting_bed.equations.section import Section
from contbed.reacting_bed.plan import plan
from contbed.reacting_bed.radial_need import across
from contbed.reacting_bed.solve import Report, march
from tests.cases import each_case
from tests.refusals import refused
from tests.scene_text import changed, set_keys

CP, U, RADIUS, T_WALL, K = 30.0, 0.5, 0.05, 800.0, 2.0
POROSITY, DENSITY, C_SOLID = 0.4, 2000.0, 1000.0


def heated(rings, shape="tube", wall=50.0, conductivity=K, reacts=0.0):
    """A bed of 1 m between walls at a temperature; A -> B if it reacts."""
    data = {"elements": {"H": 28.0}, "molar_mass": 0.028, "heat_capacity": CP}
    scene = isothermal(
        "A:1", {"A": {**data, "enthalpy": 0.0}, "B": {**data, "enthalpy": -4e3}}
    )
    scene["reactions"] = {"r": {"equation": "A -> B", "A": reacts, "E": 3e4}}
    set_keys(scene, "heat = {}")
    set_keys(scene, "mesh.cells = 8")
    scene["mesh"]["diameter"] = 2 * RADIUS
    scene["boundary"]["wall"] = {"coefficient": wall, "ambient": T_WALL}
    if rings:
        scene["packed_bed"]["section"] = {
            "shape": shape,
            "rings": rings,
            "conductivity_solids": conductivity,
        }
    set_keys(scene, "output.positions = [0.5, 1.0]")
    return scene


def mean_of_series(shape, wall, Fo):
    """Mean temperature after a Fourier number K t/(C R^2), of bodies at T that are
    heated through their surfaces.
    """
    Bi, most = wall * RADIUS / K, 60.0
    if shape == "tube":
        crossing = lambda b: b * j1(b) - Bi * j0(b)  # noqa: E731
        share = lambda b: 4.0 * Bi**2 / (b**2 * (b**2 + Bi**2))  # noqa: E731
    else:
        crossing = lambda b: b * np.sin(b) - Bi * np.cos(b)  # noqa: E731
        share = lambda b: 2.0 * Bi**2 / (b**2 * (b**2 + Bi**2 + Bi))  # noqa: E731
    grid = np.linspace(1e-6, most, 3000)
    signs = np.flatnonzero(np.diff(np.sign(crossing(grid))))
    roots = np.array(
        [brentq(crossing, grid[k], grid[k + 1], xtol=1e-14) for k in signs]
    )
    return T_WALL + (T - T_WALL) * float(share(roots) @ np.exp(-(roots**2) * Fo))


def mixed(shape, wall, x):
    """Mean temperature of plug flow of constant properties that enters at T, heated
    through its walls (Graetz).
    """
    capacity = U * P / (R_GAS * T) * CP  # [W/m2/K]
    return mean_of_series(shape, wall, K * x / (capacity * RADIUS**2))


@pytest.mark.parametrize("shape", ["tube", "plane"])
def test_plug_flow_between_walls(shape):
    """Graetz's problem of plug flow with a wall coefficient: order 2 across; 0.4 K
    of 300 K with 8 rings.
    """
    exact = np.array([mixed(shape, 50.0, x) for x in (0.5, 1.0)])
    coarse, fine = (
        solved(heated(rings, shape)).profiles["T_fluid [K]"] - exact for rings in (4, 8)
    )
    assert np.all(np.log2(coarse / fine) == approx(2.0, abs=0.1))
    assert np.abs(fine).max() < 0.5


def test_plug_flow_in_a_duct_is_that_of_two_planes():
    """Heat passes along y and z alike: (T - T_a)/(T_in - T_a) is the product of those
    between plane walls.

    With discrete columns as well, for the mean and in the middle of a side; 1e-6 of 300
    K is the error along the flow.
    """
    duct, plane = (solved(heated(4, shape)).profiles for shape in ("duct", "plane"))
    share = {
        key: (
            (duct[f"T_fluid{key} [K]"] - T_WALL) / (T - T_WALL),
            (plane[f"T_fluid{key} [K]"] - T_WALL) / (T - T_WALL),
        )
        for key in ("", "_axis", "_wall")
    }
    assert np.all(share[""][1] < 0.95)
    assert share[""][0] == approx(share[""][1] ** 2, abs=1e-6)
    assert share["_axis"][0] == approx(share["_axis"][1] ** 2, abs=1e-6)
    assert share["_wall"][0] == approx(share["_wall"][1] * share["_axis"][1], abs=1e-6)


def test_a_duct_is_the_same_along_y_and_z():
    """A reacting bed with species that pass across: columns (i, j) and (j, i) agree
    to Newton's tolerance.
    """
    scene = heated(3, "duct", reacts=400.0)
    set_keys(scene, "packed_bed.section.dispersion_mass = 1e-4")
    problem, u = solved(scene).solved
    columns = u.reshape(3, 3, len(problem.layout.names), -1)
    assert np.ptp(columns[..., problem.layout.names.index("g_B"), -1]) > 0.01
    assert np.abs(columns - columns.swapaxes(0, 1)).max() < 1e-9 * np.abs(u).max()


MU, K_GAS, D_P = 3e-5, 0.04, 3e-3


@pytest.mark.parametrize("name", ["wall_martin_nilles", "wall_li_finlayson"])
def test_wall_coefficient_by_name(name):
    """With constant properties it is a number, from Re = G d_p/mu, Pr = c mu/k, the
    conductivity without dispersion.
    """
    scene = heated(6, wall=1.0)
    scene["gas"] |= {"viscosity": MU, "conductivity": K_GAS}
    set_keys(scene, "packed_bed.section.dispersion = 0.5")
    flux = U * P / (R_GAS * T) * 0.028
    known = {
        "Re": flux * D_P / MU,
        "Pr": CP / 0.028 * MU / K_GAS,
        "k_fluid": K_GAS,
        "d_p": D_P,
        "D_bed": 2 * RADIUS,
    }
    stagnant = {"k_stagnant": K} if name == "wall_martin_nilles" else {}
    scene["boundary"]["wall"]["coefficient"] = float(
        get(name, "wall")(**known, **stagnant)
    )
    expected = solved(scene)
    scene["boundary"]["wall"]["coefficient"] = name
    found = solved(scene)
    # Newton's
    np.testing.assert_allclose(
        found.profiles["T_fluid [K]"], expected.profiles["T_fluid [K]"], rtol=1e-11
    )
    assert {use["name"] for use in found.closures} == {name}


def test_the_wall_meets_the_outermost_ring():
    """Where viscosity follows T, the temperature at the axis leaves the heat through
    the wall as it is, to rounding.
    """
    scene = heated(2, wall="li_finlayson")
    scene["gas"]["conductivity"] = K_GAS
    for gas in scene["gas"]["species"].values():
        gas["viscosity"] = [6e-8, 1.0]  # 6e-8 T
    problem = plan(from_dict(scene)).problem
    section, rings, k = (
        Section(problem.bed, problem.rings),
        problem.rings,
        problem.layout.names.index("T"),
    )

    def gains(T_axis):
        points = np.array([problem.first_point()] * 2, dtype=float)
        points[:, k] = T_axis, 600.0
        values = [np.array([value]) for value in points.ravel()]
        outer = section(values, [0.0 * value for value in values], np.zeros(1))[2][
            len(problem.layout.names) + k
        ]
        return (
            float(outer[0])
            - K * (T_axis - 600.0) * rings.joins[0].area / rings.shares[1]
        )

    assert gains(700.0) == approx(gains(500.0), rel=1e-12)


def test_dispersion_between_rings_moves_no_mass():
    """What species of unlike dispersion and molar mass carry across a face sums to
    no mass, to rounding.
    """
    scene = heated(2)
    set_keys(
        scene,
        """
        gas.composition = "A:0.5, B:0.5"
        gas.species.B.elements = { H = 44.0 }
        gas.species.B.molar_mass = 0.044
        reactions = {}
        """,
    )
    problem = plan(from_dict(scene)).problem
    section, names = Section(problem.bed, problem.rings), problem.layout.names
    points = np.array([problem.first_point()] * 2, dtype=float)
    points[1, names.index("g_A")] *= 0.3
    state = problem.bed.state([np.array(pair) for pair in points.T])
    moved = section._moved(state, {"A": 1e-3, "B": 4e-3}, 0, 1)
    parts = np.array([problem.bed.masses[name] * moved[name][0] for name in ("A", "B")])
    assert abs(parts).min() > 0.0
    assert abs(parts.sum()) < 1e-14 * abs(parts).max()


def test_temperature_of_the_wall_carries_its_heat():
    """Far from the inlet with a given flux T rises by q R/(2 K) from the axis to the
    wall: a parabola, exact.
    """
    scene = heated(5)
    scene["mesh"]["diameter"] = 2 * RADIUS
    set_keys(scene, "boundary.wall = { heat_flux = 300.0 }")
    scene["mesh"]["length"], scene["output"]["positions"] = 10.0, [10.0]
    result = solved(scene)
    difference = (
        result.profiles["T_fluid_wall [K]"] - result.profiles["T_fluid_axis [K]"]
    )
    assert difference == approx(300.0 * RADIUS / (2.0 * K), rel=1e-6)


@pytest.mark.parametrize("shape", ["tube", "plane"])
def test_order_across(shape):
    (coarse, _), (fine, iterations) = error(shape, 6, 3, 4), error(shape, 12, 3, 4)
    assert np.log2(coarse / fine) == approx(2.0, abs=0.15)
    assert iterations < 7  # the Jacobian is exact


@pytest.mark.parametrize("shape", ["tube", "plane", "duct"])
def test_the_error_of_rings_is_estimated(shape):
    """Against the series of the section, in a short bed: within a third. What a duct
    lacks to T_WALL is the square of that between planes.
    """
    length, wall = 0.2, 50.0
    scene = heated(4 if shape == "duct" else 8, shape, wall)
    scene["mesh"]["length"], scene["output"]["positions"] = length, [length]
    result = solved(scene)
    exact = mixed("tube" if shape == "tube" else "plane", wall, length)
    if shape == "duct":
        exact = T_WALL + (exact - T_WALL) ** 2 / (T - T_WALL)
    wrong = abs(result.qoi["T_fluid_out_K"] - exact) / (exact - T)
    assert wrong > 1e-3
    assert result.qoi["estimated_error_section"] == approx(wrong, rel=1 / 3)


def test_too_few_rings_bring_a_warning():
    scene = heated(4)
    scene["mesh"]["length"], scene["output"]["positions"] = 0.02, [0.02]
    warnings = solved(scene).warnings
    assert any("rings = 4: the error across the flow is" in text for text in warnings)


@pytest.mark.parametrize("degree", [1, 2])
def test_order_along(degree):
    """Polynomials of degree p: order p + 1 of all fields, against a fine line with the
    same rings.

    Differences between the rings vanish within some centimetres, which coarse cells do
    not see: 0.15 below is found.
    """
    best, u = solution("tube", 2, 30, 5)[:2]
    found = []
    for cells in (32, 64):
        problem, v = solution("tube", 2, cells, degree)[:2]
        line = problem.line
        wrong = v - best.line.at(u, line.points.ravel()).reshape(v.shape)
        found.append(np.sqrt(np.einsum("ecj,j,c->e", wrong**2, line.weights, line.h)))
    assert np.all(np.log2(found[0] / found[1]) > degree + 0.75)


def test_steps_in_time_come_to_the_steady_state():
    """From what enters, by steps of growing length: the state that Newton's method
    finds at once.
    """
    scene = heated(3, reacts=400.0)
    set_keys(scene, "packed_bed.section.dispersion_mass = 1e-4")
    problem, u = solved(scene).solved
    _, found = march(problem, problem.start(), Report())
    assert np.abs((found - u) / problem.sizes[:, None, None]).max() < 1e-8
    assert np.abs((problem.start() - u) / problem.sizes[:, None, None]).max() > 0.1


def test_wide_dispersion_is_one_dimension():
    """The difference from the 1-D bed falls with 1/K."""
    one = solved(heated(0, reacts=400.0)).qoi
    far, near = (
        solved(heated(4, conductivity=K, reacts=400.0)).qoi for K in (2e3, 2e4)
    )
    for key in ("T_fluid_out_K", "x_B_out", "heat_wall_W"):
        assert 8.0 < (far[key] - one[key]) / (near[key] - one[key]) < 12.0
        assert near[key] == approx(one[key], rel=1e-5)
    assert 0.2 < one["x_B_out"] < 0.95


def test_species_and_pressure_across_the_section():
    """Elements and energy close; rings that exchange species are more alike than
    those that do not.
    """
    scene = heated(5, reacts=400.0)
    set_keys(
        scene,
        """
        packed_bed.pressure_drop = "ergun"
        gas.viscosity = 3e-5
        gas.conductivity = 0.05
        packed_bed.section.dispersion = "vdi"
        """,
    )
    alone = solved(scene).solved
    set_keys(
        scene,
        """
        packed_bed.section.dispersion_mass = { name = "mass_dispersion_peclet", Pe_p = 10.0 }
        """,
    )
    together = solved(scene).solved
    spread = []
    for problem, u in (alone, together):
        by_ring = u.reshape(5, -1, *u.shape[1:])
        names = problem.layout.names
        p = by_ring[:, names.index("p")]
        assert np.ptp(p, axis=0).max() < 1e-9 * p.max()  # one pressure over the section
        spread.append(np.ptp(by_ring[:, names.index("g_B"), -1, -1]))
    assert spread[1] < 0.8 * spread[0]


def heating(rings, **time):
    """The bed of `heated` with particles, followed in time from the temperature of
    the gas that enters.
    """
    scene = heated(rings)
    scene["solids"]["particles"] |= {"density": DENSITY, "heat_capacity": C_SOLID}
    set_keys(scene, 'packed_bed.gas_storage = "quasi_steady"')
    scene["time"] = {"end": 300.0} | time
    return scene


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["tube", "plane"])
def test_conduction_into_a_bed_from_its_walls(shape):
    """Ahead of the front of heat from the inlet a bed is a body of Biot number 1.25 in
    time (series): order 2.

    The front is at 0.1 m of 1 m; steps of a tolerance of 1e-5 err by less than a tenth
    of what 6 rings do.
    """
    fourier = K * 300.0 / ((1.0 - POROSITY) * DENSITY * C_SOLID * RADIUS**2)
    exact, errors = mean_of_series(shape, 50.0, fourier), []
    for rings in (3, 6):
        scene = heating(rings, tolerance=1e-5)
        set_keys(scene, "mesh.cells = 4")
        scene["packed_bed"]["section"]["shape"] = shape
        errors.append(abs(solved(scene).profiles["T_fluid [K]"][-1] - exact))
    assert errors[0] > 3.6 * errors[1]
    assert errors[1] < 1.2  # of 300 K between bed and wall


@pytest.mark.parametrize(
    ("gas", "shape"),
    [
        ("quasi_steady", "tube"),
        ("quasi_steady", "duct"),
        pytest.param("stored", "tube", marks=pytest.mark.slow),
        pytest.param("stored", "duct", marks=pytest.mark.slow),
    ],
)
def test_bed_alike_across_is_plug_flow_in_time(gas, shape):
    """Walls through which a given flux of zero goes: all rings are the bed in one
    dimension, at every step.

    With a reaction, a falling pressure, and a jump of the inlet. Stages end at
    corrections of 1e-14 of typical sizes, [K] 1e3: what rounding makes of these over
    the steps stays below 1e-9 of the fields. Lengths of steps follow from an error that
    is a small difference of stages: 1e-6 for the outlet at each step.
    """
    runs = []
    for rings in (0, 3):
        scene = heating(rings, end=40.0)
        scene["packed_bed"]["gas_storage"] = gas
        if rings:
            scene["packed_bed"]["section"]["shape"] = shape
        set_keys(scene, "mesh.cells = 4")
        set_keys(scene, "reactions.r.A = 400.0")
        scene["mesh"]["diameter"] = 2 * RADIUS
        set_keys(
            scene,
            """
            boundary.wall = { heat_flux = 0.0 }
            gas.viscosity = 3e-5
            packed_bed.pressure_drop = "ergun"
            """,
        )
        scene["boundary"]["left"]["gas"]["temperature"] = {
            "times": [0, 20],
            "values": [T, T + 50.0],
            "form": "step",
        }
        runs.append(solved(scene))
    one, section = runs
    assert section.qoi["time_steps"] == one.qoi["time_steps"]
    for name, column in one.profiles.items():
        assert np.allclose(section.profiles[name], column, rtol=1e-9, atol=1e-12), name
    for name, column in one.tables["outlet"].items():
        assert np.allclose(
            section.tables["outlet"][name], column, rtol=1e-6, atol=1e-9
        ), name


def adsorbing(rings, level, **time):
    """A bed at rest that takes up a gas with -40 kJ/mol: five times what enters in a
    unit of time, to equilibrium.
    """
    scene, unit = adsorber(100.0, 10.0, 3.0, 2.0)
    for name in scene["gas"]["species"]:
        scene["gas"]["species"][name] |= {"heat_capacity": CP, "enthalpy": 0.0}
    scene["heat"] = {}
    scene["solids"]["particles"]["heat_capacity"] = C_SOLID
    set_keys(scene, "solids.particles.adsorption.A.enthalpy = -4e4")
    scene["solids"]["particles"]["inside"] = {"adsorption": level, "points": 2}
    scene["time"] |= {"end": 8.0 * unit} | time
    set_keys(scene, "mesh.cells = 4")
    scene["mesh"]["diameter"] = 2 * RADIUS
    set_keys(scene, "boundary.wall = { heat_flux = 0.0 }")
    if rings:
        scene["packed_bed"]["section"] = {
            "rings": rings,
            "conductivity_solids": 0.5,
            "dispersion_mass": 1e-4,
        }
    return scene


@pytest.mark.parametrize(
    "level",
    [
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in ("film", "linear_driving_force")
        ),
        "interior",
    ],
)
def test_bed_that_adsorbs_alike_across_is_plug_flow(level):
    """Breakthrough of a Langmuir front with its heat: rings are the bed in one
    dimension, to Newton's tolerance.
    """
    one, section = (solved(adsorbing(rings, level, tolerance=1e-3)) for rings in (0, 2))
    assert section.qoi["time_steps"] == one.qoi["time_steps"]
    assert 0.01 < one.profiles["x_A [1]"][-1] / TRACE < 0.9  # the front passes the end
    for name, column in one.profiles.items():
        assert np.allclose(section.profiles[name], column, rtol=1e-9, atol=1e-14), name


def test_bed_that_gives_off_what_it_holds_is_plug_flow():
    """Particles of all rings begin in equilibrium with the gas that fills the bed."""
    runs = []
    for rings in (0, 3):
        scene = adsorbing(rings, "film", tolerance=1e-3)
        scene["initial"]["gas"] = {"composition": scene["gas"]["composition"]}
        set_keys(scene, 'gas.composition = "N:1"')
        runs.append(solved(scene))
    one, section = runs
    assert 0.1 < one.profiles["x_A [1]"][-1] / TRACE < 0.9
    for name, column in one.profiles.items():
        assert np.allclose(section.profiles[name], column, rtol=1e-7, atol=1e-14), name


def test_heat_of_adsorption_leaves_through_the_wall():
    """Energy and elements close to 1e-12; the axis is warmer than the wall."""
    scene = adsorbing(3, "film", tolerance=1e-3)
    set_keys(
        scene,
        """
        gas.composition = "A:0.1, N:0.9"
        solids.particles.adsorption.A.affinity = 1e-4
        solids.particles.adsorption.A.capacity = 1.0
        """,
    )
    scene["mesh"]["diameter"] = 2 * RADIUS
    scene["boundary"]["wall"] = {"coefficient": 50.0, "ambient": T}
    set_keys(scene, "solids.particles.heat_capacity = 200.0")
    set_keys(scene, "time.end = 400.0")
    result = solved(scene)
    warmer = result.profiles["T_fluid_axis [K]"] - result.profiles["T_fluid_wall [K]"]
    assert warmer.max() > 2.0


def test_moving_bed_that_adsorbs_is_plug_flow():
    """Steady counter-current uptake, points inside of particles: rings alike are the
    bed in one dimension.
    """
    runs = []
    for rings in (0, 3):
        scene = adsorbing(rings, "interior")
        del scene["time"]
        let_move(scene, -3e-3, temperature=T)
        set_keys(scene, "heat = {}")
        set_keys(scene, "closures.nusselt = 10.0")
        scene["gas"] |= {"viscosity": MU, "conductivity": K_GAS}
        runs.append(solved(scene))
    one, section = runs
    assert 0.05 < one.qoi["x_A_out"] / 1e-6 < 0.95
    for name, column in one.profiles.items():
        assert np.allclose(section.profiles[name], column, rtol=1e-9, atol=1e-14), name


@pytest.mark.parametrize("temperatures", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_section_in_time_ends_in_its_steady_state(temperatures):
    """A reacting bed whose wall has become hotter, after 30 of the times in which
    heat passes it, is steady: 1e-8.
    """
    hotter = {
        "times": [0, 10, 1e5],
        "values": [T_WALL - 100.0, T_WALL, T_WALL],
        "form": "linear",
    }
    scenes = [heating(4, end=1e5), heated(4)]
    for scene in scenes:
        scene["mesh"]["cells"] = 4
        # on four cells B would fall below zero if none entered
        scene["gas"]["composition"] = "A:0.9, B:0.1"
        scene["reactions"]["r"]["A"] = 400.0
        scene["packed_bed"]["section"]["dispersion_mass"] = 1e-4
        if temperatures == 2:
            set_keys(scene, "closures.nusselt = 20.0")
            scene["solids"]["particles"] |= {
                "density": DENSITY,
                "heat_capacity": C_SOLID,
            }
            scene["gas"] |= {"viscosity": MU, "conductivity": K_GAS}
            set_keys(scene, "packed_bed.section.conductivity_gas = 0.5")
    scenes[0]["boundary"]["wall"]["ambient"] = hotter
    late, steady = (solved(scene).profiles for scene in scenes)
    for name, column in steady.items():
        assert np.allclose(late[name], column, rtol=1e-8, atol=1e-10), name
    assert abs(steady["T_fluid_wall [K]"] - steady["T_fluid_axis [K]"]).max() > 5.0


def test_plan_tells_whether_one_dimension_is_enough():
    """Mears: q R/(2 K) against 0.4 R T^2/E, with q by the coefficient and a quarter
    of the radius in series.
    """
    q = (T_WALL - T) / (1.0 / 50.0 + 0.25 * RADIUS / K)
    found = across(plan(from_dict(heated(4, reacts=400.0))).problem)
    assert found.difference == approx(q * RADIUS / (2.0 * K), rel=1e-12)
    # the concentration of an ideal gas falls with 1/T, so that its rate rises by E - R
    # T
    assert found.limit == approx(0.4 * R_GAS * T**2 / (3e4 - R_GAS * T), rel=1e-4)
    assert not found.fits
    scene = heated(0, wall=0.05, reacts=400.0)
    scene["gas"] |= {"viscosity": 3e-5, "conductivity": 0.05}
    assert across(plan(from_dict(scene)).problem).fits
    set_keys(scene, "boundary.wall.coefficient = 50.0")
    advised = dict(plan(from_dict(scene)).skipped)["differences across the bed"]
    assert advised.endswith("Add [packed_bed.section] to resolve it")


@each_case(__file__, "mistakes")
def test_mistakes(said, changes, without):
    refused(said, from_dict, changed(heated(4), changes, without))


def test_many_columns_of_a_duct_are_dear():
    """Fields of 16 x 16 columns in one dense block; 8 x 8 are not warned of."""
    scene = from_dict(heated(16, "duct"))
    assert any("256 columns" in text for text in scene.warnings)
    assert not any("columns" in w for w in from_dict(heated(8, "duct")).warnings)
    planned = plan(scene)
    line = planned.problem.system.line
    size = planned.unknowns()["bed"]
    assert planned.policy.block * line.cells == size
    fields = planned.problem.system.m
    assert fields % 256 == 0 and planned.policy.block == fields * (line.degree + 1)
