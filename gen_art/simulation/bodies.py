"""`ga.bodies`: rigid bodies as a ParticleSystem."""

from collections.abc import Iterable, Mapping

from gen_art import arguments
from gen_art.errors import UsageError
from gen_art.interactions import Interaction
from gen_art.interactions.rigid.body import Body
from gen_art.interactions.rigid.group import Group
from gen_art.simulation.system import ParticleSystem

__all__ = ["Bodies", "bodies"]

_NAMED = 6  # bodies that are named where a group says what it is


class Bodies(Group):
    """Rigid bodies and the particles that represent them; `system()` makes a ParticleSystem of them."""

    def __repr__(self) -> str:
        count, names = len(self.members), list(dict.fromkeys(body.name for body in self.members))
        listed = ", ".join(names[:_NAMED]) + (", ..." if len(names) > _NAMED else "")
        return (
            f"<Bodies: {count:,} bod{'y' if count == 1 else 'ies'} ({listed}) of {self.mass.sum():.4g} kg, "
            f"{len(self.mass):,} particles>"
        )

    def system(self, *, rigid: Mapping | None = None, interactions=(), attributes=None, **others) -> ParticleSystem:
        """A ParticleSystem of these bodies.

        rigid : parameters of the interaction `rigid`, a mapping
        The other arguments are those of ParticleSystem.
        """
        return ParticleSystem(
            position=self.position,
            velocity=self.velocity,
            mass=self.mass,
            radius=self.radius,
            fixed=self.fixed,
            attributes={**self.attributes, **_mapping("attributes", attributes)},
            interactions=[
                self.rigid(**_mapping("rigid", rigid)),
                *arguments.instances("interactions", interactions, Interaction, "ga.interactions.SelfGravity(...)"),
            ],
            **others,
        )


def _mapping(name: str, given: Mapping | None) -> Mapping:
    if given is not None and not isinstance(given, Mapping):
        raise UsageError(f"{name} must be a mapping of names to values, not {arguments.shown(given)}")
    return {arguments.text(f"a name in {name}", key): value for key, value in (given or {}).items()}


def bodies(members: Iterable[Body]) -> Bodies:
    """Several bodies as the particles of one system. Raises UsageError if there are none."""
    return Bodies(members)
