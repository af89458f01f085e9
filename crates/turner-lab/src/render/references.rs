//! Converged images to measure errors against, and their own noise.

use std::path::{Path, PathBuf};

use turner::schema::{ErrorCode, SceneError};
use turner::testing::relative_mse;
use turner_cli::failure::Failure;

use crate::picture::Picture;

/// A converged image.
pub(super) struct Reference {
    width: u32,
    height: u32,
    pixels: Vec<[f64; 3]>,
    /// The relative mean square error of the reference itself.
    pub(super) noise: f64,
}

impl Reference {
    /// The error of an image of the same size, minus the reference's own. `None` if most of the difference is the
    /// reference's own error.
    pub(super) fn error(&self, picture: &[[f64; 3]]) -> Option<f64> {
        let found = relative_mse(picture, &self.pixels) - self.noise;
        (found.is_finite() && found > 0.25 * self.noise).then_some(found)
    }
}

/// The reference for `scene`, with `width` × `height` pixels: a file of its name (`s1.exr` or `S1.exr`) among `given`,
/// which are folders and files; by default the file next to the scene. If a reference cannot be used, that is an error
/// if it was given, else a remark.
pub(super) fn find(
    given: &[PathBuf],
    scene: &Path,
    (width, height): (u32, u32),
) -> Result<Result<Reference, String>, Failure> {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let path = if given.is_empty() {
        Some(scene.with_extension("exr")).filter(|p| p.is_file())
    } else {
        given.iter().find_map(|p| if p.is_dir() { in_folder(p, &stem) } else { named(p, &stem, given.len()) })
    };
    let Some(path) = path else {
        let remark = format!(
            "{stem}: errors need a converged image {stem}.exr: pass it or its folder with --references"
        );
        if given.is_empty() {
            return Ok(Err(remark));
        }
        let shown: Vec<String> = given.iter().map(|p| p.display().to_string()).collect();
        let message = format!("there is no reference image {stem}.exr in {}", shown.join(", "));
        return Err(Failure::usage(SceneError::new(ErrorCode::File, message)));
    };
    let shown = path.display().to_string();
    let image = Picture::read(&path)?;
    if (image.width, image.height) != (width, height) {
        let message =
            format!("{shown}: {}x{} pixels, the scene has {width}x{height}", image.width, image.height);
        if given.is_empty() {
            return Ok(Err(format!(
                "{message}: errors need an image of that size: pass it with --references"
            )));
        }
        return Err(Failure::new(SceneError::new(ErrorCode::Image, message)));
    }
    Ok(Ok(Reference { width, height, pixels: image.pixels, noise: noise(&path, &stem)? }))
}

/// The image with the scene's name, in any case.
fn in_folder(folder: &Path, stem: &str) -> Option<PathBuf> {
    let mut found: Vec<PathBuf> = std::fs::read_dir(folder).ok()?.flatten().map(|e| e.path()).collect();
    found.sort();
    found
        .into_iter()
        .find(|p| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) && has_stem(p, stem))
}

/// A file given by name. If it is the only one, it belongs to any scene.
fn named(path: &Path, stem: &str, count: usize) -> Option<PathBuf> {
    (count == 1 || has_stem(path, stem)).then(|| path.to_owned())
}

fn has_stem(path: &Path, stem: &str) -> bool {
    path.file_stem().is_some_and(|s| s.to_string_lossy().eq_ignore_ascii_case(stem))
}

/// `own_noise` of the image in the `refs.json` next to it; 0 without.
fn noise(picture: &Path, stem: &str) -> Result<f64, Failure> {
    let path = picture.with_file_name("refs.json");
    let Ok(text) = std::fs::read_to_string(&path) else { return Ok(0.0) };
    let wrong = |what: String| {
        let error = SceneError::new(ErrorCode::File, format!("{}: {what}", path.display()));
        Failure::new(error.help(
            "expected { \"S1\": { \"own_noise\": 9e-5 } }, the relative mean square error of each image",
        ))
    };
    let json: serde_json::Value = serde_json::from_str(&text).map_err(|e| wrong(e.to_string()))?;
    let own = picture.file_stem().unwrap_or_default().to_string_lossy();
    let entries = json.as_object().ok_or_else(|| wrong("not a JSON object".into()))?;
    let entry = entries.iter().find(|(k, _)| k.eq_ignore_ascii_case(&own) || k.eq_ignore_ascii_case(stem));
    let Some(value) = entry.and_then(|(_, e)| e.get("own_noise")) else { return Ok(0.0) };
    match value.as_f64() {
        Some(noise) if (0.0..1.0).contains(&noise) => Ok(noise),
        _ => Err(wrong(format!("own_noise of {stem} is {value}"))),
    }
}

impl std::fmt::Debug for Reference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}, noise {}", self.width, self.height, self.noise)
    }
}
