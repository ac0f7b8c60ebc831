"""The local vectors of a tile of lanes: its state, what is found for each lane, and how it is loaded and stored."""

from typing import TYPE_CHECKING

from gen_art.backend import intrinsics
from gen_art.backend.kernel_views import traced
from gen_art.backend.runtime import impl, is_f64, make_matrix, real, ti
from gen_art.particles.rows import LIFETIME

if TYPE_CHECKING:
    from gen_art.integrators.particle_tile import TileTerms

__all__ = [
    "STATE", "WIDTH", "Lanes", "age_of", "all_alive", "are_whole", "copy", "lanes", "load", "load_lifespans", "step_of",
    "store", "tile", "time_of",
]  # fmt: skip

WIDTH = 16
STATE = "x0 x1 x2 v0 v1 v2"  # the vectors of a tile that holds positions and velocities


class Tile:
    """Local vectors of WIDTH lanes, one for each name, created while a kernel is traced."""

    _data_oriented = True

    def __init__(self, names: str):
        for name in names.split():
            setattr(self, name, impl.expr_init(make_matrix([0.0] * WIDTH)))

    @traced
    def at(self, *parts):
        """The vector whose name is the concatenation of these parts: at("u", 0, 2) is u02."""
        return getattr(self, "".join(map(str, parts)))


@traced
def tile(names: str) -> Tile:
    return Tile(names)


class Lanes(Tile):
    """What `accumulate` and `lane_steps` find for each lane.

    Where particles are born or die, `h`, `age` and `t` are vectors. Where all are alive all the time, `h` and `t` are the same
    number in every lane, and what follows from them alone is computed once; an age is computed where it is read.
    """

    def __init__(self, terms: "TileTerms"):
        super().__init__(terms.vectors)
        self.lifespans = terms.lifespans
        if terms.lifespans:
            self.birth = impl.expr_init(make_matrix([0.0] * WIDTH, dt=ti.f64))


@traced
def lanes(terms: "TileTerms") -> Lanes:
    return Lanes(terms)


@traced
def all_alive(L: Lanes, h, t, now, birth, i):
    """The same step h at the same time t for every lane; the times of birth are read where an age is."""
    L.h, L.t, L.now, L.birth, L.i = impl.expr_init(h), impl.expr_init(t), now, birth, i


@traced
def are_whole(L: Lanes, whole):
    """Whether the step of every lane is a whole one, or none."""
    L.whole = impl.expr_init(whole)


@traced
def step_of(L: Lanes, j):
    """The part of the step, s, that lane j is alive."""
    return impl.subscript(None, L.h, j) if L.lifespans else L.h


@traced
def time_of(L: Lanes, j):
    """The time, s, at which that part begins."""
    return impl.subscript(None, L.t, j) if L.lifespans else L.t


@traced
def age_of(L: Lanes, j):
    """The age, s, of lane j at that time."""
    if L.lifespans:
        return impl.subscript(None, L.age, j)
    return ti.cast(L.now - impl.subscript(None, L.birth, L.i + j), real())


@ti.func
def load(T: ti.template(), L: ti.template(), S: ti.template(), address, i, first: ti.template()):
    """Read the state of a tile from the rows of S from `first` on; `address` is where the memory of S begins.

    By addresses, because a loop that stores to S does not become vector instructions, and one that reads it asks first whether
    its indices overflow. But by a loop where all lanes are alive: LLVM then keeps the state in registers over several steps.
    """
    if ti.static(intrinsics.HAS_LANES and L.lifespans):
        for row, name in ti.static(enumerate(STATE.split())):
            intrinsics.load_lanes(address_of(S, address, first + row, i), T.at(name), is_f64())
    else:
        for j in range(WIDTH):
            T.x0[j], T.x1[j], T.x2[j] = S[first, i + j], S[first + 1, i + j], S[first + 2, i + j]
            T.v0[j], T.v1[j], T.v2[j] = S[first + 3, i + j], S[first + 4, i + j], S[first + 5, i + j]


@ti.func
def load_lifespans(L: ti.template(), S: ti.template(), address, birth: ti.template(), births_address, i):
    """Read the times of birth and the lifetimes of a tile."""
    if ti.static(intrinsics.HAS_LANES):
        intrinsics.load_lanes(births_address + ti.cast(i, ti.i64) * 8, L.birth, True)
        intrinsics.load_lanes(address_of(S, address, LIFETIME, i), L.lifetime, is_f64())
    else:
        for j in range(WIDTH):
            L.birth[j], L.lifetime[j] = birth[i + j], S[LIFETIME, i + j]


@ti.func
def address_of(S: ti.template(), address, row: ti.template(), i):
    """The address of slot i in a row of S."""
    return address + (ti.cast(S.shape[1], ti.i64) * row + i) * ti.static(8 if is_f64() else 4)


@ti.func
def copy(T: ti.template(), F: ti.template()):
    """T = F, lane by lane."""
    for j in range(WIDTH):
        T.x0[j], T.x1[j], T.x2[j] = F.x0[j], F.x1[j], F.x2[j]
        T.v0[j], T.v1[j], T.v2[j] = F.v0[j], F.v1[j], F.v2[j]


@ti.func
def store(T: ti.template(), S: ti.template(), address, i, first: ti.template()):
    """Write the state of a tile to the rows of S from `first` on."""
    if ti.static(intrinsics.HAS_LANES):
        for row, name in ti.static(enumerate(STATE.split())):
            intrinsics.store_lanes(address_of(S, address, first + row, i), T.at(name), is_f64())
    else:
        for j in range(WIDTH):
            S[first, i + j], S[first + 1, i + j], S[first + 2, i + j] = T.x0[j], T.x1[j], T.x2[j]
            S[first + 3, i + j], S[first + 4, i + j], S[first + 5, i + j] = T.v0[j], T.v1[j], T.v2[j]
