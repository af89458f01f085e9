//! Prepared lights; unchanged ones are reused.

use std::sync::Arc;

use crate::animation::motion::Displacement;
use crate::color::Spectrum;
use crate::description::{SceneDesc, SceneLight};
use crate::image::Image;
use crate::integrator::Capabilities;
use crate::light::{Light, LightDesc, LightSetting};
use crate::math::DAffine3;
use crate::schema::{Asset, ErrorCode, SceneError, Transform, Warning, WarningKind};

/// Lights except ambient ones, for each its index in the description, and the sum of the ambient ones.
#[derive(Clone)]
pub(super) struct PreparedLights {
    pub(super) lights: Vec<Light>,
    pub(super) sources: Vec<Option<u32>>,
    pub(super) ambient: Spectrum,
    /// Number of lights of the description that were prepared again.
    pub(super) rebuilt: usize,
}

/// The lights of the last description.
#[derive(Default)]
pub(super) struct CachedLights {
    made: Vec<Made>,
    capabilities: Capabilities,
}

/// One light of a description and its prepared form.
struct Made {
    desc: LightDesc,
    hidden: bool,
    motion: Option<Transform>,
    image: Option<Arc<Image>>,
    lights: Vec<Light>,
    ambient: Spectrum,
}

/// The image of a light.
fn image_of(light: &LightDesc, images: &[Asset<Image>]) -> Option<Arc<Image>> {
    images.get(light.picture()?.index()).map(|asset| asset.data.clone())
}

fn same_image(a: &Option<Arc<Image>>, b: &Option<Arc<Image>>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        (a, b) => a.is_none() && b.is_none(),
    }
}

impl CachedLights {
    /// The lights of a description; unchanged ones are reused.
    ///
    /// Errors: those of the lights.
    pub(super) fn prepare(
        &mut self,
        desc: &SceneDesc,
        capabilities: Capabilities,
        threads: usize,
    ) -> Result<PreparedLights, SceneError> {
        if self.capabilities != capabilities {
            self.made.clear();
            self.capabilities = capabilities;
        }
        let mut rebuilt = 0;
        for (number, light) in desc.lights.iter().enumerate() {
            let image = image_of(&light.value, &desc.images);
            let same = |m: &Made| {
                m.desc == light.value
                    && m.hidden == light.hidden
                    && m.motion == light.motion
                    && same_image(&m.image, &image)
            };
            if self.made.get(number).is_some_and(same) {
                continue;
            }
            rebuilt += 1;
            let before = self.made.get(number).map_or(&[][..], |made| &made.lights);
            let setting = LightSetting {
                images: &desc.images,
                compensated: capabilities.compensates,
                physical: capabilities.physical,
                threads,
                before,
            };
            let made = make(light, image, &setting)?;
            match self.made.get_mut(number) {
                Some(slot) => *slot = made,
                None => self.made.push(made),
            }
        }
        self.made.truncate(desc.lights.len());
        let (mut lights, mut sources, mut ambient) = (Vec::new(), Vec::new(), Spectrum::BLACK);
        for (number, made) in self.made.iter().enumerate() {
            lights.extend(made.lights.iter().cloned());
            sources.resize(lights.len(), Some(number as u32));
            ambient += made.ambient;
        }
        Ok(PreparedLights { lights, sources, ambient, rebuilt })
    }
}

fn make(
    light: &SceneLight,
    image: Option<Arc<Image>>,
    setting: &LightSetting<'_>,
) -> Result<Made, SceneError> {
    let mut lights = Vec::new();
    let (desc, hidden, motion) = (light.value.clone(), light.hidden, light.motion);
    if hidden {
        return Ok(Made { desc, hidden, motion, image, lights, ambient: Spectrum::BLACK });
    }
    let ambient = light.value.prepare(setting, &mut lights).map_err(|e| e.or_at(light.span))?;
    Ok(Made { desc, hidden, motion, image, lights, ambient })
}

/// What moves each prepared light while the shutter is open, given the number of its description; empty if none moves.
/// With a `shutter` that opens and closes at once, lights stay where they are then.
///
/// Errors: a motion that is not invertible or mirrors; one of a light that cannot move.
pub(super) fn motions(
    desc: &SceneDesc,
    lights: &[Light],
    sources: &[Option<u32>],
) -> Result<Vec<Option<Displacement>>, SceneError> {
    let of_light = |(light, source): (&Light, &Option<u32>)| {
        let Some(own) = source.and_then(|i| desc.lights.get(i as usize)).filter(|own| own.moves()) else {
            return Ok(None);
        };
        if !light.is_delta() {
            let message = "environments, skies and directional lights with an angle cannot move: `motion` has no effect on them";
            return Err(SceneError::new(ErrorCode::Conflict, message)
                .help("remove `motion`")
                .or_at(own.span));
        }
        let motion = own.motion.unwrap_or_default();
        let place = light.point([0.5; 2]).unwrap_or_default();
        Displacement::new(&DAffine3::from_translation(place), &motion.0)
            .map(Some)
            .map_err(|e| e.or_at(own.span))
    };
    let motions = lights.iter().zip(sources).map(of_light).collect::<Result<Vec<_>, _>>()?;
    Ok(if motions.iter().any(Option::is_some) { motions } else { Vec::new() })
}

/// The warning about negative or non-finite pixels of an environment map.
pub(super) fn invalid_pixels(count: u64) -> Warning {
    let message =
        format!("{count} pixels of the environment map are negative or non-finite: 0 is used for them");
    Warning::new(WarningKind::Doubtful, message)
}
