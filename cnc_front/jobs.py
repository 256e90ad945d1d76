"""Jobs and machine files: finding, reading and compiling them."""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cnc_front._native import gcode as native_gcode
from cnc_front._native import motion_kernel as native_kernel
from cnc_front._native import sympas as native_sympas
from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import CompileError
from cnc_front.readiness import finding

#: Motion blocks of a program whose path is held as a whole: about 2.3 kB each in a report.
MOST_BLOCKS = 1_000_000
#: Largest job that is read (GC106) and largest machine file, bytes.
JOB_BYTES = 256 << 20
MACHINE_BYTES = 1 << 20


def shown(path: str | os.PathLike[str]) -> str:
    """A path as text for people and files: bytes of a name that are no UTF-8 become U+FFFD."""
    return os.fsencode(path).decode("utf-8", "replace")


@dataclass(frozen=True, slots=True)
class MachineFile:
    """A validated machine and where it came from."""

    path: str
    text: str
    sha256: str
    machine: native_kernel.Machine


@dataclass(frozen=True, slots=True)
class StimulusFile:
    """What the world outside does in a run, and where that stands."""

    path: str
    text: str
    sha256: str
    stimulus: native_kernel.Stimulus

    def as_json(self) -> dict[str, str]:
        """For the object of `run --json`."""
        return {"path": shown(self.path), "sha256": self.sha256}


@dataclass(frozen=True, slots=True)
class JobSource:
    """The bytes of a job, read once."""

    path: str
    data: bytes
    language: str

    @property
    def sha256(self) -> str:
        """Hash of the bytes."""
        return hashlib.sha256(self.data).hexdigest()

    @property
    def lines(self) -> int:
        """Lines of the text, by its line ends."""
        text = self.data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        return text.count(b"\n") + (not text.endswith(b"\n")) if text else 0

    @property
    def content(self) -> bytes:
        """The bytes, as a recording takes them."""
        return self.data

    def text(self) -> str:
        """The text for people: UTF-8, else Windows-1252 as the dialect says."""
        try:
            return self.data.decode("utf-8-sig")
        except UnicodeDecodeError:
            return self.data.decode("cp1252", errors="replace")


@dataclass(frozen=True, slots=True)
class CompiledJob:
    """A program that compiled, with its warnings and what the compiler knows about it."""

    source: JobSource
    machine: MachineFile
    program: native_gcode.Program
    warnings: tuple[Diagnostic, ...]
    facts: dict[str, Any]
    #: feed that stands in place of the programmed ones, mm/s
    dry_feed: float | None = None


@dataclass(frozen=True, slots=True)
class CompileOptions:
    """Switches of the operator that act on compilation."""

    profile: str | None = None
    optional_stop: bool = False
    block_delete: Sequence[int] = field(default=())
    language: str | None = None
    #: first and last block of the part that is wanted: "N120", or "57" for a line
    start: str | None = None
    stop: str | None = None
    #: warnings of the linter too
    strict: bool = False
    #: language of messages
    messages: str = "en"
    #: dry-run feed, mm/s: feed moves go at it instead of F
    dry_feed: float | None = None
    #: a block of MDI: the end of a program is neither executed nor missed
    mdi: bool = False


def read_bytes(path: str, limit: int, id: str, head: int | None = None) -> bytes:
    """A regular file of at most `limit` bytes; anything else is a CompileError with one diagnostic. With `head` only
    so many bytes of it are read."""
    try:
        # without O_NONBLOCK a named pipe would wait for a writer for ever
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    except OSError as error:
        raise cannot_read(path, id, error.strerror or str(error)) from None
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise cannot_read(path, id, "not a regular file")
    before = os.fstat(handle)
    try:
        with os.fdopen(handle, "rb") as file:
            data = file.read(limit + 1 if head is None else head)
            after = os.fstat(handle)
    except OSError as error:  # a bad disk, a share that is gone
        raise cannot_read(path, id, error.strerror or str(error)) from None
    if head is not None:
        return data
    if (before.st_size, before.st_mtime_ns) != (after.st_size, after.st_mtime_ns) and id == "GC112":
        raise CompileError([finding(shown(path), "GC114")])
    if len(data) > limit:
        raise CompileError(
            [Diagnostic(shown(path), 1, 1, 1, "GC106", f"file larger than {limit >> 20} MiB", "split the job")]
        )
    return data


def cannot_read(path: str, id: str, reason: str) -> CompileError:
    """What reading a file ends with."""
    message = f"file cannot be read: {reason}"
    return CompileError([Diagnostic(shown(path), 1, 1, 1, id, message, "check the path and its permissions")])


def language_of(path: str, data: bytes, asked: str | None) -> str:
    """Design D28: `.src` is rw_SymPas, the autocode magic is autocode, all else DIN 66025."""
    if asked is not None:
        return asked
    if data.startswith(native_sympas.MAGIC):
        return "autocode"
    return "sympas" if path.lower().endswith(".src") else "din66025"


