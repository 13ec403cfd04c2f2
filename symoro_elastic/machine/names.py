"""Names a machine file may use: identifiers of C and Python that nothing in generated code takes."""

from __future__ import annotations

import difflib
import re
from collections.abc import Collection, Iterable

MAX_NAME = 63


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


MODELS = (
    "direct_dynamics",
    "direct_dynamics_by_inertia_matrix",
    "inverse_dynamics",
    "inertia_matrix",
    "bias_forces",
    "geometric_model",
    "jacobian",
    "jacobian_dot_qd",
    "velocities",
    "accelerations",
    "reaction_wrenches",
    "energy",
    "coriolis_forces",
    "gravity_forces",
    "friction_forces",
    "external_forces",
    "inverse_geometric_model",
    "inverse_position_model",
    "base_parameters",
    "regressor",
    "energy_regressor",
    "inverse_dynamics_derivatives",
    "direct_dynamics_derivatives",
    "inverse_dynamics_parameter_derivatives",
    "direct_dynamics_parameter_derivatives",
    "linearization",
    "feed_forward",
)

# Models of frames: of any point of them, and those that place one frame in another.
AT_POINTS = ("geometric_model", "velocities", "accelerations", "jacobian", "jacobian_dot_qd")
SEEN_FROM_FRAMES = (*AT_POINTS, "inverse_geometric_model", "inverse_position_model")
# Models whose results belong to the machine as a whole.
WHOLE = ("energy", "energy_regressor", "base_parameters")

# Intermediate variables of generated code: `<letters><joint number>`, their parts `<letters><joint number>a`,
# `<letters><joint number>_<component>`, and `<prefix><anything>`.
QUANTITIES: dict[str, Collection[str]] = {
    "scalars": _words("H Hinv Gamma Gb qd qdd qdf tau rho"),
    "components": _words(
        """
        A Jc P w ww wd W v vd Vk Vr g b bs J M MS U UH K Ka al f F N DV Js bstar T dJ sin cos Ac V Vd Y angle root
        length Pc Qc Q Lb Db fb Fa Fb Fh Fq Fv Gq Gv qddq qddv qddt y
        """
    ),
    "prefixes": ("sin_", "cos_", "sign_", "result_", "pair_", "by_", "rate_"),
}

GENERATED = _words(
    """
    q qd qdd tau p c stride live sine cosine angle qdd_motor pi Pi sin cos tan sqrt atan2 sign math np numpy
    JOINTS MOTORS ELASTIC PARAMETERS DEFAULTS FRAMES OUTPUTS parameters all nan inf NaN Inf infinity
    """
).union(MODELS)

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

LIBRARY = _words(
    """
    NUMBER ANGLE BITS OF WHOLE EXCESS EQUATIONS LOAD LOAD_ANGLE STORE NARROW WIDTH LANES VECTOR VECTOR_BYTES INLINE
    APART LARGEST_ANGLE numbers angles bits lanes_at put circle circles far_circles double_double pair
    I NULL NAN INFINITY EOF HUGE RAND_MAX BUFSIZ CHAR_BIT EXIT_SUCCESS EXIT_FAILURE DOMAIN
    SING OVERFLOW UNDERFLOW PLOSS TLOSS complex imaginary errno stdin stdout stderr offsetof isnan isinf isfinite
    isnormal isless isgreater islessequal isgreaterequal islessgreater isunordered signbit fpclassify
    math_errhandling linux unix near far main printf malloc free memcpy size_t
    fabs pow copysign fmin fmax exp log hypot fma
    range len tuple list dict zip enumerate isinstance print abs min max sum any map type object ValueError TypeError
    KeyError
    """
)

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)
_MACRO = re.compile(
    r"M_(E|LOG2E|LOG10E|LN2|LN10|PI|PI_2|PI_4|1_PI|2_PI|2_SQRTPI|SQRT2|SQRT1_2)(l|f\d*x?)?"
    r"|HUGE_VAL\w*|SNAN[FL]?\d*X?|(FP|DBL|FLT|LDBL|MATH)_[A-Z0-9_]+|[A-Z]+_(MIN|MAX)",
    re.ASCII,
)


def reserved(name: str) -> str | None:
    """Why `name` may not name a parameter, a joint variable, a joint or a machine; None if it may."""
    if len(name) > MAX_NAME:
        return f"a name has at most {MAX_NAME} characters"
    if not _IDENTIFIER.fullmatch(name):
        return "a name is made of ASCII letters, digits and underscores, and starts with a letter"
    if "__" in name:
        return "a name with two underscores in a row belongs to the C++ compiler"
    if name in KEYWORDS:
        return "it is a keyword of C, C++ or Python"
    if name in GENERATED:
        return "generated code uses this name"
    if name in LIBRARY or _MACRO.fullmatch(name):
        return "the standard libraries of C or Python use this name"
    return _quantity(name)


def _quantity(name: str) -> str | None:
    scalar = re.fullmatch(r"([A-Za-z]+)\d+[a-z]*", name, re.ASCII)
    component = re.fullmatch(r"([A-Za-z]+)\d+_.*", name, re.ASCII)
    if (
        (scalar and scalar[1] in QUANTITIES["scalars"])
        or (component and component[1] in QUANTITIES["components"])
        or name.startswith(tuple(QUANTITIES["prefixes"]))
    ):
        return "generated code names an intermediate quantity so"
    return None


def quoted(text: object) -> str:
    """`text` as it may stand in a one-line message: escaped, quoted, not longer than 60 characters."""
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
        return f"; did you mean {close[0]!r}?"
    return f"; there are: {', '.join(names)}" if 0 < len(names) <= 15 else ""
