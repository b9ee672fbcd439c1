//! What `normalmap` and `bumpmap` share: a material whose shading normal is turned from place to place.
//!
//! | parameter | meaning | default |
//! |---|---|---|
//! | `flip_invalid_normals` | where the turned normal faces away from the viewer, it is turned to the opposite azimuth | true |
//! | `use_shadowing_function` | light at grazing angles is dimmed as by the microfacets that have the turned normal [ELS19, eqs. 1 and 4] | true |
//! | a nested bsdf | the surface | required |
//!
//! \[ELS19\] Estevez, Lecocq & Stein 2019, "A microfacet-based shadowing function to solve the bump terminator problem".
//!
//! The material inside answers in a frame of its own round the turned normal n'. The cosine of light is that with n', so the
//! value gets the factor `|cos θ'|/|cos θ|` of the light's direction. Light that is on one side of n' and on the other of the
//! smooth normal does not count. Which way n' is turned depends on the viewer: where flux is carried, the viewer is the
//! direction that the path goes on in, and both ways are sampled.

use super::{Lobes, Material, MaterialSample, SpecularLobes, TransportMode, View};
use crate::math::{Frame, Rgb, Vec3};
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::texture::TextureReader;

/// Where turned normals come from.
pub trait NormalSource: Sized {
    /// Reads the parameters.
    fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError>;

    /// The unit normal in the shading frame; none where it stays as it is.
    fn normal(&self, view: &View) -> Option<Vec3>;
}

/// A material with turned normals.
#[derive(Clone, Debug)]
pub struct TurnedNormal<Source> {
    source: Source,
    flips: bool,
    shadows: bool,
    material: Material,
}

/// The share of flux paths that is sampled about the flipped normal, which few viewers see.
const FLIPPED_SHARE: f32 = 0.25;

/// A normal and the frame round it.
#[derive(Clone, Copy)]
struct Turned {
    frame: Frame,
    /// The probability of sampling in this frame.
    share: f32,
}

impl Turned {
    /// The frame round `normal` whose tangent is as near as it can be to the shading frame's.
    fn new(normal: Vec3, share: f32) -> Self {
        let tangent = (Vec3::X - normal * normal.x).try_normalize();
        let frame = match tangent {
            Some(tangent) => Frame { tangent, bitangent: normal.cross(tangent), normal },
            None => Frame::from_normal(normal),
        };
        Self { frame, share }
    }

    fn view(&self, view: &View) -> View {
        View { outgoing: self.frame.to_local(view.outgoing), ..*view }
    }

    /// The local direction of a direction inside; none where it is on the other side of the smooth surface.
    fn leave(&self, inside: Vec3) -> Option<Vec3> {
        let direction = self.frame.to_world(inside);
        (direction.z * inside.z > 0.0).then_some(direction)
    }
}

/// The direction of the light among the two of a scattering.
#[inline]
fn light(view: &View, incident: Vec3) -> Vec3 {
    match view.mode {
        TransportMode::Radiance => incident,
        TransportMode::Flux => view.outgoing,
    }
}

/// The shadowing function for a turned normal and the direction of the light [ELS19]: GGX's masking at the roughness of which
/// the normal's slope is typical.
fn shadowing(normal: Vec3, light: Vec3) -> f32 {
    let tangent_squared = |direction: Vec3| (1.0 / (direction.z * direction.z) - 1.0).max(0.0);
    let roughness_squared = (0.125 * tangent_squared(normal)).min(1.0);
    2.0 / (1.0 + (1.0 + roughness_squared * tangent_squared(light)).sqrt())
}

