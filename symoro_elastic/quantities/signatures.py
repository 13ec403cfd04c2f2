"""The arguments and results of generated functions, and what derivatives are taken by: a row each."""

from __future__ import annotations

from symoro_elastic.quantities.quantity import Quantity, Role, Samples, time_derivative
from symoro_elastic.quantities.units import (
    ACCELERATION,
    DAMPING,
    FORCE,
    INERTIA,
    NUMBER,
    PLACEMENT,
    POSITION,
    STIFFNESS,
    VELOCITY,
    same,
)

ARGUMENT, RESULT, COLUMN = (Role.ARGUMENT,), (Role.RESULT,), (Role.COLUMN,)
BOTH = (*ARGUMENT, *RESULT)
STATE, CARRIED = (Role.STATE,), (Role.STATE, Role.CARRIED)
VELOCITIES, ACCELERATIONS, FORCES = Samples(2, (-6, 6)), Samples(5, (2, 8)), Samples(20, (2, 8))
HIGHEST_DERIVATIVE = 12
"""The highest derivative by time of a wanted motion that has a name."""
OR_ASKED = "or in those of the frame that is asked for, as in 'tool in base'"
"""How axes of twists are chosen."""

# fmt: off
OF_JOINTS = (
    Quantity("q", "joint variables", "q", POSITION, "n", (*BOTH, *COLUMN, *CARRIED), equations=(1,),
             plural="joint variables", is_word=True),
    Quantity("qd", "joint velocities", r"\dot{q}", VELOCITY, "n", (*BOTH, *COLUMN, *CARRIED), equations=(3,),
             entries="qd@", plural="joint velocities", samples=VELOCITIES, is_word=True),
    Quantity("tau", "motor torques or forces", r"\Gamma", FORCE, "m", (*BOTH, *COLUMN, *STATE), equations=(8, 61),
             entries="tau@", plural="motor torques", samples=FORCES, is_word=True),
    Quantity("qdd_motor", "motor accelerations", r"\ddot{q}", ACCELERATION, "m", (*ARGUMENT, *COLUMN, *STATE),
             equations=(10, 53), entries="qdd@", plural="motor accelerations", samples=ACCELERATIONS, is_word=True),
    Quantity("qdd", "joint accelerations", r"\ddot{q}", ACCELERATION, "n", (*BOTH, *STATE), equations=(34, 59),
             entries="qdd@", plural="joint accelerations", samples=ACCELERATIONS, is_word=True),
)
ON_BASE = (
    Quantity("R0", "rotation from the axes of the base to those of the world, 3 x 3, row by row", "A", NUMBER, "9",
             (*ARGUMENT, *CARRIED), index="0", entries=tuple(f"A0_{m}{n}" for m in range(1, 4) for n in range(1, 4)),
             rows=3),
    Quantity("Q0", "orientation of the base in the world, a quaternion w x y z of length 1, which is not normalised",
             "Q", NUMBER, "4", (*ARGUMENT, *CARRIED), index="0", entries=tuple(f"Q0_{x}" for x in "wxyz")),
    Quantity("P0", "position of the origin of the base in the world", "P", same("m"), "3", (*ARGUMENT, *CARRIED),
             index="0", entries=tuple(f"P0_{x}" for x in "xyz"), samples=Samples(10)),
    Quantity("V0", "velocity of the origin of the base, then its angular velocity", "V", VELOCITY, "6",
             (*ARGUMENT, *COLUMN, *CARRIED), frame="in its axes", index="0", equations=(3,),
             entries=tuple(f"V0_{k}" for k in range(1, 7)), plural="the velocity of the base", samples=VELOCITIES),
    Quantity("V0d", "acceleration of the origin of the base (dv/dt + w x v of V0), then its angular acceleration",
             r"\dot{V}", ACCELERATION, "6", (*BOTH, *COLUMN, *STATE), frame="in its axes", index="0", equations=(6,),
             entries=tuple(f"Vd0_{k}" for k in range(1, 7)), plural="the acceleration of the base",
             samples=ACCELERATIONS),
    Quantity("f0", "force on the base, then moment about its origin", "f", FORCE, "6", (*BOTH, *COLUMN, *STATE),
             frame="in its axes", note="its weight is not part of it", index="0", equations=(15,),
             entries=tuple(f"F0_{k}" for k in range(1, 7)), plural="the wrench on the base", samples=FORCES),
)
EXTERNAL = (
    Quantity("f_ext", "force, then moment about the origin, that the surroundings exert on frames that a scene names",
             "f", FORCE, "w x 6", (*ARGUMENT, *STATE), frame="in axes of frame 0", index=r"\mathrm{ext}",
             equations=(12,), entries=tuple(f"fe@_{k}" for k in range(1, 7)), samples=FORCES),
)
OF_FRICTION = (
    Quantity("z", "states of friction: deflections of bristles", "z", POSITION, "b", (*ARGUMENT, *CARRIED),
             entries="zf@", samples=Samples(0.1)),
    Quantity("zd", "rates of the states", r"\dot{z}", VELOCITY, "b", RESULT),
    Quantity("load", "torques through the transmissions of joints whose friction rises with load", r"\lambda", FORCE,
             "l", (*ARGUMENT, *STATE), entries="lf@", samples=FORCES),
)
COLUMNS = (
    Quantity("pose", "displacement of a floating base, then rotation vector, both small", "x", POSITION, "6", COLUMN,
             frame="in its axes", index="0", entries=tuple(f"pose_{k}" for k in range(1, 7)),
             as_column="pose: displacement, rotation (m, rad) in axes of the base, as are V0, V0d, f0"),
    Quantity("p", "parameters", "p", None, "columns", (*ARGUMENT, *COLUMN),
             as_column="the parameters that its columns name"),
)
_Y = Quantity("y", "outboard coordinates, a motor each: its own plus those of the springs behind it, in its sense", "y",
              POSITION, "m", (*ARGUMENT, *STATE), entries="y@_0")
