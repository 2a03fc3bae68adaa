//! `petzval view`: its page, its pictures, and what it refuses.

#[path = "../support/mod.rs"]
mod support;

mod accuracy;
mod lens_bench;
mod saving;

use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use petzval_image::Picture;
use serde_json::{Value, json};
use support::{folder, root, wait_until};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

/// The longest wait for anything.
const HANG: Duration = Duration::from_secs(60);

/// A running `petzval view`, which ends with this.
struct View {
    child: Child,
    socket: SocketAddr,
    token: String,
}

impl View {
    /// Shows a scene of the repository.
    fn start(scene: &str, options: &[&str]) -> Self {
        Self::start_in(root(), scene, options)
    }

    /// Shows a scene of the folder `scenes` in another one, which is the current folder.
    fn start_in(folder: &Path, scene: &str, options: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_petzval"));
        command.args(["view", &format!("scenes/{scene}"), "--no-open", "--threads", "1"]);
        command.args(options).current_dir(folder);
        let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = child.spawn().expect("the command starts");
        let mut address = String::new();
        let output = child.stdout.as_mut().expect("its output");
        BufReader::new(output).read_line(&mut address).expect("its address");
        let rest = address.trim().strip_prefix("http://").expect("an address");
        let (socket, token) = rest.split_once('/').expect("a token");
        Self { child, socket: socket.parse().expect("a socket"), token: token.to_owned() }
    }

    fn small() -> Self {
        Self::start("dgauss.pbrt", &["--resolution", "48x32", "--spp", "6"])
    }

