"""The comparison with IDAES: what its tables say, with or without IDAES."""

from __future__ import annotations

import pytest

from studies._gallery import Table
from studies.clc_moving_bed import beside_idaes as study

RUNS = Table.read(study.HERE / "idaes.csv")
EQUAL = Table.read(study.HERE / "idaes_equal_error.csv")


def test_idaes_approaches_the_shooting_of_its_own_equations():
    exact = Table.read(study.HERE / "steps.csv").row("as coded in the flowsheet")
    best = (
        RUNS["error"]
        .tolist()
        .index(
            min(
                e
                for e, c in zip(RUNS["error"], RUNS["code"], strict=True)
                if c != "contbed"
            )
        )
    )
    for key in study.RESULTS:  # ten digits are written
        assert RUNS[key][best] == pytest.approx(exact[key], rel=1e-8), key


def test_the_times_at_equal_errors_are_those_of_the_runs():
    assert study.equal_errors(RUNS).rows == EQUAL.rows
