"""Estimate of one degree of freedom in numba: every sum over the samples in one vectorised pass."""

from __future__ import annotations

from numba import njit


@njit(fastmath=True)
def instruments(zeta, near):  # type: ignore[no-untyped-def]
    """What depends on the instruments alone: their sums with each other, bordered by 1."""
    p, n = len(zeta), zeta[0].shape[0]
    for i in range(p):
        x = zeta[i]
        for j in range(p):
            y = zeta[j]
            total = 0.0
            for k in range(n):
                total += x[k] * y[k]
            near[i, j] = total
        total = 0.0
        for k in range(n):
            total += x[k]
        near[i, p] = near[p, i] = total
    near[p, p] = n


@njit(fastmath=True)
def four(z, f0, f1, f2, target, a, near, b, i):  # type: ignore[no-untyped-def]
    """Row i of the sums for four regressors: ζᵢ with φ and with the target. The last regressor is an input."""
    n = target.shape[0]
    a0 = a1 = a2 = t = 0.0
    for k in range(n):
        x = z[k]
        a0, a1, a2 = a0 + x * f0[k], a1 + x * f1[k], a2 + x * f2[k]
        t += x * target[k]
    a[i, 0], a[i, 1], a[i, 2], a[i, 3], a[i, 4] = a0, a1, a2, near[i, 3], near[i, 4]
    b[i] = t


@njit(fastmath=True)
def three(z, f0, f1, target, a, near, b, i):  # type: ignore[no-untyped-def]
    """The same for three regressors."""
    n = target.shape[0]
    a0 = a1 = t = 0.0
    for k in range(n):
        x = z[k]
        a0, a1 = a0 + x * f0[k], a1 + x * f1[k]
        t += x * target[k]
    a[i, 0], a[i, 1], a[i, 2], a[i, 3] = a0, a1, near[i, 2], near[i, 3]
    b[i] = t


@njit(fastmath=True)
def intercept_row(phi, target, a, near, b):  # type: ignore[no-untyped-def]
    """The last row of the sums: the instrument 1."""
    p, n = len(phi), target.shape[0]
    for j in range(p - 1):
        total = 0.0
        for k in range(n):
            total += phi[j][k]
        a[p, j] = total
    total = 0.0
    for k in range(n):
        total += target[k]
    b[p] = total
    a[p, p - 1], a[p, p] = near[p, p - 1], near[p, p]


@njit(fastmath=True)
def invert(a, m, inverse):  # type: ignore[no-untyped-def]
    """Inverse of the leading m × m block of `a`, which is destroyed: Gauss–Jordan with row exchanges."""
    for i in range(m):
        for j in range(m):
            inverse[i, j] = 1.0 if i == j else 0.0
    for c in range(m):
        pivot = c
        for i in range(c + 1, m):
            if abs(a[i, c]) > abs(a[pivot, c]):
                pivot = i
        if pivot != c:
            for j in range(m):
                a[c, j], a[pivot, j] = a[pivot, j], a[c, j]
                inverse[c, j], inverse[pivot, j] = inverse[pivot, j], inverse[c, j]
        scale = 1.0 / a[c, c]
        for j in range(m):
            a[c, j] *= scale
            inverse[c, j] *= scale
        for i in range(m):
            factor = a[i, c]
            if i != c and factor != 0.0:
                for j in range(m):
                    a[i, j] -= factor * a[c, j]
                    inverse[i, j] -= factor * inverse[c, j]


@njit(fastmath=True)
def solved(p, inverse, b, theta):  # type: ignore[no-untyped-def]
    """The estimate without its intercept."""
    for i in range(p):
        total = 0.0
        for j in range(p + 1):
            total += inverse[i, j] * b[j]
        theta[i] = total
