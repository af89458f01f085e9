//! Decompression of a mip level: Zstandard (RFC 8878) and ZLIB (RFC 1950).

use super::container::{Container, Supercompression};
use super::fault::{Fault, Outcome, list};
use crate::gzip::decompress_zlib;
use ruzstd::decoding::StreamingDecoder;
use std::borrow::Cow;
use std::io::Read;

/// Largest window of a Zstandard frame for any image, in bytes.
const WINDOW: u64 = 8 << 20;

/// The first `needed` bytes of level 0, which are those of its first image.
pub(super) fn bytes_of<'a>(container: &Container<'a>, needed: usize) -> Outcome<Cow<'a, [u8]>> {
    let short = |found: u64| {
        Fault::damaged(format!(
            "level 0 has {found} bytes; {} x {} pixels need {needed}",
            container.width, container.height
        ))
    };
    if container.supercompression == Supercompression::None {
        let found = container.level.len() as u64;
        return container.level.get(..needed).map(Cow::Borrowed).ok_or_else(|| short(found));
    }
    if container.decompressed < needed as u64 {
        return Err(short(container.decompressed));
    }
    if container.supercompression == Supercompression::Zlib {
        // All layers are one stream.
        let limit = usize::try_from(container.decompressed).unwrap_or(usize::MAX).max(needed);
        let most = needed.saturating_mul(usize::try_from(container.images).unwrap_or(usize::MAX)).min(limit);
        let mut bytes = decompress_zlib(container.level, most)
            .map_err(|problem| Fault::damaged(format!("level 0 {problem}")))?;
        let found = bytes.len() as u64;
        bytes.truncate(needed);
        return if bytes.len() == needed { Ok(Cow::Owned(bytes)) } else { Err(short(found)) };
    }
    let damaged = |problem: String| Fault::damaged(format!("level 0, Zstandard: {problem}"));
    let window = (needed as u64).saturating_mul(2).max(WINDOW);
    let mut decoder = StreamingDecoder::new_with_max_window_size(skip_frames(container.level), window)
        .map_err(|error| damaged(error.to_string()))?;
    let mut bytes = list(needed)?;
    decoder.read_exact(&mut bytes).map_err(|error| damaged(error.to_string()))?;
    Ok(Cow::Owned(bytes))
}

/// The bytes from the first frame that holds data; skippable frames may precede it (RFC 8878 §3.1.2).
fn skip_frames(mut bytes: &[u8]) -> &[u8] {
    while let &[magic, 0x2a, 0x4d, 0x18, a, b, c, d, ref rest @ ..] = bytes
        && magic >> 4 == 5
    {
        bytes = rest.get(u32::from_le_bytes([a, b, c, d]) as usize..).unwrap_or_default();
    }
    bytes
}
