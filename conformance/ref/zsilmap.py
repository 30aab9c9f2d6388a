# SPDX-License-Identifier: Apache-2.0
"""The cells of a silmap and the value at a point or in a box of one cell: spec/silmap.md sections 1
to 5 and step 4 of section 6. Colours are lists of four numbers; corners of a cell and quadrants are
pairs (right, below)."""

import math
from dataclasses import dataclass

NORTH_BIT, WEST_BIT, UNCUT = 0x80, 0x40, 0x24
TOWARDS = {"N": (0, -1), "E": (1, 0), "S": (0, 1), "W": (-1, 0)}   # the neighbour of an arm
OPPOSITE = {"N": "S", "E": "W", "S": "N", "W": "E"}
CONTINUOUS, SEN2004, NEAREST = 0, 1, 2
CORNERS = ((0, 0), (1, 0), (0, 1), (1, 1))
ARMS = {"N": (None, 0), "S": (None, 1), "W": (0, None), "E": (1, None)}    # the side of the cell


# ---- sections 1 and 3 ----------------------------------------------------------------------------

@dataclass
class Cell:
    cut: frozenset                 # of "N", "S", "W", "E"
    p: tuple                       # its point, and those of the neighbours in its coordinates
    n: tuple
    s: tuple
    w: tuple
    e: tuple


@dataclass
class Grid:
    width: int
    height: int
    layers: int
    cells: bytes
    repeat_u: bool
    repeat_v: bool

    def byte(self, i: int, j: int, layer: int) -> int:
        """The byte of a cell, None where there is none."""
        if self.repeat_u:
            i %= self.width
        if self.repeat_v:
            j %= self.height
        if not (0 <= i < self.width and 0 <= j < self.height):
            return None
        return self.cells[(layer * self.height + j) * self.width + i]

    def neighbour(self, arm: str, i: int, j: int, layer: int) -> int:
        return self.byte(i + TOWARDS[arm][0], j + TOWARDS[arm][1], layer)

    def cut(self, i: int, j: int, layer: int) -> frozenset:
        own = self.byte(i, j, layer)
        bits = {"N": own & NORTH_BIT, "W": own & WEST_BIT,
                "E": (self.neighbour("E", i, j, layer) or 0) & WEST_BIT,
                "S": (self.neighbour("S", i, j, layer) or 0) & NORTH_BIT}
        leave = [arm for arm in TOWARDS if self.neighbour(arm, i, j, layer) is None]
        inner = [arm for arm in TOWARDS if bits[arm] and arm not in leave]
        if len(inner) == 1 and leave:
            runs_on = OPPOSITE[inner[0]]
            inner.append(runs_on if runs_on in leave else leave[0])
        return frozenset(inner)

    def cell(self, i: int, j: int, layer: int) -> Cell:
        def point(value):
            return ((value & 7) + 0.5) / 8, ((value >> 3 & 7) + 0.5) / 8

        own = self.byte(i, j, layer)
        points = {}
        for arm, (di, dj) in TOWARDS.items():
            value = self.neighbour(arm, i, j, layer)
            if value is None:                              # its own point, mirrored in the side
                value = own ^ (0x07 if arm in "WE" else 0x38)
            x, y = point(value)
            points[arm] = x + di, y + dj
        return Cell(self.cut(i, j, layer), point(own), points["N"], points["S"], points["W"],
                    points["E"])

    def has_costly_points(self) -> bool:
        """[R8207]"""
        return set(self.cells) != {UNCUT} and any(
            self.byte(i, j, k) != UNCUT and not self.cut(i, j, k)
            for k in range(self.layers) for j in range(self.height) for i in range(self.width))


# ---- section 4 -----------------------------------------------------------------------------------

def quadrant(cell: Cell, x: float, y: float) -> tuple:
    (px, py), (nx, ny), (sx, sy), (wx, wy), (ex, ey) = cell.p, cell.n, cell.s, cell.w, cell.e
    if x < px:
        below = (y - wy) * (px - wx) >= (x - wx) * (py - wy)
    else:
        below = (y - py) * (ex - px) >= (x - px) * (ey - py)
    if y < py:
        right = (x - nx) * (py - ny) >= (y - ny) * (px - nx)
    else:
        right = (x - px) * (sy - py) >= (y - py) * (sx - px)
    return int(right), int(below)


# ---- section 5 -----------------------------------------------------------------------------------

def mix(pairs) -> list:
    """The sum of weight times colour."""
    pairs = list(pairs)
    return [sum(weight * colour[k] for weight, colour in pairs) for k in range(4)]


def bilinear(c: dict, x: float, y: float) -> list:
    return mix((((1 - x, x)[i] * (1 - y, y)[j]), c[i, j]) for i, j in CORNERS)


def one_cut(arm: str, q: tuple, p: tuple, c: dict, x: float, y: float) -> list:
    px, py = p
    first, second, t, on_second, h = {
        "N": (c[0, 0], c[1, 0], x, q[0], (py - y) / py),
        "S": (c[0, 1], c[1, 1], x, q[0], (y - py) / (1 - py)),
        "W": (c[0, 0], c[0, 1], y, q[1], (px - x) / px),
        "E": (c[1, 0], c[1, 1], y, q[1], (x - px) / (1 - px))}[arm]
    step = max(0.0, h) * (1 - t if on_second else -t)
    return mix(((1, bilinear(c, x, y)), (step, second), (-step, first)))


