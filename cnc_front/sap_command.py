"""What `run` and `translate` do with rw_SymPas jobs and autocode files."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import CompileError, Exit, UsageError
from cnc_front.history_command import keep_run
from cnc_front.jobs import (
    CompileOptions,
    JobSource,
    MachineFile,
    compile_autocode,
    load_machine,
    load_stimulus,
    read_job,
)
from cnc_front.messages import language_from, text
from cnc_front.sap_run import TASKS, SapOptions, Task

if TYPE_CHECKING:
    from cnc_front.geometry.arguments import ReferenceOptions
    from cnc_front.geometry.checks import Checks
    from cnc_front.sap_deliver import Wanted

#: Options of `run` that rw_SymPas jobs do not have, and why.
FOREIGN = {
    "start": "--from: a rw_SymPas job has no blocks to begin at; its variables and waits need the run before",
    "stop": "--to: a rw_SymPas job has no block to end at; put a STOP into the job",
    "time_optimal": "--time-optimal: waits and inputs decide too how long a rw_SymPas job takes, not its path alone",
    "setup": "--setup: a rw_SymPas job names no tools and tells no rapid moves, so material cannot be calculated",
}


def _say(diagnostics: tuple[Diagnostic, ...], options: argparse.Namespace) -> None:
    for diagnostic in diagnostics:
        if not (options.quiet and diagnostic.is_warning):
            print(diagnostic, file=sys.stderr)


def _compile_options(options: argparse.Namespace) -> CompileOptions:
    return CompileOptions(messages=language_from(options.lang))


def _asked(options: argparse.Namespace) -> list[tuple[int | None, str]]:
    """Task numbers and files; the first is the job itself, whose number may stand in its text."""
    asked: list[tuple[int | None, str]] = [(None, options.job)]
    for given in options.task:
        number, equals, path = given.partition("=")
        if not equals or number not in {str(n) for n in range(TASKS)}:
            raise UsageError(f"--task: '{given}' is not N=JOB with N from 0 to {TASKS - 1}")
        asked.append((int(number), path))
    return asked


def _load(number: int | None, path: str, machine: MachineFile, options: argparse.Namespace) -> Task:
    """Compiles one job; raises CompileError with every finding."""
    source: JobSource = read_job(path, options.language)
    if source.language == "din66025":
        raise UsageError(f"{path} is no rw_SymPas job: its name ends with .src, or it is an autocode file")
    program, diagnostics = compile_autocode(source, machine, _compile_options(options))
    if program is None:
        raise CompileError(diagnostics)
    if number is None:
        number = program.task if program.task is not None else 0
    return Task(number, source, program, diagnostics)


def load_tasks(options: argparse.Namespace, machine: MachineFile) -> list[Task]:
    """The jobs of a command line; CompileError with every finding of the first that has one."""
    tasks = [_load(number, path, machine, options) for number, path in _asked(options)]
    numbers = [task.number for task in tasks]
    if len(set(numbers)) < len(numbers):
        raise UsageError(f"two jobs for one task ({', '.join(map(str, numbers))}): give --task N=JOB")
    return tasks


def run_sap(options: argparse.Namespace, interrupted: Callable[[], bool]) -> int:
    """`cnc-front run job.src [--task 1=monitor.src ...]`."""
    from cnc_front.geometry.arguments import reference_options
    from cnc_front.schedule import parse_schedule

    _refuse_foreign(options)
    schedule, about = parse_schedule(options.override), reference_options(options)
    given = (options.job, options.machine, options.stimulus, options.reference)
    wanted = _wanted(options, [*(path or "" for path in given), *(path for _, path in _asked(options))])
    machine = None
    try:
        machine = load_machine(options.machine, options.job)  # known to the result even if a job does not compile
        tasks = load_tasks(options, machine)
        stimulus = load_stimulus(options.stimulus, options.job, machine)
        wanted = replace(wanted, checks=_checks(options, machine, about))
    except CompileError as error:
        from cnc_front.verdict import failed_object

        _say(error.diagnostics, options)
        failed = failed_object(options.job, None, options.machine, machine, error.diagnostics)
        keep_run(failed, options, Exit.BAD_INPUT)
        if options.json:
            print(json.dumps(failed, allow_nan=False))
        return Exit.BAD_INPUT
    for task in tasks:
        _say(task.warnings, options)
    from cnc_front.commands import scanned

    scan = scanned(options, machine.machine)
    sap_options = SapOptions(options.max_time, interrupted, stimulus, schedule, scan)
    return _run_tasks(options, machine, tasks, sap_options, wanted)


def _refuse_foreign(options: argparse.Namespace) -> None:
    for name, why in FOREIGN.items():
        if getattr(options, name, None):
            raise UsageError(why)


def _wanted(options: argparse.Namespace, inputs: list[str]) -> Wanted:
    """What the run is to leave. Raises UsageError."""
    from cnc_front import outputs
    from cnc_front.commands import check_extras
    from cnc_front.sap_deliver import Wanted
    from cnc_front.sweep import parse_sweep

    check_extras(options)
    record = outputs.check_recording(options.record, inputs) if options.record else None
    report = outputs.check_report(options.report, inputs) if options.report else None
    return Wanted(options.tolerance, record, report, options.samples, parse_sweep(options.override_sweep))


def _checks(options: argparse.Namespace, machine: MachineFile, about: ReferenceOptions) -> Checks | None:
    """The check against a drawing. Raises CompileError for one that cannot be read."""
    if options.reference is None:
        return None
    from cnc_front.geometry.checks import checks_of_drawing

    if not {"X", "Y"} <= set(machine.machine.axis_names):
        raise UsageError("--reference: a drawing needs axes X and Y; the machine has none of these names")
    return checks_of_drawing(machine, options.reference, about, options.tolerance)


def _run_tasks(
    options: argparse.Namespace, machine: MachineFile, tasks: list[Task], sap_options: SapOptions, wanted: Wanted
) -> int:
    from cnc_front.progress import Progress
    from cnc_front.sap_deliver import run_and_write
    from cnc_front.sap_verdict import result_text

    language = language_from(options.lang)
    progress = Progress(language, quiet=options.quiet)
    sap_options = replace(sap_options, progress=progress.at)
    result, verdict, run = run_and_write(machine, tasks, sap_options, wanted, language)
    progress.end()
    keep_run(run, options, verdict.exit)
    print(json.dumps(run, allow_nan=False) if options.json else result_text(result, verdict, run, language))
    return verdict.exit


#: Machine time after which a listing ends, s: jobs often loop for ever.
LISTED_S = 600.0


def _list_spooled(options: argparse.Namespace, machine: MachineFile, task: Task) -> int:
    """The motion commands that a job spools when it runs, one JSON object a line (design 3.3)."""
    from cnc_front.sap_run import SapRun
    from cnc_front.spooled import rows_as_json

    stimulus = load_stimulus(None, options.job, machine)
    run = SapRun(machine, [task], SapOptions(LISTED_S, stimulus=stimulus)).run()
    for row in rows_as_json(run.listing, machine.machine.axis_names, run.places):
        print(json.dumps(row, allow_nan=False))
    if task.error is not None:
        values = {"errnum": task.error[0]} | run.places.at(task.place)
        print(f"cnc-front: {text('sap_error', language_from(options.lang), **values)}", file=sys.stderr)
        return Exit.STOPPED
    return Exit.DONE


def translate_autocode(options: argparse.Namespace) -> int:
    """Disassembles a rw_SymPas job or an autocode file, writes the autocode file, or lists what the job spools."""
    from cnc_front import outputs

    target = outputs.check_autocode(options.output, [options.job]) if options.output else None
    machine = load_machine(options.machine, options.job)
    source = read_job(options.job, options.language)
    program, diagnostics = compile_autocode(source, machine, _compile_options(options))
    if program is None:
        raise CompileError(diagnostics)
    _say(diagnostics, options)
    if options.json and not options.autocode and target is None:
        return _list_spooled(options, machine, Task(program.task or 0, source, program, diagnostics))
    if target is not None:
        target.write_bytes(program.encode())
    else:
        sys.stdout.writelines(line + "\n" for line in program.listing())
    return Exit.DONE
