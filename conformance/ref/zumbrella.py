# SPDX-License-Identifier: Apache-2.0
"""Umbrellas (spec/umbrella.md): the chunk and its rules (section 2), an umbrella at a point (3),
lookups in 2-D (4) and of rays (5 and 6), in binary64, step by step in the order of the text.

Points and vectors are pairs (x, y) or triples, colours lists of four numbers. Pictures are looked up
by a function look(kind, source, u, v, du, dv, wrap) that the caller hands in."""

import math
import struct
from dataclasses import dataclass, replace

from zbase import Cursor, need, read_plane

REPEAT, MIRROR, CLAMP, BORDER = range(4)                  # wrap modes
PARAMETRIC, EXPLICIT, COLOURED = range(3)
FLAT, CONVEX, CONCAVE, OF_BASE = range(4)
BARYCENTRIC, INVERSE_DISTANCE = range(2)
COLOUR, IMAGE, TEXTURE = range(3)                          # kinds of background
CLEAR = [0.0, 0.0, 0.0, 0.0]
NONE = 0xFFFFFFFF
FAR = 1 << 30
DONE = 2.0 ** -16


# ---- what a chunk holds --------------------------------------------------------------------------

@dataclass
class Base:
    kind: int                      # 0 image, 1 texture
    source: int
    aspect: float                  # height of the picture in its width
    centre: tuple                  # in 1/65535 of the picture
    vertices: list                 # less the centre
    morph: list                    # the second positions, less the centre; None without
    variants: list                 # each a list of colours, the centre's first
    ellipsoid: int
    height: int
    curvature: int


@dataclass
class Umbrella:
    form: int
    mirrored: bool
    base: Base                     # None for COLOURED
    centre: tuple                  # in cells
    a: float
    b: float
    morph: float
    variants: tuple
    weight: float
    strength: float
    ellipsoid: int
    height: float                  # in cells of level 0, that of the base where it is OF_BASE
    curvature: float
    lift: float
    vertices: list                 # explicit, in cells, less the centre
    colours: list                  # explicit, the centre's first


@dataclass
class Level:
    width: int
    height: int
    umbrellas: list
    lists: list                    # of each cell pairs (entry, (sx, sy))


@dataclass
class Umbrellas:
    levels: list
    bases: list
    colour_mode: int
    background_kind: int
    background_source: int
    background: list
    mean: list
    h: float                       # prism_height
    taper: tuple
    elements: bytes = b""


# ---- section 2: the chunk ------------------------------------------------------------------------

HEADER = (("grid_x", "I"), ("grid_y", "I"), ("level_count", "I"), ("base_count", "I"),
          ("umbrella_count", "I"), ("base_vertex_count", "I"), ("morph_vertex_count", "I"),
          ("variant_colour_count", "I"), ("explicit_vertex_count", "I"), ("entry_count", "I"),
          ("longest_list", "I"), ("colour_mode", "B"), ("background_kind", "B"), ("reserved46", "H"),
          ("background_source", "I"), ("background", "4I"), ("mean", "4I"), ("prism_height", "I"),
          ("taper_start", "I"), ("taper_end", "I"), ("layer_count", "I"), ("reserved100", "I"))
# Name, element size, what counts the elements, and what is subtracted from an element.
PLANES = (
    ("level_umbrellas", 4, "levels", 0), ("level_bits", 1, "levels", 0),
    ("base_kind", 1, "bases", 0), ("base_source", 4, "bases", 0), ("base_aspect", 4, "bases", 0),
    ("base_vertices", 2, "bases", 0), ("base_morph", 1, "bases", 0), ("base_variants", 1, "bases", 0),
    ("base_x", 2, "bases", 0), ("base_y", 2, "bases", 0), ("base_ellipsoid", 1, "bases", 0),
    ("base_height", 2, "bases", 0), ("base_curvature", 2, "bases", 0),
    ("vertex_x", 2, "base vertices", 0), ("vertex_y", 2, "base vertices", 0),
    ("morph_x", 2, "morph vertices", 0), ("morph_y", 2, "morph vertices", 0),
    ("variant_r", 1, "variant colours", 128), ("variant_g", 1, "variant colours", 128),
    ("variant_b", 1, "variant colours", 128),
    ("form", 1, "umbrellas", 0), ("base", 2, "umbrellas", 0),
    ("x", 4, "umbrellas", 1 << 31), ("y", 4, "umbrellas", 1 << 31),
    ("a", 4, "umbrellas", 1 << 31), ("b", 4, "umbrellas", 1 << 31),
    ("morph", 1, "umbrellas", 0), ("variant_0", 1, "umbrellas", 0), ("variant_1", 1, "umbrellas", 0),
    ("variant_weight", 1, "umbrellas", 0), ("strength", 1, "umbrellas", 0),
    ("ellipsoid", 1, "umbrellas", 0), ("height", 2, "umbrellas", 0),
    ("curvature", 2, "umbrellas", 0), ("lift", 2, "umbrellas", 0), ("vertices", 2, "umbrellas", 0),
    ("explicit_x", 4, "explicit vertices", 1 << 31), ("explicit_y", 4, "explicit vertices", 1 << 31),
    ("explicit_r", 1, "explicit colours", 0), ("explicit_g", 1, "explicit colours", 0),
    ("explicit_b", 1, "explicit colours", 0),
    ("list_size", 4, "cells", 0), ("entry", 4, "entries", 0), ("shift", 1, "entries", 0))


