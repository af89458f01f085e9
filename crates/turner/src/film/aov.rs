//! AOVs (arbitrary output variables): further channels of a picture, from the same samples as its colour.
//!
//! One line of the enum [`Aov`] and one of [`Aov::layout`] declare an AOV: its name, its channels in an EXR file and
//! how a pixel's samples become its value. Its value at a sample is in [`crate::integrator::aovs`].

use super::caught::CAUGHT;
use super::labels::{LabelChannel, LabelRule};
use super::{Channel, Film, FilmDesc, Fixed96, strips};
use crate::schema::choice;

choice! {
    /// A further output of a render, next to its colour.
    pub enum Aov {
        /// Base colour of the material at the first hit, without light. 0 where nothing is hit.
        Albedo = "albedo",
        /// Shading normal at the first hit, in world space, towards the viewer. 0 where nothing is hit.
        Normal = "normal",
        /// Geometric normal at the first hit, in world space, out of the shape. 0 where nothing is hit.
        GeometricNormal = "geometric_normal",
        /// Shading normal in the camera's axes: x right, y up, z towards the viewer. 0 where nothing is hit.
        CameraNormal = "camera_normal",
        /// Distance from the camera to the first hit along the viewing direction, in scene units, averaged over the
        /// samples that hit something. 1e10 where nothing is hit.
        Depth = "depth",
        /// Distance from the camera to the first hit along the ray, in scene units, averaged over the samples that hit
        /// something. 1e10 where nothing is hit.
        Distance = "distance",
        /// Position of the first hit in world space, in scene units, averaged over the samples that hit something.
        Position = "position",
        /// Texture coordinates at the first hit, averaged over the samples that hit something.
        Uv = "uv",
        /// Motion of the first hit in the picture while the shutter is open, in pixels, x right and y up, averaged over
        /// the samples that hit something.
        Motion = "motion",
        /// Number of the object at the sample nearest to the pixel's centre, from 1 in the order of the description,
        /// instances in order; 0 where nothing is hit.
        ObjectId = "object_id",
        /// Number of the material at the sample nearest to the pixel's centre, from 1; 0 where nothing is hit.
        MaterialId = "material_id",
        /// Number of the entry of the scene's list of objects, which may be an instance or a model, at the sample
        /// nearest to the pixel's centre, from 1; 0 where nothing is hit.
        InstanceId = "instance_id",
        /// Cryptomatte of objects: mattes with smooth edges by the names of objects.
        CryptoObject = "crypto_object",
        /// Cryptomatte of materials: mattes with smooth edges by the names of materials.
        CryptoMaterial = "crypto_material",
        /// Cryptomatte of instances and models: mattes with smooth edges by the names in the scene's list of objects.
        CryptoAsset = "crypto_asset",
        /// Light of emitters and background that is seen directly. Integrators "path" and "direct".
        Emission = "emission",
        /// Light that was scattered once on its way from an emitter to the camera. Integrators "path" and "direct".
        Direct = "direct",
        /// Light that was scattered more than once, without the light paths of "caustics". Integrators "path" and
        /// "direct".
        Indirect = "indirect",
        /// Light of each light group: a layer `light.NAME` for each `light_group` of the scene, and `light.default` for
        /// light of no group. Integrators "path" and "direct".
        LightGroups = "light_groups",
        /// Light that light paths bring, with `caustics` of the integrator "path".
        Caustics = "caustics",
        /// Light that the first surface reflects diffusely, directly from an emitter. The six layers from `direct_diffuse`
        /// to `volume`, `emission` and `caustics` add up to the picture. Integrators "path" and "direct".
        DirectDiffuse = "direct_diffuse",
        /// Light that the first surface reflects in any other way, directly from an emitter: specular reflection, coat,
        /// fuzz. Integrators "path" and "direct".
        DirectSpecular = "direct_specular",
        /// Light of other surfaces and media that the first surface reflects diffusely, with light of photons and of
        /// subsurface scattering. Integrators "path" and "direct".
        IndirectDiffuse = "indirect_diffuse",
        /// Light of other surfaces and media that the first surface reflects in any other way, as mirrors do. Integrators
        /// "path" and "direct".
        IndirectSpecular = "indirect_specular",
        /// Light that the first surface transmits. Integrators "path" and "direct".
        Transmission = "transmission",
        /// Light that a participating medium in front of the first surface scatters. Integrators "path" and "direct".
        Volume = "volume",
        /// Number of samples of the pixel.
        SampleCount = "sample_count",
        /// Number of rays per sample: camera rays, the rays that continue paths, and shadow rays. Integrators "path" and
        /// "direct".
        Cost = "cost",
        /// Number of bounces of the paths of the pixel, on average. Integrators "path" and "direct".
        Bounces = "bounces",
        /// The fraction of the direct light that objects keep from the shadow catchers in the pixel, times their
        /// coverage.
        Shadow = "shadow",
        /// Variance of the pixel's luminance, as if its samples were independent; 0 with fewer than two of them.
        Variance = "variance",
        /// What the denoiser needs: albedo, normal and logarithmic distance of the first surface that is not polished,
        /// followed through glass and mirrors, the emission that is seen there, and second moments. Integrators "path" and
        /// "direct". `denoise` asks for it.
        Denoising = "denoising",
        /// Half the width of the interval of the luminance that holds the converged value with a probability of 95 %; 0
        /// without an estimate: it needs random samples, at least four per pixel.
        Error = "error",
    }
}

