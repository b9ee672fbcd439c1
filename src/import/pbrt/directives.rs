//! All directives of pbrt-v4, and what becomes of them.

use super::super::compatibility::Row;
use super::super::compatibility::Support::{Approximated, PassedOver, Same};

/// Directives by name.
pub(in super::super) const DIRECTIVES: &[Row] = &[
    Row::new("Accelerator", PassedOver, "it chooses how pbrt computes"),
    Row::new("ActiveTransform", Approximated, "one moment of a motion: its start, or that of `--time`"),
    Row::new(
        "AreaLightSource",
        Same,
        "`diffuse` with `L`, `filename`, `power`, `scale`, `twosided`; triangles of one mesh and different size share their power",
    ),
    Row::new("Attribute", PassedOver, "a notice tells"),
    Row::new("AttributeBegin", Same, ""),
    Row::new("AttributeEnd", Same, ""),
    Row::new(
        "Camera",
        Approximated,
        "`perspective`, `orthographic`, `spherical` with equirectangular mapping; square pixels; `realistic` is refused",
    ),
    Row::new("ColorSpace", Approximated, "linear sRGB"),
    Row::new("ConcatTransform", Same, ""),
    Row::new("CoordSysTransform", Same, ""),
    Row::new("CoordinateSystem", Same, ""),
    Row::new("Film", Approximated, "size and window; the sensor's exposure is ignored"),
    Row::new("Identity", Same, ""),
    Row::new("Import", Same, ""),
    Row::new("Include", Same, "also of `.gz`"),
    Row::new("Integrator", Approximated, "the method that is nearest"),
    Row::new(
        "LightSource",
        Approximated,
        "`point`, `distant`, `spot`, `infinite`, its image by a map of latitude and longitude; portals keep no light out; `goniometric`; `projection` by a spot",
    ),
    Row::new("LookAt", Same, ""),
    Row::new("MakeNamedMaterial", Approximated, "as `Material`"),
    Row::new("MakeNamedMedium", Approximated, "`homogeneous` without preset and emission; others are passed through"),
    Row::new(
        "Material",
        Approximated,
        "`coatedconductor` without its coat; `subsurface`, `measured`, `hair` are matte; shares above 1 count as 1",
    ),
    Row::new("MediumInterface", Same, "with `volpath`, `bdpt` and `mlt`, which become `volpath`"),
    Row::new("NamedMaterial", Same, ""),
    Row::new("ObjectBegin", Same, "a `shapegroup`; lights in it do not shine, as in pbrt"),
    Row::new("ObjectEnd", Same, ""),
    Row::new("ObjectInstance", Same, "an `instance`"),
    Row::new("Option", PassedOver, "any name and value"),
    Row::new("PixelFilter", Same, "one radius for both axes"),
    Row::new("ReverseOrientation", Same, ""),
    Row::new("Rotate", Same, ""),
    Row::new("Sampler", PassedOver, "random numbers are our own"),
    Row::new("Scale", Same, ""),
    Row::new(
        "Shape",
        Approximated,
        "cut and unevenly scaled quadrics are meshes; `loopsubdiv` is its control mesh; `curve` is left out",
    ),
    Row::new("Texture", Approximated, "`constant`, `scale`, `imagemap`, `checkerboard`; others one of their colors"),
    Row::new("Transform", Same, ""),
    Row::new("TransformBegin", Same, ""),
    Row::new("TransformEnd", Same, ""),
    Row::new("TransformTimes", Approximated, "everything stands where it is at the first keyframe, or at `--time`"),
    Row::new("Translate", Same, ""),
];
