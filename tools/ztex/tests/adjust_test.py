# SPDX-License-Identifier: Apache-2.0
"""Property: a patch that was photographed in another light lies in its parent without a seam; its mask ends at 0; pruning and affine
frames do not change what is seen. It matters because nobody takes all photographs of a thing in the same light."""
import filecmp
import json
import os
import subprocess

import numpy
from PIL import Image

import support
from support import USAGE, ZTEX, save

ZOOM = 4  # of the patch to the root
ROOT = (160, 120)


def decode(v):
    return numpy.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def encode(v):
    v = numpy.clip(v, 0, 1)
    return numpy.where(v <= 0.0031308, v * 12.92, 1.055 * v ** (1 / 2.4) - 0.055)


def bytes_of(light):
    return (encode(light) * 255 + 0.5).astype(numpy.uint8)


def reduce_by(light, n):
    h, w = light.shape[:2]
    return light.reshape(h // n, n, w // n, n, -1).mean((1, 3))


def landscape():
    """Something with large and small detail in linear light, at the resolution of the patches."""
    rng = numpy.random.default_rng(7)
    w, h = ROOT[0] * ZOOM, ROOT[1] * ZOOM
    out = numpy.zeros((h, w, 3))
    for step, strength in ((160, 0.5), (40, 0.25), (10, 0.15), (2, 0.1)):
        coarse = Image.fromarray((rng.random((h // step + 2, w // step + 2, 3)) * 255).astype(numpy.uint8))
        out += strength * numpy.asarray(coarse.resize((w, h), Image.BICUBIC)) / 255
    return 0.03 + 0.6 * out ** 2


def low_pass(light):
    """To about a texel of the root: a box three times."""
    for _ in range(3):
        for axis in (0, 1):
            light = sum(numpy.roll(light, k, axis) for k in range(-2, 3)) / 5
    return light


class Adjust(support.Case):
    BOX = (101, 83, 320, 260)  # x, y, width, height of the patch at full resolution

    def setUp(self):
        super().setUp()
        self.full = landscape()
        self.h, self.w = self.full.shape[:2]
        save("root.png", bytes_of(reduce_by(self.full, ZOOM)))

    def crop(self, box=BOX):
        x, y, w, h = box
        return self.full[y:y + h, x:x + w]

    def place(self, box=BOX):
        x, y, w, h = box
        return {"offset": [x / self.w, y / self.h], "scale": [w / self.w, h / self.h]}

    def scene(self, *patches, root=None):
        return {"textures": [{"name": "t", "wrap": "clamp", "patches": [{"image": "root.png", **(root or {})}, *patches]}]}

    def make(self, scene, name="out.ztex", *words):
        with open("scene.json", "w") as file:
            json.dump(scene, file)
        self.ztex("make", "scene.json", "-o", name, *words)
        subprocess.run([ZTEX, "validate", name], check=True, stdout=subprocess.PIPE)
        return self.probe(name)

    def wrong(self, scene, *texts):
        with open("scene.json", "w") as file:
            json.dump(scene, file)
        _, errors = self.ztex("make", "scene.json", "-o", "never.ztex", status=USAGE)
        for text in texts:
            self.assertIn(text, errors)

    def patch_light(self, name, box=BOX):
        texels = self.texels(name, image=1).reshape(box[3], box[2], 4)
        return decode(texels[..., :3] / 255.0), texels[..., 3]

    def steps(self, name, box=BOX):
        """Differences of sRGB codes between the patch and the truth, both low-passed: along its edge, and of the mean."""
        light, _ = self.patch_light(name, box)
        inner = (slice(1, -1), slice(1, -1))
        off = encode(low_pass(light[inner])) - encode(low_pass(self.crop(box)[inner]))
        edge = 8  # inside of what np.roll brings in from the other side
        ring = numpy.concatenate([off[edge], off[-edge - 1], off[:, edge], off[:, -edge - 1]])
        return numpy.median(abs(ring)) * 255, abs(ring).max() * 255, abs(off[edge:-edge, edge:-edge].mean((0, 1))).max() * 255

    def test_other_light(self):
        h, w = self.BOX[3], self.BOX[2]
        y, x = numpy.mgrid[0:h, 0:w]
        r2 = ((x - w / 2) ** 2 + (y - h / 2) ** 2) / (w * w / 4 + h * h / 4)
        for light in (1.2, numpy.array([1.15, 0.95, 0.8]), (1 - 0.35 * r2)[..., None], (0.8 + 0.3 * x / w)[..., None]):
            save("child.png", bytes_of(self.crop() * light))
            self.make(self.scene({"image": "child.png", **self.place(), "mask": "none", "colour": "poisson"}))
            median, worst, mean = self.steps("out.ztex")
            self.assertLess(median, 1)
            self.assertLess(worst, 4)
            self.assertLess(mean, 1)
            self.make(self.scene({"image": "child.png", **self.place(), "mask": "none"}))
            self.assertGreater(self.steps("out.ztex")[2], 1, "without adjustment there is nothing to see")

    def test_gain(self):
        save("child.png", bytes_of(self.crop() * [1.15, 0.95, 0.8]))
        self.make(self.scene({"image": "child.png", **self.place(), "mask": "none", "colour": "gain"}))
        self.assertLess(max(self.steps("out.ztex")[::2]), 1)

    def test_overexposed_parent(self):
        """What the parent's camera has cut off is no reason to darken what lies beside it."""
        self.full[:170] = 1.6
        save("child.png", bytes_of(self.crop() * 0.55))
        self.full = numpy.minimum(self.full, 1)
        save("root.png", bytes_of(reduce_by(self.full, ZOOM)))
        self.make(self.scene({"image": "child.png", **self.place(), "mask": "none", "colour": "poisson"}))
        self.assertLess(max(self.steps("out.ztex")[::2]), 1)

    def test_chain_and_overhang(self):
        """A child of an adjusted patch follows the adjusted colours; one that hangs over its parent those of the root."""
        inner = (201, 143, 100, 90)
        beyond = (360, 250, 140, 160)
        save("child.png", bytes_of(self.crop() * 0.7))
        for box in (inner, beyond):
            save("inner.png", bytes_of(self.crop(box) * [0.6, 0.8, 0.9]))
            x, y, w, h = box
            px, py, pw, ph = self.BOX
            place = {"offset": [(x - px) / pw, (y - py) / ph], "scale": [w / pw, h / ph]}
            self.make(self.scene({"name": "c", "image": "child.png", **self.place(), "colour": "poisson", "mask": "none"},
                                 {"image": "inner.png", "parent": "c", **place, "colour": "poisson", "mask": "none"}))
            texels = self.texels("out.ztex", image=2).reshape(h, w, 4)[1:-1, 1:-1, :3]
            off = encode(decode(texels / 255.0)) - encode(self.crop(box)[1:-1, 1:-1])
            self.assertLess(abs(off.mean((0, 1))).max() * 255, 1.5, box)

    def test_threads(self):
        save("child.png", bytes_of(self.crop() * 1.2))
        scene = self.scene({"image": "child.png", **self.place(), "mask": "auto", "colour": "poisson", "prune": True},
                           root={"prune": True})
        self.make(scene, "one.ztex", "--threads", "1")
        self.make(scene, "two.ztex", "--threads", "3")
        self.assertTrue(filecmp.cmp("one.ztex", "two.ztex", shallow=False))

    def test_auto_mask(self):
        save("child.png", bytes_of(self.crop()))
        for extra in ({}, {"tau": 0.2}, {"ramp": 20}, {"separate_mask": True}):
            found = self.make(self.scene({"image": "child.png", **self.place(), "mask": "auto", **extra}))
            if "separate_mask" in extra:
                self.assertNotEqual(found["textures"][0]["patches"][1]["mask"], None)
                continue
            _, alpha = self.patch_light("out.ztex")
            self.assertEqual(max(alpha[0].max(), alpha[-1].max(), alpha[:, 0].max(), alpha[:, -1].max()), 0)
            self.assertEqual(numpy.median(alpha[60:-60, 60:-60]), 255)
            self.assertLessEqual(alpha[5].max(), 255 * 5 / extra.get("ramp", 8) + 1)

    def render(self, name, view, size=200):
        self.ztex("render", name, "-o", "r.png", "--view", ",".join(map(str, view)), "--size", f"{size}x{size}")
        return numpy.asarray(Image.open("r.png"))[..., :3].astype(int)

    def test_prune(self):
        """Rendered from near and far, nothing changes, and the file is smaller."""
        full = (16, 12, 600, 450)
        save("child.png", bytes_of(self.crop(full)))
        big = bytes_of(self.full)
        save("root.png", big)
        patch = {"image": "child.png", **self.place(full), "mask": "none"}
        self.make(self.scene(patch), "whole.ztex")
        self.make(self.scene(patch, root={"prune": True}), "pruned.ztex")
        self.assertLess(os.path.getsize("pruned.ztex"), 0.9 * os.path.getsize("whole.ztex"))
        for view in ((0, 0, 1, 1), (0.2, 0.2, 0.8, 0.8), (0, 0, 0.2, 0.2)):
            for size in (20, 57, 200):
                off = abs(self.render("whole.ztex", view, size) - self.render("pruned.ztex", view, size))
                self.assertLessEqual(off.max(), 1, (view, size))

    def test_bake_affine(self):
        corners = [[0.2, 0.2], [0.62, 0.25], [0.7, 0.75], [0.15, 0.68]]
        save("child.png", bytes_of(self.crop()))
        patch = {"image": "child.png", "corners": corners, "ramp": 12}
        inner = {"image": "child.png", "parent": 1, "offset": [0.3, 0.3], "scale": [0.3, 0.4]}
        self.make(self.scene(patch, inner), "plain.ztex")
        found = self.make(self.scene({**patch, "bake_affine": True}, inner), "baked.ztex")
        matrix = found["textures"][0]["patches"][1]["matrix"]
        self.assertEqual(matrix[6:], [0, 0, 1])
        off = abs(self.render("plain.ztex", (0, 0, 1, 1), 300) - self.render("baked.ztex", (0, 0, 1, 1), 300))
        self.assertLess(off.mean(), 1)
        self.assertLess(numpy.percentile(off, 99), 8)

    def test_layers(self):
        """Values are not colours: they stay, and the mask of the first layer is theirs."""
        save("child.png", bytes_of(self.crop() * 1.2))
        rough = (numpy.indices((self.BOX[3], self.BOX[2])).sum(0) % 256).astype(numpy.uint8)
        save("rough.png", rough)
        save("root_rough.png", rough[:90, :120])
        scene = {"textures": [{"name": "t", "patches": [
            {"layers": {"base_colour": "root.png", "roughness": "root_rough.png"}},
            {"layers": {"base_colour": "child.png", "roughness": "rough.png"}, **self.place(), "mask": "auto",
             "colour": "poisson"}]}]}
        found = self.make(scene)
        image = next(i for i, one in enumerate(found["images"]) if one["size"][:2] == [320, 260] and one["format"] == "R8_UNORM")
        self.assertTrue((self.texels("out.ztex", image=image) == rough.ravel()).all())

    def test_refusals(self):
        save("child.png", bytes_of(self.crop()))
        base = {"image": "child.png", **self.place()}
        at = "/textures/0/patches/1"
        self.wrong(self.scene({**base, "colour": "magic"}), f"{at}/colour", "none, gain, poisson")
        self.wrong(self.scene({**base, "tau": 0.3}), f"{at}/tau", "auto")
        self.wrong(self.scene({**base, "mask": "auto", "tau": 9}), f"{at}/tau", "at most 4")
        self.wrong(self.scene({**base, "mask": "auto", "tau": "x"}), f"{at}/tau", "a number")
        self.wrong(self.scene({**base, "prune": 1}), f"{at}/prune", "true or false")
        self.wrong(self.scene({**base, "bake_affine": "yes"}), f"{at}/bake_affine")
        self.wrong(self.scene({"image": {"files": ["child.png", "child.png"], "as": "frames"}, **self.place(), "colour": "gain"}),
                   f"{at}/image", "frames")
        self.wrong(self.scene(base, root={"colour": "gain"}), "/textures/0/patches/0")
        shown = self.scene({"texture": "s", **self.place(), "mask": "auto"})
        shown["textures"].insert(0, {"name": "s", "image": "child.png"})
        self.wrong(shown, "/textures/1/patches/1/mask")


support.main()
