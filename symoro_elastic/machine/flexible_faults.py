"""What is wrong with flexible bodies of a machine, and with the rows that are their modes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import chain

import numpy as np

from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.flexible import FlexibleBody
from symoro_elastic.machine.joints import SELECTED, Joint, Kind
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import quote

SAME = 1e-9
"""Of the largest entry of Mee: how far it may be from symmetric, and its eigenvalues below zero."""
PLACED = ("gamma", "b", "alpha", "d", "theta", "r")


def flexible_faults(machine: Machine) -> Iterator[tuple[str, str]]:
    """Places and faults of flexible bodies: modes are bare elastic rows on the row of their body, which carry nothing.

    Models know the deflection, spring, damper and friction of a mode; what else its row had would be left out.
    """
    rows = machine.rows
    owner: dict[str, str] = {}
    for body in machine.flexible:
        place = f"flexible body {body.joint}"
        if body.joint not in rows:
            yield place, "the machine has no such row"
            continue
        if fault := _fault_of_masses(body):
            yield f"{place}, Mee", fault
        for name in body.modes:
            what = "the machine has no such row" if name not in rows else _fault_of_mode(machine, rows, name, body)
            if other := owner.get(name):
                what = f"it is a mode of {other} already: a row is one mode"
            if what:
                yield f"{place}, mode {quote(name)}", what
            owner[name] = body.joint


def _fault_of_masses(body: FlexibleBody) -> str:
    Mee = np.array(body.Mee, dtype=float)
    if np.abs(Mee - Mee.T).max(initial=0.0) > SAME * np.abs(Mee).max(initial=0.0):
        return "is not symmetric"
    sizes = np.sqrt(np.maximum(np.diag(Mee), 0.0))
    if not sizes.all() or (len(Mee) and np.linalg.eigvalsh(Mee / np.outer(sizes, sizes)).min() <= SAME):
        return "is not positive definite: modes without mass, or which are sums of others, have no accelerations"
    return ""


def _fault_of_mode(machine: Machine, rows: Mapping[str, int], name: str, body: FlexibleBody) -> str:
    """Why a row cannot be a mode of a flexible body; empty where it can."""
    j = rows[name]
    joint = machine.joint(j)
    if joint.kind not in (Kind.ELASTIC, Kind.FIXED):
        return f"the row is {joint.kind}: a mode is elastic"
    if joint.antecedent != rows[body.joint]:
        return f"its antecedent is not the row of the body: write antecedent = {quote(body.joint)}"
    if cell := _cell_of_more(joint):
        return f"it has {cell}, which a mode has not: masses are integrals of the body; leave it out"
    carried = [x.name for x in machine.joints if x.antecedent == j]
    carried += [x.name for x in machine.frames if x.on == name]
    carried += [loop.name for loop in machine.loops if j in (loop.cut, loop.meets)]
    ends = "the row of an interface, as NAME_end of a beam"
    return f"its row carries {quote(carried[0])}, but has no place: name {ends}" if carried else ""


def _cell_of_more(joint: Joint) -> str:
    """The first cell of a mode's row that a mode cannot have; empty where there is none."""
    if not joint.rotor_inertia.is_zero:
        return "rotor_inertia"
    for cell, formula in chain(cells(joint.body), cells(joint.wrench)):
        if not formula.is_zero:
            return cell.label
    for key in PLACED[: 4 if joint.kind is Kind.FIXED else 6]:
        formula = getattr(joint, key)
        if not formula.is_zero and (key != SELECTED.get(joint.sigma) or str(formula) != str(joint.variable)):
            return f"{key} = {formula}"
    return ""
