//! Pages of the reference that come from no table: objects, groups, transforms, colours, includes.

use turner::description::SECTIONS;

use crate::reference::{Key, Page};

/// The example of the overview.
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

/// Further paragraphs on families of types.
pub(crate) const CAMERA: &str = "Without `[camera]` the scene is framed from the front.";
pub(crate) const INTEGRATOR: &str = "";
pub(crate) const SHAPE: &str = "The keys of a shape and those of every object (`name`, `material`, `transform`, `motion`) share one table.";
pub(crate) const MATERIAL: &str = "An object refers to a material by name, `material = \"NAME\"`, or defines it in place, `material = { … }`.";
pub(crate) const MEDIUM: &str = "An object that bounds only a medium has `medium = \"NAME\"` and no material. A dielectric has its interior medium as \
    `interior = \"NAME\"`. The `medium` of `[background]` fills the rest of the scene. Shapes with a medium must be closed. Where they \
    overlap, the material that comes first in the scene has priority, and a dielectric has priority over both.";
pub(crate) const TEXTURE: &str = "";
pub(crate) const LIGHT: &str = "Lights and emissive objects with the same `light_group = \"NAME\"` form a light group. `turner info` lists the light groups. The `name` of a light is used in reports. A light with `hidden = true` does not shine.";

/// Sections as written in a scene, with their contents.
pub(crate) fn sections() -> Vec<(String, &'static str)> {
    let written = |name: &str| match name {
        "include" => "include = [\"FILE\", …]".to_owned(),
        "texture" | "material" | "group" => format!("[{name}.NAME]"),
        "object" | "light" | "view" | "animation" => format!("[[{name}]]"),
        name => format!("[{name}]"),
    };
    // The tables append the written form after a colon.
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
            "An object is a shape with a material, a model, or an instance of a group. Each `[[object]]` adds one. Their \
           order matters only where two surfaces coincide: the first one is hit.",
        ],
        vec![
            key(
                "type",
                "\"text\"",
                None,
                "The shape, \"model\" for a model file, or \"instance\" for an instance of a group. The keys of that type follow.",
            ),
            key("name", "\"text\"", Some("none"), "A name, used in reports."),
            key(
                "light_group",
                "\"text\"",
                Some("none"),
                "The light group of an object with an emissive material. An object in a group without this key has that of the instance.",
            ),
            key(
                "shadow_catcher",
                "true | false",
                Some("`false`"),
                "Whether the camera sees nothing of the object but the shadow that others cast on it: alpha is the fraction of the direct light that they keep off. Reflections, and light that it reflects, stay. Integrators \"path\" and \"direct\".",
            ),
            key(
                "hidden_from_camera",
                "true | false",
                Some("`false`"),
                "Whether rays from the camera pass through the object. All other rays meet it: it is visible in mirrors, casts shadows and emits light. An instance or model hides everything in it.",
            ),
            key(
                "hidden",
                "true | false",
                Some("`false`"),
                "Whether the object is left out of the picture: it is not seen, casts no shadow and emits no light. A hidden instance or model hides everything in it.",
            ),
            key(
                "material",
                "material",
                Some("none"),
                "The name of a `[material.NAME]`, or a material defined in place. In a group, an object without one \
                 takes the material of the instance. Otherwise the default material is used.",
            ),
            key(
                "transform",
                "transform",
                Some("none"),
                "Transform from object space to scene space; see `transform`.",
            ),
            key(
                "motion",
                "transform",
                Some("none"),
                "The transform at time 1, for motion blur; `transform` is that at time 0. `shutter` in `[film]` sets when the shutter opens and closes. Rotations take the shorter arc. A moving emitter is not sampled as a light: only BSDF-sampled rays that hit it contribute.",
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
            "A named set of objects. Each `[[object]]` with `type = \"instance\"` places all of them. A group may \
           contain instances of other groups, but not of itself. A group without an instance is not rendered.",
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
            "A table of steps, applied in the order of the keys below, or a list of such tables, applied from \
             first to last. Angles are in degrees, counter-clockwise when the axis points towards you.",
            "A transform must be invertible: no scale may be 0.",
        ],
        vec![
            key(
                "scale",
                "number | [x, y, z]",
                Some("none"),
                "Scales about the origin; negative values mirror.",
            ),
            key(
                "rotate",
                "[x, y, z] | { axis = [x, y, z], angle = number }",
                Some("none"),
                "Rotates about the x, then the y, then the z axis; or about any axis through the origin. Degrees.",
            ),
            key("translate", "[x, y, z]", Some("none"), "Translates."),
            key(
                "matrix",
                "12 or 16 numbers",
                Some("none"),
                "Row by row, flat or as a list of rows. Points are column vectors, so the translation is the last column.",
            ),
            key(
                "look_at",
                "{ from = [x, y, z], to = [x, y, z], up = [x, y, z] }",
                Some("none"),
                "Moves the origin to `from`, with the z axis towards `to` and the y axis as close to `up` as possible. \
                 The defaults are the origin for `from` and [0, 1, 0] for `up`.",
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
            "`[r, g, b]` and single numbers (grey) are linear scene values and may exceed 1. `\"#rrggbb\"`, \
             `\"#rgb\"` and names are display values: the `transfer` of `[film]` converts them to scene values.",
            "The names are those of CSS: `turner list colors`. A key of type `color | texture` also takes the name of a \
             texture, or a texture defined in place: `{ type = …, … }`.",
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
            "Names of scene files that are read first; the key stands at the top of a scene. The name of a model file (see `model`) adds the model as an object. Tables are merged key by key, and \
           the including file wins; the lists `[[object]]` and `[[light]]` are appended. Paths are \
           relative to the file that contains them and must stay inside the folder of the scene.",
        ],
        Vec::new(),
        r#"include = ["materials.toml"]

[[object]]
type = "sphere"
"#,
    )
}
