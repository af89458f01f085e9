//! Buffers and buffer views: the binary chunk, `data:` URIs, external files, and decompressed buffer views.

use std::ops::Range;

use turner::schema::SceneError;

use super::budget::Budget;
use super::fault::{Fault, Outcome};
use super::json::{Buffer, Document, Index};
use super::{base64, meshopt};
use crate::assets::{AssetError, AssetSource};

/// Largest external file, in bytes: 4 GiB.
const MAX_FILE: u64 = 4 << 30;

/// The bytes of a buffer.
#[derive(Debug)]
enum Bytes {
    /// A range of the GLB file.
    Chunk(Range<usize>),
    /// Read or decoded.
    Owned(Vec<u8>),
    /// A fallback buffer without bytes: its buffer views are stored compressed in another buffer
    /// (`EXT_meshopt_compression`).
    Fallback,
}

/// The bytes of a buffer view.
#[derive(Debug)]
enum View {
    Stored {
        buffer: usize,
        range: Range<usize>,
    },
    Decoded(Vec<u8>),
    /// A view of a fallback buffer.
    Absent,
}

/// All buffers and buffer views of a document.
#[derive(Debug)]
pub(super) struct Buffers {
    file: Vec<u8>,
    buffers: Vec<Bytes>,
    views: Vec<View>,
    strides: Vec<Option<usize>>,
}

impl Buffers {
    /// Reads all buffers of the document. `file` is the file that holds the document, `chunk` the range of its
    /// binary chunk.
    pub(super) fn read(
        document: &Document,
        file: Vec<u8>,
        chunk: Option<Range<usize>>,
        uri: &str,
        assets: &dyn AssetSource,
    ) -> Outcome<Buffers> {
        let mut buffers = Vec::new();
        for (i, buffer) in document.buffers.iter().enumerate() {
            let chunk = chunk.clone().filter(|_| i == 0);
            buffers.push(read_buffer(buffer, &format!("/buffers/{i}"), chunk, uri, assets)?);
        }
        Ok(Buffers { file, buffers, views: Vec::new(), strides: Vec::new() })
    }

    /// Total bytes of the document and its buffers.
    pub(super) fn size(&self) -> u64 {
        let own = |b: &Bytes| match b {
            Bytes::Owned(bytes) => bytes.len() as u64,
            _ => 0,
        };
        self.file.len() as u64 + self.buffers.iter().map(own).sum::<u64>()
    }

    /// Checks all buffer views and decodes the compressed ones.
    pub(super) fn open_views(&mut self, document: &Document, budget: &Budget) -> Outcome<()> {
        for (i, view) in document.buffer_views.iter().enumerate() {
            let pointer = format!("/bufferViews/{i}");
            let compressed = view.extensions.as_deref().and_then(|e| e.meshopt.as_ref());
            let opened = match compressed {
                Some(how) => {
                    let pointer = format!("{pointer}/extensions/EXT_meshopt_compression");
                    let range = self.range(how.buffer, how.byte_offset.0, how.byte_length.0, &pointer)?;
                    let source = self.bytes(how.buffer.index(), &range);
                    let Some(source) = source else {
                        return Err(Fault::at(pointer, "lies in a buffer without bytes"));
                    };
                    View::Decoded(meshopt::decode(how, source, budget, &pointer)?)
                }
                None => {
                    let (Some(buffer), Some(length)) = (view.buffer, view.byte_length) else {
                        return Err(Fault::at(pointer, "has no buffer or no byteLength; expected both"));
                    };
                    let range = self.range(buffer, view.byte_offset.0, length.0, &pointer)?;
                    match self.buffers[buffer.index()] {
                        Bytes::Fallback => View::Absent,
                        _ => View::Stored { buffer: buffer.index(), range },
                    }
                }
            };
            let stride = match (compressed, view.byte_stride) {
                (Some(how), _) => Some(how.byte_stride.0),
                (None, stride) => stride.map(|s| s.0).filter(|s| *s != 0),
            };
            self.views.push(opened);
            self.strides.push(stride.map(|s| usize::try_from(s).unwrap_or(usize::MAX)));
        }
        Ok(())
    }

    /// Checks a byte range of a buffer.
    fn range(&self, buffer: Index, offset: u64, length: u64, pointer: &str) -> Outcome<Range<usize>> {
        let Some(bytes) = self.buffers.get(buffer.index()) else {
            return Err(Fault::dangling(pointer, "buffer", buffer.0, self.buffers.len()));
        };
        let size = match bytes {
            Bytes::Chunk(range) => range.len() as u64,
            Bytes::Owned(bytes) => bytes.len() as u64,
            Bytes::Fallback => u64::MAX,
        };
        match offset.checked_add(length) {
            Some(end) if end <= size && end <= usize::MAX as u64 => Ok(offset as usize..end as usize),
            _ => Err(Fault::at(
                pointer,
                format!("{length} bytes from byte {offset}, but buffer {} ends at {size}", buffer.0),
            )),
        }
    }

