"""Closures fitted from particles: fits of what they can represent are exact, files
come back, scenes use them.
"""

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pytest import approx

import contbed as cb
from contbed.closures import usage
from contbed.closures.file import closure_of
from contbed.dem import extract
from contbed.errors import ClosureRangeError
from contbed.fem.ad.dual import Dual
from contbed.loading import from_dict, loads
from contbed.scene.identity import resolved, scene_hash
from tests.balances import assert_closed
from tests.numbers_of import table_of
from tests.refusals import problems_of, refused

STUDY = Path(__file__).parents[2] / "studies/closure_transfer"
RATIO = extract.RATIO
# of ln(k/k_f), powers of eps - 0.4 by powers of ln(ratio/10)
ETC = np.array([[0.3, 0.7, 0.02], [-1.5, 0.4, 0.0]])


def k_over_fluid(ratio, eps):
    L, e = np.log(ratio / 10.0), eps - 0.4
    return np.exp(sum(ETC[n, m] * e**n * L**m for n in range(2) for m in range(3)))


@pytest.fixture
def etc():
    """A fit of data that the form can hold."""
    ratio, eps = (
        grid.ravel()
        for grid in np.meshgrid(np.geomspace(1, 1000, 9), [0.35, 0.38, 0.45])
    )
    return extract.fit_log_polynomial(
        "conductivity",
        {RATIO: ratio, "eps": eps},
        k_over_fluid(ratio, eps),
        {RATIO: "log", "eps": "linear"},
        (2, 1),
    )


@pytest.fixture
def htc():
    Re, Pr = (
        grid.ravel() for grid in np.meshgrid(np.geomspace(1, 500, 12), [0.6, 0.8])
    )
    return extract.fit_power(Re, Pr, 2.0 + 1.2 * Re**0.5 * Pr ** (1 / 3))


BED = """
[mesh]
type = "line"
length = 0.5
cells = 40

[gas]
density = 1.2
heat_capacity = 1005.0
viscosity = 1.8e-5
conductivity = 0.026

[solids.beads]
diameter = 0.002
density = 2500.0
heat_capacity = 840.0
conductivity = [0.4, 1e-3]

[packed_bed]
porosity = 0.4

[heat]

[closures]
nusselt = { file = "htc.toml" }
conductivity_solids = { file = "etc.toml" }

[boundary.left]
gas = { velocity = 0.3, temperature = 300.0 }

[boundary.right]
solids.beads.fixed_temperature = 600.0
"""


@pytest.fixture
def folder(tmp_path, etc, htc):
    etc.write(tmp_path / "etc.toml", {"scene": "packing.toml", "seed": 7})
    htc.write(tmp_path / "htc.toml", {"scene": "bed.toml"})
    return tmp_path


def scene(folder, text=BED, **overrides):
    return loads(text, "scene.toml", overrides, folder)


def test_a_form_recovers_itself(etc, htc):
    rng = np.random.default_rng(1)
    ratio, eps = rng.uniform(1, 1000, 50), rng.uniform(0.35, 0.45, 50)
    closure = etc.closure()
    found = closure(k_fluid=0.03, k_solid=0.03 * ratio, eps=eps)
    # 9 decades of powers in least squares
    assert found == approx(0.03 * k_over_fluid(ratio, eps), rel=1e-11)
    parts = htc.content["parameters"]
    assert (parts["a"]["value"], parts["b"]["value"]) == approx((1.2, 0.5), rel=1e-9)
    assert htc.closure()(Re=100.0, Pr=0.71) == approx(
        2 + 1.2 * 10 * 0.71 ** (1 / 3), rel=1e-9
    )


def test_intervals_hold_the_truth_as_often_as_they_say():
    # 95 % of 400 intervals: 380 +- 4.4, four standard deviations allowed
    rng = np.random.default_rng(8)
    x = np.geomspace(1, 100, 15)
    hits = 0
    for _ in range(400):
        noisy = np.exp(0.2 + 0.5 * np.log(x) + rng.normal(0, 0.05, x.size))
        fit = extract.fit_log_polynomial(
            "nusselt", {"Re": x}, noisy, {"Re": "log"}, (1,)
        )
        low, high = fit.content["terms"][1]["interval"]
        hits += low <= 0.5 <= high
    assert 362 <= hits <= 398


