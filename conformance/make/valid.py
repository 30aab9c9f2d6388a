# SPDX-License-Identifier: Apache-2.0
"""The valid files: `CASES` maps a name to (what, File). A case is a function that returns a File;
its docstring is the sentence for the manifest. Families of files come from loops at the end of each
section."""

import struct

from predmake import Framed, Pred, Tile, slope, symbols, texels_of
from ztexmake import (FORMATS, IDENTITY, NONE, R8, RG8, RGB8, RGBA8, RGBA8_SRGB, FORMAT_BY_NAME, Chunk,
                      File, Image, Patch,
                      Plane, Texture, Zipmap, flat, frame, frame_header, noise, raw_block,
                      rle_block, stored_zstd)
from zstd_frames import FRAMES

CASES = {}


def add(name: str, what: str, file: File):
    assert name not in CASES, name
    CASES[name] = (what, file)


def case(function):
    """Registers a function under its name, with its docstring as the description."""
    add(function.__name__, " ".join(function.__doc__.split()), function())
    return function


# ---- first files, geometry -----------------------------------------------------------------------

SIGN = bytes.fromhex("FF0000FF 00FF00FF 0000FFFF  FFFFFFFF 000000FF 80808000")


@case
def first():
    """The file of section 1 of the specification: 3 x 2 texels, one texture called `sign`."""
    return File([Image(RGBA8_SRGB, 3, 2, alpha_mode=1, texels=lambda level, size: SIGN)],
                [Texture("sign", [(1, 0)])])


@case
def size_1x1():
    """One texel of one byte, the smallest image."""
    return File([Image(R8, 1, 1)], [Texture("", [(0, 0)])])


@case
def levels_full_5x3():
    """5 x 3 texels with all three levels: 5 x 3, 2 x 1, 1 x 1."""
    return File([Image(RGBA8, 5, 3, levels=3)])


@case
def levels_fewer_5x3():
    """5 x 3 texels with two of three possible levels."""
    return File([Image(RGBA8, 5, 3, levels=2)])


@case
def levels_full_100x37():
    """100 x 37 texels, seven levels: level 0 is a unit of its own, all others are the tail."""
    return File([Image(R8, 100, 37, levels=7, texels=flat(1, 2, 3, 4, 5, 6, 7), codec=stored_zstd)])


@case
def levels_first_two_of_300x200():
    """Two levels of nine, both above 64 texels: an image without a tail."""
    return File([Image(R8, 300, 200, levels=2, texels=flat(9, 8), codec=stored_zstd)])


@case
def tail_only_64x64():
    """64 x 64 texels, all seven levels in the tail; 64 is the largest size that may be there."""
    return File([Image(R8, 64, 64, levels=7, texels=flat(7, 6, 5, 4, 3, 2, 1), codec=stored_zstd)])


@case
def tail_none_65x1():
    """65 x 1 texels with one level: just too wide for the tail, so a unit with tiles."""
    return File([Image(R8, 65, 1)])


@case
def tail_after_65x1():
    """65 x 1 texels with seven levels: level 0 as a unit, levels 1 to 6 in the tail."""
    return File([Image(R8, 65, 1, levels=7)])


@case
def tail_exactly_262144():
    """64 x 64 x 64 bytes, one level: the tail has exactly 262,144 bytes."""
    return File([Image(R8, 64, 64, depth=64, texels=flat(5), codec=stored_zstd)])


@case
def tail_one_byte_over_262144():
    """64 x 64 x 64 bytes and more levels: the sum is above 262,144, so level 0 is a unit although
    it is small enough."""
    return File([Image(R8, 64, 64, depth=64, levels=7, texels=flat(5, 4, 3, 2, 1, 0, 9),
                       codec=stored_zstd)])


@case
def tail_pushed_up_by_layers():
    """Nine layers of 64 x 64 x 8 bytes: the layers make level 0 too large for the tail."""
    return File([Image(97, 64, 64, layers=9, levels=3, texels=flat(0, 60, 0), codec=stored_zstd)])


@case
def tail_volume_deep_128():
    """2 x 2 x 128 texels: the depth counts for the tail, so level 0 is a unit with 128 tiles."""
    return File([Image(R8, 2, 2, depth=128, levels=8)])


@case
def tiles_edge_16_clipped():
    """100 x 37 texels in tiles of 16 x 16: 21 tiles, those at the right 4 wide, at the bottom 5
    high."""
    return File([Image(R8, 100, 37, tile_log2=4)])


@case
def tiles_many():
    """257 x 130 texels in tiles of 16 x 16: 17 x 9 tiles, most zstd, some raw."""
    texels = lambda level, size: bytes(size - 600) + noise(600, 3)
    return File([Image(R8, 257, 130, tile_log2=4, texels=texels, codec=stored_zstd)])


@case
def tiles_raw_and_zstd_mixed():
    """Tiles alternate between codec raw and zstd within one unit."""
    codec = lambda level, tile, data: stored_zstd(level, tile, data) if tile % 2 else (0, data)
    return File([Image(R8, 130, 20, tile_log2=4, texels=flat(33), codec=codec)])


@case
def tiles_of_blocks():
    """A block format of 300 x 20 texels is 75 x 5 blocks; the tile edge of 16 counts blocks: five
    tiles."""
    return File([Image(FORMAT_BY_NAME["BC1_RGB_UNORM_BLOCK"], 300, 20, tile_log2=4, texels=flat(17),
                       codec=stored_zstd)])


@case
def tiles_of_astc_12x12():
    """205 x 13 texels of ASTC 12x12 are 18 x 2 blocks: two tiles, the second two blocks wide."""
    return File([Image(FORMAT_BY_NAME["ASTC_12x12_UNORM_BLOCK"], 205, 13, tile_log2=4, levels=8,
                       texels=flat(*range(8)), codec=stored_zstd)])


@case
def tiles_of_unknown_format():
    """40 x 80 texels of an unknown format with blocks of 2 x 3 texels and 5 bytes: 20 x 27 blocks
    in four tiles."""
    return File([Image(1000, 40, 80, block=(2, 3, 5), tile_log2=4, texels=flat(8),
                       codec=stored_zstd)])


@case
def tiles_log2_16():
    """tile_log2 16, the largest: the level is one tile."""
    return File([Image(R8, 70, 3, tile_log2=16)])


@case
def width_1048576():
    """2^20 x 1 texels, the largest width, all 21 levels, in tiles of 2^16."""
    return File([Image(R8, 1 << 20, 1, levels=21, tile_log2=16, texels=flat(*range(1, 22)),
                       codec=stored_zstd)])


@case
def height_1048576():
    """1 x 2^20 texels, the largest height, one level."""
    return File([Image(R8, 1, 1 << 20, tile_log2=16, texels=flat(1), codec=stored_zstd)])


@case
def layers_65536():
    """1 x 1 texels in 2^16 layers, the largest number."""
    return File([Image(R8, 1, 1, layers=1 << 16, texels=flat(1), codec=stored_zstd)])


@case
def volume_5x4x3():
    """A volume with three levels."""
    return File([Image(RGBA8, 5, 4, depth=3, levels=3)],
                [Texture("volume", [(0, 0)], wrap=(0, 1, 2))])


@case
def volume_tiled():
    """A volume of 70 x 20 x 3 texels: 5 x 2 tiles a slice."""
    return File([Image(R8, 70, 20, depth=3, tile_log2=4, levels=2, texels=flat(1, 2),
                       codec=stored_zstd)])


@case
def array_3_layers():
    """A 2-D array of three layers with levels."""
    return File([Image(RGBA8, 4, 4, layers=3, levels=3)])


@case
def array_tiled():
    """An array of two layers of 65 x 3 texels, tiles numbered layer by layer."""
    return File([Image(R8, 65, 3, layers=2, tile_log2=6)])


