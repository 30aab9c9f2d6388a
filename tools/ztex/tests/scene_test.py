# SPDX-License-Identifier: Apache-2.0
"""Property: a scene becomes the zipmap that it describes, every way to place a patch means what docs/scene.md says, and a mistake is
answered with the scene's name, the place in it, and what to do. It matters because scenes are written by hand."""
import json
import os
import re
import subprocess

import numpy

import support
from support import IO, USAGE, ramps, save

HERE = os.path.dirname(os.path.abspath(__file__))


def applied(matrix, point):
    x, y, w = numpy.array(matrix).reshape(3, 3) @ [point[0], point[1], 1.0]
    return x / w, y / w, w


class Scene(support.Case):
    def setUp(self):
        super().setUp()
        save("root.png", ramps(128, 128))
        save("rgba.png", ramps(64, 48, 4))
        save("rgb.png", ramps(64, 48))
        save("grey.png", ramps(64, 48, 1))

    def make(self, scene, *words):
        with open("scene.json", "w") as file:
            json.dump(scene, file)
        self.ztex("make", "scene.json", "-o", "out.ztex", *words)
        return self.probe("out.ztex")

    def wrong(self, scene, *texts, status=USAGE):
        with open("scene.json", "w") as file:
            file.write(scene if isinstance(scene, str) else json.dumps(scene))
        out, errors = self.ztex("make", "scene.json", "-o", "never.ztex", status=status)
        self.assertFalse(os.path.exists("never.ztex"))
        for text in ("scene.json: ", *texts):
            self.assertIn(text, errors)

    def zipmap(self, *patches, **more):
        return {"textures": [{"name": "z", "patches": [{"image": "root.png"}, *patches], **more}]}

    def patch(self, **place):
        """The one patch that this describes, with the file's images."""
        found = self.make(self.zipmap({"image": "rgb.png", **place}))
        return found["textures"][0]["patches"][1], found["images"]


class Placing(Scene):
    def check_corners(self, matrix, corners, digits=12):
        for corner, place in zip([(0, 0), (1, 0), (1, 1), (0, 1)], corners):
            x, y, w = applied(matrix, place)
            self.assertAlmostEqual(x, corner[0], digits)
            self.assertAlmostEqual(y, corner[1], digits)
            self.assertGreater(w, 0)

    def test_offset_and_scale(self):
        patch, _ = self.patch(offset=[0.25, 0.5], scale=[0.5, 0.125])
        self.assertEqual(patch["matrix"], [2, 0, -0.5, 0, 8, -4, 0, 0, 1])

    def test_no_negative_zero(self):
        for place in ({"offset": [0, 0], "scale": [0.5, 0.5]}, {"matrix": [2, -0.0, 0, 0, 2, 0, 0, 0, 1]},
                      {"corners": [[0, 0], [1, 0], [1, 1], [0, 1]]}, {"rect_pixels": [0, 0, 64, 64]}):
            patch, _ = self.patch(**place)
            self.assertFalse(numpy.signbit([v for v in patch["matrix"] if v == 0]).any(), place)

    def test_corners(self):
        for corners in ([[0.1, 0.2], [0.3, 0.19], [0.31, 0.5], [0.1, 0.48]], [[0.2, 0.2], [0.4, 0.2], [0.4, 0.4], [0.2, 0.4]],
                        [[0.9, 0.1], [0.1, 0.1], [0.1, 0.9], [0.9, 0.9]], [[0.4, 0.1], [0.6, 0.1], [1.4, 0.9], [-0.4, 0.9]]):
            patch, _ = self.patch(corners=corners)
            self.check_corners(patch["matrix"], corners)

    def test_pixels_of_the_parent(self):
        patch, _ = self.patch(rect_pixels=[32, 64, 64, 16])
        self.assertEqual(patch["matrix"], [2, 0, -0.5, 0, 8, -4, 0, 0, 1])

    def test_crop(self):
        found = self.make({"textures": [{"patches": [
            {"image": {"file": "root.png", "resize": [32, 32]}},
            {"image": {"file": "root.png", "crop": [32, 64, 64, 16]}, "at_crop": True, "ramp": 1}]}]})
        self.assertEqual(found["textures"][0]["patches"][1]["matrix"], [2, 0, -0.5, 0, 8, -4, 0, 0, 1])
        self.assertEqual([image["size"][:2] for image in found["images"]], [[32, 32], [64, 16]])
        inside = self.texels("out.ztex", 1).reshape(16, 64, 4)
        self.assertTrue((inside[..., :3] == ramps(128, 128)[64:80, 32:96]).all())

    def test_root_coordinates(self):
        wanted = [10.0, 1, -5, 0, 10, -5, 0.5, 0, 1]
        found = self.make(self.zipmap(
            {"name": "a", "image": "rgb.png", "corners": [[0.1, 0.2], [0.3, 0.19], [0.31, 0.5], [0.1, 0.48]]},
            {"image": "rgb.png", "parent": "a", "matrix_root": wanted}))
        patch = found["textures"][0]["patches"][2]
        self.assertEqual(patch["parent"], 1)
        self.assertLess(abs(numpy.array(patch["root_matrix"]) - wanted).max(), 1e-12)

    def test_root_is_the_identity(self):
        found = self.make(self.zipmap({"image": "rgb.png", "offset": [0, 0], "scale": [1, 1]}))
        self.assertEqual(found["textures"][0]["patches"][0]["matrix"], [1, 0, 0, 0, 1, 0, 0, 0, 1])


