"""Texts of the line mode alone, English and German; those that the screen has too stand in `words.py`."""

from __future__ import annotations

PLAIN_TEXTS: dict[str, tuple[str, str]] = {
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
    "plain_near": ("{text}: no such command; nearest: {near}", "{text}: kein Befehl; am nächsten: {near}"),
    "plain_yes": ("Type: yes (anything else leaves it)", "Eingeben: ja (alles andere lässt es)"),
    "plain_not_asked": ("Nothing was asked.", "Es war nichts gefragt."),
    "plain_usage": ("Type: {way}", "Eingeben: {way}"),
    "plain_jog_step": ("{axis}: jog step {step:g} {unit}", "{axis}: Schritt beim Tippen {step:g} {unit}"),
    "plain_jog_bad": ("{text}: no step from {low:g} to {most:g}.", "{text}: kein Schritt von {low:g} bis {most:g}."),
    "plain_jogs": ("{axis} jogs {distance:+g} {unit}", "{axis} tippt {distance:+g} {unit}"),
    "plain_jog_moves": ("Dropped: a step is under way; wait first.", "Verworfen: ein Schritt läuft noch; erst warte."),
    "plain_zero_now": (
        "{axis}: G54 zero {zero:+.4f}, program coordinate {at:+.4f}",
        "{axis}: Nullpunkt G54 {zero:+.4f}, Programmkoordinate {at:+.4f}",
    ),
    "plain_mdi_nothing": (
        "No block is checked. Type: mdi BLOCK; start job starts the job.",
        "Kein Satz ist geprüft. Eingeben: mdi SATZ; los auftrag startet den Auftrag.",
    ),
    "plain_register": ("{register} {number} {name}: {text}", "{register} {number} {name}: {text}"),
    "plain_bits_none": ("{register}: no bit is set", "{register}: kein Bit ist gesetzt"),
    "plain_loop": (
        "{axis}: spooler {spooler}, {entries} entries, {free} bytes free, jovr {override:.0f} %, mpe {mpe:g} {unit}",
        "{axis}: Spooler {spooler}, {entries} Einträge, {free} Byte frei, jovr {override:.0f} %, mpe {mpe:g} {unit}",
    ),
    "plain_no_answer": (
        "The controller has not answered yet; again.",
        "Die Steuerung hat noch nicht geantwortet; nochmals.",
    ),
    "plain_variables_none": ("All common variables are 0.", "Alle gemeinsamen Variablen sind 0."),
    "plain_inputs": ("inputs on: {inputs}; outputs on: {outputs}", "Eingänge ein: {inputs}; Ausgänge ein: {outputs}"),
    "plain_dry_on": ("dry-run feed on: {feed:g} mm/min", "Probelaufvorschub ein: {feed:g} mm/min"),
    "plain_dry_off": ("dry-run feed off", "Probelaufvorschub aus"),
    "plain_queue_none": (
        "The queue is empty. Type: queue add PATH",
        "Die Folge ist leer. Eingeben: folge dazu PFAD",
    ),
    "plain_queue_file": ("{path}: no such file", "{path}: keine solche Datei"),
    "plain_queue_number": (
        "{text}: no number of the queue, or it runs",
        "{text}: keine Nummer der Folge, oder er läuft",
    ),
}
