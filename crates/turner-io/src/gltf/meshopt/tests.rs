//! Streams of the reference encoder, as they are and damaged.

use super::*;
use crate::gltf::json::{Index, Size};

fn hex(text: &str) -> Vec<u8> {
    let digit = |b: u8| char::from(b).to_digit(16).unwrap() as u8;
    text.as_bytes().chunks(2).map(|pair| digit(pair[0]) << 4 | digit(pair[1])).collect()
}

/// Each stream's compression parameters, its bytes and the expected result.
fn vectors() -> Vec<(Meshopt, Vec<u8>, Vec<u8>)> {
    let lines = include_str!("vectors.txt").lines().filter(|l| !l.starts_with('#'));
    let vector = |line: &str| {
        let words: Vec<&str> = line.split(' ').collect();
        let how = Meshopt {
            buffer: Index(0),
            byte_offset: Size(0),
            byte_length: Size(0),
            byte_stride: Size(words[1].parse().unwrap()),
            count: Size(words[2].parse().unwrap()),
            mode: words[0].to_owned(),
            filter: Some(words[3].to_owned()),
        };
        (how, hex(words[4]), hex(words[5]))
    };
    lines.map(vector).collect()
}

#[test]
fn streams_of_the_reference_encoder_are_decoded() {
    let vectors = vectors();
    assert!(vectors.len() > 30);
    for (how, source, expected) in vectors {
        let found = decode(&how, &source, &Budget::of_file(0), "").unwrap();
        if how.mode == "TRIANGLES" {
            // A triangle may begin at another corner.
            assert_eq!(found, expected, "{how:?}");
        } else if matches!(how.filter.as_deref(), Some("NONE" | "EXPONENTIAL")) {
            assert_eq!(found, expected, "{how:?}");
        } else {
            // Filters end with a rounding, which can differ by one on processors with fused multiply-add.
            let numbers = |bytes: &[u8]| -> Vec<i32> {
                if how.byte_stride.0 == 4 && how.filter.as_deref() == Some("COLOR") {
                    bytes.iter().map(|b| i32::from(*b)).collect()
                } else if how.byte_stride.0 == 4 {
                    bytes.iter().map(|b| i32::from(*b as i8)).collect()
                } else if how.filter.as_deref() == Some("COLOR") {
                    bytes.chunks(2).map(|b| i32::from(u16::from_le_bytes([b[0], b[1]]))).collect()
                } else {
                    bytes.chunks(2).map(|b| i32::from(i16::from_le_bytes([b[0], b[1]]))).collect()
                }
            };
            let (found, expected) = (numbers(&found), numbers(&expected));
            let most = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).max();
            assert!(most <= Some(1), "{how:?}: {found:?} {expected:?}");
        }
    }
}

#[test]
fn damaged_streams_are_refused_or_decoded_without_harm() {
    for (how, source, _) in vectors() {
        let size = how.count.0 as usize * how.byte_stride.0 as usize;
        for end in 0..source.len() {
            let refused = decode(&how, &source[..end], &Budget::of_file(0), "/bufferViews/0");
            assert!(refused.is_err(), "{how:?} cut at {end}");
        }
        for at in 0..source.len() {
            for mask in [1, 0x10, 0x80, 0xff] {
                let mut bytes = source.clone();
                bytes[at] ^= mask;
                if let Ok(found) = decode(&how, &bytes, &Budget::of_file(0), "/bufferViews/0") {
                    assert_eq!(found.len(), size);
                }
            }
        }
    }
}

#[test]
fn impossible_shapes_are_refused() {
    let said = |mode: &str, stride: u64, count: u64, filter: Option<&str>| {
        let how = Meshopt {
            buffer: Index(0),
            byte_offset: Size(0),
            byte_length: Size(0),
            byte_stride: Size(stride),
            count: Size(count),
            mode: mode.to_owned(),
            filter: filter.map(str::to_owned),
        };
        decode(&how, &[0xe1; 64], &Budget::of_file(64), "/b").unwrap_err().in_file("a").message
    };
    assert!(said("CLOTHES", 4, 4, None).contains("mode CLOTHES"));
    assert!(said("ATTRIBUTES", 5, 4, None).contains("byteStride of 5"));
    assert!(said("ATTRIBUTES", 260, 4, None).contains("byteStride of 260"));
    assert!(said("TRIANGLES", 3, 6, None).contains("byteStride of 3"));
    assert!(said("TRIANGLES", 4, 5, None).contains("5 indices"));
    assert!(said("ATTRIBUTES", 4, u64::MAX, None).contains("too many"));
    assert!(said("ATTRIBUTES", 4, 1 << 40, None).contains("exceed"));
}
