//! The metadata of a picture that say how its scene values are shown. All reading and writing of these keys is here.

use turner::color::{Tonemap, Transfer};
use turner::film::DisplayTransform;
use turner_io::image::Metadata;

use crate::recipe::{self, INTEGRATOR};

const EXPOSURE: &str = "turner:exposure";
const TONEMAP: &str = "turner:tonemap";
const TRANSFER: &str = "turner:transfer";

/// What the metadata say about display values. `None`: nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Shown {
    /// Stops.
    pub(crate) exposure: Option<f64>,
    pub(crate) tonemap: Option<Tonemap>,
    pub(crate) transfer: Option<Transfer>,
    /// The type of the integrator.
    pub(crate) integrator: Option<String>,
}

impl Shown {
    /// Reads the metadata; values that make no sense are left out.
    pub(crate) fn read(metadata: &Metadata) -> Shown {
        let text = |key: &str| metadata.get(key).map(ToString::to_string);
        let finite = |v: &f64| v.is_finite();
        Shown {
            exposure: text(EXPOSURE).and_then(|v| v.parse().ok()).filter(finite),
            tonemap: text(TONEMAP).and_then(|v| Tonemap::from_word(&v)),
            transfer: text(TRANSFER).and_then(|v| Transfer::from_word(&v)),
            integrator: text(INTEGRATOR).map(|text| recipe::integrator_type(&text).to_owned()),
        }
    }

    /// The transform, with the defaults of linear pictures of other programs: no exposure, no tone mapping, sRGB.
    pub(crate) fn transform(&self) -> DisplayTransform {
        DisplayTransform {
            exposure: self.exposure.unwrap_or(0.0),
            tonemap: self.tonemap.unwrap_or(Tonemap::None),
            transfer: self.transfer.unwrap_or(Transfer::Srgb),
            ..DisplayTransform::default()
        }
    }
}

/// The metadata of a transform, which [`Shown::read`] reads back exactly.
pub(crate) fn entries(transform: &DisplayTransform) -> [(&'static str, String); 3] {
    [
        (TRANSFER, transform.transfer.word().to_owned()),
        (TONEMAP, transform.tonemap.word().to_owned()),
        // The shortest number that is read back as the same.
        (EXPOSURE, transform.exposure.to_string()),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_come_back_exactly() {
        for exposure in [0.0, -1.25, 1.0 / 3.0, 1e-17, 12.345_678_901_234] {
            for tonemap in [Tonemap::None, Tonemap::Agx] {
                let transform = DisplayTransform { exposure, tonemap, ..DisplayTransform::default() };
                let metadata: Metadata =
                    entries(&transform).map(|(k, v)| (k.to_owned(), v.as_str().into())).into();
                assert_eq!(Shown::read(&metadata).transform(), transform);
            }
        }
        assert_eq!(Shown::read(&Metadata::new()).transform(), DisplayTransform::default());
        let odd: Metadata = [(EXPOSURE.to_owned(), "inf".into()), (TONEMAP.to_owned(), "?".into())].into();
        assert_eq!(Shown::read(&odd), Shown::default());
    }
}
