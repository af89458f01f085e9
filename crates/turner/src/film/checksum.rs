//! A hash that detects damage.

/// The hash at the end of a film's bytes, over all bytes before it. It detects damage but not forgery. Each step
/// is a bijection of the state for any word, and of the word for any state. So two inputs of equal length that
/// differ only within one aligned group of eight bytes never have the same hash.
pub fn checksum(bytes: &[u8]) -> u64 {
    let mut state = bytes.len() as u64 ^ 0x9e37_79b9_7f4a_7c15;
    for chunk in bytes.chunks(8) {
        let mut word = [0; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        state = (state ^ u64::from_le_bytes(word)).wrapping_mul(0xff51_afd7_ed55_8ccd);
        state ^= state >> 32;
    }
    state = state.wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    state ^ state >> 29
}
