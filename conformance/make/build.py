#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Makes conformance/valid, conformance/invalid and their manifests; with --check compares them with
what it would make.

    build.py             writes the files, removes those that are no longer made
    build.py --check     writes nothing; exit code 1 and a list if anything differs,
                         the dumps in spec/ included
"""

import hashlib
import json
import os
import sys

sys.dont_write_bytecode = True

import fieldsmake       # noqa: F401  adds its files to both lists of cases
import hex as dump
import invalid
import invalid_silmaps  # noqa: F401  adds its files to invalid.CASES
import invalid_umbrellas  # noqa: F401  likewise
import valid
import valid_silmaps    # noqa: F401  adds its files to valid.CASES
import valid_umbrellas  # noqa: F401  likewise
from ztexmake import SPEC

LOOKUPS = {"lookups.json", "rays.json"}     # in valid/, made by ref/lookups.py
ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))


def sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def manifest(entries: list) -> bytes:
    """JSON with one entry a line."""
    lines = ",\n".join(json.dumps(e, ensure_ascii=True) for e in entries)
    return ("[\n%s\n]\n" % lines).encode()


def make_valid() -> dict:
    out, entries = {}, []
    for name, (what, file) in sorted(valid.CASES.items()):
        data = file.build()
        out[name + ".ztex"] = data
        entry = {"file": name + ".ztex", "what": what, "textures": len(file.textures),
                 "images": len(file.images),
                 "sha256": sha256(data)}
        entry["decoded"] = [{"image": i, "level": k, "sha256": sha256(image.level_data(k))}
                            for i, image in enumerate(file.images) for k in range(image.levels)]
        planes = [{name: n, "sha256": sha256(part.elements())}
                  for name, parts in (("zipmap", file.zipmaps()), ("silmap", file.silmaps()),
                                      ("umbrellas", file.umbrellas()))
                  for n, part in enumerate(parts)]
        if planes:
            entry["planes"] = planes
        entries.append(entry)
    out["manifest.json"] = manifest(entries)
    return out


def make_invalid() -> dict:
    out, entries = {}, []
    for case in sorted(invalid.CASES, key=lambda c: c.file):
        data = case.build()
        assert case.file not in out, case.file
        out[case.file] = data
        entry = {"file": case.file, "rule": case.rule, "severity": case.severity, "what": case.what,
                 "sha256": sha256(data)}
        if case.also:
            entry["also"] = list(case.also)
        entries.append(entry)
    out["manifest.json"] = manifest(entries)
    return out


def compare(folder: str, wanted: dict, write: bool) -> list:
    """Differences between a folder and what should be in it; with `write` they are removed."""
    path = os.path.join(ROOT, folder)
    os.makedirs(path, exist_ok=True)
    found = {n for n in os.listdir(path) if n.endswith((".ztex", ".json"))} - LOOKUPS
    problems = ["%s/%s: not made by build.py" % (folder, n) for n in sorted(found - set(wanted))]
    if write:
        for n in found - set(wanted):
            os.remove(os.path.join(path, n))
        problems = []
    for name, data in sorted(wanted.items()):
        full = os.path.join(path, name)
        if write:
            with open(full, "wb") as f:
                f.write(data)
        elif name not in found:
            problems.append("%s/%s: missing" % (folder, name))
        else:
            with open(full, "rb") as f:
                if f.read() != data:
                    problems.append("%s/%s: differs" % (folder, name))
    return problems


def main() -> int:
    write = "--check" not in sys.argv[1:]
    files = make_valid()
    problems = compare("valid", files, write) + compare("invalid", make_invalid(), write)
    problems += dump.check(SPEC, files, write)
    print("\n".join(problems) if problems
          else "corpus: %d valid files, %d invalid files" % (len(files) - 1, len(invalid.CASES)))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
