"""Two-fluid runs whose results are not possible: steps too long, speeds, pressures
and temperatures out of bounds.
"""

from pathlib import Path

import numpy as np
import pytest

import contbed as cb
from contbed.errors import ContbedError, ConvergenceError
from contbed.loading import from_dict
from contbed.two_fluid import plausibility
from contbed.two_fluid import results as findings
from contbed.two_fluid import run as study
from contbed.two_fluid.averages import Averages
from tests.scene_text import scene_of

STUDIES = Path(__file__).parents[2] / "studies"
WALLS = {name: {"type": "wall"} for name in ("left", "right", "bottom", "top")}
BED = scene_of(
    """
        two_fluid = {}
        gas = { density = 1.2, viscosity = 1.8e-5 }
        solids = { beads = { diameter = 275e-6, density = 2500.0 } }
        time = { end = 0.02 }

        [mesh]
        type = "rectangle"
        length = 0.1
        height = 0.4
        cells = [4, 16]

        [initial]
        layer = [{ end = 0.2, solids = { beads = { volume_fraction = 0.58 } } }]
    """,
    {
        "boundary": WALLS
        | {
            "bottom": {"type": "inlet", "gas": {"velocity": 0.3}},
            "top": {"type": "outlet"},
        }
    },
)
HEAT = {
    "heat": {},
    "gas": BED["gas"] | {"heat_capacity": 1000.0, "conductivity": 0.025},
    "solids": {"beads": BED["solids"]["beads"] | {"heat_capacity": 800.0}},
}


def test_a_fixed_step_that_is_too_long_is_cut():
    """Steps of 0.1 s in cells of 4 cm: uncut, particles reach 4e6 m/s."""
    change = {
        "mesh.cells": [8, 24],
        "time.step": 0.1,
        "time.sample": 0.1,
        "time.end": 3.0,
    }
    result = cb.run(cb.load(STUDIES / "taghipour_bed" / "bed_0.46.toml", change))
    assert result.profiles["u_solid_max [m/s]"].max() < 5.0
    assert result.qoi["pressure_drop [Pa]"] == pytest.approx(
        result.qoi["weight_of_solids"], rel=0.5
    )
    assert any(
        "time.step = 0.1 s" in text and "were shortened" in text
        for text in result.warnings
    )


def test_a_fixed_step_within_its_bounds_stays():
    result = cb.run(
        from_dict(BED | {"time": {"end": 0.02, "step": 1e-3, "sample": 0.01}})
    )
    assert result.qoi["steps"] == 20
    assert result.warnings == []


@pytest.mark.filterwarnings("error")  # of numpy's numbers that are too large
def test_a_run_without_guards_that_overheats_says_so(tmp_path, monkeypatch):
    """Particles between no-slip walls, few of them above many; what was computed
    before is kept.
    """
    # theta overflows after 0.1 to 0.2 s and some 300 steps where their heat does not
    # bind these, with guards never
    monkeypatch.setattr("contbed.two_fluid.simulation.HEATING_LIMIT", 1e6)
    walls = BED["boundary"] | {"bottom": {"type": "inlet", "gas": {"velocity": 0.4}}}
    table = {
        "mesh": BED["mesh"] | {"length": 0.05, "cells": [10, 40]},
        "boundary": walls,
        "time": {"end": 0.5, "sample": 0.1},
    }
    table["initial"] = {
        "layer": [{"end": 0.15, "solids": {"beads": {"volume_fraction": 0.58}}}],
        "solids": {"beads": {"granular_temperature": 1e-4}},
    }
    with pytest.raises(
        ConvergenceError, match=r"two_fluid\.guards = false: .*; set guards = true"
    ):
        cb.run(from_dict(BED | table | {"two_fluid": {"guards": False}}), tmp_path)
    assert (tmp_path / "checkpoint.npz").is_file()


def test_impossible_speeds_and_pressures_end_the_run(monkeypatch):
    """What weight, free fall and inlet give is exceeded where the bounds are made a
    thousand times as strict.
    """
    speed, drop = plausibility.largest_speed, plausibility.largest_pressure_drop
    monkeypatch.setattr(
        plausibility, "largest_speed", lambda *given: 1e-3 * speed(*given)
    )
    with pytest.raises(
        ConvergenceError,
        match=r"free fall and what enters give at most.*leave out time\.step",
    ):
        cb.run(from_dict(BED))
    monkeypatch.setattr(plausibility, "largest_speed", speed)
    long = BED | {"time": {"end": 0.2}}
    monkeypatch.setattr(
        plausibility, "largest_pressure_drop", lambda *given: 0.1 * drop(*given)
    )
    assert any(
        "while weight and flow give at most" in text
        for text in cb.run(from_dict(long)).warnings
    )
    monkeypatch.setattr(
        plausibility, "largest_pressure_drop", lambda *given: 1e-3 * drop(*given)
    )
    with pytest.raises(ConvergenceError, match="while weight and flow give at most"):
        cb.run(from_dict(long))


