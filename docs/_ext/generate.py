"""Pages of the manual that are made from the package: theory, reference, closures,
gallery, glossary, how to cite.

Each fact is taken from where it stands: docstrings of equations, schemas of scenes,
data sheets of closures, the command line, READMEs of studies and the tables of
`contbed.fields`. A new physics, key, closure or study shows up by itself.
"""

from __future__ import annotations

import re
import shutil
import tomllib
from collections.abc import Iterator, Mapping
from html import escape
from pathlib import Path

from jobs import JOBS
from markdown_text import (
    code,
    literal,
    lower_headings,
    page,
    plain,
    table,
    toctree,
    without_links,
)
from messages import write_page as write_messages
from notebooks import titles, write_page
from pictures import plot_closure
from verification import write_page as write_verification

from contbed import closures, fields
from contbed.chemistry.char_and_lime import CHAR_LAWS
from contbed.chemistry.laws.gases import BY_REACTION
from contbed.closures import arguments, registry
from contbed.explain import editor
from contbed.explain.catalogue import laws_by_name, models
from contbed.explain.closure_keys import closure_keys
from contbed.explain.terms import TERMS
from contbed.models import MODELS, kind_of
from contbed.scene import schema
from contbed.scene.library import MATERIALS, data_sheet

ROOT = Path(__file__).parents[2]
THEORY = (
    "The equations of each model, with their assumptions, their discretisation and "
    "their source, as they stand at the "
    "head of the code that solves them."
)
CITE = (
    "Cite the version that `contbed --version` prints, and the sources of the closures "
    "that a run used: they stand in "
    "`summary.json` under `closures`, and in the report. `CITATION.cff` of the project:"
)


def write(folder: Path) -> None:
    """Write all generated pages anew; figures that are there and not older than
    their source are kept.
    """
    for name in ("theory", "reference", "gallery"):
        shutil.rmtree(folder / name, ignore_errors=True)
        (folder / name).mkdir(parents=True)
    (folder / "figures").mkdir(exist_ok=True)
    theory(folder / "theory")
    scenes(folder / "reference")
    correlations(folder / "reference", folder / "figures")
    commands(folder / "reference")
    gallery(folder / "gallery", folder / "figures")
    write_messages(folder / "reference" / "messages.md", ROOT / "contbed")
    glossary(folder)
    results_by_job(folder)
    project_texts(folder)


def docstring(text: str) -> str:
    """Return the text of equations as Markdown: indented blocks and columns are
    literal blocks.
    """
    found = []
    for paragraph in text.split("\n\n")[1:]:
        lines = paragraph.splitlines()
        if not lines:
            continue
        indented = all(line.startswith("    ") or not line for line in lines)
        columns = sum(bool(re.match(r"\S.{0,16}?\s{2,}\S", line)) for line in lines)
        if indented or columns > 0.5 * len(lines):
            found.append(literal(lines))
        else:
            found.append(plain("\n".join(lines)))
    return "\n\n".join(found)


def studies_of(kind: str) -> list[Path]:
    """Return the folders of studies with a scene of a physics."""
    found = []
    for folder in sorted((ROOT / "studies").glob("*/")):
        kinds = set()
        for file in folder.glob("*.toml"):
            values = tomllib.loads(file.read_text(encoding="utf-8"))
            if "scene" not in values:
                kinds.add(kind_of(values))
        if kind in kinds and (folder / "README.md").is_file():
            found.append(folder)
    return found


def checks(readme: str) -> str:
    """Return what the README of a study says of its checks: one paragraph with
    numbers.
    """
    found = re.search(
        r"^(?:\*\*Checks?[^*]*\*\*|The tables are reproduced)(.*?)(?:\n\n|\Z)",
        readme,
        re.DOTALL | re.MULTILINE,
    )
    return found[0].strip().replace("\n", " ") if found else ""


