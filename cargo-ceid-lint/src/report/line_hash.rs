//! The hash by which GitHub code scanning knows the line of an alert again: `primaryLocationLineHash`, as its upload action
//! computes it (github/codeql-action, `src/fingerprints.ts`).

use rustc_hash::FxHashMap;

/// How many characters from the beginning of a line make up its hash.
const BLOCK: usize = 100;
const FACTOR: u64 = 37;
const END_OF_FILE: u64 = 0xffff;

/// One hash for each line of a text, with the number of its occurrence: `c129715d7a2bc9a3:1`.
///
/// Spaces and tabs do not count, line breaks of all kinds are one character, and a line too short for a block goes on with
/// the lines behind it.
pub(super) fn line_hashes(text: &str) -> Vec<String> {
    let (mut units, starts) = units_and_line_starts(text);
    units.resize(units.len() + BLOCK, 0);
    let mut before = vec![0_u64];
    for unit in &units {
        let hash = before.last().copied().unwrap_or_default();
        before.push(hash.wrapping_mul(FACTOR).wrapping_add(*unit));
    }
    let of_block = (0..BLOCK).fold(1_u64, |power, _| power.wrapping_mul(FACTOR));
    let mut seen: FxHashMap<u64, u32> = FxHashMap::default();
    let numbered = starts.into_iter().map(|start| {
        let hash = before[start + BLOCK].wrapping_sub(before[start].wrapping_mul(of_block));
        let occurrence = seen.entry(hash).or_default();
        *occurrence += 1;
        format!("{hash:x}:{occurrence}")
    });
    numbered.collect()
}

/// The characters that count, as UTF-16 units with a mark at the end, and where the lines begin among them.
fn units_and_line_starts(text: &str) -> (Vec<u64>, Vec<usize>) {
    const LINE_FEED: u16 = b'\n' as u16;
    const CARRIAGE_RETURN: u16 = b'\r' as u16;
    const SKIPPED: [u16; 2] = [b' ' as u16, b'\t' as u16];
    let mut units = Vec::with_capacity(text.len() + 1);
    let mut starts = vec![0];
    let mut is_after_return = false;
    for unit in text.encode_utf16() {
        let is_second_half_of_break = is_after_return && unit == LINE_FEED;
        is_after_return = unit == CARRIAGE_RETURN;
        if is_second_half_of_break || SKIPPED.contains(&unit) {
            continue;
        }
        if unit == LINE_FEED || unit == CARRIAGE_RETURN {
            units.push(u64::from(LINE_FEED));
            starts.push(units.len());
        } else {
            units.push(u64::from(unit));
        }
    }
    units.push(END_OF_FILE);
    (units, starts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: &[&str]) {
        assert_eq!(line_hashes(text), expected);
    }

    // The vectors are those that the upload action is tested with.
    #[test]
    fn an_empty_file_has_one_line() {
        check("", &["c129715d7a2bc9a3:1"]);
    }

    #[test]
    fn spaces_and_tabs_do_not_count() {
        let hashes = ["271789c17abda88f:1", "54703d4cd895b18:1", "180aee12dab6264:1", "a23a3dc5e078b07b:1"];
        check(" a\nb\n  \t\tc\n d", &hashes);
    }

    #[test]
    fn line_breaks_of_all_kinds_are_one_character() {
        let hashes = [
            "e9496ae3ebfced30:1",
            "fb7c023a8b9ccb3f:1",
            "ce8ba1a563dcdaca:1",
            "e20e36e16fcb0cc8:1",
            "b3edc88f2938467e:1",
            "c8e28b0b4002a3a0:1",
            "c129715d7a2bc9a3:1",
        ];
        check(" hello; \t\nworld!!!\n\n\n  \t\tGreetings\n End\n", &hashes);
        check(" hello; \t\nworld!!!\r\r\r  \t\tGreetings\r End\r", &hashes);
        check(" hello; \t\r\nworld!!!\r\n\r\n\r\n  \t\tGreetings\r\n End\r\n", &hashes);
        check(" hello; \t\nworld!!!\r\n\n\r  \t\tGreetings\r End\r\n", &hashes);
    }

    #[test]
    fn equal_lines_are_numbered() {
        let hashes = [
            "a7f2ff13bc495cf2:1",
            "a7f2ff13bc495cf2:2",
            "a7f2ff13bc495cf2:3",
            "a7f2ff13bc495cf2:4",
            "a7f2ff13bc495cf2:5",
            "a7f2ff13bc495cf2:6",
            "a7f2ff1481e87703:1",
            "a9cf91f7bbf1862b:1",
            "55ec222b86bcae53:1",
            "cc97dc7b1d7d8f7b:1",
            "c129715d7a2bc9a3:1",
        ];
        check(&"Lorem ipsum dolor sit amet.\n".repeat(10), &hashes);
    }
}
