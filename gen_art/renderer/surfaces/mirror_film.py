"""What a mirror shows: the scene as a camera behind the mirror sees it, blurred by the mirror's roughness.

The mirrored camera's picture fits the camera's own picture pixel by pixel. A rough plane spreads the reflection: by the slopes of
its facets along the direction in which its normal points in the picture, and by less across it the flatter the view is. Where
the roughness is the same all over, this blurred light is smooth: it is found on a coarse grid of nodes, and linear between them.

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths.array_functions import exp
from gen_art.renderer.camera import CameraView
from gen_art.renderer.surfaces.solids import NEVER

__all__ = ["LEVELS", "NO_MIRROR", "MirrorFilm", "blur_points", "blurred_light", "mirrored_light"]

LEVELS = 7  # of a pyramid of pictures, each of half the size of the one before
POINTS = 8  # at which a rough mirror reads the pyramid, along the direction in which it spreads most
_WEIGHTS = (0.125, 0.375, 0.375, 0.125)
_TEXEL = 0.65  # standard deviation of what a bilinear texel of the pyramid covers, in its sides
_FARTHEST = 2.6  # of the outermost of them, in standard deviations
_NARROWEST, _WIDEST = 0.4, 0.8  # the blur across that direction, in parts of the blur along it
_APART = 0.5  # of nodes, in standard deviations: between them a sharp point is found to 1/8 of the square of it
_FARTHEST_APART = 16  # pixels, so that nodes follow the picture's border

F2, I2 = ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.i32, 2)


def blur_points() -> np.ndarray:
    """(POINTS, 2) float32: places along a line, and weights that make of them a normal distribution of deviation 1, sum 1."""
    place = np.linspace(-_FARTHEST, _FARTHEST, POINTS)
    weight = exp(-0.5 * place * place)
    weight /= weight.sum()
    return np.stack([place / np.sqrt((weight * place * place).sum()), weight], axis=1).astype(np.float32)


@ti.kernel
def _halve(T: F2, levels: I2, level: ti.i32):
    """Fill a level of the pyramid from the level before, with the weights 1, 3, 3, 1 along both axes."""
    ti.loop_config(block_dim=1)
    for row in range(levels[level, 2]):
        fine, width, rows = levels[level - 1, 0], levels[level - 1, 1], levels[level - 1, 2]
        starts = ti.Vector([fine + ti.min(ti.max(2 * row + k - 1, 0), rows - 1) * width for k in range(4)])
        for column in range(levels[level, 1]):
            total = ti.Vector([0.0, 0.0, 0.0, 0.0])
            for j in ti.static(range(4)):
                at = ti.min(ti.max(2 * column + j - 1, 0), width - 1)
                for i in ti.static(range(4)):
                    for c in ti.static(range(4)):
                        total[c] += _WEIGHTS[i] * _WEIGHTS[j] * T[starts[i] + at, c]
            for c in ti.static(range(4)):
                T[levels[level, 0] + row * levels[level, 1] + column, c] = total[c]


_halve_kernel = kernel(_halve)


class MirrorFilm:
    """A picture of linear light and its pyramid.

    size : of the camera's picture, in pixels
    side : of the mirrored picture's own pixels, in pixels of the camera's picture: 1, or 2 where waves blur what it shows
    texels : (n, 4) float32
    levels : (LEVELS + 1, 4) int32, first texel, width, rows and the texels' side of each level; the last row is the grid of
        nodes, with no rows for no grid
    depths : (rows, columns) float32 of the surfaces in it, where waves need them
    """

    def __init__(self, size: tuple[int, int], side: int = 1):
        sides = [side << k for k in range(LEVELS)]
        sizes = [(-(-size[0] // k), -(-size[1] // k)) for k in sides]
        starts = np.cumsum([0] + [w * h for w, h in sizes])
        self.size, self.side = size, side
        rows = [(s, w, h, k) for s, (w, h), k in zip(starts, sizes, sides)]
        self.levels = np.array([*rows, (starts[-1], 0, 0, 0)], np.int32)
        self.texels = np.zeros((int(starts[-1]), 4), np.float32)
        self.depths = np.full((1, 1), NEVER, np.float32)

    def take(self, pixels: np.ndarray, blurred: bool, depths: np.ndarray | None = None) -> None:
        """Take over a picture, (rows, columns, 4), and its depths; the pyramid only if the mirror blurs."""
        if depths is not None:
            self.depths = depths.copy()
        rows, columns = pixels.shape[:2]
        self.texels[: rows * columns].reshape(rows, columns, 4)[:] = pixels
        self.levels[LEVELS, 1:3] = 0
        if blurred:
            for level in range(1, LEVELS):
                _halve_kernel(self.texels, self.levels, level)

    def blur(self, view: CameraView, point, normal, roughness: float) -> None:
        """Blur the picture at the nodes, for a mirror of one roughness; nothing where they would be as many as the pixels.

        view : of the camera that looks at the mirror; point, normal : of the mirror
        """
        scale, normal = view.scale(self.size[1]), np.asarray(normal, np.float64)
        normal = normal / np.sqrt(normal @ normal)
        side = np.sign((view.position - np.asarray(point, np.float64)) @ normal) or 1.0
        along = blur_width(roughness, scale)
        cosine, sine = picture_direction(normal, view)
        # the finest detail that is left along the picture's rows and columns
        finest = 1.0 / np.sqrt(
            np.array([[1, (1 / _NARROWEST) ** 2], [(1 / _NARROWEST) ** 2, 1]]) @ [cosine**2, sine**2]
        )
        apart = np.clip(np.floor(_APART * along * finest), 1, _FARTHEST_APART)
        if apart.prod() < 2:
            return
        columns, rows = (-(-self.size[0] // int(apart[0])) + 1, -(-self.size[1] // int(apart[1])) + 1)
        x, y = np.linspace(0.0, self.size[0], columns), np.linspace(0.0, self.size[1], rows)
        steepness = abs(view.axes[2] @ normal) * np.ones((rows, columns))
        wanted = np.ones((rows, columns), bool)
        if view.height is None:
            right, down = (x - 0.5 * self.size[0]) / scale, (y - 0.5 * self.size[1]) / scale
            offset = right[None, :, None] * view.axes[0] - down[:, None, None] * view.axes[1]
            rays = view.axes[2] + offset
            steepness = abs(rays @ normal) / np.sqrt((rays * rays).sum(axis=2))
            wanted = _beside(rays @ normal * side < 0.0)
        start = int(self.levels[LEVELS, 0])
        if len(self.texels) < start + rows * columns:
            self.texels = np.concatenate([self.texels[:start], np.zeros((rows * columns, 4), np.float32)])
        self.levels[LEVELS, 1:3] = columns, rows
        steepness[~wanted] = -1.0
        _blur_kernel(self.texels, self.levels, blur_points(), steepness.astype(np.float32), along, cosine, sine)


def _beside(meets: np.ndarray) -> np.ndarray:
    """The nodes, (rows, columns) bool, that meet the mirror, and those next to them."""
    padded = np.pad(meets, 1)
    rows = padded[:-2] | padded[1:-1] | padded[2:]
    return rows[:, :-2] | rows[:, 1:-1] | rows[:, 2:]


def blur_width(roughness: float, scale: float) -> float:
    """Standard deviation of a rough mirror's blur, in pixels; scale : pixels of a unit at the distance 1.

    The slopes of facets have the standard deviation alpha / sqrt(2), and a reflected ray turns by twice the angle.
    """
    return 2.0**0.5 * roughness * roughness * scale


def picture_direction(normal, view: CameraView) -> tuple[float, float]:
    """(cosine, sine) of the direction in which a normal points in the picture, to the right and down."""
    right, down = float(view.axes[0] @ normal), -float(view.axes[1] @ normal)
    length = (right * right + down * down) ** 0.5
    return (right / length, down / length) if length > 1e-6 else (0.0, 1.0)


@ti.func
def _texel(T: ti.template(), levels: ti.template(), level, x, y):
    """Light at a place in pixels of the full picture, bilinear in one level, clamped at the border."""
    scale = 1.0 / ti.cast(levels[level, 3], ti.f32)
    start, width, rows = levels[level, 0], levels[level, 1], levels[level, 2]
    u = ti.min(ti.max(x * scale - 0.5, 0.0), ti.cast(width - 1, ti.f32))
    v = ti.min(ti.max(y * scale - 0.5, 0.0), ti.cast(rows - 1, ti.f32))
    i, j = ti.min(ti.cast(v, ti.i32), ti.max(rows - 2, 0)), ti.min(ti.cast(u, ti.i32), ti.max(width - 2, 0))
    fv, fu = v - ti.cast(i, ti.f32), u - ti.cast(j, ti.f32)
    result = ti.Vector([0.0, 0.0, 0.0, 0.0])
    for k in ti.static(range(4)):
        a, b = ti.min(i + k // 2, rows - 1), ti.min(j + k % 2, width - 1)
        weight = (fv if k // 2 else 1.0 - fv) * (fu if k % 2 else 1.0 - fu)
        for c in ti.static(range(4)):
            result[c] += weight * T[start + a * width + b, c]
    return result


@ti.func
def mirrored_light(T: ti.template(), levels: ti.template(), G: ti.template(), x, y, along, across, cosine, sine):
    """(4,) light and coverage of the mirrored picture at a place, blurred.

    along, across : standard deviations in pixels, along the direction (cosine, sine) of the picture and, no larger, across it
    G : (POINTS, 2) of blur_points
    """
    result = ti.Vector([0.0, 0.0, 0.0, 0.0])
    if along < 0.3:
        result = _texel(T, levels, 0, x, y)
    else:
        # the points are no farther apart than what each of them covers
        texel = ti.min(ti.max(across, _NARROWEST * along), _WIDEST * along)
        line, level = ti.sqrt(along * along - texel * texel), 0
        side = texel / (_TEXEL * ti.cast(levels[0, 3], ti.f32))
        while side >= 2.0 and level < LEVELS - 1:
            side *= 0.5
            level += 1
        # most places read the nearer of two levels alone: between 5/4 and 3/2 of a texel's side one blends into the other
        coarser = ti.min(ti.max(4.0 * side - 5.0, 0.0), 1.0)
        if coarser >= 1.0 and level < LEVELS - 1:
            level, coarser = level + 1, 0.0
        for k in range(POINTS):
            u, v = x + line * G[k, 0] * cosine, y + line * G[k, 0] * sine
            light = _texel(T, levels, level, u, v)
            if coarser > 0.0 and level < LEVELS - 1:
                light += (_texel(T, levels, level + 1, u, v) - light) * coarser
            result += G[k, 1] * light
    return result


@ti.kernel
def _blur(T: F2, levels: I2, G: F2, steepness: F2, along: ti.f32, cosine: ti.f32, sine: ti.f32):
    """Fill the nodes; steepness : (rows, columns) cosine of the mirror's normal with the view, -1 for what nobody reads."""
    ti.loop_config(block_dim=1)
    for i in range(levels[LEVELS, 2]):
        columns, rows = levels[LEVELS, 1], levels[LEVELS, 2]
        across, down = ti.cast(levels[0, 1], ti.f32), ti.cast(levels[0, 2], ti.f32)
        for j in range(columns):
            x = across * ti.cast(j, ti.f32) / ti.cast(columns - 1, ti.f32)
            y = down * ti.cast(i, ti.f32) / ti.cast(rows - 1, ti.f32)
            if steepness[i, j] >= 0.0:
                light = mirrored_light(T, levels, G, x, y, along, along * steepness[i, j], cosine, sine)
                for c in ti.static(range(4)):
                    T[levels[LEVELS, 0] + i * columns + j, c] = light[c]


_blur_kernel = kernel(_blur)
NO_MIRROR = MirrorFilm((1, 1))


@ti.func
def blurred_light(T: ti.template(), levels: ti.template(), x, y):
    """(4,) light and coverage at a place in pixels, between the nodes of the blurred picture."""
    columns, rows = levels[LEVELS, 1], levels[LEVELS, 2]
    u = x * (ti.cast(columns - 1, ti.f32) / ti.cast(levels[0, 1], ti.f32))
    v = y * (ti.cast(rows - 1, ti.f32) / ti.cast(levels[0, 2], ti.f32))
    i, j = ti.min(ti.max(ti.cast(v, ti.i32), 0), rows - 2), ti.min(ti.max(ti.cast(u, ti.i32), 0), columns - 2)
    fv, fu = v - ti.cast(i, ti.f32), u - ti.cast(j, ti.f32)
    first, result = levels[LEVELS, 0] + i * columns + j, ti.Vector([0.0, 0.0, 0.0, 0.0])
    for c in ti.static(range(4)):
        upper = T[first, c] + (T[first + 1, c] - T[first, c]) * fu
        lower = T[first + columns, c] + (T[first + columns + 1, c] - T[first + columns, c]) * fu
        result[c] = upper + (lower - upper) * fv
    return result
