//! Bits of what a function gives back on a way: see [`super::summary::Outcome`].

/// Which heads a result may have: a bit for each of the known ones, and one of several for any other.
pub(super) type Heads = u32;

pub(super) const PRESENT: Heads = 1;
pub(super) const ABSENT: Heads = 2;
pub(super) const TRUE: Heads = 4;
pub(super) const FALSE: Heads = 8;
pub(super) const OTHER: Heads = !(PRESENT | ABSENT | TRUE | FALSE);
pub(super) const ANY: Heads = Heads::MAX;

/// The bit of a head. Heads that share a bit are not told apart.
pub(super) fn bit(head: &str) -> Heads {
    match head {
        "+" => PRESENT,
        "-" => ABSENT,
        "true" => TRUE,
        "false" => FALSE,
        _ => {
            let hash = head.bytes().fold(0u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(16_777_619));
            1 << (OTHER.trailing_zeros() + hash % OTHER.count_ones())
        }
    }
}
