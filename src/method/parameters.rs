//! How a user's parameters become checked ones, and the parameters that several methods share.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::{CheckedMethod, MethodChoice, MethodError};
use crate::estimate::RadiusRule;
use crate::scene::error::nearest_name;
use crate::transport::Limits;

/// One parameter, as `photonfarm methods` and the documentation show it.
#[derive(Clone, Copy, Debug)]
pub struct ParameterHelp {
    /// Its name.
    pub name: &'static str,
    /// What it means, with its unit.
    pub meaning: &'static str,
    /// Values it may take.
    pub range: &'static str,
    /// What it is when the user does not give it.
    pub default: &'static str,
}

/// How light that arrives straight from a source is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DirectLight {
    /// Light and material sampling; photons count from their second surface on.
    #[default]
    Sample,
    /// By photons alone.
    Photons,
}

/// A number, or the word `auto`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Auto<T> {
    /// Chosen by the program.
    #[default]
    Auto,
    /// Chosen by the user.
    Value(T),
}

/// Parameters of `sppm` and `ppm`; [`HELP`] says what they mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ProgressiveParameters {
    /// α, between 0 and 1, 2/3 by default.
    pub alpha: f64,
    /// How radii shrink, `statistics` by default.
    pub radius_rule: RadiusRule,
    /// Photons emitted per pass, 1 to 2²⁶, or `auto`.
    pub photons_per_pass: Value,
    /// First gather radius, m, above 0, or `auto`.
    pub initial_radius: Value,
    /// Longest path in segments, 1 to 2³¹, or -1 for unlimited.
    pub max_depth: i64,
    /// Segments from which Russian roulette may end a path, at least 1.
    pub rr_depth: i64,
    /// How direct light is found.
    pub direct: DirectLight,
    /// Passes when the job names no stop rule, 1 to 2³¹.
    pub passes: u32,
    /// `ppm`: hit points per pixel, 1 to 64.
    pub samples_per_pixel: u32,
}

impl Default for ProgressiveParameters {
    fn default() -> Self {
        Self {
            alpha: 2.0 / 3.0,
            radius_rule: RadiusRule::Statistics,
            photons_per_pass: "auto".into(),
            initial_radius: "auto".into(),
            max_depth: -1,
            rr_depth: 1,
            direct: DirectLight::Sample,
            passes: 256,
            samples_per_pixel: 4,
        }
    }
}

/// What the parameters mean; `samples_per_pixel`, the last, is only `ppm`'s.
pub const HELP: &[ParameterHelp] = &[
    help("alpha", "share of each pass's photons that is kept as the radius shrinks", "above 0, below 1", "0.6667"),
    help("radius_rule", "how radii shrink", "statistics, schedule", "statistics"),
    help(
        "photons_per_pass",
        "photons emitted per pass",
        "1 to 67108864, auto",
        "auto: one per pixel, 65536 to 1048576",
    ),
    help("initial_radius", "first gather radius, m", "above 0, auto", "auto: per pixel by a pilot pass"),
    help("max_depth", "longest path in segments (2 is direct light)", "1 to 2147483648, -1 for unlimited", "-1"),
    help("rr_depth", "segments from which Russian roulette may end a path", "1 or more", "1"),
    help("direct", "how direct light is found", "sample, photons", "sample"),
    help("passes", "passes when no stop rule is given", "1 to 2147483648", "256"),
    help("samples_per_pixel", "hit points per pixel, fixed for the whole job", "1 to 64", "4"),
];

/// A row of a method's help.
pub const fn help(
    name: &'static str,
    meaning: &'static str,
    range: &'static str,
    default: &'static str,
) -> ParameterHelp {
    ParameterHelp { name, meaning, range, default }
}

/// The parameters of a method, with defaults, as users write them.
pub trait ParameterSet: DeserializeOwned + Serialize + Default {
    /// Names the first parameter that is out of its range.
    fn check_ranges(&self) -> Result<(), &'static str>;
}

/// Reads and checks parameters that a user gave; `known` are the method's.
pub fn read<P: ParameterSet>(
    method: &'static str,
    given: &Map<String, Value>,
    known: &[ParameterHelp],
) -> Result<P, MethodError> {
    let error = |problem: String, remedy: String| MethodError::Parameter { method, problem, remedy };
    for name in given.keys() {
        if !known.iter().any(|parameter| parameter.name == name) {
            let names: Vec<&str> = known.iter().map(|parameter| parameter.name).collect();
            return Err(error(format!("there is no parameter \"{name}\""), nearest_name(name, &names)));
        }
    }
    // One at a time, so that an error names its parameter.
    let mut all = Map::new();
    for (name, value) in given {
        let alone = Value::Object(Map::from_iter([(name.clone(), value.clone())]));
        if serde_json::from_value::<P>(alone).is_err() {
            return Err(error(format!("\"{name}\" is {value}"), range_of(name, known)));
        }
        all.insert(name.clone(), value.clone());
    }
    let parameters: P = serde_json::from_value(Value::Object(all))
        .map_err(|source| error(source.to_string(), "see photonfarm methods".to_owned()))?;
    parameters.check_ranges().map_err(|name| {
        let value = given.get(name).map_or("missing".to_owned(), Value::to_string);
        error(format!("\"{name}\" is {value}"), range_of(name, known))
    })?;
    Ok(parameters)
}