def read_header(c: Cursor, layer_count: int) -> dict:
    """The header after [R8301] to [R8303]; numbers of type f32 are binary64 then."""
    values = c.fields("".join(code for _, code in HEADER))
    head, at = {}, 0
    for name, code in HEADER:
        n = 4 if code == "4I" else 1
        head[name] = values[at:at + n] if n > 1 else values[at]
        at += n
    w, h = head["grid_x"], head["grid_y"]
    need(head["reserved46"] == head["reserved100"] == 0, "R8301", "reserved")
    need(head["layer_count"] == 1 == layer_count, "R8301", "layer_count")
    need(1 <= w <= 8192 and 1 <= h <= 8192, "R8301", "grid")
    need(1 <= head["level_count"] <= max(w, h).bit_length(), "R8301", "level_count")
    need(head["base_count"] <= 65536 and head["umbrella_count"] <= 1 << 24, "R8301", "counts")
    head["sizes"] = [(max(1, w >> k), max(1, h >> k)) for k in range(head["level_count"])]
    need(sum(a * b for a, b in head["sizes"]) < 1 << 27, "R8301", "cells")
    need(head["colour_mode"] <= 1 and head["background_kind"] <= 2, "R8302")
    for name in ("background", "mean", "prism_height", "taper_start", "taper_end"):
        bits = head[name] if isinstance(head[name], tuple) else (head[name],)
        need(all(b < 0x7F800000 for b in bits), "R8303", name)     # finite, no sign
        floats = struct.unpack("<%df" % len(bits), struct.pack("<%dI" % len(bits), *bits))
        head[name] = list(floats) if len(bits) > 1 else floats[0]
    need(head["taper_start"] < head["taper_end"] <= 0.125, "R8303", "taper")
    return head


def read_planes(c: Cursor, head: dict) -> tuple:
    """Dict of the planes' values and the decoded bytes of all."""
    counts = {"levels": head["level_count"], "bases": head["base_count"],
              "umbrellas": head["umbrella_count"], "base vertices": head["base_vertex_count"],
              "morph vertices": head["morph_vertex_count"],
              "variant colours": head["variant_colour_count"],
              "explicit vertices": head["explicit_vertex_count"],
              "cells": sum(a * b for a, b in head["sizes"]), "entries": head["entry_count"]}
    planes, elements = {}, []
    for name, size, count, less in PLANES:
        values = read_plane(c, size, counts[count])
        elements.append(b"".join(v.to_bytes(size, "little") for v in values))
        planes[name] = [v - less for v in values] if less else values
        if name == "form":
            need(all(v in (0, 1, 2, 4) for v in values), "R8309", "form")
            counts["explicit colours"] = counts["explicit vertices"] + sum(v in (1, 2) for v in values)
    need(c.left() == 0, "R5106")
    return planes, b"".join(elements)


def check_sums(head: dict, p: dict):
    """[R8304]"""
    bases = list(zip(p["base_vertices"], p["base_morph"], p["base_variants"]))
    # [R8311] says that form 0 has none, and so does the sum.
    sums = (("umbrella_count", sum(p["level_umbrellas"])),
            ("base_vertex_count", sum(v for v, _, _ in bases)),
            ("morph_vertex_count", sum(v for v, m, _ in bases if m)),
            ("variant_colour_count", sum(n * (1 + v) for v, _, n in bases)),
            ("explicit_vertex_count", sum(v for v, f in zip(p["vertices"], p["form"])
                                          if f in (EXPLICIT, COLOURED))),
            ("entry_count", sum(p["list_size"])), ("longest_list", max(p["list_size"])))
    for name, wanted in sums:
        need(head[name] == wanted, "R8304", name)
    need(all(b <= 16 for b in p["level_bits"]), "R8304", "level_bits")


def cross(a: tuple, b: tuple):
    return a[0] * b[1] - a[1] * b[0]


