//! What the call of a law says of its types: `g.add::<f32>(0.1)`. What runs the law above the loop says the same.

use super::body::LoopBody;
use super::inputs::Input;
use super::mentions::Guarded;
use super::sites::Site;
use super::text::has_word;
use crate::index::{FunctionId, Ty};
use crate::syntax::tree::{ExprId, ExprKind, Generics, TypeRef};

/// The arguments behind the name of a law, `::<f32>`, as its call has them; nothing if it has none.
pub(super) fn turbofish<'a>(of: &LoopBody<'a>, call: ExprId) -> &'a str {
    match of.kind(call) {
        ExprKind::MethodCall { method_span, .. } => {
            let rest = of.text.get(method_span.end as usize..of.span(call).end as usize).unwrap_or_default();
            arguments(rest.trim_start())
        }
        ExprKind::Call { callee, .. } => behind_the_name(of.written(*callee)),
        _ => "",
    }
}

/// Those at the end of a path.
pub(super) fn behind_the_name(path: &str) -> &str {
    let mut starts = path.match_indices("::<").map(|(at, _)| &path[at..]);
    starts.find(|rest| arguments(rest).len() == rest.len()).unwrap_or_default()
}

/// What a text begins with from `::<` to the bracket that closes it.
fn arguments(text: &str) -> &str {
    let opens = text.strip_prefix("::").is_some_and(|rest| rest.trim_start().starts_with('<'));
    let mut depth = 0_u32;
    let mut before = ' ';
    for (at, sign) in text.char_indices().take_while(|_| opens) {
        match sign {
            '<' => depth += 1,
            // An arrow closes nothing.
            '>' if before != '-' => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    return &text[..=at];
                }
            }
            _ => {}
        }
        before = sign;
    }
    ""
}

/// Whether a call says all of the types that its law leaves to it.
pub(super) fn says_types(of: &LoopBody<'_>, call: ExprId) -> bool {
    let said = turbofish(of, call);
    !said.is_empty() && !has_word(said, "_")
}

/// What the call of a law says that a parameter of its own stands for.
pub(super) fn said_of(of: &LoopBody<'_>, call: ExprId, own: &Generics, name: &str) -> Option<Ty> {
    let ExprKind::MethodCall { turbofish, .. } = of.kind(call) else { return None };
    let at = own.params.iter().position(|param| param.name == name && !param.is_const)?;
    let said = turbofish.get(at).filter(|_| turbofish.len() == own.params.len())?;
    let index = of.program.index;
    Some(index.lower(said, &index.scope_of(of.function))).filter(|ty| !matches!(ty, Ty::Unknown | Ty::Var(_)))
}

/// Whether the call of a law says the types of all that it is given, and none of them is a function's own.
pub(super) fn says_inputs(of: &LoopBody<'_>, site: &Site) -> bool {
    let has_own = |law: FunctionId| {
        let params = &of.program.index.function(law).function.params;
        params.iter().any(|param| matches!(param, TypeRef::FnPointer(..) | TypeRef::ImplTrait(_)))
    };
    says_types(of, site.call) && site.law.is_some_and(|law| !has_own(law))
}

/// Why what the calls of a half say of its types cannot be said once, where their inputs are fed.
pub(super) fn unsayable(of: &LoopBody<'_>, own: &Guarded, half: &Site, inputs: &[Vec<Input>]) -> Option<String> {
    let said = turbofish(of, half.call);
    let same = || own.sites.iter().zip(inputs).filter(|(site, _)| site.half == half.half);
    let (method, spelled) = (&half.method, &own.spelled);
    if same().any(|(site, _)| turbofish(of, site.call) != said) {
        return Some(format!(
            "the calls of `{method}` on `{spelled}` say several types for it, and a guard runs a law with one: let all of them say \
             the same"
        ));
    }
    // A reference to a copy may have to become another one, which nothing tells the compiler above the loop.
    let may_be_another = said.contains('&') || has_word(said, "str") || has_word(said, "dyn");
    if may_be_another && same().any(|(_, inputs)| inputs.iter().any(Input::is_lent)) {
        return Some(format!(
            "`{said}` says that `{method}` of `{spelled}` takes what is borrowed in the iteration, and a guard runs it at the end of the \
             cycle: let it take a value"
        ));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_end_with_their_bracket() {
        for (text, expected) in [
            ("::<f32>(0.1)", "::<f32>"),
            ("::<Vec<fn(u8) -> u8>, 4>()", "::<Vec<fn(u8) -> u8>, 4>"),
            (":: <f32>(a > b)", ":: <f32>"),
            ("(a < b, c > d)", ""),
        ] {
            assert_eq!(arguments(text), expected);
        }
    }

    #[test]
    fn arguments_of_a_type_are_none_of_its_law() {
        for (path, expected) in [
            ("Gauge::<f32>::add", ""),
            ("Gauge::<f32>::add::<u8>", "::<u8>"),
            ("<Gauge as Law<f32>>::add", ""),
            ("Gauge::add::<Vec<u8>>", "::<Vec<u8>>"),
        ] {
            assert_eq!(behind_the_name(path), expected);
        }
    }
}
