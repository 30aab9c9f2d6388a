# SPDX-License-Identifier: Apache-2.0
"""The invalid files about umbrellas (see invalid.py)."""

from dataclasses import replace

from invalid import MAX32, bad, bad_values
from silmake import BORDER, CLAMP, MIRROR, REPEAT
from umbmake import CONCAVE, CONVEX, OF_BASE, ONE, Base, Umbrella, Umbrellas, at, coloured, explicit
from valid import decal, place, root
from valid_silmaps import CLAMPED, REPEATED, sample_image
from valid_silmaps import texture as silmap_texture
from valid_umbrellas import (FAR, LEAF, MIDDLE, PLAIN, SHOWN, SQUARE, STONE, TURNING, WIDE, arrangement,
                             in_file, leaf_image, placed, ring, scene, textured, tints)
from ztexmake import (NONE, R8, RGBA8, Chunk, File, Image, Patch, Plane, Texture, Zipmap, blocks, flip,
                      flip_at, frame, frame_header, plus, raw_block)

# ---- the files that are edited -------------------------------------------------------------------

# Umbrellas 0 to 4 are level 0, 5 and 6 level 1.
LOW = [Umbrella(70000, 60000, 0, a=60000, b=20000, variants=(0, 1), weight=77, strength=200),
       Umbrella(130000, 90000, 1, a=50000, b=-30000, mirrored=True, morph=100, ellipsoid=OF_BASE, lift=900),
       explicit(90000, 120000, 0, ring(6, 700, 2), tints(7, 3, -80, 80), strength=100),
       coloured(30000, 30000, ring(4, 600, 4), tints(5, 5), ellipsoid=CONVEX, height=20000,
                curvature=30000, lift=800),
       Umbrella(200000, 100000, 2, a=0, b=70000, ellipsoid=CONCAVE, height=9000, curvature=50000)]
HIGH = [coloured(60000, 30000, ring(5, 800, 6), tints(6, 7)),
        coloured(100000, 40000, ring(3, 700, 8), tints(4, 9))]
WRAP = (REPEAT, CLAMP, CLAMP)


def both(low: list = None, high: list = None, wrap: tuple = WRAP, bases: list = None, **more) -> File:
    own = {k: more.pop(k) for k in ("images", "before", "meta", "extra", "codec") if k in more}
    return in_file(Umbrellas((4, 3), [LOW if low is None else low, HIGH if high is None else high],
                             [LEAF, STONE, PLAIN] if bases is None else bases, wrap,
                             planes=more.pop("planes", WIDE), **more),
                   own.pop("images", [leaf_image(4, 4, 50, 1)]), **own)


UMBR = both()
COUNTS = UMBR.umbrellas()[0]
PLANE_NAMES = [name for name, _, _ in COUNTS.arrays()]
LATER = "R8305 R8306 R8307 R8308 R8310 R8311 R8312 R8313 R8314"   # what shifted elements may break
BESIDE = File([root(), decal(), sample_image(5, 4, CLAMPED), leaf_image(4, 4, 50, 1)], [
    Texture("zip", [(1, NONE)], zipmap=Zipmap([Patch([0]), Patch([1], place(0.25, 0.5, 0.25))])),
    silmap_texture("silmap", 5, 4, CLAMPED, [2]),
    textured(arrangement(counts=(2,), bases=[Base(3, LEAF.centre, LEAF.vertices)], planes=WIDE))],
    meta=[("k", "v")], extra=[Chunk("AAAA", b"1", flags=2), Chunk("XFOO", b"2", flags=2)])
# Positions in BESIDE: 0 TEXS, 1 IMAG, 2 ZPMP, 3 SLMP, 4 UMBR, 5 META, 6 AAAA, 7 XFOO, 8 TEXL.

# ---- directory, heads ----------------------------------------------------------------------------

for flags in (0, 2, 3):
    bad("R3005", "umbr_flags_%d" % flags, "UMBR has flags %d." % flags, {"entry.UMBR.flags": flags},
        UMBR)
bad("R3005", "umbr_reserved_bit_2", "UMBR has flags 5.", {"entry.UMBR.flags": 5}, UMBR)
bad("R3006", "umbr_zstd", "UMBR has codec 1, and is a right frame.", {}, both(codec={"UMBR": 1}))
bad("R3006", "umbr_codec_2", "UMBR has codec 2.", {"entry.UMBR.codec": 2}, UMBR, also="R3007")
for value in (0, 2, 65535):
    bad("R3008", "umbr_version_%d" % value, "UMBR has version %d." % value,
        {"entry.UMBR.version": value}, UMBR)


def moved(*positions) -> dict:
    return {"chunks": lambda cs: [cs[p] for p in positions]}


for name, what, positions in (
        ("umbr_before_slmp", "UMBR comes before SLMP.", (0, 1, 2, 4, 3, 5, 6, 7, 8)),
        ("umbr_before_zpmp", "UMBR comes before ZPMP.", (0, 1, 4, 2, 3, 5, 6, 7, 8)),
        ("umbr_before_imag", "UMBR comes before IMAG.", (0, 4, 1, 2, 3, 5, 6, 7, 8)),
        ("umbr_first", "UMBR is the first chunk.", (4, 0, 1, 2, 3, 5, 6, 7, 8)),
        ("umbr_behind_meta", "UMBR comes behind META.", (0, 1, 2, 3, 5, 4, 6, 7, 8)),
        ("umbr_in_byte_order", "UMBR stands among unknown types in byte order.",
         (0, 1, 2, 3, 5, 6, 4, 7, 8)),
        ("umbr_last", "UMBR comes behind TEXL.", (0, 1, 2, 3, 5, 6, 7, 8, 4))):
    bad("R3009", name, what, moved(*positions), BESIDE)
