"""The plot of each closure over its range, around the values of the example in its
docstring.
"""

from __future__ import annotations

import ast
import hashlib
import inspect
import math
from pathlib import Path
from typing import Any

import numpy as np

from contbed.closures import arguments, registry

# an argument without a bound is varied by this factor to both sides of its value in the
# example
SPAN = 10.0
POINTS = 120
DPI = 80


def example(name: str) -> dict[str, float]:
    """Return the arguments of the first call of a closure in the examples of its
    data sheet.
    """
    text = registry.sheet(name).text
    lines = "\n".join(
        line.strip()[4:]
        for line in text.splitlines()
        if line.strip().startswith((">>> ", "... "))
    )
    try:
        tree = ast.parse(lines)
    except SyntaxError:
        return {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == name:
            try:
                found = {
                    key.arg: ast.literal_eval(key.value)
                    for key in node.keywords
                    if key.arg
                }
            except ValueError:
                continue
            return {
                key: float(value)
                for key, value in found.items()
                if isinstance(value, int | float)
            }
    return {}


def varied(
    name: str, given: dict[str, float]
) -> tuple[str, np.ndarray[Any, Any], bool] | None:
    """Return the argument that a plot varies, its values, and whether its axis is
    logarithmic.
    """
    sheet = registry.sheet(name)
    candidates = [key for key in (*sheet.ranges, *sheet.arguments) if key in given]
    for key in candidates:
        low, high = sheet.ranges.get(key, (-math.inf, math.inf))
        value = given[key]
        low = low if math.isfinite(low) else value / SPAN
        high = high if math.isfinite(high) else value * SPAN
        if value > 0.0 and low == 0.0 and high / value > 3.0 * SPAN:
            low = value / SPAN
        high = min(high, 1e3 * value) if value > 0.0 else high
        if not low < high:
            continue
        if low > 0.0 and high / low > SPAN:
            return key, np.geomspace(low, high, POINTS), True
        margin = 1e-3 * (high - low)  # many closures are singular at an end
        return key, np.linspace(low + margin, high - margin, POINTS), False
    return None


def plot_closure(name: str, folder: Path) -> str | None:
    """Draw a closure over its range; return the file, or None where its example
    gives no numbers to begin with.
    """
    given = example(name)
    function = registry.get(name)
    choice = varied(name, given)
    if choice is None:
        return None
    key, values, logarithmic = choice
    stamp = hashlib.sha256(
        (
            inspect.getsource(function) + Path(__file__).read_text(encoding="utf-8")
        ).encode()
    ).hexdigest()[:8]
    file = folder / f"{name}-{stamp}.png"
    if file.exists():
        return file.name
    with np.errstate(all="ignore"):
        try:
            result = np.array(
                [float(function(**{**given, key: float(value)})) for value in values]
            )
        except (TypeError, ValueError, ZeroDivisionError):
            return None
    if not np.isfinite(result).any():
        return None
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(4.6, 2.9), layout="constrained")
    axes.plot(values, result, color="#0072b2")
    if logarithmic:
        axes.set_xscale("log")
        if (result > 0.0).all() and result.max() > SPAN * result.min():
            axes.set_yscale("log")
    sheet = registry.sheet(name)
    known = arguments.argument(key, sheet.kind)
    axes.set_xlabel(
        key if known is None or known.unit == "-" else f"{key} [{known.unit}]"
    )
    axes.set_ylabel(
        sheet.kind.replace("_", " ")
        + ("" if sheet.unit == "-" else f"\n[{sheet.unit}]")
    )
    others = ", ".join(
        f"{other} = {value:g}" for other, value in given.items() if other != key
    )
    axes.set_title(others if len(others) < 70 else others[:67] + "...", fontsize=8)
    axes.grid(alpha=0.3)
    figure.savefig(file, dpi=DPI)
    pyplot.close(figure)
    return file.name
