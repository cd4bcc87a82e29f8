//! Which answer belongs to which request.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use anyhow::{Context as _, Result, ensure};

use super::super::{ask, cancel, confirm, status, undo};
use super::form::{Refused, rows, tell};
use super::guard::Guard;
use super::http::{Method, Request, Response};
use super::pages::{Question, fault, question};
use super::sheet::{Shown, page};
use super::work::{State, Work};
use crate::campaign::Wish;
use crate::folder;
use crate::journal::{JOURNAL, Journal};
use crate::problem::PROBLEM;

/// What is served, and to whom.
#[derive(Debug)]
pub(super) struct Site {
    pub(super) folder: PathBuf,
    /// For a command of the shell.
    pub(super) wait: Duration,
    pub(super) guard: Guard,
    pub(super) work: Work,
    pub(super) pictures: Drawn,
}

/// The pictures that were drawn last, and the state of the folder that they show.
pub(super) type Drawn = Mutex<Option<(Vec<FileState>, String)>>;

/// How long a file is, and when it was written.
type FileState = Option<(u64, SystemTime)>;

/// Pictures are looked at again after so long, and drawn again if anything was written meanwhile.
const PICTURES_S: u32 = 5;

impl Site {
    pub(super) fn answer(&self, request: &Request) -> Response {
        if let Some(stopped) = self.guard.stops(request) {
            return stopped;
        }
        let answer = match (request.method, &*request.path) {
            (Method::Get, "/") => self.sheet(200, Refused::new(), None),
            (Method::Get, "/style.css") => Ok(Response::css(include_str!("style.css"))),
            (Method::Get, "/report") => self.report(),
            (Method::Get, "/pictures") => Ok(self.pictures()),
            (Method::Get, "/status.json") => {
                status::status(&self.folder, None).map(|output| Response::json(&output.json))
            }
            (Method::Get, "/undo") => self.ask_undo(),
            (Method::Get, "/confirm") => self.ask_confirm(),
            (Method::Get, "/more") => self.ask_more(),
            (Method::Get, "/cancel") => self.ask_cancel(),
            (Method::Post, "/tell") => self.tell(request),
            (Method::Post, "/ask") => self.ask(request),
            (Method::Post, "/undo") => self.undo(request),
            (Method::Post, "/confirm") => self.confirm(request),
            (Method::Post, "/more") => self.more(request),
            (Method::Post, "/cancel") => self.cancel(),
            (_, "/" | "/style.css" | "/report" | "/pictures" | "/status.json" | "/tell" | "/ask") => {
                Ok(Response::plain(405, "this is not how it is asked for"))
            }
            _ => Ok(Response::plain(404, "there is no such page")),
        };
        answer.unwrap_or_else(|error| Response::html(500, fault(&format!("{error:#}"))))
    }

    /// The sheet, with what was typed and not taken.
    fn sheet(&self, status: u16, refused: Refused, error: Option<String>) -> Result<Response> {
        // First of all: work that ends in between is then shown as going on, and the page looks again.
        let work = self.work.state();
        let mut campaign = folder::read(&self.folder)?;
        let notices = campaign.take_notices();
        let (known, _) = status::known(&*campaign)?;
        let shown = Shown { work, known, notices, refused, error };
        Ok(Response::html(status, page(&*campaign, &shown)?))
    }

    fn report(&self) -> Result<Response> {
        let campaign = folder::read(&self.folder)?;
        Ok(Response::report(campaign.page(&Journal::read(&self.folder)?)?))
    }

    /// What cannot be drawn now may be drawn the next time.
    fn pictures(&self) -> Response {
        let drawn = || -> Result<String> {
            let state = [JOURNAL, PROBLEM].map(|name| file_state(&self.folder.join(name))).to_vec();
            let mut kept = self.pictures.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some((_, html)) = kept.as_ref().filter(|(of, _)| *of == state) {
                return Ok(html.clone());
            }
            let html = folder::read(&self.folder)?.pictures()?;
            *kept = Some((state, html.clone()));
            Ok(html)
        };
        Response::pictures(drawn().unwrap_or_else(|error| fault(&format!("{error:#}"))), PICTURES_S)
    }

    fn tell(&self, request: &Request) -> Result<Response> {
        let rows = rows(request);
        match tell(&self.folder, self.wait, rows.clone()) {
            Ok(None) => {
                self.work.forget();
                // Back to the row whose button it was.
                let row = request.field("row").and_then(|id| id.parse::<u64>().ok());
                Ok(Response::see_other(&row.map_or_else(|| "/".to_owned(), |id| format!("/#row-{id}"))))
            }
            Ok(Some(refused)) => self.sheet(422, refused, None),
            // Another process has the folder, or the disk is full: what was typed stays.
            Err(error) => self.sheet(503, rows, Some(format!("{error:#}"))),
        }
    }

