//! What is known not to panic, for those who go on where code has panicked: whatever is not known may.

use super::locks::lock_behind;
use super::owned::is_fixed_algebra;
use super::purity::is_open;
use super::signs::Code;
use crate::index::{FunctionId, TraitName, Ty, primitive};
use crate::syntax::tree::{BlockKind, ExprId, ExprKind};
use crate::types::{Callee, is_pointer};

/// Methods of numbers, which no other type of the standard library has with another meaning.
const OF_NUMBERS: &str = "\
    abs abs_diff unsigned_abs sqrt cbrt powi powf pow exp exp2 exp_m1 ln ln_1p log log2 log10 sin cos tan asin acos atan atan2 \
    sin_cos sinh cosh tanh asinh acosh atanh hypot floor ceil round round_ties_even trunc fract signum copysign recip mul_add \
    to_radians to_degrees to_bits midpoint next_power_of_two swap_bytes reverse_bits total_cmp to_le_bytes to_be_bytes to_ne_bytes \
    is_nan is_finite is_infinite is_normal is_subnormal is_sign_negative is_sign_positive is_positive is_negative \
    is_power_of_two count_ones count_zeros leading_zeros leading_ones trailing_zeros trailing_ones";

/// Methods of values of all kinds.
const OF_ALL: &str = "\
    clone clone_from into try_into to_string to_owned eq ne lt le gt ge cmp partial_cmp max min fmt hash as_ref as_mut \
    type_id into_iter";

/// Methods of `Option`, `Result` and `Ordering`.
const OF_CHOICES: &str = "\
    is_some is_none is_ok is_err is_some_and is_none_or is_ok_and is_err_and as_deref as_deref_mut map and and_then or or_else xor \
    unwrap_or unwrap_or_else unwrap_or_default ok err ok_or ok_or_else take replace take_if get_or_insert get_or_insert_with filter \
    flatten zip unzip cloned copied map_or map_or_else map_or_default map_err inspect inspect_err transpose iter iter_mut insert reverse \
    then then_with then_some is_eq is_ne is_lt is_gt is_le is_ge";

/// Methods of slices, collections and texts.
const OF_COLLECTIONS: &str = "\
    len is_empty first last first_mut last_mut get get_mut push push_back push_front pop pop_back pop_front pop_first pop_last front back \
    front_mut back_mut contains contains_key starts_with ends_with extend extend_from_slice append clear retain retain_mut fill fill_with \
    concat join to_vec into_vec into_boxed_slice as_slice as_mut_slice as_slices make_contiguous split_first split_last first_chunk \
    last_chunk split_first_chunk split_last_chunk split_at_checked binary_search binary_search_by binary_search_by_key partition_point \
    sort sort_unstable sort_by_key sort_unstable_by_key sort_by_cached_key is_sorted dedup dedup_by_key dedup_by capacity shrink_to_fit \
    insert remove get_key_value entry or_insert or_insert_with or_default and_modify key keys values values_mut into_keys into_values \
    first_key_value last_key_value union intersection difference is_subset is_superset is_disjoint peek peek_mut into_sorted_vec \
    as_str as_bytes as_mut_str chars char_indices bytes trim trim_start trim_end trim_matches trim_start_matches trim_end_matches split \
    split_whitespace split_ascii_whitespace split_terminator splitn rsplit rsplitn lines parse push_str to_lowercase to_uppercase \
    to_ascii_lowercase to_ascii_uppercase make_ascii_lowercase make_ascii_uppercase eq_ignore_ascii_case strip_prefix strip_suffix find \
    rfind split_once rsplit_once matches match_indices is_char_boundary is_alphabetic is_numeric is_alphanumeric is_whitespace \
    is_uppercase is_lowercase is_control is_ascii is_ascii_digit is_ascii_alphabetic is_ascii_alphanumeric is_ascii_hexdigit \
    is_ascii_whitespace is_ascii_uppercase is_ascii_lowercase is_ascii_punctuation is_ascii_graphic is_ascii_control len_utf8 into_bytes \
    into_string each_ref each_mut as_array";

/// Methods of iterators.
const OF_ITERATORS: &str = "\
    next next_back nth nth_back last count map filter filter_map flat_map flatten enumerate zip rev take skip chain cycle take_while \
    skip_while map_while scan inspect fuse peekable peek next_if next_if_eq by_ref fold rfold try_fold reduce all any find find_map rfind \
    position rposition min_by max_by min_by_key max_by_key sum product partition collect for_each try_for_each copied cloned unzip \
    is_sorted_by size_hint start end is_empty";