def successive(points: list) -> list:
    """Each point and the next, that of the last being the first."""
    return list(zip(points, points[1:] + points[:1]))


def is_star(points: list) -> bool:
    """[R8307] for vertices less centre."""
    pairs = successive(points)
    return (all(cross(d, e) > 0 for d, e in pairs)
            and sum(d[1] < 0 <= e[1] for d, e in pairs) == 1)


def colour_offset(q: int) -> float:
    q = max(q, -127)
    return q * abs(q) / 127 ** 2


def read_bases(p: dict, own: int, images: list) -> list:
    """[R8305] to [R8308]"""
    out, vertex, second, colour = [], 0, 0, 0
    for k, kind in enumerate(p["base_kind"]):
        name = "base %d" % k
        check_source(kind, p["base_source"][k], own, images, name)
        n, ellipsoid = p["base_vertices"][k], p["base_ellipsoid"][k]
        need(1 <= p["base_aspect"][k] <= 1 << 24 and 3 <= n <= 4096 and p["base_morph"][k] <= 1
             and ellipsoid <= 2, "R8306", name)
        need(ellipsoid or p["base_height"][k] == p["base_curvature"][k] == 0, "R8306", name)
        x, y = p["base_x"][k], p["base_y"][k]
        d = [(p["vertex_x"][i] - x, p["vertex_y"][i] - y) for i in range(vertex, vertex + n)]
        vertex += n
        need(is_star(d), "R8307", name)
        e = None
        if p["base_morph"][k]:
            e = [(p["morph_x"][i] - x, p["morph_y"][i] - y) for i in range(second, second + n)]
            second += n
            need(is_star(e), "R8308", name)
            need(all(cross(d0, e1) + cross(e0, d1) >= 0
                     for (d0, d1), (e0, e1) in zip(successive(d), successive(e))), "R8308", name)
        variants = []
        for _ in range(p["base_variants"][k]):
            variants.append([[colour_offset(p["variant_" + c][i]) for c in "rgb"]
                             for i in range(colour, colour + 1 + n)])
            colour += 1 + n
        out.append(Base(kind, p["base_source"][k], p["base_aspect"][k] / 65536, (x, y), d, e,
                        variants, ellipsoid, p["base_height"][k], p["base_curvature"][k]))
    return out


def check_source(kind: int, source: int, own: int, images: list, name: str):
    """[R8305] for a base or the background."""
    need(kind <= 1, "R8305", name)
    need(source < (own if kind else len(images)), "R8305", name)
    if kind == 0:
        image = images[source]
        need(image.depth == 1 and image.layers == 1 and image.layer_kind != 1, "R8305", name)


def check_umbrella(p: dict, k: int, level: int, size: tuple, wrap: tuple, bases: list):
    """[R8309] to [R8311], [R8313] and [R8314] for umbrella k."""
    one = {name: p[name][k] for name, _, count, _ in PLANES if count == "umbrellas"}
    form, name = one["form"] & 3, "umbrella %d" % k
    need(level == 0 or form == COLOURED, "R8309", name)
    base = None
    if form != COLOURED:
        need(one["base"] < len(bases), "R8310", name)
        base = bases[one["base"]]
        need(all(one[v] == 0 or one[v] < len(base.variants) for v in ("variant_0", "variant_1")),
             "R8310", name)
    if form == PARAMETRIC:
        need((one["a"], one["b"]) != (0, 0), "R8310", name)
        need(one["morph"] == 0 or base.morph, "R8310", name)
    else:
        unused = ["a", "b", "morph", "variant_0", "variant_1", "variant_weight"]
        unused += ["base", "strength"] if form == COLOURED else []
        need(not any(one[v] for v in unused), "R8310", name)
    need(one["vertices"] == len(base.vertices) if form == EXPLICIT else
         3 <= one["vertices"] <= 4096 if form == COLOURED else one["vertices"] == 0, "R8311", name)
    for axis, v in enumerate("xy"):
        if wrap[axis] == REPEAT:
            need(0 <= one[v] < 65536 * size[axis], "R8313", name)
        else:
            need(-FAR <= one[v] <= FAR, "R8313", name)
    need(-FAR <= one["a"] <= FAR and -FAR <= one["b"] <= FAR, "R8313", name)
    kind = one["ellipsoid"]
    need(kind <= (CONCAVE if form == COLOURED else OF_BASE), "R8314", name)
    need(kind in (CONVEX, CONCAVE) or one["height"] == one["curvature"] == 0, "R8314", name)
    height = base.height if kind == OF_BASE else one["height"]
    need(one["lift"] + height <= 65535, "R8314", name)
    return one, base


