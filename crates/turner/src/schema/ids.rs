//! The numbers of things, and things with names.

use std::sync::Arc;

use super::value::Span;

/// Numbers of things in their lists; the first one by default.
macro_rules! ids {
    ($($(#[doc = $doc:literal])+ $name:ident,)*) => {
        $($(#[doc = $doc])+
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name(pub u32);
        impl $name {
            /// As an index into its list.
            pub fn index(self) -> usize { self.0 as usize }
        })*
    };
}

ids! {
    /// A material of the scene.
    MaterialId,
    /// A texture of the scene.
    TextureId,
    /// A decoded picture of the scene.
    ImageId,
    /// A mesh of the scene.
    MeshId,
    /// A group of objects that can be placed many times.
    GroupId,
    /// A participating medium of the scene.
    MediumId,
}

/// Something with a name (unless written in place) and a place in a file (unless made by a program).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Named<T> {
    /// The name, if it has one.
    pub name: Option<String>,
    /// Where it stands.
    pub span: Option<Span>,
    /// The thing.
    pub value: T,
}

/// A file the scene names, read once.
#[derive(Clone, Debug, PartialEq)]
pub struct Asset<T> {
    /// Its name as written.
    pub uri: String,
    /// What it holds.
    pub data: Arc<T>,
}
