//! One viewer's connection.
//!
//! Text messages are JSON. From the browser: `{id, name, args}`, a call, and `{seen: number}`, a picture that was drawn.
//! To it: `{id, ok}` or `{id, error}`, `{event, detail}`, and once, after what is open, `{started, threads, isolated,
//! memory, role}`.
//!
//! Binary messages begin with their kind. Numbers are little-endian.
//!
//! | kind | bytes |
//! |---|---|
//! | 1, to the browser | a picture: see `tiles` |
//! | 2, to the browser | an answer with bytes: u8 2, three zeros, u32 bytes of the JSON `{id, ok}`, the JSON, the bytes |
//! | 3, from the browser | a part of a file for the call `id` that follows: u8 3, three zeros, u32 id, u32 bytes of the name, the name in UTF-8, the bytes. Parts of the same name follow one another |

use std::sync::{Arc, Weak};
use std::time::Duration;

use axum::body::Bytes;
use axum::extract::ws::{CloseFrame, Message, WebSocket};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use serde_json::{Value as Json, json};
use tokio::sync::Semaphore;
use tokio::time::{sleep, timeout};
use turner_web::{Files, READS, REPLACES};

use crate::call_queue::Call;
use crate::hub::{Hub, Reservation};
use crate::outbox::{Answer, Outbox, Outgoing};
use crate::routes::Role;
use crate::tiles::Shown;

/// Longest message of a browser: 2 MiB and the head of a part of a file.
pub(crate) const MAX_MESSAGE: usize = (2 << 20) + (4 << 10);

/// Most files of a call.
const MAX_FILES: usize = 10_000;

/// Calls of a connection that wait: further ones stay in the connection.
const CALLS: [usize; 2] = [64, 4];

/// Time between two signs of life that the browser is asked for, and how long it may be silent.
const PULSE: Duration = Duration::from_secs(20);
const SILENCE: Duration = Duration::from_secs(65);

/// Longest time of sending a message.
const STUCK: Duration = Duration::from_secs(60);

/// Codes of the end of a connection (RFC 6455, 7.4.1).
const POLICY: u16 = 1008;
const TRY_LATER: u16 = 1013;

/// Serves a viewer until the connection ends.
pub(crate) async fn serve(socket: WebSocket, hub: Arc<Hub>, role: Role, threads: usize) {
    let hello = json!({
        "started": true,
        "threads": threads,
        "isolated": true,
        "memory": crate::hub::MAX_UPLOAD,
        "role": role.word(),
    });
    let (mut sink, stream) = socket.split();
    let Some(outbox) = hub.join(&hello.to_string()) else {
        let reason = "there are too many viewers";
        let _ = sink.send(Message::Close(Some(CloseFrame { code: TRY_LATER, reason: reason.into() }))).await;
        return;
    };
    let calls = Arc::new(Semaphore::new(CALLS[usize::from(role != Role::Owner)]));
    let reader = Reader { hub: Arc::clone(&hub), outbox: Arc::clone(&outbox), role, calls, upload: None };
    let mut writing = std::pin::pin!(write(sink, &hub, &outbox));
    tokio::select! {
        () = read(stream, reader) => {
            // What ended it may still be told.
            let _ = timeout(Duration::from_secs(1), writing).await;
        }
        () = &mut writing => {}
    }
}

/// Sends what waits, until the connection ends.
async fn write(mut sink: SplitSink<WebSocket, Message>, hub: &Arc<Hub>, outbox: &Arc<Outbox>) {
    // The picture that the viewer has.
    let mut base: Weak<Shown> = Weak::new();
    loop {
        let Some((outgoing, permit)) = outbox.take() else {
            tokio::select! {
                () = outbox.came.notified() => continue,
                () = sleep(PULSE) => {}
            }
            if !send(&mut sink, Message::Ping(Bytes::new())).await {
                return;
            }
            continue;
        };
        let message = match outgoing {
            Outgoing::Text(text) => Message::Text((&*text).into()),
            Outgoing::Bytes(json, bytes) => Message::Binary(with_json(&json, &bytes).into()),
            Outgoing::Close(code, reason) => {
                send(&mut sink, Message::Close(Some(CloseFrame { code, reason: reason.into() }))).await;
                return;
            }
            Outgoing::Picture(shown) => {
                let (hub, last, next) = (Arc::clone(hub), base.upgrade(), Arc::clone(&shown));
                let packed = outbox.is_slow();
                let make = move || hub.message(last.as_deref(), &next, packed);
                let Ok(bytes) = tokio::task::spawn_blocking(make).await else { return };
                base = Arc::downgrade(&shown);
                outbox.sending(shown.number, bytes.len());
                Message::Binary(bytes)
            }
        };
        if !send(&mut sink, message).await {
            return;
        }
        drop(permit);
    }
}

