//! Who may ask: this machine, by the name of this page, with its token, and no other page of the same browser.

use std::path::Path;

use anyhow::{Context as _, Result, anyhow, ensure};
use subtle::ConstantTimeEq as _;

use super::http::{Method, Request, Response};

const SHORTEST: usize = 16;

/// A new token, or that of a file.
pub(super) fn token(file: Option<&Path>) -> Result<String> {
    let Some(path) = file else {
        let mut bytes = [0; 24];
        getrandom::fill(&mut bytes).map_err(|error| anyhow!("no random token: {error}"))?;
        return Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect());
    };
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let token = text.trim();
    let is_plain = token.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-_".contains(&byte));
    ensure!(
        is_plain && (SHORTEST..=256).contains(&token.len()),
        "{}: expected {SHORTEST} to 256 letters, digits, `-` or `_`",
        path.display()
    );
    Ok(token.to_owned())
}

#[derive(Debug)]
pub(super) struct Guard {
    pub(super) token: String,
    pub(super) port: u16,
}

impl Guard {
    /// The answer to a request that may go no further: a refusal, or the cookie in exchange for the token of the address.
    pub(super) fn stops(&self, request: &Request) -> Option<Response> {
        let Some(host) = request.header("host") else {
            return Some(Response::plain(400, "expected a header Host"));
        };
        if !self.hosts().contains(&host.to_ascii_lowercase()) {
            return Some(Response::plain(403, "this page is called 127.0.0.1 or localhost, with its port"));
        }
        let own = format!("http://{}", host.to_ascii_lowercase());
        let is_foreign = request.header("origin").is_some_and(|origin| origin != own)
            || request.header("sec-fetch-site").is_some_and(|site| !["same-origin", "none"].contains(&site));
        if is_foreign {
            return Some(Response::plain(
                403,
                "another page may not ask this one; type its address, or follow no link to it",
            ));
        }
        let in_address = request.query.iter().find(|(name, _)| name == "token");
        if let Some((_, token)) = in_address.filter(|_| request.method == Method::Get) {
            return Some(if self.is_token(token) { self.hand_over(&request.path) } else { refused() });
        }
        let cookie = self.cookie();
        let cookies = request.header("cookie").unwrap_or_default().split(';');
        let mut values = cookies.filter_map(|one| one.trim().strip_prefix(&*cookie)?.strip_prefix('='));
        (!values.any(|value| self.is_token(value))).then(refused)
    }

    fn hosts(&self) -> Vec<String> {
        let names = ["127.0.0.1", "localhost"];
        let bare = names.iter().filter(|_| self.port == 80).map(|&name| name.to_owned());
        names.iter().map(|name| format!("{name}:{}", self.port)).chain(bare).collect()
    }

    fn is_token(&self, token: &str) -> bool {
        token.as_bytes().ct_eq(self.token.as_bytes()).into()
    }

    /// Cookies know no ports: two campaigns on one machine have one each.
    fn cookie(&self) -> String {
        format!("infuse-{}", self.port)
    }

    /// The token leaves the address, where it would be seen, for the cookie.
    fn hand_over(&self, path: &str) -> Response {
        let cookie = format!("{}={}; Path=/; HttpOnly; SameSite=Strict", self.cookie(), self.token);
        let place = if ["/report", "/status.json"].contains(&path) { path } else { "/" };
        Response::see_other(place).with("Set-Cookie", cookie)
    }
}

fn refused() -> Response {
    Response::plain(403, "open the address that `infuse serve` has printed, with its token")
}
