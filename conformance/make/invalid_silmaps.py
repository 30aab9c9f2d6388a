# SPDX-License-Identifier: Apache-2.0
"""The invalid files about silmaps (see invalid.py)."""

from invalid import MAX32, bad, bad_values
from silmake import BORDER, CLAMP, MIRROR, REPEAT, UNCUT, Silmap, cell, scattered
from valid import decal, place, root
from valid_silmaps import (CLAMPED, FRAME_CELLS, LAYERS, REPEATED, coded, frames_file, sample_image,
                           shown, silmap, small_image, texture)
from ztexmake import (NONE, R8, RGBA8, Chunk, File, Image, Patch, Plane, Texture, Zipmap, blocks,
                      flip, flip_at, frame, frame_header, plus, raw_block)

SLMP = silmap(5, 4, minified=True)
BESIDE = File([root(), decal(), sample_image(5, 4, CLAMPED)],
              [Texture("zip", [(1, NONE)], zipmap=Zipmap([Patch([0]), Patch([1], place(0.25, 0.5,
                  0.25))])), texture("silmap", 5, 4, CLAMPED, [2])], meta=[("k", "v")],
              extra=[Chunk("AAAA", b"1", flags=2), Chunk("XFOO", b"2", flags=2)])
# Positions in BESIDE: 0 TEXS, 1 IMAG, 2 ZPMP, 3 SLMP, 4 META, 5 AAAA, 6 XFOO, 7 TEXL.

# ---- directory, heads ----------------------------------------------------------------------------

for flags in (0, 2, 3):
    bad("R3005", "slmp_flags_%d" % flags, "SLMP has flags %d." % flags, {"entry.SLMP.flags": flags},
        SLMP)
bad("R3005", "slmp_reserved_bit_2", "SLMP has flags 5.", {"entry.SLMP.flags": 5}, SLMP)
bad("R3006", "slmp_zstd", "SLMP has codec 1, and is a right frame.", {}, silmap(
    3, 2, samples=[0] * 32, semantics=[0x8000] * 32, codec={"SLMP": 1}))
bad("R3006", "slmp_codec_2", "SLMP has codec 2.", {"entry.SLMP.codec": 2}, SLMP, also="R3007")
for value in (0, 2, 65535):
    bad("R3008", "slmp_version_%d" % value, "SLMP has version %d." % value,
        {"entry.SLMP.version": value}, SLMP)


def moved(*positions) -> dict:
    return {"chunks": lambda cs: [cs[p] for p in positions]}


for name, what, positions in (
        ("slmp_before_zpmp", "SLMP comes before ZPMP.", (0, 1, 3, 2, 4, 5, 6, 7)),
        ("slmp_before_imag", "SLMP comes before IMAG.", (0, 3, 1, 2, 4, 5, 6, 7)),
        ("slmp_first", "SLMP is the first chunk.", (3, 0, 1, 2, 4, 5, 6, 7)),
        ("slmp_behind_meta", "SLMP comes behind META.", (0, 1, 2, 4, 3, 5, 6, 7)),
        ("slmp_in_byte_order", "SLMP stands among unknown types in byte order.",
         (0, 1, 2, 4, 5, 3, 6, 7)),
        ("slmp_last", "SLMP comes behind TEXL.", (0, 1, 2, 4, 5, 6, 7, 3))):
    bad("R3009", name, what, moved(*positions), BESIDE)
TWO = File([sample_image(5, 4, CLAMPED), root(), decal()],
           [texture("a", 5, 4, CLAMPED, [0]), texture("b", 5, 4, CLAMPED, [0]),
            Texture("c", [(1, NONE)], zipmap=Zipmap([Patch([1])])),
            Texture("d", [(1, NONE)], zipmap=Zipmap([Patch([1])]))])
