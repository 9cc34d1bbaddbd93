"""Guesses, sizes and numbers that break models of beds: each converges, closes its
balance, and says what it did.
"""

import numpy as np
import pytest
from bubbling_scenes import case1, changed, solids, solved, values
from pytest import approx

from contbed.errors import SceneError
from contbed.loading import from_dict
from tests.cases import each_case
from tests.refusals import refusal, refused

GUESSES = (400.0, 700.0, 1000.0, 1150.0, 1500.0, 2000.0)


@pytest.mark.parametrize("name", ["p1", "two_flux", "paper_closure", "none"])
def test_six_uniform_guesses_lead_to_one_state(name):
    found = [solved(case1(name, initial={"temperature": guess})) for guess in GUESSES]
    assert max(len(result.history) for result in found) <= 12
    for result in found[1:]:
        assert result.qoi == approx(found[0].qoi, rel=1e-9)
    assert found[0].qoi["steady_states_found"] == 1


def ignitable(guess):
    """Char that needs heat to burn, in a bed with less heat from the gas."""
    release = {**values()["solids"]["char"]["release"], "activation": 8000.0}
    gas = {"rate": 1.0e6, "length": 0.3}
    return case1(
        solids=solids(char={"release": release}),
        release=gas,
        initial={"temperature": guess},
    )


def test_ignited_and_extinguished_states_are_told_apart():
    cold, hot = solved(ignitable(400.0)), solved(ignitable(1500.0))
    assert (
        650 < cold.qoi["T_inert_mid_K"] < 700 and 1100 < hot.qoi["T_inert_mid_K"] < 1200
    )
    assert hot.qoi["release_char_W"] > 50 * cold.qoi["release_char_W"]
    for result in (cold, hot):
        assert result.qoi["steady_states_found"] == 2
        assert any("several steady states" in text for text in result.warnings)


def test_tiny_feeds_are_no_feeds():
    found = []
    for flow in (2e-5, 0.0):
        particles = solids()
        for name in ("char", "limestone"):
            particles[name]["feed"]["capacity_flow"] = flow
        found.append(solved(case1(solids=particles)).qoi)
    assert found[0] == approx(found[1], rel=1e-6)


@pytest.mark.parametrize("name", ["char", "limestone"])
def test_a_species_that_vanishes_is_left_out(name):
    rest = {"inert": {"volume_share": 0.98 if name == "limestone" else 0.82}}
    absent = solids(
        **{name: {"volume_share": 0.0, "feed": None, "release": None}}, **rest
    )
    without = solved(case1(solids=absent))
    assert (
        f"T_{name}_mid_K" not in without.qoi and f"T_{name} [K]" not in without.profiles
    )
    assert (f"solids {name}", "volume_share is 0") in without.plan.skipped
    rest["inert"]["volume_share"] -= 1e-7
    trace = solids(
        **{name: {"volume_share": 1e-7, "feed": None, "release": None}}, **rest
    )
    # heat that a trace passes on is not proportional to what there is of it
    for other in trace.values():
        other.get("exchange", {}).pop(name, None)
    trace[name].pop("exchange", None)
    present = solved(case1(solids=trace))
    for key, value in without.qoi.items():
        assert present.qoi[key] == approx(value, rel=1e-5), key


def test_no_bubbles():
    none = solved(case1(bubbles=None))
    zero = solved(
        case1(bubbles={"fraction": 0.0, "capacity_flow": 0.0, "exchange": 3000.0})
    )
    few = solved(
        case1(bubbles={"fraction": 1e-7, "capacity_flow": 1e-6, "exchange": 3000.0})
    )
    assert zero.qoi == none.qoi and "T_bubble_top_K" not in none.qoi
    assert {name: few.qoi[name] for name in none.qoi} == approx(none.qoi, rel=1e-6)


def test_one_species():
    alone = {"inert": {**solids()["inert"], "volume_share": 1.0}}
    p1, paper = (
        solved(case1(solids=alone)),
        solved(case1("paper_closure", solids=alone)),
    )
    assert set(p1.qoi) >= {"T_inert_mid_K"}
    assert abs(p1.qoi["T_inert_mid_K"] - paper.qoi["T_inert_mid_K"]) < 100


