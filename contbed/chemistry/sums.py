"""Sums of pointwise values by name."""

from __future__ import annotations

from typing import Any


class Sums(dict[str, Any]):
    """Sums of pointwise values by name; a name without a value has 0."""

    def add(self, name: str, value: Any) -> None:
        """Add a value to that of a name."""
        self[name] = self[name] + value if name in self else value

    def move(self, source: str, target: str, value: Any) -> None:
        """Take a value from one name and give it to another."""
        self[source], self[target] = self[source] - value, self[target] + value