def test_temperatures_beyond_those_given_end_the_run():
    """A wall that gives far too much heat."""
    hot = {"type": "wall", "heat_flux": 1e6}
    warm = BED["boundary"] | {
        "left": hot,
        "bottom": {"type": "inlet", "gas": {"velocity": 0.3, "temperature": 300.0}},
    }
    scene = (
        BED
        | HEAT
        | {
            "initial": BED["initial"] | {"gas": {"temperature": 300.0}},
            "boundary": warm,
        }
    )
    with pytest.raises(
        ConvergenceError, match=r"T_(gas|solid) from .* K, possible are 0 to 6000 K"
    ):
        cb.run(from_dict(scene | {"time": {"end": 2.0}}))


def test_particles_that_are_not_there_have_no_temperature():
    inlet = {
        "bottom": {"type": "inlet", "gas": {"velocity": 0.3, "temperature": 400.0}}
    }
    start = {
        "solids": {"beads": {"volume_fraction": 0.0}},
        "gas": {"temperature": 300.0},
    }
    result = cb.run(
        from_dict(BED | HEAT | {"initial": start, "boundary": BED["boundary"] | inlet})
    )
    assert np.isnan(result.qoi["T_solid_mean [K]"]) and np.isnan(
        result.qoi["T_solid_max [K]"]
    )
    assert np.isnan(result.profiles["T_solid_mean [K]"]).all()
    assert np.isnan(result.tables["axial"]["T_solid [K]"]).all()
    assert (result.tables["axial"]["T_gas [K]"] > 299.0).all()


def test_a_temperature_below_zero_names_the_remedy():
    """Negative heat flux of a wall, in one step so long that the plausibility check
    does not see it coming.
    """
    cold = BED["boundary"] | {"left": {"type": "wall", "heat_flux": -1e9}}
    cold |= {
        "bottom": {"type": "inlet", "gas": {"velocity": 0.3, "temperature": 300.0}}
    }
    scene = (
        BED
        | HEAT
        | {
            "initial": BED["initial"] | {"gas": {"temperature": 300.0}},
            "boundary": cold,
        }
    )
    with pytest.raises(
        ConvergenceError,
        match=r"T_(gas|solid) falls to -\S+ K, not above 0 K: a wall with a negative",
    ):
        cb.run(from_dict(scene))


def test_closures_with_parameters_of_heat_run_to_the_end():
    nusselt = {"name": "power", "a": 1.2, "b": 0.5}
    inlet = {
        "bottom": {"type": "inlet", "gas": {"velocity": 0.3, "temperature": 400.0}}
    }
    start = BED["initial"] | {"gas": {"temperature": 300.0}}
    heat = HEAT | {
        "closures": {"nusselt": nusselt},
        "initial": start,
        "boundary": BED["boundary"] | inlet,
    }
    result = cb.run(from_dict(BED | heat))
    assert any("power" in closure["name"] for closure in result.closures)


@pytest.mark.parametrize(("owner", "name"), [(findings, "tables"), (Averages, "means")])
def test_what_cannot_be_evaluated_is_told_before_the_steps(monkeypatch, owner, name):
    def broken(*arguments):
        raise ValueError("zero-size array")

    monkeypatch.setattr(owner, name, broken)
    monkeypatch.setattr(
        study.Simulation, "step", lambda *_: pytest.fail("the bed has been stepped")
    )
    with pytest.raises(
        ContbedError, match="tables cannot be evaluated: ValueError: zero-size array"
    ):
        cb.run(from_dict(BED | {"time": {"end": 0.02, "average_from": 0.01}}))


def test_a_table_that_fails_does_not_lose_the_others(tmp_path, monkeypatch):
    tables = findings.tables

    def broken(plan, bed, *rest):
        if bed.state.steps > 0:
            raise ValueError("zero-size array")
        return tables(plan, bed, *rest)

    monkeypatch.setattr(findings, "tables", broken)
    with pytest.raises(ContbedError, match="tables cannot be evaluated"):
        cb.run(from_dict(BED), tmp_path)
    assert np.loadtxt(tmp_path / "profiles.csv", delimiter=",", skiprows=1)[
        -1, 0
    ] == pytest.approx(0.02)
    summary = (tmp_path / "summary.json").read_text()
    assert '"max_velocity"' in summary
    assert '"status": "failed"' in summary
    assert "tables cannot be evaluated" in summary


