//! Which file of a crate defines what another file names, followed through imports and re-exports.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};

/// A path of modules below the root of the crate.
type Module = Vec<String>;

/// A module: its file, what it contains, and what its imports make nameable in it.
#[derive(Debug, Default)]
struct Scope {
    /// Index of its file.
    file: usize,
    defined: BTreeSet<String>,
    /// The path behind each imported name.
    imported: BTreeMap<String, Vec<String>>,
    /// Paths that end in `*`.
    globs: Vec<Vec<String>>,
    /// Paths in its items.
    named: BTreeSet<Vec<String>>,
}

/// The modules of a crate.
#[derive(Debug, Default)]
pub struct Names {
    /// The files.
    pub files: Vec<PathBuf>,
    /// The module of each file.
    modules: Vec<Module>,
    scopes: BTreeMap<Module, Scope>,
}

impl Names {
    /// Reads the crate whose root is this file. Tests are left out.
    ///
    /// # Panics
    ///
    /// When a file is missing or is no Rust.
    pub fn of(root: &Path) -> Self {
        let mut names = Self::default();
        let folder = root.parent().expect("a file stands in a folder");
        names.read_file(root, folder, Vec::new());
        names
    }

    /// Lists the files that each file takes names from, but for those of modules around it and within it.
    pub fn arrows(&self) -> BTreeMap<usize, BTreeSet<usize>> {
        let mut arrows: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
        for (module, scope) in &self.scopes {
            let found = arrows.entry(scope.file).or_default();
            for path in &scope.named {
                let file = self.file_of(module, path, 0);
                found.extend(file.filter(|file| !self.is_around_or_within(*file, scope.file)));
            }
        }
        arrows
    }

    fn is_around_or_within(&self, one: usize, other: usize) -> bool {
        let (one, other) = (&self.modules[one], &self.modules[other]);
        one.starts_with(other) || other.starts_with(one)
    }

    fn read_file(&mut self, path: &Path, below: &Path, module: Module) {
        let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let file = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        self.files.push(path.to_owned());
        self.modules.push(module.clone());
        self.read_items(&file.items, self.files.len() - 1, below, module);
    }

    /// `below` is the folder of the files of its child modules.
    fn read_items(&mut self, items: &[syn::Item], file: usize, below: &Path, module: Module) {
        let mut scope = Scope { file, ..Scope::default() };
        let mut children = Vec::new();
        for item in items {
            match item {
                syn::Item::Mod(child) if !is_of_tests(&child.attrs) => children.push(child),
                syn::Item::Mod(_) => {}
                syn::Item::Use(item) if !is_of_tests(&item.attrs) => {
                    let is_public = !matches!(item.vis, syn::Visibility::Inherited);
                    scope.import(&item.tree, &mut Vec::new(), is_public);
                }
                item => {
                    scope.defined.extend(name_of(item));
                    Paths(&mut scope.named).visit_item(item);
                }
            }
        }
        self.scopes.insert(module.clone(), scope);
        for child in children {
            let name = child.ident.to_string();
            let mut module = module.clone();
            module.push(name.clone());
            let folder = below.join(&name);
            match &child.content {
                Some((_, items)) => self.read_items(items, file, &folder, module),
                None => {
                    let beside = below.join(format!("{name}.rs"));
                    let path = if beside.exists() { beside } else { folder.join("mod.rs") };
                    self.read_file(&path, &folder, module);
                }
            }
        }
    }

    /// The file that defines what `path` names in `module`; none for names of other crates.
    fn file_of(&self, module: &[String], path: &[String], depth: usize) -> Option<usize> {
        let (first, rest) = path.split_first()?;
        // A re-export of itself by a glob.
        if depth > 16 {
            return None;
        }
        let scope = self.scopes.get(module)?;
        let at = |module: &[String]| match rest {
            [] => self.scopes.get(module).map(|scope| scope.file),
            rest => self.file_of(module, rest, depth),
        };
        match first.as_str() {
            "crate" => return at(&[]),
            "self" => return at(module),
            "super" => return at(module.split_last()?.1),
            _ => {}
        }
        let child = [module, std::slice::from_ref(first)].concat();
        if self.scopes.contains_key(&child) {
            return at(&child);
        }
        if scope.defined.contains(first) {
            return Some(scope.file);
        }
        if let Some(import) = scope.imported.get(first) {
            // `use x::x`, where the first is a crate.
            if import.first() == Some(first) && !self.scopes.contains_key(&child) {
                return None;
            }
            let whole: Vec<String> = import.iter().chain(rest).cloned().collect();
            return self.file_of(module, &whole, depth + 1);
        }
        scope.globs.iter().find_map(|glob| {
            let whole: Vec<String> = glob.iter().chain(path).cloned().collect();
            self.file_of(module, &whole, depth + 1)
        })
    }
}

impl Scope {
    /// Re-exports tie nothing: those who use them take the name from where it is defined.
    fn import(&mut self, tree: &syn::UseTree, before: &mut Vec<String>, is_public: bool) {
        let mut add = |name: String, path: Vec<String>| {
            if !is_public {
                self.named.insert(path.clone());
            }
            self.imported.insert(name, path);
        };
        match tree {
            syn::UseTree::Path(path) => {
                before.push(path.ident.to_string());
                self.import(&path.tree, before, is_public);
                before.pop();
            }
            syn::UseTree::Name(name) if name.ident == "self" => {
                add(before.last().cloned().unwrap_or_default(), before.clone());
            }
            syn::UseTree::Name(name) => {
                let name = name.ident.to_string();
                add(name.clone(), [before.as_slice(), &[name]].concat());
            }
            syn::UseTree::Rename(name) => {
                let path = [before.as_slice(), &[name.ident.to_string()]].concat();
                add(name.rename.to_string(), path);
            }
            syn::UseTree::Glob(_) => self.globs.push(before.clone()),
            syn::UseTree::Group(group) => {
                for tree in &group.items {
                    self.import(tree, before, is_public);
                }
            }
        }
    }
}

/// Gathers paths of at least two names; one name alone is imported or defined in its module.
struct Paths<'a>(&'a mut BTreeSet<Vec<String>>);

impl<'ast> Visit<'ast> for Paths<'_> {
    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|part| part.ident.to_string()).collect();
        if names.len() > 1 && path.leading_colon.is_none() {
            self.0.insert(names);
        }
        visit::visit_path(self, path);
    }
}

fn name_of(item: &syn::Item) -> Option<String> {
    let name = match item {
        syn::Item::Const(item) => &item.ident,
        syn::Item::Enum(item) => &item.ident,
        syn::Item::Fn(item) => &item.sig.ident,
        syn::Item::Macro(item) => item.ident.as_ref()?,
        syn::Item::Static(item) => &item.ident,
        syn::Item::Struct(item) => &item.ident,
        syn::Item::Trait(item) => &item.ident,
        syn::Item::TraitAlias(item) => &item.ident,
        syn::Item::Type(item) => &item.ident,
        syn::Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(name.to_string())
}

/// Whether it is only there in tests.
fn is_of_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute.parse_args::<syn::Path>().is_ok_and(|path| path.is_ident("test"))
    })
}
