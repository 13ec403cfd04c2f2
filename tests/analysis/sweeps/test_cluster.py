"""Sweeps by the workers of a Dask cluster: the same numbers, and one line where it is not there or goes away."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import symoro_elastic as se
from symoro_elastic.analysis.sweeps import running
from symoro_elastic.analysis.sweeps.running import Workplace
from symoro_elastic.api.options import Sweeping
from symoro_elastic.api.sweeps import plan
from symoro_elastic.foundation.errors import InputError
from tests.analysis.sweeps.machines import SLIDE, squared

distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def local() -> Iterator[Any]:
    """A cluster of two threads in this process, behind an address."""
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, protocol="tcp", dashboard_address=":0"
    ) as found:
        yield found


def test_a_cluster_gives_the_figures_of_one_process(local: Any) -> None:
    over = {"m": "1:3:10", "load.k": "1e4:1e5:3,log"}
    here, there = (
        se.sweep(SLIDE, over=over, hold=["all"], scheduler=address) for address in (None, local.scheduler_address)
    )
    assert list(here.figures) == list(there.figures)
    assert all((here.figures[name] == there.figures[name]).all() for name in here.figures)


@pytest.mark.parametrize(
    ("address", "said"), [("nonsense", "is not an address"), ("tcp://127.0.0.1:9", "no scheduler answers there")]
)
def test_no_scheduler_is_one_line(address: str, said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "PATIENCE", 0.3)
    with pytest.raises(InputError) as error:
        se.sweep(SLIDE, over={"m": [1.0, 2.0]}, of=squared, scheduler=address)
    assert said in str(error.value) and "\n" not in str(error.value)


def test_a_scheduler_that_goes_away_is_one_line_and_points_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(running, "PATIENCE", 2.0)
    planned, path = plan(se.read(SLIDE), Sweeping(over={"m": "1:4:40"}, of=squared)), tmp_path / "journal"
    going = distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="tcp", dashboard_address=":0"
    )

    def close(done: int, total: int) -> None:
        going.close()

    with pytest.raises(InputError, match="the scheduler is gone"):
        replace(planned, workplace=Workplace(scheduler=going.scheduler_address)).run(path, progress=close)
    assert 0 < len(path.read_text().splitlines()) - 1 < 40
    found = planned.run(path)
    assert found.figures["squared"] == pytest.approx(found.points[:, 0] ** 2, rel=1e-15)
