//! The refractive indices of transparent media by name, for `dielectric`'s `int_ior` and `ext_ior`.
//!
//! Names and values are Mitsuba 3's. It looks them up without regard to case, and its defaults are `bk7` inside and
//! `air` outside.

/// `(name, index)`: the real refractive index, relative to vacuum, dimensionless. Names are lowercase.
#[rustfmt::skip] // one medium per line, grouped as gases, liquids, solids
pub(crate) const REFRACTIVE_INDICES: &[(&str, f32)] = &[
    ("vacuum", 1.0),
    ("helium", 1.000036),
    ("hydrogen", 1.000132),
    ("air", 1.000277),
    ("carbon dioxide", 1.00045),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.52045),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
];
