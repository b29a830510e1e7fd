//! Operands of format strings: `{lp:?}`, `{:08x}`. What lends a filter passes on how that is displayed and debugged, and no more.

use super::body::LoopBody;
use crate::syntax::tree::{ExprId, ExprKind, Literal};

/// Whether an operand of a format string may be shown in another way than by `Display` or `Debug`.
pub(super) fn is_shown_otherwise(of: &LoopBody<'_>, at: ExprId) -> bool {
    let beside = of.parent(at).map(|parent| of.body.children(parent)).unwrap_or_default();
    let mut texts = beside.iter().filter(|id| matches!(of.kind(**id), ExprKind::Literal(Literal::Str(_))));
    let span = of.span(at);
    // A name in the string is shown as is said behind it.
    if let Some(text) = beside.iter().find(|id| of.span(**id).contains(span) && **id != at) {
        let rest = of.text.get(span.end as usize..of.span(*text).end as usize).unwrap_or_default();
        return rest.split('}').next().is_some_and(is_other);
    }
    texts.any(|text| of.written(*text).split('{').skip(1).any(|rest| rest.split('}').next().is_some_and(is_other)))
}

/// Whether what stands in braces, or the rest of it, names another trait: `:08x`.
fn is_other(braces: &str) -> bool {
    let Some((_, spec)) = braces.split_once(':') else { return false };
    spec.trim_end().ends_with(['x', 'X', 'o', 'b', 'e', 'E', 'p'])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_sign_names_the_trait() {
        for (braces, expected) in [
            ("", false),
            ("lp", false),
            ("hex", false),
            (":?", false),
            (":#x?", false),
            (":>8", false),
            (":x", true),
            ("0:#010b", true),
            (":.3e", true),
        ] {
            assert_eq!(is_other(braces), expected, "{braces}");
        }
    }
}