class Coverage(Scene):
    def alpha(self, name, scale=1, **patch):
        self.make(self.zipmap({"image": name, "offset": [0.2, 0.2], "scale": [0.5, 0.5], **patch}))
        return self.texels("out.ztex", 1).reshape(48, 64, 4)

    def test_ramp(self):
        for ramp in (1, 4, 8, 100):
            stored = self.alpha("rgb.png", ramp=ramp)
            self.assertTrue((stored[..., :3] == ramps(64, 48)).all())
            y, x = numpy.mgrid[:48, :64]
            inside = numpy.minimum(numpy.minimum(x, 63 - x), numpy.minimum(y, 47 - y))
            wanted = numpy.minimum(1, inside / min(ramp, 23)) * 255
            self.assertLessEqual(abs(stored[..., 3] - wanted).max(), 0.5001, ramp)

    def test_no_ramp(self):
        stored = self.alpha("rgb.png", mask="none")[..., 3]
        self.assertTrue((stored[1:-1, 1:-1] == 255).all() and stored[0].max() == 0 and stored[:, -1].max() == 0)

    def test_product(self):
        stored = self.alpha("rgba.png", mask="grey.png", ramp=4)[24, :, 3].astype(float)
        x = numpy.arange(64)
        ramp = numpy.minimum(1, numpy.minimum(x, 63 - x) / 4)
        wanted = ramps(64, 48, 4)[24, :, 3] * (ramps(64, 48, 1)[24, :, 0] / 255.0) * ramp
        self.assertLessEqual(abs(stored - wanted).max(), 0.51)

    def test_mask_of_another_size(self):
        save("small.png", numpy.full((12, 16), 128, numpy.uint8))
        stored = self.alpha("rgb.png", mask="small.png")
        self.assertTrue((stored[1:-1, 1:-1, 3] == 128).all())

    def test_mask_images(self):
        for image, more in (("grey.png", {}), ("rgba.png", {"separate_mask": True})):
            patch, images = self.patch(image=image, offset=[0, 0], scale=[1, 1], **more)
            self.assertEqual(images[patch["mask"]]["format"], "R8_UNORM")
            self.assertEqual(images[patch["images"][0]]["alpha"], 0)
        self.assertEqual(images[patch["images"][0]]["format"], "R8G8B8_SRGB")


