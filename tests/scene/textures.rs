//! Textures through `Scene::prepare`: every file format at known texture coordinates, filters, wraps and transforms, and
//! what users read when a texture cannot be.

use std::f32::consts::PI;
use std::io::Cursor;

use crate::scene_files::{exr_file, prepare};
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, LumaA, Rgb as Pixel, Rgba};
use photonfarm::math::random::{PathRandom, Stream};
use photonfarm::math::{Rgb, Vec2, Vec3};
use photonfarm::scene::Scene;
use photonfarm::scene::geometry::Ray;
use photonfarm::scene::material::{TransportMode, View};

/// A lit rectangle with a reflectance.
fn body(texture: &str) -> String {
    format!(
        "<sensor type='perspective'><transform name='to_world'><lookat origin='0,0,5' target='0,0,0' up='0,1,0'/>\
        </transform></sensor><emitter type='point'/><shape type='rectangle'><bsdf type='diffuse'>{texture}</bsdf></shape>"
    )
}

fn bitmap(file: &str, parameters: &str) -> String {
    format!("<texture name='reflectance' type='bitmap'><string name='filename' value='{file}'/>{parameters}</texture>")
}

fn scene(texture: &str, files: &[(&str, &[u8])]) -> Scene {
    prepare(&body(texture), files).unwrap_or_else(|error| panic!("{texture}: {error}"))
}

fn error(texture: &str, files: &[(&str, &[u8])]) -> String {
    prepare(&body(texture), files).err().unwrap_or_else(|| panic!("{texture} is no error")).to_string()
}

/// The reflectance of the scene's rectangle at `uv`.
fn reflectance(scene: &Scene, uv: [f32; 2]) -> Rgb {
    let view = View::new(Vec2::from_array(uv), Vec3::Z, TransportMode::Radiance);
    scene.materials[0].constant_value(&view).expect("it is matte") * PI
}

fn assert_color(scene: &Scene, uv: [f32; 2], expected: [f32; 3], what: &str) {
    let found = reflectance(scene, uv);
    assert!(found.distance(Rgb::from_array(expected)) < 1e-5, "{what} at {uv:?}: {found} for {expected:?}");
}

fn linear(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

fn encode(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    image.into().write_to(&mut file, format).expect("images can be written");
    file.into_inner()
}

/// The middles of the texels of a 2 × 2 image, row by row from the top.
const MIDDLES: [[f32; 2]; 4] = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]];
const BYTES: [[u8; 3]; 4] = [[255, 0, 10], [0, 200, 30], [60, 90, 120], [7, 8, 250]];

fn bytes_2x2() -> ImageBuffer<Pixel<u8>, Vec<u8>> {
    ImageBuffer::from_raw(2, 2, BYTES.concat()).expect("the size is right")
}

// ---- Formats. -----------------------------------------------------------------------------------------------------

#[test]
fn textures_of_bytes_are_srgb_unless_raw() {
    for (name, format) in [("a.png", ImageFormat::Png), ("a.tga", ImageFormat::Tga)] {
        let file = encode(bytes_2x2(), format);
        let files: &[(&str, &[u8])] = &[(name, &file)];
        let plain = scene(&bitmap(name, ""), files);
        let raw = scene(&bitmap(name, "<boolean name='raw' value='true'/>"), files);
        for (uv, bytes) in MIDDLES.into_iter().zip(BYTES) {
            let shares = bytes.map(|byte| f32::from(byte) / 255.0);
            assert_color(&plain, uv, shares.map(linear), name);
            assert_color(&raw, uv, shares, name);
        }
    }
}

#[test]
fn textures_of_jpeg_are_read() {
    let image = ImageBuffer::from_pixel(16, 16, Pixel([200u8, 100, 50]));
    let file = encode(image, ImageFormat::Jpeg);
    let scene = scene(&bitmap("a.jpg", "<boolean name='raw' value='true'/>"), &[("a.jpg", &file)]);
    let found = reflectance(&scene, [0.3, 0.6]) * 255.0;
    assert!(found.distance(Rgb::new(200.0, 100.0, 50.0)) < 4.0, "{found}");
}

