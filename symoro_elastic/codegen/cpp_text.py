"""C made C++: types become arguments of templates, the word that begins all names of a machine's C a namespace."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping

from symoro_elastic.codegen.c_lines import INDENT
from symoro_elastic.codegen.c_text import Routine

SCALAR, PARAMETER = "Scalar", "Parameter"
"""The types of a state, and of what depends on parameters only."""
MOTORS = "motors_in_q"
COMMENT = re.compile(r"(/\*.*?\*/)", re.DOTALL)
HEX = re.compile(r"0x[0-9a-f]+(?:\.[0-9a-f]+)?p[-+]?\d+")
HEAD = re.compile(r"(?:static )?(?:inline )?void (\w+)\(([^)]*)\)", re.DOTALL)


def decimal(text: str) -> str:
    """Return C without hexadecimal numbers, which C++ has from C++17 on; the decimal digits give the same numbers."""
    return HEX.sub(lambda found: repr(float.fromhex(found[0])), text)


def constant(name: str) -> str:
    """Return the name of what is a macro or an enumerator in C: `joints` for JOINTS, `p_Ia` for P_Ia."""
    return f"p_{name.removeprefix('P_')}" if name.startswith("P_") else name.lower()


class CppText:
    """Functions of a machine's C as templates of C++: `arm_direct_dynamics` is `arm::direct_dynamics`."""

    def __init__(self, name: str, namespace: str, called: Collection[str], empty: Collection[str]) -> None:
        """`called` are functions of the scalar type that bodies may call, `empty` arrays without entries.

        Other functions are called by their namespace, so that none of those beside the type is meant.
        """
        self.namespace, self.called, self.empty = namespace, called, frozenset(empty)
        self._calls = re.compile(rf"\b{name}_(\w+)\(")
        self._names, self._macros = re.compile(rf"\b{name}_(\w+)"), re.compile(rf"\b{name.upper()}_(\w+)")

    def definition(self, routine: Routine) -> str:
        """Return a function of C as a template."""
        return self._template(routine.head, routine.body)

    def steps(self, source: str, comments: Mapping[str, str]) -> str:
        """Return the definitions of time steps, one after another as in C, `comments` before those that have one."""
        pieces = re.split(r"^\}$", source, flags=re.MULTILINE)
        return "".join(self._piece(piece, comments) for piece in pieces[:-1]) + pieces[-1]

    def renamed(self, code: str) -> str:
        """Return code without the machine's name in the names of C."""
        code = self._names.sub(lambda found: MOTORS if found[1] == "motors" else found[1], code)
        code = self._macros.sub(lambda found: constant(found[1]), code)
        return re.sub(r"(?<!:)\bsize_t\b", "std::size_t", code)

    def _piece(self, piece: str, comments: Mapping[str, str]) -> str:
        """A function after comments and arrays."""
        start = piece.rfind("\n", 0, piece.index("void ")) + 1
        before = _in_code(piece[:start], self.renamed).replace("static const ", "constexpr ")
        head, _, body = piece[start:].partition("\n{\n")
        comment = next((text for name, text in comments.items() if f" {name}(" in head), "")
        before += f"/* {comment}\n */\n" if comment else ""
        return before + self._template(head, body.rstrip("\n"))

    def _template(self, head: str, body: str) -> str:
        found = HEAD.fullmatch(head)
        assert found, head
        name, arguments = found[1], found[2]
        if not re.search(r"_prepare(_part\d+)?$", name):
            arguments = re.sub(rf"\b{SCALAR} (\*?[pc]\b)", rf"{PARAMETER} \1", arguments)
            body = re.sub(rf"^{INDENT}{SCALAR} c\[", f"{INDENT}{PARAMETER} c[", body, flags=re.MULTILINE)
        whole = {"q", "qd", "qdd"} if re.search(r"_rate(_[a-z]+)?$", name) else set()  # with a floating base
        for array in self.empty - whole:
            arguments = re.sub(rf"\w+ \*{array}\b", f"void *{array}", arguments)
        types = [f"class {type_}" for type_ in (SCALAR, PARAMETER) if re.search(rf"\b{type_}\b", arguments)]
        head = self.renamed(f"inline void {name}({arguments})")
        body = self._calls.sub(rf"{self.namespace}::\1(", body)
        lines = "".join(self._declared_use(body)) + _in_code(body, self.renamed)
        return f"template <{', '.join(types)}>\n{head}\n{{\n{lines}\n}}"

    def _declared_use(self, body: str) -> Iterator[str]:
        """Lines that let functions be those of the standard library where the type has none."""
        for function in self.called:
            if re.search(rf"\b{function}\(", body):
                yield f"{INDENT}using {'detail' if function == 'sign' else 'std'}::{function};\n"


def _in_code(text: str, change: Callable[[str], str]) -> str:
    """A text with changes everywhere but in its comments."""
    return "".join(part if part.startswith("/*") else change(part) for part in COMMENT.split(text))
