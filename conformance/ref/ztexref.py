# SPDX-License-Identifier: Apache-2.0
"""A slow second reader of .ztex files, written from spec/ alone: opens a file, checks every rule,
decodes all levels.

`read(data)` returns a `Ztex` or raises `Fault`, which names the first rule that the file breaks.
The order is that of the layers: preamble, directory, heads and hashes, TEXS, IMAG, ZPMP, SLMP, UMBR,
META, texels. Nothing is shared with conformance/make."""

import itertools
import math
import os
import re
import struct
from dataclasses import dataclass, field

import zfields
import zmath
import zpred
import zsilmap
import zumbrella
from zbase import Cursor, Fault, align16, ceil_div, need, read_plane, unzstd, xxh3

SPEC = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..",
                                     "spec"))
KNOWN = {b"TEXS": 1, b"IMAG": 1, b"ZPMP": 1, b"SLMP": 1, b"UMBR": 1, b"META": 2,
         b"TEXL": 1}                                                   # type -> flags
ORDER = {b"TEXS": 0, b"IMAG": 1, b"ZPMP": 2, b"SLMP": 3, b"UMBR": 4, b"META": 5,
         b"TEXL": 7}                                                   # others: 6
INSIDE = (b"TEXL", b"ZPMP", b"SLMP", b"UMBR")                          # they compress inside
OFTEN = (b"ZPMP", b"SLMP", b"UMBR")
IMAGE, ZIPMAP, SILMAP, UMBRELLAS = 0, 1, 2, 3                          # kinds of textures
NONE = 0xFFFFFFFF


def registry() -> tuple:
    """Formats by number (name, block, bytes, channels, alpha) and the keys of metadata, from
    registry.md."""
    formats, keys = {}, set()
    with open(os.path.join(SPEC, "registry.md"), encoding="utf-8") as f:
        for line in f:
            cells = [c.strip() for c in line.strip().strip("|").split("|")]
            if len(cells) == 6 and cells[0].isdigit():
                w, h = map(int, cells[2].split(" x "))
                formats[int(cells[0])] = (cells[1], (w, h, int(cells[3])), len(cells[4]),
                                          cells[5] == "yes")
            elif re.fullmatch(r"`zt\.\w+`", cells[0]):
                keys.add(cells[0].strip("`"))
    return formats, keys


FORMATS, KEYS = registry()


# ---- what a file holds ---------------------------------------------------------------------------

@dataclass
class Unit:
    level: object          # a number or "tail"
    tiles: list            # decoded size of each tile
    order: tuple
    offset: int = 0
    size: int = 0
    index_hash: int = 0


@dataclass
class Image:
    format: int
    width: int
    height: int
    depth: int
    layers: int
    levels: int
    tile_log2: int
    block: tuple
    alpha_mode: int
    layer_kind: int
    primaries: int = 1
    transfer: int = 8
    units: list = field(default_factory=list)
    decoded: list = field(default_factory=list)    # bytes of each level

    def extent(self, k: int) -> tuple:
        return max(1, self.width >> k), max(1, self.height >> k), max(1, self.depth >> k)

    def grid(self, k: int) -> tuple:
        w, h, _ = self.extent(k)
        return ceil_div(w, self.block[0]), ceil_div(h, self.block[1])

    def bytes_of(self, k: int) -> int:
        bw, bh = self.grid(k)
        return self.layers * self.extent(k)[2] * bw * bh * self.block[2]

    def tile_boxes(self, k: int):
        """(slice, x0, y0, x1, y1) in blocks, in the order of 8.2."""
        bw, bh = self.grid(k)
        edge = 1 << self.tile_log2
        for s in range(self.layers * self.extent(k)[2]):
            for y in range(0, bh, edge):
                for x in range(0, bw, edge):
                    yield s, x, y, min(x + edge, bw), min(y + edge, bh)


@dataclass
class Texture:
    kind: int
    name: bytes
    images: list
    wrap: tuple = (0, 0, 0)
    zipmap: list = None            # of each patch: parent, kind, sources, mask, composed matrix
    silmap: object = None          # a Silmap
    umbrellas: object = None       # a zumbrella.Umbrellas
    elements: bytes = b""


@dataclass
class Silmap:
    filter: int
    grid: zsilmap.Grid
    samples: list                  # index of an image for each layer
    minified: list                 # the same, or NONE


