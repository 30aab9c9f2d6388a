#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Turns an annotated dump into bytes. A line is hex bytes, then an optional `; comment`; empty
lines are allowed.

    hex.py FILE.hex [OUTPUT]     writes the bytes to OUTPUT or standard output
"""

import os
import sys

EXAMPLES = {"first.hex": "first.ztex", "zipmap.hex": "zip_patch_smallest.ztex"}


def parse(text: str) -> bytes:
    return bytes.fromhex(" ".join(line.split(";")[0] for line in text.splitlines()))


def between(text: str, begin: str, end: str) -> tuple:
    """The parts of a text before, between and behind two markers."""
    a = text.index(begin) + len(begin)
    b = text.index(end, a)
    return text[:a], text[a:b], text[b:]


def check(spec: str, valid: dict, write: bool) -> list:
    """Problems with the dumps of spec/examples: bytes other than the corpus, or another dump in
    ztex.md. `write` brings the dump into ztex.md."""
    problems = []
    texts = {}
    for name, file in EXAMPLES.items():
        path = os.path.join(spec, "examples", name)
        if not os.path.exists(path):
            problems.append("spec/examples/%s: missing" % name)
            continue
        with open(path, encoding="utf-8") as f:
            texts[name] = f.read()
        if parse(texts[name]) != valid[file]:
            problems.append("spec/examples/%s: not the bytes of valid/%s" % (name, file))
    if "first.hex" in texts:
        path = os.path.join(spec, "ztex.md")
        with open(path, encoding="utf-8") as f:
            old = f.read()
        before, inside, behind = between(old, "<!-- first.hex begins -->",
                                         "<!-- first.hex ends -->")
        wanted = "\n```\n%s\n```\n" % texts["first.hex"].rstrip("\n")
        if inside != wanted and write:
            with open(path, "w", encoding="utf-8") as f:
                f.write(before + wanted + behind)
        elif inside != wanted:
            problems.append("spec/ztex.md: the dump of section 1 is not examples/first.hex")
    return problems


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as source:
        data = parse(source.read())
    if len(sys.argv) > 2:
        with open(sys.argv[2], "wb") as out:
            out.write(data)
    else:
        sys.stdout.buffer.write(data)
