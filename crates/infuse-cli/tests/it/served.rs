//! A page that is served, and a client as plain as can be.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Shutdown, TcpStream};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use crate::rig::Rig;

/// A server of a campaign, killed at the end.
#[derive(Debug)]
pub(crate) struct Served {
    child: Child,
    pub(crate) port: u16,
    pub(crate) token: String,
}

/// What was answered.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) status: u16,
    pub(crate) head: String,
    pub(crate) body: String,
}

impl Served {
    pub(crate) fn new(rig: &Rig) -> Self {
        Self::with(rig, &[])
    }

    pub(crate) fn with(rig: &Rig, arguments: &[&str]) -> Self {
        let mut command = rig.command(&[&["serve"], arguments].concat());
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let (address, token) = line.trim().split_once("/?token=").unwrap();
        let port = address.strip_prefix("http://127.0.0.1:").unwrap().parse().unwrap();
        Self { child, port, token: token.to_owned() }
    }

    pub(crate) fn url(&self) -> String {
        format!("http://127.0.0.1:{}/?token={}", self.port, self.token)
    }

    /// With SIGKILL.
    pub(crate) fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    pub(crate) fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        stream
    }

    /// Sends these bytes and reads to the end.
    pub(crate) fn raw(&self, bytes: &[u8]) -> Answer {
        let mut stream = self.connect();
        stream.write_all(bytes).unwrap();
        answer(&mut stream)
    }

    fn host_and_cookie(&self) -> String {
        format!("Host: 127.0.0.1:{}\r\nCookie: infuse-{}={}\r\n", self.port, self.port, self.token)
    }

    pub(crate) fn get(&self, path: &str) -> Answer {
        self.raw(format!("GET {path} HTTP/1.1\r\n{}\r\n", self.host_and_cookie()).as_bytes())
    }

    /// A form, as a browser sends it.
    pub(crate) fn post(&self, path: &str, fields: &[(&str, &str)]) -> Answer {
        self.post_with(path, fields, &format!("Origin: http://127.0.0.1:{}\r\n", self.port))
    }

    pub(crate) fn post_with(&self, path: &str, fields: &[(&str, &str)], headers: &str) -> Answer {
        self.raw(&self.form(path, fields, headers))
    }

    /// A form as it goes to the server.
    pub(crate) fn form(&self, path: &str, fields: &[(&str, &str)], headers: &str) -> Vec<u8> {
        let body: String = form_urlencoded::Serializer::new(String::new()).extend_pairs(fields).finish();
        let head = format!(
            "POST {path} HTTP/1.1\r\n{}{headers}Content-Type: application/x-www-form-urlencoded\r\nContent-Length: {}\r\n\r\n",
            self.host_and_cookie(),
            body.len()
        );
        format!("{head}{body}").into_bytes()
    }

    /// The page, once nothing goes on any more.
    #[track_caller]
    pub(crate) fn settled(&self) -> String {
        let start = Instant::now();
        loop {
            let page = self.get("/").body;
            if !page.contains("http-equiv") {
                return page;
            }
            assert!(start.elapsed() < Duration::from_secs(60), "it goes on and on: {page}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Chooses a batch.
    #[track_caller]
    pub(crate) fn ask(&self) -> String {
        assert_eq!(self.post("/ask", &[]).status, 303);
        self.settled()
    }
}

/// Sends these bytes to a server that may be killed meanwhile; what it answered, 0 if nothing.
pub(crate) fn send(port: u16, bytes: &[u8]) -> u16 {
    let Ok(mut stream) = TcpStream::connect(("127.0.0.1", port)) else { return 0 };
    if stream.write_all(bytes).is_err() {
        return 0;
    }
    answer(&mut stream).status
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub(crate) fn answer(stream: &mut TcpStream) -> Answer {
    let mut bytes = Vec::new();
    // A server that closes early resets the connection; what it said before is what counts.
    let _ = stream.read_to_end(&mut bytes);
    let _ = stream.shutdown(Shutdown::Both);
    let text = String::from_utf8(bytes).unwrap();
    let (head, body) = text.split_once("\r\n\r\n").unwrap_or((&text, ""));
    let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
    Answer { status, head: head.to_owned(), body: body.to_owned() }
}

/// The value of a field of a page, as it would be sent.
#[track_caller]
pub(crate) fn field(page: &str, name: &str) -> String {
    let (_, after) = page.split_once(&format!("name=\"{name}\" value=\"")).unwrap_or_else(|| panic!("{name}: {page}"));
    let value = after.split('"').next().unwrap();
    value.replace("&quot;", "\"").replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
}