/// How the samples of a pixel become its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Average {
    /// The weighted mean, as for colour. Samples that hit nothing count as 0.
    Samples,
    /// The weighted mean over the samples that hit something, and the value where none does.
    Hits(f32),
    /// The label of the sample nearest to the pixel's centre.
    Nearest,
    /// The fraction of the pixel that each label covers.
    Coverage,
    /// Known to the film without further sums.
    Film,
}

/// The channels of an AOV.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// The names of its channels in an EXR file, complete; for Cryptomatte that of the layers. `NAME` stands for each
    /// light group.
    pub channels: &'static [&'static str],
    /// How samples become a pixel.
    pub average: Average,
    /// What its values are measured in, in a few words.
    pub unit: &'static str,
}

/// What labels number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LabelKind {
    /// Objects.
    Object,
    /// Materials.
    Material,
    /// Entries of the scene's list of objects.
    Instance,
}

/// The channels of [`Aov::Denoising`], in the order of
/// [`DenoisingSample::values`](crate::integrator::DenoisingSample::values).
///
/// `moments` are means of squares: X of the luminance of `emission`, Y of that of the rest of the colour;
/// `guides` of the albedo (X) and of the logarithmic distance (Y).
pub(crate) const DENOISING_CHANNELS: [&str; 15] = [
    "denoising.albedo.R",
    "denoising.albedo.G",
    "denoising.albedo.B",
    "denoising.N.X",
    "denoising.N.Y",
    "denoising.N.Z",
    "denoising.Z",
    "denoising.hits.A",
    "denoising.emission.R",
    "denoising.emission.G",
    "denoising.emission.B",
    "denoising.moments.X",
    "denoising.moments.Y",
    "denoising.guides.U",
    "denoising.guides.V",
];

/// Depth where nothing is hit.
const FAR: f32 = 1e10;

/// The channel with the fraction of samples that hit something. Films with AOVs have it.
pub const HITS: &str = "hits.A";

/// The number of layers of a Cryptomatte, each with two labels.
pub(crate) const CRYPTO_LAYERS: usize = 3;

impl Aov {
    /// All AOVs, in the order of their channels.
    pub fn all() -> impl Iterator<Item = Aov> {
        Aov::WORDS.iter().filter_map(|word| Aov::from_word(word))
    }

