"""One reactor by several models: what they have in common, and how it is shown."""

from __future__ import annotations

import csv

import numpy as np
from pytest import approx

from contbed.many.compare import TABLE, Comparison, Outcome, compare
from contbed.output.common_results import Value, common_results
from tests.refusals import refused


def value(number, unit="K"):
    return Value(number, unit, "")


FOUND = Comparison(
    (
        Outcome(
            "packed_bed", {"T_gas_out": value(400.0), "bed_height": value(1.0, "m")}
        ),
        Outcome(
            "two_fluid",
            {"T_gas_out": value(404.0)},
            seconds=2.0,
            ignored=("packed_bed",),
            skipped=(("radiation", "no [radiation] table"),),
            warnings=("3 % of the particles have left",),
        ),
        Outcome("bubbling_bed", problem="the bed does not fluidize"),
    )
)


def test_quantities_of_one_model_are_left_out():
    assert list(FOUND.shared) == ["T_gas_out"]


def test_differences_are_to_the_first_model_that_has_the_result():
    assert FOUND.difference("T_gas_out", FOUND.outcomes[0]) is None
    assert FOUND.difference("T_gas_out", FOUND.outcomes[1]) == approx(0.01)
    assert FOUND.difference("T_gas_out", FOUND.outcomes[2]) is None


def test_the_text_says_what_each_leaves_out():
    text = FOUND.text()
    assert "404 (+1 %)" in text
    assert "leaves out radiation: no [radiation] table" in text
    assert "ignores packed_bed" in text
    assert "warning: 3 % of the particles have left" in text
    assert "failed: the bed does not fluidize" in text


def test_means_over_different_times_are_not_compared():
    """A steady run has no such time, and is compared."""

    def outcome(model, since):
        return Outcome(model, {"heat_left": Value(2.0, "W", "", since)})

    found = Comparison((outcome("a", 0.0), outcome("b", 60.0), outcome("c", None)))
    assert found.difference("heat_left", found.outcomes[1]) is None
    assert found.difference("heat_left", found.outcomes[2]) == 0.0
    assert "heat_left: of b in the mean since 60 s, of the first since 0 s" in (
        found.text()
    )
    assert "of c" not in found.text()
    qoi = {"heat_left_W": 2.0, "bed_height_m": 1.0}
    common = common_results(qoi, {}, [], since=60.0)
    assert common["heat_left"].since == 60.0 and common["bed_height"].since is None


def test_files_hold_the_numbers(tmp_path):
    FOUND.write(tmp_path)
    with open(tmp_path / TABLE, encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["quantity", "packed_bed", "two_fluid", "bubbling_bed"]
    assert rows[1] == ["T_gas_out [K]", "400", "404", ""]


def test_named_results_come_before_columns():
    z = np.array([0.0, 1.0, 3.0])
    tables = {
        "profiles": {"z [m]": z, "T_sand [K]": 300.0 + z, "T_emulsion [K]": 2 * z}
    }
    found = common_results({"x_CO_wet": 0.1, "T_solid_mean_K": 5.0}, tables, ["sand"])
    assert found["x_CO_out"].value == 0.1
    assert found["T_solids_mean"].value == 5.0
    assert found["T_gas_mean"].value == approx(3.0)  # of 2 z over 0 to 3
    found = common_results({}, tables, ["sand"])
    assert found["T_solids_mean"].value == approx(301.5)


def test_points_without_a_value_are_left_out_of_means():
    table = {
        "height [m]": np.array([0.0, 1.0, 2.0]),
        "T_gas [K]": np.array([300.0, 400.0, np.nan]),
    }
    found = common_results({}, {"axial": table}, [])
    assert found["T_gas_mean"].value == approx(350.0)


def test_an_unknown_model_is_named(tmp_path):
    refused(
        r"--models: 'packd_bed': .*'packed_bed'",
        compare,
        "scene.toml",
        ["packd_bed"],
        tmp_path,
    )
