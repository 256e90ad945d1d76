//! The predefined names of rw_SymPas (6.3 to 6.6), each once. Everything else is derived from these lines.

/// Types of values (5.3.1.2). Axis specifiers are no values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Type {
    Boolean,
    Integer,
    Timer,
    Single,
    Double,
}

impl Type {
    pub const ALL: [Type; 5] = [Type::Boolean, Type::Integer, Type::Timer, Type::Single, Type::Double];
    pub const fn name(self) -> &'static str {
        match self {
            Type::Boolean => "Boolean",
            Type::Integer => "Integer",
            Type::Timer => "Timer",
            Type::Single => "Single",
            Type::Double => "Double",
        }
    }
}

/// What a program may do with a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    Read,
    ReadWrite,
    /// Any value written clears latched flags.
    ReadClear,
}

/// Declares an enum whose members carry the manual's name, a type, an access and a text.
macro_rules! registers {
    ($(#[$doc:meta])* $name:ident { $($item:ident = $manual:literal, $type:ident, $access:ident, $text:literal;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[allow(non_camel_case_types)] // the manual's own names
        pub enum $name { $(#[doc = $text] $item,)* }

        impl $name {
            pub const ALL: &'static [$name] = &[$($name::$item,)*];
            /// Name, type, access and meaning.
            pub const fn row(self) -> (&'static str, Type, Access, &'static str) {
                match self { $($name::$item => ($manual, Type::$type, Access::$access, $text),)* }
            }
            pub const fn name(self) -> &'static str { self.row().0 }
            pub const fn kind(self) -> Type { self.row().1 }
            pub const fn access(self) -> Access { self.row().2 }
            /// The register of that name; the case counts.
            pub fn by_name(name: &str) -> Option<$name> {
                Self::ALL.iter().copied().find(|item| item.name() == name)
            }
            pub fn by_number(number: u8) -> Option<$name> {
                Self::ALL.get(usize::from(number)).copied()
            }
        }
    };
}

registers! {
    /// System parameters (6.3.1, table 32), without the common variables CI and CD.
    SystemParameter {
        BOARDTYPE = "BOARDTYPE", Integer, Read, "4: APCI-8001, 32: APCI-8008";
        CFLAG = "CFLAG", Integer, ReadWrite, "ControllerFlags of the first axis";
        CLOCK = "CLOCK", Timer, Read, "ticks of 64 us, cyclic";
        DTCA1 = "DTCA1", Double, ReadWrite, "circle centre of helix in target form, first axis";
        DTCA2 = "DTCA2", Double, ReadWrite, "circle centre of helix in target form, second axis";
        DTCA3 = "DTCA3", Double, ReadWrite, "circle centre, third axis";
        ERRORREG = "ERRORREG", Integer, ReadWrite, "system errors, cleared by writing 0";
        GFAUX = "GFAUX", Double, ReadWrite, "ratio auxiliary register to set position, first axis";
        IRQPC = "IRQPC", Boolean, ReadWrite, "PC interrupt request";
        LEDGN = "LEDGN", Boolean, ReadWrite, "green LED";
        LEDRD = "LEDRD", Boolean, ReadWrite, "red LED";
        LEDYL = "LEDYL", Boolean, ReadWrite, "yellow LED";
        LET = "LET", Double, ReadWrite, "duration of a recording, s";
        LST = "LST", Double, ReadWrite, "start delay of a recording, s";
        MODEREG = "MODEREG", Integer, ReadWrite, "option bits";
        NFRAX = "NFRAX", Integer, ReadWrite, "mask of the axes without feed rate";
        NOA = "NOA", Integer, Read, "number of axes";
        OSVERSION = "OSVERSION", Integer, Read, "version of the operating system";
        PHI = "PHI", Double, ReadWrite, "angle of a circle, degrees";
        PN1 = "PN1", Double, ReadWrite, "plane normal, first axis";
        PN2 = "PN2", Double, ReadWrite, "plane normal, second axis";
        PN3 = "PN3", Double, ReadWrite, "plane normal, third axis";
        PU = "PU", Integer, ReadWrite, "position unit of moves";
        SSFP = "SSFP", Integer, ReadWrite, "function code of ssf";
        TRAC = "TRAC", Double, ReadWrite, "path acceleration, PU/TU^2";
        TROVR = "TROVR", Double, ReadWrite, "path override, effective with utrovr";
        TROVRST = "TROVRST", Double, ReadWrite, "ramp time of an override change of 1.0, s";
        TRTVL = "TRTVL", Double, ReadWrite, "path target velocity, PU/TU";
        TRVL = "TRVL", Double, ReadWrite, "path velocity, PU/TU";
        TU = "TU", Integer, ReadWrite, "time unit of moves";
    }
}

registers! {
    /// Axis qualifiers (6.3.3, table 37) beside `an`, which is the slot of the axis itself.
    Qualifier {
        aux = "aux", Double, ReadWrite, "auxiliary register";
        axst = "axst", Integer, Read, "axis status";
        CFLAGS = "CFLAGS", Integer, ReadWrite, "ControllerFlags";
        cflags = "cflags", Integer, ReadWrite, "ControllerFlags";
        digi = "digi", Integer, ReadClear, "digital inputs";
        digo = "digo", Integer, ReadWrite, "digital outputs";
        dp = "dp", Double, ReadWrite, "set position";
        dpoffset = "dpoffset", Double, ReadWrite, "offset of the set position";
        dv = "dv", Double, Read, "set velocity";
        dvoffset = "dvoffset", Double, ReadWrite, "rate of change of dpoffset";
        effradius = "effradius", Double, ReadWrite, "effective radius of a rotary axis, PU";
        epc = "epc", Integer, Read, "EEPROM programming cycles";
        gcr = "gcr", Integer, ReadWrite, "electronic gear";
        gf = "gf", Double, ReadWrite, "gear factor";
        gfaux = "gfaux", Double, ReadWrite, "ratio auxiliary register to set position";
        hac = "hac", Double, ReadWrite, "home acceleration";
        hvl = "hvl", Double, ReadWrite, "home velocity";
        ifs = "ifs", Integer, ReadClear, "interface status";
        ipw = "ipw", Double, ReadWrite, "in-position window";
        jac = "jac", Double, ReadWrite, "jog acceleration";
        jerkrel = "jerkrel", Double, ReadWrite, "share of the ramps of S profiles";
        jovr = "jovr", Double, ReadWrite, "jog override";
        jtvl = "jtvl", Double, ReadWrite, "jog target velocity";
        jvl = "jvl", Double, ReadWrite, "jog velocity";
        kd = "kd", Double, ReadWrite, "differential coefficient, effective with uf";
        kfca = "kfca", Double, ReadWrite, "acceleration feed-forward, effective with uf";
        kfcv = "kfcv", Double, ReadWrite, "velocity feed-forward, effective with uf";
        ki = "ki", Double, ReadWrite, "integral coefficient, effective with uf";
        kp = "kp", Double, ReadWrite, "proportional coefficient, effective with uf";
        kpl = "kpl", Double, ReadWrite, "phase lead, effective with uf";
        lp = "lp", Double, ReadWrite, "latched position";
        lpndx = "lpndx", Double, ReadWrite, "position latched by the index";
        lsm = "lsm", Integer, Read, "free spool memory, bytes";
        maxacc = "maxacc", Double, ReadWrite, "maximum acceleration of interpolations";
        maxvel = "maxvel", Double, ReadWrite, "maximum velocity of interpolations";
        mcis = "mcis", Integer, Read, "motion commands in the spooler";
        mcp = "mcp", Integer, ReadWrite, "motor command port";
        mdvel = "mdvel", Double, ReadWrite, "largest velocity step at a junction";
        mpe = "mpe", Double, ReadWrite, "largest following error";
        poserr = "poserr", Double, Read, "following error dp - rp";
        pprev = "pprev", Double, Read, "encoder pulses per motor revolution";
        rp = "rp", Double, ReadWrite, "actual position, written in open loop only";
        rv = "rv", Double, Read, "actual velocity";
        sdec = "sdec", Double, ReadWrite, "stop deceleration";
        sf = "sf", Integer, ReadWrite, "application-specific special register";
        sll = "sll", Double, ReadWrite, "left software limit";
        slr = "slr", Double, ReadWrite, "right software limit";
        slsp = "slsp", Double, ReadWrite, "slits or steps per motor revolution";
        tp = "tp", Double, ReadWrite, "target position of the last command";
        zerooffset = "zerooffset", Double, Read, "total of the zero offsets";
    }
}

registers! {
    /// Structured axis qualifiers (6.3.4, table 38), `axis.name.n` with n from 1.
    BitQualifier {
        axstb = "axstb", Boolean, Read, "bit of the axis status";
        digib = "digib", Boolean, Read, "digital input";
        digob = "digob", Boolean, ReadWrite, "digital output";
        ifsb = "ifsb", Boolean, Read, "bit of the interface status";
    }
}

/// Application-specific variables by index: `SysVarInt[n]` (6.3.2) and `axis.varint[n]` (2.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Indexed {
    Integer,
    Double,
}

/// Declares an enum whose members carry the manual's name, which is found in any case.
macro_rules! names {
    ($(#[$doc:meta])* $name:ident { $($item:ident = $manual:literal;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name { $($item,)* }

        impl $name {
            pub const ALL: &'static [$name] = &[$($name::$item,)*];
            /// The name as the manual prints it in a table.
            pub const fn name(self) -> &'static str {
                match self { $($name::$item => $manual,)* }
            }
            /// The member of that name, in any case.
            pub fn by_name(name: &str) -> Option<$name> {
                Self::ALL.iter().copied().find(|item| item.name().eq_ignore_ascii_case(name))
            }
            pub fn by_number(number: u8) -> Option<$name> {
                Self::ALL.get(usize::from(number)).copied()
            }
        }
    };
}

names! {
    /// Functions of one Double (6.6); the result is Double, angles are in rad.
    Function {
        Abs = "abs";
        Acos = "acos";
        Asin = "asin";
        Atan = "atan";
        Cos = "cos";
        Cosh = "cosh";
        Exp = "exp";
        Ln = "ln";
        Sin = "sin";
        Sinh = "sinh";
        Sqr = "sqr";
        Sqrt = "sqrt";
        Tan = "tan";
        Tanh = "tanh";
    }
}

/// The argument list of a command (6.6, call forms).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// No arguments.
    Nothing,
    /// Axes.
    Axes,
    /// One axis.
    OneAxis,
    /// `axis := value, ...`, at least one. Path parameters may be given too where `path` is true.
    Values { path: bool },
    /// Two axes and their centre, PHI.
    Circle,
    /// As a circle, with further axes and their targets; or the target form with DTCA1, DTCA2.
    Helix,
    /// Three axes and their centre, PN1 to PN3, PHI.
    Circle3d,
    /// `axis := value, ...` with SSFP.
    SpoolFunction,
}

names! {
    /// Commands of axes (6.6). Those that wait (`jaw` is `ja` and then waits) are derived: [`waiting`].
    Command {
        Cl = "cl";
        Clv = "clv";
        Ja = "ja";
        Jhi = "jhi";
        Jhl = "jhl";
        Jhr = "jhr";
        Jr = "jr";
        Js = "js";
        Lpr = "lpr";
        Lprs = "lprs";
        Mca = "mca";
        Mca3d = "mca3d";
        Mcr = "mcr";
        Mcr3d = "mcr3d";
        Mha = "mha";
        Mhr = "mhr";
        Mla = "mla";
        Mlr = "mlr";
        Ms = "ms";
        Ol = "ol";
        Ra = "ra";
        Rptodp = "rptodp";
        Rs = "rs";
        Shp = "shp";
        Smca = "smca";
        Smca3d = "smca3d";
        Smcr = "smcr";
        Smcr3d = "smcr3d";
        Smha = "smha";
        Smhr = "smhr";
        Smla = "smla";
        Smlr = "smlr";
        Ssf = "ssf";
        Ssms = "ssms";
        Szpa = "szpa";
        Szpr = "szpr";
        Uf = "uf";
        Utrovr = "utrovr";
    }
}

impl Command {
    /// Its argument list.
    pub const fn form(self) -> Form {
        use Command::*;
        match self {
            Cl | Clv | Jhl | Jhr | Js | Lprs | Ms | Ol | Ra | Rptodp | Ssms | Uf | Utrovr => Form::Axes,
            Ja | Jhi | Jr | Shp | Szpa | Szpr => Form::Values { path: false },
            Lpr => Form::OneAxis,
            Mca | Mcr | Smca | Smcr => Form::Circle,
            Mca3d | Mcr3d | Smca3d | Smcr3d => Form::Circle3d,
            Mha | Mhr | Smha | Smhr => Form::Helix,
            Mla | Mlr | Smla | Smlr => Form::Values { path: true },
            Rs => Form::Nothing,
            Ssf => Form::SpoolFunction,
        }
    }
}

/// The commands that have a waiting form: the name with a `w` behind it.
const WITH_WAIT: [Command; 16] = [
    Command::Ja,
    Command::Jhi,
    Command::Jhl,
    Command::Jhr,
    Command::Jr,
    Command::Js,
    Command::Mca,
    Command::Mca3d,
    Command::Mcr,
    Command::Mcr3d,
    Command::Mha,
    Command::Mhr,
    Command::Mla,
    Command::Mlr,
    Command::Ms,
    Command::Ssms,
];

/// The command of that name in any case, and whether it waits for the profile end of its axes (6.5).
pub fn command(name: &str) -> Option<(Command, bool)> {
    if let Some(command) = Command::by_name(name) {
        return Some((command, false));
    }
    let plain = name.strip_suffix(['w', 'W'])?;
    Command::by_name(plain).filter(|c| WITH_WAIT.contains(c)).map(|c| (c, true))
}

names! {
    /// Commands for a task (6.6), with an Integer constant 0 to 3.
    TaskCommand {
        Contcnct = "contcnct";
        Startcnct = "startcnct";
        Stepcnct = "stepcnct";
        Stopcnct = "stopcnct";
        Stoptoss = "stoptoss";
    }
}

names! {
    /// Events (6.4), in the order of their priority; the names of their handlers, in upper case only.
    Event {
        Eveo = "EVEO";
        Evdnr = "EVDNR";
        Evlsh = "EVLSH";
        Evlss = "EVLSS";
        Evmpe = "EVMPE";
        Evui = "EVUI";
        Evendat = "EVENDAT";
    }
}

/// Names that are no lines of a table because their form is their own: control of the own task, time, output, common
/// buffer and zero offsets. In any case.
pub const SPECIAL: [&str; 15] = [
    "abort", "azo", "disev", "enev", "power", "rdcbd", "rdcbi", "rdcbs", "stop", "wrcbd", "wrcbi", "wrcbs", "write",
    "writeln", "wt",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_found_in_any_case_with_their_waiting_forms() {
        assert_eq!(command("SMLA"), Some((Command::Smla, false)));
        assert_eq!(command("mca3dw"), Some((Command::Mca3d, true)));
        assert_eq!(command("smlaw"), None);
        assert_eq!(command("w"), None);
        assert_eq!(Command::Mha.form(), Form::Helix);
    }

    #[test]
    fn registers_are_found_in_their_own_case_only() {
        assert_eq!(SystemParameter::by_name("TRVL").map(SystemParameter::kind), Some(Type::Double));
        assert_eq!(SystemParameter::by_name("trvl"), None);
        assert_eq!(Qualifier::by_name("dp").map(Qualifier::access), Some(Access::ReadWrite));
        assert_eq!(Qualifier::by_name("DP"), None);
    }

    #[test]
    fn no_name_stands_twice() {
        let mut all: Vec<String> = SPECIAL.iter().map(|s| (*s).to_owned()).collect();
        all.extend(Command::ALL.iter().map(|c| c.name().to_owned()));
        all.extend(WITH_WAIT.iter().map(|c| format!("{}w", c.name())));
        all.extend(Function::ALL.iter().map(|f| f.name().to_owned()));
        all.extend(TaskCommand::ALL.iter().map(|c| c.name().to_owned()));
        let count = all.len();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), count);
    }
}
