//! Deep pixels: a list of samples at several depths for each pixel, flattened.
//!
//! A chunk of scan lines or a tile has, for each of its pixels, the number of samples of its row up to there, then for
//! each row and channel the samples of all its pixels. Both are compressed: not at all, by RLE, or by ZIP.
//!
//! The samples of a pixel are ordered by `Z` (by `ZBack` where that is equal) and composited front to back: each is
//! multiplied by what those before it let through, 1 − alpha. Colours are premultiplied. Samples that overlap in depth
//! are not split, as in OpenEXR's own compositing.

use std::collections::HashSet;

use exr::compression::Compression;
use exr::meta::BlockDescription;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::f16;

use super::FORMAT;
use super::attributes::{end_of_headers, headers};
use super::channels::Choice;
use super::read::Window;
use crate::gzip::decompress_zlib;
use crate::image::ImageError;
use crate::image::limits::buffer;

/// Most bytes that a byte of compressed data can become.
const RATIO: usize = 1100;

/// The headers of a file whose parts are all deep, as those of flat parts: without the flag of deep data, and with
/// other types. `None` for other files.
pub(super) fn flat_headers(bytes: &[u8]) -> Option<Vec<u8>> {
    /// In the flags at byte 5: the file has one part, of tiles; it has deep parts; it has several parts.
    const TILES: u8 = 1 << 1;
    const DEEP: u8 = 1 << 3;
    const PARTS: u8 = 1 << 4;
    let flags = *bytes.get(5)?;
    if flags & DEEP == 0 {
        return None;
    }
    let mut out = bytes.get(..8)?.to_vec();
    let mut has_tiles = false;
    for header in headers(bytes)? {
        let mut found = false;
        for attribute in header {
            let flat: &[u8] = match (attribute.name, attribute.value) {
                (b"type", b"deepscanline") => b"scanlineimage",
                (b"type", b"deeptile") => b"tiledimage",
                _ => {
                    out.extend_from_slice(bytes.get(attribute.range)?);
                    continue;
                }
            };
            found = true;
            has_tiles |= flat == b"tiledimage";
            out.extend_from_slice(b"type\0string\0");
            out.extend((flat.len() as u32).to_le_bytes());
            out.extend_from_slice(flat);
        }
        out.push(0);
        if !found {
            return None;
        }
    }
    if flags & PARTS != 0 {
        out.push(0);
    }
    if let Some(own) = out.get_mut(5) {
        *own = flags & !DEEP | if has_tiles && flags & PARTS == 0 { TILES } else { 0 };
    }
    Some(out)
}

/// The parts of a file that is read.
pub(super) struct Deep<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) name: &'a str,
    pub(super) headers: &'a [Header],
    pub(super) part: usize,
}

/// A rectangle of the data window and its compressed data.
struct Chunk<'a> {
    corner: [usize; 2],
    size: [usize; 2],
    counts: &'a [u8],
    samples: &'a [u8],
}

/// Where the channels of a sample are in the header's list.
struct Roles {
    depth: Option<usize>,
    back: Option<usize>,
    alpha: Option<usize>,
}

