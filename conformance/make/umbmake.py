# SPDX-License-Identifier: Apache-2.0
"""Umbrellas (spec/umbrella.md), written field by field. Overrides (see ztexmake.py) are

    umbr.N.FIELD                    of the header
    umbr.N.PLANE.FIELD              of a plane
    umbr.N.PLANE.values             the list of a plane's elements, without the 2^31 or 128 added

Numbers have the units of the planes: positions in 1/65535 of a picture or 1/65536 of a cell."""

import math
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Optional

from ztexmake import NONE, Overrides, Plane, f32_bits, plane_bytes, uint

FLAT, CONVEX, CONCAVE, OF_BASE = range(4)
ONE = 65536                            # a cell, in the unit of centres
SIGNED = {"x": 31, "y": 31, "a": 31, "b": 31, "explicit_x": 31, "explicit_y": 31, "variant_r": 7,
          "variant_g": 7, "variant_b": 7}


@dataclass
class Base:
    source: int
    centre: tuple
    vertices: list
    kind: int = 0                      # 0 image, 1 texture
    aspect: int = 65536
    morph: Optional[list] = None
    variants: list = field(default_factory=list)       # each 1 + vertices colours
    ellipsoid: int = FLAT
    height: int = 0
    curvature: int = 0


@dataclass
class Umbrella:
    """Of form 0 as it stands; `explicit` and `coloured` make the others."""
    x: int
    y: int
    base: int = 0
    a: int = ONE
    b: int = 0
    mirrored: bool = False
    morph: int = 0
    variants: tuple = (0, 0)
    weight: int = 0
    strength: int = 255
    ellipsoid: int = FLAT
    height: int = 0
    curvature: int = 0
    lift: int = 0
    form: int = 0
    vertices: list = field(default_factory=list)
    colours: list = field(default_factory=list)        # form 1: signed


def explicit(x: int, y: int, base: int, vertices: list, colours: list, **more) -> Umbrella:
    return Umbrella(x, y, base, a=0, form=1, vertices=vertices, colours=colours, **more)


def coloured(x: int, y: int, vertices: list, colours: list, **more) -> Umbrella:
    return Umbrella(x, y, a=0, form=2, strength=0, vertices=vertices, colours=colours, **more)


# ---- lists ---------------------------------------------------------------------------------------

def grown_meets(points: list, box: tuple) -> bool:
    """Does the convex polygon meet the box? Both have their axes tested, exactly."""
    x0, y0, x1, y1 = box
    if (max(p[0] for p in points) < x0 or min(p[0] for p in points) > x1
            or max(p[1] for p in points) < y0 or min(p[1] for p in points) > y1):
        return False
    corners = ((x0, y0), (x1, y0), (x0, y1), (x1, y1))
    for (ax, ay), (bx, by) in zip(points, points[1:] + points[:1]):
        nx, ny = by - ay, ax - bx
        inside = max((p[0] - ax) * nx + (p[1] - ay) * ny for p in points)
        outside = min((p[0] - ax) * nx + (p[1] - ay) * ny for p in points)
        along = [(x - ax) * nx + (y - ay) * ny for x, y in corners]
        if min(along) > inside or max(along) < outside:
            return False
    return True


