//! Hair: the whole sphere of directions reaches a fibre, and none is lost.

use crate::bsdf::{Bsdf, HairPoint};
use crate::color::Spectrum;
use crate::description::SceneDesc;
use crate::integrator::PathDesc;
use crate::integrator::path::LightSampling;
use crate::light::{DirectionalDesc, LightDesc};
use crate::material::{HairMaterial, MaterialDesc};
use crate::math::DVec3;
use crate::schema::{MeshData, MeshId};
use crate::shape::ShapeDesc;
use crate::shape::curves::{CurveBasis, CurveKind, CurvesDesc};
use crate::testing::scenes::{mean, path, v};

const STRATEGIES: [LightSampling; 3] = [LightSampling::Both, LightSampling::Bsdf, LightSampling::Light];

/// Fibres along x of width 1 at the heights `y`, seen by a narrow camera that looks along −z at the first.
fn fibres(kind: CurveKind, y: &[f32], material: HairMaterial, by: LightSampling) -> SceneDesc {
    let by = PathDesc { light_sampling: by, max_depth: 200, rr_start: Some(1000), ..PathDesc::default() };
    let mut desc = path(by).seen_from_front(10.0, 0.001);
    desc.mesh(MeshData {
        positions: y.iter().flat_map(|y| [[-3.0, *y, 0.0], [3.0, *y, 0.0]]).collect(),
        strands: vec![2; y.len()],
        ..MeshData::default()
    });
    let basis = CurveBasis::Linear;
    let curves = CurvesDesc { curves: MeshId(0), width: Some(1.0), basis, kind };
    desc.with(ShapeDesc::Curves(curves), MaterialDesc::Hair(material))
}

#[test]
fn light_from_every_side_is_that_of_the_bsdf() {
    let sigma_a = Spectrum::new(0.1, 0.3, 0.8);
    let material = HairMaterial { sigma_a: Some(sigma_a), ..HairMaterial::default() };
    let point = HairPoint {
        sigma_a: sigma_a.to_array().map(f64::from),
        h: 0.0,
        beta_m: material.beta_m,
        beta_n: material.beta_n,
        alpha: material.alpha,
        ior: material.ior,
    };
    for kind in [CurveKind::Tube, CurveKind::Flat] {
        for wi in
            [v(0.0, 0.0, -1.0), v(0.3, 0.2, -1.0), v(0.2, 1.0, -0.1), v(0.0, 0.0, 1.0), v(-0.4, -1.0, 0.3)]
        {
            let wi = wi.normalize();
            let light = DirectionalDesc { from: Some(wi), intensity: 2.0, ..DirectionalDesc::default() };
            let desc = fibres(kind, &[0.0], material.clone(), LightSampling::Both)
                .lit(LightDesc::Directional(light));
            let f = Bsdf::hair(&point).eval(DVec3::Z, wi).to_array();
            let expected = f.map(|f| 2.0 * f64::from(f) * wi.z.abs());
            let found = mean(1, desc).value();
            for (a, b) in found.into_iter().zip(expected) {
                // The camera sees h = 0 within 1e-4.
                assert!((a - b).abs() < 1e-3 * b + 1e-6, "{kind:?} {wi}: {a} {b}");
            }
        }
    }
}

/// Fibres that absorb nothing cannot be told from a uniform background: light crosses from one to the other and leaves.
#[test]
fn white_fibres_vanish_before_a_white_background() {
    let white = HairMaterial { sigma_a: Some(Spectrum::BLACK), ..HairMaterial::default() };
    for kind in [CurveKind::Tube, CurveKind::Flat] {
        for by in STRATEGIES {
            let desc = fibres(kind, &[0.0, 1.2, -1.1], white.clone(), by).before(1.0);
            mean(256, desc).is_grey(1.0, 0.02);
        }
    }
}
