//! What pages in Markdown must keep to: no cell that nobody reads, no test that is not there, front pages that fit.

use std::collections::BTreeSet;

/// Longest text of a cell.
const LONGEST_CELL: usize = 200;
/// Most lines of the README of a crate.
const FRONT_PAGE: usize = 120;

/// Complaints about one page.
pub(super) fn complaints(name: &str, text: &str) -> Vec<String> {
    let mut complaints = Vec::new();
    for (number, line) in text.lines().enumerate().filter(|(_, line)| line.starts_with('|')) {
        let longest = line.split('|').map(|cell| cell.trim().chars().count()).max().unwrap_or(0);
        if longest > LONGEST_CELL {
            complaints.push(format!("{name}:{}: a cell of {longest} characters, at most {LONGEST_CELL}", number + 1));
        }
    }
    let lines = text.lines().count();
    if name.starts_with("crates/") && name.ends_with("README.md") && lines > FRONT_PAGE {
        complaints.push(format!("{name}: {lines} lines, a front page has at most {FRONT_PAGE}"));
    }
    complaints
}

/// The page with the table of crates.
pub(super) const FRONT: &str = "README.md";

/// Complaints about the table of crates: a row for each of these folders, given from the root, and no other.
pub(super) fn crate_rows(text: &str, folders: &[String]) -> Vec<String> {
    // `| [`name`](folder) | what it does |`
    let folder = |line: &str| {
        let (name, rest) = line.strip_prefix("| [`")?.split_once("`](")?;
        let (folder, _) = rest.split_once(") |")?;
        (folder == "xtask" || folder.starts_with("crates/")).then(|| (name.to_owned(), folder.to_owned()))
    };
    let rows: Vec<(String, String)> = text.lines().filter_map(folder).collect();
    let missing = folders.iter().filter(|folder| !rows.iter().any(|(_, row)| row == *folder));
    let mut complaints: Vec<String> =
        missing.map(|folder| format!("{FRONT}: `{folder}` is not in the table of crates")).collect();
    for (index, (name, folder)) in rows.iter().enumerate() {
        if !folders.contains(folder) {
            complaints.push(format!("{FRONT}: `{folder}` is in the table of crates and not in the tree"));
        } else if folder.rsplit('/').next() != Some(name) {
            complaints.push(format!("{FRONT}: the table of crates calls `{folder}` `{name}`"));
        }
        if rows[..index].iter().any(|(_, other)| other == folder) {
            complaints.push(format!("{FRONT}: `{folder}` is twice in the table of crates"));
        }
    }
    complaints
}

/// Complaints about tests that a page names and no crate has, given all sources of tests by their names from the root.
pub(super) fn missing_tests(name: &str, text: &str, sources: &[(String, String)]) -> Vec<String> {
    let crates: BTreeSet<&str> =
        sources.iter().filter_map(|(file, _)| file.strip_prefix("crates/")?.split('/').next()).collect();
    let quoted = text.split('`').skip(1).step_by(2);
    let mut strangers = Vec::new();
    let named = quoted.filter_map(|quoted| {
        // `crate::module::function`, or `crate: module::function`.
        let (package, rest) = quoted.split_once(": ").or_else(|| quoted.split_once("::"))?;
        let package = package.replace('_', "-");
        let (module, function) = rest.rsplit_once("::")?;
        let is_test = function.contains('_') && !module.contains(char::is_uppercase);
        let is_ours = crates.contains(package.as_str());
        let is_crate = quoted.contains(": ") && package.chars().all(|c| c.is_ascii_lowercase() || c == '-');
        if is_test && is_crate && !is_ours {
            strangers.push(format!("{name}: there is no crate of the test `{quoted}`"));
        }
        (is_test && is_ours).then_some((quoted, package, function))
    });
    let is_missing = |(_, package, function): &(&str, String, &str)| {
        let head = format!("fn {function}(");
        let folder = format!("crates/{package}/");
        !sources.iter().any(|(file, text)| file.starts_with(&folder) && text.contains(&head))
    };
    let missing = named.filter(is_missing).map(|(quoted, ..)| format!("{name}: there is no test `{quoted}`"));
    let missing: Vec<String> = missing.collect();
    missing.into_iter().chain(strangers).collect()
}

