//! Grids of numbers and colours (.vol files).

use turner::math::DVec3;
use turner::schema::{ErrorCode, GridData, GridScattering, Memory, SceneError};

use crate::scene_import::GridBox;

/// Values at the centres of cells that fill a box.
pub(super) struct Cells {
    size: [u32; 3],
    values: Values,
    /// The box in space, from its smallest to its largest coordinates.
    pub(super) bounds: [DVec3; 2],
}

/// Bytes of a colour.
const COLOR: u64 = 12;

/// The list of `count` values. `None` if memory is short.
fn listed<T>(count: usize, values: impl Iterator<Item = T>) -> Option<Vec<T>> {
    let mut out = Vec::new();
    out.try_reserve_exact(count).ok()?;
    out.extend(values.take(count));
    Some(out)
}

/// Densities and albedos are not negative, and finite.
fn density(v: f32) -> f32 {
    if v.is_finite() { v.clamp(0.0, 1e30) } else { 0.0 }
}

/// The values of all cells, x fastest, then y, then z.
enum Values {
    Numbers(Vec<f32>),
    Colors(Vec<[f32; 3]>),
}

impl Cells {
    /// One cell of value 1.
    pub(super) fn even(bounds: [DVec3; 2]) -> Cells {
        Cells { size: [1; 3], values: Values::Numbers(vec![1.0]), bounds }
    }

    /// Decodes a file: "VOL", version 3, type 1 (f32), sizes along x, y, z, channels, the bounding box, then the
    /// values, x fastest. Three channels are a colour; of other channels the mean is kept. Returns their number as
    /// well, and the box of the file.
    pub(super) fn read(bytes: &[u8]) -> Result<(Cells, usize), String> {
        Cells::read_as(bytes, density)
    }

    /// Decodes a file of one channel as signed distances at the vertices of a grid.
    pub(super) fn distances(bytes: &[u8]) -> Result<GridData, String> {
        let (cells, channels) = Cells::read_as(bytes, |v| v)?;
        let [x, y, z] = cells.size;
        match cells.values {
            Values::Numbers(_) if cells.size.iter().any(|n| *n < 2) => {
                Err(format!("has {x} × {y} × {z} values: expected 2 or more along each axis"))
            }
            Values::Numbers(values) if channels == 1 => GridData::of_distances(cells.size, values),
            _ => Err(format!("has {channels} channels: expected 1")),
        }
    }

    fn read_as(bytes: &[u8], kept: fn(f32) -> f32) -> Result<(Cells, usize), String> {
        let cut = || "the file is truncated".to_owned();
        if !bytes.starts_with(b"VOL\x03") {
            return Err("is not a volume file of version 3".into());
        }
        let word = |i: usize| -> Option<[u8; 4]> { bytes.get(4 * i..4 * i + 4)?.try_into().ok() };
        let integer = |i: usize| word(i).map(i32::from_le_bytes).ok_or_else(cut);
        if integer(1)? != 1 {
            return Err("its values are not 32-bit floats".into());
        }
        let mut size = [0u32; 3];
        for (i, s) in size.iter_mut().enumerate() {
            *s = u32::try_from(integer(2 + i)?).map_err(|_| "a size is negative".to_owned())?;
        }
        let channels = usize::try_from(integer(5)?).ok().filter(|c| (1..=16).contains(c));
        let channels = channels.ok_or_else(|| "expected 1 to 16 channels".to_owned())?;
        let float = |i: usize| word(i).map(|b| f64::from(f32::from_le_bytes(b))).ok_or_else(cut);
        let corner = |i: usize| Ok::<_, String>(DVec3::new(float(i)?, float(i + 1)?, float(i + 2)?));
        let bounds = [corner(6)?, corner(9)?];
        let count = size.iter().try_fold(channels, |n, s| n.checked_mul(*s as usize));
        let data = bytes.get(48..).unwrap_or_default();
        let [x, y, z] = size;
        if count.and_then(|n| n.checked_mul(4)).is_none_or(|n| n > data.len()) {
            return Err(format!("{x} × {y} × {z} cells of {channels} channels are more than the file holds"));
        }
        let count = count.filter(|n| *n > 0).ok_or_else(|| format!("has {x} × {y} × {z} cells"))?;
        let (values, _) = data.as_chunks::<4>();
        let value = |b: &[u8; 4]| kept(f32::from_le_bytes(*b));
        let cells = values.get(..count).unwrap_or_default();
        let short = || format!("not enough memory for {x} × {y} × {z} cells");
        let values = if channels == 3 {
            let colors = cells.as_chunks::<3>().0.iter().map(|cell| cell.each_ref().map(value));
            Values::Colors(listed(count / 3, colors).ok_or_else(short)?)
        } else {
            let mean = |cell: &[[u8; 4]]| cell.iter().map(|b| value(b) / channels as f32).sum();
            let numbers = cells.chunks_exact(channels).map(mean);
            Values::Numbers(listed(count / channels, numbers).ok_or_else(short)?)
        };
        Ok((Cells { size, values, bounds }, channels))
    }

