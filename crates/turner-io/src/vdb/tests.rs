use turner::math::DVec3;
use turner::schema::GridData;

use super::{blosc, decode, lz4};
use crate::testing::vdb_seed::{Named, UNIFORM, Vdb, file};

/// Voxels in nodes on both sides of 0, with fractions that halves hold.
fn voxels() -> Vec<([i32; 3], f32)> {
    (0..60).map(|i: i32| ([i - 30, (7 * i) % 11 - 3, (i * i) % 40], 0.125 * (1 + i % 9) as f32)).collect()
}

fn named<'a>(name: &'a str, map: (&'a str, &'a [f64])) -> Named<'a> {
    Named { name, tree: "Tree_float_5_4_3", class: "fog volume", map }
}

fn masked(voxels: &[([i32; 3], f32)]) -> Vdb<'_> {
    Vdb { version: 224, flags: 2, half: false, background: 0.0, voxels, tiles: &[] }
}

/// The value of a cell.
fn cell(grid: &GridData, at: [usize; 3]) -> f32 {
    let [nx, ny, _] = grid.size().map(|n| n as usize);
    grid.density()[at[0] + nx * (at[1] + ny * at[2])]
}

#[test]
fn every_way_to_store_values_gives_the_same_grid() {
    let voxels = voxels();
    // One cell around the voxels -30..=29, -3..=7 and 0..=36. The tile fills -16..=-9, 0..=7 and 16..=23.
    let index = |[x, y, z]: [i32; 3]| ((x + 31) + 62 * ((y + 4) + 13 * (z + 1))) as usize;
    let leaf_of = |at: &[i32; 3]| at.map(|v| v.div_euclid(8));
    assert!(!voxels.iter().any(|(at, _)| leaf_of(at) == [-2, 0, 2]), "the tile has a region of its own");
    let mut expected = vec![0.0; 62 * 13 * 39];
    voxels.iter().for_each(|(at, value)| expected[index(*at)] = *value);
    for x in -16..-8 {
        for y in 0..8 {
            (16..24).for_each(|z| expected[index([x, y, z])] = 2.0);
        }
    }
    for version in [220, 221, 222, 223, 224] {
        for flags in (0..4u32).filter(|flags| version >= 222 || *flags < 2) {
            for half in [false, true] {
                let tiles = &[([-16, 0, 16], 2.0)];
                let vdb = Vdb { version, flags, half, tiles, ..masked(&voxels) };
                let grid = decode(&file(&[(named("density", UNIFORM), vdb)]), None, u64::MAX).unwrap();
                assert_eq!(grid.size(), [62, 13, 39]);
                assert!(grid.density() == expected, "{version} {flags} {half}");
                // Voxels are the centres of cells of 0.5 units.
                let bounds = [DVec3::new(-15.75, -2.25, -0.75), DVec3::new(15.25, 4.25, 18.75)];
                assert_eq!(grid.bounds(), Some(bounds));
            }
        }
    }
}