# Positions in TWO: 0 TEXS, 1 IMAG, 2 and 3 ZPMP, 4 and 5 SLMP, 6 TEXL.
bad("R3009", "slmp_between_zpmp", "An SLMP chunk stands between two ZPMP chunks.",
    moved(0, 1, 2, 4, 3, 5, 6), TWO)
bad("R3011", "imag_twice_with_slmp", "IMAG is there twice, in a file where SLMP rightly is.",
    moved(0, 1, 1, 2, 3, 4, 5, 6), TWO, also="R4001")
bad("R3011", "meta_twice_with_slmp", "META is there twice, in a file with a silmap.",
    {"chunks": lambda cs: cs[:5] + [Chunk(**vars(cs[4]))] + cs[5:]}, BESIDE)
bad("R3011", "unknown_twice_slmq", "A type that the reader does not know, SLMQ, is there twice.",
    base=silmap(3, 2, extra=[Chunk("SLMQ", b"1", flags=2), Chunk("SLMQ", b"2", flags=2)]))
bad("R4001", "slmp_magic", "The head of SLMP has a wrong magic.",
    {"head.SLMP.head_magic": flip_at(0)}, SLMP)
bad("R4002", "slmp_hash", "The head of SLMP repeats another stored_hash.",
    {"head.SLMP.entry": flip_at(39)}, SLMP)
bad("R4003", "slmp_hash", "The hashes of SLMP are wrong.",
    {"entry.SLMP.stored_hash": flip(40), "entry.SLMP.decoded_hash": flip(40)}, SLMP, also="R4004")
PADDED = silmap(3, 2)                                                     # 24 + 96 + 6 + 4 + 4
bad("R4005", "slmp_first", "The first byte of padding behind SLMP is not zero.",
    {"padding.SLMP": flip_at(0)}, PADDED)
bad("R4005", "slmp_last", "The last byte of padding behind SLMP is not zero.",
    {"padding.SLMP": flip_at(-1, 128)}, PADDED)

# ---- planes --------------------------------------------------------------------------------------

RUNS = coded(cells=Plane(codec=1))
BITS = silmap(5, 3, REPEATED, planes={"": Plane(packing=2),
                                      "cells": Plane(packing=2, bit_width=7, base=0)},
              cells=[cell(k % 8, k % 7, west=True) for k in range(15)])
bad_values("R5101", "slmp_predictor", "Predictor of the plane cells", "slmp.0.cells.predictor",
           [("3", 3), ("255", 255)], SLMP)
bad_values("R5101", "slmp_packing", "Packing of the plane samples", "slmp.0.samples.packing",
           [("3", 3), ("255", 255)], SLMP)
bad_values("R5101", "slmp_codec", "Codec of the plane minified", "slmp.0.minified.codec",
           [("2", 2), ("3", 3), ("255", 255)], SLMP)
bad("R5101", "slmp_reserved", "A reserved byte of the header of the plane cells is not zero.",
    {"slmp.0.cells.reserved": 1}, SLMP)
bad("R5101", "slmp_base_2_8", "base is 2^8 for elements of 1 byte; the sum modulo 2^8 is right.",
    {"slmp.0.cells.base": 256}, BITS)
bad_values("R5102", "slmp_element_size", "element_size of the plane cells",
           "slmp.0.cells.element_size", [("0", 0), ("2", 2), ("4", 4)], SLMP, also="R5101 R5103")
bad_values("R5102", "slmp_samples_element_size", "element_size of the plane samples",
           "slmp.0.samples.element_size", [("1", 1), ("8", 8)], SLMP, also="R5101 R5103")
for name in ("cells", "samples", "minified"):
    bad_values("R5102", "slmp_%s_count" % name, "count of the plane %s" % name,
               "slmp.0.%s.count" % name, [("0", 0), ("plus_1", plus(1)), ("max", MAX32)], SLMP,
               also="R5103")
    bad("R5105", "slmp_" + name, "The hash of the plane %s is wrong." % name,
        {"slmp.0.%s.hash" % name: flip(11)}, SLMP)