def theory(folder: Path) -> None:
    names = []
    sheets = models()
    for kind, model in MODELS.items():
        parts = []
        for name in model.equations:
            text = sheets[name]
            parts.append(
                f"({name})=\n## {plain(text.partition(chr(10))[0].rstrip('.'))}\n\n"
                + docstring(text)
            )
        rows = []
        for study in studies_of(kind):
            readme = (study / "README.md").read_text(encoding="utf-8")
            title = readme.partition("\n")[0].lstrip("# ")
            rows.append(
                [
                    f"[{title}](../gallery/{study.name}.md)",
                    without_links(checks(readme)),
                ]
            )
        if rows:
            parts.append(
                "## Verified and compared by\n\n"
                + table(["study", "what its README states"], rows)
            )
        if kind == "two_fluid":
            text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
            section = text.partition("### Verification of the two-fluid model")[2]
            parts.append(
                "## Verification by exact cases"
                + re.sub(r"^#+ .*", "", section, flags=re.MULTILINE)
            )
        names.append(kind)
        page(
            folder / f"{kind}.md", f"{kind}: {editor.summary(kind).rstrip('.')}", *parts
        )
    write_verification(folder / "verification.md")
    page(
        folder / "index.md",
        "Theory",
        THEORY,
        toctree(*names, "verification"),
    )


def scenes(folder: Path) -> None:
    for kind, model in MODELS.items():
        root = schema.of(model.scene)
        parts = [
            plain(str(root.get("description", ""))),
            "A scene to begin with, as `contbed new " + kind + "` writes it:",
        ]
        parts.append("```toml\n" + editor.template(kind) + "```")
        for name, node in root["properties"].items():
            parts += list(tables_of(name, node, 0))
        page(folder / f"scene_{kind}.md", f"Keys of a {kind} scene", *parts)
    page(
        folder / "index.md",
        "Reference",
        "Made from the code, so that it is complete and says what this version does.",
        toctree(
            *(f"scene_{kind}" for kind in MODELS),
            "closures",
            "rate_laws",
            "materials",
            "commands",
            "messages",
            "../../api",
        ),
    )


def tables_of(name: str, node: schema.Node, depth: int) -> Iterator[str]:
    """Yield the heading and the keys of a table, then those of the tables in it."""
    below = []
    for option in schema.options(node):
        inner = option.get("additionalProperties")
        if isinstance(inner, dict):
            yield from tables_of(f"{name}.NAME", inner, depth)
            continue
        if (
            "properties" not in option
            or schema.is_closure(option)
            or schema.is_closure_file(option)
        ):
            continue
        rows = []
        for key, child in option["properties"].items():
            tables = [
                part
                for part in schema.options(child)
                if "properties" in part
                or isinstance(part.get("additionalProperties"), dict)
            ]
            tables = [
                part
                for part in tables
                if not schema.is_closure(part) and not schema.is_closure_file(part)
            ]
            text = (
                schema.allowed(child)
                if len(tables) < len(schema.options(child)) or not tables
                else "a table, see below"
            )
            default = (
                "required"
                if key in option.get("required", [])
                else code(shown(child.get("default")))
            )
            rows.append(
                [
                    code(key),
                    plain(text),
                    default,
                    plain(str(child.get("description", ""))),
                ]
            )
            if tables and depth < 3:
                below.append((f"{name}.{key}", child))
        kinds = [
            f' {key} = "{child["const"]}"'
            for key, child in option["properties"].items()
            if "const" in child
        ]
        heading = f"{'##' if depth == 0 else '###'} `[{name}]{''.join(kinds)}`"
        yield f"{heading}\n\n{plain(str(option.get('description', '')))}"
        yield table(["key", "allowed", "default", "meaning"], rows)
    for path, child in below:
        yield from tables_of(path, child, depth + 1)


def shown(value: object) -> str:
    if value is None or value in ([], {}, ""):
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return str(value) if not isinstance(value, dict) else ""


