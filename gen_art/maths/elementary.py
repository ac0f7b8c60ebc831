"""Elementary functions that can be vectorised and give the same bits with every C library.

A scalar call of libm prevents LLVM from vectorising Taichi's inner loops, which is 8 to 10 times slower. These functions use
range reduction and a polynomial, in the precision of the kernel. They work on scalars and, component by component, on vectors.

Accuracy over the stated ranges: 2 ulp in float32, 1e-15 relative (exp, log, phi) or absolute (sin, cos) in float64.
Source: range reduction after Cody & Waite, Software Manual for the Elementary Functions (1980); Taylor and atanh series.
"""

from gen_art.backend.runtime import is_f64, real, ti
from gen_art.maths.series import ATANH, COS, EXP, EXPM1, HALF_PI, LN2, SIN

__all__ = ["sin", "cos", "exp", "log", "power", "phi"]

Expr = ti.lang.expr.Expr


@ti.func
def _horner(x, coefficients: ti.template()):
    y = x * 0.0 + coefficients[0]
    for k in ti.static(range(1, len(coefficients))):
        y = y * x + coefficients[k]
    return y


@ti.func
def _two_to(n):
    """2 to the power n (an i32), made by writing the bits of the exponent."""
    result = n * 0.0
    if ti.static(is_f64()):
        result = ti.bit_cast((ti.cast(n, ti.i64) + ti.i64(1023)) << ti.i64(52), ti.f64)
    else:
        result = ti.bit_cast((n + 127) << 23, ti.f32)
    return result


@ti.func
def _exp(x):
    """e^x; 0 below -87 (f32) or -708 (f64); above 88 or 709 the value there."""
    low, high = ti.static((-708.0, 709.0) if is_f64() else (-87.0, 88.0))
    y = ti.min(ti.max(x, low), high)
    n = ti.floor(y * 1.4426950408889634 + 0.5)
    ln2 = ti.static(LN2[is_f64()])
    r = (y - n * ln2[0]) - n * ln2[1]
    return ti.select(x < low, 0.0, _horner(r, EXP[is_f64()]) * _two_to(ti.cast(n, ti.i32)))


@ti.func
def _log(x):
    """Natural logarithm of x > 0 (normal numbers)."""
    e = 0
    m = x * 0.0
    if ti.static(is_f64()):
        bits = ti.bit_cast(x, ti.i64)
        e = ti.cast(bits >> ti.i64(52), ti.i32) - 1023
        m = ti.bit_cast((bits & ti.i64(0xFFFFFFFFFFFFF)) | ti.i64(0x3FF0000000000000), ti.f64)
    else:
        bits = ti.bit_cast(x, ti.i32)
        e = (bits >> 23) - 127
        m = ti.bit_cast((bits & 0x7FFFFF) | 0x3F800000, ti.f32)
    big = m > 1.4142135623730951
    m = ti.select(big, m * 0.5, m)
    n = ti.cast(ti.select(big, e + 1, e), real())
    s = (m - 1.0) / (m + 1.0)
    ln2 = ti.static(LN2[is_f64()])
    return n * ln2[0] + (n * ln2[1] + 2.0 * s * _horner(s * s, ATANH[is_f64()]))


@ti.func
def _sine(x, quarter):
    """sin(x + quarter * pi/2) for abs(x) up to 1e4 (f32) or 1e8 (f64)."""
    n = ti.floor(x * 0.6366197723675814 + 0.5)
    part = ti.static(HALF_PI[is_f64()])
    r = ((x - n * part[0]) - n * part[1]) - n * part[2]
    k = ti.cast(n, ti.i32) + quarter
    r2 = r * r
    y = ti.select((k & 1) == 1, _horner(r2, COS[is_f64()]), r * _horner(r2, SIN[is_f64()]))
    return ti.select((k & 2) == 2, -y, y)


def _components(x) -> int:
    """The number of components of a value while a kernel is traced; 0 for a scalar."""
    if isinstance(x, ti.Matrix):
        return x.n
    return x.get_shape()[0] if isinstance(x, Expr) and x.is_tensor() else 0


_components._is_wrapped_kernel = (
    True  # stops Taichi's warning about plain Python functions that are called while tracing
)


@ti.func
def _each(f: ti.template(), x):
    result = x
    if ti.static(_components(x) > 0):
        for c in ti.static(range(_components(x))):
            result[c] = f(x[c])
    else:
        result = f(x)
    return result


@ti.func
def _sin(x):
    return _sine(x, 0)


@ti.func
def _cos(x):
    return _sine(x, 1)


@ti.func
def exp(x):
    """e^x, for scalars and vectors; 0 below -87 (float32) or -708 (float64)."""
    return _each(_exp, x)


@ti.func
def log(x):
    """Natural logarithm of x > 0, for scalars and vectors."""
    return _each(_log, x)


@ti.func
def sin(x):
    """Sine of x in radians; abs(x) up to 1e4 in float32, 1e8 in float64."""
    return _each(_sin, x)


@ti.func
def cos(x):
    """Cosine of x in radians; abs(x) up to 1e4 in float32, 1e8 in float64."""
    return _each(_cos, x)


@ti.func
def power(x, y):
    """x^y for x >= 0; 0 at x = 0, for every y."""
    return ti.select(x > 0.0, _exp(y * _log(ti.max(x, ti.static(1e-300 if is_f64() else 1e-37)))), 0.0)


@ti.func
def phi(z):
    """(1 - e^-z) / z, without cancellation near 0: the mean of e^-s over [0, z]; z from -87 (f32) or -708 on."""
    limit = ti.static(708.0 if is_f64() else 87.0)
    y = ti.min(ti.max(z, -limit), limit)
    n = ti.floor(0.5 - y * 1.4426950408889634)
    ln2 = ti.static(LN2[is_f64()])
    r = (-y - n * ln2[0]) - n * ln2[1]
    scale = _two_to(ti.cast(n, ti.i32))
    shrink = scale * r * _horner(r, EXPM1[is_f64()]) + (scale - 1.0)
    tiny = ti.static(1e-290 if is_f64() else 1e-30)
    near = ti.abs(z) <= tiny
    return ti.select(near, 1.0, -shrink / ti.select(near, 1.0, z))
