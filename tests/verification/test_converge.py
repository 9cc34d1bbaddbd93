"""Mesh convergence of scenes: orders against the closed form and of successive
differences, table, files.
"""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pytest import approx

from contbed.loading import load, loads
from contbed.many.converge import converge
from contbed.models import MODELS, plan
from contbed.output.tables import read_table
from contbed.runner import run
from studies._exact.of_plan import exact_profile
from tests.cases import each_case
from tests.refusals import refused

STUDY = Path(__file__).parents[2] / "studies" / "pivem_2012" / "slip_0.50.toml"

BED = """
[mesh]
type = "line"
length = 0.2
cells = 20

[gas]
density = 0.5
viscosity = 2e-5
heat_capacity = 2000
conductivity = 0.04

[solids.particles]
density = 0.7
heat_capacity = 2000
conductivity = 0.9
diameter = 0.006

[packed_bed]
porosity = 0.6

[closures]
nusselt = 3
conductivity_gas = 1
conductivity_solids = 1

[heat]

[boundary.left]
gas.velocity = 0.2
solids.particles.velocity = 0.1
gas.fixed_temperature = 300
solids.particles.fixed_temperature = 500

[solver]
stabilisation = false
"""


def scene(path: Path, *changes: tuple[str, str]) -> Path:
    text = BED
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    file = path / "scene.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_paper_case(tmp_path: Path) -> None:
    found = converge(STUDY, 5, tmp_path)
    assert [level.order for level in found.levels[2:]] == approx([3.0] * 3, abs=0.3)
    assert found.levels[-1].difference < 1e-6
    table = read_table_with_gaps(tmp_path / "convergence.csv")
    differences = [level.difference for level in found.levels]
    assert table["difference [1]"] == approx(differences, nan_ok=True)
    assert (tmp_path / "convergence.png").stat().st_size > 1000
    assert str(found).count("\n") == 6


def read_table_with_gaps(file: Path) -> dict[str, Any]:
    return {
        name: column
        for name, column in read_table(file).items()
        if not np.isnan(column).all()
    }


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_order_on_prescribed_cells(tmp_path: Path, degree: int) -> None:
    file = scene(
        tmp_path, ("stabilisation = false", f"stabilisation = false\ndegree = {degree}")
    )
    exact, errors = exact_profile(plan(load(file))), []
    for cells in (40, 80):
        profiles = run(load(file, {"mesh.cells": cells})).profiles
        expected = exact(profiles["x [m]"])
        errors.append(
            max(np.abs(profiles[name] - expected[name]).max() for name in expected)
        )
    assert np.log2(errors[0] / errors[1]) == approx(degree + 1, abs=0.3)
    found = converge(file, 3)
    assert [round(level.h / found.levels[-1].h) for level in found.levels] == [4, 2, 1]


def test_difference_of_levels_without_a_closed_form(tmp_path: Path) -> None:
    file = scene(tmp_path, ("gas.fixed_temperature", "gas.temperature"))
    found = converge(file, 4)
    assert np.isnan(found.levels[0].difference)
    assert found.levels[-1].order == approx(3.0, abs=0.3)


REACTING = """
[mesh]
type = "line"
length = 1.0
cells = 4

[gas]
model = "ideal_gas"
composition = "O2:1"
species.O2.heat_capacity = 30.0
species.O3.heat_capacity = 45.0

[solids.particles]
diameter = 0.003

[packed_bed]
porosity = 0.4
pressure_drop = "none"

[reactions.r]
equation = "3 O2 -> 2 O3"
A = 2.0
E = 0.0
orders = { O2 = 1.0 }

[boundary.left]
gas.velocity = 0.5
gas.temperature = 500.0

[solver]
degree = 1
"""


