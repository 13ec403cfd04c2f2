"""The target `cpp`: one C++11 header, function templates over the scalar type."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace

from symoro_elastic.codegen.body import Indices
from symoro_elastic.codegen.c.function import CFunction
from symoro_elastic.codegen.c.lanes import TYPE, LanesFunction, Variables, in_lanes
from symoro_elastic.codegen.c.lines import INDENT, wrap_lines
from symoro_elastic.codegen.c.printers import FUNCTIONS, OWN_FUNCTIONS, Form
from symoro_elastic.codegen.c.steps import CSteps
from symoro_elastic.codegen.c.text import FunctionText, Routine, function_text
from symoro_elastic.codegen.local_names import with_local_names, with_own_results
from symoro_elastic.codegen.outlined import SPILL
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.precision import DOUBLE, SINGLE, Precision
from symoro_elastic.codegen.target import Target, words
from symoro_elastic.codegen.targets.c import KEYWORDS, LIBRARY, banner, default_lines
from symoro_elastic.codegen.targets.c import OWN as C_WORDS
from symoro_elastic.codegen.templates import render

SCALAR, PARAMETER = "Scalar", "Parameter"
"""The types of a state and of parameter-only values."""
MOTORS = "motors_in_q"
COMMENT = re.compile(r"(/\*.*?\*/)", re.DOTALL)
HEX = re.compile(r"0x[0-9a-f]+(?:\.[0-9a-f]+)?p[-+]?\d+")
LANES = re.compile(rf"\b{TYPE.format('([24])')}\b")
COMPOUND = re.compile(rf"\(({TYPE.format('[24]')})\){{")
"""A vector of numbers as C writes it."""
HEAD = re.compile(r"(?:static )?(?:inline )?void (\w+)\(([^)]*)\)", re.DOTALL)

OWN = C_WORDS | words(
    "joints motors dependent frames parameters defaults detail std size_t motors_in_q Scalar Parameter"
)
"""Identifiers of the templates that a user's name could hide."""
MACROS = re.compile(
    r"U?INT\w+|([A-Z]+_)+(WIDTH|MAX|MIN|ENDIAN|DIG|ORDER)|MAXFLOAT|NFDBITS|FD_\w+|W[A-Z]{5,}|BYTE_ORDER"
)
"""Macros of the headers that are included, where a variable may have their name."""
GLOBAL = words(
    """
    strto strtou a64l abort abs acos acosh aligned_alloc alloca arc4random arc4random_buf arc4random_uniform asin asinh
    at_quick_exit atan atan2 atanh atexit atof atoi atol bsearch calloc canonicalize canonicalize_file_name cbrt ceil
    clearenv copysign cos cosh daddl ddivl dfmal div dmull drand48 drand48_data drem dsqrtl dsubl ecvt erand48 erf
    erfc exit exp exp10 exp2 expm1 fabs fadd fcvt fd_mask fd_set fdim fdiv ffma finite floor fma fmax fmaximum
    fmaximum_mag fmaximum_mag_num fmaximum_num fmaxmag fmin fminimum fminimum_mag fminimum_mag_num fminimum_num
    fminmag fmod fmul free frexp fromfp fromfpx fsqrt fsub gamma gcvt getenv getloadavg getpayload getpt getsubopt
    grantpt hypot ilogb initstate iscanonical iseqsig isinff isinfl isnanf isnanl issignaling iszero j0 j1 jn jrand48
    l64a labs lcong48 ldexp ldiv lgamma llabs lldiv llogb llrint llround log log10 log1p log2 logb lrand48 lrint
    lround malloc mblen mbstowcs mbtowc mkdtemp mkostemp mkostemps mkstemp mkstemps mktemp modf mrand48 nan nearbyint
    nextafter nextdown nexttoward nextup nrand48 on_exit posix_memalign posix_openpt pow pselect ptsname putenv qecvt
    qfcvt qgcvt qsort quick_exit rand random random_data realloc reallocarray realpath remainder remquo rint round
    roundeven rpmatch scalb scalbln scalbn secure_getenv seed48 select setenv setpayload setpayloadsig setstate
    signgam significand sin sincos sinh sqrt srand srand48 srandom std strfrom strfromd strtod strtof strtol strtold
    strtoq strtoul strtouq system tan tanh tgamma timespec timeval totalorder totalordermag trunc u_char u_int u_long
    u_short ufromfp ufromfpx uint ulong unlockpt unsetenv ushort valloc wcstombs wctomb y0 y1 yn
    """
)
"""Functions that these headers declare, by their names for doubles, and reserved names of namespaces."""
VARIANT = re.compile(r"([fl]|f\d+x?|64)?(_[rl])?$")
"""Suffixes of functions for other types."""


@dataclass(frozen=True)
class _AnyPrecision(Precision):
    """A precision for C++ templates: statements and arrays have the type `Scalar`."""

    @property
    def suffix(self) -> str:
        return ""

    def function(self, package: str, model: str) -> str:
        return f"{package}_{model}"

    def number(self, digits: str) -> str:
        return f"{SCALAR}({digits})"

    def number_of_state(self, digits: str) -> str:
        return self.number(digits)


