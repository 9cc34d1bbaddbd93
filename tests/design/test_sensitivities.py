"""The command that shows derivatives: table, JSON, picture, refusals with their exit
code.
"""

import json

import pytest
from design_scenes import SLIP

from contbed.cli import main
from contbed.loading import loads
from contbed.many.derivatives.gradients import gradient
from tests.cases import each_case
from tests.numbers_of import table_of


@pytest.fixture
def scene(tmp_path):
    file = tmp_path / "slip.toml"
    file.write_text(SLIP)
    return file


def run(scene, *more):
    return main(
        [
            "sensitivities",
            str(scene),
            "--qoi",
            "T_fluid_out_K",
            "--out",
            str(scene.parent / "out"),
            *more,
        ]
    )


def test_table_and_files(scene, capsys):
    assert run(scene, "--qoi", "pressure_drop_Pa") == 0
    text = capsys.readouterr().out
    lines = text.splitlines()
    made = gradient(
        loads(SLIP),
        ["T_fluid_out_K"],
        ["closures.nusselt", "boundary.left.gas.velocity"],
    )
    row = next(
        line.split()
        for line in lines
        if line.strip().startswith("boundary.left.gas.velocity ")
    )
    assert row[1:3] == ["0.2", "m/s"]
    assert float(row[3]) == pytest.approx(made.derivatives[0, 1], rel=1e-4)
    assert row[4] == "K/(m/s)"
    assert float(row[5]) == pytest.approx(made.logarithmic[0, 1], rel=1e-2)
    # the largest relative derivative comes first: the outlet follows the temperature of
    # the solid that enters
    assert lines[2].split()[0] == "boundary.left.solids.particles.fixed_temperature"
    assert any(line.startswith("pressure_drop_Pa = ") for line in lines)
    assert not any("mesh.cells" in line for line in lines)
    out = scene.parent / "out"
    rows = table_of(out / "sensitivities.csv")
    assert {row["result"] for row in rows} == {"T_fluid_out_K", "pressure_drop_Pa"}
    assert (out / "sensitivities.png").stat().st_size > 10_000


def test_json(scene, capsys):
    assert (
        run(
            scene,
            "--json",
            "--to",
            "closures.nusselt",
            "--to",
            "boundary.left.gas.velocity",
        )
        == 0
    )
    found = json.loads(capsys.readouterr().out)
    assert list(found["keys"]) == ["closures.nusselt", "boundary.left.gas.velocity"]
    assert found["keys"]["boundary.left.gas.velocity"] == {"value": 0.2, "unit": "m/s"}
    assert found["qoi"]["T_fluid_out_K"]["unit"] == "K"
    assert found["method"] == "tangent"
    assert found["standard_errors"] is None
    assert len(found["derivatives"][0]) == 2


@each_case(__file__, "refusals")
def test_refusals(scene, capsys, more, told):
    assert run(scene, *more) == 2
    assert told in capsys.readouterr().err
