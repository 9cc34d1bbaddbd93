"""Numbers of the studies hold against references computed from the scenes' own
values.
"""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import contbed as cb
from contbed.many.cascade.file import read_cascade
from contbed.packed_bed.recognition import velocities
from tests.balances import assert_closed

STUDIES = Path(__file__).parents[2] / "studies"
CASCADES = sorted(STUDIES.rglob("cascade*.toml"))
PIVEM = sorted(path.stem for path in (STUDIES / "pivem_2012").glob("*.toml"))


def study(name):
    """The script of a study as a module."""
    return import_module(f"studies.{name}.study")


def scene_of(name, scene):
    return cb.load(STUDIES / name / f"{scene}.toml")


def test_pivem_has_a_scene_for_each_row():
    rows = study("pivem_2012").reference()
    assert sorted(rows) == PIVEM
    for name, row in rows.items():
        scene = scene_of("pivem_2012", name)
        fluid, solid, porosity = scene.gas, scene.solid, scene.packed_bed.porosity
        u, u_solid = (float(vector[0]) for vector in velocities(scene))
        found = {
            "u_D_m_s": u,
            "slip_us_over_uD": u_solid / u,
            "particle_diameter_m": scene.diameter,
            "permeability_m2": (scene.diameter * porosity / (12 * (1 - porosity))) ** 2,
            "porosity": porosity,
            "Re_D": scene.packed_bed.reynolds,
            "capacity_ratio_s_over_f": solid.density
            * solid.heat_capacity
            / (fluid.density * fluid.heat_capacity),
            "conductivity_ratio_s_over_f": solid.conductivity / fluid.conductivity,
        }
        assert found == pytest.approx({key: row[key] for key in found}, rel=1e-9), name


@pytest.mark.parametrize("name", PIVEM)
def test_pivem_against_the_closed_form(name):
    scene = scene_of("pivem_2012", name)
    result = cb.run(scene)
    assert result.plan.mesh.skfem.dim() == 1
    assert np.abs(study("pivem_2012").errors(scene, result)).max() < 1e-6


def test_pivem_brinkman_flow_delays_the_equilibrium_on_the_axis():
    scene = scene_of("pivem_2012", "brinkman/darcy_9.365e-3")
    result = cb.run(scene)
    theta, length = study("pivem_2012").equilibrium(scene)
    assert 1.01 < result.qoi["equilibrium_length_m"] / length < 1.03
    assert 0 < theta - result.qoi["theta_equilibrium"] < 0.003
    assert_closed(result, 1e-10)


def test_nakayama_against_the_exact_solution():
    module, scene = study("nakayama_2001"), scene_of("nakayama_2001", "hot_fluid")
    result = cb.run(scene)
    assert np.abs(np.concatenate(module.errors(scene, result))).max() < 1e-8
    assert module.found_parameters(scene, result) == pytest.approx(
        module.exact_parameters(scene), abs=1e-8
    )


@pytest.mark.parametrize(
    ("name", "tolerance"),
    [("schumann", 2e-5), ("schumann_bed_b", 2e-5), ("dispersion", 1e-4)],
)
def test_packed_bed_against_the_exact_solution(name, tolerance):
    module, scene = study("patil_packed_bed"), scene_of("patil_packed_bed", name)
    result = cb.run(scene)
    assert np.unique(result.profiles["t [s]"]).tolist() == [0.5, 1.0, 2.25, 3.25, 4.25]
    chosen = (
        np.isin(result.profiles["z [m]"], [0.05, 0.25, 0.45])
        if name == "dispersion"
        else slice(None)
    )
    assert (
        np.abs(np.concatenate(module.errors(scene, result, chosen))).max() < tolerance
    )


SLIDING = (
    "slip_0.00_darcy",
    "slip_0.00",
    "slip_0.50",
    "slip_-0.25",
    pytest.param("slip_0.95", marks=pytest.mark.slow),
)


@pytest.mark.parametrize("name", SLIDING)
def test_sliding_bed_against_the_exact_flow(name):
    scene = scene_of("brinkman_forchheimer", name)
    result = cb.run(scene)
    assert np.abs(study("brinkman_forchheimer").errors(scene, result)).max() < 1e-8


@pytest.mark.parametrize("name", ["slip_0.00", "slip_0.50", "slip_0.95"])
def test_sliding_bed_converges(name):
    """Fourth order where the drag is smooth; a kink in the channel disturbs it but
    does not stop the convergence.
    """
    module, scene = (
        study("brinkman_forchheimer"),
        scene_of("brinkman_forchheimer", name),
    )
    coarse, fine = (
        np.abs(module.errors(refined, cb.run(refined)))
        for refined in (module.with_cells(scene, across) for across in (16, 64))
    )
    assert np.all(
        np.log(coarse / fine) / np.log(4) > (3.8 if name == "slip_0.00" else 3.0)
    )


@pytest.mark.parametrize("file", CASCADES, ids=lambda file: file.stem)
def test_cascades_of_studies_name_keys_of_their_scenes(file):
    assert read_cascade(file).settings.uncertain
