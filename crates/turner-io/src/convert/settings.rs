//! The settings of a render as TOML: `[film]` and `[integrator]`.

use turner::description::{SceneAssetWriter, SceneDesc, write_scene};
use turner::film::FilmDesc;
use turner::image::Image;
use turner::integrator::IntegratorDesc;
use turner::schema::value::Data;
use turner::schema::{
    Asset, ErrorCode, FontFile, GridFile, ImageId, MeasuredFile, MeshData, MeshId, ProfileFile, SceneError,
};

/// Film and integrator as TOML: one `key = value` per line, as in the sections `[film]` and `[integrator]` of a scene.
/// Keys at their default are left out; those of the film depend on the integrator.
///
/// Errors: none for settings that a scene can have.
pub fn settings_text(film: &FilmDesc, integrator: &IntegratorDesc) -> Result<[String; 2], SceneError> {
    let desc = SceneDesc { film: film.clone(), integrator: integrator.clone(), ..SceneDesc::default() };
    let root = write_scene(&desc, &mut NoFiles)?;
    let section = |name: &str| match &root.data {
        Data::Table(top) => top.get(name).map_or_else(String::new, super::text::keys),
        _ => String::new(),
    };
    Ok([section("film"), section("integrator")])
}

/// Film and integrator refer to no files.
struct NoFiles;

fn none<T>() -> Result<T, SceneError> {
    Err(SceneError::new(ErrorCode::Internal, "the settings of a render refer to a file"))
}

impl SceneAssetWriter for NoFiles {
    fn image(&mut self, _: ImageId, _: &Asset<Image>) -> Result<String, SceneError> {
        none()
    }
    fn mesh(&mut self, _: MeshId, _: &Asset<MeshData>) -> Result<Option<String>, SceneError> {
        none()
    }
    fn light_profile(&mut self, _: &ProfileFile) -> Result<String, SceneError> {
        none()
    }
    fn measured_brdf(&mut self, _: &MeasuredFile) -> Result<String, SceneError> {
        none()
    }
    fn grid(&mut self, _: &GridFile) -> Result<String, SceneError> {
        none()
    }
    fn font(&mut self, _: &FontFile) -> Result<String, SceneError> {
        none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use turner::integrator::PathDesc;

    #[test]
    fn settings_are_toml() {
        let film = FilmDesc { width: 30, crop: Some([1, 2, 3, 4]), ..FilmDesc::default_for("path") };
        let path = IntegratorDesc::Path(PathDesc { max_depth: 3, ..PathDesc::default() });
        let [film, integrator] = settings_text(&film, &path).unwrap();
        assert_eq!(film, "width = 30\ncrop = [1, 2, 3, 4]\n");
        assert_eq!(integrator, "type = \"path\"\nmax_depth = 3\n");
    }
}
