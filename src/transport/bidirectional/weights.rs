//! Multiple importance weights from quantities that walks carry along, so that a weight costs the same for paths of any
//! length [Georgiev 2012, "Implementing vertex connection and merging"].
//!
//! For a path that technique `t` found with density `p_t`, the weight is `1/Σ (p_k/p_t)ᵝ` over all techniques `k` that take part,
//! β = 1 for the balance heuristic and 2 for the power heuristic. The sum splits at the place where `t` joined the subpaths:
//! techniques that would have joined them further towards the light, `t` itself, and those further towards the camera. A
//! subpath carries its part of the sum with what is not known yet factored out:
//!
//! | here | [Georgiev 2012] | techniques |
//! |---|---|---|
//! | [`Sums::edge`] | d_VCM, eqs. 31, 34 | the one that would have sampled the last segment from its other end |
//! | [`Sums::join`] | d_VC, eqs. 32, 35 without merging | those before it that connect, or hit the light |
//! | [`Sums::merge`] | d_VC, eqs. 32, 35, the part of merging without η | those before it that merge |
//!
//! The acceptance η = π r² n, with n light subpaths, stays outside, so each pixel may have a radius of its own.
//! Densities leave Russian roulette out: weights add up to one whatever they are, as long as they depend on the path alone.

/// A set of techniques.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Techniques(u8);

impl Techniques {
    /// A camera subpath hits a light.
    pub const HIT: Self = Self(1);
    /// A camera subpath and a sampled point of a light.
    pub const DIRECT: Self = Self(2);
    /// Two subpaths with at least two vertices each, connected.
    pub const CONNECT: Self = Self(4);
    /// A light subpath is connected with the camera.
    pub const CAMERA: Self = Self(8);
    /// Two subpaths merged.
    pub const MERGE: Self = Self(16);
    /// Bidirectional path tracing.
    pub const ALL_CONNECTIONS: Self = Self(15);

    /// Whether some of `other` are in the set.
    #[inline]
    pub fn any(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// The set with or without `other`.
    #[must_use]
    pub fn with(self, other: Self, included: bool) -> Self {
        Self(if included { self.0 | other.0 } else { self.0 & !other.0 })
    }

    /// The numbers of vertices of the light and of the camera subpath, or of segments where they are merged, with which the set finds
    /// paths of `segments`: first those that hit or connect, then those that merge.
    pub fn strategies(self, segments: u32) -> impl Iterator<Item = [u32; 2]> {
        let technique = |pair: &[u32; 2]| match pair {
            [0, _] => Self::HIT,
            // Light that is seen directly is only hit.
            [1, 1] => Self(0),
            [1, _] => Self::DIRECT,
            [_, 1] => Self::CAMERA,
            _ => Self::CONNECT,
        };
        let connected = (0..=segments).map(move |light| [light, segments + 1 - light]);
        let merged = (1..segments).map(move |light| [light, segments - light]);
        let connected = connected.filter(move |pair| self.any(technique(pair)));
        connected.chain(merged.filter(move |_| self.any(Self::MERGE)))
    }
}

/// How densities become weights [Veach 1997, 9.2.2].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Heuristic {
    /// β = 1.
    #[default]
    Balance,
    /// β = 2.
    Power,
}

/// In which measure densities are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// By area of every vertex, with the probability of merging: the densities with which paths are found.
    Area,
    /// Products of densities by solid angle, and none for merging [Vorba 2011, eqs. 3.14, 3.15].
    SolidAngle,
}

/// Which techniques share a path, and how.
#[derive(Clone, Copy, Debug)]
pub struct Weighting {
    /// Those that take part.
    pub techniques: Techniques,
    /// How densities become weights.
    pub heuristic: Heuristic,
    /// In which measure.
    pub measure: Measure,
    /// n, light subpaths per pass.
    pub light_paths: f32,
}

/// What a subpath carries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Of the technique at the last segment.
    pub edge: f32,
    /// Of those before that need no merging.
    pub join: f32,
    /// Of those before that merge, over ηᵝ.
    pub merge: f32,
}

/// Densities by solid angle of a scattering, on the walk's way and back.
#[derive(Clone, Copy, Debug)]
pub struct Densities {
    /// Of the new direction.
    pub forward: f32,
    /// Of the old one, for a walk that comes the other way.
    pub reverse: f32,
}

impl Weighting {
    /// xᵝ.
    #[inline]
    pub fn raise(&self, x: f32) -> f32 {
        match self.heuristic {
            Heuristic::Balance => x,
            Heuristic::Power => x * x,
        }
    }

    /// (x·geometry)ᵝ: geometry converts between measures.
    #[inline]
    fn raise_by(&self, x: f32, geometry: f32) -> f32 {
        match self.measure {
            Measure::Area => self.raise(x * geometry),
            Measure::SolidAngle => self.raise(x),
        }
    }

    /// Whether only camera subpaths are made: then nothing before their last vertex matters to a weight.
    #[inline]
    pub fn is_one_ended(&self) -> bool {
        !self.techniques.any(Techniques(Techniques::CONNECT.0 | Techniques::CAMERA.0 | Techniques::MERGE.0))
    }

    #[inline]
    fn share(&self, technique: Techniques) -> f32 {
        f32::from(u8::from(self.techniques.any(technique)))
    }

    /// ηᵝ for a merging radius where photons lie as densely as those of so many light subpaths.
    #[inline]
    pub fn acceptance(&self, radius_squared: f32, paths: f32) -> f32 {
        self.raise_by(1.0, std::f32::consts::PI * radius_squared * paths)
    }

