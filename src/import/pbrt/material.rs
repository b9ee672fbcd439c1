//! Materials. pbrt's reflect from both sides, so opaque ones stand in `twosided`.

use std::collections::HashMap;

use super::super::draft::Draft;
use super::super::values::shown;
use super::output::Output;
use super::parameters::{Parameters, Values};
use super::spectrum::{self, Purpose};
use super::texture::{ColorOrTexture, Textures};
use crate::scene::description::PluginClass;
use crate::scene::error::{Location, SceneError, nearest_defined_name, nearest_name, shown_number};

/// A material that shapes may have.
#[derive(Clone, Debug)]
pub(super) struct Material {
    /// The id of its bsdf.
    pub id: String,
    /// Whether texture coordinates matter.
    pub textured: bool,
}

/// Below this α pbrt's microfacets are a mirror.
const SMOOTH: f64 = 1e-3;

const KINDS: [&str; 14] = [
    "diffuse",
    "coateddiffuse",
    "conductor",
    "coatedconductor",
    "dielectric",
    "thindielectric",
    "diffusetransmission",
    "mix",
    "interface",
    "none",
    "subsurface",
    "measured",
    "hair",
    "",
];

/// Reads the material `kind`.
///
/// # Errors
/// On kinds that pbrt-v4 does not have, and parameters that mean nothing.
pub(super) fn read(
    kind: &str,
    name: &str,
    parameters: &Parameters,
    textures: &Textures,
    named: &HashMap<String, Material>,
    output: &mut Output<'_>,
) -> Result<Material, SceneError> {
    let mut reader = Reader { parameters, textures, output, textured: false };
    let bsdf = match kind {
        "diffuse" => reader.diffuse()?,
        "coateddiffuse" => reader.coated_diffuse()?,
        "conductor" => reader.conductor("")?,
        "coatedconductor" => {
            reader.replaced(kind, "a conductor without the coat takes its place");
            reader.conductor("conductor.")?
        }
        "dielectric" => reader.dielectric()?,
        "thindielectric" => reader.index(reader.bsdf("thindielectric"))?,
        "diffusetransmission" => reader.diffuse_transmission()?,
        "mix" => reader.mix(named)?,
        "interface" | "none" | "" => reader.bsdf("null"),
        "subsurface" | "measured" | "hair" => {
            reader.replaced(kind, "a diffuse one takes its place");
            reader.diffuse()?
        }
        _ => {
            let problem = format!("there is no material {}", shown(kind));
            return Err(SceneError::new(&parameters.place, problem, nearest_name(kind, &KINDS)));
        }
    };
    let textured = reader.textured;
    output.report_unused(&format!("material {}", shown(kind)), parameters)?;
    // Without a name of its own a material is called by its kind, as others are.
    let bsdf = if name == kind { bsdf } else { bsdf.called(name) };
    Ok(Material { id: output.define("material", name, bsdf)?, textured })
}

struct Reader<'a, 'b> {
    parameters: &'a Parameters,
    textures: &'a Textures,
    output: &'a mut Output<'b>,
    textured: bool,
}

impl Reader<'_, '_> {
    fn bsdf(&self, plugin: &str) -> Draft {
        Draft::new(PluginClass::Bsdf, plugin, &self.parameters.place)
    }

    fn replaced(&mut self, kind: &str, instead: &str) {
        self.output.approximated(&self.parameters.place, format!("material {}", shown(kind)), instead);
    }

    fn two_sided(&self, bsdf: Draft) -> Draft {
        self.bsdf("twosided").with_child("", bsdf)
    }

    fn share(&mut self, name: &str, default: f64) -> Result<ColorOrTexture, SceneError> {
        let given = self.textures.color(self.parameters, name, self.output)?;
        let value = given.unwrap_or(ColorOrTexture::Color([default; 3]));
        self.textured |= value.is_texture();
        self.at_most_1(value)
    }

    /// pbrt counts shares above 1 as 1.
    fn at_most_1(&mut self, value: ColorOrTexture) -> Result<ColorOrTexture, SceneError> {
        let place = &self.parameters.place;
        match value {
            ColorOrTexture::Color(rgb) if rgb.iter().any(|channel| *channel > 1.0) => {
                let subject = format!("a surface of {rgb:?}, which reflects more than all light,");
                self.output.approximated(place, subject, "what is above 1 counts as 1, as in pbrt");
                Ok(ColorOrTexture::Color(rgb.map(|channel| channel.min(1.0))))
            }
            ColorOrTexture::Texture(id) if self.output.bright.contains(&id) => {
                let clamped = Draft::new(PluginClass::Texture, "scale", place).with_flag("clamp", true);
                let clamped = self.output.define("texture", "clamped", clamped.with_reference(&id))?;
                Ok(ColorOrTexture::Texture(clamped))
            }
            value => Ok(value),
        }
    }