    /// Its channels and how they are averaged.
    pub fn layout(self) -> Layout {
        let row = |channels, average, unit| Layout { channels, average, unit };
        use Average::{Coverage, Film, Hits, Nearest, Samples};
        match self {
            Aov::Albedo => row(&["albedo.R", "albedo.G", "albedo.B"], Samples, "linear colour"),
            Aov::Normal => row(&["N.X", "N.Y", "N.Z"], Samples, "unit vector"),
            Aov::GeometricNormal => row(&["Ng.X", "Ng.Y", "Ng.Z"], Samples, "unit vector"),
            Aov::CameraNormal => row(&["Nc.X", "Nc.Y", "Nc.Z"], Samples, "unit vector"),
            Aov::Depth => row(&["Z"], Hits(FAR), "scene units"),
            Aov::Distance => row(&["distance.Z"], Hits(FAR), "scene units"),
            Aov::Position => row(&["P.X", "P.Y", "P.Z"], Hits(0.0), "scene units"),
            Aov::Uv => row(&["uv.U", "uv.V"], Hits(0.0), "texture coordinates"),
            Aov::Motion => row(&["motion.X", "motion.Y"], Hits(0.0), "pixels"),
            Aov::ObjectId => row(&["object_id"], Nearest, "number"),
            Aov::MaterialId => row(&["material_id"], Nearest, "number"),
            Aov::InstanceId => row(&["instance_id"], Nearest, "number"),
            Aov::CryptoObject => row(&["CryptoObject"], Coverage, "fraction of the pixel"),
            Aov::CryptoMaterial => row(&["CryptoMaterial"], Coverage, "fraction of the pixel"),
            Aov::CryptoAsset => row(&["CryptoAsset"], Coverage, "fraction of the pixel"),
            Aov::Emission => row(&["emission.R", "emission.G", "emission.B"], Samples, "radiance"),
            Aov::Direct => row(&["direct.R", "direct.G", "direct.B"], Samples, "radiance"),
            Aov::Indirect => row(&["indirect.R", "indirect.G", "indirect.B"], Samples, "radiance"),
            Aov::LightGroups => row(&["light.NAME.R", "light.NAME.G", "light.NAME.B"], Samples, "radiance"),
            Aov::Caustics => row(&["caustics.R", "caustics.G", "caustics.B"], Film, "radiance"),
            Aov::DirectDiffuse => {
                row(&["direct_diffuse.R", "direct_diffuse.G", "direct_diffuse.B"], Samples, "radiance")
            }
            Aov::DirectSpecular => {
                row(&["direct_specular.R", "direct_specular.G", "direct_specular.B"], Samples, "radiance")
            }
            Aov::IndirectDiffuse => {
                row(&["indirect_diffuse.R", "indirect_diffuse.G", "indirect_diffuse.B"], Samples, "radiance")
            }
            Aov::IndirectSpecular => row(
                &["indirect_specular.R", "indirect_specular.G", "indirect_specular.B"],
                Samples,
                "radiance",
            ),
            Aov::Transmission => {
                row(&["transmission.R", "transmission.G", "transmission.B"], Samples, "radiance")
            }
            Aov::Volume => row(&["volume.R", "volume.G", "volume.B"], Samples, "radiance"),
            Aov::SampleCount => row(&["sample_count"], Film, "samples"),
            Aov::Cost => row(&["cost"], Samples, "rays"),
            Aov::Bounces => row(&["bounces"], Samples, "bounces"),
            Aov::Shadow => row(&["shadow"], Film, "fraction"),
            Aov::Denoising => row(&DENOISING_CHANNELS, Samples, "see `denoise`"),
            Aov::Variance => row(&["variance"], Film, "radiance squared"),
            Aov::Error => row(&["error"], Film, "radiance"),
        }
    }

    /// What its labels number, if its values are labels.
    pub fn labels(self) -> Option<LabelKind> {
        match self {
            Aov::ObjectId | Aov::CryptoObject => Some(LabelKind::Object),
            Aov::MaterialId | Aov::CryptoMaterial => Some(LabelKind::Material),
            Aov::InstanceId | Aov::CryptoAsset => Some(LabelKind::Instance),
            Aov::Albedo
            | Aov::Normal
            | Aov::GeometricNormal
            | Aov::CameraNormal
            | Aov::Depth
            | Aov::Distance
            | Aov::Position
            | Aov::Uv
            | Aov::Motion
            | Aov::Emission
            | Aov::Direct
            | Aov::Indirect
            | Aov::LightGroups
            | Aov::Caustics
            | Aov::DirectDiffuse
            | Aov::DirectSpecular
            | Aov::IndirectDiffuse
            | Aov::IndirectSpecular
            | Aov::Transmission
            | Aov::Volume
            | Aov::SampleCount
            | Aov::Cost
            | Aov::Bounces
            | Aov::Shadow
            | Aov::Variance
            | Aov::Denoising
            | Aov::Error => None,
        }
    }