    fn count(&self) -> u64 {
        self.size.iter().map(|s| u64::from(*s)).product()
    }

    /// Bytes of a cell.
    fn cell(&self) -> u64 {
        match self.values {
            Values::Numbers(_) => 4,
            Values::Colors(_) => COLOR,
        }
    }

    /// Bytes of all values.
    pub(super) fn bytes(&self) -> u64 {
        self.cell() * self.count()
    }

    /// The cells where a transform places them. `None` if memory is short.
    pub(super) fn placed(self, place: &GridBox) -> Option<Cells> {
        let [min, max] = place.bounds;
        let bounds = [min, max + 1e-9];
        if place.keeps_cells() {
            return Some(Cells { bounds, ..self });
        }
        let values = match &self.values {
            Values::Numbers(values) => Values::Numbers(place.values(self.size, values)?),
            Values::Colors(values) => Values::Colors(place.values(self.size, values)?),
        };
        Some(Cells { size: place.size(self.size), values, bounds })
    }

    /// The values as densities, by colour if they are colours.
    pub(super) fn into_grid(self) -> Result<GridData, String> {
        match self.values {
            Values::Numbers(values) => GridData::new(self.size, values, None),
            Values::Colors(values) => GridData::of_extinction(self.size, values, None),
        }
    }

    /// The values as albedos.
    pub(super) fn into_albedo(self) -> GridScattering {
        GridScattering::Albedo(match self.values {
            Values::Numbers(values) => values.iter().map(|v| [v.min(1.0); 3]).collect(),
            Values::Colors(mut values) => {
                values.as_flattened_mut().iter_mut().for_each(|v| *v = v.min(1.0));
                values
            }
        })
    }

    /// The cells that another grid has, with this grid's values: between the centres of its cells they are
    /// interpolated, beyond the outermost they are constant. `None` if memory is short.
    fn resampled(&self, size: [u32; 3], [min, max]: [DVec3; 2]) -> Option<Cells> {
        let [own_min, own_max] = self.bounds;
        let scale = DVec3::from(self.size.map(f64::from)) / (own_max - own_min);
        let step = (max - min) / DVec3::from(size.map(f64::from));
        // The two cells along an axis, and how far the place lies from the first to the second.
        let axis = |a: usize| -> Vec<[(usize, f64); 2]> {
            let n = self.size[a];
            let pair = |i: u32| {
                let p = min[a] + (f64::from(i) + 0.5) * step[a];
                let v = ((p - own_min[a]) * scale[a] - 0.5).clamp(0.0, f64::from(n - 1));
                let low = (v as u32).min(n - 1);
                let f = v - f64::from(low);
                [(low as usize, 1.0 - f), ((low + 1).min(n - 1) as usize, f)]
            };
            (0..size[a]).map(pair).collect()
        };
        let (xs, ys, zs) = (axis(0), axis(1), axis(2));
        let [nx, ny, _] = self.size.map(|n| n as usize);
        let places = || zs.iter().flat_map(|z| ys.iter().flat_map(|y| xs.iter().map(|x| [*x, *y, *z])));
        let of = |[x, y, z]: [[(usize, f64); 2]; 3], value: &dyn Fn(usize) -> f64| {
            let mut sum = 0.0;
            for (k, wz) in z {
                for (j, wy) in y {
                    sum += x.iter().map(|(i, wx)| wx * wy * wz * value(i + nx * (j + ny * k))).sum::<f64>();
                }
            }
            sum as f32
        };
        let number = |values: &[f32], i: usize| values.get(i).map_or(0.0, |v| f64::from(*v));
        let count = (xs.len() * ys.len()).checked_mul(zs.len())?;
        let values = match &self.values {
            Values::Numbers(v) => Values::Numbers(listed(count, places().map(|p| of(p, &|i| number(v, i))))?),
            Values::Colors(v) => {
                let flat = v.as_flattened();
                let color = |p| [0, 1, 2].map(|band| of(p, &|i| number(flat, 3 * i + band)));
                Values::Colors(listed(count, places().map(color))?)
            }
        };
        Some(Cells { size, values, bounds: [min, max] })
    }
}

