# SPDX-License-Identifier: Apache-2.0
"""Property: what comes out of a texture file is what is in it, bit for bit where a picture can hold it, and a file that was taken
apart and made again is the same. It matters because a format that one cannot get one's work out of is a trap."""
import json
import os

import numpy
from PIL import Image

import support
from support import UNSUPPORTED, USAGE, ramps, save


class One(support.Case):
    def make(self, pixels, *words):
        save("p.png", pixels)
        self.ztex("make", "p.png", "-o", "p.ztex", *words)

    def raw(self, *words, file="p.ztex"):
        return self.ztex("extract", file, "--raw", "-o", "-", *words)[0]

    def test_bytes(self):
        pixels = ramps(80, 50)
        self.make(pixels, "--tile-edge", "16")
        self.assertEqual(self.raw(), pixels.tobytes())
        self.assertEqual(self.raw("--region", "7,9,30,20"), pixels[9:29, 7:37].tobytes())
        for level in range(3):
            self.assertEqual(self.raw("--level", str(level)), self.texels("p.ztex", 0, level).tobytes())

    def test_pictures_of_eight_bits(self):
        for channels in (1, 3, 4):
            pixels = ramps(80, 50, channels)
            self.make(pixels)
            self.ztex("extract", "p.ztex", "-o", "x.png")
            shown = numpy.asarray(Image.open("x.png"))
            self.assertTrue((shown.reshape(pixels.shape) == pixels).all())
        self.ztex("extract", "p.ztex", "-o", "x.png", "--region", "1,2,3,4")
        self.assertTrue((numpy.asarray(Image.open("x.png")) == pixels[2:6, 1:4]).all())

    def test_each_plain_format_comes_back(self):
        for name, alpha in (("R8_UNORM", 0), ("R8G8_UNORM", 0), ("R16_UNORM", 0), ("R16G16B16_UNORM", 0),
                            ("R16G16B16A16_UNORM", 1), ("R16_SFLOAT", 0), ("R16G16B16_SFLOAT", 0),
                            ("R16G16B16A16_SFLOAT", 1), ("R32G32B32_SFLOAT", 0), ("E5B9G9R9_UFLOAT_PACK32", 0)):
            self.make(ramps(24, 20, 4 if alpha else 3), "--format", name)
            self.ztex("extract", "p.ztex", "--all", "all")
            self.ztex("make", "all/scene.json", "-o", "again.ztex")
            self.assertEqual(self.raw(), self.raw(file="again.ztex"), name)

    def test_floats_become_premultiplied_exr(self):
        self.make(ramps(24, 20, 4), "--format", "R32G32B32A32_SFLOAT")
        texels = numpy.frombuffer(self.raw(), numpy.float32).reshape(-1, 4)
        self.ztex("extract", "p.ztex", "-o", "x.exr")
        self.ztex("make", "x.exr", "-o", "x.ztex")
        found = numpy.frombuffer(self.raw(file="x.ztex"), numpy.float32).reshape(-1, 4)
        self.assertEqual(self.probe("x.ztex")["images"][0]["alpha"], 2)
        self.assertTrue((found[:, :3] == texels[:, :3] * texels[:, 3:]).all())

    def test_metadata(self):
        self.make(ramps(), "--meta", "zt.title=A b", "--meta", "my.key=\u00fc")
        pairs = json.loads(self.ztex("extract", "p.ztex", "--meta")[0])
        self.assertEqual(pairs, {"my.key": "\u00fc", "zt.title": "A b"})
        self.assertEqual(self.ztex("extract", "p.ztex", "--key", "zt.title")[0], b"A b\n")
        self.ztex("extract", "p.ztex", "--key", "zt.none", status=USAGE)

    def test_wrong_words(self):
        self.make(ramps())
        for words in (["-o", "x.png", "--level", "20"], ["-o", "x.png", "--image", "1"], ["-o", "-"], [],
                      ["-o", "x.png", "--region", "60,0,5,5"], ["-o", "x.png", "--slice", "1"],
                      ["-o", "x.png", "--patch", "0"], ["-o", "x.png", "--meta"]):
            self.ztex("extract", "p.ztex", *words, status=USAGE)
        self.trace_free("p.png", "p.ztex")

    def test_block_formats_come_as_bytes_only(self):
        file = os.path.join(os.path.dirname(os.path.abspath(__file__)),
                            "../../../conformance/valid/format_145_bc7_unorm_block.ztex")
        _, errors = self.ztex("extract", file, "-o", "x.png", status=UNSUPPORTED)
        self.assertIn("--raw", errors)
        self.assertEqual(len(self.raw(file=file)) % 16, 0)


class All(support.Case):
    def test_zipmap_with_layers_and_mask(self):
        save("root.png", ramps(64, 48))
        save("normal.png", ramps(64, 48)[::-1])
        save("patch.png", ramps(40, 40, 4))
        save("grey.png", ramps(40, 40, 1))
        scene = {"metadata": {"zt.title": "t"}, "textures": [
            {"name": "a/b", "wrap": ["repeat", "mirror", "clamp"],
             "layers": {"base_colour": "root.png", "normal": "normal.png"}},
            {"name": "z", "patches": [
                {"layers": {"base_colour": "root.png", "normal": "normal.png"}},
                {"layers": {"base_colour": "patch.png", "normal": "patch.png"}, "offset": [0.1, 0.2],
                 "scale": [0.3, 0.3]},
                {"layers": {"base_colour": "grey.png", "normal": "root.png"}, "separate_mask": True, "parent": 1,
                 "corners": [[0.1, 0.1], [0.9, 0.2], [0.8, 0.8], [0.1, 0.7]]},
                {"texture": "a/b", "mask": "grey.png", "offset": [0.5, 0.5], "scale": [0.25, 0.25]}]}]}
        with open("scene.json", "w", encoding="utf-8") as file:
            json.dump(scene, file)
        self.ztex("make", "scene.json", "-o", "z.ztex")
        self.ztex("extract", "z.ztex", "--all", "all")
        self.ztex("make", "all/scene.json", "-o", "again.ztex")
        before, after = self.probe("z.ztex"), self.probe("again.ztex")
        self.assertEqual(before["images"], after["images"])
        self.assertEqual(before["textures"], after["textures"])
        self.assertEqual(before["metadata"], after["metadata"])
        for i in range(len(before["images"])):
            self.assertTrue((self.texels("z.ztex", i) == self.texels("again.ztex", i)).all(), i)
        self.ztex("extract", "z.ztex", "-t", "z", "--patch", "2", "--mask", "-o", "mask.png")
        self.assertEqual(numpy.asarray(Image.open("mask.png")).shape, (40, 40))

    def test_frames_and_volumes(self):
        for kind in ("--frames", "--volume", "--array"):
            for i in range(3):
                save(f"p{i}.png", (ramps(20, 20) // 2 + 40 * i).astype(numpy.uint8))
            self.ztex("make", "p0.png", "p1.png", "p2.png", kind, "-o", "p.ztex")
            self.ztex("extract", "p.ztex", "--all", "all")
            self.ztex("make", "all/scene.json", "-o", "again.ztex")
            with open("p.ztex", "rb") as a, open("again.ztex", "rb") as b:
                self.assertEqual(a.read(), b.read(), kind)


if __name__ == "__main__":
    support.main()
