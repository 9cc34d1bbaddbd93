"""Folders that something has damaged or changed since: each file is told in one
sentence, with what to do.
"""

import copy
import csv
import io
import json
import re
import shutil

import meshio
import numpy as np
import pytest
from plane_scene import PLANE
from result_folders import (
    KINDS,
    of_calibration,
    of_cascade,
    of_optimum,
    of_run,
    of_uncertainty,
)

from contbed import load, run
from contbed.errors import ContbedError
from contbed.report import page
from contbed.report.write import write

BAD = (None, [], {}, "text", 3.5, True, [1], "3.5", {"a": 1}, ...)
"""What a value becomes; ... takes it away."""


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """The code of plotly and the packing of the charts, which take longer than the
    rest, are left out.
    """
    monkeypatch.setattr(page, "_plotly", lambda: "")
    monkeypatch.setattr(page, "_compressed", lambda text: "")


def places(value, path=()):
    """Yield the path of each value; of a list the first two, of the scene those on
    top.
    """
    yield path
    if isinstance(value, dict) and path[:1] != ("scene",):
        for key in value:
            yield from places(value[key], (*path, key))
    elif isinstance(value, list):
        for k in range(min(len(value), 2)):
            yield from places(value[k], (*path, k))


def changed(content, path, bad):
    """Return the content with another value at a place."""
    if not path:
        return [] if bad is ... else bad
    content = copy.deepcopy(content)
    table = content
    for key in path[:-1]:
        table = table[key]
    if bad is ...:
        del table[path[-1]]
    else:
        table[path[-1]] = bad
    return content


def told(folder):
    """Return the message where a report is refused, which names a file and a remedy;
    nothing where it is written.
    """
    try:
        write([folder])
    except ContbedError as error:
        text = str(error)
        assert (
            re.match(rf"(cannot read )?{folder}/\S+\.(json|csv|vtu)[: ]", text)
            and "again" in text
            and "\n" not in text
        )
        return text
    return ""


@pytest.mark.parametrize("kind", KINDS)
def test_any_value_of_json_may_be_of_another_shape(tmp_path, kind):
    folder, file = KINDS[kind](tmp_path)
    assert told(folder) == ""
    content = json.loads((folder / file).read_text())
    found = []
    for k, path in enumerate(places(content)):
        for bad in BAD[k % 3 :: 3]:
            (folder / file).write_text(json.dumps(changed(content, path, bad)))
            found.append(told(folder))
    refused = [text for text in found if text]
    share = 0.2 if kind == "run" else 0.1  # of studies only what cannot be shown
    assert len(refused) > share * len(found) and len(set(refused)) > 10


@pytest.mark.parametrize(
    "text",
    ["", "{", "\x00", "<html>", "[" * 100_000, '{"a": 1}', "[]", "null"],
    ids=repr,
)
def test_a_summary_that_is_none(tmp_path, text):
    (tmp_path / "summary.json").write_text(text[:200_000])
    assert "not the summary of a run" in told(tmp_path)


def texts(text):
    """Yield a table of CSV as others may leave it."""
    rows = list(csv.reader(io.StringIO(text)))

    def written(rows):
        out = io.StringIO()
        csv.writer(out, lineterminator="\n").writerows(rows)
        return out.getvalue()

    yield from (
        "",
        "\n",
        "\x00\x01",
        "<html></html>\n",
        '"' + text,
        text.replace(",", ";"),
        text[: len(text) // 2],
    )
    yield from (
        written(rows[:1]),
        written(rows[:2]),
        written([[rows[0][0]] * len(rows[0]), *rows[1:]]),
    )
    for k in range(len(rows[0])):
        yield written([row[:k] + row[k + 1 :] for row in rows])
        yield written([[*rows[0][:k], "foreign", *rows[0][k + 1 :]], *rows[1:]])
        for cell in ("abc", "", "nan", "inf", "1,5"):
            yield written([*rows[:-1], [*rows[-1][:k], cell, *rows[-1][k + 1 :]]])
            yield written(
                [rows[0], *([*row[:k], cell, *row[k + 1 :]] for row in rows[1:])]
            )


TABLES = {
    "profiles.csv": of_run,
    "table.csv": of_optimum,
    "points.csv": of_calibration,
    "samples.csv": of_cascade,
    "uncertainty.csv": of_uncertainty,
    "keys.csv": of_calibration,
}


@pytest.mark.parametrize("file", TABLES)
def test_tables_may_lack_columns_and_have_texts(tmp_path, file):
    folder, _ = TABLES[file](tmp_path)
    found = []
    for other in texts((folder / file).read_text()):
        (folder / file).write_text(other)
        found.append(told(folder))
    assert sum(map(bool, found)) > 5
    assert file in ("samples.csv", "keys.csv") or any(
        re.search(rf"{file}:\d+: ", one) for one in found
    )


def test_a_table_is_told_with_column_and_line(tmp_path):
    folder, _ = of_calibration(tmp_path)
    text = (folder / "points.csv").read_text()
    (folder / "points.csv").write_text(text.replace(",310,", ",abc,"))
    assert "points.csv:3: measured is 'abc', which is no number" in told(folder)
    (folder / "points.csv").write_text(text.replace("predicted", "foreign"))
    assert "points.csv: has no column 'predicted'" in told(folder)


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    folder = tmp_path_factory.mktemp("damaged")
    (folder / "plane.toml").write_text(PLANE)
    run(load(folder / "plane.toml"), out=folder / "plane")
    return folder / "plane"


LAST = "fields_0002.vtu"
FOREIGN = {
    "no fields": (
        lambda mesh: meshio.Mesh(mesh.points, mesh.cells),
        "not those of fields_0000.vtu",
    ),
    "other cells": (
        lambda mesh: meshio.Mesh(
            np.eye(4, 3), [("tetra", [[0, 1, 2, 3]])], point_data={"T": np.ones(4)}
        ),
        "not those of fields_0000.vtu",
    ),
    "points that are not there": (
        lambda mesh: meshio.Mesh(
            mesh.points, [(b.type, b.data + 1000) for b in mesh.cells], mesh.point_data
        ),
        "a cell names point 1224 of 225",
    ),
}


@pytest.mark.parametrize("what", FOREIGN)
def test_fields_of_another_run_are_told(plane, tmp_path, what):
    make, part = FOREIGN[what]
    folder = tmp_path / "run"
    shutil.copytree(plane, folder)
    make(meshio.read(folder / LAST)).write(folder / LAST)
    assert part in told(folder)


def test_particles_need_their_radius(plane, tmp_path):
    (tmp_path / "summary.json").write_text((plane / "summary.json").read_text())
    meshio.Mesh(
        np.eye(2, 3), [("vertex", [[0], [1]])], point_data={"T": np.ones(2)}
    ).write(tmp_path / "fields.vtu")
    assert "particles without their radius" in told(tmp_path)
