"""Runs `dolfinx_program.py` alone or under mpirun; without DOLFINx each test is
skipped by name.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from dolfinx_launch import PROGRAM, missing, started


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    here = [item for item in items if Path(item.path).parent == PROGRAM.parent]
    reason = missing()
    for item in here if reason else ():
        if not item.get_closest_marker("without_dolfinx"):
            item.add_marker(pytest.mark.skip(reason=reason))


@pytest.fixture(scope="session")
def results(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """Folder with what a command of the program wrote on a number of ranks, run when
    first asked for.
    """
    done: dict[Any, Path] = {}

    def get(command: str, ranks: int, *arguments: Any) -> Path:
        key = (command, ranks, *arguments)
        if key not in done:
            done[key] = tmp_path_factory.mktemp(f"{command}-{ranks}")
            finished = started(ranks, command, done[key], *arguments)
            assert finished.returncode == 0, (
                finished.stdout[-4000:] + finished.stderr[-8000:]
            )
        return done[key]

    return get
