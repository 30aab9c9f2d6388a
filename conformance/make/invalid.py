# SPDX-License-Identifier: Apache-2.0
"""The invalid files: each is a valid file and one edit (see ztexmake.py for the paths), everything
else resealed.

`bad(rule, name, what, edits, base, also)` adds the file `rule_name.ztex`. `also` lists other rules
that the file breaks as well, or that a validator may name because what it reads behind the fault
follows from it."""

import struct
from dataclasses import dataclass

import xxhash

from predmake import Framed, Pred, Tile, frequency_bits, symbols, table_bits
from valid import (GRID, GRID_IMAGES, PATTERN, PLACED, RUN, decal, dot, framed, from_residuals, mask,
                   picture, place, pred, root, run_file, zipmap)
from ztexmake import (FORMAT_BY_NAME, IDENTITY, NONE, R8, RG8, RGB8, RGBA8, RGBA8_SRGB, Chunk, File,
                      Image, Overrides,
                      Patch, Plane, Texture, Zipmap, block, blocks, flat, flip, flip_at, frame,
                      frame_header, noise, plus,
                      raw_block, rle_block, stored_zstd, uint, xxh3)


@dataclass
class Case:
    rule: str
    name: str
    what: str
    base: File
    edits: dict
    also: tuple
    severity: str

    @property
    def file(self) -> str:
        return "%s_%s.ztex" % (self.rule, self.name)

    def build(self) -> bytes:
        return self.base.build(self.edits)


CASES = []
DOT = dot()
DOT_META = dot(meta=[("a.key", "value"), ("b.key", "other")])


def bad(rule, name, what, edits=None, base=DOT, also="", severity="error"):
    CASES.append(Case(rule, name, what, base, edits or {}, tuple(also.split()), severity))


def bad_values(rule, stem, what, path, values, base=DOT, also=""):
    """One file for each (suffix, value) of a field."""
    for suffix, value in values:
        bad(rule, "%s_%s" % (stem, suffix), "%s: %s." % (what, suffix.replace("_", " ")),
            {path: value}, base, also)


MAX32, MAX64 = (1 << 32) - 1, (1 << 64) - 1

# ---- 2000: preamble ------------------------------------------------------------------------------

for k in range(10):
    bad("R2001", "byte_%d" % k, "Byte %d of the magic is wrong." % k,
        {"preamble.magic": flip_at(k)})
bad("R2001", "crlf_to_lf", "A text-mode transfer turned every CR LF into LF.",
    {"file": lambda b: b.replace(b"\r\n", b"\n")},
    also="R2006")
bad("R2001", "lf_to_crlf", "A text-mode transfer turned every LF into CR LF.",
    {"file": lambda b: b.replace(b"\n", b"\r\n")},
    also="R2007")
bad("R2001", "seven_bit", "A transfer stripped the high bit of every byte.",
    {"file": lambda b: bytes(x & 127 for x in b)},
    also="R2009")
bad("R2001", "empty", "A file without bytes.", {"file": b""}, also="R2006")
bad("R2001", "ktx2", "The identifier of another format.",
    {"preamble.magic": bytes.fromhex("AB4B5458203230BB0D0A")})
bad_values("R2002", "major", "Major version", "preamble.major",
           [("0", 0), ("2", 2), ("256", 256), ("65535", 65535)])
for name in ("reserved", "reserved40", "reserved48"):
    bad("R2003", name + "_low", "The lowest bit of a reserved field is set.",
        {"preamble." + name: 1})
    bad("R2003", name + "_high", "The highest bit of a reserved field is set.",
        {"preamble." + name: 1 << (15 if name == "reserved" else 63)})
bad("R2004", "two_chunks", "Two chunks: TEXS and IMAG.", {"chunks": lambda cs: cs[:2]},
    also="R3010 R6013")
bad_values("R2004", "chunk_count", "chunk_count does not match the file", "preamble.chunk_count",
           [("0", 0), ("65536", 65536), ("max", MAX32)], also="R2005 R2009 R3001 R3010")
bad("R2004", "count_65536_size_too",
    "65,536 chunks and the directory_size that goes with it, in a short file.",
    {"preamble.chunk_count": 65536, "preamble.directory_size": 48 * 65536},
    also="R2006 R2009 R3001")
bad("R2004", "count_wraps_directory_size",
    "A count whose product with 48 is 2^32 + 32: directory_size 32.",
    {"preamble.chunk_count": 89478486, "preamble.directory_size": 32}, also="R2005 R2009")
bad_values("R2005", "directory_size", "directory_size is wrong", "preamble.directory_size",
           [("minus_1", plus(-1)), ("plus_1", plus(1)), ("one_entry_more", plus(48)), ("0", 0),
            ("max", MAX32)], also="R2009")
for size in (1, 9, 10, 63, 64, 111, 207, 208, 240, 271, 272, 300):
    bad("R2006", "cut_at_%d" % size, "The file ends after %d bytes." % size,
        {"file": lambda b, n=size: b[:n]},
        also="R2001" if size < 10 else "")
bad("R2006", "last_byte_missing", "The last byte, padding, is missing.", {"file": lambda b: b[:-1]})
bad_values("R2006", "file_size", "file_size is larger than the file", "preamble.file_size",
           [("plus_1", plus(1)), ("plus_16", plus(16)), ("wrap_32", plus(1 << 32)), ("max", MAX64)],
           also="R3002")
bad("R2007", "one_byte_more", "A zero byte behind the end.", {"file": lambda b: b + b"\0"})
bad("R2007", "sixteen_bytes_more", "Sixteen zero bytes behind the end.",
    {"file": lambda b: b + bytes(16)})
bad("R2007", "second_file", "A second file behind the first.", {"file": lambda b: b + b})
bad_values("R2007", "file_size", "file_size is smaller than the file", "preamble.file_size",
           [("minus_1", plus(-1)), ("minus_16", plus(-16)), ("0", 0), ("64", 64)], also="R3002")
for bit in (0, 1, 31, 32, 55, 56, 63):
    bad("R2008", "bit_%d" % bit, "Bit %d of required_features is set." % bit,
        {"preamble.required_features": 1 << bit})
bad("R2009", "hash", "One bit of directory_hash is wrong.", {"preamble.directory_hash": flip(17)})
bad("R2009", "minor_changed", "The minor version was changed without the hash.",
    {"file": flip_at(12)})
bad("R2009", "hash_byte_order", "directory_hash is stored big-endian.",
    {"preamble.directory_hash": lambda h: int.from_bytes(uint(h, 8), "big")})
bad("R2009", "hash_of_directory_only", "directory_hash covers the directory but not the preamble.",
    {"file": lambda b: b[:56] + uint(xxh3(b[64:208]), 8) + b[64:]})

# ---- 3000: directory -----------------------------------------------------------------------------

bad_values("R3001", "offset", "The offset of IMAG is wrong", "entry.IMAG.offset",
           [("plus_16", plus(16)), ("minus_16", plus(-16)), ("plus_1", plus(1)),
            ("plus_8", plus(8)), ("0", 0), ("own_entry", 112),
            ("plus_wrap_32", plus(1 << 32)), ("max", MAX64), ("max_aligned", MAX64 - 15)])
bad("R3001", "first_offset_plus_16", "The offset of the first chunk is wrong.",
    {"entry.TEXS.offset": plus(16)})
bad("R3001", "overlap", "IMAG and TEXS have the same offset.", {"entry.IMAG.offset": 208})
bad("R3001", "swapped", "The offsets of IMAG and TEXL are swapped.",
    {"entry.IMAG.offset": 432, "entry.TEXL.offset": 320})
bad("R3001", "gap", "Sixteen zero bytes lie between two chunks.", {"gap.TEXS": bytes(16)})
bad("R3001", "stored_size_next_multiple",
    "stored_size of TEXS is one multiple of 16 too large: the next offset no longer follows.",
    {"entry.TEXS.stored_size": plus(16), "entry.TEXS.decoded_size": plus(16)}, also="R4003 R6101")
bad("R3002", "sixteen_bytes_more",
    "Sixteen zero bytes follow the last chunk, and file_size counts them.",
    {"gap.TEXL": bytes(16)})
bad("R3002", "no_last_padding", "The last chunk has no padding, and file_size does not count it.",
    {"padding.TEXL": b"", "preamble.file_size": plus(-15)})
XE = dot(extra=[Chunk("XFOO", b"12345", flags=2)])
bad("R3002", "directory_does_not_fit",
    "60,000 chunks and the directory_size that goes with them, in a short file.",
    {"preamble.chunk_count": 60000, "preamble.directory_size": 48 * 60000},
    also="R2006 R2009 R3001")
bad("R3003", "empty_chunk", "An unknown chunk of no bytes.", {"decoded.XFOO": b""}, XE)
bad("R3003", "empty_meta", "A META chunk of no bytes.", {"decoded.META": b""}, DOT_META,
    also="R7001")
bad("R3003", "stored_size_2_53", "stored_size and decoded_size are 2^53.",
    {"entry.XFOO.stored_size": 1 << 53, "entry.XFOO.decoded_size": 1 << 53}, XE, also="R3001 R3002")
bad("R3003", "stored_size_max", "stored_size and decoded_size are 2^64 - 1.",
    {"entry.XFOO.stored_size": MAX64, "entry.XFOO.decoded_size": MAX64}, XE, also="R3001 R3002")
bad("R3003", "stored_size_wraps", "offset + 64 + stored_size wraps past 2^64 to the right sum.",
    {"entry.XFOO.stored_size": lambda n: n - (1 << 62),
     "entry.XFOO.decoded_size": lambda n: n - (1 << 62)}, XE, also="R3001 R3002")
RUNS = run_file(frame(RUN))
BIG = (1 << 30) + 1
bad("R3003", "decoded_2_30_plus_1",
    "Codec 1 and a decoded_size of 2^30 + 1, which the frame says too.",
    {"entry.XRUN.decoded_size": BIG}, run_file(frame_header(BIG) + rle_block(65, 131072, True)),
    also="R5004 R4004")
bad("R3003", "decoded_max", "Codec 1 and a decoded_size of 2^64 - 1.",
    {"entry.XRUN.decoded_size": MAX64}, RUNS, also="R5002")
bad("R3003", "decoded_0", "Codec 1 and a decoded_size of 0.", {"entry.XRUN.decoded_size": 0}, RUNS,
    also="R3007 R5002")
for name, text in (("lower_case", b"xFOO"), ("space", b"XFO "), ("nul", b"XF\0O"),
                   ("high_bit", b"XF\xcfO"), ("at_sign", b"X@OO"),
                   ("bracket", b"XF[O"), ("slash", b"XF/O"), ("colon", b"XF:O"),
                   ("backquote", b"XFO`")):
    bad("R3004", name, "A type with a character other than A-Z and 0-9: %s." % name.replace("_",
        " "), {"entry.XFOO.type": text}, XE)
bad("R3004", "known_in_lower_case", "TEXS is written `texs`.", {"entry.TEXS.type": b"texs"},
    also="R3010 R3012")
for bit in (2, 5, 7):
    bad("R3005", "reserved_bit_%d" % bit, "Reserved flag bit %d is set." % bit,
        {"entry.XFOO.flags": flip(bit)}, XE)
ZIP = zipmap([Patch([0]), Patch([1], PLACED)], [root(), decal()])
for kind in ("TEXS", "IMAG", "ZPMP", "TEXL"):
    bad("R3005", kind.lower() + "_not_critical", "%s has flags 0." % kind,
        {"entry.%s.flags" % kind: 0}, ZIP)
bad("R3005", "texs_safe_to_copy", "TEXS has flags 3.", {"entry.TEXS.flags": 3})
for flags in (0, 1, 3):
    bad("R3005", "meta_flags_%d" % flags, "META has flags %d." % flags, {"entry.META.flags": flags},
        DOT_META)
bad_values("R3006", "codec", "The codec of an unknown chunk", "entry.XFOO.codec",
           [("2", 2), ("224", 224), ("255", 255)], XE)
bad("R3006", "texs_codec_2", "TEXS has codec 2.", {"entry.TEXS.codec": 2})
bad("R3006", "texl_zstd", "TEXL has codec 1, and is a right frame.", base=File(
    [Image(R8, 8, 8, texels=flat(3))], codec={"TEXL": 1}))
bad("R3006", "zpmp_zstd", "ZPMP has codec 1, and is a right frame.", base=zipmap(
    [Patch([0]), Patch([1], PLACED)], [root(), decal()], codec={"ZPMP": 1}))
bad("R3007", "raw_decoded_size", "Codec 0, decoded_size one more than stored_size.",
    {"entry.XFOO.decoded_size": plus(1)}, XE)
bad("R3007", "raw_decoded_hash", "Codec 0, decoded_hash differs from stored_hash.",
    {"entry.XFOO.decoded_hash": flip(3)}, XE, also="R4004")
bad("R3007", "zstd_saves_nothing", "Codec 1, stored_size equals decoded_size.",
    base=run_file(frame(RUN[:10]), RUN[:10]))
bad("R3007", "zstd_larger", "Codec 1, stored_size is above decoded_size.",
    base=run_file(frame(b"abc"), b"abc"))
for kind, values in (("TEXS", (0, 2, 65535)), ("IMAG", (0, 2)), ("ZPMP", (0, 2)), ("TEXL", (0, 2))):
    for value in values:
        bad("R3008", "%s_version_%d" % (kind.lower(), value), "%s has version %d." % (kind, value),
            {"entry.%s.version" % kind: value}, ZIP)


