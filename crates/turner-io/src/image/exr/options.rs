//! Choices in writing EXR files.

/// How the pixels of an EXR file are compressed. All methods are lossless, and every program reads them.
///
/// The lossy method DWAA is not written: the encoder of the exr crate gives different bytes on different processors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ExrCompression {
    /// Uncompressed: the fastest to read and write.
    None,
    /// Deflate of 16 rows at a time: the default of most programs.
    #[default]
    Zip,
    /// Wavelets of 32 rows at a time: smaller for noisy pictures in half floats.
    Piz,
}

/// How an EXR file is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExrOptions {
    /// The compression; default [`ExrCompression::Zip`].
    pub compression: ExrCompression,
    /// Whether `R G B A` are stored as 16-bit instead of 32-bit floats; default false. Finite values beyond ±65504
    /// become ±65504. Every further channel has a kind of its own.
    pub half: bool,
}