def test_samples_scatter_as_the_parameters_do():
    rng = np.random.default_rng(9)
    x = np.geomspace(1, 100, 40)
    fit = extract.fit_log_polynomial(
        "nusselt",
        {"Re": x},
        np.exp(np.log(x) + rng.normal(0, 0.1, 40)),
        {"Re": "log"},
        (1,),
    )
    slopes = [
        closure.content["terms"][1]["value"] for closure in fit.samples(2000, seed=3)
    ]
    # the standard deviation of 2000 draws is known to 1.6 %
    assert np.std(slopes) == approx(fit.covariance[1, 1] ** 0.5, rel=0.08)


def test_data_that_determine_nothing():
    ratio = np.geomspace(1, 100, 6)
    refused(
        "6 points do not determine 4 terms",
        lambda: extract.fit_log_polynomial(
            "conductivity",
            {RATIO: ratio, "eps": np.full(6, 0.4)},
            ratio,
            {RATIO: "log", "eps": "linear"},
            (1, 1),
        ),
    )
    refused(
        "do not determine a and b",
        extract.fit_power,
        [10.0, 10.0, 10.0],
        0.7,
        [4.0, 4.1, 4.2],
    )


def test_a_file_comes_back(folder, etc):
    content = tomllib.loads((folder / "etc.toml").read_text())
    provenance = content.pop("provenance")
    assert content == etc.content
    assert (
        provenance["seed"] == 7
        and provenance["contbed"] == cb.__version__
        and len(provenance["hash"]) == 16
    )
    closure = closure_of("etc.toml", folder, "conductivity")
    assert closure.sheet.arguments == ("k_fluid", "k_solid", "eps")
    assert closure.sheet.ranges == {RATIO: (1.0, 1000.0), "eps": (0.35, 0.45)}
    assert "seed 7" in closure.sheet.source
    assert closure(k_fluid=1.0, k_solid=50.0, eps=0.4) == etc.closure()(
        k_fluid=1.0, k_solid=50.0, eps=0.4
    )


@pytest.mark.parametrize("name", ["etc", "htc"])
def test_dual_numbers_give_the_slope(folder, name):
    # central differences with a step of 1e-6: 1e-8
    closure = closure_of(
        f"{name}.toml", folder, "conductivity" if name == "etc" else "nusselt"
    )
    arguments = (
        {"k_fluid": 0.03, "k_solid": 2.0, "eps": 0.39}
        if name == "etc"
        else {"Re": 30.0, "Pr": 0.7}
    )
    for key, value in arguments.items():
        dual = closure(**{**arguments, key: Dual(np.array(value), {0: np.array(1.0)})})
        step = 1e-6 * value
        high, low = (
            closure(**{**arguments, key: value + sign * step}) for sign in (1, -1)
        )
        assert dual.value == closure(**arguments)
        assert dual.tangents[0] == approx((high - low) / (2 * step), rel=1e-8)


def test_a_scene_uses_them(folder):
    result = cb.run(scene(folder))
    used = {use["name"]: use for use in result.closures}
    assert used["nusselt of htc.toml"]["share_outside"] == 0
    assert used["conductivity of etc.toml"]["ranges"][RATIO]["declared"] == [
        1.0,
        1000.0,
    ]
    # the conductivity depends on temperature through k_solid: Newton converges at its
    # own order
    assert result.history[-1] < 1e-9 * result.history[0] and len(result.history) < 9
    assert_closed(result, 1e-12, "energy")


def test_the_value_in_a_scene_is_the_value_of_the_file(folder):
    # constant solid: k is one number, and the run is that with the number itself
    text = BED.replace("[0.4, 1e-3]", "0.8")
    closed = cb.run(scene(folder, text))
    etc = closure_of("etc.toml", folder, "conductivity")(
        k_fluid=0.026, k_solid=0.8, eps=0.4
    )
    htc = closure_of("htc.toml", folder, "nusselt")(
        Re=1.2 * 0.3 * 0.002 / 1.8e-5, Pr=1005 * 1.8e-5 / 0.026
    )
    numbers = text.replace('{ file = "etc.toml" }', repr(float(etc))).replace(
        '{ file = "htc.toml" }', repr(float(htc))
    )
    given = cb.run(scene(folder, numbers))
    for name in ("T_fluid [K]", "T_solid [K]"):
        column = next(key for key in closed.profiles if key.startswith(name.split()[0]))
        assert closed.profiles[column] == approx(given.profiles[column], rel=1e-13)


