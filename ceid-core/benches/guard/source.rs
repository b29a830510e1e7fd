//! The programs that are measured: the same loop with calls written by hand and with a guard, in Rust and in C++.

/// How the update laws are run in Rust.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Form {
    /// One call after the other, below the body, which an early end of the cycle jumps to.
    #[default]
    Hand,
    /// The same calls in a function, called below the body and before each `continue`.
    HandTwice,
    /// `ceid!(cycle => f = filters)`
    List,
    /// The same in a body whose last statement is `continue` as well.
    ListToContinue,
    /// `each_cycle!(f in control => { … })`
    EachCycle,
    /// `control.run(|f, info| …)`
    Run,
}

impl Form {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Hand => "hand",
            Self::HandTwice => "hand_twice",
            Self::List => "ceid",
            Self::ListToContinue => "ceid_to_continue",
            Self::EachCycle => "each_cycle",
            Self::Run => "run",
        }
    }
}

/// What the body is like: where it gets its measurement, and where it ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Body {
    /// From an array, so that nothing in the cycle can panic; the body has one end.
    Straight,
    /// The same with an early end.
    Early,
    /// From a function behind a pointer, which may panic for all the compiler knows; with an early end.
    Opaque,
}

impl Body {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Straight => "straight",
            Self::Early => "early",
            Self::Opaque => "opaque",
        }
    }
}

/// Repeats a text for each filter.
fn each(filters: usize, text: impl Fn(usize) -> String) -> String {
    (0..filters).map(text).collect()
}

/// The statements between the guard and the laws.
fn body(filters: usize, body: Body, set: &str, leave: &str) -> String {
    let measure = match body {
        Body::Straight | Body::Early => "samples.0[(n & 255) as usize]",
        Body::Opaque => "(samples.1)(n)",
    };
    let chain = each(filters - 1, |filter| format!("{set}.f{}.input = {set}.f{filter}.output;\n", filter + 1));
    let exit = if body == Body::Straight { String::new() } else { format!("if position < 0.0 {{ {leave} }}\n") };
    format!("let position = {measure};\n{set}.f0.input = position;\n{exit}{chain}")
}

