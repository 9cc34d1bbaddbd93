"""Everything a run writes: read back, compared, and broken on purpose."""

import base64
import errno
import io
import json
import math
import os
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
import zipfile
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import skfem

from contbed import fields
from contbed.errors import ContbedError, ConvergenceError, SceneError
from contbed.fem.elements import Space
from contbed.loading import loads
from contbed.output import checkpoint, curves, maps, progress, summary
from contbed.output.files import atomic
from contbed.output.progress import Progress
from contbed.output.tables import read_table, write_table
from contbed.output.vtu import write_fields, write_series
from contbed.result import outside
from contbed.runner import run
from tests.cases import cases_of, each_case
from tests.refusals import refused

LINE, X, Y = (
    np.array([0.0, 0.3, 0.4, 1.0]),
    np.array([0.0, 0.4, 1.0, 1.1]),
    np.array([0.0, 0.5, 0.7]),
)
SHEAR = np.array([[1.0, 0.2, 0.1], [0.3, 1.5, 0.0], [0.0, 0.2, 0.8]])
MESHES = {
    "line3": skfem.MeshLine(LINE),
    "triangle6": skfem.MeshTri.init_tensor(X, Y),
    "quad9": skfem.MeshQuad.init_tensor(X, Y),
    "tetra10": skfem.MeshTet.init_tensor(X, Y, LINE),
    "hexahedron27": skfem.MeshHex.init_tensor(X, Y, LINE),
}
MESHES = {
    name: replace(m, doflocs=SHEAR[: m.dim(), : m.dim()] @ m.p)
    for name, m in MESHES.items()
}
SIZES = {"line3": 1.0, "triangle6": 0.77 * 1.44, "quad9": 0.77 * 1.44}
SIZES |= dict.fromkeys(("tetra10", "hexahedron27"), 0.77 * np.linalg.det(SHEAR))
# corners around each node that is not a corner
AROUND = dict(cases_of(__file__, "corners_around_nodes", "cell", "corners"))


def polynomial(points: np.ndarray, degree: int) -> np.ndarray:
    """A full polynomial of total degree up to 3."""
    direction = np.array([1.0, -2.0, 0.7])[: len(points)] @ points
    other = np.array([0.3, 1.0, -1.1])[: len(points)] @ points
    return sum(
        (direction + 0.1 * k) ** k - other * direction ** (k - 1)
        for k in range(1, degree + 1)
    )


@pytest.fixture(params=MESHES)
def cell(request):
    return request.param


def test_fields_have_units_and_bounds():
    assert fields.header("T_fluid") == "T_fluid [K]"
    assert fields.FIELDS["T_solid"].lower == 0.0
    assert fields.FIELDS["theta_solid"].label == r"$\theta_\mathrm{s}$"
    assert fields.FIELDS["u"].label == "$u$ [m/s]"
    assert all(
        fields.name_of(fields.header(name)) == name and name.isascii()
        for name in fields.FIELDS
    )
    assert fields.unit_of("T_fluid_outlet") == "K"
    assert fields.unit_of("T") is None


def test_profiles_can_be_left_out(tmp_path):
    scene = """
        mesh = { type = "line", length = 1.0 }
        radiation = { absorption = 1.0, conductivity = 1.0 }
        boundary.left.radiation.temperature = 300
        boundary.right.radiation.temperature = 400
    """
    for wanted in ("true", "false"):
        run(
            loads(
                scene
                + f"output = {{ profiles = {wanted}, plots = false, fields = false }}"
            ),
            out=tmp_path / wanted,
        )
    assert "profiles.csv" in {path.name for path in (tmp_path / "true").iterdir()}
    assert "profiles.csv" not in {path.name for path in (tmp_path / "false").iterdir()}
    assert (tmp_path / "false" / "summary.json").is_file()


