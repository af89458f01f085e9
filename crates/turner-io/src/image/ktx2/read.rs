//! From a container to a picture.

use super::container::{Container, Shown, Supercompression};
use super::fault::{Fault, Outcome, list};
use super::plain::Plain;
use super::samples::{Arrangement, Samples, View};
use super::{etc1s, level, uastc};

/// Colour models (Khronos Data Format Specification §5.6).
const ETC1S: u8 = 163;
const UASTC: u8 = 166;
/// Transfer functions (§5.8).
const LINEAR: u8 = 1;
/// Channels of ETC1S and UASTC (§5.6.11, §5.6.14).
const ETC1S_RRR: u8 = 3;
const ETC1S_GGG: u8 = 4;
const UASTC_RGB: u8 = 0;
const UASTC_RGBA: u8 = 3;
const UASTC_RRR: u8 = 4;
const UASTC_RRRG: u8 = 5;
const UASTC_RG: u8 = 6;

/// What is read.
const EXPECTED: &str = "Basis Universal (ETC1S or UASTC LDR 4x4) or uncompressed samples of 8, 16 or 32 bits";

/// How the pixels are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coding {
    /// Blocks of ETC1S; whether there is a second slice.
    Etc1s(bool),
    /// Blocks of UASTC LDR 4x4.
    Uastc,
    /// Uncompressed samples.
    Plain(Plain),
}

impl Coding {
    /// The coding of a file, or why it is not read.
    pub(super) fn of(container: &Container<'_>) -> Outcome<Coding> {
        let is_basis_lz = container.supercompression == Supercompression::BasisLz;
        let coding = match (container.format, container.descriptor.model) {
            (0, ETC1S) if is_basis_lz => Coding::Etc1s(container.descriptor.channels.1.is_some()),
            (0, ETC1S) => return Err(Fault::damaged("ETC1S without BasisLZ")),
            (0, UASTC) => Coding::Uastc,
            (format, model) => match Plain::of(format) {
                Some(plain) => Coding::Plain(plain),
                None => return Err(Fault::unsupported(named(format, model), EXPECTED)),
            },
        };
        if is_basis_lz && !matches!(coding, Coding::Etc1s(_)) {
            return Err(Fault::damaged("BasisLZ with a format other than ETC1S"));
        }
        Ok(coding)
    }

    /// Bytes per pixel while the file is decoded: what is decompressed, the decoder's samples and the picture's.
    pub(super) fn working_bytes(self, supercompression: Supercompression) -> u64 {
        let is_packed = supercompression != Supercompression::None;
        match self {
            Coding::Etc1s(_) => 8,
            Coding::Uastc => 8 + u64::from(is_packed),
            Coding::Plain(plain) => {
                let decompressed = if is_packed { plain.pixel_bytes() } else { 0 };
                (decompressed + 2 * plain.decoded_bytes()) as u64
            }
        }
    }

    /// Most pixels per byte of a file without supercompression; `u64::MAX` if a few bytes can hold any number.
    pub(super) fn pixels_per_byte(self, supercompression: Supercompression) -> u64 {
        match (supercompression, self) {
            (Supercompression::None, _) => 1,
            _ => u64::MAX,
        }
    }
}

/// The name of a format that is not read.
fn named(format: u32, model: u8) -> String {
    match (format, model) {
        (0, 167) => "UASTC HDR texels".to_owned(),
        (0, 168..=170) => "Basis Universal texels of a newer codec".to_owned(),
        (0, _) => format!("texels of colour model {model}"),
        (131..=146, _) => "BC (S3TC, RGTC or BPTC) texels".to_owned(),
        (147..=156, _) => "ETC2 or EAC texels".to_owned(),
        (157..=184 | 1_000_066_000..=1_000_066_013, _) => "ASTC texels".to_owned(),
        _ => format!("texels of Vulkan's format {format}"),
    }
}

/// A picture.
pub(super) struct Picture {
    pub(super) channels: u8,
    pub(super) samples: Samples,
}

/// Whether the file says that its 8- and 16-bit samples are linear.
pub(super) fn is_linear(container: &Container<'_>, coding: Coding) -> bool {
    let is_srgb = matches!(coding, Coding::Plain(plain) if plain.is_srgb);
    container.descriptor.transfer == LINEAR && !is_srgb
}

/// A size in memory; `usize::MAX`, for which there is no memory, if it is larger.
fn product(a: usize, b: usize, c: usize) -> usize {
    a.saturating_mul(b).saturating_mul(c)
}

/// Decodes level 0, layer 0. `width` and `height` have passed the limits.
pub(super) fn picture(container: &Container<'_>, coding: Coding) -> Outcome<Picture> {
    let (width, height) = (container.width as usize, container.height as usize);
    let (samples, stored) = match coding {
        Coding::Plain(plain) => {
            let bytes = level::bytes_of(container, product(width, height, plain.pixel_bytes()))?;
            (plain.decode(&bytes)?, plain.channels)
        }
        Coding::Uastc => {
            let size = product(width.div_ceil(4), height.div_ceil(4), uastc::BLOCK);
            let bytes = level::bytes_of(container, size)?;
            let mut out = list(product(width, height, 4))?;
            uastc::decode(&bytes, width, &mut out);
            (Samples::U8(out), 4)
        }
        Coding::Etc1s(second) => {
            let mut out = list(product(width, height, 4))?;
            etc1s::decode(container.global, container.images, container.level, second, width, &mut out)?;
            (Samples::U8(out), 4)
        }
    };
    let view = View::new(container.swizzle.unwrap_or_else(|| shown(container, coding)), stored);
    let arrangement = Arrangement {
        stored,
        width,
        is_flipped: container.is_flipped,
        is_premultiplied: container.descriptor.is_premultiplied,
        view,
    };
    let channels = arrangement.view.channels as u8;
    Ok(Picture { channels, samples: arrangement.apply(samples)? })
}

/// What the channels of a picture show without `KTXswizzle`. One channel is grey.
fn shown(container: &Container<'_>, coding: Coding) -> [Shown; 4] {
    use Shown::{Channel, One, Zero};
    let (red, green, blue, alpha) = (Channel(0), Channel(1), Channel(2), Channel(3));
    let grey = [red, red, red, One];
    match (coding, container.descriptor.channels) {
        (Coding::Plain(plain), _) if plain.channels == 1 => grey,
        (Coding::Plain(_), _) => [red, green, blue, alpha],
        (Coding::Etc1s(_), (ETC1S_RRR, None)) | (Coding::Uastc, (UASTC_RRR, _)) => grey,
        // The second of two independent channels is stored as alpha.
        (Coding::Etc1s(_), (ETC1S_RRR, Some(ETC1S_GGG))) | (Coding::Uastc, (UASTC_RRRG, _)) => {
            [red, alpha, Zero, One]
        }
        (Coding::Uastc, (UASTC_RG, _)) => [red, green, Zero, One],
        (Coding::Etc1s(false), _) | (Coding::Uastc, (UASTC_RGB, _)) => [red, green, blue, One],
        (Coding::Uastc, (UASTC_RGBA, _)) | (Coding::Etc1s(true) | Coding::Uastc, _) => {
            [red, green, blue, alpha]
        }
    }
}
