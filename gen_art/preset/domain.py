"""The keys of `domain:`, the space in which all systems are."""

from typing import Annotated

from pydantic import model_validator

from gen_art.errors import UsageError
from gen_art.particles.periodic_box import PeriodicBox
from gen_art.preset.fields import Parsed, Vector
from gen_art.preset.model import Model, about, collected
from gen_art.preset.values import shown

__all__ = ["Domain", "Periodic"]


def _axes(value):
    if not isinstance(value, str):
        raise UsageError(f"must be some of xyz, such as xy, not {shown(value)}")
    return value


class Periodic(Model):
    """A box in which space repeats: what leaves it on one side comes in at the other, with the same velocity."""

    min: Vector = about(..., "its corner with the smallest coordinates", unit="m")
    max: Vector = about(..., "its corner with the largest coordinates, which are no more in the box", unit="m")
    axes: Annotated[str, Parsed(_axes, {"type": "string", "pattern": "^[xyz]{1,3}$"})] = about(
        "xyz", "the axes along which space repeats: some of xyz, such as `xy`; along the others it is open"
    )

    @model_validator(mode="after")
    def _box(self):
        try:
            PeriodicBox(self.min, self.max, self.axes)
        except UsageError as error:
            raise collected([((str(error).partition(" ")[0],), str(error))]) from None
        return self


class Domain(Model):
    """The space of all systems; without it space is open, without limits."""

    periodic: Periodic = about(..., "a periodic box")

    @property
    def box(self) -> PeriodicBox:
        return PeriodicBox(self.periodic.min, self.periodic.max, self.periodic.axes)
