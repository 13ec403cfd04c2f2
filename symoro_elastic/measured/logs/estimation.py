"""Weighted least squares for tau = Y X, standard deviations, and a verdict for every parameter.

Gautier and Khalil (Dynamics of robots, chapter 12): the rows of joint j are divided by the standard deviation
sigma_j of its residuals; then C = (W^T W)^-1 is the covariance of X, std_i = sqrt(C_ii), and 100 std_i / |X_i|
the relative standard deviation in per cent.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.measured.fitting.estimates import (
    HARDLY_KNOWN,
    Estimate,
    Unknown,
    Verdict,
    is_identified,
    largest_of_chance,
)
from symoro_elastic.measured.logs.noise import (
    Noise,
    RowNoise,
    correlation_factors,
    residual_noise,
    student_factors,
    usual_correlation,
)
from symoro_elastic.numerics.linear.independence import IndependentColumns, independent_columns

FROM_DATA = 1e-6  # independence of columns of length 1
WEIGHTINGS = 3  # reweightings of the rows of joints
COLLAPSE = 1e-6  # smallest sigma of the first one: a row whose left side is zero may lose all its parameters
MOST_NOISE = 0.9  # fraction of noise in a direction up to which it is compensated
ALONE = 0.9  # of a column's energy is in one joint's equation
POSITIVE = ("M", "IA", "FV", "FS", "K", "DA")
FEWEST_ROWS = 2  # independent equations for each parameter
ABSORBED = "not estimated: "


@dataclass(frozen=True)
class LeastSquares:
    """Weighted least squares: X, its covariance, sigma (n) of the rows of each joint, residuals (samples, n),
    condition number of columns of length 1, for each parameter the share of position noise (0 to 1) in the part
    of its column that the others do not imitate, and by what correlation of residuals raised std, (n)."""

    X: Array
    covariance: Array
    sigma: Array
    predicted: Array
    residuals: Array
    condition: float
    noise: Array
    raised: Array

    @property
    def std(self) -> Array:
        """Standard deviations of X."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True)
class Estimation:
    """Estimates by parameter, the solution on the independent columns, and notes for the user."""

    estimates: tuple[Estimate, ...]
    solution: LeastSquares
    grouping: IndependentColumns
    joints: tuple[str, ...]
    notes: tuple[str, ...]

    def __getitem__(self, label: str) -> Estimate:
        for estimate in self.estimates:
            if estimate.unknown.label == label:
                return estimate
        raise KeyError(label)

    @property
    def hidden(self) -> list[int]:
        """Positions, among the independent columns, of columns that noise hides."""
        return [k for k, c in enumerate(self.grouping.kept) if self.estimates[c].verdict is Verdict.NOT]

    @property
    def not_identifiable(self) -> tuple[str, ...]:
        """Labels of the parameters that this motion cannot determine."""
        return tuple(e.unknown.label for e in self.estimates if e.verdict is Verdict.NOT)


def solve(Y: Array, tau: Array, noise: RowNoise | None = None, rounds: int = WEIGHTINGS) -> LeastSquares:
    """Return the weighted least squares solution of Y (samples, n, c) X = tau (samples, n).

    sigma_j^2 = |r_j|^2 / (samples - c_j), where c_j is the share of joint j in the degrees of freedom. `rounds`
    of weighting follow the ordinary solution. Rows that are zero on both sides count for nothing.

    Noise of the positions is in Y too and pulls X towards zero, most where the left side is zero (elastic joints).
    With N the mean of N_i^T N_i of noises N_i of Y of the same law, X = (Y^T Y - N)^-1 Y^T tau is free of that pull
    (bias-compensated least squares, Soederstrom 2007). Systematic errors of tau are considered, not estimated.
    """
    noise = noise or RowNoise()
    correlation = noise.correlation_in(Y)
    first: Array | None = None
    sigma = np.ones(Y.shape[1])
    for _ in range(rounds + 1):
        X = _weighted_solution(Y, tau, sigma, noise.columns)[0]
        law = _law(Y, tau, X, sigma, noise)
        deviations = sigma * np.sqrt(law.variance)
        first = deviations if first is None else first
        sigma = np.maximum(deviations, np.maximum(_smallest(Y, X, tau, deviations), COLLAPSE * first))
    X, spread, condition, share, parts = _weighted_solution(Y, tau, sigma, noise.columns)
    predicted = Y @ X
    law = _law(Y, tau, X, sigma, noise)
    raised = correlation_factors(law, (tau - predicted) / sigma)
    draws = [] if noise.draws is None else [D / sigma * raised for D in noise.draws(X)]
    covariance = spread @ _of_scores(Y / sigma[:, None], law.with_factors(raised), correlation, draws) @ spread
    unsure = parts.in_doubt(len(Y), usual_correlation(correlation), len(noise.columns))
    systematic = (_weighted_solution(Y, error, sigma, noise.columns)[0][:, None] for error in noise.systematic)
    for pull in (unsure, *systematic):
        covariance = covariance + pull @ pull.T
    return LeastSquares(X, covariance, sigma, predicted, tau - predicted, condition, share, raised)


