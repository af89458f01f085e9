//! Decompression of LZ4 blocks.
//!
//! A block is a list of sequences. Each has a token, whose upper four bits are the number of literal bytes and whose
//! lower four bits are the length of a match less 4; 15 is continued by bytes that are added, up to one that is not
//! 255. After the literals, two bytes tell how far back the match begins. The last sequence has literals only.

/// Shortest match.
const SHORTEST: usize = 4;

/// The decompressed bytes, at most `limit`.
///
/// Errors, as text: damaged data, or more than `limit` bytes.
pub(crate) fn decompress(bytes: &[u8], limit: usize) -> Result<Vec<u8>, String> {
    let damaged = || "LZ4 data are damaged".to_owned();
    let mut out: Vec<u8> = Vec::new();
    let mut rest = bytes;
    while let Some((token, after)) = rest.split_first() {
        rest = after;
        let literals = length(usize::from(token >> 4), &mut rest).ok_or_else(damaged)?;
        let (plain, after) = rest.split_at_checked(literals).ok_or_else(damaged)?;
        rest = after;
        if literals > limit - out.len() {
            return Err(damaged());
        }
        out.extend_from_slice(plain);
        if rest.is_empty() {
            break;
        }
        let ([low, high], after) = rest.split_first_chunk::<2>().ok_or_else(damaged)?;
        rest = after;
        let back = usize::from(u16::from_le_bytes([*low, *high]));
        let run = length(usize::from(token & 15), &mut rest).ok_or_else(damaged)?.saturating_add(SHORTEST);
        if back == 0 || back > out.len() || run > limit - out.len() {
            return Err(damaged());
        }
        // Matches may overlap what they write.
        let from = out.len() - back;
        for i in 0..run {
            let byte = out.get(from + i).copied().ok_or_else(damaged)?;
            out.push(byte);
        }
    }
    Ok(out)
}

/// A length of four bits and the bytes that continue it.
fn length(bits: usize, rest: &mut &[u8]) -> Option<usize> {
    let mut length = bits;
    if bits == 15 {
        loop {
            let (byte, after) = rest.split_first()?;
            *rest = after;
            length = length.checked_add(usize::from(*byte))?;
            if *byte != 255 {
                break;
            }
        }
    }
    Some(length)
}
