//! The files of measured BRDFs that a scene names.

use std::sync::Arc;

use turner::schema::MeasuredFile;

use super::CommonParts;
use super::report::{Fault, Place};
use crate::assets::printable;
use crate::measured::{decode, need};

impl CommonParts<'_> {
    /// The measured BRDF of a file that was read. `None` if it is damaged, which is reported: the surface is rendered as
    /// diffuse grey.
    ///
    /// Errors: not enough memory.
    pub(crate) fn measured_file(
        &mut self,
        name: &str,
        (path, bytes): (String, Vec<u8>),
        place: Place,
    ) -> Result<Option<MeasuredFile>, Fault> {
        if let Some(known) = self.measured.get(&path) {
            return Ok(known.clone());
        }
        let what = || format!("{}: reading it", printable(name));
        let memory = &self.options.limits.memory;
        memory.need(need(&bytes), what).map_err(|e| Fault::from_scene(place, e))?;
        let file = match decode(&bytes, name) {
            Ok(data) => Some(MeasuredFile { uri: name.to_owned(), data: Arc::new(data) }),
            Err(error) => {
                let message = format!("{}: {}; rendered as diffuse grey", error.name, error.problem);
                self.report.ignored(place, message);
                None
            }
        };
        self.measured.insert(path, file.clone());
        Ok(file)
    }
}
