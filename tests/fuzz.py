"""Damaged files for every reader: it accepts them or raises `InputError`, within a second of the processor.

python -m tests.fuzz --count 20000                 mutants for all readers, the same in every run
python -m tests.fuzz --reader scene --count 500    ... for one
python -m tests.fuzz --reader toml --count 1 --first 17 --show   one mutant, printed
python -m tests.fuzz --reader toml --guided 300    led by the branches that are reached, for 300 s (needs atheris)

What is accepted of a machine survives writing.
"""

from __future__ import annotations

import argparse
import io
import json
import os
import random
import re
import sys
import tempfile
import time
import traceback
import types
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from symoro_elastic.analysis.sweeps.running import TITLE, open_journal
from symoro_elastic.analysis.time_series.measurements import read_measurements
from symoro_elastic.analysis.time_series.reading import read_arrays
from symoro_elastic.api.declaration import read_options
from symoro_elastic.api.options import Sweeping
from symoro_elastic.api.sweeps import plan
from symoro_elastic.formats import FORMATS, read_machine
from symoro_elastic.formats.reading import format_of
from symoro_elastic.formats.toml.motions import read_motions, read_wanted
from symoro_elastic.formats.toml.reading import read_scene
from symoro_elastic.foundation.errors import LONGEST_MESSAGE, InputError, printable
from symoro_elastic.foundation.output_files import MANIFEST, write_files
from symoro_elastic.machine.checks import check
from symoro_elastic.measured.vibration_tests.reading import read_tests
from symoro_elastic.models.packaging import reserved_words
from symoro_elastic.models.programs.catalogue import MODELS
from tests.examples import EXAMPLES, example
from tests.formats.robots.mjcf_samples import ROBOTS
from tests.formats.robots.samples import ARM, GRIPPER
from tests.machine.samples import BY_AXIS, COUPLED, PAR, PAR_LOOP, TOML

WORDS = """
0 -1 1e400 -1e308 1e-320 nan inf 1_000 0x10 007 1e5 99999999999999999999 1/0 pi/2 tan(pi/2) sqrt(-1) q1 q1+q2 M1 L__1
int lambda __import__('os') exec(1) a.b 10^10^10 -- ** ( ) (( [ ] [[ ]] { } {{ }} = , ; : . " ' \'\'\' \\ # (* *) (*!
^ / * true false null fixed motor elastic passive rotation quaternion sigma theta alpha ant joints parameters name scene
NL NJ NF coupled cut loops meets closes dependent start variable ratio sharing order mu q2 qm q1+2*q2 pin 2 (*toml
1e999999999 1e-999999999mm 2^64^64 0xffffffffffffffffffffffff 1:1:0 LOW:HIGH:COUNT all none hann < > </ <a/> &amp; &#0;
<!DOCTYPE ../../etc/passwd /dev/zero con :: @ deg mm N/m N*m [deg] [ ] dB g f t re im mag phase
tool.az/tool.fz -1 58 164
"""
SIGNS = ("", " ", "\n", "\r", "\t", "\x00", "\x1b[2J", "\ufeff", "\u0661", "é", "\u2028", "\U0001f600", "a" * 2000)
ODD = (*WORDS.split(), *SIGNS)
REPEATED = (
    *(
        "1",
        "1_",
        ".",
        "a.",
        "1.",
        "(",
        "()",
        "[",
        "[1,",
        "{",
        "{a=",
        "-",
        "+-",
        "1+",
        "1/",
        "1^",
        "sin(",
        "a",
        "a ",
        " ",
    ),
    *(
        "\t",
        "\n",
        "\r\n",
        '"',
        "'",
        "\\",
        '\\"',
        "#",
        "#\n",
        "(*",
        "(**)",
        "=",
        "a=1\n",
        ",",
        ";",
        "/",
        "<a>",
        "<a/>",
        "&lt;",
    ),
    *("%", "é", "m/", "m*", "[m]", "a [m] ", "f", "9", "[[a]]\n", "q1+", ":", "1:+Z/", "\u2028"),
)
"""What a value is made of that is long, and that a reader may look at again and again."""
TOKEN = re.compile(r"[A-Za-z0-9_.]+|[^\sA-Za-z0-9]")
LONGEST = 1.0
"""Time of the processor for a file of 100 kB, s."""


class Reader(NamedTuple):
    """A reader of files with one suffix: contents that it takes, and what it does with a file."""

    suffix: str
    sources: Callable[[], tuple[bytes, ...]]
    read: Callable[[Path], object]


class Mutant(NamedTuple):
    """The content of a damaged file, and the reader that gets it."""

    content: bytes
    reader: str


# Readers


