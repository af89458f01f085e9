//! `turner list`: names of types, formats, colours and errors.

use clap::Args;
use clap::builder::PossibleValuesParser;
use serde_json::json;
use turner::camera::CameraDesc;
use turner::color::{NAMES, Tonemap, Transfer};
use turner::description::SECTIONS;
use turner::film::{Antialias, Aov};
use turner::filter::FilterKind;
use turner::integrator::IntegratorDesc;
use turner::light::LightDesc;
use turner::material::MaterialDesc;
use turner::medium::MediumDesc;
use turner::schema::{ErrorCode, FamilyDoc};
use turner::shape::ShapeDesc;
use turner::texture::TextureDesc;
use turner_io::image::ImageFormat;
use turner_io::scene::SceneFormat;

use crate::reference::{first_sentence, paragraph};
use crate::text;

/// List the names of shapes, materials, formats, errors and so on
#[derive(Debug, Args)]
pub(crate) struct ListArgs {
    /// Which names to list [default: the topics]
    #[arg(value_parser = PossibleValuesParser::new(TOPICS.iter().map(|t| t.name)), hide_possible_values = true)]
    topic: Option<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

struct Topic {
    name: &'static str,
    what: &'static str,
    rows: fn() -> Vec<(String, String)>,
}

const TOPICS: &[Topic] = &[
    Topic { name: "shapes", what: "types of objects", rows: || family(&ShapeDesc::DOC) },
    Topic { name: "materials", what: "how surfaces scatter light", rows: || family(&MaterialDesc::DOC) },
    Topic { name: "textures", what: "colours that vary over a surface", rows: || family(&TextureDesc::DOC) },
    Topic { name: "media", what: "participating media: fog and smoke", rows: || family(&MediumDesc::DOC) },
    Topic { name: "lights", what: "light sources", rows: || family(&LightDesc::DOC) },
    Topic { name: "cameras", what: "projections", rows: || family(&CameraDesc::DOC) },
    Topic {
        name: "integrators",
        what: "light transport algorithms and debug views",
        rows: || family(&IntegratorDesc::DOC),
    },
    Topic {
        name: "antialias",
        what: "where a pixel's samples lie and how they are averaged",
        rows: || words(Antialias::DOCS),
    },
    Topic { name: "filters", what: "pixel filters", rows: || words(FilterKind::DOCS) },
    Topic { name: "aovs", what: "further channels of a picture (render passes)", rows: aovs },
    Topic {
        name: "transfers",
        what: "transfer functions from scene values to display values",
        rows: || words(Transfer::DOCS),
    },
    Topic { name: "tonemaps", what: "tone mapping operators", rows: || words(Tonemap::DOCS) },
    Topic { name: "formats", what: "file formats that Turner reads and writes", rows: formats },
    Topic { name: "sections", what: "sections of a scene file", rows: || words(SECTIONS) },
    Topic { name: "colors", what: "colour names", rows: colors },
    Topic { name: "errors", what: "error codes: `turner help CODE` explains one", rows: errors },
];

fn family(doc: &FamilyDoc) -> Vec<(String, String)> {
    doc.entries.iter().map(|e| (e.name.to_owned(), first_sentence(&paragraph(e.doc)))).collect()
}

fn words(docs: &[(&str, &str)]) -> Vec<(String, String)> {
    docs.iter().map(|(name, what)| ((*name).to_owned(), (*what).to_owned())).collect()
}

fn aovs() -> Vec<(String, String)> {
    let row = |(word, what): &(&str, &str)| {
        let channels = Aov::from_word(word).map_or(&[][..], |aov| aov.layout().channels);
        (
            (*word).to_owned(),
            format!("{} ({})", first_sentence(what).trim_end_matches('.'), channels.join(" ")),
        )
    };
    Aov::DOCS.iter().map(row).collect()
}

fn formats() -> Vec<(String, String)> {
    let dotted =
        |extensions: &[&str]| extensions.iter().map(|e| format!(".{e}")).collect::<Vec<_>>().join(" ");
    let pictures = ImageFormat::all().map(|f| {
        let how = match (f.can_read(), f.can_write()) {
            (true, true) => "read and written",
            (true, false) => "read",
            _ => "written",
        };
        (dotted(f.extensions()), format!("{}, {how}: {}", f.name(), f.description()))
    });
    let scenes = SceneFormat::all()
        .map(|f| (dotted(f.extensions()), format!("{}, read: {}", f.name(), f.description())));
    let profiles = (
        ".ies".to_owned(),
        "IES LM-63, read: measured emission profiles of point and spot lights".to_owned(),
    );
    let fonts = (".ttf .otf .ttc".to_owned(), "TrueType and OpenType, read: the letters of texts".to_owned());
    scenes.chain(pictures).chain([profiles, fonts]).collect()
}

fn colors() -> Vec<(String, String)> {
    NAMES.iter().map(|(name, rgb)| ((*name).to_owned(), format!("#{rgb:06x}"))).collect()
}

fn errors() -> Vec<(String, String)> {
    ErrorCode::ALL.iter().map(|c| (c.as_str().to_owned(), c.meaning().to_owned())).collect()
}

/// Runs the command.
pub(crate) fn run(args: &ListArgs) -> u8 {
    let rows = match TOPICS.iter().find(|t| Some(t.name) == args.topic.as_deref()) {
        Some(topic) => (topic.rows)(),
        None => TOPICS.iter().map(|t| (t.name.to_owned(), t.what.to_owned())).collect(),
    };
    if args.json {
        let rows: Vec<_> = rows.iter().map(|(n, d)| json!({ "name": n, "description": d })).collect();
        text::print(&format!("{}\n", serde_json::Value::Array(rows)));
    } else {
        text::print(&text::columns(rows.iter().map(|(name, what)| (name.as_str(), what.clone()))));
        if args.topic.is_none() {
            text::print(
                "\n`turner list TOPIC` lists the names of a topic, `turner help NAME` explains a name.\n",
            );
        }
    }
    0
}
