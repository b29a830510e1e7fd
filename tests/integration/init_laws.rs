//! `cargo ceid-lint init`: which methods are resets, partial resets and other forms of a law, and which argument is the state.

use crate::init::written_for;

/// The line of the entry for `Bank`, whose filter has `lanes` lanes, with this reset.
fn with_reset(test: &str, reset: &str) -> String {
    let code = format!(
        "pub struct Stage {{ y: f32 }}\nimpl Stage {{\n\
         pub fn run(&mut self, x: f32) -> f32 {{ self.y += 0.5 * (x - self.y); self.y }}\n\
         pub fn clear(&mut self) {{ self.y = 0.0; }} }}\n\
         pub struct Pair {{ re: f32, im: f32 }}\n\
         pub struct LowPassBank {{ z: [f32; 4], pair: Pair, stages: [Stage; 2], on: bool }}\nimpl LowPassBank {{\n\
         pub fn process(&mut self, x: f32) -> f32 {{\n\
         for z in &mut self.z {{ *z += 0.1 * (x - *z); }}\n\
         self.pair.re = 0.5 * self.pair.re - self.pair.im; self.pair.im = x + self.pair.im * 0.1;\n\
         for stage in &mut self.stages {{ stage.run(x); }} self.z[0] + self.pair.re }}\n\
         {reset} }}\n\
         pub fn run(mut bank: LowPassBank) {{ loop {{ bank.process(1.0); }} }}\n"
    );
    let file = written_for(test, &code);
    let resets: Vec<&str> = file.lines().filter(|line| line.contains("reset = [\"reset\"]")).collect();
    assert_eq!(resets.len(), 1, "{file}");
    resets[0].trim_start_matches('#').to_owned()
}

#[test]
fn a_reset_that_sets_each_part_is_full() {
    for (number, reset) in [
        "pub fn reset(&mut self) { self.z = [0.0; 4]; self.pair = Pair { re: 0.0, im: 0.0 }; for s in &mut self.stages { s.clear(); } }",
        "pub fn reset(&mut self) { self.z.fill(0.0); self.pair.re = 0.0; self.pair.im = 0.0; self.stages.iter_mut().for_each(|s| s.clear()); }",
        "pub fn reset(&mut self, to: f32) { for z in &mut self.z { *z = to; } self.reset_pair(); self.stages[0].y = to; for i in 0..self.stages.len() { self.stages[i].clear(); } }\n\
         fn reset_pair(&mut self) { let Pair { re, im } = Pair { re: 0.0, im: 0.0 }; (self.pair.re, self.pair.im) = (re, im); }",
        "pub fn reset(&mut self) { self.z[0] = 0.0; self.z[1] = 0.0; self.z[2] = 0.0; self.z[3] = 0.0; self.pair = Pair { re: 0.0, im: 0.0 }; for (_, s) in self.stages.iter_mut().enumerate() { s.clear(); } }",
        "pub fn reset(&mut self) { *self = Self { z: [0.0; 4], pair: Pair { re: 0.0, im: 0.0 }, stages: [Stage { y: 0.0 }, Stage { y: 0.0 }], on: true }; }",
    ]
    .into_iter()
    .enumerate()
    {
        assert_eq!(with_reset(&format!("init_full_{number}"), reset), "reset = [\"reset\"]", "{reset}");
    }
}