@dataclass
class Umbrellas:
    grid: tuple
    levels: list                       # of each level its umbrellas
    bases: list = field(default_factory=list)
    wrap: tuple = (2, 2, 2)
    level_bits: Optional[list] = None  # default: 10
    lists: Optional[list] = None       # of each level, of each cell pairs (entry, (sx, sy))
    colour_mode: int = 0
    background_kind: int = 0
    background_source: int = NONE
    background: tuple = (0.25, 0.125, 0.0625, 1.0)
    mean: tuple = (0.25, 0.25, 0.125, 1.0)
    prism_height: float = 1.0
    taper: tuple = (0.03125, 0.125)
    planes: dict = field(default_factory=dict)         # name -> Plane; "" is the default

    def __post_init__(self):
        if self.level_bits is None:
            self.level_bits = [10] * len(self.levels)
        if self.lists is None:
            self.lists = [self.lists_of(k) for k in range(len(self.levels))]

    def size(self, level: int) -> tuple:
        return tuple(max(1, n >> level) for n in self.grid)

    def contour(self, u: Umbrella, level: int) -> list:
        """The vertices less the centre, in cells."""
        if u.form:
            scale = Fraction(1, 1 << self.level_bits[level])
            return [(x * scale, y * scale) for x, y in u.vertices]
        base = self.bases[u.base]
        aspect, m, out = Fraction(base.aspect, 65536), Fraction(u.morph, 255), []
        for d, e in zip(base.vertices, base.morph or base.vertices):
            qx, qy = (Fraction(p + m * (q - p) - c, 65535)
                      for p, q, c in zip(d, e, base.centre))
            qx, qy = (-qx if u.mirrored else qx), qy * aspect
            out.append(((u.a * qx - u.b * qy) / ONE, (u.b * qx + u.a * qy) / ONE))
        return out

    def lists_of(self, level: int) -> list:
        """The list of each cell that an umbrella meets when it is grown by 1/8 of a cell, or, with an
        ellipsoid, its circle."""
        w, h = self.size(level)
        out = [[] for _ in range(w * h)]
        shifts = [(sx, sy) for sy in (-1, 0, 1) for sx in (-1, 0, 1)
                  if (sx == 0 or self.wrap[0] == 0) and (sy == 0 or self.wrap[1] == 0)]
        for number, u in enumerate(self.levels[level]):
            d = [tuple(map(float, p)) for p in self.contour(u, level)]
            round_ = u.ellipsoid in (CONVEX, CONCAVE) or (
                u.ellipsoid == OF_BASE and self.bases[u.base].ellipsoid != FLAT)
            radius = math.sqrt(max(x * x + y * y for x, y in d)) if round_ else 0.0
            for sx, sy in shifts:
                centre = u.x / ONE + sx * w, u.y / ONE + sy * h
                for j, i in self.cells_near(d, radius, centre, (w, h)):
                    box = (i - 0.125 - centre[0], j - 0.125 - centre[1],
                           i + 1.125 - centre[0], j + 1.125 - centre[1])
                    if self.meets(d, radius, box):
                        out[j * w + i].append((number, (sx, sy)))
        return out

    @staticmethod
    def cells_near(d: list, radius: float, centre: tuple, size: tuple) -> list:
        spans = []
        for axis in range(2):
            low = min([p[axis] for p in d] + [-radius]) + centre[axis] - 0.25
            high = max([p[axis] for p in d] + [radius]) + centre[axis] + 0.25
            spans.append(range(max(0, math.floor(low)), min(size[axis], math.floor(high) + 1)))
        return [(j, i) for j in spans[1] for i in spans[0]]

    @staticmethod
    def meets(d: list, radius: float, box: tuple) -> bool:
        if radius:
            x = min(max(0.0, box[0]), box[2])
            y = min(max(0.0, box[1]), box[3])
            return x * x + y * y <= radius * radius
        return any(grown_meets([(0.0, 0.0), a, b], box) for a, b in zip(d, d[1:] + d[:1]))

    # ---- bytes -----------------------------------------------------------------------------------

    def arrays(self) -> list:
        """(name, element size, values) of each plane in file order."""
        bases, us = self.bases, [u for level in self.levels for u in level]
        first = [v for b in bases for v in b.vertices]
        second = [v for b in bases if b.morph is not None for v in b.morph]
        variant = [c for b in bases for v in b.variants for c in v]
        d = [v for u in us for v in u.vertices]
        colours = [tuple(q + 128 if u.form == 1 else q for q in c) for u in us for c in u.colours]
        entries = [e for level in self.lists for cell in level for e in cell]
        return [
            ("level_umbrellas", 4, [len(level) for level in self.levels]),
            ("level_bits", 1, self.level_bits),
            ("base_kind", 1, [b.kind for b in bases]), ("base_source", 4, [b.source for b in bases]),
            ("base_aspect", 4, [b.aspect for b in bases]),
            ("base_vertices", 2, [len(b.vertices) for b in bases]),
            ("base_morph", 1, [int(b.morph is not None) for b in bases]),
            ("base_variants", 1, [len(b.variants) for b in bases]),
            ("base_x", 2, [b.centre[0] for b in bases]), ("base_y", 2, [b.centre[1] for b in bases]),
            ("base_ellipsoid", 1, [b.ellipsoid for b in bases]),
            ("base_height", 2, [b.height for b in bases]),
            ("base_curvature", 2, [b.curvature for b in bases]),
            ("vertex_x", 2, [v[0] for v in first]), ("vertex_y", 2, [v[1] for v in first]),
            ("morph_x", 2, [v[0] for v in second]), ("morph_y", 2, [v[1] for v in second]),
            ("variant_r", 1, [c[0] for c in variant]), ("variant_g", 1, [c[1] for c in variant]),
            ("variant_b", 1, [c[2] for c in variant]),
            ("form", 1, [u.form | u.mirrored << 2 for u in us]), ("base", 2, [u.base for u in us]),
            ("x", 4, [u.x for u in us]), ("y", 4, [u.y for u in us]),
            ("a", 4, [u.a for u in us]), ("b", 4, [u.b for u in us]),
            ("morph", 1, [u.morph for u in us]), ("variant_0", 1, [u.variants[0] for u in us]),
            ("variant_1", 1, [u.variants[1] for u in us]),
            ("variant_weight", 1, [u.weight for u in us]), ("strength", 1, [u.strength for u in us]),
            ("ellipsoid", 1, [u.ellipsoid for u in us]), ("height", 2, [u.height for u in us]),
            ("curvature", 2, [u.curvature for u in us]), ("lift", 2, [u.lift for u in us]),
            ("vertices", 2, [len(u.vertices) for u in us]),
            ("explicit_x", 4, [v[0] for v in d]), ("explicit_y", 4, [v[1] for v in d]),
            ("explicit_r", 1, [c[0] for c in colours]), ("explicit_g", 1, [c[1] for c in colours]),
            ("explicit_b", 1, [c[2] for c in colours]),
            ("list_size", 4, [len(cell) for level in self.lists for cell in level]),
            ("entry", 4, [n for n, _ in entries]),
            ("shift", 1, [sx + 1 + 3 * (sy + 1) for _, (sx, sy) in entries])]

    @staticmethod
    def stored(name: str, values: list) -> list:
        return [v + (1 << SIGNED[name]) for v in values] if name in SIGNED else list(values)

    def elements(self) -> bytes:
        return b"".join(uint(v, size) for name, size, values in self.arrays()
                        for v in self.stored(name, values))

    def counts(self) -> list:
        bases, us = self.bases, [u for level in self.levels for u in level]
        sizes = [len(cell) for level in self.lists for cell in level]
        return [("base_count", len(bases)), ("umbrella_count", len(us)),
                ("base_vertex_count", sum(len(b.vertices) for b in bases)),
                ("morph_vertex_count", sum(len(b.morph) for b in bases if b.morph is not None)),
                ("variant_colour_count", sum(len(v) for b in bases for v in b.variants)),
                ("explicit_vertex_count", sum(len(u.vertices) for u in us)),
                ("entry_count", sum(sizes)), ("longest_list", max(sizes))]

    def build(self, over: Overrides, number: int) -> bytes:
        path = "umbr.%d" % number
        floats = [("%s_%s" % (name, c), v) for name, four in (("background", self.background),
                                                              ("mean", self.mean))
                  for c, v in zip(("red", "green", "blue", "alpha"), four)]
        floats += [("prism_height", self.prism_height), ("taper_start", self.taper[0]),
                   ("taper_end", self.taper[1])]
        # An f32 given as an int is a bit pattern.
        bits = [(name, 4, v if isinstance(v, int) else f32_bits(v)) for name, v in floats]
        out = over.pack(path, [
            ("grid_x", 4, self.grid[0]), ("grid_y", 4, self.grid[1]),
            ("level_count", 4, len(self.levels))]
            + [(name, 4, n) for name, n in self.counts()]
            + [("colour_mode", 1, self.colour_mode), ("background_kind", 1, self.background_kind),
               ("reserved46", 2, 0), ("background_source", 4, self.background_source)]
            + bits + [("layer_count", 4, 1), ("reserved100", 4, 0)])
        default = self.planes.get("", Plane())
        for name, size, values in self.arrays():
            values = over.get("%s.%s.values" % (path, name), values)
            out += plane_bytes(over, "%s.%s" % (path, name), size, self.stored(name, values),
                               self.planes.get(name, default))
        return out


def at(index: int, value):
    """An override for one element of a plane."""
    def edit(values: list) -> list:
        out = list(values)
        out[index] = value(out[index]) if callable(value) else value
        return out
    return edit
