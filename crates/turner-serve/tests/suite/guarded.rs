//! What is refused, and what hostile messages do.

use std::net::TcpStream;
use std::time::Duration;

use serde_json::json;
use tungstenite::Error;
use tungstenite::client::IntoClientRequest;

use crate::common::{Client, Running, SCENE};

#[test]
fn the_page_is_served_with_its_headers() {
    let server = Running::start();
    let page = server.get(&server.path());
    assert!(page.starts_with("HTTP/1.1 200 "), "{page}");
    for header in [
        "cross-origin-opener-policy: same-origin",
        "cross-origin-embedder-policy: require-corp",
        "x-content-type-options: nosniff",
        "referrer-policy: no-referrer",
        "content-security-policy: default-src 'none'",
        "content-type: text/html",
    ] {
        assert!(page.contains(header), "{header}: {page}");
    }
    assert!(page.contains("<meta name=\"turner-serve\" content=\"owner\">"));
    let viewers = format!("/{}/", server.viewers.split('/').nth(3).unwrap());
    assert!(server.get(&viewers).contains("<meta name=\"turner-serve\" content=\"viewer\">"));
    assert!(server.get(server.path().trim_end_matches('/')).starts_with("HTTP/1.1 308 "));
    let script = server.get(&format!("{}remote.js", server.path()));
    assert!(script.contains("content-type: text/javascript") && script.contains("RemoteEngine"));
    let named = server.ask(&format!("GET {} HTTP/1.1\nHost: lab.example:80", server.path()));
    assert!(named.starts_with("HTTP/1.1 200 "), "{named}");
}

#[test]
fn nothing_but_the_page_is_served() {
    let server = Running::start();
    let path = server.path();
    for file in
        ["Cargo.toml", "../Cargo.toml", "..%2fCargo.toml", "%2e%2e/Cargo.toml", "a/b", "%00", "//etc/passwd"]
    {
        let answer = server.get(&format!("{path}{file}"));
        assert!(answer.starts_with("HTTP/1.1 40"), "{file}: {answer}");
        assert!(!answer.contains("[package]"));
    }
    assert!(
        server
            .ask(&format!("POST {path} HTTP/1.1\nHost: {}\nContent-Length: 0", server.host()))
            .starts_with("HTTP/1.1 405 ")
    );
}

#[test]
fn tokens_hosts_and_origins_are_checked() {
    let server = Running::start();
    let (path, host) = (server.path(), server.host());
    let refused = |answer: &str, word: &str| {
        assert!(answer.starts_with("HTTP/1.1 403 ") && answer.contains(word), "{answer}");
    };
    refused(&server.get("/"), "token");
    refused(&server.get("/page.js"), "token");
    refused(&server.get(&format!("/{}/", "a".repeat(26))), "token");
    refused(&server.get(&format!("{}x/", path.trim_end_matches('/'))), "token");
    refused(&server.ask(&format!("GET {path} HTTP/1.1\nHost: evil.example")), "evil.example");
    refused(&server.ask(&format!("GET {path} HTTP/1.1\nHost: evil.example:80")), "--host");
    // Without the header no host is asked for.
    assert!(server.ask(&format!("GET {path} HTTP/1.1")).starts_with("HTTP/1.1 40"));
    let upgrade =
        "Upgrade: websocket\nSec-WebSocket-Version: 13\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==";
    let socket = |host: &str, more: &str| {
        server.ask(&format!("GET {path}socket HTTP/1.1\nHost: {host}\n{upgrade}{more}"))
    };
    refused(&socket(host, ""), "origin");
    refused(&socket(host, "\nOrigin: http://evil.example"), "evil.example");
    refused(&socket(host, "\nOrigin: null"), "null");
    refused(&socket("evil.example", "\nOrigin: http://evil.example"), "evil.example");
    let request = format!("ws://{host}/{}/socket", "b".repeat(26)).into_client_request().unwrap();
    let error = tungstenite::client(request, TcpStream::connect(host).unwrap()).unwrap_err();
    assert!(error.to_string().contains("403"), "{error}");
}

