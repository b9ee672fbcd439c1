//! A job's own error estimate over time.

use super::drawing::{Anchor, Drawing, FAINT_TONE, Point, TEXT, TONE};
use super::scale::{LogScale, number};
use super::style;
use crate::estimate::ErrorEstimate;

const SIZE: Point = [640.0, 400.0];
/// Space around the axes: left, top, right, bottom.
const MARGINS: [f64; 4] = [76.0, 76.0, 20.0, 48.0];

/// A name and what it shows of an estimate.
type Shown = (&'static str, fn(&ErrorEstimate) -> f64);

const CURVES: [Shown; 3] =
    [("bound", |error| error.bound), ("noise", |error| error.noise), ("bias", |error| error.bias)];

/// A job's error at some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JobPoint {
    /// Wall-clock seconds since the first lease.
    pub seconds: f64,
    /// Passes merged.
    pub passes: u32,
    /// What they tell.
    pub error: ErrorEstimate,
}

/// Draws noise, bias and the bound of a job called `title`; `wanted` is the error at which it stops.
pub fn draw_job(title: &str, points: &[JobPoint], wanted: Option<f64>) -> Drawing {
    let mut drawing = Drawing::new(SIZE[0], SIZE[1]);
    drawing.text([14.0, 20.0], title, 16.0, TONE, Anchor::Start);
    let Some(last) = points.last() else {
        let nothing = "No error estimate yet: each twin needs a pass in every region.";
        drawing.text([14.0, 44.0], nothing, TEXT, FAINT_TONE, Anchor::Start);
        return drawing;
    };
    let told = format!(
        "relMSE below {} with 95 % confidence after {} passes, {:.1} s",
        number(last.error.bound),
        last.passes,
        last.seconds
    );
    drawing.text([14.0, 40.0], told, TEXT, FAINT_TONE, Anchor::Start);
    let values = points.iter().flat_map(|point| [point.error.bound, point.error.noise, point.error.bias]);
    // Estimates of bias are close to 0 by chance: those far below all else do not stretch the scale.
    let most = points.iter().map(|point| point.error.bound).fold(0.0, f64::max);
    let least = points.iter().map(|point| point.error.noise).fold(most, f64::min);
    let shown = values.chain(wanted).filter(|value| *value > 0.1 * least);
    let x = LogScale::covering(points.iter().map(|point| point.seconds), [MARGINS[0], SIZE[0] - MARGINS[2]]);
    let y = LogScale::covering(shown, [SIZE[1] - MARGINS[3], MARGINS[1]]);
    drawing.axes(&x, &y, "seconds since the first lease");
    if let Some(wanted) = wanted {
        let place = y.place(wanted);
        drawing.dashed_line(&[[x.pixels[0], place], [x.pixels[1], place]], TONE, 1.0);
        drawing.text([x.pixels[1] - 4.0, place - 9.0], "stops here", TEXT - 1.0, TONE, Anchor::End);
    }
    let styles = style::assign(CURVES.iter().map(|(label, _)| (false, (*label).to_owned())));
    let mut left = 14.0;
    for ((label, value), (_, style)) in CURVES.iter().copied().zip(styles) {
        let places: Vec<Point> = points
            .iter()
            .filter(|point| value(&point.error) >= y.low)
            .map(|point| [x.place(point.seconds), y.place(value(&point.error))])
            .collect();
        if places.is_empty() {
            continue;
        }
        style.entry(&mut drawing, label, [left, 60.0]);
        left += 90.0;
        style.line(&mut drawing, places.clone());
        places.into_iter().for_each(|place| style.point(&mut drawing, place, false));
    }
    drawing
}
