"""What `run` and `translate` do with rw_SymPas jobs and autocode files."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

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

#: Options of `run` that are for part programs: name and option.
FOREIGN = {
    "start": "from",
    "stop": "to",
    "time_optimal": "time-optimal",
    "setup": "setup",
    "reference": "reference",
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
    from cnc_front import outputs
    from cnc_front.schedule import parse_schedule

    _refuse_foreign(options)
    schedule = parse_schedule(options.override)
    inputs = [options.job, options.machine or "", options.stimulus or "", *(path for _, path in _asked(options))]
    record = outputs.check_recording(options.record, inputs) if options.record else None
    report = outputs.check_report(options.report, inputs) if options.report else None
    machine = None
    try:
        machine = load_machine(options.machine, options.job)  # known to the result even if a job does not compile
        tasks = load_tasks(options, machine)
        stimulus = load_stimulus(options.stimulus, options.job, machine)
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
    return _run_tasks(
        options, machine, tasks, SapOptions(options.max_time, interrupted, stimulus, schedule), record, report
    )


def _refuse_foreign(options: argparse.Namespace) -> None:
    for name, option in FOREIGN.items():
        if getattr(options, name, None):
            raise UsageError(f"--{option} is for part programs, not for rw_SymPas jobs")


def _run_tasks(
    options: argparse.Namespace,
    machine: MachineFile,
    tasks: list[Task],
    sap_options: SapOptions,
    record: Path | None,
    report: Path | None,
) -> int:
    from cnc_front.progress import Progress
    from cnc_front.sap_deliver import run_and_write
    from cnc_front.sap_verdict import result_text

    language = language_from(options.lang)
    progress = Progress(language, quiet=options.quiet)
    sap_options = replace(sap_options, progress=progress.at)
    result, verdict, run = run_and_write(machine, tasks, sap_options, options.tolerance, record, report, language)
    progress.end()
    if report is not None and run["files"]["report"] is None and not options.quiet:
        print(f"cnc-front: {text('sap_no_report', language)}", file=sys.stderr)
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
    for row in rows_as_json(run.listing, machine.machine.axis_names):
        print(json.dumps(row, allow_nan=False))
    if task.error is not None:
        values = {"task": task.number, "errnum": task.error[0], "line": task.error[1]}
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
