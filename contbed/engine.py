"""Where a run is computed: on this process, or where another engine takes it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from contbed import models
from contbed.scene.tables import SceneBase

Found = TypeVar("Found")


class Engine:
    """One process with scikit-fem and compiled loops; other engines replace some of its
    methods.

    Attributes
    ----------
    name : as `--engine` has it
    tangents : whether the matrices of a solved state are at hand for derivatives
    """

    name = "skfem"
    tangents = True

    def run(self, main: Callable[[], Found]) -> Found:
        """Run what plans, solves and writes; on several ranks only the first one
        returns a result.
        """
        return main()

    def plan(self, scene: SceneBase) -> Any:
        """Return the plan of a scene for this engine.

        Raises
        ------
        SceneError : mesh, flow or closures of the scene cannot be used
        EngineError : the scene does not run on this engine
        """
        return models.plan(scene)

    def usage(self) -> dict[str, Any]:
        """Return what a run has taken on each rank; nothing without ranks."""
        return {}

    def require_all(self, scene: SceneBase) -> None:
        """Require that further runs of a scene can start now, from the process that
        calls this.

        Raises
        ------
        EngineError : other ranks would have to take part, and are not there
        """


class Elsewhere(Engine):
    """An engine that computes the loops of particles.

    Parameters
    ----------
    name : as `--engine` has it
    move : returns a plan with its loops on that engine
    """

    def __init__(self, name: str, move: Callable[[Any], Any]):
        self.name, self._move = name, move

    def plan(self, scene: SceneBase) -> Any:
        """Return the plan of a scene for this engine; raises what `Engine.plan`
        does.
        """
        return self._move(super().plan(scene))