@dataclass
class Ztex:
    textures: list = field(default_factory=list)
    images: list = field(default_factory=list)
    meta: list = field(default_factory=list)
    warnings: list = field(default_factory=list)


# ---- 3 to 5: preamble, directory, heads ----------------------------------------------------------

MAGIC = bytes((0xAB, 0x5A, 0x54, 0x45, 0x58, 0xBB, 0x0D, 0x0A, 0x1A, 0x0A))


def read_container(data: bytes) -> list:
    """(type, version, decoded bytes) of each chunk."""
    need(data[:10] == MAGIC or (data and len(data) < 10 and MAGIC.startswith(data)), "R2001")
    need(len(data) >= 64, "R2006")
    (major, minor, r1, file_size, dir_size, count, features, r2, r3,
     dir_hash) = struct.unpack("<HHHQIIQQQQ", data[10:64])
    need(major == 1, "R2002", str(major))
    need(r1 == r2 == r3 == 0, "R2003")
    need(3 <= count <= 65535, "R2004")
    need(dir_size == 48 * count, "R2005")
    need(len(data) >= file_size, "R2006")
    need(len(data) == file_size, "R2007")
    need(features == 0, "R2008")
    need(64 + dir_size <= file_size, "R3002", "the directory does not fit")
    need(xxh3(data[:56] + data[64:64 + dir_size]) == dir_hash, "R2009")
    entries, offset = [], align16(64 + dir_size)
    for i in range(count):
        raw = data[64 + 48 * i:112 + 48 * i]
        kind, version, flags, codec, at, stored, decoded, h1, h2 = struct.unpack("<4sHBBQQQQQ", raw)
        need(re.fullmatch(rb"[A-Z0-9]{4}", kind), "R3004")
        need(flags & ~3 == 0 and flags == KNOWN.get(kind, flags), "R3005")
        need(kind in KNOWN or not flags & 1, "R3012", repr(kind))
        need(codec <= 1 and not (codec and kind in INSIDE), "R3006")
        need(1 <= stored < 1 << 53 and 1 <= decoded < 1 << 53
             and (codec == 0 or decoded <= 1 << 30), "R3003")
        need(stored < decoded if codec else (stored, h1) == (decoded, h2), "R3007")
        need(version == 1 or kind not in KNOWN or not flags & 1, "R3008")
        need(at == offset, "R3001")
        offset = align16(offset + 64 + stored)
        entries.append((raw, kind, version, codec, at, stored, decoded, h1, h2))
    need(offset == file_size, "R3002")
    kinds = [e[1] for e in entries]
    for kind in (b"TEXS", b"IMAG", b"TEXL"):
        need(kind in kinds, "R3010", repr(kind))
    keys = [(ORDER.get(k, 6), b"" if k in ORDER else k) for k in kinds]
    need(keys == sorted(keys), "R3009")
    need(all(k in OFTEN or kinds.count(k) == 1 for k in kinds), "R3011")
    out = []
    for i, (raw, kind, version, codec, at, stored_size, decoded_size, h1, h2) in enumerate(entries):
        magic, index, reserved = struct.unpack("<8sII", data[at:at + 16])
        need(magic == b"\xab\x5aTchk\xbb\x0a" and index == i and reserved == 0, "R4001")
        need(data[at + 16:at + 64] == raw, "R4002")
        stored, end = data[at + 64:at + 64 + stored_size], at + 64 + stored_size
        need(not any(data[end:align16(end)]), "R4005")
        need(xxh3(stored) == h1, "R4003")
        decoded = unzstd(stored, decoded_size) if codec else stored
        need(xxh3(decoded) == h2, "R4004")
        out.append((kind, version, decoded))
    return out


# ---- 7 to 9 --------------------------------------------------------------------------------------

def check_text(raw: bytes, rule: str, forbidden: str):
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError as error:
        raise Fault(rule, str(error))
    need(not any(c in forbidden for c in text), rule, "control character")


CONTROL = "".join(map(chr, range(32))) + "\x7f"


