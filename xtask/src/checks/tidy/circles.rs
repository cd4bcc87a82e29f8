//! Files of one crate that need each other in a circle.

use std::collections::{BTreeMap, BTreeSet};

use super::source::{Word, words};

/// A path as it is written, segment by segment.
type Path = Vec<String>;

/// One file of a crate, which is one module.
#[derive(Debug)]
struct Module {
    path: Path,
    file: String,
    defined: BTreeSet<String>,
    /// What names stand for that come from elsewhere.
    imported: BTreeMap<String, Path>,
    /// Every path of more than one name in it, imports among them, whatever its first name stands for.
    named: Vec<Path>,
}

/// Complaints about the circles among the files of a crate, given as names below `src` and their texts.
pub(super) fn complaints(name: &str, files: &[(String, String)]) -> Vec<String> {
    let modules: Vec<Module> = files.iter().map(|(file, text)| module(file, text)).collect();
    let arrows = arrows(&modules);
    let circle = |circle: Vec<usize>| {
        let files: Vec<&str> = circle.iter().map(|&at| modules[at].file.as_str()).collect();
        let inside = |(&(from, to), names): (&(usize, usize), &BTreeSet<String>)| {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            (circle.contains(&from) && circle.contains(&to))
                .then(|| format!("  {} takes {} from {}", modules[from].file, names.join(", "), modules[to].file))
        };
        let ties: Vec<String> = arrows.iter().filter_map(inside).collect();
        format!("{name}: a circle of files: {}\n{}", files.join(", "), ties.join("\n"))
    };
    circles(modules.len(), &arrows).into_iter().map(circle).collect()
}

/// Who takes what from whom, by the file that defines it.
fn arrows(modules: &[Module]) -> BTreeMap<(usize, usize), BTreeSet<String>> {
    let mut arrows: BTreeMap<(usize, usize), BTreeSet<String>> = BTreeMap::new();
    for (from, module) in modules.iter().enumerate() {
        for path in &module.named {
            if let Some(to) = home(modules, from, path, 0).filter(|to| *to != from) {
                let name = path.last().cloned().unwrap_or_default();
                arrows.entry((from, to)).or_default().insert(name);
            }
        }
    }
    arrows
}

/// Longest chain of names that only hand on.
const MOST_TURNS: usize = 16;

/// The module that defines what a path names where it stands in the module `from`; none outside of the crate.
fn home(modules: &[Module], from: usize, path: &[String], turns: usize) -> Option<usize> {
    let find = |path: &[String]| modules.iter().position(|module| module.path == path);
    let (first, mut rest) = path.split_first()?;
    let mut at = match first.as_str() {
        "crate" => find(&[])?,
        "self" => from,
        "super" => find(modules[from].path.split_last()?.1)?,
        child => {
            if let Some(child) = find(&[modules[from].path.as_slice(), &[child.to_owned()]].concat()) {
                child
            } else {
                let imported = modules[from].imported.get(child).filter(|_| turns < MOST_TURNS)?;
                return home(modules, from, &[imported.as_slice(), rest].concat(), turns + 1);
            }
        }
    };
    while let Some((name, others)) = rest.split_first() {
        if name == "super" {
            at = find(modules[at].path.split_last()?.1)?;
        } else if let Some(child) = find(&[modules[at].path.as_slice(), std::slice::from_ref(name)].concat()) {
            at = child;
        } else if modules[at].defined.contains(name) {
            return Some(at);
        } else {
            let handed_on = modules[at].imported.get(name).filter(|_| turns < MOST_TURNS)?;
            let full = [handed_on.as_slice(), others].concat();
            return home(modules, at, &full, turns + 1);
        }
        rest = others;
    }
    Some(at)
}

/// The sets of more than one module that reach each other.
fn circles(n: usize, arrows: &BTreeMap<(usize, usize), BTreeSet<String>>) -> Vec<Vec<usize>> {
    let reached = |start: usize| {
        let mut seen = BTreeSet::new();
        let mut open = vec![start];
        while let Some(at) = open.pop() {
            for &(_, to) in arrows.keys().filter(|(from, _)| *from == at) {
                if seen.insert(to) {
                    open.push(to);
                }
            }
        }
        seen
    };
    let reached: Vec<BTreeSet<usize>> = (0..n).map(reached).collect();
    let mut found: Vec<Vec<usize>> = Vec::new();
    for at in 0..n {
        let circle: Vec<usize> = (0..n).filter(|&b| reached[at].contains(&b) && reached[b].contains(&at)).collect();
        if circle.len() > 1 && circle.first() == Some(&at) {
            found.push(circle);
        }
    }
    found
}

