"""Commands of the line mode: one table, from which the reader and the help come. Both languages always count."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache


@dataclass(frozen=True, slots=True)
class Verb:
    """A command: its words, and what help says of it, with the way to type it first."""

    id: str
    english: tuple[str, ...]
    german: tuple[str, ...]
    help: tuple[str, str]


VERBS: tuple[Verb, ...] = (
    Verb(
        "hold",
        ("hold", "h", "stop"),
        ("halt", "stopp"),
        ("feed hold; so does an empty line, and Ctrl+C", "Vorschub-Halt; auch eine leere Zeile und Strg+C"),
    ),
    Verb("start", ("start", "r"), ("los",), ("cycle start, or goes on", "NC-Start, oder weiter")),
    Verb("resume", ("resume", "continue"), ("weiter",), ("goes on", "fährt weiter")),
    Verb(
        "step",
        ("step", "t"),
        ("schritt",),
        ("one block; step X 0.1: how far a jog of X goes", "ein Satz; schritt X 0.1: wie weit X beim Tippen fährt"),
    ),
    Verb("single", ("single", "b"), ("einzelsatz",), ("single block on or off", "Einzelsatz ein oder aus")),
    Verb("reset", ("reset",), ("abbruch",), ("reset yes: aborts, drops the spooler", "abbruch ja: Spooler leer")),
    Verb("override", ("override", "ovr"), ("korrektur",), ("override 80: feed override in %", "korrektur 80: in %")),
    Verb("speed", ("speed",), ("tempo",), ("speed 10, speed max: of the simulation", "tempo 10, tempo max")),
    Verb("status", ("status", "s"), ("stand",), ("state, block, positions, progress", "Zustand, Satz, Positionen")),
    Verb("position", ("position", "p"), ("position", "ort"), ("every axis in a line", "jede Achse in einer Zeile")),
    Verb("block", ("block",), ("satz",), ("block, block N120: text of a block", "satz, satz N120: Text eines Satzes")),
    Verb(
        "blocks",
        ("blocks",),
        ("sätze", "saetze"),
        (
            "blocks, blocks N120: ten blocks from the current one, or that one, on",
            "sätze, sätze N120: zehn Sätze von da",
        ),
    ),
    Verb(
        "search",
        ("search",),
        ("suche", "satzsuchlauf"),
        (
            "search N120, search 45: the state before a block or line; yes takes it, start starts there; search 0: top",
            "suche N120, suche 45: Zustand vor Satz oder Zeile; ja übernimmt, los beginnt dort; suche 0: Anfang",
        ),
    ),
    Verb("yes", ("yes", "y"), ("ja",), ("to what was just asked", "zu dem, was eben gefragt wurde")),
    Verb(
        "jog",
        ("jog",),
        ("tippe", "tippen"),
        ("jog X +, jog X -: one step of X", "tippe X +, tippe X -: ein Schritt von X"),
    ),
    Verb(
        "home",
        ("home",),
        ("referenz",),
        ("home X, home all: home search, asks first", "referenz X, referenz alle: Referenzfahrt, fragt zuerst"),
    ),
    Verb(
        "zero",
        ("zero",),
        ("nullpunkt", "null"),
        ("zero X: work zero G54 here, asks first", "nullpunkt X: G54 hierher, fragt"),
    ),
    Verb(
        "mdi",
        ("mdi",),
        ("mdi",),
        (
            "mdi G1 X10 F500: checks a block or rw_SymPas statement;, start executes it; start job: the job",
            "mdi G1 X10 F500: prüft Satz oder rw_SymPas-Anweisung;, los führt aus; los auftrag: der Auftrag",
        ),
    ),
    Verb(
        "registers",
        ("registers",),
        ("register",),
        (
            "registers, registers X: error register, status bits of an axis",
            "register, register X: Fehlerregister, Achsbits",
        ),
    ),
    Verb(
        "tasks", ("tasks",), ("tasks",), ("the four CNC tasks with their lines", "die vier CNC-Tasks mit ihren Zeilen")
    ),
    Verb(
        "variables", ("variables",), ("variablen",), ("common variables that are not 0", "gemeinsame Variablen außer 0")
    ),
    Verb(
        "inputs",
        ("inputs",),
        ("eingänge", "eingaenge"),
        ("inputs and outputs that are on", "Ein- und Ausgänge, die an sind"),
    ),
    Verb(
        "force",
        ("force",),
        ("erzwinge",),
        (
            "force 3 on, force 3 off: an input, in later runs too",
            "erzwinge 3 ein, erzwinge 3 aus: ein Eingang, auch später",
        ),
    ),
    Verb(
        "release", ("release", "e"), ("freigabe",), ("no input is forced any more", "kein Eingang ist mehr erzwungen")
    ),
    Verb(
        "dryfeed",
        ("dryfeed",),
        ("probevorschub",),
        (
            "dryfeed 500: dry-run feed in mm/min; dryfeed: machine file",
            "probevorschub 500: mm/min; allein: Maschinendatei",
        ),
    ),
    Verb("dryrun", ("dryrun", "d"), ("probelauf",), ("dry-run feed on or off", "Probelaufvorschub ein oder aus")),
    Verb(
        "queue",
        ("queue",),
        ("folge",),
        (
            "queue, queue add part.nc, queue remove 2, queue start, queue stop: jobs one after the other",
            "folge, folge dazu teil.nc, folge heraus 2, folge los, folge stopp: Aufträge nacheinander",
        ),
    ),
    Verb("alarms", ("alarms", "a"), ("störungen", "stoerungen"), ("open alarms", "offene Störungen")),
    Verb("acknowledge", ("acknowledge", "ack"), ("quittieren",), ("alarms whose cause is gone", "behobene Störungen")),
    Verb("report", ("report",), ("bericht",), ("verdict and worst blocks", "Urteil und größte Abweichungen")),
    Verb("export", ("export",), ("export",), ("export FOLDER: the HTML report", "export ORDNER: HTML-Bericht")),
    Verb("load", ("load", "open"), ("lade", "öffne", "oeffne"), ("load part.nc", "lade teil.nc")),
    Verb("wait", ("wait",), ("warte",), ("wait, wait 10: until the job stands", "warte, warte 10: bis er steht")),
    Verb("every", ("every",), ("alle",), ("every 5: a line each 5 s; 0: none", "alle 5: alle 5 s; 0: keine")),
    Verb("help", ("help", "?"), ("hilfe",), ("this list", "diese Liste")),
    Verb("quit", ("quit", "q", "exit"), ("ende",), ("ends; quit yes while a job runs", "beendet; ende ja im Lauf")),
)

#: Words behind a command.
PARTS: dict[str, tuple[str, ...]] = {
    "all": ("all", "alle"),
    "job": ("job", "auftrag"),
    "on": ("on", "ein"),
    "off": ("off", "aus"),
    "add": ("add", "dazu"),
    "remove": ("remove", "heraus"),
    "start": ("start", "los"),
    "stop": ("stop", "stopp"),
}


@cache
def _by_word() -> dict[str, str]:
    return {word: verb.id for verb in VERBS for word in (*verb.english, *verb.german)}


def verb_of(word: str) -> str | None:
    """The command of a word; nothing typed is a hold, the one that must be easy."""
    return "hold" if not word else _by_word().get(word.lower())


def nearest(word: str) -> str | None:
    """The command whose word is most like an unknown one; None where none is like it at all."""
    found = get_close_matches(word.lower(), _by_word(), n=1, cutoff=0.5)
    return _by_word()[found[0]] if found else None


def way(id: str, language: str) -> str:
    """What help says of a command."""
    verb = next(verb for verb in VERBS if verb.id == id)
    return f"{', '.join(verb.german if language == 'de' else verb.english)}: {verb.help[language == 'de']}"


def part_of(text: str) -> str | None:
    """What a word behind a command means."""
    return next((id for id, words in PARTS.items() if text.lower() in words), None)