    fn bytes(&self, buffer: usize, range: &Range<usize>) -> Option<&[u8]> {
        match self.buffers.get(buffer)? {
            Bytes::Chunk(chunk) => self.file.get(chunk.clone())?.get(range.clone()),
            Bytes::Owned(bytes) => bytes.get(range.clone()),
            Bytes::Fallback => None,
        }
    }

    /// The bytes of a buffer view and its stride, if it has one.
    pub(super) fn view(&self, view: Index, pointer: &str) -> Outcome<(&[u8], Option<usize>)> {
        let Some(found) = self.views.get(view.index()) else {
            return Err(Fault::dangling(pointer, "buffer view", view.0, self.views.len()));
        };
        let bytes = match found {
            View::Stored { buffer, range } => self.bytes(*buffer, range),
            View::Decoded(bytes) => Some(&bytes[..]),
            View::Absent => None,
        };
        match bytes {
            Some(bytes) => Ok((bytes, self.strides.get(view.index()).copied().flatten())),
            None => Err(Fault::at(pointer, format!("buffer view {} lies in a buffer without bytes", view.0))),
        }
    }
}

fn read_buffer(
    buffer: &Buffer,
    pointer: &str,
    chunk: Option<Range<usize>>,
    uri: &str,
    assets: &dyn AssetSource,
) -> Outcome<Bytes> {
    let Some(wanted) = buffer.byte_length else {
        return Err(Fault::at(pointer, "has no byteLength; expected one"));
    };
    let bytes = match (&buffer.uri, chunk) {
        (Some(at), _) => Bytes::Owned(read_uri(at, uri, assets, MAX_FILE, pointer)?.0),
        (None, Some(chunk)) => Bytes::Chunk(chunk),
        (None, None) => {
            // Only a fallback buffer of compressed data may have no bytes.
            let fallback = buffer.extensions.as_deref().and_then(|e| e.meshopt.as_ref());
            if fallback.is_some_and(|f| f.fallback) {
                return Ok(Bytes::Fallback);
            }
            return Err(Fault::at(pointer, "has no uri, and the file has no binary chunk for it"));
        }
    };
    let size = match &bytes {
        Bytes::Chunk(range) => range.len() as u64,
        Bytes::Owned(bytes) => bytes.len() as u64,
        Bytes::Fallback => 0,
    };
    if wanted.0 > size {
        return Err(Fault::at(pointer, format!("says {} bytes, but there are {size}", wanted.0)));
    }
    Ok(bytes)
}

/// The bytes of a URI in the document, and the media type if the URI states one. `from` is the document's name; files
/// are read through `assets`, so only from its folder.
pub(super) fn read_uri(
    uri: &str,
    from: &str,
    assets: &dyn AssetSource,
    limit: u64,
    pointer: &str,
) -> Outcome<(Vec<u8>, Option<String>)> {
    if let Some(rest) = strip_scheme(uri) {
        let Some((kind, data)) = rest.split_once(',') else {
            return Err(Fault::at(pointer, "has a data: URI without a comma"));
        };
        let kind = kind.to_ascii_lowercase();
        let Some(mime) = kind.strip_suffix(";base64") else {
            return Err(Fault::at(pointer, "has a data: URI that is not base64"));
        };
        let bytes = base64::decode(data);
        let bytes = bytes.ok_or_else(|| Fault::at(pointer, "has a data: URI that is not valid base64"))?;
        let mime = mime.split(';').next().filter(|m| !m.is_empty()).map(str::to_owned);
        return Ok((bytes, mime));
    }
    let read = assets.resolve(from, uri).and_then(|path| assets.read(&path, limit));
    Ok((read.map_err(|e| asset_fault(&e, pointer))?, None))
}

fn strip_scheme(uri: &str) -> Option<&str> {
    let (scheme, rest) = uri.split_at_checked(5)?;
    scheme.eq_ignore_ascii_case("data:").then_some(rest)
}

fn asset_fault(error: &AssetError, pointer: &str) -> Fault {
    let SceneError { code, message, help, remedy, .. } = error.to_scene_error();
    let fault = Fault::at(pointer, message).code(code).remedy(remedy.map(|r| *r));
    match help {
        Some(help) => fault.help(help),
        None => fault,
    }
}
