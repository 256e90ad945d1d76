"""Keys of the terminal (ui-guide section 3): one table, from which bindings, key line and help come."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Key:
    """An action of the application, its keys (Textual's names) and what help says of it."""

    action: str
    keys: str
    shown: str
    english: str
    german: str
    everywhere: bool = False  # taken before a dialog or text field sees the key
    page: str = ""  # the page on which it counts; empty: on all

    @property
    def target(self) -> str:
        """The action as Textual's bindings name it."""
        name, _, rest = self.action.rstrip(")").partition("(")
        return f"on_page('{self.page}','{name}',({rest}{',' if rest else ''}))" if self.page else self.action


KEYS: tuple[Key, ...] = (
    Key("hold", "space", "Space", "feed hold, any time", "Vorschub-Halt, jederzeit", everywhere=True),
    Key(
        "escape",
        "escape",
        "Esc",
        "hold, also in text fields; leaves a dialog",
        "Halt, auch in Feldern",
        everywhere=True,
    ),
    Key("start", "r", "r", "cycle start, resume", "NC-Start, weiter"),
    Key("step", "t", "t", "step one block (single block on)", "Einzelschritt (Einzelsatz ein)"),
    Key("single_block", "b", "b", "single block on/off", "Einzelsatz ein/aus"),
    Key("override(5)", "plus_sign,plus", "+", "feed override 5 % up", "Vorschubkorrektur +5 %"),
    Key("override(-5)", "minus,hyphen", "-", "feed override 5 % down", "Vorschubkorrektur -5 %"),
    Key("override_full", "asterisk", "*", "feed override 100 %", "Vorschubkorrektur 100 %"),
    Key("rapid(-1)", "less_than_sign", "<", "rapid override down: 100, 50, 25 %", "Eilgangkorrektur -: 100, 50, 25 %"),
    Key("rapid(1)", "greater_than_sign", ">", "rapid override up", "Eilgangkorrektur +"),
    Key("switch('optional_stop')", "o", "o", "optional stop M01 on/off", "wahlweiser Halt M01 ein/aus"),
    Key("switch('skip')", "slash", "/", "block skip on/off", "Satz ausblenden ein/aus"),
    Key("switch('dry_run')", "d", "d", "dry-run feed on/off (standstill)", "Probelaufvorschub (im Stillstand)"),
    Key("dry_feed", "D", "D", "dry-run feed in mm/min (standstill)", "Probelaufvorschub als Wert (im Stillstand)"),
    Key("switch('program_test')", "p", "p", "program test on/off (standstill)", "Programmtest (im Stillstand)"),
    Key("override_value", "equals_sign", "=", "feed override by value", "Vorschubkorrektur als Wert"),
    Key("speed(-1)", "comma", ",", "simulation slower", "Simulation langsamer"),
    Key("speed(1)", "full_stop", ".", "simulation faster, up to max", "Simulation schneller, bis max"),
    Key(
        "reset", "ctrl+x", "^X Enter", "reset: abort, spooler dropped", "Reset: Abbruch, Spooler leer", everywhere=True
    ),
    Key("confirm", "enter", "Enter", "confirms what was announced", "bestätigt Angekündigtes"),
    Key(
        "complete",
        "tab",
        "Tab",
        "jobs: take the file into the field",
        "Aufträge: Datei ins Feld",
        everywhere=True,
        page="jobs",
    ),
    Key("list", "ctrl+l", "^L", "jobs: files, recent, queue", "Aufträge: Liste", everywhere=True, page="jobs"),
    Key("queue", "ctrl+n", "^N", "jobs: into or out of queue", "Aufträge: Folge ein/aus", everywhere=True, page="jobs"),
    Key(
        "earlier",
        "ctrl+p,shift+up",
        "^P Shift+Up",
        "jobs: queue, entry up",
        "Aufträge: Folge, Eintrag auf",
        everywhere=True,
        page="jobs",
    ),
    Key(
        "later",
        "ctrl+d,shift+down",
        "^D Shift+Down",
        "jobs: queue, entry down",
        "Aufträge: Folge, Eintrag ab",
        everywhere=True,
        page="jobs",
    ),
    Key("run_queue", "ctrl+r", "^R", "jobs: run the queue", "Aufträge: Folge fahren", everywhere=True, page="jobs"),
    Key(
        "stop_at_failure",
        "ctrl+t",
        "^T",
        "jobs: queue stops at failure",
        "Aufträge: Halt bei Fehler",
        everywhere=True,
        page="jobs",
    ),
    Key("view", "v", "v", "view: program+path, path, values", "Sicht: Programm+Bahn, Bahn, Werte", page="run"),
    Key("fit", "f", "f", "whole path in the picture", "ganze Bahn im Bild", page="run"),
    Key("plane", "s", "s", "side of the path: XY, XZ, YZ, ISO", "Seite der Bahn: XY, XZ, YZ, ISO", page="run"),
    Key("zoom(1)", "0", "0", "zoom in (wheel too)", "Bild größer (auch Mausrad)", page="run"),
    Key("zoom(-1)", "9", "9", "zoom out", "Bild kleiner", page="run"),
    Key(
        "pan(-1,0)",
        "shift+left",
        "Shift+arrows",
        "pan the picture (or drag)",
        "Bild schieben (oder ziehen)",
        page="run",
    ),
    Key("pan(1,0)", "shift+right", "", "", "", page="run"),
    Key("pan(0,1)", "shift+up", "", "", "", page="run"),
    Key("pan(0,-1)", "shift+down", "", "", "", page="run"),
    Key("scroll(-1)", "up", "Up/Down", "program, list: by a line", "Programm, Liste: zeilenweise"),
    Key("scroll(1)", "down", "", "", ""),
    Key("scroll(-20)", "pageup", "PgUp/PgDn", "program, list: by a page", "Programm, Liste: seitenweise"),
    Key("scroll(20)", "pagedown", "", "", ""),
    Key("seek(-5)", "u", "u m", "replay: 5 s back, on (G: to a place)", "Replay: 5 s zurück, vor (G: Ort)", page="run"),
    Key("seek(5)", "m", "", "", "", page="run"),
    Key("current", "c", "c", "back to the current block", "zurück zum laufenden Satz", page="run"),
    Key("start_at", "G", "G", "start at block (shows the state, asks)", "Satzsuchlauf (zeigt Zustand, fragt)"),
    Key("find", "ctrl+f", "^F", "find text in the program", "Text im Programm suchen"),
    Key("goto", "g", "g", "go to block or line", "gehe zu Satz oder Zeile"),
    Key("acknowledge", "delete", "Del", "alarms: acknowledge", "Störungen: quittieren", page="alarms"),
    Key("export", "e", "e", "report: write the HTML folder", "Bericht: HTML-Ordner schreiben", page="report"),
    Key("compare", "c", "c", "report: compare with before", "Bericht: Vergleich mit früher", page="report"),
    Key("replay", "P", "P", "report: replay of the last recording", "Bericht: Replay der Aufzeichnung", page="report"),
    Key("next_message", "n", "n", "next message", "nächste Meldung"),
    Key("show('help')", "f1,1,question_mark", "F1 1 ?", "this page", "diese Seite"),
    Key("show('jobs')", "f2,2", "F2 2", "jobs: open and check", "Aufträge: öffnen, prüfen"),
    Key("show('run')", "f3,3", "F3 3", "run", "Lauf"),
    Key("show('manual')", "f4,4", "F4 4", "manual: jog, home, work zero", "Einrichten: Tippen, Referenz, Nullpunkt"),
    Key("show('mdi')", "f5,5", "F5 5", "MDI: one block at a time", "Handeingabe: Satz für Satz"),
    Key("jog_on", "j", "j", "manual: jog on/off", "Einrichten: Tippen ein/aus", page="manual"),
    Key("way(-1)", "left", "arrows PgUp/Dn", "manual: one step", "Einrichten: ein Schritt", page="manual"),
    Key("way(1)", "right", "", "", "", page="manual"),
    Key("size", "i", "i", "manual: step 0.001 .. 10 mm", "Einrichten: Schritt 0.001 .. 10 mm", page="manual"),
    Key("next_axis", "tab", "Tab", "manual: next axis", "Einrichten: nächste Achse", everywhere=True, page="manual"),
    Key("axis('X')", "x", "x y z a", "manual: select axis", "Einrichten: Achse wählen", page="manual"),
    Key("axis('Y')", "y", "", "", "", page="manual"),
    Key("axis('Z')", "z", "", "", "", page="manual"),
    Key("axis('A')", "a", "", "", "", page="manual"),
    Key("home", "h", "h", "manual: home axis (asks)", "Einrichten: Referenzfahrt (fragt)", page="manual"),
    Key("home_all", "H", "H", "manual: home all (asks)", "Einrichten: alle Achsen (fragt)", page="manual"),
    Key("zero", "w", "w", "manual: set work zero (asks)", "Einrichten: Nullpunkt setzen (fragt)", page="manual"),
    Key("input", "e", "e", "manual: force an input (asks)", "Einrichten: Eingang erzwingen (fragt)", page="manual"),
    Key("release", "E", "E", "release forced inputs", "erzwungene Eingänge freigeben"),
    Key("show('alarms')", "f6,6", "F6 6", "alarms and log", "Störungen und Protokoll"),
    Key("show('report')", "f7,7", "F7 7", "report of the last run", "Bericht des letzten Laufs"),
    Key("show('service')", "f8,8", "F8 8", "axes, status bits", "Achsen, Statusbits"),
    Key("ask_quit", "ctrl+q", "^Q", "quit (asks)", "beenden (fragt)", everywhere=True),
)

#: Key line: (key, English, German); the narrow one drops the last ones that do not fit.
KEY_LINE = (
    ("SPACE", "Hold", "Halt"),
    ("r", "Start", "Start"),
    ("t", "Step", "Schritt"),
    ("b", "SB", "Einzel"),
    ("+ -", "Ovr", "Korr"),
    ("v", "View", "Sicht"),
    ("F1", "Help", "Hilfe"),
    ("F4", "Man", "Einr."),
    ("F6", "Alm", "Stör."),
    ("^X", "Reset", "Reset"),
    ("F2", "Jobs", "Auftr."),
    ("F5", "MDI", "MDI"),
    ("F7", "Report", "Bericht"),
    ("F3", "Run", "Lauf"),
    ("F8", "Service", "Service"),
    ("g", "Block", "Satz"),
    ("^Q", "Quit", "Ende"),
)

#: Motion keys that waited longer than this in the queue are dropped (ui-guide section 3), s.
LATE_S = 0.25
#: A dialog ignores keys that came this soon after it appeared, s.
SETTLE_S = 0.3
