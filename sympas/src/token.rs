//! What the scanner yields: keywords, names, constants, symbols (chapter 5.2.3).

use std::rc::Rc;

use crate::source::Span;

macro_rules! keywords {
    ($($variant:ident $text:literal;)*) => {
        /// The 32 reserved words of table 21.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Keyword { $($variant,)* }

        impl Keyword {
            pub const ALL: &[Keyword] = &[$(Keyword::$variant,)*];

            pub const fn text(self) -> &'static str {
                match self { $(Keyword::$variant => $text,)* }
            }
        }
    };
}

keywords! {
    And "and"; Begin "begin"; Boolean "boolean"; Const "const"; Do "do"; Double "double"; Downto "downto"; Else "else";
    End "end"; For "for"; Forward "forward"; Function "function"; Goto "goto"; If "if"; Integer "integer";
    Label "label"; Mod "mod"; Module "module"; Not "not"; Or "or"; Procedure "procedure"; Repeat "repeat"; Shl "shl";
    Shr "shr"; Single "single"; Then "then"; Timer "timer"; To "to"; Until "until"; Var "var"; While "while"; Xor "xor";
}

impl Keyword {
    /// The keyword of that spelling, in any case.
    pub fn of(text: &str) -> Option<Keyword> {
        if !(2..=9).contains(&text.len()) {
            return None;
        }
        Keyword::ALL.iter().copied().find(|k| k.text().eq_ignore_ascii_case(text))
    }
}

macro_rules! symbols {
    ($($variant:ident $text:literal;)*) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Symbol { $($variant,)* }

        impl Symbol {
            /// Longer ones first, so that the longest token wins.
            pub const ALL: &[Symbol] = &[$(Symbol::$variant,)*];

            pub const fn text(self) -> &'static str {
                match self { $(Symbol::$variant => $text,)* }
            }
        }
    };
}

symbols! {
    Assign ":="; NotEqual "<>"; LessEqual "<="; GreaterEqual ">=";
    Open "("; Close ")"; OpenBracket "["; CloseBracket "]"; Comma ","; Semicolon ";"; Colon ":"; Point ".";
    Equal "="; Less "<"; Greater ">"; Plus "+"; Minus "-"; Star "*"; Slash "/";
}

#[derive(Clone, Debug, PartialEq)]
pub enum TokenKind {
    Keyword(Keyword),
    /// As written, cut after 32 characters: only those count (5.2.3.2.1).
    Name(Rc<str>),
    /// Magnitude of a decimal constant, limited to 64 bits. The parser knows its sign.
    Decimal(u64),
    /// Bits of a hexadecimal constant, limited to 64.
    Hexadecimal(u64),
    Float(f64),
    Text(Rc<str>),
    Symbol(Symbol),
    /// End of the whole text.
    End,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Token {
    pub kind: TokenKind,
    pub span: Span,
}

impl Token {
    /// The token as an error message shows it.
    pub fn shown(&self) -> String {
        match &self.kind {
            TokenKind::Keyword(k) => k.text().to_owned(),
            TokenKind::Name(name) => name.to_string(),
            TokenKind::Decimal(n) => n.to_string(),
            TokenKind::Hexadecimal(n) => format!("${n:X}"),
            TokenKind::Float(x) => format!("{x:?}"),
            TokenKind::Text(text) => format!("'{text}'"),
            TokenKind::Symbol(s) => s.text().to_owned(),
            TokenKind::End => "end of text".to_owned(),
        }
    }
}
