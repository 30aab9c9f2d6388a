# SPDX-License-Identifier: Apache-2.0
"""Property: a picture rendered at a texture's own size is that texture, and a zipmap differs from its root only where its patches are.
It matters because render is how people judge textures, and how the demo measures them."""
import json

import numpy
from PIL import Image

import support
from support import USAGE, ramps, save


def load(path):
    return numpy.asarray(Image.open(path)).astype(int)


def noise(width, height, channels=3):
    return numpy.random.default_rng(1).integers(0, 256, (height, width, channels), numpy.uint8)


class Plain(support.Case):
    def make(self, pixels, *words):
        save("p.png", pixels)
        self.ztex("make", "p.png", "-o", "p.ztex", *words)

    def render(self, *words, name="r.png"):
        self.ztex("render", "p.ztex", "-o", name, *words)
        return load(name) if name.endswith("png") else None

    def test_natural_size_is_exact(self):
        for channels in (1, 3):
            pixels = ramps(61, 47, channels)
            self.make(pixels)
            self.assertTrue((self.render().reshape(pixels.shape) == pixels).all())
        for how in ("nearest", "bilinear"):
            self.assertTrue((self.render("--filter", how) == ramps(61, 47)).all())

    def test_alpha_stays_straight(self):
        pixels = ramps(40, 30, 4)
        self.make(pixels)
        shown = self.render()
        visible = pixels[..., 3] > 8
        self.assertTrue((shown[..., 3] == pixels[..., 3]).all())
        self.assertLessEqual(abs(shown - pixels)[visible].max(), 1)
        black = self.render("--background", "0,0,0")
        self.assertEqual(black.shape, (30, 40, 3))
        self.assertTrue((black[pixels[..., 3] == 0] == 0).all())

    def test_views(self):
        pixels = noise(64, 48)
        self.make(pixels)
        self.assertTrue((self.render("--view", "0.25,0.5,0.75,1") == pixels[24:, 16:48]).all())
        self.assertTrue((self.render("--view", "1,0,0,1") == pixels[:, ::-1]).all())
        self.assertTrue((self.render("--view", "-0.5,0,0.5,1") == numpy.roll(pixels, 32, 1)).all())
        self.assertEqual(self.render("--size", "32").shape, (24, 32, 3))
        self.assertEqual(self.render("--view", "0,0,0.5,1", "--size", "x96").shape, (96, 64, 3))

    def test_supersampling_is_the_mean_of_light(self):
        pixels = numpy.zeros((16, 16, 3), numpy.uint8)
        pixels[::2] = 255
        self.make(pixels, "--levels", "1")
        shown = self.render("--size", "8x8", "--supersample", "2", "--filter", "nearest")
        self.assertTrue((shown == 188).all(), shown)  # half the light, in sRGB
        self.assertTrue((self.render("--exposure", "-1")[0] == 188).all())

    def test_frames_and_sheets(self):
        self.make(noise(64, 64))
        path = "0,0,1,1;0.25,0.25,0.5,0.5"
        self.ztex("render", "p.ztex", "-o", "f%03d.png", "--zoom-path", path, "--frames", "3", "--size", "16")
        first, middle, last = (load(f"f{i:03}.png") for i in (1, 2, 3))
        self.assertTrue((first == self.render("--size", "16")).all())
        self.assertTrue((last == self.render("--view", "0.25,0.25,0.5,0.5", "--size", "16")).all())
        sheet = self.render("--zoom-path", path, "--frames", "3", "--size", "16", "--sheet", "2")
        self.assertEqual(sheet.shape, (36, 36, 3))
        self.assertTrue((sheet[:16, 20:] == middle).all() and (sheet[20:, :16] == last).all())
        self.assertTrue((sheet[20:, 20:] == 255).all())
        # The zoom is even: in the middle the view is the geometric mean, and the point that stays does stay.
        size = (0.25 * 1) ** 0.5
        at = (1 - size) / (1 - 0.25) * 0.25
        self.assertTrue((middle == self.render("--view", f"{at},{at},{at + size},{at + size}", "--size", "16")).all())

    def test_sixteen_bits_and_wrong_words(self):
        self.make(ramps(20, 10, 1))
        self.ztex("render", "p.ztex", "-o", "r.png", "--bits", "16")
        self.assertTrue((load("r.png") == ramps(20, 10, 1)[..., 0].astype(int) * 257).all())
        self.ztex("render", "p.ztex", "-o", "r.exr")
        for words in (["--view", "0,0,0,1"], ["--size", "0x3"], ["--texture", "q"], ["--layer", "normal"],
                      ["--zoom-path", "0,0,1,1"], ["--frames", "3"], ["--array-layer", "1"], ["--bits", "32"],
                      ["--view", "0,0,1,1", "--view", "0,0,1,1"], ["--background", "1,2"]):
            self.ztex("render", "p.ztex", "-o", "bad.png", *words, status=USAGE)
        self.trace_free("p.png", "p.ztex", "r.png", "r.exr")

    def test_data_keep_their_numbers(self):
        pixels = ramps(32, 32, 1)
        self.make(pixels, "--semantic", "roughness")
        self.assertTrue((self.render() == pixels[..., 0]).all())


class Zipmap(support.Case):
    """A grey root of 32 x 32 and a patch of noise on its middle, at four times the resolution."""

    def setUp(self):
        super().setUp()
        self.photo = noise(128, 128)
        save("photo.png", self.photo)
        scene = {"textures": [{"name": "z", "wrap": "clamp", "patches": [
            {"image": {"file": "photo.png", "resize": [32, 32]}},
            {"image": {"file": "photo.png", "crop": [32, 48, 64, 32]}, "at_crop": True, "ramp": 4}]}]}
        with open("scene.json", "w", encoding="utf-8") as file:
            json.dump(scene, file)
        self.ztex("make", "scene.json", "-o", "z.ztex")

    def render(self, *words):
        self.ztex("render", "z.ztex", "-o", "r.png", "--size", "128x128", *words)
        return load("r.png")

    def test_patches_and_nothing_else(self):
        whole, root = self.render(), self.render("--root-only")
        differ = (whole != root).any(-1)
        self.assertTrue(differ[56:72, 40:88].mean() > 0.9)
        differ[48:80, 32:96] = False
        self.assertFalse(differ.any())
        # Behind the ramp the patch is the photograph, texel for texel.
        self.assertTrue((whole[53:75, 37:91] == self.photo[53:75, 37:91]).all())

    def test_threads_do_not_matter(self):
        self.assertTrue((self.render("--threads", "1") == self.render("--threads", "3")).all())


if __name__ == "__main__":
    support.main()