class Whole(Scene):
    def test_equal_images_are_stored_once(self):
        patch = {"image": {"file": "rgb.png", "crop": [0, 0, 32, 32]}, "offset": [0, 0], "scale": [0.5, 0.5]}
        other = dict(patch, offset=[0.5, 0.5])
        different = dict(patch, ramp=2)
        found = self.make(self.zipmap(patch, other, different))
        self.assertEqual([p["images"] for p in found["textures"][0]["patches"]], [[0], [1], [1], [2]])
        self.assertEqual(len(found["images"]), 3)

    def test_material(self):
        layers = {"base_colour": "rgb.png", "normal": "rgb.png", "roughness": "grey.png"}
        turned = {"roughness": "grey.png", "normal": "rgb.png", "base_colour": "rgb.png"}
        found = self.make({"textures": [{"name": "m", "wrap": ["repeat", "clamp"], "patches": [
            {"layers": layers}, {"layers": turned, "offset": [0.2, 0.2], "scale": [0.5, 0.5]}]}]})
        texture = found["textures"][0]
        self.assertEqual([layer[0] for layer in texture["layers"]], [1, 2, 4])
        self.assertEqual(texture["wrap"], [0, 2, 2])
        formats = [found["images"][i]["format"] for i in texture["patches"][1]["images"]]
        self.assertEqual(formats, ["R8G8B8A8_SRGB", "R8G8B8_UNORM", "R8_UNORM"])

    def test_patches_of_textures(self):
        found = self.make({"textures": [{"name": "sign", "image": "rgba.png"}, self.zipmap(
            {"texture": "sign", "offset": [0.5, 0.5], "scale": [0.25, 0.25]},
            {"texture": "sign", "mask": "grey.png", "offset": [0.1, 0.5], "scale": [0.25, 0.25]})["textures"][0]]})
        patches = found["textures"][1]["patches"]
        self.assertEqual([patch["texture"] for patch in patches], [-1, 0, 0])
        self.assertEqual(patches[1]["mask"], -1)
        self.assertNotEqual(patches[2]["mask"], -1)

    def test_options_go_down(self):
        found = self.make({"defaults": {"levels": 3, "tile_edge": 64}, "textures": [
            {"name": "a", "image": "rgb.png"},
            {"name": "b", "defaults": {"levels": 2}, "image": {"file": "rgb.png", "tile_edge": 32}}]}, "--levels", "5")
        self.assertEqual([(i["levels"], i["tile_edge"]) for i in found["images"]], [(3, 64), (2, 32)])

    def test_metadata(self):
        found = self.make({"metadata": {"zt.title": "T", "zt.license": "CC0-1.0"}, "textures": [{"image": "rgb.png"}]},
                          "--license", "MIT")
        self.assertEqual(found["metadata"], {"zt.title": "T", "zt.license": "MIT"})

    def test_frames(self):
        found = self.make({"textures": [{"image": {"files": ["rgb.png", "rgb.png"], "as": "frames"}}]})
        self.assertEqual((found["images"][0]["layers"], found["images"][0]["layer_kind"]), (2, 2))

    def test_folders_and_streams(self):
        os.mkdir("sub")
        os.rename("rgb.png", "sub/rgb.png")
        with open("sub/s.json", "w") as file:
            json.dump({"textures": [{"image": "rgb.png"}]}, file)
        self.ztex("make", "sub/s.json", "-o", "a.ztex")
        scene = json.dumps({"textures": [{"image": "sub/rgb.png"}]}).encode()
        out, _ = self.ztex("make", "-", "-o", "-", data=scene)
        with open("a.ztex", "rb") as file:
            self.assertEqual(out, file.read())


