"""Closures of the two-fluid model against closed forms: what drag and weight make of
one particle and of a suspension, shear against dissipation, limits, joins, and the
compiled functions against numpy's.

Tolerances: the printed digits of the references where those are numbers, round-off
    where two ways must agree.
"""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from pytest import approx
from scipy.optimize import brentq

from contbed import closures
from contbed.closures.compiled import compiled
from contbed.closures.granular_transport import share_drag, share_free_path
from contbed.loading import from_dict
from contbed.runner import run
from contbed.two_fluid import filters
from contbed.two_fluid.closures import bound
from contbed.two_fluid.near_walls import (
    corrected,
    distances,
    friction_stiffness,
    wall_froude,
)
from contbed.two_fluid.plan import plan
from contbed.two_fluid.rheology import Closures, Rheology
from tests.cases import each_case
from tests.refusals import refusal, refused
from tests.scene_text import scene_of, set_keys

SEED = {"rho_s": 2550.0, "d_p": 150e-6, "rho": 1.2, "mu": 1.8e-5}
TAGHIPOUR = {"rho_s": 2500.0, "d_p": 275e-6, "rho": 1.225, "mu": 1.7894e-5}
GRAVITY = 9.81
# velocity of Stokes of the beads of the filtered scenes [m/s]
SETTLING = GRAVITY * 75e-6**2 * (1500.0 - 1.2) / (18.0 * 1.8e-5)
DRAG = ("drag_wen_yu", "drag_syamlal_obrien", "drag_gidaspow", "drag_di_felice")
PLANE = {"type": "rectangle", "length": 0.2, "height": 0.4, "cells": [10, 40]}
RADIAL = (
    "g0_sinclair_jackson",
    "g0_lun_savage",
    "g0_carnahan_starling",
    "g0_ma_ahmadi",
)


def beta(name, eps, u, rho_s, d_p, rho, mu):
    """Drag coefficient at an intrinsic slip."""
    return closures.get(name, "drag")(
        Re=eps * rho * u * d_p / mu, eps=eps, d_p=d_p, mu=mu
    )


def carried(name, eps, u, **system):
    """Drag on a suspension less its weight in the gas, over the weight."""
    weight = eps * (1 - eps) * (system["rho_s"] - system["rho"]) * GRAVITY
    return beta(name, eps, u, **system) * u / weight - 1


def g0(name, eps_s, eps_max=0.6):
    function = closures.get(name)
    return (
        function(eps_s, eps_max)
        if "eps_max" in function.sheet.arguments
        else function(eps_s)
    )


@pytest.mark.parametrize(
    ("name", "slip"), [("drag_wen_yu", 1.00303), ("drag_syamlal_obrien", 0.92414)]
)
def test_terminal_velocity_of_one_particle(name, slip):
    found = brentq(lambda u: carried(name, 1 - 1e-9, u, **SEED), 0.1, 3.0)
    assert found == approx(slip, abs=6e-6)  # five printed digits


@each_case(__file__, "voidage_of_a_uniform_suspension")
def test_voidage_of_a_uniform_suspension(name, velocity, voidage):
    found = brentq(
        lambda eps: carried(name, eps, velocity / eps, **TAGHIPOUR), 0.4, 0.75
    )
    assert found == approx(voidage, abs=6e-5)  # four printed digits


@pytest.mark.parametrize(
    ("name", "velocity"),
    [
        ("drag_syamlal_obrien", 0.1327),
        ("drag_gidaspow", 0.0718),
        ("drag_wen_yu", 0.0689),
    ],
)
def test_velocity_that_carries_a_packing(name, velocity):
    found = 0.4 * brentq(lambda u: carried(name, 0.4, u, **TAGHIPOUR), 1e-3, 1.0)
    assert found == approx(velocity, abs=6e-5)


@pytest.mark.parametrize("name", DRAG)
def test_drag_is_finite_and_rises_with_slip_and_fraction(name):
    eps_s, u = np.meshgrid(
        [1e-9, 1e-4, 0.01, 0.1, 0.14, 0.16, 0.19, 0.21, 0.4, 0.6],
        [0.0, 1e-8, 1e-3, 0.1, 1.0, 20.0],
    )
    each = beta(name, 1 - eps_s, u, **SEED) / eps_s
    assert np.isfinite(each).all()
    force = each * u
    assert (np.diff(force, axis=0) > 0).all()
    # between 0.15 and 0.2 laws change over, where each may step by a few per cent
    dense = eps_s[0] > 0.25
    assert (np.diff(each[:, dense], axis=1) > 0).all()


