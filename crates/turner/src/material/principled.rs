//! The physical material: one layered surface for plastic, metal, glass, cloth, lacquer and skin, with the names and
//! the layering of OpenPBR 1.1 (Academy Software Foundation, 2024). Every glTF and MTL material is one of these.

use crate::color::Spectrum;
use crate::schema::{ColorSource, MediumId, Range, choice, params};

choice! {
    /// What `opacity` means.
    pub enum AlphaMode {
        /// Nothing: the surface is there everywhere.
        Opaque = "opaque",
        /// The surface is there where the opacity is at least `alpha_cutoff`.
        Mask = "mask",
        /// The surface covers that share of what is behind it.
        Blend = "blend",
    }
}

choice! {
    /// What heights of a bump map are measured in.
    pub enum BumpUnit {
        /// Scene units.
        Scene = "scene",
        /// Sides of the texture: the length on the surface over which u or v grows by 1, whatever the scene's scale.
        Tile = "tile",
    }
}

/// A texture of heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump {
    /// The heights: the mean of its colour, 0 to 1.
    pub map: ColorSource,
    /// How high 1 stands above 0.
    pub scale: f64,
    /// In what unit.
    pub unit: BumpUnit,
}

impl Bump {
    /// Heights that matter; `None` of others.
    pub fn new(map: Option<ColorSource>, scale: f64, unit: BumpUnit) -> Option<Bump> {
        match map {
            Some(map @ ColorSource::Texture(_)) if scale != 0.0 => Some(Bump { map, scale, unit }),
            _ => None,
        }
    }
}

/// A source that is the same grey everywhere.
const fn grey(v: f32) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v))
}

/// OpenPBR's default, about that of skin.
const RADIUS_SCALE: ColorSource = ColorSource::Constant(Spectrum::new(1.0, 0.5, 0.25));

