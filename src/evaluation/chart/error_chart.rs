//! Error against processor time on logarithmic scales, one panel a scene.

use super::ChartData;
use super::canvas::text_width;
use super::drawing::{Anchor, Drawing, FAINT_TONE, Point, TEXT, TONE};
use super::scale::LogScale;
use super::style::CurveStyle;
use crate::evaluation::curves::{Curve, CurvePoint};

const MOST_COLUMNS: usize = 3;
const PANEL: Point = [372.0, 268.0];
/// Space around a panel's axes: left, top, right, bottom.
const MARGINS: [f64; 4] = [62.0, 34.0, 14.0, 42.0];
const EDGE: f64 = 14.0;
const LEGEND_ROW: f64 = 20.0;

pub(super) fn draw(data: &ChartData) -> Drawing {
    let columns = data.scenes.len().clamp(1, MOST_COLUMNS);
    let rows = data.scenes.len().div_ceil(columns);
    let width = (columns as f64 * PANEL[0]).max(560.0) + 2.0 * EDGE;
    let entries = legend_entries(data, width);
    let top = 64.0 + entries.last().map_or(0.0, |(_, [_, y])| y + LEGEND_ROW);
    let mut drawing = Drawing::new(width, top + rows as f64 * PANEL[1] + EDGE);
    heading(data, &mut drawing);
    for (label, [x, y]) in &entries {
        data.style(label).entry(&mut drawing, label, [*x, 64.0 + y]);
    }
    let seconds = || data.curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.cpu_seconds));
    for (index, scene) in data.scenes.iter().enumerate() {
        let corner = [EDGE + (index % columns) as f64 * PANEL[0], top + (index / columns) as f64 * PANEL[1]];
        let right = corner[0] + PANEL[0] - MARGINS[2];
        let x = LogScale::covering(seconds(), [corner[0] + MARGINS[0], right]);
        Panel { data, scene, corner, x }.draw(&mut drawing);
    }
    drawing
}

fn heading(data: &ChartData, drawing: &mut Drawing) {
    let title = format!("{} against processor time", data.measure.title());
    drawing.text([EDGE, 20.0], title, 18.0, TONE, Anchor::Start);
    let seeds = data.curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.error.count));
    let seeds = seeds.max().unwrap_or(0);
    let mut notes = match seeds {
        0 | 1 => "One seed.".to_owned(),
        _ => format!("Median of {seeds} seeds; bands from the smallest to the largest."),
    };
    if data.curves.iter().any(|curve| curve.noise.is_some()) {
        notes += " The reference's noise is subtracted; grey: below that noise.";
    }
    if data.curves.iter().any(|curve| curve.blind.is_some()) {
        notes += " Hollow: blind to some light.";
    }
    drawing.text([EDGE, 42.0], notes, TEXT, FAINT_TONE, Anchor::Start);
}

/// Labels and where their entries begin, below the heading.
fn legend_entries(data: &ChartData, width: f64) -> Vec<(String, Point)> {
    let mut place = [EDGE, 0.0];
    let entry = |(label, _): &(String, CurveStyle)| {
        let needed = 32.0 + text_width(label, TEXT) * 1.08 + 22.0;
        if place[0] + needed > width && place[0] > EDGE {
            place = [EDGE, place[1] + LEGEND_ROW];
        }
        let at = place;
        place[0] += needed;
        (label.clone(), at)
    };
    data.styles.iter().map(entry).collect()
}

struct Panel<'a> {
    data: &'a ChartData,
    scene: &'a str,
    corner: Point,
    x: LogScale,
}

impl Panel<'_> {
    fn draw(&self, drawing: &mut Drawing) {
        let bottom = self.corner[1] + PANEL[1] - MARGINS[3];
        let y = LogScale::covering(self.errors(), [bottom, self.corner[1] + MARGINS[1]]);
        self.floor(drawing, &y);
        drawing.axes(&self.x, &y, "processor-seconds");
        drawing.text([self.x.pixels[0], y.pixels[1] - 14.0], self.scene, 14.0, TONE, Anchor::Start);
        let curves: Vec<&Curve> = self.data.of_scene(self.scene).collect();
        for curve in &curves {
            self.band(drawing, curve, &y);
        }
        for curve in &curves {
            self.curve(drawing, curve, &y);
        }
    }

    /// What the panel must show: medians, and the noise where it is near them.
    fn errors(&self) -> impl Iterator<Item = f64> {
        let medians = || {
            let points = self.data.of_scene(self.scene).flat_map(|curve| &curve.points);
            points.map(|point| point.error.median).filter(|error| *error > 0.0)
        };
        let least = medians().fold(f64::INFINITY, f64::min);
        let noise = self.data.of_scene(self.scene).filter_map(|curve| curve.noise);
        let near = noise.filter(|noise| (0.1 * least..10.0 * least).contains(noise));
        medians().chain(near).collect::<Vec<_>>().into_iter()
    }

    fn floor(&self, drawing: &mut Drawing, y: &LogScale) {
        let noise = self.data.of_scene(self.scene).filter_map(|curve| curve.noise).fold(0.0, f64::max);
        if noise > y.low {
            let [left, right] = self.x.pixels;
            drawing.rectangle([left, y.place(noise)], [right, y.pixels[0]], [240, 240, 240]);
        }
    }

    fn band(&self, drawing: &mut Drawing, curve: &Curve, y: &LogScale) {
        let shown: Vec<&CurvePoint> = curve.points.iter().filter(|point| point.error.median > 0.0).collect();
        let at = |point: &CurvePoint, error: f64| [self.x.place(point.cpu_seconds), y.place(error.max(y.low))];
        let upper = shown.iter().map(|point| at(point, point.error.high));
        let lower = shown.iter().rev().map(|point| at(point, point.error.low));
        drawing.area(upper.chain(lower).collect(), self.data.style(&curve.label).color, 0.16);
    }

    /// Medians that are not above 0 are below the noise: they have no place on the scale.
    fn curve(&self, drawing: &mut Drawing, curve: &Curve, y: &LogScale) {
        let style = self.data.style(&curve.label);
        let shown = curve.points.iter().filter(|point| point.error.median > 0.0);
        let places: Vec<Point> =
            shown.map(|point| [self.x.place(point.cpu_seconds), y.place(point.error.median)]).collect();
        style.line(drawing, places.clone());
        for place in places {
            style.point(drawing, place, curve.blind.is_some());
        }
    }
}
