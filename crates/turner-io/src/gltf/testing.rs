//! Helpers for tests: small documents.

use turner::description::SceneDesc;
use turner::schema::SceneError;

use super::accessors::Elements;
use super::budget::Budget;
use super::buffers::Buffers;
use super::fault::Outcome;
use super::json::{self, Document, Index};
use crate::assets::MemoryAssets;
use crate::import::ImportOptions;

/// A GLB file with the given members of the document (`asset` is added) and the given binary chunk.
pub(super) fn glb(members: &str, bin: &[u8]) -> Vec<u8> {
    let mut json = format!("{{\"asset\":{{\"version\":\"2.0\"}},{members}}}").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bin = bin.to_vec();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let length = 12 + 8 + json.len() + 8 + bin.len();
    let mut out = [&b"glTF"[..], &2u32.to_le_bytes(), &(length as u32).to_le_bytes()].concat();
    for (kind, chunk) in [(0x4E4F_534Au32, json), (0x004E_4942, bin)] {
        out.extend_from_slice(&(chunk.len() as u32).to_le_bytes());
        out.extend_from_slice(&kind.to_le_bytes());
        out.extend_from_slice(&chunk);
    }
    out
}

/// Imports a file without external files.
pub(super) fn import(bytes: Vec<u8>) -> Result<SceneDesc, SceneError> {
    import_with(bytes, &ImportOptions::default())
}

/// Imports a file without external files, with options.
pub(super) fn import_with(bytes: Vec<u8>, options: &ImportOptions) -> Result<SceneDesc, SceneError> {
    super::import(bytes, "a.glb", &MemoryAssets::default(), options)
}

/// The bytes of little-endian floats.
pub(super) fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// A parsed document with its buffers.
pub(super) struct Opened {
    pub(super) document: Document,
    pub(super) buffers: Buffers,
}

/// Parses a document with these members and this binary chunk.
pub(super) fn open(members: &str, bin: &[u8]) -> Outcome<Opened> {
    let bytes = glb(members, bin);
    let parts = super::glb::split(&bytes)?;
    let document = json::parse(&bytes[parts.json])?;
    let assets = MemoryAssets::default();
    let mut buffers = Buffers::read(&document, bytes, parts.bin, "a.glb", &assets)?;
    buffers.open_views(&document, &Budget::of_file(buffers.size()))?;
    Ok(Opened { document, buffers })
}

impl Opened {
    /// An accessor.
    pub(super) fn elements(&self, accessor: u32) -> Outcome<Elements<'_>> {
        Elements::open(&self.document, &self.buffers, Index(accessor), "/test")
    }
}
