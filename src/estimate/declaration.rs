//! What a method's tallies hold: planes of numbers per pixel and scalars per shard, each with the rule by which it is merged.
//!
//! Wire, merge, estimate, layers and error follow the declaration. What a method does not declare is not stored and not sent.

use serde::{Deserialize, Serialize};

use super::radius::RadiusRule;

/// The plane of radiance that needs no density estimate (emission seen, sampled direct light), W·sr⁻¹·m⁻².
pub const RADIANCE: &str = "radiance";
/// The plane of un-normalised reflected flux, W·sr⁻¹.
pub const FLUX: &str = "flux";
/// The plane of photons found.
pub const PHOTONS: &str = "photons";
/// The plane of flux found inside half the disc's area, mean of the channels, W·sr⁻¹. The bias is estimated from it.
pub const INNER_FLUX: &str = "inner_flux";
/// The plane of flux, mean of the channels, times the direction from the disc's middle to where it was found, two channels, W·sr⁻¹.
/// [`evenness`](super::evenness) is told from this and the next.
pub const FLUX_SLOPE: &str = "flux_slope";
/// The plane of the squares of what photons bring, mean of the channels each, W²·sr⁻².
pub const SQUARED_FLUX: &str = "squared_flux";

/// What the name of a scalar ends in that counts proposals of chains, after their kind.
pub const PROPOSED: &str = "_proposed";
/// The same of proposals that were accepted.
pub const ACCEPTED: &str = "_accepted";
/// The scalar E: photons emitted, whether or not they were stored.
pub const PHOTONS_EMITTED: &str = "photons_emitted";
/// Photons stored in maps, for rates and memory planning.
pub const PHOTONS_STORED: &str = "photons_stored";
/// Rays traced: camera, photon and shadow rays together.
pub const RAYS: &str = "rays";
/// Contributions that were dropped because they were not finite.
pub const NON_FINITE: &str = "non_finite";

/// How a plane is merged, and what its sums are divided by to become a mean.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PlaneRule {
    /// Values are added; the mean is over passes.
    Sum,
    /// Flux that was gathered in a disc: Φ/R² is added; the mean is over π and the photons emitted.
    FluxOverRadius,
    /// The same of squared flux: Φ²/R⁴ is added; the mean is over the squares of π and the photons emitted.
    SquaredFluxOverRadius,
    /// Photons found. Not kept as a sum: they shrink the pixel's radius, where the [`RadiusRule`] follows them.
    Count,
    /// Values are added; the mean is over the sum of another plane (with one channel or as many as this one) or of a scalar. So what is
    /// known only up to a factor converges with the job. It is 0 while the denominator is 0.
    Ratio {
        /// Name of the plane or scalar.
        denominator: String,
    },
}

/// A plane: so many numbers of each pixel.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneDeclaration {
    /// Its name, which nothing else in the declaration has.
    pub name: String,
    /// Numbers per pixel. Planes hold all pixels' first channel, then all pixels' second channel, and so on.
    pub channels: usize,
    /// How it is merged.
    pub rule: PlaneRule,
    /// Whether its mean is a part of the picture's radiance; such planes have three channels.
    pub in_picture: bool,
    /// The light group whose light it holds alone. The name ends in it, after a dot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub light_group: Option<String>,
}

/// How a scalar is merged. Both kinds are added; a count must be a whole number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ScalarRule {
    /// A whole number, not negative, below 2⁵³.
    Count,
    /// Any finite number.
    Sum,
}

/// A number of a whole shard.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScalarDeclaration {
    /// Its name, which nothing else in the declaration has.
    pub name: String,
    /// How it is merged.
    pub rule: ScalarRule,
}

/// What the tallies of a checked method hold, and how radii shrink.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Declaration {
    /// The planes, in the order in which they are stored and sent.
    pub planes: Vec<PlaneDeclaration>,
    /// The scalars, in the order in which they are stored and sent.
    pub scalars: Vec<ScalarDeclaration>,
    /// How radii shrink.
    pub radius_rule: RadiusRule,
    /// α of the radius rule.
    pub alpha: f64,
}

