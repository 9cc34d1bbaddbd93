"""The manual: its blocks run as they stand, it builds without warnings, its links
lead somewhere.
"""

import json
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from pytest import approx

from contbed import cli
from contbed.explain import editor
from contbed.models import MODELS, kind_of

ROOT = Path(__file__).parents[2]
PAGES = [
    *sorted((ROOT / "docs" / "tutorial").glob("*.md")),
    *sorted((ROOT / "docs" / "howto").glob("*.md")),
]
BLOCK = re.compile(
    r"^```(\{code-block\} )?(\w+)\n(?::caption: (\S+)\n)?(.*?)^```",
    re.DOTALL | re.MULTILINE,
)
sys.path.insert(0, str(ROOT / "docs" / "_ext"))


def quick_of(pages, quick):
    """Pages as parameters of a test, slow but for those that are named."""
    return [
        pytest.param(
            page, id=page.stem, marks=[] if page.stem in quick else pytest.mark.slow
        )
        for page in pages
    ]


def blocks(page):
    """Language, file name and text of each block of code."""
    return [
        (match[2], match[3], match[4])
        for match in BLOCK.finditer(page.read_text(encoding="utf-8"))
    ]


def test_errors_against_exact_solutions_are_those_that_are_allowed():
    from verification import cases

    found = cases()
    assert {case.model.partition(",")[0] for case in found} >= {
        "packed_bed",
        "radiation",
        "bubbling_bed",
        "two_fluid",
    }
    for case in found:
        assert 0.0 <= case.error <= case.allowed, case


def test_observed_orders_are_those_of_the_tables():
    """Slopes of the committed tables: fourth order of flow, 2 p of degree p, first
    order in tolerance and at jumps.
    """
    from verification import ROOT, cases, orders

    table = tomllib.loads((ROOT / "docs" / "verification.toml").read_text())["case"]
    found = {case.against.partition(":")[0]: case.order for case in cases()}
    assert all(("order" in entry) != ("no_order" in entry) for entry in table)
    assert sum("order" in entry for entry in table) >= 4
    told = {
        name.split(",")[0]: text
        for name, text in found.items()
        if not text.startswith("none: ")
    }
    assert (
        told["Brinkman-Forchheimer flow between plates"]
        == "3.6 to 4.3 with cells across; expected 4"
    )
    assert (
        told["bed with frozen coefficients"]
        == "2.2, 4.1, 6.1 with cells; expected 2, 4, 6 for degrees 1, 2, 3"
    )
    rows = [
        {"n": str(n), "e": str(7.0 * n**-3.0), "kind": kind}
        for kind in "ab"
        for n in (4, 8, 16)
    ]
    entry = {"over": "n", "errors": ["e"], "series": ["kind"]}
    assert orders(rows, entry) == approx([3.0, 3.0])
    assert orders(rows, entry | {"tolerance": True}) == approx([-3.0, -3.0])
    with pytest.raises(ValueError, match="fewer than three meshes"):
        orders(rows, entry | {"least": 0.01})


@pytest.mark.parametrize("broken", ["nan", ""])
def test_an_error_that_is_no_number_is_refused(tmp_path, broken):
    from verification import cases

    for file in (ROOT / "studies").glob("*/*.csv"):
        (tmp_path / file.parent.name).mkdir(exist_ok=True)
        shutil.copyfile(file, tmp_path / file.parent.name / file.name)
    table = tmp_path / "nakayama_2001" / "results.csv"
    table.write_text(re.sub(r"[^,]+$", broken, table.read_text().rstrip()) + "\n")
    with pytest.raises(ValueError, match=r"nan|NaN|could not convert"):
        cases(tmp_path)


def test_the_page_of_messages_has_those_of_each_way_to_report(tmp_path, monkeypatch):
    """Each of these is reported in its own way: raised, yielded by a check, added to
    warnings, remarked; a missing one means that a kind of message is not read.
    """
    import messages

    found = messages.messages(ROOT / "contbed")
    kinds = {each.text: each.kind for each in found}
    cases = {
        "the bed is ... m large; if the file is in ..., set mesh.scale = ...": "warning",
        "a temperature of ... K; it must be above 0": "error",
        "a bed needs particles; give [solids.NAME]": "check",
        "the linear solver left a relative residual of ...": "ConvergenceError",
        "its checksum is wrong: the file was changed or damaged": "ValueError",
    }
    assert {text: kinds.get(text) for text in cases} == cases
    monkeypatch.setattr(messages, "messages", lambda package: found)
    messages.write_page(tmp_path / "messages.md", ROOT / "contbed")
    text = (tmp_path / "messages.md").read_text(encoding="utf-8")
    assert "## scene" in text
    assert "| `a temperature of ... K; it must be above 0` | error |" in text


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_blocks_of_toml_are_toml(page):
    for language, _, text in blocks(page):
        if language == "toml":
            tomllib.loads(text)


def test_scenes_of_the_tutorials_have_the_keys_of_their_schema():
    jsonschema = pytest.importorskip(
        "jsonschema",
        reason="jsonschema is not installed: pip install 'contbed[notebook]'",
    )
    found = 0
    for page in PAGES:
        for language, name, text in blocks(page):
            values = tomllib.loads(text) if language == "toml" else {}
            if name and "scene" not in values:
                jsonschema.validate(values, editor.json_schema(kind_of(values)))
                found += 1
    assert found == 4


