"""Run time against error beside finite volumes and NGSolve; the programs are in
bench/bench.toml.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from contbed.many.bench import HEADERS, bench
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
OWN = "contbed"  # cases whose name begins so are ours
NOT_COMPARED = HEADERS[2:]


def reference() -> Table:
    """The committed rows of the other programs."""
    table = Table.read(HERE / "bench.csv")
    return Table(
        dict.fromkeys(HEADERS, ""),
        [row for row in table.rows if not row[1].startswith(OWN)],
    )


def compute() -> Tables:
    """All programs that are installed, in one go."""
    with TemporaryDirectory() as out:
        print(bench(HERE, out, trust=True))
        return {"bench": Table.read(Path(out) / "bench.csv")}


def plot(tables: Tables) -> dict[str, Any]:
    """Run time over error of the slip row."""
    figure, axes = gallery.figure(size=(8, 5))
    table = tables["bench"]
    curves = table.where({"part": table.values("part")[0]})
    for name, colour in zip(curves.values("case"), gallery.PALETTE, strict=False):
        points = curves.where({"case": name})
        known = points["unknowns"] > 0
        axes.loglog(
            points["error"][known],
            1e3 * points["user_s"][known],
            "o-",
            color=colour,
            label=name,
        )
    axes.set(xlabel=r"largest error of $\theta$", ylabel="user time [ms]")
    figure.legend(loc="outside right upper")
    return {"bench": figure}