pub(crate) fn rust(form: Form, filters: usize, kind: Body) -> String {
    let fields = each(filters, |filter| format!("f{filter}: LowPass; "));
    let values = each(filters, |_| "LowPass { input: 0.0, output: 0.0 }, ".to_owned());
    let sum = each(filters, |filter| format!(" + control.filters().f{filter}.output"));
    let lines = |set: &str, leave: &str| body(filters, kind, set, leave);
    let (control, construct, control_loop) = match form {
        Form::Hand | Form::HandTwice | Form::List | Form::ListToContinue => {
            let calls = each(filters, |filter| format!("filters.f{filter}.advance(Hz::<1000>::DT);\n"));
            let control_loop = match form {
                Form::Hand => {
                    let lines = lines("filters", "break 'body;");
                    format!("while let Some(info) = clock.wait() {{\nlet n = info.n;\n'body: {{\n{lines}}}\n{calls}}}")
                }
                Form::HandTwice => {
                    let lines = lines("filters", "update(filters);\ncontinue;");
                    format!(
                        "#[inline]\nfn update(filters: &mut Filters) {{ {calls} }}\n\
                         while let Some(info) = clock.wait() {{\nlet n = info.n;\n{lines}update(filters);}}"
                    )
                }
                _ => {
                    let lines = lines("f", "continue;");
                    let last = if form == Form::ListToContinue { "continue;\n" } else { "" };
                    format!(
                        "while let Some(cycle) = clock.next_cycle() {{\nlet n = cycle.info().n;\n\
                         ceid!(cycle => f = filters);\n{lines}{last}}}"
                    )
                }
            };
            (
                "pub struct Control { filters: Filters, clock: Cycles }\n\
                 impl Control { fn filters(&self) -> &Filters { &self.filters } }",
                "Control { filters, clock }",
                format!("let Control {{ filters, clock }} = control;\n{control_loop}"),
            )
        }
        Form::EachCycle => (
            "type Control = Cyclic<Filters, Cycles>;",
            "Cyclic::new(filters, clock)",
            format!("each_cycle!(f, info in control => {{\nlet n = info.n;\n{}}});", lines("f", "continue;")),
        ),
        Form::Run => (
            "type Control = Cyclic<Filters, Cycles>;",
            "Cyclic::new(filters, clock)",
            format!(
                "control.run(|f, info| -> core::ops::ControlFlow<()> {{\nlet n = info.n;\n{}\
                 core::ops::ControlFlow::Continue(())\n}});",
                lines("f", "return core::ops::ControlFlow::Continue(());")
            ),
        ),
    };
    format!(
        "use ceid_core::prelude::*;
type Cycles = ceid_core::Take<Free<Hz<1000>>>;
type Samples = ([f64; 256], fn(u64) -> f64);
pub struct LowPass {{ input: f64, output: f64 }}
impl LowPass {{
    #[inline]
    fn advance(&mut self, dt: f64) {{ self.output += (self.input - self.output) * (dt * 20.0); }}
}}
impl<R: Rate> SampledFilter<R> for LowPass {{
    #[inline]
    fn update(&mut self, tick: Tick<'_, R>) {{ self.advance(tick.dt()) }}
}}
filters! {{ pub struct Filters @ 1000 Hz {{ {fields} }} }}
{control}
#[unsafe(no_mangle)]
#[inline(never)]
pub fn control_loop(control: &mut Control, samples: &Samples) {{
{control_loop}
}}
fn sample(n: u64) -> f64 {{ if n % 7 == 3 {{ -1.0 }} else {{ (n % 100) as f64 }} }}
fn main() {{
    let cycles = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(1000);
    let samples = std::hint::black_box((core::array::from_fn(|n| sample(n as u64)), sample as fn(u64) -> f64));
    let (filters, clock) = (Filters::register({values}), Free::<Hz<1000>>::new().take(cycles));
    let mut control = {construct};
    control_loop(&mut control, &samples);
    println!(\"{{:?}}\", 0.0{sum});
}}
"
    )
}

/// The same loop in C++, with calls written by hand or with the guard of the paper.
pub(crate) fn cpp(guarded: bool, filters: usize) -> String {
    let declare = each(filters, |filter| format!("LowPass f{filter}; "));
    let chain = each(filters - 1, |filter| format!("f.f{}.input = f.f{filter}.output;\n", filter + 1));
    let lines = |leave: &str| {
        format!(
            "double position = samples[n & 255];\nf.f0.input = position;\nif (position < 0.0) {{ {leave} }}\n{chain}"
        )
    };
    let list = |text: fn(usize) -> String| (0..filters).map(text).collect::<Vec<_>>().join(", ");
    let cycle = if guarded {
        let arguments = list(|filter| format!("f.f{filter}"));
        format!("auto&& cyclicExecution = CEIDAll({arguments});\n(void)cyclicExecution;\n{}", lines("continue;"))
    } else {
        let calls = each(filters, |filter| format!("f.f{filter}.update();\n"));
        format!("{{\n{}}}\nupdate:\n{calls}", lines("goto update;"))
    };
    let types = list(|_| "LowPass".to_owned());
    let sum = each(filters, |filter| format!(" + filters.f{filter}.output"));
    format!(
        "#include \"ceid.hpp\"
#include <cstdint>
#include <cstdio>
#include <cstdlib>
class LowPass {{
public:
    double input = 0.0, output = 0.0;
    void update() {{ output += (input - output) * (0.001 * 20.0); }}
}};
using CEIDAll = CEID<{types}>;
static_assert(is_update_per_cycle_once<CEIDAll, LowPass>::value, \"LowPass is not updated.\");
struct Filters {{ {declare} }};
extern \"C\" __attribute__((noinline)) void control_loop(Filters& f, uint64_t cycles, const double* samples) {{
for (uint64_t n = 0; n < cycles; ++n) {{
{cycle}}}
}}
int main(int, char** arguments) {{
    static double samples[256];
    for (int n = 0; n < 256; ++n) samples[n] = n % 7 == 3 ? -1.0 : n % 100;
    Filters filters;
    control_loop(filters, std::strtoull(arguments[1], nullptr, 10), samples);
    std::printf(\"%.17g\\n\", 0.0{sum});
}}
"
    )
}