TWO = File([leaf_image(4, 4, 50, 1), sample_image(5, 4, CLAMPED)], [
    textured(arrangement(counts=(2,), bases=[LEAF], planes=WIDE), "a"),
    textured(arrangement(counts=(1,), bases=[LEAF], planes=WIDE), "b"),
    silmap_texture("c", 5, 4, CLAMPED, [1]), silmap_texture("d", 5, 4, CLAMPED, [1])])
# Positions in TWO: 0 TEXS, 1 IMAG, 2 and 3 SLMP, 4 and 5 UMBR, 6 TEXL.
bad("R3009", "umbr_between_slmp", "A UMBR chunk stands between two SLMP chunks.",
    moved(0, 1, 2, 4, 3, 5, 6), TWO)
bad("R3011", "imag_twice_with_umbr", "IMAG is there twice, in a file where UMBR rightly is.",
    moved(0, 1, 1, 2, 3, 4, 5, 6), TWO, also="R4001")
bad("R3011", "unknown_twice_umbs", "A type that the reader does not know, UMBS, is there twice.",
    base=both(extra=[Chunk("UMBS", b"1", flags=2), Chunk("UMBS", b"2", flags=2)]))
bad("R4001", "umbr_magic", "The head of UMBR has a wrong magic.", {"head.UMBR.head_magic": flip_at(0)},
    UMBR)
bad("R4002", "umbr_hash", "The head of UMBR repeats another stored_hash.",
    {"head.UMBR.entry": flip_at(39)}, UMBR)
bad("R4003", "umbr_hash", "The hashes of UMBR are wrong.",
    {"entry.UMBR.stored_hash": flip(40), "entry.UMBR.decoded_hash": flip(40)}, UMBR, also="R4004")
bad("R4005", "umbr_last", "The last byte of padding behind UMBR is not zero.",
    {"padding.UMBR": flip_at(-1, 128)}, UMBR)

# ---- textures ------------------------------------------------------------------------------------

bad("R6106", "umbrellas_with_image", "The layer of umbrellas names an image.", {"layer.0.0.image": 0},
    UMBR)
bad("R6106", "umbrellas_fffffffe", "The layer of umbrellas has 0xFFFFFFFE.",
    {"layer.0.0.image": NONE - 1}, UMBR)
bad("R6110", "no_umbr", "Umbrellas without their chunk.",
    {"chunks": lambda cs: [c for c in cs if c.type != "UMBR"]}, UMBR)
bad("R6110", "umbr_more", "Two UMBR chunks for one texture of umbrellas.",
    {"chunks": lambda cs: cs[:3] + [Chunk(**vars(cs[2]))] + cs[3:]}, UMBR)
bad("R6110", "umbr_less", "One UMBR chunk for two textures of umbrellas.", moved(0, 1, 2, 3, 4, 6), TWO)
bad("R6110", "umbr_without_umbrellas", "A UMBR chunk in a file without umbrellas.",
    {"texture.0.kind": 0, "layer.0.0.image": 0}, UMBR)
bad("R6110", "umbrellas_are_silmap", "A texture of kind silmap and a UMBR chunk.",
    {"texture.0.kind": 2}, UMBR)
bad("R6110", "silmap_is_umbrellas", "Two textures of umbrellas, an SLMP chunk and a UMBR chunk.",
    {"texture.1.kind": 3}, BESIDE)

# ---- planes --------------------------------------------------------------------------------------

for name in PLANE_NAMES:
    bad("R5102", "umbr_%s_count" % name, "count of the plane %s is one more." % name,
        {"umbr.0.%s.count" % name: plus(1)}, UMBR, also="R5103")
for name, size in (("base_kind", 2), ("base_source", 8), ("vertex_x", 1), ("form", 4), ("x", 2),
                   ("explicit_x", 2), ("explicit_r", 2), ("shift", 0)):
    bad("R5102", "umbr_%s_element_size" % name, "element_size of the plane %s is %d." % (name, size),
        {"umbr.0.%s.element_size" % name: size}, UMBR, also="R5101 R5103")
for name, count in (("base", "base_count"), ("umbrella", "umbrella_count"),
                    ("base_vertex", "base_vertex_count"), ("morph_vertex", "morph_vertex_count"),
                    ("variant_colour", "variant_colour_count"),
                    ("explicit_vertex", "explicit_vertex_count"), ("entry", "entry_count")):
    for suffix, value in (("plus_1", plus(1)), ("minus_1", plus(-1)), ("0", 0)):
        bad("R5102", "umbr_header_%s_%s" % (count, suffix), "%s of the header is not what the planes "
            "have: %s." % (count, suffix.replace("_", " ")), {"umbr.0." + count: value}, UMBR,
            also="R8304")
for count in ("base_vertex_count", "morph_vertex_count", "variant_colour_count",
              "explicit_vertex_count", "entry_count"):
    bad("R5102", "umbr_header_%s_2_20" % count, "%s of the header is 2^20." % count,
        {"umbr.0." + count: 1 << 20}, UMBR, also="R5103 R8304")
bad("R5102", "umbr_one_level_less", "level_count of the header is 1, the planes have 2 levels.",
    {"umbr.0.level_count": 1}, UMBR)
bad("R5102", "umbr_grid_larger", "grid_x of the header is 5, the lists have 4 x 3 and 2 x 1 cells.",
    {"umbr.0.grid_x": 5}, UMBR)
bad("R5102", "umbr_cells_of_level_0", "The plane list_size has no cells of level 1.",
    {"umbr.0.list_size.values": lambda v: v[:12]}, UMBR)
bad_values("R5101", "umbr_packing", "Packing of the plane entry", "umbr.0.entry.packing",
           [("3", 3), ("255", 255)], UMBR)
