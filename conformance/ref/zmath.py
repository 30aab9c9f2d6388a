# SPDX-License-Identifier: Apache-2.0
"""The matrix arithmetic of spec/zipmap.md section 2: binary64, order of operations as written
there."""

IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def rows(entries) -> tuple:
    """Nine numbers as three rows."""
    return tuple(entries[0:3]), tuple(entries[3:6]), tuple(entries[6:9])


def product(p, q) -> tuple:
    return tuple(tuple((p[r][0] * q[0][c] + p[r][1] * q[1][c]) + p[r][2] * q[2][c]
                       for c in range(3)) for r in range(3))


def adjugate(m) -> tuple:
    def entry(r, c):
        a, b, x, y = (c + 1) % 3, (c + 2) % 3, (r + 1) % 3, (r + 2) % 3
        return m[a][x] * m[b][y] - m[a][y] * m[b][x]
    return tuple(tuple(entry(r, c) for c in range(3)) for r in range(3))


def determinant(m, a) -> float:
    return (m[0][0] * a[0][0] + m[0][1] * a[1][0]) + m[0][2] * a[2][0]


def corner_weights(a) -> tuple:
    """The four numbers of [R8111]."""
    return a[2][2], a[2][0] + a[2][2], a[2][1] + a[2][2], (a[2][0] + a[2][1]) + a[2][2]
