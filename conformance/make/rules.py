#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that every rule mark of the specification has an invalid file and that every invalid file
names a rule that the specification states; that file names begin with the rule; that no rule is
stated twice. Exit code 1 and a list if not."""

import json
import os
import re
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
DOCUMENTS = ("ztex.md", "zipmap.md", "silmap.md", "umbrella.md", "registry.md")


def stated_rules(problems: list) -> set:
    """The rules that begin a paragraph of the specification; references to them stand within
    one."""
    stated, named = set(), set()
    for document in DOCUMENTS:
        with open(os.path.join(ROOT, "spec", document), encoding="utf-8") as f:
            text = f.read()
        named |= set(re.findall(r"\[(R\d{4})\]", text))
        for rule in re.findall(r"\n\n\[(R\d{4})\] ", text):
            if rule in stated:
                problems.append("%s: stated twice" % rule)
            stated.add(rule)
    problems += ["%s: named in the specification, stated nowhere" % r
                 for r in sorted(named - stated)]
    return stated


def main() -> int:
    problems = []
    stated = stated_rules(problems)
    with open(os.path.join(ROOT, "conformance", "invalid", "manifest.json"), encoding="utf-8") as f:
        entries = json.load(f)
    for e in entries:
        if not e["file"].startswith(e["rule"] + "_"):
            problems.append("%s: the name does not begin with %s" % (e["file"], e["rule"]))
        for rule in [e["rule"]] + e.get("also", []):
            if rule not in stated:
                problems.append("%s: %s is not a rule" % (e["file"], rule))
        if not os.path.exists(os.path.join(ROOT, "conformance", "invalid", e["file"])):
            problems.append("%s: missing" % e["file"])
    covered = {e["rule"] for e in entries}
    problems += ["%s: no invalid file" % r for r in sorted(stated - covered)]
    print("\n".join(problems) if problems else "rules: %d stated, %d files" % (len(stated),
        len(entries)))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
