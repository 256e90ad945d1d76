//! The conditions of events (6.4).

use super::tables::Event;
use crate::mcu::Mcu;
use crate::registers::Axst;

/// The flags of axst that are the condition of an event. EVENDAT is none of them.
const fn flags(event: Event) -> Axst {
    match event {
        Event::Eveo => Axst::eo,
        Event::Evdnr => Axst::dnr,
        Event::Evlsh => Axst(Axst::lslh.0 | Axst::lsrh.0),
        Event::Evlss => Axst(Axst::lsls.0 | Axst::lsrs.0),
        Event::Evmpe => Axst::mpe,
        Event::Evui => Axst::ui,
        Event::Evendat => Axst(0),
    }
}

/// The events whose condition is fulfilled at some axis, as bits in the order of [`Event::ALL`].
pub fn active(mcu: &Mcu) -> u8 {
    let all = mcu.all_axes().iter().fold(0, |all, a| all | mcu.axst(a).0);
    let holds = |e: Event| Axst(all).any(flags(e)) || e == Event::Evendat && mcu.has_endat_error();
    Event::ALL.iter().filter(|&&e| holds(e)).fold(0, |bits, &e| bits | 1 << e as u8)
}
