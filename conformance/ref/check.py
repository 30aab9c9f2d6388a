#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the reference reader over the corpus: verdict, rule, decoded bytes and lookups. Exit
code 1 and a list if any differs. With file names as arguments: prints the verdict for each."""

import hashlib
import json
import os
import sys

sys.dont_write_bytecode = True

import lookups
import zsample
import ztexref
import zumbrella

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))


def load(folder: str, name: str) -> bytes:
    with open(os.path.join(ROOT, folder, name), "rb") as f:
        return f.read()


def sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def check_valid(entry: dict) -> list:
    data = load("valid", entry["file"])
    try:
        z = ztexref.read(data)
    except ztexref.Fault as fault:
        return ["refused: %s" % fault]
    problems = [] if sha256(data) == entry["sha256"] else ["sha256 of the file"]
    problems += ["warning " + w for w in z.warnings]
    if (len(z.textures), len(z.images)) != (entry["textures"], entry["images"]):
        problems.append("counts")
    decoded = [{"image": i, "level": k, "sha256": sha256(d)} for i, m in enumerate(z.images) for k,
               d in enumerate(m.decoded)]
    if decoded != entry["decoded"]:
        problems.append("decoded levels")
    for kind, name in ((ztexref.ZIPMAP, "zipmap"), (ztexref.SILMAP, "silmap"),
                       (ztexref.UMBRELLAS, "umbrellas")):
        planes = [sha256(t.elements) for t in z.textures if t.kind == kind]
        if planes != [p["sha256"] for p in entry.get("planes", []) if name in p]:
            problems.append("decoded planes")
    return problems


def check_invalid(entry: dict) -> list:
    data = load("invalid", entry["file"])
    problems = [] if sha256(data) == entry["sha256"] else ["sha256 of the file"]
    try:
        z = ztexref.read(data)
    except ztexref.Fault as fault:
        if entry["severity"] != "error" or fault.rule not in [entry["rule"]] + entry.get("also",
                []):
            problems.append("refused for %s" % fault)
        return problems
    if entry["severity"] != "warning":
        problems.append("accepted")
    elif z.warnings != [entry["rule"]]:
        problems.append("warnings: %s" % z.warnings)
    return problems


def check_lookups() -> tuple:
    """Count and problems of valid/lookups.json."""
    entries, problems, opened = json.loads(load("valid", "lookups.json")), [], {}
    for e in entries:
        if e["file"] not in opened:
            opened = {e["file"]: ztexref.read(load("valid", e["file"]))}
        z = opened[e["file"]]
        u, v, *d = e["at"]
        light = zumbrella.Light(e["light_x"], e["light_y"], e["shadow"]) if "shadow" in e else None
        q = zsample.Query(u, v, tuple(d[:2]), tuple(d[2:]), e["frame"], e["filter"], light)
        found = zsample.look_up(z, z.textures[e["texture"]], q)
        if len(found) != len(e["layers"]) or any(
                abs(a - b) > 1e-6 for have, want in zip(found, e["layers"])
                for a, b in zip(have, want)):
            problems.append("valid/%s: lookup at %s: %s" % (e["file"], e["at"], found))
    return len(entries), problems


def check_rays() -> tuple:
    """Count and problems of valid/rays.json."""
    count, problems = 0, []
    for e in json.loads(load("valid", "rays.json")):
        z = ztexref.read(load("valid", e["file"]))
        texture = z.textures[e["texture"]]
        for wanted in e["rays"]:
            count += 1
            found = zsample.trace(z, texture, lookups.ray_of(texture, wanted))
            pairs = [*zip(found.rgba, wanted["rgba"]), *zip(found.normal, wanted["normal"]),
                     (found.t, wanted["t"])]
            if ((found.kind, found.umbrella) != (wanted["kind"], wanted["umbrella"])
                    or any(abs(a - b) > 1e-6 for a, b in pairs)):
                problems.append("valid/%s: ray %s: %s" % (e["file"], wanted, found))
    return count, problems


def main() -> int:
    if len(sys.argv) > 1:
        for name in sys.argv[1:]:
            with open(name, "rb") as f:
                try:
                    ztexref.read(f.read())
                    print("%s: valid" % name)
                except ztexref.Fault as fault:
                    print("%s: %s" % (name, fault))
        return 0
    count = failures = 0
    for folder, check in (("valid", check_valid), ("invalid", check_invalid)):
        for entry in json.loads(load(folder, "manifest.json")):
            count += 1
            try:
                problems = check(entry)
            except Exception as error:          # a reader may refuse, never fail
                problems = ["%s: %s" % (type(error).__name__, error)]
            failures += bool(problems)
            for p in problems:
                print("%s/%s: %s" % (folder, entry["file"], p))
    looked_up, problems = check_lookups()
    rays, more = check_rays()
    failures += len(problems) + len(more)
    for p in problems + more:
        print(p)
    print("reference reader: %d files, %d lookups, %d rays, %d failures"
          % (count, looked_up, rays, failures))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
