//! A file and the paths in it.

use std::collections::{BTreeMap, BTreeSet};

use syn::{
    Attribute, Item, ItemUse, Macro, UseTree, VisRestricted, Visibility,
    visit::{self, Visit},
};

/// A place in a crate: names of modules, then perhaps of an item in the last of them.
pub(super) type Place = Vec<String>;

/// A file and what it says of others.
#[derive(Default)]
pub(super) struct File {
    /// As it is told of: `fit/plan`.
    pub name: String,
    pub module: Place,
    /// Names that it imports, where they come from as it is written, and whether they are passed on.
    pub imports: BTreeMap<String, (Place, bool)>,
    /// All other paths in it.
    pub paths: BTreeSet<Place>,
    /// Modules that are there for tests only.
    pub tests: BTreeSet<Place>,
}

impl File {
    /// Reads a file of this name (`fit/mod`) and text.
    pub(super) fn read(name: &str, text: &str) -> Result<Self, String> {
        let name = name.strip_suffix("/mod").unwrap_or(name);
        let is_root = matches!(name, "lib" | "main");
        let module = name.split('/').filter(|_| !is_root).map(str::to_owned).collect();
        let mut file = Self { name: name.to_owned(), module, ..Self::default() };
        file.visit_file(&syn::parse_file(text).map_err(|e| format!("{name}: {e}"))?);
        Ok(file)
    }

    /// Notes the names of a `use` declaration.
    fn import(&mut self, tree: &UseTree, before: &[String], is_passed_on: bool) {
        let with = |name: &dyn ToString| [before, &[name.to_string()]].concat();
        let (name, place) = match tree {
            UseTree::Path(path) => {
                return self.import(&path.tree, &with(&path.ident), is_passed_on);
            }
            UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| self.import(tree, before, is_passed_on));
            }
            UseTree::Name(name) if name.ident == "self" => {
                (before.last().cloned(), before.to_vec())
            }
            UseTree::Name(name) => (Some(name.ident.to_string()), with(&name.ident)),
            UseTree::Rename(name) => (Some(name.rename.to_string()), with(&name.ident)),
            UseTree::Glob(_) => return,
        };
        if let Some(name) = name {
            self.imports.insert(name, (place, is_passed_on));
        }
    }
}

fn is_for_tests(attributes: &[Attribute]) -> bool {
    let is_test = |a: &Attribute| {
        a.path().is_ident("cfg") && a.parse_args::<syn::Path>().is_ok_and(|p| p.is_ident("test"))
    };
    attributes.iter().any(is_test)
}

impl<'ast> Visit<'ast> for File {
    fn visit_item(&mut self, item: &'ast Item) {
        let attributes = match item {
            Item::Mod(item) => &item.attrs,
            Item::Use(item) => &item.attrs,
            Item::Fn(item) => &item.attrs,
            Item::Impl(item) => &item.attrs,
            _ => return visit::visit_item(self, item),
        };
        if !is_for_tests(attributes) {
            visit::visit_item(self, item);
        } else if let Item::Mod(item) = item {
            self.tests.insert([&self.module[..], &[item.ident.to_string()]].concat());
        }
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        self.import(&item.tree, &[], !matches!(item.vis, Visibility::Inherited));
    }

    /// Who may see something is no use of it.
    fn visit_vis_restricted(&mut self, _: &'ast VisRestricted) {}

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.paths.insert(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        visit::visit_path(self, path);
    }

    /// What is in a macro is no tree of its own: its paths are found in its text.
    fn visit_macro(&mut self, item: &'ast Macro) {
        let text = item.tokens.to_string().replace(" :: ", "::");
        let is_in_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        let words = text.split(|c| !is_in_path(c)).map(|word| word.trim_matches(':'));
        for word in words.filter(|word| word.starts_with(|c: char| c.is_alphabetic())) {
            self.paths.insert(word.split("::").map(str::to_owned).collect());
        }
        visit::visit_macro(self, item);
    }
}
