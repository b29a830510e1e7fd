//! What a generated statement may name, and where it may jump to.

/// A place that holds a filter.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// As the receiver of a method: `a`, `self.b`, `fs[0]`.
    pub(super) spelled: String,
    /// Whether it is a reference already, so that it is passed on as it is.
    pub(super) is_reference: bool,
    /// What is borrowed as a whole when this place is: `fs` for `fs[0]`.
    pub(super) root: String,
    /// The number it is built with; `None` when it may be one of several.
    pub(super) filter: Option<usize>,
    /// Whether only its update law is known.
    pub(super) is_abstract: bool,
}

impl Place {
    /// A reference variable.
    pub(super) fn reference(name: &str) -> Self {
        Self { spelled: name.into(), is_reference: true, root: name.into(), filter: None, is_abstract: false }
    }

    /// A local, a field, or an element.
    pub(super) fn owned(spelled: &str, root: &str, filter: usize) -> Self {
        Self {
            spelled: spelled.into(),
            is_reference: false,
            root: root.into(),
            filter: Some(filter),
            is_abstract: false,
        }
    }

    /// The place as an argument.
    pub(super) fn borrowed(&self) -> String {
        if self.is_reference { self.spelled.clone() } else { format!("&mut {}", self.spelled) }
    }

    /// The place as the value of a variable, which must not move a reference.
    pub(super) fn reborrowed(&self) -> String {
        if self.is_reference { format!("&mut *{}", self.spelled) } else { format!("&mut {}", self.spelled) }
    }
}

/// A loop, or a labelled block, around a statement.
#[derive(Clone, Debug)]
pub(super) struct Target {
    /// Its label, with the quote.
    pub(super) label: Option<String>,
    /// Whether it is a loop, which plain `break` and `continue` mean.
    pub(super) is_loop: bool,
    /// Its number, if its iterations are counted and end with it.
    pub(super) cycle: Option<usize>,
}

/// What a function gives back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Returns {
    /// Nothing.
    Unit,
    /// A `bool`.
    Bool,
    /// A `Result<(), Fault>`.
    Result,
    /// An `Option<f32>`.
    Option,
}

impl Returns {
    /// Its type after the parameters.
    pub(super) fn arrow(self) -> &'static str {
        match self {
            Self::Unit => "",
            Self::Bool => " -> bool",
            Self::Result => " -> Result<(), Fault>",
            Self::Option => " -> Option<f32>",
        }
    }

    /// The values it may return.
    pub(super) fn values(self) -> &'static [&'static str] {
        match self {
            Self::Unit => &[""],
            Self::Bool => &["true", "false"],
            Self::Result => &["Ok(())", "Err(Fault)"],
            Self::Option => &["Some(1.0)", "None"],
        }
    }
}

/// A function that statements may call.
#[derive(Clone, Debug)]
pub(super) struct Helper {
    /// Its name.
    pub(super) name: String,
    /// How many filters it takes by `&mut`.
    pub(super) filters: usize,
    /// What it gives back.
    pub(super) returns: Returns,
    /// Whether it takes any filter, not only a `Kf`.
    pub(super) is_generic: bool,
}

/// The surroundings of a statement.
#[derive(Clone, Debug)]
pub(super) struct Scope {
    /// Filters that are not borrowed.
    pub(super) places: Vec<Place>,
    /// Arrays of two filters that are not borrowed.
    pub(super) arrays: Vec<String>,
    /// Options with a filter in them.
    pub(super) options: Vec<String>,
    /// Immutable booleans.
    pub(super) conditions: Vec<String>,
    /// Booleans that are set to constants.
    pub(super) flags: Vec<String>,
    /// Booleans that are set to inputs.
    pub(super) switches: Vec<String>,
    /// Immutable modes.
    pub(super) modes: Vec<String>,
    /// Closures without parameters.
    pub(super) closures: Vec<String>,
    /// Whether methods of `self` may be called.
    pub(super) has_self: bool,
    /// What `return` and `?` may give.
    pub(super) returns: Returns,
    /// Loops and labelled blocks around, the innermost last.
    pub(super) targets: Vec<Target>,
    /// Whether a loop of the program lies around, in this function.
    pub(super) is_in_cycle: bool,
    /// Blocks around.
    pub(super) depth: usize,
}

impl Scope {
    /// A function's outermost block.
    pub(super) fn function(returns: Returns) -> Self {
        Self {
            places: Vec::new(),
            arrays: Vec::new(),
            options: Vec::new(),
            conditions: Vec::new(),
            flags: Vec::new(),
            switches: Vec::new(),
            modes: Vec::new(),
            closures: Vec::new(),
            has_self: false,
            returns,
            targets: Vec::new(),
            is_in_cycle: false,
            depth: 0,
        }
    }

    /// A block inside.
    pub(super) fn inner(&self) -> Self {
        Self { depth: self.depth + 1, ..self.clone() }
    }

    /// The body of a loop or a labelled block.
    pub(super) fn inside(&self, label: Option<String>, is_loop: bool) -> Self {
        let mut inner = self.inner();
        inner.targets.push(Target { label, is_loop, cycle: None });
        inner
    }

    /// The body of a counted loop inside another one.
    pub(super) fn inside_cycle(&self, label: Option<String>, cycle: usize) -> Self {
        let mut inner = self.inner();
        inner.targets.push(Target { label, is_loop: true, cycle: Some(cycle) });
        inner
    }

    /// What ends the iterations of the counted loops that a jump to one of the targets leaves.
    pub(super) fn left_behind(&self, target: usize) -> String {
        let left = self.targets[target + 1..].iter().find_map(|inner| inner.cycle);
        left.map_or_else(String::new, |cycle| format!("io.leave({cycle}); "))
    }

    /// The same without filters, for a question only.
    pub(super) fn emptied(&self) -> Self {
        let (places, arrays, options) = (Vec::new(), Vec::new(), Vec::new());
        Self { places, arrays, options, ..self.clone() }
    }

    /// The same while a place is borrowed under another name.
    pub(super) fn without(&self, roots: &[&str]) -> Self {
        let mut rest = self.clone();
        rest.places.retain(|place| !roots.contains(&place.root.as_str()));
        rest.arrays.retain(|array| !roots.contains(&array.as_str()));
        rest.options.retain(|option| !roots.contains(&option.as_str()));
        rest.has_self = false;
        rest
    }
}
