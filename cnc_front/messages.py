"""Texts that operators see, English and German, in one table. Ids are stable; texts are translated."""

from __future__ import annotations

import os
from typing import Any

LANGUAGES = ("en", "de")

TEXTS: dict[str, tuple[str, str]] = {
    "warnings": ("{count} warnings of the compiler", "{count} Warnungen des Übersetzers"),
    "tolerance": (
        "contour deviation {max_um:.1f} um > {limit_um:.1f} um at line {line}",
        "Bahnabweichung {max_um:.1f} um > {limit_um:.1f} um in Zeile {line}",
    ),
    "setpoint": (
        "set point leaves the programmed path by {max_um:.4f} um at line {line}",
        "Sollwert verlässt die programmierte Bahn um {max_um:.4f} um in Zeile {line}",
    ),
    "incomplete": (
        "the run ended {missing_mm:.3f} mm before the end of the path, at line {line}",
        "der Lauf endete {missing_mm:.3f} mm vor dem Bahnende, in Zeile {line}",
    ),
    "reference": (
        "deviation from the drawing {max_um:.1f} um > {limit_um:.1f} um at line {line}",
        "Abweichung von der Zeichnung {max_um:.1f} um > {limit_um:.1f} um in Zeile {line}",
    ),
    "reference_missing": (
        "{missing_mm:.2f} mm of the drawing ({missing_pct:.2f} %) were not driven",
        "{missing_mm:.2f} mm der Zeichnung ({missing_pct:.2f} %) wurden nicht gefahren",
    ),
    "reference_far": (
        "no cutting move comes within {capture_mm:g} mm of the drawing; see --reference-at, -unit, -offset",
        "kein Vorschubsatz kommt der Zeichnung auf {capture_mm:g} mm nahe; siehe --reference-at, -unit, -offset",
    ),
    "reference_side": (
        "{length_mm:.2f} mm were driven on the wrong side of the drawing",
        "{length_mm:.2f} mm wurden auf der falschen Seite der Zeichnung gefahren",
    ),
    "collision": (
        "{kind} {body}, tool {tool}, at line {line}, {t_s:.3f} s: {size_mm:.3f} mm",
        "{kind} {body}, Werkzeug {tool}, in Zeile {line}, {t_s:.3f} s: {size_mm:.3f} mm",
    ),
    "tool_fixture": ("tool meets fixture", "Werkzeug trifft Spannmittel"),
    "holder_fixture": ("holder meets fixture", "Halter trifft Spannmittel"),
    "holder_stock": ("holder or shank meets", "Halter oder Schaft trifft"),
    "rapid_stock": ("rapid through", "Eilgang durch"),
    "flutes_stock": ("cut deeper than the flutes:", "tiefer als die Schneiden:"),
    "stock": ("stock", "Rohteil"),
    "gouge": (
        "gouge of {max_um:.1f} um > {limit_um:.1f} um at X {X:.3f} Y {Y:.3f}, line {line}",
        "Untermaß {max_um:.1f} um > {limit_um:.1f} um bei X {X:.3f} Y {Y:.3f}, Zeile {line}",
    ),
    "rest": (
        "rest of {max_um:.1f} um > {limit_um:.1f} um at X {X:.3f} Y {Y:.3f}, line {line}",
        "Restmaterial {max_um:.1f} um > {limit_um:.1f} um bei X {X:.3f} Y {Y:.3f}, Zeile {line}",
    ),
    "from_drawing": ("from the drawing", "von der Zeichnung"),
    "not_driven": ("not driven", "nicht gefahren"),
    "extra": ("not of the drawing", "nicht aus der Zeichnung"),
    "collisions": ("collisions", "Kollisionen"),
    "gouge_word": ("gouge", "Untermaß"),
    "rest_word": ("rest", "Restmaterial"),
    "removed": ("material removed", "abgetragen"),
    "against_target": ("against the target", "gegen das Fertigteil"),
    "alarm": (
        "alarm {name} {axis} at {t_s:.3f} s, line {line}",
        "Störung {name} {axis} bei {t_s:.3f} s, Zeile {line}",
    ),
    "alarm_idle": ("alarm {name} {axis} at {t_s:.3f} s", "Störung {name} {axis} bei {t_s:.3f} s"),
    "alarm_nowhere": ("alarm {name} {axis} at {t_s:.3f} s", "Störung {name} {axis} bei {t_s:.3f} s"),
    "fault_nowhere": (
        "stopped by fault {name} {axis} at {t_s:.3f} s, {place}",
        "angehalten durch Störung {name} {axis} bei {t_s:.3f} s, {place}",
    ),
    "fault": (
        "stopped by fault {name} {axis} at {t_s:.3f} s, line {line}, {place}",
        "angehalten durch Störung {name} {axis} bei {t_s:.3f} s, Zeile {line}, {place}",
    ),
    "task_error": ("runtime error {errnum} at line {line}", "Laufzeitfehler {errnum} in Zeile {line}"),
    "sap_error": (
        "task {task}: runtime error {errnum:04X} hex at line {line}",
        "Task {task}: Laufzeitfehler {errnum:04X} hex in Zeile {line}",
    ),
    "sap_tolerance": (
        "contour deviation {max_um:.1f} um > {limit_um:.1f} um, task {task}, line {line}",
        "Bahnabweichung {max_um:.1f} um > {limit_um:.1f} um, Task {task}, Zeile {line}",
    ),
    "sap_setpoint": (
        "set point leaves the spooled path by {max_um:.4f} um > {limit_um:.4f} um, task {task}, line {line}",
        "Sollwert verlässt die gespoolte Bahn um {max_um:.4f} um > {limit_um:.4f} um, Task {task}, Zeile {line}",
    ),
    "sap_apart": (
        "task {task}, line {line}: its axes execute other commands at the same time; spool for all axes of a contour",
        "Task {task}, Zeile {line}: seine Achsen führen zugleich anderes aus; für alle Achsen einer Kontur spoolen",
    ),
    "sap_cut": (
        "task {task}: the contour was broken off at line {line}",
        "Task {task}: die Kontur wurde in Zeile {line} abgebrochen",
    ),
    "listing_refused": ("what was spooled is no path: {text}", "was gespoolt wurde, ist keine Bahn: {text}"),
    "sap_no_contour": (
        "none: no motion command was spooled; direct moves have no programmed contour",
        "keine: nichts wurde gespoolt; direkte Bewegungen haben keine programmierte Kontur",
    ),
    "sap_measured": (
        "measured for {seconds:.3f} s; direct moves have no programmed contour",
        "gemessen über {seconds:.3f} s; direkte Bewegungen haben keine programmierte Kontur",
    ),
    "sap_at": ("at task {task}, line {line}", "bei Task {task}, Zeile {line}"),
    "sap_groups": ("groups of axes", "Achsgruppen"),
    "commands": ("commands", "Befehle"),
    "sap_goes_on": ("task {task} is at line {line}", "Task {task} ist in Zeile {line}"),
    "task": ("task", "Task"),
    "position": ("position", "Position"),
    "time_limit": (
        "time limit of {seconds:g} s reached (--max-time)",
        "Zeitgrenze von {seconds:g} s erreicht (--max-time)",
    ),
    "cut_off": (
        "the recording ends at {t_s:.3f} s, before its result",
        "die Aufzeichnung endet bei {t_s:.3f} s, vor ihrem Ergebnis",
    ),
    "running": ("running, machine time {seconds:.0f} s", "läuft, Maschinenzeit {seconds:.0f} s"),
    "interrupted": ("interrupted", "abgebrochen"),
    "time": ("machine time", "Maschinenzeit"),
    "path": ("path", "Bahn"),
    "deviation": ("contour deviation", "Bahnabweichung"),
    "setpoint_deviation": ("set point deviation", "Sollwertabweichung"),
    "following": ("following error", "Schleppfehler"),
    "feed": ("feed reached", "Vorschub erreicht"),
    "possible": ("time-optimal", "zeitoptimal"),
    "less": ("less", "weniger"),
    "limited": ("limited by", "begrenzt durch"),
    "merged": ("merged blocks", "zusammengefasste Sätze"),
    "override": ("override", "Vorschubkorrektur"),
    "at_line": ("at line {line}", "in Zeile {line}"),
    "limit": ("limit", "Grenze"),
    "of_time": ("of feed time", "der Vorschubzeit"),
    "recording": ("recording", "Aufzeichnung"),
    "report": ("report", "Bericht"),
    "machine": ("machine", "Maschine"),
    "stimulus": ("stimulus", "Stimulus"),
    "builtin": ("built-in", "eingebaut"),
    "check_ok": ("{path}: no errors, {warnings} warnings", "{path}: keine Fehler, {warnings} Warnungen"),
    "check_bad": ("{path}: {errors} errors, {warnings} warnings", "{path}: {errors} Fehler, {warnings} Warnungen"),
    "more_warnings": (
        "{count} more {which} (cnc-front check names them all)",
        "{count} weitere {which} (cnc-front check nennt alle)",
    ),
    "start": (
        "start at line {line}: {modal}\n  position {position}\n  machine  {machine}\n  offset   {offset}\n"
        "  tool {tool}, length {length} mm; spindle {spindle}; coolant {coolant}; {feed}",
        "Start in Zeile {line}: {modal}\n  Position  {position}\n  Maschine  {machine}\n  Nullpunkt {offset}\n"
        "  Werkzeug {tool}, Länge {length} mm; Spindel {spindle}; Kühlmittel {coolant}; {feed}",
    ),
    "hint": ("hint", "Hinweis"),
    "history_unusable": (
        "CF501 {path}: the history cannot be used: {reason}; --history FILE chooses another, --history off none",
        "CF501 {path}: der Verlauf ist nicht benutzbar: {reason}; --history DATEI wählt einen anderen, off keinen",
    ),
    "history_damaged": (
        "CF502 {path}: damaged, or no history: {reason}; move it away, a new one is made",
        "CF502 {path}: beschädigt oder kein Verlauf: {reason}; verschieben, ein neuer wird angelegt",
    ),
    "history_newer": (
        "CF503 {path}: version {version} of a later cnc-front, this one knows {known}; --history FILE chooses another",
        "CF503 {path}: Version {version} eines neueren cnc-front (hier {known}); --history DATEI wählt einen anderen",
    ),
    "history_none": ("no runs in {path}", "keine Läufe in {path}"),
    "history_no_alarms": ("no alarms in {path}", "keine Störungen in {path}"),
    "history_job": ("job", "Auftrag"),
    "history_head": (
        "number  date              {job}  verdict   max um  at               time   alarms  by",
        "Nummer  Datum             {job}  Urteil    max um  bei              Zeit   Störg.  von",
    ),
    "history_alarm_head": (
        "date              machine time  code  axis block    job                  text and remedy",
        "Datum             Maschinenzeit Code  Achse Satz    Auftrag              Text und Abhilfe",
    ),
    "history_line": ("line", "Zeile"),
    "history_seen": ("(acknowledged)", "(quittiert)"),
    "history_hash": ("sha256", "sha256"),
    "override_refused": (
        "override {factor:g} refused: above 0 up to 10",
        "Vorschubkorrektur {factor:g} abgelehnt: über 0 bis 10",
    ),
    "switches_refused": (
        "refused: the blocks are in the spooler already; M01, SKP, DRY and PRT change at standstill, before the start",
        "abgelehnt: die Sätze sind schon im Spooler; M01, SKP, DRY und PRT nur vor dem Start, im Stillstand",
    ),
    "replay_only": (
        "a recording is only shown: r plays, Space pauses, , . speed, u m wind, G to a time or block",
        "eine Aufzeichnung wird nur gezeigt: r spielt, Leertaste hält an, , . Tempo, u m spulen, G zu Zeit oder Satz",
    ),
    "replay_cut": (
        "the run ends early: {reason}",
        "der Lauf endet vorzeitig: {reason}",
    ),
    "replay_end": ("end of the recording, {time}: {verdict}", "Ende der Aufzeichnung, {time}: {verdict}"),
    "replay_seeks": ("seeking ...", "spult ..."),
    "replay_place": (
        "'{text}' is no time (83.5, 1:23.5, +5, -5) and no block (N620, L12)",
        "'{text}' ist keine Zeit (83.5, 1:23.5, +5, -5) und kein Satz (N620, L12)",
    ),
    "replay_block": (
        "{text} was not executed in this recording",
        "{text} wurde in dieser Aufzeichnung nicht ausgeführt",
    ),
    "replay_none": ("only a recording can be wound", "spulen kann man nur in einer Aufzeichnung"),
    "unrecorded": ("W302 the run is not recorded: {reason}", "W302 der Lauf wird nicht aufgezeichnet: {reason}"),
    "did_hold": ("operator: feed hold", "Bediener: Vorschub-Halt"),
    "did_start": ("operator: cycle start", "Bediener: NC-Start"),
    "did_resume": ("operator: goes on", "Bediener: weiter"),
    "did_step": ("operator: single step", "Bediener: Einzelschritt"),
    "did_reset": ("operator: reset", "Bediener: Reset"),
    "did_override": ("operator: feed override {value} %", "Bediener: Vorschubkorrektur {value} %"),
    "did_rapid": ("operator: rapid override {value} %", "Bediener: Eilgangkorrektur {value} %"),
    "did_single_block": ("operator: single block {value}", "Bediener: Einzelsatz {value}"),
    "hand_refused": (
        "refused: the machine is busy; ^X ends the job",
        "abgelehnt: Maschine belegt; ^X beendet den Auftrag",
    ),
    "hand_alarm": ("refused: alarm; ^X Enter resets", "abgelehnt: Störung; ^X Enter setzt zurück"),
    "jog_limit": (
        "{axis}: the step would pass the software limit",
        "{axis}: der Schritt ginge über den Software-Endschalter",
    ),
    "jog_loop": ("{axis}: the loop is open", "{axis}: der Regelkreis ist offen"),
    "jog_discarded": ("{axis}: the step was discarded", "{axis}: der Schritt wurde verworfen"),
    "hand_stopped": (
        "FAST STOP: each axis stopped on its own ramp; what moved is over",
        "SCHNELLHALT: jede Achse auf ihrer eigenen Rampe; die Bewegung ist zu Ende",
    ),
    "jogs_ended": (
        "HOLD: the jog of {axes} has ended here for good; r goes on with what is behind it",
        "HALT: das Tippen von {axes} ist hier zu Ende; r fährt mit dem fort, was danach kommt",
    ),
    "home_missing": (
        "{axes}: the machine file has no reference switch and no periodic index",
        "{axes}: die Maschinendatei hat keinen Referenzschalter und keinen periodischen Index",
    ),
    "home_failed": ("{axis}: reference not found", "{axis}: Referenz nicht gefunden"),
    "home_stuck": ("{axis}: the reference switch stays active", "{axis}: der Referenzschalter bleibt aktiv"),
    "sap_failed": ("runtime error {errnum:04X} hex", "Laufzeitfehler {errnum:04X} hex"),
    "bench_fault": ("FAST STOP: {axis} {name}", "SCHNELLHALT: {axis} {name}"),
    "load_let_go": ("not wanted any more", "nicht mehr gewünscht"),
    "no_job": ("no job is loaded", "kein Auftrag geladen"),
    "mdi_again": ("the machine has moved: Enter checks the block again", "Maschine bewegt: Enter prüft den Satz neu"),
    "checked_again": (
        "checked again from where the machine stands; r starts",
        "neu geprüft ab der jetzigen Stellung; r startet",
    ),
    "not_checked": ("not started: {finding}", "nicht gestartet: {finding}"),
    "batch_head": (
        "part|verdict|max um|at|p99|RMS|time|alarms",
        "Teil|Urteil|max um|bei|99 %|RMS|Zeit|Störg.",
    ),
    "batch_foot": ("{parts} results: {counts}; {page}", "{parts} Ergebnisse: {counts}; {page}"),
    "batch_known": ("{done} of {total} results are known", "{done} von {total} Ergebnissen sind bekannt"),
    "batch_line": (
        "[{done}/{total}, {rest:.0f} s of work left] {name} on {machine}:",
        "[{done}/{total}, noch {rest:.0f} s Arbeit] {name} auf {machine}:",
    ),
    "sweep_head": (
        "override|verdict|    time s|deviation um|path change um|ratio error %|F reached %|% of maxacc",
        "Override|Urteil |    Zeit s|Abweichung um|Bahnänderung um|Verhältnisfehler %|F erreicht %|% von maxacc",
    ),
    "tune_head": (
        "{names}  verdict    time s  deviation um    line",
        "{names}  Urteil     Zeit s  Abweichung um  Zeile",
    ),
    "tune_present": ("as it is", "wie bisher"),
    "tune_more": ("... {count} more (--json, --out)", "... {count} weitere (--json, --out)"),
    "tune_foot": (
        "* none is better in time and deviation; limit {limit_um:g} um",
        "* keiner ist in Zeit und Abweichung besser; Grenze {limit_um:g} um",
    ),
    "findings": ("findings", "Befunde"),
    "trace_setpoint": ("set point", "Sollwert"),
    "trace_actual": ("load side", "Lastseite"),
    "finding_block_shifted": (
        "block shifted by {size_um:.2f} um at line {line}",
        "Satz um {size_um:.2f} um versetzt in Zeile {line}",
    ),
    "finding_centre_off": (
        "centre of the arc off by {size_um:.2f} um at line {line}",
        "Kreismittelpunkt um {size_um:.2f} um versetzt in Zeile {line}",
    ),
    "finding_radius_off": (
        "radius of the arc off by {size_um:.2f} um at line {line}",
        "Kreisradius um {size_um:.2f} um falsch in Zeile {line}",
    ),
    "finding_axis_lags": (
        "axis {axes} lags by {samples:.2f} samples ({ms:.3f} ms), {max_um:.2f} um at line {line}",
        "Achse {axes} nacheilend um {samples:.2f} Abtastungen ({ms:.3f} ms), {max_um:.2f} um in Zeile {line}",
    ),
    "finding_axes_swapped": (
        "axes {axes} swapped, {max_um:.1f} um from line {line} on",
        "Achsen {axes} vertauscht, {max_um:.1f} um ab Zeile {line}",
    ),
    "finding_axis_reversed": (
        "axis {axes} reversed, {max_um:.1f} um from line {line} on",
        "Achse {axes} läuft verkehrt, {max_um:.1f} um ab Zeile {line}",
    ),
    "finding_reversal_error": (
        "reversal error (backlash) of axis {axes}: {size_um:.2f} um, at line {line}",
        "Umkehrspanne (Lose) der Achse {axes}: {size_um:.2f} um, in Zeile {line}",
    ),
    "finding_effradius": (
        "effradius of axis {axes} is {radius:.4f} mm instead of {programmed:.4f} mm, {max_um:.2f} um at line {line}",
        "effradius der Achse {axes} ist {radius:.4f} mm statt {programmed:.4f} mm, {max_um:.2f} um in Zeile {line}",
    ),
    "finding_axis_scale": (
        "scale of axis {axes} off by {percent:.4f} %, {max_um:.2f} um at line {line}",
        "Maßstab der Achse {axes} um {percent:.4f} % falsch, {max_um:.2f} um in Zeile {line}",
    ),
    "finding_deviation": (
        "deviation of {max_um:.2f} um without a cause that the data name, at line {line}",
        "Abweichung von {max_um:.2f} um ohne benennbare Ursache, in Zeile {line}",
    ),
    "remedy_block_shifted": (
        "the block alone is off: compare its coordinates and offsets (G54, G92, tool length) with the drawing",
        "nur dieser Satz ist versetzt: Koordinaten und Verschiebungen (G54, G92, Werkzeuglänge) mit der Zeichnung "
        "vergleichen",
    ),
    "remedy_centre_off": (
        "compare I, J, K with the drawing; mind whether they count from the start of the arc (G91.1) or absolutely",
        "I, J, K mit der Zeichnung vergleichen; zählen sie vom Anfang des Bogens (G91.1) oder absolut?",
    ),
    "remedy_radius_off": (
        "compare R or I, J, K with the drawing; with feed-forward off, a lower feed or a higher kp lets the radius "
        "shrink less",
        "R oder I, J, K mit der Zeichnung vergleichen; ohne Vorsteuerung schrumpft der Radius weniger mit kleinerem "
        "Vorschub oder größerem kp",
    ),
    "remedy_axis_lags": (
        "raise kfcv of axis {axes} (or lower that of the others) until all axes lag alike; check its drive",
        "kfcv der Achse {axes} erhöhen (oder bei den anderen senken), bis alle gleich nacheilen; Antrieb prüfen",
    ),
    "remedy_axes_swapped": (
        "axes {axes}: check the order of axes in the machine file and the cables of drives and encoders",
        "Achsen {axes}: Reihenfolge in der Maschinendatei und Kabel von Antrieben und Gebern prüfen",
    ),
    "remedy_axis_reversed": (
        "axis {axes}: check the sign of counts_per_unit, the sense of drive and encoder, and mirroring in the program",
        "Achse {axes}: Vorzeichen von counts_per_unit, Drehsinn von Antrieb und Geber, Spiegelung im Programm prüfen",
    ),
    "remedy_reversal_error": (
        "axis {axes}: take the play out of the drive train, or enter it as backlash in the machine file",
        "Achse {axes}: Spiel im Antriebsstrang beseitigen oder als Lose (backlash) in die Maschinendatei eintragen",
    ),
    "remedy_effradius": (
        "axis {axes}: enter the real effradius in the machine file, or the program's radius",
        "Achse {axes}: den wahren effradius in die Maschinendatei eintragen, oder den Radius des Programms",
    ),
    "remedy_axis_scale": (
        "axis {axes}: correct counts_per_unit (pitch, gear) in the machine file; check the unit G20/G21",
        "Achse {axes}: counts_per_unit (Steigung, Getriebe) in der Maschinendatei berichtigen; Einheit G20/G21 prüfen",
    ),
    "remedy_deviation": (
        "lower the feed at line {line} and run again: if it shrinks, it is dynamics (gains, acceleration, mdvel), if "
        "not, geometry; cnc-front tune varies gains",
        "Vorschub in Zeile {line} senken und erneut fahren: wird sie kleiner, ist es Dynamik (Regler, Beschleunigung, "
        "mdvel), sonst Geometrie; cnc-front tune variiert die Regler",
    ),
    "named_findings": ("{count} findings", "{count} Befunde"),
    "dry_feed_run": (
        "run with the dry-run feed {feed:.0f} mm/min: says nothing of the deviation with the programmed feeds",
        "mit dem Probelaufvorschub {feed:.0f} mm/min gefahren: sagt nichts über die programmierten Vorschübe",
    ),
    "log_event": ("{t_s:10.3f} s  line {line}: {kind} {text}", "{t_s:10.3f} s  Zeile {line}: {kind} {text}"),
}


