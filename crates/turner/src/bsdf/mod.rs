//! Stand-in until the layered BSDF is here: Lambert, or a smooth mirror or glass.

mod point;
pub use point::PrincipledPoint;
use std::f64::consts::PI;

use crate::color::Spectrum;
use crate::math::{DVec2, DVec3, refract};
use crate::sampler::concentric_disk;

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// The direction.
    pub wi: DVec3,
    /// Value; for delta lobes weight·pdf/|wi.z|.
    pub f: Spectrum,
    /// Density per solid angle.
    pub pdf: f64,
    /// Which lobe.
    pub lobe: Lobe,
    /// Relative index of refraction that was crossed.
    pub eta: f64,
}

/// A lobe's kind.
#[derive(Clone, Copy, Debug)]
pub struct Lobe {
    /// Mirror-like.
    pub is_delta: bool,
    /// To the other side.
    pub is_transmission: bool,
    /// Diffuse.
    pub is_diffuse: bool,
}

/// A BSDF.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf(PrincipledPoint);

impl Bsdf {
    /// For numbers.
    pub fn new(p: &PrincipledPoint) -> Bsdf {
        Bsdf(*p)
    }
    /// Lambert.
    pub fn lambert(albedo: Spectrum) -> Bsdf {
        Bsdf(PrincipledPoint { base_color: albedo, ..PrincipledPoint::default() })
    }
    /// Value.
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        if self.has_smooth() && wo.z * wi.z > 0.0 {
            self.0.base_color * (self.0.base_weight / PI) as f32
        } else {
            Spectrum::BLACK
        }
    }
    /// Density.
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if self.has_smooth() && wo.z * wi.z > 0.0 { wi.z.abs() / PI } else { 0.0 }
    }
    /// Samples.
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        if self.0.base_metalness > 0.5 {
            let wi = DVec3::new(-wo.x, -wo.y, wo.z);
            let lobe = Lobe { is_delta: true, is_transmission: false, is_diffuse: false };
            return Some(BsdfSample {
                wi,
                f: self.0.base_color * (1.0 / wi.z.abs()) as f32,
                pdf: 1.0,
                lobe,
                eta: 1.0,
            });
        }
        if self.0.transmission_weight > 0.5 {
            let ior = self.0.specular_ior / self.0.exterior_ior;
            let eta = if self.0.entering { 1.0 / ior } else { ior };
            let n = DVec3::new(0.0, 0.0, wo.z.signum());
            let t = refract(-wo, n, eta);
            let f = crate::material::Fresnel::Exact.reflectance(wo.z.abs(), eta);
            let (wi, p, over) = match t {
                Some(t) if u[0] >= f => (t, 1.0 - f, eta),
                _ => (DVec3::new(-wo.x, -wo.y, wo.z), f, 1.0),
            };
            let lobe = Lobe { is_delta: true, is_transmission: over != 1.0, is_diffuse: false };
            let f = Spectrum::grey((p / wi.z.abs()) as f32) * (over * over) as f32;
            return Some(BsdfSample { wi, f, pdf: p, lobe, eta: 1.0 / over });
        }
        let d = concentric_disk(DVec2::new(u[1], u[2]));
        let z = (1.0 - d.length_squared()).max(0.0).sqrt();
        let wi = DVec3::new(d.x, d.y, z * wo.z.signum());
        let lobe = Lobe { is_delta: false, is_transmission: false, is_diffuse: true };
        (z > 0.0).then_some(BsdfSample { wi, f: self.eval(wo, wi), pdf: self.pdf(wo, wi), lobe, eta: 1.0 })
    }
    /// Whether there is more than delta lobes.
    pub fn has_smooth(&self) -> bool {
        self.0.base_metalness <= 0.5 && self.0.transmission_weight <= 0.5
    }
}
