//! `linearcurve` and `bsplinecurve`: curves with a radius, such as hair and wire, as tubes of triangles.
//!
//! `filename` holds a control point on each line, x y z and the radius in m; empty lines separate curves. A `linearcurve` goes through
//! its points (at least two) and has round ends and joints; a `bsplinecurve` is a uniform cubic B-spline (at least four points, which
//! pull it), and open at its ends. Rays meet both from outside only, as in Mitsuba: who looks into a tube sees through its walls.
//! `to_world` (any affine transform) moves the points and leaves radii as they are, as in Mitsuba.
//!
//! A tube has [`SIDES`] sides and smooth normals; its corners lie so far outside of the circle that it is as wide as the circle in
//! the mean over all directions. v grows along all curves of the file from 0 to 1, u round each.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::mesh::{self, ShapeGeometry};
use super::transform::ToWorld;
use super::triangle_mesh::TriangleMesh;
use crate::scene::bundle::{Bundle, text_of};
use crate::scene::error::{Location, SceneError, shown_number};
use crate::scene::fields::Fields;

/// Corners of a tube's cross section.
const SIDES: u32 = 24;
/// Rings of a tube for each segment of a B-spline.
const STEPS: u32 = 8;
/// Rings of a ball between its poles.
const BALL_RINGS: u32 = 11;
/// The most triangles that the curves of a file may become.
const MOST_TRIANGLES: u64 = 16_000_000;

/// A place on a curve.
#[derive(Clone, Copy)]
struct Point {
    position: DVec3,
    radius: f64,
}

/// Reads a `linearcurve`.
pub(crate) fn read_linear(fields: &mut Fields<'_>, bundle: &Bundle) -> Result<ShapeGeometry, SceneError> {
    let curves = read_curves(fields, bundle, 2)?;
    let points: usize = curves.iter().map(Vec::len).sum();
    let segments = points - curves.len();
    let ball = 2 * u64::from(SIDES) * u64::from(BALL_RINGS);
    check_size(fields, 2 * u64::from(SIDES) * segments as u64 + ball * points as u64)?;
    let mut tubes = Tubes::new(segments);
    for curve in &curves {
        for ends in curve.windows(2) {
            let along = (ends[1].position - ends[0].position).normalize_or_zero();
            tubes.start();
            for (end, step) in ends.iter().zip([0.0, 1.0]) {
                tubes.ring(*end, along, tubes.done + step);
            }
            tubes.done += 1.0;
        }
        curve.iter().for_each(|point| tubes.ball(*point));
    }
    tubes.into_shape(fields)
}

/// Reads a `bsplinecurve`.
pub(crate) fn read_spline(fields: &mut Fields<'_>, bundle: &Bundle) -> Result<ShapeGeometry, SceneError> {
    let curves = read_curves(fields, bundle, 4)?;
    let segments: usize = curves.iter().map(|curve| curve.len() - 3).sum();
    check_size(fields, 2 * u64::from(SIDES) * u64::from(STEPS) * segments as u64)?;
    let mut tubes = Tubes::new(segments);
    for curve in &curves {
        tubes.start();
        for (segment, points) in curve.windows(4).enumerate() {
            // The first ring of a segment is the last of the one before.
            for step in u32::from(segment > 0)..=STEPS {
                let t = f64::from(step) / f64::from(STEPS);
                let (point, along) = on_spline(points, t);
                tubes.ring(point, along, tubes.done + t);
            }
            tubes.done += 1.0;
        }
    }
    tubes.into_shape(fields)
}

/// The point of a segment of a uniform cubic B-spline, and the unit direction there.
fn on_spline(points: &[Point], t: f64) -> (Point, DVec3) {
    let (s, squared, cubed) = (1.0 - t, t * t, t * t * t);
    let weights = [s * s * s, 3.0 * cubed - 6.0 * squared + 4.0, -3.0 * cubed + 3.0 * squared + 3.0 * t + 1.0, cubed]
        .map(|weight| weight / 6.0);
    let slopes = [-s * s, 3.0 * squared - 4.0 * t, -3.0 * squared + 2.0 * t + 1.0, squared];
    let position = points.iter().zip(weights).map(|(point, weight)| point.position * weight).sum();
    let radius = points.iter().zip(weights).map(|(point, weight)| point.radius * weight).sum();
    let along: DVec3 = points.iter().zip(slopes).map(|(point, slope)| point.position * slope).sum();
    (Point { position, radius }, along.normalize_or_zero())
}

fn check_size(fields: &mut Fields<'_>, triangles: u64) -> Result<(), SceneError> {
    if triangles <= MOST_TRIANGLES {
        return Ok(());
    }
    let problem = format!("the curves would become {triangles} triangles, and {MOST_TRIANGLES} are the most");
    Err(fields.error("filename", problem, "take fewer curves, or fewer points for each"))
}