def text(id: str, language: str, **values: Any) -> str:
    """The message in that language with its values filled in; `kind` and `body` may be ids of words. A `line` of
    another `file` than that of the job is told with its name."""
    if values.get("file"):
        values["line"] = f"{values['line']} ({values['file']})"
    for key in ("kind", "body"):
        if values.get(key) in TEXTS:
            values[key] = TEXTS[values[key]][LANGUAGES.index(language)]
    if values.get("line") == 0 and f"{id}_nowhere" in TEXTS:
        id = f"{id}_nowhere"  # the path was left already: there is no line 0
    return TEXTS[id][LANGUAGES.index(language)].format(**values)


def limit_text(name: str, language: str) -> str:
    """Words for a cause by its name in JSON, with the axis where it has one: `mdvel X`."""
    from motion_kernel.causes import english, german  # brings numpy, which few commands need

    cause, _, axis = name.partition(" ")
    words = german(cause) if language == "de" else english(cause)
    return f"{words}, {axis}" if axis else words


def language_from(asked: str | None, environment: dict[str, str] | None = None) -> str:
    """`--lang`, else LC_ALL, LC_MESSAGES, LANG; English where nothing says German."""
    if asked is not None:
        return asked
    env = os.environ if environment is None else environment
    for name in ("LC_ALL", "LC_MESSAGES", "LANG"):
        value = env.get(name)
        if value:
            return "de" if value.lower().startswith("de") else "en"
    return "en"