/// A declaration that contradicts itself.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a method declares \"{name}\", but {problem}")]
pub struct DeclarationError {
    /// The plane or scalar.
    pub name: String,
    /// What is wrong.
    pub problem: &'static str,
}

impl PlaneDeclaration {
    fn new(name: &str, channels: usize, rule: PlaneRule, in_picture: bool) -> Self {
        Self { name: name.to_owned(), channels, rule, in_picture, light_group: None }
    }

    /// The same for a light group.
    fn of_light_group(&self, group: &str) -> Self {
        Self { name: format!("{}.{group}", self.name), light_group: Some(group.to_owned()), ..self.clone() }
    }

    /// Its name without the light group, for example [`FLUX`].
    pub fn kind(&self) -> &str {
        let group = self.light_group.as_ref();
        let kind = group.and_then(|group| self.name.strip_suffix(group.as_str())?.strip_suffix('.'));
        kind.unwrap_or(&self.name)
    }

    /// Whether the estimate keeps its sums. Counts only shrink radii.
    pub fn is_summed(&self) -> bool {
        self.rule != PlaneRule::Count
    }

    /// Whether its values refer to the pixel's gather disc.
    pub fn needs_radius(&self) -> bool {
        matches!(self.rule, PlaneRule::FluxOverRadius | PlaneRule::SquaredFluxOverRadius | PlaneRule::Count)
    }
}

impl Declaration {
    /// Methods that gather nothing: radiance is their only plane. The rule by which no radius shrinks sends none either.
    pub fn radiance_only() -> Self {
        Self::with_radiance(RadiusRule::Schedule, 1.0)
    }

    fn with_radiance(radius_rule: RadiusRule, alpha: f64) -> Self {
        let planes = vec![PlaneDeclaration::new(RADIANCE, 3, PlaneRule::Sum, true)];
        let count = |name: &&str| ScalarDeclaration { name: (*name).to_owned(), rule: ScalarRule::Count };
        let scalars = [PHOTONS_EMITTED, PHOTONS_STORED, RAYS, NON_FINITE].iter().map(count).collect();
        Self { planes, scalars, radius_rule, alpha }
    }

    /// Methods that gather photons in discs. They count them only where the count shrinks the radius.
    pub fn gathering(radius_rule: RadiusRule, alpha: f64) -> Self {
        let mut declaration = Self::with_radiance(radius_rule, alpha);
        let planes = &mut declaration.planes;
        planes.push(PlaneDeclaration::new(FLUX, 3, PlaneRule::FluxOverRadius, true));
        if radius_rule.follows_photons() {
            planes.push(PlaneDeclaration::new(PHOTONS, 1, PlaneRule::Count, false));
        }
        planes.push(PlaneDeclaration::new(INNER_FLUX, 1, PlaneRule::FluxOverRadius, false));
        if radius_rule == RadiusRule::Uniformity {
            planes.push(PlaneDeclaration::new(FLUX_SLOPE, 2, PlaneRule::FluxOverRadius, false));
            planes.push(PlaneDeclaration::new(SQUARED_FLUX, 1, PlaneRule::SquaredFluxOverRadius, false));
        }
        declaration
    }

