//! The principled material: one layered surface for plastic, metal, glass, cloth, lacquer and skin, with the names and
//! layers of OpenPBR 1.1 (Academy Software Foundation, 2024). Every glTF and MTL material converts to it.

use crate::bsdf::{FacetDistribution, FacetMasking, MetalIndex};
use crate::color::Spectrum;
use crate::schema::{ColorSource, MediumId, Range, choice, params};

choice! {
    /// The meaning of `opacity`.
    pub enum AlphaMode {
        /// Ignored: the surface is opaque.
        Opaque = "opaque",
        /// Alpha test: the surface is opaque where the opacity is at least `alpha_cutoff`, otherwise transparent.
        Mask = "mask",
        /// Alpha blending: the opacity is the fraction of the background that is covered.
        Blend = "blend",
    }
}

choice! {
    /// What `specular_weight` and `specular_color` mean.
    pub enum SpecularModel {
        /// OpenPBR: the weight is a factor of F₀, the colour a factor of a dielectric's reflection at all angles and of a
        /// metal's towards grazing angles.
        OpenPbr = "openpbr",
        /// glTF's KHR_materials_specular, Blender's specular tint: the colour, which may exceed 1, is a factor of F₀, and
        /// grazing reflection is white; the weight is a factor of the whole reflection. Metals ignore both.
        Gltf = "gltf",
    }
}

choice! {
    /// The unit of bump map heights.
    pub enum BumpUnit {
        /// Scene units.
        Scene = "scene",
        /// Texture tiles: the length on the surface over which u or v grows by 1, independent of the scene's scale.
        Tile = "tile",
    }
}

/// A bump map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump {
    /// The heights: the mean of the colour, 0 to 1.
    pub map: ColorSource,
    /// Height of 1 above 0.
    pub scale: f64,
    /// Its unit.
    pub unit: BumpUnit,
}

impl Bump {
    /// `None` for maps without effect: constants and scale 0.
    pub fn new(map: Option<ColorSource>, scale: f64, unit: BumpUnit) -> Option<Bump> {
        match map {
            Some(map @ ColorSource::Texture(_)) if scale != 0.0 => Some(Bump { map, scale, unit }),
            _ => None,
        }
    }
}

/// A constant grey.
const fn grey(v: f32) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v))
}

/// OpenPBR's default, roughly skin.
const RADIUS_SCALE: ColorSource = ColorSource::Constant(Spectrum::new(1.0, 0.5, 0.25));