@pytest.mark.parametrize(
    "name", ["drag_wen_yu", "drag_syamlal_obrien", "drag_gidaspow"]
)
def test_drag_has_no_jump(name):
    """A change by 1e-9 of the state changes the drag by no more than 1e-5: joins are
    steep but smooth.
    """
    eps, Re = np.linspace(0.37, 0.9999, 4001), np.geomspace(0.1, 5e3, 4001)
    function = closures.get(name)

    def each(Re, eps):
        return function(Re, eps, 1e-3, 1.8e-5) / (1 - eps)

    assert_allclose(each(50.0, eps - 1e-9), each(50.0, eps), rtol=1e-5)
    assert_allclose(each(Re * (1 + 1e-9), 0.9), each(Re, 0.9), rtol=1e-5)


def test_wen_yu_joins_its_two_laws_within_a_few_per_cent_of_the_reynolds_number():
    below, above = (
        closures.drag_wen_yu(Re, 0.9, d_p=1.0, mu=1.0) / (0.1 * 0.9**-2.65)
        for Re in (900.0, 1100.0)
    )
    # a tail of exp(-10) of the 0.4 % by which they differ
    assert below == approx(18 * (1 + 0.15 * 900.0**0.687), rel=1e-5)
    assert above == approx(0.33 * 1100.0, rel=1e-5)


@pytest.mark.parametrize(
    ("eps_s", "restitution", "expected"),
    [
        (0.3, 0.8, 0.523848),
        (0.3, 0.95, 2.057972),
        (0.05, 0.95, 24.9228),
        (0.5, 0.95, 1.73717),
    ],
)
def test_shear_against_dissipation(eps_s, restitution, expected):
    contact = g0("g0_sinclair_jackson", eps_s)
    mu = closures.granular_viscosity_gidaspow(eps_s, contact, restitution)
    gamma = closures.granular_dissipation_lun(eps_s, contact, restitution)
    assert mu / gamma == approx(expected, rel=3e-6)  # six printed digits


def test_rate_of_cooling():
    """b of Haff's law, d sqrt(theta)/dt = -b theta/2, from dissipation over 3/2
    eps_s.
    """
    contact = g0("g0_sinclair_jackson", 0.3)
    assert contact == approx(4.84732, abs=6e-6)
    b = closures.granular_dissipation_lun(0.3, contact, 0.95) / (1.5 * 0.3 * 150e-6)
    assert b == approx(4266.30, abs=6e-3)
    assert 1e-2 / (1 + b * 0.1 * 0.1 / 2) ** 2 == approx(2.005229e-5, rel=3e-6)


def test_bulk_viscosity_is_five_thirds_of_the_collisional_viscosity():
    s, e = np.linspace(0.01, 0.6, 20), 0.9
    contact = g0("g0_lun_savage", s, 0.63)
    collisional = closures.granular_viscosity_gidaspow(s, contact, e, kinetic=0.0)
    assert_allclose(
        closures.granular_bulk_lun(s, contact, e), 5.0 / 3.0 * collisional, rtol=1e-14
    )


@pytest.mark.parametrize("name", RADIAL)
def test_radial_distribution_is_one_when_dilute_and_rises(name):
    s = np.linspace(0.0, 0.59, 60)
    values = g0(name, s)
    assert values[0] == 1.0
    assert (np.diff(values) > 0).all()


@pytest.mark.parametrize(
    "name", ["granular_viscosity_gidaspow", "granular_viscosity_syamlal"]
)
def test_dilute_limits_of_viscosity(name):
    """Gidaspow's stays finite, Syamlal's is proportional to the fraction: neither
    grows as the particles thin out.
    """
    function, s = closures.get(name), np.array([1e-8, 1e-6, 1e-4])
    values = function(s, 1.0, 0.9)
    expected = (
        10 * np.pi**0.5 / (96 * 1.9)
        if "gidaspow" in name
        else s * np.pi**0.5 / (6 * 2.1)
    )
    assert_allclose(values, expected * np.ones(3), rtol=2e-3)


