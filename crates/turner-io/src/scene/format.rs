//! The formats of scenes and meshes: one table for extensions, listings and messages.

use std::path::Path;

use turner::schema::{ErrorCode, SceneError};

use crate::assets::{nearest, printable};

/// One line of the table.
struct Row {
    format: SceneFormat,
    name: &'static str,
    extensions: &'static [&'static str],
    description: &'static str,
    holds: Holds,
}

/// What a file of a format is used for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Holds {
    /// A scene in Turner's own language.
    Scene,
    /// A model: a scene of another program.
    Model,
    /// A model that is one mesh.
    Mesh,
    /// A scene of another renderer, which says by itself how it is to be rendered: with its own camera, film and integrator.
    Whole,
}

/// The table of formats: each entry is a variant and its line.
macro_rules! formats {
    ($($(#[doc = $doc:literal])+ $variant:ident { $($line:tt)+ })+) => {
        /// A file format that describes geometry or a whole scene.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum SceneFormat { $($(#[doc = $doc])+ $variant,)+ }

        const TABLE: &[Row] = &[$(Row { format: SceneFormat::$variant, $($line)+ },)+];
    };
}

formats! {
    /// A scene in TOML.
    Toml {
        name: "TOML",
        extensions: &["toml"],
        description: "a scene: text that a person writes",
        holds: Holds::Scene,
    }
    /// glTF 2.0, as text or in one file.
    Gltf {
        name: "glTF 2.0",
        extensions: &["glb", "gltf"],
        description: "a model: nodes, meshes, skins, animations, physical materials, lights, cameras",
        holds: Holds::Model,
    }
    /// Wavefront OBJ: a mesh.
    Obj {
        name: "Wavefront OBJ",
        extensions: &["obj"],
        description: "a model of one mesh: polygons, normals, texture coordinates, materials of its MTL files",
        holds: Holds::Mesh,
    }
    /// Stanford PLY: a mesh or a cloud of points.
    Ply {
        name: "Stanford PLY",
        extensions: &["ply"],
        description: "a model of one mesh or a cloud of points: polygons, normals, texture coordinates, colours; ASCII and binary",
        holds: Holds::Mesh,
    }
    /// STL: a mesh.
    Stl {
        name: "STL",
        extensions: &["stl"],
        description: "a model of one mesh: triangles; ASCII and binary; z is taken for up",
        holds: Holds::Mesh,
    }
    /// pbrt-v4: a scene of another renderer.
    Pbrt {
        name: "pbrt-v4",
        extensions: &["pbrt"],
        description: "a scene of another renderer, with its camera, film, materials, lights and media",
        holds: Holds::Whole,
    }
    /// Mitsuba 3's XML: a scene of another renderer.
    Mitsuba {
        name: "Mitsuba",
        extensions: &["xml"],
        description: "a scene of another renderer, with its sensor, film, BSDFs, emitters and media; XML of Mitsuba 3, 2 and 0.6",
        holds: Holds::Whole,
    }
}

/// Extensions of files that people try and that are not read as scenes.
const FOREIGN: &[(&[&str], &str)] = &[
    (&["json", "yaml", "yml"], "a JSON or YAML file"),
    (&["blend"], "a Blender file"),
    (&["usd", "usda", "usdc", "usdz"], "a USD scene"),
    (&["fbx", "dae", "3ds", "abc", "max"], "a scene of a modelling program"),
    (&["off", "mtl"], "a model file"),
    (&["pov"], "a POV-Ray scene"),
    (&["png", "jpg", "jpeg", "exr", "hdr", "tif", "tiff", "gif", "bmp", "webp", "tga"], "a picture"),
    (&["zip", "gz", "zst", "7z", "tar"], "an archive"),
];

impl SceneFormat {
    /// Every format, in the order of the table.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.iter().map(|row| row.format)
    }

    fn row(self) -> &'static Row {
        TABLE.iter().find(|row| row.format == self).unwrap_or(&TABLE[0])
    }

    /// The format's name in messages.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// The extensions that mean this format, lower case, the usual one first.
    pub fn extensions(self) -> &'static [&'static str] {
        self.row().extensions
    }

    /// What it holds, in a few words.
    pub fn description(self) -> &'static str {
        self.row().description
    }

    /// Whether it is a scene in Turner's own language, rather than a model.
    pub fn is_scene(self) -> bool {
        self.row().holds == Holds::Scene
    }

    /// Whether it is a model of another program, which can be placed in a scene or rendered by itself.
    pub fn is_model(self) -> bool {
        !self.is_scene()
    }

    /// Whether it says by itself how it is to be rendered: with its own camera, film and integrator.
    pub(crate) fn is_whole(self) -> bool {
        self.row().holds == Holds::Whole
    }

    /// The format that a name asks for by its extension, in upper or lower case.
    pub fn of_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_string_lossy().to_lowercase();
        TABLE.iter().find(|row| row.extensions.contains(&extension.as_str())).map(|row| row.format)
    }

    /// `TOML (.toml)`: the formats of scenes, for messages.
    pub(crate) fn listing() -> String {
        list(|row| row.holds == Holds::Scene)
    }

    /// `Wavefront OBJ (.obj), …`: the formats of meshes, for messages.
    pub(crate) fn mesh_listing() -> String {
        list(|row| row.holds == Holds::Mesh)
    }

    /// The formats of models, for messages.
    pub(crate) fn model_listing() -> String {
        list(|row| row.holds != Holds::Scene)
    }
}

