"""Sizes of particles by feed, drain and carry-over, and the height of a bed, with
the state they belong to.
"""

import numpy as np
import pytest
from computed_scenes import HOT, hot, tables
from pytest import approx

import contbed as cb
from contbed.bubbling_bed.problem import BubblingProblem
from contbed.errors import ConvergenceError
from contbed.loading import from_dict
from tests.balances import assert_closed
from tests.refusals import refused
from tests.scene_text import scene_of, set_keys

SAND = {"diameters": [1e-4, 2e-4, 5e-4, 1e-3], "feed": [0.1, 0.2, 0.4, 0.3]}


def sized(**changes):
    """The hot bed with sand of four sizes, fed and drained, below a freeboard."""
    found = tables(**{"freeboard": {"height": 6.0, "elutriation": "geldart"}} | changes)
    sand = found["solids"]["inert"]
    sand.pop("diameter")
    sand["sizes"] = dict(SAND)
    sand["feed"] = {
        "mass_flow": 0.2,
        "temperature": 300.0,
        "height": 0.2,
        "width": 0.05,
    }
    found["mesh"] = {"cells": 16}
    return found


def test_mass_of_every_size_is_balanced():
    result = cb.run(from_dict(sized()))
    assert_closed(result, 1e-12, "energy")
    problem_sizes = result.plan.scene.solids["inert"].sizes
    x, feed = np.array(problem_sizes.bed), 0.2 * np.array(SAND["feed"])
    assert x.sum() == approx(1.0, rel=1e-12)
    drain = result.qoi["inert_drain_kg_s"]
    carried = feed - drain * x
    # fine sizes are carried away first
    assert np.all(carried >= -1e-12) and np.all(np.diff(carried / x) <= 1e-12)
    assert x[0] < SAND["feed"][0] and x[-1] > SAND["feed"][-1]
    assert carried.sum() == approx(result.qoi["inert_carryover_kg_s"], rel=1e-10)
    diameter = 1.0 / np.sum(x / np.array(SAND["diameters"]))
    assert result.qoi["inert_diameter_m"] == approx(diameter, rel=1e-8)
    assert result.plan.scene.solids["inert"].diameter == approx(diameter, rel=1e-8)


def test_particles_thrown_over_the_end_of_a_freeboard_take_all_sizes_alike():
    """Without elutriation the bed keeps the sizes of the feed, and what leaves is the
    share of the phase in what the gas carries away.
    """
    scene = from_dict(sized(freeboard={"height": 6.0, "elutriation": 0.0}))
    result = cb.run(scene)
    assert result.plan.scene.solids["inert"].sizes.bed == approx(
        SAND["feed"], rel=1e-10
    )
    share = BubblingProblem(result.plan).above.shares["inert"]
    carried = share * result.qoi["carryover_kg_s"]
    assert carried > 1e-6
    assert result.qoi["inert_carryover_kg_s"] == approx(carried, rel=1e-8)
    assert result.qoi["inert_drain_kg_s"] == approx(0.2 - carried, rel=1e-10)


@pytest.mark.parametrize("height", [6.0, 9.0])
def test_the_gas_carries_away_what_feed_and_drain_leave_of_the_only_solid(height):
    scene = sized(freeboard={"height": height, "elutriation": "geldart"})
    sand = scene["solids"].pop("inert")
    scene["solids"] = {"inert": sand | {"volume_share": 1.0}}
    found = cb.run(from_dict(scene)).qoi
    # sizes have settled to 1e-9 of their diameter
    assert found["inert_carryover_kg_s"] == approx(found["carryover_kg_s"], rel=1e-7)


def test_a_feed_too_small_for_what_is_carried_away_is_told():
    scene = sized(freeboard={"height": 6.0, "elutriation": 5.0})
    set_keys(scene, "solids.inert.feed.mass_flow = 1e-3")
    with pytest.raises(ConvergenceError, match="feed more or coarser"):
        cb.run(from_dict(scene))


@pytest.mark.parametrize("expansion", [None, "souza_santos"])
def test_height_of_the_bubbling_bed(expansion):
    bed = {"settled_height": 0.4, "section": 1.0, "solids_fraction": 0.5}
    closures = {"expansion": expansion} if expansion else {}
    result = cb.run(hot(bubbling_bed=bed, closures=closures, mesh={"cells": 24}))
    height = result.qoi["bed_height_m"]
    assert result.profiles["z [m]"][-1] == approx(height, rel=1e-12)
    if expansion is None:
        assert not any("expansion" in text for text in result.warnings)
        # the trapezoidal rule of the table; the balance itself is to round-off
        assert result.qoi["height_at_minimum_fluidization_m"] == approx(0.4, rel=1e-4)
    else:
        assert 0.45 < height < 1.5
        dense = result.qoi["height_at_minimum_fluidization_m"]
        assert (
            f"without its bubbles the bed is {dense:.3g} m high" in result.warnings[-1]
        )
    direct = cb.run(
        hot(bubbling_bed={**HOT["bubbling_bed"], "height": height}, mesh={"cells": 24})
    )
    # cells of another grading
    assert result.qoi["T_inert_mid_K"] == approx(direct.qoi["T_inert_mid_K"], rel=1e-5)


