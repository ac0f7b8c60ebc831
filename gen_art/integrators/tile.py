"""The pieces that every step kernel shares: a tile's local vectors, and the loops that sum a composition's terms over it.

Each loop over lanes stands innermost, reads global memory and stores only to locals, so that it vectorises; repeats
(octaves) are run-time loops outside it.
"""

from gen_art.backend.kernel_views import parameters, particle, traced
from gen_art.backend.runtime import impl, make_matrix, ti
from gen_art.colliders.surface import make_surface
from gen_art.forces.base import is_steady, term_acceleration
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.pushers import phase_corrected, relativistic
from gen_art.maths.elementary import phi
from gen_art.particles.fixed import is_fixed
from gen_art.particles.rows import CHARGE, FIRST_ATTRIBUTE, LIFETIME, MASS, PX, PY, PZ, VX, VY, VZ

__all__ = [
    "WIDTH",
    "TileTerms",
    "accumulate",
    "copy",
    "flow",
    "kick",
    "lifespan",
    "load",
    "repeats",
    "specific_charge",
    "step_of",
    "store",
    "tile",
    "view",
    "weight",
]

WIDTH = 16


class Tile:
    """Local vectors of WIDTH lanes, one for each name, made while a kernel is traced."""

    _data_oriented = True

    def __init__(self, names: str):
        for name in names.split():
            setattr(self, name, impl.expr_init(make_matrix([0.0] * WIDTH)))

    @traced
    def at(self, *parts):
        """The vector whose name is made of these parts: at("u", 0, 2) is u02."""
        return getattr(self, "".join(map(str, parts)))


@traced
def tile(names: str) -> Tile:
    return Tile(names)


class TileTerms:
    """A composition as the kernels walk it. Each entry is (force, offset of its numbers, offset of its repeat count, index)."""

    _data_oriented = True

    def __init__(
        self, composition: KernelTerms, channels: tuple, pairs: int, rotates: tuple = ("", False, False), real=None
    ):
        self.pusher, self.relativistic, self.exact = rotates
        index = {id(t): k for k, t in enumerate(composition.terms)}
        entry = lambda t: (t.force, t.offset, t.count_offset(), index.get(id(t), -1))  # noqa: E731
        self.pushes = [(*entry(t), t.medium) for t in composition.pushes]  # and the medium it looks at, or -1
        self.magnetics = [entry(t) for t in composition.magnetics]
        self.dampings = [(t.force, t.offset, t.medium, index[id(t)]) for t in composition.dampings]
        self.media = [[entry(t) for t in terms] for terms in composition.media]
        self.rows = {name: FIRST_ATTRIBUTE + k for k, name in enumerate(channels)}
        self.pairs = pairs
        self.walls = []  # (collider, offset of its numbers, bit of its first side, row in the ledger)
        bit = 0
        for k, t in enumerate(composition.colliders):
            self.walls.append((t.force, t.offset, bit, len(composition.terms) + pairs + k))
            bit += t.force.sides
        self.surface = make_surface(self.walls, real) if self.walls else None
        self.mass_loss_terms = [entry(t) for t in composition.mass_loss_terms]
        self.potentials = [entry(t) for t in composition.potentials]
        self.exhaust = (
            len(composition.terms) + pairs + len(self.walls)
        )  # the ledger's row of the first burner's exhaust
        self.start = "x0 x1 x2 v0 v1 v2" if self.walls else ""  # what collisions keep of the start of a step
        self.worked = not all(t.force.conservative or not t.force.does_work for t in composition.terms)
        self.worked = self.worked or any(wall[0].turns for wall in self.walls)
        self.quadratic = any(t.force.quadratic_damping for t in composition.dampings)
        self.count = len(composition.terms)
        steady = all(
            is_steady(t.force) for t in (*composition.terms, *(t for terms in composition.media for t in terms))
        )
        # what `accumulate` leaves in the tile holds for the next step too, where no position changes in between
        self.kept = steady and not (self.magnetics or self.walls or self.mass_loss_terms)
        self.turns_alone = bool(self.magnetics) and not self.dampings
        names = ["a0 a1 a2 g0 g1 g2 h age t"]
        names += [f"k{d} q{d}" for d in range(len(self.dampings))]
        names += [f"u{m}0 u{m}1 u{m}2" for m in range(len(self.media))]
        if self.mass_loss_terms:
            names.append("m w")  # mass at the stage, and its loss in kg/s
        if self.magnetics:
            names.append("b0 b1 b2")
        self.vectors = " ".join(names)


