"""Transmissions in URDF: the rotors behind joints, and what of them a model cannot take."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from xml.etree.ElementTree import Element

from symoro_elastic.errors import InputError
from symoro_elastic.machine.formats.robots.description import JointType, LinkJoint
from symoro_elastic.machine.formats.robots.xml_text import numbers
from symoro_elastic.machine.names import listed, quoted

ROTOR, RATIO = "drake:rotor_inertia", "drake:gear_ratio"


class Rotors:
    """The transmissions of a robot, by the joints that they drive."""

    def __init__(self, robot: Element, source: str) -> None:
        self.source = source
        self.by_joint: dict[str, Element] = {}
        for transmission in robot.findall("transmission"):
            for joint in transmission.findall("joint"):
                self.by_joint.setdefault(joint.get("name", ""), transmission)

    def inertia(self, joint: str) -> float:
        """Inertia of the rotor as the joint feels it: that of Drake's elements, by the square of the gear ratio."""
        actuator = self._actuator(joint)
        if actuator is None or actuator.find(ROTOR) is None:
            return 0.0
        inertia, ratio = (self._value(actuator, tag, joint) for tag in (ROTOR, RATIO))
        if inertia < 0:
            raise InputError(self.source, f"joint {quoted(joint)}", f"its rotor inertia is negative: {inertia:g}")
        return inertia * ratio * ratio

    def remarks(self, joints: Iterable[LinkJoint]) -> Iterator[str]:
        """That reductions are not applied, and that joints without transmission have motors all the same."""
        own = [j.name for j in joints if j.type is not JointType.FIXED and j.follows is None]
        reduced = [name for name in own if self._is_reduced(name) and not self.inertia(name)]
        if reduced:
            yield (
                "motor torques are those on the joints: mechanicalReduction is not applied, and no rotor inertia is "
                f"known; give it in [motors] ({listed(reduced)})"
            )
        without = [name for name in own if name not in self.by_joint]
        if self.by_joint and without:
            yield f'no transmission drives {listed(without)}: motors here; kind = "passive" takes them off'

    def _actuator(self, joint: str) -> Element | None:
        transmission = self.by_joint.get(joint)
        return None if transmission is None else transmission.find("actuator")

    def _value(self, actuator: Element, tag: str, joint: str) -> float:
        found = actuator.find(tag)
        return 1.0 if found is None else numbers(found, "value", None, 1, self.source, f"joint {quoted(joint)}")[0]

    def _is_reduced(self, joint: str) -> bool:
        transmission = self.by_joint.get(joint)
        texts = [] if transmission is None else [e.text or "" for e in transmission.iter("mechanicalReduction")]
        return any(text.strip() not in ("", "1", "1.0") for text in texts)