bad_values("R5101", "umbr_predictor", "Predictor of the plane form", "umbr.0.form.predictor",
           [("1", 1), ("3", 3)], UMBR)
bad("R5101", "umbr_reserved", "A reserved byte of the header of the plane shift is not zero.",
    {"umbr.0.shift.reserved": 1 << 23}, UMBR)
bad("R5101", "umbr_signed_base", "base of a plane of i32 is negative, as a u64.",
    {"umbr.0.x.base": (1 << 64) - 1}, UMBR)
bad("R5101", "umbr_empty_base", "A plane of no elements, whose base does not fit.",
    {"umbr.0.form.base": 256}, scene(counts=(0,), bases=[], planes=WIDE))
EMPTY = scene(counts=(0,), bases=[], planes={"entry": Plane(), "": Plane(packing=2)})
bad("R5103", "umbr_empty_stored", "A plane of no elements stores a byte.",
    {"umbr.0.entry.stored": b"\0"}, EMPTY)
bad("R5103", "umbr_empty_zstd", "A plane of no elements has codec 1: no size is less than 0.",
    {"umbr.0.entry.codec": 1, "umbr.0.entry.stored": frame(b"")}, EMPTY, also="R5002")
bad("R5103", "umbr_stored_size_max", "stored_size of the last plane is 2^32 - 1.",
    {"umbr.0.shift.stored_size": MAX32}, UMBR)
for name, size, what in (
        ("header", 104, "behind its header"), ("first_plane_header", 104 + 31, "in the first plane's "
         "header"), ("middle", 800, "in the middle"), ("last_plane", -40, "before its last plane"),
        ("last_byte", -1, "before its last byte")):
    bad("R5103", "umbr_cut_" + name, "The chunk ends %s." % what,
        {"decoded.UMBR": lambda b, size=size: b[:size]}, UMBR)
for name in ("level_umbrellas", "base_aspect", "variant_b", "form", "curvature", "explicit_y", "entry",
             "shift"):
    bad("R5105", "umbr_" + name, "The hash of the plane %s is wrong." % name,
        {"umbr.0.%s.hash" % name: flip(11)}, UMBR)
bad("R5105", "umbr_empty", "The hash of a plane of no elements is wrong.",
    {"umbr.0.explicit_x.hash": 0}, EMPTY)
bad("R5106", "umbr_one_byte", "A byte follows the last plane.",
    {"decoded.UMBR": lambda b: b + b"\0"}, UMBR)
bad("R5106", "umbr_one_plane", "A 45th plane of no elements follows.",
    {"decoded.UMBR": lambda b: b + b[-32:]}, EMPTY)
RUNS = both(planes={"": Plane(packing=2), "base_source": Plane(), "y": Plane(1, 1, 0)}, bases=[PLAIN] * 20,
            low=[], high=[])
SOURCES = bytes(80)
for rule, name, what, stored, also in (
        ("R5002", "umbr_plus_1", "The frame of a plane has another content size.",
         frame_header(81) + blocks(SOURCES + b"\0"), ""),
        ("R5003", "umbr_trailing", "A byte follows the frame of a plane.", frame(SOURCES) + b"\0", ""),
        ("R5103", "umbr_zstd_larger", "The frame of a plane is larger than the plane.",
         frame_header(80) + raw_block(SOURCES, True), "")):
    bad(rule, name, what, {"umbr.0.base_source.codec": 1, "umbr.0.base_source.stored": stored}, RUNS,
        also)

# ---- R8301 to R8303: the header ------------------------------------------------------------------

for size in (1, 24, 103):
    bad("R8301", "%d_bytes" % size, "The chunk has %d bytes, less than its header." % size,
        {"decoded.UMBR": lambda b, size=size: b[:size]}, UMBR)
for name, bits in (("reserved46", (0, 8, 15)), ("reserved100", (0, 31))):
    for bit in bits:
        bad("R8301", "%s_bit_%d" % (name, bit), "Bit %d of reserved bytes is set." % bit,
            {"umbr.0." + name: 1 << bit}, UMBR)
bad_values("R8301", "layer_count", "layer_count is not the texture's", "umbr.0.layer_count",
           [("0", 0), ("2", 2), ("max", MAX32)], UMBR)
TWO_LAYERS = File([leaf_image(4, 4, 50, 1)], [Texture("umbrellas", [(1, NONE), (8, NONE)], wrap=WRAP,
                                                      umbrellas=COUNTS)])
bad("R8301", "two_layers", "The texture has two layers, layer_count is 1.", {}, TWO_LAYERS)
bad("R8301", "two_layers_both", "The texture has two layers, and so has layer_count.",
    {"umbr.0.layer_count": 2}, TWO_LAYERS)
for name in ("grid_x", "grid_y"):
    bad_values("R8301", name, name + " is out of range", "umbr.0." + name,
               [("0", 0), ("8193", 8193), ("max", MAX32), ("2_16", 1 << 16)], UMBR, also="R5102")
bad("R8301", "grid_8193", "8193 x 1 cells; the planes are right.", {},
    in_file(Umbrellas((8193, 1), [[]], [], planes=WIDE)))
bad_values("R8301", "level_count", "level_count is out of range", "umbr.0.level_count",
           [("0", 0), ("4", 4), ("32", 32), ("33", 33), ("max", MAX32)], UMBR, also="R5102")
for grid, n in (((1, 1), 2), ((4, 3), 4), ((7, 7), 4), ((8, 1), 5)):
    bad("R8301", "levels_%d_of_%dx%d" % ((n,) + grid), "%d levels of %d x %d cells, one more than there "
        "can be; the planes are right." % ((n,) + grid), {},
        in_file(Umbrellas(grid, [[]] * n, [], planes=WIDE)))