def read_texs(data: bytes) -> list:
    c = Cursor(data, "R6101")
    count, layer_total, name_total, reserved = c.fields("4I")
    need(len(data) == 16 + 16 * count + 8 * layer_total + name_total, "R6101")
    need(count >= 1, "R6102")
    need(reserved == 0, "R6104")
    heads = [c.fields("4BIII") for _ in range(count)]
    need(sum(h[4] for h in heads) == layer_total and sum(h[5] for h in heads) == name_total,
         "R6101", "sums")
    layers, out = [], []
    for kind, u, v, w, layer_count, name_size, reserved in heads:
        need(kind in (IMAGE, ZIPMAP, SILMAP, UMBRELLAS), "R6103", str(kind))
        need(max(u, v, w) <= 3 and reserved == 0, "R6104")
        need(1 <= layer_count <= 32, "R6105")
        need(name_size <= 255, "R6107")
        layers.append([c.fields("HHI") for _ in range(layer_count)])
        need(all(r == 0 for _, r, _ in layers[-1]), "R6104")
    for head, own in zip(heads, layers):
        name = c.take(head[5])
        check_text(name, "R6107", CONTROL)
        out.append(Texture(head[0], name, [image for _, _, image in own], head[1:4]))
    names = [t.name for t in out if t.name]
    need(len(set(names)) == len(names), "R6108")
    return out


def read_imag(data: bytes, texl_size: int) -> list:
    c = Cursor(data, "R6001")
    count, unit_total, reserved = c.fields("IIQ")
    need(len(data) == 16 + 32 * count + 24 * unit_total and count >= 1 and reserved == 0, "R6001")
    images = []
    for _ in range(count):
        (number, w, h, d, layers, levels, tile_log2, bw, bh, bb, alpha, kind, primaries, transfer,
         matrix, full,
         reserved) = c.fields("5I12B")
        need(reserved == 0, "R6001")
        need(1 <= w <= 1 << 20 and 1 <= h <= 1 << 20 and 1 <= d <= 1 << 14
             and 1 <= layers <= 1 << 16, "R6002")
        need(1 <= levels <= max(w, h, d).bit_length(), "R6003")
        known = FORMATS.get(number)
        if known:
            need((bw, bh, bb) == known[1], "R6005")
        need(1 <= bw <= 16 and 1 <= bh <= 16 and 1 <= bb <= 64, "R6005")
        image = Image(number, w, h, d, layers, levels, tile_log2, (bw, bh, bb), alpha, kind,
                      primaries, transfer)
        need(4 <= tile_log2 <= 16, "R6004")
        gw, gh = image.grid(0)
        need(min(gw, 1 << tile_log2) * min(gh, 1 << tile_log2) * bb <= 1 << 30, "R6004",
             "tile too large")
        need(alpha <= 2 and not (alpha and known and not known[3]), "R6006")
        need(kind <= 2 and (kind != 1 or (w == h and d == 1 and layers % 6 == 0)), "R6007")
        need(primaries in (1, 2, 22) or 4 <= primaries <= 12, "R6008")
        need((transfer in (1, 2) or 4 <= transfer <= 18) and matrix == 0 and full == 1, "R6008")
        need(not (known and "SRGB" in known[0]) or transfer == 13, "R6008")
        edge = 1 << tile_log2
        for k in range(levels):
            gw, gh = image.grid(k)
            need(layers * image.extent(k)[2] * ceil_div(gw, edge) * ceil_div(gh, edge) < 1 << 28,
                 "R6009", "tiles")
        need(sum(map(image.bytes_of, range(levels))) < 1 << 53, "R6009", "bytes")
        images.append(image)
    for i, image in enumerate(images):
        tail = image.levels
        total = 0
        for k in reversed(range(image.levels)):
            total += image.bytes_of(k)
            if max(image.extent(k)) > 64 or total > 262144:
                break
            tail = k
        for k in range(tail):
            tiles = [(x1 - x0) * (y1 - y0) * image.block[2] for _, x0, y0, x1,
                     y1 in image.tile_boxes(k)]
            image.units.append(Unit(k, tiles, (max(image.extent(k)).bit_length() - 1, i)))
        if tail < image.levels:
            image.units.append(Unit("tail", [sum(map(image.bytes_of, range(tail, image.levels)))],
                                    (-1, i)))
    units = [u for image in images for u in image.units]
    need(len(units) == unit_total, "R6010")
    for u in units:
        u.offset, u.size, u.index_hash = c.fields("QQQ")
        need(u.size >= 17 * len(u.tiles), "R6012")
    place = 0
    for u in sorted(units, key=lambda u: u.order):
        need(u.offset == place, "R6011")
        place += u.size
    need(place == texl_size, "R6013")
    return images


