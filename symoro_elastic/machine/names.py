"""Valid names in a machine file: identifiers of C and Python that generated code does not use."""

from __future__ import annotations

import difflib
import re
from collections.abc import Collection, Iterable

from symoro_elastic.quantities import is_intermediate, words

MAX_NAME = 63


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


KEYWORDS = _words(
    """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t char32_t class compl
    concept const consteval constexpr constinit const_cast continue co_await co_return co_yield decltype default delete
    do double dynamic_cast else enum explicit export extern false float for friend goto if inline int long mutable
    namespace new noexcept not not_eq nullptr operator or or_eq private protected public register reinterpret_cast
    requires restrict return short signed sizeof static static_assert static_cast struct switch template this
    thread_local throw true try typedef typeid typename typeof union unsigned using virtual void volatile wchar_t while
    xor xor_eq
    False None True as assert async await def del elif except finally from global import in is lambda nonlocal pass
    raise with yield
    """
)

IMPORTED = _words("math np numpy")
"""Modules that generated Python imports: no machine is called so."""
FORMULA = _words("pi Pi sin cos tan sqrt atan2 nan inf NaN Inf infinity")
LIBRARY = _words(
    """
    I NULL NAN INFINITY EOF HUGE RAND_MAX BUFSIZ CHAR_BIT EXIT_SUCCESS EXIT_FAILURE DOMAIN
    SING OVERFLOW UNDERFLOW PLOSS TLOSS complex imaginary errno stdin stdout stderr offsetof isnan isinf isfinite
    isnormal isless isgreater islessequal isgreaterequal islessgreater isunordered signbit fpclassify
    math_errhandling linux unix near far main printf malloc free memcpy size_t
    fabs pow copysign fmin fmax exp log hypot fma
    range len tuple list dict zip enumerate isinstance print abs min max sum any all map type object ValueError
    TypeError KeyError
    """
)

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)
_MACRO = re.compile(
    r"M_(E|LOG2E|LOG10E|LN2|LN10|PI|PI_2|PI_4|1_PI|2_PI|2_SQRTPI|SQRT2|SQRT1_2)(l|f\d*x?)?"
    r"|HUGE_VAL\w*|SNAN[FL]?\d*X?|(FP|DBL|FLT|LDBL|MATH)_[A-Z0-9_]+|[A-Z]+_(MIN|MAX)",
    re.ASCII,
)


def reserved(name: str, taken: Collection[str] = ()) -> str | None:
    """Reason why `name` is no valid name of a parameter, joint variable, joint or machine; None if valid.

    `taken` holds names that models and targets give to what they generate.
    """
    if len(name) > MAX_NAME:
        return f"a name has at most {MAX_NAME} characters"
    if not _IDENTIFIER.fullmatch(name):
        return "a name is made of ASCII letters, digits and underscores, and starts with a letter"
    if "__" in name:
        return "a name with two underscores in a row belongs to the C++ compiler"
    if name in KEYWORDS:
        return "it is a keyword of C, C++ or Python"
    if name in FORMULA:
        return "formulas use this name"
    if name in LIBRARY or _MACRO.fullmatch(name):
        return "the standard libraries of C or Python use this name"
    if name in taken or name in words():
        return "generated code uses this name"
    if is_intermediate(name):
        return "generated code names an intermediate quantity so"
    return None


def free_name(name: str, taken: Collection[str] = ()) -> str:
    """A valid name like one that is not valid."""
    stem = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9_]", "_", name)).strip("_")[: MAX_NAME - 3] or "x"
    stem = stem if stem[0].isalpha() else f"x{stem}"
    candidates = (stem, f"{stem}_", f"{stem}1", f"my_{stem}", f"my_{stem}_1")
    return next((found for found in candidates if reserved(found, taken) is None), "x1")


def quoted(text: object) -> str:
    """`text` for a one-line message: escaped, quoted, at most 60 characters."""
    whole = str(text)
    return repr(whole if len(whole) <= 60 else whole[:57] + "...")


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """The end of a message about an unknown name: the closest known one, else all if they are few."""
    names = sorted({str(other) for other in known})
    cutoff = 0.5 if len(name) <= 3 else 0.6
    close = difflib.get_close_matches(name[:MAX_NAME], names, n=1, cutoff=cutoff) if len(names) <= 5000 else []
    if not close:
        close = [other for other in names if other.lower() == name.lower()]
    if close:
        return f"; did you mean {quoted(close[0])}?"
    return f"; there are: {', '.join(quoted(other)[1:-1] for other in names)}" if 0 < len(names) <= 15 else ""
