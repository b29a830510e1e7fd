//! Changes real code by its tokens, the same for a seed on every machine: most results still parse, or nearly so.

/// Words that change what code around them means.
const WORDS: &[&str] = &[
    "loop",
    "while",
    "for",
    "if",
    "else",
    "match",
    "return",
    "break",
    "continue",
    "async",
    "await",
    "unsafe",
    "move",
    "mut",
    "ref",
    "self",
    "Self",
    "impl",
    "dyn",
    "where",
    "const",
    "static",
    "let",
    "=>",
    "->",
    "..",
    "..=",
    "::",
    "?",
    "&",
    "*",
    "!",
    "|",
    "'a",
    "_",
    "0",
    "\"\"",
    "#",
    "macro_rules!",
    "vec!",
    "select!",
    "update",
    "Some",
    "None",
    "Ok",
    "Err",
    ".iter_mut()",
    ".zip(",
    ".await",
    "{",
    "}",
    "(",
    ")",
    "[",
    "]",
    ";",
    ",",
    "// ceid: allow(skipped_update)\n",
    "// ceid: cycle\n",
];

/// What a piece of code is wrapped in to nest it deeper.
const SHELLS: &[(&str, &str)] = &[
    ("{", "}"),
    ("(", ")"),
    ("loop {", "}"),
    ("if c {", "}"),
    ("while c {", "}"),
    ("for x in y {", "}"),
    ("match c { _ => {", "} }"),
    ("(|| {", "})()"),
    ("async {", "}.await"),
    ("unsafe {", "}"),
    ("[", "]"),
    ("vec![", "]"),
    ("Some(", ")"),
];

/// `text` with one to eight changes, some of which take pieces from `other`.
pub(crate) fn mutated(text: &str, other: &str, seed: u64) -> String {
    let mut random = Random(seed);
    let mut tokens = tokens(text);
    let others = self::tokens(other);
    for _ in 0..=random.below(8) {
        if !tokens.is_empty() {
            change(&mut tokens, &others, &mut random);
        }
    }
    tokens.concat()
}

fn change<'a>(tokens: &mut Vec<&'a str>, others: &[&'a str], random: &mut Random) {
    let at = random.below(tokens.len());
    match random.below(9) {
        0 => {
            let end = (at + 1 + random.below(4)).min(tokens.len());
            tokens.drain(at..end);
        }
        1 => {
            let end = (at + 1 + random.below(12)).min(tokens.len());
            let copy = tokens[at..end].to_vec();
            tokens.splice(at..at, copy);
        }
        2 => {
            let with = random.below(tokens.len());
            tokens.swap(at, with);
        }
        3 => tokens.insert(at, WORDS[random.below(WORDS.len())]),
        4 => tokens[at] = WORDS[random.below(WORDS.len())],
        5 => tokens[at] = tokens[random.below(tokens.len())],
        6 => {
            // A body of the other text takes the place of one of this.
            let (own, theirs) = (group(tokens, at), group(others, random.below(others.len().max(1))));
            if let (Some(own), Some(theirs)) = (own, theirs) {
                let body = others[theirs].to_vec();
                tokens.splice(own, body);
            }
        }
        7 => {
            if let Some(own) = group(tokens, at) {
                let (open, close) = SHELLS[random.below(SHELLS.len())];
                let depth = 1 << random.below(8);
                tokens.splice(own.end..own.end, std::iter::repeat_n(close, depth));
                tokens.splice(own.start..own.start, std::iter::repeat_n(open, depth));
            }
        }
        _ => {
            if let Some(own) = group(tokens, at) {
                tokens.drain(own);
            }
        }
    }
}

/// The first bracketed piece that begins at or behind a token.
fn group(tokens: &[&str], from: usize) -> Option<std::ops::Range<usize>> {
    let start = from + tokens.get(from..)?.iter().position(|token| matches!(*token, "{" | "(" | "["))?;
    let mut depth = 0_usize;
    for (at, token) in tokens.iter().enumerate().skip(start) {
        match *token {
            "{" | "(" | "[" => depth += 1,
            "}" | ")" | "]" => {
                depth -= 1;
                if depth == 0 {
                    return Some(start..at + 1);
                }
            }
            _ => {}
        }
    }
    None
}

/// Words, runs of white space, and single signs: together the text.
fn tokens(text: &str) -> Vec<&str> {
    let kind = |letter: char| match letter {
        _ if letter.is_alphanumeric() || letter == '_' => 1,
        _ if letter.is_whitespace() => 2,
        _ => 0,
    };
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let same = |letter: char| kind(first) != 0 && kind(letter) == kind(first);
        let end = rest.find(|letter| !same(letter)).unwrap_or(rest.len()).max(first.len_utf8());
        let (token, behind) = rest.split_at(end);
        tokens.push(token);
        rest = behind;
    }
    tokens
}

/// Numbers of the splitmix64 family.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % end as u64) as usize
    }
}
