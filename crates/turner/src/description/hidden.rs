//! Descriptions without their hidden objects and lights.

use std::borrow::Cow;

use crate::description::SceneDesc;

impl SceneDesc {
    /// The scene without its hidden objects and lights, and their number. The pictures of both are the same; for
    /// programs and formats that do not know hidden parts.
    pub fn without_hidden(&self) -> (Cow<'_, SceneDesc>, usize) {
        let in_groups = self.groups.iter().flat_map(|group| &group.value.objects);
        let objects = self.objects.iter().chain(in_groups).filter(|object| object.hidden).count();
        let count = objects + self.lights.iter().filter(|light| light.hidden).count();
        if count == 0 {
            return (Cow::Borrowed(self), 0);
        }
        let mut shown = self.clone();
        shown.objects.retain(|object| !object.hidden);
        shown.groups.iter_mut().for_each(|group| group.value.objects.retain(|object| !object.hidden));
        shown.lights.retain(|light| !light.hidden);
        (Cow::Owned(shown), count)
    }
}