    fn diffuse(&mut self) -> Result<Draft, SceneError> {
        let reflectance = self.share("reflectance", 0.5)?;
        Ok(self.two_sided(reflectance.put(self.bsdf("diffuse"), "reflectance")))
    }

    fn coated_diffuse(&mut self) -> Result<Draft, SceneError> {
        // They say how pbrt finds the light that a medium of albedo 0, its default, lets through.
        self.parameters.pass_over(&["thickness", "maxdepth", "nsamples"]);
        let reflectance = self.share("reflectance", 0.5)?;
        let alpha = self.alpha("", 0.0, false)?;
        let coat = self.rough(["plastic", "roughplastic"], alpha);
        let coat = reflectance.put(self.index(coat)?, "diffuse_reflectance");
        Ok(self.two_sided(coat.with_flag("nonlinear", true)))
    }

    fn conductor(&mut self, prefix: &str) -> Result<Draft, SceneError> {
        let alpha = self.alpha(prefix, 0.0, true)?;
        let bsdf = self.rough(["conductor", "roughconductor"], alpha);
        let reflectance = if self.parameters.has("reflectance") { Some(self.share("reflectance", 1.0)?) } else { None };
        let bsdf = match reflectance {
            None => {
                let eta = self.metal(&format!("{prefix}eta"), "eta")?;
                bsdf.with_rgb("eta", eta).with_rgb("k", self.metal(&format!("{prefix}k"), "k")?)
            }
            Some(ColorOrTexture::Color(rgb)) => {
                // The k with which an index of 1 reflects as much head-on.
                let k = rgb.map(|share| share.min(0.9999)).map(|share| 2.0 * (share / (1.0 - share)).sqrt());
                bsdf.with_rgb("eta", [1.0; 3]).with_rgb("k", k)
            }
            Some(texture) => {
                let subject = "the textured reflectance of a conductor";
                self.output.approximated(&self.parameters.place, subject, "it is the same at all angles");
                texture.put(bsdf, "specular_reflectance")
            }
        };
        Ok(self.two_sided(bsdf))
    }

    /// The part "eta" or "k" of a metal's index, copper's by default.
    fn metal(&mut self, name: &str, part: &str) -> Result<[f64; 3], SceneError> {
        let copper = if part == "eta" { [0.201, 0.924, 1.102] } else { [3.913, 2.453, 2.142] };
        match self.parameters.find(name) {
            Some(parameter) => spectrum::read(parameter, Purpose::Index, self.output),
            None => Ok(copper),
        }
    }

    fn dielectric(&mut self) -> Result<Draft, SceneError> {
        let alpha = self.alpha("", 0.0, true)?;
        let bsdf = self.rough(["dielectric", "roughdielectric"], alpha);
        self.index(bsdf)
    }

    /// Gives a bsdf the index of refraction against vacuum.
    fn index(&mut self, bsdf: Draft) -> Result<Draft, SceneError> {
        let eta = match self.parameters.find("eta") {
            None => 1.5,
            Some(parameter) => {
                let [red, green, blue] = spectrum::read(parameter, Purpose::Index, self.output)?;
                if (red, green) != (green, blue) {
                    let subject = "an index of refraction that depends on color";
                    self.output.approximated(&parameter.place, subject, "the one of green counts");
                }
                green
            }
        };
        Ok(bsdf.with_float("int_ior", eta).with_float("ext_ior", 1.0))
    }