params! {
    /// The physical material, by the names of OpenPBR 1.1: a base (metal, or a dielectric that is diffuse, glassy or translucent) under a coat and a fuzz.
    /// Numbers between 0 and 1 may be textures, too: give them a picture with `channel = "g"` and `encoding = "linear"`.
    pub struct PrincipledMaterial as "principled" {
        /// Factor of the base colour.
        base_weight: ColorSource = grey(1.0), in Range::UNIT;
        /// Diffuse colour of a dielectric, reflectance of a metal seen head-on.
        base_color: ColorSource = grey(0.8), in Range::NON_NEGATIVE;
        /// Roughness of the diffuse part (Oren–Nayar).
        base_diffuse_roughness: ColorSource = grey(0.0), in Range::UNIT;
        /// 0 is a dielectric, 1 a metal.
        base_metalness: ColorSource = grey(0.0), in Range::UNIT;
        /// Strength of the specular reflection.
        specular_weight: ColorSource = grey(1.0), in Range::NON_NEGATIVE;
        /// Colour of a dielectric's reflection seen head-on, and of a metal's at grazing angles.
        specular_color: ColorSource = grey(1.0), in Range::NON_NEGATIVE;
        /// Roughness of reflection and transmission: 0 is a mirror. The width of the GGX lobe is its square.
        specular_roughness: ColorSource = grey(0.3), in Range::UNIT;
        /// Whether light that meets several microfacets of rough metal or glass is counted. Without, they are darker the rougher they are, as in renderers that
        /// follow light to one microfacet alone.
        specular_multiple_scattering: bool = true;
        /// Index of refraction. 0 reflects all light.
        specular_ior: f64 = 1.5, in Range::closed(0.0, 100.0);
        /// How much longer highlights are along the tangent than across.
        specular_roughness_anisotropy: ColorSource = grey(0.0), in Range::UNIT;
        /// Turns the direction of anisotropy, counter-clockwise from the tangent, in degrees.
        anisotropy_rotation: f64 = 0.0;
        /// glTF's picture of anisotropy: red and green are the direction, blue is the strength.
        anisotropy_map: Option<ColorSource> = None;
        /// Share of the dielectric base that light passes through, as through glass.
        transmission_weight: ColorSource = grey(0.0), in Range::UNIT;
        /// Colour of the light that passes: at the surface, or after `transmission_depth`.
        transmission_color: ColorSource = grey(1.0), in Range::NON_NEGATIVE;
        /// The way inside after which light has `transmission_color` (Beer–Lambert); 0 tints at the surface.
        transmission_depth: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Strength of dispersion: how much more than red light blue light is bent. 0 is none, 1 what the Abbe number says. A path that is first
        /// refracted so goes on with one colour band: the picture takes more samples.
        transmission_dispersion_scale: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Abbe number at strength 1: 20 is strong, glass has 25 to 65, diamond 55.
        transmission_dispersion_abbe_number: f64 = 20.0, in Range::POSITIVE;
        /// The medium inside, where light passes: murky water, milk, amber. It absorbs beside what `transmission_depth` says.
        interior: Option<MediumId> = None;
        /// Share of the diffuse base that is translucent: light walks about inside and comes out elsewhere, as in wax, skin, marble and milk. The integrators
        /// "path" and "direct" show that; for others it is a diffuse surface. In a thin wall, diffuse transmission.
        subsurface_weight: ColorSource = grey(0.0), in Range::UNIT;
        /// Colour of the translucent part, as it is seen where the body is thick.
        subsurface_color: ColorSource = grey(0.8), in Range::NON_NEGATIVE;
        /// How far light goes inside on average before it is scattered, in scene units; 0 makes it a diffuse surface.
        subsurface_radius: f64 = 1.0, in Range::NON_NEGATIVE;
        /// Factors of `subsurface_radius` by colour: red light goes farthest in skin and wax.
        subsurface_radius_scale: ColorSource = RADIUS_SCALE, in Range::NON_NEGATIVE;
        /// Mean cosine of the angle by which light is scattered inside: 0 evenly, towards 1 forwards, below 0 backwards.
        subsurface_scatter_anisotropy: f64 = 0.0, in Range::closed(-1.0, 1.0);
        /// Share covered by a clear coat.
        coat_weight: ColorSource = grey(0.0), in Range::UNIT;
        /// What the coat lets through.
        coat_color: ColorSource = grey(1.0), in Range::NON_NEGATIVE;
        /// Roughness of the coat.
        coat_roughness: ColorSource = grey(0.0), in Range::UNIT;
        /// Index of refraction of the coat.
        coat_ior: f64 = 1.6, in Range::POSITIVE;
        /// How much light that is caught under the coat darkens the base.
        coat_darkening: f64 = 1.0, in Range::UNIT;
        /// Share covered by fuzz, the sheen of cloth and dust.
        fuzz_weight: ColorSource = grey(0.0), in Range::UNIT;
        /// Colour of the fuzz.
        fuzz_color: ColorSource = grey(1.0), in Range::NON_NEGATIVE;
        /// Roughness of the fuzz.
        fuzz_roughness: ColorSource = grey(0.5), in Range::UNIT;
        /// Share covered by a thin film, which shows colours of interference.
        thin_film_weight: ColorSource = grey(0.0), in Range::UNIT;
        /// Thickness of the film in micrometres.
        thin_film_thickness: ColorSource = grey(0.5), in Range::NON_NEGATIVE;
        /// Index of refraction of the film.
        thin_film_ior: f64 = 1.4, in Range::POSITIVE;
        /// Radiance that the surface emits, a factor of `emission_color`.
        emission_luminance: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Colour of that light.
        emission_color: ColorSource = grey(1.0), in Range::NON_NEGATIVE;
        /// Whether only the outer side shines, the one that the normal points to; the back is there, and dark.
        emission_front_only: bool = false;
        /// Whether only the outer side of an opaque surface reflects light; the back is there, and black, as in renderers whose surfaces have one side.
        front_only: bool = false;
        /// How much of a surface there is; `alpha_mode` says what that means. A number, or a texture: the alpha of a picture that
        /// has one or of a vertex colour, the mean of any other colour.
        opacity: ColorSource = grey(1.0), in Range::UNIT;
        /// What `opacity` means. Without it "mask", where an opacity is given.
        alpha_mode: AlphaMode = AlphaMode::Mask;
        /// Least opacity that is there, for the mode "mask".
        alpha_cutoff: f64 = 0.5, in Range::NON_NEGATIVE;
        /// A wall without inside: light passes without being bent.
        thin_walled: bool = false;
        /// Whether the back shows; else rays from behind pass, as glTF asks for. Glass always has a back.
        double_sided: bool = true;
        /// Shows `base_color` as it is, whatever the light.
        unlit: bool = false;
        /// A picture of normals in the tangent frame (red along u, green along v), with `encoding = "linear"`.
        normal_map: Option<ColorSource> = None;
        /// Factor of its red and green parts.
        normal_scale: f64 = 1.0;
        /// The same for the coat, which has the surface's own normal otherwise.
        coat_normal_map: Option<ColorSource> = None;
        /// Factor of its red and green parts.
        coat_normal_scale: f64 = 1.0;
        /// A texture of heights that the normal follows as if the surface rose and fell with it: white stands highest. With `normal_map`, both count.
        bump_map: Option<ColorSource> = None;
        /// How high white stands above black, in `bump_unit`; below 0, how deep.
        bump_scale: f64 = 0.1;
        /// The unit of `bump_scale`.
        bump_unit: BumpUnit = BumpUnit::Scene;
        /// Share of light from all around that arrives, for the classic integrator; light transport itself finds it out.
        occlusion_map: Option<ColorSource> = None;
        /// How much of `occlusion_map` counts.
        occlusion_strength: f64 = 1.0, in Range::UNIT;
        /// Thickness of what a surface without a back stands for (glTF's volume); geometry itself says it in ray tracing.
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
    /// The heights that its normal follows.
    #[inline]
    pub fn bump(&self) -> Option<Bump> {
        Bump::new(self.bump_map, self.bump_scale, self.bump_unit)
    }

    /// A diffuse surface without reflection.
    pub fn matte() -> PrincipledMaterial {
        PrincipledMaterial { specular_weight: grey(0.0), ..PrincipledMaterial::default() }
    }
}
