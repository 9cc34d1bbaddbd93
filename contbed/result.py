"""Result of a run: profiles, named results, balances, closure ranges, cost; and how
it is written.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from contbed import models
from contbed.engine import Engine
from contbed.errors import ContbedError
from contbed.fields import span, unit_of

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

REPR_RESULTS = 4  # named results that a repr shows, in one line of a terminal


@dataclass(repr=False)
class Result:
    """Everything that a run computed.

    `profiles` maps CSV headers to columns; `nodal` maps field names to (Space, values)
    at the last time; `series` holds (time, nodal) of a transient; `engine` computed the
    run, and `usage` is the cost of each of its ranks; `summary` is the content of
    summary.json.
    """

    plan: models.Plan
    profiles: dict[str, Any] = field(default_factory=dict)
    # further tables, written as NAME.csv
    tables: dict[str, dict[str, Any]] = field(default_factory=dict)
    nodal: dict[str, Any] = field(default_factory=dict)
    series: list[tuple[float, dict[str, Any]]] = field(default_factory=list)
    qoi: dict[str, Any] = field(default_factory=dict)
    # of named results whose unit depends on the scene
    units: dict[str, str] = field(default_factory=dict)
    balances: dict[str, dict[str, Any]] = field(default_factory=dict)
    closures: list[dict[str, Any]] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    timings: dict[str, float] = field(default_factory=dict)
    adaptations: int = 0
    history: list[float] = field(default_factory=list)
    engine: Engine = field(default_factory=Engine)
    usage: dict[str, Any] = field(default_factory=dict)
    # problem and state of a steady run, for the `tangent` of its physics
    solved: Any = None
    status: str = "ok"

    def __post_init__(self) -> None:
        # as it was written; the plan may move to another scene, such as that of a bed
        # that has settled
        self.scene: Any = getattr(self.plan, "scene", None)

    def __repr__(self) -> str:
        """Return kind, status and first named results in one line."""
        shown = [
            f"{key} = {value:.6g}"
            for key, value in self.qoi.items()
            if isinstance(value, int | float)
        ][:REPR_RESULTS]
        more = ", ..." if len(self.qoi) > len(shown) else ""
        return (
            f"<Result of a {self.plan.scene.kind} scene: {self.status}; "
            f"{', '.join(shown)}{more}>"
        )

    @property
    def summary(self) -> dict[str, Any]:
        """The contents of summary.json."""
        from contbed.output.versions import versions
        from contbed.scene.identity import resolved

        return {
            "status": self.status,
            "versions": versions(),
            "scene": resolved(self.plan.scene),
            "dofs": self.plan.unknowns(),
            "timings": self.timings,
            "balances": self.balances,
            "closures": self.closures,
            "built": [{"what": what, "why": why} for what, why in self.plan.built],
            "skipped": [{"what": what, "why": why} for what, why in self.plan.skipped],
            "warnings": self.warnings,
            "qoi": self.qoi,
            "units": {
                key: self.units.get(key) or unit_of(key) or "1" for key in self.qoi
            },
            "adaptations": self.adaptations,
            "newton": self.history,
            **({"engine": self.usage} if self.usage else {}),
        }

    @property
    def gradient(self) -> NoReturn:
        """Name the function that has taken the place of this method."""
        raise AttributeError("use contbed.gradient(scene, results, keys)")

    def _repr_html_(self) -> str:
        """Return the result as a table for a notebook."""
        from contbed.output.frames import html

        return html(self)

    def to_xarray(self, table: str = "profiles") -> xarray.Dataset:
        """Return "profiles", another table, or "fields" as an xarray Dataset; see
        `contbed.output.frames.dataset`.
        """
        from contbed.output.frames import dataset

        return dataset(self, table)

    def to_pandas(self, table: str = "profiles") -> pandas.DataFrame:
        """Return "profiles", another table, or the named "results" as a pandas
        DataFrame.
        """
        from contbed.output.frames import frame

        return frame(self, table)

    def plot(self, *names: str, table: str = "profiles") -> Figure:
        """Return a matplotlib figure of columns of a table, "T_fluid", all if none
        are named; a panel for each unit.
        """
        from contbed.output.frames import figure

        made: Figure = figure(self, *names, table=table)
        return made

    def table(self) -> str:
        """Return the result as a table for a terminal."""
        from contbed.output.summary import table

        return table(self.summary)

    def write(self, out: str | Path) -> list[ContbedError]:
        """Write tables, fields and plots into the folder `out`; return the errors of
        parts that cannot be written.
        """
        from contbed.output.tables import write_table

        out = Path(out)
        settings = self.plan.scene.output
        parts: dict[str, Callable[[], Any]] = {}
        # not every physics lets its profiles be left out
        if self.profiles and getattr(settings, "profiles", True):
            parts["profiles.csv"] = lambda: write_table(
                out / "profiles.csv", self.profiles
            )
        for name, columns in self.tables.items():
            parts[f"{name}.csv"] = partial(write_table, out / f"{name}.csv", columns)
        if settings.fields and self.nodal:
            parts["fields"] = lambda: self._write_fields(out)
        if settings.plots and self.profiles:
            parts["plots"] = lambda: models.model_of(self.plan.scene).find(
                "plots", "plot"
            )(self, out)
        failed: list[ContbedError] = []
        for name, part in parts.items():
            try:
                part()
            except ContbedError as error:
                failed.append(error)
            except Exception as error:
                failed.append(
                    ContbedError(
                        f"{name} cannot be written: {type(error).__name__}: {error}"
                    )
                )
                failed[-1].__cause__ = error
        return failed

    def _write_fields(self, out: Path) -> None:
        from contbed.output.vtu import write_fields, write_series

        mesh = self.plan.mesh.skfem
        if self.series:
            names = [
                (time, write_fields(out / f"fields_{k:04d}.vtu", mesh, nodal))
                for k, (time, nodal) in enumerate(self.series)
            ]
            write_series(out / "fields.pvd", names)
        else:
            write_fields(out / "fields.vtu", mesh, self.nodal)

    @contextmanager
    def timed(self, phase: str) -> Iterator[None]:
        """Add the wall time of the block to `timings`."""
        start = clock.perf_counter()
        try:
            yield
        finally:
            self.timings[phase] = (
                self.timings.get(phase, 0.0) + clock.perf_counter() - start
            )


def timed(phase: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Decorate a `run(plan, result, ...)` so that its wall time is added to
    `result.timings` as `phase`.
    """

    def decorate(run: Callable[..., None]) -> Callable[..., None]:
        @wraps(run)
        def wrapped(plan: Any, result: Result, *arguments: Any) -> None:
            with result.timed(phase):
                run(plan, result, *arguments)

        return wrapped

    return decorate


def outside(closure: Mapping[str, Any]) -> str:
    """Describe how a closure was used outside its declared range."""
    parts = [
        f"{name} {span(use['used'], '.4g')}, declared {span(use['declared'], '.4g')}"
        for name, use in closure["ranges"].items()
        if use["share_outside"] > 0
    ]
    return f"closure {closure['name']} is out of its range: {', '.join(parts)}"


def beyond_ranges(
    closures: Iterable[Mapping[str, Any]], least: float = 0.0
) -> list[str]:
    """Return a warning for each closure that more than a `least` share of the bed uses
    outside its declared range.
    """
    return [outside(each) for each in closures if each["share_outside"] > least]
