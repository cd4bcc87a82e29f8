//! `infuse serve`: today's sheet as a page, for a browser beside the rig.
//!
//! A thread per connection reads one request and answers it. Each request reads the folder anew and writes to it as a command
//! would, so nothing is kept here that a killed server could lose.

mod connection;
mod form;
mod frame;
mod guard;
mod http;
mod pages;
mod routes;
mod sheet;
mod work;

use std::io::Write as _;
use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::time::Duration;

use anyhow::{Context as _, Result};
use serde_json::json;

use super::output::Output;
use connection::Slot;
use guard::{Guard, token};
use routes::{Drawn, Site};
use work::Work;

/// More at once are turned away.
const MOST_CONNECTIONS: usize = 64;

/// Serves until the process is interrupted.
pub(super) fn serve(
    folder: &Path,
    wait: Duration,
    port: u16,
    token_file: Option<&Path>,
    is_json: bool,
) -> Result<Output> {
    // What is wrong with the folder is said in the shell.
    crate::folder::read(folder)?;
    let token = token(token_file)?;
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).with_context(|| format!("port {port}"))?;
    let port = listener.local_addr().context("the port")?.port();
    let address = format!("http://127.0.0.1:{port}/?token={token}");
    let said = if is_json { json!({ "address": address }).to_string() } else { address };
    writeln!(std::io::stdout(), "{said}").context("standard output")?;
    writeln!(std::io::stderr(), "note: whoever has this address may write to the campaign; Ctrl-C ends the page")?;
    std::io::stdout().flush().context("standard output")?;
    let site = Arc::new(Site {
        folder: folder.to_path_buf(),
        wait,
        guard: Guard { token, port },
        work: Work::default(),
        pictures: Drawn::default(),
    });
    let open = Arc::new(AtomicUsize::new(0));
    loop {
        match listener.accept() {
            Ok((stream, _)) => {
                let Some(slot) = Slot::take(&open, MOST_CONNECTIONS) else {
                    connection::turn_away(&stream);
                    continue;
                };
                let site = Arc::clone(&site);
                // Where no thread is to be had the connection is closed.
                let _ = std::thread::Builder::new().spawn(move || {
                    let _slot = slot;
                    connection::serve(stream, |request| site.answer(request));
                });
            }
            // Too many open files, or a client that has gone: neither lasts.
            Err(_) => std::thread::sleep(Duration::from_millis(50)),
        }
    }
}
