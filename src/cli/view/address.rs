//! Address of the page: where the server listens, with a random token that only its user knows.

use std::fmt;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::process::{Command, Stdio};

use crate::cli::Failure;

/// Random bytes in a token.
const TOKEN_BYTES: usize = 16;
/// Port of an address without one.
const HTTP: u16 = 80;

/// The address of the page.
#[derive(Clone, Debug)]
pub(super) struct PageAddress {
    socket: SocketAddr,
    token: String,
}

impl PageAddress {
    /// Returns an address with a new token.
    pub fn new(socket: SocketAddr) -> Result<Self, Failure> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes)
            .map_err(|error| format!("the system gives no random numbers: {error}"))?;
        let token = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { socket, token })
    }

    /// Returns the socket as a program on this machine reaches it.
    pub fn local(&self) -> SocketAddr {
        let ip = match self.socket.ip() {
            IpAddr::V4(ip) if ip.is_unspecified() => IpAddr::V4(Ipv4Addr::LOCALHOST),
            IpAddr::V6(ip) if ip.is_unspecified() => IpAddr::V6(Ipv6Addr::LOCALHOST),
            ip => ip,
        };
        SocketAddr::new(ip, self.socket.port())
    }

    /// Returns whether a request may come under this Host: an address of the server by number, or
    /// localhost. Another name may be one that an attacker has pointed at this machine (DNS
    /// rebinding).
    pub fn is_host(&self, host: &str) -> bool {
        // Browsers leave the port of HTTP out.
        let address = host.parse().ok().or_else(|| {
            let ip = host.strip_prefix('[').and_then(|ip| ip.strip_suffix(']')).unwrap_or(host);
            Some(SocketAddr::new(ip.parse().ok()?, HTTP))
        });
        if let Some(address) = address {
            let own = self.socket.ip();
            let is_own = own.is_unspecified() || address.ip() == own;
            return address.port() == self.socket.port() && is_own;
        }
        let port = match host.split_once(':') {
            Some(("localhost", port)) => port.parse().ok(),
            None if host == "localhost" => Some(HTTP),
            _ => None,
        };
        port == Some(self.socket.port())
    }

    /// Returns the rest of a path behind the token, or `None` if the token is wrong. The time does
    /// not tell how much of it is right.
    pub fn behind_token<'a>(&self, path: &'a str) -> Option<&'a str> {
        let (token, rest) = path.strip_prefix('/')?.split_once('/')?;
        let differ = |(a, b): (u8, u8)| a ^ b;
        let difference = token.bytes().zip(self.token.bytes()).map(differ).fold(0, |a, b| a | b);
        (token.len() == self.token.len() && difference == 0).then_some(rest)
    }
}

impl fmt::Display for PageAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "http://{}/{}/", self.local(), self.token)
    }
}

/// Starts the browser of the user. Returns whether it could be started.
pub(super) fn open_browser(address: &PageAddress) -> bool {
    let (program, first): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("cmd", &["/C", "start", ""])
    } else {
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command.args(first).arg(address.to_string());
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(socket: &str) -> PageAddress {
        PageAddress { socket: socket.parse().expect("a socket"), token: "00ff".to_owned() }
    }

    #[test]
    fn hosts_are_addresses_of_the_server_and_localhost() {
        let loopback = address("127.0.0.1:8000");
        assert!(loopback.is_host("127.0.0.1:8000") && loopback.is_host("localhost:8000"));
        for host in ["", "127.0.0.1", "127.0.0.1:80", "evil.example:8000", "192.168.0.2:8000"] {
            assert!(!loopback.is_host(host), "{host}");
        }
        let http = address("127.0.0.1:80");
        for host in ["127.0.0.1", "localhost", "127.0.0.1:80", "localhost:80"] {
            assert!(http.is_host(host), "{host}");
            assert!(!loopback.is_host(host) && !address("[::1]:80").is_host("127.0.0.1"), "{host}");
        }
        for host in ["", "127.0.0.2", "localhost:8000", "evil.example", "[::1]"] {
            assert!(!http.is_host(host), "{host}");
        }
        assert!(address("[::1]:80").is_host("[::1]") && address("[::1]:80").is_host("[::1]:80"));
        let all = address("0.0.0.0:8000");
        assert!(all.is_host("192.168.0.2:8000") && !all.is_host("evil.example:8000"));
        assert_eq!(all.to_string(), "http://127.0.0.1:8000/00ff/");
    }

    #[test]
    fn only_the_whole_token_opens_the_page() {
        let address = address("127.0.0.1:8000");
        assert_eq!(address.behind_token("/00ff/style.css"), Some("style.css"));
        assert_eq!(address.behind_token("/00ff/"), Some(""));
        for path in ["", "/", "//", "/00ff", "/00f/", "/00fe/", "/00fff/", "00ff/", "/00FF/"] {
            assert_eq!(address.behind_token(path), None, "{path}");
        }
    }
}
