//! The output file, checked before rendering, and its metadata.

use std::fmt::Display;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use turner::color::Transfer;
use turner::description::SceneDesc;
use turner::film::{DisplayTransform, FilmDesc, Picture};
use turner::integrator::{IntegratorDesc, Prepared};
use turner::render::Renderer;
use turner::schema::{ErrorCode, SceneError, Warning, WarningKind};
use turner_io::image::{ExtraChannel, ImageFormat, Metadata, OutputFile};
use turner_io::{Rounding, Save, SaveError, SaveOptions, to_bytes, write_file};

use crate::aovs;
use crate::camera;
use crate::encoding::{Encoding, EncodingArgs};
use crate::failure::{Failure, two_lines};
use crate::film_picture::FilmPicture;
use crate::header;
use crate::recipe::{self, Recipe};
use crate::sequence::Step;

/// Values of `--format`.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum FormatArg {
    /// 8 or 16 bits per channel, display values
    Png,
    /// Linear floats, scene values
    Exr,
    /// 8 bits per channel, lossy compression
    Jpg,
    /// Linear with a shared exponent (Radiance)
    Hdr,
    /// 8 bits per channel, lossless
    Webp,
}

impl From<FormatArg> for ImageFormat {
    fn from(format: FormatArg) -> ImageFormat {
        match format {
            FormatArg::Png => ImageFormat::Png,
            FormatArg::Exr => ImageFormat::Exr,
            FormatArg::Jpg => ImageFormat::Jpeg,
            FormatArg::Hdr => ImageFormat::Hdr,
            FormatArg::Webp => ImageFormat::WebP,
        }
    }
}

/// An output file that was checked to be writable.
#[derive(Clone, Debug)]
pub(crate) struct Output {
    /// `None` is standard output.
    path: Option<PathBuf>,
    format: ImageFormat,
    encoding: Encoding,
    /// The output is the checkpoint: no picture is written.
    is_part: bool,
    /// The file is removed afterwards: messages do not name it, and it has no checkpoint.
    is_temporary: bool,
}

