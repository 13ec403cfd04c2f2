"""The paper's symbols for the names in a program: one table, read by everything that shows equations.

The paper's left superscript is left out of components: every vector, wrench and inertia of body j
is given in frame j.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from symoro_elastic.symbolic.expression import SYMBOL, Expression
from symoro_elastic.symbolic.program import Program

AXIS, SIX, ENTRY, INERTIA = "([xyz])", "([1-6])", "([1-6]{2})", "(xx|xy|xz|yy|yz|zz)"


@dataclass(frozen=True)
class Quantity:
    """A row of the table: names `<name><j>_<component>`, their symbol, what it is, where it is defined.

    `base`, `above` and `below` are LaTeX in which {j} is the joint and {c} the component, {c[0]}
    its first character. `shown` is the component in the list of symbols, `output` the result that
    a program must have for the row to hold.
    """

    name: str
    component: str
    base: str
    meaning: str
    equations: str
    paper: str = ""
    above: str = ""
    below: str = "{j},{c}"
    shown: str = ""
    output: str = ""

    def symbol(self, joint: str, component: str, part: str = "") -> str:
        """LaTeX of one component; `part` is the letter of a shared part of it."""
        values = {"j": joint, "c": component}
        above = ",".join(x for x in (self.above, rf"\mathrm{{{part}}}" if part else "") if x)
        below = self.below.format(**values)
        return self.base.format(**values) + (f"^{{{above}}}" if above else "") + (f"_{{{below}}}" if below else "")


TABLE = (
    Quantity("qd", "", r"\dot{{q}}", "velocity of joint j", "[3]", r"\dot{q}_{j}", below="{j}"),
    Quantity("qdd", "", r"\ddot{{q}}", "acceleration of joint j", "[34], [59]", r"\ddot{q}_{j}", below="{j}"),
    Quantity("tau", "", r"\Gamma", "torque or force of motor j", "[8], [61]", r"\Gamma_{j}", below="{j}"),
    Quantity(
        "Gamma",
        "",
        r"\bar{{\Gamma}}",
        "what moves joint j: motor, spring and damper, less friction",
        "[9], [17], [61]",
        r"\Gamma_{j}",
        below="{j}",
    ),
    Quantity(
        "cos", "theta", r"\mathrm{{C}}", "cosine of the whole angle of joint j", "[1]", r"\cos\theta_{j}", r"\theta", "{j}"
    ),
    Quantity(
        "sin", "theta", r"\mathrm{{S}}", "sine of the whole angle of joint j", "[1]", r"\sin\theta_{j}", r"\theta", "{j}"
    ),
    Quantity("P", "r", "P", "whole shift along the axis of joint j", "[1]", r"r_{j}", below="{j},{c}", shown="r"),
    Quantity("P", AXIS, "P", "origin of frame j, in frame 0", "[2]", "{}^{0}P_{j}", shown="x"),
    Quantity(
        "A", r"(\d+)", "A", "entry i, j of the inertia matrix", "[8]", r"\mathbf{A}(q)", shown="i", output="A"
    ),
    Quantity("A", "([1-3]{2})", "A", "orientation of frame j in frame 0", "[2]", "{}^{0}A_{j}", shown="mn"),
    Quantity("w", AXIS, r"\omega", "angular velocity of body j", "[3]", r"{}^{j}\omega_{j}", below="{j}{c}", shown="x"),
    Quantity(
        "ww",
        r"xx|yy|zz",
        r"\overline{{\omega_{{{j}{c[0]}}}^{{2}}}}",
        "square of an angular velocity, computed once",
        "[7], [14]",
        below="",
        shown="xx",
    ),
    Quantity(
        "ww",
        "([xyz]{2})",
        r"\overline{{\omega_{{{j}{c[0]}}}\,\omega_{{{j}{c[1]}}}}}",
        "product of angular velocities, computed once",
        "[7], [14]",
        below="",
        shown="xy",
    ),
    Quantity(
        "wd", AXIS, r"\dot{{\omega}}", "angular acceleration of body j", "[6]", r"{}^{j}\dot{\omega}_{j}",
        below="{j}{c}", shown="x",
    ),
    Quantity("v", AXIS, "V", "velocity of the origin of frame j", "[3]", "{}^{j}V_{j}", below="{j}{c}", shown="x"),
    Quantity(
        "vd", AXIS, r"\dot{{V}}", "acceleration of the origin of frame j, gravity subtracted", "[6]",
        r"{}^{j}\dot{V}_{j}", below="{j}{c}", shown="x",
    ),
    Quantity(
        "g", SIX, r"\gamma", "part of the acceleration that depends on velocities only", "[7]",
        r"{}^{j}\boldsymbol{\gamma}_{j}", shown="k",
    ),
    Quantity(
        "b", SIX, r"\beta", "centrifugal and external wrench of body j", "[14]", r"{}^{j}\boldsymbol{\beta}_{j}",
        shown="k",
    ),
    Quantity(
        "bs", SIX, r"\beta", "the same with all that body j carries", "[31], [55]",
        r"{}^{j}\boldsymbol{\beta}^{*}_{j}", "*", shown="k",
    ),
    Quantity("MS", AXIS, r"\mathit{{MS}}", "first moments of body j", "[13]", r"{}^{j}\mathit{MS}_{j}", shown="x"),
    Quantity("J", INERTIA, "J", "inertia of body j about the origin of its frame", "[13]", "{}^{j}J_{j}", shown="xx"),
    Quantity("dJ", "(yz|xz|xy)", r"\Delta J", "difference of two moments of inertia", "[14]", shown="yz"),
    Quantity("M", "c", "M", "mass of body j and all it carries", "[8], [13]", "", "c", "{j}"),
    Quantity(
        "MS", "c_([xyz])", r"\mathit{{MS}}", "first moments of body j and all it carries", "[8], [13]", "", "c", shown="x"
    ),
    Quantity("J", f"c{INERTIA}", "J", "inertia of body j and all it carries", "[8], [13]", "", "c", shown="xx"),
    Quantity(
        "Js", ENTRY, "J", "articulated inertia of body j and all it carries", "[32], [56]",
        r"{}^{j}\mathbf{J}^{*}_{j}", "*", shown="mn",
    ),
    Quantity("U", SIX, "U", "column of the articulated inertia along the joint", "[28], [50]", shown="k"),
    Quantity("H", "", "H", "inertia that joint j sees", "[28], [50]", "H_{j}", below="{j}"),
    Quantity("Hinv", "", "H", "its inverse", "[29], [51]", "H_{j}^{-1}", "-1", "{j}"),
    Quantity("rho", "", r"\rho", "rotor inertia over the inertia that joint j sees", "[29]", r"\mathit{Ia}_{j}\,H_{j}^{-1}", below="{j}"),
    Quantity(
        "UH", SIX, r"\overline{{U_{{{j},{c}}}\,H_{{{j}}}^{{-1}}}}",
        "column of the articulated inertia over the inertia that joint j sees, computed once",
        "[29], [51]", r"{}^{j}\mathbf{J}^{*}_{j}\,{}^{j}\mathbf{a}_{j}\,H_{j}^{-1}", below="", shown="k",
    ),
    Quantity(
        "K", ENTRY, "K", "articulated inertia that body j shows its antecedent", "[29], [51], [53]",
        r"{}^{j}\mathbf{K}_{j}", shown="mn",
    ),
    Quantity(
        "al", SIX, r"\boldsymbol{{\alpha}}", "wrench of joint j where its antecedent has no acceleration",
        "[30], [52], [54]", r"{}^{j}\boldsymbol{\alpha}_{j}", shown="k",
    ),
    Quantity(
        "f", SIX, "f", "wrench that the antecedent exerts on body j", "[15], [35], [58]", r"{}^{j}\mathbf{f}_{j}", shown="k"
    ),
)
