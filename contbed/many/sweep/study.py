"""A study file: one scene and the values of some of its keys.

    title = "Length of a heater"                         # of the plots; may be left out
    scene = "heater.toml"
    qoi = ["T_fluid_out_K", "heat_wall_W"]               # results to plot; the first four that vary if left out

    [parameters]                                         # every combination of these
    boundary.right.solids.pebbles.velocity = ["0.6 mm/s", "0.8 mm/s"]
    solids.pebbles.diameter = { from = "3 mm", to = "12 mm", count = 4 }

    [[zipped]]                                           # taken together, one value of each at a time
    fluid.density = [1.2, 0.6]
    fluid.viscosity = [1.8e-5, 3.0e-5]

    [sample]                                             # points of a design
    method = "sobol"                                     # or "latin_hypercube", "sobol_indices", "morris"
    count = 64
    seed = 1                                             # 0 if left out
    gradients = true                                     # uncertainty by derivatives at the means beside the samples
    [sample.parameters]
    packed_bed.porosity = { from = 0.36, to = 0.44 }

`design` describes values and distributions. Parts that stand side by side are combined,
each with each.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import product
from math import prod
from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import Field

from contbed.arrays import Array
from contbed.errors import SceneError
from contbed.loading import load
from contbed.many import value_sets
from contbed.many.distributions import Distribution
from contbed.many.runs import Case, case_of
from contbed.many.study_file import StudyFile, relocated, unit_in
from contbed.scene.identity import resolved
from contbed.scene.quantities import Switch, Table, Whole
from contbed.scene.tables import SceneBase
from contbed.scene.toml_lines import KeyPath, one_line
from contbed.scene.values import value_at

Point = dict[str, Any]  # value by key of the scene
_VALUES = (value_sets.is_values, value_sets.values)
_DISTRIBUTIONS = (
    value_sets.is_distribution,
    partial(value_sets.distribution, counts=True),
)


class SampleTable(Table):
    """[sample]."""

    method: value_sets.Method
    """how the points of the sample are drawn"""
    count: Annotated[Whole, Field(ge=1, le=value_sets.MOST_RUNS)]
    """number of points"""
    seed: Annotated[Whole, Field(ge=0, lt=2**63)] = 0
    """seed of the random numbers"""
    gradients: Switch = False
    """uncertainty by derivatives at the means as well"""
    parameters: dict[str, Any] = Field(default_factory=dict)
    """keys of the scene, each with its distribution"""


class StudyTable(Table):
    """The file of a sweep."""

    kind: ClassVar[str] = "sweep"

    title: str = ""
    """title of the study, shown in plots and reports"""
    scene: str = ""
    """scene file, path relative to this file"""
    qoi: tuple[str, ...] = Field((), min_length=1)
    """results to plot"""
    parameters: dict[str, Any] = Field(default_factory=dict)
    """keys of the scene, each with its values; all combinations are computed"""
    zipped: tuple[dict[str, Any], ...] = ()
    """keys whose values change together"""
    sample: SampleTable | None = None
    """random or quasi-random sample of keys"""


@dataclass(frozen=True)
class Sample:
    """The design of [sample]: method, distribution of each parameter, its points in the
    unit cube.

    gradients : results are propagated by their derivatives at the means as well
    """

    method: str
    distributions: Mapping[str, Distribution]
    points: Array
    gradients: bool


@dataclass(frozen=True)
class Study:
    """The runs of a study file.

    `parameters` are all that vary, with the place "file:line" of each; `axes` those
    that vary by themselves, among them the first of each [[zipped]] table;
    `logarithmic` are those with even ratios; `qoi_at` is where the file says what to
    plot. `order` are the names of the cases of all combinations, in which one that is
    the same scene as another stands again; `base` loads the scene of other values.
    """

    file: Path
    title: str
    cases: list[Case]
    qoi: tuple[str, ...]
    qoi_at: str
    logarithmic: frozenset[str]
    parameters: Mapping[str, str]
    axes: tuple[str, ...]
    warnings: tuple[str, ...]
    order: tuple[str, ...]
    base: Callable[[dict[str, Any]], SceneBase]
    sample: Sample | None = None


def read_study(
    path: str | Path, trust: bool = False, allow_large: bool = False
) -> Study:
    """Return the runs of a study file, without those that are the same scene twice;
    flags as in `contbed.loading.load`.

    Raises
    ------
    SceneError : with file:line, all mistakes of the study, or if it has none those of
        its scenes
    """
    file = StudyFile(path, StudyTable)
    settings, origin = file.settings, file.origin
    scene = file.file(("scene",), settings.scene)
    reader = _Reader(file)
    groups = [*reader.parameters(), *reader.zipped(), *reader.sample()]
    if not groups and not file.problems:
        file.say(
            ("parameters",),
            "missing; give lists: [parameters], mesh.length = [0.1, 0.2]",
        )
    if not file.problems and (count := prod(map(len, groups))) > value_sets.MOST_RUNS:
        file.say(("parameters",), f"{count} runs; at most {value_sets.MOST_RUNS}")
    file.stop()
    make = partial(load, scene, trust=trust, allow_large=allow_large)
    cases, order = _cases(make, groups, reader.places)
    return Study(
        file=file.path,
        title=settings.title,
        cases=cases,
        qoi=settings.qoi,
        qoi_at=origin.at(("qoi",)),
        logarithmic=frozenset(reader.logarithmic),
        parameters=reader.places,
        axes=tuple(name for name in reader.places if name not in reader.followers),
        warnings=tuple(reader.warnings),
        order=order,
        base=make,
        sample=reader.design,
    )


class _Reader:
    """Reader of the parts of a study, each a list of points; mistakes are collected
    by the file.
    """

    def __init__(self, file: StudyFile[StudyTable]):
        self.file, self.settings = file, file.settings
        self.warnings: list[str] = []
        self.places: dict[str, str] = {}
        self.logarithmic: set[str] = set()
        self.followers: set[str] = set()
        self.design: Sample | None = None

    def parameters(self) -> Iterator[list[Point]]:
        """Yield one part for each key: its values."""
        for name, levels in self.entries(
            ("parameters",), self.settings.parameters, *_VALUES
        ):
            yield [{name: level} for level in levels]

    def zipped(self) -> Iterator[list[Point]]:
        """Yield one part for each table of [[zipped]]: the values of its keys, taken
        together.
        """
        for k, table in enumerate(self.settings.zipped):
            entries = list(self.entries(("zipped", k), table, *_VALUES))
            lengths = {name: len(levels) for name, levels in entries}
            if len(set(lengths.values())) > 1:
                counts = ", ".join(
                    f"{count} of {name}" for name, count in lengths.items()
                )
                self.file.say(
                    ("zipped", k),
                    f"as many values of each key are needed, found {counts}",
                )
            elif entries:
                names, columns = zip(*entries, strict=True)
                self.followers.update(names[1:])
                yield _points(names, columns)

    def sample(self) -> Iterator[list[Point]]:
        """Yield one part: the points of the sample."""
        table = self.settings.sample
        if table is None:
            return
        say = self.file.say
        spreads = dict(
            self.entries(("sample", "parameters"), table.parameters, *_DISTRIBUTIONS)
        )
        if not spreads and not self.file.problems:
            say(
                ("sample", "parameters"),
                "missing; give distributions, mesh.length = { from = 0.36, to = 0.44 }",
            )
        others = sorted({"parameters", "zipped"} & self.file.values.keys())
        if table.method in value_sets.BY_THEMSELVES and others:
            say(
                ("sample", "method"),
                f'"{table.method}" stands alone; leave out {" and ".join(others)}',
            )
        if self.file.problems:
            return
        self._warn_of_count(table)
        points = value_sets.sample(table.method, table.count, table.seed, len(spreads))
        columns = []
        for k, spread in enumerate(spreads.values()):
            if table.method == "morris":
                points[:, k] = value_sets.within_tails(points[:, k], spread)
            values = spread(points[:, k])
            columns.append(
                values.astype(int).tolist()
                if spread.whole
                else [*map(value_sets.tidy, values)]
            )
        self.design = Sample(table.method, spreads, points, table.gradients)
        yield _points(spreads, columns)

    def _warn_of_count(self, table: SampleTable) -> None:
        """Warn of Sobol points that do not fill the space evenly."""
        if table.method.startswith("sobol") and table.count & (table.count - 1):
            near = 2 ** (table.count.bit_length() - 1)
            self.warnings.append(
                f"{self.file.origin.at(('sample', 'count'))}: sample.count = "
                f"{table.count}: not a power of two; "
                f"Sobol points fill the space evenly at {near} or {2 * near}"
            )

    def entries(
        self,
        at: KeyPath,
        table: Mapping[str, Any],
        is_entry: Callable[[Any], bool],
        read: Callable[..., Any],
    ) -> Iterator[tuple[str, Any]]:
        """Yield name and values, or distribution, of each key below a table."""
        for name, path, entry in self.file.entries(at, table, is_entry, self.places):
            if value_sets.is_log(entry):
                self.logarithmic.add(name)
            unit = unit_in([self.file.origin.base / self.settings.scene], name)
            found = read(entry, unit, self.file.say_below(path, name))
            if found is not None:
                yield name, found


def _points(names: Iterable[str], columns: Iterable[Iterable[Any]]) -> list[Point]:
    """Return the points whose keys have the values of the columns, row by row."""
    names = list(names)
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def _cases(
    make: Callable[[dict[str, Any]], SceneBase],
    groups: list[list[dict[str, Any]]],
    places: Mapping[str, str],
) -> tuple[list[Case], tuple[str, ...]]:
    """Return the scenes of all combinations, and their names in order; a shared
    mistake is reported once.
    """
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
                known = problems.setdefault(
                    name or text, [] if name else [f"{told} (with {_shown(values)})"]
                )
                if name and told not in known:
                    known.append(told)
        else:
            found = resolved(loaded)
            case = case_of(loaded, {name: value_at(found, name) for name in values})
            cases.setdefault(case.name, case)
            order.append(case.name)
    if problems:
        again = " (and {} more values)"
        raise SceneError(
            [
                first + (again.format(len(more)) if more else "")
                for first, *more in problems.values()
            ]
        )
    return list(cases.values()), tuple(order)


def _shown(values: Mapping[str, Any]) -> str:
    return one_line(", ".join(f"{name} = {value}" for name, value in values.items()))
