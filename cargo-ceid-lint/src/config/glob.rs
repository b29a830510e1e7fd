//! Patterns for names and paths: `*`, `?`, `[ab]`, and `**` for any number of directories. Never touches the disk.

/// Whether `text` is named by `pattern`. `*` and `?` stop at `/`, `**` does not.
#[must_use]
pub fn matches(pattern: &str, text: &str) -> bool {
    let pattern: Vec<char> = pattern.chars().collect();
    let text: Vec<char> = text.chars().collect();
    matches_from(&pattern, &text)
}

/// Whether `pattern` is more than a plain name.
#[must_use]
pub fn is_pattern(pattern: &str) -> bool {
    pattern.contains(['*', '?', '['])
}

/// Whether a set is opened in `pattern` that nothing closes.
#[must_use]
pub fn is_unclosed(pattern: &str) -> bool {
    let mut rest = pattern;
    while let Some((_, set)) = rest.split_once('[') {
        let Some((_, behind)) = set.split_once(']') else { return true };
        rest = behind;
    }
    false
}

/// The choice that braces enclose in a pattern, with what stands before them and behind: `src/{gen,ok}/**`. Braces around one name are
/// a part of it.
#[must_use]
pub fn choice(pattern: &str) -> Option<(&str, (&str, &str))> {
    let (before, rest) = pattern.split_once('{')?;
    let (choice, behind) = rest.split_once('}')?;
    choice.contains(',').then_some((before, (choice, behind)))
}

/// The rows of the table "does the pattern up to here match the text up to there", one for each character of the pattern:
/// the time is bounded by the product of both lengths, whatever the pattern.
fn matches_from(pattern: &[char], text: &[char]) -> bool {
    let mut row = vec![false; text.len() + 1];
    row[0] = true;
    let mut rest = pattern;
    while let Some((&first, tail)) = rest.split_first() {
        let (next, tail) = match first {
            '*' if tail.first() == Some(&'*') => {
                let tail = &tail[1..];
                match tail.split_first() {
                    // `**/` also stands for no directory at all.
                    Some(('/', tail)) => (any_directories(&row, text), tail),
                    _ => (spread(&row, |_| true, text), tail),
                }
            }
            '*' => (spread(&row, |c| c != '/', text), tail),
            '?' => (step(&row, |c| c != '/', text), tail),
            '[' => match tail.iter().position(|c| *c == ']') {
                Some(end) => {
                    let (set, tail) = (&tail[..end], &tail[end + 1..]);
                    (step(&row, |c| is_in_set(set, c), text), tail)
                }
                None => (step(&row, |c| c == '[', text), tail),
            },
            literal => (step(&row, |c| c == literal, text), tail),
        };
        row = next;
        rest = tail;
    }
    row[text.len()]
}

fn step(row: &[bool], accepts: impl Fn(char) -> bool, text: &[char]) -> Vec<bool> {
    let mut next = vec![false; row.len()];
    for (at, c) in text.iter().enumerate() {
        next[at + 1] = row[at] && accepts(*c);
    }
    next
}

fn spread(row: &[bool], accepts: impl Fn(char) -> bool, text: &[char]) -> Vec<bool> {
    let mut next = row.to_vec();
    for (at, c) in text.iter().enumerate() {
        next[at + 1] |= next[at] && accepts(*c);
    }
    next
}

fn any_directories(row: &[bool], text: &[char]) -> Vec<bool> {
    let reached = spread(row, |_| true, text);
    let mut next = row.to_vec();
    for (at, c) in text.iter().enumerate() {
        next[at + 1] |= reached[at] && *c == '/';
    }
    next
}

fn is_in_set(set: &[char], c: char) -> bool {
    let (negated, set) = match set.split_first() {
        Some(('!', rest)) => (true, rest),
        _ => (false, set),
    };
    let mut found = false;
    let mut rest = set;
    while let Some((&first, tail)) = rest.split_first() {
        if let ['-', last, tail @ ..] = tail {
            found |= (first..=*last).contains(&c);
            rest = tail;
        } else {
            found |= first == c;
            rest = tail;
        }
    }
    found != negated && c != '/'
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(pattern: &str, yes: &[&str], no: &[&str]) {
        for text in yes {
            assert!(matches(pattern, text), "`{pattern}` should match `{text}`");
        }
        for text in no {
            assert!(!matches(pattern, text), "`{pattern}` should not match `{text}`");
        }
    }

    #[test]
    fn a_plain_name_matches_itself() {
        check("control", &["control"], &["controls", "contro", ""]);
    }

    #[test]
    fn a_star_stays_in_its_directory() {
        check("crates/*", &["crates/a"], &["crates/a/b", "crates", "other/a"]);
        check("robot-*-hal", &["robot-arm-hal"], &["robot-arm"]);
    }

    #[test]
    fn two_stars_cross_directories() {
        check("vendor/**", &["vendor/a", "vendor/a/b.rs"], &["vendor", "src/vendor/a"]);
        check("**/gen.rs", &["gen.rs", "src/gen.rs", "a/b/gen.rs"], &["src/regen.rs"]);
        check("a/**/b", &["a/b", "a/x/b", "a/x/y/b"], &["ab", "a/xb"]);
    }

    #[test]
    fn a_set_is_one_character() {
        check("axis[0-2]", &["axis0", "axis2"], &["axis3", "axis"]);
        check("v[!0-9]", &["vx"], &["v1"]);
    }

    #[test]
    fn an_open_bracket_is_literal() {
        check("a[b", &["a[b"], &["ab"]);
        assert!(is_unclosed("a[b") && is_unclosed("[a]/[b/**"));
        assert!(!is_unclosed("a[b]") && !is_unclosed("a]b") && !is_unclosed("[[]a"));
    }

    #[test]
    fn a_pattern_made_to_be_slow_is_not() {
        check(&"*a".repeat(200), &[], &[&"a".repeat(199)]);
    }
}
