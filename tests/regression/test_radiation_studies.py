"""Every scene of the radiation studies runs; their numbers hold against
studies._exact at the scenes' own values.
"""

import tomllib
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from pytest import approx

import contbed as cb
from studies._exact.radiation import square_p1
from tests.balances import assert_closed

STUDIES = Path(__file__).parents[2] / "studies"


def study(name, script="study"):
    """A script of a study as a module."""
    return import_module(f"studies.{name}.{script}")


def scenes(name):
    """All scenes of a study as parameters."""
    folder = STUDIES / name
    return [
        pytest.param(path, id=str(path.relative_to(folder))[:-5])
        for path in sorted(folder.rglob("*.toml"))
    ]


def run(scene):
    """The result of a run whose balances close."""
    result = cb.run(scene)
    assert_closed(result, 1e-10)
    return result


@pytest.mark.parametrize("path", scenes("heaslet_warming"))
def test_plates_in_radiative_equilibrium(path):
    module, scene = study("heaslet_warming"), cb.load(path)
    found = module.found(run(scene))
    if scene.radiation.level == "ordinates":
        assert found[0] == approx(module.reference(scene)[0], rel=6e-4)
        assert found[1] == approx(module.reference(scene)[1], rel=6e-3)
    else:
        assert found == approx(module.closed_form(scene), rel=1e-10)


@pytest.mark.parametrize("path", scenes("conduction_radiation"))
@pytest.mark.parametrize("theta_L", [0.5, 0.1])
def test_conduction_with_radiation(path, theta_L):
    module = study("conduction_radiation")
    _, N, _, tau = path.stem.split("_")
    for level in ("two_flux", "p1"):
        scene = module.load(N, tau, level, theta_L=theta_L)
        assert module.found(run(scene)) == approx(
            module.of_model(scene).total, rel=1e-7
        )
    scene = module.load(N, tau, "ordinates", 4, theta_L)
    assert module.found(run(scene)) == approx(module.reference(scene).total, rel=6e-4)


def test_heat_through_a_conducting_medium_does_not_depend_on_the_place():
    """Radiation and conduction add up to the same flux at every point of the
    profiles.
    """
    module = study("conduction_radiation")
    scene = module.load("0.01", "1", "ordinates", 8)
    profiles = run(scene).profiles
    x, T, q = (
        profiles[name] for name in ("x [m]", "T_solid [K]", "q_radiation [W/m2]")
    )
    exact = module.reference(scene)
    assert np.interp(exact.depth, 10 * x, T / 1000) == approx(exact.theta, abs=2e-5)
    scale = 5.670374419e4
    assert q[[0, -1]] / scale == approx(exact.radiative, rel=1e-4)
    conducted = -scene.radiation.conductivity * np.gradient(T, x)
    assert (conducted + q)[2:-2] == approx(exact.total * scale, rel=1e-2)


@pytest.mark.parametrize("path", scenes("isothermal_slab"))
def test_isothermal_slab_scenes(path):
    module, scene = study("isothermal_slab"), cb.load(path)
    assert module.found(run(scene)) == approx(module.reference(scene), rel=1e-4)


@pytest.mark.parametrize("path", scenes("square_enclosure"))
def test_square_enclosure(path):
    module, scene = study("square_enclosure"), cb.load(path)
    result = run(scene)
    x = np.linspace(0.02, 0.98, 25)
    expected = square_p1(x, module.thickness(scene))
    for wall in ("bottom", "left", "top", "right"):
        assert module.wall_flux(result, x, wall) == approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    "options",
    [{}, {"ends": False}, {"mixing": 0.01}],
    ids=["bed", "mirrors", "little mixing"],
)
def test_radiation_of_all_species_is_the_divergence_of_the_flux(options):
    module = study("rabi_two_flux", "bed")
    for level in module.LEVELS:
        assert abs(module.open_balance(level, module.solved(level, **options))) < 1e-12


def test_hot_bed_against_collocation():
    module = study("rabi_two_flux", "bed")
    reference = tomllib.loads((module.HERE / "data" / "bed.toml").read_text())[
        "reference"
    ]["p1"]
    found = module.solved("p1")
    assert found.T_d == approx(reference["T_distributor_K"], abs=1e-5)
    middle = [np.interp(0.3, found.z, getattr(found, name)) for name in module.SOLIDS]
    assert middle == approx(reference["T_half_height_K"], abs=1e-4)
    assert found.T_emulsion[-1] == approx(reference["T_emulsion_top_K"], abs=1e-4)
    assert found.T_bubble[-1] == approx(reference["T_bubble_top_K"], abs=1e-4)
    for name, key in (("tubes", "tubes"), ("wall", "walls"), ("top", "top")):
        assert found.heat[name] == approx(reference[f"{key}_radiation_W"], abs=0.01)


def test_closure_misses_the_ends_only():
    module = study("rabi_two_flux", "bed")

    def middle(**options):
        return [
            np.interp(0.3, one.z, one.T_inert)
            for one in (module.solved(n, **options) for n in ("closure", "p1"))
        ]

    paper, full = middle()
    assert 20 < paper - full < 30
    paper, full = middle(ends=False)
    assert abs(paper - full) < 1


def test_forward_integration_does_not_conserve():
    """Its flux relaxes to -dE/dz over beta above the distributor, whatever leaves
    there.
    """
    module = study("rabi_two_flux", "bed")
    bed = module.Bed("closure")
    found = bed.results(bed.solve())
    q = bed.flux(found)
    assert q[0] < -1e5
    inside = (found.z > 0.02) & (found.z < 0.58)
    slope = np.gradient(found.G / 4, found.z)
    np.testing.assert_allclose(
        q[inside], -slope[inside] / bed.beta, rtol=0.05, atol=1.0
    )


def test_rosseland_of_a_packed_bed_stays_within_its_stated_error():
    module = study("radiating_bed")
    for length in (0.05, 0.5):
        (full, scene), (thick, _) = (
            module.heat(length, level) for level in ("p1", "rosseland")
        )
        assert 0 < thick / full - 1 < module.estimate(scene, scene.mesh)
