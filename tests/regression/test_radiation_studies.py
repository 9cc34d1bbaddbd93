"""Every scene of the radiation studies runs; their numbers hold against contbed.verify at the scenes' own values."""

import importlib.util
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import contbed as cb

STUDIES = Path(__file__).parents[2] / "studies"


@cache
def study(name, script="study"):
    """A script of a study as a module."""
    spec = importlib.util.spec_from_file_location(f"{script}_{name}", STUDIES / name / f"{script}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def scenes(name):
    """All scenes of a study as parameters."""
    folder = STUDIES / name
    return [pytest.param(path, id=str(path.relative_to(folder))[:-5]) for path in sorted(folder.rglob("*.toml"))]


def run(scene):
    """The result of a run whose balances close."""
    result = cb.run(scene)
    assert all(abs(balance["relative_residual"]) < 1e-10 for balance in result.balances.values())
    return result


@pytest.mark.parametrize("path", scenes("heaslet_warming"))
def test_plates_in_radiative_equilibrium(path):
    module, scene = study("heaslet_warming"), cb.load(path)
    found = module.found(run(scene))
    if scene.radiation.level == "ordinates":
        assert found[0] == pytest.approx(module.exact(scene)[0], rel=6e-4)
        assert found[1] == pytest.approx(module.exact(scene)[1], rel=6e-3)
    else:
        assert found == pytest.approx(module.closed_form(scene), rel=1e-10)


@pytest.mark.parametrize(("ordinates", "flux", "slip"), [(2, 8e-3, 2e-2), (4, 6e-4, 6e-3), (8, 4e-5, 2e-3), (16, 3e-6, 3e-4)])
def test_ordinates_converge_to_transport(ordinates, flux, slip):
    module = study("heaslet_warming")
    for tau in module.THICKNESSES:
        scene = module.variant(tau, "ordinates", ordinates)
        error = np.abs(module.found(run(scene)) / module.exact(scene) - 1)
        assert error[0] < flux and error[1] < slip
