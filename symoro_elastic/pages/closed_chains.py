"""Couplings and loops of a machine for `show`: lines of text, and plain data for `--json`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.joint_axes import PlacedMachine
from symoro_elastic.models.bound.rules import drive, independent_motors
from symoro_elastic.models.checks.loop_descriptions import DescribedLoop, described_loops, singular_starts
from symoro_elastic.models.checks.rotors import CHANGE, Rotor, rotors

GYROSCOPIC = (
    "joint speeds, rad/s (slides: m/s), above which the neglected gyroscopic moment of a geared rotor changes an\n"
    f"acceleration by more than {100 * CHANGE:g} %, of 1 rad/s2 (m/s2) and what these speeds cause"
)


@dataclass(frozen=True)
class ClosedChain:
    """Couplings of joints: loops, rotors, and the number of freedoms that motors drive."""

    machine: Machine
    loops: list[DescribedLoop]
    rotors: list[Rotor]
    driven: int

    @property
    def warnings(self) -> list[str]:
        """A line for each loop that starts near a singular position."""
        return singular_starts(self.loops)


def closed_chain(machine: Machine, placement: PlacedMachine) -> ClosedChain:
    """Return the couplings and loops of a machine at a position."""
    driven = len(machine.motors)
    if machine.loops:
        bound = Bound(machine)
        driven = len(independent_motors(bound, {m: bound.coordinates.S_x[m] for m in bound.motors}))
    return ClosedChain(machine, described_loops(machine), rotors(machine, placement.q), driven)


def closed_chain_lines(chain: ClosedChain) -> Iterator[str]:
    """Lines about couplings, loops, rotors and motors; none for a tree without them."""
    machine = chain.machine
    if machine.is_coupled:
        yield ""
        yield f"independent variables (q): {_variables(machine, machine.independent)}"
        if machine.dependent:
            argument = (
                "q_dep, of assemble" if any(loop.plan.is_assembled for loop in chain.loops) else "by closed forms"
            )
            yield f"dependent variables ({argument}): {_variables(machine, machine.dependent)}"
        yield f"motors (tau): {', '.join(joint.name for joint in machine.motor_joints) or 'none'}"
    if chain.driven < len(machine.motors):
        yield f"{drive(len(machine.motors), chain.driven)}: {_sharing(machine)}"
    for loop in chain.loops:
        yield from _loop_lines(machine, loop)
    if chain.rotors:
        yield ""
        yield GYROSCOPIC
    yield from (_rotor_line(rotor) for rotor in chain.rotors if not math.isinf(rotor.speed))
    idle = [f"{rotor.joint}{_body(rotor)}" for rotor in chain.rotors if math.isinf(rotor.speed)]
    if idle:
        yield f"  gyroscopic effects of rotors are negligible at all speeds: {', '.join(idle)}"


def _variables(machine: Machine, joints: Iterable[int]) -> str:
    return ", ".join(f"{machine.joint(j).variable} of {machine.joint(j).name}" for j in joints) or "none"


def _sharing(machine: Machine) -> str:
    shares = {joint.name: str(joint.sharing) for joint in machine.motor_joints if not joint.sharing.is_zero}
    if not shares:
        return "their torques are not determined; give sharing"
    return f"they share torques as {', '.join(f'{name} {share}' for name, share in shares.items())}"


def _loop_lines(machine: Machine, described: DescribedLoop) -> Iterator[str]:
    plan, loop = described.plan, described.plan.loop
    cut, end = machine.joint(loop.cut), machine.joint(loop.meets)
    yield ""
    yield f"loop {loop.name}: {cut.name} meets {end.name}{_closing(cut, loop.closes.value)}; {plan.form.value}"
    for name, text in described.maps.items():
        yield f"  {name} = {text}"
    yield f"  branch of start: {', '.join(f'{name} = {x + 0.0:.4g}' for name, x in described.start.items())}"
    if described.found:
        positions = ", ".join(f"{name} = {x + 0.0:.4g}" for name, x in described.found.items())
        yield f"  found, as start does not give them: {positions}"
    yield f"  {described.dropped}{_undetermined_components(described, cut, end)}"
    yield f"  singular {described.singular}"


def _closing(cut: Joint, closes: str) -> str:
    if closes == "point":
        return " in a point"
    return {0: ", turning", 1: ", sliding"}.get(cut.sigma, ", welded")


def _undetermined_components(described: DescribedLoop, cut: Joint, end: Joint) -> str:
    if not described.undetermined:
        return ""
    return f"; not determined then: {', '.join(described.undetermined)} at {cut.name}, in axes of {end.name}"


def _rotor_line(rotor: Rotor) -> str:
    if math.isnan(rotor.speed):
        return f"  {rotor.joint}{_body(rotor)}: not known, parameters have no value"
    return f"  {rotor.joint}{_body(rotor)}: {rotor.speed:.3g} of {' and '.join(rotor.turning)}"


def _body(rotor: Rotor) -> str:
    return "" if rotor.has_body else " (ratio)"


def closed_chain_json(chain: ClosedChain) -> dict[str, Any]:
    """Return couplings, loops, rotors and motors as plain data."""
    machine = chain.machine
    return {
        "variables": {machine.joint(j).name: machine.joint(j).variable for j in machine.with_variable},
        "dependent": [machine.joint(j).name for j in machine.dependent],
        **{kind.value: [x.name for x in machine.joints if x.kind is kind] for kind in (Kind.COUPLED, Kind.CUT)},
        "freedoms_driven": chain.driven,
        "sharing": {x.name: str(x.sharing) for x in machine.motor_joints if not x.sharing.is_zero},
        "loops": {loop.plan.loop.name: _loop_json(machine, loop) for loop in chain.loops},
        "rotors": {rotor.joint: _rotor_json(rotor) for rotor in chain.rotors},
        "warnings": chain.warnings,
    }


def _loop_json(machine: Machine, described: DescribedLoop) -> dict[str, Any]:
    plan = described.plan
    return {
        "cut": machine.joint(plan.loop.cut).name,
        "meets": machine.joint(plan.loop.meets).name,
        "closes": plan.loop.closes.value,
        "form": plan.form.value,
        "maps": described.maps,
        "dependent": [machine.joint(j).name for j in plan.dependent],
        "start": described.start,
        "found": described.found,
        "signs": {machine.joint(j or plan.loop.cut).name: sign for j, sign in plan.signs.items()},
        "equations": len(plan.kept) + len(plan.dropped),
        "dropped": len(plan.dropped),
        "undetermined": list(described.undetermined),
        "singular": described.singular,
        "distance": described.distance,
    }


def _rotor_json(rotor: Rotor) -> dict[str, Any]:
    speed = rotor.speed if math.isfinite(rotor.speed) else None
    return {"body": rotor.has_body, "speed": speed, "turning": list(rotor.turning)}
