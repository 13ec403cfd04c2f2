"""Logs as controllers write them: gaps, lost and repeated samples, uneven clocks, contacts, coupled wrists.

Truth is that of the simulation; the benchmark `tests.benchmarks.logs` has the shares over many draws.
"""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("scipy")

import symoro_elastic as se
from symoro_elastic.analysis.time_series.clocks import part_of, pieces, tidy
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.measured.logs.filtering import EvenClock
from symoro_elastic.measured.logs.identify import LogSettings, identify
from symoro_elastic.measured.logs.result import Identification
from symoro_elastic.measured.logs.validation import validation_of
from symoro_elastic.numerics.linear.regressor import Regressor, regressor
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.benchmarks.identification import Fault
from tests.benchmarks.logs import CASES, MISTAKES, RATE, Case, Change, Draw, arm, deviations, replaced, table, truth_of
from tests.benchmarks.sensors import Sensing, three_axis


def found_in(record: Measurements) -> Identification:
    return identify(arm(), tidy(record, arm()))


def worst(found: Identification) -> float:
    """The largest error in standard deviations."""
    return max(abs(z) for z, _ in deviations(found, truth_of(CASES["plain"])).values())


def widths(found: Identification) -> Array:
    return np.array([e.std for e in found.estimates])


def noted(found: Identification, text: str) -> bool:
    return any(text in note for note in found.notes)


@pytest.fixture(scope="module")
def plain() -> Identification:
    return identify(arm(), Draw(1).record())


@pytest.mark.thorough
def test_a_record_is_split_at_gaps(plain: Identification) -> None:
    kept = np.ones(len(Draw(1).t), dtype=bool)
    for first in (700, 1500, 2600):
        kept[first : first + 250] = False
    found = found_in(part_of(Draw(1).record(), kept))
    assert noted(found, "measurements: 3 gaps, 4 pieces, 79.9 % of the record used")
    assert worst(found) < 4 and np.median(widths(found) / widths(plain)) == pytest.approx(0.8**-0.5, abs=0.12)
    windows = found.filter.window / RATE if found.filter else 0.0
    starts = [t for t in found.t if any(abs(t - first / RATE - 0.5) < 0.5 - windows / 2 for first in (700, 1500, 2600))]
    assert not starts, "no average reaches over a gap"


@pytest.mark.thorough
def test_torques_that_were_not_measured_count_nowhere(plain: Identification) -> None:
    """Whatever stands in their place, nothing of the result changes."""
    record, lost = Draw(1).record(), np.random.default_rng(0).uniform(size=len(Draw(1).t)) < 0.05
    bridged = found_in(part_of(record, ~lost))
    assert noted(bridged, "short gaps are bridged: positions are interpolated there, torques are not")
    assert worst(bridged) < 4 and np.median(widths(bridged) / widths(plain)) == pytest.approx(0.95**-0.5, abs=0.1)
    record.tau[lost, 0] = np.nan
    damaged = found_in(record)
    assert noted(
        damaged,
        f"tau_lift: NaN or infinity at {lost.sum()} of {len(lost)} samples, first at sample {lost.argmax() + 1}: these",
    )
    np.testing.assert_allclose(widths(damaged), widths(bridged))


@pytest.mark.thorough
def test_samples_that_are_repeated_change_nothing(plain: Identification) -> None:
    record = Draw(1).record()
    twice = part_of(record, np.sort(np.r_[np.arange(len(record.t)), 100, 2000, 2001]))  # type: ignore[arg-type]
    found = found_in(twice)
    assert noted(found, "3 of 3753 samples repeat the one before, with its time: left out")
    assert [e.value for e in found.estimates] == [e.value for e in plain.estimates]


def stamped(step: float) -> Change:
    """Stamps that are whole multiples of a step."""
    return lambda record: replace(record, t=np.floor(record.t / step + 1e-9) * step)


def scattered(record: Measurements) -> Measurements:
    return replace(record, t=record.t + 0.3 / RATE * np.random.default_rng(0).uniform(-1, 1, len(record.t)))


