//! Methods: algorithms that turn a prepared scene into estimates. One self-contained file per method and one row in
//! [`METHODS`].

pub(crate) mod bdpm;
pub(crate) mod bdpt;
mod bidirectional_chains;
pub(crate) mod bidirectional_pass;
pub(crate) mod bidirectional_settings;
mod bounded_numbers;
pub(crate) mod chain_pass;
pub(crate) mod checked_method;
pub(crate) mod error;
pub(crate) mod gather_ends;
pub(crate) mod light_groups;
pub(crate) mod light_tracing;
pub(crate) mod mlt;
pub(crate) mod mmlt;
pub(crate) mod parameter_values;
pub(crate) mod parameters;
pub(crate) mod path;
pub(crate) mod pbdpm;
pub(crate) mod photon_map;
pub(crate) mod photon_pass;
pub(crate) mod pilot;
pub(crate) mod ppm;
pub(crate) mod shared_parameters;
pub(crate) mod sppm;
pub(crate) mod vcm;
pub(crate) mod visibility_pilot;
mod whole_paths;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};

use crate::estimate::{Declaration, Region, ShardSums};
use crate::scene::Scene;
use crate::scene::error::closest_name;
use crate::scene::light::emission_guide::EmissionGuide;
use crate::scene::material::Lobes;
use crate::transport::Counters;

pub use crate::scene::light::emission_guide::MOST_VALUES as MOST_GUIDE_VALUES;
pub use crate::scene::light::visibility::MOST_VALUES as MOST_VISIBILITY_VALUES;

pub use checked_method::{CheckedMethod, Contradiction, Gathering, ParameterizedMethod};
pub use error::MethodError;
pub use light_groups::check_light_groups;
pub use parameters::ParameterHelp;

/// One method of the table.
pub struct MethodEntry {
    /// The name that users write.
    pub name: &'static str,
    /// What other renderers and people call it.
    pub also_called: &'static [&'static str],
    /// What it does, in one line.
    pub summary: &'static str,
    /// Paths that it cannot sample, in one line.
    pub cannot_sample: &'static str,
    /// Where it was published.
    pub reference: &'static str,
    /// What becomes of its bias as passes are added.
    pub bias: Bias,
    /// Its parameters.
    pub parameters: &'static [ParameterHelp],
    /// Whether it takes filters with negative lobes as they are; else they become `gaussian`. Weights of both signs leave
    /// every mean right, but even where a picture is even they are noise, which only methods do not mind whose paths are as
    /// noisy.
    pub negative_lobes: bool,
    /// Whether it renders media that scatter light, or absorb unevenly.
    pub media: bool,
    /// Reads its parameters.
    read: ReadParameters,
}

/// The method's name and what a user gave to its parameters.
type ReadParameters =
    fn(&'static str, &serde_json::Map<String, serde_json::Value>) -> Result<Box<dyn ParameterizedMethod>, MethodError>;

/// The part of a method's error that no averaging removes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bias {
    /// Every pass is right on average.
    None,
    /// It goes with the gather radius, whose square falls as passes^(α − 1).
    Shrinks,
    /// The same, but the smaller the radius, the less counts what is gathered: connections take over [Georgiev et al. 2012].
    TakenOver,
    /// More passes leave it as it is.
    Stays,
}

/// All methods; the first is the default.
pub const METHODS: &[MethodEntry] = &[
    sppm::ENTRY,
    ppm::ENTRY,
    path::ENTRY,
    bdpt::ENTRY,
    light_tracing::ENTRY,
    photon_map::ENTRY,
    bdpm::ENTRY,
    pbdpm::ENTRY,
    vcm::ENTRY,
    mmlt::ENTRY,
    mlt::ENTRY,
    photon_map::mps::ENTRY,
];