def test_guards_end_in_one_and_zero():
    base = {
        "K": 60.0,
        "theta": 0.1,
        "g0": 1.3,
        "rho_s": 2550.0,
        "d_p": 150e-6,
        "dilute": 0.0923,
    }
    assert share_drag(eps_s=0.5, **base | {"K": 0.0}) == 1.0
    assert share_drag(eps_s=1e-9, **base) < 1e-3
    assert share_free_path(0.5, 5.0, 150e-6, 0.01) == approx(1.0, abs=1e-3)
    assert share_free_path(1e-9, 1.0, 150e-6, 0.01) < 1e-4


def test_friction_begins_where_particles_touch_and_is_smooth():
    eps_s = np.array([0.3, 0.5, 0.5 + 1e-6, 0.6])
    p = closures.friction_johnson_jackson(eps_s, 0.63)
    assert (p[:2] == 0).all()
    assert 0 < p[2] < 1e-6
    assert p[3] == approx(0.05 * 0.1**2 / 0.03**5, rel=1e-12)


def test_yield_stress_of_schaeffer_does_not_depend_on_the_rate():
    """2 mu shear_rate = p sin(angle) to (rate_min/shear_rate)^2/2; below rate_min
    the particles creep.
    """
    rates = np.array([5.0, 50.0, 500.0])
    stress = 2.0 * rates * closures.friction_viscosity_schaeffer(80.0, 0.5, rates)
    assert_allclose(stress, 80.0 * np.sin(0.5), rtol=1e-4)
    assert closures.friction_viscosity_schaeffer(80.0, 0.5, 0.0) == approx(
        80.0 * np.sin(0.5) / 0.1
    )
    assert closures.friction_viscosity_newtonian(80.0, 0.5) == approx(
        0.5 * 80.0 * np.sin(0.5)
    )


@pytest.mark.parametrize(
    "name",
    [
        "drag_gidaspow",
        "drag_syamlal_obrien",
        "g0_ma_ahmadi",
        "granular_viscosity_gidaspow",
    ],
)
def test_compiled_functions_are_those_of_numpy(name):
    """numba and numpy evaluate one function; powers may differ by their last digits."""
    function, s = closures.get(name), np.linspace(0.01, 0.58, 7)
    known = {
        "Re": 40.0,
        "eps": 1 - s,
        "d_p": 1e-3,
        "mu": 1.8e-5,
        "eps_s": s,
        "eps_max": 0.6,
        "g0": 1.0 + s,
        "e": 0.9,
    }
    names = function.sheet.arguments
    options = tuple(function.sheet.options.values())
    kernel = compiled(function)
    one = [
        kernel(*(np.broadcast_to(known[k], s.shape)[i] for k in names), *options)
        for i in range(len(s))
    ]
    assert_allclose(one, function(*(known[k] for k in names)), rtol=1e-13)


def filtered_over_plain(eps_s, filter_froude):
    given = {"Re": 1.0, "eps": 1.0 - eps_s, "d_p": 1e-4, "mu": 1.8e-5}
    plain = closures.get("drag_wen_yu", "drag")(**given)
    return (
        closures.get("drag_igci", "drag")(**given, filter_froude=filter_froude) / plain
    )


def test_filtered_drag_has_the_values_of_its_formulas():
    """Factors of the pieces as printed, evaluated elsewhere to six decimals at 12
    fractions and 10 filters.

    The logistic steps between the pieces add up to 4e-5, three widths of a step away
    from a joint.
    """
    path = Path(__file__).parents[1] / "data/filtered_drag_igci.csv"
    eps_s, froude, factor = np.loadtxt(path, delimiter=",", skiprows=1, unpack=True)
    assert len(factor) == 120
    assert_allclose(filtered_over_plain(eps_s, froude), factor, rtol=6e-5)


def test_filtered_drag_without_filter_and_at_its_ends():
    eps_s = np.array([1e-9, 1e-8, 0.3, 0.64])
    assert_array_equal(filtered_over_plain(eps_s, 0.0), 1.0)
    found = filtered_over_plain(eps_s, 32.0)
    assert found[0] == approx(found[1], rel=1e-12)
    assert found[0] > 0.8  # dilute: hardly any clusters
    assert found[2] < 0.25
    assert found[3] == approx(1.0, abs=1e-4)  # dense: no room for clusters


