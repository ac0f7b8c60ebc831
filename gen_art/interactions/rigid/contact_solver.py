"""The impulses of all contacts of one system at one moment.

Before a drift, no gap may close within it, and what comes in fast leaves at once, with restitution times its speed; at the
end of a step, what touches must not approach. What has sunk in, as bodies that spin against each other do by a little, is
moved apart again, slowly and without speed. Where the speeds that restitution asks for would gain energy, as they can with
friction or several contacts at once, the impulses are taken part of the way from the inelastic ones: as far as none is gained.
"""

import numpy as np

from gen_art.interactions.rigid.kernels import NUMBERS, contact_kernel
from gen_art.interactions.rigid.quaternions import cross

__all__ = ["ContactSolver"]

_OVERLAP = 5e-3  # of the smaller body's size: what is left alone
_PART = 0.1  # of what is beyond it, taken back in a step
_EXACT = 1e-8  # of the largest speed: what a sweep over the contacts may still change


class ContactSolver:
    """Impulses are (k, 3): along the normal and two tangents. `hits` (k,): contacts that bounce; `sign` (k, 1): -1 where the
    wall stands first."""

    def __init__(self, contacts, v: np.ndarray, w: np.ndarray, turn):
        self._contacts, self._world = contacts, contacts.world
        world, k = contacts.world, len(contacts.gap)
        n = contacts.normal
        across = np.zeros((k, 3))
        across[np.arange(k), np.abs(n).argmin(1)] = 1.0
        u = cross(n, across)
        u /= np.sqrt((u * u).sum(1))[:, None]
        self._frame = np.stack([n, u, cross(n, u)], 1)
        one, two = contacts.first, contacts.second
        self._a, self._b = np.maximum(one, 0), np.maximum(two, 0)
        self._on_a, self._on_b = (one >= 0)[:, None], (two >= 0)[:, None]
        self._ra = np.where(self._on_a, contacts.point - world.x[self._a], 0.0)
        self._rb = np.where(self._on_b, contacts.point - world.x[self._b], 0.0)
        self.sign = np.where(self._on_a, 1.0, -1.0)
        self._surface = np.zeros((k, 3))
        met = contacts.wall >= 0
        self._surface[met] = contacts.walls.velocity[contacts.wall[met]] * self.sign[met]
        self._aims(v, w, turn)

    def _sides(self, v, w):
        """(k, 3) each: velocities of the two bodies at the contacts."""
        one = np.where(self._on_a, v[self._a] + cross(w[self._a], self._ra), 0.0)
        return one, np.where(self._on_b, v[self._b] + cross(w[self._b], self._rb), 0.0)

    def _slip(self, v, w):
        one, two = self._sides(v, w)
        return one - two - self._surface

    def _aims(self, v, w, turn) -> None:
        """What each contact asks for: the least speed along its normal, without bounces and with them, and its friction."""
        world, contacts, n = self._world, self._contacts, self._contacts.normal
        was, now = self._sides(v, w), self._sides(world.v, world.w)
        self._before, self._after = was[0] - was[1] - self._surface, now[0] - now[1] - self._surface
        w0, w1 = (self._before * n).sum(1), (self._after * n).sum(1)
        laws = contacts.laws[contacts.wall + 1]
        whole = turn.dt / turn.kick
        # what presses two bodies together may be what pulls both of them against a third
        pull = whole * sum(np.abs(((b - a) * n).sum(1)) for a, b in zip(was, now))
        fast = (-laws[:, 0] * w0 > pull) & (w0 < 0)
        span = turn.drift if turn.drift > 0 else turn.dt
        self._soft = -np.maximum(contacts.gap, 0.0) / span
        self.lone, self.wait = np.zeros(len(w0), bool), np.zeros(len(w0))
        if turn.drift > 0:
            self.hits = fast & (contacts.gap + span * w1 < 0)
            self._meet_in_time(w1, turn)
            w0 = (self._before * n).sum(1)
            self._hard = np.where(self.hits, w1 - (1 + laws[:, 0]) * w0, self._soft)
        else:
            self.hits = fast
            self._soft = np.where(fast, -1e300, self._soft)  # it hits in the next step, with its restitution
            self._hard = self._soft
        slide = self._before - w0[:, None] * n
        change = whole * sum(np.sqrt(((b - a) ** 2).sum(1)) for a, b in zip(was, now))
        self._friction = np.where((slide * slide).sum(1) <= change**2, laws[:, 2], laws[:, 1])

    def _meet_in_time(self, w1: np.ndarray, turn) -> None:
        """Find the time of impact of balls that meet nothing but one wall, and the speed that forces give them until then.

        Other shapes turn on their way to the wall, and a blow off their middle turns them: they bounce where they are.

        lone (k,): such contacts     wait (k,): s from the start of the drift to the impact
        """
        contacts, many = self._contacts, len(self._world.members)
        one, two = contacts.first, contacts.second
        met = np.bincount(one[one >= 0], minlength=many) + np.bincount(two[two >= 0], minlength=many)
        alone = met[np.maximum(one, two)] == 1
        turned = sum(np.abs(cross(arm, contacts.normal)).max(1) for arm in (self._ra, self._rb))
        central = turned <= 1e-9 * contacts.sizes
        self.lone = self.hits & alone & central & (contacts.wall >= 0) & (contacts.gap > 0)
        self.wait[self.lone] = -contacts.gap[self.lone] / w1[self.lone]
        self._before += (self.wait / turn.kick)[:, None] * (self._after - self._before)

    def late(self, v: np.ndarray, w: np.ndarray) -> np.ndarray | None:
        """Shifts (b, 3) m and turns (b, 3) rad, as v and w (b, 3), from before the impulses, hold until the impact; or None."""
        if not self.lone.any():
            return None
        world, out = self._world, np.zeros((len(v), 6))
        k = np.flatnonzero(self.lone)
        b = np.maximum(self._contacts.first, self._contacts.second)[k]
        out[b] = self.wait[k, None] * np.concatenate([v - world.v, w - world.w], 1)[b]
        return out

    def _solved(self, aim: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Impulses for the aims, and how they change the speeds at the contacts, both (k, 3)."""
        world = self._world
        C = self._numbers(aim)
        C[:, 16], C[:, 17:20] = self._friction, start
        C[:, 20:23] = (self._frame * self._surface[:, None]).sum(2)
        V = self._swept(C, np.concatenate([world.v, world.w], 1))
        change = self._slip(V[:, :3], V[:, 3:]) - self._after
        return C[:, 17:20], (self._frame * change[:, None]).sum(2)

    def _numbers(self, aim: np.ndarray) -> np.ndarray:
        C = np.zeros((len(aim), NUMBERS))
        C[:, 0:3], C[:, 3:6], C[:, 6:15], C[:, 15] = self._ra, self._rb, self._frame.reshape(-1, 9), aim
        return C

    def _swept(self, C: np.ndarray, start: np.ndarray) -> np.ndarray:
        """Velocities and spins (b, 6) after the contacts C have acted on those at the start; their impulses are left in C."""
        contacts, world, many = self._contacts, self._world, len(start)
        V, B = np.zeros((many + 1, 6)), np.zeros((many + 1, 10))
        V[:many], B[:many, 0], B[:many, 1:] = start, world.ease, world.J.reshape(-1, 9)
        one, two = (np.where(i >= 0, i, many).astype(np.int32) for i in (contacts.first, contacts.second))
        tolerance = (
            _EXACT * float(max(np.abs(V).max(), np.abs(C[:, 15]).max(where=C[:, 15] > -1e299, initial=0))) + 1e-300
        )
        contact_kernel()(B, V, one, two, C, np.zeros((len(C), 36)), np.zeros((len(C), 9)), contacts.most, tolerance)
        return V[:many]

    def parting(self) -> np.ndarray | None:
        """Shifts (b, 3) m and turns (b, 3) rad that take bodies apart by a part of what they overlap by; None if they do not."""
        contacts = self._contacts
        deep = np.maximum(-contacts.gap - _OVERLAP * contacts.sizes, 0.0)
        if not deep.any():
            return None
        return self._swept(
            self._numbers(_PART * deep - np.maximum(contacts.gap, 0.0)), np.zeros((len(self._world.v), 6))
        )

    def impulses(self, start: np.ndarray) -> np.ndarray:
        """What the contacts give, found from the guess `start`."""
        start = np.where(self.hits[:, None], 0.0, start)
        full, answer = self._solved(self._hard, start)
        if self._hard is self._soft or not self.hits.any():
            return full
        before = (self._frame * self._before[:, None]).sum(2)
        gained = (full * (before + 0.5 * answer)).sum()
        if gained <= 0:
            return full
        least, least_answer = self._solved(self._soft, start)
        way, way_answer = full - least, answer - least_answer
        flat = (least * (before + 0.5 * least_answer)).sum()
        slope = (way * before).sum() + 0.5 * ((least * way_answer).sum() + (way * least_answer).sum())
        bend = 0.5 * (way * way_answer).sum()
        room = max(flat, 0.0) - flat
        if gained <= max(flat, 0.0) or bend <= 0:
            return full
        part = (np.sqrt(max(slope * slope + 4 * bend * room, 0.0)) - slope) / (2 * bend)
        return least + min(max(part, 0.0), 1.0) * way

    def give(self, impulses: np.ndarray) -> np.ndarray:
        """Let the bodies take them; returns the impulses (k, 3), N s, in the world, on the first of each pair."""
        given = (self._frame * impulses[:, :, None]).sum(1)
        P, L = np.zeros_like(self._world.v), np.zeros_like(self._world.v)
        for body, on, arm, way in ((self._a, self._on_a, self._ra, 1.0), (self._b, self._on_b, self._rb, -1.0)):
            on = on[:, 0]
            np.add.at(P, body[on], way * given[on])
            np.add.at(L, body[on], way * cross(arm[on], given[on]))
        self._world.impulse(P, L)
        return given
