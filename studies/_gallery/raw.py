"""Fields that are too large to commit: a study leaves them here and draws them where they are."""

from __future__ import annotations

from pathlib import Path

RESULTS = Path(__file__).parents[2] / "results" / "studies"


def raw(study: str) -> Path:
    """Folder of the fields of a study, not under version control; it may not exist."""
    return RESULTS / study
