//! One `use` that names a trait or type, as it is written.

use std::ops::Range;

use super::text::{
    Style, begins_line, conditions_above, indentation, line_stop, removal, with_attributes, without_comments, words,
};

/// A text, and what is code of it: a comment or a string may have any word, and the signs of code.
#[derive(Clone, Copy)]
pub(super) struct Text<'t> {
    pub(super) text: &'t str,
    pub(super) code: &'t str,
}

/// A `use` that names a trait.
pub(super) struct Import<'t> {
    pub(super) stmt: Range<usize>,
    /// The `pub` or `pub(…)` that it begins with, or nothing.
    pub(super) visibility: &'t str,
    /// What it is called, and how it is written in the innermost list: `filter::Step as Other`.
    pub(super) alias: Option<&'t str>,
    pub(super) entry: Range<usize>,
    /// The innermost list around it, with its braces.
    pub(super) list: Option<Range<usize>>,
}

impl<'t> Import<'t> {
    /// The import whose name stands at a byte, under no condition.
    pub(super) fn at(text: Text<'t>, at: usize, name: &str) -> Option<Self> {
        Self::read(text, at, name, false)
    }

    /// The import whose name stands at a byte, with the conditions `#[cfg(…)]` that its statement begins with.
    pub(super) fn conditional(text: Text<'t>, at: usize, name: &str) -> Option<Self> {
        Self::read(text, at, name, true).filter(|import| import.visibility.is_empty())
    }

    fn read(Text { text, code }: Text<'t>, at: usize, name: &str, is_conditional: bool) -> Option<Self> {
        if name == "_" || !code[at..].starts_with(name) || code[..at].trim_end().ends_with(" as") {
            return None;
        }
        let before = code[..at].rfind(';').map_or(0, |end| end + 1);
        let own = before + words(&code[before..at], "use").last()?;
        let start = code[..own].rfind([';', '}']).map_or(0, |end| end + 1);
        let (head, word) = (&code[start..at], own - start);
        let visibility = visibility_before(&head[..word]);
        let shown = if visibility.is_empty() { word } else { head[..word].trim_end().len() - visibility.len() };
        let visibility = &text[start + shown..start + shown + visibility.len()];
        let begin = if is_conditional { with_attributes(code, start + shown) - start } else { shown };
        if is_conditional {
            let attributes = head[begin..shown].matches("#[").count();
            // How it is written down says nothing of when it is there.
            let of_form = head[begin..shown].matches("#[rustfmt::skip]").count();
            if attributes == 0 || conditions_above(text, start + shown).len() + of_form != attributes {
                return None;
            }
        }
        let mut before = head[..begin].trim_start_matches('\u{feff}').lines().map(str::trim);
        // Attributes belong to it; a block begins with a brace.
        let before = before.rfind(|line| !line.starts_with("#![") && !line.is_empty());
        if before.is_some_and(|line| !line.ends_with('{')) {
            return None;
        }
        let is_path = |c: char| c.is_alphanumeric() || "_:".contains(c);
        let stop = at + code[at..].find(';')? + 1;
        if !code[own..stop].chars().all(|c| is_path(c) || " {},;\n\r\t".contains(c)) {
            return None;
        }
        let end = at + name.len();
        let rest = code[end..stop].trim_start();
        if rest.starts_with("::") {
            return None;
        }
        let alias = rest.strip_prefix("as ").map(str::trim_start);
        let alias = alias.map(|alias| &alias[..alias.find(|c| !is_path(c)).unwrap_or(alias.len())]);
        let entry_end = end + code[end..stop].find([',', '}', ';'])?;
        let first = code[..at].rfind(|c| !is_path(c)).map_or(0, |before| before + 1);
        let mut depth = 0;
        let open = code[own..at].rfind(|sign| {
            depth += match sign {
                '}' => 1,
                '{' => -1,
                _ => 0,
            };
            depth < 0
        });
        let list = match open {
            Some(open) => Some(own + open..end + closing(&code[end..stop])? + 1),
            None => None,
        };
        let alias = alias.and_then(|alias| {
            let at = end + code[end..entry_end].rfind(alias)?;
            Some(&text[at..at + alias.len()])
        });
        Some(Self { stmt: start + begin..stop, visibility, alias, entry: first..entry_end, list })
    }