/// What a connection is ended with.
fn end(client: &mut Client) -> String {
    loop {
        match client.hear() {
            Ok(_) => {}
            Err(Error::Io(error)) => return error.to_string(),
            Err(error) => return error.to_string(),
        }
    }
}

#[test]
fn messages_that_are_wrong_end_their_connection_alone() {
    let server = Running::start();
    let mut good = server.connect();
    for text in
        ["", "nonsense", "[]", "{}", "{\"id\":-1}", "{\"id\":1}", "{\"seen\":\"x\"}", &"[".repeat(100_000)]
    {
        let mut client = server.connect();
        client.text(text);
        assert!(end(&mut client).starts_with("1008"), "{text:.20}");
    }
    for bytes in [
        &[][..],
        &[3],
        &[9; 12],
        &[3, 0, 0, 0, 1, 0, 0, 0, 255, 255, 255, 255],
        &[3, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 255],
    ] {
        let mut client = server.connect();
        client.binary(bytes);
        assert!(end(&mut client).starts_with("1008"), "{bytes:?}");
    }
    let mut client = server.connect();
    // The server reads no further than the head of the message.
    let _ = client.socket.send(tungstenite::Message::Text("x".repeat(3 << 20).into()));
    let reason = end(&mut client);
    assert!(reason.starts_with("1008") || reason.contains("reset") || reason.contains("pipe"), "{reason}");
    for (name, args) in [
        ("nothing", json!({})),
        ("open", json!({ "main": 7 })),
        ("set_text", json!({ "text": "[[object]]\ntype = \"spher\"" })),
        ("gesture", json!({ "kind": "orbit", "x": "left" })),
        ("set", json!({ "edits": [[null, { "a": [[[]]] }]] })),
        ("pick", json!([1, 2])),
        ("explain", json!(null)),
    ] {
        let error = good.call(name, args).unwrap_err();
        assert!(error["message"].is_string(), "{name}: {error}");
    }
    good.open(SCENE);
    good.settled(0);
}

#[test]
fn a_viewer_looks_on_and_changes_nothing() {
    let server = Running::start();
    let (mut owner, mut viewer) = (server.connect(), Client::new(&server.viewers));
    assert_eq!(viewer.wait(|m| m["started"] == true)["role"], "viewer");
    assert_eq!(owner.wait(|m| m["started"] == true)["role"], "owner");
    owner.open(SCENE);
    owner.settled(0);
    viewer.settled(0);
    assert_eq!(viewer.picture.rgba, owner.picture.rgba);
    for name in [
        "open",
        "open_start",
        "set_text",
        "set",
        "undo",
        "redo",
        "gesture",
        "gesture_end",
        "view",
        "frame",
        "focus",
        "picture",
        "doctor",
        "check",
    ] {
        let error = viewer.call(name, json!({})).unwrap_err();
        assert!(error["message"].as_str().unwrap().contains("only shows"), "{name}: {error}");
    }
    let picked = viewer.call("pick", json!({ "x": 100, "y": 68 })).unwrap().0;
    assert_eq!(picked["material"]["path"], "material.red");
    let (saved, bytes) = viewer.call("save", json!({ "format": "png" })).unwrap();
    assert_eq!((saved["name"].as_str(), &bytes[1..4]), (Some("scene.png"), &b"PNG"[..]));
    viewer.part("a.toml", b"x");
    assert!(end(&mut viewer).starts_with("1008"));
    assert_eq!(owner.call("undo", json!({})).unwrap().0["label"], json!(null));
}

#[test]
fn the_server_ends_when_it_is_told() {
    let mut server = Running::start();
    let mut client = server.connect();
    client.open(SCENE);
    assert!(server.stop() < Duration::from_millis(500));
    end(&mut client);
    assert!(TcpStream::connect(server.host()).is_err());
}
