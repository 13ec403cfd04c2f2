"""Results of references in many digits, stored in `data/` with the digest of what they were computed from.

python -m tests.references.stored               computes all of them anew and compares
python -m tests.references.stored --regenerate  writes them

One in `RECOMPUTED` is computed anew in every run of the tests, always the same ones. A result whose machine, state or
number of digits is not the stored one is an error.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib
import json
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
import pytest
from mpmath import mpf

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.machine.machine import Machine

TESTS = Path(__file__).parents[1]
DATA = Path(__file__).parent / "data"
RECOMPUTED = 16
MORE = 3
"""Digits that are stored beyond those of the result: the text reads back as nearly the same number."""
COMMAND = "python -m tests.references.stored"

Entries = dict[str, dict[str, Any]]
Compute = Callable[..., Any]

_mode: list[str] = []
"""`compare` or `regenerate`, if the command runs; it computes everything."""
_computed: dict[str, Entries] = {}
"""What it has computed, by function."""


def stored(compute: Compute, machine: Machine, *state: Any, digits: int = 50) -> Any:
    """`compute(machine, *state)`, lists of mpf or numbers, from the data of this function.

    The state consists of (lists of) numbers that are the same on every machine, bit for bit.
    """
    key = digest(machine, state, digits)
    if _mode:
        return _compute(compute, machine, state, digits, key)
    entries = _stored(compute.__name__)
    known = entries.get(key)
    if known is None:
        raise LookupError(
            f"{_file(compute.__name__)}: no result of {compute.__name__} for {machine.name} at this state in {digits} "
            f"digits: the machine, the state or the digits have changed; if they are right, {COMMAND} --regenerate"
        )
    result = _numbers(known["result"], digits)
    if key in sorted(entries)[::RECOMPUTED]:
        _assert_equal(compute, machine, result, compute(machine, *state), digits)
    return result


def digest(machine: Machine, state: Any, digits: int) -> str:
    """Of the machine as a TOML file, the numbers of a state without rounding, and the digits of the result."""
    text = "\n".join((toml.write(machine), repr(_plain(state)), str(digits)))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _compute(compute: Compute, machine: Machine, state: Any, digits: int, key: str) -> Any:
    result = compute(machine, *state)
    entry = {"machine": machine.name, "digits": digits, "result": _texts(result, digits)}
    _computed.setdefault(compute.__name__, {})[key] = entry
    if _mode[0] == "compare":
        known = _stored(compute.__name__).get(key)
        assert known, f"{compute.__name__}: nothing is stored for {machine.name}"
        _assert_equal(compute, machine, _numbers(known["result"], digits), result, digits)
    return result


def _assert_equal(compute: Compute, machine: Machine, found: Any, wanted: Any, digits: int) -> None:
    """To all digits but the last five, relative to the largest entry."""
    with mpmath.workdps(digits + MORE):
        ours, theirs = _flat(found), _flat(wanted)
        assert len(ours) == len(theirs), f"{compute.__name__} of {machine.name}: another shape than what is stored"
        scale = max([mpf(1), *map(abs, theirs)])
        error = max((abs(a - b) for a, b in zip(ours, theirs, strict=True)), default=mpf(0))
        assert error <= scale * mpf(10) ** (5 - digits), (
            f"{compute.__name__} of {machine.name} is not what is stored: if it is right, {COMMAND} --regenerate"
        )


@cache
def _stored(name: str) -> Entries:
    path = _file(name)
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}


def _file(name: str) -> Path:
    return DATA / f"{name}.json"


def _plain(numbers: Any) -> Any:
    """Nested tuples of numbers, each as it is written exactly."""
    if isinstance(numbers, mpf):
        return repr(numbers._mpf_)
    if hasattr(numbers, "tolist"):
        return _plain(numbers.tolist())
    return tuple(map(_plain, numbers)) if isinstance(numbers, (list, tuple)) else numbers


def _texts(result: Any, digits: int) -> Any:
    if isinstance(result, (list, tuple)) or hasattr(result, "tolist"):
        return [_texts(entry, digits) for entry in result]
    return mpmath.nstr(result, digits + MORE, strip_zeros=True) if isinstance(result, mpf) else result


def _numbers(entries: Any, digits: int) -> Any:
    if isinstance(entries, list):
        return [_numbers(entry, digits) for entry in entries]
    if not isinstance(entries, str):
        return entries
    with mpmath.workdps(digits + MORE):
        return mpf(entries)


def _flat(entries: Any) -> list[Any]:
    if isinstance(entries, (list, tuple)) or hasattr(entries, "tolist"):
        return [x for entry in entries for x in _flat(entry)]
    return [mpf(entries)]


def run(mode: str) -> int:
    """Run the tests that read stored results, computing all of them: `compare` or `regenerate`."""
    _mode[:] = [mode]
    readers = [path for path in sorted(TESTS.rglob("test_*.py")) if "references.stored import" in path.read_text()]
    status = pytest.main(["-n", "0", "-q", "-m", "", *map(str, readers)])
    if mode == "regenerate" and not status:
        DATA.mkdir(exist_ok=True)
        for name, entries in _computed.items():
            lines = (f"{json.dumps(key)}: {json.dumps(entries[key])}" for key in sorted(entries))
            _file(name).write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    return int(status)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--regenerate", action="store_true", help="write the data instead of comparing with it")
    module = importlib.import_module("tests.references.stored")  # the one that tests import, not this one
    sys.exit(module.run("regenerate" if parser.parse_args().regenerate else "compare"))
