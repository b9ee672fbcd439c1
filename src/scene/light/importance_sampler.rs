//! Picks lights in proportion to their importance at a place.
//!
//! Eight lights are evaluated together; many are kept in groups of neighbours, so that a pick evaluates about 2·√n of n lights.
//! After Conty Estevez & Kulla 2018, "Importance sampling of many lights with adaptive tree splitting", with groups
//! instead of a tree: the large boxes near a tree's root tell places apart badly.

use super::importance::{Aim, Lamp, LightImportance, Place};
use crate::math::Vec3;
use crate::math::lanes::{larger, smaller};

/// Lights that are looked at together.
const LANES: usize = 8;
/// Up to so many lights are one group.
const GROUP: usize = 128;
/// What light at a grazing angle counts, at a flat lamp and where it arrives, as a share of that along the normal.
const EDGE: f32 = 0.1;

/// A number for each of eight lamps.
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
        for index in 0..self.0.len() {
            let importances = self.0[index].importances(place);
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
        for index in 0..self.0.len() {
            for (lane, importance) in self.0[index].importances(place).into_iter().enumerate() {
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
    Far {
        irradiance: f32,
    },
    Near {
        group: u32,
        member: u32,
    },
    /// It is never picked.
    LeftOut,
}

impl ImportanceSampler {
    /// Over lights by index. Nothing is nearer to a lamp than `nearest`, m, so that places on a point light stay finite.
    pub fn new(lights: &[LightImportance], nearest: f32) -> Self {
        Self::of_shares(lights, nearest, |_| 1.0)
    }

    /// The same where only a share of each light's importance is left; what has none is left out.
    pub fn of_shares(lights: &[LightImportance], nearest: f32, share: impl Fn(usize) -> f32) -> Self {
        let (mut far, mut near) = (Vec::new(), Vec::new());
        let mut slots = vec![Slot::LeftOut; lights.len()];
        // Shares of the whole keep far from the ends of f32 whatever the unit.
        let brightest = lights.iter().map(LightImportance::brightness).fold(f32::MIN_POSITIVE, f32::max);
        for (light, importance) in (0u32..).zip(lights) {
            let share = share(light as usize);
            if share == 0.0 {
                continue;
            }
            match *importance {
                LightImportance::Far { irradiance } => {
                    let irradiance = share * irradiance / brightest;
                    slots[light as usize] = Slot::Far { irradiance };
                    far.push((light, irradiance));
                }
                LightImportance::Near(lamp) => {
                    let (radius, intensity) = (lamp.radius.max(nearest), share * lamp.intensity / brightest);
                    near.push((light, Lamp { radius, intensity, ..lamp }));
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
        let (near, far) = (self.near_total(place), self.far_total);
        let total = far + near;
        if total <= 0.0 {
            return None;
        }
        let mut target = u * total;
        let mut last = None;
        for (light, irradiance) in &self.far {
            last = Some((*light as usize, irradiance / total));
            if target < *irradiance {
                return last;
            }
            target -= irradiance;
        }
        if near == 0.0 {
            // Rounding left a rest beyond the last one.
            return last;
        }
        let (group, importance, rest) = match &self.groups {
            Some(groups) => groups.find(place, target)?,
            None => (0, near, target),
        };
        let group = &self.members[group];
        let within = if self.groups.is_some() { group.lamps.total(place) } else { near };
        let (member, share, _) = group.lamps.find(place, rest / importance * within)?;
        let probability = if self.groups.is_some() { importance / total * (share / within) } else { share / total };
        Some((group.lights[member] as usize, probability))
    }

    /// The probability with which [`ImportanceSampler::pick`] takes `light` at `place`.
    #[inline]
    pub fn probability(&self, place: &Place, light: usize) -> f32 {
        let total = self.far_total + self.near_total(place);
        if total <= 0.0 {
            return 0.0;
        }
        match self.slots[light] {
            Slot::LeftOut => 0.0,
            Slot::Far { irradiance } => irradiance / total,
            Slot::Near { group: index, member } => {
                let group = &self.members[index as usize];
                let share = group.lamps.importance(place, member as usize);
                match &self.groups {
                    _ if share == 0.0 => 0.0,
                    None => share / total,
                    Some(groups) => {
                        let importance = groups.importance(place, index as usize);
                        importance / total * (share / group.lamps.total(place))
                    }
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
