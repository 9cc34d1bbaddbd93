"""Scenes of bubbling beds whose coefficients follow from closures."""

from bubbling_scenes import changed

from contbed.loading import from_dict
from tests.scene_text import scene_of

HOT = scene_of(
    """
[bubbling_bed]
height = 0.6
section = 1.0
solids_fraction = 0.5
bubbles = {}
release.rate = 1.2e6
release.length = 0.3
tubes.perimeter = 4.0
tubes.coefficient = "molerus_wirth"
tubes.temperature = 550.0
tubes.emissivity = 0.8
distributor.coefficient = 80.0
distributor.preheat_NTU = 2.5
distributor.emissivity = 0.8
freeboard.temperature = 900.0
[gas]
composition = "N2:0.79, O2:0.21"
[boundary.bottom]
gas.mass_flow = 0.6
gas.temperature = 300.0
[solids.inert]
volume_share = 0.98
diameter = 7e-4
density = 2600.0
heat_capacity = 1000.0
emissivity = 0.6
nusselt = "gunn"
mixing_conductivity = 2e4
[solids.char]
volume_share = 0.02
diameter = 3e-3
density = 1200.0
heat_capacity = [1000.0, 0.5]
emissivity = 0.8
nusselt = "ranz_marshall"
mixing_conductivity = "kunii_levenspiel"
exchange.inert = "agu"
feed.mass_flow = 0.01
feed.temperature = 300.0
feed.height = 0.2
feed.width = 0.05
[radiation]
level = "p1"
[output]
plots = false
fields = false
"""
)


def tables(**changes):
    """The tables of a hot bed; `inlet__mass_flow` replaces one value, a table all of
    a table, None removes it.
    """
    return changed(
        HOT, {tuple(key.split("__")): value for key, value in changes.items()}
    )


def hot(**changes):
    """A scene of a hot bed, with changes as in `tables`."""
    return from_dict(tables(**changes))
