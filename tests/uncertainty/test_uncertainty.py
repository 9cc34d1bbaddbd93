"""Indices with known answers, propagation that is exact where results are linear,
and the files of a sweep.
"""

import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from contbed.errors import ContbedError
from contbed.many import value_sets
from contbed.many.distributions import Distribution
from contbed.many.sweep.study import read_study
from contbed.many.uncertainty.indices import indices
from contbed.many.uncertainty.polynomial_chaos import (
    chaos_indices,
    chaos_spread,
    expansion,
)
from contbed.many.uncertainty.propagate import first_order, independent, of_sample
from contbed.many.value_sets import sample
from tests.cases import each_case
from tests.command_line import command
from tests.numbers_of import table_of
from tests.refusals import refused

SCENE = """\
mesh = { type = "line", length = 2, cells = 4 }
gas = { density = 1.2, heat_capacity = 1000.0, conductivity = 0.03, viscosity = 2e-5 }
solids.particles = { density = 2000.0, heat_capacity = 900.0, conductivity = 1.0, diameter = "3 mm" }
packed_bed = { porosity = 0.4 }
closures = { nusselt = 2.0 }
heat = {}
boundary.left.gas = { velocity = 0.1, temperature = 300 }
output = { plots = false, fields = false, profiles = false }
"""
STUDY = """\
scene = "scene.toml"
qoi = ["pressure_drop_Pa"]
[sample]
method = "sobol_indices"
count = 8
seed = 1
gradients = true
[sample.parameters]
gas.viscosity = { mean = 2e-5, deviation = 2e-6 }
gas.density = { from = 1.0, to = 1.4 }
gas.conductivity = { from = 0.02, to = 0.04 }
"""


def drop(viscosity, density):
    """Ergun's equation, linear in both."""
    share = 0.6 / 0.4**3
    return 2.0 * (
        150.0 * viscosity * share * 0.6 * 0.1 / 3e-3**2
        + 1.75 * density * share * 0.1**2 / 3e-3
    )


def ishigami(u):
    """Ishigami & Homma's function with a = 7 and b = 0.1 of points in the unit cube."""
    x = np.pi * (2.0 * u - 1.0)
    return (
        np.sin(x[:, 0])
        + 7.0 * np.sin(x[:, 1]) ** 2
        + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])
    )


VARIANCE = 49.0 / 8.0 + 0.1 * np.pi**4 / 5.0 + 0.01 * np.pi**8 / 18.0 + 0.5
ALONE = np.array([0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2, 49.0 / 8.0, 0.0]) / VARIANCE
TOTAL = ALONE + 0.01 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0) / VARIANCE * np.array(
    [1.0, 0.0, 1.0]
)


@pytest.mark.parametrize("method", ["sobol_indices", "morris"])
def test_half_widths_are_the_same_each_time(method):
    pytest.importorskip("SALib")
    points = value_sets.sample(method, 16, seed=2, dimensions=3)
    first, second = (
        indices(method, points, ishigami(points)).columns for _ in range(2)
    )
    for name, values in first.items():
        assert_array_equal(values, second[name])


def test_sobol_indices_of_ishigami_are_the_exact_ones():
    pytest.importorskip("SALib")
    points = value_sets.sample("sobol_indices", 4096, seed=2, dimensions=3)
    found = indices("sobol_indices", points, ishigami(points))
    # 4096 groups: half widths at 90 % are below 0.03, errors of scrambled points below
    # half of that
    assert_allclose(found.columns["first order"], ALONE, atol=0.015)
    assert_allclose(found.columns["total"], TOTAL, atol=0.015)
    assert np.all(found.columns["first order +-"] < 0.04) and found.groups == 4096
    spread = of_sample(ishigami(points)[independent("sobol_indices", points)])
    assert_allclose(
        [spread.mean, spread.deviation], [3.5, np.sqrt(VARIANCE)], rtol=0.02
    )
    assert spread.runs == 2 * 4096


