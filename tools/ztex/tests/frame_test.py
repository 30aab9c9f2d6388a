# SPDX-License-Identifier: Apache-2.0
"""Property: one table rules the command line. Help, man pages and completions know every verb and option, and a wrong word is refused with
a message that says what was meant and with the documented exit code. It matters because people learn the command from these texts."""
import os
import shutil
import subprocess
import unittest

import support
from support import INVALID, IO, OK, USAGE, ZTEX

VERBS = os.environ.get("ZTEX_VERBS", "make make-zipmap inspect validate extract render convert diff recover help").split()
WORDS = [verb.split("-") for verb in VERBS]


class Help(support.Case):
    def test_overview(self):
        out, _ = self.ztex("help")
        self.assertEqual(out, self.ztex("--help")[0])
        for words in WORDS:
            self.assertIn(f"\n  {' '.join(words)} ", out.decode())

    def test_every_verb_teaches(self):
        for words in WORDS:
            out = self.ztex(*words, "--help")[0].decode()
            self.assertEqual(out, self.ztex("help", *words)[0].decode())
            for part in ("Usage: ztex " + " ".join(words) + " ", "Options:", "Examples:", "Exit codes:"):
                self.assertIn(part, out)
            self.assertLessEqual(max(len(line) for line in out.splitlines() if "ztex" not in line), 100)

    def test_nothing_is_usage(self):
        out, errors = self.ztex(status=USAGE)
        self.assertEqual(out, b"")
        self.assertIn("Verbs:", errors)

    def test_verb_by_program_name(self):
        os.symlink(ZTEX, "ztex-make")
        run = subprocess.run(["./ztex-make", "--help"], stdout=subprocess.PIPE, check=True)
        self.assertEqual(run.stdout, self.ztex("make", "--help")[0])

    def test_two_words(self):
        help_text = self.ztex("make", "zipmap", "--help")[0]
        os.symlink(ZTEX, "ztex-make-zipmap")
        os.symlink(ZTEX, "ztex-make")
        for words in (["./ztex-make-zipmap", "--help"], ["./ztex-make", "zipmap", "--help"]):
            self.assertEqual(subprocess.run(words, stdout=subprocess.PIPE, check=True).stdout, help_text)
        self.assertIn(b"ztex make zipmap", self.ztex("make", "--help")[0])
        _, errors = self.ztex("help", "make", "teapot", status=USAGE)
        self.assertIn("make teapot", errors)

    def test_a_picture_named_like_a_second_word(self):
        support.save("zipmap.png", support.ramps())
        os.rename("zipmap.png", "zipmap")
        for words in (["./zipmap", "-o", "a.ztex"], ["-o", "a.ztex", "zipmap"]):
            self.ztex("make", *words)
            self.assertEqual(self.probe("a.ztex")["textures"][0]["kind"], 0, words)

    def test_version(self):
        for words in (["--version"], ["make", "--version"]):
            self.assertRegex(self.ztex(*words)[0].decode(), r"^ztex \d+\.\d+\.\d+ \(libzt \d+\.\d+\.\d+\)\n$")

    def test_formats(self):
        self.assertIn(b"R8G8B8A8_SRGB", self.ztex("help", "formats")[0])


class Man(support.Case):
    def test_pages_are_clean(self):
        for words in [[]] + WORDS:
            page = self.ztex("help", "--man", *words)[0]
            self.assertTrue(page.startswith(b".TH "))
            if not shutil.which("groff"):
                continue
            run = subprocess.run(["groff", "-man", "-ww", "-Tascii"], input=page, stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE)
            self.assertEqual(run.stderr.decode(), "", words)
            self.assertIn(b"EXIT STATUS", run.stdout.replace(b"\x08", b"").replace(b"EEXXIITT SSTTAATTUUSS", b"EXIT STATUS"))


