"""The picture of a search: objective, keys and constraints over its evaluations."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from contbed.arrays import Array, Flags
from contbed.many.optimise.evaluations import Evaluation
from contbed.many.optimise.found import Found
from contbed.many.optimise.problem import Design
from contbed.output.colours import COLOURS
from contbed.output.plots import styled_figure

_FAILED = "#B00020"
_SMALLEST = 1e-9  # excess that is drawn, of its largest
_MOST_ITEMS = 8  # of a legend beside a panel of its height


def plot(path: Path, design: Design, found: Found, rows: Sequence[Evaluation]) -> None:
    """Draw the objective, the keys between their bounds and by how much constraints
    are missed.
    """
    numbers = np.arange(1.0, len(rows) + 1.0)
    computed = np.array([row.functions is not None for row in rows])
    functions = np.full((len(rows), 1 + len(design.constraints)), np.nan)
    functions[computed] = [row.values for row in rows if row.functions is not None]
    panels = 2 + bool(design.constraints)
    with styled_figure(path, 1.0 + 2.3 * panels, design.title) as figure:
        axes = figure.subplots(panels, 1, sharex=True)
        _objective(
            axes[0],
            design,
            numbers,
            design.sign * functions[:, 0],
            _feasible(design, functions),
        )
        _keys(axes[1], design, numbers, rows)
        if design.constraints:
            _constraints(axes[2], design, numbers, functions[:, 1:])
        best = 1 + next(k for k, row in enumerate(rows) if row is found.evaluation)
        for panel in axes:
            panel.axvline(best, color="0.7", linewidth=0.8, zorder=0)
            if not computed.all():
                panel.plot(
                    numbers[~computed], np.zeros((~computed).sum()), "x", color=_FAILED, markersize=5,
                    transform=panel.get_xaxis_transform(), clip_on=False, label="run failed",
                )  # fmt: skip
            panel.margins(x=0.02)
            _legend(panel)
        axes[-1].set_xlabel("evaluation")
        axes[-1].xaxis.get_major_locator().set_params(integer=True)


def _feasible(design: Design, functions: Array) -> Flags:
    """Return which points keep all constraints, to a millionth of the largest excess
    of each.
    """
    excess = functions[:, 1:].copy()
    excess[:, design.equality] = np.abs(excess[:, design.equality])
    size = np.nanmax(np.abs(excess), axis=0, initial=0.0)
    found: Flags = (excess <= 1e-6 * size).all(axis=1) & np.isfinite(functions[:, 0])
    return found


def _objective(
    panel: Any, design: Design, numbers: Array, values: Array, feasible: Any
) -> None:
    panel.plot(numbers, values, "-", color="0.8", linewidth=1.0, zorder=0)
    for chosen, face, label in (
        (feasible, COLOURS[0], "feasible"),
        (~feasible, "white", "constraints missed"),
    ):
        if np.isfinite(values[chosen]).any():
            panel.plot(
                numbers[chosen],
                values[chosen],
                "o",
                color=COLOURS[0],
                markerfacecolor=face,
                markersize=4,
                label=label,
            )
    panel.set_ylabel(_folded(design.objective.text, design.objective.unit))


def _keys(
    panel: Any, design: Design, numbers: Array, rows: Sequence[Evaluation]
) -> None:
    points = np.array([row.point for row in rows])
    for k, key in enumerate(design.keys):
        share = (points[:, k] - key.low) / key.span
        label = (
            f"{key.name}, {key.low:.3g} to "
            f"{key.high:.3g}{'' if key.unit == '1' else f' {key.unit}'}"
        )
        panel.plot(
            numbers,
            share,
            "o-",
            markersize=3,
            linewidth=1.2,
            color=COLOURS[k % len(COLOURS)],
            label=label,
        )
    panel.set(ylim=(-0.05, 1.05), ylabel="key, lower bound 0,\nupper bound 1")


def _constraints(panel: Any, design: Design, numbers: Array, excess: Array) -> None:
    for k, one in enumerate(design.constraints):
        missed = (
            np.abs(excess[:, k]) if one.sign == "==" else np.maximum(excess[:, k], 0.0)
        )
        size = np.nanmax(np.abs(excess[:, k])) or 1.0
        shown = np.maximum(missed / size, _SMALLEST)
        panel.plot(
            numbers,
            shown,
            "o-",
            markersize=3,
            linewidth=1.2,
            color=COLOURS[k % len(COLOURS)],
            label=one.text,
        )
    panel.set(
        yscale="log",
        ylim=(0.5 * _SMALLEST, 2.0),
        ylabel="constraint missed by,\nof the largest",
    )


def _legend(panel: Any) -> None:
    if len(panel.get_legend_handles_labels()[0]) <= _MOST_ITEMS:
        panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=8)


def _folded(text: str, unit: str) -> str:
    shown = text if len(text) <= 28 else "objective"
    return shown if unit == "1" else f"{shown}\n[{unit}]"
