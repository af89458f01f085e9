//! The parameters of an OpenPBR material at one point: [`PrincipledMaterial`](crate::material::PrincipledMaterial) with
//! its textures evaluated.

use super::facets::{FacetDistribution, FacetMasking};
use super::fresnel::MetalIndex;
use crate::color::Spectrum;

/// The parameters of a [`PrincipledMaterial`](crate::material::PrincipledMaterial) at one point, under the same names.
/// Weights, colours and roughnesses are clamped to 0..=1; NaN counts as 0. The colours of diffuse thin walls may exceed 1
/// as long as what is reflected and transmitted together does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipledPoint {
    /// Factor of the base colour.
    pub base_weight: f64,
    /// Diffuse colour of a dielectric; reflectance of a metal at normal incidence.
    pub base_color: Spectrum,
    /// Roughness of the diffuse lobe.
    pub base_diffuse_roughness: f64,
    /// 0 is a dielectric, 1 a metal.
    pub base_metalness: f64,
    /// The index of refraction of metal, instead of base colour and tint; `specular_color` is then a factor of its
    /// reflectance at all angles.
    pub metal_index: Option<MetalIndex>,
    /// Strength of specular reflection.
    pub specular_weight: f64,
    /// Colour of a dielectric's reflection from outside, and of a metal's towards grazing angles.
    pub specular_color: Spectrum,
    /// Whether these two are those of glTF's KHR_materials_specular: of a dielectric only, and the colour, which may
    /// exceed 1, is a factor of the reflectance at normal incidence.
    pub gltf_specular: bool,
    /// Roughness of reflection and transmission; α is its square.
    pub specular_roughness: f64,
    /// Whether light scattered several times between facets is returned.
    pub specular_multiple_scattering: bool,
    /// The distribution of microfacet normals, and their masking.
    pub specular_distribution: FacetDistribution,
    /// See `specular_distribution`.
    pub specular_masking: FacetMasking,
    /// Index of refraction inside; 0 reflects all light (glTF).
    pub specular_ior: f64,
    /// Index of refraction on the other side: 1 except inside another dielectric.
    pub exterior_ior: f64,
    /// Elongation of highlights along the tangent (x), 0..=1.
    pub specular_roughness_anisotropy: f64,
    /// Direction of anisotropy, counter-clockwise from x around z, in radians (the material has degrees).
    pub anisotropy_rotation: f64,
    /// α along x and y given directly, instead of roughness and anisotropy (glTF's formula differs from OpenPBR's).
    pub alpha: Option<(f64, f64)>,
    /// Fraction of the dielectric base that transmits light.
    pub transmission_weight: f64,
    /// Colour of transmitted light: at each crossing of the surface if `transmission_depth` is 0. Otherwise the
    /// interior absorbs, which the BSDF does not handle.
    pub transmission_color: Spectrum,
    /// See `transmission_color`.
    pub transmission_depth: f64,
    /// Colour of transmitted light at each crossing of the surface, in addition.
    pub transmission_tint: Spectrum,
    /// Fraction of the diffuse base that is translucent. In a thin wall that fraction is diffuse transmission.
    pub subsurface_weight: f64,
    /// Colour of the translucent part.
    pub subsurface_color: Spectrum,
    /// Whether light that enters the translucent part of a solid is scattered by a random walk
    /// ([`BsdfFromWo::enter`](super::BsdfFromWo::enter)); otherwise that part is a diffuse surface of the same colour.
    pub subsurface_walk: bool,
    /// Fraction covered by a clear coat.
    pub coat_weight: f64,
    /// Colour of light that crosses the coat twice at normal incidence.
    pub coat_color: Spectrum,
    /// Roughness of the coat.
    pub coat_roughness: f64,
    /// Index of refraction of the coat.
    pub coat_ior: f64,
    /// How much internal reflection under the coat darkens the base, 0..=1.
    pub coat_darkening: f64,
    /// Fraction covered by fuzz.
    pub fuzz_weight: f64,
    /// Colour of the fuzz.
    pub fuzz_color: Spectrum,
    /// Roughness of the fuzz.
    pub fuzz_roughness: f64,
    /// Fraction covered by a thin film.
    pub thin_film_weight: f64,
    /// Thickness of the film in micrometres.
    pub thin_film_thickness: f64,
    /// Index of refraction of the film.
    pub thin_film_ior: f64,
    /// A thin wall without an interior: transmitted light is not refracted.
    pub thin_walled: bool,
    /// Whether wo is outside: on the side of the geometric normal of a closed surface.
    pub entering: bool,
}

impl Default for PrincipledPoint {
    fn default() -> PrincipledPoint {
        PrincipledPoint {
            base_weight: 1.0,
            base_color: Spectrum::grey(0.8),
            base_diffuse_roughness: 0.0,
            base_metalness: 0.0,
            metal_index: None,
            specular_weight: 1.0,
            specular_color: Spectrum::WHITE,
            gltf_specular: false,
            specular_roughness: 0.3,
            specular_multiple_scattering: true,
            specular_distribution: FacetDistribution::Ggx,
            specular_masking: FacetMasking::Correlated,
            specular_ior: 1.5,
            exterior_ior: 1.0,
            specular_roughness_anisotropy: 0.0,
            anisotropy_rotation: 0.0,
            alpha: None,
            transmission_weight: 0.0,
            transmission_color: Spectrum::WHITE,
            transmission_depth: 0.0,
            transmission_tint: Spectrum::WHITE,
            subsurface_weight: 0.0,
            subsurface_color: Spectrum::grey(0.8),
            subsurface_walk: false,
            coat_weight: 0.0,
            coat_color: Spectrum::WHITE,
            coat_roughness: 0.0,
            coat_ior: 1.6,
            coat_darkening: 1.0,
            fuzz_weight: 0.0,
            fuzz_color: Spectrum::WHITE,
            fuzz_roughness: 0.5,
            thin_film_weight: 0.0,
            thin_film_thickness: 0.5,
            thin_film_ior: 1.4,
            thin_walled: false,
            entering: true,
        }
    }
}
