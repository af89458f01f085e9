//! Wavefront MTL: materials of OBJ files, with the keys for physically based rendering that exporters add (`Pr`,
//! `Pm`, …).
//!
//! [`parse`] reads a library into [`MtlMaterial`]s; [`physical`] converts each to the closest physically based
//! material. Statements without a counterpart are counted by keyword.

mod map;
pub(super) mod physical;

pub(super) use map::MtlMap;

use super::number::parse_f32;
use crate::assets::printable;
use std::collections::BTreeMap;

/// Most materials of a library; a triangle's material index can distinguish no more.
const MAX_MATERIALS: usize = 1 << 16;

/// A material of a library. `None`: not given.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct MtlMaterial {
    pub(super) name: String,
    /// Diffuse colour (`Kd`); the other colours likewise.
    pub(super) diffuse: Option<[f32; 3]>,
    pub(super) specular: Option<[f32; 3]>,
    pub(super) ambient: Option<[f32; 3]>,
    pub(super) emission: Option<[f32; 3]>,
    /// Transmission filter (`Tf`).
    pub(super) filter: Option<[f32; 3]>,
    /// Specular exponent (`Ns`).
    pub(super) exponent: Option<f32>,
    /// `d`, or 1 − `Tr`; 1 is opaque.
    pub(super) dissolve: Option<f32>,
    /// Index of refraction (`Ni`).
    pub(super) ior: Option<f32>,
    pub(super) illum: Option<i32>,
    /// `Pr`, `Pm`, `Ps`, `Pc`, `Pcr`, `aniso`, `anisor`.
    pub(super) roughness: Option<f32>,
    pub(super) metalness: Option<f32>,
    pub(super) sheen: Option<f32>,
    pub(super) coat: Option<f32>,
    pub(super) coat_roughness: Option<f32>,
    pub(super) anisotropy: Option<f32>,
    pub(super) anisotropy_rotation: Option<f32>,
    /// Texture maps by lower-case keyword: `map_kd`, `map_bump`, `norm`, …
    pub(super) maps: BTreeMap<&'static str, MtlMap>,
    /// Whether `dissolve` comes from `Tr`; `d` overrides it.
    from_transparency: bool,
}

/// A material library.
#[derive(Debug, Default)]
pub(super) struct MtlFile {
    pub(super) materials: Vec<MtlMaterial>,
    /// Keywords and options without a counterpart, with their counts.
    pub(super) ignored: BTreeMap<String, u64>,
}

/// Keywords of texture maps, in lower case, and the key under which each is kept.
const MAPS: [(&str, &str); 20] = [
    ("map_kd", "map_kd"),
    ("map_ks", "map_ks"),
    ("map_ns", "map_ns"),
    ("map_d", "map_d"),
    ("map_tr", "map_tr"),
    ("map_ke", "map_ke"),
    ("map_ka", "map_ka"),
    ("map_pr", "map_pr"),
    ("map_pm", "map_pm"),
    ("map_ps", "map_ps"),
    ("map_pc", "map_pc"),
    ("map_bump", "map_bump"),
    ("bump", "map_bump"),
    ("norm", "norm"),
    ("map_kn", "norm"),
    ("map_norm", "norm"),
    ("disp", "disp"),
    ("map_disp", "disp"),
    ("decal", "decal"),
    ("refl", "refl"),
];

/// Parses a library. Nothing is an error: statements that cannot be read are counted as ignored.
pub(super) fn parse(bytes: &[u8]) -> MtlFile {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut file = MtlFile::default();
    for line in bytes.split(|&b| b == b'\n' || b == b'\r') {
        let line = line.trim_ascii();
        let (keyword, rest) = match line.iter().position(u8::is_ascii_whitespace) {
            Some(at) => (&line[..at], line[at..].trim_ascii()),
            None => (line, &b""[..]),
        };
        if keyword.is_empty() || keyword.starts_with(b"#") {
            continue;
        }
        let keyword = String::from_utf8_lossy(keyword).to_lowercase();
        if keyword == "newmtl" {
            if file.materials.len() < MAX_MATERIALS {
                let name = super::obj::name_of(rest);
                file.materials.push(MtlMaterial { name, ..MtlMaterial::default() });
            } else {
                file.ignore("newmtl");
            }
            continue;
        }
        let Some(material) = file.materials.last_mut() else {
            file.ignore(&keyword);
            continue;
        };
        if let Some((_, kept)) = MAPS.iter().find(|(k, _)| *k == keyword) {
            let (map, options) = MtlMap::parse(rest);
            // The first of several counts, such as `map_Bump` and `bump` in one material.
            if let Some(map) = map {
                material.maps.entry(kept).or_insert(map);
            }
            options.iter().for_each(|option| file.ignore(option));
        } else if !material.set(&keyword, rest) {
            file.ignore(&keyword);
        }
    }
    file
}

