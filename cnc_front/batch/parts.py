"""Part programs of a batch: found in folders, globs and zip archives, each with the key of its result."""

from __future__ import annotations

import glob
import hashlib
import re
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from cnc_front import VERSION
from cnc_front.errors import UsageError
from cnc_front.jobs import JOB_BYTES

#: Names that are part programs, where a folder or an archive is given.
SUFFIXES = frozenset({".nc", ".ngc", ".din", ".cnc", ".iso", ".mpf", ".tap", ".gcode", ".src", ".cls", ".ncc"})
#: Largest file beside a part that is looked at as a subprogram, bytes.
BESIDE_BYTES = 1 << 22


@dataclass(frozen=True, slots=True)
class Part:
    """A part program: its name in the batch, where it lies, and what it consists of."""

    name: str
    path: Path
    sha256: str
    bytes: int


@dataclass(frozen=True, slots=True)
class Task:
    """One part on one machine. The key changes with everything that the result depends on."""

    key: str
    part: Part
    machine: str
    machine_name: str


def find(paths: Sequence[str], unpacked: Path) -> list[Part]:
    """The part programs at these paths, sorted by name; archives are unpacked below `unpacked`.

    UsageError for a path that leads to no part program.
    """
    found: dict[str, Part] = {}
    for path in paths:
        parts = [part_of(name, file) for name, file in _files(path, unpacked)]
        if not parts:
            raise UsageError(f"no part program at {path} (endings: {' '.join(sorted(SUFFIXES))})")
        found |= {part.name: part for part in parts}
    return [found[name] for name in sorted(found)]


def _files(path: str, unpacked: Path) -> Iterator[tuple[str, Path]]:
    here = Path(path)
    if here.is_dir():
        files = (f for f in sorted(here.rglob("*")) if f.suffix.lower() in SUFFIXES and f.is_file())
        yield from ((str(f), f) for f in files)
    elif here.suffix.lower() == ".zip" and here.is_file():
        yield from _archive(here, unpacked)
    elif here.is_file():
        yield str(here), here
    else:
        names = sorted(glob.glob(path, recursive=True))  # noqa: PTH207  a pattern may be absolute
        yield from ((name, Path(name)) for name in names if Path(name).is_file())


def _archive(archive: Path, unpacked: Path) -> Iterator[tuple[str, Path]]:
    """Members of an archive, unpacked whole: subprograms lie beside their callers."""
    folder = unpacked / hashlib.sha256(archive.read_bytes()).hexdigest()[:16]
    try:
        with zipfile.ZipFile(archive) as members:
            wanted = [m for m in members.infolist() if not m.is_dir()]
            too_large = next((m for m in wanted if m.file_size > JOB_BYTES), None)
            if too_large is not None:
                raise UsageError(f"{archive}: {too_large.filename} is larger than {JOB_BYTES >> 20} MiB")
            for member in wanted:
                members.extract(member, folder)  # extract() keeps names inside the folder
    except (zipfile.BadZipFile, RuntimeError) as error:
        raise UsageError(f"{archive}: no zip archive that can be read ({error})") from None
    for file in sorted(folder.rglob("*")):
        if file.suffix.lower() in SUFFIXES and file.is_file():
            yield f"{archive}/{file.relative_to(folder)}", file


def part_of(name: str, file: Path) -> Part:
    """A part with the hash of its text and of the subprograms beside it that it names. An unreadable one is a part too:
    its run says what is wrong."""
    try:
        data = file.read_bytes() if file.stat().st_size <= JOB_BYTES else b""
    except OSError as error:
        return Part(name, file, hashlib.sha256(str(error).encode()).hexdigest(), 0)
    digest = hashlib.sha256(data)
    for beside in _named_beside(file, data):
        digest.update(beside)
    return Part(name, file, digest.hexdigest(), len(data))


def _named_beside(file: Path, data: bytes) -> list[bytes]:
    """Texts of the files in the folder that the program, or one of those it names, may call: a call needs the name of
    the file or its number somewhere in the text."""
    beside = (f for f in sorted(file.parent.iterdir()) if f != file and f.is_file())
    others = {f.name: f for f in beside if f.stat().st_size < BESIDE_BYTES}
    found: list[bytes] = []
    pending = [data.lower()]
    while pending and others:
        text = pending.pop()
        words = {*re.findall(rb"[a-z_]\w*", text), *re.findall(rb"\d+", text)}
        for name in [n for n, f in others.items() if _called(f.stem.lower(), words)]:
            called = others.pop(name).read_bytes()
            found.append(name.encode() + b"\0" + called)
            pending.append(called.lower())
    return found


def _called(stem: str, words: set[bytes]) -> bool:
    number = re.fullmatch(r"o?0*(\d+)", stem)
    return stem.encode() in words or (number is not None and any(w.lstrip(b"0") == number[1].encode() for w in words))


def tasks(parts: Sequence[Part], machines: Sequence[tuple[str, str, str]], options: Sequence[str]) -> list[Task]:
    """Every part on every machine (path, name, text of the machine file), with the options of `run` for all."""
    made = []
    for part in parts:
        for path, name, text in machines:
            ingredients = (VERSION, part.name, part.sha256, path, text, *options)
            key = hashlib.sha256("\0".join(ingredients).encode()).hexdigest()
            made.append(Task(key, part, path, name))
    return made