    /// The `self` by which a list imports the module whose name stands at a byte: `use crate::b::{self, Step};`.
    pub(super) fn of_itself(text: Text<'t>, at: usize, name: &str) -> Option<Self> {
        let code = text.code;
        let open = code[at + name.len()..].strip_prefix("::{").map(|list| code.len() - list.len())?;
        let list = &code[open..open + code[open..].find(['}', ';'])?];
        let own = words(list, "self").find(|own| !list[..*own].contains('{') && !list[..*own].ends_with("::"))?;
        Self::at(text, open + own, "self")
    }

    /// The path of what it imports, as far as that is written in at most one list.
    pub(super) fn path(&self, text: &str) -> Option<Vec<String>> {
        let before = self.list.as_ref().map_or(self.entry.start, |list| list.start);
        let head = &without_comments(&text[self.stmt.start..before]);
        let before = words(head, "use").last().map(|at| head[at + "use".len()..].trim())?;
        let path = format!("{before}{}", text[self.entry.clone()].trim());
        let path = path.split(" as ").next().filter(|path| !path.contains('{'))?;
        Some(path.split("::").map(|segment| segment.trim().to_owned()).collect())
    }

    /// What to replace, and by what, so that only code under a condition has the name.
    pub(super) fn under(&self, text: &str, condition: &str) -> Option<Vec<(Range<usize>, String)>> {
        let Style { end, .. } = Style::of(text);
        let start = self.stmt.start;
        if text[start..].starts_with('#') {
            return None;
        }
        let line = format!("{condition}{end}{}", indentation(text, start));
        let Some(list) = &self.list else { return Some(vec![(start..start, line)]) };
        let (range, new) = self.without(text)?;
        if range.contains(&start) {
            return Some(vec![(start..start, line)]);
        }
        let path = text[start..list.start].trim_end();
        if path.contains('{') {
            return None;
        }
        let own = format!("{end}{}{line}{path}{};", indentation(text, start), text[self.entry.clone()].trim());
        Some(vec![(range, new), (self.stmt.end..self.stmt.end, own)])
    }

    /// What to replace, and by what, so that the `use` is without the name.
    pub(super) fn without(&self, text: &str) -> Option<(Range<usize>, String)> {
        // What is said of it goes with it.
        let with_comment = |end: usize| {
            let rest = &text[end..line_stop(text, end)];
            if rest.trim_start().starts_with("//") { end + rest.trim_end().len() } else { end }
        };
        let whole = || (removal(text, self.stmt.start..with_comment(self.stmt.end)), String::new());
        let Some(list) = self.list.clone() else { return Some(whole()) };
        let inner = &text[list.start + 1..list.end - 1];
        let is_nested = text[self.stmt.start..list.start].contains('{');
        let code = without_comments(inner);
        let entries = entries(&code).into_iter().map(str::trim).filter(|entry| !entry.is_empty());
        let own = text[self.entry.clone()].trim();
        let left: Vec<&str> = entries.filter(|entry| *entry != own).collect();
        let has_comments = code != inner;
        match left.as_slice() {
            [] if is_nested || has_comments => None,
            [] => Some(whole()),
            [one] if *one != "self" && !has_comments => {
                let path = text[..list.start].trim_end();
                let start = if path.ends_with("::") { path.len() } else { list.start };
                Some((start..list.end, (*one).to_owned()))
            }
            ["self"] if !has_comments && text[..list.start].ends_with("::") => {
                Some((list.start - "::".len()..list.end, String::new()))
            }
            _ if !inner.contains('\n') && !has_comments => {
                let gap = |is_there| if is_there { " " } else { "" };
                let (open, close) = (gap(inner.starts_with(' ')), gap(inner.ends_with(' ')));
                Some((list.start + 1..list.end - 1, format!("{open}{}{close}", left.join(", "))))
            }
            _ => {
                let has_comma = text[self.entry.end..].starts_with(',');
                let named = without_comments(&text[self.entry.clone()]).trim_end().len();
                let end = if has_comma { self.entry.end + 1 } else { self.entry.start + named };
                let stop = line_stop(text, end);
                let rest = text[end..stop].trim();
                let own = self.entry.start..self.entry.start + named;
                let before = code[..own.start - list.start - 1].rfind(',').map(|before| list.start + 1 + before);
                // What stands behind the entry before it is said of that.
                let is_said = before.is_some_and(|before| text[before..own.start].contains("//"));
                let is_alone = begins_line(text, self.entry.start) && (rest.is_empty() || rest.starts_with("//"));
                // The last entry may be the only one without a comma.
                if is_alone && (has_comma || is_said || before.is_none()) {
                    return Some((removal(text, self.entry.start..with_comment(end)), String::new()));
                }
                let range = match before {
                    Some(before) => before..own.end,
                    None => own.start..own.end + text[own.end..].find(|sign| !" ,".contains(sign))?,
                };
                (!is_said && !text[range.start..own.start].contains("//")).then_some((range, String::new()))
            }
        }
    }
}

