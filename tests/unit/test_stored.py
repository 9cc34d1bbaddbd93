"""Fields that a run stored, and damage to them."""

from pathlib import Path

import meshio
import numpy as np
import pytest

from contbed.errors import ContbedError
from contbed.output.stored import read_fields, read_series
from contbed.output.vtu import write_series


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A square with a field."""
    square = np.array(
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    )
    mesh = meshio.Mesh(square, [("quad", [[0, 1, 2, 3]])], {"x": square[:, 0]})
    mesh.write(tmp_path / "fields.vtu", file_format="vtu")
    return tmp_path / "fields.vtu"


@pytest.mark.parametrize("share", [0.0, 0.3, 0.7])
def test_a_damaged_file_is_named(
    file: Path, share: float, capsys: pytest.CaptureFixture[str]
) -> None:
    """For some faults meshio prints an error and ends the process."""
    content = file.read_bytes()
    file.write_bytes(content[: int(share * len(content))])
    with pytest.raises(ContbedError, match=r"fields\.vtu: a damaged file of fields"):
        read_fields(file)
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("share", [0.0, 0.5])
def test_a_damaged_series_is_named(file: Path, share: float) -> None:
    series = file.with_suffix(".pvd")
    write_series(series, [(0.5, file.name), (1.0, file.name)])
    content = series.read_bytes()
    series.write_bytes(content[: int(share * len(content))])
    with pytest.raises(ContbedError, match=r"fields\.pvd: a damaged file"):
        read_series(series)


def test_a_series_lists_the_files_that_are_there(file: Path) -> None:
    series = file.with_suffix(".pvd")
    write_series(series, [(0.5, file.name), (1.0, "lost.vtu")])
    assert read_series(series) == [(0.5, file)]
