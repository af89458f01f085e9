//! The reference of the scene format as text and as Markdown, from the tables that parse scenes.
//!
//! Chapters follow the sections of a scene; each has an introduction and one page per type. `turner help NAME`
//! prints single pages, docs/reference/scene-format.md contains all of them.

use turner::animation::AnimationDesc;
use turner::camera::CameraDesc;
use turner::description::{ModelDesc, StudioDesc};
use turner::film::FilmDesc;
use turner::integrator::IntegratorDesc;
use turner::light::{BackgroundDesc, LightDesc};
use turner::material::MaterialDesc;
use turner::medium::MediumDesc;
use turner::schema::{EntryDoc, FamilyDoc, Field};
use turner::shape::ShapeDesc;
use turner::texture::TextureDesc;

use crate::text::{columns, wrap};
use crate::topics;

/// One key of a page.
#[derive(Clone, Debug)]
pub struct Key {
    /// The key.
    pub name: String,
    /// The type of its value, as text.
    pub kind: String,
    /// As written in a scene; `None` if the key is required.
    pub default: Option<String>,
    /// The range of its numbers.
    pub range: Option<String>,
    /// What it means.
    pub doc: String,
    /// Its valid words, with their meanings.
    pub words: &'static [(&'static str, &'static str)],
}

/// The documentation of a section, a type or a topic.
#[derive(Clone, Debug)]
pub struct Page {
    /// Its name.
    pub name: &'static str,
    /// `the shape "sphere"`, `the section [film]`.
    pub title: String,
    /// Its text.
    pub paragraphs: Vec<String>,
    /// Its keys.
    pub keys: Vec<Key>,
    /// A scene that uses it.
    pub example: Option<String>,
}

/// A section of a scene with its types.
#[derive(Clone, Debug)]
pub struct Chapter {
    /// Its heading.
    pub heading: &'static str,
    /// Other names, such as `shapes`.
    pub aliases: &'static [&'static str],
    /// What its types have in common.
    pub intro: Page,
    /// A page for each type.
    pub pages: Vec<Page>,
}

/// All chapters, in the order of the document.
pub fn chapters() -> Vec<Chapter> {
    vec![
        single("Film", &[], &FilmDesc::DOC),
        family("Camera", &["cameras", "view"], &CameraDesc::DOC, topics::CAMERA),
        family("Integrator", &["integrators"], &IntegratorDesc::DOC, topics::INTEGRATOR),
        single("Background", &[], &BackgroundDesc::DOC),
        written("Objects", &["objects"], topics::object()),
        family("Shapes", &["shapes"], &ShapeDesc::DOC, topics::SHAPE),
        written("Groups", &["groups", "instance"], topics::group()),
        model(),
        single("Studio", &["stage"], &StudioDesc::DOC),
        written("Transforms", &["transforms", "scale", "rotate", "translate", "matrix"], topics::transform()),
        written("Colours", &["colors", "colour", "colours"], topics::color()),
        family("Materials", &["materials"], &MaterialDesc::DOC, topics::MATERIAL),
        family("Textures", &["textures"], &TextureDesc::DOC, topics::TEXTURE),
        family("Media", &["media", "fog", "smoke", "volume"], &MediumDesc::DOC, topics::MEDIUM),
        family("Lights", &["lights"], &LightDesc::DOC, topics::LIGHT),
        keyframes(),
        written("Include", &[], topics::include()),
    ]
}

