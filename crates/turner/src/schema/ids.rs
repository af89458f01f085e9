//! IDs of the parts of a scene, and values with names.

use std::sync::Arc;

use super::value::Span;

/// Declares IDs: indices into the lists of a description. The default is 0.
macro_rules! ids {
    ($($(#[doc = $doc:literal])+ $name:ident,)*) => {
        $($(#[doc = $doc])+
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name(pub u32);
        impl $name {
            /// The index into its list.
            pub fn index(self) -> usize { self.0 as usize }
        })*
    };
}

ids! {
    /// A material of the scene.
    MaterialId,
    /// A texture of the scene.
    TextureId,
    /// A decoded image of the scene.
    ImageId,
    /// A mesh of the scene.
    MeshId,
    /// A named set of objects that instances place.
    GroupId,
    /// A participating medium of the scene.
    MediumId,
}

/// A value with a name (unless written in place) and a position in a file (unless made by a program).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Named<T> {
    /// The name, if it has one.
    pub name: Option<String>,
    /// The position in a file, if it has one.
    pub span: Option<Span>,
    /// The value.
    pub value: T,
}

/// A file that the scene refers to, read once.
#[derive(Clone, Debug, PartialEq)]
pub struct Asset<T> {
    /// The file name as written in the scene.
    pub uri: String,
    /// Its data.
    pub data: Arc<T>,
}
