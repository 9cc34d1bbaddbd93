"""The report of a cascade: each result with its band, the shares of packing, fit,
laws, data and mesh in it.
"""

from __future__ import annotations

from html import escape
from pathlib import Path

from contbed.fields import unit_of
from contbed.many.cascade.band import BAND
from contbed.many.quantities import result
from contbed.report import page
from contbed.report.linked import linked, read_columns
from contbed.report.study import Content, Found, Study, has


def _content(folder: Path, found: Found, made: page.Charts) -> Content:
    samples = read_columns(
        folder / "samples.csv", numbers=[result(name).name for name in found["qoi"]]
    )
    count = len(next(iter(samples.values())).values)
    about = (
        f"{len(found['porosities'])} packings, {count} runs with everything uncertain "
        "at once; "
        f"{found['runs']['asked']} runs in all"
    )
    rows = [f"run {k + 1}" for k in range(count)]
    sections = [
        page.section("What was found", _answer(found), "results"),
        page.warnings(found["warnings"]),
        page.section("What the bands come from", _parts(found), "parts"),
        page.section("Measured points", _measured(found), "measured"),
        page.section("Bands and shares", page.picture(folder / "band.png"), "bands"),
        linked(list(samples.values()), rows).section(
            "Linked plots of the runs with everything uncertain", made.place
        ),
        page.section(
            "What the bed visits and the packings have", _visited(found), "visited"
        ),
    ]
    return Content(
        str(found.get("title") or f"Cascade of {found['cascade']}"), about, sections
    )


def _answer(found: Found) -> str:
    """Return each result at the best values, its band, and mean and standard
    deviation of the runs.
    """
    if not found["qoi"]:
        return ""
    rows = []
    for name, value in found["qoi"].items():
        band, unit = found["band"][name], unit_of(name)
        parts = (band[key] for key in ("low", "high", "mean", "standard_deviation"))
        rows.append([page.code(name), value, *parts, page.unit(unit)])
    share = next(iter(found["band"].values()))["probability"]
    head = [
        "result",
        "at the best values",
        f"{share:.0%} from",
        "to",
        "mean",
        "standard deviation",
        "unit",
    ]
    return page.table(head, rows)


def _shares(found: Found, name: str) -> dict[str, tuple[float, float]]:
    """Return standard deviation and share in the sum of the variances of each part,
    the largest first.
    """
    deviations = {
        part["name"]: float(part["standard_deviation"][name]) for part in found["parts"]
    }
    total = sum(value**2 for value in deviations.values()) or 1.0
    order = sorted(deviations, key=lambda part: -deviations[part])
    return {part: (deviations[part], deviations[part] ** 2 / total) for part in order}


def _parts(found: Found) -> str:
    rows = [
        [
            page.code(name),
            part,
            deviation,
            page.unit(unit_of(name)),
            page.share(share),
        ]
        for name in found["qoi"]
        for part, (deviation, share) in _shares(found, name).items()
    ]
    if not rows:
        return ""
    head = [
        "result",
        "part",
        "standard deviation",
        "unit",
        "share of the sum of the variances",
    ]
    return (
        page.table(head, rows)
        + f"<p class=quiet>Laws of one particle: {escape(found['laws'])}.</p>"
    )


def _measured(found: Found) -> str:
    """Return how many of the measured points the bands hold, and the shares of the
    parts at them.
    """
    about = found.get("measured")
    if not about:
        return ""
    text = (
        f"{about['case']}, {about['points']} points of {about['quantity']}: "
        f"{about['share in the band']:.1%} are in "
        f"the band of {BAND:.0%}, {about['share in the band of a measurement']:.1%} "
        "with their own scatter of "
        f"{page.number(about['uncertainty'])} {about['unit']}"
    )
    order = sorted(about["shares of the parts"].items(), key=lambda item: -item[1])
    rows = [[part, page.share(share)] for part, share in order]
    return f"<p>{escape(text)}.</p>" + page.table(
        ["part", "share of the variances at all points"], rows
    )


def _visited(found: Found) -> str:
    porosities = found["porosities"]
    ends = found["visited"] | {
        "porosity of the packings": (min(porosities), max(porosities))
    }
    rows = ([name, *between] for name, between in ends.items())
    return page.table(["", "from", "to"], rows)


CASCADE = Study("cascade", "cascade", _content, has("cascade"))