def order(*positions):
    """An override of the chunk list: the chunks in another order."""
    return {"chunks": lambda cs: [cs[p] for p in positions]}


ALL = zipmap([Patch([0]), Patch([1], PLACED)], [root(), decal()], meta=[("k", "v")],
             extra=[Chunk("AAAA", b"1", flags=2), Chunk("XFOO", b"2", flags=2)])
# Positions in ALL: 0 TEXS, 1 IMAG, 2 ZPMP, 3 META, 4 AAAA, 5 XFOO, 6 TEXL.
bad("R3009", "imag_before_texs", "IMAG comes before TEXS.", order(1, 0, 2, 3, 4, 5, 6), ALL)
bad("R3009", "zpmp_before_imag", "ZPMP comes before IMAG.", order(0, 2, 1, 3, 4, 5, 6), ALL)
bad("R3009", "meta_before_zpmp", "META comes before ZPMP.", order(0, 1, 3, 2, 4, 5, 6), ALL)
bad("R3009", "unknown_before_meta", "An unknown chunk comes before META.",
    order(0, 1, 2, 4, 3, 5, 6), ALL)
bad("R3009", "unknown_descending", "Two unknown chunks in descending order.",
    order(0, 1, 2, 3, 5, 4, 6), ALL)
bad("R3009", "texl_before_unknown", "TEXL is not the last chunk.", order(0, 1, 2, 3, 4, 6, 5), ALL)
bad("R3009", "texl_first", "TEXL is the first chunk.", order(6, 0, 1, 2, 3, 4, 5), ALL)
bad("R3010", "no_texs", "TEXS is missing.", order(1, 3, 4, 5, 6), ALL, also="R6110")
bad("R3010", "no_imag", "IMAG is missing.", order(0, 2, 3, 4, 5, 6), ALL, also="R6106 R8105")
bad("R3010", "no_texl", "TEXL is missing.", order(0, 1, 2, 3, 4, 5), ALL, also="R6013")
TWICE = lambda p: {"chunks": lambda cs: cs[:p] + [cs[p], Chunk(**vars(cs[p]))] + cs[p + 1:]}
for p, kind in ((0, "texs"), (1, "imag"), (6, "texl")):
    bad("R3011", kind + "_twice", "%s is there twice." % kind.upper(), TWICE(p), ALL)
bad("R3011", "meta_twice", "META is there twice.", TWICE(3), ALL)
bad("R3011", "unknown_twice", "A type that the reader does not know is there twice.", TWICE(4), ALL)
bad("R3012", "critical", "A critical chunk of an unknown type.", {"entry.XFOO.flags": 1}, XE)
bad("R3012", "critical_and_safe", "A critical chunk of an unknown type with flags 3.",
    {"entry.XFOO.flags": 3}, XE)
bad("R3012", "critical_not_private", "A critical chunk of an unknown type that is not private.",
    {"entry.XFOO.type": b"QQQQ", "entry.XFOO.flags": 1}, XE)

# ---- 4000: heads, hashes, padding ----------------------------------------------------------------

for kind in ("TEXS", "IMAG", "ZPMP", "META", "XFOO", "TEXL"):
    bad("R4001", kind.lower() + "_magic", "The head of %s has a wrong magic." % kind,
        {"head.%s.head_magic" % kind: flip_at(0)}, ALL)
    bad("R4002", kind.lower() + "_hash", "The head of %s repeats another stored_hash." % kind,
        {"head.%s.entry" % kind: flip_at(39)}, ALL)
bad("R4001", "magic_lf_to_cr", "The last byte of head_magic is CR.",
    {"head.TEXS.head_magic": flip_at(7, 7)})
bad("R4001", "index_plus_1", "index is one too large.", {"head.IMAG.index": plus(1)})
bad("R4001", "index_max", "index is 2^32 - 1.", {"head.TEXS.index": MAX32})
bad("R4001", "index_from_1", "Heads count from 1.",
    {"head.%s.index" % k: plus(1) for k in ("TEXS", "IMAG", "TEXL")})
bad("R4001", "reserved", "The reserved field of a head is not zero.", {"head.TEXS.reserved": 1})
for k, name in ((0, "type"), (4, "version"), (6, "flags"), (8, "offset"), (16, "stored_size"),
                (24, "decoded_size"), (47, "last_byte")):
    bad("R4002", name, "The head differs from the directory in %s." % name,
        {"head.TEXS.entry": flip_at(k)})
META_ZSTD = dot(meta=[("k", "!" * 300)], codec={"META": 1})
bad("R4003", "zstd_hash", "stored_hash of a compressed chunk is wrong.",
    {"entry.META.stored_hash": flip(40)}, META_ZSTD)
bad("R4003", "texs_byte", "One byte of TEXS was changed.", {"file": flip_at(208 + 64 + 30)},
    also="R4004")
bad("R4003", "texl_byte", "One byte of TEXL was changed; a tile hash sees it too.",
    {"file": flip_at(-16)}, also="R4004 R5203")
bad("R4003", "both_hashes", "stored_hash and decoded_hash of a raw chunk are wrong.",
    {"entry.XFOO.stored_hash": flip(40), "entry.XFOO.decoded_hash": flip(40)}, XE, also="R4004")
bad("R4003", "zstd_byte", "One byte of a frame was changed: the decoder need not see it.",
    {"stored.META": flip_at(-1),
    "entry.META.stored_hash": xxh3(frame(META_ZSTD.meta_bytes(Overrides({}))))}, META_ZSTD,
    also="R4004")
bad("R4004", "zstd_hash", "decoded_hash of a compressed chunk is wrong.",
    {"entry.META.decoded_hash": flip(63)}, META_ZSTD)
bad("R4004", "zstd_content", "A frame decodes to other bytes; stored_hash is that of the frame.",
    {"stored.META": flip_at(-1)}, META_ZSTD)
for kind in ("TEXS", "IMAG", "META", "XFOO", "TEXL"):
    base = dot(meta=[("k", "v")], extra=[Chunk("XFOO", b"2", flags=2)])
    bad("R4005", kind.lower() + "_first", "The first byte of padding behind %s is not zero." % kind,
        {"padding." + kind: flip_at(0)}, base)
    bad("R4005", kind.lower() + "_last", "The last byte of padding behind %s is not zero." % kind,
        {"padding." + kind: flip_at(-1, 128)}, base)

# ---- 5000: zstd profile. TEXS is the compressed chunk, so that every reader looks at it ----------

TEXS_ZSTD = File([Image(R8, 1, 1)], [Texture(c * 250, [(0, 0)]) for c in "abc"], codec={"TEXS": 1})
CONTENT = TEXS_ZSTD.texs(Overrides({}))
SIZE = len(CONTENT)
BODY = blocks(CONTENT)


def bad_frame(rule, name, what, stored, also=""):
    """TEXS stored as the given bytes."""
    bad(rule, name, what, {"stored.TEXS": stored}, TEXS_ZSTD, also)


bad_frame("R5001", "magic", "The magic number is wrong.",
          frame_header(SIZE, magic=0xFD2FB529) + BODY)
bad_frame("R5001", "magic_v07", "The magic number of the older format v0.7.",
          frame_header(SIZE, magic=0xFD2FB527) + BODY)
bad_frame("R5001", "skippable_first", "A skippable frame comes first.",
          uint(0x184D2A50, 4) + uint(3, 4) + b"abc" + frame(CONTENT))
bad_frame("R5001", "magicless", "The magic number is missing.", frame(CONTENT)[4:])
bad_frame("R5001", "window", "Not single-segment: a window of 1 KiB.",
          frame_header(SIZE, single_segment=0, window=0) + BODY)
bad_frame("R5001", "window_2_31", "Not single-segment: a window of 2 GiB.",
          frame_header(SIZE, single_segment=0, window=21 << 3) + BODY)
bad_frame("R5001", "no_content_size", "Not single-segment and no content size.",
          uint(0xFD2FB528, 4) + b"\0\0" + BODY, also="R5002")
bad_frame("R5001", "unused_bit", "The unused bit is set.", frame_header(SIZE, unused=1) + BODY)
bad_frame("R5001", "reserved_bit", "The reserved bit is set.",
          frame_header(SIZE, reserved=1) + BODY)
bad_frame("R5001", "checksum", "The checksum flag is set, and the right checksum is there.",
          frame_header(SIZE, checksum=1) + BODY + uint(xxhash.xxh64_intdigest(CONTENT) & MAX32, 4))
for flag, size in ((1, 1), (2, 2), (3, 4)):
    bad_frame("R5001", "dictionary_%d" % size, "A dictionary id of %d bytes." % size,
              frame_header(SIZE, dict_id_flag=flag, dict_id=uint(7, size)) + BODY)
bad_frame("R5001", "dictionary_zero",
          "A dictionary id that is 0, which means none, is there all the same.",
          frame_header(SIZE, dict_id_flag=1, dict_id=b"\0") + BODY)
bad_frame("R5001", "gzip", "The first bytes of a gzip file.",
          bytes.fromhex("1F8B0800000000000003") + BODY)
bad_frame("R5001", "lz4", "The magic number of LZ4 frames.",
          bytes.fromhex("04224D18") + frame(CONTENT)[4:])
bad_frame("R5001", "three_bytes", "Three bytes of a frame.", frame(CONTENT)[:3])
bad_frame("R5001", "magic_only", "The magic number and nothing else.", frame(CONTENT)[:4],
          also="R5002 R5003")
bad_frame("R5002", "plus_1", "The content size is one too large.", frame_header(SIZE + 1) + BODY,
          also="R5004")
bad_frame("R5002", "minus_1", "The content size is one too small.", frame_header(SIZE - 1) + BODY,
          also="R5004")
bad_frame("R5002", "zero", "The content size is 0.", frame_header(0, 1) + BODY, also="R5004")
bad_frame("R5002", "max", "The content size is 2^64 - 1.", frame_header(MAX64, 8) + BODY,
          also="R5004")
bad_frame("R5002", "plus_2_32", "The content size is 2^32 too large.",
          frame_header(SIZE + (1 << 32), 8) + BODY, also="R5004")
bad_frame("R5002", "cut", "The stored bytes end within the content size.", frame(CONTENT, 8)[:9],
          also="R5003")
bad_frame("R5003", "reserved_type", "A block of the reserved type 3.",
          frame_header(SIZE) + block(3, b"", 0) + BODY)
bad_frame("R5003", "no_last", "No block is marked as last.",
          frame_header(SIZE) + raw_block(CONTENT[:1]) + blocks(CONTENT[1:])[:-4]
          + rle_block(99, 250), also="R5004")
bad_frame("R5003", "no_blocks", "There is no block.", frame_header(SIZE), also="R5004")
bad_frame("R5003", "trailing_byte", "A byte follows the frame.", frame(CONTENT) + b"\0")
bad_frame("R5003", "skippable_last", "A skippable frame follows.",
          frame(CONTENT) + uint(0x184D2A5F, 4) + uint(0, 4))
bad_frame("R5003", "two_frames", "The same frame twice.", frame(CONTENT) + frame(CONTENT))
bad_frame("R5003", "empty_frame_last", "A frame of no content follows.",
          frame(CONTENT) + frame_header(0) + raw_block(b"", True))
bad_frame("R5003", "checksum_without_flag", "A checksum follows that the header does not announce.",
          frame(CONTENT) + uint(xxhash.xxh64_intdigest(CONTENT) & MAX32, 4))
bad_frame("R5003", "last_too_early", "The first block is marked as last, others follow.",
          frame_header(SIZE) + raw_block(CONTENT[:72], True) + blocks(CONTENT[72:]), also="R5004")
bad_frame("R5003", "cut_in_block", "The last block is cut.", frame(CONTENT)[:-1], also="R5004")
bad_frame("R5003", "cut_in_block_header", "The last block's header is cut.", frame(CONTENT)[:-2],
          also="R5004")
bad_frame("R5003", "raw_size_too_large", "A raw block says that it has more bytes than there are.",
          frame_header(SIZE) + block(0, CONTENT[:99], 100, True), also="R5004")
BIG_RUN = bytes(131074)
bad("R5003", "rle_131073", "An RLE block of 131,073 bytes.",
    base=run_file(frame_header(131074) + rle_block(0, 131073) + rle_block(0, 1, True), BIG_RUN))
bad("R5003", "block_size_max", "An RLE block of 2^21 - 1 bytes.",
    base=run_file(frame_header(2097151) + rle_block(0, 2097151, True), bytes(2097151)))
bad_frame("R5004", "one_less", "The blocks decode to one byte less than the content size.",
          frame_header(SIZE) + blocks(CONTENT[:-1]), also="R4004")
bad_frame("R5004", "one_more", "The blocks decode to one byte more than the content size.",
          frame_header(SIZE) + blocks(CONTENT + b"c"), also="R4004")
bad_frame("R5004", "bomb", "A small content size and 64 blocks of 131,072 bytes each.",
          frame_header(SIZE) + rle_block(0, 131072) * 64 + rle_block(0, 1, True), also="R4004")
bad_frame("R5004", "compressed_garbage", "A compressed block of bytes that are none.",
          frame_header(SIZE) + block(2, b"\xff" * 40, 40, True), also="R4004")
