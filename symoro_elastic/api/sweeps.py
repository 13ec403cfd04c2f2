"""Sweeps over parameters and positions: sweep."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from symoro_elastic.analysis.sweeps.design import Design, design
from symoro_elastic.analysis.sweeps.digest import digest
from symoro_elastic.analysis.sweeps.quantities import Quantity, quantities, with_ranges
from symoro_elastic.analysis.sweeps.ranges import axis, python_text
from symoro_elastic.analysis.sweeps.running import Note, Run, Workplace
from symoro_elastic.analysis.sweeps.sweep import Sweep, sweep_of
from symoro_elastic.analysis.sweeps.tasks import Task
from symoro_elastic.api.declaration import in_si_units, operation
from symoro_elastic.api.machines import the_machine
from symoro_elastic.api.motions import refuse_mixture
from symoro_elastic.api.options import Integrating, OperatingPoint, Sweeping
from symoro_elastic.api.rows import ANALYSES, MachineLike
from symoro_elastic.api.scenes import SceneRequest, required_motions
from symoro_elastic.api.vibrations import point_of
from symoro_elastic.foundation.errors import TWICE, InputError, among
from symoro_elastic.foundation.input_files import is_plain_file, read_file
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.version import __version__
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restrict

if TYPE_CHECKING:
    from symoro_elastic.api.swept import (
        SweptControl,
        SweptFunction,
        SweptLadder,
        SweptModes,
        SweptResponse,
        SweptSimulation,
    )

    Swept: TypeAlias = SweptModes | SweptResponse | SweptControl | SweptLadder | SweptSimulation | SweptFunction


def _name(options: Sweeping) -> str:
    """Return the name of the analysis, or of the function."""
    of = options.of
    return of if isinstance(of, str) else getattr(of, "__name__", type(of).__name__)


def _refuse(options: Sweeping) -> None:
    """Raise `InputError` for an unknown analysis, for options of another one, and for numbers out of range."""
    if not callable(options.of):
        among((options.of,), ANALYSES, "--of")
    for option, value, where in (
        ("--input", options.inputs, ("response",)),
        ("--output", options.outputs, ("response", "control")),
        ("--frequency", _frequencies(options), ("response",)),
        ("--damping", options.damping, ("response", "control")),
        ("--method", options.method, ("simulation",)),
        ("--step", options.step, ("simulation",)),
    ):
        if value and options.of not in where:
            what = f"belongs to --of {' or '.join(where)}: leave it out of {_name(options)}"
            raise InputError("symoro-elastic", option, what)
    _refuse_numbers(options.damping, _frequencies(options))
    if options.of == "control" and replace(point_of(options), at={}) != OperatingPoint():
        what = "control is at the equilibrium, and motors without a drive are held: leave out all but --at"
        raise InputError("symoro-elastic", "--of", what)
    if point_of(options) != OperatingPoint() and options.of not in ("modes", "response", "control"):
        what = f"an operating point belongs to modes and response, not to {_name(options)}: leave out --at, --hold ..."
        raise InputError("symoro-elastic", "--of", what)
    refuse_mixture(_steps(options))


def _frequencies(options: Sweeping) -> tuple[float, ...]:
    return tuple(() if options.frequencies is None else options.frequencies)


def _steps(options: Sweeping) -> Integrating:
    return Integrating(method=options.method, step=options.step)


def _refuse_numbers(damping: float, frequencies: Iterable[float]) -> None:
    """Raise `InputError` for a damping ratio or frequency out of range, and for frequencies given twice."""
    if not (isinstance(damping, Real) and 0 <= damping < math.inf):
        what = f"{python_text(damping)} is not a damping ratio: 0.01 is one per cent"
        raise InputError("symoro-elastic", "--damping", what)
    written: set[str] = set()
    for x in frequencies:
        if not (isinstance(x, Real) and 0 <= x < math.inf):
            what = f"{python_text(x)} is not a frequency: give numbers of Hz from 0"
            raise InputError("symoro-elastic", "--frequency", what)
        if f"{x:g}" in written:
            raise InputError("symoro-elastic", "--frequency", f"{x:g} Hz {TWICE}")
        written.add(f"{x:g}")


def _swept(options: Sweeping, machine: DescribedMachine) -> Swept:
    """Return the results of a machine as a function of values and positions; raises `InputError`."""
    from symoro_elastic.api import swept

    scene_machine = restrict(machine, SceneRequest().of(machine, options.scene)).asking(scene=None)
    values = dict(options.values)
    if options.of in ("modes", "response"):
        arguments = replace(scene_machine, forces=()), point_of(options), values
        if options.of == "modes":
            return swept.SweptModes(*arguments)
        signals = tuple(options.inputs), tuple(options.outputs)
        return swept.SweptResponse(*arguments, *signals, tuple(map(float, _frequencies(options))), options.damping)
    if options.of == "control":
        return swept.SweptControl.of(scene_machine, point_of(options), values, tuple(options.outputs), options.damping)
    if not isinstance(options.of, str):
        return swept.SweptFunction(scene_machine, values, options.of)
    prescribed = required_motions(machine, options.scene)
    scene_machine = scene_machine.asking(motions=prescribed.motions, wanted=prescribed.wanted)
    if options.of == "ladder":
        return swept.SweptLadder(scene_machine, values)
    return swept.SweptSimulation(scene_machine, values, _steps(options))


@dataclass(frozen=True)
class Plan:
    """A sweep that can be run: the analysis, and the points."""

    machine: Machine
    options: Sweeping
    design: Design
    quantities: tuple[Quantity, ...]
    swept: Swept
    workplace: Workplace

    def run(self, journal: Path | None = None, note: Note = lambda _: None, progress: Progress = no_progress) -> Sweep:
        """Return the results at all points; raises `InputError`."""
        task = Task(self.swept, self.quantities)
        run = Run(task, self.design, self.workplace, journal, self.digest if journal else "")
        outcomes = run.outcomes(note, progress)
        names = [name for outcome in outcomes for name in outcome.figures]
        units = {quantity.name: quantity.unit for quantity in self.quantities}
        units |= {name: self.swept.unit(name) for name in dict.fromkeys(names)}
        return sweep_of(self.machine.name, _name(self.options), self.design, outcomes, units, self.options.results,
                        self.options.require)  # fmt: skip

    @property
    def digest(self) -> str:
        """A digest of the machine, the analysis, and the points."""
        paths = [motion.path for motion in self.swept.machine.asked.motions if motion.file]
        records = [read_file(path) for path in paths if is_plain_file(path)]
        return digest(__version__, self.swept, self.quantities, self.design.points, records)


def plan(machine: DescribedMachine, options: Sweeping) -> Plan:
    """Return a sweep of a machine; raises `InputError` for unknown names, axes and arguments."""
    options = in_si_units(machine, options)
    _refuse(options)
    over = options.over
    if not isinstance(over, Mapping) or not all(isinstance(name, str) for name in over):
        what = f'{python_text(over)} gives no values by name: write {{"name": "LOW:HIGH:COUNT"}}'
        raise InputError("symoro-elastic", "--over", what)
    axes = {name: axis(name, values_of_axis) for name, values_of_axis in over.items()}
    computed = _swept(options, machine)
    swept_over = quantities(computed.machine, axes)
    for quantity in swept_over:
        if quantity.of_drive and not computed.sees_drives:
            name = quantity.name
            what = f"{name} belongs to drives, on which {_name(options)} does not depend here: see --of control"
            raise InputError(machine.label, "--over", what)
        if not quantity.is_position and quantity.key in options.values:
            raise InputError(machine.label, "--value", f"{quantity.key} is swept: remove one of the two")
    computed.prepare([quantity.key for quantity in swept_over if quantity.is_position])
    points = design(with_ranges(computed.machine, swept_over, axes), options.samples, options.sampling, options.seed)
    return Plan(machine, options, points, swept_over, computed, Workplace(options.workers, options.scheduler))


@operation(Sweeping)
def sweep(machine: MachineLike, options: Sweeping) -> Sweep:
    """Return results of a machine over a grid, or a sample, of parameters and positions.

    Raises
    ------
    InputError
        For unknown names and wrong values, for too many points, and where no point has a result.
    """
    journal = None if options.journal is None else Path(options.journal)
    return plan(the_machine(machine), options).run(journal, progress=options.progress)