def solved_with(Y: Array, tau: Array, sigma: Array, correlation: Sequence[float]) -> LeastSquares:
    """Return the least squares solution for white noise of known standard deviations sigma (n) before averaging."""
    X, spread, condition, share, _ = _weighted_solution(Y, tau, sigma, ())
    predicted = Y @ X
    covariance = spread * (2 * sum(correlation) - correlation[0])
    return LeastSquares(X, covariance, sigma, predicted, tau - predicted, condition, share, np.ones(len(sigma)))


def _of_scores(Y: Array, law: Noise, correlation: Array, drawn: Sequence[Array]) -> Array:
    """Return the covariance (c, c) of sum over rows and joints of Y (rows, n, c) times noise.

    Noise of positions is that which is drawn, where any is, else that of the law. A covariance from so few draws is
    uncertain itself: its variance is that of Student's distribution.
    """
    own = law.torques if drawn and law.torques else law
    covariance = own.with_factors(student_factors(Y, correlation)).of_scores(Y)
    if drawn:
        scores = np.array([np.einsum("rjc,rj->c", Y, D) for D in drawn])
        covariance = covariance + scores.T @ scores / max(len(scores) - 2, 1)
    return covariance


def _law(Y: Array, tau: Array, X: Array, sigma: Array, noise: RowNoise) -> Noise:
    """Return the noise of the rows, which are divided by the standard deviations sigma of their joints."""
    positions, residuals = [D @ X / sigma for D in noise.columns], (tau - Y @ X) / sigma
    return residual_noise(Y / sigma[:, None], residuals, positions, noise.correlation_in(Y), noise.repeating)


def _smallest(Y: Array, X: Array, tau: Array, deviations: Array) -> Array:
    """Return lower bounds (n) of standard deviations: rounding errors, which keep weights finite without noise."""
    terms = np.sqrt(((Y * X) ** 2).sum(axis=2).mean(axis=0)) + np.sqrt((tau**2).mean(axis=0))
    floor = 1e-13 * terms
    return np.where(floor > 0, floor, max(float(deviations.max(initial=0.0)), 1e-300))


def _stacked_rows(Y: Array, sigma: Array, lengths: Array | float = 1.0) -> Array:
    """Return rows over the sigma of their joint, columns over their lengths (samples n, c)."""
    rows: Array = (Y / sigma[:, None]).reshape(-1, Y.shape[2]) / lengths
    return rows


@dataclass(frozen=True)
class _Parts:
    """Parts (c, directions) whose sum is X, and the shares of noise in these directions."""

    X: Array
    share: Array

    def in_doubt(self, rows: int, correlation: Sequence[float], draws: int) -> Array:
        """Return parts times their relative standard deviations, as the estimated noise N differs from that in Y^T Y.

        N is a mean square of so many draws, that of Y is one of so many rows: both have a variance of 2/nu, nu the
        rows without their correlations. A direction that noise hides is in doubt by all of its size.
        """
        nu = max(rows / (1 + 2 * sum(x * x for x in correlation[1:]) / correlation[0] ** 2), 1.0)
        error = math.sqrt(2 * (1 + 1 / max(draws, 1)) / nu) * self.share / np.maximum(1 - self.share, 1 - HARDLY_KNOWN)
        return self.X * np.where(self.share > HARDLY_KNOWN, 1.0, np.maximum(error, 0.0))


