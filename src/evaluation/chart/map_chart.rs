//! Layers of pictures in false colors, beside the scale that they share.

use super::canvas::text_width;
use super::color_scale::{ColorScale, NO_VALUE, ScaleError, ScaleRequest, palette};
use super::drawing::{Anchor, Drawing, FAINT_TONE, Image, Point, TONE};
use super::scale::number;
use crate::estimate::picture_files::LayerValues;

const EDGE: f64 = 14.0;
const TEXT: f64 = 12.0;
const TOP: f64 = 60.0;
/// Longest side of a map that is alone: small pictures are enlarged to about the first, large ones reduced to the second.
const ALONE: [f64; 2] = [512.0, 1024.0];
/// The same of one among others.
const TILE: [f64; 2] = [176.0, 176.0];
const GAP: f64 = 8.0;
const HEADING: f64 = 26.0;
const CAPTION: f64 = 16.0;
const BAR_WIDTH: f64 = 18.0;
/// Shortest and longest scale.
const BAR: [f64; 2] = [140.0, 512.0];

/// For what stands below it.
const BELOW_BAR: f64 = 44.0;

/// Maps of one size on one scale.
#[derive(Clone, Debug)]
pub struct MapSheet {
    /// What is shown.
    pub title: String,
    /// More of that, in one line.
    pub note: String,
    /// Of the values; stands above the scale.
    pub unit: String,
    /// Width of each map, pixels.
    pub width: u32,
    /// Height of each map, pixels.
    pub height: u32,
    /// Headings and the maps below each.
    pub rows: Vec<(String, Vec<Map>)>,
    /// Which value has which color.
    pub scale: ColorScale,
}

/// One of a [`MapSheet`].
#[derive(Clone, Debug)]
pub struct Map {
    /// Stands below it; may be empty.
    pub caption: String,
    /// Row-major, top row first, as many as its sheet has pixels. What is not finite has no value.
    pub values: Vec<f32>,
}

/// One layer of a picture `width` by `height` alone on a sheet.
pub fn draw_layer(
    layer: LayerValues,
    [width, height]: [u32; 2],
    note: &str,
    request: ScaleRequest,
) -> Result<Drawing, ScaleError> {
    let LayerValues { name, meaning, unit, values } = layer;
    let scale = ColorScale::covering(&values, request)?;
    let title = if meaning.is_empty() { name } else { format!("{name}: {meaning}") };
    let rows = vec![(String::new(), vec![Map { caption: String::new(), values }])];
    Ok(MapSheet { title, note: note.to_owned(), unit: unit.to_owned(), width, height, rows, scale }.draw())
}

impl MapSheet {
    /// Draws all maps, and the scale to the right of them.
    pub fn draw(&self) -> Drawing {
        let columns = self.rows.iter().map(|(_, maps)| maps.len()).max().unwrap_or(0);
        let size = self.shown_size(columns);
        let (row_height, map_top) = self.row_layout(size);
        let maps_width = columns as f64 * (size[0] + GAP);
        let maps_height = self.rows.len() as f64 * row_height;
        let bar_left = EDGE + maps_width + 2.0 * GAP;
        let bar_height = (maps_height - BELOW_BAR).clamp(BAR[0], BAR[1]);
        let legend = [TEXT * 2.0 + text_width(&self.unit, TEXT), text_width("no value", TEXT) + 2.0 * TEXT, 80.0];
        let wanted = [
            bar_left + legend.into_iter().fold(0.0, f64::max),
            EDGE + 1.05 * text_width(&self.title, 18.0),
            EDGE + 1.05 * text_width(&self.note, TEXT),
        ];
        let width = wanted.into_iter().fold(0.0, f64::max) + EDGE;
        let mut drawing = Drawing::new(width, TOP + maps_height.max(bar_height + BELOW_BAR) + EDGE);
        drawing.text([EDGE, 20.0], self.title.as_str(), 18.0, TONE, Anchor::Start);
        drawing.text([EDGE, 42.0], self.note.as_str(), TEXT, FAINT_TONE, Anchor::Start);
        for (row, (heading, maps)) in self.rows.iter().enumerate() {
            let top = TOP + row as f64 * row_height;
            drawing.text([EDGE, top + 12.0], heading.as_str(), 14.0, TONE, Anchor::Start);
            for (column, map) in maps.iter().enumerate() {
                let corner = [EDGE + column as f64 * (size[0] + GAP), top + map_top];
                self.place(&mut drawing, map, corner, size);
            }
        }
        self.bar(&mut drawing, [bar_left, TOP], bar_height);
        drawing
    }