/// Methods of cells, locks, channels, clocks and what is written to.
const OF_OTHERS: &str = "\
    set get take replace update into_inner get_mut get_or_init as_ptr as_mut_ptr lock try_lock read write try_read try_write is_poisoned \
    try_borrow try_borrow_mut load store fetch_add fetch_sub fetch_and fetch_or fetch_xor fetch_max fetch_min compare_exchange \
    compare_exchange_weak send recv try_send try_recv recv_timeout try_iter upgrade with with_borrow with_borrow_mut \
    as_secs as_secs_f32 as_secs_f64 as_millis as_micros as_nanos subsec_millis subsec_micros subsec_nanos is_zero elapsed duration_since \
    flush write_all write_str write_fmt read_line read_to_string is_finished deref deref_mut borrow notify_one notify_all is_null";

/// Functions of the standard library.
const FUNCTIONS: &str = "\
    new default from try_from from_iter from_bits from_le_bytes from_be_bytes from_ne_bytes from_millis from_secs from_micros from_nanos \
    try_from_secs_f32 try_from_secs_f64 from_utf8 from_utf8_lossy from_fn from_ref from_mut from_u32 swap replace take min max sleep once \
    once_with repeat repeat_n repeat_with empty successors zip drop forget black_box size_of size_of_val align_of type_name stdout stdin \
    stderr identity spin_loop yield_now fence compiler_fence exit ptr_eq strong_count weak_count downgrade now";

/// Whether a name stands in a list.
fn is_in(names: &str, name: &str) -> bool {
    names.split_whitespace().any(|own| own == name)
}

/// Whether an expression may panic by itself, as far as it is not known that it does not.
pub(super) fn may_fail(code: &Code<'_>, id: ExprId) -> bool {
    let Code { body, typed, .. } = code;
    match &body.expr(id).kind {
        ExprKind::Opaque(_) | ExprKind::Unknown { .. } => true,
        ExprKind::Await(inner) => match &body.expr(*inner).kind {
            ExprKind::Block(block) => block.kind != BlockKind::Async,
            // A function whose code is not read is one that may fail where it is called.
            kind => !matches!(kind, ExprKind::Call { .. } | ExprKind::MethodCall { .. }),
        },
        ExprKind::Repeat { len, is_vec: true, .. } => !code.is_length(*len),
        ExprKind::Binary { op, lhs, rhs } | ExprKind::AssignOp { op, place: lhs, value: rhs } => {
            code.may_operator_fail(op, *lhs, *rhs)
        }
        ExprKind::Call { callee, args } => match typed.callees.get(&id) {
            // What a closure runs is looked at where it stands, or where its name does.
            Some(Callee::Constructor(_) | Callee::Closure(_)) => false,
            Some(Callee::Resolved(resolved)) => code.is_unread(&resolved.targets),
            Some(Callee::External(path)) => !code.is_calm_function(path, args),
            Some(Callee::Builtin | Callee::Unknown) => {
                let ExprKind::Path(path) = &body.expr(*callee).kind else { return true };
                match path.segments.as_slice() {
                    _ if typed.expr_local.contains_key(callee) => true,
                    [owner, name] if primitive(&owner.name).is_some() => {
                        !code.is_calm_function(&format!("{}::{}", owner.name, name.name), args)
                    }
                    // A method that is called by the path of its trait or type.
                    [.., _, name] => {
                        !args.split_first().is_some_and(|(first, rest)| code.is_calm_method(*first, &name.name, rest))
                    }
                    _ => true,
                }
            }
            _ => true,
        },
        ExprKind::MethodCall { receiver, method, args, .. } => match typed.callees.get(&id) {
            Some(Callee::Resolved(resolved)) => code.is_unread(&resolved.targets),
            Some(Callee::External(path)) if path.starts_with("ceid_core::") => false,
            _ => !code.is_calm_method(*receiver, method, args),
        },
        _ => false,
    }
}

