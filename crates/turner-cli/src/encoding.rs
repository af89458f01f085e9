//! Options of picture files: bits per channel, dither, colour space, compression.

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Args, ValueEnum};
use turner::color::{DisplaySpace, Transfer};
use turner::film::DisplayTransform;
use turner::schema::{ErrorCode, SceneError};
use turner_io::image::{ExrCompression, ExrOptions, ImageFormat};
use turner_io::{DisplayOptions, Rounding};

use crate::failure::Failure;
use crate::scene::words;

/// Options for the file of a picture.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct EncodingArgs {
    #[command(flatten)]
    display: DisplayArgs,
    /// Compression of an EXR file [default: zip]
    #[arg(long, value_name = "NAME")]
    exr_compression: Option<CompressionArg>,
}

/// Options for display values.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct DisplayArgs {
    /// Bits per channel [default: 8; 16 for rec2100-pq; 32 for EXR]
    #[arg(long, value_name = "BITS", value_parser = depths())]
    bit_depth: Option<String>,
    /// Dither 8-bit values by up to half a step, so that smooth gradients have no bands
    #[arg(long)]
    dither: bool,
    /// Colour space of a PNG
    #[arg(long, value_name = "NAME", value_parser = words(DisplaySpace::DOCS))]
    display_space: Option<String>,
}

fn depths() -> PossibleValuesParser {
    PossibleValuesParser::new([
        PossibleValue::new("8").help("PNG, JPEG, WebP: 256 values per channel"),
        PossibleValue::new("16")
            .help("PNG: 65536 values per channel. EXR: half floats, with 11 significant bits"),
        PossibleValue::new("32").help("EXR: floats with 24 significant bits, as Turner computes them"),
    ])
}

/// Values of `--exr-compression`.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum CompressionArg {
    /// Fastest to read and write
    None,
    /// Deflate of 16 rows at a time; read by every program
    Zip,
    /// Wavelets; smaller for noisy pictures in half floats
    Piz,
}

/// How a picture is encoded: options that suit the format.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Encoding {
    pub(crate) exr: ExrOptions,
    pub(crate) space: DisplaySpace,
    pub(crate) rounding: Rounding,
}

/// The error of an option that does not suit the format.
fn refused(option: &str, format: ImageFormat, help: &str) -> Result<Encoding, Failure> {
    let message = format!("{option} does not apply to {}", format.name());
    Err(Failure::usage(SceneError::new(ErrorCode::Output, message).help(help)))
}

impl EncodingArgs {
    /// The options as words of a command.
    pub(crate) fn words(&self) -> Vec<String> {
        let mut words = self.display.words();
        let name = self.exr_compression.as_ref().and_then(ValueEnum::to_possible_value);
        words.extend(name.map(|name| format!("--exr-compression={}", name.get_name())));
        words
    }

    /// Checks that the options suit the format.
    pub(crate) fn check(&self, format: ImageFormat) -> Result<Encoding, Failure> {
        let mut encoding = self.display.check(format)?;
        if self.exr_compression.is_some() && format != ImageFormat::Exr {
            return refused("--exr-compression", format, "omit it, or write an EXR file");
        }
        encoding.exr.compression = match self.exr_compression {
            Some(CompressionArg::None) => ExrCompression::None,
            Some(CompressionArg::Zip) | None => ExrCompression::Zip,
            Some(CompressionArg::Piz) => ExrCompression::Piz,
        };
        Ok(encoding)
    }
}

impl DisplayArgs {
    /// The options as words of a command.
    pub(crate) fn words(&self) -> Vec<String> {
        let value = |option: &str, value: &Option<String>| value.as_ref().map(|v| format!("{option}={v}"));
        let depth = value("--bit-depth", &self.bit_depth);
        let space = value("--display-space", &self.display_space);
        depth.into_iter().chain(self.dither.then(|| "--dither".to_owned())).chain(space).collect()
    }

