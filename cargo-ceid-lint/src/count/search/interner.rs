//! Small numbers for values that states share.

use std::rc::Rc;

use rustc_hash::FxHashMap;

#[derive(Default)]
pub(super) struct Interner<T> {
    values: Vec<Rc<T>>,
    known: FxHashMap<Rc<T>, u32>,
}

impl<T: Eq + std::hash::Hash> Interner<T> {
    pub(super) fn intern(&mut self, value: T) -> u32 {
        match self.known.get(&value) {
            Some(id) => *id,
            None => self.intern_shared(Rc::new(value)),
        }
    }

    /// The same for a value that may be one of these already.
    pub(super) fn intern_shared(&mut self, value: Rc<T>) -> u32 {
        if let Some(id) = self.known.get(&value) {
            return *id;
        }
        let id = u32::try_from(self.values.len()).unwrap_or(u32::MAX);
        self.values.push(Rc::clone(&value));
        self.known.insert(value, id);
        id
    }

    pub(super) fn shared(&self, id: u32) -> Rc<T> {
        Rc::clone(&self.values[id as usize])
    }

    pub(super) fn get(&self, id: u32) -> &T {
        &self.values[id as usize]
    }
}
