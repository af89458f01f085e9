//! The gallery and the tutorial.

use serde_json::{Value as Json, json};
use turner_live::document::{Document, STARTS, Start};

use super::calls::{Args, Files};
use super::{CallError, Reply, Session};

/// The guide that the steps of the tutorial are described in.
const GUIDE: &str = include_str!("../../../../docs/guides/whitted-in-eight-steps.md");

/// A row of the table of steps: each is a scene of `scenes/tutorial`.
macro_rules! steps {
    ($($number:literal)*) => {
        const STEPS: &[Start] = &[$(Start {
            group: "Whitted's ray tracer in eight steps",
            name: concat!("Step ", $number),
            about: "",
            file: concat!("step-", $number),
            text: include_str!(concat!("../../../../scenes/tutorial/step-", $number, ".toml")),
            folder: "tutorial",
            files: &[("things.toml", include_bytes!("../../../../scenes/tutorial/things.toml"))],
        },)*];
    };
}

steps!("1" "2" "3" "4" "5" "6" "7" "8");

pub(super) fn gallery() -> Result<Reply, CallError> {
    let mut groups: Vec<(&str, Vec<Json>)> = Vec::new();
    for start in STARTS {
        // Files that the core does not hold itself: the page reads them.
        let missing = start.files.iter().filter(|(_, bytes)| bytes.is_empty());
        let files: Vec<Json> = missing
            .map(|(name, _)| json!({ "name": name, "path": format!("{}/{name}", start.folder) }))
            .collect();
        let entry = json!({ "id": start.file, "name": start.name, "about": start.about, "files": files });
        match groups.last_mut().filter(|(name, _)| *name == start.group) {
            Some((_, entries)) => entries.push(entry),
            None => groups.push((start.group, vec![entry])),
        }
    }
    let groups: Vec<Json> =
        groups.into_iter().map(|(name, entries)| json!({ "name": name, "entries": entries })).collect();
    Ok(json!({ "groups": groups }).into())
}

pub(super) fn tutorial() -> Result<Reply, CallError> {
    let sections = sections();
    let steps: Vec<Json> = STEPS
        .iter()
        .zip(&sections)
        .map(|(step, (title, text))| json!({ "id": step.file, "title": title, "text": text }))
        .collect();
    Ok(json!({ "steps": steps }).into())
}

/// The title and the paragraphs of each step of the guide, as plain text: without commands and pictures.
fn sections() -> Vec<(String, Vec<String>)> {
    let mut out: Vec<(String, Vec<String>)> = Vec::new();
    for block in GUIDE.split("\n## ").skip(1) {
        let (title, rest) = block.split_once('\n').unwrap_or((block, ""));
        if !title.starts_with(|c: char| c.is_ascii_digit()) {
            continue;
        }
        let mut parts = rest.split("```");
        let mut paragraphs = Vec::new();
        // Every second part is code.
        while let Some(text) = parts.next() {
            let own = text.split("\n\n").map(str::trim);
            paragraphs.extend(own.filter(|p| !p.is_empty() && !p.starts_with("![")).map(plain));
            parts.next();
        }
        out.push((title.to_owned(), paragraphs));
    }
    out
}

/// Markdown without its marks: emphasis, code and links.
fn plain(markdown: &str) -> String {
    let mut out = String::new();
    let mut rest = markdown.replace('\n', " ");
    while let Some(start) = rest.find('[') {
        let link = rest[start..].find("](").and_then(|middle| {
            let end = rest[start + middle..].find(')')?;
            Some((rest[start + 1..start + middle].to_owned(), start + middle + end + 1))
        });
        let Some((text, end)) = link else { break };
        out += &rest[..start];
        out += &text;
        rest = rest[end..].to_owned();
    }
    out += &rest;
    out.replace(['*', '`'], "")
}

pub(super) fn open(session: &mut Session, args: &Json, files: Files) -> Result<Reply, CallError> {
    let id = Args(args).text("id")?;
    let all = || STARTS.iter().chain(STEPS);
    let Some(start) = all().find(|start| start.file == id) else {
        let ids: Vec<&str> = all().map(|start| start.file).collect();
        let help = turner::schema::error::suggestion(id, &ids);
        return Err(CallError {
            help,
            ..CallError::new(format!("there is no scene \"{id}\" in the gallery"))
        });
    };
    let document = Document::start_in_memory(start, files, &session.load_options())?;
    session.show(document);
    Ok(Json::Object(Default::default()).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_guide_has_eight_steps_with_text() {
        let sections = sections();
        assert_eq!(sections.len(), STEPS.len());
        for (title, text) in &sections {
            assert!(!text.is_empty(), "{title}");
            let marks =
                |line: &String| line.contains("](") || line.contains('`') || line.contains("turner scenes");
            assert!(!text.iter().any(marks), "{title}: {text:?}");
        }
        assert_eq!(sections[0].0, "1. One ray for each pixel");
    }

    #[test]
    fn links_and_emphasis_become_text() {
        assert_eq!(plain("a *b* [c d](e.md), `f` [g]"), "a b c d, f [g]");
    }
}
