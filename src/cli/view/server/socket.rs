//! WebSocket of a client: one thread reads its wishes, another writes what it asks for.
//!
//! A client gets the next frame only once it asks, so that frames never queue for a slow one.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::atomic::Ordering;
use std::thread;
use std::time::Duration;

use serde_json::{Map, Value, json};
use tungstenite::handshake::derive_accept_key;
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Bytes, Message, WebSocket};

use super::Server;
use super::client::Client;
use crate::cli::option_names::with_option_names;
use crate::cli::view::state::Shared;

/// Largest message of a client (bytes).
const MAX_MESSAGE: usize = 16 << 10;
/// Time between pings, which tell whether a client is still there.
const PING: Duration = Duration::from_secs(20);
/// Time without a message or a pong after which a client is gone.
const SILENCE: Duration = Duration::from_secs(60);

/// The side of a connection that only reads. tungstenite answers pings while it reads; the writer
/// does that here, so that the two never write into each other's messages.
struct ReadSide<'a>(&'a TcpStream);

impl Read for ReadSide<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.0.read(buffer)
    }
}

impl Write for ReadSide<'_> {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        Ok(buffer.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// News for a client.
enum News {
    Message(Message),
    /// The picture, and its number.
    Frame(u64, Bytes),
    /// The panel, and its number.
    Panel(u64, Message),
    /// The blur map, and its number.
    Blur(u64, Bytes),
    /// The background work, and its number.
    Work(u64, Message),
    End,
}

impl Server {
    /// Serves a client until it closes the connection or the view ends.
    pub(super) fn serve_client(&self, mut stream: &TcpStream, key: &str) -> io::Result<()> {
        let accept = derive_accept_key(key.as_bytes());
        stream.write_all(
            format!(
                "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
                 Sec-WebSocket-Accept: {accept}\r\n\r\n"
            )
            .as_bytes(),
        )?;
        stream.set_read_timeout(Some(SILENCE))?;
        let client = Client::default();
        thread::scope(|scope| {
            scope.spawn(|| {
                self.write_news(stream, &client);
                // The reader waits for the client.
                let _ = stream.shutdown(Shutdown::Both);
            });
            self.read_wishes(stream, &client);
            client.closed.store(true, Ordering::Relaxed);
            self.state.notify();
        });
        Ok(())
    }

    fn read_wishes(&self, stream: &TcpStream, client: &Client) {
        let config = WebSocketConfig::default()
            .read_buffer_size(4 << 10)
            .max_message_size(Some(MAX_MESSAGE))
            .max_frame_size(Some(MAX_MESSAGE));
        let mut socket = WebSocket::from_raw_socket(ReadSide(stream), Role::Server, Some(config));
        while let Ok(message) = socket.read()
            && !client.closed.load(Ordering::Relaxed)
        {
            match message {
                Message::Text(text) => {
                    if let Err(problem) = self.heed(text.as_str(), client) {
                        let answer = json!({ "type": "refused", "problem": problem });
                        client.answer(Message::text(&*with_option_names(&answer.to_string())));
                    }
                }
                Message::Ping(payload) => client.answer(Message::Pong(payload)),
                Message::Close(_) => return,
                Message::Pong(_) | Message::Binary(_) | Message::Frame(_) => {}
            }
            self.state.notify();
        }
    }

    /// Does what a message asks for.
    fn heed(&self, message: &str, client: &Client) -> Result<(), String> {
        let wish: Map<String, Value> =
            serde_json::from_str(message).map_err(|error| format!("expected JSON: {error}"))?;
        let text = |name: &str| {
            let text = wish.get(name).and_then(Value::as_str);
            text.ok_or_else(|| format!("expected a text as {name}"))
        };
        match (wish.get("type").and_then(Value::as_str), wish.get("options")) {
            (Some("next"), _) => {
                client.asked.store(true, Ordering::Relaxed);
                Ok(())
            }
            (Some("set"), Some(Value::Object(options))) => {
                if let Some(Value::String(lens)) = options.get("lens")
                    && !self.drawer.holds(lens)
                {
                    return Err(format!("{lens} is not in the lens drawer"));
                }
                let generation = self.state.set(options)?;
                let answer = json!({ "type": "set", "generation": generation });
                client.answer(Message::text(answer.to_string()));
                Ok(())
            }
            (Some("save"), _) => self.save(text("name")?, client),
            (Some("render"), _) => {
                let (settings, _) = self.state.settings();
                self.final_render.start(text("name")?, &settings)
            }
            (Some("accuracy"), _) => {
                let budget = wish.get("budget").and_then(Value::as_f64);
                let budget = budget.ok_or("expected a number of seconds as budget")?;
                let (settings, _) = self.state.settings();
                self.accuracy.start(budget, &settings)
            }
            (Some("cancel"), _) => {
                self.background.cancel();
                Ok(())
            }
            _ => Err("expected the type next, set with options, save, render, accuracy or cancel"
                .to_owned()),
        }
    }

    /// Saves the scene with the settings that are shown.
    fn save(&self, name: &str, client: &Client) -> Result<(), String> {
        let (settings, focus) = self.state.settings();
        let bench = self.state.bench().ok_or("there is no picture yet")?;
        let saved = self.saver.save(name, &settings, bench.camera(), focus)?;
        let file = saved.file.display().to_string();
        let answer = json!({ "type": "saved", "file": file, "command": saved.command });
        client.answer(Message::text(answer.to_string()));
        Ok(())
    }

    fn write_news(&self, stream: &TcpStream, client: &Client) {
        let mut socket = WebSocket::from_raw_socket(stream, Role::Server, None);
        let mut seen = Seen::default();
        loop {
            let news = self.state.wait(PING, |shared| next_news(shared, client, &seen));
            let message = match news {
                None => Message::Ping(Bytes::new()),
                Some(News::Message(message)) => message,
                Some(News::Frame(number, message)) => {
                    seen.frame = number;
                    client.asked.store(false, Ordering::Relaxed);
                    Message::Binary(message)
                }
                Some(News::Panel(number, message)) => {
                    seen.panel = number;
                    message
                }
                Some(News::Work(number, message)) => {
                    seen.work = number;
                    message
                }
                Some(News::Blur(number, message)) => {
                    seen.blur = number;
                    Message::Binary(message)
                }
                Some(News::End) => {
                    let _ = socket.close(None);
                    return;
                }
            };
            if socket.send(message).is_err() {
                return;
            }
        }
    }
}

/// The numbers of the last messages that a client has got.
#[derive(Default)]
struct Seen {
    frame: u64,
    panel: u64,
    blur: u64,
    work: u64,
}

/// Returns what a client does not know yet.
fn next_news(shared: &Shared, client: &Client, seen: &Seen) -> Option<News> {
    if shared.stopped || client.closed.load(Ordering::Relaxed) {
        return Some(News::End);
    }
    if let Some(answer) = client.next_answer() {
        return Some(News::Message(answer));
    }
    if shared.panel_message.0 > seen.panel {
        let (number, message) = shared.panel_message.clone();
        return Some(News::Panel(number, Message::Text(message)));
    }
    if shared.work_message.0 > seen.work {
        let (number, message) = shared.work_message.clone();
        return Some(News::Work(number, Message::Text(message)));
    }
    if !client.asked.load(Ordering::Relaxed) {
        return None;
    }
    if shared.blur_message.0 > seen.blur {
        let (number, message) = shared.blur_message.clone();
        return Some(News::Blur(number, message));
    }
    (shared.frame_message.0 > seen.frame).then(|| {
        let (number, message) = shared.frame_message.clone();
        News::Frame(number, message)
    })
}
