"""Valid names in a machine file: identifiers of C and Python that generated code does not use."""

from __future__ import annotations

import difflib
import re
import sys
from collections.abc import Collection, Iterable, Mapping
from types import MappingProxyType

from symoro_elastic.foundation.errors import some_of
from symoro_elastic.foundation.file_forms import DEVICE
from symoro_elastic.quantities import is_intermediate, words

MAX_NAME = 63


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


Reasons = Mapping[str, str]
"""Names that are in use, with the reason why no machine may use them."""
NONE: Reasons = MappingProxyType({})
IN_USE = "generated code uses this name"

MODULES = sys.stdlib_module_names | _words("np numpy setup setuptools pip conftest test tests symoro_elastic")
"""Modules that a generated package of this name would hide from all that imports them, numpy for one."""
FORMULA = _words("pi Pi sin cos tan sqrt atan2 nan inf NaN Inf infinity")
MACROS_OF_COMPILERS = _words("near far huge interrupt linux unix main")
"""Reserved words that may begin names, as `far_direct_dynamics` does."""
ALL_JOINTS = "all"
LIBRARY = "the standard libraries of C or Python use this name"
_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)
_MACRO = re.compile(
    r"M_(E|LOG2E|LOG10E|LN2|LN10|PI|PI_2|PI_4|1_PI|2_PI|2_SQRTPI|SQRT2|SQRT1_2)(l|f\d*x?)?"
    r"|HUGE_VAL\w*|SNAN[FL]?\d*X?|(FP|DBL|FLT|LDBL|MATH)_[A-Z0-9_]+|[A-Z]+_(MIN|MAX)",
    re.ASCII,
)


def why_reserved(name: str, reserved: Reasons = NONE) -> str | None:
    """Reason why `name` is not a valid name of a parameter or joint variable; None if valid.

    `reserved` holds names that models give to what they generate, and words of the languages of targets.
    """
    if reason := _why_no_word(name):
        return reason
    if name in reserved:
        return reserved[name]
    return LIBRARY if _MACRO.fullmatch(name) else _why_in_use(name)


def why_no_joint(name: str, reserved: Reasons = NONE) -> str | None:
    """Reason why `name` is not a valid name of a joint, which generated code has in texts and comments only."""
    if name == ALL_JOINTS:
        return "options use this name for all joints"
    in_use = IN_USE if reserved.get(name) == IN_USE else None
    return _why_no_word(name) or in_use or _why_in_use(name)


def why_no_machine(name: str, reserved: Reasons = NONE) -> str | None:
    """Reason why `name` is not a valid name of a machine, with which names in generated code begin."""
    words = {word: reason for word, reason in reserved.items() if word not in MACROS_OF_COMPILERS}
    if reason := why_reserved(name, words):
        return reason
    if DEVICE.fullmatch(name):
        return "Windows has a device of this name, and no file"
    return "Python has a module of this name, which the generated package would hide" if name in MODULES else None


def _why_no_word(name: str) -> str | None:
    if len(name) > MAX_NAME:
        return f"a name has at most {MAX_NAME} characters"
    if not _IDENTIFIER.fullmatch(name):
        return "a name is made of ASCII letters, digits and underscores, and starts with a letter"
    if "__" in name:
        return "a name with two underscores in a row belongs to the C++ compiler"
    return "formulas use this name" if name in FORMULA else None


def _why_in_use(name: str) -> str | None:
    if name in words():
        return IN_USE
    return "generated code names an intermediate quantity so" if is_intermediate(name) else None


def free_name(name: str, reserved: Reasons = NONE) -> str:
    """A valid name similar to an invalid one."""
    stem = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9_]", "_", name)).strip("_")[: MAX_NAME - 3] or "x"
    stem = stem if stem[0].isalpha() else f"x{stem}"
    candidates = (stem, f"{stem}_", f"{stem}1", f"my_{stem}", f"my_{stem}_1")
    return next((candidate for candidate in candidates if why_reserved(candidate, reserved) is None), "x1")


def distinct(name: str, used: Collection[str]) -> str:
    """The name, with underscores appended while it is in use."""
    while name in used:
        name += "_"
    return name


def quote(text: object) -> str:
    """`text` for a one-line message: escaped, quoted, at most 60 characters."""
    written = str(text)
    return repr(written if len(written) <= 60 else written[:57] + "...")


def list_of_names(names: Iterable[object]) -> str:
    """Names for a one-line message, quoted: the first ten, and how many more there are."""
    return some_of([quote(name) for name in names])


def no_such(kind: str, name: str, choices: Iterable[str]) -> str:
    """Return the message about an unknown name, such as that of a joint, with the closest known one."""
    return f"no {kind} {quote(name)}{did_you_mean(name, choices)}"


def undeclared(name: str, declared: Iterable[str]) -> str:
    """Return the message about a name in a formula that is not a parameter, with the closest known one."""
    return f"{quote(name)} is not declared in [parameters]{did_you_mean(name, declared)}"


def unusable(name: str, reason: str, reserved: Reasons) -> str:
    """Return the message about a name that cannot be used, with a similar one that can."""
    free = free_name(name, {**reserved, name: reason})
    return f"the name {quote(name)} cannot be used: {reason}; {free!r} is free"


def did_you_mean(name: str, choices: Iterable[str]) -> str:
    """The end of a message about an unknown name: the closest known one, else all if they are few."""
    names = sorted({str(other) for other in choices})
    cutoff = 0.5 if len(name) <= 3 else 0.6
    close = difflib.get_close_matches(name[:MAX_NAME], names, n=1, cutoff=cutoff) if len(names) <= 5000 else []
    if not close:
        close = [other for other in names if other.lower() == name.lower()]
    if close:
        return f"; did you mean {quote(close[0])}?"
    return f"; there are: {', '.join(quote(other)[1:-1] for other in names)}" if 0 < len(names) <= 15 else ""
