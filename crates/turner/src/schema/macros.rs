//! The macros `params!` and `family!`, which declare the scene format. For `choice!` see [`crate::choice`].
//!
//! Every type of the scene format is declared once. The macros generate what must agree with the declaration:
//!
//! ```text
//! params! {                                      struct SphereDesc { center: DVec3, radius: f64 }
//!     /// A sphere.                              Default        the defaults
//!     pub struct SphereDesc as "sphere" {   ──►  DOC            name, docs, keys, types, defaults, ranges, example
//!         /// The centre.                        read           table of a scene file → SphereDesc, ranges checked
//!         center: DVec3 = DVec3::ZERO;           write          SphereDesc → table, without keys at their default
//!         /// The radius.                        renumber       updates the IDs it refers to
//!         radius: f64 = 1.0, in Range::POSITIVE;
//!     }
//!     example "…"
//! }
//!
//! family! {                                      enum ShapeDesc { Sphere(SphereDesc), Plane(PlaneDesc), … }
//!     /// Shapes.                                Default        the first member
//!     pub enum ShapeDesc as "shape", "shapes" {  DOC            names and docs of all members
//!         Sphere(SphereDesc),                    read, write    select the member by the key `type`
//!         Plane(PlaneDesc), …                    type_name, of_type, renumber
//!     }
//! }
//! ```
//!
//! The `///` lines become both rustdoc and the text of `turner help scene` and docs/reference/scene-format.md.

