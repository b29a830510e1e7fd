//! From the trees of all crates to flat tables. Resolves nothing.

use std::collections::BTreeMap;
use std::collections::hash_map::Entry::{Occupied, Vacant};

use super::{
    AliasDef, AliasId, BodyOwner, CrateId, CrateInfo, CrateInput, Def, Entry, FunctionDef, FunctionId, ImplDef, ImplId,
    Index, Module, ModuleId, Namespace, Owner, Shape, TraitDef, TraitId, Ty, TypeDef, TypeId, ValueDef, ValueId,
};
use crate::syntax::tree::{
    AssocItem, AssocKind, Attribute, Body, ExprId, ExprKind, Function, Item, ItemKind, TypeRef, ValueItem,
};

/// Collects the items of all crates.
pub(super) fn collect(inputs: Vec<CrateInput>) -> Index {
    let mut collector = Collector { index: Index::default() };
    for input in inputs {
        collector.collect_crate(input);
    }
    collector.index
}

struct Collector {
    index: Index,
}

fn next<T>(table: &[T]) -> u32 {
    u32::try_from(table.len()).expect("fewer than 2^32 items")
}

impl Collector {
    fn collect_crate(&mut self, input: CrateInput) {
        let krate = CrateId(next(&self.index.crates));
        let root = ModuleId(next(&self.index.modules));
        let externs = input
            .externs
            .into_iter()
            .map(|(name, (krate, package))| {
                let krate = krate.map(|index| CrateId(u32::try_from(index).expect("fewer than 2^32 crates")));
                (name, (krate, package))
            })
            .collect();
        self.index.crates.push(CrateInfo {
            package: input.package,
            target: input.target,
            name: input.name,
            package_name: input.package_name,
            removed: input.removed,
            root,
            externs,
            is_reported: input.is_reported,
            is_test: input.is_test,
        });
        self.add_module(Module { is_test: input.is_test, ..Module::of(krate, None) });
        self.collect_items(root, input.items);
    }

    fn add_module(&mut self, module: Module) -> ModuleId {
        let id = ModuleId(next(&self.index.modules));
        self.index.modules.push(module);
        id
    }

    fn define(&mut self, module: ModuleId, namespace: Namespace, name: &str, entry: Entry) {
        // The first definition wins: a second one is there under another `cfg` only.
        let names = &mut self.index.modules[module.0 as usize].names;
        match names.entry((namespace, name.to_owned())) {
            Occupied(known) if matches!((known.get(), &entry), (Entry::Import(_), Entry::Def(_))) => {
                // An import of the same name is one of another namespace: `use rtic::app;` beside `mod app`.
                *known.into_mut() = entry;
            }
            Occupied(_) => {}
            Vacant(free) => {
                free.insert(entry);
            }
        }
    }

    fn collect_items(&mut self, module: ModuleId, items: Vec<Item>) {
        self.index.modules[module.0 as usize].file = items.first().map(|item| item.span.file);
        for item in items {
            self.collect_item(module, item);
        }
    }

