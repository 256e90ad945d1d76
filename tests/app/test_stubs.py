"""The stubs of the compiled module say what it has."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from tests.app.conftest import ROOT


def test_stubs_match_the_compiled_module() -> None:
    pytest.importorskip("mypy.stubtest")
    modules = [f"cnc_front._native.{path.stem}" for path in sorted((ROOT / "cnc_front" / "_native").glob("[a-z]*.pyi"))]
    assert len(modules) == 6
    command = [sys.executable, "-m", "mypy.stubtest", *modules]
    # a cache of its own: others may run mypy beside us
    done = subprocess.run(
        command, capture_output=True, text=True, cwd=ROOT, check=False, env=os.environ | {"MYPY_CACHE_DIR": os.devnull}
    )
    assert done.returncode == 0, done.stdout