def milioli_over_plain(eps_s, slip, filter_froude, Re_t=1.3):
    given = {
        "Re": slip * (1.0 - eps_s) * Re_t,
        "eps": 1.0 - eps_s,
        "d_p": 1e-4,
        "mu": 1.8e-5,
    }
    plain = closures.get("drag_wen_yu", "drag")(**given)
    return (
        closures.get("drag_milioli", "drag")(
            **given, filter_froude=filter_froude, Re_t=Re_t
        )
        / plain
    )


MILIOLI = np.loadtxt(
    Path(__file__).parents[1] / "data/filtered_drag_milioli.csv",
    delimiter=",",
    skiprows=1,
    unpack=True,
)


def test_drag_filtered_with_the_slip_has_the_values_of_its_formulas():
    """Factors at three slips, six decimals, evaluated with the coefficients of the next
    larger filter fitted.

    Smooth minima add up to 5.8e-4 where two pieces are nearly equal.
    """
    fitted = {
        2.0: 2.056,
        4.0: 4.112,
        8.0: 8.224,
        12.0: 12.336,
        16.0: 16.448,
        20.0: 20.56,
    }
    eps_s, froude, *factors = MILIOLI
    froude = np.array([fitted.get(F, F) for F in froude])
    for slip, factor in zip((0.5, 1.0, 2.0), factors, strict=True):
        assert_allclose(milioli_over_plain(eps_s, slip, froude), factor, atol=6e-4)
    assert eps_s.shape == (120,)


def test_drag_filtered_with_the_slip_between_its_filters():
    """Monotonic from one fitted filter to the next, without the jumps of a reading
    by classes; positive everywhere.
    """
    between = np.linspace(2.056, 4.112, 201)
    found = milioli_over_plain(0.1, 1.0, between)
    assert (np.diff(found) <= 0.0).all()
    assert np.abs(np.diff(found)).max() < 1e-2 * np.ptp(found)
    assert_allclose(
        milioli_over_plain(np.array([0.01, 0.3]), 2.0, 1.028), 1.0, rtol=1e-14
    )
    eps_s, slip, froude = np.meshgrid(
        np.linspace(1e-6, 0.63, 64),
        np.geomspace(1e-3, 1e3, 61),
        [1.5, 3.0, 6.0, 18.0, 99.0],
    )
    found = milioli_over_plain(eps_s, slip, froude)
    assert found.min() > 1e-4
    assert found.max() <= 1.0


def test_filtered_stress_has_the_values_of_its_formulas():
    """Pieces as printed, by hand; dilute, kinetic theory without filter, and no
    clusters where there is no room.
    """
    pressure, viscosity = (
        closures.granular_pressure_igci,
        closures.granular_viscosity_igci,
    )
    size = 0.48 * 4.0**0.86 * (1.0 - np.exp(-4.0 / 1.4))
    kinetic = -0.185e-3 + 0.066e-2 - 0.0000183 + 0.00232
    clusters = size * (0.1 - 0.59) * (-1.69 * 0.1 - 4.61 * 0.1**2 + 11.0 * 0.1**3)
    assert pressure(0.1, 1.0, 0.9, filter_froude=4.0) == approx(
        kinetic + clusters, rel=1e-12
    )
    assert pressure(0.1, 1.0, 0.9, filter_froude=0.0) == approx(kinetic, rel=1e-12)
    assert pressure(0.005, 1.0, 0.9, filter_froude=0.0) == approx(
        -10.4 * 0.005**2 + 0.31 * 0.005, rel=1e-12
    )
    assert pressure(0.4, 1.0, 0.9, filter_froude=0.0) == approx(
        -0.00978 * 0.4 + 0.00615, rel=1e-12
    )
    theory = 2.72e-4 - 1.55e-3 + 0.329e-2 - 0.0296e-1 + 0.00136
    clusters = (
        0.37
        * 4.0**1.22
        / (0.28 * 4.0**0.43 + 1)
        * (0.1 - 0.59)
        * (-0.122 - 0.7e-2 - 2e-3)
    )
    found = viscosity(0.1, 1.0, 0.9, filter_froude=4.0, terminal_froude=88.0)
    assert found == approx(88.0 * (theory + clusters), rel=1e-12)
    thin = 1720 * 1e-8 - 215e-6 + 9.81e-4 - 0.207e-2 + 0.00254
    assert viscosity(0.01, 1.0, 0.9, filter_froude=0.0, terminal_froude=1.0) == approx(
        thin, rel=1e-12
    )
    thick = -0.0128 * 0.4**3 + 0.0107 * 0.4**2 - 0.0005 * 0.4 + 0.000335
    assert viscosity(0.4, 1.0, 0.9, filter_froude=0.0, terminal_froude=1.0) == approx(
        thick, rel=1e-12
    )
    for law, more in ((pressure, {}), (viscosity, {"terminal_froude": 88.0})):
        packed = [law(0.63, 1.0, 0.9, filter_froude=F, **more) for F in (0.0, 30.0)]
        assert packed[1] == approx(packed[0], rel=0.2)
        s = np.linspace(0.0, 0.65, 1001)
        assert (law(s, 1.0, 0.9, filter_froude=4.0, **more)[1:] > 0.0).all()


