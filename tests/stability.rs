//! Stability: for each way a method is known to fail, a small scene or a sweep built to provoke it, and what must stay true.
//!
//! docs/STABILITY.md has a row for each test, with what it measured, and what it measures with the counter-measure off. Every
//! seed is fixed, so a test gives the same numbers every time; bounds are 1.5 times or more what was measured, unless a test says otherwise.

#[path = "stability/boundaries.rs"]
mod boundaries;
#[path = "stability/counter_measures.rs"]
mod counter_measures;
#[path = "stability/noise.rs"]
mod noise;
#[path = "stability/numbers.rs"]
mod numbers;
#[path = "stability/pictures.rs"]
mod pictures;
#[path = "support/progressive.rs"]
#[expect(dead_code, reason = "scenes are written down here")]
mod progressive;
#[path = "support/scene_text.rs"]
mod scene_text;
#[path = "stability/specular.rs"]
mod specular;
#[path = "stability/statistics.rs"]
mod statistics;