bad("R5102", "slmp_more_cells", "The plane cells has a row too many, and says so.",
    {"slmp.0.cells_y": 3}, SLMP, also="R8203 R8205")
bad("R5102", "slmp_count_without_layers", "The plane cells has one layer, cell_layers is 3.",
    {"slmp.0.cell_layers": 3}, frames_file(3, FRAME_CELLS[:20], 1))
bad("R5103", "slmp_raw_one_byte_more", "The plane cells has a byte too many, and says so.",
    {"slmp.0.cells.stored": lambda b: b + b"\0"}, SLMP)
bad("R5103", "slmp_raw_one_byte_less", "The plane minified has a byte too few, and says so.",
    {"slmp.0.minified.stored": lambda b: b[:-1]}, SLMP, also="R5105")
bad("R5103", "slmp_stored_size_max", "stored_size of the last plane is 2^32 - 1.",
    {"slmp.0.minified.stored_size": MAX32}, SLMP)
SIZE = 24 + 32 + 20 + 2 * 36
for name, size, what in (
        ("header", 24, "behind its header"), ("in_plane_header", 24 + 31, "in the first plane's "
         "header"), ("no_cells", 24 + 32, "behind the first plane's header"),
        ("in_cells", 24 + 32 + 19, "in the cells"), ("one_plane", 24 + 52, "behind the first plane"),
        ("two_planes", SIZE - 36, "behind the second plane"),
        ("in_last_header", SIZE - 5, "in the last plane's header"),
        ("last_byte", SIZE - 1, "before its last byte")):
    bad("R5103", "slmp_cut_" + name, "The chunk ends %s." % what,
        {"decoded.SLMP": lambda b, size=size: b[:size]}, SLMP)
bad("R5104", "slmp_highest_bit", "The highest bit of the last byte of the cells is set.",
    {"slmp.0.cells.stored": flip_at(-1, 128)}, BITS)
bad("R5104", "slmp_lowest_unused_bit", "The lowest unused bit of the last byte of the cells is set.",
    {"slmp.0.cells.stored": flip_at(-1, 1 << 15 * 7 % 8)}, BITS)
bad("R5105", "slmp_cell_changed", "A cell was changed without the hash.",
    {"slmp.0.cells.stored": flip_at(7)}, SLMP)
bad("R5106", "slmp_one_byte", "A byte follows the last plane.",
    {"decoded.SLMP": lambda b: b + b"\0"}, SLMP)
bad("R5106", "slmp_one_plane", "A fourth plane follows.",
    {"decoded.SLMP": lambda b: b + b[-36:]}, SLMP)
CELLS = bytes(RUNS.silmaps()[0].cells)
for rule, name, what, stored, also in (
        ("R5001", "slmp_window", "The frame of the cells is not single-segment.",
         frame_header(256, single_segment=0, window=0) + blocks(CELLS), ""),
        ("R5002", "slmp_plus_1", "The frame of the cells has another content size.",
         frame_header(257) + blocks(CELLS + b"\x24"), ""),
        ("R5003", "slmp_trailing", "A byte follows the frame of the cells.", frame(CELLS) + b"\0", ""),
        ("R5004", "slmp_one_less", "The frame of the cells decodes to one byte less.",
         frame_header(256) + blocks(CELLS[:-1]), "R5105"),
        ("R5103", "slmp_zstd_larger", "The frame of the cells is larger than the cells.",
         frame_header(256) + raw_block(CELLS, True), "")):
    bad(rule, name, what, {"slmp.0.cells.stored": stored}, RUNS, also)

# ---- textures ------------------------------------------------------------------------------------

bad("R6106", "silmap_with_image", "A layer of a silmap names an image.", {"layer.0.0.image": 0}, SLMP)
bad("R6106", "silmap_fffffffe", "A layer of a silmap has 0xFFFFFFFE.",
    {"layer.0.0.image": NONE - 1}, SLMP)
