"""Docstrings of the package for napoleon: `name : meaning` in one line becomes a
name with its meaning below.
"""

from __future__ import annotations

import re
from typing import Any

SECTIONS = ("Parameters", "Raises", "Attributes")


def split(
    app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]
) -> None:
    section = ""
    changed: list[str] = []
    for k, line in enumerate(lines):
        if k + 1 < len(lines) and re.fullmatch(r"-{3,}", lines[k + 1]):
            section = line.strip()
        found = re.fullmatch(r"(\S.*?) : (.+)", line) if section in SECTIONS else None
        if found and section == "Raises":
            for error in found[1].split(", "):
                changed += [error, f"    {found[2]}"]
        elif found:
            changed += [found[1], f"    {found[2]}"]
        else:
            changed.append(line)
    lines[:] = changed


def setup(app: Any) -> dict[str, bool]:
    app.connect("autodoc-process-docstring", split, priority=400)  # before napoleon
    return {"parallel_read_safe": True, "parallel_write_safe": True}
