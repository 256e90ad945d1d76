"""Part programs of a batch: found in folders, globs and zip archives, each with the key of its result."""

from __future__ import annotations

import glob
import hashlib
import os
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
    folders = Folders()
    for path in paths:
        parts = [part_of(name, file, folders) for name, file in _files(path, unpacked)]
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


def part_of(name: str, file: Path, folders: Folders) -> Part:
    """A part with the hash of its text and of the subprograms beside it that it names. An unreadable one is a part too:
    its run says what is wrong."""
    try:
        data = file.read_bytes() if file.stat().st_size <= JOB_BYTES else b""
    except OSError as error:
        return Part(name, file, hashlib.sha256(str(error).encode()).hexdigest(), 0)
    digest = hashlib.sha256(data)
    for beside in _named_beside(file, data, folders):
        digest.update(beside)
    return Part(name, file, digest.hexdigest(), len(data))


class Folders:
    """What lies in the folders of the parts: each is looked at once, however many parts are in it."""

    def __init__(self) -> None:
        self._seen: dict[Path, dict[bytes, list[Path]]] = {}

    def callable_in(self, folder: Path) -> dict[bytes, list[Path]]:
        """Files that may be subprograms, by the word or the number with which a program may call them."""
        if folder not in self._seen:
            by_word: dict[bytes, list[Path]] = {}
            for file in sorted(folder.iterdir()):
                if file.is_file() and file.stat().st_size < BESIDE_BYTES:
                    for word in _words_for(file):
                        by_word.setdefault(word, []).append(file)
            self._seen[folder] = by_word
        return self._seen[folder]


def _words_for(file: Path) -> set[bytes]:
    """The name without its ending; of `O0100.nc` and `100.nc` the number too, without leading zeros."""
    stem = os.fsencode(file.stem.lower())
    number = re.fullmatch(rb"o?0*(\d+)", stem)
    return {stem, number[1]} if number else {stem}


#: Every byte that is part of no word becomes a blank; digits alone.
_WORDS = bytes(b if b in b"abcdefghijklmnopqrstuvwxyz0123456789_" else 0x20 for b in range(256))
_DIGITS = bytes(b if b in b"0123456789" else 0x20 for b in range(256))


def _words_in(text: bytes) -> set[bytes]:
    """Names and numbers in a text in lower case; of a number also without leading zeros."""
    words = set(text.translate(_WORDS).split())
    numbers = set(text.translate(_DIGITS).split())
    return words | {word.lstrip(b"0123456789") for word in words} | {n.lstrip(b"0") or b"0" for n in numbers}


def _named_beside(file: Path, data: bytes, folders: Folders) -> list[bytes]:
    """Texts of the files in the folder that the program, or one of those it names, may call: a call needs the name of
    the file or its number somewhere in the text."""
    others = folders.callable_in(file.parent)
    seen, found, pending = {file}, [], [data]
    while pending:
        words = _words_in(pending.pop().lower())
        called = {f for word in words & others.keys() for f in others[word]} - seen
        for other in sorted(called):
            text = other.read_bytes()
            found.append(os.fsencode(other.name) + b"\0" + text)
            pending.append(text)
        seen |= called
    return found


def tasks(parts: Sequence[Part], machines: Sequence[tuple[str, str, str]], options: Sequence[str]) -> list[Task]:
    """Every part on every machine (path, name, text of the machine file), with the options of `run` for all."""
    made = []
    for part in parts:
        for path, name, text in machines:
            ingredients = (VERSION, part.name, part.sha256, path, text, *options)
            key = hashlib.sha256("\0".join(ingredients).encode()).hexdigest()
            made.append(Task(key, part, path, name))
    return made
