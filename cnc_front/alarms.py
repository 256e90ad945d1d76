"""Faults that operators see: stable codes, and text with remedy in English and German.

Codes: E1nn is axst bit nn of an axis, E2nn is ErrorReg bit nn of the controller.
"""

from __future__ import annotations

#: What happened and what to do, by the manual's name of the bit.
TEXTS: dict[str, tuple[str, str]] = {
    "eo": ("emergency out is active; release it, then reset", "Not-Aus ist aktiv; entriegeln, dann Reset"),
    "dnr": ("drive not ready; check the drive", "Antrieb nicht bereit; Antrieb prüfen"),
    "lslh": ("left hardware limit switch; move away, reset", "linker Hardware-Endschalter; freifahren, Reset"),
    "lsrh": ("right hardware limit switch; move away, reset", "rechter Hardware-Endschalter; freifahren, Reset"),
    "lsls": (
        "left software limit passed; correct the program or the limit",
        "linker Software-Endschalter überfahren; Programm oder Grenze berichtigen",
    ),
    "lsrs": (
        "right software limit passed; correct the program or the limit",
        "rechter Software-Endschalter überfahren; Programm oder Grenze berichtigen",
    ),
    "mpe": (
        "following error beyond mpe; check drive and gains, lower feed or acceleration",
        "Schleppfehler über mpe; Antrieb und Regler prüfen, Vorschub oder Beschleunigung senken",
    ),
    "dhef": ("motion command refused, loop open; close the loop", "Fahrbefehl abgewiesen, Regelkreis offen; schließen"),
    "cef": ("configuration error; check the machine file", "Konfigurationsfehler; Maschinendatei prüfen"),
    "saf": (
        "spooler out of step with its group; the contour was left, start again",
        "Spooler läuft nicht synchron; Kontur verlassen, neu starten",
    ),
    "errSpoolerOverrun": ("spooler overflow; please report", "Spooler-Überlauf; bitte melden"),
    "ProfileToSmall": (
        "blocks shorter than a sample; raise the merge tolerance (G64 P)",
        "Sätze kürzer als ein Abtastschritt; Toleranz (G64 P) erhöhen",
    ),
    "SsfWaitRefused": (
        "a wait was refused because motion before it does not stop; please report",
        "Warten abgewiesen, weil die Bewegung davor nicht hält; bitte melden",
    ),
    "SpoolerDeepToLess": (
        "too few blocks in the spooler for the look-ahead; motion was slowed",
        "zu wenige Sätze im Spooler für die Vorausschau; langsamer gefahren",
    ),
    "JSatSAFdone": (
        "axes were stopped because spoolers ran out of step; start again",
        "Achsen angehalten, weil Spooler nicht synchron liefen; neu starten",
    ),
}

_LANGUAGES = ("en", "de")


def alarm_text(name: str, bit: int, axis: str, language: str) -> tuple[str, str]:
    """Code and text of a bit that came up; bits without a text of their own keep the manual's name."""
    code = f"E{1 if axis else 2}{bit:02d}"
    texts = TEXTS.get(name)
    return code, f"{name}: {texts[_LANGUAGES.index(language)]}" if texts else name
