"""Linked plots: which columns are drawn and how, what is left out and why, and that
a choice in one marks the other.
"""

import html
import json
import re

import pytest

from contbed import load
from contbed.errors import ContbedError
from contbed.many.derivatives.sensitivities import sensitivities
from contbed.many.derivatives.sensitivities import write as write_sensitivities
from contbed.report import page
from contbed.report.linked import (
    GREY,
    MAX_CATEGORIES,
    MAX_PAIRS,
    Column,
    linked,
    read_columns,
)
from contbed.report.write import write
from tests.report.report_file import BROWSER, WATCH, browse, charts_of

pytest.importorskip(
    "plotly", reason="plotly is not installed: pip install 'contbed[report]'"
)
LAWS = ("gunn", {"name": "power", "a": 1.2}, "gunn", True)


def column(name, *values, unit="1"):
    return Column(name, unit, values)


def test_texts_are_categories_on_axes_and_panels():
    found = linked(
        [column("law", *LAWS), column("T", 300.0, 310.0, 320.0, 330.0, unit="K")],
        list("abcd"),
    )
    parallel, matrix = (chart["data"][0] for chart in found.charts)
    axis, number = parallel["dimensions"]
    assert axis["ticktext"] == ["gunn", "power, a = 1.2", "yes"] and axis["values"] == [
        0.0,
        1.0,
        0.0,
        2.0,
    ]
    assert axis["tickvals"] == [0, 1, 2]
    assert number["label"] == "T [K]" and "ticktext" not in number
    panel = matrix["dimensions"][0]
    assert panel["values"] == ["gunn", "power, a = 1.2", "gunn", "yes"] and panel[
        "axis"
    ] == {"type": "category"}
    assert parallel["line"]["color"] == [300.0, 310.0, 320.0, 330.0]
    assert found.left_out == ()


def test_the_lowest_value_is_no_grey():
    """Grey is for rows that are not chosen: the scale has it below the lowest value,
    at the end that hides a row.
    """
    line = linked([column("T", 2.0, 4.0)], ["a", "b"]).charts[0]["data"][0]["line"]
    share = (2.0 - line["cmin"]) / (line["cmax"] - line["cmin"])
    at = [colour for place, colour in line["colorscale"] if place <= share + 1e-12]
    assert at[-1] != GREY and line["colorscale"][0][1] == GREY
    assert 0.0 < share < 0.05


def test_what_is_left_out_is_told_with_the_reason():
    many = [f"file {k}" for k in range(MAX_CATEGORIES + 1)]
    count = len(many)
    rising = [float(k) for k in range(count)]
    columns = [
        column("gaps", *[None, None, *rising[2:]], unit="K"),
        column("same", *[300.0] * count),
        column("one law", *["gunn"] * count),
        column("files", *many),
        column("nothing", *[None] * count),
        *(column(f"q{k}", *rising) for k in range(MAX_PAIRS + 1)),
    ]
    found = linked(columns, many)
    told = dict(found.left_out)
    assert told["gaps [K]"] == f"2 of {count} runs have no value"
    assert (
        told["same"] == "the same in all runs: 300"
        and told["one law"] == "the same in all runs: gunn"
    )
    assert (
        told["files"].startswith(f"{count} different texts")
        and told["nothing"] == "no run has a value"
    )
    assert f"first {MAX_PAIRS} columns" in told[f"q{MAX_PAIRS}"]
    drawn = {axis["label"] for axis in found.charts[0]["data"][0]["dimensions"]}
    # no column is lost without a word
    assert drawn | set(told) == {one.label for one in columns}
    text = found.section("Linked plots", page.Charts().place)
    assert "6 columns are left out" in text and all(
        why in text for why in told.values()
    )


def test_texts_with_gaps_have_a_category_for_them():
    axis = linked([column("yes", "yes", None), column("n", 1, 2)], ["a", "b"]).charts[
        0
    ]["data"][0]["dimensions"][0]
    assert axis["ticktext"] == ["yes", "none"]


def test_tables_that_are_damaged_are_told_with_their_line(tmp_path):
    file = tmp_path / "table.csv"
    file.write_text("k_eff [W/m/K]: objective [W/m/K],run\n1.5,a\n,b\nnan,c\n")
    found = read_columns(file)
    assert list(found) == ["k_eff [W/m/K]: objective", "run"]
    assert found["k_eff [W/m/K]: objective"].values == (1.5, None, None) and found[
        "run"
    ].values == ("a", "b", "c")
    file.write_text("a,b\n1,2\n3\n")
    with pytest.raises(ContbedError, match=r"table.csv:3: .*1 values under 2 headers"):
        read_columns(file)
    with pytest.raises(ContbedError, match="run the command that wrote it again"):
        read_columns(tmp_path / "none.csv")


