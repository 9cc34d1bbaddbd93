"""Dumps of LIGGGHTS and LAMMPS: what the programs write comes back; what is cut or
missing is named with its line.
"""

import gzip
from pathlib import Path

import numpy as np
import pytest
from pytest import approx

from contbed.dem import dumps
from contbed.dem.particle_files import read_particles, write_particles
from contbed.dem.particle_tables import has_radii, read_table
from contbed.errors import SceneError
from contbed.loading import from_dict
from tests.cases import each_case
from tests.refusals import refusal, refused

# six spheres on a plane, written by LIGGGHTS 3.8.0 and LAMMPS 2022-01-06; contacts
# conduct in the first
REAL = Path(__file__).parent / "dumps"

LIGGGHTS = """ITEM: TIMESTEP
60000
ITEM: NUMBER OF ATOMS
3
ITEM: BOX BOUNDS ff ff pp
0 0.026
0 0.026
-0.001 0.04
ITEM: ATOMS id type x y z radius f_Temp[0]
3 1 0.003 0.004 0.001 0.001 301.5
1 1 0.001 0.002 0.001 0.001 300
2 2 0.002 0.002 0.003 0.0015 305.25
"""

LAMMPS = """ITEM: UNITS
si
ITEM: TIME
0.25
ITEM: TIMESTEP
10
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS pp pp pp
0 2
-1 1
0 4
ITEM: ATOMS id element diameter xs ys zs temperature
1 Fe 0.5 0.5 0.5 0.25 400
2 C 0.25 0 1 0.5 410
"""


@pytest.fixture
def dump(tmp_path):
    def write(text, name="bed.dump"):
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


def failure(path):
    return refusal(dumps.read_dump, path).removeprefix(f"{path}:")


def test_liggghts(dump):
    (frame,) = dumps.read_dump(dump(LIGGGHTS))
    assert frame.step == 60000 and frame.periodic == (False, False, True)
    assert frame.radius == approx([0.001, 0.0015, 0.001])  # by id
    assert approx([300, 305.25, 301.5]) == frame.T
    assert frame.x[2] == approx([0.003, 0.004, 0.001])
    assert (frame.low.tolist(), frame.high.tolist()) == (
        [0, 0, -0.001],
        [0.026, 0.026, 0.04],
    )
    assert frame.columns["type"].tolist() == [1, 2, 1]


def test_lammps_with_scaled_positions_and_several_steps(dump):
    frames = dumps.read_dump(dump(LAMMPS + LAMMPS.replace("\n10\n", "\n20\n")))
    assert [frame.step for frame in frames] == [10, 20]
    assert frames[1].x == approx(np.array([[1.0, 0, 1], [0, 1, 2]]))
    assert frames[1].radius == approx([0.25, 0.125])
    assert approx([400, 410]) == frames[1].T
    assert np.isnan(frames[1].columns["element"]).all()


def test_a_packed_file_and_no_temperature(tmp_path):
    path = tmp_path / "bed.dump.gz"
    with gzip.open(path, "wt") as file:
        file.write(LIGGGHTS.replace("f_Temp[0]", "q"))
    assert dumps.read_dump(path)[0].T is None


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (
            LIGGGHTS[: LIGGGHTS.index("\n2 2") + 1],
            "11: truncated: step 60000 has 2 of 3 particles",
        ),
        (
            LIGGGHTS[:-20],
            "12: truncated: 4 values for the 7 columns id type x y z radius f_Temp[0]",
        ),
        (
            LIGGGHTS[: LIGGGHTS.index("ITEM: ATOMS")],
            "8: truncated: the file ends where an ITEM should follow",
        ),
        (
            "ITEM: TIMESTEP\n",
            "1: truncated: the file ends where the step should follow",
        ),
        (
            LIGGGHTS + LIGGGHTS[:43],
            "15: truncated: the file ends where the number of particles should follow",
        ),
        (LIGGGHTS.replace(" radius", " mass"), "12: no radius"),
        (LIGGGHTS.replace("x y z", "vx vy vz"), "12: no positions"),
        (
            LIGGGHTS.replace("0.0015", "0"),
            "12: step 60000: a position or radius is not a finite number",
        ),
        (LIGGGHTS.replace("ff ff pp", "xy xz yz pp pp pp"), "5: a tilted box"),
        (
            LIGGGHTS.replace("0 0.026", "0 0.026 1", 1),
            "6: 3 numbers where 2 finite ones are needed",
        ),
        (LIGGGHTS.replace("\n3\n", "\nmany\n", 1), "4: not 1 numbers: 'many'"),
        ("x,y,z\n1,2,3\n", "1: no text dump of LIGGGHTS or LAMMPS"),
        ("\n\n", "1: no frame in this dump"),
    ],
)
def test_what_cannot_be_read(dump, text, wanted):
    assert failure(dump(text)).startswith(wanted)


