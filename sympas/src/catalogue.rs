//! The one table of all error and warning ids: id, message and remedy in English and German.
//!
//! 3 and 91 are the manual's own numbers (5.3.2.2.2, 5.3.6.2); the others are ours: `SPnnn` errors, `SWnnn` warnings.
//! `{..}` are filled in order of appearance; both languages name them in the same order.

macro_rules! catalogue {
    ($($id:ident $name:literal $english:literal $german:literal $hint:literal $rat:literal;)*) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Id { $(#[doc = $english] $id,)* }

        /// Every id: name, message and hint in English, message and hint in German.
        pub const CATALOGUE: &[(Id, &str, [&str; 2], [&str; 2])] =
            &[$((Id::$id, $name, [$english, $hint], [$german, $rat]),)*];
    };
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Language {
    #[default]
    English,
    German,
}

impl Id {
    pub fn name(self) -> &'static str {
        CATALOGUE[self as usize].1
    }
    /// Message template and hint.
    pub fn texts(self, language: Language) -> [&'static str; 2] {
        let row = &CATALOGUE[self as usize];
        match language {
            Language::English => row.2,
            Language::German => row.3,
        }
    }
    pub fn is_warning(self) -> bool {
        self >= Id::SW901
    }
}

catalogue! {
    E3 "3" "undeclared identifier '{name}'" "nicht deklarierter Bezeichner '{name}'"
        "declare it above, in this spelling" "darüber deklarieren, in dieser Schreibweise";
    E91 "91" "result of function '{name}' is not used" "Ergebnis der Funktion '{name}' wird nicht verwendet"
        "assign it to a variable, or write a procedure" "einer Variablen zuweisen oder eine Prozedur schreiben";

    SP101 "SP101" "not a text file ({n} control bytes)" "keine Textdatei ({n} Steuerzeichen)"
        "choose the source text (.SRC), not a compiled file" "den Quelltext (.SRC) wählen, keine übersetzte Datei";
    SP102 "SP102" "illegal character '{c}' (U+{h})" "unzulässiges Zeichen '{c}' (U+{h})"
        "delete it, or type it again" "löschen oder neu eingeben";
    SP103 "SP103" "comment is not closed" "Kommentar ist nicht geschlossen" "add '}'" "'}' ergänzen";
    SP104 "SP104" "string is not closed on its line" "Zeichenkette ist in ihrer Zeile nicht geschlossen"
        "add an apostrophe at its end" "am Ende einen Apostroph ergänzen";
    SP105 "SP105" "'}' without '{'" "'}' ohne '{'"
        "delete it; comments do not nest" "löschen; Kommentare lassen sich nicht schachteln";
    SP106 "SP106" "'$' without hexadecimal digits" "'$' ohne hexadezimale Ziffern"
        "write digits 0-9, A-F behind it" "Ziffern 0-9, A-F dahinter schreiben";
    SP107 "SP107" "malformed number or name '{text}'" "ungültige Zahl oder ungültiger Name '{text}'"
        "names start with a letter; an exponent needs digits" "Namen beginnen mit einem Buchstaben; ein Exponent braucht Ziffern";
    SP108 "SP108" "source text larger than {n} MiB" "Quelltext größer als {n} MiB"
        "split the program" "das Programm aufteilen";
    SP109 "SP109" "file '{name}' cannot be read: {text}" "Datei '{name}' ist nicht lesbar: {text}"
        "check name and access rights" "Namen und Zugriffsrechte prüfen";
    SP110 "SP110" "more than {n} include levels" "mehr als {n} Include-Ebenen"
        "look for a file that includes itself" "prüfen, ob eine Datei sich selbst einfügt";
    SP111 "SP111" "unknown directive '{name}'" "unbekannte Direktive '{name}'"
        "known are $I, $TASK and $FULLSYSTEM; a comment does not start with '{$'"
        "bekannt sind $I, $TASK und $FULLSYSTEM; ein Kommentar beginnt nicht mit '{$'";
    SP112 "SP112" "directive {name}: {what} expected" "Direktive {name}: {what} erwartet"
        "write {$I file}, {$TASK 0..3} or {$FULLSYSTEM}" "{$I Datei}, {$TASK 0..3} oder {$FULLSYSTEM} schreiben";
    SP113 "SP113" "task number {n} outside 0..3" "Tasknummer {n} außerhalb 0..3"
        "there are four tasks: 0, 1, 2, 3" "es gibt vier Tasks: 0, 1, 2, 3";
    SP114 "SP114" "more than {n} errors, stopped" "mehr als {n} Fehler, abgebrochen"
        "mend the errors above first" "zuerst die Fehler darüber beheben";
    SP115 "SP115" "more than {n} included texts" "mehr als {n} eingefügte Texte"
        "include every file once" "jede Datei einmal einfügen";

    SP116 "SP116" "constant {text} is too large for Double" "Konstante {text} ist zu groß für Double"
        "the largest is about 1.8e308" "die größte ist etwa 1.8e308";

    SP201 "SP201" "{what} expected, '{token}' found" "{what} erwartet, '{token}' gefunden"
        "" "";
    SP202 "SP202" "statement expected, '{token}' found" "Anweisung erwartet, '{token}' gefunden"
        "check for a missing 'end' or ';' above" "prüfen, ob darüber 'end' oder ';' fehlt";
    SP203 "SP203" "expression expected, '{token}' found" "Ausdruck erwartet, '{token}' gefunden"
        "" "";
    SP204 "SP204" "relations do not chain" "Vergleiche lassen sich nicht verketten"
        "write (a < b) and (b < c)" "(a < b) and (b < c) schreiben";
    SP205 "SP205" "'{word}' is a reserved word" "'{word}' ist ein reserviertes Wort"
        "choose another name" "einen anderen Namen wählen";
    SP206 "SP206" "nested more than {n} levels deep" "mehr als {n} Ebenen tief geschachtelt"
        "split the expression or the statement" "den Ausdruck oder die Anweisung aufteilen";
    SP207 "SP207" "the last 'end' needs a period" "das letzte 'end' braucht einen Punkt"
        "a program ends with 'end.'" "ein Programm endet mit 'end.'";
    SP208 "SP208" "routines are not declared inside a routine" "Routinen werden nicht in einer Routine deklariert"
        "move it in front of the enclosing one" "vor die umgebende Routine verschieben";
    SP209 "SP209" "a constant is one literal or one constant" "eine Konstante ist ein Literal oder eine Konstante"
        "write the computed value" "den berechneten Wert schreiben";
    SP210 "SP210" "statement outside 'begin' and 'end'" "Anweisung außerhalb von 'begin' und 'end'"
        "statements stand between 'begin' and 'end.'" "Anweisungen stehen zwischen 'begin' und 'end.'";
    SP211 "SP211" "';' between arguments" "';' zwischen Parametern"
        "separate arguments by ','" "Parameter mit ',' trennen";
    SP212 "SP212" "'else' without 'if'" "'else' ohne 'if'"
        "check begin and end of the branch above" "begin und end des Zweigs darüber prüfen";
    SP213 "SP213" "there is no operator 'div'" "einen Operator 'div' gibt es nicht"
        "write '/', which divides Integers too" "'/' schreiben, das auch Integer dividiert";

    SP301 "SP301" "'{name}' is declared twice (first in {place})" "'{name}' ist doppelt deklariert (zuerst in {place})"
        "a name is declared once in a block; 32 characters count" "ein Name wird je Block einmal deklariert; 32 Zeichen zählen";
    SP302 "SP302" "'{name}' is {what}, not {other}" "'{name}' ist {what}, nicht {other}"
        "" "";
    SP303 "SP303" "'{name}' cannot be assigned: it is {what}" "'{name}' kann nicht zugewiesen werden: {what}"
        "assign to a variable" "an eine Variable zuweisen";
    SP304 "SP304" "result of function '{name}' is assigned outside it" "Ergebnis der Funktion '{name}' wird außerhalb zugewiesen"
        "assign to the name inside the block of the function" "innerhalb des Blocks der Funktion zuweisen";
    SP305 "SP305" "label '{name}' is placed twice (first in {place})" "Label '{name}' ist doppelt gesetzt (zuerst in {place})"
        "a label marks one statement" "ein Label kennzeichnet eine Anweisung";
    SP306 "SP306" "label '{name}' marks no statement" "Label '{name}' kennzeichnet keine Anweisung"
        "place it before a statement of this block" "vor eine Anweisung dieses Blocks setzen";
    SP307 "SP307" "label '{name}' belongs to another block" "Label '{name}' gehört zu einem anderen Block"
        "goto never leaves its block" "goto verlässt seinen Block nie";
    SP308 "SP308" "'{name}' is announced with forward twice" "'{name}' ist zweimal mit forward angekündigt"
        "the second heading is followed by the block" "auf den zweiten Kopf folgt der Block";
    SP309 "SP309" "forward routine '{name}' has no block" "forward-Routine '{name}' hat keinen Block"
        "declare it in full further down" "weiter unten vollständig deklarieren";
    SP310 "SP310" "heading of '{name}' differs from its forward ({place})" "Kopf von '{name}' weicht von forward ab ({place})"
        "repeat parameters and result type" "Parameter und Ergebnistyp wiederholen";
    SP311 "SP311" "AXIS variables are declared in the main program only" "AXIS-Variablen werden nur im Hauptprogramm deklariert"
        "move the declaration out of the routine" "die Deklaration aus der Routine herausnehmen";
    SP312 "SP312" "event procedure '{name}' takes no parameters" "Ereignisprozedur '{name}' hat keine Parameter"
        "write 'procedure NAME;'" "'procedure NAME;' schreiben";
    SP313 "SP313" "'{name}' is no qualifier of an axis" "'{name}' ist kein Achs-Qualifizierer"
        "qualifiers are written as in table 37, lower case" "Qualifizierer wie in Tabelle 37, klein geschrieben";
    SP314 "SP314" "'{name}' needs {what}" "'{name}' braucht {what}"
        "" "";
    SP315 "SP315" "'{name}' takes no {what}" "'{name}' hat keine {what}"
        "" "";
    SP316 "SP316" "bit number {n} outside 1..32" "Bitnummer {n} außerhalb 1..32"
        "bits count from 1" "Bits zählen ab 1";

    SP401 "SP401" "{type} cannot be assigned to {other}" "{type} kann nicht an {other} zugewiesen werden"
        "convert it, as in INTEGER(x)" "umwandeln, z.B. INTEGER(x)";
    SP402 "SP402" "operator {op} is not defined for {type} and {other}" "Operator {op} ist für {type} und {other} nicht definiert"
        "put relations in parentheses, or convert an operand" "Vergleiche klammern oder einen Operanden umwandeln";
    SP403 "SP403" "operator {op} is not defined for {type}" "Operator {op} ist für {type} nicht definiert"
        "convert the operand" "den Operanden umwandeln";
    SP404 "SP404" "a condition is Boolean, this is {type}" "eine Bedingung ist Boolean, dies ist {type}"
        "compare it with a value" "mit einem Wert vergleichen";
    SP405 "SP405" "a for variable is an Integer variable or the qualifier an" "eine for-Variable ist eine Integer-Variable oder der Qualifizierer an"
        "declare it as integer" "als integer deklarieren";
    SP406 "SP406" "{type} cannot be converted to {other}" "{type} kann nicht in {other} umgewandelt werden"
        "" "";
    SP407 "SP407" "a string is an argument of write and writeln only" "eine Zeichenkette ist nur Parameter von write und writeln"
        "" "";
    SP408 "SP408" "procedure '{name}' has no value" "Prozedur '{name}' hat keinen Wert"
        "declare it as a function" "als Funktion deklarieren";
    SP409 "SP409" "'{name}' takes {n} arguments, {m} given" "'{name}' hat {n} Parameter, {m} angegeben"
        "" "";
    SP410 "SP410" "'{name}' needs {what} here" "'{name}' braucht hier {what}"
        "" "";
    SP411 "SP411" "'{name}' is no parameter of '{command}'" "'{name}' ist kein Parameter von '{command}'"
        "" "";
    SP412 "SP412" "'{name}' needs an Integer constant {range}" "'{name}' braucht eine Integer-Konstante {range}"
        "write a literal or a named constant" "ein Literal oder eine benannte Konstante schreiben";
    SP413 "SP413" "'{name}' needs the name of an event procedure" "'{name}' braucht den Namen einer Ereignisprozedur"
        "EVEO, EVDNR, EVLSH, EVLSS, EVMPE, EVUI or EVENDAT" "EVEO, EVDNR, EVLSH, EVLSS, EVMPE, EVUI oder EVENDAT";
    SP414 "SP414" "parameter '{name}' is given twice" "Parameter '{name}' ist doppelt angegeben"
        "keep one of them" "einen davon behalten";

    SP501 "SP501" "too many {what}, at most {n}" "zu viele {what}, höchstens {n}"
        "split the program" "das Programm aufteilen";

    SW901 "SW901" "':=' in a constant declaration is read as '='" "':=' in einer Konstantendeklaration wird als '=' gelesen"
        "write '='" "'=' schreiben";
    SW902 "SW902" "'=' in a motion command is read as ':='" "'=' in einem Fahrbefehl wird als ':=' gelesen"
        "write ':='" "':=' schreiben";
    SW903 "SW903" "';' between arguments is read as ','" "';' zwischen Parametern wird als ',' gelesen"
        "write ','" "',' schreiben";
    SW904 "SW904" "constant {text} is limited to {n}" "Konstante {text} wird auf {n} begrenzt"
        "Integers have 32 bits" "Integer hat 32 Bits";
    SW905 "SW905" "bare {name} is that of axis 0" "{name} ohne Achse ist das der Achse 0"
        "write axis.CFLAGS or axis.gfaux" "Achse.CFLAGS oder Achse.gfaux schreiben";
    SW906 "SW906" "'{name}' is outside 0..999 and stops the task with error 0400 hex" "'{name}' ist außerhalb 0..999 und hält die Task mit Fehler 0400 hex an"
        "use 0 to 999" "0 bis 999 verwenden";
    SW907 "SW907" "text behind 'end.' is ignored" "Text hinter 'end.' wird ignoriert" "" "";
    SW908 "SW908" "function '{name}' assigns no result" "Funktion '{name}' weist kein Ergebnis zu"
        "assign to its name" "an ihren Namen zuweisen";
    SW909 "SW909" "goto into a structured statement" "goto in eine strukturierte Anweisung"
        "its effect is not defined" "die Wirkung ist nicht definiert";
    SW910 "SW910" "axis '{name}' is named twice" "Achse '{name}' ist doppelt angegeben"
        "the controller sets ErrorReg bit 0" "die Steuerung setzt ErrorReg Bit 0";
    SW911 "SW911" "offset {n} stops the task with error {error} hex" "Offset {n} hält die Task mit Fehler {error} hex an"
        "offsets are 0..999, divisible by the size of the value" "Offsets sind 0..999, teilbar durch die Größe des Werts";
    SW913 "SW913" "no procedure {name} handles this event" "keine Prozedur {name} behandelt dieses Ereignis"
        "declare it above" "darüber deklarieren";
    SW912 "SW912" "division by 0 stops the task with error 8000 hex" "Division durch 0 hält die Task mit Fehler 8000 hex an" "" "";
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holes(text: &str) -> Vec<&str> {
        text.split('{').skip(1).filter_map(|t| t.split_once('}').map(|(name, _)| name)).collect()
    }

    #[test]
    fn both_languages_fill_the_same_holes() {
        for (_, name, english, german) in CATALOGUE {
            assert_eq!(holes(english[0]), holes(german[0]), "{name}");
            assert_eq!(english[1].is_empty(), german[1].is_empty(), "{name}");
        }
    }

    #[test]
    fn names_are_unique_and_sorted_by_kind() {
        let mut names: Vec<&str> = CATALOGUE.iter().map(|row| row.1).collect();
        let warnings = CATALOGUE.iter().filter(|row| row.0.is_warning()).count();
        assert_eq!(warnings, names.iter().filter(|n| n.starts_with("SW")).count());
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), CATALOGUE.len());
    }
}
