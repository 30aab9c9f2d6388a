# SPDX-License-Identifier: Apache-2.0
"""The valid files with umbrellas; `scene` makes most of them, the rest are calls of it."""

from silmake import BORDER, CLAMP, MIRROR, REPEAT
from umbmake import CONCAVE, CONVEX, OF_BASE, ONE, Base, Umbrella, Umbrellas, coloured, explicit
from valid import META, PLACED, add, decal, mask, place, root
from valid_silmaps import CLAMPED, REPEATED, WRAP_NAMES, sample_image, tame
from valid_silmaps import texture as silmap_texture
from ztexmake import (FORMATS, NONE, R8, RGBA8, RGBA8_SRGB, Chunk, File, Image, Patch, Plane,
                      Texture, Zipmap, flat, noise)
from zstd_frames import FRAMES

FAR = 1 << 30
WIDE = {"": Plane(packing=2)}                              # what is constant stores nothing


# ---- parts ---------------------------------------------------------------------------------------

def on_square(r: int, s: int) -> tuple:
    """The point s units along the outline of a square of half the side r, from its top right corner
    down."""
    side, t = divmod(s, 2 * r)
    return ((r, t - r), (r - t, r), (-r, r - t), (t - r, -r))[side]


def ring(n: int, r: int, seed: int = 0) -> list:
    """n vertices around the centre, within r; with a seed, not all as far away."""
    out = []
    for k, v in enumerate(noise(n, seed) if seed else bytes(n)):
        x, y = on_square(r, (r // 2 + 8 * r * k // n) % (8 * r))
        out.append((x * (384 - v % 192) // 384, y * (384 - v % 192) // 384))
    return out


def placed(centre: tuple, points: list) -> list:
    return [(centre[0] + x, centre[1] + y) for x, y in points]


def tints(n: int, seed: int, low: int = 0, high: int = 255) -> list:
    """n colours with channels from low to high."""
    values = noise(3 * n, seed)
    return [tuple(low + v * (high - low + 1) // 256 for v in values[3 * k:3 * k + 3]) for k in range(n)]


def leaf_texels(w: int, h: int, seed: int):
    """RGBA of 8 bits: colours without pattern, and alpha that is mostly 1."""
    def texels(level, size):
        rgb, alpha = noise(size, seed + level), noise(size // 4, seed + 7 * level + 1)
        return b"".join(rgb[4 * k:4 * k + 3] + bytes([255 if v > 72 else 3 * v])
                        for k, v in enumerate(alpha))
    return texels


def leaf_image(w: int = 8, h: int = 8, seed: int = 50, levels: int = 4, **more) -> Image:
    more = {"alpha_mode": 1, **more}
    return Image(more.pop("format", RGBA8_SRGB), w, h, levels=levels,
                 texels=more.pop("texels", leaf_texels(w, h, seed)), **more)


MIDDLE = (32768, 32768)
LEAF = Base(0, MIDDLE, placed(MIDDLE, ring(6, 30000, 3)),
            variants=[tints(7, 11, -100, 100), tints(7, 12, -128, 127)])
STONE = Base(0, (20000, 40000), placed((20000, 40000), ring(5, 18000, 4)), aspect=49152,
             morph=placed((20000, 40000), ring(5, 19000, 9)), variants=[tints(6, 13, -60, 60)],
             ellipsoid=CONVEX, height=30000, curvature=40000)
PLAIN = Base(0, (40000, 30000), placed((40000, 30000), ring(9, 25000, 6)), aspect=98304)
BASES = [LEAF, STONE, PLAIN]


class Numbers:
    """Numbers that depend on the seed only."""

    def __init__(self, seed: int):
        self.bytes, self.at = noise(4096, seed), 0

    def below(self, n: int) -> int:
        self.at += 2
        return (self.bytes[self.at - 2] << 8 | self.bytes[self.at - 1]) * n >> 16

    def between(self, low: int, high: int) -> int:
        return low + self.below(high - low + 1)


def solid(r: Numbers, form: int) -> dict:
    """An ellipsoid, or none, and a lift."""
    kind = r.below(3 if form == 2 else 4)
    more = {"ellipsoid": kind, "lift": r.below(20000)}
    if kind in (CONVEX, CONCAVE):
        more.update(height=r.between(8000, 40000), curvature=r.between(9000, 65535))
    return more


def some_umbrella(r: Numbers, form: int, bases: list, size: tuple, three_d: bool) -> Umbrella:
    x, y = (r.below(ONE * n) for n in size)
    more = solid(r, form) if three_d else {}
    if form == 2:
        n = r.between(3, 7)
        return coloured(x, y, ring(n, r.between(500, 1000), r.between(1, 99)), tints(n + 1, r.below(99)),
                        **more)
    number = r.below(len(bases))
    base = bases[number]
    more["strength"] = r.between(100, 255)
    if form == 1:
        n = len(base.vertices)
        return explicit(x, y, number, ring(n, r.between(600, 1100), r.between(1, 99)),
                        tints(n + 1, r.below(99), -90, 90), **more)
    count = len(base.variants)
    return Umbrella(x, y, number, a=r.between(-80000, 80000) | 1, b=r.between(-80000, 80000),
                    mirrored=r.below(2) == 1, morph=r.below(256) if base.morph else 0,
                    variants=(r.below(count), r.below(count)) if count else (0, 0),
                    weight=r.below(256), **more)


def arrangement(grid: tuple = (4, 4), wrap: tuple = CLAMPED, counts=(8, 3, 1), bases: list = None,
                seed: int = 1, forms=(0, 1, 0), three_d: bool = False, **more) -> Umbrellas:
    """Umbrellas anywhere; level 0 has the forms in turn, the others form 2."""
    bases = BASES if bases is None else bases
    r, levels = Numbers(seed), []
    for level, count in enumerate(counts):
        size = tuple(max(1, n >> level) for n in grid)
        levels.append([some_umbrella(r, forms[k % len(forms)] if level == 0 else 2, bases, size,
                                     three_d) for k in range(count)])
    return Umbrellas(grid, levels, bases, wrap, **more)


def textured(umbrellas: Umbrellas, name: str = "umbrellas", semantic: int = 1) -> Texture:
    return Texture(name, [(semantic, NONE)], wrap=umbrellas.wrap, umbrellas=umbrellas)


def in_file(umbrellas: Umbrellas, images: list = None, before: list = None, **more) -> File:
    return File(images or [leaf_image()], (before or []) + [textured(umbrellas)], **more)


FILE_FIELDS = ("images", "before", "meta", "extra", "codec", "overrides")


def scene(*args, **more) -> File:
    own = {k: more.pop(k) for k in FILE_FIELDS if k in more}
    return in_file(arrangement(*args, **more), **own)


def level_0(umbrellas: list, grid: tuple = (4, 4), bases: list = None, **more) -> File:
    """One level with these umbrellas."""
    own = {k: more.pop(k) for k in FILE_FIELDS if k in more}
    return in_file(Umbrellas(grid, [umbrellas], BASES if bases is None else bases, **more), **own)


def middle(x: float = 2.0, y: float = 2.0) -> dict:
    return {"x": round(x * ONE), "y": round(y * ONE)}


# ---- the example of the specification ------------------------------------------------------------

EXAMPLE_TEXELS = bytes((204, 102, 51, 255, 102, 102, 51, 255, 153, 51, 0, 255, 51, 153, 102, 255))
EXAMPLE = Umbrellas(
    (2, 2), [[Umbrella(65536, 65536, a=163840, strength=255),
              Umbrella(98304, 65536, a=81920, mirrored=True, variants=(0, 1), weight=51, strength=255,
                       ellipsoid=CONVEX, height=39321, curvature=32767, lift=13107)],
             [coloured(32768, 32768, [(1024, 0), (0, 1024), (-1024, 0), (0, -1024)],
                       [(153, 102, 51)] + [(102, 102, 51)] * 4)]],
    [Base(0, (26214, 26214), [(52428, 26214), (26214, 52428), (0, 26214), (26214, 0)],
          variants=[[(0, 0, 0)] * 5, [(127, 0, 0)] + [(0, -127, 0)] * 4])],
    (REPEAT, CLAMP, CLAMP), background=(0.0625, 0.03125, 0.015625, 1.0), mean=(0.25, 0.125, 0.0625, 1.0),
    prism_height=0.5, planes={"": Plane(packing=2)})
add("umbrella_example", "The example of umbrella.md: 2 x 2 cells, repeat in u and clamp in v, one base, "
    "two umbrellas, and one in the level above.",
    in_file(EXAMPLE, [Image(RGBA8, 2, 2, alpha_mode=1, texels=lambda level, size: EXAMPLE_TEXELS)]))

# ---- nothing, and little -------------------------------------------------------------------------

for grid in ((1, 1), (4, 4), (3, 5)):
    add("umbrella_none_%dx%d" % grid, "No bases and no umbrellas: the background, %d x %d cells." % grid,
        scene(grid, counts=(0,), bases=[]))
add("umbrella_none_all_levels", "No umbrellas in any of four levels.",
    scene((8, 8), counts=(0, 0, 0, 0), bases=[]))
add("umbrella_no_bases", "No bases, umbrellas of form 2 in all levels.",
    scene(counts=(6, 3, 1), bases=[], forms=(2,), seed=2))
add("umbrella_no_umbrellas", "Bases that nothing uses.", scene(counts=(0, 0)))
add("umbrella_level_0_empty", "Level 0 has no umbrellas, levels 1 and 2 have some.",
    scene(counts=(0, 4, 2), seed=3))
add("umbrella_level_1_empty", "Level 1 has no umbrellas.", scene(counts=(5, 0, 2), seed=4))
add("umbrella_last_level_empty", "The last level has no umbrellas.", scene(counts=(5, 2, 0), seed=5))
add("umbrella_lists_empty", "Umbrellas that no list names.",
    scene(counts=(5, 2), lists=[[[] for _ in range(16)], [[] for _ in range(4)]]))
add("umbrella_lists_some_empty", "Two small umbrellas in a large grid: most lists are empty.",
    level_0([Umbrella(**middle(1.5, 1.5), a=40000), Umbrella(**middle(6.5, 4.25), a=20000, b=30000)],
            (9, 7)))
add("umbrella_smallest", "One cell, one umbrella of three vertices, form 2.",
    level_0([coloured(20000, 40000, ring(3, 400), tints(4, 1))], (1, 1), []))

# ---- forms and their fields ----------------------------------------------------------------------

for form, what in enumerate(("parametric", "explicit", "coloured")):
    add("umbrella_form_%d" % form, "Level 0 has only umbrellas of form %d, %s." % (form, what),
        scene(forms=(form,), seed=10 + form))
add("umbrella_forms_mixed", "Level 0 has umbrellas of all forms.",
    scene(counts=(12,), forms=(0, 1, 2), seed=14))
add("umbrella_mirrored", "Each umbrella twice: as it is, and mirrored.",
    level_0([Umbrella(**middle(x, y), base=k, a=70000, b=30000, mirrored=m)
             for k, y in enumerate((0.75, 2.0, 3.25)) for m, x in ((False, 1.0), (True, 3.0))]))
add("umbrella_similarities", "Rotations by the eighths of a turn, at four sizes.",
    level_0([Umbrella(**middle(0.5 + k % 8 / 1.2, 0.75 + 1.5 * (k // 8)), base=k % 3,
                      a=a * (20000 + 10000 * (k // 8)), b=b * (20000 + 10000 * (k // 8)))
             for k, (a, b) in enumerate([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1),
                                         (1, -1)] * 3)], (7, 5)))
for m in (0, 1, 128, 254, 255):
    add("umbrella_morph_%d" % m, "A base with a morph, at weight %d of 255." % m,
        level_0([Umbrella(**middle(), base=1, a=150000, b=40000, morph=m)]))
# Each second position is the next vertex: d_i x e_j + e_i x d_j is exactly 0 on this square.
SQUARE = [(30000, 0), (0, 30000), (-30000, 0), (0, -30000)]
TURNING = Base(0, MIDDLE, placed(MIDDLE, SQUARE), morph=placed(MIDDLE, SQUARE[1:] + SQUARE[:1]))
add("umbrella_morph_turns", "A morph that turns a square by a quarter: the sum of [R8308] is 0, the "
    "smallest that it may be.", level_0([Umbrella(**middle(), a=150000, morph=m) for m in (0, 100, 200)],
                                        bases=[TURNING]))
add("umbrella_morph_some", "Bases with and without a morph in turn.",
    level_0([Umbrella(**middle(1 + k % 3, 1 + k // 3), base=k, a=90000, morph=0 if k % 2 else 200)
             for k in range(5)],
            bases=[STONE, LEAF, TURNING, PLAIN, STONE]))
for n in (0, 1, 2, 255):
    own = Base(0, MIDDLE, placed(MIDDLE, ring(4, 30000, 5)), variants=[tints(5, 20 + k, -128, 127)
                                                                       for k in range(n)])
    add("umbrella_variants_%d" % n, "A base with %d colour variants." % n,
        level_0([Umbrella(**middle(0.75 + 1.25 * (k % 3), 0.75 + 1.25 * (k // 3)), a=80000, b=5000,
                          variants=(max(0, min(n - 1, 50 * k)), max(0, n - 1 - k)), weight=60 * k)
                 for k in range(5)], bases=[own]))
for mode, name in enumerate(("barycentric", "inverse_distance")):
    add("umbrella_colours_" + name, "colour_mode %d, all forms." % mode,
        scene(counts=(12, 4, 1), forms=(0, 1, 2), colour_mode=mode, seed=21))
add("umbrella_colour_offsets", "Offsets of -128, -127, 0, 1 and 127, strengths of 0, 1, 128 and 255.",
    level_0([Umbrella(**middle(1 + 2 * (k % 2), 1 + 2 * (k // 2)), a=90000, strength=f,
                      variants=(k % 2, 1), weight=(0, 255, 128, 1)[k])
             for k, f in enumerate((255, 128, 1, 0))],
            bases=[Base(0, MIDDLE, placed(MIDDLE, SQUARE), variants=[
                [(-128, 0, 127), (127, -127, 1), (0, 0, 0), (-1, 1, -128), (64, -64, 32)],
                [(127, 127, 127), (-128, -128, -128), (0, 127, 0), (-127, 0, 0), (0, 0, -64)]])]))
add("umbrella_colours_explicit", "Form 1 with the extremes of offsets, form 2 with those of colours.",
    level_0([explicit(**middle(1, 1), base=0, vertices=ring(6, 1000), strength=200,
                      colours=[(-128, 127, 0)] * 3 + [(127, -128, -127)] * 4),
             coloured(**middle(3, 3), vertices=ring(5, 900), colours=[(0, 255, 128)] * 3
                      + [(255, 0, 1)] * 3)], bases=[LEAF]))
for bits in (0, 8, 15, 16):
    add("umbrella_level_bits_%d" % bits, "Explicit vertices in 2^-%d of a cell." % bits,
        level_0([coloured(ONE * (1 + k) // 2, ONE * (3 - k), ring(4 + k, max(2, 1 << bits), k),
                          tints(5 + k, k)) for k in range(3)] if bits else
                [coloured(ONE, ONE, [(1, 0), (0, 1), (-1, -1)], tints(4, 1)),
                 coloured(ONE * 5 // 2, ONE * 2, [(2, 0), (0, 1), (-1, 0), (0, -2)], tints(5, 2))],
                bases=[], level_bits=[bits]))
add("umbrella_level_bits_differ", "Every level has level_bits of its own.",
    scene((16, 16), counts=(6, 4, 3, 2, 2), level_bits=[9, 12, 10, 11, 9], seed=24))
add("umbrella_overlapping_300", "300 umbrellas over each other: the longest list has 300 entries.",
    level_0([coloured(ONE // 2 + 50 * k, ONE // 2, ring(3 + k % 4, 300 + k, k + 1), tints(4 + k % 4, k))
             for k in range(300)], (1, 1), []))
add("umbrella_contour_not_convex", "A star of nine points, whose sectors are narrow.",
    level_0([Umbrella(**middle(), a=200000)], bases=[Base(0, MIDDLE, placed(MIDDLE, [
        (x // (1 + 2 * (k % 2)), y // (1 + 2 * (k % 2))) for k, (x, y) in enumerate(ring(18, 32000))]))]))
add("umbrella_on_an_axis", "Vertices exactly to the right, where [R8307] begins to count, and behind it.",
    level_0([coloured(**middle(1, 1), vertices=[(900, 0), (0, 900), (-900, 0), (0, -900)],
                      colours=tints(5, 3)),
             coloured(**middle(3, 3), vertices=[(0, 900), (-900, 0), (0, -900), (900, 0)],
                      colours=tints(5, 4)),
             coloured(**middle(3, 1), vertices=[(900, -1), (-900, 900), (-10, -900)],
                      colours=tints(4, 5))], bases=[]))

# ---- three dimensions ----------------------------------------------------------------------------

SOLIDS = [("flat", {}), ("flat_lifted", {"lift": 30000}),
          ("convex", {"ellipsoid": CONVEX, "height": 45000, "curvature": 40000}),
          ("convex_lifted", {"ellipsoid": CONVEX, "height": 25000, "curvature": 65535, "lift": 20000}),
          ("convex_without_height", {"ellipsoid": CONVEX, "curvature": 30000, "lift": 9000}),
          ("concave", {"ellipsoid": CONCAVE, "height": 45000, "curvature": 50000}),
          ("concave_lifted", {"ellipsoid": CONCAVE, "height": 15000, "curvature": 9000, "lift": 15000}),
          ("of_base", {"ellipsoid": OF_BASE, "lift": 5000}),
          ("low_curvature", {"ellipsoid": CONVEX, "height": 32767, "curvature": 0}),
          ("as_high_as_can_be", {"ellipsoid": CONVEX, "height": 65535, "curvature": 32767}),
          ("lifted_as_far_as_can_be", {"lift": 65535})]
for name, more in SOLIDS:
    number = 1 if name == "of_base" else 0
    add("umbrella_solid_" + name, "One large umbrella: %s." % name.replace("_", " "),
        level_0([Umbrella(**middle(2.25, 1.75), base=number, a=130000, b=70000, **more)],
                prism_height=1.25))
for kind, name in ((CONVEX, "convex"), (CONCAVE, "concave")):
    like = Base(0, MIDDLE, placed(MIDDLE, ring(7, 31000, 8)), ellipsoid=kind, height=40000,
                curvature=30000)
    add("umbrella_solid_base_" + name, "A %s base: an umbrella takes its ellipsoid, one does not."
        % name, level_0([Umbrella(**middle(1, 2), a=120000, ellipsoid=OF_BASE, lift=25535),
                         Umbrella(**middle(3, 2), a=120000)], bases=[like]))
add("umbrella_solid_base_flat", "A flat base whose ellipsoid an umbrella takes.",
    level_0([Umbrella(**middle(), a=120000, ellipsoid=OF_BASE, lift=65535)], bases=[LEAF]))
add("umbrella_solid_explicit", "Forms 1 and 2 with ellipsoids; form 1 also with that of its base.",
    level_0([explicit(**middle(1, 1), base=1, vertices=ring(5, 1000, 3), colours=tints(6, 7, -90, 90),
                      ellipsoid=OF_BASE),
             explicit(**middle(3, 1), base=1, vertices=ring(5, 1100, 5), colours=tints(6, 8, -90, 90),
                      ellipsoid=CONCAVE, height=30000, curvature=20000, lift=3000),
             coloured(**middle(1, 3), vertices=ring(6, 1000, 6), colours=tints(7, 9),
                      ellipsoid=CONVEX, height=50000, curvature=60000),
             coloured(**middle(3, 3), vertices=ring(4, 1200, 7), colours=tints(5, 10),
                      ellipsoid=CONCAVE, height=20000, curvature=40000, lift=20000)]))
for k, mode in enumerate(WRAP_NAMES):
    add("umbrella_solid_many_" + mode, "Umbrellas of all forms and ellipsoids, %s." % mode,
        scene((5, 4), (k, k, 0), (14, 3), forms=(0, 1, 0, 2), three_d=True, seed=30 + k,
              prism_height=0.75))
add("umbrella_solid_pile", "Lifted umbrellas above each other, the last is the lowest.",
    level_0([Umbrella(**middle(2 + 0.1 * k, 2), base=k % 3, a=100000, b=20000 * k, lift=40000 - 9000 * k)
             for k in range(5)]))
add("umbrella_solid_same_lift", "Flat umbrellas in one plane: of equally near hits the last counts.",
    level_0([Umbrella(**middle(1.5 + 0.5 * k, 2), base=k % 2 * 2, a=110000, b=30000 * k, lift=10000)
             for k in range(3)]))
for name, h, taper in (("prism_flat", 0.0, (0.03125, 0.125)), ("prism_high", 16.0, (0.03125, 0.125)),
                       ("taper_from_0", 1.0, (0.0, 0.0625)), ("taper_late", 1.0, (0.0625, 0.125)),
                       ("taper_short", 1.0, (0.0625, 0.0703125))):
    add("umbrella_" + name, "prism_height %g, taper from %g to %g." % ((h,) + taper),
        scene(counts=(9, 2), three_d=True, seed=40, prism_height=h, taper=taper))

# ---- wrap modes, shifts --------------------------------------------------------------------------

for u, name_u in enumerate(WRAP_NAMES):
    for v, name_v in enumerate(WRAP_NAMES):
        add("umbrella_wrap_%s_%s" % (name_u, name_v), "Wrap modes %s in u and %s in v."
            % (name_u, name_v), scene((5, 4), (u, v, (u + v) % 4), (10, 4, 1), seed=50 + 4 * u + v))
add("umbrella_shift_all", "One cell that repeats, and an umbrella larger than it: all nine shifts.",
    level_0([Umbrella(20000, 40000, 0, a=150000, b=60000), Umbrella(50000, 10000, 2, a=40000)], (1, 1),
            wrap=REPEATED))
add("umbrella_shift_corner", "An umbrella over the corner of a grid that repeats.",
    level_0([Umbrella(100, 200, 0, a=90000)], (3, 3), wrap=REPEATED))
add("umbrella_shift_one_direction", "A grid that repeats in u only; centres lie outside in v.",
    level_0([Umbrella(1000, -30000, 0, a=120000, b=9000),
             Umbrella(4 * ONE - 1, 3 * ONE + 40000, 2, a=120000)], (4, 3), wrap=(REPEAT, CLAMP, CLAMP)))
add("umbrella_shift_needless", "Lists may name shifts that do not meet the cell.",
    level_0([Umbrella(**middle(1, 1), a=90000)], (2, 2), wrap=REPEATED,
            lists=[[[(0, (sx, sy)) for sy in (-1, 0, 1) for sx in (-1, 0, 1)]] * 4]))
add("umbrella_outside", "Centres outside of a grid that does not repeat.",
    level_0([Umbrella(-20000, ONE, 0, a=90000, b=20000), Umbrella(ONE, 4 * ONE + 10000, 2, a=90000),
             Umbrella(4 * ONE, 0, 1, a=90000), coloured(5 * ONE, 5 * ONE, ring(4, 3000), tints(5, 2))],
            wrap=(CLAMP, MIRROR, 0)))

# ---- grids and levels ----------------------------------------------------------------------------

for n in (1, 2, 3, 4):
    add("umbrella_levels_%d" % n, "8 x 8 cells, %d of 4 levels." % n,
        scene((8, 8), counts=(10, 5, 3, 1)[:n], seed=70))
for grid, counts in (((7, 5), (8, 4, 1)), ((5, 1), (5, 2, 1)), ((1, 6), (5, 2, 1)), ((1, 1), (3,)),
                     ((3, 10), (9, 4, 2, 1)), ((9, 2), (7, 3, 2, 1))):
    for wrap in (CLAMPED, REPEATED):
        add("umbrella_grid_%dx%d_%s" % (grid + (WRAP_NAMES[wrap[0]],)), "%d x %d cells, all levels, %s."
            % (grid + (WRAP_NAMES[wrap[0]],)), scene(grid, wrap, counts, seed=80 + grid[0]))
FOURTEEN = (3, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 1)
add("umbrella_grid_8192x1", "8192 x 1 cells, 14 levels with level_bits of 3 to 16.",
    scene((8192, 1), REPEATED, FOURTEEN, level_bits=list(range(3, 17)), planes=WIDE, seed=90))
add("umbrella_grid_1x8192", "1 x 8192 cells, 14 levels with level_bits of 13 to 0 and 2^30 for an "
    "element of the last.",
    in_file(Umbrellas((1, 8192), [[] for _ in range(13)] + [[
        coloured(0, 0, [(FAR, -1), (-1, FAR), (-FAR, -FAR)], tints(4, 3))]], [], CLAMPED,
        level_bits=list(range(13, -1, -1)), planes=WIDE)))
add("umbrella_grid_200x120", "200 x 120 cells with few umbrellas.",
    scene((200, 120), (MIRROR, MIRROR, 0), (30, 20, 10, 5), planes=WIDE, seed=91))

# ---- extremes of the ranges ----------------------------------------------------------------------

add("umbrella_far_similarity", "a and b of -2^30 and 2^30, and of one 65536th.",
    level_0([Umbrella(**middle(), a=FAR, b=-FAR), Umbrella(**middle(), a=-FAR, b=FAR, base=2),
             Umbrella(**middle(1, 1), a=0, b=1), Umbrella(**middle(1, 1), a=-1)]))
add("umbrella_far_centres", "Centres at -2^30 and 2^30.",
    level_0([Umbrella(-FAR, FAR, a=9999), Umbrella(FAR, -FAR, a=9999)]))
add("umbrella_far_centres_repeat", "Centres at 0 and at the last 65536th of a grid that repeats.",
    level_0([Umbrella(0, 0, a=50000), Umbrella(4 * ONE - 1, 4 * ONE - 1, a=50000)], wrap=REPEATED))
add("umbrella_far_vertices", "Explicit vertices at -2^30 and 2^30.",
    level_0([coloured(**middle(), vertices=[(FAR, FAR), (-FAR, FAR), (-FAR, -FAR), (FAR, -FAR)],
                      colours=tints(5, 1)),
             explicit(**middle(1, 1), base=0, vertices=[(1, 0), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1)],
                      colours=tints(7, 2, -9, 9))], level_bits=[16]))
add("umbrella_aspect_extremes", "base_aspect of 1 and of 2^24.",
    level_0([Umbrella(**middle(), a=90000), Umbrella(**middle(1, 1), base=1, a=1000)],
            bases=[Base(0, MIDDLE, placed(MIDDLE, SQUARE), aspect=1),
                   Base(0, MIDDLE, placed(MIDDLE, SQUARE), aspect=1 << 24)]))
WHOLE = [(65535, 0), (65535, 65535), (0, 65535), (0, 0)]
add("umbrella_base_corners", "Vertices at 0 and 65535, centres close to them.",
    level_0([Umbrella(**middle(1, 1 + k), base=k, a=90000) for k in range(3)],
            bases=[Base(0, centre, WHOLE) for centre in ((1, 1), (65534, 65534), MIDDLE)]))
add("umbrella_base_centre_corner", "A small base in the corner of its picture.",
    level_0([Umbrella(**middle(), a=FAR // 4096)], bases=[Base(0, (2, 65533), [
        (4, 65534), (1, 65535), (0, 65533), (3, 65530)])]))
add("umbrella_base_4096_vertices", "A base of 4096 vertices, and a form 1 of it.",
    level_0([Umbrella(**middle(1, 1), a=90000),
             explicit(**middle(3, 3), base=0, vertices=ring(4096, 1 << 20),
                      colours=[(0, 0, 0)] * 4097)],
            bases=[Base(0, MIDDLE, placed(MIDDLE, ring(4096, 32000)))], level_bits=[16],
            planes={name: Plane(2, 1, 0) for name in ("vertex_x", "vertex_y")} | WIDE))
add("umbrella_coloured_4096_vertices", "An umbrella of form 2 with 4096 vertices.",
    level_0([coloured(**middle(), vertices=ring(4096, 1 << 17), colours=[(9, 200, 30)] * 4097)],
            bases=[], level_bits=[16], planes=WIDE))
TRIANGLE_X, TRIANGLE_Y = (32769, 32768, 32767), (32767, 32769, 32767)
add("umbrella_bases_256", "256 bases that are alike, each shown once, variants of each another number.",
    level_0([Umbrella(ONE // 2 + ONE * (k % 16), ONE // 2 + ONE * (k // 16), base=k, a=60000,
                      variants=(max(0, k % 4 - 1), 0)) for k in range(256)], (16, 16),
            bases=[Base(0, MIDDLE, list(zip(TRIANGLE_X, TRIANGLE_Y)),
                        variants=[[(k - 128, 0, 0)] * 4] * (k % 4)) for k in range(256)], planes=WIDE))
add("umbrella_bases_65536_encoder", "65,536 bases, the most that there may be; the last is shown.",
    level_0([Umbrella(**middle(), base=65535, a=1 << 20)], bases=[
        Base(0, MIDDLE, list(zip(TRIANGLE_X, TRIANGLE_Y)))] * 65536,
            planes=WIDE | {"vertex_x": Plane(codec=1), "vertex_y": Plane(codec=1)},
            overrides={"umbr.0.vertex_%s.stored" % c: bytes.fromhex(FRAMES["triangles_" + c][1])
                       for c in "xy"}))
add("umbrella_f32_extremes", "Denormal, tiny and huge numbers of type f32.",
    scene(counts=(2,), background=(1, 0x7F7FFFFF, 0, 0x00800000), mean=(0x7F7FFFFF, 0, 1, 0x3F800000),
          prism_height=0x7F7FFFFF, taper=(0x3DFFFFFF, 0x3E000000)))
add("umbrella_f32_zero", "All f32 that may be 0 are.",
    scene(counts=(2,), background=(0.0,) * 4, mean=(0.0,) * 4, prism_height=0.0, taper=(0.0, 1)))

# ---- pictures and backgrounds --------------------------------------------------------------------

for number, mode in ((9, 0), (16, 0), (23, 0), (29, 0), (37, 0), (37, 1), (43, 2), (70, 0), (91, 1),
                     (97, 2), (100, 0), (109, 1)):
    name = FORMATS[number].name.lower() + ("", "_straight", "_premultiplied")[mode]
    add("umbrella_format_" + name, "The picture of the bases, and the background, of %s, alpha_mode %d."
        % (FORMATS[number].name, mode), scene(counts=(8, 2), seed=100 + number, background_kind=1,
        background_source=1, images=[
            Image(number, 6, 5, levels=3, alpha_mode=mode, seed=5, texels=tame(number, 5)),
            Image(number, 3, 4, levels=1, alpha_mode=mode, seed=6, texels=tame(number, 6))]))
add("umbrella_format_bc7", "A picture in a block format, which a reader may not be able to look up.",
    scene(images=[Image(145, 8, 8, texels=flat(0))]))
add("umbrella_format_unknown", "A picture in a format that the registry does not have.",
    scene(images=[Image(1000, 8, 8, block=(2, 2, 3))]))
add("umbrella_transfer_gamma", "A picture with primaries 9 and transfer 4.",
    scene(images=[leaf_image(format=RGBA8, primaries=9, transfer=4)]))
add("umbrella_picture_frames_kind", "A picture of layer_kind 2 with one layer.",
    scene(images=[leaf_image(layer_kind=2)]))
add("umbrella_pictures_differ", "Each base has a picture of its own, the first names the last.",
    scene(bases=[Base(2, LEAF.centre, LEAF.vertices, variants=LEAF.variants),
                 Base(1, STONE.centre, STONE.vertices, aspect=STONE.aspect, morph=STONE.morph),
                 Base(0, PLAIN.centre, PLAIN.vertices, aspect=PLAIN.aspect)], seed=120,
          images=[leaf_image(16, 4, 51, 5), leaf_image(4, 12, 52, 1), leaf_image(5, 7, 53, 2)]))
for k, mode in enumerate(WRAP_NAMES):
    add("umbrella_background_image_" + mode, "The background is an image with all levels, %s." % mode,
        scene((5, 4), (k, k, 0), (6, 2), seed=130 + k, background_kind=1, background_source=1,
              images=[leaf_image(), Image(RGBA8, 8, 6, levels=4, seed=60, alpha_mode=1)]))
add("umbrella_background_clear", "A background that is half transparent.",
    scene(background=(0.125, 0.25, 0.0, 0.5), mean=(0.125, 0.125, 0.0, 0.75), seed=135))
add("umbrella_background_picture", "The background is the picture of the bases.",
    scene(background_kind=1, background_source=0, seed=136))
ROOT_AND_PATCH = Zipmap([Patch([0]), Patch([1], PLACED)])
EARLIER = {
    "image": (Texture("earlier", [(1, 0)], wrap=REPEATED), [leaf_image(), decal()]),
    "zipmap": (Texture("earlier", [(1, NONE)], wrap=REPEATED, zipmap=ROOT_AND_PATCH),
               [root(alpha_mode=1, levels=3), decal(8, 8, 4)]),
    "silmap": (silmap_texture("earlier", 5, 4, REPEATED, [0]),
               [sample_image(5, 4, REPEATED, alpha_mode=1)]),
    "umbrellas": (textured(arrangement((3, 3), REPEATED, (6, 2), seed=140), "earlier"), [leaf_image()]),
}
SHOWN = [Base(0, b.centre, b.vertices, kind=1, aspect=b.aspect, morph=b.morph, variants=b.variants)
         for b in BASES]
for name, (texture, images) in EARLIER.items():
    add("umbrella_base_of_" + name, "The bases show an earlier texture of kind %s." % name,
        scene(counts=(8, 2), seed=141, bases=SHOWN, before=[texture], images=images))
    add("umbrella_background_of_" + name, "The background is an earlier texture of kind %s." % name,
        scene((3, 4), REPEATED, counts=(4, 1), seed=142, background_kind=2, background_source=0,
              bases=[PLAIN], before=[texture], images=images))
add("umbrella_base_of_frames", "The bases show an earlier texture of three frames.",
    scene(counts=(8, 2), seed=143, bases=SHOWN, before=[Texture("earlier", [(1, 0)])],
          images=[Image(RGBA8, 5, 4, layers=3, layer_kind=2, seed=3)]))
add("umbrella_base_of_two_layers", "The bases show an earlier texture of two layers.",
    scene(counts=(8, 2), seed=144, bases=SHOWN, before=[Texture("earlier", [(1, 0), (8, 1)])],
          images=[leaf_image(), Image(R8, 8, 8)]))
add("umbrella_base_in_base_in_base", "Umbrellas show umbrellas that show umbrellas.",
    scene((2, 2), counts=(3, 1), seed=145, bases=[Base(1, b.centre, b.vertices, kind=1) for b in BASES],
          before=[textured(arrangement((2, 3), CLAMPED, (4,), seed=146), "first"),
                  textured(arrangement((3, 2), REPEATED, (4,), SHOWN, seed=147), "second")]))
add("umbrella_sources_mixed", "A base shows an image, one a texture; the background is that texture.",
    scene(counts=(8,), seed=148, bases=[LEAF, SHOWN[1], PLAIN], background_kind=2, background_source=0,
          before=[Texture("earlier", [(1, 1)])], images=[leaf_image(), leaf_image(6, 6, 57, 1)]))


def shown(wrap: tuple, patches: list, images: list, between: list = None, **more) -> File:
    """A zipmap whose patches show umbrellas, texture 0."""
    return File([Image(RGBA8, 4, 4, seed=40), leaf_image()] + images,
                [textured(arrangement((5, 4), wrap, (10, 3), [
                    Base(1, b.centre, b.vertices, aspect=b.aspect, variants=b.variants) for b in BASES],
                    seed=150, **{"background": (0.0, 0.0, 0.0, 0.0), **more}))]
                + (between or []) + [Texture("zip", [(1, NONE)], wrap=CLAMPED,
                                             zipmap=Zipmap([Patch([0])] + patches))])


for k, mode in enumerate(WRAP_NAMES):
    add("umbrella_in_zipmap_" + mode, "A patch shows umbrellas, %s; the lookup clamps, the lists are the "
        "texture's own." % mode,
        shown((k, k, 0), [Patch([0], place(0.25, 0.25, 0.5), source_kind=1)], []))
add("umbrella_in_zipmap_mask", "A patch shows umbrellas through a mask, by a homography.",
    shown(REPEATED, [Patch([0], (2.5, 0.125, -0.5, -0.25, 3.0, -0.75, 0.25, -0.125, 1.0),
                           source_kind=1, mask=2)], [mask(8, 8, 2)]))
add("umbrella_in_zipmap_background", "A patch shows umbrellas that repeat, over an image of 2 x 2 texels.",
    shown(REPEATED, [Patch([0], place(0.125, 0.25, 0.75), source_kind=1)], [leaf_image(2, 2, 58, 1)],
          background_kind=1, background_source=2))
add("umbrella_in_umbrellas_background", "Bases show umbrellas that repeat, over an image of 2 x 2 texels.",
    level_0([Umbrella(**middle(2, 2), a=4 * ONE)], bases=[Base(0, MIDDLE, WHOLE, kind=1)], before=[textured(
        arrangement((3, 3), REPEATED, (2,), [PLAIN], seed=151, background_kind=1, background_source=1),
        "earlier")], images=[leaf_image(), leaf_image(2, 2, 59, 1)]))
add("umbrella_in_zipmap_in_zipmap", "A patch shows a zipmap whose patch shows umbrellas.",
    shown(CLAMPED, [Patch([1], place(0.25, 0.25, 0.5), source_kind=1)], [], [
        Texture("inner", [(1, NONE)], zipmap=Zipmap(
            [Patch([0]), Patch([0], place(0.125, 0.125, 0.75), source_kind=1)]))]))

# ---- planes --------------------------------------------------------------------------------------

REGULAR = [Umbrella(ONE * k // 4, ONE * k // 4, a=60000) for k in range(32)]


def coded(**planes) -> File:
    """8 x 8 cells, 32 umbrellas in a row, planes as given; "" as `default`."""
    planes[""] = planes.pop("default", Plane())
    upper = [coloured(ONE * 2, ONE * 2, [(900, 0), (0, 900), (-900, 0), (0, -900)], [(9, 9, 9)] * 5)]
    return in_file(Umbrellas((8, 8), [REGULAR, upper * 12], [TURNING] * 9, level_bits=[8, 8],
                             planes=planes))


for predictor in range(3):
    for packing in range(2):
        for codec in range(2):
            add("umbrella_planes_p%d_k%d_c%d" % (predictor, packing, codec),
                "Planes with predictor %d, packing %d, codec %d." % (predictor, packing, codec),
                coded(default=Plane(predictor, packing, codec)))
add("umbrella_planes_bits", "All planes with packing 2, those of no elements too.",
    scene(planes=WIDE, seed=160))
add("umbrella_planes_mixed", "Planes with codings of their own.",
    coded(form=Plane(packing=2), x=Plane(1, 1, 1), y=Plane(2, 1, 1), list_size=Plane(1, 0, 1),
          entry=Plane(2, 0, 0), shift=Plane(0, 0, 1), b=Plane(packing=2, bit_width=0, base=1 << 31),
          explicit_x=Plane(packing=2, bit_width=32, base=0)))
add("umbrella_planes_empty_base", "Planes of no elements with packing 2, a base and a width.",
    scene(counts=(0,), bases=[], planes={"x": Plane(packing=2, bit_width=5, base=77),
                                         "entry": Plane(packing=2, bit_width=32, base=0),
                                         "form": Plane(packing=2, bit_width=0, base=255),
                                         "shift": Plane(2, 1, 0)}))
add("umbrella_planes_zstd_fcs_8", "A plane in a frame whose content size takes eight bytes.",
    coded(list_size=Plane(codec=1, fcs_bytes=8)))

# ---- beside other things -------------------------------------------------------------------------

add("umbrella_several", "Umbrellas, image, umbrellas, zipmap, silmap, umbrellas: the n-th umbrellas own "
    "the n-th UMBR chunk.",
    File([root(), decal(), sample_image(5, 4, CLAMPED), leaf_image()],
         [textured(arrangement(bases=[Base(3, LEAF.centre, LEAF.vertices)], seed=170), "a"),
          Texture("b", [(1, 0)]),
          textured(arrangement((3, 2), REPEATED, (4, 1), [Base(1, LEAF.centre, LEAF.vertices, kind=1)],
                               seed=171), "c"),
          Texture("d", [(1, NONE)], zipmap=ROOT_AND_PATCH), silmap_texture("e", 5, 4, CLAMPED, [2]),
          textured(arrangement((1, 1), (BORDER, MIRROR, 0), (2,), [
              Base(4, LEAF.centre, LEAF.vertices, kind=1)], seed=172), "f", 0x8000)]))
add("umbrella_meta_unknown_chunk", "Umbrellas with metadata and an unknown chunk.",
    scene(counts=(2,), meta=META, extra=[Chunk("XFOO", b"foo", flags=2)]))
add("umbrella_unknown_chunk_before_type", "Unknown chunks whose types lie before and behind UMBR in byte "
    "order.", scene(counts=(2,), extra=[Chunk(t, b"1", flags=2) for t in ("AAAA", "UMBQ", "UMBS")]))
