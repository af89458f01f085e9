//! Requests the memory for images before a scene is prepared.

use std::collections::BTreeSet;

use crate::description::SceneDesc;
use crate::schema::error::escape;
use crate::schema::{ImageId, Memory, SceneError};

impl SceneDesc {
    /// Requests memory for mipmaps of textures and sampling tables of environment maps.
    pub(crate) fn need_for_pictures(&self, filtered: bool, memory: &Memory) -> Result<(), SceneError> {
        let samples = |id: ImageId| {
            self.images.get(id.index()).map_or(0, |i| i.data.memory() as u64 / i.data.pixels.sample_bytes())
        };
        let shown: BTreeSet<ImageId> = self.textures.iter().filter_map(|t| t.value.picture()).collect();
        if filtered && !shown.is_empty() {
            // A third of each image, and the first two levels of the largest one as floats.
            let third: u64 = shown
                .iter()
                .filter_map(|id| self.images.get(id.index()))
                .map(|i| i.data.memory() as u64 / 3)
                .sum();
            let working = shown.iter().map(|id| samples(*id)).max().unwrap_or(0);
            memory.need(third.saturating_add(working.saturating_mul(5) / 4), || {
                format!("the mipmaps of {} images", shown.len())
            })?;
        }
        for light in &self.lights {
            if let Some(image) = light.value.picture().and_then(|id| self.images.get(id.index())) {
                // Per pixel: four bytes for its column in the table, one for the guide table, two during
                // construction.
                let pixels = u64::from(image.data.width).saturating_mul(u64::from(image.data.height));
                memory
                    .need(pixels.saturating_mul(7), || format!("the environment {}", escape(&image.uri)))?;
            }
        }
        Ok(())
    }
}
