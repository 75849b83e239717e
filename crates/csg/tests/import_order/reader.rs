//! Reads which file of a crate takes what from which other one.
//!
//! Only paths are read (`use` and written out, through re-exports to the file that defines the
//! name), not calls of methods; and only what is compiled without tests.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// A module's place under the root of its crate.
type ModulePath = Vec<String>;

/// `from` takes `name` from `to`; both are paths of files under `src`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Import {
    pub from: String,
    pub to: String,
    pub name: String,
}

/// What one module says of others.
#[derive(Default)]
struct Module {
    file: String,
    uses: Vec<Use>,
    /// Paths of two names or more in the code.
    paths: Vec<Vec<String>>,
    /// All names in the code, outside of `use`.
    names: BTreeSet<String>,
}

struct Use {
    path: Vec<String>,
    /// The name it has here.
    alias: String,
    /// Handed on: no import of this file's own unless it mentions the name, too.
    is_reexport: bool,
}

/// The imports between files of a crate, given by their paths under `src` and texts.
pub fn imports(sources: &[(String, String)]) -> Vec<Import> {
    let mut modules = Modules::default();
    for (file, text) in sources {
        let tokens = text
            .parse()
            .unwrap_or_else(|error| panic!("{file} is no Rust: {error}"));
        modules.read(file, &module_of(file), tokens);
    }
    let tests = std::mem::take(&mut modules.tests);
    let is_test = |module: &[String]| tests.iter().any(|test| module.starts_with(test));
    modules.by_path.retain(|path, _| !is_test(path));
    modules.imports()
}

/// `a/b.rs` and `a/b/mod.rs` are both the module `a::b`.
fn module_of(file: &str) -> ModulePath {
    let stem = file.strip_suffix(".rs").expect("a Rust file");
    let mut path: ModulePath = stem.split('/').map(str::to_owned).collect();
    if path.last().is_some_and(|last| last == "mod") || stem == "lib" {
        path.pop();
    }
    path
}

#[derive(Default)]
struct Modules {
    by_path: BTreeMap<ModulePath, Module>,
    /// Modules that are compiled for tests alone.
    tests: Vec<ModulePath>,
}

impl Modules {
    fn read(&mut self, file: &str, path: &ModulePath, tokens: TokenStream) {
        let mut module = Module {
            file: file.to_owned(),
            ..Module::default()
        };
        self.read_items(&mut module, path, &tokens.into_iter().collect::<Vec<_>>());
        self.by_path.insert(path.clone(), module);
    }

    fn read_items(&mut self, module: &mut Module, path: &ModulePath, tokens: &[TokenTree]) {
        let mut at = 0;
        while at < tokens.len() {
            if is_test_attribute(&tokens[at..]) {
                let end = end_of_item(tokens, at + 2);
                if let Some(name) = submodule(&tokens[at + 2..end]) {
                    self.tests.push(child(path, &name));
                }
                at = end;
                continue;
            }
            match &tokens[at] {
                TokenTree::Ident(word) if word == "use" => {
                    let end = end_of_item(tokens, at);
                    let is_reexport = at > 0
                        && (is_word(&tokens[at - 1], "pub")
                            || at > 1 && is_word(&tokens[at - 2], "pub"));
                    let tree = &tokens[at + 1..end - 1];
                    read_use(module, &mut Vec::new(), tree, is_reexport);
                    at = end;
                }
                TokenTree::Ident(word) if word == "mod" => {
                    // A module with its text right here is of this file.
                    if let Some(TokenTree::Group(body)) = tokens.get(at + 2) {
                        let inner = child(path, &tokens[at + 1].to_string());
                        self.read(&module.file, &inner, body.stream());
                    }
                    at = end_of_item(tokens, at);
                }
                TokenTree::Ident(word) if word == "pub" => {
                    at += 1 + usize::from(is_visibility(tokens.get(at + 1)));
                }
                TokenTree::Ident(_) => {
                    let names = path_from(&tokens[at..]);
                    module.names.extend(names.first().cloned());
                    at += 3 * names.len() - 2;
                    if names.len() > 1 {
                        module.paths.push(names);
                    }
                }
                TokenTree::Group(group) => {
                    let inner: Vec<_> = group.stream().into_iter().collect();
                    self.read_items(module, path, &inner);
                    at += 1;
                }
                _ => at += 1,
            }
        }
    }

    fn imports(&self) -> Vec<Import> {
        let mut found = BTreeSet::new();
        for (path, module) in &self.by_path {
            let uses = module
                .uses
                .iter()
                .filter(|taken| !taken.is_reexport || module.names.contains(&taken.alias))
                .map(|taken| &taken.path);
            for names in uses.chain(&module.paths) {
                if let Some((to, name)) = self.definer(path, names, 0)
                    && to != module.file
                {
                    let (from, to) = (module.file.clone(), to.to_owned());
                    found.insert(Import { from, to, name });
                }
            }
        }
        found.into_iter().collect()
    }

