# SPDX-License-Identifier: Apache-2.0
"""Property: zipmaps can be animated. Layers of their images are frames; a patch has as many frames as the root or one that stays; masks
may have frames too; each frame is rendered as a still zipmap of its pictures would be. It matters because it is the only way in which time
enters a zipmap, and a frame that shows another one's patch would look plausible."""
import json
import os

import numpy
from PIL import Image

import support
from support import USAGE, ramps, save

FRAMES = 3


class Animation(support.Case):
    def setUp(self):
        super().setUp()
        noise = numpy.random.default_rng(3)
        for i in range(FRAMES):
            save(f"root_{i:02d}.png", numpy.roll(ramps(64, 48), 16 * i, 1))
            save(f"patch_{i + 1}.png", noise.integers(0, 256, (32, 32, 3), numpy.uint8))
            save(f"mask_{i}.png", noise.integers(0, 2, (32, 32, 1), numpy.uint8) * 255)
            save(f"grey_{i}.png", noise.integers(0, 256, (32, 32, 1), numpy.uint8))
        save("still.png", noise.integers(0, 256, (16, 16, 3), numpy.uint8))

    @staticmethod
    def frames(pattern):
        return {"file": pattern, "as": "frames"}

    def patches(self):
        """The root, a patch with frames and a mask with frames, one that stays, and one whose frames are listed."""
        place = {"offset": [0.1, 0.1], "scale": [0.4, 0.5]}
        return [{"image": self.frames("root_%02d.png")},
                {"image": self.frames("patch_%d.png"), "mask": self.frames("mask_%d.png"), **place},
                {"image": "still.png", "offset": [0.5, 0.2], "scale": [0.25, 0.25]},
                {"image": {"files": [f"patch_{i + 1}.png" for i in range(FRAMES)], "as": "frames"}, "mask": "mask_0.png",
                 "separate_mask": True, "offset": [0.3, 0.4], "scale": [0.5, 0.5]}]

    def still(self, patches, frame):
        """The same with the pictures of one frame."""
        def of(image):
            if not isinstance(image, dict):
                return image
            if "files" in image:
                return image["files"][frame]
            name = image["file"] % frame
            return name if os.path.exists(image["file"] % 0) else image["file"] % (frame + 1)
        return [{key: of(value) if key in ("image", "mask") else value for key, value in patch.items()} for patch in patches]

    def make(self, patches, name, *words, status=support.OK):
        with open("scene.json", "w") as file:
            json.dump({"textures": [{"name": "z", "wrap": "clamp", "patches": patches}]}, file)
        return self.ztex("make", "scene.json", "-o", name, *words, status=status)[1]

    def rendered(self, name, *words):
        self.ztex("render", name, "-o", "r.png", *words)
        return numpy.asarray(Image.open("r.png")).astype(int)

    def test_frames(self):
        self.make(self.patches(), "z.ztex")
        found = self.probe("z.ztex")
        self.assertEqual([i["layers"] for i in found["images"]], [3, 3, 1, 3, 3])
        seen = []
        for frame in range(FRAMES):
            self.make(self.still(self.patches(), frame), "one.ztex")
            for words in (["--size", "96"], ["--view", "0.2,0.2,0.6,0.6", "--size", "80"], ["--size", "20"]):
                moving = self.rendered("z.ztex", "--frame", str(frame), *words)
                self.assertTrue((moving == self.rendered("one.ztex", *words)).all(), f"frame {frame} {words}")
            seen.append(moving.tobytes())
        self.assertEqual(len(set(seen)), FRAMES)
        self.ztex("validate", "z.ztex")

    def test_play(self):
        """Pictures of a film: the next frame in each, round again, along a path or in one view."""
        self.make(self.patches(), "z.ztex")
        path = "0,0,1,1;0.3,0.3,0.5,0.5"
        self.ztex("render", "z.ztex", "-o", "film%d.png", "--play", "--frame", "1", "--frames", "5", "--zoom-path", path, "--size", "40")
        for i in range(5):
            self.ztex("render", "z.ztex", "-o", "path%d.png", "--frame", str((1 + i) % FRAMES), "--frames", "5", "--zoom-path", path,
                      "--size", "40")
            with open(f"film{i + 1}.png", "rb") as a, open(f"path{i + 1}.png", "rb") as b:
                self.assertEqual(a.read(), b.read(), i)
        self.ztex("render", "z.ztex", "-o", "s%d.png", "--play", "--frames", "4", "--view", "0,0,1,0.5", "--size", "40")
        for i in range(4):
            one = self.rendered("z.ztex", "--frame", str(i % FRAMES), "--view", "0,0,1,0.5", "--size", "40")
            self.assertTrue((numpy.asarray(Image.open(f"s{i + 1}.png")) == one).all())

    def test_all_and_back(self):
        """What is taken out makes the same file again."""
        self.make(self.patches(), "z.ztex")
        self.ztex("extract", "z.ztex", "--all", "out")
        self.ztex("make", "out/scene.json", "-o", "again.ztex")
        for frame in range(FRAMES):
            words = ("--frame", str(frame), "--size", "96")
            self.assertTrue((self.rendered("z.ztex", *words) == self.rendered("again.ztex", *words)).all())
        self.ztex("extract", "z.ztex", "--patch", "1", "--array-layer", "2", "-o", "e.png")
        self.assertTrue((numpy.asarray(Image.open("e.png"))[1:-1, 1:-1, :3] == numpy.asarray(Image.open("patch_3.png"))[1:-1, 1:-1]).all())

    def test_wrong(self):
        patches = self.patches()
        root, child = patches[0], patches[1]
        two = {"files": ["patch_1.png", "patch_2.png"], "as": "frames"}
        for wrong, place, text in ((dict(child, image=two, mask="none"), "1/image", "2 frames"),
                                   (dict(child, mask=two), "1/mask", "2 frames"),
                                   (dict(child, image=self.frames("no_%d.png")), "1/image", "number 0 or 1"),
                                   (dict(child, mask="auto"), "1/image", "frames"),
                                   (dict(child, colour="poisson", mask="none"), "0/image", "frames"),
                                   (dict(child, image="still.png", prune=True, mask=self.frames("mask_%d.png")), "1/mask", "mask"),
                                   (dict(child, mask={"file": "mask_0.png", "as": "volume"}), "1/mask", "mask")):
            errors = self.make([root, wrong], "never.ztex", status=USAGE)
            self.assertIn(f"/textures/0/patches/{place}: ", errors)
            self.assertIn(text, errors)
        errors = self.make([{"image": "still.png"}, child], "never.ztex", status=USAGE)
        self.assertIn("the root has 1", errors)
        self.make(patches, "z.ztex")
        for words in (["--frame", "3"], ["--play", "--view", "0,0,1,1", "--view", "0,0,1,1"]):
            self.ztex("render", "z.ztex", "-o", "r%d.png", *words, status=USAGE)


if __name__ == "__main__":
    support.main()
