//! How curves are told apart: by colors that color-blind people see as different too, and by the shape of their points.

use super::drawing::{Anchor, Color, Drawing, Point, TEXT, TONE, WHITE};

/// The scheme "muted" of Paul Tol (2021, "Colour schemes", SRON/EPS/TN/09-002), in an order that keeps neighbors apart.
const PALETTE: [Color; 9] = [
    [51, 34, 136],
    [204, 102, 119],
    [68, 170, 153],
    [136, 34, 85],
    [153, 153, 51],
    [17, 119, 51],
    [136, 204, 238],
    [170, 68, 153],
    [221, 204, 119],
];
/// Other programs are black and grey, and dashed.
const PEER_PALETTE: [Color; 3] = [[0, 0, 0], [120, 120, 120], [70, 70, 70]];

/// Points have one of these forms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Form {
    #[default]
    Circle,
    Square,
    Triangle,
    Diamond,
}

const FORMS: [Form; 4] = [Form::Circle, Form::Square, Form::Triangle, Form::Diamond];

/// Color and form of a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct CurveStyle {
    pub(super) color: Color,
    pub(super) peer: bool,
    form: Form,
}

/// Styles for labels that are peers or not. Our own get the first places, each group in its order.
pub(super) fn assign(labels: impl Iterator<Item = (bool, String)>) -> Vec<(String, CurveStyle)> {
    let (peers, own): (Vec<_>, Vec<_>) = labels.partition(|(peer, _)| *peer);
    let style = |peer: bool, index: usize| {
        let palette: &[Color] = if peer { &PEER_PALETTE } else { &PALETTE };
        CurveStyle { color: palette[index % palette.len()], peer, form: FORMS[index % FORMS.len()] }
    };
    let styled = |labels: Vec<(bool, String)>| {
        labels.into_iter().enumerate().map(move |(index, (peer, label))| (label, style(peer, index)))
    };
    styled(own).chain(styled(peers)).collect()
}

impl CurveStyle {
    /// A point of this style, hollow for methods that are blind to some light.
    pub(super) fn point(self, drawing: &mut Drawing, [x, y]: Point, hollow: bool) {
        let outline = |radius: f64| -> Vec<Point> {
            let corners: &[Point] = match self.form {
                Form::Circle => &[],
                Form::Square => &[[-0.85, -0.85], [0.85, -0.85], [0.85, 0.85], [-0.85, 0.85]],
                Form::Triangle => &[[0.0, -1.15], [1.05, 0.75], [-1.05, 0.75]],
                Form::Diamond => &[[0.0, -1.2], [1.2, 0.0], [0.0, 1.2], [-1.2, 0.0]],
            };
            let circle = (0..24).map(|step| {
                let (sin, cos) = (f64::from(step) * std::f64::consts::TAU / 24.0).sin_cos();
                [cos, sin]
            });
            let shape: Vec<Point> = if corners.is_empty() { circle.collect() } else { corners.to_vec() };
            shape.into_iter().map(|[dx, dy]| [x + radius * dx, y + radius * dy]).collect()
        };
        const RADIUS: f64 = 3.6;
        drawing.area(outline(RADIUS + 1.2), WHITE, 1.0);
        drawing.area(outline(RADIUS), self.color, 1.0);
        if hollow {
            drawing.area(outline(RADIUS - 1.5), WHITE, 1.0);
        }
    }

    /// A legend's entry: a piece of line with a point, and the label. `place` is its left end, middle height.
    pub(super) fn entry(self, drawing: &mut Drawing, label: &str, [left, middle]: Point) {
        self.line(drawing, vec![[left, middle], [left + 26.0, middle]]);
        self.point(drawing, [left + 13.0, middle], false);
        drawing.text([left + 32.0, middle], label, TEXT, TONE, Anchor::Start);
    }

    /// A line of this style.
    pub(super) fn line(self, drawing: &mut Drawing, points: Vec<Point>) {
        const WIDTH: f64 = 1.75;
        if self.peer {
            drawing.dashed_line(&points, self.color, WIDTH)
        } else {
            drawing.line(points, self.color, WIDTH)
        }
    }
}
