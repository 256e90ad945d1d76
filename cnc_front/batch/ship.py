"""The code of this installation for the workers of a Dask cluster: they need Python and numpy, not cnc-front.

This module travels by value and is executed where cnc-front is not installed, or in another version: it imports nothing
of ours before the code has arrived.
"""

from __future__ import annotations

import io
import os
import platform
import shutil
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Any

#: What a dry run imports.
ROOMS = ("cnc_front", "gcode", "motion_kernel", "sympas", "toolpaths")
#: Python text, the compiled module, tables and templates; neither sources in Rust nor tests.
SUFFIXES = (".py", ".so", ".pyd", ".tsv", ".j2", ".css", ".js")


def packed() -> bytes:
    """A zip archive of the rooms as they are installed here."""
    import cnc_front

    root, archive = Path(cnc_front.__file__).parents[1], io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as members:
        for room in ROOMS:
            for file in sorted((root / room).rglob("*")):
                if file.suffix in SUFFIXES and file.is_file():
                    members.write(file, file.relative_to(root))
    return archive.getvalue()


def system() -> str:
    """For which the compiled module is made."""
    return f"{sys.platform} {platform.machine()}"


class Code:
    """A plugin of Dask workers: those that are there and those that come later."""

    name = "cnc-front-code"

    def __init__(self, archive: bytes) -> None:
        self.archive, self.made_for = archive, system()
        self.folder: str | None = None

    def setup(self, worker: Any) -> None:
        """Lays the code where this process and the processes it starts find it first."""
        if "cnc_front" in sys.modules:
            return  # a worker in the process of the user, or one that was set up before
        if system() != self.made_for:
            raise RuntimeError(f"cnc-front for {self.made_for} does not run on {system()}: use workers of one kind")
        self.folder = tempfile.mkdtemp(prefix="cnc-front-code-")
        with zipfile.ZipFile(io.BytesIO(self.archive)) as members:
            members.extractall(self.folder)
        sys.path.insert(0, self.folder)
        before = os.environ.get("PYTHONPATH")
        os.environ["PYTHONPATH"] = os.pathsep.join(p for p in (self.folder, before) if p)

    def teardown(self, worker: Any) -> None:
        """Removes it when the worker ends."""
        if self.folder is not None:
            shutil.rmtree(self.folder, ignore_errors=True)
