//! Trees of all sorts of primitives, each checked from top to bottom.

use super::validate::validate;
use super::*;

fn random(seed: &mut u64) -> f32 {
    *seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *seed;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
}

#[test]
fn a_first_tree() {
    let mut seed = 1;
    for n in [0, 1, 2, 3, 4, 5, 9, 33, 100, 1000, 10_000, 100_000] {
        let positions: Vec<[f32; 3]> = (0..n).flat_map(|_| {
            let c = [0; 3].map(|_| random(&mut seed));
            [0; 3].map(|_| c.map(|x| x + 0.01 * random(&mut seed)))
        }).collect();
        let triangles: Vec<[u32; 3]> = (0..n).map(|i| [0, 1, 2].map(|k| i * 3 + k)).collect();
        let source = Source::Triangles { positions: &positions, triangles: &triangles, scale: 1.0 };
        for quality in [Quality::Fast, Quality::Balanced, Quality::High] {
            let tree = build(&source, &BuildOptions { quality, threads: 1, ..Default::default() }).unwrap();
            validate(&tree, &source, quality != Quality::High).unwrap_or_else(|e| panic!("{n}: {e}"));
            let other = build(&source, &BuildOptions { quality, threads: 3, ..Default::default() }).unwrap();
            assert!(tree == other);
        }
    }
}