@pytest.mark.thorough
@pytest.mark.parametrize("change", [stamped(0.01), stamped(0.005), scattered])
def test_stamps_off_an_even_clock_are_known_by_positions(plain: Identification, change: Change) -> None:
    found = found_in(change(Draw(1).record()))
    assert noted(found, "off an even clock of 4")
    wanted = [e.value for e in plain.estimates]
    np.testing.assert_allclose([e.value for e in found.estimates], wanted, rtol=1e-2, atol=2e-3)


@pytest.mark.thorough
def test_samples_off_an_even_clock_are_taken_at_their_times(plain: Identification) -> None:
    found = found_in(Draw(1, jitter=0.4).record())
    assert noted(found, "sampling is uneven, steps of ") and not noted(found, "its times are taken")
    assert worst(found) < 4 and np.median(widths(found) / widths(plain)) == pytest.approx(1.0, abs=0.1)


def test_an_even_clock_keeps_motion_and_noise() -> None:
    """A sine to the third order of the step, the density of white noise below a tenth of the sampling frequency."""
    rng = np.random.default_rng(0)
    errors = []
    for count in (400, 800):
        t = (np.arange(count) + 0.4 * rng.uniform(-1, 1, count)) / count
        clock = EvenClock(t, 1 / count)
        even = clock.evenly(np.sin(8 * np.pi * t))
        errors.append(np.abs(even - np.sin(8 * np.pi * clock.t))[5:-5].max())
        back = clock.at_samples(np.sin(8 * np.pi * clock.t))
        assert np.abs(back - np.sin(8 * np.pi * t))[5:-5].max() < 1e-6
    assert errors[1] < errors[0] / 5 and errors[1] < 2e-5
    t = (np.arange(4000) + 0.4 * rng.uniform(-1, 1, 4000)) / 4000
    clock = EvenClock(t, 1 / 4000)
    power = [
        np.mean(np.abs(np.fft.rfft(clock.evenly(rng.standard_normal(4000))))[1:400] ** 2) / 4000 for _ in range(20)
    ]
    assert np.mean(power) == pytest.approx(1.04, abs=0.05), "weights of samples that are uneven differ by some per cent"


def test_a_cubic_stands_in_for_samples_that_are_missing() -> None:
    t = np.delete(np.linspace(0, 1, 201), np.r_[50:58, 120])
    clock = EvenClock(t, 0.005)
    x = 1 + t - 3 * t**2 + 2 * t**3
    np.testing.assert_allclose(clock.evenly(x), 1 + clock.t - 3 * clock.t**2 + 2 * clock.t**3, atol=1e-6)


def test_pieces_are_cut_where_time_jumps() -> None:
    t = np.r_[0:50, 60:100, 140:200] / 100.0
    record = Measurements(t, t[:, None], t[:, None], warnings=("one",))
    assert [len(x.t) for x in pieces(record, 20)] == [90, 60] and [len(x.t) for x in pieces(record, 5)] == [50, 40, 60]
    assert [x.warnings for x in pieces(record, 5)] == [("one",), (), ()]


@pytest.mark.thorough
def test_validation_of_a_record_with_gaps(plain: Identification) -> None:
    whole, some = Draw(2).record(), np.r_[0:1000, 1300:3750]
    fits = [validation_of(plain, tidy(x, arm())) for x in (whole, part_of(whole, some))]  # type: ignore[arg-type]
    for joint in ("lift", "elbow"):
        assert fits[1].sample_percent[joint] == pytest.approx(fits[0].sample_percent[joint], rel=0.1)
        assert fits[1].band_percent[joint] == pytest.approx(fits[0].band_percent[joint], rel=0.3)


@pytest.mark.thorough
def test_pieces_of_a_record_have_its_friction() -> None:
    cold, warm = (Draw(k).record() for k in (1, 2))
    laws = CASES["temperatures"].asked["laws"]
    split = part_of(cold, np.r_[0:1500, 1800:3750])  # type: ignore[arg-type]
    found = identify(arm(), [tidy(x, arm()) for x in (split, warm)], LogSettings(laws=laws))
    assert [e.unknown.label for e in found.estimates][-6:-2] == ["FV1_2", "FS1_2", "FV2_2", "FS2_2"]


