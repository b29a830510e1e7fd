//! The closure that is a law, as it is written above the loop.

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
}

impl Closure {
    /// The statement that gives a name to the result of the call, as rustfmt has it.
    pub(super) fn statement(&self, name: &str, indent: &str, step: &str, end: &str) -> String {
        const WIDTH: usize = 100;
        let Self { call: (call, filter), params, body, is_value } = self;
        if *is_value {
            let line = format!("{indent}{}", self.in_one_line(name));
            if line.chars().count() <= WIDTH {
                return line;
            }
        }
        let lines =
            |steps: usize| body.iter().map(move |(more, line)| format!("{indent}{}{line}", step.repeat(steps + more)));
        let head = format!("{indent}let mut {name} = {call}({filter}, |{params}| {{");
        if head.chars().count() <= WIDTH {
            return std::iter::once(head)
                .chain(lines(1))
                .chain([format!("{indent}}});")])
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
        let Self { call: (call, filter), params, body, is_value } = self;
        let body = body.iter().map(|(_, line)| line.as_str()).collect::<Vec<_>>().join(" ");
        let body = if *is_value { body } else { format!("{{ {body} }}") };
        format!("let mut {name} = {call}({filter}, |{params}| {body});")
    }
}