@traced
def view(terms: TileTerms, S, K, i, x, v, age, flow=None, mass=None, step=None):
    """The particle `p` in slot i as forces see it, moved to position x, velocity v, age.

    flow is its medium's velocity; mass what it weighs where it burns, with the age at the start of its step and the step.
    """
    row = lambda r: impl.subscript(None, S, r, i)  # noqa: E731
    key = make_matrix([impl.subscript(None, K, 0, i), impl.subscript(None, K, 1, i)])
    extra = {name: row(r) for name, r in terms.rows.items()}
    if flow is not None:
        extra["flow"] = flow
    if step is not None:
        extra["since"], extra["step"] = step
    return particle(
        position=x,
        velocity=v,
        mass=row(6) if mass is None else mass,
        charge=row(7),
        radius=row(8),
        lifetime=row(9),
        age=age,
        key=key,
        **extra,
    )


@traced
def flow(L, medium: int, j):
    """The velocity of a medium in lane j, once `accumulate` has summed it; None where a term looks at no medium."""
    if medium < 0:
        return None
    return make_matrix([impl.subscript(None, L.at("u", medium, c), j) for c in range(3)])


@traced
def weight(terms: TileTerms, L, j):
    """A lane's mass at the stage, where it burns; else None: the stored one."""
    return impl.subscript(None, L.m, j) if terms.mass_loss_terms else None


@traced
def step_of(terms: TileTerms, L, j):
    """The age at the start of a lane's own step and the step's length, where it burns; else None."""
    return (impl.subscript(None, L.age, j), impl.subscript(None, L.h, j)) if terms.mass_loss_terms else None


@ti.func
def specific_charge(terms: ti.template(), L: ti.template(), S: ti.template(), i, j):
    """Charge over mass."""
    ratio = S[CHARGE, i + j] / S[MASS, i + j]
    if ti.static(len(terms.mass_loss_terms) > 0):
        ratio = S[CHARGE, i + j] / L.m[j]
    return ratio


@ti.func
def repeats(Q: ti.template(), offset: ti.template()):
    count = 1
    if ti.static(offset >= 0):
        count = ti.cast(Q[offset], ti.i32)
    return count


@ti.func
def load(T: ti.template(), S: ti.template(), i):
    for j in range(WIDTH):
        T.x0[j], T.x1[j], T.x2[j] = S[PX, i + j], S[PY, i + j], S[PZ, i + j]
        T.v0[j], T.v1[j], T.v2[j] = S[VX, i + j], S[VY, i + j], S[VZ, i + j]


@ti.func
def copy(T: ti.template(), F: ti.template()):
    """T = F, lane by lane."""
    for j in range(WIDTH):
        T.x0[j], T.x1[j], T.x2[j] = F.x0[j], F.x1[j], F.x2[j]
        T.v0[j], T.v1[j], T.v2[j] = F.v0[j], F.v1[j], F.v2[j]


@ti.func
def store(T: ti.template(), S: ti.template(), i):
    for j in range(WIDTH):
        S[PX, i + j], S[PY, i + j], S[PZ, i + j] = T.x0[j], T.x1[j], T.x2[j]
        S[VX, i + j], S[VY, i + j], S[VZ, i + j] = T.v0[j], T.v1[j], T.v2[j]


