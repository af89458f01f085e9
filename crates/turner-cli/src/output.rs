//! The output file, checked before rendering, and its metadata.

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

/// Values of `--format`.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum FormatArg {
    /// 8 bits per channel, display values
    Png,
    /// Linear 32-bit floats, scene values
    Exr,
    /// 8 bits per channel, lossy compression
    Jpg,
    /// Linear with a shared exponent (Radiance)
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

/// An output file that was checked to be writable.
#[derive(Debug)]
pub(crate) struct Output {
    /// `None` is standard output.
    path: Option<PathBuf>,
    format: ImageFormat,
}

impl Output {
    /// Checks the path and the format. Creates no file, so that a killed render leaves none behind.
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
                return usage("a scene from standard input has no name for the output file", "add `-o FILE`");
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
                None => usage("the format of standard output is unknown", "add `--format png`"),
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

    /// The output file of one picture of a sequence.
    pub(crate) fn numbered(&self, step: &Step) -> Result<Output, Failure> {
        let path = self.path.as_ref().map(|path| step.path(path));
        if let (Some(path), false) = (&path, *step == Step::Only) {
            OutputFile::create(path)
                .map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))?;
        }
        Ok(Output { path, format: self.format })
    }

    /// Refuses to overwrite a file that the scene reads: `cup.obj` may have a texture `cup.png`.
    pub(crate) fn check_against(&self, scene: &Path, desc: &SceneDesc) -> Result<(), Failure> {
        let Some(own) = self.path.as_ref().and_then(|p| p.canonicalize().ok()) else { return Ok(()) };
        let folder = scene.parent().unwrap_or(Path::new(""));
        let images = desc.images.iter().map(|i| folder.join(&i.uri));
        let mut read =
            images.chain(desc.meshes.iter().map(|m| folder.join(&m.uri))).chain([scene.to_owned()]);
        if read.any(|path| path.canonicalize().is_ok_and(|path| path == own)) {
            let message = format!("{}: the scene reads this file", own.display());
            return Err(Failure::new(
                SceneError::new(ErrorCode::Output, message).help("name another output file with `-o FILE`"),
            ));
        }
        Ok(())
    }

    /// The metadata of the picture: equal for the same scene on every machine. `exposure` is that of the display
    /// values, in stops.
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
        // PNG has its own keyword.
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
                .then(|| ("turner:sharedPaths", "groups of 16 pixels".to_owned())),
        )
        .chain(clamp.map(|most| ("turner:clampIndirect", most.to_string())))
        .map(|(name, value)| (name.to_owned(), value.as_str().into()))
        .collect()
    }

    /// Checks before rendering that the disk has space for a picture of this size.
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

    /// Encodes the picture and writes the file atomically. If that fails, e.g. because the disk is full, the picture is
    /// kept in the folder for temporary files.
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
                    .map_err(|e| failed(&format!("cannot write to standard output: {e}")))
            }
        }
    }
}

/// Keeps a picture as a temporary file with a unique name.
fn rescue(bytes: &[u8], format: ImageFormat) -> Option<PathBuf> {
    let suffix = format!(".{}", format.extensions()[0]);
    let mut file = tempfile::Builder::new().prefix("turner-kept-").suffix(&suffix).tempfile().ok()?;
    file.write_all(bytes).ok()?;
    file.keep().ok().map(|(_, path)| path)
}

/// The fields of plain data as `name=value`, from its debug form.
fn compact(value: &impl std::fmt::Debug) -> String {
    let text = format!("{value:?}");
    let fields = text.split_once("{ ").map_or(text.as_str(), |(_, rest)| rest);
    fields.trim_end_matches(')').trim_end_matches('}').trim_end().replace(": ", "=")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_writable_format_has_a_value() {
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
