"""Coefficients of Rosenbrock-W methods, written as they are printed in their sources.

Stage i of a step of size h of y' = f(t, y), with T any approximation of df/dy, is

    Y_i = y + h sum_{j<i} a_ij k_j,    w_i = sum_{j<i} (gamma_ij / gamma) k_j,
    (I - gamma h T) z_i = f(t + c_i h, Y_i) + w_i,    k_i = z_i - w_i,    c_i = sum_j a_ij,

and y(t + h) = y + h sum_i b_i k_i. The order holds whatever T is.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from symoro_elastic.codegen.integration.tableaus import Coefficients, row
from symoro_elastic.quantities.time_steps import TimeStep


@dataclass(frozen=True)
class WMethod:
    """A W-method: `gamma`, strictly lower rows a and gamma_ij, weights b, weights of an embedded method.

    `embedded` is empty where the source gives none; its order is one less.
    """

    name: str
    title: str
    order: int
    gamma: Fraction
    a: tuple[Coefficients, ...]
    g: tuple[Coefficients, ...]
    b: Coefficients
    embedded: Coefficients = ()

    @property
    def c(self) -> Coefficients:
        """Times of the stages in steps: c_i = sum_j a_ij."""
        return tuple(sum(each, Fraction(0)) for each in self.a)

    @classmethod
    def from_text(cls, name: str, title: str, order: int, gamma: str, text: str) -> WMethod:
        """Return the method of a text: lines `a_i1 a_i2 ... | gamma_i1 gamma_i2 ...`, then `b | embedded`."""
        *stages, weights = [line.split("|") for line in text.strip().splitlines()]
        b, embedded = map(row, weights)
        a, g = (tuple(row(stage[k]) for stage in stages) for k in range(2))
        return cls(name, title, order, Fraction(gamma), a, g, b, embedded)


W2 = WMethod.from_text(
    TimeStep.W2,
    "W-method ROS2, order 2",
    2,
    "0.29289321881345247560",
    """
        |
    1   | -0.58578643762690495120
    1/2 1/2 |
    """,
)
"""ROS2 with gamma = 1 - 1/sqrt(2): Verwer, Spee, Blom and Hundsdorfer, A second-order Rosenbrock method applied to
photochemical dispersion problems, SIAM J. Sci. Comput. 20 (1999), equation 4 and gamma_21 = -2 gamma."""
W3 = WMethod.from_text(
    TimeStep.W3,
    "W-method ROS34PW2, order 3",
    3,
    "0.43586652150845900",
    """
                                                                 |
    0.87173304301691801                                          | -0.87173304301691801
    0.84457060015369423 -0.11299064236484185                     | -0.90338057013044082  0.054180672388095326
    0                    0                   1                   |  0.24212380706095346 -1.2232505839045147   0.54526025533510214
    0.24212380706095346 -1.2232505839045147  1.5452602553351020  0.43586652150845900 | 0.37810903145819369 -0.096042292212423178 0.5 0.21793326075422950
    """,  # noqa: E501
)
"""ROS34PW2: Rang and Angermann, New Rosenbrock W-methods of order 3 for partial differential algebraic equations of
index 1, BIT 45 (2005), table 5."""
