//! Reads a picture file: channels with their statistics, metadata, the values of a pixel.

use std::collections::HashMap;

use turner::image::{Image, Pixels};
use turner::schema::error::escape;
use turner::schema::{ErrorCode, SceneError};
use turner_io::image::{
    ChannelValues, DecodeLimits, ExtraChannel, ImageFormat, Metadata, SampleKind, decode, exr,
};

use crate::failure::Failure;
use crate::picture_file::{PictureFile, failed};

/// What a picture file contains. Names are as in the file, not escaped.
pub(super) struct Contents {
    pub(super) name: String,
    pub(super) bytes: u64,
    pub(super) format: ImageFormat,
    pub(super) width: u64,
    pub(super) height: u64,
    pub(super) parts: Vec<Part>,
    pub(super) metadata: Metadata,
    pub(super) pixel: Option<(u32, u32)>,
}

/// Channels that are stored together.
pub(super) struct Part {
    /// What an EXR file says about the part.
    pub(super) exr: Option<exr::ExrPart>,
    pub(super) channels: Vec<Channel>,
}

/// A channel.
pub(super) struct Channel {
    pub(super) name: String,
    /// `half`, `float`, `uint`, `8 bits` or `16 bits`.
    pub(super) kind: &'static str,
    pub(super) statistics: Statistics,
    /// The value in the requested pixel.
    pub(super) value: Option<f64>,
}

/// Statistics of the values of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Statistics {
    /// The smallest, the largest and the mean finite value; `None` if there are none.
    pub(super) range: Option<(f64, f64, f64)>,
    /// Number of NaNs.
    pub(super) nan: u64,
    /// Number of infinite values.
    pub(super) infinite: u64,
}

impl Statistics {
    fn of(values: impl Iterator<Item = f64>) -> Statistics {
        let mut found = Statistics::default();
        let (mut least, mut most, mut sum, mut count) = (f64::INFINITY, f64::NEG_INFINITY, 0.0, 0u64);
        for v in values {
            if v.is_finite() {
                (least, most, sum, count) = (least.min(v), most.max(v), sum + v, count + 1);
            } else if v.is_nan() {
                found.nan += 1;
            } else {
                found.infinite += 1;
            }
        }
        found.range = (count > 0).then(|| (least, most, sum / count as f64));
        found
    }
}

/// Channels with colours as R G B A; the file has them in alphabetical order.
fn in_reading_order(channels: &[exr::ExrChannel]) -> Vec<&exr::ExrChannel> {
    let key = |channel: &&exr::ExrChannel| {
        let (layer, component) = channel.name.rsplit_once('.').unwrap_or(("", &channel.name));
        let rank = ["R", "G", "B", "A"].iter().position(|c| *c == component).unwrap_or(4);
        (layer.to_owned(), rank, component.to_owned())
    };
    let mut sorted: Vec<_> = channels.iter().collect();
    sorted.sort_by_key(key);
    sorted
}

/// Reads the file.
pub(super) fn read(
    file: &PictureFile,
    layer: Option<&str>,
    pixel: Option<(u32, u32)>,
) -> Result<Contents, Failure> {
    let (width, height, parts) = match file.format {
        ImageFormat::Exr => of_exr(file, layer, pixel)?,
        _ => of_image(file, layer, pixel)?,
    };
    Ok(Contents {
        name: file.name.clone(),
        bytes: file.bytes.len() as u64,
        format: file.format,
        width,
        height,
        parts,
        metadata: file.metadata()?,
        pixel,
    })
}

/// Most parts of an EXR file whose values are read. Each reads the headers of all again.
const MOST_PARTS: usize = 64;

/// Columns, rows and parts.
type Found = (u64, u64, Vec<Part>);

