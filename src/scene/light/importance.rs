//! Light importance: an estimate of each light's unshadowed contribution at a place, by which a light is picked there.
//!
//! The importance of a light is its peak intensity over the square of the distance, W·m⁻², where the place lies in the light's cone
//! and the light over the place's horizon, times approximate cosines at both ends. Eight lights are evaluated together; many
//! are kept in groups of neighbours, so that a pick evaluates about 2·√n of n lights. Occlusion is ignored.
//! After Conty Estevez & Kulla 2018, "Importance sampling of many lights with adaptive tree splitting", with groups
//! instead of a tree: the large boxes near a tree's root tell places apart badly.

use crate::math::Vec3;
use crate::math::lanes::{larger, smaller};
use crate::scene::geometry::Interaction;
use crate::scene::material::Lobes;

/// Lights that are looked at together.
const LANES: usize = 8;
/// Up to so many lights are one group.
const GROUP: usize = 128;
/// What light at a grazing angle counts, at a flat lamp and where it arrives, as a share of that along the normal.
const EDGE: f32 = 0.1;

/// What the importance of a light is computed from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightImportance {
    /// Inside the scene.
    Near(Lamp),
    /// Outside: the same everywhere.
    Far {
        /// W·m⁻² on a surface that faces it.
        irradiance: f32,
    },
}

/// The bounds of a light in the scene: place, extent, intensity and direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// The middle, m.
    pub center: Vec3,
    /// Everything that shines is so near to the middle, m.
    pub radius: f32,
    /// Radiant intensity where it is brightest, or thereabouts, W·sr⁻¹.
    pub intensity: f32,
    /// Where it shines to.
    pub aim: Aim,
}

/// Where a lamp shines to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim {
    /// Anywhere.
    Everywhere,
    /// From a plane to one side, falling with the cosine against the unit vector.
    Side(Vec3),
    /// Along a unit vector, with at least this cosine against it.
    Cone(Vec3, f32),
}

/// A place that light may arrive at.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Where, m.
    pub position: Vec3,
    /// Normal on the lit side; zero in the middle of nothing.
    normal: Vec3,
    /// 1 where light may come from behind too, else 0.
    both_sides: f32,
    /// The share of picks that goes by power alone.
    by_power: f32,
}

impl From<Vec3> for Place {
    /// In the middle of nothing: all directions count the same.
    fn from(position: Vec3) -> Self {
        Self { position, normal: Vec3::ZERO, both_sides: 1.0, by_power: 0.0 }
    }
}

impl Place {
    /// On a surface with some `lobes`, on the side of the path that came there.
    #[inline]
    pub fn on(hit: &Interaction, lobes: Lobes) -> Self {
        let normal = hit.geometric_normal;
        let facing = if hit.outgoing.dot(normal) < 0.0 { -normal } else { normal };
        let both_sides = f32::from(u8::from(lobes.any(Lobes::TRANSMISSIVE)));
        let by_power = if lobes.any(Lobes::NARROW) { BY_POWER_IN_GLOSS } else { BY_POWER };
        Self { position: hit.offset_towards(hit.outgoing), normal: facing, both_sides, by_power }
    }

    /// The share of picks that goes by power alone, 0 to below 1.
    #[inline]
    pub fn by_power(&self) -> f32 {
        self.by_power
    }
}

/// So many picks go by power, for places whose bright lamps are hidden by walls.
const BY_POWER: f32 = 0.1;
/// And so many where a surface is glossy: in a highlight the lamp that it shows is all that matters, however far it is.
const BY_POWER_IN_GLOSS: f32 = 0.5;

type Lanes = [f32; LANES];

/// Eight lamps, one a lane; spare lanes have no intensity.
#[derive(Clone, Debug, Default)]
struct Eight {
    center: [Lanes; 3],
    radius: Lanes,
    axis: [Lanes; 3],
    /// Least cosine against the axis.
    cutoff: Lanes,
    /// Intensity is `base + slope·cosine`.
    base: Lanes,
    slope: Lanes,
}

impl Eight {
    fn set(&mut self, lane: usize, lamp: &Lamp) {
        let (axis, cutoff, base, slope) = match lamp.aim {
            Aim::Everywhere => (Vec3::Z, -2.0, 1.0, 0.0),
            Aim::Side(normal) => (normal, 0.0, EDGE, 1.0 - EDGE),
            Aim::Cone(axis, cosine) => (axis, cosine, 1.0, 0.0),
        };
        for dimension in 0..3 {
            self.center[dimension][lane] = lamp.center[dimension];
            self.axis[dimension][lane] = axis[dimension];
        }
        self.radius[lane] = lamp.radius;
        self.cutoff[lane] = cutoff;
        (self.base[lane], self.slope[lane]) = (base * lamp.intensity, slope * lamp.intensity);
    }

