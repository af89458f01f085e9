//! The image viewer tev (<https://github.com/Tom94/tev>), over TCP.
//!
//! A packet is its length in bytes including the length (u32), its type (u8) and its content; integers are little
//! endian, strings end with a zero byte.
//!
//! | type | content |
//! |---|---|
//! | 4, create an image | focus (u8), name, width, height, number of channels (i32 each), their names |
//! | 3, update a channel | focus (u8), name, channel, x, y, width, height (i32 each), width x height floats |

use std::io::{self, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use turner::film::Picture;

const CREATE: u8 = 4;
const UPDATE: u8 = 3;
const CHANNELS: [&str; 4] = ["R", "G", "B", "A"];

/// The longest wait for an answer.
const TIMEOUT: Duration = Duration::from_secs(2);

/// A connection to the viewer.
pub(super) struct Tev {
    stream: TcpStream,
    name: String,
    is_created: bool,
}

impl Tev {
    /// Connects to `host:port`; the picture has this name in the viewer.
    pub(super) fn connect(address: &str, name: &str) -> io::Result<Tev> {
        let mut error = io::Error::new(io::ErrorKind::InvalidInput, "expected HOST:PORT");
        for address in address.to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, TIMEOUT) {
                Ok(stream) => {
                    stream.set_write_timeout(Some(TIMEOUT))?;
                    // A zero byte would end the name.
                    return Ok(Tev { stream, name: name.replace('\0', ""), is_created: false });
                }
                Err(e) => error = e,
            }
        }
        Err(error)
    }

    /// Sends the scene values of a picture.
    pub(super) fn show(&mut self, picture: &Picture) -> io::Result<()> {
        let size = [picture.width as i32, picture.height as i32];
        if !self.is_created {
            let mut packet = Packet::new(CREATE, &self.name);
            packet.integers(&size);
            packet.integers(&[CHANNELS.len() as i32]);
            CHANNELS.iter().for_each(|name| packet.text(name));
            self.stream.write_all(&packet.finish())?;
            self.is_created = true;
        }
        for (i, channel) in CHANNELS.iter().enumerate() {
            let mut packet = Packet::new(UPDATE, &self.name);
            packet.text(channel);
            packet.integers(&[0, 0]);
            packet.integers(&size);
            packet.bytes.extend(picture.linear.iter().flat_map(|pixel| pixel[i].to_le_bytes()));
            self.stream.write_all(&packet.finish())?;
        }
        self.stream.flush()
    }
}

struct Packet {
    bytes: Vec<u8>,
}

impl Packet {
    fn new(kind: u8, name: &str) -> Packet {
        // Its length, its type, and not to take the focus.
        let mut packet = Packet { bytes: vec![0, 0, 0, 0, kind, 0] };
        packet.text(name);
        packet
    }

    fn text(&mut self, text: &str) {
        self.bytes.extend(text.as_bytes());
        self.bytes.push(0);
    }

    fn integers(&mut self, integers: &[i32]) {
        self.bytes.extend(integers.iter().flat_map(|v| v.to_le_bytes()));
    }

    fn finish(mut self) -> Vec<u8> {
        let length = self.bytes.len() as u32;
        self.bytes[..4].copy_from_slice(&length.to_le_bytes());
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;
    use std::net::TcpListener;

    use super::*;

    #[test]
    fn a_picture_arrives() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let received = std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().unwrap();
            let mut bytes = Vec::new();
            stream.read_to_end(&mut bytes).unwrap();
            bytes
        });
        let linear = vec![[1.0, 2.0, 3.0, 1.0], [4.0, 5.0, 6.0, 0.5]];
        let picture = Picture {
            width: 2,
            height: 1,
            display: vec![[0; 4]; 2],
            linear,
            has_alpha: true,
            missing: 0,
            exposure: 0.0,
        };
        let mut tev = Tev::connect(&address, "a.png").unwrap();
        tev.show(&picture).unwrap();
        tev.show(&picture).unwrap();
        drop(tev);
        let bytes = received.join().unwrap();
        let mut rest = bytes.as_slice();
        let mut packets = Vec::new();
        while !rest.is_empty() {
            let length = u32::from_le_bytes(rest[..4].try_into().unwrap()) as usize;
            packets.push(&rest[4..length]);
            rest = &rest[length..];
        }
        assert_eq!(packets.len(), 1 + 4 + 4);
        assert_eq!(packets[0], b"\x04\0a.png\0\x02\0\0\0\x01\0\0\0\x04\0\0\0R\0G\0B\0A\0");
        let green = [&b"\x03\0a.png\0G\0"[..], &[0; 8], &[2, 0, 0, 0, 1, 0, 0, 0]].concat();
        assert_eq!(packets[2][..green.len()], green);
        assert_eq!(packets[2][green.len()..], [2.0f32.to_le_bytes(), 5.0f32.to_le_bytes()].concat());
    }
}