#[test]
fn textures_of_16_bits_keep_them() {
    let shares: [u16; 4] = [0, 1, 33_333, 65_535];
    let grey = ImageBuffer::<Luma<u16>, _>::from_raw(2, 2, shares.to_vec()).expect("the size is right");
    let file = encode(grey, ImageFormat::Png);
    let files: &[(&str, &[u8])] = &[("a.png", &file)];
    let plain = scene(&bitmap("a.png", ""), files);
    let raw = scene(&bitmap("a.png", "<boolean name='raw' value='true'/>"), files);
    for (uv, share) in MIDDLES.into_iter().zip(shares) {
        let share = f32::from(share) / 65_535.0;
        assert_color(&plain, uv, [linear(share); 3], "16 bits");
        assert_color(&raw, uv, [share; 3], "16 bits raw");
    }
}

#[test]
fn textures_of_floats_are_linear() {
    let colors = [[0.0, 0.25, 1.0], [0.5, 0.125, 0.0625], [0.75, 0.5, 0.25], [1.0, 0.5, 0.5]];
    let at = |x: usize, y: usize| colors[2 * y + x];
    let exr = exr_file(2, 2, at);
    let hdr = ImageBuffer::<Pixel<f32>, _>::from_raw(2, 2, colors.concat()).expect("the size is right");
    let hdr = encode(hdr, ImageFormat::Hdr);
    for (name, file) in [("a.exr", &exr), ("a.hdr", &hdr)] {
        let scene = scene(&bitmap(name, ""), &[(name, file)]);
        for (uv, expected) in MIDDLES.into_iter().zip(colors) {
            // Radiance HDR has 8 bits and a common exponent.
            let tolerance = if name == "a.hdr" { 1.0 / 128.0 } else { 1e-6 };
            let found = reflectance(&scene, uv);
            assert!(found.distance(Rgb::from_array(expected)) < tolerance, "{name} at {uv:?}: {found}");
        }
    }
}

#[test]
fn textures_give_single_channels() {
    let colors = ImageBuffer::from_pixel(1, 1, Rgba([51u8, 102, 153, 204]));
    let (colors, opaque) = (encode(colors, ImageFormat::Png), encode(bytes_2x2(), ImageFormat::Png));
    let grey = encode(ImageBuffer::from_pixel(1, 1, LumaA([51u8, 102])), ImageFormat::Png);
    let files: &[(&str, &[u8])] = &[("a.png", &colors), ("b.png", &opaque), ("c.png", &grey)];
    let expected = [
        ("a.png", "r", true, 0.2),
        ("a.png", "g", true, 0.4),
        ("a.png", "b", true, 0.6),
        ("a.png", "a", true, 0.8),
        // Alpha is never sRGB.
        ("a.png", "r", false, linear(0.2)),
        ("a.png", "a", false, 0.8),
        ("b.png", "a", false, 1.0),
        ("c.png", "b", true, 0.2),
        ("c.png", "a", true, 0.4),
    ];
    for (file, channel, raw, expected) in expected {
        let parameters = format!("<string name='channel' value='{channel}'/><boolean name='raw' value='{raw}'/>");
        let scene = scene(&bitmap(file, &parameters), files);
        assert_color(&scene, [0.25, 0.25], [expected; 3], &format!("{file} {channel} raw {raw}"));
    }
}

// ---- Filters, wraps and transforms. -------------------------------------------------------------------------------

/// Four greys in a row: 0, 0.2, 0.4 and 1, one texel high.
fn steps() -> Vec<u8> {
    let greys = vec![0u8, 51, 102, 255];
    encode(ImageBuffer::<Luma<u8>, _>::from_raw(4, 1, greys).expect("the size is right"), ImageFormat::Png)
}

fn assert_along_u(parameters: &str, expected: &[(f32, f32)]) {
    let file = steps();
    let parameters = format!("<boolean name='raw' value='true'/>{parameters}");
    let scene = scene(&bitmap("a.png", &parameters), &[("a.png", &file)]);
    for (u, value) in expected {
        assert_color(&scene, [*u, 0.3], [*value; 3], &parameters);
    }
}

