"""The options of all operations: a record for each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symoro_elastic.api import kinds, rows
from symoro_elastic.api.declaration import Options, argument, option, switch
from symoro_elastic.api.quantities import of_gains, of_joints, of_parameters, of_signals, of_states
from symoro_elastic.api.rows import Gains, Of, Over, Ranges, SceneLike, Values

if TYPE_CHECKING:
    from symoro_elastic.foundation.array_types import Array
    from symoro_elastic.foundation.progress import Announce, Progress, StepProgress

# Machines and models


class Reading(Options):
    """Options of reading a machine."""

    base: bool = switch("Group the inertial parameters: fewer operations, the same motion.")
    free: Sequence[str] = option(
        (), "TABLES", "Tables whose numbers stay parameters of generated code: {names}.", kinds.WORDS,
        names=rows.table_names,
    )  # fmt: skip
    snap: float | None = option(
        None, "[TOL]", "Round angles within TOL (rad) to multiples of pi/12, and lengths of a robot within TOL (m) to "
        "zero (default 1e-9).", kinds.NUMBER, bare="1e-9",
    )  # fmt: skip
    elastic: Mapping[str, float | Sequence[float]] | None = option(
        None, "JOINT=K[:IA]", "Put a spring behind the motor of a joint of a robot: stiffness, N m/rad or N/m, and "
        "inertia of the rotor reflected to the joint, kg m2 or kg.", kinds.SPRINGS,
    )  # fmt: skip


class Requested(Options):
    """Models, constants and outputs in addition to those of a scene."""

    only: Mapping[str, Sequence[str]] | None = option(
        None, "MODEL=NAME", "Only this joint or frame of a model, as in 'jacobian=tool at (0.1, 0, L2) in base', or "
        "these columns of derivatives, as in 'direct_dynamics_parameter_derivatives by M1, K2'.", kinds.REQUESTS,
        gone=("outputs",),
    )  # fmt: skip
    fold: Sequence[str] = option(
        (), "NAME|all", "Parameter that becomes a constant.", kinds.TEXTS, of_machine=rows.parameters_or_all
    )
    scene: SceneLike = rows.scene_row("of models, outputs, constants and locked joints")


class RequestedModels(Requested):
    """Models, with the form of direct_dynamics."""

    models: Sequence[str] = option(
        (), "NAME", "Model, as `symoro-elastic models` lists them (default: those of the scene, else direct_dynamics "
        "and inverse_dynamics).", kinds.TEXTS, names=rows.model_names,
    )  # fmt: skip
    form: str = option(
        "auto", "NAME", "Form of direct_dynamics: {names} (inertia: through the inertia matrix; auto: the one with "
        "fewer operations, as accurate; where something is proven or left out, the recursion).", names=rows.form_names,
    )  # fmt: skip


class Loading(RequestedModels):
    """Models that are loaded as functions."""

    steps: Sequence[str] = argument(
        (), "Time steps in addition to the models (numpy and C): {names}.", names=rows.method_names
    )
    backend: Any = argument(
        "numpy", '"numpy": generated numpy functions; "c": the generated C, compiled by $CC, gcc or clang; "casadi": '
        'functions of CasADi; "jax": functions that JAX traces, differentiates and maps; "sympy": functions of '
        "expressions; or an array library such as torch, by its module."
    )  # fmt: skip


class Locating(Options):
    """Options of `singularities`."""

    components: Sequence[str] = option(
        (), "FRAME.X", "Component of the twist of a frame, as in tool.x, tool.rz or 'tool.x at (0.1, 0, L2) in base' "
        "(default: all of the last frame that some joint changes).", kinds.TEXTS,
    )  # fmt: skip
    scene: SceneLike = rows.scene_row("of locked joints and constants")


class Generating(RequestedModels):
    """Targets of code and output files."""

    targets: Sequence[str] = option(
        (), "NAME", "Target: {names} (default: numpy and c).", kinds.TEXTS, names=rows.target_names
    )
    out: str | Path = option("generated", "FOLDER", "Folder of generated machines.", kinds.OUTPUT_FOLDER)
    precisions: Sequence[str] = option(
        (), "NAME", "Precision of the C code: {names} (default: double).", kinds.TEXTS, names=rows.precision_names
    )
    within: str | float | Mapping[str, str | float] = rows.within_row()
    keep: str = rows.keep_row()
    guaranteed: str = rows.guaranteed_row()
    limits: str = rows.limits_row()
    certify: bool = switch(
        "Write error bounds that are valid within [limits] into the code, and a function *_in_box that checks the "
        "arguments."
    )
    report: bool = switch("Compile the C, and report stack, size and instructions of each function.")
    processor: str = rows.processor_row("of the report, instead of --compiler and its options")
    compiler: str = option("", "COMMAND", "Compiler of the report (default: that of this computer).", gone=("--cc",))
    compiler_flags: str = option("", "OPTIONS", "Its options, after -O2, as in '-mcpu=cortex-m7'.", gone=("--cflags",))
    fmi: int = option(2, "N", "Version of FMI of an FMU, 2 or 3.", kinds.WHOLE, least=2, most=3)
    start: Values = rows.start_row()
    by_torque: bool = switch("Motors of an FMU are given by torques, without their [drives].")
    merge_angles: float | None = rows.merge_angles_row()
    steps: Sequence[str] = argument((), "Time steps in addition to the models: {names}.", names=rows.method_names)
    force: bool = argument(False, "Replace existing files that the program has not written itself.")
    announce: Announce = rows.announce_row()
    progress: Progress = rows.progress_row()


class Checking(RequestedModels):
    """Options of `check`."""

    seed: int = rows.seed_row()
    announce: Announce = rows.announce_row()
    progress: Progress = rows.progress_row()


class Certifying(RequestedModels):
    """Options of `certify`."""

    precisions: Sequence[str] = option(
        (), "NAME", "Precision that is certified: {names} (default: double).", kinds.TEXTS, names=rows.certified_names
    )
    limits: str = rows.limits_row()
    sub_boxes: int = option(
        64, "N", "Maximum number of sub-boxes; more give tighter bounds.", kinds.WHOLE, least=1, most=4096
    )
    polynomials: bool = switch(
        "Also bound errors and ranges of inverse models and inertia matrices by coefficients: slower, but tighter."
    )
    seed: int = rows.seed_row()
    announce: Announce = rows.announce_row()
    progress: Progress = rows.progress_row()


class Writing(Requested, kw_only=False):
    """Options of `equations`."""

    model: Sequence[str] = option(
        (), "NAME", "Model to write out; several make one page (default: the first of the scene, else "
        "direct_dynamics).", kinds.TEXTS, names=rows.model_names,
    )  # fmt: skip
    _: KW_ONLY
    announce: Announce = rows.announce_row()


class Trading(RequestedModels):
    """Builds to compare, and the states and rounds of their measurement."""

    merge_angles: float | None = rows.merge_angles_row()
    effort: str = option(
        "usual", "NAME", "Builds that are tried: {names} (quick: one compiler with its best flags; all: every "
        "combination, however long it takes).", names=lambda: rows.EFFORTS, gone=("--quick=quick", "--all=all"),
    )  # fmt: skip
    extreme: bool = switch("Measure at extreme states instead of moderate ones.")
    states: int = option(
        20_000, "N", "States to measure errors at; more make the bound at other states tighter.", kinds.WHOLE,
        least=1, most=1_000_000,
    )  # fmt: skip
    within: str | float | Mapping[str, str | float] = rows.within_row()
    keep: str = rows.keep_row()
    guaranteed: str = rows.guaranteed_row()
    limits: str = rows.limits_row()
    rounds: int = option(15, "N", "Rounds of timing.", kinds.WHOLE, least=1, most=10_000)
    seed: int = rows.seed_row()
    watched: StepProgress | None = argument(None, "Called with a step's name; returns a callback that counts its work.")


class Drawing(Options):
    """Position of a drawn machine."""

    at: Values = rows.at_row()
    scene: SceneLike = rows.scene_row("of locked joints")
    values: Values = rows.values_row()


class Viewing(Options, kw_only=False):
    """Contents of the page of a machine."""

    scene: SceneLike = rows.scene_row(
        "whose joints are locked, and whose [motion] is simulated and played (default: those of MACHINE)"
    )
    _: KW_ONLY
    at: Values = rows.at_row()
    values: Values = rows.values_row()
    announce: Announce = rows.announce_row()
    progress: Progress = rows.progress_row()


class Serving(Options):
    """Address of the live page of a machine."""

    port: int = option(0, "N", "TCP port (0: any free one).", kinds.WHOLE, least=0, most=65535)


class Reporting(Options, kw_only=False):
    """Contents of the report of a machine."""

    scene: SceneLike = rows.scene_row("of locked joints, [motion] and [wanted]")
    _: KW_ONLY
    values: Values = rows.values_row()
    announce: Announce = rows.announce_row()
    progress: Progress = rows.progress_row()


# Vibration


class OperatingPoint(Options):
    """State about which a machine is linearized, and its held motors."""

    at: Values = rows.at_row(", or initial guess for another joint")
    torques: Values = option(
        {}, "MOTOR=X", "Torque or force of a motor that is free to move to its equilibrium.", kinds.NUMBERS,
        unit=of_joints("torque"),
    )  # fmt: skip
    rates: Values = option(
        {}, "JOINT=X", "Velocity of a joint, with --as-given.", kinds.NUMBERS, unit=of_joints("velocity")
    )
    as_given: bool = switch("Use --at, --rate and --torque as the state instead of an equilibrium.")
    hold: Sequence[str] = option(
        (), "MOTOR|all", "Motor that is held (default: motors are free).", kinds.TEXTS, of_machine=rows.motors_or_all
    )
    pd: Gains | None = option({}, "MOTOR=KP:KD", "Gains of a motor's position controller.", kinds.GAINS, unit=of_gains)
    hover: bool = switch("Balance a floating base by a force and a moment of constant direction.")
    thrusts: Mapping[str, float | None] | None = option(
        {}, "FRAME.fz[=X]", "Force or moment that turns with its frame and carries a floating base (fx ... mz, N or "
        "N m; computed without X).", kinds.NUMBERS_OR_NONE, unit=of_signals,
    )  # fmt: skip


class Signals(Options):
    """Inputs and outputs of a linear model."""

    inputs: Sequence[str] = option(
        (), "NAME", "Input: motor_x.tau, tool.fx ... tool.mz (default: all motors).", kinds.TEXTS
    )
    outputs: Sequence[str] = option(
        (), "NAME", "Output: motor_x.q, tool.x, tool.vx, tool.ax, 'tool at (0.1, 0, L2).rz' ... (default: encoders of "
        "the motors).", kinds.TEXTS,
    )  # fmt: skip


class ParametersAndScene(Options):
    """Values of parameters, and a scene that locks joints."""

    values: Values = rows.values_row()
    scene: SceneLike = rows.scene_row("of locked joints")


class Evaluating(RequestedModels):
    """Options of `evaluate`."""

    at: Values = option(
        {}, "JOINT=X", "Position of a joint, rad or m; with JOINT.qd its velocity, .qdd acceleration, .tau torque "
        "(default 0).", kinds.NUMBERS, unit=of_states,
    )  # fmt: skip
    values: Values = rows.values_row()


class Reaching(ParametersAndScene):
    """Options of `ik`."""

    frame: str = rows.frame_row()
    position: Sequence[float] = option(
        ..., "X,Y,Z", "Wanted position of the frame in frame 0, m.", kinds.POINT, unit="m"
    )
    orientation: Sequence[float] | None = option(
        None, "A,B,C", "Wanted orientation: angles, rad, about the fixed axes x, y and z of frame 0, in this order "
        "(default: free).", kinds.POINT, unit="rad",
    )  # fmt: skip
    at: Values = rows.at_row(": solutions near it come first")
    starts: int = option(
        30, "N", "Positions from which the search starts, within the limits.", kinds.WHOLE, least=1, most=1000
    )
    seed: int = rows.seed_row()


class Yielding(ParametersAndScene):
    """Options of `stiffness`."""

    frame: str = rows.frame_row()
    at: Values = rows.at_row(", or initial guess for another joint")
    along: Mapping[str, Sequence[float]] = rows.along_row()


class CountingModes(Options):
    """Options of `flexible_parts`."""

    frame: str = rows.frame_row()
    at: Values = rows.at_row()
    within: float | None = option(
        None, "X%", "Of a machine: try fewer joints or modes, up to errors below X%.", kinds.NUMBER, unit=""
    )


class Placed(Options, kw_only=False):
    """An operating point given as one object."""

    point: OperatingPoint | None = argument(
        None, "The operating point as an object; options by name replace its entries."
    )


class Linearizing(ParametersAndScene, Signals, OperatingPoint, Placed):
    """Options of `linearize`."""


class Oscillating(ParametersAndScene, OperatingPoint, Placed):
    """Options of `modes`."""


class TuningDrives(ParametersAndScene):
    """Options of `tune`."""

    optimum: bool = switch("Compute all gains together: the least peak compliance at these modulus margins.")
    rule: bool = switch("Also gains by published rules: amount and symmetrical optimum, Kv = 1/(4 T_v).")
    modulus: float = option(
        0.5, "X", "Modulus margin of velocity loops, the least |1 + L|, for the largest gain.", kinds.NUMBER,
        above=0, most=0.95,
    )  # fmt: skip
    position_modulus: float = option(
        0.7, "X", "Modulus margin of position loops, for the largest gain.", kinds.NUMBER, above=0, most=0.95
    )
    damping: float = rows.damping_row()
    along: Mapping[str, Sequence[float]] = rows.along_row()
    at: Values = rows.at_row(", or initial guess for another joint")
    compliances: Sequence[str] = option(
        (), "NAME", "Position whose displacement by a force there is computed: tool.x (default: x, y, z of the last "
        "fixed frame).", kinds.TEXTS,
    )  # fmt: skip
    progress: Progress = rows.progress_row()


class Controlling(TuningDrives):
    """Options of `control`."""

    tune: bool = switch('Compute all gains, not only those that the file calls "tuned".')


class Cutting(ParametersAndScene):
    """Options of `lobes`."""

    direction: str = option(
        ..., "NAME", "Output along which the cutting force acts: tool.x, 'tool at (0.1, 0, L2).x'; in milling, along "
        "which the tool moves through the workpiece.", kinds.TEXT,
    )  # fmt: skip
    cutting: float = option(
        ..., "K", "Cutting coefficient, N/m2: force per area of the chip (steel some 2e9).", kinds.NUMBER, unit="N/m2"
    )
    across: str | None = option(
        None, "NAME", "Milling: the output at right angles to --direction in the plane of the tool's teeth, which move "
        "from it to --direction (clockwise with x and y).", kinds.TEXT,
    )  # fmt: skip
    radial: float | None = option(
        None, "K", "Milling: coefficient of the radial force, N/m2 (often a third of --cutting).", kinds.NUMBER,
        least=0, unit="N/m2",
    )  # fmt: skip
    immersion: float | None = option(
        None, "SHARE", "Milling: radial width of the cut over the diameter of the tool (default 1, a slot).",
        kinds.NUMBER, above=0, most=1, unit="",
    )  # fmt: skip
    down: bool = switch("Down (climb) milling (default: up milling).")
    intervals: int | None = option(
        None, "N", "Depths also by semi-discretization with N intervals between two teeth: forces that change as teeth "
        "turn (default: none).", kinds.WHOLE, least=4, most=2000,
    )  # fmt: skip
    thickness: str = option(
        "", "NAME", "Output along which the chip gets thicker, -tool.y for the opposite sense (default: that of the "
        "force).", kinds.TEXT,
    )  # fmt: skip
    teeth: int = option(1, "N", "Teeth that pass a point of the workpiece in a turn.", kinds.WHOLE, least=1, most=1000)
    speeds: tuple[float, float, int] | None = option(
        None,
        "LOW:HIGH:COUNT",
        "Spindle speeds, turns per minute, even in 1/speed (default: 1000:20000:200).",
        kinds.SPEEDS,
    )
    damping: float = rows.damping_row()
    along: Mapping[str, Sequence[float]] = rows.along_row()
    at: Values = rows.at_row(", or initial guess for another joint")
    progress: Progress = rows.progress_row()


class Frequencies(Options):
    """Frequencies of a response, and damping that is added to it."""

    frequencies: Sequence[float] | Array | None = option(
        (), "HZ", "Frequency, Hz, at which the magnitude of a response is computed.", kinds.LIST, unit="Hz"
    )
    damping: float = rows.damping_row()


class Responding(Frequencies, ParametersAndScene, Signals, OperatingPoint, Placed):
    """Options of `response`."""

    band: tuple[float, float, int] | None = option(
        None, "LOW:HIGH[:COUNT]", "Band of frequencies, Hz, on a logarithmic scale (default: around all poles).",
        kinds.BAND, gone=("--frequencies",),
    )  # fmt: skip


class Comparing(Options, kw_only=False):
    """Options of `compare`."""

    motion: str | Path | None = rows.motion_row(
        "Motion of all joints with torques, or of the motors alone (springs follow), .csv or .npz (default: a move)."
    )
    _: KW_ONLY
    at: Values = rows.at_row(", or initial guess for another joint")
    values: Values = rows.values_row()
    ratios: Values = option(
        {}, "MOTOR=N", "Gear ratio: turns of the rotor per turn of its joint; couples them in the full model.",
        kinds.NUMBERS,
    )  # fmt: skip
    stroke: float = option(0.1, "X", "Stroke of the move, of every motor, rad or m.", kinds.NUMBER, unit=rows.POSITION)
    duration: float | None = rows.duration_row()
    free_motors: bool = switch(
        "Compute natural frequencies with free motors instead of held ones.", gone=("--free", "free")
    )
    scene: SceneLike = rows.scene_row("of locked joints")
    progress: Progress = rows.progress_row()


class Following(Options, kw_only=False):
    """Options of `feed_forward`."""

    motion: str | Path | None = rows.motion_row(
        "Reference trajectory: .csv or .npz with t, y_<motor>, yd_<motor> ..., or positions only (default: a move). "
        "Where motors follow from loops, as in a delta, y_<joint> of the independent joints."
    )
    _: KW_ONLY
    strokes: Values | float = option(
        {}, "[MOTOR=]X", "Stroke of the move, rad or m (default: 0.1 for every motor).", kinds.NUMBERS_OR_DEFAULT,
        unit=rows.POSITION,
    )  # fmt: skip
    duration: float | None = rows.duration_row()
    start: Values = rows.start_row()
    degree: int | None = option(
        None, "N", "Degree of the splines of a move, or through the positions of a file (default: one more than "
        "necessary).", kinds.WHOLE,
    )  # fmt: skip
    sample_rate: float | None = rows.sample_rate_row(None)
    values: Values = rows.values_row()
    scene: SceneLike = rows.scene_row("of locked joints")


# Motions


class EvenSteps(Options):
    """Options of integration with equal steps: method and step."""

    method: str | None = option(
        None, "NAME", "Method of even steps: {names} (default: the cheapest by prediction).", names=rows.method_names
    )
    step: float | None = option(
        None, "S", "Step of a simulation, s (default: the longest that is accurate enough).", kinds.NUMBER, unit="s"
    )


class Integrating(EvenSteps):
    """How to integrate: even steps of a method, or steps that are adapted and locate events."""

    adaptive: bool = switch("Steps of scipy's DOP853 or Radau, adapted to the motion.")
    events: Values = option(
        {},
        "JOINT.q=X",
        "Event: a joint's position (.q) or velocity (.qd) crosses a level.",
        kinds.NUMBERS,
        unit=of_signals,
    )
    stop: bool = switch("End the motion at the first event.")


class Simulating(Integrating, kw_only=False):
    """Options of `simulate`."""

    scene: SceneLike = rows.scene_row("with [motion], or several, [wanted] and [scene] (default: those of MACHINE)")
    _: KW_ONLY
    values: Values = rows.values_row()
    announce: Announce = rows.announce_row()
    progress: Progress = rows.progress_row()


class Climbing(Options, kw_only=False):
    """Options of `ladder`."""

    scene: SceneLike = rows.scene_row("with the tables [motion] and [wanted]")
    _: KW_ONLY
    box: Ranges | None = option(
        {}, "JOINT=LOW:HIGH", "Range of positions at which the motion may start, rad or m.", kinds.RANGES,
        gone=("--from",), unit=rows.POSITION,
    )  # fmt: skip
    starts: int = option(
        20, "N", "Start positions in the ranges of --box, a Latin hypercube.", kinds.WHOLE,
        least=1, most=1000,
    )  # fmt: skip
    budget: bool = switch(
        "Spend the tolerances on springs, numbers of bodies, steps and precision together, whichever saves the most "
        "operations for its error, and simulate the model at the end."
    )
    announce: Announce = rows.announce_row()
    progress: Progress = rows.progress_row()


class Reducing(Options, kw_only=False):
    """Options of `reduce`."""

    scene: SceneLike = rows.scene_row("with the table [motion] (default: that of MACHINE)")
    _: KW_ONLY
    to: Values = option(
        {}, "SIGNAL=X", "Tolerance of an output, tool.x=5um (default: those of [wanted]).", kinds.NUMBERS,
        unit=of_signals,
    )  # fmt: skip
    for_: str = option(
        "", "PURPOSE", "What the reduced model is for: {names} (default: both if motors are controlled).",
        names=rows.purpose_names,
    )  # fmt: skip
    proven: bool = switch("Prove the torque errors over the operating range, instead of 95 % confidence.")
    only: Sequence[str] = option(
        (), "PART", "What may be left out: {names} (default: all).", kinds.TEXTS, names=rows.part_names
    )
    rate: float | None = option(
        None, "HZ", "Rate of the controller: a period is a whole number of steps.", kinds.NUMBER, unit="Hz", above=0
    )
    processor: str = rows.processor_row("whose instructions are counted; torques in the precision of its unit")
    announce: Announce = rows.announce_row()
    progress: Progress = rows.progress_row()


class Sweeping(Frequencies, Signals, EvenSteps, OperatingPoint, Placed):
    """Options of `sweep`."""

    over: Over = option(
        {}, "NAME=VALUES", "Values of a parameter, of a number of the table (ram.stiffness, ram.k) or of a position "
        "(q.motor_x): LOW:HIGH:COUNT[,log] or X1,X2,...; with --samples LOW:HIGH[,log], normal:MEAN:DEVIATION or "
        "lognormal:MEDIAN:DEVIATION; tolerance[:COUNT] of a parameter, limits[:COUNT] of a position: as the machine "
        "file has them.", kinds.AXES, unit=of_parameters,
    )  # fmt: skip
    of: Of = option(
        "modes", "NAME", "Analysis at each point: {names}.", names=lambda: rows.ANALYSES,
        in_python="Or a function of the machine (and of the positions, a dictionary) that returns a dictionary of "
        "numbers.",
    )  # fmt: skip
    samples: int | None = option(None, "N", "Number of random points (instead of a grid).", kinds.WHOLE)
    sampling: str | None = option(
        None,
        "NAME",
        "Sampling of points: latin (a Latin hypercube, default), random or sobol.",
        names=rows.sampling_names,
    )
    seed: int | None = option(None, "N", "Random seed (default 0).", kinds.WHOLE)
    results: Sequence[str] = option(
        (), "NAME", "Result to keep, or a pattern such as 'frequency_*' (default: all).", kinds.TEXTS,
        gone=("--figure", "figures"),
    )  # fmt: skip
    require: Ranges = option(
        {}, "RESULT=LOW:HIGH", "Range that a result, or each of a pattern, is to be in ('*_modulus=0.4:'; LOW: or "
        ":HIGH): the share of points at which it is, of a sample with its interval of 95 % confidence.", kinds.BOUNDS,
    )  # fmt: skip
    workers: int = option(1, "N", "Worker processes; 0: one per core.", kinds.WHOLE)
    scheduler: str | None = option(None, "ADDRESS", "Dask scheduler for the points: tcp://host:8786.")
    journal: str | Path | None = argument(
        None, "A file to which each point is written when it is computed; a sweep that was interrupted goes on from "
        "there. The file stays at the end, and an equal sweep reads its results from it."
    )  # fmt: skip
    values: Values = rows.values_row()
    scene: SceneLike = rows.scene_row("with [motion] and [wanted], or of locked joints")
    progress: Progress = rows.progress_row()