bad("R8301", "no_levels", "No levels; the planes have none.",
    {"umbr.0.level_count": 0, "umbr.0.level_umbrellas.values": [], "umbr.0.level_bits.values": [],
     "umbr.0.list_size.values": []}, scene((1, 1), counts=(0,), bases=[], planes=WIDE), also="R8304")
bad_values("R8301", "base_count", "base_count is out of range", "umbr.0.base_count",
           [("65537", 65537), ("max", MAX32)], UMBR, also="R5102 R8304")
bad_values("R8301", "umbrella_count", "umbrella_count is out of range", "umbr.0.umbrella_count",
           [("2_24_plus_1", (1 << 24) + 1), ("max", MAX32)], UMBR, also="R5102 R8304")
bad_values("R8302", "colour_mode", "colour_mode", "umbr.0.colour_mode",
           [("2", 2), ("128", 128), ("255", 255)], UMBR)
bad_values("R8302", "background_kind", "background_kind", "umbr.0.background_kind",
           [("3", 3), ("255", 255)], UMBR, also="R8305")
FLOATS = ["%s_%s" % (name, c) for name in ("background", "mean")
          for c in ("red", "green", "blue", "alpha")] + ["prism_height", "taper_start", "taper_end"]
NOT_ALLOWED = (("nan", 0x7FC00000), ("signalling_nan", 0x7F800001), ("infinite", 0x7F800000),
               ("minus_infinite", 0xFF800000), ("negative", 0xBD000000), ("minus_zero", 0x80000000),
               ("negative_denormal", 0x80000001))
for k, name in enumerate(FLOATS):
    for n, (suffix, bits) in enumerate(NOT_ALLOWED):
        if (n + k) % 3 == 0 or name == "prism_height":
            bad("R8303", "%s_%s" % (name, suffix), "%s is %s." % (name, suffix.replace("_", " ")),
                {"umbr.0." + name: bits}, UMBR)
for name, edits, what in (
        ("taper_equal", {"taper_start": 0x3D000000, "taper_end": 0x3D000000}, "both are 1/32"),
        ("taper_both_0", {"taper_start": 0, "taper_end": 0}, "both are 0"),
        ("taper_swapped", {"taper_start": 0x3E000000, "taper_end": 0x3D000000}, "start is above end"),
        ("taper_start_one_bit_more", {"taper_start": 0x3D000001, "taper_end": 0x3D000000},
         "start is above end by one bit"),
        ("taper_end_one_bit_more", {"taper_end": 0x3E000001}, "end is above 1/8 by one bit"),
        ("taper_end_1", {"taper_end": 0x3F800000}, "end is 1"),
        ("taper_both_above", {"taper_start": 0x3E800000, "taper_end": 0x3F000000}, "1/4 to 1/2")):
    bad("R8303", name, "taper_start and taper_end: %s." % what,
        {"umbr.0." + k: v for k, v in edits.items()}, UMBR)

# ---- R8304: sums ---------------------------------------------------------------------------------


def edited(rule: str, name: str, what: str, plane: str, index: int, value, base: File = UMBR,
           also: str = ""):
    """A file with one element of a plane changed."""
    bad(rule, name, what, {"umbr.0.%s.values" % plane: at(index, value)}, base, also)


for name, plane, index, value, also in (
        ("level_umbrellas_more", "level_umbrellas", 1, 3, LATER),
        ("level_umbrellas_less", "level_umbrellas", 0, 4, "R8309 R8315"),
        ("level_umbrellas_max", "level_umbrellas", 1, MAX32, LATER),
        ("base_vertices_more", "base_vertices", 2, 10, LATER),
        ("base_vertices_less", "base_vertices", 0, 5, LATER),
        ("morph_less", "base_morph", 1, 0, "R8310"), ("morph_more", "base_morph", 2, 1, "R8308"),
        ("variants_more", "base_variants", 2, 1, ""), ("variants_less", "base_variants", 0, 1, "R8310"),
        ("explicit_vertices_more", "vertices", 3, 5, LATER),
        ("explicit_vertices_less", "vertices", 6, 2, LATER),
        ("list_size_more", "list_size", 5, plus(1), "R8315"),
        ("list_size_less", "list_size", 5, plus(-1), "R8315")):
    edited("R8304", name, "The plane %s sums to another count than that of the header." % plane, plane,
           index, value, also=also)
bad("R8304", "level_umbrellas_wrap", "level_umbrellas sums to umbrella_count modulo 2^32.",
    {"umbr.0.level_umbrellas.values": [5 + (1 << 31), 2 + (1 << 31)]}, UMBR)
bad("R8304", "list_size_wraps", "list_size sums to entry_count modulo 2^32.",
    {"umbr.0.list_size.values": lambda v: [v[0] + (1 << 31), v[1] + (1 << 31)] + v[2:]}, UMBR)
bad_values("R8304", "longest_list", "longest_list is not the largest list_size", "umbr.0.longest_list",
           [("plus_1", plus(1)), ("minus_1", plus(-1)), ("0", 0), ("max", MAX32)], UMBR)
for index, value in ((0, 17), (1, 17), (0, 32), (1, 255)):
    edited("R8304", "level_bits_%d_%d" % (index, value), "level_bits of level %d is %d." % (index, value),
           "level_bits", index, value)

# ---- R8305: sources ------------------------------------------------------------------------------


def shows(**more) -> Base:
    return replace(PLAIN, **more)


for value in (2, 3, 255):
    edited("R8305", "base_kind_%d" % value, "base_kind %d." % value, "base_kind", 1, value)
for name, value in (("count", 1), ("2_31", 1 << 31), ("max", MAX32)):
    edited("R8305", "base_image_" + name, "A base's image does not exist: %d." % value, "base_source", 0,
           value)
