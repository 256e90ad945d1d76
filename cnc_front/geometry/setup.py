"""The setup of a job: blank, fixtures, target and tools, from `part.setup.toml` beside `part.nc` (docs/material.md)."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import CompileError
from cnc_front.geometry.section import Section, read_toml
from cnc_front.jobs import MACHINE_BYTES, read_bytes, shown

if TYPE_CHECKING:
    from toolpaths.material import Fixture, Grid, Heights, Tool, Workshop
    from toolpaths.meshes import Triangles

SHAPES = ("flat", "ball", "bull")
UNITS = {"mm": 1.0, "inch": 25.4}
NOWHERE = (0.0, 0.0, 0.0)

#: Reads a file named in a setup; raises OSError or CompileError.
Reader = Callable[[str], bytes]


@dataclass(frozen=True, slots=True)
class Setup:
    """A validated setup. `meshes` are the bytes of the files that it names, for a recording."""

    path: str
    text: str
    sha256: str
    zero: tuple[float, float, float]
    follow: str
    shop: Workshop
    target: Heights | None
    gouge_limit: float | None
    rest_limit: float | None
    meshes: dict[str, bytes]

    def as_json(self) -> dict[str, Any]:
        """For the object of `run --json`."""
        return {"path": shown(self.path), "sha256": self.sha256}


def load_setup(path: str) -> Setup:
    """Reads and validates a setup and the meshes it names (beside it); raises CompileError (SU100 ...)."""
    data = read_bytes(path, MACHINE_BYTES, "SU100")
    return parse_setup(data, path, lambda name: read_bytes(str(Path(path).parent / name), 256 << 20, "SU109"))


def parse_setup(data: bytes, path: str, read: Reader) -> Setup:
    """As `load_setup`, from bytes; raises CompileError with every finding."""
    values, findings = read_toml(data, shown(path))
    if values is None:
        raise CompileError(findings.sorted())
    reading = _Reading(Section(values, (), findings), read)
    setup = reading.setup(path, data)
    if findings.found or setup is None:
        raise CompileError(findings.sorted())
    return setup


class _Reading:
    def __init__(self, top: Section, read: Reader) -> None:
        self.top, self.read = top, read
        self.meshes: dict[str, bytes] = {}

    def setup(self, path: str, data: bytes) -> Setup | None:
        from toolpaths.material import Workshop

        top = self.top
        zero, follow = top.point("zero", NOWHERE), top.word("follow", ("actual", "setpoint"), "actual")
        margin = top.number("rapid_margin", 0.001, 10.0, 0.05)
        tools = self.tools()
        first = top.whole("first_tool", 0, 99_999_999, next(iter(tools), 0))
        if tools and first not in tools:
            top.fault("first_tool", "SU110", f"there is no tool {first}")
        grid, stock, floor = self.stock()
        step = grid.step if grid else top.number("resolution", 0.001, 10.0, 0.2)
        target, gouge, rest = self.target(grid)
        fixtures = self.fixtures(step)
        top.finish()
        if stock is None and not fixtures and not top.findings.found:
            top.findings.add((), "SU104", "there is neither a [stock] nor a [[fixture]]: nothing to check")
        if top.findings.found:
            return None
        shop = Workshop(tools, first, grid, stock, floor, fixtures, margin, step)
        sha256, text = hashlib.sha256(data).hexdigest(), data.decode()
        return Setup(path, text, sha256, zero, follow, shop, target, gouge, rest, self.meshes)

    def tools(self) -> dict[int, Tool]:
        tables = self.top.children("tool")
        if not tables and "tool" not in self.top.table:
            self.top.findings.add((), "SU104", "[[tool]] is missing: nothing is known of the tools")
        tools: dict[int, Tool] = {}
        for table in tables:
            tool = _tool(table)
            if tool.number in tools:
                table.fault("number", "SU108", f"tool {tool.number} is there twice")
            tools[tool.number] = tool
        return tools

    def stock(self) -> tuple[Grid | None, Heights | None, float]:
        """Grid, heights and underside of the blank."""
        from toolpaths.material import MOST_NODES, Grid, usual_step

        table = self.top.child("stock")
        if table is None:
            return None, None, -float("inf")
        mesh = self.mesh(table) if table.has("file") else None
        if mesh is None and not table.has("file"):
            low, high = table.point("from"), table.point("to")
        elif mesh is not None:
            low, high = tuple(mesh.min(axis=(0, 1)).tolist()), tuple(mesh.max(axis=(0, 1)).tolist())
        else:
            low, high = NOWHERE, (1.0, 1.0, 1.0)
        table.finish()
        if not all(a < b for a, b in zip(low, high, strict=True)):
            if table.has("from") and table.has("to"):
                table.fault("to", "SU110", "must be above `from` in X, Y and Z")
            return None, None, -float("inf")
        step = self.top.number("resolution", 0.001, 10.0, usual_step(low, high))
        nodes = (high[0] - low[0]) * (high[1] - low[1]) / step**2
        if nodes > MOST_NODES:
            at = self.top if self.top.has("resolution") else table
            at.fault("resolution", "SU111", f"{nodes:.0f} nodes, at most {MOST_NODES} are calculated")
            return None, None, -float("inf")
        grid = Grid.over(low, high, step)
        return grid, grid.flat(high[2]) if mesh is None else grid.of_mesh(mesh), low[2]

    def target(self, grid: Grid | None) -> tuple[Heights | None, float | None, float | None]:
        table = self.top.child("target")
        if table is None:
            return None, None, None
        mesh = self.mesh(table)
        gouge = table.number("gouge_limit", 0.0, 1000.0, -1.0)
        rest = table.number("rest_limit", 0.0, 1000.0, -1.0)
        table.finish()
        if not self.top.has("stock"):
            self.top.findings.add(("target",), "SU104", "a [target] needs a [stock] that it is cut from")
        heights = grid.of_mesh(mesh) if grid is not None and mesh is not None else None
        return heights, gouge if gouge >= 0 else None, rest if rest >= 0 else None

    def fixtures(self, step: float) -> tuple[Fixture, ...]:
        from toolpaths.material import MOST_NODES, Fixture

        fixtures: list[Fixture] = []
        for number, table in enumerate(self.top.children("fixture"), 1):
            name = table.text("name", f"fixture {number}")
            clearance, mesh = table.number("clearance", 0.0, 100.0, 0.0), self.mesh(table)
            table.finish()
            if name in {fixture.name for fixture in fixtures}:
                table.fault("name", "SU108", f"{name} is there twice")
            if mesh is None:
                continue
            size = (mesh.max(axis=(0, 1)) - mesh.min(axis=(0, 1)) + 2 * clearance) / step + 4
            if size[0] * size[1] > MOST_NODES:
                table.fault("file", "SU111", f"{size[0] * size[1]:.0f} nodes, at most {MOST_NODES} are calculated")
                continue
            fixtures.append(Fixture(name, mesh, clearance))
        return tuple(fixtures)

    def mesh(self, table: Section) -> Triangles | None:
        """The body in `file`, moved to `at`."""
        from toolpaths.meshes import GeometryError, read_mesh

        name = table.text("file")
        scale, at = UNITS[table.word("unit", tuple(UNITS), "mm")], table.point("at", NOWHERE)
        if not name:
            return None
        try:
            data = self.meshes[name] if name in self.meshes else self.read(name)
            self.meshes[name] = data
            return read_mesh(data, Path(name).suffix.lower().lstrip("."), scale) + at
        except GeometryError as error:
            table.fault("file", "SU109", f"{name} {error}")
        except CompileError as error:
            table.fault("file", "SU109", f"{name}: {error.diagnostics[0].message}", error.diagnostics[0].hint)
        return None


def _tool(table: Section) -> Tool:
    """A tool with its shank and holder as cylinders."""
    from toolpaths.material import Tool

    number = table.whole("number", 0, 99_999_999)
    shape = table.word("shape", SHAPES)
    radius = table.number("diameter", 0.01, 1000.0) / 2
    corner = radius if shape == "ball" else 0.0
    if shape == "bull":
        corner = table.number("corner", 0.0, 500.0)
        if corner > radius:
            table.fault("corner", "SU110", f"{corner:g} is more than the radius of the tool")
    gauge = table.number("gauge", -1e4, 1e4, 0.0)
    length = table.number("length", 0.1, 1e4, 1e4)
    flute = table.number("flute", 0.01, 1e4, length)
    if table.has("flute") and flute > length:
        table.fault("flute", "SU110", "is more than the length of the tool")
    shank = table.number("shank", 0.01, 1000.0, 2 * radius)
    bodies = [(shank / 2, flute)] if table.has("shank") else []
    holder = table.children("holder")
    if holder and not table.has("length"):
        table.fault("holder", "SU104", "needs `length`, the height of its lower face above the tip")
    above = length
    for part in holder:
        bodies.append((part.number("diameter", 0.01, 2000.0) / 2, above))
        above += part.number("length", 0.01, 1e4)
        part.finish()
    table.finish()
    limited = table.has("flute") or table.has("length")
    return Tool(number, shape, radius, corner, gauge, flute if limited else float("inf"), tuple(bodies))


def check_job(setup: Setup, machine: Any, events: list[tuple[int, str, str]], moved: set[str]) -> list[Diagnostic]:
    """Whether a job can be checked on a height map: X, Y, Z linear, no other axis moves, tools are known."""
    file, found = shown(setup.path), []
    kinds = dict(zip(machine.axis_names, machine.kinds, strict=True))
    missing = [name for name in "XYZ" if kinds.get(name) != "linear"]
    if missing:
        text = f"material and collisions need linear axes X, Y, Z; the machine has no linear {', '.join(missing)}"
        found.append(Diagnostic(file, 1, 1, 1, "SU110", text, "use a machine with X, Y and Z, or leave out the setup"))
    others = sorted(moved - set("XYZ"))
    if others:
        text = f"the job moves {', '.join(others)}; material and collisions are calculated for X, Y, Z alone"
        found.append(Diagnostic(file, 1, 1, 1, "SU110", text, "leave out the setup for jobs with other axes"))
    for line, kind, number in events:
        if kind == changing(events) and tool_number(number) not in {0, *setup.shop.tools}:
            text = f"the job changes to tool {number} in line {line}, which is not in the setup"
            found.append(Diagnostic(file, 1, 1, 1, "SU110", text, "add a [[tool]] with that number"))
    return list({d.message.split(" in line")[0]: d for d in reversed(found)}.values())[::-1]


def changing(events: list[tuple[int, str, str]]) -> str:
    """The event that changes the tool: M06 where the program has one, else T."""
    return "M06" if any(kind == "M06" for _, kind, _ in events) else "T"


def tool_number(text: str) -> int:
    """The number in a T or M06 event; -1 for a tool that has none."""
    return int(text) if text.isascii() and text.isdigit() else -1
