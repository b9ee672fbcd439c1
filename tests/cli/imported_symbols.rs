//! What the program takes from the system's mathematical library: nothing that a picture hangs on.
//!
//! Another binary than the tests' own, for example the release build, is named by `PHOTONFARM_BINARY`.

use object::{Object, ObjectSymbol};

/// Functions of libm.so.6 that differ from system to system in their last bits.
const INEXACT: &[&str] = &[
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "cos", "cosh", "erf", "erfc", "exp", "exp10",
    "exp2", "expm1", "hypot", "lgamma", "log", "log10", "log1p", "log2", "pow", "sin", "sincos", "sinh", "tan", "tanh",
    "tgamma",
];

/// Those that are imported all the same, and who needs them.
const ALLOWED: &[(&str, &str)] = &[
    ("exp", "significance of evaluations"),
    ("log", "axes of charts"),
    ("log10", "axes of charts"),
    ("log2", "exposure of pictures that evaluate keeps to look at"),
    ("pow", "axes of charts, rates of surveys, progress bars"),
    ("sincos", "colors of charts"),
    ("cosf", "the crate exr, for textures compressed with DWA"),
    ("logf", "the same, its tables"),
    ("powf", "the same, and colors of charts"),
    ("exp2f", "the crate obvhs, for the grid of a tree's boxes, which are rounded outwards: no hit depends on it"),
    ("log2f", "the same"),
    ("cbrt", "color differences of evaluations"),
];

#[test]
fn the_systems_mathematical_library_decides_nothing_in_a_picture() {
    let file = std::env::var("PHOTONFARM_BINARY").unwrap_or_else(|_| env!("CARGO_BIN_EXE_photonfarm").to_owned());
    let bytes = std::fs::read(&file).expect("the program");
    let program = object::File::parse(&*bytes).expect("an object file");
    let imported: Vec<String> = program
        .dynamic_symbols()
        .filter(|symbol| symbol.is_undefined())
        .filter_map(|symbol| symbol.name().ok().map(str::to_owned))
        .collect();
    assert!(imported.len() > 50, "only {} symbols are imported: {file} is not read properly", imported.len());
    let is_inexact = |name: &str| INEXACT.iter().any(|known| name == *known || name.strip_suffix('f') == Some(*known));
    let wrong: Vec<&String> = imported
        .iter()
        .filter(|name| is_inexact(name) && !ALLOWED.iter().any(|(allowed, _)| allowed == name))
        .collect();
    assert!(wrong.is_empty(), "{file} imports {wrong:?}; use the crate libm");
}
