"""Formulas as MathML, which browsers show by themselves: the manual needs no script and no network."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from latex2mathml.converter import convert


def inline(writer: Any, node: Any) -> None:
    writer.body.append(convert(node.astext()))
    raise nodes.SkipNode


def block(writer: Any, node: Any) -> None:
    lines = [line for line in node.astext().split("\n") if line.strip()]
    body = "".join(f'<div class="line">{convert(line, display="block")}</div>' for line in lines)
    writer.body.append(f'<div class="math">{body}</div>\n')
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, bool]:
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