def test_files_that_are_not_there_or_not_text(tmp_path):
    assert failure(tmp_path / "no.dump") == "1: no such file"
    path = tmp_path / "bad.dump.gz"
    path.write_bytes(gzip.compress(LIGGGHTS.encode())[:-30])
    assert "cannot be read" in failure(path)


TWO = np.array([[1.0, 2, 3], [4e-3, 5, 6]])


@each_case(__file__, "tables")
def test_tables(tmp_path, text, radius, velocity):
    path = tmp_path / "x.csv"
    path.write_text(text)
    table = read_table(path)
    assert table.x == approx(TWO)
    for found, wanted in ((table.radius, radius), (table.velocity, velocity)):
        assert (found is None) == (wanted is None)
        assert wanted is None or found == approx(np.array(wanted))
    assert has_radii(path) == (radius is not None)


@each_case(__file__, "tables_that_cannot_be_read")
def test_tables_that_cannot_be_read(tmp_path, text, told):
    path = tmp_path / "x.csv"
    path.write_text(text)
    refused(told, read_table, path)


def test_own_files_of_particles_are_read(tmp_path):
    path = tmp_path / "particles_0000.vtu"
    write_particles(path, TWO, {"radius": np.array([0.1, 0.2]), "velocity": 2.0 * TWO})
    found = read_particles(path)
    assert (found.x.tolist(), found.radius.tolist()) == (TWO.tolist(), [0.1, 0.2])
    assert found.velocity.tolist() == (2.0 * TWO).tolist()
    path.write_text("no xml")
    refused(
        r"particles_0000\.vtu:1: no VTU file that can be read", read_particles, path
    )


def test_a_dump_that_liggghts_wrote():
    first, last = dumps.read_dump(REAL / "liggghts.dump")
    assert (first.step, last.step) == (0, 500)
    assert first.radius == approx([1e-3, 1e-3, 1e-3, 1.5e-3, 1e-3, 1e-3])
    assert first.x[3] == approx([0.002, 0.0037, 0.001499])
    assert approx([300.0] * 5 + [400.0]) == first.T
    assert (last.low.tolist(), last.high.tolist(), last.periodic) == (
        [0, 0, -2e-3],
        [6e-3, 6e-3, 1e-2],
        (False,) * 3,
    )
    # the hot sphere has touched the large one and lost to it; 0.008 K of 300 are known
    # to 6 % in the digits of a dump
    lost, won = ((last.radius**3 * (last.T - first.T))[k] for k in (5, 3))
    assert won > 0.0 and won == approx(-lost, rel=0.07)


def test_a_dump_that_lammps_wrote():
    first, last = dumps.read_dump(REAL / "lammps.dump")
    assert (first.step, last.step) == (0, 250)
    # scaled positions of six digits in a box of 6 and 12 mm; the same spheres as in the
    # other dump
    assert first.x == approx(dumps.read_dump(REAL / "liggghts.dump")[0].x, abs=1.2e-8)
    assert first.radius[3] == approx(1.5e-3) and first.T is None
    assert last.periodic == (True, True, False)
    assert last.columns["vz"][5] == approx(0.631756)


@pytest.mark.parametrize("name", ["liggghts.dump", "lammps.dump"])
def test_real_dumps_cut_after_any_line(name, dump):
    """Only a cut between two steps leaves a dump; every other one is an error with
    its line.
    """
    lines = (REAL / name).read_text().splitlines(keepends=True)
    whole = []
    for count in range(1, len(lines)):
        path = dump("".join(lines[:count]))
        try:
            whole.append((count, len(dumps.read_dump(path))))
        except SceneError as error:
            assert str(error).startswith(f"{path}:") and (
                "truncated" in str(error) or "no frame" in str(error)
            )
    second = next(
        k
        for k, line in enumerate(lines)
        if k > 5 and line.startswith(("ITEM: TIME\n", "ITEM: TIMESTEP"))
    )
    # LAMMPS writes the time before a step
    assert {count for count, _ in whole} <= {second, second + 2}
    assert (second, 1) in whole


@pytest.mark.parametrize("name", ["liggghts.dump", "lammps.dump"])
def test_real_dumps_cut_within_a_line(name, dump):
    text = (REAL / name).read_text()
    last = text.rstrip("\n").rindex("\n")
    assert "truncated: " in failure(dump(text[: last + 9]))


def test_a_file_that_cannot_be_used_is_named_with_its_key(tmp_path):
    (tmp_path / "x.csv").write_text("x,y,z,radius\n0,0,0,nan\n")
    scene = {"particles": {"file": "x.csv"}, "solids": {"a": {"conductivity": 1.0}}}
    said = r'scene:1: particles\.file = "x\.csv": .*x\.csv:2: 4 numbers where 4 finite'
    refused(said, from_dict, scene, base=tmp_path)