def test_use_outside_of_the_range(folder):
    narrow = (
        (folder / "htc.toml")
        .read_text()
        .replace("Re = [1.0, 500.0]", "Re = [1.0, 20.0]")
    )
    # changed by hand, it is no longer what was fitted
    narrow = re.sub(r"\nhash = .*", "", narrow)
    assert "20.0" in narrow
    (folder / "htc.toml").write_text(narrow)
    result = cb.run(scene(folder))
    assert any(
        "nusselt of htc.toml is out of its range: Re 40" in text
        for text in result.warnings
    )
    with pytest.raises(ClosureRangeError, match=r"declared 1 to 20$"):
        cb.run(scene(folder, **{"solver.strict": True}))


def test_the_content_of_the_file_is_part_of_the_scene(folder):
    before = scene(folder)
    assert resolved(before)["closures"]["nusselt"] == {"file": "htc.toml"}
    first = scene_hash(before)
    text = (folder / "htc.toml").read_text()
    (folder / "htc.toml").write_text(text + "# another line\n")
    assert scene_hash(scene(folder)) != first
    assert scene_hash(from_dict(resolved(before), base=folder)) == scene_hash(before)


def problems(folder, **files: str):
    for name, text in files.items():
        (folder / f"{name}.toml").write_text(text)
    return problems_of(scene, folder)


def test_files_that_cannot_be_used(folder):
    line = next(
        k for k, text in enumerate(BED.splitlines(), 1) if text.startswith("nusselt")
    )
    at = f"scene.toml:{line}: closures.nusselt: "
    good = (folder / "htc.toml").read_text()
    file = str(folder / "htc.toml")

    def told(text: str) -> Any:
        return problems(folder, htc=text)

    assert told(good.replace("format = 1", "format = 7")) == [
        f"{at}{file}:1: format: is 7; this version of contbed reads 1: extract it anew"
    ]
    assert told((folder / "etc.toml").read_text()) == [
        f"{at}htc.toml holds a closure of kind 'conductivity', wanted kind 'nusselt'"
    ]
    assert told("title = 'a scene'") == [
        f"{at}{file}:1: format: missing: this is no closure file of contbed"
    ]
    assert "not valid TOML" in told(good[:40])[0]
    assert (
        'form = "spline": unknown choice; allowed: log_polynomial, power'
        in told(good.replace('"power"', '"spline"'))[0]
    )
    line = next(
        k for k, text in enumerate(good.splitlines(), 1) if text.startswith("a = ")
    )
    assert (
        f"{file}:{line}: parameters.a.values = 1.2: unknown key; allowed: value"
        in told(good.replace("\na = {value =", "\na = {values ="))[0]
    )
    assert "range: does not bound Pr" in told(good.replace("\nPr = [", "\nEps = ["))[0]
    (folder / "htc.toml").unlink()
    assert problems_of(scene, folder) == [
        f"{at}no closure file 'htc.toml'; looked for {file}"
    ]


def test_a_bad_polynomial(folder):
    good = (folder / "etc.toml").read_text()
    for old, new, wanted in (
        ("powers = [0, 0]", "powers = [0]", "terms[0]: needs 2 whole powers"),
        (
            'scale = "linear"',
            'scale = "cubic"',
            'variables.eps.scale = "cubic": unknown choice',
        ),
        ("\neps = {", "\nporosity = {", "variables.porosity: names no argument"),
        (
            "eps = [0.35, 0.45]",
            "eps = [0.45, 0.35]",
            "range.eps = [0.45, 0.35]: is not [lowest, highest]",
        ),
    ):
        assert old in good
        assert wanted in problems(folder, etc=good.replace(old, new, 1))[0]