def _weighted_solution(
    Y: Array, tau: Array, sigma: Array, noise: Sequence[Array]
) -> tuple[Array, Array, float, Array, _Parts]:
    """Return X, (Y^T Y - N)^-1, the condition number of unit columns, the noise fraction of each X_i, parts of X."""
    lengths = np.linalg.norm(_stacked_rows(Y, sigma), axis=0)
    W, right = _stacked_rows(Y, sigma, lengths), (tau / sigma).ravel()
    Q, R = np.linalg.qr(W)
    condition = float(np.linalg.cond(R)) if len(R) else 1.0
    inverse = np.linalg.inv(R)
    share, axes = np.zeros(len(R)), np.eye(len(R))
    if noise:
        noisy = sum(w.T @ w for w in (_stacked_rows(D, sigma, lengths) for D in noise)) / len(noise)
        N = inverse.T @ noisy @ inverse
        share, axes = np.linalg.eigh((N + N.T) / 2)
    directions = inverse @ axes
    pull = directions / (1 - np.minimum(share, MOST_NOISE))
    hidden = (directions**2 @ np.maximum(share, 0.0)) / (directions**2).sum(axis=1)
    parts = pull * (axes.T @ (Q.T @ right)) / lengths[:, None]
    spread = pull @ directions.T / np.outer(lengths, lengths)
    return parts.sum(axis=1), spread, condition, hidden, _Parts(parts, share)


@dataclass(frozen=True)
class LinearModel:
    """tau = Y X: Y (samples, n, c), tau (samples, n), the unknowns X (c), the names of joints (n), noise in rows.

    `still` are joints (0-based) that do not move; `source` names the data in messages.
    """

    Y: Array
    tau: Array
    unknowns: Sequence[Unknown]
    joints: Sequence[str]
    noise: RowNoise = field(default_factory=RowNoise)
    still: Sequence[int] = ()
    source: str = "measurements"


def estimate(model: LinearModel, least: int = FEWEST_ROWS, sigma: Array | None = None) -> Estimation:
    """Return the estimates of the unknowns of a linear model, with verdicts and notes.

    Columns that the motion leaves zero or dependent are dropped by QR (Gautier 1991) and named. `sigma` are the
    standard deviations of noise where rows are too few to determine them, and so to judge signs and residuals. Raises
    `InputError` for less than `least` independent equations for each parameter, or a motion that excites no parameter.
    """
    Y, tau, source = model.Y, model.tau, model.source
    rows = int((np.abs(Y).max(axis=2, initial=0.0) > 0).sum())
    correlation = usual_correlation(model.noise.correlation_in(Y))
    refuse_short(rows, len(model.unknowns), correlation, source, least)
    grouping = independent_columns(balanced_rows(Y), FROM_DATA)
    if not grouping.kept:
        raise InputError(source, "q", "this motion excites no parameter: move every joint, and move it faster")
    independent = list(grouping.kept)
    if sigma is None:
        solution = solve(Y[:, :, independent], tau, model.noise.of_columns(independent, Y.shape[2]))
    else:
        solution = solved_with(Y[:, :, independent], tau, sigma, correlation)
    still, hidden = [model.joints[j] for j in model.still], _hidden(Y[:, :, independent], tau, solution, model.joints)
    estimates = {c: _estimate(model, grouping, solution, k, hidden) for k, c in enumerate(independent)}
    estimates |= {c: _lost(model.unknowns[c], still) for c in grouping.vanishing}
    estimates |= {c: _inseparable(c, grouping, model.unknowns, still) for c in grouping.dropped}
    judged = () if sigma is not None else (*_consistency(estimates.values()), *_whiteness(solution, model.joints))
    notes = [*judged, *(f"{name} does not move beyond the noise of its sensor: held still" for name in still)]
    ordered = tuple(estimates[c] for c in range(len(model.unknowns)))
    if lost := [e.unknown.label for e in ordered if e.verdict is Verdict.NOT]:
        notes.append(f"{ABSORBED}{', '.join(lost)}; their effect is contained in the values of the others")
    return Estimation(ordered, solution, grouping, tuple(model.joints), tuple(notes))


