"""Faults that operators see: stable codes, and text with fact, limit and remedy in English and German.

Codes: E1nn is axst bit nn of an axis, E2nn is ErrorReg bit nn of the controller, E301 a runtime error of the CNC task.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cnc_front._native import motion_kernel as native_kernel
    from cnc_front.execution import AlarmEvent

#: What happened, and what to do, English and German, by the manual's name of the bit.
TEXTS: dict[str, tuple[tuple[str, str], tuple[str, str]]] = {
    "eo": (("emergency out is active", "release it, then reset"), ("Not-Aus ist aktiv", "entriegeln, dann Reset")),
    "dnr": (("drive not ready", "check the drive, then reset"), ("Antrieb nicht bereit", "Antrieb prüfen, dann Reset")),
    "lslh": (
        ("left hardware limit switch", "reset, then move away"),
        ("linker Hardware-Endschalter", "Reset, dann freifahren"),
    ),
    "lsrh": (
        ("right hardware limit switch", "reset, then move away"),
        ("rechter Hardware-Endschalter", "Reset, dann freifahren"),
    ),
    "lsls": (
        ("left software limit passed", "correct the program or the limit"),
        ("linker Software-Endschalter überfahren", "Programm oder Grenze berichtigen"),
    ),
    "lsrs": (
        ("right software limit passed", "correct the program or the limit"),
        ("rechter Software-Endschalter überfahren", "Programm oder Grenze berichtigen"),
    ),
    "mpe": (
        ("following error", "check drive and gains, or lower feed or acceleration"),
        ("Schleppfehler", "Antrieb und Regler prüfen, oder Vorschub oder Beschleunigung senken"),
    ),
    "dhef": (
        ("motion command refused, loop open", "close the loop"),
        ("Fahrbefehl abgewiesen, Regelkreis offen", "Regelkreis schließen"),
    ),
    "cef": (
        ("configuration error", "check the machine file"),
        ("Konfigurationsfehler", "Maschinendatei prüfen"),
    ),
    "saf": (
        ("spooler out of step with its group, contour left", "reset, start again"),
        ("Spooler läuft nicht synchron, Kontur verlassen", "Reset, neu starten"),
    ),
    "errSpoolerOverrun": (("spooler overflow", "please report"), ("Spooler-Überlauf", "bitte melden")),
    "ProfileToSmall": (
        ("blocks shorter than a sample", "raise the merge tolerance (G64 P)"),
        ("Sätze kürzer als eine Abtastung", "Toleranz (G64 P) erhöhen"),
    ),
    "SsfWaitRefused": (
        ("a wait was refused because motion before it does not stop", "please report"),
        ("Warten abgewiesen, weil die Bewegung davor nicht hält", "bitte melden"),
    ),
    "SpoolerDeepToLess": (
        (
            "too few blocks in the spooler for the look-ahead, motion was slowed",
            "larger blocks, or more spooler memory",
        ),
        ("zu wenige Sätze im Spooler für die Vorausschau, langsamer gefahren", "größere Sätze oder Spooler vergrößern"),
    ),
    "JSatSAFdone": (
        ("axes were stopped because spoolers ran out of step", "reset, start again"),
        ("Achsen angehalten, weil Spooler nicht synchron liefen", "Reset, neu starten"),
    ),
    "task_error": (
        ("runtime error of the CNC task", "correct the program, then reset"),
        ("Laufzeitfehler des CNC-Tasks", "Programm berichtigen, dann Reset"),
    ),
}

#: Stands where the fact is not known.
UNKNOWN = {"mpe": ("too large", "zu groß")}
_LANGUAGES = ("en", "de")
#: The same alarm that comes again so soon is a contact that bounces, s.
BOUNCE_S = 0.1


def alarm_text(name: str, bit: int, axis: str, language: str, fact: str = "") -> tuple[str, str]:
    """Code, and text: what, fact with limit, the manual's name, remedy. Bits without a text keep the manual's name."""
    code = f"E{1 if axis else 2}{bit:02d}" if name != "task_error" else "E301"
    if name not in TEXTS:
        return code, name
    column = _LANGUAGES.index(language)
    what, remedy = TEXTS[name][column]
    fact = fact or UNKNOWN.get(name, ("", ""))[column]
    return code, f"{what} {fact}".rstrip() + f" ({name}); {remedy}"


def alarm_fact(event: AlarmEvent, machine: native_kernel.Machine, language: str) -> str:
    """What was measured when it came, against its limit; empty where nothing was."""
    if event.axis not in machine.axis_names or event.following is None or event.set_point is None:
        return ""
    axis = machine.axis_names.index(event.axis)
    limits, unit, mpe = machine.limits[axis], machine.units[axis], machine.mpe[axis]
    if event.name == "mpe" and abs(event.following) > mpe:
        return f"{abs(event.following):.4g} {unit} > {mpe:g} {unit}"
    if event.name in ("lslh", "lsrh"):
        at = ("at", "bei")[_LANGUAGES.index(language)]
        return f"{at} {event.set_point - event.following:.3f} {unit}"
    if limits is None or event.name not in ("lsls", "lsrs"):
        return ""
    sign, limit = ("<", limits[0]) if event.name == "lsls" else (">", limits[1])
    return f"{event.set_point:.4f} {unit} {sign} {limit:g} {unit}"


def without_bounces(events: Iterable[AlarmEvent]) -> list[AlarmEvent]:
    """Alarms as operators count them: one that comes again within BOUNCE_S of the last time is still the same."""
    last: dict[tuple[str, str], float] = {}
    kept = []
    for event in events:
        who = event.axis, event.name
        if event.t_s - last.get(who, -BOUNCE_S) >= BOUNCE_S:
            kept.append(event)
        last[who] = event.t_s
    return kept