bad_frame("R5004", "compressed_empty", "A compressed block of no bytes.",
          frame_header(SIZE) + BODY[:-4] + block(2, b"", 0, True), also="R4004")
bad_frame("R5004", "literals_too_long",
          "A compressed block whose literals say 255 bytes, of which 2 are there.",
          frame_header(SIZE) + block(2, uint(255 << 4 | 1 << 2, 2) + b"ab", 4, True), also="R4004")
bad_frame("R5004", "far_match", "A compressed block whose match begins before the content.",
          frame_header(SIZE) + block(2, bytes.fromhex("08 61 01 54 00 05 30 01"), 8, True),
          also="R4004")

# ---- 5100: planes --------------------------------------------------------------------------------

GRIDF = lambda **planes: zipmap(GRID, GRID_IMAGES, planes={"": Plane(), **planes})
PLAIN = GRIDF()
bad_values("R5101", "predictor", "Predictor", "plane.0.parent.predictor", [("3", 3), ("255", 255)],
           PLAIN)
bad_values("R5101", "packing", "Packing", "plane.0.parent.packing", [("3", 3), ("255", 255)], PLAIN)
bad_values("R5101", "codec", "Codec", "plane.0.parent.codec",
           [("2", 2), ("3", 3), ("224", 224), ("255", 255)], PLAIN)
bad("R5101", "bit_width_without_bits", "bit_width is 1 with packing 0.",
    {"plane.0.parent.bit_width": 1}, PLAIN)
bad("R5101", "base_without_bits", "base is 1 with packing 0.", {"plane.0.parent.base": 1}, PLAIN)
bad("R5101", "base_with_byte_planes", "base is 1 with packing 1.", {"plane.0.parent.base": 1},
    GRIDF(parent=Plane(packing=1)))
for k in (1, 1 << 8, 1 << 16, 1 << 23):
    bad("R5101", "reserved_%x" % k, "A reserved byte of a plane header is not zero.",
        {"plane.0.m00.reserved": k}, PLAIN)
BITS = GRIDF(parent=Plane(packing=2, base=0, bit_width=7), source0=Plane(packing=2),
             mask=Plane(packing=2), m22=Plane(packing=2))
bad("R5101", "bits_with_delta", "Packing 2 with predictor 1.", {"plane.0.mask.predictor": 1}, BITS)
bad("R5101", "bits_with_second", "Packing 2 with predictor 2.", {"plane.0.mask.predictor": 2}, BITS)
bad("R5101", "bits_with_zstd", "Packing 2 with codec 1 and a right frame of the bits.",
    {"plane.0.parent.codec": 1, "plane.0.parent.stored": lambda b: frame(b)}, BITS, also="R5103")
