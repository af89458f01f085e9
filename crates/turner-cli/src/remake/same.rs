//! Whether two picture files are the same: bytes, or else all channels of all pixels.

use turner::image::Pixels;
use turner::schema::error::escape;
use turner_io::image::{ChannelValues, DecodeLimits, ImageFormat, decode, exr};

use crate::failure::Failure;
use crate::picture_file::{PictureFile, failed};

/// The result.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Sameness {
    /// The files are equal.
    Bytes,
    /// All channels are equal; these metadata are not.
    Pixels {
        /// Their names.
        metadata: Vec<String>,
    },
    /// Some pixels differ.
    Different {
        /// How many.
        pixels: u64,
        /// Of how many.
        total: u64,
        /// Column and row of the first.
        first: (u64, u64),
    },
    /// The pictures have other sizes or channels, which the text says.
    OtherSize(String),
}

impl Sameness {
    /// Whether the pixels are equal.
    pub(super) fn is_same(&self) -> bool {
        matches!(self, Sameness::Bytes | Sameness::Pixels { .. })
    }
}

/// A decoded picture.
struct Decoded {
    width: u64,
    height: u64,
    /// Names and the bits of the samples.
    channels: Vec<(String, Vec<u32>)>,
}

/// Compares two files of the same format.
pub(super) fn compare(old: &PictureFile, new: &PictureFile) -> Result<Sameness, Failure> {
    if old.bytes == new.bytes {
        return Ok(Sameness::Bytes);
    }
    let (a, b) = (decoded(old)?, decoded(new)?);
    if (a.width, a.height) != (b.width, b.height) {
        let what = format!("{}x{} pixels and now {}x{}", a.width, a.height, b.width, b.height);
        return Ok(Sameness::OtherSize(what));
    }
    let names = |d: &Decoded| d.channels.iter().map(|(name, _)| escape(name)).collect::<Vec<_>>();
    if names(&a) != names(&b) {
        let what = format!("channels {} and now {}", names(&a).join(" "), names(&b).join(" "));
        return Ok(Sameness::OtherSize(what));
    }
    let channels: Vec<_> = a.channels.iter().zip(&b.channels).map(|((_, a), (_, b))| (a, b)).collect();
    let total = a.width.saturating_mul(a.height);
    let differs = |i: &u64| {
        let at = usize::try_from(*i).unwrap_or(usize::MAX);
        channels.iter().any(|(a, b)| a.get(at) != b.get(at))
    };
    let mut different = (0..total).filter(differs);
    if let Some(first) = different.next() {
        let first = (first % a.width, first / a.width);
        return Ok(Sameness::Different { pixels: 1 + different.count() as u64, total, first });
    }
    let (old, new) = (old.metadata()?, new.metadata()?);
    let mut metadata: Vec<String> = old.keys().chain(new.keys()).cloned().collect();
    metadata.retain(|key| old.get(key).map(ToString::to_string) != new.get(key).map(ToString::to_string));
    metadata.sort();
    metadata.dedup();
    Ok(Sameness::Pixels { metadata })
}

fn decoded(file: &PictureFile) -> Result<Decoded, Failure> {
    let limits = DecodeLimits::default();
    if file.format != ImageFormat::Exr {
        let image = decode(&file.bytes, &file.name, &limits).map_err(|e| failed(&e))?;
        let count = usize::from(image.channels);
        let values = |c: usize| -> Vec<u32> {
            match &image.pixels {
                Pixels::U8(v) => v.iter().skip(c).step_by(count).map(|v| u32::from(*v)).collect(),
                Pixels::U16(v) => v.iter().skip(c).step_by(count).map(|v| u32::from(*v)).collect(),
                Pixels::F32(v) => v.iter().skip(c).step_by(count).map(|v| v.to_bits()).collect(),
            }
        };
        let channels = (0..count).map(|c| (format!("channel {c}"), values(c))).collect();
        return Ok(Decoded { width: image.width.into(), height: image.height.into(), channels });
    }
    let parts = exr::parts(&file.bytes, &file.name).map_err(|e| failed(&e))?;
    let (width, height) = parts.first().map_or((0, 0), |part| (part.width, part.height));
    let mut channels = Vec::new();
    for part in 0..parts.len() {
        let read = exr::read_channels(&file.bytes, &file.name, part, |_| true, &limits);
        for channel in read.map_err(|e| failed(&e))? {
            let bits = match &channel.values {
                ChannelValues::Float(v) => v.iter().map(|v| v.to_bits()).collect(),
                ChannelValues::Uint(v) => v.to_vec(),
            };
            channels.push((format!("{} ({})", channel.name, channel.kind.word()), bits));
        }
    }
    Ok(Decoded { width, height, channels })
}
