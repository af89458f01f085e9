//! Integers and bounded lists.

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use std::fmt;
use std::marker::PhantomData;
use std::ops::{Deref, Index as IndexOp};

/// Most bytes that the elements of a list may take: 1 GiB.
const MAX_LIST_BYTES: usize = 1 << 30;

/// Reads an integer from 0 to `most`. Exporters whose only number type is floating point write `3.0`.
struct Whole {
    most: u64,
}

impl Visitor<'_> for Whole {
    type Value = u64;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "an integer from 0 to {}", self.most)
    }

    fn visit_u64<E: Error>(self, v: u64) -> Result<u64, E> {
        if v <= self.most { Ok(v) } else { Err(E::invalid_value(serde::de::Unexpected::Unsigned(v), &self)) }
    }

    fn visit_i64<E: Error>(self, v: i64) -> Result<u64, E> {
        match u64::try_from(v) {
            Ok(v) => self.visit_u64(v),
            Err(_) => Err(E::invalid_value(serde::de::Unexpected::Signed(v), &self)),
        }
    }

    fn visit_f64<E: Error>(self, v: f64) -> Result<u64, E> {
        // Up to 2^53 a double represents every integer exactly.
        if (0.0..=9_007_199_254_740_992.0).contains(&v) && v == v.floor() {
            self.visit_u64(v as u64)
        } else {
            Err(E::invalid_value(serde::de::Unexpected::Float(v), &self))
        }
    }
}

/// An index into one of the document's lists, or a small constant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Index(pub(crate) u32);

impl Index {
    /// As `usize`.
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

impl<'de> Deserialize<'de> for Index {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Index, D::Error> {
        let v = from.deserialize_any(Whole { most: u64::from(u32::MAX) })?;
        Ok(Index(v as u32))
    }
}

/// A count or a size in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Size(pub(crate) u64);

impl<'de> Deserialize<'de> for Size {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Size, D::Error> {
        from.deserialize_any(Whole { most: u64::MAX }).map(Size)
    }
}

/// A list of at most [`MAX_LIST_BYTES`] bytes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct List<T>(Vec<T>);

impl<T> Default for List<T> {
    fn default() -> Self {
        List(Vec::new())
    }
}

impl<T> Deref for List<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        &self.0
    }
}

impl<T> IndexOp<Index> for List<T> {
    type Output = T;
    /// Panics if out of range; only for indices that were checked after parsing.
    fn index(&self, index: Index) -> &T {
        &self.0[index.index()]
    }
}

impl<'a, T> IntoIterator for &'a List<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;
    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

struct Elements<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for Elements<T> {
    type Value = List<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<List<T>, A::Error> {
        let most = MAX_LIST_BYTES / size_of::<T>().max(1);
        let mut list = Vec::new();
        while let Some(element) = seq.next_element()? {
            if list.len() == most {
                return Err(A::Error::custom(format_args!("a list has more than {most} elements")));
            }
            list.push(element);
        }
        list.shrink_to_fit();
        Ok(List(list))
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for List<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<List<T>, D::Error> {
        from.deserialize_seq(Elements(PhantomData))
    }
}