    /// Checks that the options suit the format.
    pub(crate) fn check(&self, format: ImageFormat) -> Result<Encoding, Failure> {
        let refused = |option: &str, help: &str| refused(option, format, help);
        let is_exr = format == ImageFormat::Exr;
        let space = self.display_space.as_deref().and_then(DisplaySpace::from_word).unwrap_or_default();
        if space != DisplaySpace::Srgb && format != ImageFormat::Png {
            let help = "write a PNG; EXR and HDR files keep scene values, and JPEG and WebP are sRGB";
            return refused(&format!("--display-space {}", space.word()), help);
        }
        let bits = self.bit_depth.as_deref();
        let valid: &[&str] = match format {
            ImageFormat::Png => &["8", "16"],
            ImageFormat::Exr => &["16", "32"],
            ImageFormat::Hdr => &[],
            _ => &["8"],
        };
        if let Some(bits) = bits.filter(|bits| !valid.contains(bits)) {
            let help = match valid {
                [] => "omit it: HDR files have 8 bits and a shared exponent".to_owned(),
                _ => format!("use {} for {}", valid.join(" or "), format.name()),
            };
            return refused(&format!("--bit-depth {bits}"), &help);
        }
        let sixteen = bits.map_or(space == DisplaySpace::Rec2100Pq, |bits| bits == "16");
        if self.dither && (sixteen || matches!(format, ImageFormat::Exr | ImageFormat::Hdr)) {
            let what = if sixteen { "--dither with 16 bits" } else { "--dither" };
            return refused(what, "it is for display values of 8 bits");
        }
        let rounding = match (sixteen, self.dither) {
            (true, _) => Rounding::SixteenBits,
            (false, true) => Rounding::Dithered,
            (false, false) => Rounding::EightBits,
        };
        let exr = ExrOptions { half: is_exr && bits == Some("16"), ..ExrOptions::default() };
        Ok(Encoding { exr, space, rounding })
    }
}

impl Encoding {
    /// The display values of a picture, given how its linear values are shown.
    pub(crate) fn display(&self, transform: DisplayTransform) -> DisplayOptions {
        let transform = DisplayTransform { space: self.space, ..transform };
        DisplayOptions { transform, rounding: self.rounding }
    }

    /// Whether display values differ from those of 8-bit sRGB.
    pub(crate) fn is_special(&self) -> bool {
        self.space != DisplaySpace::Srgb || self.rounding != Rounding::EightBits
    }

    /// Refuses a colour space for values that are display values already.
    pub(crate) fn check_transfer(&self, transfer: Transfer) -> Result<(), Failure> {
        if self.space == DisplaySpace::Srgb || transfer != Transfer::None {
            return Ok(());
        }
        let message = format!(
            "--display-space {} needs linear scene values, but the film has transfer = \"none\"",
            self.space.word()
        );
        let help = "add `-D film.transfer=srgb`, or omit --display-space";
        Err(Failure::usage(SceneError::new(ErrorCode::Output, message).help(help)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn args(bits: Option<&str>, dither: bool, space: Option<&str>) -> DisplayArgs {
        DisplayArgs { bit_depth: bits.map(str::to_owned), dither, display_space: space.map(str::to_owned) }
    }

    #[test]
    fn options_suit_formats() {
        use ImageFormat::{Exr, Hdr, Jpeg, Png, WebP};
        for (args, good, bad) in [
            (args(Some("16"), false, None), &[Png, Exr][..], &[Jpeg, WebP, Hdr][..]),
            (args(Some("32"), false, None), &[Exr], &[Png, Jpeg, Hdr]),
            (args(Some("8"), true, None), &[Png, Jpeg, WebP], &[Exr, Hdr]),
            (args(Some("16"), true, None), &[], &[Png, Exr]),
            (args(None, true, Some("rec2100-pq")), &[], &[Png]),
            (args(Some("8"), true, Some("rec2100-pq")), &[Png], &[Jpeg]),
            (args(None, false, Some("display-p3")), &[Png], &[Jpeg, WebP, Exr, Hdr]),
            (args(None, false, Some("srgb")), &[Png, Jpeg, Exr, Hdr], &[]),
        ] {
            assert!(good.iter().all(|f| args.check(*f).is_ok()), "{args:?}");
            assert!(bad.iter().all(|f| args.check(*f).is_err()), "{args:?}");
        }
        let rounding = |a: DisplayArgs| a.check(Png).unwrap().rounding;
        assert_eq!(rounding(args(None, false, None)), Rounding::EightBits);
        assert_eq!(rounding(args(None, false, Some("rec2100-pq"))), Rounding::SixteenBits);
        assert!(args(Some("16"), false, None).check(Exr).unwrap().exr.half);
    }
}