def test_sizes_that_cannot_be_balanced_are_refused():
    refused(
        r"needs \[bubbling_bed.freeboard\] with a height",
        lambda: from_dict(sized(freeboard={"temperature": 900.0})),
    )
    wrong = sized()
    set_keys(
        wrong,
        """
        solids.inert.sizes = { diameters = [1e-4, 1e-3], feed = [0.5, 0.4] }
        """,
    )
    refused(r"sum to 1; found 0\.9", from_dict, wrong)


def test_tubes_that_do_not_fit_are_told():
    """2 A/p is the width of slits; circles that touch fill pi/(2 sqrt 3) of a
    section, of 0.0127 m in 1 m2 285.6 m.
    """
    refused(
        r"tubes\.perimeter.*leaves 0\.002 m .* particles of 0\.003 m; .* 666\.7 m",
        hot,
        tubes__perimeter=1000.0,
    )
    (text,) = hot(tubes__perimeter=300.0).warnings
    assert "12.7 mm that touch each other have 285.6 m in 1 m2" in text
    assert not hot(tubes__perimeter=280.0).warnings
    above = {
        "height": 2.0,
        "tubes": {"perimeter": 300.0, "coefficient": 50.0, "temperature": 550.0},
    }
    (text,) = hot(freeboard=above).warnings
    assert "freeboard.tubes.perimeter" in text


def test_a_bed_of_igniting_bubbles_that_expands_far_is_followed_in_height(monkeypatch):
    """Its height nearly triples, which one step of Newton's method does not survive:
    gas in bubbles ignites at another place. No step in time is taken, which would cost
    four times as much as the whole run.
    """
    monkeypatch.setattr(BubblingProblem, "_marched", None)
    monkeypatch.setattr(BubblingProblem, "_unbent", None)
    scene = scene_of(
        """
        [bubbling_bed]
        settled_height = 0.4
        section = 4
        solids_fraction = 0.56
        bubbles = {}
        tubes = { perimeter = 6, coefficient = 280, temperature = 573.15 }
        [gas]
        composition = "C3H8:0.03, O2:0.2037, N2:0.7663"
        [boundary.bottom]
        gas = { mass_flow = 2.5, temperature = 293.15 }
        [solids.sand]
        diameter = 1.1e-3
        density = 2600
        heat_capacity = 1100
        nusselt = "gunn"
        mixing_conductivity = 1e5
        [reactions.burn]
        equation = "C3H8 + 5 O2 -> 3 CO2 + 4 H2O"
        rate = "k*exp(-E/(R*T))*c_C3H8"
        parameters = { k = 1e7, E = 1e5 }
        basis = "gas"
        """
    )
    result = cb.run(from_dict(scene))
    z, T = result.profiles["z [m]"], result.profiles["T_sand [K]"]
    solids = 1.0 - result.profiles["delta [1]"]
    assert np.trapezoid(solids, z) == approx(0.4, rel=1e-3)
    # 85.3 mol/s with 2.559 mol/s of propane, lower heating value 2043 kJ/mol; mean heat
    # capacities of the products from 293 to 1444 K [J/mol/K]; the gas of the bubbles
    # leaves 31 K hotter than the sand, which is 2 % of the heat
    heat = 2.559 * 2043e3
    gas = 7.68 * 50.9 + 10.24 * 39.8 + 4.58 * 33.6 + 65.37 * 31.8
    tubes = 6.0 * 280.0 * np.trapezoid(T - 573.15, z)
    assert tubes + gas * (T.mean() - 293.15) == approx(heat, rel=0.03)


def test_a_branch_warns_of_a_height_that_it_keeps():
    """Twice the gas: the bubbles of the last state fill what the warning says."""
    bed = {"settled_height": 0.4, "section": 1.0, "solids_fraction": 0.5}
    key = "boundary.bottom.gas.mass_flow"
    scene = hot(bubbling_bed=bed, mesh={"cells": 24})
    start = scene.gas_flow
    way = {"parameter": key, "to": 2.0 * start}
    result = cb.run(hot(bubbling_bed=bed, mesh={"cells": 24}, continuation=way))
    (text,) = [each for each in result.warnings if "the branch keeps" in each]
    assert f"{result.qoi['bed_height_m']:.3g} m" in text
    assert f"{key} = {2.0 * start:.6g}" in text
    short = hot(
        bubbling_bed=bed, mesh={"cells": 24}, continuation=way | {"to": 1.01 * start}
    )
    assert not any("the branch keeps" in each for each in cb.run(short).warnings)
