//! Notes calls that wait or read a clock, and the steps that filters are made with. Changes nothing of the graph.

use super::Builder;
use super::constants::{Constant, Constants};
use crate::flow::waits::{Wait, WaitKind, function_wait, method_wait};
use crate::flow::{Step, StepUnit, Var, step_unit};
use crate::index::{FunctionId, TraitName, Ty};
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::Callee;

/// What makes something periodic of a time.
const TICKERS: &[&str] = &["embassy_time::Ticker::every", "tokio::time::interval"];

impl Builder<'_> {
    pub(super) fn constants(&self) -> Constants<'_> {
        Constants { program: self.program, body: self.body(), typed: self.typed() }
    }

    /// A time that the source fixes, in seconds; a plain number counts in units.
    fn seconds(&self, id: ExprId, unit: Option<f64>) -> Option<f64> {
        match (self.constants().value(id)?, unit) {
            (Constant::Seconds(seconds), _) => Some(seconds),
            (Constant::Number(number), Some(unit)) => Some(number * unit),
            (Constant::Number(_), None) => None,
        }
    }

    /// Notes a function outside the analysed code that waits.
    pub(super) fn note_function_wait(&mut self, id: ExprId, path: &str, args: &[ExprId]) {
        let Some(kind) = function_wait(path) else { return };
        let unit = match path.rsplit("::").next().unwrap_or("") {
            "sleep_ms" | "after_millis" => Some(1e-3),
            "after_micros" | "usleep" => Some(1e-6),
            "after_secs" => Some(1.0),
            _ => None,
        };
        let is_paced =
            kind == WaitKind::Sleep && !matches!(path.rsplit("::").next(), Some("at" | "sleep_until" | "park"));
        let period = args.first().filter(|_| is_paced).and_then(|arg| self.seconds(*arg, unit));
        let what = path.rsplit("::").take(2).collect::<Vec<_>>();
        let what = what.into_iter().rev().collect::<Vec<_>>().join("::");
        self.add_wait(id, kind, what, period);
    }

    /// Notes a method of a type outside the analysed code that waits.
    pub(super) fn note_method_wait(&mut self, id: ExprId, receiver: ExprId, method: &str, args: &[ExprId]) {
        if matches!(self.typed().callees.get(&id), Some(Callee::Resolved(resolved)) if !resolved.targets.is_empty()) {
            return;
        }
        if matches!(method, "next" | "tick") {
            if let Some(period) = self.ticker_period(receiver) {
                self.add_wait(id, WaitKind::Tick, method.to_owned(), Some(period));
            }
            return;
        }
        let Some(kind) = owners(self.ty(receiver)).iter().find_map(|owner| method_wait(owner, method)) else { return };
        let unit = match method {
            "delay_ms" => Some(1e-3),
            "delay_us" => Some(1e-6),
            "delay_ns" => Some(1e-9),
            _ => None,
        };
        let period = unit.and_then(|unit| self.seconds(*args.first()?, Some(unit)));
        let what = format!("{}.{method}", self.text(receiver));
        self.add_wait(id, kind, what, period);
    }

    fn add_wait(&mut self, id: ExprId, kind: WaitKind, what: String, period: Option<f64>) {
        // What runs elsewhere waits there, unless a loop of its own is the cycle.
        let Some(node) = self.at.filter(|_| !self.is_detached || !self.loops.is_empty()) else { return };
        let wait = Wait { kind, what, span: self.span(id), node, in_loop: self.loops.last().copied(), period };
        self.graph.waits.push(wait);
    }

    /// The period of the ticker that an expression names, if that is constant.
    fn ticker_period(&self, receiver: ExprId) -> Option<f64> {
        let made = self.constants().initial(receiver)?;
        let Some(Callee::External(path)) = self.typed().callees.get(&made) else { return None };
        let ExprKind::Call { args, .. } = &self.body().expr(made).kind else { return None };
        let arg = args.first().filter(|_| TICKERS.contains(&path.as_str()))?;
        self.seconds(*arg, None)
    }

    /// Notes the step that a function of a filter's type is given.
    pub(super) fn note_given_step(&mut self, target: FunctionId, result: Var, ty: &Ty, args: &[ExprId]) {
        let index = self.program.index;
        let function = &index.function(target).function;
        if index.filter_spec(ty).is_none() {
            return;
        }
        let Some(body) = &function.body else { return };
        let names = crate::flow::parameter_names(body);
        let skip = body.params.len().saturating_sub(args.len());
        let found = names.skip(skip).zip(args).find_map(|(name, arg)| self.step(name, *arg));
        if let Some(step) = found {
            self.graph.steps.insert(result, step);
        }
    }

    /// Notes the step that a filter's fields are given.
    pub(super) fn note_field_step(&mut self, var: Var, ty: &Ty, fields: &[(String, ExprId)]) {
        if self.program.index.filter_spec(ty).is_some()
            && let Some(step) = fields.iter().find_map(|(name, value)| self.step(name, *value))
        {
            self.graph.steps.insert(var, step);
        }
    }

    /// The constant step that is given under a name, if the name is that of a step.
    fn step(&self, name: &str, value: ExprId) -> Option<Step> {
        let unit = step_unit(name)?;
        let (seconds, has_unit) = match (unit, self.constants().value(value)?) {
            (StepUnit::Time(_), Constant::Seconds(seconds)) => (seconds, true),
            (StepUnit::Time(Some(unit)), Constant::Number(number)) => (number * unit, true),
            // A whole number without a unit may count anything.
            (StepUnit::Time(None), Constant::Number(number)) if *self.ty(value) == Ty::Float && name != "period" => {
                (number, false)
            }
            (StepUnit::Rate(unit), Constant::Number(number)) if number > 0.0 => (1.0 / (number * unit), true),
            _ => return None,
        };
        Some(Step { seconds, has_unit, span: self.span(value) })
    }
}

/// The paths of a type behind references and pointers, and of the traits that bound it.
fn owners(ty: &Ty) -> Vec<String> {
    let of_bounds = |bounds: &[crate::index::TraitRef]| -> Vec<String> {
        let names = bounds.iter().filter_map(|bound| match &bound.name {
            TraitName::External(path) => Some(path.clone()),
            TraitName::Local(_) => None,
        });
        names.collect()
    };
    match ty.peel() {
        Ty::External(path, args) => {
            let name = path.rsplit("::").next().unwrap_or("");
            match args.first() {
                Some(inner) if crate::types::is_pointer(name) => owners(inner),
                _ => vec![path.clone()],
            }
        }
        Ty::Param(param) => of_bounds(&param.bounds),
        Ty::Opaque(bounds) => of_bounds(bounds),
        _ => Vec::new(),
    }
}
