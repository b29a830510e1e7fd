//! Items by path: types, fields, functions, impls, `use` resolution; which types are filters. Reads no bodies.

mod collect;
mod entries;
mod entry_arguments;
mod entry_errors;
mod entry_resets;
mod extensions;
mod filters;
mod function_places;
mod generics;
mod in_scope;
mod known;
mod lookup;
mod module;
mod names;
mod owned;
mod plain;
mod possible;
mod rtic;
mod states;
mod ty;

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::{FxHashMap, FxHashSet};

use crate::source::Span;
use crate::syntax::tree::{
    Attribute, Bound, ExprId, Fields, Function, Generics, OpaqueMacro, Path, TypeRef, ValueItem, Variant,
};

pub use entries::{CycleSpec, EntryScope, GuardSpec};
pub use filters::{FilterSpec, LawGroup, Subject};
pub use function_places::{FunctionPlace, FunctionPlaces};
pub use known::{is_guard_type, is_sampled_filter_path};
pub use lookup::MethodOwner;
use module::Entry;
pub use module::Module;
pub use names::{Globbed, Namespace};
pub use rtic::SHARED_RESOURCE;
pub use states::{handed, is_number};
pub(crate) use ty::primitive;
pub use ty::{Length, ParamTy, TraitName, TraitRef, Ty, TyScope};

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident;)*) => { $(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name(pub u32);
    )* };
}

ids! {
    /// A crate.
    CrateId;
    /// A module, or a block with items of its own.
    ModuleId;
    /// A struct, union or enum.
    TypeId;
    /// A `type` alias.
    AliasId;
    /// A trait.
    TraitId;
    /// An `impl`.
    ImplId;
    /// A function, method or signature.
    FunctionId;
    /// A constant or static.
    ValueId;
}

/// Everything that has a name in the analysed code.
#[derive(Debug, Default)]
pub struct Index {
    /// Paths into crates whose sources are not read that the entries name, so that glob imports of them are understood.
    named_outside: Vec<String>,
    /// The crates, dependencies before those that use them.
    pub crates: Vec<CrateInfo>,
    /// The modules.
    pub modules: Vec<Module>,
    /// The structs, unions and enums.
    pub types: Vec<TypeDef>,
    /// The aliases.
    pub aliases: Vec<AliasDef>,
    /// The traits.
    pub traits: Vec<TraitDef>,
    /// The impls.
    pub impls: Vec<ImplDef>,
    /// The functions.
    pub functions: Vec<FunctionDef>,
    /// The generic functions of which there are instances for certain types; the numbers of these go on behind the functions.
    pub instances: Vec<FunctionId>,
    /// The constants and statics.
    pub values: Vec<ValueDef>,
    /// The modules of blocks that hold items, by the function or value whose body the block lies in.
    pub blocks: FxHashMap<(BodyOwner, ExprId), ModuleId>,
    /// Macros called where items stand, that could not be read: they may define anything.
    pub opaque_items: Vec<(ModuleId, OpaqueMacro)>,
    impls_of_type: FxHashMap<TypeId, Vec<ImplId>>,
    impls_of_external: FxHashMap<String, Vec<ImplId>>,
    impls_of_reference: FxHashMap<(bool, TypeId), Vec<ImplId>>,
    traits_of_type: FxHashMap<TypeId, FxHashSet<TraitName>>,
    traits_of_external: FxHashMap<String, FxHashSet<TraitName>>,
    /// The impls for a type parameter, and those of each trait among them.
    blankets: Vec<ImplId>,
    blankets_of_trait: FxHashMap<TraitName, Vec<ImplId>>,
    /// Those for arrays, slices, tuples and `impl Trait`.
    impls_of_shapes: Vec<ImplId>,
    /// Those for primitive types and references, by the names of their methods.
    extensions: FxHashMap<String, Vec<ImplId>>,
    impls_of_trait: FxHashMap<TraitId, Vec<ImplId>>,
    /// Those of traits that are not read, and what types derive.
    impls_of_foreign: FxHashMap<String, Vec<ImplId>>,
    derived: FxHashSet<String>,
    /// The traits that each trait asks for, at any depth.
    implied: Vec<FxHashSet<TraitName>>,
    /// What paths mean, as far as it was asked.
    resolved: std::sync::RwLock<Resolved>,
    /// Which traits are in scope in modules, as far as it was asked.
    in_scope: std::sync::RwLock<FxHashMap<(ModuleId, TraitName), Option<bool>>>,
    /// What may be behind types that are known by their bounds, as far as it was asked.
    behind: std::sync::RwLock<FxHashMap<Ty, std::sync::Arc<[Ty]>>>,
    specs: Vec<FilterSpec>,
    /// Those of them that entries name.
    entered: Vec<entries::Entered>,
    cycles: Vec<CycleSpec>,
    guards: Vec<GuardSpec>,
    /// Functions of crates whose sources are not read that give a filter, with its path.
    makers: BTreeMap<String, String>,
    /// Functions that reset a filter which they are lent.
    reset_functions: Vec<entry_resets::ResetFunction>,
    /// The types of states that laws have in an argument.
    states: Vec<states::StateType>,
    /// The types that are filters or have one among their fields, at any depth.
    holding: FxHashSet<TypeId>,
    /// The types that a field of a struct has.
    kept: FxHashSet<TypeId>,
    /// The types that lead to destructors or to something that is called.
    leading: owned::Leading,
}

