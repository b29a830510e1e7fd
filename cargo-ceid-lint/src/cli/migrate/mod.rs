//! `cargo ceid-lint migrate`: loops that update their filters by hand get a guard of `ceid-core`.

mod args;
mod core;
mod files;
mod keyed;
mod left;
mod names;
mod offered;

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Instant;

use self::core::{core_directory, relative};
use self::files::{same_file, text_of};
use self::keyed::{Key, Keyed, keyed};
use self::left::left;
use self::names::needless_names;
use self::offered::Offered;
use super::args::FixArgs;
use super::console::Stream;
use super::{Console, ExitStatus, input, interrupted, vcs};
use crate::count::Cycle;
use crate::diagnostic::Diagnostic;
use crate::fix::{self, Bounds, Edit, Fix, Revision};
use crate::index::{FunctionId, Ty};
use crate::migrate::{Doubtful, HandedOn, Plan, Reason, Rewrite, quoted};
use crate::pipeline::{Options, Purpose, Report, dependencies};
use crate::project::Project;
use crate::report::{count, text};
use crate::source::{DiskSource, ReadSource, SourceMap, Span};
use args::Asked;
pub(super) use args::{AFTER_HELP, MigrateArgs};

/// Plans, migrates and tells.
///
/// # Errors
/// What is wrong with the arguments.
pub(super) fn run(args: &MigrateArgs) -> Result<ExitStatus, String> {
    let console = Console::new(&args.talk);
    let asked = args.asked()?;
    args.ceid_core_path.as_deref().map(core_directory).transpose()?;
    let mut selection = input::selection(&[], &args.scope, &args.build);
    // Code of any member may use what a migration changes.
    selection.workspace |= selection.packages.is_empty();
    let Ok(project) = input::project(&selection, console, Instant::now()) else { return Ok(ExitStatus::Incomplete) };
    if args.diff || matches!(asked, Asked::Nothing) {
        interrupted::tell(&project, console);
    } else if interrupted::complete(&Bounds::of(&project), console) {
        return Ok(ExitStatus::Incomplete);
    }
    let options = Options { purpose: Purpose::Migration, ..Options::default() };
    let check = |source: Box<dyn ReadSource>| input::checked(&project, &options, source, console);
    let first = check(Box::new(DiskSource));
    if first.is_config_wrong || !first.report.problems.is_empty() {
        for problem in &first.report.problems {
            console.show(&text::problem(&first.report.sources, problem, console.style(Stream::Err)));
        }
        let why =
            if first.is_config_wrong { "" } else { ": code that cannot be read may use what a migration changes" };
        console.error(&format!("nothing was migrated{why}"), None);
        return Ok(ExitStatus::Incomplete);
    }
    let run = Run {
        args,
        project: &project,
        asked,
        console,
        touched: RefCell::default(),
        offered: RefCell::default(),
        doubtful: RefCell::default(),
    };
    run.migrate(&first.report, |source| check(source).report)
}

struct Run<'a> {
    args: &'a MigrateArgs,
    project: &'a Project,
    asked: Asked,
    console: Console,
    /// The files in which loops are migrated.
    touched: RefCell<BTreeSet<PathBuf>>,
    /// What is told of each loop that gets a guard: by its file and title, from the report by which it was migrated.
    offered: RefCell<BTreeMap<Key, Offered>>,
    /// The imports that may be idle in the newest text, each with its file and line.
    doubtful: RefCell<Vec<(String, u32, Doubtful)>>,
}