def test_morris_effects_of_a_linear_model_are_its_slopes():
    pytest.importorskip("SALib")
    points = value_sets.sample("morris", 10, seed=2, dimensions=3)
    found = indices("morris", points, points @ np.array([3.0, -2.0, 0.0]))
    assert_allclose(found.columns["mean effect"], [3.0, -2.0, 0.0], atol=1e-12)
    assert_allclose(found.columns["mean magnitude"], [3.0, 2.0, 0.0], atol=1e-12)
    assert_allclose(found.columns["scatter"], 0.0, atol=1e-12)


@pytest.mark.parametrize("method", ["sobol_indices", "morris"])
@pytest.mark.parametrize("unit", [-1000, -600, 600, 1000], ids=str)
def test_indices_do_not_depend_on_the_size_of_a_result(method, unit):
    """Powers of 2 change no digit; the squares of the results are no numbers of a
    computer.
    """
    points = sample(method, 16, seed=1, dimensions=2)
    values = points[:, 0] + 2.0 * points[:, 0] * points[:, 1]
    one, other = (
        indices(method, points, values),
        indices(method, points, np.ldexp(values, unit)),
    )
    for name, column in one.columns.items():
        scaled = np.ldexp(column, unit) if method == "morris" else column
        assert_array_equal(other.columns[name], scaled)


@pytest.mark.parametrize("method", ["sobol_indices", "morris"])
def test_what_varies_by_rounding_alone_has_no_indices(method):
    points = sample(method, 16, seed=1, dimensions=2)
    assert indices(method, points, 300.0 + 1e-12 * points[:, 0]) is None
    assert indices(method, points, np.zeros(len(points))) is None
    flat = [Distribution(0.0, 1.0, even=True)] * 2
    assert (
        expansion(
            sample("sobol", 64, 1, 2),
            300.0 + 1e-12 * sample("sobol", 64, 1, 2)[:, 0],
            flat,
        )
        is None
    )


@pytest.mark.parametrize("method", ["sobol", "latin_hypercube", "morris"])
def test_whole_numbers_are_sampled_evenly(folder, method):
    head = STUDY.split("gradients")[0].replace('"sobol_indices"', f'"{method}"')
    (folder / "study.toml").write_text(
        f"{head}[sample.parameters]\nmesh.cells = {{ from = 4, to = 7, integer = true "
        f"}}\n"
    )
    study = read_study(folder / "study.toml")
    cells = [case.parameters["mesh.cells"] for case in study.cases]
    assert all(isinstance(each, int) for each in cells) and set(cells) <= {4, 5, 6, 7}
    spread = study.sample.distributions["mesh.cells"]
    drawn = spread((np.arange(400) + 0.5) / 400)
    assert [int((drawn == k).sum()) for k in range(3, 9)] == [0, 100, 100, 100, 100, 0]
    assert (spread.mean, spread.deviation) == (5.5, pytest.approx(float(np.std(drawn))))
    assert spread(np.array([0.0, 1.0])).tolist() == [4.0, 7.0]


@pytest.mark.parametrize(
    ("entry", "told"),
    [
        ("{ from = 4.5, to = 7, integer = true }", "give integers"),
        ("{ from = 7, to = 4, integer = true }", "the lower end first"),
        (
            "{ from = 4, to = 7, integer = 1 }",
            "integer = 1: wrong kind of value; allowed: true or false",
        ),
        ("{ mean = 4, deviation = 1, integer = true }", "integer = true: unknown key"),
    ],
)
def test_mistakes_in_whole_numbers_are_told(folder, entry, told):
    head = STUDY.split("gradients")[0].replace('"sobol_indices"', '"sobol"')
    (folder / "study.toml").write_text(
        f"{head}[sample.parameters]\nmesh.cells = {entry}\n"
    )
    refused(told, lambda: read_study(folder / "study.toml"))


