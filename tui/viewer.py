"""The browser view: the operator's screen on a page at localhost, for looking only.

It is a mirror of the terminal and has no way to the engine: it knows GET and two addresses, the page and its frames.
Nothing comes from the network. Frames are sent as server-sent events, only while somebody looks.
"""

from __future__ import annotations

import json
import secrets
import threading
from collections.abc import Iterable, Sequence
from html import escape
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, ClassVar

from rich.segment import Segment
from rich.terminal_theme import SVG_EXPORT_THEME

from cnc_front.errors import UsageError

#: Pages that look at once.
MOST_VIEWERS = 8
#: A page that got nothing for so long gets a comment, so that a closed one is noticed, s.
PULSE_S = 5.0

_PAGE = """<!doctype html><html lang="{language}"><meta charset="utf-8"><title>cnc-front</title>
<style>body{{margin:0;background:{background};color:{foreground}}}
p{{font:14px sans-serif;margin:4px 8px}}pre{{font:15px/1.25 monospace;margin:0 8px}}.old pre{{opacity:.4}}</style>
<p>{note}</p><pre id="screen"></pre><script nonce="{nonce}">
const source = new EventSource("/frames");
source.onmessage = event => {{ document.body.className = "";
  document.getElementById("screen").innerHTML = JSON.parse(event.data); }};
source.onerror = () => {{ document.body.className = "old"; }};
</script></html>
"""
_POLICY = "default-src 'none'; connect-src 'self'; style-src 'unsafe-inline'; script-src 'nonce-{nonce}'"


def as_html(rows: Iterable[Iterable[Segment]]) -> str:
    """Rows of the screen as lines of spans. Whatever a program's text holds stays text."""
    lines = []
    for row in rows:
        spans = []
        for text, style, control in row:
            if control:
                continue
            css = style.get_html_style(SVG_EXPORT_THEME) if style else ""
            spans.append(f'<span style="{escape(css)}">{escape(text)}</span>' if css else escape(text))
        lines.append("".join(spans))
    return "\n".join(lines)


class Viewer:
    """Serves the newest frame. Raises UsageError where the port is taken."""

    def __init__(self, port: int, note: str, language: str, colours: tuple[str, str]) -> None:
        """`port` 0: any free one. `note`: what stands above the screen."""
        self._news = threading.Condition()
        self._frame, self._number, self._watching = "", 0, 0
        self._closed = False
        self.page = (note, language, colours)
        handler = type("Handler", (_Handler,), {"viewer": self})
        try:
            self._server = ThreadingHTTPServer(("127.0.0.1", port), handler)
        except OSError as error:
            raise UsageError(f"--view: port {port} of localhost: {error.strerror or error}; choose another") from None
        self._server.daemon_threads = True
        self.port = int(self._server.server_address[1])
        threading.Thread(target=self._server.serve_forever, name="viewer", daemon=True).start()

    @property
    def is_watched(self) -> bool:
        """Somebody looks: only then are frames worth making."""
        return self._watching > 0

    def show(self, rows: Sequence[Iterable[Segment]]) -> None:
        """Another frame."""
        frame = as_html(rows)
        with self._news:
            if frame != self._frame:
                self._frame, self._number = frame, self._number + 1
                self._news.notify_all()

    def close(self) -> None:
        """Ends the server and lets all pages go."""
        with self._news:
            self._closed = True
            self._news.notify_all()
        self._server.shutdown()
        self._server.server_close()

    def admit(self, by: int) -> bool:
        """A page comes (1) or goes (-1); False if there are too many."""
        with self._news:
            if by > 0 and self._watching >= MOST_VIEWERS:
                return False
            self._watching += by
            return True

    def after(self, number: int) -> tuple[int, str | None]:
        """Waits for a frame newer than `number`; None if nothing came. The number is -1 once all is over."""
        with self._news:
            self._news.wait_for(lambda: self._closed or self._number != number, PULSE_S)
            if self._closed:
                return -1, None
            return self._number, self._frame if self._number != number else None


class _Handler(BaseHTTPRequestHandler):
    """GET of the page and of its frames; everything else is refused."""

    viewer: ClassVar[Viewer]
    server_version, sys_version = "cnc-front", ""
    timeout = 30

    def do_GET(self) -> None:
        """The page, or frames without end."""
        hosts = {f"{name}:{self.viewer.port}" for name in ("localhost", "127.0.0.1")}
        if self.headers.get("Host") not in hosts:  # a page elsewhere that pretends to be localhost
            self.send_error(403, "localhost only")
        elif self.path == "/":
            self._send_page()
        elif self.path == "/frames":
            self._send_frames()
        else:
            self.send_error(404)

    def _send_page(self) -> None:
        nonce = secrets.token_urlsafe(16)
        note, language, (background, foreground) = self.viewer.page
        values = {"note": escape(note), "language": language, "nonce": nonce}
        body = _PAGE.format(**values, background=background or "#000", foreground=foreground or "#ccc").encode()
        self._head("text/html; charset=utf-8", nonce, len(body))
        self.wfile.write(body)

    def _head(self, kind: str, nonce: str, length: int | None = None) -> None:
        self.send_response(200)
        headers = {
            "Content-Type": kind,
            "Content-Security-Policy": _POLICY.format(nonce=nonce),
            "Cache-Control": "no-store",
            "X-Content-Type-Options": "nosniff",
            "X-Frame-Options": "DENY",
        }
        for name, value in headers.items():
            self.send_header(name, value)
        if length is not None:
            self.send_header("Content-Length", str(length))
        self.end_headers()

    def _send_frames(self) -> None:
        if not self.viewer.admit(1):
            self.send_error(503, "too many viewers")
            return
        try:
            self._head("text/event-stream", "none")
            number = 0
            while number >= 0:
                number, frame = self.viewer.after(number)
                self.wfile.write(b": pulse\n\n" if frame is None else f"data: {json.dumps(frame)}\n\n".encode())
                self.wfile.flush()
        except OSError:
            pass  # the page was closed
        finally:
            self.viewer.admit(-1)

    def log_message(self, format: str, *values: Any) -> None:
        """Nothing is written to the terminal, which shows the screen."""