/// Densities and albedos with the same cells in the box of the densities, and whether their interpolation is that of the
/// two grids. Where memory is short the cells are those of the densities.
///
/// Errors: not enough memory for these either.
pub(super) fn on_one_grid(
    density: Cells,
    albedo: Cells,
    memory: &Memory,
) -> Result<(Cells, Cells, bool), SceneError> {
    let what = || "a grid of albedos".to_owned();
    // Albedos become colours.
    let colors = |cells: u64| if albedo.cell() == COLOR { 0 } else { COLOR.saturating_mul(cells) };
    let is_near = |a: DVec3, b: DVec3| (a - b).abs().max_element() <= 1e-6 * (b.abs().max_element() + 1e-6);
    let is_one_box = density.bounds.iter().zip(albedo.bounds).all(|(a, b)| is_near(*a, b));
    if density.size == albedo.size && is_one_box {
        memory.need(colors(albedo.count()), what)?;
        return Ok((density, albedo, true));
    }
    let bounds = density.bounds;
    let on = |size: [u32; 3]| -> Result<(Option<Cells>, Cells), SceneError> {
        let cells = size.iter().fold(1u64, |n, s| n.saturating_mul(u64::from(*s)));
        let moves = size != density.size;
        let own = if moves { density.cell() } else { 0 };
        memory.need(cells.saturating_mul(own + albedo.cell()).saturating_add(colors(cells)), what)?;
        let short = || SceneError::new(ErrorCode::TooLarge, "not enough memory for a grid of albedos");
        let made = if moves { Some(density.resampled(size, bounds).ok_or_else(short)?) } else { None };
        Ok((made, albedo.resampled(size, bounds).ok_or_else(short)?))
    };
    let mut size: [u32; 3] = std::array::from_fn(|a| density.size[a].max(albedo.size[a]));
    // Long and thin grids across one another would become a large one.
    let count = size.iter().try_fold(1u64, |n, s| n.checked_mul(u64::from(*s)));
    let mut made = None;
    if size != density.size && count.is_some_and(|n| n <= 4 * (density.count() + albedo.count())) {
        made = on(size).ok();
    }
    let (own, scattered) = match made {
        Some(made) => made,
        None => {
            size = density.size;
            on(size)?
        }
    };
    // Constant values stay what they are.
    let is_even = (is_one_box && density.count() == 1 && size == albedo.size)
        || (albedo.count() == 1 && size == density.size);
    Ok((own.unwrap_or(density), scattered, is_even))
}

#[cfg(test)]
pub(super) mod tests {
    use std::sync::Arc;

    use turner::description::SceneDesc;
    use turner::medium::MediumDesc;
    use turner::schema::Limits;

    use super::*;
    use crate::assets::MemoryAssets;
    use crate::import::ImportOptions;

    /// A file of cells.
    pub(in crate::mitsuba) fn file(size: [i32; 3], channels: i32, values: &[f32]) -> Vec<u8> {
        let mut out = b"VOL\x03".to_vec();
        [1, size[0], size[1], size[2], channels].iter().for_each(|v| out.extend(v.to_le_bytes()));
        [-1.0f32, -1.0, -1.0, 1.0, 2.0, 3.0].iter().for_each(|v| out.extend(v.to_le_bytes()));
        values.iter().for_each(|v| out.extend(v.to_le_bytes()));
        out
    }