fn of_exr(file: &PictureFile, layer: Option<&str>, pixel: Option<(u32, u32)>) -> Result<Found, Failure> {
    let parts = exr::parts(&file.bytes, &file.name).map_err(|e| failed(&e))?;
    let (width, height) = parts.first().map_or((0, 0), |p| (p.width, p.height));
    let index = index(file, (width, height), pixel)?;
    let prefix = layer.map(|l| format!("{}.", l.to_lowercase()));
    // `N` has the channels `N.X` and so on, and `Z` is a channel itself.
    let in_layer = |name: &str| {
        prefix.as_ref().is_none_or(|prefix| format!("{}.", name.to_lowercase()).starts_with(prefix))
    };
    let mut found = Vec::new();
    for (number, part) in parts.into_iter().enumerate() {
        if !part.channels.iter().any(|c| in_layer(&c.name)) {
            continue;
        }
        // Deep channels are listed without values.
        let channels = if part.deep || number >= MOST_PARTS {
            Vec::new()
        } else {
            exr::read_channels(&file.bytes, &file.name, number, in_layer, &DecodeLimits::default())
                .map_err(|e| failed(&e))?
        };
        let read: HashMap<&str, &ExtraChannel<'_>> = channels.iter().map(|c| (c.name.as_ref(), c)).collect();
        let listed =
            in_reading_order(&part.channels).into_iter().filter(|c| in_layer(&c.name)).map(|listed| {
                let empty = Channel {
                    name: listed.name.clone(),
                    kind: listed.kind.word(),
                    statistics: Statistics::default(),
                    value: None,
                };
                let read = read.get(listed.name.as_str());
                read.map_or(empty, |read| channel(read, read.kind.word(), index))
            });
        let channels = listed.collect();
        found.push(Part { exr: Some(part), channels });
    }
    if found.is_empty() && layer.is_some() {
        // For its message, which lists the layers.
        file.image(layer)?;
    }
    Ok((width, height, found))
}

fn of_image(file: &PictureFile, layer: Option<&str>, pixel: Option<(u32, u32)>) -> Result<Found, Failure> {
    let image = match layer {
        None => decode(&file.bytes, &file.name, &DecodeLimits::default()).map_err(|e| failed(&e))?,
        Some(_) => file.image(layer)?.0,
    };
    let size = (u64::from(image.width), u64::from(image.height));
    let index = index(file, size, pixel)?;
    let kind = match &image.pixels {
        Pixels::U8(_) => "8 bits",
        Pixels::U16(_) => "16 bits",
        Pixels::F32(_) => "float",
    };
    let channels = split(&image).iter().map(|c| channel(c, kind, index)).collect();
    Ok((size.0, size.1, vec![Part { exr: None, channels }]))
}

/// The channels of an image one by one.
fn split(image: &Image) -> Vec<ExtraChannel<'static>> {
    let names: &[&str] = match image.channels {
        1 => &["Y"],
        2 => &["Y", "A"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    };
    let n = names.len();
    let values = |c: usize| match &image.pixels {
        Pixels::U8(v) => {
            ChannelValues::from(v.iter().skip(c).step_by(n).map(|v| u32::from(*v)).collect::<Vec<_>>())
        }
        Pixels::U16(v) => {
            ChannelValues::from(v.iter().skip(c).step_by(n).map(|v| u32::from(*v)).collect::<Vec<_>>())
        }
        Pixels::F32(v) => ChannelValues::from(v.iter().skip(c).step_by(n).copied().collect::<Vec<_>>()),
    };
    names.iter().enumerate().map(|(c, name)| ExtraChannel::new(*name, SampleKind::Float, values(c))).collect()
}

fn channel(read: &ExtraChannel<'_>, kind: &'static str, index: Option<usize>) -> Channel {
    let (statistics, value) = match &read.values {
        ChannelValues::Float(v) => {
            (Statistics::of(v.iter().map(|v| f64::from(*v))), index.map(|i| f64::from(v[i])))
        }
        ChannelValues::Uint(v) => {
            (Statistics::of(v.iter().map(|v| f64::from(*v))), index.map(|i| f64::from(v[i])))
        }
    };
    Channel { name: read.name.clone().into_owned(), kind, statistics, value }
}

/// The index of the requested pixel; an error if it is outside.
fn index(
    file: &PictureFile,
    (width, height): (u64, u64),
    pixel: Option<(u32, u32)>,
) -> Result<Option<usize>, Failure> {
    let Some((x, y)) = pixel else { return Ok(None) };
    if u64::from(x) < width && u64::from(y) < height {
        return Ok(usize::try_from(u64::from(y) * width + u64::from(x)).ok());
    }
    let name = escape(&file.name);
    let message = format!("--pixel {x},{y} is outside {name}, which has {width}x{height} pixels");
    let help = format!("use columns 0 to {} and rows 0 to {}", width.max(1) - 1, height.max(1) - 1);
    Err(Failure::usage(SceneError::new(ErrorCode::Image, message).help(help)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_leave_out_what_is_not_finite() {
        let found = Statistics::of([1.0, f64::NAN, 3.0, f64::INFINITY, -1.0, f64::NEG_INFINITY].into_iter());
        assert_eq!(found, Statistics { range: Some((-1.0, 3.0, 1.0)), nan: 1, infinite: 2 });
        assert_eq!(Statistics::of([f64::NAN].into_iter()).range, None);
    }
}
