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
from contbed.report.linked import linked, read_columns, table_of
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
    parts = read_columns(folder / "table.csv", ("part",)).values()
    laws = f"<p class=quiet>Laws of one particle: {escape(found['laws'])}.</p>"
    sections = [
        page.section("What was found", _answer(found), "results"),
        page.warnings(found["warnings"]),
        page.section("What the bands come from", table_of(parts) + laws, "parts"),
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
    return page.records(
        {
            "result": page.code(name),
            "unit": page.unit(unit_of(name)),
            "at the best values": value,
            **found["band"][name],
        }
        for name, value in found["qoi"].items()
    )


def _measured(found: Found) -> str:
    """Return how many of the measured points the bands hold."""
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
    return f"<p>{escape(text)}.</p>"


def _visited(found: Found) -> str:
    porosities = found["porosities"]
    ends = found["visited"] | {
        "porosity of the packings": (min(porosities), max(porosities))
    }
    rows = ([name, *between] for name, between in ends.items())
    return page.table(["", "from", "to"], rows)


CASCADE = Study("cascade", "cascade", _content, has("cascade"))
