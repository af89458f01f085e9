//! The container: header, level index, data format descriptor and key/value data (KTX 2.0 §3).

use super::fault::{Fault, Outcome};

/// The first bytes of a file.
pub(in crate::image) const SIGNATURE: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";

/// Bytes of the header with its index.
const HEADER: usize = 80;
/// Bytes of an entry of the level index.
const LEVEL: usize = 24;
/// Most key/value pairs that are looked at; the specification defines about a dozen.
const MOST_PAIRS: usize = 1000;

/// How the levels are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Supercompression {
    None,
    BasisLz,
    Zstandard,
    Zlib,
}

/// What the data format descriptor says. The numbers are those of the Khronos Data Format Specification.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Descriptor {
    pub(super) model: u8,
    pub(super) transfer: u8,
    /// Whether colours are multiplied by alpha.
    pub(super) is_premultiplied: bool,
    /// The channel of the first sample, and that of the second.
    pub(super) channels: (u8, Option<u8>),
}

/// What a sample of a pixel shows, by `KTXswizzle`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shown {
    /// The stored channel of this index.
    Channel(usize),
    Zero,
    One,
}

/// A file whose header is read.
#[derive(Debug)]
pub(super) struct Container<'a> {
    /// Vulkan's number of the format, 0 for those of Basis Universal.
    pub(super) format: u32,
    pub(super) width: u32,
    pub(super) height: u32,
    /// Number of images in all levels, layers and faces.
    pub(super) images: u64,
    pub(super) supercompression: Supercompression,
    pub(super) descriptor: Descriptor,
    /// Whether columns are stored from right to left, and rows from the bottom.
    pub(super) is_flipped: (bool, bool),
    pub(super) swizzle: Option<[Shown; 4]>,
    /// The bytes of level 0, as stored.
    pub(super) level: &'a [u8],
    /// The size that level 0 has when decompressed; 0 for BasisLZ.
    pub(super) decompressed: u64,
    /// The global data of BasisLZ.
    pub(super) global: &'a [u8],
}

/// A little-endian number at a position.
fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|four| u32::from_le_bytes(*four))
}

fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    bytes.get(at..)?.first_chunk().map(|eight| u64::from_le_bytes(*eight))
}

/// A part of the file.
fn part<'a>(bytes: &'a [u8], at: u64, len: u64, what: &str) -> Outcome<&'a [u8]> {
    let end = at.checked_add(len).and_then(|end| usize::try_from(end).ok());
    end.and_then(|end| bytes.get(at as usize..end)).ok_or_else(|| {
        let file = bytes.len();
        Fault::damaged(format!("{what} of {len} bytes at {at} reaches beyond the file of {file} bytes"))
    })
}

