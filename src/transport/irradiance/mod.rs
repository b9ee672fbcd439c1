//! Irradiance caching: irradiance on matte surfaces is found in few places and interpolated between them.
//!
//! A record holds what arrives at a place: irradiance E, the harmonic mean R of the distances to what is seen there, and how E
//! changes where the place turns or moves. Near enough places take
//!
//! ```text
//! E(x, n) = Σ wᵢ·(Eᵢ + (nᵢ × n)·∇rEᵢ + (x − xᵢ)·∇tEᵢ) / Σ wᵢ        over the records with εᵢ < a
//! εᵢ = |x − xᵢ|/Rᵢ + √(1 − n·nᵢ),   wᵢ = 1/εᵢ − 1/a
//! ```
//!
//! without the records that lie in front of x: they see what x does not. a is the largest error that the split-sphere model lets
//! interpolation have. Taking 1/a off the weight lets a record fade out where its reach ends.
//!
//! References: \[WRC88\] Ward, Rubinstein & Clear 1988, "A ray tracing solution for diffuse interreflection" (ε, the test of what lies
//! in front, the octree); \[WH92\] Ward & Heckbert 1992, "Irradiance gradients"; \[KG09\] Křivánek & Gautron 2009, "Practical global
//! illumination with irradiance caching".
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | E | `IrradianceRecord::irradiance` | W·m⁻² |
//! | ∇rE, ∇tE | `TangentGradient`, by rotation and by translation | W·m⁻²·rad⁻¹, W·m⁻³ |
//! | R | `IrradianceRecord::radius` | m |
//! | M, N | rings and sectors of `HemisphereCells` | – |

mod cache;
mod gradients;
mod hemisphere;
mod record;

pub use cache::{IrradianceCache, IrradianceQuery};
pub use gradients::TangentGradient;
pub use hemisphere::{Arrival, HemisphereCells};
pub use record::{IrradianceRecord, RadiusRange};
