"""Running a compiled job and writing what was asked for: recording, report, the object of `run --json`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cnc_front import VERSION
from cnc_front._native import motion_kernel as native_kernel
from cnc_front._native import toolpaths as native_paths
from cnc_front.evidence import evidence_keys, motor_commands
from cnc_front.jobs import CompiledJob, JobSource, shown
from cnc_front.recording import RESULT, Recorded, RecordingSink, content_of, open_recording
from cnc_front.run import RunOptions, RunResult, Sink, dry_run
from cnc_front.streaming import StreamedJob
from cnc_front.verdict import (
    EMPTY,
    SCHEMA,
    Reason,
    Verdict,
    judge,
    measured_keys,
    partial_object,
    run_object,
    with_findings,
)

if TYPE_CHECKING:
    from cnc_front.geometry.checks import Checks
    from cnc_front.geometry.reference import Reference
    from cnc_front.geometry.setup import Setup
    from cnc_front.report import ReportInput
    from cnc_front.samples import SamplesFile
    from cnc_front.time_optimal import TimeOptimal


class Both:
    """A sink: hands what a run tells to several sinks."""

    def __init__(self, *sinks: Sink | None) -> None:
        self._sinks = [sink for sink in sinks if sink is not None]

    def write(self, chunk: Any, deviation_mm: Any, happened: Any) -> None:
        for sink in self._sinks:
            sink.write(chunk, deviation_mm, happened)


def run_and_write(
    job: CompiledJob | StreamedJob,
    options: RunOptions,
    tolerance_mm: float | None,
    record: Path | None,
    report: Path | None,
    language: str,
    checks: Checks | None = None,
) -> tuple[RunResult, Verdict, dict[str, Any]]:
    """The run, its verdict, and the object of design 3.2; files are written before it returns.

    A report, `checks`, a sweep and the time-optimal bound need a CompiledJob. Raises OSError; CompileError where a
    machine is not ready, or the file of a StreamedJob changed.
    """
    tolerance = tolerance_mm if tolerance_mm is not None else job.machine.machine.tolerance_mm
    metadata = run_metadata(job, options, tolerance, tolerance_from(tolerance_mm))
    metadata |= checks.metadata() if checks else {}
    more = checks.attachments() if checks else []
    sink = RecordingSink(record, job, metadata, more, options.scan, job.facts["modal"]) if record else None
    plotting = Plotting(tolerance) if report else None
    result = _measured(job, options, checks, sink, plotting, report)
    files = {"recording": shown(record) if record else None, "report": shown(report) if report else None}
    verdict, run = judged(result, tolerance_mm, files, checks)
    optimal = None
    if isinstance(job, CompiledJob):
        if options.sweep:
            from cnc_front.sweep import job_at, override_sweep

            run["override_sweep"] = override_sweep(options.sweep, job_at(job, options, tolerance))
        if options.time_optimal and result.path is not None:
            sequence = job.program.sequence()
            optimal = _optimal(sequence, result.path, result.tracker, job.machine.machine, run["samples"])
            run["time_optimal_s"] = optimal.seconds
    if sink is not None:
        sink.finish(run)
    if report is not None and plotting is not None and isinstance(job, CompiledJob):
        from cnc_front.report import write_report

        machine, events = job.machine.machine, events_of(result)
        made = plotting.report_input(run, result.summary, job.source, machine, events)
        made.time_optimal, made.checks = optimal, checks
        write_report(made, report, language)
    return result, verdict, run


def _measured(
    job: CompiledJob | StreamedJob,
    options: RunOptions,
    checks: Checks | None,
    sink: RecordingSink | None,
    plotting: Plotting | None,
    report: Path | None,
) -> RunResult:
    """The run; what comes sample by sample is written, and the motion commands."""
    table = samples_file(job.machine.machine, report) if options.samples else None
    try:
        result = dry_run(job, options, Both(sink, checks, table), plotting)
        if sink is not None:
            sink.add_commands()
    except ValueError:
        if isinstance(job, StreamedJob):
            job.source.check_unchanged()  # half a program may be no path
        raise
    if isinstance(job, StreamedJob):
        job.settle()
    if table is not None:
        table.close()
    return result


def samples_file(machine: native_kernel.Machine, report: Path | None) -> SamplesFile | None:
    """The file of all samples beside a report."""
    if report is None:
        return None
    from cnc_front.samples import SamplesFile

    return SamplesFile(report, machine.axis_names, machine.sample_time_us * 1e-6)


def judged(
    result: RunResult, tolerance_mm: float | None, files: dict[str, str | None], checks: Checks | None = None
) -> tuple[Verdict, dict[str, Any]]:
    """The verdict of a run that is over, and the object of design 3.2; `tolerance_mm` None: that of the machine."""
    machine = result.job.machine.machine
    tolerance = tolerance_mm if tolerance_mm is not None else machine.tolerance_mm
    found, more = checked(checks, tolerance)
    named = evidence_keys(result.tracker, result.summary, machine, tolerance)
    verdict = with_findings(judge(result, tolerance, more), named["findings"])
    motors = motor_commands(result.execution.mcu, machine.axis_names)
    run = run_object(result, verdict, files) | named | found | {"motor_command": motors}
    run["verdict"]["tolerance_from"] = tolerance_from(tolerance_mm)
    return verdict, run


def checked(checks: Checks | None, tolerance_mm: float) -> tuple[dict[str, Any], tuple[Reason, ...]]:
    """What drawing and setup show: keys of the object of a run, reasons for its verdict."""
    if checks is None:
        return {}, ()
    from cnc_front.geometry.judging import geometry_reasons

    found = checks.finish()
    return found, geometry_reasons(found, tolerance_mm)


def report_from_recording(
    recording: str, folder: Path, language: str, setup: Setup | None = None, reference: Reference | None = None
) -> None:
    """Builds the report of a recorded run; the figures are measured again from its columns.

    Raises CompileError for what is no recording of ours, OSError where the report cannot be written.
    """
    from cnc_front.report import write_report

    write_report(measured_report(recording, setup, reference, language), folder, language)


def measured_report(
    recording: str, setup: Setup | None = None, reference: Reference | None = None, language: str = "en"
) -> ReportInput:
    """All that the report of a recorded run shows; raises CompileError for what is no recording of ours."""
    with content_of(recording):
        recorded = open_recording(recording)
        if recorded.metadata.get("language", "din66025") == "din66025":
            return _measured_again(recorded, setup, reference)
        from cnc_front.sap_deliver import measured_again

        return measured_again(recorded, setup, reference, language)


def _measured_again(recorded: Recorded, setup: Setup | None, reference: Reference | None) -> ReportInput:
    metadata = recorded.metadata
    machine = native_kernel.Machine.parse(recorded.machine_text.encode(), metadata["machine_path"])
    source = JobSource(metadata["job_path"], recorded.job, "din66025")
    path = native_paths.Path(recorded.sequence)
    plotting = Plotting(float(metadata["tolerance_mm"]))
    schedule = [(t, f) for t, f in json.loads(metadata["schedule"])]
    wanted = "time_optimal" in metadata
    tracker = native_paths.Tracker(
        path,
        sample_time_s=machine.sample_time_us * 1e-6,
        schedule=schedule,
        trovrst_s=machine.trovrst_s,
        passages=wanted,
    )
    plotting.begin(path, tracker)
    checks = checks_recorded(recorded, machine, setup, reference)
    samples = measure_recorded(recorded, tracker.feed_columns, plotting, checks)
    summary = tracker.finish()
    run = run_of(recorded, source, machine, summary, samples) | checked(checks, 0.0)[0]
    run |= evidence_keys(tracker, summary, machine, plotting.tolerance_mm)
    report = plotting.report_input(run, summary, source, machine, sorted(recorded.events, key=_order))
    report.checks = checks
    if wanted:
        report.time_optimal = _optimal(recorded.sequence, path, tracker, machine, samples)
        run["time_optimal_s"] = report.time_optimal.seconds
    report.note = f"{recorded.path}: {recorded.damage}" if recorded.damage else ""
    return report


def _optimal(
    sequence: dict[str, Any],
    path: native_paths.Path,
    tracker: native_paths.Tracker,
    machine: native_kernel.Machine,
    samples: int,
) -> TimeOptimal:
    from cnc_front.time_optimal import check_available, time_optimal

    check_available()
    return time_optimal(sequence, path, tracker, machine, samples)


def checks_recorded(
    recorded: Recorded, machine: native_kernel.Machine, setup: Setup | None, reference: Reference | None
) -> Checks | None:
    """The checks that a recording carries, or those given now."""
    if setup is None and reference is None and not recorded.files:
        return None
    from cnc_front.geometry.checks import recorded_checks

    return recorded_checks(machine, recorded.metadata, recorded.files, setup, reference)


def measure_recorded(
    recorded: Recorded, feed: Callable[..., NDArray[np.float32]], plotting: Plotting, checks: Checks | None
) -> int:
    """Feeds the samples of a recording to a tracker (Tracker.feed_columns); how many there are."""
    samples = 0
    for columns in recorded.columns():
        names = ("dp", "load", "rp", "factor", "v_plan", "entry", "flags")
        deviation = feed(columns["first_sample"], *(columns[name] for name in names))
        plotting.add(deviation)
        if checks is not None:
            checks.feed_recorded(columns, recorded.events)
        samples = columns["first_sample"] + len(deviation)
    if checks is not None:
        checks.feed_recorded(None, recorded.events)
    return samples


def run_of(
    recorded: Recorded, source: JobSource, machine: native_kernel.Machine, summary: dict[str, Any], samples: int
) -> dict[str, Any]:
    """The recorded result with the figures measured now; without a result (cut off) what can be said."""
    tolerance = float(recorded.metadata["tolerance_mm"])
    schedule = json.loads(recorded.metadata["schedule"])
    run = recorded.result
    if run is None:
        run = partial_object(source, machine, recorded, samples, tolerance)
    if not run.keys() >= EMPTY.keys() or run["schema"] != SCHEMA:
        raise ValueError(f"{RESULT} is no result of a run")
    run["verdict"].setdefault("tolerance_from", recorded.metadata.get("tolerance_from", "machine"))
    return run | measured_keys(summary, machine, schedule)


class Plotting:
    """What only a report needs: the polyline with its deviation, the histogram."""

    def __init__(self, tolerance_mm: float) -> None:
        from cnc_front.report.data import Histogram

        self.tolerance_mm = tolerance_mm
        self.histogram = Histogram(tolerance_mm)

    def begin(self, path: native_paths.Path, tracker: native_paths.Tracker) -> None:
        from cnc_front.report.data import PLOT_POINTS

        polyline = path.polyline(0.005, PLOT_POINTS * 3 // max(3, len(path.extents)))
        self.attach(path, tracker, polyline)
        tracker.watch(polyline["s_mm"])

    def attach(self, path: native_paths.Path, tracker: native_paths.Tracker, polyline: dict[str, Any]) -> None:
        """For a tracker that watches the vertices of `polyline` already."""
        self.path, self.tracker, self.polyline = path, tracker, polyline

    def add(self, deviation_mm: Any) -> None:
        self.histogram.add(deviation_mm)

    def report_input(
        self,
        run: dict[str, Any],
        summary: dict[str, Any],
        source: JobSource,
        machine: native_kernel.Machine,
        events: list[dict[str, Any]],
    ) -> ReportInput:
        from cnc_front.report import ReportInput
        from cnc_front.report.evidence import circle_curves
        from cnc_front.report.limits import LimitData

        watched, _ = self.tracker.watched()
        samples, buckets = self.tracker.limits_over_time()
        limits = LimitData(summary["limits"], samples, buckets, self.tracker.watched_limits())
        return ReportInput(
            run=run,
            summary=summary,
            job_lines=source.text().splitlines(),
            axes=list(machine.axis_names),
            units=list(machine.units),
            mpe=list(machine.mpe),
            sample_time_s=machine.sample_time_us * 1e-6,
            polyline=self.polyline,
            plot_deviation_mm=np.asarray(watched),
            plot_signed_mm=np.asarray(self.tracker.watched_signed()),
            blocks=self.path.blocks(),
            measured=self.tracker.blocks(),
            series=self.tracker.series(),
            histogram=self.histogram,
            circles=circle_curves(self.tracker.evidence(), run["circularity"]),
            events=events,
            limits=limits,
        )


def events_of(result: RunResult) -> list[dict[str, Any]]:
    """What happened in a run, in order."""
    execution = result.execution
    log = [
        {"t_s": e.t_s, "kind": e.kind, "axis": e.axis, "name": e.name, "on": e.on, "line": e.line, "value": e.value}
        | {"text": ""}
        for e in execution.log
    ]
    hosts = [
        {"t_s": h.t_s, "kind": "host", "axis": "", "name": h.kind, "on": True, "line": h.line, "value": 0}
        | {"text": h.text}
        for h in execution.host_events
    ]
    return sorted(log + hosts, key=_order)


def _order(event: dict[str, Any]) -> tuple[float, bool]:
    """Order of events: by time; what the program told comes last in its sample."""
    return event["t_s"], event["kind"] == "host"


def tolerance_from(tolerance_mm: float | None) -> str:
    """Where the limit comes from: `option` (--tolerance) or `machine` (file or default)."""
    return "machine" if tolerance_mm is None else "option"


def run_metadata(
    job: CompiledJob | StreamedJob, options: RunOptions, tolerance_mm: float, tolerance_from: str
) -> dict[str, str]:
    """The arguments of a run that a report needs."""
    optional = {"stimulus": options.stimulus.text} if options.stimulus else {}
    if options.time_optimal:
        optional["time_optimal"] = "1"
    return optional | {
        "job_path": shown(job.source.path),
        "machine_path": shown(job.machine.path),
        "tolerance_mm": repr(tolerance_mm),
        "tolerance_from": tolerance_from,
        "schedule": json.dumps([list(point) for point in options.schedule]),
        "version": VERSION,
    }
