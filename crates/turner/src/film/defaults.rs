//! Film defaults that depend on the integrator.
//!
//! A path tracer with one sample per pixel and no transfer curve gives a noisy, dark picture. So a scene file that says nothing about sampling and transfer gets values that
//! suit its integrator. The type of the integrator decides while a file is read: only there is it known which keys were given. [`FilmDesc::default`] does not depend on it.

use super::{Antialias, FilmDesc};
use crate::color::Transfer;
use crate::schema::value::{Data, Entry, Span, Table, Value};
use crate::schema::{ParamType, ReadContext, SceneError, TableReader, WriteContext};

/// The keys whose default depends on the integrator.
const KEYS: [&str; 3] = ["antialias", "samples", "transfer"];

impl FilmDesc {
    /// The film of a scene file that gives no key of `[film]`; `integrator` is the type of its integrator, e.g. `path`.
    ///
    /// With `path` and `direct` the picture has stochastic samples, 64 or 16 per pixel, and the sRGB curve. The debug view `bounces`
    /// has 16 stochastic samples. Other integrators have [`FilmDesc::default`].
    pub fn default_for(integrator: &str) -> FilmDesc {
        let stochastic =
            FilmDesc { antialias: Antialias::MonteCarlo, transfer: Transfer::Srgb, ..FilmDesc::default() };
        match integrator {
            "path" => FilmDesc { samples: 64, ..stochastic },
            "direct" => FilmDesc { samples: 16, ..stochastic },
            // A mean over random paths, but no colour.
            "bounces" => FilmDesc { antialias: Antialias::MonteCarlo, samples: 16, ..FilmDesc::default() },
            _ => FilmDesc::default(),
        }
    }

    /// Reads `[film]`. Keys that the table lacks get the defaults of the integrator of that type.
    pub(crate) fn read_for(
        integrator: &str,
        value: &Value,
        cx: &mut dyn ReadContext,
    ) -> Result<FilmDesc, SceneError> {
        let mut table = TableReader::of(value, "[film]")?;
        let mut film = FilmDesc::read(&mut table, cx)?;
        table.finish(cx)?;
        let given = |key: &str| matches!(&value.data, Data::Table(table) if table.get(key).is_some());
        let FilmDesc { antialias, samples, transfer, .. } = FilmDesc::default_for(integrator);
        if !given("antialias") {
            film.antialias = antialias;
        }
        if !given("samples") {
            film.samples = samples;
        }
        if !given("transfer") {
            film.transfer = transfer;
        }
        Ok(film)
    }

    /// What [`FilmDesc::read_for`] reads back as this film. Without an integrator the keys that depend on it are all written.
    pub(crate) fn write_for(
        &self,
        integrator: Option<&str>,
        cx: &mut dyn WriteContext,
    ) -> Result<Table, SceneError> {
        let default = integrator.map(FilmDesc::default_for);
        let mut plain = self.write(cx)?;
        let mut out = Table::default();
        for field in FilmDesc::DOC.fields {
            let key = field.name;
            if !KEYS.contains(&key) {
                let own = plain.entries.iter().position(|e| e.key == key);
                out.entries.extend(own.map(|i| plain.entries.remove(i)));
                continue;
            }
            let (value, is_default) = match key {
                "antialias" => {
                    (self.antialias.write(cx)?, default.as_ref().map(|d| d.antialias == self.antialias))
                }
                "samples" => (self.samples.write(cx)?, default.as_ref().map(|d| d.samples == self.samples)),
                _ => (self.transfer.write(cx)?, default.as_ref().map(|d| d.transfer == self.transfer)),
            };
            if let (Some(data), false) = (value, is_default == Some(true)) {
                let value = Value::new(data);
                out.entries.push(Entry { key: key.to_owned(), key_span: Span::NONE, value });
            }
        }
        Ok(out)
    }
}