def test_groups_with_a_failed_run_are_left_out():
    pytest.importorskip("SALib")
    points = value_sets.sample("sobol_indices", 64, seed=2, dimensions=3)
    values = ishigami(points)
    whole = indices("sobol_indices", points[5:], values[5:])
    values[2] = np.nan
    found = indices("sobol_indices", points, values)
    assert found.groups == 63
    assert_array_equal(found.columns["total"], whole.columns["total"])
    assert (
        indices("sobol_indices", points, np.where(np.arange(320) < 310, np.nan, values))
        is None
    )
    # shares of a variance of nothing
    assert indices("sobol_indices", points, np.ones(320)) is None


def test_samples_of_groups_are_their_independent_points():
    rows = independent("sobol_indices", np.zeros((10, 3)))
    assert np.flatnonzero(rows).tolist() == [0, 4, 5, 9]
    assert (
        independent("sobol", np.zeros((4, 3))).all()
        and not independent("morris", np.zeros((4, 3))).any()
    )


def test_first_order_is_exact_where_the_result_is_linear():
    spreads = {
        "a": Distribution(1.0, 1.2, even=False),
        "b": Distribution(-2.0, 4.0, even=True),
        "c": Distribution(2.0, 3.0, even=False, logarithmic=True),
    }
    slopes = np.array([3.0, -1.0, 0.5])
    value = float(slopes @ [spread.mean for spread in spreads.values()])
    found = first_order(value, slopes, spreads, 1)
    variance = (3.0 * 0.2) ** 2 + 6.0**2 / 12.0 + (0.5 * spreads["c"].deviation) ** 2
    assert_allclose(found.deviation, np.sqrt(variance), rtol=1e-14)
    u = value_sets.sample("sobol", 2**14, seed=1, dimensions=3)
    values = (
        np.column_stack([spread(u[:, k]) for k, spread in enumerate(spreads.values())])
        @ slopes
    )
    # Sobol points: far below the 1/root(n) of independent ones
    assert_allclose(
        [found.mean, found.deviation], [values.mean(), values.std()], rtol=1e-3
    )


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path


def test_a_sweep_writes_samples_gradients_and_indices_side_by_side(
    folder, capsys, monkeypatch
):
    pytest.importorskip("SALib")
    assert command("sweep study.toml --out out --jobs 1 --quiet") == 0
    out = capsys.readouterr().out
    assert "40 of 40 runs are finished" in out and "share by gradients" in out
    samples, gradients = table_of(folder / "out" / "uncertainty.csv")
    assert (samples["estimator"], samples["runs"], gradients["estimator"]) == (
        "samples",
        "16",
        "gradients",
    )
    parts = np.array([drop(2e-6, 0.0), drop(0.0, 0.4 / np.sqrt(12.0)), 0.0])
    # the derivative is exact to 1e-6, CSV holds nine digits
    assert_allclose(float(gradients["mean"]), drop(2e-5, 1.2), rtol=1e-6)
    assert_allclose(
        float(gradients["standard deviation"]), np.linalg.norm(parts), rtol=1e-6
    )
    # 16 points
    assert_allclose(float(samples["mean"]), drop(2e-5, 1.2), rtol=0.03)
    assert_allclose(
        float(samples["standard deviation"]), np.linalg.norm(parts), rtol=0.3
    )
    rows = table_of(folder / "out" / "indices.csv")
    exact = parts**2 / np.sum(parts**2)
    assert_allclose(
        [float(row["share by gradients"]) for row in rows], exact, atol=1e-6
    )
    for row, share in zip(rows, exact, strict=True):
        assert (
            abs(float(row["first order"]) - share)
            <= 2.0 * float(row["first order +-"]) + 1e-6
        )
        assert abs(float(row["total"]) - share) <= 2.0 * float(row["total +-"]) + 1e-6
    assert (folder / "out" / "uncertainty.png").exists()
    # what is known is not computed again
    monkeypatch.setattr("contbed.many.uncertainty.write.gradient", None)
    assert command("sweep study.toml --out out --jobs 1 --quiet") == 0
    assert "40 were before" in capsys.readouterr().out
    pytest.importorskip(
        "plotly", reason="plotly is not installed: pip install 'contbed[report]'"
    )
    assert command("report out") == 0
    report = (folder / "out" / "report.html").read_text()
    assert "share by gradients" in report and "standard error of the mean" in report


