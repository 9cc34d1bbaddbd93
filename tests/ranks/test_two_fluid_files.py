"""Fields of two fluids in pieces: each rank writes its cells, and what reads fields
reads them as one.
"""

import json
import xml.etree.ElementTree as tree
from pathlib import Path

import meshio
import numpy as np
import pytest
from dolfinx_launch import started

from contbed.errors import ContbedError
from contbed.output.stored import read_fields, read_series
from contbed.report.animate import animate
from contbed.report.fields import pictures
from contbed.report.read import read_run

PROGRAM = Path(__file__).with_name("two_fluid_program.py")
BEDS = ("triangles", "rectangles", "heated", "tetrahedra", "hexahedra")
# what numbers of ranks differ by after some 50 steps, see test_two_fluid_ranks
CONTINUED = 1e-8


def ran(ranks: int, *arguments) -> None:
    finished = started(ranks, *arguments, program=PROGRAM)
    assert finished.returncode == 0, finished.stdout[-4000:] + finished.stderr[-8000:]


@pytest.fixture(scope="module", params=[2, 3])
def both(request, tmp_path_factory: pytest.TempPathFactory) -> tuple[int, Path]:
    folder = tmp_path_factory.mktemp("files")
    ran(request.param, "files", folder, *BEDS)
    return request.param, folder


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The folder of a run of two ranks with fields in pieces, and that of one rank."""
    two, one = tmp_path_factory.mktemp("two"), tmp_path_factory.mktemp("one")
    ran(2, "in_pieces", two, "averaged", "0.05")
    ran(1, "in_pieces", one, "averaged", "0.05")
    return two, one


def by_place(mesh: meshio.Mesh):
    """Corners and fields of the cells in an order that does not depend on how they
    are dealt out.
    """
    (block,) = mesh.cells
    corners = mesh.points[block.data]
    order = np.lexsort(np.round(corners.mean(axis=1), 12).T)
    return corners[order], {
        name: values[0][order] for name, values in mesh.cell_data.items()
    }


@pytest.mark.parametrize("name", BEDS)
def test_pieces_are_the_whole(both, name: str) -> None:
    ranks, folder = both
    header = folder / "pieces" / f"{name}.pvtu"
    root = tree.parse(header).getroot()
    parts = [
        meshio.read(header.parent / item.attrib["Source"])
        for item in root.iter("Piece")
    ]
    assert len(parts) == ranks and all(len(part.cells[0].data) for part in parts)
    one = meshio.read(folder / "one" / f"{name}.vtu")
    arrays = {
        item.attrib["Name"]: int(item.attrib["NumberOfComponents"])
        for item in root.iter("PDataArray")
    }
    assert arrays.pop("Points") == 3
    assert arrays == {
        key: values[0].size // len(values[0]) for key, values in one.cell_data.items()
    }
    assert {"eps_s", "u_solid", "eps_s_mean", "theta_total_mean"} <= arrays.keys()
    read = read_fields(header)
    # joined where the pieces meet
    assert len(read.points) == len(np.unique(one.cells[0].data))
    (x, found), (y, expected) = by_place(read), by_place(one)
    np.testing.assert_array_equal(x, y)
    for key, values in expected.items():
        np.testing.assert_array_equal(found[key], values, err_msg=key)  # the same bits


def test_a_lost_piece_is_told_by_name(both, tmp_path: Path) -> None:
    _, folder = both
    header = tmp_path / "triangles.pvtu"
    header.write_text((folder / "pieces" / "triangles.pvtu").read_text())
    with pytest.raises(
        ContbedError, match=r"triangles_p00000\.vtu, triangles_p00001\.vtu.* not found"
    ):
        read_fields(header)


def test_series_summary_and_pictures_of_a_run_in_pieces(film) -> None:
    two, one = film
    series = read_series(two / "fields.pvd")
    assert [file.name for _, file in series] == [
        f"fields_{k:04d}.pvtu" for k in range(3)
    ]
    assert (
        [time for time, _ in series]
        == [time for time, _ in read_series(one / "fields.pvd")]
        == [0.02, 0.04, 0.05]
    )
    files = json.loads((two / "summary.json").read_text())["files"]
    pieces = [f"fields_{k:04d}_p{rank:05d}.vtu" for k in range(3) for rank in range(2)]
    assert {file.name for _, file in series} | {*pieces, "fields.png"} <= set(files)
    assert not list(two.glob("*.part")) and not (two / "fields_0000.vtu").exists()


def test_reports_and_films_show_pieces_as_one(film, tmp_path: Path) -> None:
    two, one = (pictures(read_run(folder, "run")) for folder in film)
    assert len(two) == len(one) > 5
    for found, expected in zip(two, one, strict=True):
        assert (found.field, found.times) == (expected.field, expected.times)
        scale = np.nanmax(np.abs(expected.frames)) or 1.0
        # others are rounding where there are no particles
        if found.field in ("eps_s", "eps_s_mean", "p", "|u_gas|"):
            np.testing.assert_allclose(
                found.frames, expected.frames, rtol=0.0, atol=CONTINUED * scale
            )
    assert animate(film[0], tmp_path / "film.gif").stat().st_size > 1000


def test_the_next_run_removes_the_pieces(tmp_path: Path) -> None:
    ran(2, "in_pieces", tmp_path, "triangles", "0.01")
    assert (tmp_path / "fields_0000_p00001.vtu").is_file()
    ran(1, "in_pieces", tmp_path, "triangles", "0.01")
    assert [path.name for path in sorted(tmp_path.glob("*.*vtu"))] == [
        "fields_0000.vtu"
    ]