def corner_between(cut: frozenset) -> tuple:
    """The quadrant whose two arms are the two that are cut."""
    return int("E" in cut), int("S" in cut)


def adjacent_cut(m: tuple, q: tuple, c: dict, x: float, y: float) -> list:
    if q == m:
        return c[m]
    dx, dy = abs(x - m[0]), abs(y - m[1])
    changed = dict(c)
    if dx + dy > 0:
        vertical, horizontal = c[m[0], 1 - m[1]], c[1 - m[0], m[1]]
        changed[m] = mix(((dy / (dx + dy), vertical), (dx / (dx + dy), horizontal)))
    return bilinear(changed, x, y)


def plane(left_out: tuple, c: dict, x: float, y: float) -> list:
    """The plane through the three other corners, kept within their range."""
    k = 1 - left_out[0], 1 - left_out[1]
    along_x, along_y = c[1 - k[0], k[1]], c[k[0], 1 - k[1]]
    ax, ay = abs(x - k[0]), abs(y - k[1])
    value = mix(((1 - ax - ay, c[k]), (ax, along_x), (ay, along_y)))
    three = list(zip(c[k], along_x, along_y))
    return [min(max(v, min(range_)), max(range_)) for v, range_ in zip(value, three)]


def at_arm(arm: str, q: tuple) -> bool:
    """Is the quadrant one of the two at this arm?"""
    return all(want is None or want == have for want, have in zip(ARMS[arm], q))


def along_side(arm: str, c: dict, x: float, y: float) -> list:
    """Linear along the side that the arm crosses."""
    i, j = ARMS[arm]
    if i is None:
        return mix(((1 - x, c[0, j]), (x, c[1, j])))
    return mix(((1 - y, c[i, 0]), (y, c[i, 1])))


def value(kind: int, cell: Cell, q: tuple, c: dict, x: float, y: float) -> list:
    """The filter's formula for the quadrant q at (x, y)."""
    cut = cell.cut
    if kind == NEAREST or len(cut) == 4:
        return c[q]
    if not cut:
        return bilinear(c, x, y)
    if len(cut) == 3:
        arm, = set(ARMS) - cut
        return along_side(arm, c, x, y) if at_arm(arm, q) else c[q]
    if cut == {"N", "S"}:
        return mix(((1 - y, c[q[0], 0]), (y, c[q[0], 1])))
    if cut == {"W", "E"}:
        return mix(((1 - x, c[0, q[1]]), (x, c[1, q[1]])))
    if len(cut) == 2:
        m = corner_between(cut)
        if kind == CONTINUOUS:
            return adjacent_cut(m, q, c, x, y)
        return c[m] if q == m else plane(m, c, x, y)
    arm, = cut
    if kind == CONTINUOUS:
        return one_cut(arm, q, cell.p, c, x, y)
    if not at_arm(arm, q):
        return bilinear(c, x, y)
    other = (1 - q[0], q[1]) if arm in "NS" else (q[0], 1 - q[1])
    return plane(other, c, x, y)


# ---- section 6, step 4 ---------------------------------------------------------------------------

def signed_quotient(start: tuple, end: tuple, x: float, y: float, bx: float, by: float,
                    sign: int) -> float:
    """The distance of (x, y) from the line, divided by the line's reach. With sign 1 it is positive
    to the right of a line that leads down, with sign -1 below a line that leads right."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = math.hypot(dx, dy)
    distance = sign * ((x - start[0]) * dy - (y - start[1]) * dx) / length
    reach = (bx * abs(dy) + by * abs(dx)) / length
    if reach == 0:
        return math.inf if distance >= 0 else -math.inf
    return distance / reach


def share(before: float, behind: float, convex: bool) -> float:
    d = min(before, behind) if convex else max(before, behind)
    return min(max((1 + d) / 2, 0.0), 1.0)


def part_value(kind: int, cell: Cell, c: dict, x: float, y: float, bx: float, by: float) -> list:
    """The value of the part of a box that lies in the cell."""
    if bx == by == 0:
        return value(kind, cell, quadrant(cell, x, y), c, x, y)
    (px, py), (nx, ny), (sx, sy), (wx, wy), (ex, ey) = cell.p, cell.n, cell.s, cell.w, cell.e
    box = (x, y, bx, by)
    r = share(signed_quotient(cell.n, cell.p, *box, 1), signed_quotient(cell.p, cell.s, *box, 1),
              (px - nx) * (sy - py) - (py - ny) * (sx - px) <= 0)
    b = share(signed_quotient(cell.w, cell.p, *box, -1), signed_quotient(cell.p, cell.e, *box, -1),
              (px - wx) * (ey - py) - (py - wy) * (ex - px) >= 0)
    return mix(((1 - r, r)[i] * (1 - b, b)[j], value(kind, cell, (i, j), c, x, y)) for i, j in CORNERS)
