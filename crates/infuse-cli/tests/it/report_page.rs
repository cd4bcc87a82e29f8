//! What the claims about both kinds of reports share.

use crate::rig::Rig;

/// Text that a careless page would obey.
pub(crate) const EVIL: &str = "<i>&\"'";

pub(crate) fn page(rig: &Rig) -> String {
    rig.infuse(&["report"]).ok();
    rig.read("report.html")
}

/// The cells of the rows of a table, found by a part of its caption.
pub(crate) fn table(page: &str, caption: &str) -> Vec<Vec<String>> {
    let from = page.find(caption).unwrap();
    let body = page[from..].split_once("<tbody>").unwrap().1.split_once("</tbody>").unwrap().0;
    let inner = |cell: &str| cell.split_once('>').unwrap().1.split_once("</td>").unwrap().0.to_owned();
    body.split("<tr>").skip(1).map(|row| row.split("<td").skip(1).map(inner).collect()).collect()
}

/// That a report made anew is the same, on one thread too, and does not say where its folder is.
#[track_caller]
pub(crate) fn assert_gives_the_same_bytes(rig: &Rig) {
    let first = page(rig);
    assert_eq!(first, page(rig));
    let said = rig.command(&["report", "--output", "other.html"]).env("RAYON_NUM_THREADS", "1").output().unwrap();
    assert!(said.status.success());
    assert_eq!(first, rig.read("other.html"), "on one thread");
    assert!(!first.contains(&rig.folder().display().to_string()), "the folder may be anywhere");
}
