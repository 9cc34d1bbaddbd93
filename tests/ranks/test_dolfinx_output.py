"""Fields in pieces: each rank writes its cells, the pieces are the whole, and a
.pvtu names them.
"""

import xml.etree.ElementTree as tree
from pathlib import Path

import meshio
import numpy as np
import pytest

from contbed.output.stored import read_fields


def rows(mesh: meshio.Mesh, name: str):
    """Values at all points of all cells, in an order that does not depend on how
    cells are dealt out.
    """
    (block,) = mesh.cells
    points, values = (
        mesh.points[block.data],
        np.asarray(mesh.point_data[name])[block.data],
    )
    centres = points.mean(axis=1)
    order = np.lexsort(np.round(centres, 12).T)
    return np.sort(points[order], axis=1), np.sort(values[order], axis=1)


def pieces(header: Path) -> list[meshio.Mesh]:
    found = tree.parse(header).getroot().iter("Piece")
    return [meshio.read(header.parent / item.attrib["Source"]) for item in found]


@pytest.mark.parametrize(
    ("scene", "stem"),
    [("heat_sources_and_tubes", "fields"), ("transient_gas", "fields_0001")],
)
def test_pieces_are_the_whole(results, scene: str, stem: str) -> None:
    alone, together = results("write", 1) / scene, results("write", 2) / scene
    whole, parts = meshio.read(alone / f"{stem}.vtu"), pieces(together / f"{stem}.pvtu")
    assert len(parts) == 2 and all(len(part.cells[0].data) for part in parts)
    assert not (together / f"{stem}.vtu").exists()
    joined = read_fields(together / f"{stem}.pvtu")
    assert len(joined.points) == len(whole.points)
    declared = {
        item.attrib["Name"]
        for item in tree.parse(together / f"{stem}.pvtu").getroot().iter("PDataArray")
    }
    assert declared == {"Points", *whole.point_data, *whole.cell_data}
    for name in whole.point_data:
        (x, one), (y, other) = rows(whole, name), rows(joined, name)
        assert np.abs(x - y).max() <= 1e-12
        assert np.abs(one - other).max() <= 1e-10 * np.abs(one).max()
    for name, (values,) in whole.cell_data.items():
        both = np.concatenate([part.cell_data[name][0] for part in parts])
        assert np.array_equal(np.bincount(both), np.bincount(values))


def test_series_names_the_pieces(results) -> None:
    folder = results("write", 2) / "transient_gas"
    files = [
        item.attrib["file"]
        for item in tree.parse(folder / "fields.pvd").getroot().iter("DataSet")
    ]
    assert files and all(
        name.endswith(".pvtu") and (folder / name).is_file() for name in files
    )
