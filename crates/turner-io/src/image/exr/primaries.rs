//! The attribute `chromaticities`: which colours R, G and B are.

use exr::meta::attribute::Chromaticities;
use turner::math::{DMat3, DVec3};

/// Red, green, blue and white of Rec. 709, (x, y).
const REC709: [[f64; 2]; 4] = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]];

/// Chromaticities that differ by less are the same: files hold rounded numbers.
const SAME: f64 = 2e-3;

/// Bradford's cone responses of XYZ.
const BRADFORD: [[f64; 3]; 3] =
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// The matrix from R, G and B with these chromaticities to linear Rec. 709; `None` if they are the same or describe no
/// colours. White becomes white, by Bradford's adaptation; but X, Y and Z stay X, Y and Z.
pub(super) fn to_rec709(chromaticities: &Chromaticities) -> Option<DMat3> {
    let own = list(chromaticities);
    let same = own.as_flattened().iter().zip(REC709.as_flattened()).all(|(a, b)| (a - b).abs() < SAME);
    let xyz = matrix(own).filter(|_| !same)?;
    let is_xyz = own[..3] == [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];
    let adapted = if is_xyz { xyz } else { adapt(own[3]) * xyz };
    Some(rec709().inverse() * adapted).filter(DMat3::is_finite)
}

/// The matrix from R, G and B to X, Y and Z, with white of luminance 1; `None` if they describe no colours.
pub(super) fn xyz_of_rgb(chromaticities: &Chromaticities) -> Option<DMat3> {
    matrix(list(chromaticities))
}

/// That of Rec. 709.
pub(super) fn rec709() -> DMat3 {
    matrix(REC709).unwrap_or(DMat3::IDENTITY)
}

fn list(c: &Chromaticities) -> [[f64; 2]; 4] {
    [c.red, c.green, c.blue, c.white].map(|v| [f64::from(v.0), f64::from(v.1)])
}

fn xyz([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x, y, 1.0 - x - y)
}

fn matrix([red, green, blue, white]: [[f64; 2]; 4]) -> Option<DMat3> {
    let primaries = DMat3::from_cols(xyz(red), xyz(green), xyz(blue));
    if primaries.determinant().abs() < 1e-9 || white[1].abs() < 1e-9 {
        return None;
    }
    let amounts = primaries.inverse() * (xyz(white) / white[1]);
    Some(primaries * DMat3::from_diagonal(amounts)).filter(DMat3::is_finite)
}

/// The adaptation of XYZ from a white to that of Rec. 709.
fn adapt(white: [f64; 2]) -> DMat3 {
    let cones = DMat3::from_cols_array_2d(&BRADFORD).transpose();
    let response = |white: [f64; 2]| cones * (xyz(white) / white[1]);
    cones.inverse() * DMat3::from_diagonal(response(REC709[3]) / response(white)) * cones
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::math::Vec2;

    fn chromaticities([red, green, blue, white]: [[f32; 2]; 4]) -> Chromaticities {
        let v = |[x, y]: [f32; 2]| Vec2(x, y);
        Chromaticities { red: v(red), green: v(green), blue: v(blue), white: v(white) }
    }

    fn is(found: DVec3, expected: [f64; 3], within: f64) {
        assert!((found - DVec3::from(expected)).abs().max_element() < within, "{found} {expected:?}");
    }

    #[test]
    fn matrices_are_the_published_ones() {
        // IEC 61966-2-1.
        is(rec709() * DVec3::X, [0.4124, 0.2126, 0.0193], 1e-4);
        is(rec709() * DVec3::Y, [0.3576, 0.7152, 0.1192], 1e-4);
        // ACEScg with the white of Rec. 709: the matrix of the ACES output transforms.
        let acescg = chromaticities([[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], [0.32168, 0.33767]]);
        let matrix = to_rec709(&acescg).unwrap();
        is(matrix * DVec3::X, [1.70505, -0.13026, -0.02400], 1e-4);
        is(matrix * DVec3::Y, [-0.62179, 1.14080, -0.12897], 1e-4);
        is(matrix * DVec3::ONE, [1.0; 3], 1e-6);
    }

    #[test]
    fn xyz_stays_xyz() {
        let xyz = chromaticities([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]]);
        // X, Y and Z of Rec. 709's white.
        is(to_rec709(&xyz).unwrap() * DVec3::new(0.9505, 1.0, 1.089), [1.0; 3], 1e-3);
    }

    #[test]
    fn the_own_space_and_nonsense_change_nothing() {
        assert!(to_rec709(&chromaticities(REC709.map(|v| v.map(|x| x as f32)))).is_none());
        assert!(to_rec709(&chromaticities([[0.3, 0.3]; 4])).is_none());
        assert!(to_rec709(&chromaticities([[f32::NAN, 0.3], [0.1, 0.8], [0.1, 0.1], [0.3, 0.3]])).is_none());
    }
}