def test_vtu_reads_back(cell, tmp_path):
    meshio = pytest.importorskip("meshio")
    mesh = MESHES[cell]
    nodal = {}
    for degree in (1, 2) if cell == "hexahedron27" else (1, 2, 3):
        space = Space(mesh, degree)
        nodal[f"f{degree}"] = space, polynomial(space.points, degree)
    space = Space(mesh, 2)
    nodal["u"] = (
        space,
        np.array([polynomial(space.points, 2) + k for k in range(mesh.dim())]),
    )
    write_fields(tmp_path / "fields.vtu", mesh, nodal)
    back = meshio.read(tmp_path / "fields.vtu")
    points = back.points[:, : mesh.dim()].T
    assert back.points.shape[1] == 3 and not back.points[:, mesh.dim() :].any()
    assert len(back.points) == space.size and "region" not in back.cell_data
    velocity = np.zeros((3, len(back.points)))
    for k in range(mesh.dim()):
        velocity[k] = polynomial(points, 2) + k
    expected = {
        name: polynomial(points, space.degree) for name, (space, _) in nodal.items()
    }
    for name, values in (expected | {"u": velocity.T}).items():
        np.testing.assert_allclose(back.point_data[name], values, rtol=0, atol=1e-12)


def test_vtu_node_order_is_that_of_vtk(cell, tmp_path):
    meshio = pytest.importorskip("meshio")
    mesh = MESHES[cell]
    write_fields(tmp_path / "fields.vtu", mesh, {})
    back = meshio.read(tmp_path / "fields.vtu")
    (block,) = back.cells
    assert block.type == cell and len(block.data) == mesh.nelements
    nodes = back.points[block.data]
    corners = 1 + max(map(max, AROUND[cell]))
    assert nodes.shape[1] == corners + len(AROUND[cell])
    for k, around in enumerate(AROUND[cell]):
        assert np.allclose(
            nodes[:, corners + k], nodes[:, around].mean(axis=1), rtol=0, atol=1e-14
        )
    assert np.all(signed_sizes(cell, nodes) > 0)
    assert signed_sizes(cell, nodes).sum() == pytest.approx(SIZES[cell], rel=1e-12)


def signed_sizes(cell: str, nodes: np.ndarray) -> np.ndarray:
    """Sizes of VTK's cells with parallel sides or straight simplices, negative where
    turned inside out.
    """
    toward = {
        "line3": [1],
        "triangle6": [1, 2],
        "quad9": [1, 3],
        "tetra10": [1, 2, 3],
        "hexahedron27": [1, 3, 4],
    }[cell]
    spans = np.array([nodes[:, k] - nodes[:, 0] for k in toward])[:, :, : len(toward)]
    share = {"triangle6": 2, "tetra10": 6}.get(cell, 1)
    return np.linalg.det(spans.transpose(1, 0, 2)) / share


def test_vtu_blocks_that_are_full(tmp_path):
    """A whole number of VTK's blocks of 32768 bytes: 3 * 4096 numbers of nodes."""
    meshio = pytest.importorskip("meshio")
    mesh = skfem.MeshLine(np.linspace(0.0, 1.0, 4097))
    space = Space(mesh, 1)
    write_fields(tmp_path / "fields.vtu", mesh, {"p": (space, space.points[0] ** 2)})
    back = meshio.read(tmp_path / "fields.vtu")
    assert back.cells[0].data.shape == (4096, 3) and back.cells[0].data.max() == 8192
    ends = back.points[back.cells[0].data[:, :2], 0]
    assert (back.point_data["p"][back.cells[0].data[:, :2]] == ends**2).all()
    assert (ends[:, 1] - ends[:, 0] == 1 / 4096).all()
    for array in ElementTree.parse(tmp_path / "fields.vtu").iter("DataArray"):
        count, full, last = np.frombuffer(
            base64.b64decode(array.text.strip()[:16]), np.uint32
        )
        wanted = {
            "p": 8 * 8193,
            "Points": 24 * 8193,
            "connectivity": 24 * 4096,
            "offsets": 8 * 4096,
            "types": 4096,
        }
        # what VTK allocates; it counts a last block that is full as 0
        size = (count - (last > 0)) * full + last
        assert size == wanted[array.get("Name")] and last < full == 32768


