//! `turner tonemap`: a picture with display values from one with scene values.

use std::path::PathBuf;

use clap::Args;
use turner::color::{Tonemap, Transfer};
use turner::film::{DisplayTransform, auto_exposure};
use turner::schema::error::escape;
use turner::schema::{ErrorCode, SceneError, Warning, WarningKind};
use turner_io::image::{ImageFormat, Metadata, OutputFile};
use turner_io::{SaveOptions, write_file};

use crate::encoding::{DisplayArgs, Encoding};
use crate::failure::{Failure, two_lines};
use crate::header::{self, Shown};
use crate::picture_file::{Linear, PictureFile};
use crate::recipe;
use crate::report::Reporter;
use crate::scene::words;

/// Make a PNG, JPEG or WebP from an EXR, HDR or PFM file: exposure, tone mapping, transfer curve
#[derive(Debug, Args)]
#[command(
    after_help = "Without options the picture is shown as it was rendered: Turner's EXR files hold exposure,\n\
                  tone mapping and transfer curve, and the result has the pixels of the PNG of the same render.\n\
                  Files of other programs are shown without exposure and tone mapping, with the sRGB curve."
)]
pub(crate) struct TonemapArgs {
    /// Picture with scene values: .exr, .hdr or .pfm
    input: PathBuf,
    /// Picture to write: .png, .jpg or .webp
    output: PathBuf,
    /// Exposure in stops: 1 doubles the brightness, -1 halves it [default: as rendered, or 0]
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true, value_parser = stops)]
    exposure: Option<f64>,
    /// Choose the exposure from the picture; --exposure is added to it
    #[arg(long)]
    auto_exposure: bool,
    /// Tone mapping operator [default: as rendered, or none]
    #[arg(long, value_name = "NAME", value_parser = words(Tonemap::DOCS))]
    tonemap: Option<String>,
    /// Curve from linear values to display values [default: as rendered, or srgb]
    #[arg(long, value_name = "NAME", value_parser = words(Transfer::DOCS))]
    transfer: Option<String>,
    /// Layer of an EXR file, such as `albedo` [default: the picture]
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    #[command(flatten)]
    display: DisplayArgs,
    /// Print errors only
    #[arg(long)]
    quiet: bool,
}

impl TonemapArgs {
    /// The options of a render that makes the picture at once, as JSON, given those of the EXR file. `None`: there is
    /// no such render.
    fn command(&self, recorded: &str) -> Option<String> {
        let is_same = self.exposure.is_none() && !self.auto_exposure && self.layer.is_none();
        let mut words: Vec<String> = serde_json::from_str(recorded)
            .ok()
            .filter(|_| is_same && self.tonemap.is_none() && self.transfer.is_none())?;
        words.retain(|word| !recipe::ENCODING.contains(&recipe::option(word)));
        words.extend(self.display.words());
        words.sort_by(|a, b| recipe::option(a).cmp(recipe::option(b)));
        Some(serde_json::json!(words).to_string())
    }
}

/// The range of the film's `exposure`.
fn stops(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if (-64.0..=64.0).contains(&v) => Ok(v),
        _ => Err("expected a number of stops from -64 to 64".to_owned()),
    }
}

/// Runs the command.
pub(crate) fn run(args: &TonemapArgs) -> u8 {
    let reporter = Reporter { quiet: args.quiet, events: None };
    match convert(args) {
        Ok((line, warnings)) => {
            reporter.warnings(&warnings, &Default::default(), &Default::default());
            reporter.line(&line);
            0
        }
        Err(failure) => {
            reporter.failure(&failure);
            failure.exit
        }
    }
}

/// The output, checked before anything is decoded.
fn target(args: &TonemapArgs) -> Result<(OutputFile, ImageFormat, Encoding), Failure> {
    let path = &args.output;
    let usage = |error: SceneError| Err(Failure::usage(error));
    let format = match ImageFormat::of_path(path) {
        Ok(format) => format,
        Err(e) => return usage(two_lines(ErrorCode::Output, &e.to_string())),
    };
    if matches!(format, ImageFormat::Exr | ImageFormat::Hdr) {
        let name = escape(&path.to_string_lossy());
        let message = format!("{name}: {} holds scene values", format.name());
        return usage(SceneError::new(ErrorCode::Output, message).help("write a .png, .jpg or .webp file"));
    }
    let encoding = args.display.check(format)?;
    if let (Ok(a), Ok(b)) = (path.canonicalize(), args.input.canonicalize())
        && a == b
    {
        let message = format!("{}: is the input", escape(&path.to_string_lossy()));
        return usage(SceneError::new(ErrorCode::Output, message).help("name another file"));
    }
    let file = OutputFile::create(path).map_err(|e| output_failed(&e.to_string()))?;
    Ok((file, format, encoding))
}