def test_a_morris_design_of_normal_parameters_stays_within_their_tails(folder, capsys):
    pytest.importorskip("SALib")
    text = STUDY.replace('"sobol_indices"', '"morris"').replace(
        "count = 8", "count = 4"
    )
    (folder / "study.toml").write_text(text)
    assert command("sweep study.toml --out out --jobs 1 --quiet") == 0
    rows = table_of(folder / "out" / "indices.csv")
    # levels are 0.05, 0.35, 0.65 and 0.95 of the normal, 1.0 to 1.4 of the even one
    assert_allclose(float(rows[1]["mean effect"]), drop(0.0, 0.4), rtol=1e-6)
    assert float(rows[2]["mean magnitude"]) == 0.0
    values = {
        float(row["gas.viscosity [Pa*s]"])
        for row in table_of(folder / "out" / "table.csv")
    }
    assert max(values) <= 2e-5 + 1.6449 * 2e-6 and len(values) <= 4


EVEN, NORMAL = Distribution(2.0, 6.0, even=True), Distribution(10.0, 11.0, even=False)
LOG_NORMAL = Distribution(1.0, 1.5, even=False, logarithmic=True)


def test_polynomials_of_the_parameters_are_found_exactly():
    """3 + x y + y^2 - 2 log z of x even, y normal and log z normal: moments by hand,
    to the rounding of 64 runs.
    """
    spreads = [EVEN, NORMAL, LOG_NORMAL]
    points = value_sets.sample("sobol", 64, seed=3, dimensions=3)
    x, y, z = (spread(points[:, k]) for k, spread in enumerate(spreads))
    found = expansion(points, 3.0 + x * y + y**2 - 2.0 * np.log(z), spreads)
    # x = 4 + 2 u, y = 10 + v: x y + y^2 = 140 + 20 u + 24 v + 2 u v + v^2, with the
    # variances 1/3 of u and 1 of v
    parts = np.array([400.0 / 3.0, 24.0**2 + 2.0, (2.0 * np.log(1.5)) ** 2])
    variance, both = parts.sum() + 4.0 / 3.0, 4.0 / 3.0 * np.array([1.0, 1.0, 0.0])
    spread = chaos_spread(found)
    assert_allclose([spread.mean, spread.deviation**2], [144.0, variance], rtol=1e-10)
    columns = chaos_indices(found).columns
    assert_allclose(columns["first order"], parts / variance, atol=1e-10)
    assert_allclose(columns["total"], (parts + both) / variance, atol=1e-10)
    assert (
        max(columns["total +-"].max(), columns["first order +-"].max()) < 1e-8
        and found.unexplained < 1e-15
    )
    # the band of a result that is even, of 4096 points
    line = chaos_spread(expansion(points, x, spreads))
    assert_allclose([line.low, line.high], [2.2, 5.8], rtol=2e-3)


def test_bands_of_polynomial_chaos_hold():
    """Ishigami's function with 96 and 128 runs of 40 seeds: few terms short of exact,
    and the bands say so.

    They should hold 90 % of the indices; 480 of them, of which those of a seed go
    together, scatter by some percent.
    """
    spreads, held, used = [Distribution(-np.pi, np.pi, even=True)] * 3, [], 0
    for seed in range(40):
        points = value_sets.sample("latin_hypercube", 96 if seed % 2 else 128, seed, 3)
        found = expansion(points, ishigami(points), spreads)
        used += found is not None
        if found is not None:
            columns = chaos_indices(found).columns
            for name, exact in (("first order", ALONE), ("total", TOTAL)):
                held += list(np.abs(columns[name] - exact) <= columns[f"{name} +-"])
                assert np.abs(columns[name] - exact).max() < 0.15
    assert used >= 36 and np.mean(held) >= 0.8


