# SPDX-License-Identifier: Apache-2.0
"""Codec 4, "fields", of spec/ztex.md section 6.5: the content of a tile's frame to its blocks."""

SIZES = {range(131, 135): (4, 4), range(137, 139): (2, 6, 4, 4), range(139, 141): (2, 6),
         range(141, 143): (2, 6, 2, 6), range(145, 147): (8, 8)}


def fields_of(number: int):
    """Bytes of the fields of a block of a format; None: the codec is not for it."""
    return next((sizes for formats, sizes in SIZES.items() if number in formats), None)


def together(content: bytes, sizes: tuple) -> bytes:
    count, o = len(content) // sum(sizes), 0
    out = bytearray(len(content))
    for s in sizes:
        for j in range(count):
            for k in range(s):
                out[sum(sizes) * j + o + k] = content[count * o + s * j + k]
        o += s
    return bytes(out)
