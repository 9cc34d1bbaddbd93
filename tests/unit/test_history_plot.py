"""The picture of what leaves a bed: one panel a unit, no curve of what does not
change, no file without a curve.
"""

import matplotlib.figure
import numpy as np

from contbed.output.curves import history_plot, over_times

T = np.linspace(0.0, 10.0, 20)


def test_one_panel_a_unit_without_constant_curves(tmp_path, monkeypatch):
    seen = {}
    keep = matplotlib.figure.Figure.savefig

    def savefig(figure, *arguments, **options):
        for axes in figure.axes:
            seen[axes.get_ylabel()] = [
                text.get_text() for text in axes.get_legend().get_texts()
            ]
        keep(figure, *arguments, **options)

    monkeypatch.setattr(matplotlib.figure.Figure, "savefig", savefig)
    x = T / 100.0
    columns = {
        "t [s]": T,
        "T_fluid [K]": 300.0 + T,
        "x_A [1]": x,
        "x_B [1]": 1.0 - x,
        "x_C [1]": np.zeros(20),
    }
    history_plot(
        tmp_path / "outlet.png", columns | {"T_solid [K]": np.full(20, np.nan)}
    )
    assert seen == {"$T$ [K]": ["T_fluid"], "mole fraction [1]": ["x_A", "x_B"]}
    assert (tmp_path / "outlet.png").stat().st_size > 5_000


def test_nothing_that_changes_gives_no_picture(tmp_path):
    history_plot(
        tmp_path / "outlet.png", {"t [s]": T, "T_fluid [K]": np.full(20, 300.0)}
    )
    assert not list(tmp_path.iterdir())


def test_times_from_an_hour_on_are_in_hours():
    x, t = np.array([0.0, 1.0] * 3), np.repeat([0.0, 1800.0, 21600.0], 2)
    assert [curve.name for curve in over_times(x, x, t)] == ["0 s", "1800 s", "6 h"]
    assert [curve.name for curve in over_times(x, x, t, "bed")][2] == "bed, 6 h"
