"""The recorded session in docs/ is what the terminal shows."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.tui.session import DOCUMENT, record


def test_the_recorded_session(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = record(tmp_path)
    if os.environ.get("RENEW_FRAMES"):
        DOCUMENT.write_text(text, "utf-8")
    assert text == DOCUMENT.read_text("utf-8")
    words = (
        "CHECK of contour.nc",
        "RUNNING",
        "HOLD",
        "set 60 eff 60 %",
        "ACTIVE",
        "E104",
        "acknowledged",
        "DONE",
        "PASS",
    )
    assert not [word for word in words if word not in text]
