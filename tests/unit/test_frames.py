"""A result in Python: as xarray and pandas with units, as a table of a notebook, as
a figure.
"""

import numpy as np
import pytest
from small_scenes import STEADY

import contbed as cb
from contbed.errors import ContbedError

TRANSIENT = (
    STEADY
    + "[time]\nend = 100.0\ntimes = [20.0, 50.0]\n[initial]\ntemperature = 350.0\n"
)


@pytest.fixture(scope="module")
def steady():
    from contbed.loading import loads

    return cb.run(loads(STEADY))


@pytest.fixture(scope="module")
def transient():
    from contbed.loading import loads

    return cb.run(loads(TRANSIENT))


def test_xarray_has_coordinates_and_units(steady, transient):
    pytest.importorskip(
        "xarray", reason="xarray is not installed: pip install 'contbed[notebook]'"
    )
    found = steady.to_xarray()
    assert (
        found.T_solid.dims == ("x",)
        and found.T_solid.attrs["units"] == "K"
        and found.x.attrs["units"] == "m"
    )
    assert np.array_equal(
        found.T_solid.values, np.asarray(steady.profiles["T_solid [K]"])
    )
    several = transient.to_xarray()
    assert several.T_solid.dims == ("t", "x") and list(several.t.values) == [
        20.0,
        50.0,
        100.0,
    ]
    rows = np.asarray(transient.profiles["t [s]"]) == 50.0
    assert np.array_equal(
        several.T_solid.sel(t=50.0).values,
        np.asarray(transient.profiles["T_solid [K]"])[rows],
    )
    fields = steady.to_xarray("fields")
    space, values = steady.nodal["T_solid"]
    assert np.array_equal(fields.T_solid.values, values)
    assert np.array_equal(fields.coords[f"x_{space.size}"].values, space.points[0])


def test_pandas_has_headers_with_units(steady):
    pytest.importorskip(
        "pandas", reason="pandas is not installed: pip install 'contbed[notebook]'"
    )
    assert list(steady.to_pandas().columns) == list(steady.profiles)
    results = steady.to_pandas("results")
    assert results.loc["T_fluid_out_K", "value"] == steady.qoi["T_fluid_out_K"]
    assert results.loc["T_fluid_out_K", "unit"] == "K"
    with pytest.raises(ContbedError, match="no table 'axial'; it has: profiles"):
        steady.to_pandas("axial")


def test_a_notebook_shows_the_results(steady):
    text = steady._repr_html_()
    assert (
        f"{steady.qoi['T_fluid_out_K']:.6g}" in text
        and "closes to" in text
        and "<table>" in text
        and "data:image/png;base64," in text
    )
    steady.profiles, kept = {}, steady.profiles
    assert "<img" not in steady._repr_html_()
    steady.profiles = kept


def test_figures_have_a_panel_for_each_unit(steady, transient):
    figure = steady.plot("T_fluid", "T_solid", "p")
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["[K]", "p [Pa]"] and figure.axes[-1].get_xlabel() == "x [m]"
    assert len(transient.plot("T_solid").axes[0].lines) == 3
    with pytest.raises(ContbedError, match="profiles has no column 'T'"):
        steady.plot("T")
