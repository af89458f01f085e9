//! Pages of the reference that no table holds: objects, groups, transforms, colours, includes.

use turner::description::SECTIONS;

use crate::reference::{Key, Page};

/// A scene that shows something.
pub(crate) const SCENE: &str = r##"[camera]
position = [0, 1.5, 6]
look_at = [0, 1, 0]

[[object]]
type = "sphere"
center = [0, 1, 0]
material = { color = "tomato", k_reflect = 0.2 }

[[light]]
type = "point"
position = [5, 8, 5]
"##;

/// What is common to all of a family, beside its own words.
pub(crate) const CAMERA: &str = "Without `[camera]` the whole scene is framed from the front.";
pub(crate) const INTEGRATOR: &str = "";
pub(crate) const SHAPE: &str =
    "The keys of a shape stand beside those of the object: `name`, `material`, `transform`, `motion`.";
pub(crate) const MATERIAL: &str =
    "An object names its material, `material = \"NAME\"`, or has it in place, `material = { … }`.";
pub(crate) const MEDIUM: &str = "An object that is nothing but a medium says `medium = \"NAME\"` in place of a material; glass with a medium inside says \
    `interior = \"NAME\"` in its material; all that is in the open has the `medium` of `[background]`. Shapes with a medium must be closed. Where they \
    overlap, the material that stands first in the scene counts, as glass does before both.";
pub(crate) const TEXTURE: &str = "";
pub(crate) const LIGHT: &str = "A light of any type may have a `group = \"NAME\"`: lights of one name, and objects with that `light_group`, belong together. `turner info` lists the groups. A `name` is for reports.";

/// Sections as they are written, with what they hold.
pub(crate) fn sections() -> Vec<(String, &'static str)> {
    let written = |name: &str| match name {
        "include" => "include = [\"FILE\", …]".to_owned(),
        "texture" | "material" | "group" => format!("[{name}.NAME]"),
        "object" | "light" | "view" => format!("[[{name}]]"),
        name => format!("[{name}]"),
    };
    // The tables say how it is written, too.
    SECTIONS.iter().map(|(name, what)| (written(name), what.split(": [").next().unwrap_or(what))).collect()
}

fn key(name: &str, kind: &str, default: Option<&str>, doc: &str) -> Key {
    Key {
        name: name.into(),
        kind: kind.into(),
        default: default.map(Into::into),
        range: None,
        doc: doc.into(),
        words: &[],
    }
}

fn page(name: &'static str, title: &str, paragraphs: &[&str], keys: Vec<Key>, example: &str) -> Page {
    Page {
        name,
        title: title.into(),
        paragraphs: paragraphs.iter().map(|p| (*p).to_owned()).collect(),
        keys,
        example: Some(example.trim_end().to_owned()),
    }
}

pub(crate) fn object() -> Page {
    page(
        "object",
        "the section [[object]]",
        &[
            "What is in the scene: a shape with a material, or a group that is placed. Each `[[object]]` is one; their \
           order matters only where two surfaces coincide: the first wins.",
        ],
        vec![
            key(
                "type",
                "\"text\"",
                None,
                "The shape, \"model\" for a file of another program, or \"instance\" to place a group. The keys of the shape follow.",
            ),
            key("name", "\"text\"", Some("none"), "A name for reports."),
            key(
                "light_group",
                "\"text\"",
                Some("none"),
                "The group of lights that it belongs to where its material shines; objects of a group without one take the instance's.",
            ),
            key(
                "material",
                "material",
                Some("none"),
                "The name of a `[material.NAME]`, or a material written in place. In a group, an object without one \
                 takes that of the instance; at last there is the default material.",
            ),
            key("transform", "transform", Some("none"), "Where it is placed; see `transform`."),
            key(
                "motion",
                "transform",
                Some("none"),
                "Where it goes while `transform` is where it comes from: at which moments of that way the shutter opens and closes says `shutter` of `[film]`. Rotations go the shorter way. Light of things that move is only found by chance.",
            ),
            key("group", "\"text\"", Some("none"), "For \"instance\": the name of the group."),
        ],
        r#"[material.glass]
color = "white"
k_refract = 0.9
ior = 1.5

[[object]]
type = "sphere"
name = "ball"
material = "glass"
transform = { scale = [1, 2, 1], translate = [0, 1, 0] }
"#,
    )
}

