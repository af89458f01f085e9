use serde_json::json;
use turner::schema::Limits;

use super::*;
use context::{Context, Side};

/// The text before and after the mark `|`.
fn marked(text: &str) -> (String, usize) {
    let at = text.find('|').unwrap();
    (text.replacen('|', "", 1), at)
}

fn context(text: &str) -> Context {
    let (text, at) = marked(text);
    Context::at(&text, at)
}

fn labels(text: &str) -> Vec<String> {
    let (text, at) = marked(text);
    let session = Session::new(1, Limits::default());
    let offset = units_of(&text, at);
    let reply = complete(&session, &json!({ "text": text, "offset": offset })).unwrap();
    reply.json["items"]
        .as_array()
        .unwrap()
        .iter()
        .map(|item| item["label"].as_str().unwrap().to_owned())
        .collect()
}

#[test]
fn the_table_of_the_cursor_is_found() {
    let at = context("[[object]]\ntype = \"sphere\"\nra|");
    assert_eq!(
        (at.path, at.kind.as_deref(), at.side),
        (vec!["object".to_owned()], Some("sphere"), Side::Key)
    );
    let at = context("[[object]]\nmaterial = { type = \"met|al\", roughness = 1 }");
    assert_eq!(at.path, ["object", "material"]);
    assert_eq!(at.side, Side::Value("type".into()));
    assert_eq!(at.written, ["type", "roughness"]);
    let at = context("light = [{ type = \"point\", inten| }, { type = \"ambient\" }]");
    assert_eq!((at.path, at.kind.as_deref(), at.side), (vec!["light".to_owned()], Some("point"), Side::Key));
    let at = context("[film]\nwidth = 10 # [[object]]\n\n[[object]]\ntype = \"plane\"\n\n[mat|");
    assert_eq!(at.side, Side::Section);
    let at = context("[material.gold]\ncolor = [1, |");
    assert_eq!(
        (at.path, at.side),
        (vec!["material".to_owned(), "gold".to_owned()], Side::Value("color".into()))
    );
    let at = context("a = \"[[object]]\"\nb|");
    assert!(at.path.is_empty());
}

#[test]
fn keys_types_words_and_names_are_completed() {
    assert_eq!(labels("[[object]]\ntype = \"sphere\"\nradi|")[0], "radius");
    assert!(!labels("[[object]]\ntype = \"sphere\"\nradius = 2\n|").contains(&"radius".to_owned()));
    assert_eq!(labels("[[object]]\ntype = \"sph|\"")[0], "sphere");
    assert!(labels("[[object]]\ntype = |").contains(&"model".to_owned()));
    assert!(labels("[film]\nantialias = |").contains(&"monte-carlo".to_owned()));
    assert!(labels("[[object]]\nmaterial = { type = \"|\" }").contains(&"principled".to_owned()));
    assert!(labels("[[object]]\nmaterial = { color = { type = \"check|\" } }")[0].starts_with("checker"));
    assert_eq!(labels("[fi|")[0], "film");
    assert!(labels("|").contains(&"[[object]]".to_owned()));
}

#[test]
fn any_prefix_of_a_scene_has_a_context() {
    for text in [
        include_str!("../../../../../scenes/hello.toml"),
        include_str!("../../../../../scenes/showcase/product.toml"),
    ] {
        for at in (0..=text.len()).filter(|at| text.is_char_boundary(*at)) {
            let whole = Context::at(text, at);
            let part = Context::at(&text[..at], at);
            assert!(whole.word.start <= at && part.word.end <= at);
        }
    }
}

#[test]
fn positions_count_in_utf_16() {
    let text = "# 😀\n[fi";
    assert_eq!(byte_of(text, 8), text.len());
    assert_eq!(units_of(text, text.len()), 8);
}

#[test]
fn errors_have_places() {
    let session = Session::new(1, Limits::default());
    let reply = check(&session, &json!({ "text": "[[object]]\ntype = \"spher\"\n" })).unwrap();
    let error = &reply.json["errors"][0];
    assert_eq!((error["line"].as_u64(), error["column"].as_u64()), (Some(2), Some(8)), "{error}");
    assert!(error["help"].as_str().unwrap().contains("sphere"), "{error}");
    let reply = check(&session, &json!({ "text": "[[object]]\ntype = \"sphere\"\n" })).unwrap();
    assert_eq!(reply.json["errors"], json!([]));
}
