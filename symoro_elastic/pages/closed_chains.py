"""Couplings and loops of a machine as `show` prints them: lines of text, and the same as plain data for `--json`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.driving import drive, independent_motors
from symoro_elastic.models.joint_axes import PlacedMachine
from symoro_elastic.models.loops.description import DescribedLoop, described_loops, singular_starts
from symoro_elastic.models.rotors import CHANGE, Rotor, rotors

GYROSCOPIC = (
    "rotors behind gears: from these speeds on of the joints named, rad/s (slides: m/s), the gyroscopic moment of a\n"
    f"rotor, which rotor_inertia leaves out, changes an acceleration by {100 * CHANGE:g} %: of\n"
    "1 rad/s2 (m/s2) and what these speeds cause"
)


@dataclass(frozen=True)
class ClosedChain:
    """What joints of a machine depend on: its loops, rotors, and how many freedoms its motors drive."""

    machine: Machine
    loops: list[DescribedLoop]
    rotors: list[Rotor]
    driven: int

    @property
    def warnings(self) -> list[str]:
        """A line for each loop that starts next to a singular position."""
        return singular_starts(self.loops)


def closed_chain(machine: Machine, placed: PlacedMachine) -> ClosedChain:
    """Return what there is to say about couplings and loops of a machine at a position."""
    driven = len(machine.motors)
    if machine.loops:
        bound = Bound(machine)
        driven = len(independent_motors(bound, {m: bound.coordinates.S_x[m] for m in bound.motors}))
    return ClosedChain(machine, described_loops(machine), rotors(machine, placed.q), driven)


def closed_chain_lines(found: ClosedChain) -> Iterator[str]:
    """Lines about couplings, loops, rotors and motors; none for a tree without them."""
    machine = found.machine
    if machine.is_coupled:
        yield ""
        yield f"independent variables (q): {_variables(machine, machine.independent)}"
        if machine.dependent:
            argument = (
                "q_dep, of assemble" if any(loop.plan.is_assembled for loop in found.loops) else "by closed forms"
            )
            yield f"dependent variables ({argument}): {_variables(machine, machine.dependent)}"
        yield f"motors (tau): {', '.join(joint.name for joint in machine.motor_joints) or 'none'}"
    if found.driven < len(machine.motors):
        yield f"{drive(len(machine.motors), found.driven)}: {_sharing(machine)}"
    for loop in found.loops:
        yield from _loop_lines(machine, loop)
    if found.rotors:
        yield ""
        yield GYROSCOPIC
    yield from (_rotor_line(rotor) for rotor in found.rotors if not math.isinf(rotor.speed))
    idle = [f"{rotor.joint}{_body(rotor)}" for rotor in found.rotors if math.isinf(rotor.speed)]
    if idle:
        yield f"  at no speed, because the moment acts on no moving joint, or others change more: {', '.join(idle)}"


def _variables(machine: Machine, joints: Iterable[int]) -> str:
    return ", ".join(f"{machine.joint(j).variable} of {machine.joint(j).name}" for j in joints) or "none"


def _sharing(machine: Machine) -> str:
    shares = {joint.name: str(joint.sharing) for joint in machine.motor_joints if not joint.sharing.is_zero}
    if not shares:
        return "their torques are not determined; give sharing"
    return f"they share torques as {', '.join(f'{name} {share}' for name, share in shares.items())}"


def _loop_lines(machine: Machine, found: DescribedLoop) -> Iterator[str]:
    loop = found.plan.loop
    cut, end = machine.joint(loop.cut), machine.joint(loop.meets)
    yield ""
    yield f"loop {loop.name}: {cut.name} meets {end.name}{_closing(cut, loop.closes.value)}; {found.plan.form.value}"
    for name, text in found.maps.items():
        yield f"  {name} = {text}"
    yield f"  branch of start: {', '.join(f'{name} = {x + 0.0:.4g}' for name, x in found.start.items())}"
    if found.found:
        positions = ", ".join(f"{name} = {x + 0.0:.4g}" for name, x in found.found.items())
        yield f"  found, as start does not give them: {positions}"
    yield f"  {found.dropped}{_undetermined(found, cut, end)}"
    yield f"  singular {found.singular}"


def _closing(cut: Joint, closes: str) -> str:
    if closes == "point":
        return " in a point"
    return {0: ", turning", 1: ", sliding"}.get(cut.sigma, ", welded")


def _undetermined(found: DescribedLoop, cut: Joint, end: Joint) -> str:
    if not found.undetermined:
        return ""
    return f"; not determined then: {', '.join(found.undetermined)} at {cut.name}, in axes of {end.name}"


def _rotor_line(rotor: Rotor) -> str:
    if math.isnan(rotor.speed):
        return f"  {rotor.joint}{_body(rotor)}: not known, parameters have no value"
    return f"  {rotor.joint}{_body(rotor)}: {rotor.speed:.3g} of {' and '.join(rotor.turning)}"


def _body(rotor: Rotor) -> str:
    return "" if rotor.has_body else " (ratio)"


def closed_chain_json(found: ClosedChain) -> dict[str, Any]:
    """Return couplings, loops, rotors and motors as plain data."""
    machine = found.machine
    return {
        "variables": {machine.joint(j).name: machine.joint(j).variable for j in machine.with_variable},
        "dependent": [machine.joint(j).name for j in machine.dependent],
        **{kind.value: [x.name for x in machine.joints if x.kind is kind] for kind in (Kind.COUPLED, Kind.CUT)},
        "freedoms_driven": found.driven,
        "sharing": {x.name: str(x.sharing) for x in machine.motor_joints if not x.sharing.is_zero},
        "loops": {loop.plan.loop.name: _loop_json(machine, loop) for loop in found.loops},
        "rotors": {rotor.joint: _rotor_json(rotor) for rotor in found.rotors},
        "warnings": found.warnings,
    }


def _loop_json(machine: Machine, found: DescribedLoop) -> dict[str, Any]:
    plan = found.plan
    return {
        "cut": machine.joint(plan.loop.cut).name,
        "meets": machine.joint(plan.loop.meets).name,
        "closes": plan.loop.closes.value,
        "form": plan.form.value,
        "maps": found.maps,
        "dependent": _names(machine, plan.dependent),
        "start": found.start,
        "found": found.found,
        "signs": {machine.joint(j or plan.loop.cut).name: sign for j, sign in plan.signs.items()},
        "equations": len(plan.kept) + len(plan.dropped),
        "dropped": len(plan.dropped),
        "undetermined": list(found.undetermined),
        "singular": found.singular,
        "distance": found.distance,
    }


def _rotor_json(rotor: Rotor) -> dict[str, Any]:
    speed = rotor.speed if math.isfinite(rotor.speed) else None
    return {"body": rotor.has_body, "speed": speed, "turning": list(rotor.turning)}


def _names(machine: Machine, joints: Sequence[int]) -> list[str]:
    return [machine.joint(j).name for j in joints]
