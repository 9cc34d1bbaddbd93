"""The command `contbed sweep`: run every scene of a study that has no outcome yet, then
write the table and the plots.

All data of a sweep is in its folder: an interrupted sweep continues with the same
command.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from contbed.errors import SceneError
from contbed.many.runs import compute, give_up, is_begun, is_damaged, known
from contbed.many.store import Content, locked
from contbed.many.study_file import relocated
from contbed.many.sweep import table
from contbed.many.sweep.study import Study, read_study
from contbed.many.sweep.table import Row
from contbed.many.workers import computed
from contbed.output.folder import prepare_study
from contbed.output.progress import Progress
from contbed.scene.names import nearest


@dataclass(frozen=True)
class Sweep:
    """The runs of a sweep in the order of the study, how many of them existed
    before, and warnings.
    """

    rows: list[Row]
    before: int
    warnings: tuple[str, ...]
    study: Study

    @property
    def failed(self) -> list[Row]:
        """The runs that failed."""
        return [row for row in self.rows if row.exit_code]

    def failures(self, most: int = 20) -> list[str]:
        """Return a line for each run that failed, with its parameters, exit code and
        problem.
        """
        lines = [
            f"failed with {row.exit_code}: "
            f"{', '.join(f'{k} = {v}' for k, v in row.parameters.items())}: "
            f"{row.problem}"
            for row in self.failed[:most]
        ]
        rest = len(self.failed) - most
        return [*lines, f"{rest} more failed, see table.csv"] if rest > 0 else lines


def sweep(
    study: str | Path,
    out: str | Path | None = None,
    jobs: int = -1,
    retry_failed: bool = False,
    quiet: bool = True,
    trust: bool = False,
    allow_large: bool = False,
) -> Sweep:
    """Run a study; all its scenes are checked first.

    Parameters
    ----------
    study : its TOML file
    out : folder for runs, table and plots; results/STUDY if absent
    jobs : processes on this machine, -1 for one a core; 1 computes in this process
    retry_failed : compute the failed runs again
    quiet : no progress bar
    trust, allow_large : as in `contbed.loading.load`

    Raises
    ------
    SceneError : mistakes in the study or its scenes, before anything is written; a name
        in `qoi` that no run has
    ContbedError : the folder cannot be written, or no process can compute
    """
    todo = read_study(study, trust, allow_large)
    folder = (Path(out) if out else Path("results") / todo.file.stem).absolute()
    prepare_study(
        folder, "table.csv", "table.json", "sweep.png", "uncertainty.*", "indices.csv"
    )
    outcomes: dict[str, Content] = {}
    for case in todo.cases:
        if (found := known(case, folder, retry_failed)) is not None:
            outcomes[case.name] = found
    before = len(outcomes)
    damaged = [
        case.name
        for case in todo.cases
        if case.name not in outcomes and is_damaged(case, folder)
    ]
    warnings = [
        f"runs/{name}: outcome.json is not as it was written; the run is computed again"
        for name in damaged
    ]
    try:
        with Progress(len(todo.cases), "runs", quiet) as progress:
            waiting = [
                (case, folder) for case in todo.cases if case.name not in outcomes
            ]
            for (case, _), outcome in computed(
                compute,
                waiting,
                jobs,
                begun=lambda task: is_begun(*task),
                lost=lambda task: give_up(*task),
            ):
                outcomes[case.name] = outcome
                failed = sum(
                    bool(outcome["exit_code"]) for outcome in outcomes.values()
                )
                progress.advance_to(len(outcomes), f"{failed} failed" if failed else "")
    finally:
        ended = (
            (case, outcomes.get(case.name) or known(case, folder))
            for case in todo.cases
        )
        rows = [
            Row(
                case.name,
                case.parameters,
                found["qoi"],
                found["exit_code"],
                relocated(found["problem"], todo.parameters)[1],
            )
            for case, found in ended
            if found is not None
        ]
        with _alone(folder):
            table.write(folder, todo, rows)
    _require_known(todo, rows)
    from contbed.many.sweep.plots import plot

    with _alone(folder):
        plot(folder / "sweep.png", todo, rows)
    return Sweep(rows, before, (*todo.warnings, *warnings), todo)


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Lock the sweep while the table is written, because another sweep of the study
    may end at the same time.
    """
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        with locked(descriptor):
            yield
    finally:
        os.close(descriptor)


def _require_known(todo: Study, rows: list[Row]) -> None:
    """Raise SceneError for names to plot that no run has, unless every run failed."""
    results = [quantity.key for quantity in table.columns(todo, rows)[1]]
    missing = [name for name in todo.qoi if name not in results]
    if results and missing:
        raise SceneError(
            [
                f'{todo.qoi_at}: qoi: no run has the result "{name}"; '
                f"{nearest(name, results)}"
                for name in missing
            ]
        )
