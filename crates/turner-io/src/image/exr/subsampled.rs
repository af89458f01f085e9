//! Blocks with channels of less than one sample per pixel.
//!
//! A channel with the sampling (2, 2) has samples at every second pixel of every second row, counted from the corner
//! of the data window. A block stores, for each row, the samples of each channel that has any there.
//!
//! The exr crate refuses such files. So it reads them as if every channel had all samples ([`full`]), and blocks are
//! decompressed with the true sampling.

use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::{BlockIndex, UncompressedBlock};
use exr::compression::Compression;
use exr::error::Error;
use exr::math::Vec2;
use exr::meta::attribute::{ChannelDescription, IntegerBounds, SampleType};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};

use super::FORMAT;
use super::attributes::headers;
use crate::image::ImageError;
use crate::image::limits::reserve;

/// Whether a channel has less than one sample per pixel.
pub(super) fn is_subsampled(channel: &ChannelDescription) -> bool {
    channel.sampling.0 != 1 || channel.sampling.1 != 1
}

/// Whether a part has such channels.
pub(super) fn has_subsampled(header: &Header) -> bool {
    header.channels.list.iter().any(is_subsampled)
}

/// Samples of a channel in a row, at every `step`th pixel and for `rows` rows.
pub(super) struct Row {
    pub(super) channel: usize,
    /// Relative to the data window.
    pub(super) y: usize,
    /// Its bytes in the block.
    pub(super) bytes: std::ops::Range<usize>,
    pub(super) step: usize,
    pub(super) rows: usize,
}

/// The rows of a block of scan lines in the order in which they are stored.
pub(super) fn rows(header: &Header, index: BlockIndex) -> Vec<Row> {
    let (first, width) = (index.pixel_position.1, index.pixel_size.0);
    let mut at = 0_usize;
    let mut found = Vec::new();
    for y in first..first.saturating_add(index.pixel_size.1) {
        for (channel, description) in header.channels.list.iter().enumerate() {
            let (step, rows) = (description.sampling.0.max(1), description.sampling.1.max(1));
            if y % rows != 0 {
                continue;
            }
            let end =
                at.saturating_add((width / step).saturating_mul(description.sample_type.bytes_per_sample()));
            found.push(Row { channel, y, bytes: at..end, step, rows });
            at = end;
        }
    }
    found
}

/// Samplings (x, y) of the channels of each part.
pub(super) type Samplings = Vec<Vec<(usize, usize)>>;

/// A copy of a file whose channels claim to have all samples, and what they have; `None` if they do have all.
pub(super) fn full(bytes: &[u8], name: &str) -> Result<Option<(Vec<u8>, Samplings)>, ImageError> {
    let Some(fields) = fields(bytes) else { return Ok(None) };
    let integer = |at: usize| {
        let field = bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
        field.map_or(1, i32::from_le_bytes)
    };
    let pair = |at: &usize| (integer(*at).max(1) as usize, integer(at + 4).max(1) as usize);
    let samplings: Samplings = fields.iter().map(|part| part.iter().map(pair).collect()).collect();
    if samplings.iter().flatten().all(|s| *s == (1, 1)) {
        return Ok(None);
    }
    let mut copy = Vec::new();
    reserve(&mut copy, bytes.len(), name)?;
    copy.extend_from_slice(bytes);
    for at in fields.into_iter().flatten() {
        let one = [1, 0, 0, 0, 1, 0, 0, 0];
        if let Some(field) = copy.get_mut(at..at + 8) {
            field.copy_from_slice(&one);
        }
    }
    Ok(Some((copy, samplings)))
}

/// Where the samplings of the channels of each part are in a file; `None` if its headers are cut off.
fn fields(bytes: &[u8]) -> Option<Vec<Vec<usize>>> {
    let mut parts = Vec::new();
    for header in headers(bytes)? {
        let mut part = Vec::new();
        let list = header.into_iter().find(|a| a.name == b"channels")?;
        let mut at = list.range.end - list.value.len();
        // Name, NUL, type, flags, sampling along x and y; an empty name ends the list.
        while *bytes.get(at)? != 0 && at < list.range.end {
            at += bytes.get(at..list.range.end)?.iter().position(|b| *b == 0)? + 1;
            part.push(at + 8);
            at += 16;
        }
        parts.push(part);
    }
    Some(parts)
}

/// Gives the channels of headers their true samplings.
///
/// Errors: windows that are no multiples of them.
pub(super) fn restore(headers: &mut [Header], samplings: &Samplings, name: &str) -> Result<(), ImageError> {
    for (header, samplings) in headers.iter_mut().zip(samplings) {
        let (size, corner) = (header.layer_size, header.own_attributes.layer_position);
        for (channel, (x, y)) in header.channels.list.iter_mut().zip(samplings) {
            let fits = |size: usize, corner: i32, step: usize| {
                size.is_multiple_of(step) && i64::from(corner) % step as i64 == 0
            };
            let is_flat = !header.deep && header.blocks == BlockDescription::ScanLines;
            if !(fits(size.0, corner.0, *x) && fits(size.1, corner.1, *y) && (is_flat || (*x, *y) == (1, 1)))
            {
                let problem =
                    format!("the channel {} cannot have samples at every {x} x {y} pixels", channel.name);
                return Err(ImageError::damaged(name, FORMAT, problem));
            }
            channel.sampling = Vec2(*x, *y);
        }
    }
    Ok(())
}