def test_records_at_two_rates_are_refused() -> None:
    record = Draw(1).record()
    with pytest.raises(InputError, match=r"records are sampled at 250 Hz in .*, 125 Hz in .*--resample 125"):
        identify(arm(), [record, part_of(record, slice(None, None, 2))])


@pytest.mark.thorough
def test_contacts_are_named_and_left_out(plain: Identification) -> None:
    more = np.zeros((len(Draw(1).t), 2))
    more[2000:2060, 1] = 12.0
    touched = Draw(1).record(more)
    bent, found = (identify(arm(), touched, LogSettings(offsets="never", robust=x)) for x in (False, True))
    assert worst(found) < 4 and np.median(widths(found) / widths(bent)) < 0.5
    (line,) = (note for note in found.notes if note.startswith("outliers of elbow"))
    assert "averages stand out and are left out, at 7." in line or "at 8" in line
    clean = identify(arm(), Draw(1).record(), LogSettings(robust=True))
    assert noted(clean, "outliers: no average stands out")
    assert [e.value for e in clean.estimates] == [e.value for e in plain.estimates]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("title", "line"),
    [
        ("offsets", "offset of torques: residuals"),
        ("delay of 6 ms", "delay of torques: residuals"),
        ("load friction", "load friction: residuals"),
        ("Stribeck", "friction by Stribeck's law: residuals"),
        ("temperatures", "friction of each record: residuals"),
        ("link side", "torques behind transmissions, IA1, FV1, FS1, IA2, FV2, FS2 are not sought: residuals"),
    ],
)
def test_each_option_says_in_one_line_what_it_changed(title: str, line: str) -> None:
    found = CASES[title].identified(3)
    (said,) = (note for note in found.notes if note.startswith(line))
    after, before = (float(x.split(" %")[0].split()[-1]) for x in (said.split("residuals ")[1], said.split(", ")[-1]))
    assert after < 0.9 * before or title == "link side"
    assert after == pytest.approx(before, rel=0.02) or title != "link side"


@pytest.mark.thorough
def test_standard_deviations_of_damaged_logs_are_honest() -> None:
    """A few draws of the benchmark, whose sum of squares is not chance."""
    found = table(["plain", "3 gaps of 0.8 s", "uneven by 40 %"], 5)
    assert all(0.7 < x["rms"] < 1.35 and x["within 95 %"] > 0.85 for x in found.values())


WRIST = """
name = "wrist"
gravity = [0, -9.81, 0]
joints = [
  { name = "bend",  antecedent = 0,      kind = "motor",   sigma = 0, theta = "q5", alpha = "pi/2" },
  { name = "motor", antecedent = 0,      kind = "motor",   sigma = 0, theta = "qm" },
  { name = "roll",  antecedent = "bend", kind = "coupled", sigma = 0, theta = "qm - q5", alpha = "-pi/2", d = 0.1 },
]
[bodies]
bend = { mass = 2.0, center_of_mass = [0.02, 0.05, 0.1], inertia = [0.02, 0.03, 0.01] }
roll = { mass = 1.0, center_of_mass = [0.03, 0.02, 0.06], inertia = [0.006, 0.004, 0.005] }
[motors]
bend  = { rotor_inertia = 0.05 }
motor = { rotor_inertia = 0.03 }
[friction]
bend  = { viscous = 0.8, coulomb = 0.5 }
motor = { viscous = 0.4, coulomb = 0.3 }
roll  = { viscous = 0.2, coulomb = 0.15 }
"""


