//! The material context of MGF.

use super::color::{Color, GREY};
use super::text::Entity;
use crate::scene::error::{SceneError, shown_number};

/// One component: how much light, of which color, and how rough the surface is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Component {
    /// A photometric share; of the emission lm·m⁻².
    pub amount: f64,
    pub color: Color,
    /// Root mean square slope of the facets; 0 is smooth.
    pub roughness: f64,
}

const NOTHING: Component = Component { amount: 0.0, color: GREY, roughness: 0.0 };

/// A material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Material {
    pub two_sided: bool,
    /// Real and imaginary part of the index of refraction.
    pub index: [f64; 2],
    pub diffuse_reflection: Component,
    pub diffuse_transmission: Component,
    pub emission: Component,
    pub specular_reflection: Component,
    pub specular_transmission: Component,
}

/// A two-sided black absorber.
pub(super) const BLACK: Material = Material {
    two_sided: true,
    index: [1.0, 0.0],
    diffuse_reflection: NOTHING,
    diffuse_transmission: NOTHING,
    emission: NOTHING,
    specular_reflection: NOTHING,
    specular_transmission: NOTHING,
};

/// All numbers of a material, for looking it up.
pub(super) type Key = [u64; 23];

impl Material {
    /// Follows one of the entities `sides`, `rd`, `td`, `ed`, `rs`, `ts` and `ir`; `color` is the current color.
    pub(super) fn set(&mut self, entity: &Entity<'_>, color: Color) -> Result<(), SceneError> {
        let is_colored = !["sides", "ir"].contains(&entity.keyword);
        if is_colored && !color.is_real() && entity.number(0).is_ok_and(|amount| amount != 0.0) {
            let remedy =
                "give chromaticities with y above 0 and x + y up to 1, or visible light in a spectrum or mixture";
            return Err(entity.error("no light has the current color", remedy));
        }
        match entity.keyword {
            "sides" => {
                entity.check_count(1, 1, "sides 1 or sides 2")?;
                self.two_sided = match entity.word(0) {
                    "1" => false,
                    "2" => true,
                    other => return Err(entity.error(format!("{other:?} sides"), "write \"sides 1\" or \"sides 2\"")),
                };
            }
            "rd" => self.diffuse_reflection = share(entity, color)?,
            "td" => self.diffuse_transmission = share(entity, color)?,
            "rs" => self.specular_reflection = rough_share(entity, color)?,
            "ts" => self.specular_transmission = rough_share(entity, color)?,
            "ed" => {
                entity.check_count(1, 1, "ed emittance")?;
                self.emission = Component { amount: entity.amount(0)?, color, roughness: 0.0 };
            }
            _ => {
                entity.check_count(2, 2, "ir n_real n_imaginary")?;
                let index = [entity.amount(0)?, entity.amount(1)?];
                if index[0] == 0.0 {
                    return Err(entity.error("the index of refraction is 0", "give a number above 0"));
                }
                self.index = index;
            }
        }
        Ok(())
    }

    fn components(&self) -> [Component; 5] {
        let reflection = [self.diffuse_reflection, self.specular_reflection];
        let transmission = [self.diffuse_transmission, self.specular_transmission];
        [reflection[0], reflection[1], transmission[0], transmission[1], self.emission]
    }

    /// What tells it from other materials.
    pub(super) fn key(&self) -> Key {
        let mut key = [0; 23];
        key[..3].copy_from_slice(&[u64::from(self.two_sided), self.index[0].to_bits(), self.index[1].to_bits()]);
        for (part, component) in key[3..].chunks_exact_mut(4).zip(self.components()) {
            let Component { amount, color, roughness } = component;
            part.copy_from_slice(&[amount, color.x, color.y, roughness].map(f64::to_bits));
        }
        key
    }

    /// The sum of all that is reflected and transmitted.
    pub(super) fn albedo(&self) -> f64 {
        self.components()[..4].iter().map(|component| component.amount).sum()
    }
}

/// A share of the light that is scattered evenly.
fn share(entity: &Entity<'_>, color: Color) -> Result<Component, SceneError> {
    entity.check_count(1, 1, &format!("{} share", entity.keyword))?;
    Ok(Component { amount: at_most_one(entity)?, color, roughness: 0.0 })
}

fn rough_share(entity: &Entity<'_>, color: Color) -> Result<Component, SceneError> {
    entity.check_count(2, 2, &format!("{} share roughness", entity.keyword))?;
    // Facets of less slope cannot be told from a smooth surface in single precision.
    let roughness = Some(entity.amount(1)?).filter(|roughness| *roughness >= 1e-4).unwrap_or_default();
    Ok(Component { amount: at_most_one(entity)?, color, roughness })
}

fn at_most_one(entity: &Entity<'_>) -> Result<f64, SceneError> {
    let amount = entity.amount(0)?;
    if amount <= 1.0 {
        return Ok(amount);
    }
    Err(entity
        .error(format!("a share of {} makes light out of nothing", shown_number(amount)), "give a number from 0 to 1"))
}