    /// Whether it is a part of the light, so that the integrator must tell its kinds of light apart.
    pub fn is_light(self) -> bool {
        matches!(self, Aov::Emission | Aov::Direct | Aov::Indirect | Aov::LightGroups | Aov::Denoising)
            || self.is_lobe()
    }

    /// Whether its value is known only when paths were traced, or is another kind of sum.
    pub(crate) fn needs_paths(self) -> bool {
        self.is_light() || matches!(self, Aov::Cost | Aov::Bounces | Aov::Denoising)
    }

    /// Whether it is the light of one lobe of the first surface.
    pub fn is_lobe(self) -> bool {
        Aov::LOBES.contains(&self)
    }

    /// The light by the lobe of the first surface that scatters it: with [`Aov::Emission`] and [`Aov::Caustics`] the whole
    /// picture.
    pub const LOBES: [Aov; 6] = [
        Aov::DirectDiffuse,
        Aov::DirectSpecular,
        Aov::IndirectDiffuse,
        Aov::IndirectSpecular,
        Aov::Transmission,
        Aov::Volume,
    ];

    /// Whether the samples have a value for each of its channels.
    pub(crate) fn has_sums(self) -> bool {
        matches!(self.layout().average, Average::Samples | Average::Hits(_))
    }
}

impl FilmDesc {
    /// The channels of its AOVs in the film, after [`HITS`]; empty without AOVs.
    pub(crate) fn channels(&self) -> Vec<Channel> {
        if !self.aovs.has_channels() {
            return Vec::new();
        }
        let names = self.aovs.summed().flat_map(|aov| self.aovs.channels_of(aov));
        let caught = CAUGHT.iter().filter(|_| self.aovs.catches_shadows()).map(|name| (*name).to_owned());
        std::iter::once(HITS.to_owned()).chain(names).chain(caught).map(Channel::new).collect()
    }

    /// The number of values per pixel of its developed AOVs.
    pub fn aov_values(&self) -> u64 {
        let values = |aov: Aov| match aov.layout().average {
            Average::Coverage => 4 * CRYPTO_LAYERS as u64,
            Average::Samples | Average::Hits(_) | Average::Nearest | Average::Film => {
                self.aovs.channels_of(aov).len() as u64
            }
        };
        self.aovs.iter().map(values).sum()
    }

    /// The labels of its AOVs.
    pub(crate) fn labels(&self) -> Vec<LabelChannel> {
        let label = |aov: Aov| {
            let rule = match aov.layout().average {
                Average::Nearest => LabelRule::Nearest,
                Average::Coverage => LabelRule::Coverage,
                Average::Samples | Average::Hits(_) | Average::Film => return None,
            };
            Some(LabelChannel { name: aov.word().to_owned(), rule })
        };
        self.aovs.iter().filter_map(label).collect()
    }
}

impl Film {
    /// The weighted means of an additional channel in all pixels of the crop, row by row; 0 without samples. Empty
    /// without such a channel. `threads` of 0 uses all.
    pub fn channel_values(&self, name: &str, threads: usize) -> Vec<f32> {
        let Some(channel) = self.channels().iter().position(|c| c.name == name) else { return Vec::new() };
        let crop = self.crop;
        let value = |x: u32, y: u32| {
            let (band, i) = self.place(x, y)?;
            let weight = band.sum(i).weight();
            (weight != 0.0).then(|| Fixed96::from_words(band.extra(i)[channel]).mean(weight) as f32)
        };
        strips::map(crop.area() as usize, threads, |i| {
            let (x, y) = (i as u32 % crop.width, i as u32 / crop.width);
            value(crop.x + x, crop.y + y).unwrap_or(0.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_of_all_aovs_have_different_names() {
        let all: Vec<Aov> = Aov::all().collect();
        assert_eq!(all.len(), Aov::WORDS.len());
        let mut names: Vec<&str> = all.iter().flat_map(|aov| aov.layout().channels).copied().collect();
        names.extend(super::super::COLOR_CHANNELS);
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
        let labels = |aov: &Aov| matches!(aov.layout().average, Average::Nearest | Average::Coverage);
        assert!(all.iter().all(|aov| labels(aov) == aov.labels().is_some()));
    }
}
