"""The command line of the studies."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from studies._gallery.catalogue import STUDIES, Study, studies
from studies._gallery.table import Tables
from studies._gallery.timing import machine, user_time

SHOWN = 40  # rows of a table that are printed at most
README = STUDIES / "README.md"
BEGIN, END = "<!-- studies: begin -->", "<!-- studies: end -->"


def main(arguments: Sequence[str]) -> int:
    """Do what the arguments say; return an exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m studies", description="Studies of contbed"
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    commands.add_parser("list", help="name, CPU and title of every study (the default)")
    for name, what in (
        ("run", "compute tables and figures"),
        ("draw", "draw the figures of the committed tables"),
        ("check", "compute, and compare with the committed tables; nothing is written"),
    ):
        each = commands.add_parser(name, help=what)
        each.add_argument(
            "names", nargs="*", metavar="NAME", help="a folder, or FOLDER/SCRIPT"
        )
        each.add_argument(
            "--all",
            action="store_true",
            help="all, run and check without the long ones",
        )
        if name != "check":
            each.add_argument(
                "--out",
                type=Path,
                metavar="DIR",
                help="folder of tables and figures, not the study's",
            )
        if name == "run":
            each.add_argument(
                "--case",
                action="append",
                metavar="CASE",
                help="only this case, may be repeated",
            )
    commands.add_parser("readme", help="bring the list in studies/README.md up to date")
    options = parser.parse_args(arguments)
    if options.command in (None, "list"):
        print(listing())
        return 0
    if options.command == "readme":
        README.write_text(
            with_list(README.read_text(encoding="utf-8")), encoding="utf-8"
        )
        return 0
    known = studies()
    if unknown := [name for name in options.names if name not in known]:
        parser.error(f"no study {', '.join(unknown)}; see python -m studies")
    chosen = [known[name] for name in options.names]
    if options.all:
        chosen = [
            study
            for study in known.values()
            if options.command == "draw" or not study.is_long
        ]
    if not chosen:
        parser.error("name a study, or --all")
    if options.command == "check":
        return max(check(study) for study in chosen)
    for study in chosen:
        if options.command == "draw":
            _draw(study, study.tables(), options.out)
        else:
            run(study, options.case, options.out)
    return 0


def listing() -> str:
    """One line for each study; those that run only when named show their CPU."""
    found = studies().values()
    wide = max(len(study.name) for study in found)
    lines = [
        f"{study.name:{wide}}  {study.cost if study.is_long else '':>6}  {study.title}"
        for study in found
    ]
    return "\n".join(
        [
            *lines,
            "",
            "CPU of those that run only when they are named; python -m studies --help",
        ]
    )


def run(study: Study, cases: list[str] | None = None, out: Path | None = None) -> None:
    """Compute, write and print tables, draw figures."""
    print(f"{study.name}: {study.title}\n{machine()}")
    start, folder = user_time(), out or study.folder
    tables = study.compute(cases)
    folder.mkdir(parents=True, exist_ok=True)
    for name, table in tables.items():
        table.write(folder / f"{name}.csv")
        print(
            f"\n{folder / name}.csv, {len(table)} rows",
            *([table.markdown()] if len(table) <= SHOWN else []),
            sep="\n",
        )
    print(f"{user_time() - start:.1f} s of CPU")
    _draw(study, study.tables() | tables, out)


def check(study: Study) -> int:
    """Compute and compare with the committed tables: 1 if they differ."""
    differences = study.differences(study.compute())
    print(
        f"{study.name}: {'differs' if differences else 'as committed'}",
        *differences,
        sep="\n  ",
    )
    return int(bool(differences))


def _draw(study: Study, tables: Tables, out: Path | None) -> None:
    for path in study.draw(tables, out):
        print(path)


def markdown_list() -> str:
    """The list of studies/README.md: one line for each folder."""
    folders = [study for study in studies().values() if "/" not in study.name]
    rows = [
        f"| [{study.name}]({study.name}) | {study.title} | {study.cost} |"
        for study in folders
    ]
    return "\n".join(
        [BEGIN, "", "| study | about | CPU |", "|---|---|---|", *rows, "", END]
    )


def with_list(text: str) -> str:
    """The README with its list brought up to date."""
    before, _, rest = text.partition(BEGIN)
    return before + markdown_list() + rest.partition(END)[2]
