//! Metals by name: linear Rec. 709 colours of the reflectance at normal incidence and of its tint at 82°.
//!
//! From published indices of refraction n + ik: at each nanometre from 380 to 780 the Fresnel equations give the
//! unpolarised reflectance at 0° and at the cosine 1/7. Both are lit by CIE D65 and seen by the CIE 1931 observer;
//! white reflects all light. The tint is the factor that turns Schlick's approximation into the second (F82-tint, Kutz,
//! Hašan and Edmondson 2021). Bands above 1, colours outside Rec. 709, are set to 1.

pub use crate::bsdf::conductor;
use crate::color::Spectrum;
use crate::math::elementary::pow_int;
use crate::schema::choice;

choice! {
    /// A metal.
    pub enum MetalName {
        /// Data: Johnson and Christy 1972.
        Gold = "gold",
        /// Data: Johnson and Christy 1972.
        Silver = "silver",
        /// Data: Johnson and Christy 1972.
        Copper = "copper",
        /// Data: Rakić 1995.
        Aluminium = "aluminium",
        /// 70 % copper, 30 % zinc. Data: Querry 1985.
        Brass = "brass",
        /// Data: Johnson and Christy 1974.
        Iron = "iron",
        /// Stainless, austenitic. Data: Karlsson and Ribbing 1982.
        Steel = "steel",
        /// Data: Johnson and Christy 1974.
        Chromium = "chromium",
        /// Data: Johnson and Christy 1974.
        Nickel = "nickel",
        /// Data: Johnson and Christy 1974.
        Titanium = "titanium",
        /// Data: Rakić, Djurišić, Elazar and Majewski 1998 (Brendel-Bormann model).
        Platinum = "platinum",
        /// Data: Johnson and Christy 1974.
        Palladium = "palladium",
        /// Data: Johnson and Christy 1974.
        Cobalt = "cobalt",
        /// Data: Johnson and Christy 1974.
        Vanadium = "vanadium",
        /// Data: Rakić, Djurišić, Elazar and Majewski 1998 (Brendel-Bormann model).
        Tungsten = "tungsten",
        /// Data: Querry 1985.
        Zinc = "zinc",
    }
}

/// Largest part of an index of refraction that a material takes.
pub const MAX_INDEX: f32 = 100.0;

/// The colours of a metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetalColors {
    /// Reflectance at normal incidence, F₀.
    pub f0: Spectrum,
    /// Factor of Schlick's approximation at 82°.
    pub tint: Spectrum,
}

const fn colors(f0: [f32; 3], tint: [f32; 3]) -> MetalColors {
    MetalColors { f0: Spectrum::new(f0[0], f0[1], f0[2]), tint: Spectrum::new(tint[0], tint[1], tint[2]) }
}

impl MetalName {
    /// Its colours.
    pub const fn colors(self) -> MetalColors {
        match self {
            MetalName::Gold => colors([1.0, 0.730, 0.364], [0.971, 1.0, 0.981]),
            MetalName::Silver => colors([0.989, 0.984, 0.978], [0.993, 0.995, 0.999]),
            MetalName::Copper => colors([0.929, 0.624, 0.522], [0.982, 0.947, 0.945]),
            MetalName::Aluminium => colors([0.907, 0.916, 0.922], [0.874, 0.903, 0.933]),
            MetalName::Brass => colors([0.908, 0.779, 0.423], [0.952, 0.979, 1.0]),
            MetalName::Iron => colors([0.529, 0.513, 0.494], [0.765, 0.767, 0.802]),
            MetalName::Steel => colors([0.669, 0.639, 0.598], [0.789, 0.823, 0.870]),
            MetalName::Chromium => colors([0.550, 0.556, 0.554], [0.741, 0.749, 0.814]),
            MetalName::Nickel => colors([0.696, 0.641, 0.563], [0.815, 0.834, 0.871]),
            MetalName::Titanium => colors([0.618, 0.580, 0.543], [0.769, 0.790, 0.821]),
            MetalName::Platinum => colors([0.678, 0.640, 0.584], [0.792, 0.819, 0.854]),
            MetalName::Palladium => colors([0.732, 0.697, 0.652], [0.832, 0.852, 0.887]),
            MetalName::Cobalt => colors([0.683, 0.655, 0.616], [0.799, 0.820, 0.859]),
            MetalName::Vanadium => colors([0.520, 0.535, 0.567], [0.728, 0.701, 0.718]),
            MetalName::Tungsten => colors([0.506, 0.497, 0.477], [0.718, 0.729, 0.744]),
            MetalName::Zinc => colors([0.743, 0.768, 0.768], [0.615, 0.633, 0.641]),
        }
    }
}

