//! Program, blocks, declarations (5.3.1, 5.3.2, 5.3.6, 5.3.7).

use motion_kernel::sap::tables::Type;

use super::{Lost, Parse, Parser};
use crate::ast::{Block, Constant, Item, Name, Program, Routine, TypeName};
use crate::diagnostics::{Fault, Id, Phrase, closest};
use crate::token::{Keyword, Symbol, TokenKind};

const NAME: [&str; 2] = ["a name", "ein Name"];

/// What a misspelt type may mean.
const TYPES: [&str; 6] = ["boolean", "integer", "single", "double", "timer", "axis"];

/// The keywords that begin a declaration.
pub(super) const DECLARATIONS: [Keyword; 5] =
    [Keyword::Label, Keyword::Const, Keyword::Var, Keyword::Procedure, Keyword::Function];

/// The type that a keyword names.
pub(super) fn simple_type(keyword: Keyword) -> Option<Type> {
    match keyword {
        Keyword::Boolean => Some(Type::Boolean),
        Keyword::Integer => Some(Type::Integer),
        Keyword::Single => Some(Type::Single),
        Keyword::Double => Some(Type::Double),
        Keyword::Timer => Some(Type::Timer),
        _ => None,
    }
}

impl Parser<'_> {
    pub(super) fn program(mut self) -> Program {
        let heading = self.heading();
        let mut items = Vec::new();
        self.declarations(&mut items, true);
        let mut body = Vec::new();
        if self.eat_keyword(Keyword::Begin) {
            body = self.main_body();
        } else {
            self.expected("'begin'");
        }
        let end = self.last_span();
        if self.eat_symbol(Symbol::Point) {
            if !self.at_end() {
                let span = self.span();
                self.report(Fault::new(Id::SW907, span));
            }
        } else if !self.reports.has_errors() {
            self.report(Fault::new(Id::SP207, end));
        }
        Program { heading, block: Block { items, body, end }, lost_names: self.lost_names || self.given_up }
    }
    fn heading(&mut self) -> Option<Name> {
        if !self.is_word("program") || self.symbol_at(1, Symbol::Assign) {
            return None;
        }
        self.advance();
        let name = self.expect_name(NAME).ok();
        if name.is_none() || self.expect_symbol(Symbol::Semicolon).is_err() {
            self.skip_declaration();
        }
        name
    }
    /// The statements between the first `begin` and the last `end`. An `end` too many is reported once.
    fn main_body(&mut self) -> Vec<crate::ast::Statement> {
        let mut body = Vec::new();
        loop {
            body.extend(self.sequence());
            let end = self.span();
            if self.expect_keyword(Keyword::End).is_err() || self.is_symbol(Symbol::Point) {
                return body;
            }
            if self.at_end() || self.keyword().is_some_and(|k| DECLARATIONS.contains(&k)) {
                return body;
            }
            self.report(Fault::new(Id::SP207, end));
            self.eat_symbol(Symbol::Semicolon);
        }
    }
    /// Declaration sections and, in the main program, routines, up to the `begin` of the block.
    fn declarations(&mut self, items: &mut Vec<Item>, main: bool) {
        loop {
            if self.eat_symbol(Symbol::Semicolon) {
                continue; // stray ones are ignored (6.7.2 prints one)
            }
            let result = match self.keyword() {
                Some(Keyword::Begin) => return,
                Some(Keyword::Label) => self.labels(items),
                Some(Keyword::Const) => self.constants(items),
                Some(Keyword::Var) => self.variables(items),
                Some(Keyword::Procedure | Keyword::Function) => self.routine(items, main),
                _ if self.at_end() => return,
                _ => Err(self.stray()),
            };
            if result.is_err() && !matches!(self.keyword(), Some(Keyword::Begin)) {
                self.skip_declaration();
            }
        }
    }
    /// Something that is no declaration stands among them.
    fn stray(&mut self) -> Lost {
        let statement = matches!(self.kind(), TokenKind::Name(_));
        let goes_on = [Symbol::Assign, Symbol::Open, Symbol::Semicolon, Symbol::Point];
        let span = self.span();
        if statement && goes_on.iter().any(|s| self.symbol_at(1, *s)) {
            return self.report(Fault::new(Id::SP210, span));
        }
        self.expected(Phrase::new("a declaration or 'begin'", "eine Deklaration oder 'begin'"))
    }
    /// Goes on behind the next `;`, or at the next section.
    fn skip_declaration(&mut self) {
        self.lost_names = true;
        loop {
            match self.keyword() {
                Some(Keyword::Begin) => return,
                Some(k) if DECLARATIONS.contains(&k) => return,
                _ if self.at_end() || self.eat_symbol(Symbol::Semicolon) => return,
                _ => self.advance(),
            }
        }
    }
    fn labels(&mut self, items: &mut Vec<Item>) -> Parse<()> {
        self.advance();
        items.push(Item::Labels(self.expect_names(["a label", "ein Label"])?));
        self.expect_symbol(Symbol::Semicolon)
    }
    /// True where another entry of a section begins: a name with one of these behind it.
    fn more_entries(&self, behind: [Symbol; 2]) -> bool {
        matches!(self.kind(), TokenKind::Name(_)) && behind.iter().any(|s| self.symbol_at(1, *s))
    }
    fn constants(&mut self, items: &mut Vec<Item>) -> Parse<()> {
        self.advance();
        loop {
            let item = self.constant();
            match item {
                Ok(constant) => items.push(Item::Constant(constant)),
                Err(Lost) => self.skip_declaration(),
            }
            if !self.more_entries([Symbol::Equal, Symbol::Assign]) {
                return Ok(());
            }
        }
    }
    fn constant(&mut self) -> Parse<Constant> {
        let at = self.at;
        let name = self.expect_name(NAME)?;
        let span = self.span();
        if self.eat_symbol(Symbol::Assign) {
            self.report(Fault::new(Id::SW901, span));
        } else {
            self.expect_symbol(Symbol::Equal)?;
        }
        let value = self.constant_value()?;
        if !self.is_symbol(Symbol::Semicolon) && self.binary_operator().is_some() {
            let span = self.span();
            return Err(self.report(Fault::new(Id::SP209, span)));
        }
        self.expect_symbol(Symbol::Semicolon)?;
        Ok(Constant { name, value, at })
    }
    fn variables(&mut self, items: &mut Vec<Item>) -> Parse<()> {
        self.advance();
        loop {
            match self.variable_entry() {
                Ok(item) => items.push(item),
                Err(Lost) => self.skip_declaration(),
            }
            if !self.more_entries([Symbol::Comma, Symbol::Colon]) {
                return Ok(());
            }
        }
    }
    fn variable_entry(&mut self) -> Parse<Item> {
        let names = self.expect_names(NAME)?;
        self.expect_symbol(Symbol::Colon)?;
        let item = match self.type_name(true) {
            Ok(kind) => Item::Variables { names, kind },
            Err(Lost) if matches!(self.kind(), TokenKind::Name(_)) => {
                self.advance(); // a misspelt type: what is declared is known all the same
                Item::Unknown(names)
            }
            Err(Lost) => return Err(Lost),
        };
        self.expect_symbol(Symbol::Semicolon)?;
        Ok(item)
    }
    fn type_name(&mut self, axis: bool) -> Parse<TypeName> {
        let span = self.span();
        let kind = self.keyword().and_then(simple_type);
        if kind.is_some() || axis && self.is_word("axis") {
            self.advance();
            return Ok(TypeName { kind, span });
        }
        let what = "(boolean, integer, single, double, timer)";
        let what = Phrase::new(&format!("a type {what}"), &format!("ein Typ {what}"));
        let near = match self.kind() {
            TokenKind::Name(name) => closest(&name.to_lowercase(), TYPES.into_iter().filter(|t| axis || *t != "axis")),
            _ => None,
        };
        Err(self.expected_but(what, near))
    }
    fn routine(&mut self, items: &mut Vec<Item>, main: bool) -> Parse<()> {
        if !main {
            let span = self.span();
            self.report(Fault::new(Id::SP208, span));
        }
        let routine = self.routine_declaration()?;
        if main {
            items.push(Item::Routine(routine));
        }
        Ok(())
    }
    fn routine_declaration(&mut self) -> Parse<Routine> {
        let heading = self.routine_heading();
        if heading.is_err() {
            self.skip_heading();
        }
        if self.eat_keyword(Keyword::Forward) {
            self.expect_symbol(Symbol::Semicolon)?;
            return heading;
        }
        let block = self.deeper(Self::routine_block)?;
        self.expect_symbol(Symbol::Semicolon)?;
        heading.map(|routine| Routine { block: Some(block), ..routine })
    }
    fn routine_heading(&mut self) -> Parse<Routine> {
        let function = self.is_keyword(Keyword::Function);
        self.advance();
        let name = self.expect_name(NAME)?;
        let parameters = self.parameters()?;
        let mut result = None;
        if function {
            self.expect_symbol(Symbol::Colon)?;
            result = Some(self.type_name(false)?);
        }
        self.expect_symbol(Symbol::Semicolon)?;
        Ok(Routine { name, parameters, result, block: None })
    }
    /// Goes behind the `;` that ends a heading: the block below is read all the same.
    fn skip_heading(&mut self) {
        self.lost_names = true;
        loop {
            let block = |k: Keyword| matches!(k, Keyword::Begin | Keyword::Forward) || DECLARATIONS.contains(&k);
            if self.at_end() || self.keyword().is_some_and(block) {
                return;
            }
            self.advance();
        }
    }
    fn parameters(&mut self) -> Parse<Vec<(Name, TypeName)>> {
        let mut list = Vec::new();
        if !self.eat_symbol(Symbol::Open) || self.eat_symbol(Symbol::Close) {
            return Ok(list);
        }
        loop {
            let names = self.expect_names(NAME)?;
            self.expect_symbol(Symbol::Colon)?;
            let kind = self.type_name(false)?;
            list.extend(names.into_iter().map(|name| (name, kind)));
            if !self.eat_symbol(Symbol::Semicolon) {
                self.expect_symbol(Symbol::Close)?;
                return Ok(list);
            }
        }
    }
    fn routine_block(&mut self) -> Parse<Block> {
        let mut items = Vec::new();
        self.declarations(&mut items, false);
        self.expect_keyword(Keyword::Begin)?;
        let body = self.sequence();
        let end = self.span();
        self.expect_keyword(Keyword::End)?;
        Ok(Block { items, body, end })
    }
}