/// What paths mean in modules.
type Resolved = FxHashMap<(ModuleId, Namespace, Vec<String>), Option<Def>>;

/// Whose body it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BodyOwner {
    /// A function's.
    Function(FunctionId),
    /// A constant's or static's.
    Value(ValueId),
}

/// A crate.
#[derive(Debug)]
pub struct CrateInfo {
    /// Index into the project's packages.
    pub package: usize,
    /// Index into the package's targets.
    pub target: usize,
    /// Its name in `use`.
    pub name: String,
    /// The name of its package, as a crate of that name would be spelled.
    pub package_name: String,
    /// The names of items and methods that are not there under this `cfg`.
    pub removed: BTreeSet<String>,
    /// Its root module.
    pub root: ModuleId,
    /// The crates it can name, by the name it uses; `None` for one whose sources are not read, with its package's name.
    pub externs: BTreeMap<String, (Option<CrateId>, String)>,
    /// Whether findings in it are reported.
    pub is_reported: bool,
    /// Whether it is a test or benchmark target: nothing in it is presumed to be a cycle.
    pub is_test: bool,
}

/// A crate before it is collected: what the index needs to know of it.
#[derive(Clone, Debug)]
pub struct CrateInput {
    /// Index into the project's packages.
    pub package: usize,
    /// Index into the package's targets.
    pub target: usize,
    /// Its name in `use`.
    pub name: String,
    /// See [`CrateInfo::package_name`].
    pub package_name: String,
    /// See [`CrateInfo::removed`].
    pub removed: BTreeSet<String>,
    /// See [`CrateInfo::externs`]; the crate is an index into the list of inputs.
    pub externs: BTreeMap<String, (Option<usize>, String)>,
    /// Whether findings in it are reported.
    pub is_reported: bool,
    /// Whether it is a test or benchmark target.
    pub is_test: bool,
    /// Its items.
    pub items: Vec<crate::syntax::tree::Item>,
}

/// What a path means.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Def {
    /// A module.
    Module(ModuleId),
    /// A struct, union or enum.
    Type(TypeId),
    /// A variant, by its number.
    Variant(TypeId, usize),
    /// An alias.
    Alias(AliasId),
    /// A trait.
    Trait(TraitId),
    /// A function.
    Function(FunctionId),
    /// A constant or static.
    Value(ValueId),
    /// Something of a crate whose sources are not read: its path, `core` and `alloc` written as `std`.
    External(String),
}

/// A struct, union or enum.
#[derive(Debug)]
pub struct TypeDef {
    /// Its name.
    pub name: String,
    /// Where the name stands.
    pub span: Span,
    /// The module it is declared in.
    pub module: ModuleId,
    /// Its parameters.
    pub generics: Generics,
    /// Its shape.
    pub shape: Shape,
    /// Its attributes.
    pub attributes: Vec<Attribute>,
}

/// The shape of a type.
#[derive(Debug)]
pub enum Shape {
    /// Fields.
    Struct(Fields),
    /// Variants.
    Enum(Vec<Variant>),
}

/// An alias.
#[derive(Debug)]
pub struct AliasDef {
    /// The module it is declared in.
    pub module: ModuleId,
    /// Its parameters.
    pub generics: Generics,
    /// What it stands for.
    pub ty: TypeRef,
}

/// A trait.
#[derive(Debug)]
pub struct TraitDef {
    /// Its name.
    pub name: String,
    /// Where the name stands.
    pub span: Span,
    /// The module it is declared in.
    pub module: ModuleId,
    /// Its parameters.
    pub generics: Generics,
    /// Its supertraits.
    pub supertraits: Vec<Bound>,
    /// Its methods, with or without default bodies.
    pub methods: BTreeMap<String, FunctionId>,
    /// Its associated types with their bounds.
    pub types: BTreeMap<String, Vec<Bound>>,
}

/// An impl.
#[derive(Debug)]
pub struct ImplDef {
    /// The module it stands in.
    pub module: ModuleId,
    /// Its parameters.
    pub generics: Generics,
    /// The trait as written.
    pub trait_path: Option<Path>,
    /// The trait, resolved.
    pub implements: Option<TraitName>,
    /// The type as written.
    pub self_ref: TypeRef,
    /// The type, resolved.
    pub self_ty: Ty,
    /// Its methods.
    pub methods: BTreeMap<String, FunctionId>,
    /// Its associated types.
    pub types: BTreeMap<String, TypeRef>,
    /// Its associated constants.
    pub consts: BTreeMap<String, ValueId>,
}

/// What a function belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Owner {
    /// A module or block.
    Module,
    /// An impl.
    Impl(ImplId),
    /// A trait.
    Trait(TraitId),
}

