"""What is known of a part program before it starts: where it goes against the limits, tools, feeds, modes, findings."""

from __future__ import annotations

from dataclasses import dataclass

from cnc_front.diagnostics import Diagnostic
from cnc_front.jobs import CompiledJob


@dataclass(frozen=True, slots=True)
class Reach:
    """Where an axis goes, in machine coordinates and its unit, and how far it may."""

    name: str
    unit: str
    low: float
    high: float
    limits: tuple[float, float] | None

    @property
    def fits(self) -> bool:
        """Within the software limits; an axis without limits always does."""
        return self.limits is None or (self.limits[0] <= self.low and self.high <= self.limits[1])


@dataclass(frozen=True, slots=True)
class LoadCheck:
    """The facts of a compiled program."""

    axes: tuple[Reach, ...]
    tools: tuple[int, ...]  # in the order of their first use
    feeds: tuple[float, float] | None  # lowest and highest F, mm/min
    modal: str  # state of the first motion
    motion_blocks: int
    findings: tuple[Diagnostic, ...]
    more_findings: int

    @property
    def is_within(self) -> bool:
        """Every axis stays within its limits."""
        return all(axis.fits for axis in self.axes)


def load_check(job: CompiledJob, extents: dict[str, tuple[float, float]]) -> LoadCheck:
    """`extents`: of the programmed path, by axis name."""
    machine, facts = job.machine.machine, job.facts
    rows = zip(machine.axis_names, machine.units, machine.limits, strict=True)
    feeds = [feed for _, feed in facts["feeds"]]
    modal = facts["modal"]
    return LoadCheck(
        axes=tuple(Reach(name, unit, *extents[name], limits) for name, unit, limits in rows),
        tools=tuple(dict.fromkeys(facts["tools"])),
        feeds=(min(feeds), max(feeds)) if feeds else None,
        modal=modal[0][1] if modal else "",
        motion_blocks=facts["motion_blocks"],
        findings=job.warnings,
        more_findings=facts["more_warnings"],
    )
