"""Frames of a machine by their names: every text that names a frame is read here."""

from __future__ import annotations

from symoro_elastic.machine.free_base import row_of_base
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Point, RequestedPart
from symoro_elastic.quantities.frames import BASE, JOINT, frame_names


class FrameNames:
    """Names and numbers of the frames of a machine: 0, and those of its joints.

    Where frame 0 is a choice (`or_frame_0`) `base` is frame 0, whatever joints are called; elsewhere it is the body of
    a base that is given coordinates, else the joint of that name. `joint NAME` is a joint everywhere. With
    `by_any_name` joints may be called by their variables and numbers, too; a joint's own name comes before the
    variable of another.
    """

    def __init__(self, machine: Machine, by_any_name: bool = False) -> None:
        own = {joint.name: j for j, joint in enumerate(machine.joints, start=1)}
        numbers = {str(j): j for j in own.values()}
        variables = {joint.variable: own[joint.name] for joint in machine.joints if joint.variable}
        self.own, self.joints = own, {**numbers, **variables, **own} if by_any_name else own
        self._base = row_of_base(machine)
        self._names = frame_names(own)

    def number(self, text: str, or_frame_0: bool = False) -> int | None:
        """Return the number of a frame; None where there is none of this name."""
        if or_frame_0 and text == BASE:
            return 0
        if self._base and text == BASE:
            return self._base
        named, _, joint = text.partition(JOINT)
        return self.joints.get(text) if named or not joint else self.own.get(joint.strip())

    def name(self, number: int) -> str:
        """Return the name of a frame, which `number` reads; frame 0 has one of its own."""
        return self._names[number]

    def in_base(self, number: int, at: Point | None = None) -> str:
        """Return the request for a frame, or a point of its body, seen from frame 0."""
        return str(RequestedPart(self.name(number), at, self.name(0)))

    def choices(self, or_frame_0: bool = False) -> list[str]:
        """Return what a message may propose: names and variables of joints, the base."""
        return [*(text for text in self.joints if not text.isdecimal()), *([BASE] if or_frame_0 else [])]
