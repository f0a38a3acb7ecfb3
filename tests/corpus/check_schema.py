#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the corpora and the shipped protocols through the schemas.

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


def check(name, good, bad, at_least_bad):
    schema = json.loads((ROOT / f"schema/{name}.schema.json").read_text(encoding="utf-8"))
    jsonschema.validators.validator_for(schema).check_schema(schema)
    validator = jsonschema.validators.validator_for(schema)(schema)
    wrong = []
    for path in good:
        error = jsonschema.exceptions.best_match(validator.iter_errors(load(path)))
        if error:
            wrong.append(f"{path}: refused: {error.json_path}: {error.message[:200]}")
    wrong += [f"{p}: accepted, expected a refusal" for p in bad if validator.is_valid(load(p))]
    if len(good) < 3 or len(bad) < at_least_bad:
        wrong.append(f"{name}: only {len(good)} good and {len(bad)} bad files: incomplete?")
    print(f"{name}: {len(good)} to accept, {len(bad)} to refuse, {len(wrong)} wrong")
    return wrong


def main():
    corpus = ROOT / "tests/corpus"
    wrong = check("protocol",
                  sorted(corpus.glob("protocol/accept/*.json"))
                  + sorted(ROOT.glob("protocols/library/*.json")),
                  sorted(corpus.glob("protocol/reject/*.json")), 40)
    wrong += check("config", sorted(corpus.glob("config/accept/*.json")),
                   sorted(corpus.glob("config/reject/*.json")), 12)
    wrong += check("faults", sorted(corpus.glob("faults/accept/*.json")),
                   sorted(corpus.glob("faults/reject/*.json")), 12)
    wrong += check("batch", sorted(corpus.glob("batch/accept/*.json")),
                   sorted(corpus.glob("batch/reject/*.json")), 12)
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
