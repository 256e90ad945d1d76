"""The browser view: the operator's screen, read-only, on localhost, from nowhere else."""

from __future__ import annotations

import json
import re
import socket
import threading
import time
from collections.abc import Iterator
from http.client import HTTPConnection, HTTPResponse

import pytest
from rich.segment import Segment
from rich.style import Style

from cnc_front.errors import UsageError
from tests.tui.stage import Stage, play
from tests.tui.test_terminal import REAL, window
from tui.viewer import MOST_VIEWERS, Viewer, as_html


@pytest.fixture
def viewer() -> Iterator[Viewer]:
    made = Viewer(0, "only <looking>", "en", ("#1b1d1f", "#d0d0d0"))
    yield made
    made.close()


def ask(viewer: Viewer, path: str, method: str = "GET", host: str = "") -> HTTPResponse:
    connection = HTTPConnection("127.0.0.1", viewer.port, timeout=10)
    connection.request(method, path, headers={"Host": host or f"localhost:{viewer.port}"})
    return connection.getresponse()


def test_the_page_asks_nobody_else(viewer: Viewer) -> None:
    answer = ask(viewer, "/")
    page = answer.read().decode()
    policy = answer.headers["Content-Security-Policy"]
    assert "only &lt;looking&gt;" in page and "default-src 'none'" in policy
    assert re.findall(r"(?:src|href|url)\\s*[=(]", page) == [] and "://" not in page
    assert re.search(r"nonce=\"([^\"]+)\"", page).group(1) in policy  # type: ignore[union-attr]


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS"])
def test_it_can_only_be_looked_at(method: str, viewer: Viewer) -> None:
    assert ask(viewer, "/", method).status == 501


def test_a_foreign_page_gets_nothing(viewer: Viewer) -> None:
    assert ask(viewer, "/", host="evil.example").status == 403
    assert ask(viewer, "/frames", host=f"evil.example:{viewer.port}").status == 403
    assert ask(viewer, "/etc/passwd").status == 404


def test_it_listens_on_localhost_only(viewer: Viewer) -> None:
    assert viewer._server.server_address[0] == "127.0.0.1"
    with pytest.raises(UsageError, match="choose another"):
        Viewer(viewer.port, "", "en", ("", ""))


def frame(answer: HTTPResponse) -> str:
    """The next frame."""
    while not (line := answer.readline()).startswith(b"data: "):
        assert line, "the stream has ended"
    return str(json.loads(line[6:]))


def test_the_screen_is_mirrored_while_somebody_looks(viewer: Viewer) -> None:
    async def script(stage: Stage) -> None:
        stage.app.viewer = viewer
        await stage.load()
        await stage.frame()
        assert viewer._number == 0, "nobody looks, nothing is made"
        answers: list[str] = []

        def look() -> None:
            stream = ask(viewer, "/frames")
            for part in ("bracket_07.nc", "RUNNING", "SERVICE"):
                answers.append(next(text for text in iter(lambda: frame(stream), "") if part in text))

        thread = threading.Thread(target=look)
        thread.start()
        await stage.until(lambda: len(answers) == 1)  # equal frames are sent once
        stage.engine.run_half()
        await stage.until(lambda: len(answers) == 2)
        await stage.press("8")
        await stage.until(lambda: len(answers) == 3)
        thread.join()
        assert "background-color: #8ecbff" in answers[0]

    play(script)


def test_what_a_program_says_stays_text() -> None:
    rows = [[Segment("<script>&", Style(color="#ff6a13")), Segment('"')], [Segment("x")]]
    html = as_html(rows)
    assert html.count("\n") == 1 and "&lt;script&gt;&amp;" in html and "<script>" not in html


def test_so_many_and_no_more(viewer: Viewer) -> None:
    viewer.show([[Segment("x")]])
    streams = [ask(viewer, "/frames") for _ in range(MOST_VIEWERS)]
    assert all(stream.status == 200 for stream in streams)
    assert ask(viewer, "/frames").status == 503


def test_closing_lets_pages_go(viewer: Viewer) -> None:
    stream = ask(viewer, "/frames")
    other = Viewer(0, "", "en", ("", ""))
    began = time.monotonic()
    other.close()
    assert time.monotonic() - began < 3 and stream.status == 200
    with pytest.raises(OSError):
        socket.create_connection(("127.0.0.1", other.port), 1).close()


def test_a_closed_page_ends_nothing() -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    with window([*REAL, "examples/jobs/cam.nc", "--view", str(port)], (120, 40)) as w:
        w.shows("DISC CAM")
        for _ in range(3):
            with socket.create_connection(("127.0.0.1", port), 10) as page:
                page.sendall(b"GET /frames HTTP/1.1\r\nHost: localhost:%d\r\n\r\n" % port)
                while b"data: " not in page.recv(65536):
                    w.read(0.05)
        w.press("r", "STOPPED")  # every frame goes to pages that are gone
        w.press("r", "RUNNING")
        w.press(" ", "HOLD")
        assert w.ended() is None
