//! Grids of media: boxes that are aligned with the world axes.

use turner::math::{DAffine3, DVec3};
use turner::schema::{GridData, GridScattering};

/// A matrix entry is 0 if it is smaller than this fraction of the greatest one of its row: quarter turns are rounded.
const NONE: f64 = 1e-6;

/// What the box of a grid is if it is not exact.
pub(crate) const ROTATED_GRID: &str =
    "a medium grid that is rotated: it fills the box around it, aligned with the world axes";

/// A world axis and the axis of the grid that is nearest to it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    of_grid: usize,
    is_mirrored: bool,
}

/// Where a transform places a grid.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GridBox {
    /// The box around the transformed one, from its smallest to its largest coordinates.
    pub(crate) bounds: [DVec3; 2],
    /// Whether the transformed box is that box: the transform scales, exchanges and mirrors axes and does nothing else.
    pub(crate) is_exact: bool,
    axes: [Axis; 3],
}

impl GridBox {
    /// Where `to_world` places a grid that fills a box with the opposite corners `a` and `b`.
    pub(crate) fn new(to_world: &DAffine3, [a, b]: [DVec3; 2]) -> GridBox {
        let corner = |i: usize| {
            let of = |axis: usize| if i >> axis & 1 == 0 { a[axis] } else { b[axis] };
            to_world.transform_point3(DVec3::new(of(0), of(1), of(2)))
        };
        let first = corner(0);
        let bounds = (1..8).map(corner).fold([first; 2], |[min, max], p| [min.min(p), max.max(p)]);
        let mut is_exact = true;
        let mut axes = [0, 1, 2].map(|row| {
            let entries = to_world.matrix3.row(row);
            let sizes = entries.abs();
            let of_grid = (1..3).fold(0, |best, i| if sizes[i] > sizes[best] { i } else { best });
            let others = (0..3).filter(|i| *i != of_grid);
            is_exact &= sizes[of_grid] > 0.0
                && others.fold(0.0, |most: f64, i| most.max(sizes[i])) <= NONE * sizes[of_grid];
            Axis { of_grid, is_mirrored: entries[of_grid] < 0.0 }
        });
        if (0..3).any(|i| axes.iter().all(|axis| axis.of_grid != i)) {
            is_exact = false;
            axes = [0, 1, 2].map(|of_grid| Axis { of_grid, is_mirrored: false });
        }
        GridBox { bounds, is_exact, axes }
    }

    /// Whether the cells keep their order.
    pub(crate) fn keeps_cells(&self) -> bool {
        self.axes.iter().enumerate().all(|(i, axis)| axis.of_grid == i && !axis.is_mirrored)
    }

    /// Cells along the world axes of a grid that has `size` cells along its own.
    pub(crate) fn size(&self, size: [u32; 3]) -> [u32; 3] {
        self.axes.map(|axis| size[axis.of_grid])
    }

    /// The values of cells, x fastest, then y, then z, in the order along the world axes. `None` if memory is short or
    /// their number is not that of the cells.
    pub(crate) fn values<T: Copy>(&self, size: [u32; 3], values: &[T]) -> Option<Vec<T>> {
        let strides = [1, u64::from(size[0]), u64::from(size[0]) * u64::from(size[1])];
        let [nx, ny, nz] = self.size(size);
        if strides[2].checked_mul(u64::from(size[2])) != Some(values.len() as u64) {
            return None;
        }
        let at = |world: usize, i: u32| {
            let Axis { of_grid, is_mirrored } = self.axes[world];
            let i = if is_mirrored { size[of_grid] - 1 - i } else { i };
            strides[of_grid] * u64::from(i)
        };
        let mut out = Vec::new();
        out.try_reserve_exact(values.len()).ok()?;
        for z in 0..nz {
            for y in 0..ny {
                let row = at(1, y) + at(2, z);
                for x in 0..nx {
                    out.push(*values.get((row + at(0, x)) as usize)?);
                }
            }
        }
        Some(out)
    }