    /// Sends bytes, and returns the reply.
    fn exchange(&self, request: &[u8]) -> String {
        let mut stream = self.connect();
        // A refused request may be closed before all of it is sent.
        let _ = stream.write_all(request);
        let mut reply = Vec::new();
        let _ = stream.read_to_end(&mut reply);
        String::from_utf8_lossy(&reply).into_owned()
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.socket).expect("a connection");
        stream.set_read_timeout(Some(HANG)).expect("a timeout");
        stream
    }

    /// Returns the reply to a request of a path of the server, with more headers.
    fn get(&self, path: &str, headers: &str) -> String {
        let host = self.socket;
        self.exchange(format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{headers}\r\n").as_bytes())
    }

    /// Returns the status of the reply to a path behind the token.
    fn status(&self, path: &str) -> u32 {
        status(&self.get(&format!("/{}{path}", self.token), ""))
    }

    fn client(&self) -> Client {
        self.try_client(&[]).expect("a WebSocket")
    }

    fn try_client(&self, headers: &[(&'static str, &str)]) -> Result<Client, String> {
        let address = format!("ws://{}/{}socket", self.socket, self.token);
        let mut request = address.into_client_request().expect("a request");
        for (name, value) in headers {
            request.headers_mut().insert(*name, value.parse().expect("a header"));
        }
        let connected = tungstenite::client(request, self.connect());
        connected.map(|(socket, _)| Client(socket)).map_err(|error| error.to_string())
    }

    /// Returns the resident memory without files (kB).
    #[cfg(target_os = "linux")]
    fn memory(&self) -> u64 {
        let status = format!("/proc/{}/status", self.child.id());
        let status = std::fs::read_to_string(status).expect("its status");
        let line = status.lines().find_map(|line| line.strip_prefix("RssAnon:"));
        let number = line.and_then(|line| line.split_whitespace().next()?.parse().ok());
        number.expect("a number of kB")
    }

    #[cfg(target_os = "linux")]
    fn threads(&self) -> usize {
        let tasks = format!("/proc/{}/task", self.child.id());
        std::fs::read_dir(tasks).expect("its threads").count()
    }
}

impl Drop for View {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn status(reply: &str) -> u32 {
    let status = reply.split(' ').nth(1).and_then(|status| status.parse().ok());
    status.unwrap_or_else(|| panic!("no status in {reply:?}"))
}

/// A page without a browser.
struct Client(WebSocket<TcpStream>);

/// A frame, as the page receives it.
struct Received {
    picture: Picture,
    samples: u32,
    finished: bool,
    draft: bool,
    generation: u64,
}

impl Received {
    fn new(bytes: &[u8]) -> Self {
        assert_eq!(&bytes[..4], b"PZV1");
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("4 bytes"));
        let size = [4, 8].map(|at| word(at) as usize);
        let value = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().expect("4 bytes"));
        let values: Vec<f32> = bytes[32..].chunks_exact(4).map(value).collect();
        assert_eq!(values.len(), 3 * size[0] * size[1]);
        let pixels = values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
        let generation = u64::from_le_bytes(bytes[24..32].try_into().expect("8 bytes"));
        let (draft, finished) = (word(20) & 1 == 1, word(20) & 2 == 2);
        let picture = Picture { size, pixels };
        Self { picture, samples: word(12), finished, draft, generation }
    }
}

impl Client {
    fn send(&mut self, message: &Value) {
        self.0.send(Message::text(message.to_string())).expect("the message is sent");
    }

    /// Returns the next message of a type.
    fn hear(&mut self, kind: &str) -> Value {
        self.hear_one(&[kind])
    }

    /// Returns the next message of one of these types.
    fn hear_one(&mut self, kinds: &[&str]) -> Value {
        let start = Instant::now();
        loop {
            // Pings come all the time.
            assert!(start.elapsed() < HANG, "no message of the types {kinds:?} comes");
            if let Message::Text(text) = self.0.read().expect("a message") {
                let message: Value = serde_json::from_str(&text).expect("JSON");
                if kinds.iter().any(|kind| message["type"] == *kind) {
                    return message;
                }
            }
        }
    }

    fn next_frame(&mut self) -> Received {
        self.send(&json!({ "type": "next" }));
        let start = Instant::now();
        loop {
            assert!(start.elapsed() < HANG, "no frame comes");
            // Blur maps are another kind of message.
            if let Message::Binary(bytes) = self.0.read().expect("a message")
                && bytes.starts_with(b"PZV1")
            {
                return Received::new(&bytes);
            }
        }
    }

    /// Sets options and returns the finished picture.
    fn set(&mut self, options: Value) -> Received {
        self.send(&json!({ "type": "set", "options": options }));
        let generation = self.hear("set")["generation"].as_u64().expect("a number");
        self.finished(generation)
    }

    fn finished(&mut self, generation: u64) -> Received {
        loop {
            let frame = self.next_frame();
            if frame.finished && frame.generation == generation {
                return frame;
            }
        }
    }
}

#[test]
fn the_page_is_behind_its_token() {
    let view = View::small();
    assert!(view.socket.ip().is_loopback(), "{}", view.socket);
    assert_eq!(view.token.len(), 33, "128 bits and a slash: {}", view.token);
    for path in ["/", "/style.css", "/0123456789abcdef0123456789abcdef/", "/socket"] {
        let reply = view.get(path, "");
        assert_eq!(status(&reply), 403, "{path}: {reply}");
        assert!(!reply.contains(&view.token), "{reply}");
    }
    let page = view.get(&format!("/{}", view.token), "");
    assert_eq!(status(&page), 200);
    assert!(page.contains("Content-Security-Policy: default-src 'none'"), "{page}");
    let posted = format!("POST /{} HTTP/1.1\r\nHost: {}\r\n\r\n", view.token, view.socket);
    assert_eq!(status(&view.exchange(posted.as_bytes())), 405);
}

#[test]
fn other_hosts_and_origins_are_refused() {
    let view = View::small();
    let path = format!("/{}", view.token);
    for host in ["evil.example", "evil.example:80", "127.0.0.1:1", "", "127.0.0.1\r\nHost: x"] {
        let request = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n");
        assert_eq!(status(&view.exchange(request.as_bytes())), 403, "{host}");
    }
    for origin in ["http://evil.example", "null", "https://127.0.0.1", "http://localhost:1"] {
        assert_eq!(status(&view.get(&path, &format!("Origin: {origin}\r\n"))), 403, "{origin}");
        assert!(view.try_client(&[("Origin", origin)]).is_err(), "{origin}");
    }
    let own = format!("http://{}", view.socket);
    assert!(view.try_client(&[("Origin", &own)]).is_ok());
}

#[test]
fn no_file_of_the_disk_is_served() {
    let view = View::small();
    for path in [
        "../Cargo.toml",
        "..%2fCargo.toml",
        "%2e%2e/Cargo.toml",
        "/etc/passwd",
        "etc/passwd",
        "section/../style.css",
        "section/99999.svg",
        "section/-1.svg",
        "style.css\0",
        "Cargo.toml",
        "main.rs",
    ] {
        let status = view.status(path);
        assert!(status == 404 || status == 400, "{path}: {status}");
    }
    for path in ["main.js", "icon.svg", "lenses.json", "section/0.svg"] {
        assert_eq!(view.status(path), 200, "{path}");
    }
}

#[test]
fn the_page_names_no_other_server() {
    let folder = root().join("src/cli/view/page");
    for entry in std::fs::read_dir(folder).expect("the page") {
        let path = entry.expect("an entry").path();
        let text = std::fs::read_to_string(&path).expect("a text");
        // The name of a language, which nobody fetches.
        let text = text.replace("http://www.w3.org/2000/svg", "");
        for scheme in ["http:", "https:", "src=\"//", "url(//", "@import"] {
            let foreign = text.contains(scheme) && path.extension().is_some_and(|e| e != "js");
            assert!(!foreign, "{}: {scheme}", path.display());
        }
        assert!(!text.contains("http://") && !text.contains("https://"), "{}", path.display());
    }
}

#[test]
fn hostile_requests_and_messages_end_their_own_connection() {
    let view = View::small();
    let long = format!("GET /{} HTTP/1.1\r\nX: {}\r\n\r\n", view.token, "a".repeat(20_000));
    let reply = view.exchange(long.as_bytes());
    assert!(reply.is_empty() || status(&reply) == 431, "{reply}");
    assert_eq!(status(&view.exchange(b"\x16\x03\x01 nonsense \r\n\r\n")), 400);
    // Connections that send nothing hold no others up.
    let idle: Vec<TcpStream> = (0..20).map(|_| view.connect()).collect();
    let mut client = view.client();
    client.0.send(Message::text("a".repeat(100_000))).expect("the message is sent");
    // It would be refused as one that is no JSON.
    let answer = loop {
        match client.0.read() {
            Ok(Message::Text(text)) if text.contains("expected JSON") => break Ok(text),
            Ok(_) => {}
            Err(tungstenite::Error::Io(error)) if error.kind() == ErrorKind::WouldBlock => {
                break Ok("the connection stays open".into());
            }
            Err(error) => break Err(error),
        }
    };
    assert!(answer.is_err(), "a message of 100 kB is taken: {answer:?}");
    let mut client = view.client();
    for message in ["", "{", "[]", "{\"type\":\"set\"}", "{\"type\":\"x\"}"] {
        client.0.send(Message::text(message)).expect("the message is sent");
        client.hear("refused");
    }
    assert!(client.next_frame().picture.size[0] > 0);
    drop(idle);
}

#[test]
fn settings_that_are_not_of_the_camera_are_refused() {
    let view = View::small();
    let mut client = view.client();
    client.hear("state");
    let mut refused = |options: Value| {
        client.send(&json!({ "type": "set", "options": options }));
        let answer = client.hear_one(&["refused", "set"]);
        answer["problem"].as_str().expect("a problem").to_owned()
    };
    assert!(refused(json!({ "output": "x.exr" })).contains("--output"));
    assert!(refused(json!({ "catalogue": "/" })).contains("--catalogue"));
    assert!(refused(json!({ "lens": "/etc/passwd" })).contains("lens drawer"));
    assert!(refused(json!({ "fstop": "-1" })).contains("f-number"));
    assert!(refused(json!({ "fstop": 4 })).contains("short text"));
    assert!(refused(json!({ "fstop": "4".repeat(2000) })).contains("short text"));
    // One that only the lens can refuse.
    client.send(&json!({ "type": "set", "options": { "fstop": "0.5" } }));
    loop {
        let state = client.hear("state");
        if let Some(error) = state["error"].as_str() {
            assert!(error.contains("--fstop 0.5"), "{error}");
            break;
        }
    }
    assert_eq!(client.set(json!({ "fstop": "4" })).samples, 6);
}

#[test]
fn pictures_beyond_the_memory_are_refused() {
    let options = ["--resolution", "48x32", "--spp", "6", "--memory", "1GB"];
    let view = View::start("dgauss.pbrt", &options);
    let mut client = view.client();
    client.hear("state");
    client.send(&json!({ "type": "set", "options": { "resolution": "11585x11585" } }));
    loop {
        let state = client.hear("state");
        if let Some(error) = state["error"].as_str() {
            assert!(error.contains("--memory allows 1.00 GB"), "{error}");
            break;
        }
    }
    assert_eq!(client.set(json!({ "resolution": "48x32" })).samples, 6);
}

#[test]
fn the_finished_picture_has_the_bits_of_its_command() {
    let view = View::start("dgauss.pbrt", &["--resolution", "45x31", "--spp", "9", "--fstop=4"]);
    let mut client = view.client();
    client.finished(1);
    let seen = client.set(json!({
        "focus": "auto@20,11",
        "look-at": "0.1,0,-0.2,0,0.01,3",
        "shutter": "time=1/30",
        "film-shift": "1,-2",
        "effects": "+ghosts"
    }));
    let mut client = view.client();
    let state = client.hear("state");
    assert_eq!(state["error"], Value::Null);
    let command = state["command"].as_str().expect("a command");
    let folder = folder();
    let path = folder.path().join("a.exr");
    let binary = PathBuf::from(env!("CARGO_BIN_EXE_petzval"));
    let command = command.strip_prefix("petzval").expect("the command");
    let line = format!("'{}' {command} -o '{}'", binary.display(), path.display());
    let run = Command::new("sh").args(["-c", &line]).current_dir(root()).output();
    let run = run.expect("a shell");
    assert!(run.status.success(), "{line}: {}", String::from_utf8_lossy(&run.stderr));
    let rendered = Picture::read(&path).expect("a picture");
    assert_eq!(seen.samples, 9);
    assert_eq!(seen.picture.size, rendered.size);
    let bits = |picture: &Picture| -> Vec<u32> {
        picture.pixels.as_flattened().iter().map(|value| value.to_bits()).collect()
    };
    assert_eq!(bits(&seen.picture), bits(&rendered), "{line}");
}

#[test]
fn a_smaller_film_sees_less_of_the_scene() {
    let view = View::start("dgauss.pbrt", &["--resolution", "48x32", "--spp", "1"]);
    let mut client = view.client();
    client.set(json!({ "film-diagonal": "35" }));
    let film: Vec<f64> =
        serde_json::from_value(view.client().hear("state")["film"].clone()).expect("two numbers");
    // 3 : 2, as the picture.
    assert!((film[0].hypot(film[1]) - 35.0).abs() < 1e-9, "{film:?}");
    assert!((film[0] / film[1] - 1.5).abs() < 1e-9, "{film:?}");
    client.send(&json!({ "type": "set", "options": { "film-diagonal": "-1" } }));
    client.hear("refused");
}

fn mean(frame: &Received) -> f64 {
    let values = frame.picture.pixels.as_flattened();
    values.iter().map(|&value| f64::from(value)).sum::<f64>() / values.len() as f64
}

#[test]
fn rings_change_the_exposure_by_their_factors() {
    let view = View::start("dgauss.pbrt", &["--resolution", "48x48", "--spp", "16"]);
    let mut client = view.client();
    let at = |client: &mut Client, options: Value| mean(&client.set(options));
    let long = at(&mut client, json!({ "fstop": "8", "shutter": "time=1/30" }));
    let short = at(&mut client, json!({ "shutter": "time=1/60" }));
    // The same samples, times another factor: only roundings of f32 differ.
    assert!((long / short - 2.0).abs() < 1e-5, "{long} and {short}");
    let closed = at(&mut client, json!({ "fstop": "16" }));
    // Two stops. Another pupil takes other rays: 5 % is far above their noise here.
    assert!((short / closed - 4.0).abs() < 0.2, "{short} and {closed}");
}

#[test]
fn a_click_moves_the_focus_and_movement_keeps_it() {
    let view = View::start("dgauss.pbrt", &["--resolution", "48x48", "--spp", "2"]);
    let mut client = view.client();
    client.finished(1);
    let first = client.set(json!({ "focus": "auto@24,24" })).generation;
    let state = |view: &View| view.client().hear("state");
    let focus = state(&view)["focus"].as_f64().expect("a distance");
    assert!(focus > 0.0);
    assert!(client.set(json!({ "look-at": "0,0.2,-0.1,0,0,3" })).generation > first);
    let moved = state(&view);
    let options = &moved["options"];
    assert!(!options["focus"].as_str().expect("a focus").starts_with("auto"), "{options}");
    let kept = moved["focus"].as_f64().expect("a distance");
    assert!((kept / focus - 1.0).abs() < 1e-3, "{kept} instead of {focus}");
}

#[test]
fn frames_come_to_two_clients_and_only_when_they_ask() {
    let view = View::small();
    let (mut one, mut other) = (view.client(), view.client());
    // This one never asks, and reads only at the end.
    let mut silent = view.client();
    for stop in ["4", "5.6", "8"] {
        let frame = one.set(json!({ "fstop": stop }));
        let same = other.finished(frame.generation);
        assert_eq!(same.picture.pixels, frame.picture.pixels);
    }
    silent.send(&json!({ "type": "nonsense" }));
    loop {
        match silent.0.read().expect("a message") {
            Message::Binary(_) => panic!("a frame that nobody asked for"),
            Message::Text(text) if text.contains("refused") => break,
            _ => {}
        }
    }
}

#[test]
fn drafts_come_before_the_picture() {
    let view = View::start("dgauss.pbrt", &["--resolution", "900x900", "--spp", "1"]);
    let mut client = view.client();
    let first = client.next_frame();
    assert!(first.draft && first.generation == 1 && first.picture.size[0] < 900);
    client.send(&json!({ "type": "set", "options": { "fstop": "4" } }));
    let generation = client.hear("set")["generation"].as_u64().expect("a number");
    let frame = loop {
        let frame = client.next_frame();
        if frame.generation == generation {
            break frame;
        }
    };
    assert!(frame.draft && frame.picture.size[0] < 900, "{:?}", frame.picture.size);
    assert_eq!(frame.picture.size[0], frame.picture.size[1]);
}

#[test]
fn the_blur_map_is_sharp_where_the_focus_is() {
    let view = View::start("dgauss.pbrt", &["--resolution", "60x40", "--spp", "1", "--fstop=2.1"]);
    let mut client = view.client();
    client.send(&json!({ "type": "set", "options": { "focus": "auto@30,30" } }));
    let generation = client.hear("set")["generation"].as_u64().expect("a number");
    let map = loop {
        client.send(&json!({ "type": "next" }));
        if let Message::Binary(bytes) = client.0.read().expect("a message")
            && bytes.starts_with(b"PZC1")
            && bytes[12..20] == generation.to_le_bytes()
        {
            break bytes;
        }
    };
    let float = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().expect("4 bytes"));
    let blur: Vec<f32> = map[20..].chunks_exact(4).map(float).collect();
    assert_eq!(blur.len(), 60 * 40);
    let [focus, front] = [30, 38].map(|y| blur[60 * y + 30]);
    // The floor in row 38 is much nearer than in row 30.
    assert!(focus > 0.0 && focus < 0.2 && front > 2.0 * focus, "{focus} and {front}");
    assert!(blur[30] > 2.0 * focus, "the sky has the blur of infinity: {}", blur[30]);
}