def without_hidden_rows(model: LinearModel, estimation: Estimation) -> Estimation:
    """Return estimates without the equations of undriven joints that contain parameters hidden by noise.

    Such an equation determines its parameters up to a factor: least squares makes it zero, and shifts what its
    parameters move to other joints. It is left out if a hidden parameter occurs there alone, others if some remain.
    """
    hidden = [estimation.grouping.kept[k] for k in estimation.hidden]
    energy = ((model.Y[:, :, hidden] / estimation.solution.sigma[:, None]) ** 2).sum(axis=0)
    shares, is_driven = energy / np.maximum(energy.sum(axis=0), 1e-300), model.tau.any(axis=0)
    for least in (ALONE, 1 - ALONE):
        is_left_out = ~is_driven & (shares > least).any(axis=1)
        if is_left_out.any():
            break
    else:
        return estimation
    rows = np.flatnonzero(~is_left_out).tolist()
    correlation = model.noise.correlation_in(model.Y)[:, :, rows]
    noise = RowNoise([D[:, rows] for D in model.noise.columns], correlation)
    joints = [model.joints[j] for j in rows]
    reduced = LinearModel(model.Y[:, rows], model.tau[:, rows], model.unknowns, joints, noise, source=model.source)
    return without_hidden_rows(reduced, estimate(reduced, least=0))


def formula(label: str, terms: Sequence[tuple[str, float]]) -> str:
    """Return a group as text: `ZZ1 + Ia1 + 0.25 M3`."""
    text = label
    for other, b in terms:
        size = "" if abs(abs(b) - 1.0) < 1e-12 else f"{abs(b):.6g} "
        text += f" {'+' if b > 0 else '-'} {size}{other}"
    return text


def refuse_short(
    rows: int, parameters: int, correlation: Sequence[float], source: str, enough: int = FEWEST_ROWS
) -> None:
    """Raise `InputError` for fewer than two independent equations for each parameter, or than are `enough`.

    `rows` with such correlations to those 0, 1, 2 ... rows later are worth fewer independent ones.
    """
    least = fewest_rows(parameters, correlation, enough)
    if rows < least:
        what = f"{rows} equations after filtering for {parameters} parameters: at least {least} are needed"
        raise InputError(source, "t", f"{what}: measure longer, or give known values")


def fewest_rows(parameters: int, correlation: Sequence[float], per_parameter: int = FEWEST_ROWS) -> int:
    """Return the number of correlated rows equivalent to `per_parameter` independent equations for each parameter."""
    return math.ceil(per_parameter * parameters * (2 * sum(correlation) - correlation[0]))


def independent_solution(Y: Array, tau: Array, noise: RowNoise | None = None) -> tuple[list[int], LeastSquares]:
    """Return the independent columns of Y (rows, n, c), and the least squares solution of these."""
    independent = list(independent_columns(balanced_rows(Y), FROM_DATA).kept)
    own = noise and noise.of_columns(independent, Y.shape[2])
    return independent, solve(Y[:, :, independent], tau, own)


def balanced_rows(Y: Array) -> Array:
    """Return rows divided by the largest column of their joint, so that joints weigh equally in the rank."""
    size = np.sqrt((Y**2).mean(axis=0)).max(axis=1, initial=0.0)
    balanced_rows: Array = (Y / np.where(size > 0, size, 1.0)[:, None]).reshape(-1, Y.shape[2])
    return balanced_rows


