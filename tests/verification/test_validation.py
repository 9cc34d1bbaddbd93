"""The score of measured beds: known offsets give known numbers, and mistakes in a
case are told with file and line.
"""

import json
import shutil

import numpy as np
import pytest
from pytest import approx

from contbed.many.validate.case import SHIPPED, names, read_case
from contbed.many.validate.deviations import COVERAGE, Score
from contbed.many.validate.report import write
from contbed.many.validate.score import Validated, validate
from tests.cases import each_case
from tests.command_line import command
from tests.refusals import refusal, refused

SCENE = """\
mesh = { type = "line", length = 0.01, cells = 4 }

[gas]
density = 1.2
heat_capacity = 1000.0
conductivity = 0.03
viscosity = 2e-5

[solids.particles]
density = 2000.0
heat_capacity = 900.0
conductivity = 1e3
diameter = "1 mm"

[packed_bed]
porosity = 0.4

[closures]
nusselt = 0.0

[heat]

[boundary.left]
solids.particles.heat_flux = 500.0

[initial]
gas.temperature = 300
solids.particles.temperature = 300

[time]
end = 100
"""
# a thin bed that a flux heats: dT/dt = q/(C L), the same everywhere
RATE = 500.0 / (0.6 * 2000.0 * 900.0 * 0.01)
CASE = """\
title = "a tank"
source = "closed form"
licence = "none"
scene = "scene.toml"
quantity = "T_solid"
uncertainty = "1 K"
each = "time"
[measured]
file = "measured.csv"
column = "T"
time = "t"
position = "x"
[report]
positions = [0.004]
times = [300.0]
[uncertain]
boundary.left.solids.particles.heat_flux = 50.0
solids.particles.heat_capacity = "1 %"
"""


@pytest.fixture
def tank(tmp_path):
    """Folder of a case whose points are the closed form plus 2 K at 100 s and minus
    1 K at 200 s.
    """
    folder = tmp_path / "tank"
    folder.mkdir()
    (folder / "scene.toml").write_text(SCENE)
    (folder / "case.toml").write_text(CASE)
    rows = [
        f"{t / 60.0:.10g},{x},{300.0 + RATE * t + shift:.12g}"
        for t, shift in ((0.0, 50.0), (100.0, 2.0), (200.0, -1.0))
        for x in (2.0, 5.0, 8.0)
    ]
    (folder / "measured.csv").write_text(
        "t [min],x [mm],T [K]\n" + "\n".join(rows) + "\n"
    )
    return folder


def test_known_offset_gives_known_rms_and_bias(tank):
    """Predicted minus measured is -2 K and +1 K; conduction leaves 1e-3 K. Points at
    0 s do not count.
    """
    done = validate(read_case(str(tank)))
    first, second, everything = done.compared.scores
    assert [score.points for score in done.compared.scores] == [3, 3, 6]
    assert (first.group, first.rms, first.bias) == (
        "100 s",
        approx(2.0, abs=5e-3),
        approx(-2.0, abs=5e-3),
    )
    assert (second.rms, second.bias) == (
        approx(1.0, abs=5e-3),
        approx(1.0, abs=5e-3),
    )
    assert everything.rms == approx(np.sqrt(2.5), abs=5e-3)
    assert everything.bias == approx(-0.5, abs=5e-3)
    assert done.compared.reported["T_0.004m_300s_K"] == approx(
        300.0 + RATE * 300.0, abs=5e-3
    )


def test_band_is_the_propagated_uncertainty(tank):
    """T - 300 K is proportional to the flux and to 1/c_p: 10 % and 1 % of it as
    squares; conduction 3e-4.
    """
    done = validate(read_case(str(tank)))
    rise = RATE * done.case.points.t
    np.testing.assert_allclose(
        done.compared.band, rise * np.hypot(0.1, 0.01), rtol=5e-4
    )
    assert done.compared.influence[
        "boundary.left.solids.particles.heat_flux"
    ] == approx(0.1 * np.sqrt(np.mean(rise**2)), rel=5e-4)


def test_verdict_needs_both_uncertainties():
    """2.1 K is beyond twice the data's 1 K, and within twice the hypotenuse of 1 K
    and 1 K.
    """
    alone, both = (Score("all", 1, 2.1, 0.0, 1.0, band, "K") for band in (0.0, 1.0))
    assert COVERAGE == 2.0 and not alone.within and both.within


def test_command_writes_table_picture_and_summary(tank, tmp_path, capsys):
    """The command prints the table or JSON and writes both files; the run's own
    files lie in a folder of the case.
    """
    out = tmp_path / "out"
    assert command(f"validate {tank} --out {out}") == 0
    text = capsys.readouterr().out
    assert "within uncertainty" in text and "tank" in text
    found = json.loads((out / "summary.json").read_text())["cases"]["tank"]
    assert found["qoi"]["T_0.004m_300s_K"] == approx(300.0 + RATE * 300.0, abs=5e-3)
    assert (out / "validation.png").stat().st_size > 10_000
    assert (out / "tank" / "profiles.csv").is_file()


@each_case(__file__, "mistakes_in_a_case")
def test_mistakes_in_a_case(tank, old, new, words):
    """Each mistake names the file, the line and the key."""
    text = (tank / "case.toml").read_text()
    assert old in text
    (tank / "case.toml").write_text(text.replace(old, new))
    assert words in refusal(lambda: validate(read_case(str(tank))))


def test_unknown_case_names_the_nearest():
    """A name that is no case says which there are."""
    refused("did you mean 'pacheco_2002'", read_case, "pacheco_2020")


@pytest.mark.parametrize("name", names())
def test_shipped_cases_are_complete(name):
    """Scene, data and uncertain inputs of every case that is part of contbed can be
    read.
    """
    case = read_case(name)
    assert case.folder.parent == SHIPPED
    assert len(case.points.value) > 3
    # a long run is not repeated for every input
    assert case.settings.long or list(case.uncertain())
    assert case.settings.source and case.settings.licence


def test_salt_thermocline_against_its_measured_front(tmp_path):
    """Pacheco et al.: after 1 h the deviation is 4.2 K RMS for data with 3 K of
    scatter; the front is where it was.

    The first half hour is off by 7 K: the measured profile steepens, which no transport
    of the measured start does.
    """
    shutil.copytree(SHIPPED / "pacheco_2002", tmp_path / "salt")
    case = tmp_path / "salt" / "case.toml"
    case.write_text(case.read_text().partition("[uncertain]")[0])
    done = validate(read_case(str(tmp_path / "salt")))
    assert isinstance(done, Validated)
    hour = done.compared.scores[1]
    assert hour.group == "3600 s"
    assert hour.rms < 5.0 and abs(hour.bias) < 1.0


def test_wood_sphere_against_its_measured_mass(tmp_path):
    """Park et al.: one value of the whole particle over the time, compared without
    positions.
    """
    shutil.copytree(SHIPPED / "park_2010", tmp_path / "wood")
    case = tmp_path / "wood" / "case.toml"
    case.write_text(case.read_text().partition("[uncertain]")[0])
    done = validate(read_case(str(tmp_path / "wood")))
    (whole,) = done.compared.scores
    # repeated measurements differ by 0.006 to 0.015
    assert whole.group == "all" and whole.rms < 0.015 and whole.within
    assert set(done.compared.reported) == {
        f"mass_{t}s" for t in (100, 200, 300, 400, 500)
    }
    write([done], tmp_path)
    assert (tmp_path / "validation.png").stat().st_size > 10_000
