"""Feeds a run, or its recording, to the checks against drawing and setup, and tells what they found."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import CompileError
from cnc_front.execution import HostEvent
from cnc_front.geometry.arguments import ReferenceOptions
from cnc_front.geometry.reference import Reference, load_reference, parse_reference
from cnc_front.geometry.setup import Setup, changing, check_job, load_setup, parse_setup, tool_number
from cnc_front.jobs import CompiledJob, MachineFile

if TYPE_CHECKING:
    from toolpaths.material import Compared, Finding, Removal
    from toolpaths.reference import ReferenceMeter

#: Bits of the flags of a sample (motion_kernel/src/trace.rs).
MOVING, RAPID = 1, 2
#: Findings that are listed, the largest ones; all are counted.
LISTED = 200
SETUP_NAME, REFERENCE_NAME, MESH_PREFIX = "setup.toml", "reference", "mesh/"


@dataclass(slots=True)
class Checks:
    """What a run is held against besides its program. `change` is the event that changes tools."""

    axes: list[str]
    sample_time_s: float
    change: str
    tolerance_mm: float
    setup: Setup | None = None
    reference: Reference | None = None
    removal: Removal | None = None
    meters: dict[str, ReferenceMeter] = field(default_factory=dict)
    compared: Compared | None = None
    figures: dict[str, Any] = field(default_factory=dict)
    _tool: int = 0
    _waiting: dict[str, Any] | None = None
    _seen: int = 0

    def __post_init__(self) -> None:
        if self.setup is not None:
            from toolpaths.material import Removal

            self.removal, self._tool = Removal(self.setup.shop), self.setup.shop.first_tool
        if self.reference is not None:
            from toolpaths.reference import Offset, ReferenceMeter

            drawing, o = self.reference.drawing, self.reference.options
            offset = Offset(o.offset, o.radius)
            for name in ("setpoint", "actual"):
                self.meters[name] = ReferenceMeter(drawing, offset, o.capture_mm, covers=name == "actual")

    # ---- samples

    def write(self, chunk: Any, deviation_mm: Any, happened: Sequence[Any]) -> None:
        """A chunk of a run (cnc_front.run.Sink)."""
        changes = [(h.t_s, h.text) for h in happened if isinstance(h, HostEvent) and h.kind == self.change]
        if len(chunk):
            self.feed(chunk.first_sample, _columns_of(chunk), changes)
        else:
            self._change_tools(0, 0, changes)

    def feed(
        self,
        first_sample: int,
        samples: dict[str, NDArray[Any]],
        changes: Sequence[tuple[float, str]],
    ) -> None:
        """Samples by column, and the tool changes among them (seconds, number)."""
        dp, load, lines, flags = (samples[name] for name in ("dp", "load", "line", "flags"))
        columns = [self.axes.index(name) for name in "XYZ" if name in self.axes]
        at = {"setpoint": _in_space(dp, columns), "actual": _in_space(load, columns)}
        rapid = (flags & RAPID) != 0
        if self.meters:
            # direct moves of rw_SymPas jobs are no entries of a spooler, and no contour
            cutting = ((flags & MOVING) != 0) & ~rapid & (samples["entry"] > 0)
            for name, meter in self.meters.items():
                meter.feed(at[name], cutting, lines, samples["entry"], first_sample)
        if self.removal is not None and self.setup is not None:
            tools = self._change_tools(first_sample, len(lines), changes)
            points = at[self.setup.follow] - self.setup.zero
            self.removal.feed(points, lines, rapid, tools, first_sample)

    def feed_recorded(self, columns: dict[str, Any] | None, events: list[dict[str, Any]]) -> None:
        """Columns of a recording, None behind the last. The events of a chunk come after it, so it waits for them."""
        waiting, self._waiting = self._waiting, columns
        new, self._seen = events[self._seen :], len(events)
        changes = [(e["t_s"], e["text"]) for e in new if e["kind"] == "host" and e["name"] == self.change]
        if waiting is None:
            self._change_tools(0, 0, changes)
            return
        self.feed(waiting["first_sample"], waiting, changes)

    def _change_tools(self, first: int, count: int, changes: Sequence[tuple[float, str]]) -> NDArray[np.int64]:
        """The tool in the spindle in each of the next samples."""
        tools = np.full(count, self._tool, dtype=np.int64)
        for t_s, text in changes:
            self._tool = tool_number(text)
            tools[max(round(t_s / self.sample_time_s) - first, 0) :] = self._tool
        return tools

    # ---- figures

    def finish(self) -> dict[str, Any]:
        """`reference`, `material` and `collisions` of the object of `run --json`; what was not asked for is None."""
        self.figures = {"reference": self._reference(), "material": self._material(), "collisions": self._collisions()}
        return self.figures

    def _reference(self) -> dict[str, Any] | None:
        if self.reference is None:
            return None
        figures = {name: self._placed(meter.finish()) for name, meter in self.meters.items()}
        covered = {
            key: figures["actual"].pop(key, None) for key in ("length_mm", "missing_mm", "missing_pct", "missing")
        }
        return self.reference.as_json() | covered | figures

    def _placed(self, figures: dict[str, Any]) -> dict[str, Any]:
        worst = figures["worst"]
        if worst is not None:
            places = {key: dict(zip("XYZ", worst[key], strict=True)) for key in ("position", "nearest")}
            t_s = (worst["sample"] + 1) * self.sample_time_s
            figures["worst"] = {"line": worst["line"], "t_s": t_s} | places
        return figures

    def _material(self) -> dict[str, Any] | None:
        from toolpaths.material import CHORD_MM, compare

        setup, removal = self.setup, self.removal
        if setup is None or removal is None:
            return None
        removal.finish()
        if removal.stock is None or setup.shop.grid is None:
            return {"setup": setup.as_json(), "stock": None, "target": None}
        grid = setup.shop.grid
        figures: dict[str, Any] = {
            "setup": setup.as_json(),
            "follow": setup.follow,
            "resolution_mm": grid.step,
            "nodes": grid.nx * grid.ny,
            "moves": removal.moves,
            "chord_mm": CHORD_MM,
            "removed_mm3": removal.volume,
            "target": None,
        }
        if setup.target is not None:
            lines = removal.stock.line()
            self.compared = compare(removal.stock.z(), setup.target, grid)
            limits = {"rest": (1, setup.rest_limit), "gouge": (-1, setup.gouge_limit)}
            figures["target"] = {
                name: self.compared.side(sign, self.tolerance_mm if limit is None else limit, lines)
                | {"judged": limit is not None}
                for name, (sign, limit) in limits.items()
            }
            figures["target"]["gouge"]["judged"] = True
        return figures

    def _collisions(self) -> dict[str, Any] | None:
        if self.removal is None:
            return None
        from toolpaths.material import KINDS

        found = self.removal.findings
        return {
            "count": len(found),
            "kinds": {kind: n for kind in KINDS if (n := sum(f.kind == kind for f in found))},
            "findings": [
                {
                    "kind": f.kind,
                    "body": f.body,
                    "tool": f.tool,
                    "line": f.line,
                    "t_s": (f.sample + 1) * self.sample_time_s,
                    "place": dict(zip("XYZ", f.place, strict=True)),
                    "size_mm": f.size,
                }
                for f in self.listed()
            ],
        }

    def listed(self) -> list[Finding]:
        """The largest findings in the order of time."""
        found = self.removal.findings if self.removal is not None else []
        return sorted(sorted(found, key=lambda f: -f.size)[:LISTED], key=lambda f: (f.sample, f.kind))

    # ---- in a recording

    def attachments(self) -> list[tuple[str, str, bytes]]:
        """What a recording carries, so that a report can measure again."""
        files: list[tuple[str, str, bytes]] = []
        if self.setup is not None:
            files.append((SETUP_NAME, "application/toml", self.setup.text.encode()))
            files += [
                (MESH_PREFIX + name, "application/octet-stream", data) for name, data in self.setup.meshes.items()
            ]
        if self.reference is not None:
            files.append((REFERENCE_NAME, "application/octet-stream", self.reference.data))
        return files

    def metadata(self) -> dict[str, str]:
        """Names and options beside the attachments."""
        values = {"tool_change": self.change}
        if self.setup is not None:
            values["setup_path"] = self.setup.path
        if self.reference is not None:
            values["reference_path"] = self.reference.path
            values["reference_options"] = json.dumps(asdict(self.reference.options))
        return values


def _columns_of(chunk: Any) -> dict[str, NDArray[Any]]:
    return {name: getattr(chunk, name) for name in ("dp", "load", "line", "entry", "flags")}


def _in_space(values: NDArray[np.float64], columns: list[int]) -> NDArray[np.float64]:
    """X, Y, Z of samples; axes that the machine lacks are 0."""
    points = np.zeros((len(values), 3))
    points[:, : len(columns)] = values[:, columns]
    return points


def loaded(
    setup: str | None, reference: str | None, options: ReferenceOptions
) -> tuple[Setup | None, Reference | None]:
    """Both files, as far as they are asked for; raises CompileError with the findings of both."""
    found: list[Diagnostic] = []
    prepared, drawing = None, None
    try:
        prepared = load_setup(setup) if setup is not None else None
    except CompileError as error:
        found += error.diagnostics
    try:
        drawing = load_reference(reference, options) if reference is not None else None
    except CompileError as error:
        found += error.diagnostics
    if found:
        raise CompileError(found)
    return prepared, drawing


def checks_of_job(
    job: CompiledJob, setup: str | None, reference: str | None, options: ReferenceOptions, tolerance_mm: float | None
) -> Checks:
    """The checks of a compiled job against the files named; raises CompileError (SU..., RF...)."""
    prepared, drawing = loaded(setup, reference, options)
    machine, events = job.machine.machine, job.program.events()
    if prepared is not None:
        problems = check_job(prepared, machine, events, _moved_axes(job))
        if problems:
            raise CompileError(problems)
    limit = machine.tolerance_mm if tolerance_mm is None else tolerance_mm
    names, sample_time_s = list(machine.axis_names), machine.sample_time_us * 1e-6
    return Checks(names, sample_time_s, changing(events), limit, prepared, drawing)


def checks_of_drawing(
    machine: MachineFile, reference: str, options: ReferenceOptions, tolerance_mm: float | None
) -> Checks:
    """The check of a rw_SymPas job against a drawing; raises CompileError (RF...)."""
    names, limit = list(machine.machine.axis_names), machine.machine.tolerance_mm
    drawing = loaded(None, reference, options)[1]
    limit = limit if tolerance_mm is None else tolerance_mm
    return Checks(names, machine.machine.sample_time_us * 1e-6, "", limit, reference=drawing)


def _moved_axes(job: CompiledJob) -> set[str]:
    sequence = job.program.sequence()
    moved = (sequence["target"] != sequence["start"]).any(axis=0)
    return {name for name, moves in zip(job.machine.machine.axis_names, moved.tolist(), strict=True) if moves}


def recorded_checks(
    machine: Any, metadata: dict[str, str], files: dict[str, bytes], setup: Setup | None, reference: Reference | None
) -> Checks | None:
    """The checks that a recording carries; a setup or reference given now takes the place of the recorded one."""
    if setup is None and SETUP_NAME in files:
        meshes = {name.removeprefix(MESH_PREFIX): data for name, data in files.items() if name.startswith(MESH_PREFIX)}
        setup = parse_setup(files[SETUP_NAME], metadata["setup_path"], meshes.__getitem__)
    if reference is None and REFERENCE_NAME in files:
        plain = json.loads(metadata["reference_options"])
        options = ReferenceOptions(**plain | {"at": tuple(plain["at"])})
        reference = parse_reference(files[REFERENCE_NAME], metadata["reference_path"], options)
    if setup is None and reference is None:
        return None
    change, tolerance_mm = metadata.get("tool_change", "M06"), float(metadata["tolerance_mm"])
    return Checks(list(machine.axis_names), machine.sample_time_us * 1e-6, change, tolerance_mm, setup, reference)
