//! One source for reading the scene format, for `turner help scene` and for docs/scene-format.md.
//!
//! Three small macros: `params!` declares what one kind of thing (a sphere, a spot light) is made of,
//! `family!` the closed set of its kinds, `choice!` a set of words. Each gives the plain data type, how it
//! is read from a table of a scene file, and its documentation.

use super::error::{ErrorCode, SceneError, escape, nearest, suggestion, unknown_name};
use super::model::Renumber;
use super::read::ReadContext;
use super::value::{Data, Span, Table, Value};
use super::write::WriteContext;

/// One key of a table in a scene file.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// The key.
    pub name: &'static str,
    /// The type of its value, in words.
    pub kind: fn() -> String,
    /// Its default as written in a scene; `None` if it must be given.
    pub default: Option<fn() -> String>,
    /// What it means, a line each.
    pub doc: &'static [&'static str],
    /// Its range.
    pub range: Option<Range>,
}

/// The documentation of one kind of thing.
#[derive(Clone, Copy, Debug)]
pub struct EntryDoc {
    /// Its name in a scene.
    pub name: &'static str,
    /// What it is, a line each.
    pub doc: &'static [&'static str],
    /// Its keys.
    pub fields: &'static [Field],
    /// A scene snippet; it loads and renders.
    pub example: &'static str,
}

/// The documentation of a closed set of kinds: shapes, lights, …
#[derive(Clone, Copy, Debug)]
pub struct FamilyDoc {
    /// One of them, e.g. `shape`.
    pub one: &'static str,
    /// Several, e.g. `shapes`.
    pub many: &'static str,
    /// What they have in common, a line each.
    pub doc: &'static [&'static str],
    /// Its members.
    pub entries: &'static [&'static EntryDoc],
}

/// An interval that numbers must lie in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Lower end.
    pub min: f64,
    /// Whether the lower end itself is refused.
    pub open_min: bool,
    /// Upper end.
    pub max: f64,
    /// Whether the upper end itself is refused.
    pub open_max: bool,
}

impl Range {
    /// Greater than 0.
    pub const POSITIVE: Range = Range { min: 0.0, open_min: true, max: f64::MAX, open_max: false };
    /// 0 or more.
    pub const NON_NEGATIVE: Range = Range::closed(0.0, f64::MAX);
    /// 0 to 1.
    pub const UNIT: Range = Range::closed(0.0, 1.0);
    /// Any finite number.
    pub const FINITE: Range = Range::closed(f64::MIN, f64::MAX);

    /// From `min` to `max`, both included.
    pub const fn closed(min: f64, max: f64) -> Range {
        Range { min, open_min: false, max, open_max: false }
    }

    /// Between `min` and `max`, both excluded.
    pub const fn open(min: f64, max: f64) -> Range {
        Range { min, open_min: true, max, open_max: true }
    }

    /// Whether `v` lies inside; NaN does not.
    pub fn contains(&self, v: f64) -> bool {
        (if self.open_min { v > self.min } else { v >= self.min })
            && (if self.open_max { v < self.max } else { v <= self.max })
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.min > f64::MIN, self.max < f64::MAX) {
            (false, false) => write!(f, "a finite number"),
            (true, false) if self.open_min => write!(f, "greater than {}", self.min),
            (true, false) => write!(f, "{} or more", self.min),
            (false, true) => write!(f, "{} or less", self.max),
            (true, true) if self.open_min || self.open_max => {
                let side = |open| if open { "excluded" } else { "included" };
                write!(f, "{} ({}) to {} ({})", self.min, side(self.open_min), self.max, side(self.open_max))
            }
            (true, true) => write!(f, "{} to {}", self.min, self.max),
        }
    }
}

