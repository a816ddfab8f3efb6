//! No circle of files inside a crate: whoever reads a file need not read those that read it.
//!
//! A module and the modules below it may name each other; they are one subject. Names are followed through `use` and
//! `pub use` to the file that defines them. Code for tests only does not count, nor do the arguments of macros.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemMod, UseTree};

use crate::floors::root;

/// Where names of more `use` steps than this lead is not followed: `use` may go in circles.
const MAX_STEPS: usize = 32;

/// The modules of a crate; the first is its root.
#[derive(Default)]
struct Crate {
    modules: Vec<Module>,
}

struct Module {
    file: PathBuf,
    parent: usize,
    children: BTreeMap<String, usize>,
    /// What `use` brings in: its name here, and its path.
    names: BTreeMap<String, Vec<String>>,
    /// The paths of `use path::*`.
    globs: Vec<Vec<String>>,
    /// The names that are defined here.
    defined: BTreeSet<String>,
    items: Vec<Item>,
}

fn is_for_tests(attributes: &[Attribute]) -> bool {
    let mentions_test = |attribute: &Attribute| match &attribute.meta {
        syn::Meta::List(list) => list.tokens.to_string().contains("test"),
        _ => attribute.path().is_ident("test"),
    };
    attributes.iter().any(|attribute| {
        (attribute.path().is_ident("cfg") || attribute.path().is_ident("test")) && mentions_test(attribute)
    })
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Mod(i) => &i.attrs,
        Item::Use(i) => &i.attrs,
        Item::Fn(i) => &i.attrs,
        Item::Impl(i) => &i.attrs,
        Item::Struct(i) => &i.attrs,
        Item::Enum(i) => &i.attrs,
        Item::Const(i) => &i.attrs,
        Item::Trait(i) => &i.attrs,
        Item::Type(i) => &i.attrs,
        _ => &[],
    }
}

fn defined_name(item: &Item) -> Option<String> {
    let ident = match item {
        Item::Fn(i) => &i.sig.ident,
        Item::Struct(i) => &i.ident,
        Item::Enum(i) => &i.ident,
        Item::Const(i) => &i.ident,
        Item::Static(i) => &i.ident,
        Item::Trait(i) => &i.ident,
        Item::Type(i) => &i.ident,
        _ => return None,
    };
    Some(ident.to_string())
}

/// The paths that a `use` names, each with its name here; `*` for all names.
fn leaves(tree: &UseTree, path: &mut Vec<String>, found: &mut Vec<(Vec<String>, String)>) {
    match tree {
        UseTree::Path(step) => {
            path.push(step.ident.to_string());
            leaves(&step.tree, path, found);
            path.pop();
        }
        UseTree::Name(name) if name.ident == "self" => {
            found.push((path.clone(), path.last().cloned().unwrap_or_default()));
        }
        UseTree::Name(name) => found.push(([&path[..], &[name.ident.to_string()]].concat(), name.ident.to_string())),
        UseTree::Rename(name) => {
            found.push(([&path[..], &[name.ident.to_string()]].concat(), name.rename.to_string()));
        }
        UseTree::Glob(_) => found.push((path.clone(), "*".to_owned())),
        UseTree::Group(group) => group.items.iter().for_each(|tree| leaves(tree, path, found)),
    }
}

impl Crate {
    fn read(file: &Path) -> Self {
        let mut found = Self::default();
        let items = syn::parse_file(&fs::read_to_string(file).unwrap()).unwrap().items;
        found.add(file, file.parent().unwrap(), 0, items);
        found
    }

    /// Adds a module, whose children lie in `folder`, and all below it.
    fn add(&mut self, file: &Path, folder: &Path, parent: usize, items: Vec<Item>) -> usize {
        let here = self.modules.len();
        let items: Vec<Item> = items
            .into_iter()
            .filter(|item| !is_for_tests(attributes(item)))
            .collect();
        let mut uses = Vec::new();
        for item in &items {
            if let Item::Use(item) = item {
                leaves(&item.tree, &mut Vec::new(), &mut uses);
            }
        }
        let (globs, names): (Vec<_>, Vec<_>) = uses.into_iter().partition(|(_, name)| name == "*");
        let below: Vec<ItemMod> = items
            .iter()
            .filter_map(|item| match item {
                Item::Mod(below) => Some(below.clone()),
                _ => None,
            })
            .collect();
        self.modules.push(Module {
            file: file.to_owned(),
            parent,
            children: BTreeMap::new(),
            names: names.into_iter().map(|(path, name)| (name, path)).collect(),
            globs: globs.into_iter().map(|(path, _)| path).collect(),
            defined: items.iter().filter_map(defined_name).collect(),
            items,
        });
        for item in below {
            let name = item.ident.to_string();
            let deeper = folder.join(&name);
            let child = match item.content {
                Some((_, items)) => self.add(file, &deeper, here, items),
                None => {
                    let places = [deeper.with_extension("rs"), deeper.join("mod.rs")];
                    let at = places.iter().find(|place| place.exists());
                    let Some(at) = at else { continue };
                    let items = syn::parse_file(&fs::read_to_string(at).unwrap()).unwrap().items;
                    self.add(at, &deeper, here, items)
                }
            };
            self.modules[here].children.insert(name, child);
        }
        here
    }

    /// The module in which `path`, as written in module `at`, is defined; `None` for what is not of this crate.
    fn target(&self, at: usize, path: &[String], steps: usize) -> Option<usize> {
        let (first, rest) = path.split_first()?;
        if steps > MAX_STEPS {
            return None;
        }
        let module = &self.modules[at];
        match first.as_str() {
            "crate" => self.within(0, rest, steps),
            "self" => self.within(at, rest, steps),
            "super" => self.within(module.parent, rest, steps),
            name if module.children.contains_key(name) || module.names.contains_key(name) => {
                self.within(at, path, steps)
            }
            _ => None,
        }
    }

