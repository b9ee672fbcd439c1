//! `<Materials>` as bsdfs.
//!
//! | material | bsdf |
//! |---|---|
//! | diffuse | `diffuse` |
//! | specular | `ward` of the lobe's width and share, with the diffuse part; `roughplastic` for `TorranceSparrow` |
//! | mirror | `conductor` (`none`); with other parts a `blendbsdf` |
//! | `type="conductor"` | `conductor` of that index |
//! | `type="dielectric"`, or with transparency | `dielectric` |
//! | `Roughness` of these | `roughconductor`, `roughdielectric` |
//!
//! In scenes without any normalized BRDF light is reflected without 1/π. There reflectances are divided by π, and
//! lights multiplied by it, so that what lights light directly looks the same and nothing reflects more than it gets.

use std::collections::HashSet;
use std::f64::consts::PI;

use super::super::draft::Draft;
use super::super::notices::Notices;
use super::super::values::shown;
use super::element::Element;
use super::reflection::{Reflection, Reflections};
use crate::scene::description::PluginClass;
use crate::scene::error::{SceneError, nearest_name};
use crate::scene::notice::Notice;

const TAGS: [&str; 10] = [
    "AmbientReflectance",
    "DiffuseReflectance",
    "SpecularReflectance",
    "MirrorReflectance",
    "PhongExponent",
    "Transparency",
    "RefractionIndex",
    "AbsorptionIndex",
    "AbsorptionCoefficient",
    "Roughness",
];
const TYPES: [&str; 3] = ["mirror", "conductor", "dielectric"];
/// What `degamma` undoes.
const GAMMA: f64 = 2.2;
/// A little less than 1, so that the sum of rounded shares is not more.
const MOST: f64 = 1.0 - 1e-6;

type Color = [f64; 3];

/// The materials of a scene.
pub(super) struct Materials {
    /// In the order of the file.
    pub bsdfs: Vec<Draft>,
    ids: HashSet<String>,
    /// Factor on all lights.
    pub light_scale: f64,
    /// Whether any of them reflects or refracts as a smooth surface does.
    pub any_specular: bool,
}

impl Materials {
    /// Reads the scene's `<BRDFs>` and `<Materials>`.
    pub(super) fn read(scene: &Element<'_>, notices: &mut Notices) -> Result<Self, SceneError> {
        let reflections = Reflections::read(scene, notices)?;
        let mut all = Self { bsdfs: Vec::new(), ids: HashSet::new(), light_scale: 1.0, any_specular: false };
        let Some(list) = scene.child("Materials")? else { return Ok(all) };
        list.report_unknown(&["Material"], &[], notices);
        let mut read = Vec::new();
        for element in list.all("Material") {
            read.push(Material::read(element, &reflections, notices)?);
        }
        let mut reflecting = read.iter().filter(|material| material.reflects()).peekable();
        if reflecting.peek().is_some() && reflecting.all(|material| !material.reflection.is_normalized()) {
            all.light_scale = PI;
            let explanation = "they are divided by π, and all lights multiplied by it";
            notices.add(Notice::approximated(&list.location(), "reflectances without 1/π", explanation));
        }
        for (index, material) in read.iter().enumerate() {
            let id = material.element.attribute("id").map_or_else(|| (index + 1).to_string(), str::to_owned);
            if !all.ids.insert(id.clone()) {
                let problem = format!("the id {} is given twice", shown(&id));
                return Err(material.element.error(problem, "give every material an id of its own"));
            }
            all.any_specular |= material.dielectric || material.mirror != [0.0; 3];
            let bsdf = material.bsdf(1.0 / all.light_scale, notices)?;
            all.bsdfs.push(Draft { id: bsdf_id(&id), ..bsdf });
        }
        Ok(all)
    }

