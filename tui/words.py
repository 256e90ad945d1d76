"""Texts of the terminal, English and German, with the terms of the German controller manuals (ui-guide 9)."""

from __future__ import annotations

WORDS: dict[str, tuple[str, str]] = {
    "actual": ("ACTUAL", "IST"),
    "to_go": ("TO GO", "RESTWEG"),
    "follow": ("FOLLOW um", "SCHLEPPF. um"),
    "limit": ("limit", "Grenze"),
    "path": ("PATH", "BAHN"),
    "time": ("TIME", "ZEIT"),
    "sim": ("sim", "sim"),
    "set": ("set", "soll"),
    "eff": ("eff", "wirksam"),
    "now": ("now", "jetzt"),
    "max": ("max", "max"),
    "tol": ("tol", "Tol"),
    "empty_in": ("empty in", "leer in"),
    "by_deviation": ("colour/glyph = deviation", "Farbe/Zeichen = Abweichung"),
    "todo": ("to do", "offen"),
    "tool": ("tool", "Wkz"),
    "col": ("1 col =", "1 Sp ="),
    "no_job": ("No job. F2 opens, or: cnc-front tui part.nc", "Kein Auftrag. F2 öffnet, oder: cnc-front tui teil.nc"),
    "loading": ("Loading {name} ...", "Lade {name} ..."),
    "loaded": ("{name}: {lines} lines, {warnings} warnings", "{name}: {lines} Zeilen, {warnings} Warnungen"),
    "too_small": ("too small, need 80x24", "zu klein, braucht 80x24"),
    "estop": (
        "This terminal is no emergency stop. Use the hard-wired one.",
        "Dieses Terminal ist kein Not-Halt. Dafür gibt es den fest verdrahteten.",
    ),
    "reset_armed": ("Reset: Enter within 3 s drops the job", "Reset: Enter binnen 3 s verwirft den Auftrag"),
    "reset_done": ("ABORT: braked on the path, spooler dropped", "ABBRUCH: auf der Bahn gebremst, Spooler verworfen"),
    "held": ("HOLD: slows on the path; r goes on", "HALT: bremst auf der Bahn; r setzt fort"),
    "low_override": ("override low", "Korrektur klein"),
    "no_message": ("", ""),
    "open_title": ("Open part program", "Teileprogramm öffnen"),
    "goto_title": ("Go to line", "Gehe zu Zeile"),
    "override_title": ("Feed override in percent", "Vorschubkorrektur in Prozent"),
    "quit_title": ("Quit? The emulated machine ends with it.", "Beenden? Die emulierte Maschine endet mit."),
    "enter_esc": ("Enter: take   Esc: leave (and hold)", "Enter: übernehmen   Esc: verlassen (und Halt)"),
    "enter_quit": ("Enter: quit   Esc: stay", "Enter: beenden   Esc: bleiben"),
    "bad_value": ("not a number: {text}", "keine Zahl: {text}"),
    "no_line": ("there is no line {text}", "Zeile {text} gibt es nicht"),
    "warning_count": ("{count} warning", "{count} Warnung"),
    "alarm_count": ("{count} alarm", "{count} Störung"),
    "alarms": ("ALARMS", "STÖRUNGEN"),
    "no_alarms": ("No alarms.", "Keine Störungen."),
    "line": ("line", "Zeile"),
    "details": ("n: next", "n: weiter"),
    "key_hold": ("Hold", "Halt"),
    "key_start": ("Start", "Start"),
    "key_step": ("Step", "Einzelschr."),
    "key_sb": ("SB", "Einzels."),
    "key_ovr": ("Ovr", "Korr"),
    "key_speed": ("Sim", "Sim"),
    "key_reset": ("Reset", "Reset"),
    "key_plot": ("View", "Ansicht"),
    "key_help": ("Help", "Hilfe"),
    "key_open": ("Open", "Öffnen"),
    "key_alarms": ("Alarms", "Störungen"),
}

STATES: dict[str, tuple[str, str, str, str]] = {
    # state: symbol, style, English, German
    "NO JOB": ("-", "soft", "NO JOB", "KEIN AUFTRAG"),
    "READY": ("#", "text", "READY", "BEREIT"),
    "RUNNING": (">", "inverse", "RUNNING", "LÄUFT"),
    "HOLDING": ("=", "warn_inverse", "HOLDING", "BREMST"),
    "HOLD": ("=", "warn_inverse", "HOLD", "HALT"),
    "STEP": ("=", "warn_inverse", "BLOCK END", "SATZENDE"),
    "STOPPED": ("=", "warn_inverse", "STOPPED", "GESTOPPT"),
    "WAITING": ("~", "text", "WAITING", "WARTET"),
    "DONE": ("v", "text", "DONE", "FERTIG"),
    "ABORTED": ("x", "bad", "ABORTED", "ABGEBROCHEN"),
    "ALARM": ("!!", "bad_inverse", "ALARM", "STÖRUNG"),
}

HELP: tuple[tuple[str, str, str], ...] = (
    ("SPACE", "Feed hold (Esc too); never asks", "Vorschub-Halt (auch Esc); fragt nie"),
    ("r", "Start, resume", "NC-Start, fortsetzen"),
    ("t", "Step one block", "Einzelschritt"),
    ("b", "Single block on/off", "Einzelsatz ein/aus"),
    ("+ - * =", "Feed override 5 % up, down, 100 %, value", "Vorschubkorrektur 5 % auf, ab, 100 %, Wert"),
    (", .", "Simulation speed slower, faster (max = free)", "Simulation langsamer, schneller (max = frei)"),
    ("Ctrl+X Enter", "Reset: brake on the path, drop the job", "Reset: auf der Bahn bremsen, Auftrag verwerfen"),
    ("v", "View: program+path, path, values", "Ansicht: Programm+Bahn, Bahn, Werte"),
    ("f  z Z", "Fit path, zoom in, out (drag pans)", "Bahn einpassen, größer, kleiner (ziehen schiebt)"),
    ("Up Down", "Look through the program; g: go to line", "Im Programm blättern; g: gehe zu Zeile"),
    ("n", "Next message", "Nächste Meldung"),
    ("F2 o", "Open a part program", "Teileprogramm öffnen"),
    ("F3", "Run screen", "Schirm Lauf"),
    ("F6", "Alarms", "Störungen"),
    ("F1 ?", "This help", "Diese Hilfe"),
    ("Ctrl+Q", "Quit (asks)", "Beenden (fragt)"),
)


class Say:
    """Looks texts up in one language."""

    def __init__(self, language: str) -> None:
        self.german = language == "de"

    def __call__(self, id: str, **values: object) -> str:
        """The text with its values filled in."""
        return WORDS[id][self.german].format(**values)

    def state(self, state: str) -> tuple[str, str, str]:
        """Symbol, style name and word of a state."""
        symbol, style, english, german = STATES[state]
        return symbol, style, german if self.german else english

    def help(self) -> list[tuple[str, str]]:
        """Key and what it does."""
        return [(key, german if self.german else english) for key, english, german in HELP]
