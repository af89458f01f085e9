//! A font for tests, whose letters have known areas.

use std::sync::Arc;

use super::TextDesc;
use crate::math::DVec2;
use crate::math::elementary::sin_cos;
use crate::schema::{Contour, ErrorCode, Font, FontFile, Glyph, OutlinePiece, SceneError};

/// A font of five characters: `I` is a rectangle of .2 x .7 em, `o` a ring of radii .25 and .15, `8` two rings that
/// overlap, `=` two bars, and a space. `I` and `o` are kerned by -.05 em.
#[derive(Debug)]
struct Five;

fn rectangle(min: [f64; 2], max: [f64; 2]) -> Contour {
    let [a, b, c, d] = [[min[0], min[1]], [max[0], min[1]], max, [min[0], max[1]]].map(DVec2::from);
    Contour { start: a, pieces: [b, c, d].map(OutlinePiece::Line).to_vec() }
}

/// A circle as 64 quadratic curves, which is nearer to it than 1e-8; clockwise for a negative radius.
fn circle(center: DVec2, radius: f64) -> Contour {
    let at = |i: u32, r: f64| {
        let (s, c) = sin_cos(std::f64::consts::TAU * f64::from(i) / 128.0 * radius.signum());
        center + r.abs() * DVec2::new(c, s)
    };
    let beyond = radius / crate::math::elementary::cos(std::f64::consts::PI / 64.0);
    let piece = |i: u32| OutlinePiece::Quadratic(at(2 * i + 1, beyond), at(2 * i + 2, radius));
    Contour { start: at(0, radius), pieces: (0..64).map(piece).collect() }
}

impl Font for Five {
    fn set_line(&self, face: u32, line: &str) -> Result<Vec<Glyph>, SceneError> {
        if face != 0 {
            return Err(SceneError::new(ErrorCode::Font, "one face"));
        }
        let ring = |y: f64| {
            let center = DVec2::new(0.3, y);
            [circle(center, 0.25), circle(center, -0.15)]
        };
        let glyph = |c: char| match c {
            'I' => (0.3, Some(vec![rectangle([0.05, 0.0], [0.25, 0.7])])),
            'o' => (0.6, Some(ring(0.25).to_vec())),
            '8' => (0.6, Some([ring(0.25), ring(0.6)].concat())),
            '=' => (0.5, Some(vec![rectangle([0.0, 0.1], [0.4, 0.2]), rectangle([0.0, 0.3], [0.4, 0.4])])),
            ' ' => (0.25, Some(Vec::new())),
            _ => (0.0, None),
        };
        let next = line.chars().skip(1).map(Some).chain([None]);
        Ok(line
            .chars()
            .zip(next)
            .map(|(character, next)| {
                let (advance, contours) = glyph(character);
                let kerning = if (character, next) == ('I', Some('o')) { -0.05 } else { 0.0 };
                Glyph { character, advance: advance + kerning, contours: contours.map(Arc::new) }
            })
            .collect())
    }
    fn bytes(&self) -> &[u8] {
        b"five"
    }
}

/// A text in it.
pub(crate) fn text(text: &str) -> TextDesc {
    let font = FontFile { uri: "five.ttf".into(), font: Arc::new(Five) };
    TextDesc { text: text.to_owned(), font, ..TextDesc::default() }
}