def run_blocks(page, capsys):
    """Run the blocks of a page in their order in the working directory: files are
    written, commands run; return the text of the Python blocks.
    """
    program = []
    for language, name, text in blocks(page):
        if name:
            Path(name).write_text(text)
        elif language == "sh":
            for line in text.splitlines():
                command, _, target = line.partition(" > ")
                words = shlex.split(command)
                assert words[0] == "contbed"
                assert cli.main(words[1:]) == 0, line
                out = capsys.readouterr().out
                if target:
                    Path(target.strip()).write_text(out)
        elif language == "python":
            program.append(text)
    return program


@pytest.mark.parametrize("page", quick_of(PAGES, ("first_bed",)))
def test_every_block_runs(page, tmp_path, monkeypatch, capsys):
    """All in one folder, and Python in one process."""
    monkeypatch.chdir(tmp_path)
    if program := run_blocks(page, capsys):
        (tmp_path / "page.py").write_text("\n".join(program))
        environment = {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1", "PATH": ""}
        done = subprocess.run(
            [sys.executable, "page.py"], env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr


# the processor time of the others is 5 to 30 s
FOLDER = ROOT / "docs" / "problems"
PROBLEMS = quick_of(
    sorted({*FOLDER.glob("*.md")} - {FOLDER / "index.md"}),
    ("moving_bed", "rock_store", "reformer_tube"),
)
ROW = re.compile(
    r"^\| `(?P<name>.+?)` \| (?P<hand>[-+.e\d]+) \| (?P<run>[-+.e\d]+) \| "
    r"(?P<within>[.\d]+) % \|$",
    re.MULTILINE,
)


@pytest.mark.parametrize("page", PROBLEMS)
def test_worked_problems_agree_with_their_check_by_hand(
    page, tmp_path, monkeypatch, capsys
):
    """Each row of the table holds a value by hand, that of the run and the difference
    that the page explains; the run's own value is printed with four digits, or as
    settled particles and bubbles repeat it.
    """
    monkeypatch.chdir(tmp_path)
    run_blocks(page, capsys)
    found = {}
    for summary in sorted(tmp_path.glob("*/summary.json")):
        results = json.loads(summary.read_text(encoding="utf-8"))["qoi"]
        found |= {name.partition(" [")[0]: value for name, value in results.items()}
    rows = list(ROW.finditer(page.read_text(encoding="utf-8")))
    assert rows
    for row in rows:
        value = found[row["name"].partition(" [")[0]]
        assert value == approx(float(row["run"]), rel=1e-3), row["name"]
        allowed = 1e-2 * float(row["within"])
        assert value == approx(float(row["hand"]), rel=allowed), row["name"]


class Links(HTMLParser):
    """Targets and names in a page."""

    def __init__(self):
        super().__init__()
        self.targets, self.names = [], set()

    def handle_starttag(self, tag, attributes):
        for key, value in attributes:
            if key in ("href", "src") and value:
                self.targets.append(value)
            if key in ("id", "name") and value:
                self.names.add(value)


@pytest.mark.slow
def test_it_builds_and_all_its_links_lead_somewhere(tmp_path):
    """As `make docs`, with warnings as errors; then every link to a file or a place
    of the manual is followed.
    """
    for name in ("sphinx", "myst_parser", "furo"):
        pytest.importorskip(
            name, reason=f"{name} is not installed: pip install 'contbed[docs]'"
        )
    command = [
        sys.executable,
        "-m",
        "sphinx",
        "-W",
        "-q",
        "-b",
        "html",
        str(ROOT / "docs"),
        str(tmp_path),
    ]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stderr[-3000:]
    parsed = {}
    for file in tmp_path.rglob("*.html"):
        parsed[file.resolve()] = links = Links()
        links.feed(file.read_text(encoding="utf-8"))
    broken = []
    for file, links in parsed.items():
        for target in links.targets:
            parts = urlsplit(target)
            if parts.scheme or target.startswith(("//", "data:")):
                continue
            other = (
                (file.parent / unquote(parts.path)).resolve() if parts.path else file
            )
            names = parsed[other].names if other in parsed else None
            if not other.exists() or (
                parts.fragment
                and names is not None
                and unquote(parts.fragment) not in names
            ):
                broken.append(f"{file.name}: {target}")
    assert not broken, broken[:20]
    for kind in MODELS:
        assert (tmp_path / "generated" / "theory" / f"{kind}.html").exists()
        assert (tmp_path / "generated" / "reference" / f"scene_{kind}.html").exists()
    scripts = [
        target
        for links in parsed.values()
        for target in links.targets
        if urlsplit(target).scheme in ("http", "https")
    ]
    loaded = [target for target in scripts if target.endswith((".js", ".css"))]
    assert not loaded  # nothing is loaded from elsewhere


@pytest.mark.slow
@pytest.mark.parametrize(
    "file",
    sorted((ROOT / "docs" / "notebooks").glob("*.ipynb")),
    ids=lambda file: file.stem,
)
def test_notebooks_run(file, tmp_path, monkeypatch):
    """Each from the first cell to the last, in an empty folder; the saved results
    are of a run without errors.
    """
    nbformat = pytest.importorskip(
        "nbformat", reason="nbformat is not installed: pip install 'contbed[notebook]'"
    )
    nbclient = pytest.importorskip(
        "nbclient", reason="nbclient is not installed: pip install 'contbed[notebook]'"
    )
    pytest.importorskip(
        "ipykernel",
        reason="ipykernel is not installed: pip install 'contbed[notebook]'",
    )
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    notebook = nbformat.read(file, 4)
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(cell.execution_count for cell in code)
    assert not any(
        output.output_type == "error" for cell in code for output in cell.outputs
    )
    where = {"metadata": {"path": str(tmp_path)}}
    nbclient.NotebookClient(
        notebook, timeout=300, kernel_name="python3", resources=where
    ).execute()
