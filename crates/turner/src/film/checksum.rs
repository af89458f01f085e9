//! A hash that detects damage.

/// The hash at the end of a film's bytes, over all bytes before it. It detects damage but not forgery. Each step
/// is a bijection of the state for any word, and of the word for any state. So two inputs of equal length that
/// differ only within one aligned group of eight bytes never have the same hash.
pub fn checksum(bytes: &[u8]) -> u64 {
    let mut sum = Checksum::new(bytes.len() as u64);
    sum.add(bytes);
    sum.finish()
}

/// A [`checksum`] of bytes that come in pieces.
#[derive(Clone, Debug)]
pub struct Checksum {
    state: u64,
    /// The first bytes of the next word.
    word: [u8; 8],
    filled: usize,
}

impl Checksum {
    /// For `length` bytes in all.
    pub fn new(length: u64) -> Checksum {
        Checksum { state: length ^ 0x9e37_79b9_7f4a_7c15, word: [0; 8], filled: 0 }
    }

    /// Adds the next bytes.
    pub fn add(&mut self, mut bytes: &[u8]) {
        if self.filled > 0 {
            let (first, rest) = bytes.split_at(bytes.len().min(8 - self.filled));
            self.word[self.filled..self.filled + first.len()].copy_from_slice(first);
            self.filled += first.len();
            bytes = rest;
            if self.filled < 8 {
                return;
            }
            self.step(u64::from_le_bytes(self.word));
        }
        let (words, rest) = bytes.as_chunks();
        words.iter().for_each(|word| self.step(u64::from_le_bytes(*word)));
        self.word = [0; 8];
        self.word[..rest.len()].copy_from_slice(rest);
        self.filled = rest.len();
    }

    fn step(&mut self, word: u64) {
        let state = (self.state ^ word).wrapping_mul(0xff51_afd7_ed55_8ccd);
        self.state = state ^ state >> 32;
    }

    /// The checksum of all bytes.
    pub fn finish(mut self) -> u64 {
        if self.filled > 0 {
            self.step(u64::from_le_bytes(self.word));
        }
        let state = self.state.wrapping_mul(0xc4ce_b9fe_1a85_ec53);
        state ^ state >> 29
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_have_the_checksum_of_the_whole() {
        let bytes: Vec<u8> = (0..1003u32).map(|i| (i * 37 + i / 7) as u8).collect();
        for piece in [1, 3, 8, 13, 500, 2000] {
            let mut sum = Checksum::new(bytes.len() as u64);
            bytes.chunks(piece).for_each(|part| sum.add(part));
            assert_eq!(sum.finish(), checksum(&bytes), "{piece}");
        }
        assert_ne!(checksum(&bytes[1..]), checksum(&bytes));
    }
}
