use turner::math::DVec3;

use super::decode;
use crate::gzip::decompress_zlib;

/// Written by NanoVDB 32.9 with ZIP: the voxels of [`voxels`], scaled by 0.5 and moved by (1, 2, 3).
const FILE: &[u8] = include_bytes!("../testing/cloud.nvdb");

/// Bytes up to the name of the grid.
const NAME: usize = 16 + 176;
const NAME_BYTES: usize = 8;

/// In nodes on both sides of 0.
fn voxels() -> impl Iterator<Item = ([i32; 3], f32)> {
    (0..60).map(|i: i32| ([i - 30, (7 * i) % 11 - 3, (i * i) % 40], 0.125 * (1 + i % 9) as f32))
}

/// The grid alone, without segments.
fn alone() -> Vec<u8> {
    decompress_zlib(&FILE[NAME + NAME_BYTES + 8..], 1 << 24).unwrap()
}

/// The file with another codec and other stored bytes.
fn stored(codec: u16, bytes: &[u8]) -> Vec<u8> {
    let mut out = FILE[..NAME + NAME_BYTES].to_vec();
    out[14..16].copy_from_slice(&codec.to_le_bytes());
    out[24..32].copy_from_slice(&(bytes.len() as u64).to_le_bytes());
    out.extend(bytes);
    out
}

fn error(bytes: &[u8]) -> String {
    decode(bytes, None, u64::MAX).unwrap_err()
}

fn with<const N: usize>(mut bytes: Vec<u8>, at: usize, value: [u8; N]) -> Vec<u8> {
    bytes[at..at + N].copy_from_slice(&value);
    bytes
}

#[test]
fn every_codec_gives_the_same_grid() {
    // One cell around the voxels -30..=29, -3..=7 and 0..=36.
    let mut expected = vec![0.0; 62 * 13 * 39];
    for ([x, y, z], value) in voxels() {
        expected[((x + 31) + 62 * ((y + 4) + 13 * (z + 1))) as usize] = value;
    }
    let grid = alone();
    // A chunk of Blosc that is stored plainly.
    let size = (grid.len() as u32).to_le_bytes();
    let chunk = [&[2, 1, 2, 4], &size, &size, &(grid.len() as u32 + 16).to_le_bytes(), &grid[..]].concat();
    let chunk = [&(chunk.len() as u64).to_le_bytes(), &chunk[..]].concat();
    let two = [alone(), with(alone(), 40, *b"heat\0\0\0")].concat();
    for (what, file) in [
        ("ZIP", FILE.to_vec()),
        ("none", stored(0, &grid)),
        ("Blosc", stored(2, &chunk)),
        ("the first signature", with(stored(0, &grid), 0, *b"NanoVDB0")),
        ("a grid alone", grid.clone()),
        ("a grid alone with a later signature", with(grid, 0, *b"NanoVDB1")),
        ("two grids", two),
        ("two segments", [FILE, &with(FILE.to_vec(), NAME, *b"heat\0\0\0")].concat()),
    ] {
        let grid = decode(&file, None, u64::MAX).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_eq!(grid.size(), [62, 13, 39], "{what}");
        assert!(grid.density() == expected, "{what}");
        // Voxels are the centres of cells.
        let bounds = [DVec3::new(-14.75, -0.25, 2.25), DVec3::new(16.25, 6.25, 21.75)];
        assert_eq!(grid.bounds(), Some(bounds), "{what}");
        let named = decode(&file, Some("heat"), u64::MAX);
        assert_eq!(named.is_ok(), what.starts_with("two"), "{what}");
    }
}

#[test]
fn tiles_are_filled() {
    // The lower node of the last voxels: its children without a node become tiles of 2.
    let mut grid = alone();
    let tree = 672;
    let lower = i64::from_le_bytes(grid[tree + 8..tree + 16].try_into().unwrap()) as usize + tree;
    let (active, children) = (lower + 32, lower + 544);
    let first = (0..4096usize).find(|i| grid[children + i / 8] >> (i % 8) & 1 == 0).unwrap();
    grid[active + first / 8] |= 1 << (first % 8);
    let at = lower + 1088 + 8 * first;
    grid[at..at + 4].copy_from_slice(&2.0f32.to_le_bytes());
    let before = decode(FILE, None, u64::MAX).unwrap();
    let after = decode(&grid, None, u64::MAX).unwrap();
    let sum = |g: &turner::schema::GridData| g.density().iter().map(|v| f64::from(*v)).sum::<f64>();
    assert!((sum(&after) - sum(&before) - 2.0 * 512.0).abs() < 1e-6);
}