/// Complaints about files and folders that the map of the code names and that are not there, given all names from the root.
pub(super) fn missing_places(name: &str, text: &str, names: &[&str]) -> Vec<String> {
    let mut complaints = Vec::new();
    let mut source = None;
    for line in text.lines() {
        if let Some(heading) = line.strip_prefix("### ") {
            source = heading.split('`').nth(1).map(|package| format!("{package}/src/"));
        } else if line.starts_with("## ") {
            source = None;
        }
        let Some(source) = source.as_ref().filter(|_| line.starts_with('|')) else {
            continue;
        };
        let first = line.split('|').nth(1).unwrap_or_default();
        for place in first.split('`').skip(1).step_by(2) {
            let whole = format!("{source}{place}");
            let is_there =
                names.iter().any(|name| *name == whole || (whole.ends_with('/') && name.starts_with(&whole)));
            if !is_there {
                complaints.push(format!("{name}: there is no {whole}"));
            }
        }
    }
    complaints
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_crates_has_a_row_for_each_folder_and_no_other() {
        let page = |rows: &[&str]| format!("# Title\n\n| crate | what it does |\n|---|---|\n{}\n", rows.join("\n"));
        let [doe, xtask] = ["| [`doe`](crates/doe) | designs |", "| [`xtask`](xtask) | starts the studies |"];
        let folders = ["crates/doe", "xtask"].map(str::to_owned);
        let complaints = |rows: &[&str]| crate_rows(&page(rows), &folders);
        let link = "| [`results`](docs/results.md) | no crate |";
        assert_eq!(complaints(&[doe, xtask, link]), Vec::<String>::new());
        assert_eq!(complaints(&[xtask]), ["README.md: `crates/doe` is not in the table of crates"]);
        let gone = "| [`grid`](crates/grid) | cells |";
        assert_eq!(
            complaints(&[doe, gone, xtask]),
            ["README.md: `crates/grid` is in the table of crates and not in the tree"]
        );
        let renamed = "| [`designs`](crates/doe) | designs |";
        assert_eq!(complaints(&[renamed, xtask]), ["README.md: the table of crates calls `crates/doe` `designs`"]);
        assert_eq!(complaints(&[doe, xtask, doe]), ["README.md: `crates/doe` is twice in the table of crates"]);
    }

    #[test]
    fn long_cells_and_long_front_pages_are_found() {
        let row = |length: usize| format!("| a | {} |\n", "x".repeat(length));
        assert!(complaints("docs/a.md", &row(LONGEST_CELL)).is_empty(), "as long as allowed");
        assert_eq!(complaints("docs/a.md", &row(LONGEST_CELL + 1)).len(), 1, "longer");
        let page = "a\n".repeat(FRONT_PAGE + 1);
        assert_eq!(complaints("crates/a/README.md", &page).len(), 1, "a manual");
        assert!(complaints("docs/a.md", &page).is_empty(), "not a front page");
    }

    #[test]
    fn places_that_are_not_there_are_found() {
        let names = ["crates/a/src/b.rs", "crates/a/src/c/d.rs"];
        let map = |places: &str| format!("### `crates/a`: all\n| {places} | `none.rs` |\n\n## Else\n| `e.rs` | x |\n");
        assert!(missing_places("m", &map("`b.rs`, `c/`, `c/d.rs`"), &names).is_empty(), "as it should be");
        assert_eq!(missing_places("m", &map("`b.rs`, `f.rs`"), &names), ["m: there is no crates/a/src/f.rs"]);
    }

    #[test]
    fn tests_that_are_not_there_are_found() {
        let sources = [("crates/a-b/tests/it/c.rs".to_owned(), "fn it_holds() {}".to_owned())];
        let check = |text: &str| missing_tests("docs/checks.md", text, &sources);
        assert_eq!(check("`a-b: c::it_fails`").len(), 1, "in the other form");
        assert!(
            check("`a_b::c::it_holds`, `a-b: c::it_holds`, `a_b::Type::new`, `std::mem::size_of`").is_empty(),
            "as it should be"
        );
        assert_eq!(check("`a_b::c::it_fails`"), ["docs/checks.md: there is no test `a_b::c::it_fails`"]);
    }
}