def read_meta(data: bytes, warnings: list) -> list:
    c = Cursor(data, "R7001")
    count, reserved = c.fields("II")
    need(count >= 1 and reserved == 0, "R7001")
    sizes = [c.fields("II") for _ in range(count)] if 8 * count <= c.left() else need(False,
        "R7001")
    need(sum(map(sum, sizes)) == c.left(), "R7001")
    keys = []
    values = []
    for k, v in sizes:
        keys.append(c.take(k))
        values.append(c.take(v))
    for key, value in zip(keys, values):
        need(1 <= len(key) <= 255, "R7002")
        check_text(key, "R7002", CONTROL)
        check_text(value, "R7004", "\0")
        if key.startswith(b"zt.") and key.decode() not in KEYS:
            warnings.append("R7005")
    need(all(a < b for a, b in zip(keys, keys[1:])), "R7003")
    return list(zip(keys, values))


# ---- zipmap.md -----------------------------------------------------------------------------------

def read_zpmp(data: bytes, own: int, z: Ztex):
    """Checks the chunk of texture `own`; leaves its patches there. Returns the coverage images."""
    texture, images = z.textures[own], z.images
    need(len(data) >= 16, "R8101")
    c = Cursor(data, "R5103")
    n, layer_count, reserved = c.fields("IIQ")
    need(reserved == 0 and layer_count == len(texture.images) and 1 <= n <= 1 << 24, "R8101")
    layout = [("parent", 4), ("kind", 1)] + [("source", 4)] * layer_count + [("mask", 4)] + [("m",
        8)] * 9
    planes = []
    for name, size in layout:
        values = read_plane(c, size, n)
        texture.elements += b"".join(v.to_bytes(size, "little") for v in values)
        planes.append(values)
    need(c.left() == 0, "R5106")
    parents, kinds, sources = planes[0], planes[1], planes[2:-10]
    masks, entries = planes[-10], planes[-9:]
    for bits in (b for plane in entries for b in plane):
        need(bits >> 52 & 0x7FF != 0x7FF and bits != 1 << 63, "R8109")
    matrices = [zmath.rows([struct.unpack("<d", plane[i].to_bytes(8,
        "little"))[0] for plane in entries]) for i in range(n)]
    need((parents[0], kinds[0], masks[0]) == (0, 0, NONE) and matrices[0] == zmath.IDENTITY,
         "R8102")
    composed, coverage, used = [], set(), set()
    for i in range(n):
        need(i == 0 or parents[i] < i, "R8103")
        need(kinds[i] <= 1, "R8104")
        src = [plane[i] for plane in sources]
        if kinds[i] == 0:
            need(max(src) < len(images), "R8105")
            used.update(src)
        else:
            need(len(set(src)) == 1 and src[0] < own
                 and len(z.textures[src[0]].images) == layer_count, "R8105")
        if masks[i] != NONE:
            need(masks[i] < len(images) and FORMATS.get(images[masks[i]].format, (0, 0, 0))[2] == 1,
                 "R8106")
            used.add(masks[i])
        if i and kinds[i] == 0:
            need((images[src[0]].alpha_mode != 0) != (masks[i] != NONE), "R8107")
            coverage.add(src[0] if masks[i] == NONE else masks[i])
        elif i and masks[i] != NONE:
            coverage.add(masks[i])
        m = matrices[i] if i == 0 else zmath.product(matrices[i], composed[parents[i]])
        composed.append(m)
        a = zmath.adjugate(m)
        det = zmath.determinant(m, a)
        need(all(math.isfinite(x) for row in m for x in row) and math.isfinite(det) and det != 0,
             "R8110")
        need(all(math.isfinite(w) and w != 0 and (w > 0) == (det > 0) for w in zmath.corner_weights(a)), "R8111")
    layers = images[sources[0][0]].layers
    for k in used:
        need(images[k].depth == 1 and images[k].layer_kind != 1 and images[k].layers in (1, layers),
             "R8108")
    texture.zipmap = list(zip(parents, kinds, zip(*sources), masks, composed))
    return coverage


# ---- silmap.md -----------------------------------------------------------------------------------

