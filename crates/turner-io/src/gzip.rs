//! Decompression of gzip (RFC 1952; one or more members) and zlib (RFC 1950).

use miniz_oxide::inflate::core::DecompressorOxide;
use miniz_oxide::inflate::core::inflate_flags::TINFL_FLAG_USING_NON_WRAPPING_OUTPUT_BUF as WHOLE;
use miniz_oxide::inflate::{TINFLStatus, core};

/// Whether the bytes begin with the gzip signature.
pub(crate) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// The decompressed bytes, at most `limit` of them.
///
/// Errors, as text: damaged data, or more than `limit` bytes.
pub(crate) fn decompress(bytes: &[u8], limit: usize) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    let mut rest = bytes;
    while is_gzip(rest) {
        rest = member(rest, &mut out, limit)?;
    }
    if out.is_empty() && !is_gzip(bytes) {
        return Err("is not gzip data".into());
    }
    Ok(out)
}

/// Appends the decompressed bytes of one member and returns the input after it.
fn member<'a>(bytes: &'a [u8], out: &mut Vec<u8>, limit: usize) -> Result<&'a [u8], String> {
    let cut = || "its gzip header is truncated".to_owned();
    let (&flags, mut rest) = (bytes.get(3).ok_or_else(cut)?, bytes.get(10..).ok_or_else(cut)?);
    if bytes.get(2) != Some(&8) {
        return Err("uses an unknown compression method".into());
    }
    if flags & 4 != 0 {
        let len =
            usize::from(u16::from_le_bytes([*rest.first().ok_or_else(cut)?, *rest.get(1).ok_or_else(cut)?]));
        rest = rest.get(2 + len..).ok_or_else(cut)?;
    }
    for flag in [8, 16] {
        if flags & flag != 0 {
            let end = rest.iter().position(|b| *b == 0).ok_or_else(cut)?;
            rest = rest.get(end + 1..).ok_or_else(cut)?;
        }
    }
    if flags & 2 != 0 {
        rest = rest.get(2..).ok_or_else(cut)?;
    }
    let start = out.len();
    let rest = inflate(rest, out, limit)?;
    let size = rest.get(4..8).and_then(|s| s.try_into().ok()).map(u32::from_le_bytes);
    if size != Some((out.len() - start) as u32) {
        return Err("its length differs from the one in its trailer".into());
    }
    Ok(rest.get(8..).unwrap_or_default())
}

/// Decompresses zlib data (RFC 1950), at most `limit` bytes. The checksum at the end is not verified.
///
/// Errors, as text: damaged data, or more than `limit` bytes.
pub(crate) fn decompress_zlib(bytes: &[u8], limit: usize) -> Result<Vec<u8>, String> {
    let rest = match bytes {
        [method, flags, rest @ ..] if method & 15 == 8 && flags & 32 == 0 => rest,
        _ => return Err("is not zlib data".into()),
    };
    let mut out = Vec::new();
    inflate(rest, &mut out, limit)?;
    Ok(out)
}

/// Appends decompressed deflate data and returns the input after it.
fn inflate<'a>(mut rest: &'a [u8], out: &mut Vec<u8>, limit: usize) -> Result<&'a [u8], String> {
    let start = out.len();
    let mut inflate = Box::<DecompressorOxide>::default();
    let mut at = start;
    // Deflate expands at most 1032 times; the buffer grows as needed.
    let mut room = rest.len().saturating_mul(4).clamp(1 << 12, 1 << 26);
    loop {
        let wanted = out.len().saturating_add(room).min(limit);
        if wanted <= at {
            return Err(format!("holds more than {limit} bytes"));
        }
        out.try_reserve_exact(wanted - out.len())
            .map_err(|_| "there is not enough memory to decompress it".to_owned())?;
        out.resize(wanted, 0);
        let (status, used, written) = core::decompress(&mut inflate, rest, out, at, WHOLE);
        rest = rest.get(used..).unwrap_or_default();
        at += written;
        match status {
            TINFLStatus::Done => break,
            TINFLStatus::HasMoreOutput => room = room.saturating_mul(2).min(1 << 28),
            _ => return Err("its compressed data is damaged or truncated".into()),
        }
    }
    out.truncate(at);
    Ok(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packed(data: &[u8]) -> Vec<u8> {
        let mut out = vec![0x1f, 0x8b, 8, 8, 0, 0, 0, 0, 0, 0, b'a', 0];
        out.extend(miniz_oxide::deflate::compress_to_vec(data, 6));
        out.extend([0; 4]);
        out.extend((data.len() as u32).to_le_bytes());
        out
    }

    #[test]
    fn what_is_packed_comes_back() {
        let data: Vec<u8> = (0..300_000_u32).map(|i| (i.wrapping_mul(i) >> 7) as u8).collect();
        assert_eq!(decompress(&packed(&data), 1 << 20).unwrap(), data);
        let twice = [packed(b"one "), packed(b"two")].concat();
        assert_eq!(decompress(&twice, 100).unwrap(), b"one two");
        assert_eq!(decompress(&packed(b""), 100).unwrap(), b"");
    }

    #[test]
    fn damage_and_bombs_are_refused() {
        let bomb = packed(&vec![0; 1 << 24]);
        assert!(bomb.len() < 20_000);
        assert!(decompress(&bomb, 1 << 20).unwrap_err().contains("more than"));
        let good = packed(b"some text that is long enough to be cut anywhere");
        for end in 0..good.len() {
            assert!(decompress(&good[..end], 1 << 20).is_err(), "{end}");
        }
        for at in 0..good.len() {
            let mut bad = good.clone();
            bad[at] ^= 0x55;
            let _ = decompress(&bad, 1 << 20);
        }
    }
}
