# SPDX-License-Identifier: Apache-2.0
"""Tiles of codec 4, "fields" (spec/ztex.md section 6.5), and the valid and invalid files about them;
they are added to valid.CASES and invalid.CASES."""

from invalid import bad
from valid import add
from ztexmake import (R8, RGBA8, File, Image, block, flat, flip, flip_at, frame,
                      frame_header, noise, raw_block, rle_block, stored_zstd)

FIELDS = {131: (4, 4), 132: (4, 4), 133: (4, 4), 134: (4, 4), 137: (2, 6, 4, 4), 138: (2, 6, 4, 4),
          139: (2, 6), 140: (2, 6), 141: (2, 6, 2, 6), 142: (2, 6, 2, 6), 145: (8, 8), 146: (8, 8)}
BC1, BC3, BC4, BC5, BC7 = 133, 137, 139, 141, 145
CODEC = 4


def apart(data: bytes, fields: tuple) -> bytes:
    """The first field of every block, then the second of every block, and so on."""
    size, at, out = sum(fields), 0, b""
    for s in fields:
        out += b"".join(data[o + at:o + at + s] for o in range(0, len(data), size))
        at += s
    return out


def quiet_ends(fields: tuple, seed: int = 5):
    """texels() whose fields of 2 bytes, or the first one, are the same in whole runs of blocks; the
    rest is noise: so a frame of runs is small once the fields are apart."""
    def texels(level, total):
        out, dots = b"", noise(total, seed + level)
        for j in range(total // sum(fields)):
            for i, s in enumerate(fields):
                still = s == 2 or i == 0
                out += bytes([40 + i + j // 24 % 200]) * s if still else dots[len(out):len(out) + s]
        return out
    return texels


def coded(fields: tuple, pack=frame, choose=None):
    """An image's codec(): codec 4 in tiles of levels, codec 1 in tails and where `choose(tile)` is
    false."""
    def codec(level, tile, data):
        if level == "tail" or (choose and not choose(tile)):
            return stored_zstd(level, tile, data)
        stored = pack(apart(data, fields))
        assert len(stored) < len(data), "R5202"
        return CODEC, stored
    return codec


def image(fmt: int, w: int, h: int, fields: tuple = None, pack=frame, choose=None, **more) -> Image:
    fields = fields or FIELDS[fmt]
    more.setdefault("texels", quiet_ends(fields))
    return Image(fmt, w, h, codec=coded(fields, pack, choose), **more)


# ---- valid ---------------------------------------------------------------------------------------

for number in FIELDS:
    add("fields_format_%d" % number, "A tile of codec 4, format %d." % number,
        File([image(number, 90, 30)]))
for number in (BC1, BC3, BC5):
    add("fields_tiles_%d" % number,
        "Tiles of 16 x 16 blocks of codec 4, clipped at the right and below, format %d." % number,
        File([image(number, 150, 90, tile_log2=4)]))
add("fields_levels", "All levels of 300 x 200 texels: three of codec 4, a tail of codec 1.",
    File([image(BC7, 300, 200, levels=9)]))
add("fields_layers", "Three array layers of codec 4.", File([image(BC4, 100, 40, layers=3)]))
add("fields_cube", "Six faces of codec 4.", File([image(BC1, 80, 80, layers=6, layer_kind=1)]))
add("fields_volume", "A volume of 5 slices of codec 4.", File([image(BC3, 70, 40, depth=5)]))
add("fields_mixed", "Tiles of codec 4 and others by turns.",
    File([image(BC5, 300, 100, tile_log2=4, choose=lambda tile: tile % 3 == 1)]))
add("fields_column", "One block wide, 100 blocks high.", File([image(BC3, 4, 400, tile_log2=8)]))
add("fields_row", "100 blocks wide, one high.", File([image(BC1, 400, 2, tile_log2=8)]))
add("fields_content_size_8", "The frame has a content size of eight bytes.",
    File([image(BC7, 90, 30, pack=lambda data: frame(data, 8))]))
add("fields_many_blocks", "The frame has a block for each run of 50 bytes and an empty last one.",
    File([image(BC1, 90, 30, texels=flat(7), pack=lambda data: frame_header(len(data)) + b"".join(
        rle_block(7, min(50, len(data) - at)) for at in range(0, len(data), 50)) + raw_block(b"", True))]))
ENCODED = bytes.fromhex(
    "28b52ffd60000fe50600e40a00000021010102020103030404020505060603070708080409090a0a050b0b0c"
    "0c060d0d0e0e070f0f1010081111121209131314140a151516160b171718180c19191a1a0d1b1b1c1c0e1d1d"
    "1e1e0f1f1f202010212122221123232424122525262613272728281429292a2a152b2b2c2c162d2d2e2e172f"
    "2f3030183131323219333334341a353536361b373738381c39393a3a1d3b3b3c3c1e3d3d3e3e1f3f3f841000"
    "ff851001ff84100203ff42a81082dd76f059033208fcff0e7abffe77ed4f6a41c3660ce477165ea92bbf4cd0"
    "bf36a4da3b7ad19749ca")


def two_fields(level, total):
    """What ENCODED holds."""
    return b"".join(bytes([j // 8, j // 8, j // 16, 0x21, 0x84 + j % 2, 0x10, j % 4, 0xFF])
                    for j in range(total // 8))


add("fields_encoder", "A tile of BC1, the frame made by an encoder.",
    File([image(BC1, 128, 64, texels=two_fields, pack=lambda data: ENCODED)]))

# ---- invalid -------------------------------------------------------------------------------------

TILE = File([image(BC3, 90, 30)])
SIZE = 23 * 8 * 16


def anyway(fmt: int, w: int, h: int, fields: tuple, **more) -> File:
    """Codec 4 where that may not be, tails included."""
    base = Image(fmt, w, h, texels=flat(7), **more)
    base.codec = lambda level, tile, data: (CODEC, frame(apart(data, fields)))
    return File([base])


bad("R5401", "tail", "A mip tail of one level has codec 4.", base=anyway(BC1, 64, 64, (4, 4)))
bad("R5401", "tail_of_levels", "Level 0 has codec 4, and so has the tail behind it.",
    base=anyway(BC1, 128, 128, (4, 4), levels=8))
for number, fields, what in (
        (R8, (4, 4), "R8"), (RGBA8, (4, 4), "RGBA8"), (109, (8, 8), "RGBA32"),
        (135, (8, 4, 4), "BC2"), (136, (8, 4, 4), "BC2, sRGB"), (143, (8, 8), "BC6H, unsigned"),
        (144, (8, 8), "BC6H, signed"), (147, (4, 4), "ETC2"), (151, (2, 6, 4, 4), "ETC2 with alpha"),
        (153, (2, 6), "EAC R11"), (155, (2, 6, 2, 6), "EAC RG11"), (157, (8, 8), "ASTC 4 x 4"),
        (171, (8, 8), "ASTC 8 x 8")):
    bad("R5401", "format_%d" % number, "A tile of %s has codec 4." % what,
        base=anyway(number, 400, 40, fields))
bad("R5401", "format_unknown",
    "A tile of a format that the registry does not have, 1000, with blocks of 4 x 4 texels and eight "
    "bytes, has codec 4.", base=anyway(1000, 90, 30, (4, 4), block=(4, 4, 8)))
for k in range(3):
    bad("R5201", "fields_reserved_%d" % k, "A reserved byte of the record of a tile of codec 4.",
        {"tile.0.0.0.reserved": 1 << 8 * k}, TILE)
bad("R5202", "fields_empty", "A tile of codec 4 without stored bytes.", {"tile.0.0.3.stored": b""},
    File([image(BC3, 150, 90, tile_log2=4)]), also="R5001")
bad("R5202", "fields_not_smaller", "A tile of codec 4 with more bytes than it decodes to.",
    {"tile.0.0.0.stored": lambda b: frame_header(SIZE) + raw_block(bytes(SIZE), True)}, TILE,
    also="R5203")
for rule, name, what, stored, also in (
        ("R5001", "magic", "The frame's magic number is wrong.",
         lambda b: flip_at(0)(b), ""),
        ("R5001", "checksum_flag", "The frame's checksum flag is set.",
         lambda b: flip_at(4, 4)(b), "R5003 R5004"),
        ("R5001", "form", "A form as codec 2 has it comes before the frame.",
         lambda b: b"\x10\0" + b, ""),
        ("R5002", "plus_1", "The content size of the frame is one too large.",
         lambda b: frame_header(SIZE + 1) + rle_block(0, SIZE, True), "R5004"),
        ("R5002", "one_field", "The frame holds the first field of each block only, rightly.",
         lambda b: frame(bytes(SIZE // 8)), "R5004"),
        ("R5003", "trailing", "A byte follows the frame.", lambda b: b + b"\0", ""),
        ("R5003", "no_last", "No block of the frame is marked as last.",
         lambda b: frame_header(SIZE) + rle_block(0, SIZE), ""),
        ("R5003", "second_frame", "A second frame follows.", lambda b: b + frame(b"1"), ""),
        ("R5004", "content", "The frame decodes to one byte less than it says.",
         lambda b: frame_header(SIZE) + rle_block(0, SIZE - 1, True), ""),
        ("R5004", "compressed", "A compressed block that is none.",
         lambda b: frame_header(SIZE) + block(2, b"\xFF" * 9, 9, True), "")):
    bad(rule, "fields_" + name, what, {"tile.0.0.0.stored": stored}, TILE, also)
bad("R5203", "fields_hash", "The hash of a tile of codec 4 is wrong.", {"tile.0.0.0.hash": flip(0)},
    TILE)
bad("R5203", "fields_as_they_lie", "Codec 4, and the frame holds the blocks as they lie.",
    base=File([Image(BC7, 90, 30, texels=lambda level, total: b"".join(
        bytes([j % 200]) * 16 for j in range(total // 16)),
        codec=lambda level, tile, data: (CODEC, frame(data)))]))
bad("R5203", "fields_other_format", "Codec 4, and the fields are those of BC5 in a tile of BC3.",
    base=File([image(BC3, 90, 30, (2, 6, 2, 6))]))
