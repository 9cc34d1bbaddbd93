"""Pictures of fields over planes and through boxes, and one axis for each unit."""

from contextlib import contextmanager

import numpy as np
import pytest

from contbed import run
from contbed.bubbling_bed import plots as bubbling
from contbed.explain import editor
from contbed.loading import loads
from contbed.output import curves, maps
from contbed.output.plots import styled_figure
from contbed.output.progress import Progress


@pytest.fixture
def figures(monkeypatch):
    """The figures that modules draw, before they are saved."""
    found = []

    @contextmanager
    def kept(*arguments, **options):
        with styled_figure(*arguments, **options) as figure:
            yield figure
            found.append(figure)

    for module in (maps, curves):
        monkeypatch.setattr(module, "styled_figure", kept)
    return found


def test_a_slice_shows_the_middle_of_a_box(tmp_path, figures):
    """What is hot only near y = 0.05, its middle, is hot all over the picture; what
    is cold there is cold.
    """
    axis = np.linspace(0.0, 1.0, 11)
    points = np.array(np.meshgrid(axis, 0.1 * axis, 0.5 * axis, indexing="ij")).reshape(
        3, -1
    )
    hot = np.where(np.abs(points[1] - 0.05) < 0.035, 900.0, 300.0) + points[0]
    maps.slice_maps(
        tmp_path / "in.png", points, {"T_solid": hot, "T_fluid": 1200.0 - hot}, "bed"
    )
    solid, fluid = (
        axes.images[0].get_array() for axes in figures[0].axes if axes.images
    )
    assert solid.shape == (60, 120) and solid.min() > 899.9 and fluid.max() < 300.1
    # rises by 1 K along x
    assert solid[:, -1].mean() - solid[:, 0].mean() == pytest.approx(1.0, abs=0.1)
    labels = [(axes.get_xlabel(), axes.get_ylabel()) for axes in figures[0].axes[:2]]
    assert (
        labels == [("", "$z$ [m]"), ("$x$ [m]", "$z$ [m]")]
        and (tmp_path / "in.png").exists()
    )


def test_cells_are_drawn_where_they_are(tmp_path, figures):
    corners = np.array(
        [
            [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
            for y in range(2)
            for x in range(2)
        ],
        float,
    )
    values = np.array([300.0, 400.0, 500.0, 900.0])
    maps.cell_maps(tmp_path / "a.png", corners, {"T_gas": values}, ("x", "y"), "bed")
    (cells,) = figures[0].axes[0].collections
    assert np.array_equal(cells.get_array(), values)
    assert np.array_equal(cells.get_paths()[3].vertices[:4], corners[3])
    assert figures[0].axes[0].get_title() == r"$T_\mathrm{g}$ [K]"


@pytest.mark.slow
def test_two_fluids_show_their_fields(tmp_path):
    scene = loads(
        editor.template("two_fluid"),
        overrides={"time.end": "2 ms", "time.sample": "1 ms"},
    )
    run(scene, out=tmp_path / "plane")
    assert (tmp_path / "plane" / "fields.png").stat().st_size > 10_000


def test_bubbles_have_one_axis_for_each_unit(tmp_path, figures):
    z = np.linspace(0.0, 1.0, 5)
    columns = {
        "z [m]": z,
        "T_sand [K]": z + 900,
        "delta [1]": 0.2 * z,
        "d_b [m]": 0.1 + z,
        "u_b [m/s]": 1 + z,
    }
    bubbling.profiles_plot(tmp_path / "a.png", columns, "bed")
    labels = [axes.get_ylabel() for axes in figures[0].axes]
    assert [label for label in labels if label.startswith("bubbles: ")] == [
        r"bubbles: $d_\mathrm{b}$ [m]",
        r"bubbles: $\delta$",
        r"bubbles: $u_\mathrm{b}$ [m/s]",
    ]


@pytest.mark.slow
def test_a_bubbling_bed_reports_how_far_it_is(monkeypatch):
    """A reacting bed is begun by steps of growing size, of which the bar shows the
    powers of ten.
    """
    from pathlib import Path

    from contbed import load

    told = []
    monkeypatch.setattr(
        Progress,
        "advance_to",
        lambda bar, value, note="": told.append(value / bar.total),
    )
    run(
        load(
            Path(__file__).parents[2] / "studies" / "coal_boiler_design" / "boiler.toml"
        )
    )
    assert len(told) >= 5 and told == sorted(told) and told[0] < 0.3 and told[-1] > 0.8
