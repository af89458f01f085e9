//! Cryptomatte 1.2 (Friedman and Jones 2015, "Fully automatic ID mattes with support for motion blur and transparency").
//!
//! Each name is hashed to 32 bits, which become the bits of a float. A pixel has pairs of such a float and the fraction
//! of the pixel that the name covers, the largest first:
//!
//! ```text
//! CryptoObject00.R  CryptoObject00.G   first name, its coverage
//! CryptoObject00.B  CryptoObject00.A   second name, its coverage
//! CryptoObject01.R  …                  third name, …                       six in all
//! ```
//!
//! The attributes `cryptomatte/<key>/…` of the file hold the name of the layers, the hash function, and a manifest: the
//! hash of each name in the picture, as JSON.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::aovs::{each, label_name};
use crate::film::{Aov, CRYPTO_LAYERS, Film, LabelKind};
use crate::scene::Scene;

/// Names of a pixel in a file.
const RANKS: usize = 2 * CRYPTO_LAYERS;

/// MurmurHash3_x86_32 with seed 0 (Appleby 2011).
pub(super) fn murmur3(bytes: &[u8]) -> u32 {
    let mix = |k: u32| k.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (blocks, tail) = bytes.as_chunks::<4>();
    let mut hash = 0u32;
    for block in blocks {
        hash = (hash ^ mix(u32::from_le_bytes(*block))).rotate_left(13);
        hash = hash.wrapping_mul(5).wrapping_add(0xe654_6b64);
    }
    let last = tail.iter().rev().fold(0u32, |k, b| k << 8 | u32::from(*b));
    if !tail.is_empty() {
        hash ^= mix(last);
    }
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

/// The hash whose bits are a normal float: a bit of the exponent is flipped where it would be zero, denormal, infinite or
/// not a number ("uint32_to_float32").
pub(super) fn float_bits(hash: u32) -> u32 {
    let exponent = hash >> 23 & 255;
    if exponent == 0 || exponent == 255 { hash ^ 1 << 23 } else { hash }
}

/// The float of a name, as bits.
fn id_of(name: &str) -> u32 {
    float_bits(murmur3(name.as_bytes()))
}

/// A JSON object of strings.
pub(super) fn json(entries: impl Iterator<Item = (String, String)>) -> String {
    let mut out = String::from("{");
    for (name, value) in entries {
        let comma = if out.len() > 1 { "," } else { "" };
        let _ = write!(out, "{comma}{}:{}", quoted(&name), quoted(&value));
    }
    out.push('}');
    out
}

/// A JSON string in ASCII.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            ' '..='~' => out.push(c),
            _ => {
                for unit in c.encode_utf16(&mut [0; 2]) {
                    let _ = write!(out, "\\u{unit:04x}");
                }
            }
        }
    }
    out.push('"');
    out
}

/// The Cryptomatte of one kind of names.
pub(super) struct Matte<'a> {
    scene: &'a Scene,
    aov: Aov,
    kind: LabelKind,
}

impl<'a> Matte<'a> {
    pub(super) fn new(scene: &'a Scene, aov: Aov, kind: LabelKind) -> Matte<'a> {
        Matte { scene, aov, kind }
    }

    /// The name of its layers.
    fn layer(&self) -> &'static str {
        self.aov.layout().channels.first().copied().unwrap_or_default()
    }

    /// The labels in the picture, in ascending order, each with its name.
    fn names(&self, film: &Film) -> BTreeMap<u32, String> {
        let mut names = BTreeMap::new();
        let crop = film.crop;
        for (x, y) in
            (crop.y..crop.y + crop.height).flat_map(|y| (crop.x..crop.x + crop.width).map(move |x| (x, y)))
        {
            for (label, _) in film.label_coverage(self.aov.word(), x, y) {
                names.entry(label).or_insert_with(|| label_name(self.scene, self.kind, label));
            }
        }
        names
    }

