//! A request as bytes, and an answer: so much of HTTP/1.1 as a page with forms needs, one request per connection.

use std::io::{self, Write};

/// Of the line of a request and its headers.
const MOST_HEAD: usize = 16 << 10;
/// Of a form.
pub(super) const MOST_BODY: usize = 1 << 20;
const MOST_HEADERS: usize = 64;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Method {
    Get,
    Post,
}

#[derive(Debug)]
pub(super) struct Request {
    pub(super) method: Method,
    pub(super) path: String,
    pub(super) query: Vec<(String, String)>,
    /// In small letters, each with its value.
    headers: Vec<(String, String)>,
    /// Of the form that was sent.
    pub(super) fields: Vec<(String, String)>,
}

impl Request {
    pub(super) fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(other, _)| other == name).map(|(_, value)| &**value)
    }

    pub(super) fn field(&self, name: &str) -> Option<&str> {
        self.fields.iter().find(|(other, _)| other == name).map(|(_, value)| &**value)
    }
}

/// What is to be done with the bytes that came so far.
#[derive(Debug)]
pub(super) enum Parsed {
    More,
    Request(Request),
    Refused(Response),
}

/// The request in these bytes, if it has come to its end.
pub(super) fn parse(bytes: &[u8]) -> Parsed {
    let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
    let mut head = httparse::Request::new(&mut headers);
    let start = match head.parse(bytes) {
        Ok(httparse::Status::Complete(start)) if start <= MOST_HEAD => start,
        Ok(httparse::Status::Partial) if bytes.len() <= MOST_HEAD => return Parsed::More,
        Ok(_) => return refused(431, "the headers are too long"),
        Err(httparse::Error::TooManyHeaders) => return refused(431, "there are too many headers"),
        Err(error) => return refused(400, &format!("this is no HTTP: {error}")),
    };
    let (Some(method), Some(target)) = (head.method, head.path) else { return refused(400, "this is no HTTP") };
    let method = match method {
        "GET" => Method::Get,
        "POST" => Method::Post,
        _ => return refused(405, "expected GET or POST"),
    };
    let Some(headers) = known_headers(head.headers) else {
        return refused(400, "a header is no text, or comes twice where it may come once");
    };
    let (path, query) = target.split_once('?').unwrap_or((target, ""));
    let mut request =
        Request { method, path: path.to_owned(), query: pairs(query.as_bytes()), headers, fields: Vec::new() };
    if request.header("transfer-encoding").is_some() {
        return refused(400, "expected a Content-Length, and no Transfer-Encoding");
    }
    let n_body = match (request.header("content-length"), method) {
        (None, Method::Get) => 0,
        (None, Method::Post) => return refused(411, "expected a Content-Length"),
        (Some(text), _) if !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit()) => {
            text.parse().unwrap_or(usize::MAX)
        }
        _ => return refused(400, "the Content-Length is no number"),
    };
    if n_body > MOST_BODY {
        return refused(413, "the form is too large, expected at most 1 MB");
    }
    match bytes.get(start..start + n_body) {
        None => Parsed::More,
        Some(body) => {
            request.fields = pairs(body);
            Parsed::Request(request)
        }
    }
}

