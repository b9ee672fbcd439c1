//! Processor time until an error is reached: one row a scene, one line in it for each method.

use super::ChartData;
use super::drawing::{Anchor, Drawing, FAINT_INK, GRID, INK};
use super::scale::{LogScale, number};
use crate::evaluation::curves::{Curve, Reached};

const WIDTH: f64 = 1000.0;
const LEFT: f64 = 170.0;
const RIGHT: f64 = 880.0;
/// Where the points of those lie that do not reach the error.
const NEVER: f64 = 926.0;
const TOP: f64 = 84.0;
const LINE: f64 = 15.0;
const TEXT: f64 = 12.0;
const SMALL: f64 = 11.0;

pub(super) fn draw(data: &ChartData) -> Drawing {
    let lines = |scene: &String| data.of_scene(scene).count() as f64 * LINE + 12.0;
    let height: f64 = data.scenes.iter().map(lines).sum();
    let mut drawing = Drawing::new(WIDTH, TOP + height + 46.0);
    let title = format!("Processor time until {} is {}", data.measure.title(), number(data.target));
    drawing.text([14.0, 20.0], title, 18.0, INK, Anchor::Start);
    let note = "Interpolated between time budgets. The bar ends where the error is reached; an arrow: before the first budget already. \
                Right: not within the time given.";
    drawing.text([14.0, 42.0], note, TEXT, FAINT_INK, Anchor::Start);
    let x = scale(data);
    axis(&mut drawing, &x, TOP + height);
    let mut top = TOP;
    for (index, scene) in data.scenes.iter().enumerate() {
        let bottom = top + lines(scene);
        if index > 0 {
            drawing.line(vec![[14.0, top], [WIDTH - 14.0, top]], FAINT_INK, 0.75);
        }
        drawing.text([14.0, top + 6.0 + LINE / 2.0], scene.as_str(), 13.0, INK, Anchor::Start);
        for (line, curve) in in_order(data, scene).into_iter().enumerate() {
            bar(data, &mut drawing, curve, &x, top + 6.0 + (line as f64 + 0.5) * LINE);
        }
        top = bottom;
    }
    drawing
}

fn scale(data: &ChartData) -> LogScale {
    let times = data.curves.iter().flat_map(|curve| {
        let budgets = curve.points.iter().map(|point| point.cpu_seconds);
        budgets.collect::<Vec<_>>()
    });
    LogScale::covering(times, [LEFT, RIGHT])
}

/// Fastest first; those that do not reach the error at the end.
fn in_order<'a>(data: &'a ChartData, scene: &'a str) -> Vec<&'a Curve> {
    let seconds = |curve: &Curve| match curve.reaches(data.target) {
        Some(Reached::Before(seconds) | Reached::At(seconds)) => seconds,
        Some(Reached::NotBy(_)) | None => f64::INFINITY,
    };
    let mut curves: Vec<&Curve> = data.of_scene(scene).collect();
    curves.sort_by(|a, b| seconds(a).total_cmp(&seconds(b)));
    curves
}

fn axis(drawing: &mut Drawing, x: &LogScale, bottom: f64) {
    for value in x.ticks() {
        let place = x.place(value);
        drawing.line(vec![[place, TOP], [place, bottom]], GRID, 0.75);
        for y in [TOP - 10.0, bottom + 12.0] {
            drawing.text([place, y], number(value), SMALL, FAINT_INK, Anchor::Middle);
        }
    }
    drawing.text([RIGHT, bottom + 30.0], "processor-seconds", SMALL, FAINT_INK, Anchor::End);
    drawing.text([NEVER, TOP - 10.0], "not reached", SMALL, FAINT_INK, Anchor::Middle);
}

fn bar(data: &ChartData, drawing: &mut Drawing, curve: &Curve, x: &LogScale, y: f64) {
    let style = data.style(&curve.label);
    let hollow = curve.blind.is_some();
    let (place, text) = match curve.reaches(data.target) {
        Some(Reached::At(seconds)) => (x.place(seconds), format!("{} {}", curve.label, number(seconds))),
        Some(Reached::Before(seconds)) => (x.place(seconds), format!("{} < {}", curve.label, number(seconds))),
        Some(Reached::NotBy(_)) | None => {
            style.point(drawing, [NEVER, y], hollow);
            drawing.text([NEVER - 12.0, y], curve.label.as_str(), SMALL, INK, Anchor::End);
            return;
        }
    };
    style.line(drawing, vec![[LEFT, y], [place, y]]);
    if let Some(Reached::Before(_)) = curve.reaches(data.target) {
        drawing.area(vec![[LEFT - 7.0, y], [LEFT, y - 4.0], [LEFT, y + 4.0]], style.color, 1.0);
    }
    style.point(drawing, [place, y], hollow);
    // Near the right end there is room on the left only.
    if place < RIGHT - 190.0 {
        drawing.text([place + 9.0, y], text, SMALL, INK, Anchor::Start);
    } else {
        drawing.text([LEFT - 10.0, y], text, SMALL, INK, Anchor::End);
    }
}
