"""The kinds of scenes besides the packed bed: where settings, checks, plan and run of each are. Imported when used."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any


@dataclass(frozen=True)
class Kind:
    """Addresses "module:name" in contbed, and the phase that the timings call the run.

    settings : model of the scene
    checks : what can be wrong with it although every value is right
    plan : of a scene
    solve : (plan, result, folder, quiet, start) fills the result, from the checkpoint `start` unless it is None
    """

    settings: str
    checks: str
    plan: str
    solve: str
    phase: str


KINDS = {
    "bubbling_bed": Kind(
        "bubbling_bed.scene:BubblingScene",
        "bubbling_bed.checks:CHECKS",
        "bubbling_bed.plan:plan",
        "bubbling_bed.results:solve",
        "heat",
    ),
    "particles": Kind("dem.scene:ParticleScene", "dem.checks:CHECKS", "dem.run:plan", "dem.run:solve", "heat"),
    "particles_gas": Kind(
        "cfd_dem.scene:GasScene",
        "cfd_dem.checks:CHECKS",
        "cfd_dem.run:plan",
        "cfd_dem.run:solve",
        "particles and gas",
    ),
    "two_fluid": Kind(
        "two_fluid.scene:TwoFluidScene",
        "two_fluid.checks:CHECKS",
        "two_fluid.plan:plan",
        "two_fluid.run:solve",
        "flow",
    ),
    "fully_developed": Kind(
        "developed_flow.scene:DevelopedScene",
        "developed_flow.checks:CHECKS",
        "developed_flow.plan:plan",
        "developed_flow.results:solve",
        "flow",
    ),
}


def find(address: str) -> Any:
    """What stands at "module:name"."""
    module, name = address.split(":")
    return getattr(import_module(f"contbed.{module}"), name)