bad("R8305", "base_unused", "The image of a base that nothing uses does not exist.",
    base=both([], [], bases=[PLAIN, shows(source=7)]))
BAD_IMAGES = (("depth_2", Image(RGBA8, 4, 4, depth=2)), ("layers_2", Image(RGBA8, 4, 4, layers=2)),
              ("frames_3", Image(RGBA8, 4, 4, layers=3, layer_kind=2)),
              ("cube", Image(RGBA8, 4, 4, layers=6, layer_kind=1)),
              ("volume", Image(R8, 4, 4, depth=16384)))
for name, image in BAD_IMAGES[:4]:
    bad("R8305", "base_" + name, "The image of a base is one of: %s." % name.replace("_", " "),
        base=both(bases=[LEAF, STONE, shows(source=1)], images=[leaf_image(4, 4, 50, 1), image]))
    bad("R8305", "background_" + name, "The image of the background is one of: %s."
        % name.replace("_", " "), base=both(background_kind=1, background_source=1,
                                            images=[leaf_image(4, 4, 50, 1), image]))
EARLIER = [Texture("earlier", [(1, 0)])]
LATER_TEXTURE = File([leaf_image(4, 4, 50, 1)], [
    textured(arrangement(counts=(1,), bases=[SHOWN[2]], planes=WIDE)), Texture("later", [(1, 0)])])
bad("R8305", "base_texture_later", "The texture of a base comes later.",
    {"umbr.0.base_source.values": [1]}, LATER_TEXTURE)
bad("R8305", "base_texture_self", "The texture of a base is its own.", {}, LATER_TEXTURE)
for name, value in (("self", 1), ("none", 2), ("max", MAX32)):
    bad("R8305", "base_texture_second_" + name, "The texture of a base is %d, its own is 1." % value,
        base=both(bases=[LEAF, STONE, shows(kind=1, source=value)], before=EARLIER))
bad("R8305", "base_texture_in_a_circle", "Two textures of umbrellas show each other.",
    base=File([leaf_image(4, 4, 50, 1)], [
        textured(arrangement(counts=(1,), bases=[shows(kind=1, source=k)], planes=WIDE), "t%d" % k)
        for k in (1, 0)]))
for name, kind, source in (("colour_with_image", 0, 0), ("colour_fffffffe", 0, NONE - 1),
                           ("image_count", 1, 1), ("image_none", 1, NONE), ("texture_self", 2, 1),
                           ("texture_later", 2, 2), ("texture_none", 2, NONE)):
    bad("R8305", "background_" + name, "background_kind is %d, background_source is %d; the file has one "
        "image, the texture is number 1." % (kind, source),
        base=both(background_kind=kind, background_source=source, before=EARLIER))

# ---- R8306 to R8308: bases -----------------------------------------------------------------------

for name, value in (("0", 0), ("2_24_plus_1", (1 << 24) + 1), ("max", MAX32)):
    edited("R8306", "aspect_" + name, "base_aspect is %d." % value, "base_aspect", 1, value)
for n in (0, 1, 2):
    bad("R8306", "vertices_%d" % n, "A base of %d vertices." % n, {},
        both([], [], bases=[PLAIN, replace(PLAIN, vertices=PLAIN.vertices[:n])]), also="R8307")
for n in (4097, 8192):
    bad("R8306", "vertices_%d" % n, "A base of %d vertices, around its centre." % n, {},
        both([], [], bases=[Base(0, MIDDLE, placed(MIDDLE, ring(n, 32000)))]))
for value in (2, 255):
    edited("R8306", "morph_%d" % value, "base_morph is %d." % value, "base_morph", 1, value,
           also="R8304")
for value in (3, 4, 255):
    edited("R8306", "ellipsoid_%d" % value, "base_ellipsoid is %d." % value, "base_ellipsoid", 1, value)
for plane in ("base_height", "base_curvature"):
    for value in (1, 65535):
        edited("R8306", "flat_%s_%d" % (plane[5:], value), "A flat base has a %s of %d."
               % (plane[5:], value), plane, 0, value)
edited("R8306", "flat_made", "A base became flat and kept its height and curvature.", "base_ellipsoid", 1,
       0)


def not_a_star(rule: str, prefix: str, what: str, base_of):
    """Contours that are not star-shaped; `base_of` makes a file of vertices less centre."""
    pentagon = [(300, 0), (93, 285), (-243, 176), (-243, -176), (93, -285)]
    square = [(300, 0), (0, 300), (-300, 0), (0, -300)]
    for name, why, points in (
            ("anticlockwise", "It goes round the other way.", pentagon[::-1]),
            ("swapped", "Two vertices are swapped: some sectors are negative.",
             [square[k] for k in (0, 2, 1, 3)]),
            ("one_negative", "One vertex goes back: one sector is negative.",
             [(300, 0), (200, 200), (290, 100), (-300, 200), (-200, -300)]),
            ("vertex_twice", "A vertex is there twice: a sector has no area.", square[:2] + square[1:]),
            ("on_one_ray", "Two vertices lie on one ray: a sector has no area.",
             [(300, 0), (0, 300), (0, 200), (-300, 0), (0, -300)]),
            ("half_turn", "The centre lies on an edge.", [(300, 0), (-300, 0), (0, -300)]),
            ("last_half_turn", "The centre lies on the last edge.", [(300, 0), (0, 300), (-300, 0)]),
            ("centre_outside", "The centre lies outside.", [(100, 0), (300, 0), (300, 200), (100, 200)]),
            ("centre_is_vertex", "The centre is a vertex.", [(0, 0), (300, 0), (0, 300)]),
            ("two_turns", "Each sector is positive, but the contour goes around twice.",
             [pentagon[2 * k % 5] for k in range(5)]),
            ("two_turns_same", "The contour goes around twice the same way.", square * 2),
            ("three_turns", "The contour goes around three times.",
             [(300, 0), (0, 300), (-300, 0), (0, -300)] * 3),
            ("two_turns_of_7", "A heptagram: two turns in seven steps.",
             [[(300, 0), (187, 235), (-67, 292), (-270, 130), (-270, -130), (-67, -292), (187, -235)]
              [2 * k % 7] for k in range(7)])):
        bad(rule, prefix + name, "%s %s" % (what, why), base=base_of(points))


