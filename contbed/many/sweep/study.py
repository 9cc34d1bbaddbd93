"""A study file: one scene and the values of some of its keys.

    title = "Length of a heater"                         # of the plots; may be left out
    scene = "heater.toml"
    qoi = ["T_fluid_out_K", "heat_wall_W"]               # results to plot; the first four that vary if left out

    [parameters]                                         # every combination of these
    flow.velocity_solid = ["-0.6 mm/s", "-0.8 mm/s"]
    bed.particle_diameter = { from = "3 mm", to = "12 mm", count = 4 }

    [[zipped]]                                           # taken together, one value of each at a time
    fluid.density = [1.2, 0.6]
    fluid.viscosity = [1.8e-5, 3.0e-5]

    [sample]                                             # points of a design
    method = "sobol"                                     # or "latin_hypercube", "sobol_indices", "morris"
    count = 64
    seed = 1                                             # 0 if left out
    gradients = true                                     # uncertainty by derivatives at the means beside the samples
    [sample.parameters]
    bed.porosity = { from = 0.36, to = 0.44 }

`design` describes values and distributions. Parts that stand side by side are combined, each with each.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import product
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from contbed.errors import SceneError
from contbed.explain import sheets
from contbed.loading import load
from contbed.many import value_sets
from contbed.many.distributions import Distribution
from contbed.many.runs import Case, case_of
from contbed.scene.identity import resolved
from contbed.scene.names import nearest
from contbed.scene.tables import SceneBase
from contbed.scene.toml_lines import KeyPath, Origin, dotted, one_line, parse_key, read

_KEYS = ("title", "scene", "qoi", "parameters", "zipped", "sample")
_VALUES = (value_sets.is_values, value_sets.values)
_DISTRIBUTIONS = (value_sets.is_distribution, partial(value_sets.distribution, counts=True))
_SAMPLE_KEYS = ("method", "count", "seed", "gradients", "parameters")


@dataclass(frozen=True)
class Sample:
    """The design of [sample]: method, distribution of each parameter, its points in the unit cube.

    gradients : results are propagated by their derivatives at the means as well
    """

    method: str
    distributions: Mapping[str, Distribution]
    points: value_sets.Array
    gradients: bool


@dataclass(frozen=True)
class Study:
    """The runs of a study file.

    `axes` are the parameters that vary by themselves, among them the first of each [[zipped]] table; `logarithmic` are
    those with even ratios; `qoi_at` is where the file says what to plot. `order` are the names of the cases of all
    combinations, in which one that is the same scene as another stands again; `base` loads the scene of other values.
    """

    file: Path
    title: str
    cases: list[Case]
    qoi: tuple[str, ...]
    qoi_at: str
    logarithmic: frozenset[str]
    parameters: tuple[str, ...]
    axes: tuple[str, ...]
    warnings: tuple[str, ...]
    order: tuple[str, ...]
    base: Callable[[dict[str, Any]], SceneBase]
    sample: Sample | None = None


def read_study(path: str | Path, trust: bool = False, allow_large: bool = False) -> Study:
    """Return the runs of a study file, without those that are the same scene twice; flags as in `contbed.loading.load`.

    Raises
    ------
    SceneError : with file:line, all mistakes of the study, or if it has none those of its scenes
    """
    path = Path(path)
    values, origin = read(path)
    reader = _Reader(values, origin)
    reader.head()
    groups = [*reader.parameters(), *reader.zipped(), *reader.sample()]
    if not groups and not reader.problems:
        reader.say(("parameters",), "missing; give lists: [parameters], flow.velocity = [0.1, 0.2]")
    if not reader.problems and (count := prod(map(len, groups))) > value_sets.MOST_RUNS:
        reader.say(("parameters",), f"{count} runs; at most {value_sets.MOST_RUNS}")
    if reader.problems:
        raise SceneError(list(dict.fromkeys(reader.problems)))
    make = partial(load, origin.base / values["scene"], trust=trust, allow_large=allow_large)
    cases, order = _cases(make, groups, reader.places)
    return Study(
        file=path,
        title=values.get("title", ""),
        cases=cases,
        qoi=tuple(values.get("qoi", ())),
        qoi_at=origin.at(("qoi",)),
        logarithmic=frozenset(reader.logarithmic),
        parameters=tuple(reader.places),
        axes=tuple(name for name in reader.places if name not in reader.followers),
        warnings=tuple(reader.warnings),
        order=order,
        base=make,
        sample=reader.design,
    )


class _Reader:
    """Reader of the parts of a study, each a list of points {parameter: value}; it collects mistakes."""

    def __init__(self, values: dict[str, Any], origin: Origin):
        self.values, self.origin = values, origin
        self.problems: list[str] = []
        self.warnings: list[str] = []
        self.places: dict[str, str] = {}
        self.logarithmic: set[str] = set()
        self.followers: set[str] = set()
        self.design: Sample | None = None

    def say(self, path: KeyPath, text: str, shown: str = "") -> None:
        """Note a mistake at a key, which is shown by its name in the scene where it has one."""
        self.problems.append(one_line(f"{self.origin.at(path)}: {shown or dotted(path)}: {text}"))

    def _say_below(self, path: KeyPath, name: str, below: KeyPath, text: str) -> None:
        self.say((*path, *below), text, name)

    def head(self) -> None:
        """Read the plain keys."""
        for key in self.values.keys() - set(_KEYS):
            self.say((key,), f"unknown key; {nearest(key, list(_KEYS))}")
        scene = self.values.get("scene")
        if not isinstance(scene, str):
            self.say(("scene",), 'missing; give the file of the scene, scene = "base.toml"')
        elif not (self.origin.base / scene).is_file():
            self.say(("scene",), f'no such file: "{scene}", looked for beside the study')
        if not isinstance(self.values.get("title", ""), str):
            self.say(("title",), "expected a text")
        qoi = self.values.get("qoi", ["any"])
        if not isinstance(qoi, list) or not qoi or not all(isinstance(name, str) for name in qoi):
            self.say(("qoi",), 'expected a list of names of results, ["T_fluid_out_K"]')

    def parameters(self) -> Iterator[list[dict[str, Any]]]:
        """Return one part for each key: its values."""
        for name, levels in self.entries(("parameters",), self.values.get("parameters", {}), *_VALUES):
            yield [{name: level} for level in levels]

    def zipped(self) -> Iterator[list[dict[str, Any]]]:
        """Return one part for each table of [[zipped]]: the values of its keys, taken together."""
        tables = self.values.get("zipped", [])
        if not isinstance(tables, list):
            self.say(("zipped",), "expected tables [[zipped]]")
            return
        for k, table in enumerate(tables):
            entries = list(self.entries(("zipped", k), table, *_VALUES))
            lengths = {name: len(levels) for name, levels in entries}
            if len(set(lengths.values())) > 1:
                counts = ", ".join(f"{count} of {name}" for name, count in lengths.items())
                self.say(("zipped", k), f"as many values of each key are needed, found {counts}")
            elif entries:
                names, columns = zip(*entries, strict=True)
                self.followers.update(names[1:])
                yield [dict(zip(names, point, strict=True)) for point in zip(*columns, strict=True)]

    def sample(self) -> Iterator[list[dict[str, Any]]]:
        """Return one part: the points of the sample."""
        if "sample" not in self.values:
            return
        at, table = ("sample",), self.values["sample"]
        if not isinstance(table, dict):
            self.say(at, "expected a table with method, count, seed and parameters")
            return
        say = partial(self._say_below, at, "sample")
        for key in table.keys() - set(_SAMPLE_KEYS):
            say((key,), f"{key}: unknown key; {nearest(key, list(_SAMPLE_KEYS))}")
        method = value_sets.choice(table, "method", value_sets.METHODS, say)
        count = value_sets.whole(table, "count", 1, value_sets.MOST_RUNS, say)
        seed = value_sets.whole(table, "seed", 0, 2**63 - 1, say, default=0)
        gradients = table.get("gradients", False)
        if not isinstance(gradients, bool):
            say(("gradients",), "gradients: expected true or false")
        entries = list(self.entries((*at, "parameters"), table.get("parameters", {}), *_DISTRIBUTIONS))
        if not entries and not self.problems:
            say(("parameters",), "parameters: missing; give distributions, bed.porosity = { from = 0.36, to = 0.44 }")
        if self.problems or method is None or count is None or seed is None:
            return
        if method in value_sets.BY_THEMSELVES and (others := {"parameters", "zipped"} & self.values.keys()):
            say(("method",), f'method = "{method}" stands by itself; leave out {" and ".join(sorted(others))}')
            return
        if method.startswith("sobol") and count & (count - 1):
            near = 2 ** (count.bit_length() - 1)
            self.warnings.append(
                f"{self.origin.at((*at, 'count'))}: sample.count = {count}: not a power of two; "
                f"Sobol points fill the space evenly at {near} or {2 * near}"
            )
        points = value_sets.sample(method, count, seed, len(entries))
        if method == "morris":
            points = np.column_stack(
                [value_sets.within_tails(points[:, k], spread) for k, (_, spread) in enumerate(entries)]
            )
        self.design = Sample(method, dict(entries), points, gradients)
        columns = {
            name: spread(points[:, k]).astype(int).tolist()
            if spread.whole
            else map(value_sets.tidy, spread(points[:, k]))
            for k, (name, spread) in enumerate(entries)
        }
        yield [dict(zip(columns, point, strict=True)) for point in zip(*columns.values(), strict=True)]

    def entries(
        self, at: KeyPath, table: Any, is_entry: Callable[[Any], bool], read_entry: Callable[..., Any]
    ) -> Iterator[tuple[str, Any]]:
        """Name and values, or distribution, of each key below a table."""
        if not isinstance(table, dict):
            self.say(at, "expected a table of keys of the scene")
            return
        for below, entry in flat(table, is_entry):
            name, path = ".".join(below), (*at, *below)
            if name in self.places:
                self.say(path, f"stands twice, also at {self.places[name]}", name)
                continue
            self.places[name] = self.origin.at(path)
            if value_sets.is_log(entry):
                self.logarithmic.add(name)
            found = read_entry(entry, unit_of(name), partial(self._say_below, path, name))
            if found is not None:
                yield name, found


def flat(
    table: Mapping[str, Any], is_entry: Callable[[Any], bool], above: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Return the entries by path, whether written as "a.b" = [...], a.b = [...] or in sub-tables."""
    for key, value in table.items():
        if is_entry(value):
            yield (*above, key), value
        else:
            yield from flat(value, is_entry, (*above, key))