#[test]
fn textures_wrap_and_filter() {
    let wrap = |mode: &str| format!("<string name='wrap_mode' value='{mode}'/>");
    let inside = [(0.125, 0.0), (0.25, 0.1), (0.375, 0.2), (0.5, 0.3), (0.75, 0.7), (0.875, 1.0)];
    for mode in ["repeat", "mirror", "clamp"] {
        assert_along_u(&wrap(mode), &inside);
    }
    assert_along_u(
        &wrap("repeat"),
        &[(0.0, 0.5), (1.0, 0.5), (1.25, 0.1), (-0.75, 0.1), (-7.125, 1.0), (0.9375, 0.75)],
    );
    assert_along_u(&wrap("mirror"), &[(0.0, 0.0), (1.0, 1.0), (1.25, 0.7), (-0.25, 0.1), (2.25, 0.1), (-1.25, 0.7)]);
    assert_along_u(&wrap("clamp"), &[(0.0, 0.0), (-3.0, 0.0), (1.0, 1.0), (8.5, 1.0)]);
    let nearest = "<string name='filter_type' value='nearest'/>";
    assert_along_u(
        nearest,
        &[(0.01, 0.0), (0.24, 0.0), (0.26, 0.2), (0.74, 0.4), (0.76, 1.0), (1.3, 0.2), (-0.1, 1.0)],
    );
}

#[test]
fn textures_are_transformed() {
    let to_uv = |steps: &str| format!("<transform name='to_uv'>{steps}</transform>");
    assert_along_u(&to_uv("<scale x='0.5'/>"), &[(0.25, 0.0), (0.5, 0.1), (1.75, 1.0)]);
    assert_along_u(&to_uv("<translate x='0.25'/>"), &[(0.125, 0.2), (0.0, 0.1)]);
    assert_along_u(&to_uv("<scale x='0.5'/><translate x='0.25'/>"), &[(0.25, 0.2)]);
    // u' = v: a quarter turn.
    assert_along_u(&to_uv("<matrix value='0 1 0 0  1 0 0 0  0 0 1 0  0 0 0 1'/>"), &[(0.0, 0.14), (0.9, 0.14)]);
}

#[test]
fn textures_checkerboard_and_scale() {
    let colors = "<rgb name='color0' value='0.1, 0.2, 0.3'/><float name='color1' value='0.9'/>";
    let board = scene(&format!("<texture type='checkerboard' name='reflectance'>{colors}</texture>"), &[]);
    for (uv, first) in
        [([0.2, 0.2], true), ([0.7, 0.2], false), ([0.2, 0.7], false), ([0.7, 0.7], true), ([1.2, -0.7], true)]
    {
        assert_color(&board, uv, if first { [0.1, 0.2, 0.3] } else { [0.9; 3] }, "checkerboard");
    }
    let file = steps();
    let scaled = |scale: &str| {
        format!(
            "<texture type='scale' name='reflectance'>{scale}{}</texture>",
            bitmap("a.png", "<boolean name='raw' value='true'/>")
        )
    };
    let half = scene(&scaled("<float name='scale' value='0.5'/>"), &[("a.png", &file)]);
    assert_color(&half, [0.875, 0.0], [0.5; 3], "scale");
    let tint = scene(&scaled("<rgb name='scale' value='1, 0.5, 0.25'/>"), &[("a.png", &file)]);
    assert_color(&tint, [0.875, 0.0], [1.0, 0.5, 0.25], "scale");
}

#[test]
fn textures_are_found_by_reference_and_reach_the_hit() {
    let file = encode(bytes_2x2(), ImageFormat::Png);
    let texture = format!(
        "<texture type='bitmap' id='t'><string name='filename' value='a.png'/></texture>{}",
        body("<ref name='reflectance' id='t'/>")
    );
    let scene = prepare(&texture, &[("a.png", &file)]).expect("the scene is good");
    // The top row of the image lies at v = 0: towards -y of a rectangle.
    let places = [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)];
    for ((x, y), bytes) in places.into_iter().zip(BYTES) {
        let hit = scene.geometry.intersect(&Ray::new(Vec3::new(x, y, 2.0), -Vec3::Z)).expect("the ray hits");
        assert_color(&scene, hit.uv.to_array(), bytes.map(|byte| linear(f32::from(byte) / 255.0)), "a hit");
    }
}

// ---- What is refused. ---------------------------------------------------------------------------------------------