@ti.func
def lifespan(L: ti.template(), S: ti.template(), birth: ti.template(), i, now, dt, earliest, real: ti.template()):
    """Each lane's own step: the part of [now, now + dt] it is alive; its age and the time where that part begins."""
    for j in range(WIDTH):
        since = birth[i + j] - now
        start = ti.max(since, earliest)
        end = ti.min(since + ti.cast(S[LIFETIME, i + j], ti.f64), dt)
        own = ti.cast(ti.max(end - start, ti.f64(0.0)), real)
        L.h[j] = ti.select(is_fixed(S[LIFETIME, i + j]), own * 0.0, own)
        L.age[j] = ti.cast(start - since, real)
        L.t[j] = ti.cast(now + start, real)


@ti.func
def accumulate(
    terms: ti.template(),
    L: ti.template(),
    X: ti.template(),
    S: ti.template(),
    K: ti.template(),
    A: ti.template(),
    Q: ti.template(),
    i,
    tau,
):
    """Sum every term at the state X of the tile and the fraction tau of each lane's step, into L."""
    if ti.static(len(terms.mass_loss_terms) > 0):
        for j in range(WIDTH):
            L.m[j] = S[MASS, i + j] - tau * L.h[j] * L.w[j]
    for j in range(WIDTH):
        L.a0[j], L.a1[j], L.a2[j] = 0.0, 0.0, 0.0
    for k in ti.static(range(terms.pairs)):
        for j in range(WIDTH):
            L.a0[j] += A[3 * k, i + j]
            L.a1[j] += A[3 * k + 1, i + j]
            L.a2[j] += A[3 * k + 2, i + j]
    for m in ti.static(range(len(terms.media))):
        for j in range(WIDTH):
            L.at("u", m, 0)[j], L.at("u", m, 1)[j], L.at("u", m, 2)[j] = 0.0, 0.0, 0.0
        for force, offset, count, _ in ti.static(terms.media[m]):
            for repeat in range(repeats(Q, count)):
                for j in range(WIDTH):
                    x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
                    v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
                    p = view(
                        terms,
                        S,
                        K,
                        i + j,
                        x,
                        v,
                        L.age[j] + tau * L.h[j],
                        None,
                        weight(terms, L, j),
                        step_of(terms, L, j),
                    )
                    u = force.acceleration(p, L.t[j] + tau * L.h[j], parameters(Q, force, offset, repeat))
                    L.at("u", m, 0)[j] += u[0]
                    L.at("u", m, 1)[j] += u[1]
                    L.at("u", m, 2)[j] += u[2]
    for force, offset, count, _, medium in ti.static(terms.pushes):
        for repeat in range(repeats(Q, count)):
            for j in range(WIDTH):
                x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
                v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
                p = view(
                    terms,
                    S,
                    K,
                    i + j,
                    x,
                    v,
                    L.age[j] + tau * L.h[j],
                    flow(L, medium, j),
                    weight(terms, L, j),
                    step_of(terms, L, j),
                )
                a = term_acceleration(force, p, L.t[j] + tau * L.h[j], parameters(Q, force, offset, repeat))
                L.a0[j] += a[0]
                L.a1[j] += a[1]
                L.a2[j] += a[2]
    for d in ti.static(range(len(terms.dampings))):
        for j in range(WIDTH):
            x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
            v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
            p = view(terms, S, K, i + j, x, v, L.age[j] + tau * L.h[j], None, weight(terms, L, j), step_of(terms, L, j))
            q = parameters(Q, terms.dampings[d][0], terms.dampings[d][1])
            rates = terms.dampings[d][0].damping(p, L.t[j] + tau * L.h[j], q)
            L.at("k", d)[j], L.at("q", d)[j] = rates[0], rates[1]
    if ti.static(len(terms.magnetics) > 0):
        for j in range(WIDTH):
            L.b0[j], L.b1[j], L.b2[j] = 0.0, 0.0, 0.0
        for force, offset, count, _ in ti.static(terms.magnetics):
            for repeat in range(repeats(Q, count)):
                for j in range(WIDTH):
                    x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
                    v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
                    p = view(
                        terms,
                        S,
                        K,
                        i + j,
                        x,
                        v,
                        L.age[j] + tau * L.h[j],
                        None,
                        weight(terms, L, j),
                        step_of(terms, L, j),
                    )
                    field = force.magnetic(p, L.t[j] + tau * L.h[j], parameters(Q, force, offset, repeat))
                    L.b0[j] += field[0]
                    L.b1[j] += field[1]
                    L.b2[j] += field[2]


