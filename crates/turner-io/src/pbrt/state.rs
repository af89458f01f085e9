//! The graphics state: transforms, material, area light, media, default parameters.

use super::params::{Param, Params};
use std::rc::Rc;
use turner::color::Spectrum;
use turner::math::DAffine3;

/// The current transformation matrix at the start and the end of the motion.
pub(super) type Ctm = [DAffine3; 2];

/// No transformation.
pub(super) const IDENTITY: Ctm = [DAffine3::IDENTITY; 2];

/// The kinds of objects for which `Attribute` sets defaults.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    Shape,
    Light,
    Material,
    Medium,
    Texture,
}

impl Target {
    pub(super) const WORDS: [(&'static str, Target); 5] = [
        ("shape", Target::Shape),
        ("light", Target::Light),
        ("material", Target::Material),
        ("medium", Target::Medium),
        ("texture", Target::Texture),
    ];
}

/// The colour space that `rgb` is written in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum ColorSpace {
    #[default]
    Srgb,
    DciP3,
    Rec2020,
    Aces,
}

impl ColorSpace {
    pub(super) const WORDS: [(&'static str, ColorSpace); 4] = [
        ("srgb", ColorSpace::Srgb),
        ("dci-p3", ColorSpace::DciP3),
        ("rec2020", ColorSpace::Rec2020),
        ("aces2065-1", ColorSpace::Aces),
    ];

    /// Light to linear Rec. 709. White is the light of the space's white point, with luminance 1.
    pub(super) fn light_to_rec709(self, [r, g, b]: [f64; 3]) -> [f64; 3] {
        let by = |m: [[f64; 3]; 3]| m.map(|row| row[0] * r + row[1] * g + row[2] * b);
        match self {
            // Their white point is D65.
            ColorSpace::Srgb | ColorSpace::DciP3 | ColorSpace::Rec2020 => self.to_rec709([r, g, b]),
            // From the primaries of ACES2065-1 and its white point, x = 0.32168, y = 0.33767.
            ColorSpace::Aces => by([
                [2.558_279, -1.119_424, -0.391_796],
                [-0.277_981, 1.365_996, -0.093_486],
                [-0.017_175, -0.148_569, 1.081_307],
            ]),
        }
    }

    /// The light of the white point, with luminance 1.
    pub(super) fn white(self) -> Spectrum {
        let [r, g, b] = self.light_to_rec709([1.0; 3]).map(|v| v as f32);
        Spectrum::new(r, g, b)
    }

    /// The colour of a surface to linear Rec. 709; white stays white.
    pub(super) fn to_rec709(self, [r, g, b]: [f64; 3]) -> [f64; 3] {
        let by = |m: [[f64; 3]; 3]| m.map(|row| row[0] * r + row[1] * g + row[2] * b);
        match self {
            ColorSpace::Srgb => [r, g, b],
            // With the white point D65.
            ColorSpace::DciP3 => by([
                [1.224_940, -0.224_940, 0.0],
                [-0.042_057, 1.042_057, 0.0],
                [-0.019_638, -0.078_636, 1.098_274],
            ]),
            ColorSpace::Rec2020 => by([
                [1.660_491, -0.587_641, -0.072_850],
                [-0.124_550, 1.132_900, -0.008_349],
                [-0.018_151, -0.100_579, 1.118_730],
            ]),
            // Adapted from the ACES white point.
            ColorSpace::Aces => by([
                [2.521_686, -1.134_131, -0.387_555],
                [-0.276_480, 1.372_719, -0.096_239],
                [-0.015_378, -0.152_975, 1.168_353],
            ]),
        }
    }
}

/// The graphics state.
#[derive(Clone, Debug)]
pub(super) struct State {
    pub(super) ctm: Ctm,
    /// Which of the two transforms directives change.
    pub(super) active: [bool; 2],
    pub(super) reverse: bool,
    /// Index of the material's slot.
    pub(super) material: usize,
    pub(super) area_light: Option<Rc<Params>>,
    /// Names of the media inside and outside; empty for none.
    pub(super) media: [String; 2],
    pub(super) color_space: ColorSpace,
    /// Default parameters; usually none.
    pub(super) defaults: Rc<Vec<(Target, Param)>>,
}

impl State {
    pub(super) fn new(material: usize) -> State {
        State {
            ctm: IDENTITY,
            active: [true, true],
            reverse: false,
            material,
            area_light: None,
            media: Default::default(),
            color_space: ColorSpace::Srgb,
            defaults: Rc::default(),
        }
    }

    /// Multiplies the active transforms from the right.
    pub(super) fn concat(&mut self, by: DAffine3) {
        for (ctm, active) in self.ctm.iter_mut().zip(self.active) {
            if active {
                *ctm *= by;
            }
        }
    }

    /// Replaces the active transforms.
    pub(super) fn set(&mut self, to: Ctm) {
        for ((ctm, active), to) in self.ctm.iter_mut().zip(self.active).zip(to) {
            if active {
                *ctm = to;
            }
        }
    }

    /// `params` with the defaults for one kind of object.
    pub(super) fn with_defaults(&self, params: Params, target: Target) -> Params {
        if self.defaults.is_empty() {
            return params;
        }
        let own: Vec<Param> =
            self.defaults.iter().filter(|(t, _)| *t == target).map(|(_, p)| p.clone()).collect();
        params.with_defaults(&own)
    }
}