    /// The id of the bsdf of an object; the object's `<Material>` says which.
    pub(super) fn of(&self, object: &Element<'_>) -> Result<String, SceneError> {
        let element = object.required("Material")?;
        let id = element.word()?;
        if self.ids.contains(id) {
            return Ok(bsdf_id(id));
        }
        let mut known: Vec<&str> = self.ids.iter().map(String::as_str).collect();
        known.sort_unstable();
        Err(element.error(format!("there is no material {}", shown(id)), nearest_name(id, &known)))
    }
}

fn bsdf_id(id: &str) -> String {
    format!("material-{id}")
}

struct Material<'a> {
    element: Element<'a>,
    reflection: Reflection,
    diffuse: Color,
    specular: Color,
    mirror: Color,
    dielectric: bool,
}

impl<'a> Material<'a> {
    fn read(element: Element<'a>, reflections: &Reflections, notices: &mut Notices) -> Result<Self, SceneError> {
        element.report_unknown(&TAGS, &["type", "BRDF", "degamma"], notices);
        let kind = element.attribute("type").unwrap_or_default();
        if !kind.is_empty() && !TYPES.contains(&kind) {
            let problem = format!("there is no type {} of materials", shown(kind));
            return Err(element.error(problem, nearest_name(kind, &TYPES)));
        }
        let gamma = if element.flag("degamma")? { GAMMA } else { 1.0 };
        let color = |tag: &str| Ok(element.color_of(tag)?.map(|channel| libm::pow(channel, gamma)));
        let transparent = element.color_of("Transparency")? != [0.0; 3];
        Ok(Self {
            element,
            reflection: reflections.of(&element)?,
            diffuse: color("DiffuseReflectance")?,
            specular: color("SpecularReflectance")?,
            mirror: color("MirrorReflectance")?,
            dielectric: transparent || kind == "dielectric",
        })
    }

    /// Whether its BRDF reflects anything.
    fn reflects(&self) -> bool {
        !self.dielectric && (self.diffuse != [0.0; 3] || self.specular != [0.0; 3])
    }

    fn plugin(&self, name: &str) -> Draft {
        Draft::new(PluginClass::Bsdf, name, &self.element.location())
    }

    fn approximated(&self, subject: &str, explanation: &str, notices: &mut Notices) {
        notices.add(Notice::approximated(&self.element.location(), subject, explanation));
    }

    /// The bsdf; `scale` is a factor on what the BRDF reflects.
    fn bsdf(&self, scale: f64, notices: &mut Notices) -> Result<Draft, SceneError> {
        if self.dielectric {
            return self.glass(notices);
        }
        let factor = |share: f64| move |channel: f64| channel * share * scale;
        let mut diffuse = self.diffuse.map(factor(self.reflection.diffuse_share()));
        let mut specular = self.specular.map(factor(self.reflection.specular_share()));
        let mut mirror = self.mirror;
        // What Fresnel's reflectance leaves goes into the diffuse part.
        let together = |channel: usize| match self.reflection.has_fresnel() {
            true => diffuse[channel].max(specular[channel]),
            false => diffuse[channel] + specular[channel],
        };
        let base = (0..3).map(together).fold(0.0, f64::max);
        let sum = base + brightest(mirror);
        if sum > 1.0 {
            let explanation = "all of its reflectances are scaled down, so that it reflects no more than arrives";
            self.approximated("a material that makes light", explanation, notices);
        }
        if sum > MOST {
            for part in [&mut diffuse, &mut specular, &mut mirror] {
                *part = part.map(|channel| channel * MOST / sum);
            }
        }
        let weight = brightest(self.mirror) / sum;
        if mirror == [0.0; 3] {
            return Ok(self.base(diffuse, specular, notices));
        }
        if base == 0.0 {
            return self.metal(mirror, notices);
        }
        // Chosen in proportion to their brightest channels and divided by that, both parts keep their shares.
        let base = self.base(diffuse.map(|c| c / (1.0 - weight)), specular.map(|c| c / (1.0 - weight)), notices);
        let metal = self.metal(mirror.map(|channel| channel / weight), notices)?;
        Ok(self.plugin("blendbsdf").with_float("weight", weight).with_child("", base).with_child("", metal))
    }