impl MtlFile {
    fn ignore(&mut self, what: &str) {
        // Bounds the memory if a hostile file uses many different keywords.
        const MOST: usize = 64;
        if self.ignored.len() < MOST || self.ignored.contains_key(what) {
            let shown: String = printable(what).chars().take(40).collect();
            *self.ignored.entry(shown).or_default() += 1;
        }
    }
}

impl MtlMaterial {
    /// Applies a numeric statement; false if it is unknown or lacks a number.
    fn set(&mut self, keyword: &str, rest: &[u8]) -> bool {
        let mut numbers = [0.0_f32; 3];
        let words = rest.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        let mut count = 0;
        for word in words.take_while(|w| !w.starts_with(b"#")).take(3) {
            match parse_f32(word).filter(|v| v.is_finite()) {
                Some(v) => numbers[count] = v,
                // `spectral FILE`, `xyz X Y Z`, or damage.
                None => break,
            }
            count += 1;
        }
        if count == 0 {
            return false;
        }
        let number = Some(numbers[0]);
        let color = match count {
            // One number is grey. Two are not valid; the first is used.
            1 | 2 => Some([numbers[0].max(0.0); 3]),
            _ => Some(numbers.map(|v| v.max(0.0))),
        };
        match keyword {
            "kd" => self.diffuse = color,
            "ks" => self.specular = color,
            "ka" => self.ambient = color,
            "ke" => self.emission = color,
            "tf" => self.filter = color,
            "ns" => self.exponent = number.map(|v| v.max(0.0)),
            "d" => {
                self.dissolve = number.map(|v| v.clamp(0.0, 1.0));
                self.from_transparency = false;
            }
            "tr" if self.dissolve.is_none() || self.from_transparency => {
                self.dissolve = number.map(|v| 1.0 - v.clamp(0.0, 1.0));
                self.from_transparency = true;
            }
            "tr" => {}
            "ni" => self.ior = number.filter(|v| *v > 0.0),
            "illum" => self.illum = number.map(|v| v as i32),
            "pr" => self.roughness = number.map(|v| v.clamp(0.0, 1.0)),
            "pm" => self.metalness = number.map(|v| v.clamp(0.0, 1.0)),
            "ps" => self.sheen = number.map(|v| v.clamp(0.0, 1.0)),
            "pc" => self.coat = number.map(|v| v.clamp(0.0, 1.0)),
            "pcr" => self.coat_roughness = number.map(|v| v.clamp(0.0, 1.0)),
            "aniso" => self.anisotropy = number.map(|v| v.clamp(0.0, 1.0)),
            "anisor" => self.anisotropy_rotation = number,
            // Sharpness of reflection maps and texture anti-aliasing: no counterpart.
            "sharpness" | "map_aat" => {}
            _ => return false,
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_are_read_in_any_case_and_ignored_ones_counted() {
        let text = b"\xef\xbb\xbf# c\r\nKd 1 1 1\nnewmtl my  paint # c\r\n\tKd 0.1 0.2 0.3\r\nKS .5\nNs 96\nd -halo 0.5\n\
                     Tr 0.25\nillum 2\nNi 1.45\nPr 0.3\nPM 1\nfoo bar\nfoo\nKe spectral x.rfl\nmap_Kd -s 2 2 2 a b.png\nbump c.png\n\
                     newmtl other\nd 0.5\nTr 0.9\n";
        let file = parse(text);
        let [paint, other] = &file.materials[..] else { panic!("{file:?}") };
        assert_eq!(paint.name, "my paint");
        assert_eq!((paint.diffuse, paint.specular), (Some([0.1, 0.2, 0.3]), Some([0.5; 3])));
        assert_eq!((paint.exponent, paint.dissolve, paint.illum), (Some(96.0), Some(0.75), Some(2)));
        assert_eq!((paint.ior, paint.roughness, paint.metalness), (Some(1.45), Some(0.3), Some(1.0)));
        assert_eq!(paint.maps["map_kd"].file, "a b.png");
        assert_eq!(paint.maps["map_bump"].file, "c.png");
        assert_eq!(other.dissolve, Some(0.5));
        let ignored: Vec<_> = file.ignored.iter().map(|(k, n)| (k.as_str(), *n)).collect();
        assert_eq!(ignored, [("d", 1), ("foo", 2), ("kd", 1), ("ke", 1)]);
    }
}