#[test]
fn level_sets_are_signed_distances() {
    let negative = |mut grid: Vec<u8>| {
        let leaf = 672 + i64::from_le_bytes(grid[672..680].try_into().unwrap()) as usize;
        // Where its first active voxel is; inactive ones may lie outside the box of the active ones.
        let is_active = |i: &usize| grid[leaf + 16 + i / 8] >> (i % 8) & 1 == 1;
        let value = leaf + 96 + 4 * (0..512).find(is_active).unwrap();
        grid[value..value + 4].copy_from_slice(&(-0.5f32).to_le_bytes());
        grid
    };
    let class = |class: u32| with(negative(alone()), 632, class.to_le_bytes());
    let fog = decode(&class(2), None, u64::MAX).unwrap();
    assert!(!fog.has_distances() && fog.density().iter().all(|v| *v >= 0.0));
    let distances = decode(&class(1), None, u64::MAX).unwrap();
    assert!(distances.has_distances() && distances.density().contains(&-0.5));
    let [(a, b), (c, d)] = [fog, distances].map(|grid| grid.bounds().map(|[a, b]| (a, b)).unwrap());
    assert_eq!([c - a, b - d], [DVec3::splat(0.25); 2]);
}

#[test]
fn what_cannot_be_read_says_so() {
    let with_grid = |at: usize, value: u32| with(alone(), at, value.to_le_bytes());
    for (file, expected) in [
        (with_grid(636, 15), "(fp16)"),
        (with_grid(636, 6), "(vec3f)"),
        (with_grid(16, 31 << 21 | 3 << 10), "version"),
        (with(stored(0, &alone()), 8, (29u32 << 21).to_le_bytes()), "version 29.0: expected 32"),
        (stored(7, &alone()), "codec 7"),
        (with(alone(), 392, 0.5f64.to_le_bytes()), "rotated or sheared"),
        (with(alone(), 384, f64::NAN.to_le_bytes()), "finite"),
        (with(alone(), 672 + 24, (1i64 << 40).to_le_bytes()), "the file ends"),
        (with(alone(), 672 + 24, i64::MIN.to_le_bytes()), "out of the file"),
    ] {
        let found = error(&file);
        assert!(found.contains(expected), "{found}: expected {expected}");
    }
    assert!(decode(FILE, None, 1000).unwrap_err().contains("at most 1000"));
}

/// What is decompressed counts as well as the cells.
#[test]
fn the_budget_is_for_the_bytes_and_the_cells() {
    let (bytes, cells) = (alone().len() as u64, 4 * 62 * 13 * 39);
    assert!(decode(FILE, None, bytes + cells).is_ok());
    let found = decode(FILE, None, bytes + cells - 1).unwrap_err();
    assert!(found.contains("cells around its active voxels"), "{found}");
    // Stored plainly it is not copied.
    assert!(decode(&stored(0, &alone()), None, bytes.max(cells)).is_ok());
}

/// All children of the root are the same node. Without a check, a small file would hold any number of voxels.
#[test]
fn nodes_that_share_bytes_are_refused() {
    let grid = alone();
    let root = 672 + i64::from_le_bytes(grid[696..704].try_into().unwrap()) as usize;
    let count = u32::from_le_bytes(grid[root + 24..root + 28].try_into().unwrap());
    let mut bad = grid.clone();
    // Append a root with many children that all are the first one of the true root.
    let first = i64::from_le_bytes(grid[root + 72..root + 80].try_into().unwrap()) + root as i64;
    let place = grid.len();
    let children = 500u32;
    bad.extend(&grid[root..root + 64]);
    bad[place + 24..place + 28].copy_from_slice(&children.to_le_bytes());
    for i in 0..u64::from(children) {
        bad.extend(i.to_le_bytes());
        bad.extend((first - place as i64).to_le_bytes());
        bad.extend([0; 16]);
    }
    let size = bad.len() as u64;
    bad[32..40].copy_from_slice(&size.to_le_bytes());
    bad[696..704].copy_from_slice(&(place as i64 - 672).to_le_bytes());
    let found = error(&bad);
    assert!(found.contains("500 nodes of 270400 bytes"), "{found}");
    assert!(count < 500);
}

#[test]
fn damage_is_an_error_and_never_a_panic() {
    for cut in (0..FILE.len()).step_by(7).chain(FILE.len() - 9..FILE.len() - 4) {
        assert!(decode(&FILE[..cut], None, u64::MAX).is_err(), "{cut}");
    }
    let grid = alone();
    let tree = 672;
    let part = |i: usize| {
        let at = tree + 8 * i;
        tree + i64::from_le_bytes(grid[at..at + 8].try_into().unwrap()) as usize
    };
    // The grid, the root, and the beginning, masks and first children of the first node of each level.
    let starts = [(0, 900), (part(3), 200), (part(2), 40), (part(2) + 32 + 4096, 64), (part(1), 1300)];
    for at in starts.iter().flat_map(|(start, length)| *start..start + length).chain(part(0)..part(0) + 100) {
        for flip in [1, 0x80] {
            let mut bad = grid.clone();
            if let Some(byte) = bad.get_mut(at) {
                *byte ^= flip;
            }
            let _ = decode(&bad, None, 1 << 24);
        }
    }
    for at in 0..FILE.len() {
        let mut bad = FILE.to_vec();
        bad[at] ^= 0x10;
        let _ = decode(&bad, None, 1 << 24);
    }
}
