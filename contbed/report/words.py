"""The first lines of a report: what was found, how sure it is, and what to look at
next, in sentences.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from html import escape
from typing import Any

from contbed import fields
from contbed.report.read import Run

# named results in the order of a report, each with its sentence; {} is the
# value with its unit, {name} the part of the result's name that the scene chooses
SENTENCES = {
    "boiler_efficiency": "The boiler has an efficiency of {}.",
    "combustion_efficiency": "{} of the heat of combustion of the fuel is released.",
    "heat_charged_J": "The store takes up {}.",
    "heat_discharged_J": "It gives {} back.",
    "storage_efficiency": "This is {} of what it took up.",
    "utilisation": "It uses {} of its capacity.",
    "breakthrough_NAME_s": "{name} breaks through after {}.",
    "purity_NAME": "{name} is won with a purity of {}.",
    "recovery_NAME": "{} of the {name} that enters is won.",
    "conversion_NAME": "{} of the {name} that enters reacts.",
    "hot_spot_K": "The hottest place of the bed has {}.",
    "metallization": "{} of the iron leaves as metal.",
    "T_fluid_out_K": "The gas leaves at {}.",
    "T_gas_out_K": "The gas leaves at {}.",
    "T_solid_out_K": "The particles leave at {}.",
    "T_NAME_mid_K": "Half up the bed the solid phase {name} has {}.",
    "T_solid_NAME_out_K": "The solid phase {name} leaves at {}.",
    "duty_W": "The gas takes up {}.",
    "effectiveness": "This is {} of what the streams could exchange.",
    "k_eff [W/m/K]": "The packing conducts {}.",
    "u_over_u_mf": "The gas enters at {} times the velocity of minimum fluidization.",
    "bed_height_m": "The bed is {} high.",
    "pressure_drop_mean [Pa]": "Its mean pressure drop is {}.",
    "mass_fraction_end": "{} of the mass of the particle is left at the end.",
    "half_time_s": "Half of the mass that is lost is lost after {}.",
    "pressure_drop_Pa": "The pressure of the gas falls by {}.",
}
SHARES = re.compile(
    "efficiency|utilisation|purity|recovery|conversion|metallization|effectiveness"
    "|mass_fraction_end"
)
PREFIXED = ("W", "J", "Pa", "W/m2", "J/m2")
MOST = 6  # sentences about results


def words(run: Run) -> str:
    """Return three paragraphs: what was found, how sure it is, what to look at next."""
    parts = (
        ("Found", found(run.summary)),
        ("How sure", sure(run.summary)),
        ("Next", following(run.summary)),
    )
    return "".join(
        f"<p><b>{title}.</b> {_with_code(' '.join(sentences))}</p>"
        for title, texts in parts
        if (sentences := list(texts))
    )


def _with_code(text: str) -> str:
    return re.sub("`([^`]+)`", r"<code>\1</code>", escape(text))


def found(summary: Mapping[str, Any]) -> Iterator[str]:
    """Yield sentences about the results that a reader asks for first."""
    if summary.get("status") != "ok":
        yield "The run did not end well, and its results are those of its last state."
    count = 0
    results = summary.get("qoi", {})
    for pattern, sentence in SENTENCES.items():
        form = re.compile(re.escape(pattern).replace("NAME", "(.+)"))
        for key, value in results.items():
            match = form.fullmatch(key)
            if match is None or not isinstance(value, int | float) or count >= MOST:
                continue
            unit = summary.get("units", {}).get(key) or fields.unit_of(key) or "1"
            name = match[1] if match.groups() else ""
            yield sentence.format(amount(key, float(value), unit), name=name)
            count += 1


def sure(summary: Mapping[str, Any]) -> Iterator[str]:
    """Yield sentences about balances, the numerical error and the closures' ranges."""
    open_by = [
        balance["relative_residual"]
        for balance in summary.get("balances", {}).values()
        if balance.get("relative_residual") is not None
    ]
    if open_by:
        yield f"All balances close to {max(map(abs, open_by)):.1g} of their flows."
    error = summary.get("qoi", {}).get("estimated_error")
    if isinstance(error, int | float):
        yield f"The mesh leaves an estimated error of {100 * error:.2g} %."
    closures = summary.get("closures", [])
    beyond = [each["name"] for each in closures if each.get("share_outside")]
    if beyond:
        yield f"These closures are used outside of their range: {', '.join(beyond)}."
    elif closures:
        yield "Each closure is used within its range."


def following(summary: Mapping[str, Any]) -> Iterator[str]:
    """Yield what the reader does next, by what is least sure."""
    closures = summary.get("closures", [])
    if summary.get("warnings"):
        count = len(summary["warnings"])
        yield f"Read the warning{'s' if count > 1 else ''} below."
    if any(each.get("share_outside") for each in closures):
        yield (
            "Compare with another closure: `contbed closures --for KEY` ranks those "
            "that fit."
        )
    if "estimated_error" not in summary.get("qoi", {}):
        yield (
            "See what the mesh changes: `contbed converge SCENE` where profiles run "
            "along a bed, else a run with `--set mesh.refine=1`."
        )
    if closures:
        yield (
            "See what the closures leave uncertain: `contbed sensitivities SCENE "
            "--qoi RESULT` names the keys that matter."
        )


def amount(name: str, value: float, unit: str) -> str:
    """Return a value with its unit as a reader writes it: 21.4 kW, 63 %, 966 K.

    >>> amount("duty_W", 20949.9, "W"), amount("conversion_CH4", 0.6312, "1")
    ('20.9 kW', '63.1 %')
    """
    if SHARES.search(name) and unit == "1":
        return f"{100.0 * value:.3g} %"
    if unit in PREFIXED:
        for size, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
            if abs(value) >= size:
                return f"{value / size:.3g} {prefix}{unit}"
    digits = 4 if unit == "K" else 3
    text = f"{value:.0f}" if 1e3 <= abs(value) < 1e6 else f"{value:.{digits}g}"
    return text + fields.behind(unit)