def test_what_no_polynomial_explains_is_told():
    """Noise of 4 % of the variance: about as much is missed at left-out runs,
    however many terms would fit it.
    """
    random, spreads = np.random.default_rng(1), [EVEN, NORMAL]
    for seed in range(5):
        points = value_sets.sample("latin_hypercube", 200, seed, 2)
        values = EVEN(points[:, 0]) / EVEN.deviation + np.sqrt(
            0.04 / 0.96
        ) * random.standard_normal(200)
        assert 0.03 < expansion(points, values, spreads).unexplained < 0.06


def test_without_a_polynomial_there_is_none():
    random, spreads = np.random.default_rng(1), [EVEN, NORMAL]
    points = value_sets.sample("latin_hypercube", 60, seed=1, dimensions=2)
    noise = random.standard_normal(60)
    # nothing of it is explained at left-out runs
    assert expansion(points, noise, spreads) is None
    assert expansion(points, np.ones(60), spreads) is None
    assert expansion(points[:9], points[:9, 0], spreads) is None
    some = np.where(np.arange(60) % 7 == 3, np.nan, points[:, 0])
    assert expansion(points, some, spreads).runs == 51


@pytest.mark.parametrize("unit", [2.0**-700, 2.0**700])
def test_results_whose_squares_are_no_numbers_have_the_same_spread(unit):
    """Mole fractions of what has reacted: a power of 2 changes no digit but those of
    the band.
    """
    spreads = [EVEN, NORMAL]
    points = value_sets.sample("latin_hypercube", 60, seed=1, dimensions=2)
    values = EVEN(points[:, 0]) + NORMAL(points[:, 1])
    found, small = (
        expansion(points, values, spreads),
        expansion(points, unit * values, spreads),
    )
    for each, other in (
        (chaos_spread(found), chaos_spread(small)),
        (of_sample(values), of_sample(unit * values)),
    ):
        assert other.mean == pytest.approx(unit * each.mean, rel=1e-12)
        assert other.deviation == pytest.approx(unit * each.deviation, rel=1e-12)
    for name, column in chaos_indices(found).columns.items():
        assert_array_equal(chaos_indices(small).columns[name], column)


def test_a_sample_has_indices_by_polynomial_chaos(folder, capsys):
    text = STUDY.replace('"sobol_indices"', '"sobol"').replace(
        "count = 8", "count = 32"
    )
    (folder / "study.toml").write_text(text)
    assert command("sweep study.toml --out out --jobs 1 --quiet") == 0
    assert "by polynomial chaos (32 runs)" in capsys.readouterr().out
    rows = {
        row["estimator"]: row for row in table_of(folder / "out" / "uncertainty.csv")
    }
    parts = np.array([drop(2e-6, 0.0), drop(0.0, 0.4 / np.sqrt(12.0)), 0.0])
    # the result is linear, CSV holds nine digits
    found = rows["polynomial chaos"]
    assert_allclose(float(found["mean"]), drop(2e-5, 1.2), rtol=1e-8)
    assert_allclose(
        float(found["standard deviation"]), np.linalg.norm(parts), rtol=1e-8
    )
    shares = [float(row["total"]) for row in table_of(folder / "out" / "indices.csv")]
    assert_allclose(shares, parts**2 / np.sum(parts**2), atol=1e-8)


@each_case(__file__, "mistakes_in_a_design_of_indices_are_told")
def test_mistakes_in_a_design_of_indices_are_told(folder, capsys, old, new, told):
    pytest.importorskip("SALib")
    (folder / "study.toml").write_text(STUDY.replace(old, new))
    command("sweep study.toml --out out --jobs 1 --quiet")
    assert told in capsys.readouterr().err


def test_without_salib_indices_are_refused_before_any_run(monkeypatch):
    monkeypatch.setitem(sys.modules, "SALib.sample", None)
    with pytest.raises(
        ContbedError, match=r"needs SALib: pip install 'contbed\[calibrate\]'"
    ):
        value_sets.sample("sobol_indices", 4, seed=1, dimensions=2)