#[test]
fn transforms_place_the_grid() {
    let voxels = [([0, 0, 0], 1.0), ([3, 0, 0], 2.0)];
    let read = |map| decode(&file(&[(named("density", map), masked(&voxels))]), None, u64::MAX);
    let is = |map, min: [f64; 3], max: [f64; 3]| {
        assert_eq!(read(map).unwrap().bounds(), Some([DVec3::from(min), DVec3::from(max)]));
    };
    is(("TranslationMap", &[1.0, 2.0, 3.0]), [-0.5, 0.5, 1.5], [5.5, 3.5, 4.5]);
    let moved = [&[1.0, 2.0, 3.0, 2.0, 1.0, 4.0][..], &[1.0; 12]].concat();
    is(("ScaleTranslateMap", &moved), [-2.0, 0.5, -3.0], [10.0, 3.5, 9.0]);
    let matrix = |x: [f64; 3], y: [f64; 3], z: [f64; 3]| {
        let row = |r: [f64; 3]| [r[0], r[1], r[2], 0.0];
        [row(x), row(y), row(z), [10.0, 20.0, 30.0, 1.0]].concat()
    };
    let mirrored = matrix([-1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]);
    is(("AffineMap", &mirrored), [5.5, 17.0, 28.5], [11.5, 23.0, 31.5]);
    // The voxel 3 comes first along x.
    let grid = read(("AffineMap", &mirrored)).unwrap();
    assert_eq!([cell(&grid, [1, 1, 1]), cell(&grid, [4, 1, 1])], [2.0, 1.0]);
    let turned = matrix([0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    assert!(read(("AffineMap", &turned)).unwrap_err().contains("is rotated or sheared"));
    assert!(read(("NonlinearFrustumMap", &[1.0; 30])).unwrap_err().contains("NonlinearFrustumMap"));
    assert!(read(("TranslationMap", &[f64::NAN; 3])).unwrap_err().contains("finite"));
}

#[test]
fn a_grid_is_chosen_by_its_name() {
    let (one, two) = ([([0, 0, 0], 1.0)], [([0, 0, 0], 2.0)]);
    let both =
        file(&[(named("heat", UNIFORM), masked(&one)), (named("density\u{1e}1", UNIFORM), masked(&two))]);
    let middle = |file: &[u8], name| decode(file, name, u64::MAX).map(|g| cell(&g, [1, 1, 1]));
    assert_eq!(middle(&both, None), Ok(2.0));
    assert_eq!(middle(&both, Some("heat")), Ok(1.0));
    let error = middle(&both, Some("flames")).unwrap_err();
    assert_eq!(error, "has no grid \"flames\"; its grids: \"heat\" (float), \"density\" (float)");
    let vector = Named { tree: "Tree_vec3s_5_4_3", ..named("v", UNIFORM) };
    let list = file(&[(vector, masked(&one)), (named("a", UNIFORM), masked(&one))]);
    assert!(middle(&list, Some("v")).unwrap_err().contains("\"v\" (vec3s) has no densities"));
    // The only grid of floats.
    assert_eq!(middle(&list, None), Ok(1.0));
    let error = middle(&file(&[(named("e", UNIFORM), masked(&[]))]), None).unwrap_err();
    assert!(error.contains("has no active voxels"), "{error}");
}

#[test]
fn grids_that_are_too_large_are_refused_before_they_are_made() {
    let voxels = [([-2_000_000_000, 0, 0], 1.0), ([2_000_000_000, 5, 2_000_000_000], 1.0)];
    let read = |voxels, budget| {
        decode(&file(&[(named("density", UNIFORM), masked(voxels))]), None, budget).unwrap_err()
    };
    let error = read(&voxels, u64::MAX);
    assert!(error.contains("4000000003 × 8 × 2000000003 cells"), "{error}");
    let error = read(&voxels[..1], 26 * 4);
    assert!(error.contains("3 × 3 × 3 cells around its active voxels: expected at most 26"), "{error}");
}

#[test]
fn values_are_densities() {
    let voxels = [([0, 0, 0], -3.0), ([1, 0, 0], f32::NAN), ([2, 0, 0], f32::INFINITY), ([3, 0, 0], 0.5)];
    let grid = decode(&file(&[(named("density", UNIFORM), masked(&voxels))]), None, u64::MAX).unwrap();
    assert_eq!([1, 2, 3, 4].map(|x| cell(&grid, [x, 1, 1])), [0.0, 0.0, 1e30, 0.5]);
}

/// The distance from a plane, in a band of voxels on both sides of it.
#[test]
fn level_sets_are_signed_distances() {
    let distance = |x: i32| 0.5 * x as f32 - 0.75;
    let band = |at: [i32; 3]| (0..4).contains(&at[0]).then(|| distance(at[0]));
    let voxels: Vec<([i32; 3], f32)> = (-1..5)
        .flat_map(|x| (0..2).flat_map(move |y| (0..2).map(move |z| [x, y, z])))
        .filter_map(|at| Some((at, band(at)?)))
        .collect();
    let vdb = Vdb { background: 2.0, ..masked(&voxels) };
    let level_set = Named { class: "level set", ..named("ls", UNIFORM) };
    let bytes = file(&[(level_set, vdb)]);
    let grid = decode(&bytes, None, u64::MAX).unwrap();
    assert!(grid.has_distances());
    assert_eq!(grid.size(), [6, 4, 4]);
    assert_eq!([1, 2, 3, 4].map(|x| cell(&grid, [x, 1, 1])), [0, 1, 2, 3].map(distance));
    // Beyond the band there is the background. The first and the last voxels lie on the faces of the box.
    assert_eq!([cell(&grid, [0, 1, 1]), cell(&grid, [1, 0, 1])], [2.0, 2.0]);
    assert_eq!(grid.bounds(), Some([DVec3::splat(-0.5), DVec3::new(2.0, 1.0, 1.0)]));
    assert_eq!(grid.vertex_bounds(), grid.bounds());
    let bad = [([0, 0, 0], f32::NAN)];
    let level_set = Named { class: "level set", ..named("ls", UNIFORM) };
    let error = decode(&file(&[(level_set, masked(&bad))]), None, u64::MAX).unwrap_err();
    assert!(error.contains("is NaN"), "{error}");
    // Densities keep half a cell around their voxels.
    let fog = decode(&file(&[(named("fog", UNIFORM), masked(&voxels))]), None, u64::MAX).unwrap();
    assert!(!fog.has_distances() && cell(&fog, [1, 1, 1]) == 0.0);
    assert_eq!(fog.bounds(), Some([DVec3::splat(-0.75), DVec3::new(2.25, 1.25, 1.25)]));
}

#[test]
fn damage_is_an_error_and_never_a_panic() {
    let good = crate::testing::vdb_seed::seed();
    assert!(decode(&good, None, u64::MAX).is_ok());
    for cut in (0..good.len()).step_by(7).chain(good.len() - 200..good.len()) {
        assert!(decode(&good[..cut], None, u64::MAX).is_err(), "{cut}");
    }
    // Masks take most of the bytes.
    for at in (0..500).chain((500..good.len()).step_by(61)) {
        for flip in [1, 0x80] {
            let mut bad = good.clone();
            bad[at] ^= flip;
            let _ = decode(&bad, None, 1 << 24);
        }
    }
}

/// Chunks of c-blosc at level 9: 512 singles (i² mod 97) / 8 with shuffled bytes, by LZ4 and by Deflate.
const LZ4: &str = "020121040008000000080000f6000000140000000c0000001f000100ffe85000000000000c0000001f000100ffe850000000\
     00006d000000ff5200000090004890c40022c040bc108078f83e840cc0d440b036ac3cc880025830d83032f48cb02c04c080\
     10403a2a1e161212161e2a3a401080c0042cb08cf43230d830580280c83cac36b040d4c00c843ef8788010bc40c02200c490\
     48009000006100ff885040b036ac3c4d000000d1003e3f3f4040404041413e404004003040413f0500804041403f41404140\
     0300413f41414006000402000033000106000120000b3100113e04000032004f403f3f3e6100ff88504140414041";
const DEFLATE: &str = "020161040008000000080000ea000000140000000e00000078da6360180523190000020000010e00000078da636018052319\
     0000020000017000000078da63606098c0e031e10883d201873d020d153fec5a780e5c71d860b6c6e644035384c10d03a32f\
     3d1b74580e3408385869c989090989c969593908341c60d1d9d0f3c508a82082a9e184cd1ab30d0e570ef0b4d8fda86810d8\
     e3704089e1c8040fa0d120306ac1e0b50000588fbfbb3a00000078daed8dc10d003008029dccc3fd97aad8f4d309fa28c87d\
     0c2112d4aaca86a3c26863f8a88679c434d0fe5f859cb821c8f8032f0f2cf3f27ebc";
/// 64 bytes (7919 i / 8) mod 256, which did not become fewer.
const PLAIN: &str = "0201330440000000400000005000000000ddbb9977553311efccaa8866442200debb9977553311efcdaa8866442200\
     debc9977553311efcdab8866442200debc9a77553311efcdab8966442200debc9a";

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|i| u8::from_str_radix(&hex[i..i + 2], 16).unwrap()).collect()
}

