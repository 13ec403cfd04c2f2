"""Sweeps over parameters and positions: sweep."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias, Unpack

from symoro_elastic import __version__
from symoro_elastic.api.machines import NO_VALUES, MachineLike, Values, the_machine
from symoro_elastic.api.motions import Integration
from symoro_elastic.api.scenes import Asked, SceneLike, prescribed
from symoro_elastic.api.vibrations import OperatingPoint, Where, operating_point
from symoro_elastic.errors import InputError, among
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restricted
from symoro_elastic.progress import Progress, no_progress
from symoro_elastic.sweeps.axes import AxisLike, axis
from symoro_elastic.sweeps.design import Design, design
from symoro_elastic.sweeps.digest import digest
from symoro_elastic.sweeps.points import Task
from symoro_elastic.sweeps.quantities import Quantity, quantities
from symoro_elastic.sweeps.running import Note, Run, Workplace
from symoro_elastic.sweeps.sweep import Sweep, swept

if TYPE_CHECKING:
    from symoro_elastic.api.swept import SweptFunction, SweptLadder, SweptModes, SweptResponse, SweptSimulation
    from symoro_elastic.machine.prescribed_motion import PrescribedMotion

    Swept: TypeAlias = SweptModes | SweptResponse | SweptLadder | SweptSimulation | SweptFunction

ANALYSES = ("modes", "response", "ladder", "simulation")
Of: TypeAlias = str | Callable[..., Mapping[str, float]]
Over: TypeAlias = Mapping[str, AxisLike]


@dataclass(frozen=True)
class Subject:
    """What is computed at each point of a sweep: `of` an analysis, or a function, and its arguments."""

    of: Of = "modes"
    point: OperatingPoint = field(default_factory=OperatingPoint)
    inputs: Sequence[str] = ()
    outputs: Sequence[str] = ()
    frequencies: Sequence[float] = ()
    damping: float = 0.0
    integration: Integration = field(default_factory=Integration)
    values: Values = field(default_factory=dict)
    scene: SceneLike = None

    def __post_init__(self) -> None:
        if not callable(self.of):
            among((self.of,), ANALYSES, "--of")
        for option, given, where in (
            ("--input", self.inputs, ("response",)),
            ("--output", self.outputs, ("response",)),
            ("--frequency", self.frequencies, ("response",)),
            ("--damping", self.damping, ("response",)),
            ("--method", self.integration.method, ("simulation",)),
            ("--step", self.integration.step, ("simulation",)),
        ):
            if given and self.of not in where:
                what = f"belongs to --of {' or '.join(where)}: leave it out of {self.name}"
                raise InputError("symoro-elastic", option, what)
        self._refuse_numbers()
        told = any(getattr(self.point, one.name) for one in fields(self.point))
        if told and self.of not in ("modes", "response"):
            what = f"an operating point belongs to modes and response, not to {self.name}: leave out --at, --hold ..."
            raise InputError("symoro-elastic", "--of", what)

    def _refuse_numbers(self) -> None:
        """Raise `InputError` for a damping ratio that is none, and for frequencies that are none or given twice."""
        if not (isinstance(self.damping, Real) and 0 <= self.damping < math.inf):
            what = f"{self.damping!r} is no damping ratio: 0.01 is one per cent"
            raise InputError("symoro-elastic", "--damping", what)
        for k, x in enumerate(self.frequencies):
            if not (isinstance(x, Real) and 0 <= x < math.inf):
                what = f"{x!r} is no frequency: give numbers of Hz from 0"
                raise InputError("symoro-elastic", "--frequency", what)
            if f"{x:g}" in [f"{y:g}" for y in self.frequencies[:k]]:
                raise InputError("symoro-elastic", "--frequency", f"{x:g} Hz is given twice: leave it out once")

    @property
    def name(self) -> str:
        """The analysis, or the name of the function."""
        return self.of if isinstance(self.of, str) else getattr(self.of, "__name__", type(self.of).__name__)

    def swept(self, machine: Machine) -> Swept:
        """Return the figures of a machine as a function of values and positions; raises `InputError`."""
        from symoro_elastic.api import swept

        kept = replace(restricted(machine, Asked().of(machine, self.scene)), scene=None)
        if self.of in ("modes", "response"):
            given = replace(kept, forces=()), self.point, dict(self.values)
            if self.of == "modes":
                return swept.SweptModes(*given)
            signals = tuple(self.inputs), tuple(self.outputs)
            return swept.SweptResponse(*given, *signals, tuple(map(float, self.frequencies)), self.damping)
        if not isinstance(self.of, str):
            return swept.SweptFunction(kept, dict(self.values), self.of)
        told = prescribed(machine, self.scene)
        kept = replace(kept, motions=told.motions, wanted=told.wanted)
        if self.of == "ladder":
            return swept.SweptLadder(kept, dict(self.values))
        return swept.SweptSimulation(kept, dict(self.values), self.integration)


@dataclass(frozen=True)
class Plan:
    """A sweep that can be run: what is computed, at which points."""

    machine: Machine
    subject: Subject
    design: Design
    quantities: tuple[Quantity, ...]
    swept: Swept

    def run(
        self,
        workplace: Workplace,
        journal: Path | None,
        figures: Sequence[str] = (),
        note: Note = lambda _: None,
        progress: Progress = no_progress,
    ) -> Sweep:
        """Return the figures at all points; raises `InputError`."""
        task = Task(self.swept, self.quantities)
        run = Run(task, self.design, workplace, journal, self.digest if journal else "")
        outcomes = run.outcomes(note, progress)
        names = [name for one in outcomes for name in one.figures]
        units = {one.name: one.unit for one in self.quantities}
        units |= {name: self.swept.unit(name) for name in dict.fromkeys(names)}
        return swept(self.machine.name, self.subject.name, self.design, outcomes, units, figures)

    @property
    def digest(self) -> str:
        """A digest of the machine, what is computed of it, and the points."""
        records = [Path(motion.path).read_bytes() for motion in self.swept.machine.motions if _is_there(motion)]
        return digest(__version__, self.swept, self.quantities, self.design.points, records)


def _is_there(motion: PrescribedMotion) -> bool:
    return bool(motion.file) and Path(motion.path).is_file()


def plan(
    machine: Machine,
    over: Over,
    subject: Subject,
    samples: int | None = None,
    sampling: str | None = None,
    seed: int | None = None,
) -> Plan:
    """Return a sweep of a machine; raises `InputError` for names, axes and arguments that are none."""
    if not isinstance(over, Mapping) or not all(isinstance(name, str) for name in over):
        what = f'{over!r} gives no values by name: write {{"name": "LOW:HIGH:COUNT"}}'
        raise InputError("symoro-elastic", "--over", what)
    axes = {name: axis(name, given) for name, given in over.items()}
    figures = subject.swept(machine)
    found = quantities(figures.machine, axes)
    for one in found:
        if not one.is_position and one.key in subject.values:
            raise InputError(machine.label, "--value", f"{one.key} is swept: leave it out of one of both")
    figures.prepare([one.key for one in found if one.is_position])
    return Plan(machine, subject, design(axes, samples, sampling, seed), found, figures)


def sweep(
    machine: MachineLike,
    *,
    over: Over,
    of: Of = "modes",
    samples: int | None = None,
    sampling: str | None = None,
    seed: int | None = None,
    figures: Sequence[str] = (),
    workers: int = 1,
    scheduler: str | None = None,
    journal: str | Path | None = None,
    point: OperatingPoint | None = None,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
    frequencies: Sequence[float] = (),
    damping: float = 0.0,
    method: str | None = None,
    step: float | None = None,
    values: Values = NO_VALUES,
    scene: SceneLike = None,
    progress: Progress = no_progress,
    **where: Unpack[Where],
) -> Sweep:
    """Return figures of a machine over a grid, or a sample, of parameters and positions.

    Parameters
    ----------
    machine
        A machine, its file or its tables.
    over
        What is swept, by name: a parameter, a number of the table such as "ram.stiffness" or "ram.k", the position of a
        joint, "motor_x" or "q.motor_x". A list of numbers, or a text: "LOW:HIGH:COUNT", "LOW:HIGH:COUNT,log"; with
        `samples` "LOW:HIGH", "LOW:HIGH,log", "normal:MEAN:DEVIATION", "lognormal:MEDIAN:DEVIATION".
    of
        "modes", "response", "ladder", "simulation", or a function of the machine (and of the positions, a dictionary)
        that returns a dictionary of numbers.
    samples, sampling, seed
        Number of points that are drawn, "latin" (a Latin hypercube, the default), "random" or "sobol", and a whole
        number that gives others; without `samples` all points of the grid.
    figures
        Names of figures that are kept, or patterns such as "frequency_*" (default: all).
    workers, scheduler
        Processes of this computer, 0 for one on each core; or the address of a Dask scheduler.
    journal
        A file to which each point is written when it is computed; a sweep that was interrupted goes on from there. The
        file is left when it ends, and an equal sweep takes its figures from there.
    point
        The operating point of modes and responses; its fields may also be given by name, as in `linearize`.
    inputs, outputs, frequencies, damping
        Of "response": signals, frequencies (Hz) whose magnitudes are figures, damping ratio added to every mode.
    method, step
        Of "simulation": as in `simulate`.
    values
        Values of parameters that are not swept.
    scene
        A scene that locks joints, or has motions.
    progress
        Called with the points that are computed, and their number.

    Raises
    ------
    InputError
        For names and values that are none, for too many points, and where no point has a result.
    """
    subject = Subject(
        of,
        operating_point(point, where),
        inputs,
        outputs,
        frequencies,
        damping,
        Integration(method, step),
        values,
        scene,
    )
    planned = plan(the_machine(machine), over, subject, samples, sampling, seed)
    path = None if journal is None else Path(journal)
    return planned.run(Workplace(workers, scheduler), path, figures, progress=progress)