def make_umbrella(one: dict, base: Base, d: list, colours: list, bits: int, h: float) -> Umbrella:
    kind, height, curvature = one["ellipsoid"], one["height"], one["curvature"]
    if kind == OF_BASE:
        kind, height, curvature = base.ellipsoid, base.height, base.curvature
    form = one["form"] & 3
    return Umbrella(form, bool(one["form"] & 4), base, (one["x"] / 65536, one["y"] / 65536),
                    one["a"] / 65536, one["b"] / 65536, one["morph"] / 255,
                    (one["variant_0"], one["variant_1"]), one["variant_weight"] / 255,
                    1.0 if form == COLOURED else one["strength"] / 255, kind, height / 65535 * h,
                    (curvature + 1) / 65536, one["lift"] / 65535 * h,
                    [(x / (1 << bits), y / (1 << bits)) for x, y in d], colours)


def read_levels(head: dict, p: dict, bases: list, wrap: tuple) -> list:
    """[R8309] to [R8314]"""
    out, k, vertex, colour = [], 0, 0, 0
    for level, size in enumerate(head["sizes"]):
        umbrellas = []
        for _ in range(p["level_umbrellas"][level]):
            one, base = check_umbrella(p, k, level, size, wrap, bases)
            d, colours, n = [], [], one["vertices"]
            if one["form"] & 3 != PARAMETRIC:
                d = list(zip(p["explicit_x"][vertex:vertex + n], p["explicit_y"][vertex:vertex + n]))
                vertex += n
                need(all(-FAR <= v <= FAR for q in d for v in q) and is_star(d), "R8312",
                     "umbrella %d" % k)
                value = ((lambda q: colour_offset(q - 128)) if one["form"] == EXPLICIT
                         else lambda q: (q / 255) ** 2)
                colours = [[value(p["explicit_" + c][i]) for c in "rgb"]
                           for i in range(colour, colour + 1 + n)]
                colour += 1 + n
            umbrellas.append(make_umbrella(one, base, d, colours, p["level_bits"][level],
                                           head["prism_height"]))
            k += 1
        out.append(Level(*size, umbrellas, []))
    return out


def read_lists(levels: list, p: dict, wrap: tuple):
    """[R8315]"""
    at, cell = 0, 0
    for number, level in enumerate(levels):
        for _ in range(level.width * level.height):
            n = p["list_size"][cell]
            pairs = list(zip(p["entry"][at:at + n], p["shift"][at:at + n]))
            name = "cell %d, level %d" % (cell, number)
            need(all(a < b for a, b in zip(pairs, pairs[1:])), "R8315", name)
            entries = []
            for entry, shift in pairs:
                need(entry < len(level.umbrellas) and shift <= 8, "R8315", name)
                sx, sy = shift % 3 - 1, shift // 3 - 1
                need((sx == 0 or wrap[0] == REPEAT) and (sy == 0 or wrap[1] == REPEAT), "R8315", name)
                entries.append((entry, (sx, sy)))
            level.lists.append(entries)
            at += n
            cell += 1


def read(data: bytes, layer_count: int, wrap: tuple, own: int, images: list) -> Umbrellas:
    """The chunk of texture `own`."""
    need(len(data) >= 104, "R8301")
    c = Cursor(data, "R5103")
    head = read_header(c, layer_count)
    p, elements = read_planes(c, head)
    check_sums(head, p)
    bases = read_bases(p, own, images)
    kind, source = head["background_kind"], head["background_source"]
    if kind == COLOUR:
        need(source == NONE, "R8305", "background")
    else:
        check_source(kind - 1, source, own, images, "background")
    levels = read_levels(head, p, bases, wrap)
    read_lists(levels, p, wrap)
    return Umbrellas(levels, bases, head["colour_mode"], kind, source, head["background"],
                     head["mean"], head["prism_height"], (head["taper_start"], head["taper_end"]),
                     elements)


# ---- section 3: an umbrella at a point -----------------------------------------------------------

def own_space(u: Umbrella, q: tuple) -> tuple:
    """Q, or a derivative, in the space where the vertices are."""
    if u.form != PARAMETRIC:
        return q
    n = u.a * u.a + u.b * u.b
    x, y = (u.a * q[0] + u.b * q[1]) / n, (u.a * q[1] - u.b * q[0]) / n
    return (-x if u.mirrored else x), y


def contour(u: Umbrella) -> list:
    """The vertices less the centre, in that space."""
    if u.form != PARAMETRIC:
        return u.vertices
    second = u.base.morph or u.base.vertices
    return [((d[0] + u.morph * (e[0] - d[0])) / 65535,
             (d[1] + u.morph * (e[1] - d[1])) / 65535 * u.base.aspect)
            for d, e in zip(u.base.vertices, second)]