    #[test]
    fn three_channels_are_colors() {
        let values: Vec<f32> = (0..12).map(|i| i as f32).collect();
        let (cells, channels) = Cells::read(&file([2, 2, 1], 3, &values)).unwrap();
        assert_eq!((channels, cells.bounds[1]), (3, DVec3::new(1.0, 2.0, 3.0)));
        let grid = cells.into_grid().unwrap();
        assert_eq!(grid.extinction().unwrap()[1], [3.0, 4.0, 5.0]);
        assert_eq!(grid.density(), [2.0, 5.0, 8.0, 11.0]);
        let (cells, _) = Cells::read(&file([2, 1, 1], 2, &values[..4])).unwrap();
        assert_eq!(cells.into_grid().unwrap().density(), [0.5, 2.5]);
        assert!(Cells::read(&file([2, 2, 1], 3, &values[..11])).is_err());
        assert!(Cells::read(&file([0, 2, 1], 3, &values)).is_err());
        assert!(Cells::read(&file([i32::MAX, i32::MAX, i32::MAX], 3, &values)).is_err());
    }

    /// A grid that is linear along each axis stays so between the outermost centres.
    #[test]
    fn albedos_are_resampled() {
        let line = |n: i32| (0..n).map(|i| (i as f32 + 0.5) / n as f32).collect::<Vec<f32>>();
        let read = |n| Cells::read(&file([n, 1, 1], 1, &line(n))).unwrap().0;
        let (density, albedo, is_exact) = on_one_grid(read(8), read(4), &Memory::default()).unwrap();
        assert!(!is_exact);
        assert_eq!(density.into_grid().unwrap().density(), line(8));
        let GridScattering::Albedo(found) = albedo.into_albedo() else { panic!() };
        let expected = line(8);
        for (i, found) in found.iter().enumerate() {
            let expected = expected[i].clamp(0.125, 0.875);
            assert!((found[1] - expected).abs() < 1e-6, "{i}: {found:?}, not {expected}");
        }
        let bounds = read(3).bounds;
        let (density, _, is_exact) = on_one_grid(Cells::even(bounds), read(3), &Memory::default()).unwrap();
        assert!(is_exact);
        assert_eq!(density.into_grid().unwrap().density(), [1.0; 3]);
        // Across one another.
        let thin = |size| Cells::read(&file(size, 1, &[0.5; 300])).unwrap().0;
        let (density, albedo, _) =
            on_one_grid(thin([300, 1, 1]), thin([1, 300, 1]), &Memory::default()).unwrap();
        assert_eq!((density.size, albedo.size), ([300, 1, 1], [300, 1, 1]));
    }

    /// Where memory is short the cells are those of the densities.
    #[test]
    fn resampled_grids_need_memory() {
        let read = |size: [i32; 3]| {
            let count = size.iter().product::<i32>() as usize;
            Cells::read(&file(size, 1, &vec![0.5; count])).unwrap().0
        };
        let made = |bytes: u64| {
            let memory = Memory::new(bytes, || None);
            on_one_grid(read([32, 32, 32]), read([16, 16, 64]), &memory).map(|(_, albedo, _)| albedo.size)
        };
        assert_eq!(made(1 << 21).unwrap(), [32, 32, 64]);
        assert_eq!(made(600_000).unwrap(), [32, 32, 32]);
        assert!(made(100_000).unwrap_err().message.contains("a grid of albedos needs"));
    }

    /// A medium in a grid of n × 1 × 1 cells.
    fn medium(n: i32, to_world: &str, memory: Memory) -> Result<SceneDesc, SceneError> {
        let values: Vec<f32> = (0..n).map(|i| 1.0 + i as f32).collect();
        let text = format!(
            "<scene version='3.0.0'><shape type='sphere'><bsdf type='null'/><medium name='interior' type='heterogeneous'>\
             <volume name='sigma_t' type='gridvolume'><string name='filename' value='c.vol'/>\
             <transform name='to_world'>{to_world}</transform></volume></medium></shape></scene>"
        );
        let mut assets = MemoryAssets::default();
        assets.files.insert("c.vol".into(), file([n, 1, 1], 1, &values));
        let limits = Limits { memory: Arc::new(memory), ..Limits::default() };
        let options = ImportOptions { limits, ..ImportOptions::default() };
        crate::mitsuba::import_from(text.into_bytes(), "a.xml", &assets, &options)
    }

