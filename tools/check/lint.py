# SPDX-License-Identifier: Apache-2.0
"""What the text lints share: the tree, C++ text without comments, brace blocks, self-tests."""

import argparse
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CODE_FOLDERS = ["base", "events", "plot", "storage", "model", "drivers", "protocols", "daemon", "analysis",
                "budget", "tools", "tests", "bench"]
PRODUCTION = [f for f in CODE_FOLDERS if f not in ("tests", "bench")]


def files(suffixes, folders=tuple(CODE_FOLDERS)):
    """Source files as paths relative to the root, sorted."""
    found = []
    for folder in folders:
        found += [p.relative_to(ROOT) for p in (ROOT / folder).rglob("*") if p.suffix in suffixes]
    return sorted(found)


def read(path):
    return (ROOT / path).read_text(encoding="utf-8")


_TOKEN = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"([^(\s\\]{0,16})\(.*?\)\1"|"(?:\\.|[^"\\\n])*"'
    r"|(?<![0-9a-zA-Z_])'(?:\\.|[^'\\\n])+'", re.S)


def bare(text):
    """C++ text with comments, strings and preprocessor lines blanked; line numbers are kept."""

    def blank(match):
        token = match.group(0)
        keep = '""' if token[0] in '"R' else "''" if token[0] == "'" else ""
        return keep + re.sub(r"[^\n]", " ", token)[len(keep):]

    text = _TOKEN.sub(blank, text)
    return re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*",
                  lambda m: re.sub(r"[^\n]", " ", m.group(0)), text, flags=re.M)


def line_of(text, position):
    return text.count("\n", 0, position) + 1


_QUALIFIERS = r"(?:\s*(?:const|noexcept|mutable|override|final|&&?|->\s*[\w:<>,\s&*\[\]]+))*\s*$"
_SCOPE = re.compile(r"\b(?:namespace|struct|class|union|enum|extern)\b[^;=]*$")
_INITIALISERS = re.compile(r"\)\s*(?:noexcept\s*)?:\s*[\w:<>]+\s*[({].*$", re.S)


def block_kind(head):
    """What the `{` after `head` (the text since the last ; { or }) opens:
    scope (namespace, class), function, code (statement block, lambda body) or braces (a value)."""
    head = head.strip()
    in_initialisers = _INITIALISERS.search(head)
    if in_initialisers and not head.endswith((")", "}")):
        return "braces"  # a member's initial value
    if re.search(r"\)" + _QUALIFIERS, head) or in_initialisers:
        word = re.match(r"(?:\}?\s*else\s+)?(if|for|while|switch|catch)\b", head)
        in_value = re.search(r"\[[^\]]*\]\s*\([^()]*\)" + _QUALIFIERS, head)
        return "code" if word or in_value else "function"
    if re.search(r"\]" + _QUALIFIERS, head) and not re.search(r"\w\s*\[[^\]]*\]$", head):
        return "code"  # a lambda without parameters
    if _SCOPE.search(head) and not re.search(r"[()]", re.sub(r"\balignas\(.*?\)", "", head)):
        return "scope"
    if re.search(r"(?:\belse|\bdo|\btry|^|[^:]:)$", head):
        return "code"
    return "braces"


def blocks(text):
    """All brace pairs of bare text as (open, close, kind, start of the head, parents' kinds)."""
    found, stack = [], []
    head_start = 0
    parens = 0
    for i, c in enumerate(text):
        if c in "()":
            parens += 1 if c == "(" else -1
        elif c == "{":
            kind = block_kind(text[head_start:i])
            stack.append((i, kind, head_start, parens))
            parens = 0
            if kind != "braces":
                head_start = i + 1
        elif c == "}" and stack:
            start, kind, head, parens = stack.pop()
            found.append((start, i, kind, head, [s[1] for s in stack]))
            if kind != "braces":
                # A lambda's body ends inside its statement: the head goes on.
                head_start = head if parens > 0 else i + 1
        elif c == ";" and parens == 0:
            head_start = i + 1
    return found


def main(description, check, self_test):
    """Runs the lint over the tree, or its self-test. `check` returns a list of messages."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--self-test", action="store_true", help="flag bad samples, pass good ones")
    if parser.parse_args().self_test:
        self_test()
        print(f"{Path(sys.argv[0]).name}: self-test ok")
        return
    found = check()
    for message in found:
        print(message)
    if found:
        sys.exit(f"{Path(sys.argv[0]).name}: {len(found)} found")


def expect(condition, what):
    """For self-tests: survives `python -O`, unlike assert."""
    if not condition:
        sys.exit(f"{Path(sys.argv[0]).name}: self-test FAILED: {what}")