_RATES = {1: "their velocities", 2: "their accelerations", 3: "their jerks"}
MOTION = (
    _Y,
    *(
        time_derivative(_Y, k, _RATES.get(k, f"their {k}th derivatives by time"))
        for k in range(1, HIGHEST_DERIVATIVE + 1)
    ),
)
"""y, yd, ydd ...: a `d` for each derivative by time."""
OF_FRAMES = (
    Quantity("T", "placement of each frame, row by row", "T", PLACEMENT, "frames x 4 x 4", BOTH, frame0=True,
             equations=(1, 2), entries=tuple(f"T0_{m}{n}" for m in range(1, 5) for n in range(1, 5)), rows=4),
    Quantity("P", "position of the origin of the frame", "P", same("m"), "3", ARGUMENT, equations=(1, 2),
             entries=tuple(f"T0_{m}4" for m in range(1, 4))),
    Quantity("V", "velocity of the origin, then angular velocity of each frame", "V", VELOCITY, "frames x 6", RESULT,
             frame=f"relative to frame 0 (the motion of a base included), in the frame's own axes {OR_ASKED}",
             equations=(3,)),
    Quantity("Vd", "acceleration of the origin, then angular acceleration of each frame", r"\dot{V}", ACCELERATION,
             "frames x 6", RESULT,
             frame=f"relative to frame 0 (the motion of a base included), in the frame's own axes {OR_ASKED}",
             equations=(6, 7)),
    Quantity("J", "Jacobian of each frame", "J", VELOCITY / VELOCITY, "frames x 6 x n", RESULT,
             frame=f"of the motion relative to frame 0, in axes of frame 0 {OR_ASKED}",
             note="velocities = jacobian qd on a base at rest, both in the same axes", equations=(3,), says_unit=False),
    Quantity("detJ", "determinant of the Jacobian", r"\det J", None, "1", RESULT, equations=(3,)),
    Quantity("Jinv", "inverse of the Jacobian, by joint and component", "J^{-1}", VELOCITY / VELOCITY, "n x components",
             RESULT, says_unit=False),
    Quantity("weights", "weights of the squares of joint velocities (or accelerations) whose sum is least, positive",
             "w", None, "components", ARGUMENT, entries="weight@"),
    Quantity("f", "force, then moment about the origin of its frame, that the antecedent exerts on each body", "f",
             FORCE, "frames x 6", RESULT, frame="in axes of the frame of the body", equations=(15, 35, 58)),
)
OF_STATIC_SPRINGS = (
    Quantity("q_static", "variables of the joints whose springs are static, in table order", "q^{E}", POSITION, "s",
             (*BOTH, *STATE), equations=(9, 35, 58)),
)
OF_MACHINES = (
    Quantity("A", "inertia matrix", "A", INERTIA, "n x n", RESULT, equations=(8,), columns_follow_rows=True),
    Quantity("A_packed", "lower triangle of the inertia matrix, row by row: entry i, j is at i(i + 1)/2 + j, from 0",
             r"A^{\mathrm{L}}", INERTIA, "n(n + 1)/2", RESULT, equations=(8,)),
    Quantity("H", "Coriolis, centrifugal, gravity and friction forces", "H", FORCE, "n", RESULT, equations=(8,)),
    Quantity("singularity",
             "zero where a solution is singular: product of the square roots and distances that vanish there",
             r"\Delta", None, "solutions", RESULT),
    Quantity("E", "kinetic energy, gravity energy (zero at the origin of frame 0) and elastic energy", "E", same("J"),
             "3", RESULT, equations=(8, 9)),
    Quantity("M", "inertia matrix", "M", INERTIA, "n x n", RESULT, equations=(8,)),
    Quantity("D", "damping: derivatives of motor torques by qd, friction included", "D", DAMPING, "n x n", RESULT,
             equations=(8,)),
    Quantity("K", "stiffness: derivatives of motor torques by q, those of springs, gravity and inertia", "K", STIFFNESS,
             "n x n", RESULT, equations=(8,)),
    Quantity("Y", "regressor: torques are Y times the parameters that its columns name", "Y", None, "n x columns",
             RESULT, equations=(15,)),
    Quantity("h", "energy regressor: energy is h times the parameters that its entries name, up to a constant", "h",
             None, "columns", RESULT, equations=(3, 13)),
    Quantity("X", "base inertial parameters; sums that are zero by the numbers of the table are left out", "X", None,
             "parameters", RESULT, equations=(13,)),
)
OF_CLOSED_CHAINS = (
    Quantity("q_dep", "variables of the joints that loops make dependent", "d", POSITION, "d", (*BOTH, *CARRIED),
             plural="dependent variables"),
    Quantity("x", "joint coordinates of all joints, dependent ones too", "x", POSITION, "joints", RESULT),
    Quantity("residual", "length of the closing errors of all loops: distances in m and small angles in rad", "r", None,
             "1", RESULT),
    Quantity("S", "derivatives of the positions of all joints by q", "S", VELOCITY / VELOCITY, "joints x n", RESULT,
             note="the velocity of a joint is its row of S times qd", says_unit=False),
    Quantity("gam", "accelerations of all joints where qdd is zero", r"\gamma", ACCELERATION, "joints", RESULT),
    Quantity("mu", "force, then moment, that the body of the frame met exerts on that of each cut joint", r"\mu", FORCE,
             "loops x 6", RESULT, frame="at the cut joint, in axes of the frame met",
             note="components that the loop leaves undetermined are zero"),
    Quantity("lam", "forces that couplings exert on the joints that have no variable of their own", r"\lambda", FORCE,
             "joints", RESULT),
)
OF_CONTROLLERS = (
    Quantity("measured", "measured positions that are controlled, over what they change with their motors", "q^{c}",
             POSITION, "m", ARGUMENT, entries="qc@"),
    Quantity("speed", "measured velocities of the motors", "v^{c}", VELOCITY, "m", ARGUMENT, entries="vc@"),
    Quantity("r", "set points of the motors", "r", POSITION, "m", ARGUMENT, entries="rs@"),
    Quantity("rd", "velocities of the set points", r"\dot{r}", VELOCITY, "m", ARGUMENT, entries="rsd@"),
    Quantity("rdd", "accelerations of the set points", r"\ddot{r}", ACCELERATION, "m", ARGUMENT, entries="rsdd@"),
    Quantity("zc", "states of the controllers", "z", None, "states", BOTH),
    Quantity("zc_next", "states of the controllers a period later", "z^{+}", None, "states", RESULT),
    Quantity("u", "set points of the torques, held over a period", "u", FORCE, "m", RESULT),
)
# fmt: on
