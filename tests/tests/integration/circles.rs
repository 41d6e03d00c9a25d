//! No circles between the files of a crate: what two files need from each other is a third thing, or they are one file.
//!
//! A file needs another one where a `use` or a path in it leads to what is defined there, through any re-exports in between. What is
//! under `#[cfg(test)]` does not count, and neither do `mod` lines and re-exports themselves: a module may show what its files have.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use sinew_tests::checkout;

/// Where a module stands in its crate; empty is the root.
type Module = Vec<String>;

/// What a file says about others.
#[derive(Debug, Default)]
struct Source {
    path: PathBuf,
    /// Modules that are files of their own.
    modules: Vec<String>,
    uses: Vec<Use>,
    /// Paths of more than one word.
    paths: Vec<Vec<String>>,
    /// What is defined in it.
    items: BTreeSet<String>,
}

/// One name that a `use` brings; `*` = all there are.
#[derive(Debug)]
struct Use {
    path: Vec<String>,
    name: String,
    /// Shown to others: `pub use`.
    shown: bool,
}

fn word(token: Option<&TokenTree>) -> Option<String> {
    match token {
        Some(TokenTree::Ident(ident)) => Some(ident.to_string()),
        _ => None,
    }
}

fn is_sign(token: Option<&TokenTree>, sign: char) -> bool {
    matches!(token, Some(TokenTree::Punct(found)) if found.as_char() == sign)
}

/// Whether `::` is at this place.
fn is_step(tokens: &[TokenTree], at: usize) -> bool {
    is_sign(tokens.get(at), ':') && is_sign(tokens.get(at + 1), ':')
}

/// Where the item that begins here ends.
fn end_of_item(tokens: &[TokenTree], from: usize) -> usize {
    let is_use = tokens[from..].iter().take(3).any(|token| word(Some(token)).as_deref() == Some("use"));
    let is_body = |token: &TokenTree| matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace);
    let last = |token: &TokenTree| is_sign(Some(token), ';') || (!is_use && is_body(token));
    tokens[from..].iter().position(last).map_or(tokens.len(), |at| from + at + 1)
}

impl Source {
    /// Takes in what stands here and in the groups below.
    fn read(&mut self, stream: TokenStream) {
        let tokens: Vec<TokenTree> = stream.into_iter().collect();
        let mut at = 0;
        while let Some(token) = tokens.get(at) {
            at = match token {
                TokenTree::Punct(_) if is_sign(Some(token), '#') => self.attribute(&tokens, at),
                TokenTree::Group(group) => {
                    self.read(group.stream());
                    at + 1
                }
                TokenTree::Ident(ident) => self.word(&tokens, at, &ident.to_string()),
                _ => at + 1,
            };
        }
    }

    /// Passes over an attribute, and over what it makes a part of the tests.
    fn attribute(&self, tokens: &[TokenTree], at: usize) -> usize {
        match tokens.get(at + 1).map(ToString::to_string) {
            Some(text) if text.replace(' ', "") == "[cfg(test)]" => end_of_item(tokens, at + 2),
            _ => at + 2,
        }
    }

    /// Takes in what begins with a word; where it ends.
    fn word(&mut self, tokens: &[TokenTree], at: usize, first: &str) -> usize {
        let next = word(tokens.get(at + 1));
        match (first, next) {
            ("use", _) => {
                let end = end_of_item(tokens, at);
                let is_shown = |token: &TokenTree| word(Some(token)).as_deref() == Some("pub");
                let shown = tokens[at.saturating_sub(2)..at].iter().any(is_shown);
                self.tree(&tokens[at + 1..end], &[], shown);
                end
            }
            ("mod", Some(name)) if is_sign(tokens.get(at + 2), ';') => {
                self.modules.push(name);
                at + 3
            }
            ("struct" | "enum" | "union" | "trait" | "type" | "fn" | "const" | "static" | "mod", Some(name)) => {
                self.items.insert(name);
                at + 2
            }
            _ => {
                let mut path = vec![first.to_string()];
                let mut end = at + 1;
                while let Some(next) = word(tokens.get(end + 2)).filter(|_| is_step(tokens, end)) {
                    path.push(next);
                    end += 3;
                }
                if path.len() > 1 {
                    self.paths.push(path);
                }
                end
            }
        }
    }