impl<Source: NormalSource> TurnedNormal<Source> {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let source = Source::read(fields, textures)?;
        let flips = fields.boolean("flip_invalid_normals")?.unwrap_or(true);
        let shadows = fields.boolean("use_shadowing_function")?.unwrap_or(true);
        let Some(nested) = fields.child(PluginClass::Bsdf) else {
            let problem = format!("\"{}\" holds no bsdf", fields.node().plugin);
            return Err(SceneError::new(fields.location(), problem, "nest the bsdf of the surface"));
        };
        textures.ask_for_turned_normals();
        Ok(Self { source, flips, shadows, material: super::read(nested, textures)? })
    }

    /// The turned normal as `viewer` sees it, with `view`'s texture coordinates.
    fn normal_for(&self, view: &View, viewer: Vec3) -> Vec3 {
        let normal = self.source.normal(view).unwrap_or(Vec3::Z);
        let faces_away = viewer.z * viewer.dot(normal) <= 0.0;
        if self.flips && faces_away { Vec3::new(-normal.x, -normal.y, normal.z) } else { normal }
    }

    /// The normal where all that is known is `view`, for layers.
    pub fn normal(&self, view: &View) -> Vec3 {
        self.normal_for(view, view.outgoing)
    }

    /// The frames in which directions are sampled: the viewer's where radiance is carried, else both.
    fn frames(&self, view: &View) -> [Option<Turned>; 2] {
        if view.mode == TransportMode::Radiance {
            return [Some(Turned::new(self.normal(view), 1.0)), None];
        }
        let normal = self.source.normal(view).unwrap_or(Vec3::Z);
        if !self.flips || (normal.x == 0.0 && normal.y == 0.0) {
            return [Some(Turned::new(normal, 1.0)), None];
        }
        let flipped = Vec3::new(-normal.x, -normal.y, normal.z);
        [Some(Turned::new(normal, 1.0 - FLIPPED_SHARE)), Some(Turned::new(flipped, FLIPPED_SHARE))]
    }

    /// The frame in which the value of a scattering is asked.
    fn frame_of(&self, view: &View, incident: Vec3) -> Turned {
        let viewer = match view.mode {
            TransportMode::Radiance => view.outgoing,
            TransportMode::Flux => incident,
        };
        Turned::new(self.normal_for(view, viewer), 1.0)
    }

    /// What the value inside is multiplied with; 0 where the light is on different sides of the two normals.
    fn factor(&self, turned: &Turned, view: &View, incident: Vec3) -> f32 {
        let light = light(view, incident);
        let ratio = light.dot(turned.frame.normal) / light.z;
        match (ratio > 0.0, self.shadows) {
            (false, _) => 0.0,
            (true, true) => ratio * shadowing(turned.frame.normal, light),
            (true, false) => ratio,
        }
    }

    /// Samples the material inside, in one of its frames.
    pub fn sample(&self, view: &View, [u, v, mut choice]: [f32; 3]) -> Option<MaterialSample> {
        let [first, second] = self.frames(view);
        let mut turned = first?;
        if let Some(second) = second {
            if choice < second.share {
                (choice, turned) = (choice / second.share, second);
            } else {
                choice = (choice - second.share) / (1.0 - second.share);
            }
        }
        let inside = self.material.sample(&turned.view(view), [u, v, choice])?;
        let direction = turned.leave(inside.direction)?;
        if inside.is_specular() {
            return self.specular(&turned, view, inside).map(|sample| sample.scaled(1.0 / turned.share));
        }
        let response = (self.evaluate(view, direction), self.pdf(view, direction));
        MaterialSample::weighted(direction, response, inside.relative_index)
    }

    /// A specular direction of the material inside, where the viewer sees the normal turned so.
    fn specular(&self, turned: &Turned, view: &View, inside: MaterialSample) -> Option<MaterialSample> {
        let direction = turned.leave(inside.direction)?;
        if self.frame_of(view, direction).frame.normal != turned.frame.normal {
            return None;
        }
        let factor = self.factor(turned, view, direction);
        // The weight inside has the cosine there.
        let cosines = direction.z / inside.direction.z;
        (factor > 0.0).then(|| MaterialSample { direction, ..inside.scaled(factor * cosines.abs()) })
    }

    /// The material inside, in its frame.
    pub fn evaluate(&self, view: &View, incident: Vec3) -> Rgb {
        let turned = self.frame_of(view, incident);
        let factor = self.factor(&turned, view, incident);
        if factor == 0.0 {
            return Rgb::ZERO;
        }
        self.material.evaluate(&turned.view(view), turned.frame.to_local(incident)) * factor
    }

    /// The density inside; where flux is carried, the mixture of both frames'.
    pub fn pdf(&self, view: &View, incident: Vec3) -> f32 {
        let density = |turned: &Turned| {
            let inside = turned.frame.to_local(incident);
            let same_side = inside.z * incident.z > 0.0;
            if same_side { self.material.pdf(&turned.view(view), inside) * turned.share } else { 0.0 }
        };
        self.frames(view).iter().flatten().map(density).sum()
    }

    /// Those inside.
    pub fn lobes(&self) -> Lobes {
        self.material.lobes()
    }

    /// That inside.
    pub fn followed_share(&self, view: &View) -> f32 {
        let turned = Turned::new(self.normal(view), 1.0);
        self.material.followed_share(&turned.view(view))
    }

    /// Those inside.
    pub fn specular_lobes(&self, view: &View) -> SpecularLobes {
        let mut found = SpecularLobes::default();
        let mut places = found.iter_mut();
        for turned in self.frames(view).into_iter().flatten() {
            let inside = self.material.specular_lobes(&turned.view(view)).into_iter().flatten();
            for (sample, place) in inside.filter_map(|lobe| self.specular(&turned, view, lobe)).zip(&mut places) {
                *place = Some(sample);
            }
        }
        found
    }

    /// None: the cosines change it.
    pub fn constant_value(&self, _view: &View) -> Option<Rgb> {
        None
    }
}