fn single(heading: &'static str, aliases: &'static [&'static str], doc: &'static EntryDoc) -> Chapter {
    let title = format!("the section [{}]", doc.name);
    Chapter { heading, aliases, intro: entry(doc, title), pages: Vec::new() }
}

fn keyframes() -> Chapter {
    let intro = entry(&AnimationDesc::DOC, "the section [[animation]]".to_owned());
    Chapter {
        heading: "Animation",
        aliases: &["animations", "keyframes", "keyframe"],
        intro,
        pages: Vec::new(),
    }
}

fn model() -> Chapter {
    let intro = entry(&ModelDesc::DOC, "the object \"model\"".to_owned());
    Chapter { heading: "Models", aliases: &["models", "glb", "gltf"], intro, pages: Vec::new() }
}

fn written(heading: &'static str, aliases: &'static [&'static str], intro: Page) -> Chapter {
    Chapter { heading, aliases, intro, pages: Vec::new() }
}

fn family(
    heading: &'static str,
    aliases: &'static [&'static str],
    doc: &'static FamilyDoc,
    more: &str,
) -> Chapter {
    let mut paragraphs = vec![paragraph(doc.doc)];
    paragraphs.extend((!more.is_empty()).then(|| more.to_owned()));
    let intro =
        Page { name: doc.one, title: doc.many.to_owned(), paragraphs, keys: Vec::new(), example: None };
    let pages = doc.entries.iter().map(|e| entry(e, format!("the {} \"{}\"", doc.one, e.name))).collect();
    Chapter { heading, aliases, intro, pages }
}

fn entry(doc: &'static EntryDoc, title: String) -> Page {
    Page {
        name: doc.name,
        title,
        paragraphs: vec![paragraph(doc.doc)],
        keys: doc.fields.iter().map(key).collect(),
        example: Some(doc.example.trim_end().to_owned()).filter(|e| !e.is_empty()),
    }
}

fn key(field: &Field) -> Key {
    Key {
        name: field.name.to_owned(),
        default: field.default.map(|show| show()),
        range: field.range.map(|r| r.to_string()),
        doc: paragraph(field.doc),
        words: (field.words)(),
        kind: (field.kind)(),
    }
}

/// Lines of a doc comment as one paragraph.
pub fn paragraph(lines: &[&str]) -> String {
    lines.iter().map(|l| l.trim()).collect::<Vec<_>>().join(" ").trim().to_owned()
}

/// The text up to the first full stop.
pub(crate) fn first_sentence(text: &str) -> String {
    text.split_once(". ").map_or(text, |(first, _)| first).trim_end_matches('.').to_owned()
}

/// The examples of all pages, with the titles. Tests load and render them.
pub fn examples() -> Vec<(String, String)> {
    chapters()
        .into_iter()
        .flat_map(|c| std::iter::once(c.intro).chain(c.pages))
        .filter_map(|page| Some((page.title, page.example?)))
        .collect()
}

/// Every name that [`explain`] knows.
pub(crate) fn names() -> Vec<&'static str> {
    let mut names: Vec<&'static str> = chapters()
        .iter()
        .flat_map(|c| {
            let own = std::iter::once(c.intro.name).chain(c.aliases.iter().copied());
            own.chain(c.pages.iter().map(|p| p.name)).collect::<Vec<_>>()
        })
        .collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// All pages with this name, as text; `None` if there is none.
pub(crate) fn explain(name: &str) -> Option<String> {
    let mut parts = Vec::new();
    for chapter in chapters() {
        if chapter.intro.name == name || chapter.aliases.contains(&name) {
            let mut out = page_text(&chapter.intro);
            if !chapter.pages.is_empty() {
                out += "\n";
                out += &columns(chapter.pages.iter().map(|p| (p.name, first_sentence(&p.paragraphs[0]))));
                out += "\n`turner help NAME` explains one of them.\n";
            }
            parts.push(out);
        }
        parts.extend(chapter.pages.iter().filter(|p| p.name == name).map(page_text));
    }
    (!parts.is_empty()).then(|| parts.join("\n\n"))
}

/// The sections and the families, as text.
pub(crate) fn overview() -> String {
    let mut out = String::from("A scene is a TOML file. Every section is optional.\n\n");
    out += &columns(topics::sections().iter().map(|(name, what)| (name.as_str(), (*what).to_owned())));
    out += "\nKinds, by their `type`:\n\n";
    let chapters = chapters();
    let kinds = chapters
        .iter()
        .filter(|c| !c.pages.is_empty())
        .map(|c| (c.intro.title.as_str(), c.pages.iter().map(|p| p.name).collect::<Vec<_>>().join(", ")));
    out += &columns(kinds);
    out += "\nA complete scene:\n\n";
    for line in topics::SCENE.lines() {
        out += format!("    {line}").trim_end();
        out.push('\n');
    }
    out += "\n`turner help NAME` explains a section, a kind, a key or a value;\n\
            `turner list colors` lists the colour names.\n";
    out
}

fn page_text(page: &Page) -> String {
    let mut out = format!("{}\n\n", capitalised(&page.title));
    for paragraph in &page.paragraphs {
        wrap(&mut out, &paragraph.replace('`', ""), 2);
        out.push('\n');
    }
    for key in &page.keys {
        out += &format!("  {}  {}", key.name, key.kind);
        if let Some(range) = &key.range {
            out += &format!(", {range}");
        }
        match key.default.as_deref() {
            None => out += "; required",
            Some("none") => out += "; optional",
            Some(default) => out += &format!("; default {default}"),
        }
        out.push('\n');
        wrap(&mut out, &key.doc.replace('`', ""), 6);
        for (word, meaning) in key.words {
            wrap(&mut out, &format!("\"{word}\": {meaning}"), 10);
        }
    }
    if let Some(example) = &page.example {
        out += if page.keys.is_empty() { "  Example:\n\n" } else { "\n  Example:\n\n" };
        for line in example.lines() {
            out += format!("    {line}").trim_end();
            out.push('\n');
        }
    }
    out
}

fn capitalised(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or(String::new(), |c| c.to_uppercase().chain(chars).collect())
}

/// The complete reference as Markdown.
pub fn markdown() -> String {
    let mut out =
        String::from("## Sections\n\nEvery section is optional.\n\n| section | contents |\n| --- | --- |\n");
    for (name, what) in topics::sections() {
        out += &format!("| `{name}` | {} |\n", cell(what));
    }
    for chapter in chapters() {
        out += &format!("\n## {}\n\n", chapter.heading);
        page_markdown(&mut out, &chapter.intro);
        for page in &chapter.pages {
            out += &format!("\n### {}: `{}`\n\n", chapter.heading, page.name);
            page_markdown(&mut out, page);
        }
    }
    out
}

fn page_markdown(out: &mut String, page: &Page) {
    *out += &page.paragraphs.join("\n\n");
    out.push('\n');
    if !page.keys.is_empty() {
        *out += "\n| key | type | default | meaning |\n| --- | --- | --- | --- |\n";
    }
    for key in &page.keys {
        let range = key.range.as_ref().map_or(String::new(), |r| format!(", {}", cell(r)));
        let default = match key.default.as_deref() {
            None => "*required*".to_owned(),
            Some("none") => "–".to_owned(),
            Some(default) => format!("`{}`", cell(default)),
        };
        let words: String = key.words.iter().map(|(w, m)| format!("<br>`\"{w}\"`: {}", cell(m))).collect();
        *out += &format!(
            "| `{}` | {}{range} | {default} | {}{words} |\n",
            key.name,
            cell(&key.kind),
            cell(&key.doc)
        );
    }
    if let Some(example) = &page.example {
        *out += &format!("\n```toml\n{example}\n```\n");
    }
}

/// Escapes text for a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ").replace('<', "&lt;")
}
