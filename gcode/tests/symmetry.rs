//! Symmetric properties over generated programs of rapids, lines, arcs, helices and functions: one path, written in two
//! ways, must become the same commands.

mod common;

use common::{Command, commands, mill3, program_for};
use gcode::Options;
use motion_kernel::machine::Profile;
use proptest::prelude::*;

type P = [f64; 3];

/// One block of a program, free of how it is written.
#[derive(Clone, Debug)]
enum Step {
    Rapid(P),
    Line(P, f64),
    /// Plane 0..2 (XY, ZX, YZ), centre from the start, signed sweep in degrees, way of the third axis, feed.
    Arc {
        plane: usize,
        centre: [f64; 2],
        sweep: f64,
        third: f64,
        feed: f64,
    },
    Word(&'static str),
}

/// First and second axis and the third, centre letters, plane code.
const PLANES: [([usize; 3], [char; 2], u32); 3] =
    [([0, 1, 2], ['I', 'J'], 17), ([2, 0, 1], ['K', 'I'], 18), ([1, 2, 0], ['J', 'K'], 19)];

fn step() -> impl Strategy<Value = Step> {
    let point = || prop::array::uniform3(-80.0..80.0f64);
    let feed = || (1..50u32).prop_map(|f| f64::from(f) * 50.0);
    let sweep = prop_oneof![1.0..179.0f64, 181.0..359.0f64, Just(360.0), 361.0..900.0f64];
    let arc =
        (0..3usize, 0.0..360.0f64, 2.0..20.0f64, sweep, any::<bool>(), prop_oneof![Just(0.0), -9.0..9.0f64], feed());
    prop_oneof![
        1 => point().prop_map(Step::Rapid),
        3 => (point(), feed()).prop_map(|(p, f)| Step::Line(p, f)),
        3 => arc.prop_map(|(plane, angle, r, sweep, ccw, third, feed)| {
            let (sin, cos) = angle.to_radians().sin_cos();
            Step::Arc { plane, centre: [r * cos, r * sin], sweep: if ccw { sweep } else { -sweep }, third, feed }
        }),
        1 => prop::sample::select(vec!["M8", "M9", "M62 P3", "G4 P20", "S500 M3", "CI7 = 5", "(MSG, on)", "G61", "G64"]).prop_map(Step::Word),
    ]
}

/// How a path is written.
#[derive(Clone, Copy)]
struct Style {
    incremental: bool,
    inch: bool,
    absolute_centres: bool,
    by_radius: bool,
    /// Program coordinates: mirrored in X, turned about the origin in XY (degrees), scaled, shifted.
    mirror: bool,
    turn: f64,
    scale: f64,
    shift: P,
}

const PLAIN: Style = Style {
    incremental: false,
    inch: false,
    absolute_centres: false,
    by_radius: false,
    mirror: false,
    turn: 0.0,
    scale: 1.0,
    shift: [0.0; 3],
};

impl Style {
    /// A direction as the program writes it.
    fn vector(&self, v: P) -> P {
        let (sin, cos) = self.turn.to_radians().sin_cos();
        let x = if self.mirror { -v[0] } else { v[0] };
        [x * cos - v[1] * sin, x * sin + v[1] * cos, v[2]].map(|c| c * self.scale)
    }
    fn point(&self, p: P) -> P {
        let v = self.vector(p);
        [0, 1, 2].map(|i| v[i] + self.shift[i])
    }
    fn unit(&self) -> f64 {
        if self.inch { 25.4 } else { 1.0 }
    }
    fn word(&self, letter: char, value: f64) -> String {
        format!(" {letter}{:.*}", if self.inch { 13 } else { 11 }, value / self.unit())
    }
    fn feed(&self, feed: f64) -> String {
        format!(" F{:.12}", feed / self.unit())
    }
    fn axes(&self, from: P, to: P) -> String {
        let (a, b) = (self.point(from), self.point(to));
        (0..3).map(|i| self.word(['X', 'Y', 'Z'][i], if self.incremental { b[i] - a[i] } else { b[i] })).collect()
    }
    /// The blocks of a path from `at`, and where it ends.
    fn write(&self, steps: &[Step], at: &mut P) -> String {
        let mut text = String::new();
        for step in steps {
            let from = *at;
            text += &match step {
                Step::Word(word) => (*word).to_owned(),
                Step::Rapid(p) => {
                    *at = *p;
                    format!("G0{}", self.axes(from, *p))
                }
                Step::Line(p, feed) => {
                    *at = *p;
                    format!("G1{}{}", self.axes(from, *p), self.feed(*feed))
                }
                Step::Arc { plane, centre, sweep, third, feed } => self.arc(*plane, *centre, *sweep, *third, *feed, at),
            };
            text.push('\n');
        }
        text
    }
    fn arc(&self, plane: usize, centre: [f64; 2], sweep: f64, third: f64, feed: f64, at: &mut P) -> String {
        let ([a, b, c], letters, code) = PLANES[plane];
        let from = *at;
        let (sin, cos) = sweep.to_radians().sin_cos();
        let mut middle = from;
        (middle[a], middle[b]) = (from[a] + centre[0], from[b] + centre[1]);
        at[c] += third;
        if sweep.abs() != 360.0 {
            at[a] = middle[a] - centre[0] * cos + centre[1] * sin;
            at[b] = middle[b] - centre[0] * sin - centre[1] * cos;
        }
        // a mirror in X turns the sense in the planes that hold X
        let reversed = self.mirror && plane < 2;
        let g = if (sweep > 0.0) != reversed { 3 } else { 2 };
        let turns = if sweep.abs() > 360.0 { format!(" P{}", (sweep.abs() / 360.0).ceil()) } else { String::new() };
        let head = format!("G{code} G{g}{}{}", self.axes(from, *at), self.feed(feed));
        if self.by_radius && sweep.abs() < 360.0 {
            let radius = self.scale * centre[0].hypot(centre[1]);
            return head + &self.word('R', if sweep.abs() > 180.0 { -radius } else { radius });
        }
        let middle = self.point(middle);
        let start = self.point(from);
        let offset = |i: usize| if self.absolute_centres { middle[i] } else { middle[i] - start[i] };
        head + &self.word(letters[0], offset(a)) + &self.word(letters[1], offset(b)) + &turns
    }
    /// The whole program.
    fn program(&self, head: &str, steps: &[Step]) -> String {
        let mut text = format!(
            "{}{}{head}\n",
            if self.inch { "G20" } else { "G21" },
            if self.absolute_centres { " G90.1" } else { "" }
        );
        text += if self.incremental { "G91\n" } else { "G90\n" };
        text + &self.write(steps, &mut [0.0; 3]) + "M30\n"
    }
}

fn translated(text: &str) -> Vec<Command> {
    commands(&program_for(text, &mill3(), &Options::default()))
}

/// The same commands, lines aside; angles and centres within `loose`.
fn same(a: &[Command], b: &[Command], loose: f64) -> Result<(), String> {
    let close = |x: f64, y: f64, by: f64| (x - y).abs() <= by * x.abs().max(1.0);
    let all = |x: &[f64], y: &[f64], by: f64| x.len() == y.len() && x.iter().zip(y).all(|(x, y)| close(*x, *y, by));
    let pair = |a: &Command, b: &Command| match (a, b) {
        (
            Command::Line { to, vl, tvl, rapid, .. },
            Command::Line { to: to2, vl: vl2, tvl: tvl2, rapid: rapid2, .. },
        ) => rapid == rapid2 && all(to, to2, 1e-9) && close(*vl, *vl2, 1e-9) && close(*tvl, *tvl2, 1e-9),
        (
            Command::Arc { axes, to, center, phi, vl, tvl, .. },
            Command::Arc { axes: axes2, to: to2, center: center2, phi: phi2, vl: vl2, tvl: tvl2, .. },
        ) => {
            axes == axes2
                && all(to, to2, 1e-9)
                && all(center, center2, loose)
                && close(*phi, *phi2, loose)
                && close(*vl, *vl2, 1e-9)
                && close(*tvl, *tvl2, 1e-9)
        }
        (
            Command::Ssf { axes, command, value, .. },
            Command::Ssf { axes: axes2, command: command2, value: value2, .. },
        ) => axes == axes2 && command == command2 && value == value2,
        (Command::Event { kind, text, .. }, Command::Event { kind: kind2, text: text2, .. }) => {
            kind == kind2 && text == text2
        }
        (Command::Drain(_), Command::Drain(_)) => true,
        (Command::Other(a), Command::Other(b)) => a == b,
        _ => false,
    };
    if a.len() != b.len() {
        return Err(format!("{} commands against {}", a.len(), b.len()));
    }
    match a.iter().zip(b).find(|(a, b)| !pair(a, b)) {
        Some((a, b)) => Err(format!("{a:?}\n{b:?}")),
        None => Ok(()),
    }
}

fn assert_same(steps: &[Step], head: &str, style: &Style, loose: f64) -> Result<(), TestCaseError> {
    let (plain, other) = (PLAIN.program("", steps), style.program(head, steps));
    let result = same(&translated(&plain), &translated(&other), loose);
    prop_assert!(result.is_ok(), "{}\n{plain}\n{other}", result.unwrap_err());
    Ok(())
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    prop::collection::vec(step(), 1..12)
}

proptest! {
    #[test]
    fn incremental_against_absolute(steps in steps()) {
        assert_same(&steps, "", &Style { incremental: true, ..PLAIN }, 1e-8)?;
    }
    #[test]
    fn inch_against_mm(steps in steps(), incremental: bool) {
        assert_same(&steps, "", &Style { inch: true, incremental, ..PLAIN }, 1e-8)?;
    }
    #[test]
    fn centres_absolute_against_from_the_start(steps in steps(), inch: bool) {
        assert_same(&steps, "", &Style { absolute_centres: true, inch, ..PLAIN }, 1e-8)?;
    }
    #[test]
    fn radius_against_centre(steps in steps(), incremental: bool) {
        assert_same(&steps, "", &Style { by_radius: true, incremental, ..PLAIN }, 1e-6)?;
    }
    #[test]
    fn mirrored_twice(steps in steps(), incremental: bool, line in -20.0..20.0f64, by_radius: bool) {
        let style = Style { mirror: true, by_radius, incremental, shift: [2.0 * line, 0.0, 0.0], ..PLAIN };
        assert_same(&steps, &format!("\nG51.1 X{line:.12}"), &style, 1e-6)?;
    }
    #[test]
    fn turned_by_360_or_there_and_back(steps in steps(), turn in -360.0..360.0f64, absolute_centres: bool) {
        // the plane must stay while G68 is active
        let flat: Vec<Step> = steps.into_iter().filter(|s| !matches!(s, Step::Arc { plane: 1 | 2, .. })).collect();
        assert_same(&flat, "\nG68 X3 Y-4 R360", &Style { absolute_centres, ..PLAIN }, 1e-8)?;
        assert_same(&flat, &format!("\nG68 X0 Y0 R{turn:.12}"), &Style { turn: -turn, absolute_centres, ..PLAIN }, 1e-7)?;
    }
    #[test]
    fn scaled_there_and_back(steps in steps(), factor in 0.3..3.0f64, by_radius: bool) {
        assert_same(&steps, &format!("\nG51 X0 Y0 Z0 P{factor:.12}"), &Style { scale: 1.0 / factor, by_radius, ..PLAIN }, 1e-6)?;
    }
    #[test]
    fn shifted_there_and_back(steps in steps(), x in -30.0..30.0f64, z in -30.0..30.0f64, kind in 0..4usize, incremental: bool) {
        let words = format!("X{x:.11} Z{z:.11}");
        let head = [format!("\nG52 {words}"), format!("\nG10 L2 P1 {words}"), format!("\nG10 L2 P3 {words}\nG56"), format!("\nG92 X{:.11} Z{:.11}", -x, -z)];
        let style = Style { shift: [-x, 0.0, -z], incremental, ..PLAIN };
        assert_same(&steps, &head[kind], &style, 1e-8)?;
    }

    /// A subprogram, in each notation, against its body written out.
    #[test]
    fn a_subprogram_against_its_expansion(body in steps(), before in steps(), count in 1..4usize, notation in 0..6usize) {
        let style = Style { incremental: true, ..PLAIN };
        // what is called several times must end where it began: then every pass is the same text
        let mut at = [0.0; 3];
        let start = style.write(&before, &mut at);
        let mut end = at;
        let mut inner = style.write(&body, &mut end);
        inner += &format!("G0{}\n", style.axes(end, at));
        let expanded = format!("G91\n{start}{}M30\n", inner.repeat(count));
        let text = match notation {
            0 => format!("G91\n{start}L100 O{count}\nM30\n%L 100\n{inner}M17\n"),
            1 => format!("G91\n{start}L PART O{count}\nM30\n%L PART\n{inner}M29\n"),
            2 => format!("G91\n{start}M98 P77 L{count}\nM30\nO77\n{inner}M99\n"),
            3 => format!("G91\n{start}G65 P77 L{count}\nM30\n:77\n{inner}M99\n"),
            4 => format!("G91\n{start}#1=0\nWHILE [#1 LT {count}] DO1\n{inner}#1=#1+1\nEND1\nM30\n"),
            _ => format!("G91\n{start}o5 repeat [{count}]\no6 call\no5 endrepeat\nM30\no6 sub\n{inner}o6 endsub\n"),
        };
        let profile = if notation == 5 { Profile::Linuxcnc } else { Profile::Din };
        let options = Options { profile: Some(profile), ..Options::default() };
        let translated = |text: &str| commands(&program_for(text, &mill3(), &options));
        let result = same(&translated(&expanded), &translated(&text), 1e-9);
        prop_assert!(result.is_ok(), "{}\n{expanded}\n{text}", result.unwrap_err());
    }
}