#[test]
fn a_reset_that_leaves_a_part_is_partial() {
    let rest = "self.pair = Pair { re: 0.0, im: 0.0 }; for s in &mut self.stages { s.clear(); }";
    let all = "self.z = [0.0; 4];";
    for (number, body) in [
        format!("(&mut self, lane: usize) {{ self.z[lane] = 0.0; {rest} }}"),
        format!("(&mut self, lane: usize) {{ let z = &mut self.z[lane]; *z = 0.0; {rest} }}"),
        format!("(&mut self) {{ for z in self.z.iter_mut().skip(1) {{ *z = 0.0; }} {rest} }}"),
        format!("(&mut self) {{ for i in 1..4 {{ self.z[i] = 0.0; }} {rest} }}"),
        format!("(&mut self) {{ self.z[0] = 0.0; self.z[1] = 0.0; {rest} }}"),
        format!("(&mut self, n: usize) {{ for i in 0..n {{ self.z[i] = 0.0; }} {rest} }}"),
        format!("(&mut self, hard: bool) {{ if hard {{ {all} }} {rest} }}"),
        format!("(&mut self) {{ if !self.on {{ return; }} {all} {rest} }}"),
        format!("(&mut self) {{ {all} self.pair.re = 0.0; for s in &mut self.stages {{ s.clear(); }} }}"),
        format!("(&mut self, at: usize) {{ {all} self.pair = Pair {{ re: 0.0, im: 0.0 }}; self.stages[at].clear(); }}"),
        format!("(&mut self) {{ self.z = self.z.map(|z| 0.5 * z); {rest} }}"),
    ]
    .into_iter()
    .enumerate()
    {
        let reset = format!("pub fn reset{body}");
        assert_eq!(with_reset(&format!("init_partial_{number}"), &reset), "partial_reset = [\"reset\"]", "{reset}");
    }
}

#[test]
fn a_line_that_is_filled_needs_no_beginning() {
    let code = |field: &str| {
        format!(
            "pub struct DelayFilter {{ line: [f32; 8], {field}: usize }}\nimpl DelayFilter {{\n\
             pub fn process(&mut self, x: f32) -> f32 {{ let y = self.line[self.{field}]; self.line[self.{field}] = x + 0.5 * y; self.{field} = (self.{field} + 1) % 8; y }}\n\
             pub fn reset(&mut self) {{ self.line.fill(0.0); }} }}\n\
             pub fn run(mut filter: DelayFilter) {{ loop {{ filter.process(1.0); }} }}\n"
        )
    };
    let file = written_for("init_line", &code("write_pos"));
    assert!(file.contains("\nreset = [\"reset\"]"), "{file}");
    let file = written_for("init_line_count", &code("used"));
    assert!(file.contains("partial_reset = [\"reset\"]"), "{file}");
}

#[test]
fn the_reset_of_a_trait_is_as_full_as_that_of_each_type() {
    let code = |reset: &str| {
        format!(
            "pub trait Filter {{ fn update(&mut self, x: f32) -> f32; fn reset(&mut self); }}\n\
             pub struct Lp {{ y: f32 }}\nimpl Filter for Lp {{\n\
             fn update(&mut self, x: f32) -> f32 {{ self.y += 0.1 * (x - self.y); self.y }}\n\
             fn reset(&mut self) {{ self.y = 0.0; }} }}\n\
             pub struct Pi {{ sum: f32, e: f32 }}\nimpl Filter for Pi {{\n\
             fn update(&mut self, x: f32) -> f32 {{ self.sum += x * 0.1 - self.e; self.e = 0.5 * self.e + x; self.sum }}\n\
             fn reset(&mut self) {{ {reset} }} }}\n\
             pub fn run(f: &mut dyn Filter) {{ loop {{ f.update(1.0); }} }}\n"
        )
    };
    let file = written_for("init_trait_full", &code("self.sum = 0.0; self.e = 0.0;"));
    assert!(file.contains("#reset = [\"reset\"]"), "{file}");
    let file = written_for("init_trait_partial", &code("self.sum = 0.0;"));
    assert!(file.contains("#partial_reset = [\"reset\"]"), "{file}");
}