def correlations(folder: Path, figures: Path) -> None:
    kinds = sorted({registry.sheet(name).kind for name in closures.names()})
    (folder / "closures").mkdir()
    for kind in kinds:
        parts = [f"Returns: {plain(arguments.RESULTS.get(kind, kind))}."]
        if named := [place for place, taken in closure_keys().items() if taken == kind]:
            parts.append(
                "Named in scenes by " + ", ".join(code(place) for place in named) + "."
            )
        for name in closures.names(kind):
            parts += list(data_sheet_of(name, figures))
        page(folder / "closures" / f"{kind}.md", kind.replace("_", " "), *parts)
    rows = [
        [
            f"[{kind.replace('_', ' ')}](closures/{kind}.md)",
            plain(arguments.RESULTS.get(kind, "")),
            str(len(closures.names(kind))),
        ]
        for kind in kinds
    ]
    page(
        folder / "closures.md",
        "Closures",
        "`contbed closures --for PLACE --at CONDITIONS` ranks those of one kind.",
        table(["kind", "returns", "number"], rows),
        toctree(*(f"closures/{kind}" for kind in kinds), hidden=True),
    )
    laws = []
    for reaction, table_of in {**BY_REACTION, **CHAR_LAWS}.items():
        rows = [
            [
                code(law),
                plain(f.reaction),
                f"{f.T_range[0]:g} to {f.T_range[1]:g} K",
                f.unit,
                plain(f.source),
            ]
            for law, f in table_of.items()
        ]
        laws.append(
            f"## `{reaction}`\n\n"
            + table(["law", "reaction", "range", "unit", "source"], rows)
        )
    named = [
        [code(name), plain("; ".join(equations))]
        for name, equations in laws_by_name().items()
    ]
    page(
        folder / "rate_laws.md",
        "Rate laws",
        "`[reactions.NAME]` with the name of one of these reactions takes its first law, "
        "or that of `law`.",
        *laws,
        "## For a reaction of any name",
        table(["law", "reaction"], named),
    )
    page(
        folder / "materials.md",
        "Materials",
        "For `material` in `[gas]` and `[solids.NAME]`, and in `[fluid]`.",
        *(f"## `{name}`\n\n```text\n{data_sheet(name)}\n```" for name in MATERIALS),
    )


def data_sheet_of(name: str, figures: Path) -> Iterator[str]:
    sheet = registry.sheet(name)
    yield f"({name})=\n## `{name}`\n\n{plain(sheet.summary)}"
    if sheet.equation:
        yield literal(sheet.equation.splitlines())
    rows = []
    for key in (*sheet.arguments, *sheet.options):
        known = arguments.argument(key, sheet.kind)
        given = sheet.ranges.get(key)
        default = (
            f"{sheet.options[key]:.6g}"
            if isinstance(sheet.options.get(key), float | int)
            else str(sheet.options.get(key, ""))
        )
        rows.append(
            [
                code(key),
                known.unit if known else "",
                plain(known.meaning if known else own_row(sheet.text, key)),
                "" if given is None else f"{given[0]:g} to {given[1]:g}",
                default,
            ]
        )
    yield table(["argument", "unit", "meaning", "range", "default"], rows)
    ratios = [
        f"{key}: {low:g} to {high:g}"
        for key, (low, high) in sheet.ranges.items()
        if "/" in key
    ]
    if ratios:
        yield "Ranges of ratios: " + plain("; ".join(ratios)) + "."
    for title in ("Fitted to", "Limits", "Source"):
        if found := re.search(
            rf"^{title}\n-+\n(.*?)(?:\n\n|\Z)", sheet.text, re.DOTALL | re.MULTILINE
        ):
            yield f"**{title}.** " + plain(" ".join(found[1].split()))
    if (file := plot_closure(name, figures)) is not None:
        yield f"![{name} over its range](../../figures/{file})"


def own_row(text: str, key: str) -> str:
    """Return what a data sheet says of an argument that has its own row."""
    found = re.search(rf"^{key} : \[.+?\] (.*)$", text, re.MULTILINE)
    return found[1] if found else ""


def commands(folder: Path) -> None:
    import typer

    from contbed.cli import app

    group = typer.main.get_command(app)
    parts = []
    for name, command in group.commands.items():
        rows = []
        for option in command.params:
            if option.name in ("help", "install_completion", "show_completion"):
                continue
            flags = (
                ", ".join(option.opts)
                if option.param_type_name == "option"
                else str(option.metavar or option.name)
            )
            rows.append([code(flags), plain(str(getattr(option, "help", "") or ""))])
        parts.append(
            f"## `contbed {name}`\n\n{plain(' '.join(str(command.help or '').split()))}"
        )
        parts.append(table(["argument", "meaning"], rows) if rows else "")
    page(
        folder / "commands.md",
        "Command line",
        "The commands at a glance, and exit codes: "
        "[commands](../../reference/commands.md).",
        *parts,
    )