/// A way of finding paths of a length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Strategy {
    /// Segments of the paths.
    pub segments: u32,
    /// Vertices of the light subpath, 0 where the camera subpath hits a light; segments where subpaths are merged.
    pub light: u32,
    /// Vertices of the camera subpath; segments where subpaths are merged.
    pub camera: u32,
}

impl Strategy {
    /// Whether it merges subpaths, which adds no segment between them.
    pub fn merges(self) -> bool {
        self.light + self.camera == self.segments
    }
}

/// What of a scene decides whether a method finds all its light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneTraits {
    /// Lights that directions never hit: point, spot and directional ones.
    pub point_lights: bool,
    /// Mirrors, glass and other perfectly specular surfaces.
    pub specular: bool,
    /// A reconstruction filter with negative lobes.
    pub negative_lobes: bool,
    /// Media that scatter light, or absorb unevenly.
    #[serde(default)]
    pub media: bool,
    /// Nearly all light meets mirrors or glass first, so that hardly any point sees a lamp.
    #[serde(default)]
    pub sealed_lights: bool,
}

impl SceneTraits {
    /// Looks at a scene.
    pub fn of(scene: &Scene) -> Self {
        Self {
            point_lights: scene.lights.has_points(),
            specular: scene.lobes().any(Lobes::SPECULAR),
            negative_lobes: scene.film.filter.has_negative_lobes(),
            media: scene.has_scattering_media(),
            sealed_lights: scene.has_sealed_lights(),
        }
    }
}

/// A method prepared for one scene, with its parameters and the job's seed. Every function is pure.
pub trait PreparedMethod: Send + Sync {
    /// Adds pass `pass` to the region's `sums`, as far as the method declares them; `None` when `cancel` was set meanwhile, and then the sums
    /// are of no use. Runs on the calling rayon pool.
    fn trace_pass(&self, pass: &Pass<'_>, sums: &mut ShardSums, cancel: &AtomicBool) -> Option<Counters>;

    /// Finds what is needed before the first pass, and counts what a pass costs; `None` when cancelled.
    fn pilot(&self, cancel: &AtomicBool) -> Option<PilotPass>;
}

/// The name of the pilot's field of first radii², m², one per pixel of the picture.
pub const FIRST_RADIUS_SQUARED: &str = "first_radius_squared";

/// The name of the pilot's field that says where photons start, an [`EmissionGuide`] as numbers; absent for emission by power.
pub const EMISSION_GUIDE: &str = "emission_guide";

/// The name of the pilot's field that says which lights are seen where, a [`LightVisibility`](crate::scene::light::LightVisibility) as
/// numbers; absent where picks do without.
pub const LIGHT_VISIBILITY: &str = "light_visibility";

/// Numbers that a pilot finds, by name.
#[derive(Clone, Debug, PartialEq)]
pub struct PilotField {
    /// What they are, for example [`FIRST_RADIUS_SQUARED`].
    pub name: String,
    /// One per pixel, or as many as the method needs.
    pub values: Vec<f32>,
}

/// What a pilot finds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PilotPass {
    /// What passes need: first radii where the method gathers.
    pub fields: Vec<PilotField>,
    /// What a pass costs.
    pub counters: Counters,
}

impl PilotPass {
    /// First radii² of all pixels, and what a pass costs.
    pub fn with_radii(radius_squared: Vec<f32>, counters: Counters) -> Self {
        let field = PilotField { name: FIRST_RADIUS_SQUARED.to_owned(), values: radius_squared };
        Self { fields: vec![field], counters }
    }

    /// The same, with a guide if there is one.
    #[must_use]
    pub fn and_guide(mut self, guide: Option<Vec<f32>>) -> Self {
        let field = |values| PilotField { name: EMISSION_GUIDE.to_owned(), values };
        self.fields.extend(guide.map(field));
        self
    }