/// Reads one packet for tev: its kind and its content.
fn tev_packet(stream: &mut TcpStream) -> (u8, Vec<u8>) {
    let mut length = [0; 4];
    stream.read_exact(&mut length).expect("a length");
    let mut packet = vec![0; u32::from_le_bytes(length) as usize - 4];
    stream.read_exact(&mut packet).expect("a packet");
    (packet[0], packet.split_off(1))
}

#[test]
fn a_tev_that_takes_no_data_does_not_block_the_end() {
    let tev = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = tev.local_addr().expect("an address").to_string();
    // More than the buffers of a connection hold.
    let options = ["--resolution", "1200x1000", "--spp", "1", "--tev", &address];
    let mut view = View::start("dgauss.pbrt", &options);
    let (_stream, _) = tev.accept().expect("a connection");
    view.client().finished(1);
    std::thread::sleep(Duration::from_millis(500));
    support::workspace::signal(&view.child, "INT");
    wait_until("the end of the view", || view.child.try_wait().expect("a status").is_some());
}

#[test]
fn tev_receives_the_picture() {
    let tev = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = tev.local_addr().expect("an address").to_string();
    // More rows than one packet holds.
    let options = ["--resolution", "20x100", "--spp", "1", "--tev", &address];
    let view = View::start("dgauss.pbrt", &options);
    let seen = view.client().finished(1);
    let (mut stream, _) = tev.accept().expect("a connection");
    let start = b"\x01scenes/dgauss.pbrt\0";
    let (kind, content) = tev_packet(&mut stream);
    assert_eq!((kind, &content[..start.len()]), (4, &start[..]));
    let numbers = [20_i32, 100, 3].map(i32::to_le_bytes).concat();
    assert_eq!(content[start.len()..], [&numbers[..], b"R\0G\0B\0"].concat());
    let mut light = Vec::new();
    for (first, rows) in [(0, 64), (64, 36)] {
        let (kind, content) = tev_packet(&mut stream);
        assert_eq!(kind, 6);
        let head = start.len() + 4 + 6;
        let place = [0, first, 20, rows].map(i32::to_le_bytes).concat();
        assert_eq!(content[head..head + 16], place);
        let strides = [0_i64, 1, 2, 3, 3, 3].map(i64::to_le_bytes).concat();
        assert_eq!(content[head + 16..head + 64], strides);
        light.extend_from_slice(&content[head + 64..]);
    }
    let pixels = seen.picture.pixels.as_flattened();
    assert_eq!(light, pixels.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>());
}