impl Output {
    /// Checks the path and the format. Creates no file, so that a killed render leaves none behind.
    pub(crate) fn new(
        path: Option<&Path>,
        format: Option<FormatArg>,
        encoding: &EncodingArgs,
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
                Some(format) => {
                    let format = format.into();
                    Ok(Output {
                        path: None,
                        format,
                        encoding: encoding.check(format)?,
                        is_part: false,
                        is_temporary: false,
                    })
                }
            };
        }
        let format = match format {
            Some(format) => format.into(),
            None => ImageFormat::of_path(&path)
                .map_err(|e| Failure::usage(two_lines(ErrorCode::Output, &e.to_string())))?,
        };
        let encoding = encoding.check(format)?;
        OutputFile::create(&path).map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))?;
        Ok(Output { path: Some(path), format, encoding, is_part: false, is_temporary: false })
    }

    /// A checkpoint instead of a picture.
    pub(crate) fn part(path: &Path) -> Result<Output, Failure> {
        OutputFile::create(path).map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))?;
        Ok(Output {
            path: Some(path.to_owned()),
            format: ImageFormat::Png,
            encoding: Encoding::default(),
            is_part: true,
            is_temporary: false,
        })
    }

    /// The same for a file that is removed afterwards.
    pub(crate) fn temporary(self) -> Output {
        Output { is_temporary: true, ..self }
    }

    /// The output file of one picture of a sequence.
    pub(crate) fn numbered(&self, step: &Step) -> Result<Output, Failure> {
        let path = self.path.as_ref().map(|path| step.path(path));
        if let (Some(path), false) = (&path, *step == Step::Only) {
            OutputFile::create(path)
                .map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))?;
        }
        Ok(Output { path, ..*self })
    }

    /// Refuses to overwrite a file that the scene reads, and AOVs on standard output that the format cannot hold.
    pub(crate) fn check_against(&self, scene: &Path, desc: &SceneDesc) -> Result<(), Failure> {
        if self.path.is_none() && !desc.film.aovs.is_empty() && self.format != ImageFormat::Exr {
            let message = "the picture on standard output cannot hold AOVs";
            let help = "write EXR, which can: `--format exr`";
            return Err(Failure::usage(SceneError::new(ErrorCode::Output, message).help(help)));
        }
        let beside = self.aov_path(&desc.film);
        if let Some(beside) = &beside {
            OutputFile::create(beside)
                .map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))?;
        }
        for own in self.path.iter().chain(&beside) {
            refuse_input(own, scene, desc)?;
        }
        Ok(())
    }

    /// The EXR file next to a picture in another format, if the film has AOVs.
    pub(crate) fn aov_path(&self, film: &FilmDesc) -> Option<PathBuf> {
        let beside = !film.aovs.is_empty() && self.format != ImageFormat::Exr && !self.is_part;
        let path = self.path.as_ref().filter(|_| beside)?;
        let other = path.with_extension("exr");
        Some(if other == *path { path.with_extension("aovs.exr") } else { other })
    }

    /// Refuses options that do not suit the film.
    pub(crate) fn check_film(&self, film: &FilmDesc) -> Result<(), Failure> {
        self.encoding.check_transfer(film.transfer)
    }

    /// The metadata of the picture: equal for the same scene on every machine. `shown` is the transform of the display
    /// values.
    pub(crate) fn metadata(
        &self,
        prepared: &Prepared,
        integrator: &IntegratorDesc,
        hash: &str,
        samples_per_pixel: u32,
        shown: &DisplayTransform,
        recipe: &Recipe,
    ) -> Metadata {
        let film = &prepared.view.film;
        let clamp = match integrator {
            IntegratorDesc::Path(path) => Some(path.clamp_indirect).filter(|most| *most > 0.0),
            _ => None,
        };
        // PNG has its own keyword.
        let software = if self.format == ImageFormat::Png { "Software" } else { "turner:software" };
        [
            (software, format!("Turner {}", env!("CARGO_PKG_VERSION"))),
            (recipe::SCENE_HASH, hash.to_owned()),
            ("turner:seed", film.seed.to_string()),
            ("turner:samples", samples_per_pixel.to_string()),
            (recipe::CAMERA, camera::json(&prepared.view).to_string()),
        ]
        .into_iter()
        .chain(recipe.entries())
        .chain(recipe::settings(prepared, integrator))
        .chain(header::entries(shown))
        .chain(
            prepared
                .path()
                .and_then(|path| path.caustics())
                .map(|plan| ("turner:caustics", plan.to_string())),
        )
        .chain(
            prepared.integrator.shares_paths().then(|| {
                ("turner:sharedPaths", format!("clusters of {} pixels", prepared.integrator.cluster()))
            }),
        )
        .chain(
            prepared
                .path()
                .map(|path| path.light_samples())
                .filter(|number| *number != 1)
                .map(|number| ("turner:lightSamples", number.to_string())),
        )
        .chain(clamp.map(|most| ("turner:clampIndirect", most.to_string())))
        .chain(film.removes_fireflies().then(|| ("turner:fireflies", "removed".to_owned())))
        .map(|(name, value)| (name.to_owned(), value.as_str().into()))
        .collect()
    }

    /// Checks before rendering that the disk has space for a picture of this size.
    pub(crate) fn check_space(&self, width: u32, height: u32) -> Result<(), Failure> {
        let Some(path) = self.path.as_ref().filter(|_| !self.is_part) else { return Ok(()) };
        let deep = if self.encoding.rounding == Rounding::SixteenBits { 2 } else { 1 };
        let most = self.format.most_bytes(width, height).saturating_mul(deep);
        OutputFile::create(path)
            .and_then(|file| file.check_space(most))
            .map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))
    }

    /// Whether the picture goes to standard output.
    pub(crate) fn is_stdout(&self) -> bool {
        self.path.is_none()
    }

    /// Whether the output is a checkpoint and no picture is written.
    pub(crate) fn is_part(&self) -> bool {
        self.is_part
    }

    /// The file, unless the output is standard output, a device, or temporary.
    pub(crate) fn file(&self) -> Option<&Path> {
        let path = self.path.as_deref().filter(|_| !self.is_temporary)?;
        path.metadata().map_or(true, |meta| meta.is_file()).then_some(path)
    }

    /// The picture as a checkpoint records it: its path and the extension of its format. `None` without a file, or if
    /// the path is not UTF-8.
    pub(crate) fn recorded(&self) -> Option<turner_io::checkpoint::Output> {
        let path = self.file().filter(|_| !self.is_part)?.to_str()?.to_owned();
        Some(turner_io::checkpoint::Output { path, format: self.format.extensions()[0].to_owned() })
    }

    /// The text metadata of the existing file, if it has this output's format.
    pub(crate) fn existing_metadata(&self) -> Option<Metadata> {
        let path = self.file().filter(|_| !self.is_part)?;
        turner_io::image::read_metadata(&std::fs::read(path).ok()?, &self.name()).ok()
    }

    /// Its name in messages.
    pub(crate) fn name(&self) -> String {
        if self.is_temporary {
            return "temporary file".to_owned();
        }
        self.path.as_ref().map_or("-".into(), |p| p.display().to_string())
    }

    /// What the file does not hold of the picture.
    pub(crate) fn remarks(&self, picture: &FilmPicture<'_>) -> Vec<Warning> {
        let mut remarks = Vec::new();
        let mut remark = |kind, message: String| remarks.push(Warning::new(kind, message));
        if picture.samples().has_alpha() && matches!(self.format, ImageFormat::Jpeg | ImageFormat::Hdr) {
            let format = self.format.name();
            remark(
                WarningKind::Note,
                format!("{format} stores no transparency: use PNG, WebP or EXR to keep the alpha channel"),
            );
        }
        if self.encoding.is_special() && picture.has_custom_display() {
            let message = "--bit-depth, --dither and --display-space are ignored: this debug view shows values as \
                           8-bit colours; EXR files keep the values";
            remark(WarningKind::Ignored, message.to_owned());
        }
        remarks
    }

    /// Encodes the picture and writes the file atomically, with the AOVs if it is an EXR file; else they go to one
    /// beside it. If that fails, e.g. because the disk is full, the picture is kept in the folder for temporary files.
    pub(crate) fn write(
        &self,
        picture: &FilmPicture<'_>,
        renderer: &Renderer,
        metadata: &Metadata,
        threads: usize,
    ) -> Result<(), Failure> {
        let film = &renderer.prepared().view.film;
        let is_plain = !self.encoding.is_special() || picture.has_custom_display();
        let options = |format, holds: bool| {
            let channels = if holds { aovs::channels(renderer, threads) } else { Vec::new() };
            let transform = Some(picture.transform()).filter(|_| !is_plain);
            self.options(format, renderer, channels, metadata, threads, transform)
        };
        let own = options(self.format, self.format == ImageFormat::Exr);
        match &self.path {
            Some(path) => commit(path, self.format, picture.samples(), &own)?,
            None => {
                let mut out = std::io::stdout().lock();
                let bytes = to_bytes(picture.samples(), self.format, &own).map_err(failed)?;
                out.write_all(&bytes).and_then(|()| out.flush()).map_err(|e| {
                    let message = format!("cannot write to standard output: {e}");
                    Failure::new(two_lines(ErrorCode::Output, &message))
                })?;
            }
        }
        let Some(beside) = self.aov_path(film) else { return Ok(()) };
        let format = ImageFormat::Exr;
        commit(&beside, format, picture.samples(), &options(format, true))
    }

    /// How a file of a format is encoded; `channels` are those of an EXR file, `transform` that of display values with
    /// special options.
    fn options<'a>(
        &self,
        format: ImageFormat,
        renderer: &Renderer,
        channels: Vec<ExtraChannel<'a>>,
        metadata: &Metadata,
        threads: usize,
        transform: Option<DisplayTransform>,
    ) -> SaveOptions<'a> {
        let film = &renderer.prepared().view.film;
        let is_exr = format == ImageFormat::Exr;
        SaveOptions {
            format: Some(format),
            transfer: match film.transfer {
                Transfer::Srgb if !is_exr => turner_io::image::Transfer::Srgb,
                Transfer::Srgb | Transfer::None => turner_io::image::Transfer::Unstated,
            },
            display: transform.filter(|_| !is_exr).map(|transform| self.encoding.display(transform)),
            metadata: if is_exr { aovs::metadata(renderer, metadata) } else { metadata.clone() },
            channels,
            exr: self.encoding.exr,
            threads,
        }
    }

    /// The size in bytes of the files that a picture like this becomes, with these channels. Nothing is written.
    pub(crate) fn encoded_size(
        &self,
        picture: &Picture,
        renderer: &Renderer,
        channels: Vec<ExtraChannel<'_>>,
        threads: usize,
    ) -> usize {
        let transform = picture.transform(&renderer.prepared().view.film);
        let transform = Some(transform).filter(|_| self.encoding.is_special());
        let size = |format, channels| {
            let options = self.options(format, renderer, channels, &Metadata::new(), threads, transform);
            to_bytes(picture, format, &options).map_or(0, |bytes| bytes.len())
        };
        if self.format == ImageFormat::Exr || channels.is_empty() {
            return size(self.format, channels);
        }
        size(self.format, Vec::new()) + size(ImageFormat::Exr, channels)
    }
}

