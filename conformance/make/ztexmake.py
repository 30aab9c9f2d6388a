# SPDX-License-Identifier: Apache-2.0
"""Writes .ztex files field by field, with the names of spec/ztex.md, spec/zipmap.md,
spec/silmap.md and spec/umbrella.md.

A `File` is a description: images, textures, metadata, other chunks. `File.build()` turns it into
bytes, computing every size, offset and hash. Any field can be replaced on the way by an *override*,
a path and a value:

    preamble.FIELD              entry.TYPE.FIELD         head.TYPE.FIELD  (2nd ZPMP: ZPMP1)
    texs.FIELD                  texture.T.FIELD          layer.T.L.FIELD          name.T
    imag.FIELD                  image.I.FIELD            unit.I.U.FIELD           tile.I.U.N.FIELD
    index.I.U                   pred.I.U.N.FIELD     (predmake.py)
    zpmp.Z.FIELD                plane.Z.NAME.FIELD       meta.FIELD               pair.P.FIELD
    slmp.S.FIELD                slmp.S.PLANE.FIELD   (silmake.py)
    umbr.U.FIELD                umbr.U.PLANE.FIELD   (umbmake.py)
    stored.TYPE  decoded.TYPE  padding.TYPE  gap.TYPE (behind the padding)  unit_order  chunks  file

The value is a number, bytes, or a function of the value that would have stood there. Everything
computed later (hashes, offsets, the directory) sees the replaced value, so a malformed file is a
good one with a single edit, resealed. A path that nothing asks for is an error, which finds typing
mistakes."""

import math
import os
import re
import struct
from dataclasses import dataclass, field
from typing import Callable, Optional

import xxhash

SPEC = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..",
                                     "spec"))
MAGIC = bytes.fromhex("AB 5A 54 45 58 BB 0D 0A 1A 0A")
HEAD_MAGIC = bytes.fromhex("AB 5A 54 63 68 6B BB 0A")
NONE = 0xFFFFFFFF
KNOWN_FLAGS = {"TEXS": 1, "IMAG": 1, "ZPMP": 1, "SLMP": 1, "UMBR": 1, "TEXL": 1,
               "META": 2}
IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
MATRIX_NAMES = ["m%d%d" % (r, c) for r in range(3) for c in range(3)]


# ---- small things --------------------------------------------------------------------------------

def xxh3(data: bytes) -> int:
    """XXH3-64, seed 0."""
    return xxhash.xxh3_64_intdigest(data)


def align16(x: int) -> int:
    return (x + 15) // 16 * 16