    #[inline(always)]
    fn importances(&self, place: &Place) -> Lanes {
        let (position, normal) = (place.position.to_array(), place.normal.to_array());
        let (floor, slope) = if place.normal == Vec3::ZERO { (1.0, 0.0) } else { (EDGE, 1.0 - EDGE) };
        std::array::from_fn(|lane| {
            let [x, y, z] = [0, 1, 2].map(|dimension| position[dimension] - self.center[dimension][lane]);
            let along = x * self.axis[0][lane] + y * self.axis[1][lane] + z * self.axis[2][lane];
            let height = -(x * normal[0] + y * normal[1] + z * normal[2]);
            let distance_squared = x * x + y * y + z * z;
            let cosine = along / larger(distance_squared, f32::MIN_POSITIVE).sqrt();
            let intensity = self.base[lane] + self.slope[lane] * cosine;
            // No part of the lamp is higher over the surface than this.
            let highest = larger(height, -place.both_sides * height) + self.radius[lane];
            let reach_squared = larger(distance_squared, self.radius[lane] * self.radius[lane]);
            let facing = floor + slope * smaller(highest / reach_squared.sqrt(), 1.0);
            let shines = (cosine > self.cutoff[lane]) & (highest > 0.0);
            if shines { intensity * facing / reach_squared } else { 0.0 }
        })
    }
}

/// Lamps in a row.
#[derive(Clone, Debug)]
struct Lamps(Vec<Eight>);

impl Lamps {
    fn new(lamps: impl ExactSizeIterator<Item = Lamp>) -> Self {
        let mut eights = vec![Eight::default(); lamps.len().div_ceil(LANES)];
        lamps.enumerate().for_each(|(index, lamp)| eights[index / LANES].set(index % LANES, &lamp));
        Self(eights)
    }

    #[inline]
    fn total(&self, place: &Place) -> f32 {
        let mut sums = [0.0; LANES];
        for eight in &self.0 {
            let importances = eight.importances(place);
            (0..LANES).for_each(|lane| sums[lane] += importances[lane]);
        }
        sums.iter().sum()
    }

    fn importance(&self, place: &Place, index: usize) -> f32 {
        self.0[index / LANES].importances(place)[index % LANES]
    }

    /// The lamp at `target` in the row of importances, its own, and the rest of `target` within it.
    #[inline]
    fn find(&self, place: &Place, mut target: f32) -> Option<(usize, f32, f32)> {
        let mut last = None;
        for (index, eight) in self.0.iter().enumerate() {
            for (lane, importance) in eight.importances(place).into_iter().enumerate() {
                if importance > 0.0 {
                    last = Some((index * LANES + lane, importance, target.min(importance)));
                    if target < importance {
                        return last;
                    }
                    target -= importance;
                }
            }
        }
        // Rounding may leave a rest beyond the last one.
        last
    }
}

/// Picks lights in proportion to their importance at a place.
#[derive(Clone, Debug)]
pub struct ImportanceSampler {
    /// Lights outside and their irradiance.
    far: Vec<(u32, f32)>,
    far_total: f32,
    /// Each group as one lamp; empty when there is only one group.
    groups: Option<Lamps>,
    members: Vec<Group>,
    /// Where each light is stored.
    slots: Vec<Slot>,
}

#[derive(Clone, Debug)]
struct Group {
    lamps: Lamps,
    lights: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
enum Slot {
    Far { irradiance: f32 },
    Near { group: u32, member: u32 },
}

impl ImportanceSampler {
    /// Over lights by index. Nothing is nearer to a lamp than `nearest`, m, so that places on a point light stay finite.
    pub fn new(lights: &[LightImportance], nearest: f32) -> Self {
        let (mut far, mut near) = (Vec::new(), Vec::new());
        let mut slots = vec![Slot::Far { irradiance: 0.0 }; lights.len()];
        // Shares of the whole keep far from the ends of f32 whatever the unit.
        let brightest = lights.iter().map(LightImportance::brightness).fold(f32::MIN_POSITIVE, f32::max);
        for (index, importance) in (0u32..).zip(lights) {
            match *importance {
                LightImportance::Far { irradiance } => {
                    let irradiance = irradiance / brightest;
                    far.push((index, irradiance));
                    slots[index as usize] = Slot::Far { irradiance };
                }
                LightImportance::Near(lamp) => {
                    let (radius, intensity) = (lamp.radius.max(nearest), lamp.intensity / brightest);
                    near.push((index, Lamp { radius, intensity, ..lamp }));
                }
            }
        }
        let far_total = far.iter().map(|(_, irradiance)| irradiance).sum();
        let mut parts = Vec::new();
        split(near, &mut parts);
        for (group, members) in (0u32..).zip(&parts) {
            for (member, (light, _)) in (0u32..).zip(members) {
                slots[*light as usize] = Slot::Near { group, member };
            }
        }
        let groups = (parts.len() > 1).then(|| Lamps::new(parts.iter().map(|members| joined(members))));
        let group = |members: Vec<(u32, Lamp)>| Group {
            lamps: Lamps::new(members.iter().map(|(_, lamp)| *lamp)),
            lights: members.iter().map(|(light, _)| *light).collect(),
        };
        Self { far, far_total, groups, members: parts.into_iter().map(group).collect(), slots }
    }