params! {
    /// The principled material, with the parameter names of OpenPBR 1.1: a base (metal, or a dielectric that is
    /// diffuse, transmissive or translucent) under a coat and fuzz. Weights and other values from 0 to 1 can be
    /// textures: use an image with `channel = "g"` and `encoding = "linear"`. The integrator "classic" converts it and
    /// ignores fuzz, film, anisotropy, subsurface, dispersion and absorption.
    pub struct PrincipledMaterial as "principled" {
        /// Factor of `base_color`.
        base_weight: ColorSource = grey(1.0), in Range::UNIT;
        /// Diffuse albedo of a dielectric; reflectance of a metal at normal incidence.
        base_color: ColorSource = grey(0.8), in Range::NON_NEGATIVE;
        /// Roughness of diffuse reflection (energy-preserving Oren-Nayar): 0 is Lambertian, 1 very rough.
        base_diffuse_roughness: ColorSource = grey(0.0), in Range::UNIT;
        /// 0 is a dielectric, 1 a metal; values between mix the two.
        base_metalness: ColorSource = grey(0.0), in Range::UNIT;
        /// Index of refraction of a metal by colour band, with `metal_k`: its reflectance follows from the Fresnel
        /// equations, `base_color` does not count, and `specular_color` is a factor at all angles.
        metal_eta: Option<Spectrum> = None, in Range::closed(0.0, 100.0);
        /// The imaginary part of that index: how strongly the metal absorbs.
        metal_k: Option<Spectrum> = None, in Range::closed(0.0, 100.0);
        /// Strength of specular reflection: 0 none, 1 as the index of refraction gives it. Above 1 increases the
        /// reflectance.
        specular_weight: ColorSource = grey(1.0), in Range::NON_NEGATIVE;
        /// Colour of a dielectric's specular reflection, and of a metal's towards grazing angles.
        specular_color: ColorSource = grey(1.0), in Range::NON_NEGATIVE;
        /// What `specular_weight` and `specular_color` mean.
        specular_model: SpecularModel = SpecularModel::OpenPbr;
        /// Roughness of specular reflection and transmission: 0 is a perfect mirror or clear glass, 1 very rough. α
        /// is its square.
        specular_roughness: ColorSource = grey(0.3), in Range::UNIT;
        /// Whether light scattered several times between microfacets is included. Without it, rougher surfaces are darker,
        /// as in renderers with single-scattering microfacet models.
        specular_multiple_scattering: bool = true;
        /// The distribution of microfacet normals.
        specular_distribution: FacetDistribution = FacetDistribution::Ggx;
        /// How masking and shadowing of microfacets combine.
        specular_masking: FacetMasking = FacetMasking::Correlated;
        /// Index of refraction: water 1.33, glass 1.5, diamond 2.42. 1 has no specular effect; 0 reflects all light
        /// (glTF).
        specular_ior: f64 = 1.5, in Range::closed(0.0, 100.0);
        /// Elongation of highlights along the tangent: 0 is isotropic, 1 extremely anisotropic.
        specular_roughness_anisotropy: ColorSource = grey(0.0), in Range::UNIT;
        /// GGX's or Beckmann's α along the tangent, instead of `specular_roughness` and its anisotropy: a number or a texture.
        specular_alpha_x: Option<ColorSource> = None, in Range::UNIT;
        /// α along the bitangent; without it that along the tangent, and the reverse.
        specular_alpha_y: Option<ColorSource> = None, in Range::UNIT;
        /// Rotation of the anisotropy direction in degrees, counter-clockwise from the tangent.
        anisotropy_rotation: f64 = 0.0;
        /// glTF's anisotropy texture: red and green are the direction, blue the strength. Use `encoding = "linear"`.
        anisotropy_map: Option<ColorSource> = None;
        /// Fraction of the dielectric base that transmits light, like glass: 0 opaque, 1 clear.
        transmission_weight: ColorSource = grey(0.0), in Range::UNIT;
        /// Colour of transmitted light: at each crossing of the surface, or after `transmission_depth`.
        transmission_color: ColorSource = grey(1.0), in Range::NON_NEGATIVE;
        /// Distance inside after which light has `transmission_color` (Beer-Lambert absorption), in scene units. 0
        /// tints at the surface.
        transmission_depth: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Colour of transmitted light at each crossing of the surface, in addition to `transmission_color`: print on
        /// coloured glass. glTF's base colour.
        transmission_tint: ColorSource = grey(1.0), in Range::NON_NEGATIVE;
        /// Strength of dispersion: 0 none, 1 as the Abbe number gives it. Blue light is refracted more than red. A path
        /// that is refracted with dispersion continues with one colour band, so the render needs more samples.
        transmission_dispersion_scale: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Abbe number at dispersion scale 1: low is strong dispersion. Glass has 25 to 65, diamond 55.
        transmission_dispersion_abbe_number: f64 = 20.0, in Range::POSITIVE;
        /// The medium inside, if light is transmitted, passes a thin wall, or passes where alpha blending leaves the surface
        /// transparent: murky water, milk, amber. It absorbs in addition to
        /// `transmission_depth`. Only for the integrators "path" and "direct".
        interior: Option<MediumId> = None;
        /// Fraction of the diffuse base with subsurface scattering (wax, skin, marble, milk): light enters, is
        /// scattered inside and leaves elsewhere. The integrators "path" and "direct" trace random walks; others show a
        /// diffuse surface. In a thin wall it is diffuse transmission.
        subsurface_weight: ColorSource = grey(0.0), in Range::UNIT;
        /// Colour of the subsurface part: the colour that a thick object shows.
        subsurface_color: ColorSource = grey(0.8), in Range::NON_NEGATIVE;
        /// Mean free path of light inside, in scene units. 0 makes the subsurface part a diffuse surface.
        subsurface_radius: f64 = 1.0, in Range::NON_NEGATIVE;
        /// Factors of `subsurface_radius` by colour: in skin and wax red light travels farthest.
        subsurface_radius_scale: ColorSource = RADIUS_SCALE, in Range::NON_NEGATIVE;
        /// Mean cosine of the scattering angle inside: 0 is isotropic, above 0 forward, below 0 backward.
        subsurface_scatter_anisotropy: f64 = 0.0, in Range::closed(-1.0, 1.0);
        /// Fraction of the surface covered by a clear coat.
        coat_weight: ColorSource = grey(0.0), in Range::UNIT;
        /// Colour of the coat: what it transmits of light that crosses it twice at normal incidence.
        coat_color: ColorSource = grey(1.0), in Range::NON_NEGATIVE;
        /// Roughness of the coat: 0 is a smooth coat. The GGX α is its square.
        coat_roughness: ColorSource = grey(0.0), in Range::UNIT;
        /// Index of refraction of the coat.
        coat_ior: f64 = 1.6, in Range::POSITIVE;
        /// How much internal reflection under the coat darkens the base: 0 none, 1 physically correct.
        coat_darkening: f64 = 1.0, in Range::UNIT;
        /// Fraction of the surface covered by fuzz: the sheen of cloth and dust.
        fuzz_weight: ColorSource = grey(0.0), in Range::UNIT;
        /// Colour of the fuzz.
        fuzz_color: ColorSource = grey(1.0), in Range::NON_NEGATIVE;
        /// Roughness of the fuzz.
        fuzz_roughness: ColorSource = grey(0.5), in Range::UNIT;
        /// Fraction of the surface covered by a thin film, which shows interference colours.
        thin_film_weight: ColorSource = grey(0.0), in Range::UNIT;
        /// Thickness of the film in micrometres.
        thin_film_thickness: ColorSource = grey(0.5), in Range::NON_NEGATIVE;
        /// Index of refraction of the film.
        thin_film_ior: f64 = 1.4, in Range::POSITIVE;
        /// Emitted radiance, a factor of `emission_color`.
        emission_luminance: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Colour of the emission.
        emission_color: ColorSource = grey(1.0), in Range::NON_NEGATIVE;
        /// Whether only the front face emits, the side of the normal. The back face is still visible, without emission.
        emission_front_only: bool = false;
        /// Whether only the front face of an opaque surface reflects light. The back face is black, as in renderers
        /// with one-sided surfaces.
        front_only: bool = false;
        /// Opacity from 0 (transparent) to 1 (opaque); `alpha_mode` determines its use. A number or a texture. Of a
        /// texture, the alpha of an image or vertex colour if it has one, otherwise the mean of the colour.
        opacity: ColorSource = grey(1.0), in Range::UNIT;
        /// How `opacity` is used: opaque, alpha test or alpha blending.
        alpha_mode: AlphaMode = AlphaMode::Mask;
        /// Least opacity of an opaque point in the mode "mask".
        alpha_cutoff: f64 = 0.5, in Range::NON_NEGATIVE;
        /// A thin wall, like a window pane or a soap bubble: transmitted light is not refracted.
        thin_walled: bool = false;
        /// Whether the back face is visible. If not, rays that hit it pass through, as in glTF. Transmissive surfaces
        /// always have a back face.
        double_sided: bool = true;
        /// Shows `base_color` unchanged, without lighting.
        unlit: bool = false;
        /// Normal map in tangent space: red along u, green along v. Use an image with `encoding = "linear"`.
        normal_map: Option<ColorSource> = None;
        /// Strength of the normal map: factor of red and green.
        normal_scale: f64 = 1.0;
        /// Normal map of the coat. Without it the coat has the surface's own normal.
        coat_normal_map: Option<ColorSource> = None;
        /// Strength of the coat's normal map: factor of red and green.
        coat_normal_scale: f64 = 1.0;
        /// Bump map: a texture of heights, white is high. It changes the shading normal, not the shape. It is applied
        /// together with `normal_map`.
        bump_map: Option<ColorSource> = None;
        /// Height of white above black, in `bump_unit`; negative inverts.
        bump_scale: f64 = 0.1;
        /// The unit of `bump_scale`.
        bump_unit: BumpUnit = BumpUnit::Scene;
        /// Whether diffuse reflection of meshes with smooth normals fades before the shadow terminator, which hides the
        /// edges of coarse triangles. The total reflectance stays. pbrt and Mitsuba do not do this.
        soften_terminator: bool = true;
        /// Ambient occlusion texture: the fraction of ambient light that arrives. Only for the integrator "classic";
        /// "path" and "direct" compute it.
        occlusion_map: Option<ColorSource> = None;
        /// Strength of `occlusion_map`: 0 ignores it, 1 applies it fully.
        occlusion_strength: f64 = 1.0, in Range::UNIT;
        /// glTF's volume thickness of surfaces without a back. Ignored: ray tracing uses the geometry.
        thickness: ColorSource = grey(0.0), in Range::NON_NEGATIVE;
    }
    example r##"[material.gold]
type = "principled"
base_color = [1, 0.78, 0.34]
base_metalness = 1
specular_roughness = 0.2

[[object]]
type = "sphere"
material = "gold"
"##
}

impl PrincipledMaterial {
    /// Its bump map.
    #[inline]
    pub fn bump(&self) -> Option<Bump> {
        Bump::new(self.bump_map, self.bump_scale, self.bump_unit)
    }

    /// The index of refraction of its metal.
    pub(super) fn metal_index(&self) -> Option<MetalIndex> {
        let given = self.metal_eta.is_some() || self.metal_k.is_some();
        let (eta, k) = (self.metal_eta.unwrap_or(Spectrum::WHITE), self.metal_k.unwrap_or(Spectrum::BLACK));
        given.then(|| MetalIndex::new(eta, k))
    }

    /// A diffuse surface without specular reflection.
    pub fn matte() -> PrincipledMaterial {
        PrincipledMaterial { specular_weight: grey(0.0), ..PrincipledMaterial::default() }
    }
}
