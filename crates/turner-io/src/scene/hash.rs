//! The hash that identifies the inputs of a picture. It is stable across machines and versions, and not
//! cryptographic.

/// A 128-bit hash over a sequence of byte blobs. The boundaries between blobs count.
#[derive(Clone, Debug)]
pub(crate) struct SceneHash {
    a: u64,
    b: u64,
}

const K: [u64; 4] =
    [0xa076_1d64_78bd_642f, 0xe703_7ed1_a0b4_28db, 0x8ebc_6af0_9c88_c6e3, 0x5899_65cc_7537_4cc3];

fn fold(x: u64, y: u64) -> u64 {
    let product = u128::from(x) * u128::from(y);
    (product as u64) ^ (product >> 64) as u64
}

impl SceneHash {
    pub(crate) fn new() -> SceneHash {
        SceneHash { a: K[0], b: K[1] }
    }

    fn mix(&mut self, x: u64, y: u64) {
        // The rotated old state stays in, so that no block can cancel what came before it.
        self.a = fold(self.a ^ x ^ K[1], y ^ K[2]) ^ self.a.rotate_left(29);
        self.b = fold(self.b ^ y ^ K[3], x ^ K[0]).wrapping_add(self.b.rotate_left(37)) ^ K[2];
    }

    /// Adds one blob; `kind` distinguishes texts, overrides, images and meshes.
    pub(crate) fn add(&mut self, kind: u8, bytes: &[u8]) {
        self.mix(u64::from(kind) ^ 0x7475_726e_6572, bytes.len() as u64);
        let mut blocks = bytes.chunks_exact(16);
        for block in &mut blocks {
            let (x, y) = block.split_at(8);
            self.mix(word(x), word(y));
        }
        let mut last = [0; 16];
        last[..blocks.remainder().len()].copy_from_slice(blocks.remainder());
        self.mix(word(&last[..8]), word(&last[8..]));
    }

    /// 32 hexadecimal digits.
    pub(crate) fn hex(&self) -> String {
        let mut end = self.clone();
        for k in K {
            end.mix(end.b ^ k, end.a);
        }
        format!("{:016x}{:016x}", end.a, end.b)
    }
}

fn word(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |w, &b| w << 8 | u64::from(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    fn of(blobs: &[&[u8]]) -> String {
        let mut hash = SceneHash::new();
        blobs.iter().for_each(|b| hash.add(0, b));
        hash.hex()
    }

    #[test]
    fn every_bit_and_every_border_counts() {
        let mut seen = HashSet::new();
        for len in 0..70 {
            let mut bytes = vec![0; len];
            assert!(seen.insert(of(&[&bytes])));
            for bit in 0..len * 8 {
                bytes[bit / 8] ^= 1 << (bit % 8);
                assert!(seen.insert(of(&[&bytes])), "{len} {bit}");
                bytes[bit / 8] ^= 1 << (bit % 8);
            }
        }
        assert_ne!(of(&[b"ab", b"c"]), of(&[b"a", b"bc"]));
        assert_ne!(of(&[b"ab"]), of(&[b"ab", b""]));
    }

    #[test]
    fn the_hash_of_a_text_never_changes() {
        assert_eq!(of(&[b"[film]\nwidth = 4\n"]).len(), 32);
    }
}
