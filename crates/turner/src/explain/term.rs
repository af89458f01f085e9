//! Named values of a ray: numbers between words, so that front ends write them as they like.

use std::fmt;

use super::number;
use crate::color::Spectrum;
use crate::math::DVec3;

/// A part of the value of a [`Term`]. `Display` writes numbers as [`number`](mod@super::number) does.
#[derive(Clone, Debug, PartialEq)]
pub enum Piece {
    /// Words and punctuation between the values. Names of the scene may be in it, not escaped for a terminal or HTML.
    Text(String),
    /// A number, to five digits.
    Number(f64),
    /// A number, to three digits.
    Rounded(f64),
    /// A colour: radiance, a weight or a factor per channel.
    Color(Spectrum),
    /// A point or a direction in world space.
    Vector(DVec3),
}

impl fmt::Display for Piece {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Piece::Text(text) => f.write_str(text),
            Piece::Number(v) => f.write_str(&number::number(*v)),
            Piece::Rounded(v) => f.write_str(&number::short(*v)),
            Piece::Color(c) => f.write_str(&number::color(*c)),
            Piece::Vector(v) => f.write_str(&number::vector(*v)),
        }
    }
}

/// A value of a ray and its name, such as `throughput` or `Russian roulette`.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// Its name.
    pub name: &'static str,
    /// Its value: the pieces in a row.
    pub pieces: Vec<Piece>,
}

impl Term {
    pub(super) fn new(name: &'static str, value: impl Into<Value>) -> Term {
        Term { name, pieces: value.into().0 }
    }

    /// The value as text.
    pub fn text(&self) -> String {
        self.pieces.iter().map(Piece::to_string).collect()
    }

    /// What a ray adds to the sample by this term, if that is what it says.
    pub fn contribution(&self) -> Option<Spectrum> {
        match (self.name, self.pieces.first()) {
            ("adds", Some(Piece::Color(color))) => Some(*color),
            _ => None,
        }
    }

    /// What the name means, in a sentence; `None` for names that say it themselves.
    pub fn meaning(&self) -> Option<&'static str> {
        MEANINGS.iter().find(|(name, _)| *name == self.name).map(|(_, meaning)| *meaning)
    }
}

/// What the names of terms mean.
const MEANINGS: &[(&str, &str)] = &[
    ("t", "Distance from the origin of the ray to the hit, in scene units."),
    ("hits", "Point of the hit in world space, and its texture coordinates."),
    ("normal", "Geometric normal of the surface, a unit vector; the shading normal where it differs."),
    ("weights", "Fractions of the local colour and of the reflected and refracted rays."),
    ("local", "Radiance of the surface without reflected and refracted rays."),
    ("adds", "Radiance that is added to the sample."),
    ("emission", "Radiance that the surface or the medium emits."),
    ("N·L", "Cosine of the angle between the normal and the direction to the light."),
    (
        "R·V",
        "Cosine of the angle between the mirrored direction to the light and the direction to the viewer.",
    ),
    ("intensity", "Light that arrives at the surface, without its shadow."),
    ("diffuse", "Part of the light that the surface reflects in all directions."),
    ("highlight", "Part of the light that the surface reflects as a highlight."),
    ("distance", "Distance to the light, in scene units."),
    ("throughput", "Factor of the radiance at this point in the sample: the product of the weights so far."),
    ("transmittance", "Fraction of the light that passes the medium."),
    ("BSDF sample", "The next direction of the path, chosen at random by the BSDF."),
    (
        "BSDF value",
        "Fraction of the light per solid angle (1/sr) that the surface scatters, and the density of the sample.",
    ),
    ("MIS weight", "Share of this sampling technique in multiple importance sampling."),
    ("next-event estimation", "Light that one chosen light sends directly to this point."),
    ("Russian roulette", "Ends dark paths at random; those that survive count for more."),
    ("unoccluded", "Contribution if nothing were between the surface and the light."),
    ("radiance", "Radiance that arrives, in W/(sr·m²) or the scene's unit."),
    ("photons", "Photons of light paths that are merged with this point."),
    ("random walk", "Scattering below the surface, from the point of entry to the point of exit."),
    (
        "dispersion",
        "From here on the path carries one colour channel, because the index of refraction differs.",
    ),
    ("shared", "The path also serves the neighbouring pixels."),
    ("medium", "Medium that the ray passes."),
];

/// The value of a term.
pub(super) struct Value(Vec<Piece>);

impl From<Piece> for Value {
    fn from(piece: Piece) -> Value {
        Value(vec![piece])
    }
}

impl From<Vec<Piece>> for Value {
    fn from(pieces: Vec<Piece>) -> Value {
        Value(pieces)
    }
}

impl From<String> for Value {
    fn from(text: String) -> Value {
        Value(vec![Piece::Text(text)])
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Value {
        Value(vec![Piece::Text(text.to_owned())])
    }
}

/// Puts values in place of each `{}`.
pub(super) fn filled<const N: usize>(template: &str, values: [Value; N]) -> Vec<Piece> {
    let mut out = Vec::with_capacity(2 * N + 1);
    let mut values = values.into_iter();
    for (i, words) in template.split("{}").enumerate() {
        if i > 0 {
            out.extend(values.next().map(|v| v.0).unwrap_or_default());
        }
        if !words.is_empty() {
            out.push(Piece::Text(words.to_owned()));
        }
    }
    out
}

/// Like `format!`, but numbers stay numbers.
macro_rules! fill {
    ($template:literal $(, $value:expr)* $(,)?) => { $crate::explain::term::filled($template, [$($value.into()),*]) };
}
pub(super) use fill;

pub(super) fn number(v: f64) -> Piece {
    Piece::Number(v)
}

pub(super) fn short(v: f64) -> Piece {
    Piece::Rounded(v)
}

pub(super) fn color(c: Spectrum) -> Piece {
    Piece::Color(c)
}

pub(super) fn vector(v: DVec3) -> Piece {
    Piece::Vector(v)
}