#[cfg(target_os = "linux")]
#[test]
fn a_thousand_connections_leave_nothing_behind() {
    let view = View::small();
    view.client().finished(1);
    // The threads without a client: their number does not change for half a second.
    let (mut idle, mut since) = (view.threads(), Instant::now());
    wait_until("the first client's threads to end", || {
        let threads = view.threads();
        if threads != idle {
            (idle, since) = (threads, Instant::now());
        }
        since.elapsed() > Duration::from_millis(500)
    });
    let mut memory = 0;
    for i in 0..1000 {
        let mut client = view.client();
        if i % 2 == 0 {
            client.next_frame();
        }
        if i == 200 {
            memory = view.memory();
        }
    }
    // The allocator keeps some; the buffers of a connection that stays have 128 kB or more.
    let grown = view.memory().saturating_sub(memory);
    assert!(grown < 40 << 10, "{grown} kB more after 800 connections");
    wait_until("the threads of closed connections to end", || view.threads() <= idle);
    assert_eq!(view.status(""), 200);
}

#[cfg(unix)]
#[test]
fn a_signal_ends_it_with_the_code_of_other_commands() {
    let mut view = View::small();
    let mut client = view.client();
    client.next_frame();
    let signal = Command::new("kill").args(["-TERM", &view.child.id().to_string()]).status();
    assert!(signal.expect("kill").success());
    let mut code = None;
    wait_until("the command to end", || {
        code = view.child.try_wait().expect("a child");
        code.is_some()
    });
    assert_eq!(code.and_then(|code| code.code()), Some(130));
    // The client is told, and does not hang.
    while client.0.read().is_ok() {}
}