def test_a_file_whose_numbers_make_no_closure(folder):
    good = (folder / "htc.toml").read_text()
    value = re.search(r"\na = \{value = ([^,]+),", good).group(1)
    for old, new, wanted in (
        (
            "format = 1\n",
            "format = true\n",
            "format: is True; this version of contbed reads 1",
        ),
        (
            "format = 1\n",
            "format = 1.0\n",
            "format: is 1.0; this version of contbed reads 1",
        ),
        (
            "Re = [1.0, 500.0]",
            "Re = [-1.0, 500.0]",
            "range.Re: begins below 0, where Re never is",
        ),
        (
            "Re = [1.0, 500.0]",
            "Re = [500.0, 1.0]",
            "range.Re = [500.0, 1.0]: is not [lowest, highest]",
        ),
        (f"a = {{value = {value}", "a = {value = -50.0", "parameters: give -"),
        (
            f"a = {{value = {value}",
            "a = {value = inf",
            "parameters.a.value = Infinity: not a finite number",
        ),
        (
            f"a = {{value = {value}",
            "a = {value = 1e308",
            "parameters.a.value = 1e+308: 1e+308 is no size that a bed has",
        ),
        (
            f"a = {{value = {value}",
            "a = {value = 1e155",
            "parameters.a.value = 1e+155: 1e+155 is no size that a bed has",
        ),
        (
            f"a = {{value = {value}",
            "a = {value = 1.0",
            "provenance.hash: does not belong to this content",
        ),
        (
            "\n[provenance]",
            "\n[residuals.by]",
            "provenance: this table is missing",
        ),
    ):
        assert old in good
        assert wanted in problems(folder, htc=good.replace(old, new, 1))[0]
    backward = re.sub(r"(\na = .*interval = )\[.*\]", r"\1[2.0, 1.0]", good)
    assert (
        "parameters.a.interval = [2.0, 1.0]: is not [lowest, highest]"
        in problems(folder, htc=backward)[0]
    )


def test_a_number_where_a_file_belongs(folder):
    refused(
        r"closures\.nusselt\.file = 3: wrong kind of value",
        lambda: scene(folder, BED.replace('{ file = "htc.toml" }', "{ file = 3 }")),
    )
    refused(
        r"closures\.nusselt\.a = 1: unknown key; allowed: file",
        lambda: scene(
            folder, BED.replace('{ file = "htc.toml" }', '{ file = "htc.toml", a = 1 }')
        ),
    )


def test_registry_reads_its_use(etc):
    use = usage(etc.closure(), k_fluid=1.0, k_solid=np.array([10.0, 5000.0]), eps=0.4)
    assert use.share_outside == 0.5


def test_the_study_of_transfer():
    # the committed closure file gives the committed outlet temperature, inside of its
    # range
    result = cb.run(cb.load(STUDY / "heated_wall.toml"))
    rows = {
        row["conductivity"]: float(row["T_out [K]"])
        for row in table_of(STUDY / "outlet.csv")
    }
    assert result.qoi["T_fluid_out_K"] == approx(
        rows["packings, cones (Eq. 5)"], abs=2e-3
    )
    used = next(
        use
        for use in result.closures
        if use["name"] == "conductivity of closures/conductivity.toml"
    )
    assert used["share_outside"] == 0
    assert "seeds (1, 2, 3, 4)" in used["source"]


def test_a_sweep_over_packings_is_what_the_network_says():
    # one layer of touching spheres between two others, with walls and with periodic
    # sides
    x = np.stack(
        np.meshgrid(np.arange(3.0), np.arange(3.0), np.arange(5.0), indexing="ij"), -1
    ).reshape(-1, 3)
    box = (np.zeros(3), np.array([3.0, 3.0, 5.0]))
    sides = extract.Packing(x, 0.5, 0.4764, 0.5, 3.5, 9.0, box)
    k = {
        paths: extract.conductivity_sweep([sides], (1.0, 20.0), 0.5, 1.0, paths)[
            "k/k_fluid"
        ]
        for paths in ("cones", "columns")
    }
    # a cubic bed of its own fluid, to round-off
    assert k["columns"][0] == approx(1.0, rel=1e-12)
    assert k["cones"][0] > 1.1
    open_sides = extract.conductivity_sweep(
        [sides._replace(box=None)], (20.0,), 0.5, 1.0
    )
    assert open_sides["eps"] == [0.4764] and open_sides["k/k_fluid"][0] < k["cones"][1]
