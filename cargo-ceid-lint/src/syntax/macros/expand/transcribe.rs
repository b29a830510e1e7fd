//! Writes down what a rule stands for. Never gives a token a place outside the call: the tokens of its arguments keep
//! theirs, and all others get that of the call.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{Delimiter, Group, Ident, Punct, Spacing, Span, TokenStream, TokenTree};

use super::hygiene::{marked, own_variables};
use super::matcher::{Binding, Bindings};
use super::rules::{Fragment, Node, Repeat, is_punct};

/// What the variables stand for in the round that is written.
type Scope<'b> = BTreeMap<&'b str, &'b Binding>;

/// The tokens of the transcriber, of a macro of the crate `home` if that is another one; `None` if it is wrong or gives more than
/// `limit`.
pub(super) fn transcribe(
    nodes: &[Node],
    bindings: &Bindings,
    home: Option<&str>,
    call: Span,
    limit: usize,
) -> Option<TokenStream> {
    let mut writer = Writer { call, home, left: limit, number: limit, own: own_variables(nodes) };
    let scope = bindings.iter().map(|(name, binding)| (name.as_str(), binding)).collect();
    let tokens = writer.nodes(nodes, &scope)?;
    Some(tokens.into_iter().collect())
}

struct Writer<'h> {
    call: Span,
    /// What `$crate` is.
    home: Option<&'h str>,
    left: usize,
    /// Tells this call from those in the same code: each has fewer tokens left than the one before.
    number: usize,
    /// The variables that the rule declares for itself.
    own: BTreeSet<String>,
}

impl Writer<'_> {
    fn nodes(&mut self, nodes: &[Node], scope: &Scope<'_>) -> Option<Vec<TokenTree>> {
        let mut out = Vec::new();
        for (index, node) in nodes.iter().enumerate() {
            let before = out.len();
            match node {
                Node::Token(tokens) => {
                    let is_member = matches!(index.checked_sub(1).map(|before| &nodes[before]),
                        Some(Node::Token(before)) if matches!(before.as_slice(), [dot] if is_punct(dot, '.')));
                    out.extend(tokens.iter().map(|token| self.written(token, is_member)));
                }
                Node::Crate => {
                    if self.home.is_some() {
                        out.push(TokenTree::Punct(Punct::new(':', Spacing::Joint)));
                        out.push(TokenTree::Punct(Punct::new(':', Spacing::Alone)));
                    }
                    out.push(TokenTree::Ident(Ident::new(self.home.unwrap_or("crate"), Span::call_site())));
                    out[before..].iter_mut().for_each(|token| token.set_span(self.call));
                }
                Node::Group(delimiter, inner) => {
                    let inner = self.nodes(inner, scope)?;
                    out.push(TokenTree::Group(group(*delimiter, inner, self.call)));
                }
                Node::Variable(name) => {
                    let Binding::One(fragment, tokens) = scope.get(name.as_str())? else { return None };
                    self.fragment(*fragment, tokens, nodes.get(index + 1), &mut out)?;
                }
                Node::Repeat(repeat) => self.repeat(repeat, scope, &mut out)?,
                Node::Fragment(..) => return None,
            }
            if !matches!(node, Node::Variable(_) | Node::Repeat(_)) {
                self.charge(out.len() - before)?;
            }
        }
        Some(out)
    }

    /// What a variable took. An expression stays one whatever stands around it, and so does a type before `::`.
    fn fragment(
        &mut self,
        fragment: Fragment,
        tokens: &[TokenTree],
        next: Option<&Node>,
        out: &mut Vec<TokenTree>,
    ) -> Option<()> {
        self.charge(count(tokens))?;
        let before_path =
            matches!(next, Some(Node::Token(next)) if matches!(next.as_slice(), [colon, _] if is_punct(colon, ':')));
        match (fragment, tokens) {
            (Fragment::Expr, [first, .., last]) => {
                let place = first.span().join(last.span()).unwrap_or(first.span());
                out.push(TokenTree::Group(group(Delimiter::None, tokens.to_vec(), place)));
            }
            (Fragment::Ty, [_, _, ..]) if before_path => {
                out.push(self.punct('<'));
                out.extend_from_slice(tokens);
                out.push(self.punct('>'));
            }
            _ => out.extend_from_slice(tokens),
        }
        Some(())
    }

    fn repeat(&mut self, repeat: &Repeat, scope: &Scope<'_>, out: &mut Vec<TokenTree>) -> Option<()> {
        let mut names = Vec::new();
        variables(&repeat.body, &mut names);
        let mut rounds = None;
        for name in &names {
            if let Some(Binding::Many(all)) = scope.get(name) {
                // Variables of different lengths cannot go together.
                if rounds.is_some_and(|rounds| rounds != all.len()) {
                    return None;
                }
                rounds = Some(all.len());
            }
        }
        for round in 0..rounds? {
            if round > 0 {
                let separator = repeat.separator.iter().map(|token| self.moved(token.clone()));
                out.extend(separator.collect::<Vec<_>>());
                self.charge(repeat.separator.len())?;
            }
            let mut inner = scope.clone();
            for name in &names {
                if let Some(Binding::Many(all)) = scope.get(name) {
                    inner.insert(name, all.get(round)?);
                }
            }
            // A round may be empty, and still is one.
            self.charge(1)?;
            out.extend(self.nodes(&repeat.body, &inner)?);
        }
        Some(())
    }

    fn charge(&mut self, tokens: usize) -> Option<()> {
        self.left = self.left.checked_sub(tokens)?;
        Some(())
    }

    /// A token of the rule's own.
    fn written(&self, token: &TokenTree, is_member: bool) -> TokenTree {
        match token {
            TokenTree::Ident(ident) if !is_member && self.own.contains(&ident.to_string()) => {
                self.moved(TokenTree::Ident(marked(ident, self.number)))
            }
            _ => self.moved(token.clone()),
        }
    }

    fn moved(&self, mut token: TokenTree) -> TokenTree {
        token.set_span(self.call);
        token
    }

    fn punct(&self, char: char) -> TokenTree {
        self.moved(TokenTree::Punct(Punct::new(char, Spacing::Alone)))
    }
}

fn group(delimiter: Delimiter, tokens: Vec<TokenTree>, place: Span) -> Group {
    let mut group = Group::new(delimiter, tokens.into_iter().collect());
    group.set_span(place);
    group
}

fn variables<'n>(nodes: &'n [Node], names: &mut Vec<&'n str>) {
    for node in nodes {
        match node {
            Node::Variable(name) => names.push(name),
            Node::Group(_, inner) => variables(inner, names),
            Node::Repeat(repeat) => variables(&repeat.body, names),
            Node::Token(_) | Node::Fragment(..) | Node::Crate => {}
        }
    }
}

/// How many tokens there are, those in brackets included.
fn count(tokens: &[TokenTree]) -> usize {
    let inner = tokens.iter().map(|token| match token {
        TokenTree::Group(group) => count(&group.stream().into_iter().collect::<Vec<_>>()),
        _ => 0,
    });
    tokens.len() + inner.sum::<usize>()
}
