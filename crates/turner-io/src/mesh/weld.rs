//! Vertex welding: merges equal triples of 32-bit values, such as positions, or corners with (u, v).
//!
//! STL and similar formats repeat each vertex in every triangle. An open-addressing hash table, at most half full,
//! maps each triple to the index of its first occurrence, so n corners take O(n) time. Triples are equal only if all
//! bits are (−0 and 0 count as equal positions); no tolerance is used.
//!
//! Probing stops after a fixed number of slots: a file crafted to produce collisions then leaves some duplicates, but
//! takes no more time.

use super::MeshError;
use super::error::{push, reserve};

/// Marks an empty slot.
const EMPTY: u32 = u32::MAX;
/// Most slots that are probed for one triple.
const PROBES: usize = 64;

/// Numbers distinct triples in the order of first occurrence.
pub(super) struct Welder {
    pub(super) keys: Vec<[u32; 3]>,
    table: Vec<u32>,
}

impl Welder {
    pub(super) fn new() -> Welder {
        Welder { keys: Vec::new(), table: Vec::new() }
    }

    /// The index of a position; −0 counts as 0.
    #[inline]
    pub(super) fn vertex(&mut self, position: [f32; 3], name: &str) -> Result<u32, MeshError> {
        self.number(position.map(|v| (v + 0.0).to_bits()), name)
    }

    /// The index of a triple.
    #[inline]
    pub(super) fn number(&mut self, key: [u32; 3], name: &str) -> Result<u32, MeshError> {
        if 2 * self.keys.len() >= self.table.len() {
            self.grow(name)?;
        }
        let mask = self.table.len() - 1;
        let start = hash(key);
        let new = self.keys.len() as u32;
        for i in 0..PROBES {
            let slot = &mut self.table[start.wrapping_add(i) & mask];
            if *slot == EMPTY {
                *slot = new;
                break;
            }
            if self.keys[*slot as usize] == key {
                return Ok(*slot);
            }
        }
        push(&mut self.keys, key, name)?;
        Ok(new)
    }

    /// The positions of [`Welder::vertex`].
    pub(super) fn into_positions(self) -> Vec<[f32; 3]> {
        self.keys.into_iter().map(|k| k.map(f32::from_bits)).collect()
    }

    fn grow(&mut self, name: &str) -> Result<(), MeshError> {
        let places = (2 * self.table.len()).max(1024);
        self.table = Vec::new();
        reserve(&mut self.table, places, name)?;
        self.table.resize(places, EMPTY);
        for (i, key) in self.keys.iter().enumerate() {
            let start = hash(*key);
            let mut tried = (0..PROBES).map(|k| start.wrapping_add(k) & (places - 1));
            if let Some(at) = tried.find(|&at| self.table[at] == EMPTY) {
                self.table[at] = i as u32;
            }
        }
        Ok(())
    }
}

/// Hashes a triple so that every input bit affects every output bit: MurmurHash3's finaliser over a sum with odd
/// factors.
fn hash([x, y, z]: [u32; 3]) -> usize {
    let mut h = u64::from(x).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ u64::from(y).wrapping_mul(0xc2b2_ae3d_27d4_eb4f).rotate_left(21)
        ^ u64::from(z).wrapping_mul(0x1656_67b1_9e37_79f9).rotate_left(42);
    h = (h ^ (h >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
    h = (h ^ (h >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    (h ^ (h >> 33)) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_bits_are_one_vertex() {
        let mut welder = Welder::new();
        let grid = |i: u32| [(i % 100) as f32 * 0.1, (i / 100 % 100) as f32 * 0.1, 0.0];
        for _ in 0..3 {
            for i in 0..10_000 {
                assert_eq!(welder.vertex(grid(i), "").unwrap(), i);
            }
        }
        assert_eq!(welder.keys.len(), 10_000);
        assert_eq!(welder.vertex([-0.0, 0.0, -0.0], "").unwrap(), 0);
        let beside = welder.vertex([0.1_f32.next_up(), 0.0, 0.0], "").unwrap();
        assert_eq!(beside, 10_000);
        assert_eq!(welder.vertex([f32::NAN; 3], "").unwrap(), welder.vertex([f32::NAN; 3], "").unwrap());
    }
}