def test_fractions_of_an_isothermal_reacting_bed(tmp_path: Path) -> None:
    """Temperatures are the same on all meshes, what reacts is not; degree 1 inside
    of cells is of second order.
    """
    file = tmp_path / "scene.toml"
    file.write_text(REACTING, encoding="utf-8")
    found = converge(file, 4)
    assert found.measure.endswith(": T_fluid, T_solid, x_O2, x_O3")
    assert found.levels[-1].difference > 1e-5
    assert found.levels[-1].order == approx(2.0, abs=0.2)
    assert [level.h for level in found.levels] == approx([0.25, 0.125, 0.0625, 0.03125])


def test_a_reacting_bed_in_time(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    in_time = REACTING.replace(
        "porosity = 0.4", 'porosity = 0.4\ngas_storage = "quasi_steady"'
    )
    file.write_text(in_time + "[time]\nend = 10.0\n", encoding="utf-8")
    assert converge(file, 3).levels[-1].difference > 0.0


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("reacting_bed", "give mesh.cells"),
        ("two_fluid", "no profiles at given positions"),
    ],
)
def test_kinds_without_meshes_to_compare(tmp_path: Path, kind: str, said: str) -> None:
    refused(said, lambda: converge(MODELS[kind].template, 2))


def test_the_command_draws_its_picture(tmp_path: Path) -> None:
    """In a process of its own, in which parts of matplotlib are left out."""
    file = scene(tmp_path, ("gas.fixed_temperature", "gas.temperature"))
    command = [
        sys.executable,
        "-m",
        "contbed",
        "converge",
        str(file),
        "--levels",
        "2",
        "--out",
        str(tmp_path),
    ]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "convergence.png").stat().st_size > 1000


def test_flow_without_heat(tmp_path: Path) -> None:
    file = tmp_path / "flow.toml"
    file.write_text(
        """\
[mesh]
type = "rectangle"
length = 0.1
height = 0.02
cells = [10, 4]

[gas]
density = 0.5
viscosity = 2e-5

[solids.particles]
diameter = 0.006

[packed_bed]
porosity = 0.6

[boundary.left]
gas.velocity = 0.2

[boundary.bottom]
type = "no_slip"
""",
        encoding="utf-8",
    )
    found = converge(file, 3)
    assert found.measure.endswith(": u")
    assert found.levels[2].difference < found.levels[1].difference


def made(*changes: tuple[str, str]) -> Any:
    text = BED
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return plan(loads(text))


ENDS = """gas.velocity = 0.2
solids.particles.velocity = 0.1
gas.fixed_temperature = 300
solids.particles.fixed_temperature = 500
"""
GAS_ALONE = "gas.velocity = 0.2\ngas.fixed_temperature = 300\n"
SOLIDS_ALONE = (
    "solids.particles.velocity = 0.1\nsolids.particles.fixed_temperature = 500\n"
)


@pytest.mark.parametrize(
    "changes",
    [
        [],
        [
            ("fixed_temperature = 300", "fixed_temperature = 4"),
            ("= 500", "= 300"),
            ("= 4\n", "= 500\n"),
        ],
        [("[boundary.left]", "[boundary.right]")],
        [(ENDS, f"{GAS_ALONE}[boundary.right]\n{SOLIDS_ALONE}")],
        [("solids.particles.velocity = 0.1\n", "")],
        [
            (
                "nusselt = 3",
                "nusselt = 3\ntortuosity = -0.0005\ndispersion = {axial = 0.02}",
            )
        ],
    ],
    ids=["parallel", "hot fluid", "backwards", "counter", "resting", "tortuosity"],
)
def test_closed_form_fits_the_run(changes: list[tuple[str, str]]) -> None:
    from contbed.runner import run

    text = BED.replace("cells = 20\n", "")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    result = run(loads(text + "tolerance = 1e-7\n"))
    profile = exact_profile(result.plan)
    assert profile is not None
    for name, exact in profile(result.profiles["x [m]"]).items():
        assert np.abs(result.profiles[name] - exact).max() < 1e-6


@each_case(__file__, "no_closed_form")
def test_no_closed_form(changes: list[tuple[str, str]]) -> None:
    assert exact_profile(made(*changes)) is None
