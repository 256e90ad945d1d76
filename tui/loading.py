"""What is being loaded, since when, and whether it is wanted: a load cannot be interrupted, but it can be let go."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from tui.words import Words

#: Without a word about the time up to here, s (ui-guide section 4: over 0.3 s activity, over 2 s a way to cancel).
SHORT_S = 2.0


class Loading:
    """One load at a time: a newer one, or the operator, lets the older one go."""

    def __init__(self) -> None:
        self._count = 0
        self._path = ""
        self._began = 0.0

    @property
    def is_active(self) -> bool:
        """Something is being loaded."""
        return self._path != ""

    @property
    def name(self) -> str:
        """The file."""
        return Path(self._path).name

    def begin(self, path: str) -> Callable[[], bool]:
        """Notes what is loaded; the answer says whether it is still wanted."""
        self._count += 1
        self._path, self._began = path, time.monotonic()
        mine = self._count
        return lambda: self._count == mine

    def end(self) -> None:
        """It is there, refused, or not wanted any more."""
        self._count += 1
        self._path = ""

    def text(self, words: Words) -> str:
        """The line about it; empty where nothing is loaded."""
        if not self.is_active:
            return ""
        seconds, path = time.monotonic() - self._began, Path(self._path)
        if seconds < SHORT_S:
            return words("loading", name=self._path[-50:])
        size = path.stat().st_size / 1e6 if path.is_file() else 0.0
        return words("loading_long", name=path.name[-40:], seconds=seconds, size=size)
