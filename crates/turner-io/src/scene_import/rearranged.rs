//! Images that are made of the pixels of others.

use turner::image::{Image, Pixels};
use turner::schema::ImageId;

use super::CommonParts;

/// An image of `size` (columns, rows) whose pixel (x, y) is the pixel `from(x, y)` of another one. `None` if that has no
/// such pixel, or if memory is short.
pub(crate) fn rearranged(
    old: &Image,
    size: [u32; 2],
    from: impl Fn(u32, u32) -> (u32, u32),
) -> Option<Image> {
    let [width, height] = size;
    let channels = usize::from(old.channels);
    let first = |x: u32, y: u32| {
        let (x, y) = from(x, y);
        (y as usize * old.width as usize + x as usize) * channels
    };
    let places = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| first(x, y));
    fn spread<T: Copy>(old: &[T], channels: usize, places: impl Iterator<Item = usize>) -> Option<Vec<T>> {
        let mut out = Vec::new();
        out.try_reserve_exact(old.len()).ok()?;
        for at in places {
            out.extend_from_slice(old.get(at..at + channels)?);
        }
        Some(out)
    }
    let pixels = match &old.pixels {
        Pixels::U8(p) => Pixels::U8(spread(p, channels, places())?),
        Pixels::U16(p) => Pixels::U16(spread(p, channels, places())?),
        Pixels::F32(p) => Pixels::F32(spread(p, channels, places())?),
    };
    Some(Image { width, height, channels: old.channels, pixels })
}

impl CommonParts<'_> {
    /// An image that is derived from that of the file `name`; `how` says which of them, and each is made once. `None` if
    /// memory is short.
    pub(crate) fn derived_image(
        &mut self,
        (name, id): (&str, ImageId),
        how: &str,
        make: impl FnOnce(&Image) -> Option<Image>,
    ) -> Option<ImageId> {
        let key = format!("{name}\0{how}");
        if let Some(known) = self.image_ids.get(&key) {
            return *known;
        }
        let old = self.images.get(id.index())?.data.clone();
        let made = if self.may_copy(old.memory() as u64) { make(&old)? } else { return None };
        let made = self.add_image(name, made);
        self.image_ids.insert(key, Some(made));
        Some(made)
    }
}
