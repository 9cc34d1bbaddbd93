"""Sweeps as studies: run one sweep file and get its table and the summaries of its
runs.
"""

from __future__ import annotations

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from studies._gallery.table import Table

# the last columns of a sweep's table name the run, its exit code and its message
RUN_COLUMNS = 3


def swept(file: Path) -> tuple[Table, list[dict[str, Any]]]:
    """Run all scenes of a sweep; return parameters and results, and summary.json of
    each run.
    """
    from contbed.many.sweep.sweep import sweep

    with TemporaryDirectory() as out:
        sweep(file, out, quiet=False)
        whole = Table.read(Path(out) / "table.csv")
        paths = sorted(Path(out).glob("runs/*/summary.json"))
        summaries = [json.loads(path.read_text(encoding="utf-8")) for path in paths]
    columns = dict.fromkeys(whole.columns[:-RUN_COLUMNS], "")
    return Table(columns, [row[:-RUN_COLUMNS] for row in whole.rows]), summaries
