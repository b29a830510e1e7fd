//! What a guard is to hold: which places, whether it can, and what they are called in the body.

use std::collections::{BTreeMap, BTreeSet};

use super::Reason;
use super::adapt::{adaptation, lent};
use super::ambiguous::calls_that_go;
use super::body::LoopBody;
use super::each::each;
use super::elements::take_apart;
use super::exits::{ends_before, is_exact};
use super::iteration::listed;
use super::locks::{is_lock_guard, is_opened_alone, lock_of, locked};
use super::loops::Loops;
use super::mentions::{Guarded, held, is_about, is_about_owner};
use super::sites::{Part, Place, Site, place_of};
use super::text::{without_comments, words};
use crate::count::Pair;
use crate::index::{Def, FunctionId, Namespace, Ty};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, MacroKind, StmtKind};
use crate::types::LocalId;

/// A filter that the loop updates or owes an update, where it lies, and where it is updated.
pub(super) type Found<'p> = (&'p Pair, (Place, ExprId, Option<FunctionId>), Vec<Site>);

/// The places that the guard is to hold, in the order in which their laws run today.
pub(super) fn guarded(
    loops: &Loops<'_>,
    of: &LoopBody<'_>,
    mut found: Vec<Found<'_>>,
) -> Result<Vec<Guarded>, Vec<Reason>> {
    take_apart(of, &mut found);
    let mut reasons = Vec::new();
    let mut by_place: BTreeMap<Place, Guarded> = BTreeMap::new();
    for (pair, (place, at, law), sites) in found {
        if sites.iter().any(|site| site.place != place) {
            let names: BTreeSet<&str> = sites.iter().map(|site| of.written(site.receiver)).collect();
            let names = names.into_iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
            let text = format!(
                "`{}` is updated under several names ({names}): let each filter have one name in the loop, and move none to another",
                pair.name
            );
            reasons.push(Reason { span: of.span(at), text });
        }
        let ty = of.typed.ty(at).clone();
        let filter =
            sites.first().map(|site| site.filter.clone()).or_else(|| held(&ty).cloned()).unwrap_or(Ty::Unknown);
        let spelled = spelled(of, &place, at);
        let is_lock_guard = is_lock_guard(of, place.local);
        let own = Guarded {
            place: place.clone(),
            spelled,
            name: String::new(),
            at,
            ty,
            filter,
            law,
            sites: Vec::new(),
            adaptation: None,
            rare: BTreeSet::new(),
            locked: None,
            is_lock_guard,
            deviates: None,
        };
        let own = by_place.entry(place).or_insert(own);
        own.sites.extend(sites);
        if pair.counts.contains(&0) && !ends_before(of, pair) {
            own.rare.insert(pair.half);
        }
        if !is_exact(of, pair) {
            own.deviates = Some(pair.verdict);
        }
    }
    let mut guarded: Vec<Guarded> = by_place.into_values().collect();
    for own in &mut guarded {
        own.sites.sort_by_key(|site| of.span(site.call));
    }
    let overlap = guarded.iter().any(|one| {
        let is_above = |other: &Guarded| {
            one.place != other.place
                && (one.place.element.is_none() || one.place.fields != other.place.fields)
                && one.place.local == other.place.local
                && other.place.fields.starts_with(&one.place.fields)
        };
        guarded.iter().any(is_above)
    });
    if overlap {
        reasons.push(Reason { span: of.span(of.whole), text: "one filter of this loop holds another one".to_owned() });
    }
    reasons.extend(guarded.iter().find_map(|own| listed_beside(of, own, &guarded)));
    // Filters that are listed have one call.
    guarded.sort_by_key(|own| {
        (own.sites.first().map_or((true, of.span(own.at)), |site| (false, of.span(site.call))), of.span(own.at))
    });
    let mut taken = BTreeSet::new();
    let alike = alike(of, &guarded);
    let gone = calls_that_go(&guarded);
    for own in &mut guarded {
        match free_name(of, own, &(&taken | &alike)).or_else(|| free_name(of, own, &taken)) {
            Some(name) => {
                taken.insert(name.clone());
                own.name = name;
                own.locked = lock_of(of, &own.place).filter(|_| own.ty != own.filter);
                match holds(of, own).map(|()| adaptation(loops, of, own, &gone)) {
                    Ok(Ok(adaptation)) => own.adaptation = adaptation,
                    Ok(Err(reason)) => reasons.push(reason),
                    Err(text) => reasons.push(Reason { span: of.span(own.at), text }),
                }
            }
            None => reasons.push(Reason {
                span: of.span(own.at),
                text: format!("every short name for `{}` means something else in this loop", own.spelled),
            }),
        }
    }
    if let Some(own) = guarded.iter().find(|own| own.locked.is_some())
        && (guarded.len() > 1 || own.adaptation.is_some())
    {
        let (place, lock) = match of.is_function {
            true => ("function", "let the function take what the lock gives"),
            false => ("loop", "lock it above the loop"),
        };
        let text = format!(
            "`{}` is locked in the {place}, where a guard can hold only what is locked before it: {lock}, or let its law take no \
             input and guard it alone",
            own.name
        );
        reasons.push(Reason { span: of.span(own.at), text });
    }
    if guarded.len() > 16 {
        let text = "the loop has more than 16 filters: declare them with `filters!`".to_owned();
        reasons.push(Reason { span: of.span(of.whole), text });
    }
    // The elements of an array have the same reason.
    reasons.dedup();
    if reasons.is_empty() { Ok(guarded) } else { Err(reasons) }
}

