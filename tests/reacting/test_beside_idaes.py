"""The comparison with IDAES: what its tables say, with or without IDAES."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import pytest

from studies._gallery import Table
from studies.clc_moving_bed import beside_idaes as study
from studies.clc_moving_bed.shooting import Bed

RUNS = Table.read(study.HERE / "idaes.csv")
EQUAL = Table.read(study.HERE / "idaes_equal_error.csv")


def test_graded_elements_grow_to_the_longest():
    ((points, ends),) = study.graded(5, 5.0, (1e-3, 2.0, 0.5))
    sizes = 5.0 * np.diff(ends)
    assert points == 5 and ends[0] == 0.0 and ends[-1] == 1.0
    assert np.allclose(sizes[1:6] / sizes[:5], 2.0, rtol=1e-9)
    # the bed ends inside of the last element, by which all shrink
    assert (
        np.allclose(sizes[-3:], sizes[-1], rtol=1e-9) and 0.9 * 0.5 < sizes[-1] <= 0.5
    )


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


def test_rows_of_idaes_are_kept_where_it_is_not_installed(monkeypatch):
    monkeypatch.setattr(study, "find_spec", lambda name: None)
    monkeypatch.setattr(study, "reference", lambda bed: {})
    monkeypatch.setattr(
        study, "own", lambda exact: [{"code": study.OWN, "cpu_s": 1.0, "error": 1e-12}]
    )
    tables = study.compute()
    peers = [row for row in RUNS.rows if row[0] != study.OWN]
    assert [
        row for row in tables["idaes"].rows if row[0] != study.OWN
    ] == peers and peers
    assert len(tables["idaes"]) == len(peers) + 1
    assert tables["idaes_equal_error"].where({"code": study.OWN})["cpu_s"].tolist() == [
        1.0
    ] * len(study.WANTED)


@pytest.mark.slow
@pytest.mark.skipif(
    find_spec("idaes") is None,
    reason="IDAES is not installed: pip install 'contbed[bench-idaes]'",
)
def test_idaes_gives_its_rows_again():
    name = "IDAES, 3 Radau points"
    (row,) = study.peer(Bed.of(study.load(study.SCENE)), {name: study.even(3, 10)})
    committed = RUNS.where({"code": name, "level": "10 elements"})
    for key in study.RESULTS:  # Ipopt to 1e-8
        assert row[key] == pytest.approx(committed[key][0], rel=1e-7), key
    assert 0.0 < row["ipopt_s"] < row["cpu_s"]