def survives(path: Path) -> None:
    """Read a machine, write it in every format and read that."""
    machine, _ = read_machine(path, reserved_words(), MODELS)
    for form in FORMATS:
        if form.write is None:
            continue
        try:
            text = form.write(machine)
        except InputError:
            assert form is not format_of(path, FORMATS)
            continue
        again = form.read(text, str(path))
        if form.describe is None:
            check(again, reserved_words(), MODELS)
        if form is format_of(path, FORMATS) and form.describe is None:
            assert again == replace(machine, source=again.source)


def _scene(path: Path) -> None:
    machine = example("planar_2r.toml")
    read_scene(path, machine, MODELS)
    read_motions(path, machine)
    read_wanted(path)


def _sweep(path: Path) -> None:
    plan(example("two_axis.toml"), replace(Sweeping(), **read_options(path, Sweeping)))


def _journal(path: Path) -> None:
    with open_journal(path, "digest", 3):
        pass


def _manifest(path: Path) -> None:
    folder = path.parent / "generated"
    folder.mkdir(exist_ok=True)
    path.rename(folder / MANIFEST)
    write_files(folder, {"a.c": "text"})


def _tests(path: Path) -> None:
    for file in (EXAMPLES / "two_axis_tests").glob("*.csv"):
        (path.parent / file.name).write_bytes(file.read_bytes())
    read_tests(path, example("two_axis.toml"))


def _measured(path: Path) -> None:
    """A measurement of the list of vibration tests."""
    named = 'rename = { "12:+Z/3:+Z" = "tool.az/tool.fz" }\n' if path.suffix == ".uff" else ""
    text = f'[[tests]]\nfile = "{path.name}"\nhold = ["all"]\n{named}'
    (path.parent / "tests.toml").write_text(text, encoding="utf-8")
    read_tests(path.parent / "tests.toml", example("lathe.toml"))


def of_files(*patterns: str) -> Callable[[], tuple[bytes, ...]]:
    """Return what gives the contents of examples."""
    return lambda: tuple(path.read_bytes() for pattern in patterns for path in sorted(EXAMPLES.glob(pattern)))


def _texts(*texts: str) -> Callable[[], tuple[bytes, ...]]:
    return lambda: tuple(text.encode() for text in texts)


def _log() -> str:
    names = ("shoulder", "elbow")
    head = ",".join(["t [s]", *(f"q_{name} [deg]" for name in names), *(f"tau_{name}" for name in names)])
    return "\n".join([head, *(f"{k / 100},{k / 7:.3f},{-k / 9:.3f},1.{k},-2.{k}" for k in range(60))]) + "\n"


def _arrays() -> tuple[bytes, ...]:
    made = []
    for save in (np.savez, np.savez_compressed):
        stream, t = io.BytesIO(), np.arange(30.0)
        save(stream, t=t, q=np.stack([t, -t], axis=1), n=np.arange(3))
        made.append(stream.getvalue())
    return tuple(made)


def _universal() -> tuple[bytes, ...]:
    pyuff = __import__("pyuff")
    f, made = 10.0 + 2.5 * np.arange(12), []
    for binary in (0, 1):
        with tempfile.TemporaryDirectory() as folder:
            row = {"type": 58, "func_type": 4, "rsp_node": 12, "rsp_dir": 3, "ref_node": 3, "ref_dir": 3, "x": f}
            row |= {"data": f * (1 + 1j), "abscissa_spacing": 1, "abscissa_spec_data_type": 18, "binary": binary}
            row |= {"ordinate_spec_data_type": 12, "orddenom_spec_data_type": 13}
            pyuff.UFF(str(Path(folder, "m.uff"))).write_sets([row], mode="add", force_double=True)
            made.append(Path(folder, "m.uff").read_bytes())
    return tuple(made)