    /// The grid with its cells in the order along the world axes. `None` if memory is short.
    pub(crate) fn grid(&self, data: GridData) -> Option<GridData> {
        if self.keeps_cells() {
            return Some(data);
        }
        let own = data.size();
        let size = self.size(own);
        let emission = match data.emission() {
            Some(values) => Some(self.values(own, values)?),
            None => None,
        };
        let made = match data.extinction() {
            Some(colors) => GridData::of_extinction(size, self.values(own, colors)?, emission),
            None => GridData::new(size, self.values(own, data.density())?, emission),
        };
        let made = made.ok()?;
        let scattering = match data.scattering() {
            None => return Some(made),
            Some(GridScattering::Albedo(colors)) => GridScattering::Albedo(self.values(own, colors)?),
            Some(GridScattering::Coefficient(colors)) => {
                GridScattering::Coefficient(self.values(own, colors)?)
            }
        };
        made.with_scattering(scattering).ok()
    }
}

#[cfg(test)]
mod tests {
    use turner::math::{DMat3, radians};

    use super::*;

    const CUBE: [DVec3; 2] = [DVec3::NEG_ONE, DVec3::ONE];

    #[test]
    fn a_rotated_box_lies_in_the_box_around_it() {
        let turn = DAffine3::from_rotation_z(radians(45.0));
        let placed = GridBox::new(&turn, CUBE);
        let [min, max] = placed.bounds;
        let expected = DVec3::new(2f64.sqrt(), 2f64.sqrt(), 1.0);
        assert!((max - expected).length() < 1e-12 && (min + expected).length() < 1e-12, "{min} {max}");
        assert!(!placed.is_exact);
        let flat = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0)));
        assert!(!GridBox::new(&flat, CUBE).is_exact);
    }

    /// Each cell is where the transform moves its centre.
    #[test]
    fn cells_follow_quarter_turns_and_mirrors() {
        let size = [2u32, 3, 4];
        let values: Vec<f32> = (0..24).map(|i| i as f32).collect();
        let colors: Vec<[f32; 3]> = values.iter().map(|v| [*v, 1.0, 2.0]).collect();
        let grid = GridData::new(size, values.clone(), Some(values.clone())).unwrap();
        let grid = grid.with_extinction(colors.clone()).unwrap();
        let grid = grid.with_scattering(GridScattering::Coefficient(colors)).unwrap();
        let local = [DVec3::ZERO, DVec3::new(2.0, 3.0, 4.0)];
        let scale = DAffine3::from_scale(DVec3::new(2.0, -0.5, 3.0));
        let turns = [
            DAffine3::IDENTITY,
            DAffine3::from_rotation_x(radians(90.0)),
            DAffine3::from_rotation_z(radians(-90.0)) * scale,
            scale * DAffine3::from_rotation_y(radians(180.0)),
            DAffine3::from_rotation_x(radians(90.0)) * DAffine3::from_rotation_y(radians(270.0)) * scale,
        ];
        for turn in turns {
            let to_world = DAffine3::from_translation(DVec3::new(5.0, 6.0, 7.0)) * turn;
            let placed = GridBox::new(&to_world, local);
            assert!(placed.is_exact, "{to_world:?}");
            let moved = placed.grid(grid.clone()).unwrap();
            let [min, max] = placed.bounds;
            let new = DVec3::from(moved.size().map(f64::from));
            for (i, value) in values.iter().enumerate() {
                let cell = DVec3::new((i % 2) as f64, (i / 2 % 3) as f64, (i / 6) as f64);
                let at = (to_world.transform_point3(cell + 0.5) - min) / (max - min) * new;
                let [x, y, z] = at.to_array().map(|v| v as usize);
                let at = x + moved.size()[0] as usize * (y + moved.size()[1] as usize * z);
                assert_eq!(moved.extinction().unwrap()[at], [*value, 1.0, 2.0], "{to_world:?} {i}");
                assert_eq!(moved.scattering().unwrap().values()[at][0], *value);
                assert_eq!(moved.emission().unwrap()[at], *value);
            }
        }
    }
}
