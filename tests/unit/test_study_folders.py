"""Commands that make many runs: files of others in their folder stay, their own are
replaced.
"""

import pytest

from contbed.output.folder import STUDY, prepare_study
from tests.cases import each_case
from tests.command_line import command

SCENE = """\
mesh = { type = "line", length = 0.05, cells = 4 }
gas = { density = 1.2, heat_capacity = 1005, conductivity = 0.026, viscosity = 1.8e-5 }
solids.pebbles = { density = 2500, heat_capacity = 840, conductivity = 0.84, diameter = "10 mm" }
packed_bed = { porosity = 0.4 }
closures = { nusselt = "wakao_kaguei", conductivity_solids = "zehner_schluender", conductivity_gas = 0.0 }
heat = {}
boundary.left.gas = { velocity = 0.3, temperature = 300.0 }
boundary.right.solids.pebbles = { velocity = 1.7e-4, temperature = 500.0 }
"""
FILES = {
    "sweep": 'scene = "bed.toml"\n[parameters]\npacked_bed.porosity = [0.39, 0.4]\n',
    "design": """\
scene = "bed.toml"
minimise = "pressure_drop_Pa"
[keys]
boundary.left.gas.velocity = { from = 0.2, to = 0.4 }
""",
    "cascade": """\
scene = "bed.toml"
qoi = ["T_fluid_out_K"]
samples = 8
packings = { count = 2, particles = 300, width = 5 }
laws = { conduction = ["cones"], exchange = ["gunn"] }
uncertain = { solids.pebbles.conductivity = "5 %" }
""",
    "data": """\
[keys]
packed_bed.porosity = { from = 0.35, to = 0.45 }
[[experiment]]
scene = "bed.toml"
file = "drops.csv"
keys = { "boundary.left.gas.velocity" = "u" }
values = [{ quantity = "pressure_drop_Pa", column = "dp", error = "2 %" }]
""",
}
TEXT = '{"files": 12}'
BENCH = """\
[[race]]
title = "race"
[[race.case]]
name = "only"
command = ["-c", ""]
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bed.toml").write_text(SCENE)
    for name, text in FILES.items():
        (tmp_path / f"{name}.toml").write_text(text)
    (tmp_path / "drops.csv").write_text("u [m/s],dp [Pa]\n0.1,1.0\n0.2,3.0\n")
    bench = tmp_path / "study" / "bench" / "bench.toml"
    bench.parent.mkdir(parents=True)
    bench.write_text(BENCH)
    (tmp_path / "out").mkdir()
    return tmp_path


@each_case(__file__, "files_of_others_are_not_replaced")
def test_files_of_others_are_not_replaced(here, capsys, line, name):
    (here / "out" / name).write_text(TEXT)
    assert command(f"{line} --out out") == 1
    assert f"{name}: not written by a run of contbed" in capsys.readouterr().err
    assert [path.name for path in (here / "out").iterdir()] == [name]
    assert (here / "out" / name).read_text() == TEXT


def test_a_study_replaces_its_own_files(here, capsys):
    for _ in range(2):
        assert command("converge bed.toml --levels 2 --out out") == 0
    (here / "out" / "table.csv").write_text("mine")
    assert command("sweep sweep.toml --out out") == 1
    assert (here / "out" / "table.csv").read_text() == "mine"


def test_a_study_replaces_what_a_run_has_written(here):
    assert command("run bed.toml --quiet --out out") == 0
    prepare_study(here / "out", "summary.json", "profiles.csv")
    listed = (here / "out" / STUDY).read_text()
    assert listed.split() == ["summary.json", "profiles.csv"]
