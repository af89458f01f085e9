//! What the integrator knows of a sample besides its colour: parts of its light, its rays, the shadow that it caught.

use crate::color::Spectrum;
use crate::film::{Aov, FilmDesc, layers};
use crate::integrator::{CaughtLight, DenoisingSample, LobeParts, Radiance, SampleDetails};

/// Less light than this fraction of the sample, which remains for "default" after all groups, is rounding.
const ROUNDING: f32 = 1e-6;

/// The details of one sample, scaled down like its colour.
#[derive(Default)]
pub(super) struct SampleLight<'a> {
    /// The factors of `clamp_sample` and of the camera.
    by: f32,
    color: Spectrum,
    emission: Spectrum,
    direct: Spectrum,
    indirect: Spectrum,
    /// The light of each group of the scene, not scaled; empty if it is not known.
    groups: &'a [Spectrum],
    names: &'a [String],
    rays: u32,
    bounces: u32,
    lobes: LobeParts,
    denoising: DenoisingSample,
}

impl<'a> SampleLight<'a> {
    /// The light of a sample, by its index in the batch, and its factor by the camera; `names` are those of all light groups. Parts that the integrator does not
    /// know are 0.
    pub(super) fn new(
        film: &FilmDesc,
        radiance: &Radiance,
        details: &SampleDetails<'a>,
        (sample, weight): (usize, f32),
        names: &'a [String],
    ) -> SampleLight<'a> {
        let rays = details.rays.get(sample).copied().unwrap_or(0);
        let bounces = details.bounces.get(sample).copied().unwrap_or(0);
        let denoising = details.denoising.get(sample).copied().unwrap_or_default();
        let Some(part) = details.parts.get(sample) else {
            return SampleLight { rays, bounces, denoising, ..SampleLight::default() };
        };
        let by = weight * film.clamp_factor(radiance.color * weight);
        let indirect = radiance.color - part.emission - part.direct;
        let groups = details.groups.get(sample * names.len()..(sample + 1) * names.len());
        SampleLight {
            by,
            color: radiance.color * by,
            emission: part.emission * by,
            direct: part.direct * by,
            indirect: indirect * by,
            groups: groups.unwrap_or_default(),
            names,
            rays,
            bounces,
            lobes: details.lobes.get(sample).copied().unwrap_or_default(),
            denoising,
        }
    }

    /// Appends the values of an AOV; false if it is not one of these.
    pub(super) fn append(&self, aov: Aov, values: &mut Vec<f32>) -> bool {
        match aov {
            Aov::Emission => append(values, self.emission),
            Aov::Direct => append(values, self.direct),
            Aov::Indirect => append(values, self.indirect),
            Aov::LightGroups => self.append_groups(values),
            Aov::DirectDiffuse => append(values, self.lobes.direct_diffuse * self.by),
            Aov::DirectSpecular => append(values, self.lobes.direct_specular * self.by),
            Aov::IndirectDiffuse => append(values, self.indirect_diffuse()),
            Aov::IndirectSpecular => append(values, self.lobes.indirect_specular * self.by),
            Aov::Transmission => append(values, self.lobes.transmission * self.by),
            Aov::Volume => append(values, self.lobes.volume * self.by),
            Aov::Cost => values.push(self.rays as f32),
            Aov::Bounces => values.push(self.bounces as f32),
            Aov::Denoising => {
                values.extend(self.denoising.values(self.color, self.by).map(finite));
            }
            _ => return false,
        }
        true
    }

    fn append_groups(&self, values: &mut Vec<f32>) {
        let mut rest = self.color;
        for (group, _) in layers(self.names) {
            let light = self.groups.get(group).map_or(Spectrum::BLACK, |light| *light * self.by);
            append(values, light);
            rest = rest - light;
        }
        append(values, self.without_rounding(rest));
    }

    /// What remains for indirect light that is reflected diffusely.
    fn indirect_diffuse(&self) -> Spectrum {
        let LobeParts { direct_diffuse, direct_specular, indirect_specular, transmission, volume } =
            self.lobes;
        let known = direct_diffuse + direct_specular + indirect_specular + transmission + volume;
        self.without_rounding(self.color - self.emission - known * self.by)
    }

    /// A remainder of the colour, without what is only rounding.
    fn without_rounding(&self, rest: Spectrum) -> Spectrum {
        let least = ROUNDING * self.color.max_component();
        Spectrum::from(rest.to_array().map(|v| if v.abs() > least { v } else { 0.0 }))
    }
}

/// Appends what a film sums of a shadow catcher at a sample: see [`crate::film::Film::shadow`].
pub(super) fn append_caught(
    values: &mut Vec<f32>,
    film: &FilmDesc,
    radiance: &Radiance,
    weight: f32,
    caught: Option<&CaughtLight>,
) {
    let Some(caught) = caught.filter(|caught| caught.is_caught) else {
        return values.extend([0.0; 7]);
    };
    values.extend([1.0, finite(caught.shadowed), finite(caught.unshadowed)]);
    append(values, radiance.color * (weight * film.clamp_factor(radiance.color * weight)));
    values.push(finite(radiance.alpha));
}

/// Appends a colour.
fn append(values: &mut Vec<f32>, color: Spectrum) {
    values.extend(color.to_array().map(finite));
}

/// Values that are not finite become 0: they must not hide the colour of their sample.
pub(super) fn finite(v: f32) -> f32 {
    if v.is_finite() { v } else { 0.0 }
}