class Mistakes(Scene):
    def test_json(self):
        self.wrong('{"textures": [', "line 1")
        self.wrong('{"textures": [], "textures": []}', "duplicate")
        self.wrong("[]", "an object is wanted")
        self.wrong("{}", "'textures' is missing")

    def test_pointers(self):
        place = {"offset": [0, 0], "scale": [1, 1]}
        self.wrong({"textures": [{"image": "rgb.png", "nam": "x"}]}, "/textures/0: ", "'nam'", "did you mean 'name'")
        self.wrong({"textures": [{"image": {"file": "rgb.png", "levels": 99}}]}, "/textures/0/image/levels", "1 to 32")
        self.wrong({"textures": [{"image": {"file": "rgb.png", "format": "RGB"}}]}, "/textures/0/image/format", "RGB")
        self.wrong({"textures": [{"image": {"file": "rgb.png", "crop": [0, 0, 9]}}]}, "/textures/0/image/crop")
        self.wrong({"textures": [{"image": 5}]}, "/textures/0/image", "not a number")
        self.wrong({"textures": [{"layers": {"colr": "rgb.png"}}]}, "/textures/0/layers/colr", "semantic")
        self.wrong({"textures": [{"image": "rgb.png", "kind": "zipmap"}]}, "/textures/0/kind", "patches")
        self.wrong(self.zipmap({"image": "rgb.png"}), "/textures/0/patches/1", "where the patch lies")
        self.wrong(self.zipmap({"image": "rgb.png", "matrix": [1] * 9, **place}), "both 'offset' and 'matrix'")
        self.wrong(self.zipmap({"image": "rgb.png", "offset": [0, 0]}), "needs 'scale'")
        self.wrong(self.zipmap({"image": "rgb.png", "offset": [0, 0], "scale": [0, 1]}), "/textures/0/patches/1", "empty")
        self.wrong(self.zipmap({"image": "rgb.png", "corners": [[0, 0], [1, 1], [1, 0], [0, 1]]}), "convex")
        self.wrong(self.zipmap({"image": "rgb.png", "parent": 1, **place}), "/textures/0/patches/1/parent", "0 to 0")
        self.wrong(self.zipmap({"image": "rgb.png", "parent": "x", **place}), "/textures/0/patches/1/parent", "'x'")
        self.wrong(self.zipmap({"texture": "x", **place}), "/textures/0/patches/1/texture", "'x'")
        self.wrong(self.zipmap({"image": "rgb.png", "ramp": 0, **place}), "/textures/0/patches/1/ramp")
        self.wrong(self.zipmap({"image": "rgb.png", "matrix": [0] * 9}), "/textures/0")
        self.wrong(self.zipmap({"layers": {"normal": "rgb.png"}, **place}), "base_colour", "missing")
        self.wrong({"textures": [{"patches": [{"image": "rgb.png", **place}]}]}, "/textures/0/patches/0", "root")

    def test_pictures(self):
        place = {"offset": [0, 0], "scale": [1, 1]}
        self.wrong(self.zipmap({"image": "no.png", **place}), "/textures/0/patches/1/image", "no.png", status=IO)
        self.wrong(self.zipmap({"image": "rgb.png", "mask": "no.png", **place}), "/textures/0/patches/1/mask", "no.png",
                   status=IO)
        self.wrong({"textures": [{"image": {"file": "rgb.png", "crop": [60, 0, 10, 10]}}]}, "64 x 48", status=IO)

    def test_command_line(self):
        with open("scene.json", "w") as file:
            json.dump({"textures": [{"image": "rgb.png"}]}, file)
        _, errors = self.ztex("make", "scene.json", "--wrap", "clamp", "-o", "x.ztex", status=USAGE)
        self.assertIn("--wrap", errors)


class Documents(Scene):
    def test_originals_stay(self):
        before = open("root.png", "rb").read()
        mask = {"image": "rgb.png", "mask": "grey.png", "offset": [0, 0], "scale": [0.5, 0.5]}
        for picture in ("root.png", "rgb.png", "grey.png"):
            with open("scene.json", "w") as file:
                json.dump(self.zipmap(mask), file)
            _, errors = self.ztex("make", "scene.json", "-o", picture, status=USAGE)
            self.assertIn("is an input as well", errors)
        self.assertEqual(open("root.png", "rb").read(), before)

    def test_schema_knows_what_the_reader_knows(self):
        with open(os.path.join(HERE, "..", "scene.schema.json")) as file:
            schema = json.load(file)
        members = set()

        def walk(value):
            if isinstance(value, dict):
                members.update(value.get("properties", {}))
                for item in value.values():
                    walk(item)
            elif isinstance(value, list):
                for item in value:
                    walk(item)

        walk(schema)
        known = set()
        for name in ("scene.c", "scene_image.c", "scene_silmap.c", "scene_umbrellas.c", "scene_bases.c"):
            with open(os.path.join(HERE, "..", name)) as file:
                text = file.read()
            for block in re.findall(r"\*const (?:known|option_keys|ways)\[\] = \{(.*?)\};", text, re.S):
                known.update(re.findall(r'"([^"]+)"', block))
        self.assertEqual(members, known)


support.main()
