//! Bits of what a function gives back on a way: see [`super::summary::Outcome`].

pub(super) const PRESENT: u8 = 1;
pub(super) const ABSENT: u8 = 2;
pub(super) const TRUE: u8 = 4;
pub(super) const FALSE: u8 = 8;
pub(super) const OTHER: u8 = 16;
pub(super) const ANY: u8 = 31;

/// The bit of a head.
pub(super) fn bit(head: &str) -> u8 {
    match head {
        "+" => PRESENT,
        "-" => ABSENT,
        "true" => TRUE,
        "false" => FALSE,
        _ => OTHER,
    }
}
