"""Many scenes from one study file: every combination of the listed values, in parallel, resumable.

    scene = "base.toml"

    [parameters]
    "flow.velocity_solid" = [-0.001, -0.002]
    "bed.particle_diameter" = ["3 mm", "6 mm"]

Each run has a folder named by the content hash of its scene, so that a changed value is a new run and a finished one is
never repeated. `sweep.csv` holds the parameters and the named results of all runs, failures with their reason.
"""

from __future__ import annotations

import csv
import io
import json
import os
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from math import prod
from pathlib import Path
from typing import Any

from contbed.errors import ContbedError, SceneError
from contbed.scene import reference
from contbed.scene.loading import load, scene_hash
from contbed.scene.settings import Scene
from contbed.scene.toml_lines import dotted, one_line, parse_key, read

MOST_RUNS = 100_000


@dataclass(frozen=True)
class Row:
    """One run: the values of its parameters, its folder, and its named results or why it failed."""

    parameters: Mapping[str, Any]
    run: str
    qoi: Mapping[str, Any]
    problem: str = ""


def sweep(study: str | Path, jobs: int = 1, out: str | Path | None = None, progress: bool = False) -> list[Row]:
    """Run a study and write `sweep.csv`; `jobs` -1 means all processors. All scenes are checked first."""
    from joblib import Parallel, delayed, parallel_config

    study = Path(study)
    folder = Path(out) if out else Path("results") / study.stem
    cases = {scene_hash(scene): (parameters, scene) for parameters, scene in _cases(study)}
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    # One thread for each process: many small runs side by side are faster than one on all processors.
    with parallel_config(backend="loky", inner_max_num_threads=1):
        finished = Parallel(n_jobs=jobs, return_as="generator")(
            delayed(_run)(scene, folder / name) for name, (_, scene) in cases.items()
        )
        for (name, (parameters, _)), (qoi, problem) in zip(cases.items(), finished, strict=True):
            rows.append(Row(parameters, name, qoi, problem))
            if progress:
                _report(len(rows), len(cases), rows[-1])
            # Written after every run: an interrupted sweep leaves a table of what is there.
            write_atomic(folder / "sweep.csv", table(rows))
    return rows


def table(rows: list[Row]) -> str:
    """The rows as CSV with headers `name [unit]`; the columns of results are those of any run."""
    names = list(rows[0].parameters) if rows else []
    results = list(dict.fromkeys(name for row in rows for name in row.qoi))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*map(header, names), *results, "run", "problem"])
    for row in rows:
        values = [_cell(row.parameters[name]) for name in names]
        writer.writerow([*values, *(_cell(row.qoi.get(name, "")) for name in results), row.run, row.problem])
    return text.getvalue()


def header(name: str) -> str:
    """`name [unit]` for a key of the scene that has a unit, "-" for a plain number."""
    unit = reference.unit(parse_key(name))
    return name if unit is None else f"{name} [{'-' if unit == '1' else unit}]"


def write_atomic(path: Path, text: str) -> None:
    """Write a text file so that a reader sees the old or the new one, never half of it."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(path)


def _cases(study: Path) -> list[tuple[dict[str, Any], Scene]]:
    """The combinations with their scenes; all mistakes at once, those of the study before those of its scenes."""
    values, origin = read(study)
    cases = []
    unknown = values.keys() - {"scene", "parameters"}
    problems = [f"{origin.at((key,))}: {dotted((key,))}: unknown key; allowed: scene, parameters" for key in unknown]
    parameters = values.get("parameters")
    if not isinstance(values.get("scene"), str):
        problems.append(f'{origin.at(("scene",))}: scene: missing; give the file of the scene, scene = "base.toml"')
    if not isinstance(parameters, dict) or not parameters:
        problems.append(f"{origin.at(('parameters',))}: parameters: missing; give lists: flow.velocity = [0.1, 0.2]")
        parameters = {}
    flat = {".".join(path): (levels, origin.at(("parameters", *path))) for path, levels in _flat(parameters)}
    for name, (levels, place) in flat.items():
        if not isinstance(levels, list) or not levels:
            problems.append(f"{place}: {one_line(name)}: expected a list of values")
    if problems:
        raise SceneError(problems)
    if (count := prod(len(levels) for levels, _ in flat.values())) > MOST_RUNS:
        raise SceneError(f"{origin.at(('parameters',))}: parameters: {count} runs; at most {MOST_RUNS}")
    for combination in product(*(levels for levels, _ in flat.values())):
        case = dict(zip(flat, combination, strict=True))
        try:
            scene = load(study.parent / values["scene"], overrides=case)
        except SceneError as error:
            problems += [_relocate(text, flat) for text in error.problems]
        else:
            cases.append(({name: _si(scene, name) for name in case}, scene))
    if problems:
        raise SceneError(list(dict.fromkeys(problems)))
    return cases


def _flat(table: Mapping[str, Any], above: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Parameters by path, whether written as "a.b" = [...], a.b = [...] or in sub-tables."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, (*above, key))
        else:
            yield (*above, key), value


def _relocate(problem: str, flat: Mapping[str, tuple[Any, str]]) -> str:
    """What the scene calls an override stands in the study."""
    text = problem.removeprefix("override: ")
    if text == problem:
        return problem
    return f"{next((place for name, (_, place) in flat.items() if text.startswith(name)), 'override')}: {text}"


def _si(scene: Scene, name: str) -> Any:
    """The value of a key as the scene understood it, in SI."""
    value: Any = scene
    for key in parse_key(name):
        value = value[str(key)] if isinstance(value, dict) else getattr(value, str(key))
    return value


def _cell(value: Any) -> Any:
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value, default=str) if isinstance(value, (list, tuple, dict)) else value


def _run(scene: Scene, folder: Path) -> tuple[dict[str, Any], str]:
    """The named results of one run, from its folder if it is finished, else computed; or why it failed."""
    finished = folder / "finished.json"
    try:
        return json.loads(finished.read_text(encoding="utf-8")), ""
    except (OSError, ValueError):
        pass
    from contbed.runner import run

    try:
        result = run(scene, out=folder, quiet=True)
    except ContbedError as error:
        return {}, str(error).replace("\n", "; ")
    except Exception as error:  # one broken run must not lose the others
        return {}, f"{type(error).__name__}: {error}".replace("\n", "; ")
    qoi = dict(result.summary.get("qoi", {}))
    write_atomic(finished, json.dumps(qoi))
    return qoi, ""


def _report(done: int, total: int, row: Row) -> None:
    values = ", ".join(f"{name} = {value}" for name, value in row.parameters.items())
    print(f"{done}/{total} {values}: {row.problem or 'ok'}", file=sys.stderr)
