//! Sessions as a page uses them, natively.

use serde_json::{Value as Json, json};
use turner::schema::Limits;
use turner_web::{CALLS, CallError, Event, Reply, Session};

fn session() -> Session {
    Session::new(2, Limits::default())
}

fn call(session: &mut Session, name: &str, args: Json) -> Result<Reply, CallError> {
    session.call(name, &args, Vec::new())
}

fn ok(session: &mut Session, name: &str, args: Json) -> Json {
    call(session, name, args).unwrap_or_else(|e| panic!("{name}: {} {:?}", e.message, e.help)).json
}

/// Steps until the picture is finished; returns the last frame.
fn settle(session: &mut Session) -> (Json, std::sync::Arc<turner::Picture>) {
    let mut last = None;
    for _ in 0..100_000 {
        session.step();
        for event in session.events() {
            match event {
                Event::Frame(data, picture) => last = Some((data, picture)),
                Event::Status(status) => assert_eq!(status["error"], Json::Null),
                Event::Document(_) => {}
            }
        }
        if last.as_ref().is_some_and(|(data, _)| data["stage"] == "settled") {
            return last.unwrap();
        }
    }
    panic!("the picture is not finished");
}

const SCENE: &str = "[film]\nwidth = 48\nheight = 36\n\n[camera]\nposition = [0, 1, 5]\nlook_at = [0, 1, 0]\n\n[[light]]\ntype = \"point\"\n\
    position = [3, 4, 5]\n\n[material.red]\ncolor = \"red\" # kept\n\n[[object]]\nname = \"ball\"\ntype = \"sphere\"\ncenter = [0, 1, 0]\nmaterial = \"red\"\n";

#[test]
fn the_reference_names_every_call() {
    let page = include_str!("../../../docs/reference/page.md");
    for (name, _) in CALLS {
        assert!(page.contains(&format!("`{name}`")), "{name}");
    }
}

#[test]
fn a_settled_frame_is_the_picture_of_the_library() {
    let mut session = session();
    ok(&mut session, "set_text", json!({ "text": SCENE }));
    let (data, picture) = settle(&mut session);
    assert_eq!((data["width"].as_u64(), data["height"].as_u64()), (Some(48), Some(36)));
    let request = turner_web::PictureRequest { main: "a.toml".into(), ..Default::default() };
    let alone = turner_web::picture(vec![("a.toml".into(), SCENE.into())], &request).unwrap();
    assert_eq!(picture.display, alone.display);
    assert_eq!(picture.linear, alone.linear);
}

#[test]
fn an_edit_changes_picture_and_text_and_can_be_undone() {
    let mut session = session();
    ok(&mut session, "set_text", json!({ "text": SCENE }));
    let (_, before) = settle(&mut session);
    let edits = json!([["material.red.color", "blue"], ["object.0.radius", 1.5]]);
    ok(&mut session, "set", json!({ "edits": edits, "label": "Blue" }));
    let (_, after) = settle(&mut session);
    assert_ne!(before.display, after.display);
    let text = ok(&mut session, "text", json!({}))["text"].as_str().unwrap().to_owned();
    assert!(text.contains("# kept") && text.contains("radius = 1.5"), "{text}");
    let part = ok(&mut session, "part", json!({ "path": "object.0" }));
    let radius = part["keys"].as_array().unwrap().iter().find(|key| key["name"] == "radius").unwrap();
    assert_eq!((&radius["value"], &radius["set"]), (&json!(1.5), &json!(true)));
    ok(&mut session, "set", json!({ "edits": [["object.0.radius", null]] }));
    assert_eq!(ok(&mut session, "undo", json!({}))["label"], "Edit");
    assert_eq!(ok(&mut session, "undo", json!({}))["label"], "Blue");
    let (_, again) = settle(&mut session);
    assert_eq!(before.display, again.display);
    assert_eq!(ok(&mut session, "text", json!({}))["text"], SCENE);
}

