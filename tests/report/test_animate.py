"""`contbed animate`: films of planes and of particles, as GIF and as MP4."""

import json
import shutil
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image
from plane_scene import PLANE

from contbed import load, run
from contbed.errors import ContbedError
from contbed.explain import editor
from contbed.report.animate import animate
from tests.command_line import command


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    folder = tmp_path_factory.mktemp("film")
    (folder / "plane.toml").write_text(PLANE)
    changes = {"mesh.cells": [8, 3], "time.end": 500, "time.times": [100, 200]}
    run(load(folder / "plane.toml", changes), out=folder / "plane")
    return folder / "plane"


def frames(file):
    """The pictures of a GIF as arrays of grey values."""
    with Image.open(file) as film:
        found = []
        for k in range(film.n_frames):
            film.seek(k)
            found.append(np.asarray(film.convert("L"), dtype=float))
    return found


def test_a_film_has_one_picture_for_each_time(plane, capsys):
    assert command(f"animate {plane}") == 0
    assert "animation.gif" in capsys.readouterr().out
    film = frames(plane / "animation.gif")
    assert len(film) == 3
    # grey values of 255
    assert all(np.abs(a - b).mean() > 1.0 for a, b in pairwise(film))


def test_a_film_of_others_is_not_replaced(plane, tmp_path):
    """But a film that contbed has written is, in the folder and where the user says."""
    folder = tmp_path / "run"
    shutil.copytree(plane, folder)
    film = folder / "animation.gif"
    film.write_bytes(b"of others")
    summary = json.loads((folder / "summary.json").read_text())
    summary["files"] = [each for each in summary["files"] if each != film.name]
    (folder / "summary.json").write_text(json.dumps(summary))
    with pytest.raises(ContbedError, match=r"animation\.gif: not written by a run"):
        animate(folder)
    film.unlink()
    for _ in range(2):
        assert animate(folder) == film
    assert animate(folder, tmp_path / "a.gif") == animate(folder, tmp_path / "a.gif")


def test_other_fields_and_mistakes(plane, tmp_path):
    assert animate(plane, tmp_path / "gas.gif", "T_fluid").stat().st_size > 10_000
    with pytest.raises(ContbedError, match="no field 'T'; there are"):
        animate(plane, tmp_path / "gas.gif", "T")
    with pytest.raises(ContbedError, match="a film is a"):
        animate(plane, tmp_path / "gas.avi")


def test_a_steady_run_has_no_film(tmp_path):
    (tmp_path / "bed.toml").write_text(editor.template("packed_bed"))
    run(load(tmp_path / "bed.toml"), out=tmp_path / "bed")
    with pytest.raises(ContbedError, match=r"give time.times or time.fields"):
        animate(tmp_path / "bed")


def test_mp4(plane, tmp_path):
    pytest.importorskip(
        "imageio_ffmpeg",
        reason="imageio-ffmpeg is not installed: pip install 'contbed[animation]'",
    )
    file = animate(plane, tmp_path / "film.mp4")
    assert file.read_bytes()[4:8] == b"ftyp" and file.stat().st_size > 2000


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["two_fluid", "particles_gas"])
def test_two_fluids_and_particles(kind, tmp_path):
    (tmp_path / "bed.toml").write_text(editor.template(kind))
    run(load(tmp_path / "bed.toml", {"time.fields": "20 ms"}), out=tmp_path / "bed")
    film = frames(animate(tmp_path / "bed"))
    assert len(film) >= 3 and np.abs(film[0] - film[-1]).mean() > 0.2
