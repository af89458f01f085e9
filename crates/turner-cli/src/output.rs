//! Where the picture goes, checked before anything is rendered, and what is written with it.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use turner::color::Transfer;
use turner::description::SceneDesc;
use turner::film::Picture;
use turner::integrator::{IntegratorDesc, Prepared};
use turner::schema::{ErrorCode, SceneError};
use turner::view::View;
use turner_io::image::{ImageFormat, Metadata, OutputFile};
use turner_io::{SaveOptions, to_bytes};

use crate::failure::{Failure, two_lines};
use crate::sequence::Step;

/// Formats by their option.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum FormatArg {
    /// 8 bits, what the display shows
    Png,
    /// Linear floats, what was computed
    Exr,
    /// 8 bits, lossy
    Jpg,
    /// Linear, shared exponent
    Hdr,
}

impl From<FormatArg> for ImageFormat {
    fn from(format: FormatArg) -> ImageFormat {
        match format {
            FormatArg::Png => ImageFormat::Png,
            FormatArg::Exr => ImageFormat::Exr,
            FormatArg::Jpg => ImageFormat::Jpeg,
            FormatArg::Hdr => ImageFormat::Hdr,
        }
    }
}

/// A place for a picture that has been found fit to be written.
#[derive(Debug)]
pub(crate) struct Output {
    /// `None` is standard output.
    path: Option<PathBuf>,
    format: ImageFormat,
}