/// Where the list ends that is open at the beginning of the text.
fn closing(text: &str) -> Option<usize> {
    let mut depth = 0;
    text.find(|sign| {
        depth += match sign {
            '{' => 1,
            '}' => -1,
            _ => 0,
        };
        depth < 0
    })
}

/// The entries of a list, those with lists of their own in full.
fn entries(list: &str) -> Vec<&str> {
    let mut depth = 0;
    let is_end = |sign| {
        depth += match sign {
            '{' => 1,
            '}' => -1,
            _ => 0,
        };
        sign == ',' && depth == 0
    };
    list.split(is_end).collect()
}

/// The `pub` or `pub(…)` that a text ends with, or nothing.
fn visibility_before(text: &str) -> &str {
    let text = text.trim_end();
    let found = words(text, "pub").last().map(|at| &text[at..]).unwrap_or_default();
    let is_whole = found == "pub" || found.starts_with("pub(") && found.find(')') == Some(found.len() - 1);
    if is_whole { found } else { "" }
}

/// The attribute that holds where one of these does; none where one of them always holds.
pub(super) fn either(conditions: &[&str]) -> Option<String> {
    let inner = conditions.iter().map(|own| own.strip_prefix("#[cfg(")?.strip_suffix(")]"));
    let mut inner: Vec<&str> = inner.collect::<Option<_>>()?;
    inner.dedup();
    // Of a condition and its opposite one always holds.
    let is_opposed =
        |own: &&str| own.strip_prefix("not(").is_some_and(|own| inner.iter().any(|other| own == format!("{other})")));
    if inner.iter().any(is_opposed) {
        return None;
    }
    let parts: Vec<&str> = inner
        .iter()
        .map(|own| own.strip_prefix("any(").and_then(|parts| parts.strip_suffix(')')).unwrap_or(own).trim())
        .collect();
    match inner.as_slice() {
        [one] => Some(format!("#[cfg({one})]")),
        _ => Some(format!("#[cfg(any({}))]", parts.join(", "))),
    }
}

