//! The closure that is a law, as it is written above the loop.

use super::each::Each;
use super::text::Style;

/// A closure with the call that takes it: `Adapted::fed(&mut kf, |kf, z| kf.correct(z))`.
#[derive(Clone, Debug)]
pub(super) struct Closure {
    /// The call, and its argument before the closure.
    pub(super) call: (String, String),
    /// What stands between the bars.
    pub(super) params: String,
    /// The body: its lines, each with the number of steps that it is indented.
    pub(super) body: Vec<(usize, String)>,
    /// Whether the body is an expression, which needs no braces.
    pub(super) is_value: bool,
    /// The law by its path, where the closure would do nothing but call that.
    pub(super) path: Option<String>,
    /// The collection whose filters are lent one by one.
    pub(super) each: Option<Each>,
}

/// How much of a line the arguments of a call may take, in hundredths: the form of rustfmt.
const ARGUMENTS: usize = 60;

impl Closure {
    /// The statement that gives a name to the result of the call, as rustfmt has it.
    pub(super) fn statement(&self, name: &str, indent: &str, style: Style) -> String {
        let Style { end, step, width } = style;
        if let Some(each) = &self.each {
            return self.chain(each, name, indent, style).join(end);
        }
        let Self { call: (call, filter), params, body, .. } = self;
        if self.fits(width) {
            let line = format!("{indent}{}", self.in_one_line(name));
            if line.chars().count() <= width {
                return line;
            }
            let below = format!("{indent}{step}{};", self.lending());
            if below.chars().count() <= width {
                return [format!("{indent}let mut {name} ="), below].join(end);
            }
        }
        if let Some(path) = &self.path {
            let arguments = [filter, path].map(|argument| format!("{indent}{step}{argument},"));
            let head = format!("{indent}let mut {name} = {call}(");
            return [&[head][..], &arguments, &[format!("{indent});")]].concat().join(end);
        }
        let lines =
            |steps: usize| body.iter().map(move |(more, line)| format!("{indent}{}{line}", step.repeat(steps + more)));
        let head = format!("{indent}let mut {name} = {call}({filter}, |{params}| {{");
        if head.chars().count() <= width {
            return std::iter::once(head)
                .chain(lines(1))
                .chain([format!("{indent}}});")])
                .collect::<Vec<_>>()
                .join(end);
        }
        let head = format!("{indent}{step}{call}({filter}, |{params}| {{");
        if head.chars().count() <= width {
            let above = format!("{indent}let mut {name} =");
            return [above, head]
                .into_iter()
                .chain(lines(2))
                .chain([format!("{indent}{step}}});")])
                .collect::<Vec<_>>()
                .join(end);
        }
        let head = [
            format!("{indent}let mut {name} = {call}("),
            format!("{indent}{step}{filter},"),
            format!("{indent}{step}|{params}| {{"),
        ];
        let foot = [format!("{indent}{step}}},"), format!("{indent});")];
        head.into_iter().chain(lines(2)).chain(foot).collect::<Vec<_>>().join(end)
    }

    /// The same where other code stands in the same line.
    pub(super) fn in_one_line(&self, name: &str) -> String {
        let lent = self.lending();
        match &self.each {
            None => format!("let mut {name} = {lent};"),
            Some(Each { elements: (collection, method), name: element, is_vec, .. }) => {
                let collect = if *is_vec { ".collect::<Vec<_>>()" } else { "" };
                format!("let mut {name} = {collection}.{method}().map(|{element}| {lent}){collect};")
            }
        }
    }

    /// Whether the arguments of the call may stand in one line.
    fn fits(&self, width: usize) -> bool {
        let (call, _) = &self.call;
        self.is_value && self.lending().chars().count() <= call.chars().count() + "()".len() + width * ARGUMENTS / 100
    }

    /// What lends one filter, in one line.
    fn lending(&self) -> String {
        let Self { call: (call, filter), params, body, is_value, .. } = self;
        if let Some(path) = &self.path {
            return format!("{call}({filter}, {path})");
        }
        let body = body.iter().map(|(_, line)| line.as_str()).collect::<Vec<_>>().join(" ");
        let body = if *is_value { body } else { format!("{{ {body} }}") };
        format!("{call}({filter}, |{params}| {body})")
    }

    /// The lines that lend the filters of a collection.
    fn chain(&self, each: &Each, name: &str, indent: &str, style: Style) -> Vec<String> {
        let Style { step, width, .. } = style;
        let Self { call: (call, filter), params, body, .. } = self;
        let Each { elements: (collection, method), name: element, is_vec, .. } = each;
        let lent = self.lending();
        let short = format!("{indent}{step}.map(|{element}| {lent})");
        let is_short = self.fits(width) && short.chars().count() < width;
        let mut lines: Vec<String> = Vec::new();
        if is_short || *is_vec {
            // Each link of the chain stands in a line of its own.
            let links = collection.replace('.', &format!("\n{indent}{step}."));
            lines.extend(format!("{indent}let mut {name} = {links}").lines().map(str::to_owned));
            lines.push(format!("{indent}{step}.{method}()"));
        }
        let inner = if lines.is_empty() { indent.to_owned() } else { format!("{indent}{step}") };
        if is_short {
            lines.push(short);
        } else {
            let head = format!("map(|{element}| {{");
            lines.push(match lines.is_empty() {
                true => format!("{indent}let mut {name} = {collection}.{method}().{head}"),
                false => format!("{inner}.{head}"),
            });
            let lent = format!("{inner}{step}{lent}");
            if self.fits(width) && lent.chars().count() <= width {
                lines.push(lent);
            } else if let Some(path) = &self.path {
                lines.push(format!("{inner}{step}{call}("));
                lines.extend([filter, path].map(|argument| format!("{inner}{step}{step}{argument},")));
                lines.push(format!("{inner}{step})"));
            } else {
                lines.push(format!("{inner}{step}{call}({filter}, |{params}| {{"));
                lines.extend(body.iter().map(|(more, line)| format!("{inner}{}{line}", step.repeat(2 + more))));
                lines.push(format!("{inner}{step}}})"));
            }
            lines.push(format!("{inner}}})"));
        }
        if *is_vec {
            lines.push(format!("{indent}{step}.collect::<Vec<_>>()"));
        }
        if let Some(last) = lines.last_mut() {
            last.push(';');
        }
        lines
    }
}