impl Output {
    /// Checks the path and the format. Nothing is left behind, so that a render that is killed leaves nothing either.
    pub(crate) fn new(
        path: Option<&Path>,
        format: Option<FormatArg>,
        scene: &Path,
    ) -> Result<Output, Failure> {
        let usage = |message: &str, help: &str| {
            Err(Failure::usage(SceneError::new(ErrorCode::Output, message).help(help)))
        };
        let path = match path {
            Some(path) => path.to_owned(),
            None if scene == Path::new("-") => {
                return usage("a scene from standard input has no name for its picture", "add `-o FILE`");
            }
            None => {
                let extension = format.map_or("png", |f| ImageFormat::from(f).extensions()[0]);
                let mut name = scene.file_stem().unwrap_or(scene.as_os_str()).to_owned();
                name.push(".");
                name.push(extension);
                PathBuf::from(name)
            }
        };
        if path == Path::new("-") {
            return match format {
                None => usage("standard output has no extension to tell the format", "add `--format png`"),
                Some(_) if std::io::stdout().is_terminal() => {
                    usage("standard output is a terminal", "redirect it: `-o - --format png > picture.png`")
                }
                Some(format) => Ok(Output { path: None, format: format.into() }),
            };
        }
        let format = match format {
            Some(format) => format.into(),
            None => ImageFormat::of_path(&path)
                .map_err(|e| Failure::usage(two_lines(ErrorCode::Output, &e.to_string())))?,
        };
        OutputFile::create(&path).map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))?;
        Ok(Output { path: Some(path), format })
    }

    /// The place of one picture of a sequence.
    pub(crate) fn numbered(&self, step: &Step) -> Result<Output, Failure> {
        let path = self.path.as_ref().map(|path| step.path(path));
        if let (Some(path), false) = (&path, *step == Step::Only) {
            OutputFile::create(path)
                .map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))?;
        }
        Ok(Output { path, format: self.format })
    }

    /// Refuses to write over a file that the scene was read from: `cup.obj` may well have a texture `cup.png`.
    pub(crate) fn check_against(&self, scene: &Path, desc: &SceneDesc) -> Result<(), Failure> {
        let Some(own) = self.path.as_ref().and_then(|p| p.canonicalize().ok()) else { return Ok(()) };
        let folder = scene.parent().unwrap_or(Path::new(""));
        let images = desc.images.iter().map(|i| folder.join(&i.uri));
        let mut read =
            images.chain(desc.meshes.iter().map(|m| folder.join(&m.uri))).chain([scene.to_owned()]);
        if read.any(|path| path.canonicalize().is_ok_and(|path| path == own)) {
            let message = format!("{}: the scene is made of this file", own.display());
            return Err(Failure::new(
                SceneError::new(ErrorCode::Output, message).help("name another one with `-o FILE`"),
            ));
        }
        Ok(())
    }

    /// What the picture says about its making: the same for the same scene, on any machine, at any time. `exposure` is
    /// that of its display values, in stops.
    pub(crate) fn metadata(
        &self,
        prepared: &Prepared,
        integrator: &IntegratorDesc,
        hash: &str,
        samples_per_pixel: u32,
        exposure: f64,
    ) -> Metadata {
        let film = &prepared.view.film;
        let settings = format!("film {}; integrator {}", compact(film), compact(integrator));
        let clamp = match integrator {
            IntegratorDesc::Path(path) => Some(path.clamp_indirect).filter(|most| *most > 0.0),
            _ => None,
        };
        // PNG has a keyword of its own for it.
        let software = if self.format == ImageFormat::Png { "Software" } else { "turner:software" };
        [
            (software, format!("Turner {}", env!("CARGO_PKG_VERSION"))),
            ("turner:sceneHash", hash.to_owned()),
            ("turner:seed", film.seed.to_string()),
            ("turner:samples", samples_per_pixel.to_string()),
            ("turner:integrator", integrator.type_name().to_owned()),
            ("turner:settings", settings),
            ("turner:transfer", film.transfer.word().to_owned()),
            ("turner:tonemap", film.tonemap.word().to_owned()),
            ("turner:exposure", format!("{exposure:.4}")),
        ]
        .into_iter()
        .chain(
            prepared
                .path()
                .and_then(|path| path.caustics())
                .map(|plan| ("turner:caustics", plan.to_string())),
        )
        .chain(
            prepared
                .integrator
                .shares_paths()
                .then(|| ("turner:shared-paths", "groups of 16 pixels".to_owned())),
        )
        .chain(clamp.map(|most| ("turner:clampIndirect", most.to_string())))
        .map(|(name, value)| (name.to_owned(), value.as_str().into()))
        .collect()
    }

    /// Checks, before anything is rendered, that the disk has room for a picture of this size.
    pub(crate) fn check_space(&self, width: u32, height: u32) -> Result<(), Failure> {
        let Some(path) = &self.path else { return Ok(()) };
        OutputFile::create(path)
            .and_then(|file| file.check_space(self.format.most_bytes(width, height)))
            .map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))
    }

    /// Whether the picture goes to standard output.
    pub(crate) fn is_stdout(&self) -> bool {
        self.path.is_none()
    }

    /// Its name in messages.
    pub(crate) fn name(&self) -> String {
        self.path.as_ref().map_or("-".into(), |p| p.display().to_string())
    }

    /// Encodes the picture and puts it in its place, whole or not at all. What cannot be put there (a disk that has filled up
    /// meanwhile) is kept in the folder for temporary files, so that hours of work are not lost.
    pub(crate) fn write(
        &self,
        picture: &Picture,
        view: &View,
        metadata: &Metadata,
        threads: usize,
    ) -> Result<(), Failure> {
        let failed = |text: &str| Failure::new(two_lines(ErrorCode::Output, text));
        let options = SaveOptions {
            format: Some(self.format),
            transfer: match view.film.transfer {
                Transfer::Srgb => turner_io::image::Transfer::Srgb,
                Transfer::None => turner_io::image::Transfer::Unstated,
            },
            metadata: metadata.clone(),
            threads,
        };
        let bytes = to_bytes(picture, self.format, &options).map_err(|e| failed(&e.to_string()))?;
        match &self.path {
            Some(path) => OutputFile::create(path).and_then(|file| file.commit(&bytes)).map_err(|e| {
                let failure = failed(&e.to_string());
                match rescue(&bytes, self.format) {
                    Some(kept) => failure.note(format!("the picture was kept as {}", kept.display())),
                    None => failure,
                }
            }),
            None => {
                let mut out = std::io::stdout().lock();
                out.write_all(&bytes)
                    .and_then(|()| out.flush())
                    .map_err(|e| failed(&format!("standard output cannot be written: {e}")))
            }
        }
    }
}

/// Keeps a picture among the temporary files, under a name of its own.
fn rescue(bytes: &[u8], format: ImageFormat) -> Option<PathBuf> {
    let suffix = format!(".{}", format.extensions()[0]);
    let mut file = tempfile::Builder::new().prefix("turner-kept-").suffix(&suffix).tempfile().ok()?;
    file.write_all(bytes).ok()?;
    file.keep().ok().map(|(_, path)| path)
}

/// The fields of plain data as `name=value`: what stands between the outermost braces of its debug form.
fn compact(value: &impl std::fmt::Debug) -> String {
    let text = format!("{value:?}");
    let fields = text.split_once("{ ").map_or(text.as_str(), |(_, rest)| rest);
    fields.trim_end_matches(')').trim_end_matches('}').trim_end().replace(": ", "=")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_that_are_written_can_be_asked_for() {
        let named: Vec<ImageFormat> = FormatArg::value_variants().iter().map(|f| (*f).into()).collect();
        for format in ImageFormat::all() {
            assert_eq!(named.contains(&format), format.can_write(), "--format and {}", format.name());
        }
    }

    #[test]
    fn settings_are_compact() {
        let normals = turner::integrator::IntegratorDesc::Normals(turner::integrator::NormalsDesc {
            normal: turner::integrator::NormalKind::Geometric,
        });
        assert_eq!(compact(&normals), "normal=Geometric");
    }
}
