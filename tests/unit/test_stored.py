"""Fields in pieces are read as one mesh."""

from pathlib import Path

import meshio
import numpy as np
import pytest

from contbed.errors import ContbedError
from contbed.output.stored import read_fields, read_series
from contbed.output.vtu import write_series
from contbed.ranks import pieces


@pytest.fixture
def header(tmp_path: Path) -> Path:
    """Two squares side by side, each a piece, the second with its nodes a rounding
    away.
    """
    square = np.array(
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    )
    for rank in range(2):
        points = square + np.array([rank * (1.0 + 1e-15), 0.0, 0.0])
        fields = {
            "point_data": {"x": points[:, 0]},
            "cell_data": {"rank": [np.array([float(rank)])]},
        }
        mesh = meshio.Mesh(points, [("quad", [[0, 1, 2, 3]])], **fields)
        mesh.write(tmp_path / pieces.name_of("fields", rank), file_format="vtu")
    name = pieces.write_header(
        tmp_path / "fields.vtu", {"x": ("Float64", 1)}, {"rank": ("Float64", 1)}, 2
    )
    return tmp_path / name


def test_pieces_are_joined_at_the_nodes_that_they_share(header: Path) -> None:
    mesh = read_fields(header)
    assert mesh.points.shape == (6, 3)
    assert mesh.points[mesh.cells[0].data].mean(axis=1).round(12).tolist() == [
        [0.5, 0.5, 0.0],
        [1.5, 0.5, 0.0],
    ]
    assert mesh.cell_data["rank"][0].tolist() == [0.0, 1.0]
    np.testing.assert_allclose(
        mesh.point_data["x"], mesh.points[:, 0], rtol=0.0, atol=1e-14
    )


def test_a_piece_that_is_lost_is_named(header: Path) -> None:
    (header.parent / "fields_p00001.vtu").unlink()
    with pytest.raises(
        ContbedError, match=r"fields\.pvtu: fields_p00001\.vtu not found"
    ):
        read_fields(header)


@pytest.mark.parametrize("name", ["fields_p00001.vtu", "fields.pvtu"])
@pytest.mark.parametrize("share", [0.0, 0.3, 0.7])
def test_a_damaged_file_is_named(
    header: Path, name: str, share: float, capsys: pytest.CaptureFixture[str]
) -> None:
    """For some faults meshio prints an error and ends the process."""
    file = header.with_name(name)
    content = file.read_bytes()
    file.write_bytes(content[: int(share * len(content))])
    with pytest.raises(ContbedError, match=rf"{name}: a damaged file of fields"):
        read_fields(header)
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("share", [0.0, 0.5])
def test_a_damaged_series_is_named(header: Path, share: float) -> None:
    series = header.with_suffix(".pvd")
    write_series(series, [(0.5, header.name), (1.0, header.name)])
    content = series.read_bytes()
    series.write_bytes(content[: int(share * len(content))])
    with pytest.raises(ContbedError, match=r"fields\.pvd: a damaged file"):
        read_series(series)


def test_a_series_lists_the_files_that_are_there(header: Path) -> None:
    series = header.with_suffix(".pvd")
    write_series(series, [(0.5, header.name), (1.0, "lost.pvtu")])
    assert read_series(series) == [(0.5, header)]