    fn collect_item(&mut self, module: ModuleId, item: Item) {
        let Item { name, name_span, attributes, kind, is_pub, .. } = item;
        if !is_pub {
            self.note_private(module, &name, &kind);
        }
        match kind {
            ItemKind::Mod(items) => {
                let parent = self.index.module(module);
                let is_test = parent.is_test || is_test_only(&attributes);
                let id = self.add_module(Module {
                    name: name.clone(),
                    is_private: !is_pub,
                    is_test,
                    ..Module::of(parent.krate, Some(module))
                });
                self.define(module, Namespace::Type, &name, Entry::Def(Def::Module(id)));
                if super::rtic::is_app(&attributes) {
                    for task in super::rtic::contexts(&items) {
                        self.collect_context(id, task);
                    }
                }
                self.collect_items(id, items);
            }
            ItemKind::Use(names) => self.collect_use(module, names),
            ItemKind::ExternCrate { alias } => {
                let bound = alias.unwrap_or_else(|| name.clone());
                if bound != name {
                    self.define(module, Namespace::Type, &bound, Entry::Import(vec![String::new(), name]));
                }
            }
            ItemKind::Struct { generics, fields } => {
                let is_tuple = !fields.named;
                let id = TypeId(next(&self.index.types));
                let shape = Shape::Struct(fields);
                self.index.types.push(TypeDef {
                    name: name.clone(),
                    span: name_span,
                    module,
                    generics,
                    shape,
                    attributes,
                });
                self.define(module, Namespace::Type, &name, Entry::Def(Def::Type(id)));
                if is_tuple {
                    self.define(module, Namespace::Value, &name, Entry::Def(Def::Type(id)));
                }
            }
            ItemKind::Enum { generics, variants } => {
                let id = TypeId(next(&self.index.types));
                let shape = Shape::Enum(variants);
                self.index.types.push(TypeDef {
                    name: name.clone(),
                    span: name_span,
                    module,
                    generics,
                    shape,
                    attributes,
                });
                self.define(module, Namespace::Type, &name, Entry::Def(Def::Type(id)));
            }
            ItemKind::TypeAlias { generics, ty } => {
                let id = AliasId(next(&self.index.aliases));
                self.index.aliases.push(AliasDef { module, generics, ty });
                self.define(module, Namespace::Type, &name, Entry::Def(Def::Alias(id)));
            }
            ItemKind::Trait { generics, supertraits, items } => {
                let id = TraitId(next(&self.index.traits));
                let (methods, types, _) = (BTreeMap::new(), BTreeMap::new(), ());
                self.index.traits.push(TraitDef {
                    name: name.clone(),
                    span: name_span,
                    module,
                    generics,
                    supertraits,
                    methods,
                    types,
                });
                self.define(module, Namespace::Type, &name, Entry::Def(Def::Trait(id)));
                for item in items {
                    self.collect_trait_item(module, id, item);
                }
            }
            ItemKind::Impl { generics, trait_path, self_ty, items } => {
                let id = ImplId(next(&self.index.impls));
                self.index.impls.push(ImplDef {
                    module,
                    generics,
                    trait_path,
                    implements: None,
                    self_ref: self_ty,
                    self_ty: Ty::Unknown,
                    methods: BTreeMap::new(),
                    types: BTreeMap::new(),
                    consts: BTreeMap::new(),
                });
                let is_test = is_test_only(&attributes);
                for item in items {
                    self.collect_impl_item(module, id, item, is_test);
                }
            }
            ItemKind::Function(function) => {
                let id = self.add_function(module, Owner::Module, name.clone(), *function, attributes, false);
                self.define(module, Namespace::Value, &name, Entry::Def(Def::Function(id)));
            }
            ItemKind::Value(value) => {
                let id = self.add_value(module, Owner::Module, name.clone(), name_span, *value);
                self.define(module, Namespace::Value, &name, Entry::Def(Def::Value(id)));
            }
            ItemKind::MacroRules { .. } => {}
            ItemKind::MacroCall(call) => self.index.opaque_items.push((module, call)),
        }
    }

    /// The module of a task: its names are those of the application, too.
    fn collect_context(&mut self, app: ModuleId, task: Item) {
        let parent = self.index.module(app);
        let id = self.add_module(Module {
            name: task.name.clone(),
            is_block: true,
            is_test: parent.is_test,
            ..Module::of(parent.krate, Some(app))
        });
        self.define(app, Namespace::Type, &task.name, Entry::Def(Def::Module(id)));
        if let ItemKind::Mod(items) = task.kind {
            self.collect_items(id, items);
        }
    }

    /// Notes what only the module itself, and what lies in it, gets by a glob.
    fn note_private(&mut self, module: ModuleId, name: &str, kind: &ItemKind) {
        let private = &mut self.index.modules[module.0 as usize].private;
        match kind {
            ItemKind::Use(names) => private.extend(names.iter().filter_map(|import| import.name.clone())),
            ItemKind::Trait { .. } => drop(private.insert(name.to_owned())),
            _ => {}
        }
    }

    fn collect_use(&mut self, module: ModuleId, names: Vec<crate::syntax::tree::UseName>) {
        for import in names {
            match import.name {
                None => self.index.modules[module.0 as usize].globs.push(import.path),
                Some(name) => {
                    for namespace in [Namespace::Type, Namespace::Value] {
                        let already = self.index.module(module).names.contains_key(&(namespace, name.clone()));
                        if !already {
                            self.define(module, namespace, &name, Entry::Import(import.path.clone()));
                        } else if namespace == Namespace::Type {
                            self.index.modules[module.0 as usize].unnamed.push(import.path.clone());
                        }
                    }
                }
            }
        }
    }

    fn collect_trait_item(&mut self, module: ModuleId, id: TraitId, item: AssocItem) {
        match item.kind {
            AssocKind::Function(function) => {
                let owner = Owner::Trait(id);
                let function = self.add_function(module, owner, item.name.clone(), *function, item.attributes, false);
                self.index.traits[id.0 as usize].methods.entry(item.name).or_insert(function);
            }
            AssocKind::Type { bounds, .. } => {
                self.index.traits[id.0 as usize].types.insert(item.name, bounds);
            }
            AssocKind::Const(_) => {}
            AssocKind::MacroCall(mut call) => {
                // What it makes belongs to what it stands in.
                call.mentions.push(self.index.traits[id.0 as usize].name.clone());
                self.index.opaque_items.push((module, call));
            }
        }
    }

