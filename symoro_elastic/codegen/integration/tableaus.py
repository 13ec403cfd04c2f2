"""Coefficients of time-stepping methods, as printed in their sources.

**Runge-Kutta**: Butcher tableaus.

**Rosenbrock**, for exact derivatives. Stage i of a step of size h of y' = f(t, y), with J = df/dy, f_t = df/dt at the
start of the step, is

    (1/(gamma h) I - J) u_i = f(t + alpha_i h, y + sum_{j<i} a_ij u_j) + sum_{j<i} (c_ij / h) u_j + gamma_i h f_t,

and y(t + h) = y + sum_i m_i u_i.

**Rosenbrock-W**, with T any approximation of df/dy:

    Y_i = y + h sum_{j<i} a_ij k_j,    w_i = sum_{j<i} (gamma_ij / gamma) k_j,
    (I - gamma h T) z_i = f(t + c_i h, Y_i) + w_i,    k_i = z_i - w_i,    c_i = sum_j a_ij,

and y(t + h) = y + h sum_i b_i k_i. The order holds whatever T is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

from symoro_elastic.quantities.time_steps import TimeStep

if TYPE_CHECKING:
    from symoro_elastic.foundation.array_types import Array

Coefficients = tuple[Fraction, ...]


@dataclass(frozen=True)
class Tableau:
    """Coefficients of an explicit Runge-Kutta method: nodes c, matrix A (strictly lower triangular), weights b."""

    name: str
    title: str
    order: int
    c: Coefficients
    A: tuple[Coefficients, ...]
    b: Coefficients

    @classmethod
    def from_text(cls, name: str, title: str, order: int, text: str) -> Tableau:
        """Return the tableau of a text: lines `c_i | a_i1 a_i2 ...`, the last one `| b_1 b_2 ...`."""
        *stages, (_, weights) = [line.split("|") for line in text.strip().splitlines()]
        nodes = tuple(Fraction(node) for node, _ in stages)
        return cls(name, title, order, nodes, tuple(row(entries) for _, entries in stages), row(weights))

    @cached_property
    def stages(self) -> tuple[tuple[float, tuple[float, ...]], ...]:
        """For each stage, the node c_i and row i of A, in double precision."""
        return tuple((float(c), tuple(map(float, row))) for c, row in zip(self.c, self.A, strict=True))

    @cached_property
    def weights(self) -> tuple[float, ...]:
        """The weights b in double precision."""
        return tuple(map(float, self.b))


def row(text: str) -> Coefficients:
    """Return the coefficients in a text, as exact fractions."""
    return tuple(map(Fraction, text.split()))


RK4 = Tableau.from_text(
    TimeStep.RK4,
    "classical Runge-Kutta method, order 4",
    4,
    """
    0   |
    1/2 | 1/2
    1/2 | 0    1/2
    1   | 0    0    1
        | 1/6  2/6  2/6  1/6
    """,
)
"""The classical method of fourth order: Kutta, Zeitschrift fuer Mathematik und Physik 46 (1901); Hairer, Norsett and
Wanner, Solving Ordinary Differential Equations I, section II.1, table 1.2."""


Rate: TypeAlias = "Callable[[float, Array], Array]"
"""f of y' = f(t, y)."""


# Steps of explicit Runge-Kutta methods.
def step(tableau: Tableau, rate: Rate, t: float, y: Array, h: float) -> Array:
    """Return y at t + h by one step for y' = f(t, y), where `rate` is f and y an array of any shape.

    k_i = f(t + c_i h, y + h sum_j a_ij k_j),    y(t + h) = y + h sum_i b_i k_i
    """
    k: list[Array] = []
    for c, row in tableau.stages:
        k.append(rate(t + c * h, _advance(y, h, row, k)))
    return _advance(y, h, tableau.weights, k)


def _advance(y: Array, h: float, weights: Iterable[float], k: Iterable[Array]) -> Array:
    """Return y + h sum_j a_j k_j; terms with a_j = 0 are omitted."""
    for a, rate in zip(weights, k, strict=True):
        if a:
            y = y + (h * a) * rate
    return y


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
        alpha, gammas = (tuple(row_of_times[k] for row_of_times in times) for k in range(2))
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
        return tuple(sum(weights, Fraction(0)) for weights in self.a)

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


@dataclass(frozen=True)
class Midpoint:
    """The implicit midpoint rule, y(t + h) = y + h k, k = f(t + h/2, y + h k/2).

    It has a fixed number of steps of Newton's method, each with the system of W-methods.
    """

    name: str
    title: str
    order: int
    iterations: int


MIDPOINT = Midpoint(TimeStep.MIDPOINT, "implicit midpoint rule, order 2", 2, 4)
"""Hairer, Lubich and Wanner, Geometric Numerical Integration, section II.1.1, one-stage Gauss method: it keeps the
energy of linear vibrations."""

Method: TypeAlias = Tableau | WMethod | Rosenbrock | Midpoint
METHODS: dict[str, Method] = {method.name: method for method in (W3, W2, RK4, RODAS4, MIDPOINT)}


def times_of(method: Method) -> Coefficients:
    """Return the nodes c of the stages, as fractions of a step."""
    if isinstance(method, Rosenbrock):
        return method.alpha
    return (Fraction(1, 2),) if isinstance(method, Midpoint) else method.c


def nodes_of(method: Method, driven: bool = False) -> Coefficients:
    """Return the nodes, as fractions of a step, with motor inputs: stages, and the end if motors are `driven`."""
    return tuple(dict.fromkeys((*times_of(method), *([Fraction(1)] if driven else []))))


def share_of_halving(method: Method) -> float:
    """Return the ratio of a step's error to its change by halving the step, 2^p / (2^p - 1) for order p."""
    return float(2**method.order / (2**method.order - 1))