impl Run<'_> {
    fn migrate(&self, first: &Report, check: impl Fn(Box<dyn ReadSource>) -> Report) -> Result<ExitStatus, String> {
        let chosen = self.chosen(first)?;
        let left = self.tell_left(first);
        let is_left = left > 0 && matches!(self.asked, Asked::At(_));
        let bounds = Bounds::of(self.project);
        if !self.args.diff && !matches!(self.asked, Asked::Nothing) {
            super::fix::remove_abandoned(&bounds, self.project, first);
        }
        if chosen.is_empty() {
            if is_left {
                return Ok(ExitStatus::Findings);
            }
            self.console.say(&self.nothing(first));
            return Ok(ExitStatus::Clean);
        }
        if matches!(self.asked, Asked::Nothing) {
            self.list(first, &chosen);
            return Ok(ExitStatus::Clean);
        }
        let fixes = FixArgs {
            fix: true,
            unsafe_fixes: self.args.unsafe_fixes,
            diff: self.args.diff,
            allow_dirty: self.args.allow_dirty,
            allow_staged: self.args.allow_staged,
            allow_no_vcs: self.args.allow_no_vcs,
        };
        let refusal = bounds.repositories().find_map(|root| vcs::check(root, &fixes).err());
        if let Some(refusal) = refusal.filter(|_| !self.args.diff) {
            self.console.error(&refusal.replace("ceid-lint fix", "ceid-lint migrate"), None);
            return Ok(ExitStatus::Incomplete);
        }
        let mut revision = fix::revise(first, |report| self.offer(report, first), |path| bounds.file(path), &check);
        fix::keep_form(&mut revision.changes, |path, text| self.project.formatted(path, text));
        if self.args.diff {
            for change in &revision.changes {
                self.console.print(&fix::diff(change, &first.sources));
            }
        }
        let mut is_unwritten = revision.refused.iter().any(|refused| refused.is_unwritable);
        if !self.args.diff
            && let Err(error) = fix::commit(&revision, first, &mut bounds.disk(), || check(Box::new(DiskSource)))
        {
            self.console.error(&error, None);
            return Ok(ExitStatus::Incomplete);
        }
        let refused = self.tell(first, &chosen, &revision, left);
        is_unwritten |= revision.made.is_empty() && revision.refused.iter().any(|refused| refused.is_unwritable);
        Ok(if is_unwritten {
            ExitStatus::Incomplete
        } else if self.args.diff && !revision.changes.is_empty()
            || refused > 0 && matches!(self.asked, Asked::At(_))
            || is_left
        {
            ExitStatus::Findings
        } else {
            ExitStatus::Clean
        })
    }

    /// The plans that were asked for.
    fn chosen<'r>(&self, report: &'r Report) -> Result<Vec<Keyed<'r>>, String> {
        let plans = keyed(report);
        let Asked::At(places) = &self.asked else {
            return Ok(plans.into_iter().filter(|keyed| !keyed.plan.is_helper).collect());
        };
        let mut heads = BTreeSet::new();
        for (path, line) in places {
            let is_file = |span: Span| same_file(&report.sources.file(span.file).path, path);
            let holds = |span: Span| {
                let last = Span { start: span.end.saturating_sub(1), ..span };
                (report.sources.line(span)..=report.sources.line(last)).contains(line)
            };
            let around = report.plans.iter().filter(|plan| is_file(plan.head) && holds(plan.whole));
            let innermost = around.max_by_key(|plan| plan.head.start);
            let is_cycle =
                report.cycles.iter().any(|cycle| is_file(cycle.head) && report.sources.line(cycle.head) == *line);
            match innermost {
                Some(plan) if is_cycle && report.sources.line(plan.head) != *line => {}
                Some(plan) => drop(heads.insert(plan.head)),
                None if is_cycle => {}
                None => {
                    return Err(format!("there is no control cycle at line {line} of `{}`", path.display()));
                }
            }
        }
        Ok(plans.into_iter().filter(|keyed| heads.contains(&keyed.plan.head)).collect())
    }

    /// Tells why loops stay as they are though no plan is about them, and how many these are: of those that were named, or of all.
    fn tell_left(&self, report: &Report) -> usize {
        let line = |head: Span| report.sources.line(head);
        let is_at = |head: Span, (path, at): &(PathBuf, u32)| {
            line(head) == *at && same_file(&report.sources.file(head.file).path, path)
        };
        let is_told = |head: Span| match &self.asked {
            Asked::Nothing | Asked::All => true,
            Asked::At(places) => places.iter().any(|place| is_at(head, place)),
        };
        let mut number = 0;
        if !matches!(self.asked, Asked::At(_)) {
            for plan in report.plans.iter().filter(|plan| plan.is_helper) {
                let title = self.title(report, plan, &plan.filters);
                self.console.warn(&format!(
                    "{title}: not migrated\n  nothing says that it is called once per cycle: if it is, name it by \
                     `cargo ceid-lint migrate {}:{}`",
                    report.sources.file(plan.head.file).name,
                    line(plan.head)
                ));
                number += 1;
            }
        }
        let without_plan = |cycle: &&Cycle| !report.plans.iter().any(|plan| plan.head == cycle.head);
        for cycle in report.cycles.iter().filter(|cycle| is_told(cycle.head)).filter(without_plan) {
            let mut reasons: Vec<String> = cycle.filters.iter().filter_map(|pair| left(report, cycle, pair)).collect();
            // A law of several halves has a pair for each.
            reasons.dedup();
            if !reasons.is_empty() {
                let file = &report.sources.file(cycle.head.file).name;
                let title = format!("{file}:{}: `{}`: not migrated", line(cycle.head), cycle.function);
                self.console.warn(&[vec![title], reasons].concat().join("\n  "));
                number += 1;
            }
        }
        number
    }

    fn nothing(&self, report: &Report) -> String {
        if report.cycles.is_empty() {
            "there is no control cycle here; `cargo ceid-lint init` looks for filters".to_owned()
        } else {
            "nothing to migrate: no filter is updated by hand in every cycle".to_owned()
        }
    }

    /// Tells what could be done.
    fn list(&self, report: &Report, plans: &[Keyed<'_>]) {
        let can = |plan: &&Plan| self.taken(plan).is_some_and(|rewrite| self.edits(report, rewrite).is_ok());
        let (able, unable): (Vec<&Plan>, Vec<&Plan>) = plans.iter().map(|keyed| keyed.plan).partition(can);
        for plan in able {
            self.console.say(&format!("{} can be migrated", self.title(report, plan, self.going(plan))));
            self.tell_staying(report, plan);
        }
        for plan in unable {
            self.refuse(report, plan, None);
        }
        self.console.say("`cargo ceid-lint migrate FILE:LINE` migrates one loop, `--all` all that can be");
    }

    fn is_taken(&self, rewrite: &Rewrite) -> bool {
        self.args.unsafe_fixes || rewrite.changes.is_empty()
    }

    /// How a loop is rewritten: with all its filters, or with those that can go.
    fn taken<'p>(&self, plan: &'p Plan) -> Option<&'p Rewrite> {
        let all = plan.outcome.as_ref().ok().filter(|rewrite| self.is_taken(rewrite));
        all.or_else(|| plan.partly.as_ref().map(|partly| &partly.rewrite))
    }

    /// The filters that go by that.
    fn going<'p>(&self, plan: &'p Plan) -> &'p [String] {
        match (&plan.outcome, &plan.partly) {
            (Ok(rewrite), _) if self.is_taken(rewrite) => &plan.filters,
            (_, Some(partly)) => &partly.filters,
            _ => &plan.filters,
        }
    }

    /// Tells why some filters of a loop stay as they are where the others go.
    fn tell_staying(&self, report: &Report, plan: &Plan) {
        let going = self.going(plan);
        let staying: Vec<String> = plan.filters.iter().filter(|name| !going.contains(name)).cloned().collect();
        let (Some(partly), [_, ..]) = (&plan.partly, staying.as_slice()) else { return };
        let how = match &plan.outcome {
            Ok(_) => " (`--unsafe-fixes` migrates all, and the program does something else then)",
            Err(_) => "",
        };
        self.console.say(&format!("  {}{how}:", plan.stay(&staying)));
        let mut reasons: Vec<String> = partly.reasons.iter().map(|reason| told(report, plan, reason)).collect();
        reasons.dedup();
        reasons.iter().for_each(|reason| self.console.say(&format!("    {reason}")));
    }

    /// The fixes of a round.
    fn offer(&self, report: &Report, first: &Report) -> Vec<Fix> {
        let Ok(of_first) = self.chosen(first) else { return Vec::new() };
        let chosen: BTreeMap<&Key, &Plan> = of_first.iter().map(|keyed| (&keyed.key, keyed.plan)).collect();
        let mut fixes = Vec::new();
        let mut laws: Vec<(Ty, FunctionId)> = Vec::new();
        for Keyed { key, plan } in keyed(report) {
            if let Some(of_first) = chosen.get(&key)
                && let Some(rewrite) = self.taken(plan)
                && !rewrite.laws.iter().any(|(ty, law)| laws.iter().any(|(own, other)| own.may_be(ty) && other != law))
                && let Ok(edits) = self.edits(report, rewrite)
            {
                // A type has one law for guards; what another loop would make of it shows once that is written.
                laws.extend(rewrite.laws.iter().cloned());
                let of_first = self.taken(of_first).map(|rewrite| Offered::of(first, of_first, rewrite));
                let offered = Offered::of(report, plan, rewrite).in_lines_of(of_first);
                self.touched.borrow_mut().extend(edits.iter().map(|edit| edit.path.clone()));
                fixes.push(fix_of(report, plan.head, key.1.clone(), edits));
                self.offered.borrow_mut().insert(key, offered);
            }
        }
        let is_touched = |path: &Path| self.touched.borrow().iter().any(|own| same_file(own, path));
        fixes.extend(idle(report, first, is_touched));
        fixes.extend(needless_names(report, first));
        let sources = &report.sources;
        let doubtful =
            report.idle_imports.doubtful.iter().filter(|import| is_touched(&sources.file(import.span.file).path));
        let told = |import: &Doubtful| {
            (sources.file(import.span.file).name.clone(), sources.line(import.span), import.clone())
        };
        *self.doubtful.borrow_mut() = doubtful.map(told).collect();
        // A suppression of what a guard has put right goes with it.
        let known: BTreeSet<_> = first.shown().filter(is_unused).map(|finding| said(first, finding)).collect();
        fixes.extend(fix::offered(report, false, |finding| {
            is_unused(&finding) && !known.contains(&said(report, finding))
        }));
        fixes
    }

    /// The edits of a plan, those in manifests included.
    fn edits(&self, report: &Report, rewrite: &Rewrite) -> Result<Vec<Edit>, String> {
        let core = self.args.ceid_core_path.as_deref();
        let named = |manifest: &Path| core.map(|core| relative(core, manifest)).transpose();
        let added = dependencies(report, self.project, rewrite, named)?.into_iter();
        let added = added.map(|(path, at, text)| Edit { path, start: at, end: at, text });
        Ok(rewrite.edits.iter().map(|edit| edit_of(&report.sources, edit)).chain(added).collect())
    }

    /// Tells what was done and what was not, beside the loops without a plan, and how much was not.
    fn tell(&self, first: &Report, chosen: &[Keyed<'_>], revision: &Revision, unplanned: usize) -> usize {
        let own: BTreeSet<(&str, &str)> =
            revision.made.iter().map(|fix| (fix.file.as_str(), fix.title.as_str())).collect();
        let is_own = |keyed: &Keyed<'_>| own.contains(&(keyed.key.0.as_str(), keyed.key.1.as_str()));
        // Two loops may call the function that gets the guard.
        let is_same = |one: &Keyed<'_>, other: &Keyed<'_>| {
            self.taken(one.plan).zip(self.taken(other.plan)).is_some_and(|(one, other)| one.edits == other.edits)
        };
        let is_made = |one: &&Keyed<'_>| is_own(one) || chosen.iter().any(|other| is_own(other) && is_same(one, other));
        let (made, left): (Vec<&Keyed<'_>>, Vec<&Keyed<'_>>) = chosen.iter().partition(is_made);
        let verb = if self.args.diff { "would migrate" } else { "migrated" };
        for Keyed { key, plan } in made.iter().copied() {
            self.console.say(&format!("{verb} {}", self.title(first, plan, self.going(plan))));
            let offered = self.offered.borrow();
            let Some(Offered { notes, changes }) = offered.get(key) else { continue };
            for note in notes {
                self.console.say(&format!("  {note}"));
            }
            for change in changes {
                self.console.say(&format!("  changed: {change}"));
            }
            self.tell_staying(first, plan);
        }
        for Keyed { key, plan } in left.iter().copied() {
            let is_of = |fix: &Fix| (&fix.file, &fix.title) == (&key.0, &key.1);
            let why = revision.refused.iter().find(|refused| is_of(&refused.fix));
            let other = self.other_law(plan, &made).map(|other| {
                let line = first.sources.line(other.head);
                let file = &first.sources.file(other.head.file).name;
                format!("guards run one law of a type, which is that of the loop at {file}:{line}: migrate this loop alone if it should be its own")
            });
            self.refuse(first, plan, why.map(|refused| refused.why.as_str()).or(other.as_deref()));
        }
        for fix in revision.made.iter().filter(|fix| fix.rule == fix::UNUSED_SUPPRESSION) {
            let verb = if self.args.diff { "would be" } else { "was" };
            self.console.say(&format!("{}: a suppression {verb} removed that hides nothing any more", fix.file));
        }
        for (file, line, Doubtful { name, is_conditional, .. }) in self.doubtful.borrow().iter() {
            let what = match is_conditional {
                true => {
                    "perhaps only code under `#[cfg(…)]` needs it now: remove the import, or put the same attribute above it"
                }
                false => "perhaps nothing needs it now: remove the import",
            };
            self.console.say(&format!("{file}:{line}: `{name}` is imported, and {what}"));
        }
        let manifests = revision.changes.iter().filter(|change| change.path.ends_with("Cargo.toml"));
        let owners: Vec<String> = manifests.filter_map(|change| directory(&change.path)).collect();
        if !owners.is_empty() && !self.args.diff {
            let of = if owners.len() > 1 { format!(" in {}", quoted(&owners)) } else { String::new() };
            self.console
                .say(&format!("`ceid-core` is a dependency{of} now; the next build brings `Cargo.lock` up to date"));
        }
        let total = made.len() + left.len() + unplanned;
        self.console.say(&format!("{verb} {} of {}", made.len(), count(total, "loop")));
        left.len()
    }

    /// The loop that gave a type another law for guards than this one would.
    fn other_law<'r>(&self, plan: &Plan, made: &[&Keyed<'r>]) -> Option<&'r Plan> {
        let own = self.taken(plan)?;
        let is_other = |rewrite: &Rewrite| {
            let mut laws = rewrite.laws.iter();
            laws.any(|(ty, law)| own.laws.iter().any(|(other, with)| other.may_be(ty) && with != law))
        };
        made.iter().map(|keyed| keyed.plan).find(|plan| self.taken(plan).is_some_and(is_other))
    }

    fn title(&self, report: &Report, plan: &Plan, filters: &[String]) -> String {
        let file = &report.sources.file(plan.head.file).name;
        format!("{file}:{}: {} in `{}`", report.sources.line(plan.head), quoted(filters), plan.function)
    }

    /// Tells why a loop stays as it is.
    fn refuse(&self, report: &Report, plan: &Plan, why: Option<&str>) {
        let title = self.title(report, plan, &plan.filters);
        let mut lines = vec![format!("{title}: not migrated")];
        match &plan.outcome {
            Err(reasons) => lines.extend(reasons.iter().map(|reason| told(report, plan, reason))),
            Ok(rewrite) => {
                if let Err(error) = self.edits(report, rewrite) {
                    lines.push(error);
                }
                lines.extend(why.map(str::to_owned));
                if !self.is_taken(rewrite) {
                    lines[0] +=
                        ", because the program would do something else (`--unsafe-fixes` migrates it all the same)";
                    lines.extend(rewrite.changes.iter().map(|change| told(report, plan, change)));
                }
                if lines.len() == 1 {
                    lines.push("its changes overlap with those of another loop: run it again".to_owned());
                }
            }
        }
        lines.dedup();
        self.console.warn(&lines.join("\n  "));
    }
}