@pytest.mark.thorough
@pytest.mark.parametrize("possible", [False, True])
def test_a_coupled_wrist_is_a_motor_and_a_joint_that_follows(tmp_path: Path, possible: bool) -> None:
    """Motor 6 turns by q5 + q6: its rotor and friction act on that sum, friction of the joint on q6."""
    (tmp_path / "wrist.toml").write_text(WRIST, encoding="utf-8")
    machine = se.read(tmp_path / "wrist.toml")
    draw = Draw(4)
    tau = np.array(numpy_model(machine, ("inverse_dynamics",)).inverse_dynamics(*draw.exact)[0])
    tau += 0.02 * draw.rng.standard_normal(tau.shape)
    log = {"t": draw.t, "q_bend": draw.exact[0][:, 0], "q_motor": draw.exact[0][:, 1]}
    log |= {"tau_bend": tau[:, 0], "tau_motor": tau[:, 1]}
    found = se.identify(machine, log, possible=possible)
    for label, true in {"FS1": 0.5, "FS2": 0.3, "FS3": 0.15, "FV1": 0.8, "FV2": 0.4, "FV3": 0.2}.items():
        e = found.found.estimation[label]
        assert abs(e.value - true) < 4 * e.std < 0.4 * true, label
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        se.write(found.saved()[0], tmp_path / "found.toml")
        again = se.read(tmp_path / "found.toml")
    other = Draw(5).exact
    both = [np.array(numpy_model(x, ("inverse_dynamics",)).inverse_dynamics(*other)[0]) for x in (machine, again)]
    assert np.abs(both[1] - both[0]).max() < 0.01 * np.abs(both[0]).max()
    if possible:
        assert found.found.possible is not None
        assert all(np.linalg.eigvalsh(J).min() > 0 for J in found.found.possible.bodies().values())


HEAD = "t,q_lift,q_elbow,tau_lift,tau_elbow"


def written(path: Path, record: Measurements, head: str = HEAD) -> Path:
    np.savetxt(path, np.column_stack([record.t, record.q, record.tau]), delimiter=",", header=head, comments="")
    return path


def rest(q: Array) -> Array:
    return np.zeros_like(q) + 1e-5 * np.random.default_rng(0).standard_normal(q.shape)


@pytest.mark.sampled(6)
@pytest.mark.parametrize(
    ("change", "head", "said"),
    [
        (replaced("t", lambda t: t[::-1]), HEAD, "t: does not increase from sample 1"),
        (replaced("t", lambda t: 1000 * t), HEAD, "if t is in ms, call the column t [ms]"),
        (replaced("t", lambda t: 0 * t), HEAD, "t: does not increase from sample 1"),
        (
            replaced("q", rest),
            HEAD,
            "q: no joint moves beyond the noise of its sensor: nothing can be identified at rest",
        ),
        (replaced("q", lambda q: 0 * q), HEAD, "q: no joint moves: nothing can be identified at rest"),
        (replaced("tau", lambda x: x * np.nan), HEAD, "tau_lift, tau_elbow: NaN or infinity at 3750 of 3750 samples"),
        (replaced("tau", lambda x: x * 1e200), HEAD, "which no machine does: check the column and its unit"),
        (lambda x: part_of(x, slice(20)), HEAD, "t: 20 samples are too few"),
        (lambda x: x, HEAD.replace("q_lift", "q_lift [kg]"), "q_lift [kg]: 'kg' cannot be converted to rad"),
        (lambda x: x, HEAD.replace("tau_lift", "tau_lift [N]"), "tau_lift [N]: 'N' cannot be converted to N m"),
        (lambda x: x, HEAD.replace("tau_elbow", "tau_wrist"), "tau_wrist: no moving joint 'wrist'"),
        (lambda x: x, HEAD.replace("tau_elbow", "current"), "tau_elbow: missing; the file has t"),
    ],
)
def test_logs_that_tell_nothing_are_refused_in_a_line(tmp_path: Path, change: Change, head: str, said: str) -> None:
    file = written(tmp_path / "log.csv", change(Draw(1).record()), head)
    with pytest.raises(InputError) as error:
        se.identify(arm(), file)
    assert said in str(error.value) and str(error.value).startswith(str(file)) and "\n" not in str(error.value)


def test_gaps_that_leave_nothing_are_refused() -> None:
    record = part_of(Draw(1).record(), np.arange(3750) % 150 < 100)
    with pytest.raises(InputError, match=r"24 gaps leave no piece of 1\.32 s, which filters of this motion need"):
        identify(arm(), record, LogSettings(bandwidth=1.0))