fn output_failed(text: &str) -> Failure {
    Failure::new(two_lines(ErrorCode::Output, text))
}

/// The closing line and the warnings.
fn convert(args: &TonemapArgs) -> Result<(String, Vec<Warning>), Failure> {
    let (file, format, encoding) = target(args)?;
    let input = PictureFile::read(&args.input)?;
    let (image, associated) = input.image(args.layer.as_deref())?;
    let name = escape(&input.name);
    if image.is_display_encoded() {
        let message = format!("{name}: {} holds display values", input.format.name());
        let help = "name a picture with scene values: an EXR, HDR or PFM file";
        return Err(Failure::new(SceneError::new(ErrorCode::Image, message).help(help)));
    }
    let metadata = input.metadata()?;
    let shown = Shown::read(&metadata);
    let linear = Linear::new(&image, associated);
    let mut transform = shown.transform();
    if args.auto_exposure {
        transform.exposure = auto_exposure(&linear.pixels) + args.exposure.unwrap_or(0.0);
    } else if let Some(exposure) = args.exposure {
        transform.exposure = exposure;
    }
    let tonemap = args.tonemap.as_deref().and_then(Tonemap::from_word);
    let transfer = args.transfer.as_deref().and_then(Transfer::from_word);
    transform.tonemap = tonemap.unwrap_or(transform.tonemap);
    transform.transfer = transfer.unwrap_or(transform.transfer);
    encoding.check_transfer(transform.transfer)?;

    let options = SaveOptions {
        display: Some(encoding.display(transform)),
        metadata: carried(args, metadata, format, &transform),
        ..SaveOptions::default()
    };
    write_file(file, &linear, format, &options).map_err(|e| output_failed(&e.to_string()))?;
    let line = format!(
        "{}: {}x{}, exposure {}, tonemap {}, {}",
        escape(&args.output.to_string_lossy()),
        linear.width,
        linear.height,
        rounded(transform.exposure),
        transform.tonemap.word(),
        if transform.transfer == Transfer::None { "transfer none" } else { encoding.space.word() },
    );
    Ok((line, warnings(&shown, &linear, format, &name)))
}

/// At most four decimals.
fn rounded(v: f64) -> String {
    let text = format!("{v:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn warnings(shown: &Shown, linear: &Linear, format: ImageFormat, name: &str) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let views = ["depth", "position", "uv", "ids", "cost"];
    if let Some(view) = shown.integrator.as_deref().filter(|i| views.contains(i)) {
        let message = format!(
            "{name}: the debug view \"{view}\" holds values, not colours: render it as PNG to see its colours"
        );
        warnings.push(Warning::new(WarningKind::Doubtful, message));
    }
    if linear.has_alpha && format == ImageFormat::Jpeg {
        let message = "JPEG stores no transparency: use PNG or WebP to keep the alpha channel".to_owned();
        warnings.push(Warning::new(WarningKind::Note, message));
    }
    warnings
}

/// The metadata of Turner's own pictures, with the transform of the new one.
fn carried(
    args: &TonemapArgs,
    metadata: Metadata,
    format: ImageFormat,
    transform: &DisplayTransform,
) -> Metadata {
    const SOFTWARE: &str = "turner:software";
    let mut kept: Metadata =
        metadata.into_iter().filter(|(key, _)| key.starts_with("turner:") && key.len() < 80).collect();
    let command = kept.remove(recipe::COMMAND).and_then(|command| args.command(&command.to_string()));
    if let Some(command) = command {
        kept.insert(recipe::COMMAND.to_owned(), command.as_str().into());
    }
    let software = kept.remove(SOFTWARE);
    let own = || format!("Turner {}", env!("CARGO_PKG_VERSION")).as_str().into();
    let key = if format == ImageFormat::Png { "Software" } else { SOFTWARE };
    kept.insert(key.to_owned(), software.unwrap_or_else(own));
    for (key, value) in header::entries(transform) {
        kept.insert(key.to_owned(), value.as_str().into());
    }
    kept
}
