//! Stability: for each way a method is known to fail, a small scene or a sweep built to provoke it, and what must stay true.
//!
//! docs/measured/STABILITY.md has a row for each test, with what it measured, and what it measures with the counter-measure off. Every
//! seed is fixed, so a test gives the same numbers every time; bounds are 1.5 times or more what was measured, unless a test says otherwise.

#[path = "../support/progressive.rs"]
#[expect(dead_code, reason = "scenes are written down here")]
mod progressive;
#[path = "../support/scene_text.rs"]
mod scene_text;

mod boundaries;
mod chains;
mod counter_measures;
mod noise;
mod numbers;
mod pictures;
mod specular;
mod statistics;
