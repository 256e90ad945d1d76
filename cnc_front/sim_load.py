"""Loads part programs for the terminal, for the machine as it stands and the switches as they are."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from cnc_front.engine import Switches
from cnc_front.errors import UsageError
from cnc_front.jobs import (
    CompileOptions,
    JobSource,
    MachineFile,
    StimulusFile,
    load_machine,
    load_stimulus,
    read_job,
)
from cnc_front.search import Start, search
from cnc_front.sim_bench import Bench, Place
from cnc_front.sim_job import LoadedJob, load_source

#: How a block is named: "N120", or "57" for a line.
BLOCK = re.compile(r"N?[0-9]{1,9}")


def dry_feed(switches: Switches, machine: MachineFile) -> float:
    """The dry-run feed in mm/s: what the operator chose, else that of the machine file; never above its feed limit."""
    chosen = machine.machine.dry_feed if switches.dry_feed is None else switches.dry_feed / 60.0
    return min(chosen, machine.machine.feed_limit)


#: Told of a job of CNC tasks: the screens of part programs and the queue have no blocks, path and hold for it.
NO_PART_PROGRAM = (
    "a rw_SymPas job has tasks, no blocks: cnc-front run FILE gives its verdict, cnc-front tui FILE steps through it"
)


@dataclass(frozen=True, slots=True)
class Asked:
    """What was loaded under which conditions: where one of them changed, the program must be checked again."""

    path: str
    start: str | None  # block, None: the top
    switches: Switches
    place: Place


@dataclass(frozen=True, slots=True)
class Loaded:
    """A job and what it was loaded for."""

    asked: Asked
    machine: MachineFile
    source: JobSource
    stimulus: StimulusFile | None
    job: LoadedJob
    start: Start | None


@dataclass(frozen=True, slots=True)
class Loader:
    """Knows the machine file and the options of the command line. Safe across threads."""

    machine: str | None
    options: CompileOptions

    def first_bench(self) -> Bench:
        """The machine as its file says, before any job. Raises CompileError."""
        file = load_machine(self.machine)
        return Bench(file, Place.first(file.machine))

    def compile_options(self, switches: Switches, machine: MachineFile) -> CompileOptions:
        """The switches as the compiler takes them."""
        return replace(
            self.options,
            optional_stop=switches.optional_stop,
            block_delete=switches.skip,
            dry_feed=dry_feed(switches, machine) if switches.dry_run else None,
        )

    def load(self, path: str, start: str | None, switches: Switches, bench: Bench) -> Loaded:
        """Reads and compiles a job for the machine on the bench, or for that of its own machine file at its start.
        Raises CompileError."""
        if start is not None and not BLOCK.fullmatch(start):
            raise UsageError(f"{start}: no block; write N120, or 57 for a line")
        file = load_machine(self.machine, path)
        same = file.sha256 == bench.file.sha256
        place = bench.place if same else Place.first(file.machine)
        source = read_job(path, self.options.language)
        if source.language != "din66025":
            raise UsageError(NO_PART_PROGRAM)
        stimulus = load_stimulus(None, path, file)
        options = replace(self.compile_options(switches, file), start=start)
        job = load_source(source, place.machine(file), options, stimulus)
        begins: Start | None = job.job.facts["start"] if start else None
        return Loaded(Asked(path, start, switches, place), file, source, stimulus, job, begins)

    def search(self, loaded: Loaded, block: str) -> Start:
        """The state before a block of a loaded job. Raises CompileError, or UsageError for what names no block."""
        if not BLOCK.fullmatch(block):
            raise UsageError(f"{block}: no block; write N120, or 57 for a line")
        options = self.compile_options(loaded.asked.switches, loaded.machine)
        return search(loaded.source, loaded.asked.place.machine(loaded.machine), options, block)