    /// The file that defines what `names` lead to from `module`, if it is of this crate, and
    /// what that is called there.
    fn definer(&self, module: &[String], names: &[String], depth: usize) -> Option<(&str, String)> {
        assert!(depth < 32, "{names:?} in {module:?} leads in a circle");
        let mut place = module.to_vec();
        for (index, name) in names.iter().enumerate() {
            match name.as_str() {
                "crate" => place.clear(),
                "self" => {}
                "super" => {
                    place.pop();
                }
                _ if self.by_path.contains_key(&child(&place, name)) => {
                    place.push(name.clone());
                }
                _ => {
                    let here = self.by_path.get(&place)?;
                    // Of `use smallvec::smallvec` the first name is another crate.
                    let is_it = |taken: &&Use| taken.alias == *name && taken.path[0] != *name;
                    if let Some(taken) = here.uses.iter().find(is_it) {
                        let through = [&taken.path[..], &names[index + 1..]].concat();
                        return self.definer(&place, &through, depth + 1);
                    }
                    // A first name that is nothing here is another crate, or a type.
                    return (index > 0).then(|| (here.file.as_str(), name.clone()));
                }
            }
        }
        let name = place.last().cloned().unwrap_or_default();
        self.by_path
            .get(&place)
            .map(|module| (module.file.as_str(), name))
    }
}

fn child(path: &[String], name: &str) -> ModulePath {
    [path, &[name.to_owned()]].concat()
}

fn is_word(token: &TokenTree, word: &str) -> bool {
    matches!(token, TokenTree::Ident(ident) if ident == word)
}

fn is_mark(token: Option<&TokenTree>, mark: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == mark)
}

/// Whether a token behind `pub` is `(crate)`, `(super)` or `(in crate::a)`, not a type.
fn is_visibility(token: Option<&TokenTree>) -> bool {
    let Some(TokenTree::Group(group)) = token else {
        return false;
    };
    let inner: Vec<_> = group.stream().into_iter().collect();
    group.delimiter() == Delimiter::Parenthesis
        && inner
            .first()
            .is_some_and(|first| inner.len() == 1 || is_word(first, "in"))
}

/// Whether `#[cfg(test)]` or `#[test]` begins here.
fn is_test_attribute(tokens: &[TokenTree]) -> bool {
    is_mark(tokens.first(), '#')
        && matches!(tokens.get(1), Some(TokenTree::Group(group))
            if ["cfg (test)", "cfg(test)", "test"].contains(&group.stream().to_string().as_str()))
}

/// Behind the first semicolon or the first body in braces; `use` has braces before its end.
fn end_of_item(tokens: &[TokenTree], from: usize) -> usize {
    let mut is_use = false;
    for (index, token) in tokens.iter().enumerate().skip(from) {
        is_use |= is_word(token, "use");
        let is_body = matches!(token, TokenTree::Group(group)
            if group.delimiter() == Delimiter::Brace);
        if is_mark(Some(token), ';') || is_body && !is_use {
            return index + 1;
        }
    }
    tokens.len()
}

/// The module that an item declares, if it declares one.
fn submodule(item: &[TokenTree]) -> Option<String> {
    let place = item.iter().position(|token| is_word(token, "mod"))?;
    Some(item.get(place + 1)?.to_string())
}

/// The names of a path `a::b::c` that begins here.
fn path_from(tokens: &[TokenTree]) -> Vec<String> {
    let mut names = vec![tokens[0].to_string()];
    let mut rest = &tokens[1..];
    while let [colon, second, TokenTree::Ident(name), ..] = rest
        && is_mark(Some(colon), ':')
        && is_mark(Some(second), ':')
    {
        names.push(name.to_string());
        rest = &rest[3..];
    }
    names
}

/// Reads `a::{b, c::d as e}` behind `before`.
fn read_use(module: &mut Module, before: &mut Vec<String>, tree: &[TokenTree], is_reexport: bool) {
    for branch in tree.split(|token| is_mark(Some(token), ',')) {
        let known = before.len();
        let mut alias = None;
        let mut is_tree = branch.is_empty();
        for (index, token) in branch.iter().enumerate() {
            match token {
                TokenTree::Ident(word) if word == "as" => {
                    alias = branch.get(index + 1).map(ToString::to_string);
                    break;
                }
                TokenTree::Ident(word) => before.push(word.to_string()),
                TokenTree::Group(group) => {
                    let inner: Vec<_> = group.stream().into_iter().collect();
                    read_use(module, before, &inner, is_reexport);
                    is_tree = true;
                }
                _ => {}
            }
        }
        if !is_tree {
            if before.last().is_some_and(|last| last == "self") && before.len() > 1 {
                before.pop();
            }
            module.uses.push(Use {
                alias: alias.unwrap_or_else(|| before[before.len() - 1].clone()),
                path: before.clone(),
                is_reexport,
            });
        }
        before.truncate(known);
    }
}