FILTERED_STRESS = {
    "granular_pressure": "granular_pressure_igci",
    "granular_viscosity": "igci",
    "granular_bulk_viscosity": "none",
}


def filtered_scene(theta, two_fluid=None, **closures):
    sides = ["left", "right", "bottom", "top"]
    return scene_of(
        """
            gas = { density = 1.2, viscosity = 1.8e-5 }
            time = { end = 0.1 }

            [solids.beads]
            diameter = 75e-6
            density = 1500.0
            restitution = 0.9
            packing_limit = 0.6

            [initial.solids.beads]
            volume_fraction = 0.05
        """,
        {
            "mesh": PLANE,
            "two_fluid": {"granular_temperature": "frozen"} | (two_fluid or {}),
            "closures": {"drag": "milioli", **FILTERED_STRESS, **closures},
            "initial.solids.beads.granular_temperature": theta,
            "boundary": {
                side: {"type": "wall", "solids": {"beads": {"wall": "slip"}}}
                for side in sides
            },
        },
    )


NEAR_WALLS = {
    "wall_drag": (6.0, 0.295),
    "wall_pressure": (9.14, 0.345),
    "wall_viscosity": (5.69, 0.228),
}
TANKS = scene_of("""
    plane = { type = "rectangle", length = 0.1, height = 0.2, cells = [10, 5] }
    pipe = { type = "axisymmetric", length = 0.2, radius = 0.1, cells = [10, 5] }
    box = { type = "box", length = 0.1, width = 0.06, height = 0.2, cells = [10, 6, 5] }
""")


def tank(mesh=TANKS["plane"], two_fluid=None, **closures):
    sides = {
        "rectangle": ["left", "right", "bottom", "top"],
        "axisymmetric": ["wall", "bottom", "top"],
        "box": ["left", "right", "front", "back", "bottom", "top"],
    }
    walls = {
        "type": "wall",
        "solids": {"beads": {"wall": "slip"}},
        "gas": {"wall": "slip"},
    }
    scene = filtered_scene(
        SETTLING**2,
        two_fluid,
        **closures,
    )
    return scene | {
        "mesh": mesh,
        "boundary": dict.fromkeys(sides[mesh["type"]], walls),
    }


@pytest.mark.slow
def test_filtered_stress_comes_with_its_granular_temperature():
    """mu = rho_s v_t^3/g mu*, p = rho_s v_t^2 p* of the model where theta = v_t^2;
    other temperatures are refused.
    """
    scene = from_dict(filtered_scene(SETTLING**2))
    bed, _ = plan(scene).bed()
    F = 2.0 * (0.02 * 0.01) ** 0.5 * GRAVITY / SETTLING**2
    rheology, theta = bed.state.properties.rheology, bed.state.theta
    pressure = closures.granular_pressure_igci(0.05, 1.0, 0.9, F)
    # fades below 1e-8
    assert_allclose(rheology.pressure * theta, SETTLING**2 * pressure, rtol=1e-5)
    viscosity = closures.granular_viscosity_igci(
        0.05, 1.0, 0.9, F, SETTLING**2 / GRAVITY / 75e-6
    )
    assert_allclose(rheology.mu, 1500.0 * 75e-6 * SETTLING * viscosity, rtol=1e-5)
    assert bound(scene)["drag"].parameters["Re_t"] == approx(
        1.2 * SETTLING * 75e-6 / 1.8e-5, rel=1e-12
    )
    refused(
        r"must be 0\.0651\d+ m2/s2, the square of the terminal velocity",
        lambda: from_dict(filtered_scene(1e-3)),
    )
    refused(
        r'granular_temperature.*must be "frozen"',
        lambda: from_dict(filtered_scene(SETTLING**2, {"granular_temperature": "pde"})),
    )
    refused(
        "needs particles that settle",
        lambda: from_dict(filtered_scene(SETTLING**2, {"gravity": 0.0})),
    )


