"""From packings to a bed: what the parts of the band are, that nothing is computed
twice, mistakes in the file.
"""

import csv
import json
from statistics import NormalDist
from unittest.mock import Mock

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from pytest import approx

from contbed.cli import main
from contbed.closures.binding import bind
from contbed.dem import extract
from contbed.errors import ContbedError
from contbed.loading import load
from contbed.many.cascade import band, measured, particles
from contbed.many.cascade.run import cascade
from contbed.many.derivatives.gradients import gradient
from contbed.many.validate.case import read_case
from contbed.materials import gas_mixture
from contbed.runner import run
from contbed.scene.tables import ClosureFile
from tests.cases import each_case
from tests.command_line import command
from tests.numbers_of import table_of
from tests.refusals import refusal, refused
from tests.report.report_file import charts_of

SCENE = """
mesh = { type = "line", length = 0.05 }
gas = { density = 1.2, heat_capacity = 1005, conductivity = 0.026, viscosity = 1.8e-5 }
solids.pebbles = { density = 2500, heat_capacity = 840, conductivity = 0.84, diameter = "10 mm" }
packed_bed = { porosity = 0.4 }
closures = { nusselt = "wakao_kaguei", conductivity_solids = "zehner_schluender", conductivity_gas = 0.0 }
heat = {}
boundary.left.gas = { velocity = 0.3, temperature = 300.0 }
boundary.right.solids.pebbles = { velocity = 1.7e-4, temperature = 500.0 }
"""
FILE = """
scene = "bed.toml"
qoi = ["T_fluid_out_K"]
samples = 8
packings = { count = 2, particles = 300, width = 5 }
laws = { conduction = ["cones", "columns"], exchange = [{ name = "power", a = 1.2, b = 0.5 }, "gunn"] }
uncertain = { solids.pebbles.conductivity = "5 %" }
"""
NAME = "T_fluid_out_K"


def written(folder, text=FILE, scene=SCENE):
    (folder / "bed.toml").write_text(scene)
    (folder / "cascade.toml").write_text(text)
    return folder / "cascade.toml"


