"""Expressions prepared to be evaluated many times."""

from __future__ import annotations

import random

from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate, multiprecision
from symoro_elastic.symbolic.tape import Tape
from tests.analysis.ladder.scenes import two_axis


def test_a_tape_has_the_values_of_evaluate_to_the_last_bit() -> None:
    """Of expressions with all kinds of operands, constants among the roots, in floats and in 50 digits."""
    motion = EquationsOfMotion(two_axis())
    roots = [*motion.residual, 0, motion.potential, 3]
    source = random.Random(1)
    names = sorted(set(motion.parameters) | {x.operands[0] for x in motion.bound.q.values()})
    for arithmetic in (FLOATS, multiprecision(50)):
        tape = Tape(roots, arithmetic)
        for _ in range(2):
            symbols = {name: arithmetic.number(source.randint(-9, 9)) for name in names}
            for block in (motion.bound.qd, motion.bound.qdd, motion.bound.tau):
                symbols |= {x.operands[0]: arithmetic.number(source.randint(-9, 9)) for x in block.values()}
            value = evaluate(roots, symbols, arithmetic)
            assert tape.values(symbols) == [value(x) for x in roots]