    /// In Mitsuba 0.6 grids fill the box of their file, and constant volumes have no box; later versions place the unit
    /// cube.
    #[test]
    fn volumes_of_mitsuba_0_6_have_their_own_boxes() {
        let read = |version: &str, volume: &str| {
            let text = format!(
                "<scene version='{version}'><shape type='sphere'><bsdf type='null'/>\
                 <medium name='interior' type='heterogeneous'>{volume}</medium></shape></scene>"
            );
            let mut grid = file([2, 1, 1], 1, &[1.0, 2.0]);
            for (i, v) in [-3.0f32, -2.0, -1.0, 1.0, 2.0, 3.0].into_iter().enumerate() {
                grid[24 + 4 * i..28 + 4 * i].copy_from_slice(&v.to_le_bytes());
            }
            let mut assets = MemoryAssets::default();
            assets.files.insert("c.vol".into(), grid);
            let options = ImportOptions::default();
            let scene = crate::mitsuba::import_from(text.into_bytes(), "a.xml", &assets, &options).unwrap();
            scene.media[0].value.clone()
        };
        let grid =
            "<volume name='density' type='gridvolume'><string name='filename' value='c.vol'/></volume>";
        let even = "<volume name='density' type='constvolume'><float name='value' value='2'/></volume>";
        for (version, bounds) in [
            ("0.5.0", [DVec3::new(-3.0, -2.0, -1.0), DVec3::new(1.0, 2.0, 3.0)]),
            ("3.0.0", [DVec3::ZERO, DVec3::ONE]),
        ] {
            let MediumDesc::Grid(medium) = read(version, grid) else { panic!() };
            // The reader widens boxes a little, so that none is empty.
            let is_near = medium.bounds().iter().zip(bounds).all(|(a, b)| a.abs_diff_eq(b, 1e-8));
            assert!(is_near, "{version}: {:?}", medium.bounds());
        }
        assert!(matches!(read("0.5.0", even), MediumDesc::Homogeneous(_)));
        assert!(matches!(read("3.0.0", even), MediumDesc::Grid(_)));
    }

    #[test]
    fn rotated_grids_keep_their_cells_or_fill_the_box_around() {
        let root = 0.5f64.sqrt();
        for (to_world, size, density, min, max, warnings) in [
            ("<rotate z='1' angle='90'/>", [1, 2, 1], [1.0, 2.0], DVec3::NEG_X, DVec3::new(0.0, 1.0, 1.0), 0),
            ("<scale x='-2'/>", [2, 1, 1], [2.0, 1.0], DVec3::NEG_X * 2.0, DVec3::new(0.0, 1.0, 1.0), 0),
            (
                "<rotate z='1' angle='-45'/>",
                [2, 1, 1],
                [1.0, 2.0],
                DVec3::NEG_Y * root,
                DVec3::new(2.0 * root, root, 1.0),
                1,
            ),
        ] {
            let scene = medium(2, to_world, Memory::default()).unwrap();
            let MediumDesc::Grid(grid) = &scene.media[0].value else { panic!() };
            assert_eq!(grid.file.data.size(), size, "{to_world}");
            assert_eq!(grid.file.data.density(), density, "{to_world}");
            let [a, b] = grid.bounds();
            assert!((a - min).length() < 1e-8 && (b - max).length() < 1e-8, "{to_world}: {a} {b}");
            assert_eq!(scene.warnings.len(), warnings, "{:?}", scene.warnings);
        }
    }

    #[test]
    fn grids_need_memory() {
        assert!(medium(40_000, "", Memory::new(400_000, || None)).is_ok());
        let error = medium(40_000, "", Memory::new(300_000, || None)).unwrap_err();
        assert!(error.message.contains("c.vol: reading it needs"), "{}", error.message);
    }
}