@case
def array_of_volumes():
    """Two layers, each a volume of 3 x 2 x 2: layers outside, slices inside."""
    return File([Image(R8, 3, 2, depth=2, layers=2, levels=2)])


@case
def array_of_volumes_tiled():
    """Two layers of 65 x 2 x 2 texels: tiles of layer 0 slice 0, layer 0 slice 1, layer 1 ..."""
    return File([Image(R8, 65, 2, depth=2, layers=2, tile_log2=6)])


@case
def cube():
    """A cube: six square faces with levels."""
    return File([Image(RGBA8_SRGB, 4, 4, layers=6, layer_kind=1, levels=3)])


@case
def cube_array():
    """Two cubes: twelve faces."""
    return File([Image(R8, 2, 2, layers=12, layer_kind=1)])


@case
def frames():
    """An animation of four frames."""
    return File([Image(RGBA8_SRGB, 3, 3, layers=4, layer_kind=2)], [Texture("animation", [(1, 0)])])


# ---- tiles of codec 2, "pred" --------------------------------------------------------------------

def picture(fmt: int, w: int, h: int, depth: int = 1, layers: int = 1, wobble: int = 2,
            opaque: bool = False, flat_until: int = 0):
    """texels() of slopes with a little noise, the same for formats of 8 and 16 bits. `opaque`: the
    last channel is constant. Columns below `flat_until` have no noise."""
    known = FORMATS[fmt]
    n = known.channels
    size = known.block_bytes // n

    def texels(level, total):
        out = bytearray()
        lw, lh, ld = (max(1, v >> level) for v in (w, h, depth))
        dots = iter(noise(lw * lh * ld * layers * n, 77 + level))
        for s in range(ld * layers):
            for y in range(lh):
                for x in range(lw):
                    for c in range(n):
                        dot = next(dots) % wobble if x >= flat_until else 0
                        v = (40 + 3 * s + x + 2 * y + 50 * c) * (1 if size == 1 else 37) + dot
                        if opaque and c == n - 1:
                            v = -1
                        out += (v & (1 << 8 * size) - 1).to_bytes(size, "little")
        return bytes(out)
    return texels