ANY = _AnyPrecision("any", "of any scalar type", SCALAR, SCALAR, SCALAR, DOUBLE.bits)
FORM = Form(
    number=SCALAR,
    angle=SCALAR,
    real=SCALAR,
    load="{array}[{k}]",
    load_angle="{array}[{k}]",
    store="{array}[{k}] = {value};",
    narrow="{}",
    functions={name: name for name in FUNCTIONS},
    load_parameter=f"{SCALAR}({{array}}[{{k}}])",
    sincos=lambda angles, _: (f"detail::sines_and_cosines({len(angles)}U, angle, sine, cosine);",),
    operand=f"{SCALAR}({{}})",
    outlined=1,
)


class _CppFunction(CFunction):
    """A model as a C++ template: parameter-only values may have another type than the state."""

    def _of_parameters(self, groups: Mapping[str, Indices], used: Iterator[str]) -> dict[str, str]:  # type: ignore[override]
        return self.once_writer.unpack_lines(groups, used, dict.fromkeys(groups, self.form.load_parameter))

    def type_of(self, array: str) -> str:
        return PARAMETER if array in ("p", "c") else super().type_of(array)

    def stack(self) -> int:
        """Bytes of the work arrays of a call on doubles."""
        return 8 * (self.slots + 3 * len(self.angles))


class _Variables(Variables):
    """Variables in lanes that are spilled number by number, so that compilers can infer their type."""

    def _in_slot(self, name: str, slot: str) -> list[str]:
        return [f"{SPILL}[{self.width * int(slot) + k}]" for k in range(self.width_of(name))]


class _CppLanes(_CppFunction, LanesFunction):
    """A model as a C++ template, congruent limbs in lanes of vectors."""

    variables = _Variables

    def _partition(self) -> None:
        super()._partition()
        self.form, self.slots = replace(self.form, number=SCALAR), self.lanes.width * self.slots


@dataclass(frozen=True)
class ModelText:
    """A model: its comment, its templates in order of definition, and the number of parameter-only values."""

    name: str
    title: str
    counts: str
    documented: tuple[str, ...]
    constants: str
    constant_count: int
    definitions: tuple[str, ...]


@dataclass(frozen=True)
class HeaderText:
    """Template data of the C++ header; `called` are the functions that statements need."""

    package: Package
    namespace: str
    macro: str
    banner: str
    defaults: tuple[str, ...]
    functions: tuple[ModelText, ...]
    called: frozenset[str]
    has_angles: bool
    has_lanes: bool
    precisions: tuple[Precision, ...]
    steps: str
    nodes: Mapping[str, int]
    step_constants: int


def namespace_of(name: str) -> str:
    """The namespace of a machine: its name, with an underscore where the standard library has that name."""
    is_global = name in GLOBAL | LIBRARY or VARIANT.sub("", name) in GLOBAL or name.endswith("_t")
    return f"{name}_" if is_global else name


def render_cpp(package: Package) -> Files:
    """Return `<name>.hpp`."""
    package = with_local_names(with_own_results(package), _reserved_names(package))
    functions = [_CppFunction(package, function, ANY, FORM) for function in package.functions]
    lanes = [in_lanes(function, _CppLanes) for function in functions]
    steps = CSteps(package, ANY, functions)
    called = frozenset(name for function in functions for name in function.printer.called)
    empty = {a.name for f in functions for a in f.signature if not a.entries}
    text = CppText(package.name, namespace_of(package.name), sorted(called), empty)
    header = HeaderText(
        package=package,
        namespace=namespace_of(package.name),
        macro=package.name.upper(),
        banner=banner(package, ANY),
        defaults=tuple(line.replace("NAN ", "static_cast<double>(NAN) ") for line in default_lines(package, DOUBLE)),
        functions=tuple(_model(function_text(x or y), text) for x, y in zip(lanes, functions, strict=True)),
        called=called,
        has_angles=any(function.angles for function in functions),
        has_lanes=any(lanes),
        precisions=(DOUBLE, SINGLE),
        steps=text.steps(steps.source(), {step.name: step.comment for step in steps.steps}),
        nodes=steps.nodes,
        step_constants=steps.constants,
    )
    return {f"{package.name}.hpp": wrap_lines(decimal(render("cpp/header.hpp.j2", **vars(header))))}


def _reserved_names(package: Package) -> frozenset[str]:
    """Identifiers that local variables may not have."""
    symbols = {p.symbol for p in package.parameters}
    symbols |= {symbol for f in package.functions for a in f.program.inputs for symbol in a.symbols}
    macros = {symbol for symbol in symbols if MACROS.fullmatch(symbol)}
    return OWN | macros | {package.name, namespace_of(package.name)} | {f"p_{p.name}" for p in package.parameters}


def _model(function: FunctionText, text: CppText) -> ModelText:
    return ModelText(
        name=text.without_machine_name(function.name),
        title=function.title,
        counts=function.counts,
        documented=function.documented,
        constants=constant(text.without_machine_name(function.constants)),
        constant_count=function.constant_count,
        definitions=tuple(map(text.definition, function.routines)),
    )