def test_vtu_regions(tmp_path):
    meshio = pytest.importorskip("meshio")
    mesh = MESHES["quad9"].with_subdomains(
        {"core": lambda x: x[0] < 0.5, "wall": lambda x: x[0] >= 0.5}
    )
    write_fields(tmp_path / "a.vtu", mesh, {})
    back = meshio.read(tmp_path / "a.vtu")
    (region,) = back.cell_data["region"]
    assert region.dtype.kind == "i" and set(region) == {0, 1}
    assert np.array_equal(
        np.flatnonzero(region == list(mesh.subdomains).index("wall")),
        mesh.subdomains["wall"],
    )


def test_vtu_refuses_nonsense(tmp_path):
    mesh = MESHES["quad9"]
    space = Space(mesh, 1)
    for name in ("T fluid", "\u03b8"):
        with pytest.raises(ValueError, match="plain ASCII"):
            write_fields(
                tmp_path / "a.vtu", mesh, {name: (space, np.zeros(space.size))}
            )
    with pytest.raises(ValueError, match="values on a space"):
        write_fields(tmp_path / "a.vtu", mesh, {"p": (space, np.zeros(3))})
    assert not list(tmp_path.iterdir())


def test_series(tmp_path):
    write_series(
        tmp_path / "fields.pvd", [(0.0, "fields_0000.vtu"), (0.1 + 0.2, 'a&"b.vtu')]
    )
    sets = (
        ElementTree.parse(tmp_path / "fields.pvd")
        .getroot()
        .findall("Collection/DataSet")
    )
    assert [item.get("file") for item in sets] == ["fields_0000.vtu", 'a&"b.vtu']
    assert float(sets[1].get("timestep")) == 0.1 + 0.2


def test_table_round_trip(tmp_path):
    columns = {
        "x [m]": np.array([0.0, 1 / 3, 1e-300]),
        "T_fluid [K]": np.array([300, math.nan, -math.inf]),
    }
    write_table(tmp_path / "deep" / "profiles.csv", columns)
    text = (tmp_path / "deep" / "profiles.csv").read_text()
    assert text.splitlines()[:3] == ["x [m],T_fluid [K]", "0,300", "0.333333333333,nan"]
    back = read_table(tmp_path / "deep" / "profiles.csv")
    assert list(back) == list(columns)
    for header, values in columns.items():
        assert np.allclose(back[header], values, rtol=1e-12, atol=0, equal_nan=True)
    write_table(tmp_path / "empty.csv", {"x [m]": [], "a, b": []})
    assert {
        header: len(values)
        for header, values in read_table(tmp_path / "empty.csv").items()
    } == dict.fromkeys(("x [m]", "a, b"), 0)


def test_table_refuses_what_is_no_table(tmp_path):
    for columns in ({}, {"x": [1.0], "y": [1.0, 2.0]}, {"x": np.zeros((2, 2))}):
        with pytest.raises(ValueError, match="one length"):
            write_table(tmp_path / "a.csv", columns)
    with pytest.raises(ContbedError, match="No such file"):
        read_table(tmp_path / "a.csv")


@each_case(__file__, "damaged_tables_are_told")
def test_damaged_tables_are_told(tmp_path, text, told):
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(ContbedError, match=told) as caught:
        read_table(tmp_path / "t.csv")
    assert "not a table" in str(caught.value) and "\n" not in str(caught.value)


