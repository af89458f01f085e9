//! A server in a thread, requests as text, and a client that draws what it gets.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use serde_json::{Value as Json, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Error, Message, WebSocket};
use turner_serve::{Options, Server, Stopper};

/// Longest wait for anything.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// A scene that is quick to render: a red and a small green ball.
pub(crate) const SCENE: &str = r#"
[film]
width = 200
height = 136
samples = 1

[camera]
position = [0, 0, 6]
look_at = [0, 0, 0]

[material.red]
type = "matte"
color = [0.8, 0.1, 0.1]

[material.green]
type = "matte"
color = [0.1, 0.8, 0.1]

[[object]]
type = "sphere"
radius = 1
material = "red"

[[object]]
type = "sphere"
center = [2.4, -1.6, 0]
radius = 0.2
material = "green"

[[light]]
type = "point"
position = [3, 5, 6]
intensity = 60
"#;

pub(crate) struct Running {
    pub(crate) owner: String,
    pub(crate) viewers: String,
    stopper: Stopper,
    thread: Option<JoinHandle<std::io::Result<()>>>,
}

impl Running {
    pub(crate) fn start() -> Running {
        let bind = Some([127, 0, 0, 1].into());
        let names = vec!["lab.example".to_owned()];
        let options = Options { bind, port: Some(0), share: true, names, ..Options::default() };
        let server = Server::new(options).unwrap();
        let (owner, viewers) = (server.owner(), server.viewers().unwrap());
        let stopper = server.stopper();
        Running { owner, viewers, stopper, thread: Some(std::thread::spawn(move || server.run())) }
    }

    /// `127.0.0.1:port`.
    pub(crate) fn host(&self) -> &str {
        self.owner.split('/').nth(2).unwrap()
    }

    /// The path with the owner's token.
    pub(crate) fn path(&self) -> String {
        format!("/{}/", self.owner.split('/').nth(3).unwrap())
    }

    /// Ends the server and returns how long that took.
    pub(crate) fn stop(&mut self) -> Duration {
        let begun = Instant::now();
        self.stopper.stop();
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap().unwrap();
        }
        begun.elapsed()
    }

    /// The answer to a request with these lines.
    pub(crate) fn ask(&self, lines: &str) -> String {
        let mut stream = TcpStream::connect(self.host()).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(stream, "{}\r\nConnection: close\r\n\r\n", lines.trim().replace('\n', "\r\n")).unwrap();
        let mut answer = Vec::new();
        // A refused request may end with a reset.
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    pub(crate) fn get(&self, path: &str) -> String {
        self.ask(&format!("GET {path} HTTP/1.1\nHost: {}", self.host()))
    }

    pub(crate) fn connect(&self) -> Client {
        Client::new(&self.owner)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stopper.stop();
    }
}

/// A picture as it arrived.
#[derive(Clone, Debug, Default)]
pub(crate) struct Picture {
    pub(crate) number: u32,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) rgba: Vec<u8>,
    pub(crate) detail: Json,
    /// Tiles in the last message, and the tiles of the whole picture.
    pub(crate) tiles: [u32; 2],
    pub(crate) bytes: usize,
    /// 1 RGBA, 2 packed.
    pub(crate) flags: u8,
}

pub(crate) enum Heard {
    Json(Json),
    Picture,
    Bytes(Json, Vec<u8>),
}

pub(crate) struct Client {
    pub(crate) socket: WebSocket<TcpStream>,
    next: u64,
    pub(crate) picture: Picture,
    /// Whether pictures are acknowledged.
    pub(crate) sees: bool,
    /// A wait before each acknowledgement.
    pub(crate) delay: Option<Duration>,
    /// Pictures that arrived.
    pub(crate) pictures: usize,
    pub(crate) fewest_tiles: u32,
}

impl Client {
    pub(crate) fn new(address: &str) -> Client {
        let host = address.split('/').nth(2).unwrap();
        let mut request =
            format!("{}socket", address.replacen("http", "ws", 1)).into_client_request().unwrap();
        request.headers_mut().insert("Origin", format!("http://{host}").parse().unwrap());
        let stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.set_nodelay(true).unwrap();
        let (socket, _) = tungstenite::client(request, stream).unwrap();
        Client {
            socket,
            next: 1,
            picture: Picture::default(),
            sees: true,
            delay: None,
            pictures: 0,
            fewest_tiles: u32::MAX,
        }
    }

    pub(crate) fn text(&mut self, text: &str) {
        self.socket.send(Message::Text(text.into())).unwrap();
    }

    pub(crate) fn binary(&mut self, bytes: &[u8]) {
        self.socket.send(Message::Binary(bytes.to_vec().into())).unwrap();
    }