impl<'a> Container<'a> {
    /// Reads everything but the pixels.
    pub(super) fn read(bytes: &'a [u8]) -> Outcome<Container<'a>> {
        let header = bytes.get(..HEADER).ok_or_else(|| Fault::damaged("the file ends inside the header"))?;
        if !header.starts_with(SIGNATURE) {
            return Err(Fault::damaged("the file does not begin with the signature of KTX 2.0"));
        }
        let number = |at: usize| u32_at(header, at).unwrap_or(0);
        let (format, width, height) = (number(12), number(20), number(24));
        let (depth, layers, faces, levels) = (number(28), number(32), number(36), number(40));
        let supercompression = match number(44) {
            0 => Supercompression::None,
            1 => Supercompression::BasisLz,
            2 => Supercompression::Zstandard,
            3 => Supercompression::Zlib,
            other => {
                let found = format!("supercompression scheme {other}");
                return Err(Fault::unsupported(found, "none, BasisLZ, Zstandard or ZLIB"));
            }
        };
        match (depth, faces) {
            (0, 1) => {}
            (0, 6) => return Err(Fault::unsupported("a cube map", "one 2-D image")),
            (1.., 1) => return Err(Fault::unsupported("a 3-D texture", "one 2-D image")),
            _ => return Err(Fault::damaged(format!("{faces} faces; expected 1 or 6"))),
        }
        if levels > 32 {
            return Err(Fault::damaged(format!("{levels} mip levels; expected at most 32")));
        }
        let images = u64::from(levels.max(1)) * u64::from(layers.max(1));
        let index = bytes.get(HEADER..HEADER + LEVEL);
        let index = index.ok_or_else(|| Fault::damaged("the file ends inside the level index"))?;
        let entry = |at: usize| u64_at(index, at).unwrap_or(0);
        let level = part(bytes, entry(0), entry(8), "level 0")?;
        let pairs = part(bytes, number(56).into(), number(60).into(), "the key/value data")?;
        let (at, len) = (u64_at(header, 64).unwrap_or(0), u64_at(header, 72).unwrap_or(0));
        let descriptor = part(bytes, number(48).into(), number(52).into(), "the data format descriptor")?;
        let mut container = Container {
            format,
            width,
            height: height.max(1),
            images,
            supercompression,
            descriptor: descriptor_of(descriptor)?,
            is_flipped: (false, false),
            swizzle: None,
            level,
            decompressed: entry(16),
            global: if len == 0 { &[] } else { part(bytes, at, len, "the global data")? },
        };
        container.read_pairs(pairs)?;
        Ok(container)
    }

    /// Reads the key/value pairs that matter: orientation, swizzle, animation.
    fn read_pairs(&mut self, mut rest: &[u8]) -> Outcome<()> {
        for _ in 0..MOST_PAIRS {
            let Some(len) = u32_at(rest, 0) else { return Ok(()) };
            let len = len as usize;
            let pair = len.checked_add(4).and_then(|end| rest.get(4..end));
            let pair = pair.ok_or_else(|| Fault::damaged("the key/value data is truncated"))?;
            let mut parts = pair.splitn(2, |byte| *byte == 0);
            let (key, value) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
            let value = value.strip_suffix(b"\0").unwrap_or(value);
            match key {
                b"KTXorientation" => self.is_flipped = flips(value)?,
                b"KTXswizzle" => self.swizzle = Some(swizzle(value)?),
                b"KTXanimData" => return Err(Fault::unsupported("an animation", "a still image")),
                _ => {}
            }
            rest = rest.get((4 + len).next_multiple_of(4)..).unwrap_or_default();
        }
        Ok(())
    }
}

/// Whether columns and rows are reversed: `rd` is right and down, `lu` left and up.
fn flips(value: &[u8]) -> Outcome<(bool, bool)> {
    match value {
        b"rd" | b"r" => Ok((false, false)),
        b"ru" => Ok((false, true)),
        b"ld" | b"l" => Ok((true, false)),
        b"lu" => Ok((true, true)),
        other => {
            let text = String::from_utf8_lossy(other.get(..8).unwrap_or(other)).into_owned();
            Err(Fault::damaged(format!("KTXorientation \"{text}\"; expected rd, ru, ld or lu")))
        }
    }
}

fn swizzle(value: &[u8]) -> Outcome<[Shown; 4]> {
    let fault = || Fault::damaged("KTXswizzle; expected four of r, g, b, a, 0 and 1");
    let value: &[u8; 4] = value.try_into().map_err(|_| fault())?;
    let mut shown = [Shown::Zero; 4];
    for (shown, letter) in shown.iter_mut().zip(value) {
        *shown = match letter {
            b'r' => Shown::Channel(0),
            b'g' => Shown::Channel(1),
            b'b' => Shown::Channel(2),
            b'a' => Shown::Channel(3),
            b'0' => Shown::Zero,
            b'1' => Shown::One,
            _ => return Err(fault()),
        };
    }
    Ok(shown)
}

/// Reads the basic descriptor block: the size of all blocks, a header of 24 bytes, samples of 16 bytes.
fn descriptor_of(bytes: &[u8]) -> Outcome<Descriptor> {
    let fault = || Fault::damaged("the data format descriptor is truncated");
    let block = bytes.get(4..).ok_or_else(fault)?;
    let &[kind_0, kind_1, kind_2, kind_3, _, _, size_0, size_1, model, _, transfer, flags, ..] = block else {
        return Err(fault());
    };
    if [kind_0, kind_1, kind_2, kind_3] != [0; 4] {
        return Err(Fault::damaged("the data format descriptor does not begin with a basic block"));
    }
    let size = usize::from(u16::from_le_bytes([size_0, size_1]));
    let samples = block.get(24..size).unwrap_or_default().as_chunks::<16>().0;
    let channel = |i: usize| samples.get(i).map(|sample| sample[3] & 15);
    let channels = (channel(0).unwrap_or(0), channel(1));
    Ok(Descriptor { model, transfer, is_premultiplied: flags & 1 == 1, channels })
}
