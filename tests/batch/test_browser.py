"""The index in a browser: no errors, and the figures of the store."""

from __future__ import annotations

import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import pytest

from tests.batch.conftest import batch, machines, results

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


class Table(HTMLParser):
    """Texts of the cells of each row of the body that is shown."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self._inside, self._hidden = False, False
        self.feed(page[page.index("<tbody>") : page.index("</tbody>")])

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        if tag == "tr":
            self._hidden = "hidden" in dict(attributes)
            if not self._hidden:
                self.rows.append([])
        elif tag == "td" and not self._hidden:
            self.rows[-1].append("")
            self._inside = True

    def handle_endtag(self, tag: str) -> None:
        self._inside = self._inside and tag != "td"

    def handle_data(self, data: str) -> None:
        if self._inside:
            self.rows[-1][-1] += data


def shown(page: Path, then: str, folder: Path) -> list[list[str]]:
    """What a reader sees after the script `then`; an error in the console fails."""
    assert CHROMIUM is not None
    copy = page.with_name("copy.html")
    copy.write_text(page.read_text("utf-8").replace("</body>", f"<script>{then}</script></body>"), "utf-8")
    options = ["--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder}", "--enable-logging=stderr"]
    done = subprocess.run([CHROMIUM, *options, "--dump-dom", copy], capture_output=True, text=True, timeout=120)
    assert "CONSOLE" not in done.stderr, done.stderr
    return Table(done.stdout).rows


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
def test_the_index_shows_the_store(parts: Path, tmp_path: Path) -> None:
    (parts / "wrong.nc").write_text("G01 X1 F100\nG01 Q*\nM30\n")
    out = tmp_path / "out"
    batch(parts, *machines(), "--out", out, "--reports", 1, code=2)
    kept = results(out)
    rows = shown(out / "index.html", "", tmp_path / "profile")
    assert len(rows) == len(kept) == 18 and [row[0] for row in rows[:2]] == ["FAIL", "FAIL"]
    told = {(row[1], row[2]): row for row in rows}
    for row in kept:
        verdict, _, _, deviation, line, seconds, *_ = told[row["part"], row["machine_name"]]
        assert verdict == row["verdict"]
        if row["deviation_max_mm"] is not None:
            assert deviation == f"{row['deviation_max_mm'] * 1e3:.2f}" and line == str(row["worst_line"])
            assert seconds == f"{row['machine_time_s']:.2f}"
    slowest = "const b = document.querySelectorAll('th button')[5]; b.click(); b.click();"
    order = [row[5] for row in shown(out / "index.html", slowest, tmp_path / "profile") if row[5]]
    assert order == sorted(order, key=float, reverse=True) and len(order) == 16
    word = "words.value = 'PART3'; words.dispatchEvent(new Event('input'));"
    assert {Path(row[1]).name for row in shown(out / "index.html", word, tmp_path / "profile")} == {"part3.nc"}