not_a_star("R8307", "", "A base is not star-shaped.",
           lambda points: both([], [], bases=[PLAIN, Base(0, MIDDLE, placed(MIDDLE, points))]))
not_a_star("R8312", "coloured_", "An umbrella of form 2 is not star-shaped.",
           lambda points: both(low=LOW[:3] + [coloured(9, 9, points, tints(1 + len(points), 1))] + LOW[4:]))
edited("R8307", "moved_centre", "A centre was moved out of its contour.", "base_x", 2, 65535)
edited("R8307", "moved_vertex", "A vertex was moved to the other side.", "vertex_x", 2, 65535)


def around(points: list) -> list:
    return placed(MIDDLE, points)


def morphing(second: list, first: list = SQUARE) -> File:
    return both([], [], bases=[PLAIN, Base(0, MIDDLE, around(first), morph=around(second))])


PENTAGON = [(30000, 0), (9300, 28500), (-24300, 17600), (-24300, -17600), (9300, -28500)]
for name, why, first, second in (
        ("anticlockwise", "goes round the other way.", SQUARE, SQUARE[::-1]),
        ("swapped", "has two vertices swapped.", SQUARE, [SQUARE[k] for k in (0, 2, 1, 3)]),
        ("vertex_twice", "has a vertex twice.", SQUARE, SQUARE[:2] + [SQUARE[1], SQUARE[3]]),
        ("two_turns", "goes around twice.", PENTAGON, [PENTAGON[2 * k % 5] for k in range(5)]),
        ("centre_outside", "does not have the centre inside.", SQUARE,
         [(30000, 10), (30000, 20000), (10, 20000), (10, 10)])):
    bad("R8308", "second_" + name, "The second contour %s" % why, base=morphing(second, first))
bad("R8308", "fold_half_turn", "Both contours are star-shaped, but the second is turned by half a turn: "
    "at one half all vertices meet in the centre.", base=morphing([(-x, -y) for x, y in SQUARE]))
bad("R8308", "fold_three_quarters", "The second contour is turned by three quarters.",
    base=morphing(SQUARE[3:] + SQUARE[:3], [(30000, 1), (-1, 30000), (-30000, -1), (1, -30000)]))
bad("R8308", "fold_just", "The second contour is turned by a little more than a quarter: the sum is "
    "negative.", base=morphing([(-1, 30000), (-30000, -1), (1, -30000), (30000, 1)]))
bad("R8308", "fold_by_1", "One vertex is one step too far: one sum is negative.",
    base=morphing([(0, 30000), (-30000, -1), (0, -30000), (30000, 0)]))
bad("R8308", "fold_second_base", "The second of two bases with a morph folds.",
    base=both([], [], bases=[STONE, TURNING, replace(TURNING, morph=around([(-x, -y)
                                                                            for x, y in SQUARE]))]))

# ---- R8309 to R8311: forms and their fields ------------------------------------------------------

for index, value in ((0, 3), (0, 7), (0, 8), (0, 12), (0, 128), (2, 5), (2, 17), (3, 6), (3, 255)):
    edited("R8309", "form_%d_for_%d" % (value, LOW[index].form), "form is %d." % value, "form", index,
           value, also="R5102 R8304 R8310 R8311")
bad("R8309", "level_1_form_0", "An umbrella of level 1 has form 0.", base=both(high=HIGH + [LOW[0]]))
bad("R8309", "level_1_form_0_mirrored", "The first umbrella of level 1 has form 0 and is mirrored.",
    base=both(high=[LOW[1]] + HIGH))
bad("R8309", "level_1_form_1", "An umbrella of level 1 has form 1.", base=both(high=HIGH + [LOW[2]]))
bad("R8309", "level_2_form_1", "An umbrella of level 2 has form 1.",
    base=in_file(Umbrellas((4, 4), [[], [], [replace(LOW[2], x=0, y=0)]], [LEAF], planes=WIDE)))
for index in (0, 2):
    for name, value in (("count", 3), ("max", 65535)):
        edited("R8310", "base_%s_form_%d" % (name, LOW[index].form), "base is %d, there are three."
               % value, "base", index, value)
for form, u in ((0, LOW[4]), (1, LOW[2])):
    bad("R8310", "no_bases_form_%d" % form, "An umbrella of form %d, and no bases." % form,
        base=in_file(Umbrellas((4, 3), [[u]], [], lists=[[[]] * 12], planes=WIDE),
                     [leaf_image(4, 4, 50, 1)]), also="R8311")
for plane in ("variant_0", "variant_1"):
    for index, value, why in ((0, 2, "it has two"), (0, 255, "it has two"), (1, 1, "it has one"),
                              (4, 1, "it has none"), (4, 255, "it has none")):
        edited("R8310", "%s_%d_of_%d" % (plane, value, index), "%s is %d, which the base does not have: "
               "%s." % (plane, value, why), plane, index, value)
bad("R8310", "no_scale", "a and b are both 0.", {"umbr.0.a.values": at(4, 0), "umbr.0.b.values": at(4, 0)},
    UMBR)
for index in (0, 4):
    for value in (1, 255):
        edited("R8310", "morph_%d_of_%d" % (value, index), "The base has no morph, morph is %d." % value,
               "morph", index, value)