def read_slmp(data: bytes, texture: Texture, z: Ztex):
    """Checks the chunk of a texture; leaves its silmap there."""
    need(len(data) >= 24, "R8201")
    c = Cursor(data, "R5103")
    w, h, cell_layers, layer_count, kind, reserved = c.fields("4IB7s")
    need(reserved == bytes(7) and layer_count == len(texture.images), "R8201")
    need(1 <= w <= 1 << 20 and 1 <= h <= 1 << 20 and 1 <= cell_layers <= 1 << 16
         and w * h * cell_layers < 1 << 32, "R8201", "size")
    need(kind <= 2, "R8202")
    planes = [read_plane(c, size, count) for size, count in ((1, w * h * cell_layers),
                                                             (4, layer_count), (4, layer_count))]
    need(c.left() == 0, "R5106")
    cells, samples, minified = planes
    texture.elements = bytes(cells) + struct.pack("<%dI" % (2 * layer_count), *samples, *minified)
    repeat_u, repeat_v = texture.wrap[0] == 0, texture.wrap[1] == 0
    for index in samples:
        need(index < len(z.images), "R8203", "index")
        image = z.images[index]
        need(image.levels == 1 and image.depth == 1 and image.layer_kind != 1, "R8203")
        need((image.width, image.height) == (w + (not repeat_u), h + (not repeat_v)), "R8203",
             "size")
    array_layers = {z.images[index].layers for index in samples}
    need(len(array_layers) == 1 and (cell_layers == 1 or cell_layers in array_layers), "R8204")
    for index, own in zip(minified, samples):
        if index == NONE:
            continue
        need(index < len(z.images), "R8205", "index")
        small, image = z.images[index], z.images[own]
        need((small.width, small.height, small.depth) == (w, h, 1), "R8205", "size")
        for name in ("format", "alpha_mode", "primaries", "transfer", "layers", "layer_kind"):
            need(getattr(small, name) == getattr(image, name), "R8205", name)
    grid = zsilmap.Grid(w, h, cell_layers, bytes(cells), repeat_u, repeat_v)
    for layer in range(cell_layers):
        for j in range(h) if not repeat_u else ():
            need(not grid.byte(0, j, layer) & zsilmap.WEST_BIT, "R8206", "first column")
        for i in range(w) if not repeat_v else ():
            need(not grid.byte(i, 0, layer) & zsilmap.NORTH_BIT, "R8206", "first row")
    if grid.has_costly_points():
        z.warnings.append("R8207")
    texture.silmap = Silmap(kind, grid, samples, minified)


def check_coverage(image: Image):
    """[R8112] for uncompressed formats: the last channel is the coverage."""
    name, blk, channels, alpha = FORMATS.get(image.format, ("", (0, 0, 0), 0, False))
    if blk[:2] != (1, 1):
        return
    width = blk[2] // channels
    signed_zero = b"\0" * (width - 1) + b"\x80"  # -0.0: also no coverage, for float formats
    is_float = "FLOAT" in name
    for k, data in enumerate(image.decoded):
        w, h, _ = image.extent(k)
        for s in range(image.layers):
            for y in range(h):
                for x in range(w) if y in (0, h - 1) else {0, w - 1}:
                    end = ((s * h + y) * w + x + 1) * blk[2]
                    value = data[end - width:end]
                    need(not any(value) or (is_float and value == signed_zero), "R8112",
                         "level %d, x %d, y %d" % (k, x, y))


# ---- 8.2, 8.3: texels ----------------------------------------------------------------------------