impl Code<'_> {
    fn is_unread(&self, targets: &[FunctionId]) -> bool {
        let index = self.loops.program.index;
        !targets.iter().any(|target| index.function(*target).function.body.is_some())
    }

    /// Whether arithmetic may panic in a release build, beside what is divided by zero and what goes below it. Operators of the
    /// analysed code are read as code.
    fn may_operator_fail(&self, op: &str, lhs: ExprId, rhs: ExprId) -> bool {
        let is_division = matches!(op, "/" | "%");
        if !(is_division || matches!(op, "+" | "-" | "*")) {
            return false;
        }
        let is_number = |id: ExprId| self.number(id).is_some_and(|number| number != 0.0);
        let is_float = |id: ExprId| matches!(self.typed.ty(id).peel(), Ty::Float);
        match self.typed.ty(lhs).peel() {
            Ty::External(path, _) => match (path.as_str(), op) {
                ("std::string::String", _) => false,
                // How long it takes until a time overflows, no program runs.
                ("std::time::Duration" | "std::time::Instant" | "std::time::SystemTime", "+") => false,
                ("std::time::Duration", "*" | "/") => !is_number(rhs),
                // Below zero, what is known of it says more.
                ("std::time::Duration", "-") => false,
                ("std::time::Instant", "-") => {
                    !matches!(self.typed.ty(rhs).peel(), Ty::External(path, _) if path == "std::time::Instant")
                }
                _ => !is_of_calm_crate(path) && (is_division || !path.starts_with("std::num::")),
            },
            ty @ (Ty::Param(_) | Ty::Opaque(_)) => is_open(ty),
            Ty::Unknown | Ty::Var(_) => {
                (is_division || op == "-") && !is_float(rhs) && !(is_division && is_number(rhs))
            }
            _ => false,
        }
    }

    fn is_calm_function(&self, path: &str, args: &[ExprId]) -> bool {
        if path.starts_with("ceid_core::") || is_of_calm_crate(path) {
            return true;
        }
        let mut segments = path.rsplit("::");
        let (name, owner) = (segments.next().unwrap_or_default(), segments.next().unwrap_or_default());
        let is_std = path.starts_with("std::") || primitive(owner).is_some();
        let all_numbers = || args.iter().all(|arg| self.number(*arg).is_some());
        match (owner, name) {
            // What is derived for a type of the analysed code has no code there.
            _ if !is_std => segments.next().is_none() && (name == "default" || is_in(OF_ALL, name)),
            ("Duration", "new") => all_numbers(),
            ("Duration", "from_secs_f32" | "from_secs_f64") => {
                args.iter().all(|arg| self.number(*arg).is_some_and(|number| number >= 0.0))
            }
            ("RefCell", _) => name == "new",
            (_, "with_capacity") => args.first().is_some_and(|length| self.is_length(*length)),
            (_, "from_str_radix" | "from_digit") => args.last().is_some_and(|radix| self.is_radix(*radix)),
            _ if is_in(FUNCTIONS, name) => true,
            _ => args.split_first().is_some_and(|(first, rest)| self.is_calm_method(*first, name, rest)),
        }
    }

    fn is_calm_method(&self, receiver: ExprId, method: &str, args: &[ExprId]) -> bool {
        let index = self.loops.program.index;
        let ty = behind_pointers(self.typed.ty(receiver));
        let is_of_number = || is_in(OF_NUMBERS, method) || is_on_all_numbers(method);
        match ty {
            Ty::Unknown | Ty::Var(_) => return is_of_number(),
            Ty::Param(_) | Ty::Opaque(_) if is_open(ty) => return false,
            Ty::Adt(..) => {
                let iterator = TraitName::External("std::iter::Iterator".to_owned());
                let is_iterator = is_in(OF_ITERATORS, method) && index.implements(ty, &iterator);
                return is_in(OF_ALL, method) || is_iterator;
            }
            Ty::External(path, _) if path.starts_with("ceid_core::") || is_of_calm_crate(path) => return true,
            Ty::External(path, _) if !path.starts_with("std::") && !path.starts_with("heapless::") => return false,
            _ => {}
        }
        // A cell that is borrowed refuses whatever else is done with it.
        if lock_behind(ty) == Some("RefCell") {
            let asks_first = method.starts_with("try_") || matches!(method, "get_mut" | "into_inner" | "as_ptr");
            // What is borrowed is looked at where all panics of the language are.
            return asks_first || matches!(method, "borrow" | "borrow_mut") && args.is_empty();
        }
        let is_int = *ty == Ty::Int;
        // Of these, what is asked for by its number has to be there.
        let is_sequence = matches!(ty, Ty::Array(..) | Ty::Slice(_))
            || ty.external_name().is_some_and(|name| matches!(name, "Vec" | "VecDeque" | "Deque" | "String"));
        let first = || args.first().copied();
        let is_counted = || first().is_some_and(|number| self.constant(number).is_some_and(|number| number != 0));
        match method {
            _ if is_on_all_numbers(method) => true,
            _ if method.contains("div") || method.contains("rem_euclid") || method == "next_multiple_of" => {
                *ty == Ty::Float || is_counted()
            }
            "wrapping_rem" | "overflowing_rem" => is_counted(),
            "chunks" | "chunks_mut" | "chunks_exact" | "chunks_exact_mut" | "rchunks" | "rchunks_mut" | "windows"
            | "step_by" => is_counted(),
            "to_digit" | "is_digit" => first().is_some_and(|radix| self.is_radix(radix)),
            "rotate_left" | "rotate_right" => {
                is_int
                    || matches!(ty, Ty::Array(_, length) if first().and_then(|by| self.constant(by))
                    .zip(length.value).is_some_and(|(by, length)| by <= length))
            }
            "reserve" | "reserve_exact" | "resize" | "resize_with" | "repeat" => {
                first().is_some_and(|length| self.is_length(length))
            }
            "drain" => first().is_none_or(|range| {
                matches!(self.body.expr(range).kind, ExprKind::Range { start: None, end: None, .. })
            }),
            "truncate" => ty.external_name().is_some_and(|name| matches!(name, "Vec" | "VecDeque")),
            "sort_by" | "sort_unstable_by" => first().is_some_and(|order| self.is_total(order)),
            "swap" => !is_sequence,
            "insert" | "remove" => !is_sequence && *ty != Ty::Str,
            // Which bounds are in order is looked at where the panics are that somebody sees.
            "clamp" => args.len() == 2,
            _ => [OF_NUMBERS, OF_ALL, OF_CHOICES, OF_COLLECTIONS, OF_ITERATORS, OF_OTHERS]
                .iter()
                .any(|names| is_in(names, method)),
        }
    }

    /// Whether there is room for so many elements: a number that is written, or how many there are of others.
    fn is_length(&self, id: ExprId) -> bool {
        let is_asked = matches!(&self.body.expr(id).kind, ExprKind::MethodCall { method, args, .. }
            if args.is_empty() && matches!(method.as_str(), "len" | "capacity" | "count"));
        is_asked || self.constant(id).is_some()
    }

    fn is_radix(&self, id: ExprId) -> bool {
        self.constant(id).is_some_and(|radix| (2..=36).contains(&radix))
    }

    /// Whether a closure orders all values there are: a sort may panic where that is not so.
    fn is_total(&self, order: ExprId) -> bool {
        let calls = |name: &str| {
            let is_it =
                |id: ExprId| matches!(&self.body.expr(id).kind, ExprKind::MethodCall { method, .. } if method == name);
            self.body.within(order).any(is_it)
        };
        !calls("partial_cmp") && (calls("total_cmp") || calls("cmp"))
    }
}

/// The type behind references, boxes, handles and the guards of locks.
fn behind_pointers(ty: &Ty) -> &Ty {
    match ty.peel() {
        Ty::External(path, args) if is_pointer(path.rsplit("::").next().unwrap_or_default()) => {
            args.first().map_or(ty, behind_pointers)
        }
        peeled => peeled,
    }
}

/// Whether a method is one of numbers that answers for each of them: what it would be divided by is checked, or there is nothing.
fn is_on_all_numbers(method: &str) -> bool {
    let divides = ["div", "rem"].iter().any(|word| method.contains(word));
    method.starts_with("checked_")
        || ["saturating_", "wrapping_", "overflowing_"].iter().any(|prefix| method.starts_with(prefix)) && !divides
}

/// Crates of numbers and of vectors of a fixed size, which answer whatever they are given.
fn is_of_calm_crate(path: &str) -> bool {
    let mut segments = path.split("::");
    let krate = segments.next().unwrap_or_default();
    matches!(
        krate,
        "libm" | "micromath" | "num_traits" | "num_complex" | "half" | "ordered_float" | "uom" | "typenum" | "glam"
    ) || krate == "nalgebra" && segments.any(is_fixed_algebra)
}
