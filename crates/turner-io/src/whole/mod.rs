//! What importers of whole scenes of other renderers have in common: lists in the making, remarks with their places, values of textures.

mod facets;
mod layer;
mod open;
mod orient;
pub(crate) mod report;
mod revolution;
mod stock;
pub(crate) mod surroundings;
mod values;

pub(crate) use facets::{Facets, incoming, one_facet_alone};
pub(crate) use layer::inner_reflectance;
pub(crate) use open::fill_open;
pub(crate) use orient::orient;
pub(crate) use report::{Place, unknown};
pub(crate) use revolution::{ALONG, AROUND, Surface, upright};
pub(crate) use stock::{Stock, is_sound, push};
pub(crate) use values::{Through, map_values, mix, product};
