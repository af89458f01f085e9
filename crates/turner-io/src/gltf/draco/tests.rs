//! Streams of the reference encoder, as they are and damaged, and streams that are made here.

use super::rans::symbols;
use super::*;

/// FNV-1a.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, byte| (h ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

fn hex(text: &str) -> Vec<u8> {
    let digit = |b: u8| char::from(b).to_digit(16).unwrap() as u8;
    text.as_bytes().chunks(2).map(|pair| digit(pair[0]) << 4 | digit(pair[1])).collect()
}

/// Name, stream and hash of the decoded mesh.
fn vectors() -> Vec<(&'static str, Vec<u8>, u64)> {
    let lines = include_str!("vectors.txt").lines().filter(|line| !line.starts_with('#'));
    let vector = |line: &'static str| {
        let words: Vec<&str> = line.split(' ').collect();
        (words[0], hex(words[1]), u64::from_str_radix(words[2], 16).unwrap())
    };
    lines.map(vector).collect()
}

fn decoded(bytes: &[u8]) -> Outcome<Mesh> {
    decode(bytes, &Budget::of_file(0), "/p")
}

/// The error of a damaged stream.
fn refusal(bytes: &[u8]) -> String {
    decoded(bytes).unwrap_err().in_file("a.glb").message
}

/// The bits of value `i`.
fn bits(data: &Data, i: usize) -> u32 {
    data.float(i).map_or_else(|| data.integer(i).unwrap() as u32, f32::to_bits)
}

/// The hash of the number of points, the faces, and of each attribute its id, width and the values of the points, as
/// little-endian 32-bit words.
fn digest(mesh: &Mesh) -> u64 {
    let mut words = vec![mesh.points as u32];
    words.extend(mesh.faces.as_flattened());
    let mut attributes: Vec<&Attribute> = mesh.attributes.iter().collect();
    attributes.sort_by_key(|a| a.id);
    for attribute in attributes {
        words.extend([attribute.id, attribute.width as u32]);
        let values = (0..mesh.points).flat_map(|point| attribute.values(point));
        words.extend(values.map(|i| bits(&attribute.data, i)));
    }
    hash(&words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>())
}

#[test]
fn every_method_gives_the_bits_of_the_reference_decoder() {
    let vectors = vectors();
    assert_eq!(vectors.len(), 19);
    for (name, stream, expected) in vectors {
        let mesh = decoded(&stream).unwrap_or_else(|fault| panic!("{name}: {fault:?}"));
        assert_eq!(digest(&mesh), expected, "{name}");
    }
}

/// The encoder rearranges vertices and faces, but loses no integer: each mesh has the faces of its formula, with the
/// vertices (3a, 2b, ab mod 7) for integers a and b modulo N and M.
#[test]
fn integer_positions_are_those_that_were_encoded() {
    let mut compared = 0;
    for (name, stream, _) in vectors() {
        let (n, m, holes) = match name.split_once('-').unwrap() {
            ("torus", "sequential-raw") | ("holes", _) => (9, 7, true),
            ("torus", _) => (8, 6, false),
            ("large", _) => (36, 16, false),
            ("seams", "integers-1") => (6, 5, true),
            // Those have quantised positions.
            _ => continue,
        };
        let place = |a: i64, b: i64| [3 * (a % n), 2 * (b % m), a % n * (b % m) % 7];
        let mut expected = Vec::new();
        for (a, b) in (0..n).flat_map(|a| (0..m).map(move |b| (a, b))) {
            if !holes || (3 * a + b) % 5 != 0 {
                expected.push([place(a, b), place(a + 1, b), place(a + 1, b + 1)]);
                expected.push([place(a, b), place(a + 1, b + 1), place(a, b + 1)]);
            }
        }
        let mesh = decoded(&stream).unwrap();
        let positions = &mesh.attributes[0];
        let mut found: Vec<[[i64; 3]; 3]> = mesh
            .faces
            .iter()
            .map(|face| {
                face.map(|point| {
                    let first = positions.values(point as usize).start;
                    [0, 1, 2].map(|k| positions.data.integer(first + k).unwrap())
                })
            })
            .collect();
        // A face may begin at any of its corners.
        for face in found.iter_mut().chain(&mut expected) {
            let least = (0..3).min_by_key(|k| face[*k]).unwrap();
            face.rotate_left(least);
        }
        found.sort_unstable();
        expected.sort_unstable();
        assert_eq!(found, expected, "{name}");
        compared += 1;
    }
    assert_eq!(compared, 15);
}

/// Encodes symbols by rANS, the inverse of the decoder's step: x ↦ ⌊x / p⌋ 2^bits + c + (x mod p).
fn encode(list: &[u32], table: &[u32], bits: u32) -> Vec<u8> {
    let base = 4u32 << bits;
    let (mut state, mut out) = (base, Vec::new());
    for symbol in list.iter().rev() {
        let probability = table[*symbol as usize];
        let before: u32 = table[..*symbol as usize].iter().sum();
        while state >= (base >> bits << 8) * probability {
            out.push(state as u8);
            state >>= 8;
        }
        state = ((state / probability) << bits) + before + state % probability;
    }
    let rest = state - base;
    let size = (1..=4).find(|size| rest < 1 << (8 * size - 2)).unwrap();
    out.extend_from_slice(&(rest | (size - 1) << (8 * size - 2)).to_le_bytes()[..size as usize]);
    out
}

