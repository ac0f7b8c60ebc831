"""Coefficients of the elementary functions, by whether they are for float64, from the highest power down.

Source: range reduction after Cody & Waite, Software Manual for the Elementary Functions (1980); Taylor and atanh series.
"""

import math

__all__ = ["ATANH", "COS", "EXP", "EXPM1", "HALF_PI", "LN2", "SIN"]

_FACTORIAL = [math.factorial(k) for k in range(20)]
EXP = {
    False: tuple(1 / _FACTORIAL[k] for k in range(7, -1, -1)),
    True: tuple(1 / _FACTORIAL[k] for k in range(13, -1, -1)),
}
EXPM1 = {  # (e^r - 1) / r
    False: tuple(1 / _FACTORIAL[k + 1] for k in range(6, -1, -1)),
    True: tuple(1 / _FACTORIAL[k + 1] for k in range(12, -1, -1)),
}
ATANH = {
    False: tuple(1 / (2 * k + 1) for k in range(5, -1, -1)),
    True: tuple(1 / (2 * k + 1) for k in range(11, -1, -1)),
}
SIN = {
    False: tuple((-1) ** k / _FACTORIAL[2 * k + 1] for k in range(5, -1, -1)),
    True: tuple((-1) ** k / _FACTORIAL[2 * k + 1] for k in range(9, -1, -1)),
}
COS = {
    False: tuple((-1) ** k / _FACTORIAL[2 * k] for k in range(5, -1, -1)),
    True: tuple((-1) ** k / _FACTORIAL[2 * k] for k in range(9, -1, -1)),
}
# pi/2 and ln 2 as sums of parts; the leading parts have so few bits that their product with a small integer is exact
HALF_PI = {
    False: (1.5703125, 4.837512969970703e-4, 7.549789948768648e-8),
    True: (1.5707963109016418, 1.5893254712295857e-8, 6.123233995736766e-17),
}
LN2 = {False: (0.693359375, -2.12194440e-4), True: (0.6931471803691238, 1.9082149292705877e-10)}