def language_at(path: str, asked: str | None) -> str | None:
    """The language of a job by its name and its first bytes; None for what cannot be read."""
    try:
        data = read_bytes(path, JOB_BYTES, "GC112", head=len(native_sympas.MAGIC))
    except CompileError:
        return None
    return language_of(path, data, asked)


def read_job(path: str, language: str | None = None) -> JobSource:
    """The job at `path`; raises CompileError (GC112, GC106)."""
    data = read_bytes(path, JOB_BYTES, "GC112")
    return JobSource(path, data, language_of(path, data, language))


def load_machine(path: str | None, job: str | None = None) -> MachineFile:
    """The machine file given, else `machine.toml` beside the job, else the built-in mill."""
    if path is None and job is not None:
        beside = Path(job).parent / "machine.toml"
        path = str(beside) if beside.is_file() else None
    if path is None:
        text = native_kernel.Machine.builtin_text()
        return MachineFile("", text, hashlib.sha256(text.encode()).hexdigest(), native_kernel.Machine.builtin())
    data = read_bytes(path, MACHINE_BYTES, "MC100")
    try:
        machine = native_kernel.Machine.parse(data, shown(path))
    except native_kernel.MachineError as error:
        raise CompileError([Diagnostic(*row) for row in error.args[0]]) from None
    return MachineFile(path, data.decode("utf-8"), hashlib.sha256(data).hexdigest(), machine)


def load_stimulus(path: str | None, job: str, machine: MachineFile) -> StimulusFile | None:
    """The stimulus file given, else the one beside the job (`part.stim` for `part.nc`), else none, for the axes of a
    machine; raises CompileError (ST100 ...)."""
    if path is None:
        beside = Path(job).with_suffix(".stim")
        if not beside.is_file():
            return None
        path = str(beside)
    data = read_bytes(path, MACHINE_BYTES, "ST100")
    try:
        stimulus = native_kernel.Stimulus.parse(data, shown(path), machine.machine)
    except native_kernel.MachineError as error:
        raise CompileError([Diagnostic(*row) for row in error.args[0]]) from None
    return StimulusFile(path, data.decode("utf-8"), hashlib.sha256(data).hexdigest(), stimulus)


def diagnose(
    source: JobSource, machine: MachineFile, options: CompileOptions, *, check_only: bool
) -> tuple[native_gcode.Program | None, tuple[Diagnostic, ...], dict[str, Any]]:
    """Compiles without judging: program (None with errors or `check_only`), all diagnostics, facts."""
    if check_only and source.language != "din66025":
        return None, compile_autocode(source, machine, options)[1], {}
    if source.language != "din66025":
        raise CompileError([_no_path(source)])
    program, rows, facts = native_gcode.compile(
        source.data,
        shown(source.path),
        machine.machine,
        profile=options.profile,
        optional_stop=options.optional_stop,
        block_delete=list(options.block_delete),
        check_only=check_only,
        library=str(Path(source.path).parent),
        start=options.start,
        stop=options.stop,
        strict=options.strict,
        dry_feed=options.dry_feed,
        mdi=options.mdi,
    )
    return program, tuple(Diagnostic(*row) for row in rows), facts


def compile_job(source: JobSource, machine: MachineFile, options: CompileOptions) -> CompiledJob:
    """The whole way from text to a program; raises CompileError with every diagnostic if there is an error."""
    program, diagnostics, facts = diagnose(source, machine, options, check_only=False)
    if program is None:
        raise CompileError(diagnostics)
    return CompiledJob(source, machine, program, diagnostics, facts, options.dry_feed)


def check_held(path: str, blocks: int) -> None:
    """Raises CompileError (CF203) for a path that is too long to be held as a whole."""
    if blocks > MOST_BLOCKS:
        message = f"a path of more than {MOST_BLOCKS} motion blocks is not held as a whole, as this needs it"
        hint = "run it without (a verdict and --record take any length), or a part of it: --from, --to"
        raise CompileError([Diagnostic(shown(path), 1, 1, 1, "CF203", message, hint)])


def compile_autocode(
    source: JobSource, machine: MachineFile, options: CompileOptions
) -> tuple[native_sympas.Program | None, tuple[Diagnostic, ...]]:
    """Register code of a rw_SymPas job or of an autocode file (None with errors), and all diagnostics."""
    name = shown(source.path)
    if source.language == "autocode":
        try:
            return native_sympas.decode(source.data), ()
        except ValueError as error:
            hint = "compile the job again: cnc-front translate JOB.src --output FILE.cnc"
            return None, (Diagnostic(name, 1, 1, 1, "CF202", str(error), hint),)
    program, rows = native_sympas.compile(
        source.data, name, machine.machine, path=source.path, language=options.messages
    )
    return program, tuple(Diagnostic(*row) for row in rows)


def _no_path(source: JobSource) -> Diagnostic:
    message = f"{source.language} jobs have no programmed path to show or to compare with"
    hint = "cnc-front run, check and translate take them"
    return Diagnostic(shown(source.path), 1, 1, 1, "CF201", message, hint)
