"""A worker process of a batch: one dry-run after the other, each asked for by a line of JSON on stdin.

An answer is one line of JSON on the stream that was stdout at the start: `{"code", "run", "stderr"}`. The process has
its own limit of memory; whatever ends it is the end of one task only.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import resource
import sys


def limit_memory(mib: int) -> None:
    """The process gets no more memory of its own than that."""
    if mib > 0:
        resource.setrlimit(resource.RLIMIT_DATA, (mib << 20, resource.RLIM_INFINITY))


def dry_run(arguments: list[str]) -> dict[str, object]:
    """`cnc-front run ... --json` inside this process; a batch has a store of its own and no place in the history."""
    from cnc_front.cli import run_command_line

    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = run_command_line(["run", *arguments, "--json", "--quiet", "--history", "off"])
    text = out.getvalue().strip()
    return {"code": code, "run": json.loads(text) if text else None, "stderr": err.getvalue()[-4000:]}


def main() -> None:
    """Serves until stdin ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # nothing else may write between the answers
    limit_memory(int(sys.argv[1]) if len(sys.argv) > 1 else 0)
    for line in sys.stdin:
        try:
            answer = dry_run(json.loads(line))
        except MemoryError:
            answer = {"code": 3, "run": None, "stderr": "out of memory", "memory": True}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
