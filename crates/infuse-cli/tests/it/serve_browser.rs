//! The page in a real browser: what only that can show.

use std::io::Write as _;
use std::process::Command;

use tempfile::TempDir;

use crate::rig::Rig;
use crate::served::Served;

/// What the browser makes of an address.
fn shown(browser: &str, url: &str) -> String {
    let folder = TempDir::new().unwrap();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run"])
        .args(["--disable-component-update", "--disable-sync", "--dump-dom"])
        .arg(format!("--user-data-dir={}", folder.path().display()))
        .arg(url)
        .output()
        .unwrap();
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The cookie comes with the redirection, and the style is loaded under the policy; a form of the page is sent with its
/// origin, which another page can't do.
#[test]
fn a_browser_is_let_in_by_the_address_alone() {
    let browsers = ["chromium", "chromium-browser", "google-chrome"];
    let Some(browser) = browsers.into_iter().find(|name| Command::new(name).arg("--version").output().is_ok()) else {
        // Said aloud, past the capture of the test harness.
        let _ = writeln!(std::io::stderr(), "skipped: there is no chromium to try the page with");
        return;
    };
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    let served = Served::new(&rig);
    let page = shown(browser, &served.url());
    assert!(page.contains("id=\"row-1\"") && page.contains("Run the experiments below"), "{page}");
    assert!(!shown(browser, &format!("http://127.0.0.1:{}/", served.port)).contains("row-1"), "no token, no page");
    // Another page with a form to this one, sent by its own script.
    let html = format!(
        "<form id=f method=post action=\"http://127.0.0.1:{}/ask\"></form><script>f.submit()</script>",
        served.port
    );
    rig.write("evil.html", &html);
    let evil = shown(browser, &format!("file://{}", rig.path("evil.html").display()));
    assert!(!evil.contains("row-1"), "{evil}");
}
