"""`contbed report`: one file that needs nothing else, with the numbers of
summary.json, opened in a browser.
"""

import base64
import html
import json
import re

import numpy as np
import pytest
from plane_scene import PLANE

from contbed import load, run
from contbed.errors import ContbedError
from contbed.explain import editor
from contbed.output.tables import axis_of
from contbed.report import charts
from contbed.report.fields import Cloud, pictures
from contbed.report.read import Run, read_run
from contbed.report.write import write
from tests.command_line import command
from tests.report.report_file import BROWSER, WATCH, browse, charts_of

pytest.importorskip(
    "plotly", reason="plotly is not installed: pip install 'contbed[report]'"
)
LIMIT = 5_000_000  # bytes of a report


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    (folder / "plane.toml").write_text(PLANE)
    run(load(folder / "plane.toml"), out=folder / "plane")
    run(
        load(
            folder / "plane.toml",
            {"boundary.left.gas.velocity": 0.2, "packed_bed.porosity": 0.5},
        ),
        out=folder / "slower",
    )
    return folder


def test_numbers_are_those_of_the_summary(plane):
    text = write([plane / "plane"]).read_text()
    summary = json.loads((plane / "plane" / "summary.json").read_text())
    assert len(text) < LIMIT
    plain = html.unescape(
        re.sub(r"<[^>]+>", " ", text.split('<script type="text/plain"')[0])
    )
    for key, value in summary["qoi"].items():
        assert key.split(" [")[0] in plain and f"{value:.6g}" in plain
    for part in (
        "balance of energy closes to",
        "mesh.length",
        "left out",
        "Wakao, Kaguei, Funazkri 1979",
        "version of numpy",
        "hash of the scene",
        summary["host"],
        summary["begun"],
    ):
        assert part in plain
    assert summary["scene"]["title"] in plain
    assert "report.html" in summary["files"]  # the next run into the folder removes it


def test_nothing_is_loaded_from_elsewhere(plane):
    text = write([plane / "plane"]).read_text()
    assert not re.search(
        r"<(script|link|img|iframe)[^>]+(src|href)=", text.split('id="plotly"')[0]
    )


def test_packed_fields_are_exact_to_their_digits():
    values = np.linspace(280.0, 900.0, 2 * 3 * 4).reshape(2, 3, 4)
    values[0, 1, 2] = np.nan
    found = charts.packed(values)
    numbers = np.frombuffer(base64.b64decode(found["data"]), "<u2").reshape(
        found["shape"]
    )
    assert (numbers == 65535).sum() == 1 and numbers[0, 1, 2] == 65535
    back = found["low"] + numbers * (found["high"] - found["low"]) / 65534
    there = np.isfinite(values)
    assert np.abs(back - values)[there].max() <= 0.5 * 620.0 / 65534 * (1 + 1e-9)


def test_fields_of_a_plane_are_where_they_belong(plane):
    """The picture of the solid at the end against the field at its own points, away
    from steep layers.
    """
    import meshio

    items = {item.field: item for item in pictures(read_run(plane / "plane", "plane"))}
    item = items["T_solid"]
    assert item.times == (200.0, 500.0, 1000.0) and item.frames.shape == (
        3,
        len(item.y),
        len(item.x),
    )
    mesh = meshio.read(plane / "plane" / "fields_0002.vtu")
    for point, value in zip(mesh.points, mesh.point_data["T_solid"], strict=True):
        if 0.05 < point[0] < 0.25 and 0.02 < point[1] < 0.05:
            i, j = (
                np.abs(item.x - point[0]).argmin(),
                np.abs(item.y - point[1]).argmin(),
            )
            # half a point, 1 mm, at 2 K/mm
            assert item.frames[2, j, i] == pytest.approx(value, abs=3.0)


def test_a_box_is_cut_in_its_middle(tmp_path):
    text = PLANE.replace('"rectangle", length = 0.3, height = 0.1, cells = [12, 4]',
                         '"box", length = 0.3, width = 0.06, height = 0.1, cells = [6, '
                         '2, 4]')  # fmt: skip
    text = re.sub(r"^time = .*$", "", text, flags=re.MULTILINE)
    (tmp_path / "box.toml").write_text(text)
    run(load(tmp_path / "box.toml"), out=tmp_path / "box")
    (item, *_) = pictures(read_run(tmp_path / "box", "box"))
    assert item.remark == "plane y = 0.03 m" and item.axes == ("x", "z")
    assert np.isfinite(item.frames).all() and item.frames.min() >= 290.0