@pytest.fixture(scope="module", autouse=True)
def few_runs():
    """Three samples for the part of the fit, which is small: what is tested here
    does not depend on their number.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(band, "FIT_SAMPLES", 3)
        yield


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cascade")
    return cascade(written(folder), folder / "out")


def with_closures(found, **changes):
    """The bed with the closures that the cascade wrote for users."""
    files = {"conductivity_solids": "conductivity", "nusselt": "nusselt"}
    closures = {
        f"closures.{key}": {"file": str(found.folder / f"{name}.toml")}
        for key, name in files.items()
    }
    values = {
        **closures,
        "packed_bed.porosity": float(found.porosities.mean()),
        **changes,
    }
    return load(found.cascade.scene_file, values)


@pytest.mark.slow
def test_closures_that_are_written_give_the_result(found):
    result = run(with_closures(found))
    assert result.qoi[NAME] == found.base[NAME]
    used = {closure["name"]: closure for closure in result.closures}
    ours = [closure for name, closure in used.items() if name.endswith(".toml")]
    assert len(ours) == 2
    assert all(closure["share_outside"] == 0.0 for closure in ours)


def test_range_is_that_of_the_bed(found):
    """Constant properties have one k_solid/k_fluid, one Pr and one Re, which the
    fits surround.
    """
    expected = {
        "k_solid/k_fluid": 0.84 / 0.026,
        "Pr": 1005 * 1.8e-5 / 0.026,
        "Re": 1.2 * 0.3 * 1e-2 / 1.8e-5,
    }
    for name, value in expected.items():
        # the solids move as well: Re is that of the slip, 3e-3 more
        assert found.ranges[name] == approx(
            (value, value), rel=5e-3 if name == "Re" else 1e-12
        )


def test_part_of_a_number_is_its_derivative(found):
    """Half the difference of two runs is |d qoi/d key| times the standard
    uncertainty, up to its third order.
    """
    part = next(
        part for part in found.parts if part.name == "solids.pebbles.conductivity"
    )
    slope = gradient(
        with_closures(found), [NAME], ["solids.pebbles.conductivity"]
    ).derivatives[0, 0]
    assert part.deviation[NAME] == approx(abs(slope) * 0.05 * 0.84, rel=2e-2)


def test_part_of_the_laws_is_their_scatter(found):
    """Two laws, equally probable, deviate by half of their difference; Gunn's at
    every particle is far from a power.
    """
    parts = {part.name: part.deviation[NAME] for part in found.parts}
    # studies/closure_transfer: 21 K between both laws in such a bed
    assert parts["law of exchange"] > 5.0
    assert parts["law of exchange"] > 20.0 * max(
        parts["law of conduction"], parts["packing"], parts["fit"]
    )
    assert sum(found.shares(NAME).values()) == approx(1.0)
    low, high = found.band(NAME)
    assert high - low == approx(2.0 * parts["law of exchange"], rel=0.1)


RESTING = """
mesh = { type = "line", length = 0.05, cells = 12 }
gas = { density = 1.2, heat_capacity = 1005, conductivity = 0.026, viscosity = 1.8e-5 }
solids.pebbles = { density = 2500, heat_capacity = 840, conductivity = 0.84, diameter = "10 mm" }
packed_bed = { porosity = 0.4 }
closures = { nusselt = 2.0, conductivity_solids = "zehner_schluender", conductivity_gas = 0.0 }
heat = {}
boundary.left.solids.pebbles.fixed_temperature = 400.0
"""
SCATTER = """
scene = "bed.toml"
qoi = ["heat_left_W"]
samples = 100
packings = { count = 2, particles = 300, width = 5 }
laws = { conduction = ["cones"], scatter_conduction = "20 %" }
"""


@pytest.mark.slow
def test_scatter_of_measured_beds_multiplies_the_law(tmp_path):
    """Heat through a bed at rest is proportional to its conductivity, so that it
    scatters as that does.
    """
    done = cascade(
        written(
            tmp_path,
            SCATTER,
            RESTING + "boundary.right.solids.pebbles.fixed_temperature = 300.0\n",
        ),
        tmp_path / "out",
    )
    parts = {part.name: part.deviation["heat_left_W"] for part in done.parts}
    best = done.base["heat_left_W"]
    assert parts["scatter of conduction"] == approx(best * np.sinh(0.2), rel=1e-9)
    factors = np.array(done.drawn["laws.scatter_conduction"])
    scale = done.samples["heat_left_W"] / factors  # what is left is packing and fit
    assert scale.std() == approx(np.hypot(parts["packing"], parts["fit"]), rel=0.5)
    assert scale.std() < 0.02 * best
    # three standard errors of 100 draws
    assert np.log(factors).std() == approx(0.2, rel=0.22)
    low, high = done.band("heat_left_W")
    assert np.log(high / low) == approx(2 * NormalDist().inv_cdf(0.95) * 0.2, rel=0.3)


def test_scatter_multiplies_both_forms_of_closures():
    Re = np.geomspace(1.0, 100.0, 5)
    power = extract.fit_power(Re, np.full(5, 0.7), 2.0 + 1.1 * Re**0.6)
    at = {"Re": 30.0, "Pr": 0.7, "eps": 0.4}
    assert power.times(1.7).closure()(**at) == approx(
        1.7 * power.closure()(**at), rel=1e-14
    )
    columns = {extract.RATIO: Re, "eps": np.full(5, 0.4)}
    fit = extract.fit_log_polynomial(
        "conductivity", columns, Re**0.7, {extract.RATIO: "log"}, (2,)
    )
    there = {"k_fluid": 0.03, "k_solid": 0.9, "eps": 0.4}
    assert fit.times(1.7).closure()(**there) == approx(
        1.7 * fit.closure()(**there), rel=1e-14
    )


def test_second_command_computes_nothing(found, monkeypatch):
    monkeypatch.setattr(particles, "pack", None)
    monkeypatch.setattr(particles, "bed_nusselt", None)
    again = cascade(found.cascade.path, found.folder)
    assert again.before == again.runs == found.runs
    assert_array_equal(again.samples[NAME], found.samples[NAME])


@pytest.mark.slow
def test_interrupted_cascade_goes_on(found, tmp_path, monkeypatch):
    """Ctrl-C in a packing, in a point of one and in a run: the same command ends
    with the same numbers.
    """
    path = written(tmp_path)
    for module, name, when in (
        (particles, "pack", 2),
        (particles, "bed_nusselt", 7),
        (band, "compute", 9),
    ):
        left, function = [when], getattr(module, name)

        def stopped(*arguments, left=left, function=function, **options):
            left[0] -= 1
            if not left[0]:
                raise KeyboardInterrupt
            return function(*arguments, **options)

        with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
            patch.setattr(module, name, stopped)
            cascade(path, tmp_path / "out")
    damaged = next((tmp_path / "out/particles/packings").glob("*.npz"))
    damaged.write_bytes(damaged.read_bytes()[:100])
    done = cascade(path, tmp_path / "out")
    # scenes name their closure files by absolute path, so the folder must not matter to
    # the numbers
    assert_array_equal(done.samples[NAME], found.samples[NAME])
    assert done.base == found.base


def test_files(found, capsys):
    assert main(["cascade", str(found.cascade.path), "--out", str(found.folder)]) == 0
    text = capsys.readouterr().out
    assert text.startswith(f"{NAME}: {found.base[NAME]:.6g} K, 90% between")
    assert "law of exchange: standard deviation" in text
    summary = json.loads((found.folder / "summary.json").read_text())
    assert summary["band"][NAME]["low"] == found.band(NAME)[0]
    rows = table_of(found.folder / "table.csv")
    assert [row["part"] for row in rows] == [part.name for part in found.parts]
    assert len(list(csv.reader((found.folder / "samples.csv").open()))) == 9
    assert (found.folder / "band.png").stat().st_size > 10_000
    pytest.importorskip(
        "plotly", reason="plotly is not installed: pip install 'contbed[report]'"
    )
    assert main(["report", str(found.folder)]) == 0
    report = (found.folder / "report.html").read_text()
    low, high = found.band(NAME)
    assert (
        f"{low:.6g}" in report
        and f"{high:.6g}" in report
        and "law of exchange" in report
    )
    rows = table_of(found.folder / "table.csv")
    shares = {row["part"]: row[f"share in {NAME}"] for row in rows}
    assert {part: float(share) for part, share in shares.items()} == approx(
        found.shares(NAME)
    )
    parallel, matrix = (chart["data"][0] for chart in charts_of(report))
    labels = [axis["label"] for axis in parallel["dimensions"]]
    assert (
        labels[1:3] == ["laws.conduction", "laws.exchange"] and len(matrix["text"]) == 8
    )


def test_what_was_drawn_gives_the_result_again(found):
    """The run with the first law of exchange is warmer by more than all else
    together does to it.
    """
    laws = np.array(found.drawn["laws.exchange"])
    assert set(laws) == {"gunn", "power, a = 1.2, b = 0.5"}
    gunn, power = (
        found.samples[NAME][laws == name]
        for name in ("gunn", "power, a = 1.2, b = 0.5")
    )
    assert gunn.min() > power.max() + 10.0
    porosities = [found.porosities[k - 1] for k in found.drawn["packing"]]
    assert found.drawn["packed_bed.porosity"] == porosities
    assert np.ptp(found.drawn["solids.pebbles.conductivity"]) > 0.02


def test_particles_that_nothing_needs_are_not_asked(tmp_path, monkeypatch):
    monkeypatch.setattr(particles, "bed_nusselt", None)
    text = FILE.replace(
        'conduction = ["cones", "columns"], exchange = [{ name = "power", a = 1.2, b = '
        '0.5 }, "gunn"]',
        'conduction = ["cones"]',
    )
    done = cascade(written(tmp_path, text), tmp_path / "out")
    assert {part.name for part in done.parts} == {
        "packing",
        "fit",
        "solids.pebbles.conductivity",
        "mesh",
    }
    assert not (tmp_path / "out/nusselt.toml").exists()


@pytest.mark.slow
def test_packings_of_many_sizes_have_the_sauter_mean_of_the_bed(tmp_path):
    """Exchange per volume is 6 (1 - eps) h/d_32; sizes differ by the spread of a
    normal distribution cut at two.
    """
    text = FILE.replace("width = 5 }", "width = 5, spread = 0.2 }")
    text = text.replace('["cones", "columns"]', '["cones"]').replace(', "gunn"', "")
    done = cascade(written(tmp_path, text), tmp_path / "out")
    kept = list((tmp_path / "out").rglob("packings/*.npz"))
    assert len(kept) == 2
    for path in kept:
        radius = np.load(path)["radius"]
        assert (radius**3).sum() / (radius**2).sum() == approx(5e-3, rel=1e-12)
        # 300 draws: 4 %
        assert radius.std() / radius.mean() == approx(0.2 * 0.7737**0.5, rel=0.1)
    assert (tmp_path / "out/nusselt.toml").exists() and done.band(NAME)[1] > done.band(
        NAME
    )[0]


@each_case(__file__, "mistakes")
def test_mistakes(tmp_path, old, new, says):
    assert old in FILE
    assert says in refusal(
        lambda: cascade(written(tmp_path, FILE.replace(old, new)), tmp_path / "out")
    )
    assert not (tmp_path / "out").exists()


def test_scene_without_closures_to_give(tmp_path):
    path = written(
        tmp_path, scene=SCENE.replace('"10 mm" }', '"10 mm", shape = "rods" }')
    )
    refused(
        r"the packings are of spheres, but the shape of the solid is 'rods'",
        lambda: cascade(path, tmp_path / "out"),
    )


def test_bubbling_bed_whose_coefficients_are_numbers(tmp_path):
    scene = BUBBLING.replace("mass_flow = 0.1", "capacity_flow = 100.0")
    scene = scene.replace('nusselt = "gunn"', "gas_coefficient = 100.0").replace(
        GAS, ""
    )
    refused(
        r"toml:2: scene: coefficients of a bed with .*capacity_flow are numbers",
        lambda: cascade(written(tmp_path, scene=scene), tmp_path / "out"),
    )


def test_result_that_the_run_does_not_have(tmp_path):
    path = written(tmp_path, FILE.replace(NAME, "heat_wall_W"))
    refused(
        r'the run has no result "heat_wall_W"; allowed: .*heat_left_W',
        lambda: cascade(path, tmp_path / "out"),
    )
    # the first run shows it, before any packing
    assert not (tmp_path / "out/particles").exists()


GAS = 'gas.composition = "N2:0.79, O2:0.21"\n'
BUBBLING = f"""
boundary.bottom.gas = {{ mass_flow = 0.1, temperature = 900 }}
{GAS}
[bubbling_bed]
height = 0.5
section = 1.0
solids_fraction = 0.55
tubes = {{ perimeter = 1.0, coefficient = 200.0, temperature = 600 }}
[solids.char]
volume_share = 0.01
diameter = "2 mm"
density = 1200
heat_capacity = 1200
nusselt = "gunn"
mixing_conductivity = 1e-6
release = {{ rate = 2e5 }}
[solids.sand]
volume_share = 0.99
diameter = "0.5 mm"
density = 2600
heat_capacity = 1000
nusselt = "gunn"
mixing_conductivity = 2e4
"""


def test_bubbling_bed_takes_packings_as_its_emulsion(tmp_path):
    """Char without mixing is warmer than the gas by the heat that it releases over
    its surface and coefficient.
    """
    text = FILE.replace(NAME, "T_char_mid_K").replace(
        "solids.pebbles.conductivity", "solids.char.diameter"
    )
    text = text.replace(', "columns"', "").replace(', "gunn"', "")
    done = cascade(written(tmp_path, text, BUBBLING), tmp_path / "out")
    eps = float(done.porosities.mean())
    nusselt, conductivity = (
        {"file": str(tmp_path / f"out/{kind}.toml")}
        for kind in ("nusselt", "conductivity")
    )
    closures = {f"solids.{name}.nusselt": nusselt for name in ("char", "sand")}
    closures["bubbling_bed.conductivity"] = conductivity
    result = run(
        load(
            tmp_path / "bed.toml",
            closures | {"bubbling_bed.solids_fraction": 1.0 - eps},
        )
    )
    assert result.qoi["T_char_mid_K"] == done.base["T_char_mid_K"]
    used = {closure["used_by"]: closure for closure in result.closures}
    for key in closures:
        assert used[key]["name"].endswith(".toml") and used[key]["share_outside"] == 0.0
    (low, high), (slow, fast) = (
        used["solids.sand.nusselt"]["ranges"]["Re"]["used"],
        done.ranges["Re"],
    )
    # the range is that of both species: char is four times as large
    assert slow < 1.01 * low and fast > 3.0 * high
    z = result.profiles["z [m]"]
    char, sand, gas_there = (
        np.interp(0.25, z, result.profiles[f"T_{name} [K]"])
        for name in ("char", "sand", "emulsion")
    )
    T, air = 0.01 * char + 0.99 * sand, gas_mixture("N2:0.79, O2:0.21", 101325.0)
    Re, Pr = (
        0.1 * 2e-3 / air.viscosity(T),
        air.viscosity(T) * air.heat_capacity(T) / air.conductivity(T),
    )
    Nu = bind(ClosureFile(**nusselt), "nusselt", ("Re", "Pr"))(Re=Re, Pr=Pr)
    surfaces = 0.01 / 2e-3, 0.99 / 0.5e-3  # by which the tubes share out what they take
    released = 2e5 - surfaces[0] / sum(surfaces) * 200.0 * (char - 600.0)
    excess = released / (
        6.0 * (1.0 - eps) * surfaces[0] * Nu * air.conductivity(T) / 2e-3
    )
    # profiles are interpolated
    assert char - gas_there == approx(excess, rel=1e-4)
    part = next(part for part in done.parts if part.name == "packing")
    assert part.deviation["T_char_mid_K"] > 0.0


CASE = """
title = "A bed heated at its end"
source = "made from a run"
licence = "none needed"
scene = "bed.toml"
quantity = "T_solid"
uncertainty = "0.5 K"
[measured]
file = "measured.csv"
column = "T"
time = "t"
position = "x"
"""
HEATED = RESTING + "time = { end = 2000 }\ninitial = { temperature = 300 }\n"


def measured_bed(folder, rows):
    (folder / "case.toml").write_text(CASE)
    (folder / "bed.toml").write_text(HEATED)
    (folder / "measured.csv").write_text(
        "t [s],x [m],T [K]\n" + "".join(f"{t},{x},{T}\n" for t, x, T in rows)
    )
    return read_case(str(folder))


def test_share_of_measured_points_in_the_band(tmp_path):
    """A normal prediction: the band reaches 1.645 deviations, with the scatter u of
    a value 1.645 (s^2 + u^2)^(1/2).
    """
    deviation, ends = 2.0, 1.645 * np.array([2.0, np.hypot(2.0, 0.5)])
    offsets = [
        0.0,
        ends[0] - 0.05,
        -ends[0] + 0.05,
        ends.mean(),
        -ends.mean(),
        ends[1] + 0.1,
    ]
    case = measured_bed(
        tmp_path, [(100.0 * (k + 1), 0.01, 350.0 + by) for k, by in enumerate(offsets)]
    )
    names = measured.names(case)
    normal = np.array(
        [NormalDist(350.0, deviation).inv_cdf((k + 0.5) / 4000) for k in range(4000)]
    )
    deviations = {
        "packing": dict.fromkeys(names, 3.0),
        "fit": dict.fromkeys(names, 1.0),
    }
    found = measured.held(
        case, dict.fromkeys(names, 350.0), deviations, dict.fromkeys(names, normal), 0.9
    )
    assert_allclose(found.high - 350.0, ends[0], rtol=1e-3)
    # 21 nodes of the scatter
    assert_allclose(found.high_measured - 350.0, ends[1], rtol=3e-3)
    assert found.inside == 3 / 6 and found.inside_measured == 5 / 6
    assert found.shares == {"packing": 0.9, "fit": 0.1}


@pytest.mark.slow
def test_a_cascade_beside_measured_points(tmp_path, capsys):
    """Points that are the best prediction lie in the band, those 50 K away do not;
    walls make packings looser.
    """
    text = """
        scene = "bed.toml"
        measured = "."
        samples = 8
        packings = { count = 2, particles = 400, width = 7, walls = true, friction = 0.4 }
        laws = { conduction = ["cones", "spreading"] }
        uncertain = { solids.pebbles.heat_capacity = "3 %" }
    """
    times = [500.0, 1000.0, 2000.0]
    measured_bed(tmp_path, [(t, 0.02, 300.0) for t in times])
    (tmp_path / "cascade.toml").write_text(text)
    first = cascade(tmp_path / "cascade.toml", tmp_path / "out")
    best = first.held.best
    # 7 spheres between walls; about 0.39 between periodic sides
    assert first.porosities.min() > 0.42
    assert np.all((first.held.low < best) & (best < first.held.high))
    measured_bed(
        tmp_path,
        [
            *((t, 0.02, T) for t, T in zip(times, best, strict=True)),
            (1000.0, 0.02, best[1] + 50.0),
        ],
    )
    assert command(f"cascade {tmp_path}/cascade.toml --out {tmp_path}/out") == 0
    assert "4 measured points, 75% in the band of 90%" in capsys.readouterr().out
    about = json.loads((tmp_path / "out/summary.json").read_text())["measured"]
    assert about["share in the band"] == 0.75 and sum(
        about["shares of the parts"].values()
    ) == approx(1.0)
    assert about["shares of the parts"]["law of conduction"] > 0.5
    table = table_of(tmp_path / "out/table.csv")
    assert [float(row["share at the measured points"]) for row in table] == list(
        about["shares of the parts"].values()
    )
    assert command(f"report {tmp_path}/out") == 0
    report = (tmp_path / "out/report.html").read_text()
    assert "75.0% are in the band of 90%" in report


def test_damaged_runs_of_the_bed_are_told(tmp_path):
    """Their outcome is there, but summary or profiles were changed since: removed,
    they are computed again.
    """
    bed = Mock()
    bed.settings.quantity = "T_solid"
    (tmp_path / "summary.json").write_text('{"status": "ok", "qoi": {}}')
    with pytest.raises(
        ContbedError,
        match=r"summary\.json: .*closures is missing; remove .*, and the same command",
    ):
        band.Runs(bed, tmp_path, lambda: None).summary(tmp_path)
    (tmp_path / "profiles.csv").write_text("t [s],x [m]\n1,2\n")
    with pytest.raises(
        ContbedError,
        match=r"profiles\.csv: has no column 'T_solid \[K\]'; remove .*, and the same",
    ):
        measured.predicted(bed, tmp_path)