/// A stream of raw symbols: the scheme, the number of bits, the table and the coded symbols.
fn raw(list: &[u32], table: &[u32]) -> Vec<u8> {
    let mut bytes = vec![1, 1, table.len() as u8];
    for probability in table {
        bytes.extend_from_slice(&[
            (probability << 2) as u8 | 2,
            (probability >> 6) as u8,
            (probability >> 14) as u8,
        ]);
    }
    let coded = encode(list, table, 12);
    bytes.push(coded.len() as u8);
    bytes.extend(coded);
    bytes
}

#[test]
fn symbols_are_the_inverse_of_their_encoding() {
    let (budget, table) = (Budget::of_file(0), [1000, 96, 2000, 1000]);
    let room = Room { budget: &budget, pointer: "" };
    let list: Vec<u32> = (0..60u32).map(|i| i * i % 7 % 4).collect();
    let bytes = raw(&list, &table);
    let mut reader = Reader::new(&bytes);
    assert_eq!(symbols(&mut reader, 20, 3, room).unwrap(), list);
    assert_eq!(reader.left(), 0);
    // A table whose probabilities have another sum.
    let found = symbols(&mut Reader::new(&raw(&list, &[1000, 96, 2000, 999])), 20, 3, room);
    assert!(matches!(found, Err(Damage::Stream(what)) if what.contains("4095; expected 4096")));
}

/// Indices as compressed differences, which no encoder of the reference writes by default.
#[test]
fn compressed_indices_are_decoded() {
    // 0, 1, 2, then 2, 1, 3: steps of 0, 1, 1, 0, −1, 2 with the sign in the lowest bit.
    let coded = raw(&[0, 2, 2, 0, 3, 4], &[1024, 0, 1024, 1024, 1024]);
    let positions = [0u8, 0, 9, 0, 0, 9, 9, 9];
    let mut bytes = b"DRACO\x02\x02\x01\x00\x00\x00".to_vec();
    bytes.extend([2, 4, 0]);
    bytes.extend(coded);
    // One group of one attribute: generic, unsigned bytes, two components, number 5, raw.
    bytes.extend([1, 1, 4, 2, 2, 0, 5, 0]);
    bytes.extend(positions);
    let mesh = decoded(&bytes).unwrap();
    assert_eq!((mesh.points, &mesh.faces[..]), (4, &[[0, 1, 2], [2, 1, 3]][..]));
    let attribute = &mesh.attributes[0];
    let found = (0..4).flat_map(|p| attribute.values(p)).map(|i| attribute.data.integer(i).unwrap() as u8);
    assert_eq!((attribute.id, found.collect::<Vec<u8>>()), (5, positions.to_vec()));
    // An index beyond the points.
    bytes[12] = 3;
    assert!(refusal(&bytes).contains("point 3, but there are 3"), "{}", refusal(&bytes));
}

#[test]
fn metadata_are_skipped() {
    let (_, stream, expected) = vectors().swap_remove(0);
    let mut with = stream[..9].to_vec();
    // Of attribute 3: one entry "a" of two bytes. Of the file: no entry, one group "b" with an entry "c".
    with.extend([0, 0x80, 1, 3, 1, 1, b'a', 2, 7, 8, 0, 0, 1, 1, b'b', 1, 1, b'c', 1, 9, 0]);
    with.extend(&stream[11..]);
    assert_eq!(digest(&decoded(&with).unwrap()), expected);
}

#[test]
fn other_streams_are_refused_with_what_was_found() {
    let (_, stream, _) = vectors().swap_remove(0);
    let with = |at: usize, byte: u8| {
        let mut bytes = stream.clone();
        bytes[at] = byte;
        refusal(&bytes)
    };
    let start = "a.glb: /p: its Draco stream ";
    for (message, expected) in [
        (with(0, b'd'), "does not begin with DRACO"),
        (with(6, 1), "has version 2.1; expected 2.2"),
        (with(7, 0), "holds a point cloud; expected a mesh"),
        (with(8, 2), "has method 2; expected 0 or 1"),
        (with(11, 1), "has predictive edgebreaker symbols"),
        (refusal(&stream[..40]), "is cut off"),
        (refusal(b""), "is cut off: it has 0 of 5 bytes"),
    ] {
        assert!(message.starts_with(start) && message.contains(expected), "{message}");
    }
}

/// All tables of a stream whose symbols take no bits can announce any number of faces.
#[test]
fn memory_is_charged_before_it_is_used() {
    let mut bytes = b"DRACO\x02\x02\x01\x00\x00\x00".to_vec();
    bytes.extend([0xff, 0xff, 0xff, 0x7f, 4, 0]);
    bytes.extend(raw(&[], &[4096]));
    assert!(refusal(&bytes).contains("memory budget"), "{}", refusal(&bytes));
}

#[test]
fn damaged_streams_are_rejected_or_decoded() {
    let mut state = 1u64;
    let mut random = move |n: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % n
    };
    for (name, stream, _) in vectors() {
        for cut in (0..stream.len()).step_by(7) {
            assert!(decoded(&stream[..cut]).is_err(), "{name}: {cut} bytes");
        }
        let mut rejected = 0;
        for _ in 0..400 {
            let mut bytes = stream.clone();
            for _ in 0..=random(3) {
                let at = 11 + random(bytes.len() - 11);
                bytes[at] ^= 1 << random(8);
            }
            match decoded(&bytes) {
                Ok(mesh) => assert!(mesh.faces.as_flattened().iter().all(|p| (*p as usize) < mesh.points)),
                Err(_) => rejected += 1,
            }
        }
        assert!(rejected > 0, "{name}");
    }
}
