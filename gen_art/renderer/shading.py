"""From particles to the picture: where each is projected, how large, in what colour, with what light.

One kernel serves all looks. It processes LANES particles at a time in local arrays, which lets the compiler vectorise it.

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths.elementary import exp
from gen_art.particles.rows import CHARGE, LIFETIME, MASS, PX, PY, PZ, RADIUS, VX, VY, VZ
from gen_art.renderer.colour import TABLE
from gen_art.renderer.look_tables import (
    ALBEDO,
    AREA_OF,
    AXES,
    BLEND,
    COLOR,
    CONSERVE,
    DUTY,
    EMITS,
    FALLOFF,
    FAR,
    FILM_TIME,
    FIRST_ENTRY,
    FOCUS,
    FOG_BLUE,
    FOG_GREEN,
    FOG_RATE,
    FOG_RED,
    FOG_START,
    INTENSITY,
    KELVIN,
    KIND,
    LENS,
    LIT,
    MARGIN,
    NEAR,
    OPACITY,
    ORTHOGRAPHIC,
    OVERLAP,
    PIECES,
    POSITION,
    QUANTITIES,
    RAMP_CHANNEL,
    RAMP_LOW,
    RAMP_SCALE,
    RAMP_SLOT,
    RAMPS,
    RANDOM,
    RAW,
    RIBBON,
    ROWS,
    SCALE,
    SHUTTER,
    SIZE,
    SIZE_MODE,
    SIZE_VALUE,
    SNAP,
    STROBE_HI,
    STROBE_LO,
    TIME,
    WEIGHT,
    WIDEST,
    WIDTH,
    LookTables,
)
from gen_art.renderer.piece_rows import NO_PIECES, PIECE_HEAD, PIECE_LIGHT, PIECE_OLD, PIECE_WIDTH
from gen_art.renderer.projected_particles import (
    FIRST_ALBEDO,
    LIT_EXTINCTION,
    LIT_RADIUS,
    ProjectedParticles,
)
from gen_art.renderer.spacing import NO_SPACING
from gen_art.renderer.sprite import (
    ALPHA,
    AREA,
    BLUE,
    DEPTH,
    DISC,
    DX,
    DY,
    EDGE,
    FOOTPRINT,
    FOOTPRINT_PER_RADIUS,
    GREEN,
    HIDDEN,
    KERNEL_VARIANCE,
    MIN_FOOTPRINT,
    MIN_RIM,
    OUTSIDE,
    PICTURE,
    POINT,
    RED,
    SPHERE,
    STREAK,
    X,
    Y,
)  # fmt: skip

__all__ = ["shade"]

LANES = 8
BLOCK = 2048  # particles per iteration of the parallel loop
REFERENCE_ROWS = 720.0  # a "pixel" of a preset is 1/720 of the picture's height
FARTHEST = 1e30  # a sum of coordinates that are numbers; beyond it nothing is drawn
BOKEH = 0.25 / KERNEL_VARIANCE  # square of the footprint whose kernel has the variance of an even disc of radius 1
# Half widths of an even disc's rim that keep the second moment: of a sharp disc out of focus by 1, and, as a
# share of its footprint, of a soft one.
SHARP_RIM, SOFT_RIM = (0.2 / KERNEL_VARIANCE) ** 0.5, 0.8**0.5
# radius^2 / (disc^2 + circle^2) where disc and circle of confusion are nearly of one size: a cone, all rim.
CONE_RADIUS2 = (1.0 + KERNEL_VARIANCE) / (1.0 + 6.0 * KERNEL_VARIANCE + 0.021)
# quantities that a ramp may follow, in the order of preset.look.BY; RANDOM is in look_tables
Q_AGE, Q_SECONDS, Q_SPEED, Q_ENERGY, Q_CHARGE, Q_MASS, Q_RADIUS, Q_ID, _, Q_DISTANCE, Q_X, Q_Y, Q_Z, Q_ACCELERATION = (
    range(QUANTITIES)
)

F64, D2, U2, I1, L1, F1, F2, F3 = (
    ti.types.ndarray(d, n)
    for d, n in ((ti.f64, 1), (ti.f64, 2), (ti.u32, 2), (ti.i32, 1), (ti.i64, 1), (ti.f32, 1), (ti.f32, 2), (ti.f32, 3))
)


@ti.func
def uniform01(low, high, channel):
    """A random number in 0..1 from a particle's key: PCG's output permutation over a mix of the words."""
    s = (low ^ ti.u32(channel)) * ti.u32(747796405) + ti.u32(2891336453)
    s = s ^ (high * ti.u32(277803737))
    s = s * ti.u32(747796405) + ti.u32(2891336453)
    w = ((s >> ((s >> ti.u32(28)) + ti.u32(4))) ^ s) * ti.u32(277803737)
    w = (w >> ti.u32(22)) ^ w
    return ti.cast(w >> ti.u32(8), ti.f32) * (1.0 / 16777216.0)


@ti.func
def _clip(p, q, low, high):
    """Liang and Barsky's step: narrow [low, high] to the t with p * t <= q."""
    if p < 0.0:
        low = ti.max(low, q / p)
    elif p > 0.0:
        high = ti.min(high, q / p)
    elif q < 0.0:
        high = -1.0
    return low, high


