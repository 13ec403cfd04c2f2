"""The drives of a machine as expressions: parts of their chains, and names of their states.

Dead times are Pade approximations of order 2, whose transfer function is positive on the real axis. States are
scaled as in `analysis.control`, and in the order of `analysis.control.drive_laws`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.described import drives_of
from symoro_elastic.machine.drives import (
    MOTOR,
    NO_NUMBER,
    TUNED,
    Drive,
    Filter,
    LoadPosition,
    LowPass,
    Notch,
    why_no_current_loop,
)
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.kinematics import frames
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.drives.drive_chain import Block, Chain, Inputs, Limit, SetPoint, Winding
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from symoro_elastic.symbolic.functions import amount, minimum, square_root

SET_POINTS = ("r", "rd", "rdd")


def driven_motors(machine: Machine) -> Mapping[int, Drive]:
    """Return the drives of motors by joint, if time steps support all of them; else none."""
    numbers, drives = {machine.joint(j).name: j for j in machine.motors}, drives_of(machine).by_motor
    return {} if why_not_driven(machine) else {j: drives[name] for name, j in numbers.items() if name in drives}


def why_not_driven(machine: Machine) -> str:
    """Return why time steps cannot include the drives of a machine, with the way out; empty where they can.

    A gain that is still to be tuned has no value, the position of a load is known along a motion only, and samples of
    a controller are not in chains.
    """
    of = drives_of(machine)
    for name, drive in of.by_motor.items():
        if TUNED in (drive.Kv, drive.Kp, drive.Tn):
            return f"a gain of {name} is {NO_NUMBER}"
        if drive.measured != MOTOR and name not in of.loads:
            return f"{name} measures {drive.measured}, which is known along a motion only: simulate takes it"
        if drive.period is not None:
            return f"{name} has a period: its controller is the model control"
    return ""


def chains_of(bound: Bound) -> dict[int, Chain]:
    """Return the drives of a bound machine by joint of the motor; raises `InputError` for missing parts."""
    return {j: _chain(bound, j, drive) for j, drive in driven_motors(bound.machine).items()}


def state_names(machine: Machine, drives: bool) -> tuple[str, ...]:
    """Return names of the states of friction by joint, then, with `drives`, of drives by motor."""
    friction = [f"{machine.joint(j).name}.friction" for j in machine.bristles]
    chains = chains_of(Bound(machine)) if drives else {}
    return (*friction, *(f"{machine.joint(j).name}.{name}" for j, chain in chains.items() for name in chain.names))


def state_symbols(chains: Mapping[int, Chain], stem: str) -> dict[int, tuple[str, ...]]:
    """Return names of the variables of the states of drives, by motor."""
    return {j: tuple(f"{stem}{j}_{k}" for k in range(1, len(chain.names) + 1)) for j, chain in chains.items()}


def states_at_rest(machine: Machine, r: Sequence[float], rd: Sequence[float], tau: Sequence[float]) -> list[float]:
    """Return the steady states of all drives at the torques tau; r, rd, tau are by motor."""
    bound = Bound(machine, [parameter.name for parameter in machine.parameters])
    inputs = [tuple(map(bound.graph.symbol, (f"r{j}", f"rd{j}", f"tau{j}"))) for j in bound.motors]
    values_of_inputs = zip(inputs, zip(r, rd, tau, strict=True), strict=True)
    symbols = {x.operands[0]: value for names, row in values_of_inputs for x, value in zip(names, row, strict=True)}
    states = [x for j, chain in chains_of(bound).items() for x in chain.at_rest(*inputs[bound.motors.index(j)])]
    value = evaluate(states, symbols, FLOATS)
    return [float(value(x)) for x in states]


def inputs_of(bound: Bound, j: int) -> Inputs:
    """Return the inputs of the drive of a motor: set points, position, velocity, additional torque."""
    entries, k = bound.arguments(), bound.motors.index(j)
    r, rd, rdd = (bound.graph.symbol(entries[name][k]) for name in SET_POINTS)
    return Inputs(r, rd, rdd, controlled_position(bound, j), bound.rate(j), bound.tau[j])


def controlled_position(bound: Bound, j: int) -> Scalar:
    """Return the position that the drive of a motor controls: its own, or that of its load."""
    load = drives_of(bound.machine).loads.get(bound.machine.joint(j).name)
    if load is None:
        return bound.variables[j]
    return load.motor + (position_of_load(bound, load) - load.start) / load.ratio


def position_of_load(bound: Bound, load: LoadPosition) -> Scalar:
    """Return the position of a load."""
    if load.axis is None:
        return bound.variables[load.number]
    link = bound.fixed_link(load.number, load.at)
    carrier = frames(bound.mechanism)[link.antecedent]
    return (carrier.origin + carrier.rotation * link.transform.origin)[load.axis]


def _chain(bound: Bound, j: int, drive: Drive) -> Chain:
    if wrong := why_no_current_loop(drive, bound.machine.joint(j)):
        key, what = wrong.split(": ", 1)
        raise bound.machine.error(f"drives, {bound.machine.joint(j).name}, {key}", what)
    kp, kv, tn = (bound.cell(x) if isinstance(x, Formula) else 0 for x in (drive.Kp, drive.Kv, drive.Tn))
    integral = drive.Tn is not None
    controller = Block(("speed_integral",), ((0,),), (1,), (kp / tn,), kp) if integral else Block((), (), (), (), kp)
    filters = tuple(_filter(bound, section, f"filter_{k}") for k, section in enumerate(drive.filters, start=1))
    limit = _limit(bound, j, drive, tn if integral else 1)
    return Chain(
        *(kv, bound.cell(drive.velocity_forward), bound.cell(drive.acceleration_forward), controller),
        path=(*_behind(bound, drive), *(() if limit else filters)),
        set_point=_set_point(bound, drive),
        ahead=filters if limit else (),
        limit=limit,
        winding=_winding(bound, j, drive),
    )


def _limit(bound: Bound, j: int, drive: Drive, tn: Scalar) -> Limit | None:
    """Return the limit of the torque: the lower of the torque limit and the current limit times Kt."""
    levels = [bound.cell(x) for x in (drive.torque_limit,) if x is not None]
    if drive.current_limit is not None:
        levels.append(amount(bound.graph, _torque_constant(bound, j)) * bound.cell(drive.current_limit))
    if not levels:
        return None
    lowest = levels[0] if len(levels) == 1 else minimum(bound.graph, *levels)
    return Limit(bound.graph, lowest, 1 / (tn if drive.windup is None else bound.cell(drive.windup)))


def _winding(bound: Bound, j: int, drive: Drive) -> Winding | None:
    if drive.current is None:
        return None
    own, of = bound.machine.joint(j).electrics, drive.current
    Kt, ti, n = _torque_constant(bound, j), bound.cell(of.ti), _ratio(bound, j)
    back = bound.cell(own.torque_constant if own.back_emf.is_zero else own.back_emf) * n
    limit = None
    if drive.voltage_limit is not None:
        limit = Limit(bound.graph, amount(bound.graph, Kt) * bound.cell(drive.voltage_limit), 1 / ti)
    return Winding(
        *(bound.cell(of.kp), ti, bound.cell(own.resistance), bound.cell(own.inductance)),
        *(Kt * back, bound.cell(of.compensation)),
        limit=limit,
    )


def _ratio(bound: Bound, j: int) -> Scalar:
    ratio = bound.machine.joint(j).ratio
    return 1 if ratio.is_zero else bound.cell(ratio)


def _torque_constant(bound: Bound, j: int) -> Scalar:
    """Return the torque constant on the joint's axis, N m/A or N/A."""
    return bound.cell(bound.machine.joint(j).electrics.torque_constant) * _ratio(bound, j)


