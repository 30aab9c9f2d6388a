# SPDX-License-Identifier: Apache-2.0
"""validate accepts every valid file of the corpus and names the broken rule of every other one."""
import json
import os
import shutil

import corpus
import support


class Validate(support.Case):
    def report(self, *words, status=support.OK):
        found = json.loads(self.ztex("validate", "--json", *words, status=status)[0])
        corpus.validator("validate").validate(found)
        return found

    def test_valid(self):
        found = self.report(corpus.folder("valid"))
        self.assertEqual(found["summary"]["valid"], len(corpus.manifest("valid")))
        for one in found["files"]:
            self.assertEqual(one["findings"], [], one["file"])
            self.assertTrue(one["complete"], one["file"])

    def test_invalid(self):
        found = self.report(corpus.folder("invalid"), status=support.INVALID)
        files = {os.path.basename(one["file"]): one for one in found["files"]}
        self.assertEqual(len(files), len(corpus.manifest("invalid")))
        for entry in corpus.manifest("invalid"):
            one = files[entry["file"]]
            rules = {f"R{f['rule']}" for f in one["findings"]}
            # A fault of two rules at once may be met by the other one first.
            self.assertTrue(rules & {entry["rule"], *entry.get("also", [])}, f"{entry} {rules}")
            self.assertEqual(one["valid"], entry["severity"] == "warning", entry["file"])

    def many_findings(self):
        """A file with 24 tiles of which 20 are damaged."""
        support.save("a.png", support.ramps(96, 64))
        self.ztex("make", "a.png", "-o", "a.ztex", "--tile-edge", "16", "--raw", "--levels", "1")
        one = corpus.objects(self.ztex("inspect", "--json", "--tiles", "a.ztex")[0])[0]
        tiles = one["images"][0]["levels"][0]["tiles"]
        self.assertEqual(len(tiles), 24)
        with open("a.ztex", "r+b") as file:
            for tile in tiles[:20]:
                file.seek(tile["offset"])
                byte = file.read(1)[0]
                file.seek(tile["offset"])
                file.write(bytes([byte ^ 1]))

    def test_folding(self):
        self.many_findings()
        text = self.ztex("validate", "a.ztex", status=support.INVALID)[0].decode()
        self.assertEqual(text.count("R5203"), 6, text)
        self.assertIn("and 15 more", text)
        one = self.report("--max", "2", "a.ztex", status=support.INVALID)["files"][0]
        tiles = [f for f in one["findings"] if f["rule"] == 5203][0]
        self.assertEqual((tiles["count"], len(tiles["places"])), (20, 2))
        self.assertGreaterEqual(one["errors"], 20)

    def test_ignore_only_severity(self):
        self.many_findings()
        self.assertTrue(self.report("--ignore", "5203,stored-hash", "a.ztex")["files"][0]["valid"])
        self.assertTrue(self.report("--only", "R2001", "a.ztex")["files"][0]["valid"])
        self.report("--only", "tile-hash", "a.ztex", status=support.INVALID)
        one = self.report("--severity", "5203=warning", "--severity", "4003=ignore", "a.ztex")["files"][0]
        self.assertEqual((one["errors"], one["warnings"]), (0, 20))
        self.report("--severity", "5203=warning", "--ignore", "4003", "--structure", "a.ztex")

    def test_structure_sees_no_texels(self):
        self.many_findings()
        self.assertTrue(self.report("--structure", "a.ztex")["files"][0]["valid"])

    def test_warnings(self):
        name = [e["file"] for e in corpus.manifest("invalid") if e["severity"] == "warning"][0]
        path = os.path.join(corpus.folder("invalid"), name)
        self.assertTrue(self.report(path)["files"][0]["valid"])
        self.report("--werror", path, status=support.INVALID)

    def test_wrong_rules(self):
        for words in (("--ignore", "1"), ("--only", "tile-hush"), ("--severity", "5203"), ("--severity", "5203=no")):
            _, errors = self.ztex("validate", *words, "x.ztex", status=support.USAGE)
            self.assertIn(words[0], errors)
        self.assertIn("tile-hash", self.ztex("validate", "--only", "tile-hush", "x", status=support.USAGE)[1])

    def test_catalogue(self):
        rules = self.report("--list-rules")["rules"]
        self.assertEqual([r["rule"] for r in rules], sorted(r["rule"] for r in rules))
        text = self.ztex("validate", "--list-rules")[0].decode()
        self.assertEqual(len(text.splitlines()), len(rules))

    def test_folders_are_sorted_and_threads_change_nothing(self):
        os.makedirs("d/e")
        for place in ("d/b.ztex", "d/e/a.ztex", "d/a.ztex"):
            shutil.copy(corpus.paths("valid")[0], place)
        with open("d/notes.txt", "w", encoding="utf-8") as file:
            file.write("no texture")
        names = [one["file"] for one in self.report("d")["files"]]
        self.assertEqual(names, ["d/a.ztex", "d/b.ztex", "d/e/a.ztex"])
        self.many_findings()
        one = self.ztex("validate", "--threads", "1", "a.ztex", status=support.INVALID)[0]
        self.assertEqual(one, self.ztex("validate", "--threads", "4", "a.ztex", status=support.INVALID)[0])

    def test_missing_file(self):
        one = self.report("nothing.ztex", status=support.IO)["files"][0]
        self.assertFalse(one["checked"] or one["valid"])


if __name__ == "__main__":
    support.main()
