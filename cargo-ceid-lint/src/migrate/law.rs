//! The `impl` by which a guard runs a law that is there already.

use super::core_items::CoreItems;
use super::loops::Loops;
use super::text::{Style, begins_line, conditions_above, has_word, indentation, with_attributes};
use crate::flow::Program;
use crate::index::{FunctionId, Index, Owner, TraitName, Ty};
use crate::source::Span;
use crate::syntax::tree::{Receiver, TypeRef};
use crate::types::Callee;

/// The names that the parameter for the rate may get.
const RATES: [&str; 3] = ["R", "TickRate", "CycleRate"];

/// An `impl` to write, where it stands, and the package whose file that is.
#[derive(Clone, Debug)]
pub(super) struct NewImpl {
    pub(super) span: Span,
    pub(super) text: String,
}

/// What has to be written so that `filter` is a `SampledFilter` of ceid-core whose law is the function `law`; nothing if it is one.
///
/// # Errors
/// Why that cannot be written.
pub(super) fn delegation(loops: &Loops<'_>, filter: &Ty, law: FunctionId) -> Result<Option<NewImpl>, String> {
    let program = loops.program;
    let index = program.index;
    let type_name = index.type_name(filter);
    let def = index.function(law);
    if existing_law(index, filter) == Some(law) {
        return Err(format!(
            "guards run `{}` of `{type_name}` already: make its guard at the head of the loop; `cargo ceid-lint fix` moves one \
             there from above the loop",
            def.name
        ));
    }
    if let Some(existing) = existing_law(index, filter) {
        return if runs(program, existing, law) {
            Ok(None)
        } else {
            Err(format!(
                "`{type_name}` is a `SampledFilter` of ceid-core already, with another law than `{}`",
                def.name
            ))
        };
    }
    if !def.function.params.is_empty() {
        return Err(format!("`{}` of `{type_name}` takes inputs, and nothing in the loop gives them", def.name));
    }
    if def.function.is_async || !matches!(def.function.receiver, Some(Receiver::Exclusive)) {
        return Err(format!("`{}` of `{type_name}` does not take `&mut self`", def.name));
    }
    if !def.function.generics.params.is_empty() {
        return Err(format!(
            "each call of `{}` of `{type_name}` chooses what its parameters stand for, and a guard chooses nothing: let the type have them",
            def.name
        ));
    }
    let Owner::Impl(impl_id) = def.owner else {
        return Err(format!("`{}` is written in its trait, and not for `{type_name}`", def.name));
    };
    if !matches!(index.impl_def(impl_id).self_ty, Ty::Adt(..)) {
        return Err(format!("`{}` is written for more than `{type_name}`", def.name));
    }
    let keyword = def.function.keyword;
    let text = &program.sources.file(keyword.file).text;
    let outline = loops.outline(keyword.file);
    let around: Vec<_> = outline.around(keyword.start as usize).collect();
    let enclosing = around.first().filter(|_| !around.iter().any(|enclosure| enclosure.is_macro));
    let Some(block) = enclosing.filter(|_| text[keyword.start as usize..].starts_with("fn")) else {
        return Err(format!("`{}` of `{type_name}` is written by a macro", def.name));
    };
    let Some(head) = Head::of(&text[block.head.clone()]) else {
        return Err(format!("the `impl` around `{}` of `{type_name}` is not understood", def.name));
    };
    let core = CoreItems::of(program, law);
    let written = &text[block.head.clone()];
    let Some(rate) = RATES.into_iter().find(|name| !has_word(written, name)) else {
        return Err(format!("every name for a rate means something else in the `impl` of `{type_name}`"));
    };
    let style = loops.style(keyword.file).inside(text, block.head.start..block.brackets.end);
    let Style { end, step, .. } = style;
    let indent = indentation(text, block.head.start);
    let own = head.generics.trim().trim_end_matches(',');
    let separator = if own.is_empty() { "" } else { ", " };
    let call = match head.of_trait {
        None => format!("Self::{}(self)", def.name),
        Some(of_trait) if of_trait.contains('<') || !head.generics.is_empty() => {
            format!("<Self as {of_trait}>::{}(self)", def.name)
        }
        Some(of_trait) => format!("{of_trait}::{}(self)", def.name),
    };
    let begin = def.function.body.as_ref().map_or(0, |body| body.expr(body.root).span.start as usize);
    let brace = match begins_line(text, begin) {
        true => format!("{end}{indent}{step}{{"),
        false => " {".to_owned(),
    };
    let discarded = if def.function.output == TypeRef::unit() { "" } else { "let _ = " };
    let qualified =
        text[..keyword.start as usize].trim_end_matches(|sign: char| !matches!(sign, ';' | '{' | '}' | ']'));
    let conditions = [conditions_above(text, block.head.start), conditions_above(text, qualified.len())].concat();
    let conditions: String = conditions.iter().map(|condition| format!("{indent}{condition}{end}")).collect();
    let attributes = &text[with_attributes(text, qualified.len())..qualified.len()];
    let inline = ["#[inline]", "#[inline(always)]"].into_iter().find(|own| attributes.contains(own));
    let inline = inline.map(|own| format!("{indent}{step}{own}{end}")).unwrap_or_default();
    let lines = [
        String::new(),
        format!(
            "{end}{conditions}{}",
            header(
                &format!("{indent}impl<{own}{separator}{rate}: {}>", core.name("Rate")),
                &format!("{}<{rate}>", core.name("SampledFilter")),
                head.of_type,
                (indent, style),
            )
        ),
        format!("{inline}{indent}{step}fn update(&mut self, _: {}<'_, {rate}>){brace}", core.name("Tick")),
        format!("{indent}{step}{step}{discarded}{call};"),
        format!("{indent}{step}}}"),
        format!("{indent}}}"),
    ];
    let at = u32::try_from(block.brackets.end).unwrap_or(u32::MAX);
    Ok(Some(NewImpl { span: Span::new(keyword.file, at, at), text: lines.join(end) }))
}