@pytest.mark.parametrize("speed", [0.0, 0.1])
@pytest.mark.parametrize("eps_s", [0.0, 0.3])
@pytest.mark.parametrize("gravity", [0.0, 9.81])
def test_gas_between_no_slip_walls(speed, eps_s, gravity):
    lid = {"top": {"type": "wall", "velocity": [speed, 0.0]}}
    scene = BED | {
        "boundary": WALLS | lid,
        "initial": {"solids": {"beads": {"volume_fraction": eps_s}}},
        "two_fluid": {"gravity": gravity},
    }
    result = cb.run(from_dict(scene))
    assert result.status == "ok"
    assert np.isfinite(result.profiles["u_solid_max [m/s]"]).all()


def test_particles_fall_during_the_whole_run_through_periodic_ends():
    """In a periodic cell of 1 cm free fall of 0.5 s gives 4.9 m/s, and no error."""
    ends = {"bottom": {"type": "periodic", "partner": "top"}}
    sides = {name: {"type": "symmetry"} for name in ("left", "right")}
    bed = BED | scene_of(
        """
            closures = { drag = "none" }
            initial = { solids = { beads = { volume_fraction = 0.2 } } }
            time = { end = 0.5 }

            [mesh]
            type = "rectangle"
            length = 0.01
            height = 0.01
            cells = [2, 2]
        """,
        {"boundary": ends | sides},
    )
    result = cb.run(from_dict(bed))
    fastest = result.profiles["u_solid_max [m/s]"][-1]
    assert fastest == pytest.approx(0.5 * 9.81, rel=1e-3)
    assert not any("not stable" in text for text in result.warnings)


SLOT = {"type": "outlet", "on": "bottom", "start": 0.02, "end": 0.04}
BEADS = {"diameter": 1e-3, "density": 2500.0, "packing_limit": 0.63}
SILO = {
    "mesh": {"type": "rectangle", "length": 0.06, "height": 0.16, "cells": [18, 48]},
    "solids": {"beads": BEADS},
    "closures": {"friction_viscosity": "friction_viscosity_schaeffer"},
    "boundary": WALLS
    | {name: {"type": "symmetry"} for name in ("left", "right")}
    | {"top": {"type": "outlet"}, "slot": SLOT},
    "initial": {
        "layer": [{"end": 0.14, "solids": {"beads": {"volume_fraction": 0.6}}}]
    },
    "time": {"end": 0.2, "sample": 0.1},
}


SILO_AT_REST = BED | {
    "boundary": WALLS | {"top": {"type": "outlet"}},
    "solids": {"beads": BEADS},
    "time": {"end": 0.3},
}


def test_a_silo_discharges_through_a_slot():
    """Beverloo's rate for a slot of width D, 1.03 rho_bulk sqrt(g) (D - 1.4 d_p)^1.5
    (Nedderman 1992, Statics and kinematics of granular materials, ISBN 0521404355),
    is 12.3 kg/s/m.

    Cells of 5, 2.5 and 1.25 mm give 57, 72 and 80 % of it, in the limit of fine cells
    about 88 %; these of 3.3 mm are to give from 55 to 80 %. If friction did not push
    particles out, 2 % would be left.
    """
    result = cb.run(from_dict(BED | SILO))
    first, last = result.profiles["solids [kg]"][1:]
    bulk = 0.6 * BEADS["density"]
    beverloo = 1.03 * bulk * np.sqrt(9.81) * (0.02 - 1.4e-3) ** 1.5
    assert 0.55 < (first - last) / 0.1 / beverloo < 0.8
    assert not any("like honey" in text for text in result.warnings)


def test_a_bed_laid_too_densely_says_that_it_expands():
    """Friction of 20.6 kPa at 0.6 against some 3 kPa of weight; 1 kPa at 0.58 is less."""
    reported = [
        any("push each other apart by 2.06e+04 Pa" in text for text in warnings)
        for warnings in (
            cb.run(from_dict(SILO_AT_REST | {"initial": {"layer": [layer]}})).warnings
            for layer in (
                {"end": 0.2, "solids": {"beads": {"volume_fraction": fraction}}}
                for fraction in (0.6, 0.58)
            )
        )
    ]
    assert reported == [True, False]


def test_newtonian_friction_at_an_outlet_below_is_reported():
    """Its beads flow like honey; friction on the floor does not matter."""
    short = {"time": {"end": 1e-4}, "closures": {}}
    reported = [
        any("like honey" in text for text in warnings)
        for warnings in (
            cb.run(from_dict(BED | SILO | short | {"boundary": boundary})).warnings
            for boundary in (WALLS | {"top": {"type": "outlet"}}, SILO["boundary"])
        )
    ]
    assert reported == [False, True]