/// All headers by their names in small letters; none if one is no text, or if two could be read in two ways.
fn known_headers(headers: &[httparse::Header<'_>]) -> Option<Vec<(String, String)>> {
    let mut known: Vec<(String, String)> = Vec::new();
    for header in headers {
        let name = header.name.to_ascii_lowercase();
        let once = ["host", "origin", "content-length", "transfer-encoding", "sec-fetch-site", "cookie"];
        if once.contains(&&*name) && known.iter().any(|(other, _)| *other == name) {
            return None;
        }
        // Others may hold what they like; they are not read.
        match std::str::from_utf8(header.value) {
            Ok(value) => known.push((name, value.trim().to_owned())),
            Err(_) if once.contains(&&*name) => return None,
            Err(_) => {}
        }
    }
    Some(known)
}

fn pairs(bytes: &[u8]) -> Vec<(String, String)> {
    form_urlencoded::parse(bytes).into_owned().collect()
}

fn refused(status: u16, why: &str) -> Parsed {
    Parsed::Refused(Response::plain(status, why))
}

/// What may be loaded by a page: nothing from elsewhere, and no script.
const POLICY: &str = "default-src 'none'; style-src 'self'; frame-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'";
/// The report has its style in itself.
const POLICY_OF_REPORT: &str =
    "default-src 'none'; style-src 'unsafe-inline'; form-action 'none'; base-uri 'none'; frame-ancestors 'none'";
/// Pictures are shown within the page.
const POLICY_OF_PICTURES: &str =
    "default-src 'none'; style-src 'unsafe-inline'; form-action 'none'; base-uri 'none'; frame-ancestors 'self'";

#[derive(Debug)]
pub(super) struct Response {
    pub(super) status: u16,
    kind: &'static str,
    policy: &'static str,
    /// Besides those that every answer has.
    headers: Vec<(&'static str, String)>,
    body: Vec<u8>,
}

impl Response {
    fn new(status: u16, kind: &'static str, body: impl Into<Vec<u8>>) -> Self {
        Self { status, kind, policy: POLICY, headers: Vec::new(), body: body.into() }
    }

    pub(super) fn plain(status: u16, text: &str) -> Self {
        Self::new(status, "text/plain; charset=utf-8", format!("{text}\n"))
    }

    pub(super) fn html(status: u16, html: String) -> Self {
        Self::new(status, "text/html; charset=utf-8", html)
    }

    /// A page with its style in itself, within another, which is loaded again after so many seconds.
    pub(super) fn pictures(html: String, refresh_s: u32) -> Self {
        Self { policy: POLICY_OF_PICTURES, ..Self::html(200, html) }.with("Refresh", refresh_s.to_string())
    }

    /// A page with its style in itself.
    pub(super) fn report(html: String) -> Self {
        Self { policy: POLICY_OF_REPORT, ..Self::html(200, html) }
    }

    pub(super) fn css(text: &str) -> Self {
        Self::new(200, "text/css; charset=utf-8", text)
    }

    pub(super) fn json(value: &serde_json::Value) -> Self {
        Self::new(200, "application/json", format!("{value}\n"))
    }

    /// Go there and read; what was sent is done.
    pub(super) fn see_other(place: &str) -> Self {
        Self::plain(303, "see the page").with("Location", place.to_owned())
    }

    pub(super) fn with(mut self, name: &'static str, value: String) -> Self {
        self.headers.push((name, value));
        self
    }

    pub(super) fn write(&self, to: &mut impl Write) -> io::Result<()> {
        let reason = match self.status {
            200 => "OK",
            303 => "See Other",
            400 => "Bad Request",
            403 => "Forbidden",
            404 => "Not Found",
            405 => "Method Not Allowed",
            408 => "Request Timeout",
            409 => "Conflict",
            411 => "Length Required",
            413 => "Content Too Large",
            422 => "Unprocessable Content",
            431 => "Request Header Fields Too Large",
            503 => "Service Unavailable",
            _ => "Internal Server Error",
        };
        let Self { status, kind, policy, headers, body } = self;
        let within = if *policy == POLICY_OF_PICTURES { "SAMEORIGIN" } else { "DENY" };
        let mut head = format!(
            "HTTP/1.1 {status} {reason}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\
             Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nX-Frame-Options: {within}\r\n\
             Referrer-Policy: same-origin\r\nCross-Origin-Resource-Policy: same-origin\r\n\
             Content-Security-Policy: {policy}\r\n",
            body.len()
        );
        for (name, value) in headers {
            head.push_str(&format!("{name}: {value}\r\n"));
        }
        head.push_str("\r\n");
        to.write_all(head.as_bytes())?;
        to.write_all(body)?;
        to.flush()
    }
}
