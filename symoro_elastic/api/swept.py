"""Results at a point of a sweep: modes, responses, ladders, simulations, or a function of the machine."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from symoro_elastic.api.machines import the_machine
from symoro_elastic.api.motions import ladder, plan
from symoro_elastic.api.options import Integrating, OperatingPoint
from symoro_elastic.api.rows import Values
from symoro_elastic.api.vibrations import held_motors, linearized_at, modes_of, motion_at
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine

if TYPE_CHECKING:
    from symoro_elastic.analysis.control.control import Control
    from symoro_elastic.analysis.vibration.linearization import Linearization
    from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion


@dataclass(frozen=True)
class SweptVibration:
    """A machine about an operating point; its equations of motion are traced once, for all points of a sweep."""

    machine: DescribedMachine
    point: OperatingPoint
    values: Values
    inputs: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()
    sees_drives: ClassVar[bool] = False
    """Whether results depend on drives."""

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for other processes: without the trace, which they compute themselves."""
        return {item.name: getattr(self, item.name) for item in fields(self)}

    @cached_property
    def motion(self) -> EquationsOfMotion:
        """The equations of motion, valid for all values of the parameters."""
        return motion_at(self.point, self.machine, self.values, self.inputs, self.outputs)

    def prepare(self, positions: Sequence[str]) -> None:
        """Raise `InputError` for unknown names, and for positions that an equilibrium determines."""
        from symoro_elastic.analysis.vibration.tracking import refuse_unheld

        motion = self.motion
        point_values = (("--at", self.point.at), ("--torque", self.point.torques), ("--rate", self.point.rates))
        for option, numbers in point_values:
            motion.indices_of(numbers, option)
        twice = {motion.index(name, "--at"): name for name in self.point.at}
        for name in positions:
            if motion.index(name, "--over") in twice:
                what = f"{twice[motion.index(name, '--over')]} is swept: remove one of the two"
                raise InputError(self.machine.label, "--at", what)
        for name in held_motors(self.point, motion):
            motion.motor(name, "--hold")
        if not self.point.as_given:
            refuse_unheld(motion, positions, self.point.torques, "--over")

    def linear(self, values: Values, positions: Values) -> Linearization:
        """Return the machine with these values, linearized at these positions."""
        motion = self.motion.at_values({**self.values, **values})
        point = replace(self.point, at={**self.point.at, **positions})
        return linearized_at(point, motion, self.inputs, self.outputs)


@dataclass(frozen=True)
class SweptModes(SweptVibration):
    """Frequencies and damping ratios of all modes, ascending, and the fastest growth of an unstable motion."""

    def __call__(self, values: Values, positions: Values) -> dict[str, float]:
        """Return the results at a point."""
        here = modes_of(self.linear(values, positions))
        figures = {f"frequency_{k}": float(f) for k, f in enumerate(here.frequencies, 1)}
        figures |= {f"damping_ratio_{k}": float(x) for k, x in enumerate(here.damping_ratios, 1)}
        return {**figures, "growth": float(here.growth.max(initial=0.0))}

    def unit(self, figure: str) -> str:
        """Return the unit of a result by its name."""
        return "Hz" if figure.startswith("frequency") else "1/s" if figure == "growth" else ""


@dataclass(frozen=True)
class SweptResponse(SweptVibration):
    """Peak, bandwidth and chosen magnitudes of the frequency responses; `damping` is a ratio added to every mode."""

    frequencies: tuple[float, ...] = ()
    damping: float = 0.0

    def __call__(self, values: Values, positions: Values) -> dict[str, float]:
        """Return the results at a point."""
        from symoro_elastic.analysis.vibration.peaks import response_figures
        from symoro_elastic.analysis.vibration.responses import with_modal_damping

        linear = with_modal_damping(self.linear(values, positions), self.damping)
        return response_figures(linear, self.frequencies)

    def unit(self, figure: str) -> str:
        """Return the unit of a result by its name."""
        from symoro_elastic.analysis.vibration.peaks import unit_of_figure

        return unit_of_figure(self.machine, figure)


@dataclass(frozen=True)
class SweptControl(SweptVibration):
    """Margins, bandwidths, largest gains and compliances with the loops of [drives] closed.

    Gains that the file leaves to tuning are found once, for the machine as it is given, and kept.
    """

    damping: float = 0.0
    sees_drives: ClassVar[bool] = True

    @classmethod
    def of(
        cls, machine: DescribedMachine, point: OperatingPoint, values: Values, outputs: tuple[str, ...], damping: float
    ) -> SweptControl:
        """Return the swept closed loops of a machine, gains to be tuned found once; raises `InputError`."""
        from symoro_elastic.analysis.control.control import with_gains
        from symoro_elastic.analysis.control.driven_machine import default_compliances

        swept = cls(machine, point, values, (), outputs or default_compliances(machine), damping)
        return replace(swept, machine=DescribedMachine.of(with_gains(machine, swept.control({}, {}))))

    @cached_property
    def motion(self) -> EquationsOfMotion:
        """The equations of motion, with the points that drives measure."""
        from symoro_elastic.analysis.control.driven_machine import measured_positions

        signals = (*self.outputs, *measured_positions(self.machine))
        return motion_at(self.point, self.machine, self.values, (), signals)

    def control(self, values: Values, positions: Values) -> Control:
        """Return the loops with these values at these positions."""
        from symoro_elastic.analysis.control.control import control_at
        from symoro_elastic.analysis.control.tuning import AT_USUAL_DISTANCES
        from symoro_elastic.numerics.motion.equilibrium import equilibrium

        motion = self.motion.at_values({**self.values, **values})
        place = {**self.point.at, **positions}
        states = [(place, equilibrium(motion, place))]
        return control_at(motion, states, AT_USUAL_DISTANCES, self.damping, self.outputs)

    def __call__(self, values: Values, positions: Values) -> dict[str, float]:
        """Return the results at a point."""
        from symoro_elastic.analysis.control.control import control_figures

        return control_figures(self.control(values, positions))

    def unit(self, figure: str) -> str:
        """Return the unit of a result by its name."""
        from symoro_elastic.analysis.control.control import unit_of

        return unit_of(figure, self.motion.given)


