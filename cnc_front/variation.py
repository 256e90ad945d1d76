"""Machine files with some numbers changed: what `cnc-front tune` sweeps."""

from __future__ import annotations

import hashlib
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cnc_front._native import motion_kernel as native_kernel
from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import CompileError, UsageError
from cnc_front.jobs import MachineFile, shown

#: Where a name is looked for, in this order: the axis itself, its controller, its drive, the G-code defaults.
PLACES = ("axis", "pidf", "plant", "gcode")


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number of the machine file by its key. `values` are factors, or absolute."""

    name: str
    place: str
    values: tuple[float, ...]
    absolute: bool = False


def find(name: str, machine: MachineFile) -> str:
    """The place of PLACES that has a number of that name; raises UsageError."""
    content = tomllib.loads(machine.machine.show())
    axis = content["axis"][0]
    for place in PLACES:
        table = {"axis": axis, "gcode": content["gcode"]}.get(place, axis.get(place, {}))
        value = table.get(name)
        if isinstance(value, float | int) and not isinstance(value, bool):
            return place
    raise UsageError(f"--vary: the machine file has no number '{name}' of an axis, its pidf, its plant or gcode")


def present(parameter: Parameter, machine: MachineFile, axes: Sequence[str]) -> dict[str, float]:
    """The values in the machine file by axis ('' for those of gcode)."""
    content = tomllib.loads(machine.machine.show())
    if parameter.place == "gcode":
        return {"": float(content["gcode"][parameter.name])}
    tables = {axis["name"]: axis if parameter.place == "axis" else axis[parameter.place] for axis in content["axis"]}
    return {name: float(tables[name][parameter.name]) for name in axes if parameter.name in tables[name]}


def varied(machine: MachineFile, chosen: Mapping[Parameter, float], axes: Sequence[str]) -> MachineFile:
    """The machine with these values (or factors) on these axes; raises CompileError where that is no valid machine."""
    text = machine.machine.show()
    for parameter, value in chosen.items():
        for axis, now in present(parameter, machine, axes).items():
            text = _replaced(text, parameter, axis, value if parameter.absolute else now * value)
    data = text.encode()
    try:
        made = native_kernel.Machine.parse(data, shown(machine.path) or "machine")
    except native_kernel.MachineError as error:
        raise CompileError([Diagnostic(*row) for row in error.args[0]]) from None
    return MachineFile(machine.path, text, hashlib.sha256(data).hexdigest(), made)


def _replaced(text: str, parameter: Parameter, axis: str, value: float) -> str:
    """The resolved machine file is written by `Machine.show`: a table a section, one key a line, small ones inline."""
    begin, end = _section(text, parameter, axis)
    key = re.escape(parameter.name)
    inline = parameter.place not in ("axis", "gcode")
    pattern = rf"(\b{key} = )[-+.\deE]+" if inline else rf"(?m)(^{key} = )[-+.\deE]+"
    changed, count = re.subn(pattern, lambda found: f"{found[1]}{value!r}", text[begin:end], count=1)
    assert count == 1, f"{parameter.name} is in the resolved machine file"
    return text[:begin] + changed + text[end:]


def _section(text: str, parameter: Parameter, axis: str) -> tuple[int, int]:
    if parameter.place == "gcode":
        begin = text.index("\n[gcode]\n") + 1
        return begin, _next_table(text, begin + 1)
    name = text.index(f'\nname = "{axis}"\n', text.index("[[axis]]"))
    begin = text.rindex("[[axis]]", 0, name + 1)
    following = text.find("[[axis]]", begin + 1)
    end = following if following >= 0 else text.index("\n[gcode]\n")
    if parameter.place == "axis":
        return begin, min(end, _next_table(text, begin + 8))
    if f"[axis.{parameter.place}]" in text[begin:end]:
        begin = text.index(f"[axis.{parameter.place}]", begin)
        return begin, min(end, _next_table(text, begin + 1))
    begin = text.index(f"\n{parameter.place} = ", begin) + 1
    return begin, text.index("\n", begin)


def _next_table(text: str, begin: int) -> int:
    found = re.compile(r"(?m)^\[").search(text, begin)
    return found.start() if found else len(text)