    /// The same of a path whose first step is a name of module `at`.
    fn within(&self, at: usize, path: &[String], steps: usize) -> Option<usize> {
        let Some((first, rest)) = path.split_first() else {
            return Some(at);
        };
        let module = &self.modules[at];
        if first == "super" {
            return self.within(module.parent, rest, steps + 1);
        }
        if let Some(&child) = module.children.get(first) {
            return self.within(child, rest, steps + 1);
        }
        if let Some(path) = module.names.get(first) {
            return self.target(at, &[path, rest].concat(), steps + 1);
        }
        if module.defined.contains(first) {
            return Some(at);
        }
        let through = module
            .globs
            .iter()
            .find_map(|glob| self.target(at, &[glob, path].concat(), steps + 1));
        through.or(Some(at))
    }

    fn is_above(&self, above: usize, mut below: usize) -> bool {
        while below != above && below != 0 {
            below = self.modules[below].parent;
        }
        below == above
    }

    /// The files that each file names.
    fn arrows(&self) -> BTreeMap<&Path, BTreeSet<&Path>> {
        let mut arrows: BTreeMap<&Path, BTreeSet<&Path>> = BTreeMap::new();
        for (at, module) in self.modules.iter().enumerate() {
            let mut paths = Paths::default();
            module
                .items
                .iter()
                .filter(|item| !matches!(item, Item::Mod(_)))
                .for_each(|item| paths.visit_item(item));
            for path in paths.0 {
                let Some(to) = self.target(at, &path, 0) else { continue };
                let one_subject = self.is_above(to, at) || self.is_above(at, to);
                if !one_subject && module.file != self.modules[to].file {
                    arrows.entry(&module.file).or_default().insert(&self.modules[to].file);
                }
            }
        }
        arrows
    }
}

/// Every path in some items.
#[derive(Default)]
struct Paths(Vec<Vec<String>>);

impl<'a> Visit<'a> for Paths {
    fn visit_path(&mut self, path: &'a syn::Path) {
        self.0
            .push(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        visit::visit_path(self, path);
    }

    fn visit_item_use(&mut self, item: &'a syn::ItemUse) {
        // What is named to be passed on is not needed here.
        if !matches!(item.vis, syn::Visibility::Inherited) {
            return;
        }
        let mut found = Vec::new();
        leaves(&item.tree, &mut Vec::new(), &mut found);
        self.0.extend(found.into_iter().map(|(path, _)| path));
    }
}

/// The files that can be reached from `from`.
fn reached<'a>(from: &'a Path, arrows: &BTreeMap<&'a Path, BTreeSet<&'a Path>>) -> BTreeSet<&'a Path> {
    let (mut seen, mut next) = (BTreeSet::new(), vec![from]);
    while let Some(file) = next.pop() {
        let new = arrows.get(file).into_iter().flatten().filter(|to| seen.insert(**to));
        next.extend(new.copied());
    }
    seen
}

/// The circles of a crate: the files of each, and the arrows between them in words.
fn circles(file: &Path) -> Vec<(BTreeSet<PathBuf>, String)> {
    let krate = Crate::read(file);
    let arrows = krate.arrows();
    let reach: BTreeMap<&Path, _> = arrows.keys().map(|from| (*from, reached(from, &arrows))).collect();
    let mut named = BTreeSet::new();
    let mut circles = Vec::new();
    for (from, seen) in &reach {
        if !seen.contains(from) || named.contains(from) {
            continue;
        }
        let comes_back = |to: &&Path| reach.get(to).is_some_and(|back| back.contains(from));
        let ring: BTreeSet<&Path> = seen.iter().copied().filter(comes_back).collect();
        let lines = ring.iter().flat_map(|a| {
            let to = arrows[a].iter().filter(|b| ring.contains(*b));
            to.map(|b| format!("  {} -> {}\n", shown(a), shown(b)))
        });
        circles.push((ring.iter().map(|path| path.to_path_buf()).collect(), lines.collect()));
        named.extend(ring);
    }
    circles
}

fn shown(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}

#[test]
fn no_circle_of_files_inside_a_crate() {
    let crates = crate::floors::crate_roots();
    assert!(crates.len() > 15, "found only {}", crates.len());
    let found: Vec<String> = crates
        .iter()
        .flat_map(|file| circles(file))
        .map(|(_, arrows)| arrows)
        .collect();
    assert!(
        found.is_empty(),
        "circles of files that name each other:\n{}",
        found.join("\n")
    );
}

#[test]
fn a_circle_through_names_that_are_passed_on_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    fs::create_dir(folder.path().join("inner")).unwrap();
    write("lib.rs", "mod a; mod inner; pub use a::A;");
    write("a.rs", "use crate::inner::B; pub struct A; pub struct C(B);");
    write("inner/mod.rs", "mod b; pub use b::B;");
    write("inner/b.rs", "pub struct B; pub fn f() { let _ = crate::A; }");
    let found = circles(&folder.path().join("lib.rs"));
    assert_eq!(found.len(), 1);
    let (files, arrows) = &found[0];
    assert!(files.len() == 2 && arrows.contains("a.rs -> "), "{arrows}");
    // For tests alone it is none, and a module may name what is above it.
    write("inner/b.rs", "pub struct B; #[cfg(test)] mod tests { use crate::A; }");
    assert_eq!(circles(&folder.path().join("lib.rs")), Vec::new());
    write("inner/b.rs", "use super::D; pub struct B;");
    write("inner/mod.rs", "mod b; pub use b::B; pub struct D;");
    assert_eq!(circles(&folder.path().join("lib.rs")), Vec::new());
}
