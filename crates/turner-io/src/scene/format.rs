//! The file formats of scenes and models: one table for extensions, listings and messages.

use std::path::Path;

use turner::schema::{ErrorCode, SceneError};

use crate::assets::{nearest, printable};

/// One row of the table.
struct Row {
    format: SceneFormat,
    name: &'static str,
    extensions: &'static [&'static str],
    description: &'static str,
    holds: Holds,
}

/// What a file of a format contains.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Holds {
    /// A scene in Turner's own format.
    Scene,
    /// A model of another program, without render settings.
    Model,
    /// A model that is one mesh.
    Mesh,
    /// A scene of another renderer, with its own camera, film and integrator.
    Whole,
}

/// The table of formats: each entry becomes an enum variant and a row.
macro_rules! formats {
    ($($(#[doc = $doc:literal])+ $variant:ident { $($line:tt)+ })+) => {
        /// A file format of scenes or models.
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
        description: "a Turner scene: text, written by hand",
        holds: Holds::Scene,
    }
    /// glTF 2.0, as text (`.gltf`) or binary (`.glb`).
    Gltf {
        name: "glTF 2.0",
        extensions: &["glb", "gltf"],
        description: "a model: nodes, meshes, skins, animations, PBR materials, lights, cameras",
        holds: Holds::Model,
    }
    /// Universal Scene Description, as text (`.usda`), binary (`.usdc`, `.usd`) or package (`.usdz`).
    Usd {
        name: "USD",
        extensions: &["usdz", "usd", "usda", "usdc"],
        description: "a model: composed prims, subdivision surfaces, instances, UsdPreviewSurface, lights, cameras",
        holds: Holds::Model,
    }
    /// Wavefront OBJ: a mesh.
    Obj {
        name: "Wavefront OBJ",
        extensions: &["obj"],
        description: "a mesh: polygons, normals, texture coordinates, materials from MTL files",
        holds: Holds::Mesh,
    }
    /// Stanford PLY: a mesh or a point cloud.
    Ply {
        name: "Stanford PLY",
        extensions: &["ply"],
        description: "a mesh or a point cloud: polygons, normals, texture coordinates, colours; ASCII and binary",
        holds: Holds::Mesh,
    }
    /// STL: a mesh.
    Stl {
        name: "STL",
        extensions: &["stl"],
        description: "a mesh: triangles; ASCII and binary; z is up",
        holds: Holds::Mesh,
    }
    /// pbrt-v4: a scene of another renderer.
    Pbrt {
        name: "pbrt-v4",
        extensions: &["pbrt"],
        description: "a scene with its camera, film, materials, lights and media",
        holds: Holds::Whole,
    }
    /// Mitsuba 3's XML: a scene of another renderer.
    Mitsuba {
        name: "Mitsuba",
        extensions: &["xml"],
        description: "a scene with its sensor, film, BSDFs, emitters and media; XML of Mitsuba 3, 2 and 0.6",
        holds: Holds::Whole,
    }
}

/// Extensions that users try but that Turner does not read as scenes.
const FOREIGN: &[(&[&str], &str)] = &[
    (&["json", "yaml", "yml"], "a JSON or YAML file"),
    (&["blend"], "a Blender file"),
    (&["fbx", "dae", "3ds", "abc", "max"], "a scene of a modelling program"),
    (&["off", "mtl"], "a model file"),
    (&["pov"], "a POV-Ray scene"),
    (&["png", "jpg", "jpeg", "exr", "hdr", "tif", "tiff", "gif", "bmp", "webp", "tga", "ktx2"], "an image"),
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

    /// Its contents in a few words.
    pub fn description(self) -> &'static str {
        self.row().description
    }

    /// Whether it is Turner's own scene format.
    pub fn is_scene(self) -> bool {
        self.row().holds == Holds::Scene
    }

    /// Whether it is a file of another program, which can be placed in a scene or rendered on its own.
    pub fn is_model(self) -> bool {
        !self.is_scene()
    }

    /// Whether it brings its own camera, film and integrator.
    pub(crate) fn is_whole(self) -> bool {
        self.row().holds == Holds::Whole
    }

    /// The format of a path, by its extension in upper or lower case.
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

/// The format of a path by its extension. A missing or unknown extension means TOML; a known foreign format is
/// an error.
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

/// The most similar mesh extension as `; the nearest is .ply`, or an empty string.
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