#[test]
fn textures_that_cannot_be() {
    let png = encode(bytes_2x2(), ImageFormat::Png);
    let bright = exr_file(2, 2, |x, _| [0.5, x as f32 * 1.5, 0.0]);
    let negative = exr_file(2, 2, |x, _| [0.5, -(x as f32), 0.0]);
    let infinite = exr_file(2, 2, |x, _| [0.5, 1.0 / x as f32, 0.0]);
    // The header says 60 000 × 60 000.
    let mut vast = png.clone();
    vast[16..24].copy_from_slice(&[0, 0, 0xea, 0x60, 0, 0, 0xea, 0x60]);
    let checksum = crc32(&vast[12..29]).to_be_bytes();
    vast[29..33].copy_from_slice(&checksum);
    let files: &[(&str, &[u8])] = &[
        ("a.png", &png),
        ("short.png", &png[..png.len() / 2]),
        ("vast.png", &vast),
        ("text.png", b"not an image"),
        ("bright.exr", &bright),
        ("short.exr", &bright[..bright.len() - 20]),
        ("negative.exr", &negative),
        ("infinite.exr", &infinite),
        ("empty.tga", b""),
    ];
    let cases = [
        (bitmap("b.png", ""), "a.png"),
        (bitmap("short.png", ""), "short.png"),
        (bitmap("vast.png", ""), "60000 × 60000"),
        (bitmap("text.png", ""), "no image"),
        (bitmap("bright.exr", ""), "goes up to 0.5, 1.5, 0"),
        (bitmap("short.exr", ""), "short.exr"),
        (bitmap("negative.exr", ""), "goes down to 0.5, -1, 0"),
        (bitmap("infinite.exr", ""), "not finite"),
        (bitmap("empty.tga", ""), "empty.tga"),
        (bitmap("a.png", "<string name='wrap_mode' value='repeats'/>"), "did you mean \"repeat\"?"),
        (bitmap("a.png", "<string name='filter_mode' value='nearest'/>"), "did you mean \"filter_type\"?"),
        ("<texture name='reflectance' type='bitmap'/>".to_owned(), "no \"filename\""),
        ("<texture name='reflectance' type='bitmat'/>".to_owned(), "did you mean \"bitmap\"?"),
        ("<texture name='reflectanse' type='checkerboard'/>".to_owned(), "did you mean \"reflectance\"?"),
        ("<texture type='checkerboard'/>".to_owned(), "has no name"),
        (
            "<texture name='reflectance' type='checkerboard'/><float name='reflectance' value='1'/>".to_owned(),
            "as a texture",
        ),
        (
            "<texture name='reflectance' type='checkerboard'/><texture name='reflectance' type='checkerboard'/>"
                .to_owned(),
            "another texture",
        ),
        ("<texture name='reflectance' type='scale'/>".to_owned(), "holds no texture"),
    ];
    for (texture, part) in cases {
        let message = error(&texture, files);
        assert!(message.contains(part) && message.contains("test.xml"), "{texture}: {message}");
    }
}

/// Any bytes are an image or an error.
#[test]
fn textures_survive_damaged_files() {
    let colors = ImageBuffer::from_fn(9, 7, |x, y| Pixel([20 * x as u8, 30 * y as u8, 255]));
    let floats = ImageBuffer::from_fn(9, 7, |x, y| Pixel([x as f32 / 9.0, y as f32 / 7.0, 1.0]));
    let files = [
        ("a.png", encode(colors.clone(), ImageFormat::Png)),
        ("a.jpg", encode(colors.clone(), ImageFormat::Jpeg)),
        ("a.tga", encode(colors, ImageFormat::Tga)),
        ("a.hdr", encode(floats, ImageFormat::Hdr)),
        ("a.exr", exr_file(9, 7, |x, y| [x as f32 / 9.0, y as f32 / 7.0, 1.0])),
    ];
    for (family, (name, file)) in (0..).zip(&files) {
        for damage in 0..400 {
            let mut file = file.clone();
            for change in 0..1 + damage % 4 {
                let random = PathRandom::new(1, Stream::Camera, family, 8 * damage + change).block(0);
                // Headers are where the damage is.
                let reach = if random[2] < 0.7 { file.len().min(400) } else { file.len() };
                let place = (random[0] * reach as f32) as usize;
                file[place] = (random[1] * 256.0) as u8;
            }
            if damage % 5 == 0 {
                file.truncate(file.len() * damage as usize / 400);
            }
            let _ = prepare(&body(&bitmap(name, "")), &[(name, &file)]);
        }
    }
}

/// Of a PNG chunk.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |remainder, byte| {
        (0..8).fold(
            remainder ^ u32::from(*byte),
            |bits, _| if bits & 1 == 1 { bits >> 1 ^ 0xedb8_8320 } else { bits >> 1 },
        )
    })
}
