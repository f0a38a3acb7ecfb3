#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the protocol corpus and the shipped library through schema/protocol.schema.json.

reject/ holds what the schema and the parser both refuse; reject_semantic/ what only the parser can
see, so the schema must accept it (or it is no JSON at all).
"""
import json
import pathlib
import re
import sys

import jsonschema

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOKEN = re.compile(r'"(?:\\.|[^"\\])*"|//[^\n]*')


def load(path):
    text = path.read_text(encoding="utf-8")
    return json.loads(TOKEN.sub(lambda m: m[0] if m[0][0] == '"' else "", text))


def main():
    schema = json.loads((ROOT / "schema/protocol.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    corpus = ROOT / "tests/corpus/protocol"
    good = sorted(corpus.glob("accept/*.json")) + sorted(ROOT.glob("protocols/library/*.json"))
    bad = sorted(corpus.glob("reject/*.json"))
    wrong = []
    for path in good:
        error = jsonschema.exceptions.best_match(validator.iter_errors(load(path)))
        if error:
            wrong.append(f"{path}: refused: {error.json_path}: {error.message[:200]}")
    wrong += [f"{p}: accepted, expected a refusal" for p in bad if validator.is_valid(load(p))]
    if len(good) < 10 or len(bad) < 40:
        wrong.append(f"only {len(good)} good and {len(bad)} bad files: is the corpus complete?")
    print("\n".join(wrong) or f"schema: {len(good)} accepted, {len(bad)} refused")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
