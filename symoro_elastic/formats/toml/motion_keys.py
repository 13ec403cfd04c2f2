"""The tables [motion] and [wanted] of a machine file or scene: their keys, a row each."""

from __future__ import annotations

from symoro_elastic.formats.toml.key import (
    NAMED,
    NUMBER,
    NUMBER_OR_NUMBERS,
    NUMBERS,
    TEXT,
    TEXTS,
    TRUTH,
    Key,
    Section,
    Type,
    list_of_numbers,
)
from symoro_elastic.formats.toml.tables import Table
from symoro_elastic.machine.prescribed_motion import WRENCH, BaseStart

_OF_BASE = BaseStart()

MOTOR = Key("motor", NAMED, "motor that moves, by name or variable", '"motor_x"')
FROM = Key("from", NUMBER, "time at which it begins", "0.1", default=0.0, unit="s")
IN = Key("in", NUMBER, "time that it takes", "0.15", unit="s")

MOVES = Section(
    "moves of [motion]",
    "Moves from rest to rest, by 35 x^4 - 84 x^5 + 70 x^6 - 20 x^7: velocity, acceleration and jerk are zero at both "
    "ends.",
    (MOTOR, Key("by", NUMBER, "stroke", "0.08", unit="rad or m"), FROM, IN),
    rows=True,
)
WOBBLES = Section(
    "wobbles of [motion]",
    "Oscillations: amplitude times sin(2 pi frequency t), over the whole motion. Each is faded in over its first "
    "period and out over its last, so that it begins and ends at rest with steady acceleration and jerk.",
    (
        MOTOR,
        Key("amplitude", NUMBER, "amplitude", "1e-3", unit="rad or m"),
        Key("frequency", NUMBER, "frequency", "25", unit="Hz"),
    ),
    rows=True,
)
GAINS = (
    Key("kp", NUMBER, "gain of the position error", "2e6", otherwise="bandwidth instead", unit="N m/rad or N/m"),
    Key("kd", NUMBER, "gain of the velocity error", "3e4", otherwise="damping instead", unit="N m s/rad or N s/m"),
)
BANDWIDTH = (
    Key("bandwidth", NUMBER, "frequency of the motor, springs locked", "25", otherwise="kp instead", unit="Hz"),
    Key("damping", NUMBER, "its damping ratio", "0.8", otherwise="kd instead"),
)
_NEEDED = {key.name: [other.name] for pair in (GAINS, BANDWIDTH) for key, other in (pair, pair[::-1])}
_NOT_BOTH = {key.name: {"properties": {other.name: False for other in BANDWIDTH}} for key in GAINS}
SERVO = Section(
    "servo of [motion]",
    "Position controllers: of all motors, or of none. Gains kp and kd, or bandwidth and damping: kp = m (2 pi f)^2, "
    "kd = 2 zeta m (2 pi f), with m the inertia of the motor at the start, springs locked.",
    (*GAINS, *BANDWIDTH),
    "motor",
    rules={"dependentRequired": _NEEDED, "dependentSchemas": _NOT_BOTH, "minProperties": 2},
)
FORCES = Section(
    "forces of [motion]",
    "Forces and moments on frames, in axes of frame 0, which rise smoothly and then stay.",
    (
        Key("at", NAMED, "frame on whose origin it acts", '"tool"'),
        *(
            Key(
                *(name, NUMBER, f"{'force' if name[0] == 'f' else 'moment'} along {name[1]} of frame 0", "200"),
                default=0.0,
                unit="N" if name[0] == "f" else "N m",
            )
            for name in WRENCH
        ),
        FROM,
        IN,
    ),
    rows=True,
)
BASE_START = Section(
    "base of [motion]",
    "Start of a floating base, and the wrench on it, in its axes. It is let go at time 0, with the springs at the "
    "equilibrium that they have on a base held there.",
    (
        Key(
            *("position", list_of_numbers(3), "position of its origin in the world", "[0, 0, 2]"),
            default=_OF_BASE.position,
            otherwise="0",
            unit="m",
        ),
        Key(
            *("orientation", list_of_numbers(4, 9), "quaternion w x y z, or rotation to axes of the world by rows"),
            "[1, 0, 0, 0]",
            default=_OF_BASE.orientation,
            otherwise="axes of the world",
        ),
        Key(
            *("velocity", list_of_numbers(6), "velocity of its origin, then angular velocity", "[0, 0, 0, 0, 0, 0.5]"),
            default=_OF_BASE.velocity,
            otherwise="0",
            unit="m/s and rad/s",
        ),
        Key(
            *("wrench", list_of_numbers(6), "force, then moment about its origin; its weight is not included"),
            "[0, 0, 34.3, 0, 0, 0]",
            default=_OF_BASE.wrench,
            otherwise="0",
            unit="N and N m",
        ),
    ),
)
BASE = Key(
    *("base", BASE_START.type, "start of a floating base, and the wrench on it", "{ velocity = [0, 0, 0, 0, 0, 0.5] }"),
    otherwise="at rest in axes of the world, without a wrench",
)
MOTION = Section(
    "[motion]",
    "A motion of the motor coordinates: the sum of moves, wobbles and a record. Springs start at "
    "equilibrium. Values are numbers, or formulas of numbers in quotes. Several motions: [[motion]] for each.",
    (
        Key(
            *("start", NUMBERS, "positions of motors, and of other joints where the search for equilibrium begins"),
            "{ motor_x = 0.1 }",
            default={},
            otherwise="0, the start of loops, neutral positions of springs",
            unit="rad or m",
        ),
        Key("duration", NUMBER, "simulated time, from 0", "0.25", unit="s"),
        Key(
            *("moves", MOVES.type, "moves from rest to rest"),
            '[{ motor = "motor_x", by = 0.08, from = 0.05, in = 0.15 }]',
            default=(),
        ),
        Key(
            *("wobbles", WOBBLES.type, "oscillations"),
            '[{ motor = "motor_x", amplitude = 1e-3, frequency = 25 }]',
            default=(),
        ),
        Key(
            *("file", TEXT, "record beside this file: t, y_<motor>, yd_<motor> ... of the coordinates of all motors"),
            '"move.csv"',
            default="",
            otherwise="none",
        ),
        Key(
            *("servo", SERVO.type, "position controllers: bandwidth and damping, or kp and kd"),
            "{ motor_x = { bandwidth = 25, damping = 0.8 } }",
            default={},
            otherwise="motors follow exactly",
        ),
        Key(
            *("drives", TRUTH, "whether the motors have the drives of the machine, [drives], in place of servos"),
            "true",
            default=False,
        ),
        Key(
            *("forces", FORCES.type, f"forces on frames: {', '.join(WRENCH)}"),
            '[{ at = "tool", fx = 200, from = 0.1, in = 0.01 }]',
            default=(),
        ),
        BASE,
    ),
)


