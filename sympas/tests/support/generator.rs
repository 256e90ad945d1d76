//! Generates programs of the language core from a seed: every type, operator, statement and form of routine. All of
//! them end; some end in a runtime error.

use std::fmt::Write;

use motion_kernel::sap::tables::Type;

const REALS: [&str; 8] = ["0.3", "1.0", "-2.5", "0.1", "1e3", ".5", "16777217.0", "1e-9"];
const INTEGERS: [&str; 12] = ["0", "1", "2", "-1", "7", "-13", "100", "5", "33", "$FFFF", "2147483647", "-2147483648"];

/// A variable, parameter or constant in reach.
#[derive(Clone)]
struct Known {
    name: String,
    of: Type,
    /// Constants and counters of loops are not.
    assignable: bool,
}

#[derive(Clone)]
struct Routine {
    name: String,
    parameters: Vec<Type>,
    result: Option<Type>,
}

pub struct Generator {
    state: u64,
    text: String,
    known: Vec<Known>,
    routines: Vec<Routine>,
    /// Declarations that loops and jumps of the present block need: counters and labels.
    counters: Vec<String>,
    labels: Vec<String>,
    next: u32,
    depth: u32,
}

/// The program of a seed.
pub fn program(seed: u64) -> String {
    let mut generator = Generator {
        state: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1,
        text: String::new(),
        known: Vec::new(),
        routines: Vec::new(),
        counters: Vec::new(),
        labels: Vec::new(),
        next: 0,
        depth: 0,
    };
    generator.whole()
}