/// A function, method or signature.
#[derive(Debug)]
pub struct FunctionDef {
    /// Its name.
    pub name: String,
    /// The module it stands in.
    pub module: ModuleId,
    /// What it belongs to.
    pub owner: Owner,
    /// Its signature and body.
    pub function: Function,
    /// Its attributes.
    pub attributes: Vec<Attribute>,
    /// Whether it is a test, or compiled for tests only.
    pub is_test: bool,
    /// Whether it is a method with any `pub`; those of traits have none.
    pub is_pub_method: bool,
}

/// A constant or static.
#[derive(Debug)]
pub struct ValueDef {
    /// Its name.
    pub name: String,
    /// Where the name stands.
    pub span: Span,
    /// The module it stands in.
    pub module: ModuleId,
    /// The impl it belongs to.
    pub owner: Owner,
    /// Its type and value.
    pub item: ValueItem,
}

impl Index {
    /// Collects and links the items of all crates; a crate stands behind those it names. `named_outside` are the paths that
    /// the entries of the configuration name in crates whose sources are not read.
    #[must_use]
    pub fn build(inputs: Vec<CrateInput>, named_outside: Vec<String>) -> Self {
        let mut index = collect::collect(inputs);
        index.named_outside = named_outside;
        index.link();
        index.specs = filters::specs(&index);
        index.find_holders();
        index
    }

    /// The function with that id.
    #[must_use]
    pub fn function(&self, id: FunctionId) -> &FunctionDef {
        &self.functions[self.origin(id).0 as usize]
    }

    /// The function as it is written: another one where the id is that of an instance of it.
    #[must_use]
    pub fn origin(&self, id: FunctionId) -> FunctionId {
        let instance = (id.0 as usize).checked_sub(self.functions.len());
        instance.and_then(|at| self.instances.get(at)).copied().unwrap_or(id)
    }

    /// The type with that id.
    #[must_use]
    pub fn type_def(&self, id: TypeId) -> &TypeDef {
        &self.types[id.0 as usize]
    }

    /// The number that a variant of an enum is as an integer, if that is written or counted.
    #[must_use]
    pub fn variant_number(&self, id: TypeId, at: usize) -> Option<u64> {
        let Shape::Enum(variants) = &self.type_def(id).shape else { return None };
        let numbers = variants.get(..=at)?.iter().scan(Some(0_u64), |next, variant| {
            let number = variant.number.unwrap_or(*next);
            *next = number.and_then(|number| number.checked_add(1));
            Some(number)
        });
        numbers.last().flatten()
    }

    /// The variant of an enum that is a number as an integer.
    #[must_use]
    pub fn variant_numbered(&self, id: TypeId, number: u64) -> Option<&str> {
        let Shape::Enum(variants) = &self.type_def(id).shape else { return None };
        let at = (0..variants.len()).find(|at| self.variant_number(id, *at) == Some(number))?;
        Some(&variants[at].name)
    }

    /// The trait with that id.
    #[must_use]
    pub fn trait_def(&self, id: TraitId) -> &TraitDef {
        &self.traits[id.0 as usize]
    }

    /// The impl with that id.
    #[must_use]
    pub fn impl_def(&self, id: ImplId) -> &ImplDef {
        &self.impls[id.0 as usize]
    }

    /// The constant or static with that id.
    #[must_use]
    pub fn value(&self, id: ValueId) -> &ValueDef {
        &self.values[id.0 as usize]
    }

    /// The module with that id.
    #[must_use]
    pub fn module(&self, id: ModuleId) -> &Module {
        &self.modules[id.0 as usize]
    }

    /// The crate a module belongs to.
    #[must_use]
    pub fn crate_of(&self, module: ModuleId) -> &CrateInfo {
        &self.crates[self.module(module).krate.0 as usize]
    }

    /// All functions with their ids.
    pub fn function_ids(&self) -> impl Iterator<Item = FunctionId> + use<> {
        (0..u32::try_from(self.functions.len()).unwrap_or(u32::MAX)).map(FunctionId)
    }

    /// The type that declares the fields of a type: itself, or the struct of resources that an RTIC task has some of.
    #[must_use]
    pub fn declares_fields(&self, id: TypeId) -> TypeId {
        let def = self.type_def(id);
        let declared = rtic::declared_in(&def.attributes)
            .and_then(|name| self.resolve(def.module, &[name.to_owned()], Namespace::Type));
        match declared {
            Some(Def::Type(declared)) => declared,
            _ => id,
        }
    }

    /// The function as a reader names it: `main`, `Robot::run`.
    #[must_use]
    pub fn function_name(&self, id: FunctionId) -> String {
        let def = self.function(id);
        match def.owner {
            Owner::Module => def.name.clone(),
            Owner::Impl(impl_id) => format!("{}::{}", self.type_name(&self.impl_def(impl_id).self_ty), def.name),
            Owner::Trait(trait_id) => format!("{}::{}", self.trait_def(trait_id).name, def.name),
        }
    }

    /// The scope in which the types of a function are read.
    #[must_use]
    pub fn scope_of(&self, id: FunctionId) -> TyScope<'_> {
        let def = self.function(id);
        TyScope { function: Some(id), ..self.scope(def.module, def.owner, Some(&def.function.generics)) }
    }
}
