//! The further layers that an EXR picture may hold: one row each in [`LAYERS`], which the API, the command line, the
//! EXR writer and the documents all read.

/// A further layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Layer {
    /// Gather radius.
    Radius,
    /// Photons accumulated.
    Photons,
    /// The share of light that the first surface seen scatters.
    Albedo,
    /// Its shading normal.
    Normal,
    /// Its distance.
    Depth,
}

/// What a layer is called and holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LayerRow {
    /// The layer.
    pub layer: Layer,
    /// What users call it.
    pub name: &'static str,
    /// Its channels in a file.
    pub channels: &'static [&'static str],
    /// What they hold, with unit.
    pub meaning: &'static str,
}

const fn row(layer: Layer, name: &'static str, channels: &'static [&'static str], meaning: &'static str) -> LayerRow {
    LayerRow { layer, name, channels, meaning }
}

/// All layers, in the order of [`Layer`].
pub const LAYERS: [LayerRow; 5] = [
    row(Layer::Radius, "radius", &["radius.Y"], "gather radius, m"),
    row(Layer::Photons, "photons", &["photons.Y"], "photons accumulated"),
    row(
        Layer::Albedo,
        "albedo",
        &["albedo.R", "albedo.G", "albedo.B"],
        "share of light that the first surface seen reflects or transmits",
    ),
    row(Layer::Normal, "normal", &["normal.X", "normal.Y", "normal.Z"], "its shading normal in world space"),
    row(Layer::Depth, "depth", &["depth.Z"], "its distance from the camera, m; 1e10 where nothing is seen"),
];

/// A layer of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureLayer {
    /// Which one.
    pub layer: Layer,
    /// The values of each of its channels: row-major, top row first, as many as the picture has pixels.
    pub channels: Vec<Vec<f32>>,
}

/// A name that no layer has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no layer \"{0}\"")]
pub struct UnknownLayer(pub String);

impl Layer {
    /// Its row of the table.
    pub fn row(self) -> &'static LayerRow {
        &LAYERS[self as usize]
    }

    /// The layers that a list names, separated by commas; each once, in the order of the table.
    pub fn parse_list(list: &str) -> Result<Vec<Self>, UnknownLayer> {
        let names = list.split(',').map(str::trim).filter(|name| !name.is_empty());
        let layer = |name: &str| {
            let row = LAYERS.iter().find(|row| row.name == name);
            row.map(|row| row.layer).ok_or_else(|| UnknownLayer(name.to_owned()))
        };
        let mut layers = names.map(layer).collect::<Result<Vec<_>, _>>()?;
        layers.sort_unstable();
        layers.dedup();
        Ok(layers)
    }

    /// The names of all layers, separated by commas.
    pub fn known() -> String {
        LAYERS.map(|row| row.name).join(", ")
    }
}
