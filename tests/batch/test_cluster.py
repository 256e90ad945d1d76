"""The same tasks on a Dask cluster of processes, one of which dies in the middle."""

from __future__ import annotations

import os
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

from distributed import Client, LocalCluster

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


#: For a worker that must not find the checkout: our rooms are there only once the code has arrived.
WITHOUT_OURS = """
import sys
class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("cnc_front", "gcode", "motion_kernel", "sympas", "toolpaths"):
            if not any("cnc-front-code-" in place for place in sys.path):
                raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Absent())
"""


def test_workers_need_no_cnc_front(parts: Path, tmp_path: Path) -> None:
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "sitecustomize.py").write_text(WITHOUT_OURS)
    bare = {**os.environ, "PYTHONPATH": str(tmp_path / "site")}
    with LocalCluster(n_workers=0, dashboard_address=None) as cluster:
        worker = subprocess.Popen(
            [sys.executable, "-m", "distributed.cli.dask_worker", cluster.scheduler_address, "--no-dashboard"],
            cwd=tmp_path,
            env=bare,
            stderr=subprocess.DEVNULL,
        )
        try:
            batch(parts, "--out", tmp_path / "there", "--cluster", cluster.scheduler_address)
            with Client(cluster.scheduler_address) as client:
                places = client.run(lambda: sys.modules["cnc_front"].__file__)
        finally:
            worker.terminate()
            worker.wait()
    assert places and all("cnc-front-code-" in place for place in places.values())
    batch(parts, "--out", tmp_path / "here")
    assert results(tmp_path / "there") == results(tmp_path / "here")
