"""README and pages of the models: the results that they print are those of the code,
the numbers of the evidence those of the committed tables, and links lead somewhere.
"""

import re
from pathlib import Path

import pytest

import contbed as cb
from contbed.models import MODELS
from tests.numbers_of import table_of

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
MODEL_PAGES = sorted((ROOT / "docs" / "models").glob("[!i]*.md"))
RESULTS = re.compile(
    r"^```\{code-block\} text\n:caption: (\w+)\n(.*?)^```", re.DOTALL | re.MULTILINE
)
# these compile or settle first; `make test-slow` runs them
LONG = {"two_fluid", "particles_gas"}


def shown(text):
    """Names and numbers of the lines that a run prints as its results."""
    lines = re.findall(r"^(\w+)(?: \[\S+\])?\s+(-?[\d.e+-]+)$", text, re.MULTILINE)
    return {name: float(number) for name, number in lines}


def table(study, file="results"):
    return table_of(ROOT / "studies" / study / f"{file}.csv")


def test_it_is_read_at_once():
    assert len(README.splitlines()) <= 120


@pytest.mark.parametrize(
    "page",
    [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "studies" / "README.md"],
    ids=str,
)
def test_links_lead_somewhere(page):
    text = page.read_text(encoding="utf-8")
    targets = re.findall(r"\]\(([^)#]+)", text)
    missing = [
        target
        for target in targets
        if "://" not in target and not (page.parent / target).exists()
    ]
    assert missing == []


def test_the_scene_gives_the_result_that_it_shows(tmp_path):
    """To six digits, which are printed; the error estimate to one."""
    scene, printed = re.search(
        r"```toml\n(.*?)```.*?```text\n(.*?)```", README, re.DOTALL
    ).groups()
    (tmp_path / "scene.toml").write_text(scene, encoding="utf-8")
    result = cb.run(cb.load(tmp_path / "scene.toml"))
    assert result.status == "ok"
    found = shown(printed.partition("result\n")[2])
    assert len(found) >= 5
    for name, number in found.items():
        within = 0.1 if name == "estimated_error" else 1e-5
        assert result.qoi[name] == pytest.approx(number, rel=within), name
    # "The steam leaves 1.2 K colder than the silica enters."
    assert 973.15 - result.qoi["T_fluid_out_K"] == pytest.approx(1.2, abs=0.05)
    assert "leaves 1.2 K colder" in README


def test_every_model_has_a_page_and_a_line():
    kinds = set(MODELS)
    assert {page.stem for page in MODEL_PAGES} == kinds
    first = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    for kind in kinds:
        assert f"](docs/models/{kind}.md)" in README
        assert f"](models/{kind}.md)" in first


@pytest.mark.parametrize("page", MODEL_PAGES, ids=lambda page: page.stem)
def test_pages_of_models_have_the_same_parts(page):
    text = page.read_text(encoding="utf-8")
    assert re.findall(r"^## (.*)", text, re.MULTILINE) == [
        "What it solves",
        "When to use it",
        "When not",
        "A scene",
        "A result",
        "Evidence",
        "Cost",
        "In detail",
    ]
    assert "$$" in text and "template.toml" in text


def results_of_pages():
    pages = [*MODEL_PAGES, ROOT / "docs" / "index.md"]
    found = []
    for page in pages:
        for kind, text in RESULTS.findall(page.read_text(encoding="utf-8")):
            marks = [pytest.mark.slow] * (kind in LONG)
            name = f"{page.stem}-{kind}"
            found.append(pytest.param(kind, text, marks=marks, id=name))
    return found


@pytest.mark.parametrize(("kind", "printed"), results_of_pages())
def test_templates_give_the_results_that_pages_show(kind, printed):
    result = cb.run(cb.load(MODELS[kind].template))
    found = shown(printed)
    assert len(found) == len(printed.strip().splitlines())
    values = {name.partition(" ")[0]: value for name, value in result.qoi.items()}
    for name, number in found.items():
        assert values[name] == pytest.approx(number, rel=1e-4), name


def test_numbers_of_the_evidence_are_those_of_the_tables():
    rows = table("pivem_2012")
    error = max(
        abs(float(row[name]))
        for row in rows
        for name in ("error_fluid [1]", "error_solid [1]")
    )
    assert f"error {error:.1e}".replace("e-0", "e-") in README
    assert f"in {len(rows)} scenes" in README

    checks = table("two_fluid_checks")
    slip = [row for row in checks if row["quantity"] == "slip_velocity"]
    drift = [row for row in checks if row["quantity"] == "mass_drift_relative"]
    worst = [max(float(row["deviation"]) for row in each) for each in (slip, drift)]
    texts = [f"{number:.0e}".replace("e-0", "e-") for number in worst]
    assert f"slip velocity {texts[0]}, mass {texts[1]}" in README

    scores = {
        (row["case"], row["group"]): float(row["RMS [K]"])
        for row in table("measured_beds", "scores")
    }
    assert f"steel beads {scores['beaulieu_2020', 'all']:.1f} K" in README
    salt = [scores["pacheco_2002", time] for time in ("3600 s", "1800 s")]
    assert f"molten salt {salt[0]:.1f} K after 1 h" in README
    assert f"molten salt {salt[1]:.1f} K after 0.5 h" in README
    assert f"stone {scores['alonso_2022', '3600 s']:.0f} K" in README

    swings = {
        row["model"]: (
            float(row["standard deviation [Pa]"]),
            float(row["peak of the spectrum [Hz]"]),
        )
        for row in table("van_wachem_2001", "statistics")
    }
    measured, particles = swings["measured"], swings["particles"]
    fluids = swings["two fluids"]
    assert f"{particles[0]:.0f} Pa, measured {measured[0]:.0f} Pa" in README
    assert (
        f"two fluids {fluids[0]:.0f} Pa, at {fluids[1]:.1f} Hz instead of "
        f"{measured[1]:.1f} Hz" in README
    )

    seconds = {
        (row["case"], row["program"]): float(row["cpu_per_s"])
        for row in table("two_fluid_speed")
    }
    ratios = sorted(
        seconds[case, "twoPhaseEulerFoam"] / seconds[case, "contbed"]
        for case in {case for case, _ in seconds}
    )
    assert f"{ratios[0]:.1f} to {ratios[-1]:.1f} times cheaper" in README