SUMMARY = {
    "qoi": {"T_fluid_outlet": np.float64(412.34567), "power [W]": np.float32(2.5), "T_solid_out_K": 1},
    "status": "ok",
    "dofs": {"flow": np.int64(1234567), "heat": 12},
    "timings": {"mesh": 0.1, "solve": 12.34},
    "balances": {
        "energy": {"in": 10.0, "out": 9.0, "source": 0.0, "stored": None, "relative_residual": 1e-13, "unit": "W"}
    },
    "closures": [
        {
            "name": "nusselt_x", "kind": "nusselt", "source": "A (1990)", "share_outside": 0.25,
            "ranges": {
                "Re": {"declared": [15.0, None], "used": [3.0, 20.0], "share_outside": 0.25},
                "Pr": {"declared": [None, 1000.0], "used": [0.7, 0.7], "share_outside": 0.0},
            },
        }
    ],
    "warnings": ["closure [bold]nusselt_x[/bold] is used outside its range"],
}  # fmt: skip


def test_a_range_that_is_left_is_told_in_few_digits():
    """One number where both ends are the same, and no end that is not there."""
    use = {
        "eps": {
            "declared": [0.372583728893804, 0.372583728893804],
            "used": [0.45, 0.45],
            "share_outside": 1.0,
        },
        "Re": {"declared": [15.0, None], "used": [3.0, 20.0], "share_outside": 0.5},
        "Pr": {"declared": [0.0, 1.0], "used": [0.7, 0.7], "share_outside": 0.0},
    }
    text = "eps 0.45, declared 0.3726, Re 3 to 20, declared at least 15"
    assert (
        outside({"name": "x", "ranges": use})
        == f"closure x is out of its range: {text}"
    )


def test_json_is_strict_and_ordered(tmp_path):
    content = SUMMARY | {
        "extra": [np.nan, np.inf, np.arange(2), (Path("a"), True, None)],
        3: np.float64(0.1),
    }
    summary.write_json(tmp_path / "summary.json", content)

    def refuse(name):
        raise AssertionError(name)

    back = json.loads((tmp_path / "summary.json").read_text(), parse_constant=refuse)
    assert list(back) == [
        "status",
        "dofs",
        "timings",
        "balances",
        "closures",
        "warnings",
        "qoi",
        "extra",
        "3",
    ]
    assert back["extra"] == [None, None, [0, 1], ["a", True, None]] and back["3"] == 0.1
    assert (
        back["dofs"] == {"flow": 1234567, "heat": 12}
        and back["qoi"]["power [W]"] == 2.5
    )
    with pytest.raises(TypeError, match="set"):
        summary.write_json(tmp_path / "summary.json", {"a": {1}})
    assert json.loads((tmp_path / "summary.json").read_text()) == back


def test_result_table_is_plain_and_complete():
    text = summary.table(SUMMARY)
    assert text.isascii() and "\x1b" not in text
    assert all(len(line) <= 100 and line == line.rstrip() for line in text.splitlines())
    for part in (
        "flow 1,234,567, heat 12",
        "solve 12.3 s",
        "energy [W]",
        "1.0e-13",
        "3 to 20",
        "at least 15",
        "at most 1e+03",
        "! 25 %",
        "T_fluid_outlet [K]",
        "412.346",
        "power [W]",
        "[bold]nusselt_x[/bold]",
    ):
        assert part in text
    assert text.count("!") == 1 and "_out_K [K]" not in text
    assert "unknowns   12,345" in summary.table({"dofs": 12345, "timings": {"mesh": 1}})
    narrow = summary.table(SUMMARY, width=40)
    assert all(len(line) <= 40 for line in narrow.splitlines())
    assert "412.346" in narrow
    assert summary.table({"status": "not converged"}).split() == [
        "status",
        "not",
        "converged",
    ]
    several = summary.table(
        {
            "qoi": {
                "short": [265.63457863529555, 322.94544827905776],
                "long": [1 / 3] * 9,
            }
        }
    )
    assert (
        "265.635, 322.945" in several
        and several.count("0.333333") == 8
        and "... (9" in several
    )


