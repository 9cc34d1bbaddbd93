"""Benchmarks of a study: tables and plot of a tiny one, missing modules, failing
programs, interpolation of curves.
"""

from pathlib import Path

import pytest

from contbed.errors import ContbedError
from contbed.many.bench import bench, time_at
from tests.cases import each_case
from tests.refusals import refused

PROGRAM = """
import json
for n in (1, 2, 4):
    print(json.dumps({"unknowns": n, "error": 1 / n**2, "seconds": 0.1 * n}))
"""
PLAN = """
repeats = 1
[curves]
title = "curves"
error = 0.25
[[curves.case]]
name = "first"
command = ["points.py"]
[[curves.case]]
name = "absent"
command = ["points.py"]
needs = "no_such_module"
[[race]]
title = "race"
[[race.case]]
name = "only"
command = ["-c", "open(r'{out}/mark', 'w').close()"]
"""


def study(folder: Path, plan: str = PLAN) -> Path:
    (folder / "bench").mkdir()
    (folder / "bench" / "bench.toml").write_text(plan, encoding="utf-8")
    (folder / "points.py").write_text(PROGRAM, encoding="utf-8")
    return folder


def test_tables_and_plot(tmp_path: Path) -> None:
    out = tmp_path / "out"
    found = bench(study(tmp_path), out, trust=True)
    assert [row[:4] for row in found.rows[:3]] == [
        ("curves", "first", n, 1 / n**2) for n in (1, 2, 4)
    ]
    assert found.rows[3][:2] == ("at an error of 0.25", "first")
    assert found.rows[3][4:] == (pytest.approx(0.2), 1.0)
    assert found.rows[4][:2] == ("race", "only")
    assert found.skipped == ("skipped: absent: no_such_module is not installed",)
    assert {file.name for file in out.iterdir()} == {
        ".contbed.study",
        "bench.txt",
        "bench.csv",
        "bench.png",
        "mark",
    }
    assert "first" in str(found)


def test_a_failing_program_is_named(tmp_path: Path) -> None:
    broken = study(
        tmp_path,
        PLAN.replace('["points.py"]', '["-c", "raise SystemExit(\'out of order\')"]'),
    )
    with pytest.raises(ContbedError, match="failed: out of order"):
        bench(broken, tmp_path / "out", trust=True)


@each_case(__file__, "mistakes_in_the_list_of_programs_are_told")
def test_mistakes_in_the_list_of_programs_are_told(
    tmp_path: Path, old: str, new: str, told: str
) -> None:
    refused(
        told,
        lambda: bench(
            study(tmp_path, PLAN.replace(old, new)), tmp_path / "out", trust=True
        ),
    )
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "printed",
    ["hello", "[1]", '{"unknowns": 1}', '{"unknowns": 1, "error": "a", "seconds": 1}'],
)
def test_what_is_no_point_of_a_curve_is_told(tmp_path: Path, printed: str) -> None:
    folder = study(tmp_path)
    (folder / "points.py").write_text(f"print({printed!r})", encoding="utf-8")
    with pytest.raises(ContbedError, match=r"points\.py printed .*; expected a line"):
        bench(folder, tmp_path / "out", trust=True)


def test_a_program_without_points_and_a_list_without_programs_are_told(
    tmp_path: Path,
) -> None:
    folder = study(tmp_path)
    (folder / "points.py").write_text("", encoding="utf-8")
    with pytest.raises(ContbedError, match="printed no point of its curve"):
        bench(folder, tmp_path / "out", trust=True)
    (folder / "bench" / "bench.toml").write_text(
        'title = "nothing"\n', encoding="utf-8"
    )
    refused("nothing to measure", lambda: bench(folder, tmp_path / "out", trust=True))


def test_a_study_without_programs(tmp_path: Path) -> None:
    with pytest.raises(ContbedError, match=r"bench\.toml"):
        bench(tmp_path, tmp_path / "out")


def test_programs_run_only_where_the_study_is_trusted(tmp_path: Path) -> None:
    refused(
        r"bench.toml: runs programs: points.py, .*add --trust",
        lambda: bench(study(tmp_path), tmp_path / "out"),
    )
    assert not (tmp_path / "out").exists()


def test_time_at_an_error() -> None:
    assert time_at(1e-3, [1.0, 4.0], [1e-2, 1e-4]) == (pytest.approx(2.0), "")
    assert time_at(1e-1, [1.0, 4.0], [1e-2, 1e-4]) == (1.0, " (or less)")
    assert time_at(1e-5, [1.0, 4.0], [1e-2, 1e-4]) == (4.0, " (not reached: 1.0e-04)")
