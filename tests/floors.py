"""Print the lowest versions that pyproject.toml declares, as a constraints file for
pip: `make test-floors`.
"""

import re
import tomllib
from pathlib import Path


def floors(extras: tuple[str, ...] = ("test",)) -> list[str]:
    """Return NAME==VERSION of every dependency with a lowest version."""
    project = tomllib.loads(
        (Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8")
    )["project"]
    wanted = [
        *project["dependencies"],
        *(item for extra in extras for item in project["optional-dependencies"][extra]),
    ]
    found = [re.match(r"([A-Za-z0-9_.-]+)>=([0-9.]+)", item) for item in wanted]
    return [f"{match[1]}=={match[2]}" for match in found if match]


if __name__ == "__main__":
    print("\n".join(floors()))
