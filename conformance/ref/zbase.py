# SPDX-License-Identifier: Apache-2.0
"""What all parts of the reader share: faults, fields, and spec/ztex.md sections 6.1 and 6.2, the
codec zstd and planes."""

import struct

import xxhash
import zstandard


class Fault(Exception):
    def __init__(self, rule: str, text: str = ""):
        super().__init__("%s %s" % (rule, text))
        self.rule = rule


def need(condition, rule: str, text: str = ""):
    if not condition:
        raise Fault(rule, text)


def xxh3(data) -> int:
    return xxhash.xxh3_64_intdigest(bytes(data))


def align16(x: int) -> int:
    return (x + 15) & ~15


def ceil_div(a: int, b: int) -> int:
    return -(-a // b)


class Cursor:
    """Reads fields one after another; running out of bytes breaks `rule`."""

    def __init__(self, data: bytes, rule: str):
        self.data, self.at, self.rule = data, 0, rule

    def take(self, n: int) -> bytes:
        need(n <= len(self.data) - self.at, self.rule, "too few bytes")
        self.at += n
        return self.data[self.at - n:self.at]

    def fields(self, layout: str) -> tuple:
        return struct.unpack("<" + layout, self.take(struct.calcsize("<" + layout)))

    def left(self) -> int:
        return len(self.data) - self.at


# ---- 6.1 zstd ------------------------------------------------------------------------------------

def unzstd(stored: bytes, size: int) -> bytes:
    """One frame of the profile of 6.1 that decodes to `size` bytes."""
    need(len(stored) >= 5 and stored[:4] == b"\x28\xb5\x2f\xfd", "R5001", "magic number")
    descriptor = stored[4]
    need(descriptor & 0x3F == 0x20, "R5001", "descriptor")
    width = (1, 2, 4, 8)[descriptor >> 6]
    need(len(stored) >= 5 + width, "R5002", "cut")
    content = int.from_bytes(stored[5:5 + width], "little") + (256 if width == 2 else 0)
    need(content == size, "R5002")
    at, last = 5 + width, False
    while not last:
        need(at + 3 <= len(stored), "R5003", "block header")
        header = int.from_bytes(stored[at:at + 3], "little")
        last, kind, length = header & 1, header >> 1 & 3, header >> 3
        need(kind != 3, "R5003", "reserved type")
        need(length <= 131072, "R5003", "block size")
        at += 3 + (1 if kind == 1 else length)
        need(at <= len(stored), "R5003", "block ends behind the stored bytes")
    need(at == len(stored), "R5003", "bytes behind the frame")
    try:
        out = zstandard.ZstdDecompressor().decompress(stored)
    except zstandard.ZstdError as error:
        raise Fault("R5004", str(error))
    need(len(out) == size, "R5004")
    return out


# ---- 6.2 planes ----------------------------------------------------------------------------------

def read_plane(c: Cursor, size: int, count: int) -> list:
    (element, predictor, packing, codec, bit_width, reserved, base, n, stored_size,
     digest) = c.fields("5B3sQIIQ")
    need(element in (1, 2, 4, 8) and (element, n) == (size, count), "R5102")
    need(predictor <= 2 and packing <= 2 and codec <= 1 and reserved == b"\0\0\0", "R5101")
    if packing == 2:
        need(predictor == 0 and codec == 0 and bit_width <= 8 * size, "R5101")
        need(base < 1 << 8 * size and base + (1 << bit_width) - 1 < 1 << 8 * size, "R5101", "base")
        need(stored_size == ceil_div(n * bit_width, 8), "R5103")
    else:
        need(bit_width == 0 and base == 0, "R5101")
        need(stored_size == n * size if codec == 0 else 1 <= stored_size < n * size, "R5103")
    stored = c.take(stored_size)
    mask = (1 << 8 * size) - 1
    if packing == 2:
        number = int.from_bytes(stored, "little")
        need(number >> (n * bit_width) == 0, "R5104")
        values = [(number >> (i * bit_width) & ((1 << bit_width) - 1)) + base
                  for i in range(n)] if bit_width else [base] * n
    else:
        content = unzstd(stored, n * size) if codec else stored
        if packing == 1:
            content = bytes(content[k * n + i] for i in range(n) for k in range(size))
        values = [int.from_bytes(content[i * size:(i + 1) * size], "little") for i in range(n)]
    if predictor:
        e1 = e2 = 0
        for i, z in enumerate(values):
            d = (z >> 1) ^ (-(z & 1) & mask)
            e = (e1 + d if predictor == 1 else 2 * e1 - e2 + d) & mask
            values[i], e1, e2 = e, e, e1
    need(xxh3(b"".join(v.to_bytes(size, "little") for v in values)) == digest, "R5105")
    return values