def _estimate(
    model: LinearModel, grouping: IndependentColumns, solution: LeastSquares, k: int, hidden: dict[int, str]
) -> Estimate:
    """Return the estimate, with verdict, of independent column k."""
    c = grouping.kept[k]
    unknown = model.unknowns[c]
    value, std = unknown.about + float(solution.X[k]), float(solution.std[k])
    if k in hidden:
        return Estimate(unknown, math.nan, math.nan, Verdict.NOT, hidden[k])
    reason = ""
    joined = [(model.unknowns[other].label, b) for other, b in grouping.terms(k)]
    if joined:
        reason = f"with this motion only the sum {formula(unknown.label, joined)}"
    if is_identified(value, std):
        return Estimate(unknown, value, std, Verdict.IDENTIFIED, reason)
    size = np.sqrt((model.Y[:, :, c] ** 2).mean(axis=0)) * (abs(value) + 2 * std)
    why = "its torques stay within the noise" if (size < solution.sigma).all() else "weakly excited"
    why += ", zero is possible" if abs(value) < 2 * std else ""
    return Estimate(unknown, value, std, Verdict.POOR, "; ".join(filter(None, (why, reason))))


def _hidden(Y: Array, tau: Array, solution: LeastSquares, joints: Sequence[str]) -> dict[int, str]:
    """Return the columns that noise of the positions hides, with the reason.

    A joint without measured torque gives its parameters up to a common factor: where the factor is hidden, so
    are all parameters that occur in this joint's equation only.
    """
    energy = ((Y / solution.sigma[:, None]) ** 2).sum(axis=0)
    owner, shares = energy.argmax(axis=0), energy.max(axis=0) / energy.sum(axis=0)
    owner = np.where(shares > ALONE, owner, -1)
    hidden, lost = {}, {int(j) for j in owner[solution.noise > HARDLY_KNOWN] if j >= 0 and not tau[:, j].any()}
    for k, noise in enumerate(solution.noise):
        if int(owner[k]) in lost:
            hidden[k] = (
                f"{joints[owner[k]]} has no motor and determines its parameters only up to a factor: give one as known"
            )
        elif noise > HARDLY_KNOWN:
            hidden[k] = (
                f"{min(100, round(100 * noise))} % of what distinguishes it from the others is noise of the positions"
            )
    return hidden


def _lost(unknown: Unknown, still: Sequence[str]) -> Estimate:
    why = f"{unknown.joint} does not move" if unknown.joint in still else "no torque depends on it"
    return Estimate(unknown, math.nan, math.nan, Verdict.NOT, why)


def _inseparable(c: int, grouping: IndependentColumns, unknowns: Sequence[Unknown], still: Sequence[str]) -> Estimate:
    labels = [
        unknowns[column].label for k, column in enumerate(grouping.kept) if grouping.beta[k, grouping.dropped.index(c)]
    ]
    why = f"cannot be distinguished from {', '.join(labels)}"
    if unknowns[c].joint in still:
        why += f": {unknowns[c].joint} does not move"
    return Estimate(unknowns[c], math.nan, math.nan, Verdict.NOT, why)


def _consistency(estimates: Iterable[Estimate]) -> list[str]:
    """Return notes on values that must be positive, but are more negative than chance explains if all were zero."""
    alone = [e for e in estimates if e.unknown.formula == e.unknown.label and e.unknown.quantity in POSITIVE]
    enough = largest_of_chance(len(alone))
    notes = []
    for e in alone:
        if e.value < -enough * e.std:
            what = f"{e.unknown.label} = {e.value:.4g} is negative by {-e.value / e.std:.1f} standard deviations"
            notes.append(f"{what}, which is physically impossible: something is missing in the model or in the data")
    return notes


def _whiteness(solution: LeastSquares, joints: Sequence[str]) -> list[str]:
    """Return notes on joints whose residuals are not white."""
    return [
        f"residuals of {joint} stay correlated beyond the filter, so standard deviations are increased {factor:.1f} "
        "times where they rest on this joint; the model lacks something, or torques have slow noise"
        for joint, factor in zip(joints, solution.raised, strict=True)
        if factor > 1
    ]
