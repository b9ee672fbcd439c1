//! All entities of MGF, and what becomes of them.

use super::super::compatibility::Row;
use super::super::compatibility::Support::{Approximated, PassedOver, Same};

/// Entities by name.
pub(in super::super) const ENTITIES: &[Row] = &[
    Row::new("i", Same, ""),
    Row::new("ies", Same, "the luminous opening is a point"),
    Row::new("o", PassedOver, "names change nothing"),
    Row::new("xf", Same, "arrays are instances where copies would be more than 20 000 triangles"),
    Row::new("c", Same, ""),
    Row::new("cxy", Approximated, "linear Rec. 709; colors outside of it are brought back"),
    Row::new("cspec", Approximated, "its color"),
    Row::new("cct", Approximated, "its color"),
    Row::new("cmix", Same, ""),
    Row::new("m", Same, ""),
    Row::new("sides", Approximated, "the invisible back of one-sided surfaces is black"),
    Row::new("rd", Same, ""),
    Row::new("td", Same, ""),
    Row::new("ed", Same, ""),
    Row::new("rs", Same, ""),
    Row::new("ts", Approximated, "without an index straight through, without color and roughness"),
    Row::new("ir", Approximated, "does nothing on opaque surfaces that are both matte and complex"),
    Row::new("v", Same, ""),
    Row::new("p", Same, ""),
    Row::new("n", Same, ""),
    Row::new("f", Same, ""),
    Row::new("fh", Same, ""),
    Row::new("sph", Same, ""),
    Row::new("cyl", Same, ""),
    Row::new("cone", Approximated, "72 corners a circle"),
    Row::new("ring", Approximated, "72 corners a circle, but for full ones"),
    Row::new("torus", Approximated, "72 corners a circle"),
    Row::new("prism", Same, ""),
];