HEAD = json.dumps({"title": TITLE, "digest": "digest", "points": 3}) + "\n"
LINES = '{"point": 0, "figures": {"f": 1.5, "g": "nan"}, "reason": ""}\n{"point": 2, "figures": {}, "reason": "none"}\n'
SWEEP = """of = "response"
inputs = ["tool.fx"]
outputs = ["tool.x"]
damping = 0.02
hold = ["all"]
samples = 100
[over]
"ram.k" = "lognormal:1e7:0.2"
"ram.mass" = "normal:25:1"
"q.motor_y" = "0:0.2"
"bed_yaw.k" = "1e7:1e8"
"""
TABLE = "name,type,theta [deg],d,a,alpha,mass\none,revolute,0,0.1,0.2,pi/2,1\ntwo,prismatic,30,0,0.3,0,2.5\n"
READERS = {
    "toml": Reader(".toml", lambda: (*_texts(TOML, COUPLED, BY_AXIS)(), *of_files("*.toml")()), survives),
    "par": Reader(".par", lambda: (*_texts(PAR, PAR_LOOP)(), *of_files("*.par")()), survives),
    "urdf": Reader(".urdf", lambda: (*_texts(ARM, GRIPPER)(), *of_files("*.urdf")()), survives),
    "mjcf": Reader(".xml", lambda: (*_texts(*ROBOTS.values())(), *of_files("*.xml")()), survives),
    "dh": Reader(".csv", _texts(TABLE, TABLE.replace(",", ";").replace(".", ",")), survives),
    "log": Reader(".csv", _texts(_log(), _log().replace(",", ";"), _log().replace(",", "\t")),
                  lambda path: read_measurements(path, example("planar_2r.toml"))),
    "arrays": Reader(".npz", _arrays, read_arrays),
    "scene": Reader(".toml", of_files("scenes/planar_2r*.toml", "scenes/puma*.toml"), _scene),
    "sweep": Reader(".toml", _texts(SWEEP), _sweep),
    "tests": Reader(".toml", of_files("two_axis_tests/tests.toml"), _tests),
    "responses": Reader(".csv", of_files("lathe_tests/hammer_far.csv", "lathe_tests/modes*.csv"), _measured),
    "universal": Reader(".uff", _universal, _measured),
    "journal": Reader(".journal", _texts(HEAD + LINES), _journal),
    "manifest": Reader(".json", _texts('{"files": ["a.c", "b/c.m"], "sha256": {"a.c": "00"}}'), _manifest),
}  # fmt: skip
NEEDS = {"mjcf": "mujoco", "universal": "pyuff"}


@cache
def sources(reader: str) -> tuple[str, ...]:
    """The contents that are damaged, a character for each byte where they are no text."""
    return tuple(_as_text(content) for content in READERS[reader].sources())


def _as_text(content: bytes) -> str:
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1")


# Mutants


def mutant(seed: int, reader: str) -> Mutant:
    """A mutant for a reader; the same for the same number."""
    rng = random.Random(f"{reader} {seed}")
    text = rng.choice(sources(reader))
    for _ in range(rng.choice((1, 1, 1, 2, 3, 8))):
        text = rng.choice(DAMAGE)(text, rng)
    if rng.random() < 0.1:
        text = _replace_token(text, rng, rng.choice(REPEATED))
    content = bytearray(text.encode("latin-1" if reader in ("arrays", "universal") else "utf-8", "replace"))
    if rng.random() < 0.1 or reader == "arrays":
        for _ in range(rng.randint(1, 5)):
            if content:
                content[rng.randrange(len(content))] = rng.randrange(256)
    return Mutant(bytes(content), reader)


