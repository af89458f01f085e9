//! Separable filters on strips of rows.

/// How an image continues beyond its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Border {
    /// The nearest pixel of the edge.
    Clamp,
    /// The image, mirrored at its edge: c b a | a b c | c b a.
    Mirror,
}

impl Border {
    /// The index within 0..n for any index; n is at least 1.
    pub(super) fn place(self, i: isize, n: usize) -> usize {
        let n = n.max(1) as isize;
        let place = match self {
            Border::Clamp => i.clamp(0, n - 1),
            Border::Mirror => {
                let i = i.rem_euclid(2 * n);
                if i < n { i } else { 2 * n - 1 - i }
            }
        };
        place as usize
    }
}

/// Weights of the offsets −r to r, in order.
#[derive(Clone, Debug)]
pub(super) struct Kernel(pub(super) Vec<f64>);

impl Kernel {
    /// From a function of the offset.
    pub(super) fn new(radius: usize, f: impl Fn(f64) -> f64) -> Kernel {
        let r = radius as isize;
        Kernel((-r..=r).map(|i| f(i as f64)).collect())
    }

    /// Scaled so that the sum is 1.
    pub(super) fn normalised(self) -> Kernel {
        let sum: f64 = self.0.iter().sum();
        Kernel(self.0.into_iter().map(|w| w / sum).collect())
    }

    /// Positive weights scaled so that their sum is 1, negative ones to −1.
    pub(super) fn balanced(self) -> Kernel {
        let up: f64 = self.0.iter().filter(|w| **w > 0.0).sum();
        let down: f64 = self.0.iter().filter(|w| **w < 0.0).sum();
        Kernel(
            self.0
                .into_iter()
                .map(|w| if w > 0.0 { w / up } else { w / -down.min(-f64::MIN_POSITIVE) })
                .collect(),
        )
    }

    fn radius(&self) -> usize {
        self.0.len() / 2
    }
}

/// Rows of values.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    pub(super) width: usize,
    pub(super) values: Vec<f64>,
}

impl Plane {
    /// The rows `first − halo` to `last + halo` (`last` excluded) of an image with the value `at(x, y)` in
    /// column x and row y. `border` gives rows beyond the image.
    pub(super) fn new(
        (width, height): (usize, usize),
        rows: std::ops::Range<usize>,
        halo: usize,
        border: Border,
        at: impl Fn(usize, usize) -> f64,
    ) -> Plane {
        let halo = halo as isize;
        let rows = rows.start as isize - halo..rows.end as isize + halo;
        let rows = rows.map(|y| border.place(y, height));
        let values = rows.flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect();
        Plane { width, values }
    }

    /// A function of each value.
    pub(super) fn map(&self, f: impl Fn(f64) -> f64) -> Plane {
        Plane { width: self.width, values: self.values.iter().map(|v| f(*v)).collect() }
    }

    /// Filtered along x; the number of rows stays.
    pub(super) fn along_x(&self, kernel: &Kernel, border: Border) -> Plane {
        let (w, r) = (self.width, kernel.radius());
        let mut values = vec![0.0; self.values.len()];
        let mut wide = vec![0.0; w + 2 * r];
        for (row, out) in self.values.chunks_exact(w.max(1)).zip(values.chunks_exact_mut(w.max(1))) {
            for (i, v) in wide.iter_mut().enumerate() {
                *v = row[border.place(i as isize - r as isize, w)];
            }
            for (k, weight) in kernel.0.iter().enumerate() {
                out.iter_mut().zip(&wide[k..]).for_each(|(o, v)| *o += weight * v);
            }
        }
        Plane { width: w, values }
    }

    /// Filtered along y; `halo` rows fewer at the top and at the bottom. `halo` is at least the kernel's radius.
    pub(super) fn along_y(&self, kernel: &Kernel, halo: usize) -> Plane {
        let w = self.width.max(1);
        let rows = (self.values.len() / w).saturating_sub(2 * halo);
        let mut values = vec![0.0; rows * w];
        let top = halo - kernel.radius().min(halo);
        for (y, out) in values.chunks_exact_mut(w).enumerate() {
            for (weight, row) in kernel.0.iter().zip(self.values[(y + top) * w..].chunks_exact(w)) {
                out.iter_mut().zip(row).for_each(|(o, v)| *o += weight * v);
            }
        }
        Plane { width: self.width, values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders() {
        let places = |border: Border| (-4..7).map(|i| border.place(i, 3)).collect::<Vec<_>>();
        assert_eq!(places(Border::Clamp), [0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2]);
        assert_eq!(places(Border::Mirror), [2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0]);
        assert_eq!(Border::Mirror.place(-9, 1), 0);
    }

    #[test]
    fn strips_are_parts_of_the_whole() {
        let at = |x: usize, y: usize| ((x * 7 + y * 13) % 11) as f64;
        let kernel = Kernel::new(2, |i| 1.0 + i).normalised();
        let of = |rows: std::ops::Range<usize>| {
            let plane = Plane::new((6, 9), rows, 3, Border::Clamp, at);
            plane.along_x(&kernel, Border::Clamp).along_y(&kernel, 3).values
        };
        let whole = of(0..9);
        assert_eq!(whole.len(), 54);
        assert_eq!([of(0..4), of(4..9)].concat(), whole);
        // At the centre, by hand.
        let weight = |i: i32| (1.0 + f64::from(i)) / 5.0;
        let mut sum = 0.0;
        for dy in -2..=2i32 {
            for dx in -2..=2i32 {
                sum += weight(dx) * weight(dy) * at((3 + dx) as usize, (4 + dy) as usize);
            }
        }
        assert!((whole[4 * 6 + 3] - sum).abs() < 1e-12);
    }

    #[test]
    fn balanced_kernels_cancel_constants() {
        let k = Kernel::new(3, |i| i).balanced();
        assert!(k.0.iter().sum::<f64>().abs() < 1e-15 && (k.0[4..].iter().sum::<f64>() - 1.0).abs() < 1e-15);
    }
}
