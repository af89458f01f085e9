//! Memory that pictures take while a scene is prepared, asked for beforehand.

use std::collections::BTreeSet;

use crate::description::SceneDesc;
use crate::schema::error::escape;
use crate::schema::{ImageId, Memory, SceneError};

impl SceneDesc {
    /// Asks for what is made of pictures: smaller sizes of those that textures show, tables of those that shine.
    pub(crate) fn need_for_pictures(&self, filtered: bool, memory: &Memory) -> Result<(), SceneError> {
        let samples = |id: ImageId| {
            self.images.get(id.index()).map_or(0, |i| i.data.memory() as u64 / i.data.pixels.sample_bytes())
        };
        let shown: BTreeSet<ImageId> = self.textures.iter().filter_map(|t| t.value.picture()).collect();
        if filtered && !shown.is_empty() {
            // A third of each, and the largest one's first two levels as numbers.
            let third: u64 = shown
                .iter()
                .filter_map(|id| self.images.get(id.index()))
                .map(|i| i.data.memory() as u64 / 3)
                .sum();
            let working = shown.iter().map(|id| samples(*id)).max().unwrap_or(0);
            memory.need(third.saturating_add(working.saturating_mul(5) / 4), || {
                format!("the smaller sizes of {} pictures", shown.len())
            })?;
        }
        for light in &self.lights {
            if let Some(image) = light.value.picture().and_then(|id| self.images.get(id.index())) {
                // Four bytes of a pixel for its column, one for the guide, two while it is made.
                let pixels = u64::from(image.data.width).saturating_mul(u64::from(image.data.height));
                memory
                    .need(pixels.saturating_mul(7), || format!("the environment {}", escape(&image.uri)))?;
            }
        }
        Ok(())
    }
}
