//! With what probability a path goes on by each perfectly specular lobe of a surface, and by all lobes with a density together.
//!
//! Chains have to know these of every path, however it was found, so they do not follow from how a material samples itself.

use crate::math::{Rgb, Vec3};
use crate::scene::Scene;
use crate::scene::geometry::surface::Shape;
use crate::scene::material::{Lobes, SpecularLobes, View};

/// What a path follows at a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lobe {
    /// Lobes with a density.
    #[default]
    Smooth,
    /// A perfectly specular one.
    Specular,
}

/// Where a surface has both, with what probability the path goes on by those with a density, or ends a subpath in them.
const SMOOTH: f32 = 0.5;
/// A direction belongs to a specular lobe when the cosine between them is at least this.
const SAME_DIRECTION: f32 = 0.999;

/// The lobes in view, and how probable each is.
pub(crate) struct LobeChoice {
    specular: SpecularLobes,
    shares: [f32; 4],
    smooth: f32,
}

/// A specular lobe.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpecularChoice {
    /// Its local direction.
    pub direction: Vec3,
    /// Its full weight.
    pub weight: Rgb,
    /// Its probability.
    pub share: f32,
}

impl LobeChoice {
    /// Of a surface in view.
    pub(crate) fn new(scene: &Scene, shape: Shape, view: &View) -> Self {
        let specular = scene.material(shape).specular_lobes(view);
        let weights = specular.map(|lobe| lobe.map_or(0.0, |lobe| lobe.weight.max_element()));
        let total: f32 = weights.iter().sum();
        let has_smooth = scene.lobes_at(shape).any(Lobes::SMOOTH);
        let smooth = match (has_smooth, total > 0.0) {
            (true, true) => SMOOTH,
            (true, false) => 1.0,
            (false, _) => 0.0,
        };
        let share = |weight: f32| if total > 0.0 { (1.0 - smooth) * weight / total } else { 0.0 };
        Self { specular, shares: weights.map(share), smooth }
    }

    /// The probability of the lobes with a density.
    pub(crate) fn smooth(&self) -> f32 {
        self.smooth
    }

    /// The specular lobe that `u` in [0, 1) picks; `None` for the others.
    pub(crate) fn pick(&self, u: f32) -> Option<SpecularChoice> {
        let mut rest = u - self.smooth;
        if rest < 0.0 {
            return None;
        }
        let possible = (0..4).filter(|index| self.shares[*index] > 0.0);
        let mut last = None;
        for index in possible {
            last = self.choice(index);
            rest -= self.shares[index];
            if rest < 0.0 {
                break;
            }
        }
        last
    }

    /// The specular lobe that leads into a local direction.
    pub(crate) fn towards(&self, direction: Vec3) -> Option<SpecularChoice> {
        self.nearest(direction).filter(|choice| choice.direction.dot(direction) >= SAME_DIRECTION)
    }

    /// The specular lobe whose direction is nearest to a local one.
    pub(crate) fn nearest(&self, direction: Vec3) -> Option<SpecularChoice> {
        let choices = (0..4).filter_map(|index| self.choice(index)).filter(|choice| choice.share > 0.0);
        choices.max_by(|a, b| a.direction.dot(direction).total_cmp(&b.direction.dot(direction)))
    }

    fn choice(&self, index: usize) -> Option<SpecularChoice> {
        let lobe = self.specular[index]?;
        Some(SpecularChoice { direction: lobe.direction, weight: lobe.weight, share: self.shares[index] })
    }
}