bad("R6106", "silmap_second_layer", "The second layer of a silmap names an image.",
    {"layer.0.1.image": 0}, silmap(6, 5, images=LAYERS, samples=[0, 1], semantics=[1, 2]))
bad("R6110", "no_slmp", "A silmap without its chunk.",
    {"chunks": lambda cs: [c for c in cs if c.type != "SLMP"]}, SLMP)
bad("R6110", "slmp_more", "Two SLMP chunks for one silmap.",
    {"chunks": lambda cs: cs[:3] + [Chunk(**vars(cs[2]))] + cs[3:]}, SLMP)
bad("R6110", "slmp_less", "One SLMP chunk for two silmaps.",
    moved(0, 1, 2, 3, 4, 6), TWO)
bad("R6110", "slmp_without_silmap", "An SLMP chunk in a file without silmaps.",
    {"texture.0.kind": 0, "layer.0.0.image": 0}, SLMP)
bad("R6110", "silmap_is_zipmap", "A texture of kind zipmap and an SLMP chunk.",
    {"texture.0.kind": 1}, SLMP)
bad("R6110", "zipmap_is_silmap", "Two silmaps, a ZPMP chunk and an SLMP chunk.",
    {"texture.0.kind": 2}, BESIDE)
bad("R6110", "kinds_sum_up", "One silmap and one zipmap with two SLMP chunks.",
    moved(0, 1, 3, 3, 4, 5, 6, 7), BESIDE, also="R4001")

# ---- 8200 ----------------------------------------------------------------------------------------

for size in (1, 16, 23):
    bad("R8201", "%d_bytes" % size, "The chunk has %d bytes, less than its header." % size,
        {"decoded.SLMP": lambda b, size=size: b[:size]}, SLMP)
for k in range(7):
    bad("R8201", "reserved_%d" % k, "Byte %d of the reserved field is not zero." % k,
        {"slmp.0.reserved": (1 if k % 2 else 128) << 8 * k}, SLMP)
bad_values("R8201", "layer_count", "layer_count is not the texture's", "slmp.0.layer_count",
           [("0", 0), ("2", 2), ("max", MAX32), ("2_31_plus_1", (1 << 31) + 1)], SLMP,
           also="R5102 R5103")
bad("R8201", "layer_count_less", "Two layers, layer_count 1.", {"slmp.0.layer_count": 1},
    silmap(6, 5, images=LAYERS, samples=[0, 1], semantics=[1, 2]), also="R5102")
for name in ("cells_x", "cells_y"):
    bad_values("R8201", name, name + " is out of range", "slmp.0." + name,
               [("0", 0), ("2_20_plus_1", (1 << 20) + 1), ("max", MAX32)], SLMP,
               also="R5102 R8203")
bad_values("R8201", "cell_layers", "cell_layers is out of range", "slmp.0.cell_layers",
           [("0", 0), ("2_16_plus_1", (1 << 16) + 1), ("max", MAX32)], SLMP, also="R5102 R8204")
bad("R8201", "no_cells_in_a_row", "cells_x is 0, and the plane cells is empty.",
    {"slmp.0.cells_x": 0, "slmp.0.cells.count": 0, "slmp.0.cells.stored": b""}, SLMP,
    also="R5105 R8203")
for name, numbers, what in (
        ("product_2_32", (1 << 16, 1 << 16, 1), "2^16 x 2^16 cells: a 32-bit count is 0."),
        ("product_2_32_layers", (1 << 16, 1, 1 << 16), "2^16 cells in 2^16 layers."),
        ("product_2_40", (1 << 20, 1 << 20, 1), "2^20 x 2^20 cells."),
        ("product_2_56", (1 << 20, 1 << 20, 1 << 16), "The largest of everything."),
        ("product_wraps", (1 << 20, (1 << 12) * 5, 1), "2^32 x 5 cells.")):
    bad("R8201", name, what, dict(zip(("slmp.0.cells_x", "slmp.0.cells_y", "slmp.0.cell_layers"),
                                      numbers)), SLMP, also="R5102 R8203 R8204")