    /// The diffuse and the glossy part.
    fn base(&self, diffuse: Color, specular: Color, notices: &mut Notices) -> Draft {
        let alpha = self.reflection.alpha();
        let subject = format!("<{}>", self.reflection.name());
        if specular == [0.0; 3] {
            return self.plugin("diffuse").with_rgb("reflectance", diffuse);
        }
        if self.reflection.has_fresnel() && self.reflection.index != 1.0 {
            let explanation =
                "a roughplastic of the same roughness and reflectance from straight above takes its place";
            self.approximated(&subject, explanation, notices);
            // Indices n and 1/n reflect the same from straight above.
            let index = self.reflection.index.max(1.0 / self.reflection.index);
            return self
                .plugin("roughplastic")
                .with_float("int_ior", index)
                .with_float("ext_ior", 1.0)
                .with_float("alpha", alpha)
                .with_rgb("diffuse_reflectance", diffuse)
                .with_rgb("specular_reflectance", specular);
        }
        self.approximated(&subject, "a ward with a lobe of the same width and share takes its place", notices);
        self.plugin("ward")
            .with_float("alpha_u", alpha)
            .with_float("alpha_v", alpha)
            .with_rgb("diffuse_reflectance", diffuse)
            .with_rgb("specular_reflectance", specular)
    }

    fn metal(&self, reflectance: Color, notices: &mut Notices) -> Result<Draft, SceneError> {
        let metal = self.roughened("conductor", notices)?.with_rgb("specular_reflectance", reflectance);
        if self.element.attribute("type") != Some("conductor") {
            return Ok(metal.with_text("material", "none"));
        }
        let [eta, k] = ["RefractionIndex", "AbsorptionIndex"].map(|tag| self.element.required(tag));
        Ok(metal.with_rgb("eta", [eta?.number()?; 3]).with_rgb("k", [k?.number()?; 3]))
    }

    fn glass(&self, notices: &mut Notices) -> Result<Draft, SceneError> {
        for (tag, color) in [("Diffuse", self.diffuse), ("Specular", self.specular), ("Mirror", self.mirror)] {
            if color != [0.0; 3] {
                let subject = format!("<{tag}Reflectance> of a transparent material");
                notices.add(Notice::ignored(&self.element.location(), subject, "it reflects as a dielectric does"));
            }
        }
        let transmitted = match self.element.child("Transparency")? {
            Some(transparency) => transparency.color()?,
            None => self.element.color_of("AbsorptionCoefficient")?.map(|per_meter| libm::exp(-per_meter)),
        };
        if transmitted != [1.0; 3] {
            let explanation = "what one unit of length absorbs is absorbed at the two surfaces";
            self.approximated("absorption inside of a transparent material", explanation, notices);
        }
        if brightest(transmitted) > 1.0 {
            return Err(self.element.error("the transparency is above 1", "write numbers up to 1"));
        }
        Ok(self
            .roughened("dielectric", notices)?
            .with_float("int_ior", self.element.required("RefractionIndex")?.number()?)
            .with_float("ext_ior", 1.0)
            .with_rgb("specular_transmittance", transmitted.map(f64::sqrt)))
    }

    /// A smooth plugin, or the rough one for the material's `<Roughness>`: that moves the end of the mirrored unit vector within
    /// a square of this side. The half vector moves half as far, along each axis by roughness/(2·√12) on average, and
    /// α is √2 times that.
    fn roughened(&self, smooth: &str, notices: &mut Notices) -> Result<Draft, SceneError> {
        let alpha = self.element.number_of("Roughness")?.unwrap_or(0.0) / f64::sqrt(24.0);
        if alpha < 1e-4 {
            return Ok(self.plugin(smooth));
        }
        self.approximated("<Roughness>", "a Beckmann surface of the same spread takes its place", notices);
        Ok(self.plugin(&format!("rough{smooth}")).with_float("alpha", alpha))
    }
}

fn brightest(color: Color) -> f64 {
    color.into_iter().fold(0.0, f64::max)
}