    /// The channels of its layers, each with its name.
    pub(super) fn channels(&self, film: &Film) -> Vec<(String, Vec<f32>)> {
        let ids: BTreeMap<u32, u32> =
            self.names(film).into_iter().map(|(label, name)| (label, id_of(&name))).collect();
        let ranked = each(film, |x, y| {
            let of_labels = film
                .label_coverage(self.aov.word(), x, y)
                .map(|(label, part)| (ids.get(&label).copied().unwrap_or_default(), part));
            ranks(of_labels)
        });
        let mut out = Vec::new();
        for layer in 0..CRYPTO_LAYERS {
            for (i, channel) in ["R", "G", "B", "A"].iter().enumerate() {
                let (rank, is_coverage) = (2 * layer + i / 2, i % 2 == 1);
                let value = |pixel: &[(u32, f32); RANKS]| {
                    let (id, part) = pixel[rank];
                    if is_coverage { part } else { f32::from_bits(id) }
                };
                let name = format!("{}{layer:02}.{channel}", self.layer());
                out.push((name, ranked.iter().map(value).collect()));
            }
        }
        out
    }

    /// The attributes of the file.
    pub(super) fn attributes(&self, film: &Film) -> Vec<(String, String)> {
        let layer = self.layer();
        let key = format!("{:08x}", murmur3(layer.as_bytes()));
        let hashes: BTreeMap<String, String> = self
            .names(film)
            .into_values()
            .map(|name| {
                let id = format!("{:08x}", id_of(&name));
                (name, id)
            })
            .collect();
        [
            ("conversion", "uint32_to_float32".to_owned()),
            ("hash", "MurmurHash3_32".to_owned()),
            ("manifest", json(hashes.into_iter())),
            ("name", layer.to_owned()),
        ]
        .map(|(what, value)| (format!("cryptomatte/{}/{what}", &key[..7]), value))
        .into()
    }
}

/// The ids with the largest coverage, in falling order; equal coverages by id. Coverages of one id are added.
fn ranks(of_labels: impl Iterator<Item = (u32, f32)>) -> [(u32, f32); RANKS] {
    let mut all: Vec<(u32, f32)> = Vec::new();
    for (id, part) in of_labels {
        match all.iter_mut().find(|(known, _)| *known == id) {
            Some((_, sum)) => *sum += part,
            None => all.push((id, part)),
        }
    }
    all.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut out = [(0, 0.0); RANKS];
    out.iter_mut().zip(all).for_each(|(slot, entry)| *slot = entry);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the reference implementation.
    #[test]
    fn hashes_are_those_of_murmur3() {
        for (text, hash) in [
            ("", 0),
            ("hello", 0x248b_fa47),
            ("hello, world", 0x149b_bb7f),
            ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
            ("abc", 0xb3dd_93fa),
        ] {
            assert_eq!(murmur3(text.as_bytes()), hash, "{text}");
        }
    }

    #[test]
    fn ids_are_normal_floats_and_remain_different() {
        for hash in [0, 1, 0x007f_ffff, 0x8000_0000, 0x7f80_0000, 0x7fc0_1234, 0xffff_ffff, 0x3f80_0000] {
            let float = f32::from_bits(float_bits(hash));
            assert!(float.is_normal(), "{hash:08x} {float}");
        }
        // No fixed exponent is lost: only the lowest bit of the exponent changes.
        assert_eq!(float_bits(0x7f80_0000), 0x7f00_0000);
        assert_eq!(float_bits(0x0000_0005), 0x0080_0005);
        assert_eq!(float_bits(0x3f80_0000), 0x3f80_0000);
    }

    #[test]
    fn ranks_fall_and_ties_go_by_id() {
        let labels = [(7, 0.25f32), (3, 0.25), (9, 0.125), (9, 0.375), (1, 0.0)];
        assert_eq!(ranks(labels.into_iter())[..4], [(9, 0.5), (3, 0.25), (7, 0.25), (1, 0.0)]);
    }

    #[test]
    fn json_is_ascii_and_escaped() {
        let entries = [("a\"b\\", "ü\n"), ("🙂", "")];
        let text = json(entries.into_iter().map(|(a, b)| (a.to_owned(), b.to_owned())));
        assert_eq!(text, r#"{"a\"b\\":"\u00fc\u000a","\ud83d\ude42":""}"#);
    }
}
