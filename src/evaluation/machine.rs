//! Which machine figures come from.

use serde::{Deserialize, Serialize};

/// A machine: processor-seconds of two of them cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Model of the processor.
    pub processor: String,
    /// Threads that it can run at once.
    pub cores: usize,
}

impl Machine {
    /// This one.
    pub fn here() -> Self {
        Self { processor: processor(), cores: std::thread::available_parallelism().map_or(1, usize::from) }
    }
}

#[cfg(target_arch = "x86_64")]
fn processor() -> String {
    let brand = raw_cpuid::CpuId::new().get_processor_brand_string();
    brand.map_or_else(|| "unknown x86-64".to_owned(), |brand| brand.as_str().trim().to_owned())
}

#[cfg(not(target_arch = "x86_64"))]
fn processor() -> String {
    std::env::consts::ARCH.to_owned()
}