def unit_of(name: str) -> str | None:
    """Return the SI unit of a dotted key; None if it has none or is not known."""
    try:
        return sheets.unit(parse_key(name))
    except ValueError:  # reported by the scene
        return None


def _cases(
    make: Callable[[dict[str, Any]], SceneBase], groups: list[list[dict[str, Any]]], places: Mapping[str, str]
) -> tuple[list[Case], tuple[str, ...]]:
    """Return the scenes of all combinations, and their names in order; a shared mistake is reported once."""
    cases: dict[str, Case] = {}
    order: list[str] = []
    problems: dict[str, list[str]] = {}
    for points in product(*groups):
        values = {name: value for point in points for name, value in point.items()}
        try:
            loaded = make(values)
        except SceneError as error:
            for text in error.problems:
                name, told = relocated(text, places)
                known = problems.setdefault(name or text, [] if name else [f"{told} (with {_shown(values)})"])
                if name and told not in known:
                    known.append(told)
        else:
            found = resolved(loaded)
            case = case_of(loaded, {name: _at(found, name) for name in values})
            cases.setdefault(case.name, case)
            order.append(case.name)
    if problems:
        again = " (and {} more values)"
        raise SceneError([first + (again.format(len(more)) if more else "") for first, *more in problems.values()])
    return list(cases.values()), tuple(order)


def relocated(problem: str, places: Mapping[str, str]) -> tuple[str, str]:
    """Replace an override of a scene in a message by the parameter and the line of the study."""
    text = problem.removeprefix("override: ")
    if text != problem:
        for name in sorted(places, key=len, reverse=True):
            if text.startswith(name):
                return name, f"{places[name]}: {text}"
    return "", problem


def _shown(values: Mapping[str, Any]) -> str:
    return one_line(", ".join(f"{name} = {value}" for name, value in values.items()))


def _at(values: Any, name: str) -> Any:
    """Return the value of a key; None where the scene leaves it out."""
    for key in parse_key(name):
        values = values.get(str(key)) if isinstance(values, dict) else None
    return values
