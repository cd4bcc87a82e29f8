//! A connection: one request is read in a bounded time, answered, and the connection closed.

use std::io::{ErrorKind, Read as _};
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use super::http::{Parsed, Request, Response, parse};

/// A request that has not come by then is given up, however it drips in.
const PATIENCE: Duration = Duration::from_secs(10);
/// How long, and how much, is read from a client that still sends what was refused, so that it sees the answer.
const LINGER: (Duration, usize) = (Duration::from_secs(1), 8 << 20);

/// One of the connections that may be open at once.
#[derive(Debug)]
pub(super) struct Slot(Arc<AtomicUsize>);

impl Slot {
    pub(super) fn take(open: &Arc<AtomicUsize>, most: usize) -> Option<Self> {
        let slot = Self(Arc::clone(open));
        (open.fetch_add(1, Ordering::SeqCst) < most).then_some(slot)
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Says that there are too many, without waiting for whoever it is.
pub(super) fn turn_away(mut stream: &TcpStream) {
    let _ = stream.set_nonblocking(true);
    let _ = Response::plain(503, "too many connections at once, try again").write(&mut stream);
}

/// Whatever goes wrong with a connection is the end of it, and of nothing else.
pub(super) fn serve(mut stream: TcpStream, answer: impl Fn(&Request) -> Response) {
    let response = match read(&mut stream) {
        Some(Parsed::Request(request)) => answer(&request),
        Some(Parsed::Refused(response)) => response,
        _ => return,
    };
    let _ = stream.set_write_timeout(Some(PATIENCE));
    if response.write(&mut stream).is_ok() && stream.shutdown(Shutdown::Write).is_ok() {
        linger(&mut stream);
    }
}

/// What came; nothing from a client that said nothing.
fn read(stream: &mut TcpStream) -> Option<Parsed> {
    let start = Instant::now();
    let (mut bytes, mut chunk) = (Vec::new(), [0; 16 << 10]);
    loop {
        let left = PATIENCE.saturating_sub(start.elapsed());
        let n = match left.is_zero() {
            true => None,
            false => {
                stream.set_read_timeout(Some(left)).ok()?;
                match stream.read(&mut chunk) {
                    Ok(0) => return None,
                    Ok(n) => Some(n),
                    Err(error) if [ErrorKind::WouldBlock, ErrorKind::TimedOut].contains(&error.kind()) => None,
                    Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                    Err(_) => return None,
                }
            }
        };
        let Some(n) = n else {
            let late = Parsed::Refused(Response::plain(408, "the request took too long"));
            return (!bytes.is_empty()).then_some(late);
        };
        bytes.extend_from_slice(&chunk[..n]);
        match parse(&bytes) {
            Parsed::More => {}
            parsed => return Some(parsed),
        }
    }
}

/// A connection that is closed with something unread is reset, and its answer lost.
fn linger(stream: &mut TcpStream) {
    let (start, mut n_read, mut chunk) = (Instant::now(), 0, [0; 16 << 10]);
    while n_read < LINGER.1 {
        let left = LINGER.0.saturating_sub(start.elapsed());
        if left.is_zero() || stream.set_read_timeout(Some(left)).is_err() {
            return;
        }
        match stream.read(&mut chunk) {
            Ok(n) if n > 0 => n_read += n,
            _ => return,
        }
    }
}