    /// Takes in the names of a `use`: `a::b`, `a as b`, `a::{b, c::d}`, `a::*`.
    fn tree(&mut self, tokens: &[TokenTree], before: &[String], shown: bool) {
        for branch in tokens.split(|token| is_sign(Some(token), ',') || is_sign(Some(token), ';')) {
            let mut path = before.to_vec();
            let mut name = None;
            let mut at = 0;
            while let Some(token) = branch.get(at) {
                match token {
                    TokenTree::Group(group) => {
                        let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                        self.tree(&inner, &path, shown);
                        path.clear();
                    }
                    TokenTree::Ident(ident) if ident == "as" => {
                        name = word(branch.get(at + 1));
                        at += 1;
                    }
                    TokenTree::Ident(ident) if ident == "self" && !path.is_empty() => {}
                    TokenTree::Ident(ident) => path.push(ident.to_string()),
                    _ if is_sign(Some(token), '*') => name = Some("*".into()),
                    _ => {}
                }
                at += 1;
            }
            if let Some(last) = path.last().cloned() {
                self.uses.push(Use { name: name.unwrap_or(last), path, shown });
            }
        }
    }
}

/// The files of a crate.
type Files = BTreeMap<Module, Source>;

/// Reads a module's file and those of its modules.
fn load(files: &mut Files, module: Module, path: PathBuf) {
    let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut source = Source::default();
    source.read(text.parse().unwrap_or_else(|e| panic!("{}: {e}", path.display())));
    let is_head = path.file_stem().is_some_and(|stem| ["lib", "main", "mod"].iter().any(|head| stem == *head));
    let folder = if is_head { path.parent().expect("in a folder").to_path_buf() } else { path.with_extension("") };
    for name in source.modules.clone() {
        let inner = [module.as_slice(), std::slice::from_ref(&name)].concat();
        let places = [folder.join(format!("{name}.rs")), folder.join(&name).join("mod.rs")];
        let place = places.into_iter().find(|place| place.is_file());
        load(files, inner, place.unwrap_or_else(|| panic!("{}: no file of module {name}", path.display())));
    }
    source.path = path;
    files.insert(module, source);
}

/// The module whose file defines what a path in `module` leads to; `None` = another crate's. `steps` bounds how often re-exports are
/// followed.
fn leads_to(files: &Files, module: &Module, path: &[String], steps: usize) -> Option<Module> {
    let (first, mut rest) = path.split_first()?;
    let steps = steps.checked_sub(1)?;
    let mut at = match first.as_str() {
        "crate" => Module::new(),
        "self" => module.clone(),
        "super" => module.split_last()?.1.to_vec(),
        _ => {
            rest = path;
            module.clone()
        }
    };
    let is_named = rest.len() < path.len();
    while let Some((next, after)) = rest.split_first() {
        let inner = [at.as_slice(), std::slice::from_ref(next)].concat();
        let source = &files[&at];
        if next == "super" {
            at.pop();
        } else if files.contains_key(&inner) {
            at = inner;
        } else if let Some(used) = source.uses.iter().find(|used| used.name == *next) {
            let is_foreign = used.path.first() == Some(next) && used.path.len() == 1;
            let onward = [used.path.as_slice(), after].concat();
            return if is_foreign { None } else { leads_to(files, &at, &onward, steps) };
        } else if source.items.contains(next) {
            return Some(at);
        } else {
            let globs = source.uses.iter().filter(|used| used.name == "*");
            let mut behind = globs.filter_map(|used| leads_to(files, &at, &used.path, steps));
            return behind.find(|module| files[module].items.contains(next)).or(is_named.then_some(at));
        }
        rest = after;
    }
    Some(at)
}

