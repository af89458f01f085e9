//! Pictures as their files have them, beside what they were decoded to.

use std::sync::{Arc, Mutex};
use turner::image::Image;

/// One picture.
struct Kept {
    image: Arc<Image>,
    name: String,
    bytes: Arc<[u8]>,
}

/// The bytes of pictures' files, found by the pictures. Clones share them.
#[derive(Clone, Default)]
pub struct KeptPictures(Arc<Mutex<Vec<Kept>>>);

impl std::fmt::Debug for KeptPictures {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("KeptPictures")
    }
}

/// Two are the same if they share what they keep.
impl PartialEq for KeptPictures {
    fn eq(&self, other: &KeptPictures) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl KeptPictures {
    /// Keeps the file of a picture; `name` is its path.
    pub fn keep(&self, image: &Arc<Image>, name: &str, bytes: Vec<u8>) {
        let mut list = self.0.lock().unwrap_or_else(|e| e.into_inner());
        list.push(Kept { image: Arc::clone(image), name: name.to_owned(), bytes: bytes.into() });
    }

    /// The path and the bytes of a picture's file: decoded, they give this picture.
    pub fn find(&self, image: &Arc<Image>) -> Option<(String, Arc<[u8]>)> {
        let list = self.0.lock().unwrap_or_else(|e| e.into_inner());
        let kept = list.iter().find(|kept| Arc::ptr_eq(&kept.image, image))?;
        Some((kept.name.clone(), Arc::clone(&kept.bytes)))
    }
}
