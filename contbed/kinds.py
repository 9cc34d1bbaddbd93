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
        "bubbling.settings:BubblingScene",
        "bubbling.checks:CHECKS",
        "bubbling.planning:plan",
        "bubbling.findings:solve",
        "heat",
    ),
    "particles": Kind(
        "dem.settings:ParticleScene", "dem.checks:CHECKS", "dem.study:plan", "dem.study:solve", "heat"
    ),
    "particles_gas": Kind(
        "dem.gas_settings:GasScene",
        "dem.gas_checks:CHECKS",
        "dem.gas_study:plan",
        "dem.gas_study:solve",
        "particles and gas",
    ),
    "two_fluid": Kind(
        "two_fluid.settings:TwoFluidScene",
        "two_fluid.checks:CHECKS",
        "two_fluid.planning:plan",
        "two_fluid.study:solve",
        "flow",
    ),
    "fully_developed": Kind(
        "two_fluid.developed_settings:DevelopedScene",
        "two_fluid.developed_checks:CHECKS",
        "two_fluid.developed_planning:plan",
        "two_fluid.developed_findings:solve",
        "flow",
    ),
}


def find(address: str) -> Any:
    """What stands at "module:name"."""
    module, name = address.split(":")
    return getattr(import_module(f"contbed.{module}"), name)