    /// A method without radii has only costs to find: those of a pass that nobody looks at. `None` when cancelled.
    pub fn of_a_pass(method: &impl PreparedMethod, scene: &Scene, cancel: &AtomicBool) -> Option<Self> {
        let region = Region { row_start: 0, row_end: scene.height };
        let pass =
            Pass { index: u32::MAX, region, radius_squared: &[], scale: 1.0, typical_radius_squared: 1.0, guide: None };
        let mut nobody_looks = ShardSums::zero(scene.pixel_count());
        Some(Self::without_fields(method.trace_pass(&pass, &mut nobody_looks, cancel)?))
    }

    /// Costs, and no radii.
    pub fn without_fields(counters: Counters) -> Self {
        Self { fields: Vec::new(), counters }
    }
}

/// One pass of a region.
#[derive(Clone, Copy, Debug)]
pub struct Pass<'a> {
    /// Index of the pass in the job.
    pub index: u32,
    /// The pixels.
    pub region: Region,
    /// R² of the region's pixels in its radius field, m²; empty for methods that gather nothing.
    pub radius_squared: &'a [f32],
    /// ρ: this pass gathers with ρ·R² and divides flux and counts by ρ.
    pub scale: f32,
    /// Typical R² of this pass over the whole picture, m².
    pub typical_radius_squared: f32,
    /// Where photons start; by power without one.
    pub guide: Option<&'a EmissionGuide>,
}

/// A method by name, with the parameters that the user set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MethodChoice {
    /// Name in the table, for example `sppm`.
    pub name: String,
    /// Parameters by name; whatever is missing takes its default.
    #[serde(default)]
    pub parameters: serde_json::Map<String, serde_json::Value>,
}

/// The table.
pub fn table() -> &'static [MethodEntry] {
    METHODS
}

/// The row of a method.
pub fn entry(name: &str) -> Result<&'static MethodEntry, MethodError> {
    METHODS
        .iter()
        .find(|entry| entry.name == name)
        .ok_or_else(|| MethodError::Unknown { name: name.to_owned(), remedy: remedy_for_unknown(name) })
}

/// What to write in place of a method that does not exist: what others call so, or what has nearly that name; and all there are.
fn remedy_for_unknown(name: &str) -> String {
    let plain = name.to_ascii_lowercase().replace(['-', ' '], "_");
    let is_called = |entry: &&MethodEntry| entry.name == plain || entry.also_called.contains(&plain.as_str());
    let known: Vec<&str> = METHODS.iter().map(|entry| entry.name).collect();
    let all = known.join(", ");
    match METHODS.iter().find(is_called) {
        Some(entry) => format!("it is called \"{}\" here; methods: {all}", entry.name),
        None => match closest_name(name, known) {
            Some(close) => format!("did you mean \"{close}\"? Methods: {all}"),
            None => format!("methods: {all}"),
        },
    }
}

/// Checks a choice against the table. `pixels` is the picture's size, from which `photons_per_pass: auto` follows.
///
/// # Errors
/// An unknown method, parameters that it cannot take, and such that leave no path to find.
pub fn check(choice: &MethodChoice, pixels: u64) -> Result<CheckedMethod, MethodError> {
    let method = CheckedMethod::new(choice, pixels)?;
    method.refuse(method.parameters.contradiction()).map(|()| method)
}

/// The strategies of a choice: of the paths that it looks at, else of all from 2 to `longest` segments.
///
/// # Errors
/// The method does not tell strategies apart, or a parameter is wrong.
pub fn strategies(choice: &MethodChoice, longest: u32) -> Result<Vec<Strategy>, MethodError> {
    let entry = entry(&choice.name)?;
    let parameters = (entry.read)(entry.name, &choice.parameters)?;
    parameters.strategies(longest).ok_or_else(|| {
        let tells = |entry: &&MethodEntry| {
            (entry.read)(entry.name, &serde_json::Map::new()).is_ok_and(|defaults| defaults.strategies(2).is_some())
        };
        let able: Vec<&str> = METHODS.iter().filter(tells).map(|entry| entry.name).collect();
        let problem = "it does not tell strategies apart".to_owned();
        MethodError::Parameter { method: entry.name, problem, remedy: format!("{} do", able.join(", ")) }
    })
}

