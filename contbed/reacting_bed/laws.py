"""Rate laws that scenes name: which there are, what they need, and the equations
that belong to them.
"""

from __future__ import annotations

from contbed.closures.reactions import LAWS
from contbed.closures.reactions_reforming import REACTIONS as REFORMING
from contbed.particle.three_interfaces import TAKAHASHI

# three steps, per mole of the reducing gas
_STAGES = (
    "{0} + 3 Fe2O3 -> 2 Fe3O4 + {1}",
    "{0} + Fe3O4 -> 3 FeO + {1}",
    "{0} + FeO -> Fe + {1}",
)
STAGED: dict[str, str] = {f"three_interfaces_{gas}": gas for gas in TAKAHASHI}
IRON = ("Fe2O3", "Fe3O4", "FeO", "Fe")
LAWS_WITH_EQUATION: dict[str, str | tuple[str, ...]] = {
    **REFORMING,
    **{
        f"{name}.{law.name}": law.reaction
        for name, laws in LAWS.items()
        for law in laws.values()
    },
    **{
        key: tuple(stage.format(gas, TAKAHASHI[gas].oxidised) for stage in _STAGES)
        for key, gas in STAGED.items()
    },
}
# keys that each law of a scene's own constants needs
NEEDS: dict[str, tuple[str, ...]] = {
    "power": ("A", "E"),
    "grain": ("A", "E", "grain_radius", "molar_density"),
    "grain_remaining": ("A", "E", "grain_radius", "molar_density"),
    "shrinking_core": ("A", "E", "diffusivity"),
}


def known_laws(name: str) -> list[str]:
    """Return the laws that a reaction of this name may have."""
    return [*NEEDS, *REFORMING, *STAGED, *LAWS.get(name, {})]
