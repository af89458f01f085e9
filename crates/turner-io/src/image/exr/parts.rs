//! What an EXR file contains: parts, layers, channels; and the samples of any of its channels.

use super::FORMAT;
use super::channels::{full_names, unknown_layer};
use super::picture::{copy, floats};
use super::read::Opened;
use super::subsampled::is_subsampled;
use crate::image::contain::contain;
use crate::image::limits::buffer;
use crate::image::{ChannelValues, DecodeLimits, ExtraChannel, ImageError, SampleKind};
use exr::compression::Compression;
use exr::meta::BlockDescription;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;

/// A part of an EXR file: channels of equal size.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExrPart {
    /// Its name; files with one part often have none.
    pub name: Option<String>,
    /// Columns of the display window, which is the picture.
    pub width: u64,
    /// Rows of the display window.
    pub height: u64,
    /// The pixels stored, relative to the display window: first column, first row, columns, rows.
    pub data: [i64; 4],
    /// The compression in OpenEXR's words: `none`, `rle`, `zips`, `zip`, `piz`, `pxr24`, `b44`, `b44a`, `dwaa`,
    /// `dwab`, `htj2k32` or `htj2k256`.
    pub compression: &'static str,
    /// Size of the tiles, if it is stored in tiles.
    pub tiles: Option<(u64, u64)>,
    /// Whether pixels hold lists of samples at several depths, which [`decode`](super::decode) flattens.
    pub deep: bool,
    /// Its channels, in the order of the file.
    pub channels: Vec<ExrChannel>,
}

/// A channel of an EXR file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExrChannel {
    /// The name, `layer.component` or `component`. In files of several parts it begins with the name of the part.
    pub name: String,
    /// How samples are stored.
    pub kind: SampleKind,
    /// Whether it has less than one sample per pixel.
    pub subsampled: bool,
}

/// Lists the parts and channels of an EXR file without decoding pixels.
pub fn parts(bytes: &[u8], name: &str) -> Result<Vec<ExrPart>, ImageError> {
    contain(name, FORMAT, || {
        let file = Opened::new(bytes, name)?;
        let names = full_names(file.headers());
        Ok(file.headers().iter().zip(names).map(|(header, names)| part(header, names)).collect())
    })
}

fn part(header: &Header, names: Vec<String>) -> ExrPart {
    let window = header.shared_attributes.display_window;
    let position = header.own_attributes.layer_position;
    let tiles = match header.blocks {
        BlockDescription::Tiles(tiles) => Some((tiles.tile_size.0 as u64, tiles.tile_size.1 as u64)),
        BlockDescription::ScanLines => None,
    };
    let channels = header.channels.list.iter().zip(names).map(|(channel, name)| ExrChannel {
        name,
        kind: kind(channel.sample_type),
        subsampled: is_subsampled(channel),
    });
    ExrPart {
        name: header.own_attributes.layer_name.as_ref().map(ToString::to_string),
        width: window.size.0 as u64,
        height: window.size.1 as u64,
        data: [
            i64::from(position.0) - i64::from(window.position.0),
            i64::from(position.1) - i64::from(window.position.1),
            header.layer_size.0 as i64,
            header.layer_size.1 as i64,
        ],
        compression: word(header.compression),
        tiles,
        deep: header.deep,
        channels: channels.collect(),
    }
}

fn kind(sample: SampleType) -> SampleKind {
    match sample {
        SampleType::F16 => SampleKind::Half,
        SampleType::F32 => SampleKind::Float,
        SampleType::U32 => SampleKind::Uint,
    }
}

fn word(compression: Compression) -> &'static str {
    match compression {
        Compression::Uncompressed => "none",
        Compression::RLE => "rle",
        Compression::ZIP1 => "zips",
        Compression::ZIP16 => "zip",
        Compression::PIZ => "piz",
        Compression::PXR24 => "pxr24",
        Compression::B44 => "b44",
        Compression::B44A => "b44a",
        Compression::DWAA(_) => "dwaa",
        Compression::DWAB(_) => "dwab",
        Compression::HTJ2K32 => "htj2k32",
        Compression::HTJ2K256 => "htj2k256",
    }
}

/// Reads the channels of a part, in the order of the file, with the names of [`parts`]: those for which `wanted` is
/// true. Samples are those of the display window, 0 outside the data window; integers stay integers. A sample of a
/// subsampled channel counts for the pixels up to the next one.
///
/// An error if there is no such part, or if it is deep.
pub fn read_channels(
    bytes: &[u8],
    name: &str,
    part: usize,
    wanted: impl Fn(&str) -> bool,
    limits: &DecodeLimits,
) -> Result<Vec<ExtraChannel<'static>>, ImageError> {
    contain(name, FORMAT, || {
        let file = Opened::new(bytes, name)?;
        let (Some(header), Some(names)) =
            (file.headers().get(part), full_names(file.headers()).into_iter().nth(part))
        else {
            return Err(unknown_layer(file.headers(), name, &format!("part {part}")));
        };
        if header.deep {
            return Err(ImageError::unsupported(name, FORMAT, "deep data", "flat pixels"));
        }
        let list: Vec<_> =
            header.channels.list.iter().zip(names).map(|(c, name)| (c.clone(), name)).collect();
        let count = list.iter().filter(|(_, name)| wanted(name)).count() as u64;
        let window = file.window(part, 4 * count, limits)?;
        let mut channels = Vec::with_capacity(list.len());
        for (channel, full) in list {
            if !wanted(&full) {
                channels.push(None);
                continue;
            }
            let kind = kind(channel.sample_type);
            let values = match kind {
                SampleKind::Uint => ChannelValues::from(buffer::<u32>(window.size.pixels, name)?),
                SampleKind::Half | SampleKind::Float => {
                    ChannelValues::from(buffer::<f32>(window.size.pixels, name)?)
                }
            };
            channels.push(Some(ExtraChannel { name: full.into(), kind, values }));
        }
        file.lines(part, &window, |line| {
            let Some(Some(channel)) = channels.get_mut(line.channel) else { return };
            match &mut channel.values {
                ChannelValues::Float(v) => {
                    floats(&line, v.to_mut().get_mut(line.first..).unwrap_or_default().iter_mut());
                }
                ChannelValues::Uint(v) => {
                    let out = v.to_mut().get_mut(line.first..).unwrap_or_default().iter_mut();
                    copy(line.bytes, out, u32::from_ne_bytes);
                }
            }
        })?;
        Ok(channels.into_iter().flatten().collect())
    })
}