def test_particles_have_their_size(plane):
    """Two spheres that touch the sides of the picture: their diameters in pixels are
    shares of its height.
    """
    radius = np.array([0.01, 0.03])
    frame = (
        np.array([0.01, 0.03]),
        np.array([0.21, 0.03]),
        radius,
        np.array([1.0, 2.0]),
    )
    cloud = Cloud("T", (frame,), (0.0,), "")
    assert np.allclose(cloud.box(), [(0.0, 0.06), (0.0, 0.22)])
    chart = charts.picture(read_run(plane / "plane", "plane"), cloud, False)
    inside = chart["height"] - charts.MARGINS
    assert np.allclose(
        chart["data"][0]["marker"]["size"], 2 * radius / 0.22 * inside, rtol=1e-5
    )


def test_two_runs_side_by_side(plane):
    text = write([plane / "plane", plane / "slower"], plane / "both.html").read_text()
    plain = html.unescape(
        re.sub(r"<[^>]+>", " ", text.split('<script type="text/plain"')[0])
    )
    assert "boundary.left.gas.velocity" in plain and "Where the scenes differ" in plain
    names = {
        trace["name"]
        for chart in charts_of(text)
        if chart["kind"] == "curves"
        for trace in chart["data"]
    }
    assert {"plane: T_fluid", "slower: T_fluid"} <= names
    assert len(text) < LIMIT


@pytest.mark.slow
def test_a_sweep_has_linked_plots(plane):
    (plane / "bed.toml").write_text(editor.template("packed_bed"))
    (plane / "sweep.toml").write_text(
        'scene = "bed.toml"\n[parameters]\nboundary.left.gas.velocity = [0.4, 0.5, '
        "0.6]\n"
    )
    assert (
        command(f"sweep {plane}/sweep.toml --out {plane}/sweep --jobs 1 --quiet") == 0
    )
    text = write([plane / "sweep"]).read_text()
    found = {chart["kind"]: chart for chart in charts_of(text)}
    assert set(found) == {"parallel", "matrix"}
    labels = [
        entry["label"].replace("<br>", "")
        for entry in found["parallel"]["data"][0]["dimensions"]
    ]
    assert any("velocity" in label for label in labels) and any(
        "T_fluid_out" in label for label in labels
    )
    assert len(text) < LIMIT


def test_columns_over_time_are_not_profiles():
    """A bed's height is a column over the time, a coordinate only where each time
    has several rows.
    """
    time = {"t [s]": np.array([0.0, 1.0]), "height [m]": np.array([0.1, 0.2])}
    assert axis_of([time]) == ("t [s]", None)
    profiles = {
        "t [s]": np.array([0.0, 0.0, 1.0, 1.0]),
        "height [m]": np.array([0.0, 1.0, 0.0, 1.0]),
    }
    assert axis_of([profiles]) == ("height [m]", "t [s]")


def test_mistakes_are_one_line(plane, tmp_path, capsys):
    assert command(f"report {tmp_path}") == 1
    assert capsys.readouterr().err.startswith(f"{tmp_path}: no summary.json of a run")
    (tmp_path / "summary.json").write_text('{"status": "running"}')
    with pytest.raises(ContbedError, match="has not ended"):
        write([tmp_path])


