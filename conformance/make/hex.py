#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Turns an annotated dump into bytes. A line is hex bytes, then an optional `; comment`; empty
lines are allowed.

    hex.py FILE.hex [OUTPUT]     writes the bytes to OUTPUT or standard output
"""

import os
import struct
import sys

EXAMPLES = {"first.hex": "first.ztex", "zipmap.hex": "zip_patch_smallest.ztex"}
PARTS = {"pred.hex": "pred_example.ztex"}             # part of a file: the last tile
CHUNKS = {"silmap.hex": "silmap_example.ztex",       # the stored bytes of a chunk
          "umbrella.hex": "umbrella_example.ztex"}
QUOTED = {"first.hex": "ztex.md", "pred.hex": "ztex.md", "silmap.hex": "silmap.md",
          "umbrella.hex": "umbrella.md"}


def parse(text: str) -> bytes:
    return bytes.fromhex(" ".join(line.split(";")[0] for line in text.splitlines()))


def between(text: str, begin: str, end: str) -> tuple:
    """The parts of a text before, between and behind two markers."""
    a = text.index(begin) + len(begin)
    b = text.index(end, a)
    return text[:a], text[a:b], text[b:]


def chunks_of(data: bytes) -> list:
    """The stored bytes of each chunk."""
    out = []
    for i in range(struct.unpack_from("<I", data, 28)[0]):
        offset, size = struct.unpack_from("<QQ", data, 64 + 48 * i + 8)
        out.append(data[offset + 64:offset + 64 + size])
    return out


def check(spec: str, valid: dict, write: bool) -> list:
    """Problems with the dumps of spec/examples: bytes other than the corpus, or another dump in the
    document. `write` brings the dumps into the documents."""
    problems = []
    texts = {}
    for name, file in (EXAMPLES | PARTS | CHUNKS).items():
        path = os.path.join(spec, "examples", name)
        if not os.path.exists(path):
            problems.append("spec/examples/%s: missing" % name)
            continue
        with open(path, encoding="utf-8") as f:
            texts[name] = f.read()
        data = parse(texts[name])
        if name in EXAMPLES and data != valid[file]:
            problems.append("spec/examples/%s: not the bytes of valid/%s" % (name, file))
        if name in PARTS and not valid[file].rstrip(b"\0").endswith(data.rstrip(b"\0")):
            problems.append("spec/examples/%s: not the last tile of valid/%s" % (name, file))
        if name in CHUNKS and data not in chunks_of(valid[file]):
            problems.append("spec/examples/%s: not a chunk of valid/%s" % (name, file))
    for name in (n for n in QUOTED if n in texts):
        path = os.path.join(spec, QUOTED[name])
        with open(path, encoding="utf-8") as f:
            old = f.read()
        before, inside, behind = between(old, "<!-- %s begins -->" % name,
                                         "<!-- %s ends -->" % name)
        wanted = "\n```\n%s\n```\n" % texts[name].rstrip("\n")
        if inside != wanted and write:
            with open(path, "w", encoding="utf-8") as f:
                f.write(before + wanted + behind)
        elif inside != wanted:
            problems.append("spec/%s: a dump is not examples/%s" % (QUOTED[name], name))
    return problems


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as source:
        data = parse(source.read())
    if len(sys.argv) > 2:
        with open(sys.argv[2], "wb") as out:
            out.write(data)
    else:
        sys.stdout.buffer.write(data)
