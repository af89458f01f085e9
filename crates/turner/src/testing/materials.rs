//! Parameters of the principled material that together cover all its lobes, for the tests of this crate and of
//! others.

use crate::bsdf::{FacetDistribution, FacetMasking, PrincipledPoint};
use crate::color::Spectrum;

/// Names and parameters. Materials whose name begins with "white" absorb nothing: they pass the white furnace test.
#[expect(clippy::too_many_lines, reason = "a table")]
pub fn materials() -> Vec<(&'static str, PrincipledPoint)> {
    let p = PrincipledPoint { specular_weight: 0.0, ..Default::default() };
    let plastic = PrincipledPoint::default();
    let metal = PrincipledPoint {
        base_metalness: 1.0,
        base_color: Spectrum::new(1.0, 0.77, 0.34),
        ..Default::default()
    };
    let white_metal = PrincipledPoint { base_color: Spectrum::WHITE, ..metal };
    let glass = PrincipledPoint { transmission_weight: 1.0, specular_roughness: 0.0, ..Default::default() };
    let beckmann = |p| PrincipledPoint { specular_distribution: FacetDistribution::Beckmann, ..p };
    let coat = PrincipledPoint { coat_weight: 1.0, ..Default::default() };
    vec![
        ("matte", PrincipledPoint { base_color: Spectrum::new(0.8, 0.4, 0.1), ..p }),
        (
            "rough white matte",
            PrincipledPoint { base_color: Spectrum::WHITE, base_diffuse_roughness: 1.0, ..p },
        ),
        (
            "rough matte",
            PrincipledPoint { base_color: Spectrum::new(0.6, 0.2, 0.1), base_diffuse_roughness: 0.6, ..p },
        ),
        ("plastic", PrincipledPoint { base_color: Spectrum::new(0.1, 0.4, 0.8), ..plastic }),
        (
            "white plastic, smooth",
            PrincipledPoint { base_color: Spectrum::WHITE, specular_roughness: 0.0, ..plastic },
        ),
        (
            "white plastic, glossy",
            PrincipledPoint { base_color: Spectrum::WHITE, specular_roughness: 0.15, ..plastic },
        ),
        (
            "dull plastic",
            PrincipledPoint {
                base_color: Spectrum::WHITE,
                specular_roughness: 0.8,
                base_diffuse_roughness: 0.7,
                ..plastic
            },
        ),
        (
            "white plastic, dense",
            PrincipledPoint {
                base_color: Spectrum::WHITE,
                specular_roughness: 0.4,
                specular_ior: 2.7,
                ..plastic
            },
        ),
        (
            "plastic with a red highlight",
            PrincipledPoint { specular_color: Spectrum::new(0.9, 0.1, 0.1), ..plastic },
        ),
        (
            "plastic with a red F0",
            PrincipledPoint { gltf_specular: true, specular_color: Spectrum::new(12.0, 1.0, 0.0), ..plastic },
        ),
        (
            "white plastic with F0 .5, rough",
            PrincipledPoint {
                gltf_specular: true,
                base_color: Spectrum::WHITE,
                specular_color: Spectrum::grey(12.5),
                specular_weight: 0.8,
                specular_roughness: 0.7,
                ..plastic
            },
        ),
        (
            "white plastic without F0, smooth",
            PrincipledPoint {
                gltf_specular: true,
                base_color: Spectrum::WHITE,
                specular_color: Spectrum::BLACK,
                specular_roughness: 0.0,
                ..plastic
            },
        ),
        (
            "glass with a red F0, frosted",
            PrincipledPoint {
                gltf_specular: true,
                specular_color: Spectrum::new(9.0, 1.0, 0.2),
                specular_weight: 0.7,
                specular_roughness: 0.3,
                ..glass
            },
        ),
        (
            "white glass with F0 .3",
            PrincipledPoint { gltf_specular: true, specular_color: Spectrum::grey(7.5), ..glass },
        ),
        (
            "pane with a blue F0",
            PrincipledPoint {
                gltf_specular: true,
                specular_color: Spectrum::new(0.0, 1.0, 20.0),
                thin_walled: true,
                ..glass
            },
        ),
        ("white metal, mirror", PrincipledPoint { specular_roughness: 0.0, ..white_metal }),
        ("white metal, polished", PrincipledPoint { specular_roughness: 0.1, ..white_metal }),
        ("white metal, dull", PrincipledPoint { specular_roughness: 0.5, ..white_metal }),
        ("white metal, rough", PrincipledPoint { specular_roughness: 1.0, ..white_metal }),
        ("gold", PrincipledPoint { specular_color: Spectrum::new(0.9, 0.95, 1.0), ..metal }),
        (
            "brushed metal",
            PrincipledPoint {
                specular_roughness: 0.5,
                specular_roughness_anisotropy: 0.9,
                anisotropy_rotation: 0.6,
                ..white_metal
            },
        ),
        ("metal of given widths", PrincipledPoint { alpha: Some((0.05, 0.6)), ..white_metal }),
        ("metal with a film", PrincipledPoint { thin_film_weight: 1.0, thin_film_thickness: 0.4, ..metal }),
        (
            "white metal, Beckmann's facets",
            PrincipledPoint { specular_roughness: 0.6, ..beckmann(white_metal) },
        ),
        (
            "stretched metal, Beckmann's facets, independent masking",
            PrincipledPoint {
                specular_multiple_scattering: false,
                specular_masking: FacetMasking::Separable,
                alpha: Some((0.1, 0.4)),
                ..beckmann(metal)
            },
        ),
        (
            "metal, independent masking",
            PrincipledPoint {
                specular_roughness: 0.7,
                specular_masking: FacetMasking::Separable,
                specular_multiple_scattering: false,
                ..metal
            },
        ),
        ("white glass, Beckmann's facets", PrincipledPoint { specular_roughness: 0.5, ..beckmann(glass) }),
        (
            "white glass, Beckmann's facets, from inside",
            PrincipledPoint { specular_roughness: 0.5, entering: false, ..beckmann(glass) },
        ),
        (
            "white plastic, Beckmann's facets",
            PrincipledPoint { base_color: Spectrum::WHITE, specular_roughness: 0.6, ..beckmann(plastic) },
        ),
        (
            "plastic of single scattering, Beckmann's facets",
            PrincipledPoint {
                specular_roughness: 0.6,
                specular_multiple_scattering: false,
                specular_masking: FacetMasking::Separable,
                ..beckmann(plastic)
            },
        ),
        ("white glass, smooth", glass),
        ("white glass, from inside", PrincipledPoint { entering: false, ..glass }),
        ("white glass, rough", PrincipledPoint { specular_roughness: 0.5, ..glass }),
        (
            "white glass, rough, from inside",
            PrincipledPoint { specular_roughness: 0.5, entering: false, ..glass },
        ),
        ("white glass, very rough", PrincipledPoint { specular_roughness: 1.0, ..glass }),
        (
            "white glass, very rough, from inside",
            PrincipledPoint { specular_roughness: 1.0, entering: false, ..glass },
        ),
        ("white diamond, frosted", PrincipledPoint { specular_roughness: 0.3, specular_ior: 2.42, ..glass }),
        ("white bubble", PrincipledPoint { specular_roughness: 0.4, specular_ior: 0.75, ..glass }),
        ("white pane", PrincipledPoint { thin_walled: true, ..glass }),
        ("white pane, frosted", PrincipledPoint { thin_walled: true, specular_roughness: 0.5, ..glass }),
        (
            "green pane, frosted",
            PrincipledPoint {
                thin_walled: true,
                specular_roughness: 0.3,
                transmission_color: Spectrum::new(0.2, 0.9, 0.3),
                ..glass
            },
        ),
        (
            "white soap bubble",
            PrincipledPoint {
                thin_walled: true,
                thin_film_weight: 1.0,
                thin_film_ior: 1.33,
                thin_film_thickness: 0.5,
                specular_ior: 1.0,
                ..glass
            },
        ),
        (
            "lacquer",
            PrincipledPoint { base_color: Spectrum::new(0.7, 0.05, 0.02), coat_roughness: 0.1, ..coat },
        ),
        (
            "tinted coat on rough metal",
            PrincipledPoint {
                coat_weight: 1.0,
                coat_color: Spectrum::new(1.0, 0.5, 0.2),
                coat_roughness: 0.2,
                ..metal
            },
        ),
        (
            "half a coat on glass",
            PrincipledPoint { coat_weight: 0.5, coat_roughness: 0.3, specular_roughness: 0.4, ..glass },
        ),
        (
            "half a coat on glass in glass",
            PrincipledPoint { coat_weight: 0.5, coat_roughness: 0.3, exterior_ior: 1.5, ..glass },
        ),
        (
            "coat on white",
            PrincipledPoint { base_color: Spectrum::WHITE, coat_darkening: 0.0, coat_roughness: 0.3, ..coat },
        ),
        (
            "velvet",
            PrincipledPoint {
                base_color: Spectrum::new(0.3, 0.02, 0.05),
                fuzz_weight: 1.0,
                fuzz_roughness: 0.4,
                ..p
            },
        ),
        (
            "white cloth",
            PrincipledPoint { base_color: Spectrum::WHITE, fuzz_weight: 0.7, fuzz_roughness: 0.8, ..p },
        ),
        (
            "smooth fuzz on white plastic",
            PrincipledPoint { base_color: Spectrum::WHITE, fuzz_weight: 1.0, fuzz_roughness: 0.0, ..plastic },
        ),
        (
            "film on white plastic",
            PrincipledPoint {
                base_color: Spectrum::WHITE,
                thin_film_weight: 1.0,
                thin_film_ior: 1.8,
                ..plastic
            },
        ),
        (
            "leaf",
            PrincipledPoint {
                thin_walled: true,
                base_color: Spectrum::new(0.1, 0.3, 0.05),
                subsurface_weight: 0.5,
                subsurface_color: Spectrum::new(0.3, 0.7, 0.1),
                ..plastic
            },
        ),
        (
            "white paper",
            PrincipledPoint {
                thin_walled: true,
                base_color: Spectrum::WHITE,
                subsurface_weight: 0.4,
                subsurface_color: Spectrum::WHITE,
                ..p
            },
        ),
        (
            "skin",
            PrincipledPoint {
                subsurface_weight: 0.8,
                subsurface_color: Spectrum::new(0.8, 0.5, 0.4),
                specular_roughness: 0.45,
                ..plastic
            },
        ),
        (
            "everything",
            PrincipledPoint {
                base_metalness: 0.4,
                transmission_weight: 0.5,
                specular_roughness: 0.4,
                specular_roughness_anisotropy: 0.5,
                coat_weight: 0.5,
                coat_roughness: 0.25,
                fuzz_weight: 0.3,
                thin_film_weight: 0.5,
                base_diffuse_roughness: 0.3,
                ..plastic
            },
        ),
        (
            "everything, from inside",
            PrincipledPoint {
                base_metalness: 0.2,
                transmission_weight: 0.5,
                specular_roughness: 0.4,
                coat_weight: 0.5,
                coat_roughness: 0.25,
                fuzz_weight: 0.3,
                entering: false,
                ..plastic
            },
        ),
    ]
}
