"""Starts the terminal: the only place that knows which engine stands behind it, and what a closed terminal means."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import cast

from cnc_front.engine import Engine, State
from cnc_front.errors import Exit, UsageError
from cnc_front.history import place
from tui.app import Terminal
from tui.archive import Archive
from tui.debug_keys import ALL_KEYS, main_keys
from tui.keys import Key
from tui.look import Look, choose_look
from tui.words import Words

#: After the terminal was closed: longest wait for standstill, and for a tidy end, s.
STANDSTILL_S, END_S = 5.0, 3.0


def run_terminal(options: argparse.Namespace, language: str) -> int:
    """Until the operator quits. Raises UsageError where there is no terminal to draw on."""
    if options.keys:
        from tui.keymap import table_text

        print(table_text(keys_of(options), Words(language)))
        return int(Exit.DONE)
    if options.no_input:
        raise UsageError("tui is operated by its input; cnc-front run needs none")
    if options.plain:
        return run_plain(options, language)
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise UsageError("tui needs a terminal; `tui --plain` and `cnc-front run` work without one")
    look = choose_look(options.theme, options.glyphs, os.environ)
    keys = keys_of(options)
    if options.job and is_sap(options):
        return debug(options, look, Words(language), keys)
    engine = make_engine(options, language)
    archive = Archive(place(options.history), language)
    viewer = None
    try:
        if options.view is not None:
            from tui.viewer import Viewer

            if hasattr(signal, "SIGPIPE"):
                signal.signal(signal.SIGPIPE, signal.SIG_IGN)  # a page that is closed ends nothing
            colours = (look.background, look.foreground)
            viewer = Viewer(options.view, Words(language)("view_note"), language, colours)
        mouse = not options.no_mouse
        terminal = Terminal(
            engine,
            look,
            Words(language),
            job=options.job,
            archive=archive,
            keys=main_keys(keys),
            viewer=viewer,
            mouse=mouse,
        )
        hold_when_hung_up(engine, terminal.leave_from_thread)
        terminal.run(mouse=mouse)
        return int(Exit.DONE if terminal.return_code == 0 else Exit.STOPPED)
    finally:
        if viewer is not None:
            viewer.close()
        engine.close()
        archive.close()


def keys_of(options: argparse.Namespace) -> tuple[Key, ...]:
    """The keys, with what the keymap file changes. Raises UsageError."""
    from tui import keymap

    path = keymap.place(options.keymap, os.environ)
    return ALL_KEYS if path is None else keymap.read_keymap(path)


def run_plain(options: argparse.Namespace, language: str) -> int:
    """Line mode, with or without a terminal, until `quit` or the end of the input. Ctrl+C holds; at rest it ends."""
    from tui.plain import Plain
    from tui.states import UNDERWAY

    if options.job and is_sap(options):
        raise UsageError("--plain is for part programs; rw_SymPas jobs: cnc-front run, or tui without --plain")
    engine = make_engine(options, language)
    archive = Archive(place(options.history), language)
    plain = Plain(engine, Words(language), sys.stdout, archive)

    def interrupted(*_: object) -> None:
        if engine.snapshot().state not in UNDERWAY:
            raise KeyboardInterrupt
        engine.hold()

    signal.signal(signal.SIGINT, interrupted)
    hold_when_hung_up(engine, lambda: None)
    try:
        plain.run(sys.stdin, options.job)
        return int(Exit.DONE)
    finally:
        engine.close()
        archive.close()


def is_recording(options: argparse.Namespace) -> bool:
    """The job is a recording, to be replayed."""
    return bool(options.job) and options.job.lower().endswith(".mcap")


def is_sap(options: argparse.Namespace) -> bool:
    """The job is for CNC tasks: rw_SymPas, or autocode."""
    from cnc_front.jobs import read_job

    if is_recording(options):
        return False
    return read_job(options.job, options.language).language != "din66025"


def debug(options: argparse.Namespace, look: Look, words: Words, keys: Sequence[Key]) -> int:
    """Steps through a rw_SymPas job. Raises CompileError with every finding."""
    from cnc_front.jobs import load_machine, load_stimulus
    from cnc_front.sap_command import load_tasks
    from cnc_front.sap_debug import debug_session
    from tui.debugger import Debugger

    machine = load_machine(options.machine, options.job)
    tasks = load_tasks(options, machine)
    stimulus, mouse = load_stimulus(None, options.job, machine), not options.no_mouse
    Debugger(debug_session(machine, tasks, stimulus), look, words, mouse, keys).run(mouse=mouse)
    return int(Exit.DONE)


def make_engine(options: argparse.Namespace, language: str) -> Engine:
    """The emulator, or a recording once one is loaded. A link to a real controller would stand here."""
    from cnc_front.console import Console
    from cnc_front.jobs import CompileOptions
    from cnc_front.sim import SimEngine

    folder = Path(options.record) if options.record else None
    if folder is not None and not folder.is_dir():
        raise UsageError(f"--record: {folder} is not a folder")
    compiling = CompileOptions(options.profile, options.optional_stop, tuple(options.skip), options.language)
    machine = SimEngine(options.machine, compiling, language=language, speed=options.speed, recordings=folder)
    return cast(Engine, Console(machine, language))


def hold_when_hung_up(engine: Engine, leave: Callable[[], None]) -> None:
    """A closed terminal holds the job (ui-guide section 4); once it stands, the program ends.

    Without this handler SIGHUP would kill the process in the middle of a move.
    """
    if not hasattr(signal, "SIGHUP"):
        return

    def end() -> None:
        deadline = time.monotonic() + STANDSTILL_S
        while time.monotonic() < deadline and engine.snapshot().state in (State.RUNNING, State.HOLDING):
            time.sleep(0.02)
        leave()
        time.sleep(END_S)
        engine.close()
        os._exit(128 + signal.SIGHUP)  # the terminal is gone: writing its last words may block for ever

    def hung_up(*_: object) -> None:
        engine.hold()
        threading.Thread(target=end, name="hung-up", daemon=True).start()

    signal.signal(signal.SIGHUP, hung_up)
