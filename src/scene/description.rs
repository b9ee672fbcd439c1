//! The scene description: the tree a user wrote, after includes, defaults and references are resolved and before
//! anything is interpreted. Every format is imported into this tree; only [`super::prepare`] reads it.

use std::sync::Arc;

use glam::DMat4;

use super::bundle::Bundle;
use super::error::Location;
use super::notice::Notice;

/// What a plugin is for; the tag in XML, the kind of slot it may stand in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PluginClass {
    /// The root `<scene>`.
    Scene,
    /// A method with its parameters.
    Integrator,
    /// A camera.
    Sensor,
    /// The picture's size and reconstruction filter holder.
    Film,
    /// A reconstruction filter.
    ReconstructionFilter,
    /// Mitsuba's random number source; read for checking, not used.
    Sampler,
    /// A surface.
    Shape,
    /// A material.
    Bsdf,
    /// A light.
    Emitter,
    /// A texture.
    Texture,
    /// A participating medium.
    Medium,
    /// Where a medium scatters light to.
    Phase,
    /// What varies within a medium.
    Volume,
}

impl PluginClass {
    /// The XML tag of this class.
    pub fn tag(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Integrator => "integrator",
            Self::Sensor => "sensor",
            Self::Film => "film",
            Self::ReconstructionFilter => "rfilter",
            Self::Sampler => "sampler",
            Self::Shape => "shape",
            Self::Bsdf => "bsdf",
            Self::Emitter => "emitter",
            Self::Texture => "texture",
            Self::Medium => "medium",
            Self::Phase => "phase",
            Self::Volume => "volume",
        }
    }
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `<integer>`
    Integer(i64),
    /// `<float>`
    Float(f64),
    /// `<boolean>`
    Boolean(bool),
    /// `<string>`
    String(String),
    /// `<rgb>`, and `<spectrum>` when it is a single number (then grey). Linear Rec. 709.
    Rgb([f64; 3]),
    /// `<point>` and `<vector>`
    Vector([f64; 3]),
    /// `<transform>`: column vectors, `p' = M p`; steps already multiplied in the order they apply.
    Transform(DMat4),
}

impl Value {
    /// The name of the value's type as a user knows it.
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::Integer(_) => "integer",
            Self::Float(_) => "float",
            Self::Boolean(_) => "boolean",
            Self::String(_) => "string",
            Self::Rgb(_) => "rgb",
            Self::Vector(_) => "vector",
            Self::Transform(_) => "transform",
        }
    }
}

/// One named value.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// The parameter's name, for example `int_ior`.
    pub name: String,
    /// Its value.
    pub value: Value,
    /// Where it stands.
    pub location: Location,
}

/// A nested plugin: `<bsdf …>` in a shape, or a resolved `<ref>`. Shared when several parents refer to it.
#[derive(Clone, Debug)]
pub struct Child {
    /// The slot's name when the user gave one (`<texture name="reflectance">`), else empty.
    pub name: String,
    /// The plugin.
    pub node: Arc<Node>,
}

/// One plugin with its parameters and nested plugins, in the user's order.
#[derive(Clone, Debug)]
pub struct Node {
    /// What it is for.
    pub class: PluginClass,
    /// The plugin's name: the XML `type` attribute, for example `dielectric`. For the scene itself: `scene`.
    pub plugin: String,
    /// The user's id, or empty. No two plugins have the same.
    pub id: String,
    /// What the file calls it where that is no id, as in formats in which several things may have one name; else empty.
    pub name: String,
    /// Plain values.
    pub parameters: Vec<Parameter>,
    /// Nested plugins.
    pub children: Vec<Child>,
    /// Where it stands.
    pub location: Location,
}

/// A whole scene as the user gave it: the resolved tree, and the files it refers to.
#[derive(Clone, Debug)]
pub struct SceneDescription {
    /// The `scene` node.
    pub root: Node,
    /// Where relative file names are looked up.
    pub bundle: Bundle,
    /// What the import approximated or ignored.
    pub notices: Vec<Notice>,
    /// From which moment to which something moves, in the scene's own unit of time; `None` where nothing does.
    pub moves: Option<[f64; 2]>,
}