    /// The next message.
    pub(crate) fn hear(&mut self) -> Result<Heard, Error> {
        loop {
            match self.socket.read()? {
                Message::Text(text) => return Ok(Heard::Json(serde_json::from_str(&text).unwrap())),
                Message::Binary(bytes) if bytes[0] == 1 => {
                    self.draw(&bytes);
                    if let Some(delay) = self.delay {
                        std::thread::sleep(delay);
                    }
                    if self.sees {
                        self.acknowledge();
                    }
                    return Ok(Heard::Picture);
                }
                Message::Binary(bytes) => {
                    let end = 8 + u32::from_le_bytes(bytes[4..8].try_into().unwrap()) as usize;
                    let json = serde_json::from_slice(&bytes[8..end]).unwrap();
                    return Ok(Heard::Bytes(json, bytes[end..].to_vec()));
                }
                Message::Close(frame) => {
                    let text = frame.map_or(String::new(), |f| format!("{} {}", f.code, f.reason));
                    return Err(Error::Io(std::io::Error::other(text)));
                }
                _ => {}
            }
        }
    }

    pub(crate) fn acknowledge(&mut self) {
        let seen = json!({ "seen": self.picture.number });
        self.text(&seen.to_string());
    }

    fn draw(&mut self, bytes: &[u8]) {
        let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        let short = |at: usize| u16::from_le_bytes(bytes[at..at + 2].try_into().unwrap()) as usize;
        let (width, height, tiles, json) = (number(8), number(12), number(16) as usize, number(20) as usize);
        let picture = &mut self.picture;
        if (picture.width, picture.height) != (width, height) {
            picture.rgba = vec![0; 4 * (width * height) as usize];
        }
        (picture.number, picture.width, picture.height) = (number(4), width, height);
        picture.detail = serde_json::from_slice(&bytes[24 + 8 * tiles..24 + 8 * tiles + json]).unwrap();
        picture.tiles = [tiles as u32, width.div_ceil(64) * height.div_ceil(64)];
        picture.bytes = bytes.len();
        self.pictures += 1;
        self.fewest_tiles = self.fewest_tiles.min(tiles as u32);
        let flags = bytes[1];
        picture.flags = flags;
        let channels = if flags & 1 != 0 { 4 } else { 3 };
        let packed = flags & 2 != 0;
        let mut rest = bytes[24 + 8 * tiles + json..].to_vec();
        if packed {
            rest = miniz_oxide::inflate::decompress_to_vec_zlib(&rest).unwrap();
        }
        let mut pixels = rest.chunks_exact(channels);
        for tile in 0..tiles {
            let [x, y, w, h] = [0, 2, 4, 6].map(|at| short(24 + 8 * tile + at));
            for row in y..y + h {
                let mut last = [0_u8; 4];
                for column in x..x + w {
                    let mut pixel = [0, 0, 0, 255];
                    pixel[..channels].copy_from_slice(pixels.next().unwrap());
                    if packed {
                        for c in 0..channels {
                            pixel[c] = last[c].wrapping_add(pixel[c]);
                        }
                        last = pixel;
                    }
                    let at = 4 * (row * width as usize + column);
                    picture.rgba[at..at + 4].copy_from_slice(&pixel);
                }
            }
        }
        assert!(pixels.next().is_none() && pixels.remainder().is_empty());
    }

    /// Sends a call.
    pub(crate) fn send(&mut self, name: &str, args: Json) -> u64 {
        let id = self.next;
        self.next += 1;
        self.text(&json!({ "id": id, "name": name, "args": args }).to_string());
        id
    }

    /// Makes a call.
    pub(crate) fn call(&mut self, name: &str, args: Json) -> Result<(Json, Vec<u8>), Json> {
        let id = self.send(name, args);
        loop {
            let (json, bytes) = match self.hear().unwrap() {
                Heard::Json(json) => (json, Vec::new()),
                Heard::Bytes(json, bytes) => (json, bytes),
                Heard::Picture => continue,
            };
            if json["id"] == id {
                return match json.get("error") {
                    Some(error) => Err(error.clone()),
                    None => Ok((json["ok"].clone(), bytes)),
                };
            }
        }
    }

    /// Sends a part of a file for the next call.
    pub(crate) fn part(&mut self, name: &str, bytes: &[u8]) {
        let id = u32::try_from(self.next).unwrap().to_le_bytes();
        let length = u32::try_from(name.len()).unwrap().to_le_bytes();
        self.binary(&[&[3, 0, 0, 0], &id[..], &length, name.as_bytes(), bytes].concat());
    }

    pub(crate) fn open(&mut self, text: &str) {
        let (first, second) = text.as_bytes().split_at(100);
        self.part("a/scene.toml", first);
        self.part("a/scene.toml", second);
        self.call("open", json!({})).unwrap();
    }

    /// Waits for the first message that `is` what is wanted.
    pub(crate) fn wait(&mut self, is: impl Fn(&Json) -> bool) -> Json {
        let end = Instant::now() + PATIENCE;
        while Instant::now() < end {
            if let Heard::Json(json) = self.hear().unwrap()
                && is(&json)
            {
                return json;
            }
        }
        panic!("it did not come");
    }

    /// Waits for the settled picture of another number than `last`.
    pub(crate) fn settled(&mut self, last: u32) {
        let end = Instant::now() + PATIENCE;
        while self.picture.detail["stage"] != "settled" || self.picture.number == last {
            assert!(Instant::now() < end, "the picture does not settle: {}", self.picture.detail);
            self.hear().unwrap();
        }
    }
}
