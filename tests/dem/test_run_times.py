"""What `contbed plan` predicts a packing to take, over what it takes: a table over beds
of 200 to 10,000 spheres, soft and stiff, with and without friction.

`python -m tests.dem.test_run_times` writes it to tests/data/run_times.csv anew.
"""

import csv
import time
from pathlib import Path

import pytest

import contbed as cb
from contbed.loading import load
from contbed.models import MODELS, plan
from tests.numbers_of import table_of

TABLE = Path(__file__).parents[1] / "data" / "run_times.csv"
FIRST_HOUR = TABLE.parent / "first_hour" / "packc.toml"
HEADER = ("bed", "spheres", "predicted [s]", "measured [s]", "ratio")


def box(count, width, modulus="10 MPa", **solid):
    """A packing of 2 mm spheres in a box, laid over the template of particles."""
    return {
        "output.plots": False,
        "particles.lattice": None,
        "particles.packing": {"count": count, "width": [width, width]},
        "particles.modulus": modulus,
        "solids.spheres.density": 2500.0,
        "solids.spheres.youngs_modulus": "63 GPa",
    } | {f"solids.spheres.{key}": value for key, value in solid.items()}


BEDS = {
    "200 spheres": box(200, "10 mm"),
    "600 spheres": box(600, "16 mm"),
    "3000 spheres": box(3000, "30 mm"),
    "10,000 spheres": box(10_000, "40 mm"),
    "soft": box(1000, "18 mm", "1 MPa"),
    "stiff": box(1000, "18 mm", "100 MPa"),
    "without friction": box(1000, "18 mm", sliding_friction=0.0),
    "sizes that differ": box(1000, "18 mm", size_spread=0.2),
}


def measured(name):
    """Return a row of the table, of processor seconds once all is compiled."""
    path, changes = MODELS["particles"].template, BEDS.get(name)
    if changes is None:
        path, changes = FIRST_HOUR, {"output.plots": False}
    scene = load(path, changes)
    expected = plan(scene)
    start = time.process_time()
    cb.run(scene, quiet=True)
    spent = time.process_time() - start
    seconds = expected.seconds()
    return name, expected.unknowns()["heat"], seconds, spent, seconds / spent


@pytest.mark.slow
@pytest.mark.parametrize("name", [*BEDS, "first hour"])
def test_the_plan_predicts_within_a_factor_of_three(name):
    measured("200 spheres")  # compiles
    assert 1.0 / 3.0 < measured(name)[-1] < 3.0


def test_the_table_is_within_a_factor_of_three():
    rows = table_of(TABLE)
    assert [row["bed"] for row in rows] == [*BEDS, "first hour"]
    assert all(1.0 / 3.0 < float(row["ratio"]) < 3.0 for row in rows)


if __name__ == "__main__":
    measured("200 spheres")
    found = [measured(name) for name in (*BEDS, "first hour")]
    lines = [[*row[:2], *(f"{value:.2g}" for value in row[2:])] for row in found]
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([HEADER, *lines])