@ti.func
def damped(terms: ti.template(), L: ti.template(), j, v, w, h):
    """dv/dt = a + sum k_i (u_i - v) over h from v, solved exactly with k_i = rate_i + quadratic_i abs(w - u_i) held."""
    rate = h * 0.0
    pull = ti.Vector([L.a0[j], L.a1[j], L.a2[j]])
    for d in ti.static(range(len(terms.dampings))):
        m = ti.static(terms.dampings[d][2])
        u = ti.Vector([L.at("u", m, 0)[j], L.at("u", m, 1)[j], L.at("u", m, 2)[j]])
        k = L.at("k", d)[j] + L.at("q", d)[j] * (w - u).norm()
        rate += k
        pull += k * u
    return v + (h * phi(rate * h)) * (pull - rate * v)


@ti.func
def push(terms: ti.template(), L: ti.template(), j, v, h):
    """Acceleration and drag over h. The quadratic rate is taken at the predicted middle: second order, terminal speed exact."""
    result = v + h * ti.Vector([L.a0[j], L.a1[j], L.a2[j]])
    if ti.static(len(terms.dampings) > 0):
        middle = v
        if ti.static(terms.quadratic):
            middle = damped(terms, L, j, v, v, 0.5 * h)
        result = damped(terms, L, j, v, middle, h)
    return result


@ti.func
def rotated(v, omega, h):
    """v turned about omega by the angle 2 atan(abs(omega) h / 2): Boris's rotation, which keeps abs(v)."""
    t = omega * (0.5 * h)
    s = t * (2.0 / (1.0 + t.dot(t)))
    return v + (v + v.cross(t)).cross(s)


@ti.func
def kick(terms: ti.template(), L: ti.template(), X: ti.template(), S: ti.template(), i, fraction, light):
    """Advance the tile's velocities by a fraction of each lane's step under what `accumulate` left in L; light : c, m/s."""
    for j in range(WIDTH):
        v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
        h = fraction * L.h[j]
        if ti.static(terms.relativistic):
            omega = v * 0.0
            if ti.static(len(terms.magnetics) > 0):
                omega = ti.Vector([L.b0[j], L.b1[j], L.b2[j]]) * specific_charge(terms, L, S, i, j)
            v = relativistic(terms, v, ti.Vector([L.a0[j], L.a1[j], L.a2[j]]), omega, h, light)
        elif ti.static(len(terms.magnetics) == 0):
            v = push(terms, L, j, v, h)
        else:
            omega = ti.Vector([L.b0[j], L.b1[j], L.b2[j]]) * specific_charge(terms, L, S, i, j)
            if ti.static(terms.pusher != ""):
                if ti.static(terms.exact):
                    a, turn = phase_corrected(ti.Vector([L.a0[j], L.a1[j], L.a2[j]]), omega, h, 1.0, 1.0)
                    L.a0[j], L.a1[j], L.a2[j] = a[0], a[1], a[2]
                    omega = turn
                v = push(terms, L, j, v, 0.5 * h)
                v = rotated(v, omega, h)
                v = push(terms, L, j, v, 0.5 * h)
            else:
                turn = v.cross(omega)
                L.a0[j] += turn[0]
                L.a1[j] += turn[1]
                L.a2[j] += turn[2]
                v = push(terms, L, j, v, h)
        X.v0[j], X.v1[j], X.v2[j] = v[0], v[1], v[2]
