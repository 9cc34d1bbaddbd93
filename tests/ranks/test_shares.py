"""Each rank makes its share of a mesh: none holds lists of the whole, and every cell
and side is where it belongs.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from dolfinx_launch import started

PROGRAM = Path(__file__).with_name("shares_program.py")
SHAPES = ("line", "rectangles", "triangles", "bricks", "tetrahedra", "refined", "file")


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory):
    """Folder with what a command of the program wrote on a number of ranks, run when
    first asked for.
    """
    done = {}

    def get(command: str, ranks: int) -> Path:
        if (command, ranks) not in done:
            done[command, ranks] = folder = tmp_path_factory.mktemp(
                f"{command}-{ranks}"
            )
            finished = started(ranks, command, folder, program=PROGRAM)
            assert finished.returncode == 0, (
                finished.stdout[-4000:] + finished.stderr[-8000:]
            )
        return done[command, ranks]

    return get


@pytest.mark.parametrize("ranks", [1, 2, 3])
@pytest.mark.parametrize("name", SHAPES)
def test_ranks_give_equal_shares(name: str, ranks: int, written) -> None:
    folder = written("cells", ranks)
    found = np.load(folder / f"{name}.npz")
    given = [
        json.loads((folder / f"rank{k}.json").read_text())[name] for k in range(ranks)
    ]
    for counts, whole in zip(np.transpose(given), found["size"], strict=True):
        assert counts.sum() == whole and np.ptp(counts) <= 1


@pytest.mark.parametrize("ranks", [1, 2, 3])
@pytest.mark.parametrize("name", SHAPES)
def test_cells_and_sides_are_where_they_belong(name: str, ranks: int, written) -> None:
    found = np.load(written("cells", ranks) / f"{name}.npz")
    assert np.array_equal(np.sort(found["order"]), np.arange(found["size"][0]))
    # means of the same coordinates in another order
    np.testing.assert_allclose(
        found["middles"], found["expected"], rtol=0.0, atol=1e-15
    )
    assert found["there"].min() > 0
    np.testing.assert_array_equal(found["facets"], found["there"])


@pytest.mark.parametrize("ranks", [1, 2, 3])
@pytest.mark.parametrize("shape", ["rectangles", "triangles"])
def test_no_rank_lists_the_whole_of_a_grid(shape: str, ranks: int, written) -> None:
    """Of 40 x 100 cells, or twice as many; a part has its own faces and those of two
    layers of copies at each cut.
    """
    found = json.loads((written("grids", ranks) / "grids.json").read_text())[shape]
    each = {"rectangles": 2, "triangles": 3}[shape]  # faces for each node
    assert len(found["lists"]) == ranks
    assert max(found["lists"]) <= found["faces"] / ranks + 2 * 3 * each * 40
    assert found["outline"] <= 7 * each * (40 + 100)  # in up to three rows at each side
    # between rows the first rank has no fields
    assert (
        found["state"] == 0
        and found["fields"] == {"rectangles": 4000, "triangles": 8000}[shape]
    )


@pytest.mark.parametrize("ranks", [1, 2])
def test_the_first_rank_assembles_without_points_of_cells(ranks: int, written) -> None:
    found = json.loads((written("points", ranks) / "points.json").read_text())
    assert len(found) > 1 and not any(found)
