"""Running rw_SymPas jobs and writing what was asked for: recording, report, the object of `run --json`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cnc_front import VERSION
from cnc_front._native import motion_kernel as native_kernel
from cnc_front.deliver import Plotting, tolerance_from
from cnc_front.jobs import JobSource, MachineFile, shown
from cnc_front.recording import Recorded, RecordingSink
from cnc_front.sap_measure import Measured, Measuring, line_offsets, measured_run, place_of
from cnc_front.sap_run import SapOptions, SapRun, Task
from cnc_front.sap_verdict import judge, run_object
from cnc_front.spooled import Paths
from cnc_front.verdict import Verdict, measured_keys

if TYPE_CHECKING:
    from cnc_front.report import ReportInput


def run_and_write(
    machine: MachineFile,
    tasks: list[Task],
    options: SapOptions,
    tolerance_mm: float | None,
    record: Path | None,
    report: Path | None,
    language: str,
) -> tuple[Measured, Verdict, dict[str, Any]]:
    """The run, its verdict, and the object of design 3.2; files are written before it returns. There is no report of a
    job that spools nothing (`files.report` is null then)."""
    tolerance = tolerance_mm if tolerance_mm is not None else machine.machine.tolerance_mm
    source = joined(tasks)
    sinks: list[RecordingSink] = []

    def sink(paths: Paths) -> RecordingSink:
        assert record is not None
        metadata = _metadata(tasks, options, tolerance, tolerance_from(tolerance_mm))
        sinks.append(RecordingSink(record, _Spooled(source, machine, paths), metadata))
        return sinks[0]

    plotting = Plotting(tolerance) if report else None
    result = measured_run(lambda: SapRun(machine, tasks, options), sink if record else None, plotting)
    verdict = judge(result, tolerance)
    plotted = report if result.summary is not None else None
    files = {"recording": shown(record) if record else None, "report": shown(plotted) if plotted else None}
    run = run_object(result, verdict, files)
    run["verdict"]["tolerance_from"] = tolerance_from(tolerance_mm)
    for recording in sinks:
        recording.finish(run)
    if plotted is not None and plotting is not None and result.summary is not None:
        from cnc_front.report import write_report

        events = [_event(entry) for entry in result.run.log]
        write_report(plotting.report_input(run, result.summary, source, machine.machine, events), plotted, language)
    return result, verdict, run


def joined(tasks: Sequence[Task]) -> JobSource:
    """The texts of all tasks behind each other, as the lines of `line_offsets` count; of autocode files none."""
    first = tasks[0].source
    if len(tasks) == 1:
        return first
    text = "\n".join("\n".join(task.source.text().splitlines() or [""]) for task in tasks)
    return JobSource(first.path, text.encode(), first.language)


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

    def sequence(self) -> dict[str, Any]:
        """Columns and stretches of all lanes."""
        return _packed(self.paths)


def _measure(recorded: Recorded, measuring: Measuring, plotting: Plotting) -> int:
    samples = 0
    for columns in recorded.columns():
        names = ("dp", "load", "rp", "factor", "v_plan", "entry", "flags")
        given = (columns["first_sample"], *(columns[name] for name in names))
        deviation = measuring.feed(lambda tracker: tracker.feed_columns(*given))  # noqa: B023  called at once
        plotting.add(deviation)
        samples = columns["first_sample"] + len(deviation)
    return samples


def _packed(paths: Paths) -> dict[str, Any]:
    """Columns and stretches of all lanes under one roof, lane number first."""
    packed: dict[str, Any] = {}
    for n, lane in enumerate(paths.lanes):
        columns = lane.sequence | {"stretches": np.array(lane.stretches, np.uint64).reshape(-1, 4)}
        packed |= {f"{n}.{name}": column for name, column in columns.items()}
    return packed


def _unpacked(packed: dict[str, Any]) -> list[tuple[dict[str, Any], list[tuple[int, int, int, bool]]]]:
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
        "line_offsets": json.dumps(list(line_offsets(tasks).items())),
        "version": VERSION,
    }


def measured_again(recorded: Recorded) -> ReportInput:
    """What a report of a recorded run is made of, measured from the recorded samples."""
    from cnc_front.deliver import run_of

    metadata = recorded.metadata
    machine = native_kernel.Machine.parse(recorded.machine_text.encode(), metadata["machine_path"])
    source = JobSource(metadata["job_path"], recorded.job, metadata["language"])
    schedule = [(t, f) for t, f in json.loads(metadata["schedule"])]
    lanes = _unpacked(recorded.sequence)
    if not lanes:
        raise ValueError("the job spooled nothing, so there is no contour to report on")
    measuring = Measuring.of(lanes, {"sample_time_s": machine.sample_time_us * 1e-6, "schedule": schedule})
    plotting = Plotting(float(metadata["tolerance_mm"]))
    plotting.begin(measuring.paths[0], measuring.trackers[0])
    samples = _measure(recorded, measuring, plotting)
    summary = measuring.finish()
    run = run_of(recorded, source, machine, summary, samples) | measured_keys(summary, machine, schedule)
    offsets = {int(task): int(offset) for task, offset in json.loads(metadata["line_offsets"])}
    for deviation in run["deviation"].values():
        worst = deviation["worst"]
        worst["task"], worst["line"] = place_of(worst["line"], offsets)
    report = plotting.report_input(run, summary, source, machine, recorded.events)
    report.note = f"{recorded.path}: {recorded.damage}" if recorded.damage else ""
    return report
