//! Paths that a user gives: hints where light comes from, each a list of points from a lamp to a surface that is not a mirror [Fan et al. 2005, section 5].

use super::light_end::LightEnd;
use super::lobe_choice::LobeChoice;
use crate::math::Vec3;
use crate::scene::Scene;
use crate::scene::geometry::{Interaction, Ray};
use crate::scene::material::{Lobes, TransportMode, View};

/// Points may lie beside their surfaces by this share of the scene's radius.
const TOLERANCE: f32 = 0.01;
/// The path behind a mirror or glass may turn from where it leads by so much, as a cosine: 15°.
const FOLLOWS: f32 = 0.966;

/// A path as it was given.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenPath<'a> {
    /// At least two, m, from the lamp on.
    pub points: &'a [[f32; 3]],
    /// The half angle of the cone around each segment, radians.
    pub cones: Vec<f32>,
}

/// A path that was checked.
#[derive(Clone, Debug)]
pub struct UserPath {
    /// Index of the lamp.
    pub light: u32,
    /// All but the lamp.
    pub points: Vec<UserPoint>,
}

/// A surface point of such a path.
#[derive(Clone, Copy, Debug)]
pub struct UserPoint {
    /// m.
    pub position: Vec3,
    /// One minus the cosine of the half angle of the cone around the segment that leads here.
    pub one_minus_cosine: f32,
    /// Whether the path follows a mirror or glass here.
    pub is_specular: bool,
}

/// Why a path cannot be taken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum UserPathError {
    /// The first point.
    #[error("it starts at no lamp; the nearest is at {nearest}")]
    NoLamp {
        /// Where the nearest lamp is.
        nearest: Vec3,
    },
    /// No lamp of the scene has a place.
    #[error("no lamp of the scene has a place that it could start at")]
    NoPlaces,
    /// A segment meets something else first.
    #[error("segment {segment} passes a surface at {at}")]
    Blocked {
        /// From 1.
        segment: usize,
        /// Where it is.
        at: Vec3,
    },
    /// A segment ends in the air.
    #[error("segment {segment} hits nothing at its end; {}", beyond(.surface))]
    HitsNothing {
        /// From 1.
        segment: usize,
        /// The next surface in its direction.
        surface: Option<Vec3>,
    },
    /// The segment behind a mirror or glass goes elsewhere.
    #[error("segment {segment} does not go where the mirror or glass before it leads")]
    LeavesMirror {
        /// From 1.
        segment: usize,
    },
    /// The end.
    #[error("it ends at a mirror or glass, which reflects no light to other directions")]
    EndsAtMirror,
}

fn beyond(surface: &Option<Vec3>) -> String {
    match surface {
        Some(surface) => format!("the surface in its direction is at {surface}"),
        None => "there is none in its direction".to_owned(),
    }
}

impl UserPath {
    /// Checks a path against a scene.
    pub fn check(scene: &Scene, given: &GivenPath<'_>) -> Result<Self, UserPathError> {
        let places: Vec<Vec3> = given.points.iter().map(|point| Vec3::from_array(*point)).collect();
        let tolerance = TOLERANCE * scene.geometry.bounding_sphere().1;
        let light = lamp_at(scene, places[0], places[1], tolerance)?;
        let mut points = Vec::with_capacity(places.len() - 1);
        let mut previous: Option<Interaction> = None;
        for (segment, target) in (1..places.len()).zip(&places[1..]) {
            let hit = follow(scene, previous.as_ref(), places[0], *target, segment, tolerance)?;
            let is_last = segment + 1 == places.len();
            let is_smooth = scene.lobes_at(hit.shape).any(Lobes::SMOOTH);
            if is_last && !is_smooth {
                return Err(UserPathError::EndsAtMirror);
            }
            let next = places.get(segment + 1).map(|next| (*next - hit.position).normalize());
            let is_specular = next.is_some_and(|next| !is_smooth || leads_to(scene, &hit, next));
            if is_specular && !next.is_some_and(|next| leads_to(scene, &hit, next)) {
                return Err(UserPathError::LeavesMirror { segment: segment + 1 });
            }
            let half = libm::sinf(0.5 * given.cones[segment - 1]);
            points.push(UserPoint { position: hit.position, one_minus_cosine: 2.0 * half * half, is_specular });
            previous = Some(hit);
        }
        Ok(Self { light, points })
    }
}

/// The lamp at a place, as seen from the next point.
fn lamp_at(scene: &Scene, place: Vec3, next: Vec3, tolerance: f32) -> Result<u32, UserPathError> {
    let mut nearest: Option<(u32, Vec3)> = None;
    let mut offer = |light: u32, at: Vec3| {
        if nearest.is_none_or(|(_, other)| at.distance(place) < other.distance(place)) {
            nearest = Some((light, at));
        }
    };
    for light in 0..scene.lights.lights().len() as u32 {
        // An even look at each lamp tells where it is about.
        for u in 0..LOOKS {
            let number = (u as f32 + 0.5) / LOOKS as f32;
            let turned = (number * 7.0).fract();
            let Some(end) = LightEnd::at(scene, light, [number, turned, 0.0, 0.5, 0.5]) else { continue };
            let Some(first) = end.segment(scene, next) else { continue };
            offer(light, end.position(scene, &first, next).unwrap_or(Vec3::INFINITY));
        }
    }
    // A place of a large lamp is found by looking there from just before it, so that nothing else is in the way.
    let direction = (place - next).normalize();
    if let Some(hit) = scene.intersect(&Ray::new(place - direction * (2.0 * tolerance), direction))
        && hit.position.distance(place) <= tolerance
        && let Some(LightEnd::Surface { light, .. }) = LightEnd::of_hit(scene, &hit, false)
    {
        return Ok(light);
    }
    match nearest.filter(|(_, at)| at.is_finite()) {
        None => Err(UserPathError::NoPlaces),
        Some((light, at)) if at.distance(place) <= tolerance => Ok(light),
        Some((_, nearest)) => Err(UserPathError::NoLamp { nearest }),
    }
}

/// Places of each lamp that are looked at.
const LOOKS: u32 = 16;

/// Where a segment ends.
fn follow(
    scene: &Scene,
    previous: Option<&Interaction>,
    lamp: Vec3,
    target: Vec3,
    segment: usize,
    tolerance: f32,
) -> Result<Interaction, UserPathError> {
    let from = previous.map_or(lamp, |hit| hit.position);
    let direction = (target - from).normalize();
    let mut ray = previous.map_or(Ray::new(lamp, direction), |hit| hit.ray_to(direction));
    if previous.is_none() {
        // The lamp itself is not in the way.
        ray.origin += direction * tolerance.min(0.5 * target.distance(from));
    }
    let Some(hit) = scene.intersect(&ray) else { return Err(UserPathError::HitsNothing { segment, surface: None }) };
    let (found, wanted) = (hit.position.distance(from), target.distance(from));
    if found < wanted - tolerance {
        return Err(UserPathError::Blocked { segment, at: hit.position });
    }
    if found > wanted + tolerance {
        return Err(UserPathError::HitsNothing { segment, surface: Some(hit.position) });
    }
    Ok(hit)
}

/// Whether a specular lobe at `hit` leads about into `direction`.
fn leads_to(scene: &Scene, hit: &Interaction, direction: Vec3) -> bool {
    let choice = LobeChoice::new(scene, hit.shape, &View::at(hit, TransportMode::Flux));
    let local = hit.frame.to_local(direction);
    choice.nearest(local).is_some_and(|lobe| lobe.direction.dot(local) >= FOLLOWS)
}