/// Declares one type with its keys: `key: Type = DEFAULT;`, with `, in RANGE` before the semicolon where values are
/// limited. `key: Type, required, default VALUE;` declares a key that a file must give; `Default` then has VALUE.
macro_rules! params {
    (
        $(#[doc = $doc:literal])+
        pub struct $name:ident as $key:literal {
            $($(#[doc = $fdoc:literal])+ $field:ident : $ty:ty $(= $default:expr)? $(, required, default $start:expr)? $(, in $range:expr)?;)*
        }
        example $example:expr
    ) => {
        $(#[doc = $doc])+
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name { $($(#[doc = $fdoc])+ pub $field: $ty,)* }
        impl Default for $name {
            fn default() -> $name {
                $name { $($field: $crate::schema::params!(@start $($default)? $($start)?),)* }
            }
        }
        impl $name {
            /// Its documentation in the scene format.
            pub const DOC: $crate::schema::EntryDoc = $crate::schema::EntryDoc {
                name: $key,
                doc: &[$($doc),+],
                fields: &[$($crate::schema::Field {
                    name: stringify!($field),
                    kind: <$ty as $crate::schema::ParamType>::kind,
                    words: <$ty as $crate::schema::ParamType>::words,
                    default: $crate::schema::params!(@show $ty $(, $default)?),
                    doc: &[$($fdoc),+],
                    range: $crate::schema::params!(@range $($range)?),
                },)*],
                example: $example,
            };
            /// Reads its keys. The caller rejects unknown keys with `TableReader::finish`.
            #[allow(unused_variables)]
            pub fn read(
                table: &mut $crate::schema::TableReader<'_>,
                cx: &mut dyn $crate::schema::ReadContext,
            ) -> Result<$name, $crate::schema::SceneError> {
                Ok($name { $($field: $crate::schema::params!(@read table, cx, $field, $ty, ($($range)?), ($($start)?) $(, $default)?),)* })
            }
            /// Its keys as [`Self::read`] reads them, without those at their default.
            #[allow(unused_variables)]
            pub fn write(&self, cx: &mut dyn $crate::schema::WriteContext) -> Result<$crate::schema::value::Table, $crate::schema::SceneError> {
                #[allow(unused_mut)]
                let mut table = $crate::schema::value::Table::default();
                $($crate::schema::params!(@write table, cx, self.$field, stringify!($field), $ty $(, $default)?);)*
                Ok(table)
            }
            /// Updates the IDs that it refers to.
            #[allow(unused_variables)]
            pub fn renumber(&mut self, by: &$crate::schema::Renumber) {
                $($crate::schema::ParamType::renumber(&mut self.$field, by);)*
            }
        }
    };
    (@start $value:expr) => { $value };
    (@show $ty:ty) => { None };
    (@show $ty:ty, $default:expr) => { Some(|| { let v: $ty = $default; $crate::schema::ParamType::show(&v) }) };
    (@write $table:ident, $cx:ident, $value:expr, $key:expr, $ty:ty) => {
        $crate::schema::write::entry::<$ty>($cx, &mut $table, $key, &$value, None)?
    };
    (@write $table:ident, $cx:ident, $value:expr, $key:expr, $ty:ty, $default:expr) => {
        $crate::schema::write::entry::<$ty>($cx, &mut $table, $key, &$value, Some(&$default))?
    };
    (@range) => { None };
    (@range $range:expr) => { Some($range) };
    (@read $table:ident, $cx:ident, $field:ident, $ty:ty, ($($range:expr)?), ($start:expr)) => {
        $table.required::<$ty>(stringify!($field), $crate::schema::params!(@range $($range)?), $cx, || $start)?
    };
    (@read $table:ident, $cx:ident, $field:ident, $ty:ty, ($($range:expr)?), (), $default:expr) => {
        match $table.optional::<$ty>(stringify!($field), $crate::schema::params!(@range $($range)?), $cx)? {
            Some(v) => v,
            None => $default,
        }
    };
}
pub(crate) use params;

/// Declares a family: an enum with one variant per type. The key `type` of a table selects the variant; the first
/// variant is the default.
macro_rules! family {
    (
        $(#[doc = $doc:literal])+
        pub enum $name:ident as $one:literal, $many:literal { $first:ident($first_ty:ty), $($variant:ident($ty:ty),)* }
    ) => {
        $crate::schema::family! { @all $(#[doc = $doc])+ $name, $one, $many, $first($first_ty), $first($first_ty), $($variant($ty),)* }
    };
    (
        @all $(#[doc = $doc:literal])+ $name:ident, $one:literal, $many:literal, $first:ident($first_ty:ty), $($variant:ident($ty:ty),)*
    ) => {
        $(#[doc = $doc])+
        #[derive(Clone, Debug, PartialEq)]
        // A scene has few descriptions, so their size does not matter.
        #[allow(clippy::large_enum_variant)]
        pub enum $name { $(#[allow(missing_docs)] $variant($ty),)* }
        impl Default for $name {
            /// The first type, with its defaults.
            fn default() -> $name { $name::$first(<$first_ty>::default()) }
        }
        impl $name {
            /// The documentation of all types.
            pub const DOC: $crate::schema::FamilyDoc = $crate::schema::FamilyDoc {
                one: $one,
                many: $many,
                doc: &[$($doc),+],
                entries: &[$(&<$ty>::DOC,)*],
            };
            /// The value of `type` that selects it in a scene file.
            pub fn type_name(&self) -> &'static str { match self { $($name::$variant(_) => <$ty>::DOC.name,)* } }
            /// The type called `name` in a scene file, with its defaults; `None` if there is no such type.
            pub fn of_type(name: &str) -> Option<$name> {
                $(if name == <$ty>::DOC.name { return Some($name::$variant(<$ty>::default())); })*
                None
            }
            /// Reads a table as the type called `name`; `Ok(None)` if there is no such type.
            pub fn read(
                name: &str,
                table: &mut $crate::schema::TableReader<'_>,
                cx: &mut dyn $crate::schema::ReadContext,
            ) -> Result<Option<$name>, $crate::schema::SceneError> {
                $(if name == <$ty>::DOC.name {
                    table.rename(format!("the {} \"{name}\"", $one));
                    return <$ty>::read(table, cx).map(|v| Some($name::$variant(v)));
                })*
                Ok(None)
            }
            /// Its `type` and its keys, without those at their default.
            pub fn write(&self, cx: &mut dyn $crate::schema::WriteContext) -> Result<$crate::schema::value::Table, $crate::schema::SceneError> {
                let mut table = $crate::schema::value::Table::default();
                table.push("type", $crate::schema::value::Data::String(self.type_name().to_owned()));
                table.entries.extend(match self { $($name::$variant(v) => v.write(cx)?,)* }.entries);
                Ok(table)
            }
            /// Updates the IDs that it refers to.
            pub fn renumber(&mut self, by: &$crate::schema::Renumber) {
                match self { $($name::$variant(v) => v.renumber(by),)* }
            }
        }
    };
}
pub(crate) use family;
