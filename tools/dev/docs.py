#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Renders the man pages and the rule catalogue: docs.py OUTPUT_FOLDER.

A warning of the man page formatter is an error. The catalogue is made from the margins of spec/ and
from conformance/invalid/manifest.json, so it says nothing that the specification does not say.
"""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import spec

ROOT = Path(__file__).resolve().parents[2]


def man_pages(output):
    """Renders each page as text; returns how many there are and what the formatter complains of."""
    pages = sorted(path for folder in ('tools', 'share') for path in (ROOT / folder).rglob('*.[1-7]'))
    complaints = []
    for page in pages:
        run = subprocess.run(
            ['man', '--warnings', '-Tutf8', '-l', page], capture_output=True, text=True, check=False,
            env={**os.environ, 'MANWIDTH': '80', 'LC_ALL': 'C.UTF-8'})
        complaints += [f'{page.relative_to(ROOT)}: {line}' for line in run.stderr.splitlines()]
        target = output / 'man' / f'{page.name}.txt'
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(re.sub('.\x08', '', run.stdout))  # no overstriking
    return len(pages), complaints


def examples():
    """Rule id -> files in conformance/invalid that break it."""
    manifest = ROOT / 'conformance/invalid/manifest.json'
    found = {}
    if manifest.exists():
        for entry in json.loads(manifest.read_text()):
            found.setdefault(str(entry['rule']).lstrip('R'), []).append(entry['file'])
    return found


def catalogue(output):
    files = examples()
    rows = []
    for document in sorted((ROOT / 'spec').glob('*.md')):
        for rule in spec.rules(document.read_text()):
            rows.append((rule.id, document.name, rule.section, rule.text))
    lines = ['# Rules of the .ztex format', '',
             'Made from the margins of spec/. A number is never used again for another rule.', '']
    for rule, document, section, text in sorted(rows):
        lines += [f'## R{rule}', '', text, '', f'{document}, section {section}.']
        if rule in files:
            lines += ['', 'Broken by: ' + ', '.join(f'`{name}`' for name in sorted(files[rule]))]
        lines.append('')
    (output / 'rules.md').write_text('\n'.join(lines))
    return len(rows)


def main():
    output = Path(sys.argv[1])
    output.mkdir(parents=True, exist_ok=True)
    pages, complaints = man_pages(output)
    rules = catalogue(output)
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    print(f'{pages} man pages, {rules} rules: {output}')
    return 1 if complaints else 0


if __name__ == '__main__':
    sys.exit(main())
