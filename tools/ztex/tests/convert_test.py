# SPDX-License-Identifier: Apache-2.0
"""Property: convert changes what it is asked to change, and nothing else: not a texel, not a matrix, not a chunk that it does not know.
It matters because a tool that loses what it does not understand ends the life of every extension."""
import json
import os

import numpy

import support
from support import UNSUPPORTED, USAGE, ramps, save

VALID = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../conformance/valid")


def read(path):
    with open(path, "rb") as file:
        return file.read()


class Convert(support.Case):
    def setUp(self):
        super().setUp()
        save("root.png", ramps(300, 200))
        save("patch.png", ramps(60, 40, 4))
        scene = {"metadata": {"zt.title": "t"}, "textures": [
            {"name": "plain", "image": "root.png"},
            {"name": "z", "wrap": "clamp", "patches": [
                {"layers": {"base_colour": "root.png", "roughness": {"file": "root.png", "format": "R8_UNORM"}}},
                {"layers": {"base_colour": "patch.png", "roughness": {"file": "patch.png", "format": "R8_UNORM"}},
                 "corners": [[0.1, 0.1], [0.9, 0.2], [0.8, 0.8], [0.1, 0.7]]}]}]}
        with open("scene.json", "w", encoding="utf-8") as file:
            json.dump(scene, file)
        self.ztex("make", "-q", "scene.json", "-o", "a.ztex")

    def convert(self, *words, status=0):
        self.ztex("convert", "a.ztex", "-o", "b.ztex", *words, status=status)
        return self.probe("b.ztex") if status == 0 else None

    def same_texels(self):
        images = self.probe("a.ztex")["images"]
        for i, image in enumerate(images):
            for level in range(image["levels"]):
                a, b = (self.texels(name, i, level) for name in ("a.ztex", "b.ztex"))
                self.assertTrue(a.size == b.size and (a == b).all(), f"image {i} level {level}")

    def test_nothing_asked_nothing_changed(self):
        self.convert()
        self.assertEqual(read("a.ztex"), read("b.ztex"))

    def test_storage(self):
        before = self.probe("a.ztex")
        for words in (["--raw"], ["--effort", "1"], ["--tile-edge", "32"]):
            after = self.convert(*words)
            self.same_texels()
            self.assertEqual(after["textures"], before["textures"])
        self.assertEqual({i["tile_edge"] for i in after["images"]}, {32})
        os.rename("b.ztex", "c.ztex")
        self.ztex("convert", "c.ztex", "-o", "d.ztex", "--tile-edge", "256", "--effort", "5")
        self.assertEqual(read("a.ztex"), read("d.ztex"))

    def test_format(self):
        before = self.probe("a.ztex")
        after = self.convert("--format", "R16G16B16A16_SFLOAT")
        self.assertEqual(before["textures"], after["textures"])
        for i, (a, b) in enumerate(zip(before["images"], after["images"])):
            if a["format"] == "R8_UNORM":  # data
                self.assertEqual(a, b)
                continue
            self.assertEqual((b["format"], b["transfer"], b["alpha"]), ("R16G16B16A16_SFLOAT", 8, a["alpha"]))
            coded = self.texels("a.ztex", i).reshape(a["size"][1], a["size"][0], -1)[..., :3] / 255
            light = numpy.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
            half = self.texels("b.ztex", i, dtype=numpy.float16).reshape(*coded.shape[:2], 4)[..., :3]
            self.assertTrue((abs(half - light) <= 0.0006 * light + 1e-7).all())
        # And back: halves are fine enough for eight bits.
        os.rename("b.ztex", "c.ztex")
        self.ztex("convert", "c.ztex", "-o", "b.ztex", "--format", "R8G8B8A8_SRGB")
        found = self.texels("b.ztex", 0).reshape(-1, 4)[:, :3]
        self.assertTrue((found == self.texels("a.ztex", 0).reshape(-1, 3)).all())
        self.convert("--format", "R8G8B8_SRGB", status=USAGE)  # the patch needs its alpha
        self.convert("--format", "BC7_SRGB_BLOCK", status=UNSUPPORTED)

    def test_levels(self):
        full = [i["levels"] for i in self.probe("a.ztex")["images"]]
        self.assertEqual({i["levels"] for i in self.convert("--levels", "2")["images"]}, {2})
        os.rename("b.ztex", "c.ztex")
        self.ztex("convert", "c.ztex", "-o", "b.ztex", "--levels", "all")
        self.assertEqual([i["levels"] for i in self.probe("b.ztex")["images"]], full)
        self.assertEqual(read("a.ztex"), read("b.ztex"))
        self.convert("--mip-filter", "box")
        self.assertNotEqual(read("a.ztex"), read("b.ztex"))

    def test_stripping(self):
        after = self.convert("--strip", "--strip-patches")
        self.assertEqual(after["metadata"], {})
        self.assertEqual([t["kind"] for t in after["textures"]], [0, 0])
        self.assertLess(len(after["images"]), len(self.probe("a.ztex")["images"]))
        after = self.convert("--keep-textures", "plain")
        self.assertEqual(([t["name"] for t in after["textures"]], len(after["images"])), (["plain"], 1))
        self.convert("--keep-textures", "plane", status=USAGE)

    def test_metadata(self):
        after = self.convert("--meta", "zt.author=me", "--unmeta", "zt.title")
        self.assertEqual(after["metadata"], {"zt.author": "me"})
        self.same_texels()

    def test_unknown_chunks(self):
        for name, kept in (("chunk_unknown_safe", True), ("chunk_unknown_zstd", True), ("chunk_unknown_unsafe", False)):
            before = os.path.join(VALID, name + ".ztex")
            _, text = self.ztex("convert", before, "-o", "u.ztex")
            self.assertEqual("dropped" in text, not kept, name)
            if kept:
                self.assertEqual(read(before)[208:].count(b"ZTchk"), read("u.ztex")[208:].count(b"ZTchk"), name)
        self.ztex("convert", os.path.join(VALID, "chunk_unknown_safe.ztex"), "-o", "u.ztex", "--strip")
        self.assertLess(len(read("u.ztex")), len(read(os.path.join(VALID, "chunk_unknown_safe.ztex"))))


if __name__ == "__main__":
    support.main()