    /// Maps keep whole pixels where they are enlarged.
    fn shown_size(&self, columns: usize) -> Point {
        let [small, large] = if columns > 1 { TILE } else { ALONE };
        let longest = f64::from(self.width.max(self.height).max(1));
        let factor = if longest <= small { (small / longest).floor() } else { (large / longest).min(1.0) };
        [self.width, self.height].map(|side| (f64::from(side) * factor).max(1.0))
    }

    /// Height of a row, and where in it maps begin.
    fn row_layout(&self, size: Point) -> (f64, f64) {
        let has = |text: fn(&(String, Vec<Map>)) -> bool| self.rows.iter().any(text);
        let heading = if has(|(heading, _)| !heading.is_empty()) { HEADING } else { 0.0 };
        let caption = if has(|(_, maps)| maps.iter().any(|map| !map.caption.is_empty())) { CAPTION } else { 0.0 };
        (heading + size[1] + caption + GAP, heading)
    }

    fn place(&self, drawing: &mut Drawing, map: &Map, corner: Point, size: Point) {
        let pixels = map.values.iter().map(|value| self.scale.color(*value)).collect();
        drawing.images.push(Image { corner, size, width: self.width, height: self.height, pixels });
        let below = [corner[0] + size[0] / 2.0, corner[1] + size[1] + 9.0];
        drawing.text(below, map.caption.as_str(), TEXT - 1.0, TONE, Anchor::Middle);
    }

    fn values(&self) -> impl Iterator<Item = f32> {
        self.rows.iter().flat_map(|(_, maps)| maps).flat_map(|map| map.values.iter().copied())
    }

    /// The scale. A pointed end says that there are values beyond it.
    fn bar(&self, drawing: &mut Drawing, [left, top]: Point, height: f64) {
        const POINT: f64 = 10.0;
        const STEPS: u32 = 256;
        let (right, middle) = (left + BAR_WIDTH, left + BAR_WIDTH / 2.0);
        let top = top + 24.0;
        let bottom = top + height - 24.0;
        drawing.text([left, top - 24.0], self.unit.as_str(), TEXT, TONE, Anchor::Start);
        let pixels = (0..STEPS).rev().map(|step| palette(f64::from(step) / f64::from(STEPS - 1))).collect();
        drawing.images.push(Image {
            corner: [left, top],
            size: [BAR_WIDTH, bottom - top],
            width: 1,
            height: STEPS,
            pixels,
        });
        let beyond = |outside: fn(f64) -> bool| self.values().filter_map(|value| self.scale.share(value)).any(outside);
        if beyond(|share| share > 1.0) {
            drawing.area(vec![[left, top], [right, top], [middle, top - POINT]], palette(1.0), 1.0);
        }
        if beyond(|share| share < 0.0) {
            drawing.area(vec![[left, bottom], [right, bottom], [middle, bottom + POINT]], palette(0.0), 1.0);
        }
        for (value, share) in self.scale.ticks() {
            let y = bottom - share * (bottom - top);
            drawing.line(vec![[right, y], [right + 5.0, y]], TONE, 1.0);
            drawing.text([right + 9.0, y], number(value), TEXT, TONE, Anchor::Start);
        }
        if self.values().any(|value| self.scale.share(value).is_none()) {
            let y = bottom + 30.0;
            drawing.rectangle([left, y - 6.0], [left + 12.0, y + 6.0], NO_VALUE);
            drawing.text([left + 18.0, y], "no value", TEXT, TONE, Anchor::Start);
        }
    }
}