    fn diffuse_transmission(&mut self) -> Result<Draft, SceneError> {
        let scale = self.parameters.float("scale")?.unwrap_or(1.0);
        let mut part = |name: &str| -> Result<ColorOrTexture, SceneError> {
            self.share(name, 0.25)?.scaled([scale; 3], self.parameters, self.output)
        };
        let (reflectance, transmittance) = (part("reflectance")?, part("transmittance")?);
        // Both parts must stay below 1 after they are divided by their weights.
        let most = |value: &ColorOrTexture| match value {
            ColorOrTexture::Color(rgb) => rgb.iter().fold(0.0, |most: f64, channel| most.max(*channel)),
            ColorOrTexture::Texture(_) => 0.5,
        };
        let (front, back) = (most(&reflectance), most(&transmittance));
        let weight = if front + back > 0.0 { back / (front + back) } else { 0.5 };
        let (reflecting, passing) = (self.bsdf("diffuse"), self.bsdf("difftrans"));
        let divided = |value: &ColorOrTexture, weight: f64, output: &mut Output<'_>| {
            value.scaled([if weight > 0.0 { 1.0 / weight } else { 0.0 }; 3], self.parameters, output)
        };
        let reflecting = divided(&reflectance, 1.0 - weight, self.output)?.put(reflecting, "reflectance");
        let passing = divided(&transmittance, weight, self.output)?.put(passing, "transmittance");
        let blend = self.bsdf("blendbsdf").with_float("weight", weight);
        Ok(blend.with_child("", self.two_sided(reflecting)).with_child("", passing))
    }

    fn mix(&mut self, named: &HashMap<String, Material>) -> Result<Draft, SceneError> {
        let parameter = self.parameters.find("materials");
        let names = match parameter.map(|parameter| &parameter.values) {
            Some(Values::Texts(names)) if names.len() == 2 => names,
            _ => {
                let problem = "a mix does not name two \"materials\"";
                return Err(SceneError::new(
                    &self.parameters.place,
                    problem,
                    "write \"string materials\" [ \"a\" \"b\" ]",
                ));
            }
        };
        let amount = self.textures.number(self.parameters, "amount")?.unwrap_or(ColorOrTexture::Color([0.5; 3]));
        self.textured |= amount.is_texture();
        let mut blend = amount.put_number(self.bsdf("blendbsdf"), "weight");
        for name in names {
            let part = find(named, name, self.parameters)?;
            self.textured |= part.textured;
            blend = blend.with_reference(&part.id);
        }
        Ok(blend)
    }

    /// The first of two plugins, or the second with its roughness.
    fn rough(&self, [smooth, rough]: [&str; 2], alpha: Option<[ColorOrTexture; 2]>) -> Draft {
        let Some([u, v]) = alpha else { return self.bsdf(smooth) };
        let bsdf = self.bsdf(rough).with_text("distribution", "ggx");
        match (&u, &v) {
            (ColorOrTexture::Color(u), ColorOrTexture::Color(v)) if u == v => bsdf.with_float("alpha", u[0]),
            _ => v.put_number(u.put_number(bsdf, "alpha_u"), "alpha_v"),
        }
    }

    /// α along u and v, unless it is so small that pbrt makes a mirror.
    fn alpha(
        &mut self,
        prefix: &str,
        default: f64,
        anisotropic: bool,
    ) -> Result<Option<[ColorOrTexture; 2]>, SceneError> {
        let remap = self.parameters.flag("remaproughness")?.unwrap_or(true);
        let place = &self.parameters.place;
        let common = self.textures.number(self.parameters, &format!("{prefix}roughness"))?;
        let common = common.unwrap_or(ColorOrTexture::Color([default; 3]));
        let mut along = |axis: &str| -> Result<ColorOrTexture, SceneError> {
            let own = self.textures.number(self.parameters, &format!("{prefix}{axis}roughness"))?;
            Ok(match own.unwrap_or_else(|| common.clone()) {
                ColorOrTexture::Color([roughness, ..]) if !(0.0..=100.0).contains(&roughness) => {
                    let problem = format!("a roughness of {}", shown_number(roughness));
                    return Err(SceneError::new(place, problem, "give a number from 0 to 1"));
                }
                ColorOrTexture::Color([roughness, ..]) if remap => ColorOrTexture::Color([roughness.sqrt(); 3]),
                texture if remap && texture.is_texture() => {
                    let instead = "the texture is α itself, not its square: add \"bool remaproughness\" false";
                    self.output.approximated(place, "a textured roughness that is remapped", instead);
                    texture
                }
                value => value,
            })
        };
        let both = [along("u")?, along("v")?];
        self.textured |= both.iter().any(ColorOrTexture::is_texture);
        Ok(match both {
            [ColorOrTexture::Color([u, ..]), ColorOrTexture::Color([v, ..])] if u.max(v) < SMOOTH => None,
            [ColorOrTexture::Color([u, ..]), ColorOrTexture::Color([v, ..])] if !anisotropic && u != v => {
                self.output.approximated(place, "an anisotropic coat", "the mean of its roughnesses counts");
                Some([ColorOrTexture::Color([0.5 * (u + v); 3]), ColorOrTexture::Color([0.5 * (u + v); 3])])
            }
            both => Some(both.map(|value| match value {
                ColorOrTexture::Color([alpha, ..]) => ColorOrTexture::Color([alpha.max(1e-4); 3]),
                texture => texture,
            })),
        })
    }
}

/// The material of a name.
pub(super) fn find<'a>(
    named: &'a HashMap<String, Material>,
    name: &str,
    parameters: &Parameters,
) -> Result<&'a Material, SceneError> {
    named.get(name).ok_or_else(|| {
        let mut known: Vec<&str> = named.keys().map(String::as_str).filter(|name| name.len() < 80).collect();
        known.sort_unstable();
        let problem = format!("no material {} was made before", shown(name));
        let remedy = nearest_defined_name(name, &known, "make it with MakeNamedMaterial first");
        SceneError::new(&parameters.place, problem, remedy)
    })
}

/// What a shape without a material has: a two-sided matte grey.
pub(super) fn default(place: &Location) -> Draft {
    let grey = Draft::new(PluginClass::Bsdf, "diffuse", place).with_rgb("reflectance", [0.5; 3]);
    Draft::new(PluginClass::Bsdf, "twosided", place).with_child("", grey)
}
