"""Springs beside motors: a joint of their own about the same axis, welded to what the motor moves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from symoro_elastic.machine.formats.robots.description import Connection, Description, Link, LinkJoint, Placement
from symoro_elastic.machine.names import distinct, listed

SPRING, CARRIED = "_spring", "_sprung"


def with_springs_beside(description: Description) -> Description:
    """The robot whose joints have a motor or a spring, not both.

    A spring beside a motor is an elastic joint of a link without mass. A connection welds it to the link of the motor,
    so its position is that of the motor's joint. Damping stays with the motor.
    """
    both = [joint for joint in description.joints if joint.driven and joint.stiffness]
    taken = {joint.name for joint in description.joints} | {link.name for link in description.links}
    links, joints, connections = [], [], []
    for joint in both:
        spring, link = distinct(joint.name + SPRING, taken), distinct(joint.name + CARRIED, taken)
        links.append(Link(link, frame_only=False))
        forces = LinkJoint(spring, joint.type, joint.parent, link, stiffness=joint.stiffness, neutral=joint.neutral)
        joints.append(replace(forces, placement=joint.placement, axis=joint.axis, driven=False))
        connections.append(
            Connection(link, joint.child, link, Placement(), Placement(), weld=True, dependent=(spring,))
        )
    return replace(
        description,
        links=(*description.links, *links),
        joints=(*map(_without_spring, description.joints), *joints),
        connections=(*description.connections, *connections),
        remarks=(*description.remarks, *_remarks(both)),
    )


def _remarks(both: Sequence[LinkJoint]) -> Iterator[str]:
    if both:
        what = "springs beside motors are elastic joints of their own, each in a loop with the joint of its motor"
        yield f"{what}: {listed(joint.name for joint in both)}"


def _without_spring(joint: LinkJoint) -> LinkJoint:
    """The joint of the motor, which has the spring beside it."""
    if not (joint.driven and joint.stiffness):
        return joint
    return replace(joint, stiffness=0.0, neutral=0.0)
