"""Markdown for the generated pages: pages, tables, escaped text, links and headings
of files of the project.
"""

from __future__ import annotations

import re
from pathlib import Path
from textwrap import dedent


def page(file: Path, title: str, *parts: str) -> None:
    file.write_text(
        "\n\n".join([f"# {title}", *(part for part in parts if part)]) + "\n",
        encoding="utf-8",
    )


def toctree(*names: str, hidden: bool = False) -> str:
    option = ":hidden:\n" if hidden else ":maxdepth: 1\n"
    return "```{toctree}\n" + option + "\n" + "\n".join(names) + "\n```"


def table(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(
        "| "
        + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in row)
        + " |"
        for row in lines
    )


def code(text: str) -> str:
    return f"`{text}`" if text else ""


def plain(text: str) -> str:
    """Return a text of a docstring as Markdown: what Markdown would read as its own
    is escaped.
    """
    parts = re.split(r"(`[^`]*`)", text)
    return "".join(
        part if part.startswith("`") else re.sub(r"([*_<>\[\]#|\\])", r"\\\1", part)
        for part in parts
    )


def without_links(text: str) -> str:
    """Return Markdown whose links to files of the project are their texts; those to
    the web stay.
    """
    return re.sub(r"(?<!!)\[([^\]]+)\]\((?!https?:)[^)]+\)", r"\1", text)


def lower_headings(text: str) -> str:
    """Return Markdown whose headings follow each other without a gap below that of
    the page.
    """
    levels = [len(found) for found in re.findall(r"^(#+) ", text, re.MULTILINE)]
    shift = 2 - min(levels) if levels else 0
    return re.sub(
        r"^(#+) ",
        lambda match: "#" * max(2, len(match[1]) + shift) + " ",
        text,
        flags=re.MULTILINE,
    )


def literal(lines: list[str]) -> str:
    """Return lines as a literal block, without their common indentation."""
    return "```text\n" + dedent("\n".join(lines)) + "\n```"