/// The curves of the file, each with at least `least` points.
fn read_curves(fields: &mut Fields<'_>, bundle: &Bundle, least: usize) -> Result<Vec<Vec<Point>>, SceneError> {
    let (bytes, location) = mesh::mesh_file(fields, bundle)?;
    let to_world = ToWorld::read(fields)?;
    let text = text_of(&bytes);
    let mut curves: Vec<Vec<Point>> = vec![Vec::new()];
    let error = |line: usize, problem: String| {
        SceneError::new(
            &Location { line: line as u32 + 1, ..location.clone() },
            problem,
            "write x y z radius on each line",
        )
    };
    let mut last = 0;
    for (line, text) in text.lines().enumerate().chain([(usize::MAX, "")]) {
        let words: Vec<&str> = text.split_whitespace().collect();
        if words.is_empty() {
            let points = curves.last().map_or(0, Vec::len);
            if (1..least).contains(&points) {
                return Err(error(
                    last,
                    format!("the curve that ends here has {points} points, and {least} are the fewest"),
                ));
            }
            if points > 0 {
                curves.push(Vec::new());
            }
            continue;
        }
        last = line;
        let numbers: Vec<f64> =
            words.iter().filter_map(|word| word.parse().ok()).filter(|number: &f64| number.is_finite()).collect();
        let [x, y, z, radius] = numbers[..] else {
            let shown: String = text.trim().chars().take(60).collect();
            return Err(error(line, format!("{shown:?} is not a control point")));
        };
        if words.len() != 4 || radius < 0.0 {
            return Err(error(
                line,
                format!("the control point has {} numbers and the radius {}", words.len(), shown_number(radius)),
            ));
        }
        curves
            .last_mut()
            .into_iter()
            .for_each(|curve| curve.push(Point { position: to_world.point(DVec3::new(x, y, z)), radius }));
    }
    curves.pop();
    match curves.is_empty() {
        false => Ok(curves),
        true => Err(SceneError::new(&location, "the file holds no curves", "write x y z radius on each line")),
    }
}

/// The mesh of all tubes.
struct Tubes {
    mesh: TriangleMesh,
    /// Segments of all curves.
    segments: f64,
    /// Segments so far.
    done: f64,
    /// The last ring of the current tube: where its first vertex lies, and what.
    last: Option<(DVec3, Point)>,
}

impl Tubes {
    fn new(segments: usize) -> Self {
        Self { mesh: TriangleMesh::default(), segments: segments as f64, done: 0.0, last: None }
    }

    /// What comes next belongs to no earlier ring.
    fn start(&mut self) {
        self.last = None;
    }

    fn push(&mut self, position: DVec3, normal: DVec3, uv: [f64; 2]) {
        self.mesh.positions.push(position.as_vec3().to_array());
        self.mesh.normals.push(normal.as_vec3().to_array());
        self.mesh.texture_coordinates.push(uv.map(|coordinate| coordinate as f32));
    }

    /// Adds a ring round a point across `along`, joined to the last one; `segment` says how far along all curves it is.
    fn ring(&mut self, point: Point, along: DVec3, segment: f64) {
        // The corner of the last ring is carried along without turning round the curve.
        let before = self.last.map_or(DVec3::ZERO, |(corner, _)| corner);
        let corner = (before - along * before.dot(along)).try_normalize();
        let corner =
            corner.unwrap_or_else(|| if along == DVec3::ZERO { DVec3::X } else { along.any_orthonormal_vector() });
        let across = along.cross(corner);
        // Where the tube gets wider its normals lean back.
        let lean = self.last.map_or(0.0, |(_, last)| {
            let length = point.position.distance(last.position);
            if length > 0.0 { (last.radius - point.radius) / length } else { 0.0 }
        });
        let wider = PI / f64::from(SIDES) / libm::sin(PI / f64::from(SIDES));
        let first = self.mesh.positions.len() as u32;
        for side in 0..=SIDES {
            let turn = f64::from(side % SIDES) / f64::from(SIDES) * TAU;
            let outwards = corner * libm::cos(turn) + across * libm::sin(turn);
            let uv = [f64::from(side) / f64::from(SIDES), segment / self.segments];
            self.push(point.position + outwards * (point.radius * wider), (outwards + along * lean).normalize(), uv);
        }
        if self.last.is_some() {
            self.join(first - SIDES - 1, first);
        }
        self.last = Some((corner, point));
    }

    /// Triangles between two rings, whose outside is away from the curve.
    fn join(&mut self, first: u32, second: u32) {
        for side in 0..SIDES {
            let [a, b, c, d] = [first + side, first + side + 1, second + side + 1, second + side];
            self.mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }

    /// A ball round a point.
    fn ball(&mut self, point: Point) {
        let wider = PI / f64::from(SIDES) / libm::sin(PI / f64::from(SIDES));
        let start = self.mesh.positions.len() as u32;
        let v = self.done / self.segments;
        for ring in 0..=BALL_RINGS + 1 {
            let polar = PI * f64::from(ring) / f64::from(BALL_RINGS + 1);
            for side in 0..=SIDES {
                let turn = f64::from(side % SIDES) / f64::from(SIDES) * TAU;
                let [sine, cosine] = [libm::sin(polar), libm::cos(polar)];
                let outwards = DVec3::new(sine * libm::cos(turn), sine * libm::sin(turn), -cosine);
                self.push(
                    point.position + outwards * (point.radius * wider),
                    outwards,
                    [f64::from(side) / f64::from(SIDES), v],
                );
            }
        }
        let row = SIDES + 1;
        for ring in 0..=BALL_RINGS {
            let (below, above) = (start + ring * row, start + (ring + 1) * row);
            for side in 0..SIDES {
                let [a, b, c, d] = [below + side, below + side + 1, above + side + 1, above + side];
                // At the poles one of the two has no area.
                if ring > 0 {
                    self.mesh.triangles.push([a, b, c]);
                }
                if ring < BALL_RINGS {
                    self.mesh.triangles.push([a, c, d]);
                }
            }
        }
    }

    fn into_shape(self, fields: &mut Fields<'_>) -> Result<ShapeGeometry, SceneError> {
        let mut shape = mesh::one_sided(self.mesh, fields)?;
        shape.notices.push(format!("its curves are approximated by tubes with {SIDES} sides"));
        Ok(shape)
    }
}