@dataclass(frozen=True)
class SweptMotions:
    """A machine with motions; swept positions are their starts."""

    machine: DescribedMachine
    values: Values

    @property
    def sees_drives(self) -> bool:
        """Whether the motors are controlled by drives."""
        return any(motion.drives for motion in self.machine.asked.motions)

    def at(self, values: Values, positions: Values) -> DescribedMachine:
        """Return the machine with these values, its motions from these positions."""
        described = the_machine(self.machine, {**self.values, **values})
        motions = (replace(motion, start={**motion.start, **positions}) for motion in self.machine.asked.motions)
        return described.asking(motions=tuple(motions))

    def prepare(self, positions: Sequence[str]) -> None:
        """Raise `InputError` for a joint without independent motion."""
        moving = [joint.name for joint in self.machine.independent_joints]
        for name in positions:
            if name not in moving:
                raise self.machine.error("--over", f"{name} is locked by the scene: remove one of the two")


@dataclass(frozen=True)
class SweptLadder(SweptMotions):
    """Results of a ladder of models: the chosen one, its omissions and costs, and its errors over their tolerances."""

    def __call__(self, values: Values, positions: Values) -> dict[str, float]:
        """Return the results at a point."""
        climbed = ladder(self.at(values, positions))
        rung = None if climbed.chosen is None else climbed.rungs[climbed.chosen]
        if rung is None or rung.chosen is None or climbed.chosen is None:
            raise InputError(self.machine.label, "wanted, tolerance", "no rung keeps the tolerances")
        shares = [error / climbed.tolerance[name] for name, error in rung.predicted.items()]
        figures = {
            "rung": climbed.chosen,
            "springs_left_out": len(rung.left_out),
            "steps": rung.chosen.steps,
            "operations": rung.chosen.operations,
            "saving": climbed.saving,
            "predicted_error": max(shares),
        }
        if rung.measured:
            measured = [error / climbed.tolerance[name] for name, error in rung.measured.model.items()]
            figures["measured_error"] = max(measured)
        return {name: float(x) for name, x in figures.items()}

    def unit(self, figure: str) -> str:
        """Return the unit of a result by its name."""
        return ""


@dataclass(frozen=True)
class SweptSimulation(SweptMotions):
    """Outputs at the end, largest deviations, measured errors and energies of simulated motions."""

    integration: Integrating

    def __call__(self, values: Values, positions: Values) -> dict[str, float]:
        """Return the results at a point."""
        planned = plan(self.at(values, positions), None, self.integration)
        figures: dict[str, float] = {}
        for k, reference in enumerate(planned.references, 1):
            simulated = planned.run(reference)
            prefix = f"motion_{k} " if len(planned.references) > 1 else ""
            for name, outputs, deviation in zip(
                simulated.names, simulated.outputs.T, simulated.deviation.T, strict=True
            ):
                figures[f"{prefix}{name}: final"] = float(outputs[-1])
                figures[f"{prefix}{name}: deviation"] = float(np.abs(deviation).max())
                figures[f"{prefix}{name}: error"] = float(simulated.errors[name])
            figures[f"{prefix}steps"] = float(simulated.trajectory.steps)
            for name in ("put_in", "dissipated", "stored", "largest"):
                figures[f"{prefix}energy: {name}"] = float(getattr(simulated.energy, name))
        return figures

    def unit(self, figure: str) -> str:
        """Return the unit of a result by its name."""
        from symoro_elastic.numerics.motion.signals import output_unit

        if "energy: " in figure:
            return "J"
        try:
            return output_unit(self.machine, re.sub(r"^motion_\d+ ", "", figure).rpartition(": ")[0])
        except InputError:
            return ""


@dataclass(frozen=True)
class SweptFunction:
    """Results of a function of the user, of the machine, and of positions if it has two arguments."""

    machine: DescribedMachine
    values: Values
    function: Callable[..., Mapping[str, float]]
    sees_drives: ClassVar[bool] = True

    @property
    def takes_positions(self) -> bool:
        """Whether the function has a second argument."""
        try:
            return len(inspect.signature(self.function).parameters) > 1
        except (TypeError, ValueError):
            return False

    def prepare(self, positions: Sequence[str]) -> None:
        """Raise `InputError` for swept positions of a function without them."""
        if positions and not self.takes_positions:
            what = f"{positions[0]} is a position, and the function has one argument, machine: give it a second one"
            raise InputError("symoro-elastic", "--over", what)

    def __call__(self, values: Values, positions: Values) -> Mapping[str, float]:
        """Return the results at a point."""
        described = the_machine(self.machine, {**self.values, **values})
        return self.function(described, dict(positions)) if self.takes_positions else self.function(described)

    def unit(self, figure: str) -> str:
        """Return the unit of a result by its name."""
        return ""
