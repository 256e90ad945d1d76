"""Texts of the terminal, English and German, in one table (terms: ui-guide section 9)."""

from __future__ import annotations

TEXTS: dict[str, tuple[str, str]] = {
    "cnc_task": ("CNC task", "CNC-Task"),
    "task_runs": ("runs", "läuft"),
    "task_waits": ("waits", "wartet"),
    "task_step": ("before a step", "vor einem Schritt"),
    "task_halted": ("halted at writeln", "hält bei writeln"),
    "task_rests": ("at rest", "in Ruhe"),
    "task_error": ("RUNTIME ERROR", "LAUFZEITFEHLER"),
    "debug_keys": (
        " s step  o over  c go  a all go  p pause  b breakpoint  up/down  t task  q quit",
        " s Schritt o darüber c weiter a alle p Pause b Haltepunkt auf/ab t Task q Ende",
    ),
    "actual": ("ACTUAL", "IST"),
    "to_go": ("TO GO", "RESTWEG"),
    "command": ("COMMAND", "SOLL"),
    "follow": ("FOLLOW um", "SCHLEPP um"),
    "limit": ("limit", "Grenze"),
    "path": ("PATH", "BAHN"),
    "time": ("TIME", "ZEIT"),
    "override": ("OVR", "KORR"),
    "set": ("set", "Soll"),
    "effective": ("eff", "Ist"),
    "low": ("override low", "Korrektur klein"),
    "deviation": ("DEV", "ABW"),
    "now": ("now", "jetzt"),
    "tolerance": ("tol", "Tol"),
    "spool": ("SPOOL", "SPOOL"),
    "empty_in": ("empty in", "leer in"),
    "auto": ("AUTO", "AUTO"),
    "live": ("LIVE {hz:.0f} Hz", "LIVE {hz:.0f} Hz"),
    "lag": ("LAG {seconds:.1f} s", "VERZUG {seconds:.1f} s"),
    "stale": ("no news for {seconds:.0f} s", "seit {seconds:.0f} s keine Werte"),
    "plot_head": ("PATH {plane}  colour/glyph = deviation", "BAHN {plane}  Farbe/Zeichen = Abweichung"),
    "plot_head_short": ("PATH {plane}", "BAHN {plane}"),
    "plot_keys": ("[v]iew [f]it", "[v] Sicht [f] Alles"),
    "todo": ("to do", "offen"),
    "tool": ("tool", "Werkzeug"),
    "no_job": ("No job. F2 opens, or: cnc-front tui part.nc", "Kein Auftrag. F2 öffnet, oder: cnc-front tui teil.nc"),
    "warning_1": ("! 1 warning", "! 1 Warnung"),
    "warnings": ("! {n} warnings", "! {n} Warnungen"),
    "alarm_n": ("!! {n} alarms", "!! {n} Störungen"),
    "too_small": ("too small, need 80x24", "zu klein, braucht 80x24"),
    "start_line": (
        "Simulation. A terminal is no emergency stop; the hard-wired chain stays.",
        "Simulation. Ein Terminal ist kein Not-Aus; die verdrahtete Kette bleibt.",
    ),
    "details": ("n: next", "n: weiter"),
    "loading": ("loading {name} ...", "lade {name} ..."),
    "loaded": ("{name}: {lines} lines, {path:.1f} mm", "{name}: {lines} Zeilen, {path:.1f} mm"),
    "load_failed": ("{id} {place} {text}", "{id} {place} {text}"),
    "more_errors": ("(+{n} more, F2)", "(+{n} weitere, F2)"),
    "deviation_over": (
        "W204 {block} path deviation {um:.1f} um > {limit:g} um",
        "W204 {block} Bahnabweichung {um:.1f} um > {limit:g} um",
    ),
    "tolerance_of": ("(tolerance of the machine)", "(Toleranz der Maschine)"),
    "runs_already": ("The job runs already.", "Der Auftrag läuft schon."),
    "brakes": ("Brakes on the path; r when it stands.", "Bremst auf der Bahn; r, wenn sie steht."),
    "no_start_alarm": ("Alarm: cure the cause, ^X Enter resets, then r.", "Störung: beheben, ^X Enter, dann r."),
    "no_step": ("Step works from standstill: Space first.", "Einzelschritt nur im Stillstand: erst Leertaste."),
    "dropped": ("Key came late and was dropped; press again.", "Taste kam zu spät und gilt nicht; nochmals drücken."),
    "reset_armed": (
        "Reset drops the spooler; the job starts again from the top. Homing stays. Enter within 3 s.",
        "Reset leert den Spooler; Auftrag beginnt von vorn. Referenz bleibt. Enter in 3 s.",
    ),
    "reset_done": (
        "ABORT: braked on the path, spooler dropped; r starts from the top.",
        "ABBRUCH: auf der Bahn gebremst, Spooler leer; r beginnt von vorn.",
    ),
    "hold_hup": ("Terminal closed: HOLD.", "Terminal geschlossen: HALT."),
    "hold_text": ("HOLD on the path; r goes on.", "HALT auf der Bahn; r fährt weiter."),
    "step_text": ("BLOCK END; r or t goes on.", "SATZENDE; r oder t fährt weiter."),
    "stopped_M06": ("M06: tool T{tool} in? Then r.", "M06: Werkzeug T{tool} gewechselt? Dann r."),
    "stopped_M00": ("M00: program stop; r goes on.", "M00: Programmhalt; r fährt weiter."),
    "stopped_M01": ("M01: optional stop; r goes on.", "M01: wahlweiser Halt; r fährt weiter."),
    "stopped": ("{why}: waits for the operator; r goes on.", "{why}: wartet auf den Bediener; r fährt weiter."),
    "waiting": ("Waits: {why}", "Wartet: {why}"),
    "goto": ("Go to block (N620) or line (12):", "Gehe zu Satz (N620) oder Zeile (12):"),
    "goto_none": ("{text}: no such block.", "{text}: kein solcher Satz."),
    "goto_job": ("No program to search.", "Kein Programm zum Suchen."),
    "override_ask": ("Feed override in % ({low}..{high}):", "Vorschubkorrektur in % ({low}..{high}):"),
    "override_bad": ("{text}: not a number from {low} to {high}.", "{text}: keine Zahl von {low} bis {high}."),
    "quit_ask": (
        "Quit cnc-front? The simulated machine ends with it.",
        "Beenden? Die simulierte Maschine endet damit.",
    ),
    "quit_runs": ("A job is under way ({state}).", "Ein Auftrag ist in Arbeit ({state})."),
    "quit_keys": ("Enter quits   Esc stays (and holds)", "Enter beendet   Esc bleibt (und hält an)"),
    "field_keys": ("Enter takes it   Esc leaves (and holds)", "Enter übernimmt   Esc verlässt (und hält an)"),
    "jobs_title": ("JOBS  open by path:", "AUFTRÄGE  öffnen mit Pfad:"),
    "jobs_keys": ("Up/Down choose   Tab into name   Enter opens", "Auf/Ab wählen   Tab übernimmt Namen   Enter öffnet"),
    "jobs_none": ("no file begins with this", "keine Datei beginnt so"),
    "check": ("CHECK of {name}", "PRÜFUNG von {name}"),
    "check_extents": ("axis    from          to", "Achse   von           bis"),
    "check_clean": ("no errors, {n} warnings", "keine Fehler, {n} Warnungen"),
    "check_bad": ("not loaded: {n} errors", "nicht geladen: {n} Fehler"),
    "check_time": (
        "machine time {time}   path {path:.1f} mm   {lines} lines",
        "Maschinenzeit {time}   Bahn {path:.1f} mm   {lines} Zeilen",
    ),
    "dwell": ("dwell", "Verweilzeit"),
    "hint": ("hint:", "Hinweis:"),
    "alarms_title": ("ALARMS  active", "STÖRUNGEN  aktiv"),
    "alarms_none": ("none", "keine"),
    "log_title": ("LOG of this session, newest first", "PROTOKOLL dieser Sitzung, neueste zuerst"),
    "alarm_head": (
        " time       machine s code axis block   state   cause, remedy",
        " Zeit      Maschine s Code Achs Satz    Zustand Ursache, Abhilfe",
    ),
    "alarms_keys": ("Up/Down n choose  Del acknowledges", "Auf/Ab n wählen  Entf quittiert"),
    "alarm_active": ("ACTIVE", "AKTIV"),
    "alarm_gone": ("gone", "behoben"),
    "acknowledged": ("acknowledged", "quittiert"),
    "ack_none": ("No alarm to acknowledge.", "Keine Störung zu quittieren."),
    "ack_refused": (
        "{code} {axis}: the cause is still there ({name}); cure it first.",
        "{code} {axis}: die Ursache besteht noch ({name}); erst beheben.",
    ),
    "ack_done": ("{code} {axis} acknowledged.", "{code} {axis} quittiert."),
    "earlier_title": ("BEFORE this session", "VOR dieser Sitzung"),
    "alarms_count": ("alarms", "Störungen"),
    "report_title": ("REPORT", "BERICHT"),
    "report_none": ("No run has ended yet; r starts the job.", "Noch kein Lauf zu Ende; r startet den Auftrag."),
    "report_keys": ("Enter shows block  e export  c compare", "Enter zeigt Satz  e Export  c Vergleich"),
    "worst_head": (
        "WORST      max um   RMS um  of limit  block",
        "GRÖSSTE    max um   RMS um  d. Grenze Satz",
    ),
    "feed_reached": ("feed reached", "Vorschub erreicht"),
    "plot_deviation": ("DEVIATION over path length, um", "ABWEICHUNG über der Bahnlänge, um"),
    "plot_velocity": ("PATH VELOCITY over time, mm/min", "BAHNGESCHWINDIGKEIT über der Zeit, mm/min"),
    "plot_histogram": ("SAMPLES by deviation, um", "ABTASTUNGEN nach Abweichung, um"),
    "compare_none": ("No earlier run of this job in the history.", "Kein früherer Lauf dieses Auftrags im Verlauf."),
    "compare_head": (
        "COMPARED with run {number} of {date}, {verdict}",
        "VERGLEICH mit Lauf {number} vom {date}, {verdict}",
    ),
    "compare_columns": (
        "                           now         before         change",
        "                         jetzt         früher       Änderung",
    ),
    "compare_new": ("new among the worst", "neu unter den größten"),
    "compare_gone": ("no longer among them", "nicht mehr darunter"),
    "export_ask": ("Folder for the report (Enter: {folder}):", "Ordner für den Bericht (Enter: {folder}):"),
    "exporting": ("writing {folder} ...", "schreibe {folder} ..."),
    "exported": ("report: {folder}/report.html", "Bericht: {folder}/report.html"),
    "service_title": ("SERVICE  axes as the controller reports them", "SERVICE  Achsen, wie die Steuerung sie meldet"),
    "service_head": (
        "axis   command      actual   follow      mpe   spool  status bits",
        "Achse     Soll         Ist  Schlepp      mpe   Spool  Statusbits",
    ),
    "not_referenced": ("NOT HOMED", "nicht referenziert"),
    "help_title": ("HELP  keys", "HILFE  Tasten"),
    "help_stop": (
        "A terminal is no emergency stop: keep the hard-wired chain.",
        "Ein Terminal ist kein Not-Aus: die verdrahtete Kette bleibt.",
    ),
    "help_states": ("States", "Zustände"),
    "help_scroll": ("Up/Down scroll   F3 Run", "Auf/Ab blättern   F3 Lauf"),
    "plain_hello": (
        "Line mode: help lists the commands; an empty line holds.",
        "Zeilenmodus: hilfe nennt die Befehle; eine leere Zeile hält an.",
    ),
    "plain_unknown": ("{text}: no such command; help lists them.", "{text}: kein Befehl; hilfe nennt sie."),
    "plain_hold": ("Hold asked for.", "Halt angefordert."),
    "plain_reset": (
        "Reset drops the spooler; the job starts again from the top. Type: reset yes",
        "Reset leert den Spooler; der Auftrag beginnt von vorn. Eingeben: abbruch ja",
    ),
    "plain_quit": (
        "A job is under way: held. Type: quit yes",
        "Ein Auftrag ist in Arbeit: angehalten. Eingeben: ende ja",
    ),
    "plain_single_on": ("single block on", "Einzelsatz ein"),
    "plain_single_off": ("single block off", "Einzelsatz aus"),
    "plain_speed_bad": ("{text}: no speed from 1 to 1000, or max.", "{text}: kein Tempo von 1 bis 1000, oder max."),
    "plain_every_bad": ("{text}: no number of seconds from 0 to 3600.", "{text}: keine Sekunden von 0 bis 3600."),
    "plain_axis": (
        "{axis}: actual {values[0]:+.4f} {unit}, command {values[1]:+.4f}, to go {values[2]:.4f}, "
        "following {values[3]:+.1f} um",
        "{axis}: Ist {values[0]:+.4f} {unit}, Soll {values[1]:+.4f}, Restweg {values[2]:.4f}, "
        "Schleppfehler {values[3]:+.1f} um",
    ),
    "speed": ("simulation speed {speed}", "Simulationstempo {speed}"),
    "job_busy": ("A job is under way; ^X Enter ends it first.", "Auftrag in Arbeit; erst ^X Enter."),
}


class Words:
    """Looks texts up in one language."""

    def __init__(self, language: str = "en") -> None:
        self.language = language
        self._column = 1 if language == "de" else 0

    def __call__(self, id: str, /, **facts: object) -> str:
        """The text of an id with its facts filled in."""
        return TEXTS[id][self._column].format(**facts)

    def pick(self, english: str, german: str) -> str:
        """One of two texts that stand in a table of their own."""
        return (english, german)[self._column]
