# SPDX-License-Identifier: Apache-2.0
"""Property: a scene with umbrellas becomes a valid file whose bytes depend on scene and seed alone; each coarser level shows what the finest one shows on the
average, wherever its pixels lie; bases come from alpha, colour, drawings, lists and textures; and what is wrong in a scene is named, with its place. It matters because an umbrella texture is
made of chance: nobody could tell a mistake from it by looking, and nobody could repeat it."""
import json
import os

import numpy
from PIL import Image, ImageDraw

import jsonschema
import support
from support import USAGE

HERE = os.path.dirname(os.path.abspath(__file__))
EXAMPLES = os.path.join(HERE, "../../dev/umbrellas")
GOAL_DB = 30

LEAF_SVG = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 60"><path d="M4 30 C30 2 70 2 96 30 C70 58 30 58 4 30 Z" fill="#7a9a2c"/>
<path d="M4 30 L96 30" stroke="#d8d890" stroke-width="3"/></svg>"""
DIAMOND = [[0.1, 0.5], [0.5, 0.1], [0.9, 0.5], [0.5, 0.9]]
HORSESHOE = [[0.1, 0.1], [0.3, 0.1], [0.3, 0.7], [0.7, 0.7], [0.7, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9]]


def disc(name, colour, ground=None, size=64):
    """A disc on nothing, or on a plain ground."""
    picture = Image.new("RGBA" if ground is None else "RGB", (size, size), ground or (0, 0, 0, 0))
    ImageDraw.Draw(picture).ellipse((6, 10, size - 8, size - 6), fill=colour)
    ImageDraw.Draw(picture).line((10, size // 2, size - 12, size // 2), fill=(240, 240, 200), width=3)
    picture.save(name)


def base(**members):
    return {"image": "disc.png", "size": [0.8, 1.6], **members}


def scene(*bases, **members):
    return {"textures": [{"name": "heap", "umbrellas": {
        "grid": [6, 4], "background": "#404040", "bases": list(bases) or [base()],
        "arrangement": {"density": 2.5}, **members}}]}


class Umbrellas(support.Case):
    def setUp(self):
        super().setUp()
        disc("disc.png", (160, 90, 40, 255))
        disc("keyed.png", (30, 60, 190), ground=(230, 230, 225))
        with open("leaf.svg", "w", encoding="utf-8") as file:
            file.write(LEAF_SVG)

    def make(self, content, *words, output="u.ztex", status=support.OK):
        with open("scene.json", "w", encoding="utf-8") as file:
            json.dump(content, file)
        return self.ztex("make", "umbrellas", "scene.json", "-o", output, "--no-fsync", *words, status=status)

    def refuse(self, content, *texts):
        errors = self.make(content, status=USAGE)[1]
        for text in texts:
            self.assertIn(text, errors)
        self.assertFalse(os.path.exists("u.ztex"))

    def schema(self, name):
        with open(os.path.join(HERE, "..", name), encoding="utf-8") as file:
            found = json.load(file)
        jsonschema.Draft202012Validator.check_schema(found)
        return jsonschema.Draft202012Validator(found)

    def read(self, path="u.ztex"):
        with open(path, "rb") as file:
            return file.read()

    def test_everything_at_once(self):
        variants = [{"tint": "#a03020"}, {"offset": [0.1, -0.1, 0], "rim": [0, 0.1, 0], "spread": 0.1}, {"image": "keyed.png"}]
        content = scene(
            base(name="disc", morph={"amount": 0.2}, variants=variants[:2], mirrored=0.5, ellipsoid="convex", height=[0.1, 0.5],
                 curvature=[0.2, 1], lift=[0, 0.1]),
            base(name="keyed", image="keyed.png", key=True, vertices=12, centre="centroid", ellipsoid="concave", variants=variants[2:]),
            base(name="leaf", image="leaf.svg", texels=64, rotation=[-20, 20], strength=0.5),
            base(name="hand", outline=DIAMOND, morph={"outline": [[0.2, 0.5], [0.5, 0.2], [0.8, 0.5], [0.5, 0.8]]}, centre=[0.5, 0.5]),
            base(name="drawn", outline="leaf.svg", vertices=10),
            base(name="shown", image=None, texture="ground", outline=DIAMOND),
            background={"texture": "ground"}, colour_mode="inverse_distance", taper=[0.02, 0.1], prism_height=2)
        del content["textures"][0]["umbrellas"]["bases"][5]["image"]
        content["textures"].insert(0, {"name": "ground", "image": "keyed.png"})
        self.schema("scene.schema.json").validate(content)
        report = json.loads(self.make(content, "--json", "--report", "r.html")[0])
        self.schema("umbrellas_report.schema.json").validate(report)
        self.ztex("validate", "u.ztex")
        self.assertEqual((report["cells"], report["bases"], len(report["levels"])), ([6, 4], 6, 2))
        self.assertEqual(report["bytes"], os.path.getsize("u.ztex"))
        with open("r.html", encoding="utf-8") as file:
            self.assertEqual(file.read().count("<img"), 4)

    def test_same_bytes(self):
        content = scene(base(morph={"amount": 0.1}, variants=[{"tint": "#208040", "spread": 0.1}]), seed=5)
        self.make(content, "--threads", "1")
        first = self.read()
        for words in (["--threads", "2"], ["--threads", "4"], ["--seed", "5"]):
            self.make(content, *words)
            self.assertEqual(self.read(), first, words)
        self.make(content, "--seed", "6")
        self.assertNotEqual(self.read(), first)
        self.ztex("make", "scene.json", "-o", "u.ztex")
        self.assertEqual(self.read(), first, "ztex make of the same scene")

    def test_arrangements(self):
        for arrangement in ({"method": "poisson", "density": 1, "order": "size"}, {"method": "jittered", "jitter": 0.5},
                            {"method": "tiling", "columns": 3, "rows": 2, "row_shift": 0.5},
                            {"method": "places", "places": [{"base": "one", "at": [1.5, 2], "size": 2, "rotation": 90, "mirrored": True},
                                                            {"base": 0, "at": [4, 2], "variant": 0, "morph": 0, "lift": 0.1}]},
                            {"method": "places", "places": []}):
            for members in ({}, {"form": "explicit", "vertex_jitter": 0.1, "colour_jitter": 0.1}, {"background": "none"}):
                content = scene(base(name="one", variants=[{"tint": "#808020"}]), arrangement=arrangement, **members)
                self.schema("scene.schema.json").validate(content)
                for wrap in ("repeat", "clamp"):
                    content["textures"][0]["wrap"] = wrap
                    self.make(content)
                    self.ztex("validate", "u.ztex")

    def test_placed(self):
        """One element in a given place: its colour there, the background elsewhere."""
        Image.new("RGB", (16, 16), (200, 30, 30)).save("red.png")
        content = scene(base(image="red.png", outline=DIAMOND, centre=[0.5, 0.5], size=2), background="#0000ff",
                        arrangement={"method": "places", "places": [{"base": 0, "at": [1, 1], "rotation": 0}]})
        self.make(content)
        self.ztex("render", "u.ztex", "-o", "r.png", "--size", "96x64")
        with Image.open("r.png") as picture:
            pixels = numpy.asarray(picture).astype(int)
        red = (abs(pixels - (200, 30, 30)).max(-1) < 3)
        self.assertTrue((red | (abs(pixels - (0, 0, 255)).max(-1) < 3)).mean() > 0.95)
        y, x = numpy.nonzero(red)
        # A diamond of 2 x 2 cells has an area of 2; a cell has 16 x 16 pixels.
        self.assertTrue(abs(x.mean() + 0.5 - 16) < 0.5 and abs(y.mean() + 0.5 - 16) < 0.5)
        self.assertTrue(abs(red.sum() / 256 - 2) < 0.15)

    def test_levels_of_the_examples(self):
        for name, grid in (("leaves", [8, 8]), ("pebbles", [6, 6]), ("flowers", [8, 8]), ("photographs", [6, 4])):
            with open(os.path.join(EXAMPLES, name + ".json"), encoding="utf-8") as file:
                content = json.load(file)
            self.schema("scene.schema.json").validate(content)
            content["textures"][0]["umbrellas"]["grid"] = grid
            text = json.dumps(content)
            for drawing in os.listdir(EXAMPLES):
                text = text.replace(f'"{drawing}"', json.dumps(os.path.join(EXAMPLES, drawing)))
            report = json.loads(self.make(json.loads(text), "--json")[0])
            self.ztex("validate", "u.ztex")
            self.assertTrue(report["levels"], name)
            for level in report["levels"]:
                self.assertGreaterEqual(level["psnr"], GOAL_DB, (name, level))
                self.assertGreaterEqual(level["between_psnr"], GOAL_DB, (name, level))
                self.assertGreaterEqual(level["between_psnr"], level["mipmap_psnr"], (name, level))
            if name == "leaves":
                self.check_phases(8, report["levels"][0])

    def check_phases(self, cells, level):
        """The figures of level 1 once more, out of pictures: of a grid of pixels, and of those shifted by an eighth to a half of a pixel."""
        pixels = 8 * cells // 2

        def light(view, size, *words):
            self.ztex("render", "u.ztex", "-o", "r.png", "--view", view, "--size", f"{size}x{size}", *words)
            with Image.open("r.png") as picture:
                coded = numpy.asarray(picture.convert("RGB")) / 255
            return numpy.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)

        def coded(value):
            return numpy.where(value <= 0.0031308, value * 12.92, 1.055 * value ** (1 / 2.4) - 0.055)

        fine = light("0,0,1,1", 8 * pixels, "--supersample", "4")
        for off in (0, 0.125, 0.25, 0.5):
            by = off / pixels
            moved = numpy.roll(fine, [-round(8 * off)] * 2, (0, 1))
            wanted = moved.reshape(pixels, 8, pixels, 8, 3).mean((1, 3))
            shown = light(f"{by},{by},{1 + by},{1 + by}", pixels)
            found = -10 * numpy.log10(((coded(shown) - coded(wanted)) ** 2).mean())
            self.assertGreaterEqual(found, GOAL_DB, (off, level))
            self.assertLess(abs(found - level["psnr"]), 1, (off, level))

    def test_longest_list(self):
        report = json.loads(self.make(scene(levels={"longest": 12, "vertices": 6, "quality": 90}), "--json")[0])
        for level in report["levels"]:
            self.assertLessEqual(level["longest_list"], 12)
        report = json.loads(self.make(scene(levels={"count": 1}), "--json")[0])
        self.assertEqual(report["levels"], [])

    def test_errors(self):
        place = "/textures/0/umbrellas"
        self.refuse(scene(base(outline=HORSESHOE)), f"{place}/bases/0", "disc.png: the outline is not star-shaped: vertex ",
                    "is not seen from the centre")
        self.refuse(scene(base(sizes=1)), f"{place}/bases/0", "no member 'sizes': did you mean 'size'?")
        self.refuse(scene(base(size=[2, 1])), f"{place}/bases/0/size", "the lesser number first")
        self.refuse(scene(base(image="keyed.png", key="#1e3cbe", tolerance=0.9, threshold=1)), "nothing to cut out")
        self.refuse(scene(base(morph={"outline": DIAMOND})), "'outline' is missing")
        self.refuse(scene(base(outline=DIAMOND, morph={"outline": DIAMOND[:3]})), "the morph has 3 vertices and the outline 4")
        self.refuse(scene(base(height=1)), "go with 'ellipsoid'")
        self.refuse(scene(base(texture="x")), "either 'image' or 'texture'")
        self.refuse(scene(background={"texture": "x"}), f"{place}/background/texture", "no earlier texture is named 'x'")
        self.refuse(scene(background="red"), "no colour such as #8a5a2b")
        self.refuse(scene(arrangement={"method": "places", "places": [{"base": "x", "at": [0, 0]}]}),
                    f"{place}/arrangement/places/0/base", "no base is named 'x'")
        self.refuse(scene(base(size=9)), "larger than the texture, which repeats")
        self.refuse(scene(grid=[0, 4]), f"{place}/grid", "no cells are too few")
        self.refuse(scene(vertex_jitter=0.1), '"form": "explicit"')
        self.refuse(scene(arrangement={"density": 10000}, grid=[8192, 8192]), "umbrellas are too many")
        self.refuse({"textures": [{"image": "disc.png"}]}, "0 textures have 'umbrellas'")
        content = scene()
        content["textures"][0]["wrap"] = "mirror"
        self.refuse(content, "not mirrored")
        content["textures"][0].update(wrap="repeat", image="disc.png")
        self.refuse(content, "'umbrellas' says what the texture is made of")
        self.make(scene(), output="disc.png", status=USAGE)
        self.trace_free("disc.png", "keyed.png", "leaf.svg", "scene.json")


if __name__ == "__main__":
    support.main()
