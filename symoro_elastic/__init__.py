"""Symbolic models of robots and machine tools with elastic joints, as numpy and C code.

A machine is a tree of bodies on revolute, prismatic and fixed joints that are driven by motors, elastic or passive,
with couplings and closed loops, described by the geometric parameters of Khalil and Kleinfinger. The recursions of
Khalil and Gautier, *Modeling of high speed machines using robotics formulation*, run on the symbols of its table; what
remains is pruned, scheduled and written as functions without dependencies, or as equations.

>>> import symoro_elastic as se
>>> machine = se.read("examples/two_axis.toml")
>>> machine
<Machine two_axis: 12 coordinates, 2 motors, 10 springs, 13 rows>
>>> model = se.load(machine, "inverse_dynamics")
>>> tau, qdd = model.inverse_dynamics([0.0] * 12, [0.0] * 12, [1.0, 0.0])
>>> print(tau)
[30.  0.]

Machines and scenes are given as files, as tables (dictionaries and lists as in the files), or as objects already read.
Results have a short `repr`, tables in notebooks, `arrays()`, `to_frame()`, `as_json()` and `plot()`. Errors that
you can fix are `InputError`, in one line.
"""

from __future__ import annotations

import warnings
from importlib import import_module
from typing import TYPE_CHECKING, Any

from symoro_elastic.foundation.version import __version__ as __version__

if TYPE_CHECKING:
    from symoro_elastic.analysis.control.control import Control as Control
    from symoro_elastic.analysis.control.lobes import Lobes as Lobes
    from symoro_elastic.analysis.flexible.parts import FlexibleParts as FlexibleParts
    from symoro_elastic.analysis.flexible.reduction import FlexibleModes as FlexibleModes
    from symoro_elastic.analysis.ladder.reduced import Reduced as Reduced
    from symoro_elastic.analysis.ladder.rungs import Ladder as Ladder
    from symoro_elastic.analysis.poses.evaluation import Evaluation as Evaluation
    from symoro_elastic.analysis.poses.frame_stiffness import FrameStiffness as FrameStiffness
    from symoro_elastic.analysis.poses.frame_stiffness import StiffnessMap as StiffnessMap
    from symoro_elastic.analysis.poses.inverse_geometry import InverseGeometry as InverseGeometry
    from symoro_elastic.analysis.simulation.simulated import Simulation as Simulation
    from symoro_elastic.analysis.simulation.simulated import Simulations as Simulations
    from symoro_elastic.analysis.singularities.singularities import Singularities as Singularities
    from symoro_elastic.analysis.sweeps.sweep import Sweep as Sweep
    from symoro_elastic.analysis.trade_off.trade import Trade as Trade
    from symoro_elastic.analysis.vibration.comparison import Comparison as Comparison
    from symoro_elastic.analysis.vibration.feed_forward import FeedForward as FeedForward
    from symoro_elastic.analysis.vibration.linearization import Linearization as Linearization
    from symoro_elastic.analysis.vibration.modes import Modes as Modes
    from symoro_elastic.analysis.vibration.responses import Response as Response
    from symoro_elastic.api.control import control as control
    from symoro_elastic.api.control import lobes as lobes
    from symoro_elastic.api.control import tune as tune
    from symoro_elastic.api.drawings import MachinePage as MachinePage
    from symoro_elastic.api.drawings import MachinePicture as MachinePicture
    from symoro_elastic.api.drawings import Report as Report
    from symoro_elastic.api.drawings import picture as picture
    from symoro_elastic.api.drawings import report as report
    from symoro_elastic.api.drawings import view as view
    from symoro_elastic.api.flexible import flexible as flexible
    from symoro_elastic.api.flexible import flexible_parts as flexible_parts
    from symoro_elastic.api.loaded import LoadedModel as LoadedModel
    from symoro_elastic.api.loaded import load as load
    from symoro_elastic.api.machines import MachineWarning as MachineWarning
    from symoro_elastic.api.machines import new as new
    from symoro_elastic.api.machines import read as read
    from symoro_elastic.api.machines import write as write
    from symoro_elastic.api.measured import excite as excite
    from symoro_elastic.api.measured import identify as identify
    from symoro_elastic.api.measured import update as update
    from symoro_elastic.api.models import Equations as Equations
    from symoro_elastic.api.models import benchmark as benchmark
    from symoro_elastic.api.models import certify as certify
    from symoro_elastic.api.models import check as check
    from symoro_elastic.api.models import equations as equations
    from symoro_elastic.api.models import generate as generate
    from symoro_elastic.api.motions import ladder as ladder
    from symoro_elastic.api.motions import reduce as reduce
    from symoro_elastic.api.motions import simulate as simulate
    from symoro_elastic.api.poses import evaluate as evaluate
    from symoro_elastic.api.poses import ik as ik
    from symoro_elastic.api.poses import singularities as singularities
    from symoro_elastic.api.poses import stiffness as stiffness
    from symoro_elastic.api.sweeps import sweep as sweep
    from symoro_elastic.api.vibrations import compare as compare
    from symoro_elastic.api.vibrations import feed_forward as feed_forward
    from symoro_elastic.api.vibrations import linearize as linearize
    from symoro_elastic.api.vibrations import modes as modes
    from symoro_elastic.api.vibrations import response as response
    from symoro_elastic.foundation.errors import InputError as InputError
    from symoro_elastic.generation.pipeline import Generated as Generated
    from symoro_elastic.machine.described import DescribedMachine as DescribedMachine
    from symoro_elastic.measured.logs.identified import Identified as Identified
    from symoro_elastic.measured.logs.trajectory import ExcitingTrajectory as ExcitingTrajectory
    from symoro_elastic.measured.vibration_tests.updated import Updated as Updated
    from symoro_elastic.numerics.guarantees.certificates import Certificates as Certificates
    from symoro_elastic.numerics.verification.verify import Verification as Verification