pub(crate) fn group() -> Page {
    page(
        "group",
        "the section [group.NAME]",
        &[
            "Objects that are placed together, as often as needed, by `[[object]]` with `type = \"instance\"`. A group may \
           hold instances of other groups, but not of itself. A group that is not placed is not seen.",
        ],
        vec![key("object", "[[group.NAME.object]]", None, "Its objects; keys as in `[[object]]`.")],
        r#"[[group.pair.object]]
type = "sphere"
radius = 0.5

[[group.pair.object]]
type = "sphere"
radius = 0.3
center = [0, 0.8, 0]
material = { color = "gold" }

[[object]]
type = "instance"
group = "pair"
material = { color = "teal" }

[[object]]
type = "instance"
group = "pair"
transform = { translate = [1.5, 0, 0] }
"#,
    )
}

pub(crate) fn transform() -> Page {
    page(
        "transform",
        "transforms",
        &[
            "A table of steps, which are applied in the order of the keys below, or a list of such tables, applied from \
             first to last. Angles are in degrees, counter-clockwise seen from the tip of the axis.",
            "A transform must be one that can be undone: no scale of 0.",
        ],
        vec![
            key(
                "scale",
                "number | [x, y, z]",
                Some("none"),
                "Stretches about the origin; negative values mirror.",
            ),
            key(
                "rotate",
                "[x, y, z] | { axis = [x, y, z], angle = number }",
                Some("none"),
                "Turns about the x, then the y, then the z axis; or about any axis through the origin.",
            ),
            key("translate", "[x, y, z]", Some("none"), "Moves."),
            key(
                "matrix",
                "12 or 16 numbers",
                Some("none"),
                "Row by row, flat or as a list of rows; points are columns, so the translation is the last column.",
            ),
            key(
                "look_at",
                "{ from = [x, y, z], to = [x, y, z], up = [x, y, z] }",
                Some("none"),
                "Places the origin at `from` with the z axis towards `to` and the y axis as near `up` as that allows. \
                 `from` is the origin and `up` is [0, 1, 0] unless given.",
            ),
        ],
        r#"[[object]]
type = "sphere"
transform = [
    { scale = [1, 0.5, 1], rotate = [0, 45, 0] },
    { rotate = { axis = [1, 1, 0], angle = 30 }, translate = [0, 1, 0] },
]
"#,
    )
}

pub(crate) fn color() -> Page {
    page(
        "color",
        "colours",
        &[
            "`[r, g, b]` and single numbers (grey) are scene values as they stand, and may exceed 1. `\"#rrggbb\"`, \
             `\"#rgb\"` and names are what a display shows: the `transfer` of `[film]` makes scene values of them.",
            "The names are those of CSS: `turner list colors`. Where a key takes `color | texture`, the name of a \
             texture or a texture written in place, `{ type = …, … }`, may stand instead.",
        ],
        Vec::new(),
        r##"[[object]]
type = "sphere"
material = { color = [0.8, 0.3, 0.1] }

[[object]]
type = "sphere"
center = [2, 0, 0]
material = { color = "#4682b4" }

[[object]]
type = "sphere"
center = [4, 0, 0]
material = { color = "steelblue" }

[[light]]
type = "ambient"
color = 0.3
"##,
    )
}

pub(crate) fn include() -> Page {
    page(
        "include",
        "the key include",
        &[
            "Names of scene files, at the top of a scene, whose sections are read first; the name of a model (see `model`) brings it in as an object. Tables are merged key by key and \
           the file that includes wins; the lists `[[object]]` and `[[light]]` are appended. Paths in a file are \
           relative to that file and stay inside the folder of the scene.",
        ],
        Vec::new(),
        r#"include = ["materials.toml"]

[[object]]
type = "sphere"
"#,
    )
}
