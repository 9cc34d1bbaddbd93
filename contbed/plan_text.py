"""The text of a plan: what is built and left out, its unknowns and their memory."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from contbed.models import Plan, model_of
from contbed.scene.toml_lines import dotted

Rows = tuple[tuple[str, str], ...]


def built_and_skipped(parts: Iterable[tuple[str, str, bool]]) -> tuple[Rows, Rows]:
    """Return what is built, with how, and what is left out, with why, of parts
    (what, how or why, whether it is built).
    """
    found = list(parts)
    built = tuple((what, how) for what, how, there in found if there)
    skipped = tuple((what, why) for what, why, there in found if not there)
    return built, skipped


def plan_text(plan: Plan, *more: str) -> str:
    """Describe a plan as a table.

    The unknowns with their memory, further lines and warnings follow.
    """
    from contbed.output.sketch import sketch, text_of
    from contbed.scene.identity import resolved

    rows = [("MODEL", model_of(plan.scene).name, _reason_for_the_model(plan.scene))]
    rows += [("BUILT", what, why) for what, why in plan.built]
    rows += [("SKIPPED", what, why) for what, why in plan.skipped]
    rows += [
        ("IGNORED", dotted(path), "only other models have this key")
        for path in plan.scene.ignored
    ]
    width = max(len(what) for _, what, _ in rows)
    lines = [f"{state:8}{what:{width}}  {why}" for state, what, why in rows]
    for part, size in plan.unknowns().items():
        if size:
            megabytes = max(1.0, 1e3 * plan.policy.predicted_GB(size))
            lines.append(f"{part}: {size} unknowns, about {megabytes:.0f} MB")
    warnings = [f"WARNING {text}" for text in plan.scene.warnings]
    bed = sketch(model_of(plan.scene).name, resolved(plan.scene))
    drawing = [text_of(bed), ""] if bed is not None else []
    return "\n".join([*drawing, *lines, *more, *warnings])


def _reason_for_the_model(scene: Any) -> str:
    return "derived from the tables" if scene.model is None else "as the scene says"


def percent(share: float) -> str:
    """Return a share in percent, in two digits.

    >>> percent(0.0333), percent(2e-9)
    ('3.3 %', '< 0.01 %')
    """
    return "< 0.01 %" if share < 1e-4 else f"{100.0 * share:.2g} %"
