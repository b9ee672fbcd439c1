//! Things that move: where they stand at a moment.
//!
//! A picture shows one moment; nothing is blurred by motion. Between two key frames places go straight, turns along the shorter arc, and sizes
//! evenly; a matrix that is more than these three (a shear) goes number by number. Before the first key frame and after the last one things stand
//! still. All of it is computed with libm: every worker must get the same bits, and the system's sine may differ.

use glam::{DMat4, DQuat};

/// How far, as a share of its largest number, a matrix may be from what its place, turn and size make again.
const CLOSE: f64 = 1e-9;
/// Below this angle, radians, the arc is as straight as its chord.
const SMALL_ANGLE: f64 = 1e-6;

/// Where something stands at a moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct KeyFrame {
    /// In the scene's own unit of time.
    pub time: f64,
    pub place: DMat4,
}

/// The moment at which a scene is read, and what was found of its motion.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    /// The moment that is shown; without one, everything stands where it begins.
    pub moment: Option<f64>,
    /// From which moment to which something moves, so far.
    pub span: Option<[f64; 2]>,
}

impl Motion {
    pub(super) fn at(moment: Option<f64>) -> Self {
        Self { moment, span: None }
    }

    /// Where something with these key frames stands, whose times rise; `None` when there are none.
    pub(super) fn place(&mut self, keys: &[KeyFrame]) -> Option<DMat4> {
        let (first, last) = (keys.first()?, keys.last()?);
        if keys.len() > 1 {
            let [start, end] = self.span.unwrap_or([first.time, last.time]);
            self.span = Some([start.min(first.time), end.max(last.time)]);
        }
        let moment = self.moment.unwrap_or(first.time);
        let next = keys.partition_point(|key| key.time <= moment);
        Some(match (next.checked_sub(1).map(|before| &keys[before]), keys.get(next)) {
            (Some(before), Some(after)) => {
                between(before.place, after.place, (moment - before.time) / (after.time - before.time))
            }
            (Some(last), None) => last.place,
            (None, _) => first.place,
        })
    }
}

/// The matrix at `share` of the way from `a` to `b`, 0 to 1.
pub(super) fn between(a: DMat4, b: DMat4, share: f64) -> DMat4 {
    if share <= 0.0 || a == b {
        return a;
    }
    if share >= 1.0 {
        return b;
    }
    let linear = || a * (1.0 - share) + b * share;
    let Some([(size_a, turn_a, place_a), (size_b, turn_b, place_b)]) =
        parts(a).zip(parts(b)).map(|(a, b)| [a, b]).filter(|[a, b]| (a.0.x < 0.0) == (b.0.x < 0.0))
    else {
        return linear();
    };
    let turn = turned(turn_a, turn_b, share);
    DMat4::from_scale_rotation_translation(size_a.lerp(size_b, share), turn, place_a.lerp(place_b, share))
}

type Parts = (glam::DVec3, DQuat, glam::DVec3);

/// Size, turn and place, if a matrix is made of them.
fn parts(matrix: DMat4) -> Option<Parts> {
    if !matrix.determinant().is_normal() {
        return None;
    }
    let (size, turn, place) = matrix.to_scale_rotation_translation();
    let again = DMat4::from_scale_rotation_translation(size, turn, place);
    let largest = matrix.to_cols_array().into_iter().fold(0.0, |most: f64, number| most.max(number.abs()));
    again.abs_diff_eq(matrix, CLOSE * largest).then_some((size, turn, place))
}

/// At `share` of the shorter arc from `a` to `b`, unit quaternions [Shoemake 1985].
pub(super) fn turned(a: DQuat, b: DQuat, share: f64) -> DQuat {
    let cosine = a.dot(b);
    let b = if cosine < 0.0 { -b } else { b };
    let angle = libm::acos(cosine.abs().min(1.0));
    let weights = if angle < SMALL_ANGLE {
        [1.0 - share, share]
    } else {
        [1.0 - share, share].map(|part| libm::sin(part * angle) / libm::sin(angle))
    };
    (a * weights[0] + b * weights[1]).normalize()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::transform;
    use super::*;

    fn key(time: f64, place: DMat4) -> KeyFrame {
        KeyFrame { time, place }
    }

    #[test]
    fn halfway_is_half_of_the_place_the_turn_and_the_size() {
        let turn = |degrees| transform::rotate([0.0, 0.0, 1.0], degrees).expect("an axis");
        let a = transform::translate([1.0, 0.0, 0.0]) * turn(10.0);
        let b = transform::translate([3.0, 2.0, 0.0]) * turn(70.0) * transform::scale([3.0; 3]);
        let expected = transform::translate([2.0, 1.0, 0.0]) * turn(40.0) * transform::scale([2.0; 3]);
        assert!(between(a, b, 0.5).abs_diff_eq(expected, 1e-12));
        assert_eq!([between(a, b, 0.0), between(a, b, 1.0)], [a, b]);
        // The shorter way, across zero.
        assert!(between(turn(350.0), turn(30.0), 0.5).abs_diff_eq(turn(10.0), 1e-9));
    }

    #[test]
    fn mirrored_and_sheared_matrices_keep_their_ends() {
        let mirrored = transform::scale([-1.0, 1.0, 1.0]);
        let sheared = DMat4::from_cols_array(&[1., 0., 0., 0., 0.5, 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.]);
        let moved = transform::translate([2.0, 0.0, 0.0]) * mirrored;
        assert!(between(mirrored, moved, 0.25).abs_diff_eq(transform::translate([0.5, 0.0, 0.0]) * mirrored, 1e-12));
        let halfway = between(DMat4::IDENTITY, sheared, 0.5).transform_point3(DVec3::Y);
        assert!(halfway.abs_diff_eq(DVec3::new(0.25, 1.0, 0.0), 1e-12));
    }

    #[test]
    fn things_stand_still_before_and_after_their_key_frames() {
        let at = |x: f64| transform::translate([x, 0.0, 0.0]);
        let keys = [key(1.0, at(0.0)), key(2.0, at(4.0)), key(4.0, at(0.0))];
        for (moment, x) in [(0.0, 0.0), (1.0, 0.0), (1.5, 2.0), (2.0, 4.0), (3.0, 2.0), (9.0, 0.0)] {
            let mut motion = Motion::at(Some(moment));
            assert_eq!(motion.place(&keys), Some(at(x)), "at {moment}");
            assert_eq!(motion.span, Some([1.0, 4.0]));
        }
        let mut still = Motion::at(None);
        assert_eq!((still.place(&keys[1..2]), still.span), (Some(at(4.0)), None));
        assert_eq!(still.place(&[]), None);
    }
}
