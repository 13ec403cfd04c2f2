"""Equality constraints of a compiled MJCF model: joints that follow others, and connections that close loops."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from numpy.polynomial import Polynomial

from symoro_elastic.machine.formats.robots.description import Connection, Mimicked, Placement
from symoro_elastic.machine.formats.robots.mjcf_bodies import Bodies
from symoro_elastic.machine.formats.robots.mjcf_forces import Forces
from symoro_elastic.machine.names import quoted

CONNECT, WELD, JOINT = "mjEQ_CONNECT", "mjEQ_WELD", "mjEQ_JOINT"


@dataclass(frozen=True, eq=False)
class Equalities:
    """The equality constraints of a model that are in force."""

    bodies: Bodies
    forces: Forces

    @cached_property
    def followers(self) -> dict[int, Mimicked | float]:
        """By the number of a joint: the joint that it follows, or the position, rad or m, at which it is held."""
        found: dict[int, Mimicked | float] = {}
        for e in self._of(JOINT):
            first, second = int(self._model.eq_obj1id[e]), int(self._model.eq_obj2id[e])
            law = self._law(e, first, second)
            if second >= 0 and self._is_led_by_first(first, second, law):
                first, second = second, first
                law = Polynomial([-law.coef[0] / law.coef[1], 1 / law.coef[1]])
            if first in found:
                what = f"equality constraints {quoted(self.name(e))} and others give its position: leave one"
                raise self.bodies.compiled.error(f"joint {quoted(self.bodies.joint_names[first])}", what)
            found[first] = self._following(first, second, law)
        return found

    @cached_property
    def connections(self) -> tuple[Connection, ...]:
        """What holds bodies of the robot together, or to the world."""
        return tuple(one for e in self._of(CONNECT, WELD) if (one := self._connection(e)))

    @cached_property
    def left_out(self) -> tuple[str, ...]:
        """Names of the constraints that are not taken: of tendons, to bodies that are not taken, and not in force."""
        taken = set(self._of(JOINT)) | {e for e in self._of(CONNECT, WELD) if self._connection(e)}
        return tuple(self.name(e) for e in range(self._model.neq) if e not in taken)

    def name(self, e: int) -> str:
        """The name of a constraint; its type and number where the file gives none."""
        given = [self._model.equality(k).name for k in range(self._model.neq)]
        return given[e] or f"{self._type(e).removeprefix('mjEQ_').lower()}{e + 1}"

    @property
    def _model(self) -> Any:
        return self.bodies.model

    def _type(self, e: int) -> str:
        name: str = self.bodies.compiled.mujoco.mjtEq(self._model.eq_type[e]).name
        return name

    def _of(self, *types: str) -> Iterator[int]:
        """Numbers of the constraints of some types that are in force."""
        if not self.forces.off("EQUALITY") and not self.forces.off("CONSTRAINT"):
            yield from (e for e in range(self._model.neq) if self._type(e) in types and self._model.eq_active0[e])

    def _law(self, e: int, first: int, second: int) -> Polynomial:
        """The position of the first joint as a polynomial of that of the second."""
        own, other = (float(self._model.qpos0[self._model.jnt_qposadr[j]]) if j >= 0 else 0.0 for j in (first, second))
        coefficients = self._model.eq_data[e][: 5 if second >= 0 else 1]
        law: Polynomial = Polynomial(coefficients)(Polynomial([-other, 1.0])) + own
        return law.trim()

    def _is_led_by_first(self, first: int, second: int, law: Polynomial) -> bool:
        """Whether the second joint is to follow: the first has the motor or the spring, and the law is linear."""
        acted = [bool(self.forces.actuators.get(j)) or self._model.jnt_stiffness[j] > 0 for j in (first, second)]
        return acted == [True, False] and law.degree() == 1

    def _following(self, first: int, second: int, law: Polynomial) -> Mimicked | float:
        name = self.bodies.joint_names[first]
        if self._model.jnt_stiffness[first] > 0 and not self.forces.off("SPRING"):
            what = "it has a spring and follows another joint: move the spring to that joint"
            raise self.bodies.compiled.error(f"joint {quoted(name)}", what)
        if second < 0 or law.degree() == 0:
            return float(law.coef[0])
        offset, multiplier, *powers = map(float, law.coef)
        return Mimicked(self.bodies.joint_names[second], multiplier, offset, tuple(powers))

    def _connection(self, e: int) -> Connection | None:
        """A connection of two links; None where a body is not taken, or where both are one."""
        ends = self._ends(e)
        if ends is None or ends[0][0] == ends[1][0]:
            return None
        (first, on_first), (second, on_second) = ends
        return Connection(self.name(e), first, second, on_first, on_second, weld=self._type(e) == WELD)

    def _ends(self, e: int) -> tuple[tuple[str, Placement], tuple[str, Placement]] | None:
        """The link of each of the two frames that coincide, and the placement of the frame there."""
        model, data = self._model, self._model.eq_data[e]
        objects = int(model.eq_obj1id[e]), int(model.eq_obj2id[e])
        if model.eq_objtype[e] == self.bodies.compiled.mujoco.mjtObj.mjOBJ_SITE:
            owners = [int(model.site_bodyid[s]) for s in objects]
            frames = [Placement(self.bodies.rotation(model.site_quat[s]), model.site_pos[s].copy()) for s in objects]
        elif self._type(e) == WELD:
            owners, frames = [*objects], [Placement(self.bodies.rotation(data[6:10]), data[3:6].copy()), Placement()]
        else:
            owners = [*objects]
            frames = [Placement(translation=data[:3].copy()), Placement(translation=data[3:6].copy())]
        places = [self.bodies.place(b) for b in owners]
        if places[0] is None or places[1] is None:
            return None
        (first, a), (second, b) = places[0], places[1]
        return (first, a * frames[0]), (second, b * frames[1])
