"""Signals over time and profiles at levels: known signals give known statistics,
mistakes are told with their line.
"""

import json

import numpy as np
import pytest
from pytest import approx

from contbed.many.validate import report
from contbed.many.validate.case import read_case
from contbed.many.validate.levels import at
from contbed.many.validate.levels import compare as compare_levels
from contbed.many.validate.score import Validated
from contbed.many.validate.signal import compare, resampled, spectrum, statistics
from contbed.result import Result
from tests.refusals import refused

SIGNAL = """\
title = "a bubbling bed"
source = "closed form"
licence = "none"
scene = "scene.toml"
quantity = "p"
uncertainty = "3 Pa"
compare = "signal"
[measured]
file = "measured.csv"
column = "p"
time = "t"
[signal]
column = "middle p [Pa]"
start = 2.0
report = ["height [m]"]
"""
LEVELS = """\
title = "a spouted bed"
source = "closed form"
licence = "none"
scene = "scene.toml"
quantity = "speed_solid"
uncertainty = "0.02 m/s"
compare = "levels"
[measured]
file = "measured.csv"
column = "v"
position = "x"
height = "z"
"""
FREQUENCY, AMPLITUDE = 2.0, 100.0  # Hz, Pa


def folder_of(tmp_path, case, measured):
    for name, text in (
        ("scene.toml", ""),
        ("case.toml", case),
        ("measured.csv", measured),
    ):
        (tmp_path / name).write_text(text)
    return read_case(str(tmp_path))


def wave(t, amplitude=AMPLITUDE, frequency=FREQUENCY):
    return amplitude * np.sin(2.0 * np.pi * frequency * t + 0.3)


@pytest.fixture
def signal(tmp_path):
    """A case with 3 s of a sine wave of 100 Pa and 2 Hz, at times that are not even."""
    t = np.sort(np.random.default_rng(4).uniform(3.0, 6.0, 400))
    rows = "\n".join(f"{a:.6f},{b:.6f}" for a, b in zip(t, wave(t), strict=True))
    return folder_of(tmp_path, SIGNAL, f"t [s],p [Pa]\n{rows}\n")


@pytest.fixture
def levels(tmp_path):
    """A case with points at two heights."""
    tmp_path = tmp_path / "levels"
    tmp_path.mkdir()
    rows = "\n".join(
        f"{z},{x},{1.0 + z / 100.0}" for z in (30, 90) for x in (10, 20, 40)
    )
    return folder_of(tmp_path, LEVELS, f"z [mm],x [mm],v [m/s]\n{rows}\n")


def run_with(t, **columns):
    result = Result(None)
    result.profiles = {"t [s]": t} | {
        name: np.asarray(column) for name, column in columns.items()
    }
    return result


def test_a_sine_has_its_deviation_its_crossings_and_its_peak():
    t = np.linspace(0.0, 3.0, 301)
    found = statistics(*resampled(t, 7.0 + wave(t)), 3.0)
    # 6 whole periods: the deviation is that of a sine, the peak is on a line of the
    # spectrum
    assert found.value[0] == approx(AMPLITUDE / np.sqrt(2.0), rel=5e-3)
    assert found.value[1] == approx(FREQUENCY, rel=1e-6)
    assert found.value[2] == approx(FREQUENCY, rel=5e-3)
    assert found.uncertainty[0] < 0.01 * AMPLITUDE
    assert found.uncertainty[2] == approx(1.0 / 3.0)


def test_the_spectrum_holds_the_variance():
    """Parseval: the power per frequency summed over all frequencies is the variance
    of the piece.
    """
    rng = np.random.default_rng(1)
    values = rng.normal(size=1001)
    frequency, power = spectrum(0.01, values, 10.0)
    assert np.sum(power) * frequency[0] == approx(values.var(), rel=1e-3)


def test_the_peak_of_a_long_run_has_the_resolution_of_the_measured_record():
    """In 10 s a peak is found to 0.1 Hz, in pieces of 3 s, as measured, to a third
    of 1 Hz.
    """
    t = np.linspace(0.0, 10.0, 1001)
    frequency, _ = spectrum(*resampled(t, wave(t)), 3.0)
    assert frequency[0] == approx(1.0 / 3.0, rel=5e-3)


def test_a_wave_of_half_the_amplitude_misses_half_of_the_deviation(signal):
    t = np.linspace(0.0, 12.0, 1201)
    result = run_with(
        t,
        **{
            "middle p [Pa]": 300.0 + wave(t, 0.5 * AMPLITUDE, 2.0 * FREQUENCY),
            "height [m]": 0.1 + 0 * t,
        },
    )
    found = compare(signal, result)
    deviation, crossings, peak = found.scores
    assert (deviation.unit, crossings.unit, peak.unit) == ("Pa", "Hz", "Hz")
    assert deviation.bias == approx(-0.5 * AMPLITUDE / np.sqrt(2.0), rel=0.02)
    assert deviation.data >= 3.0  # that of reading a point
    assert crossings.bias == approx(FREQUENCY, rel=0.05)
    assert peak.bias == approx(FREQUENCY, rel=0.05)
    assert not deviation.within
    assert not peak.within
    assert found.reported["mean of height [m]"] == approx(0.1)
    assert found.reported["mean of middle p [Pa]"] == approx(300.0, abs=1.0)


