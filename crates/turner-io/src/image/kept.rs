//! Keeps encoded images alongside the decoded ones, so that `turner convert` can copy them unchanged.

use std::sync::{Arc, Mutex};
use turner::image::Image;

/// An image and its encoded file.
struct Kept {
    image: Arc<Image>,
    name: String,
    bytes: Arc<[u8]>,
}

/// A store of encoded images, looked up by decoded image. Clones share the store.
#[derive(Clone, Default)]
pub struct KeptPictures(Arc<Mutex<Vec<Kept>>>);

impl std::fmt::Debug for KeptPictures {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("KeptPictures")
    }
}

/// Equal if they share the same store.
impl PartialEq for KeptPictures {
    fn eq(&self, other: &KeptPictures) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl KeptPictures {
    /// Stores the encoded bytes of an image; `name` is its path.
    pub fn keep(&self, image: &Arc<Image>, name: &str, bytes: Vec<u8>) {
        let mut list = self.0.lock().unwrap_or_else(|e| e.into_inner());
        list.push(Kept { image: Arc::clone(image), name: name.to_owned(), bytes: bytes.into() });
    }

    /// The path and the encoded bytes of an image, if stored.
    pub fn find(&self, image: &Arc<Image>) -> Option<(String, Arc<[u8]>)> {
        let list = self.0.lock().unwrap_or_else(|e| e.into_inner());
        let kept = list.iter().find(|kept| Arc::ptr_eq(&kept.image, image))?;
        Some((kept.name.clone(), Arc::clone(&kept.bytes)))
    }
}