@pytest.mark.parametrize(
    ("name", "more", "size"),
    [
        ("plane", {}, 0.02),
        ("plane", {"refine": 1}, 0.01),
        ("pipe", {}, 0.02),
        ("box", {}, 4e-6 ** (1 / 3)),
    ],
)
def test_plan_and_results_tell_the_size_of_the_filter(name, more, size):
    """Two cells wide by itself, on cells of a pipe by their section; results are in
    v_t^2/g and in metres.
    """
    found = plan(from_dict(tank(TANKS[name] | more)))
    lines = {what: how for what, how in found.built if what.startswith("filter")}
    assert set(lines) == {
        f"filter of the {what}"
        for what in ("drag", "granular pressure", "granular viscosity")
    }
    length = SETTLING**2 / GRAVITY
    assert all(
        f"{2 * size:.3g} m, 2 cells wide, {2 * size / length:.3g} v_t^2/g" in text
        for text in lines.values()
    )
    named = filters.results(found.scene)
    assert named["filter_size [m]"] == approx(2 * size, rel=1e-12)
    assert named["filter_froude"] == approx(2 * size / length, rel=1e-12)
    assert not any("filter" in text for text in found.warnings)
    drag = bound(found.scene)["drag"].parameters
    assert drag["filter_froude"] == approx(2 * size / length, rel=1e-12)


@pytest.mark.parametrize(
    ("F", "says"),
    [
        (1.0, "no drag is filtered up to 1.028"),
        (4.112, "the fit to 4.112"),
        (30.0, "the fit to 24.67"),
        (5.0, "between the fits to 4.112 and 8.224"),
    ],
)
def test_plan_tells_the_fits_that_the_filtered_drag_lies_between(F, says):
    lines = dict(
        plan(from_dict(tank(drag={"name": "milioli", "filter_froude": F}))).built
    )
    assert lines["filter of the drag"].endswith(f"; {says}")


def test_filter_unlike_the_cells_is_warned_of():
    (text,) = plan(
        from_dict(tank(drag={"name": "igci", "filter_froude": 0.5}))
    ).warnings
    assert (
        "closures.drag: its filter is 0.166 cells wide; 2 are meant, filter_froude = "
        "6.022" in text
    )
    refused(
        r"closures\.drag: needs particles that settle",
        lambda: from_dict(
            tank(
                drag={"name": "igci", "filter_froude": 3.0},
                two_fluid={"gravity": 0.0},
            )
        ),
    )


def test_plan_without_filtered_closures_tells_no_filter():
    plain = {
        "drag": "wen_yu",
        "granular_pressure": "granular_pressure_dilute",
        "granular_viscosity": "none",
    }
    found = plan(from_dict(tank(**plain)))
    assert not any(what.startswith("filter") for what, _ in found.built)
    assert filters.results(found.scene) == {}


@pytest.mark.slow  # compiles a step with these closures on both kinds of meshes
@pytest.mark.parametrize("shape", ["quadrilateral", "triangle"])
def test_pressure_that_falls_with_the_fraction_leaves_compaction_solvable(shape):
    """Igci's pressure falls between 0.3 and 0.59: a dense bed keeps its particles
    below the packing limit.
    """
    mesh = TANKS["plane"] | {"cells": [10, 20], "shape": shape}
    scene = tank(mesh, drag="igci", **dict.fromkeys(NEAR_WALLS, "igci"))
    del scene["initial"]["solids"]["beads"]["volume_fraction"]
    set_keys(
        scene,
        """
        initial.layer = [{ end = 0.1, solids = { beads = { volume_fraction = 0.45 } } }]
        boundary.bottom = { type = "inlet", gas = { velocity = 0.5 } }
        boundary.top = { type = "outlet" }
        """,
    )
    result = run(
        from_dict(
            scene | {"time": {"end": 0.1}, "output": {"plots": False, "fields": False}}
        )
    )
    assert result.qoi["eps_s_max"] < 0.6
    # of 300 steps, each to rounding
    assert abs(result.qoi["mass_drift_relative"]) < 1e-13
    # of a gas at 0.5 m/s through half of the section
    assert result.qoi["max_velocity"] < 2.0


