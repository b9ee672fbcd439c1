//! The entities that set the current color.

use super::Reader;
use super::color::Color;
use super::text::Entity;
use crate::scene::error::{SceneError, shown_number};

impl Reader<'_> {
    /// Follows `cxy`, `cspec`, `cct` or `cmix`. Whether the result is a color that things can have is asked when they get it.
    pub(super) fn set_color(&mut self, entity: &Entity<'_>) -> Result<(), SceneError> {
        *self.colors.current() = match entity.keyword {
            "cxy" => {
                entity.check_count(2, 2, "cxy x y")?;
                Color { x: entity.number(0)?, y: entity.number(1)? }
            }
            "cct" => {
                entity.check_count(1, 1, "cct kelvin")?;
                match entity.number(0)? {
                    kelvin if kelvin >= 100.0 => Color::from_temperature(kelvin),
                    kelvin => {
                        return Err(
                            entity.error(format!("a black body of {} K", shown_number(kelvin)), "give at least 100 K")
                        );
                    }
                }
            }
            "cspec" => {
                entity.check_count(4, 4096, "cspec first_nanometer last_nanometer value1 value2 …")?;
                let (first, last) = (entity.amount(0)?, entity.amount(1)?);
                let values = (2..entity.words.len()).map(|at| entity.number(at)).collect::<Result<Vec<_>, _>>()?;
                if last <= first {
                    return Err(entity.error("the wavelengths do not increase", "give the first and the last in nm"));
                }
                Color::from_spectrum(first, last, &values)
            }
            _ => {
                entity.check_count(2, 4096, "cmix weight1 color1 weight2 color2 …")?;
                if entity.words.len() % 2 == 1 {
                    return Err(entity.error("the last weight has no color", "give weights and colors in turn"));
                }
                let part = |at: usize| Ok((entity.number(at)?, self.colors.find(entity.word(at + 1), entity)?));
                let parts = (0..entity.words.len()).step_by(2).map(part).collect::<Result<Vec<_>, SceneError>>()?;
                Color::mix(&parts)
            }
        };
        Ok(())
    }
}
