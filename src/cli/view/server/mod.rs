//! Server: the page and its WebSocket, for programs on this machine that know the token.
//!
//! It is small on purpose: one thread for a connection, one request for a connection, no file of the
//! disk. httparse reads requests, tungstenite the messages of the WebSocket. The renderer works with
//! threads that block, and so does this.

mod assets;
mod client;
mod reply;
mod request;
mod socket;

use std::io;
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use super::address::PageAddress;
use super::lens_drawer::LensDrawer;
use super::state::ViewState;
use reply::{Reply, Status};
use request::RequestHead;

/// Largest number of connections at a time; more are closed at once.
const MAX_CONNECTIONS: usize = 64;
/// Largest number of clients that look at the picture at a time.
const MAX_CLIENTS: usize = 16;
/// Longest time for a request to arrive, and for a reply to be taken.
const TIMEOUT: Duration = Duration::from_secs(5);

/// The server of a view.
pub(super) struct Server {
    pub address: PageAddress,
    pub state: Arc<ViewState>,
    pub drawer: LensDrawer,
}

/// Counts itself while it exists.
struct Counted<'a>(&'a AtomicUsize);

impl<'a> Counted<'a> {
    /// Counts one more, up to a limit.
    fn new(count: &'a AtomicUsize, most: usize) -> Option<Self> {
        let counted = Self(count);
        (count.fetch_add(1, Ordering::Relaxed) < most).then_some(counted)
    }
}

impl Drop for Counted<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Server {
    /// Accepts connections until it is stopped; a connection wakes it.
    pub fn run(&self, listener: &TcpListener, stopped: &AtomicBool) {
        let (connections, clients) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let clients = &clients;
        thread::scope(|scope| {
            for stream in listener.incoming() {
                if stopped.load(Ordering::Relaxed) {
                    break;
                }
                let Ok(stream) = stream else {
                    // No file descriptors are left, most likely. Some will be closed.
                    thread::sleep(Duration::from_millis(50));
                    continue;
                };
                if let Some(counted) = Counted::new(&connections, MAX_CONNECTIONS) {
                    let serve = move || {
                        let _counted = counted;
                        // A connection that fails is the client's loss.
                        let _ = self.serve(&stream, clients);
                    };
                    // Without a thread, the connection is closed.
                    let _ = thread::Builder::new().spawn_scoped(scope, serve);
                }
            }
        });
    }

    /// Serves the one request of a connection.
    fn serve(&self, stream: &TcpStream, clients: &AtomicUsize) -> io::Result<()> {
        stream.set_read_timeout(Some(TIMEOUT))?;
        stream.set_write_timeout(Some(TIMEOUT))?;
        stream.set_nodelay(true)?;
        let reply = match RequestHead::read(stream, TIMEOUT)? {
            Ok(request) => match self.answer(&request) {
                Answer::Reply(reply) => reply,
                Answer::Socket(key) => match Counted::new(clients, MAX_CLIENTS) {
                    Some(_counted) => return self.serve_client(stream, &key),
                    None => Reply::error(Status::Busy, "too many pages show this camera"),
                },
            },
            Err(reply) => reply,
        };
        reply.write(stream)
    }

    /// Returns the answer to a request. Checks where it comes from before anything else.
    fn answer(&self, request: &RequestHead) -> Answer {
        let error = |status, message: &str| Answer::Reply(Reply::error(status, message));
        let host = request.header("host").unwrap_or_default();
        if !self.address.is_host(host) {
            return error(Status::Forbidden, "the Host is not an address of this camera");
        }
        let own = format!("http://{host}");
        if request.header("origin").is_some_and(|origin| origin != own) {
            return error(Status::Forbidden, "another page asks for this camera");
        }
        let Some(path) = self.address.behind_token(&request.path) else {
            let message = "open the address that petzval view prints, with its token";
            return error(Status::Forbidden, message);
        };
        if request.method != "GET" {
            return error(Status::Method, "only GET is supported");
        }
        if path == "socket" {
            let upgrade = request.header("upgrade").unwrap_or_default();
            let key = request.header("sec-websocket-key").unwrap_or_default();
            let version = request.header("sec-websocket-version") == Some("13");
            if !upgrade.eq_ignore_ascii_case("websocket") || key.is_empty() || !version {
                return error(Status::BadRequest, "expected a WebSocket of version 13");
            }
            return Answer::Socket(key.to_owned());
        }
        Answer::Reply(self.content(path))
    }

    /// Returns a part of the page.
    fn content(&self, path: &str) -> Reply {
        if let Some((kind, content)) = assets::find(path) {
            return Reply::content(kind, content);
        }
        if path == "lenses.json" {
            return Reply::content("application/json", self.drawer.list().to_string());
        }
        if path == "picture.exr" {
            return match self.state.frame().map(|frame| frame.exr()) {
                Some(Ok(file)) => Reply::content("image/x-exr", file),
                Some(Err(error)) => Reply::error(Status::Failed, &error.to_string()),
                None => Reply::error(Status::NotFound, "there is no picture yet"),
            };
        }
        let number = path.strip_prefix("section/").and_then(|name| name.strip_suffix(".svg"));
        let section = number.and_then(|number| self.drawer.section(number.parse().ok()?));
        match section {
            Some(section) => Reply::content("image/svg+xml", section),
            None => Reply::error(Status::NotFound, "there is no such part of the page"),
        }
    }
}

/// Answer to a request.
enum Answer {
    Reply(Reply),
    /// A WebSocket, with the key of the client.
    Socket(String),
}
