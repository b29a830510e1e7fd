//! Methods of the standard library's own types, which go before those of the same name that a trait of the code gives them.

/// Whether a type of the standard library has a method of its own that takes `self` as it is or by reference, so that no method of a
/// trait is meant: a trait of buffers may have an `extend_from_slice` for `Vec<u8>`.
pub(super) fn has_own(path: &str, method: &str) -> bool {
    let own: &[&str] = match path {
        "std::vec::Vec" => &[
            "append",
            "capacity",
            "clear",
            "dedup",
            "drain",
            "extend_from_slice",
            "extend_from_within",
            "insert",
            "is_empty",
            "len",
            "pop",
            "push",
            "remove",
            "reserve",
            "resize",
            "resize_with",
            "retain",
            "retain_mut",
            "split_off",
            "swap_remove",
            "truncate",
        ],
        "std::collections::VecDeque" => &[
            "append",
            "back",
            "back_mut",
            "clear",
            "drain",
            "front",
            "front_mut",
            "get",
            "get_mut",
            "insert",
            "is_empty",
            "iter",
            "iter_mut",
            "len",
            "make_contiguous",
            "pop_back",
            "pop_front",
            "push_back",
            "push_front",
            "remove",
            "resize",
            "retain",
            "rotate_left",
            "rotate_right",
            "split_off",
            "swap",
            "truncate",
        ],
        "std::string::String" => {
            &["clear", "insert", "is_empty", "len", "pop", "push", "push_str", "remove", "truncate"]
        }
        _ => &[],
    };
    own.contains(&method)
}
