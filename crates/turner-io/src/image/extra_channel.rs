//! Further channels of a picture: albedo, normals, depth and so on, next to its colour.

use super::{ImageError, ImageFormat};
use std::borrow::Cow;

/// A named channel next to `R G B A`, for EXR files. Other formats do not store it.
///
/// Names follow OpenEXR: `layer.component`, as in `albedo.R albedo.G albedo.B`, `N.X N.Y N.Z`, or a single name such as
/// `Z`. Compositors show channels with the same prefix as one layer.
///
/// ```
/// use turner_io::image::{ExtraChannel, SampleKind};
///
/// let depth = [1.5, 2.5, f32::INFINITY, 4.0];
/// let ids = vec![7u32, 7, 0, 9];
/// let channels = [
///     ExtraChannel::new("Z", SampleKind::Float, &depth[..]),
///     ExtraChannel::new("albedo.R", SampleKind::Half, vec![0.5f32; 4]),
///     ExtraChannel::new("id", SampleKind::Uint, ids),
/// ];
/// let picture = turner_io::image::OutputImage {
///     width: 2,
///     height: 2,
///     linear: Some(&[[0.1, 0.2, 0.3, 1.0]; 4]),
///     channels: &channels,
///     ..Default::default()
/// };
/// let exr = turner_io::image::exr::encode(&picture)?;
/// # let limits = turner_io::image::DecodeLimits::default();
/// # let found = turner_io::image::decode(&exr, "a.exr", &limits)?;
/// # assert_eq!(found.channels, 3);
/// # Ok::<(), turner_io::image::ImageError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ExtraChannel<'a> {
    /// The name: 1 to 255 bytes of printable ASCII, other than `R G B A` and the names of the other channels.
    pub name: Cow<'a, str>,
    /// How the file stores the samples.
    pub kind: SampleKind,
    /// One sample per pixel, row 0 at the top.
    pub values: ChannelValues<'a>,
}

/// How a sample is stored in an EXR file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SampleKind {
    /// 16-bit float: 11 significant bits. Finite values beyond ±65504, its largest value, become ±65504.
    Half,
    /// 32-bit float: every bit is kept, so it can also carry the 32-bit hashes of Cryptomatte.
    Float,
    /// 32-bit unsigned integer. Floats are rounded, and clamped to its range; NaN becomes 0.
    Uint,
}

impl SampleKind {
    /// The word for it: `half`, `float` or `uint`.
    pub fn word(self) -> &'static str {
        match self {
            SampleKind::Half => "half",
            SampleKind::Float => "float",
            SampleKind::Uint => "uint",
        }
    }
}

/// The samples of a channel.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelValues<'a> {
    /// Floats.
    Float(Cow<'a, [f32]>),
    /// Integers.
    Uint(Cow<'a, [u32]>),
}

impl ChannelValues<'_> {
    /// Number of samples.
    pub fn len(&self) -> usize {
        match self {
            ChannelValues::Float(v) => v.len(),
            ChannelValues::Uint(v) => v.len(),
        }
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl<'a> From<&'a [f32]> for ChannelValues<'a> {
    fn from(v: &'a [f32]) -> Self {
        ChannelValues::Float(Cow::Borrowed(v))
    }
}

impl From<Vec<f32>> for ChannelValues<'_> {
    fn from(v: Vec<f32>) -> Self {
        ChannelValues::Float(Cow::Owned(v))
    }
}

impl<'a> From<&'a [u32]> for ChannelValues<'a> {
    fn from(v: &'a [u32]) -> Self {
        ChannelValues::Uint(Cow::Borrowed(v))
    }
}

impl From<Vec<u32>> for ChannelValues<'_> {
    fn from(v: Vec<u32>) -> Self {
        ChannelValues::Uint(Cow::Owned(v))
    }
}

impl<'a> ExtraChannel<'a> {
    /// A channel with this name and these samples, borrowed or owned.
    pub fn new(
        name: impl Into<Cow<'a, str>>,
        kind: SampleKind,
        values: impl Into<ChannelValues<'a>>,
    ) -> ExtraChannel<'a> {
        ExtraChannel { name: name.into(), kind, values: values.into() }
    }
}

/// Checks the names of the channels and that each has `pixels` samples.
pub(super) fn check(
    channels: &[ExtraChannel<'_>],
    pixels: usize,
    format: ImageFormat,
) -> Result<(), ImageError> {
    let mut names: Vec<&str> = vec!["R", "G", "B", "A"];
    for channel in channels {
        let name = channel.name.as_ref();
        let printable = name.bytes().all(|b| (0x20..0x7f).contains(&b));
        if name.is_empty() || name.len() > 255 || !printable {
            let problem =
                format!("channel \"{name}\"; expected a name of 1 to 255 printable ASCII characters");
            return Err(ImageError::encode(format, problem));
        }
        if channel.values.len() != pixels {
            let found = channel.values.len();
            let problem = format!("channel \"{name}\" has {found} samples; expected {pixels}");
            return Err(ImageError::encode(format, problem));
        }
        names.push(name);
    }
    names.sort_unstable();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(ImageError::encode(format, format!("two channels are named \"{}\"", pair[0]))),
        None => Ok(()),
    }
}
