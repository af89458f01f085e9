//! Filters (appendix B), applied in slot after decompression of attributes.
//!
//! | filter | stored | decoded |
//! |---|---|---|
//! | OCTAHEDRAL | octahedral coordinates (x, y) and the value of 1 | unit vector, 8 or 16 bits per component |
//! | QUATERNION | the three smaller components, scale and index of the largest | unit quaternion, 16 bits |
//! | EXPONENTIAL | 24-bit mantissa, 8-bit exponent | float |
//! | COLOR | luma, two chroma differences, alpha | RGBA, 8 or 16 bits |
//!
//! Each filter returns whether the length is a multiple of the element size. Arithmetic is in single precision, as
//! the extension requires.

/// Applies `change` to each element of `N` bytes; false if bytes remain.
fn elements<const N: usize>(bytes: &mut [u8], mut change: impl FnMut(&mut [u8; N])) -> bool {
    let (chunks, rest) = bytes.as_chunks_mut::<N>();
    chunks.iter_mut().for_each(&mut change);
    rest.is_empty()
}

/// Rounds to the nearest integer, halves away from 0.
fn round(v: f32) -> i32 {
    (v + if v >= 0.0 { 0.5 } else { -0.5 }) as i32
}

/// The unit vector of octahedral coordinates (x, y), where `one` represents 1, scaled to `max`.
fn octahedron(x: f32, y: f32, one: f32, max: f32) -> [i32; 3] {
    let z = one - x.abs() - y.abs();
    let fold = z.min(0.0);
    let x = x + if x >= 0.0 { fold } else { -fold };
    let y = y + if y >= 0.0 { fold } else { -fold };
    let scale = max / (x * x + y * y + z * z).sqrt();
    // The length is zero only in damaged data; NaN then converts to 0.
    [x, y, z].map(|v| round(v * scale))
}

/// Octahedral vectors of signed bytes; the fourth byte is kept.
pub(super) fn octahedral_8(bytes: &mut [u8]) -> bool {
    elements::<4>(bytes, |e| {
        let [x, y, one, _] = e.map(|b| f32::from(b as i8));
        let v = octahedron(x, y, one, 127.0);
        for (slot, v) in e.iter_mut().zip(v) {
            *slot = v as i8 as u8;
        }
    })
}

fn shorts(e: &[u8; 8]) -> [i16; 4] {
    [0, 2, 4, 6].map(|i| i16::from_le_bytes([e[i], e[i + 1]]))
}

fn put_short(e: &mut [u8; 8], i: usize, v: i16) {
    e[2 * i..2 * i + 2].copy_from_slice(&v.to_le_bytes());
}

/// Octahedral vectors of signed 16-bit integers; the fourth is kept.
pub(super) fn octahedral_16(bytes: &mut [u8]) -> bool {
    elements::<8>(bytes, |e| {
        let [x, y, one, _] = shorts(e).map(f32::from);
        let v = octahedron(x, y, one, 32767.0);
        for (i, v) in v.into_iter().enumerate() {
            put_short(e, i, v as i16);
        }
    })
}

/// Unit quaternions. Stored are the three smaller components; the fourth integer holds their scale and, in two bits,
/// the index of the omitted component.
pub(super) fn quaternion(bytes: &mut [u8]) -> bool {
    elements::<8>(bytes, |e| {
        let [x, y, z, scale] = shorts(e);
        let scaled = std::f32::consts::FRAC_1_SQRT_2 / f32::from(scale | 3);
        let [x, y, z] = [x, y, z].map(|v| f32::from(v) * scaled);
        let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
        let missing = (scale & 3) as usize;
        for (i, v) in [w, x, y, z].into_iter().enumerate() {
            put_short(e, (missing + i) & 3, round(v * 32767.0) as i16);
        }
    })
}

/// Floats with a signed 24-bit mantissa and a signed 8-bit exponent to base 2.
pub(super) fn exponential(bytes: &mut [u8]) -> bool {
    elements::<4>(bytes, |e| {
        let v = i32::from_le_bytes(*e);
        let (mantissa, exponent) = (v << 8 >> 8, v >> 24);
        // 2^exponent as a double: the exponent occupies bits 52 to 62.
        let power = f64::from_bits(((exponent + 1023) as u64) << 52);
        *e = ((f64::from(mantissa) * power) as f32).to_le_bytes();
    })
}

/// RGBA from luma, two chroma differences and alpha. The highest set bit of alpha gives the number of bits.
fn rgba([y, co, cg, a]: [i32; 4], max: f32) -> [i32; 4] {
    let ones = [1, 2, 4, 8].iter().fold(a, |ones, shift| ones | ones >> shift);
    let scale = max / ones as f32;
    let a = (a << 1 & ones) | (a & 1);
    [y + co - cg, y + cg, y - co - cg, a].map(|v| (v as f32 * scale + 0.5) as i32)
}

/// Colours of four bytes.
pub(super) fn color_8(bytes: &mut [u8]) -> bool {
    elements::<4>(bytes, |e| {
        let [y, co, cg, a] = *e;
        let v = rgba([y.into(), (co as i8).into(), (cg as i8).into(), a.into()], 255.0);
        *e = v.map(|v| v.clamp(0, 255) as u8);
    })
}

/// Colours of four 16-bit integers.
pub(super) fn color_16(bytes: &mut [u8]) -> bool {
    elements::<8>(bytes, |e| {
        let [y, co, cg, a] = shorts(e);
        let v = rgba([(y as u16).into(), co.into(), cg.into(), (a as u16).into()], 65535.0);
        for (i, v) in v.into_iter().enumerate() {
            e[2 * i..2 * i + 2].copy_from_slice(&(v.clamp(0, 65535) as u16).to_le_bytes());
        }
    })
}