#[test]
fn chunks_of_blosc_are_decompressed() {
    let singles: Vec<u8> = (0..512).flat_map(|i: u32| ((i * i % 97) as f32 / 8.0).to_le_bytes()).collect();
    for chunk in [LZ4, DEFLATE] {
        let chunk = bytes(chunk);
        assert_eq!(blosc::decompress(&chunk, 2048).unwrap(), singles);
        assert!(blosc::decompress(&chunk, 2047).is_err());
        for at in 0..chunk.len() {
            assert!(blosc::decompress(&chunk[..at], 2048).is_err(), "{at}");
            let mut bad = chunk.clone();
            bad[at] ^= 0x41;
            let _ = blosc::decompress(&bad, 2048);
        }
    }
    let plain: Vec<u8> = (0..64u32).map(|i| (7919 * i / 8) as u8).collect();
    assert_eq!(blosc::decompress(&bytes(PLAIN), 64).unwrap(), plain);
}

#[test]
fn blocks_of_lz4_are_decompressed() {
    // Literals "ab", a match of 9 bytes two back, then the literal "c".
    let block = [0x25, b'a', b'b', 2, 0, 0x10, b'c'];
    assert_eq!(lz4::decompress(&block, 12).unwrap(), b"abababababac");
    assert!(lz4::decompress(&block, 11).is_err());
    assert!(lz4::decompress(&[0x25, b'a', b'b', 3, 0], 100).is_err());
    assert!(lz4::decompress(&[0xf0, 255, 255], 1000).is_err());
}
