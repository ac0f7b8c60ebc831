"""Forces between particles."""

from gen_art.interactions.base import INTERACTIONS, Interaction, interaction
from gen_art.interactions.coulomb import Coulomb
from gen_art.interactions.pair_force import PairForce
from gen_art.interactions.pair_law import PairLaw
from gen_art.interactions.rigid.interaction import Rigid
from gen_art.interactions.self_gravity import SelfGravity
from gen_art.interactions.sphere_contacts import Contacts
from gen_art.interactions.springs import Springs

__all__ = [
    "INTERACTIONS",
    "Contacts",
    "Coulomb",
    "Interaction",
    "PairForce",
    "PairLaw",
    "Rigid",
    "SelfGravity",
    "Springs",
    "interaction",
]