/// Why the inner loop that updates a filter cannot go: it lists another one, which no guard gets.
fn listed_beside(of: &LoopBody<'_>, own: &Guarded, guarded: &[Guarded]) -> Option<Reason> {
    let lists = own.sites.iter().filter_map(|site| listed(of, site.inner?));
    let is_left = |at: &ExprId| !guarded.iter().any(|own| Some(&own.place) == place_of(of, *at).as_ref());
    let at = lists.flatten().find(is_left)?;
    let text = format!(
        "`{}` is updated in the same inner loop as `{}`, and a guard cannot have it: update each by its own name",
        of.written(at),
        own.spelled
    );
    Some(Reason { span: of.span(at), text })
}

fn spelled(of: &LoopBody<'_>, place: &Place, at: ExprId) -> String {
    let base = std::iter::once(of.typed.local(place.local).name.as_str());
    let base = base.chain(place.fields.iter().map(String::as_str));
    let base = base.map(|name| if is_raw(of, at, name) { format!("r#{name}") } else { name.to_owned() });
    let base = base.collect::<Vec<_>>().join(".");
    place.element.map_or(base.clone(), |element| format!("{base}[{element}]"))
}

/// Whether a name is written `r#name` in an expression.
fn is_raw(of: &LoopBody<'_>, at: ExprId, name: &str) -> bool {
    let written = of.written(at);
    words(written, name).any(|at| written[..at].ends_with("r#"))
}