def pred(fmt: int, w: int, h: int, texels=None, depth: int = 1, layers: int = 1, levels: int = 1,
         tile_log2: int = 8, choose=None, **how) -> Image:
    """An image whose tiles have codec 2. Where that is not smaller, as [R5202] asks, or where
    `choose(level, tile)` is false, the tile is zstd or raw; tails always are."""
    known = FORMATS[fmt]
    coding = Pred(known.channels, known.block_bytes // known.channels, **how)
    more = {"levels": levels, "tile_log2": tile_log2, "depth": depth, "layers": layers}
    image = Image(fmt, w, h, texels=texels or picture(fmt, w, h, depth, layers), **more)

    def codec(level, tile, data):
        if level != "tail" and (choose is None or choose(level, tile)):
            coded = Tile(coding, *image.tile_size(level, tile), data)
            if len(coded.build()) < len(data):
                return 2, coded
        return stored_zstd(level, tile, data)
    image.codec = codec
    return image


def from_residuals(fmt: int, w: int, h: int, residuals, first: list = None, **how) -> Image:
    """A one-tile image with residuals(channel, x, y); without the colour bit."""
    n = FORMATS[fmt].channels
    size = FORMATS[fmt].block_bytes // n
    first = first or [10 * (c + 1) for c in range(n)]
    data = texels_of(residuals, w, h, n, size, first)
    return pred(fmt, w, h, texels=lambda level, total: data, first=first, **how)


# The example of section 6.4 is the last tile of 16 x 16 of this image.
EXAMPLE_GREEN = """03E8 0415 0441 0461 048B 04B4 04DC 0503   03F2 041F 0440 046B 0495 04BE 04E6 050D
                   03F7 0424 0450 0470 049A 04C3 04EB 0512   0402 042F 0450 047B 04A5 04CE 04F6 051D"""
EXAMPLE_TABLES = [{0: 614, 1: 256, 2: 154, 5: 308, 6: 358, 64: 52, 78: 51, 80: 51, 82: 51, 84: 51,
                   88: 51, 90: 51}, {0: 85, 1: 85, 10: 598, 20: 512, 22: 683, 32: 85}]


@case
def pred_example():
    """The example of section 6.4 of the specification: it is the last of five tiles."""
    green = [int(v, 16) for v in EXAMPLE_GREEN.split()]
    tile = b"".join(struct.pack("<4H", g + 300 + (3 * x + y) % 4, g, g - 100, 0x3C00)
                    for y in range(4) for x in range(8) for g in [green[8 * y + x]])
    rows = [bytes(64 * 8) + tile[64 * y:64 * y + 64] for y in range(4)]
    return File([pred(97, 72, 4, texels=lambda level, size: b"".join(rows), tile_log2=4,
                      choose=lambda level, tile: tile == 4, colour=True, tables=EXAMPLE_TABLES,
                      maps=[[0, 0, 1, 1, 1, 1, 1, 1] + [0] * 8, [0] * 16])])


for number in (9, 15, 16, 22, 23, 29, 37, 43, 70, 76, 77, 83, 84, 90, 91, 97):
    fmt = FORMATS[number]
    add("pred_%s" % fmt.name.lower(), "Codec pred, %s, 65 x 16 texels in one tile." % fmt.name,
        File([pred(number, 65, 16, table_count=2)]))
    if fmt.channels >= 3:
        add("pred_%s_colour" % fmt.name.lower(),
            "Codec pred with the colour bit, %s, 65 x 16 texels in one tile." % fmt.name,
            File([pred(number, 65, 16, table_count=2, colour=True)]))

for code in range(3):
    add("pred_lanes_%d" % (16 << code), "Lane code %d: more columns than lanes." % code,
        File([pred(RGBA8, 130, 9, lane_code=code, colour=True)]))
    add("pred_lanes_%d_narrow" % (16 << code),
        "Lane code %d and four tiles of 16 columns: with more lanes some are not used." % code,
        File([pred(91, 66, 8, lane_code=code, tile_log2=4, colour=True)]))
for count in (1, 3, 8):
    add("pred_tables_%d" % count, "table_count %d, channels of 8 bits." % count,
        File([pred(RGBA8, 70, 12, texels=picture(RGBA8, 70, 12, wobble=14), table_count=count)]))
    add("pred_tables_%d_16_bit" % count, "table_count %d, channels of 16 bits." % count,
        File([pred(77, 70, 12, texels=picture(77, 70, 12, wobble=800), table_count=count)]))


# Residuals of every magnitude, mostly small, so that all 16 activities occur.
SPREAD = noise(1 << 14, 5)


def spread(c, x, y):
    v = SPREAD[(c * 67 + x + 131 * y) % len(SPREAD)]
    return v >> 1 + (x // 8) % 7 if v % 3 else -(v >> 1 + (x // 8) % 7)


def spread_16(c, x, y):
    return spread(c, x, y) << (x // 8 + y // 4) % 9


@case
def pred_activities():
    """Residuals whose size changes from place to place: every activity with a table of its own for
    two activities, three channels of 8 bits."""
    return File([from_residuals(RGB8, 65, 16, spread, table_count=8)])


@case
def pred_activities_16_bit():
    """The same with 16 bits: high and low bytes, activity 15 of the low byte."""
    return File([from_residuals(84, 65, 10, spread_16, table_count=8)])


@case
def pred_maps_differ():
    """Maps that are not monotonic and differ between the planes; table 2 is not used by any."""
    maps = [[(a * k + 3 * (a % 2)) % 5 for a in range(16)] for k in (1, 3, 7)]
    maps = [[4 if t == 2 else t if t != 4 else 3 for t in m] for m in maps]
    return File([from_residuals(RGB8, 65, 16, spread, table_count=5, maps=maps)])


@case
def pred_extreme_residuals():
    """Residuals -128, 127, 1, 0 and -1 of 8 bits."""
    values = (-128, 127, 0, 1, -1, 0, 0, -128)
    return File([from_residuals(RG8, 70, 9, lambda c, x, y: values[SPREAD[c + 2 * x + 151 * y] % 8],
                                table_count=2)])


@case
def pred_extreme_residuals_16_bit():
    """Residuals -32768, 32767, 0, 127, 128 and -128 of 16 bits: zigzag 65535, 65534, 0, 254, 256,
    255."""
    values = (-32768, 32767, 0, 127, 128, -128, 0, 0)
    return File([from_residuals(77, 70, 9, lambda c, x, y: values[SPREAD[c + 2 * x + 151 * y] % 8],
                                table_count=2)])


@case
def pred_residual_at_origin():
    """The texel (0, 0) differs from `first` by its residual."""
    return File([pred(97, 65, 4, first=[0, 0xFFFF, 0x8000, 1], colour=True)])


@case
def pred_half_nan():
    """NaN, infinities and negative zero of half floats are numbers like others to the codec."""
    values = struct.pack("<8H", 0x7E01, 0xFC00, 0x7C00, 0x8000, 0x7FFF, 0xFFFF, 0, 1)
    return File([pred(76, 80, 10, texels=lambda level, size: values * 100)])


@case
def pred_zero_map():
    """A zero map: 130 x 20 texels are 3 x 3 blocks, at the right 2 wide, at the bottom 4 high;
    those at the left are coded in the
    first plane only."""
    texels = picture(RGB8, 130, 20, flat_until=100)
    return File([pred(RGB8, 130, 20, texels=texels, colour=True, zero_map=True, table_count=2)])


@case
def pred_zero_map_16_bit():
    """A zero map of 16 bits: high bytes are coded in one block only."""
    rare = lambda c, x, y: 5000 if (x, y) == (66, 9) else SPREAD[x + 70 * y] % 3 if x > 63 else 0
    return File([from_residuals(77, 70, 20, rare, zero_map=True, planes=[0, 1, 2, 3],
                                table_count=2)])


@case
def pred_zero_map_all_coded():
    """A zero map whose bits are all one."""
    return File([pred(RGB8, 65, 16, zero_map=True)])


@case
def pred_zero_map_nothing_coded():
    """A coded plane whose zero map calls every block zero: no sample is coded, all states are
    2^15."""
    return File([from_residuals(R8, 70, 20, lambda c, x, y: 0, zero_map=True, planes=[0])])


@case
def pred_zero_map_then_activity():
    """The blocks below a zero block and to the right of one: their activities see zeros there."""
    some = lambda c, x, y: spread(c, x, y) if (x // 64 + y // 8) % 2 else 0
    return File([from_residuals(RG8, 140, 20, some, zero_map=True, table_count=8)])


@case
def pred_coded_plane_of_zeros():
    """A plane that is coded though all its samples are zero."""
    return File([pred(RGBA8, 65, 9, texels=picture(RGBA8, 65, 9, opaque=True),
                      planes=[0, 1, 2, 3])])


@case
def pred_opaque():
    """Opaque alpha: plane 3 is not coded."""
    return File([pred(RGBA8_SRGB, 65, 16, texels=picture(RGBA8_SRGB, 65, 16, opaque=True),
                      colour=True)])


@case
def pred_opaque_16_bit():
    """Opaque alpha of 16 bits, and small differences: high bytes and planes 6 and 7 are not
    coded."""
    return File([pred(91, 65, 9, texels=picture(91, 65, 9, opaque=True), colour=True)])


@case
def pred_first_plane_not_coded():
    """Only the second and the third plane are coded; the first counts as zero in the activities."""
    some = lambda c, x, y: 0 if c == 1 else spread(c, x, y)
    return File([from_residuals(RGB8, 65, 9, some, table_count=4)])


for number, colour in ((R8, False), (RGBA8, False), (RGBA8, True), (97, True)):
    add("pred_no_plane_%d%s" % (number, "_colour" if colour else ""),
        "No plane is coded: one colour, the tile ends behind `first`. Format %d%s."
        % (number, ", colour bit" if colour else ""),
        File([pred(number, 65, 3, texels=lambda level, size, number=number:
                   b"\x12\x34\x56\x78\x9a\xbc\xde\xf0"[:FORMATS[number].block_bytes] * (65 * 3),
                   colour=colour)]))


@case
def pred_no_words():
    """All residuals are 1: a table of one symbol with frequency 2048, no words."""
    return File([from_residuals(RGB8, 65, 9, lambda c, x, y: 1)])


@case
def pred_no_words_lanes_64():
    """All residuals are -32768; 64 lanes, no words."""
    return File([from_residuals(84, 65, 9, lambda c, x, y: -32768, lane_code=2)])


ONE_IN_16 = lambda x, y: (x + 5 * y) % 16 == 3


@case
def pred_table_steps():
    """Frequencies 2047, 0, 1 and 0, 2047, 1: z is 22 and 21, K goes from 0 to 11 and back."""
    tables = [{0: 2047, 1: 1}, {255: 2047, 1: 1}]
    return File([from_residuals(RG8, 65, 9, lambda c, x, y: 1 if ONE_IN_16(x, y) else -c, tables=tables,
                                maps=[[0] * 16, [1] * 16])])


@case
def pred_table_256_symbols():
    """A table of 256 symbols with frequency 8 each, complete with the 256th."""
    return File([from_residuals(R8, 80, 40, lambda c, x, y: 2 * (x % 64) + (y * 3) % 128 - 128
                                if x < 64 and y < 8 else 0, zero_map=True,
                                tables=[{s: 8 for s in range(256)}])])


@case
def pred_table_last_symbol():
    """All 2048 on the last symbol, -128 of 8 bits: 255 frequencies of zero before."""
    return File([from_residuals(R8, 65, 9, lambda c, x, y: -128, planes=[0])])


@case
def pred_table_last_symbol_16_bit():
    """A table for 16 bits with the symbol 255 as the last, and frequencies of 1 in between."""
    table = {0: 1024, 254: 1, 255: 1023}
    return File([from_residuals(70, 65, 16, lambda c, x, y: (0, -128, 0, 0)[(x + y) % 4],
                                tables=[table], planes=[1])])


@case
def pred_table_frequencies():
    """A table with frequencies around powers of two: 1, 2, 3, 6, 7, 8, 14, 15, 16 ... and zeros."""
    values = [1, 2, 3, 6, 7, 8, 0, 14, 15, 16, 30, 0, 0, 31, 32, 62, 63, 64, 126, 127, 128, 254, 255,
              256]
    table = dict(zip(symbols(1), values))
    table[symbols(1)[len(values)]] = 2048 - sum(values)
    usable = [s for s, f in table.items() if f]
    return File([from_residuals(R8, 80, 20, lambda c, x, y: usable[SPREAD[x + 80 * y]
                                % len(usable)], tables=[table])])


@case
def pred_tiles_16():
    """100 x 70 texels in tiles of 16 x 16, those at the right 4 wide, at the bottom 6 high; where
    pred is not smaller, tiles are raw."""
    return File([pred(R8, 100, 70, tile_log2=4, texels=picture(R8, 100, 70, wobble=1))])


@case
def pred_tiles_80x65():
    """80 x 65 texels in tiles of 64 x 64: the tiles at the bottom are one row high."""
    return File([pred(RGB8, 80, 65, tile_log2=6, texels=picture(RGB8, 80, 65, flat_until=60),
                      colour=True, zero_map=True)])


@case
def pred_tiles_1_wide():
    """17 x 66 texels of 8 bytes in tiles of 16 x 16: tiles one texel wide."""
    return File([pred(91, 17, 66, tile_log2=4, colour=True, texels=picture(91, 17, 66, wobble=1))])


@case
def pred_one_row():
    """200 x 1 texels in tiles of 128 and 72: a level of one row."""
    return File([pred(RGBA8, 200, 1, tile_log2=7)])


@case
def pred_65x3():
    """65 x 3 texels in tiles of 64 x 3 and 1 x 3."""
    return File([pred(97, 65, 3, tile_log2=6)])


# Normal maps, and vectors that no unit vector is.
def normal_map(w: int, h: int, n: int):
    def texels(level, total):
        out = bytearray()
        for y in range(h):
            for x in range(w):
                out += bytes((128 + 9 * (x % 11) - 40, 128 - 7 * (y % 9) + x // 16,
                              (250 - (x + y) % 7 if x < w - 5 else 50 * x) & 255, 255 - y)[:n])
        return bytes(out)
    return texels


def every_slope(level, total):
    """Channels 0 and 1 take each pair of values once; channel 2 is 128 more than its slope."""
    return bytes(v for y in range(256) for x in range(256)
                 for v in (x, y, slope(x, y) + 128 & 255))


add("pred_normal_rgb8", "Codec pred with the normal bit, R8G8B8_UNORM.",
    File([pred(RGB8, 65, 16, texels=normal_map(65, 16, 3), normal=True, table_count=2)]))
add("pred_normal_rgba8", "Codec pred with the normal bit and a zero map, R8G8B8A8_UNORM.",
    File([pred(RGBA8, 130, 18, texels=normal_map(130, 18, 4), normal=True, zero_map=True)]))
add("pred_normal_srgb", "The normal bit is about bytes: the format is R8G8B8A8_SRGB.",
    File([pred(RGBA8_SRGB, 65, 16, normal=True)]))
add("pred_normal_every_pair", "All pairs of the channels 0 and 1 with the normal bit.",
    File([pred(RGB8, 256, 256, texels=every_slope, normal=True, table_count=1, zero_map=True)]))
add("pred_normal_no_plane", "No plane is coded, and the normal bit is set.",
    File([pred(RGB8, 65, 3, texels=lambda level, total: b"\x70\x90\xF8" * 195, normal=True)]))


# ---- tiles of codec 2 with a frame ----

def framed(fmt: int, w: int, h: int, texels=None, tile_log2: int = 8, depth: int = 1,
           layers: int = 1, pack=frame, choose=None, **how) -> Image:
    """An image whose tiles have codec 2 with a frame where that is smaller, else codec 1 or 0."""
    known = FORMATS[fmt]
    coding = Framed(known.channels, known.block_bytes // known.channels, pack=pack, **how)
    image = Image(fmt, w, h, texels=texels or stripes(fmt, w, h), tile_log2=tile_log2, depth=depth,
                  layers=layers)

    def codec(level, tile, data):
        coded = coding.tile(*image.tile_size(level, tile), data)
        if (choose is None or choose(tile)) and len(coded.build()) < len(data):
            return 2, coded
        return stored_zstd(level, tile, data)
    image.codec = codec
    return image


def stripes(fmt: int, w: int, h: int):
    """Runs in every form: blocks of 40 columns and 6 rows, each a step from the one before."""
    known = FORMATS[fmt]
    n, size = known.channels, known.block_bytes // known.channels

    def texels(level, total):
        value = lambda x, y, c: (x // 40 * 531 + y // 6 * 77 + c * 9) * (1 if size == 1 else 97)
        one = b"".join((value(x, y, c) & (1 << 8 * size) - 1).to_bytes(size, "little")
                       for y in range(h) for x in range(w) for c in range(n))
        return one * (total // len(one))
    return texels


FORM_NAMES = ("none", "left", "above")
for number in (9, 16, 23, 37, 70, 77, 84, 97):
    fmt = FORMATS[number]
    for predictor, name in enumerate(FORM_NAMES):
        add("pred_frame_%s_%s" % (fmt.name.lower(), name),
            "Codec pred with a frame, plane by plane, predictor %s, %s." % (name, fmt.name),
            File([framed(number, 90, 20, predictor=predictor)]))
for number in (9, 23, 37, 97):
    fmt = FORMATS[number]
    blocks_of_one = lambda level, total: bytes(total // 2) + b"\7" * (total - total // 2)
    for predictor, name in enumerate(FORM_NAMES):
        add("pred_frame_%s_%s_by_texel" % (fmt.name.lower(), name),
            "Codec pred with a frame, texel by texel, predictor %s, %s." % (name, fmt.name),
            File([framed(number, 90, 20, texels=blocks_of_one, predictor=predictor,
                         by_texel=True)]))
for number, by_texel in ((23, False), (37, True), (91, False), (97, True)):
    add("pred_frame_colour_%s%s" % (FORMATS[number].name.lower(), "_by_texel" if by_texel else ""),
        "A frame and the colour bit, %s." % FORMATS[number].name,
        File([framed(number, 90, 20, predictor=2, colour=True, by_texel=by_texel)]))
for predictor, name in enumerate(FORM_NAMES):
    add("pred_frame_normal_" + name, "A frame and the normal bit, predictor %s." % name,
        File([framed(RGBA8, 90, 20, predictor=predictor, normal=True)]))
add("pred_frame_1x300", "One column: its texels follow from the ones above with predictor 1, too.",
    File([framed(RGB8, 1, 300, texels=lambda level, total: b"\1\2\3" * 300, predictor=1)]))
add("pred_frame_tiles", "Tiles of 32 x 32, narrower ones at the right and at the bottom, some of "
    "them raw.", File([framed(RGBA8, 90, 70, tile_log2=5, predictor=2,
                               choose=lambda tile: tile % 3 != 1)]))
add("pred_frame_volume", "Slices of a volume with frames.",
    File([framed(R8, 90, 20, depth=3, predictor=1)]))
add("pred_frame_array", "Layers with frames.", File([framed(77, 90, 20, layers=2, predictor=2)]))
GRADIENT_TEXELS, GRADIENT_FRAME = map(bytes.fromhex, FRAMES["tile"])
add("pred_frame_encoder", "A frame of compressed blocks: residuals without a prediction, texel by "
    "texel.", File([framed(RGBA8, 128, 8, texels=lambda level, total: GRADIENT_TEXELS,
                           by_texel=True, pack=lambda samples: GRADIENT_FRAME)]))


@case
def pred_tiles_mixed():
    """Tiles raw, zstd and pred in one level."""
    image = pred(RG8, 100, 20, tile_log2=4)
    right = image.codec
    image.codec = lambda level, tile, data: ((0, data), stored_zstd(level, tile, data),
        right(level, tile, data))[tile % 3]
    plain = image.texels
    image.texels = lambda level, size: bytes(v if (k // 2 % 100) // 16 % 3 != 1 else 9
                                             for k, v in enumerate(plain(level, size)))
    return File([image])


@case
def pred_levels_and_tail():
    """140 x 70 texels with all levels: two levels of pred tiles and a tail, which never is."""
    texels = picture(R8, 140, 70, wobble=1)
    return File([pred(R8, 140, 70, texels=texels, levels=8, tile_log2=5)])


@case
def pred_volume():
    """A volume of 65 x 8 x 2 texels: each slice is a tile of its own."""
    return File([pred(RGBA8, 65, 8, depth=2)])


@case
def pred_array():
    """An array of two layers of 65 x 8 texels."""
    return File([pred(RGB8, 65, 8, layers=2, colour=True)])


@case
def pred_array_of_volumes():
    """Two layers of 66 x 5 x 2 texels in tiles of 32 x 32."""
    return File([pred(97, 66, 5, depth=2, layers=2, tile_log2=5, colour=True,
                      texels=picture(97, 66, 5, 2, 2, wobble=1))])


@case
def pred_cube():
    """Six square faces of 65 x 65 texels of one colour each."""
    image = pred(RGBA8, 65, 65, layers=6, texels=lambda level, size: b"".join(
        bytes([40 * k, 10, k, 255]) * (65 * 65) for k in range(6)))
    image.layer_kind = 1
    return File([image])


# ---- formats, colour -----------------------------------------------------------------------------

for number, fmt in FORMATS.items():
    if fmt.block_width == 1:
        add("format_%d_%s" % (number, fmt.name.lower()),
            "A 3 x 2 image of %s, two levels." % fmt.name,
            File([Image(number, 3, 2, levels=2)]))

for name in ("BC1_RGB_UNORM_BLOCK", "BC3_SRGB_BLOCK", "BC4_SNORM_BLOCK", "BC6H_UFLOAT_BLOCK",
             "BC7_UNORM_BLOCK",
             "ETC2_R8G8B8A1_SRGB_BLOCK", "EAC_R11G11_UNORM_BLOCK", "ASTC_4x4_UNORM_BLOCK",
             "ASTC_5x4_SRGB_BLOCK",
             "ASTC_8x5_UNORM_BLOCK", "ASTC_12x12_UNORM_BLOCK"):
    number = FORMAT_BY_NAME[name]
    add("format_%d_%s" % (number, name.lower()),
        "A 13 x 9 image of %s, two levels; partial blocks at the edges." % name,
        File([Image(number, 13, 9, levels=2)]))


@case
def format_unknown_number():
    """A format number that the registry does not have, 1000, with a texel block of 5 x 3 texels and
    7 bytes."""
    return File([Image(1000, 13, 9, levels=2, block=(5, 3, 7))])


@case
def format_unknown_limits():
    """An unknown format number with the largest texel block, 16 x 16 texels and 64 bytes; number
    2^32 - 1."""
    return File([Image(0xFFFFFFFF, 33, 1, block=(16, 16, 64))])


@case
def float_nan_texels():
    """NaN, infinities and negative zero are texels like others."""
    values = struct.pack("<6I", 0x7FC00000, 0xFFC00001, 0x7F800001, 0x7F800000, 0xFF800000,
                         0x80000000)
    return File([Image(100, 3, 2, texels=lambda level, size: values)])


@case
def half_nan_texels():
    """NaN and infinity in a half float format."""
    values = struct.pack("<4H", 0x7E01, 0xFC00, 0x7C00, 0x8000)
    return File([Image(76, 2, 2, texels=lambda level, size: values)])


for mode, word in enumerate(("none", "straight", "premultiplied")):
    add("alpha_%s" % word, "alpha_mode %d." % mode, File([Image(RGBA8, 2, 2, alpha_mode=mode)]))

add("alpha_unknown_format",
    "An unknown format with alpha_mode 1: a reader cannot know that it has no alpha.",
    File([Image(999, 2, 2, block=(1, 1, 4), alpha_mode=1)]))

for primaries, transfer in ((2, 2), (4, 4), (5, 5), (6, 6), (7, 7), (8, 9), (9, 16), (10, 17),
                            (11, 18), (12, 13), (22, 1),
                            (1, 10), (1, 11), (1, 12), (1, 14), (1, 15), (9, 18)):
    add("cicp_%d_%d" % (primaries, transfer),
        "Colour primaries %d, transfer characteristics %d." % (primaries, transfer),
        File([Image(RGBA8, 1, 1, primaries=primaries, transfer=transfer)]))


# ---- units ---------------------------------------------------------------------------------------

@case
def units_interleaved():
    """Four images of different sizes: tails first, then the units by size, not image by image."""
    return File([Image(R8, 300, 1, levels=9, seed=1, texels=flat(1), codec=stored_zstd),
                 Image(R8, 65, 66, levels=2, seed=2, texels=flat(2), codec=stored_zstd),
                 Image(R8, 2, 2, levels=2, seed=3), Image(R8, 1, 130, levels=1, seed=4)])


@case
def units_same_size():
    """Three images of equal size: equal c, in the order of the images."""
    return File([Image(R8, 66, 1, levels=7, seed=s) for s in (1, 2, 3)])


@case
def units_c_of_npot():
    """127 and 128 texels differ in c, 128 and 255 do not: floor(log2)."""
    return File([Image(R8, 255, 1, seed=1), Image(R8, 128, 1, seed=2), Image(R8, 127, 1, seed=3)])


@case
def images_40():
    """Forty images of one texel each, one of them in no texture."""
    return File([Image(R8, 1, 1, seed=s) for s in range(40)],
                [Texture("t%d" % s, [(0, s)]) for s in range(39)])


# ---- textures ------------------------------------------------------------------------------------

@case
def texture_layers():
    """A material: base colour, normal and roughness share one size."""
    return File([Image(RGBA8_SRGB, 4, 4), Image(RG8, 4, 4, seed=2),
                 Image(R8, 4, 4, levels=3, seed=3)],
                [Texture("material", [(1, 0), (2, 1), (4, 2)])])


@case
def texture_layers_32():
    """32 layers, the largest number, all of them the same image."""
    return File([Image(R8, 1, 1)], [Texture("many", [(0x8000 + k, 0) for k in range(32)])])


@case
def texture_two_share_an_image():
    """Two textures with the same image and different wrap modes."""
    return File([Image(R8, 2, 2)], [Texture("a", [(0, 0)]), Texture("b", [(0, 0)], wrap=(2, 2, 2))])


@case
def texture_unnamed_twice():
    """Empty names need not differ."""
    return File([Image(R8, 1, 1)], [Texture("", [(0, 0)]), Texture("", [(0, 0)])])


@case
def texture_name_255():
    """A name of 255 bytes, the longest."""
    return File([Image(R8, 1, 1)], [Texture("n" * 255, [(0, 0)])])


@case
def texture_names_utf8():
    """Names with characters of one to four bytes, among them the first and last of each length and
    U+0080."""
    names = ["Stra\u00dfe", "\u6728\u76ee", "\U0001F9F1", "\u0080\u07ff",
             "\u0800\ud7ff\ue000\uffff", "\U00010000\U0010ffff", "~ "]
    return File([Image(R8, 1, 1)], [Texture(n, [(0, 0)]) for n in names])


@case
def texture_wrap_modes():
    """All four wrap modes in every direction."""
    return File([Image(R8, 2, 2, depth=2)], [Texture("w%d" % m, [(0, 0)],
        wrap=(m, (m + 1) % 4, (m + 2) % 4)) for m in range(4)])


@case
def texture_semantic_unknown():
    """A semantic that the registry does not have; a reader passes the number on."""
    return File([Image(R8, 1, 1)], [Texture("s", [(77, 0), (0xFFFF, 0)])])


@case
def texture_layers_differ_in_levels():
    """Layers of one texture may differ in format, levels, tile size and colour."""
    return File([Image(RGBA8_SRGB, 4, 4, levels=3, tile_log2=4), Image(83, 4, 4, levels=1, seed=2)],
                [Texture("m", [(1, 0), (2, 1)])])


# ---- metadata, chunks ----------------------------------------------------------------------------

META = [("my.key", "value"), ("zt.author", "A. Author"), ("zt.title", "Brick wall \u58c1")]


def dot(**more) -> File:
    """A file with one texel, for cases about something else."""
    return File([Image(R8, 1, 1)], [Texture("dot", [(0, 0)])], **more)


add("meta_raw", "Three pairs of metadata.", dot(meta=META))
add("meta_zstd", "Metadata with chunk codec zstd (raw and RLE blocks).",
    dot(meta=[("zt.comment", "ha" + "!" * 300)], codec={"META": 1}))
add("meta_zstd_encoder", "Metadata in a frame of compressed blocks, as a zstd encoder makes it.",
    dot(meta=FRAMES["meta"][0], codec={"META": (1, bytes.fromhex(FRAMES["meta"][1]))}))
add("meta_empty_value",
    "A value may be empty and may have line ends and other control characters but U+0000.",
    dot(meta=[("a.empty", ""), ("a.lines", "one\r\ntwo\tthree\x01\x7f")]))
add("meta_key_255", "A key of 255 bytes and keys of which one is the beginning of another.",
    dot(meta=[("k", "1"), ("k" * 254, "2"), ("k" * 255, "3")]))
add("meta_keys_byte_order", "Keys in byte order, which is not alphabetical order of languages.",
    dot(meta=[("B.x", ""), ("a.x", ""), ("\u00e4.x", ""), ("\uffff.x", ""), ("\U00010000.x", "")]))
REGISTERED = "author comment copyright license source title writer xmp".split()
add("meta_all_registered", "Every key that the registry names.",
    dot(meta=[("zt." + k, "x") for k in REGISTERED]))
add("meta_version_2",
    "A META chunk of version 2: ancillary, so a reader skips it, whatever it holds.",
    dot(extra=[], meta=[("k", "v")], overrides={"entry.META.version": 2,
                                                "decoded.META": noise(40, 5)}))
add("chunk_unknown_safe", "An unknown ancillary chunk that is safe to copy.",
    dot(extra=[Chunk("XFOO", noise(21, 1), flags=2)]))
add("chunk_unknown_unsafe", "An unknown ancillary chunk that is not safe to copy.",
    dot(extra=[Chunk("XFOO", noise(16, 1), flags=0)]))
add("chunk_unknown_zstd", "An unknown ancillary chunk with codec zstd.",
    dot(extra=[Chunk("XFOO", bytes(5000), codec=1, flags=2)]))
add("chunk_unknown_version_65535", "An unknown ancillary chunk of version 65,535.",
    dot(extra=[Chunk("XFOO", b"\0", flags=2, version=65535)]))
add("chunk_unknown_several",
    "Metadata and four unknown chunks in byte order of their types: digits before letters.",
    dot(meta=META, extra=[Chunk(t, noise(5, 2), flags=2) for t in ("0000", "9ZZZ", "AAAA",
        "ZZZZ")]))
add("chunk_unknown_30", "Thirty unknown chunks.",
    dot(extra=[Chunk("X%03d" % k, b"x", flags=2) for k in range(30)]))
add("minor_7", "Minor version 7: a reader of 1.0 reads on.", dot(minor=7))
add("minor_65535", "The largest minor version.", dot(minor=65535))
add("texs_zstd", "TEXS with codec zstd.", File([Image(R8, 1, 1)], [Texture("a" * 200, [(0, 0)])],
                                               codec={"TEXS": 1}))
add("imag_zstd_encoder", "IMAG in a frame of compressed blocks: twenty equal images.",
    File([Image(R8, 1, 1)] * 20, [Texture("t", [(0, 19)])],
         codec={"IMAG": (1, bytes.fromhex(FRAMES["imag"][1]))}))
add("texs_zstd_encoder", "TEXS in a frame of compressed blocks, as a zstd encoder makes it.",
    File([Image(R8, 1, 1)], [Texture("texture number %d" % k, [(0, 0)]) for k in range(30)],
         codec={"TEXS": (1, bytes.fromhex(FRAMES["texs"][1]))}))

# ---- zstd profile --------------------------------------------------------------------------------

RUN = bytes([65]) * 300


def run_file(stored: bytes, data: bytes = RUN) -> File:
    """An unknown chunk of 300 equal bytes, in a frame of the case's own."""
    return dot(extra=[Chunk("XRUN", data, codec=1, flags=2, stored=stored)])


add("zstd_fcs_4_bytes", "Frame content size in four bytes though two would do.",
    run_file(frame(RUN, 4)))
add("zstd_fcs_8_bytes", "Frame content size in eight bytes though two would do.",
    run_file(frame(RUN, 8)))
add("zstd_fcs_2_bytes_256", "A content of exactly 256 bytes, the smallest that two bytes can say.",
    run_file(frame(RUN[:256], 2), RUN[:256]))
add("zstd_fcs_1_byte_255", "A content of 255 bytes, the largest that one byte can say.",
    run_file(frame(RUN[:255], 1), RUN[:255]))
add("zstd_two_rle_blocks", "Two RLE blocks.", run_file(frame_header(300) + rle_block(65,
    1) + rle_block(65, 299, True)))
add("zstd_empty_last_block", "The last block is a raw block of no bytes.",
    run_file(frame_header(300) + rle_block(65, 300) + raw_block(b"", True)))
add("zstd_block_131072", "An RLE block of 131,072 bytes, the largest size.",
    run_file(frame(bytes(131072)), bytes(131072)))
add("zstd_block_131072_twice", "A content of 131,073 bytes needs a second block.",
    run_file(frame(bytes(131073)), bytes(131073)))
add("zstd_one_byte_smaller", "A frame that saves exactly one byte.",
    run_file(frame(RUN[:11], 1), RUN[:11]))
add("tile_zstd_encoder", "A 32 x 32 gradient whose tile is a frame as a zstd encoder makes it.",
    File([Image(RGBA8, 32, 32, texels=lambda level, size: bytes.fromhex(FRAMES["tile"][0]),
                codec=lambda level, tile, data: (1, bytes.fromhex(FRAMES["tile"][1])))]))


# ---- zipmaps -------------------------------------------------------------------------------------

def covered(width: int, height: int, pixel: bytes, clear: bytes, layers: int = 1):
    """texels() of an image whose coverage is zero on the border of every level: `clear` there,
    `pixel` inside."""
    def texels(level, size):
        w, h = max(1, width >> level), max(1, height >> level)
        inside = lambda x, y: 0 < x < w - 1 and 0 < y < h - 1
        return b"".join(pixel if inside(x, y) else clear for y in range(h)
                        for x in range(w)) * layers
    return texels


def root(**more) -> Image:
    return Image(RGBA8, 4, 4, **more)


def decal(width: int = 4, height: int = 4, levels: int = 1, layers: int = 1, **more) -> Image:
    """A patch image with coverage in its alpha."""
    more = {"alpha_mode": 2, "format": RGBA8, "pixel": b"\x40\x50\x60\x80", "clear": b"\0\0\0\0",
            **more}
    pixel, clear, fmt = more.pop("pixel"), more.pop("clear"), more.pop("format")
    return Image(fmt, width, height, levels=levels, layers=layers,
                 texels=covered(width, height, pixel, clear, layers),
                 codec=stored_zstd, **more)


def mask(width: int = 4, height: int = 4, levels: int = 1, fmt: int = R8,
         pixel: bytes = b"\xff") -> Image:
    return Image(fmt, width, height, levels=levels,
                 texels=covered(width, height, pixel, bytes(len(pixel))))


def place(x: float, y: float, size: float) -> tuple:
    """The matrix of a patch that covers the square of `size` at (x, y) of its parent."""
    s = 1.0 / size
    return (s, 0.0, -x * s if x else 0.0, 0.0, s, -y * s if y else 0.0, 0.0, 0.0, 1.0)


def zipmap(patches: list, images: list, layers: int = 1, planes: dict = None, before: list = None,
           **more) -> File:
    """A file with one zipmap behind the textures `before`. A patch of the list is a Patch."""
    texture = Texture("zip", [(k, NONE) for k in range(layers)], wrap=(2, 2, 2),
                      zipmap=Zipmap(patches, planes or {}))
    return File(images, (before or []) + [texture], **more)


PLACED = place(0.25, 0.5, 0.25)

add("zip_root_only", "A zipmap with nothing but its root.", zipmap([Patch([0])], [root()]))
add("zip_patch_smallest",
    "The smallest zipmap with a patch: one texel as root, one texel as patch.",
    zipmap([Patch([0]), Patch([1], place(0.5, 0.5, 0.5))], [Image(R8, 1, 1), decal(1, 1)],
           planes={"": Plane(packing=2), "matrix": Plane()}))
add("zip_root_levels", "A root with all its levels and straight alpha.",
    zipmap([Patch([0])], [root(levels=3, alpha_mode=1)]))
add("zip_patch", "A root and one patch, placed by scale and offset.",
    zipmap([Patch([0]), Patch([1], PLACED)], [root(), decal()]))
add("zip_patch_levels", "A patch with all its levels, zero coverage on the border of each.",
    zipmap([Patch([0]), Patch([1], PLACED)], [root(), decal(8, 8, 4)]))
add("zip_patch_npot_levels", "A patch of 7 x 5 texels with levels.",
    zipmap([Patch([0]), Patch([1], PLACED)], [root(), decal(7, 5, 3)]))
add("zip_patch_straight", "Coverage from straight alpha: colour under zero coverage is free.",
    zipmap([Patch([0]), Patch([1], PLACED)], [root(),
                                              decal(alpha_mode=1, clear=b"\xff\xee\xdd\0")]))
add("zip_patch_tiled", "A patch of 65 x 17 texels in tiles of 16 x 16 texels.",
    zipmap([Patch([0]), Patch([1], PLACED)], [root(), decal(65, 17, tile_log2=4)]))
PRED_DECAL = decal(70, 18)
PRED_DECAL.codec = pred(RGBA8, 70, 18, texels=PRED_DECAL.texels, zero_map=True).codec
add("zip_patch_pred", "A patch whose tile has codec pred; its coverage is checked like any other.",
    zipmap([Patch([0]), Patch([1], PLACED)], [root(), PRED_DECAL]))
add("zip_patch_half_float", "Coverage in the alpha of a half float format.",
    zipmap([Patch([0]), Patch([1], PLACED)],
           [root(), decal(format=97, pixel=struct.pack("<4H", 0x3C00, 0x3800, 0x7E00, 0x3C00),
                          clear=bytes(8))]))
add("zip_patch_16_bit", "Coverage in the alpha of a 16-bit format.",
    zipmap([Patch([0]), Patch([1], PLACED)], [root(),
                                              decal(format=91, pixel=b"\1\2\3\4\5\6\0\1",
                                                    clear=bytes(8))]))
add("zip_patch_block_format",
    "A patch in BC3, which has an alpha channel; coverage of block formats is not checked.",
    zipmap([Patch([0]), Patch([1], PLACED)], [root(), Image(137, 8, 8, alpha_mode=1)]))
add("zip_rotation", "A rotation with cosine 0.6.",
    zipmap([Patch([0]), Patch([1], (1.2, 1.6, -0.9, -1.6, 1.2, 0.7, 0.0, 0.0, 1.0))],
           [root(), decal()]))
add("zip_reflection",
    "A mirrored patch: the determinant is negative, and so are the four numbers of [R8111].",
    zipmap([Patch([0]), Patch([1], (-2.0, 0.0, 1.5, 0.0, 2.0, -0.5, 0.0, 0.0, 1.0))],
           [root(), decal()]))
add("zip_homography", "A homography, as photographs give it.",
    zipmap([Patch([0]), Patch([1], (2.5, 0.125, -0.5, -0.25, 3.0, -0.75, 0.25, -0.125, 1.0))],
           [root(), decal()]))
add("zip_outside", "A patch that lies wholly outside the root is of no use, and valid.",
    zipmap([Patch([0]), Patch([1], place(5.0, 5.0, 0.25))], [root(), decal()]))
add("zip_chain", "A chain of parents three deep.",
    zipmap([Patch([0])] + [Patch([1], place(0.25, 0.25, 0.5), parent=p) for p in (0, 1, 2)],
           [root(), decal()]))
add("zip_parent_previous_and_root", "Patches with parents 0, 1 and 1.",
    zipmap([Patch([0])] + [Patch([1], place(0.5, 0.25, 0.5), parent=p) for p in (0, 1, 1)],
           [root(), decal()]))
add("zip_mask", "Coverage from a mask, the patch's image has no alpha.",
    zipmap([Patch([0]), Patch([1], PLACED, mask=2)], [root(), Image(29, 4, 4, seed=2), mask()]))
add("zip_mask_other_size",
    "A mask of another size and with levels; alpha_mode 0 of a four-channel image.",
    zipmap([Patch([0]), Patch([1], PLACED, mask=2)],
           [root(), Image(RGBA8, 4, 4, seed=2), mask(9, 5, 4)]))
add("zip_mask_float", "A mask of 32-bit floats.",
    zipmap([Patch([0]), Patch([1], PLACED, mask=2)],
           [root(), Image(29, 4, 4, seed=2), mask(fmt=100, pixel=b"\0\0\x80\x3f")]))
add("zip_mask_bc4", "A mask in BC4, a block format of one channel.",
    zipmap([Patch([0]), Patch([1], PLACED, mask=2)],
           [root(), Image(29, 4, 4, seed=2), Image(139, 4, 4, seed=3)]))
add("zip_layers",
    "Three layers share patches and the coverage of the first; the second layer's size is its own.",
    zipmap([Patch([0, 1, 2]), Patch([3, 4, 5], PLACED)],
           [root(), Image(RG8, 2, 2), root(seed=4), decal(), Image(RG8, 4, 2, seed=5),
            Image(R8, 4, 4, seed=6)], layers=3))
add("zip_layers_32", "A zipmap of 32 layers.",
    zipmap([Patch([0] * 32), Patch([1] * 32, PLACED)], [Image(R8, 1, 1), decal()], layers=32,
           planes={"": Plane(packing=2)}))
add("zip_image_used_often", "One decal in nine places.",
    zipmap([Patch([0])] + [Patch([1], place(k / 16, 0.5, 0.125)) for k in range(9)],
           [root(), decal()]))
add("zip_image_is_root_too", "The root's image is the patch's as well.",
    zipmap([Patch([0]), Patch([0], PLACED)], [decal()]))
add("zip_frames", "An animated root and an animated patch.",
    zipmap([Patch([0]), Patch([1], PLACED)], [Image(RGBA8, 2, 2, layers=3, layer_kind=2),
                                              decal(layers=3, layer_kind=2)]))
add("zip_frames_static_patch", "An animated root and a patch that is the same in every frame.",
    zipmap([Patch([0]), Patch([1], PLACED)], [Image(RGBA8, 2, 2, layers=3, layer_kind=2), decal()]))
add("zip_frames_and_array",
    "The layer kinds of a root and a patch may differ: frames and an array of as many layers.",
    zipmap([Patch([0]), Patch([1], PLACED)], [Image(RGBA8, 2, 2, layers=2, layer_kind=2),
                                              decal(layers=2)]))
add("zip_array_static_mask", "A root with two array layers, a patch with two and a mask with one.",
    zipmap([Patch([0]), Patch([1], PLACED, mask=2)],
           [Image(RGBA8, 2, 2, layers=2), Image(29, 4, 4, layers=2), mask()]))
PATTERN = Texture("pattern", [(0, 1)])
add("zip_texture_source", "A patch whose source is an earlier texture of the file.",
    zipmap([Patch([0]), Patch([0], PLACED, source_kind=1)], [root(), decal()], before=[PATTERN]))
add("zip_texture_source_mask", "A texture as source, with a mask, which is optional there.",
    zipmap([Patch([0]), Patch([0], PLACED, source_kind=1, mask=2)], [root(), decal(), mask()],
           before=[PATTERN]))
add("zip_texture_source_no_alpha", "A texture without alpha as source and no mask.",
    zipmap([Patch([0]), Patch([0], PLACED, source_kind=1)], [root(), Image(29, 4, 4)],
           before=[PATTERN]))
add("zip_in_zip", "The source is a zipmap itself.",
    File([root(), decal()], [Texture("inner", [(0, NONE)],
                                     zipmap=Zipmap([Patch([0]), Patch([1], PLACED)])),
                             Texture("outer", [(0, NONE)],
                                     zipmap=Zipmap([Patch([0]),
                                                    Patch([0], PLACED, source_kind=1)]))]))
add("zip_texture_source_layers", "A source of two layers for a zipmap of two layers.",
    zipmap([Patch([0, 0]), Patch([0, 0], PLACED, source_kind=1)], [root(), decal()], layers=2,
           before=[Texture("two", [(0, 1), (2, 1)])]))
add("zip_several", "Image, zipmap, image, zipmap: the n-th zipmap owns the n-th ZPMP chunk.",
    File([root(), decal(), root(seed=7)],
         [Texture("a", [(0, 0)]), Texture("b", [(0, NONE)],
                                          zipmap=Zipmap([Patch([0]), Patch([1], PLACED)])),
          Texture("c", [(0, 1)]), Texture("d", [(0, NONE)], zipmap=Zipmap([Patch([2])]))]))
add("zip_meta_unknown_chunk", "A zipmap with metadata and an unknown chunk.",
    zipmap([Patch([0]), Patch([1], PLACED)], [root(), decal()], meta=META,
           extra=[Chunk("XFOO", b"foo", flags=2)]))

# Matrices on the boundary of [R8110] and [R8111].
ULP = 2.0 ** -52


def matrix_file(*matrix) -> File:
    return zipmap([Patch([0]), Patch([1], matrix)], [root(), decal()])


add("matrix_one_ulp_from_singular",
    "Two rows that differ by one unit in the last place: the determinant is 2^-52.",
    matrix_file(1.0, 1.0, 0.0, 1.0, 1.0 + ULP, 0.0, 0.0, 0.0, 1.0))
add("matrix_a22_smallest", "A22 and the determinant are 2^-1074, the smallest number above zero.",
    matrix_file(2.0 ** -537, 0.0, 0.0, 0.0, 2.0 ** -537, 0.0, 0.0, 0.0, 1.0))
add("matrix_corner_one_ulp_from_infinity",
    "A20 + A22 is 2^-53: the corner (1, 0) is far away, and finite.",
    matrix_file(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0 - ULP / 2, 0.0, 1.0))
add("matrix_unfused_sign",
    "The determinant is positive with each operation rounded, negative if fused.",
    matrix_file(1.0434872917830944, 0.07713235728442669, 0.17584552243351936, 0.21207539271563292,
                1.9831877201795578,
                0.15370267909020185, 0.6277813422493637, 1.0301600387319922, 0.1647741007618606))
add("matrix_unfused_corner",
    "As matrix_unfused_sign, but with fused multiply-adds only a corner would change.",
    matrix_file(1.9848958775401115, 0.03538454417139292, 0.20538753643631935, 0.21638641320168972,
                1.3197840079665184,
                0.07640571985393763, 1.1006411453709006, 0.6775842760689557, 0.1408966281451285))
add("matrix_denormal", "A denormal entry is a number like others.",
    matrix_file(1.0, 0.0, 5e-324, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0))
add("matrix_largest", "The largest binary64 as an offset; every product stays finite.",
    matrix_file(1.0, 0.0, 1.7976931348623157e308, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0))
add("matrix_negative_zero_in_product",
    "The composed matrix has a negative zero, which only stored entries may not have.",
    zipmap([Patch([0]), Patch([1], (1.0, 0.0, 0.0, 0.0, 2.0 ** -600, 0.0, 0.0, 0.0, 1.0)),
            Patch([1], (-1.0, -2.0 ** -600, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), parent=1)],
            [root(), decal()]))

# Planes: every predictor, packing and codec. source_kind has elements of 1 byte, parent of 4, the
# matrix of 8.
GRID = [Patch([0])] + [Patch([1], place((k % 5) / 8, (k // 5) / 8, 0.125),
                             parent=0 if k < 12 else k // 2) for k in range(20)]
GRID_IMAGES = [root(), decal()]
for codec, codec_name in enumerate(("raw", "zstd")):
    for packing, packing_name in enumerate(("elements", "bytes")):
        for predictor, predictor_name in enumerate(("none", "delta", "second")):
            add("planes_%s_%s_%s" % (predictor_name, packing_name, codec_name),
                "Predictor %d, packing %d, codec %d (raw where zstd saves nothing)."
                % (predictor, packing, codec),
                zipmap(GRID, GRID_IMAGES, planes={"": Plane(predictor, packing, codec)}))
add("planes_bits", "All planes with packing 2, widths 0 to 64.",
    zipmap(GRID, GRID_IMAGES, planes={"": Plane(packing=2)}))
add("planes_bits_full_width", "Packing 2 with bit_width 8 x E and base 0.",
    zipmap(GRID, GRID_IMAGES, planes={"": Plane(packing=2),
                                      "parent": Plane(packing=2, bit_width=32, base=0),
                                      "source_kind": Plane(packing=2, bit_width=8, base=0),
                                      "matrix": Plane(packing=2, bit_width=64, base=0)}))
add("planes_bits_base_top", "Packing 2 with base + 2^bit_width - 1 exactly 2^(8E) - 1.",
    zipmap(GRID, GRID_IMAGES, planes={"": Plane(packing=2),
                                      "mask": Plane(packing=2, bit_width=0, base=NONE)}))
add("planes_bits_wide", "Packing 2 with widths that cross bytes and leave unused bits.",
    zipmap(GRID, GRID_IMAGES, planes={"": Plane(packing=2),
                                      "parent": Plane(packing=2, bit_width=13, base=0),
                                      "source0": Plane(packing=2, bit_width=3, base=0)}))
add("planes_wrap_around",
    "Masks change between 2 and 0xFFFFFFFF, so differences wrap around.",
    zipmap([Patch([0])] + [Patch([1], place(k / 16, 0.5, 0.125), mask=2) if k % 3 else Patch([3],
        PLACED) for k in range(9)],
           [root(), Image(29, 4, 4, seed=2), mask(), decal()],
           planes={"": Plane(2), "matrix": Plane(1)}))
add("planes_zstd_fcs_8", "Planes in frames whose content size takes eight bytes.",
    zipmap(GRID, GRID_IMAGES, planes={"": Plane(packing=1, codec=1, fcs_bytes=8)}))
add("planes_zstd_encoder", "A matrix plane in a frame as a zstd encoder makes it.",
    zipmap(GRID, GRID_IMAGES, planes={"m02": Plane(packing=1, codec=1)},
           overrides={"plane.0.m02.stored": bytes.fromhex(FRAMES["plane"][1])}))
add("planes_mixed", "Each plane has a coding of its own.",
    zipmap(GRID, GRID_IMAGES, planes={"parent": Plane(1), "source_kind": Plane(packing=2),
                                      "source0": Plane(2, 1, 1),
                                      "mask": Plane(2), "m00": Plane(1, 1, 1), "m02": Plane(0, 1),
                                      "m12": Plane(2, 0, 0),
                                      "m22": Plane(packing=2)}))
add("planes_300_patches", "300 patches in little space.",
    zipmap([Patch([0])] + [Patch([1], place((k % 20) / 32, (k // 20) / 32,
                                            0.03125)) for k in range(299)], GRID_IMAGES,
           planes={"": Plane(packing=2), "m02": Plane(0, 1, 1), "m12": Plane(0, 1, 1)}))