/// What a user should know of light that a method never finds in a scene.
pub fn blind_spot(method: &CheckedMethod, traits: SceneTraits) -> Option<String> {
    let unseen = method.parameters.blind_to(traits)?;
    Some(format!("{} cannot find {unseen}.", method.entry.name))
}

/// What a user should know of a method in a scene: light that it never finds, parameters that do nothing there, and a filter that it
/// replaces.
pub fn notices(method: &CheckedMethod, traits: SceneTraits) -> Vec<String> {
    let entry = method.entry;
    let replaced = (traits.negative_lobes && !entry.negative_lobes).then(|| {
        let able = METHODS.iter().filter(|entry| entry.negative_lobes).map(|entry| entry.name);
        let able = able.collect::<Vec<_>>().join(", ");
        format!(
            "{} replaces the film's filter, which has negative lobes, by \"gaussian\"; {able} take it as it is.",
            entry.name
        )
    });
    let futile = method.parameters.futile_in(traits).map(|what| format!("{}: {what}.", entry.name));
    blind_spot(method, traits).into_iter().chain(futile).chain(replaced).collect()
}

/// The power of time with which theory says that a method's mean square error falls, once there are many passes.
///
/// Without bias −1. Progressive density estimation has variance ∝ passes^−α and bias ∝ passes^(α − 1) [Knaus & Zwicker 2011,
/// section 4], so the slower of −α and −2(1 − α): −2/3 at α = 2/3, where both are the same; −1 where connections take over. A bias that stays is all
/// that is left in the end: 0.
pub fn theory_rate(method: &CheckedMethod) -> f64 {
    match (method.parameters.bias(method.entry.bias), method.parameters.gathering()) {
        (Bias::Shrinks, Gathering::ShrinkingDiscs { alpha, .. }) => -alpha.min(2.0 * (1.0 - alpha)),
        (Bias::None | Bias::Shrinks | Bias::TakenOver, _) => -1.0,
        (Bias::Stays, _) => 0.0,
    }
}

/// What the tallies of a checked method hold.
pub fn declaration(method: &CheckedMethod) -> Arc<Declaration> {
    let proposals = method.parameters.proposals().iter().map(|step| step.name());
    Arc::new(method.parameters.gathering().declaration().with_proposals(proposals))
}

/// Prepares a checked method for a scene.
///
/// # Errors
/// The scene has media that the method does not render.
pub fn prepare(scene: Arc<Scene>, method: &CheckedMethod, seed: u64) -> Result<Box<dyn PreparedMethod>, MethodError> {
    check_media(method, SceneTraits::of(&scene))?;
    check_in_scene(method, &scene)?;
    Ok(method.parameters.prepare(scene, method.photons_per_pass, seed))
}

/// Whether a scene can take a method's parameters that name places in it.
///
/// # Errors
/// It cannot, and why.
pub fn check_in_scene(method: &CheckedMethod, scene: &Scene) -> Result<(), MethodError> {
    method.refuse(method.parameters.refuses(scene))
}

/// Whether a method renders the media of a scene with such traits; all render those that only absorb.
///
/// # Errors
/// It does not, and which methods do.
pub fn check_media(method: &CheckedMethod, traits: SceneTraits) -> Result<(), MethodError> {
    if method.entry.media || !traits.media {
        return Ok(());
    }
    let able: Vec<&str> = METHODS.iter().filter(|entry| entry.media).map(|entry| entry.name).collect();
    let problem =
        "the scene has participating media that scatter light, or absorb unevenly, which it does not render".to_owned();
    Err(MethodError::Parameter { method: method.entry.name, problem, remedy: format!("{} does", able.join(", ")) })
}