fn module(file: &str, text: &str) -> Module {
    let words = words(text);
    let mut module = Module {
        path: module_path(file),
        file: file.to_owned(),
        defined: BTreeSet::new(),
        imported: BTreeMap::new(),
        named: Vec::new(),
    };
    let mut at = 0;
    while at < words.len() {
        match (&words[at], words.get(at + 1)) {
            (Word::Name(word), _) if word == "use" => {
                at = import(&words, at + 1, &mut Vec::new(), &mut module);
                continue;
            }
            (Word::Name(word), Some(Word::Name(name))) if DEFINING.contains(&word.as_str()) => {
                module.defined.insert(name.clone());
            }
            (Word::Name(_), Some(Word::Sign(':'))) => {
                // What the first name stands for is asked when all files are read: a child, an import, another crate.
                let (path, end) = written_path(&words, at);
                // `pub(in crate::a)` says who may look, not who is needed.
                let is_visibility = words[..at].ends_with(&[Word::Sign('('), Word::Name("in".to_owned())]);
                if path.len() > 1 && !is_visibility {
                    module.named.push(path);
                }
                at = end;
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    module
}

const DEFINING: &[&str] = &["const", "enum", "fn", "macro_rules", "static", "struct", "trait", "type", "union"];

/// The modules from the root down to a file below `src`.
fn module_path(file: &str) -> Path {
    let stem = file.strip_suffix(".rs").unwrap_or(file);
    let mut path: Path = stem.split('/').map(str::to_owned).collect();
    if path.last().is_some_and(|last| last == "mod" || (path.len() == 1 && (last == "lib" || last == "main"))) {
        path.pop();
    }
    path
}

/// A path of names with `::` between them, and where it ends.
fn written_path(words: &[Word], mut at: usize) -> (Path, usize) {
    let mut path = Vec::new();
    while let Some(Word::Name(name)) = words.get(at) {
        path.push(name.clone());
        at += 1;
        if words.get(at) != Some(&Word::Sign(':')) || words.get(at + 1) != Some(&Word::Sign(':')) {
            break;
        }
        at += 2;
    }
    (path, at)
}

/// Reads one branch of a tree of imports; where it ends.
fn import(words: &[Word], mut at: usize, stem: &mut Path, module: &mut Module) -> usize {
    let depth = stem.len();
    let (path, end) = written_path(words, at);
    at = end;
    stem.extend(path);
    match words.get(at) {
        Some(Word::Sign('{')) => {
            while !matches!(words.get(at), None | Some(Word::Sign('}' | ';'))) {
                at = import(words, at + 1, stem, module);
            }
            at += 1;
        }
        Some(Word::Sign('*')) => {
            module.named.push(stem.clone());
            at += 1;
        }
        _ if stem.len() > depth => {
            if stem.last().is_some_and(|last| last == "self") {
                stem.pop();
            }
            let mut name = stem.last().cloned().unwrap_or_default();
            if words.get(at).is_some_and(|word| word.is_name("as")) {
                if let Some(Word::Name(alias)) = words.get(at + 1) {
                    name.clone_from(alias);
                }
                at += 2;
            }
            module.imported.insert(name, stem.clone());
            module.named.push(stem.clone());
        }
        _ => {}
    }
    stem.truncate(depth);
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(files: &[(&str, &str)]) -> Vec<String> {
        let files: Vec<(String, String)> =
            files.iter().map(|(file, text)| ((*file).to_owned(), (*text).to_owned())).collect();
        complaints("a", &files)
    }

    #[test]
    fn files_that_import_each_other_are_found() {
        let found = check(&[
            ("lib.rs", "mod b; mod c;"),
            ("b.rs", "use crate::c::C; pub struct B;"),
            ("c.rs", "pub struct C; fn f(_: crate::b::B) {}"),
        ]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(
            found[0].contains("b.rs takes C from c.rs") && found[0].contains("c.rs takes B from b.rs"),
            "{found:?}"
        );
    }

    #[test]
    fn a_face_that_hands_names_on_is_no_part_of_a_circle() {
        let face = "mod b; mod c; pub use b::B; pub use c::{C as See, D};";
        let free =
            [("lib.rs", face), ("b.rs", "use crate::{See, D}; pub struct B;"), ("c.rs", "pub struct C; struct D;")];
        assert!(check(&free).is_empty(), "{:?}", check(&free));
        let tied =
            [("lib.rs", face), ("b.rs", "use crate::See; pub struct B;"), ("c.rs", "use super::B; pub struct C;")];
        assert_eq!(check(&tied).len(), 1, "through the face");
    }

    #[test]
    fn a_child_that_needs_its_parent_which_needs_it_is_found() {
        let parent = "mod child; use child::f; pub struct P; pub fn g() { f(); }";
        let files = [("lib.rs", "mod p;"), ("p/mod.rs", parent), ("p/child.rs", "use super::P; pub fn f() {}")];
        assert_eq!(check(&files).len(), 1, "p and p/child");
        let tests = "pub fn f() {}\n#[cfg(test)]\nmod tests { use super::super::P; }";
        let files = [("lib.rs", "mod p;"), ("p/mod.rs", parent), ("p/child.rs", tests)];
        assert!(check(&files).is_empty(), "tests may look at anything");
    }

    #[test]
    fn a_path_that_begins_with_a_child_is_read() {
        let parent = "mod child; pub struct P; pub fn g() { child::f(); }";
        let files = [("lib.rs", "mod p;"), ("p/mod.rs", parent), ("p/child.rs", "use super::P; pub fn f() {}")];
        let found = check(&files);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].contains("p/mod.rs takes f from p/child.rs"), "{found:?}");
    }

    #[test]
    fn a_path_that_a_loop_goes_over_is_read_and_one_of_a_visibility_is_not() {
        let parent = ("p/mod.rs", "mod child; pub struct P; pub fn g() { for _ in child::all() {} }");
        let child = ("p/child.rs", "use super::P; pub fn all() -> [P; 0] { [] }");
        assert_eq!(check(&[("lib.rs", "mod p;"), parent, child]).len(), 1, "for _ in child::all()");
        let child = ("p/child.rs", "pub(in crate::p) fn all() -> [u8; 0] { [] }");
        assert!(check(&[("lib.rs", "mod p;"), parent, child]).is_empty(), "pub(in crate::p)");
    }

    #[test]
    fn a_path_that_begins_with_an_imported_module_is_read_through_its_face() {
        let face = "mod b; mod c; pub use b::f;";
        let user = "use crate::face; pub struct C; pub fn g() { let _: u8 = face::f(); }";
        let files = [
            ("lib.rs", "mod face;"),
            ("face/mod.rs", face),
            ("face/b.rs", "use super::c::C; pub fn f() {}"),
            ("face/c.rs", user),
        ];
        let found = check(&files);
        assert!(found.iter().any(|said| said.contains("face/c.rs takes f from face/b.rs")), "{found:?}");
    }

    #[test]
    fn what_a_name_of_another_crate_leads_to_ties_nothing() {
        let files = [
            ("lib.rs", "mod b; mod c;"),
            ("b.rs", "use crate::c::C; use std::fmt; pub struct B; fn f<T: fmt::Display>() { T::c(); B::c(); }"),
            ("c.rs", "use fmt::b; pub struct C; fn f() { b::B::new(); std::b::f(); C::b(); }"),
        ];
        assert!(check(&files).is_empty(), "{:?}", check(&files));
    }

    #[test]
    fn names_from_other_crates_and_comments_tie_nothing() {
        let files = [
            ("lib.rs", "mod b; mod c;"),
            ("b.rs", "use crate::c::C; struct B;"),
            ("c.rs", "//! [`crate::b::B`]\nuse b::B; use std::fmt; struct C;"),
        ];
        assert!(check(&files).is_empty(), "{:?}", check(&files));
    }
}
