//! EXR files in layouts of other programs: half and integer samples, every lossless compression, tiles, layers, data
//! windows that differ from the display window. Written here with the exr crate.

use exr::prelude::*;
use turner::image::{Image as Picture, Pixels};
use turner_io::image::{DecodeLimits, ImageError, decode};

const SIZE: Vec2<usize> = Vec2(37, 21);

fn samples() -> Vec<f32> {
    (0..SIZE.area()).map(|i| i as f32 * 0.25).collect()
}

fn half() -> FlatSamples {
    FlatSamples::F16(samples().iter().map(|&v| f16::from_f32(v)).collect())
}

fn channels(list: &[(&str, FlatSamples)]) -> AnyChannels<FlatSamples> {
    AnyChannels::sort(list.iter().map(|(name, s)| AnyChannel::new(*name, s.clone())).collect())
}

fn encoding(compression: Compression, blocks: Blocks) -> Encoding {
    Encoding { compression, blocks, line_order: LineOrder::Increasing }
}

fn write(layer: Layer<AnyChannels<FlatSamples>>) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

fn read(bytes: &[u8]) -> std::result::Result<Picture, ImageError> {
    decode(bytes, "other.exr", &DecodeLimits::default())
}

fn floats(image: &Picture) -> &[f32] {
    match &image.pixels {
        Pixels::F32(v) => v,
        _ => panic!("EXR is float"),
    }
}

#[test]
fn every_lossless_compression_in_lines_and_tiles() {
    use Compression::*;
    for compression in [Uncompressed, RLE, ZIP1, ZIP16, PIZ] {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 8))] {
            let list = channels(&[
                ("R", half()),
                ("G", FlatSamples::F32(samples())),
                ("B", FlatSamples::U32(samples().iter().map(|&v| v as u32).collect())),
                ("Z", half()),
            ]);
            let layer = Layer::new(SIZE, LayerAttributes::named("main"), encoding(compression, blocks), list);
            let image = read(&write(layer)).unwrap();
            assert_eq!((image.width, image.height, image.channels), (37, 21, 3));
            for (p, v) in floats(&image).chunks(3).zip(samples()) {
                assert_eq!(p, [v, v, v.floor()]);
            }
        }
    }
}

fn layer_of(list: &[(&str, FlatSamples)]) -> Layer<AnyChannels<FlatSamples>> {
    let encoding = encoding(Compression::ZIP16, Blocks::ScanLines);
    Layer::new(SIZE, LayerAttributes::named("main"), encoding, channels(list))
}

#[test]
fn grey_single_and_layered_channels_are_found() {
    let image = read(&write(layer_of(&[("Y", half())]))).unwrap();
    assert_eq!((image.channels, floats(&image)), (1, &samples()[..]));
    let image = read(&write(layer_of(&[("depth", half())]))).unwrap();
    assert_eq!(image.channels, 1);
    let list = [("diffuse.R", half()), ("diffuse.G", half()), ("diffuse.B", half()), ("depth.Z", half())];
    let image = read(&write(layer_of(&list))).unwrap();
    assert_eq!((image.channels, floats(&image)[3 * 5]), (3, 1.25));
    let two = FlatSamples::F16(vec![f16::from_f32(0.5); SIZE.area()]);
    let image = read(&write(layer_of(&[("Y", half()), ("A", two)]))).unwrap();
    // Straight alpha: divided by an alpha of 0.5.
    assert_eq!((image.channels, floats(&image)[2 * 5]), (2, 2.5));
}

#[test]
fn missing_channels_are_named() {
    let message = read(&write(layer_of(&[("R", half()), ("B", half())]))).unwrap_err().to_string();
    assert!(message.contains("other.exr") && message.contains("without G"), "{message}");
}

#[test]
fn the_display_window_is_the_picture() {
    let mut layer = layer_of(&[("Y", half())]);
    layer.attributes.layer_position = Vec2(-2, 3);
    let mut image = Image::from_layer(layer);
    image.attributes.display_window = IntegerBounds::new((35, 0), (50, 10));
    let mut apart = std::io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut apart).unwrap();
    assert!(read(apart.get_ref()).unwrap_err().to_string().contains("display window"));
    image.attributes.display_window = IntegerBounds::new((0, 0), (50, 10));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    let image = read(bytes.get_ref()).unwrap();
    assert_eq!((image.width, image.height), (50, 10));
    let at = |x: usize, y: usize| floats(&image)[y * 50 + x];
    assert_eq!((at(0, 0), at(0, 2), at(35, 4)), (0.0, 0.0, 0.0));
    assert_eq!((at(0, 3), at(34, 3), at(0, 9)), (0.5, 9.0, samples()[6 * 37 + 2]));
}

#[test]
fn a_block_listed_twice_is_refused() {
    let mut bytes = write(layer_of(&[("Y", half())]));
    // The offset table follows the header: two blocks of 16 rows. Set both entries to the first block.
    let table = bytes.windows(8).position(|w| {
        let offset = u64::from_le_bytes(w.try_into().unwrap());
        offset > 300 && offset < 700
    });
    let at = table.unwrap();
    let first: [u8; 8] = bytes[at..at + 8].try_into().unwrap();
    bytes[at + 8..at + 16].copy_from_slice(&first);
    let message = read(&bytes).unwrap_err().to_string();
    assert!(message.contains("twice"), "{message}");
}
