"""A description as a tree: what moves together, and in which order joints stand in the table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

from symoro_elastic.formats.robots.robot import Description, JointType, Link, LinkJoint, Placement
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import MOST_JOINTS
from symoro_elastic.machine.names import did_you_mean, quote


@dataclass(frozen=True, eq=False)
class Carried:
    """What moves a link: its joint, None where it stands on the base, and its placement in the frame of that joint."""

    joint: LinkJoint | None
    placement: Placement


@dataclass(frozen=True, eq=False)
class Tree:
    """The links and joints of a description, known to be one tree.

    `root` is the link that carries all others, `frame_0` the link whose frame is frame 0: the root, or the link that
    floats in it by the joint `floating`.
    """

    description: Description
    root: str
    children: dict[str, list[LinkJoint]]
    floating: LinkJoint | None = None

    @property
    def frame_0(self) -> str:
        """The link whose frame is frame 0."""
        return self.floating.child if self.floating else self.root

    @cached_property
    def joints(self) -> tuple[LinkJoint, ...]:
        """The joints beyond frame 0, fixed ones too: each before those that it carries, branch by branch."""
        found: list[LinkJoint] = []
        waiting = self.children[self.frame_0][::-1]
        while waiting:
            found.append(waiting.pop())
            waiting += self.children[found[-1].child][::-1]
        return tuple(found)

    @cached_property
    def moving(self) -> tuple[LinkJoint, ...]:
        """The joints that move, in this order."""
        return tuple(joint for joint in self.joints if joint.type is not JointType.FIXED)

    @cached_property
    def carrying(self) -> dict[str, Carried]:
        """The joint that moves each link, and where the link is in the frame of that joint."""
        found = {self.frame_0: Carried(None, Placement())}
        for joint in self.joints:
            parent = found[joint.parent]
            fixed = joint.type is JointType.FIXED
            found[joint.child] = (
                Carried(parent.joint, parent.placement * joint.placement) if fixed else (Carried(joint, Placement()))
            )
        return found

    def seat(self, joint: LinkJoint) -> Placement:
        """Placement of a joint's frame at position 0 in the frame of the joint that moves its parent."""
        return self.carrying[joint.parent].placement * joint.placement

    def carrier(self, joint: LinkJoint) -> LinkJoint | None:
        """The joint that moves the parent of a joint; None on the base."""
        return self.carrying[joint.parent].joint

    @cached_property
    def carried_joints(self) -> dict[str, list[LinkJoint]]:
        """The joints that each joint carries without another between, the one that carries most first."""
        found: dict[str, list[LinkJoint]] = {joint.name: [] for joint in self.moving}
        weight = Counter({joint.name: 1 for joint in self.moving})
        for joint in reversed(self.moving):
            if carrier := self.carrier(joint):
                weight[carrier.name] += weight[joint.name]
        for joint in self.moving:
            if carrier := self.carrier(joint):
                found[carrier.name].append(joint)
        return {name: sorted(joints, key=lambda one: -weight[one.name]) for name, joints in found.items()}

    @cached_property
    def leaves(self) -> tuple[LinkJoint, ...]:
        """Fixed joints to links that carry nothing (tools, cameras), in the order of the joints that carry them."""
        fixed = [j for j in self.joints if j.type is JointType.FIXED and not self.children[j.child]]
        order = {joint.name: k for k, joint in enumerate(self.moving)}
        return tuple(sorted(fixed, key=lambda joint: order[carrier.name] if (carrier := self.carrier(joint)) else -1))

    @cached_property
    def _links_by_joint(self) -> dict[str, list[tuple[Link, Placement]]]:
        found: dict[str, list[tuple[Link, Placement]]] = {}
        for link in self.description.links:
            if carried := self.carrying.get(link.name):
                found.setdefault(carried.joint.name if carried.joint else "", []).append((link, carried.placement))
        return found

    def links_on(self, joint: LinkJoint | None) -> list[tuple[Link, Placement]]:
        """The links that move with a joint, or with frame 0, and their placements in its frame."""
        return self._links_by_joint.get(joint.name if joint else "", [])


def tree_of(description: Description, source: str) -> Tree:
    """The tree of a description; raises `InputError` that names links and joints which make none."""
    links = [link.name for link in description.links]
    _refuse_twice("link", links, source)
    _refuse_twice("joint", [joint.name for joint in description.joints], source)
    children: dict[str, list[LinkJoint]] = {name: [] for name in links}
    above: dict[str, LinkJoint] = {}
    for joint in description.joints:
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in children:
                raise _wrong(source, joint, f"its {role} {quote(name)} is not a link{did_you_mean(name, children)}")
        if other := above.get(joint.child):
            what = f"its child {quote(joint.child)} is the child of joint {quote(other.name)} too: no closed loops"
            raise _wrong(source, joint, what)
        above[joint.child] = joint
        children[joint.parent].append(joint)
    root = _root(links, above, source)
    floating = _floating(description.joints, root, children, source)
    tree = Tree(description, root, children, floating)
    count = len(tree.moving) + len(tree.leaves)
    if count > MOST_JOINTS:
        raise InputError(source, "robot", f"{count} joints that move and leaves: at most {MOST_JOINTS} can be modelled")
    return tree


def _root(links: list[str], above: dict[str, LinkJoint], source: str) -> str:
    """The link that carries all others; raises `InputError` where several do, or links are in a cycle."""
    if not links:
        raise InputError(source, "robot", "it has no link")
    roots = [name for name in links if name not in above]
    if len(roots) > 1:
        shown = ", ".join(map(quote, roots[:5])) + (" ..." if len(roots) > 5 else "")
        raise InputError(source, "links", f"{shown} are not children of a joint: one link must carry all others")
    cycle = _cycle(links, above)
    if cycle:
        around = " to ".join(map(quote, cycle[:6]))
        raise _wrong(source, above[cycle[0]], f"the links {around} are in a cycle: a robot is a tree")
    return roots[0]


def _cycle(links: Iterable[str], above: Mapping[str, LinkJoint]) -> list[str]:
    """Links that carry each other around, from parents to children; none in a tree."""
    clear: set[str] = set()
    for name in links:
        chain: dict[str, None] = {}
        one = name
        while one in above and one not in clear and one not in chain:
            chain[one] = None
            one = above[one].parent
        if one in chain:
            return [one, *reversed([*chain][[*chain].index(one) :])]
        clear.update(chain)
    return []


def _floating(
    joints: Iterable[LinkJoint], root: str, children: dict[str, list[LinkJoint]], source: str
) -> LinkJoint | None:
    """The joint by which the robot floats in its root."""
    found = [joint for joint in joints if joint.type is JointType.FLOATING]
    for joint in found:
        if joint.parent != root or len(children[root]) > 1:
            what = "a floating joint is for the base: that of the only child of the root link; elsewhere use six joints"
            raise _wrong(source, joint, what)
    return found[0] if found else None


def _refuse_twice(what: str, names: list[str], source: str) -> None:
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise InputError(source, f"{what} {quote(twice[0])}", "the name is given twice: choose another")


def _wrong(source: str, joint: LinkJoint, what: str) -> InputError:
    return InputError(source, f"joint {quote(joint.name)}", what)
