//! What becomes of tallies: merged sums, their errors, pictures, files, and evaluations.

#[path = "../support/exr_channels.rs"]
mod exr_channels;
#[path = "../support/progressive.rs"]
mod progressive;
#[path = "../support/result_records.rs"]
mod result_records;
#[path = "../support/scene_text.rs"]
mod scene_text;

mod declared_planes;
mod error_estimate;
mod evaluation;
mod merge_laws;
mod metrics_against_numpy;
mod picture_bits;
mod picture_files;
mod survey;
