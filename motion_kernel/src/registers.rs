//! The bit-coded registers of the controller. Each register is one table; names, masks and texts
//! everywhere else come from it. Bits are given by number, never by mask.

/// Declares a register: one line per bit, `name = number, "text";`.
macro_rules! bits {
    ($(#[$doc:meta])* $name:ident { $($bit:ident = $number:literal, $manual:literal, $text:literal;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        pub struct $name(pub u32);

        #[allow(non_upper_case_globals)] // the manual's own names
        impl $name {
            $(#[doc = $text] pub const $bit: $name = $name(1 << $number);)*
            /// Every assigned bit: number, the manual's name, text.
            pub const ALL: &'static [(u32, &'static str, &'static str)] = &[$(($number, $manual, $text),)*];

            pub const fn has(self, bits: $name) -> bool {
                self.0 & bits.0 == bits.0
            }
            pub const fn any(self, bits: $name) -> bool {
                self.0 & bits.0 != 0
            }
            pub fn set(&mut self, bits: $name) {
                self.0 |= bits.0;
            }
            pub fn clear(&mut self, bits: $name) {
                self.0 &= !bits.0;
            }
            pub fn put(&mut self, bits: $name, on: bool) {
                if on { self.set(bits) } else { self.clear(bits) }
            }
            /// Names of the bits that are set, in ascending order.
            pub fn names(self) -> impl Iterator<Item = &'static str> {
                Self::ALL.iter().filter(move |(n, _, _)| self.0 >> n & 1 == 1).map(|(_, name, _)| *name)
            }
            /// The bit of that name.
            pub fn by_name(name: &str) -> Option<$name> {
                Self::ALL.iter().find(|(_, n, _)| *n == name).map(|(n, _, _)| $name(1 << n))
            }
        }

        impl std::ops::BitOr for $name {
            type Output = $name;
            fn bitor(self, other: $name) -> $name { $name(self.0 | other.0) }
        }
    };
}

bits! {
    /// Axis status (4.4.45, table 12).
    Axst {
        eo = 1, "eo", "emergency out: an EO input is active";
        dnr = 2, "dnr", "drive not ready: a DR input is inactive";
        lslh = 3, "lslh", "left hardware limit switch";
        lsrh = 4, "lsrh", "right hardware limit switch";
        lsls = 5, "lsls", "left software limit passed";
        lsrs = 6, "lsrs", "right software limit passed";
        mpe = 7, "mpe", "following error above mpe";
        dhef = 8, "dhef", "data handling error";
        cef = 9, "cef", "configuration error";
        pe = 12, "pe", "profile end reached";
        cl = 13, "cl", "loop closed";
        ip = 14, "ip", "in position";
        ui = 15, "ui", "a UI input is active";
        lpsf = 16, "lpsf", "position latched";
        referenced = 17, "referenced", "home position set";
        refh = 18, "refh", "a REF input is active";
        saf = 19, "saf", "spooler asynchronous in its group";
    }
}

bits! {
    /// System errors (4.4.63.1, table 15). Sticky: only writing 0 or a boot clears them.
    ErrorReg {
        errAxDef = 0, "errAxDef", "an axis was selected twice in a motion command";
        errTargetVel = 1, "errTargetVel", "target velocity not 0 at the end of the spooler";
        errUnit = 2, "errUnit", "invalid unit";
        errCenterPoint = 3, "errCenterPoint", "invalid centre of a circle";
        errSpoolerOverrun = 4, "errSpoolerOverrun", "spooler overflow";
        ProfileToSmall = 5, "ProfileToSmall", "two spooled profiles in a row shorter than a sample";
        SplineSizeErr = 6, "SplineSizeErr", "too many spline records";
        RotationFail = 7, "RotationFail", "axis rotation failed";
        PciBusError = 8, "PciBusError", "PCI bridge error";
        CheckMonitorScreen = 9, "CheckMonitorScreen", "a message was written to the monitor screen";
        SsfWaitRefused = 10, "SsfWaitRefused", "a wait command was ignored, the motion before it does not stop";
        SpoolerLoadError = 11, "SpoolerLoadError", "the spooler was written while the system generated a profile";
        VelocityZero = 12, "VelocityZero", "interpolation with velocity 0 discarded";
        AccelZero = 13, "AccelZero", "interpolation with acceleration 0 discarded";
        LimitDefError = 14, "LimitDefError", "invalid mcp limit";
        ZeroProfile = 15, "ZeroProfile", "interpolation without distance discarded";
        RadiusError = 16, "RadiusError", "circle with radius 0 discarded";
        SpoolerDeepToLess = 17, "SpoolerDeepToLess", "too few profiles in the spooler for the look-ahead";
        IOResetHandled = 18, "IOResetHandled", "unexpected reset of inputs and outputs";
        JSatSAFdone = 19, "JSatSAFdone", "axes were stopped because their spoolers ran asynchronously";
    }
}

bits! {
    /// MODEREG (6.3.1.5, table 36).
    ModeReg {
        LookAhead = 0, "LookAhead", "limit junction velocities by mdvel, stop at the end of the spooler";
        SProfile = 1, "SProfile", "S-shaped ramps";
        WkzRadKorr = 3, "WkzRadKorr", "tool radius correction of option TC";
        AutoSpool = 5, "AutoSpool", "start a full spooler by itself";
        NoTriangle = 6, "NoTriangle", "no triangular profiles inside a chain";
        ChkMaxVel = 7, "ChkMaxVel", "limit lines by maxvel and maxacc of every axis";
        ExactTargetPos = 8, "ExactTargetPos", "no rounding to counts at a stop";
        ShortestRotatoricDistance = 9, "ShortestRotatoricDistance", "absolute jogs of rotary axes take the short way";
        RotatoricUnit = 10, "RotatoricUnit", "rotary targets of interpolations in the axis unit";
        ForbidTargetVel = 11, "ForbidTargetVel", "reset if the spooler ends with a target velocity";
        CenterAlwaysRel = 12, "CenterAlwaysRel", "circle centres of G02 and G03 always relative";
        NoLsmCheck = 13, "NoLsmCheck", "no check of the spooler memory at G01";
        MS_DECEL = 15, "MS_DECEL", "motion stop brakes with TRAC";
        SimulationMode = 24, "SimulationMode", "actual positions are simulated, no motor command";
        OvrMode = 25, "OvrMode", "utrovr leaves jovr unchanged";
        StopAtWriteln = 26, "StopAtWriteln", "writeln stops the task";
        ClearZeroPosition = 27, "ClearZeroPosition", "clear the shift of szpa and szpr";
        JSatSAF = 28, "JSatSAF", "stop all axes when a spooler runs asynchronously";
        InhibitProfileRefuse = 29, "InhibitProfileRefuse", "no message for discarded profiles";
    }
}

bits! {
    /// ControllerFlags of a servo axis (6.3.1.4, table 35).
    ControllerFlags {
        MoveControl = 0, "MoveControl", "the Move flags act while the axis executes a profile";
        MoveZero = 1, "MoveZero", "the integral part is cleared";
        MoveDeadBand = 2, "MoveDeadBand", "the integral part does not grow outside the dead band";
        MoveFix = 3, "MoveFix", "the integral part is held";
        StopControl = 8, "StopControl", "the Stop flags act while the axis stands in closed loop";
        StopZero = 9, "StopZero", "the integral part is cleared";
        StopDeadBand = 10, "StopDeadBand", "the integral part does not grow outside the dead band";
        StopFix = 11, "StopFix", "the integral part is held";
    }
}

bits! {
    /// Signals of one axis in its digi word, beside the 16 digital inputs (4.4.52.1).
    Digi {
        index = 16, "index", "index signal of the encoder, as it is now";
        error = 17, "error", "error of the measuring system, stored";
        index_edge = 18, "index_edge", "index signal of the encoder, stored edge";
        strobe = 19, "strobe", "hardware latch signal, stored edge";
        AEA = 20, "AEA", "encoder alarm of channel A";
        AEB = 21, "AEB", "encoder alarm of channel B";
        AEN = 22, "AEN", "encoder alarm of the index channel";
        AES = 23, "AES", "encoder alarm, sum of all";
    }
}

bits! {
    /// Interface status (4.4.70.1).
    Ifs {
        edv = 0, "edv", "the data in the EEPROM are valid";
        cncrdy = 1, "cncrdy", "the CNC-ready relay is closed";
        pfe = 16, "pfe", "supply below 2.85 V, also after power-up";
        wdog = 17, "wdog", "watchdog of the primary circuit";
        iae = 18, "iae", "invalid access inside the operating system";
        scwdog = 19, "scwdog", "watchdog of the secondary circuit";
        scpfe = 20, "scpfe", "supply below 4.75 V, also after power-up";
        bus_error = 21, "bus_error", "communication error";
        EpmBaseResetFlag = 22, "EpmBaseResetFlag", "reset of the inputs and outputs of the base board";
        EpmOpmfResetFlag = 23, "EpmOpmfResetFlag", "reset of the inputs and outputs of the option board";
    }
}

bits! {
    /// Options of the operating system and of the board.
    Options {
        RESOURCE = 0, "RESOURCE", "the resource interface";
        PCI = 1, "PCI", "access to the memory of the host";
        GEAR = 2, "GEAR", "electronic gear";
        ENDAT = 3, "ENDAT", "ENDAT encoders";
        DMARTS = 4, "DMARTS", "DMA latch";
        RTS_ANALOGIN = 5, "RTS_ANALOGIN", "DMA latch with analog inputs";
        ISIS = 6, "ISIS", "Isis sensors and RayDex";
        FAST_PULSE = 7, "FAST_PULSE", "board with fast pulse outputs";
        EP1K50 = 8, "EP1K50", "board with the large logic device";
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_from_the_table() {
        let status = Axst::pe | Axst::cl;
        assert_eq!(status.0, 0x3000);
        assert_eq!(status.names().collect::<Vec<_>>(), ["pe", "cl"]);
        assert_eq!(ModeReg::by_name("JSatSAF"), Some(ModeReg(1 << 28)));
        assert_eq!(Axst::by_name("nosuch"), None);
    }

    #[test]
    fn no_bit_stands_twice() {
        for table in [Axst::ALL, ErrorReg::ALL, ModeReg::ALL, ControllerFlags::ALL, Digi::ALL, Ifs::ALL, Options::ALL] {
            let mut numbers: Vec<u32> = table.iter().map(|row| row.0).collect();
            numbers.dedup();
            assert_eq!(numbers.len(), table.len());
            assert!(numbers.is_sorted());
        }
    }
}