@ti.func
def _lanes(value):
    return ti.Vector([value] * LANES)


@ti.kernel
def _shade(
    S: ti.types.ndarray(ndim=2), V: ti.types.ndarray(ndim=2), birth: F64, key: U2, id: L1, source: I1, tag_rows: I1,
    acceleration: F1, booked: D2, n: ti.i32, C: F2, A: F2, ramps: F2, curves: F2, colours: F3, Q: F64, pieces: F2,
    spacing: F1,
):  # fmt: skip
    """Project n particles, and give each its size, colour and light.

    V : positions and velocities as the camera sees them, in the rows of S; S itself where nothing bends light
    booked : (entries, capacity) J, see Particles
    C : (11, n) channels of the projected particles, written
    A : (n, 8) columns LIT_... of lit particles, written for a lit look
    ramps, curves, colours : see LookTables
    Q : numbers of look_tables.kernel_numbers
    pieces : (8, n) of piece_rows, for pieces of curved streaks
    spacing : (n,) m, distances to neighbours, or (1,) where the look has no `spread`
    """
    ti.loop_config(block_dim=1)
    for block in range((n + BLOCK - 1) // BLOCK):
        kind, scale = ti.cast(Q[KIND], ti.i32), ti.cast(Q[SCALE], ti.f32)
        parallel = Q[ORTHOGRAPHIC] > 0.5
        near, far = ti.cast(Q[NEAR], ti.f32), ti.cast(Q[FAR], ti.f32)
        width, rows = ti.cast(Q[WIDTH], ti.f32), ti.cast(Q[ROWS], ti.f32)
        accelerations = acceleration.shape[0]
        for tile in range(block * BLOCK // LANES, ti.min((block + 1) * BLOCK, n + LANES - 1) // LANES):
            i0 = tile * LANES
            right, up, ahead = _lanes(0.0), _lanes(0.0), _lanes(0.0)
            v_right, v_up, v_ahead = _lanes(0.0), _lanes(0.0), _lanes(0.0)
            px, py, dx, dy, pixels_per_unit = _lanes(0.0), _lanes(0.0), _lanes(0.0), _lanes(0.0), _lanes(0.0)
            visible_part = _lanes(0.0)  # share of the streak that is in the frame; 0 for a particle that is not drawn
            alive = _lanes(0.0)  # 1 for a particle that exists: it shadows others from behind the camera too
            quantity = ti.Vector([0.0] * ((QUANTITIES + RAMPS) * LANES))
            for j in range(LANES):
                i = i0 + j
                x = ti.cast(ti.cast(V[PX, i], ti.f64) - Q[POSITION], ti.f32)
                y = ti.cast(ti.cast(V[PY, i], ti.f64) - Q[POSITION + 1], ti.f32)
                z = ti.cast(ti.cast(V[PZ, i], ti.f64) - Q[POSITION + 2], ti.f32)
                u, v, w = ti.cast(V[VX, i], ti.f32), ti.cast(V[VY, i], ti.f32), ti.cast(V[VZ, i], ti.f32)
                a = ti.Vector([ti.cast(Q[AXES + k], ti.f32) for k in range(9)])
                right[j], v_right[j] = a[0] * x + a[1] * y + a[2] * z, a[0] * u + a[1] * v + a[2] * w
                up[j], v_up[j] = a[3] * x + a[4] * y + a[5] * z, a[3] * u + a[4] * v + a[5] * w
                ahead[j], v_ahead[j] = a[6] * x + a[7] * y + a[8] * z, a[6] * u + a[7] * v + a[8] * w
                u, v, w = ti.cast(S[VX, i], ti.f32), ti.cast(S[VY, i], ti.f32), ti.cast(S[VZ, i], ti.f32)
                age, lifetime = ti.cast(Q[TIME] - birth[i], ti.f32), ti.cast(S[LIFETIME, i], ti.f32)
                mass, squared = ti.cast(S[MASS, i], ti.f32), u * u + v * v + w * w
                x, y, z = ti.cast(S[PX, i], ti.f32), ti.cast(S[PY, i], ti.f32), ti.cast(S[PZ, i], ti.f32)
                quantity[Q_AGE * LANES + j], quantity[Q_SECONDS * LANES + j] = age / ti.max(lifetime, 1e-30), age
                quantity[Q_SPEED * LANES + j], quantity[Q_ENERGY * LANES + j] = ti.sqrt(squared), 0.5 * mass * squared
                quantity[Q_CHARGE * LANES + j], quantity[Q_MASS * LANES + j] = ti.cast(S[CHARGE, i], ti.f32), mass
                quantity[Q_RADIUS * LANES + j] = ti.cast(S[RADIUS, i], ti.f32)
                quantity[Q_ID * LANES + j] = ti.cast(id[i], ti.f32)
                quantity[Q_DISTANCE * LANES + j] = ti.sqrt(x * x + y * y + z * z)
                quantity[Q_X * LANES + j], quantity[Q_Y * LANES + j], quantity[Q_Z * LANES + j] = x, y, z
                quantity[Q_ACCELERATION * LANES + j] = acceleration[ti.min(i, accelerations - 1)]
                exists = (
                    (i < n) & (age >= 0.0) & (age < lifetime) & (abs(right[j]) + abs(up[j]) + abs(ahead[j]) < FARTHEST)
                )
                visible = exists & (ahead[j] < far) & ((ahead[j] >= near) | (kind == STREAK))
                alive[j] = ti.select(exists, 1.0, 0.0)
                visible_part[j] = ti.select(visible, 1.0, 0.0)
            if Q[PIECES] > 0.5:  # their ends are given, and one moves from the old end to the head in a unit of time
                for j in range(ti.min(LANES, n - i0)):
                    i = i0 + j
                    right[j], up[j], ahead[j] = (
                        pieces[PIECE_HEAD, i],
                        pieces[PIECE_HEAD + 1, i],
                        pieces[PIECE_HEAD + 2, i],
                    )
                    v_right[j], v_up[j] = right[j] - pieces[PIECE_OLD, i], up[j] - pieces[PIECE_OLD + 1, i]
                    v_ahead[j] = ahead[j] - pieces[PIECE_OLD + 2, i]
            if kind == STREAK:
                for j in range(LANES):
                    if visible_part[j] > 0.0:
                        lapse = ti.min(ti.cast(Q[SHUTTER], ti.f32), ti.max(quantity[Q_SECONDS * LANES + j], 0.0))
                        if Q[PIECES] > 0.5:
                            lapse = 1.0
                        head = ti.Vector([right[j], up[j], ahead[j]])
                        old_end = head - ti.Vector([v_right[j], v_up[j], v_ahead[j]]) * lapse
                        near_low, near_high = _clip(head[2] - old_end[2], head[2] - near, 0.0, 1.0)
                        visible_part[j] = 0.0
                        if near_high > near_low:
                            clipped_end = head + (old_end - head) * near_high
                            head = head + (old_end - head) * near_low
                            scale_head, scale_end = scale, scale
                            if not parallel:
                                scale_head, scale_end = scale / head[2], scale / clipped_end[2]
                            hx, hy = 0.5 * width + head[0] * scale_head, 0.5 * rows - head[1] * scale_head
                            ox = hx - (0.5 * width + clipped_end[0] * scale_end)
                            oy = hy - (0.5 * rows - clipped_end[1] * scale_end)
                            low, high = 0.0, 1.0
                            p = ti.Vector([ox, -ox, oy, -oy])
                            q = ti.Vector([hx + width, 2.0 * width - hx, hy + rows, 2.0 * rows - hy])
                            for e in range(4):
                                low, high = _clip(p[e], q[e], low, high)
                            if high > low:
                                px[j], py[j] = hx - ox * low, hy - oy * low
                                dx[j], dy[j] = ox * (high - low), oy * (high - low)
                                visible_part[j] = (near_high - near_low) * (high - low)
                            pixels_per_unit[j], ahead[j] = scale_head, head[2]
            else:
                for j in range(LANES):
                    depth = ti.select(visible_part[j] > 0.0, ahead[j], 1.0)
                    pixels_per_unit[j] = ti.select(parallel, scale, scale / depth)
                    px[j], py[j] = 0.5 * width + right[j] * pixels_per_unit[j], 0.5 * rows - up[j] * pixels_per_unit[j]
            # the six ramps, each by its quantity
            table_index = ti.Vector([0.0] * (RAMPS * LANES))
            value = ti.Vector([0.0] * (3 * LANES))
            for k in range(RAMPS):
                if ramps[k, RAMP_SCALE] == 0.0:  # a constant: it needs no index into its table
                    if k < 3:
                        for j in range(LANES):
                            value[k * LANES + j] = curves[k, 0]
                else:
                    slot = ti.cast(ramps[k, RAMP_SLOT], ti.i32) * LANES
                    channel = ti.cast(ramps[k, RAMP_CHANNEL], ti.i32)
                    if channel >= 0:
                        for j in range(LANES):
                            quantity[slot + j] = ti.cast(S[channel, i0 + j], ti.f32)
                    if channel <= FIRST_ENTRY:
                        for j in range(LANES):
                            quantity[slot + j] = ti.cast(booked[FIRST_ENTRY - channel, i0 + j], ti.f32)
                    if slot == RANDOM * LANES:
                        for j in range(LANES):
                            quantity[slot + j] = uniform01(key[0, i0 + j], key[1, i0 + j], 11)
                    for j in range(LANES):
                        t = ti.min(ti.max((quantity[slot + j] - ramps[k, RAMP_LOW]) * ramps[k, RAMP_SCALE], 0.0), 1.0)
                        table_index[k * LANES + j] = t * (TABLE - 1.0)
                    if k < 3:
                        for j in range(LANES):
                            t = table_index[k * LANES + j]
                            at = ti.min(ti.cast(t, ti.i32), TABLE - 2)
                            first = curves[k, at]
                            value[k * LANES + j] = first + (curves[k, at + 1] - first) * (t - ti.cast(at, ti.f32))
            if Q[PIECES] > 0.5:
                for j in range(ti.min(LANES, n - i0)):
                    value[INTENSITY * LANES + j] *= pieces[PIECE_LIGHT, i0 + j]
                    if Q[RIBBON] > 0.5:
                        value[SIZE * LANES + j] *= pieces[PIECE_WIDTH, i0 + j]
            # radius in pixels, the area that its light is multiplied by, and its coverage
            radius, area, light, fog = _lanes(0.0), _lanes(0.0), _lanes(0.0), _lanes(1.0)
            optical_depth, coverage = _lanes(0.0), _lanes(0.0)
            mode = ti.cast(Q[SIZE_MODE], ti.i32)
            pixel = rows / REFERENCE_ROWS
            for j in range(LANES):
                size = ti.select(mode == 0, quantity[Q_RADIUS * LANES + j], ti.cast(Q[SIZE_VALUE], ti.f32))
                size *= value[SIZE * LANES + j]
                radius[j] = size * ti.select(mode == 2, pixel, pixels_per_unit[j])
                dot = pixel * value[SIZE * LANES + j]
                a = ti.cast(Q[AREA_OF], ti.f32) * radius[j] * radius[j]
                a = ti.select((kind == POINT) & (mode < 2), dot * dot, a)
                swept_area = ti.sqrt(dx[j] * dx[j] + dy[j] * dy[j]) * ti.sqrt(ti.cast(Q[AREA_OF], ti.f32)) * radius[j]
                a = ti.select(Q[RIBBON] > 0.5, swept_area, a)
                area[j] = ti.select(Q[RAW] > 0.5, width * rows, a)
                falloff = ti.cast(Q[FALLOFF], ti.f32) / ti.max(ahead[j] * ahead[j], 1e-30)
                falloff = ti.select((Q[FALLOFF] > 0.0) & (not parallel), falloff, 1.0)
                light[j] = value[INTENSITY * LANES + j] * ti.cast(Q[WEIGHT], ti.f32) * falloff
                light[j] *= ti.select((Q[RIBBON] > 0.5) & (visible_part[j] > 0.0), 1.0, visible_part[j])
                ratio = ti.cast(Q[CONSERVE], ti.f32) * pixels_per_unit[j] / ti.max(radius[j], 1e-30)
                optical_depth[j] = value[OPACITY * LANES + j] * ti.select(Q[CONSERVE] > 0.0, ratio * ratio, 1.0)
            if Q[OVERLAP] > 0.0:
                distances = spacing.shape[0]
                for j in range(LANES):
                    distance = spacing[ti.min(i0 + j, distances - 1)] * ti.cast(Q[OVERLAP], ti.f32)
                    wider = ti.max(distance * pixels_per_unit[j] / ti.max(radius[j], 1e-30), 1.0)
                    wider = ti.min(wider, ti.cast(Q[WIDEST], ti.f32))
                    radius[j], area[j] = radius[j] * wider, area[j] * (wider * wider)
                    light[j], optical_depth[j] = light[j] / (wider * wider), optical_depth[j] / (wider * wider)
            if Q[STROBE_HI] > 0.0:
                for j in range(LANES):
                    key_low, key_high = key[0, i0 + j], key[1, i0 + j]
                    f = Q[STROBE_LO] + (Q[STROBE_HI] - Q[STROBE_LO]) * ti.cast(uniform01(key_low, key_high, 5), ti.f64)
                    phase = Q[FILM_TIME] * f + ti.cast(uniform01(key_low, key_high, 6), ti.f64)
                    light[j] *= ti.select(phase - ti.floor(phase) < Q[DUTY], 1.0, 0.0)
            if Q[BLEND] > 0.5:
                for j in range(LANES):
                    opacity = ti.select(Q[BLEND] > 1.5, 1.0, 1.0 - exp(-optical_depth[j]))
                    coverage[j] = ti.select(visible_part[j] > 0.0, opacity * area[j], 0.0)
            if Q[FOG_RATE] > 0.0:
                for j in range(LANES):
                    fog_depth = ti.max(ahead[j] - ti.cast(Q[FOG_START], ti.f32), 0.0) * ti.cast(Q[FOG_RATE], ti.f32)
                    fog[j] = exp(-fog_depth)
            # emitted light, and the light of a lamp that the particle would reflect
            red, green, blue = _lanes(0.0), _lanes(0.0), _lanes(0.0)
            if Q[EMITS] > 0.5:
                blackbody = ti.Vector([0.0] * (3 * LANES))
                for c in ti.static(range(3)):
                    for j in range(LANES):
                        blackbody[c * LANES + j] = colours[0, 0, c]
                if ramps[KELVIN, RAMP_SCALE] > 0.0:
                    for j in range(LANES):
                        t = table_index[KELVIN * LANES + j]
                        at = ti.min(ti.cast(t, ti.i32), TABLE - 2)
                        for c in ti.static(range(3)):
                            first = colours[0, at, c]
                            change = colours[0, at + 1, c] - first
                            blackbody[c * LANES + j] = first + change * (t - ti.cast(at, ti.f32))
                for j in range(LANES):
                    t, row, factor = table_index[COLOR * LANES + j], tag_rows[2 * source[i0 + j]], light[j] * area[j]
                    at = ti.min(ti.cast(t, ti.i32), TABLE - 2)
                    f = t - ti.cast(at, ti.f32)
                    c, d, e = colours[row, at, 0], colours[row, at, 1], colours[row, at, 2]
                    red[j] = (c + (colours[row, at + 1, 0] - c) * f) * blackbody[j] * factor
                    green[j] = (d + (colours[row, at + 1, 1] - d) * f) * blackbody[LANES + j] * factor
                    blue[j] = (e + (colours[row, at + 1, 2] - e) * f) * blackbody[2 * LANES + j] * factor
            if Q[BLEND] > 0.5:
                for j in range(LANES):
                    t = table_index[ALBEDO * LANES + j]
                    at = ti.min(ti.cast(t, ti.i32), TABLE - 2)
                    row, f, factor = tag_rows[2 * source[i0 + j] + 1], t - ti.cast(at, ti.f32), coverage[j] * fog[j]
                    c, d, e = colours[row, at, 0], colours[row, at, 1], colours[row, at, 2]
                    c = (c + (colours[row, at + 1, 0] - c) * f) * factor
                    d = (d + (colours[row, at + 1, 1] - d) * f) * factor
                    e = (e + (colours[row, at + 1, 2] - e) * f) * factor
                    fog_light = coverage[j] * (1.0 - fog[j])
                    red[j] = red[j] * fog[j] + fog_light * ti.cast(Q[FOG_RED], ti.f32)
                    green[j] = green[j] * fog[j] + fog_light * ti.cast(Q[FOG_GREEN], ti.f32)
                    blue[j] = blue[j] * fog[j] + fog_light * ti.cast(Q[FOG_BLUE], ti.f32)
                    if Q[LIT] > 0.5:
                        # the first rows of table_index are free now: they hold the lit particles' columns
                        table_index[j], table_index[LANES + j], table_index[2 * LANES + j] = c, d, e
                        world_footprint = radius[j] / pixels_per_unit[j] * FOOTPRINT_PER_RADIUS
                        extinction = optical_depth[j] * AREA * world_footprint * world_footprint
                        table_index[3 * LANES + j] = alive[j] * extinction
                    else:
                        red[j], green[j], blue[j] = red[j] + c, green[j] + d, blue[j] + e
            else:
                for j in range(LANES):
                    red[j], green[j], blue[j] = red[j] * fog[j], green[j] * fog[j], blue[j] * fog[j]
            # footprint and edge, with the lens; a particle off the picture or without light is hidden
            footprint, edge = _lanes(0.0), _lanes(0.0)
            for j in range(LANES):
                circle = ti.cast(Q[LENS], ti.f32) * abs(scale / ti.cast(Q[FOCUS], ti.f32) - pixels_per_unit[j])
                sharp_footprint = radius[j] * FOOTPRINT_PER_RADIUS
                dot = (kind == POINT) & (mode < 2)
                widened = ti.sqrt(sharp_footprint * sharp_footprint + MIN_FOOTPRINT * MIN_FOOTPRINT)
                soft_footprint = ti.select(dot, MIN_FOOTPRINT, widened)
                s = ti.sqrt(soft_footprint * soft_footprint + circle * circle * BOKEH)
                # a random number spreads the size at which sprites move to a coarser framebuffer
                e = -uniform01(key[0, i0 + j], key[1, i0 + j], 21)
                if (kind <= DISC) & (circle > soft_footprint):  # an even disc; a smaller circle only widens the sprite
                    s, e = circle, SOFT_RIM * soft_footprint
                elif dot & (Q[LENS] == 0.0):
                    s = 0.0
                elif kind == SPHERE:
                    s = ti.max(
                        ti.max(radius[j], circle), ti.sqrt((radius[j] * radius[j] + circle * circle) * CONE_RADIUS2)
                    )
                    e = ti.max(ti.min(SHARP_RIM * ti.min(radius[j], circle), s), MIN_RIM)
                elif kind == PICTURE:
                    s, e = ti.sqrt(radius[j] * radius[j] + 1.0 + circle * circle), 0.0
                    dx[j] = quantity[Q_SECONDS * LANES + j]  # an image's AGE and RANDOM
                    dy[j] = uniform01(key[0, i0 + j], key[1, i0 + j], 31)
                if Q[PIECES] > 0.5 and Q[RIBBON] < 0.5:
                    s = ti.max(s * pieces[PIECE_WIDTH, ti.min(i0 + j, n - 1)], MIN_FOOTPRINT)
                footprint[j], edge[j] = s, e
                margin = (ti.max(s, 1.0) + e) * ti.cast(Q[MARGIN], ti.f32) + ti.select(
                    kind == STREAK, ti.max(abs(dx[j]), abs(dy[j])), 0.0
                )
                on_picture = (visible_part[j] > 0.0) & (px[j] > -margin) & (px[j] < width + margin)
                on_picture = on_picture & (py[j] > -margin) & (py[j] < rows + margin)
                has_light = (coverage[j] > 0.0) | (red[j] + green[j] + blue[j] > 0.0) | (Q[LIT] > 0.5)
                footprint[j] = ti.select(on_picture & has_light, footprint[j], HIDDEN)
            for j in range(ti.min(LANES, n - i0)):
                i = i0 + j
                at = ti.select(Q[SNAP] > 0.5, ti.floor(px[j]) + 0.5, px[j])
                C[X, i] = ti.select(footprint[j] == HIDDEN, OUTSIDE, at)
                C[Y, i] = ti.select(Q[SNAP] > 0.5, ti.floor(py[j]) + 0.5, py[j])
                C[DX, i], C[DY, i] = dx[j], dy[j]
                C[FOOTPRINT, i], C[EDGE, i], C[DEPTH, i] = footprint[j], edge[j], ahead[j]
                C[RED, i], C[GREEN, i], C[BLUE, i], C[ALPHA, i] = red[j], green[j], blue[j], coverage[j]
            if Q[LIT] > 0.5:
                for j in range(ti.min(LANES, n - i0)):
                    i = i0 + j
                    for c in ti.static(range(3)):
                        A[i, c], A[i, FIRST_ALBEDO + c] = ti.cast(S[c, i], ti.f32), table_index[c * LANES + j]
                    A[i, LIT_EXTINCTION], A[i, LIT_RADIUS] = table_index[3 * LANES + j], radius[j] / pixels_per_unit[j]


shade_kernel = kernel(_shade)


NO_ACCELERATION = np.zeros(1, np.float32)
NOTHING_BOOKED = np.zeros((1, 1))


def shade(
    projected: ProjectedParticles, system, shading: LookTables, numbers: np.ndarray, acceleration=None, seen=None,
    pieces=NO_PIECES, distances=NO_SPACING,
) -> None:  # fmt: skip
    """Project a system's particles. For a lit look also fill `projected.lit`; the scattered light is added later.

    numbers : of look_tables.kernel_numbers
    acceleration : (n,) m/s^2, 0 unless given
    seen : (6, capacity) positions and velocities as the camera sees them; the particles' own unless given
    pieces : (8, n) of piece_rows where the system's particles are pieces of curved streaks and numbers[PIECES] is 1
    distances : (n,) m to the neighbours, of spacing.py, for a look with `spread`
    """
    n = int(system.count)
    projected.reserve(n, numbers[LIT] > 0.5)
    if n:
        shade_kernel(
            system.floats, system.floats if seen is None else seen, system.birth, system.key, system.id, system.source,
            shading.rows(system.sources),
            NO_ACCELERATION if acceleration is None else acceleration, system.booked if system.entries else NOTHING_BOOKED, n,
            projected.channels, projected.lit, shading.ramps, shading.curves, shading.colours, numbers,
            pieces, distances,
        )  # fmt: skip
