"""How a person's hands set the control inputs of a force: sticks, levers, a button and a pointer."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["Button", "Device", "Hands", "Lever", "Pointer", "Stick"]


@dataclass(frozen=True)
class Hands:
    """What keyboard, mouse and gamepad do at a moment.

    held : by key, how far it is pressed, 0 to 1; the mouse's button is the key "mouse"
    point : (3,) m, where the pointer is
    """

    held: Mapping[str, float] = field(default_factory=dict)
    point: tuple[float, float, float] | None = None

    def push(self, keys: tuple[str, ...]) -> float:
        """How far the farthest pressed of these keys is pressed, 0 to 1."""
        return max((min(max(self.held.get(key, 0.0), 0.0), 1.0) for key in keys), default=0.0)


@dataclass(frozen=True)
class Device:
    """The base. Each sets one input, in the units of the table.

    less, more : keys that lower and raise it
    """

    less: tuple[str, ...] = ()
    more: tuple[str, ...] = ()

    def moved(self, value: float, rest: float, hands: Hands, seconds: float) -> float:
        """The input after so many seconds of the film in these hands.

        value : before
        rest : the one at the start
        """
        raise NotImplementedError


@dataclass(frozen=True)
class Stick(Device):
    """An input that goes back to its rest when the keys are let go.

    low, high : its ends
    seconds : from rest to an end, and back
    """

    low: float = -1.0
    high: float = 1.0
    seconds: float = 0.25

    def moved(self, value: float, rest: float, hands: Hands, seconds: float) -> float:
        push = hands.push(self.more) - hands.push(self.less)
        wanted = rest + push * ((self.high - rest) if push > 0 else (rest - self.low))
        most = 0.5 * (self.high - self.low) * seconds / self.seconds
        return min(max(value + min(max(wanted - value, -most), most), self.low), self.high)


@dataclass(frozen=True)
class Lever(Device):
    """An input that stays where it was put.

    low, high : its ends; infinite for an angle that may turn on and on
    rate : its change each second while a key is held
    """

    low: float = 0.0
    high: float = 1.0
    rate: float = 1.0

    def moved(self, value: float, rest: float, hands: Hands, seconds: float) -> float:
        push = hands.push(self.more) - hands.push(self.less)
        return min(max(value + push * self.rate * seconds, self.low), self.high)


@dataclass(frozen=True)
class Button(Device):
    """An input that is `on` while a key is held, and otherwise at its rest; `less` makes it -on."""

    on: float = 1.0

    def moved(self, value: float, rest: float, hands: Hands, seconds: float) -> float:
        push = hands.push(self.more) - hands.push(self.less)
        return rest if push == 0.0 else math.copysign(self.on, push)


@dataclass(frozen=True)
class Pointer(Device):
    """A coordinate of the point that the mouse points at, m.

    axis : 0, 1 or 2
    """

    axis: int = 0

    def moved(self, value: float, rest: float, hands: Hands, seconds: float) -> float:
        return value if hands.point is None else hands.point[self.axis]