impl Deep<'_> {
    /// The chosen channels of a deep part, flattened, in the display window `window`.
    pub(super) fn flatten(&self, choice: &Choice, window: &Window) -> Result<Vec<f32>, ImageError> {
        let channels = usize::from(choice.channels);
        let Some(header) = self.headers.get(self.part) else { return Ok(Vec::new()) };
        let data = window.of_data(header);
        let mut pixels = buffer(data.size.pixels * channels, self.name)?;
        let damaged = |problem: String| ImageError::damaged(self.name, FORMAT, problem);
        let mut seen = HashSet::new();
        for offset in self.offsets(header).map_err(damaged)? {
            let Some(chunk) = self.chunk(header, offset).map_err(damaged)? else { continue };
            if !seen.insert(chunk.corner) {
                return Err(damaged("the offset table refers to a block twice".into()));
            }
            chunk.flatten(header, choice, data.size.width as usize, &mut pixels).map_err(damaged)?;
        }
        let mut samples = buffer(window.size.pixels * channels, self.name)?;
        window.place(&data, &pixels, channels, &mut samples);
        Ok(samples)
    }

    /// The offsets of the part's chunks.
    fn offsets(&self, header: &Header) -> Result<Vec<usize>, String> {
        let before: usize = self.headers.iter().take(self.part).map(|h| h.chunk_count).sum();
        let start = end_of_headers(self.bytes).and_then(|end| end.checked_add(before.checked_mul(8)?));
        let table = start
            .and_then(|start| self.bytes.get(start..start.checked_add(header.chunk_count.checked_mul(8)?)?));
        let table = table.ok_or("the offset table extends beyond the end of the file")?;
        Ok(table.as_chunks::<8>().0.iter().map(|b| u64::from_le_bytes(*b) as usize).collect())
    }

    /// The chunk at an offset; `None` if it belongs to a smaller resolution level.
    fn chunk(&self, header: &Header, offset: usize) -> Result<Option<Chunk<'_>>, String> {
        let cut = || format!("a block at byte {offset} extends beyond the end of the file");
        let mut rest = self.bytes.get(offset..).ok_or_else(cut)?;
        let mut take = |count: usize| -> Result<&[u8], String> {
            let (taken, after) = rest.split_at_checked(count).ok_or_else(cut)?;
            rest = after;
            Ok(taken)
        };
        let mut integers = |count: usize| -> Result<Vec<i64>, String> {
            let words = take(4 * count)?.as_chunks::<4>().0.iter();
            Ok(words.map(|b| i64::from(i32::from_le_bytes(*b))).collect())
        };
        if self.headers.len() > 1 && integers(1)? != [self.part as i64] {
            return Err("the offset table refers to a block of another part".into());
        }
        let (width, height) = (header.layer_size.0, header.layer_size.1);
        let (corner, most) = match header.blocks {
            BlockDescription::ScanLines => {
                let y =
                    integers(1)?.first().map_or(0, |y| y - i64::from(header.own_attributes.layer_position.1));
                ([0, y], [width, header.compression.scan_lines_per_block()])
            }
            BlockDescription::Tiles(tiles) => {
                let [x, y, level_x, level_y] = integers(4)?[..] else { return Err(cut()) };
                if (level_x, level_y) != (0, 0) {
                    return Ok(None);
                }
                let side = [tiles.tile_size.0, tiles.tile_size.1];
                ([x.saturating_mul(side[0] as i64), y.saturating_mul(side[1] as i64)], side)
            }
        };
        let [x, y] = corner.map(|v| usize::try_from(v).unwrap_or(usize::MAX));
        if x >= width || y >= height || most.contains(&0) {
            return Err(format!("a block lies at {corner:?}: expected it in {width} x {height} pixels"));
        }
        let lengths = take(24)?.as_chunks::<8>().0;
        let [counts, samples, _] =
            [0, 1, 2].map(|i| lengths.get(i).map_or(0, |b| u64::from_le_bytes(*b)) as usize);
        let size = [most[0].min(width - x), most[1].min(height - y)];
        Ok(Some(Chunk { corner: [x, y], size, counts: take(counts)?, samples: take(samples)? }))
    }
}

impl Chunk<'_> {
    fn flatten(
        &self,
        header: &Header,
        choice: &Choice,
        stride: usize,
        pixels: &mut [f32],
    ) -> Result<(), String> {
        let [width, height] = self.size;
        let compression = header.compression;
        let counts = unpack(compression, self.counts, 4 * width * height)?;
        let ends: Vec<usize> =
            counts.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b) as usize).collect();
        // The counts add up along a row.
        if ends.chunks(width).any(|row| !row.is_sorted()) {
            return Err("the numbers of samples decrease along a row".into());
        }
        let total =
            ends.chunks(width).filter_map(|row| row.last()).fold(0, |sum: usize, n| sum.saturating_add(*n));
        let size = total.saturating_mul(header.channels.bytes_per_pixel);
        let data = unpack(compression, self.samples, size)?;
        let list = &header.channels.list;
        let position = |name: &str| list.iter().position(|c| c.name.eq(name));
        let roles = Roles { depth: position("Z"), back: position("ZBack"), alpha: position("A") };
        let channels = usize::from(choice.channels);
        let mut rest = data.as_slice();
        for (y, row) in ends.chunks(width).enumerate() {
            let count = row.last().copied().unwrap_or(0);
            let mut columns = Vec::with_capacity(list.len());
            for channel in list {
                let bytes = count * channel.sample_type.bytes_per_sample();
                let (column, after) = rest.split_at_checked(bytes).ok_or("samples are missing")?;
                columns.push(floats(column, channel.sample_type));
                rest = after;
            }
            let mut start = 0;
            for (x, end) in row.iter().enumerate() {
                let samples = roles.ordered(&columns, start..*end);
                let at = ((self.corner[1] + y) * stride + self.corner[0] + x) * channels;
                if let Some(pixel) = pixels.get_mut(at..at + channels) {
                    roles.composite(&columns, &samples, choice, pixel);
                }
                start = *end;
            }
        }
        Ok(())
    }
}

