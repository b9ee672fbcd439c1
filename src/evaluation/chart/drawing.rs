//! A chart as a list of marks, in pixels from the top left corner.

/// Red, green and blue, sRGB.
pub(super) type Color = [u8; 3];
/// A place, pixels.
pub(super) type Point = [f64; 2];

pub(super) const TONE: Color = [34, 34, 34];
pub(super) const FAINT_TONE: Color = [105, 105, 105];
pub(super) const GRID: Color = [228, 228, 228];
pub(super) const WHITE: Color = [255, 255, 255];

/// Height of the letters of notes and legends.
pub(super) const TEXT: f64 = 12.0;

/// Where a text's place lies in it. Vertically it is the middle of small letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

#[derive(Clone, Debug)]
pub(super) enum Mark {
    Line { points: Vec<Point>, color: Color, width: f64 },
    Area { points: Vec<Point>, color: Color, opacity: f64 },
    Text { at: Point, text: String, size: f64, color: Color, anchor: Anchor },
}

/// A picture, stretched from a corner by hard-edged pixels.
#[derive(Clone, Debug)]
pub(super) struct Image {
    pub(super) corner: Point,
    pub(super) size: Point,
    /// Pixels of the picture itself.
    pub(super) width: u32,
    pub(super) height: u32,
    /// Row-major, top row first.
    pub(super) pixels: Vec<Color>,
}

/// A drawing on white ground.
#[derive(Clone, Debug)]
pub struct Drawing {
    pub(super) width: f64,
    pub(super) height: f64,
    /// All lie under the marks.
    pub(super) images: Vec<Image>,
    /// Later ones cover earlier ones.
    pub(super) marks: Vec<Mark>,
}

impl Drawing {
    pub(super) fn new(width: f64, height: f64) -> Self {
        Self { width, height, images: Vec::new(), marks: Vec::new() }
    }

    pub(super) fn line(&mut self, points: Vec<Point>, color: Color, width: f64) {
        if points.len() > 1 {
            self.marks.push(Mark::Line { points, color, width });
        }
    }

    /// A line with gaps.
    pub(super) fn dashed_line(&mut self, points: &[Point], color: Color, width: f64) {
        const DASH: f64 = 6.0;
        const GAP: f64 = 4.0;
        let mut travelled = 0.0;
        for pair in points.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let length = libm::hypot(to[0] - from[0], to[1] - from[1]);
            let at = |distance: f64| [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * distance / length);
            let mut start = -(travelled % (DASH + GAP));
            while start < length {
                let (first, last) = (start.max(0.0), (start + DASH).min(length));
                if last > first {
                    self.line(vec![at(first), at(last)], color, width);
                }
                start += DASH + GAP;
            }
            travelled += length;
        }
    }

    pub(super) fn area(&mut self, points: Vec<Point>, color: Color, opacity: f64) {
        if points.len() > 2 {
            self.marks.push(Mark::Area { points, color, opacity });
        }
    }

    pub(super) fn rectangle(&mut self, [left, top]: Point, [right, bottom]: Point, color: Color) {
        self.area(vec![[left, top], [right, top], [right, bottom], [left, bottom]], color, 1.0);
    }

    pub(super) fn text(&mut self, at: Point, text: impl Into<String>, size: f64, color: Color, anchor: Anchor) {
        let text = text.into();
        if !text.is_empty() {
            self.marks.push(Mark::Text { at, text, size, color, anchor });
        }
    }
}
