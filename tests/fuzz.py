"""Mutants of machine files: the readers accept them or raise `InputError`, and what is accepted survives writing.

python -m tests.fuzz --count 20000              mutants of both formats, the same in every run
python -m tests.fuzz --count 1 --first 17 --show   mutant number 17, printed
"""

from __future__ import annotations

import argparse
import random
import re
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

from symoro_elastic.formats import FORMATS, read_machine
from symoro_elastic.formats.reading import format_of
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.models.catalogue import MODELS
from symoro_elastic.models.packaging import reserved_words
from tests.machine.samples import COUPLED, PAR, PAR_LOOP, TOML

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
WORDS = """
0 -1 1e400 -1e308 1e-320 nan inf 1_000 0x10 007 1e5 99999999999999999999 1/0 pi/2 tan(pi/2) sqrt(-1) q1 q1+q2 M1 L__1
int lambda __import__('os') exec(1) a.b 10^10^10 -- ** ( ) (( [ ] [[ ]] { } {{ }} = , ; : . " ' \'\'\' \\ # (* *) (*!
^ / * true false null fixed motor elastic passive rotation quaternion sigma theta alpha ant joints parameters name scene
NL NJ NF coupled cut loops meets closes dependent start variable ratio sharing order mu q2 qm q1+2*q2 pin 2 (*toml
"""
SIGNS = ("", " ", "\n", "\r", "\t", "\x00", "\x1b[2J", "\ufeff", "\u0661", "é", "\u2028", "\U0001f600", "a" * 2000)
ODD = (*WORDS.split(), *SIGNS)
TOKEN = re.compile(r"[A-Za-z0-9_.]+|[^\sA-Za-z0-9]")


class Mutant(NamedTuple):
    """The content of a damaged machine file, and the suffix of its format."""

    content: bytes
    suffix: str


@cache
def sources() -> tuple[tuple[str, str], ...]:
    """Text and suffix of the machine files that are damaged."""
    paths = sorted(path for path in EXAMPLES.iterdir() if path.suffix in (".toml", ".par"))
    return (
        (TOML, ".toml"),
        (COUPLED, ".toml"),
        (PAR, ".par"),
        (PAR_LOOP, ".par"),
        *((path.read_text(encoding="utf-8"), path.suffix) for path in paths),
    )


def mutant(seed: int) -> Mutant:
    """A mutant; the same for the same number."""
    rng = random.Random(seed)
    text, suffix = rng.choice(sources())
    for _ in range(rng.choice((1, 1, 1, 2, 3, 8))):
        text = rng.choice(DAMAGE)(text, rng)
    content = text.encode("utf-8", "surrogatepass")
    if rng.random() < 0.1:
        content = bytearray(content)
        for _ in range(rng.randint(1, 5)):
            if content:
                content[rng.randrange(len(content))] = rng.randrange(256)
    return Mutant(bytes(content), suffix)


def _replace_token(text: str, rng: random.Random) -> str:
    found = list(TOKEN.finditer(text))
    if not found:
        return text
    token = rng.choice(found)
    other = rng.choice(ODD) if rng.random() < 0.6 else rng.choice(found)[0]
    return text[: token.start()] + other + text[token.end() :]


def _change_lines(text: str, rng: random.Random) -> str:
    lines = text.split("\n")
    first, second = rng.randrange(len(lines)), rng.randrange(len(lines))
    way = rng.randrange(4)
    if way == 0:
        del lines[first]
    elif way == 1:
        lines.insert(first, lines[second])
    elif way == 2:
        lines[first], lines[second] = lines[second], lines[first]
    else:
        lines[first] += lines[second]
    return "\n".join(lines)


def _cut(text: str, rng: random.Random) -> str:
    start = rng.randrange(len(text) + 1)
    end = min(len(text), start + rng.choice((1, 2, 10, 100, len(text))))
    return text[:start] + rng.choice(("", text[start:end] * 2)) + text[end:]


def _insert(text: str, rng: random.Random) -> str:
    place = rng.randrange(len(text) + 1)
    return text[:place] + rng.choice(ODD) * rng.choice((1, 1, 2, 60)) + text[place:]


def _splice(text: str, rng: random.Random) -> str:
    other, _ = rng.choice(sources())
    return text[: rng.randrange(len(text) + 1)] + other[rng.randrange(len(other)) :]


DAMAGE: tuple[Callable[[str, random.Random], str], ...] = (
    *(_replace_token,) * 4,
    *(_change_lines,) * 2,
    *(_cut, _insert, _splice),
)


def outcome(asked: Mutant, folder: Path) -> str:
    """Read a mutant, write it in every format and read that: "accepted", or "refused"; other errors are raised."""
    path = folder / f"arm{asked.suffix}"
    path.write_bytes(asked.content)
    try:
        machine, _ = read_machine(path, reserved_words(), MODELS)
    except InputError as error:
        assert str(error).startswith(f"{path}: ") and "\n" not in str(error) and len(str(error)) < 800, error
        return "refused"
    for form in FORMATS:
        if form.write is None:
            continue
        try:
            text = form.write(machine)
        except InputError:
            assert form is not format_of(path, FORMATS)
            continue
        again = form.read(text, str(path))
        check(again, reserved_words(), MODELS)
        if form is format_of(path, FORMATS):
            assert again == replace(machine, source=again.source)
    return "accepted"


def main() -> int:
    """Try mutants; print how many were accepted and refused, and every failure with its number."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz")
    parser.add_argument("--count", type=int, default=20_000, help="mutants to try")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--show", action="store_true", help="print the mutants")
    asked = parser.parse_args()
    found, slowest, begin = Counter[str](), (0.0, 0), time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        for number in range(asked.first, asked.first + asked.count):
            if asked.show:
                print(mutant(number).content.decode("utf-8", "replace"))
            start = time.perf_counter()
            try:
                found[outcome(mutant(number), Path(folder))] += 1
            except Exception:
                found["failed"] += 1
                print(f"mutant {number}:\n{traceback.format_exc(limit=-3)}")
            slowest = max(slowest, (time.perf_counter() - start, number))
    print(", ".join(f"{count} {word}" for word, count in sorted(found.items())), end="; ")
    print(f"{time.perf_counter() - begin:.0f} s, the slowest {slowest[0]:.2f} s (mutant {slowest[1]})")
    return 1 if found["failed"] else 0


if __name__ == "__main__":
    sys.exit(main())