/// The directory of a manifest.
fn directory(manifest: &Path) -> Option<String> {
    Some(manifest.parent()?.file_name()?.to_string_lossy().into_owned())
}

fn is_unused(finding: &&Diagnostic) -> bool {
    finding.rule == fix::UNUSED_SUPPRESSION
}

/// What a finding says, and of which file.
fn said<'r>(report: &'r Report, finding: &'r Diagnostic) -> (&'r str, &'r str) {
    (&report.sources.file(finding.primary.span.file).name, &finding.message)
}

const IDLE_IMPORT: &str = "an import removed that nothing needs any more, or left for the builds that need it";

/// The fixes that remove imports which nothing needs any more: those in touched files, and those that hand on what touched files had.
pub(super) fn idle(report: &Report, first: &Report, is_touched: impl Fn(&Path) -> bool) -> Vec<Fix> {
    let edits = |of: &[(Span, String)]| of.iter().map(|edit| edit_of(&report.sources, edit)).collect::<Vec<Edit>>();
    let fix = |edits: Vec<Edit>, at: Option<&(Span, String)>| {
        at.map(|(span, _)| fix_of(report, *span, IDLE_IMPORT.to_owned(), edits))
    };
    let removals = report.idle_imports.removals.iter().map(|import| (edits(import), import.first()));
    let own = removals.filter(|(edits, _)| edits.iter().any(|edit| is_touched(&edit.path)));
    // What was handed on for nothing before is none of it.
    let is_lost = |handed: &&HandedOn| {
        report.sources.files().filter(|(_, file)| is_touched(&file.path)).any(|(_, file)| {
            text_of(&first.sources, &file.path).is_some_and(|before| handed.is_said_less(before, &file.text))
        })
    };
    let handed = report.idle_imports.handed_on.iter().filter(is_lost);
    own.chain(handed.map(|handed| (edits(&handed.edits), handed.edits.first())))
        .filter_map(|(edits, at)| fix(edits, at))
        .collect()
}

fn fix_of(report: &Report, at: Span, title: String, edits: Vec<Edit>) -> Fix {
    let file = report.sources.file(at.file).name.clone();
    Fix { rule: "unguarded_update", title, file, line: report.sources.line(at), is_unsafe: false, edits }
}

fn edit_of(sources: &SourceMap, (span, text): &(Span, String)) -> Edit {
    let path = sources.file(span.file).path.clone();
    Edit { path, start: span.start as usize, end: span.end as usize, text: text.clone() }
}

/// A reason with its line, and its file if it is another one.
fn told(report: &Report, plan: &Plan, reason: &Reason) -> String {
    let line = report.sources.line(reason.span);
    if reason.span.file == plan.head.file {
        format!("line {line}: {}", reason.text)
    } else {
        format!("{}:{line}: {}", report.sources.file(reason.span.file).name, reason.text)
    }
}
