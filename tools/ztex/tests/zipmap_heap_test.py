# SPDX-License-Identifier: Apache-2.0
"""Property: a heap of photographs whose truth is known becomes the zipmap that it is: every picture in its parent and where it belongs, what
does not belong is named with its reason, and the same bytes come from any number of threads and from the scene that was written. It matters
because nobody checks by hand what a program says about a hundred photographs."""
import json
import os
import re
import shutil
import sys

import jsonschema
import numpy
import skimage.data
from PIL import Image

import support
from support import IO, USAGE

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.append(os.path.join(HERE, "../../bench"))
import heap  # noqa: E402  (the generator of the benchmark)

PHOTOS = [heap.MATE + name for name in ("abstract/Elephants_3840x2160.jpg", "nature/Garden.jpg", "nature/Dune.jpg", "nature/GreenMeadow.jpg",
                                        "nature/RainDrops.jpg")]
WIDTH = 600


class Heaps(support.Case):
    """The heap is made once, and each test gets a copy."""

    @classmethod
    def setUpClass(cls):
        cls.made = support.tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.made.cleanup)
        cls.truth = heap.make_heap("4x", 2, cls.made.name, 5, WIDTH, PHOTOS)
        cls.pictures = {picture["file"]: picture for picture in cls.truth["pictures"]}

    def setUp(self):
        super().setUp()
        for name in self.pictures:
            shutil.copy(os.path.join(self.made.name, name), name)

    def names(self, *roles):
        return sorted(name for name, picture in self.pictures.items() if picture["role"] in roles)

    def read(self, path):
        with open(path, "rb") as file:
            return file.read()


