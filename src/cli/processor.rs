//! Refuses processors that the program was not compiled for, before one of its instructions faults.

/// What the processor lacks of x86-64-v3 (AVX2, BMI, FMA and companions; Intel since 2013, AMD since 2015).
#[cfg(target_arch = "x86_64")]
pub(super) fn check() -> Result<(), String> {
    let processor = raw_cpuid::CpuId::new();
    let basic = processor.get_feature_info();
    let extended = processor.get_extended_feature_info();
    let amd = processor.get_extended_processor_and_feature_identifiers();
    let has = |flag: Option<bool>| flag.unwrap_or(false);
    let features = [
        ("SSE4.2", has(basic.as_ref().map(|info| info.has_sse42()))),
        ("POPCNT", has(basic.as_ref().map(|info| info.has_popcnt()))),
        ("AVX", has(basic.as_ref().map(|info| info.has_avx() && info.has_oxsave()))),
        ("F16C", has(basic.as_ref().map(|info| info.has_f16c()))),
        ("FMA", has(basic.as_ref().map(|info| info.has_fma()))),
        ("MOVBE", has(basic.as_ref().map(|info| info.has_movbe()))),
        ("AVX2", has(extended.as_ref().map(|info| info.has_avx2()))),
        ("BMI1", has(extended.as_ref().map(|info| info.has_bmi1()))),
        ("BMI2", has(extended.as_ref().map(|info| info.has_bmi2()))),
        ("LZCNT", has(amd.as_ref().map(|info| info.has_lzcnt()))),
    ];
    let missing: Vec<&str> = features.iter().filter(|(_, there)| !there).map(|(name, _)| *name).collect();
    if missing.is_empty() {
        return Ok(());
    }
    Err(format!(
        "this processor lacks {}, which x86-64-v3 includes; use a machine with a processor of 2015 or later",
        missing.join(", ")
    ))
}

/// Other architectures are compiled for their baseline.
#[cfg(not(target_arch = "x86_64"))]
pub(super) fn check() -> Result<(), String> {
    Ok(())
}