/// Whether a message was sent.
async fn send(sink: &mut SplitSink<WebSocket, Message>, message: Message) -> bool {
    matches!(timeout(STUCK, sink.send(message)).await, Ok(Ok(())))
}

/// A message of kind 2.
fn with_json(json: &str, bytes: &[u8]) -> Vec<u8> {
    let length = u32::try_from(json.len()).unwrap_or(u32::MAX).to_le_bytes();
    [&[2, 0, 0, 0], &length, json.as_bytes(), bytes].concat()
}

/// What a connection's messages are read with.
struct Reader {
    hub: Arc<Hub>,
    outbox: Arc<Outbox>,
    role: Role,
    calls: Arc<Semaphore>,
    upload: Option<Upload>,
}

/// Files for a call to come.
struct Upload {
    id: u64,
    files: Files,
    room: Reservation,
}

async fn read(mut stream: SplitStream<WebSocket>, mut reader: Reader) {
    loop {
        let message = match timeout(SILENCE, stream.next()).await {
            Ok(Some(Ok(message))) => message,
            Ok(Some(Err(_))) => {
                reader.outbox.close(POLICY, "a message is too long or malformed");
                return;
            }
            Ok(None) | Err(_) => {
                reader.outbox.close(POLICY, "the viewer is silent");
                return;
            }
        };
        let refused = match message {
            Message::Text(text) => reader.text(&text).await.err(),
            Message::Binary(bytes) => reader.part(&bytes).err(),
            Message::Close(_) => {
                reader.outbox.close(1000, "");
                return;
            }
            Message::Ping(_) | Message::Pong(_) => None,
        };
        if let Some(reason) = refused {
            reader.outbox.close(POLICY, reason);
            return;
        }
    }
}

impl Reader {
    /// A call or an acknowledgement.
    ///
    /// Errors: a message that is neither, which ends the connection.
    async fn text(&mut self, text: &str) -> Result<(), &'static str> {
        let Ok(Json::Object(mut message)) = serde_json::from_str::<Json>(text) else {
            return Err("a message is no JSON object");
        };
        if let Some(seen) = message.get("seen") {
            let number = seen.as_u64().and_then(|n| u32::try_from(n).ok());
            self.outbox.seen(number.ok_or("the number of a picture is wrong")?);
            return Ok(());
        }
        let id = message.get("id").and_then(Json::as_u64).ok_or("a call has no id")?;
        let Some(Json::String(name)) = message.remove("name") else { return Err("a call has no name") };
        let args = message.remove("args").unwrap_or_else(|| json!({}));
        let permit = Arc::clone(&self.calls).acquire_owned().await.ok();
        let answer = Answer::new(id, Arc::clone(&self.outbox), permit);
        let (files, room) = match self.upload.take() {
            Some(upload) if upload.id == id => (upload.files, Some(upload.room)),
            _ => (Files::new(), None),
        };
        if self.role != Role::Owner && !READS.contains(&&*name) {
            answer.give(Err(json!({
                "message": "this address only shows the picture",
                "help": "whoever started the server has the address that changes the scene",
            })));
            return Ok(());
        }
        let replaces = REPLACES.contains(&&*name);
        self.hub.calls.put(Call { name, args, files, room, answer }, self.role == Role::Owner);
        if replaces {
            self.hub.stop_step();
        }
        Ok(())
    }

    /// A part of a file.
    ///
    /// Errors: a message that is none, or too many bytes, which end the connection.
    fn part(&mut self, message: &[u8]) -> Result<(), &'static str> {
        if self.role != Role::Owner {
            return Err("a viewer sends no files");
        }
        const MALFORMED: &str = "a part of a file is malformed";
        let (head, rest) = message.split_first_chunk::<12>().ok_or(MALFORMED)?;
        let number = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let (name, bytes) = rest.split_at_checked(number(8) as usize).ok_or(MALFORMED)?;
        let name = std::str::from_utf8(name).map_err(|_| MALFORMED)?;
        if head[..4] != [3, 0, 0, 0] {
            return Err(MALFORMED);
        }
        let id = u64::from(number(4));
        // Files of another call are given up.
        self.upload = self.upload.take().filter(|upload| upload.id == id);
        let room = || self.hub.room();
        let upload = self.upload.get_or_insert_with(|| Upload { id, files: Files::new(), room: room() });
        if !upload.room.take(message.len() as u64) {
            return Err("the files are larger than 1 GiB");
        }
        let is_full = upload.files.len() >= MAX_FILES;
        match upload.files.last_mut().filter(|(own, _)| own == name) {
            Some((_, own)) => own.extend_from_slice(bytes),
            None if is_full => return Err("there are more than 10,000 files"),
            None => upload.files.push((name.to_owned(), bytes.to_vec())),
        }
        Ok(())
    }
}