impl Generator {
    /// xorshift64*
    fn random(&mut self, below: u32) -> u32 {
        self.state ^= self.state >> 12;
        self.state ^= self.state << 25;
        self.state ^= self.state >> 27;
        let high = self.state.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33;
        (high % u64::from(below.max(1))) as u32
    }
    fn pick<T: Clone>(&mut self, list: &[T]) -> T {
        let n = self.random(list.len() as u32) as usize;
        list[n].clone()
    }
    fn name(&mut self, prefix: &str) -> String {
        self.next += 1;
        format!("{prefix}{}", self.next)
    }
    fn kind(&mut self) -> Type {
        self.pick(&[Type::Integer, Type::Integer, Type::Double, Type::Boolean, Type::Single, Type::Timer])
    }
    fn whole(&mut self) -> String {
        let (mut declarations, mut starts) = (String::new(), String::new());
        for _ in 0..self.random(3) {
            let (name, of) = (self.name("k"), self.pick(&[Type::Integer, Type::Double]));
            let value = if of == Type::Integer { self.pick(&INTEGERS) } else { self.pick(&REALS) };
            let _ = writeln!(declarations, "const {name} = {value};");
            self.known.push(Known { name, of, assignable: false });
        }
        for of in [Type::Integer, Type::Integer, Type::Double, Type::Boolean, Type::Single, Type::Timer] {
            let name = self.name("g");
            let _ = writeln!(declarations, "var {name} : {};", of.name());
            starts += &format!("  {name} := {};\n", self.start_value(of));
            self.known.push(Known { name, of, assignable: true });
        }
        for _ in 0..self.random(4) {
            let routine = if self.random(4) == 0 { self.recursive() } else { self.routine() };
            declarations += &routine;
        }
        let body = self.block(8);
        for known in self.known.clone() {
            self.show(&known);
        }
        let ends = std::mem::take(&mut self.text);
        let counters = self.take_counters();
        format!("{declarations}{counters}begin\n{starts}{body}{ends}end.\n")
    }
    /// Declares what the statements of a block needed.
    fn take_counters(&mut self) -> String {
        let mut out = String::new();
        if !self.labels.is_empty() {
            let _ = writeln!(out, "label {};", std::mem::take(&mut self.labels).join(", "));
        }
        if !self.counters.is_empty() {
            let _ = writeln!(out, "var {} : integer;", std::mem::take(&mut self.counters).join(", "));
        }
        out
    }
    fn routine(&mut self) -> String {
        let prefix = self.pick(&["P", "F"]);
        let name = self.name(prefix);
        let result = name.starts_with('F').then(|| self.kind());
        let outer = self.known.clone();
        let mut parameters = Vec::new();
        let mut heads = Vec::new();
        for _ in 0..self.random(3) {
            let (parameter, of) = (self.name("a"), self.kind());
            heads.push(format!("{parameter} : {}", of.name()));
            self.known.push(Known { name: parameter, of, assignable: true });
            parameters.push(of);
        }
        let mut locals = String::new();
        for _ in 0..self.random(3) {
            // a local may hide a global of the same name
            let hidden = self.pick(&outer).name;
            let (local, of) = (if self.random(4) == 0 { hidden } else { self.name("v") }, self.kind());
            if locals.contains(&format!("{local} :")) {
                continue;
            }
            let _ = writeln!(locals, "var {local} : {};", of.name());
            self.known.retain(|k| k.name != local);
            self.known.push(Known { name: local, of, assignable: true });
        }
        if let Some(of) = result {
            self.known.push(Known { name: name.clone(), of, assignable: true });
        }
        let mut starts = String::new();
        for local in locals.lines().filter_map(|l| l.strip_prefix("var ")?.split_once(" :")).map(|(n, _)| n.to_owned())
        {
            let of = self.known.iter().find(|k| k.name == local).map_or(Type::Integer, |k| k.of);
            starts += &format!("  {local} := {};\n", self.start_value(of));
        }
        let body = self.block(3);
        let counters = self.take_counters();
        self.known = outer;
        self.routines.push(Routine { name: name.clone(), parameters, result });
        let list = if heads.is_empty() { String::new() } else { format!("({})", heads.join("; ")) };
        let head = match result {
            Some(of) => format!("function {name}{list} : {};", of.name()),
            None => format!("procedure {name}{list};"),
        };
        let forward = if self.random(4) == 0 { format!("{head} forward;\n") } else { String::new() };
        format!("{forward}{head}\n{locals}{counters}begin\n{starts}{body}end;\n")
    }
    /// A function that calls itself a few times; its local keeps its value meanwhile.
    fn recursive(&mut self) -> String {
        let (name, parameter, local, of) = (self.name("F"), self.name("a"), self.name("v"), self.kind());
        let kind = of.name();
        let outer = self.known.clone();
        self.known.push(Known { name: local.clone(), of, assignable: true });
        let (first, after) = (self.expression(of, 1), self.block(2));
        let counters = self.take_counters();
        self.known = outer;
        let less = if self.random(2) == 0 { format!("{parameter} - 1") } else { format!("{parameter} / 2") };
        let join = match of {
            Type::Boolean => "xor",
            _ => "+",
        };
        let body = format!(
            "  {local} := {first};\n  if {parameter} > 0 then {name} := {name}({less}) {join} {local};\n{after}\
             \x20 {name} := {name} {join} {local};\n"
        );
        let wrapper = self.name("F");
        self.routines.push(Routine { name: wrapper.clone(), parameters: vec![], result: Some(of) });
        let depth = 1 + self.random(6);
        format!(
            "function {name}({parameter} : integer) : {kind};\nvar {local} : {kind};\n{counters}begin\n{body}end;\n\
             function {wrapper} : {kind};\nbegin\n  {wrapper} := {name}({depth});\nend;\n"
        )
    }
    fn block(&mut self, statements: u32) -> String {
        let outer = std::mem::take(&mut self.text);
        for _ in 0..=self.random(statements) {
            self.statement();
        }
        std::mem::replace(&mut self.text, outer)
    }
    fn line(&mut self, text: &str) {
        self.text += "  ";
        self.text += text;
        self.text.push('\n');
    }
    fn statement(&mut self) {
        self.depth += 1;
        match self.random(if self.depth > 3 { 9 } else { 15 }) {
            0..=4 => self.assignment(),
            5 => {
                let of = self.kind();
                let value = self.expression(of, 2);
                let text = if self.random(2) == 0 { "write" } else { "writeln" };
                self.line(&format!("{text}('v ', {value});"));
            }
            6 => self.call(),
            7 => self.registers(),
            8 => self.goto(),
            9 | 10 => self.if_statement(),
            11 => self.while_statement(),
            12 => self.repeat_statement(),
            13 => self.for_statement(),
            _ => {
                let body = self.block(3);
                self.line(&format!("begin\n{body}  end;"));
            }
        }
        self.depth -= 1;
    }
    fn assignment(&mut self) {
        let targets: Vec<Known> = self.known.iter().filter(|k| k.assignable).cloned().collect();
        let target = self.pick(&targets);
        let source = match target.of {
            Type::Integer => self.pick(&[Type::Integer, Type::Integer, Type::Integer, Type::Boolean, Type::Timer]),
            Type::Timer => self.pick(&[Type::Timer, Type::Integer]),
            Type::Single => self.pick(&[Type::Single, Type::Integer, Type::Boolean, Type::Timer]),
            Type::Double => self.pick(&Type::ALL),
            Type::Boolean => Type::Boolean,
        };
        let value = self.expression(source, 3);
        self.line(&format!("{} := {value};", target.name));
        if self.random(2) == 0 {
            self.show(&target);
        }
    }
    /// Writes a variable; a Single with all the digits that it should not have.
    fn show(&mut self, known: &Known) {
        let text = if known.of == Type::Single { format!("double({})", known.name) } else { known.name.clone() };
        self.line(&format!("writeln({text});"));
    }
    /// Values that tell operators apart.
    fn start_value(&mut self, of: Type) -> String {
        match of {
            Type::Boolean => self.pick(&["TRUE", "FALSE"]).to_owned(),
            Type::Integer => (self.random(200) as i32 - 100).to_string(),
            Type::Timer => format!("{}", self.random(100) as i32 - 50),
            Type::Single | Type::Double => format!("{}.{}", self.random(50), 1 + self.random(98)),
        }
    }
    fn call(&mut self) {
        let list: Vec<Routine> = self.routines.iter().filter(|r| r.result.is_none()).cloned().collect();
        if list.is_empty() {
            return self.assignment();
        }
        let routine = self.pick(&list);
        let arguments = self.arguments(&routine);
        self.line(&format!("{}{arguments};", routine.name));
    }
    fn arguments(&mut self, routine: &Routine) -> String {
        if routine.parameters.is_empty() {
            return if self.random(2) == 0 { "()".to_owned() } else { String::new() };
        }
        let list: Vec<String> = routine.parameters.iter().map(|of| self.expression(*of, 1)).collect();
        format!("({})", list.join(", "))
    }
    fn registers(&mut self) {
        let n = self.random(4);
        let text = match self.random(6) {
            0 => format!("CI{n} := {};", self.expression(Type::Integer, 2)),
            1 => format!("CD{n} := {};", self.expression(Type::Double, 2)),
            2 => format!("wrcbi({}, {});", 4 * n, self.expression(Type::Integer, 2)),
            3 => format!("wrcbd({}, {});", 8 * n, self.expression(Type::Double, 2)),
            4 => format!("wrcbs({}, {});", self.expression(Type::Integer, 1), self.expression(Type::Single, 1)),
            _ if self.random(20) == 0 => "CI0 := CI1000;".to_owned(),
            _ => format!("CI{n} := CI{n} + 1;"),
        };
        self.line(&text);
    }
    /// A jump ahead within the sequence, over one statement or none.
    fn goto(&mut self) {
        let label = self.name("L");
        self.labels.push(label.clone());
        let condition = self.expression(Type::Boolean, 2);
        self.line(&format!("if {condition} then goto {label};"));
        self.assignment();
        self.line(&format!("{label}: ;"));
    }
    fn if_statement(&mut self) {
        let condition = self.expression(Type::Boolean, 3);
        let then = self.block(2);
        let text = match self.random(3) {
            0 => format!("if {condition} then begin\n{then}  end;"),
            1 => format!("if {condition} then begin\n{then}  end else begin\n{}  end;", self.block(2)),
            _ => format!("if {condition} then begin\n{then}  end; else begin\n{}  end;", self.block(2)),
        };
        self.line(&text);
    }
    fn counter(&mut self) -> String {
        let name = self.name("c");
        self.counters.push(name.clone());
        name
    }
    fn while_statement(&mut self) {
        let (counter, most) = (self.counter(), 1 + self.random(4));
        let body = self.block(2);
        let condition = self.expression(Type::Boolean, 1);
        self.line(&format!("{counter} := 0;"));
        self.line(&format!(
            "while ({counter} < {most}) and ({condition}) do begin\n  {counter} := {counter} + 1;\n{body}  end;"
        ));
    }
    fn repeat_statement(&mut self) {
        let (counter, most) = (self.counter(), 1 + self.random(4));
        let body = self.block(2);
        let condition = self.expression(Type::Boolean, 1);
        self.line(&format!("{counter} := 0;"));
        self.line(&format!(
            "repeat\n  {counter} := {counter} + 1;\n{body}  until ({counter} >= {most}) or ({condition});"
        ));
    }
    fn for_statement(&mut self) {
        let counter = self.counter();
        let first = self.random(9) as i32 - 4;
        let last = first + self.random(7) as i32 - 2;
        self.known.push(Known { name: counter.clone(), of: Type::Integer, assignable: false });
        let body = self.block(2);
        self.known.retain(|k| k.name != counter);
        let (mut a, mut b) = (first.to_string(), last.to_string());
        if self.random(3) == 0 {
            a = format!("({} mod 3)", self.expression(Type::Integer, 1));
        }
        if self.random(3) == 0 {
            b = format!("({} mod 4 + 1)", self.expression(Type::Integer, 1));
        }
        let word = if self.random(3) == 0 { "downto" } else { "to" };
        if word == "downto" {
            std::mem::swap(&mut a, &mut b);
        }
        self.line(&format!("for {counter} := {a} {word} {b} do begin\n{body}  end;"));
    }