def test_run_writes_a_report_also_of_a_failure(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = re.sub(r"^time = .*$", "", PLANE, flags=re.MULTILINE)
    (tmp_path / "steady.toml").write_text(text + "[solver]\nstrict = true\n")
    assert command("run steady.toml --report --quiet --set closures.nusselt=gunn") == 0
    report = tmp_path / "results" / "steady" / "report.html"
    assert (
        "report.html"
        in json.loads((report.parent / "summary.json").read_text())["files"]
    )
    assert command("run steady.toml --quiet --set closures.nusselt=gunn") == 0
    assert not report.exists()
    assert (
        command(
            "run steady.toml --report --quiet --set boundary.left.gas.velocity=0.001"
        )
        == 4
    )
    assert "closure out of range" in report.read_text()


def test_a_report_of_others_is_not_replaced(tmp_path, monkeypatch, capsys):
    """Before the run, and by the command alone; a report of a folder without a summary
    is known by its content.
    """
    monkeypatch.chdir(tmp_path)
    text = re.sub(r"^time = .*$", "", PLANE, flags=re.MULTILINE)
    (tmp_path / "steady.toml").write_text(text)
    out = tmp_path / "out"
    out.mkdir()
    other = out / "report.html"
    other.write_text("<html>of others</html>")
    run = "run steady.toml --quiet --out out"
    assert command(f"{run} --report") == 1
    assert "report.html: not written by a run of contbed" in capsys.readouterr().err
    assert not (out / "summary.json").exists()
    assert command(run) == 0
    assert command("report out") == 1 and other.read_text() == "<html>of others</html>"
    other.unlink()
    assert command("report out") == command("report out") == 0
    assert command("report out --out one.html") == 0
    assert command("report out --out one.html") == 0
    (tmp_path / "one.html").write_text("<html>of others</html>")
    assert command("report out --out one.html") == 1


USE = """<script>
const wait = setInterval(() => {
  if (document.body.dataset.ready === undefined) return;
  clearInterval(wait);
  const seen = [];
  for (const slider of document.querySelectorAll("input[data-chart]")) {
    const div = document.getElementById("chart" + slider.dataset.chart);
    const state = () => JSON.stringify([div.data[0].z, div.data[0].y]);
    const before = state();
    slider.value = 0;
    slider.dispatchEvent(new Event("input"));
    seen.push([slider.parentElement.querySelector("output").textContent, before !== state()]);
  }
  const told = { faults, seen, ready: document.body.dataset.ready };
  const pre = document.createElement("pre");
  pre.id = "told";
  pre.textContent = JSON.stringify(told);
  document.body.appendChild(pre);
}, 50);
</script>"""


@pytest.mark.slow
@pytest.mark.skipif(
    BROWSER is None, reason="no Chromium here: apt-get install chromium"
)
def test_in_a_browser(plane, tmp_path):
    """It opens without an error, each slider changes its chart, axes are labelled,
    and the picture is not empty.
    """
    text = write([plane / "plane"], tmp_path / "report.html").read_text()
    tried = tmp_path / "tried.html"
    tried.write_text(
        text.replace("<head>", "<head>" + WATCH).replace("</body>", USE + "</body>")
    )
    dom = browse("--dump-dom", f"file://{tried}")
    told = json.loads(
        html.unescape(re.search(r'<pre id="told">(.*?)</pre>', dom, re.DOTALL)[1])
    )
    assert told["faults"] == []
    assert int(told["ready"]) >= 5
    assert len(told["seen"]) >= 4 and all(
        when == "200 s" and changed for when, changed in told["seen"]
    )
    labels = set(re.findall(r'class="[xy]title"[^>]*>([^<]+)<', dom))
    assert {"x [m]", "y [m]", "K", "wall time [s]"} <= labels
    browse(
        "--window-size=1280,2000",
        f"--screenshot={tmp_path / 'shot.png'}",
        f"file://{tmp_path / 'report.html'}",
    )
    from matplotlib.image import imread

    pixels = imread(tmp_path / "shot.png")[..., :3]
    assert pixels.shape[:2] == (2000, 1280)
    colours = np.unique((pixels.reshape(-1, 3) * 31).astype(int), axis=0)
    assert len(colours) > 100  # the scale of colours of the fields, curves and text


def test_tables_of_a_list_are_shown_key_by_key(tmp_path):
    layer = {"start": -1e30, "end": 0.2, "gas": {"velocity": 0.5}}
    scene = {"model": "two_fluid", "initial": {"layer": [layer]}}
    keys = Run("bed", tmp_path, {"scene": scene}, {}, ()).scene_keys()
    shown = {key.name: (key.value, key.unit, key.default) for key in keys}
    assert shown["initial.layer[0].start"] == (-1e30, "m", True)
    assert shown["initial.layer[0].end"] == (0.2, "m", False)
    assert shown["initial.layer[0].gas.velocity"] == (0.5, "m/s", False)
