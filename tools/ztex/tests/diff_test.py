# SPDX-License-Identifier: Apache-2.0
"""diff tells content from storage: the same texels stored otherwise are the same, one texel that differs is told."""
import json
import os

import corpus
import support


class Diff(support.Case):
    def report(self, *words, status=support.DIFFERENT):
        found = json.loads(self.ztex("diff", "--json", *words, status=status)[0])
        corpus.validator("diff").validate(found)
        self.assertEqual(found["same"], status == support.OK)
        return found["differences"]

    def make(self, name, pixels, *words):
        support.save("a.png", pixels)
        self.ztex("make", "a.png", "-o", name, "--name", "a", *words)

    def test_storage_is_no_difference(self):
        pixels = support.ramps(100, 70)
        self.make("a.ztex", pixels)
        self.make("b.ztex", pixels, "--raw")
        self.report("a.ztex", "b.ztex", status=support.OK)
        self.assertEqual(self.ztex("diff", "a.ztex", "b.ztex")[0], b"")

    def test_one_texel(self):
        pixels = support.ramps(100, 70)
        self.make("a.ztex", pixels, "--levels", "1")
        pixels[33, 44, 1] ^= 1
        self.make("b.ztex", pixels, "--levels", "1")
        one = self.report("a.ztex", "b.ztex")
        self.assertEqual([d["where"] for d in one], ["image 0/level 0"])
        self.assertAlmostEqual(one[0]["max"], 1 / 255, places=6)
        self.assertGreater(one[0]["psnr"], 60)
        self.report("--tolerance", "0.004", "a.ztex", "b.ztex", status=support.OK)
        self.report("--structure-only", "a.ztex", "b.ztex", status=support.OK)
        out, errors = self.ztex("diff", "-q", "a.ztex", "b.ztex", status=support.DIFFERENT)
        self.assertEqual((out, errors), (b"", ""))

    def test_structure(self):
        pixels = support.ramps(100, 70)
        self.make("a.ztex", pixels, "--meta", "zt.title=One")
        self.make("b.ztex", pixels, "--meta", "zt.title=Two", "--wrap", "clamp")
        found = {d["where"]: (d["a"], d["b"]) for d in self.report("--structure-only", "a.ztex", "b.ztex")}
        self.assertEqual(found["metadata/0/value"], ('"One"', '"Two"'))
        self.assertIn("textures/0/wrap_u", found)

    def test_rendered(self):
        pixels = support.ramps(128, 128)
        self.make("a.ztex", pixels)
        self.make("b.ztex", pixels, "--tile-edge", "32")
        self.report("a.ztex", "b.ztex")
        self.report("--rendered", "--size", "64", "a.ztex", "b.ztex", status=support.OK)
        self.make("c.ztex", 255 - pixels)
        one = self.report("--rendered", "--size", "64", "a.ztex", "c.ztex")
        self.assertEqual(one[0]["part"], "rendered")

    def test_corpus_files_are_the_same_as_themselves(self):
        for path in corpus.paths("valid")[::12]:
            self.report(path, path, status=support.OK)

    def test_unknown_chunks_count(self):
        plain = os.path.join(corpus.folder("valid"), "zip_mask.ztex")
        other = os.path.join(corpus.folder("valid"), "zip_meta_unknown_chunk.ztex")
        self.assertTrue(any(d["where"].startswith("chunks/") for d in self.report("-q", plain, other)))

    def test_broken_file(self):
        path = os.path.join(corpus.folder("invalid"), "R2009_hash.ztex")
        self.ztex("diff", corpus.paths("valid")[0], path, status=support.INVALID)


if __name__ == "__main__":
    support.main()