/// The colours of a metal with the index of refraction eta + i·k per band.
pub fn colors_of_index(eta: Spectrum, k: Spectrum) -> MetalColors {
    let (mut f0, mut tint) = ([0.0; 3], [0.0; 3]);
    let bands = eta.to_array().into_iter().zip(k.to_array());
    for ((eta, k), (f0, tint)) in bands.zip(f0.iter_mut().zip(&mut tint)) {
        let (eta, k) = (f64::from(eta), f64::from(k));
        let head_on = conductor(1.0, eta, k);
        let schlick = head_on + (1.0 - head_on) * pow_int(6.0 / 7.0, 5);
        let ratio = if schlick > 0.0 { conductor(1.0 / 7.0, eta, k) / schlick } else { 1.0 };
        (*f0, *tint) = (head_on as f32, ratio.clamp(0.0, 1.0) as f32);
    }
    MetalColors { f0: f0.into(), tint: tint.into() }
}

/// The index of refraction, η and k by band, of a metal with the reflectance `f0` at normal incidence and `grazing` at 82°
/// (cosine 1/7).
pub fn index_of_reflectances(f0: Spectrum, grazing: Spectrum) -> (Spectrum, Spectrum) {
    let (mut eta, mut k) = ([0.0; 3], [0.0; 3]);
    let bands = f0.to_array().into_iter().zip(grazing.to_array());
    for ((f0, grazing), (eta, k)) in bands.zip(eta.iter_mut().zip(&mut k)) {
        let f0 = f64::from(f0).clamp(1e-4, 0.9999);
        let root = f0.sqrt();
        // η is within these bounds; k follows from F₀, and the reflectance at 82° falls with η.
        let (mut low, mut high) = ((1.0 - root) / (1.0 + root), (1.0 + root) / (1.0 - root));
        let k_of = |eta: f64| {
            ((f0 * (eta + 1.0) * (eta + 1.0) - (eta - 1.0) * (eta - 1.0)) / (1.0 - f0)).max(0.0).sqrt()
        };
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if conductor(1.0 / 7.0, middle, k_of(middle)) > f64::from(grazing) {
                low = middle;
            } else {
                high = middle;
            }
        }
        (*eta, *k) = (low as f32, k_of(low) as f32);
    }
    (eta.into(), k.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_give_the_reflectance_of_the_equations() {
        // Gold at 650 nm and 450 nm: n, k and R of Johnson and Christy 1972; 1.5 + 0i is glass.
        let c = colors_of_index(Spectrum::new(0.166, 1.5, 1.5), Spectrum::new(3.15, 1.88, 0.0));
        assert!((c.f0.r - 0.941).abs() < 0.02 && (c.f0.g - 0.39).abs() < 0.02, "{:?}", c.f0);
        assert!((c.f0.b - 0.04).abs() < 1e-6);
        // Values that no metal has.
        for (eta, k) in [(0.0, 0.0), (1e30, 0.0), (0.0, 1e30), (1.0, 0.0)] {
            let c = colors_of_index(Spectrum::grey(eta), Spectrum::grey(k));
            assert!(c.f0.is_finite() && c.tint.is_finite() && c.f0.r <= 1.0, "{eta} {k}: {c:?}");
        }
    }

    #[test]
    fn reflectances_give_the_index_that_gives_them() {
        let at = |cos: f64, eta: f64, k: f64| Spectrum::grey(conductor(cos, eta, k) as f32);
        for (eta, k) in [(0.143, 3.98), (0.375, 2.39), (1.44, 1.6), (2.2, 0.8), (4.4, 5.2), (1.66, 9.2)] {
            let (e, found) = index_of_reflectances(at(1.0, eta, k), at(1.0 / 7.0, eta, k));
            let (e, found) = (f64::from(e.g), f64::from(found.g));
            assert!((e / eta - 1.0).abs() < 2e-3 && (found / k - 1.0).abs() < 2e-3, "{eta} {k}: {e} {found}");
        }
        // Black, white and values that no metal has.
        for (f0, grazing) in [(0.0, 0.5), (1.0, 1.0), (0.5, 0.0), (0.04, 0.9), (1.0, 0.0), (0.3, f32::NAN)] {
            let (eta, k) = index_of_reflectances(Spectrum::grey(f0), Spectrum::grey(grazing));
            assert!(eta.is_finite() && k.is_finite() && eta.g > 0.0, "{f0} {grazing}: {eta:?} {k:?}");
            let back = conductor(1.0, f64::from(eta.g), f64::from(k.g));
            assert!((back - f64::from(f0)).abs() < 1e-3, "{f0} {grazing}: {back}");
        }
    }

    #[test]
    fn named_metals_look_like_themselves() {
        for word in MetalName::WORDS {
            let c = MetalName::from_word(word).unwrap().colors();
            for v in c.f0.to_array().into_iter().chain(c.tint.to_array()) {
                assert!((0.3..=1.0).contains(&v), "{word} {c:?}");
            }
        }
        let (gold, silver) = (MetalName::Gold.colors().f0, MetalName::Silver.colors().f0);
        assert!(gold.r > gold.g && gold.g > 1.5 * gold.b && silver.b > 0.97);
        assert!(MetalName::Iron.colors().f0.luminance() < MetalName::Aluminium.colors().f0.luminance());
    }
}