class Result(Heaps):
    def test_graph_and_places(self):
        _, errors = self.ztex("make", "zipmap", *sorted(self.pictures), "-o", "out.ztex", "--report", "out.report.json")
        with open("out.report.json") as file:
            report = json.load(file)
        with open(os.path.join(HERE, "../zipmap_report.schema.json")) as file:
            jsonschema.validate(report, json.load(file), cls=jsonschema.Draft202012Validator)
        photos = {photo["file"]: photo for photo in report["photographs"]}
        for name, picture in self.pictures.items():
            photo = photos[name]
            self.assertEqual(photo["state"], {"root": "root", "child": "placed", "distractor": "unplaced"}[picture["role"]], name)
            if picture["role"] == "child":
                self.assertEqual(report["photographs"][photo["parent"]]["file"], picture["parent"], name)
                self.assertLess(heap.corner_error(picture["matrix"], photo["matrix"], picture["size"]), 1.0, name)
            if picture["role"] == "distractor":
                self.assertIn(f"{name} is left out: {photo['text']}", errors)
        self.assertEqual(len(report["seams"]), len(self.names("child")))
        for seam in report["seams"]:
            self.assertLess(seam["after"]["median"], max(2.0, seam["before"]["median"]))
        found = self.probe("out.ztex")
        self.assertEqual(len(found["textures"]), 1)
        self.assertEqual(len(found["textures"][0]["patches"]), len(self.names("root", "child")))

    def test_same_bytes(self):
        pictures = self.names("root", "child")
        self.ztex("make", "zipmap", *pictures, "-o", "one.ztex", "--threads", "1", "--scene-out", "scene.json")
        os.mkdir("elsewhere")
        self.ztex("make", "zipmap", *pictures, "-o", "two.ztex", "--threads", "2", "--scene-out", "elsewhere/scene.json")
        self.ztex("make", "scene.json", "-o", "again.ztex")
        self.ztex("make", "elsewhere/scene.json", "-o", "moved.ztex")
        # Each compared with the two that look most alike, which is where it belongs.
        self.ztex("make", "zipmap", *pictures, "-o", "chosen.ztex", "--candidates", "2")
        for name in ("two", "again", "moved", "chosen"):
            self.assertEqual(self.read("one.ztex"), self.read(f"{name}.ztex"), name)

    def test_page_needs_nothing_beside_it(self):
        pictures = self.names("root", "child")[:3] + self.names("distractor")
        self.ztex("make", "zipmap", *pictures, "-o", "out.ztex", "--report", "out.html", "--max-size", "200")
        page = self.read("out.html").decode()
        for name in pictures:
            self.assertIn(name, page)
        sources = re.findall(r'(?:src|href)="([^"]{0,30})', page)
        self.assertTrue(sources)
        for source in sources:
            self.assertTrue(source.startswith("data:image/jpeg;base64,"), source)
        self.trace_free("out.ztex", "out.html", *self.pictures)

    def test_layers_follow(self):
        pictures = self.names("root", "child")[:3]
        os.mkdir("rough")
        for name in pictures:
            stem = os.path.splitext(name)[0]
            with Image.open(name) as picture:
                size = picture.size
            Image.new("RGB", (size[0] // 2, size[1] // 2), (128, 128, 255)).save(f"{stem}_normal.png")
            Image.new("L", size, 77).save(f"rough/{stem}.tif")
        self.ztex("make", "zipmap", *pictures, "-o", "out.ztex", "--layer", "normal=%_normal.png", "--layer", "roughness=rough")
        texture = self.probe("out.ztex")["textures"][0]
        self.assertEqual(len(texture["layers"]), 3)
        for patch in range(len(texture["patches"])):  # each in its layer; upright normals stay upright however a photograph lies
            for layer, value in (("normal", (128, 128, 255)), ("roughness", 77)):
                self.ztex("extract", "out.ztex", "--patch", str(patch), "--layer", layer, "-o", "layer.png")
                with Image.open("layer.png") as picture:
                    self.assertLessEqual(abs(numpy.asarray(picture).astype(int) - value).max(), 1)
        os.remove(f"{os.path.splitext(pictures[0])[0]}_normal.png")
        _, errors = self.ztex("make", "zipmap", *pictures, "-o", "no.ztex", "--layer", "normal=%_normal.png", status=IO)
        self.assertIn("_normal.png", errors)
        _, errors = self.ztex("make", "zipmap", *pictures, "-o", "no.ztex", "--layer", "normal=n.png", status=USAGE)
        self.assertIn("SEMANTIC=PATTERN", errors)


class Errors(Heaps):
    def wrong(self, pictures, *texts, status=USAGE, words=()):
        before = sorted(os.listdir("."))
        _, errors = self.ztex("make", "zipmap", *pictures, "-o", "never.ztex", "--scene-out", "never.json", *words, status=status)
        for text in texts:
            self.assertIn(text, errors)
        self.trace_free(*before)

    def test_nothing_overlaps(self):
        self.wrong(self.names("root", "distractor"), "no two", *self.names("root", "distractor"))

    def test_one_picture(self):
        self.wrong(self.names("root"), "one photograph")

    def test_unreadable(self):
        with open("broken.jpg", "wb") as file:
            file.write(self.read(self.names("root")[0])[:300])
        self.wrong([*self.names("root"), "broken.jpg"], "broken.jpg", status=IO)
        self.wrong([*self.names("root"), "missing.jpg"], "missing.jpg", status=IO)

    def test_too_few_matches(self):
        Image.new("RGB", (400, 300), (120, 130, 140)).save("flat.png")
        pictures = self.names("root", "child")
        _, errors = self.ztex("make", "zipmap", *pictures, "flat.png", "-o", "out.ztex", "--report", "r.json")
        self.assertIn("flat.png is left out", errors)
        with open("r.json") as file:
            photos = json.load(file)["photographs"]
        self.assertEqual([photo["reason"] for photo in photos if photo["state"] == "unplaced"], ["too few matches"])

    def test_several_things(self):
        astronaut = Image.open(os.path.join(os.path.dirname(skimage.data.__file__), "astronaut.png")).convert("RGB")
        astronaut.resize((260, 260), Image.Resampling.BOX).save("far.png")
        astronaut.crop((120, 20, 380, 280)).save("near.png")
        others = ["far.png", "near.png"]
        pictures = self.names("root", "child")
        self.wrong([*pictures, *others], "group 1: ", "group 2: ", "--allow-many", pictures[0])
        self.ztex("make", "zipmap", *pictures, *others, "-o", "both.ztex", "--allow-many")
        self.assertEqual(len(self.probe("both.ztex")["textures"]), 2)

    def test_outputs_are_not_inputs(self):
        pictures = self.names("root", "child")
        for words in (["-o", pictures[0]], ["-o", "a.ztex", "--report", pictures[0]], ["-o", "a.ztex", "--scene-out", "a.ztex"]):
            self.ztex("make", "zipmap", *pictures, *words, status=USAGE)


support.main()
