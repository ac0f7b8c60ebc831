"""Whether a user's law of pairs is what it declares: action against reaction, and force against potential."""

from typing import TYPE_CHECKING

import numpy as np

from gen_art.errors import UsageError
from gen_art.interactions.pair_law_kernels import probe_kernel
from gen_art.particles.periodic_box import PeriodicBox
from gen_art.particles.rows import POSITION
from gen_art.particles.storage import Particles

if TYPE_CHECKING:
    from gen_art.interactions.pair_law import PairLaw

__all__ = ["check_reaction_and_potential"]

_PAIRS = 24  # at most
_STEP = 1e-5  # of the differences, relative to the distance
_GRADIENT = 1e-3  # of the largest force: how far it may be from minus the potential's gradient
_REACTION = 1e-6  # of the largest force: how far it may be from minus its reaction
_INSIDE = 0.6  # of the cutoff: where pairs are tried that are farther apart


def check_reaction_and_potential(law: "PairLaw", state: Particles, name: str, box: PeriodicBox | None) -> None:
    """Try a law for particles and the nearest others of the system `name`, in float64.

    Raises UsageError with the forces for a law that is declared reciprocal and is not, and for a potential whose gradient is
    not minus the force.
    """
    n = state.count
    if n < 2:
        return
    chosen = np.unique(np.linspace(0, n - 1, min(n, _PAIRS)).astype(int))
    A, others = state.floats[:, chosen].astype(np.float64), np.empty(len(chosen), int)
    B = np.empty_like(A)
    x = state.floats[POSITION, :n].astype(np.float64)
    for k, slot in enumerate(chosen):
        d = x[:, slot, None] - x
        if box is not None:
            turn = np.divide(1.0, box.lengths, out=np.zeros(3), where=box.lengths > 0)[:, None]
            d -= box.lengths[:, None] * np.floor(d * turn + 0.5)
        squared = (d**2).sum(axis=0)
        squared[slot] = np.inf
        others[k] = other = int(np.argmin(squared))
        distance = float(np.sqrt(squared[other]))
        B[:, k] = state.floats[:, other]
        shrink = 1.0 if law.reach is None else min(1.0, _INSIDE * law.reach / max(distance, 1e-300))
        B[POSITION, k] = A[POSITION, k] - shrink * d[:, other]
    distance = np.sqrt(((A[POSITION] - B[POSITION]) ** 2).sum(axis=0))
    apart = distance > 0
    if not apart.any():
        return
    A, B, chosen, others, distance = A[:, apart], B[:, apart], chosen[apart], others[apart], distance[apart]
    # columns: each pair as it is, then its first particle displaced to both sides along each axis
    pairs = len(chosen)
    A, B, place = np.repeat(A, 7, axis=1), np.repeat(B, 7, axis=1), np.tile(np.arange(7), pairs)
    size = np.repeat(_STEP * distance, 7)
    for c in range(3):
        A[c] += size * ((place == 1 + 2 * c).astype(float) - (place == 2 + 2 * c))
    keys = [np.ascontiguousarray(np.repeat(state.key[:, some], 7, axis=1)) for some in (chosen, others)]
    ages = -np.repeat(np.stack([state.birth[chosen], state.birth[others]]), 7, axis=1)
    out = np.zeros((7, 7 * pairs))
    probe_kernel(law, state.attributes)(A, keys[0], B, keys[1], ages, np.array(law.numbers() or [0.0]), out)
    where = [f"between particles {state.id[i]} and {state.id[j]} of '{name}'" for i, j in zip(chosen, others)]
    _check_reaction(law, out, where)
    if law.conservative:
        _check_potential(law, out, size[::7], where)


def _check_reaction(law: "PairLaw", out: np.ndarray, where: list[str]) -> None:
    F, G = out[:3, ::7], out[3:6, ::7]
    with np.errstate(all="ignore"):
        allowed = _REACTION * np.sqrt(np.maximum((F**2).sum(axis=0), (G**2).sum(axis=0)))
        wrong = np.flatnonzero(np.sqrt(((F + G) ** 2).sum(axis=0)) > allowed)
    if law.reciprocal and len(wrong):
        k = wrong[0]
        raise UsageError(
            f"{type(law).__name__}: action is not reaction {where[k]}: the forces are {_text(F[:, k])} N and {_text(G[:, k])} N, "
            "so that momentum is not conserved; if that is meant, declare reciprocal = False"
        )


def _check_potential(law: "PairLaw", out: np.ndarray, size: np.ndarray, where: list[str]) -> None:
    F, U = out[:3, ::7], out[6].reshape(-1, 7)
    with np.errstate(all="ignore"):
        gradient = np.stack([U[:, 1 + 2 * c] - U[:, 2 + 2 * c] for c in range(3)]) / (2 * size)
        difference = np.sqrt(((F + gradient) ** 2).sum(axis=0))
        noise = 8 * np.finfo(np.float64).eps * np.abs(U).max(axis=1) / size  # the differences of U lose digits
        force = np.sqrt(np.maximum((F**2).sum(axis=0), (gradient**2).sum(axis=0)))
    finite = force[np.isfinite(force)]
    # a force that is small beside those of the others is tried against the middle one: laws vary by many powers of ten
    allowed = _GRADIENT * np.maximum(force, float(np.median(finite)) if len(finite) else 0.0) + noise
    wrong = np.flatnonzero(np.isfinite(difference) & (difference > allowed))
    # a few pairs may be at an edge, where the force jumps
    if len(wrong) > max(1, len(where) // 4) or (len(wrong) and len(where) == 1):
        k = wrong[0]
        raise UsageError(
            f"{type(law).__name__}: its potential is not that of its force: {where[k]} the force is {_text(F[:, k])} N and minus "
            f"the potential's gradient {_text(-gradient[:, k])} N; is a sign or a factor missing?"
        )


def _text(vector: np.ndarray) -> str:
    return f"({', '.join(f'{float(c):.4g}' for c in vector)})"