class Completion(support.Case):
    def complete(self, line):
        """What bash offers behind this line."""
        script = self.ztex("help", "--completion", "bash")[0].decode()
        words = line.split(" ")
        listing = " ".join(f"'{word}'" for word in words)
        program = f"{script}\nCOMP_WORDS=({listing})\nCOMP_CWORD={len(words) - 1}\n_ztex\nprintf '%s\\n' \"${{COMPREPLY[@]}}\"\n"
        run = subprocess.run(["bash", "--norc", "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(run.stderr.decode(), "")
        return run.stdout.decode().split()

    def test_bash(self):
        open("a.ztex", "w").close()
        open("b.png", "w").close()
        os.mkdir("sub")
        seconds = [words[1] for words in WORDS if len(words) > 1]
        self.assertEqual(self.complete("ztex ma"), ["make"])
        self.assertEqual({words[0] for words in WORDS} - set(self.complete("ztex ")), set())
        self.assertEqual(self.complete("ztex make --mip"), ["--mip-filter"])
        self.assertEqual(self.complete("ztex make --wrap "), ["repeat", "mirror", "clamp", "border"])
        self.assertEqual(self.complete("ztex make -w mi"), ["mirror"])
        self.assertEqual(self.complete("ztex make --wrap = cl"), ["clamp"])
        self.assertEqual(self.complete("ztex make --format R8G8B8A8_S"), ["R8G8B8A8_SRGB"])
        self.assertEqual(sorted(self.complete("ztex make ")), sorted(["a.ztex", "b.png", "sub", *seconds]))
        self.assertEqual(self.complete("ztex make zi"), ["zipmap"])
        self.assertEqual(self.complete("ztex-make zi"), ["zipmap"])
        self.assertEqual(sorted(self.complete("ztex make b.png ")), ["a.ztex", "b.png", "sub"])
        self.assertEqual(self.complete("ztex make zipmap --colo"), ["--colour"])
        self.assertEqual(self.complete("ztex make zipmap --colour no"), ["none"])
        self.assertEqual(self.complete("ztex-make-zipmap --colo"), ["--colour"])
        self.assertEqual(self.complete("ztex help make zi"), ["zipmap"])
        self.assertEqual(sorted(self.complete("ztex make zipmap ")), ["a.ztex", "b.png", "sub"])
        self.assertEqual(sorted(self.complete("ztex make -o ")), ["a.ztex", "sub"])
        self.assertEqual(self.complete("ztex-make --wra"), ["--wrap"])
        self.assertEqual(self.complete("/usr/bin/ztex-make --wra"), ["--wrap"])
        self.assertEqual(self.complete("ztex help mak"), ["make"])
        self.assertIn("a.ztex", self.complete("ztex inspect "))

    def test_bash_loads(self):
        script = self.ztex("help", "--completion", "bash")[0]
        run = subprocess.run(["bash", "--norc", "-c", script.decode() + "\ncomplete -p ztex ztex-make"],
                             stdout=subprocess.PIPE, check=True)
        self.assertIn(b"-F _ztex ztex-make", run.stdout)

    def test_other_shells_parse(self):
        for shell in ("zsh", "fish"):
            with open(shell, "wb") as file:
                file.write(self.ztex("help", "--completion", shell)[0])
            if shutil.which(shell):
                run = subprocess.run([shell, "-n", shell], stderr=subprocess.PIPE)
                self.assertEqual((run.returncode, run.stderr), (0, b""), shell)

    @unittest.skipUnless(shutil.which("fish"), "no fish")
    def test_fish_completes(self):
        script = self.ztex("help", "--completion", "fish")[0].decode()
        run = subprocess.run(["fish", "--no-config", "-c", script + "\ncomplete -C'ztex make --wrap mi'"], stdout=subprocess.PIPE)
        self.assertIn(b"mirror", run.stdout)
        for line, word in (("ztex make zi", b"zipmap"), ("ztex make zipmap --colour no", b"none")):
            run = subprocess.run(["fish", "--no-config", "-c", f"{script}\ncomplete -C'{line}'"], stdout=subprocess.PIPE)
            self.assertIn(word, run.stdout)


class Parsing(support.Case):
    def wrong(self, words, *texts, status=USAGE):
        out, errors = self.ztex(*words, status=status)
        self.assertEqual(out, b"")
        for text in texts:
            self.assertIn(text, errors)

    def test_wrong_words(self):
        self.wrong(["mkae"], "no verb 'mkae'", "'make'")
        self.wrong(["--quiet"], "the verb comes first")
        self.wrong(["make", "--warp", "clamp", "a"], "no option --warp", "--wrap", "--help")
        self.wrong(["make", "-Z", "a"], "no option -Z")
        self.wrong(["make", "a", "--wrap", "mirrow"], "mirror")
        self.wrong(["make", "a", "--wrap"], "--wrap wants MODE")
        self.wrong(["make", "a", "--raw=yes"], "takes no value")
        self.wrong(["make", "a", "--levels", "0"], "1 to 32")
        self.wrong(["make", "a", "--effort", "10"], "1 to 9")
        self.wrong(["make", "a", "--memory", "12Q"], "512M")
        self.wrong(["make", "a", "--format", "R8G8B8A8_SRBG"], "R8G8B8A8_SRGB")
        self.wrong(["make", "a", "-o", "b", "-o", "c"], "given twice")
        self.wrong(["make", "a"], "-o FILE is missing")
        self.wrong(["make", "-o", "a"], "a file is missing")
        self.wrong(["make", "-o", "a", "b", "--meta", "x"], "KEY=VALUE")
        self.wrong(["make", "-o", "a", "b", "--tile-edge", "100"], "power of two")
        self.wrong(["make", "-o", "a", "b", "--layer", "norml=x"], "SEMANTIC=FILE")
        self.wrong(["make", "-o", "a", "b", "--transfer", "rec709x"], "rec709x")
        self.wrong(["make", "a", "b", "-o", "c"], "--array")
        self.trace_free()

    def test_ways_to_write_options(self):
        support.save("p.png", support.ramps())
        self.ztex("make", "p.png", "-o", "1.ztex", "--wrap", "clamp", "--name", "x")
        for i, words in enumerate([["--wrap=clamp", "p.png", "--name=x", "--output=F"], ["-w", "clamp", "-nx", "-oF", "p.png"],
                                   ["-qvwclamp", "-n=x", "-o", "F", "--", "p.png"]]):
            self.ztex("make", *[word.replace("F", f"way{i}.ztex") for word in words])
            with open("1.ztex", "rb") as first, open(f"way{i}.ztex", "rb") as second:
                self.assertEqual(first.read(), second.read())

    def test_dashes_end_options(self):
        support.save("-p.png", support.ramps())
        self.ztex("make", "-o", "1.ztex", "--", "-p.png")

    def test_messages_are_safe(self):
        _, errors = self.ztex("make", "no\x1b[31m\u202e\u009b\nfile", "-o", "x", status=IO)
        self.assertEqual(errors.count("\n"), 1)
        for bad in "\x1b\u202e\u009b":
            self.assertNotIn(bad, errors)
        self.assertIn("\\x1b[31m", errors)

    def test_closed_output(self):
        with open("/dev/full", "wb") as full:
            run = subprocess.run([ZTEX, "help"], stdout=full, stderr=subprocess.PIPE)
        self.assertEqual(run.returncode, IO)


support.main()