    /// At the first hit of a light subpath, where the cosine is `cosine`.
    #[inline]
    pub fn start_light(&self, first: &crate::scene::light::FirstSegment, cosine: f32) -> Sums {
        Sums {
            edge: self.share(Techniques::DIRECT) * self.raise_by(first.light_sampling, 1.0 / cosine),
            join: self.share(Techniques::HIT) * self.raise_by(first.light_hit, first.light_cosine / cosine),
            merge: 0.0,
        }
    }

    /// At the first hit of a camera subpath, whose direction has density `pdf` by solid angle, and what follows it.
    #[inline]
    pub fn start_camera(&self, pdf: f32, distance_squared: f32, cosine: f32) -> Sums {
        let edge = self.raise_by(self.light_paths / pdf, distance_squared / cosine);
        Sums { edge: self.share(Techniques::CAMERA) * edge, join: 0.0, merge: 0.0 }
    }

    /// At the end of a segment.
    #[inline]
    pub fn arrive(&self, sums: &Sums, distance_squared: f32, cosine: f32) -> Sums {
        let inverse = self.raise_by(1.0, 1.0 / cosine);
        Sums {
            edge: sums.edge * self.raise_by(1.0, distance_squared / cosine),
            join: sums.join * inverse,
            merge: sums.merge * inverse,
        }
    }

    /// After a scattering into a lobe with a density; `cosine` is the new direction's. Nothing is joined at the camera's or the
    /// light's own end any more, so the new segment is one to connect.
    #[inline]
    pub fn scatter(&self, sums: &Sums, pdf: Densities, cosine: f32) -> Sums {
        let factor = self.raise_by(1.0 / pdf.forward, cosine);
        let reverse = self.raise(pdf.reverse);
        Sums {
            edge: self.share(Techniques::CONNECT) * self.raise(1.0 / pdf.forward),
            join: factor * (sums.join * reverse + sums.edge),
            merge: factor * (sums.merge * reverse + self.share(Techniques::MERGE)),
        }
    }

    /// After a scattering into a perfectly specular lobe, where nothing can be joined. The chances of both ways are taken as
    /// equal.
    #[inline]
    pub fn scatter_specular(&self, sums: &Sums, cosine: f32) -> Sums {
        let factor = self.raise_by(1.0, cosine);
        Sums { edge: 0.0, join: factor * sums.join, merge: factor * sums.merge }
    }

    /// The part of the sum on one side of a joint, for a subpath whose other end would have been prolonged by the joint's segment
    /// with a density by solid angle and a factor that makes it one by area, and would have been scattered on with density
    /// `reverse`.
    #[inline]
    fn beyond(&self, sums: &Sums, [prolonged, geometry]: [f32; 2], reverse: f32, acceptance: f32) -> f32 {
        if self.is_one_ended() {
            return 0.0;
        }
        let merged = acceptance * self.share(Techniques::MERGE);
        self.raise_by(prolonged, geometry)
            * (merged + sums.edge + (sums.join + acceptance * sums.merge) * self.raise(reverse))
    }

    /// Weight of light sampling at a camera vertex: `pdf` of the material there, `cosine` towards the light.
    #[inline]
    pub fn direct(
        &self,
        camera: &Sums,
        pdf: Densities,
        cosine: f32,
        light: &crate::scene::light::DirectSample,
        acceptance: f32,
    ) -> f32 {
        let hit = match light.pdf_solid_angle {
            0.0 => 0.0,
            sampled => self.share(Techniques::HIT) * self.raise(pdf.forward / sampled),
        };
        1.0 / (1.0 + hit + self.beyond(camera, [light.emission_ratio, cosine], pdf.reverse, acceptance))
    }

    /// Weight of a camera subpath of more than one segment that hit a light. `sampled` is the density of light sampling and
    /// `emitted` that of emission back along the path, `scattered` that of the last direction (0 for a specular lobe).
    #[inline]
    pub fn hit(&self, sums: &Sums, scattered: f32, sampled: f32, emitted: f32, acceptance: f32) -> f32 {
        let direct = match scattered {
            0.0 => 0.0,
            scattered => self.share(Techniques::DIRECT) * self.raise(sampled / scattered),
        };
        1.0 / (1.0 + direct + self.raise(emitted) * (sums.join + acceptance * sums.merge))
    }

    /// Weight of a connection of length² `distance_squared` between two vertices, with the cosines at its ends.
    #[inline]
    pub fn connection(
        &self,
        [camera, light]: [&Sums; 2],
        [at_camera, at_light]: [Densities; 2],
        [cosine_camera, cosine_light]: [f32; 2],
        distance_squared: f32,
        acceptance: f32,
    ) -> f32 {
        let from_camera = [at_camera.forward, cosine_light / distance_squared];
        let from_light = [at_light.forward, cosine_camera / distance_squared];
        1.0 / (1.0
            + self.beyond(light, from_camera, at_light.reverse, acceptance)
            + self.beyond(camera, from_light, at_camera.reverse, acceptance))
    }

    /// Weight of a light vertex that is connected with the camera, which would have found it with density `seen` by solid angle,
    /// to be multiplied with `geometry` for one by area.
    #[inline]
    pub fn to_camera(&self, light: &Sums, [seen, geometry]: [f32; 2], reverse: f32, acceptance: f32) -> f32 {
        1.0 / (1.0 + self.beyond(light, [seen / self.light_paths, geometry], reverse, acceptance))
    }

    /// Weight of a merge at a camera vertex, with the densities there towards the light and back.
    #[inline]
    pub fn merged(&self, [camera, light]: [&Sums; 2], pdf: Densities, acceptance: f32) -> f32 {
        let side = |sums: &Sums, pdf: f32| {
            (sums.edge + sums.join * self.raise(pdf)) / acceptance + sums.merge * self.raise(pdf)
        };
        1.0 / (1.0 + side(light, pdf.forward) + side(camera, pdf.reverse))
    }
}
