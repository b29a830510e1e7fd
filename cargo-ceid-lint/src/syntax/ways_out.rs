//! The ways out of the code around a macro that its tokens hold. What the macro makes of them is not known.

use proc_macro2::{Delimiter, TokenStream, TokenTree};

use super::tree::WayOut;

/// The ways out among the tokens, once each; those that leave only a loop or a future among the tokens are none.
pub(super) fn ways_out(tokens: &TokenStream) -> Vec<WayOut> {
    let mut found = Found::default();
    found.tokens(tokens, Around::default());
    found.ways
}

/// What of the tokens stands around a token.
#[derive(Clone, Copy, Default)]
struct Around {
    is_loop: bool,
    is_future: bool,
}

#[derive(Default)]
struct Found {
    ways: Vec<WayOut>,
}

impl Found {
    fn tokens(&mut self, tokens: &TokenStream, around: Around) {
        let tokens: Vec<TokenTree> = tokens.clone().into_iter().collect();
        let mut opens = around;
        for (at, token) in tokens.iter().enumerate() {
            let behind = &tokens[at + 1..];
            match token {
                TokenTree::Group(group) => {
                    let is_body = group.delimiter() == Delimiter::Brace;
                    self.tokens(&group.stream(), if is_body { opens } else { around });
                    if is_body {
                        opens = around;
                    }
                }
                TokenTree::Ident(word) => match word.to_string().as_str() {
                    "loop" | "while" | "for" => opens.is_loop = true,
                    "async" => opens.is_future = true,
                    "continue" => self.jump(label(behind), around, WayOut::Continue),
                    "break" => self.jump(label(behind), around, WayOut::Break),
                    "return" if !around.is_future => {
                        let fails =
                            matches!(behind, [TokenTree::Ident(value), ..] if value == "Err" || value == "None");
                        self.add(if fails { WayOut::Failure } else { WayOut::Return });
                    }
                    _ => {}
                },
                // `T: ?Sized` asks for nothing.
                TokenTree::Punct(mark) if mark.as_char() == '?' && !around.is_future => {
                    if !matches!(behind, [TokenTree::Ident(bound), ..] if bound == "Sized") {
                        self.add(WayOut::Failure);
                    }
                }
                TokenTree::Punct(mark) if mark.as_char() == ';' => opens = around,
                TokenTree::Punct(_) | TokenTree::Literal(_) => {}
            }
        }
    }

    fn jump(&mut self, label: Option<String>, around: Around, way: impl Fn(Option<String>) -> WayOut) {
        if label.is_some() || !around.is_loop {
            self.add(way(label));
        }
    }

    fn add(&mut self, way: WayOut) {
        if !self.ways.contains(&way) {
            self.ways.push(way);
        }
    }
}

/// The label at the beginning of tokens.
fn label(tokens: &[TokenTree]) -> Option<String> {
    match tokens {
        [TokenTree::Punct(quote), TokenTree::Ident(label), ..] if quote.as_char() == '\'' => Some(label.to_string()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(tokens: &str, expected: &[WayOut]) {
        assert_eq!(ways_out(&tokens.parse().unwrap()), expected);
    }

    #[test]
    fn each_way_is_found_once_at_any_depth() {
        check("x => { continue } else (continue), y?", &[WayOut::Continue(None), WayOut::Failure]);
    }

    #[test]
    fn labels_are_kept() {
        check("loop { break 'outer }", &[WayOut::Break(Some("outer".to_owned()))]);
    }

    #[test]
    fn what_leaves_a_loop_among_the_tokens_is_none() {
        check("loop { if x { break; } } T: ?Sized, async { y?; return }", &[]);
    }

    #[test]
    fn errors_are_returned_as_by_a_question() {
        check("return Err(x); return 3", &[WayOut::Failure, WayOut::Return]);
    }
}