def sector(d: list, q: tuple) -> int:
    """Step 1."""
    if q == (0.0, 0.0):
        return 0
    found = [i for i, (di, dj) in enumerate(successive(d)) if cross(di, q) >= 0 > cross(dj, q)]
    assert len(found) == 1, (d, q, found)
    return found[0]


def coverage_in(d: list, i: int, q: tuple, dx: tuple, dy: tuple) -> float:
    """Step 2 in the sector i."""
    di, dj = d[i], d[(i + 1) % len(d)]
    along = dj[0] - di[0], dj[1] - di[1]
    length = math.hypot(*along)
    normal = -along[1] / length, along[0] / length         # towards the centre
    distance = normal[0] * (q[0] - di[0]) + normal[1] * (q[1] - di[1])
    reach = sum(abs(normal[0] * v[0] + normal[1] * v[1]) for v in (dx, dy)) / 2
    if reach == 0:
        return 1.0 if distance >= 0 else 0.0
    if distance < 0:
        distance = min(distance, max(math.hypot(*di), math.hypot(*dj)) - math.hypot(*q))
    return min(max((1 + distance / reach) / 2, 0.0), 1.0)


def coverage(u: Umbrella, q: tuple, dx: tuple, dy: tuple) -> float:
    """Steps 1 and 2 for Q and derivatives in cells."""
    d, q = contour(u), own_space(u, q)
    return coverage_in(d, sector(d, q), q, own_space(u, dx), own_space(u, dy))


def colours_of(u: Umbrella) -> list:
    """The colours or offsets of the centre and the vertices, None if they are 0."""
    if u.form != PARAMETRIC:
        return u.colours
    if not u.base.variants:
        return None
    first, second = (u.base.variants[v] for v in u.variants)
    w = u.weight
    return [[(1 - w) * a + w * b for a, b in zip(*both)] for both in zip(first, second)]


def mean_colour(mode: int, colours: list, d: list, i: int, g: float, k: float, q: tuple) -> list:
    """The colour O of step 5."""
    if colours is None:
        return [0.0, 0.0, 0.0]
    if mode == BARYCENTRIC:
        j = (i + 1) % len(d)
        three = ((1 - g - k, colours[0]), (g, colours[1 + i]), (k, colours[1 + j]))
        return [sum(w * c[n] for w, c in three) for n in range(3)]
    distances = [math.hypot(q[0] - v[0], q[1] - v[1]) for v in [(0.0, 0.0)] + d]
    if 0.0 in distances:
        return colours[distances.index(0.0)]
    weights = [1 / v for v in distances]
    return [sum(w * c[n] for w, c in zip(weights, colours)) / sum(weights) for n in range(3)]


def picture(u: Umbrella, i: int, g: float, k: float, d: list, dx: tuple, dy: tuple, look) -> list:
    """Step 4: C and A."""
    if u.form == COLOURED:
        return [0.0, 0.0, 0.0, 1.0]
    base, j = u.base, (i + 1) % len(d)
    vi, vj, area = base.vertices[i], base.vertices[j], cross(d[i], d[j])

    def mapped(g, k):
        return tuple((g * vi[n] + k * vj[n]) / 65535 for n in range(2))

    place = mapped(g, k)
    steps = [mapped(cross(v, d[j]) / area, cross(d[i], v) / area) for v in (dx, dy)]
    centre = base.centre[0] / 65535, base.centre[1] / 65535
    return look(base.kind, base.source, centre[0] + place[0], centre[1] + place[1],
                (steps[0][0], steps[1][0]), (steps[0][1], steps[1][1]), (CLAMP, CLAMP))


def at_point(t: Umbrellas, u: Umbrella, q: tuple, dx: tuple, dy: tuple, hard: bool, look) -> tuple:
    """Coverage, colour and A of section 3 for Q and derivatives in cells. `hard`: no derivatives in
    step 2."""
    d, q, dx, dy = contour(u), own_space(u, q), own_space(u, dx), own_space(u, dy)
    i = sector(d, q)
    di, dj = d[i], d[(i + 1) % len(d)]
    still = (0.0, 0.0)
    cover = coverage_in(d, i, q, still, still) if hard else coverage_in(d, i, q, dx, dy)
    if cover == 0:
        return 0.0, [0.0, 0.0, 0.0], 0.0
    g, k = cross(q, dj) / cross(di, dj), cross(di, q) / cross(di, dj)
    *c, alpha = picture(u, i, g, k, d, dx, dy, look)
    o = mean_colour(t.colour_mode, colours_of(u), d, i, g, k, q)
    return cover, [min(max(c[n] + alpha * u.strength * o[n], 0.0), alpha) for n in range(3)], alpha