def _replace_token(text: str, rng: random.Random, repeated: str = "") -> str:
    found = list(TOKEN.finditer(text))
    if not found:
        return text
    token = rng.choice(found)
    other = rng.choice(ODD) if rng.random() < 0.6 else rng.choice(found)[0]
    other = repeated * (rng.choice((400, 5000, 60_000)) // len(repeated)) if repeated else other
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
    other = rng.choice(sources(rng.choice(tuple(name for name in READERS if name not in NEEDS))))
    return text[: rng.randrange(len(text) + 1)] + other[rng.randrange(len(other)) :]


DAMAGE: tuple[Callable[[str, random.Random], str], ...] = (
    *(_replace_token,) * 4,
    *(_change_lines,) * 2,
    *(_cut, _insert, _splice),
)


# What readers do


def outcome(asked: Mutant, folder: Path) -> str:
    """Let a reader read a file: "accepted", "refused", or "slow" and how long; other errors are raised."""
    reader = READERS[asked.reader]
    path = folder / f"arm{reader.suffix}"
    path.write_bytes(asked.content)
    begin = time.process_time()
    try:
        reader.read(path)
        found = "accepted"
    except InputError as error:
        said = str(error)
        assert "\n" not in said and len(said) <= LONGEST_MESSAGE and said == printable(said), error
        found = "refused"
    seconds = time.process_time() - begin
    is_long = seconds > LONGEST * max(1.0, len(asked.content) / 1e5) and asked.reader not in ("mjcf", "tests")
    return f"slow: {seconds:.1f} s" if is_long and found == "refused" else found


def available() -> list[str]:
    """The readers whose packages are installed."""
    from importlib.util import find_spec

    return [name for name in READERS if name not in NEEDS or find_spec(NEEDS[name])]


def main() -> int:
    """Try mutants; print how many were accepted and refused, and every failure with its number."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz")
    parser.add_argument("--reader", choices=available(), action="append", help="of these readers only")
    parser.add_argument("--count", type=int, default=20_000, help="mutants to try, of all readers together")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--show", action="store_true", help="print the mutants")
    parser.add_argument(
        "--guided", type=int, metavar="SECONDS", help="let atheris look for files that reach new branches"
    )
    asked = parser.parse_args()
    names = asked.reader or available()
    if asked.guided:
        return guided(names[0], asked.guided)
    failed = 0
    for name in names:
        failed += tried(name, range(asked.first, asked.first + max(1, asked.count // len(names))), asked.show)
    return 1 if failed else 0


def tried(name: str, numbers: range, is_shown: bool) -> int:
    """Try mutants for one reader, print a line, and return how many failed."""
    found, slowest, begin = Counter[str](), (0.0, 0), time.process_time()
    for number in numbers:
        made = mutant(number, name)
        if is_shown:
            print(made.content.decode("utf-8", "replace"))
        start = time.process_time()
        try:
            with tempfile.TemporaryDirectory() as folder:
                said = outcome(made, Path(folder))
            if said.startswith("slow"):
                print(f"{name}, mutant {number}: {said}")
            found[said.partition(":")[0]] += 1
        except Exception:
            found["failed"] += 1
            print(f"{name}, mutant {number}:\n{traceback.format_exc(limit=-3)}", flush=True)
        slowest = max(slowest, (time.process_time() - start, number))
    counts = ", ".join(f"{count} {word}" for word, count in sorted(found.items()))
    seconds = time.process_time() - begin
    print(f"{name}: {counts}; {seconds:.0f} s, the slowest {slowest[0]:.2f} s (mutant {slowest[1]})", flush=True)
    return found["failed"] + found["slow"]


# Led by branches


GUIDED = ("symoro_elastic.formats", "symoro_elastic.machine", "symoro_elastic.analysis.time_series", "tomllib",
          "symoro_elastic.measured.vibration_tests", "symoro_elastic.analysis.sweeps", "symoro_elastic.api",
          "symoro_elastic.quantities", "symoro_elastic.foundation")  # fmt: skip
"""Packages whose branches are looked at."""


def guided(name: str, seconds: int) -> int:
    """Let atheris change files for a reader, and print each place of an error once, with a file that leads to it."""
    import atheris

    functions = [*_functions()]
    for function in functions:
        atheris.instrument_func(function)
    failures: dict[str, bytes] = {}
    counts, begin = Counter[str](), time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        corpus = Path(folder, "corpus")
        corpus.mkdir()
        for k, content in enumerate(READERS[name].sources()):
            (corpus / str(k)).write_bytes(content[:20_000])
        words = Path(folder, "words")
        words.write_text("".join(f'"{_escaped(word)}"\n' for word in ODD if 0 < len(word) < 60), encoding="ascii")

        def one(content: bytes) -> None:
            try:
                with tempfile.TemporaryDirectory(dir=folder) as own:
                    said = outcome(Mutant(content, name), Path(own))
            except Exception as error:
                said = "failed"
                _, _, trace = sys.exc_info()
                where = f"{type(error).__name__} at {traceback.extract_tb(trace)[-1]}"
                if failures.setdefault(where, content) is content:
                    print(f"{name}: {traceback.format_exc(limit=-3)}{content!r}", flush=True)
            else:
                if said.startswith("slow"):
                    print(f"{name}: {said}: {content[:300]!r} ({len(content)} bytes)", flush=True)
            counts[said.partition(":")[0]] += 1
            if time.monotonic() - begin > seconds:
                print(
                    f"{name}: {dict(counts)}, {len(functions)} functions, {len(failures)} places of errors", flush=True
                )
                os._exit(bool(failures))  # atheris takes an exception for a failure of the file

        atheris.Setup(
            [name, str(corpus), f"-dict={words}", "-max_len=40000", "-verbosity=0", "-print_final_stats=0"], one
        )
        atheris.Fuzz()
    return 1


def _escaped(word: str) -> str:
    return "".join(c if c.isascii() and c.isalnum() else "".join(f"\\x{byte:02x}" for byte in c.encode()) for c in word)


def _functions() -> Iterator[Any]:
    """The functions of the packages that are looked at."""
    for module in [one for name, one in sys.modules.items() if name.startswith(GUIDED)]:
        for found in [*vars(module).values()]:
            members = (
                [*vars(found).values()] if isinstance(found, type) and found.__module__ == module.__name__ else [found]
            )
            for member in members:
                function = getattr(member, "__func__", getattr(member, "fget", member))
                if isinstance(function, types.FunctionType) and function.__module__ == module.__name__:
                    yield function


if __name__ == "__main__":
    sys.exit(main())