#[test]
fn forms_of_a_law_under_other_names_are_alternatives() {
    let code = |round: &str| {
        format!(
            "pub struct Smoother {{ y: f32, k: f32 }}\nimpl Smoother {{\n\
             pub fn next_smoothed(&mut self, x: f32) -> f32 {{ self.y += self.k * (x - self.y); self.y }}\n\
             pub fn process_block(&mut self, x: f32, n: f32) -> f32 {{ self.y += self.k * n * (x - self.y); self.y }} }}\n\
             pub fn run(mut smoother: Smoother, is_slow: bool, x: f32) {{ loop {{ {round} }} }}\n"
        )
    };
    let both = "law = [[\"next_smoothed\", \"process_block\"]]";
    for (number, round) in [
        "if is_slow { smoother.next_smoothed(x); } else { smoother.process_block(x, 2.0); }",
        "if is_slow { smoother.next_smoothed(x); continue; } smoother.process_block(x, 2.0);",
        "match is_slow { true => smoother.next_smoothed(x), false => smoother.process_block(x, 2.0) };",
    ]
    .into_iter()
    .enumerate()
    {
        let file = written_for(&format!("init_instead_{number}"), &code(round));
        assert!(file.contains(both), "{round}\n{file}");
    }
    // What one round calls beside the law is no other form of it, and without it nothing is certain.
    let file =
        written_for("init_beside_each_other", &code("smoother.next_smoothed(x); smoother.process_block(x, 2.0);"));
    assert!(!file.contains(both) && !file.contains("\n[[filter]]"), "{file}");
}

#[test]
fn both_terms_of_a_controller_are_told_by_their_names() {
    let code = "pub struct IntegralTerm { sum: f32, ki: f32 }\nimpl IntegralTerm {\n\
         pub fn update(&mut self, e: f32, dt: f32) -> f32 { self.sum += e * dt; self.ki * self.sum } }\n\
         pub struct DerivativeTerm { last: f32, kd: f32 }\nimpl DerivativeTerm {\n\
         pub fn update(&mut self, e: f32, dt: f32) -> f32 { let d = (e - self.last) / dt; self.last = e; self.kd * d } }\n\
         pub fn run(mut i: IntegralTerm, mut d: DerivativeTerm) { loop { i.update(1.0, 0.1); d.update(1.0, 0.1); } }\n";
    let file = written_for("init_terms", code);
    assert_eq!(file.matches("\n[[filter]]").count(), 2, "{file}");
}

#[test]
fn a_sum_that_is_drawn_off_is_no_filter() {
    let code = |more: &str| {
        format!(
            "pub struct MotionAccumulator {{ sum: f32 }}\nimpl MotionAccumulator {{\n\
             pub fn accumulate(&mut self, x: f32) -> f32 {{ self.sum += x * 0.5; self.sum }} }}\n\
             pub fn run(mut motion: MotionAccumulator, x: f32) {{ loop {{ let mut sum = motion.accumulate(x); {more} show(sum); }} }}\n\
             fn show(_: f32) {{}}\n"
        )
    };
    let file = written_for("init_drawn_off", &code("while sum > 1.0 { sum = motion.accumulate(-1.0); }"));
    assert!(!file.contains("MotionAccumulator"), "{file}");
    let file = written_for("init_not_drawn_off", &code("while sum > 1.0 { sum -= 1.0; }"));
    assert!(file.contains("MotionAccumulator"), "{file}");
}

#[test]
fn the_state_of_a_function_is_told_from_its_data() {
    let code = |data: &str, state: &str| {
        format!(
            "pub struct Frame {{ pub speed: f32, pub torque: f32 }}\n\
             pub struct {state} {{ pub prev_speed: f32, pub gain: f32 }}\n\
             pub fn inertia_filter({data}: &mut Frame, s: &mut {state}) {{\n\
             {data}.torque += -({data}.speed - s.prev_speed) * s.gain; s.prev_speed = {data}.speed; }}\n\
             pub fn curve_filter({data}: &mut Frame, state: &{state}) {{ {data}.torque = {data}.torque * state.gain + {data}.torque; }}\n\
             pub fn run(mut f: Frame, mut s: {state}) {{ loop {{ inertia_filter(&mut f, &mut s); curve_filter(&mut f, &s); }} }}\n"
        )
    };
    for (number, state) in ["InertiaState", "Inertia"].into_iter().enumerate() {
        let file = written_for(&format!("init_state_{number}"), &code("frame", state));
        assert!(file.contains("#function = \"crate::inertia_filter\"\n#instance = \"arg(1)\""), "{file}");
        assert!(!file.contains("curve_filter"), "{file}");
    }
}
