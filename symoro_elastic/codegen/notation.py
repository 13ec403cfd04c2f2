r"""The paper's symbols for the names in a program: one table, read by everything that shows equations.

Components are given in the body's own frame, so the paper's left superscript is left out: K5_14
is K_{5,14}. A trailing letter, as in Js5_14a, marks a part of the quantity that is used more than
once; it becomes a superscript. What is overlined is one product, computed once.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache

from symoro_elastic.symbolic.program import Program

# Components of a name: what they look like, and the one that stands for all in the list of symbols.
COMPONENTS = {
    "": ("", ""),
    "axis": ("_(?P<c>[xyz])", "x"),
    "square": ("_(?P<c>xx|yy|zz)", "xx"),
    "product": ("_(?P<c>[xyz]{2})", "xy"),
    "six": ("_(?P<c>[1-6])", "k"),
    "entry": ("_(?P<c>[1-6]{2})", "mn"),
    "moment": ("_(?P<c>xx|xy|xz|yy|yz|zz)", "xx"),
    "quaternion": ("_(?P<c>[wxyz])", "w"),
    "number": (r"_(?P<c>\d+)", "i"),
    "place": (r"_(?P<c>(?:0_)?\d+(?:_0_\d+|_\d+)?)", "i"),
    "row column": (r"_(?P<c>[1-6]_\d+)", "k_i"),
    "c": ("_c", ""),
    "c axis": ("_c_(?P<c>[xyz])", "x"),
    "c moment": ("_c(?P<c>xx|xy|xz|yy|yz|zz)", "xx"),
    "parameter": (r"_(?P<c>[A-Z]+\d+)", "X"),
    "theta": ("_theta", ""),
    "motor": ("_motor", ""),
    "spring": ("_spring", ""),
    "link": ("_link", ""),
    "compliance": ("_compliance", ""),
    "r": ("_r", ""),
}


@dataclass(frozen=True)
class Quantity:
    """A row of the table: names `<name><joint><component>`, their symbol, its definition and meaning.

    `base`, `above` and `below` are LaTeX in which `@` is the joint, `#` the component, `<` and `>`
    its first and second letter. A row with an `output` holds for programs that have this result.
    """

    name: str
    component: str
    base: str
    above: str
    below: str
    paper: str
    equations: str
    meaning: str
    output: str = ""

    def symbol(self, joint: str = "j", component: str | None = None, part: str = "") -> str:
        """LaTeX of one component; `part` is the letter of a shared part of it."""
        shown = (COMPONENTS[self.component][1] if component is None else component).replace("_", ",")
        above = "".join(x for x in (self.above, rf"\mathrm{{{part}}}" if part else "") if x)
        text = self.base + (f"^{{{above}}}" if above else "") + (f"_{{{self.below}}}" if self.below else "")
        return text.replace("<", shown[:1]).replace(">", shown[1:]).replace("#", shown).replace("@", joint)


# fmt: off
TABLE = (
    Quantity("qd", "", r"\dot{q}", "", "@", "", "[3]", "velocity of joint j"),
    Quantity("qdd", "", r"\ddot{q}", "", "@", "", "[34], [59]", "acceleration of joint j"),
    Quantity("y", "number", "y", "(#)", "@", "", "", "outboard coordinate of motor j, derivative i by time"),
    Quantity("y", "motor", "q", "", "@", "q_{j}", "[9]", "variable of motor j, before its springs"),
    Quantity("y", "spring", "q", "", "@", "q_{j}", "[9]", "deflection of spring j"),
    Quantity("y", "link", "z", "", "@", "", "[9]", "variable of motor j and of springs up to joint j"),
    Quantity("y", "compliance", "k", "-1", "@", "1/k_{j}", "[9]", "inverse of the stiffness of joint j"),
    Quantity("tau", "", r"\Gamma", "", "@", "", "[8], [61]", "torque or force of motor j"),
    Quantity("Gamma", "", r"\bar{\Gamma}", "", "@", r"\Gamma_{j}", "[9], [17], [61]",
             "what moves joint j: motor, spring, damper, less friction"),
    Quantity("Gb", "", r"\Gamma", "*", "@", r"\Gamma_{j} + {}^{j}\mathbf{a}_{j}^{T}\,{}^{j}\boldsymbol{\beta}^{*}_{j}",
             "[30], [52]", "what moves joint j, velocity forces of what it carries included"),
    Quantity("cos", "theta", r"\mathrm{C}", r"\theta", "@", r"\cos\theta_{j}", "[1]", "cosine of the whole angle"),
    Quantity("sin", "theta", r"\mathrm{S}", r"\theta", "@", r"\sin\theta_{j}", "[1]", "sine of the whole angle"),
    Quantity("P", "r", "P", "", r"@,\mathrm{r}", "r_{j}", "[1]", "whole shift along the axis of joint j"),
    Quantity("P", "axis", "P", "", "@#", "{}^{0}P_{j}", "[2]", "origin of frame j, in frame 0"),
    Quantity("A", "number", "A", "", "@,#", r"\mathbf{A}", "[8]", "entry j, i of the inertia matrix", "A"),
    Quantity("A", "number", "A", "", "@,#", r"\mathbf{A}", "[8]", "entry j, i of the inertia matrix", "qdd"),
    Quantity("A", "entry", "A", "", "@,#", "{}^{0}A_{j}", "[2]", "orientation of frame j, in frame 0"),
    Quantity("F", "six", "f", r"\mathrm{e}", "@,#", "", "", "wrench of the surroundings on body j"),
    Quantity("Lb", "entry", r"\mathit{LD}", "", "@,#", r"\mathbf{LD}", "",
             "factors of the articulated inertia of a floating base, L D L^T"),
    Quantity("Db", "six", "D", "-1", "@,#", r"\mathbf{D}^{-1}", "", "inverse pivots of these factors"),
    Quantity("fb", "six", "f", "*", "@,#", r"\mathbf{L}^{-1}(\mathbf{f}_{j} + \boldsymbol{\beta}^{*}_{j})", "",
             "what moves a floating base"),
    Quantity("Q", "quaternion", "Q", "", "@#", "", "", "quaternion that turns frame j into the world"),
    Quantity("Y", "parameter", "Y", "", r"@,\mathit{#}", "", "[15]", "entry of the regressor: joint j, parameter X"),
    Quantity("root", "number", r"\Delta", "", "@,#", "", "", "vanishes where solution i of joint j is singular"),
    Quantity("cos", "number", r"\mathrm{C}", "", "@,#", r"\cos\theta_{j}", "[1]", "cosine of solution i of joint j"),
    Quantity("sin", "number", r"\mathrm{S}", "", "@,#", r"\sin\theta_{j}", "[1]", "sine of solution i of joint j"),
    Quantity("angle", "number", r"\theta", "", "@,#", "", "[1]", "angle of joint j in solution i"),
    Quantity("length", "number", "r", "", "@,#", "", "[1]", "shift of joint j in solution i"),
    Quantity("w", "axis", r"\omega", "", "@#", r"{}^{j}\omega_{j}", "[3]", "angular velocity of body j"),
    Quantity("ww", "square", r"\overline{\omega_{@<}^{2}}", "", "", "", "[7], [14]", "square of an angular velocity"),
    Quantity("ww", "product", r"\overline{\omega_{@<}\,\omega_{@>}}", "", "", "", "[7], [14]",
             "product of angular velocities"),
    Quantity("wd", "axis", r"\dot{\omega}", "", "@#", r"{}^{j}\dot{\omega}_{j}", "[6]",
             "angular acceleration of body j"),
    Quantity("v", "axis", "V", "", "@#", "{}^{j}V_{j}", "[3]", "velocity of the origin of frame j"),
    Quantity("vd", "axis", r"\dot{V}", "", "@#", r"{}^{j}\dot{V}_{j}", "[6]",
             "acceleration of the origin of frame j, gravity subtracted"),
    Quantity("V", "six", "V", "", "@,#", r"{}^{j}\mathbf{V}_{j}", "[3]", "velocity screw of frame j"),
    Quantity("Vd", "six", r"\dot{V}", "", "@,#", r"{}^{j}\dot{\mathbf{V}}_{j}", "[6]", "acceleration of frame j"),
    Quantity("Vk", "six", r"\dot{V}", r"\mathrm{k}", "@,#", r"{}^{j}\dot{\mathbf{V}}^{\mathrm{k}}_{j}", "[6]",
             "part of the acceleration of frame j that is known before the backward recursion"),
    Quantity("Vr", "six", r"\dot{V}", r"\mathrm{r}", "@,#", r"{}^{j}\dot{\mathbf{V}}^{\mathrm{r}}_{j}", "[6], [36]",
             "acceleration of frame j without the part known before the backward recursion"),
    Quantity("W", "axis", r"{}^{0}\omega", "", "@#", r"{}^{0}\omega_{j}", "[3]",
             "angular velocity of body j, in frame 0"),
    Quantity("Ac", "six", r"{}^{0}\dot{V}", "", "@,#", r"{}^{0}\dot{\mathbf{V}}_{j}", "[6]",
             "acceleration of frame j, in frame 0"),
    Quantity("Jc", "row column", "J", "", "@,#", "", "[3]", "column i of the Jacobian of frame j"),
    Quantity("g", "six", r"\gamma", "", "@,#", r"{}^{j}\boldsymbol{\gamma}_{j}", "[7]",
             "known part of the acceleration that is not in Vk, in frame j before its turn by theta"),
    Quantity("b", "six", r"\beta", "", "@,#", r"{}^{j}\boldsymbol{\beta}_{j}", "[14]",
             "centrifugal, gyroscopic and external wrench of body j"),
    Quantity("bs", "six", r"\beta", "*", "@,#", r"{}^{j}\boldsymbol{\beta}^{*}_{j}", "[31], [55]",
             "wrench beta of body j with what the bodies it carries add"),
    Quantity("M", "c", "M", r"\mathrm{c}", "@", "", "[8], [13]", "mass of body j and all it carries"),
    Quantity("MS", "axis", r"\mathit{MS}", "", "@#", r"{}^{j}\mathit{MS}_{j}", "[13]", "first moments of body j"),
    Quantity("MS", "c axis", r"\mathit{MS}", r"\mathrm{c}", "@#", "", "[8], [13]",
             "first moments of body j and all it carries"),
    Quantity("J", "moment", "J", "", "@#", "{}^{j}J_{j}", "[13]", "inertia of body j about the origin of frame j"),
    Quantity("J", "c moment", "J", r"\mathrm{c}", "@#", "", "[8], [13]", "inertia of body j and all it carries"),
    Quantity("dJ", "product", r"\Delta J", "", "@#", "", "[14]", "difference of two moments of inertia of body j"),
    Quantity("Js", "entry", "J", "*", "@,#", r"{}^{j}\mathbf{J}^{*}_{j}", "[32], [56]",
             "articulated inertia of body j and what it carries; at a tip in the frame of K, as w and b there"),
    Quantity("U", "six", "U", "", "@,#", r"{}^{j}\mathbf{J}^{*}_{j}\,{}^{j}\mathbf{a}_{j}", "[28], [50]",
             "articulated inertia along the joint axis"),
    Quantity("H", "", "H", "", "@", "", "[28], [50]", "inertia that joint j moves"),
    Quantity("Hinv", "", "H", "-1", "@", "", "[29], [51]", "inverse of the inertia that joint j moves"),
    Quantity("rho", "", r"\rho", "", "@", r"\mathit{Ia}_{j}\,H_{j}^{-1}", "[29]", "share of the rotor in this inertia"),
    Quantity("qdf", "", r"\ddot{q}", "*", "@", r"\Gamma^{*}_{j}\,H_{j}^{-1}", "[30], [34]",
             "acceleration of joint j where its antecedent has none"),
    Quantity("UH", "six", r"\overline{U_{@,#}H_{@}^{-1}}", "", "",
             r"{}^{j}\mathbf{J}^{*}_{j}\,{}^{j}\mathbf{a}_{j}\,H_{j}^{-1}", "[29], [51]",
             "articulated inertia along the joint axis, over the inertia that joint j moves"),
    Quantity("K", "entry", "K", "", "@,#", r"{}^{j}\mathbf{K}_{j}", "[29], [51], [53]",
             "what its antecedent feels of this articulated inertia, in frame j before its turn by theta"),
    Quantity("al", "six", r"\boldsymbol{\alpha}", "", "@,#", r"{}^{j}\boldsymbol{\alpha}_{j}", "[30], [52], [54]",
             "wrench at joint j that does not depend on the acceleration of its antecedent, in the frame of K"),
    Quantity("f", "six", "f", "", "@,#", r"{}^{j}\mathbf{f}_{j}", "[15], [35], [58]",
             "wrench of the antecedent on body j"),
    Quantity("A", "place", "A", "", "@,#", r"\mathbf{A}", "[8]", "entry j, i of the inertia matrix", "dtau_dq"),
    Quantity("A", "place", "A", "", "@,#", r"\mathbf{A}", "[8]", "entry j, i of the inertia matrix", "dqdd_dq"),
    Quantity("A", "place", "A", "", "@,#", r"\mathbf{A}", "[8]", "entry j, i of the inertia matrix", "dqdd_dp"),
    Quantity("Pc", "axis", "P", r"\mathrm{c}", "@,#", "", "",
             "twice the momentum of body j and all it carries, seen from one that moves with the origin of frame j"),
    Quantity("Qc", "entry", "Q", r"\mathrm{c}", "@,#", "", "",
             "twice the moment of Coriolis forces on body j and all it carries, by how they turn"),
    Quantity("Fb", "six", "F", "", "@,#", "", "[12]", "wrench that gives body j alone its acceleration"),
    Quantity("Fa", "row column", "F", r"\mathrm{a}", "@,#", "", "[15]",
             "wrench that accelerates all beyond joint j along it, in frame i"),
    Quantity("Fh", "row column", "F", r"\mathrm{h}", "@,#", "", "[15]",
             "torque of joint j by how joint i makes all beyond it turn, in frame i"),
    Quantity("Fq", "row column", "F", "q", "@,#", "", "[15]",
             "change of the wrench on body i by that of the variable of joint j"),
    Quantity("Fv", "row column", "F", r"\dot{q}", "@,#", "", "[15]",
             "change of the wrench on body i by that of the velocity of joint j"),
    Quantity("Gq", "place", r"\partial_{q}\bar{\Gamma}", "", "@,#", "", "[15]",
             "derivative of what moves joint j by the variable of joint i"),
    Quantity("Gv", "place", r"\partial_{\dot{q}}\bar{\Gamma}", "", "@,#", "", "[15]",
             "derivative of what moves joint j by the velocity of joint i"),
    Quantity("qddq", "number", r"\partial_{q}\ddot{q}", "", "@,#", "", "[11]",
             "derivative of the acceleration of joint j by the variable of joint i"),
    Quantity("qddv", "number", r"\partial_{\dot{q}}\ddot{q}", "", "@,#", "", "[11]",
             "derivative of the acceleration of joint j by the velocity of joint i"),
    Quantity("qddt", "number", r"\partial_{\Gamma}\ddot{q}", "", "@,#", "", "[11]",
             "derivative of the acceleration of joint j by the torque of joint i"),
)
# fmt: on
FUNCTIONS = {"sin": r"\mathrm{S}", "cos": r"\mathrm{C}", "sign": r"\mathrm{sign}"}
RESULTS = {
    "qdd": r"\ddot{q}",
    "tau": r"\Gamma",
    "A": "A",
    "H": "H",
    "T": "T",
    "V": "V",
    "Vd": r"\dot{V}",
    "J": "J",
    "f": "f",
    "E": "E",
    "Y": "Y",
    "h": "h",
    "X": "X",
    "q": "q",
    "qd": r"\dot{q}",
    "singularity": r"\Delta",
}
# Derivatives: of what and by what, `x_0` being the pose of a floating base.
ROWS = {"tau": r"\Gamma", "qdd": r"\ddot{q}", "V0d": r"\dot{V}_{0}", "f0": " f_{0}"}
COLUMNS = {
    "q": " q",
    "qd": r"\dot{q}",
    "qdd_motor": r"\ddot{q}",
    "tau": r"\Gamma",
    "p": " p",
    "pose": " x_{0}",
    "V0": " V_{0}",
    "V0d": r"\dot{V}_{0}",
    "f0": " f_{0}",
}
RESULTS |= {
    f"d{of}_d{by}": rf"[\partial{row}/\partial{column}]" for of, row in ROWS.items() for by, column in COLUMNS.items()
}
# Models whose results are seen from the base where nothing else is said, unlike what they are made of.
FROM_BASE = ("geometric_model", "jacobian_dot_qd")
# Results whose columns follow the joints that move, their own rows, or the motors.
BY_JOINT = ("J", *(f"d{of}_d{by}" for of in ROWS for by in ("q", "qd")))
BY_ROW = ("A",)
DERIVATIVE = tuple(f"d{of}_d" for of in ROWS)
BY_MOTOR = tuple(f"d{of}_d{by}" for of in ROWS for by in ("qdd_motor", "tau"))
_LETTERS = """
    alpha beta gamma delta epsilon zeta eta theta kappa mu nu xi rho sigma tau phi chi psi omega
    Gamma Delta Theta Lambda Xi Sigma Phi Psi Omega
