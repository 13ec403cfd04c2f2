"""A spring beside a motor: both turn about one axis, and the spring counts whole turns."""

from __future__ import annotations

import numpy as np
import pytest

from symoro_elastic.machine.formats import toml
from symoro_elastic.numerics.verify import verify
from tests.compiled_models import numpy_package

STIFFNESS, DAMPING, NEUTRAL = 5.0, 0.2, 0.4
MACHINE = """
name = "balanced_arm"
gravity = [0, -9.81, 0]
joints = [
  {{ name = "column", antecedent = 0, kind = "motor", sigma = 0, theta = "q1 + 0.3", alpha = "pi/3", r = 0.1 }},
  {{ name = "arm", kind = "motor", sigma = 0, d = 0.15, alpha = 0.3, theta = "q2" }},
  {{ name = "spring", antecedent = "column", kind = "elastic", sigma = 0, {spring} }},
  {{ name = "weld", antecedent = "spring", kind = "cut", sigma = 2 }},
  {{ name = "meets", antecedent = "arm", kind = "fixed", sigma = 2{meets} }},
]
[loops]
balance = {{ cut = "weld", meets = "meets", dependent = ["spring"], start = {{ q2 = 0, q3 = 0 }} }}
[springs]
spring = {{ stiffness = 5, damping = 0.2, neutral = 0.4 }}
[bodies]
column = {{ mass = 1, center_of_mass = [0.07, 0, 0.01], inertia = [0.001, 0.003, 0.003] }}
arm = {{ mass = 1, center_of_mass = [0.22, 0.1, 0], inertia = [0.001, 0.02, 0.02] }}
"""