for index, name, planes in ((2, "explicit", ()), (3, "coloured", ("base", "strength")),
                            (6, "coloured_level_1", ("base", "strength"))):
    for plane in ("a", "b", "morph", "variant_0", "variant_1", "variant_weight") + planes:
        edited("R8310", "%s_%s" % (name, plane), "Umbrella %d, of form %d, has a %s of 1."
               % (index, 1 if index == 2 else 2, plane), plane, index, 1)
for name, value in (("minus_1", -1), ("min", -(1 << 31))):
    edited("R8310", "explicit_a_" + name, "An umbrella of form 1 has an a of %d." % value, "a", 2, value,
           also="R8313")


def with_umbrella(index: int, u: Umbrella) -> File:
    return both(low=LOW[:index] + [u] + LOW[index + 1:])


for n in (3, 5, 7):
    bad("R8311", "explicit_%d_of_6" % n, "An umbrella of form 1 has %d vertices, its base 6." % n,
        base=with_umbrella(2, explicit(9, 9, 0, ring(n, 700), tints(n + 1, 1, -9, 9))))
bad("R8311", "explicit_of_other_base", "An umbrella of form 1 has the vertices of another base.",
    base=with_umbrella(2, explicit(9, 9, 1, ring(6, 700), tints(7, 1, -9, 9))))
for n in (0, 1, 2):
    bad("R8311", "coloured_%d" % n, "An umbrella of form 2 has %d vertices." % n,
        base=both(low=LOW[:3] + [coloured(9, 9, ring(6, 700)[:n], tints(n + 1, 1))],
                  lists=[[[]] * 12, [[]] * 2]), also="R8312")
bad("R8311", "coloured_4097", "An umbrella of form 2 has 4097 vertices, around its centre.",
    base=with_umbrella(3, coloured(9, 9, ring(4097, 1 << 17), [(9, 9, 9)] * 4098)))
for index, value in ((0, 6), (1, 1), (4, 65535)):
    edited("R8311", "parametric_%d" % value, "An umbrella of form 0 has vertices: %d." % value,
           "vertices", index, value, also="R8304")

# ---- R8312 to R8314: numbers ---------------------------------------------------------------------

for name, x, y in (("x_more", FAR + 1, 0), ("y_more", 0, FAR + 1), ("x_max", (1 << 31) - 1, 0),
                   ("y_min", 0, -(1 << 31)), ("x_less", -FAR - 1, 0), ("y_less", 0, -FAR - 1)):
    points = [(1000, 0), (0, 1000), (-1000, 0), (0, -1000)]
    k = 0 if x > 0 else 2 if x < 0 else 1 if y > 0 else 3
    points[k] = (x, y)
    bad("R8312", name, "A vertex at (%d, %d); the contour is star-shaped." % (x, y),
        base=both(low=LOW[:3] + [coloured(9, 9, points, tints(5, 1))], lists=[[[]] * 12, [[]] * 2]))
bad("R8312", "explicit_swapped", "An umbrella of form 1 is not star-shaped.",
    base=with_umbrella(2, explicit(9, 9, 0, [ring(6, 700)[k] for k in (1, 0, 2, 3, 4, 5)],
                                   tints(7, 1, -9, 9))))
bad("R8312", "explicit_two_turns", "An umbrella of form 1 goes around twice.",
    base=with_umbrella(2, explicit(9, 9, 0, [(700, 0), (-300, 600), (-300, -600)] * 2,
                                   tints(7, 1, -9, 9))))
bad("R8312", "level_1", "An umbrella of level 1 is not star-shaped.",
    base=both(high=HIGH + [coloured(9, 9, [(1, 0), (0, -1), (-1, 1)], tints(4, 1))]))
edited("R8312", "moved_vertex", "A vertex was moved to the other side.", "explicit_y", 0, 1 << 20)
for name, index, plane, value, what in (
        ("repeat_minus_1", 0, "x", -1, "repeat, x is -1"),
        ("repeat_width", 0, "x", 4 * ONE, "repeat, x is the width"),
        ("repeat_min", 4, "x", -(1 << 31), "repeat, x is -2^31"),
        ("repeat_max", 3, "x", (1 << 31) - 1, "repeat, x is 2^31 - 1"),
        ("repeat_level_1", 5, "x", 2 * ONE, "repeat, x is the width of level 1"),
        ("clamp_more", 0, "y", FAR + 1, "clamp, y is 2^30 + 1"),
        ("clamp_less", 2, "y", -FAR - 1, "clamp, y is -2^30 - 1"),
        ("clamp_min", 6, "y", -(1 << 31), "clamp, y is -2^31"),
        ("a_more", 0, "a", FAR + 1, "a is 2^30 + 1"), ("a_less", 1, "a", -FAR - 1, "a is -2^30 - 1"),
        ("b_more", 4, "b", FAR + 1, "b is 2^30 + 1"), ("b_min", 0, "b", -(1 << 31), "b is -2^31")):
    edited("R8313", name, "Out of range: %s." % what, plane, index, value)
for mode, name in ((MIRROR, "mirror"), (BORDER, "border")):
    edited("R8313", name + "_more", "%s in u, x is 2^30 + 1." % name.capitalize(), "x", 0, FAR + 1,
           scene(counts=(2, 1), wrap=(mode, REPEAT, 0), planes=WIDE))
    edited("R8313", name + "_v_repeat", "Repeat in v, %s in u, y is the height." % name, "y", 1, 4 * ONE,
           scene(counts=(2, 1), wrap=(mode, REPEAT, 0), planes=WIDE))
for value in (4, 128, 255):
    edited("R8314", "ellipsoid_%d" % value, "ellipsoid is %d." % value, "ellipsoid", 0, value)