    /// A light for `place` with `u` in [0, 1), and the probability of that; `None` where no light shines to.
    #[inline]
    pub fn pick(&self, place: &Place, u: f32) -> Option<(usize, f32)> {
        let near = self.near_total(place);
        let total = self.far_total + near;
        if total <= 0.0 {
            return None;
        }
        let mut target = u * total;
        for (light, irradiance) in &self.far {
            if target < *irradiance {
                return Some((*light as usize, irradiance / total));
            }
            target -= irradiance;
        }
        if near == 0.0 {
            // Rounding left a rest beyond the last one.
            return self.far.last().map(|(light, irradiance)| (*light as usize, irradiance / total));
        }
        let (group, importance, rest) = match &self.groups {
            Some(groups) => groups.find(place, target)?,
            None => (0, near, target),
        };
        let Group { lamps, lights } = &self.members[group];
        let within = if self.groups.is_some() { lamps.total(place) } else { near };
        let (member, share, _) = lamps.find(place, rest / importance * within)?;
        let probability = if self.groups.is_some() { importance / total * (share / within) } else { share / total };
        Some((lights[member] as usize, probability))
    }

    /// The probability with which [`ImportanceSampler::pick`] takes `light` at `place`.
    #[inline]
    pub fn probability(&self, place: &Place, light: usize) -> f32 {
        let near = self.near_total(place);
        let total = self.far_total + near;
        if total <= 0.0 {
            return 0.0;
        }
        match self.slots[light] {
            Slot::Far { irradiance } => irradiance / total,
            Slot::Near { group, member } => {
                let lamps = &self.members[group as usize].lamps;
                let share = lamps.importance(place, member as usize);
                match &self.groups {
                    _ if share == 0.0 => 0.0,
                    None => share / total,
                    Some(groups) => groups.importance(place, group as usize) / total * (share / lamps.total(place)),
                }
            }
        }
    }

    #[inline]
    fn near_total(&self, place: &Place) -> f32 {
        match (&self.groups, self.members.first()) {
            (Some(groups), _) => groups.total(place),
            (None, Some(only)) => only.lamps.total(place),
            (None, None) => 0.0,
        }
    }
}

impl LightImportance {
    /// Intensity or irradiance.
    fn brightness(&self) -> f32 {
        match self {
            Self::Near(lamp) => lamp.intensity,
            Self::Far { irradiance } => *irradiance,
        }
    }
}

/// Splits lamps into groups of neighbours: at the middle of the longer side of their box, until they are few enough.
fn split(mut lamps: Vec<(u32, Lamp)>, groups: &mut Vec<Vec<(u32, Lamp)>>) {
    if lamps.len() <= GROUP {
        if !lamps.is_empty() {
            groups.push(lamps);
        }
        return;
    }
    let bounds = |pick: fn(Vec3, Vec3) -> Vec3| lamps.iter().map(|(_, lamp)| lamp.center).reduce(pick);
    let size = bounds(Vec3::max).unwrap_or_default() - bounds(Vec3::min).unwrap_or_default();
    let axis = size.max_position();
    lamps.sort_by(|(_, a), (_, b)| a.center[axis].total_cmp(&b.center[axis]));
    let second = lamps.split_off(lamps.len() / 2);
    split(lamps, groups);
    split(second, groups);
}

/// A lamp that shines wherever one of `members` does.
fn joined(members: &[(u32, Lamp)]) -> Lamp {
    let intensity: f32 = members.iter().map(|(_, lamp)| lamp.intensity).sum();
    let middle = members.iter().map(|(_, lamp)| lamp.center * (lamp.intensity / intensity)).sum::<Vec3>();
    let center = if middle.is_finite() { middle } else { members[0].1.center };
    let reach = members.iter().map(|(_, lamp)| center.distance(lamp.center) + lamp.radius);
    Lamp { center, radius: reach.fold(0.0, f32::max), intensity, aim: Aim::Everywhere }
}
