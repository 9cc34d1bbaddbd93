"""The studies in the folders beside this package, and what can be done with one of
them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import Any

from studies._gallery import figures
from studies._gallery.table import Table, Tables

STUDIES = Path(__file__).parents[1]
FUNCTIONS = ("compute", "reference", "plot")
SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0}
SHORT = 60.0  # CPU [s] up to which a study is run with all others
# folders of a study whose TOML files are no scenes
NO_SCENES = ("closures", "sweep", "sweeps", "design", "bench", "data")


@dataclass(frozen=True)
class Study:
    """One script with `compute`, `reference` and `plot`.

    name : folder, or FOLDER/SCRIPT where the script is not study.py
    """

    name: str

    @property
    def folder(self) -> Path:
        return STUDIES / self.name.partition("/")[0]

    @property
    def script(self) -> Path:
        return self.folder / f"{self.name.partition('/')[2] or 'study'}.py"

    @cached_property
    def readme(self) -> str:
        return (self.folder / "README.md").read_text(encoding="utf-8")

    @property
    def title(self) -> str:
        """First line of the README, or of the script where the folder has several."""
        if self.script.stem != "study":
            return (
                self.script.read_text(encoding="utf-8")
                .partition("\n")[0]
                .strip('"')
                .rstrip(".")
            )
        return self.readme.partition("\n")[0].lstrip("# ")

    @property
    def cost(self) -> str:
        """CPU of a run as the README states it behind `python -m studies run NAME`,
        such as "8 min", or "".
        """
        command = rf"python -m studies run {re.escape(self.name)}(?![/\w])"
        found = re.search(rf"{command}.*?([\d.]+ (?:s|min|h))\b", self.readme)
        return found[1] if found else ""

    @property
    def seconds(self) -> float:
        """CPU of a run [s]."""
        number, unit = self.cost.split()
        return float(number) * SECONDS[unit]

    @property
    def is_long(self) -> bool:
        """Is this study run only when it is named?"""
        return self.seconds > SHORT

    @property
    def tolerance(self) -> float:
        """Relative difference within which a run gives the committed tables again,
        as the README states it.
        """
        found = re.search(r"[Tt]ables are reproduced within ([\d.e-]+)", self.readme)
        if found is None:
            raise ValueError(
                f"{self.folder}/README.md does not say within what the tables are "
                "reproduced"
            )
        return float(found[1].rstrip("."))

    @property
    def module(self) -> Any:
        """The script, imported."""
        return import_module(f"studies.{self.folder.name}.{self.script.stem}")

    @property
    def scenes(self) -> list[Path]:
        """Scenes of the folder and its subfolders."""
        found = sorted(self.folder.rglob("*.toml"))
        return [
            path
            for path in found
            if not set(path.relative_to(self.folder).parts) & set(NO_SCENES)
        ]

    def tables(self) -> Tables:
        """The committed tables by name."""
        return {
            path.stem: Table.read(path) for path in sorted(self.folder.glob("*.csv"))
        }

    def compute(self, cases: list[str] | None = None) -> Tables:
        """Run the study, or some of its cases."""
        function = self.module.compute
        if not cases:
            return dict(function())
        if "cases" not in signature(function).parameters:
            raise ValueError(f"{self.name} has no cases to choose from")
        return dict(function(cases))

    def draw(self, tables: Tables, folder: Path | None = None) -> list[Path]:
        """Draw the figures of these tables into a folder, by default that of the
        study.
        """
        import matplotlib

        with matplotlib.rc_context():
            matplotlib.rcdefaults()
            matplotlib.rcParams.update(figures.STYLE)
            return figures.save(self.module.plot(tables), folder or self.folder)

    def differences(self, tables: Tables) -> list[str]:
        """How tables differ from the committed ones beyond the tolerance; times are
        not compared.
        """
        skip, committed = getattr(self.module, "NOT_COMPARED", ()), self.tables()
        found = []
        for name, table in tables.items():
            lines = (
                table.differences(committed[name], self.tolerance, skip)
                if name in committed
                else ["not committed"]
            )
            found += [f"{name}.csv, {line}" for line in lines]
        return found


def studies() -> dict[str, Study]:
    """All studies by name."""
    found = []
    for path in sorted(STUDIES.glob("[!_]*/*.py")):
        if re.search(r"^def compute\(", path.read_text(encoding="utf-8"), re.MULTILINE):
            found.append(
                path.parent.name
                if path.stem == "study"
                else f"{path.parent.name}/{path.stem}"
            )
    return {name: Study(name) for name in sorted(found)}
