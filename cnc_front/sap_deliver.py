"""Running rw_SymPas jobs and writing what was asked for: recording, report, the object of `run --json`."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cnc_front import VERSION
from cnc_front._native import motion_kernel as native_kernel
from cnc_front.deliver import Both, Plotting, checked, checks_recorded, measure_recorded, run_of, samples_file
from cnc_front.deliver import tolerance_from as origin_of
from cnc_front.jobs import JobSource, MachineFile, shown
from cnc_front.messages import text
from cnc_front.recording import Recorded, RecordingSink
from cnc_front.run import Sink
from cnc_front.sap_measure import Measured, Measuring, measured_run
from cnc_front.sap_places import Places, joined
from cnc_front.sap_run import SapOptions, SapRun, Task
from cnc_front.sap_verdict import evidence_of, judge, place_deviations, run_object, run_status
from cnc_front.spooled import Paths
from cnc_front.sweep import Swept, override_sweep
from cnc_front.verdict import Verdict, measured_keys, with_findings

if TYPE_CHECKING:
    from cnc_front.geometry.checks import Checks
    from cnc_front.geometry.reference import Reference
    from cnc_front.geometry.setup import Setup
    from cnc_front.report import ReportInput


@dataclass(frozen=True, slots=True)
class Wanted:
    """What a run is to leave, and what it is held against."""

    tolerance_mm: float | None = None
    record: Path | None = None
    report: Path | None = None
    samples: bool = False
    sweep: tuple[float, ...] = ()
    checks: Checks | None = None


def run_and_write(
    machine: MachineFile, tasks: list[Task], options: SapOptions, wanted: Wanted, language: str
) -> tuple[Measured, Verdict, dict[str, Any]]:
    """The run, its verdict, and the object of design 3.2; files are written before it returns."""
    limit, checks, report = wanted.tolerance_mm, wanted.checks, wanted.report
    tolerance = limit if limit is not None else machine.machine.tolerance_mm
    source, recordings = joined(tasks), list[RecordingSink]()
    table = samples_file(machine.machine, report) if wanted.samples else None

    def sink(paths: Paths) -> Sink:
        if wanted.record is not None:
            metadata = _metadata(tasks, options, tolerance, origin_of(limit)) | (checks.metadata() if checks else {})
            files = checks.attachments() if checks else []
            job = _Spooled(source, machine, paths)
            recordings.append(RecordingSink(wanted.record, job, metadata, files, options.scan))
        return Both(*recordings, checks, table)

    plotting = Plotting(tolerance) if report else None
    has_sink = wanted.record is not None or checks is not None or table is not None
    result = measured_run(lambda: SapRun(machine, tasks, options), sink if has_sink else None, plotting)
    if table is not None:
        table.close()
    found, more = checked(checks, tolerance)
    named = evidence_of(result.measuring, result.places, machine.machine, tolerance)
    verdict = with_findings(judge(result, tolerance, more), named["findings"])
    files = {"recording": shown(wanted.record) if wanted.record else None, "report": shown(report) if report else None}
    run = run_object(result, verdict, files) | named | found
    run["verdict"]["tolerance_from"] = origin_of(limit)
    if wanted.sweep:
        run["override_sweep"] = override_sweep(
            wanted.sweep, lambda factor: _swept(machine, tasks, options, tolerance, factor)
        )
    for recording in recordings:
        recording.finish(run)
    if report is not None and plotting is not None:
        from cnc_front.report import write_report

        events, figures = [_event(entry) for entry in result.run.log], run
        if not result.has_contour:  # the page shows figures of nothing, and says so
            figures = run | measured_keys(result.summary, machine.machine, options.schedule)
        made = plotting.report_input(figures, result.summary, source, machine.machine, events)
        made.job_lines, made.checks = result.places.labelled(source.text()), checks
        made.note = "" if result.has_contour else nothing_spooled(language)
        write_report(made, report, language)
    return result, verdict, run


def nothing_spooled(language: str) -> str:
    """What a report says of a job without contour."""
    return f"{text('path', language)}: {text('sap_no_contour', language)}"


def _swept(machine: MachineFile, tasks: list[Task], options: SapOptions, tolerance_mm: float, factor: float) -> Swept:
    """The job at one override factor."""
    quiet = replace(options, schedule=((0.0, factor),), progress=lambda seconds: None, scan=())
    result = measured_run(lambda: SapRun(machine, [replace(task) for task in tasks], quiet))
    word = judge(result, tolerance_mm).word
    axes = evidence_of(result.measuring, result.places, machine.machine, tolerance_mm)["axes"]
    return Swept(word, run_status(result.run), result.run.machine_time_s, result.summary, axes)


def _event(entry: Any) -> dict[str, Any]:
    names = ("t_s", "kind", "axis", "name", "on", "line", "value")
    return {name: getattr(entry, name) for name in names} | {"text": ""}


@dataclass(frozen=True, slots=True)
class _Spooled:
    """A job with what it spooled, as a recording wants it."""

    source: JobSource
    machine: MachineFile
    paths: Paths

    @property
    def program(self) -> _Spooled:
        """Who knows the motion commands."""
        return self

    def pieces(self, rows: int) -> Iterator[dict[str, Any]]:
        """Columns and stretches of all lanes, as one piece."""
        return iter([_packed(self.paths)])


def _packed(paths: Paths) -> dict[str, Any]:
    """Columns and stretches of all lanes under one roof, lane number first."""
    packed: dict[str, Any] = {}
    for n, lane in enumerate(paths.lanes):
        columns = lane.sequence | {"stretches": np.array(lane.stretches, np.uint64).reshape(-1, 4)}
        packed |= {f"{n}.{name}": column for name, column in columns.items()}
    return packed


def lanes_of(packed: dict[str, Any]) -> list[tuple[dict[str, Any], list[tuple[int, int, int, bool]]]]:
    lanes = []
    for n in range(len({key.partition(".")[0] for key in packed})):
        columns = {key.partition(".")[2]: column for key, column in packed.items() if key.partition(".")[0] == str(n)}
        rows = columns.pop("stretches").tolist()
        lanes.append((columns, [(begin, end, command, bool(settles)) for begin, end, command, settles in rows]))
    return lanes


def _metadata(tasks: Sequence[Task], options: SapOptions, tolerance_mm: float, origin: str) -> dict[str, str]:
    """The arguments of a run that a report needs."""
    optional = {"stimulus": options.stimulus.text} if options.stimulus else {}
    return optional | {
        "language": "sympas",
        "job_path": shown(tasks[0].source.path),
        "machine_path": "",
        "tolerance_mm": repr(tolerance_mm),
        "tolerance_from": origin,
        "schedule": json.dumps([list(point) for point in options.schedule]),
        "places": Places.of(tasks).as_json(),
        "version": VERSION,
    }


def measured_again(recorded: Recorded, setup: Setup | None, reference: Reference | None, language: str) -> ReportInput:
    """What a report of a recorded run is made of, measured from the recorded samples."""
    metadata = recorded.metadata
    machine = native_kernel.Machine.parse(recorded.machine_text.encode(), metadata["machine_path"])
    source = JobSource(metadata["job_path"], recorded.job, metadata["language"])
    schedule = [(t, f) for t, f in json.loads(metadata["schedule"])]
    options = {"sample_time_s": machine.sample_time_us * 1e-6, "schedule": schedule}
    measuring = Measuring.of(lanes_of(recorded.sequence), options)
    plotting = Plotting(float(metadata["tolerance_mm"]))
    plotting.begin(measuring.paths[0], measuring.trackers[0])
    checks = checks_recorded(recorded, machine, setup, reference)

    def feed(*columns: Any) -> NDArray[np.float32]:
        return measuring.feed(lambda tracker: tracker.feed_columns(*columns))

    samples = measure_recorded(recorded, feed, plotting, checks)
    summary, places = measuring.finish(), Places.parse(metadata["places"])
    run = run_of(recorded, source, machine, summary, samples)
    run |= checked(checks, 0.0)[0] | evidence_of(measuring, places, machine, plotting.tolerance_mm)
    place_deviations(run, places)
    report = plotting.report_input(run, summary, source, machine, recorded.events)
    report.job_lines, report.checks = places.labelled(source.text()), checks
    nothing = "" if len(plotting.path.blocks()["line"]) else nothing_spooled(language)
    report.note = f"{recorded.path}: {recorded.damage}" if recorded.damage else nothing
    return report