def test_result_table_has_the_units_of_a_line():
    """Heats on a line are per area, whatever their names say."""
    qoi = {"duty_W": 2.0, "T_fluid_out_K": 300.0}
    text = summary.table(
        {"qoi": qoi, "units": {"duty_W": "W/m2", "T_fluid_out_K": "K"}}
    )
    assert "duty_W [W/m2]" in text and "T_fluid_out_K [" not in text
    assert "duty_W  " in summary.table({"qoi": qoi, "units": {"duty_W": "W"}})


def test_result_table_has_colour_on_a_terminal(monkeypatch):
    monkeypatch.setattr(sys, "stdout", FakeTerminal())
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    assert "\x1b[" in summary.table(SUMMARY)


def picture(path: Path) -> np.ndarray:
    """Pixels of a PNG as (height, width, 3)."""
    from matplotlib.image import imread

    return imread(path)[:, :, :3]


def shows_something(path: Path) -> bool:
    """Whether a picture has its width, ink, and nothing cut at the sides."""
    pixels = picture(path)
    inked = np.mean(pixels.min(axis=2) < 0.9)
    return (
        1500 < pixels.shape[1] < 1750
        and inked > 0.005
        and np.all(pixels[:, [0, -1]] == 1.0)
    )


def test_profiles(tmp_path):
    x = np.linspace(0, 1, 50)
    columns = {
        "x [m]": x,
        "T_fluid [K]": 300 + x,
        "T_solid [K]": 310 + x,
        "p [Pa]": 1 - x,
    }
    curves.profile_plot(tmp_path / "a.png", columns, "x [m]", "50 % of $5, \\alpha")
    assert shows_something(tmp_path / "a.png")
    curves.profile_plot(
        tmp_path / "a.png", {"z [m]": x, "u [m/s]": 0 * x + 1, "p [Pa]": 1 - x}, "z [m]"
    )
    assert shows_something(tmp_path / "a.png")


def test_transient_profiles(tmp_path):
    x, t = (a.ravel() for a in np.meshgrid(np.linspace(0, 1, 30), np.arange(20.0)))
    columns = {
        "t [s]": t,
        "x [m]": x,
        "theta_fluid [1]": np.tanh(x - t / 20),
        "theta_solid [1]": 0 * x,
    }
    curves.transient_plot(tmp_path / "a.png", columns, "x [m]", "front")
    assert shows_something(tmp_path / "a.png")
    one = {header: values[t == 3.0] for header, values in columns.items()}
    curves.transient_plot(tmp_path / "a.png", one, "x [m]")
    assert shows_something(tmp_path / "a.png")


@pytest.mark.parametrize(
    "shape", [(1.0, 1.0), (0.05, 0.1), (0.05, 0.5), (1.0, 30.0), (4.0, 1.0)]
)
def test_maps(shape, tmp_path):
    mesh = skfem.MeshQuad.init_tensor(*(np.linspace(0, size, 6) for size in shape))
    cubic, quadratic = Space(mesh, 3), Space(mesh, 2)
    temperature = 300 + 10 * cubic.points[0]
    nodal = {
        "T_fluid": (cubic, temperature),
        "T_solid": (cubic, temperature + 5),
        "p": (Space(mesh, 1), np.zeros(36)),
    }
    nodal["u"] = quadratic, np.array([0 * quadratic.points[0], quadratic.points[0] + 1])
    maps.field_plot(tmp_path / "a.png", mesh, nodal, axisymmetric=True, title="bed")
    assert shows_something(tmp_path / "a.png")


def test_map_of_a_flow_on_triangles(tmp_path):
    mesh = MESHES["triangle6"]
    nodal = {
        "p": (Space(mesh, 1), np.ones(mesh.nvertices)),
        "u": (Space(mesh, 2), np.ones((2, Space(mesh, 2).size))),
    }
    maps.field_plot(tmp_path / "a.png", mesh, nodal)
    assert shows_something(tmp_path / "a.png")
    with pytest.raises(ValueError, match="2-D"):
        maps.field_plot(tmp_path / "b.png", MESHES["tetra10"], {})


