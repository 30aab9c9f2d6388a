# SPDX-License-Identifier: Apache-2.0
"""What the tests of inspect, validate, recover and diff share: the conformance corpus, and the JSON schemas."""
import json
import os

import jsonschema

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", "..", ".."))


def folder(kind):
    return os.path.join(ROOT, "conformance", kind)


def manifest(kind):
    with open(os.path.join(folder(kind), "manifest.json"), encoding="utf-8") as file:
        return json.load(file)


def paths(kind):
    return [os.path.join(folder(kind), entry["file"]) for entry in manifest(kind)]


def validator(name):
    with open(os.path.join(ROOT, "spec", f"{name}.schema.json"), encoding="utf-8") as file:
        schema = json.load(file)
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def objects(text):
    """The JSON objects that follow each other in a text."""
    decoder, at, found = json.JSONDecoder(), 0, []
    text = text.decode() if isinstance(text, bytes) else text
    while at < len(text.rstrip()):
        value, at = decoder.raw_decode(text, at)
        found.append(value)
        while at < len(text) and text[at].isspace():
            at += 1
    return found