def ceil_div(a: int, b: int) -> int:
    return -(-a // b)


def uint(value: int, size: int) -> bytes:
    """An unsigned little-endian integer of `size` bytes; larger or negative values wrap."""
    return (value % (1 << 8 * size)).to_bytes(size, "little")


def f64_bits(x: float) -> int:
    return struct.unpack("<Q", struct.pack("<d", x))[0]


def f32_bits(x: float) -> int:
    return struct.unpack("<I", struct.pack("<f", x))[0]


def noise(size: int, seed: int) -> bytes:
    """Bytes without pattern, the same everywhere: a 64-bit linear congruential generator, top byte
    of each state."""
    out = bytearray()
    state = (seed * 2862933555777941757 + 3037000493) % (1 << 64)
    for _ in range(size):
        state = (state * 6364136223846793005 + 1442695040888963407) % (1 << 64)
        out.append(state >> 56)
    return bytes(out)


def plus(n: int) -> Callable[[int], int]:
    """An override that adds n to the right value."""
    return lambda value: value + n


def flip(bit: int = 0) -> Callable[[int], int]:
    """An override that flips one bit of the right value."""
    return lambda value: value ^ (1 << bit)


def flip_at(position: int, mask: int = 1) -> Callable[[bytes], bytes]:
    """An override for bytes: XOR of one byte (a negative position counts from the end)."""
    def edit(data: bytes) -> bytes:
        out = bytearray(data)
        out[position] ^= mask
        return bytes(out)
    return edit


class Overrides:
    """Values that replace computed ones, and the record of which were asked for."""

    def __init__(self, values: dict):
        self.values = dict(values)
        self.used = set()

    def get(self, path: str, value):
        if path not in self.values:
            return value
        self.used.add(path)
        new = self.values[path]
        return new(value) if callable(new) else new

    def pack(self, path: str, fields: list) -> bytes:
        """Fields are (name, size in bytes, number) or (name, size, bytes); each can be overridden
        as path.name."""
        out = b""
        for name, size, value in fields:
            value = self.get(path + "." + name, value)
            out += value if isinstance(value, bytes) else uint(value, size)
        return out

    def check_all_used(self):
        unused = set(self.values) - self.used
        if unused:
            raise ValueError("overrides that no field asked for: %s" % sorted(unused))


# ---- zstd frames by hand (RFC 8878) --------------------------------------------------------------

def block(kind: int, data: bytes, size: int, last: bool = False) -> bytes:
    """A block: kind 0 raw, 1 RLE, 2 compressed, 3 reserved. `size` is the header's Block_Size."""
    return uint((size << 3) | (kind << 1) | int(last), 3) + data


def raw_block(data: bytes, last: bool = False) -> bytes:
    return block(0, data, len(data), last)


def rle_block(byte: int, count: int, last: bool = False) -> bytes:
    return block(1, bytes([byte]), count, last)


def frame_header(content_size: int, fcs_bytes: Optional[int] = None, *, single_segment=1, unused=0,
                 reserved=0, checksum=0,
                 dict_id_flag=0, window: Optional[int] = None, dict_id: bytes = b"",
                 magic=0xFD2FB528) -> bytes:
    """A frame header of any kind; the default is the profile of spec 6.1."""
    if fcs_bytes is None:
        limits = ((256, 1), (65792, 2), (1 << 32, 4), (1 << 64, 8))
        fcs_bytes = next(n for limit, n in limits if content_size < limit)
    flag = {0: 0, 1: 0, 2: 1, 4: 2, 8: 3}[fcs_bytes]
    descriptor = (flag << 6 | single_segment << 5 | unused << 4 | reserved << 3 | checksum << 2
                  | dict_id_flag)
    out = uint(magic, 4) + bytes([descriptor])
    if window is not None:
        out += bytes([window])
    return out + dict_id + uint(content_size - (256 if fcs_bytes == 2 else 0), fcs_bytes)


def runs(data: bytes) -> list:
    """Cuts data into (True, byte, count) for long runs and (False, bytes, count) for what lies
    between."""
    out, start = [], 0
    for match in re.finditer(rb"(.)\1{7,}", data, re.DOTALL):
        if match.start() > start:
            out.append((False, data[start:match.start()], match.start() - start))
        out.append((True, match.group()[0], match.end() - match.start()))
        start = match.end()
    if start < len(data) or not out:
        out.append((False, data[start:], len(data) - start))
    return out


def blocks(data: bytes) -> bytes:
    """Raw and RLE blocks for data."""
    pieces = []
    for is_run, content, count in runs(data):
        for at in range(0, max(count, 1), 131072):
            n = min(131072, count - at)
            pieces.append((1, bytes([content]), n) if is_run else (0, content[at:at + n], n))
    return b"".join(block(k, d, n, i == len(pieces) - 1) for i, (k, d, n) in enumerate(pieces))


def frame(data: bytes, fcs_bytes: Optional[int] = None) -> bytes:
    """A valid zstd frame of raw and RLE blocks: no encoder is involved, so the bytes never
    change."""
    return frame_header(len(data), fcs_bytes) + blocks(data)


# ---- formats -------------------------------------------------------------------------------------

@dataclass
class Format:
    number: int
    name: str
    block_width: int
    block_height: int
    block_bytes: int
    channels: int
    alpha: bool


def read_registry() -> dict:
    """The texel formats of spec/registry.md by number."""
    row = re.compile(r"^\| (\d+) \| (\w+) \| (\d+) x (\d+) \| (\d+) \| (\w+) \| (yes|no) \|$")
    out = {}
    with open(os.path.join(SPEC, "registry.md"), encoding="utf-8") as f:
        for line in f:
            m = row.match(line.rstrip("\n"))
            if m:
                n, name, w, h, size, channels, alpha = m.groups()
                out[int(n)] = Format(int(n), name, int(w), int(h), int(size), len(channels),
                                     alpha == "yes")
    return out


FORMATS = read_registry()
FORMAT_BY_NAME = {f.name: f.number for f in FORMATS.values()}
R8, RG8, RGB8, RGBA8, RGBA8_SRGB = 9, 16, 23, 37, 43


# ---- images --------------------------------------------------------------------------------------

@dataclass
class Image:
    """One image record with its texels. `texels(level, size)` gives the bytes of a level (layers,
    slices, rows, tight); `codec(level, tile, data)` gives (codec, stored bytes) of a tile; the
    level is "tail" for the mip tail. Instead of bytes it may give a predmake.Tile."""
    format: int
    width: int
    height: int
    depth: int = 1
    layers: int = 1
    levels: int = 1
    tile_log2: int = 8
    alpha_mode: int = 0
    layer_kind: int = 0
    primaries: int = 1
    transfer: Optional[int] = None
    matrix: int = 0
    full_range: int = 1
    block: Optional[tuple] = None
    texels: Optional[Callable] = None
    codec: Optional[Callable] = None
    seed: int = 1
    wrong_tail: Optional[int] = None   # a start of the tail other than that of the specification

    def __post_init__(self):
        known = FORMATS.get(self.format)
        if self.block is None:
            self.block = (known.block_width, known.block_height, known.block_bytes)
        if self.transfer is None:
            self.transfer = 13 if known and (known.name.endswith("SRGB")
                                             or "SRGB_BLOCK" in known.name) else 8

    def size(self, level: int) -> tuple:
        return tuple(max(1, x >> level) for x in (self.width, self.height, self.depth))

    def block_grid(self, level: int) -> tuple:
        w, h, _ = self.size(level)
        return ceil_div(w, self.block[0]), ceil_div(h, self.block[1])

    def level_bytes(self, level: int) -> int:
        bw, bh = self.block_grid(level)
        return self.layers * self.size(level)[2] * bw * bh * self.block[2]

    def level_data(self, level: int) -> bytes:
        size = self.level_bytes(level)
        data = self.texels(level, size) if self.texels else noise(size, self.seed * 32 + level)
        assert len(data) == size, (len(data), size)
        return data

    def tail_start(self) -> int:
        """The level t of spec 8.2; `levels` if there is no tail."""
        if self.wrong_tail is not None:
            return self.wrong_tail
        for t in range(self.levels):
            if max(self.size(t)) <= 64 and sum(map(self.level_bytes,
                                                   range(t, self.levels))) <= 262144:
                return t
        return self.levels

    def tiles(self, level: int) -> list:
        """The decoded bytes of the tiles of a level, in the order of spec 8.2."""
        data, (bw, bh), size = self.level_data(level), self.block_grid(level), self.block[2]
        edge, slices = 1 << self.tile_log2, self.layers * self.size(level)[2]
        out = []
        for s in range(slices):
            for y0 in range(0, bh, edge):
                for x0 in range(0, bw, edge):
                    row = (min(x0 + edge, bw) - x0) * size
                    rows = range(y0, min(y0 + edge, bh))
                    starts = (((s * bh + y) * bw + x0) * size for y in rows)
                    out.append(b"".join(data[at:at + row] for at in starts))
        return out

    def tile_size(self, level, tile: int) -> tuple:
        """Width and height in blocks of a tile of a level, or of the whole level 0 for the tail."""
        if level == "tail":
            return self.block_grid(0)
        (bw, bh), edge = self.block_grid(level), 1 << self.tile_log2
        row, column = divmod(tile % (ceil_div(bw, edge) * ceil_div(bh, edge)), ceil_div(bw, edge))
        return min(edge, bw - column * edge), min(edge, bh - row * edge)

    def units(self) -> list:
        """(level or "tail", tiles) for each unit, level 0 first and the tail last."""
        t = self.tail_start()
        out = [(k, self.tiles(k)) for k in range(t)]
        if t < self.levels:
            out.append(("tail", [b"".join(self.level_data(k) for k in range(self.levels - 1, t - 1,
                -1))]))
        return out

    def record(self, over: Overrides, path: str) -> bytes:
        return over.pack(path, [
            ("format", 4, self.format), ("width", 4, self.width), ("height", 4, self.height),
            ("depth", 4, self.depth),
            ("layers", 4, self.layers), ("levels", 1, self.levels),
            ("tile_log2", 1, self.tile_log2),
            ("block_width", 1, self.block[0]), ("block_height", 1, self.block[1]),
            ("block_bytes", 1, self.block[2]),
            ("alpha_mode", 1, self.alpha_mode), ("layer_kind", 1, self.layer_kind),
            ("primaries", 1, self.primaries),
            ("transfer", 1, self.transfer), ("matrix", 1, self.matrix),
            ("full_range", 1, self.full_range),
            ("reserved", 1, 0)])


def stored_raw(level, tile, data):
    return 0, data


def stored_zstd(level, tile, data):
    """Codec 1 where the frame is smaller, as [R5202] asks, else raw."""
    f = frame(data)
    return (1, f) if len(f) < len(data) else (0, data)


def flat(*values):
    """texels() that fills each level with one byte, and so compresses well."""
    return lambda level, size: bytes([values[level % len(values)]]) * size




def unit_bytes(over: Overrides, image: Image, i: int, u: int, level, tiles: list) -> tuple:
    """The stored bytes of a unit and the hash of its index."""
    index, body = b"", b""
    for n, data in enumerate(tiles):
        codec, stored = (image.codec or stored_raw)(level, n, data)
        path = "tile.%d.%d.%d" % (i, u, n)
        if not isinstance(stored, bytes):
            stored = stored.build(over, "pred.%d.%d.%d" % (i, u, n))
        stored = over.get(path + ".stored", stored)
        index += over.pack(path, [("stored_size", 4, len(stored)), ("codec", 1, codec),
                                  ("reserved", 3, 0),
                                  ("hash", 8, xxh3(data))])
        body += stored
    index = over.get("index.%d.%d" % (i, u), index)
    return index + body, xxh3(index)


# ---- planes and zipmaps --------------------------------------------------------------------------

@dataclass
class Plane:
    """How one array is stored. bit_width and base default to the smallest that fit; where codec 1
    saves nothing, the plane is raw, as [R5103] asks."""
    predictor: int = 0
    packing: int = 0
    codec: int = 0
    bit_width: Optional[int] = None
    base: Optional[int] = None
    fcs_bytes: Optional[int] = None


def predict(values: list, predictor: int, bits: int) -> list:
    """The zigzag residuals of spec 6.2, step 3, inverted."""
    if predictor == 0:
        return list(values)
    mask, out, before, before2 = (1 << bits) - 1, [], 0, 0
    for e in values:
        guess = before if predictor == 1 else 2 * before - before2
        d = (e - guess) & mask
        out.append(((d << 1) ^ (-(d >> (bits - 1)))) & mask)
        before2, before = before, e
    return out


def plane_bytes(over: Overrides, path: str, size: int, values: list, p: Plane) -> bytes:
    """Header and stored bytes of one plane."""
    elements = b"".join(uint(v, size) for v in values)
    bit_width = base = codec = 0
    if p.packing == 2:
        base = min(values, default=0) if p.base is None else p.base
        top = max((v - base for v in values), default=0)
        bit_width = top.bit_length() if p.bit_width is None else p.bit_width
        if p.base is None:                                 # base + 2^bit_width - 1 must fit
            base = min(base, (1 << 8 * size) - (1 << bit_width))
        number = sum((v - base) << (i * bit_width) for i, v in enumerate(values))
        stored = number.to_bytes(ceil_div(len(values) * bit_width, 8), "little")
    else:
        stored = b"".join(uint(v, size) for v in predict(values, p.predictor, 8 * size))
        if p.packing == 1:
            stored = b"".join(stored[k::size] for k in range(size))
        stored = over.get(path + ".content", stored)
        packed = frame(stored, p.fcs_bytes) if p.codec == 1 else stored
        codec = int(len(packed) < len(stored) or path + ".stored" in over.values and p.codec == 1)
        stored = packed if codec else stored
    stored = over.get(path + ".stored", stored)
    return over.pack(path, [
        ("element_size", 1, size), ("predictor", 1, p.predictor), ("packing", 1, p.packing),
        ("codec", 1, codec),
        ("bit_width", 1, bit_width), ("reserved", 3, 0), ("base", 8, base),
        ("count", 4, len(values)),
        ("stored_size", 4, len(stored)), ("hash", 8, xxh3(elements))]) + stored


@dataclass
class Patch:
    sources: list
    matrix: tuple = IDENTITY
    parent: int = 0
    source_kind: int = 0
    mask: int = NONE


@dataclass
class Zipmap:
    patches: list
    planes: dict = field(default_factory=dict)  # name -> Plane; "" is the default for the others

    def arrays(self) -> list:
        """(name, element size, values) of each plane in file order."""
        ps = self.patches
        out = [("parent", 4, [p.parent for p in ps]),
               ("source_kind", 1, [p.source_kind for p in ps])]
        out += [("source%d" % k, 4, [p.sources[k] for p in ps]) for k in range(len(ps[0].sources))]
        out.append(("mask", 4, [p.mask for p in ps]))
        # A matrix entry given as an int is a bit pattern: NaNs and negative zeros pass unharmed.
        bits = lambda x: x if isinstance(x, int) else f64_bits(x)
        out += [(name, 8, [bits(p.matrix[k]) for p in ps]) for k, name in enumerate(MATRIX_NAMES)]
        return out

    def elements(self) -> bytes:
        return b"".join(uint(v, size) for _, size, values in self.arrays() for v in values)

    def build(self, over: Overrides, z: int) -> bytes:
        out = over.pack("zpmp.%d" % z, [("patch_count", 4, len(self.patches)),
                                        ("layer_count", 4, len(self.patches[0].sources)),
                                        ("reserved", 8, 0)])
        default = self.planes.get("", Plane())
        for name, size, values in self.arrays():
            key = "matrix" if name in MATRIX_NAMES and name not in self.planes else name
            out += plane_bytes(over, "plane.%d.%s" % (z, name), size, values,
                               self.planes.get(key, default))
        return out


# ---- textures and the file -----------------------------------------------------------------------

@dataclass
class Texture:
    name: object = ""                  # str or bytes
    layers: list = None                # (semantic, image); for other kinds (semantic, NONE)
    wrap: tuple = (0, 0, 0)
    zipmap: Optional[Zipmap] = None
    silmap: object = None              # silmake.Silmap
    umbrellas: object = None           # umbmake.Umbrellas

    def kind(self) -> int:
        return 1 if self.zipmap else 2 if self.silmap else 3 if self.umbrellas else 0

    def name_bytes(self) -> bytes:
        return self.name.encode() if isinstance(self.name, str) else self.name


@dataclass
class Chunk:
    """A chunk before it has a place. `stored` None: the decoded bytes, through zstd for codec 1."""
    type: str
    decoded: bytes
    codec: int = 0
    flags: Optional[int] = None
    version: int = 1
    stored: Optional[bytes] = None
    label: str = ""


@dataclass
class File:
    images: list
    textures: Optional[list] = None
    meta: Optional[list] = None        # (key, value) pairs, str or bytes
    extra: list = field(default_factory=list)
    codec: dict = field(default_factory=dict)   # chunk type -> codec or (codec, stored bytes)
    minor: int = 0
    overrides: dict = field(default_factory=dict)

    def __post_init__(self):
        if self.textures is None:
            self.textures = [Texture("t%d" % i, [(0, i)]) for i in range(len(self.images))]

    def zipmaps(self) -> list:
        return [t.zipmap for t in self.textures if t.zipmap]

    def silmaps(self) -> list:
        return [t.silmap for t in self.textures if t.silmap]

    def umbrellas(self) -> list:
        return [t.umbrellas for t in self.textures if t.umbrellas]

    def texs(self, over: Overrides) -> bytes:
        names = [over.get("name.%d" % i, t.name_bytes()) for i, t in enumerate(self.textures)]
        out = over.pack("texs", [("texture_count", 4, len(self.textures)),
                                 ("layer_total", 4, sum(len(t.layers) for t in self.textures)),
                                 ("name_bytes", 4, sum(map(len, names))), ("reserved", 4, 0)])
        for i, t in enumerate(self.textures):
            out += over.pack("texture.%d" % i, [
                ("kind", 1, t.kind()), ("wrap_u", 1, t.wrap[0]),
                ("wrap_v", 1, t.wrap[1]),
                ("wrap_w", 1, t.wrap[2]), ("layer_count", 4, len(t.layers)),
                ("name_size", 4, len(names[i])),
                ("reserved", 4, 0)])
        for i, t in enumerate(self.textures):
            for k, (semantic, image) in enumerate(t.layers):
                out += over.pack("layer.%d.%d" % (i, k),
                                 [("semantic", 2, semantic), ("reserved", 2, 0),
                                                          ("image", 4, image)])
        return out + b"".join(names)

    def imag_texl(self, over: Overrides) -> tuple:
        """The decoded bytes of IMAG and TEXL."""
        units = []                     # [order key, image, unit, bytes, index hash]
        for i, image in enumerate(self.images):
            for u, (level, tiles) in enumerate(image.units()):
                key = (-1, i) if level == "tail" else (max(image.size(level)).bit_length() - 1, i)
                units.append((key, i, u) + unit_bytes(over, image, i, u, level, tiles))
        order = sorted(units, key=over.get("unit_order", lambda unit: unit[0]))
        texl, place = b"", {}
        for key, i, u, data, index_hash in order:
            place[i, u] = len(texl)
            texl += data
        imag = over.pack("imag", [("image_count", 4, len(self.images)),
                                  ("unit_total", 4, len(units)),
                                  ("reserved", 8, 0)])
        for i, image in enumerate(self.images):
            imag += image.record(over, "image.%d" % i)
        for key, i, u, data, index_hash in units:
            imag += over.pack("unit.%d.%d" % (i, u),
                              [("offset", 8, place[i, u]), ("size", 8, len(data)),
                                                      ("index_hash", 8, index_hash)])
        return imag, texl

    def meta_bytes(self, over: Overrides) -> bytes:
        enc = lambda x: x.encode() if isinstance(x, str) else x
        pairs = [(enc(k), enc(v)) for k, v in self.meta]
        out = over.pack("meta", [("pair_count", 4, len(pairs)), ("reserved", 4, 0)])
        for i, (k, v) in enumerate(pairs):
            out += over.pack("pair.%d" % i, [("key_size", 4, len(k)), ("value_size", 4, len(v))])
        return out + b"".join(k + v for k, v in pairs)

    def chunks(self, over: Overrides) -> list:
        imag, texl = self.imag_texl(over)
        out = [Chunk("TEXS", self.texs(over)), Chunk("IMAG", imag)]
        out += [Chunk("ZPMP", z.build(over, n)) for n, z in enumerate(self.zipmaps())]
        out += [Chunk("SLMP", s.build(over, n)) for n, s in enumerate(self.silmaps())]
        out += [Chunk("UMBR", u.build(over, n)) for n, u in enumerate(self.umbrellas())]
        if self.meta is not None:
            out.append(Chunk("META", self.meta_bytes(over)))
        out += [Chunk(**vars(c)) for c in sorted(self.extra, key=lambda c: c.type)]
        out.append(Chunk("TEXL", texl))
        for c in out:
            codec = self.codec.get(c.type, c.codec)
            c.codec, c.stored = codec if isinstance(codec, tuple) else (codec, c.stored)
        out = over.get("chunks", out)
        seen = {}
        for c in out:
            n = seen.setdefault(c.type, 0)
            seen[c.type] += 1
            c.label = c.type if n == 0 else "%s%d" % (c.type, n)
        return out

    def build(self, overrides: Optional[dict] = None) -> bytes:
        over = Overrides({**self.overrides, **(overrides or {})})
        chunks = self.chunks(over)
        offset = align16(64 + 48 * len(chunks))
        directory, body = b"", bytes(offset - 64 - 48 * len(chunks))
        for index, c in enumerate(chunks):
            c.decoded = over.get("decoded." + c.label, c.decoded)
            stored = c.stored
            if stored is None:
                stored = frame(c.decoded) if c.codec == 1 else c.decoded
            stored = over.get("stored." + c.label, stored)
            flags = KNOWN_FLAGS.get(c.type, 0) if c.flags is None else c.flags
            decoded = c.decoded if c.codec == 1 else stored
            entry = over.pack("entry." + c.label, [
                ("type", 4, c.type.encode("latin-1")), ("version", 2, c.version),
                ("flags", 1, flags), ("codec", 1, c.codec),
                ("offset", 8, offset), ("stored_size", 8, len(stored)),
                ("decoded_size", 8, len(decoded)),
                ("stored_hash", 8, xxh3(stored)), ("decoded_hash", 8, xxh3(decoded))])
            directory += entry
            body += over.pack("head." + c.label, [("head_magic", 8, HEAD_MAGIC),
                                                  ("index", 4, index), ("reserved", 4, 0),
                                                  ("entry", 48, entry)]) + stored
            end = align16(offset + 64 + len(stored))
            body += over.get("padding." + c.label, bytes(end - offset - 64 - len(stored)))
            gap = over.get("gap." + c.label, b"")
            body += gap
            offset = end + len(gap)
        preamble = over.pack("preamble", [
            ("magic", 10, MAGIC), ("major", 2, 1), ("minor", 2, self.minor), ("reserved", 2, 0),
            ("file_size", 8, offset),
            ("directory_size", 4, len(directory)), ("chunk_count", 4, len(chunks)),
            ("required_features", 8, 0),
            ("reserved40", 8, 0), ("reserved48", 8, 0)])
        preamble += uint(over.get("preamble.directory_hash", xxh3(preamble + directory)), 8)
        data = over.get("file", preamble + directory + body)
        over.check_all_used()
        return data
