//! What serving costs: `cargo test --release -p turner-serve -- --ignored --nocapture speed`.

use std::time::{Duration, Instant};

use serde_json::json;
use turner::schema::Limits;
use turner_live::document::STARTS;
use turner_web::{Event, Session};

use crate::common::{Client, Heard, Running};

/// Moves of each measurement.
const MOVES: usize = 60;

/// Longest time from a move to its picture, after which the next one is made.
const PATIENCE: Duration = Duration::from_secs(2);

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Prints times in milliseconds.
fn print(what: &str, times: &[f64], total: Duration, bytes: usize) {
    let (count, seconds) = (times.len() as f64, total.as_secs_f64());
    println!(
        "{what}: {:.1} ms from a move to its picture, {:.1} pictures per second, {:.1} MB/s",
        median(times.to_vec()),
        count / seconds,
        bytes as f64 / 1e6 / seconds
    );
}

fn view(integrator: Option<&str>) -> serde_json::Value {
    json!({ "width": 1280, "height": 720, "integrator": integrator })
}

/// A scene of the gallery at 1280 x 720.
fn edits() -> serde_json::Value {
    json!({ "edits": [["film.width", 1280], ["film.height", 720]], "label": "Size" })
}

fn alone(id: &str, integrator: Option<&str>) {
    let mut session = Session::new(0, Limits::default());
    session.call("open_start", &json!({ "id": id }), Vec::new()).unwrap();
    session.call("view", &view(integrator), Vec::new()).unwrap();
    session.call("set", &edits(), Vec::new()).unwrap();
    // Until the first picture.
    while !session.events().iter().any(|event| matches!(event, Event::Frame(..))) {
        session.step();
    }
    let (mut times, begun) = (Vec::new(), Instant::now());
    for _ in 0..MOVES {
        let from = Instant::now();
        session.call("gesture", &json!({ "kind": "orbit", "x": 0.02 }), Vec::new()).unwrap();
        while from.elapsed() < PATIENCE {
            session.step();
            if session.events().iter().any(|event| matches!(event, Event::Frame(..))) {
                break;
            }
        }
        times.push(from.elapsed().as_secs_f64() * 1e3);
    }
    print(&format!("{id}, {}, engine alone", integrator.unwrap_or("rendered")), &times, begun.elapsed(), 0);
}

fn served(id: &str, integrator: Option<&str>, packed: bool) {
    let server = Running::start();
    let mut client = Client::new(&server.owner);
    client.call("open_start", json!({ "id": id })).unwrap();
    client.call("view", view(integrator)).unwrap();
    client.call("set", edits()).unwrap();
    client.draws();
    client.draws();
    if packed {
        // A slow connection, as the server sees it.
        client.delay = Some(Duration::from_millis(300));
        for _ in 0..6 {
            client.call("gesture", json!({ "kind": "orbit", "x": 0.02 })).unwrap();
            client.draws();
        }
        client.delay = None;
    }
    let (mut times, mut bytes, begun) = (Vec::new(), 0, Instant::now());
    let pictures = client.pictures;
    for _ in 0..MOVES {
        let from = Instant::now();
        client.send("gesture", json!({ "kind": "orbit", "x": 0.02 }));
        client.draws();
        bytes += client.picture.bytes;
        times.push(from.elapsed().as_secs_f64() * 1e3);
    }
    let what = if packed { "served to a slow viewer" } else { "served" };
    let (shown, kind) = (&client.picture, integrator.unwrap_or("rendered"));
    let what = format!("{id}, {kind}, {what}, {}x{}, flags {}", shown.width, shown.height, shown.flags);
    print(&what, &times, begun.elapsed(), bytes);
    assert!(client.pictures - pictures >= MOVES);
}

impl Client {
    /// Waits for a picture.
    fn draws(&mut self) {
        while !matches!(self.hear().unwrap(), Heard::Picture) {}
    }
}

#[test]
#[ignore = "a measurement"]
fn speed_of_an_orbit() {
    // Normals take little time: pictures then have the film's size.
    for (id, integrator) in
        [(STARTS[2].file, None), ("material-balls", None), (STARTS[2].file, Some("normals"))]
    {
        alone(id, integrator);
        served(id, integrator, false);
        served(id, integrator, true);
    }
}
