//! Replies to requests, with the headers that confine the page.

use std::io::{self, Write};

use crate::cli::option_names::with_option_names;

/// Status of a reply.
#[derive(Clone, Copy, Debug)]
pub(super) enum Status {
    Ok,
    BadRequest,
    Forbidden,
    NotFound,
    Method,
    TooLarge,
    Failed,
    Busy,
}

impl Status {
    fn line(self) -> &'static str {
        match self {
            Self::Ok => "200 OK",
            Self::BadRequest => "400 Bad Request",
            Self::Forbidden => "403 Forbidden",
            Self::NotFound => "404 Not Found",
            Self::Method => "405 Method Not Allowed",
            Self::TooLarge => "431 Request Header Fields Too Large",
            Self::Failed => "500 Internal Server Error",
            Self::Busy => "503 Service Unavailable",
        }
    }
}

/// Headers of every reply. The page loads nothing from elsewhere and runs no inline script, no other
/// page can embed or read it, and the token of its address is not handed on.
const HEADERS: &str = "Cache-Control: no-store\r\n\
    Connection: close\r\n\
    Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; \
    img-src 'self' blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; \
    frame-ancestors 'none'\r\n\
    Cross-Origin-Opener-Policy: same-origin\r\n\
    Cross-Origin-Resource-Policy: same-origin\r\n\
    Referrer-Policy: no-referrer\r\n\
    X-Content-Type-Options: nosniff\r\n";

/// A reply.
#[derive(Debug)]
pub(super) struct Reply {
    status: Status,
    kind: &'static str,
    body: Vec<u8>,
}

impl Reply {
    pub fn content(kind: &'static str, body: impl Into<Vec<u8>>) -> Self {
        Self { status: Status::Ok, kind, body: body.into() }
    }

    pub fn error(status: Status, message: &str) -> Self {
        Self {
            status,
            kind: "text/plain; charset=utf-8",
            body: format!("petzval: {}\n", with_option_names(message)).into(),
        }
    }

    pub fn write(&self, mut to: impl Write) -> io::Result<()> {
        let Self { status, kind, body } = self;
        let head = format!(
            "HTTP/1.1 {}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n{HEADERS}\r\n",
            status.line(),
            body.len()
        );
        to.write_all(head.as_bytes())?;
        to.write_all(body)?;
        to.flush()
    }
}