/// Whether a guard can hold what lies at a place, and whether that is what the loop updates.
fn holds(of: &LoopBody<'_>, own: &Guarded) -> Result<(), String> {
    let Guarded { place, spelled, ty, sites, filter, .. } = own;
    let local = of.typed.local(place.local);
    if own.locked.is_none() && local.span.start > of.span(of.whole).start {
        return Err(match lent_below_the_head(of, own) {
            Some((statement, true)) if !of.is_function && !place.fields.is_empty() => format!(
                "`{spelled}` lies in what {statement} locks in each iteration, where a guard can hold only all of it: if nothing \
                 else locks it meanwhile, put that above the loop, and `let {name} = &mut *{name};` below it",
                name = local.name
            ),
            Some((statement, _)) if of.is_function => format!(
                "`{spelled}` has its name only below the head of the function, where a guard has to hold it already: let the function \
                 take what {statement} gives"
            ),
            Some((statement, is_lock)) => format!(
                "`{spelled}` has its name only below the head of the loop, where a guard has to hold it already: put {statement} above \
                 the loop{}",
                if is_lock { ", if nothing else locks it meanwhile" } else { "" }
            ),
            None if is_in_a_list(of, local.span) => {
                format!("a guard has `{spelled}` in its list, and runs its law: delete the call")
            }
            None => {
                let what = if of.is_function { "function" } else { "loop" };
                match own.is_lock_guard || matches!(local.ty, Ty::Ref(..)) {
                    true => format!(
                        "`{spelled}` has its name only below the head of the {what}, where a guard has to hold it already: write \
                         the guard by hand, below what binds that name"
                    ),
                    false => format!(
                        "`{spelled}` is bound in the {what} itself, so that it means no instance that lives outside of it"
                    ),
                }
            }
        });
    }
    if local.by_ref && !matches!(local.ty, Ty::Ref(..)) {
        return Err(format!("`{spelled}` is bound by `ref`, and it is not known whether it may be changed"));
    }
    if place.fields.is_empty() && local.name == "self" {
        return Err("the filter is `self`: guard it where the loop is called, or make it a field".to_owned());
    }
    let is_another = |site: &Site| {
        let first = sites.iter().find(|other| other.half == site.half);
        site.filter != *filter || first.is_some_and(|first| first.law != site.law || first.method != site.method)
    };
    if sites.iter().any(is_another) {
        let methods: BTreeSet<String> = sites.iter().map(|site| format!("`{}`", site.method)).collect();
        let methods = methods.into_iter().collect::<Vec<_>>().join(", ");
        return Err(format!(
            "`{spelled}` is updated in several ways ({methods}), and a guard runs one law: make one method of those that exclude each other"
        ));
    }
    let is_single = sites.iter().all(|site| site.part == Part::Whole) && (lent(own).is_some() || own.locked.is_some());
    if !own.is_held() && !is_single && each(of, own).is_none() {
        return Err(match filter {
            Ty::Param(_) | Ty::Opaque(_) => format!(
                "only the trait of `{spelled}` is known, and not its type: let that trait be ceid-core's `SampledFilter`, which \
                 references, boxes and slices of filters have as well"
            ),
            _ => out_of_reach(of, own),
        });
    }
    // The fields on the way have to be plain ones, so that each is borrowed by itself.
    let mut at = own.at;
    if let (Some(_), ExprKind::Index { base, .. }) = (place.element, of.kind(at)) {
        at = *base;
    }
    while let ExprKind::Field { base, name: field } = of.kind(at) {
        let owner = of.typed.ty(*base);
        let mut owner = owner;
        while let Ty::Ref(true, inner) = owner {
            owner = inner;
        }
        let owner = match owner {
            // What lies in a box is borrowed as what lies in a variable.
            Ty::External(path, args) if path == "std::boxed::Box" => args.first().unwrap_or(owner),
            other => other,
        };
        if matches!(owner, Ty::Ref(false, _)) {
            return Err(format!(
                "`{}` is a shared reference, and a guard changes what it holds: let the function take it by `&mut`",
                of.written(*base)
            ));
        }
        if !matches!(owner, Ty::Adt(..) | Ty::Tuple(_)) {
            let advice = lending(of, *base);
            return Err(format!(
                "`{}` does not lend its fields one by one: put {advice} above the loop",
                of.written(*base)
            ));
        }
        if own.is_lock_guard && is_used_beside(of, place) {
            let name = &local.name;
            return Err(format!(
                "`{name}` is the guard of a lock, which does not lend its fields one by one: put `let {name} = &mut *{name};` above the loop"
            ));
        }
        let has_it = |owner: &Ty| of.program.index.field_ty(owner, None, field).is_some();
        if matches!(owner, Ty::Adt(..)) && !has_it(owner) {
            let written = of.written(*base);
            return Err(format!(
                "`{field}` is no field of `{written}` itself, but of what its `Deref` leads to, which lends all of `{written}` with \
                 it: name it by the fields that lead there"
            ));
        }
        at = *base;
    }
    let is_collection = !is_single && held(ty).is_some_and(|inner| !matches!(ty, Ty::Adt(..)) && !is_ref_to(ty, inner));
    let elements: Vec<u64> =
        sites.iter().filter_map(|site| if let Part::Element(at) = site.part { Some(at) } else { None }).collect();
    let all = sites.iter().filter(|site| site.part == Part::All).count();
    let whole = sites.iter().filter(|site| site.part == Part::Whole).count();
    let paired = sites.iter().any(|site| site.part == Part::Paired);
    let length = match ty {
        Ty::Array(_, length) => length.value,
        Ty::Ref(_, inner) => match &**inner {
            Ty::Array(_, length) => length.value,
            _ => None,
        },
        _ => None,
    };
    let distinct: BTreeSet<u64> = elements.iter().copied().collect();
    let is_each_fed = each(of, own).is_some() && sites.iter().all(|site| !site.inputs.is_empty());
    let is_covered = is_each_fed
        || match (elements.len(), all, whole) {
            _ if paired => false,
            (0, 0, 0) => true,
            (0, 1.., 0) => is_collection,
            (_, 0, 0) => is_collection && length == Some(distinct.len() as u64),
            (0, 0, _) => !is_collection,
            _ => false,
        };
    if is_covered {
        return Ok(());
    }
    Err(if paired {
        format!(
            "the elements of `{spelled}` are updated as far as what they are paired with goes, and a guard updates all"
        )
    } else {
        format!("not every element of `{spelled}` is updated here, and a guard updates all")
    })
}

