//! The page beside the rig: who may ask it, what it takes, and what it keeps.

use std::io::Write as _;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::rig::{Rig, measured, told};
use crate::served::{Answer, Served, answer, field};

/// A campaign whose first batch was asked for in the shell.
fn asked() -> (Rig, Served) {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    let served = Served::new(&rig);
    (rig, served)
}

/// Types a value, a reason and a note into the row of an experiment on this page, and saves.
fn tell(served: &Served, page: &str, id: u64, row: (&str, &str, &str)) -> Answer {
    let fields = row_of(page, id, row);
    let fields: Vec<(&str, &str)> = fields.iter().map(|(name, value)| (&**name, &**value)).collect();
    served.post("/tell", &fields)
}

/// The fields of this row.
pub(crate) fn row_of(page: &str, id: u64, (value, failed, note): (&str, &str, &str)) -> [(String, String); 6] {
    let name = |place: usize| format!("cell-{id}-{place}");
    [
        (format!("was-{id}"), field(page, &format!("was-{id}"))),
        (name(0), value.to_owned()),
        (name(1), failed.to_owned()),
        (name(2), field(page, &name(2))),
        (name(3), String::new()),
        (name(4), note.to_owned()),
    ]
}

#[test]
fn only_who_has_the_token_is_answered() {
    let (_rig, served) = asked();
    let host = format!("Host: 127.0.0.1:{}\r\n", served.port);
    for (path, cookie) in [
        ("/", String::new()),
        ("/?token=wrong", String::new()),
        ("/status.json", format!("Cookie: infuse-{}={}0\r\n", served.port, served.token)),
        ("/report", format!("Cookie: infuse-1={}\r\n", served.token)),
        ("/style.css", String::new()),
    ] {
        let refused = served.raw(format!("GET {path} HTTP/1.1\r\n{host}{cookie}\r\n").as_bytes());
        assert_eq!(refused.status, 403, "{path}");
        assert!(!refused.body.contains("spring") && !refused.body.contains(&served.token), "{}", refused.body);
    }
    let first = served.raw(format!("GET /?token={} HTTP/1.1\r\n{host}\r\n", served.token).as_bytes());
    assert_eq!(first.status, 303);
    assert!(first.head.contains("\r\nLocation: /\r\n"), "the token leaves the address: {}", first.head);
    for word in ["HttpOnly", "SameSite=Strict", &format!("infuse-{}={};", served.port, served.token)] {
        assert!(first.head.contains(word), "{word}: {}", first.head);
    }
    let page = served.get("/");
    assert_eq!(page.status, 200);
    assert!(page.head.contains("default-src 'none'") && !page.head.to_lowercase().contains("access-control"));
    assert!(!page.body.contains("<script") && !page.body.contains("http://"), "nothing from elsewhere, no script");
    assert_eq!(served.get("/nowhere").status, 404);
    assert_eq!(served.get("/tell").status, 405);
}

#[test]
fn other_pages_of_the_browser_are_refused() {
    let (rig, served) = asked();
    let cookie = format!("Cookie: infuse-{}={}\r\n", served.port, served.token);
    for host in ["evil.example", "127.0.0.1", "127.0.0.1:1", "evil.example:80"] {
        let refused = served.raw(format!("GET / HTTP/1.1\r\nHost: {host}\r\n{cookie}\r\n").as_bytes());
        assert_eq!(refused.status, 403, "{host}");
    }
    assert_eq!(served.raw(format!("GET / HTTP/1.1\r\n{cookie}\r\n").as_bytes()).status, 400, "no host");
    let other_port = "Origin: http://127.0.0.1:1\r\n";
    for header in ["Origin: http://evil.example\r\n", "Origin: null\r\n", other_port, "Sec-Fetch-Site: cross-site\r\n"]
    {
        for path in ["/tell", "/undo", "/ask", "/confirm"] {
            assert_eq!(served.post_with(path, &[("lines", "1")], header).status, 403, "{path} {header}");
        }
    }
    assert_eq!(served.post_with("/tell", &[], "Sec-Fetch-Site: same-site\r\n").status, 403);
    assert_eq!(served.post_with("/tell", &[], "Sec-Fetch-Site: same-origin\r\n").status, 303);
    assert!(told(&rig.journal()).is_empty());
}

