"""The journal of a sweep: what was computed is kept, torn lines are dropped, other sweeps are refused."""

from __future__ import annotations

import math
import os
import shutil
import threading
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.sweeps import running
from symoro_elastic.analysis.sweeps.digest import digest
from symoro_elastic.analysis.sweeps.running import open_journal
from symoro_elastic.analysis.sweeps.tasks import Outcome
from symoro_elastic.api.options import Sweeping
from symoro_elastic.api.sweeps import plan
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_files import permission
from tests.analysis.sweeps.machines import SLIDE, squared, value
from tests.command_line import EXAMPLES, refused

ODD = Outcome({"a": 0.1 + 0.2, "b": math.inf, "c": -math.inf, "d": math.nan, "e": 5e-324}, "")


def test_numbers_are_read_back_to_the_last_bit(tmp_path: Path) -> None:
    path = tmp_path / "a.journal"
    with open_journal(path, "digest", 2) as (before, record):
        record([(1, ODD), (0, Outcome({}, "none"))])
    assert before == {}
    with open_journal(path, "digest", 2) as (found, _):
        assert np.array_equal(list(found[1].figures.values()), list(ODD.figures.values()), equal_nan=True)
        assert found[0] == Outcome({}, "none")


def test_a_line_that_a_killed_run_left_unfinished_is_dropped(tmp_path: Path) -> None:
    path = tmp_path / "a.journal"
    with open_journal(path, "digest", 3) as (_, record):
        record([(0, Outcome({"x": 1.0}))])
        record([(1, Outcome({"x": 2.0}))])
    whole = path.read_bytes()
    for length in range(whole.index(b"\n") + 1, len(whole)):
        path.write_bytes(whole[:length])
        with open_journal(path, "digest", 3) as (found, record):
            assert set(found) == set(range(whole[:length].count(b"\n") - 1))
            record([(2, Outcome({"x": 3.0}))])
        with open_journal(path, "digest", 3) as (found, _):
            assert found[2] == Outcome({"x": 3.0})


def test_journals_of_other_sweeps_and_other_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.journal"
    with open_journal(path, "digest", 1) as (_, record):
        record([(0, ODD)])
    content = path.read_bytes()
    with pytest.raises(InputError, match="is of another sweep"), open_journal(path, "other", 1):
        pass
    assert path.read_bytes() == content
    with permission(force=True), open_journal(path, "other", 1) as (found, _):
        assert found == {}
    path.write_text("mine")
    with permission(force=True), pytest.raises(InputError, match="is not a journal"), open_journal(path, "digest", 1):
        pass
    assert path.read_text() == "mine"


def test_two_runs_do_not_write_one_journal(tmp_path: Path) -> None:
    path = tmp_path / "a.journal"
    with (
        open_journal(path, "digest", 1),
        pytest.raises(InputError, match="by another run"),
        open_journal(path, "digest", 1),
    ):
        pass
    assert not path.exists()


def test_a_changed_machine_or_sweep_is_another_one() -> None:
    """Also where the change is one that `repr` of a machine does not show, or one of the function."""
    machine = se.read(SLIDE)
    stiffer = se.read({**SLIDE, "springs": {"load": {"stiffness": 1e5, "damping": 40.0}}})
    over = {"m": [1.0, 2.0]}
    plans = [
        plan(machine, Sweeping(over=over)),
        plan(stiffer, Sweeping(over=over)),
        plan(machine, Sweeping(over={"m": [1.0, 3.0]})),
        plan(machine, Sweeping(over=over, of="response")),
        plan(machine, Sweeping(over=over, values={"load.stiffness": 1e5})),
        plan(machine, Sweeping(over=over, of=squared)),
        plan(machine, Sweeping(over=over, of=lambda machine: {"m": value(machine)})),
    ]
    assert len({one.digest for one in plans}) == len(plans)
    assert plan(replace(machine, source="elsewhere.toml"), Sweeping(over=over)).digest == plans[0].digest


FACTOR, MADE = 2.0, np.array([1.0, 2.0])


def _scaled(machine: object) -> dict[str, float]:
    return {"x": sum(_once(x) for x in MADE)}


def _once(x: float) -> float:
    return FACTOR * x


class Held:
    """Something with a state, that is called."""

    def __init__(self, x: float) -> None:
        self.x = x

    def __call__(self, machine: object) -> dict[str, float]:
        return {"x": _once(self.x)}


