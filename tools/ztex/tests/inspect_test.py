# SPDX-License-Identifier: Apache-2.0
"""inspect shows every file of the corpus, broken ones too: scripts that read its JSON must never meet anything else."""
import os
import subprocess

import corpus
import support


class Inspect(support.Case):
    def inspect(self, *words):
        return subprocess.run([support.ZTEX, "inspect", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              check=False, timeout=600)

    def test_valid_files_pass_the_schema(self):
        schema = corpus.validator("inspect")
        run = self.inspect("--json", "--tiles", *corpus.paths("valid"))
        self.assertEqual(run.returncode, 0, run.stderr[:500])
        found = corpus.objects(run.stdout)
        self.assertEqual(len(found), len(corpus.paths("valid")))
        for entry, one in zip(corpus.manifest("valid"), found):
            schema.validate(one)
            self.assertTrue(one["valid"], entry["file"])
            self.assertEqual(len(one["textures"]), entry["textures"])
            self.assertEqual(len(one["images"]), entry["images"])

    def test_invalid_files_pass_the_schema(self):
        schema = corpus.validator("inspect")
        run = self.inspect("--json", *corpus.paths("invalid"))
        found = corpus.objects(run.stdout)
        self.assertEqual(len(found), len(corpus.paths("invalid")))
        for entry, one in zip(corpus.manifest("invalid"), found):
            schema.validate(one)
            if not one["valid"] and one["error"]["rule"]:
                rules = [entry["rule"], *entry.get("also", [])]
                self.assertIn(f"R{one['error']['rule']}", rules, entry["file"])

    def test_damaged_file_still_shows_its_chunks(self):
        path = os.path.join(corpus.folder("invalid"), "R4003_texs_byte.ztex")
        one = corpus.objects(self.ztex("inspect", "--json", path, status=support.INVALID)[0])[0]
        self.assertEqual([c["type"] for c in one["found_chunks"]], ["TEXS", "IMAG", "TEXL"])
        self.assertEqual([c["intact"] for c in one["found_chunks"]], [False, True, True])
        text = self.ztex("inspect", path, status=support.INVALID)[0].decode()
        self.assertIn("DAMAGED", text)
        self.assertIn("4003", text)

    def test_textconv_says_nothing_of_the_place(self):
        path = os.path.join(corpus.folder("valid"), "zip_mask.ztex")
        with open("other_name.ztex", "wb") as file, open(path, "rb") as source:
            file.write(source.read())
        one = self.ztex("inspect", "--textconv", "--tiles", path)[0]
        self.assertEqual(one, self.ztex("inspect", "--textconv", "--tiles", "other_name.ztex")[0])
        broken = os.path.join(corpus.folder("invalid"), "R2009_hash.ztex")
        self.ztex("inspect", "--textconv", broken)

    def test_texts_cannot_steer_a_terminal(self):
        run = self.inspect("--tree", "--patches", *corpus.paths("valid"))
        self.assertEqual(run.returncode, 0)
        for byte in run.stdout:
            self.assertFalse(byte < 0x20 and byte != 0x0A or byte == 0x7F)

    def test_patches_have_places(self):
        path = os.path.join(corpus.folder("valid"), "zip_homography.ztex")
        one = corpus.objects(self.ztex("inspect", "--json", path)[0])[0]
        root, patch = one["textures"][0]["patches"]
        self.assertEqual(root["box"], [0, 0, 1, 1])
        self.assertIsNone(patch["offset"])
        m = patch["root_matrix"]
        for corner, (x, y) in zip(patch["corners"], [(0, 0), (1, 0), (1, 1), (0, 1)]):
            u, v = corner
            w = m[6] * u + m[7] * v + m[8]
            self.assertAlmostEqual((m[0] * u + m[1] * v + m[2]) / w, x)
            self.assertAlmostEqual((m[3] * u + m[4] * v + m[5]) / w, y)

    def test_standard_input(self):
        with open(corpus.paths("valid")[0], "rb") as file:
            self.assertIn(b"standard input", self.ztex("inspect", "-", data=file.read())[0])


if __name__ == "__main__":
    support.main()