bad("R8201", "product_wraps_to_20", "W x H x L modulo 2^32 is 20, the count of the plane.",
    {"slmp.0.cells_x": 858993460, "slmp.0.cells_y": 5}, SLMP, also="R5102 R8203")
for value in (3, 4, 128, 255):
    bad("R8202", "filter_%d" % value, "Filter %d." % value, {"slmp.0.filter": value}, SLMP)


def sil_bad(rule, name, what, *args, also="", **more):
    bad(rule, name, what, base=silmap(*args, **more), also=also)


for name, value in (("count", 1), ("max", NONE), ("2_31", 1 << 31)):
    sil_bad("R8203", "sample_" + name, "The sample image is %d, which does not exist." % value, 5, 4,
            samples=[value], images=[sample_image(5, 4, CLAMPED)])
sil_bad("R8203", "second_layer", "The second layer's sample image does not exist.", 6, 5,
        samples=[0, 1], images=LAYERS[:1])
sil_bad("R8203", "two_levels", "The sample image has two levels.", 5, 4,
        images=[sample_image(5, 4, CLAMPED, levels=2)])
sil_bad("R8203", "all_levels", "The second layer's sample image has all levels.", 5, 4,
        samples=[0, 1], images=[sample_image(5, 4, CLAMPED), sample_image(5, 4, CLAMPED, R8, levels=3)])
sil_bad("R8203", "depth_2", "The sample image has depth 2.", 5, 4,
        images=[sample_image(5, 4, CLAMPED, depth=2)])
sil_bad("R8203", "cube", "The sample image is a cube.", 3, 3,
        images=[Image(RGBA8, 4, 4, layers=6, layer_kind=1)])
sil_bad("R8203", "cube_repeat", "The sample image is a cube, cells have six layers.", 4, 4, REPEATED,
        cells=[UNCUT] * 96, cell_layers=6, images=[Image(RGBA8, 4, 4, layers=6, layer_kind=1)])
for mode, name in enumerate(("repeat", "mirror", "clamp", "border")):
    for direction in range(2):
        wrap = tuple(mode if k == direction else CLAMP for k in range(3))
        cells = scattered(5, 4, wrap, 5)
        right = sample_image(5, 4, wrap)
        one = 1 if mode == REPEAT else -1
        wrong = [right.width, right.height]
        wrong[direction] += one
        sil_bad("R8203", "%s_%s_as_other" % (name, "uv"[direction]), "%s in %s and %d samples for %d "
                "cells." % (name.capitalize(), "uv"[direction], wrong[direction], (5, 4)[direction]),
                5, 4, wrap, cells=cells, images=[Image(RGBA8, *wrong)])
sil_bad("R8203", "width_plus_2", "Clamp and W + 2 samples in a row.", 5, 4,
        images=[Image(RGBA8, 7, 5)])
sil_bad("R8203", "height_plus_2", "Clamp and H + 2 rows.", 5, 4, images=[Image(RGBA8, 6, 6)])
sil_bad("R8203", "turned", "Width and height are swapped.", 5, 4, images=[Image(RGBA8, 5, 6)])
sil_bad("R8203", "wrap_w_counts_not", "Clamp in u and v, repeat in w, which has no samples to save.",
        5, 4, (CLAMP, CLAMP, REPEAT), images=[Image(RGBA8, 5, 4)])
bad("R8203", "wrap_changed", "A texture that repeats was changed to clamp; no cut leaves it.",
    {"texture.0.wrap_u": CLAMP, "texture.0.wrap_v": CLAMP},
    silmap(5, 4, REPEATED, cells=scattered(5, 4, CLAMPED, 5)))
