//! Colours of diffuse bases under layers. What leaves a layer is no linear function of the base's reflectance, so pbrt's
//! spectra change their colour: the function is applied to a smooth spectrum of the colour, wavelength by wavelength.

use std::collections::BTreeMap;
use std::rc::Rc;

use turner::color::Spectrum;

use crate::scene_import::Through;
use crate::spectral::{Smooth, Upsampling};

/// Nodes of a table along each component.
const NODES: usize = 17;
/// Most spectra of single colours, each of which takes up to a millisecond, and most tables.
const MAX_SPECTRA: u32 = 4096;
const MAX_TABLES: usize = 64;

/// Spectra of colours, made when they are first asked for.
#[derive(Default)]
pub(super) struct LayerColors {
    upsampling: Upsampling,
    /// Those of the nodes of tables.
    nodes: Vec<(Spectrum, Smooth)>,
    spectra: u32,
    tables: BTreeMap<String, Rc<ColorTable>>,
}

/// A function of colours in a table, for images.
pub(super) struct ColorTable {
    f: Through,
    /// At each node, what the function by wavelengths is above the function by components.
    above: Vec<[f32; 3]>,
}

/// The value of a node. Dark colours have more nodes.
fn node(i: usize) -> f32 {
    let v = i as f32 / (NODES - 1) as f32;
    v * v
}

impl LayerColors {
    /// The spectrum of a colour; `None` once the limit of colours is reached.
    pub(super) fn smooth(&mut self, color: Spectrum) -> Option<Smooth> {
        self.spectra = self.spectra.saturating_add(1);
        (self.spectra <= MAX_SPECTRA).then(|| self.upsampling.of(color))
    }

    /// The function of a colour by its spectrum; of greys and after too many colours, component by component.
    pub(super) fn of(&mut self, color: Spectrum, f: Through) -> Spectrum {
        let is_grey = color.r == color.g && color.g == color.b;
        match if is_grey { None } else { self.smooth(color) } {
            Some(smooth) => smooth.through(color, |v| f.of(v)),
            None => color.map(|v| f.of(f64::from(v)) as f32),
        }
    }

    /// The same for many colours; `None` after too many other functions.
    pub(super) fn table(&mut self, f: Through) -> Option<Rc<ColorTable>> {
        let key = format!("{f:?}");
        if !self.tables.contains_key(&key) && self.tables.len() < MAX_TABLES {
            let made = Rc::new(self.new_table(f));
            self.tables.insert(key.clone(), made);
        }
        self.tables.get(&key).cloned()
    }

    fn new_table(&mut self, f: Through) -> ColorTable {
        if self.nodes.is_empty() {
            let grid = (0..NODES * NODES * NODES).map(|i| {
                let [r, g, b] = [i / (NODES * NODES), i / NODES % NODES, i % NODES].map(node);
                Spectrum::new(r, g, b)
            });
            self.nodes = grid.map(|color| (color, self.upsampling.of(color))).collect();
        }
        let above = self.nodes.iter().map(|(color, smooth)| {
            let whole = smooth.through(*color, |v| f.of(v)).to_array();
            let each = color.to_array().map(|v| f.of(f64::from(v)) as f32);
            [0, 1, 2].map(|i| whole[i] - each[i])
        });
        ColorTable { f, above: above.collect() }
    }
}

impl ColorTable {
    /// The function of a colour, interpolated.
    pub(super) fn at(&self, color: [f64; 3]) -> [f64; 3] {
        let cells = (NODES - 1) as f64;
        let place = color.map(|v| v.clamp(0.0, 1.0).sqrt() * cells);
        let first = place.map(|v| (v.floor() as usize).min(NODES - 2));
        let part = [0, 1, 2].map(|i| place[i] - first[i] as f64);
        let mut sum = color.map(|v| self.f.of(v));
        for corner in 0..8usize {
            let up = [corner >> 2 & 1, corner >> 1 & 1, corner & 1];
            let weights = [0, 1, 2].map(|i| if up[i] == 1 { part[i] } else { 1.0 - part[i] });
            let weight = weights[0] * weights[1] * weights[2];
            let at = ((first[0] + up[0]) * NODES + first[1] + up[1]) * NODES + first[2] + up[2];
            let above = self.above.get(at).copied().unwrap_or_default();
            sum.iter_mut().zip(above).for_each(|(sum, above)| *sum += weight * f64::from(above));
        }
        sum.map(|v| v.clamp(0.0, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_near_what_they_hold() {
        let mut colors = LayerColors::default();
        let f = Through::Layer { gain: 0.4037, inner: 0.5963, turns: Some(5) };
        let table = colors.table(f).unwrap();
        for i in 0..216u32 {
            let color = [i % 6, i / 6 % 6, i / 36].map(|v| (0.02 + 0.19 * f64::from(v)).min(1.0));
            let found = table.at(color);
            let expected = colors.of(color.map(|v| v as f32).into(), f).to_array();
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - f64::from(expected)).abs() < 0.012, "{color:?} {found} {expected}");
            }
        }
    }
}