    /// An expression of exactly that type.
    fn expression(&mut self, of: Type, depth: u32) -> String {
        if depth == 0 || self.random(5) == 0 {
            return self.leaf(of);
        }
        match of {
            Type::Boolean => self.boolean(depth),
            Type::Integer => self.integer(depth),
            Type::Timer => match self.random(4) {
                0 => format!("timer({})", self.expression(Type::Integer, depth - 1)),
                1 => format!("({} + {})", self.expression(Type::Integer, depth - 1), self.expression(of, depth - 1)),
                n => {
                    let other = if n == 2 { Type::Integer } else { of };
                    let operator = self.pick(&["+", "-"]);
                    format!("({} {operator} {})", self.expression(of, depth - 1), self.expression(other, depth - 1))
                }
            },
            Type::Single => self.single(depth),
            Type::Double => self.double(depth),
        }
    }
    fn leaf(&mut self, of: Type) -> String {
        let list: Vec<Known> = self.known.iter().filter(|k| k.of == of).cloned().collect();
        if !list.is_empty() && self.random(3) > 0 {
            return self.pick(&list).name;
        }
        let functions: Vec<Routine> = self.routines.iter().filter(|r| r.result == Some(of)).cloned().collect();
        if !functions.is_empty() && self.random(2) == 0 && self.depth < 6 {
            let function = self.pick(&functions);
            let saved = std::mem::replace(&mut self.depth, 6);
            let arguments = self.arguments(&function);
            self.depth = saved;
            return format!("{}{arguments}", function.name);
        }
        match of {
            Type::Boolean => self.pick(&["TRUE", "FALSE"]).to_owned(),
            Type::Integer => self.pick(&INTEGERS).to_owned(),
            Type::Timer => format!("timer({})", self.pick(&INTEGERS)),
            Type::Single => format!("single({})", self.pick(&REALS)),
            Type::Double => self.pick(&REALS).to_owned(),
        }
    }
    fn boolean(&mut self, depth: u32) -> String {
        match self.random(6) {
            0 => format!("not {}", self.expression(Type::Boolean, 0)),
            1 | 2 => {
                let operator = self.pick(&["and", "or", "xor"]);
                format!(
                    "({} {operator} {})",
                    self.expression(Type::Boolean, depth - 1),
                    self.expression(Type::Boolean, depth - 1)
                )
            }
            3 => {
                let of = self.kind();
                format!("boolean({})", self.expression(of, depth - 1))
            }
            _ => {
                let pairs = [
                    (Type::Integer, Type::Integer),
                    (Type::Integer, Type::Double),
                    (Type::Single, Type::Integer),
                    (Type::Single, Type::Double),
                    (Type::Boolean, Type::Boolean),
                    (Type::Timer, Type::Timer),
                    (Type::Timer, Type::Integer),
                    (Type::Integer, Type::Timer),
                ];
                let (a, b) = self.pick(&pairs);
                let operator = self.pick(&["=", "<>", "<", ">", "<=", ">="]);
                format!("({} {operator} {})", self.expression(a, depth - 1), self.expression(b, depth - 1))
            }
        }
    }
    fn integer(&mut self, depth: u32) -> String {
        match self.random(8) {
            0 => {
                let of = self.kind();
                format!("integer({})", self.expression(of, depth - 1))
            }
            1 => format!("{} {}", self.pick(&["-", "+", "not"]), self.expression(Type::Integer, 0)),
            2 => format!("rdcbi({})", 4 * self.random(8)),
            3 => format!("CI{}", self.random(4)),
            _ => {
                let operator = self.pick(&["+", "-", "*", "/", "mod", "shl", "shr", "and", "or", "xor", "+", "-", "*"]);
                let (a, b) = (self.expression(Type::Integer, depth - 1), self.expression(Type::Integer, depth - 1));
                // a divisor that is seldom 0, so that programs get somewhere
                if matches!(operator, "/" | "mod") && self.random(8) > 0 {
                    return format!("({a} {operator} (1 + 2 * {b}))");
                }
                format!("({a} {operator} {b})")
            }
        }
    }
    fn single(&mut self, depth: u32) -> String {
        match self.random(4) {
            0 => {
                let of = self.kind();
                format!("single({})", self.expression(of, depth - 1))
            }
            1 => format!("- {}", self.expression(Type::Single, 0)),
            2 => format!("rdcbs({})", 4 * self.random(8)),
            _ => {
                let operator = self.pick(&["+", "-", "*"]);
                let other = self.pick(&[Type::Single, Type::Integer]);
                format!(
                    "({} {operator} {})",
                    self.expression(Type::Single, depth - 1),
                    self.expression(other, depth - 1)
                )
            }
        }
    }
    fn double(&mut self, depth: u32) -> String {
        match self.random(7) {
            0 => {
                let of = self.kind();
                format!("double({})", self.expression(of, depth - 1))
            }
            1 => {
                let function = self.pick(&["abs", "sqr", "sqrt", "sin", "atan", "ln", "exp", "cos", "tanh"]);
                let of = self.pick(&[Type::Double, Type::Integer, Type::Single]);
                format!("{function}({})", self.expression(of, depth - 1))
            }
            2 => format!("rdcbd({})", 8 * self.random(4)),
            3 => format!("CD{}", self.random(4)),
            4 => format!(
                "({} / (1.5 + sqr({})))",
                self.expression(Type::Double, depth - 1),
                self.expression(Type::Double, 0)
            ),
            _ => {
                let operator = self.pick(&["+", "-", "*", "/", "+", "-", "*"]);
                let other = self.pick(&[Type::Double, Type::Single, Type::Integer]);
                format!(
                    "({} {operator} {})",
                    self.expression(Type::Double, depth - 1),
                    self.expression(other, depth - 1)
                )
            }
        }
    }
}
