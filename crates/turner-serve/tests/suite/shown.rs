//! Pictures: whole and in tiles, for viewers of any speed.

use serde_json::json;
use turner_live::document::STARTS;
use turner_web::{PictureRequest, picture};

use crate::common::{Client, Running, SCENE};

/// The display values that the library renders.
fn rendered(text: &str, overrides: &[(&str, &str)]) -> Vec<u8> {
    let files = vec![("scene.toml".to_owned(), text.as_bytes().to_vec())];
    let overrides = overrides.iter().map(|&(path, value)| (path.to_owned(), value.to_owned())).collect();
    let wanted = PictureRequest { main: "scene.toml".into(), overrides, ..PictureRequest::default() };
    picture(files, &wanted).unwrap().display.as_flattened().to_vec()
}

#[test]
fn a_scene_of_the_gallery_has_the_pixels_of_the_library() {
    let server = Running::start();
    let mut client = server.connect();
    let start = &STARTS[0];
    client.call("open_start", json!({ "id": start.file })).unwrap();
    let edits = json!([["film.width", 90], ["film.height", 70]]);
    client.call("set", json!({ "edits": edits, "label": "Small" })).unwrap();
    client.wait(|m| m["event"] == "document" && m["detail"]["film"]["width"] == 90);
    client.settled(0);
    assert_eq!([client.picture.width, client.picture.height], [90, 70]);
    assert_eq!(client.picture.rgba, rendered(start.text, &[("film.width", "90"), ("film.height", "70")]));
}

#[test]
fn after_an_edit_changed_tiles_come() {
    let server = Running::start();
    let mut client = server.connect();
    client.open(SCENE);
    client.settled(0);
    assert_eq!(client.picture.rgba, rendered(SCENE, &[]));
    let last = client.picture.number;
    client.fewest_tiles = u32::MAX;
    client
        .call("set", json!({ "edits": [["material.green.color", [0.1, 0.1, 0.8]]], "label": "Blue" }))
        .unwrap();
    client.settled(last);
    let changed = SCENE.replace("[0.1, 0.8, 0.1]", "[0.1, 0.1, 0.8]");
    assert_eq!(client.picture.rgba, rendered(&changed, &[]));
    assert_eq!(client.picture.tiles[1], 12);
    assert!(client.fewest_tiles < 12, "all tiles came each time");
}

#[test]
fn a_slow_viewer_gets_the_newest_picture_and_not_all() {
    let server = Running::start();
    let (mut owner, mut slow) = (server.connect(), Client::new(&server.viewers));
    owner.open(SCENE);
    owner.settled(0);
    slow.sees = false;
    while slow.pictures == 0 {
        slow.hear().unwrap();
    }
    let begun = owner.pictures;
    let mut last = owner.picture.number;
    for _ in 0..4 {
        owner.call("gesture", json!({ "kind": "orbit", "x": 0.1 })).unwrap();
        owner.call("gesture_end", json!({})).unwrap();
        owner.settled(last);
        last = owner.picture.number;
    }
    assert!(owner.pictures - begun >= 4);
    assert_eq!(slow.pictures, 1);
    // The answer comes after all that was sent before it.
    slow.call("value", json!({ "x": 1, "y": 1 })).unwrap();
    assert_eq!(slow.pictures, 1, "it has acknowledged none");
    slow.sees = true;
    slow.acknowledge();
    slow.settled(0);
    assert!(slow.pictures <= 3, "{}", slow.pictures);
    assert_eq!(slow.picture.number, last);
    assert_eq!(slow.picture.rgba, owner.picture.rgba);
}

#[test]
fn who_comes_later_sees_what_is_open() {
    let server = Running::start();
    let mut first = server.connect();
    first.open(SCENE);
    first.settled(0);
    let mut second = server.connect();
    let document = second.wait(|m| m["event"] == "document");
    assert_eq!(document["detail"]["text"], SCENE);
    second.wait(|m| m["started"] == true);
    second.settled(0);
    assert_eq!(second.picture.rgba, first.picture.rgba);
    second.call("set", json!({ "edits": [["object.0.radius", 1.2]], "label": "Larger" })).unwrap();
    first.wait(|m| m["event"] == "document" && m["detail"]["undo"] == "Larger");
}
