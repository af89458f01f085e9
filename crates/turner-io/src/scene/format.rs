//! The formats of scenes and meshes: one table for extensions, listings and messages.

use crate::assets::{nearest, printable};
use std::path::Path;
use turner::scene::error::{ErrorCode, SceneError};

/// A file format that describes geometry or a whole scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SceneFormat {
    /// A scene in TOML.
    Toml,
    /// Wavefront OBJ: a mesh.
    Obj,
    /// Stanford PLY: a mesh or a cloud of points.
    Ply,
    /// STL: triangles.
    Stl,
}

/// One line of the table.
struct Row {
    format: SceneFormat,
    name: &'static str,
    extensions: &'static [&'static str],
    description: &'static str,
    is_scene: bool,
}

const TABLE: &[Row] = &[
    Row {
        format: SceneFormat::Toml,
        name: "TOML",
        extensions: &["toml"],
        description: "a scene: text that a person writes",
        is_scene: true,
    },
    Row {
        format: SceneFormat::Obj,
        name: "Wavefront OBJ",
        extensions: &["obj"],
        description: "a mesh: polygons, normals, texture coordinates; materials are ignored",
        is_scene: false,
    },
    Row {
        format: SceneFormat::Ply,
        name: "Stanford PLY",
        extensions: &["ply"],
        description: "a mesh or points: polygons, normals, texture coordinates, colours; ASCII and binary",
        is_scene: false,
    },
    Row {
        format: SceneFormat::Stl,
        name: "STL",
        extensions: &["stl"],
        description: "a mesh: triangles, perhaps colours; ASCII and binary",
        is_scene: false,
    },
];

/// Extensions of files that people try and that are not read as scenes.
const FOREIGN: &[(&[&str], &str)] = &[
    (&["glb", "gltf"], "a glTF scene"),
    (&["pbrt"], "a pbrt scene"),
    (&["xml"], "an XML file (Mitsuba?)"),
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

    /// Whether it is a whole scene that can be rendered, rather than a mesh.
    pub fn is_scene(self) -> bool {
        self.row().is_scene
    }

    /// The format that a name asks for by its extension, in upper or lower case.
    pub fn of_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_string_lossy().to_lowercase();
        TABLE.iter().find(|row| row.extensions.contains(&extension.as_str())).map(|row| row.format)
    }

    /// `TOML (.toml)`: the formats of scenes, for messages.
    pub(crate) fn listing() -> String {
        list(|row| row.is_scene)
    }

    /// `Wavefront OBJ (.obj), …`: the formats of meshes, for messages.
    pub(crate) fn mesh_listing() -> String {
        list(|row| !row.is_scene)
    }
}

fn list(wanted: impl Fn(&Row) -> bool) -> String {
    let rows = TABLE.iter().filter(|row| wanted(row));
    rows.map(|row| format!("{} (.{})", row.name, row.extensions[0])).collect::<Vec<_>>().join(", ")
}

/// Refuses a path that is no text scene by its extension; an unknown one or none is taken for TOML.
pub(super) fn check_scene(path: &Path) -> Result<(), SceneError> {
    let Some(extension) = path.extension().map(|e| e.to_string_lossy().to_lowercase()) else { return Ok(()) };
    let name = printable(&path.to_string_lossy());
    let found = match SceneFormat::of_path(path) {
        Some(format) if format.is_scene() => return Ok(()),
        Some(format) => {
            let message =
                format!("{name}: is a {} mesh; expected a scene: {}", format.name(), SceneFormat::listing());
            let file = printable(&path.file_name().unwrap_or_default().to_string_lossy());
            return Err(SceneError::new(ErrorCode::File, message)
                .help(format!("write a scene with [[object]] type = \"mesh\", file = \"{file}\"")));
        }
        None => FOREIGN
            .iter()
            .find(|(extensions, _)| extensions.contains(&extension.as_str()))
            .map(|(_, what)| *what),
    };
    let Some(found) = found else { return Ok(()) };
    let message = format!("{name}: is {found}; expected a scene: {}", SceneFormat::listing());
    Err(SceneError::new(ErrorCode::File, message)
        .help(format!("meshes are read from {}", SceneFormat::mesh_listing())))
}

/// The nearest extension of a mesh, as `; the nearest is .ply`, or nothing.
pub(crate) fn nearest_mesh_extension(extension: &str) -> String {
    let every = TABLE.iter().filter(|row| !row.is_scene).flat_map(|row| row.extensions.iter().copied());
    nearest(extension, every).map_or_else(String::new, |e| format!("; the nearest is .{e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_each_format_once() {
        for format in [SceneFormat::Toml, SceneFormat::Obj, SceneFormat::Ply, SceneFormat::Stl] {
            assert_eq!(TABLE.iter().filter(|row| row.format == format).count(), 1);
            assert_eq!(
                SceneFormat::of_path(Path::new(&format!("a.{}", format.extensions()[0]))),
                Some(format)
            );
        }
        assert_eq!(SceneFormat::all().count(), TABLE.len());
    }

    #[test]
    fn other_files_are_named() {
        assert!(check_scene(Path::new("a.TOML")).is_ok() && check_scene(Path::new("scene")).is_ok());
        let message = check_scene(Path::new("a.glb")).unwrap_err().to_string();
        assert!(message.contains("glTF") && message.contains("TOML (.toml)"), "{message}");
        assert!(check_scene(Path::new("a.ply")).unwrap_err().help.unwrap().contains("a.ply"));
    }
}
