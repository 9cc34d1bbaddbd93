"""Scenes and files that are too large or never end are refused at once, by `check`
already.
"""

import gzip
import os
import subprocess
import sys
import time

import pytest

from contbed.loading import load, loads
from contbed.scene import size
from contbed.scene.inputs import LARGE_FILE
from tests.refusals import refusal, refused

BED = """\
[gas]
density = 1
viscosity = 2e-5

[solids.particles]
diameter = "3 mm"

[packed_bed]
porosity = 0.4

[boundary.left]
gas.velocity = 0.1
"""
LINE = '[mesh]\ntype = "line"\nlength = 2\n' + BED
FILE = '[mesh]\ntype = "file"\nfile = "bed.msh"\n' + BED
PARTICLES = """\
[particles]
file = "pack.csv.gz"
[solids.spheres]
diameter = 2e-3
conductivity = 1.0
[particles.layers]
bottom = 0.0
top = 0.1
area = 1e-2
"""


def problem(text: str, **options) -> str:
    return refusal(loads, text, **options)


def check(folder, name="scene.toml"):
    start = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-m", "contbed", "check", name],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=60,
    )
    return done.returncode, done.stderr, time.monotonic() - start


def test_memory_needed_and_available():
    found = problem(
        '[mesh]\ntype = "rectangle"\nlength = 2\nheight = 1\ncells = [30000, 30000]\n'
        + BED
    )
    assert found.startswith(
        "scene.toml:5: mesh.cells = [30000, 30000]: 900 000 000 cells of a plane need "
        "at least 2.7 TB, "
    )
    assert found.endswith(" GB are available; make it smaller, or allowed by "
                          "--allow-large, in Python "
                          "load(..., allow_large=True)")  # fmt: skip


def test_refinement_and_simplices_count(monkeypatch):
    monkeypatch.setattr(size, "available_bytes", lambda: 1e11)
    text = (
        '[mesh]\ntype = "box"\nlength = 2\nheight = 1\nwidth = 1\ncells = [50, 20, '
        "20]\nrefine = 2\n"
    )
    assert "1 280 000 cells of a volume" in problem(text + BED)
    assert "more than 1 000 000 are allowed by --allow-large" in problem(text + BED)
    assert "1 152 000 cells" in problem(
        text.replace("50", "60").replace(
            "refine = 2", 'refine = 1\nshape = "tetrahedron"'
        )
        + BED
    )
    loads(text.replace("refine = 2", "refine = 1") + BED)
    loads(text + BED, allow_large=True)


def test_rows_files_and_steps():
    text = LINE.replace("viscosity", "heat_capacity = 1\nconductivity = 1\nviscosity")
    text = text.replace(
        'diameter = "3 mm"',
        'diameter = "3 mm"\ndensity = 1\nheat_capacity = 1\nconductivity = 1',
    )
    text = text.replace(
        "gas.velocity = 0.1", "gas.velocity = 0.1\ngas.temperature = 300"
    )
    text += (
        "[closures]\nnusselt = 2\n[heat]\n[initial]\ntemperature = 300\n[time]\n"
        "end = 1.0\n"
    )
    found = problem(text + "step = 1e-9\n")
    assert (
        "1 000 000 000 time steps; more than 100 000 000 are allowed by --allow-large"
        in found
    )


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
@pytest.mark.parametrize("name", ["pipe", "device"])
def test_pipes_and_devices_do_not_hang(tmp_path, name):
    if name == "pipe":
        os.mkfifo(tmp_path / "bed.msh")
        os.mkfifo(tmp_path / "pipe.toml")
    else:
        (tmp_path / "bed.msh").symlink_to("/dev/zero")
        (tmp_path / "pipe.toml").symlink_to("/dev/zero")
    (tmp_path / "scene.toml").write_text(FILE)
    code, text, seconds = check(tmp_path)
    assert code == 2 and seconds < 20
    assert (
        text
        == 'scene.toml:3: mesh.file = "bed.msh": is a folder, a pipe or a device; give '
        "a file\n"
    )
    assert check(tmp_path, "pipe.toml")[:2] == (
        2,
        "pipe.toml:1: is a pipe or a device; give a file\n",
    )


def test_closures_in_pipes_and_long_scenes(tmp_path):
    os.mkfifo(tmp_path / "closure.toml")
    text = LINE + '[closures]\npermeability = { file = "closure.toml" }\n'
    assert (
        'closures.permeability.file = "closure.toml": is a folder, a pipe'
        in problem(text, base=tmp_path)
    )
    with open(tmp_path / "scene.toml", "wb") as file:
        file.truncate(30_000_000)
    refused(
        r"scene\.toml:1: 30 MB; a TOML file has at most 20 MB",
        lambda: load(tmp_path / "scene.toml"),
    )


def test_what_a_small_file_unpacks_to(tmp_path):
    with gzip.open(tmp_path / "pack.csv.gz", "wb", compresslevel=1) as file:
        piece = b"0.001,0.002,0.003\n" * 100_000
        for _ in range(LARGE_FILE // len(piece) + 1):
            file.write(piece)
    found = problem(PARTICLES, base=tmp_path)
    assert found.startswith(
        'scene.toml:2: particles.file = "pack.csv.gz": is larger than 500 MB, '
        "unpacked; read only"
    )
    (tmp_path / "pack.csv.gz").write_bytes(b"no gzip")
    assert "Not a gzipped file" in problem(PARTICLES, base=tmp_path)


def test_a_large_mesh_file(tmp_path):
    with open(tmp_path / "bed.msh", "wb") as file:
        file.truncate(LARGE_FILE + 1)
    assert "is larger than 500 MB; read only with --allow-large" in problem(
        FILE, base=tmp_path
    )


@pytest.mark.parametrize(
    ("text", "line", "key"),
    [
        ('[mesh]\nlength = 2\ntypex = "line"\n', 3, "typex"),
        ('mesh.length = 2\nmesh.typ = "line"\n', 2, "typ"),
    ],
)
def test_a_misspelt_choice_is_told_at_its_own_line(text, line, key):
    assert problem(text + BED).startswith(
        f"scene.toml:{line}: mesh.{key} = \"line\": unknown key; did you mean 'type'? "
        "allowed: "
    )