STILL, MOVING = sample_image(5, 4, CLAMPED), sample_image(5, 4, CLAMPED, layers=3, layer_kind=2)
for name, images in (("first", [MOVING, STILL]), ("second", [STILL, MOVING])):
    sil_bad("R8204", "layers_differ_" + name, "The %s layer's samples have three frames, the other "
            "layer's one." % name, 5, 4, samples=[0, 1], images=images)
for number, count, own in ((2, 3, FRAME_CELLS[:40]), (3, 1, FRAME_CELLS), (2, 1, FRAME_CELLS[:40]),
                           (3, 2, FRAME_CELLS), (4, 3, FRAME_CELLS + FRAME_CELLS[:20])):
    sil_bad("R8204", "cells_%d_samples_%d" % (number, count),
            "cell_layers is %d, the samples have %d." % (number, count), 5, 4, cells=own,
            cell_layers=number, images=[sample_image(5, 4, CLAMPED, layers=count)])
sil_bad("R8204", "cells_3_samples_1_and_3", "cell_layers is 3, the number of the second layer's "
        "samples only.", 5, 4, cells=FRAME_CELLS, cell_layers=3, samples=[0, 1],
        images=[STILL, MOVING])
for name, value in (("count", 2), ("fffffffe", NONE - 1), ("2_31", 1 << 31)):
    sil_bad("R8205", "image_" + name, "The minified image is %d, which does not exist." % value, 5, 4,
            images=[STILL, small_image(5, 4)], minified=[value])
for name, small in (
        ("width_less", small_image(4, 4)), ("width_more", small_image(6, 4)),
        ("height_less", small_image(5, 3)), ("height_more", small_image(5, 5)),
        ("turned", small_image(4, 5)), ("as_samples", small_image(6, 5)),
        ("depth", small_image(5, 4, depth=2)),
        ("format", small_image(5, 4, RGBA8, transfer=13)), ("alpha_mode", small_image(5, 4, alpha_mode=1)),
        ("primaries", small_image(5, 4, primaries=9)), ("layers", small_image(5, 4, layers=2)),
        ("layer_kind", small_image(5, 4, layer_kind=2))):
    sil_bad("R8205", name, "The minified image differs in: %s." % name.replace("_", " "), 5, 4,
            images=[STILL, small], minified=[1])
sil_bad("R8205", "transfer", "The minified image differs in: transfer.", 5, 4, minified=[1],
        images=[sample_image(5, 4, CLAMPED, RGBA8, transfer=8), small_image(5, 4, RGBA8, transfer=1)])
sil_bad("R8205", "second_layer", "The second layer's minified image has the first layer's format.",
        6, 5, samples=[0, 1], images=LAYERS, minified=[3, 3])
sil_bad("R8205", "frames", "The samples have three frames, the minified image one.", 5, 4,
        cells=FRAME_CELLS, cell_layers=3, images=[MOVING, small_image(5, 4)], minified=[1])
sil_bad("R8205", "cube", "The minified image is a cube, the samples are an array of six.", 4, 4,
        images=[sample_image(4, 4, CLAMPED, RGBA8, layers=6),
                Image(RGBA8, 4, 4, layers=6, layer_kind=1)], minified=[1])


def cut_at(w: int, h: int, wrap: tuple, places: dict, layers: int = 1) -> dict:
    """More cells for `silmap`: uncut but for those at the places."""
    cells = [UNCUT] * (w * h * layers)
    for place_, byte in places.items():
        cells[place_] = byte
    return {"cells": cells, "cell_layers": layers, "wrap": wrap,
            "images": [sample_image(w, h, wrap, layers=layers)]}


W_CUT, N_CUT = cell(west=True), cell(north=True)
for mode, name in ((MIRROR, "mirror"), (CLAMP, "clamp"), (BORDER, "border")):
    sil_bad("R8206", "west_" + name, "An arm to the west of the first column is cut, %s in u, repeat "
            "in v." % name, 5, 4, **cut_at(5, 4, (mode, REPEAT, REPEAT), {5: W_CUT}))
    sil_bad("R8206", "north_" + name, "An arm to the north of the first row is cut, repeat in u, %s "
            "in v." % name, 5, 4, **cut_at(5, 4, (REPEAT, mode, REPEAT), {2: N_CUT}))