bad("R5101", "bit_width_33", "bit_width is 33 for elements of 4 bytes.",
    {"plane.0.parent.bit_width": 33, "plane.0.parent.stored": lambda b: bytes((21 * 33 + 7) // 8)},
    BITS, also="R5105")
bad("R5101", "bit_width_65", "bit_width is 65 for elements of 8 bytes.",
    {"plane.0.m22.bit_width": 65, "plane.0.m22.stored": bytes((21 * 65 + 7) // 8)}, BITS)
bad("R5101", "bit_width_255", "bit_width is 255.", {"plane.0.parent.bit_width": 255}, BITS,
    also="R5103")
bad("R5101", "base_2_32", "base is 2^32 for elements of 4 bytes; the sum modulo 2^32 is right.",
    {"plane.0.parent.base": 1 << 32}, BITS)
bad("R5101", "base_2_8", "base is 2^8 for elements of 1 byte; the sum modulo 2^8 is right.",
    {"plane.0.source_kind.base": 256}, GRIDF(source_kind=Plane(packing=2)))
bad("R5101", "base_and_width_2_32",
    "base + 2^bit_width - 1 is 2^32 for elements of 4 bytes, though no element is.",
    {"plane.0.mask.bit_width": 1, "plane.0.mask.stored": bytes(3)}, BITS)
bad("R5101", "base_and_width_2_64", "base is 1 and bit_width 64: the sum is 2^64.",
    {"plane.0.m00.base": 1, "plane.0.m00.stored": lambda b: b"".join(uint(struct.unpack_from("<Q",
        b, 8 * i)[0] - 1, 8) for i in range(21))},
    GRIDF(m00=Plane(packing=2, base=0, bit_width=64)))
bad_values("R5102", "element_size", "element_size of the plane parent",
           "plane.0.parent.element_size",
           [("0", 0), ("2", 2), ("3", 3), ("8", 8), ("255", 255)], PLAIN, also="R5101 R5103")
bad_values("R5102", "matrix_element_size", "element_size of a matrix plane",
           "plane.0.m00.element_size", [("4", 4), ("16", 16)], PLAIN,
           also="R5101 R5103")
bad_values("R5102", "count", "count of the plane parent", "plane.0.parent.count",
           [("0", 0), ("minus_1", plus(-1)), ("plus_1", plus(1)), ("max", MAX32),
            ("wraps_32", (1 << 30) + 21)], PLAIN, also="R5103")
bad("R5103", "raw_one_byte_more", "A raw plane has one byte too many, and says so.",
    {"plane.0.parent.stored": lambda b: b + b"\0"}, PLAIN)
bad("R5103", "raw_one_byte_less", "A raw plane has one byte too few, and says so.",
    {"plane.0.m22.stored": lambda b: b[:-1]}, PLAIN, also="R5105")
bad_values("R5103", "stored_size", "stored_size of the last plane is more than what is left",
           "plane.0.m22.stored_size",
           [("plus_1", plus(1)), ("max", MAX32)], PLAIN)
bad("R5103", "raw_0", "stored_size of a raw plane is 0.", {"plane.0.m22.stored_size": 0}, PLAIN,
    also="R5105 R5106")
bad("R5103", "byte_planes_one_byte_more", "A raw plane with packing 1 has one byte too many.",
    {"plane.0.m00.stored": lambda b: b + b"\0"}, GRIDF(m00=Plane(packing=1)))
TEN = zipmap([Patch([0])] + [Patch([1], PLACED)] * 9, GRID_IMAGES)
bad("R5103", "zstd_saves_nothing", "A plane of 10 bytes in a frame of 10 bytes.",
    {"plane.0.source_kind.codec": 1, "plane.0.source_kind.stored": frame(bytes(10))}, TEN)
bad("R5103", "zstd_larger", "A plane of 21 bytes in a frame of 30 bytes.",
    {"plane.0.source_kind.codec": 1, "plane.0.source_kind.stored": frame_header(21)
     + raw_block(bytes(21), True)}, PLAIN)
bad("R5103", "plane_empty", "A plane with codec 1 and no bytes.",
    {"plane.0.m01.stored": b"", "plane.0.m01.codec": 1}, PLAIN)
bad("R5103", "bits_one_byte_more", "A plane of bits has one byte too many.",
    {"plane.0.parent.stored": lambda b: b + b"\0"}, BITS)
bad("R5103", "bits_one_byte_less", "A plane of bits has one byte too few.",
    {"plane.0.parent.stored": lambda b: b[:-1]}, BITS, also="R5105")
bad("R5103", "bits_width_0_one_byte", "A plane of bit_width 0 has a byte.",
    {"plane.0.mask.stored": b"\0"}, BITS)
bad("R5103", "chunk_ends_in_header", "The chunk ends within the header of the last plane.",
    {"decoded.ZPMP": lambda b: b[:-21 * 8 - 1]}, PLAIN)
bad("R5103", "chunk_ends_before_plane", "The last plane is missing.",
    {"decoded.ZPMP": lambda b: b[:-21 * 8 - 32]}, PLAIN)
bad("R5104", "highest_bit", "The highest bit of the last byte is set.",
    {"plane.0.parent.stored": flip_at(-1, 128)}, BITS)
bad("R5104", "lowest_unused_bit", "The lowest unused bit of the last byte is set.",
    {"plane.0.parent.stored": flip_at(-1, 1 << 3)}, BITS)
for name in ("parent", "source_kind", "source0", "mask", "m00", "m22"):
    bad("R5105", name, "The hash of plane %s is wrong." % name,
        {"plane.0.%s.hash" % name: flip(11)}, PLAIN)
bad("R5105", "hash_of_stored", "The hash is that of the bytes before prediction was undone.",
    {"plane.0.m02.hash": lambda h: h ^ 0x1234}, GRIDF(m02=Plane(predictor=1)))
bad("R5106", "one_byte", "A byte follows the last plane.", {"decoded.ZPMP": lambda b: b + b"\0"},
    PLAIN)
bad("R5106", "one_plane", "A fourteenth plane follows.",
    {"decoded.ZPMP": lambda b: b + b[-21 * 8 - 32:]}, PLAIN)
ZP = zipmap(GRID, GRID_IMAGES, planes={"": Plane(), "source_kind": Plane(codec=1),
                                       "parent": Plane(codec=1, packing=1)})
ZEROS = bytes(21)
for rule, name, what, stored, also in (
        ("R5001", "plane_checksum", "The frame of a plane has the checksum flag.",
         frame_header(21, checksum=1) + blocks(ZEROS) + uint(
            xxhash.xxh64_intdigest(ZEROS) & MAX32, 4), ""),
        ("R5002", "plane_plus_1", "The frame of a plane has another content size.",
         frame_header(22) + blocks(bytes(22)), ""),
        ("R5002", "plane_2_32", "The frame of a plane has a content size of 2^32 + 21.",
         frame_header(21 + (1 << 32), 8) + blocks(ZEROS), ""),
        ("R5003", "plane_trailing", "A byte follows the frame of a plane.", frame(ZEROS) + b"\0",
         ""),
        ("R5004", "plane_one_more", "The frame of a plane decodes to one byte more.",
         frame_header(21) + blocks(bytes(22)), "R5105")):
    bad(rule, name, what, {"plane.0.source_kind.stored": stored}, ZP, also)

# ---- 5200: tiles ---------------------------------------------------------------------------------

TILES = File([Image(R8, 130, 20, tile_log2=4, texels=flat(33),
                    codec=stored_zstd)])        # 18 tiles, all zstd: 14 or 16 to 1
RAW_TILES = File([Image(R8, 130, 20, tile_log2=4)])
TAIL = File([Image(R8, 16, 16, texels=flat(1), codec=stored_zstd)])
for value in (3, 224, 255):
    bad("R5201", "codec_%d" % value, "A tile has codec %d." % value, {"tile.0.0.3.codec": value},
        TILES)
for value in (3, 255):
    bad("R5201", "tail_codec_%d" % value, "The tail has codec %d." % value,
        {"tile.0.0.0.codec": value}, TAIL)
for k in range(3):
    bad("R5201", "reserved_%d" % k, "A reserved byte of an index record is not zero.",
        {"tile.0.0.3.reserved": 1 << 8 * k}, TILES)
bad("R5202", "raw_one_byte_more", "A raw tile has one byte too many.",
    {"tile.0.0.3.stored": lambda b: b + b"\0"}, RAW_TILES)
bad("R5202", "raw_one_byte_less", "A raw tile has one byte too few.",
    {"tile.0.0.3.stored": lambda b: b[:-1]}, RAW_TILES, also="R5203")
bad("R5202", "raw_not_clipped", "A tile at the right edge has the size of those in the middle.",
    {"tile.0.0.8.stored": bytes(256)}, RAW_TILES, also="R5203")
bad("R5202", "zstd_0", "A tile with codec 1 has no bytes.", {"tile.0.0.3.stored": b""}, TILES,
    also="R5001")
bad("R5202", "zstd_saves_nothing", "The frame of a tile is as large as the tile.",
    {"tile.0.0.17.codec": 1, "tile.0.0.17.stored": frame_header(8, 1) + rle_block(33,
        1) + rle_block(33, 7, True)},
    TILES)
bad("R5202", "tail_zstd_larger", "The frame of a tail is larger than the tail.",
    {"tile.0.0.0.stored": frame_header(256) + raw_block(b"\1" * 256, True)}, TAIL)
bad("R5202", "tail_raw_less", "A raw tail has one byte too few.",
    {"tile.0.0.0.stored": lambda b: b[:-1]}, File([Image(R8, 5, 5)]), also="R5203")
bad("R5203", "hash", "The hash of a tile is wrong.", {"tile.0.0.3.hash": flip(5)}, TILES)
bad("R5203", "raw_hash", "The hash of a raw tile is wrong.", {"tile.0.0.17.hash": flip(5)},
    RAW_TILES)
bad("R5203", "tail_hash", "The hash of a tail is wrong.", {"tile.0.0.0.hash": flip(5)}, TAIL)
bad("R5203", "zstd_content", "The frame of a tile decodes to other texels.",
    {"tile.0.0.3.stored": frame(b"\x22" * 256)}, TILES)
bad("R5203", "hash_of_stored", "The hash of a tile is that of its stored bytes.",
    {"tile.0.0.3.hash": xxh3(frame(b"\x21" * 256))}, TILES)
bad("R5204", "unit", "The hash of a tile index is wrong.", {"unit.0.0.index_hash": flip(9)}, TILES)
bad("R5204", "tail", "The hash of a tail's index is wrong.", {"unit.0.0.index_hash": flip(9)}, TAIL)
bad("R5204", "index_changed", "A tile index was changed without its hash.",
    {"decoded.TEXL": flip_at(8), "unit.0.0.index_hash": lambda h: h}, TILES, also="R5203")
bad("R5205", "sum_too_small", "A byte lies behind the last tile.",
    {"tile.0.0.17.stored": lambda b: b + b"\0", "tile.0.0.17.stored_size": plus(-1)}, RAW_TILES)
bad("R5205", "sum_too_large", "The stored sizes sum to one more than the unit has.",
    {"tile.0.0.3.stored_size": plus(1)}, TILES, also="R5003")
bad("R5205", "stored_size_max", "A stored size of 2^32 - 1.", {"tile.0.0.3.stored_size": MAX32},
    TILES, also="R5202")
bad("R5205", "two_wrap_32", "Two stored sizes that are right modulo 2^32.",
    {"tile.0.0.3.stored_size": plus(1 << 31), "tile.0.0.4.stored_size": plus(1 << 31)}, TILES,
    also="R5202")
for rule, name, what, stored, also in (
        ("R5001", "tile_window", "The frame of a tile is not single-segment.",
         frame_header(256, single_segment=0, window=0) + blocks(b"\x21" * 256), ""),
        ("R5002", "tile_minus_1", "The frame of a tile has another content size.",
         frame(b"\x21" * 255), "R5203"),
        ("R5003", "tile_trailing", "A byte follows the frame of a tile.",
         frame(b"\x21" * 256) + b"\0", ""),
        ("R5003", "tile_reserved_block", "A block of a tile's frame has type 3.",
         frame_header(256) + block(3, b"\x21", 256, True), ""),
        ("R5004", "tile_one_less", "The frame of a tile decodes to one byte less.",
         frame_header(256) + blocks(b"\x21" * 255), "R5203"),
        ("R5004", "tile_bomb", "The frame of a tile decodes to 1 MiB.",
         frame_header(256) + rle_block(33, 131072) * 7 + rle_block(33, 131072, True), "R5203")):
    bad(rule, name, what, {"tile.0.0.3.stored": stored}, TILES, also)

# ---- 5300: tiles of codec 2, "pred" --------------------------------------------------------------

# Three bases: 8 bits with the colour bit, two tables and four planes; the same with a zero map;
# 16 bits, two planes of four.
PRED = File([pred(RGBA8, 65, 16, colour=True, table_count=2)])
PRED_MAP = File([pred(RGBA8, 130, 9, picture(RGBA8, 130, 9, flat_until=100), colour=True,
                      zero_map=True, table_count=2)])
PRED_16 = File([pred(77, 65, 16, table_count=2)])
PRED_FLAT = File([pred(RGBA8, 65, 3, lambda level, size: b"\1\2\3\4" * 195)])     # no plane coded
PRED_ONES = File([from_residuals(R8, 65, 9, lambda c, x, y: 1)])          # no words
PRED_WIDE = File([from_residuals(R8, 65, 20, lambda c, x, y: 1, lane_code=2)])


def parts(base: File) -> dict:
    """The place of each field of the only tile: name -> (start, end)."""
    places, found = {}, []

    class Watch:
        def get(self, path, value):
            if isinstance(value, (bytes, int)) and not path.endswith("stored"):
                found.append((path.split(".")[-1], 1 if isinstance(value, int) else len(value)))
            return value
    image = base.images[0]
    (_, tiles), = image.units()
    image.codec(0, 0, tiles[0])[1].build(Watch(), "")
    at = 0
    for name, size in found:
        places[name] = at, at + size
        at += size
    return places


def pred_bad(rule, name, what, edits=None, base=PRED, also=""):
    """Edits of fields of the only tile, or of its record: tile.0.0.0.FIELD."""
    bad(rule, "pred_" + name, what, {k if k.startswith("tile.") else "pred.0.0.0." + k: v
                                     for k, v in (edits or {}).items()}, base, also)


def table_of(frequencies: list) -> str:
    """A table of these frequencies, whatever they sum to."""
    out, before = "", 8
    for f in frequencies:
        bits, before = frequency_bits(f, before)
        out += bits
    return out


def pred_anyway(image: Image, n: int, size: int, **how) -> File:
    """An image whose tiles, or tail, have codec 2 where that may not be."""
    def codec(level, tile, data):
        w, h = image.tile_size(level, tile)
        return 2, Tile(Pred(n, size, **how), w, len(data) // (w * n * size), data)
    image.codec = codec
    return File([image])


def framed_anyway(image: Image, n: int) -> Image:
    """An image whose tiles, or tail, have codec 2 with a frame where that may not be."""
    def codec(level, tile, data):
        w, h = image.tile_size(level, tile)
        return 2, Framed(n, pack=frame).tile(w, len(data) // (w * n), data)
    image.codec = codec
    return image


MIXED = pred(R8, 100, 50, levels=7, texels=lambda level, size: bytes([level]) * size)
MIXED.codec = lambda level, tile, data: (2, Tile(Pred(1), *((100, 50) if level == 0
    else (len(data), 1)), data))
bad("R5301", "tail", "A mip tail of one level has codec 2.",
    base=pred_anyway(Image(RGBA8, 64, 16, texels=picture(RGBA8, 64, 16)), 4, 1))
bad("R5301", "tail_no_plane", "A mip tail of one level and one value has codec 2.",
    base=pred_anyway(Image(R8, 16, 16, texels=flat(3)), 1, 1))
bad("R5301", "tail_of_levels", "Level 0 has codec 2, and so has the tail of six levels behind it.",
    base=File([MIXED]))
bad("R5301", "tail_16_bit", "A mip tail of RGBA16 has codec 2.",
    base=pred_anyway(Image(91, 60, 8, texels=picture(91, 60, 8)), 4, 2))
for number, n, size, what in (
        (100, 2, 2, "R32, one channel of 32 bits"), (103, 4, 2, "RG32, two channels of 32 bits"),
        (123, 4, 1, "E5B9G9R9, channels that are not of 8 or 16 bits"),
        (133, 4, 2, "BC1, a block format"), (145, 4, 2, "BC7, a block format"),
        (171, 4, 2, "ASTC 8x8, a block format"), (139, 4, 2, "BC4, a block format")):
    scale = {1: 1, 4: 4, 8: 8}[Image(number, 1, 1).block[0]]
    repeat = Image(number, 1, 1).block[2] // (n * size)
    bad("R5301", "format_%d" % number, "A tile of %s: it has codec 2." % what,
        base=pred_anyway(Image(number, 65 * scale, 4 * scale,
                               texels=lambda level, size: b"\1\2\3\4" * (size // 4)), n, size))
for number, n, size in ((106, 3, 2), (109, 4, 2)):
    bad("R5301", "format_%d" % number, "A tile of %d channels of 32 bits has codec 2." % n,
        base=pred_anyway(Image(number, 65, 4, texels=lambda level, size: bytes(size)), n, size))
bad("R5301", "format_unknown",
    "A tile of a format that the registry does not have, 1000, with blocks of one texel and four "
    "bytes, has codec 2.", base=pred_anyway(Image(1000, 65, 4, block=(1, 1, 4),
                                                  texels=flat(1)), 4, 1))

AT = parts(PRED)
for name, size, what in (
        ("cut_1", 1, "one byte"), ("cut_2", 2, "two bytes"), ("cut_3", 3, "three bytes"),
        ("cut_in_first", AT["first"][1] - 1, "`first` without its last byte"),
        ("cut_no_maps", AT["maps"][0], "no maps"),
        ("cut_in_first_map", AT["maps"][0] + 7, "seven bytes of the first map"),
        ("cut_in_last_map", AT["maps"][1] - 1, "the maps without the last byte")):
    pred_bad("R5302", name, "The tile ends early: %s." % what,
             {"stored": lambda b, size=size: b[:size]})
pred_bad("R5302", "cut_in_first_16_bit", "`first` lacks half a channel.",
         {"stored": lambda b: b[:6]}, PRED_16)
pred_bad("R5302", "cut_in_first_no_plane", "No plane is coded, and `first` lacks a byte.",
         {"stored": lambda b: b[:-1]}, PRED_FLAT)
pred_bad("R5302", "lane_code_3", "Lane code 3.", {"flags": lambda f: f | 12})
pred_bad("R5302", "lane_code_3_no_plane", "Lane code 3 where no plane is coded.",
         {"flags": lambda f: f | 12}, PRED_FLAT, also="R5304")
for bit in range(4, 8):
    if bit >= 6:
        pred_bad("R5302", "flag_bit_%d" % bit, "Reserved bit %d of `flags` is set." % bit,
                 {"flags": flip(bit)})
    pred_bad("R5302", "coded_bit_%d" % bit, "Bit %d of `coded`, for four planes." % bit,
             {"coded": flip(bit)})
pred_bad("R5302", "coded_bit_4_16_bit", "Bit 4 of `coded`, for two channels of 16 bits.",
         {"coded": flip(4)}, PRED_16)
pred_bad("R5302", "coded_bit_1_of_1", "Bit 1 of `coded`, for one channel of 8 bits.",
         {"coded": flip(1)}, PRED_ONES)
pred_bad("R5302", "flag_bit_7_no_plane", "A reserved bit of `flags` where no plane is coded.",
         {"flags": flip(7)}, PRED_FLAT)
for number in (R8, RG8, 70, 83):
    pred_bad("R5303", "colour_%d" % number,
             "The colour bit with %s, format %d." % ("one channel" if number in (R8, 70)
                                                     else "two channels", number),
             {"flags": flip(0)}, File([pred(number, 65, 16)]))
pred_bad("R5303", "colour_no_plane", "The colour bit with one channel where no plane is coded.",
         {"flags": flip(0)}, File([pred(R8, 65, 3, lambda level, size: b"\7" * size)]))
for number in (R8, RG8, 77, 91):
    what = {R8: "one channel", RG8: "two channels"}.get(number, "16 bits")
    pred_bad("R5303", "normal_%d" % number, "The normal bit with %s, format %d." % (what, number),
             {"flags": flip(5)}, File([pred(number, 65, 16)]))
pred_bad("R5303", "normal_and_colour", "The normal bit and the colour bit.", {"flags": flip(5)})
pred_bad("R5303", "normal_and_colour_no_plane", "Both bits where no plane is coded.",
         {"flags": lambda f: f | 33}, PRED_FLAT)
for value in (0, 9, 255):
    pred_bad("R5304", "table_count_%d" % value, "table_count is %d." % value,
             {"table_count": value}, also="R5305" if value == 0 else "")
for value in (1, 2):
    pred_bad("R5304", "no_plane_lane_code_%d" % value,
             "No plane is coded, and the lane code is %d." % value, {"flags": value << 2},
             PRED_FLAT)
pred_bad("R5304", "no_plane_table_count_1", "No plane is coded, and table_count is 1.",
         {"table_count": 1}, PRED_FLAT)
pred_bad("R5304", "no_plane_zero_map", "No plane is coded, and the zero map bit is set.",
         {"flags": 2}, PRED_FLAT)
for count in (1, 2, 64):
    pred_bad("R5304", "no_plane_%d_bytes_more" % count,
             "No plane is coded, and %d zero bytes follow `first`." % count,
             {"stored": lambda b, count=count: b + bytes(count)}, PRED_FLAT)
PRED_1 = File([pred(RG8, 65, 16)])
PRED_8 = File([pred(RG8, 65, 16, texels=picture(RG8, 65, 16, wobble=5), table_count=8)])
for name, position, value, base, what in (
        ("low_half", 0, 0x02, PRED, "the first number is 2, of two tables"),
        ("high_half", 0, 0x20, PRED, "the second number is 2, of two tables"),
        ("last", -1, 0x30, PRED, "the last number of the last map is 3, of two tables"),
        ("15", 9, 0x0F, PRED, "a number of the second map is 15"),
        ("1_of_1", 3, 0x10, PRED_1, "a number is 1, of one table"),
        ("8_of_8", 12, 0x08, PRED_8, "a number is 8, of eight tables"),
        ("unused_activity", -1, 0x20, PRED_ONES, "activity 15, which does not occur, has table 2")):
    pred_bad("R5305", "map_" + name, "A map: %s." % what,
             {"maps": lambda b, position=position, value=value: b[:position % len(b)]
              + bytes([value]) + b[position % len(b) + 1:]}, base)
END = {"states": b"", "words": b""}
for base, stem in ((PRED, "tables"), (PRED_MAP, "zero_map"), (PRED_ONES, "one_table"),
                   (PRED_16, "tables_16_bit")):
    length = parts(base)["bits"][1] - parts(base)["bits"][0]
    for size in sorted({0, 1, 2, length // 2, length - 1}):
        if size < length and (stem != "one_table" or size in (0, length - 1)):
            pred_bad("R5306", "%s_cut_at_%d" % (stem, size),
                     "The tile ends %d bytes into zero map and tables." % size,
                     {"bits": lambda b, size=size: b[:size], **END}, base)
pred_bad("R5306", "zeros_to_the_end", "A table of zero bits, eight, and the end.",
         {"bits": b"\0", **END})
pred_bad("R5306", "table_missing", "table_count is one more than there are tables, and no states.",
         {"table_count": plus(1), **END})
ORDER = symbols(1)
SUM = [1000, 500, 300, 200]
for name, bits, what in (
        ("sum_2049", table_of(SUM + [49]), "The frequencies sum to 2049."),
        ("sum_4094", table_of([4094]), "The first frequency is 4094, K is 11."),
        ("sum_2049_at_once", table_of([2049]), "The first frequency is 2049."),
        ("sum_2047_then_2", table_of([2047, 0, 0, 2]), "A sum of 2047, and a frequency of 2."),
        ("sum_2047", table_of([2047] + [0] * 255), "256 frequencies sum to 2047."),
        ("sum_2047_of_8", table_of([8] * 255 + [7]), "256 frequencies of 8 but the last, 7."),
        ("sum_2049_of_8", table_of([8] * 255 + [9]), "256 frequencies of 8 but the last, 9."),
        ("sum_0", table_of([0] * 256), "256 frequencies of 0."),
        ("k_12", "0" * 8 + "1" + "0" * 12, "The first symbol: z = 8, K = 12."),
        ("k_12_after_0", table_of([0]) + "0" * 24 + "1" + "0" * 12,
         "K = 12 after K = 0: z is 24."),
        ("k_12_after_1", table_of([1]) + "0" * 22 + "1" + "0" * 12,
         "K = 12 after K = 1: z is 22, which alone would be right."),
        ("k_minus_1", "0" * 17 + "1", "The first symbol: z = 17, K = -1."),
        ("k_minus_1_after_0", table_of([0]) + "01", "K = -1 after K = 0: z is 1."),
        ("z_23", table_of([2047]) + "0" * 23 + "1", "z = 23 after K = 11: K = -1."),
        ("z_60", table_of([1]) + "0" * 60 + "1", "z = 60.")):
    for table in (0, 1) if name in ("sum_2049", "k_12", "z_23") else (0,):
        pred_bad("R5307", name + ("_table_1" if table else ""),
                 what + (" The second table." if table else ""),
                 {"table.%d" % table: bits + "1" * 40 if name[0] in "kz" else bits})
pred_bad("R5307", "sum_2049_16_bit", "The frequencies sum to 2049, 16 bits.",
         {"table.0": table_of([2000, 0, 49])}, PRED_16)
pred_bad("R5307", "sum_2047_16_bit", "256 frequencies sum to 2047, 16 bits.",
         {"table.1": table_of([0] * 255 + [2047])}, PRED_16)
for base, stem in ((PRED, ""), (PRED_MAP, "_zero_map"), (PRED_16, "_16_bit"), (PRED_ONES, "_ones")):
    seen = []
    Probe = type("Probe", (), {"get": lambda self, path, value: (seen.append(value)
                 if path.endswith("padding") else None, value)[1]})
    base.images[0].codec(0, 0, base.images[0].tiles(0)[0])[1].build(Probe(), "")
    padding = len(seen[0])
    for name, bit in (("first", 0), ("last", padding - 1)):
        if padding > (name == "last"):
            pred_bad("R5308", "%s_bit%s" % (name, stem),
                     "The %s of %d bits behind the last table is set." % (name, padding),
                     {"padding": lambda p, bit=bit: p[:bit] + "1" + p[bit + 1:]}, base)


def state(lane: int, value: int):
    """An override of one state."""
    return lambda b: b[:4 * lane] + value.to_bytes(4, "little") + b[4 * lane + 4:]


for name, value in (("2_15_minus_1", (1 << 15) - 1), ("0", 0), ("2_31", 1 << 31), ("max", MAX32)):
    for lane in (0, 15):
        pred_bad("R5309", "state_%s_lane_%d" % (name, lane), "A state is %d, lane %d." % (value,
            lane), {"states": state(lane, value)})
pred_bad("R5309", "state_of_lane_63", "The state of lane 63 is 2^15 - 1.",
         {"states": state(63, (1 << 15) - 1)}, PRED_WIDE)
for name, size in (("no_states", 0), ("cut_at_1", 1), ("cut_at_4", 4), ("cut_at_62", 62),
                   ("cut_at_63", 63)):
    pred_bad("R5309", name, "The tile ends %d bytes into the states." % size,
             {"states": lambda b, size=size: b[:size], "words": b""})
pred_bad("R5309", "lane_code_too_large", "Lane code 1 and states for 16 lanes, no words.",
         {"flags": lambda f: f | 4}, PRED_ONES)
pred_bad("R5310", "one_byte_more", "A zero byte behind the words.",
         {"words": lambda b: b + b"\0"}, also="R5311")
pred_bad("R5310", "one_byte_less", "The last word lacks a byte.", {"words": lambda b: b[:-1]},
         also="R5311")
pred_bad("R5310", "one_byte", "A byte behind the states where there are no words.",
         {"words": b"\0"}, PRED_ONES, also="R5311")
pred_bad("R5311", "last_word_missing", "The last word is missing.", {"words": lambda b: b[:-2]})
pred_bad("R5311", "no_words", "All words are missing.", {"words": b""})
pred_bad("R5311", "only_first_word", "All words but the first are missing.",
         {"words": lambda b: b[:2]})
pred_bad("R5311", "one_word_more", "A zero word behind the last one.",
         {"words": lambda b: b + b"\0\0"})
pred_bad("R5311", "one_word_more_8000", "The word 0x8000 behind the last one.",
         {"words": lambda b: b + b"\0\x80"}, PRED_16)
pred_bad("R5311", "word_not_wanted", "A word where none is wanted.", {"words": b"\0\0"}, PRED_ONES)
pred_bad("R5311", "word_not_wanted_zero_map",
         "A zero word behind the last one, in a tile with a zero map.",
         {"words": lambda b: b + b"\0\0"}, PRED_MAP)
pred_bad("R5312", "lane_0", "The only symbol takes all of its table, so the state of lane 0 stays "
         "2^15 + 1; the texels are right.", {"states": state(0, (1 << 15) + 1)}, PRED_ONES)
pred_bad("R5312", "lane_15", "The same with lane 15 and 2^31 - 1.",
         {"states": state(15, (1 << 31) - 1)}, PRED_ONES)
pred_bad("R5312", "lane_63", "The same with the last of 64 lanes and 2^16.",
         {"states": state(63, 1 << 16)}, PRED_WIDE)
NARROW = File([pred(91, 66, 8, tile_log2=4, colour=True, lane_code=1)])
bad("R5312", "pred_unused_lane", "A tile of 16 columns has 32 lanes; the state of lane 31, which "
    "no sample uses, is 2^15 + 1.", {"pred.0.0.1.states": state(31, (1 << 15) + 1)}, NARROW)
bad("R5312", "pred_unused_lane_16", "The same with lane 16 and 2^31 - 1.",
    {"pred.0.0.1.states": state(16, (1 << 31) - 1)}, NARROW)
pred_bad("R5312", "last_word", "The lowest bit of the last word is wrong.",
         {"words": flip_at(-2)}, also="R5311 R5203")
pred_bad("R5312", "last_word_16_bit", "The highest bit of the last word is wrong.",
         {"words": flip_at(-1, 128)}, PRED_16, also="R5311 R5203")
# Hashes and sizes of such tiles.
pred_bad("R5203", "hash", "The hash of a pred tile is wrong.", {"tile.0.0.0.hash": flip(60)})
pred_bad("R5203", "first", "A byte of `first` is wrong: other texels.", {"first": flip_at(1)})
pred_bad("R5203", "colour", "The colour bit is missing: other texels.", {"flags": flip(0)})
pred_bad("R5203", "no_plane", "One colour, and another one was meant.", {"first": flip_at(3, 128)},
         PRED_FLAT)
pred_bad("R5203", "hash_of_stored", "The hash is that of the stored bytes.",
         {"tile.0.0.0.hash": xxh3(bytes.fromhex("00000001020304"))}, PRED_FLAT)
pred_bad("R5202", "as_large", "The stored bytes of a pred tile are as many as the texels.",
         {"stored": lambda b: b + bytes(65 * 16 * 2 - len(b))}, PRED_1, also="R5311")
pred_bad("R5202", "larger", "The stored bytes of a pred tile are more than the texels.",
         {"stored": lambda b: b + bytes(65 * 16 * 2 + 2 - len(b))}, PRED_1, also="R5311")
pred_bad("R5202", "empty", "A pred tile has no bytes.", {"stored": b""},
         File([pred(RGBA8, 65, 32, lambda level, size: b"\1\2\3\4" * (size // 4), tile_log2=4)]),
         also="R5302")
for k in range(3):
    pred_bad("R5201", "reserved_%d" % k, "A reserved byte of the record of a pred tile.",
             {"tile.0.0.0.reserved": 1 << 8 * k})

# ---- 5313: tiles of codec 2 with a frame ----
FRAMED = File([framed(RGBA8, 90, 20, predictor=1)])
FRAMED_SIZE = 90 * 20 * 4
SAMPLES = bytes(FRAMED_SIZE)                # of texels that are 0
BLACK = File([framed(RGBA8, 90, 20, texels=flat(0))])
for bit in (1, 2, 3):
    pred_bad("R5313", "frame_flag_bit_%d" % bit, "A frame, and bit %d of `flags` is set." % bit,
             {"flags": flip(bit)}, FRAMED)
pred_bad("R5313", "no_form", "The tile ends behind `flags`.", {"stored": lambda b: b[:1]}, FRAMED)
pred_bad("R5313", "predictor_3", "Predictor 3.", {"form": 3}, FRAMED)
pred_bad("R5313", "predictor_3_by_texel", "Predictor 3, texel by texel.", {"form": 7}, FRAMED)
for bit in range(3, 8):
    pred_bad("R5313", "form_bit_%d" % bit, "Reserved bit %d of `form` is set." % bit,
             {"form": flip(bit)}, FRAMED)
for bit in (6, 7):
    pred_bad("R5302", "frame_flag_bit_%d" % bit, "A frame, and bit %d of `flags` is set." % bit,
             {"flags": flip(bit)}, FRAMED)
pred_bad("R5303", "frame_colour_r8", "A frame and the colour bit, one channel.", {"flags": flip(0)},
         File([framed(R8, 90, 20)]))
pred_bad("R5303", "frame_normal_r8", "A frame and the normal bit, one channel.", {"flags": flip(5)},
         File([framed(R8, 90, 20)]))
pred_bad("R5303", "frame_normal_16_bit", "A frame and the normal bit, 16 bits.",
         {"flags": flip(5)}, File([framed(91, 90, 20)]))
pred_bad("R5303", "frame_normal_and_colour", "A frame, the normal bit and the colour bit.",
         {"flags": lambda f: f | 33}, FRAMED)
bad("R5301", "frame_tail", "A mip tail has codec 2 with a frame.",
    base=File([framed_anyway(Image(RGBA8, 64, 16, texels=flat(0)), 4)]))
bad("R5301", "frame_format_100", "A tile of R32 has codec 2 with a frame.",
    base=File([framed_anyway(Image(100, 65, 16, texels=flat(0)), 4)]))
for rule, name, what, bytes_of_frame, also in (
        ("R5001", "magic", "The frame's magic number is wrong.",
         frame_header(FRAMED_SIZE, magic=0xFD2FB529) + rle_block(0, FRAMED_SIZE, True), ""),
        ("R5001", "none", "No frame follows `form`.", b"", ""),
        ("R5002", "plus_1", "The content size of the frame is one too large.",
         frame_header(FRAMED_SIZE + 1) + rle_block(0, FRAMED_SIZE, True), "R5004"),
        ("R5002", "one_plane", "The frame holds one plane only, rightly.",
         frame(bytes(FRAMED_SIZE // 4)), "R5004"),
        ("R5003", "trailing", "A byte follows the frame.", frame(SAMPLES) + b"\0", ""),
        ("R5003", "no_last", "No block of the frame is marked as last.",
         frame_header(FRAMED_SIZE) + rle_block(0, FRAMED_SIZE), "R5004"),
        ("R5004", "short", "The blocks hold a byte less than the frame says.",
         frame_header(FRAMED_SIZE) + rle_block(0, FRAMED_SIZE - 1, True), ""),
        ("R5004", "long", "The blocks hold a byte more than the frame says.",
         frame_header(FRAMED_SIZE) + rle_block(0, FRAMED_SIZE + 1, True), ""),
        ("R5203", "frame", "A tile with a frame whose texels are others than the hash says.",
         frame(b"\1" + SAMPLES[1:]), "")):
    pred_bad(rule, "frame_" + name, what, {"frame": bytes_of_frame}, BLACK, also)
pred_bad("R5203", "frame_other_predictor", "The predictor of a frame was changed.", {"form": 2},
         FRAMED)
pred_bad("R5203", "normal_bit", "The normal bit was set afterwards.", {"flags": flip(5)},
         File([pred(RGBA8, 65, 16)]))

# ---- 6000: images --------------------------------------------------------------------------------

PAIR = File([Image(R8, 1, 1), Image(R8, 1, 1, seed=2)], [Texture("a", [(0, 0)])])
bad("R6001", "one_byte_more", "IMAG has a byte too many.", {"decoded.IMAG": lambda b: b + b"\0"})
bad("R6001", "one_byte_less", "IMAG has a byte too few.", {"decoded.IMAG": lambda b: b[:-1]})
bad("R6001", "fifteen_bytes", "IMAG is shorter than its header.",
    {"decoded.IMAG": lambda b: b[:15]})
bad("R6001", "header_only", "IMAG is its header, which promises an image.",
    {"decoded.IMAG": lambda b: b[:16]})
bad_values("R6001", "image_count", "image_count is wrong", "imag.image_count",
           [("0", 0), ("plus_1", plus(1)), ("max", MAX32), ("wraps_32", (1 << 27) + 1)],
           also="R6106 R6010")
bad("R6001", "no_images", "An image_count of 0 and a chunk that agrees.",
    {"decoded.IMAG": bytes(16)}, also="R6106 R6013")
bad_values("R6001", "unit_total", "unit_total is wrong", "imag.unit_total",
           [("0", 0), ("plus_1", plus(1)), ("max", MAX32), ("wraps_32", (1 << 29) + 1)],
           also="R6010")
bad("R6001", "reserved_low", "The reserved field is 1.", {"imag.reserved": 1})
bad("R6001", "reserved_high", "The reserved field is 2^63.", {"imag.reserved": 1 << 63})
bad("R6001", "record_reserved", "The reserved byte of a record is not zero.",
    {"image.0.reserved": 1})
one = lambda *a, **k: File([Image(*a, **k)])
bad("R6002", "width_0", "Width 0.", base=one(R8, 0, 1))
bad("R6002", "height_0", "Height 0.", base=one(R8, 1, 0))
bad("R6002", "depth_0", "Depth 0.", base=one(R8, 1, 1, depth=0))
bad("R6002", "layers_0", "No layers.", {"image.0.layers": 0}, also="R5202 R6004")
bad("R6002", "width_2_20_plus_1", "Width 2^20 + 1.",
    base=one(R8, (1 << 20) + 1, 1, tile_log2=16, texels=flat(1), codec=stored_zstd))
bad("R6002", "height_2_20_plus_1", "Height 2^20 + 1.",
    base=one(R8, 1, (1 << 20) + 1, tile_log2=16, texels=flat(1), codec=stored_zstd))
bad("R6002", "layers_2_16_plus_1", "65,537 layers.",
    base=one(R8, 1, 1, layers=65537, texels=flat(1), codec=stored_zstd))
WIDE = one(R8, 65, 1)
for name, value in (("width", MAX32), ("height", MAX32), ("depth", 16385), ("depth", MAX32),
                    ("layers", MAX32)):
    bad("R6002", "%s_%s" % (name, "max" if value == MAX32 else value),
        "%s %d." % (name.capitalize(), value), {"image.0." + name: value},
        WIDE, also="R5202 R6009 R6012")
bad("R6003", "levels_0", "An image without levels.",
    base=File([Image(R8, 1, 1), Image(R8, 1, 1, levels=0)], [Texture("a", [(0, 0)])]))
bad("R6003", "one_more_1x1", "Two levels of 1 x 1.", base=one(R8, 1, 1, levels=2))
bad("R6003", "one_more_5x3", "Four levels of 5 x 3.", base=one(R8, 5, 3, levels=4))
bad("R6003", "one_more_depth", "Five levels where the depth of 9 gives four.",
    base=one(R8, 2, 2, depth=9, levels=5))
bad("R6003", "one_more_2_20", "Twenty-two levels of 2^20 texels.",
    base=one(R8, 1 << 20, 1, levels=22, tile_log2=16, texels=flat(1), codec=stored_zstd))
bad("R6003", "levels_255", "255 levels.", base=one(R8, 4, 4, levels=255))
bad("R6003", "layers_do_not_count", "Two levels because of two layers: layers are never halved.",
    base=one(R8, 1, 1, layers=2, levels=2))
bad_values("R6004", "tile_log2", "tile_log2", "image.0.tile_log2",
           [("0", 0), ("3", 3), ("17", 17), ("31", 31), ("32", 32), ("255", 255)])
bad("R6004", "tile_above_2_30", "A tile of 65,536 x 16,385 bytes: above 2^30.",
    {"image.0.width": 65536, "image.0.height": 16385, "image.0.tile_log2": 16}, WIDE, also="R5202")
bad("R6004", "tile_2_36", "A tile of 65,536 x 65,536 texels of 16 bytes.",
    {"image.0.width": 65536, "image.0.height": 65536, "image.0.tile_log2": 16}, one(109, 65, 1),
    also="R5202")
bad("R6004", "tile_one_texel_more_at_16_bytes", "Tiles of 8,192 x 8,193 texels of 16 bytes.",
    {"image.0.width": 8192, "image.0.height": 8193, "image.0.tile_log2": 16}, one(109, 65, 1),
    also="R5202")
bad("R6005", "r8_width_2", "R8_UNORM with a block 2 wide.", base=one(R8, 4, 4, block=(2, 1, 1)))
bad("R6005", "r8_height_2", "R8_UNORM with a block 2 high.", base=one(R8, 4, 4, block=(1, 2, 1)))
bad("R6005", "rgba8_bytes_3", "R8G8B8A8_UNORM with 3 bytes.",
    base=one(RGBA8, 4, 4, block=(1, 1, 3)))
bad("R6005", "bc1_bytes_16", "BC1 with 16 bytes a block.", base=one(131, 8, 8, block=(4, 4, 16)))
bad("R6005", "astc_5x4_as_4x5", "ASTC 5x4 with its block turned.",
    base=one(159, 20, 20, block=(4, 5, 16)))
for name, size in (("width_17", (17, 1, 1)), ("height_17", (1, 17, 1)), ("bytes_65", (1, 1, 65)),
                   ("all_255", (255, 255, 255))):
    bad("R6005", "unknown_" + name,
        "An unknown format with a block out of range: %s." % name.replace("_", " "),
        base=one(1000, 4, 4, block=size))
for name in ("block_width", "block_height", "block_bytes"):
    bad("R6005", "unknown_%s_0" % name, "An unknown format with %s 0." % name,
        {"image.0." + name: 0}, one(1000, 4, 4, block=(1, 1, 1)), also="R5202")
    bad("R6005", "known_%s_0" % name, "R8_UNORM with %s 0." % name, {"image.0." + name: 0},
        also="R5202")
bad("R6006", "mode_3", "alpha_mode 3.", base=one(RGBA8, 2, 2, alpha_mode=3))
bad("R6006", "mode_255", "alpha_mode 255.", base=one(RGBA8, 2, 2, alpha_mode=255))
for fmt in (R8, RG8, RGB8, 123, 131, 153):
    for mode in (1, 2):
        bad("R6006", "format_%d_mode_%d" % (fmt, mode),
            "alpha_mode %d for format %d, which has no alpha." % (mode, fmt),
            base=one(fmt, 2, 2, alpha_mode=mode))
bad("R6007", "kind_3", "layer_kind 3.", base=one(R8, 2, 2, layer_kind=3))
bad("R6007", "kind_255", "layer_kind 255.", base=one(R8, 2, 2, layer_kind=255))
bad("R6007", "cube_not_square", "Cube faces of 3 x 2 texels.",
    base=one(R8, 3, 2, layers=6, layer_kind=1))
bad("R6007", "cube_depth_2", "Cube faces of depth 2.",
    base=one(R8, 2, 2, depth=2, layers=6, layer_kind=1))
for n in (1, 5, 7, 13):
    bad("R6007", "cube_%d_faces" % n, "A cube of %d faces." % n,
        base=one(R8, 2, 2, layers=n, layer_kind=1))
for n in (0, 3, 13, 21, 23, 255):
    bad("R6008", "primaries_%d" % n, "Colour primaries %d." % n, base=one(R8, 2, 2, primaries=n))
for n in (0, 3, 19, 255):
    bad("R6008", "transfer_%d" % n, "Transfer characteristics %d." % n,
        base=one(R8, 2, 2, transfer=n))
bad("R6008", "matrix_1", "Matrix coefficients 1.", base=one(R8, 2, 2, matrix=1))
for n in (0, 2, 255):
    bad("R6008", "full_range_%d" % n, "full_range %d." % n, base=one(R8, 2, 2, full_range=n))
for n in (1, 2, 8):
    bad("R6008", "srgb_transfer_%d" % n, "R8G8B8A8_SRGB with transfer %d." % n,
        base=one(RGBA8_SRGB, 2, 2, transfer=n))
bad("R6009", "tiles_2_28", "A level of exactly 2^28 tiles.",
    {"image.0.width": 1 << 20, "image.0.height": 1 << 16, "image.0.tile_log2": 4}, WIDE,
    also="R6012 R5202")
bad("R6009", "tiles_2_32", "A level of 2^32 tiles: a 32-bit count is 0.",
    {"image.0.width": 1 << 20, "image.0.height": 1 << 20, "image.0.tile_log2": 4}, WIDE,
    also="R6012 R5202")
bad("R6009", "bytes_2_53", "An image of exactly 2^53 bytes.",
    {"image.0.width": 1 << 20, "image.0.height": 1 << 20, "image.0.layers": 512,
     "image.0.tile_log2": 13}, one(109, 65, 1), also="R6012 R5202")
bad("R6009", "bytes_2_64", "An image of 2^64 bytes: a 64-bit count is 0.",
    {"image.0.width": 1 << 20, "image.0.height": 1 << 20, "image.0.depth": 1 << 4,
     "image.0.layers": 1 << 16, "image.0.tile_log2": 13},
    one(109, 65, 1), also="R6012 R5202")
bad("R6009", "bytes_largest", "The largest of everything: 2^76 bytes.",
    {"image.0.width": 1 << 20, "image.0.height": 1 << 20, "image.0.depth": 1 << 14,
     "image.0.layers": 1 << 16, "image.0.tile_log2": 11},
    one(1000, 65, 1, block=(1, 1, 64)), also="R6012 R5202")
bad("R6010", "one_more", "A unit record too many, and unit_total counts it.",
    {"imag.unit_total": plus(1), "decoded.IMAG": lambda b: b + uint(17, 8) + uint(17,
        8) + bytes(8)}, also="R6013")
bad("R6010", "one_less", "A unit record too few, and unit_total agrees.",
    {"imag.unit_total": plus(-1), "decoded.IMAG": lambda b: b[:-24]}, PAIR, also="R6013")
bad("R6010", "tail_one_level_early", "A level of 65 texels is in the tail.",
    base=one(R8, 65, 1, levels=7, wrong_tail=0))
bad("R6010", "tail_one_level_late", "A level of 64 texels is a unit and not in the tail.",
    base=one(R8, 64, 1, levels=7, wrong_tail=1))
bad("R6010", "tail_above_262144", "A tail of 262,144 + 32,768 bytes.",
    base=one(R8, 64, 64, depth=64, levels=2, texels=flat(1), codec=stored_zstd, wrong_tail=0))
bad("R6010", "no_tail", "Each of three small levels is a unit.",
    base=one(R8, 5, 3, levels=3, wrong_tail=3))
bad("R6010", "none", "No unit records at all.", {"imag.unit_total": 0,
                                                 "decoded.IMAG": lambda b: b[:-24]}, also="R6013")
TWO_UNITS = File([Image(R8, 65, 1, levels=7, seed=1), Image(R8, 130, 1, levels=8, seed=2)])
bad_values("R6011", "offset", "The offset of a unit is wrong", "unit.0.0.offset",
           [("plus_1", plus(1)), ("minus_1", plus(-1)), ("0", 0), ("max", MAX64),
            ("plus_2_32", plus(1 << 32))], TWO_UNITS)
bad("R6011", "image_by_image", "The units lie image by image, not by size; offsets say so.",
    {"unit_order": lambda key: lambda unit: (unit[1], unit[2])}, TWO_UNITS)
bad("R6011", "fine_before_coarse", "The units lie the other way round, fine before coarse.",
    {"unit_order": lambda key: lambda unit: (-unit[0][0], -unit[0][1])}, TWO_UNITS)
bad("R6011", "same_c_swapped", "Two units of the same size in the wrong order of images.",
    {"unit_order": lambda key: lambda unit: (unit[0][0], -unit[1])},
    File([Image(R8, 66, 1, seed=1), Image(R8, 65, 1, seed=2)]))
bad("R6011", "overlap", "Two units are the same bytes.", {"unit.1.0.offset": 0}, PAIR)
bad("R6012", "empty_tile", "A tail of one tile without bytes: 16 bytes.",
    {"tile.0.0.0.stored": b""}, also="R5202")
bad("R6012", "size_0", "The size of a unit is 0.", {"unit.0.0.size": 0}, also="R6013")
bad("R6012", "size_16_tiles", "The size of a unit is 17 bytes times the number of tiles less one.",
    {"unit.0.0.size": 17 * 18 - 1}, TILES, also="R5205 R6013")
bad("R6013", "texl_one_byte_more", "A byte lies behind the last unit.",
    {"decoded.TEXL": lambda b: b + b"\0"})
bad("R6013", "texl_one_byte_less", "The last byte of the last unit is missing.",
    {"decoded.TEXL": lambda b: b[:-1]}, RAW_TILES)
bad("R6013", "last_size_plus_1", "The last unit says that it has a byte more.",
    {"unit.1.0.size": plus(1)}, PAIR, also="R5205")
bad("R6013", "size_max", "A unit of 2^64 - 1 bytes.", {"unit.1.0.size": MAX64}, PAIR, also="R5205")
bad("R6013", "sum_wraps_64", "The sizes sum to the right number modulo 2^64, the offsets too.",
    {"unit.0.0.size": plus(1 << 63), "unit.1.0.size": plus(1 << 63),
     "unit.1.0.offset": plus(1 << 63)}, PAIR, also="R5205 R6011")

# ---- 6100: textures ------------------------------------------------------------------------------

bad("R6101", "one_byte_more", "TEXS has a byte too many.", {"decoded.TEXS": lambda b: b + b"x"})
bad("R6101", "one_byte_less", "TEXS has a byte too few.", {"decoded.TEXS": lambda b: b[:-1]})
bad("R6101", "fifteen_bytes", "TEXS is shorter than its header.",
    {"decoded.TEXS": lambda b: b[:15]})
for name, values in (("texture_count", [("plus_1", plus(1)), ("max", MAX32),
                                        ("wraps_32", (1 << 28) + 1)]),
                     ("layer_total", [("0", 0), ("plus_1", plus(1)), ("max", MAX32),
                                      ("wraps_32", (1 << 29) + 1)]),
                     ("name_bytes", [("0", 0), ("minus_1", plus(-1)), ("plus_1", plus(1)),
                                     ("max", MAX32)])):
    bad_values("R6101", name, name + " is wrong", "texs." + name, values)
bad("R6101", "layer_sum", "A texture says that it has a layer more.", {"texture.0.layer_count": 2})
bad("R6101", "layer_sum_wraps", "layer_counts that sum to layer_total modulo 2^32.",
    {"texture.0.layer_count": plus(1 << 31), "texture.1.layer_count": plus(1 << 31)},
    File([Image(R8, 1, 1)], [Texture("a", [(0, 0)]), Texture("b", [(0, 0)])]), also="R6105")
bad("R6101", "name_sum", "A name says that it is shorter.", {"texture.0.name_size": plus(-1)})
bad("R6102", "none", "No texture; the chunk is its header.", base=File([Image(R8, 1, 1)], []))
for value in (4, 5, 224, 255):
    bad("R6103", "kind_%d" % value, "Texture kind %d." % value,
        {"texture.0.kind": value, "layer.0.0.image": NONE})
for name in ("wrap_u", "wrap_v", "wrap_w"):
    bad_values("R6104", name, name, "texture.0." + name, [("4", 4), ("255", 255)])
bad("R6104", "texture_reserved", "The reserved field of a texture is not zero.",
    {"texture.0.reserved": 1 << 31})
bad("R6104", "layer_reserved", "The reserved field of a layer is not zero.",
    {"layer.0.0.reserved": 1})
bad("R6104", "header_reserved", "The reserved field of the header is not zero.",
    {"texs.reserved": 1})
bad("R6105", "no_layers", "A texture without layers.",
    base=File([Image(R8, 1, 1)], [Texture("a", [(0, 0)]), Texture("b", [])]))
bad("R6105", "layers_33", "A texture of 33 layers.",
    base=File([Image(R8, 1, 1)], [Texture("a", [(0, 0)] * 33)]))
bad("R6105", "layers_max", "layer_count 2^32 - 1.", {"texture.0.layer_count": MAX32}, also="R6101")
bad_values("R6106", "image", "The image of a layer does not exist", "layer.0.0.image",
           [("count", 1), ("none", NONE), ("2_31", 1 << 31)])
bad("R6106", "zipmap_with_image", "A layer of a zipmap names an image.", {"layer.0.0.image": 0},
    ZIP)
bad("R6106", "zipmap_fffffffe", "A layer of a zipmap has 0xFFFFFFFE.",
    {"layer.0.0.image": NONE - 1}, ZIP)
BAD_UTF8 = (("lone_continuation", b"a\x80"), ("overlong_2", b"\xc0\x80"),
            ("overlong_2_c1", b"\xc1\xbf"), ("overlong_3", b"\xe0\x9f\xbf"),
            ("overlong_4", b"\xf0\x8f\xbf\xbf"), ("surrogate_first", b"\xed\xa0\x80"),
            ("surrogate_last", b"\xed\xbf\xbf"),
            ("above_10ffff", b"\xf4\x90\x80\x80"), ("f5", b"\xf5\x80\x80\x80"),
            ("five_bytes", b"\xf8\x88\x80\x80\x80"), ("ff", b"\xff"),
            ("cut_2", b"a\xc3"), ("cut_3", b"a\xe2\x82"), ("cut_4", b"a\xf0\x9f\xa7"),
            ("latin_1", b"Stra\xdfe"))
CONTROLS = (("nul", b"a\0b"), ("u_1f", b"a\x1f"), ("line_feed", b"a\nb"), ("u_7f", b"a\x7f"))
named = lambda name: File([Image(R8, 1, 1)], [Texture(name, [(0, 0)])])
bad("R6107", "length_256", "A name of 256 bytes.", base=named("n" * 256))
bad("R6107", "across_names", "A character is cut in two by the end of a name.",
    base=File([Image(R8, 1, 1)], [Texture(b"a\xc3", [(0, 0)]), Texture(b"\xa4", [(0, 0)])]))
for name, text in BAD_UTF8:
    bad("R6107", name, "A name that is not UTF-8: %s." % name.replace("_", " "), base=named(text))
for name, text in CONTROLS:
    bad("R6107", "control_" + name, "A name with a control character: %s." % name.replace("_", " "),
        base=named(text))
bad("R6108", "same", "Two textures of one name.", base=File([Image(R8, 1, 1)],
    [Texture("a", [(0, 0)]), Texture("a", [(0, 0)])]))
bad("R6108", "same_apart", "The first and the last of three textures have one name.",
    base=File([Image(R8, 1, 1)], [Texture("a", [(0, 0)]), Texture("b", [(0, 0)]),
                                  Texture("a", [(0, 0)])]))
for name, image in (("width", Image(R8, 3, 2)), ("height", Image(R8, 2, 1)),
                    ("depth", Image(R8, 2, 2, depth=2)),
                    ("layers", Image(R8, 2, 2, layers=2)),
                    ("layer_kind", Image(R8, 2, 2, layer_kind=2))):
    bad("R6109", name, "Two layers of a texture differ in %s." % name,
        base=File([Image(R8, 2, 2), image], [Texture("a", [(0, 0), (4, 1)])]))
bad("R6110", "no_zpmp", "A zipmap without its chunk.",
    {"chunks": lambda cs: [c for c in cs if c.type != "ZPMP"]}, ZIP)
bad("R6110", "zpmp_more", "Two ZPMP chunks for one zipmap.",
    {"chunks": lambda cs: cs[:3] + [Chunk(**vars(cs[2]))] + cs[3:]}, ZIP)
bad("R6110", "zpmp_without_zipmap", "A ZPMP chunk in a file without zipmaps.",
    {"texture.0.kind": 0, "layer.0.0.image": 0}, ZIP)

# ---- 7000: metadata ------------------------------------------------------------------------------

pairs = lambda *kv: dot(meta=list(kv))
bad("R7001", "no_pairs", "No pairs.", base=pairs())
bad("R7001", "one_byte_more", "META has a byte too many.", {"decoded.META": lambda b: b + b"\0"},
    DOT_META)
bad("R7001", "one_byte_less", "META has a byte too few.", {"decoded.META": lambda b: b[:-1]},
    DOT_META)
bad("R7001", "seven_bytes", "META is shorter than its header.", {"decoded.META": lambda b: b[:7]},
    DOT_META)
bad_values("R7001", "pair_count", "pair_count is wrong", "meta.pair_count",
           [("minus_1", plus(-1)), ("plus_1", plus(1)), ("max", MAX32),
            ("wraps_32", (1 << 29) + 2)], DOT_META, also="R7002 R7003")
bad_values("R7001", "value_size", "The size of a value is wrong", "pair.1.value_size",
           [("plus_1", plus(1)), ("minus_1", plus(-1)), ("max", MAX32)], DOT_META)
bad("R7001", "sizes_wrap_32", "Sizes that sum to the right number modulo 2^32.",
    {"pair.0.value_size": plus(1 << 31), "pair.1.value_size": plus(1 << 31)}, DOT_META)
bad("R7001", "reserved", "The reserved field is not zero.", {"meta.reserved": 1}, DOT_META)
bad("R7002", "empty_key", "An empty key.", base=pairs(("", "v")))
bad("R7002", "length_256", "A key of 256 bytes.", base=pairs(("k" * 256, "v")))
for name, text in BAD_UTF8[:1] + BAD_UTF8[3:6] + BAD_UTF8[-2:]:
    bad("R7002", name, "A key that is not UTF-8: %s." % name.replace("_", " "),
        base=pairs((text, "v")))
for name, text in CONTROLS:
    bad("R7002", "control_" + name, "A key with a control character: %s." % name.replace("_", " "),
        base=pairs((text, "v")))
bad("R7003", "descending", "Keys in descending order.", base=pairs(("b", "1"), ("a", "2")))
bad("R7003", "twice", "A key twice.", base=pairs(("a", "1"), ("a", "2")))
bad("R7003", "longer_first", "A key before the key that it begins with.",
    base=pairs(("ab", "1"), ("a", "2")))
bad("R7003", "signed_bytes", "Keys in the order of signed bytes.",
    base=pairs(("\u00e4", "1"), ("a", "2")))
bad("R7003", "utf16_order", "Keys in the order of UTF-16.",
    base=pairs(("\U00010000", "1"), ("\uffff", "2")))
for name, text in BAD_UTF8[:1] + BAD_UTF8[3:7] + BAD_UTF8[-2:]:
    bad("R7004", name, "A value that is not UTF-8: %s." % name.replace("_", " "),
        base=pairs(("k", text)))
bad("R7004", "nul", "A value with U+0000.", base=pairs(("k", "a\0b")))
bad("R7004", "nul_last", "A value that ends in U+0000, as strings of C do.",
    base=pairs(("k", "a\0")))
for name, key in (("unknown", "zt.unknown"), ("case", "zt.Title"), ("longer", "zt.title2"),
                  ("prefix_only", "zt.")):
    bad("R7005", name, "The key `%s` is not in the registry: a warning." % key,
        base=pairs((key, "v")), severity="warning")

# ---- 8100: zipmaps -------------------------------------------------------------------------------

bad("R8101", "fifteen_bytes", "The chunk is shorter than its header.",
    {"decoded.ZPMP": lambda b: b[:15]}, ZIP)
bad("R8101", "reserved_low", "The reserved field is 1.", {"zpmp.0.reserved": 1}, ZIP)
bad("R8101", "reserved_high", "The reserved field is 2^63.", {"zpmp.0.reserved": 1 << 63}, ZIP)
bad_values("R8101", "layer_count", "layer_count is not the texture's", "zpmp.0.layer_count",
           [("0", 0), ("2", 2), ("max", MAX32)], ZIP,
           also="R5102 R5103 R5106")
bad_values("R8101", "patch_count", "patch_count is out of range", "zpmp.0.patch_count",
           [("0", 0), ("2_24_plus_1", (1 << 24) + 1), ("max", MAX32)],
           ZIP, also="R5102")


def zip_bad(rule, name, what, patches, images=None, also="", **more):
    bad(rule, name, what, base=zipmap(patches, images or [root(), decal()], **more), also=also)


changed = lambda k, v: IDENTITY[:k] + (v,) + IDENTITY[k + 1:]
second = Patch([1], PLACED)
zip_bad("R8102", "parent", "The root has parent 1.", [Patch([0], parent=1), second])
zip_bad("R8102", "parent_none", "The root has parent 0xFFFFFFFF.",
        [Patch([0], parent=NONE), second])
zip_bad("R8102", "source_kind", "The root's source is a texture.",
        [Patch([0], source_kind=1), second], before=[PATTERN])
zip_bad("R8102", "mask", "The root has a mask.", [Patch([0], mask=2), second],
        [root(), decal(), mask()])
zip_bad("R8102", "mask_0", "The root's mask is image 0, of one channel.",
        [Patch([0], mask=0), second], [mask(), decal()])
for k in range(9):
    zip_bad("R8102", "matrix_%d%d" % (k // 3, k % 3),
            "An entry of the root's matrix differs from the identity.",
            [Patch([0], changed(k, 0.5)), second])
zip_bad("R8102", "one_ulp", "An entry of the root's matrix is 1 + 2^-52.",
        [Patch([0], changed(0, 1 + 2.0 ** -52)), second])
zip_bad("R8102", "scaled_identity", "The root's matrix is twice the identity, which maps alike.",
        [Patch([0], tuple(2 * x for x in IDENTITY)), second])
zip_bad("R8103", "self", "A patch is its own parent.", [Patch([0]), Patch([1], PLACED, parent=1)])
zip_bad("R8103", "cycle", "Two patches are each other's parent.",
        [Patch([0]), Patch([1], PLACED, parent=2), Patch([1], PLACED, parent=1)])
zip_bad("R8103", "later", "The parent comes later.",
        [Patch([0]), Patch([1], PLACED, parent=2), Patch([1], PLACED)])
zip_bad("R8103", "count", "The parent does not exist.", [Patch([0]), Patch([1], PLACED, parent=2)])
zip_bad("R8103", "max", "The parent is 0xFFFFFFFF.", [Patch([0]), Patch([1], PLACED, parent=NONE)])
zip_bad("R8104", "kind_2", "source_kind 2.", [Patch([0]), Patch([1], PLACED, source_kind=2)])
zip_bad("R8104", "kind_255", "source_kind 255.", [Patch([0]), Patch([1], PLACED, source_kind=255)])
for name, value in (("count", 2), ("max", NONE)):
    zip_bad("R8105", "image_" + name, "A source is image %d, which does not exist." % value,
            [Patch([0]), Patch([value], PLACED)])
    zip_bad("R8105", "root_image_" + name, "The root's image does not exist.",
            [Patch([value]), second])
zip_bad("R8105", "second_layer", "The second layer's image does not exist.",
        [Patch([0, 0]), Patch([1, 2], PLACED)], layers=2)
zip_bad("R8105", "texture_self", "The source is the texture itself.",
        [Patch([0]), Patch([1], PLACED, source_kind=1)], before=[PATTERN])
zip_bad("R8105", "texture_count", "The source texture does not exist.",
        [Patch([0]), Patch([2], PLACED, source_kind=1)], before=[PATTERN])
bad("R8105", "texture_later", "The source is a later texture.", base=File([root(), decal()], [
    Texture("zip", [(0, NONE)], zipmap=Zipmap([Patch([0]), Patch([1], PLACED, source_kind=1)])),
    PATTERN]))
bad("R8105", "texture_cycle", "Two zipmaps are each other's source.", base=File([root(), decal()], [
    Texture("a", [(0, NONE)], zipmap=Zipmap([Patch([0]), Patch([1], PLACED, source_kind=1)])),
    Texture("b", [(0, NONE)], zipmap=Zipmap([Patch([0]), Patch([0], PLACED, source_kind=1)]))]))
TWO_LAYERS = [Texture("p", [(0, 1), (0, 1)]), Texture("q", [(0, 1), (0, 1)])]
zip_bad("R8105", "textures_differ", "The layers of a patch name different textures.",
        [Patch([0, 0]), Patch([0, 1], PLACED, source_kind=1)],
        layers=2, before=TWO_LAYERS)
zip_bad("R8105", "texture_layers", "The source texture has one layer, the zipmap two.",
        [Patch([0, 0]), Patch([0, 0], PLACED, source_kind=1)],
        layers=2, before=[PATTERN])
zip_bad("R8105", "texture_layers_more", "The source texture has two layers, the zipmap one.",
        [Patch([0]), Patch([0], PLACED, source_kind=1)],
        before=TWO_LAYERS)
MASKED = [Patch([0]), Patch([1], PLACED, mask=2)]
RGB = Image(29, 4, 4, seed=2)
zip_bad("R8106", "count", "The mask does not exist.", [Patch([0]), Patch([1], PLACED, mask=3)],
        [root(), RGB, mask()])
zip_bad("R8106", "fffffffe", "The mask is 0xFFFFFFFE.",
        [Patch([0]), Patch([1], PLACED, mask=NONE - 1)], [root(), RGB, mask()])
for fmt in (RG8, RGB8, RGBA8):
    zip_bad("R8106", "format_%d" % fmt, "The mask has more than one channel: format %d." % fmt,
            MASKED,
            [root(), RGB, Image(fmt, 4, 4, texels=flat(0))])
zip_bad("R8107", "neither", "No alpha and no mask.", [Patch([0]), second], [root(), RGB])
zip_bad("R8107", "alpha_mode_0", "Four channels, alpha_mode 0 and no mask.", [Patch([0]), second],
        [root(), decal(alpha_mode=0)])
zip_bad("R8107", "both", "Alpha and a mask.", MASKED, [root(), decal(), mask()])
zip_bad("R8107", "alpha_in_second_layer", "The alpha is in the second layer.",
        [Patch([0, 0]), Patch([1, 2], PLACED)], [root(), RGB, decal()], layers=2)
zip_bad("R8108", "root_volume", "The root is a volume.", [Patch([0])], [root(depth=2)])
zip_bad("R8108", "root_cube", "The root is a cube.", [Patch([0])], [root(layers=6, layer_kind=1)])
zip_bad("R8108", "patch_volume", "A patch is a volume.", [Patch([0]), second],
        [root(), Image(RGBA8, 2, 2, depth=2, alpha_mode=1, texels=flat(0))])
zip_bad("R8108", "patch_cube", "A patch is a cube, the root has six layers.", [Patch([0]), second],
        [root(layers=6), Image(RGBA8, 2, 2, layers=6, layer_kind=1, alpha_mode=1, texels=flat(0))])
zip_bad("R8108", "patch_layers", "A patch has two array layers, the root one.",
        [Patch([0]), second], [root(), decal(layers=2)])
zip_bad("R8108", "patch_layers_fewer", "A patch has two frames, the root three.",
        [Patch([0]), second],
        [root(layers=3, layer_kind=2), decal(layers=2, layer_kind=2)])
zip_bad("R8108", "second_layer_image",
        "The second layer's image has three frames, the root's first image one.",
        [Patch([0, 1])], [root(), root(layers=3, layer_kind=2)], layers=2)
zip_bad("R8108", "mask_layers", "A mask has two array layers, the root one.", MASKED,
        [root(), RGB, Image(R8, 4, 4, layers=2, texels=flat(0))])
zip_bad("R8108", "mask_volume", "A mask is a volume.", MASKED,
        [root(), RGB, Image(R8, 2, 2, depth=2, texels=flat(0))])
NAN, INF, NEGATIVE_ZERO = 0x7FF8000000000000, 0x7FF0000000000000, 1 << 63
for name, bits in (("nan", NAN), ("nan_signalling", INF | 1), ("nan_negative", NAN | NEGATIVE_ZERO),
                   ("infinity", INF),
                   ("minus_infinity", INF | NEGATIVE_ZERO), ("negative_zero", NEGATIVE_ZERO)):
    k = 3
    zip_bad("R8109", name, "An entry m10 is %s." % name.replace("_", " "),
            [Patch([0]), Patch([1], PLACED[:k] + (bits,) + PLACED[k + 1:])],
            also="" if name == "negative_zero" else "R8110")
zip_bad("R8109", "root_negative_zero",
        "An entry of the root's matrix is negative zero, which equals zero.",
        [Patch([0], IDENTITY[:1] + (NEGATIVE_ZERO,) + IDENTITY[2:]), second], also="R8102")
zip_bad("R8109", "last_entry", "m22 of the last patch is NaN.",
        [Patch([0]), second, Patch([1], PLACED[:8] + (NAN,))], also="R8110 R8111")


def matrix_bad(rule, name, what, *matrix, also=""):
    zip_bad(rule, name, what, [Patch([0]), Patch([1], matrix)], also=also)


matrix_bad("R8110", "zero", "All entries are zero.", *[0.0] * 9, also="R8111")
matrix_bad("R8110", "rank_1", "A matrix of rank 1.", 1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 3.0, 6.0, 9.0,
           also="R8111")
matrix_bad("R8110", "rank_2",
           "Two equal rows; valid one ulp away (matrix_one_ulp_from_singular).",
           1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, also="R8111")
matrix_bad("R8110", "zero_scale", "A scale of zero in x.", 0.0, 0.0, 0.5, 0.0, 2.0, 0.0, 0.0, 0.0,
           1.0, also="R8111")
matrix_bad("R8110", "zero_row_2", "w' is 0 everywhere.", 2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0,
           0.0)
matrix_bad("R8110", "determinant_underflows", "A determinant of 2^-1080 is zero in binary64.",
           2.0 ** -540, 0.0, 0.0, 0.0, 2.0 ** -540, 0.0, 0.0, 0.0, 1.0, also="R8111")
matrix_bad("R8110", "determinant_overflows", "A determinant of 2^1200 is infinite in binary64.",
           2.0 ** 600, 0.0, 0.0, 0.0, 2.0 ** 600, 0.0, 0.0, 0.0, 1.0)
HUGE = (2.0 ** 600, 0.0, 0.0, 0.0, 2.0 ** -600, 0.0, 0.0, 0.0, 1.0)
zip_bad("R8110", "composed_overflows",
        "Two scales of 2^600 in x, one upon the other, overflow; each alone is right.",
        [Patch([0]), Patch([1], HUGE), Patch([1], HUGE, parent=1)], also="R8111")
TINY = (2.0 ** -600, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
zip_bad("R8110", "composed_underflows",
        "Two scales of 2^-600 in x, one upon the other, are zero; each alone is right.",
        [Patch([0]), Patch([1], TINY), Patch([1], TINY, parent=1)], also="R8111")
matrix_bad("R8110", "zero_unfused",
           "The determinant is zero with each operation rounded, and not if fused.",
           1.2550690323114395, 0.0294796759262681, 0.12385877221822739, 0.19024061132222414,
           1.4494910649955273,
           0.11806131061166525, 0.7226548218168318, 0.7394853704608977, 0.12096004141494632)
matrix_bad("R8111", "sign_unfused",
           "The determinant is negative with each operation rounded, and not if fused.",
           1.2216916680335999, 0.19092524889856577, 0.10947189759463072, 0.23479175474494696,
           1.4958122447133064,
           0.13821489457041025, 0.7282417113892734, 0.8433687468059361, 0.12384339608252048)
matrix_bad("R8111", "corner_11_order",
           "(A20 + A21) + A22 is zero in the order of the specification, 2^-54 in another.",
           1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.75, 0.25 - 2.0 ** -54, 1.0)
matrix_bad("R8111", "a22_zero", "A22 is zero: the corner (0, 0) lies at infinity.", 1.0, 0.0, 0.0,
           0.0, 0.0, 1.0, 0.0, 1.0, 0.0)
matrix_bad("R8111", "corner_10_zero",
           "A20 + A22 is zero; valid one ulp away (matrix_corner_one_ulp_from_infinity).",
           1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0)
matrix_bad("R8111", "corner_10_behind", "A20 + A22 has the other sign.", 1.0, 0.0, 0.0, 0.0, 1.0,
           0.0, 2.0, 0.0, 1.0)
matrix_bad("R8111", "corner_01_zero", "A21 + A22 is zero.", 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0,
           1.0)
matrix_bad("R8111", "corner_01_behind", "A21 + A22 has the other sign.", 1.0, 0.0, 0.0, 0.0, 1.0,
           0.0, 0.0, 2.0, 1.0)
matrix_bad("R8111", "corner_11_zero", "Only the sum of all three is zero.", 1.0, 0.0, 0.0, 0.0, 1.0,
           0.0, 0.5, 0.5, 1.0)
matrix_bad("R8111", "corner_11_behind", "Only the sum of all three has the other sign.", 1.0, 0.0,
           0.0, 0.0, 1.0, 0.0, 0.75, 0.5, 1.0)
matrix_bad("R8111", "all_behind", "w' is negative all over the patch.", -2.0, 0.0, 1.0, 0.0, -2.0,
           1.0, 0.0, 0.0, -1.0)


def border(rule_name, what, x, y, level=0, width=6, height=5, levels=1, as_mask=False, fmt=RGBA8,
           size=4, channel=3, value=b"\1", layers=1, layer=0, **more):
    """A file whose coverage is not zero at one texel of one level."""
    image = mask(width, height, levels) if as_mask else decal(width, height, levels, layers,
        format=fmt, pixel=bytes(size), clear=bytes(size), **more)
    right = image.texels

    def texels(k, total):
        data = bytearray(right(k, total))
        if k == level:
            w, h, _ = image.size(k)
            at = ((layer * h + y % h) * w + x % w) * (1 if as_mask else size) + (0 if as_mask
                else channel)
            data[at:at + len(value)] = value
        return bytes(data)
    image.texels = texels
    patches, images = (MASKED, [root(layers=layers), RGB, image]) if as_mask else ([Patch([0]),
        second], [root(layers=layers), image])
    zip_bad("R8112", rule_name, what, patches, images)


border("top", "A texel in the middle of the first row has coverage 1 of 255.", 3, 0)
border("bottom", "A texel in the middle of the last row has coverage.", 3, -1)
border("left", "A texel in the middle of the first column has coverage.", 0, 2)
border("right", "A texel in the middle of the last column has coverage.", -1, 2)
border("corner_first", "The first texel has coverage.", 0, 0)
border("corner_last", "The last texel has coverage.", -1, -1)
border("straight", "Coverage on the border, with straight alpha.", 3, 0, alpha_mode=1)
border("level_1", "A texel in the last row of level 1 has coverage.", 1, -1, level=1, levels=3)
border("level_1x1", "The only texel of the last level has coverage.", 0, 0, level=2, levels=3)
border("mask", "A mask is not zero in its last column.", -1, 2, as_mask=True)
border("mask_level_1", "A mask is not zero in the first column of level 1.", 0, 1, level=1,
       levels=2, as_mask=True)
border("second_frame", "The second frame has coverage on its border.", 2, 0, layers=2, layer=1,
       layer_kind=2)
border("tiled", "A texel in the last column of a tiled image has coverage.", -1, 9, width=70,
       height=18, tile_log2=4)
border("16_bit_low_byte", "16-bit coverage of 1 of 65,535.", 2, 0, fmt=91, size=8, channel=6)
border("16_bit_high_byte", "16-bit coverage of 256 of 65,535.", 2, 0, fmt=91, size=8, channel=7)
border("half_denormal", "Half float coverage of 2^-24.", 2, 0, fmt=97, size=8, channel=6)
border("half_nan", "Half float coverage that is NaN.", 2, 0, fmt=97, size=8, channel=6,
       value=b"\x00\x7e")
border("float_denormal", "Float coverage of 2^-149.", 2, 0, fmt=109, size=16, channel=12)
zip_bad("R8112", "image_is_root_too",
        "The image is that of the root, which needs no border, and of a patch, which does.",
        [Patch([0]), Patch([0], PLACED)], [Image(RGBA8, 4, 4, alpha_mode=1, texels=flat(1))])