#[test]
fn a_token_may_come_from_a_file() {
    let rig = Rig::pooled();
    rig.write("token", "a-secret-of-my-own_1\n");
    assert_eq!(Served::with(&rig, &["--token-file", "token"]).token, "a-secret-of-my-own_1");
    for (text, words) in [("short", "16 to 256"), ("sixteen letters and blanks", "16 to 256")] {
        rig.write("token", text);
        assert!(rig.infuse(&["serve", "--token-file", "token"]).error().contains(words), "{text}");
    }
    assert!(rig.infuse(&["serve", "--token-file", "none"]).error().contains("none"));
    assert!(Rig::empty().infuse(&["serve"]).error().contains("campaign.toml"));
}

#[test]
fn a_batch_is_asked_for_filled_in_and_followed_by_the_next() {
    let rig = Rig::pooled();
    let served = Served::new(&rig);
    assert!(served.get("/").body.contains("Choose the next experiments"));
    let mut page = served.ask();
    assert!(rig.path("sheet-1.csv").exists(), "the sheet of the shell is there, too");
    for id in 1..=10 {
        let settings: Value = serde_json::from_str(&field(&page, &format!("was-{id}"))).unwrap();
        let setting = |index: usize| settings[0][index].as_str().unwrap().parse().unwrap();
        let saved = tell(&served, &page, id, (&measured(id, setting(0), setting(1)), "", ""));
        assert_eq!(saved.status, 303, "{}", saved.body);
        page = served.get("/").body;
    }
    assert!(page.contains("Choose the next experiments"), "{page}");
    assert!(page.contains("Recommended"), "{page}");
    assert!(served.ask().contains("Batch 2"));
    assert_eq!(served.post("/ask", &[]).status, 303);
    assert!(served.settled().contains("Batch 2"), "a second one finds the batch that is there");
    let status: Value = serde_json::from_str(&served.get("/status.json").body).unwrap();
    assert_eq!(status, rig.status(), "the page says what the shell says");
    assert!(served.get("/report").body.contains("<svg"));
    // The shell takes back what the page has asked for.
    assert!(rig.infuse(&["undo"]).ok().contains("batch 2"));
    assert!(served.get("/").body.contains("Choose the next experiments"));
}

#[test]
fn a_long_choice_is_answered_at_once() {
    let rig = Rig::pooled();
    let command = "command = [\"sh\", \"-c\", \"sleep 0.3; echo {spring}{damper gain}\"]\njobs = 1";
    rig.edit("table = \"simulation.csv\"", command);
    rig.edit("experiments = 10", "experiments = 4\nsimulations = 8");
    let served = Served::new(&rig);
    let start = Instant::now();
    assert_eq!((served.post("/ask", &[]).status, served.post("/ask", &[]).status), (303, 303));
    let page = served.get("/").body;
    assert!(page.contains("Choosing the next experiments") && page.contains("http-equiv=\"refresh\""), "{page}");
    assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
    assert!(served.post("/undo", &[("lines", "1")]).body.contains("wait until that is done"));
    assert!(served.settled().contains("Batch 1"));
    let is_batch = |line: &Value| line["experiments"].as_array().is_some_and(|planned| !planned.is_empty());
    let n_planned = rig.journal().iter().filter(|line| line["event"] == "planned" && is_batch(line)).count();
    assert_eq!(n_planned, 1, "a second click asks for nothing");
}

#[test]
fn wrong_values_stay_in_the_form_beside_what_is_wrong() {
    let (rig, served) = asked();
    let page = served.get("/").body;
    let n_lines = rig.journal().len();
    for (value, failed, words) in [
        ("seven", "", "expected a number"),
        ("-3", "", "expected at least 0"),
        ("1e999", "", "expected a"),
        ("7", "it broke", "expected nothing, as there is a value"),
        ("5 m/s", "", "expected a number in `mm/s`"),
    ] {
        let refused = tell(&served, &page, 3, (value, failed, "my note"));
        assert_eq!(refused.status, 422, "{value}");
        let body = refused.body.replace("<code>", "`").replace("</code>", "`");
        assert!(body.contains(words), "{words}: {body}");
        let kept = (field(&body, "cell-3-0"), field(&body, "cell-3-4"));
        assert_eq!(kept, (value.to_owned(), "my note".to_owned()));
        assert!(body.contains("aria-invalid=\"true\"") && body.contains("id=\"row-3\" class=\"refused\""));
    }
    // A note alone is no result; markup is text.
    let refused = tell(&served, &page, 3, ("", "", "<b>\"&'"));
    assert_eq!((refused.status, field(&refused.body, "cell-3-4")), (422, "<b>\"&'".to_owned()));
    assert!(!refused.body.contains("<b>"), "{}", refused.body);
    assert_eq!(rig.journal().len(), n_lines, "nothing of it was taken");
}

