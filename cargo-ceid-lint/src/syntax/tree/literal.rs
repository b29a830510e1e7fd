//! Literals, and how those of one value are spelled.

/// A literal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Literal {
    /// An integer, `None` above 2^64, with its suffix (`u8`, or `f32` in `1f32`).
    Int(Option<u64>, String),
    /// A float, as written.
    Float(String),
    /// `true`, `false`
    Bool(bool),
    /// A string.
    Str(String),
    /// A character.
    Char(char),
    /// A byte string or C string, as written.
    Bytes(String),
}

impl Literal {
    /// The literal in the one way in which all that have its value are spelled.
    #[must_use]
    pub fn spelling(&self) -> String {
        match self {
            Self::Int(Some(value), _) => value.to_string(),
            Self::Int(None, _) => "big".to_owned(),
            Self::Float(text) => self.float().map_or_else(|| text.clone(), |number| format!("{number:?}")),
            Self::Bool(value) => value.to_string(),
            Self::Str(text) => format!("{text:?}"),
            Self::Char(char) => format!("{char:?}"),
            Self::Bytes(text) => text.clone(),
        }
    }

    /// The value of a float.
    #[must_use]
    pub fn float(&self) -> Option<f64> {
        let Self::Float(text) = self else { return None };
        let digits = text.replace('_', "");
        digits.trim_end_matches("f32").trim_end_matches("f64").parse().ok()
    }
}
