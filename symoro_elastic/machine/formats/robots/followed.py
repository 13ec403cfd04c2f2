"""Joints that follow others, as coupled rows of the table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from numpy.polynomial import Polynomial

from symoro_elastic.errors import InputError
from symoro_elastic.machine.formats.robots.description import JointType, LinkJoint, Mimicked
from symoro_elastic.machine.formats.robots.rows import number_cell
from symoro_elastic.machine.formats.robots.tree import Tree
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.names import did_you_mean, quoted


@dataclass(frozen=True)
class Followers:
    """The joints of a robot that follow others."""

    tree: Tree
    source: str

    def leader(self, joint: LinkJoint) -> Mimicked:
        """The joint with a variable of its own that a joint follows, through others that follow it too.

        Raises `InputError` for one that follows itself, or no joint that moves.
        """
        joints = {one.name: one for one in self.tree.description.joints}
        found, seen = joint.follows, [joint.name]
        assert found is not None
        while True:
            if found.joint not in joints:
                what = f"it mimics {quoted(found.joint)}, which is no joint{did_you_mean(found.joint, joints)}"
                raise self._wrong(joint, what)
            leader = joints[found.joint]
            if leader.name in seen:
                raise self._wrong(joint, f"it mimics {quoted(leader.name)}, which mimics it: break the cycle")
            if leader.type in (JointType.FIXED, JointType.FLOATING):
                raise self._wrong(joint, f"it mimics {quoted(leader.name)}, which has no variable of its own")
            if not any((found.multiplier, *found.powers)):
                raise self._wrong(joint, "its multiplier is 0: a joint that does not move is fixed")
            if leader.follows is None:
                return found
            seen.append(leader.name)
            found = _composed(found, leader.follows)

    def cell(self, joint: LinkJoint, offset: Formula, variables: Mapping[str, str]) -> Formula:
        """The cell of a joint that follows another: a polynomial of that variable, and the offset of the joint."""
        leader = self.leader(joint)
        types = {one.name: one.type for one in self.tree.description.joints}
        variable = variables[leader.joint]
        if abs(leader.multiplier) == 1.0 and types[leader.joint] is joint.type:
            text = variable if leader.multiplier > 0 else f"-{variable}"
        else:
            text = f"{number_cell(leader.multiplier)}*{variable}"
        first = [text] if leader.multiplier else []
        powers = [f"({number_cell(x)})*{variable}^{k}" for k, x in enumerate(leader.powers, start=2) if x]
        terms = [term for term in (offset, number_cell(leader.offset)) if not term.is_zero]
        constants = [f"({term})" if term.text[0] == "-" else term.text for term in terms]
        return Formula.parse(" + ".join([*first, *powers, *constants]))

    def _wrong(self, joint: LinkJoint, what: str) -> InputError:
        return InputError(self.source, f"joint {quoted(joint.name)}", what)


def _composed(outer: Mimicked, inner: Mimicked) -> Mimicked:
    """What a joint follows through another one that follows it."""
    law, of = (Polynomial([one.offset, one.multiplier, *one.powers]) for one in (outer, inner))
    offset, multiplier, *powers = map(float, law(of).coef)
    return Mimicked(inner.joint, multiplier, offset, tuple(powers))