@pytest.mark.parametrize("kind", NEAR_WALLS)
def test_factors_near_walls_have_the_values_of_their_formulas(kind):
    a, b = NEAR_WALLS[kind]
    x = np.array([0.0, 1.0, 5.0, 200.0])
    assert_allclose(
        closures.get(f"{kind}_igci", kind)(x),
        1.0 / (1.0 + a * np.exp(-b * x)),
        rtol=1e-14,
    )


@pytest.mark.parametrize(
    ("name", "distance"),
    [
        ("plane", lambda x: np.minimum(x, 0.1 - x)),
        ("pipe", lambda r: 0.1 - r),
        ("box", lambda x, y: np.minimum.reduce([x, 0.1 - x, y, 0.06 - y])),
    ],
)
def test_distances_are_those_from_the_walls_beside_the_flow(name, distance):
    """Floor and roof do not count; cells of a box are as far as the nearest of its
    four sides.
    """
    scene = from_dict(tank(TANKS[name]))
    grid = plan(scene).grid
    across = grid.centres[:, :-1].T
    assert_allclose(distances(scene, grid), distance(*across), rtol=1e-12)


def test_factors_near_walls_multiply_drag_pressure_and_viscosity():
    """Each multiplies what it is named after in a step's closures; friction stays,
    so that a packing carries.
    """
    scene = from_dict(tank(TANKS["box"], **dict.fromkeys(NEAR_WALLS, "igci")))
    grid = plan(scene).grid
    x = wall_froude(scene, grid)
    eps_s, theta, table = (
        np.linspace(0.45, 0.6, len(x)),
        np.full(len(x), 0.3),
        np.linspace(0.0, 1.0, 101) ** 2,
    )
    first, spacing = 0.5, 1e-3

    def theory(eps_s, theta, K):
        field = np.linspace(1.0, 2.0, len(eps_s))
        rub = friction_stiffness(eps_s, (first, spacing, table))
        return Rheology(*(field,) * len(Rheology._fields))._replace(
            stiffness=3.0 * theta + rub
        )

    plain = Closures(
        lambda eps_s, slip: eps_s * slip,
        theory,
        lambda p, rate: p,
        packing=(first, spacing, table),
    )
    near = corrected(plain, bound(scene), scene, grid)
    assert_array_equal(near.wall_froude, x)
    drag, pressure, viscosity = (
        1.0 / (1.0 + a * np.exp(-b * x)) for a, b in NEAR_WALLS.values()
    )
    assert_allclose(near.drag(eps_s, theta), drag * eps_s * theta, rtol=1e-13)
    r, found = theory(eps_s, theta, theta), near.granular(eps_s, theta, theta)
    rub = r.stiffness - 3.0 * theta
    expected = {
        "pressure": pressure * r.pressure,
        "mu": viscosity * r.mu,
        "stiffness": 3.0 * pressure * theta + rub,
    }
    for name, field in r._asdict().items():
        assert_allclose(
            getattr(found, name), expected.get(name, field), rtol=1e-13, err_msg=name
        )
    # the slope of each piece of the table in its middle, zero below its start
    middle = np.array([first - spacing, *(first + spacing * (np.arange(100) + 0.5))])
    slope = np.array([0.0, *(np.diff(table) / spacing)])
    assert_allclose(
        friction_stiffness(middle, (first, spacing, table)), slope, rtol=1e-12
    )


def test_closures_of_a_step_are_as_they_were_without_factors_near_walls():
    scene = from_dict(tank(PLANE))
    plain = Closures(np.multiply, np.add, np.add)
    assert corrected(plain, bound(scene), scene, plan(scene).grid) is plain


@each_case(__file__, "factors_near_walls_without_what_they_multiply")
def test_factors_near_walls_without_what_they_multiply(keys, told):
    assert told in refusal(lambda: from_dict(tank(PLANE, **keys)))


def test_factors_near_walls_that_do_not_slip_are_told():
    scene = tank(PLANE, wall_drag="igci")
    set_keys(
        scene,
        """
        boundary.left = { type = "wall", solids = { beads = { wall = "slip" } } }
        """,
    )
    text = (
        'closures.wall_drag = "igci": holds where gas and particles slip along '
        "walls, not along left"
    )
    assert any(text in warning for warning in from_dict(scene).warnings)