/// The head of the new `impl` to its brace, in the lines that rustfmt makes of it.
fn header(generics: &str, of_trait: &str, of_type: &str, (indent, style): (&str, Style)) -> String {
    let Style { end, step, width: most } = style;
    let (own, bounds) = of_type.split_at(super::text::words(of_type, "where").next().unwrap_or(of_type.len()));
    let own = own.trim_end();
    let brace = if bounds.is_empty() { " {" } else { "" };
    let width = |line: &str| line.chars().map(|sign| if sign == '\t' { 4 } else { 1 }).sum::<usize>();
    let head = format!("{generics} {of_trait}");
    if width(&format!("{head} for {own}{brace}")) <= most || own.contains('\n') {
        return format!("{head} for {of_type}{{");
    }
    let bounds = if bounds.is_empty() { indent } else { bounds };
    if width(&head) > most {
        return format!("{generics}{end}{indent}{step}{of_trait} for {own}{end}{bounds}{{");
    }
    format!("{head}{end}{indent}{step}for {own}{end}{bounds}{{")
}

/// The head of an `impl`, in parts.
struct Head<'t> {
    /// What stands between its angle brackets.
    generics: &'t str,
    of_trait: Option<&'t str>,
    /// The type with all that follows it, to the brace.
    of_type: &'t str,
}

impl<'t> Head<'t> {
    fn of(text: &'t str) -> Option<Self> {
        let rest = text.strip_prefix("impl")?;
        let (generics, rest) = match rest.trim_start().strip_prefix('<') {
            Some(inner) => {
                let end = closing(inner)?;
                (&inner[..end], &inner[end + 1..])
            }
            None => ("", rest),
        };
        if rest.contains(['{', '!']) || text.contains("//") || text.contains("/*") {
            return None;
        }
        let where_at = super::text::words(rest, "where").next().unwrap_or(rest.len());
        let for_at =
            super::text::words(&rest[..where_at], "for").find(|at| !rest[at + 3..].trim_start().starts_with('<'));
        Some(match for_at {
            Some(at) => Self { generics, of_trait: Some(rest[..at].trim()), of_type: rest[at + 3..].trim_start() },
            None => Self { generics, of_trait: None, of_type: rest.trim_start() },
        })
    }
}

/// Where the angle bracket that is open at the beginning of the text is closed.
fn closing(text: &str) -> Option<usize> {
    let mut depth = 1;
    let mut before = ' ';
    for (at, sign) in text.char_indices() {
        match sign {
            '<' => depth += 1,
            '>' if before != '-' && before != '=' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return Some(at);
        }
        before = sign;
    }
    None
}

/// The law by which a type is a filter of ceid-core.
fn existing_law(index: &Index, filter: &Ty) -> Option<FunctionId> {
    let of_core = |name: &TraitName| index.is_of_core(name);
    index.impls_of(filter).into_iter().find_map(|id| {
        let def = index.impl_def(id);
        (def.self_ty.may_be(filter) && def.implements.as_ref().is_some_and(of_core))
            .then(|| def.methods.get("update").copied())
            .flatten()
    })
}

/// Whether a function calls another one, and no other.
fn runs(program: &Program<'_>, caller: FunctionId, callee: FunctionId) -> bool {
    let calls = |found: &Callee| matches!(found, Callee::Resolved(resolved) if resolved.targets == [callee]);
    program.typed(caller).is_some_and(|typed| typed.callees.len() == 1 && typed.callees.values().all(calls))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, generics: &str, of_trait: Option<&str>, of_type: &str) {
        let head = Head::of(text).expect("it is the head of an impl");
        assert_eq!((head.generics, head.of_trait, head.of_type), (generics, of_trait, of_type));
    }

    #[test]
    fn long_heads_are_broken() {
        let (generics, of_trait) = ("impl<const N: usize, R: ceid_core::Rate>", "ceid_core::SampledFilter<R>");
        let head = |of_type: &str| header(generics, of_trait, of_type, ("", Style::of("")));
        assert_eq!(head("Short<N> "), format!("{generics} {of_trait} for Short<N> {{"));
        let long = "crate::estimation::ExtendedFilter<N> ";
        let broken = format!("{generics} {of_trait}\n    for {}\n", long.trim_end());
        assert_eq!(head(long), format!("{broken}{{"));
        let bounds = "where\n    Self: Copy,\n";
        assert_eq!(head(&format!("{long}{bounds}")), format!("{broken}{bounds}{{"));
        let generics = format!("impl<const N: usize, {}: Copy, R: ceid_core::Rate>", "T".repeat(30));
        let head = header(&generics, of_trait, "Filter<N> ", ("", Style::of("")));
        assert_eq!(head, format!("{generics}\n    {of_trait} for Filter<N>\n{{"));
    }

    #[test]
    fn heads_come_apart() {
        check("impl Pid ", "", None, "Pid ");
        check("impl crate::Step for Pid ", "", Some("crate::Step"), "Pid ");
        check(
            "impl<T: Fn(u8) -> u8, const N: usize> Step<T> for Pid<T, N>\nwhere\n    T: Copy,\n",
            "T: Fn(u8) -> u8, const N: usize",
            Some("Step<T>"),
            "Pid<T, N>\nwhere\n    T: Copy,\n",
        );
        check("impl<F> Step for F where F: for<'a> Fn(&'a u8) ", "F", Some("Step"), "F where F: for<'a> Fn(&'a u8) ");
        assert!(Head::of("unsafe impl A for B ").is_none());
        assert!(Head::of("impl !A for B ").is_none());
    }
}