def _set_point(bound: Bound, drive: Drive) -> SetPoint | None:
    if not isinstance(drive.set_point, LowPass):
        return None
    return SetPoint(_filter(bound, drive.set_point, "set_point"), _angular(bound, drive.set_point))


def _behind(bound: Bound, drive: Drive) -> Iterator[Block]:
    """Yield the blocks between limit and motor: dead time (Pade) and lag."""
    delay = bound.cell(drive.dead_time) if drive.dead_time else 0
    if not _is_zero(delay):
        over = 1 / delay
        A = ((0, 12 * over), (-over, -6 * over))
        yield Block(("dead_time_1", "dead_time_2"), A, (0, over), (0, -12), 1)
    lag = bound.cell(drive.lag)
    if not _is_zero(lag):
        yield _first_order("torque", 1 / lag)


def _filter(bound: Bound, section: Filter, name: str) -> Block:
    w, names = _angular(bound, section), (f"{name}_1", f"{name}_2")
    if isinstance(section, Notch):
        below = bound.cell(section.width)
        return _biquad(names, w, below, (0, 2 * (bound.cell(section.depth) - below)), 1)
    if section.order == 1:
        return _first_order(name, w)
    return _biquad(names, w, square_root(bound.graph, 2) / 2, (1, 0), 0)


def _angular(bound: Bound, section: Filter) -> Scalar:
    return 2 * bound.graph.pi * bound.cell(section.frequency)


def _first_order(name: str, rate: Scalar) -> Block:
    return Block((name,), ((-rate,),), (rate,), (1,), 0)


def _biquad(names: tuple[str, str], w: Scalar, below: Scalar, C: tuple[Scalar, Scalar], D: Scalar) -> Block:
    return Block(names, ((0, w), (-w, -2 * below * w)), (0, w), C, D)


def _is_zero(x: Scalar) -> bool:
    return isinstance(x, int) and x == 0
