# SPDX-License-Identifier: Apache-2.0
"""The valid files with silmaps; `silmap` makes one, the rest are calls of it."""

import struct

from silmake import (BORDER, CLAMP, CONTINUOUS, MIRROR, NEAREST, NORTH, REPEAT, SEN2004, UNCUT, WEST,
                     Silmap, cell, cut_arms, lawful, scattered)
from valid import META, PLACED, add, decal, mask, place, pred, root, zipmap
from ztexmake import (FORMATS, NONE, R8, RGB8, RGBA8, RGBA8_SRGB, Chunk, File, Image, Patch, Plane,
                      Texture, Zipmap, flat, noise, stored_zstd)

WRAP_NAMES = ("repeat", "mirror", "clamp", "border")
FILTER_NAMES = ("continuous", "sen2004", "nearest")
CLAMPED, REPEATED = (CLAMP, CLAMP, CLAMP), (REPEAT, REPEAT, REPEAT)


def corners(w: int, h: int, wrap: tuple) -> tuple:
    """The size of a sample image."""
    return w + (wrap[0] != REPEAT), h + (wrap[1] != REPEAT)


def tame(fmt: int, seed: int):
    """texels() without the NaN and the huge numbers that noise has in float formats: values from 0
    to 1."""
    known = FORMATS[fmt]
    size = known.block_bytes // known.channels
    if "FLOAT" not in known.name:
        return None
    letter = {2: "e", 4: "f"}[size]
    return lambda level, total: b"".join(struct.pack("<" + letter, v / 255)
                                         for v in noise(total // size, seed + level))


def sample_image(w: int, h: int, wrap: tuple, fmt: int = RGBA8_SRGB, seed: int = 1, **more) -> Image:
    return Image(fmt, *corners(w, h, wrap), seed=seed, texels=more.pop("texels", tame(fmt, seed)),
                 **more)


def small_image(w: int, h: int, fmt: int = RGBA8_SRGB, seed: int = 99, **more) -> Image:
    """A minified image. Its texels are not those of section 7, so that a lookup shows which image
    it saw."""
    return Image(fmt, w, h, seed=seed, texels=more.pop("texels", tame(fmt, seed)), **more)


def silmap(w: int, h: int, wrap: tuple = CLAMPED, cells: list = None, images: list = None,
           minified=None, samples: list = None, semantics=None, **more) -> File:
    """A file with one silmap. Images: by default one sample image and, with `minified` True, one
    minified image behind it."""
    images = images or [sample_image(w, h, wrap)]
    if minified is True:
        images, minified = images + [small_image(w, h)], [1]
    samples = samples or [0]
    cells = scattered(w, h, wrap, 5) if cells is None else cells
    own = {k: more.pop(k) for k in ("filter", "cell_layers", "planes") if k in more}
    semantics = semantics or [1] * len(samples)
    texture = Texture("silmap", [(s, NONE) for s in semantics], wrap=wrap,
                      silmap=Silmap(w, h, cells, samples, minified, **own))
    return File(images, [texture], **more)


# ---- the smallest, and the example of the specification ------------------------------------------

# Cell (1, 0) has its west and its south arm cut.
EXAMPLE_CELLS = [cell(6, 4), cell(2, 5, west=True), UNCUT, UNCUT, cell(4, 1, north=True), UNCUT]
EXAMPLE_SAMPLES = bytes((0, 20, 220, 240, 10, 40, 200, 250, 255, 235, 180, 0))
add("silmap_example", "The example of silmap.md: 3 x 2 cells, clamp, one layer of R8.",
    silmap(3, 2, cells=EXAMPLE_CELLS, semantics=[8],
           images=[Image(R8, 4, 3, texels=lambda level, size: EXAMPLE_SAMPLES)]))

for mode, name in enumerate(WRAP_NAMES):
    add("silmap_1x1_" + name, "One cell without cuts, %s." % name,
        silmap(1, 1, (mode, mode, mode), cells=[UNCUT], minified=True))
for name, byte in (("west_east", cell(1, 6, west=True)), ("north_south", cell(7, 0, north=True)),
                   ("four_arms", cell(3, 5, west=True, north=True))):
    add("silmap_1x1_" + name, "One cell that repeats, so that it is its own neighbour: %s cut."
        % name.replace("_", " and ").replace("four and arms", "four arms"),
        silmap(1, 1, REPEATED, cells=[byte], minified=True))
add("silmap_1x5", "One column, cut between all cells, clamp.",
    silmap(1, 5, cells=lawful([cell(k, 7 - k, north=True) for k in range(5)], 1, 5, CLAMPED)))
add("silmap_5x1", "One row, cut between all cells, repeat in u and clamp in v.",
    silmap(5, 1, (REPEAT, CLAMP, CLAMP), cells=[cell(k, 7 - k, west=True) for k in range(5)],
           minified=True))

# ---- patterns, filters, wraps --------------------------------------------------------------------

ALL_PATTERNS = scattered(8, 8, REPEATED, 3)
assert len({cut_arms(ALL_PATTERNS, 8, 8, REPEATED, k % 8, k // 8) for k in range(64)}) == 16
for kind, name in enumerate(FILTER_NAMES):
    add("silmap_patterns_" + name, "All sixteen patterns of cut arms, filter %s." % name,
        silmap(8, 8, REPEATED, cells=ALL_PATTERNS, filter=kind))
    add("silmap_minified_" + name, "Filter %s with a minified image of all levels." % name,
        silmap(8, 8, REPEATED, cells=ALL_PATTERNS, filter=kind, minified=[1],
               images=[sample_image(8, 8, REPEATED), small_image(8, 8, levels=4)]))

# One cell in the middle of 3 x 3 for each pattern: the arms that are cut and nothing else.
for k in range(16):
    bits = {4: k >> 3 & 1, 5: k & 1, 7: k >> 2 & 1}       # W of the middle, W to the east, N below
    nine = [cell(2 + n % 3, 6 - n // 2, west=n in (4, 5) and bits[n], north=n == 4 and k >> 1 & 1
                 or n == 7 and bits[7]) for n in range(9)]
    nine = lawful(nine, 3, 3, CLAMPED)
    arms = cut_arms(nine, 3, 3, CLAMPED, 1, 1)
    for kind in (CONTINUOUS, SEN2004):
        add("silmap_arms_%s_%s" % (arms.lower() or "none", FILTER_NAMES[kind]),
            "3 x 3 cells, cut arms of the one in the middle: %s; filter %s."
            % (", ".join(arms) or "none", FILTER_NAMES[kind]),
            silmap(3, 3, cells=nine, filter=kind, images=[sample_image(3, 3, CLAMPED, RGB8)]))

# Points at the ends of their range: quadrants with angles above 180 degrees and nearly 0.
EXTREME = lawful([cell(0 if (k + k // 6) % 2 else 7, 0 if k % 3 else 7, True, True)
                  for k in range(36)], 6, 6, REPEATED)
for kind, name in enumerate(FILTER_NAMES):
    add("silmap_extreme_points_" + name, "Points in the corners of their cells, every arm cut, "
        "filter %s." % name, silmap(6, 6, REPEATED, cells=EXTREME, filter=kind))
HALF = [b if k % 3 else b & 63 for k, b in enumerate(EXTREME)]
for kind in (CONTINUOUS, SEN2004):
    add("silmap_extreme_points_some_%s" % FILTER_NAMES[kind], "The same with fewer cuts, filter %s."
        % FILTER_NAMES[kind], silmap(6, 6, REPEATED, cells=lawful(HALF, 6, 6, REPEATED), filter=kind))

for u, name_u in enumerate(WRAP_NAMES):
    for v, name_v in enumerate(WRAP_NAMES):
        wrap = (u, v, (u + v) % 4)
        add("silmap_wrap_%s_%s" % (name_u, name_v), "Wrap modes %s in u and %s in v: %d x %d samples "
            "for 5 x 4 cells." % ((name_u, name_v) + corners(5, 4, wrap)),
            silmap(5, 4, wrap, cells=scattered(5, 4, wrap, 7 + 4 * u + v), minified=True))

# ---- borders -------------------------------------------------------------------------------------


def bordered(w: int, h: int, wrap: tuple, arms: list, seed: int, kind: int) -> File:
    """Frames whose cells differ in the arms that are cut: frame k has `arms` (cell, bit) number n
    cut if bit n of k is set, an entry being one arm or several. Each frame has points of its own."""
    frames = 1 << len(arms)
    cells = []
    for k in range(frames):
        layer = [v & 0x3F for v in noise(w * h, seed + k)]
        for n, group in enumerate(arms):
            for at, bit in group if k >> n & 1 else ():
                layer[at] |= bit
        cells += lawful(layer, w, h, wrap)
    return silmap(w, h, wrap, cells=cells, cell_layers=frames, filter=kind, minified=[1], images=[
        sample_image(w, h, wrap, RGBA8, layers=frames, layer_kind=2, seed=seed),
        small_image(w, h, RGBA8, layers=frames, layer_kind=2)])


def inner_arms(w: int, h: int, wrap: tuple = CLAMPED) -> list:
    """Every arm that does not leave the texture, by itself."""
    return [[(j * w + i, bit)] for j in range(h) for i in range(w)
            for bit, first, mode in ((WEST, i == 0, wrap[0]), (NORTH, j == 0, wrap[1]))
            if not first or mode == REPEAT]


# 3 x 3: three groups, one for each inner arm of the four cells in the middle of a side.
SIDES = [[(1, WEST), (3, NORTH), (5, NORTH), (7, WEST)],
         [(2, WEST), (6, NORTH), (8, NORTH), (8, WEST)],
         [(4, NORTH), (4, WEST), (5, WEST), (7, NORTH)]]
for kind, name in enumerate(FILTER_NAMES):
    add("silmap_border_sides_" + name, "3 x 3 cells, clamp; the cells in the middle of the sides have "
        "none to three of their inner arms cut, frame by frame; filter %s." % name,
        bordered(3, 3, CLAMPED, SIDES, 300, kind))
    add("silmap_border_corners_" + name, "2 x 2 cells, clamp, each a corner: a frame for each way to "
        "cut the four inner arms; filter %s." % name,
        bordered(2, 2, CLAMPED, inner_arms(2, 2), 320, kind))
    add("silmap_border_1x4_" + name, "One column, clamp: a frame for each way to cut the three inner "
        "arms; filter %s." % name, bordered(1, 4, CLAMPED, inner_arms(1, 4), 340, kind))
    add("silmap_border_4x1_" + name, "One row, clamp: a frame for each way to cut the three inner "
        "arms; filter %s." % name, bordered(4, 1, CLAMPED, inner_arms(4, 1), 360, kind))
for mode, name in ((MIRROR, "mirror"), (BORDER, "border")):
    add("silmap_border_sides_" + name, "3 x 3 cells, %s; the cells in the middle of the sides as in "
        "silmap_border_sides_continuous." % name,
        bordered(3, 3, (mode, mode, mode), SIDES, 380, CONTINUOUS))
    add("silmap_border_corners_" + name, "2 x 2 cells, %s in u, clamp in v." % name,
        bordered(2, 2, (mode, CLAMP, CLAMP), inner_arms(2, 2), 400, SEN2004))
ACROSS, ALONG = (REPEAT, CLAMP, CLAMP), (CLAMP, REPEAT, CLAMP)
for name, w, h, wrap in (("2x2_u", 2, 2, ACROSS), ("2x2_v", 2, 2, ALONG), ("1x3_u", 1, 3, ACROSS),
                         ("3x1_v", 3, 1, ALONG), ("3x1_u", 3, 1, ACROSS), ("1x3_v", 1, 3, ALONG),
                         ("1x1_u", 1, 1, ACROSS), ("1x1_v", 1, 1, ALONG)):
    for kind in (CONTINUOUS, SEN2004):
        add("silmap_border_%s_%s" % (name, FILTER_NAMES[kind]), "%d x %d cells that repeat in %s only: "
            "every way to cut the arms that stay inside; filter %s."
            % (w, h, name[-1], FILTER_NAMES[kind]),
            bordered(w, h, wrap, inner_arms(w, h, wrap), 420 + w + 8 * h, kind))

# ---- minified images -----------------------------------------------------------------------------

add("silmap_minified_one_level", "A minified image with one level.", silmap(6, 4, minified=True))
add("silmap_minified_some_levels", "A minified image with two of three levels.",
    silmap(6, 4, minified=[1], images=[sample_image(6, 4, CLAMPED), small_image(6, 4, levels=2)]))
add("silmap_minified_is_first_image", "The minified image comes before the sample image.",
    silmap(6, 4, samples=[1], minified=[0],
           images=[small_image(6, 4), sample_image(6, 4, CLAMPED)]))
add("silmap_minified_is_samples", "In a texture that repeats, an image can be both.",
    silmap(4, 4, REPEATED, minified=[0], images=[sample_image(4, 4, REPEATED)]))
add("silmap_image_not_named", "An image that no texture names lies between the two.",
    silmap(6, 4, minified=[2], images=[sample_image(6, 4, CLAMPED), Image(R8, 3, 1),
                                       small_image(6, 4)]))

# ---- layers, frames ------------------------------------------------------------------------------

LAYERS = [sample_image(6, 5, CLAMPED, alpha_mode=1), sample_image(6, 5, CLAMPED, 77, seed=2),
          sample_image(6, 5, CLAMPED, R8, seed=3), small_image(6, 5, levels=3, alpha_mode=1),
          small_image(6, 5, 77, seed=4)]
add("silmap_layers", "Base colour, normal and opacity share the cells; the last has no minified "
    "image.", silmap(6, 5, images=LAYERS, samples=[0, 1, 2], minified=[3, 4, NONE],
                     semantics=[1, 2, 8]))
add("silmap_layers_share_images", "Two layers with the same two images.",
    silmap(6, 5, images=[LAYERS[0], LAYERS[3]], samples=[0, 0], minified=[1, 1],
           semantics=[1, 0x8000]))
add("silmap_layers_32", "A silmap of 32 layers.",
    silmap(3, 2, samples=[0] * 32, semantics=[0x8000 + k for k in range(32)],
           planes={"": Plane(packing=2), "cells": Plane()}))
FRAME_CELLS = [b for k in range(3) for b in scattered(5, 4, CLAMPED, 20 + k)]


def frames_file(count: int, cells: list, cell_layers: int, kind: int = 2, **more) -> File:
    return silmap(5, 4, cells=cells, cell_layers=cell_layers, minified=[1], images=[
        sample_image(5, 4, CLAMPED, layers=count, layer_kind=kind),
        small_image(5, 4, layers=count, layer_kind=kind, levels=2)], **more)


add("silmap_frames", "Three frames with cells of their own.", frames_file(3, FRAME_CELLS, 3))
add("silmap_frames_static_cells", "Three frames that share one layer of cells.",
    frames_file(3, FRAME_CELLS[:20], 1))
add("silmap_array", "An array of three layers with cells of their own.",
    frames_file(3, FRAME_CELLS, 3, 0))
add("silmap_frames_wrap", "Three frames that repeat, filter sen2004.",
    silmap(5, 4, REPEATED, cells=[b for k in range(3) for b in scattered(5, 4, REPEATED, 30 + k)],
           cell_layers=3, filter=SEN2004,
           images=[sample_image(5, 4, REPEATED, layers=3, layer_kind=2)]))
add("silmap_frames_and_array", "One layer has three frames, the other an array of three layers.",
    silmap(5, 4, cells=FRAME_CELLS, cell_layers=3, samples=[0, 1], semantics=[1, 4],
           images=[sample_image(5, 4, CLAMPED, layers=3, layer_kind=2),
                   sample_image(5, 4, CLAMPED, R8, layers=3)]))
add("silmap_65536_layers", "One cell in 2^16 layers, the largest number of each.",
    silmap(1, 1, REPEATED, cells=[cell(1, 2, True, True)] * 65536, cell_layers=65536,
           planes={"": Plane(packing=2)},
           images=[Image(R8, 1, 1, layers=65536, texels=flat(7), codec=stored_zstd)]))
add("silmap_1048576_cells", "2^20 cells in a row, the largest width.",
    silmap(1 << 20, 1, REPEATED, cells=[UNCUT] * (1 << 20), planes={"": Plane(packing=2)},
           images=[Image(R8, 1 << 20, 1, tile_log2=16, texels=flat(1), codec=stored_zstd)]))

# ---- formats -------------------------------------------------------------------------------------

for number, mode in ((9, 0), (15, 0), (16, 0), (29, 0), (37, 1), (43, 1), (43, 2), (70, 0), (77, 0),
                     (91, 1), (97, 2), (100, 0), (109, 1)):
    name = FORMATS[number].name.lower() + ("", "_straight", "_premultiplied")[mode]
    add("silmap_format_" + name, "Samples and minified image of %s, alpha_mode %d."
        % (FORMATS[number].name, mode), silmap(4, 3, minified=[1], images=[
            sample_image(4, 3, CLAMPED, number, alpha_mode=mode),
            small_image(4, 3, number, alpha_mode=mode, levels=2)]))
add("silmap_format_bc7", "Samples in a block format, which a reader may not be able to look up.",
    silmap(7, 7, images=[Image(145, 8, 8, texels=flat(0))]))
add("silmap_format_unknown", "Samples in a format that the registry does not have.",
    silmap(7, 7, minified=[1], images=[Image(1000, 8, 8, block=(2, 2, 3)),
                                       Image(1000, 7, 7, block=(2, 2, 3))]))
add("silmap_transfer_gamma", "Samples with primaries 9 and transfer 4, and a minified image alike.",
    silmap(4, 3, minified=[1], images=[
        sample_image(4, 3, CLAMPED, RGBA8, primaries=9, transfer=4),
        small_image(4, 3, RGBA8, primaries=9, transfer=4)]))
add("silmap_tiled_pred", "70 x 40 cells; samples in tiles of 32 x 32, some of codec pred.",
    silmap(70, 40, images=[pred(RGB8, 71, 41, tile_log2=5, colour=True)],
           cells=lawful([b if k % 5 == 0 else UNCUT for k, b in enumerate(noise(2800, 8))], 70, 40,
                        CLAMPED)))

# ---- planes --------------------------------------------------------------------------------------

# Only the first rows are cut, so that frames of runs save bytes; 32 layers, so that all planes are
# long enough.
MOSTLY_UNCUT = scattered(16, 3, REPEATED, 9) + [UNCUT] * (16 * 13)
MOSTLY_UNCUT = lawful(MOSTLY_UNCUT, 16, 16, REPEATED)


def coded(**planes) -> File:
    """16 x 16 cells, 32 layers, planes as given; "" as `default`."""
    planes[""] = planes.pop("default", Plane())
    return silmap(16, 16, REPEATED, cells=MOSTLY_UNCUT, samples=[0, 1] + [0] * 30, planes=planes,
                  minified=[0, NONE] + [NONE] * 30, semantics=[0x8000] * 32,
                  images=[sample_image(16, 16, REPEATED, R8, seed=s) for s in (1, 2)])


for predictor in range(3):
    for packing in range(2):
        for codec in range(2):
            add("silmap_planes_p%d_k%d_c%d" % (predictor, packing, codec),
                "Planes with predictor %d, packing %d, codec %d." % (predictor, packing, codec),
                coded(default=Plane(predictor, packing, codec)))
add("silmap_planes_bits", "All planes with packing 2; the cells have base 64 and six bits.",
    silmap(5, 3, REPEATED, minified=True, planes={"": Plane(packing=2)},
           cells=[cell(k % 8, k % 7, west=True) for k in range(15)]))
add("silmap_planes_bits_7", "Cells of seven bits, which cross bytes and leave unused bits.",
    silmap(5, 3, REPEATED, planes={"cells": Plane(packing=2, bit_width=7, base=0)},
           cells=[cell(k % 8, k % 7, west=True) for k in range(15)]))
add("silmap_planes_bits_full_width", "Packing 2 with bit_width 8 x E and base 0.",
    coded(default=Plane(packing=2, bit_width=32, base=0),
          cells=Plane(packing=2, bit_width=8, base=0)))
add("silmap_planes_bits_base_top", "Packing 2, where base + 2^bit_width - 1 is 2^32 - 1.",
    silmap(3, 2, planes={"minified": Plane(packing=2, bit_width=0, base=NONE)}))
add("silmap_planes_mixed", "Each plane has a coding of its own.",
    coded(cells=Plane(1, 0, 1), samples=Plane(packing=2), minified=Plane(2, 1, 1)))
add("silmap_planes_zstd_fcs_8", "The cells in a frame whose content size takes eight bytes.",
    coded(cells=Plane(codec=1, fcs_bytes=8)))

# ---- beside other things -------------------------------------------------------------------------


def texture(name: str, w: int, h: int, wrap: tuple, samples: list, minified: list = None,
            seed: int = 5, **more) -> Texture:
    return Texture(name, [(1, NONE)] * len(samples), wrap=wrap, silmap=Silmap(
        w, h, scattered(w, h, wrap, seed), samples, minified, **more))


ROOT_AND_PATCH = Zipmap([Patch([0]), Patch([1], PLACED)])
add("silmap_several", "Silmap, image, silmap, zipmap, silmap: the n-th silmap owns the n-th SLMP "
    "chunk.",
    File([root(), decal(), sample_image(4, 3, CLAMPED), sample_image(5, 4, REPEATED, seed=2),
          small_image(5, 4)],
         [texture("a", 4, 3, CLAMPED, [2]), Texture("b", [(1, 0)]),
          texture("c", 5, 4, REPEATED, [3], [4]),
          Texture("d", [(1, NONE)], zipmap=ROOT_AND_PATCH),
          texture("e", 4, 3, (MIRROR, BORDER, 0), [2], seed=6, filter=NEAREST)]))
add("silmap_images_shared", "An image is the samples of a silmap, and a texture of its own.",
    File([sample_image(4, 3, CLAMPED)], [Texture("plain", [(1, 0)]),
                                         texture("silmap", 4, 3, CLAMPED, [0])]))
add("silmap_meta_unknown_chunk", "A silmap with metadata and an unknown chunk.",
    silmap(3, 2, meta=META, extra=[Chunk("XFOO", b"foo", flags=2)]))
add("silmap_unknown_chunk_before_type", "Unknown chunks whose types lie before and behind SLMP in "
    "byte order.", silmap(3, 2, extra=[Chunk(t, b"1", flags=2) for t in ("AAAA", "SLMO", "SLMQ")]))


def shown(source: list, images: list, patches: list, layers: int = 1, wrap: tuple = CLAMPED) -> File:
    """A zipmap over image 0 whose patches show earlier textures."""
    return File([Image(RGBA8, 4, 4, seed=40)] + images, source + [
        Texture("zip", [(1, NONE)] * layers, wrap=wrap,
                zipmap=Zipmap([Patch([0] * layers)] + patches))])


for mode, name in enumerate(WRAP_NAMES):
    wrap = (mode, mode, mode)
    add("silmap_in_zipmap_" + name, "A patch shows a silmap with alpha, %s; the lookup clamps, "
        "neighbours and samples are those of the texture." % name,
        shown([texture("silmap", 5, 4, wrap, [1], [2])],
              [sample_image(5, 4, wrap, alpha_mode=1), small_image(5, 4, levels=2, alpha_mode=1)],
              [Patch([0], place(0.25, 0.25, 0.5), source_kind=1)], wrap=wrap))
add("silmap_in_zipmap_mask", "A patch shows a silmap without alpha, with a mask.",
    shown([texture("silmap", 5, 4, CLAMPED, [1])], [sample_image(5, 4, CLAMPED, RGB8), mask(8, 8, 2)],
          [Patch([0], place(0.25, 0.25, 0.5), source_kind=1, mask=2)]))
add("silmap_in_zipmap_layers", "A patch shows a silmap of two layers, by a homography.",
    shown([texture("silmap", 5, 4, REPEATED, [1, 2], filter=SEN2004)],
          [sample_image(5, 4, REPEATED, alpha_mode=2), sample_image(5, 4, REPEATED, R8, seed=3)],
          [Patch([0, 0], (2.5, 0.125, -0.5, -0.25, 3.0, -0.75, 0.25, -0.125, 1.0), source_kind=1)],
          layers=2))
add("silmap_in_zipmap_in_zipmap", "A patch shows a zipmap whose patch shows a silmap.",
    shown([texture("silmap", 5, 4, REPEATED, [1]),
           Texture("inner", [(1, NONE)], zipmap=Zipmap(
               [Patch([0]), Patch([0], place(0.125, 0.125, 0.75), source_kind=1)]))],
          [sample_image(5, 4, REPEATED, alpha_mode=1)],
          [Patch([1], place(0.25, 0.25, 0.5), source_kind=1)]))
add("silmap_in_zipmap_frames", "A patch shows an animated silmap; the root has one frame.",
    shown([Texture("silmap", [(1, NONE)], wrap=CLAMPED,
                   silmap=Silmap(5, 4, FRAME_CELLS, [1], None, cell_layers=3))],
          [sample_image(5, 4, CLAMPED, layers=3, layer_kind=2)],
          [Patch([0], place(0.25, 0.25, 0.5), source_kind=1)]))