    /// Answers at once; a second one meanwhile finds what goes on.
    fn ask(&self, request: &Request) -> Result<Response> {
        let wish = Wish { anyway: request.field("anyway") == Some("yes"), more: false };
        let (folder, wait) = (self.folder.clone(), self.wait);
        self.work.begin(move || ask::ask(&folder, wait, None, wish, false))?;
        Ok(Response::see_other("/"))
    }

    fn ask_undo(&self) -> Result<Response> {
        let (journal, last) = undo::last_of(&self.folder)?;
        let what = format!("This will be taken back: {}. There is no way to take that back.", undo::in_words(&last));
        let asked =
            Question { heading: "Take the last thing back?", what: &what, button: "Take it back", action: "/undo" };
        Ok(Response::html(200, question(asked, journal.all.len(), None)))
    }

    fn undo(&self, request: &Request) -> Result<Response> {
        self.is_free()?;
        match undo::undo(&self.folder, self.wait, Some(lines(request)?)) {
            Ok(output) => {
                self.work.say(output.notices);
                Ok(Response::see_other("/"))
            }
            Err(error) => self.sheet(409, Refused::new(), Some(format!("{error:#}"))),
        }
    }

    fn ask_confirm(&self) -> Result<Response> {
        let asked = Question {
            heading: "Confirm what was gained?",
            what: "A few runs each of the recommended design, the best measured and the simulation's own choice will be a \
                   batch of their own. Once they are told, the page says what was gained.",
            button: "Plan these runs",
            action: "/confirm",
        };
        Ok(Response::html(200, question(asked, Journal::read(&self.folder)?.all.len(), Some(3))))
    }

    fn confirm(&self, request: &Request) -> Result<Response> {
        self.is_free()?;
        let n_lines = lines(request)?;
        let runs = request.field("runs").unwrap_or_default().trim();
        let planned = || {
            let runs = runs.parse().ok().with_context(|| format!("`runs` is `{runs}`, expected a number from 1"))?;
            let is_same = Journal::read(&self.folder)?.all.len() == n_lines;
            ensure!(is_same, "something was written down since this was asked: nothing was planned, look again");
            confirm::confirm(&self.folder, self.wait, runs, None)
        };
        match planned() {
            Ok(output) => {
                self.work.say(output.notices);
                Ok(Response::see_other("/"))
            }
            Err(error) => self.sheet(409, Refused::new(), Some(format!("{error:#}"))),
        }
    }

    fn ask_more(&self) -> Result<Response> {
        let asked = Question {
            heading: "Another batch beside this one?",
            what: "The next batch will be chosen without the results that are still waited for. This may simulate for a while.",
            button: "Choose another batch",
            action: "/more",
        };
        Ok(Response::html(200, question(asked, Journal::read(&self.folder)?.all.len(), None)))
    }

    fn more(&self, request: &Request) -> Result<Response> {
        if Journal::read(&self.folder)?.all.len() != lines(request)? {
            let error = "something was written down since this was asked: nothing was chosen, look again".to_owned();
            return self.sheet(409, Refused::new(), Some(error));
        }
        let (folder, wait) = (self.folder.clone(), self.wait);
        let wish = Wish { anyway: false, more: true };
        self.work.begin(move || ask::ask(&folder, wait, None, wish, false))?;
        Ok(Response::see_other("/"))
    }

    fn ask_cancel(&self) -> Result<Response> {
        let asked = Question {
            heading: "Stop what is in the queue?",
            what: "Simulations and experiments that wait or run are stopped. What was finished counts, and the next ask or run \
                   submits the others again.",
            button: "Stop them",
            action: "/cancel",
        };
        Ok(Response::html(200, question(asked, 0, None)))
    }

    /// Stops the queue. While this page itself waits for simulations, it holds the campaign, and would submit them again.
    fn cancel(&self) -> Result<Response> {
        self.is_free()?;
        match cancel::cancel(&self.folder, self.wait) {
            Ok(output) => {
                self.work.say(vec![output.text.trim().to_owned()]);
                Ok(Response::see_other("/"))
            }
            Err(error) => self.sheet(409, Refused::new(), Some(format!("{error:#}"))),
        }
    }

    fn is_free(&self) -> Result<()> {
        ensure!(!matches!(self.work.state(), State::Busy(_)), "experiments are being chosen: wait until that is done");
        Ok(())
    }
}

fn file_state(path: &Path) -> FileState {
    let metadata = std::fs::metadata(path).ok()?;
    Some((metadata.len(), metadata.modified().ok()?))
}

/// How many lines the journal had when a page was made.
fn lines(request: &Request) -> Result<usize> {
    request.field("lines").and_then(|text| text.parse().ok()).context("the form is not whole: go back and try again")
}
