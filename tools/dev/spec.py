# SPDX-License-Identifier: Apache-2.0
"""The rules in the margins of spec/: a mark such as [R2001] at the start of a paragraph or list item."""

import re
from dataclasses import dataclass


@dataclass
class Rule:
    id: str
    line: int
    section: str  # the heading, with its number
    text: str

    def number(self):
        return self.section.split(' ')[0].rstrip('.')


def rules(document):
    found = []
    section, current, before, fence = '', None, '', False
    for number, line in enumerate(document.split('\n'), 1):
        fence ^= line.startswith('```')
        item = re.match(r'\s*(?:[-*|>]|\d+\.)\s+', line)
        mark = re.match(r'\s*(?:(?:[-*|>]|\d+\.)\s+)?\[R(\d{4})\]\s*(.*)', line)
        if not line.strip() or item or fence:
            current = None
        if re.match(r'#+ ', line) and not fence:
            section = line.lstrip('# ')
        elif mark and not fence and (item or not before.strip()):
            current = Rule(mark.group(1), number, section, mark.group(2).strip())
            found.append(current)
        elif current:
            current.text += ' ' + line.strip()
        before = line
    return found
