#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The programs in the headers' opening comments compile and do what they say.

A program in a comment that nobody compiles is wrong after the first change of the interface. This one is taken from zt.h as it
stands, compiled as the reader would, and run on the specification's own example. The lines in zt_write.h are put into a
function, write a file, and that file is opened by the first program.

usage: opening_program.py LIBRARY LINK_FLAG...
"""

import os
import re
import subprocess
import sys
import tempfile

INCLUDE = "libzt/include"


def program(header):
    """The indented lines of the opening comment, without the comment's stars."""
    with open(os.path.join(INCLUDE, "zt", header), encoding="utf-8") as file:
        comment = re.search(r"/\*\n(.*?)\n \*/", file.read(), re.S).group(1)
    lines = [line[3:] for line in comment.split("\n") if line.startswith(" *     ") or line == " *"]
    return "\n".join(lines).strip("\n") + "\n"


def build(folder, name, source, link):
    path = os.path.join(folder, name + ".c")
    with open(path, "w", encoding="utf-8") as file:
        file.write(source)
    output = os.path.join(folder, name)
    compiler = os.environ.get("CC", "cc")
    subprocess.run([compiler, "-std=c11", "-Wall", "-Wextra", "-Werror", "-I", INCLUDE, path, "-o", output, *link], check=True)
    return output


def main():
    link = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        reader = build(folder, "reader", program("zt.h"), link)
        out = subprocess.run([reader, "conformance/valid/first.ztex"], check=True, capture_output=True, text=True).stdout
        assert out.startswith("3 x 2 texels, 1 levels\nin the middle "), out
        bad = subprocess.run([reader, "README.md"], capture_output=True, text=True)
        assert bad.returncode == 1 and "not a .ztex file" in bad.stderr, bad

        writer = build(folder, "writer", "#include <zt/zt_write.h>\nint main(void)\n{\n"
                       "uint32_t w = 2, h = 2; unsigned char pixels[16] = {255}; zt_diag diag;\n"
                       + program("zt_write.h") + "return diag.result;\n}\n", link)
        subprocess.run([writer], check=True, cwd=folder)
        out = subprocess.run([reader, os.path.join(folder, "brick.ztex")], check=True, capture_output=True, text=True).stdout
        assert out.startswith("2 x 2 texels, 2 levels\n"), out
    return 0


if __name__ == "__main__":
    sys.exit(main())
