"""What would not fit into the memory is refused before any work, with the way out."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.analysis.time_series.preparation import Preparation
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import MOST_HELD, InputError, refuse_numbers
from symoro_elastic.measured.logs.pieces import refuse_amount
from tests.cli.test_every_command import ODD
from tests.command_line import EXAMPLES, refused

TWO_AXIS, RX90 = EXAMPLES / "two_axis.toml", EXAMPLES / "rx90.par"
FORCES = [f"--input tool.{part}{x}" for part in "fm" for x in "xyz"]
FRAMES = ("tool", "ram", "sensor_head", "cart_y")
PLACES = [f"--output {frame}.{x}" for frame in FRAMES for x in ("x", "y", "z", "rx", "ry", "rz")]
EXCITED = "--out e.npz --position -1:1 --velocity 1 --acceleration 9 --fundamental 1 --evaluations 1"


def test_the_bound() -> None:
    refuse_numbers(MOST_HELD, "they", "a.toml", "--over", "give fewer")
    with pytest.raises(InputError) as error:
        refuse_numbers(MOST_HELD + 1, "9 positions", "a.toml", "--over", "give fewer")
    assert str(error.value) == "a.toml: --over: 9 positions make 5e+07 numbers, 5e+07 is the limit: give fewer"


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("command", "machine", "options", "said"),
    [
        (
            *("response", TWO_AXIS, " ".join(["--band 1:9:200000 --hold all", *FORCES, *PLACES])),
            "--band: 200000 frequencies of 6 inputs and 24 outputs make",
        ),
        ("feed-forward", TWO_AXIS, "--sample-rate 1e6 --duration 4.9", "rate: 4900001 samples of 2 motors with"),
        ("excite", TWO_AXIS, f"{EXCITED} --sample-rate 9e5 --periods 3", "rate: 4.5e+06 samples of 2 motors make"),
        ("excite", TWO_AXIS, f"{EXCITED} --sample-rate 1e9", "rate: 1e+09 Hz makes 5e+09 samples, 5e+06 is the limit"),
        ("benchmark", RX90, "--states 1000000 --model regressor", "--states: 1000000 states with"),
        ("modes", "chain.toml", "--along j1=0:1:10000", "--along: 10000 positions of 40 joints make"),
    ],
)
def test_commands(
    command: str, machine: Path, options: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "chain.toml").write_text(ODD["long_chain"])
    line = refused(command, machine, *options.split())
    assert said in line and "is the limit: " in line
    assert [path.name for path in tmp_path.iterdir()] == ["chain.toml"]


def test_equations_of_a_record() -> None:
    record: Any = SimpleNamespace(q=np.broadcast_to(0.0, (5_000_000, 6)), source="r.csv")
    with pytest.raises(
        InputError, match=r"r\.csv: t: 30000000 equations after filtering for 52 parameters make 4\.68e\+09"
    ):
        refuse_amount([[record]], None, 52, may_be_few=False)
    refuse_amount([[record]], None, 0, may_be_few=True)


def test_resampled_records() -> None:
    machine, _ = read_machine(RX90)
    t = np.arange(0.0, 1e6, 100.0)
    record = Measurements(t, np.zeros((len(t), 6)), np.zeros((len(t), 6)))
    with pytest.raises(InputError, match=r"--resample: 13 columns at 4 Hz make 5\.2"):
        Preparation(rate=4.0)(record, machine)
