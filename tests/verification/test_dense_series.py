"""Packed beds whose series have many points: steps pass kinks that are small beside
their errors, and no others.

A run that is cut at every kink is the reference; its steps are so short that their
errors do not count.
"""

import numpy as np
import pytest

import contbed as cb
from contbed.loading import from_dict
from contbed.models import plan
from contbed.packed_bed import plan as packed_plan
from tests.balances import assert_closed
from tests.scene_text import scene_of

END, POINTS = 6000.0, 151
TIMES = np.linspace(0.0, END, POINTS)
TOLERANCE = 1e-3
PARTICLES = {
    "density": 2000.0,
    "heat_capacity": 900.0,
    "conductivity": 2.0,
    "diameter": 0.005,
}


def series(values, **more):
    return {"times": TIMES.tolist(), "values": values.tolist(), **more}


def swing(low, high, periods=1.0):
    """Values that swing from the lower one as a cosine does."""
    return low + 0.5 * (high - low) * (
        1.0 - np.cos(2.0 * np.pi * periods * TIMES / END)
    )


def bed(**tables):
    scene = scene_of(
        """
        [mesh]
        type = "line"
        length = 0.5
        cells = 30
        [gas]
        density = 1.2
        heat_capacity = 1000.0
        conductivity = 0.03
        viscosity = 2e-5
        [packed_bed]
        porosity = 0.4
        [closures]
        nusselt = 10.0
        [heat]
        [boundary.left]
        gas.velocity = 0.3
        [initial]
        gas.temperature = 300.0
        solids.particles.temperature = 300.0
        [output]
        positions = [0.1, 0.5]
        plots = false
        """,
        {
            "solids.particles": PARTICLES,
            "boundary.left.gas.temperature": series(swing(300.0, 400.0)),
            "time.end": END,
            "time.tolerance": TOLERANCE,
        },
    )
    scene["time"]["times"] = np.linspace(600.0, END, 10).tolist()
    return {
        key: {**scene.get(key, {}), **tables.get(key, {})}
        for key in {**scene, **tables}
    }


FIXED = {"fixed_temperature": series(swing(300.0, 340.0, 1.5))}
SCENES = {
    "temperature": bed(),
    "several": bed(
        boundary={
            "left": {
                "gas": {"velocity": 0.3, "temperature": series(swing(300.0, 400.0))}
            },
            "right": {
                "solids": {
                    "particles": {
                        "coefficient": 50.0,
                        "ambient": series(swing(300.0, 340.0, 1.5)),
                    }
                }
            },
        }
    ),
    "fixed_temperature": bed(
        boundary={
            "left": {
                "gas": {"velocity": 0.3, "temperature": series(swing(300.0, 400.0))},
                "solids": {"particles": FIXED},
            },
            "right": {
                "solids": {"particles": {"heat_flux": series(swing(0.0, 500.0))}}
            },
        }
    ),
    "inside": bed(solids={"particles": {**PARTICLES, "inside": {"heat": "interior"}}}),
}


def found(scene):
    result = cb.run(from_dict(scene), quiet=True)
    assert_closed(result, 1e-12, "energy")
    return result


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_kinks_that_are_small_are_passed(monkeypatch, scene):
    """Errors of some steps' tolerance over the span of 100 K, for a fourth of the
    steps.
    """
    passed = found(scene)
    intervals = plan(from_dict(scene)).intervals()
    assert len(intervals) == 1 and len(intervals[0].schedule.samples) == str(
        scene["boundary"]
    ).count("times")
    monkeypatch.setattr(packed_plan, "kinks_passed", lambda *_: None)
    cut = found(scene)
    assert passed.qoi["time_steps"] < 0.25 * cut.qoi["time_steps"]
    for name in ("T_fluid [K]", "T_solid [K]"):
        off = np.abs(passed.profiles[name] - cut.profiles[name]).max()
        assert off < 5.0 * TOLERANCE * 100.0, name


def test_errors_follow_the_tolerance(monkeypatch):
    """A tenth of it leaves less than a fourth of the error."""
    errors = []
    for tolerance in (1e-2, 1e-3):
        scene = bed(time={"tolerance": tolerance})
        errors.append(found(scene).profiles["T_fluid [K]"])
    monkeypatch.setattr(packed_plan, "kinks_passed", lambda *_: None)
    exact = found(bed(time={"tolerance": 1e-6})).profiles["T_fluid [K]"]
    loose, tight = (np.abs(T - exact).max() for T in errors)
    assert tight < 0.25 * loose


def test_a_step_does_not_jump_over_what_it_does_not_see(monkeypatch):
    """A rise of 40 K for some minutes, long after the bed is hot, when steps are
    longer than that.
    """
    times = np.linspace(0.0, 30000.0, 601)
    apart = np.clip((times - 20000.0) / 2000.0, 0.0, 1.0)
    values = 400.0 + 20.0 * (1.0 - np.cos(2.0 * np.pi * apart))
    inflow = {"times": times.tolist(), "values": values.tolist()}
    scene = bed(
        boundary={"left": {"gas": {"velocity": 0.3, "temperature": inflow}}},
        time={
            "end": 30000.0,
            "tolerance": 1e-2,
            "times": [20800.0, 21200.0, 22000.0, 30000.0],
        },
    )
    assert len(plan(from_dict(scene)).intervals()) == 1
    passed = found(scene)
    monkeypatch.setattr(packed_plan, "kinks_passed", lambda *_: None)
    cut = found(scene)
    assert np.ptp(cut.profiles["T_fluid [K]"]) > 10.0
    np.testing.assert_allclose(
        passed.profiles["T_fluid [K]"], cut.profiles["T_fluid [K]"], rtol=0.0, atol=2.0
    )


def test_no_step_crosses_a_jump_or_a_kink_that_matters():
    """Steps end where the velocity jumps, and where the temperature stops to rise at
    once.
    """
    rises = np.minimum(300.0 + 100.0 * TIMES / 2000.0, 400.0)
    scene = bed(
        boundary={
            "left": {
                "gas": {
                    "velocity": {"times": [0.0, 3333.0], "values": [0.3, 0.2]},
                    "temperature": series(rises),
                }
            }
        },
    )
    intervals = plan(from_dict(scene)).intervals()
    assert [interval.start for interval in intervals] == [0.0, 2000.0, 3333.0]
    assert [interval.jumps for interval in intervals[1:]] == [False, True]
    times = found(scene).tables["outlet"]["t [s]"]
    for moment in (2000.0, 3333.0):
        assert np.abs(times - moment).min() < 1e-9


@pytest.mark.parametrize("time", [{"step": 50.0}, {"cycle": {}}], ids=["step", "cycle"])
def test_steps_of_one_length_and_cycles_meet_every_kink(time):
    """The parts of a cycle tell when the bed is charged and when it is discharged."""
    scene = bed()
    del scene["time"]["tolerance"]
    scene["time"] |= time
    assert len(plan(from_dict(scene)).intervals()) == POINTS - 1