def _motions(table: Table, key: str) -> list[Table]:
    return [table.table(key)] if isinstance(table.entries[key], dict) else table.tables(key)


MOTIONS = Key(
    "motion",
    Type(
        "table, or list of tables",
        {"anyOf": [MOTION.schema, {"type": "array", "items": MOTION.schema, "minItems": 1}]},
        _motions,
    ),
    "A motion to simulate, or several.",
    "",
    otherwise="none",
)
WANTED = Section(
    "[wanted]",
    "Requirements on a simulated motion, by which `simulate` and `ladder` choose.",
    (
        Key(
            *("tolerance", NUMBER_OR_NUMBERS, "largest error: a number for all outputs, or by signal"),
            '{ "tool.x" = 1e-6, "motor_x.tau" = 5 }',
            otherwise="none",
            unit="m or rad for a number, else the unit of the signal",
        ),
        Key(
            *("outputs", TEXTS, "output signals, as `linearize` names them"),
            '["tool.x", "tool.y"]',
            default=(),
            otherwise="those of the tolerance",
        ),
        Key("period", NUMBER, "period of a controller: a whole number of steps", "1e-3", otherwise="none", unit="s"),
        Key("time", NUMBER, "largest time of the steps of a period", "50e-6", otherwise="none", unit="s"),
    ),
)
OF_MOTION = (MOTION, MOVES, WOBBLES, SERVO, FORCES, BASE_START, WANTED)
"""The tables of motions and of what is wanted, in the order of the reference."""