/// The choice of `method` with every default of `known` written out.
pub fn written_out<P: ParameterSet>(method: &str, parameters: P, known: &[ParameterHelp]) -> MethodChoice {
    let all = serde_json::to_value(parameters).unwrap_or_default();
    let parameters = known
        .iter()
        .filter_map(|parameter| Some((parameter.name.to_owned(), all.get(parameter.name)?.clone())))
        .collect();
    MethodChoice { name: method.to_owned(), parameters }
}

fn range_of(name: &str, known: &[ParameterHelp]) -> String {
    let range = known.iter().find(|parameter| parameter.name == name).map_or("", |parameter| parameter.range);
    format!("allowed: {range}")
}

/// The first of `checks` that is not good, as [`ParameterSet::check_ranges`] answers.
pub fn first_bad(checks: &[(&'static str, bool)]) -> Result<(), &'static str> {
    checks.iter().find(|(_, good)| !good).map_or(Ok(()), |(name, _)| Err(name))
}

/// A number of photons, 1 to 2²⁶, or `auto`; `None` for anything else.
pub fn photon_count(value: &Value) -> Option<Auto<u32>> {
    match value {
        Value::String(word) if word == "auto" => Some(Auto::Auto),
        value => {
            let count = value.as_u64().filter(|count| (1..=1 << 26).contains(count))?;
            Some(Auto::Value(count as u32))
        }
    }
}

/// The photons of a pass for a picture of so many pixels: `auto` is one per pixel, 65536 to 1048576.
pub fn photons_for(value: &Value, pixels: u64) -> u32 {
    match photon_count(value) {
        Some(Auto::Value(count)) => count,
        _ => pixels.clamp(1 << 16, 1 << 20) as u32,
    }
}

/// A radius above 0, m, or `auto`; `None` for anything else.
pub fn radius(value: &Value) -> Option<Auto<f32>> {
    match value {
        Value::String(word) if word == "auto" => Some(Auto::Auto),
        value => {
            let radius = value.as_f64()? as f32;
            let squared = radius * radius;
            (radius > 0.0 && squared.is_normal()).then_some(Auto::Value(radius))
        }
    }
}

/// Whether `max_depth` is -1 or a number of segments.
pub fn is_depth(max_depth: i64) -> bool {
    max_depth == -1 || (1..=1 << 31).contains(&max_depth)
}

/// Limits on path length from checked parameters.
pub fn limits(max_depth: i64, rr_depth: i64) -> Limits {
    Limits { max_depth: u32::try_from(max_depth).ok(), rr_depth: u32::try_from(rr_depth).unwrap_or(u32::MAX) }
}

impl ParameterSet for ProgressiveParameters {
    fn check_ranges(&self) -> Result<(), &'static str> {
        first_bad(&[
            ("alpha", self.alpha > 0.0 && self.alpha < 1.0),
            ("photons_per_pass", photon_count(&self.photons_per_pass).is_some()),
            ("initial_radius", radius(&self.initial_radius).is_some()),
            ("max_depth", is_depth(self.max_depth)),
            ("rr_depth", self.rr_depth >= 1),
            ("passes", (1..=1 << 31).contains(&self.passes)),
            ("samples_per_pixel", (1..=64).contains(&self.samples_per_pixel)),
        ])
    }
}

impl ProgressiveParameters {
    /// First gather radius, m.
    pub fn first_radius(&self) -> Option<Auto<f32>> {
        radius(&self.initial_radius)
    }

    /// Limits on path length.
    pub fn limits(&self) -> Limits {
        limits(self.max_depth, self.rr_depth)
    }

    /// The choice with every default written out; `photons_per_pass: auto` becomes a number for `pixels`.
    pub fn checked(mut self, name: &str, known: &[ParameterHelp], pixels: u64) -> CheckedMethod {
        let photons_per_pass = photons_for(&self.photons_per_pass, pixels);
        self.photons_per_pass = photons_per_pass.into();
        let (radius_rule, alpha, passes) = (self.radius_rule, self.alpha, self.passes);
        let choice = written_out(name, self, known);
        CheckedMethod { choice, radius_rule, alpha, photons_per_pass, passes }
    }
}
