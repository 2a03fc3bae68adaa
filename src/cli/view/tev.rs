//! Stream to tev, a viewer of pictures: the frames by tev's protocol over TCP.
//!
//! Protocol: `src/python/ipc.py` of tev (Müller). A packet is its length in bytes as a 32-bit
//! number, its kind, and its content, all little-endian.

use std::io::{self, ErrorKind, Write};
use std::net::TcpStream;
use std::time::Duration;

use super::frame::ViewFrame;
use super::state::ViewState;
use crate::cli::Failure;

/// Kinds of packets.
const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE_V3: u8 = 6;

/// Rows of a picture in one packet.
const ROWS: usize = 64;

/// Time between looks at whether the view has ended.
const LOOK: Duration = Duration::from_secs(1);
/// The same while tev takes no data.
const PATIENCE: Duration = Duration::from_millis(200);

/// A connection to tev.
pub(super) struct TevStream {
    address: String,
    stream: TcpStream,
    /// The name of the picture in tev.
    name: String,
}

impl TevStream {
    /// Connects to tev at `host:port`.
    pub fn connect(address: &str, name: String) -> Result<Self, Failure> {
        let stream = TcpStream::connect(address).map_err(|error| {
            format!(
                "--tev {address}: {error}; expected the host and port of a running tev, such as \
                 127.0.0.1:14158"
            )
        })?;
        stream.set_write_timeout(Some(PATIENCE))?;
        Ok(Self { address: address.to_owned(), stream, name })
    }

    /// Sends the frames in full resolution until the view ends or tev does.
    pub fn run(mut self, state: &ViewState) {
        let (mut seen, mut size) = (0, None);
        loop {
            let number = state.wait(LOOK, |shared| match shared.frame_message.0 {
                _ if shared.stopped => Some(None),
                number => (number > seen).then_some(Some(number)),
            });
            match number {
                None => continue,
                Some(None) => return,
                Some(Some(number)) => seen = number,
            }
            let Some(frame) = state.frame().filter(|frame| !frame.draft) else { continue };
            if let Err(error) = self.send(&frame, &mut size, state) {
                if state.is_stopped() {
                    return;
                }
                say!("petzval: warning: --tev {}: {error}; no more frames go there", self.address);
                return;
            }
        }
    }

    /// Sends a frame, and creates its picture if tev has none of its size.
    fn send(
        &mut self,
        frame: &ViewFrame,
        size: &mut Option<[usize; 2]>,
        state: &ViewState,
    ) -> io::Result<()> {
        let [width, height] = frame.picture.size;
        if *size != Some(frame.picture.size) {
            let mut packet = self.packet(CREATE_IMAGE, true);
            put(&mut packet, width);
            put(&mut packet, height);
            put_channels(&mut packet);
            self.write(packet, state)?;
            *size = Some(frame.picture.size);
        }
        for (band, rows) in frame.picture.pixels.chunks(ROWS * width.max(1)).enumerate() {
            let mut packet = self.packet(UPDATE_IMAGE_V3, false);
            put_channels(&mut packet);
            for number in [0, band * ROWS, width, rows.len() / width.max(1)] {
                put(&mut packet, number);
            }
            // Offset and stride of each channel.
            for number in [0_i64, 1, 2, 3, 3, 3] {
                packet.extend(number.to_le_bytes());
            }
            rows.as_flattened().iter().for_each(|value| packet.extend(value.to_le_bytes()));
            self.write(packet, state)?;
        }
        Ok(())
    }

    /// Returns a packet of a kind up to the name of the picture, without its length.
    fn packet(&self, kind: u8, grab_focus: bool) -> Vec<u8> {
        let mut packet = vec![kind, u8::from(grab_focus)];
        packet.extend(self.name.bytes().filter(|&byte| byte != 0));
        packet.push(0);
        packet
    }

    /// Sends a packet. A tev that takes no data does not keep the view from its end.
    fn write(&mut self, packet: Vec<u8>, state: &ViewState) -> io::Result<()> {
        let length = (packet.len() + size_of::<u32>()) as u32;
        for bytes in [&length.to_le_bytes()[..], &packet] {
            let mut left = bytes;
            while !left.is_empty() {
                match self.stream.write(left) {
                    Ok(0) => return Err(ErrorKind::WriteZero.into()),
                    Ok(count) => left = &left[count..],
                    Err(error) => match error.kind() {
                        ErrorKind::Interrupted => {}
                        ErrorKind::WouldBlock | ErrorKind::TimedOut if !state.is_stopped() => {}
                        _ => return Err(error),
                    },
                }
            }
        }
        Ok(())
    }
}

fn put(packet: &mut Vec<u8>, number: usize) {
    packet.extend((number as i32).to_le_bytes());
}

/// Adds the number of channels and their names.
fn put_channels(packet: &mut Vec<u8>) {
    put(packet, 3);
    packet.extend(b"R\0G\0B\0");
}