def test_a_function_with_other_values_is_another_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Enclosed, global and default values, those of functions that it calls, of its methods, and its code on a line."""

    def made(x: object) -> Any:
        return lambda machine, y=1.0: {"x": x}

    pair = [lambda machine: {"x": 1.0}, lambda machine: {"x": 2.0}]
    with_default = made(1.0)
    with_default.__defaults__ = (2.0,)
    functions = [
        made(1.0),
        made(2.0),
        made([1, 2]),
        made({"a": [1, {3}]}),
        made(np.array([1, 2], object)),
        with_default,
    ]
    functions += [*pair, partial(made(1.0), y=3.0), partial(made(1.0), y=4.0), Held(1.0), Held(2.0), Held(1.0).__call__]
    changing = [_scaled, Held(1.0), lambda machine: {"x": math.fsum(_once(x) for x in (1, 2))}]
    digests = [digest(one) for one in (*functions, *changing)]
    assert len(set(digests)) == len(digests) - 1 and digests[10] == digests[14]
    assert digests == [digest(one) for one in (*functions, *changing)] and digest(made(1.0)) == digests[0]
    for name, x in (("FACTOR", 3.0), ("MADE", np.array([1.0, 3.0])), ("_once", lambda x: x)):
        before = [digest(one) for one in changing]
        monkeypatch.setitem(globals(), name, x)
        differs = [a != b for a, b in zip(before, [digest(one) for one in changing], strict=True)]
        assert differs == [True, name != "MADE", name != "MADE"]


def test_what_cannot_be_compared_has_no_journal(tmp_path: Path) -> None:
    lock: Any = threading.Lock()

    def function(machine: object) -> dict[str, float]:
        return {"x": float(lock.locked())}

    path = tmp_path / "a.journal"
    for given, said in (
        (function, "lock, which function uses, has changed"),
        (partial(squared, lock), "the function or"),
    ):
        with pytest.raises(InputError, match=f"whether {said}.*leave out the journal"):
            se.sweep(SLIDE, over={"m": [1.0]}, of=given, journal=path)
    assert not path.exists()
    assert se.sweep(SLIDE, over={"m": [1.0]}, of=function).figures["x"].tolist() == [0.0]


@pytest.mark.parametrize(
    "line",
    [
        *(b"garbage", b"\x00\xff", b"[1]", b"", b"{}", b"[" * 10**5, b'{"point": 0, "figures": [], "reason": ""}'),
        b'{"point": 9, "figures": {}, "reason": ""}',
        b'{"point": 0, "figures": {"x": "1"}, "reason": ""}',
        b'{"point": 0, "figures": {"x": null}, "reason": ""}',
    ],
)
def test_a_damaged_line_is_named(tmp_path: Path, line: bytes) -> None:
    path = tmp_path / "a.journal"
    with open_journal(path, "digest", 3) as (_, record):
        record([(0, Outcome({"x": 1.0})), (1, Outcome({"x": 2.0}))])
    head, first, second = path.read_bytes().splitlines(keepends=True)
    damaged = head + first + line + b"\n" + second
    path.write_bytes(damaged)
    damage = pytest.raises(InputError, match=r"a.journal: journal: line 3 is damaged: delete")
    with damage as error, open_journal(path, "digest", 3):
        pass
    assert path.read_bytes() == damaged and "\n" not in str(error.value)
    with permission(force=True), open_journal(path, "digest", 3) as (found, _):
        assert found == {}


def test_a_full_disk_leaves_no_empty_journal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> int:
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr(os, "write", full)
    with pytest.raises(InputError, match="No space left"), open_journal(tmp_path / "a.journal", "digest", 1):
        pass
    assert not [*tmp_path.iterdir()]


def test_a_pipe_and_a_link_are_no_journals(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to(tmp_path / "elsewhere")
    for name, said in (("pipe", "is a pipe: give the name of a file"), ("link", "is a link")):
        with pytest.raises(InputError, match=said), open_journal(tmp_path / name, "digest", 1):
            pass
    assert sorted(path.name for path in tmp_path.iterdir()) == ["link", "pipe"]


def test_an_interrupted_sweep_goes_on_where_it_was(tmp_path: Path) -> None:
    """Each point is computed once, whatever ends the run; those that failed are tried again."""
    log = tmp_path / "computed"
    log.touch()

    def computed() -> list[float]:
        return [float(line) for line in log.read_text().splitlines()]

    def function(machine: object) -> dict[str, float]:
        x = value(machine)  # type: ignore[arg-type]
        before = computed()
        log.write_text("\n".join(map(str, [*before, x])))
        if x == 3.0 and 3.0 not in before:
            raise KeyboardInterrupt
        return {"squared": x**2, "inverse": 1 / (x - 2) if 2.0 not in before else 0.0}

    path = tmp_path / "a.journal"
    planned, told = plan(se.read(SLIDE), Sweeping(over={"m": [1, 2, 3, 4]}, of=function)), list[str]()
    with pytest.raises(KeyboardInterrupt):
        planned.run(path)
    found = planned.run(path, note=told.append)
    assert computed() == [1.0, 2.0, 3.0, 2.0, 3.0, 4.0]
    assert told == ["1 of 4 points were computed before and are kept"]
    assert found.figures["squared"].tolist() == [1.0, 4.0, 9.0, 16.0] and found.failures == 0


def test_a_sweep_without_room_is_refused_with_the_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    planned = plan(se.read(SLIDE), Sweeping(over={"m": "1:2:10000"}, of=squared))
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=10**6))
    with pytest.raises(InputError, match=r"need 0.0012 GB, and 0.001 GB are free: give fewer points"):
        planned.run(tmp_path / "a.journal")
    monkeypatch.setattr(running, "MOST_HELD", 10**4)
    with pytest.raises(
        InputError, match=r"1 results and 1 axes at 10000 points make 2e\+04 numbers, 1e\+04 is the limit"
    ):
        planned.run()
    assert list(tmp_path.iterdir()) == []


def test_a_sweep_without_any_result_leaves_no_journal(tmp_path: Path) -> None:
    given = ("sweep", EXAMPLES / "two_axis.toml", "--over", "ram.k=-1,-2", "--out", tmp_path / "out.csv")
    assert "all 2 points without a result" in refused(*given) and list(tmp_path.iterdir()) == []
    (tmp_path / "out.csv.journal").write_bytes(b"")
    refused(*given)
    assert [path.name for path in tmp_path.iterdir()] == ["out.csv.journal"], "one that was there stays"