#[test]
fn every_part_of_every_scene_of_the_gallery_has_keys() {
    let mut session = session();
    let gallery = ok(&mut session, "gallery", json!({}));
    let starts =
        gallery["groups"].as_array().unwrap().iter().flat_map(|group| group["entries"].as_array().unwrap());
    let steps = ok(&mut session, "tutorial", json!({}));
    let ids: Vec<String> = starts
        .chain(steps["steps"].as_array().unwrap())
        .map(|entry| entry["id"].as_str().unwrap().to_owned())
        .collect();
    assert!(ids.len() >= 5 + 13 + 8 + 8);
    for id in ids {
        ok(&mut session, "open_start", json!({ "id": id }));
        let outline = ok(&mut session, "outline", json!({}));
        for list in outline["lists"].as_array().unwrap() {
            for entry in list["entries"].as_array().unwrap().iter().take(20) {
                let part = ok(&mut session, "part", json!({ "path": entry["path"] }));
                // Debug views have no keys.
                let has = !part["keys"].as_array().unwrap().is_empty();
                assert!(has || entry["family"] == "integrator", "{id}: {entry}");
            }
        }
    }
}

#[test]
fn the_camera_moves_in_one_step_of_the_history() {
    let mut session = session();
    ok(&mut session, "set_text", json!({ "text": SCENE }));
    let (_, before) = settle(&mut session);
    for _ in 0..5 {
        ok(&mut session, "gesture", json!({ "kind": "orbit", "x": 0.1, "y": 0.05 }));
        session.step();
        let moves = session.events().into_iter().filter(|event| matches!(event, Event::Document(_))).count();
        assert_eq!(moves, 0, "while the camera moves, the document is not told");
    }
    ok(&mut session, "gesture_end", json!({}));
    assert!(session.events().iter().any(|event| matches!(event, Event::Document(_))));
    let (_, after) = settle(&mut session);
    assert_ne!(before.display, after.display);
    assert_eq!(ok(&mut session, "undo", json!({}))["label"], "Orbit");
    let (_, again) = settle(&mut session);
    assert_eq!(before.display, again.display);
    for kind in ["look", "pan", "fly"] {
        ok(&mut session, "gesture", json!({ "kind": kind, "x": 0.01, "y": 0.01, "z": 0.01 }));
    }
    ok(&mut session, "gesture", json!({ "kind": "dolly", "x": 0.9 }));
    ok(&mut session, "frame", json!({ "object": 0 }));
    settle(&mut session);
    ok(&mut session, "focus", json!({ "x": 24, "y": 18 }));
    assert!(call(&mut session, "gesture", json!({ "kind": "spin" })).unwrap_err().message.contains("orbit"));
}

#[test]
fn a_pixel_is_picked_explained_and_saved() {
    let mut session = session();
    ok(&mut session, "set_text", json!({ "text": SCENE }));
    let early = call(&mut session, "save", json!({ "format": "png" })).unwrap_err();
    assert!(early.message.contains("picture"), "{}", early.message);
    settle(&mut session);
    let picked = ok(&mut session, "pick", json!({ "x": 24.5, "y": 18.5 }));
    assert_eq!(
        (&picked["object"]["path"], &picked["material"]["path"]),
        (&json!("object.0"), &json!("material.red"))
    );
    assert_eq!(ok(&mut session, "pick", json!({ "x": 0.5, "y": 0.5 })), json!({}));
    for (format, mark) in
        [("page", "<section"), ("html", "<!DOCTYPE"), ("text", "ball"), ("json", "{"), ("svg", "<svg")]
    {
        let explained = ok(&mut session, "explain", json!({ "x": 24, "y": 18, "format": format }));
        assert!(explained["text"].as_str().unwrap().contains(mark), "{format}");
        assert_eq!(explained["exact"], true);
    }
    assert!(
        !ok(&mut session, "explain", json!({ "x": 24, "y": 18 }))["text"]
            .as_str()
            .unwrap()
            .contains("<script")
    );
    let value = ok(&mut session, "value", json!({ "x": 24.5, "y": 18.5 }));
    assert_eq!(value["display"].as_array().unwrap().len(), 4);
    for (format, magic) in
        [("png", &b"\x89PNG"[..]), ("exr", b"\x76\x2f\x31\x01"), ("toml", b"[film]"), ("jpg", b"\xff\xd8")]
    {
        let saved = call(&mut session, "save", json!({ "format": format })).unwrap();
        assert!(saved.bytes.starts_with(magic), "{format}");
        assert_eq!(saved.json["name"], format!("scene.{format}"));
    }
    let findings = ok(&mut session, "doctor", json!({}));
    assert!(findings["findings"].is_array());
}