impl Roles {
    /// The samples of a pixel from front to back.
    fn ordered(&self, columns: &[Vec<f32>], range: std::ops::Range<usize>) -> Vec<usize> {
        let value = |column: Option<usize>, i: usize| {
            column.and_then(|c| columns.get(c)?.get(i)).copied().unwrap_or_default()
        };
        let mut samples: Vec<usize> = range.collect();
        samples.sort_by(|&a, &b| {
            let by = |column| value(column, a).total_cmp(&value(column, b));
            by(self.depth).then_with(|| by(self.back))
        });
        samples
    }

    fn composite(&self, columns: &[Vec<f32>], samples: &[usize], choice: &Choice, pixel: &mut [f32]) {
        let mut passes = 1.0;
        for &sample in samples {
            let value =
                |c: usize| columns.get(c).and_then(|column| column.get(sample)).copied().unwrap_or_default();
            for (c, to) in choice.to.iter().enumerate() {
                if let Some(out) = to.and_then(|to| pixel.get_mut(usize::from(to))) {
                    *out += passes * value(c);
                }
            }
            // Without alpha the first sample hides the others.
            passes *= 1.0 - self.alpha.map_or(1.0, value);
            if passes.is_nan() || passes <= 0.0 {
                break;
            }
        }
    }
}

fn floats(bytes: &[u8], kind: SampleType) -> Vec<f32> {
    match kind {
        SampleType::F16 => bytes.as_chunks::<2>().0.iter().map(|b| f16::from_le_bytes(*b).to_f32()).collect(),
        SampleType::F32 => bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect(),
        SampleType::U32 => bytes.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b) as f32).collect(),
    }
}

/// Decompresses to `size` bytes. Data that did not become fewer bytes are stored as they are.
fn unpack(compression: Compression, packed: &[u8], size: usize) -> Result<Vec<u8>, String> {
    // OpenEXR fills the counts of tiles at the right and at the bottom up to the size of other tiles.
    let is_plain = compression == Compression::Uncompressed && packed.len() > size;
    if packed.len() == size || is_plain {
        return Ok(packed.iter().take(size).copied().collect());
    }
    if size > packed.len().saturating_mul(RATIO) {
        return Err(format!("{size} bytes of samples announced in {} compressed ones", packed.len()));
    }
    let bytes = match compression {
        Compression::RLE => runs(packed, size)?,
        Compression::ZIP1 | Compression::ZIP16 => decompress_zlib(packed, size + 1)?,
        _ => return Err(format!("{} bytes of samples: expected {size}", packed.len())),
    };
    if bytes.len() != size {
        return Err(format!("{} bytes of samples: expected {size}", bytes.len()));
    }
    Ok(interleaved(bytes))
}

/// Run lengths: −n is followed by n bytes, n by a byte that stands for n + 1.
fn runs(packed: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    let mut rest = packed;
    while let Some((&length, after)) = rest.split_first() {
        let length = i32::from(length as i8);
        let count = length.unsigned_abs() as usize;
        if length < 0 {
            let (plain, after) = after.split_at_checked(count).ok_or("runs are truncated")?;
            out.extend_from_slice(plain);
            rest = after;
        } else {
            let (byte, after) = after.split_first().ok_or("runs are truncated")?;
            out.extend(std::iter::repeat_n(*byte, count + 1));
            rest = after;
        }
        if out.len() > size {
            return Err(format!("more than {size} bytes of samples"));
        }
    }
    Ok(out)
}

/// Undoes what makes bytes easier to compress: each but the first is the difference to the one before, plus 128; the
/// first half are those at even places.
fn interleaved(mut bytes: Vec<u8>) -> Vec<u8> {
    let mut last: Option<u8> = None;
    for byte in &mut bytes {
        *byte = last.map_or(*byte, |last| last.wrapping_add(*byte).wrapping_sub(128));
        last = Some(*byte);
    }
    let (even, odd) = bytes.split_at(bytes.len().div_ceil(2));
    let at = |i: usize| if i.is_multiple_of(2) { even.get(i / 2) } else { odd.get(i / 2) };
    (0..bytes.len()).filter_map(at).copied().collect()
}
