//! What the value of each address may be (docs/dialect.md, section 4).

/// What an address takes (section 4).
pub(crate) struct Rule {
    pub signed: bool,
    pub integer: bool,
    pub low: f64,
    pub high: f64,
}

const fn rule(signed: bool, integer: bool, low: f64, high: f64) -> Rule {
    Rule { signed, integer, low, high }
}

/// By letter.
pub(crate) const RULES: [Rule; 26] = {
    const C: Rule = rule(true, false, -1e7, 1e7);
    [
        C,                                  // A
        C,                                  // B
        C,                                  // C
        rule(false, true, 0.0, 9999.0),     // D
        rule(true, false, -1e6, 1e6),       // E
        rule(true, false, -1e6, 1e6),       // F, sign: GC504
        rule(false, false, 0.0, 999.9),     // G
        rule(false, true, 0.0, 9999.0),     // H
        C,                                  // I
        C,                                  // J
        C,                                  // K
        rule(false, true, 0.0, 99999999.0), // L
        rule(false, true, 0.0, 999.0),      // M
        rule(false, true, 0.0, 99999999.0), // N
        rule(false, true, 0.0, 99999999.0), // O
        rule(true, false, -1e9, 1e9),       // P, per function
        C,                                  // Q, sign: GC416
        C,                                  // R
        rule(false, false, 0.0, 1e6),       // S
        rule(false, true, 0.0, 99999999.0), // T
        C,                                  // U
        C,                                  // V
        C,                                  // W
        C,                                  // X
        C,                                  // Y
        C,                                  // Z
    ]
};