/// A type that can stand after a key in a scene file.
pub trait ParamType: Sized {
    /// The type in words, e.g. `number` or `[x, y, z]`.
    fn kind() -> String;
    /// From a value.
    fn read(value: &Value, cx: &mut ReadContext<'_>) -> Result<Self, SceneError>;
    /// As it would be written in a scene; used to show defaults.
    fn show(&self) -> String;
    /// As a value that reads back as the same; `None` for what is said by leaving the key out.
    ///
    /// Errors: those of the files that its data goes to.
    fn write(&self, cx: &mut WriteContext<'_>) -> Result<Option<Data>, SceneError>;
    /// Moves the numbers of things it refers to.
    fn renumber(&mut self, _by: &Renumber) {}
    /// The first number in it outside a range, if any. Types without numbers have none.
    fn outside(&self, _range: &Range) -> Option<f64> {
        None
    }
}

/// The error for a value of another type than expected.
pub fn wrong_type(value: &Value, expected: &str) -> SceneError {
    SceneError::at(
        ErrorCode::WrongType,
        value.span,
        format!("expected {expected}, found {}", value.data.kind()),
    )
}

/// Reads the keys of one table, remembers which were asked for, and refuses the others.
pub struct TableReader<'a> {
    table: &'a Table,
    span: Span,
    what: String,
    known: Vec<&'static str>,
}

impl<'a> TableReader<'a> {
    /// A reader of a table that is `what` (for messages: "a sphere", "the camera").
    pub fn new(table: &'a Table, span: Span, what: impl Into<String>) -> TableReader<'a> {
        TableReader { table, span, what: what.into(), known: Vec::new() }
    }

    /// A reader of a value that must be a table.
    pub fn of(value: &'a Value, what: impl Into<String>) -> Result<TableReader<'a>, SceneError> {
        match &value.data {
            Data::Table(table) => Ok(TableReader::new(table, value.span, what)),
            _ => Err(wrong_type(value, "a table { key = value, … }")),
        }
    }

    /// Names the table more exactly, once its type is known.
    pub fn rename(&mut self, what: impl Into<String>) {
        self.what = what.into();
    }

    /// Where the table stands.
    pub fn span(&self) -> Span {
        self.span
    }

    /// The value of a key; the key counts as known from here on.
    pub fn take(&mut self, key: &'static str) -> Option<&'a Value> {
        self.known.push(key);
        self.table.get(key)
    }

    /// Where the key or, without it, the table stands.
    pub fn span_of(&self, key: &str) -> Span {
        self.table.get(key).map_or(self.span, |v| v.span)
    }

    /// The value of a key, typed.
    pub fn optional<T: ParamType>(
        &mut self,
        key: &'static str,
        range: Option<Range>,
        cx: &mut ReadContext<'_>,
    ) -> Result<Option<T>, SceneError> {
        let Some(value) = self.take(key) else { return Ok(None) };
        let read = T::read(value, cx)?;
        if let Some(range) = range
            && let Some(bad) = read.outside(&range)
        {
            let message = format!("`{key}` must be {range}, found {bad}");
            return Err(SceneError::at(ErrorCode::OutOfRange, value.span, message));
        }
        Ok(Some(read))
    }

    /// The value of a key that must be there.
    pub fn required<T: ParamType>(
        &mut self,
        key: &'static str,
        range: Option<Range>,
        cx: &mut ReadContext<'_>,
    ) -> Result<T, SceneError> {
        match self.optional(key, range, cx)? {
            Some(v) => Ok(v),
            None => {
                let message = format!("{} needs the key `{key}`", self.what);
                Err(SceneError::at(ErrorCode::MissingKey, self.span, message)
                    .help(format!("add `{key} = {}`", T::kind())))
            }
        }
    }

    /// Refuses keys nobody asked for.
    pub fn finish(&self) -> Result<(), SceneError> {
        for entry in &self.table.entries {
            if !self.known.contains(&entry.key.as_str()) {
                let message = format!("unknown key `{}` in {}", escape(&entry.key), self.what);
                let error = SceneError::at(ErrorCode::UnknownKey, entry.key_span, message);
                let mut valid = self.known.clone();
                valid.sort_unstable();
                valid.dedup();
                return Err(match nearest(&entry.key, &valid) {
                    Some(near) => error.help(format!("did you mean `{near}`?")),
                    None => error.help(suggestion("", &valid).unwrap_or_default()),
                });
            }
        }
        Ok(())
    }
}

/// The error for an unknown word where one of a few is expected.
pub fn unknown_choice(value: &Value, what: &str, found: &str, valid: &[&str]) -> SceneError {
    unknown_name(ErrorCode::UnknownName, value.span, what, found, valid)
}

/// A set of words. `choice! { /// doc pub enum Name { /// doc Variant = "word", … } }`; the first is the default.
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
            /// The word and what it means.
            pub const DOCS: &[(&str, &str)] = &[($first_word, concat!($($first_doc),+).trim_ascii()), $(($word, concat!($($vdoc),+).trim_ascii()),)*];
            /// The word in a scene file.
            pub fn word(self) -> &'static str { match self { $name::$first => $first_word, $($name::$variant => $word,)* } }
            /// From its word.
            pub fn from_word(word: &str) -> Option<$name> { match word { $first_word => Some($name::$first), $($word => Some($name::$variant),)* _ => None } }
        }
        impl $crate::scene::schema::ParamType for $name {
            fn kind() -> String {
                Self::WORDS.iter().map(|w| format!("\"{w}\"")).collect::<Vec<_>>().join(" | ")
            }
            fn read(value: &$crate::scene::value::Value, _: &mut $crate::scene::read::ReadContext<'_>) -> Result<$name, $crate::scene::error::SceneError> {
                match &value.data {
                    $crate::scene::value::Data::String(s) => $name::from_word(s)
                        .ok_or_else(|| $crate::scene::schema::unknown_choice(value, "choice", s, Self::WORDS)),
                    _ => Err($crate::scene::schema::wrong_type(value, &Self::kind())),
                }
            }
            fn show(&self) -> String { format!("\"{}\"", self.word()) }
            fn write(&self, _: &mut $crate::scene::write::WriteContext<'_>) -> Result<Option<$crate::scene::value::Data>, $crate::scene::error::SceneError> {
                Ok(Some($crate::scene::value::Data::String(self.word().to_owned())))
            }
        }
    };
}
pub(crate) use choice;

/// What one kind of thing is made of:
/// `params! { /// doc pub struct Name as "name" { /// doc key: Type = default, in RANGE; … } example "…" }`.
/// A field without a default must be given.
macro_rules! params {
    (
        $(#[doc = $doc:literal])+
        pub struct $name:ident as $key:literal {
            $($(#[doc = $fdoc:literal])+ $field:ident : $ty:ty $(= $default:expr)? $(, in $range:expr)?;)*
        }
        example $example:expr
    ) => {
        $(#[doc = $doc])+
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name { $($(#[doc = $fdoc])+ pub $field: $ty,)* }
        impl $name {
            /// Its documentation.
            pub const DOC: $crate::scene::schema::EntryDoc = $crate::scene::schema::EntryDoc {
                name: $key,
                doc: &[$($doc),+],
                fields: &[$($crate::scene::schema::Field {
                    name: stringify!($field),
                    kind: <$ty as $crate::scene::schema::ParamType>::kind,
                    default: $crate::scene::schema::params!(@show $ty $(, $default)?),
                    doc: &[$($fdoc),+],
                    range: $crate::scene::schema::params!(@range $($range)?),
                },)*],
                example: $example,
            };
            /// Reads its keys; the caller refuses unknown ones.
            #[allow(unused_variables)]
            pub fn read(
                table: &mut $crate::scene::schema::TableReader<'_>,
                cx: &mut $crate::scene::read::ReadContext<'_>,
            ) -> Result<$name, $crate::scene::error::SceneError> {
                Ok($name { $($field: $crate::scene::schema::params!(@read table, cx, $field, $ty, ($($range)?) $(, $default)?),)* })
            }
            /// Its keys, ones with their default left out: what [`Self::read`] reads.
            #[allow(unused_variables)]
            pub fn write(&self, cx: &mut $crate::scene::write::WriteContext<'_>) -> Result<$crate::scene::value::Table, $crate::scene::error::SceneError> {
                #[allow(unused_mut)]
                let mut table = $crate::scene::value::Table::default();
                $($crate::scene::schema::params!(@write table, cx, self.$field, stringify!($field), $ty $(, $default)?);)*
                Ok(table)
            }
            /// Moves the numbers of things it refers to.
            #[allow(unused_variables)]
            pub fn renumber(&mut self, by: &$crate::scene::model::Renumber) {
                $($crate::scene::schema::ParamType::renumber(&mut self.$field, by);)*
            }
        }
    };
    (@show $ty:ty) => { None };
    (@show $ty:ty, $default:expr) => { Some(|| { let v: $ty = $default; $crate::scene::schema::ParamType::show(&v) }) };
    (@write $table:ident, $cx:ident, $value:expr, $key:expr, $ty:ty) => {
        $cx.entry::<$ty>(&mut $table, $key, &$value, None)?
    };
    (@write $table:ident, $cx:ident, $value:expr, $key:expr, $ty:ty, $default:expr) => {
        $cx.entry::<$ty>(&mut $table, $key, &$value, Some(&$default))?
    };
    (@range) => { None };
    (@range $range:expr) => { Some($range) };
    (@read $table:ident, $cx:ident, $field:ident, $ty:ty, ($($range:expr)?)) => {
        $table.required::<$ty>(stringify!($field), $crate::scene::schema::params!(@range $($range)?), $cx)?
    };
    (@read $table:ident, $cx:ident, $field:ident, $ty:ty, ($($range:expr)?), $default:expr) => {
        match $table.optional::<$ty>(stringify!($field), $crate::scene::schema::params!(@range $($range)?), $cx)? {
            Some(v) => v,
            None => $default,
        }
    };
}
pub(crate) use params;

/// A closed set of kinds: `family! { /// doc pub enum ShapeDesc as "shape", "shapes" { Sphere(SphereDesc), … } }`.
/// A table says which by its key `type`.
macro_rules! family {
    (
        $(#[doc = $doc:literal])+
        pub enum $name:ident as $one:literal, $many:literal { $($variant:ident($ty:ty),)* }
    ) => {
        $(#[doc = $doc])+
        #[derive(Clone, Debug, PartialEq)]
        // Descriptions are few; their size does not matter.
        #[allow(clippy::large_enum_variant)]
        pub enum $name { $(#[allow(missing_docs)] $variant($ty),)* }
        impl $name {
            /// Names and keys of all kinds.
            pub const DOC: $crate::scene::schema::FamilyDoc = $crate::scene::schema::FamilyDoc {
                one: $one,
                many: $many,
                doc: &[$($doc),+],
                entries: &[$(&<$ty>::DOC,)*],
            };
            /// Its name in a scene file.
            pub fn type_name(&self) -> &'static str { match self { $($name::$variant(_) => <$ty>::DOC.name,)* } }
            /// Reads the kind called `name` (written in `value`); `Ok(None)` if there is none of that name.
            pub fn read(
                name: &str,
                table: &mut $crate::scene::schema::TableReader<'_>,
                cx: &mut $crate::scene::read::ReadContext<'_>,
            ) -> Result<Option<$name>, $crate::scene::error::SceneError> {
                $(if name == <$ty>::DOC.name {
                    table.rename(format!("the {} \"{name}\"", $one));
                    return <$ty>::read(table, cx).map(|v| Some($name::$variant(v)));
                })*
                Ok(None)
            }
            /// Its `type` and its keys, ones with their default left out.
            pub fn write(&self, cx: &mut $crate::scene::write::WriteContext<'_>) -> Result<$crate::scene::value::Table, $crate::scene::error::SceneError> {
                let mut table = $crate::scene::value::Table::default();
                table.push("type", $crate::scene::value::Data::String(self.type_name().to_owned()));
                table.entries.extend(match self { $($name::$variant(v) => v.write(cx)?,)* }.entries);
                Ok(table)
            }
            /// Moves the numbers of things it refers to.
            pub fn renumber(&mut self, by: &$crate::scene::model::Renumber) {
                match self { $($name::$variant(v) => v.renumber(by),)* }
            }
        }
    };
}
pub(crate) use family;