/// Which modules each one needs.
fn needs(files: &Files) -> BTreeMap<&Module, BTreeSet<Module>> {
    let of = |(module, source): (&'_ Module, &Source)| -> BTreeSet<Module> {
        let used = source.uses.iter().filter(|used| !used.shown).map(|used| &used.path);
        let found = used.chain(&source.paths).filter_map(|path| leads_to(files, module, path, 8));
        found.filter(|other| other != module).collect()
    };
    files.iter().map(|(module, source)| (module, of((module, source)))).collect()
}

/// Files that need each other, each with those of the others that it needs itself.
type Circle = BTreeMap<String, Vec<String>>;

/// Groups of files of this crate, each of which needs all the others of its group, as paths in its `src`.
fn circles(root: &Path) -> BTreeSet<Circle> {
    let mut files = Files::new();
    load(&mut files, Module::new(), root.to_path_buf());
    let needs = needs(&files);
    let reaches = |from: &Module| -> BTreeSet<Module> {
        let mut found = BTreeSet::new();
        let mut next: Vec<&Module> = vec![from];
        while let Some(module) = next.pop() {
            next.extend(needs[module].iter().filter(|other| found.insert((*other).clone())));
        }
        found
    };
    let reach: BTreeMap<&Module, BTreeSet<Module>> = files.keys().map(|module| (module, reaches(module))).collect();
    let name = |module: &Module| -> String {
        let path = files[module].path.strip_prefix(root.parent().expect("in a folder")).expect("below it");
        path.display().to_string()
    };
    let circle_of = |module: &Module| -> Circle {
        let is_in = |other: &&Module| reach[module].contains(*other) && reach[*other].contains(module);
        let needed = |one: &Module| needs[one].iter().filter(is_in).map(name).collect();
        reach[module].iter().filter(is_in).map(|one| (name(one), needed(one))).collect()
    };
    files.keys().filter(|module| reach[module].contains(*module)).map(circle_of).collect()
}

/// Every `lib.rs` and `main.rs` of the workspace.
fn roots() -> Vec<PathBuf> {
    let manifest = fs::read_to_string(checkout().join("Cargo.toml")).expect("it is in the checkout");
    let manifest: toml::Table = manifest.parse().expect("TOML");
    let members = manifest["workspace"]["members"].as_array().expect("a list");
    let folders = members.iter().map(|member| checkout().join(member.as_str().expect("a folder")).join("src"));
    folders
        .flat_map(|folder| ["lib.rs", "main.rs"].map(|root| folder.join(root)))
        .filter(|root| root.is_file())
        .collect()
}

#[test]
fn no_two_files_of_a_crate_need_each_other() {
    let mut found = String::new();
    for root in roots() {
        let folder = root.ancestors().nth(2).and_then(|folder| folder.strip_prefix(checkout()).ok()).expect("a crate");
        for circle in circles(&root) {
            let files = circle.iter().map(|(file, needs)| format!("\n  {file} needs {}", needs.join(", ")));
            found += &format!("{}: these files need each other{}\n", folder.display(), files.collect::<String>());
        }
    }
    assert!(found.is_empty(), "{found}What two files need from each other is a third thing, or they are one file.");
}

#[test]
fn a_circle_is_found_through_what_a_module_shows_and_not_in_its_tests() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |file: &str, text: &str| fs::write(folder.path().join(file), text).expect("the folder is writable");
    let found = || circles(&folder.path().join("lib.rs"));
    write("lib.rs", "mod a;\nmod b;\npub use a::{A, other as same};\n");
    write("a.rs", "use super::b::{self, B};\npub struct A(B);\npub fn other() { b::f() }\n");
    write("b.rs", "pub struct B;\npub fn f() {}\n#[cfg(test)]\nmod tests {\n    use crate::A;\n}\n");
    assert!(found().is_empty(), "{:?}", found());
    for needs in ["use crate::A;", "fn g() { crate::same() }", "fn g() -> Vec<super::a::A> { vec![] }"] {
        write("b.rs", &format!("pub struct B;\npub fn f() {{}}\n{needs}\n"));
        let both =
            Circle::from([("a.rs", "b.rs"), ("b.rs", "a.rs")].map(|(one, other)| (one.into(), vec![other.into()])));
        assert_eq!(found(), BTreeSet::from([both]), "{needs}");
    }
}