"""
GREEK = frozenset(_LETTERS.split())


@cache
def _pattern(component: str) -> re.Pattern[str]:
    return re.compile(rf"(?P<j>\d+){COMPONENTS[component][0]}(?P<part>[a-z]*)", re.ASCII)


_BY_NAME: dict[str, list[Quantity]] = {}
for _row in TABLE:
    _BY_NAME.setdefault(_row.name, []).append(_row)


@dataclass(frozen=True)
class Meaning:
    """A line of the list of symbols."""

    symbol: str
    paper: str
    equations: str
    meaning: str


class Notation:
    """LaTeX of the names of one program; no two names share a symbol."""

    def __init__(self, program: Program) -> None:
        self.outputs = {output.name for output in program.outputs}
        self.used: set[Quantity] = set()
        self.parts = False
        self.symbols: dict[str, str] = {}
        given = [name for argument in program.inputs for name in argument.symbols]
        assigned = [s.name for s in (*program.once, *program.statements)]
        self._users, self._assigned = {*given, *program.used}, set(assigned)
        self._claim({name: self.quantity(name) for name in (*assigned, *given)})
        self._claim({name: user_symbol(name) for name in (*given, *sorted(program.used), *assigned)})

    def __getitem__(self, name: str) -> str:
        if name not in self.symbols:
            self._claim({name: self.quantity(name) or user_symbol(name)})
        return self.symbols[name]

    def _claim(self, wanted: Mapping[str, str]) -> None:
        taken = set(self.symbols.values())
        for name, symbol in wanted.items():
            if symbol and name not in self.symbols:
                self.symbols[name] = literal(name) if symbol in taken else symbol
                taken.add(self.symbols[name])

    def quantity(self, name: str) -> str:
        """Symbol of a quantity of the table; empty for any other name."""
        function, _, argument = name.partition("_")
        if function in FUNCTIONS and argument in self._users | self._assigned:
            return f"{FUNCTIONS[function]}_{{{self.quantity(argument) or user_symbol(argument)}}}"
        if function == "by":
            return self._derivative(argument)
        if function == "rate":
            return self._coefficient(argument)
        letters = re.match("[A-Za-z]*", name, re.ASCII)[0]  # type: ignore[index]
        for row in _BY_NAME.get(letters, ()):
            found = _pattern(row.component).fullmatch(name, len(letters))
            if found and (not row.output or row.output in self.outputs):
                self.used.add(row)
                self.parts |= bool(found["part"])
                return row.symbol(found["j"], found.groupdict().get("c") or "", found["part"])
        return ""

    def _derivative(self, name: str) -> str:
        """Symbol of a derivative, its variable first: `q2_f3_6` is that of `f3_6` by q2."""
        for variable in self._users:
            quantity = self.quantity(name.removeprefix(f"{variable}_")) if name.startswith(f"{variable}_") else ""
            if quantity:
                return rf"\partial_{{{self.quantity(variable) or user_symbol(variable)}}}{quantity}"
        return ""

    def _coefficient(self, name: str) -> str:
        """Symbol of a coefficient of t^k, k first: `2_f3_6` is that of f3_6 at t^2."""
        order, _, of = name.partition("_")
        quantity = self.quantity(of) or user_symbol(of)
        return rf"[{quantity}]_{{t^{{{order}}}}}"

    def meanings(self) -> Iterator[Meaning]:
        """The quantities that occur, in the order of the table."""
        for row in TABLE:
            if row in self.used:
                yield Meaning(row.symbol(), row.paper, row.equations, row.meaning)


def user_symbol(name: str) -> str:
    r"""Symbol of a name that a user chose: t1 is t_{1}, RL4 \mathit{RL}_{4}, k_tool k_{\mathrm{tool}}."""
    found = re.fullmatch("([A-Za-z]+)(?:_?([0-9]+)|_([A-Za-z]+[0-9]*))?", name, re.ASCII)
    if not found:
        return literal(name)
    letters, number, word = found.groups()
    base = letters if len(letters) == 1 else rf"\{letters}" if letters in GREEK else rf"\mathit{{{letters}}}"
    below = number or (rf"\mathrm{{{word}}}" if word else "")
    return base + (f"_{{{below}}}" if below else "")


def literal(name: str) -> str:
    """A name as it is written in the machine's file."""
    escaped = name.replace("_", r"\_")
    return rf"\mathit{{{escaped}}}"