#[test]
fn views_show_other_integrators_and_displays() {
    let mut session = session();
    ok(&mut session, "set_text", json!({ "text": SCENE }));
    let (_, plain) = settle(&mut session);
    ok(&mut session, "view", json!({ "integrator": "normals", "width": 48, "height": 36 }));
    let (_, normals) = settle(&mut session);
    assert_ne!(plain.display, normals.display);
    ok(&mut session, "view", json!({ "integrator": "depth" }));
    assert!(settle(&mut session).0["scale"]["unit"].is_string());
    ok(&mut session, "view", json!({ "integrator": null, "display": "false-color" }));
    settle(&mut session);
    assert!(
        call(&mut session, "view", json!({ "integrator": "normal" }))
            .unwrap_err()
            .help
            .unwrap()
            .contains("normals")
    );
}

#[test]
fn files_open_from_folders_and_bad_ones_have_a_message() {
    let mut session = session();
    let obj = b"v -1 0 -1\nv 1 0 -1\nv 1 0 1\nf 1 2 3\n".to_vec();
    let scene = format!("{SCENE}\n[[object]]\ntype = \"model\"\nfile = \"parts/roof.obj\"\n").into_bytes();
    let files = vec![
        ("a/scene.toml".to_owned(), scene),
        ("a/parts/roof.obj".to_owned(), obj.clone()),
        ("x.txt".to_owned(), vec![0]),
    ];
    session.call("open", &json!({}), files).unwrap();
    settle(&mut session);
    session.call("open", &json!({}), vec![("roof.obj".to_owned(), obj)]).unwrap();
    let event = session.events().into_iter().find_map(|event| match event {
        Event::Document(data) => Some(data),
        _ => None,
    });
    assert!(event.unwrap()["text"].as_str().unwrap().contains("roof.obj"));
    let bad = session.call("open", &json!({}), vec![("a.glb".to_owned(), b"glTF????".to_vec())]).unwrap_err();
    assert!(bad.message.contains("a.glb"), "{}", bad.message);
    // Outside the scene's folder.
    let out = "[[object]]\ntype = \"model\"\nfile = \"../secret.obj\"\n".as_bytes().to_vec();
    assert!(session.call("open", &json!({}), vec![("s/a.toml".to_owned(), out)]).is_err());
}

#[test]
fn wrong_calls_have_messages() {
    let mut session = session();
    assert!(call(&mut session, "opne", json!({})).unwrap_err().help.unwrap().contains("open"));
    for (name, args) in [
        ("open_start", json!({ "id": 3 })),
        ("open_start", json!({ "id": "cornel-box" })),
        ("gesture", json!({ "kind": "orbit", "x": "a" })),
        ("part", json!({ "path": "object.9" })),
        ("set", json!({ "edits": [["object.0.radius"]] })),
        ("set", json!({ "edits": [["nothing.at.all", 1]] })),
        ("explain", json!({ "x": 1, "y": 1 })),
        ("save", json!({ "format": "doc" })),
        ("pick", json!({})),
        ("set_text", json!({ "text": "a = [" })),
        ("complete", json!({ "text": "[", "offset": -1 })),
    ] {
        let error = call(&mut session, name, args.clone()).map(|reply| reply.json);
        assert!(error.as_ref().is_err_and(|e| !e.message.is_empty()), "{name} {args}: {error:?}");
    }
    assert_eq!(ok(&mut session, "undo", json!({}))["label"], Json::Null);
}