    /// The same for a method of chains that makes proposals of these kinds: two scalars of each count them.
    #[must_use]
    pub fn with_proposals<'a>(mut self, kinds: impl Iterator<Item = &'a str>) -> Self {
        let counts = kinds.flat_map(|kind| [format!("{kind}{PROPOSED}"), format!("{kind}{ACCEPTED}")]);
        self.scalars.extend(counts.map(|name| ScalarDeclaration { name, rule: ScalarRule::Count }));
        self
    }

    /// The same for a job that keeps light groups apart: each plane that is a part of the picture becomes one for each group, so that the
    /// picture is their sum. Without groups nothing changes.
    #[must_use]
    pub fn with_light_groups(mut self, groups: &[String]) -> Self {
        if groups.is_empty() {
            return self;
        }
        let planes = self.planes.into_iter().flat_map(|plane| match plane.in_picture {
            true => groups.iter().map(|group| plane.of_light_group(group)).collect(),
            false => vec![plane],
        });
        self.planes = planes.collect();
        self
    }

    /// The light groups that it keeps apart.
    pub fn light_groups(&self) -> Vec<&str> {
        let mut groups: Vec<&str> = Vec::new();
        for group in self.planes.iter().filter_map(|plane| plane.light_group.as_deref()) {
            if !groups.contains(&group) {
                groups.push(group);
            }
        }
        groups
    }

    /// Indices of the planes of a kind: one plane, or one for each light group.
    pub fn planes_of_kind(&self, kind: &str) -> impl Iterator<Item = usize> {
        self.planes.iter().enumerate().filter(move |(_, plane)| plane.kind() == kind).map(|(index, _)| index)
    }

    /// The kinds of proposals that chains make.
    pub fn proposals(&self) -> impl Iterator<Item = &str> {
        self.scalars.iter().filter_map(|scalar| scalar.name.strip_suffix(PROPOSED))
    }

    /// Index of a plane.
    pub fn plane(&self, name: &str) -> Option<usize> {
        self.planes.iter().position(|plane| plane.name == name)
    }

    /// Index of a scalar.
    pub fn scalar(&self, name: &str) -> Option<usize> {
        self.scalars.iter().position(|scalar| scalar.name == name)
    }

    /// Index of the plane that shrinks radii, if there is one.
    pub fn counted(&self) -> Option<usize> {
        self.planes.iter().position(|plane| plane.rule == PlaneRule::Count)
    }

    /// Whether pixels have gather radii, so that radius fields travel.
    pub fn has_radii(&self) -> bool {
        self.planes.iter().any(PlaneDeclaration::needs_radius)
    }

    /// Whether what pixels find shrinks their radii.
    pub fn shrinks_by_count(&self) -> bool {
        self.radius_rule.follows_photons() && self.counted().is_some()
    }

    /// Checks that the declaration does not contradict itself.
    pub fn check(&self) -> Result<(), DeclarationError> {
        let wrong = |name: &str, problem| Err(DeclarationError { name: name.to_owned(), problem });
        let planes = self.planes.iter().map(|plane| &plane.name);
        let names: Vec<&String> = planes.chain(self.scalars.iter().map(|scalar| &scalar.name)).collect();
        if let Some(twice) = names.iter().enumerate().find(|(index, name)| names[..*index].contains(name)) {
            return wrong(twice.1, "another plane or scalar has the same name");
        }
        for plane in &self.planes {
            if plane.channels == 0 || (plane.in_picture && plane.channels != 3) {
                return wrong(&plane.name, "its number of channels does not fit");
            }
            if plane.needs_radius() && self.scalar(PHOTONS_EMITTED).is_none() {
                return wrong(&plane.name, "no scalar says how many photons were emitted");
            }
            if plane.rule == PlaneRule::Count && (plane.channels, plane.in_picture) != (1, false) {
                return wrong(&plane.name, "a count has one channel and is no part of the picture");
            }
            if let PlaneRule::Ratio { denominator } = &plane.rule
                && !self.divides(denominator, plane.channels)
            {
                return wrong(&plane.name, "its denominator is no scalar and no plane of sums with as many channels");
            }
        }
        if self.planes.iter().filter(|plane| plane.rule == PlaneRule::Count).count() > 1 {
            return wrong(PHOTONS, "more than one plane counts photons");
        }
        Ok(())
    }

    /// Whether `name` can be the denominator of a plane with so many channels.
    fn divides(&self, name: &str, channels: usize) -> bool {
        let fits = |plane: &PlaneDeclaration| {
            plane.rule == PlaneRule::Sum && (plane.channels == 1 || plane.channels == channels)
        };
        self.scalar(name).is_some() || self.plane(name).is_some_and(|index| fits(&self.planes[index]))
    }
}