/// Why a guard does not get to the filter that lies at a place, and how it would.
pub(super) fn out_of_reach(of: &LoopBody<'_>, own: &Guarded) -> String {
    let spelled = &own.spelled;
    // A guard reaches through a `&mut`.
    let ty = if let Ty::Ref(true, inner) = &own.ty { inner } else { &own.ty };
    match ty {
        Ty::Ref(false, _) => {
            return format!(
                "`{spelled}` is a shared reference, and a guard changes what it holds: let the function take it by `&mut`"
            );
        }
        Ty::External(path, args) => {
            let name = path.rsplit("::").next().unwrap_or(path);
            let place = if of.is_function { "first" } else { "above the loop" };
            let advice = match name {
                "Rc" | "Arc" => "let one variable or field own the filter".to_owned(),
                "Vec" if matches!(args.first(), Some(Ty::Ref(..))) => "let it hold the filters themselves".to_owned(),
                "VecDeque" => {
                    let slice = of.written(own.at);
                    let short = slice.rsplit('.').next().unwrap_or(slice);
                    format!("put `let {short} = {slice}.make_contiguous();` {place}, and update it by that name")
                }
                "BTreeMap" | "BTreeSet" | "BinaryHeap" | "HashMap" | "HashSet" | "LinkedList" | "Option" => {
                    "keep the filters in variables or fields of their own, or in an array or a `Vec`".to_owned()
                }
                _ => format!(
                    "put {} {place}, if that is a filter or a slice of them, and update it by that name",
                    lending(of, own.at)
                ),
            };
            return format!("`{spelled}` is a `{name}`, through which a guard does not reach: {advice}");
        }
        _ => {}
    }
    format!(
        "`{spelled}` holds its filter in a way that a guard cannot reach through: keep it in a variable or field of its own type"
    )
}

/// Whether the loop, its head included, names the variable that a place begins with for something else than what lies there.
fn is_used_beside(of: &LoopBody<'_>, place: &Place) -> bool {
    let names = |id: &ExprId| of.typed.expr_local.get(id) == Some(&place.local);
    let is_own = |id: ExprId| is_about(of, place, id) && !is_about_owner(of, place, id);
    of.body.within(of.loop_statement()).filter(names).any(|id| !is_own(id))
}

/// The statement by which a pointer is a reference whose fields are lent one by one.
fn lending(of: &LoopBody<'_>, base: ExprId) -> String {
    let written = of.written(base);
    let name = written.rsplit('.').next().unwrap_or(written);
    let mut inner = of.typed.ty(base);
    let mut stars = String::new();
    while let Ty::Ref(_, behind) = inner {
        stars.push('*');
        inner = behind;
    }
    match inner {
        // A name of its own: `self` cannot be bound.
        Ty::External(path, _) if path.ends_with("::Pin") => {
            let name = if name == "self" { "this" } else { name };
            format!("`let {name} = {written}.as_mut().get_mut();`")
        }
        Ty::External(..) => format!("`let {name} = &mut *{stars}{written};`"),
        _ => format!("`let {name} = &mut {stars}{written};`"),
    }
}

