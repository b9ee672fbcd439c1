//! Area lights: what is current when shapes come.

use std::f64::consts::PI;

use super::super::draft::Draft;
use super::super::resolve::resolve;
use super::output::Output;
use super::parameters::Parameters;
use super::texture::ColorOrTexture;
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::Primitive;
use crate::scene::geometry::primitive::SHAPES;

/// The light of shapes that come after `AreaLightSource`.
#[derive(Clone, Debug)]
pub(super) struct AreaSource {
    /// Radiance, W·sr⁻¹·m⁻², or what is in proportion to it where there is a power.
    radiance: ColorOrTexture,
    two_sided: bool,
    power: Option<Power>,
    /// pbrt has no such parameter.
    light_group: Option<String>,
}

/// The flux of every shape that the light is on.
#[derive(Clone, Copy, Debug)]
struct Power {
    /// lm, or W where colors of luminance 1 are 1 W.
    flux: f64,
    /// The mean luminance that the image has; 1 without an image.
    mean: f64,
}

impl AreaSource {
    /// A light of one color.
    pub(super) fn of_color(radiance: [f64; 3], parameters: &Parameters) -> Result<Self, SceneError> {
        Self::of_image(ColorOrTexture::Color(radiance), 1.0, parameters)
    }

    /// A light of an image with this mean luminance.
    pub(super) fn of_image(radiance: ColorOrTexture, mean: f64, parameters: &Parameters) -> Result<Self, SceneError> {
        let flux = parameters.float("power")?.filter(|power| *power > 0.0);
        let power = flux.map(|flux| Power { flux, mean });
        let light_group = parameters.text("light_group")?.map(str::to_owned);
        Ok(Self { radiance, two_sided: parameters.flag("twosided")?.unwrap_or(false), power, light_group })
    }

    /// Whether texture coordinates matter.
    pub(super) fn is_textured(&self) -> bool {
        self.radiance.is_texture()
    }

    /// Whether it is black.
    pub(super) fn is_black(&self) -> bool {
        matches!(self.radiance, ColorOrTexture::Color([0.0, 0.0, 0.0]))
    }

    /// The emitter of `shape`, which is of pbrt's kind `kind`.
    ///
    /// # Errors
    /// When the area of a shape with a power cannot be found out.
    pub(super) fn on(
        &self,
        shape: &Draft,
        kind: &str,
        parameters: &Parameters,
        output: &mut Output<'_>,
    ) -> Result<Draft, SceneError> {
        let radiance = match self.power {
            None => self.radiance.clone(),
            Some(Power { flux, mean }) => {
                let (area, pieces) = extent(shape, kind, output)?;
                let sides = if self.two_sided { 2.0 } else { 1.0 };
                let factor = flux * pieces as f64 / (mean * sides * area * PI).max(f64::MIN_POSITIVE);
                self.radiance.scaled([factor; 3], parameters, output)?
            }
        };
        let light = radiance.put(Draft::new(PluginClass::Emitter, "area", &parameters.place), "radiance");
        let light = if self.two_sided { light.with_flag("two_sided", true) } else { light };
        Ok(light.in_light_group(self.light_group.as_deref()))
    }
}

/// The area of a shape in the world, m², and how many lights pbrt makes of it: one for each triangle or patch, each of
/// which has the whole power.
fn extent(shape: &Draft, kind: &str, output: &mut Output<'_>) -> Result<(f64, usize), SceneError> {
    let unknown = || SceneError::new(&shape.location, "the area of a light with a power is unknown", "give \"L\"");
    let alone = resolve(&Draft { children: Vec::new(), ..shape.clone() }, &[])?;
    let (_, read) = SHAPES.iter().find(|(name, _)| *name == alone.plugin).ok_or_else(unknown)?;
    let bundle = output.bundle.clone().with_generated(output.made.clone());
    let primitives = read(&mut Fields::new(&alone), &bundle)?.primitives;
    let areas: Vec<f64> = primitives.iter().map(Primitive::area).map(f64::from).collect();
    let pieces = match kind {
        "trianglemesh" | "plymesh" | "loopsubdiv" => areas.len(),
        "bilinearmesh" => areas.len() / 2,
        _ => 1,
    };
    let (least, most) =
        areas.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), area| (least.min(*area), most.max(*area)));
    if pieces > 1 && least < 0.99 * most {
        let instead =
            "in pbrt each has it, so that small ones are brighter; here all are alike and have as much together";
        output.approximated(&shape.location, "the power of triangles of different size", instead);
    }
    Ok((areas.iter().sum(), pieces))
}
