//! Request: its head, read from a connection within limits of size and time.

use std::io::{self, Read};
use std::time::{Duration, Instant};

use super::reply::{Reply, Status};

/// Largest head of a request (bytes).
const MAX_HEAD: usize = 8192;
/// Largest number of its headers.
const MAX_HEADERS: usize = 64;

/// The head of a request. The server reads no bodies.
#[derive(Debug)]
pub(super) struct RequestHead {
    pub method: String,
    pub path: String,
    /// Names in lower case, and values.
    headers: Vec<(String, String)>,
}

impl RequestHead {
    /// Reads a head, or returns the reply to one that is refused.
    ///
    /// # Errors
    /// Returns an error if the connection ends, or the time is over.
    pub fn read(mut from: impl Read, most: Duration) -> io::Result<Result<Self, Reply>> {
        let start = Instant::now();
        let mut head = Vec::new();
        let mut byte = [0; 1024];
        loop {
            let read = from.read(&mut byte)?;
            if read == 0 || start.elapsed() > most {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            head.extend_from_slice(&byte[..read]);
            if head.len() > MAX_HEAD {
                let reply = Reply::error(Status::TooLarge, "the head of the request is too large");
                return Ok(Err(reply));
            }
            match Self::parse(&head) {
                Ok(None) => {}
                Ok(Some(request)) => return Ok(Ok(request)),
                Err(error) => {
                    return Ok(Err(Reply::error(Status::BadRequest, &error.to_string())));
                }
            }
        }
    }

    /// Parses a head, or returns `None` if it is not complete.
    fn parse(head: &[u8]) -> Result<Option<Self>, httparse::Error> {
        let mut headers = [httparse::EMPTY_HEADER; MAX_HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        if request.parse(head)?.is_partial() {
            return Ok(None);
        }
        let header = |header: &mut httparse::Header| {
            let value = String::from_utf8_lossy(header.value).into_owned();
            (header.name.to_ascii_lowercase(), value)
        };
        Ok(Some(Self {
            method: request.method.unwrap_or_default().to_owned(),
            path: request.path.unwrap_or_default().to_owned(),
            headers: request.headers.iter_mut().map(header).collect(),
        }))
    }

    /// Returns the value of a header that is given once.
    pub fn header(&self, name: &str) -> Option<&str> {
        let mut values = self.headers.iter().filter(|(found, _)| found == name);
        match (values.next(), values.next()) {
            (Some((_, value)), None) => Some(value),
            // Two values: what one program checks, another may not use.
            (Some(_), Some(_)) => Some(""),
            _ => None,
        }
    }
}
