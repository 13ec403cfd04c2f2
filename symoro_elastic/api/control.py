"""Drives around a machine: control."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from symoro_elastic.api.declaration import operation
from symoro_elastic.api.options import Controlling, Cutting, TuningDrives
from symoro_elastic.api.rows import MachineLike
from symoro_elastic.api.scenes import kept_machine
from symoro_elastic.foundation.errors import InputError, reported_places

if TYPE_CHECKING:
    from symoro_elastic.analysis.control.control import Control
    from symoro_elastic.analysis.control.cutting import Cut
    from symoro_elastic.analysis.control.lobes import Lobes
    from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State


USUAL_SPEEDS = (1000.0, 20_000.0, 200)
"""Lowest and highest spindle speed, turns per minute, and their number."""


@operation(Controlling)
def control(machine: MachineLike, options: Controlling) -> Control:
    """Return margins, bandwidths and limits of the gains of a machine's drives; computes gains to be tuned.

    Raises
    ------
    InputError
        Where the machine has no drives, for gains that are sought and that nothing limits, for modes without damping
        where gains are sought, and without equilibrium.
    """
    return _control(machine, options, options.tune)


@operation(TuningDrives)
def tune(machine: MachineLike, options: TuningDrives) -> Control:
    """Return Kv, Kp and Tn of all drives of a machine, what limits each, and the loops with them.

    As `control(machine, tune=True)`. Raises `InputError`.
    """
    return _control(machine, options, True)


def _control(machine: MachineLike, options: TuningDrives, all_gains: bool) -> Control:
    from symoro_elastic.analysis.control.control import control_at, gains_by_rules
    from symoro_elastic.analysis.control.driven_machine import measured_positions
    from symoro_elastic.analysis.control.tuning import Distances, Tuning
    from symoro_elastic.numerics.motion.equations_of_motion import motion_of

    scene_machine = kept_machine(machine, options.scene)
    measured = measured_positions(scene_machine)
    with reported_places({"--output": "--compliance"}):
        motion = motion_of(scene_machine, dict(options.values), (), (*options.compliances, *measured))
    states = _states(options.along, options.at, motion)
    distances = Distances(options.modulus, options.position_modulus)
    tuning = Tuning(distances, all_gains or options.optimum, options.optimum)
    with reported_places({"--output": "--compliance"}):
        result = control_at(motion, states, tuning, options.damping, options.compliances, options.progress)
    return replace(result, rules=gains_by_rules(result.plants, result.cascades)) if options.rule else result


@operation(Cutting)
def lobes(machine: MachineLike, options: Cutting) -> Lobes:
    """Return the largest depth of cut without regenerative chatter, by spindle speed.

    Loops of [drives] are closed, motors without a drive are held. With `across` it is that of milling, by the mean of
    the forces over a turn, and with `intervals` by forces that change as teeth turn. Raises `InputError`.
    """
    import numpy as np

    from symoro_elastic.analysis.control.cutting import refuse_wrong
    from symoro_elastic.analysis.control.driven_machine import measured_positions
    from symoro_elastic.analysis.control.lobes import lobes_at
    from symoro_elastic.numerics.motion.equations_of_motion import motion_of

    scene_machine = kept_machine(machine, options.scene)
    cut = _cut(options)
    low, high, count = options.speeds or USUAL_SPEEDS
    speeds = 1 / np.linspace(1 / low, 1 / high, count)  # as many in each lobe
    refuse_wrong(cut, speeds, scene_machine)
    motion = motion_of(scene_machine, dict(options.values), (), (*cut.outputs, *measured_positions(scene_machine)))
    states = _states(options.along, options.at, motion)
    return lobes_at(motion, states, cut, speeds, options.damping, options.intervals, options.progress)


def _cut(options: Cutting) -> Cut:
    """Return the cut of the options; raises `InputError` for milling options in turning, and the reverse."""
    from symoro_elastic.analysis.control.cutting import Cut, Milling

    source, milling = "symoro-elastic", None
    if options.across is None:
        of_milling = {"--radial": options.radial, "--immersion": options.immersion, "--down": options.down or None}
        for name in (name for name, value in of_milling.items() if value is not None):
            raise InputError(source, name, "belongs to milling: name the output across the feed by --across")
    else:
        if options.radial is None:
            raise InputError(source, "--radial", "milling needs it (--across is given): often a third of --cutting")
        if options.thickness:
            raise InputError(source, "--thickness", "in milling it is along --direction and --across: leave it out")
        immersion = 1.0 if options.immersion is None else options.immersion
        milling = Milling(options.across, options.radial, immersion, options.down)
    return Cut(options.cutting, options.teeth, options.direction, options.thickness or options.direction, milling)


def _states(
    along: Mapping[str, Sequence[float]], at: Mapping[str, float], motion: EquationsOfMotion
) -> list[tuple[dict[str, float], State]]:
    """Return the equilibria at all positions of a grid, or at the stated position."""
    from symoro_elastic.analysis.vibration.tracking import places_of
    from symoro_elastic.numerics.motion.equilibrium import equilibrium

    return [(place, equilibrium(motion, {**at, **place})) for place in places_of(motion, along, at)]
