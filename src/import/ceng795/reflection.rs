//! `<BRDFs>`: how the diffuse and the specular reflectance of a material are meant.
//!
//! With r the mirrored direction, h the half vector and n the exponent, the specular term of a BRDF is
//!
//! | tag | specular term | α |
//! |---|---|---|
//! | `OriginalPhong` | cosⁿ∠(r, o) / cos θi | ½·√(2/(n+2)) |
//! | `ModifiedPhong` | cosⁿ∠(r, o), `normalized` times (n+2)/2π | ½·√(2/(n+2)) |
//! | `OriginalBlinnPhong` | cosⁿ∠(h, normal) / cos θi | √(2/(n+2)) |
//! | `ModifiedBlinnPhong` | cosⁿ∠(h, normal), `normalized` times (n+8)/8π | √(2/(n+2)) |
//! | `TorranceSparrow` | microfacets with Blinn's distribution of exponent n | √(2/(n+2)) |
//!
//! α is the roughness that gives a Gaussian of slopes the same peak as Blinn's distribution [Walter et al. 2007, sec. 5.2].
//! The mirrored direction turns twice as far as the half vector, hence the half. Materials without a BRDF have
//! `OriginalBlinnPhong` with their `PhongExponent`. The diffuse term is 1/π where the BRDF is normalized, else 1.

use std::f64::consts::PI;

use super::super::notices::Notices;
use super::super::values::shown;
use super::element::Element;
use crate::scene::error::{SceneError, nearest_name, shown_number};

/// The forms of the specular term.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    OriginalPhong,
    ModifiedPhong,
    OriginalBlinnPhong,
    ModifiedBlinnPhong,
    TorranceSparrow,
}

const FORMS: [(&str, Form); 5] = [
    ("OriginalPhong", Form::OriginalPhong),
    ("ModifiedPhong", Form::ModifiedPhong),
    ("OriginalBlinnPhong", Form::OriginalBlinnPhong),
    ("ModifiedBlinnPhong", Form::ModifiedBlinnPhong),
    ("TorranceSparrow", Form::TorranceSparrow),
];

/// One BRDF.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflection {
    form: Form,
    exponent: f64,
    normalized: bool,
    /// Index of refraction of `TorranceSparrow`.
    pub index: f64,
}

impl Reflection {
    /// What a material has without a BRDF of the scene.
    pub(super) fn of_material(material: &Element<'_>) -> Result<Self, SceneError> {
        let exponent = match material.child("PhongExponent")? {
            Some(element) => exponent(&element)?,
            None => 1.0,
        };
        Ok(Self { form: Form::OriginalBlinnPhong, exponent, normalized: false, index: 1.0 })
    }

    fn read(element: &Element<'_>, form: Form, notices: &mut Notices) -> Result<Self, SceneError> {
        let microfacets = form == Form::TorranceSparrow;
        let tags: &[&str] = if microfacets { &["Exponent", "RefractiveIndex"] } else { &["Exponent"] };
        element.report_unknown(tags, if microfacets { &["kdfresnel"] } else { &["normalized"] }, notices);
        let index = match microfacets {
            true => element.required("RefractiveIndex")?.number()?,
            false => 1.0,
        };
        if index <= 0.0 {
            return Err(element.error("the refractive index is not above 0", "write one such as 1.5"));
        }
        let normalized = microfacets || element.flag("normalized")?;
        Ok(Self { form, exponent: exponent(&element.required("Exponent")?)?, normalized, index })
    }

    /// Whether its diffuse term is 1/π, so that a reflectance is a share of light.
    pub(super) fn is_normalized(&self) -> bool {
        self.normalized
    }

    /// Whether it is made of microfacets with Fresnel's reflectance.
    pub(super) fn has_fresnel(&self) -> bool {
        self.form == Form::TorranceSparrow
    }

    /// Its tag.
    pub(super) fn name(&self) -> &'static str {
        FORMS.iter().find(|(_, form)| *form == self.form).map_or("", |(name, _)| name)
    }

    /// The roughness of the surface with a lobe of this width, at least the least one that materials have.
    pub(super) fn alpha(&self) -> f64 {
        const LEAST: f64 = 1e-4;
        let blinn = f64::sqrt(2.0 / (self.exponent + 2.0));
        let alpha = match self.form {
            Form::OriginalPhong | Form::ModifiedPhong => 0.5 * blinn,
            _ => blinn,
        };
        alpha.max(LEAST)
    }

    /// Share of light that a diffuse reflectance of 1 reflects.
    pub(super) fn diffuse_share(&self) -> f64 {
        if self.normalized { 1.0 } else { PI }
    }

    /// Share of light from straight above that a specular reflectance of 1 reflects: the integral of the term over the
    /// directions, of which the half vector of Blinn's reaches 45° from the normal.
    pub(super) fn specular_share(&self) -> f64 {
        let n = self.exponent;
        // ∫ 4 cosᵐ⁻¹θ dω over half vectors up to 45°, over 8π.
        let cap = |m: f64| (1.0 - libm::pow(2.0, -0.5 * m)) / m;
        match (self.form, self.normalized) {
            (Form::OriginalPhong, _) => 2.0 * PI / (n + 1.0),
            (Form::ModifiedPhong, false) => 2.0 * PI / (n + 2.0),
            (Form::ModifiedPhong, true) | (Form::TorranceSparrow, _) => 1.0,
            (Form::OriginalBlinnPhong, _) => 8.0 * PI * cap(n + 2.0),
            (Form::ModifiedBlinnPhong, false) => 8.0 * PI * (2.0 * cap(n + 4.0) - cap(n + 2.0)),
            (Form::ModifiedBlinnPhong, true) => (n + 8.0) * (2.0 * cap(n + 4.0) - cap(n + 2.0)),
        }
    }
}

fn exponent(element: &Element<'_>) -> Result<f64, SceneError> {
    let exponent = element.number()?;
    match exponent >= 0.0 {
        true => Ok(exponent),
        false => {
            Err(element.error(format!("the exponent is {}", shown_number(exponent)), "write a number of at least 0"))
        }
    }
}

/// The BRDFs of a scene by id.
pub(super) struct Reflections(Vec<(String, Reflection)>);

impl Reflections {
    /// Reads the scene's `<BRDFs>`, if it has any.
    pub(super) fn read(scene: &Element<'_>, notices: &mut Notices) -> Result<Self, SceneError> {
        let mut all = Vec::new();
        let Some(list) = scene.child("BRDFs")? else { return Ok(Self(all)) };
        list.report_unknown(&FORMS.map(|(tag, _)| tag), &[], notices);
        for (index, element) in list.elements().enumerate() {
            let Some((_, form)) = FORMS.iter().find(|(tag, _)| *tag == element.tag()) else { continue };
            let id = element.attribute("id").map_or_else(|| (index + 1).to_string(), str::to_owned);
            all.push((id, Reflection::read(&element, *form, notices)?));
        }
        Ok(Self(all))
    }

    /// The BRDF of a material.
    pub(super) fn of(&self, material: &Element<'_>) -> Result<Reflection, SceneError> {
        let Some(id) = material.attribute("BRDF") else { return Reflection::of_material(material) };
        self.0.iter().find(|(known, _)| known == id).map(|(_, reflection)| *reflection).ok_or_else(|| {
            let known: Vec<&str> = self.0.iter().map(|(known, _)| known.as_str()).collect();
            material.error(format!("there is no BRDF {}", shown(id)), nearest_name(id, &known))
        })
    }
}