@pytest.mark.thorough
def test_cells_that_are_empty_are_samples_left_out(tmp_path: Path) -> None:
    file = written(tmp_path / "log.csv", Draw(1).record())
    lines = file.read_text(encoding="utf-8").splitlines()
    lines[500:2000:50] = [",".join([*line.split(",")[:4], ""]) for line in lines[500:2000:50]]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    found = se.identify(arm(), file).found
    assert noted(found, "tau_elbow: NaN or infinity at 30 of 3750 samples, first at sample 500: these samples are")
    assert worst(found) < 4


@pytest.mark.thorough
def test_cases_of_the_benchmark_run() -> None:
    """Those that no other test runs, once each."""
    for title in ("1 % spikes of 10 std", "contacts", "possible, trust 0.3"):
        case: Case = CASES[title]
        assert case.identified(1).estimates


@cache
def columns_of_arm() -> Regressor:
    return regressor(arm())


@pytest.mark.thorough
@pytest.mark.parametrize("fault", [Fault(lambda x, _: x, ""), *MISTAKES.values()], ids=["none", *MISTAKES])
def test_mistakes_of_columns_are_named(fault: Fault) -> None:
    changed = fault.change(Draw(3).record(), np.random.default_rng(0))
    found = identify(arm(), changed, Y=columns_of_arm())
    words = (
        "are in degrees",
        "opposite sign",
        "exchanged",
        "give --gain",
        "does not change",
        "does not resolve",
        "all values are",
        "minutes",
        "of the motor, not",
        "the zero of",
        "is the velocity",
        "absolute values",
    )
    lines = [note for note in found.notes if any(word in note for word in words)]
    assert (lines and all(fault.reported in line for line in lines)) if fault.reported else not lines


@pytest.mark.parametrize("seed", [0, *(pytest.param(x, marks=pytest.mark.thorough) for x in range(1, 12))])
def test_exchanged_joints_are_named_in_any_motion(seed: int) -> None:
    """Noise is in residuals with and without the exchange: before, a ratio of 2.8 was silent."""
    fault = MISTAKES["joints exchanged"]
    changed = fault.change(Draw(seed).record(), np.random.default_rng(0))
    found = identify(arm(), changed, Y=columns_of_arm())
    assert noted(found, "columns of lift and elbow are exchanged: residuals 0.")


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("noise", [1.0, 5.0, 20.0])
@pytest.mark.parametrize("stribeck", [0.0, 1.2])
def test_noise_and_friction_of_another_law_are_no_mistakes_of_columns(noise: float, stribeck: float, seed: int) -> None:
    draw = Draw(seed)
    more = stribeck * np.sign(draw.exact[1]) / (1 + (draw.exact[1] / 0.15) ** 2)
    more += noise * np.array([0.3, 0.1]) * np.random.default_rng(seed).standard_normal(more.shape)
    found = identify(arm(), draw.record(more), Y=columns_of_arm())
    assert not [note for note in found.notes if "of the torque then" in note]


def test_angles_that_wrap_are_refused() -> None:
    wrapped = replaced("q", lambda q: np.mod(q, 2 * np.pi))(Draw(3).record())
    with pytest.raises(InputError, match=r"q_lift: jumps by 6.283\d* rad 18 times, first at sample 120 .*: unwrap it"):
        identify(arm(), wrapped, Y=columns_of_arm())


@pytest.mark.thorough
def test_a_zero_of_an_encoder_is_named() -> None:
    """A quarter turn of the second of three axes; that of the last joint of an arm its own first moments take up."""
    axes = three_axis()
    record = axes.record(Sensing(), 12)
    off = part_of(replace(record, q=record.q - [0, np.pi / 2, 0]), np.arange(len(record.t)) % 2 == 0)
    (line,) = [note for note in identify(axes.machine, off).notes if "the zero of" in note]
    added = re.search(r"the zero of q_lift is off: add (\S+) rad to it", line)
    assert added and abs(float(added[1]) - np.pi / 2) < 0.1


@pytest.mark.thorough
def test_signs_that_values_of_the_file_do_not_give_are_those_of_fits() -> None:
    """Of three axes: torques by the file alone leave some signs wrong."""
    axes = three_axis()
    record = part_of(axes.record(Sensing(), 31), slice(None, None, 2))
    lines = identify(axes.machine, replace(record, tau=abs(record.tau))).notes
    assert any("absolute values, whose signs are lost" in line for line in lines)