/// The statement of the loop that gives a part of what lives outside of it its name, by a reference.
/// Whether that locks it, as well.
fn lent_below_the_head(of: &LoopBody<'_>, own: &Guarded) -> Option<(String, bool)> {
    let local = of.typed.local(own.place.local);
    let blocks =
        of.inside.iter().filter_map(|id| if let ExprKind::Block(block) = of.kind(*id) { Some(block) } else { None });
    let (stmt, init) = blocks.flat_map(|block| &block.stmts).find_map(|stmt| match &stmt.kind {
        StmtKind::Let { pat, init: Some(init), .. } if of.body.pat(*pat).span.contains(local.span) => {
            Some((stmt, *init))
        }
        _ => None,
    })?;
    let mut root = locked(of, init).unwrap_or(init);
    loop {
        root = match of.kind(root) {
            ExprKind::Reference { value: inner, .. }
            | ExprKind::Field { base: inner, .. }
            | ExprKind::Index { base: inner, .. }
            | ExprKind::Deref(inner)
            | ExprKind::Try(inner) => *inner,
            ExprKind::MethodCall { receiver, method, .. } if is_lending(method) => *receiver,
            _ => break,
        };
    }
    let is_lock = own.is_lock_guard;
    let is_outside = |local: &LocalId| of.typed.local(*local).span.start < of.span(of.whole).start;
    let is_lent = matches!(of.typed.ty(init), Ty::Ref(true, _)) || local.by_ref || is_opened_alone(of, init);
    let written = of.program.sources.snippet(stmt.span);
    let statement = if written.contains('\n') { "the `let` that binds it".to_owned() } else { format!("`{written}`") };
    let is_outside = of.typed.expr_local.get(&root).is_some_and(is_outside);
    ((is_lent || is_lock) && is_outside).then_some((statement, is_lock))
}

/// Whether a variable gets its name in the list of a guard.
fn is_in_a_list(of: &LoopBody<'_>, at: Span) -> bool {
    let is_guard =
        |id: &ExprId| matches!(of.kind(*id), ExprKind::Macro(call) if matches!(call.kind, MacroKind::Ceid { .. }));
    of.inside.iter().any(|id| of.span(*id).contains(at) && is_guard(id))
}

/// Methods that give a reference to what their receiver holds.
fn is_lending(method: &str) -> bool {
    matches!(
        method,
        "as_mut"
            | "as_deref_mut"
            | "get_mut"
            | "first_mut"
            | "last_mut"
            | "unwrap"
            | "expect"
            | "ok"
            | "lock"
            | "write"
            | "borrow_mut"
    )
}

fn is_ref_to(ty: &Ty, inner: &Ty) -> bool {
    match ty {
        Ty::Ref(_, own) => **own == *inner,
        _ => false,
    }
}

/// The short names that several places would have: all of these get longer ones, `roll_pid` and `pitch_pid`.
fn alike(of: &LoopBody<'_>, guarded: &[Guarded]) -> BTreeSet<String> {
    let mut alike = BTreeSet::new();
    loop {
        let mut names: Vec<String> = guarded.iter().filter_map(|own| free_name(of, own, &alike)).collect();
        names.sort();
        let twice: Vec<String> = names.windows(2).filter(|two| two[0] == two[1]).map(|two| two[0].clone()).collect();
        if twice.is_empty() {
            return alike;
        }
        alike.extend(twice);
    }
}

/// A name for a place that means nothing else in the loop.
fn free_name(of: &LoopBody<'_>, own: &Guarded, taken: &BTreeSet<String>) -> Option<String> {
    let place = &own.place;
    let local = &of.typed.local(place.local).name;
    let is_variable = place.fields.is_empty() && place.element.is_none();
    if is_variable && !is_raw(of, own.at, local) {
        return (!taken.contains(local)).then(|| local.clone());
    }
    let element = place.element.map(|element| element.to_string());
    let all: Vec<&str> = std::iter::once(local.as_str())
        .chain(place.fields.iter().map(String::as_str))
        .chain(element.as_deref())
        .collect();
    let code = without_comments(of.program.sources.snippet(of.span(of.block)));
    let is_name = |name: &str| name.starts_with(|first: char| first.is_alphabetic() || first == '_');
    let is_free = |name: &str| {
        is_name(name)
            && !is_raw(of, own.at, name)
            && !taken.contains(name)
            && !of.typed.locals.iter().any(|local| local.name == name)
            && !is_value(of, name)
            && words(&code, name).all(|at| code[..at].trim_end().ends_with('.'))
    };
    (1..=all.len())
        .rev()
        .map(|from| all[from - 1..].join("_"))
        .map(|name| name.replace("self_", "own_"))
        .chain(is_variable.then(|| format!("own_{local}")))
        .find(|name| is_free(name))
}

/// Whether a name is that of a static, a constant, or a unit that the module has, which no variable can have.
pub(super) fn is_value(of: &LoopBody<'_>, name: &str) -> bool {
    let index = of.program.index;
    let found = index.resolve(of.def().module, &[name.to_owned()], Namespace::Value);
    matches!(found, Some(Def::Value(_) | Def::Variant(..) | Def::Type(_)))
}
