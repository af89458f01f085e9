//! The macros that declare what the scene format knows: `params!`, `family!`; for `choice!` see [`crate::choice`].

/// What one kind of thing is made of:
/// `params! { /// doc pub struct Name as "name" { /// doc key: Type = default, in RANGE; … } example "…" }`.
/// `key: Type, required, default VALUE;` is a key that a file must give; a program starts from VALUE. `Default` has all these values.
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
            /// Its documentation.
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
            /// Reads its keys; the caller refuses unknown ones.
            #[allow(unused_variables)]
            pub fn read(
                table: &mut $crate::schema::TableReader<'_>,
                cx: &mut dyn $crate::schema::ReadContext,
            ) -> Result<$name, $crate::schema::SceneError> {
                Ok($name { $($field: $crate::schema::params!(@read table, cx, $field, $ty, ($($range)?), ($($start)?) $(, $default)?),)* })
            }
            /// Its keys, ones with their default left out: what [`Self::read`] reads.
            #[allow(unused_variables)]
            pub fn write(&self, cx: &mut dyn $crate::schema::WriteContext) -> Result<$crate::schema::value::Table, $crate::schema::SceneError> {
                #[allow(unused_mut)]
                let mut table = $crate::schema::value::Table::default();
                $($crate::schema::params!(@write table, cx, self.$field, stringify!($field), $ty $(, $default)?);)*
                Ok(table)
            }
            /// Moves the numbers of things it refers to.
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

/// A closed set of kinds: `family! { /// doc pub enum ShapeDesc as "shape", "shapes" { Sphere(SphereDesc), … } }`.
/// A table says which by its key `type`; the first is the default.
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
        // Descriptions are few; their size does not matter.
        #[allow(clippy::large_enum_variant)]
        pub enum $name { $(#[allow(missing_docs)] $variant($ty),)* }
        impl Default for $name {
            /// The first kind, with its defaults.
            fn default() -> $name { $name::$first(<$first_ty>::default()) }
        }
        impl $name {
            /// Names and keys of all kinds.
            pub const DOC: $crate::schema::FamilyDoc = $crate::schema::FamilyDoc {
                one: $one,
                many: $many,
                doc: &[$($doc),+],
                entries: &[$(&<$ty>::DOC,)*],
            };
            /// Its name in a scene file.
            pub fn type_name(&self) -> &'static str { match self { $($name::$variant(_) => <$ty>::DOC.name,)* } }
            /// The kind of that name in a scene file, with its defaults; `None` if there is none of that name.
            pub fn of_type(name: &str) -> Option<$name> {
                $(if name == <$ty>::DOC.name { return Some($name::$variant(<$ty>::default())); })*
                None
            }
            /// Reads the kind called `name` (written in `value`); `Ok(None)` if there is none of that name.
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
            /// Its `type` and its keys, ones with their default left out.
            pub fn write(&self, cx: &mut dyn $crate::schema::WriteContext) -> Result<$crate::schema::value::Table, $crate::schema::SceneError> {
                let mut table = $crate::schema::value::Table::default();
                table.push("type", $crate::schema::value::Data::String(self.type_name().to_owned()));
                table.entries.extend(match self { $($name::$variant(v) => v.write(cx)?,)* }.entries);
                Ok(table)
            }
            /// Moves the numbers of things it refers to.
            pub fn renumber(&mut self, by: &$crate::schema::Renumber) {
                match self { $($name::$variant(v) => v.renumber(by),)* }
            }
        }
    };
}
pub(crate) use family;
