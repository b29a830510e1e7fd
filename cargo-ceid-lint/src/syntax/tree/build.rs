//! What code asks of the build that it is in: `cfg!`.

use super::{CfgKey, MacroKind};

/// What `cfg!` gives in the build that is judged.
#[derive(Clone, Debug, PartialEq)]
pub enum BuildFlag {
    /// The chosen target and features tell.
    Known(bool),
    /// It depends on a flag that is not known.
    Unknown(CfgKey),
}

impl MacroKind {
    /// What `cfg!` gives in the build that is judged, if that is asked and known.
    #[must_use]
    pub fn built(&self) -> Option<bool> {
        match self {
            Self::Build(BuildFlag::Known(answer)) => Some(*answer),
            _ => None,
        }
    }
}
