//! Calls that take the callback of a device or timer: each call of the closure is one control cycle.

use super::{Builder, Value};
use crate::index::{FunctionId, TraitName, Ty};
use crate::syntax::tree::{ExprId, ExprKind, PatId};
use crate::types::Callee;

impl Builder<'_> {
    /// Whether the first closure that a call gets is called once per cycle.
    pub(super) fn takes_callback(&self, id: ExprId) -> bool {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::MethodCall { receiver, method, .. } => {
                let of_timer = || self.type_name(self.ty(*receiver)).is_some_and(is_timer);
                CALLBACK_METHODS.contains(&method.as_str()) || (TIMER_METHODS.contains(&method.as_str()) && of_timer())
            }
            ExprKind::Call { callee, .. } => match &body.expr(*callee).kind {
                ExprKind::Path(path) => {
                    let names: Vec<&str> = path.segments.iter().map(|segment| segment.name.as_str()).collect();
                    match names.as_slice() {
                        [.., owner, name] if CALLBACK_TYPES.contains(owner) => {
                            name.starts_with("new") || *name == "with_state"
                        }
                        [.., owner, name] if is_timer(owner) && TIMER_METHODS.contains(name) => true,
                        [.., name] => CALLBACK_METHODS.contains(name),
                        [] => false,
                    }
                }
                _ => false,
            },
            _ => false,
        }
    }

    /// Whether a function calls what it gets as a parameter, so that its body tells how often.
    fn calls_parameter(&self, id: FunctionId) -> bool {
        let calls = |callee: &Callee| matches!(callee, Callee::Parameter(_));
        self.program.typed(id).is_some_and(|typed| typed.callees.values().any(calls))
    }

    /// Whether the closure that a function is given is called from elsewhere.
    pub(super) fn keeps_callback(&self, id: ExprId, target: FunctionId, values: &[Value]) -> bool {
        self.takes_callback(id) && !self.calls_parameter(target) || self.stands_for_framework(target, values)
    }

    /// Whether a function asks for a closure that can be called again and again, and does nothing with it: it stands for one of a
    /// framework, which calls the closure from elsewhere.
    fn stands_for_framework(&self, id: FunctionId, values: &[Value]) -> bool {
        let (Some(body), Some(typed)) = (&self.program.index.function(id).function.body, self.program.typed(id)) else {
            return false;
        };
        let is_named = |pat: &PatId| {
            let local = typed.pat_local.get(pat);
            local.is_some_and(|local| typed.expr_local.values().any(|named| named == local))
        };
        let given = body.params.iter().zip(values).enumerate().filter(|(_, (_, value))| value.closure.is_some());
        let mut is_idle = given.map(|(at, (pat, _))| !is_named(pat) && is_called_again(&self.declared_param(id, at)));
        is_idle.next().is_some_and(|first| first && is_idle.all(|idle| idle))
    }

    /// The last name of a type, behind references.
    fn type_name<'t>(&'t self, ty: &'t Ty) -> Option<&'t str> {
        match ty.peel() {
            Ty::Adt(id, _) => Some(&self.program.index.type_def(*id).name),
            ty => ty.external_name(),
        }
    }
}

/// Whether a value of the type can be called more than once.
fn is_called_again(ty: &Ty) -> bool {
    let bounds = match ty.peel() {
        Ty::Param(param) => param.bounds.as_slice(),
        Ty::Opaque(bounds) => bounds.as_slice(),
        Ty::External(path, args) if path.ends_with("::Box") => return args.first().is_some_and(is_called_again),
        _ => return false,
    };
    bounds.iter().any(|bound| match &bound.name {
        TraitName::External(path) => matches!(path.rsplit("::").next(), Some("Fn" | "FnMut")),
        TraitName::Local(_) => false,
    })
}

fn is_timer(name: &str) -> bool {
    name.contains("Timer") || name.ends_with("Ticker")
}

/// Methods whose first closure an audio device, or a timer that repeats, calls once per cycle.
const CALLBACK_METHODS: &[&str] = &[
    // Audio: cpal, cubeb, portaudio, coreaudio, oboe.
    "build_input_stream",
    "build_input_stream_raw",
    "build_output_stream",
    "build_output_stream_raw",
    "build_duplex_stream",
    "data_callback",
    "set_data_callback",
    "open_non_blocking_stream",
    "set_input_callback",
    "set_render_callback",
    "set_process_callback",
    "set_audio_callback",
    // Timers: timer, glib, ROS.
    "schedule_repeating",
    "timeout_add",
    "timeout_add_local",
    "create_timer_repeating",
    "create_wall_timer",
    "set_interval",
];

/// Methods of timers whose closure is called each time that the timer fires.
const TIMER_METHODS: &[&str] = &[
    "subscribe",
    "every",
    "repeat",
    "start",
    "timer",
    "timer_nonstatic",
    "set_callback",
    "on_tick",
    "on_update",
    "listen",
];

/// Types that wrap the callback of an audio client: jack.
const CALLBACK_TYPES: &[&str] = &["ClosureProcessHandler"];