ARRAYS = {
    "state": np.array([0.1, -0.0, 5e-324, np.nan, np.inf, 1 / 3]),
    "file": np.arange(6, dtype=np.int32).reshape(2, 3).T,
    "empty": np.zeros((0, 2)),
    "number": np.array(2.5),
}
IDENTITY = {
    "values": {"flow": {"velocity": 0.3}, "time": {"end": 1.0}},
    "files": {"a.msh": "1"},
    "contbed": "1",
}
META = {"identity": IDENTITY, "time": 0.1 + 0.2, "tick": 2**60, "level": np.int64(3)}


def test_checkpoint_is_bitwise(tmp_path):
    checkpoint.save(tmp_path / "new", ARRAYS, META)
    arrays, meta = checkpoint.load(tmp_path / "new")
    assert meta == META and set(arrays) == set(ARRAYS)
    for name, array in ARRAYS.items():
        same = arrays[name]
        assert (
            same.dtype == array.dtype
            and same.shape == array.shape
            and same.tobytes() == array.tobytes()
        )
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["checkpoint.npz"]
    with pytest.raises(TypeError, match="objects"):
        checkpoint.save(tmp_path, {"a": np.array([None])}, {})


@pytest.mark.parametrize(("every", "written"), [(1e-9, [0.0, 1.0, 2.0]), (1e9, [2.0])])
@pytest.mark.parametrize("error", [None, KeyboardInterrupt, ConvergenceError("no")])
def test_states_are_kept_at_intervals_and_at_the_end(
    tmp_path, monkeypatch, every, written, error
):
    """The last state that was offered is written also where the run fails, as it was
    when it was offered.
    """
    save, found, state = checkpoint.save, [], np.zeros(1)

    def watched(folder, arrays, meta):
        found.append(float(arrays["a"][0]))
        save(folder, arrays, meta)

    monkeypatch.setattr(checkpoint, "save", watched)

    def run(folder):
        with checkpoint.Keeper(folder, IDENTITY, every) as keeper:
            for _ in range(3):
                keeper.offer({"a": state}, {"files": "2"})
                state[0] += 1.0
            if error is not None:
                raise error

    run_to_its_end = (
        pytest.raises((KeyboardInterrupt, ConvergenceError)) if error else nullcontext()
    )
    with run_to_its_end:
        run(tmp_path)
    assert found == written
    arrays, meta = checkpoint.load(tmp_path)
    assert arrays["a"] == [2.0] and meta == {"identity": IDENTITY, "files": "2"}


