"""What each command does: load, check, run, print. One function a command."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cnc_front import VERSION
from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import CompileError, Exit, UsageError
from cnc_front.german import in_language
from cnc_front.history_command import keep_run
from cnc_front.jobs import (
    CompiledJob,
    CompileOptions,
    JobSource,
    MachineFile,
    check_held,
    compile_job,
    diagnose,
    language_at,
    load_machine,
    load_stimulus,
    read_job,
)
from cnc_front.messages import language_from, text

if TYPE_CHECKING:
    from cnc_front._native import motion_kernel as native_kernel
    from cnc_front.geometry.arguments import ReferenceOptions
    from cnc_front.geometry.checks import Checks
    from cnc_front.run import RunOptions, RunResult
    from cnc_front.streaming import FileSource, StreamedJob
    from cnc_front.verdict import Verdict


def _compile_options(options: argparse.Namespace) -> CompileOptions:
    part = (getattr(options, "start", None), getattr(options, "stop", None))
    skip, strict = tuple(options.skip), getattr(options, "strict", False)
    return CompileOptions(
        options.profile, options.optional_stop, skip, options.language, *part, strict, language_from(options.lang)
    )


def _print_diagnostics(diagnostics: tuple[Diagnostic, ...], options: argparse.Namespace) -> None:
    for diagnostic in diagnostics:
        if not (options.quiet and diagnostic.is_warning):
            print(in_language(diagnostic, language_from(options.lang)), file=sys.stderr)


#: Warnings of one id that `run` and `translate` print in full; `check` names every one.
PER_ID = 5


def _print_warnings(diagnostics: tuple[Diagnostic, ...], options: argparse.Namespace) -> None:
    """The first warnings of each id, then how many more there are: a flood hides what matters. Every error."""
    counts = Counter(found.id for found in diagnostics)
    shown: Counter[str] = Counter()
    for found in diagnostics:
        shown[found.id] += found.is_warning
        if options.quiet and found.is_warning:
            continue
        if shown[found.id] <= PER_ID or options.verbose:
            print(in_language(found, language_from(options.lang)), file=sys.stderr)
        elif shown[found.id] == counts[found.id]:
            more = text("more_warnings", language_from(options.lang), which=found.id, count=counts[found.id] - PER_ID)
            print(f"{found.file}: {more}", file=sys.stderr)


def _print_start(facts: dict[str, Any], machine: MachineFile, options: argparse.Namespace) -> None:
    """What the operator must know where the program begins in the middle."""
    if facts["start"] is not None and not options.quiet:
        from cnc_front.search import start_text

        units = dict(zip(machine.machine.axis_names, machine.machine.units, strict=True))
        print(start_text(facts["start"], units, language_from(options.lang)), file=sys.stderr)


def _print_basis(run_object: dict[str, Any], options: argparse.Namespace) -> None:
    """With --verbose: what exactly was run, and how long that took."""
    if options.verbose:
        job, machine = run_object["job"], run_object["machine"]
        print(f"cnc-front {VERSION}; {run_object['samples']} x {run_object['sample_time_us']:g} us in "
              f"{run_object['wall_time_s']:.2f} s", file=sys.stderr)  # fmt: skip
        print(f"  {job['path']} sha256 {job['sha256']}", file=sys.stderr)
        print(f"  {machine['path'] or machine['name']} sha256 {machine['sha256']}", file=sys.stderr)


def run(options: argparse.Namespace) -> int:
    """`cnc-front run`."""
    from cnc_front.interrupt import interruptible

    with interruptible() as interrupted:
        return _run(options, interrupted)


def _run(options: argparse.Namespace, interrupted: Callable[[], bool]) -> int:
    if _is_autocode(options.job, options.language):
        from cnc_front.sap_command import run_sap

        return run_sap(options, interrupted)
    if options.task:
        raise UsageError("--task is for rw_SymPas jobs")
    from cnc_front import outputs
    from cnc_front.geometry.arguments import reference_options
    from cnc_front.progress import Progress
    from cnc_front.run import RunOptions
    from cnc_front.schedule import parse_schedule
    from cnc_front.sweep import parse_sweep

    language = language_from(options.lang)
    progress = Progress(language, quiet=options.quiet)
    schedule, optimal = parse_schedule(options.override), options.time_optimal
    run_options = RunOptions(schedule, options.max_time, interrupted, progress, time_optimal=optimal)
    run_options = replace(run_options, sweep=parse_sweep(options.override_sweep), samples=options.samples)
    inputs = [options.job, options.machine or "", options.stimulus or "", options.setup or "", options.reference or ""]
    about_reference = reference_options(options)
    check_extras(options)
    record = outputs.check_recording(options.record, inputs) if options.record else None
    report = outputs.check_report(options.report, inputs) if options.report else None
    loaded = _Loaded()
    try:
        result, verdict, run_object = _executed(loaded, options, run_options, about_reference, record, report)
    except CompileError as error:
        from cnc_front.verdict import failed_object

        progress.end()
        _print_warnings(error.diagnostics, options)
        failed = failed_object(options.job, loaded.source, options.machine, loaded.machine, error.diagnostics)
        keep_run(failed, options, Exit.BAD_INPUT)
        if options.json:
            print(json.dumps(failed, allow_nan=False))
        return Exit.BAD_INPUT
    progress.end()
    _print_basis(run_object, options)
    keep_run(run_object, options, verdict.exit)  # before printing: who reads stdout may stop reading
    if options.json:
        print(json.dumps(run_object, allow_nan=False))
    else:
        from cnc_front.text_result import result_text

        colors = sys.stdout.isatty() and not (options.no_color or os.environ.get("NO_COLOR"))
        print(result_text(result, verdict, run_object, language, colors=colors))
    return verdict.exit


def _executed(
    loaded: _Loaded,
    options: argparse.Namespace,
    run_options: RunOptions,
    about_reference: ReferenceOptions,
    record: Path | None,
    report: Path | None,
) -> tuple[RunResult, Verdict, dict[str, Any]]:
    """The run with its verdict and object: streamed, unless the path is needed as a whole."""
    from cnc_front.deliver import run_and_write

    checked = options.reference is not None or _setup_path(options) is not None
    whole = bool(report or options.time_optimal or run_options.sweep or checked)
    job = loaded.job(options, whole=whole)
    wanted = replace(run_options, stimulus=load_stimulus(options.stimulus, options.job, job.machine))
    checks = _checks(job, options, about_reference) if isinstance(job, CompiledJob) else None
    wanted = replace(wanted, scan=scanned(options, job.machine.machine))
    _print_warnings(job.warnings, options)
    _print_start(job.facts, job.machine, options)
    return run_and_write(job, wanted, options.tolerance, record, report, language_from(options.lang), checks)


def check_extras(options: argparse.Namespace) -> None:
    """What an option needs beside a plain installation is there."""
    if options.time_optimal:
        from cnc_front.time_optimal import check_available

        check_available()
    if options.samples:
        from cnc_front.samples import check_available as check_samples

        if not options.report:
            raise UsageError("--samples needs --report DIR: samples.parquet is a file of the report")
        check_samples()


def _checks(job: CompiledJob, options: argparse.Namespace, reference: ReferenceOptions) -> Checks | None:
    """The checks against drawing and setup; nothing is loaded for a run without any."""
    path = _setup_path(options)
    if path is None and options.reference is None:
        return None
    from cnc_front.geometry.checks import checks_of_job

    return checks_of_job(job, path, options.reference, reference, options.tolerance)


def scanned(options: argparse.Namespace, machine: native_kernel.Machine) -> tuple[str, ...]:
    """Resources to record, by name."""
    if options.scan is None:
        return ()
    from cnc_front.scan import parse_scan

    return parse_scan(options.scan, machine, recorded=options.record is not None)


def _setup_path(options: argparse.Namespace) -> str | None:
    """The setup that was given, else the one beside the job."""
    if options.setup is not None:
        return str(options.setup)
    beside = Path(options.job).with_suffix(".setup.toml")
    return str(beside) if beside.is_file() else None


def _is_autocode(path: str, language: str | None) -> bool:
    """True for rw_SymPas jobs and autocode files; a file that cannot be read is reported where it is compiled."""
    return language_at(path, language) not in (None, "din66025")


class _Loaded:
    """What is known of a run even if it does not compile."""

    source: JobSource | FileSource | None = None
    machine: MachineFile | None = None

    def job(self, options: argparse.Namespace, *, whole: bool) -> CompiledJob | StreamedJob:
        """The job, ready to run; raises CompileError."""
        from cnc_front.streaming import FileSource, begin, streams

        chosen = _compile_options(options)
        if not whole and streams(options.job, options.language):
            self.source = FileSource(options.job)
            self.machine = load_machine(options.machine, options.job)
            return begin(self.source, self.machine, chosen, recorded=options.record is not None)
        source = self.source = read_job(options.job, options.language)
        self.machine = load_machine(options.machine, options.job)
        job = compile_job(source, self.machine, chosen)
        check_held(options.job, job.facts["motion_blocks"])
        return job


def check(options: argparse.Namespace) -> int:
    """`cnc-front check`: every diagnostic of every job on stderr, one line a job on stdout."""
    language = language_from(options.lang)
    worst = Exit.DONE
    for path in options.jobs:
        try:
            diagnostics = _findings(path, options)
        except CompileError as error:
            diagnostics = error.diagnostics
        _print_diagnostics(diagnostics, options)
        errors = sum(not d.is_warning for d in diagnostics)
        counts = {"path": path, "errors": errors, "warnings": len(diagnostics) - errors}
        print(text("check_bad" if errors else "check_ok", language, **counts))
        worst = Exit.BAD_INPUT if errors else worst
    return worst


def _findings(path: str, options: argparse.Namespace) -> tuple[Diagnostic, ...]:
    """All diagnostics of a job; raises CompileError for what cannot be read."""
    from cnc_front import streaming

    machine, chosen = load_machine(options.machine, path), _compile_options(options)
    if streaming.streams(path, options.language):
        return streaming.check(path, machine, chosen)
    return diagnose(read_job(path, options.language), machine, chosen, check_only=True)[1]


def translate(options: argparse.Namespace) -> int:
    """`cnc-front translate`."""
    if _is_autocode(options.job, options.language):
        from cnc_front.sap_command import translate_autocode

        return translate_autocode(options)
    if options.autocode or options.output:
        raise UsageError("--autocode and --output are for rw_SymPas jobs and autocode files")
    machine, chosen = load_machine(options.machine, options.job), _compile_options(options)
    warnings, facts, pieces = _listing(options, machine, chosen)
    _print_warnings(warnings, options)
    _print_start(facts, machine, options)
    sys.stdout.writelines(pieces)
    return Exit.DONE


def _listing(
    options: argparse.Namespace, machine: MachineFile, chosen: CompileOptions
) -> tuple[tuple[Diagnostic, ...], dict[str, Any], Iterable[str]]:
    """Warnings, facts and listing of a sound program: nothing is printed of another. Beside a program that jumps the
    lines of the sheet are not in their order, so that one is made of the whole."""
    from cnc_front import streaming

    if streaming.streams(options.job, options.language):
        source = streaming.FileSource(options.job)
        warnings, facts = streaming.sound(source, machine, chosen)
        if options.json or not facts["looks_back"]:
            return warnings, facts, streaming.listing(source, machine, chosen, json=options.json)
    job = compile_job(read_job(options.job, options.language), machine, chosen)
    return job.warnings, job.facts, job.program.listing(job.source.data, options.json)


def report(options: argparse.Namespace) -> int:
    """`cnc-front report`: from a recording, without running again."""
    from cnc_front import outputs
    from cnc_front.deliver import report_from_recording
    from cnc_front.geometry.arguments import reference_options

    about_reference = reference_options(options)
    folder = outputs.check_report(options.folder, [options.recording, options.setup or "", options.reference or ""])
    if options.samples:
        from cnc_front.samples import check_available

        check_available()
    setup, reference = None, None
    if options.setup is not None or options.reference is not None:
        from cnc_front.geometry.checks import loaded

        setup, reference = loaded(options.setup, options.reference, about_reference)
    report_from_recording(options.recording, folder, language_from(options.lang), setup, reference)
    if options.samples:
        from cnc_front.samples import samples_of_recording

        samples_of_recording(options.recording, folder)
    return Exit.DONE


def history(options: argparse.Namespace) -> int:
    """`cnc-front history`."""
    from cnc_front.history_command import history

    return history(options)


def machine(options: argparse.Namespace) -> int:
    """`cnc-front machine check|show`."""
    loaded = load_machine(options.file)
    if options.action == "show":
        sys.stdout.write(loaded.machine.show())
    else:
        axes = ", ".join(loaded.machine.axis_names)
        print(f"{loaded.path or 'built-in machine'}: valid; {loaded.machine.name}, axes {axes}")
    return Exit.DONE


def tui(options: argparse.Namespace) -> int:
    """`cnc-front tui`: the package tui stands above this one, so it is found by name."""
    import importlib

    start: Any = importlib.import_module("tui").start
    return int(start(options, language_from(options.lang)))


def batch(options: argparse.Namespace) -> int:
    """`cnc-front batch`."""
    from cnc_front.batch.command import batch

    return batch(options)


def tune(options: argparse.Namespace) -> int:
    """`cnc-front tune`."""
    from cnc_front.tune import tune

    return tune(options)


def compare(options: argparse.Namespace) -> int:
    """`cnc-front compare`."""
    from cnc_front.batch.compare import compare
    from cnc_front.compare import compare_runs, is_run

    if is_run(options.before) or is_run(options.after):
        return compare_runs(options)
    if options.out:
        raise UsageError("--out is for the comparison of two runs")

    return compare(options)


COMMANDS: dict[str, Callable[[argparse.Namespace], int]] = {
    "run": run,
    "check": check,
    "translate": translate,
    "report": report,
    "history": history,
    "machine": machine,
    "tui": tui,
    "batch": batch,
    "compare": compare,
    "tune": tune,
}
