"""What a run found: profiles, named results, balances, closure ranges, cost; and how it is written."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from contbed.packed_bed.plan import Plan


@dataclass
class Result:
    """`profiles` maps CSV headers to columns; `nodal` maps field names to (Space, values) at the last time;
    `engine` holds what ranks took; `series` holds (time, nodal) of a transient; `summary` is what summary.json says.
    """

    plan: Plan
    profiles: dict[str, Any] = field(default_factory=dict)
    tables: dict[str, dict[str, Any]] = field(default_factory=dict)  # further tables, written as NAME.csv
    nodal: dict[str, Any] = field(default_factory=dict)
    series: list[tuple[float, dict[str, Any]]] = field(default_factory=list)
    qoi: dict[str, Any] = field(default_factory=dict)
    balances: dict[str, dict[str, Any]] = field(default_factory=dict)
    closures: list[dict[str, Any]] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    timings: dict[str, float] = field(default_factory=dict)
    adaptations: int = 0
    history: list[float] = field(default_factory=list)
    engine: dict[str, Any] = field(default_factory=dict)
    status: str = "ok"

    @property
    def summary(self) -> dict[str, Any]:
        """The contents of summary.json."""
        from contbed.scene.loading import resolved
        from contbed.versions import versions

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
            "adaptations": self.adaptations,
            "newton": self.history,
            **({"engine": self.engine} if self.engine else {}),
        }

    def table(self) -> str:
        """The result as a table for a terminal."""
        from contbed.output.summary import table

        return table(self.summary)

    def write(self, out: Path) -> None:
        """Write summary.json, profiles.csv, fields and plots into `out`."""
        from contbed.output.summary import write_json
        from contbed.output.tables import write_table

        settings, mesh = self.plan.scene.output, self.plan.mesh
        if self.profiles:
            write_table(out / "profiles.csv", self.profiles)
        for name, columns in self.tables.items():
            write_table(out / f"{name}.csv", columns)
        if settings.fields and self.nodal:
            if mesh.engine == "dolfinx":
                from contbed.output.pieces import write
            else:
                from contbed.output.vtu import write
            if self.series:
                from contbed.output.vtu import write_series

                names = [
                    (time, write(out / f"fields_{k:04d}.vtu", mesh.skfem, nodal))
                    for k, (time, nodal) in enumerate(self.series)
                ]
                write_series(out / "fields.pvd", names)
            else:
                write(out / "fields.vtu", mesh.skfem, self.nodal)
        if settings.plots and self.profiles:
            self._plot(out)
        write_json(out / "summary.json", self.summary)

    def _plot(self, out: Path) -> None:
        from contbed.output.plots import field_plot, profile_plot, transient_plot

        scene, mesh = self.plan.scene, self.plan.mesh
        if scene.kind == "bubbling_bed":
            from contbed.bubbling_bed.plots import bubbling_plot

            bubbling_plot(out / "profiles.png", self.profiles, scene.title, self.qoi)
            if "continuation" in self.tables:
                from contbed.bubbling_bed.plots import branch_plot

                branch_plot(out / "continuation.png", self.tables["continuation"], scene.title)
            return
        if scene.kind == "two_fluid":
            from contbed.two_fluid.plots import two_fluid_plot

            two_fluid_plot(out / "profiles.png", self.profiles, self.tables, scene.title)
            return
        if scene.kind == "fully_developed":
            from contbed.two_fluid.plots import developed_plot

            developed_plot(out / "profiles.png", self.profiles, scene.title)
            return
        if scene.kind == "particles_gas":
            from contbed.dem.plots import history_plot

            history_plot(out / "profiles.png", self.profiles, scene.title)
            return
        coordinate = next(iter(self.profiles))
        draw = transient_plot if "t [s]" in self.profiles else profile_plot
        draw(out / "profiles.png", self.profiles, coordinate, scene.title)
        if self.nodal and mesh.skfem.dim() == 2:
            field_plot(out / "fields.png", mesh.skfem, self.nodal, mesh.axisymmetric, scene.title)