#[cfg(test)]
mod tests {
    use super::super::text::code_only;
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: Option<&str>) {
        let at = words(&without_comments(text), "Step").next().expect("it is there");
        let code = code_only(text);
        let import = Import::at(Text { text, code: &code }, at, "Step");
        let changed = import.and_then(|import| import.without(text)).map(|(range, new)| {
            let mut text = text.to_owned();
            text.replace_range(range, &new);
            text
        });
        assert_eq!(changed.as_deref(), expected);
    }

    #[test]
    fn an_import_goes_alone() {
        check("use a;\nuse crate::b::Step;\nuse c;\n", Some("use a;\nuse c;\n"));
        check("use crate::b::{Pid, Step};\n", Some("use crate::b::Pid;\n"));
        check("use crate::b::{Kf, Pid, Step};\n", Some("use crate::b::{Kf, Pid};\n"));
        check("use crate::b::{\n    Kf,\n    Step,\n    Pid,\n};\n", Some("use crate::b::{\n    Kf,\n    Pid,\n};\n"));
        check("use crate::b::{ Kf, Pid, Step };\n", Some("use crate::b::{ Kf, Pid };\n"));
        check("use a;\nuse b::Step; // for `step`\n// c\nuse c;\n", Some("use a;\n// c\nuse c;\n"));
        check("use {crate::b::Kf, crate::b::Step};\n", Some("use crate::b::Kf;\n"));
        check("use crate::b::{Step};\nfn f() {}\n", Some("fn f() {}\n"));
        check("use crate::Step::Kf;\n", None);
        check("\u{feff}use crate::b::{Kf, Step};\n", Some("\u{feff}use crate::b::Kf;\n"));
        check("\u{feff}use crate::b::Step;\nuse c;\n", Some("\u{feff}use c;\n"));
        check("use crate::b::Step as Other;\n", Some(""));
        check("#![deny(warnings)]\nuse crate::b::Step;\n", Some("#![deny(warnings)]\n"));
        check(
            "mod a {\n    // c\n    use crate::b::{Kf, Step as _};\n}\n",
            Some("mod a {\n    // c\n    use crate::b::Kf;\n}\n"),
        );
        check("use crate::b::\n{\n    Kf,\n    Step,\n};\n", Some("use crate::b::Kf;\n"));
        check("use crate::{b::{Step, Kf}, c};\n", Some("use crate::{b::Kf, c};\n"));
        check("use crate::{b::Step, c, d};\n", Some("use crate::{c, d};\n"));
        check("use crate::{b::{Kf, Pid}, c::Step};\n", Some("use crate::b::{Kf, Pid};\n"));
        check(
            "fn f() {}\nuse crate::{b::{self, Pid}, c::{Kf, Step}};\n",
            Some("fn f() {}\nuse crate::{b::{self, Pid}, c::Kf};\n"),
        );
        check("use crate::{c::Step, b::{Kf, Pid}, d};\n", Some("use crate::{b::{Kf, Pid}, d};\n"));
        check(
            "use crate::{\n    b::{Kf, Pid},\n    c::Step,\n    d,\n};\n",
            Some("use crate::{\n    b::{Kf, Pid},\n    d,\n};\n"),
        );
        check("use crate::b::{self, Step};\n", Some("use crate::b;\n"));
        check("use crate::{b::{self, Step}, c};\n", Some("use crate::{b, c};\n"));
        check("use a::{Kf, /* its law: */ Step};\n", Some("use a::{Kf};\n"));
        check("use a::{Step, Kf, /* and */ Pid};\n", Some("use a::{Kf, /* and */ Pid};\n"));
        check("use a::{Kf,\n    Step, Pid};\n", Some("use a::{Kf, Pid};\n"));
        check("use a::{\n    Kf,\n    Pid,\n    Step\n};\n", Some("use a::{\n    Kf,\n    Pid\n};\n"));
        check("use a::{\n    Kf, // the filter\n    Step, Pid\n};\n", None);
        check(
            "use a::{\n    // its law: Kf\n    Kf,\n    // the last one\n    Step\n};\n",
            Some("use a::{\n    // its law: Kf\n    Kf,\n    // the last one\n};\n"),
        );
        check("/* we use */ use /* a */ a::Step; // use it\nuse c;\n", Some("/* we use */\nuse c;\n"));
        check(
            "use a::{\n    // What we use;\n    Step, Kf,\n};\n",
            Some("use a::{\n    // What we use;\n    Kf,\n};\n"),
        );
        check("const OLD: &str = \"\nuse a::Step;\n\";\n", None);
        check(
            "use a::{\n    Kf,   // the filter\n    Step, // its trait\n};\n",
            Some("use a::{\n    Kf,   // the filter\n};\n"),
        );
    }

    #[track_caller]
    fn check_for_tests(text: &str, expected: &str) {
        let at = words(text, "Step").next().expect("it is there");
        let code = code_only(text);
        let import = Import::at(Text { text, code: &code }, at, "Step").expect("it is an import");
        let mut changed = text.to_owned();
        for (range, new) in import.under(text, "#[cfg(test)]").expect("it can be under a condition").into_iter().rev() {
            changed.replace_range(range, &new);
        }
        assert_eq!(changed, expected);
    }

    #[test]
    fn a_module_goes_from_the_list_of_what_it_has() {
        let text = "use crate::b::{self, Step};\n";
        let import = Import::of_itself(Text { text, code: text }, text.find("b::").expect("it is there"), "b")
            .expect("it is an import");
        assert_eq!(import.without(text), Some((14..26, "Step".to_owned())));
        assert!(Import::of_itself(Text { text: "use b::{Step};", code: "use b::{Step};" }, 4, "b").is_none());
    }

    #[test]
    fn an_import_is_kept_for_tests() {
        check_for_tests("    use b::Step;\n", "    #[cfg(test)]\n    use b::Step;\n");
        check_for_tests("use b::{Kf, Step};\n", "use b::Kf;\n#[cfg(test)]\nuse b::Step;\n");
        check_for_tests("use b::{Step};\n", "#[cfg(test)]\nuse b::{Step};\n");
    }

    #[test]
    fn an_import_goes_with_its_visibility() {
        check("pub use crate::b::Step;\nuse c;\n", Some("use c;\n"));
        check("use a;\npub(crate) use crate::b::{Kf, Step};\n", Some("use a;\npub(crate) use crate::b::Kf;\n"));
        check("mod p {\n    pub(in crate::a) use crate::b::Step;\n}\n", Some("mod p {\n}\n"));
        check("fn pub_() {}\nuse crate::b::Step;\n", Some("fn pub_() {}\n"));
    }

    #[test]
    fn an_import_has_a_path() {
        let path = |text: &str| {
            let at = words(text, "Step").next().expect("it is there");
            let code = code_only(text);
            Import::at(Text { text, code: &code }, at, "Step")
                .expect("it is an import")
                .path(text)
                .map(|path| path.join("::"))
        };
        assert_eq!(path("use Step;").as_deref(), Some("Step"));
        assert_eq!(path("pub(crate) use a::{b::Kf, b::Step as _};").as_deref(), Some("a::b::Step"));
        assert_eq!(path("use a::{b::{Step, Kf}, c};"), None);
    }

    #[test]
    fn an_import_goes_with_its_condition() {
        let check = |text: &str, expected: Option<&str>| {
            let at = words(text, "Step").next().expect("it is there");
            let code = code_only(text);
            let import = Import::conditional(Text { text, code: &code }, at, "Step");
            let changed = import.and_then(|import| import.without(text)).map(|(range, new)| {
                let mut text = text.to_owned();
                text.replace_range(range, &new);
                text
            });
            assert_eq!(changed.as_deref(), expected);
        };
        check("use a;\n#[cfg(feature = \"use\")]\nuse crate::b::Step;\nuse c;\n", Some("use a;\nuse c;\n"));
        check("#[cfg(x)]\nuse crate::b::{Kf, Step};\n", Some("#[cfg(x)]\nuse crate::b::Kf;\n"));
        check("#[cfg(x)]\n#[allow(unused)]\nuse crate::b::Step;\n", None);
        check("#[cfg(x)]\npub use crate::b::Step;\n", None);
        check("use crate::b::Step;\n", None);
    }

    #[test]
    fn what_is_more_than_an_import_stays() {
        check("#[cfg(x)]\nuse crate::b::Step;\n", None);
        check("use crate::{b::{Step}, c};\n", None);
        check("fn f<T: Step>() {}\n", None);
    }

    #[test]
    fn one_of_several_conditions_is_one() {
        let found = |conditions: &[&str]| either(conditions);
        let feature = "#[cfg(feature = \"sim\")]";
        assert_eq!(found(&[feature, "#[cfg(test)]"]).as_deref(), Some("#[cfg(any(feature = \"sim\", test))]"));
        assert_eq!(found(&["#[cfg(any(a, b))]", "#[cfg(test)]"]).as_deref(), Some("#[cfg(any(a, b, test))]"));
        assert_eq!(found(&["#[cfg(test)]", "#[cfg(test)]"]).as_deref(), Some("#[cfg(test)]"));
        assert_eq!(found(&["#[cfg(not(test))]", "#[cfg(test)]"]), None);
    }
}