    fn collect_impl_item(&mut self, module: ModuleId, id: ImplId, item: AssocItem, is_test: bool) {
        match item.kind {
            AssocKind::Function(function) => {
                let owner = Owner::Impl(id);
                let function = self.add_function(module, owner, item.name.clone(), *function, item.attributes, is_test);
                self.index.functions[function.0 as usize].is_pub_method = item.is_pub;
                self.index.impls[id.0 as usize].methods.entry(item.name).or_insert(function);
            }
            AssocKind::Type { ty, .. } => {
                if let Some(ty) = ty {
                    self.index.impls[id.0 as usize].types.insert(item.name, ty);
                }
            }
            AssocKind::Const(value) => {
                let value = self.add_value(module, Owner::Impl(id), item.name.clone(), item.name_span, *value);
                self.index.impls[id.0 as usize].consts.insert(item.name, value);
            }
            AssocKind::MacroCall(mut call) => {
                if let TypeRef::Path(path) = &self.index.impls[id.0 as usize].self_ref {
                    call.mentions.push(path.last().to_owned());
                }
                self.index.opaque_items.push((module, call));
            }
        }
    }

    fn add_function(
        &mut self,
        module: ModuleId,
        owner: Owner,
        name: String,
        mut function: Function,
        attributes: Vec<Attribute>,
        is_test: bool,
    ) -> FunctionId {
        let id = FunctionId(next(&self.index.functions));
        let is_test = is_test || self.index.module(module).is_test || is_test_only(&attributes);
        let blocks = function.body.as_mut().map(take_items).unwrap_or_default();
        let is_pub_method = false;
        self.index.functions.push(FunctionDef { name, module, owner, function, attributes, is_test, is_pub_method });
        self.collect_blocks(module, BodyOwner::Function(id), blocks);
        id
    }

    fn add_value(
        &mut self,
        module: ModuleId,
        owner: Owner,
        name: String,
        span: crate::source::Span,
        mut item: ValueItem,
    ) -> ValueId {
        let id = ValueId(next(&self.index.values));
        let blocks = item.value.as_mut().map(take_items).unwrap_or_default();
        self.index.values.push(ValueDef { name, span, module, owner, item });
        self.collect_blocks(module, BodyOwner::Value(id), blocks);
        id
    }

    /// Makes a module of each block with items. Outer blocks have higher ids, because children come before their parents.
    fn collect_blocks(&mut self, module: ModuleId, owner: BodyOwner, blocks: Vec<(ExprId, Option<ExprId>, Vec<Item>)>) {
        let krate = self.index.module(module).krate;
        let is_test = self.index.module(module).is_test;
        for (block, around, items) in blocks.into_iter().rev() {
            let parent = around.and_then(|around| self.index.blocks.get(&(owner, around)).copied()).unwrap_or(module);
            let id = self.add_module(Module { is_block: true, is_test, ..Module::of(krate, Some(parent)) });
            self.index.blocks.insert((owner, block), id);
            self.collect_items(id, items);
        }
    }
}

/// Takes the items out of all blocks of a body: the block, the next block with items around it, and its items.
fn take_items(body: &mut Body) -> Vec<(ExprId, Option<ExprId>, Vec<Item>)> {
    let mut taken: Vec<(ExprId, Option<ExprId>, Vec<Item>)> = Vec::new();
    let mut spans = Vec::new();
    for (number, expr) in body.exprs.iter_mut().enumerate() {
        if let ExprKind::Block(block) = &mut expr.kind
            && !block.items.is_empty()
        {
            let id = ExprId(u32::try_from(number).expect("fewer than 2^32 expressions"));
            spans.push(expr.span);
            taken.push((id, None, std::mem::take(&mut block.items)));
        }
    }
    for inner in 0..taken.len() {
        taken[inner].1 =
            (inner + 1..taken.len()).find(|outer| spans[*outer].contains(spans[inner])).map(|at| taken[at].0);
    }
    taken
}

/// Whether attributes say that something is there for tests only.
fn is_test_only(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let last = attribute.path.rsplit("::").next().unwrap_or("");
        matches!(last, "test" | "bench" | "rstest" | "test_case" | "proptest" | "quickcheck" | "tests")
    })
}
