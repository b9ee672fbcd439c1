//! Which method is best on each scene, and how much worse the others are.

use super::ChartData;
use super::canvas::text_width;
use super::drawing::{Anchor, Color, Drawing, FAINT_TONE, TEXT, TONE, WHITE};
use super::scale::number;
use crate::evaluation::curves::{Curve, common_budget};

const CELL: [f64; 2] = [88.0, 30.0];
const TOP: f64 = 102.0;
const EDGE: f64 = 14.0;
/// From the best to [`WORST`] times its error: blue to nearly white, darker is better; seen alike by color-blind people.
const SHADES: [Color; 5] = [[8, 64, 129], [43, 140, 190], [123, 190, 215], [190, 222, 235], [244, 248, 250]];
const WORST: f64 = 10.0;

pub(super) fn draw(data: &ChartData) -> Drawing {
    let left = EDGE + 14.0 + data.scenes.iter().map(|scene| text_width(scene, 13.0)).fold(60.0, f64::max) * 1.08;
    let columns = data.styles.len();
    let width = (left + columns as f64 * CELL[0] + EDGE).max(620.0);
    let mut drawing = Drawing::new(width, TOP + data.scenes.len() as f64 * CELL[1] + 16.0);
    let title = format!("{} as a multiple of the best method's", data.measure.title());
    drawing.text([EDGE, 20.0], title, 18.0, TONE, Anchor::Start);
    let note =
        "After the same processor time, which stands below the scene's name. ° blind to some light; – no result.";
    drawing.text([EDGE, 42.0], note, TEXT, FAINT_TONE, Anchor::Start);
    for (column, (label, _)) in data.styles.iter().enumerate() {
        let middle = left + (column as f64 + 0.5) * CELL[0];
        let lines = broken(label);
        for (line, text) in lines.iter().enumerate() {
            let y = TOP - 12.0 - (lines.len() - 1 - line) as f64 * 13.0;
            drawing.text([middle, y], text.as_str(), TEXT, TONE, Anchor::Middle);
        }
    }
    for (row, scene) in data.scenes.iter().enumerate() {
        draw_row(data, &mut drawing, scene, [left, TOP + row as f64 * CELL[1]]);
    }
    drawing
}

/// A label in lines that fit over a column.
fn broken(label: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in label.split_inclusive([' ', ':']) {
        match lines.last_mut() {
            Some(line) if text_width(&format!("{line}{word}"), TEXT) < CELL[0] - 4.0 => line.push_str(word),
            _ => lines.push(word.to_owned()),
        }
    }
    lines.into_iter().map(|line| line.trim().to_owned()).collect()
}

fn draw_row(data: &ChartData, drawing: &mut Drawing, scene: &str, [left, top]: [f64; 2]) {
    let middle = top + CELL[1] / 2.0;
    let Some(budget) = common_budget(&data.curves, scene) else {
        drawing.text([EDGE, middle], scene, 13.0, TONE, Anchor::Start);
        return;
    };
    drawing.text([EDGE, middle - 6.0], scene, 13.0, TONE, Anchor::Start);
    drawing.text([EDGE, middle + 8.0], format!("{} s", number(budget)), 10.0, FAINT_TONE, Anchor::Start);
    let error = |curve: &Curve| curve.at(budget).map(|point| point.error.median).filter(|error| *error > 0.0);
    let best = data.of_scene(scene).filter_map(error).fold(f64::INFINITY, f64::min);
    for (column, (label, _)) in data.styles.iter().enumerate() {
        let corner = [left + column as f64 * CELL[0], top];
        let center = [corner[0] + CELL[0] / 2.0, middle];
        let curve = data.curve(scene, label);
        let Some(ratio) = curve.and_then(error).map(|error| error / best) else {
            drawing.text(center, "–", TEXT, FAINT_TONE, Anchor::Middle);
            continue;
        };
        let color = shade(ratio);
        drawing.rectangle([corner[0] + 1.0, top + 1.0], [corner[0] + CELL[0] - 1.0, top + CELL[1] - 1.0], color);
        let blind = if curve.is_some_and(|curve| curve.blind.is_some()) { " °" } else { "" };
        let digits = usize::from(ratio < 9.95);
        let tone = if f64::from(color[1]) < 150.0 { WHITE } else { TONE };
        drawing.text(center, format!("{ratio:.digits$}{blind}"), TEXT + 1.0, tone, Anchor::Middle);
    }
}

fn shade(ratio: f64) -> Color {
    let place = (ratio.ln() / WORST.ln()).clamp(0.0, 1.0) * (SHADES.len() - 1) as f64;
    let index = (place as usize).min(SHADES.len() - 2);
    let share = place - index as f64;
    let mix = |channel: usize| {
        let (a, b) = (f64::from(SHADES[index][channel]), f64::from(SHADES[index + 1][channel]));
        (a + share * (b - a)).round() as u8
    };
    [0, 1, 2].map(mix)
}