def test_no_folder_no_checkpoint(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with checkpoint.Keeper(None, IDENTITY, 1e-9) as keeper:
        keeper.offer({"a": np.zeros(1)})
    assert list(tmp_path.iterdir()) == []


def test_checkpoint_damage_is_noticed(tmp_path):
    checkpoint.save(tmp_path, ARRAYS, META)
    path = tmp_path / "checkpoint.npz"
    good = path.read_bytes()
    damaged = [good[:n] for n in range(0, len(good), 97)]
    for position in range(0, len(good), 61):
        damaged.append(
            good[:position] + bytes([good[position] ^ 0x21]) + good[position + 1 :]
        )
    refused = 0
    for content in damaged:
        path.write_bytes(content)
        try:
            arrays, meta = checkpoint.load(tmp_path)
        except SceneError as error:
            assert "damaged checkpoint" in str(error) and "\n" not in str(error)
            refused += 1
        else:
            # the change met bytes that carry nothing, such as a date
            assert meta == META and all(
                arrays[name].tobytes() == array.tobytes()
                for name, array in ARRAYS.items()
            )
    assert refused > 0.7 * len(damaged)


def test_checkpoint_checksum_covers_all_values(tmp_path):
    checkpoint.save(tmp_path, ARRAYS, META)
    path = tmp_path / "checkpoint.npz"
    with np.load(path) as file:
        entries = dict(file)
    for change in (
        {"array.state": np.zeros(6)},
        {"meta": np.array("{}")},
        {"array.more": np.zeros(1)},
    ):
        np.savez(path, **(entries | change))
        refused("checksum", checkpoint.load, tmp_path)


def test_checkpoint_missing_or_of_another_scene(tmp_path):
    refused("no such folder", lambda: checkpoint.load(tmp_path / "none"))
    refused(r"no checkpoint\.npz", checkpoint.load, tmp_path)
    checkpoint.require_same(META, IDENTITY)


@each_case(__file__, "the_checkpoint_of_another_scene_names_what_differs")
def test_the_checkpoint_of_another_scene_names_what_differs(change, told):
    arguments = (META, IDENTITY | change, ["time.end"], lambda key: key.split(".")[0])
    if not told:
        checkpoint.require_same(*arguments)
        return
    with pytest.raises(SceneError) as caught:
        checkpoint.require_same(*arguments)
    assert len(caught.value.problems) == len(told)
    assert all(
        text in problem
        for text, problem in zip(told, caught.value.problems, strict=True)
    )
    refused("does not name its scene", checkpoint.require_same, {}, IDENTITY)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_full_disk_keeps_the_previous_checkpoint(tmp_path, monkeypatch):
    real = zipfile.ZipFile
    for before in ("no earlier checkpoint", "previous checkpoint is intact"):
        with (
            monkeypatch.context() as patch,
            pytest.raises(ContbedError, match=before) as caught,
        ):
            patch.setattr(
                zipfile, "ZipFile", lambda path, mode: real("/dev/full", mode)
            )
            checkpoint.save(tmp_path, {"a": np.zeros(100_000)}, {})
        assert "No space left" in str(caught.value) and str(tmp_path) in str(
            caught.value
        )
        assert "\n" not in str(caught.value) and type(caught.value) is ContbedError
        assert not list(tmp_path.glob("*.part"))
        checkpoint.save(tmp_path, {"a": np.ones(3)}, {})
    assert checkpoint.load(tmp_path)[0]["a"].sum() == 3


@pytest.mark.skipif(os.name == "nt", reason="needs SIGKILL")
def test_kill_leaves_a_whole_checkpoint(tmp_path):
    program = (
        "import sys, numpy as np\n"
        "from contbed.output import checkpoint\n"
        "for k in range(10**6):\n"
        "    checkpoint.save(sys.argv[1], {'a': np.full(100_000, k)}, {'k': k})\n"
    )
    for wait in (0.0, 0.007, 0.013):
        process = subprocess.Popen([sys.executable, "-c", program, str(tmp_path)])
        deadline = time.monotonic() + 20
        (tmp_path / "checkpoint.npz").unlink(missing_ok=True)
        while (
            not (tmp_path / "checkpoint.npz").exists() and time.monotonic() < deadline
        ):
            time.sleep(0.005)
        time.sleep(wait)
        process.send_signal(signal.SIGKILL)
        process.wait()
        arrays, meta = checkpoint.load(tmp_path)
        assert np.all(arrays["a"] == meta["k"])


@pytest.mark.parametrize(
    "broken", ["folder in the way", "file as folder", "full", "interrupted"]
)
def test_atomic_keeps_the_old_file(broken, tmp_path, monkeypatch):
    path = tmp_path / "out" / "a.txt"
    if broken == "folder in the way":
        path.mkdir(parents=True)
        error, text = ContbedError, "a folder has this name"
    elif broken == "file as folder":
        path.parent.write_text("old")
        error, text = ContbedError, "a file has the name of the folder"
    else:
        path.parent.mkdir()
        path.write_text("old")
        error, text = (
            (ContbedError, "free some space")
            if broken == "full"
            else (KeyboardInterrupt, None)
        )
    with pytest.raises(error, match=text) as caught, atomic(path) as temporary:
        temporary.write_text("new")
        if broken == "full":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        if broken == "interrupted":
            raise KeyboardInterrupt
    if error is ContbedError:
        assert str(path) in str(caught.value) and "\n" not in str(caught.value)
    old = path.parent if broken == "file as folder" else path
    assert old.is_dir() or old.read_text() == "old"
    assert not list(tmp_path.rglob("*.part"))


@pytest.mark.skipif(
    os.name == "nt" or os.geteuid() == 0, reason="root may write anywhere"
)
def test_no_permission(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(ContbedError, match="check the permissions"):
        write_table(tmp_path / "a.csv", {"x": [1.0]})


class FakeTerminal(io.StringIO):
    def isatty(self):
        return True


def test_progress_in_a_pipe_is_a_line_now_and_then(monkeypatch):
    """Every 10 s at most; the longer a run takes, the fewer."""
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    clock = iter([0.0, 9.0, 11.0, 20.0, 22.0, 5000.0, 5020.0, 5510.0])
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=clock.__next__))
    with Progress(2.0, "s") as bar:
        for step in range(1, 8):
            bar.advance_to(0.1 * step, "period 3")
    assert stream.getvalue().splitlines() == [
        "0.2 of 2 s, period 3, 11 s elapsed",
        "0.4 of 2 s, period 3, 22 s elapsed",
        "0.5 of 2 s, period 3, 5000 s elapsed",
        "0.7 of 2 s, period 3, 5510 s elapsed",
    ]


