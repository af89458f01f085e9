//! The ICC profile of Display P3, for programs that do not know the cICP chunk of PNG.
//!
//! ICC.1:2022 (version 4), a matrix profile: a header of 128 bytes, a table of tags, and the tags. The colours are
//! those of SMPTE EG 432-1 adapted to D50 with the Bradford matrix; the curve is that of sRGB.

/// Numbers of 16.16 fixed point.
const RED: [i32; 3] = [33759, 15807, -69];
const GREEN: [i32; 3] = [19135, 45367, 2745];
const BLUE: [i32; 3] = [10296, 4363, 51385];
const D50: [i32; 3] = [63190, 65536, 54061];
/// The adaptation from D65 to D50.
const ADAPTATION: [i32; 9] = [68674, 1502, -3291, 1939, 64912, -1119, -606, 988, 49262];
/// The curve of sRGB: exponent 2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045.
const CURVE: [i32; 5] = [157_286, 62_119, 3_417, 5_072, 2_651];

/// The profile.
pub(super) fn display_p3() -> Vec<u8> {
    let tags: [(&[u8; 4], Vec<u8>); 8] = [
        (b"desc", text("Display P3")),
        (b"cprt", text("CC0")),
        (b"wtpt", xyz(D50)),
        (b"chad", numbers(b"sf32", &ADAPTATION)),
        (b"rXYZ", xyz(RED)),
        (b"gXYZ", xyz(GREEN)),
        (b"bXYZ", xyz(BLUE)),
        (b"rTRC", parametric(&CURVE)),
    ];
    // Green and blue share the curve of red.
    let count = tags.len() as u32 + 2;
    let mut data = Vec::new();
    let mut table = count.to_be_bytes().to_vec();
    let start = 128 + 4 + 12 * count;
    let mut entry = |name: &[u8; 4], offset: u32, size: u32| {
        table.extend_from_slice(name);
        table.extend(offset.to_be_bytes());
        table.extend(size.to_be_bytes());
    };
    for (name, bytes) in &tags {
        let offset = start + data.len() as u32;
        entry(name, offset, bytes.len() as u32);
        if *name == b"rTRC" {
            entry(b"gTRC", offset, bytes.len() as u32);
            entry(b"bTRC", offset, bytes.len() as u32);
        }
        data.extend_from_slice(bytes);
        data.resize(data.len().next_multiple_of(4), 0);
    }
    let mut profile = header(start + data.len() as u32);
    profile.extend(table);
    profile.extend(data);
    profile
}

/// The header: version 4.3, a display, RGB to XYZ, a fixed date.
fn header(size: u32) -> Vec<u8> {
    let mut header = size.to_be_bytes().to_vec();
    header.extend([0; 4]);
    header.extend([4, 0x30, 0, 0]);
    header.extend(b"mntrRGB XYZ ");
    header.extend([2026u16, 1, 1, 0, 0, 0].iter().flat_map(|v| v.to_be_bytes()));
    header.extend(b"acsp");
    // Platform, flags, manufacturer, model, attributes, rendering intent.
    header.extend([0; 28]);
    header.extend(D50.iter().flat_map(|v| v.to_be_bytes()));
    header.resize(128, 0);
    header
}

fn xyz(v: [i32; 3]) -> Vec<u8> {
    numbers(b"XYZ ", &v)
}

fn numbers(kind: &[u8; 4], v: &[i32]) -> Vec<u8> {
    let mut bytes = kind.to_vec();
    bytes.extend([0; 4]);
    bytes.extend(v.iter().flat_map(|v| v.to_be_bytes()));
    bytes
}

/// A parametric curve of function 3.
fn parametric(v: &[i32; 5]) -> Vec<u8> {
    let mut bytes = b"para\0\0\0\0\0\x03\0\0".to_vec();
    bytes.extend(v.iter().flat_map(|v| v.to_be_bytes()));
    bytes
}

/// Text in English, in UTF-16.
fn text(text: &str) -> Vec<u8> {
    let units: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let mut bytes = b"mluc\0\0\0\0\0\0\0\x01\0\0\0\x0cenUS".to_vec();
    bytes.extend((units.len() as u32).to_be_bytes());
    bytes.extend(28u32.to_be_bytes());
    bytes.extend(units);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_profile_is_consistent() {
        let profile = display_p3();
        let number = |at: usize| u32::from_be_bytes(profile[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!(number(0), profile.len());
        assert_eq!(&profile[36..40], b"acsp");
        let count = number(128);
        assert_eq!(count, 10);
        for tag in 0..count {
            let at = 132 + 12 * tag;
            let (offset, size) = (number(at + 4), number(at + 8));
            assert!(offset % 4 == 0 && offset + size <= profile.len() && size >= 12, "tag {tag}");
        }
        // The colours add up to the white point, up to rounding.
        for i in 0..3 {
            assert!((RED[i] + GREEN[i] + BLUE[i] - D50[i]).abs() <= 1);
        }
    }
}