for name, places in (("west_first", {0: W_CUT}), ("west_last_row", {15: W_CUT}),
                     ("north_first", {0: N_CUT}), ("north_last_column", {4: N_CUT}),
                     ("both", {0: W_CUT | N_CUT}), ("west_at_any_point", {10: cell(1, 6, True)})):
    sil_bad("R8206", name, "Clamp, and an arm that leaves the texture is cut: %s."
            % name.replace("_", " "), 5, 4, **cut_at(5, 4, CLAMPED, places))
for name, place_, byte in (("west", 20 + 5, W_CUT), ("north", 20 + 3, N_CUT)):
    sil_bad("R8206", name + "_second_layer", "An arm that leaves the texture is cut in the second "
            "layer of cells.", 5, 4, **cut_at(5, 4, CLAMPED, {place_: byte}, 2))
sil_bad("R8206", "1x1", "One cell, clamp, its north arm is cut.", 1, 1,
        **cut_at(1, 1, CLAMPED, {0: N_CUT}))
bad("R8206", "as_repeat", "A repeating texture's cells and a texture that is mirrored; the samples "
    "are right.", base=silmap(5, 4, (MIRROR, MIRROR, 0), cells=scattered(5, 4, REPEATED, 5),
                              images=[Image(RGBA8, 6, 5)]), also="R8207")
for name, byte in (("00", 0), ("25", 0x25), ("2c", 0x2C), ("3f", 0x3F)):
    bad("R8207", "byte_" + name, "A cell without cuts has the byte 0x%s: a warning." % name.upper(),
        base=silmap(5, 4, **cut_at(5, 4, CLAMPED, {7: byte})), severity="warning")
for name, what, places, wrap, layers in (
        ("beside_cut", "A cell beside one whose south arm is cut.",
         {11: N_CUT | 1, 5: cell(2, 2)}, CLAMPED, 1),
        ("first", "The first cell, in a texture that repeats.", {0: cell(0, 0)}, REPEATED, 1),
        ("last", "The last cell, to whose east and south nothing is.", {19: cell(7, 7)}, CLAMPED, 1),
        ("second_layer", "A cell of the second layer; the first has a cut there.",
         {7: cell(1, 1, True), 27: cell(1, 1)}, CLAMPED, 2),
        ("all", "All cells have the byte 0.", {k: 0 for k in range(20)}, CLAMPED, 1)):
    bad("R8207", name, what + " Its point is not in the middle: a warning.",
        base=silmap(5, 4, **cut_at(5, 4, wrap, places, layers)), severity="warning")
bad("R8207", "two_chunks", "Two silmaps, a cell of the second has the byte 0x23: a warning.",
    base=File([STILL], [texture("a", 5, 4, CLAMPED, [0]),
                        Texture("b", [(1, NONE)], wrap=CLAMPED, silmap=Silmap(
                            5, 4, [UNCUT] * 19 + [0x23], [0]))]), severity="warning")

# ---- patches that show silmaps -------------------------------------------------------------------

QUARTER = place(0.25, 0.5, 0.25)
bad("R8105", "silmap_later", "The source of a patch is a silmap that comes later.",
    base=File([root(), STILL], [
        Texture("zip", [(0, NONE)], zipmap=Zipmap([Patch([0]), Patch([1], QUARTER, source_kind=1)])),
        texture("silmap", 5, 4, CLAMPED, [1])]))
bad("R8105", "silmap_layers", "The source of a patch is a silmap of two layers, the zipmap has one.",
    base=shown([texture("silmap", 5, 4, CLAMPED, [1, 1])], [STILL],
               [Patch([0], QUARTER, source_kind=1)]))