/// Writes a file atomically. If that fails, the picture is kept in the folder for temporary files.
fn commit(
    path: &Path,
    format: ImageFormat,
    picture: &dyn Save,
    options: &SaveOptions<'_>,
) -> Result<(), Failure> {
    let file = OutputFile::create(path).map_err(SaveError::Output);
    file.and_then(|file| write_file(file, picture, format, options)).map_err(|error| {
        let is_refused = matches!(error, SaveError::Image(_));
        let failure = failed(error);
        match rescue(format, picture, options).filter(|_| !is_refused) {
            Some(kept) => failure.note(format!("the picture was kept as {}", kept.display())),
            None => failure,
        }
    })
}

fn failed(error: impl Display) -> Failure {
    Failure::new(two_lines(ErrorCode::Output, &error.to_string()))
}

/// Refuses to overwrite a file that the scene reads: `cup.obj` may have a texture `cup.png`.
fn refuse_input(path: &Path, scene: &Path, desc: &SceneDesc) -> Result<(), Failure> {
    let Ok(own) = path.canonicalize() else { return Ok(()) };
    let folder = scene.parent().unwrap_or(Path::new(""));
    let images = desc.images.iter().map(|i| folder.join(&i.uri));
    let mut read = images.chain(desc.meshes.iter().map(|m| folder.join(&m.uri))).chain([scene.to_owned()]);
    if read.any(|path| path.canonicalize().is_ok_and(|path| path == own)) {
        let message = format!("{}: the scene reads this file", own.display());
        return Err(Failure::new(
            SceneError::new(ErrorCode::Output, message).help("name another output file with `-o FILE`"),
        ));
    }
    Ok(())
}

/// Keeps a picture as a temporary file with a unique name.
fn rescue(format: ImageFormat, picture: &dyn Save, options: &SaveOptions<'_>) -> Option<PathBuf> {
    let suffix = format!(".{}", format.extensions()[0]);
    let file = tempfile::Builder::new().prefix("turner-kept-").suffix(&suffix).tempfile().ok()?;
    let (_, path) = file.keep().ok()?;
    let written = OutputFile::create(&path).map_err(SaveError::Output);
    match written.and_then(|own| write_file(own, picture, format, options)) {
        Ok(()) => Some(path),
        Err(_) => {
            // An empty file says nothing.
            let _ = std::fs::remove_file(&path);
            None
        }
    }
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
}