def test_ten_species_of_all_sizes():
    ten = {
        f"s{k}": {
            "volume_share": 0.1,
            "diameter": 1e-4 * 2.0**k,
            "emissivity": 0.1 + 0.08 * k,
            "gas_coefficient": 40.0 + 20.0 * k,
            "mixing_conductivity": 10.0 ** (k - 4),
            "exchange": {f"s{other}": 10.0 ** (other - 2) for other in range(k)},
            "feed": {
                "capacity_flow": 10.0 ** (k - 8),
                "temperature": 300.0 + 50.0 * k,
                "height": 0.06 * k,
                "width": 0.02,
                "drain": "top" if k % 2 else "bottom",
            },
            "release": {
                "rate": 2e4 * (k - 4),
                "activation": 500.0 * k,
                "reference": 1100.0,
            },
        }
        for k in range(10)
    }
    result = solved(case1(solids=ten))
    columns = [
        values for header, values in result.profiles.items() if header.startswith("T_s")
    ]
    assert len(columns) == 10 and np.min(columns) > 300 and np.max(columns) < 2500


@pytest.mark.parametrize("factor", [0.0, 1e-9, 1e6])
def test_mixing_from_none_to_perfect(factor):
    mixing = {
        name: {"mixing_conductivity": factor * item["mixing_conductivity"]}
        for name, item in solids().items()
    }
    # conduction of 2e10 W/m/K over 0.1 mm rounds temperatures of 1e3 K to 1e-10 of the
    # heat
    result = solved(case1(solids=solids(**mixing)), 1e-10 if factor > 1 else 1e-12)
    spread = np.ptp(result.profiles["T_inert [K]"])
    assert spread < 1e-2 if factor > 1 else spread > 100


def test_hopeless_newton_is_marched_to_its_state():
    """All the heat of the char released by a millionth of it: far beyond any bed,
    and Newton's method alone fails.
    """
    result = solved(
        case1(
            solids=solids(
                char={"volume_share": 1e-6}, inert={"volume_share": 0.82 - 1e-6}
            )
        )
    )
    assert 5000 < result.qoi["T_char_mid_K"] < 7000


@each_case(__file__, "bad_scenes")
def test_bad_scenes_are_explained(said, changes, without):
    keys = changes | dict.fromkeys(without)
    paths = {tuple(key.split(".")): value for key, value in keys.items()}
    refused(said, lambda: from_dict(changed(values(), paths)))


def test_all_mistakes_at_once_with_their_lines():
    from contbed.loading import loads

    text = (
        "[bubling_bed]\nheight = 1.0\n\n[boundary.bottom]\ngas.capacity_flow = "
        "-1.0\ngas.temperature = '20 degC'\n"
    )
    lines = refusal(loads, text, "bed.toml").splitlines()
    assert any(
        line.startswith("bed.toml:1: bubling_bed: unknown key")
        and "'bubbling_bed'" in line
        for line in lines
    )
    assert any(
        line.startswith(
            "bed.toml:5: boundary.bottom.gas.capacity_flow = -1.0: out of range"
        )
        for line in lines
    )


def test_former_keys_name_the_present_ones():
    from contbed.loading import loads

    text = """
[bubbling_bed]
height = 0.6
section = 1.0
solids_fraction = 0.5
[gas]
mass_flow = 0.6
composition = "N2:0.79, O2:0.21"
[species.coal]
volume_fraction = 1.0
[walls]
perimeter = 4.0
[fuel]
species = "coal"
[solver]
guess = 900.0
"""
    with pytest.raises(SceneError) as error:
        loads(text, "bed.toml")
    for told in (
        "bed.toml:7: gas.mass_flow = 0.6: this key is called "
        "'boundary.bottom.gas.mass_flow' now",
        "bed.toml:10: species.coal.volume_fraction = 1.0: this key is called "
        "'solids.coal.volume_share' now",
        "bed.toml:11: walls: this key is called 'bubbling_bed.walls' now",
        "bed.toml:13: fuel: this table is [solids.NAME.fuel] now",
        "bed.toml:16: solver.guess = 900.0: this key is called 'initial.temperature' "
        "now",
    ):
        assert told in str(error.value)
