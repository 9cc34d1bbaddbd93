"""One reactor by several models, side by side: `contbed compare SCENE --models A,B`.

Each model reads the same file and ignores the keys that only others have, see
`scene.other_models`. Its run is an ordinary one in the folder of its name. The
comparison lists the results that more than one model has (`output.common_results`),
their differences to the first model, the time of each run and what each leaves out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from contbed.errors import ContbedError, SceneError
from contbed.fields import labelled
from contbed.loading import load
from contbed.many.tables import aligned, write_rows
from contbed.models import MODELS, names
from contbed.output.common_results import Value, common_results
from contbed.output.folder import prepare_study
from contbed.output.progress import say
from contbed.runner import run
from contbed.scene.names import nearest, several
from contbed.scene.tables import SceneBase
from contbed.scene.toml_lines import dotted

TABLE = "comparison.csv"
TIME = "wall time [s]"


@dataclass(frozen=True)
class Outcome:
    """The run of one model.

    results : by common name
    ignored : keys of the file that only other models have
    problem : what stopped the run; empty if nothing did
    warnings : of the run, without those on keys that are ignored
    """

    model: str
    results: Mapping[str, Value] = field(default_factory=dict)
    seconds: float = 0.0
    unknowns: int = 0
    ignored: tuple[str, ...] = ()
    skipped: tuple[tuple[str, str], ...] = ()
    problem: str = ""
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Comparison:
    """The runs of all models, in the order asked for."""

    outcomes: tuple[Outcome, ...]

    @property
    def shared(self) -> dict[str, Value]:
        """The quantities that more than one model has, with the first value of each."""
        found: dict[str, Value] = {}
        for outcome in self.outcomes:
            for name, value in outcome.results.items():
                count = sum(name in other.results for other in self.outcomes)
                if count > 1:
                    found.setdefault(name, value)
        return found

    def difference(self, name: str, outcome: Outcome) -> float | None:
        """Return how far a result is from that of the first model that has it, relative
        to it.

        None for that model itself, for one without the result, where the first is 0,
        and where both are means over different times.
        """
        first = next(each for each in self.outcomes if name in each.results)
        reference, found = first.results[name], outcome.results.get(name)
        if outcome is first or found is None or reference.value == 0.0:
            return None
        if _apart(reference, found):
            return None
        return (found.value - reference.value) / abs(reference.value)

    def text(self) -> str:
        """Return the comparison as a table for a terminal."""
        rows = [("", *(outcome.model for outcome in self.outcomes))]
        for name, value in self.shared.items():
            cells = (self._cell(name, outcome) for outcome in self.outcomes)
            rows.append((labelled(name, value.unit), *cells))
        rows.append((TIME, *(f"{outcome.seconds:.3g}" for outcome in self.outcomes)))
        rows.append(("unknowns", *(str(outcome.unknowns) for outcome in self.outcomes)))
        lines = aligned(rows, left=(0,))
        for name, value in self.shared.items():
            lines += [
                f"{name}: of {outcome.model} in the mean since {found.since:g} s, of the "
                f"first since {value.since:g} s: take time.average_from away to compare"
                for outcome in self.outcomes
                if (found := outcome.results.get(name)) and _apart(value, found)
            ]
        for outcome in self.outcomes:
            lines += ["", f"{outcome.model}:"]
            lines += [f"  failed: {outcome.problem}"] if outcome.problem else []
            lines += [f"  warning: {text}" for text in outcome.warnings]
            lines += [f"  leaves out {what}: {why}" for what, why in outcome.skipped]
            lines += (
                [f"  ignores {', '.join(outcome.ignored)}"] if outcome.ignored else []
            )
        return "\n".join(lines)

    def _cell(self, name: str, outcome: Outcome) -> str:
        if name not in outcome.results:
            return "-"
        difference = self.difference(name, outcome)
        shown = f"{outcome.results[name].value:.6g}"
        return shown if difference is None else f"{shown} ({100.0 * difference:+.2g} %)"

    def write(self, out: Path) -> None:
        """Write comparison.csv into a folder: a quantity each row, a column for each
        model.
        """
        rows: list[list[Any]] = []
        for name, first in self.shared.items():
            values = [outcome.results.get(name) for outcome in self.outcomes]
            cells = ["" if value is None else f"{value.value:.12g}" for value in values]
            rows.append([labelled(name, first.unit), *cells])
        rows.append([TIME, *(f"{outcome.seconds:.3g}" for outcome in self.outcomes)])
        head = ["quantity", *(outcome.model for outcome in self.outcomes)]
        write_rows(out / TABLE, head, rows)


def _apart(one: Value, other: Value) -> bool:
    """Whether both are means over different times."""
    return None not in (one.since, other.since) and one.since != other.since


def compare(
    scene: str | Path,
    models: str | Sequence[str],
    out: Path,
    overrides: Mapping[str, Any] | None = None,
    *,
    quiet: bool = True,
    trust: bool = False,
    allow_large: bool = False,
) -> Comparison:
    """Run one file by several models; a model that fails leaves the others their runs.

    Parameters
    ----------
    scene : a TOML file
    models : names of models, see `contbed.models.names`
    out : folder; each model writes into a folder of its name in it
    overrides : values of keys, such as {"mesh.refine": 1}
    quiet : do not show which model runs, nor its progress

    Raises
    ------
    SceneError : a model does not exist, or the file cannot be a scene of it
    """
    chosen = several(models)
    unknown = [model for model in chosen if model not in names()]
    if unknown:
        name = unknown[0]
        text = f"unknown choice; {nearest(name, names())}"
        if name in MODELS:
            kind = MODELS[name]
            text = (
                f"it is a {kind.name} by {kind.decides}, which one file has or has not"
            )
        raise SceneError(f"--models: {name!r}: {text}")
    given = dict(overrides or {})
    scenes = {
        model: load(
            scene, {**given, "model": model}, trust=trust, allow_large=allow_large
        )
        for model in chosen
    }
    prepare_study(out, TABLE)
    outcomes = []
    for count, (model, loaded) in enumerate(scenes.items(), 1):
        if not quiet:
            say(f"{model}: run {count} of {len(scenes)}")
        outcomes.append(_outcome(model, loaded, out / model, quiet))
    found = Comparison(tuple(outcomes))
    found.write(out)
    return found


def _outcome(model: str, scene: SceneBase, folder: Path, quiet: bool) -> Outcome:
    ignored = tuple(dotted(path) for path in scene.ignored)
    try:
        result = run(scene, folder, quiet=quiet)
    except ContbedError as error:
        return Outcome(model, ignored=ignored, problem=str(error))
    tables = {"profiles": result.profiles, **result.tables}
    time = getattr(scene, "time", None)
    since = None if time is None else getattr(time, "average_from", None) or 0.0
    return Outcome(
        model,
        common_results(
            result.qoi, tables, tuple(getattr(scene, "solids", ())), result.units, since
        ),
        result.timings["total"],
        sum(result.plan.unknowns().values()),
        ignored,
        tuple(result.plan.skipped),
        warnings=tuple(
            text for text in result.warnings if "is ignored: only" not in text
        ),
    )