# C made C++: types become arguments of templates, the word that begins all names of a machine's C a namespace.
def decimal(text: str) -> str:
    """Return C code with hexadecimal numbers, which need C++17, replaced by equal decimal numbers."""
    return HEX.sub(lambda found: repr(float.fromhex(found[0])), text)


def constant(name: str) -> str:
    """Return the name of a macro or an enumerator of C in C++: `joints` for JOINTS, `p_Ia` for P_Ia."""
    return f"p_{name.removeprefix('P_')}" if name.startswith("P_") else name.lower()


class CppText:
    """Converter of a machine's C functions to C++ templates: `arm_direct_dynamics` is `arm::direct_dynamics`."""

    def __init__(self, name: str, namespace: str, called: Collection[str], empty: Collection[str]) -> None:
        """Prepare; `called` are functions of the scalar type that bodies may call, `empty` arrays without entries.

        Other functions are called with their namespace, so that functions of the type's namespace are not selected.
        """
        self.namespace, self.called, self.empty = namespace, called, frozenset(empty)
        self._calls = re.compile(rf"\b{name}_(\w+)\(")
        self._names, self._macros = re.compile(rf"\b{name}_(\w+)"), re.compile(rf"\b{name.upper()}_(\w+)")

    def definition(self, routine: Routine) -> str:
        """Return a function of C as a template."""
        return self._template(routine.head, routine.body)

    def steps(self, source: str, comments: Mapping[str, str]) -> str:
        """Return the definitions of time steps in the order of C, with `comments` before those that have one."""
        pieces = re.split(r"^\}$", source, flags=re.MULTILINE)
        return "".join(self._piece(piece, comments) for piece in pieces[:-1]) + pieces[-1]

    def without_machine_name(self, code: str) -> str:
        """Return code without the machine's name in the names of C."""
        code = self._names.sub(lambda match: MOTORS if match[1] == "motors" else match[1], code)
        code = self._macros.sub(lambda match: constant(match[1]), code)
        return re.sub(r"(?<!:)\bsize_t\b", "std::size_t", code)

    def _piece(self, piece: str, comments: Mapping[str, str]) -> str:
        """A C definition as a C++ template, after its comment and its arrays."""
        start = piece.rfind("\n", 0, piece.index("void ")) + 1
        before = _in_code(piece[:start], self.without_machine_name).replace("static const ", "constexpr ")
        head, _, body = piece[start:].partition("\n{\n")
        comment = next((text for name, text in comments.items() if f" {name}(" in head), "")
        before += f"/* {comment}\n */\n" if comment else ""
        return before + self._template(head, body.rstrip("\n"))

    def _template(self, head: str, body: str) -> str:
        match = HEAD.fullmatch(head)
        assert match, head
        name, arguments = match[1], match[2]
        if not re.search(r"_prepare(_part\d+)?$", name):
            arguments = re.sub(rf"\b{SCALAR} (\*?[pc]\b)", rf"{PARAMETER} \1", arguments)
            body = re.sub(rf"^{INDENT}{SCALAR} c\[", f"{INDENT}{PARAMETER} c[", body, flags=re.MULTILINE)
        full = {"q", "qd", "qdd"} if re.search(r"_rate(_[a-z]+)?$", name) else set()  # with the base
        for array in self.empty - full:
            arguments = re.sub(rf"\w+ \*{array}\b", f"void *{array}", arguments)
        typedefs = "".join(self._types_of_lanes(body))
        types = [f"class {type_}" for type_ in (SCALAR, PARAMETER) if re.search(rf"\b{type_}\b", arguments)]
        head = self.without_machine_name(f"inline void {name}({arguments})")
        body = COMPOUND.sub(r"\1{", self._calls.sub(rf"{self.namespace}::\1(", body))
        lines = typedefs + "".join(self._declared_use(body)) + _in_code(body, self.without_machine_name)
        return f"template <{', '.join(types)}>\n{head}\n{{\n{lines}\n}}"

    @staticmethod
    def _types_of_lanes(body: str) -> Iterator[str]:
        """Names of the vector types used in a body."""
        for width in sorted({*LANES.findall(body)}):
            name = TYPE.format(width)
            yield f"{INDENT}typedef typename detail::Lanes<{SCALAR}, {width}>::type {name};\n"

    def _declared_use(self, body: str) -> Iterator[str]:
        """Using-declarations of standard functions in a body, for scalar types without their own."""
        for function in self.called:
            if re.search(rf"\b{function}\(", body):
                yield f"{INDENT}using {'detail' if function in OWN_FUNCTIONS else 'std'}::{function};\n"


def _in_code(text: str, change: Callable[[str], str]) -> str:
    """A text with a change applied everywhere but in its comments."""
    return "".join(part if part.startswith("/*") else change(part) for part in COMMENT.split(text))


CPP = Target(
    name="cpp",
    title="one C++11 header: templates of any scalar type",
    suffixes=(".hpp",),
    precisions=(DOUBLE,),
    reserved=KEYWORDS | LIBRARY,
    files=lambda package, _: render_cpp(package),
)
