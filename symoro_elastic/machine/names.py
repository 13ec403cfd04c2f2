"""Valid names in a machine file: identifiers of C and Python that generated code does not use."""

from __future__ import annotations

import difflib
import re
from collections.abc import Collection, Iterable, Mapping
from types import MappingProxyType

from symoro_elastic.foundation.errors import some_of
from symoro_elastic.quantities import is_intermediate, words

MAX_NAME = 63


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


Reasons = Mapping[str, str]
"""Names that are in use, with the reason why no machine may use them."""
NONE: Reasons = MappingProxyType({})
IN_USE = "generated code uses this name"

IMPORTED = _words("math np numpy")
"""Modules that generated Python imports: no machine is called so."""
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


def why_reserved(name: str, taken: Reasons = NONE) -> str | None:
    """Reason why `name` is not a valid name of a parameter or joint variable; None if valid.

    `taken` holds names that models give to what they generate, and words of the languages of targets.
    """
    if reason := _why_no_word(name):
        return reason
    if name in taken:
        return taken[name]
    return LIBRARY if _MACRO.fullmatch(name) else _why_in_use(name)


def why_no_joint(name: str, taken: Reasons = NONE) -> str | None:
    """Reason why `name` is not a valid name of a joint, which generated code has in texts and comments only."""
    if name == ALL_JOINTS:
        return "options use this name for all joints"
    in_use = IN_USE if taken.get(name) == IN_USE else None
    return _why_no_word(name) or in_use or _why_in_use(name)


def why_no_machine(name: str, taken: Reasons = NONE) -> str | None:
    """Reason why `name` is not a valid name of a machine, with which names in generated code begin."""
    words = {**taken, **dict.fromkeys(IMPORTED, IN_USE)}
    return why_reserved(name, {word: reason for word, reason in words.items() if word not in MACROS_OF_COMPILERS})


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


def free_name(name: str, taken: Reasons = NONE) -> str:
    """A valid name, of whatever it is, like one that is not valid."""
    stem = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9_]", "_", name)).strip("_")[: MAX_NAME - 3] or "x"
    stem = stem if stem[0].isalpha() else f"x{stem}"
    candidates = (stem, f"{stem}_", f"{stem}1", f"my_{stem}", f"my_{stem}_1")
    return next((found for found in candidates if why_reserved(found, taken) is None), "x1")


def distinct(name: str, taken: Collection[str]) -> str:
    """The name, with underscores behind it where it is taken."""
    while name in taken:
        name += "_"
    return name


def quote(text: object) -> str:
    """`text` for a one-line message: escaped, quoted, at most 60 characters."""
    whole = str(text)
    return repr(whole if len(whole) <= 60 else whole[:57] + "...")


def list_of_names(names: Iterable[object]) -> str:
    """Names for a one-line message, quoted: the first ten, and how many more there are."""
    return some_of([quote(name) for name in names])


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """The end of a message about an unknown name: the closest known one, else all if they are few."""
    names = sorted({str(other) for other in known})
    cutoff = 0.5 if len(name) <= 3 else 0.6
    close = difflib.get_close_matches(name[:MAX_NAME], names, n=1, cutoff=cutoff) if len(names) <= 5000 else []
    if not close:
        close = [other for other in names if other.lower() == name.lower()]
    if close:
        return f"; did you mean {quote(close[0])}?"
    return f"; there are: {', '.join(quote(other)[1:-1] for other in names)}" if 0 < len(names) <= 15 else ""
