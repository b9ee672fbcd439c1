//! Drawings as SVG and PNG, by the crate `plotters`.
//!
//! Its bitmaps have hard edges and whole pixels, so both forms are drawn larger than they are shown: SVG gets fractions of a pixel that way,
//! and PNG smooth edges by averaging.

use std::sync::OnceLock;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use plotters::backend::{BitMapBackend, DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{
    Color as _, FontDesc, FontFamily, FontStyle, RGBAColor, RGBColor, ShapeStyle, TextStyle, register_font,
};

use super::drawing::{Anchor, Color, Drawing, Image, Mark, Point};
use crate::estimate::picture_files::{PictureFileError, encode_png_bytes};

/// Pixels drawn for a pixel of the drawing.
const FINENESS: u32 = 4;
/// Pixels of a PNG for a pixel of the drawing.
const PNG_DENSITY: u32 = 2;
/// The font's name; browsers know it too.
const FAMILY: &str = "sans-serif";
/// `plotters` takes a size to be 1.24 em.
const SIZE_OF_EM: f64 = 1.24;
/// Height of the bitmap font from its highest to its lowest letter, em: `ab_glyph` scales by it.
const BITMAP_FONT_HEIGHT: f64 = 1.121;
/// From where `plotters` puts a text's middle to the middle of capitals and digits, em.
const SVG_TEXT_DROP: f64 = 0.08;
const BITMAP_TEXT_DROP: f64 = 0.23;

/// A drawing that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum CanvasError {
    /// The font or the backend refused.
    #[error("cannot draw the chart: {problem}")]
    Draw {
        /// What was said.
        problem: String,
    },
    /// The PNG cannot be encoded.
    #[error(transparent)]
    Encode(#[from] PictureFileError),
}

/// The two forms differ in how letters are measured.
#[derive(Clone, Copy, PartialEq)]
enum Form {
    Svg,
    Bitmap,
}

/// The drawing as an SVG document.
pub fn to_svg(drawing: &Drawing) -> Result<String, CanvasError> {
    let (width, height) = fine_size(drawing);
    let mut text = String::new();
    play(drawing, SVGBackend::with_string(&mut text, (width, height)), Form::Svg)?;
    let fine = format!("width=\"{width}\" height=\"{height}\" viewBox");
    let shown = format!("width=\"{}\" height=\"{}\" viewBox", width / FINENESS, height / FINENESS);
    let images = drawing.images.iter().map(svg_image).collect::<Result<String, _>>()?;
    // The first element is the ground.
    Ok(text.replacen(&fine, &shown, 1).replacen("/>\n", &format!("/>\n{images}"), 1))
}

/// An image as an element; the backend has none.
fn svg_image(image: &Image) -> Result<String, CanvasError> {
    let ((x, y), (width, height)) = (fine_point(&image.corner), fine_point(&image.size));
    let png = STANDARD.encode(encode_png_bytes(&image.pixels.concat(), image.width, image.height)?);
    Ok(format!(
        "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
         style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{png}\"/>\n"
    ))
}

/// The drawing as a PNG, two pixels for each of the drawing's.
pub fn to_png(drawing: &Drawing) -> Result<Vec<u8>, CanvasError> {
    let (width, height) = fine_size(drawing);
    let mut fine = vec![255; (width * height * 3) as usize];
    play(drawing, BitMapBackend::with_buffer(&mut fine, (width, height)), Form::Bitmap)?;
    let step = (FINENESS / PNG_DENSITY) as usize;
    let (columns, rows) = (width as usize / step, height as usize / step);
    let mut bytes = Vec::with_capacity(columns * rows * 3);
    for row in 0..rows {
        for column in 0..columns {
            for channel in 0..3 {
                let pixel = |index: usize| {
                    let (x, y) = (column * step + index % step, row * step + index / step);
                    usize::from(fine[(y * width as usize + x) * 3 + channel])
                };
                bytes.push(((0..step * step).map(pixel).sum::<usize>() / (step * step)) as u8);
            }
        }
    }
    Ok(encode_png_bytes(&bytes, columns as u32, rows as u32)?)
}

fn fine_size(drawing: &Drawing) -> (u32, u32) {
    (drawing.width.ceil() as u32 * FINENESS, drawing.height.ceil() as u32 * FINENESS)
}

fn failed(error: impl std::fmt::Display) -> CanvasError {
    CanvasError::Draw { problem: error.to_string() }
}

/// Draws all marks in their order.
fn play<B: DrawingBackend>(drawing: &Drawing, mut backend: B, form: Form) -> Result<(), CanvasError> {
    register()?;
    let (width, height) = backend.get_size();
    backend.draw_rect((0, 0), (width as i32, height as i32), &shape([255; 3], 1.0, 0.0), true).map_err(failed)?;
    if form == Form::Bitmap {
        drawing.images.iter().try_for_each(|image| blit(&mut backend, image))?;
    }
    for mark in &drawing.marks {
        let drawn = match mark {
            Mark::Line { points, color, width } => {
                backend.draw_path(points.iter().map(fine_point), &shape(*color, 1.0, *width))
            }
            Mark::Area { points, color, opacity } => {
                backend.fill_polygon(points.iter().map(fine_point), &shape(*color, *opacity, 0.0))
            }
            Mark::Text { at: [x, y], text, size, color, anchor } => {
                let (font_size, drop) = match form {
                    Form::Svg => (size * SIZE_OF_EM, SVG_TEXT_DROP * size),
                    Form::Bitmap => (size * BITMAP_FONT_HEIGHT, BITMAP_TEXT_DROP * size),
                };
                backend.draw_text(text, &text_style(font_size, *color, *anchor), fine_point(&[*x, y + drop]))
            }
        };
        drawn.map_err(failed)?;
    }
    backend.present().map_err(failed)
}

fn blit<B: DrawingBackend>(backend: &mut B, image: &Image) -> Result<(), CanvasError> {
    let ((right, bottom), place) = (fine_point(&image.size), fine_point(&image.corner));
    let (width, height) = (right as u32, bottom as u32);
    let source = |x: u32, y: u32| {
        let (column, row) = (x as usize * image.width as usize, y as usize * image.height as usize);
        image.pixels[row / height as usize * image.width as usize + column / width as usize]
    };
    let bytes: Vec<u8> = (0..height).flat_map(|y| (0..width).flat_map(move |x| source(x, y))).collect();
    backend.blit_bitmap(place, (width, height), &bytes).map_err(failed)
}

fn fine_point(point: &Point) -> (i32, i32) {
    let [x, y] = point.map(|place| (place * f64::from(FINENESS)).round() as i32);
    (x, y)
}

fn shape([red, green, blue]: Color, opacity: f64, width: f64) -> ShapeStyle {
    let stroke_width = (width * f64::from(FINENESS)).round() as u32;
    ShapeStyle { color: RGBAColor(red, green, blue, opacity), filled: true, stroke_width }
}

fn text_style(size: f64, [red, green, blue]: Color, anchor: Anchor) -> TextStyle<'static> {
    let horizontal = match anchor {
        Anchor::Start => HPos::Left,
        Anchor::Middle => HPos::Center,
        Anchor::End => HPos::Right,
    };
    let font = FontDesc::new(FontFamily::from(FAMILY), size * f64::from(FINENESS), FontStyle::Normal);
    let color = RGBColor(red, green, blue).to_backend_color();
    TextStyle { font, color, pos: Pos::new(horizontal, VPos::Center) }
}

/// Width of a text, pixels of the drawing. Browsers' fonts differ by a few percent. 0 when there is no font, which drawing will tell.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    let measured = register().ok().and_then(|()| {
        let fine = size * BITMAP_FONT_HEIGHT * f64::from(FINENESS);
        FontDesc::new(FontFamily::from(FAMILY), fine, FontStyle::Normal).box_size(text).ok()
    });
    measured.map_or(0.0, |(width, _)| f64::from(width) / f64::from(FINENESS))
}

fn register() -> Result<(), CanvasError> {
    static REGISTERED: OnceLock<bool> = OnceLock::new();
    let font = epaint_default_fonts::UBUNTU_LIGHT;
    match REGISTERED.get_or_init(|| register_font(FAMILY, FontStyle::Normal, font).is_ok()) {
        true => Ok(()),
        false => Err(CanvasError::Draw { problem: "the font cannot be read".to_owned() }),
    }
}