def gallery(folder: Path, figures: Path) -> None:
    cards = []
    names = []
    for study in sorted((ROOT / "studies").glob("*/README.md")):
        name = study.parent.name
        text = study.read_text(encoding="utf-8")
        shown_first = ""
        for picture in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text):
            source = (study.parent / picture).resolve()
            target = f"{name}-{source.name}"
            shutil.copyfile(source, figures / target)
            text = text.replace(f"]({picture})", f"](../figures/{target})")
            shown_first = shown_first or target
        title, _, body = text.partition("\n")
        page(
            folder / f"{name}.md",
            title.lstrip("# "),
            lower_headings(without_links(body.strip())),
            f"Files: `studies/{name}`. The study is computed anew by `python -m "
            f"studies run {name}`.",
        )
        names.append(name)
        image = f'<img src="../../_images/{shown_first}" alt="">' if shown_first else ""
        cards.append(
            f'<a href="{name}.html">{image}<span>{escape(title.lstrip("# "))}</span></a>'
        )
    shown_notebooks = titles(ROOT / "docs" / "notebooks")
    for name in shown_notebooks:
        write_page(
            ROOT / "docs" / "notebooks" / f"{name}.ipynb",
            folder / f"notebook_{name}.md",
            figures,
        )
    listed = "\n".join(
        f"- [{title}](notebook_{name}.md)" for name, title in shown_notebooks.items()
    )
    html = '<div class="gallery">\n' + "\n".join(cards) + "\n</div>"
    page(
        folder / "index.md",
        "Gallery",
        "## Notebooks",
        listed,
        "## Studies",
        "From their READMEs.",
        "```{raw} html\n" + html + "\n```",
        toctree(*(f"notebook_{name}" for name in shown_notebooks), *names, hidden=True),
    )


def glossary(folder: Path) -> None:
    def rows(entries: Mapping[str, fields.Field]) -> list[list[str]]:
        return [
            [
                code(name),
                "" if entry.unit == "1" else plain(entry.unit),
                plain(entry.description),
            ]
            for name, entry in entries.items()
        ]

    head = ["name", "unit", "meaning"]
    taken = [
        [
            code(name),
            "" if entry.unit == "-" else plain(entry.unit),
            plain(entry.meaning),
        ]
        for name, entry in arguments.ARGUMENTS.items()
    ]
    page(
        folder / "glossary.md",
        "Glossary",
        "## Terms",
        "\n\n".join(
            f"{term}\n: {plain(text)}"
            for term, text in sorted(TERMS.items(), key=lambda item: item[0].lower())
        ),
        "## Fields and columns",
        table(head, rows(fields.FIELDS)),
        "## Named results",
        "The keys of `qoi` in `summary.json`; NAME, PHASE and PLACE are chosen by the "
        "scene.",
        table(head, rows(fields.RESULTS)),
        "## Arguments of closures",
        table(["name", "unit", "meaning"], taken),
    )


def results_by_job(folder: Path) -> None:
    """Write the page of the named results of each kind of job."""
    parts = []
    for job in JOBS:
        found = {name: fields.RESULTS[name] for name in job.results}
        rows = [
            [
                code(name),
                "" if each.unit == "1" else plain(each.unit),
                plain(each.description),
            ]
            for name, each in found.items()
        ]
        parts += [f"## {job.title}", plain(f"Of {job.scenes}.")]
        parts.append(table(["name", "unit", "meaning"], rows))
    page(
        folder / "results.md",
        "Results by kind of job",
        "Named results of a run, in `summary.json`, the report and sweeps; NAME is "
        "chosen by the scene. `contbed explain NAME` tells each as well, and the "
        "[glossary](glossary.md) lists all.",
        *parts,
    )


def project_texts(folder: Path) -> None:
    """Write pages that hold files of the project: the changelog, how it is built,
    how to cite it.
    """
    for name, title in (("CHANGELOG", "Changelog"), ("CONTRIBUTING", "Contributing")):
        text = (ROOT / f"{name}.md").read_text(encoding="utf-8").partition("\n")[2]
        page(folder / f"{name.lower()}.md", title, without_links(text))
    cite = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    page(folder / "cite.md", "How to cite", CITE, "```yaml\n" + cite + "```")