fn list(wanted: impl Fn(&Row) -> bool) -> String {
    let rows = TABLE.iter().filter(|row| wanted(row));
    rows.map(|row| format!("{} (.{})", row.name, row.extensions[0])).collect::<Vec<_>>().join(", ")
}

/// The format of a path by its extension; an unknown one or none is taken for TOML, that of other programs refused.
pub(super) fn check_scene(path: &Path) -> Result<SceneFormat, SceneError> {
    if let Some(format) = SceneFormat::of_path(path) {
        return Ok(format);
    }
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let found = FOREIGN.iter().find(|(extensions, _)| extensions.contains(&extension.as_str()));
    let Some((_, found)) = found else { return Ok(SceneFormat::Toml) };
    let name = printable(&path.to_string_lossy());
    let message = format!("{name}: is {found}; expected a scene: {}", SceneFormat::listing());
    Err(SceneError::new(ErrorCode::File, message)
        .help(format!("models are read from {}", SceneFormat::model_listing())))
}

/// The nearest extension of a mesh, as `; the nearest is .ply`, or nothing.
pub(crate) fn nearest_mesh_extension(extension: &str) -> String {
    let every =
        TABLE.iter().filter(|row| row.holds == Holds::Mesh).flat_map(|row| row.extensions.iter().copied());
    nearest(extension, every).map_or_else(String::new, |e| format!("; the nearest is .{e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_extension_means_one_format() {
        for format in SceneFormat::all() {
            for extension in format.extensions() {
                assert_eq!(SceneFormat::of_path(Path::new(&format!("a.{extension}"))), Some(format));
                assert!(FOREIGN.iter().all(|(extensions, _)| !extensions.contains(extension)), "{extension}");
            }
        }
    }

    #[test]
    fn other_files_are_named() {
        for name in ["a.TOML", "scene", "a.scene"] {
            assert_eq!(check_scene(Path::new(name)).unwrap(), SceneFormat::Toml);
        }
        assert_eq!(check_scene(Path::new("a.GLB")).unwrap(), SceneFormat::Gltf);
        let error = check_scene(Path::new("a.fbx")).unwrap_err();
        assert!(error.message.contains("TOML (.toml)"), "{error}");
        assert!(error.help.unwrap().contains("glTF 2.0 (.glb)"));
    }
}
