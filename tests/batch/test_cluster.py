"""The same tasks on a Dask cluster of processes, one of which dies in the middle."""

from __future__ import annotations

import sqlite3
import subprocess
import time
from pathlib import Path

from distributed import LocalCluster

from tests.batch.conftest import ROOT, batch, command, machines, program, results


def test_a_cluster_with_a_dying_worker_gives_the_same(parts: Path, tmp_path: Path) -> None:
    for n in range(8, 14):
        (parts / f"part{n}.nc").write_text(program(n, 100))
    here, there = tmp_path / "here", tmp_path / "there"
    batch(parts, *machines(), "--out", here, "--reports", 1)
    with LocalCluster(n_workers=3, threads_per_worker=1, dashboard_address=None) as cluster:
        arguments = (
            "batch",
            parts,
            *machines(),
            "--out",
            there,
            "--reports",
            1,
            "--cluster",
            cluster.scheduler_address,
        )
        running = subprocess.Popen(command(*arguments), cwd=ROOT, stderr=subprocess.PIPE, text=True)
        deadline = time.monotonic() + 60
        while not begun(there):
            assert time.monotonic() < deadline and running.poll() is None
            time.sleep(0.05)
        next(iter(cluster.workers.values())).process.process.kill()
        _, said = running.communicate(timeout=200)
    assert running.returncode == 0, said
    assert results(there) == results(here)


def begun(out: Path) -> bool:
    """The first results are there."""
    try:
        return (out / "results.sqlite").is_file() and results(out) != []
    except sqlite3.OperationalError:
        return False  # the table is not there yet


def test_an_address_without_a_cluster_is_told(parts: Path, tmp_path: Path) -> None:
    ran = batch(parts, "--out", tmp_path / "out", "--cluster", "tcp://127.0.0.1:9", code=2)
    assert "127.0.0.1:9" in ran.stderr