#[test]
fn failing_runs_other_settings_and_commas_are_taken_as_from_a_sheet() {
    let (rig, served) = asked();
    let page = served.get("/").body;
    assert_eq!(tell(&served, &page, 1, ("", "the belt slipped", "at noon")).status, 303);
    assert_eq!(tell(&served, &page, 2, ("7,25 mm/s", "", "")).status, 303);
    let was = field(&page, "was-3");
    let fields = [("was-3", &*was), ("cell-3-0", "8"), ("cell-3-1", ""), ("cell-3-2", "100"), ("cell-3-3", "")];
    let refused = served.post("/tell", &[&fields[..], &[("cell-3-4", "")]].concat());
    assert_eq!(refused.status, 422);
    assert!(refused.body.contains("id=\"cell-3-2-fault\"") && refused.body.contains("<details open>"));
    let fields = [("was-3", &*was), ("cell-3-0", "8"), ("cell-3-1", ""), ("cell-3-2", "20.5"), ("cell-3-3", "")];
    assert_eq!(served.post("/tell", &[&fields[..], &[("cell-3-4", "")]].concat()).status, 303);
    let journal = rig.journal();
    let line = |id: u64| journal.iter().find(|line| line["event"] == "told" && line["id"] == id).unwrap();
    assert_eq!((&line(1)["failed"], &line(1)["note"]), (&"the belt slipped".into(), &"at noon".into()));
    assert_eq!(line(2)["value"], 7.25);
    assert_eq!(line(3)["actual"]["spring"], 20.5);
    let page = served.get("/").body;
    assert_eq!(
        (field(&page, "cell-1-1"), field(&page, "cell-2-0")),
        ("the belt slipped".to_owned(), "7.25".to_owned())
    );
}

#[test]
fn two_tabs_do_not_overwrite_each_other_unseen() {
    let (rig, served) = asked();
    let (one, other) = (served.get("/").body, served.get("/").body);
    assert_eq!(tell(&served, &one, 4, ("7.5", "", "")).status, 303);
    let n_lines = rig.journal().len();
    // The same once more is known, however it is written.
    assert_eq!(tell(&served, &one, 4, ("7.50", "", "")).status, 303);
    assert_eq!(rig.journal().len(), n_lines);
    let refused = tell(&served, &other, 4, ("9.5", "", ""));
    assert_eq!(refused.status, 422);
    assert!(refused.body.contains("now it has 7.5"), "{}", refused.body);
    assert_eq!(field(&refused.body, "cell-4-0"), "9.5");
    assert_eq!(told(&rig.journal()).get(&4), Some(&7.5));
    // Who has read that may replace it, and a row that was emptied is no result.
    assert_eq!(tell(&served, &refused.body, 4, ("9.5", "", "")).status, 303);
    assert_eq!(told(&rig.journal()).get(&4), Some(&9.5));
    assert_eq!(tell(&served, &served.get("/").body, 4, ("", "", "")).status, 422);
    // The shell is a tab like any other.
    let page = served.get("/").body;
    rig.infuse(&["tell", "--id", "5", "--value", "6.5"]).ok();
    assert!(tell(&served, &page, 5, ("8", "", "")).body.contains("now it has 6.5"));
    assert_eq!(field(&served.get("/").body, "cell-5-0"), "6.5");
    // An untouched row of an old page says nothing.
    assert_eq!(tell(&served, &page, 5, ("", "", "")).status, 303);
    assert_eq!(told(&rig.journal()).get(&5), Some(&6.5));
}

#[test]
fn corrections_follow_the_rules_of_the_shell() {
    let (rig, served) = asked();
    assert_eq!(tell(&served, &served.get("/").body, 4, ("7.5", "", "")).status, 303);
    assert_eq!(tell(&served, &served.get("/").body, 4, ("7.5", "", "only a note")).status, 303);
    let last = rig.journal().pop().unwrap();
    assert_eq!(
        (&last["note"], &last["corrects"], &last["from"]),
        (&"only a note".into(), &true.into(), &"the page".into())
    );
    assert!(rig.infuse(&["log"]).ok().contains("the page"));
}

