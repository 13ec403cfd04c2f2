"""Coefficients of Rosenbrock methods for exact derivatives, written as they are printed in their sources.

Stage i of a step of size h of y' = f(t, y), with J = df/dy and f_t = df/dt at the start of the step, is

    (1/(gamma h) I - J) u_i = f(t + alpha_i h, y + sum_{j<i} a_ij u_j) + sum_{j<i} (c_ij / h) u_j + gamma_i h f_t,

and y(t + h) = y + sum_i m_i u_i.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from symoro_elastic.codegen.integration.tableaus import Coefficients, row
from symoro_elastic.quantities.time_steps import TimeStep


@dataclass(frozen=True)
class Rosenbrock:
    """A Rosenbrock method: strictly lower rows a and c_ij, alpha_i, gamma_i, weights m and embedded ones."""

    name: str
    title: str
    order: int
    gamma: Fraction
    alpha: Coefficients
    gammas: Coefficients
    a: tuple[Coefficients, ...]
    c: tuple[Coefficients, ...]
    m: Coefficients
    embedded: Coefficients

    @classmethod
    def from_text(cls, name: str, title: str, order: int, gamma: str, text: str) -> Rosenbrock:
        """Return the method of lines `alpha_i gamma_i | a_i1 ... | c_i1 ...`, then `| m | embedded`."""
        *stages, (_, weights, embedded) = [line.split("|") for line in text.strip().splitlines()]
        times, a, c = (tuple(row(stage[k]) for stage in stages) for k in range(3))
        alpha, gammas = (tuple(each[k] for each in times) for k in range(2))
        return cls(name, title, order, Fraction(gamma), alpha, gammas, a, c, row(weights), row(embedded))


RODAS4 = Rosenbrock.from_text(
    TimeStep.RODAS4,
    "Rosenbrock method RODAS, order 4",
    4,
    "0.25",
    """
    0      0.25               |                                                                          |
    0.386 -0.1043             | 1.544                                                                    | -5.6688
    0.21   0.1035             | 0.9466785280815826 0.2557011698983284                                    | -2.430093356833875  -0.2063599157091915
    0.63  -0.0362             | 3.314825187068521  2.896124015972201 0.9986419139977817                  | -0.1073529058151375 -9.594562251023355 -20.47028614809616
    1      0                  | 1.221224509226641  6.019134481288629 12.53708332932087 -0.6878860361058950   |  7.496443313967647  -10.24680431464352 -33.99990352819905  11.70890893206160
    1      0                  | 1.221224509226641  6.019134481288629 12.53708332932087 -0.6878860361058950 1 |  8.083246795921522  -7.981132988064893 -31.52159432874371  16.31930543123136 -6.058818238834054
    | 1.221224509226641 6.019134481288629 12.53708332932087 -0.6878860361058950 1 1 | 1.221224509226641 6.019134481288629 12.53708332932087 -0.6878860361058950 1 0
    """,  # noqa: E501
)
"""RODAS: Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.7; its code prints the coefficients,
with an embedded method of order 3."""
