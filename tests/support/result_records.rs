//! Made-up lines of results files.

use photonfarm::evaluation::{Machine, Metrics, Record, ReferenceNoise};

/// A line whose relMSE is `error`, of which `noise` is the reference's. Time spent is the budget.
pub(crate) fn record(scene: &str, label: &str, seed: u64, budget: f64, error: f64, noise: f64) -> Record {
    let reference_noise =
        ReferenceNoise { rmse: noise.sqrt(), relmse: noise, mse_left: error - noise, relmse_left: error - noise };
    Record {
        version: "1.0.0".to_owned(),
        machine: Machine { processor: "abacus".to_owned(), cores: 1 },
        threads: 1,
        scene: scene.to_owned(),
        scene_hash: format!("hash of {scene}"),
        reference_hash: format!("hash of {scene}'s picture"),
        label: label.to_owned(),
        method: label.split(':').next().unwrap_or_default().to_owned(),
        parameters: serde_json::Map::new(),
        theory_rate: -1.0,
        blind: None,
        seed,
        budget,
        passes: 10,
        cpu_seconds: budget,
        wall_seconds: budget,
        metrics: Metrics {
            rmse: error.sqrt(),
            rel_rmse: error.sqrt(),
            relmse: error,
            relmse_trimmed: 0.9 * error,
            bias: 0.01,
            bias_rgb: [0.01; 3],
            block_bias_max: 0.1,
            ssim: Some(0.9),
            flip: 0.1,
            reference_noise: Some(reference_noise),
        },
        picture: None,
        reference_picture: None,
    }
}

/// One method at one budget, a seed for each error.
pub(crate) fn with_errors(scene: &str, errors: &[f64]) -> Vec<Record> {
    errors.iter().zip(1..).map(|(error, seed)| record(scene, "sppm", seed, 10.0, *error, 0.0)).collect()
}
