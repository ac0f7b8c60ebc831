"""Forces between particles."""

from gen_art.interactions.base import INTERACTIONS, Interaction, interaction
from gen_art.interactions.gravity import SelfGravity

__all__ = ["INTERACTIONS", "Interaction", "SelfGravity", "interaction"]