#[test]
fn a_question_comes_before_what_cannot_be_taken_back() {
    let (rig, served) = asked();
    assert_eq!(tell(&served, &served.get("/").body, 4, ("7.5", "", "")).status, 303);
    let question = served.get("/undo").body;
    assert!(question.contains("1 result from the page"), "{question}");
    let lines = field(&question, "lines");
    rig.infuse(&["tell", "--id", "5", "--value", "6.5"]).ok();
    assert_eq!(served.post("/undo", &[("lines", &lines)]).status, 409, "it would be another thing now");
    assert_eq!(told(&rig.journal()).len(), 2);
    let lines = field(&served.get("/undo").body, "lines");
    assert_eq!(served.post("/undo", &[("lines", &lines)]).status, 303);
    assert_eq!(rig.status()["told"], 1);
    assert!(!served.post("/undo", &[]).head.contains("303"));
}

#[test]
fn confirming_runs_are_planned_once() {
    let rig = Rig::pooled();
    rig.batch();
    let served = Served::new(&rig);
    let lines = field(&served.get("/confirm").body, "lines");
    assert_eq!(served.post("/confirm", &[("lines", &lines), ("runs", "many")]).status, 409);
    assert_eq!(served.post("/confirm", &[("lines", &lines), ("runs", "2")]).status, 303);
    assert_eq!(served.post("/confirm", &[("lines", &lines), ("runs", "2")]).status, 409);
    assert!(served.get("/").body.contains("Batch 2"));
}

#[test]
fn a_killed_server_loses_nothing_that_it_has_said() {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    for id in 1..=10 {
        let mut served = Served::new(&rig);
        assert_eq!(tell(&served, &served.get("/").body, id, (&format!("7.{id}"), "", "")).status, 303);
        served.kill();
        assert_eq!(told(&rig.journal()).len(), usize::try_from(id).unwrap());
    }
    assert_eq!(rig.status()["stage"], "ready");
}

#[test]
fn what_is_no_request_is_refused_and_others_are_served_meanwhile() {
    let (rig, served) = asked();
    let head = format!("Host: 127.0.0.1:{}\r\n", served.port);
    let long = "x".repeat(20_000);
    for (request, status) in [
        ("\u{16}\u{3}\u{1}\r\n\r\n".to_owned(), 400),
        ("GET\r\n\r\n".to_owned(), 400),
        (format!("GET / HTTP/1.1\r\n{head}{head}\r\n"), 400),
        (format!("POST /tell HTTP/1.1\r\n{head}\r\n"), 411),
        (format!("POST /tell HTTP/1.1\r\n{head}Content-Length: -1\r\n\r\n"), 400),
        (format!("POST /tell HTTP/1.1\r\n{head}Content-Length: 99999999999999999999999\r\n\r\n"), 413),
        (format!("POST /tell HTTP/1.1\r\n{head}Content-Length: 1048577\r\n\r\n{}", "x".repeat(1_048_577)), 413),
        (format!("POST /tell HTTP/1.1\r\n{head}Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n"), 400),
        (format!("DELETE / HTTP/1.1\r\n{head}\r\n"), 405),
        (format!("GET /{long} HTTP/1.1\r\n{head}\r\n"), 431),
        (format!("GET / HTTP/1.1\r\n{head}{}\r\n", "A: b\r\n".repeat(100)), 431),
    ] {
        let found = served.raw(request.as_bytes());
        assert_eq!(found.status, status, "{}: {}", &request[..request.len().min(80)], found.body);
    }
    // Fields that are none, of experiments that are none, in numbers that are none.
    let odd =
        [("was-99", "[]"), ("cell-99-0", "1"), ("cell-1-99999999999", "1"), ("cell--", ""), ("was-1", "{"), ("", "")];
    assert_eq!(served.post("/tell", &odd).status, 422);
    assert!(told(&rig.journal()).is_empty());
}

#[test]
fn slow_clients_keep_nobody_waiting_and_are_given_up() {
    let (_rig, served) = asked();
    let mut slow: Vec<_> = (0..20).map(|_| served.connect()).collect();
    slow.iter_mut().for_each(|stream| stream.write_all(b"GET / HTTP/1.1\r\nHost: ").unwrap());
    let start = Instant::now();
    assert_eq!(served.get("/").status, 200);
    assert!(start.elapsed() < Duration::from_secs(3), "{:?}", start.elapsed());
    // A byte now and then does not keep a connection.
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(12) && slow[0].write_all(b"1").is_ok() {
        std::thread::sleep(Duration::from_millis(500));
    }
    assert_eq!(answer(&mut slow[1]).status, 408);
    // More than a page needs at once are turned away.
    let many: Vec<_> = (0..200).map(|_| served.connect()).collect();
    let turned_away = served.raw(b"");
    assert_eq!(turned_away.status, 503);
    drop(many);
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(served.get("/").status, 200);
}
