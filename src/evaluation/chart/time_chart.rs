//! Processor time until an error is reached: one block a scene, one bar in it for each method.

use super::ChartData;
use super::canvas::text_width;
use super::drawing::{Anchor, Drawing, FAINT_TONE, GRID, TEXT, TONE, WHITE};
use super::scale::{LogScale, number};
use crate::evaluation::curves::{Curve, Reached};

const WIDTH: f64 = 1000.0;
const EDGE: f64 = 14.0;
const LEFT: f64 = 170.0;
const RIGHT: f64 = 800.0;
const TOP: f64 = 84.0;
const LINE: f64 = 15.0;
/// Space above and below a scene's lines.
const PADDING: f64 = 7.0;
const SMALL: f64 = 11.0;

pub(super) fn draw(data: &ChartData) -> Drawing {
    let blocks: Vec<Block> = data.scenes.iter().map(|scene| Block::new(data, scene)).collect();
    let height: f64 = blocks.iter().map(Block::height).sum();
    let mut drawing = Drawing::new(WIDTH, TOP + height + 46.0);
    let title = format!("Processor time until {} is {}", data.measure.title(), number(data.target));
    drawing.text([EDGE, 20.0], title, 18.0, TONE, Anchor::Start);
    let note = "Interpolated between time budgets, medians over seeds. An arrow: before the first budget already. \
                Hollow: blind to some light.";
    drawing.text([EDGE, 42.0], note, TEXT, FAINT_TONE, Anchor::Start);
    let seconds = data.curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.cpu_seconds));
    let x = LogScale::covering(seconds, [LEFT, RIGHT]);
    axis(&mut drawing, &x, TOP + height);
    let mut top = TOP;
    for block in &blocks {
        if top > TOP {
            drawing.line(vec![[EDGE, top], [WIDTH - EDGE, top]], FAINT_TONE, 0.5);
        }
        block.draw(&mut drawing, &x, top);
        top += block.height();
    }
    drawing
}

fn axis(drawing: &mut Drawing, x: &LogScale, bottom: f64) {
    for value in x.ticks() {
        let place = x.place(value);
        drawing.line(vec![[place, TOP], [place, bottom]], GRID, 0.75);
        for y in [TOP - 10.0, bottom + 12.0] {
            drawing.text([place, y], number(value), SMALL, FAINT_TONE, Anchor::Middle);
        }
    }
    drawing.text([RIGHT, bottom + 30.0], "processor-seconds", SMALL, FAINT_TONE, Anchor::End);
}

/// A scene: those that reach the error, fastest first, and the others in lines below.
struct Block<'a> {
    data: &'a ChartData,
    scene: &'a str,
    reached: Vec<(&'a Curve, f64, bool)>,
    others: Vec<Vec<&'a Curve>>,
}

impl<'a> Block<'a> {
    fn new(data: &'a ChartData, scene: &'a str) -> Self {
        let (mut reached, mut others) = (Vec::new(), Vec::new());
        for curve in data.of_scene(scene) {
            match curve.reaches(data.target) {
                Some(Reached::Before(seconds)) => reached.push((curve, seconds, true)),
                Some(Reached::At(seconds)) => reached.push((curve, seconds, false)),
                Some(Reached::NotBy(_)) | None => others.push(curve),
            }
        }
        reached.sort_by(|a, b| a.1.total_cmp(&b.1));
        Self { data, scene, reached, others: wrapped(others) }
    }

    fn height(&self) -> f64 {
        (self.reached.len() + self.others.len()).max(1) as f64 * LINE + 2.0 * PADDING
    }

    fn draw(&self, drawing: &mut Drawing, x: &LogScale, top: f64) {
        let middle = |line: usize| top + PADDING + (line as f64 + 0.5) * LINE;
        drawing.text([EDGE, middle(0)], self.scene, 13.0, TONE, Anchor::Start);
        for (line, (curve, seconds, before)) in self.reached.iter().enumerate() {
            self.bar(drawing, curve, x.place(*seconds), middle(line));
            let sign = if *before { "< " } else { "" };
            let text = format!("{} {sign}{}", curve.label, number(*seconds));
            label(drawing, &text, x.place(*seconds), middle(line));
            if *before {
                let (y, color) = (middle(line), self.data.style(&curve.label).color);
                drawing.area(vec![[LEFT - 7.0, y], [LEFT, y - 4.0], [LEFT, y + 4.0]], color, 1.0);
            }
        }
        for (index, line) in self.others.iter().enumerate() {
            self.other_line(drawing, line, middle(self.reached.len() + index), index == 0);
        }
    }

    fn bar(&self, drawing: &mut Drawing, curve: &Curve, end: f64, y: f64) {
        let style = self.data.style(&curve.label);
        style.line(drawing, vec![[LEFT, y], [end, y]]);
        style.point(drawing, [end, y], curve.blind.is_some());
    }

    fn other_line(&self, drawing: &mut Drawing, curves: &[&Curve], y: f64, first: bool) {
        let [begin, end] = [LEFT, WIDTH - EDGE];
        drawing.rectangle([begin, y - LINE / 2.0], [end, y + LINE / 2.0], WHITE);
        if first {
            drawing.text([begin, y], NOT_REACHED, SMALL, FAINT_TONE, Anchor::Start);
        }
        let mut x = begin + text_width(NOT_REACHED, SMALL) * 1.1 + 14.0;
        for curve in curves {
            self.data.style(&curve.label).point(drawing, [x, y], curve.blind.is_some());
            drawing.text([x + 8.0, y], curve.label.as_str(), SMALL, FAINT_TONE, Anchor::Start);
            x += entry_width(curve);
        }
    }
}

const NOT_REACHED: &str = "not reached:";

fn entry_width(curve: &Curve) -> f64 {
    8.0 + text_width(&curve.label, SMALL) * 1.1 + 16.0
}

/// As many to a line as fit.
fn wrapped(curves: Vec<&Curve>) -> Vec<Vec<&Curve>> {
    let most = WIDTH - EDGE - LEFT - text_width(NOT_REACHED, SMALL) * 1.1 - 14.0;
    let mut lines: Vec<Vec<&Curve>> = Vec::new();
    let mut used = 0.0;
    for curve in curves {
        used += entry_width(curve);
        match lines.last_mut() {
            Some(line) if used <= most => line.push(curve),
            _ => {
                used = entry_width(curve);
                lines.push(vec![curve]);
            }
        }
    }
    lines
}

/// Right of a bar's end, or on the bar where there is no room.
fn label(drawing: &mut Drawing, text: &str, end: f64, y: f64) {
    const GAP: f64 = 9.0;
    let width = text_width(text, SMALL) * 1.1;
    if end + GAP + width < WIDTH - EDGE {
        drawing.text([end + GAP, y], text, SMALL, TONE, Anchor::Start);
        return;
    }
    drawing.rectangle([end - GAP - width - 3.0, y - 6.0], [end - GAP + 3.0, y + 6.0], WHITE);
    drawing.text([end - GAP, y], text, SMALL, TONE, Anchor::End);
}