# ---- section 4: lookup in 2-D --------------------------------------------------------------------

@dataclass
class Light:
    x: float                       # displacement towards it, in cells of level 0
    y: float
    darkness: float


@dataclass
class Query:
    s: float
    t: float
    ds: tuple                      # for one step in x and in y
    dt: tuple
    wrap: tuple
    filter: str = "trilinear"
    light: Light = None


def into_unit(x: float, mode: int):
    """spec/zipmap.md section 3; None for outside of a border."""
    if mode == REPEAT:
        return x - math.floor(x)
    if mode == MIRROR:
        m = x - 2 * math.floor(x / 2)
        return 2 - m if m > 1 else m
    if mode == CLAMP:
        return min(max(x, 0.0), 1.0)
    return x if 0 <= x <= 1 else None


def cell_list(level: Level, p: tuple) -> list:
    i, j = min(math.floor(p[0]), level.width - 1), min(math.floor(p[1]), level.height - 1)
    return level.lists[j * level.width + i]


def relative(level: Level, u: Umbrella, shift: tuple, p: tuple) -> tuple:
    """Q"""
    return (p[0] - u.centre[0] - shift[0] * level.width, p[1] - u.centre[1] - shift[1] * level.height)


def background(t: Umbrellas, q: Query, look) -> list:
    """Step 4 for wrapped (s, t)."""
    if t.background_kind == COLOUR:
        return t.background
    kind = t.background_kind - 1
    return look(kind, t.background_source, q.s, q.t, q.ds, q.dt, (CLAMP, CLAMP) if kind else q.wrap)


class Shadows:
    """Step 5: what the casters over a point of a level leave of the light."""

    def __init__(self, t: Umbrellas, level: Level, q: Query, p: tuple, dx: tuple, dy: tuple):
        self.casters, light = [], q.light
        if light is None or light.darkness == 0:
            return
        first = t.levels[0]
        moved = p[0] + light.x * level.width / first.width, p[1] + light.y * level.height / first.height
        s = into_unit(moved[0] / level.width, q.wrap[0])
        v = into_unit(moved[1] / level.height, q.wrap[1])
        if s is None or v is None:
            return
        there = s * level.width, v * level.height
        for entry, shift in cell_list(level, there):
            u = level.umbrellas[entry]
            c = coverage(u, relative(level, u, shift, there), dx, dy)
            self.casters.append((entry, 1 - light.darkness * c))

    def above(self, entry: int) -> float:
        return math.prod(share for caster, share in self.casters if caster > entry)


def in_level(t: Umbrellas, number: int, q: Query, look) -> list:
    """Step 3."""
    level = t.levels[number]
    p = q.s * level.width, q.t * level.height
    dx = q.ds[0] * level.width, q.dt[0] * level.height
    dy = q.ds[1] * level.width, q.dt[1] * level.height
    hard = q.filter != "trilinear"
    flat = ((0.0, 0.0), (0.0, 0.0)) if hard else (dx, dy)
    shadows = Shadows(t, level, q, p, *flat)
    left, total = 1.0, list(CLEAR)

    def add(colour, alpha, light):
        for n in range(3):
            total[n] += left * light * colour[n]
        total[3] += left * alpha

    for entry, shift in reversed(cell_list(level, p)):
        u = level.umbrellas[entry]
        cover, colour, alpha = at_point(t, u, relative(level, u, shift, p), dx, dy, hard, look)
        if cover * alpha == 0:
            continue
        add([cover * v for v in colour], cover * alpha, shadows.above(entry))
        left *= 1 - cover * alpha
        if left < DONE:
            return total
    below = background(t, q, look)
    add(below, below[3], shadows.above(-1))
    return total


def mixed(pairs: list) -> list:
    return [sum(weight * colour[n] for weight, colour in pairs) for n in range(4)]


def level_at(t: Umbrellas, number: int, q: Query, look) -> list:
    return t.mean if number == len(t.levels) else in_level(t, number, q, look)


def look_up(t: Umbrellas, q: Query, look) -> list:
    s, v = into_unit(q.s, q.wrap[0]), into_unit(q.t, q.wrap[1])
    if s is None or v is None:
        return list(CLEAR)
    q = replace(q, s=s, t=v)
    first = t.levels[0]
    rho = max(math.hypot(q.ds[k] * first.width, q.dt[k] * first.height) for k in range(2))
    fine = math.log2(8 * rho) if rho > 0 else 0.0
    fine = min(max(fine, 0.0), float(len(t.levels)))
    if q.filter != "trilinear":
        return level_at(t, math.floor(fine + 0.5), q, look)
    k = math.floor(fine)
    f = fine - k
    pairs = [(1 - f, level_at(t, k, q, look))]
    if f > 0:
        pairs.append((f, level_at(t, k + 1, q, look)))
    return mixed(pairs)