def test_what_is_before_the_start_does_not_count(signal):
    t = np.linspace(0.0, 12.0, 1201)
    start = np.where(t < 2.0, 1e5, wave(t))
    found = compare(signal, run_with(t, **{"middle p [Pa]": start, "height [m]": t}))
    assert [score.within for score in found.scores] == [True] * 3


def test_a_column_that_the_run_does_not_have(signal):
    refused(
        r"case.toml:12: signal: profiles.csv has no column 'middle p \[Pa\]'; it has t",
        lambda: compare(signal, run_with(np.linspace(0.0, 12.0, 1201))),
    )


def table_of(factor):
    x = np.linspace(0.0, 0.05, 6)
    result = Result(None)
    heights = (0.03, 0.09, 0.15)
    result.tables["levels"] = {
        "height [m]": np.repeat(heights, 6),
        "x [m]": np.tile(x, 3),
        "speed_solid [m/s]": np.repeat([factor * (1.0 + 10.0 * z) for z in heights], 6),
    }
    return result


def test_profiles_at_levels_have_their_offset(levels):
    """Predictions 1.2 times the measured ones: L1 of 0.2 at each height; heights
    without points are reported.
    """
    found = compare_levels(levels, table_of(1.2))
    assert [score.group for score in found.scores] == ["0.03 m", "0.09 m", "all"]
    assert found.scores[0].bias == approx(0.2 * 1.3)
    assert found.scores[1].rms == approx(0.2 * 1.9)
    for name in ("0.03 m", "0.09 m", "all"):
        assert found.reported[f"L1 of {name}"] == approx(0.2)
    assert found.reported["x [m]"] == [0.01, 0.02, 0.04]
    assert found.reported["speed_solid at 0.15 m [m/s]"] == approx([1.2 * 2.5] * 3)


def test_report_of_signals_and_levels(tmp_path, signal, levels):
    """Table, summary.json and picture take both kinds of comparison."""
    t = np.linspace(0.0, 12.0, 1201)
    run = run_with(t, **{"middle p [Pa]": wave(t), "height [m]": 0.1 + 0.0 * t})
    done = [
        Validated(signal, compare(signal, run), 1.0, run),
        Validated(levels, compare_levels(levels, table_of(1.2)), 1.0, table_of(1.2)),
    ]
    report.write(done, tmp_path)
    cases = json.loads((tmp_path / "summary.json").read_text())["cases"]
    scores = [one["scores"] for one in cases.values()]
    assert any(
        score["group"] == "peak of the spectrum" and score["within"] is True
        for group in scores
        for score in group
    )
    assert (tmp_path / "validation.png").stat().st_size > 10_000
    text = report.table(done)
    assert "rises through the mean" in text and "0.09 m" in text and "Hz" in text


def test_a_level_that_the_run_does_not_have(levels):
    refused(
        r"case.toml:4: output.levels of scene.toml: no profile of speed_solid at "
        r"0.5 m",
        lambda: at(levels, table_of(1.0), 0.5, np.array([0.01])),
    )


@pytest.mark.parametrize(
    ("case", "old", "words"),
    [
        (
            SIGNAL,
            'time = "t"\n',
            r'case.toml:8: measured.time: missing; compare = "signal" needs it',
        ),
        (
            SIGNAL,
            SIGNAL[SIGNAL.index("[signal]") :],
            r'case.toml:8: signal: missing; compare = "signal" needs it',
        ),
        (
            LEVELS,
            'height = "z"\n',
            r'case.toml:8: measured.height: missing; compare = "levels" needs it',
        ),
    ],
)
def test_what_a_comparison_needs(tmp_path, case, old, words):
    refused(
        words, lambda: folder_of(tmp_path, case.replace(old, ""), "t [s],p [Pa]\n1,2\n")
    )


def test_the_measured_pressure_of_van_wachem_has_its_published_statistics():
    """82 Pa, 2.01 Hz, and 8 rises in 2.98 s, one of which reaches 0.1 Pa above the
    mean and may be lost in sampling.
    """
    points = read_case("van_wachem_2001").points
    found = statistics(*resampled(points.t, points.value), points.t[-1] - points.t[0])
    deviation, crossings, peak = found.value
    assert (deviation, peak) == approx((82.0, 2.01), rel=0.02)
    assert 7 <= round(crossings * 2.983) <= 8
