//! Enumerations of words, the values of scene keys with a few possibilities; each word has a documentation text.

/// An enumeration of words. `choice!` implements it.
pub trait Choice: Copy + Sized + 'static {
    /// The words, in order.
    const ALL_WORDS: &'static [&'static str];
    /// Each word with its meaning.
    const ALL_DOCS: &'static [(&'static str, &'static str)];
    /// The word in a scene file.
    fn to_word(self) -> &'static str;
    /// The value of a word.
    fn of_word(word: &str) -> Option<Self>;
}

/// Declares an enumeration of words: `choice! { /// doc pub enum Name { /// doc Variant = "word", … } }`. The
/// first one is the default.
macro_rules! choice {
    (
        $(#[doc = $doc:literal])+
        pub enum $name:ident { $(#[doc = $first_doc:literal])+ $first:ident = $first_word:literal, $($(#[doc = $vdoc:literal])+ $variant:ident = $word:literal,)* }
    ) => {
        $(#[doc = $doc])+
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        pub enum $name { $(#[doc = $first_doc])+ #[default] $first, $($(#[doc = $vdoc])+ $variant,)* }
        impl $name {
            /// The words, in order.
            pub const WORDS: &[&str] = &[$first_word, $($word,)*];
            /// Each word with its meaning.
            pub const DOCS: &[(&str, &str)] = &[($first_word, concat!($($first_doc),+).trim_ascii()), $(($word, concat!($($vdoc),+).trim_ascii()),)*];
            /// The word in a scene file.
            pub fn word(self) -> &'static str { match self { $name::$first => $first_word, $($name::$variant => $word,)* } }
            /// The value of a word.
            pub fn from_word(word: &str) -> Option<$name> { match word { $first_word => Some($name::$first), $($word => Some($name::$variant),)* _ => None } }
        }
        impl $crate::choice::Choice for $name {
            const ALL_WORDS: &'static [&'static str] = $name::WORDS;
            const ALL_DOCS: &'static [(&'static str, &'static str)] = $name::DOCS;
            fn to_word(self) -> &'static str { self.word() }
            fn of_word(word: &str) -> Option<$name> { $name::from_word(word) }
        }
    };
}
pub(crate) use choice;