# ---- sections 5 and 6: lookup in 3-D -------------------------------------------------------------

@dataclass
class Ray:
    start: tuple                   # X, Y, z in cells of level 0
    end: tuple
    footprints: tuple
    wrap: tuple
    light: Light = None

    def at(self, t: float) -> tuple:
        return tuple(a + t * (b - a) for a, b in zip(self.start, self.end))

    def footprint(self, t: float) -> float:
        return self.footprints[0] + t * (self.footprints[1] - self.footprints[0])


@dataclass
class Answer:
    kind: int                      # 0 nothing, 1 lookup in 2-D, 2 an umbrella, 3 the background
    rgba: list
    normal: tuple = (0.0, 0.0, 0.0)
    t: float = 1.0
    umbrella: int = -1


NOTHING = Answer(0, CLEAR)


def taper(t: Umbrellas, rho: float) -> float:
    """H / h"""
    x = min(max((rho - t.taper[0]) / (t.taper[1] - t.taper[0]), 0.0), 1.0)
    return 1 - x * x * (3 - 2 * x)


def square(level: Level, rho: float) -> tuple:
    """The derivatives of (s, t) of a square pixel."""
    return (rho / level.width, 0.0), (0.0, rho / level.height)


def on_ground(t: Umbrellas, ray: Ray) -> Query:
    """The place and the pixel of P_1, None if it is not on the ground."""
    if ray.end[2] > 0:
        return None
    level, rho = t.levels[0], ray.footprints[1]
    return Query(ray.end[0] / level.width, ray.end[1] / level.height, *square(level, rho),
                 ray.wrap, "trilinear", ray.light)


def crossed(ray: Ray) -> list:
    """The places along the ray where it enters and leaves each cell, in order."""
    stops = {0.0, 1.0}
    for axis in range(2):
        a, b = ray.start[axis], ray.end[axis]
        for n in range(math.ceil(min(a, b)), math.floor(max(a, b)) + 1) if a != b else ():
            stops.add((n - a) / (b - a))
    stops = sorted(s for s in stops if 0 <= s <= 1)
    return list(zip(stops, stops[1:]))


def into_grid(x: float, n: int, mode: int):
    """The cell in a direction, and what to multiply and to add to bring coordinates there; None
    outside."""
    tile = math.floor(x / n)
    if tile == 0:
        return math.floor(x), 1, 0
    if mode == REPEAT:
        return math.floor(x) - tile * n, 1, -tile * n
    if mode == MIRROR:
        if tile % 2 == 0:
            return math.floor(x) - tile * n, 1, -tile * n
        return (tile + 1) * n - 1 - math.floor(x), -1, (tile + 1) * n
    return None


def reach_of(u: Umbrella) -> float:
    """R"""
    scale = math.hypot(u.a, u.b) if u.form == PARAMETRIC else 1.0
    return max(math.hypot(*d) for d in contour(u)) * scale


@dataclass
class Hit:
    place: float                   # 0 at a', 1 at b'
    point: tuple                   # (x, y) around the centre
    q: tuple                       # for section 3
    normal: tuple


def flat_hits(a: tuple, b: tuple) -> list:
    if a[2] == b[2]:
        return []
    s = a[2] / (a[2] - b[2])
    if not 0 <= s <= 1:
        return []
    p = a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])
    return [Hit(s, p, p, (0.0, 0.0, 1.0))]


def cap_hits(u: Umbrella, a: tuple, b: tuple, tau_a: float, tau_b: float) -> list:
    """Where the segment from a to b, around the centre and the lift, meets the cap or the bowl."""
    e, k, radius = u.height, u.curvature, reach_of(u)
    c = e / k
    z0, big = e - c, radius / math.sqrt(k * (2 - k))
    if u.ellipsoid == CONCAVE:
        a, b = (a[0], a[1], e - a[2]), (b[0], b[1], e - b[2])
    p = a[0] / big, a[1] / big, (a[2] - z0) / c
    v = (b[0] - a[0]) / big, (b[1] - a[1]) / big, (b[2] - a[2]) / c
    qa, qb = sum(x * x for x in v), sum(x * y for x, y in zip(p, v))
    qc = sum(x * x for x in p) - 1
    under_root = qb * qb - qa * qc
    if qa == 0 or under_root < 0:
        return []
    out = []
    for root in (-math.sqrt(under_root), math.sqrt(under_root)):
        s = (root - qb) / qa
        x, y, z = (m + s * (n - m) for m, n in zip(a, b))
        if not 0 <= s <= 1 or z < 0:
            continue
        r, tau = math.hypot(x, y), tau_a + s * (tau_b - tau_a)
        phi = math.acos(min(max((z - z0) / c, -1.0), 1.0))
        length = (1 - tau) * r + tau * radius * phi / math.acos(1 - k)
        q = (x / r * length, y / r * length) if r > 0 else (0.0, 0.0)
        up = -1 if u.ellipsoid == CONCAVE else 1
        n = x / big ** 2, y / big ** 2, up * (z - z0) / c ** 2
        size = math.hypot(*n)
        out.append(Hit(s, (x, y), q, tuple(m / size for m in n)))
    return out