def test_short_and_quiet_runs_show_no_progress_in_a_pipe(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    with Progress(1.0, "s") as bar:
        bar.advance_to(0.5, "note")
    terminal = FakeTerminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with Progress(1.0, "s", quiet=True) as bar:
        bar.advance_to(0.5)
    assert stream.getvalue() == terminal.getvalue() == ""


def test_the_clock_is_shown_where_a_run_tells_nothing(monkeypatch):
    """From SHORTEST on, in a pipe from PAUSE on; not for a run that ends before."""
    monkeypatch.setattr(progress, "SHORTEST", 0.05)
    monkeypatch.setattr(progress, "PAUSE", 0.05)
    monkeypatch.setattr(progress, "WAITING", 0.01)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    shown = []
    for seconds, stream in (
        (0.2, FakeTerminal()),
        (0.0, FakeTerminal()),
        (0.2, io.StringIO()),
    ):
        monkeypatch.setattr(sys, "stderr", stream)
        with progress.waiting():
            time.sleep(seconds)
        shown.append(stream.getvalue())
    assert "0 s" in shown[0] and shown[1] == ""
    assert shown[2].startswith("still computing, 0 s elapsed")
    terminal = FakeTerminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress.waiting(), Progress(1.0) as bar:
        bar.advance_to(0.5, "its own")
        time.sleep(0.2)
    assert "its own" in terminal.getvalue() and "0 s" not in terminal.getvalue()


def test_progress_on_a_terminal(monkeypatch):
    terminal = FakeTerminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    with Progress(2.0, "s") as bar:
        for k in range(1, 1001):
            bar.advance_to(0.001 * k, "step [1] s")
        bar.advance_to(2.0, "done")
    text = terminal.getvalue()
    assert "step [1] s" in text and "2 of 2 s, done" in text and "100 %" in text
    assert text.count("step [1] s") < 100


def test_imports_are_lazy(tmp_path):
    program = (
        "import sys, contbed.output.files, contbed.output.vtu, contbed.output.tables, "
        "contbed.output.summary\n"
        "import contbed.output.curves, contbed.output.checkpoint, "
        "contbed.output.progress\n"
        "with contbed.output.progress.Progress(1.0) as p: p.advance_to(1.0)\n"
        "print(sorted({'meshio', 'matplotlib', 'rich'} & set(sys.modules)))\n"
        "contbed.output.curves.profile_plot(sys.argv[1], {'x [m]': [0, 1], 'p [Pa]': "
        "[0, 1]}, 'x [m]')\n"
        "print('matplotlib.pyplot' in sys.modules)\n"
    )
    command = [sys.executable, "-c", program, str(tmp_path / "a.png")]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.split("\n")[:2] == ["[]", "False"]