for index in (3, 5):
    edited("R8314", "of_base_form_2_%d" % index, "ellipsoid is 3, and umbrella %d has no base." % index,
           "ellipsoid", index, OF_BASE)
bad("R8314", "of_base_form_2", "ellipsoid is 3, and the umbrella has no base; all else is 0.",
    base=with_umbrella(3, coloured(9, 9, ring(4, 600), tints(5, 1), ellipsoid=OF_BASE)))
for index, name in ((0, "flat"), (1, "of_base"), (5, "coloured_flat")):
    for plane in ("height", "curvature"):
        edited("R8314", "%s_%s" % (name, plane), "ellipsoid is %d, and there is a %s."
               % (OF_BASE if index == 1 else 0, plane), plane, index, 1)
edited("R8314", "lift_and_height", "lift and height are 65536 together.", "lift", 3, 45536)
edited("R8314", "lift_and_height_wrap", "lift and height are 2^16 + 1 together.", "lift", 4, 56537)
edited("R8314", "lift_and_height_of_base", "lift and the height of the base are 65536 together.", "lift",
       1, 65536 - STONE.height)
edited("R8314", "both_max", "lift is 65535, height 9000.", "lift", 4, 65535)

# ---- R8315: lists --------------------------------------------------------------------------------


def listed(lists: dict, wrap: tuple = REPEATED) -> File:
    """4 x 3 and 2 x 1 cells with these entries: (level, cell) -> pairs of entry and shift 0 to 8."""
    out = [[[] for _ in range(12)], [[] for _ in range(2)]]
    for (level, cell), pairs in lists.items():
        out[level][cell] = [(n, (s % 3 - 1, s // 3 - 1)) for n, s in pairs]
    return both(wrap=wrap, lists=out)


for name, what, lists, wrap in (
        ("descending", "Entries descend.", {(0, 0): [(1, 4), (0, 4)]}, REPEATED),
        ("twice", "A pair is there twice.", {(0, 3): [(2, 4), (2, 4)]}, REPEATED),
        ("twice_at_end", "The last pair is there twice.", {(0, 11): [(0, 4), (2, 4), (3, 4), (3, 4)]},
         REPEATED),
        ("shifts_descend", "The shifts of an entry descend.", {(0, 5): [(1, 5), (1, 4)]}, REPEATED),
        ("by_shift", "Pairs ascend by shift, not by entry.", {(0, 5): [(2, 3), (1, 4)]}, REPEATED),
        ("level_1_descending", "Entries descend in level 1.", {(1, 1): [(1, 4), (0, 4)]}, REPEATED),
        ("entry_count", "An entry is the number of umbrellas of level 0.", {(0, 2): [(5, 4)]}, REPEATED),
        ("entry_max", "An entry is 2^32 - 1.", {(0, 2): [(0, 4), (MAX32, 4)]}, REPEATED),
        ("entry_level_1", "An entry of level 1 is 2, which would be right in level 0.",
         {(1, 0): [(2, 4)]}, REPEATED),
        ("entry_of_all_levels", "An entry of level 1 counts the umbrellas of level 0.",
         {(1, 0): [(5, 4)]}, REPEATED),
        ("sx_clamp", "A shift to the left, and clamp in u.", {(0, 4): [(0, 3)]}, (CLAMP, REPEAT, 0)),
        ("sx_mirror", "A shift to the right, and mirrored repeat in u.", {(0, 4): [(0, 5)]},
         (MIRROR, REPEAT, 0)),
        ("sy_clamp", "A shift up, and clamp in v.", {(0, 4): [(0, 1)]}, (REPEAT, CLAMP, 0)),
        ("sy_border", "A shift down, and border in v.", {(0, 4): [(0, 7)]}, (REPEAT, BORDER, 0)),
        ("both_clamp", "A shift in both directions, and clamp in v.", {(0, 4): [(0, 4), (0, 8)]},
         (REPEAT, CLAMP, 0)),
        ("level_1_clamp", "A shift in level 1, and clamp.", {(1, 0): [(0, 5)]}, CLAMPED),
        ("wrap_w_counts_not", "Shifts, and repeat in w only.", {(0, 0): [(0, 5)]}, (CLAMP, CLAMP, REPEAT))):
    bad("R8315", name, what, base=listed(lists, wrap))
for value in (9, 10, 13, 128, 255):
    edited("R8315", "shift_%d" % value, "A shift is %d." % value, "shift", 0, value,
           listed({(0, 0): [(0, 8)]}))
bad("R8315", "empty_level", "A list names an umbrella in a level that has none.",
    {}, in_file(Umbrellas((2, 2), [[LOW[0]], []], [LEAF], lists=[[[]] * 4, [[(0, (0, 0))]]], planes=WIDE),
                [leaf_image(4, 4, 50, 1)]))

# ---- patches that show umbrellas -----------------------------------------------------------------

QUARTER = place(0.25, 0.5, 0.25)
bad("R8105", "umbrellas_later", "The source of a patch is a texture of umbrellas that comes later.",
    base=File([root(), leaf_image(4, 4, 50, 1)], [
        Texture("zip", [(0, NONE)], zipmap=Zipmap([Patch([0]), Patch([1], QUARTER, source_kind=1)])),
        textured(arrangement(counts=(1,), bases=[replace(LEAF, source=1)], planes=WIDE))]))
bad("R8105", "umbrellas_layers", "The source of a patch is umbrellas, which have one layer; the zipmap has "
    "two.", base=File([root(), leaf_image(4, 4, 50, 1)], [
        textured(arrangement(counts=(1,), bases=[replace(LEAF, source=1)], planes=WIDE)),
        Texture("zip", [(0, NONE), (1, NONE)], zipmap=Zipmap(
            [Patch([0, 0]), Patch([0, 0], QUARTER, source_kind=1)]))]))