def sweep(folder):
    """A table of a sweep of nine runs; the sixth failed."""
    runs = [
        {
            "run": f"{k:016x}",
            "exit_code": 3 * (k == 5),
            "problem": "no convergence" * (k == 5),
            "parameters": {
                "boundary.left.gas.velocity": 0.1 * (k // 3),
                "closures.nusselt": ("gunn", {"name": "power", "a": 1.2})[k % 2],
            },
            "qoi": {} if k == 5 else {"T_fluid_out_K": 300.0 + k, "converged": True},
        }
        for k in range(9)
    ]
    about = {
        "parameters": {
            "boundary.left.gas.velocity": {"unit": "m/s"},
            "closures.nusselt": {"unit": None},
        },
        "qoi": {"T_fluid_out_K": {"unit": "K"}, "converged": {"unit": "1"}},
    }
    content = {
        "study": "sweep.toml",
        "cases": 9,
        "ended": 9,
        "failed": 1,
        "warnings": [],
        **about,
        "runs": runs,
    }
    (folder / "table.json").write_text(json.dumps(content))


def test_a_sweep_over_laws_shows_them(tmp_path):
    sweep(tmp_path)
    text = write([tmp_path]).read_text()
    found = {chart["kind"]: chart["data"][0] for chart in charts_of(text)}
    assert found["parallel"]["dimensions"][1]["ticktext"] == ["gunn", "power, a = 1.2"]
    assert len(found["matrix"]["dimensions"]) == 3 and len(found["matrix"]["text"]) == 8
    assert "<td>converged</td><td>the same in all runs: yes</td>" in text
    assert "8 of 9" not in text and "9 of 9 runs have ended, 1 of them failed" in text


USE = """<script>
const tick = (time) => new Promise((done) => setTimeout(done, time));
const wait = setInterval(async () => {
  if (document.body.dataset.ready === undefined) return;
  clearInterval(wait);
  const axes = document.getElementById("chart0"), panels = document.getElementById("chart1");
  const colours = () => [...axes.data[0].line.color];
  const marked = () => { const p = panels.data[0].selectedpoints; return p ? [...p] : null; };
  const told = { before: colours(), panels: panels.getBoundingClientRect().height };
  await Plotly.restyle(axes, { "dimensions[2].constraintrange": [[301.5, 304.5]] });
  await tick(200);
  told.brushed = marked();
  await Plotly.restyle(axes, { "dimensions[2].constraintrange": [[[299, 300.5], [306.5, 309]]] });
  await tick(200);
  told.twice = marked();
  const drag = panels.querySelectorAll(".nsewdrag");
  const box = drag[drag.length - 1].getBoundingClientRect();
  const mouse = (type, clientX, clientY, on) =>
    on.dispatchEvent(new MouseEvent(type, { clientX, clientY, bubbles: true, buttons: 1 }));
  mouse("mousedown", box.left + 1, box.top + 1, drag[drag.length - 1]);
  const cover = document.querySelector(".dragcover") || document;
  mouse("mousemove", box.left + 0.5 * box.width, box.top + 0.5 * box.height, cover);
  mouse("mousemove", box.right - 1, box.top + 0.5 * box.height, cover);
  await tick(200);
  mouse("mouseup", box.right - 1, box.top + 0.5 * box.height, cover);
  await tick(400);
  told.framed = marked();
  told.greyed = colours();
  told.free = axes.data[0].dimensions.every((d) => !d.constraintrange);
  panels.emit("plotly_deselect");
  await tick(200);
  told.after = colours();
  await Plotly.restyle(axes, { "dimensions[2].constraintrange": [[301.5, 304.5]] });
  await tick(200);
  await Plotly.restyle(axes, { "dimensions[2].constraintrange": [null] });
  await tick(200);
  told.none = marked();
  told.faults = faults;
  told.grey = axes.data[0].line.cmin;
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
def test_a_choice_is_linked_both_ways_in_a_browser(tmp_path):
    """What is chosen along an axis is marked in the panels; what is framed in a
    panel alone keeps its colour.
    """
    sweep(tmp_path)
    text = write([tmp_path], tmp_path / "report.html").read_text()
    (tmp_path / "tried.html").write_text(
        text.replace("<head>", "<head>" + WATCH).replace("</body>", USE + "</body>")
    )
    dom = browse(
        "--dump-dom", "--window-size=1280,1800", f"file://{tmp_path / 'tried.html'}"
    )
    told = json.loads(
        html.unescape(re.search(r'<pre id="told">(.*?)</pre>', dom, re.DOTALL)[1])
    )
    assert told["faults"] == []
    assert (
        told["before"]
        == told["after"]
        == [300.0, 301.0, 302.0, 303.0, 304.0, 306.0, 307.0, 308.0]
    )
    assert (
        told["brushed"] == [2, 3, 4]
        and told["twice"] == [0, 6, 7]
        and told["none"] is None
    )
    framed = told["framed"]
    assert framed and len(framed) < 8
    expected = [
        value if k in framed else told["grey"] for k, value in enumerate(told["before"])
    ]
    assert told["greyed"] == expected and told["free"]


@pytest.mark.slow
def test_report_of_derivatives(tmp_path):
    """The table holds what the command found, the largest relative derivative
    first, and its picture stands above it.
    """
    scene, keys = (
        load("studies/moving_bed_heater/heater.toml"),
        ["packed_bed.porosity", "solids.silica.diameter"],
    )
    found, about = sensitivities(scene, ["T_fluid_out_K", "pressure_drop_Pa"], keys)
    write_sensitivities(found, about, tmp_path, scene.title)
    text = write([tmp_path]).read_text(encoding="utf-8")
    shown = re.findall(r"<tr><td>([^<]+)</td><td>([^<]+)</td>", text)
    for i, name in enumerate(found.qoi):
        largest = sorted(
            zip(found.logarithmic[i], found.keys, strict=True),
            key=lambda pair: -abs(pair[0]),
        )
        rows = [key for result, key in shown if result == name]
        assert rows == [key for _, key in largest]
    assert 'alt="sensitivities" src="data:image/png;base64,' in text
    assert (
        f"<td class=number>{page.number(float(found.derivatives[1, 0]))}</td>" in text
        and "<td>Pa/m</td>" in text
    )


def test_damaged_derivatives_are_refused(tmp_path):
    (tmp_path / "sensitivities.json").write_text(
        '{"title": "", "qoi":', encoding="utf-8"
    )
    with pytest.raises(
        ContbedError,
        match=r"sensitivities\.json: not that of .*; run contbed sensitivities again",
    ):
        write([tmp_path])