def hits(u: Umbrella, a: tuple, b: tuple, tau_a: float, tau_b: float) -> list:
    if u.ellipsoid == FLAT or u.height == 0:
        return flat_hits(a, b)
    return cap_hits(u, a, b, tau_a, tau_b)


def in_cell(t: Umbrellas, entries: list, a: tuple, b: tuple, taus: tuple, rhos: tuple, look) -> tuple:
    """(hit, entry, shift, colour) of the first hit on the bent segment, None without."""
    level, best = t.levels[0], None
    for entry, shift in entries:
        u = level.umbrellas[entry]
        ends = [relative(level, u, shift, p) + (p[2] - u.lift,) for p in (a, b)]
        for hit in hits(u, *ends, *taus):
            rho = rhos[0] + hit.place * (rhos[1] - rhos[0])
            cover, colour, alpha = at_point(t, u, hit.q, (rho, 0.0), (0.0, rho), True, look)
            if cover * alpha < 0.5:
                continue
            if best is None or hit.place <= best[0].place:
                best = hit, entry, shift, [v / alpha for v in colour]
            break
    return best


def trace(t: Umbrellas, ray: Ray, look) -> Answer:
    level = t.levels[0]
    for at, to in crossed(ray):
        middle = ray.at((at + to) / 2)
        cell = [into_grid(middle[k], (level.width, level.height)[k], ray.wrap[k]) for k in range(2)]
        if None in cell:
            continue
        rhos = ray.footprint(at), ray.footprint(to)
        taus = taper(t, rhos[0]), taper(t, rhos[1])
        if min(taus) * t.h <= t.h / 64:
            q = on_ground(t, ray)
            return Answer(1, look_up(t, q, look)) if q else NOTHING
        ends = []
        for place, tau in ((at, taus[0]), (to, taus[1])):
            p = ray.at(place)
            ends.append(tuple(m * x + n for x, (_, m, n) in zip(p, cell)) + (p[2] / tau,))
        entries = level.lists[cell[1][0] * level.width + cell[0][0]]
        found = in_cell(t, entries, *ends, taus, rhos, look)
        if found:
            return answer(t, ray, found, ends, cell, (at, to), rhos)
    q = on_ground(t, ray)
    s, v = (into_unit(x, mode) for x, mode in zip((q.s, q.t), q.wrap)) if q else (None, None)
    if s is None or v is None:
        return NOTHING
    q = replace(q, s=s, t=v)
    rho = ray.footprints[1]
    lit = Shadows(t, level, q, (s * level.width, v * level.height), (rho, 0.0), (0.0, rho)).above(-1)
    below = background(t, q, look)
    return Answer(3, [lit * x for x in below[:3]] + [below[3]])


def answer(t: Umbrellas, ray: Ray, found: tuple, ends: list, cell: list, places: tuple,
           rhos: tuple) -> Answer:
    hit, entry, shift, colour = found
    level, u = t.levels[0], t.levels[0].umbrellas[entry]
    rho = rhos[0] + hit.place * (rhos[1] - rhos[0])
    p = (hit.point[0] + u.centre[0] + shift[0] * level.width,
         hit.point[1] + u.centre[1] + shift[1] * level.height)
    q = Query(0.0, 0.0, *square(level, rho), ray.wrap, "trilinear", ray.light)
    lit = Shadows(t, level, q, p, (rho, 0.0), (0.0, rho)).above(entry)
    n = hit.normal
    if sum(x * (e - s) for x, s, e in zip(n, *ends)) > 0:
        n = tuple(-x for x in n)
    n = n[0] * cell[0][1], n[1] * cell[1][1], n[2]         # a mirrored copy mirrors it
    place = places[0] + hit.place * (places[1] - places[0])
    return Answer(2, [lit * v for v in colour] + [1.0], n, place, entry)
