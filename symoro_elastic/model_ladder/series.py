"""Springs in series with massless bodies between, which have no motion of their own, as one spring each."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import PrescribedMotion
from symoro_elastic.machine.series_springs import Condensed, condensed
from symoro_elastic.model_ladder.outputs import is_torque
from symoro_elastic.vibration.signals import FrameSignal, outputs

WAY_OUT = "leave it out, or name a frame beyond them"


def with_springs_joined(machine: Machine, motions: Sequence[PrescribedMotion], signals: Iterable[str]) -> Condensed:
    """Return the machine with one spring in place of those in series, which is exact, and a line on each.

    Raises `InputError` for motions and signals that name what then is another thing: the variables of the joints, and
    frames between them.
    """
    found = condensed(machine)
    for motion in motions:
        for name in found.variables.intersection(motion.start):
            what = f"{name} is one of two springs in series, which become one: {WAY_OUT}"
            raise motion.error(f"start, {name}", what)
        for k, force in enumerate(motion.forces, 1):
            if force.at in found.between:
                what = f"{force.at} is between two springs in series, which become one: {WAY_OUT}"
                raise motion.error(f"forces {k}, at", what)
    for name in signals:
        if _changes(machine, found, name):
            what = f"{name} is of two springs in series, which become one: {WAY_OUT}"
            raise machine.error("wanted, tolerance", what)
    return found


def _changes(machine: Machine, found: Condensed, name: str) -> bool:
    """Whether a signal is of a variable, or of a frame, that condensing changes."""
    if not found.variables or is_torque(name):
        return False
    (signal,) = outputs(machine, [name])
    joint = machine.joint(signal.number).name
    return joint in (found.between if isinstance(signal, FrameSignal) else found.variables)
