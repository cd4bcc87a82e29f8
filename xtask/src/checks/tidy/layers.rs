//! The crates in layers: each may use what lies below it, and of that exactly what the table says.

use toml::{Table, Value};

/// A crate on its layer, with the crates of the workspace that it uses.
struct Room {
    layer: u32,
    name: &'static str,
    uses: &'static [&'static str],
}

const fn room(layer: u32, name: &'static str, uses: &'static [&'static str]) -> Room {
    Room { layer, name, uses }
}

/// Exactly these arrows, in any kind of dependency; each from a layer to a lower one.
const ROOMS: &[Room] = &[
    room(6, "xtask", &[]),
    room(
        5,
        "studies",
        &[
            "bat-dynamics",
            "design-space",
            "doe",
            "infuse",
            "page",
            "quarter-car",
            "scaling",
            "surface",
            "tether-control",
            "water-channel",
        ],
    ),
    room(5, "infuse-cli", &["design-space", "infuse", "page", "surface"]),
    room(5, "infuse-python", &["bat-dynamics", "design-space", "doe", "infuse", "surface", "water-channel"]),
    room(4, "infuse", &["design-space", "doe", "surface"]),
    room(4, "page", &[]),
    room(3, "surface", &["design-space", "doe"]),
    room(2, "doe", &["design-space"]),
    room(2, "water-channel", &["bat-dynamics", "scaling", "tether-control"]),
    room(1, "design-space", &[]),
    room(1, "bat-dynamics", &[]),
    room(1, "quarter-car", &[]),
    room(1, "tether-control", &[]),
    room(1, "scaling", &[]),
];

/// The page with the drawing, which has a row for each crate.
pub(super) const PAGE: &str = "docs/architecture.md";

/// Complaints about the dependencies of a crate.
pub(super) fn complaints(name: &str, manifest: &Table) -> Vec<String> {
    let Some(room) = ROOMS.iter().find(|room| room.name == name) else {
        return vec![format!("{name}: on no layer")];
    };
    let mut found = Vec::new();
    collect_dependencies(manifest, &mut found);
    found.retain(|dependency| ROOMS.iter().any(|room| room.name == dependency));
    let extra = found.iter().filter(|found| !room.uses.contains(&found.as_str()));
    let missing = room.uses.iter().filter(|uses| !found.iter().any(|found| found == *uses));
    extra
        .map(|to| format!("{name}: must not depend on {to}"))
        .chain(missing.map(|to| format!("{name}: the table says it depends on {to}, but it does not")))
        .collect()
}

/// Complaints about the page that shows the layers.
pub(super) fn page_complaints(texts: &[(String, String)]) -> Vec<String> {
    let page = texts.iter().find(|(name, _)| name == PAGE).map_or("", |(_, text)| text.as_str());
    let missing = ROOMS.iter().map(row).filter(|row| !page.lines().any(|line| line == row));
    missing.map(|row| format!("{PAGE}: no row `{row}`")).collect()
}

/// A crate in the table of the page.
fn row(Room { layer, name, uses }: &Room) -> String {
    let uses: Vec<String> = uses.iter().map(|uses| format!("`{uses}`")).collect();
    format!("| {layer} | `{name}` | {} |", if uses.is_empty() { "–".to_owned() } else { uses.join(", ") })
}

/// The names under every table that ends in `dependencies`, also those of one target only.
fn collect_dependencies(table: &Table, found: &mut Vec<String>) {
    for (key, value) in table {
        let Value::Table(inner) = value else {
            continue;
        };
        if key.ends_with("dependencies") {
            found.extend(inner.keys().cloned());
        } else {
            collect_dependencies(inner, found);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_arrow_goes_up() {
        for from in ROOMS {
            for to in from.uses {
                let to = ROOMS.iter().find(|room| room.name == *to).expect("a crate of the table");
                assert!(to.layer < from.layer, "{} uses {}", from.name, to.name);
            }
        }
    }

    #[test]
    fn wrong_arrows_are_found() {
        let check = |name: &str, manifest: &str| complaints(name, &manifest.parse().expect("a manifest")).join("\n");
        assert_eq!(check("doe", "[dependencies]\ndesign-space.workspace = true\nserde = \"1\""), "");
        assert_eq!(
            check("page", "[dev-dependencies]\ninfuse = { path = \"../infuse\" }"),
            "page: must not depend on infuse"
        );
        assert_eq!(
            check("page", "[target.'cfg(unix)'.dependencies]\ninfuse = \"1\""),
            "page: must not depend on infuse"
        );
        assert_eq!(check("doe", "[dependencies]"), "doe: the table says it depends on design-space, but it does not");
        assert_eq!(check("new", ""), "new: on no layer");
    }

    #[test]
    fn a_row_that_the_page_lacks_is_found() {
        let page: String = ROOMS.iter().map(|room| row(room) + "\n").collect();
        assert!(page_complaints(&[(PAGE.to_owned(), page.clone())]).is_empty(), "all rows");
        let without = page.replace(&row(&ROOMS[1]), "");
        assert_eq!(page_complaints(&[(PAGE.to_owned(), without)]).len(), 1, "one row less");
    }
}
