//! Buffers and buffer views: the binary chunk, `data:` URIs, external files, and decompressed buffer views.

use std::ops::Range;

use turner::schema::SceneError;

use super::budget::Budget;
use super::fault::{Fault, Outcome};
use super::json::{Buffer, Document, Index};
use super::report::Report;
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
    /// A buffer without bytes: a placeholder that nothing reads (§3.6.1.1), one whose buffer views are stored compressed
    /// in another buffer (`EXT_meshopt_compression`), or one at a network address.
    Absent { size: u64, why: Option<Box<Fault>> },
}

/// The bytes of a buffer view.
#[derive(Debug)]
enum View {
    Stored {
        buffer: usize,
        range: Range<usize>,
    },
    Decoded(Vec<u8>),
    /// A view of a buffer without bytes.
    Absent {
        buffer: usize,
    },
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

    /// A range of the file that holds the document.
    pub(super) fn file(&self, range: Range<usize>) -> &[u8] {
        self.file.get(range).unwrap_or_default()
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
                        Bytes::Absent { .. } => View::Absent { buffer: buffer.index() },
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
            Bytes::Absent { size, .. } => *size,
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
            Bytes::Absent { .. } => None,
        }
    }

    /// Whether a buffer view lies in a placeholder, which has no bytes although the file is valid.
    pub(super) fn is_placeholder(&self, view: Index) -> bool {
        let Some(View::Absent { buffer }) = self.views.get(view.index()) else { return false };
        matches!(self.buffers.get(*buffer), Some(Bytes::Absent { why: None, .. }))
    }

    /// Whether a buffer view lies in a buffer without bytes, so that it can be checked but not read.
    pub(super) fn is_absent(&self, view: Index) -> bool {
        matches!(self.views.get(view.index()), Some(View::Absent { .. }))
    }

    /// Warns of buffers at network addresses. What needs one is refused.
    pub(super) fn report(&self, report: &mut Report) {
        if self.file.starts_with(b"glTF")
            && matches!(self.buffers.first(), Some(Bytes::Absent { why: None, .. }))
        {
            report.doubtful("/buffers/0: has no uri, and the file has no binary chunk for it");
        }
        for buffer in &self.buffers {
            if let Bytes::Absent { why: Some(fault), .. } = buffer {
                report.doubtful(format!("{}; nothing is read from it", fault.text()));
            }
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
            View::Absent { buffer } => match self.buffers.get(*buffer) {
                Some(Bytes::Absent { why: Some(fault), .. }) => return Err((**fault).clone()),
                _ => None,
            },
        };
        match bytes {
            Some(bytes) => Ok((bytes, self.strides.get(view.index()).copied().flatten())),
            None => {
                let message = format!(
                    "buffer view {} lies in a buffer that has neither a uri nor a binary chunk",
                    view.0
                );
                Err(Fault::at(pointer, message))
            }
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
        (Some(at), _) => match read_uri(at, uri, assets, MAX_FILE, pointer) {
            Ok((bytes, _)) => Bytes::Owned(bytes),
            // Nothing may be read from it.
            Err(fault) if is_network_address(at) => {
                return Ok(Bytes::Absent { size: wanted.0, why: Some(Box::new(fault)) });
            }
            Err(fault) => return Err(fault),
        },
        (None, Some(chunk)) => Bytes::Chunk(chunk),
        (None, None) => {
            let fallback = buffer.extensions.as_deref().and_then(|e| e.meshopt.as_ref());
            let size = if fallback.is_some_and(|f| f.fallback) { u64::MAX } else { wanted.0 };
            return Ok(Bytes::Absent { size, why: None });
        }
    };
    let size = match &bytes {
        Bytes::Chunk(range) => range.len() as u64,
        Bytes::Owned(bytes) => bytes.len() as u64,
        Bytes::Absent { size, .. } => *size,
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
        let (mime, bytes) = match kind.strip_suffix(";base64") {
            Some(mime) => (mime, base64::decode(data)),
            None => (&kind[..], percent_decode(data)),
        };
        let bytes = bytes.ok_or_else(|| {
            Fault::at(pointer, "has a data: URI that is neither valid base64 nor percent-encoded")
        })?;
        let mime = mime.split(';').next().filter(|m| !m.is_empty()).map(str::to_owned);
        return Ok((bytes, mime));
    }
    let read = assets.resolve(from, uri).and_then(|path| assets.read(&path, limit));
    Ok((read.map_err(|e| asset_fault(&e, pointer))?, None))
}

fn is_network_address(uri: &str) -> bool {
    let scheme = uri.split_once("://").map_or("", |(scheme, _)| scheme);
    scheme.eq_ignore_ascii_case("http") || scheme.eq_ignore_ascii_case("https")
}

/// What follows `data:`; `None` for other URIs.
pub(super) fn strip_scheme(uri: &str) -> Option<&str> {
    let (scheme, rest) = uri.split_at_checked(5)?;
    scheme.eq_ignore_ascii_case("data:").then_some(rest)
}

/// The bytes of percent-encoded text (RFC 2397); `None` if a `%` is not followed by two hexadecimal digits.
fn percent_decode(text: &str) -> Option<Vec<u8>> {
    let mut bytes = text.bytes();
    let mut out = Vec::new();
    while let Some(byte) = bytes.next() {
        let mut digit = || char::from(bytes.next()?).to_digit(16);
        out.push(if byte == b'%' { (digit()? * 16 + digit()?) as u8 } else { byte });
    }
    Some(out)
}

fn asset_fault(error: &AssetError, pointer: &str) -> Fault {
    let SceneError { code, message, help, remedy, .. } = error.to_scene_error();
    let fault = Fault::at(pointer, message).code(code).remedy(remedy.map(|r| *r));
    match help {
        Some(help) => fault.help(help),
        None => fault,
    }
}