_MODULES = {
    "foundation.errors": "InputError",
    "api.control": "control lobes tune",
    "api.drawings": "MachinePage MachinePicture Report picture report view",
    "api.flexible": "flexible flexible_parts",
    "api.loaded": "LoadedModel load",
    "api.machines": "MachineWarning new read write",
    "api.measured": "excite identify update",
    "api.models": "Equations benchmark certify check equations generate",
    "api.motions": "ladder reduce simulate",
    "api.poses": "evaluate ik stiffness singularities",
    "api.sweeps": "sweep",
    "api.vibrations": "compare feed_forward linearize modes response",
    "analysis.control.control": "Control",
    "analysis.control.lobes": "Lobes",
    "analysis.flexible.parts": "FlexibleParts",
    "analysis.flexible.reduction": "FlexibleModes",
    "analysis.ladder.reduced": "Reduced",
    "analysis.ladder.rungs": "Ladder",
    "analysis.poses.evaluation": "Evaluation",
    "analysis.poses.frame_stiffness": "FrameStiffness StiffnessMap",
    "analysis.poses.inverse_geometry": "InverseGeometry",
    "analysis.simulation.simulated": "Simulation Simulations",
    "analysis.singularities.singularities": "Singularities",
    "analysis.sweeps.sweep": "Sweep",
    "analysis.trade_off.trade": "Trade",
    "analysis.vibration.comparison": "Comparison",
    "analysis.vibration.feed_forward": "FeedForward",
    "analysis.vibration.linearization": "Linearization",
    "analysis.vibration.modes": "Modes",
    "analysis.vibration.responses": "Response",
    "generation.pipeline": "Generated",
    "machine.described": "DescribedMachine",
    "measured.logs.identified": "Identified",
    "measured.logs.trajectory": "ExcitingTrajectory",
    "measured.vibration_tests.updated": "Updated",
    "numerics.guarantees.certificates": "Certificates",
    "numerics.verification.verify": "Verification",
}
"""Functions, then the classes of their results, for annotations."""
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names.split()}
_FORMER = {"trade": "benchmark"}
__all__ = [*_MODULE_OF]  # noqa: PLE0604


def __getattr__(name: str) -> Any:
    """Return a public name, imported on first use."""
    if name in _FORMER:
        warnings.warn(f"{name} is now {_FORMER[name]}", DeprecationWarning, stacklevel=2)
        name = _FORMER[name]
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'symoro_elastic' has no attribute {name!r}")
    public: Any = getattr(import_module(f"symoro_elastic.{_MODULE_OF[name]}"), name)
    if not isinstance(public, type):
        public = import_module("symoro_elastic.api.checked_calls").with_arguments(public)
    globals()[name] = public
    return public


def __dir__() -> list[str]:
    """Return the public names."""
    return [*__all__, "__version__"]