def unpred(stored: bytes, image: Image, level, tile: int) -> bytes:
    """A tile of codec 2 (6.4)."""
    _, blk, channels, _ = FORMATS.get(image.format, ("", (0, 0, 0), 0, False))
    need(level != "tail", "R5301", "mip tail")
    need(blk[:2] == (1, 1) and 1 <= channels <= 4 and blk[2] in (channels, 2 * channels), "R5301",
         "format")
    _, x0, y0, x1, y1 = next(itertools.islice(image.tile_boxes(level), tile, None))
    try:
        return zpred.decode(stored, x1 - x0, y1 - y0, channels, blk[2] // channels, unzstd)
    except zpred.Broken as broken:
        raise Fault(broken.rule, str(broken))


def read_unit(texl: bytes, image: Image, unit: Unit) -> list:
    """The decoded tiles of a unit."""
    data = texl[unit.offset:unit.offset + unit.size]
    n = len(unit.tiles)
    index = data[:16 * n]
    need(xxh3(index) == unit.index_hash, "R5204")
    records = [struct.unpack_from("<IB3sQ", index, 16 * i) for i in range(n)]
    for size, (stored, codec, reserved, digest) in zip(unit.tiles, records):
        need(codec in (0, 1, 2, 4) and reserved == b"\0\0\0", "R5201")
        need(stored == size if codec == 0 else 1 <= stored < size, "R5202")
    need(sum(r[0] for r in records) == unit.size - 16 * n, "R5205")
    at, out = 16 * n, []
    for k, (size, (stored, codec, reserved, digest)) in enumerate(zip(unit.tiles, records)):
        piece = data[at:at + stored]
        at += stored
        if codec == 2:
            tile = unpred(piece, image, unit.level, k)
        elif codec == 4:
            sizes = zfields.fields_of(image.format)
            need(unit.level != "tail" and sizes, "R5401")
            tile = zfields.together(unzstd(piece, size), sizes)
        else:
            tile = unzstd(piece, size) if codec else piece
        need(xxh3(tile) == digest, "R5203")
        out.append(tile)
    return out


def read_texels(texl: bytes, image: Image):
    image.decoded = [b""] * image.levels
    for unit in image.units:
        tiles = read_unit(texl, image, unit)
        if unit.level == "tail":
            at = 0
            first = len(image.units) - 1
            for k in range(image.levels - 1, first - 1, -1):
                image.decoded[k] = tiles[0][at:at + image.bytes_of(k)]
                at += image.bytes_of(k)
            continue
        (bw, bh), size = image.grid(unit.level), image.block[2]
        out = bytearray(image.bytes_of(unit.level))
        for tile, (s, x0, y0, x1, y1) in zip(tiles, image.tile_boxes(unit.level)):
            row = (x1 - x0) * size
            for y in range(y0, y1):
                at = ((s * bh + y) * bw + x0) * size
                out[at:at + row] = tile[(y - y0) * row:(y - y0 + 1) * row]
        image.decoded[unit.level] = bytes(out)


def read(data: bytes) -> Ztex:
    chunks = read_container(data)
    by_kind = lambda kind: [(version, payload) for k, version, payload in chunks if k == kind]
    z = Ztex()
    texl = by_kind(b"TEXL")[0][1]
    z.textures = read_texs(by_kind(b"TEXS")[0][1])
    z.images = read_imag(by_kind(b"IMAG")[0][1], len(texl))
    zpmp, slmp, umbr = by_kind(b"ZPMP"), by_kind(b"SLMP"), by_kind(b"UMBR")
    need(len(zpmp) == sum(t.kind == ZIPMAP for t in z.textures), "R6110", "ZPMP")
    need(len(slmp) == sum(t.kind == SILMAP for t in z.textures), "R6110", "SLMP")
    need(len(umbr) == sum(t.kind == UMBRELLAS for t in z.textures), "R6110", "UMBR")
    for t in z.textures:
        if t.kind == IMAGE:
            need(all(i < len(z.images) for i in t.images), "R6106")
            shapes = {(i.width, i.height, i.depth, i.layers,
                       i.layer_kind) for i in (z.images[k] for k in t.images)}
            need(len(shapes) == 1, "R6109")
        else:
            need(all(i == NONE for i in t.images), "R6106")
    coverage = set()
    payloads = iter(zpmp)
    for own, t in enumerate(z.textures):
        if t.kind == ZIPMAP:
            coverage |= read_zpmp(next(payloads)[1], own, z)
    payloads = iter(slmp)
    for t in z.textures:
        if t.kind == SILMAP:
            read_slmp(next(payloads)[1], t, z)
    payloads = iter(umbr)
    for own, t in enumerate(z.textures):
        if t.kind == UMBRELLAS:
            t.umbrellas = zumbrella.read(next(payloads)[1], len(t.images), t.wrap, own, z.images)
            t.elements = t.umbrellas.elements
    for version, payload in by_kind(b"META"):
        if version == 1:
            z.meta = read_meta(payload, z.warnings)
    for image in z.images:
        read_texels(texl, image)
    for k in sorted(coverage):
        check_coverage(z.images[k])
    return z
