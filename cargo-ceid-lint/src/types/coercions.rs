//! References that are lent as ones to something else: to what a pointer holds, or what `Deref` impls of the analysed code lead to.

use super::builtin;
use super::infer::Infer;
use crate::index::Ty;
use crate::syntax::tree::ExprId;

/// How many `Deref` impls are gone through.
const MAX_DEREFS: usize = 4;

impl Infer<'_> {
    /// Unifies an argument with a parameter; a reference to a pointer is a reference to its content where that is asked for.
    pub(super) fn coerce(&mut self, wanted: &Ty, found: &Ty) {
        let found = self.variables.shallow(found);
        if let (Ty::Ref(_, inner), Ty::Ref(_, content)) = (self.variables.shallow(wanted), &found)
            && let Ty::External(path, args) = self.variables.shallow(content)
            && builtin::is_pointer(path.rsplit("::").next().unwrap_or(""))
            && !matches!(self.variables.shallow(&inner), Ty::Var(_) | Ty::External(..))
            && !args.is_empty()
        {
            return self.variables.unify(&inner, &args[0]);
        }
        self.variables.unify(wanted, &found);
    }

    /// The type as which a reference is lent where one to something else is expected, to which `Deref` impls of the analysed code lead.
    pub(super) fn lent_as(&mut self, id: ExprId, found: &Ty, expected: &Ty) -> Option<Ty> {
        let Ty::Ref(mutable, own) = self.variables.shallow(found) else { return None };
        let Ty::Ref(_, wanted) = self.variables.shallow(expected) else { return None };
        let (wanted, mut own) = (self.variables.shallow(&wanted), self.variables.shallow(&own));
        let is_wanted = |own: &Ty| match (own, &wanted) {
            (Ty::Adt(own, _), Ty::Adt(wanted, _)) => own == wanted,
            (Ty::External(own, _), Ty::External(wanted, _)) => own == wanted,
            (Ty::Slice(_) | Ty::Array(..), Ty::Slice(_)) => true,
            (Ty::External(own, _), Ty::Slice(_)) => own == "std::vec::Vec",
            _ => false,
        };
        if !matches!(wanted, Ty::Adt(..) | Ty::External(..) | Ty::Slice(_)) {
            return None;
        }
        let mut derefs = Vec::new();
        while derefs.len() < MAX_DEREFS && !is_wanted(&own) {
            let behind = match &own {
                Ty::Adt(..) => {
                    let (target, through) = self.user_deref(&own)?;
                    derefs.push(through);
                    target
                }
                Ty::External(path, args) if builtin::is_pointer(path.rsplit("::").next().unwrap_or("")) => {
                    args.first()?.clone()
                }
                // A reference to a reference, as that to what a lock opens.
                Ty::Ref(_, inner) => (**inner).clone(),
                _ => return None,
            };
            own = self.variables.shallow(&behind);
        }
        let is_it = !derefs.is_empty() && is_wanted(&own);
        is_it.then(|| {
            self.typed.coerced.insert(id, derefs);
            Ty::Ref(mutable, Box::new(own))
        })
    }
}
