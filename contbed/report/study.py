"""What a study needs for a report of its own: the file that shows it, and the
sections of the page.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from contbed.output.folder import SUMMARY, read_summary
from contbed.output.shapes import Shape, fitting, read_json
from contbed.report import page

Found = Mapping[str, Any]


@dataclass(frozen=True)
class Content:
    """Title of a page, one line about it, and its sections."""

    title: str
    about: str
    sections: list[str]


@dataclass(frozen=True)
class Study:
    """A kind of study.

    name : what it is, "cascade"
    command : of contbed that writes it
    content : returns the page for a folder and the content of the file; its charts are
        added to the third argument
    is_in : whether a folder holds such a study
    file : in the folder
    """

    name: str
    command: str
    content: Callable[[Path, Found, page.Charts], Content]
    is_in: Callable[[Path], bool]
    file: str = SUMMARY

    def report(self, folder: Path) -> str:
        """Return the page.

        Raises
        ------
        ContbedError : a file of the study is missing or damaged
        """
        file, what = folder / self.file, f"that of a {self.name}"
        remedy = f"run contbed {self.command} again"
        found = read_json(file, Shape, what, remedy)
        made = page.Charts()
        with fitting(file, what, remedy):
            content = self.content(folder, found, made)
            about = content.about
            if "versions" in found:
                about += f"; contbed {found['versions'].get('contbed', '?')}"
        return page.page(
            content.title, [page.header(content.title, about), *content.sections], made
        )


def has(key: str) -> Callable[[Path], bool]:
    """Return whether the summary of a folder has a key that only one kind of study
    has.
    """
    return lambda folder: key in read_summary(folder)
