//! Whether photons that lie close to a point belong to it, or to what is on the other side of a wall.
//!
//! A photon that came from o counts at p where p sees o [Wald 1999, section 4.1.1]. Where nothing stands between p and the photon,
//! it would hardly ever be otherwise, and where it is, at the rim of a shadow, photons that fail the test are not made up for by those that
//! never came to the dark side: the test then takes light away. So by default only photons are tested to which the way
//! along the surface is blocked; what may block it is found once per disc.

use serde::{Deserialize, Serialize};

use super::Counters;
use super::photon_map::{GatherQuery, Photon};
use super::visibility::SHADOW_END;
use crate::math::{Vec3, octahedral};
use crate::scene::Scene;
use crate::scene::geometry::{Interaction, Layer, Obstacles, Ray};

/// Which photons are tested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Occlusion {
    /// None: all count that lie in the disc.
    Off,
    /// Those between which and the point something stands.
    #[default]
    Unclear,
    /// All.
    All,
}

/// How high over the surface the way to a photon is looked along, in radii.
const HEIGHT: f32 = 0.05;
/// How far a disc reaches up and down, in radii; what the gather accepts.
const DEPTH: f32 = 0.25;
/// The way to a photon goes on behind it by so many rounding errors: a photon right under a wall lies on neither side of it, and is tested.
const BEHIND: f32 = 4.0;
/// A surface is an origin up to this share of the origin's distance before or behind it.
const ORIGIN_ROOM: f32 = 1.0 / 1024.0;

/// What a point of a surface sees.
pub(crate) struct Sight<'a> {
    scene: &'a Scene,
    hit: &'a Interaction,
    tested: Occlusion,
    /// The normal on the side that is looked at.
    normal: Vec3,
    /// Height over the surface of the way to photons, m.
    height: f32,
    /// On the side of the normal, and on the other.
    obstacles: [Obstacles; 2],
}

impl<'a> Sight<'a> {
    /// The sight from `hit`, within the disc of `query`, by which the photons `tested` are to be judged; `None` where every photon in the
    /// disc counts.
    #[inline]
    pub(crate) fn new(scene: &'a Scene, hit: &'a Interaction, query: &GatherQuery, tested: Occlusion) -> Option<Self> {
        if tested == Occlusion::Off {
            return None;
        }
        let radius = query.radius_squared.sqrt();
        let height = (HEIGHT * radius).max(2.0 * hit.error);
        let mut obstacles = [Obstacles::default(); 2];
        if tested == Occlusion::Unclear {
            let find = |side: Vec3| {
                let heights = [height, height + DEPTH * radius];
                scene.geometry.obstacles(&Layer::new(query.position, side, radius + BEHIND * hit.error, heights))
            };
            obstacles[0] = find(query.normal);
            if query.both_sides {
                obstacles[1] = find(-query.normal);
            }
            if obstacles.iter().all(Obstacles::is_empty) {
                return None;
            }
        }
        Some(Self { scene, hit, tested, normal: query.normal, height, obstacles })
    }

    /// Whether `photon` counts, which came from `origin_distance` m away.
    #[inline]
    pub(crate) fn accepts(&self, photon: &Photon, origin_distance: f32, counters: &mut Counters) -> bool {
        let (side, obstacles) = match photon.normal().dot(self.normal) < 0.0 {
            true => (-self.normal, &self.obstacles[1]),
            false => (self.normal, &self.obstacles[0]),
        };
        let is_tested = match self.tested {
            Occlusion::Off => false,
            Occlusion::Unclear => self.is_unclear(photon, side, obstacles, counters),
            Occlusion::All => true,
        };
        !is_tested || self.sees_origin(photon, origin_distance, side, counters)
    }

    /// Whether something stands between the point and `photon`, on that `side` of the surface.
    #[inline]
    fn is_unclear(&self, photon: &Photon, side: Vec3, obstacles: &Obstacles, counters: &mut Counters) -> bool {
        let between = Vec3::from_array(photon.position) - self.hit.position;
        let length = between.length();
        if obstacles.is_empty() || length == 0.0 {
            return false;
        }
        // Over what bulges between them where the photon lies lower.
        let lift = self.height + (-between.dot(side)).max(0.0);
        counters.rays += u64::from(obstacles.needs_tree());
        let (origin, direction) = (self.hit.position + side * lift, between / length);
        let ray = Ray { origin, direction, length: length + BEHIND * self.hit.error };
        self.scene.geometry.is_blocked_within(&ray, obstacles)
    }

    /// Whether the point sees on that `side` where `photon` came from.
    #[inline]
    fn sees_origin(&self, photon: &Photon, origin_distance: f32, side: Vec3, counters: &mut Counters) -> bool {
        let start = self.hit.offset_towards(side);
        counters.rays += 2;
        let Some(origin) = self.origin(photon, origin_distance, start) else { return false };
        let between = origin - start;
        if between.dot(side) <= 0.0 {
            return false;
        }
        let length = between.length();
        let ray = Ray { origin: start, direction: between / length, length: length * SHADOW_END };
        !self.scene.geometry.is_blocked(&ray)
    }

    /// Where `photon` came from. Its direction is 0.05 mrad off, which is much where `start` sees the origin along a wall; so a surface is
    /// looked for there. `None` where the photon came from the other side of it than `start` is on, and where something hides the origin
    /// from the photon itself, which then slipped in between wall and floor by rounding.
    #[inline]
    fn origin(&self, photon: &Photon, origin_distance: f32, start: Vec3) -> Option<Vec3> {
        let offset = 2.0 * self.hit.error;
        let position = Vec3::from_array(photon.position) + photon.normal() * offset;
        let direction = octahedral::decode(photon.direction);
        let room = origin_distance * ORIGIN_ROOM + 4.0 * offset;
        let ray = Ray { origin: position, direction, length: origin_distance + room };
        let Some(hit) = self.scene.intersect(&ray) else {
            return Some(position + direction * origin_distance);
        };
        let height = |place: Vec3| (place - hit.position).dot(hit.geometric_normal);
        let is_origin = hit.distance > origin_distance - room && height(start) * height(position) > 0.0;
        is_origin.then(|| hit.offset_towards(start - hit.position))
    }
}