/// Decompresses a chunk, also with such channels. The exr crate computes the size of a block from the bytes per pixel,
/// which are those of its own rows here: they are set in `header`, which has the true samplings.
pub(super) fn decompress(
    chunk: Chunk,
    meta: &MetaData,
    header: &mut Header,
) -> Result<UncompressedBlock, Error> {
    if !has_subsampled(header) {
        return UncompressedBlock::decompress_chunk(chunk, meta, false);
    }
    let tile = header.get_block_data_indices(&chunk.compressed_block)?;
    let area = header.get_absolute_block_pixel_coordinates(tile)?;
    area.validate(Some(header.layer_size))?;
    let index = BlockIndex {
        layer: chunk.layer_index,
        pixel_position: area.position.to_usize("block position")?,
        level: tile.level_index,
        pixel_size: area.size,
    };
    let CompressedBlock::ScanLine(lines) = chunk.compressed_block else {
        return Err(Error::NotSupported("subsampled tiles".into()));
    };
    let size = rows(header, index).last().map_or(0, |row| row.bytes.end);
    let pixels = area.size.area().max(1);
    if !size.is_multiple_of(pixels) {
        let what = "subsampled channels whose blocks have no whole number of bytes per pixel";
        return Err(Error::NotSupported(what.into()));
    }
    let packed = lines.compressed_pixels_le;
    if matches!(header.compression, Compression::B44 | Compression::B44A) && packed.len() != size {
        return Ok(UncompressedBlock { index, data: b44(&packed, header, index)? });
    }
    header.channels.bytes_per_pixel = size / pixels;
    let data = header.compression.decompress_image_section_from_le(header, packed, area, false)?;
    Ok(UncompressedBlock { index, data })
}

/// Decompresses B44 data channel by channel, as a part with that channel alone: the exr crate assumes as many samples
/// in each.
fn b44(packed: &[u8], header: &Header, index: BlockIndex) -> Result<Vec<u8>, Error> {
    let (width, height) = (index.pixel_size.0, index.pixel_size.1);
    let mut rest = packed;
    let mut columns = Vec::new();
    for channel in &header.channels.list {
        let mut own = header.clone();
        let mut alone = channel.clone();
        alone.sampling = Vec2(1, 1);
        let size = Vec2(width / channel.sampling.0, height / channel.sampling.1);
        let plain = size.area() * channel.sample_type.bytes_per_sample();
        own.channels.bytes_per_pixel = channel.sample_type.bytes_per_sample();
        own.channels.list = std::iter::once(alone).collect();
        // Other samples than halves are stored as they are.
        let length = if channel.sample_type == SampleType::F16 { b44_length(rest, size) } else { plain };
        let (own_bytes, after) =
            rest.split_at_checked(length).ok_or_else(|| Error::Invalid("truncated B44 data".into()))?;
        rest = after;
        if channel.sample_type == SampleType::F16 && length == plain {
            return Err(Error::NotSupported("B44 blocks as large as their samples".into()));
        }
        let area = IntegerBounds::from_dimensions(size);
        columns.push(header.compression.decompress_image_section_from_le(
            &own,
            own_bytes.to_vec(),
            area,
            false,
        )?);
    }
    let mut taken = vec![0_usize; columns.len()];
    let mut data = Vec::new();
    for row in rows(header, index) {
        let (Some(column), Some(at)) = (columns.get(row.channel), taken.get_mut(row.channel)) else {
            continue;
        };
        let end = *at + row.bytes.len();
        data.extend_from_slice(column.get(*at..end).unwrap_or_default());
        *at = end;
    }
    Ok(data)
}

/// Bytes of the B44 data of a channel: blocks of 4 x 4 samples with 14 bytes, or 3 if all samples are equal.
fn b44_length(bytes: &[u8], size: Vec2<usize>) -> usize {
    /// The third byte of a block of equal samples is at least this.
    const EQUAL: u8 = 13 << 2;
    let blocks = size.0.div_ceil(4) * size.1.div_ceil(4);
    (0..blocks).fold(0, |at, _| at + if bytes.get(at + 2).is_some_and(|b| *b >= EQUAL) { 3 } else { 14 })
}

/// Repeats each of the samples of `size` bytes `step` times.
pub(super) fn repeated(bytes: &[u8], size: usize, step: usize) -> Vec<u8> {
    bytes.chunks_exact(size).flat_map(|sample| std::iter::repeat_n(sample, step)).flatten().copied().collect()
}
